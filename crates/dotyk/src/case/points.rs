//! Points with a name: the key `points` of a body, and names in place of coordinates.

use crate::case::document::{Node, Span, Table, Value, check_name, coordinates};
use crate::case::error::Fault;
use crate::case::mesh_file::Named;
use crate::geometry::Point;
use crate::mesh::Mesh;
use crate::model::{Body, Place};

/// The points that a mesh file names, and those of the key `points`.
pub(crate) fn points<const D: usize>(
    table: Table<'_>,
    body: &str,
    of_file: Named<D>,
) -> Result<Named<D>, Fault> {
    let mut points = of_file;
    for entry in table.get("points").map_or(Ok(&[][..]), Node::entries)? {
        check_name(&entry.key, &entry.key_span)?;
        let given = vec![entry.node.point()?];
        if points.insert(entry.key.clone(), given).is_some() {
            let message = format!(
                "the mesh file of body `{body}` has a group of points `{}` already",
                entry.key
            );
            return Err(Fault::new(&entry.key_span, message).label("second use of the name"));
        }
    }
    Ok(points)
}

/// Coordinates, or those of the points of a name.
pub(crate) fn places<const D: usize>(
    node: &Node,
    body: &str,
    points: &Named<D>,
) -> Result<Vec<Point<D>>, Fault> {
    match &node.value {
        Value::Text(name) => match points.get(name) {
            Some(places) => Ok(places.clone()),
            None => Err(unknown(name, &node.span, body, points)),
        },
        _ => Ok(vec![node.point()?]),
    }
}

fn unknown<const D: usize>(name: &str, span: &Span, body: &str, points: &Named<D>) -> Fault {
    let fault = Fault::new(span, format!("body `{body}` has no point `{name}`"));
    if points.is_empty() {
        return fault
            .label("no such point")
            .help(format!(
                "it has no named points: write `points = {{ NAME = {} }}` in the body, or the coordinates here",
                coordinates::<D>()
            ));
    }
    let names = points.keys().map(String::as_str);
    fault.nearest(name, ["the nearest known point", "its points"], names)
}

/// Coordinates, or those of the one point that a "BODY.NAME" names.
pub(crate) fn place<const D: usize>(node: &Node, bodies: &[Body<D>]) -> Result<Point<D>, Fault> {
    if !matches!(node.value, Value::Text(_)) {
        return node.point();
    }
    let (body, name) = of_body(
        node,
        bodies,
        ["a point", "\"BODY.NAME\", such as \"block.tip\""],
    )?;
    let Body {
        name: owner,
        points,
        ..
    } = &bodies[body];
    match points.get(name).map(Vec::as_slice) {
        Some([point]) => Ok(*point),
        Some(several) => {
            let message = format!("`{name}` of body `{owner}` are {} points", several.len());
            Err(Fault::new(&node.span, message)
                .label("one is needed")
                .help("give a group of points of its own to the one that is meant, or write its coordinates"))
        }
        None => Err(unknown(name, &node.span, owner, points)),
    }
}

/// The body and the second word of a "BODY.WORD"; `what` is its kind and notation.
pub(crate) fn of_body<'n, const D: usize>(
    node: &'n Node,
    bodies: &[Body<D>],
    [what, written]: [&str; 2],
) -> Result<(usize, &'n str), Fault> {
    let text = node.text()?;
    let Some((body, word)) = text.split_once('.') else {
        return Err(Fault::new(&node.span, format!("`{text}` is not {what}"))
            .label("no dot")
            .help(format!("{what} is written {written}")));
    };
    Ok((named_body(body, &node.span, bodies)?, word))
}

/// The body of a name that stands at a place.
pub(crate) fn named_body<const D: usize>(
    name: &str,
    span: &Span,
    bodies: &[Body<D>],
) -> Result<usize, Fault> {
    let found = bodies.iter().position(|body| body.name == name);
    found.ok_or_else(|| {
        let names = bodies.iter().map(|body| body.name.as_str());
        let fault = Fault::new(span, format!("there is no body `{name}`"));
        fault.nearest(name, ["the nearest known body", "bodies"], names)
    })
}

/// The side or the points of a body with this name; empty without either.
pub(crate) fn named_places<const D: usize>(
    name: &str,
    mesh: &Mesh<D>,
    points: &Named<D>,
) -> Vec<Place<D>> {
    let side = mesh.side(name).map(|_| Place::Side(name.to_string()));
    let points = points.get(name).into_iter().flatten();
    side.into_iter()
        .chain(points.map(|&point| Place::Point(point)))
        .collect()
}
