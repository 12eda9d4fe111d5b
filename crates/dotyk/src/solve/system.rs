//! The linear problem that a guess of states leaves: unknown forces x and rigid amplitudes α̂ with
//!
//! ```text
//!   wₐ·gap + softnessₐ xₐ = pullₐ,   gap = Fλ − d − Ĝᵀα̂,   Ĝλ = ê,   λ = offset + Σ xₐ cₐ
//! ```
//!
//! Assembled F, symmetric (c = w): Cholesky of A = WᵀFW + softness and the Schur complement of the balance. Where A is
//! semidefinite (grounded floating bodies, contacts that do the same) ϱĜᵀĜ is added, which changes nothing where Ĝλ = ê,
//! and then a shift of rounding size; corrections with the true residual remove what that changes. Unsymmetric (slip with
//! Coulomb's law): LU with pivoting. Unknowns are scaled to a unit diagonal by powers of two, which rounds nothing: stiff
//! contacts beside soft ones must not drown.
//!
//! Sparse F: LU with pivoting of the whole without its zeros, and with the balance in the modes of the single bodies, which
//! are sparser than orthonormal ones; the shift and the corrections are the same.
//!
//! Applied F: conjugate gradients in the null space of the balance for symmetric systems, restarted minimal residuals for
//! unsymmetric ones, both preconditioned and warm started.
//!
//! Directions of α̂ that no unknown determines come back in `loose`; α̂ has no part along them.

use crate::dual::{Balance, Compliance};
use crate::linalg::dense::{
    Lu, cholesky_in_place, solve_cholesky_in_place, solve_lower_in_place,
    solve_lower_transpose_in_place, transpose_product,
};
use crate::linalg::{LinearOperator, Mat, SparseLu, SparseMatrix, SparseVector};
use crate::solve::null::{Null, Pseudo, add_outer, gram_of};
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::{Anchor, State, Unknown, along, unknowns};
use crate::solve::{dot, norm};

/// A squared Cholesky pivot below this part of its diagonal entry marks a dependent row.
const DEPENDENT: f64 = 1e-13;

/// Shift of a singular matrix, relative to its diagonal.
const SHIFT: f64 = 1e-10;

/// Parts of a loose direction below this one are rounding.
const LOOSE: f64 = 1e-9;

/// Part of a right side that the factor of a regular matrix leaves at most.
const SOLVED: f64 = 1e-6;

/// Most corrections of a solution; a shifted matrix needs more of them than rounding.
const CORRECTIONS: usize = 8;

/// Most conjugate gradients of one linear problem.
const CONJUGATE: usize = 500;

/// Vectors that minimal residuals keep, and how often they begin again.
const KRYLOV: usize = 60;
const RESTARTS: usize = 10;

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
    /// The problem that `states` leave, with the conditions and the compliance `own` as in [`unknowns`].
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
        let rows = on_unknowns(balance.rows(), &unknowns, |u| &u.row);
        let forces = on_unknowns(balance.rows(), &unknowns, |u| &u.force);
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
            false => {
                let balance = &self.setup.balance;
                let forces = on_unknowns(balance.rows(), &self.unknowns, |u| &u.force);
                null_of(balance, &forces)
            }
        };
        null.iter().all(|z| dot(z, &rest).abs() <= 1e-9 * size)
    }

    /// Solves from `guess`, with a relative accuracy that only iterations use; `None` where the system is singular.
    pub fn solve(&mut self, guess: &Forces, accuracy: f64) -> Option<Forces> {
        let point = match &self.setup.problem.compliance {
            Compliance::Dense(_) | Compliance::Sparse(_) => self.solve_assembled(),
            Compliance::Operator { preconditioner, .. } => {
                self.solve_applied(preconditioner.as_ref(), guess, accuracy)
            }
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
    fn point(&mut self, x: &[f64], alpha: Vec<f64>) -> Forces {
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

    /// What is left of the conditions, (n,), and of the balance, (k,).
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
    /// Scale of the unknown `a` with the diagonal entry `own`, and not that alone: it is rounding where a body is grounded.
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

/// What an unknown pushes, or what its condition weighs.
type Side = fn(&Unknown) -> &[(usize, f64)];

/// Rows over the forces as rows over the unknowns.
fn on_unknowns(rows: &[SparseVector], unknowns: &[Unknown], side: Side) -> Vec<SparseVector> {
    let Some(m) = rows.first().map(SparseVector::len) else {
        return Vec::new();
    };
    let mut met: Vec<Vec<(usize, f64)>> = vec![Vec::new(); m];
    for (a, unknown) in unknowns.iter().enumerate() {
        let parts = side(unknown).iter();
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
    /// The same without its zeros.
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

    /// LU of the bordered matrix without its zeros: of the coupling and the softness of the unknowns, and of the balance in
    /// its own modes, which are sparser than orthonormal ones.
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

    /// How large a residual is, in scaled units.
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

/// Whether a factor of `a` solves a system with it to a few digits at least: those of a singular matrix do not.
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

// Applied F

impl System<'_> {
    fn solve_applied(
        &mut self,
        preconditioner: &dyn LinearOperator,
        guess: &Forces,
        accuracy: f64,
    ) -> Option<Forces> {
        let symmetric = self.unknowns.iter().all(Unknown::is_symmetric);
        // the unknowns nearest to the guess
        let apart = guess.lambda.iter().zip(&self.offset);
        let apart: Vec<f64> = apart.map(|(force, known)| force - known).collect();
        let nearest = self.unknowns.iter().map(|u| u.nearest(&apart));
        let start: Vec<f64> = nearest.collect();
        match symmetric {
            true => self.conjugate_gradients(preconditioner, start, accuracy),
            false => self.minimal_residuals(preconditioner, start, accuracy),
        }
    }

    /// out = WᵀFC x + softness x; `lambda` and `image` are workspace (m,).
    fn apply(&mut self, x: &[f64], lambda: &mut [f64], image: &mut [f64], out: &mut [f64]) {
        lambda.fill(0.0);
        for (unknown, x) in self.unknowns.iter().zip(x) {
            for &(i, weight) in &unknown.force {
                lambda[i] += x * weight;
            }
        }
        self.setup.multiply(lambda, image);
        for ((out, unknown), x) in out.iter_mut().zip(&self.unknowns).zip(x) {
            *out = along(&unknown.row, image) + unknown.softness * x;
        }
    }

    /// out = an approximation of (WᵀFC)⁻¹ r; `spread` and `image` are workspace (m,).
    fn precondition(
        &self,
        preconditioner: &dyn LinearOperator,
        r: &[f64],
        spread: &mut [f64],
        image: &mut [f64],
        out: &mut [f64],
    ) {
        spread.fill(0.0);
        for (unknown, r) in self.unknowns.iter().zip(r) {
            for &(i, weight) in &unknown.row {
                spread[i] += r * weight;
            }
        }
        preconditioner.apply(spread, image);
        for (out, unknown) in out.iter_mut().zip(&self.unknowns) {
            *out = along(&unknown.row, image);
        }
    }

    /// Conjugate gradients on the forces that keep the balance.
    fn conjugate_gradients(
        &mut self,
        preconditioner: &dyn LinearOperator,
        mut x: Vec<f64>,
        accuracy: f64,
    ) -> Option<Forces> {
        let (n, m) = (x.len(), self.setup.len());
        let mut null = Null::new(&self.rows, &self.loose);
        let mut target = vec![0.0; self.setup.modes()];
        self.setup.balance.imbalance(&self.offset, &mut target);
        target.iter_mut().for_each(|rest| *rest = -*rest);
        null.restore(&self.rows, &target, &mut x);
        let (mut lambda, mut image) = (vec![0.0; m], vec![0.0; m]);
        let point = self.point(&x, vec![0.0; target.len()]);
        let (mut residual, _) = self.residual(&point, &x);
        let reference = self.reference(&mut null);
        null.project(&self.rows, &mut residual);
        let goal = accuracy * reference.max(1e-3 * norm(&residual));
        let (mut z, mut out) = (vec![0.0; n], vec![0.0; n]);
        self.precondition(preconditioner, &residual, &mut lambda, &mut image, &mut z);
        null.project(&self.rows, &mut z);
        let mut direction = z.clone();
        let mut slope = dot(&residual, &z);
        for _ in 0..CONJUGATE.min(2 * n + 50) {
            if norm(&residual) <= goal || slope <= 0.0 {
                break;
            }
            self.apply(&direction, &mut lambda, &mut image, &mut out);
            null.project(&self.rows, &mut out);
            let curvature = dot(&direction, &out);
            if curvature <= 0.0 {
                break;
            }
            let step = slope / curvature;
            for i in 0..n {
                x[i] += step * direction[i];
                residual[i] -= step * out[i];
            }
            self.precondition(preconditioner, &residual, &mut lambda, &mut image, &mut z);
            null.project(&self.rows, &mut z);
            let next = dot(&residual, &z);
            for i in 0..n {
                direction[i] = z[i] + next / slope * direction[i];
            }
            slope = next;
        }
        null.restore(&self.rows, &target, &mut x);
        let mut point = self.point(&x, vec![0.0; target.len()]);
        let (open, _) = self.residual(&point, &x);
        point.alpha = null.amplitudes(&self.rows, &open);
        Some(point)
    }

    /// Size of the right side on the balanced forces.
    fn reference(&self, null: &mut Null) -> f64 {
        let shift = &self.setup.shift;
        let own = self.unknowns.iter().map(|u| u.pull + along(&u.row, shift));
        let mut reference: Vec<f64> = own.collect();
        null.project(&self.rows, &mut reference);
        norm(&reference)
    }

    /// Minimal residuals on the forces that keep the balance, tested by motions that are not rigid.
    fn minimal_residuals(
        &mut self,
        preconditioner: &dyn LinearOperator,
        mut x: Vec<f64>,
        accuracy: f64,
    ) -> Option<Forces> {
        let mut forces = Null::new(&self.forces, &[]);
        let mut rigid = Null::new(&self.rows, &self.loose);
        let mut target = vec![0.0; self.setup.modes()];
        self.setup.balance.imbalance(&self.offset, &mut target);
        target.iter_mut().for_each(|rest| *rest = -*rest);
        forces.restore(&self.forces, &target, &mut x);
        let none = vec![0.0; target.len()];
        let point = self.point(&x, none.clone());
        let (mut residual, _) = self.residual(&point, &x);
        let reference = self.reference(&mut rigid);
        rigid.project(&self.rows, &mut residual);
        let goal = accuracy * reference.max(1e-3 * norm(&residual));
        let change = self.krylov(
            preconditioner,
            &residual,
            goal,
            &mut [&mut forces, &mut rigid],
        )?;
        x.iter_mut().zip(&change).for_each(|(x, d)| *x += d);
        forces.restore(&self.forces, &target, &mut x);
        let mut point = self.point(&x, none);
        let (open, _) = self.residual(&point, &x);
        point.alpha = rigid.amplitudes(&self.rows, &open);
        Some(point)
    }

    /// x without resultant for which b − Ax is a rigid motion, to within a norm, by restarted minimal residuals,
    /// preconditioned from the right; the null spaces are those of the forces and of the rigid motions.
    fn krylov(
        &mut self,
        preconditioner: &dyn LinearOperator,
        b: &[f64],
        goal: f64,
        [forces, rigid]: &mut [&mut Null; 2],
    ) -> Option<Vec<f64>> {
        let (n, m) = (b.len(), self.setup.len());
        let (mut lambda, mut image) = (vec![0.0; m], vec![0.0; m]);
        let mut x = vec![0.0; n];
        let mut residual = b.to_vec();
        for _ in 0..RESTARTS {
            let size = norm(&residual);
            if size <= goal || size == 0.0 {
                return Some(x);
            }
            let mut basis = vec![residual.iter().map(|r| r / size).collect::<Vec<f64>>()];
            let mut directions: Vec<Vec<f64>> = Vec::new();
            let mut triangle: Vec<Vec<f64>> = Vec::new();
            let mut turns: Vec<(f64, f64)> = Vec::new();
            let mut right = vec![size];
            for j in 0..KRYLOV.min(n) {
                let (mut z, mut w) = (vec![0.0; n], vec![0.0; n]);
                self.precondition(preconditioner, &basis[j], &mut lambda, &mut image, &mut z);
                forces.project(&self.forces, &mut z);
                self.apply(&z, &mut lambda, &mut image, &mut w);
                rigid.project(&self.rows, &mut w);
                directions.push(z);
                let mut column: Vec<f64> = Vec::with_capacity(j + 2);
                for q in &basis {
                    let part = dot(q, &w);
                    w.iter_mut().zip(q).for_each(|(w, q)| *w -= part * q);
                    column.push(part);
                }
                let rest = norm(&w);
                for (i, &(cos, sin)) in turns.iter().enumerate() {
                    let (a, b) = (column[i], column[i + 1]);
                    (column[i], column[i + 1]) = (cos * a + sin * b, cos * b - sin * a);
                }
                let length = column[j].hypot(rest);
                let (cos, sin) = match length > 0.0 {
                    true => (column[j] / length, rest / length),
                    false => (1.0, 0.0),
                };
                column[j] = length;
                turns.push((cos, sin));
                triangle.push(column);
                let last = right[j];
                right[j] = cos * last;
                right.push(-sin * last);
                if right[j + 1].abs() <= goal || rest == 0.0 {
                    break;
                }
                basis.push(w.iter().map(|w| w / rest).collect());
            }
            let count = triangle.len();
            let mut y = right[..count].to_vec();
            for i in (0..count).rev() {
                y[i] /= triangle[i][i];
                for row in 0..i {
                    y[row] -= triangle[i][row] * y[i];
                }
            }
            if !y.iter().all(|y| y.is_finite()) {
                return None;
            }
            for (y, direction) in y.iter().zip(&directions) {
                x.iter_mut().zip(direction).for_each(|(x, d)| *x += y * d);
            }
            self.apply(&x, &mut lambda, &mut image, &mut residual);
            rigid.project(&self.rows, &mut residual);
            residual.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
        }
        Some(x)
    }
}
