//! All solvers on one condensed model, side by side: iterations, products, time, and the difference of their answers.

use crate::linalg::dense::norm;
use crate::model::march::attempt::run_method;
use crate::model::march::steps::{check_linear, condense_step};
use crate::model::nouns::error::Error;
use crate::model::nouns::event::Event;
use crate::model::nouns::model::{Method, Model};
use crate::model::nouns::presence::Stage;
use crate::model::nouns::solution::HistoryPoint;
use crate::model::system::compliance::DENSE_LIMIT;
use crate::model::system::condense::{Condensed, Purpose, linearise};
use crate::model::system::state::State;
use crate::solve::{SAFE_STEP, SolveError};
use std::sync::Arc;
use std::time::Instant;

/// One run of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonRow {
    /// Name of the method.
    pub method: String,
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
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// Title of the model.
    pub title: String,
    /// One per run.
    pub rows: Vec<ComparisonRow>,
}

/// Most iterations of one run of a sweep: enough for the left branch at a hundredth of the best step.
const SWEEP_ITERATIONS: usize = 20_000;

/// Runs every named method that applies to the model on its last load step, each from its own start.
///
/// Errors: those of [`Model::solve`] that come before the contact solver.
pub(crate) fn compare<const D: usize>(
    model: &Model<D>,
    observe: &mut dyn FnMut(Event),
) -> Result<Vec<ComparisonRow>, Error<D>> {
    let bench = Bench::new(model, observe)?;
    let mut rows = Vec::new();
    for method in Method::NAMED {
        match bench.run(&bench.stage, method, None, observe) {
            Err(Error::Solver(SolveError::Unsupported { .. })) => {}
            row => rows.push(row?),
        }
    }
    Ok(rows)
}

/// Iterations of the p,A-algorithm and of projected gradient for some steps ρ.
///
/// A run that has not converged after 20 000 iterations counts as not converged.
/// Source: Janovský & Procházka (1980) III, Fig. 11.
pub(crate) fn compare_steps<const D: usize>(
    model: &Model<D>,
    steps: &[f64],
    observe: &mut dyn FnMut(Event),
) -> Result<Vec<ComparisonRow>, Error<D>> {
    let bench = Bench::new(model, observe)?;
    let mut varied = bench.stage.clone();
    let mut rows = Vec::new();
    for method in [Method::Uzawa, Method::Gradient] {
        // the automatic step gives λ_max of the operator that the method iterates on
        varied.solver.rho = None;
        varied.solver.max_iterations = Some(1);
        let natural = run_method(
            &varied,
            &bench.condensed,
            (method, model.solver.tolerance, 0),
            None,
            &mut |_| {},
        )?;
        let lambda_max = natural.outcome.rho.map(|rho| SAFE_STEP / rho);
        for &rho in steps {
            varied.solver.rho = Some(rho);
            varied.solver.max_iterations = Some(SWEEP_ITERATIONS);
            let row = bench.run(&varied, method, lambda_max, &mut |_| {})?;
            observe(Event::Iteration(HistoryPoint {
                iteration: rows.len() + 1,
                residual: f64::NAN,
                active: row.iterations,
            }));
            rows.push(row);
        }
    }
    Ok(rows)
}

/// A condensed model with the reference answer of all runs.
struct Bench<const D: usize> {
    /// The parts of the model that are there in the last load step.
    stage: Model<D>,
    condensed: Condensed<D>,
    reference: Vec<f64>,
}

impl<const D: usize> Bench<D> {
    fn new(model: &Model<D>, observe: &mut dyn FnMut(Event)) -> Result<Self, Error<D>> {
        check_linear(model)?;
        let last = model.last_time();
        let (stage, condensed) = match model.has_stages() {
            true => {
                let (stage, (condensed, _)) = condense_step(model, last, DENSE_LIMIT, observe)?;
                (stage.model.into_owned(), condensed)
            }
            false => {
                let from = (last, Arc::new(State::new(model, last, false)));
                let (stage, anew) = (Stage::whole(model), (None, Purpose::others(DENSE_LIMIT)));
                let (condensed, ()) = linearise(&stage, from, anew, |_, _| Ok(()), observe)?;
                (model.clone(), condensed)
            }
        };
        let newton = run_method(
            &stage,
            &condensed,
            (Method::Newton, model.solver.tolerance, 0),
            None,
            &mut |_| {},
        )?;
        Ok(Self {
            stage,
            condensed,
            reference: newton.outcome.multipliers.lambda,
        })
    }

    fn run(
        &self,
        model: &Model<D>,
        method: Method,
        lambda_max: Option<f64>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<ComparisonRow, Error<D>> {
        let clock = Instant::now();
        let attempt = run_method(
            model,
            &self.condensed,
            (method, model.solver.tolerance, 0),
            None,
            observe,
        )?;
        let seconds = clock.elapsed().as_secs_f64();
        let lambda = &attempt.outcome.multipliers.lambda;
        let size = norm(&self.reference);
        let rest = lambda.iter().zip(&self.reference).map(|(a, b)| a - b);
        let rest = norm(&rest.collect::<Vec<f64>>());
        let rho = attempt.outcome.rho;
        Ok(ComparisonRow {
            method: attempt.method,
            rho,
            rho_lambda_max: rho.map(|rho| lambda_max.map_or(SAFE_STEP, |largest| rho * largest)),
            converged: attempt.failure.is_none(),
            iterations: attempt.outcome.iterations,
            products: attempt.outcome.products,
            seconds,
            difference: if size > 0.0 { rest / size } else { rest },
        })
    }
}
