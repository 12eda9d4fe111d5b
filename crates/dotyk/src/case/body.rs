//! `[[body]]` of a case file: mesh, material, supports, loads.

use crate::case::couple::Couples;
use crate::case::cyclic::cyclic;
use crate::case::document::{AXES, Node, Span, Table, Value, later, name, zero};
use crate::case::error::Fault;
use crate::case::initial::initial;
use crate::case::keys;
use crate::case::mesh::{Generated, mesh};
use crate::case::mesh_file::{MeshFiles, Named};
use crate::case::points::{places, points};
use crate::case::spring::springs as springs_of;
use crate::case::steps::Steps;
use crate::case::strength::{plastic, strength};
use crate::case::suggest::{listed, nearest};
use crate::case::surface::true_surface;
use crate::geometry::Field;
use crate::mesh::Mesh;
use crate::model::{
    Active, Ages, Analysis, Body, Elastic, Formulation, Initial, Load, Material, Place, Support,
};

const FORMULATIONS: [(&str, Formulation); 2] = [
    ("displacement", Formulation::Displacement),
    ("enhanced", Formulation::Enhanced),
];

/// One body with everything that is written inside it.
pub(crate) fn body<const D: usize>(
    node: &Node,
    analysis: Analysis,
    files: &mut MeshFiles,
    steps: &Steps,
) -> Result<Body<D>, Fault>
where
    Mesh<D>: Generated<D>,
{
    let table = node.table(keys::BODY)?;
    let body_name = name(table.require("name", "a body")?)?;
    let what = format!("body `{body_name}`");
    let of = table.require("mesh", &what)?;
    let needed = format!("the analysis is in {D}D");
    let (mut mesh, of_file) = mesh(of, &body_name, &needed, files)?;
    let points = points(table, &body_name, of_file)?;
    let (materials, thickness) = materials(table.require("material", &what)?, &body_name, &mesh)?;
    let initial = initial::<D>(table, analysis)?;
    let (active, release) = steps.active_body(table)?;
    let mut couples = Couples::new(&body_name, analysis);
    for node in table.list("couple")? {
        let table = node.table(keys::COUPLE)?;
        let side = side(table.require("side", "a couple")?, &body_name, &mut mesh)?;
        couples.add(table, &side, &points)?;
    }
    let supports = table.list("fix")?.iter();
    let supports = supports.map(|node| support(node, &mut couples, &mesh, &points, steps));
    let supports: Vec<_> = supports.collect::<Result<_, _>>()?;
    let springs = table.list("spring")?.iter();
    let springs = springs.map(|node| springs_of(node, &mut couples, &mut mesh, &points, steps));
    let springs: Vec<_> = springs.collect::<Result<_, _>>()?;
    let loads = table.list("load")?.iter();
    let loads = loads.map(|node| {
        let active = steps.active(node.table(keys::LOAD)?)?;
        let loads = load(node, &mut couples, &mut mesh, &points, (&initial, active))?;
        Ok(loads
            .into_iter()
            .map(|load| load.during(active))
            .collect::<Vec<_>>())
    });
    let loads: Vec<_> = loads.collect::<Result<_, _>>()?;
    let body_force = table.get("body_force").map_or(Ok(zero()), Node::fields)?;
    let sector = table.get("cyclic");
    let sector = sector.map(|node| cyclic(node, &body_name, &mut mesh, analysis));
    let cyclic = sector.transpose()?;
    let surfaces = table.get("surface").map_or(Ok(&[][..]), Node::entries)?;
    let surfaces = surfaces.iter().map(|entry| {
        known_side(&entry.key, &entry.key_span, &body_name, &mesh)?;
        Ok((entry.key.clone(), true_surface(&entry.node)?))
    });
    let surfaces = surfaces.collect::<Result<_, _>>()?;
    let couples = couples.list;
    let formulation = table.get("formulation");
    let formulation = formulation.map(|node| node.choice("formulation", &FORMULATIONS));
    Ok(Body {
        name: body_name,
        mesh: mesh.into(),
        materials,
        formulation: formulation.transpose()?.unwrap_or_default(),
        thickness,
        body_force,
        initial,
        active,
        release,
        supports: supports.concat(),
        springs: springs.concat(),
        loads: loads.concat(),
        couples,
        cyclic,
        surfaces,
        points,
    })
}

/// The materials and the thickness, which they share. One without `group` is for the cells of all other groups.
fn materials<const D: usize>(
    node: &Node,
    body: &str,
    mesh: &Mesh<D>,
) -> Result<(Vec<Material>, f64), Fault> {
    let groups = mesh.groups();
    let (mut materials, thickness) = match &node.value {
        Value::List(list) => list_of_materials(node, list, body, &groups)?,
        _ => {
            let (material, thickness) = material(node, body, &groups)?;
            (vec![material], thickness)
        }
    };
    let without = |group: &&str| !materials.iter().any(|m| m.group.as_deref() == Some(*group));
    let rest: Vec<&str> = groups.iter().copied().filter(without).collect();
    let loose = mesh.blocks().iter().any(|block| block.group.is_none());
    let common = materials.iter().any(|m| m.group.is_none());
    if !common && (loose || !rest.is_empty()) {
        let cells = match rest.len() {
            0 => "its cells of no group".to_string(),
            _ => format!("its cells of {}", listed(rest)),
        };
        let message = format!("body `{body}` has no material for {cells}");
        return Err(Fault::new(&node.span, message)
            .label("a material is missing")
            .help("a material without `group` is for all cells that have no other"));
    }
    // The first that fits is taken.
    materials.sort_by_key(|material| material.group.is_none());
    Ok((materials, thickness))
}

fn list_of_materials(
    node: &Node,
    list: &[Node],
    body: &str,
    groups: &[&str],
) -> Result<(Vec<Material>, f64), Fault> {
    let mut materials: Vec<Material> = Vec::new();
    let mut common = None;
    for node in list {
        let (material, thickness) = material(node, body, groups)?;
        if *common.get_or_insert(thickness) != thickness {
            let message = format!("the materials of body `{body}` differ in thickness");
            return Err(Fault::new(&node.span, message).label("one thickness for the whole body"));
        }
        if materials.iter().any(|m| m.group == material.group) {
            let message = format!("body `{body}` has two materials for the same cells");
            return Err(Fault::new(&node.span, message).label("same `group` as above"));
        }
        materials.push(material);
    }
    let Some(thickness) = common else {
        let message = format!("the list of materials of body `{body}` is empty");
        return Err(Fault::new(&node.span, message).label("empty"));
    };
    Ok((materials, thickness))
}

fn material(node: &Node, body: &str, groups: &[&str]) -> Result<(Material, f64), Fault> {
    let table = node.table(keys::MATERIAL)?;
    let group = table.get("group").map(name).transpose()?;
    let (young, ages) = young(table.require("young", "a material")?)?;
    let poisson_node = table.require("poisson", "a material")?;
    let poisson = poisson_node.number()?;
    let thickness = table.get("thickness");
    let thickness = thickness.map_or(Ok(1.0), |node| node.positive("`thickness`"))?;
    if poisson == 0.5 {
        let message = "`poisson` = 0.5: incompressible materials are not supported";
        return Err(Fault::new(&poisson_node.span, message)
            .label("incompressible")
            .help("use a value in (-1, 0.5), such as 0.49"));
    }
    if !(poisson > -1.0 && poisson < 0.5) {
        let message = format!("`poisson` must lie between -1 and 0.5, found {poisson}");
        return Err(Fault::new(&poisson_node.span, message).label("not in (-1, 0.5)"));
    }
    if let (Some(group), Some(node)) = (&group, table.get("group")) {
        known_group(group, &node.span, body, groups)?;
    }
    let strength = table.get("strength").map(strength).transpose()?;
    let material = Material {
        group,
        elastic: Elastic { young, poisson },
        ages,
        plastic: plastic(table, strength.as_ref())?,
        strength,
    };
    Ok((material, thickness))
}

/// Young's modulus, and how it changes with time; what it is at the last load step is known later.
fn young(node: &Node) -> Result<(f64, Option<Ages>), Fault> {
    let young = node.course()?;
    match young.as_constant() {
        Some(_) => Ok((node.positive("`young`")?, None)),
        None => Ok((
            f64::NAN,
            Some(Ages {
                young,
                last: f64::NAN,
            }),
        )),
    }
}

/// Refuses a group of cells that the mesh does not have.
fn known_group(group: &str, span: &Span, body: &str, groups: &[&str]) -> Result<(), Fault> {
    if groups.contains(&group) {
        return Ok(());
    }
    let message = format!("body `{body}` has no group of cells `{group}`");
    let fault = Fault::new(span, message);
    Err(match nearest(group, groups.iter().copied()) {
        Some(near) => fault
            .label(format!("the nearest known group is `{near}`"))
            .help(format!("its groups: {}", listed(groups.iter().copied()))),
        None => fault
            .label("no such group")
            .help("its mesh has no groups: give one material without `group`"),
    })
}

/// The name of a side that the mesh has; a list of sides becomes one.
pub(crate) fn side<const D: usize>(
    node: &Node,
    body: &str,
    mesh: &mut Mesh<D>,
) -> Result<String, Fault> {
    joined(&sides(node)?, &node.span, body, mesh)
}

/// One name or a list of names, each with its place.
fn sides(node: &Node) -> Result<Vec<(String, Span)>, Fault> {
    let one = |node: &Node| Ok((node.text()?.to_string(), node.span.clone()));
    match &node.value {
        Value::List(list) => list.iter().map(one).collect(),
        _ => Ok(vec![one(node)?]),
    }
}

/// Refuses sides that the mesh does not have, a side listed twice, and an empty list.
fn check_sides<const D: usize>(
    sides: &[(String, Span)],
    span: &Span,
    body: &str,
    mesh: &Mesh<D>,
) -> Result<(), Fault> {
    if sides.is_empty() {
        return Err(Fault::new(span, "the list of sides is empty").label("no side"));
    }
    for (k, (side, span)) in sides.iter().enumerate() {
        known_side(side, span, body, mesh)?;
        if sides[..k].iter().any(|(before, _)| before == side) {
            let message = format!("the side `{side}` is listed twice");
            return Err(Fault::new(span, message).label("second time"));
        }
    }
    Ok(())
}

/// Joins the sides of a body named at these places into one; at least one name, and no name twice.
pub(crate) fn joined<const D: usize>(
    sides: &[(String, Span)],
    span: &Span,
    body: &str,
    mesh: &mut Mesh<D>,
) -> Result<String, Fault> {
    check_sides(sides, span, body, mesh)?;
    let names: Vec<&str> = sides.iter().map(|(side, _)| side.as_str()).collect();
    let joined = mesh.join_sides(&names);
    joined.map_err(|error| Fault::new(span, error.to_string()))
}

/// Refuses a side that the mesh does not have.
pub(crate) fn known_side<const D: usize>(
    text: &str,
    span: &Span,
    body: &str,
    mesh: &Mesh<D>,
) -> Result<(), Fault> {
    if mesh.side(text).is_some() {
        return Ok(());
    }
    let fault = Fault::new(span, format!("body `{body}` has no side `{text}`"));
    let sides: Vec<&str> = mesh.side_names().collect();
    let words = ["the nearest known side", "its sides"];
    Err(fault.nearest(text, words, sides.into_iter()))
}

/// Refuses a component along z, which plane analyses do not have.
pub(crate) fn no_z<const D: usize>(table: Table<'_>) -> Result<(), Fault> {
    match table.entry("z") {
        Some(entry) if D == 2 => {
            let message = "plane and axisymmetric analyses have no `z`";
            Err(Fault::new(&entry.key_span, message).label("only x and y"))
        }
        _ => Ok(()),
    }
}

/// A support: one for each of a list of sides, so that a corner has the normals of both, and one at each point of a name. At the point
/// of a couple it becomes part of the couple.
fn support<const D: usize>(
    node: &Node,
    couples: &mut Couples<'_, D>,
    mesh: &Mesh<D>,
    points: &Named<D>,
    steps: &Steps,
) -> Result<Vec<Support<D>>, Fault> {
    let table = node.table(keys::FIX)?;
    let active = steps.active(table)?;
    let body = couples.body;
    no_z::<D>(table)?;
    let places: Vec<Place<D>> = match (table.get("side"), table.get("point")) {
        (Some(node), None) => {
            let sides = sides(node)?;
            check_sides(&sides, &node.span, body, mesh)?;
            let places = sides.into_iter().map(|(side, _)| Place::Side(side));
            places.collect()
        }
        (None, Some(node)) => {
            let places = places(node, body, points)?;
            places.into_iter().map(Place::Point).collect()
        }
        (Some(_), Some(node)) => {
            let message = format!("a support of body `{body}` has both `side` and `point`");
            return Err(Fault::new(&node.span, message).label("give one of the two"));
        }
        (None, None) => {
            let message = format!("a support of body `{body}` needs `side` or `point`");
            return Err(Fault::new(table.span, message).label("neither `side` nor `point`"));
        }
    };
    let field = |key: &str| table.get(key).map(Node::field).transpose();
    let mut components: [Option<Field>; D] = std::array::from_fn(|_| None);
    for (component, axis) in components.iter_mut().zip(AXES) {
        *component = field(axis)?;
    }
    let normal = field("normal")?;
    let nothing = components.iter().all(Option::is_none) && normal.is_none();
    if nothing && table.entry("rotation").is_none() {
        let message = format!("a support of body `{body}` prescribes nothing");
        return Err(Fault::new(table.span, message)
            .label("no component")
            .help(format!(
                "add {} or `normal`, such as `x = 0.0`",
                listed(AXES[..D].iter().copied())
            )));
    }
    if let ([Place::Point(_), ..], Some(node)) = (&places[..], table.get("normal")) {
        let message = "a point has no normal";
        return Err(Fault::new(&node.span, message)
            .label("only with `side`")
            .help(format!("use {}", listed(AXES[..D].iter().copied()))));
    }
    if couples.hold(table)? {
        return match table.entry("active") {
            Some(entry) => Err(later(
                &entry.key_span,
                "`active` of a support of a coupled point",
            )),
            None => Ok(Vec::new()),
        };
    }
    let each = places.into_iter().map(|place| Support {
        place,
        components: components.clone(),
        normal: normal.clone(),
        active,
    });
    Ok(each.collect())
}

/// A load: one at each point of a name. At the point of a couple it becomes part of the couple.
fn load<const D: usize>(
    node: &Node,
    couples: &mut Couples<'_, D>,
    mesh: &mut Mesh<D>,
    points: &Named<D>,
    (initial, active): (&Initial, Active),
) -> Result<Vec<Load<D>>, Fault> {
    let table = node.table(keys::LOAD)?;
    let body = couples.body;
    if couples.load(table, active)? {
        return Ok(Vec::new());
    }
    let mut present = table.present();
    present.retain(|key| *key != "active");
    present.sort_unstable();
    match present[..] {
        ["side", "traction"] => Ok(vec![Load::Traction {
            side: side(table.require("side", "a load")?, body, mesh)?,
            traction: table.require("traction", "a load")?.fields()?,
        }]),
        ["pressure", "side"] => Ok(vec![Load::Pressure {
            side: side(table.require("side", "a load")?, body, mesh)?,
            pressure: table.require("pressure", "a load")?.field()?,
        }]),
        ["in_situ", "side"] => {
            let factor = table.require("in_situ", "a load")?;
            let Some(stress) = initial.stress.clone() else {
                let message = format!("`in_situ` without an `initial_stress` of body `{body}`");
                return Err(Fault::new(&factor.span, message)
                    .label("a part of which stress?")
                    .help("give the body an `initial_stress`, such as { vertical = \"-27e3*(80 - y)\", k0 = 0.6 }"));
            };
            Ok(vec![Load::InSitu {
                side: side(table.require("side", "a load")?, body, mesh)?,
                factor: factor.field()?,
                stress: stress.into(),
            }])
        }
        ["force", "side"] => Ok(vec![Load::Resultant {
            side: side(table.require("side", "a load")?, body, mesh)?,
            force: table.require("force", "a load")?.courses()?,
        }]),
        ["force", "point"] => {
            let force: [Field; D] = table.require("force", "a load")?.fields()?;
            let places = places(table.require("point", "a load")?, body, points)?;
            let each = places.into_iter().map(|point| Load::Force {
                point,
                force: force.clone(),
            });
            Ok(each.collect())
        }
        _ => {
            let keys = match present.len() {
                0 => "none".to_string(),
                _ => listed(table.present()),
            };
            let message = format!("a load of body `{body}` with the keys {keys}");
            Err(Fault::new(table.span, message).label("not a load").help(
                "a load is `side` with `traction`, `pressure`, `force` or `in_situ`, or `point` with `force`",
            ))
        }
    }
}
