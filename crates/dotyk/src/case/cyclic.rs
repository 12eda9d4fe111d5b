//! `cyclic` of a body: the sector that it is.

use crate::case::body::side;
use crate::case::document::{Node, coordinates};
use crate::case::error::Fault;
use crate::case::keys;
use crate::geometry::{Point, unit};
use crate::mesh::{Facet, Mesh};
use crate::model::{Analysis, Cyclic};
use std::collections::BTreeSet;

/// The cyclic symmetry of a body.
pub(crate) fn cyclic<const D: usize>(
    node: &Node,
    body: &str,
    mesh: &mut Mesh<D>,
    analysis: Analysis,
) -> Result<Cyclic<D>, Fault> {
    let table = node.table(keys::CYCLIC)?;
    if analysis == Analysis::Axisymmetric {
        let message =
            format!("`cyclic` of body `{body}`: with axial symmetry a body is a full turn");
        return Err(Fault::new(&node.span, message).label("not a sector"));
    }
    let what = format!("`cyclic` of body `{body}`");
    let number = table.require("sectors", &what)?;
    let sectors = number.positive_integer("`sectors`")?;
    if sectors < 2 {
        let message = "`sectors` is the number of sectors of the full turn, 2 or more";
        return Err(Fault::new(&number.span, message).label("not a sector"));
    }
    let (one, other) = (table.require("from", &what)?, table.require("to", &what)?);
    let [from, to] = [side(one, body, mesh)?, side(other, body, mesh)?];
    let facets = |side: &str| mesh.side(side).unwrap_or_default().iter();
    let first: BTreeSet<&Facet> = facets(&from).collect();
    if facets(&to).any(|facet| first.contains(facet)) {
        let message = format!("the faces `from` and `to` of body `{body}` share facets");
        return Err(Fault::new(&other.span, message)
            .label("the same facets")
            .help("a sector is bounded by two faces: one comes to the other by a turn"));
    }
    let point = table.get("point").map(Node::point).transpose()?;
    let axis = match (table.entry("axis"), D) {
        (None, 2) => [0.0, 0.0, 1.0],
        (Some(entry), 2) => {
            let message = "`axis` is a direction in space, in the plane it is that across it";
            return Err(Fault::new(&entry.key_span, message).label("superfluous"));
        }
        (None, _) => {
            return Err(Fault::new(&node.span, format!("{what} has no axis"))
                .label("`axis` is missing")
                .help(format!(
                    "add `axis = {}`, its direction",
                    coordinates::<D>()
                )));
        }
        (Some(entry), _) => {
            let axis: Point<3> = entry.node.point()?;
            unit(axis).ok_or_else(|| {
                Fault::new(&entry.node.span, "the axis has no direction").label("not a direction")
            })?
        }
    };
    Ok(Cyclic {
        from,
        to,
        sectors,
        point: point.unwrap_or([0.0; D]),
        axis,
    })
}
