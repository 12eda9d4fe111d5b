//! Projected gradient with Nesterov's extrapolation, restarted when the step points against the gradient mapping.
//!
//! ```text
//!   xₖ₊₁ = P(yₖ − (Fyₖ − d)/L),   yₖ₊₁ = xₖ₊₁ + (tₖ − 1)/tₖ₊₁ (xₖ₊₁ − xₖ),   tₖ₊₁ = (1 + √(1 + 4tₖ²))/2
//! ```
//!
//! P is the exact projection onto Λ ∩ {Gλ = e}, L an upper bound of the largest eigenvalue of PFP by Lanczos steps, which
//! grows where a step shows a larger one. Rate √κ where the plain gradient has κ, and no parameter.
//!
//! As described in Beck & Teboulle (2009); the restart as described in O'Donoghue & Candès (2015).

use crate::dual::Multipliers;
use crate::solve::gradient::projected_bound;
use crate::solve::iteration::{Iteration, Projection, iterate, steeper_than};
use crate::solve::setup::{Forces, Position, Setup};
use crate::solve::{FixedBounds, Observer, Outcome, SolveError, TOLERANCE};

/// Projected gradient with extrapolation and restart.
#[derive(Debug, Clone, PartialEq)]
pub struct Accelerated {
    /// Residual at which it stops.
    pub tolerance: f64,
    /// Most iterations.
    pub max_iterations: usize,
}

impl Default for Accelerated {
    fn default() -> Self {
        Self {
            tolerance: TOLERANCE,
            max_iterations: 100_000,
        }
    }
}

impl FixedBounds for Accelerated {
    const NAME: &'static str = "accelerated";

    fn limits_mut(&mut self) -> (&mut f64, &mut usize) {
        (&mut self.tolerance, &mut self.max_iterations)
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let bound = 1.01 * projected_bound(setup);
        let (projection, mut x) = Projection::start(setup, guess)?;
        setup.multiply(&x.lambda, &mut x.product);
        let mut steps = AcceleratedSteps {
            setup,
            projection,
            bound,
            momentum: 1.0,
            restart: false,
            y: x.clone(),
            x,
            next: Forces::none(setup),
        };
        iterate(self, setup, &mut steps, 0, observe)
    }
}

struct AcceleratedSteps<'a> {
    setup: &'a Setup<'a>,
    projection: Projection<'a>,
    /// L.
    bound: f64,
    /// t.
    momentum: f64,
    /// The step points against the gradient mapping.
    restart: bool,
    /// xₖ, the extrapolated yₖ and xₖ₊₁, each with its product; that of y follows by the same combination.
    x: Forces,
    y: Forces,
    next: Forces,
}

impl Iteration for AcceleratedSteps<'_> {
    const FIRST: usize = 1;

    fn evaluate(&mut self) {
        let (x, y, next) = (&self.x.lambda, &self.y, &mut self.next);
        loop {
            let (bound, shift) = (self.bound, &self.setup.shift);
            let trial = |i: usize| y.lambda[i] - (y.product[i] - shift[i]) / bound;
            let tau = self.projection.project(trial, &mut next.lambda);
            for (alpha, tau) in next.alpha.iter_mut().zip(tau) {
                *alpha = -tau * bound;
            }
            self.setup.multiply(&next.lambda, &mut next.product);
            match steeper_than(bound, next, y, |_| true) {
                Some(quotient) => self.bound = 1.05 * quotient,
                None => break,
            }
        }
        let (y, next) = (&y.lambda, &next.lambda);
        let against = (0..x.len()).map(|i| (y[i] - next[i]) * (next[i] - x[i]));
        self.restart = against.sum::<f64>() > 0.0;
    }

    fn point(&self) -> Position<'_> {
        let step = if self.restart { 'r' } else { 'a' };
        self.next.at(self.setup, step)
    }

    fn advance(&mut self, _gap: &[f64]) -> usize {
        let momentum = if self.restart { 1.0 } else { self.momentum };
        self.momentum = (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt()) / 2.0;
        let part = (momentum - 1.0) / self.momentum;
        let (x, y, next) = (&self.x, &mut self.y, &self.next);
        for i in 0..y.lambda.len() {
            y.lambda[i] = next.lambda[i] + part * (next.lambda[i] - x.lambda[i]);
            y.product[i] = next.product[i] + part * (next.product[i] - x.product[i]);
        }
        std::mem::swap(&mut self.x, &mut self.next);
        1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance, DualProblem};
    use crate::solve::tests::{apart, definite, of, times};
    use crate::solve::{ContactSolver, Iterate};
    use std::ops::ControlFlow;

    fn held() -> DualProblem {
        of(
            Compliance::Dense(definite(8)),
            &[1.0, -0.4, 0.7, 0.2, -1.0, 0.9, 0.8, 0.6],
            vec![Block::Unilateral; 8],
            (&[], &[]),
        )
    }

    #[test]
    fn iterates_are_those_of_the_published_recursion_with_restarts() {
        let problem = held();
        let setup = Setup::new(&problem).unwrap();
        let bound = 1.01 * projected_bound(&setup);
        let (f, d) = (definite(8), &problem.shift);
        let mut shown = Vec::new();
        let outcome = Accelerated::default()
            .solve(&problem, None, &mut |at: &Iterate<'_>| {
                shown.push((at.iteration, at.lambda.to_vec(), at.step));
                ControlFlow::Continue(())
            })
            .unwrap();
        assert!(problem.certify(&outcome.multipliers, 1e-8).holds());
        let (mut x, mut y, mut t) = (vec![0.0; 8], vec![0.0; 8], 1.0f64);
        let mut restarts = 0;
        for (k, (iteration, lambda, step)) in shown.iter().enumerate() {
            let image = times(&f, &y);
            let next: Vec<f64> = (0..8)
                .map(|i| (y[i] - (image[i] - d[i]) / bound).max(0.0))
                .collect();
            let against: f64 = (0..8).map(|i| (y[i] - next[i]) * (next[i] - x[i])).sum();
            let restart = against > 0.0;
            restarts += usize::from(restart);
            if restart {
                t = 1.0;
            }
            let momentum = (1.0 + (1.0 + 4.0 * t * t).sqrt()) / 2.0;
            let part = (t - 1.0) / momentum;
            y = (0..8).map(|i| next[i] + part * (next[i] - x[i])).collect();
            (x, t) = (next, momentum);
            assert_eq!(
                (*iteration, *step),
                (k + 1, if restart { 'r' } else { 'a' })
            );
            assert!(apart(lambda, &x) < 1e-11, "iterate {iteration}");
        }
        assert!(restarts > 0, "nothing was restarted");
    }

    #[test]
    fn bound_grows_until_the_step_is_no_steeper() {
        let problem = held();
        let setup = Setup::new(&problem).unwrap();
        let (projection, x) = Projection::start(&setup, None).unwrap();
        let mut steps = AcceleratedSteps {
            setup: &setup,
            projection,
            bound: 0.1,
            momentum: 1.0,
            restart: false,
            y: x.clone(),
            x,
            next: Forces::none(&setup),
        };
        steps.evaluate();
        let step = &steps.next.lambda;
        let energy: f64 = times(&definite(8), step)
            .iter()
            .zip(step)
            .map(|(a, b)| a * b)
            .sum();
        let square: f64 = step.iter().map(|x| x * x).sum();
        let quotient = energy / square;
        assert!(
            quotient <= 1.000_001 * steps.bound,
            "{quotient} {}",
            steps.bound
        );
        let largest = projected_bound(&setup);
        assert!(steps.bound > 0.3 * largest && steps.bound <= 1.05 * largest);
        assert!(apart(&steps.next.product, &times(&definite(8), step)) < 1e-14);
    }
}
