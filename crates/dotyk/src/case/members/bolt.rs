//! `[[bolt]]` of a case file: bodies that are cut across and drawn together there.

use crate::case::document::{Node, Table};
use crate::case::error::Fault;
use crate::case::members::end;
use crate::case::points::{named_body, place};
use crate::case::steps::Steps;
use crate::geometry::{Point, padded, unit};
use crate::mesh::{Mesh, MeshError};
use crate::model::{Body, BodyId, Bolt, Line, MemberEnd, SideRef};
use std::sync::Arc;

pub(crate) const KEYS: &[&str] = &[
    "name",
    "body",
    "at",
    "axis",
    "from",
    "to",
    "prestress",
    "tightened",
    "shortening",
];

/// How it is tightened; its axis is that of the cut.
pub(crate) fn read(table: Table<'_>, _: &str, steps: &Steps) -> Result<Bolt, Fault> {
    let course = |key: &str| table.get(key).map(Node::course).transpose();
    let tightened = table.get("tightened").map(|node| steps.times_of(node));
    Ok(Bolt {
        axis: None,
        prestress: course("prestress")?,
        tightened: tightened.transpose()?,
        shortening: course("shortening")?,
    })
}

/// The axis of a bolt, if it is given.
pub(crate) fn axis<const D: usize>(table: Table<'_>) -> Result<Option<[f64; 3]>, Fault> {
    let Some(node) = table.get("axis") else {
        return Ok(None);
    };
    let axis: Point<D> = node.point()?;
    match unit(axis) {
        Some(_) => Ok(Some(padded(axis))),
        None => Err(Fault::new(&node.span, "the axis has no direction").label("not a direction")),
    }
}

/// The two sides of its cut: those that are named, or those of a body that is cut here.
pub(crate) fn line<const D: usize>(
    table: Table<'_>,
    (name, what): (&str, &str),
    bodies: &mut [Body<D>],
) -> Result<Line<D>, Fault> {
    let Some(entry) = table.entry("body") else {
        if let Some(entry) = table.entry("at") {
            let message = format!("`at` is where a `body` is cut, and {what} names none");
            return Err(Fault::new(&entry.key_span, message).label("in which body?"));
        }
        if table.entry("from").is_none() && table.entry("to").is_none() {
            let message = format!("{what} does not say where it is");
            let help = "add `body`, `at` and `axis`: the body is cut there; or `from` and `to`, the two sides of a cut in its mesh";
            return Err(Fault::new(table.span, message)
                .label("`body` is missing")
                .help(help));
        }
        let of = |key: &str, bodies: &mut [Body<D>]| {
            end(table.require(key, what)?, "the end of a bolt", bodies)
        };
        let ends = [of("from", bodies)?, of("to", bodies)?];
        return Ok(Line::new(ends, &[]));
    };
    for key in ["from", "to"] {
        if let Some(entry) = table.entry(key) {
            let message = format!("{what} cuts a body: its sides are those of the cut");
            return Err(Fault::new(&entry.key_span, message).label("superfluous"));
        }
    }
    let text = entry.node.text()?;
    let of = named_body(text, &entry.node.span, bodies)?;
    let node = table.require("at", what)?;
    let at = place(node, bodies)?;
    let across = table.require("axis", what)?.point()?;
    let mesh = &bodies[of].mesh;
    let facets = mesh.across(at, across);
    if facets.is_empty() {
        let message = format!("the cut of {what} misses the cells of body `{text}`");
        return Err(Fault::new(&node.span, message)
            .label("no cells on both sides of it")
            .help("`at` is a point of the shank, with at least one layer of cells before and behind it along `axis`"));
    }
    let sides = ["behind", "ahead"].map(|end| format!("{name}-{end}"));
    let cut = Mesh::clone(mesh).slit(&facets, sides.each_ref().map(String::as_str));
    let cut = cut.map_err(|error| {
        let help = match error {
            MeshError::CutEnds { .. } => {
                "put `at` where the plane across `axis` cuts the shank alone"
            }
            _ => "choose another name",
        };
        Fault::new(&node.span, format!("{what}: {error}"))
            .label("cut here")
            .help(help)
    })?;
    bodies[of].mesh = Arc::new(cut);
    let side = |side: &String| {
        MemberEnd::Side(SideRef {
            body: BodyId(of),
            side: side.clone(),
        })
    };
    Ok(Line::new(sides.each_ref().map(side), &[]))
}
