//! Sides with sharp corners, taken apart: a corner has a normal, and a condition, for each of its two faces.
//!
//! One condition along the mean of two normals would let the corner of a block slide through the floor of the pocket that
//! it sits in, as soon as it leaves the wall.

use crate::contact::node_to_node::facets;
use crate::contact::normals::SHARP;
use crate::contact::{ContactError, End};
use crate::geometry::{Point, dot, unit};
use crate::mesh::Facet;
use std::collections::BTreeMap;

/// The parts of a side between its sharp corners, in the order of its chain; the whole where it has none.
///
/// Errors: unknown or empty sides.
pub fn smooth_parts<const D: usize>(end: End<'_, D>) -> Result<Vec<Vec<Facet>>, ContactError> {
    let (mesh, side) = (&end.body.mesh, facets(end)?);
    let mut around: BTreeMap<usize, Vec<(usize, Point<D>)>> = BTreeMap::new();
    for (index, &facet) in side.iter().enumerate() {
        let kind = mesh.facet_kind(facet);
        for (node, xi) in mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
            let normal = unit(mesh.outward_normal(facet, xi)).unwrap_or([0.0; D]);
            around
                .entry(node as usize)
                .or_default()
                .push((index, normal));
        }
    }
    let mut part: Vec<usize> = (0..side.len()).collect();
    let mut sharp = false;
    for meeting in around.values() {
        let pairs = meeting.iter().zip(&meeting[1..]);
        for (&(a, normal), &(b, other)) in pairs {
            match dot(normal, other) > SHARP {
                true => join(&mut part, a, b),
                false => sharp = true,
            }
        }
    }
    if D != 2 || !sharp {
        return Ok(vec![side.to_vec()]);
    }
    let mut parts: BTreeMap<usize, Vec<Facet>> = BTreeMap::new();
    for (index, &facet) in side.iter().enumerate() {
        let first = root(&part, index);
        parts.entry(first).or_default().push(facet);
    }
    let chains = mesh.chain(end.side).unwrap_or_default();
    let along = chains.iter().flat_map(|chain| &chain.facets).enumerate();
    let place: BTreeMap<Facet, usize> = along.map(|(place, &facet)| (facet, place)).collect();
    let first = |part: &Vec<Facet>| part.iter().filter_map(|facet| place.get(facet)).min();
    let mut parts: Vec<Vec<Facet>> = parts.into_values().collect();
    parts.sort_by_key(|part| first(part).copied());
    Ok(parts)
}

/// The first facet of a part.
fn root(part: &[usize], mut index: usize) -> usize {
    while part[index] != index {
        index = part[index];
    }
    index
}

fn join(part: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(part, a), root(part, b));
    part[a.max(b)] = a.min(b);
}
