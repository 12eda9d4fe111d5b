//! To come.

// ---- Stand-ins for the result files, so that the command line compiles without them: to be dropped by the merge. ----

use crate::model::{Model, Solution};
use std::path::{Path, PathBuf};

/// Why a result file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("this build cannot write")]
pub struct Error;

/// One solver on the case.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonRow {
    /// Name of the method.
    pub method: String,
    /// Fixed step.
    pub rho: Option<f64>,
    /// The step times the largest eigenvalue of F.
    pub rho_lambda_max: Option<f64>,
    /// The certificate holds.
    pub converged: bool,
    /// Iterations.
    pub iterations: usize,
    /// Products with F.
    pub products: usize,
    /// Wall seconds of the contact solver.
    pub seconds: f64,
    /// Largest difference of λ, relative.
    pub difference: f64,
}

/// What `dotyk compare` measured.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// Title of the case.
    pub title: String,
    /// The runs.
    pub rows: Vec<ComparisonRow>,
}

/// Writes all result files.
pub fn write(
    _model: &Model<2>,
    _solution: &Solution<2>,
    _stem: &str,
    _dir: &Path,
) -> Result<Vec<PathBuf>, Error> {
    Err(Error)
}

/// Writes the summary alone.
pub fn write_summary(
    _model: &Model<2>,
    _solution: &Solution<2>,
    _stem: &str,
    _dir: &Path,
) -> Result<PathBuf, Error> {
    Err(Error)
}

/// Writes the page of an unsolved model.
pub fn write_check_page(
    _model: &Model<2>,
    _text: &str,
    _stem: &str,
    _dir: &Path,
) -> Result<PathBuf, Error> {
    Err(Error)
}

/// Writes a comparison.
pub fn write_comparison(_comparison: &Comparison, _dir: &Path) -> Result<Vec<PathBuf>, Error> {
    Err(Error)
}
