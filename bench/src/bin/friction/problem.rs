//! A friction problem of the literature, and the measure that judges its answers.
//!
//! ```text
//!   find r ∈ K:   u = Wr + q,   u + μ|uₜ|eₙ ∈ K*,   orthogonal to r
//! ```
//!
//! K is the product of the cones |rₜ| ≤ μrₙ, one per contact, its normal component first. r: forces, compression ≥ 0;
//! u: relative velocities (or displacements), opening ≥ 0; q: those without contact forces.
//! W may be unsymmetric (measured: up to 2e-3) and of low rank. As a dual problem: F = W, d = −q, λ = r, no balance.
//!
//! **The scaled error**, which decides whether a problem is solved:
//!
//! ```text
//!   |r − P_K(r − ϱ(u + μ|uₜ|eₙ))| / max(|r|, ϱ|q|),     ϱ = 1 / max diag W,   |·| Euclidean over all contacts
//! ```
//!
//! It vanishes exactly at solutions. With aW and bq in place of W and q (a, b > 0), the solution is (b/a)r and ϱ becomes ϱ/a:
//! numerator and denominator are both multiplied by b/a, and the error does not change. ϱ|q| keeps the
//! denominator from vanishing with r: at r = 0 the error is at most √(1 + μ²) in any units. A scale of zero counts
//! as 1.
//!
//! **The error of the literature** has ϱ = 1 and |q| below: it changes with the units of W (with W about 1e-5, 1e-8 there
//! is 1e-3 here). Source: Acary, Brémond & Huber (2018), natural map of the second-order cone problem.
//!
//! The projection is written here once more: the judge shares no code with the solvers.

use dotyk::dual::{AdmissibleSet, Balance, Compliance, DualError, DualProblem, Friction};
use dotyk::linalg::SparseMatrix;

/// Largest size for which the rank is computed.
const RANKED: usize = 2000;

/// Largest size for which W is taken with its zeros.
const SPARSE: usize = 600;

/// Columns below this part of the largest column do not count in the rank.
const RANK_TOLERANCE: f64 = 1e-10;

/// W, q, μ.
#[derive(Debug, Clone)]
pub struct Problem {
    /// Components of a contact: 2 or 3.
    pub dimension: usize,
    /// W, (n, n).
    pub matrix: SparseMatrix,
    /// q, (n,).
    pub free: Vec<f64>,
    /// μ, one per contact.
    pub friction: Vec<f64>,
}

impl Problem {
    /// The problem; errors in words: sizes that do not fit, entries that are not finite.
    pub fn new(
        dimension: usize,
        matrix: SparseMatrix,
        free: Vec<f64>,
        friction: Vec<f64>,
    ) -> Result<Self, String> {
        if !(2..=3).contains(&dimension) {
            return Err(format!("a contact has {dimension} components, not 2 or 3"));
        }
        let n = dimension * friction.len();
        if (matrix.rows(), matrix.cols(), free.len()) != (n, n, n) || n == 0 {
            return Err(format!(
                "W is {} by {}, q has {} entries, but {} contacts of dimension {dimension} have {n}",
                matrix.rows(),
                matrix.cols(),
                free.len(),
                friction.len()
            ));
        }
        let numbers = free.iter().chain(&friction);
        let finite = (0..n).all(|i| matrix.row(i).all(|(_, x)| x.is_finite()))
            && numbers.copied().all(f64::is_finite);
        if !finite {
            return Err("an entry is not a finite number".to_string());
        }
        Ok(Self {
            dimension,
            matrix,
            free,
            friction,
        })
    }

    /// Number of components n.
    pub fn size(&self) -> usize {
        self.free.len()
    }

    /// Smallest and largest coefficient of friction.
    pub fn friction_range(&self) -> (f64, f64) {
        let low = self.friction.iter().copied().fold(f64::INFINITY, f64::min);
        (low, self.friction.iter().copied().fold(0.0, f64::max))
    }

    /// W unchanged; a large W without its zeros.
    fn compliance(&self) -> Compliance {
        match self.size() > SPARSE {
            true => Compliance::Sparse(self.matrix.clone()),
            false => Compliance::Dense(self.matrix.to_dense()),
        }
    }

    /// The dual problem with F = W and d = −q.
    pub fn dual(&self) -> Result<DualProblem, DualError> {
        let block =
            |&coefficient: &f64| Friction::Coulomb { coefficient }.block(self.dimension - 1);
        DualProblem::new(
            self.compliance(),
            self.free.iter().map(|q| -q).collect(),
            AdmissibleSet::new(self.friction.iter().map(block).collect()),
            Balance::none(self.size()),
        )
    }

    /// 1 / max diag W, force over velocity; 1 where nothing on the diagonal is positive.
    pub fn unit(&self) -> f64 {
        let diagonal = (0..self.size()).map(|i| {
            let own = self.matrix.row(i).find(|&(j, _)| i == j);
            own.map_or(0.0, |(_, x)| x)
        });
        1.0 / one_if_zero(diagonal.fold(0.0, f64::max))
    }

    /// |r − P_K(r − ϱ(u + μ|uₜ|eₙ))|; `r` (n,).
    fn natural_map(&self, r: &[f64], rho: f64) -> f64 {
        let mut u = vec![0.0; self.size()];
        self.matrix.mul(r, &mut u);
        let contacts = (r.chunks(self.dimension).zip(u.chunks(self.dimension)))
            .zip(self.free.chunks(self.dimension))
            .zip(&self.friction);
        let mut sum = 0.0;
        for (((force, product), free), &mu) in contacts {
            let velocity: Vec<f64> = product.iter().zip(free).map(|(u, q)| u + q).collect();
            let mut trial: Vec<f64> = force
                .iter()
                .zip(&velocity)
                .map(|(r, u)| r - rho * u)
                .collect();
            trial[0] -= rho * mu * norm(&velocity[1..]);
            project(&mut trial, mu);
            sum += force
                .iter()
                .zip(&trial)
                .map(|(r, p)| (r - p).powi(2))
                .sum::<f64>();
        }
        sum.sqrt()
    }

    /// The scale-free error of forces `r` (n,).
    pub fn scaled_error(&self, r: &[f64]) -> f64 {
        let rho = self.unit();
        let size = norm(r).max(rho * norm(&self.free));
        self.natural_map(r, rho) / one_if_zero(size)
    }

    /// The error that the literature uses.
    pub fn literature_error(&self, r: &[f64]) -> f64 {
        self.natural_map(r, 1.0) / one_if_zero(norm(&self.free))
    }

    /// Numerical rank of W, by orthogonalisation of its columns, the longest remaining one first; `None` above 2000.
    pub fn rank(&self) -> Option<usize> {
        let n = self.size();
        if n > RANKED {
            return None;
        }
        let dense = self.matrix.to_dense();
        let mut rest: Vec<Vec<f64>> = (0..n).map(|j| dense.col_as_slice(j).to_vec()).collect();
        let mut first = 0.0;
        for rank in 0..n {
            let longest = rest
                .iter()
                .enumerate()
                .map(|(at, column)| (at, norm(column)))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((at, length)) = longest else { break };
            if rank == 0 {
                first = length;
            }
            if length <= RANK_TOLERANCE * first {
                return Some(rank);
            }
            let direction: Vec<f64> = rest.swap_remove(at).iter().map(|x| x / length).collect();
            for column in &mut rest {
                let part: f64 = column.iter().zip(&direction).map(|(x, d)| x * d).sum();
                if part != 0.0 {
                    column
                        .iter_mut()
                        .zip(&direction)
                        .for_each(|(x, d)| *x -= part * d);
                }
            }
        }
        Some(n)
    }
}

/// Nearest point of the cone |xₜ| ≤ μxₙ, in place.
fn project(x: &mut [f64], mu: f64) {
    let (normal, length) = (x[0], norm(&x[1..]));
    if length <= mu * normal {
        return;
    }
    if mu * length <= -normal {
        x.fill(0.0);
        return;
    }
    let along = (normal + mu * length) / (1.0 + mu * mu);
    x[0] = along;
    x[1..].iter_mut().for_each(|t| *t *= mu * along / length);
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn one_if_zero(scale: f64) -> f64 {
    if scale > 0.0 { scale } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotyk::solve::{ContactSolver, Newton};
    use std::ops::ControlFlow;

    /// One contact of dimension 3 with W = 2 and the given q and μ.
    fn one_contact(free: [f64; 3], mu: f64) -> Problem {
        let matrix = SparseMatrix::from_triplets(3, 3, &[(0, 0, 2.0), (1, 1, 2.0), (2, 2, 2.0)]);
        Problem::new(3, matrix, free.to_vec(), vec![mu]).unwrap()
    }

    /// Two coupled contacts of dimension 2, W unsymmetric.
    fn two_contacts(stretch: f64, load: f64) -> Problem {
        let entries = [
            [3.0, 0.5, 1.0, 0.1],
            [0.5, 2.0, 0.0, 0.3],
            [1.01, 0.0, 4.0, 0.2],
            [0.1, 0.3, 0.2, 2.5],
        ];
        let mut triplets = Vec::new();
        for (i, row) in entries.iter().enumerate() {
            triplets.extend(row.iter().enumerate().map(|(j, x)| (i, j, stretch * x)));
        }
        let free = [-1.0, 0.7, -0.5, -0.2].map(|q| load * q).to_vec();
        let matrix = SparseMatrix::from_triplets(4, 4, &triplets);
        Problem::new(2, matrix, free, vec![0.4, 0.2]).unwrap()
    }

    #[test]
    fn scaled_error_does_not_depend_on_units_and_that_of_the_literature_does() {
        let r = [0.5, -0.1, 0.3, 0.2];
        let problem = two_contacts(1.0, 1.0);
        let error = problem.scaled_error(&r);
        assert!(error > 1e-2);
        for (stretch, load) in [(1e-6, 1.0), (1e5, 1e-12), (3.0, 7e8)] {
            let other = two_contacts(stretch, load);
            let same: Vec<f64> = r.iter().map(|r| r * load / stretch).collect();
            let relative = other.scaled_error(&same) / error - 1.0;
            // Rounding of some twenty operations.
            assert!(relative.abs() < 1e-14, "{relative}");
        }
        let soft = two_contacts(1e-6, 1.0);
        let same: Vec<f64> = r.iter().map(|r| r * 1e6).collect();
        assert!(soft.literature_error(&same) > 10.0 * problem.literature_error(&r));
    }

    #[test]
    fn error_at_zero_force_is_bounded() {
        let pressed = one_contact([-1e-12, 0.0, 0.0], 0.5);
        assert_eq!(pressed.scaled_error(&[0.0; 3]), 1.0);
        let open = one_contact([3.0, 4.0, 0.0], 0.5);
        assert_eq!(open.scaled_error(&[0.0; 3]), 0.0);
        assert!(pressed.scaled_error(&[f64::NAN, 0.0, 0.0]).is_nan());
    }

    #[test]
    fn stick_slip_and_open_by_hand() {
        // u = 2r + q. Stick: r = −q/2. Slip: rₙ = −qₙ/2, rₜ = −μrₙ along the slip, uₜ = qₜ + 2rₜ. Open: r = 0.
        let cases = [
            ([-2.0, 0.3, 0.4], 0.5, [1.0, -0.15, -0.2]),
            ([-2.0, 3.0, 4.0], 0.5, [1.0, -0.3, -0.4]),
            ([2.0, 3.0, 4.0], 0.5, [0.0, 0.0, 0.0]),
            ([-2.0, 3.0, 4.0], 0.0, [1.0, 0.0, 0.0]),
        ];
        for (free, mu, expected) in cases {
            let problem = one_contact(free, mu);
            assert!(problem.scaled_error(&expected) < 1e-15);
            let dual = problem.dual().unwrap();
            let outcome = Newton::default().solve(&dual, None, &mut |_| ControlFlow::Continue(()));
            let found = outcome.unwrap().multipliers.lambda;
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12);
            }
            let mut wrong = expected;
            wrong[1] += 1e-3;
            assert!(problem.scaled_error(&wrong) > 1e-5);
        }
    }

    #[test]
    fn unsymmetric_matrix_reaches_the_dual_problem_as_it_is() {
        let problem = two_contacts(1.0, 1.0);
        let dual = problem.dual().unwrap();
        let (mut own, mut theirs) = (vec![0.0; 4], vec![0.0; 4]);
        problem.matrix.mul(&[1.0, 2.0, 3.0, 4.0], &mut own);
        dual.compliance.apply(&[1.0, 2.0, 3.0, 4.0], &mut theirs);
        assert_eq!(own, theirs);
        assert_eq!(own[0], 7.4);
        assert!((own[2] - 13.81).abs() < 1e-12);
    }

    #[test]
    fn rank_counts_independent_columns() {
        assert_eq!(two_contacts(1e-7, 1.0).rank(), Some(4));
        let row = [1.0, 2.0, 3.0, 4.0];
        let entry = |k: usize| (k / 4, k % 4, row[k / 4] * row[k % 4]);
        let triplets: Vec<_> = (0..16).map(entry).collect();
        let matrix = SparseMatrix::from_triplets(4, 4, &triplets);
        let problem = Problem::new(2, matrix, vec![0.0; 4], vec![0.1; 2]).unwrap();
        assert_eq!(problem.rank(), Some(1));
    }
}
