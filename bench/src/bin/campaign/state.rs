//! Forces at the nodes of one load step, from its displacements alone.
//!
//! rest = internal − external is the force of supports and contacts on a node. At other nodes it must vanish; on a contact side it
//! is the true contact force.

use crate::elastic::{bedded, conditions, external, internal, nearest, of_support};
use crate::held::{Condition, free_part, held_axes};
use crate::metal;
use crate::plane::{Vector, bounds, dot, length, minus, plus};
use crate::problem::{Bar, Body, Problem};
use crate::raw::{Answer, Step};
use std::collections::BTreeMap;

/// Forces below this part of the force scale are rounding: a hundredth of the error of a wrong answer, ten times the limit of
/// the program (1e-8 of its own scale).
pub const FORCE: f64 = 1e-7;

/// Displacements below this part of the displacement scale are rounding: the limit of the program at nodes.
pub const MOVE: f64 = 1e-6;

/// An initial stress counts in the displacement scale with this part of the displacement that its release would cause.
const GIVEN: f64 = 0.1;

/// Roundings of displacements in units of 2⁻⁵³ that add up at a node.
pub const ROUNDINGS: f64 = 32.0;

/// Force over modulus · displacement · thickness of the most slender body for which forces are checked sharply.
pub const SLENDER: f64 = 1e-4;

/// One load step, seen from its displacements.
pub struct State {
    /// Forces of supports and contacts on each node of each body.
    pub rest: Vec<Vec<Vector>>,
    /// Rounding limit of these forces.
    pub limits: Vec<Vec<f64>>,
    pub conditions: Vec<Vec<Condition>>,
    /// Held directions of nodes.
    pub held: Vec<BTreeMap<usize, Vec<Vector>>>,
    /// Force scale: half the sum of the magnitudes of all nodal forces of the body where that is largest, at least what the
    /// displacements cause in a slender body.
    pub force: f64,
    /// Displacement scale: the largest displacement.
    pub moves: f64,
    /// Largest coordinate: positions are rounded to 2⁻⁵³ of it.
    pub size: f64,
    /// Forces of beds on each body.
    pub beds: Vec<Vector>,
}

/// Conditions of supports that begin in a later step: nodes are held where they were in the step before.
fn held_later(problem: &Problem, answer: &Answer, step: &Step, body: usize) -> Vec<Condition> {
    let mut all = Vec::new();
    for support in &problem.bodies[body].supports {
        let Some(from) = support.from.filter(|&from| step.time >= from) else {
            continue;
        };
        let before = answer.steps.iter().rfind(|step| step.time < from);
        for condition in of_support(&answer.meshes[body], support, step.time) {
            let was = before.map_or([0.0; 2], |b| b.displacements[body][condition.node]);
            all.push(Condition {
                value: condition.value + dot(condition.axis, was),
                ..condition
            });
        }
    }
    all
}

/// The tension of the spring or bar of a body in a step, after all steps up to it.
fn tension(answer: &Answer, step: &Step, body: usize, bar: &Bar) -> f64 {
    let node = nearest(&answer.meshes[body], bar.at);
    let before = answer.steps.iter().filter(|s| s.time <= step.time);
    bar.tension(before.map(|s| s.displacements[body][node][0]))
}

impl State {
    /// The forces of a step.
    pub fn new(problem: &Problem, answer: &Answer, step: &Step) -> Self {
        let analysis = problem.analysis;
        let mut state = Self {
            rest: Vec::new(),
            limits: Vec::new(),
            conditions: Vec::new(),
            held: Vec::new(),
            force: 0.0,
            moves: 0.0,
            size: 0.0,
            beds: Vec::new(),
        };
        let mut magnitudes = Vec::new();
        // large displacements of other bodies leave rounding on a body that hardly moves
        let all = step.displacements.iter().flatten();
        let largest = all.fold(0.0, |s: f64, &u| s.max(length(u)));
        for ((body, mesh), moves) in problem
            .bodies
            .iter()
            .zip(&answer.meshes)
            .zip(&step.displacements)
        {
            let least = 0.01 * largest;
            let inside = match &body.more.metal {
                Some(own) => {
                    let place = state.rest.len();
                    let so_far = answer.steps.iter().filter(|s| s.time <= step.time);
                    let ways = so_far.map(|s| &s.displacements[place][..]);
                    let ways: Vec<&[Vector]> = ways.collect();
                    let forces = |gives_way: bool| {
                        let of = (mesh, body, own);
                        metal::internal(of, analysis, &ways, (least, gives_way))
                    };
                    let (inside, either) = forces(false);
                    let other = either.then(|| forces(true).0);
                    std::iter::once(inside).chain(other).collect()
                }
                None => vec![internal(mesh, body, analysis, moves, least)],
            };
            let there = body.more.from.is_none_or(|from| step.time >= from);
            let mut outside = match there {
                true => external(mesh, body, analysis, step.time),
                false => vec![[0.0; 2]; moves.len()],
            };
            let mut beds = bedded(mesh, body, analysis, moves);
            // a spring or bar along x at one of the nodes, whose other end is held
            if let Some(bar) = &body.more.bar {
                let node = nearest(mesh, bar.at);
                beds[node][0] -= tension(answer, step, state.rest.len(), bar);
            }
            for (sum, &bed) in outside.iter_mut().zip(&beds) {
                *sum = plus(*sum, 1.0, bed);
            }
            let rests = inside.into_iter().map(|inside| {
                let forces = inside.forces.iter().zip(&outside);
                let rest: Vec<Vector> = forces.map(|(&i, &o)| minus(i, o)).collect();
                (rest, inside.magnitudes)
            });
            let left = |rest: &[Vector]| rest.iter().map(|&f| length(f)).sum::<f64>();
            let (rest, own_magnitudes) = rests
                .min_by(|(a, _), (b, _)| left(a).total_cmp(&left(b)))
                .unwrap_or_default();
            let sizes = rest.iter().chain(&outside).map(|&f| length(f));
            state.force = state.force.max(0.5 * sizes.sum::<f64>());
            state.moves = moves.iter().fold(state.moves, |s, &u| s.max(length(u)));
            let (low, high) = bounds(&mesh.points);
            // beside the displacement that the initial stress could cause
            let stress = body.more.initial.as_ref().map_or(0.0, |stress| {
                let at = |x: Vector| {
                    stress
                        .iter()
                        .map(|s| s.at(x, 0.0).abs())
                        .fold(0.0, f64::max)
                };
                at(low).max(at(high))
            });
            let could = stress / body.young * length(minus(high, low));
            state.moves = state.moves.max(GIVEN * could);
            let corner = low
                .iter()
                .chain(&high)
                .fold(0.0, |s: f64, x| s.max(x.abs()));
            state.size = state.size.max(corner);
            state.rest.push(rest);
            magnitudes.push(own_magnitudes);
            state
                .beds
                .push(beds.iter().fold([0.0; 2], |s, &f| plus(s, 1.0, f)));
            let mut conditions = conditions(mesh, body, analysis, step.time);
            conditions.extend(held_later(problem, answer, step, state.conditions.len()));
            state.held.push(held_axes(&conditions));
            state.conditions.push(conditions);
        }
        for (place, body) in problem.bodies.iter().enumerate() {
            // the force of a bar is not a reaction at either of its ends
            if let Some(bar) = &body.more.bar
                && let Some((other, _)) = &bar.to
            {
                let pull = [tension(answer, step, place, bar), 0.0];
                state.beds[place] = plus(state.beds[place], 1.0, pull);
                let other = problem.body(other);
                state.beds[other] = plus(state.beds[other], -1.0, pull);
            }
        }
        for (place, contact) in problem.contacts.iter().enumerate() {
            if let crate::problem::Against::Obstacle {
                drive: crate::problem::Drive::Displacement(field),
                ..
            } = &contact.against
            {
                let moved = crate::amount::vector_at(field, [0.0; 2], step.time);
                debug_assert!(place < step.contacts.len());
                state.moves = state.moves.max(length(moved));
            }
        }
        // without pressure, forces are rounding of the forces that such displacements could cause
        let softest = problem
            .bodies
            .iter()
            .map(Body::plane_modulus)
            .fold(f64::INFINITY, f64::min);
        let deep = match analysis.axisymmetric() {
            true => std::f64::consts::TAU * state.size,
            false => problem.bodies[0].thickness,
        };
        state.force = state.force.max(SLENDER * softest * state.moves * deep);
        let rounding = ROUNDINGS * f64::EPSILON / 2.0;
        let limit = |m: &f64| FORCE * state.force + rounding * m;
        state.limits = magnitudes
            .iter()
            .map(|m| m.iter().map(limit).collect())
            .collect();
        state
    }

    /// The known part of the force on a node: without the directions that supports hold.
    pub fn free(&self, body: usize, node: usize, force: Vector) -> Vector {
        free_part(force, self.held[body].get(&node))
    }

    /// Lengths below this are rounding.
    pub fn tiny_length(&self) -> f64 {
        MOVE * self.moves + 1e-14 * self.size
    }
}
