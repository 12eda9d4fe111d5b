//! Projected gradient without a bolt: λ ← P(λ − ρ(Fλ − d)) with the exact projection P onto Λ ∩ {Gλ = e}.
//!
//! The step ρ is fixed, by default 1.9/L with L an upper bound of the largest eigenvalue of PFP (P here the orthogonal
//! projector onto Gλ = 0) by Lanczos steps; it converges for every ρ < 2/L. α follows from the multiplier τ of the
//! projection, α = −τ/ρ.
//!
//! Source: fixed step as described in Janovský & Procházka (1980) III for the p,A-algorithm, with the exact projection in
//! place of the bolt.

use crate::dual::Multipliers;
use crate::solve::iteration::{FixedStep, Iteration, Projection, iterate};
use crate::solve::setup::{Forces, Position, Setup};
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

    fn limits_mut(&mut self) -> (&mut f64, &mut usize) {
        (&mut self.tolerance, &mut self.max_iterations)
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        FixedStep::check(self.rho)?;
        let step = FixedStep::new(self.rho, || projected_bound(setup));
        let (projection, at) = Projection::start(setup, guess)?;
        let mut steps = Steps {
            setup,
            step,
            projection,
            next: vec![0.0; setup.len()],
            then: at.clone(),
            at,
        };
        iterate(self, setup, &mut steps, 0, observe)
    }
}

struct Steps<'a> {
    setup: &'a Setup<'a>,
    step: FixedStep,
    projection: Projection<'a>,
    /// The iterate and the one before.
    at: Forces,
    then: Forces,
    /// λ of the next one.
    next: Vec<f64>,
}

impl Iteration for Steps<'_> {
    fn evaluate(&mut self) {
        let (setup, at) = (self.setup, &mut self.at);
        setup.multiply(&at.lambda, &mut at.product);
        self.step.adapt(at, &self.then, |_| true);
        let next = &mut self.next;
        self.projection.descend(setup, self.step.rho, at, next);
    }

    fn point(&self) -> Position<'_> {
        self.at.at(self.setup, 'g')
    }

    fn advance(&mut self, _gap: &[f64]) -> usize {
        std::mem::swap(&mut self.at, &mut self.then);
        std::mem::swap(&mut self.at.lambda, &mut self.next);
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
