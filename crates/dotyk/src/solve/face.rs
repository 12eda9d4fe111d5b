//! The equality-constrained problem on a face: min 1/2 λᵀFλ − dᵀλ with Ĝλ = ê and λ = 0 outside the active set.
//!
//! ```text
//!   [F_II  −Ĝ_Iᵀ] [λ_I]   [d_I]
//!   [Ĝ_I     0  ] [ α̂ ] = [ ê ]
//! ```
//!
//! Assembled F: Cholesky of F_II + ρĜ_IᵀĜ_I and the Schur complement of the balance. The added term changes nothing
//! where Ĝλ = ê, and it makes the matrix definite where a grounded floating body leaves F semidefinite. Rows that
//! still depend on others carry no force. Applied F: conjugate gradients in the null space of Ĝ_I, preconditioned,
//! warm started from the previous face.
//!
//! Where the active contacts do not determine α̂, its undetermined directions are returned in `loose`.

use crate::dual::Compliance;
use crate::linalg::dense::{
    cholesky_in_place, gram, product, solve_cholesky_in_place, solve_lower_in_place,
    solve_lower_transpose_in_place, symmetric_eigen, transpose_product,
};
use crate::linalg::{LinearOperator, Mat};
use crate::solve::{Setup, dot, norm};

/// Eigenvalues of a small balance matrix below this part of the largest count as zero.
const RANK: f64 = 1e-12;

/// A squared Cholesky pivot below this part of its diagonal entry marks a dependent row.
const DEPENDENT: f64 = 1e-13;

/// Solution on the last face, kept as the starting point of the next.
pub(crate) struct Face {
    /// λ, (m,), zero outside the face.
    pub lambda: Vec<f64>,
    /// α̂, (k,), of least norm.
    pub alpha: Vec<f64>,
    /// Fλ, (m,).
    pub product: Vec<f64>,
    /// Directions of α̂ that the face leaves undetermined, orthonormal.
    pub loose: Vec<Vec<f64>>,
    /// Products with F so far.
    pub products: usize,
}

impl Face {
    /// Begins with the forces `lambda`.
    pub fn new(setup: &Setup<'_>, lambda: Vec<f64>) -> Self {
        Self {
            product: vec![0.0; lambda.len()],
            lambda,
            alpha: vec![0.0; setup.modes()],
            loose: Vec::new(),
            products: 0,
        }
    }

    /// Solves on the face `active` (m,); `tolerance` is relative and used by conjugate gradients only.
    pub fn solve(&mut self, setup: &Setup<'_>, active: &[bool], tolerance: f64) {
        match &setup.problem.compliance {
            Compliance::Dense(matrix) => self.solve_dense(setup, matrix, active),
            Compliance::Operator { preconditioner, .. } => {
                self.solve_iteratively(setup, preconditioner.as_ref(), active, tolerance);
            }
        }
    }

    fn apply(&mut self, setup: &Setup<'_>) {
        setup
            .problem
            .compliance
            .apply(&self.lambda, &mut self.product);
        self.products += 1;
    }

    fn solve_dense(&mut self, setup: &Setup<'_>, matrix: &Mat<f64>, active: &[bool]) {
        let k = setup.modes();
        let system = System::new(setup, matrix, active);
        self.loose = system.schur.null.clone();
        self.lambda.fill(0.0);
        self.alpha.fill(0.0);
        self.product.fill(0.0);
        let mut displacement = vec![0.0; system.face.len()];
        let mut rest = vec![0.0; k];
        let mut rigid = vec![0.0; setup.len()];
        // The first pass solves, the later ones refine.
        let mut before = f64::INFINITY;
        for _ in 0..3 {
            rigid.fill(0.0);
            setup.balance.add_transposed(1.0, &self.alpha, &mut rigid);
            for (out, &i) in displacement.iter_mut().zip(&system.face) {
                *out = setup.problem.shift[i] + rigid[i] - self.product[i];
            }
            setup.balance.imbalance(&self.lambda, &mut rest);
            rest.iter_mut().for_each(|rest| *rest = -*rest);
            let size = norm(&displacement) + norm(&rest);
            if size == 0.0 || size >= 0.5 * before {
                break;
            }
            before = size;
            system.correct(&displacement, &rest, &mut self.lambda, &mut self.alpha);
            self.apply(setup);
        }
    }

    fn solve_iteratively(
        &mut self,
        setup: &Setup<'_>,
        preconditioner: &dyn LinearOperator,
        active: &[bool],
        tolerance: f64,
    ) {
        let m = setup.len();
        let mut tangent = Tangent::new(setup, active);
        self.loose = tangent.gram.null.clone();
        let shift = &setup.problem.shift;
        tangent.restore(setup, &mut self.lambda);
        self.apply(setup);
        let mut residual: Vec<f64> = (0..m).map(|i| shift[i] - self.product[i]).collect();
        tangent.project(setup, &mut residual);
        let mut reference = shift.clone();
        tangent.project(setup, &mut reference);
        let target = tolerance * norm(&reference).max(1e-3 * norm(&residual));
        let (mut z, mut image) = (vec![0.0; m], vec![0.0; m]);
        preconditioner.apply(&residual, &mut z);
        tangent.project(setup, &mut z);
        let mut direction = z.clone();
        let mut slope = dot(&residual, &z);
        for _ in 0..2 * m + 50 {
            if norm(&residual) <= target || slope <= 0.0 {
                break;
            }
            setup.problem.compliance.apply(&direction, &mut image);
            self.products += 1;
            tangent.project(setup, &mut image);
            let curvature = dot(&direction, &image);
            if curvature <= 0.0 {
                break;
            }
            let step = slope / curvature;
            for i in 0..m {
                self.lambda[i] += step * direction[i];
                residual[i] -= step * image[i];
            }
            preconditioner.apply(&residual, &mut z);
            tangent.project(setup, &mut z);
            let next = dot(&residual, &z);
            for i in 0..m {
                direction[i] = z[i] + next / slope * direction[i];
            }
            slope = next;
        }
        tangent.restore(setup, &mut self.lambda);
        self.apply(setup);
        let overlap: Vec<f64> = (0..m)
            .map(|i| {
                if active[i] {
                    self.product[i] - shift[i]
                } else {
                    0.0
                }
            })
            .collect();
        setup.balance.apply(&overlap, &mut self.alpha);
        tangent.gram.solve(&mut self.alpha, &mut tangent.right);
    }
}

/// Replaces `forces` by the nearest ones with Ĝλ = ê that differ on the face only; `false` where there are none.
///
/// Outside the face they stay as they are where friction may load them, else they become zero.
pub(crate) fn restore(setup: &Setup<'_>, active: &[bool], forces: &mut [f64]) -> bool {
    let mut tangent = Tangent::new(setup, active);
    // Twice: the second pass removes what rounding left.
    for _ in 0..2 {
        if setup.admissible.has_friction() {
            tangent.rebalance(setup, forces);
        } else {
            tangent.restore(setup, forces);
        }
    }
    let mut rest = vec![0.0; setup.modes()];
    setup.balance.imbalance(forces, &mut rest);
    norm(&rest) <= 1e-9 * norm(&setup.balance.load).max(1e-3 * norm(forces))
}

/// Pseudo-inverse of a small symmetric positive semidefinite matrix.
pub(crate) struct Pseudo {
    pairs: Vec<(f64, Vec<f64>)>,
    pub null: Vec<Vec<f64>>,
}

impl Pseudo {
    pub fn new(matrix: &Mat<f64>) -> Self {
        let k = matrix.nrows();
        let (values, vectors) =
            symmetric_eigen(matrix).unwrap_or_else(|_| (vec![0.0; k], Mat::identity(k, k)));
        let largest = values.last().copied().unwrap_or(0.0);
        let mut pseudo = Self {
            pairs: Vec::new(),
            null: Vec::new(),
        };
        for (j, value) in values.into_iter().enumerate() {
            let vector = vectors.col_as_slice(j).to_vec();
            if value > RANK * largest {
                pseudo.pairs.push((value, vector));
            } else {
                pseudo.null.push(vector);
            }
        }
        pseudo
    }

    /// x ← A⁺x; `right` is workspace of the same length.
    pub fn solve(&self, x: &mut [f64], right: &mut [f64]) {
        right.copy_from_slice(x);
        x.fill(0.0);
        for (value, vector) in &self.pairs {
            let part = dot(vector, right) / value;
            for (x, v) in x.iter_mut().zip(vector) {
                *x += part * v;
            }
        }
    }
}

/// Null space of Ĝ_I on a face.
struct Tangent<'a> {
    active: &'a [bool],
    gram: Pseudo,
    parts: Vec<f64>,
    right: Vec<f64>,
}

impl<'a> Tangent<'a> {
    fn new(setup: &Setup<'_>, active: &'a [bool]) -> Self {
        let rows = &setup.balance.rows;
        let on_face = |l: usize, j: usize| if active[l] { rows[j][l] } else { 0.0 };
        let gram = gram(&Mat::from_fn(active.len(), rows.len(), on_face));
        Self {
            active,
            gram: Pseudo::new(&gram),
            parts: vec![0.0; rows.len()],
            right: vec![0.0; rows.len()],
        }
    }

    fn mask(&self, v: &mut [f64]) {
        for (v, active) in v.iter_mut().zip(self.active) {
            if !active {
                *v = 0.0;
            }
        }
    }

    /// v ← the nearest vector on the face with Ĝv = 0.
    fn project(&mut self, setup: &Setup<'_>, v: &mut [f64]) {
        self.mask(v);
        setup.balance.apply(v, &mut self.parts);
        self.subtract(setup, v);
    }

    /// v ← the nearest vector on the face with Ĝv = ê.
    fn restore(&mut self, setup: &Setup<'_>, v: &mut [f64]) {
        self.mask(v);
        setup.balance.imbalance(v, &mut self.parts);
        self.subtract(setup, v);
    }

    /// v ← the nearest vector with Ĝv = ê that differs on the face only.
    fn rebalance(&mut self, setup: &Setup<'_>, v: &mut [f64]) {
        setup.balance.imbalance(v, &mut self.parts);
        let mut change = vec![0.0; v.len()];
        self.subtract(setup, &mut change);
        for (v, change) in v.iter_mut().zip(&change) {
            *v += change;
        }
    }

    /// v −= Ĝ_Iᵀ(Ĝ_IĜ_Iᵀ)⁺`parts`.
    fn subtract(&mut self, setup: &Setup<'_>, v: &mut [f64]) {
        self.gram.solve(&mut self.parts, &mut self.right);
        setup.balance.add_transposed(-1.0, &self.parts, v);
        self.mask(v);
    }
}

/// Factored saddle system of a face.
struct System {
    /// Contact unknowns of the face that are independent.
    face: Vec<usize>,
    /// Cholesky factor of F_II + ρĜ_IᵀĜ_I.
    factor: Mat<f64>,
    rho: f64,
    /// Ĝ_Iᵀ and (F_II + ρĜ_IᵀĜ_I)⁻¹Ĝ_Iᵀ, k columns.
    rows: Mat<f64>,
    solved: Mat<f64>,
    schur: Pseudo,
}

impl System {
    fn new(setup: &Setup<'_>, matrix: &Mat<f64>, active: &[bool]) -> Self {
        let mut face: Vec<usize> = (0..active.len()).filter(|&i| active[i]).collect();
        let k = setup.modes();
        let rows_on =
            |face: &[usize]| Mat::from_fn(face.len(), k, |i, j| setup.balance.rows[j][face[i]]);
        let mut rows = rows_on(&face);
        let stiffness: f64 = face.iter().map(|&i| matrix[(i, i)]).sum();
        let weight: f64 = (0..k)
            .map(|j| dot(rows.col_as_slice(j), rows.col_as_slice(j)))
            .sum();
        let rho = match (stiffness > 0.0, weight > 0.0) {
            (true, true) => stiffness / weight,
            (false, true) => 1.0,
            (_, false) => 0.0,
        };
        let augmented = augmented(matrix, &face, &rows, rho);
        let mut factor = augmented.clone();
        if cholesky_in_place(&mut factor).is_err() || has_dependent_row(&factor, &augmented) {
            let kept = independent_rows(&augmented);
            face = kept.iter().map(|&i| face[i]).collect();
            rows = rows_on(&face);
            factor = Mat::from_fn(kept.len(), kept.len(), |i, j| augmented[(kept[i], kept[j])]);
            // Independent by construction: the pivots are the ones just found.
            if cholesky_in_place(&mut factor).is_err() {
                face.clear();
                rows = rows_on(&face);
                factor = Mat::zeros(0, 0);
            }
        }
        let mut solved = rows.clone();
        solve_lower_in_place(&factor, &mut solved);
        solve_lower_transpose_in_place(&factor, &mut solved);
        let schur = transpose_product(&rows, &solved);
        let schur = Mat::from_fn(k, k, |i, j| 0.5 * (schur[(i, j)] + schur[(j, i)]));
        Self {
            face,
            factor,
            rho,
            schur: Pseudo::new(&schur),
            rows,
            solved,
        }
    }

    /// Adds the solution for the right-hand side (`displacement` on the face, `rest` of the balance).
    fn correct(&self, displacement: &[f64], rest: &[f64], lambda: &mut [f64], alpha: &mut [f64]) {
        if self.face.is_empty() {
            return;
        }
        let mut forces = displacement[..self.face.len()].to_vec();
        solve_cholesky_in_place(&self.factor, &mut forces);
        let mut shift: Vec<f64> = (0..rest.len())
            .map(|j| rest[j] - dot(self.rows.col_as_slice(j), &forces))
            .collect();
        self.schur.solve(&mut shift, &mut vec![0.0; rest.len()]);
        for (j, shift) in shift.iter().enumerate() {
            for (force, x) in forces.iter_mut().zip(self.solved.col_as_slice(j)) {
                *force += shift * x;
            }
        }
        for (force, &i) in forces.iter().zip(&self.face) {
            lambda[i] += force;
        }
        for ((alpha, shift), rest) in alpha.iter_mut().zip(&shift).zip(rest) {
            *alpha += shift - self.rho * rest;
        }
        for direction in &self.schur.null {
            let part = dot(direction, alpha);
            for (alpha, z) in alpha.iter_mut().zip(direction) {
                *alpha -= part * z;
            }
        }
    }
}

/// F_II + ρĜ_IᵀĜ_I.
fn augmented(matrix: &Mat<f64>, face: &[usize], rows: &Mat<f64>, rho: f64) -> Mat<f64> {
    let scaled = Mat::from_fn(rows.ncols(), rows.nrows(), |j, i| rho * rows[(i, j)]);
    let mut out = product(rows, &scaled);
    for j in 0..face.len() {
        let from = matrix.col_as_slice(face[j]);
        for (to, &i) in out.col_as_slice_mut(j).iter_mut().zip(face) {
            *to += from[i];
        }
    }
    out
}

fn has_dependent_row(factor: &Mat<f64>, matrix: &Mat<f64>) -> bool {
    (0..factor.nrows()).any(|i| factor[(i, i)].powi(2) <= DEPENDENT * matrix[(i, i)])
}

/// Rows of a semidefinite matrix that do not depend on others: Cholesky with pivoting, largest pivot first.
fn independent_rows(matrix: &Mat<f64>) -> Vec<usize> {
    let n = matrix.nrows();
    let mut pivots: Vec<f64> = (0..n).map(|i| matrix[(i, i)]).collect();
    let mut kept: Vec<usize> = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut open: Vec<usize> = (0..n).collect();
    while let Some(place) =
        (0..open.len()).max_by(|&a, &b| pivots[open[a]].total_cmp(&pivots[open[b]]).then(b.cmp(&a)))
    {
        let pivot = open[place];
        if pivots[pivot] <= 1e-12 * matrix[(pivot, pivot)] || pivots[pivot] <= 0.0 {
            // Judged against its own size: a stiff contact beside a soft one is not dependent.
            open.swap_remove(place);
            continue;
        }
        open.swap_remove(place);
        let root = pivots[pivot].sqrt();
        let column: Vec<f64> = (0..n)
            .map(|i| {
                let known: f64 = columns.iter().map(|c| c[i] * c[pivot]).sum();
                (matrix[(i, pivot)] - known) / root
            })
            .collect();
        for &i in &open {
            pivots[i] -= column[i] * column[i];
        }
        columns.push(column);
        kept.push(pivot);
    }
    kept.sort_unstable();
    kept
}
