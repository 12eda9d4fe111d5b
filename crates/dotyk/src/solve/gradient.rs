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
        let mut steps = GradientSteps {
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

struct GradientSteps<'a> {
    setup: &'a Setup<'a>,
    step: FixedStep,
    projection: Projection<'a>,
    /// The iterate and the one before.
    at: Forces,
    then: Forces,
    /// λ of the next one.
    next: Vec<f64>,
}

impl Iteration for GradientSteps<'_> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance};
    use crate::linalg::Mat;
    use crate::solve::tests::{apart, definite, of, silent, times};
    use crate::solve::{ContactSolver, Iterate};
    use std::ops::ControlFlow;

    #[test]
    fn bound_is_the_largest_eigenvalue_on_balanced_forces() {
        // along (1, −1)/√2 alone forces keep their sum: (3 + 7)/2
        let f = Mat::from_fn(2, 2, |i, j| if i == j { [3.0, 7.0][i] } else { 0.0 });
        let blocks = vec![Block::Unilateral; 2];
        let balance = (&[vec![1.0, 1.0]][..], &[1.0][..]);
        let problem = of(
            Compliance::Dense(f.clone()),
            &[1.0, 2.0],
            blocks.clone(),
            balance,
        );
        let setup = Setup::new(&problem).unwrap();
        assert!((projected_bound(&setup) - 5.0).abs() < 1e-13);
        let problem = of(Compliance::Dense(f), &[1.0, 2.0], blocks, (&[], &[]));
        let setup = Setup::new(&problem).unwrap();
        assert!((projected_bound(&setup) - 7.0).abs() < 1e-13);
    }

    #[test]
    fn iterates_are_those_of_the_formula_and_the_step_is_told() {
        let f = definite(6);
        let shift = [1.0, -0.4, 0.7, 0.2, -1.0, 0.9];
        let problem = of(
            Compliance::Dense(f.clone()),
            &shift,
            vec![Block::Unilateral; 6],
            (&[], &[]),
        );
        let mut iterates = Vec::new();
        let method = Gradient {
            rho: Some(0.4),
            ..Gradient::default()
        };
        let outcome = method
            .solve(&problem, None, &mut |iterate: &Iterate<'_>| {
                assert_eq!(iterate.step, 'g');
                assert_eq!(iterate.iteration, iterates.len() + 1);
                iterates.push(iterate.lambda.to_vec());
                ControlFlow::Continue(())
            })
            .unwrap();
        assert_eq!(outcome.rho, Some(0.4));
        assert_eq!(outcome.iterations, iterates.len());
        // one product for each iterate and for the start
        assert_eq!(outcome.products, iterates.len() + 1);
        let mut lambda = vec![0.0; 6];
        for iterate in &iterates {
            let gap = times(&f, &lambda);
            for i in 0..6 {
                lambda[i] = (lambda[i] - 0.4 * (gap[i] - shift[i])).max(0.0);
            }
            assert!(apart(&lambda, iterate) < 1e-14);
        }
        let automatic = Gradient::default()
            .solve(&problem, None, &mut silent)
            .unwrap();
        let setup = Setup::new(&problem).unwrap();
        let rho = automatic.rho.unwrap();
        assert!((rho * projected_bound(&setup) - 1.9).abs() < 1e-14);
    }
}
