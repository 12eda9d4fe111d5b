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
//! force within the law can, are doubled until they do. The inner accuracy follows the outer one; what counts at the end is
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
const PATIENCE: usize = 12;

/// Most doublings of bounds that cannot carry the load.
const DOUBLINGS: usize = 60;

/// Least part of the way from bounds to the next.
const LEAST_PART: f64 = 0.125;

/// Accuracy of the first problem, and the least of all: bounds that are far off need no better forces.
const ROUGH: f64 = 1e-3;

/// Accuracy of a problem in parts of the residual of the law: its own error is nothing beside that of the bounds.
const FOLLOWING: f64 = 1e-3;

/// Changes of the bounds above this multiple of the accuracy of the problems tell the contraction.
const TELLING: f64 = 100.0;

/// Changes of the bounds below this part of the largest force say nothing of the contraction.
const ROUNDING: f64 = 1e-11;

/// Solves the problem of `setup`, whose bounds follow from normal forces, by `method` for given bounds.
///
/// Errors: those of `method`; `NotConverged` when the bounds do not settle.
pub(crate) fn fixed_point<S: FixedBounds>(
    method: &S,
    setup: &Setup<'_>,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let mut search = Search::new(method, setup);
    let mut bounds = match guess {
        Some(guess) => {
            setup.start(Some(guess))?;
            search.last = Some(Outcome::unsolved(guess.clone()));
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
        if search.still >= PATIENCE || !search.residual.is_finite() {
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
struct Search<'a, S> {
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
    /// The part of the way to the next bounds that is gone: a map that does not contract may still when it is less than all.
    part: f64,
    contraction: Option<f64>,
}

impl<'a, S: FixedBounds> Search<'a, S> {
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

    /// Keeps what a problem with given bounds gave; the outcome of all of them.
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

    /// Counts rounds without progress, and estimates the contraction from changes that are more than inaccuracy.
    fn compare(&mut self, bounds: &[f64], next: &[f64], accuracy: f64) {
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let change = largest(&mut bounds.iter().zip(next).map(|(a, b)| (a - b).abs()));
        let size = largest(&mut next.iter().copied());
        let told = change > (TELLING * accuracy * size).max(ROUNDING * size);
        if let Some(before) = self.change
            && (told || self.contraction.is_none() && change > ROUNDING * size)
        {
            // the factor is that of the whole way
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
            method: S::NAME,
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
