//! Newton's method where bounds of friction follow from normal forces: exact steps, and further stages where these find no
//! answer.
//!
//! Coulomb's law is such a law. Its solution is not the minimum of an energy, so that no energy distinguishes a good step from a
//! bad one. Each stage covers cases that the one before it cannot solve:
//!
//! 1. [`exact`]: guess the state of every node, solve, guess anew. Few steps where friction is moderate and the start is good.
//! 2. [`interior`]: forces of all nodes begin inside the cone of the law and approach its border together. No state is guessed.
//! 3. [`alternate`]: the law of each node and the linear problem of the bodies by turns, with no guess of states at all, until
//!    these settle. Some hundred cheap steps, however many bodies float.
//! 4. [`rest`], where bodies float: exact steps move such a body back and forth while too few contacts hold it. With
//!    bounds that are *given*, those of the best forces so far, the problem is convex and its solution moves the bodies to
//!    where contacts hold them. Exact steps go on from there, and after them [`alternate_rested`].
//! 5. [`settle`]: proximal steps, on a problem to which compliance is added until Newton's iteration ends on it.
//! 6. [`iterate_bounds`]: the convex problem with given bounds, repeated with the bounds that follow from the forces of the
//!    one before. A contraction for small coefficients.
//!
//! Where none has an answer, [`limit`] asks whether friction bears a part of the load only.
//!
//! An answer that does not come from exact steps is sharpened by exact steps ([`sharpen`]).
//!
//! A crowd (`DualProblem::is_crowd`) has the first and the third stage only, or just the third if F is known body by body: the
//! others wander among forces with which bodies clamp each other, or need dense matrices.
//!
//! Stages 4 to 6 begin from the forces of least residual so far: the last ones may have grown without bound.
//!
//! As described in Alart & Curnier (1991) for the steps, Nečas, Jarušek & Haslinger (1980) for the bounds.

use crate::dual::{DualProblem, Multipliers};
use crate::solve::alternating::{alternate, alternate_from};
use crate::solve::anchored::settle;
use crate::solve::coulomb::{carry, fixed_point};
use crate::solve::exact::{
    COARSER, EXACT_STEPS, Ended, INTERIOR, NEAR, NEARBY, Patience, STALLED, Search,
};
use crate::solve::hold::{held, hold};
use crate::solve::interior::interior;
use crate::solve::iteration::{completed, counting_from};
use crate::solve::limit::limit;
use crate::solve::setup::Setup;
use crate::solve::states::State;
use crate::solve::{FixedBounds, Observer, Outcome, SolveError, levels};

/// Exact steps: their residuals may rise on the way.
const EXACT: Patience = Patience::new(14, f64::INFINITY);

/// Most steps of the stages before the last one: if these have no answer after so many steps they find none later, and the last
/// stage, given bounds, needs some hundred of its own.
const SINGLE: usize = 200;

/// Most steps on a coarser problem: no more than a guess is asked for.
const COARSE: usize = 30;

/// Accuracy of the convex problems that determine where floating bodies rest.
const RESTING: f64 = 1e-4;

/// One stage and its name: goes on from states, with what a method for given bounds can do.
type Stage<S> = (
    &'static str,
    fn(&S, &mut Search<'_>, Vec<State>, Observer<'_>) -> Ended,
);

/// The last stage.
const BOUNDS: &str = "bounds that are given";

/// All stages but the last. Crowds have only those that do not wander, and without exact steps where F is known body by body, as
/// there are too many bodies then.
fn stages<S: FixedBounds>(problem: &DualProblem) -> Vec<Stage<S>> {
    let exact: Stage<S> = (EXACT_STEPS, exact);
    let settle: Stage<S> = ("proximal steps", |_, search, states, observe| {
        settle(search, states, observe)
    });
    let alternate: Stage<S> = ("law and bodies by turns", |_, search, states, observe| {
        alternate(search, states, observe)
    });
    let interior: Stage<S> = (INTERIOR, |_, search, states, observe| {
        interior(search, states, observe)
    });
    let rest: Stage<S> = ("exact steps from rest", rest);
    let rested: Stage<S> = ("turns from rest", |_, search, states, observe| {
        alternate_rested(search, states, observe)
    });
    match (problem.is_crowd(), problem.parts.is_empty()) {
        (false, _) => vec![exact, interior, alternate, rest, rested, settle],
        (true, true) => vec![exact, alternate],
        (true, false) => vec![alternate],
    }
}

/// Newton on the problem of `setup`, in which bounds follow from normal forces; `method` is Newton with given bounds.
///
/// Errors: `NotConverged`; `Slides` where a part of the load has an answer, and friction is exhausted there.
pub(crate) fn solve<S: FixedBounds>(
    method: &S,
    setup: &Setup<'_>,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let (mut search, ended) = climb(method, setup, guess, &stages(setup.problem), observe)?;
    match ended {
        Ended::Converged => {
            let stopped = sharpen(&mut search, observe);
            Ok(search.outcome(stopped))
        }
        Ended::Stopped => Ok(search.outcome(true)),
        Ended::Stuck(_) if setup.problem.is_crowd() => Err(search.not_converged(S::NAME, STALLED)),
        Ended::Stuck(_) => {
            let ended = match search.iterations() < method.limits().1 {
                true => iterate_bounds(method, search, observe),
                false => Err(search.not_converged(S::NAME, STALLED)),
            };
            match ended {
                Err(left @ SolveError::NotConverged { .. }) => match limit(method, setup) {
                    Some((direction, factor)) => Err(SolveError::Slides { direction, factor }),
                    None => Err(left),
                },
                ended => ended,
            }
        }
    }
}

/// Tries one stage after the other from a guess, or from a coarser problem.
fn climb<'a, S: FixedBounds>(
    method: &S,
    setup: &'a Setup<'a>,
    guess: Option<&Multipliers>,
    stages: &[Stage<S>],
    observe: Observer<'_>,
) -> Result<(Search<'a>, Ended), SolveError> {
    let (tolerance, most) = method.limits();
    let mut search = Search::new((tolerance, most.min(SINGLE)), setup);
    let coarse = |(tolerance, _), setup: &Setup<'_>, observe: Observer<'_>| {
        coarse(&method.within(tolerance, COARSE.min(most)), setup, observe)
    };
    let mut states = match guess {
        Some(guess) => search.states_of_guess(guess)?,
        None => match levels::start(setup, &coarse) {
            Some(start) => {
                search.tried.push(COARSER);
                search.begin(start)
            }
            None => search.all_closed(),
        },
    };
    hold(setup, &mut states, None);
    let mut ended = Ended::Stuck(states);
    for (name, stage) in stages {
        ended = match ended {
            Ended::Stuck(states) => {
                search.stage(name, |search| stage(method, search, states, observe))
            }
            ended => ended,
        };
    }
    Ok((search, ended))
}

/// The best that a few steps find on a coarser problem.
fn coarse<S: FixedBounds>(
    method: &S,
    setup: &Setup<'_>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let (mut search, _) = climb(method, setup, None, &stages(setup.problem), observe)?;
    search.point = search.best.1.clone();
    Ok(search.outcome(false))
}

/// Exact steps from an answer that other steps found, accepted if they lead to an answer; returns whether they were stopped.
///
/// The tolerance is relative to the largest length of a problem, which may be a clearance that never closes: the gaps that other
/// steps leave may be large beside the motions of a contact that bears. The gaps that exact steps leave are rounding.
fn sharpen(search: &mut Search<'_>, observe: Observer<'_>) -> bool {
    let setup = search.setup;
    if search.kind == 'n' || setup.problem.is_crowd() {
        return false;
    }
    let found = (search.residual, search.kind, search.point.clone());
    let sticking = State::of_all_forces(&setup.admissible, &search.point.lambda);
    let states = search.next_states(&sticking, &search.judge.gap);
    match search.exact(states, &NEAR, &held(setup), observe) {
        Ended::Stopped => true,
        Ended::Converged if search.residual <= found.0 => false,
        Ended::Converged | Ended::Stuck(_) => {
            (search.residual, search.kind, search.point) = found;
            false
        }
    }
}

/// Exact steps in which floating bodies are held.
fn exact<S>(_: &S, search: &mut Search<'_>, states: Vec<State>, observe: Observer<'_>) -> Ended {
    search.exact(states, &EXACT, &held(search.setup), observe)
}

/// Exact steps from where floating bodies rest with given bounds.
fn rest<S: FixedBounds>(
    method: &S,
    search: &mut Search<'_>,
    states: Vec<State>,
    observe: Observer<'_>,
) -> Ended {
    if search.setup.modes() == 0 {
        return Ended::Stuck(states);
    }
    let Some(states) = at_rest(method, search, observe) else {
        return Ended::Stuck(states);
    };
    search.rested = Some((search.point.lambda.clone(), search.judge.gap.clone()));
    search.exact(states, &NEAR, &held(search.setup), observe)
}

/// Alternating directions from where floating bodies rest, if that is known.
fn alternate_rested(search: &mut Search<'_>, states: Vec<State>, observe: Observer<'_>) -> Ended {
    match search.rested.take() {
        Some(start) => alternate_from(search, start, states, observe),
        None => Ended::Stuck(states),
    }
}

/// Solves the convex problem with the bounds of friction of the best forces so far, or no problem where these cannot carry the
/// load; returns the states of its answer, `None` without an answer.
fn at_rest<S: FixedBounds>(
    method: &S,
    search: &mut Search<'_>,
    observe: Observer<'_>,
) -> Option<Vec<State>> {
    let setup = search.setup;
    let best = &search.best.1;
    let guess = setup.multipliers(&best.lambda, &best.alpha);
    let bounds = setup.admissible.bounds(&best.lambda);
    let (admissible, guess) = match carry(setup, &bounds) {
        true => (setup.admissible.with_bounds(&bounds), Some(&guess)),
        false => (setup.admissible.sticking(), None),
    };
    let method = method.within(RESTING, search.most.saturating_sub(search.iterations()));
    let mut after = counting_from(search.iterations(), observe);
    let outcome = match method.run(&setup.with_admissible(admissible), guess, &mut after) {
        Ok(outcome) => outcome,
        // a near answer may be enough
        Err(SolveError::NotConverged { outcome, .. }) => *outcome,
        Err(_) => return None,
    };
    search.steps += outcome.iterations;
    let states = search.states_of_guess(&outcome.multipliers).ok()?;
    search.move_to(search.point.lambda.clone(), search.point.alpha.clone());
    let mut next = search.next_states(&states, &search.judge.gap);
    hold(setup, &mut next, Some(&states));
    Some(next)
}

/// Bounds of friction and the convex problem with these bounds, repeatedly; the best forces of all if that does not converge.
fn iterate_bounds<S: FixedBounds>(
    method: &S,
    mut search: Search<'_>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let setup = search.setup;
    let (residual, point) = &search.best;
    let guess = setup.multipliers(&point.lambda, &point.alpha);
    let guess = residual.is_finite().then_some(&guess);
    let done = search.iterations();
    let mut after = counting_from(done, observe);
    let mut tried = std::mem::take(&mut search.tried);
    tried.push(BOUNDS);
    let (tolerance, most) = method.limits();
    let rest = method.within(tolerance, most.saturating_sub(done));
    let mut result = fixed_point(&rest, setup, guess, &mut after);
    search.go_back();
    if let Err(SolveError::NotConverged {
        outcome, residual, ..
    }) = &mut result
        // a problem whose first system is singular has no iterate
        && (search.residual < residual.min(NEARBY) || !residual.is_finite())
    {
        outcome.multipliers = setup.multipliers(&search.point.lambda, &search.point.alpha);
        *residual = search.residual;
    }
    completed(S::NAME, result, |outcome| Outcome {
        iterations: done + outcome.iterations,
        tried,
        ..outcome
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::Compliance;
    use crate::dual::Friction;
    use crate::linalg::Mat;
    use crate::solve::tests::{apart, definite, of, of_rank, silent};
    use crate::solve::{ContactSolver, Iterate, Newton, norm};
    use std::ops::ControlFlow;

    /// Two nodes in the plane with F = AᵀA + I/100, d, G, e and a coefficient of friction.
    struct Frozen {
        a: &'static [[f64; 4]],
        shift: [f64; 4],
        modes: &'static [[f64; 4]],
        load: &'static [f64],
        coefficient: f64,
    }

    impl Frozen {
        fn problem(&self) -> DualProblem {
            let coefficient = self.coefficient;
            let block = Friction::Coulomb { coefficient }.block(1);
            let balance = (self.modes, self.load);
            of_rank(self.a, &self.shift, vec![block; 2], balance)
        }
    }

    /// Places among the stages.
    const EXACTLY: usize = 0;
    const INSIDE: usize = 1;
    const ALTERNATING: usize = 2;
    const AT_REST: usize = 3;
    const SETTLING: usize = 5;

    fn chosen(places: &[usize]) -> Vec<Stage<Newton>> {
        let all = stages(&LAST.problem());
        places.iter().map(|&place| all[place]).collect()
    }

    /// The stages `before` leave the problem open, the stage `then` behind them ends with a certified answer.
    fn needs(before: &[usize], then: usize, frozen: &Frozen) {
        let (problem, method) = (frozen.problem(), Newton::default());
        let setup = Setup::new(&problem).unwrap();
        let climb =
            |stages: &[Stage<Newton>]| climb(&method, &setup, None, stages, &mut silent).unwrap();
        let (_, open) = climb(&chosen(before));
        assert!(matches!(open, Ended::Stuck(_)), "{before:?} do");
        let (search, ended) = climb(&chosen(&[before, &[then]].concat()));
        assert!(matches!(ended, Ended::Converged), "{then} does not");
        let certificate = problem.certify(&search.outcome(false).multipliers, 1e-8);
        assert!(certificate.holds(), "{certificate}");
    }

    #[test]
    fn exact_steps_find_stick_and_slip() {
        let frozen = Frozen {
            a: &[[1.0, 0.0, 0.2, 0.0], [0.0, 1.0, 0.0, 0.2]],
            shift: [1.0, 0.6, 0.9, 0.1],
            modes: &[],
            load: &[],
            coefficient: 0.3,
        };
        needs(&[], EXACTLY, &frozen);
    }

    /// Both nodes stick; the second one bears a hundred thousandth of the first, so that the tolerance is a hundredth of its force.
    #[test]
    fn answer_within_the_tolerance_is_sharpened_to_rounding() {
        let exact = [1.0, 0.1, 1e-5, 0.0];
        let a = [[1.0, 0.0, 0.2, 0.0], [0.0, 1.0, 0.0, 0.2]];
        let product = |i: usize| {
            let rows = a.iter().map(|row| {
                let image: f64 = row.iter().zip(&exact).map(|(a, l)| a * l).sum();
                row[i] * image
            });
            rows.sum::<f64>() + 0.01 * exact[i]
        };
        let shift = [0, 1, 2, 3].map(product);
        let block = Friction::Coulomb { coefficient: 0.3 }.block(1);
        let problem = of_rank(&a, &shift, vec![block; 2], (&[], &[]));
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new(Newton::default().limits(), &setup);
        let mut near = exact.to_vec();
        near[2] += 2e-8;
        search.move_to(near, Vec::new());
        assert!(search.residual <= search.tolerance, "{}", search.residual);
        let gap = |search: &Search<'_>| {
            search
                .judge
                .gap
                .iter()
                .fold(0.0, |s: f64, g| s.max(g.abs()))
        };
        assert!(gap(&search) > 1e-9, "{}", gap(&search));
        assert!(!sharpen(&mut search, &mut silent));
        assert_eq!((search.kind, search.steps), ('n', 1));
        assert!(gap(&search) < 1e-15, "{}", gap(&search));
        // an exact answer needs no sharpening
        assert!(!sharpen(&mut search, &mut silent));
        assert_eq!(search.steps, 1);
    }

    #[test]
    fn given_bounds_move_a_body_to_where_contacts_hold_it() {
        let frozen = Frozen {
            a: &[[0.4, 0.6, 0.0, -0.1]],
            shift: [-0.9, -0.9, -0.4, 0.2],
            modes: &[[-0.4, -0.1, -0.6, -0.9]],
            load: &[-1.8],
            coefficient: 1.0,
        };
        needs(&[EXACTLY], AT_REST, &frozen);
    }

    #[test]
    fn proximal_steps_end_where_states_run_in_circles() {
        let frozen = Frozen {
            a: &[[-0.1, -0.3, 0.7, -0.4], [0.0, -0.9, 0.7, -0.4]],
            shift: [-0.8, 0.0, -0.9, -0.9],
            modes: &[[-0.8, 0.0, 0.0, 0.3], [0.6, -0.2, 0.4, 0.6]],
            load: &[0.2, 1.3],
            coefficient: 2.0,
        };
        needs(&[EXACTLY, AT_REST], SETTLING, &frozen);
    }

    #[test]
    fn interior_points_end_where_guessed_states_do_not() {
        needs(&[EXACTLY], INSIDE, &LAST);
    }

    #[test]
    fn alternating_directions_end_where_guessed_states_do_not() {
        needs(&[EXACTLY], ALTERNATING, &LAST);
        needs(&[EXACTLY, AT_REST, SETTLING], ALTERNATING, &LAST);
    }

    #[test]
    fn bounds_that_follow_each_other_find_what_guessed_states_do_not_and_steps_are_counted_on() {
        let (problem, method) = (LAST.problem(), Newton::default());
        let setup = Setup::new(&problem).unwrap();
        let mut numbers = Vec::new();
        let mut observe = |at: &Iterate<'_>| {
            numbers.push(at.iteration);
            ControlFlow::Continue(())
        };
        let guessing = chosen(&[EXACTLY, AT_REST, SETTLING]);
        let (search, ended) = climb(&method, &setup, None, &guessing, &mut observe).unwrap();
        assert!(matches!(ended, Ended::Stuck(_)));
        let before = search.iterations();
        let outcome = iterate_bounds(&method, search, &mut observe).unwrap();
        assert!(outcome.fixed_point.is_some());
        assert_eq!(outcome.tried.last(), Some(&BOUNDS));
        assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
        // systems that are singular are no iterates
        assert!(
            numbers.windows(2).all(|pair| pair[1] > pair[0]),
            "{numbers:?}"
        );
        assert_eq!(numbers.last(), Some(&outcome.iterations));
        assert!(outcome.iterations > before);
    }

    /// The problem that no guess of states solves.
    const LAST: Frozen = Frozen {
        a: &[
            [-0.2, 0.7, -1.0, -0.7],
            [-0.4, 0.4, -0.6, 0.9],
            [-0.4, 0.1, -0.7, 0.4],
        ],
        shift: [-0.3, 0.9, -0.3, 1.0],
        modes: &[[-0.2, 0.9, -0.7, 0.3], [-0.2, 0.7, 0.5, -0.8]],
        load: &[0.4, -0.4],
        coefficient: 2.0,
    };

    #[test]
    fn where_the_work_allowed_does_not_do_forces_with_a_residual_come_back() {
        let problem = LAST.problem();
        let setup = Setup::new(&problem).unwrap();
        for most in [1, 2, 3] {
            let method = Newton::default().within(1e-8, most);
            let error = solve(&method, &setup, None, &mut silent).unwrap_err();
            let SolveError::NotConverged {
                method,
                outcome,
                residual,
                ..
            } = error
            else {
                panic!("{error}");
            };
            assert_eq!(method, "newton");
            assert!(
                residual > 1e-8 && residual.is_finite(),
                "{most}: {residual}"
            );
            assert!(outcome.multipliers.lambda.iter().any(|force| *force != 0.0));
        }
        let stopped = solve(&Newton::default(), &setup, None, &mut |_| {
            ControlFlow::Break(())
        });
        let stopped = stopped.unwrap();
        assert!(stopped.stopped_by_observer && stopped.iterations == 1);
    }

    /// Through all stages, the last of which begins after 200 steps, too.
    #[test]
    fn no_more_steps_are_made_than_are_allowed() {
        let circling = Frozen {
            a: &[[0.2, -0.7, 0.1, 0.9], [-0.5, 0.6, 0.3, 0.4]],
            shift: [-0.4, 0.8, 0.6, -0.9],
            modes: &[[0.3, 0.9, -0.6, 0.2]],
            load: &[0.5],
            coefficient: 3.0,
        };
        for frozen in [&LAST, &circling] {
            let problem = frozen.problem();
            let setup = Setup::new(&problem).unwrap();
            for most in (1..60).chain([100, 199, 200, 201, 220, 300]) {
                let method = Newton::default().within(1e-14, most);
                let made = match solve(&method, &setup, None, &mut silent) {
                    Ok(outcome) => outcome.iterations,
                    Err(SolveError::NotConverged { outcome, .. }) => outcome.iterations,
                    Err(other) => panic!("{other}"),
                };
                assert!(made <= most, "{made} steps of {most}");
            }
        }
    }

    #[test]
    fn where_nothing_floats_there_is_nothing_to_be_brought_to_rest() {
        let frozen = Frozen {
            a: &[[1.0, 0.0, 0.2, 0.0], [0.0, 1.0, 0.0, 0.2]],
            shift: [1.0, 0.6, 0.9, 0.1],
            modes: &[],
            load: &[],
            coefficient: 0.3,
        };
        let problem = frozen.problem();
        let setup = Setup::new(&problem).unwrap();
        let method = Newton::default();
        let mut search = Search::new(method.limits(), &setup);
        let states = search.all_closed();
        let ended = rest(&method, &mut search, states.clone(), &mut silent);
        let Ended::Stuck(same) = ended else {
            panic!("no step was to be made");
        };
        assert_eq!((same, search.steps), (states, 0));
    }

    #[test]
    fn coarser_problem_returns_the_least_residual_that_it_found() {
        let (problem, method) = (LAST.problem(), Newton::default());
        let setup = Setup::new(&problem).unwrap();
        let mut least = f64::INFINITY;
        let mut observe = |at: &Iterate<'_>| {
            least = least.min(at.residual);
            ControlFlow::Continue(())
        };
        let outcome = coarse(&method.within(1e-8, COARSE), &setup, &mut observe).unwrap();
        let residual = problem.kkt_residual(&outcome.multipliers);
        // given bounds show residuals of their own problem, which may be less
        assert!(residual >= least && residual.is_finite());
        let (search, _) = climb(
            &method.within(1e-8, COARSE),
            &setup,
            None,
            &stages(&problem),
            &mut silent,
        )
        .unwrap();
        assert!((residual - search.best.0).abs() <= 1e-12 * residual);
    }

    /// λₙ with λₙ + turn · bound(λₙ) = 1.
    fn balanced(law: Friction, turn: f64) -> f64 {
        let (mut low, mut high) = (0.0, 2.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match middle + turn * law.bound(middle) > 1.0 {
                true => high = middle,
                false => low = middle,
            }
        }
        low
    }

    const BENDS: Friction = Friction::Saturating {
        limit: 0.5,
        coefficient: 0.9,
    };

    #[test]
    fn a_node_that_slips_bears_a_bound_that_bends() {
        for turn in [0.4, -0.4] {
            for tangents in [1, 2] {
                let m = 1 + tangents;
                let pull = [1.0, 3.0, 4.0];
                // both tangents turn the normal gap alike: along the slip by |turn|
                let entry = |i: usize, j: usize| match (i, j) {
                    _ if i == j => 1.0,
                    (0, k) | (k, 0) if tangents == 2 => turn * pull[k] / 5.0,
                    (0, _) | (_, 0) => turn,
                    _ => 0.0,
                };
                let f = Mat::from_fn(m, m, entry);
                let problem = of(
                    Compliance::Dense(f),
                    &pull[..m],
                    vec![BENDS.block(tangents)],
                    (&[], &[]),
                );
                let mut residuals = Vec::new();
                let outcome = Newton::default()
                    .solve(&problem, None, &mut |at: &Iterate<'_>| {
                        residuals.push(at.residual);
                        ControlFlow::Continue(())
                    })
                    .unwrap();
                let lambda = &outcome.multipliers.lambda;
                assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
                let normal = lambda[0];
                let shear = norm(&lambda[1..]);
                assert!((shear - BENDS.bound(normal)).abs() < 1e-9, "{shear}");
                if tangents == 1 || turn > 0.0 {
                    assert!((normal - balanced(BENDS, turn)).abs() < 1e-8, "{normal}");
                }
                assert_eq!(outcome.tried, [EXACT_STEPS]);
                assert!(outcome.iterations <= 8);
                // Newton's method: the last residuals are squares of the ones before
                let last = &residuals[residuals.len() - 3..];
                assert!(
                    last[1] < 10.0 * last[0] * last[0] && last[2] < 1e-9,
                    "{residuals:?}"
                );
            }
        }
    }

    #[test]
    fn every_stage_that_serves_answers_a_bound_that_bends() {
        let shift = [1.0, 5.0, 0.8, -3.0, 0.5, 0.05];
        let problem = of(
            Compliance::Dense(definite(6)),
            &shift,
            vec![BENDS.block(1); 3],
            (&[], &[]),
        );
        let method = Newton::default();
        let setup = Setup::new(&problem).unwrap();
        let expected = method.solve(&problem, None, &mut silent).unwrap();
        assert_eq!(expected.tried, [EXACT_STEPS]);
        let expected = expected.multipliers.lambda;
        for place in [EXACTLY, ALTERNATING, SETTLING] {
            let (search, ended) =
                climb(&method, &setup, None, &chosen(&[place]), &mut silent).unwrap();
            assert!(matches!(ended, Ended::Converged), "{place}");
            let found = search.outcome(false).multipliers;
            assert!(problem.certify(&found, 1e-7).holds(), "{place}");
            assert!(apart(&found.lambda, &expected) < 1e-6, "{place}");
        }
        let (_, ended) = climb(&method, &setup, None, &chosen(&[INSIDE]), &mut silent).unwrap();
        assert!(matches!(ended, Ended::Stuck(_)));
        let fixed = fixed_point(&method, &setup, None, &mut silent).unwrap();
        assert!(apart(&fixed.multipliers.lambda, &expected) < 1e-6);
    }

    #[test]
    fn a_body_slides_beyond_the_bounds_of_its_nodes() {
        let f = || Compliance::Dense(Mat::from_fn(4, 4, |i, j| f64::from(i == j)));
        let modes = [vec![0.0, 1.0, 0.0, 1.0], vec![1.0, 0.0, 1.0, 0.0]];
        let most = 2.0 * BENDS.bound(0.5);
        let pulled = |load: f64| {
            of(
                f(),
                &[0.0; 4],
                vec![BENDS.block(1); 2],
                (&modes, &[load, 1.0]),
            )
        };
        let borne = pulled(0.999 * most);
        let answer = Newton::default().solve(&borne, None, &mut silent).unwrap();
        assert!(borne.certify(&answer.multipliers, 1e-8).holds());
        assert!(matches!(
            borne.feasibility(),
            crate::dual::Feasibility::Feasible { .. }
        ));
        let crate::dual::Feasibility::Infeasible { direction, factor } =
            pulled(most / 0.9).feasibility()
        else {
            panic!("it slides");
        };
        // as accurate as the edges of round cones
        assert!((factor.unwrap() - 0.9).abs() < 2e-6, "{factor:?}");
        assert!((direction[0] - 1.0).abs() < 1e-12);
    }
}
