//! Nodes of a contact that are one place: on the border of a sector, where what meets one face meets the other; on both sides of the cut
//! of a bolt which a contact crosses, if the bolt draws them together along the contact; and what meets the other side along one direction
//! at one place, from several faces of a corner or on several of its surfaces.
//!
//! Ties of the faces make the conditions at both the same, so that their forces could be divided in any way; and a bolt that is locked
//! would exchange its force with the friction on both sides. There is one multiplier of the weight of both, whose row is the mean of both
//! rows:
//!
//! ```text
//!   (w₁ + w₂) row = w₁ row₁ + w₂ row₂,      p = λ/(w₁ + w₂) at both
//! ```
//!
//! with the directions at the second turned as its place is.

use crate::contact::{Coupling, InterfaceNode, Role};
use crate::fem::{Turn, Twins};
use crate::geometry::{Point, add_scaled, distance, dot};
use crate::model::nouns::ids::BodyId;
use crate::model::nouns::model::Model;
use crate::model::nouns::solution::ContactSolution;
use crate::model::system::condition::{Condition, Twin};
use std::collections::{BTreeMap, BTreeSet};

/// Normals of one place have at least this cosine of their angle after the turn, where one has those of a corner's other side.
const ALIKE: f64 = 0.9;

/// Conditions of one node are the same if their directions, and their gaps by the length of the body, differ by less.
const SAME_CONDITION: f64 = 1e-6;

/// A contact lies along the axis of a bolt if the part of its normal along it is no larger.
const ALONG: f64 = 1e-6;

/// Joins the nodes of contacts that are one place of the whole.
pub(crate) fn join_borders<const D: usize>(model: &Model<D>, conditions: &mut [Condition<D>]) {
    let cuts: Vec<(BodyId, Cut<D>)> = conditions.iter().filter_map(|c| cut(model, c)).collect();
    for condition in conditions {
        let of = condition.nonmortar.body;
        if condition.contact().is_none() {
            continue;
        }
        let nodes = &condition.interface.nodes;
        let mortar = condition.mortar.as_ref();
        let mortar = mortar.map(|side| model.bodies[side.body.0].mesh.points());
        let mut pairs = match condition.interface.coupling {
            Coupling::Tied => Vec::new(),
            _ => same_conditions(nodes, mortar, model.bodies[of.0].mesh.diameter()),
        };
        if let Some(twins) = model.bodies[of.0].twins() {
            join_places(nodes, &twins, |_| true, &mut pairs);
        }
        for (_, cut) in cuts.iter().filter(|(body, _)| *body == of) {
            let along = |node: &InterfaceNode<D>| dot(node.normal(), cut.axis).abs() <= ALONG;
            join_places(nodes, &cut.twins, along, &mut pairs);
        }
        let joined = pairs.iter().map(|Twin { places, turn }| {
            let frame = condition.interface.nodes[places[0]].frame;
            (*places, frame.map(|axis| turn.vector(axis)))
        });
        let joined: Vec<([usize; 2], [Point<D>; D])> = joined.collect();
        condition.interface.join(&joined);
        condition.touch.twins = pairs;
    }
}

/// The places of nodes whose conditions on several surfaces of the other side are one: along one direction, with one gap, at one place of
/// the other side (of these points; an obstacle is rigid, so that its places do not matter). That of the largest weight comes first; gaps
/// and places are compared with a length.
fn same_conditions<const D: usize>(
    nodes: &[InterfaceNode<D>],
    mortar: Option<&[Point<D>]>,
    length: f64,
) -> Vec<Twin<D>> {
    let mut at_nodes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (place, node) in nodes.iter().enumerate() {
        if node.rows[0].is_some() {
            at_nodes.entry(node.node).or_default().push(place);
        }
    }
    // over a trench with level banks each bank has a condition of its own
    let at_one_place = |[a, b]: [&InterfaceNode<D>; 2]| {
        let Some(points) = mortar else { return true };
        let met = |node: &InterfaceNode<D>| {
            let met = node.opposite.iter();
            met.fold([0.0; D], |sum, &(k, n)| add_scaled(sum, n, points[k]))
        };
        let known = !a.opposite.is_empty() && !b.opposite.is_empty();
        known && distance(met(a), met(b)) <= SAME_CONDITION * length
    };
    let mut pairs = Vec::new();
    for mut places in at_nodes.into_values().filter(|places| places.len() > 1) {
        // stable: the first of equal ones
        places.sort_by(|&a, &b| nodes[b].weight.total_cmp(&nodes[a].weight));
        let mut owners: Vec<usize> = Vec::new();
        for place in places {
            let same = |&&owner: &&usize| {
                let [a, b] = [&nodes[owner], &nodes[place]];
                distance(a.normal(), b.normal()) <= SAME_CONDITION
                    && (a.gap - b.gap).abs() <= SAME_CONDITION * length
                    && a.rows.map(|row| row.is_some()) == b.rows.map(|row| row.is_some())
                    && at_one_place([a, b])
            };
            match owners.iter().find(same) {
                Some(&owner) => pairs.push(Twin {
                    places: [owner, place],
                    turn: Turn::none(),
                }),
                None => owners.push(place),
            }
        }
    }
    pairs
}

/// The cut of a bolt through one body.
struct Cut<const D: usize> {
    axis: Point<D>,
    twins: Twins<D>,
}

/// The cut that a condition draws together, if both of its sides are of one body.
fn cut<const D: usize>(model: &Model<D>, condition: &Condition<D>) -> Option<(BodyId, Cut<D>)> {
    model.members[condition.source.member()?].kind.bolt()?;
    let nodes = &condition.interface.nodes;
    let axis = nodes.first()?.frame[0];
    let pairs = nodes
        .iter()
        .filter_map(|node| Some([node.node, node.partner()?]));
    let (turn, pairs) = (Turn::none(), pairs.collect());
    let cut = Cut {
        axis,
        twins: Twins { turn, pairs },
    };
    let is_one = condition.mortar.is_none();
    is_one.then_some((condition.nonmortar.body, cut))
}

/// Adds the places of twins in the list of a contact's nodes, those of nodes that may be joined and are not yet.
fn join_places<const D: usize>(
    nodes: &[InterfaceNode<D>],
    twins: &Twins<D>,
    may_join: impl Fn(&InterfaceNode<D>) -> bool,
    pairs: &mut Vec<Twin<D>>,
) {
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
    for &[node, twin] in &twins.pairs {
        for first in of(node).filter(|&first| may_join(&nodes[first])) {
            let free = |place: &usize| pairs.iter().all(|pair| !pair.places.contains(place));
            if !free(&first) {
                continue;
            }
            let found = of(twin).find(|second| free(second) && alike(first, *second));
            pairs.extend(found.map(|second| Twin {
                places: [first, second],
                turn: twins.turn,
            }));
        }
    }
}

impl<const D: usize> Condition<D> {
    /// The part of the weight of a node in its contact that is not that of a twin.
    pub fn untwinned(&self, place: usize) -> f64 {
        let twins = self.touch.twins.iter();
        let twins = twins.filter(|twin| twin.places[0] == place);
        let others = twins.map(|twin| self.interface.nodes[twin.places[1]].weight);
        let others: f64 = others.sum();
        match others > 0.0 {
            true => 1.0 - others / self.own_weight(place),
            false => 1.0,
        }
    }
}

/// Gives twins what is found at the node that carries their multiplier, and this its own weight.
pub(crate) fn tell_twins<const D: usize>(condition: &Condition<D>, told: &mut ContactSolution<D>) {
    for Twin { places, turn } in &condition.touch.twins {
        let found = told.nodes[places[0]];
        let twin = &mut told.nodes[places[1]];
        (twin.gap, twin.pressure, twin.status) = (found.gap, found.pressure, found.status);
        twin.shear = turn.vector(found.shear);
        // in the plane the slip is that of the node itself
        if D == 3 {
            twin.slip = turn.vector(found.slip);
        }
    }
    let carriers = condition.touch.twins.iter().map(|twin| twin.places[0]);
    let carriers: BTreeSet<usize> = carriers.collect();
    for place in carriers {
        told.nodes[place].weight *= condition.untwinned(place);
    }
}
