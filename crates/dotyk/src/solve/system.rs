//! The linear problem of a guess of states: unknown forces x and rigid amplitudes α̂ with
//!
//! ```text
//!   wₐ·gap + softnessₐ xₐ = pullₐ,   gap = Fλ − d − Ĝᵀα̂,   Ĝλ = ê,   λ = offset + Σ xₐ cₐ
//! ```
//!
//! Assembled F, symmetric (c = w): Cholesky of A = WᵀFW + softness and the Schur complement of the balance. Where A is
//! semidefinite (grounded floating bodies, redundant contacts) ϱĜᵀĜ is added, which changes nothing where Ĝλ = ê, and then a
//! shift of rounding size; corrections with the true residual remove the effect of the shift. Unsymmetric (slip with
//! Coulomb's law): LU with pivoting. Unknowns are scaled to a unit diagonal, so that stiff contacts are not lost beside soft
//! ones, by powers of two, which rounds nothing.
//!
//! Sparse F: sparse LU with pivoting of the bordered matrix, with the balance in the modes of the single bodies, which are
//! sparser than orthonormal ones; the shift and the corrections are the same.
//!
//! Applied F: by iterations (`system/krylov.rs`).
//!
//! Directions of α̂ that no unknown determines come back in `loose`; α̂ has no part along them.

mod krylov;
mod network;

use crate::dual::{Balance, Compliance, NO_WORK};
use crate::linalg::dense::{
    Lu, cholesky_in_place, solve_cholesky_in_place, solve_lower_in_place,
    solve_lower_transpose_in_place, transpose_product,
};
use crate::linalg::{Mat, SparseLu, SparseMatrix, SparseVector};
use crate::solve::null::{Pseudo, add_outer, gram_of};
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::{Anchor, State, Unknown, along, unknowns};
use crate::solve::{dot, norm};

/// A squared Cholesky pivot below this part of its diagonal entry marks a dependent row.
const DEPENDENT: f64 = 1e-13;

/// Shift of a singular matrix, relative to its diagonal.
const SHIFT: f64 = 1e-10;

/// Parts of a loose direction below this one are rounding: it is orthonormal to some 1e-15, times the condition number of the
/// supports.
pub(crate) const LOOSE: f64 = 1e-9;

/// Largest relative residual of a solve with the factor of a regular matrix.
const SOLVED: f64 = 1e-6;

/// Most corrections of a solution; a shifted matrix needs more of them than rounding.
const CORRECTIONS: usize = 8;

/// The linear problem of some unknowns.
pub(crate) struct System<'a> {
    setup: &'a Setup<'a>,
    unknowns: Vec<Unknown>,
    /// Known forces beside them, (m,).
    offset: Vec<f64>,
    /// Ĝ cₐ and Ĝ wₐ, k rows over the unknowns; beside a sparse F those of M = LĜ, of which fewer are not zero.
    forces: Vec<SparseVector>,
    rows: Vec<SparseVector>,
    /// Directions of α̂ that no row determines, orthonormal.
    pub loose: Vec<Vec<f64>>,
    /// The solution was determined without a shift.
    pub unique: bool,
}

impl<'a> System<'a> {
    /// The problem of `states`, with the conditions and the compliance `own` as in [`unknowns`].
    pub fn of(
        setup: &'a Setup<'a>,
        states: &[State],
        anchor: Option<Anchor<'_>>,
        own: &[f64],
    ) -> Self {
        let (unknowns, offset) = unknowns(&setup.admissible, states, anchor, own);
        Self::new(setup, unknowns, offset)
    }

    /// The problem of `unknowns` beside the known forces `offset` (m,).
    pub fn new(setup: &'a Setup<'a>, unknowns: Vec<Unknown>, offset: Vec<f64>) -> Self {
        let balance = &setup.balance;
        let rows = on_unknowns(balance.rows(), &unknowns, Side::Rows);
        let forces = on_unknowns(balance.rows(), &unknowns, Side::Forces);
        let loose = null_of(balance, &rows);
        let sparse = matches!(setup.problem.compliance, Compliance::Sparse(_));
        let [rows, forces] = match sparse {
            true => [rows, forces],
            false => [rows, forces].map(|rows| balance.orthonormal_rows(rows)),
        };
        Self {
            setup,
            unknowns,
            offset,
            forces,
            rows,
            loose,
            unique: false,
        }
    }

    /// Whether some values of the unknowns balance the load.
    pub fn carries(&self) -> bool {
        let mut rest = vec![0.0; self.setup.modes()];
        self.setup.balance.imbalance(&self.offset, &mut rest);
        let size = norm(self.setup.balance.target()).max(norm(&rest));
        let symmetric = self.unknowns.iter().all(Unknown::is_symmetric);
        let null = match symmetric {
            true => self.loose.clone(),
            false => self.loose_forces(),
        };
        null.iter().all(|z| dot(z, &rest).abs() <= NO_WORK * size)
    }

    /// Directions of the balance that no value of the unknowns changes, orthonormal.
    fn loose_forces(&self) -> Vec<Vec<f64>> {
        let balance = &self.setup.balance;
        let forces = on_unknowns(balance.rows(), &self.unknowns, Side::Forces);
        null_of(balance, &forces)
    }

    /// Solves from `guess`, with a relative accuracy that only iterations use; `None` where the system is singular.
    pub fn solve(&mut self, guess: &Forces, accuracy: f64) -> Option<Forces> {
        let point = match &self.setup.problem.compliance {
            Compliance::Dense(_) | Compliance::Sparse(_) => self.solve_assembled(),
            Compliance::Operator {
                preconditioner,
                glue,
                ..
            } => self.solve_applied((preconditioner.as_ref(), glue.as_deref()), guess, accuracy),
        }?;
        let finite = point
            .lambda
            .iter()
            .chain(&point.alpha)
            .all(|x| x.is_finite());
        finite.then_some(point)
    }

    fn solve_assembled(&mut self) -> Option<Forces> {
        let (n, k) = (self.unknowns.len(), self.setup.modes());
        let factored = Factored::new(self)?;
        self.unique = !factored.shifted;
        let (mut x, mut alpha) = (vec![0.0; n], vec![0.0; k]);
        let mut point = self.point(&x, alpha.clone());
        let mut before = f64::INFINITY;
        // the first pass solves, the later ones correct
        for pass in 0..=CORRECTIONS {
            let (right, rest) = self.residual(&point, &x);
            let size = factored.size(&right, &rest);
            if size == 0.0 || size >= 0.5 * before || (pass > 2 && !factored.shifted) {
                break;
            }
            before = size;
            let (dx, dalpha) = factored.solve(&self.setup.balance, &right, &rest);
            x.iter_mut().zip(&dx).for_each(|(x, d)| *x += d);
            alpha.iter_mut().zip(&dalpha).for_each(|(a, d)| *a += d);
            for z in &self.loose {
                let part = dot(z, &alpha);
                alpha.iter_mut().zip(z).for_each(|(a, z)| *a -= part * z);
            }
            point = self.point(&x, alpha.clone());
        }
        Some(point)
    }

    /// The forces of some values of the unknowns.
    fn point(&self, x: &[f64], alpha: Vec<f64>) -> Forces {
        let mut lambda = self.offset.clone();
        for (unknown, x) in self.unknowns.iter().zip(x) {
            for &(i, weight) in &unknown.force {
                lambda[i] += x * weight;
            }
        }
        let mut product = vec![0.0; lambda.len()];
        if lambda.iter().any(|force| *force != 0.0) {
            self.setup.multiply(&lambda, &mut product);
        }
        Forces {
            lambda,
            alpha,
            product,
        }
    }

    /// Residuals of the conditions, (n,), and of the balance, (k,).
    fn residual(&self, point: &Forces, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut gap = point.product.clone();
        let shift = &self.setup.shift;
        gap.iter_mut().zip(shift).for_each(|(gap, d)| *gap -= d);
        self.setup
            .balance
            .add_transposed(-1.0, &point.alpha, &mut gap);
        let open = self.unknowns.iter().zip(x);
        let right = open.map(|(u, x)| u.pull - along(&u.row, &gap) - u.softness * x);
        let mut rest = vec![0.0; self.setup.modes()];
        self.setup.balance.imbalance(&point.lambda, &mut rest);
        rest.iter_mut().for_each(|rest| *rest = -*rest);
        (right.collect(), rest)
    }
}

impl System<'_> {
    /// Scale of the unknown `a`, not from its diagonal entry `own` alone: that is rounding where a body is grounded.
    fn unit_of(&self, a: usize, own: f64) -> f64 {
        let unknown = &self.unknowns[a];
        let softness = &self.setup.problem.softness;
        let weights = unknown.force.iter().zip(&unknown.row);
        let least = weights.map(|(c, w)| (c.1 * w.1).abs() * softness[c.0]);
        unit_scale(own.abs().max(least.sum()))
    }
}

/// Scale of every row of the balance of scaled unknowns, of which `forces` and `rows` are the two sides.
fn units_of_balance(forces: &[SparseVector], rows: &[SparseVector], scale: &[f64]) -> Vec<f64> {
    let unit = |(forces, rows): (&SparseVector, &SparseVector)| {
        let pushes = forces.entries().chain(rows.entries());
        unit_scale(pushes.fold(0.0, |s: f64, (a, g)| s.max((g * scale[a]).powi(2))))
    };
    forces.iter().zip(rows).map(unit).collect()
}

/// The column of an unknown, or the row of its condition.
#[derive(Clone, Copy)]
enum Side {
    Forces,
    Rows,
}

impl Side {
    fn of(self, unknown: &Unknown) -> &[(usize, f64)] {
        match self {
            Self::Forces => &unknown.force,
            Self::Rows => &unknown.row,
        }
    }
}

/// Rows over the forces as rows over the unknowns.
fn on_unknowns(rows: &[SparseVector], unknowns: &[Unknown], side: Side) -> Vec<SparseVector> {
    let Some(m) = rows.first().map(SparseVector::len) else {
        return Vec::new();
    };
    let mut met: Vec<Vec<(usize, f64)>> = vec![Vec::new(); m];
    for (a, unknown) in unknowns.iter().enumerate() {
        let parts = side.of(unknown).iter();
        parts.for_each(|&(i, weight)| met[i].push((a, weight)));
    }
    let along_row = |row: &SparseVector| {
        let entries = row.entries();
        let parts = entries.flat_map(|(i, g)| met[i].iter().map(move |&(a, w)| (a, w * g)));
        SparseVector::sum(unknowns.len(), parts.collect())
    };
    rows.iter().map(along_row).collect()
}

/// Orthonormal α̂ (k,) whose pull vanishes on unknowns on which M has these `rows`.
fn null_of(balance: &Balance, rows: &[SparseVector]) -> Vec<Vec<f64>> {
    let whole = || Pseudo::new(&gram_of(&balance.orthonormal_rows(rows.to_vec())), &[]).null;
    balance.loose(rows).unwrap_or_else(whole)
}

/// The nearest power of two to 1/√x, or 1.
fn unit_scale(diagonal: f64) -> f64 {
    match diagonal > 0.0 && diagonal.is_finite() {
        true => (-0.5 * diagonal.log2()).round().exp2(),
        false => 1.0,
    }
}

/// A factored assembled system.
struct Factored {
    /// Scale of each unknown.
    scale: Vec<f64>,
    kind: Kind,
    /// The matrix was changed: corrections must undo it.
    shifted: bool,
}

enum Kind {
    /// Cholesky factor of the scaled A + ϱĜᵀĜ, the scaled Ĝᵀ and A⁻¹Ĝᵀ (n, k), and the Schur complement.
    Symmetric {
        factor: Mat<f64>,
        rho: f64,
        rows: Mat<f64>,
        solved: Mat<f64>,
        schur: Pseudo,
    },
    /// LU of the whole, with the scale of every row of the balance.
    General { lu: Lu, balance: Vec<f64> },
    /// Sparse LU of the same.
    Sparse {
        lu: Box<SparseLu>,
        balance: Vec<f64>,
    },
}

impl Factored {
    fn new(system: &System<'_>) -> Option<Self> {
        match &system.setup.problem.compliance {
            Compliance::Dense(matrix) => Self::dense(system, matrix),
            Compliance::Sparse(matrix) => Self::sparse(system, matrix),
            Compliance::Operator { .. } => None,
        }
    }

    fn dense(system: &System<'_>, matrix: &Mat<f64>) -> Option<Self> {
        let unknowns = &system.unknowns;
        let symmetric = unknowns.iter().all(Unknown::is_symmetric);
        let mut whole = coupling(matrix, unknowns);
        for (a, unknown) in unknowns.iter().enumerate() {
            whole[(a, a)] += unknown.softness;
        }
        let scale: Vec<f64> = (0..unknowns.len())
            .map(|a| system.unit_of(a, whole[(a, a)]))
            .collect();
        for b in 0..unknowns.len() {
            let column = whole.col_as_slice_mut(b).iter_mut();
            column
                .zip(&scale)
                .for_each(|(value, s)| *value *= s * scale[b]);
        }
        match symmetric {
            true => Self::symmetric(system, whole, scale),
            false => Self::general(system, whole, scale),
        }
    }

    fn symmetric(system: &System<'_>, whole: Mat<f64>, scale: Vec<f64>) -> Option<Self> {
        let (n, k) = (scale.len(), system.rows.len());
        let rows = Mat::from_fn(n, k, |a, j| system.rows[j][a] * scale[a]);
        let weight: f64 = (0..k)
            .map(|j| dot(rows.col_as_slice(j), rows.col_as_slice(j)))
            .sum();
        let soft = system.unknowns.iter().all(|u| u.softness > 0.0);
        let rho = if weight > 0.0 { n as f64 / weight } else { 0.0 };
        let mut attempts = Vec::new();
        if soft || k == 0 {
            attempts.push((0.0, 0.0));
        }
        if k > 0 {
            attempts.push((rho, 0.0));
        }
        attempts.push((rho, SHIFT));
        for (rho, shift) in attempts {
            let mut factor = whole.clone();
            if rho > 0.0 {
                add_outer(&mut factor, rho, &rows);
            }
            for a in 0..n {
                factor[(a, a)] += shift;
            }
            let diagonal: Vec<f64> = (0..n).map(|a| factor[(a, a)]).collect();
            if cholesky_in_place(&mut factor).is_err() {
                continue;
            }
            let dependent = |a: usize| factor[(a, a)].powi(2) <= DEPENDENT * diagonal[a];
            if shift == 0.0 && (0..n).any(dependent) {
                continue;
            }
            let mut solved = rows.clone();
            solve_lower_in_place(&factor, &mut solved);
            solve_lower_transpose_in_place(&factor, &mut solved);
            let schur = transpose_product(&rows, &solved);
            let schur = Mat::from_fn(k, k, |i, j| 0.5 * (schur[(i, j)] + schur[(j, i)]));
            return Some(Self {
                scale,
                kind: Kind::Symmetric {
                    factor,
                    rho,
                    rows,
                    solved,
                    schur: Pseudo::new(&schur, &system.loose),
                },
                shifted: shift > 0.0,
            });
        }
        None
    }

    fn general(system: &System<'_>, whole: Mat<f64>, scale: Vec<f64>) -> Option<Self> {
        let (n, k) = (scale.len(), system.rows.len());
        let balance = units_of_balance(&system.forces, &system.rows, &scale);
        let bordered = |shift: f64| {
            Mat::from_fn(n + k, n + k, |i, j| match (i < n, j < n) {
                (true, true) => whole[(i, j)] + if i == j { shift } else { 0.0 },
                (true, false) => -system.rows[j - n][i] * scale[i] * balance[j - n],
                (false, true) => system.forces[i - n][j] * scale[j] * balance[i - n],
                // α̂ has no part along directions that no row determines
                (false, false) => {
                    let loose = system.loose.iter().map(|z| z[i - n] * z[j - n]);
                    loose.sum::<f64>() * balance[i - n] * balance[j - n]
                }
            })
        };
        for shift in [0.0, SHIFT] {
            if let Ok(lu) = Lu::new(bordered(shift)) {
                return Some(Self {
                    scale,
                    kind: Kind::General { lu, balance },
                    shifted: shift > 0.0,
                });
            }
        }
        None
    }

    /// Sparse LU of the bordered matrix: the coupling and the softness of the unknowns, and the balance in its own modes, which
    /// are sparser than orthonormal ones.
    fn sparse(system: &System<'_>, matrix: &SparseMatrix) -> Option<Self> {
        let mut whole = sparse_coupling(matrix, &system.unknowns);
        let n = system.unknowns.len();
        let mut diagonal: Vec<f64> = system.unknowns.iter().map(|u| u.softness).collect();
        whole.extend((0..n).map(|a| (a, a, diagonal[a])));
        let own = whole.iter().take(whole.len() - n).filter(|e| e.0 == e.1);
        own.for_each(|&(a, _, value)| diagonal[a] += value);
        let scale: Vec<f64> = (0..n).map(|a| system.unit_of(a, diagonal[a])).collect();
        let own = &system.setup.balance;
        let (rows, forces) = (&system.rows, &system.forces);
        let balance = units_of_balance(forces, rows, &scale);
        let size = n + balance.len();
        whole
            .iter_mut()
            .for_each(|(a, b, value)| *value *= scale[*a] * scale[*b]);
        for (j, unit) in balance.iter().enumerate() {
            let rows = rows[j].entries();
            whole.extend(rows.map(|(a, g)| (a, n + j, -g * scale[a] * unit)));
            let forces = forces[j].entries();
            whole.extend(forces.map(|(a, g)| (n + j, a, g * scale[a] * unit)));
        }
        // the amplitudes have no part along directions that no row determines
        for z in &system.loose {
            let z = own.to_rows(z);
            let least = LOOSE * z.iter().fold(0.0, |s: f64, z| s.max(z.abs()));
            let part = |i: &usize| z[*i].abs() > least;
            let met: Vec<usize> = (0..z.len()).filter(part).collect();
            let pairs = met.iter().flat_map(|&i| met.iter().map(move |&j| (i, j)));
            whole.extend(pairs.map(|(i, j)| (n + i, n + j, z[i] * z[j] * balance[i] * balance[j])));
        }
        for shift in [0.0, SHIFT] {
            whole.extend((0..n).map(|a| (a, a, shift)));
            let a = SparseMatrix::from_triplets(size, size, &whole);
            if let Some(lu) = SparseLu::new(&a).ok().filter(|lu| solves(lu, &a)) {
                return Some(Self {
                    scale,
                    kind: Kind::Sparse {
                        lu: Box::new(lu),
                        balance,
                    },
                    shifted: shift > 0.0,
                });
            }
        }
        None
    }

    /// Size of a residual, in scaled units.
    fn size(&self, right: &[f64], rest: &[f64]) -> f64 {
        let scaled = right.iter().zip(&self.scale).map(|(r, s)| (r * s).powi(2));
        scaled.sum::<f64>().sqrt() + norm(rest)
    }

    /// x and α̂ for the right sides (n,) and (k,), of the balance `own`.
    fn solve(&self, own: &Balance, right: &[f64], rest: &[f64]) -> (Vec<f64>, Vec<f64>) {
        match &self.kind {
            Kind::Symmetric {
                factor,
                rho,
                rows,
                solved,
                schur,
            } => {
                let scaled = right.iter().zip(&self.scale).map(|(r, s)| r * s);
                let mut x: Vec<f64> = scaled.collect();
                solve_cholesky_in_place(factor, &mut x);
                let mut alpha: Vec<f64> = (0..rest.len())
                    .map(|j| rest[j] - dot(rows.col_as_slice(j), &x))
                    .collect();
                schur.solve(&mut alpha, &mut vec![0.0; rest.len()]);
                for (j, alpha) in alpha.iter().enumerate() {
                    let column = solved.col_as_slice(j).iter();
                    x.iter_mut().zip(column).for_each(|(x, s)| *x += alpha * s);
                }
                // the added term pulls with ϱĜᵀ(Ĝλ − ê)
                alpha
                    .iter_mut()
                    .zip(rest)
                    .for_each(|(a, rest)| *a -= rho * rest);
                x.iter_mut().zip(&self.scale).for_each(|(x, s)| *x *= s);
                (x, alpha)
            }
            Kind::General { lu, balance } => self.solve_bordered(right, rest, balance, |both| {
                let mut x = Mat::from_fn(both.len(), 1, |i, _| both[i]);
                lu.solve_in_place(&mut x);
                both.copy_from_slice(x.col_as_slice(0));
            }),
            Kind::Sparse { lu, balance } => {
                let rest = own.rest_of_rows(rest);
                let solve = |both: &mut [f64]| lu.solve(both);
                let (x, beta) = self.solve_bordered(right, &rest, balance, solve);
                (x, own.from_rows(beta))
            }
        }
    }

    /// x and α̂ from the solution of the scaled bordered system.
    fn solve_bordered(
        &self,
        right: &[f64],
        rest: &[f64],
        balance: &[f64],
        solve: impl Fn(&mut [f64]),
    ) -> (Vec<f64>, Vec<f64>) {
        let units = self.scale.iter().chain(balance);
        let both = right.iter().chain(rest).zip(units.clone());
        let mut both: Vec<f64> = both.map(|(r, s)| r * s).collect();
        solve(&mut both);
        both.iter_mut().zip(units).for_each(|(x, s)| *x *= s);
        let alpha = both.split_off(right.len());
        (both, alpha)
    }
}

/// Whether a factor of `a` solves a system to a few digits at least: the factor of a singular matrix does not.
fn solves(lu: &SparseLu, a: &SparseMatrix) -> bool {
    let n = a.rows();
    let right: Vec<f64> = (0..n).map(|i| 1.0 + (i as f64).sin()).collect();
    let (mut x, mut left) = (right.clone(), vec![0.0; n]);
    lu.solve(&mut x);
    a.mul(&x, &mut left);
    let off = left.iter().zip(&right).map(|(l, r)| (l - r).powi(2));
    off.sum::<f64>().sqrt() <= SOLVED * norm(&right)
}

/// Entries of WᵀFC of some unknowns, (n, n), in any order.
fn sparse_coupling(matrix: &SparseMatrix, unknowns: &[Unknown]) -> Vec<(usize, usize, f64)> {
    let mut moves: Vec<Vec<(usize, f64)>> = vec![Vec::new(); matrix.rows()];
    for (b, unknown) in unknowns.iter().enumerate() {
        let force = unknown.force.iter();
        force.for_each(|&(j, weight)| moves[j].push((b, weight)));
    }
    let mut entries = Vec::new();
    for (a, unknown) in unknowns.iter().enumerate() {
        for &(i, weight) in &unknown.row {
            for (j, value) in matrix.row(i) {
                let moved = moves[j].iter();
                entries.extend(moved.map(|&(b, c)| (a, b, weight * value * c)));
            }
        }
    }
    entries
}

/// WᵀFC of some unknowns, (n, n).
fn coupling(matrix: &Mat<f64>, unknowns: &[Unknown]) -> Mat<f64> {
    let n = unknowns.len();
    let mut out = Mat::zeros(n, n);
    let mut sum = vec![0.0; matrix.nrows()];
    for (b, unknown) in unknowns.iter().enumerate() {
        let column: &[f64] = match unknown.force[..] {
            [(i, 1.0)] => matrix.col_as_slice(i),
            _ => {
                sum.fill(0.0);
                for &(i, weight) in &unknown.force {
                    let column = matrix.col_as_slice(i).iter();
                    sum.iter_mut()
                        .zip(column)
                        .for_each(|(s, f)| *s += weight * f);
                }
                &sum
            }
        };
        for (out, other) in out.col_as_slice_mut(b).iter_mut().zip(unknowns) {
            *out = match other.row[..] {
                [(i, 1.0)] => column[i],
                _ => along(&other.row, column),
            };
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, DualProblem, Friction};
    use crate::solve::states::Shear;
    use crate::solve::tests::{apart, applied, definite, eliminated, of, times};

    /// Two motions of two nodes in the plane, a tied pair and a contact that presses.
    fn modes() -> [Vec<f64>; 2] {
        [
            vec![1.0, 0.0, 1.0, 0.2, 0.5, 0.0, 1.0],
            vec![0.3, 1.0, -0.3, 1.0, 0.0, 0.7, 0.4],
        ]
    }

    const SHIFT: [f64; 7] = [1.0, 0.3, -0.5, 0.8, 0.1, -0.2, 0.6];
    const LOAD: [f64; 2] = [2.0, -0.4];

    fn blocks(tangents: Friction) -> Vec<Block> {
        let node = tangents.block(1);
        vec![node, node, Block::Free { size: 2 }, Block::Unilateral]
    }

    fn problem(compliance: Compliance, law: Friction) -> DualProblem {
        of(compliance, &SHIFT, blocks(law), (&modes(), &LOAD))
    }

    /// F assembled, without its zeros, and applied.
    fn forms() -> [Compliance; 3] {
        let f = definite(7);
        let sparse = SparseMatrix::from_dense(&f);
        [
            Compliance::Sparse(sparse),
            applied(&f, Mat::identity(7, 7)),
            Compliance::Dense(f),
        ]
    }

    fn state(closed: bool, shear: Shear) -> State {
        State {
            closed,
            shear,
            excess: 0.0,
            normal: 0.0,
        }
    }

    fn slip(sign: f64) -> Shear {
        Shear::Slip {
            direction: vec![sign],
            share: 0.5,
        }
    }

    /// λ and α of `states` by elimination of all conditions at once, one for each force.
    fn expected(
        states: &[State],
        law: Friction,
        anchor: Option<Anchor<'_>>,
    ) -> (Vec<f64>, Vec<f64>) {
        let (m, r, f, modes) = (7, 2, definite(7), modes());
        let touch = law.touch(0.0);
        let (given, growth) = (touch.given, touch.growth);
        let mut a = Mat::<f64>::zeros(m + r, m + r);
        let mut right = vec![0.0; m + r];
        let mut closes = |i: usize, a: &mut Mat<f64>| {
            for j in 0..m {
                a[(i, j)] = f[(i, j)];
            }
            for j in 0..r {
                a[(i, m + j)] = -modes[j][i];
            }
            right[i] = SHIFT[i];
            if let Some(Anchor { centre, compliance }) = anchor {
                a[(i, i)] += compliance[i];
                right[i] += compliance[i] * centre[i];
            }
        };
        let starts = [0, 2, 4, 6];
        let mut known = Vec::new();
        for (state, start) in states.iter().zip(starts) {
            match state.closed {
                true => closes(start, &mut a),
                false => known.push((start, vec![(start, 1.0)], 0.0)),
            }
            if start == 4 {
                closes(5, &mut a);
            } else if start < 4 {
                let tangent = start + 1;
                match &state.shear {
                    Shear::Slip { direction, .. } if law.bears(state.closed) => {
                        let row = vec![(tangent, 1.0), (start, -growth * direction[0])];
                        known.push((tangent, row, given * direction[0]));
                    }
                    Shear::Stick if law.bears(state.closed) => closes(tangent, &mut a),
                    _ => known.push((tangent, vec![(tangent, 1.0)], 0.0)),
                }
            }
        }
        for (i, row, value) in known {
            row.iter().for_each(|&(j, x)| a[(i, j)] = x);
            right[i] = value;
        }
        for j in 0..r {
            for i in 0..m {
                a[(m + j, i)] = modes[j][i];
            }
            right[m + j] = LOAD[j];
        }
        let x = eliminated(&a, &right).expect("the conditions are independent");
        (x[..m].to_vec(), x[m..].to_vec())
    }

    fn sets() -> Vec<(Friction, Vec<State>)> {
        let (tresca, coulomb) = (
            Friction::Tresca { bound: 0.3 },
            Friction::Coulomb { coefficient: 0.4 },
        );
        let tied = || state(true, Shear::Stick);
        let all = |law: Friction, a: State, b: State, pressed: bool| {
            (law, vec![a, b, tied(), state(pressed, Shear::Stick)])
        };
        let stick = |closed| state(closed, Shear::Stick);
        vec![
            all(tresca, stick(true), stick(true), true),
            all(tresca, stick(true), state(true, slip(-1.0)), false),
            all(tresca, state(false, slip(1.0)), stick(true), true),
            all(coulomb, stick(true), stick(false), true),
            all(coulomb, state(true, slip(1.0)), stick(true), true),
            all(
                coulomb,
                state(true, slip(1.0)),
                state(true, slip(-1.0)),
                false,
            ),
        ]
    }

    #[test]
    fn forces_of_states_meet_all_their_conditions_however_the_compliance_is_given() {
        let centre = [0.4, -0.2, 0.9, 0.1, 0.0, 0.3, 1.0];
        let compliance = [0.2, 0.1, 0.3, 0.2, 0.4, 0.1, 0.5];
        for (law, states) in sets() {
            for anchored in [false, true] {
                let anchor = anchored.then_some(Anchor {
                    centre: &centre,
                    compliance: &compliance,
                });
                let (lambda, alpha) = expected(&states, law, anchor);
                for form in forms() {
                    let problem = problem(form, law);
                    let setup = Setup::new(&problem).unwrap();
                    let mut system = System::of(&setup, &states, anchor, &problem.softness);
                    assert!(system.carries() && system.loose.is_empty());
                    let rough = Forces {
                        lambda: vec![0.5; 7],
                        ..Forces::none(&setup)
                    };
                    let found = system.solve(&rough, 1e-13).unwrap();
                    let told = setup.multipliers(&found.lambda, &found.alpha);
                    let what = format!("{law:?}, {states:?}");
                    // F and the balance are conditioned like 1e2
                    assert!(apart(&told.lambda, &lambda) < 1e-10, "{what}");
                    assert!(apart(&told.alpha, &alpha) < 1e-10, "{what}");
                    let product = times(&definite(7), &found.lambda);
                    assert!(apart(&found.product, &product) < 1e-13);
                    let applied = matches!(problem.compliance, Compliance::Operator { .. });
                    assert_eq!(system.unique, !applied);
                }
            }
        }
    }

    #[test]
    fn preconditioner_and_accuracy_decide_how_many_products_are_made() {
        let f = definite(7);
        let inverse = {
            let columns: Vec<Vec<f64>> = (0..7)
                .map(|j| {
                    let unit: Vec<f64> = (0..7).map(|i| f64::from(i == j)).collect();
                    eliminated(&f, &unit).unwrap()
                })
                .collect();
            Mat::from_fn(7, 7, |i, j| columns[j][i])
        };
        let products =
            |states: &[State], law: Friction, preconditioner: &Mat<f64>, accuracy: f64| {
                let problem = problem(applied(&f, preconditioner.clone()), law);
                let setup = Setup::new(&problem).unwrap();
                let mut system = System::of(&setup, states, None, &problem.softness);
                system.solve(&Forces::none(&setup), accuracy).unwrap();
                setup.products()
            };
        let identity = Mat::identity(7, 7);
        for (law, states) in [sets().swap_remove(0), sets().swap_remove(4)] {
            let exact = products(&states, law, &identity, 1e-13);
            let rough = products(&states, law, &identity, 1e-1);
            // no more steps than there are free forces; a product for the start and one for the end beside them
            assert!(exact <= 10 && rough < exact, "{rough} {exact}");
            let preconditioned = products(&states, law, &inverse, 1e-13);
            // with slip rows and columns differ: there the inverse of F is not that of the system
            let symmetric = matches!(law, Friction::Tresca { .. });
            assert!(preconditioned + usize::from(symmetric) <= exact, "{law:?}");
        }
    }

    #[test]
    fn start_that_is_the_answer_needs_no_steps() {
        for which in [0, 4] {
            let (law, states) = sets().swap_remove(which);
            let problem = problem(applied(&definite(7), Mat::identity(7, 7)), law);
            let setup = Setup::new(&problem).unwrap();
            let mut system = System::of(&setup, &states, None, &problem.softness);
            let (lambda, _) = expected(&states, law, None);
            let guess = Forces {
                lambda,
                ..Forces::none(&setup)
            };
            system.solve(&guess, 1e-10).unwrap();
            // one for the residual of the start, one for the gaps at the end
            assert_eq!(setup.products(), 2, "{law:?}");
        }
    }

    /// Two contacts, the second of which has a slightly larger compliance than the first.
    fn nearly_alike(more: f64) -> (bool, bool) {
        let f = Mat::from_fn(2, 2, |i, j| 1.0 + if i == 1 && j == 1 { more } else { 0.0 });
        let blocks = vec![Block::Unilateral; 2];
        let problem = of(Compliance::Dense(f), &[1.0, 1.0], blocks, (&[], &[]));
        let setup = Setup::new(&problem).unwrap();
        let states = vec![state(true, Shear::Stick); 2];
        let mut system = System::of(&setup, &states, None, &problem.softness);
        let found = system.solve(&Forces::none(&setup), 1e-12).unwrap();
        let solved = apart(&found.product, &[1.0, 1.0]) < 1e-12;
        (system.unique, solved)
    }

    #[test]
    fn singular_systems_of_every_kind_are_solved_and_not_unique() {
        // two nodes, each direction redundant with that of the other
        let f = Mat::from_fn(4, 4, |i, j| f64::from(i % 2 == j % 2));
        let node = Friction::Coulomb { coefficient: 0.4 }.block(1);
        for sparse in [false, true] {
            let f = match sparse {
                true => Compliance::Sparse(SparseMatrix::from_dense(&f)),
                false => Compliance::Dense(f.clone()),
            };
            let problem = of(f, &[1.0, 0.5, 1.0, 0.5], vec![node; 2], (&[], &[]));
            let setup = Setup::new(&problem).unwrap();
            for states in [
                vec![state(true, slip(1.0)); 2],
                vec![state(true, Shear::Stick); 2],
            ] {
                let mut system = System::of(&setup, &states, None, &problem.softness);
                let found = system.solve(&Forces::none(&setup), 1e-12).unwrap();
                assert!(!system.unique, "sparse: {sparse}");
                assert!((found.lambda[0] + found.lambda[2] - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn contacts_that_do_the_same_share_their_forces_and_say_so() {
        assert_eq!(nearly_alike(0.0), (false, true));
        assert_eq!(nearly_alike(0.7e-13), (false, true));
        assert_eq!(nearly_alike(1.5e-13), (true, true));
        assert_eq!(nearly_alike(1.0), (true, true));
    }

    #[test]
    fn compliance_of_grounded_bodies_may_be_semidefinite_where_the_balance_tells_the_rest() {
        // F = vvᵀ vanishes across v; the modes do not
        let v = [1.0, -1.0, 0.5];
        let f = Mat::from_fn(3, 3, |i, j| v[i] * v[j]);
        let modes = [vec![1.0, 1.0, 1.0], vec![0.0, 1.0, -1.0]];
        for sparse in [false, true] {
            let f = match sparse {
                true => Compliance::Sparse(SparseMatrix::from_dense(&f)),
                false => Compliance::Dense(f.clone()),
            };
            let blocks = vec![Block::Free { size: 3 }];
            let problem = of(f, &[0.2, 0.1, 0.3], blocks, (&modes, &[3.0, 0.5]));
            let setup = Setup::new(&problem).unwrap();
            let states = vec![state(true, Shear::Stick)];
            let mut system = System::of(&setup, &states, None, &problem.softness);
            let found = system.solve(&Forces::none(&setup), 1e-12).unwrap();
            assert!(system.unique);
            let multipliers = setup.multipliers(&found.lambda, &found.alpha);
            let gap = problem.gap(&multipliers);
            assert!(apart(&gap, &[0.0; 3]) < 1e-13, "{gap:?}");
            let carried = problem.balance.modes().product(&multipliers.lambda);
            assert!(apart(&carried, &[3.0, 0.5]) < 1e-13, "{carried:?}");
        }
    }

    #[test]
    fn motions_that_no_unknown_feels_are_loose_and_carry_no_load() {
        let modes = [vec![1.0, 0.0, 1.0], vec![0.0, 1.0, 1.0]];
        for sparse in [false, true] {
            let f = definite(3);
            let f = match sparse {
                true => Compliance::Sparse(SparseMatrix::from_dense(&f)),
                false => Compliance::Dense(f),
            };
            let blocks = vec![Block::Unilateral; 3];
            let problem = of(f, &[1.0, 0.5, 0.2], blocks, (&modes, &[1.0, 0.0]));
            let setup = Setup::new(&problem).unwrap();
            let only = |closed: [bool; 3]| {
                let states = closed.map(|closed| state(closed, Shear::Stick));
                System::of(&setup, &states, None, &problem.softness)
            };
            // only the first contact bears: the second motion is free, and the load does not drive it
            let mut system = only([true, false, false]);
            let [z] = &system.loose[..] else {
                panic!("{:?}", system.loose);
            };
            let free = setup.multipliers(&[0.0; 3], z).alpha;
            let image = problem.balance.modes().motion(0, &free);
            assert!(image.abs() < 1e-14 && (norm(z) - 1.0).abs() < 1e-14);
            let z = z.clone();
            assert!(system.carries());
            let found = system.solve(&Forces::none(&setup), 1e-12).unwrap();
            assert!(dot(&z, &found.alpha).abs() < 1e-13);
            assert!(apart(&found.lambda, &[1.0, 0.0, 0.0]) < 1e-13);
            let told = setup.multipliers(&found.lambda, &found.alpha);
            assert!(problem.gap(&told)[0].abs() < 1e-13);
            // only the second one bears: the load drives what is free
            assert!(!only([false, true, false]).carries());
            assert!(only([false, true, true]).carries());
            assert!(only([false, false, false]).loose.len() == 2);
        }
    }

    #[test]
    fn load_that_is_carried_to_rounding_is_carried() {
        let carries = |load: f64| {
            let modes = [vec![1.0, 0.0], vec![0.0, 1.0]];
            let mut problem = of(
                Compliance::Dense(definite(2)),
                &[1.0, 1.0],
                vec![Block::Unilateral; 2],
                (&modes, &[1.0, 0.0]),
            );
            problem.balance = Balance::new(problem.balance.modes().clone(), vec![1.0, load]);
            let setup = Setup::unchecked(&problem);
            let states = [true, false].map(|closed| state(closed, Shear::Stick));
            System::of(&setup, &states, None, &problem.softness).carries()
        };
        assert!(carries(0.9e-9) && carries(-0.9e-9));
        assert!(!carries(1.1e-9) && !carries(-1.1e-9));
    }

    #[test]
    fn scales_are_the_powers_of_two_nearest_to_a_unit_diagonal() {
        for (diagonal, scale) in [
            (1.0, 1.0),
            (4.0, 0.5),
            (0.25, 2.0),
            (1.9, 1.0),
            (2.1, 0.5),
            (0.51, 1.0),
        ] {
            assert_eq!(unit_scale(diagonal), scale, "{diagonal}");
        }
        for none in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert_eq!(unit_scale(none), 1.0);
        }
        let forces = [
            SparseVector::from_dense(&[1.0, 0.5]),
            SparseVector::from_dense(&[0.0, 0.125]),
        ];
        let rows = [
            SparseVector::from_dense(&[0.0, -4.0]),
            SparseVector::from_dense(&[0.0, 0.0]),
        ];
        // the largest push, squared: (4 · 2)² and (0.125 · 2)²
        assert_eq!(units_of_balance(&forces, &rows, &[1.0, 2.0]), [0.125, 4.0]);
    }

    #[test]
    fn unit_of_an_unknown_is_not_that_of_a_grounded_diagonal() {
        let problem = problem(
            Compliance::Dense(definite(7)),
            Friction::Coulomb { coefficient: 0.5 },
        );
        let setup = Setup::new(&problem).unwrap();
        let unknowns = vec![
            Unknown::of(0),
            Unknown {
                force: vec![(0, 2.0), (1, 0.5)],
                row: vec![(0, -2.0), (1, 1.0)],
                ..Unknown::of(0)
            },
        ];
        let system = System::new(&setup, unknowns, vec![0.0; 7]);
        let softness = &problem.softness;
        assert_eq!(system.unit_of(0, 1e-20), unit_scale(softness[0]));
        assert_eq!(system.unit_of(0, -64.0), 0.125);
        let both = 4.0 * softness[0] + 0.5 * softness[1];
        assert_eq!(system.unit_of(1, 0.0), unit_scale(both));
    }

    #[test]
    fn coupling_is_the_product_of_rows_matrix_and_forces() {
        let f = definite(4);
        let list = |pairs: &[(usize, f64)]| pairs.to_vec();
        let unknowns = [
            Unknown::of(2),
            Unknown {
                force: list(&[(0, 1.0), (1, 0.4)]),
                row: list(&[(0, 1.0)]),
                ..Unknown::of(0)
            },
            Unknown {
                force: list(&[(3, -2.0)]),
                row: list(&[(3, 0.5), (1, 3.0)]),
                ..Unknown::of(3)
            },
        ];
        let dense = coupling(&f, &unknowns);
        let mut sparse = Mat::<f64>::zeros(3, 3);
        for (a, b, value) in sparse_coupling(&SparseMatrix::from_dense(&f), &unknowns) {
            sparse[(a, b)] += value;
        }
        for (a, one) in unknowns.iter().enumerate() {
            for (b, other) in unknowns.iter().enumerate() {
                let mut expected = 0.0;
                for &(i, w) in &one.row {
                    for &(j, c) in &other.force {
                        expected += w * f[(i, j)] * c;
                    }
                }
                assert!((dense[(a, b)] - expected).abs() < 1e-14, "{a} {b}");
                assert!((sparse[(a, b)] - expected).abs() < 1e-14, "{a} {b}");
            }
        }
        let rows = [SparseVector::from_dense(&[1.0, 2.0, 0.0, 5.0])];
        let forces = on_unknowns(&rows, &unknowns, Side::Forces);
        assert_eq!(forces[0].to_dense(), [0.0, 1.8, -10.0]);
        let tests = on_unknowns(&rows, &unknowns, Side::Rows);
        assert_eq!(tests[0].to_dense(), [0.0, 1.0, 8.5]);
        assert!(on_unknowns(&[], &unknowns, Side::Rows).is_empty());
    }

    #[test]
    fn factor_that_leaves_more_than_a_millionth_solves_nothing() {
        // the factor of one matrix before another
        let matrix = |x: f64| SparseMatrix::from_triplets(2, 2, &[(0, 0, x), (1, 1, x)]);
        let lu = SparseLu::new(&matrix(1.0)).unwrap();
        assert!(solves(&lu, &matrix(1.0 + 0.9e-6)));
        assert!(!solves(&lu, &matrix(1.0 + 1.1e-6)));
        assert!(!solves(&lu, &matrix(1.0 - 1.1e-6)));
    }

    #[test]
    fn stiff_contacts_beside_soft_ones_keep_their_forces() {
        // compliances 1 and 1e-14 on one body, which sinks by 2: each bears as much as it gives way
        let compliance = [1.0, 1e-14];
        let f = Mat::from_fn(2, 2, |i, j| if i == j { compliance[i] } else { 0.0 });
        for sparse in [false, true] {
            let f = match sparse {
                true => Compliance::Sparse(SparseMatrix::from_dense(&f)),
                false => Compliance::Dense(f.clone()),
            };
            let blocks = vec![Block::Unilateral; 2];
            let load = 2.0 + 2e14;
            let problem = of(f, &[0.0, 0.0], blocks, (&[vec![1.0, 1.0]], &[load]));
            let setup = Setup::new(&problem).unwrap();
            let states = vec![state(true, Shear::Stick); 2];
            let mut system = System::of(&setup, &states, None, &problem.softness);
            let found = system.solve(&Forces::none(&setup), 1e-12).unwrap();
            let told = setup.multipliers(&found.lambda, &found.alpha);
            assert!((told.alpha[0] - 2.0).abs() < 1e-12, "{}", told.alpha[0]);
            assert!((found.lambda[1] / 2e14 - 1.0).abs() < 1e-12);
            assert!(system.unique);
        }
    }

    #[test]
    fn residual_is_what_conditions_and_balance_lack() {
        let problem = problem(
            Compliance::Dense(definite(7)),
            Friction::Coulomb { coefficient: 0.5 },
        );
        let setup = Setup::new(&problem).unwrap();
        let unknowns = vec![
            Unknown {
                force: vec![(0, 1.0), (1, -0.5)],
                softness: 0.25,
                pull: 3.0,
                ..Unknown::of(0)
            },
            Unknown::of(6),
        ];
        let mut offset = vec![0.0; 7];
        offset[3] = 2.0;
        let system = System::new(&setup, unknowns, offset);
        let alpha = [0.3, -0.6];
        let mut own = vec![0.0; 2];
        setup.balance.from_original(&alpha, &mut own);
        let point = system.point(&[4.0, -1.0], own);
        assert_eq!(point.lambda, [4.0, -2.0, 0.0, 2.0, 0.0, 0.0, -1.0]);
        assert!(apart(&point.product, &times(&definite(7), &point.lambda)) < 1e-14);
        let (right, rest) = system.residual(&point, &[4.0, -1.0]);
        let gap = |i: usize| {
            let rigid: f64 = (0..2).map(|j| modes()[j][i] * alpha[j]).sum();
            point.product[i] - SHIFT[i] - rigid
        };
        assert!((right[0] - (3.0 - gap(0) - 0.25 * 4.0)).abs() < 1e-14);
        assert!((right[1] + gap(6)).abs() < 1e-14);
        // ê − Ĝλ, whatever the orthonormal modes are: its size follows from G and GGᵀ
        let g = Mat::from_fn(2, 2, |i, j| dot(&modes()[i], &modes()[j]));
        let left: Vec<f64> = (0..2)
            .map(|j| LOAD[j] - dot(&modes()[j], &point.lambda))
            .collect();
        let square = dot(&left, &eliminated(&g, &left).unwrap());
        assert!((norm(&rest) - square.sqrt()).abs() < 1e-13);
        let mut both = vec![0.0; 2];
        setup.balance.imbalance(&point.lambda, &mut both);
        assert!(
            dot(&both, &rest) < 0.0,
            "it is what lacks, not what is too much"
        );
    }
}
