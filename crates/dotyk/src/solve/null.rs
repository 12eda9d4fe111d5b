//! The balance on some unknowns alone: its null space, and what of least norm restores it.

use crate::linalg::dense::{cholesky_in_place, product, solve_cholesky_in_place, symmetric_eigen};
use crate::linalg::{Mat, SparseVector};
use crate::solve::dot;

/// Eigenvalues of a balance matrix below this part of the largest count as zero.
const RANK: f64 = 1e-12;

/// Matrices from this size on are first tried as definite ones: their eigenvalues take 30 times as long as a factor.
const LARGE: usize = 96;

/// A definite matrix remains one when this part of its norm is taken from the diagonal.
const DEFINITE: f64 = 1e-11;

/// Pseudo-inverse of a symmetric positive semidefinite matrix.
pub(crate) struct Pseudo {
    inverse: Inverse,
    /// Orthonormal basis of its null space.
    pub null: Vec<Vec<f64>>,
}

enum Inverse {
    /// Eigenvalues that are not zero, with their vectors.
    Spectral(Vec<(f64, Vec<f64>)>),
    /// Cholesky factor, made definite along the null vectors.
    Factor(Mat<f64>),
}

impl Pseudo {
    /// Of a matrix with the orthonormal null vectors `known`, or more.
    pub fn new(matrix: &Mat<f64>, known: &[Vec<f64>]) -> Self {
        if let Some(factor) = definite_factor(matrix, known) {
            return Self {
                inverse: Inverse::Factor(factor),
                null: known.to_vec(),
            };
        }
        let k = matrix.nrows();
        let (values, vectors) =
            symmetric_eigen(matrix).unwrap_or_else(|_| (vec![0.0; k], Mat::identity(k, k)));
        let largest = values.last().copied().unwrap_or(0.0);
        let (mut pairs, mut null) = (Vec::new(), Vec::new());
        for (j, value) in values.into_iter().enumerate() {
            let vector = vectors.col_as_slice(j).to_vec();
            if value > RANK * largest {
                pairs.push((value, vector));
            } else {
                null.push(vector);
            }
        }
        Self {
            inverse: Inverse::Spectral(pairs),
            null,
        }
    }

    /// x ← A⁺x; `right` is workspace of the same length.
    pub fn solve(&self, x: &mut [f64], right: &mut [f64]) {
        let pairs = match &self.inverse {
            Inverse::Factor(factor) => {
                solve_cholesky_in_place(factor, x);
                for z in &self.null {
                    let part = dot(z, x);
                    x.iter_mut().zip(z).for_each(|(x, z)| *x -= part * z);
                }
                return;
            }
            Inverse::Spectral(pairs) => pairs,
        };
        right.copy_from_slice(x);
        x.fill(0.0);
        for (value, vector) in pairs {
            let part = dot(vector, right) / value;
            for (x, v) in x.iter_mut().zip(vector) {
                *x += part * v;
            }
        }
    }
}

/// The Cholesky factor of a large matrix plus a multiple of Σ zzᵀ over its null vectors z, where it has no other
/// eigenvalues near zero: that the factor of a shifted matrix exists proves it.
fn definite_factor(matrix: &Mat<f64>, known: &[Vec<f64>]) -> Option<Mat<f64>> {
    let k = matrix.nrows();
    if k < LARGE {
        return None;
    }
    let mut matrix = matrix.clone();
    if !known.is_empty() {
        let diagonal = (0..k).map(|j| matrix[(j, j)]).fold(0.0, f64::max);
        let null = Mat::from_fn(k, known.len(), |i, j| known[j][i]);
        add_outer(&mut matrix, diagonal, &null);
    }
    let columns = (0..k).map(|j| matrix.col_as_slice(j).iter().map(|x| x.abs()).sum());
    let shift = DEFINITE * columns.fold(0.0, f64::max);
    let mut shifted = matrix.clone();
    for j in 0..k {
        shifted[(j, j)] -= shift;
    }
    cholesky_in_place(&mut shifted).ok()?;
    cholesky_in_place(&mut matrix).ok()?;
    Some(matrix)
}

/// a += ϱ rows rowsᵀ.
pub(crate) fn add_outer(a: &mut Mat<f64>, rho: f64, rows: &Mat<f64>) {
    let scaled = Mat::from_fn(rows.ncols(), rows.nrows(), |j, i| rho * rows[(i, j)]);
    let outer = product(rows, &scaled);
    for j in 0..a.ncols() {
        let column = a.col_as_slice_mut(j).iter_mut();
        column.zip(outer.col_as_slice(j)).for_each(|(a, o)| *a += o);
    }
}

/// The (k, k) products of k rows.
pub(crate) fn gram_of(rows: &[SparseVector]) -> Mat<f64> {
    let mut columns: Vec<Vec<(usize, f64)>> = Vec::new();
    columns.resize(rows.first().map_or(0, SparseVector::len), Vec::new());
    for (i, row) in rows.iter().enumerate() {
        row.entries()
            .for_each(|(a, value)| columns[a].push((i, value)));
    }
    let mut gram = Mat::zeros(rows.len(), rows.len());
    for column in &columns {
        for (place, &(j, y)) in column.iter().enumerate() {
            let out = gram.col_as_slice_mut(j);
            column[place..].iter().for_each(|&(i, x)| out[i] += x * y);
        }
    }
    for j in 0..rows.len() {
        for i in j + 1..rows.len() {
            gram[(j, i)] = gram[(i, j)];
        }
    }
    gram
}

/// Null space of the balance on some unknowns.
pub(crate) struct Null {
    gram: Pseudo,
    parts: Vec<f64>,
    right: Vec<f64>,
}

impl Null {
    /// Of k rows; `known` are orthonormal z (k,) with zᵀ`rows` = 0, all or none.
    pub fn new(rows: &[SparseVector], known: &[Vec<f64>]) -> Self {
        Self {
            gram: Pseudo::new(&gram_of(rows), known),
            parts: vec![0.0; rows.len()],
            right: vec![0.0; rows.len()],
        }
    }

    /// v ← the nearest vector whose rows vanish.
    pub fn project(&mut self, rows: &[SparseVector], v: &mut [f64]) {
        for (part, row) in self.parts.iter_mut().zip(rows) {
            *part = row.dot(v);
        }
        self.subtract(rows, v);
    }

    /// v ← the nearest vector whose rows are `target` (k,).
    pub fn restore(&mut self, rows: &[SparseVector], target: &[f64], v: &mut [f64]) {
        for ((part, row), target) in self.parts.iter_mut().zip(rows).zip(target) {
            *part = row.dot(v) - target;
        }
        self.subtract(rows, v);
    }

    fn subtract(&mut self, rows: &[SparseVector], v: &mut [f64]) {
        self.gram.solve(&mut self.parts, &mut self.right);
        for (part, row) in self.parts.iter().zip(rows) {
            row.add_to(-part, v);
        }
    }

    /// α̂ of least norm whose pull on the unknowns is nearest to minus what is `open` of their conditions.
    pub fn amplitudes(&mut self, rows: &[SparseVector], open: &[f64]) -> Vec<f64> {
        for (part, row) in self.parts.iter_mut().zip(rows) {
            *part = -row.dot(open);
        }
        self.gram.solve(&mut self.parts, &mut self.right);
        self.parts.clone()
    }
}
