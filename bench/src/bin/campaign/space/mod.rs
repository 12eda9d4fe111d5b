//! Problems of space: bodies, obstacles and histories in any position, before a checker of their own.
//!
//! The same campaign as in the plane: [`families`] make problems, [`check`] judges answers by its own elements, geometry, cones
//! and moments, without any code of the solver, and a part of the problems is solved again turned, in other units and in
//! another order.

mod check;
mod elastic;
mod families;
mod geometry;
#[cfg(test)]
mod mutations;
mod problem;
mod rows;
mod side;
mod solids;
mod state;
mod touch;
mod wrench;

use crate::judgement::Judgement;
use crate::problem::Known;
use crate::random::Random;
use crate::twin::Twin;
use crate::{raw, run};
use geometry::{Vector, random_rotation, without_motion};
pub use problem::Problem;
use problem::{Against, Carry, Law, Shape};
use solids::Solid;
use state::State;
use std::collections::BTreeMap;

type Mesh = raw::Mesh<3, Solid>;
type Answer = raw::Answer<3, Solid>;
type Step = raw::Step<3>;
type Row = raw::Row<3>;

/// A mesh file with moved nodes.
fn gmsh(mesh: &Mesh, place: impl Fn(Vector) -> Vector) -> String {
    let points: Vec<Vector> = mesh.points.iter().map(|&x| place(x)).collect();
    let cell = |(kind, nodes): &(Solid, Vec<usize>)| (kind.gmsh(), kind.in_gmsh(nodes));
    let cells: Vec<_> = mesh.cells.iter().map(cell).collect();
    let facet = |nodes: &Vec<usize>| (side::kind(nodes.len()).gmsh(), nodes.clone());
    let side = |(name, facets): (&String, &Vec<Vec<usize>>)| {
        (name.clone(), facets.iter().map(facet).collect())
    };
    let sides: BTreeMap<_, _> = mesh.sides.iter().map(side).collect();
    crate::gmsh::text(3, &points, &cells, &sides)
}

impl run::Problem<3> for Problem {
    type Kind = Solid;

    fn families() -> Vec<&'static str> {
        families::FAMILIES.map(|(name, _)| name).to_vec()
    }

    fn of_seed(seed: u64, family: Option<&str>, _more: bool) -> Self {
        families::problem(seed, family)
    }

    fn family(&self) -> &'static str {
        self.family
    }

    fn known(&self) -> (Known, &str) {
        (self.known, &self.reason)
    }

    fn rough(&self) -> bool {
        self.contacts.iter().any(|c| c.law.rough())
    }

    fn coulomb(&self) -> bool {
        let coulomb = |law: Law| matches!(law, Law::Coulomb(_));
        self.contacts.iter().any(|c| coulomb(c.law))
    }

    fn contacts(&self) -> Vec<&str> {
        self.contacts.iter().map(|c| c.name.as_str()).collect()
    }

    fn text(&self) -> String {
        Problem::text(self)
    }

    fn files(&self) -> Vec<(&str, &str)> {
        let shapes = self.bodies.iter().map(|body| &body.shape);
        shapes
            .filter_map(|shape| match shape {
                Shape::File { name, text } => Some((&name[..], &text[..])),
                _ => None,
            })
            .collect()
    }

    fn by_method(&self, method: &str) -> Self {
        let mut again = self.clone();
        again.method = method.to_string();
        again
    }

    fn check(&self, answer: &Answer) -> Judgement {
        check::check(self, answer)
    }

    /// Turned, in other units, bodies and contacts in another order; or with the two sides of each contact swapped.
    fn twins(&self, answer: &Answer, random: &mut Random) -> Vec<Twin<Self, 3>> {
        let carry = Carry {
            turn: random_rotation(random),
            lengths: random.magnitude(1e-3, 1e3),
            forces: random.magnitude(1e-3, 1e3),
            shift: [0.0; 3],
        };
        let mut problem = self.carried(&answer.meshes, &carry);
        let mut order: Vec<usize> = (0..self.bodies.len()).collect();
        random.shuffle(&mut order);
        problem.bodies = order.iter().map(|&b| problem.bodies[b].clone()).collect();
        random.shuffle(&mut problem.contacts);
        let swapped = random.chance(0.3);
        for contact in problem.contacts.iter_mut().filter(|_| swapped) {
            if let Against::Side { side, .. } = &mut contact.against {
                std::mem::swap(&mut contact.own, side);
            }
        }
        let place = |b: usize| order.iter().position(|&o| o == b).unwrap_or(b);
        vec![Twin {
            name: if swapped { "sides" } else { "turned" },
            problem,
            lengths: carry.lengths,
            turn: carry.turn,
            parts: (0..order.len()).map(|b| vec![place(b)]).collect(),
            tolerance: 1e-6,
        }]
    }

    fn unique(&self, answer: &Answer, twin: &str) -> bool {
        !run::Problem::coulomb(self)
            && !self.spins
            && (twin != "sides" || check::all_nodal(self, answer))
    }

    fn determined(&self, body: usize, mesh: &Mesh, moves: Vec<Vector>) -> Vec<Vector> {
        if elastic::fully_held(mesh, &self.bodies[body], self.times[0]) {
            moves
        } else {
            without_motion(&mesh.points, &moves)
        }
    }

    fn forces(&self, answer: &Answer, step: &Step) -> (Vec<Vec<Vector>>, f64) {
        let state = State::new(self, answer, step);
        (state.rest, state.force)
    }
}
