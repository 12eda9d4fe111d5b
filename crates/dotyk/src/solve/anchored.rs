//! Proximal steps with friction: problems with an added compliance, which falls from one to the next.
//!
//! ```text
//!   λ ← the solution of the law with F + a and d + aλ
//! ```
//!
//! The added compliance a outweighs the coupling by friction, so that Newton's iteration on the states converges; the solution
//! becomes the next centre λ, and a centre that no longer changes solves the problem without a. After an iteration that
//! converged a falls, after one that ran in a circle it rises. Contacts that share their forces (F of low rank) are
//! harmless: F + a is definite.
//!
//! The states come from the trial forces λ − g/c with the compliance c of each contact and the residual of its condition,
//! g = gap + a(λ − centre). The trial forces centre − gap/a of the convex problem (`proximal.rs`) have the same solution, but
//! they grow without bound as a falls: nodes would flip from one direction of slip to the other, and in space the linearised
//! law would lose its terms for a turning direction.
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
const LEAST_ANCHORED: f64 = 1e-6;
const LARGEST: f64 = 1e4;

/// Centres without a smaller residual that end the steps.
const ANCHOR_PATIENCE: usize = 10;

/// Most Newton steps for one centre.
const INNER: usize = 40;

/// Accuracy of the law in the Newton steps for one centre: this part of the residual of the previous centre, at least the second.
const INEXACT: f64 = 1e-3;
pub(crate) const ACCURATE: f64 = 1e-10;

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
    while part <= LARGEST && still <= ANCHOR_PATIENCE && !search.exhausted() {
        let compliance: Vec<f64> = setup.problem.softness.iter().map(|c| part * c).collect();
        let anchor = Anchor {
            centre: &at.lambda,
            compliance: &compliance,
        };
        let own = (anchor, &setup.problem.softness[..]);
        (at, states) = match anchored(search, states.clone(), own, error, observe) {
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
        part = (part * FALL).max(LEAST_ANCHORED);
    }
    Ended::Stuck(states)
}

/// How the Newton steps for one centre ended.
pub(crate) enum Inner {
    /// The states that come next.
    Settled(Vec<State>),
    Failed,
    Stopped,
}

/// Newton steps on anchored conditions until the error of the law is at most the part `accuracy` of the largest force; states
/// come from trial forces of the compliance `own` (m,).
pub(crate) fn anchored(
    search: &mut Search<'_>,
    mut states: Vec<State>,
    (anchor, own): (Anchor<'_>, &[f64]),
    accuracy: f64,
    observe: Observer<'_>,
) -> Inner {
    let setup = search.setup;
    let mut seen = HashSet::new();
    for _ in 0..INNER {
        if search.exhausted() || !anchored_step(search, &states, anchor, own) {
            return Inner::Failed;
        }
        if search.tell(observe) {
            return Inner::Stopped;
        }
        let left = anchor.left(&search.point.lambda, &search.judge.gap);
        let mut next = search.next_states_of(&states, &left, own);
        let (now, then) = (State::keys(&states), State::keys(&next));
        let turns = State::turning(&states, &setup.admissible) > 0.0;
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
fn anchored_step(
    search: &mut Search<'_>,
    states: &[State],
    anchor: Anchor<'_>,
    own: &[f64],
) -> bool {
    let mut system = System::of(search.setup, states, Some(anchor), own);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance, DualProblem, Friction};
    use crate::linalg::Mat;
    use crate::solve::Iterate;
    use crate::solve::tests::{apart, definite, of, silent};
    use std::ops::ControlFlow;

    fn nodes(coefficient: f64) -> DualProblem {
        let block = Friction::Coulomb { coefficient }.block(1);
        let shift = [1.0, 0.9, 0.8, -0.4, 0.7, 0.1];
        of(
            Compliance::Dense(definite(6)),
            &shift,
            vec![block; 3],
            (&[], &[]),
        )
    }

    #[test]
    fn error_of_the_law_is_the_largest_change_that_gaps_ask_for() {
        let f = Mat::from_fn(5, 5, |i, j| {
            if i == j {
                [1.0, 2.0, 0.5, 4.0, 4.0][i]
            } else {
                0.0
            }
        });
        let coulomb = Friction::Coulomb { coefficient: 0.5 }.block(1);
        let blocks = vec![
            Block::Free { size: 1 },
            Block::Unilateral,
            Block::Unilateral,
            coulomb,
        ];
        let problem = of(Compliance::Dense(f), &[1.0; 5], blocks, (&[], &[]));
        let setup = Setup::new(&problem).unwrap();
        let error = |lambda: [f64; 5], gap: [f64; 5]| law_error(&setup, &lambda, &gap);
        let rest = [1.0, 1.0, 0.0, 2.0, 0.5];
        assert_eq!(error(rest, [0.0; 5]), 0.0);
        // a tie in either direction; a length over its compliance is a force
        assert_eq!(error(rest, [-0.25, 0.0, 0.0, 0.0, 0.0]), 0.25);
        assert_eq!(error(rest, [0.25, 0.0, 0.0, 0.0, 0.0]), 0.25);
        // a contact loses no more than its force, an open one has nothing to lose
        assert_eq!(error(rest, [0.0, 1.0, 0.0, 0.0, 0.0]), 0.5);
        assert_eq!(error(rest, [0.0, 9.0, 0.0, 0.0, 0.0]), 1.0);
        assert_eq!(error(rest, [0.0, 0.0, 9.0, 0.0, 0.0]), 0.0);
        assert_eq!(error(rest, [0.0, 0.0, -0.25, 0.0, 0.0]), 0.5);
        // the shear is held to its bound 1: trial 0.5 + 0.25, then beyond
        assert_eq!(error(rest, [0.0, 0.0, 0.0, 0.0, -1.0]), 0.25);
        assert_eq!(error(rest, [0.0, 0.0, 0.0, 0.0, -40.0]), 0.5);
    }

    #[test]
    fn centres_lead_to_the_forces_of_the_law() {
        for coefficient in [0.2, 0.6] {
            let problem = nodes(coefficient);
            let setup = Setup::new(&problem).unwrap();
            let mut search = Search::new((1e-9, 200), &setup);
            search.judge();
            let (closed, mut kinds) = (search.all_closed(), String::new());
            let mut observe = |at: &Iterate<'_>| {
                assert_eq!(at.iteration, kinds.len() + 1);
                kinds.push(at.step);
                ControlFlow::Continue(())
            };
            let ended = settle(&mut search, closed, &mut observe);
            assert!(matches!(ended, Ended::Converged));
            assert!(kinds.starts_with('p') && kinds.len() <= 20, "{kinds}");
            let lambda = &search.point.lambda;
            let gap = problem.gap(&setup.multipliers(lambda, &[]));
            for (n, t) in [(0, 1), (2, 3), (4, 5)] {
                let (pressed, shear) = (lambda[n], lambda[t]);
                assert!(pressed >= 0.0 && gap[n] > -1e-8 && (pressed * gap[n]).abs() < 1e-8);
                assert!(shear.abs() <= coefficient * pressed + 1e-8);
                // a slipping node slips along its shear; a node below its bound does not slip
                let slip = -gap[t];
                assert!(slip * shear >= -1e-8);
                let spare = coefficient * pressed - shear.abs();
                assert!((spare * slip).abs() < 1e-7, "{spare} {slip}");
            }
        }
    }

    #[test]
    fn steps_keep_to_their_limits_and_to_the_observer() {
        let problem = nodes(0.2);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-9, 2), &setup);
        search.judge();
        let closed = search.all_closed();
        assert!(matches!(
            settle(&mut search, closed.clone(), &mut silent),
            Ended::Stuck(_)
        ));
        assert_eq!(search.steps, 2);
        let mut search = Search::new((1e-9, 200), &setup);
        search.judge();
        let mut satisfied = |_: &Iterate<'_>| ControlFlow::Break(());
        assert!(matches!(
            settle(&mut search, closed, &mut satisfied),
            Ended::Stopped
        ));
        assert_eq!(search.steps, 1);
    }

    #[test]
    fn anchored_step_solves_its_conditions_and_counts() {
        let problem = nodes(0.6);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-9, 200), &setup);
        let (centre, compliance) = ([0.3; 6], [0.5; 6]);
        let anchor = Anchor {
            centre: &centre,
            compliance: &compliance,
        };
        let closed = search.all_closed();
        assert!(anchored_step(
            &mut search,
            &closed,
            anchor,
            &problem.softness
        ));
        assert_eq!((search.steps, search.kind), (1, 'p'));
        let left = anchor.left(&search.point.lambda, &search.judge.gap);
        assert!(apart(&left, &[0.0; 6]) < 1e-13);
        assert!(search.residual.is_finite() && search.best.0 == search.residual);
    }

    #[test]
    fn newton_steps_of_a_centre_end_where_its_law_holds_to_the_accuracy() {
        let problem = nodes(0.2);
        let setup = Setup::new(&problem).unwrap();
        let (centre, compliance) = ([0.0; 6], [0.5; 6]);
        let anchor = Anchor {
            centre: &centre,
            compliance: &compliance,
        };
        let steps = |accuracy: f64| {
            let mut search = Search::new((1e-9, 200), &setup);
            let closed = search.all_closed();
            let inner = anchored(
                &mut search,
                closed,
                (anchor, &problem.softness),
                accuracy,
                &mut silent,
            );
            assert!(matches!(inner, Inner::Settled(_)));
            let left = anchor.left(&search.point.lambda, &search.judge.gap);
            let force = largest(0.0, &search.point.lambda);
            (
                search.steps,
                law_error(&setup, &search.point.lambda, &left) / force,
            )
        };
        let (rough, error) = steps(10.0);
        assert_eq!(rough, 1);
        let (exact, none) = steps(1e-12);
        assert!(
            exact > 1 && none < 1e-12 && error > 1e-3,
            "{exact} {none} {error}"
        );
    }
}
