//! Problems of the plane as the campaign asks and judges them.

use crate::cells::Kind;
use crate::check::{all_nodal, check};
use crate::families;
use crate::judgement::Judgement;
use crate::plane::{Vector, without_motion};
use crate::problem::{Known, Problem, Shape};
use crate::random::Random;
use crate::raw::{Answer, Mesh, Step};
use crate::run;
use crate::state::State;
use crate::twin::Twin;
use crate::twins::{fully_held, twins};

impl run::Problem<2> for Problem {
    type Kind = Kind;

    fn families() -> Vec<&'static str> {
        let all = families::FAMILIES.iter().chain(&families::MORE);
        all.map(|(name, _)| *name).collect()
    }

    fn of_seed(seed: u64, family: Option<&str>, more: bool) -> Self {
        families::problem(seed, family, more)
    }

    fn family(&self) -> &'static str {
        self.family
    }

    fn known(&self) -> (Known, &str) {
        (self.known, &self.reason)
    }

    fn rough(&self) -> bool {
        Problem::rough(self)
    }

    fn coulomb(&self) -> bool {
        Problem::coulomb(self)
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
        check(self, answer)
    }

    fn twins(&self, answer: &Answer, random: &mut Random) -> Vec<Twin<Self, 2>> {
        twins(self, answer, random)
    }

    fn past(&self) -> usize {
        self.past
    }

    fn told_twice(&self) -> bool {
        self.other.is_some()
    }

    fn unique(&self, answer: &Answer, twin: &str) -> bool {
        // if nothing moves in any step, displacements are only rounding
        if (1..=self.times.len()).all(|step| self.idle.contains(&step)) {
            return false;
        }
        // these twins only rewrite the same history
        let same = matches!(twin, "no stage" | "resumed");
        // plastic flow without hardening is not unique
        let metals = self
            .bodies
            .iter()
            .filter_map(|body| body.more.metal.as_ref());
        (same || !Problem::coulomb(self))
            && metals.into_iter().all(|metal| metal.hardening > 0.0)
            && !self.spins
            && (twin != "sides" || all_nodal(self, answer))
    }

    fn determined(&self, body: usize, mesh: &Mesh, moves: Vec<Vector>) -> Vec<Vector> {
        if fully_held(self, body, mesh) {
            moves
        } else {
            without_motion(&mesh.points, &moves, self.analysis.axisymmetric())
        }
    }

    fn forces(&self, answer: &Answer, step: &Step) -> (Vec<Vec<Vector>>, f64) {
        let state = State::new(self, answer, step);
        (state.rest, state.force)
    }
}
