//! Bounds of friction that follow from normal forces, as those of Coulomb's law do, by a fixed point: solve with given bounds,
//! set the bounds to those that follow from the answer, repeat.
//!
//! ```text
//!   boundₖ₊₁ = bound(λₙ),   λ the solution of the convex problem whose bounds are boundₖ
//! ```
//!
//! Generic over the method that solves with given bounds. It begins with the bounds of the starting point, or of the
//! solution in which every pressed contact sticks. The map contracts for small coefficients; the observed factor is
//! reported, because it speaks for or against a unique solution. Bounds that cannot carry the load, although some
//! force within the law can, are doubled until they do. The inner accuracy follows the outer one; the final criterion is
//! the residual of the law itself.
//!
//! As described in Nečas, Jarušek & Haslinger (1980).

use crate::dual::{Feasibility, Multipliers};
use crate::solve::iteration::{completed, counting_from};
use crate::solve::setup::{Forces, Setup};
use crate::solve::{FixedBounds, FixedPoint, Observer, Outcome, SolveError};

/// Most problems with given bounds.
const ROUNDS: usize = 200;

/// Rounds without a smaller change of the bounds that end the iteration.
const BOUND_PATIENCE: usize = 12;

/// Most doublings of bounds that cannot carry the load.
const DOUBLINGS: usize = 60;

/// Least part of the way from bounds to the next.
const LEAST_PART: f64 = 0.125;

/// Accuracy of the first problem, the lowest of all: bounds that are far off need no better forces.
const ROUGH: f64 = 1e-3;

/// Accuracy of a problem as a part of the residual of the law: its own error is then negligible beside that of the bounds.
const FOLLOWING: f64 = 1e-3;

/// Changes of the bounds above this multiple of the accuracy of the problems serve to estimate the contraction.
const TELLING: f64 = 100.0;

/// Changes of the bounds below this part of the largest force do not serve to estimate the contraction.
const BOUND_ROUNDING: f64 = 1e-11;

/// Solves the problem of `setup`, whose bounds follow from normal forces, by `method` for given bounds.
///
/// Errors: those of `method`; `NotConverged` when the bounds do not settle.
pub(crate) fn fixed_point<S: FixedBounds>(
    method: &S,
    setup: &Setup<'_>,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let mut search = BoundSearch::new(method, setup);
    let mut bounds = match guess {
        Some(guess) => {
            setup.start(Some(guess))?;
            search.last = Some(Outcome::new(guess.clone(), 0));
            setup.admissible.bounds(&guess.lambda)
        }
        None => Vec::new(),
    };
    if guess.is_none() || !carry(setup, &bounds) {
        let sticking = setup.with_admissible(setup.admissible.sticking());
        if let Some(outcome) = search.solve(&sticking, ROUGH, observe)? {
            return Ok(outcome);
        }
        bounds = search.bounds();
    }
    for _ in 0..ROUNDS {
        for _ in 0..DOUBLINGS {
            if carry(setup, &bounds) {
                break;
            }
            bounds.iter_mut().for_each(|bound| *bound *= 2.0);
        }
        let given = setup.with_admissible(setup.admissible.with_bounds(&bounds));
        let accuracy = (FOLLOWING * search.residual).clamp(0.3 * search.tolerance, ROUGH);
        if let Some(outcome) = search.solve(&given, accuracy, observe)? {
            return Ok(outcome);
        }
        search.rounds += 1;
        let next = search.bounds();
        search.compare(&bounds, &next, accuracy);
        search.judge();
        if search.residual <= search.tolerance {
            return Ok(search.outcome(false));
        }
        if search.still >= BOUND_PATIENCE || !search.residual.is_finite() {
            break;
        }
        for (bound, next) in bounds.iter_mut().zip(next) {
            *bound += search.part * (next - *bound);
        }
    }
    Err(search.not_converged())
}

/// Whether normal forces with these friction bounds balance the load.
pub(crate) fn carry(setup: &Setup<'_>, bounds: &[f64]) -> bool {
    if setup.modes() == 0 {
        return true;
    }
    let given = setup.admissible.with_bounds(bounds);
    let (balance, force) = (&setup.problem.balance, setup.problem.scales.force);
    matches!(
        Feasibility::of(&given, balance, force),
        Feasibility::Feasible { .. }
    )
}

/// The iteration and its history.
struct BoundSearch<'a, S> {
    method: &'a S,
    setup: &'a Setup<'a>,
    tolerance: f64,
    last: Option<Outcome>,
    residual: f64,
    iterations: usize,
    rounds: usize,
    /// Change of the bounds in the last round, and their smallest change.
    change: Option<f64>,
    smallest: f64,
    still: usize,
    /// Relaxation: the part of the step to the next bounds that is taken. A map that does not contract may do so with less than 1.
    part: f64,
    contraction: Option<f64>,
}

impl<'a, S: FixedBounds> BoundSearch<'a, S> {
    fn new(method: &'a S, setup: &'a Setup<'a>) -> Self {
        Self {
            method,
            setup,
            tolerance: method.limits().0,
            last: None,
            residual: f64::INFINITY,
            iterations: 0,
            rounds: 0,
            change: None,
            smallest: f64::INFINITY,
            still: 0,
            part: 1.0,
            contraction: None,
        }
    }

    /// Solves with given bounds from the last answer; an outcome when the observer is satisfied.
    fn solve(
        &mut self,
        given: &Setup<'_>,
        accuracy: f64,
        observe: Observer<'_>,
    ) -> Result<Option<Outcome>, SolveError> {
        let done = self.iterations;
        let left = self.method.limits().1.saturating_sub(done);
        let method = self.method.within(accuracy, left);
        let mut after = counting_from(done, observe);
        let guess = self.last.as_ref().map(|last| last.multipliers.clone());
        let result = method.run(given, guess.as_ref(), &mut after);
        let outcome = completed(S::NAME, result, |outcome| self.keep(outcome))?;
        Ok(outcome.stopped_by_observer.then_some(outcome))
    }

    /// Keeps the outcome of a problem with given bounds; returns the outcome of all of them.
    fn keep(&mut self, outcome: Outcome) -> Outcome {
        self.iterations += outcome.iterations;
        let stopped = outcome.stopped_by_observer;
        self.last = Some(outcome);
        self.outcome(stopped)
    }

    /// Bounds that follow from the last answer.
    fn bounds(&self) -> Vec<f64> {
        let none = Vec::new();
        let last = self.last.as_ref();
        let lambda = last.map_or(&none, |last| &last.multipliers.lambda);
        self.setup.admissible.bounds(lambda)
    }

    /// Residual of the law itself at the last answer.
    fn judge(&mut self) {
        if let Some(last) = &self.last {
            self.residual = self.setup.problem.kkt_residual(&last.multipliers);
            self.setup.count(1);
        }
    }

    /// Counts rounds without progress, and estimates the contraction from changes larger than the inaccuracy.
    fn compare(&mut self, bounds: &[f64], next: &[f64], accuracy: f64) {
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let change = largest(&mut bounds.iter().zip(next).map(|(a, b)| (a - b).abs()));
        let size = largest(&mut next.iter().copied());
        let told = change > (TELLING * accuracy * size).max(BOUND_ROUNDING * size);
        if let Some(before) = self.change
            && (told || self.contraction.is_none() && change > BOUND_ROUNDING * size)
        {
            // the factor is that of full steps
            if self.part == 1.0 {
                self.contraction = Some(change / before);
            }
            if told && change >= before {
                self.part = (0.5 * self.part).max(LEAST_PART);
            }
        }
        let falls = change < self.smallest;
        self.still = if falls { 0 } else { self.still + 1 };
        self.smallest = self.smallest.min(change);
        self.change = told.then_some(change);
    }

    fn outcome(&self, stopped_by_observer: bool) -> Outcome {
        let none = || self.setup.outcome(&Forces::none(self.setup));
        let mut outcome = self.last.clone().unwrap_or_else(none);
        if let Some(factor) = self.contraction.filter(|factor| *factor >= 1.0) {
            outcome.remarks.push(format!(
                "the bounds of friction did not contract (factor {factor:.2}): a solution may not be unique"
            ));
        }
        Outcome {
            iterations: self.iterations,
            products: self.setup.products(),
            exact: false,
            stopped_by_observer,
            fixed_point: Some(FixedPoint {
                iterations: self.rounds,
                contraction: self.contraction,
            }),
            ..outcome
        }
    }

    fn not_converged(&self) -> SolveError {
        let factor = match self.contraction {
            Some(factor) => format!(" (factor {factor:.2} in the last round)"),
            None => String::new(),
        };
        SolveError::NotConverged {
            method: S::NAME.to_string(),
            outcome: Box::new(self.outcome(false)),
            residual: self.residual,
            reason: format!(
                "the bounds of friction did not settle in {} rounds{factor}: a solution may not be unique; \
                 try smaller coefficients or smaller load steps",
                self.rounds
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Compliance, DualProblem, Friction};
    use crate::linalg::Mat;
    use crate::solve::tests::{apart, of, silent};
    use crate::solve::{Iterate, Newton};
    use std::ops::ControlFlow;

    /// One node that is pressed and drawn aside so far that it slips; `turn` couples its two directions.
    fn node(turn: f64, coefficient: f64) -> DualProblem {
        let f = Mat::from_fn(2, 2, |i, j| [[1.0, turn], [turn, 1.0]][i][j]);
        let block = Friction::Coulomb { coefficient }.block(1);
        of(Compliance::Dense(f), &[1.0, 5.0], vec![block], (&[], &[]))
    }

    #[test]
    fn bounds_settle_at_the_forces_of_one_slipping_node_with_the_factor_of_its_map() {
        // λₙ + turn λₜ = 1, λₜ = μ λₙ: bound ↦ μ (1 − turn · bound)
        let (turn, coefficient) = (0.5, 0.4);
        let problem = node(turn, coefficient);
        let setup = Setup::new(&problem).unwrap();
        let outcome = fixed_point(&Newton::default(), &setup, None, &mut silent).unwrap();
        let normal = 1.0 / (1.0 + turn * coefficient);
        let expected = [normal, coefficient * normal];
        assert!(apart(&outcome.multipliers.lambda, &expected) < 1e-8);
        let FixedPoint {
            iterations,
            contraction,
        } = outcome.fixed_point.unwrap();
        assert!((contraction.unwrap() - turn * coefficient).abs() < 1e-3);
        // each round gains a factor of five: 12 rounds for eight digits
        assert!((8..16).contains(&iterations), "{iterations}");
        assert!(outcome.iterations >= iterations && !outcome.exact);
        assert!(outcome.remarks.is_empty());
        assert_eq!(outcome.products, setup.products());
        // started at the answer, one round confirms it
        let again = fixed_point(
            &Newton::default(),
            &setup,
            Some(&outcome.multipliers),
            &mut silent,
        );
        let again = again.unwrap();
        assert_eq!(again.fixed_point.unwrap().iterations, 1);
        assert!(apart(&again.multipliers.lambda, &expected) < 1e-8);
    }

    #[test]
    fn satisfied_observer_and_few_iterations_end_the_rounds() {
        let problem = node(0.5, 0.4);
        let setup = Setup::new(&problem).unwrap();
        let mut seen = Vec::new();
        let mut observe = |at: &Iterate<'_>| {
            seen.push(at.iteration);
            match seen.len() {
                4 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        };
        let outcome = fixed_point(&Newton::default(), &setup, None, &mut observe).unwrap();
        assert!(outcome.stopped_by_observer);
        // numbers go on from problem to problem
        assert_eq!((seen, outcome.iterations), (vec![1, 2, 3, 4], 4));
        let few = Newton::default().within(1e-8, 3);
        let error = fixed_point(&few, &setup, None, &mut silent).unwrap_err();
        let SolveError::NotConverged {
            method, outcome, ..
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!((method.as_str(), outcome.iterations), ("newton", 3));
        let guess = Multipliers {
            lambda: vec![1.0],
            alpha: Vec::new(),
        };
        let wrong = fixed_point(&few, &setup, Some(&guess), &mut silent);
        assert!(matches!(wrong, Err(SolveError::Invalid(_))));
    }

    #[test]
    fn map_that_does_not_contract_is_gone_part_of_the_way_and_told() {
        // factor 1.2: the bounds would swing apart
        let problem = node(0.6, 2.0);
        let setup = Setup::new(&problem).unwrap();
        let normal = 1.0 / (1.0 + 1.2);
        // from nearby: from far away the bounds swing to where the node opens
        let near = Multipliers {
            lambda: vec![1.01 * normal, 2.02 * normal],
            alpha: Vec::new(),
        };
        let outcome = fixed_point(&Newton::default(), &setup, Some(&near), &mut silent).unwrap();
        assert!(apart(&outcome.multipliers.lambda, &[normal, 2.0 * normal]) < 1e-7);
        let factor = outcome.fixed_point.unwrap().contraction.unwrap();
        assert!((factor - 1.2).abs() < 1e-3, "{factor}");
        let expected =
            "the bounds of friction did not contract (factor 1.20): a solution may not be unique";
        assert_eq!(outcome.remarks, [expected]);
    }

    #[test]
    fn changes_of_the_bounds_tell_contraction_progress_and_the_part_of_the_way() {
        let problem = node(0.5, 0.4);
        let setup = Setup::new(&problem).unwrap();
        let method = Newton::default();
        let mut search = BoundSearch::new(&method, &setup);
        let state =
            |search: &BoundSearch<'_, Newton>| (search.contraction, search.part, search.still);
        // the first change gives no factor
        search.compare(&[1.0, 5.0], &[2.0, 9.0], 1e-3);
        assert_eq!(
            (search.change, search.smallest, state(&search)),
            (Some(4.0), 4.0, (None, 1.0, 0))
        );
        search.compare(&[2.0, 8.0], &[2.0, 7.0], 1e-3);
        assert_eq!(
            (search.change, state(&search)),
            (Some(1.0), (Some(0.25), 1.0, 0))
        );
        // a change that is not smaller: half steps from here on, and the factor stands
        search.compare(&[2.0, 8.0], &[2.0, 7.0], 1e-3);
        assert_eq!(state(&search), (Some(1.0), 0.5, 1));
        search.compare(&[2.0, 8.0], &[2.0, 6.0], 1e-3);
        assert_eq!(
            (state(&search), search.smallest),
            ((Some(1.0), 0.25, 2), 1.0)
        );
        search.compare(&[2.0, 8.0], &[2.0, 5.0], 1e-3);
        search.compare(&[2.0, 8.0], &[2.0, 4.0], 1e-3);
        assert_eq!(search.part, LEAST_PART);
        // changes within the inaccuracy of the problems give no factor: 100 · 1e-3 · 8
        search.compare(&[2.0, 8.0], &[2.0, 7.3], 1e-3);
        assert_eq!((search.change, search.still), (None, 0));
        search.compare(&[2.0, 8.0], &[2.0, 7.1], 1e-3);
        assert_eq!(search.change, Some(8.0 - 7.1));
        // nor does rounding of the largest bound, however exact the problems are
        search.compare(&[2.0, 8.0], &[2.0, 8.0 - 7.9e-11], 0.0);
        assert_eq!(search.change, None);
        search.compare(&[2.0, 8.0], &[2.0, 8.0 - 8.1e-11], 0.0);
        assert!(search.change.is_some());
        // without a factor so far a small change gives one, and does not shorten the steps
        let mut search = BoundSearch::new(&method, &setup);
        search.compare(&[8.0], &[6.0], 1e-3);
        search.compare(&[6.0], &[5.9], 1e-3);
        assert_eq!(state(&search).1, 1.0);
        assert!((search.contraction.unwrap() - 0.05).abs() < 1e-12);
        let mut search = BoundSearch::new(&method, &setup);
        search.compare(&[8.0], &[6.0], 1e-3);
        search.compare(&[6.0], &[6.0 - 5e-11], 1e-3);
        assert_eq!(search.contraction, None);
    }

    #[test]
    fn factor_is_told_where_the_bounds_do_not_settle() {
        let problem = node(0.5, 0.4);
        let setup = Setup::new(&problem).unwrap();
        let method = Newton::default();
        let mut search = BoundSearch::new(&method, &setup);
        (search.rounds, search.residual, search.iterations) = (7, 0.25, 9);
        let words = |search: &BoundSearch<'_, Newton>| search.not_converged().to_string();
        assert!(
            words(&search).contains("did not settle in 7 rounds: a solution"),
            "{}",
            words(&search)
        );
        search.contraction = Some(0.994);
        assert!(words(&search).contains("7 rounds (factor 0.99 in the last round)"));
        assert!(search.outcome(false).remarks.is_empty());
        search.contraction = Some(1.0);
        let outcome = search.outcome(true);
        assert_eq!(outcome.remarks.len(), 1);
        assert!(outcome.stopped_by_observer && outcome.iterations == 9);
        assert_eq!(outcome.fixed_point.unwrap().iterations, 7);
        assert_eq!(outcome.multipliers.lambda, [0.0; 2]);
    }

    #[test]
    fn bounds_carry_a_load_aside_that_is_no_more_than_their_sum() {
        let block = Friction::Coulomb { coefficient: 0.4 }.block(1);
        let f = || Compliance::Dense(Mat::from_fn(4, 4, |i, j| f64::from(i == j)));
        let modes = [vec![0.0, 1.0, 0.0, 1.0], vec![1.0, 0.0, 1.0, 0.0]];
        let problem = of(f(), &[1.0; 4], vec![block; 2], (&modes, &[1.0, 5.0]));
        let setup = Setup::new(&problem).unwrap();
        assert!(carry(&setup, &[0.6, 0.41]) && carry(&setup, &[0.0, 1.01]));
        assert!(!carry(&setup, &[0.6, 0.39]) && !carry(&setup, &[0.0, 0.0]));
        let one = of(f(), &[1.0; 4], vec![block; 2], (&modes[..1], &[1.0]));
        let one = Setup::new(&one).unwrap();
        assert!(carry(&one, &[0.6, 0.41]) && !carry(&one, &[0.6, 0.39]));
        // the doubled bounds of a guess that does not press reach the answer
        let guess = Multipliers {
            lambda: vec![0.02, 0.0, 0.02, 0.0],
            alpha: vec![0.0; 2],
        };
        for guess in [Some(&guess), None] {
            let outcome = fixed_point(&Newton::default(), &setup, guess, &mut silent).unwrap();
            assert!(problem.certify(&outcome.multipliers, 1e-7).holds());
            assert!(apart(&outcome.multipliers.lambda, &[2.5, 0.5, 2.5, 0.5]) < 1e-7);
        }
        let held = of(f(), &[1.0; 4], vec![block; 2], (&[], &[]));
        assert!(carry(&Setup::new(&held).unwrap(), &[0.0, 0.0]));
    }
}
