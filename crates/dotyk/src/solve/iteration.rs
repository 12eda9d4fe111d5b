//! The driver of all iterations: a method says how its forces become the next ones, everything else stands here once.
//!
//! ```text
//!   evaluate: Fλ and α̂ at the present λ    →    gap = Fλ − d − Ĝᵀα̂, residual, observer, end?    →    advance: the next λ
//! ```
//!
//! It ends where the residual passes, where the observer is satisfied, after the most iterations, and where numbers are
//! no longer finite or forces grow as those of a step that is too long.

use std::ops::ControlFlow;

use crate::dual::{Multipliers, Projector};
use crate::solve::setup::{Forces, Judge, Position, Setup};
use crate::solve::{FixedBounds, Iterate, Observer, Outcome, SAFE_STEP, SolveError, loaded};

/// Forces beyond this multiple of those of the first step have diverged: a fixed step beyond its limit grows by a factor
/// per iteration.
const DIVERGED: f64 = 1e12;

/// What to do where a method did not converge.
const ADVICE: &str = "allow more iterations, or use newton";

/// A method: its state, and how that goes on.
pub(crate) trait Iteration {
    /// Number of the first point: 1 where it is a step away from the start already.
    const FIRST: usize = 0;

    /// Finds Fλ and α̂ at the present forces.
    fn evaluate(&mut self);

    /// Where it is.
    fn point(&self) -> Position<'_>;

    /// Goes to the next forces from the gaps (m,) of the present ones; how many iterations that counts for.
    fn advance(&mut self, gap: &[f64]) -> usize;

    /// The residual of the forces that would be returned, where the one that was found is an estimate; `None` where it is not
    /// worth asking. `last`: there is no further step.
    fn verdict(&mut self, estimate: f64, _judge: &mut Judge, _last: bool) -> Option<f64> {
        Some(estimate)
    }

    /// ρ, where there is a fixed step.
    fn rho(&self) -> Option<f64> {
        None
    }

    /// What to do where it did not converge.
    fn advice(&self) -> String {
        ADVICE.to_string()
    }
}

/// Runs `iteration` within the limits of `method`; `done` iterations came before.
///
/// Errors: `NotConverged` with the last iterate.
pub(crate) fn iterate<S: FixedBounds, I: Iteration>(
    method: &S,
    setup: &Setup<'_>,
    iteration: &mut I,
    done: usize,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let (tolerance, most) = method.limits();
    let mut judge = setup.judge();
    let mut count = done + I::FIRST;
    let mut ceiling = None;
    loop {
        iteration.evaluate();
        let estimate = judge.residual(setup, &iteration.point());
        let stopped = count > done && tell(observe, count, &iteration.point(), estimate);
        let force = setup.largest_force(&iteration.point().forces.lambda);
        let diverged = !estimate.is_finite() || ceiling.is_some_and(|ceiling| force > ceiling);
        let last = diverged || count >= most;
        let residual = match stopped {
            true => Some(estimate),
            false => iteration.verdict(estimate, &mut judge, last),
        };
        let passes = residual.is_some_and(|residual| residual <= tolerance);
        if stopped || passes || last {
            let outcome = Outcome {
                iterations: count,
                rho: iteration.rho(),
                stopped_by_observer: stopped,
                ..setup.outcome(iteration.point().forces)
            };
            return match stopped || passes {
                true => Ok(outcome),
                false => Err(SolveError::NotConverged {
                    method: S::NAME,
                    outcome: Box::new(outcome),
                    residual: residual.unwrap_or(estimate),
                    reason: iteration.advice(),
                }),
            };
        }
        if count > done {
            ceiling.get_or_insert(DIVERGED * force);
        }
        count += iteration.advance(&judge.gap);
    }
}

/// Tells the observer; `true` when it is satisfied.
pub(crate) fn tell(
    observe: Observer<'_>,
    iteration: usize,
    point: &Position<'_>,
    residual: f64,
) -> bool {
    let lambda = &point.forces.lambda;
    let iterate = Iterate {
        iteration,
        lambda,
        residual,
        active: loaded(lambda),
        step: point.step,
    };
    observe(&iterate) == ControlFlow::Break(())
}

/// An observer of iterations that follow `done` others.
pub(crate) fn counting_from<'a>(
    done: usize,
    observe: Observer<'a>,
) -> impl FnMut(&Iterate<'_>) -> ControlFlow<()> + 'a {
    move |iterate| {
        observe(&Iterate {
            iteration: done + iterate.iteration,
            ..*iterate
        })
    }
}

/// What a method returns that ended in another one: the outcome of that, completed.
pub(crate) fn completed(
    method: &'static str,
    result: Result<Outcome, SolveError>,
    complete: impl FnOnce(Outcome) -> Outcome,
) -> Result<Outcome, SolveError> {
    match result {
        Ok(outcome) => Ok(complete(outcome)),
        Err(SolveError::NotConverged {
            outcome,
            residual,
            reason,
            ..
        }) => Err(SolveError::NotConverged {
            method,
            outcome: Box::new(complete(*outcome)),
            residual,
            reason,
        }),
        Err(error) => Err(error),
    }
}

/// The step ρ of a projected gradient: 1.9/L with an upper bound L of the largest eigenvalue, which grows where two iterates
/// show a larger one; or as it was given.
pub(crate) struct FixedStep {
    /// ρ, force over length.
    pub rho: f64,
    bound: f64,
    given: bool,
}

impl FixedStep {
    /// Errors: a given step that is not a positive number.
    pub fn check(given: Option<f64>) -> Result<(), SolveError> {
        match given {
            Some(rho) if !(rho > 0.0 && rho.is_finite()) => Err(SolveError::Invalid(format!(
                "rho is {rho}: it must be a positive number, or \"auto\""
            ))),
            _ => Ok(()),
        }
    }

    /// The given ρ, or the one of a bound.
    pub fn new(given: Option<f64>, bound: impl FnOnce() -> f64) -> Self {
        let bound = given.map_or_else(bound, |rho| SAFE_STEP / rho);
        Self {
            rho: given.unwrap_or(SAFE_STEP / bound),
            bound,
            given: given.is_some(),
        }
    }

    /// Shortens an automatic step after two iterates, over the components that count.
    pub fn adapt(&mut self, now: &Forces, then: &Forces, counts: impl Fn(usize) -> bool) {
        if self.given {
            return;
        }
        if let Some(quotient) = steeper_than(self.bound, now, then, counts) {
            self.bound = 1.05 * quotient;
            self.rho = SAFE_STEP / self.bound;
        }
    }

    /// Why it failed; `bound` as in [`FixedStep::new`].
    pub fn advice(&self, bound: impl FnOnce() -> f64) -> String {
        if !self.given {
            return ADVICE.to_string();
        }
        let (rho, limit) = (self.rho, 2.0 / bound());
        if rho >= limit {
            format!(
                "rho = {rho:.6e} is beyond 2/λ_max = {limit:.6e}, where a fixed step diverges: choose a smaller rho, or \"auto\""
            )
        } else {
            format!(
                "rho = {rho:.6e} is below 2/λ_max = {limit:.6e}: allow more iterations, a larger rho, or use newton"
            )
        }
    }
}

/// Exact projections of gradient steps onto Λ ∩ {Gλ = e}.
pub(crate) struct Projection<'a> {
    projector: Projector<'a>,
    trial: Vec<f64>,
    tau: Vec<f64>,
}

impl<'a> Projection<'a> {
    /// Begins with the forces that are nearest to those of a guess, or to none.
    ///
    /// Errors: those of [`Setup::start`].
    pub fn start(
        setup: &'a Setup<'_>,
        guess: Option<&Multipliers>,
    ) -> Result<(Self, Forces), SolveError> {
        let start = setup.start(guess)?;
        let mut projection = Self {
            projector: setup.projector(),
            trial: vec![0.0; setup.len()],
            tau: vec![0.0; setup.modes()],
        };
        let mut at = Forces::none(setup);
        projection.project(|i| start[i], &mut at.lambda);
        Ok((projection, at))
    }

    /// The forces (m,) nearest to λ − ρ(Fλ − d), with the amplitudes α̂ = −τ/ρ that pull them to the balance.
    pub fn descend(&mut self, setup: &Setup<'_>, rho: f64, at: &mut Forces, next: &mut [f64]) {
        let trial = |i: usize| at.lambda[i] - rho * (at.product[i] - setup.shift[i]);
        let tau = self.project(trial, next);
        let pairs = at.alpha.iter_mut().zip(tau);
        pairs.for_each(|(alpha, tau)| *alpha = -tau / rho);
    }

    /// The forces (m,) nearest to some trial forces, and what their multipliers pull (k,).
    pub fn project(&mut self, trial: impl Fn(usize) -> f64, lambda: &mut [f64]) -> &[f64] {
        for (i, value) in self.trial.iter_mut().enumerate() {
            *value = trial(i);
        }
        self.projector.project(&self.trial, &mut self.tau, lambda);
        &self.tau
    }
}

/// Whether (x − y)ᵀF(x − y) exceeds `bound`‖x − y‖² over the chosen components, and by which Rayleigh quotient;
/// differences that are rounding are not judged.
pub(crate) fn steeper_than(
    bound: f64,
    x: &Forces,
    y: &Forces,
    counts: impl Fn(usize) -> bool,
) -> Option<f64> {
    let (mut energy, mut length, mut size) = (0.0, 0.0, 0.0);
    for i in 0..x.lambda.len() {
        let step = x.lambda[i] - y.lambda[i];
        energy += step * (x.product[i] - y.product[i]);
        size += x.lambda[i] * x.lambda[i];
        if counts(i) {
            length += step * step;
        }
    }
    // Below 1e-6 of λ the quotient of differences loses too many digits.
    (length > 1e-12 * size && energy > 1.000_001 * bound * length).then(|| energy / length)
}
