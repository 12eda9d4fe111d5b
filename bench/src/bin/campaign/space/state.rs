//! Forces at the nodes of one load step, from its displacements alone, as in the plane.

use super::elastic::{conditions, external, internal};
use super::geometry::{Vector, bounds, length, minus};
use super::problem::{Against, Body, Drive, Problem};
use super::{Answer, Step};
use crate::amount::vector_at;
use crate::held::{Condition, free_part, held_axes};
use crate::state::{FORCE, MOVE, ROUNDINGS, SLENDER};
use std::collections::BTreeMap;

/// One load step, seen from its displacements.
pub struct State {
    /// Forces of supports and contacts on each node of each body.
    pub rest: Vec<Vec<Vector>>,
    /// Rounding limit of these forces.
    pub limits: Vec<Vec<f64>>,
    pub conditions: Vec<Vec<Condition<3>>>,
    /// Held directions of nodes.
    pub held: Vec<BTreeMap<usize, Vec<Vector>>>,
    /// Force scale: half the sum of the magnitudes of all nodal forces of the body where that is largest, at least what the
    /// displacements cause in a slender body.
    pub force: f64,
    /// Displacement scale: the largest displacement, of obstacles, too.
    pub moves: f64,
    /// Largest coordinate: positions are rounded to 2⁻⁵³ of it.
    pub size: f64,
}

impl State {
    /// The forces of a step.
    pub fn new(problem: &Problem, answer: &Answer, step: &Step) -> Self {
        let moves = step.displacements.iter().flatten();
        let largest = moves.fold(0.0, |s: f64, &u| s.max(length(u)));
        let mut state = Self {
            rest: Vec::new(),
            limits: Vec::new(),
            conditions: Vec::new(),
            held: Vec::new(),
            force: 0.0,
            moves: largest,
            size: 0.0,
        };
        let mut magnitudes = Vec::new();
        let mut smallest = f64::INFINITY;
        let bodies = problem.bodies.iter().zip(&answer.meshes);
        for ((body, mesh), moves) in bodies.zip(&step.displacements) {
            // large displacements of other bodies leave rounding on a body that hardly moves
            let inside = internal(mesh, body, moves, 0.01 * largest);
            let outside = external(mesh, body, step.time);
            let both = inside.forces.iter().zip(&outside);
            let rest: Vec<Vector> = both.map(|(&i, &o)| minus(i, o)).collect();
            let sizes = rest.iter().chain(&outside).map(|&f| length(f));
            state.force = state.force.max(0.5 * sizes.sum::<f64>());
            let (low, high) = bounds(&mesh.points);
            let corners = low.iter().chain(&high);
            state.size = corners.fold(state.size, |s: f64, x| s.max(x.abs()));
            smallest = smallest.min(length(minus(high, low)));
            state.rest.push(rest);
            magnitudes.push(inside.magnitudes);
            let conditions = conditions(mesh, body, step.time);
            state.held.push(held_axes(&conditions));
            state.conditions.push(conditions);
        }
        for contact in &problem.contacts {
            if let Against::Obstacle {
                drive: Some(Drive::Displacement(field)),
                ..
            } = &contact.against
            {
                let moved = length(vector_at(field, [0.0; 3], step.time));
                state.moves = state.moves.max(moved);
            }
        }
        // without pressure, forces are rounding of the forces that such displacements could cause
        let moduli = problem.bodies.iter().map(Body::plane_modulus);
        let softest = moduli.fold(f64::INFINITY, f64::min);
        state.force = state.force.max(SLENDER * softest * state.moves * smallest);
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
