//! Forces at the nodes of one load step, from its displacements alone.
//!
//! rest = internal − external is the force of supports and contacts on a node. At other nodes it must vanish; on a contact side it
//! is the true contact force.

use crate::amount::vector_at;
use crate::elastic::{Internal, bedded, conditions, external, internal, of_support};
use crate::held::{Condition, free_part, held_axes};
use crate::metal;
use crate::problem::{Against, Analysis, Bar, Body, Drive, Problem};
use crate::raw::{Answer, Mesh, Step};
use crate::vector::{axes, bounds, dot, length, minus, plus, sum};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

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
pub struct State<const D: usize> {
    /// Forces of supports and contacts on each node of each body.
    pub rest: Vec<Vec<[f64; D]>>,
    /// Rounding limit of these forces.
    pub limits: Vec<Vec<f64>>,
    pub conditions: Vec<Vec<Condition<D>>>,
    /// Held directions of nodes.
    pub held: Vec<BTreeMap<usize, Vec<[f64; D]>>>,
    /// Force scale: half the sum of the magnitudes of all nodal forces of the body where that is largest, at least what the
    /// displacements cause in a slender body.
    pub force: f64,
    /// Displacement scale: the largest displacement, of obstacles, too.
    pub moves: f64,
    /// Largest coordinate: positions are rounded to 2⁻⁵³ of it.
    pub size: f64,
    /// Forces of beds on each body.
    pub beds: Vec<[f64; D]>,
}

/// Conditions of supports that begin in a later step: nodes are held where they were in the step before.
fn held_later<const D: usize>(
    problem: &Problem<D>,
    answer: &Answer<D>,
    step: &Step<D>,
    body: usize,
) -> Vec<Condition<D>> {
    let mut all = Vec::new();
    for support in &problem.bodies[body].supports {
        let Some(from) = support.from.filter(|&from| step.time >= from) else {
            continue;
        };
        let before = answer.steps.iter().rfind(|step| step.time < from);
        for condition in of_support(&answer.meshes[body], support, step.time) {
            let was = before.map_or([0.0; D], |b| b.displacements[body][condition.node]);
            all.push(Condition {
                value: condition.value + dot(condition.axis, was),
                ..condition
            });
        }
    }
    all
}

/// The tension of the spring or bar of a body in a step, after all steps up to it.
fn tension<const D: usize>(answer: &Answer<D>, step: &Step<D>, body: usize, bar: &Bar<D>) -> f64 {
    let node = answer.meshes[body].nearest(bar.at);
    let before = answer.steps.iter().filter(|s| s.time <= step.time);
    bar.tension(before.map(|s| s.displacements[body][node][0]))
}

/// Forces of the stresses of a body: of metal there may be two kinds, depending on whether its cells flow.
fn inside<const D: usize>(
    (problem, answer, step): (&Problem<D>, &Answer<D>, &Step<D>),
    place: usize,
    least: f64,
) -> Vec<Internal<D>> {
    let (body, mesh) = (&problem.bodies[place], &answer.meshes[place]);
    let Some(own) = &body.more.metal else {
        let moves = &step.displacements[place];
        return vec![internal(mesh, body, problem.analysis, moves, least)];
    };
    let so_far = answer.steps.iter().filter(|s| s.time <= step.time);
    let ways = so_far.map(|s| &s.displacements[place][..]);
    let ways: Vec<&[[f64; D]]> = ways.collect();
    let forces = |gives_way: bool| {
        let of = (mesh, body, own);
        metal::internal(of, problem.analysis, &ways, (least, gives_way))
    };
    let (inside, either) = forces(false);
    let other = either.then(|| forces(true).0);
    std::iter::once(inside).chain(other).collect()
}

/// The displacement that the release of the initial stress of a body could cause.
fn given<const D: usize>(body: &Body<D>, mesh: &Mesh<D>) -> f64 {
    let (low, high) = bounds(&mesh.points);
    let components = body.more.initial.iter().flatten();
    let stress = components.flat_map(|s| [low, high].map(|x| s.at(x, 0.0).abs()));
    stress.fold(0.0, f64::max) / body.young * length(minus(high, low))
}

impl<const D: usize> State<D> {
    /// The forces of a step.
    pub fn new(problem: &Problem<D>, answer: &Answer<D>, step: &Step<D>) -> Self {
        let analysis = problem.analysis;
        let all = step.displacements.iter().flatten();
        let largest = all.fold(0.0, |s: f64, &u| s.max(length(u)));
        let mut state = Self {
            rest: Vec::new(),
            limits: Vec::new(),
            conditions: Vec::new(),
            held: Vec::new(),
            force: 0.0,
            moves: largest,
            size: 0.0,
            beds: Vec::new(),
        };
        let mut magnitudes = Vec::new();
        let mut smallest = f64::INFINITY;
        for (place, (body, mesh)) in problem.bodies.iter().zip(&answer.meshes).enumerate() {
            let moves = &step.displacements[place];
            let mut outside = match body.there(step.time) {
                true => external(mesh, body, analysis, step.time),
                false => vec![[0.0; D]; moves.len()],
            };
            let mut beds = bedded(mesh, body, analysis, moves);
            // a spring or bar along x at one of the nodes, whose other end is held
            if let Some(bar) = &body.more.bar {
                beds[mesh.nearest(bar.at)][0] -= tension(answer, step, place, bar);
            }
            for (sum, &bed) in outside.iter_mut().zip(&beds) {
                *sum = plus(*sum, 1.0, bed);
            }
            // large displacements of other bodies leave rounding on a body that hardly moves
            let inside = inside((problem, answer, step), place, 0.01 * largest);
            let rests = inside.into_iter().map(|inside| {
                let forces = inside.forces.iter().zip(&outside);
                let rest: Vec<[f64; D]> = forces.map(|(&i, &o)| minus(i, o)).collect();
                (rest, inside.magnitudes)
            });
            let left = |rest: &[[f64; D]]| rest.iter().map(|&f| length(f)).sum::<f64>();
            let (rest, own_magnitudes) = rests
                .min_by(|(a, _), (b, _)| left(a).total_cmp(&left(b)))
                .unwrap_or_default();
            state.force = state.force.max(0.5 * (left(&rest) + left(&outside)));
            state.moves = state.moves.max(GIVEN * given(body, mesh));
            let (low, high) = bounds(&mesh.points);
            let corners = low.iter().chain(&high);
            state.size = corners.fold(state.size, |s: f64, x| s.max(x.abs()));
            smallest = smallest.min(length(minus(high, low)));
            state.rest.push(rest);
            magnitudes.push(own_magnitudes);
            state.beds.push(sum(beds));
            let mut conditions = conditions(mesh, body, analysis, step.time);
            conditions.extend(held_later(problem, answer, step, place));
            state.held.push(held_axes(&conditions));
            state.conditions.push(conditions);
        }
        for (place, body) in problem.bodies.iter().enumerate() {
            // the force of a bar is not a reaction at either of its ends
            if let Some(bar) = &body.more.bar
                && let Some((other, _)) = &bar.to
            {
                let (tension, along) = (tension(answer, step, place, bar), axes()[0]);
                let other = problem.body(other);
                state.beds[place] = plus(state.beds[place], tension, along);
                state.beds[other] = plus(state.beds[other], -tension, along);
            }
        }
        for contact in &problem.contacts {
            if let Against::Obstacle {
                drive: Drive::Displacement(field),
                ..
            } = &contact.against
            {
                let moved = length(vector_at(field, [0.0; D], step.time));
                state.moves = state.moves.max(moved);
            }
        }
        // without pressure, forces are rounding of the forces that such displacements could cause
        let moduli = problem.bodies.iter().map(Body::plane_modulus);
        let softest = moduli.fold(f64::INFINITY, f64::min);
        let deep = match analysis {
            Analysis::Space => smallest,
            Analysis::Axisymmetric => TAU * state.size,
            _ => problem.bodies[0].thickness,
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
    pub fn free(&self, body: usize, node: usize, force: [f64; D]) -> [f64; D] {
        free_part(force, self.held[body].get(&node))
    }

    /// Lengths below this are rounding.
    pub fn tiny_length(&self) -> f64 {
        MOVE * self.moves + 1e-14 * self.size
    }
}
