//! Algorithms for the dual contact problem, one file each; they see a [`DualProblem`] only.
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
mod alternating;
mod anchored;
mod anderson;
mod correct;
mod coulomb;
mod exact;
mod foreign;
mod gradient;
mod hold;
mod interior;
mod iteration;
mod levels;
mod limit;
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
mod torn;
mod uzawa;

pub use accelerated::Accelerated;
pub(crate) use anderson::Anderson;
pub(crate) use correct::{FREE, correction, distance_to_exact, left_open};
pub(crate) use foreign::Foreign;
pub use gradient::Gradient;
pub use mprgp::Mprgp;
pub use newton::Newton;
pub use outcome::{Bolt, FixedPoint, Iterate, Observer, Outcome, SolveError};
pub use secant::Secant;
pub(crate) use setup::largest;
pub(crate) use states::{Shear, State};
pub(crate) use torn::torn;
pub use uzawa::Uzawa;

pub(crate) use crate::linalg::dense::{dot, norm};

use crate::dual::{DualProblem, Multipliers};
use crate::solve::setup::Setup;

/// The automatic fixed step ρ times the upper bound of λ_max: below 2, where the iteration would stop converging.
pub const SAFE_STEP: f64 = 1.9;

/// Relative violation of the optimality conditions at which a solver stops, unless it is told otherwise.
pub const TOLERANCE: f64 = 1e-8;

/// An algorithm for the dual contact problem. A model takes one from outside by
/// [`Model::solve_by`](crate::model::Model::solve_by), and judges its forces as those of all others.
pub trait ContactSolver: Sync {
    /// Its name in reports and case files.
    fn name(&self) -> &str;

    /// Solves `problem`, from `guess` where given, else from a start of its own, such as the projection of zero. It may
    /// tell an observer of its iterations, and makes its answer with [`Outcome::new`].
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

    /// Solves where bounds follow from normal forces: repeatedly, until the bounds no longer change.
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
    fn name(&self) -> &str {
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
    use crate::linalg::{LinearOperator, Mat};
    use std::ops::ControlFlow;

    pub(crate) fn silent(_: &Iterate<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Contacts whose exact steps run in a circle.
    pub(crate) fn circle() -> DualProblem {
        let a = [
            [0.5, 0.1, 0.3, 0.9, 1.0, -0.3],
            [0.2, 0.2, 0.7, 0.7, -0.1, 0.6],
        ];
        let shift = [0.6, -0.6, 0.6, -0.6, 0.2, 0.8];
        of_rank(&a, &shift, vec![Block::Unilateral; 6], (&[], &[]))
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

    /// The problem of any F, d, Λ, G and e.
    pub(crate) fn of(
        compliance: Compliance,
        shift: &[f64],
        blocks: Vec<Block>,
        (modes, load): (&[Vec<f64>], &[f64]),
    ) -> DualProblem {
        let modes = Mat::from_fn(modes.len(), shift.len(), |i, j| modes[i][j]);
        let balance = Balance::new(modes, load.to_vec());
        let admissible = AdmissibleSet::new(blocks);
        DualProblem::new(compliance, shift.to_vec(), admissible, balance).unwrap()
    }

    /// A definite matrix in which all contacts are coupled, each pair differently.
    pub(crate) fn definite(m: usize) -> Mat<f64> {
        let own = |i: usize| 0.2 + 0.1 * (1.0 + i as f64).sin();
        Mat::from_fn(m, m, |i, j| {
            (-0.5 * i.abs_diff(j) as f64).exp() + if i == j { own(i) } else { 0.0 }
        })
    }

    /// A matrix as an operator.
    pub(crate) struct Applied(pub Mat<f64>);

    impl LinearOperator for Applied {
        fn len(&self) -> usize {
            self.0.nrows()
        }

        fn apply(&self, x: &[f64], y: &mut [f64]) {
            for (i, y) in y.iter_mut().enumerate() {
                *y = (0..x.len()).map(|j| self.0[(i, j)] * x[j]).sum();
            }
        }
    }

    /// F that is applied, with this preconditioner.
    pub(crate) fn applied(f: &Mat<f64>, preconditioner: Mat<f64>) -> Compliance {
        Compliance::Operator {
            apply: Box::new(Applied(f.clone())),
            preconditioner: Box::new(Applied(preconditioner)),
            glue: None,
        }
    }

    /// Ax.
    pub(crate) fn times(a: &Mat<f64>, x: &[f64]) -> Vec<f64> {
        let row = |i: usize| (0..x.len()).map(|j| a[(i, j)] * x[j]).sum();
        (0..a.nrows()).map(row).collect()
    }

    /// The largest difference of two vectors.
    pub(crate) fn apart(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter()
            .zip(b)
            .fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()))
    }

    /// x with Ax = b by elimination with exchange of rows; `None` where a pivot is zero.
    pub(crate) fn eliminated(a: &Mat<f64>, b: &[f64]) -> Option<Vec<f64>> {
        let n = b.len();
        let mut rows: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| a[(i, j)]).chain([b[i]]).collect())
            .collect();
        for j in 0..n {
            let pivot = (j..n).max_by(|&p, &q| rows[p][j].abs().total_cmp(&rows[q][j].abs()))?;
            rows.swap(j, pivot);
            if rows[j][j].abs() < 1e-13 {
                return None;
            }
            for i in (0..n).filter(|&i| i != j) {
                let factor = rows[i][j] / rows[j][j];
                let pivot = rows[j].clone();
                let pairs = rows[i].iter_mut().zip(&pivot);
                pairs.for_each(|(x, pivot)| *x -= factor * pivot);
            }
        }
        Some((0..n).map(|i| rows[i][n] / rows[i][i]).collect())
    }

    /// λ and α of unilateral contacts, by trial of every choice of closed ones: the choice with forces ≥ 0 and gaps ≥ 0 is the
    /// answer.
    pub(crate) fn by_trial(
        f: &Mat<f64>,
        shift: &[f64],
        (modes, load): (&[Vec<f64>], &[f64]),
    ) -> Multipliers {
        let (m, r) = (shift.len(), load.len());
        for choice in 0..1usize << m {
            let closed: Vec<usize> = (0..m).filter(|i| choice >> i & 1 == 1).collect();
            let n = closed.len();
            let bordered = Mat::from_fn(n + r, n + r, |i, j| match (i < n, j < n) {
                (true, true) => f[(closed[i], closed[j])],
                (true, false) => -modes[j - n][closed[i]],
                (false, true) => modes[i - n][closed[j]],
                (false, false) => 0.0,
            });
            let right: Vec<f64> = closed.iter().map(|&i| shift[i]).collect();
            let right: Vec<f64> = right.into_iter().chain(load.iter().copied()).collect();
            let Some(x) = eliminated(&bordered, &right) else {
                continue;
            };
            let (mut lambda, alpha) = (vec![0.0; m], x[n..].to_vec());
            closed.iter().zip(&x).for_each(|(&i, x)| lambda[i] = *x);
            let product = times(f, &lambda);
            let gap = |i: usize| {
                let rigid: f64 = (0..r).map(|j| modes[j][i] * alpha[j]).sum();
                product[i] - shift[i] - rigid
            };
            let open = |i: usize| closed.contains(&i) || gap(i) >= 0.0;
            if lambda.iter().all(|force| *force >= 0.0) && (0..m).all(open) {
                return Multipliers { lambda, alpha };
            }
        }
        panic!("no choice of closed contacts is an answer");
    }

    /// λ of unilateral contacts and intervals, by trial of every choice of states. In an interval λ is at an end where its gap
    /// moves against it.
    fn by_trial_of_states(f: &Mat<f64>, shift: &[f64], blocks: &[Block]) -> Vec<f64> {
        let m = shift.len();
        for choice in 0..3usize.pow(m as u32) {
            let state: Vec<usize> = (0..m).map(|i| choice / 3usize.pow(i as u32) % 3).collect();
            // 0 closed or within, 1 open or at the upper end, 2 at the lower end
            let known = |i: usize| match (&blocks[i], state[i]) {
                (_, 0) => None,
                (Block::Interval { bound }, 1) => Some(*bound),
                (Block::Interval { bound }, _) => Some(-bound),
                (_, 1) => Some(0.0),
                _ => Some(f64::NAN),
            };
            let matrix = Mat::from_fn(m, m, |i, j| match known(i) {
                None => f[(i, j)],
                Some(_) => f64::from(i == j),
            });
            let right: Vec<f64> = (0..m).map(|i| known(i).unwrap_or(shift[i])).collect();
            let Some(lambda) =
                eliminated(&matrix, &right).filter(|l| l.iter().all(|l| l.is_finite()))
            else {
                continue;
            };
            let product = times(f, &lambda);
            let holds = |i: usize| {
                let (force, gap) = (lambda[i], product[i] - shift[i]);
                match (&blocks[i], state[i]) {
                    (Block::Interval { bound }, 0) => force.abs() <= *bound,
                    (Block::Interval { .. }, 1) => gap <= 0.0,
                    (Block::Interval { .. }, _) => gap >= 0.0,
                    (_, 0) => force >= 0.0,
                    _ => gap >= 0.0,
                }
            };
            if (0..m).all(holds) {
                return lambda;
            }
        }
        panic!("no choice of states is an answer");
    }

    #[test]
    fn every_method_finds_what_intervals_bear_beside_contacts() {
        let mut ends = [0; 3];
        for seed in 0..40 {
            let f = definite(6);
            let shift: Vec<f64> = (0..6)
                .map(|i| 2.0 * (2.1 * i as f64 + 1.7 * f64::from(seed)).sin())
                .collect();
            let interval = |bound| Block::Interval { bound };
            let contact = Block::Unilateral;
            let blocks = [
                interval(0.4),
                contact,
                interval(0.7),
                contact,
                interval(0.3),
                contact,
            ];
            let expected = by_trial_of_states(&f, &shift, &blocks);
            for (force, block) in expected.iter().zip(&blocks) {
                if let Block::Interval { bound } = block {
                    ends[match *force {
                        force if force >= bound - 1e-12 => 1,
                        force if force <= 1e-12 - bound => 2,
                        _ => 0,
                    }] += 1;
                }
            }
            let problem = of(
                Compliance::Dense(f.clone()),
                &shift,
                blocks.to_vec(),
                (&[], &[]),
            );
            let operator = applied(&f, Mat::from_fn(6, 6, |i, j| f64::from(i == j)));
            let other = of(operator, &shift, blocks.to_vec(), (&[], &[]));
            let solvers: [&dyn ContactSolver; 5] = [
                &Gradient::default(),
                &Accelerated::default(),
                &Secant::default(),
                &Mprgp::default(),
                &Newton::default(),
            ];
            for solver in solvers {
                for problem in [&problem, &other] {
                    let found = solver.solve(problem, None, &mut silent).unwrap();
                    let lambda = &found.multipliers.lambda;
                    let told = format!("{} {seed}: {lambda:?} {expected:?}", solver.name());
                    assert!(apart(lambda, &expected) < 1e-6, "{told}");
                    let certificate = problem.certify(&found.multipliers, 1e-6);
                    assert!(certificate.holds(), "{told} {certificate}");
                    // and it notices a force beyond an end, or short of it
                    let mut wrong = found.multipliers.clone();
                    wrong.lambda[0] = if lambda[0] >= 0.4 - 1e-9 { 0.3 } else { 0.41 };
                    assert!(!problem.certify(&wrong, 1e-6).holds(), "{told}");
                }
            }
        }
        assert!(ends.iter().all(|&count| count > 10), "{ends:?}");
    }

    #[test]
    fn other_limits_leave_the_rest_of_a_method_as_it_is() {
        let own = Uzawa {
            rho: Some(0.25),
            bolts: Some(vec![3]),
            tolerance: 1e-5,
            max_iterations: 12,
            move_improper: false,
        };
        assert_eq!(own.limits(), (1e-5, 12));
        let other = own.within(1e-3, 7);
        assert_eq!(other.limits(), (1e-3, 7));
        let expected = Uzawa {
            tolerance: 1e-3,
            max_iterations: 7,
            ..own
        };
        assert_eq!(other, expected);
    }

    #[test]
    fn every_method_has_the_name_of_case_files_and_its_default_limits() {
        let solvers: [&dyn ContactSolver; 6] = [
            &Uzawa::default(),
            &Gradient::default(),
            &Accelerated::default(),
            &Secant::default(),
            &Mprgp::default(),
            &Newton::default(),
        ];
        let names = solvers.map(|solver| solver.name());
        let expected = [
            "uzawa",
            "gradient",
            "accelerated",
            "secant",
            "mprgp",
            "newton",
        ];
        assert_eq!(names, expected);
        assert_eq!(Uzawa::default().limits(), (1e-8, 200_000));
        assert_eq!(Gradient::default().limits(), (1e-8, 200_000));
        assert_eq!(Accelerated::default().limits(), (1e-8, 100_000));
        assert_eq!(Secant::default().limits(), (1e-8, 100_000));
        assert_eq!(Mprgp::default().limits(), (1e-8, 20_000));
        assert_eq!(Newton::default().limits(), (1e-8, 600));
    }

    #[test]
    fn forces_of_either_sign_are_loaded_and_zero_is_not() {
        assert_eq!(loaded(&[0.0, -1e-300, 2.0, -0.0]), 2);
        assert_eq!(loaded(&[]), 0);
    }

    #[test]
    fn every_method_finds_the_forces_that_trial_of_all_choices_finds() {
        // ten contacts on one body that floats and turns: 1024 choices
        let f = definite(10);
        let shift: Vec<f64> = (0..10).map(|i| (2.1 * i as f64).sin()).collect();
        let modes = [
            vec![1.0; 10],
            (0..10).map(|i| i as f64 / 9.0 - 0.3).collect(),
        ];
        let balance = (&modes[..], &[3.0, 0.8][..]);
        let expected = by_trial(&f, &shift, balance);
        let open = expected
            .lambda
            .iter()
            .filter(|force| **force == 0.0)
            .count();
        assert!((2..8).contains(&open), "{open} of ten contacts are open");
        let problem = of(
            Compliance::Dense(f),
            &shift,
            vec![Block::Unilateral; 10],
            balance,
        );
        let solvers: [&dyn ContactSolver; 6] = [
            &Uzawa::default(),
            &Gradient::default(),
            &Accelerated::default(),
            &Secant::default(),
            &Mprgp::default(),
            &Newton::default(),
        ];
        for solver in solvers {
            let found = solver.solve(&problem, None, &mut silent).unwrap();
            let (lambda, alpha) = (&found.multipliers.lambda, &found.multipliers.alpha);
            // residual 1e-8; the least eigenvalue of F is 0.3 of its scale
            assert!(apart(lambda, &expected.lambda) < 1e-6, "{}", solver.name());
            assert!(apart(alpha, &expected.alpha) < 1e-6, "{}", solver.name());
            assert_eq!(found.exact, solver.name() == "newton");
        }
    }
}
