//! Projected gradient without a bolt: λ ← P(λ − ρ(Fλ − d)) with the exact projection P onto Λ ∩ {Gλ = e}.
//!
//! [`Gradient`] has a fixed step ρ, by default 1.9/L with L an upper bound of the largest eigenvalue of PFP (P here the
//! orthogonal projector onto Gλ = 0) by Lanczos steps; it converges for every ρ < 2/L. [`Accelerated`] adds Nesterov's
//! extrapolation and restarts it when the step points against the gradient mapping: rate √κ instead of κ, no parameter.
//! α follows from the multiplier τ of the projection, α = −τ/ρ.
//!
//! Sources: fixed step as described in Janovský & Procházka (1980) III for the p,A-algorithm, with the exact
//! projection in place of the bolt; acceleration as described in Beck & Teboulle (2009), restart as described in
//! O'Donoghue & Candès (2015).

use std::ops::ControlFlow;

use crate::dual::{DualProblem, Multipliers};
use crate::solve::{
    ContactSolver, FixedBounds, Iterate, Observer, Outcome, Setup, SolveError, loaded, solve_with,
    spectrum, steeper_than,
};

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
            tolerance: 1e-8,
            max_iterations: 200_000,
        }
    }
}

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
            tolerance: 1e-8,
            max_iterations: 100_000,
        }
    }
}

impl ContactSolver for Gradient {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        solve_with(self, problem, guess, observe)
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
        let problem = setup.problem;
        check_rho(self.rho)?;
        let mut projector = setup.projector();
        let mut judge = setup.judge();
        let (m, k) = (setup.len(), setup.modes());
        let mut products = 0;
        let mut bound = match self.rho {
            Some(rho) => 1.9 / rho,
            None => projected_bound(setup, &mut products),
        };
        let mut rho = self.rho.unwrap_or(1.9 / bound);
        let start = setup.start(guess)?;
        let (mut lambda, mut next) = (vec![0.0; m], vec![0.0; m]);
        let (mut product, mut before) = (vec![0.0; m], vec![0.0; m]);
        let (mut tau, mut alpha) = (vec![0.0; k], vec![0.0; k]);
        projector.project(&start, &mut vec![0.0; k], &mut lambda);
        let mut trial = vec![0.0; m];
        let mut residual = f64::INFINITY;
        for iteration in 0..=self.max_iterations {
            before.copy_from_slice(&product);
            problem.compliance.apply(&lambda, &mut product);
            products += 1;
            if self.rho.is_none() && iteration > 0 {
                // `next` still holds the iterate before.
                let steeper = steeper_than(bound, (&lambda, &product), (&next, &before), |_| true);
                if let Some(quotient) = steeper {
                    bound = 1.05 * quotient;
                    rho = 1.9 / bound;
                }
            }
            for i in 0..m {
                trial[i] = lambda[i] - rho * (product[i] - problem.shift[i]);
            }
            projector.project(&trial, &mut tau, &mut next);
            for (alpha, tau) in alpha.iter_mut().zip(&tau) {
                *alpha = -tau / rho;
            }
            residual = judge.residual(setup, &setup.components, &lambda, &product, &alpha);
            let stopped = iteration > 0
                && observe(&Iterate {
                    iteration,
                    lambda: &lambda,
                    residual,
                    active: loaded(&lambda),
                    step: 'g',
                }) == ControlFlow::Break(());
            let ended = iteration == self.max_iterations || !residual.is_finite();
            if stopped || residual <= self.tolerance || ended {
                let outcome = Outcome {
                    multipliers: setup.multipliers(&lambda, &alpha),
                    iterations: iteration,
                    products,
                    rho: Some(rho),
                    bolts: Vec::new(),
                    exact: false,
                    stopped_by_observer: stopped,
                    fixed_point: None,
                    remarks: Vec::new(),
                };
                if stopped || residual <= self.tolerance {
                    return Ok(outcome);
                }
                return Err(self.not_converged(setup, outcome, residual));
            }
            std::mem::swap(&mut lambda, &mut next);
        }
        Err(SolveError::Invalid(format!(
            "gradient ended without a verdict at residual {residual:e}"
        )))
    }
}

impl Gradient {
    /// Names the step and its limit.
    fn not_converged(&self, setup: &Setup<'_>, outcome: Outcome, residual: f64) -> SolveError {
        let reason = match self.rho {
            None => "allow more iterations, or use newton".to_string(),
            Some(rho) => rho_reason(rho, projected_bound(setup, &mut 0)),
        };
        SolveError::NotConverged {
            method: Self::NAME,
            outcome: Box::new(outcome),
            residual,
            reason,
        }
    }
}

impl ContactSolver for Accelerated {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        solve_with(self, problem, guess, observe)
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
        let problem = setup.problem;
        let mut projector = setup.projector();
        let mut judge = setup.judge();
        let (m, k) = (setup.len(), setup.modes());
        let mut products = 0;
        let mut bound = 1.01 * projected_bound(setup, &mut products);
        let start = setup.start(guess)?;
        // x is the iterate, y the extrapolated point; their products with F follow by the same combination.
        let (mut x, mut y, mut next) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
        let (mut product_x, mut product_next) = (vec![0.0; m], vec![0.0; m]);
        let (mut tau, mut alpha) = (vec![0.0; k], vec![0.0; k]);
        projector.project(&start, &mut vec![0.0; k], &mut x);
        problem.compliance.apply(&x, &mut product_x);
        products += 1;
        y.copy_from_slice(&x);
        let mut product_y = product_x.clone();
        let mut trial = vec![0.0; m];
        let (mut momentum, mut iteration): (f64, usize) = (1.0, 0);
        loop {
            for i in 0..m {
                trial[i] = y[i] - (product_y[i] - problem.shift[i]) / bound;
            }
            projector.project(&trial, &mut tau, &mut next);
            problem.compliance.apply(&next, &mut product_next);
            products += 1;
            let steeper = steeper_than(bound, (&next, &product_next), (&y, &product_y), |_| true);
            if let Some(quotient) = steeper {
                bound = 1.05 * quotient;
                continue;
            }
            iteration += 1;
            for (alpha, tau) in alpha.iter_mut().zip(&tau) {
                *alpha = -tau * bound;
            }
            let against: f64 = (0..m).map(|i| (y[i] - next[i]) * (next[i] - x[i])).sum();
            let restart = against > 0.0;
            if restart {
                momentum = 1.0;
            }
            let faster = (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt()) / 2.0;
            let extrapolation = (momentum - 1.0) / faster;
            momentum = faster;
            for i in 0..m {
                y[i] = next[i] + extrapolation * (next[i] - x[i]);
                product_y[i] = product_next[i] + extrapolation * (product_next[i] - product_x[i]);
            }
            std::mem::swap(&mut x, &mut next);
            std::mem::swap(&mut product_x, &mut product_next);
            let residual = judge.residual(setup, &setup.components, &x, &product_x, &alpha);
            let stopped = observe(&Iterate {
                iteration,
                lambda: &x,
                residual,
                active: loaded(&x),
                step: if restart { 'r' } else { 'a' },
            }) == ControlFlow::Break(());
            let ended = iteration == self.max_iterations || !residual.is_finite();
            if stopped || residual <= self.tolerance || ended {
                let outcome = Outcome {
                    multipliers: setup.multipliers(&x, &alpha),
                    iterations: iteration,
                    products,
                    rho: None,
                    bolts: Vec::new(),
                    exact: false,
                    stopped_by_observer: stopped,
                    fixed_point: None,
                    remarks: Vec::new(),
                };
                if stopped || residual <= self.tolerance {
                    return Ok(outcome);
                }
                return Err(SolveError::NotConverged {
                    method: Self::NAME,
                    outcome: Box::new(outcome),
                    residual,
                    reason: "allow more iterations, or use newton".to_string(),
                });
            }
        }
    }
}

/// Upper bound of the largest eigenvalue of PFP, P = I − ĜᵀĜ; see [`Setup::usable_bound`] for the zero operator.
pub(crate) fn projected_bound(setup: &Setup<'_>, products: &mut usize) -> f64 {
    let (m, k) = (setup.len(), setup.modes());
    let (mut parts, mut inside) = (vec![0.0; k], vec![0.0; m]);
    let mut project = |v: &mut [f64]| {
        setup.balance.apply(v, &mut parts);
        setup.balance.add_transposed(-1.0, &parts, v);
    };
    let (bound, count) = spectrum::largest_eigenvalue(m, spectrum::STEPS, |x, y| {
        inside.copy_from_slice(x);
        project(&mut inside);
        setup.problem.compliance.apply(&inside, y);
        project(y);
    });
    *products += count;
    setup.usable_bound(bound)
}

/// A given step must be a positive number.
pub(crate) fn check_rho(rho: Option<f64>) -> Result<(), SolveError> {
    match rho {
        Some(rho) if !(rho > 0.0 && rho.is_finite()) => Err(SolveError::Invalid(format!(
            "rho is {rho}: it must be a positive number, or \"auto\""
        ))),
        _ => Ok(()),
    }
}

/// Why a fixed step failed.
pub(crate) fn rho_reason(rho: f64, bound: f64) -> String {
    let limit = 2.0 / bound;
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
