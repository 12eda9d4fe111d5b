//! Contacts of sectors: where one reaches a face of a sector it goes on in the sector beside it.
//!
//! So bodies that touch there are sectors of the same whole, and their faces lie on each other.

use crate::contact::opposite::{Found, Opposite};
use crate::contact::{Against, ContactError, End, InitialGap};
use crate::fem::{Cyclic, show};
use crate::geometry::{distance, dot, padded, sub, unit};
use std::collections::BTreeSet;

/// Faces lie on each other if shape functions of nodes beside them are smaller there.
const BESIDE: f64 = 0.05;

/// Two axes are the same if their directions, and their distance in parts of the bodies, differ by less.
const SAME_AXIS: f64 = 1e-6;

/// Errors: sectors of different wholes; a contact that reaches a face of a sector, and opposite no sector, or not its face.
pub(crate) fn check_sectors<const D: usize>(ends: [End<'_, D>; 2]) -> Result<(), ContactError> {
    let names = || ends.map(|end| end.body.name.clone());
    let size = ends.map(|end| end.body.mesh.diameter());
    match ends.map(|end| end.body.cyclic.as_ref()) {
        [None, None] => return Ok(()),
        [Some(one), Some(other)] if !same_whole(one, other, size[0].max(size[1])) => {
            return Err(ContactError::Wholes { bodies: names() });
        }
        _ => {}
    }
    faces_meet(ends)?;
    faces_meet([ends[1], ends[0]])
}

/// Whether two symmetries are that of one whole.
fn same_whole<const D: usize>(one: &Cyclic<D>, other: &Cyclic<D>, size: f64) -> bool {
    let [Some(axis), Some(second)] = [one.axis, other.axis].map(unit) else {
        return false;
    };
    let between = padded(sub(other.point, one.point));
    let along = dot(between, axis);
    let off = distance(between, axis.map(|a| along * a));
    one.sectors == other.sectors
        && 1.0 - dot(axis, second).abs() <= SAME_AXIS * SAME_AXIS
        && off <= SAME_AXIS * size
}

/// The nodes of the two faces of a sector; none of a body that is none.
fn faces<const D: usize>(end: End<'_, D>) -> [BTreeSet<usize>; 2] {
    let sides = end.body.cyclic.as_ref().map(|c| [&c.from, &c.to]);
    let nodes = |side: &String| {
        let nodes = end.body.mesh.side_nodes(side).unwrap_or_default();
        nodes.into_iter().map(|node| node as usize).collect()
    };
    sides.map_or_else(Default::default, |sides| sides.map(nodes))
}

/// Errors: a node of the first side on a face of its sector, and opposite to it a place that is on no face of the second.
fn faces_meet<const D: usize>([own, other]: [End<'_, D>; 2]) -> Result<(), ContactError> {
    let ends = faces(own);
    let theirs = faces(other);
    if ends.iter().all(BTreeSet::is_empty) {
        return Ok(());
    }
    let on_a_face = |found: &Found| {
        theirs.iter().any(|face| {
            let beside = found.nodes.iter().filter(|(node, _)| !face.contains(node));
            beside.map(|(_, n)| n.abs()).sum::<f64>() <= BESIDE
        })
    };
    let mesh = &own.body.mesh;
    let opposite = Opposite::new(own, Against::Side(other), InitialGap::Measured, 0.0)?;
    for &facet in own.facets()? {
        let places = mesh.facet_kind(facet).reference_nodes();
        for (node, xi) in mesh.facet_nodes(facet).zip(places) {
            let node = node as usize;
            if ends.iter().all(|face| !face.contains(&node)) {
                continue;
            }
            let found = opposite.at(facet, xi)?;
            if found.is_some_and(|found| !on_a_face(&found)) {
                return Err(ContactError::Sectors {
                    sides: [own, other].map(|end| end.name()),
                    bodies: [own, other].map(|end| end.body.name.clone()),
                    point: show(mesh.points()[node]),
                    advice: match &other.body.cyclic {
                        Some(_) => "cut both at the same places",
                        None => {
                            "give it `cyclic`, too, with the same axis and number of sectors, and the part of it that lies in this sector"
                        }
                    },
                });
            }
        }
    }
    Ok(())
}
