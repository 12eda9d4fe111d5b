//! `[[body]]` of a case file: mesh, material, supports, loads.

use crate::case::couple::Couples;
use crate::case::document::{Entry, Node, Span, Table, Value, check_name, later, name, zero};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::mesh_file::{MeshFiles, Named};
use crate::case::outline;
use crate::case::points::{places, points};
use crate::case::suggest::{listed, nearest};
use crate::case::surface::true_surface;
use crate::geometry::Field;
use crate::mesh::{CellKind, Diagonals, Mesh, MeshError, Rectangle, Ring, TunnelRock};
use crate::model::{Analysis, Body, Elastic, Load, Material, Place, Support};

/// Most cells of a generated mesh: a misplaced digit must not exhaust the memory.
const MOST_CELLS: usize = 20_000_000;

const CELLS_OF_THE_PLANE: [(&str, CellKind); 5] = [
    ("tri3", CellKind::Tri3),
    ("tri6", CellKind::Tri6),
    ("quad4", CellKind::Quad4),
    ("quad8", CellKind::Quad8),
    ("quad9", CellKind::Quad9),
];

const CELLS_OF_SPACE: [&str; 5] = ["tet4", "tet10", "hex8", "hex20", "hex27"];

const DIAGONALS: [(&str, Diagonals); 5] = [
    ("checkerboard", Diagonals::Checkerboard),
    ("checkerboard-odd", Diagonals::CheckerboardOdd),
    ("mirrored", Diagonals::Mirrored),
    ("forward", Diagonals::Forward),
    ("backward", Diagonals::Backward),
];

/// One body with everything that is written inside it.
pub(crate) fn body(
    node: &Node,
    analysis: Analysis,
    files: &mut MeshFiles,
) -> Result<Body<2>, Fault> {
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
    Ok(Body {
        name: body_name,
        mesh,
        materials,
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
fn mesh(node: &Node, body: &str, files: &mut MeshFiles) -> Result<(Mesh<2>, Named), Fault> {
    let table = node.table(keys::MESH)?;
    let generators: Vec<&Entry> = keys::MESH
        .iter()
        .filter(|key| **key != "sides")
        .filter_map(|key| table.entry(key))
        .collect();
    let [generator] = generators[..] else {
        let message = match generators.len() {
            0 => format!("the mesh of body `{body}` has no generator"),
            _ => format!("the mesh of body `{body}` has more than one generator"),
        };
        let known = keys::MESH.iter().copied().filter(|key| *key != "sides");
        return Err(Fault::new(table.span, message)
            .label("exactly one is needed")
            .help(format!("give exactly one of {}", listed(known))));
    };
    let mut points = Named::new();
    let built = match generator.key.as_str() {
        "file" => {
            let (mesh, named) = files.mesh(&generator.node, body)?;
            points = named;
            Ok(mesh)
        }
        "rectangle" => rectangle(&generator.node)?.build(),
        "ring" => ring(&generator.node)?.build(),
        "tunnel_rock" => tunnel_rock(&generator.node)?.build(),
        "outline" => Ok(outline::mesh(&generator.node, body)?),
        other => {
            return Err(later(
                &generator.key_span,
                &format!("a mesh from `{other}`"),
            ));
        }
    };
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
        cell: cell(table)?,
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
        cell: cell(table)?,
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
        cell: cell(table)?,
        diagonals: diagonals(table)?,
    })
}

fn cells(table: Table<'_>, what: &str) -> Result<[usize; 2], Fault> {
    let node = table.require("cells", what)?;
    let [a, b] = node.counts("the number of cells")?;
    if a.saturating_mul(b) > MOST_CELLS {
        let message = format!("more than {MOST_CELLS} cells in one body");
        return Err(Fault::new(&node.span, message).label("too many cells"));
    }
    Ok([a, b])
}

fn growth(table: Table<'_>, key: &str) -> Result<f64, Fault> {
    let name = format!("`{key}`");
    table.get(key).map_or(Ok(1.0), |node| node.positive(&name))
}

fn cell(table: Table<'_>) -> Result<CellKind, Fault> {
    let Some(node) = table.get("cell") else {
        return Ok(CellKind::Quad4);
    };
    if CELLS_OF_SPACE.contains(&node.text()?) {
        let message = format!("`{}` is a cell of 3D meshes", node.text()?);
        let known = CELLS_OF_THE_PLANE.iter().map(|(name, _)| *name);
        return Err(Fault::new(&node.span, message)
            .label("a 3D cell")
            .help(format!("cells of the plane: {}", listed(known))));
    }
    node.choice("cell", &CELLS_OF_THE_PLANE)
}

fn diagonals(table: Table<'_>) -> Result<Diagonals, Fault> {
    let node = table.get("diagonals");
    node.map_or(Ok(Diagonals::default()), |node| {
        node.choice("pattern of diagonals", &DIAGONALS)
    })
}

/// The materials and the thickness, which they share. One without `group` is for the cells of all other groups.
fn materials(node: &Node, body: &str, mesh: &Mesh<2>) -> Result<(Vec<Material>, f64), Fault> {
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
fn groups(mesh: &Mesh<2>) -> Vec<&str> {
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
fn side(node: &Node, body: &str, mesh: &mut Mesh<2>) -> Result<String, Fault> {
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
fn check_sides(
    sides: &[(String, Span)],
    span: &Span,
    body: &str,
    mesh: &Mesh<2>,
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
pub(crate) fn joined(
    sides: &[(String, Span)],
    span: &Span,
    body: &str,
    mesh: &mut Mesh<2>,
) -> Result<String, Fault> {
    check_sides(sides, span, body, mesh)?;
    let names: Vec<&str> = sides.iter().map(|(side, _)| side.as_str()).collect();
    let joined = mesh.join_sides(&names);
    joined.map_err(|error| Fault::new(span, error.to_string()))
}

/// Refuses a side that the mesh does not have.
pub(crate) fn known_side(text: &str, span: &Span, body: &str, mesh: &Mesh<2>) -> Result<(), Fault> {
    if mesh.side(text).is_some() {
        return Ok(());
    }
    let fault = Fault::new(span, format!("body `{body}` has no side `{text}`"));
    let sides: Vec<&str> = mesh.side_names().collect();
    let words = ["the nearest known side", "its sides"];
    Err(fault.nearest(text, words, sides.into_iter()))
}

/// Refuses a component along z, which plane analyses do not have.
fn no_z(table: Table<'_>) -> Result<(), Fault> {
    table.entry("z").map_or(Ok(()), |entry| {
        Err(Fault::new(
            &entry.key_span,
            "plane and axisymmetric analyses have no `z`",
        )
        .label("only x and y"))
    })
}

/// A support; on a list of sides one for each, so that a corner has the normal of either, and one at each point of a name; none
/// of the body's own at the point of a couple, which takes it over.
fn support(
    node: &Node,
    couples: &mut Couples<'_>,
    mesh: &Mesh<2>,
    points: &Named,
) -> Result<Vec<Support<2>>, Fault> {
    let table = node.table(keys::FIX)?;
    let body = couples.body;
    no_z(table)?;
    let places: Vec<Place<2>> = match (table.get("side"), table.get("point")) {
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
    let components: [Option<Field>; 2] = [field("x")?, field("y")?];
    let normal = field("normal")?;
    let nothing = components.iter().all(Option::is_none) && normal.is_none();
    if nothing && table.entry("rotation").is_none() {
        let message = format!("a support of body `{body}` prescribes nothing");
        return Err(Fault::new(table.span, message)
            .label("no component")
            .help("add `x`, `y` or `normal`, such as `x = 0.0`"));
    }
    if let ([Place::Point(_), ..], Some(node)) = (&places[..], table.get("normal")) {
        let message = "a point has no normal";
        return Err(Fault::new(&node.span, message)
            .label("only with `side`")
            .help("use `x` and `y`"));
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
fn load(
    node: &Node,
    couples: &mut Couples<'_>,
    mesh: &mut Mesh<2>,
    points: &Named,
) -> Result<Vec<Load<2>>, Fault> {
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
            let force: [Field; 2] = table.require("force", "a load")?.fields()?;
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
