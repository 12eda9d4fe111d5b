//! `[[body]]` of a case file: mesh, material, supports, loads.

use crate::case::couple::Couples;
use crate::case::document::{AXES, Entry, Node, Span, Table, Value, check_name, later, name, zero};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::mesh_file::{MeshFiles, Named};
use crate::case::outline;
use crate::case::points::{places, points};
use crate::case::suggest::{listed, nearest};
use crate::case::surface::true_surface;
use crate::geometry::Field;
use crate::mesh::{CellKind, Cuboid, Diagonals, Mesh, MeshError, Rectangle, Ring, TunnelRock};
use crate::model::{Analysis, Body, Elastic, Formulation, Load, Material, Place, Support};

/// Most cells of a generated mesh: a misplaced digit must not exhaust the memory.
const MOST_CELLS: usize = 20_000_000;

const CELLS_OF_THE_PLANE: [(&str, CellKind); 5] = [
    ("tri3", CellKind::Tri3),
    ("tri6", CellKind::Tri6),
    ("quad4", CellKind::Quad4),
    ("quad8", CellKind::Quad8),
    ("quad9", CellKind::Quad9),
];

const CELLS_OF_SPACE: [(&str, CellKind); 8] = [
    ("tet4", CellKind::Tet4),
    ("tet10", CellKind::Tet10),
    ("hex8", CellKind::Hex8),
    ("hex20", CellKind::Hex20),
    ("hex27", CellKind::Hex27),
    ("prism6", CellKind::Prism6),
    ("prism15", CellKind::Prism15),
    ("prism18", CellKind::Prism18),
];

const DIAGONALS: [(&str, Diagonals); 5] = [
    ("checkerboard", Diagonals::Checkerboard),
    ("checkerboard-odd", Diagonals::CheckerboardOdd),
    ("mirrored", Diagonals::Mirrored),
    ("forward", Diagonals::Forward),
    ("backward", Diagonals::Backward),
];

/// Meshes of D dimensions as a case file makes them.
pub(crate) trait Generated<const D: usize>: Sized {
    /// Keys of `mesh` that make one.
    const GENERATORS: &'static [&'static str];

    /// The mesh that one of these keys makes, and the points that a mesh file names.
    fn generated(entry: &Entry, body: &str, files: &mut MeshFiles) -> Result<Made<D>, Fault>;
}

/// A mesh or why there is none, and named points.
pub(crate) type Made<const D: usize> = (Result<Mesh<D>, MeshError>, Named<D>);

impl Generated<2> for Mesh<2> {
    const GENERATORS: &'static [&'static str] =
        &["rectangle", "ring", "tunnel_rock", "outline", "file"];

    fn generated(entry: &Entry, body: &str, files: &mut MeshFiles) -> Result<Made<2>, Fault> {
        let node = &entry.node;
        let built = match entry.key.as_str() {
            "file" => {
                let (mesh, named) = files.mesh(node, body)?;
                return Ok((Ok(mesh), named));
            }
            "rectangle" => rectangle(node)?.build(),
            "ring" => ring(node)?.build(),
            "tunnel_rock" => tunnel_rock(node)?.build(),
            _ => Ok(outline::mesh(node, body)?),
        };
        Ok((built, Named::new()))
    }
}

impl Generated<3> for Mesh<3> {
    const GENERATORS: &'static [&'static str] = &["box", "file"];

    fn generated(entry: &Entry, _: &str, _: &mut MeshFiles) -> Result<Made<3>, Fault> {
        match entry.key.as_str() {
            "box" => Ok((cuboid(&entry.node)?.build(), Named::new())),
            other => Err(later(&entry.key_span, &format!("a 3D mesh from `{other}`"))),
        }
    }
}

const FORMULATIONS: [(&str, Formulation); 2] = [
    ("displacement", Formulation::Displacement),
    ("enhanced", Formulation::Enhanced),
];

/// One body with everything that is written inside it.
pub(crate) fn body<const D: usize>(
    node: &Node,
    analysis: Analysis,
    files: &mut MeshFiles,
) -> Result<Body<D>, Fault>
where
    Mesh<D>: Generated<D>,
{
    let table = node.table(keys::BODY)?;
    let body_name = name(table.require("name", "a body")?)?;
    let what = format!("body `{body_name}`");
    let (mut mesh, of_file) = mesh(table.require("mesh", &what)?, &body_name, files)?;
    let points = points(table, &body_name, of_file)?;
    let (materials, thickness) = materials(table.require("material", &what)?, &body_name, &mesh)?;
    let mut couples = Couples::new(&body_name, analysis);
    for node in table.list("couple")? {
        let table = node.table(keys::COUPLE)?;
        let side = side(table.require("side", "a couple")?, &body_name, &mut mesh)?;
        couples.add(table, &side, &points)?;
    }
    let supports = table.list("fix")?.iter();
    let supports = supports.map(|node| support(node, &mut couples, &mesh, &points));
    let supports: Vec<_> = supports.collect::<Result<_, _>>()?;
    let loads = table.list("load")?.iter();
    let loads = loads.map(|node| load(node, &mut couples, &mut mesh, &points));
    let loads: Vec<_> = loads.collect::<Result<_, _>>()?;
    let body_force = table.get("body_force").map_or(Ok(zero()), Node::fields)?;
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
        mesh,
        materials,
        formulation: formulation.transpose()?.unwrap_or_default(),
        thickness,
        body_force,
        supports: supports.concat(),
        loads: loads.concat(),
        couples,
        surfaces,
        points,
    })
}

/// The mesh, and the points that a mesh file names.
fn mesh<const D: usize>(
    node: &Node,
    body: &str,
    files: &mut MeshFiles,
) -> Result<(Mesh<D>, Named<D>), Fault>
where
    Mesh<D>: Generated<D>,
{
    let table = node.table(keys::MESH)?;
    let generators: Vec<&Entry> = keys::MESH
        .iter()
        .filter(|key| **key != "sides")
        .filter_map(|key| table.entry(key))
        .collect();
    let known = || listed(Mesh::<D>::GENERATORS.iter().copied());
    let [generator] = generators[..] else {
        let message = match generators.len() {
            0 => format!("the mesh of body `{body}` has no generator"),
            _ => format!("the mesh of body `{body}` has more than one generator"),
        };
        return Err(Fault::new(table.span, message)
            .label("exactly one is needed")
            .help(format!("give exactly one of {}", known())));
    };
    if !Mesh::<D>::GENERATORS.contains(&generator.key.as_str()) {
        let other = 5 - D;
        let message = format!(
            "`{}` makes {other}D meshes, and the analysis is in {D}D",
            generator.key
        );
        return Err(Fault::new(&generator.key_span, message)
            .label(format!("a {other}D mesh"))
            .help(format!("{D}D meshes: {}", known())));
    }
    let (built, points) = Mesh::<D>::generated(generator, body, files)?;
    let invalid = |e: MeshError, span: &Span| {
        Fault::new(span, format!("the mesh of body `{body}`: {e}")).label("cannot be built")
    };
    let mut mesh = built.map_err(|e| invalid(e, &generator.key_span))?;
    for patch in table.get("sides").map_or(Ok(&[][..]), Node::entries)? {
        check_name(&patch.key, &patch.key_span)?;
        let keys = patch.node.table(keys::PATCH)?;
        if mesh.side(&patch.key).is_some() {
            let message = format!("body `{body}` has a side `{}` already", patch.key);
            return Err(Fault::new(&patch.key_span, message).label("second use of the name"));
        }
        let of = side(keys.require("of", "a patch")?, body, &mut mesh)?;
        let min = keys.require("min", "a patch")?.point()?;
        let max = keys.require("max", "a patch")?.point()?;
        mesh = mesh
            .with_patch(&patch.key, &of, min, max)
            .map_err(|e| invalid(e, &patch.key_span))?;
    }
    Ok((mesh, points))
}

fn rectangle(node: &Node) -> Result<Rectangle, Fault> {
    let table = node.table(keys::RECTANGLE)?;
    let what = "a rectangle";
    Ok(Rectangle {
        from: table.require("from", what)?.point()?,
        to: table.require("to", what)?.point()?,
        cells: cells(table, what)?,
        cell: cell(table, 2)?,
        diagonals: diagonals(table)?,
    })
}

fn ring(node: &Node) -> Result<Ring, Fault> {
    let table = node.table(keys::RING)?;
    let what = "a ring";
    let angles = match (table.entry("from"), table.entry("to")) {
        (None, None) => None,
        (Some(from), Some(to)) => Some([from.node.number()?, to.node.number()?]),
        (Some(one), None) | (None, Some(one)) => {
            return Err(
                Fault::new(&one.key_span, "a part of a ring needs both `from` and `to`")
                    .label("the other angle is missing")
                    .help("without `from` and `to` the ring is full"),
            );
        }
    };
    Ok(Ring {
        center: table.get("center").map_or(Ok([0.0; 2]), Node::point)?,
        inner: table.require("inner", what)?.positive("the inner radius")?,
        outer: table.require("outer", what)?.positive("the outer radius")?,
        angles,
        cells: cells(table, what)?,
        ratio: growth(table, "ratio")?,
        grade: growth(table, "grade")?,
        cell: cell(table, 2)?,
        diagonals: diagonals(table)?,
    })
}

fn tunnel_rock(node: &Node) -> Result<TunnelRock, Fault> {
    let table = node.table(keys::TUNNEL_ROCK)?;
    let what = "tunnel rock";
    let length = |key: &str| table.require(key, what)?.positive(&format!("`{key}`"));
    Ok(TunnelRock {
        radius: length("radius")?,
        half_width: length("half_width")?,
        half_height: length("half_height")?,
        cells: cells(table, what)?,
        ratio: growth(table, "ratio")?,
        grade: growth(table, "grade")?,
        cell: cell(table, 2)?,
        diagonals: diagonals(table)?,
    })
}

fn cuboid(node: &Node) -> Result<Cuboid, Fault> {
    let table = node.table(keys::BOX)?;
    let what = "a box";
    Ok(Cuboid {
        from: table.require("from", what)?.point()?,
        to: table.require("to", what)?.point()?,
        cells: cells(table, what)?,
        cell: cell(table, 3)?,
    })
}

fn cells<const N: usize>(table: Table<'_>, what: &str) -> Result<[usize; N], Fault> {
    let node = table.require("cells", what)?;
    let counts = node.counts("the number of cells")?;
    if counts.iter().fold(1, |n: usize, c| n.saturating_mul(*c)) > MOST_CELLS {
        let message = format!("more than {MOST_CELLS} cells in one body");
        return Err(Fault::new(&node.span, message).label("too many cells"));
    }
    Ok(counts)
}

fn growth(table: Table<'_>, key: &str) -> Result<f64, Fault> {
    let name = format!("`{key}`");
    table.get(key).map_or(Ok(1.0), |node| node.positive(&name))
}

/// A kind of cells of a dimension, of four or eight corners where none is named.
fn cell(table: Table<'_>, dimension: usize) -> Result<CellKind, Fault> {
    let [own, other] = match dimension {
        2 => [&CELLS_OF_THE_PLANE[..], &CELLS_OF_SPACE],
        _ => [&CELLS_OF_SPACE[..], &CELLS_OF_THE_PLANE],
    };
    let Some(node) = table.get("cell") else {
        return Ok(if dimension == 2 {
            CellKind::Quad4
        } else {
            CellKind::Hex8
        });
    };
    let text = node.text()?;
    if other.iter().any(|(name, _)| *name == text) {
        let message = format!("`{text}` is a cell of {}D meshes", 5 - dimension);
        let known = own.iter().map(|(name, _)| *name);
        return Err(Fault::new(&node.span, message)
            .label(format!("a {}D cell", 5 - dimension))
            .help(format!("cells of {dimension}D meshes: {}", listed(known))));
    }
    node.choice("cell", own)
}

fn diagonals(table: Table<'_>) -> Result<Diagonals, Fault> {
    let node = table.get("diagonals");
    node.map_or(Ok(Diagonals::default()), |node| {
        node.choice("pattern of diagonals", &DIAGONALS)
    })
}

/// The materials and the thickness, which they share. One without `group` is for the cells of all other groups.
fn materials<const D: usize>(
    node: &Node,
    body: &str,
    mesh: &Mesh<D>,
) -> Result<(Vec<Material>, f64), Fault> {
    let groups = groups(mesh);
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

/// Names of the groups of cells of a mesh, each once.
fn groups<const D: usize>(mesh: &Mesh<D>) -> Vec<&str> {
    let mut groups: Vec<&str> = Vec::new();
    for group in mesh
        .blocks()
        .iter()
        .filter_map(|block| block.group.as_deref())
    {
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    groups
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
    let young = table.require("young", "a material")?.positive("`young`")?;
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
    let elastic = Elastic { young, poisson };
    Ok((Material { group, elastic }, thickness))
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
fn side<const D: usize>(node: &Node, body: &str, mesh: &mut Mesh<D>) -> Result<String, Fault> {
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

/// Refuses sides that the mesh does not have, one that is listed twice, and no side at all.
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

/// One side of those of a body that are named at these places, at least one and none twice.
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
fn no_z<const D: usize>(table: Table<'_>) -> Result<(), Fault> {
    match table.entry("z") {
        Some(entry) if D == 2 => {
            let message = "plane and axisymmetric analyses have no `z`";
            Err(Fault::new(&entry.key_span, message).label("only x and y"))
        }
        _ => Ok(()),
    }
}

/// A support; on a list of sides one for each, so that a corner has the normal of either, and one at each point of a name; none
/// of the body's own at the point of a couple, which takes it over.
fn support<const D: usize>(
    node: &Node,
    couples: &mut Couples<'_, D>,
    mesh: &Mesh<D>,
    points: &Named<D>,
) -> Result<Vec<Support<D>>, Fault> {
    let table = node.table(keys::FIX)?;
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
        return Ok(Vec::new());
    }
    let each = places.into_iter().map(|place| Support {
        place,
        components: components.clone(),
        normal: normal.clone(),
    });
    Ok(each.collect())
}

/// A load; at each point of a name one; none of the body's own at the point of a couple, which takes it over.
fn load<const D: usize>(
    node: &Node,
    couples: &mut Couples<'_, D>,
    mesh: &mut Mesh<D>,
    points: &Named<D>,
) -> Result<Vec<Load<D>>, Fault> {
    let table = node.table(keys::LOAD)?;
    let body = couples.body;
    if couples.load(table)? {
        return Ok(Vec::new());
    }
    let mut present = table.present();
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
                "a load is `side` with `traction`, `pressure` or `force`, or `point` with `force`",
            ))
        }
    }
}
