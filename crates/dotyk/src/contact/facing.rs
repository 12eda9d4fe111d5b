//! Which parts of two sides face each other although their nodes do not coincide.
//!
//! A facet sees the other side when the line from one of its points along its outward normal meets a facet there whose
//! outward normal is opposed. Node-to-node pairing is right where no facet with a node of its own sees the other side.

use crate::contact::node_to_node::matching_nodes;
use crate::contact::search::{Line, Search};
use crate::contact::{ContactError, End};
use crate::geometry::{Point, add_scaled, sub, unit};
use crate::mesh::{Facet, Mesh};
use std::collections::BTreeSet;

/// A node without a partner on a facet that faces the other side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unmatched<const D: usize> {
    /// It belongs to the mortar side.
    pub of_mortar: bool,
    /// The node.
    pub node: usize,
    /// Its position.
    pub point: Point<D>,
    /// Distance of the nearest node of the other side.
    pub distance: f64,
}

/// The first facet that faces the other side and has a node without a partner; `None` when node-to-node pairing leaves
/// nothing out, be it that all nodes there coincide or that the sides do not face each other.
///
/// Errors: unknown or empty sides.
pub fn unmatched_facing<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
) -> Result<Option<Unmatched<D>>, ContactError> {
    for (own, other, of_mortar) in [(nonmortar, mortar, false), (mortar, nonmortar, true)] {
        let matches = matching_nodes(own, other)?;
        let mesh = &own.body.mesh;
        let search = Search::new(mesh, &other.body.mesh, other.facets()?);
        for &facet in own.facets()? {
            let lonely = mesh
                .facet_nodes(facet)
                .map(|node| node as usize)
                .find(|node| matches[node].0.is_none());
            if let Some(node) = lonely
                && sees(mesh, facet, &search)
            {
                return Ok(Some(Unmatched {
                    of_mortar,
                    node,
                    point: mesh.points()[node],
                    distance: matches[&node].1,
                }));
            }
        }
    }
    Ok(None)
}

/// Whether facets that face each other have the same nodes: else coincident nodes bear different parts of a pressure on the
/// two sides (a quadratic facet over two linear ones, triangles over squares), and node-to-node pairing does not pass a uniform
/// one.
///
/// Errors: unknown or empty sides.
pub fn facets_coincide<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
) -> Result<bool, ContactError> {
    let (mesh, other) = (&nonmortar.body.mesh, &mortar.body.mesh);
    let matches = matching_nodes(nonmortar, mortar)?;
    let opposite = mortar.facets()?;
    let search = Search::new(mesh, other, opposite);
    let nodes_of = |mesh: &Mesh<D>, facet: Facet| -> BTreeSet<usize> {
        mesh.facet_nodes(facet).map(|node| node as usize).collect()
    };
    let known: BTreeSet<BTreeSet<usize>> = opposite
        .iter()
        .map(|&facet| nodes_of(other, facet))
        .collect();
    let own = nonmortar.facets()?.iter();
    Ok(own.copied().all(|facet| {
        let partners = nodes_of(mesh, facet).into_iter();
        let partners: Option<BTreeSet<usize>> = partners.map(|node| matches[&node].0).collect();
        partners.is_none_or(|nodes| known.contains(&nodes) || !sees(mesh, facet, &search))
    }))
}

/// Lines start at the middle of a facet and so far from it towards its corners.
const STARTS: [f64; 3] = [0.0, 0.5, 0.9];

fn sees<const D: usize>(mesh: &Mesh<D>, facet: Facet, search: &Search<'_, D>) -> bool {
    let shallow = mesh.facet_length(facet);
    let kind = mesh.facet_kind(facet);
    let (corners, centre) = (kind.corners(), kind.domain().centre());
    let starts = STARTS.iter().flat_map(|part| {
        let towards = kind.reference_nodes()[..corners].iter();
        towards.map(move |corner| add_scaled(centre, *part, sub(*corner, centre)))
    });
    starts.into_iter().any(|xi| {
        let start = mesh.facet_point(facet, &xi);
        let direction = unit(mesh.outward_normal(facet, &xi));
        direction.is_some_and(|direction| {
            let line = Line { start, direction };
            search.opposite(line, shallow).is_some()
        })
    })
}
