//! Planes and circles of a case file: true surfaces of sides, and rigid obstacles.

use crate::case::document::{Entry, Node, later};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::suggest::listed;
use crate::geometry::{Surface, unit};

/// Surfaces of solids: known, and refused for now.
const OF_SPACE: [&str; 2] = ["cylinder", "sphere"];

/// The true surface behind a side: `{ circle = .. }` or `{ plane = .. }`.
pub(crate) fn true_surface(node: &Node) -> Result<Surface<2>, Fault> {
    let table = node.table(keys::SURFACE)?;
    table.refuse_later(&OF_SPACE)?;
    let given: Vec<&Entry> = keys::SURFACE
        .iter()
        .filter_map(|k| table.entry(k))
        .collect();
    let [entry] = given[..] else {
        return Err(Fault::new(table.span, "a surface is exactly one shape")
            .label("not exactly one")
            .help(format!(
                "give one of {}",
                listed(keys::SURFACE.iter().copied())
            )));
    };
    Ok(surface(entry)?.0)
}

/// A plane or a circle, and whether the body is inside the circle.
pub(crate) fn surface(entry: &Entry) -> Result<(Surface<2>, bool), Fault> {
    match entry.key.as_str() {
        "plane" => {
            let table = entry.node.table(keys::PLANE)?;
            let point = table.require("point", "a plane")?.point()?;
            let direction = table.require("normal", "a plane")?;
            let normal = unit(direction.point()?).ok_or_else(|| {
                Fault::new(&direction.span, "the normal of a plane is zero").label("no direction")
            })?;
            Ok((Surface::Plane { point, normal }, false))
        }
        "circle" => {
            let table = entry.node.table(keys::CIRCLE)?;
            let center = table.require("center", "a circle")?.point()?;
            let radius = table.require("radius", "a circle")?;
            let radius = radius.positive("the radius of a circle")?;
            let inside = table.get("inside").map_or(Ok(false), Node::boolean)?;
            Ok((Surface::Sphere { center, radius }, inside))
        }
        other => Err(later(&entry.key_span, &format!("`{other}`"))),
    }
}
