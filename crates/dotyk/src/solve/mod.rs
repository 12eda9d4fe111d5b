//! Algorithms for the dual contact problem, one file each; all of them see a [`DualProblem`] and nothing else.
//!
//! ```text
//!   min  1/2 λᵀFλ − dᵀλ    over λ ∈ Λ,  subject to  Gλ = e,     gap(λ, α) = Fλ − d − Gᵀα
//! ```
//!
//! | Solver | What it iterates on | Parameters |
//! |---|---|---|
//! | [`Uzawa`] | the p,A-algorithm: fixed step, bolts for the balance | rho, bolts (both may be automatic) |
//! | [`Gradient`] | projected gradient, fixed step, exact projection | rho (may be automatic) |
//! | [`Accelerated`] | the same with Nesterov's extrapolation and restarts | none |
//! | [`Secant`] | the same with crossed-secant acceleration | none |
//! | [`Mprgp`] | conjugate gradients on faces, balance by an augmented Lagrangian | none |
//! | [`Newton`] | active sets, one linear solve each; the default | none |
//!
//! Every solver stops on the same dimensionless measure, [`DualProblem::kkt_residual`], never on the size of its
//! update alone: with a small step that would stop far from the solution. What a solver returns as converged passes
//! [`DualProblem::certify`] with the same tolerance. Not converging is an error that carries the last iterate.
//!
//! Friction: [`Newton`] treats every law directly. The other methods solve convex problems whose bounds of friction are given;
//! bounds that follow from normal forces are reached as a fixed point of such problems (`coulomb.rs`).

mod accelerated;
mod anchored;
mod correct;
mod coulomb;
mod exact;
mod gradient;
mod hold;
mod iteration;
mod levels;
mod mprgp;
mod newton;
mod null;
mod outcome;
mod proximal;
mod secant;
mod setup;
mod slip;
mod spectrum;
mod states;
mod system;
mod uzawa;

pub use accelerated::Accelerated;
pub(crate) use correct::{correction, distance_to_exact};
pub use gradient::Gradient;
pub use mprgp::Mprgp;
pub use newton::Newton;
pub use outcome::{Bolt, FixedPoint, Iterate, Observer, Outcome, SolveError};
pub use secant::Secant;
pub(crate) use setup::largest;
pub(crate) use states::{Shear, State};
pub use uzawa::Uzawa;

pub(crate) use crate::linalg::dense::{dot, norm};

use crate::dual::{DualProblem, Multipliers};
use crate::solve::setup::Setup;

/// The automatic fixed step ρ times the upper bound of λ_max: below 2, where the iteration would stop converging.
pub const SAFE_STEP: f64 = 1.9;

/// Relative violation of the optimality conditions at which a solver stops, unless it is told otherwise.
pub const TOLERANCE: f64 = 1e-8;

/// An algorithm for the dual contact problem.
pub trait ContactSolver: Sync {
    /// Its name in reports and case files.
    fn name(&self) -> &'static str;

    /// Solves `problem`, from `guess` where given, else from the projection of zero; `guess` is not modified.
    ///
    /// Errors: see [`SolveError`]; `NotConverged` carries the last iterate.
    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError>;
}

/// An algorithm for problems whose friction bounds are given, on prepared data.
pub(crate) trait FixedBounds: Clone + Sync {
    /// Its name in reports and case files.
    const NAME: &'static str;

    /// Residual at which it stops, and the most iterations.
    fn limits_mut(&mut self) -> (&mut f64, &mut usize);

    /// The same, to read.
    fn limits(&self) -> (f64, usize) {
        let mut own = self.clone();
        let (tolerance, most) = own.limits_mut();
        (*tolerance, *most)
    }

    /// The same algorithm with other limits.
    fn within(&self, tolerance: f64, max_iterations: usize) -> Self {
        let mut other = self.clone();
        let limits = other.limits_mut();
        (*limits.0, *limits.1) = (tolerance, max_iterations);
        other
    }

    /// Solves for the admissible set of `setup`, in which no bound depends on λ.
    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError>;

    /// Solves where bounds follow from normal forces: as often as they change.
    fn run_coulomb(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        coulomb::fixed_point(self, setup, guess, observe)
    }
}

impl<S: FixedBounds> ContactSolver for S {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let setup = Setup::new(problem)?;
        match setup.admissible.bounds_follow() {
            true => self.run_coulomb(&setup, guess, observe),
            false => self.run(&setup, guess, observe),
        }
    }
}

/// Number of contact unknowns with a force.
pub(crate) fn loaded(lambda: &[f64]) -> usize {
    lambda.iter().filter(|force| **force != 0.0).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, Block, Compliance};
    use crate::linalg::Mat;
    use std::ops::ControlFlow;

    pub(crate) fn silent(_: &Iterate<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// The problem with F = AᵀA + I/100, d, Λ, G and e: far from an M-matrix where A has few rows.
    pub(crate) fn of_rank<const M: usize>(
        a: &[[f64; M]],
        shift: &[f64; M],
        blocks: Vec<Block>,
        (modes, load): (&[[f64; M]], &[f64]),
    ) -> DualProblem {
        let f = Mat::from_fn(M, M, |i, j| {
            let sum: f64 = a.iter().map(|row| row[i] * row[j]).sum();
            sum + if i == j { 0.01 } else { 0.0 }
        });
        let modes = Mat::from_fn(modes.len(), M, |i, j| modes[i][j]);
        DualProblem::new(
            Compliance::Dense(f),
            shift.to_vec(),
            AdmissibleSet::new(blocks),
            Balance::new(modes, load.to_vec()),
        )
        .unwrap()
    }
}
