//! Sides with sharp corners, in space edges, taken apart: a corner has a normal, and a condition, for each of its faces.
//!
//! One condition along the mean of two normals would let the corner of a block slide through the floor of the pocket that
//! it sits in, as soon as it leaves the wall.

use crate::contact::{ContactError, End};
use crate::geometry::{Point, dot, unit};
use crate::mesh::Facet;
use std::collections::BTreeMap;

/// Facets whose normals have a cosine below this meet at a corner: each keeps its own normal there.
pub(super) const SHARP: f64 = 0.7;

/// The parts of a side between its sharp corners or edges, in the order of its chain, in space of their first facets; the whole
/// where it has none.
///
/// Errors: unknown or empty sides.
pub fn smooth_parts<const D: usize>(end: End<'_, D>) -> Result<Vec<Vec<Facet>>, ContactError> {
    let (mesh, side) = (&end.body.mesh, end.facets()?);
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
        for (place, &(a, normal)) in meeting.iter().enumerate() {
            for &(b, other) in &meeting[place + 1..] {
                match dot(normal, other) > SHARP {
                    true => join(&mut part, a, b),
                    false => sharp = true,
                }
            }
        }
    }
    if !sharp {
        return Ok(vec![side.to_vec()]);
    }
    let mut parts: BTreeMap<usize, Vec<Facet>> = BTreeMap::new();
    for (index, &facet) in side.iter().enumerate() {
        let first = root(&part, index);
        parts.entry(first).or_default().push(facet);
    }
    let mut parts: Vec<Vec<Facet>> = parts.into_values().collect();
    if let Some(plane) = mesh.in_plane() {
        let chains = plane.chain(end.side).unwrap_or_default();
        let along = chains.iter().flat_map(|chain| &chain.facets).enumerate();
        let place: BTreeMap<Facet, usize> = along.map(|(place, &facet)| (facet, place)).collect();
        let first = |part: &Vec<Facet>| part.iter().filter_map(|facet| place.get(facet)).min();
        parts.sort_by_key(|part| first(part).copied());
    }
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
