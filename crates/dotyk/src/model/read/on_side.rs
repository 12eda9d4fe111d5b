//! The state of a contact at each node of the facets of its side.
//!
//! A node at a sharp corner has a state for each of its faces, and a facet takes the one whose normal fits its own. A node with
//! states against a near and a far surface takes the one with the larger force. In space only the corners of facets carry
//! multipliers: for each of their facets, nodes between corners have values linear between the corners, and the status of the
//! corner with the largest force. So they agree with the multipliers, and a loaded node is not called open.

use crate::geometry::{Point, add_scaled, dot, unit};
use crate::mesh::{Facet, Mesh};
use crate::model::nouns::solution::{ContactNode, ContactSolution, Status};
use std::collections::BTreeMap;

/// The side of a contact, with its states.
pub(crate) struct OnSide<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    facets: &'a [Facet],
    states: BTreeMap<usize, Vec<&'a ContactNode<D>>>,
}

/// A node between corners, as one of its facets has it.
pub(crate) struct Between<'a, const D: usize> {
    /// Index in the mesh.
    pub node: usize,
    /// Outward unit normal of the facet there.
    pub normal: Point<D>,
    /// States of the corners and their parts.
    corners: Vec<(&'a ContactNode<D>, f64)>,
}

impl<'a, const D: usize> OnSide<'a, D> {
    /// The nonmortar side of a contact, whose body has this mesh.
    pub fn new(mesh: &'a Mesh<D>, contact: &'a ContactSolution<D>) -> Self {
        let mut states: BTreeMap<usize, Vec<&ContactNode<D>>> = BTreeMap::new();
        for node in &contact.nodes {
            states.entry(node.node).or_default().push(node);
        }
        Self {
            mesh,
            facets: mesh.side(&contact.nonmortar.side).unwrap_or_default(),
            states,
        }
    }

    /// The state of a node on a facet with this normal; `None` where it has none of its own.
    pub fn state(&self, node: usize, normal: Point<D>) -> Option<&'a ContactNode<D>> {
        let states = self.states.get(&node)?.iter().copied();
        let fits = fitting(states.clone(), normal, |state| state.normal)?;
        let fit = |state: &&ContactNode<D>| dot(state.normal, normal);
        let least = fit(&fits) - ALIKE;
        states
            .filter(|state| fit(state) >= least)
            .reduce(bearing_most)
    }

    /// The nodes between corners without a state of their own, once for each of their facets. In the plane, where all nodes of a side
    /// carry multipliers, there are no such nodes; nor beside corners without a state.
    pub fn between(&self) -> impl Iterator<Item = Between<'a, D>> {
        let facets = if D == 2 { &[] } else { self.facets };
        facets.iter().flat_map(|&facet| self.between_on(facet))
    }

    fn between_on(&self, facet: Facet) -> impl Iterator<Item = Between<'a, D>> {
        let kind = self.mesh.facet_kind(facet);
        let nodes: Vec<usize> = self.mesh.facet_nodes(facet).map(|n| n as usize).collect();
        let normal = move |local: usize| {
            let normal = self
                .mesh
                .outward_normal(facet, &kind.reference_nodes()[local]);
            unit(normal).unwrap_or([0.0; D])
        };
        kind.between_corners().filter_map(move |(local, parts)| {
            let corner = |(corner, part): (usize, f64)| {
                Some((self.state(nodes[corner], normal(corner))?, part))
            };
            let corners: Option<Vec<_>> = parts.into_iter().map(corner).collect();
            let own = self.states.contains_key(&nodes[local]);
            Some(Between {
                node: nodes[local],
                normal: normal(local),
                corners: corners.filter(|_| !own)?,
            })
        })
    }
}

impl<const D: usize> Between<'_, D> {
    /// The linear interpolation between the corners.
    pub fn mean(&self, value: impl Fn(&ContactNode<D>) -> f64) -> f64 {
        self.corners
            .iter()
            .map(|(node, part)| part * value(node))
            .sum()
    }

    /// The same of a vector.
    pub fn mean_vector(&self, value: impl Fn(&ContactNode<D>) -> Point<D>) -> Point<D> {
        let corners = self.corners.iter();
        corners.fold([0.0; D], |sum, (node, part)| {
            add_scaled(sum, *part, value(node))
        })
    }

    /// The status of the corner with the largest force.
    pub fn status(&self) -> Option<Status> {
        let corners = self.corners.iter().map(|(node, _)| *node);
        corners.reduce(bearing_most).map(|node| node.status)
    }
}

/// Normals whose cosines to that of a facet differ by less than this fit it alike.
const ALIKE: f64 = 1e-6;

/// That of two states that bears more; of equal ones the first.
fn bearing_most<'a, const D: usize>(
    a: &'a ContactNode<D>,
    b: &'a ContactNode<D>,
) -> &'a ContactNode<D> {
    let bears = |node: &ContactNode<D>| match node.pressure.is_nan() {
        true => 0.0,
        false => node.pressure,
    };
    if bears(b) > bears(a) { b } else { a }
}

/// The item whose normal fits a normal best; of equal ones the first.
pub(crate) fn fitting<T, const D: usize>(
    several: impl IntoIterator<Item = T>,
    normal: Point<D>,
    own: impl Fn(&T) -> Point<D>,
) -> Option<T> {
    let fit = |one: &T| dot(own(one), normal);
    let several = several.into_iter();
    several.reduce(|a, b| if fit(&b) > fit(&a) { b } else { a })
}
