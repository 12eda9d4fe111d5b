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
pub use secant::Secant;
pub(crate) use states::{Shear, State};
pub use uzawa::Uzawa;

use std::ops::ControlFlow;

pub(crate) use crate::linalg::dense::{dot, norm};

use crate::dual::{Block, DualError, DualProblem, Multipliers};
use crate::solve::setup::Setup;

/// The automatic fixed step ρ times the upper bound of λ_max: below 2, where the iteration would stop converging.
pub const SAFE_STEP: f64 = 1.9;

/// Relative violation of the optimality conditions at which a solver stops, unless it is told otherwise.
pub const TOLERANCE: f64 = 1e-8;

/// What an observer sees once per iteration.
#[derive(Debug, Clone, Copy)]
pub struct Iterate<'a> {
    /// From 1.
    pub iteration: usize,
    /// Contact forces (m,).
    pub lambda: &'a [f64],
    /// Largest relative violation of the optimality conditions at λ; of those with given bounds of friction, where
    /// bounds that follow from normal forces are reached through these.
    pub residual: f64,
    /// Contact unknowns with a force.
    pub active: usize,
    /// Kind of step: `u` p,A-step, `g` gradient, `a` accelerated, `r` restarted, `s` secant, `c` conjugate gradient, `e` expansion,
    /// `p` proportioning (MPRGP) or proximal step (Newton), `n` exact Newton step.
    pub step: char,
}

/// Called once per iteration. `Break`: the caller is satisfied, the iterate is returned as it is.
pub type Observer<'a> = &'a mut dyn FnMut(&Iterate<'_>) -> ControlFlow<()>;

/// An answer and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// λ and α.
    pub multipliers: Multipliers,
    /// Iterations.
    pub iterations: usize,
    /// Products with F.
    pub products: usize,
    /// Fixed step, where there is one.
    pub rho: Option<f64>,
    /// Bolts in the order in which they were used (p,A-algorithm only).
    pub bolts: Vec<Bolt>,
    /// One linear solve on the problem itself made the forces from what every contact does.
    pub exact: bool,
    /// The observer stopped it: the answer need not pass the certificate.
    pub stopped_by_observer: bool,
    /// How bounds that follow from normal forces were reached, where by a fixed point of problems with given ones.
    pub fixed_point: Option<FixedPoint>,
    /// What the user should know, in words.
    pub remarks: Vec<String>,
}

/// The fixed point of bounds ↦ bounds that follow from the normal forces of the solution with them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedPoint {
    /// Problems with given bounds that were solved.
    pub iterations: usize,
    /// Estimated factor by which each of them reduces the error of the bounds; below 1 the map contracts here, which
    /// speaks for a unique solution. `None`: the bounds settled before it could be told.
    pub contraction: Option<f64>,
}

impl Outcome {
    /// Forces that no solver has improved.
    pub fn unsolved(multipliers: Multipliers) -> Self {
        Self {
            multipliers,
            iterations: 0,
            products: 0,
            rho: None,
            bolts: Vec::new(),
            exact: false,
            fixed_point: None,
            stopped_by_observer: false,
            remarks: Vec::new(),
        }
    }

    /// The same answer with increments of one exact step.
    pub(crate) fn corrected(&self, change: &Multipliers) -> Self {
        let sum = |to: &[f64], by: &[f64]| to.iter().zip(by).map(|(to, by)| to + by).collect();
        Self {
            multipliers: Multipliers {
                lambda: sum(&self.multipliers.lambda, &change.lambda),
                alpha: sum(&self.multipliers.alpha, &change.alpha),
            },
            iterations: self.iterations + 1,
            exact: true,
            ..self.clone()
        }
    }
}

/// A bolt of the p,A-algorithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bolt {
    /// Contact unknown that held it.
    pub index: usize,
    /// Rigid mode that it was chosen for.
    pub mode: usize,
    /// Its force at the limit; negative is tension, that is, improper.
    pub force: f64,
    /// It was moved away from here because it was improper.
    pub moved: bool,
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The iteration ended before the optimality conditions were met.
    #[error("{method} did not converge: residual {residual:.1e} after {} iterations; {reason}", outcome.iterations)]
    NotConverged {
        /// Name of the solver.
        method: &'static str,
        /// The last iterate.
        outcome: Box<Outcome>,
        /// Its residual.
        residual: f64,
        /// What happened and what to do.
        reason: String,
    },
    /// No admissible contact force balances the load.
    #[error("no contact force can balance the load: it pulls along the rigid motion {direction:?}")]
    Infeasible {
        /// Amplitudes (r,), unit length: the motion opens the contacts and the load works on it.
        direction: Vec<f64>,
        /// Largest part of the load along that motion which friction can hold; `None`: no friction could hold it.
        factor: Option<f64>,
    },
    /// The solver cannot treat a block of the admissible set.
    #[error("{method} cannot treat block {block} of the admissible set, {found:?}: {reason}")]
    Unsupported {
        /// Name of the solver.
        method: &'static str,
        /// Index of the block.
        block: usize,
        /// The block.
        found: Block,
        /// Why, and what to use instead.
        reason: &'static str,
    },
    /// The named bolts do not hold the floating bodies.
    #[error(
        "the bolts at contact unknowns {bolts:?} do not hold the {modes} rigid modes that contact controls: name one per mode, where the normal moves with it"
    )]
    DependentBolts {
        /// Contact unknowns that were named.
        bolts: Vec<usize>,
        /// Number of modes to be held.
        modes: usize,
    },
    /// A bolt is in tension at the limit, and moving it was not allowed.
    #[error("the bolt at contact unknown {} is improper: its force is {:.6e}, a tension; choose a node that stays in contact", bolt.index, bolt.force)]
    ImproperBolt {
        /// The bolt.
        bolt: Bolt,
        /// The limit of the iteration with this bolt, which is not a solution.
        outcome: Box<Outcome>,
    },
    /// An argument has the wrong size or is not finite.
    #[error("{0}")]
    Invalid(String),
    /// The problem itself is inconsistent.
    #[error(transparent)]
    Problem(#[from] DualError),
}

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

/// The largest of `least` and the sizes of some values.
pub(crate) fn largest(least: f64, values: &[f64]) -> f64 {
    values.iter().fold(least, |s, value| s.max(value.abs()))
}

/// Number of contact unknowns with a force.
pub(crate) fn loaded(lambda: &[f64]) -> usize {
    lambda.iter().filter(|force| **force != 0.0).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, Compliance};
    use crate::linalg::Mat;

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
