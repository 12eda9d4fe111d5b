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
use crate::fem::Twins;
use crate::geometry::{Point, dot};
use crate::model::nouns::model::Model;
use crate::model::nouns::solution::ContactSolution;
use crate::model::system::condition::{Condition, Twin};

/// Normals of one place have at least this cosine of their angle after the turn, where one has those of a corner's other side.
const ALIKE: f64 = 0.9;

/// Joins the nodes of contacts that are one place of the whole.
pub(crate) fn join_borders<const D: usize>(model: &Model<D>, conditions: &mut [Condition<D>]) {
    for condition in conditions {
        let body = &model.bodies[condition.nonmortar.body.0];
        if condition.contact().is_none() {
            continue;
        }
        let Some(twins) = body.twins() else { continue };
        let pairs = places(condition, &twins);
        let turn = twins.turn;
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

/// The places of twins in the list of a contact's nodes.
fn places<const D: usize>(condition: &Condition<D>, twins: &Twins<D>) -> Vec<[usize; 2]> {
    let nodes = &condition.interface.nodes;
    let of = |node: usize| {
        let carries = move |place: &usize| {
            let found = &nodes[*place];
            found.node == node && found.role == Role::Multiplier && found.rows[0].is_some()
        };
        (0..nodes.len()).filter(carries)
    };
    let alike = |first: usize, second: usize| {
        dot(twins.turn.vector(nodes[first].normal()), nodes[second].normal()) >= ALIKE
            // where supports hold one of them otherwise than the other they are not alike
            && nodes[first].rows.map(|row| row.is_some())
                == nodes[second].rows.map(|row| row.is_some())
    };
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for &[node, twin] in &twins.pairs {
        for first in of(node) {
            let free = |second: &usize| pairs.iter().all(|pair| pair[1] != *second);
            let found = of(twin).find(|second| free(second) && alike(first, *second));
            pairs.extend(found.map(|second| [first, second]));
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
