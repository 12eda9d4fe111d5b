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
//! | [`Mprgp`] | conjugate gradients on faces, balance by an augmented Lagrangian | none |
//! | [`Newton`] | active sets, one linear solve each; the default | none |
//!
//! Every solver stops on the same dimensionless measure, [`DualProblem::kkt_residual`], never on the size of its
//! update alone: with a small step that would stop far from the solution. What a solver returns as converged passes
//! [`DualProblem::certify`] with the same tolerance. Not converging is an error that carries the last iterate.
//!
//! Friction: [`Newton`] treats the laws of Tresca and of Coulomb directly. The other methods solve the convex problem
//! of Tresca, and Coulomb as a fixed point of such problems (`coulomb.rs`).

mod correct;
mod coulomb;
mod gradient;
mod levels;
mod mprgp;
mod newton;
mod null;
mod proximal;
mod slip;
mod spectrum;
mod states;
mod system;
mod uzawa;

pub(crate) use correct::{correction, distance_to_exact};
pub use gradient::{Accelerated, Gradient};
pub use mprgp::Mprgp;
pub use newton::Newton;
pub use uzawa::Uzawa;

use std::ops::ControlFlow;

pub(crate) use crate::linalg::dense::{dot, norm};

use crate::dual::{
    AdmissibleSet, Balance, Block, Component, DualError, DualProblem, Feasibility, Multipliers,
    Projector, Violations,
};

/// The automatic fixed step ρ times the upper bound of λ_max: below 2, where the iteration would stop converging.
pub const SAFE_STEP: f64 = 1.9;

/// What an observer sees once per iteration.
#[derive(Debug, Clone, Copy)]
pub struct Iterate<'a> {
    /// From 1.
    pub iteration: usize,
    /// Contact forces (m,).
    pub lambda: &'a [f64],
    /// Largest relative violation of the optimality conditions at λ; of those with given bounds of friction, where
    /// Coulomb's law is reached through these.
    pub residual: f64,
    /// Contact unknowns with a force.
    pub active: usize,
    /// Kind of step: `u` p,A-step, `g` gradient, `a` accelerated, `r` restarted, `c` conjugate gradient, `e` expansion,
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
    /// How Coulomb's law was reached, where by a fixed point of problems with given bounds.
    pub fixed_point: Option<FixedPoint>,
    /// What the user should know, in words.
    pub remarks: Vec<String>,
}

/// Coulomb's law as the fixed point of bounds ↦ coefficient · λₙ.
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
pub(crate) trait FixedBounds: Sized {
    /// Its name in reports and case files.
    const NAME: &'static str;

    /// Residual at which it stops, and the most iterations.
    fn limits(&self) -> (f64, usize);

    /// The same algorithm with other limits.
    fn within(&self, tolerance: f64, max_iterations: usize) -> Self;

    /// Solves for the admissible set of `setup`, in which no bound depends on λ.
    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError>;
}

/// Runs `method`, once or, where a bound depends on λ, as often as the bounds change.
pub(crate) fn solve_with<S: FixedBounds>(
    method: &S,
    problem: &DualProblem,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let setup = Setup::new(problem)?;
    if setup.admissible.has_coulomb() {
        coulomb::fixed_point(method, &setup, guess, observe)
    } else {
        method.run(&setup, guess, observe)
    }
}

/// What every solver prepares: checked data, the balance in orthonormal modes, the kind of each force.
pub(crate) struct Setup<'a> {
    pub problem: &'a DualProblem,
    /// d, (m,): that of the problem, or what is left of it beside forces from which increments are sought.
    pub shift: Vec<f64>,
    /// Λ: that of the problem, or with other friction blocks in the same places.
    pub admissible: AdmissibleSet,
    pub balance: Balance,
    pub components: Vec<Component>,
}

impl<'a> Setup<'a> {
    /// Checks the problem, refuses loads that nothing can carry.
    pub fn new(problem: &'a DualProblem) -> Result<Self, SolveError> {
        problem.check()?;
        let mut setup = Self::unchecked(problem);
        match problem.feasibility() {
            Feasibility::Infeasible { direction, .. } => Err(SolveError::Infeasible { direction }),
            Feasibility::Feasible { load } => {
                setup.balance.set_load(&load);
                Ok(setup)
            }
        }
    }

    /// The same for a problem that was checked before.
    pub fn unchecked(problem: &'a DualProblem) -> Self {
        Self {
            problem,
            shift: problem.shift.clone(),
            admissible: problem.admissible.clone(),
            balance: Balance::new(&problem.equilibrium),
            components: problem.admissible.components(),
        }
    }

    /// The same problem with the admissible set `admissible`, which must have the same length.
    pub fn with_admissible(&self, admissible: AdmissibleSet) -> Self {
        Self {
            problem: self.problem,
            shift: self.shift.clone(),
            components: admissible.components(),
            admissible,
            balance: self.balance.clone(),
        }
    }

    /// Number m of contact forces.
    pub fn len(&self) -> usize {
        self.components.len()
    }

    /// Number k of rigid modes that contact controls.
    pub fn modes(&self) -> usize {
        self.balance.rank()
    }

    /// Force `i` is ≥ 0.
    pub fn bounded(&self, i: usize) -> bool {
        self.components[i] == Component::Normal
    }

    /// `bound`, an eigenvalue bound, or a number of its order where it is rounding: then the balance alone determines
    /// the forces, and any step is right that is comparable with them.
    pub fn usable_bound(&self, bound: f64) -> f64 {
        let diagonal = self.problem.compliance.diagonal();
        let diagonal = diagonal.map_or(0.0, |d| d.into_iter().fold(0.0, f64::max));
        if self.len() > self.modes() && bound > 1e-13 * diagonal {
            return bound;
        }
        let or_one = |scale: f64| if scale > 0.0 { scale } else { 1.0 };
        or_one(self.problem.scales.length) / or_one(self.problem.scales.force)
    }

    /// Workspace for projections.
    pub fn projector(&self) -> Projector<'_> {
        Projector::new(&self.admissible, &self.balance)
    }

    /// Forces to begin with: those of the guess, or zero; not yet admissible or balanced.
    pub fn start(&self, guess: Option<&Multipliers>) -> Result<Vec<f64>, SolveError> {
        let Some(guess) = guess else {
            return Ok(vec![0.0; self.len()]);
        };
        let expected = (self.len(), self.balance.original_len());
        if (guess.lambda.len(), guess.alpha.len()) != expected {
            return Err(SolveError::Invalid(format!(
                "the starting point has {} contact forces and {} rigid amplitudes, the problem {} and {}",
                guess.lambda.len(),
                guess.alpha.len(),
                expected.0,
                expected.1
            )));
        }
        let mut values = guess.lambda.iter().chain(&guess.alpha);
        if let Some(value) = values.find(|value| !value.is_finite()) {
            return Err(SolveError::Invalid(format!(
                "the starting point holds {value}: it must be finite"
            )));
        }
        Ok(guess.lambda.clone())
    }

    /// α from its amplitudes in orthonormal modes.
    pub fn multipliers(&self, lambda: &[f64], alpha: &[f64]) -> Multipliers {
        let mut original = vec![0.0; self.balance.original_len()];
        self.balance.to_original(alpha, &mut original);
        Multipliers {
            lambda: lambda.to_vec(),
            alpha: original,
        }
    }

    /// Workspace of [`Judge::residual`].
    pub fn judge(&self) -> Judge {
        Judge {
            alpha: vec![0.0; self.balance.original_len()],
            gap: vec![0.0; self.len()],
        }
    }
}

/// Computes the stopping measure without allocating.
pub(crate) struct Judge {
    alpha: Vec<f64>,
    /// Gap of the last call (m,).
    pub gap: Vec<f64>,
}

impl Judge {
    /// Residual at (λ, α̂) from the product Fλ; components called free are not held to λ ≥ 0.
    pub fn residual(
        &mut self,
        setup: &Setup<'_>,
        components: &[Component],
        lambda: &[f64],
        product: &[f64],
        alpha: &[f64],
    ) -> f64 {
        setup.balance.to_original(alpha, &mut self.alpha);
        setup
            .problem
            .gap_from_product(product, &self.alpha, &mut self.gap);
        Violations::at(
            setup.problem,
            &setup.admissible,
            lambda,
            &self.alpha,
            (&self.gap, None),
            components,
        )
        .residual(setup.problem.scales.moment_arm)
    }
}

/// An observer of iterations that follow `done` others.
pub(crate) fn counting_from<'a>(
    done: usize,
    observe: Observer<'a>,
) -> impl FnMut(&Iterate<'_>) -> ControlFlow<()> + 'a {
    move |iterate| {
        observe(&Iterate {
            iteration: done + iterate.iteration,
            ..*iterate
        })
    }
}

/// What a method returns that ended in another one: the outcome of that, completed.
pub(crate) fn completed(
    method: &'static str,
    result: Result<Outcome, SolveError>,
    complete: impl FnOnce(Outcome) -> Outcome,
) -> Result<Outcome, SolveError> {
    match result {
        Ok(outcome) => Ok(complete(outcome)),
        Err(SolveError::NotConverged {
            outcome,
            residual,
            reason,
            ..
        }) => Err(SolveError::NotConverged {
            method,
            outcome: Box::new(complete(*outcome)),
            residual,
            reason,
        }),
        Err(error) => Err(error),
    }
}

/// Number of contact unknowns with a force.
pub(crate) fn loaded(lambda: &[f64]) -> usize {
    lambda.iter().filter(|force| **force != 0.0).count()
}

/// Whether (x − y)ᵀF(x − y) exceeds `bound`‖x − y‖² over the chosen components, and by which Rayleigh quotient;
/// differences that are rounding are not judged.
pub(crate) fn steeper_than(
    bound: f64,
    x: (&[f64], &[f64]),
    y: (&[f64], &[f64]),
    counts: impl Fn(usize) -> bool,
) -> Option<f64> {
    let (mut energy, mut length, mut size) = (0.0, 0.0, 0.0);
    for i in 0..x.0.len() {
        let step = x.0[i] - y.0[i];
        energy += step * (x.1[i] - y.1[i]);
        size += x.0[i] * x.0[i];
        if counts(i) {
            length += step * step;
        }
    }
    // Below 1e-6 of λ the quotient of differences loses too many digits.
    (length > 1e-12 * size && energy > 1.000_001 * bound * length).then(|| energy / length)
}
