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

use crate::dual::{Multipliers, Projector};
use crate::solve::gradient::projected_bound;
use crate::solve::iteration::{Iteration, Point, iterate, steeper_than};
use crate::solve::setup::Setup;
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

    fn limits(&self) -> (f64, usize) {
        (self.tolerance, self.max_iterations)
    }

    fn within(&self, tolerance: f64, max_iterations: usize) -> Self {
        Self {
            tolerance,
            max_iterations,
        }
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let bound = 1.01 * projected_bound(setup);
        let (m, k) = (setup.len(), setup.modes());
        let mut projector = setup.projector();
        let (mut x, mut product_x) = (vec![0.0; m], vec![0.0; m]);
        projector.project(&setup.start(guess)?, &mut vec![0.0; k], &mut x);
        setup.multiply(&x, &mut product_x);
        let mut steps = Steps {
            setup,
            projector,
            bound,
            momentum: 1.0,
            restart: false,
            y: x.clone(),
            product_y: product_x.clone(),
            x,
            product_x,
            next: vec![0.0; m],
            product_next: vec![0.0; m],
            trial: vec![0.0; m],
            tau: vec![0.0; k],
            alpha: vec![0.0; k],
        };
        iterate(self, setup, &mut steps, 0, observe)
    }
}

struct Steps<'a> {
    setup: &'a Setup<'a>,
    projector: Projector<'a>,
    /// L.
    bound: f64,
    /// t.
    momentum: f64,
    /// The step points against the gradient mapping.
    restart: bool,
    /// xₖ, the extrapolated yₖ and xₖ₊₁, each with its product; that of y follows by the same combination.
    x: Vec<f64>,
    product_x: Vec<f64>,
    y: Vec<f64>,
    product_y: Vec<f64>,
    next: Vec<f64>,
    product_next: Vec<f64>,
    trial: Vec<f64>,
    tau: Vec<f64>,
    alpha: Vec<f64>,
}

impl Iteration for Steps<'_> {
    const FIRST: usize = 1;

    fn evaluate(&mut self) {
        loop {
            for (i, trial) in self.trial.iter_mut().enumerate() {
                *trial = self.y[i] - (self.product_y[i] - self.setup.shift[i]) / self.bound;
            }
            self.projector
                .project(&self.trial, &mut self.tau, &mut self.next);
            self.setup.multiply(&self.next, &mut self.product_next);
            let (to, from) = (
                (&self.next[..], &self.product_next[..]),
                (&self.y[..], &self.product_y[..]),
            );
            let Some(quotient) = steeper_than(self.bound, to, from, |_| true) else {
                break;
            };
            self.bound = 1.05 * quotient;
        }
        for (alpha, tau) in self.alpha.iter_mut().zip(&self.tau) {
            *alpha = -tau * self.bound;
        }
        let (x, y, next) = (&self.x, &self.y, &self.next);
        let against: f64 = (0..x.len())
            .map(|i| (y[i] - next[i]) * (next[i] - x[i]))
            .sum();
        self.restart = against > 0.0;
    }

    fn point(&self) -> Point<'_> {
        Point {
            lambda: &self.next,
            product: &self.product_next,
            alpha: &self.alpha,
            components: &self.setup.components,
            step: if self.restart { 'r' } else { 'a' },
        }
    }

    fn advance(&mut self, _gap: &[f64]) -> usize {
        let momentum = if self.restart { 1.0 } else { self.momentum };
        self.momentum = (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt()) / 2.0;
        let part = (momentum - 1.0) / self.momentum;
        for i in 0..self.y.len() {
            self.y[i] = self.next[i] + part * (self.next[i] - self.x[i]);
            self.product_y[i] =
                self.product_next[i] + part * (self.product_next[i] - self.product_x[i]);
        }
        std::mem::swap(&mut self.x, &mut self.next);
        std::mem::swap(&mut self.product_x, &mut self.product_next);
        1
    }
}
