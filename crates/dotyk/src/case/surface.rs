//! Planes, circles, spheres, cylinders and cones of a case file: true surfaces of sides, and rigid obstacles.

use crate::case::document::{Entry, Node, Table};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::suggest::listed;
use crate::geometry::{Surface, unit};

/// Shapes of the plane and of space.
const SHAPES: [&[&str]; 2] = [
    &["plane", "circle"],
    &["plane", "cylinder", "cone", "sphere"],
];

/// Word for a side without a true surface behind its facets.
const FACETS: &str = "facets";

/// Shapes of D dimensions.
pub(crate) fn shapes<const D: usize>() -> impl Iterator<Item = &'static str> + Clone {
    SHAPES[D - 2].iter().copied()
}

/// The true surface behind a side: `{ circle = .. }`, `{ plane = .. }` ..., or "facets" without one.
pub(crate) fn true_surface<const D: usize>(node: &Node) -> Result<Option<Surface<D>>, Fault> {
    if node.text().is_ok() {
        return node.choice("surface", &[(FACETS, None)]);
    }
    let table = node.table(keys::SURFACE)?;
    let given: Vec<&Entry> = keys::SURFACE
        .iter()
        .filter_map(|k| table.entry(k))
        .collect();
    let [entry] = given[..] else {
        return Err(Fault::new(table.span, "a surface is exactly one shape")
            .label("not exactly one")
            .help(format!(
                "give one of {}, or \"{FACETS}\" instead",
                listed(shapes::<D>())
            )));
    };
    let (surface, _) = surface(entry)?;
    match entry.node.entries()?.iter().find(|e| e.key == "inside") {
        Some(inside) => {
            let message = "a true surface has no `inside`: its side tells where the body is";
            Err(Fault::new(&inside.key_span, message)
                .label("no meaning here")
                .help("leave it out; obstacles have it"))
        }
        None => Ok(Some(surface)),
    }
}

/// A shape of D dimensions, and whether the body is inside it, if it is round.
pub(crate) fn surface<const D: usize>(entry: &Entry) -> Result<(Surface<D>, bool), Fault> {
    let (node, what) = (&entry.node, format!("a {}", entry.key));
    if !shapes::<D>().any(|shape| shape == entry.key) {
        let message = format!("`{}` is a shape of {}D analyses", entry.key, 5 - D);
        return Err(Fault::new(&entry.key_span, message)
            .label(format!("not in {D}D"))
            .help(format!("shapes in {D}D: {}", listed(shapes::<D>()))));
    }
    let round = |table: Table<'_>| {
        let radius = table.require("radius", &what)?;
        let radius = radius.positive(&format!("the radius of {what}"))?;
        let inside = table.get("inside").map_or(Ok(false), Node::boolean)?;
        Ok((radius, inside))
    };
    match entry.key.as_str() {
        "plane" => {
            let table = node.table(keys::PLANE)?;
            let point = table.require("point", &what)?.point()?;
            let normal = direction(table, "normal", &what)?;
            Ok((Surface::Plane { point, normal }, false))
        }
        "cylinder" => {
            let table = node.table(keys::CYLINDER)?;
            let point = table.require("point", &what)?.point()?;
            let axis = direction(table, "axis", &what)?;
            let (radius, inside) = round(table)?;
            let cylinder = Surface::Cylinder {
                point,
                axis,
                radius,
            };
            Ok((cylinder, inside))
        }
        "cone" => {
            let table = node.table(keys::CONE)?;
            let angle = table.require("angle", &what)?;
            let degrees = angle.positive("the angle of a cone")?;
            if degrees >= 90.0 {
                let message = "the angle of a cone is that between its axis and its surface, in degrees below 90";
                return Err(Fault::new(&angle.span, message).label("too large"));
            }
            let inside = table.get("inside").map_or(Ok(false), Node::boolean)?;
            let cone = Surface::Cone {
                apex: table.require("apex", &what)?.point()?,
                axis: direction(table, "axis", &what)?,
                half_angle: degrees.to_radians(),
            };
            Ok((cone, inside))
        }
        _ => {
            let table = node.table(keys::CIRCLE)?;
            let center = table.require("center", &what)?.point()?;
            let (radius, inside) = round(table)?;
            Ok((Surface::Sphere { center, radius }, inside))
        }
    }
}

/// A vector of length 1.
pub(crate) fn direction<const D: usize>(
    table: Table<'_>,
    key: &str,
    what: &str,
) -> Result<[f64; D], Fault> {
    let node = table.require(key, what)?;
    let given: [f64; D] = node.point()?;
    // of any length: squares of numbers like 1e200 are none
    let largest = given.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    unit(given.map(|c| c / largest)).ok_or_else(|| {
        Fault::new(&node.span, format!("the {key} of {what} is zero")).label("no direction")
    })
}
