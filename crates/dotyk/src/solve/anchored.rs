//! Proximal steps with friction: a problem that is always soft enough to be solved, and harder each time.
//!
//! ```text
//!   λ ← the solution of the law with F + a and d + aλ
//! ```
//!
//! The compliance a that is added outweighs what friction couples, so that Newton's iteration on the states ends; the
//! solution becomes the next centre λ, and where centres no longer change they solve the problem without a. After an
//! iteration that ended a falls, after one that ran in a circle it rises. Contacts that share their forces (F of low rank) do
//! no harm: F + a is definite.
//!
//! The states come from the trial forces λ − g/c with the compliance c of each contact and what is left of its condition,
//! g = gap + a(λ − centre). The trial forces centre − gap/a of the convex problem (`proximal.rs`) have the same solution, but
//! they grow as a falls, beyond every bound: nodes would flip from one direction of slip to the other, and in space the
//! linearised law would forget that a direction may turn.
//!
//! As described in Acary, Brémond & Huber (2018) for the loop, Alart & Curnier (1991) for its steps.

use std::collections::HashSet;

use crate::dual::Component;
use crate::solve::exact::{CERTAIN, Ended, NEAR, Search};
use crate::solve::hold::{held, hold};
use crate::solve::setup::Setup;
use crate::solve::states::{Anchor, State};
use crate::solve::system::System;
use crate::solve::{Observer, largest};

/// First compliance, relative to that of each contact; its factors after a success and a failure.
const FIRST: f64 = 0.1;
const FALL: f64 = 0.3;
const RISE: f64 = 10.0;

/// Smallest and largest compliance.
const LEAST: f64 = 1e-6;
const LARGEST: f64 = 1e4;

/// Centres without a smaller residual that end the steps.
const PATIENCE: usize = 10;

/// Most Newton steps for one centre.
const INNER: usize = 40;

/// Errors of the law that Newton steps for one centre leave: a part of the residual of the centre before, at least the second.
const INEXACT: f64 = 1e-3;
const ACCURATE: f64 = 1e-10;

/// Proximal steps, and exact ones where two centres in a row have the same states.
pub(crate) fn settle(
    search: &mut Search<'_>,
    mut states: Vec<State>,
    observe: Observer<'_>,
) -> Ended {
    let setup = search.setup;
    let mut centre = vec![0.0; setup.len()];
    setup.admissible.project(&search.best.1.lambda, &mut centre);
    search.move_to(centre, search.best.1.alpha.clone());
    let mut at = search.point.clone();
    let (mut part, mut error) = (FIRST, INEXACT);
    let (mut best, mut still) = (f64::INFINITY, 0);
    let mut before = Vec::new();
    while part <= LARGEST && still <= PATIENCE && !search.exhausted() {
        let compliance: Vec<f64> = setup.problem.softness.iter().map(|c| part * c).collect();
        let anchor = Anchor {
            centre: &at.lambda,
            compliance: &compliance,
        };
        (at, states) = match anchored(search, states.clone(), anchor, error, observe) {
            Inner::Stopped => return Ended::Stopped,
            Inner::Settled(states) => (search.point.clone(), states),
            Inner::Failed => {
                part *= RISE;
                continue;
            }
        };
        let residual = search.residual;
        if residual <= search.tolerance {
            return Ended::Converged;
        }
        let settled = State::keys(&states);
        if settled == before {
            match search.exact(states.clone(), &NEAR, &held(setup), observe) {
                Ended::Stuck(_) => {}
                ended => return ended,
            }
        }
        before = settled;
        let falls = residual < 0.9 * best;
        still = if falls { 0 } else { still + 1 };
        best = best.min(residual);
        error = (INEXACT * residual).clamp(ACCURATE, INEXACT);
        part = (part * FALL).max(LEAST);
    }
    Ended::Stuck(states)
}

/// How the Newton steps for one centre ended.
enum Inner {
    /// The states that come next.
    Settled(Vec<State>),
    Failed,
    Stopped,
}

/// Newton steps on anchored conditions until the error of the law is at most the part `accuracy` of the largest force.
fn anchored(
    search: &mut Search<'_>,
    mut states: Vec<State>,
    anchor: Anchor<'_>,
    accuracy: f64,
    observe: Observer<'_>,
) -> Inner {
    let setup = search.setup;
    let mut seen = HashSet::new();
    for _ in 0..INNER {
        if search.exhausted() || !anchored_step(search, &states, anchor) {
            return Inner::Failed;
        }
        if search.tell(observe) {
            return Inner::Stopped;
        }
        let left = anchor.left(&search.point.lambda, &search.judge.gap);
        let mut next = search.next_states(&states, &left);
        let (now, then) = (State::keys(&states), State::keys(&next));
        // in space the directions of slip go on turning in the same states
        let turns = states.iter().any(State::may_turn);
        let force = largest(0.0, &search.point.lambda);
        let settled = law_error(setup, &search.point.lambda, &left) <= accuracy * force;
        let answer = search.residual <= CERTAIN * search.tolerance;
        if settled || answer || now == then && !turns {
            return Inner::Settled(next);
        }
        hold(setup, &mut next, Some(&states));
        if !seen.insert(now) && !turns {
            return Inner::Failed;
        }
        states = next;
    }
    Inner::Failed
}

/// Solves for the forces of `states` with anchored conditions and judges them; `false` where the system is singular.
fn anchored_step(search: &mut Search<'_>, states: &[State], anchor: Anchor<'_>) -> bool {
    let setup = search.setup;
    let softness = &setup.problem.softness;
    let mut system = System::of(setup, states, Some(anchor), softness);
    search.steps += 1;
    search.kind = 'p';
    let solved = system.solve(&search.point, ACCURATE);
    let Some(point) = solved else { return false };
    search.point = point;
    search.judge();
    true
}

/// Largest |λ − P(λ − gap/softness)|, a force; shears are held to the bounds that go with λₙ. Shapes: (m,).
fn law_error(setup: &Setup<'_>, lambda: &[f64], gap: &[f64]) -> f64 {
    let trial = |i: usize| lambda[i] - gap[i] / setup.problem.softness[i];
    let error = |(i, component): (usize, &Component)| match component {
        Component::Free => (lambda[i] - trial(i)).abs(),
        Component::Normal => (lambda[i] - trial(i).max(0.0)).abs(),
        Component::Tangent => 0.0,
    };
    let normal = setup.components.iter().enumerate().map(error);
    let shear = setup.admissible.slip_violation(lambda, trial);
    normal.fold(shear, f64::max)
}
