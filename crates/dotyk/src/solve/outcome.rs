//! Reports of a solver while it runs, and its outcome.

use crate::dual::{Block, DualError, Multipliers};
use std::ops::ControlFlow;

/// One iteration as an observer sees it.
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
    /// `p` proportioning (MPRGP) or proximal step (Newton), `n` exact Newton step, `i` interior point, `d` alternating directions (Newton).
    pub step: char,
}

/// Called once per iteration. `Break`: the caller is satisfied, the iterate is returned as it is.
pub type Observer<'a> = &'a mut dyn FnMut(&Iterate<'_>) -> ControlFlow<()>;

/// An answer and its cost, made by [`Outcome::new`].
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
    /// The forces come from one linear solve on the problem itself with the states of all contacts.
    pub(crate) exact: bool,
    /// The observer stopped it: the answer need not pass the certificate.
    pub stopped_by_observer: bool,
    /// The fixed point of problems with given bounds, where bounds that follow from normal forces were reached by one.
    pub fixed_point: Option<FixedPoint>,
    /// Remarks to the user, in words.
    pub remarks: Vec<String>,
    /// Stages of Newton's method in the order in which they were entered; the last one answered.
    pub tried: Vec<&'static str>,
}

/// The fixed point of bounds ↦ bounds that follow from the normal forces of the solution with them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedPoint {
    /// Problems with given bounds that were solved.
    pub iterations: usize,
    /// Estimated factor by which each of them reduces the error of the bounds; below 1 the map contracts here, which
    /// speaks for a unique solution. `None`: the bounds settled before it could be estimated.
    pub contraction: Option<f64>,
}

impl Outcome {
    /// The answer of a solver after some iterations; the public fields take all else.
    pub fn new(multipliers: Multipliers, iterations: usize) -> Self {
        Self {
            multipliers,
            iterations,
            products: 0,
            rho: None,
            bolts: Vec::new(),
            exact: false,
            fixed_point: None,
            stopped_by_observer: false,
            remarks: Vec::new(),
            tried: Vec::new(),
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
        method: String,
        /// The last iterate.
        outcome: Box<Outcome>,
        /// Its residual.
        residual: f64,
        /// Cause and advice.
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
    /// Some contact forces balance the load, but not those that follow from the compliance of the bodies: friction is exhausted before.
    #[error(
        "friction does not bear the load along the rigid motion {direction:?}, but {factor} of it"
    )]
    Slides {
        /// Amplitudes (r,): the motion.
        direction: Vec<f64>,
        /// Largest part of the load along that motion which friction bears.
        factor: f64,
    },
    /// The solver cannot treat a block of the admissible set.
    #[error("{method} cannot treat block {block} of the admissible set: {reason}")]
    Unsupported {
        /// Name of the solver.
        method: String,
        /// Index of the block.
        block: usize,
        /// The block.
        found: Block,
        /// The reason, and a solver to use instead.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correction_adds_increments_counts_one_step_and_keeps_the_rest() {
        let multipliers = Multipliers {
            lambda: vec![1.0, -2.0],
            alpha: vec![0.5],
        };
        let before = Outcome {
            products: 9,
            rho: Some(0.5),
            remarks: vec!["said".to_string()],
            ..Outcome::new(multipliers, 4)
        };
        assert!(!before.exact && !before.stopped_by_observer);
        let after = before.corrected(&Multipliers {
            lambda: vec![0.25, 1.0],
            alpha: vec![-1.0],
        });
        let expected = Outcome {
            multipliers: Multipliers {
                lambda: vec![1.25, -1.0],
                alpha: vec![-0.5],
            },
            iterations: 5,
            exact: true,
            ..before
        };
        assert_eq!(after, expected);
    }

    #[test]
    fn a_new_answer_tells_forces_and_iterations_alone() {
        let multipliers = Multipliers {
            lambda: vec![3.0],
            alpha: Vec::new(),
        };
        let outcome = Outcome::new(multipliers.clone(), 7);
        assert_eq!(outcome.multipliers, multipliers);
        assert_eq!((outcome.iterations, outcome.products), (7, 0));
        assert!(!outcome.exact && !outcome.stopped_by_observer);
        assert_eq!((outcome.rho, outcome.fixed_point), (None, None));
        assert!(outcome.bolts.is_empty() && outcome.remarks.is_empty());
    }
}
