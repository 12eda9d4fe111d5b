//! The user's nouns and the pipeline: assemble → condense → solve → recover.
//!
//! A [`Model`] is plain data: bodies with meshes, materials, supports and loads, contacts between their sides.
//! [`Model::solve`] turns it into a [`Solution`]; nothing in between is visible or valid only after a second call.

mod build;
mod check;
mod compare;
mod condense;
mod error;
mod floating;
mod nouns;
mod pair;
mod pipeline;
mod probe;
mod recover;
mod solution;

pub use check::{BodyCheck, Check, ContactCheck};
pub use compare::{Comparison, ComparisonRow};
pub use error::Error;
pub use nouns::*;
pub use pipeline::Event;
pub use solution::*;

// ---- Stand-ins for the pipeline, so that the command line compiles without it: to be dropped by the merge. ----

/// What happens during a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A stage begins.
    Stage(&'static str),
    /// An iteration of the contact solver is done.
    Iteration {
        /// Iteration, from 1.
        iteration: usize,
        /// Largest relative violation of the optimality conditions.
        residual: f64,
        /// Contact unknowns with a force.
        active: usize,
    },
}

/// Why there is no solution.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The last iterate does not hold its certificate.
    #[error("not converged after {} iterations", .0.solver.iterations)]
    NotConverged(Box<Solution<2>>),
    /// No pipeline.
    #[error("this build cannot solve")]
    Missing,
}

/// What is found without solving.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Check {
    /// What forbids a solution.
    pub errors: Vec<String>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "nothing was checked")
    }
}

/// One run of one method on a case.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodRun {
    /// Name of the method.
    pub method: String,
    /// Fixed step.
    pub rho: Option<f64>,
    /// The step times the largest eigenvalue of F on the admissible directions.
    pub rho_lambda_max: Option<f64>,
    /// The certificate holds.
    pub converged: bool,
    /// Iterations.
    pub iterations: usize,
    /// Products with F.
    pub products: usize,
    /// Wall seconds of the contact solver.
    pub seconds: f64,
    /// Largest difference of λ to newton's, relative to max|λ|; NaN where there is none.
    pub difference: f64,
}

impl Model<2> {
    /// Solves.
    pub fn solve_with(&self, _observe: &mut dyn FnMut(Event)) -> Result<Solution<2>, Error> {
        Err(Error::Missing)
    }

    /// Looks without solving.
    pub fn check(&self) -> Check {
        Check::default()
    }

    /// All named methods, newton first.
    pub fn compare(&self, _observe: &mut dyn FnMut(Event)) -> Result<Vec<MethodRun>, Error> {
        Err(Error::Missing)
    }

    /// `uzawa` and `gradient` with each of these steps.
    pub fn compare_steps(
        &self,
        _rho: &[f64],
        _observe: &mut dyn FnMut(Event),
    ) -> Result<Vec<MethodRun>, Error> {
        Err(Error::Missing)
    }
}
