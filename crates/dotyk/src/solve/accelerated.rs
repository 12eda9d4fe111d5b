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
        let mut steps = Steps {
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

struct Steps<'a> {
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

impl Iteration for Steps<'_> {
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
