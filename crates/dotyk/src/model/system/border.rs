//! Contacts on the border of a sector: where they meet one face of it they meet the other, and both places are one of the whole.
//!
//! The tie of the faces makes the conditions at both the same, so that their forces could be divided in any way. There is one multiplier
//! of the weight of both, whose row is the mean of both rows:
//!
//! ```text
//!   (w₁ + w₂) row = w₁ row₁ + w₂ row₂,      p = λ/(w₁ + w₂) at both
//! ```
//!
//! with the directions at the second turned as its place is.

use crate::contact::Role;
use crate::fem::{Body, Turn};
use crate::geometry::{Point, distance, dot};
use crate::model::nouns::model::Model;
use crate::model::nouns::solution::ContactSolution;
use crate::model::system::coincident::{SAME, largest_facet};
use crate::model::system::condition::{Condition, Twin};
use crate::model::system::cyclic::turn;
use std::collections::BTreeSet;

/// Normals of one place, of which either face sees its own facets, have at least this cosine of their angle after the turn.
const ALIKE: f64 = 0.9;

/// Joins the nodes of contacts that are one place of the whole.
pub(crate) fn join_borders<const D: usize>(model: &Model<D>, conditions: &mut [Condition<D>]) {
    for condition in conditions {
        let body = &model.bodies[condition.nonmortar.body.0];
        if condition.contact().is_none() {
            continue;
        }
        let Some(cyclic) = &body.cyclic else { continue };
        // faces that differ were refused before
        let Ok(turn) = turn(body, cyclic, model.analysis) else {
            continue;
        };
        let pairs = twins(body, [&cyclic.from, &cyclic.to], condition, &turn);
        let frame = |place: usize| condition.interface.nodes[place].frame;
        let joined: Vec<([usize; 2], [Point<D>; D])> = pairs
            .iter()
            .map(|&pair| (pair, frame(pair[0]).map(|axis| turn.vector(axis))))
            .collect();
        condition.interface.join(&joined);
        let found = pairs.into_iter().map(|places| Twin { places, turn });
        condition.touch.twins = found.collect();
    }
}

/// The places of nodes on the first face, each with that of the node on the second face which it comes to.
fn twins<const D: usize>(
    body: &Body<D>,
    faces: [&String; 2],
    condition: &Condition<D>,
    turn: &Turn<D>,
) -> Vec<[usize; 2]> {
    let nodes = &condition.interface.nodes;
    let on = |face: &String| -> Vec<usize> {
        let of_face = body.mesh.side_nodes(face).unwrap_or_default().into_iter();
        let of_face: BTreeSet<usize> = of_face.map(|node| node as usize).collect();
        let carries = |place: &usize| {
            let node = &nodes[*place];
            node.role == Role::Multiplier && node.rows[0].is_some() && of_face.contains(&node.node)
        };
        (0..nodes.len()).filter(carries).collect()
    };
    let [from, to] = faces.map(on);
    let within = SAME * largest_facet(&body.mesh, faces[1]);
    let place = |of: usize| body.mesh.points()[nodes[of].node];
    let is_twin = |first: usize, second: usize| {
        first != second
            && distance(turn.place(place(first)), place(second)) <= within
            && dot(turn.vector(nodes[first].normal()), nodes[second].normal()) >= ALIKE
            // where supports hold one of them otherwise than the other they are not alike
            && nodes[first].rows.map(|row| row.is_some())
                == nodes[second].rows.map(|row| row.is_some())
    };
    let mut free: BTreeSet<usize> = to.into_iter().collect();
    let mut pairs = Vec::new();
    for first in from {
        let twin = free.iter().copied().find(|&second| is_twin(first, second));
        if let Some(second) = twin {
            free.remove(&second);
            pairs.push([first, second]);
        }
    }
    pairs
}

impl<const D: usize> Condition<D> {
    /// The part of the weight of a node in its contact that is not that of a twin.
    pub fn untwinned(&self, place: usize) -> f64 {
        let mut twins = self.touch.twins.iter();
        twins
            .find(|twin| twin.places[0] == place)
            .map_or(1.0, |twin| {
                let other = &self.interface.nodes[twin.places[1]];
                1.0 - other.weight / self.own_weight(place)
            })
    }
}

/// Gives twins what is found at the node that carries their multiplier, and this its own weight.
pub(crate) fn tell_twins<const D: usize>(condition: &Condition<D>, told: &mut ContactSolution<D>) {
    for Twin { places, turn } in &condition.touch.twins {
        let own = condition.untwinned(places[0]);
        told.nodes[places[0]].weight *= own;
        let found = told.nodes[places[0]];
        let twin = &mut told.nodes[places[1]];
        (twin.gap, twin.pressure, twin.status) = (found.gap, found.pressure, found.status);
        twin.shear = turn.vector(found.shear);
    }
}
