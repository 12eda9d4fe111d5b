//! Nodes of two sides that lie on each other in pairs, and what supports hold at both of a pair.

use crate::geometry::{Point, add_scaled, distance, dot, norm};
use crate::mesh::Mesh;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Nodes lie on each other within this part of a facet.
pub(crate) const SAME: f64 = 1e-4;

/// Directions are held if supports hold all of them but this part.
const HELD: f64 = 1e-9;

/// The nodes of a side, each with its place.
pub(crate) fn placed<const D: usize>(mesh: &Mesh<D>, side: &str) -> Vec<(usize, Point<D>)> {
    let nodes = mesh.side_nodes(side).unwrap_or_default().into_iter();
    let place = |node| (node as usize, mesh.points()[node as usize]);
    nodes.map(place).collect()
}

/// The size of the largest facet of a side, a length.
pub(crate) fn largest_facet<const D: usize>(mesh: &Mesh<D>, side: &str) -> f64 {
    let facets = mesh.side(side).unwrap_or_default().iter();
    facets.fold(0.0, |most: f64, facet| most.max(mesh.facet_length(*facet)))
}

/// For each node of a set the nearest one of another set that lies within a distance, if there is one.
pub(crate) fn partners<const D: usize>(
    [own, other]: [&[(usize, Point<D>)]; 2],
    within: f64,
) -> Vec<Option<usize>> {
    let others = other.iter();
    let others = others.map(|&(node, place)| GeomWithData::new(place, node));
    let tree = RTree::bulk_load(others.collect());
    let partner = |&(_, place): &(usize, Point<D>)| {
        let near = tree.nearest_neighbor(place)?;
        (distance(*near.geom(), place) <= within).then_some(near.data)
    };
    own.iter().map(partner).collect()
}

/// The nodes of two sets in pairs, one of each, that lie within a distance of each other.
///
/// Errors: the place of a node that has no partner, or one of several.
pub(crate) fn coincident<const D: usize>(
    [own, other]: [&[(usize, Point<D>)]; 2],
    within: f64,
) -> Result<Vec<[usize; 2]>, Point<D>> {
    let found = partners([own, other], within).into_iter();
    let pair = |(partner, &(node, place)): (Option<usize>, &(usize, Point<D>))| {
        partner.map(|partner| [node, partner]).ok_or(place)
    };
    let pairs = found.zip(own).map(pair);
    let pairs = pairs.collect::<Result<Vec<_>, Point<D>>>()?;
    let mut met: Vec<usize> = pairs.iter().map(|pair| pair[1]).collect();
    met.sort_unstable();
    met.dedup();
    let unmet = |(node, _): &&(usize, Point<D>)| met.binary_search(node).is_err();
    match other.iter().find(unmet) {
        Some(&(_, place)) => Err(place),
        None if met.len() != pairs.len() => Err(own[0].1),
        None => Ok(pairs),
    }
}

/// Whether unit vectors at right angles to each other span a direction.
pub(crate) fn spans<const D: usize>(
    held: impl Iterator<Item = Point<D>>,
    direction: Point<D>,
) -> bool {
    let rest = held.fold(direction, |rest, axis| {
        add_scaled(rest, -dot(direction, axis), axis)
    });
    norm(rest) <= HELD
}
