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

/// Squares of differences below this part of the squares of the forces are not judged: below 1e-6 of λ the quotient of
/// differences loses too many digits.
const TOO_NEAR: f64 = 1e-12;

/// A Rayleigh quotient exceeds a bound by this factor at least: else it is rounding of the differences.
const EXCEEDS: f64 = 1.000_001;

/// Advice where a method did not converge.
const ADVICE: &str = "allow more iterations, or use newton";

/// A method: its state and its step.
pub(crate) trait Iteration {
    /// Number of the first point: 1 where it is a step away from the start already.
    const FIRST: usize = 0;

    /// Finds Fλ and α̂ at the present forces.
    fn evaluate(&mut self);

    /// The present point.
    fn point(&self) -> Position<'_>;

    /// Goes to the next forces from the gaps (m,) of the present ones; how many iterations that counts for.
    fn advance(&mut self, gap: &[f64]) -> usize;

    /// The residual of the forces that would be returned, where `estimate` is only an estimate; `None` where computing it is not
    /// worth while. `last`: there is no further step.
    fn verdict(&mut self, estimate: f64, _judge: &mut Judge, _last: bool) -> Option<f64> {
        Some(estimate)
    }

    /// ρ, where there is a fixed step.
    fn rho(&self) -> Option<f64> {
        None
    }

    /// Advice where it did not converge.
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
                    method: S::NAME.to_string(),
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

/// The completed outcome of a method that continued with another one.
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
            method: method.to_string(),
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

    /// The forces (m,) nearest to some trial forces; returns their multipliers τ (k,).
    pub fn project(&mut self, trial: impl Fn(usize) -> f64, lambda: &mut [f64]) -> &[f64] {
        for (i, value) in self.trial.iter_mut().enumerate() {
            *value = trial(i);
        }
        self.projector.project(&self.trial, &mut self.tau, lambda);
        &self.tau
    }
}

/// The Rayleigh quotient of x − y over the chosen components if (x − y)ᵀF(x − y) exceeds `bound`‖x − y‖²; differences that are
/// rounding are not judged.
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
    (length > TOO_NEAR * size && energy > EXCEEDS * bound * length).then(|| energy / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance, DualProblem};
    use crate::linalg::Mat;
    use crate::solve::Gradient;
    use crate::solve::tests::{of, silent};

    /// One contact with F = 1 and d = 1: the answer is the force 1.
    fn one() -> DualProblem {
        let f = Mat::from_fn(1, 1, |_, _| 1.0);
        of(
            Compliance::Dense(f),
            &[1.0],
            vec![Block::Unilateral],
            (&[], &[]),
        )
    }

    /// Forces that are read from a list.
    struct Told<'a> {
        setup: &'a Setup<'a>,
        list: Vec<f64>,
        next: usize,
        at: Forces,
        /// The verdict from the estimate.
        verdict: fn(f64, bool) -> Option<f64>,
    }

    impl<'a> Told<'a> {
        fn new(setup: &'a Setup<'a>, list: &[f64]) -> Self {
            Self {
                setup,
                list: list.to_vec(),
                next: 0,
                at: Forces::none(setup),
                verdict: |estimate, _| Some(estimate),
            }
        }
    }

    impl Iteration for Told<'_> {
        fn evaluate(&mut self) {
            self.at.lambda[0] = self.list[self.next.min(self.list.len() - 1)];
            self.at.product[0] = self.at.lambda[0];
            self.next += 1;
        }

        fn point(&self) -> Position<'_> {
            self.at.at(self.setup, 'x')
        }

        fn advance(&mut self, gap: &[f64]) -> usize {
            assert_eq!(gap[0], self.at.lambda[0] - 1.0);
            1
        }

        fn verdict(&mut self, estimate: f64, _: &mut Judge, last: bool) -> Option<f64> {
            (self.verdict)(estimate, last)
        }

        fn rho(&self) -> Option<f64> {
            Some(0.125)
        }

        fn advice(&self) -> String {
            "read another list".to_string()
        }
    }

    fn limits(max_iterations: usize) -> Gradient {
        Gradient {
            max_iterations,
            ..Gradient::default()
        }
    }

    #[test]
    fn start_that_is_the_answer_takes_no_iteration_and_is_not_shown() {
        let problem = one();
        let setup = Setup::new(&problem).unwrap();
        let mut told = Told::new(&setup, &[1.0]);
        let mut observe = |_: &Iterate<'_>| panic!("the start is no iterate");
        let outcome = iterate(&limits(5), &setup, &mut told, 3, &mut observe).unwrap();
        assert_eq!(outcome.iterations, 3);
        assert_eq!(outcome.multipliers.lambda, [1.0]);
        assert_eq!(outcome.rho, Some(0.125));
    }

    #[test]
    fn iterates_are_shown_with_their_numbers_until_one_passes() {
        let problem = one();
        let setup = Setup::new(&problem).unwrap();
        let mut told = Told::new(&setup, &[0.0, 3.0, 2.0, 1.0, 5.0]);
        let mut shown = Vec::new();
        let mut observe = |at: &Iterate<'_>| {
            assert_eq!((at.step, at.active), ('x', 1));
            shown.push((at.iteration, at.lambda[0]));
            ControlFlow::Continue(())
        };
        let outcome = iterate(&limits(50), &setup, &mut told, 10, &mut observe).unwrap();
        assert_eq!(shown, [(11, 3.0), (12, 2.0), (13, 1.0)]);
        assert_eq!(outcome.iterations, 13);
        assert!(!outcome.stopped_by_observer);
    }

    #[test]
    fn most_iterations_end_with_the_last_iterate_its_residual_and_advice() {
        let problem = one();
        let setup = Setup::new(&problem).unwrap();
        let mut told = Told::new(&setup, &[0.0, 3.0, 2.0, 5.0]);
        let error = iterate(&limits(2), &setup, &mut told, 0, &mut silent).unwrap_err();
        let SolveError::NotConverged {
            method,
            outcome,
            residual,
            reason,
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!(
            (method.as_str(), reason.as_str()),
            ("gradient", "read another list")
        );
        assert_eq!(
            (outcome.iterations, outcome.multipliers.lambda[0]),
            (2, 2.0)
        );
        assert!((residual - problem.kkt_residual(&outcome.multipliers)).abs() < 1e-15);
    }

    #[test]
    fn satisfied_observer_ends_with_the_iterate_that_it_saw() {
        let problem = one();
        let setup = Setup::new(&problem).unwrap();
        let mut told = Told::new(&setup, &[0.0, 3.0, 2.0, 5.0]);
        let mut observe = |at: &Iterate<'_>| match at.iteration {
            2 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let outcome = iterate(&limits(50), &setup, &mut told, 0, &mut observe).unwrap();
        assert!(outcome.stopped_by_observer);
        assert_eq!(
            (outcome.iterations, outcome.multipliers.lambda[0]),
            (2, 2.0)
        );
    }

    #[test]
    fn verdict_decides_in_place_of_the_estimate() {
        let problem = one();
        let setup = Setup::new(&problem).unwrap();
        // not computed: goes on although the estimate passes
        let mut told = Told::new(&setup, &[1.0]);
        told.verdict = |_, last| last.then_some(0.5);
        let error = iterate(&limits(3), &setup, &mut told, 0, &mut silent).unwrap_err();
        let SolveError::NotConverged { residual, .. } = error else {
            panic!("{error}");
        };
        assert_eq!((told.next, residual), (4, 0.5));
        // passes although the estimate does not
        let mut told = Told::new(&setup, &[7.0]);
        told.verdict = |_, _| Some(1e-8);
        assert!(iterate(&limits(3), &setup, &mut told, 0, &mut silent).is_ok());
        assert_eq!(told.next, 1);
        told.verdict = |_, _| Some(1.1e-8);
        assert!(iterate(&limits(3), &setup, &mut told, 0, &mut silent).is_err());
    }

    #[test]
    fn forces_a_million_million_times_those_of_the_first_step_have_diverged() {
        let problem = one();
        let setup = Setup::new(&problem).unwrap();
        let ends = |list: &[f64]| {
            let mut told = Told::new(&setup, list);
            let result = iterate(&limits(20), &setup, &mut told, 0, &mut silent);
            (result.is_ok(), told.next)
        };
        // the start does not count: its force may be zero
        assert_eq!(ends(&[1e-20, 2.0, 1.99e12, 1.0]), (true, 4));
        assert_eq!(ends(&[1e-20, 2.0, -2.01e12, 1.0]), (false, 3));
        assert_eq!(ends(&[0.0, 2.0, 2.01e12, 1.0]), (false, 3));
        assert_eq!(ends(&[0.0, f64::NAN, 1.0]), (false, 2));
        assert_eq!(ends(&[0.0, f64::INFINITY, 1.0]), (false, 2));
    }

    #[test]
    fn observer_of_a_second_method_counts_on() {
        let mut seen = Vec::new();
        let mut observe = |at: &Iterate<'_>| {
            seen.push((at.iteration, at.active, at.step));
            match at.iteration < 9 {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        };
        let mut after = counting_from(6, &mut observe);
        let at = |iteration| Iterate {
            iteration,
            lambda: &[],
            residual: 0.0,
            active: 4,
            step: 'c',
        };
        assert_eq!(after(&at(2)), ControlFlow::Continue(()));
        assert_eq!(after(&at(3)), ControlFlow::Break(()));
        drop(after);
        assert_eq!(seen, [(8, 4, 'c'), (9, 4, 'c')]);
    }

    #[test]
    fn result_of_another_method_is_completed_whether_it_converged_or_not() {
        let outcome = || {
            let multipliers = Multipliers {
                lambda: vec![1.0],
                alpha: Vec::new(),
            };
            Outcome::new(multipliers, 0)
        };
        let more = |outcome: Outcome| Outcome {
            iterations: outcome.iterations + 5,
            ..outcome
        };
        let ok = completed("own", Ok(outcome()), more).unwrap();
        assert_eq!(ok.iterations, 5);
        let error = SolveError::NotConverged {
            method: "other".to_string(),
            outcome: Box::new(outcome()),
            residual: 0.25,
            reason: "why".to_string(),
        };
        let expected = SolveError::NotConverged {
            method: "own".to_string(),
            outcome: Box::new(more(outcome())),
            residual: 0.25,
            reason: "why".to_string(),
        };
        assert_eq!(completed("own", Err(error), more), Err(expected));
        let invalid = SolveError::Invalid("no".to_string());
        assert_eq!(completed("own", Err(invalid.clone()), more), Err(invalid));
    }

    #[test]
    fn given_step_must_be_a_positive_number() {
        for rho in [None, Some(1e-300), Some(2.0)] {
            assert_eq!(FixedStep::check(rho), Ok(()));
        }
        for rho in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = FixedStep::check(Some(rho)).unwrap_err().to_string();
            assert!(error.contains(&format!("rho is {rho}:")), "{error}");
        }
    }

    #[test]
    fn automatic_step_shortens_where_iterates_show_a_larger_eigenvalue() {
        let problem = one();
        let setup = Setup::new(&problem).unwrap();
        let none = Forces::none(&setup);
        // moved by 2, the product by 2 · 6
        let mut now = none.clone();
        (now.lambda[0], now.product[0]) = (2.0, 12.0);
        let mut step = FixedStep::new(None, || 4.0);
        assert_eq!(step.rho, 1.9 / 4.0);
        step.adapt(&now, &none, |_| false);
        assert_eq!(step.rho, 1.9 / 4.0);
        step.adapt(&now, &none, |_| true);
        assert!((step.rho - 1.9 / (1.05 * 6.0)).abs() < 1e-15);
        let shortened = step.rho;
        step.adapt(&now, &none, |_| true);
        assert_eq!(step.rho, shortened);
        let mut given = FixedStep::new(Some(0.7), || panic!("no bound is needed"));
        given.adapt(&now, &none, |_| true);
        assert_eq!(given.rho, 0.7);
    }

    #[test]
    fn advice_says_on_which_side_of_its_limit_a_given_step_is() {
        let advice = |rho: f64| FixedStep::new(Some(rho), || 0.0).advice(|| 4.0);
        let limit = "2/λ_max = 5.000000e-1";
        let beyond = format!("rho = 5.000000e-1 is beyond {limit}");
        assert!(advice(0.5).starts_with(&beyond), "{}", advice(0.5));
        let below = format!("rho = 4.900000e-1 is below {limit}");
        assert!(advice(0.49).starts_with(&below), "{}", advice(0.49));
        let automatic = FixedStep::new(None, || 4.0);
        let words = automatic.advice(|| panic!("no limit is told"));
        assert_eq!(words, "allow more iterations, or use newton");
    }

    #[test]
    fn rayleigh_quotient_counts_beyond_its_bound_and_beyond_rounding() {
        let problem = of(
            Compliance::Dense(Mat::from_fn(2, 2, |i, j| f64::from(i == j))),
            &[1.0, 1.0],
            vec![Block::Unilateral; 2],
            (&[], &[]),
        );
        let setup = Setup::new(&problem).unwrap();
        let at = |lambda: [f64; 2], product: [f64; 2]| Forces {
            lambda: lambda.to_vec(),
            product: product.to_vec(),
            ..Forces::none(&setup)
        };
        let (x, y) = (at([3.0, 1.0], [8.0, 4.0]), at([1.0, 0.0], [2.0, 1.0]));
        // (2·6 + 1·3)/(4 + 1)
        let all = |bound| steeper_than(bound, &x, &y, |_| true);
        assert_eq!(all(2.9), Some(3.0));
        assert_eq!(all(3.0 / 1.000_000_9), None);
        assert_eq!(all(3.0 / 1.000_001_1), Some(3.0));
        // the energy of all, the length of those that count
        assert_eq!(steeper_than(2.9, &x, &y, |i| i == 0), Some(15.0 / 4.0));
        // a difference of 1e-6 of the forces is not judged
        let moved = |by: f64| at([1.0 + by, 0.0], [2.0 + 9.0 * by, 1.0]);
        assert_eq!(steeper_than(1.0, &moved(0.9e-6), &y, |_| true), None);
        assert!(steeper_than(1.0, &moved(1.1e-6), &y, |_| true).is_some());
    }

    #[test]
    fn projected_step_is_that_of_the_gaps_with_its_amplitudes() {
        let f = crate::solve::tests::definite(3);
        let modes = [vec![1.0, 2.0, 0.5]];
        let problem = of(
            Compliance::Dense(f),
            &[2.0, -1.0, 0.3],
            vec![Block::Unilateral; 3],
            (&modes, &[4.0]),
        );
        let setup = Setup::new(&problem).unwrap();
        let guess = Multipliers {
            lambda: vec![3.0, -2.0, 1.0],
            alpha: vec![0.0],
        };
        let carried =
            |lambda: &[f64]| -> f64 { lambda.iter().zip(&modes[0]).map(|(l, g)| l * g).sum() };
        let (mut projection, mut at) = Projection::start(&setup, Some(&guess)).unwrap();
        assert!((carried(&at.lambda) - 4.0).abs() < 1e-12);
        // the nearest force: its change is along the mode, but for the component held at zero
        assert_eq!(at.lambda[1], 0.0);
        let moved = [at.lambda[0] - 3.0, at.lambda[2] - 1.0];
        assert!((moved[0] - 2.0 * moved[1]).abs() < 1e-12, "{moved:?}");
        let lambda = at.lambda.clone();
        setup.multiply(&lambda, &mut at.product);
        let mut next = vec![0.0; 3];
        projection.descend(&setup, 0.3, &mut at, &mut next);
        let multipliers = setup.multipliers(&lambda, &at.alpha);
        let gap = problem.gap(&multipliers);
        for i in 0..3 {
            let expected = (lambda[i] - 0.3 * gap[i]).max(0.0);
            assert!((next[i] - expected).abs() < 1e-12, "{i}");
        }
        assert!((carried(&next) - 4.0).abs() < 1e-12);
    }
}
