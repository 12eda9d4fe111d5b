//! All solvers on one condensed model, side by side: iterations, products, time, and the difference of their answers.

use super::condense::DENSE_LIMIT;
use super::error::Error;
use super::nouns::{Method, Model};
use super::pipeline::{Attempt, Event};
use crate::solve::SAFE_STEP;
use std::time::Instant;

/// One run of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonRow {
    /// Name of the method.
    pub method: &'static str,
    /// Fixed step, where there is one.
    pub rho: Option<f64>,
    /// ρ·λ_max of the operator that the method iterates on.
    pub rho_lambda_max: Option<f64>,
    /// It met the tolerance.
    pub converged: bool,
    /// Iterations.
    pub iterations: usize,
    /// Products with F.
    pub products: usize,
    /// Wall seconds of the contact solver.
    pub seconds: f64,
    /// ‖λ − λ_newton‖ / ‖λ_newton‖.
    pub difference: f64,
}

/// Rows of all methods, or of a sweep of ρ.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// One per run.
    pub rows: Vec<ComparisonRow>,
}

/// Steps of a sweep of ρ.
const SWEEP: usize = 25;
/// Most iterations of one run of a sweep: enough for the left branch at a hundredth of the best step.
const SWEEP_ITERATIONS: usize = 20_000;

impl<const D: usize> Model<D> {
    /// Runs every named method on the model.
    ///
    /// Errors: those of [`Model::solve`] that come before the contact solver.
    pub fn compare(&self, observe: &mut dyn FnMut(Event)) -> Result<Comparison, Error<D>> {
        let condensed = self.condense(DENSE_LIMIT, observe)?;
        let reference = self
            .run_solver(
                &condensed,
                Method::Newton,
                self.solver.tolerance,
                None,
                observe,
            )?
            .outcome
            .multipliers
            .lambda;
        let mut rows = Vec::new();
        for method in Method::NAMED {
            let clock = Instant::now();
            let attempt =
                self.run_solver(&condensed, method, self.solver.tolerance, None, observe)?;
            rows.push(row(
                attempt,
                clock.elapsed().as_secs_f64(),
                None,
                &reference,
            ));
        }
        Ok(Comparison { rows })
    }

    /// Iterations of the p,A-algorithm and of projected gradient as functions of ρ: 25 log-spaced values in a range.
    ///
    /// Without a range: from a hundredth of the stability limit 2/λ_max to 1.5 times it. A run that has not converged
    /// after 20 000 iterations counts as not converged.
    /// Source: Janovský & Procházka (1980) III, Fig. 11.
    pub fn compare_rho(
        &self,
        range: Option<(f64, f64)>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Comparison, Error<D>> {
        let condensed = self.condense(DENSE_LIMIT, observe)?;
        let reference = self
            .run_solver(
                &condensed,
                Method::Newton,
                self.solver.tolerance,
                None,
                observe,
            )?
            .outcome
            .multipliers
            .lambda;
        let mut rows = Vec::new();
        for method in [Method::Uzawa, Method::Gradient] {
            // the automatic run tells the operator's λ_max: ρ = 1.9/λ_max
            let automatic = Self {
                solver: super::nouns::SolverOptions {
                    rho: None,
                    ..self.solver.clone()
                },
                ..self.clone()
            };
            let natural = automatic.run_solver(
                &condensed,
                method,
                self.solver.tolerance,
                None,
                &mut |_| {},
            )?;
            let Some(rho) = natural.outcome.rho else {
                continue;
            };
            let lambda_max = SAFE_STEP / rho;
            let (low, high) = range.unwrap_or((0.02 / lambda_max, 3.0 / lambda_max));
            for step in 0..SWEEP {
                let fraction = step as f64 / (SWEEP - 1) as f64;
                let rho = low * (high / low).powf(fraction);
                let mut model = automatic.clone();
                model.solver.rho = Some(rho);
                model.solver.max_iterations = Some(SWEEP_ITERATIONS);
                let clock = Instant::now();
                let attempt = model.run_solver(
                    &condensed,
                    method,
                    self.solver.tolerance,
                    None,
                    &mut |_| {},
                )?;
                observe(Event::Iteration {
                    iteration: rows.len() + 1,
                    residual: f64::NAN,
                    active: 0,
                });
                rows.push(row(
                    attempt,
                    clock.elapsed().as_secs_f64(),
                    Some((rho, rho * lambda_max)),
                    &reference,
                ));
            }
        }
        Ok(Comparison { rows })
    }
}

fn row(
    attempt: Attempt,
    seconds: f64,
    rho: Option<(f64, f64)>,
    reference: &[f64],
) -> ComparisonRow {
    let lambda = &attempt.outcome.multipliers.lambda;
    let size: f64 = reference.iter().map(|l| l * l).sum::<f64>().sqrt();
    let rest: f64 = lambda
        .iter()
        .zip(reference)
        .map(|(a, b)| (a - b) * (a - b))
        .sum::<f64>()
        .sqrt();
    ComparisonRow {
        method: attempt.method,
        rho: rho.map(|r| r.0).or(attempt.outcome.rho),
        rho_lambda_max: rho.map(|r| r.1).or(attempt.outcome.rho.map(|_| SAFE_STEP)),
        converged: attempt.failure.is_none(),
        iterations: attempt.outcome.iterations,
        products: attempt.outcome.products,
        seconds,
        difference: if size > 0.0 { rest / size } else { rest },
    }
}
