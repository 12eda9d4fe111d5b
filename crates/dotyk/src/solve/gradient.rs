//! Projected gradient without a bolt: λ ← P(λ − ρ(Fλ − d)) with the exact projection P onto Λ ∩ {Gλ = e}.
//!
//! The step ρ is fixed, by default 1.9/L with L an upper bound of the largest eigenvalue of PFP (P here the orthogonal
//! projector onto Gλ = 0) by Lanczos steps; it converges for every ρ < 2/L. α follows from the multiplier τ of the
//! projection, α = −τ/ρ.
//!
//! Source: fixed step as described in Janovský & Procházka (1980) III for the p,A-algorithm, with the exact projection in
//! place of the bolt.

use crate::dual::{Multipliers, Projector};
use crate::solve::iteration::{FixedStep, Iteration, Point, iterate};
use crate::solve::setup::Setup;
use crate::solve::{FixedBounds, Observer, Outcome, SolveError, TOLERANCE, spectrum};

/// Projected gradient with a fixed step.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// ρ in forces, unscaled (force / length); `None`: 1.9/L.
    pub rho: Option<f64>,
    /// Residual at which it stops.
    pub tolerance: f64,
    /// Most iterations.
    pub max_iterations: usize,
}

impl Default for Gradient {
    fn default() -> Self {
        Self {
            rho: None,
            tolerance: TOLERANCE,
            max_iterations: 200_000,
        }
    }
}

impl FixedBounds for Gradient {
    const NAME: &'static str = "gradient";

    fn limits(&self) -> (f64, usize) {
        (self.tolerance, self.max_iterations)
    }

    fn within(&self, tolerance: f64, max_iterations: usize) -> Self {
        Self {
            tolerance,
            max_iterations,
            ..self.clone()
        }
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        FixedStep::check(self.rho)?;
        let step = FixedStep::new(self.rho, || projected_bound(setup));
        let (m, k) = (setup.len(), setup.modes());
        let mut projector = setup.projector();
        let mut lambda = vec![0.0; m];
        projector.project(&setup.start(guess)?, &mut vec![0.0; k], &mut lambda);
        let mut steps = Steps {
            setup,
            step,
            projector,
            next: lambda.clone(),
            lambda,
            product: vec![0.0; m],
            before: vec![0.0; m],
            trial: vec![0.0; m],
            tau: vec![0.0; k],
            alpha: vec![0.0; k],
        };
        iterate(self, setup, &mut steps, 0, observe)
    }
}

struct Steps<'a> {
    setup: &'a Setup<'a>,
    step: FixedStep,
    projector: Projector<'a>,
    lambda: Vec<f64>,
    /// The iterate before, until there is the next one.
    next: Vec<f64>,
    /// Fλ of this iterate and of the one before.
    product: Vec<f64>,
    before: Vec<f64>,
    /// λ − ρ(Fλ − d).
    trial: Vec<f64>,
    tau: Vec<f64>,
    alpha: Vec<f64>,
}

impl Iteration for Steps<'_> {
    fn evaluate(&mut self) {
        std::mem::swap(&mut self.product, &mut self.before);
        self.setup.multiply(&self.lambda, &mut self.product);
        let (now, then) = (
            (&self.lambda[..], &self.product[..]),
            (&self.next[..], &self.before[..]),
        );
        self.step.adapt(now, then, |_| true);
        let rho = self.step.rho;
        for (i, trial) in self.trial.iter_mut().enumerate() {
            *trial = self.lambda[i] - rho * (self.product[i] - self.setup.shift[i]);
        }
        self.projector
            .project(&self.trial, &mut self.tau, &mut self.next);
        for (alpha, tau) in self.alpha.iter_mut().zip(&self.tau) {
            *alpha = -tau / rho;
        }
    }

    fn point(&self) -> Point<'_> {
        Point {
            lambda: &self.lambda,
            product: &self.product,
            alpha: &self.alpha,
            components: &self.setup.components,
            step: 'g',
        }
    }

    fn advance(&mut self, _gap: &[f64]) -> usize {
        std::mem::swap(&mut self.lambda, &mut self.next);
        1
    }

    fn rho(&self) -> Option<f64> {
        Some(self.step.rho)
    }

    fn advice(&self) -> String {
        self.step.advice(|| projected_bound(self.setup))
    }
}

/// Upper bound of the largest eigenvalue of PFP, P = I − ĜᵀĜ; see [`Setup::usable_bound`] for the zero operator.
pub(crate) fn projected_bound(setup: &Setup<'_>) -> f64 {
    let (m, k) = (setup.len(), setup.modes());
    let (mut parts, mut inside) = (vec![0.0; k], vec![0.0; m]);
    let mut project = |v: &mut [f64]| {
        setup.balance.apply(v, &mut parts);
        setup.balance.add_transposed(-1.0, &parts, v);
    };
    let bound = spectrum::largest_eigenvalue(m, spectrum::STEPS, |x, y| {
        inside.copy_from_slice(x);
        project(&mut inside);
        setup.multiply(&inside, y);
        project(y);
    });
    setup.usable_bound(bound)
}
