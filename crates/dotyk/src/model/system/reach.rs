//! Reach of the forces of contact nodes: could pushes between the nodes hold a load that nodal forces do not?
//!
//! ```text
//!   Σ λᵢ gᵢ + Σ μₖ g(xₖ) = e,     λ ∈ Λ, μ ≥ 0,     g(x)ⱼ = n·(rⱼ(x) on the nonmortar side − rⱼ(y) on the other one)
//! ```
//!
//! The force of a node acts at one place. Where facets face the other side in part, these places do not reach the edge of the common
//! area, and a load near that edge has no nodal forces, although the bodies hold it. To distinguish it from a load that cannot
//! be held, the points xₖ between the nodes, where the judge measures gaps, push as well.

use crate::contact::{Coupling, GapPoint};
use crate::dual::{AdmissibleSet, Balance, Block, Feasibility, Modes};
use crate::geometry::dot;
use crate::linalg::SparseVector;
use crate::model::nouns::ids::SideRef;
use crate::model::system::bodies::{LoadedBody, load_size};
use crate::model::system::condition::Condition;
use std::collections::BTreeMap;
use std::iter::repeat_n;

/// A place where two bodies may push each other, and their contact.
type Place<'a, const D: usize> = (&'a Condition<D>, &'a GapPoint<D>);

/// Names of the contacts that could hold a load if they also pushed between their nodes, wherever two bodies face each other: those
/// that the motion with the amplitudes `z` (r,) closes there. `None` where these pushes would not hold it either.
///
/// For each mode: its part with its number there, its row of G and its load.
pub(crate) fn hold_between_nodes<'a, const D: usize>(
    bodies: &[LoadedBody<D>],
    conditions: &'a [Condition<D>],
    admissible: &AdmissibleSet,
    (modes, rows, load): (&[(usize, usize)], &[SparseVector], Vec<f64>),
    z: &[f64],
) -> Option<Vec<&'a str>> {
    let places = places(conditions);
    let (first, m) = (admissible.len(), admissible.len() + places.len());
    let between = closed(bodies, &places, modes);
    let with_places = |(row, between): (&SparseVector, &Vec<(usize, f64)>)| {
        let between = between
            .iter()
            .map(|&(place, closed)| (first + place, closed));
        SparseVector::new(m, row.entries().chain(between))
    };
    let rows: Vec<SparseVector> = rows.iter().zip(&between).map(with_places).collect();
    let blocks = admissible.blocks().iter().copied();
    let blocks = blocks.chain(repeat_n(Block::Unilateral, places.len()));
    let balance = Balance::new(Modes::of_rows(&rows, m), load);
    let force = bodies.iter().map(load_size).fold(0.0, f64::max);
    match Feasibility::of(&AdmissibleSet::new(blocks.collect()), &balance, force) {
        Feasibility::Infeasible { .. } => None,
        Feasibility::Feasible { .. } => {
            let mut met = vec![0.0; m];
            let parts = rows.iter().zip(z);
            parts.for_each(|(row, z)| row.add_to(*z, &mut met));
            let met = places.iter().zip(&met[first..]);
            let met = met.filter(|(_, closed)| **closed > 0.0);
            let mut names: Vec<&str> = met
                .map(|((condition, _), _)| condition.name.as_str())
                .collect();
            names.dedup();
            Some(names)
        }
    }
}

/// Points where two bodies face each other in unilateral contacts, contact by contact.
fn places<const D: usize>(conditions: &[Condition<D>]) -> Vec<Place<'_, D>> {
    let pushes = |condition: &&Condition<D>| {
        // no rigid motion closes gaps between sides of the same body
        let two = |other: &SideRef| other.body != condition.nonmortar.body;
        condition.mortar.as_ref().is_some_and(two) && condition.interface.coupling != Coupling::Tied
    };
    let all = conditions.iter().filter(pushes).flat_map(|condition| {
        let samples = condition.touch.samples.iter().flatten();
        samples.map(move |sample| (condition, &sample.at))
    });
    all.collect()
}

/// Closing of the places by each mode of its own body, by their numbers.
fn closed<const D: usize>(
    bodies: &[LoadedBody<D>],
    places: &[Place<'_, D>],
    modes: &[(usize, usize)],
) -> Vec<Vec<(usize, f64)>> {
    let mut of_body: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, (condition, _)) in places.iter().enumerate() {
        for side in [Some(&condition.nonmortar), condition.mortar.as_ref()] {
            let Some(side) = side else { continue };
            of_body.entry(side.body.0).or_default().push(k);
        }
    }
    let of_mode = |&(body, mode): &(usize, usize)| {
        let Some(own) = of_body.get(&body) else {
            return Vec::new();
        };
        let system = &bodies[body].system;
        let moved = system.to_global(&system.modes[mode]);
        let along = |nodes: &[(usize, f64)], normal| -> f64 {
            let nodes = nodes.iter();
            nodes.map(|&(n, shape)| shape * dot(moved[n], normal)).sum()
        };
        let closed = |&k: &usize| {
            let (condition, at) = places[k];
            match condition.nonmortar.body.0 == body {
                true => (k, along(&at.own, at.normal)),
                false => (k, -along(&at.opposite, at.normal)),
            }
        };
        own.iter().map(closed).collect()
    };
    modes.iter().map(of_mode).collect()
}
