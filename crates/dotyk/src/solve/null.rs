//! The balance on some unknowns alone: its null space, and the change of least norm that restores it.

use crate::linalg::dense::{cholesky_in_place, product, solve_cholesky_in_place, symmetric_eigen};
use crate::linalg::{Mat, SparseVector};
use crate::solve::dot;

/// Eigenvalues of a balance matrix below this part of the largest count as zero.
const RANK: f64 = 1e-12;

/// Matrices from this size on are first tried as definite ones: their eigenvalues take 30 times as long as a factor.
const LARGE: usize = 96;

/// A definite matrix stays definite when this part of its norm is subtracted from the diagonal.
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

    /// α̂ of least norm whose pull on the unknowns is nearest to minus the residuals `open` of their conditions.
    pub fn amplitudes(&mut self, rows: &[SparseVector], open: &[f64]) -> Vec<f64> {
        for (part, row) in self.parts.iter_mut().zip(rows) {
            *part = -row.dot(open);
        }
        self.gram.solve(&mut self.parts, &mut self.right);
        self.parts.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::norm;

    fn diagonal(values: &[f64]) -> Mat<f64> {
        let n = values.len();
        Mat::from_fn(n, n, |i, j| if i == j { values[i] } else { 0.0 })
    }

    fn sparse(rows: &[Vec<f64>]) -> Vec<SparseVector> {
        rows.iter()
            .map(|row| SparseVector::from_dense(row))
            .collect()
    }

    fn solved(pseudo: &Pseudo, x: &[f64]) -> Vec<f64> {
        let (mut x, mut right) = (x.to_vec(), vec![0.0; x.len()]);
        pseudo.solve(&mut x, &mut right);
        x
    }

    #[test]
    fn eigenvalue_below_its_part_of_the_largest_is_none() {
        let pseudo = Pseudo::new(&diagonal(&[4.0, 3.9e-12, 2.0]), &[]);
        assert_eq!(pseudo.null.len(), 1);
        assert_eq!(
            pseudo.null[0].iter().map(|z| z.abs()).collect::<Vec<_>>(),
            [0.0, 1.0, 0.0]
        );
        let x = solved(&pseudo, &[1.0, 1.0, 1.0]);
        assert!((x[0] - 0.25).abs() < 1e-15 && (x[2] - 0.5).abs() < 1e-15);
        assert_eq!(x[1], 0.0);
        let pseudo = Pseudo::new(&diagonal(&[4.0, 4.1e-12, 2.0]), &[]);
        assert!(pseudo.null.is_empty());
        let x = solved(&pseudo, &[1.0, 1.0, 1.0]);
        assert!((x[1] * 4.1e-12 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn full_matrix_is_inverted_beside_its_null_space() {
        // vvᵀ + wwᵀ with v · w = 0
        let (v, w) = ([1.0, 2.0, 2.0], [2.0, 1.0, -2.0]);
        let a = Mat::from_fn(3, 3, |i, j| v[i] * v[j] + 4.0 * w[i] * w[j]);
        let pseudo = Pseudo::new(&a, &[]);
        assert_eq!(pseudo.null.len(), 1);
        assert!(dot(&pseudo.null[0], &v).abs() < 1e-14 && dot(&pseudo.null[0], &w).abs() < 1e-14);
        assert!((norm(&pseudo.null[0]) - 1.0).abs() < 1e-14);
        // A(v/9) = v, A(w/36) = w; the third direction vanishes
        let x = solved(&pseudo, &[3.0 + 2.0, 3.0 - 2.0, 1.0]);
        let expected: Vec<f64> = (0..3)
            .map(|i| {
                let right = [5.0, 1.0, 1.0];
                v[i] * dot(&v, &right) / 81.0 + w[i] * dot(&w, &right) / (4.0 * 81.0)
            })
            .collect();
        for (x, e) in x.iter().zip(expected) {
            assert!((x - e).abs() < 1e-14);
        }
    }

    #[test]
    fn large_matrices_are_factored_where_they_are_definite_beside_the_known_null_space() {
        let factored = |pseudo: &Pseudo| matches!(pseudo.inverse, Inverse::Factor(_));
        let one = |k: usize| Pseudo::new(&diagonal(&vec![2.0; k]), &[]);
        assert!(!factored(&one(LARGE - 1)) && factored(&one(LARGE)));
        // definite to more than a hundred billionth of its norm
        let with = |least: f64| {
            let mut values = vec![2.0; LARGE + 4];
            values[7] = least;
            Pseudo::new(&diagonal(&values), &[])
        };
        assert!(factored(&with(2.2e-11)));
        assert!(!factored(&with(1.8e-11)) && with(1.8e-11).null.is_empty());
        assert_eq!(with(1e-13).null.len(), 1);
        // a null vector that is known
        let k = LARGE;
        let z: Vec<f64> = (0..k)
            .map(|i| f64::from(i == 3 || i == 4) * 0.5f64.sqrt())
            .collect();
        let a = Mat::from_fn(k, k, |i, j| 3.0 * (f64::from(i == j) - z[i] * z[j]));
        let pseudo = Pseudo::new(&a, std::slice::from_ref(&z));
        assert!(factored(&pseudo) && pseudo.null == [z.clone()]);
        let right: Vec<f64> = (0..k).map(|i| (i as f64).cos()).collect();
        let x = solved(&pseudo, &right);
        let part = dot(&z, &right);
        for i in 0..k {
            assert!((x[i] - (right[i] - part * z[i]) / 3.0).abs() < 1e-13, "{i}");
        }
        // a null vector that is not known, beside it
        assert_eq!(Pseudo::new(&a, &[]).null.len(), 1);
        assert!(!factored(&Pseudo::new(&a, &[])));
    }

    #[test]
    fn outer_products_are_added_and_row_products_are_symmetric() {
        let rows = [
            vec![1.0, 0.0, 2.0, -1.0],
            vec![0.0, 0.0, 3.0, 0.5],
            vec![4.0, 0.0, 0.0, 0.0],
        ];
        let gram = gram_of(&sparse(&rows));
        for i in 0..3 {
            for j in 0..3 {
                assert_eq!(gram[(i, j)], dot(&rows[i], &rows[j]), "{i} {j}");
            }
        }
        assert_eq!(gram_of(&[]).nrows(), 0);
        let mut a = Mat::from_fn(3, 3, |i, j| (i + 10 * j) as f64);
        let columns = Mat::from_fn(3, 2, |i, j| [[1.0, 2.0], [0.0, -1.0], [3.0, 0.5]][i][j]);
        add_outer(&mut a, 0.5, &columns);
        for i in 0..3 {
            for j in 0..3 {
                let outer: f64 = (0..2).map(|c| columns[(i, c)] * columns[(j, c)]).sum();
                assert!((a[(i, j)] - ((i + 10 * j) as f64 + 0.5 * outer)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn nearest_vectors_with_given_rows_and_the_nearest_pull() {
        let rows = sparse(&[vec![1.0, 2.0, 0.0, 1.0], vec![0.0, 1.0, -1.0, 3.0]]);
        let values = |v: &[f64]| rows.iter().map(|row| row.dot(v)).collect::<Vec<f64>>();
        // two vectors on which both rows vanish
        let free = [[2.0, -1.0, -1.0, 0.0], [5.0, -3.0, 0.0, 1.0]];
        assert!(free.iter().flat_map(|w| values(w)).all(|x| x == 0.0));
        let mut null = Null::new(&rows, &[]);
        let start = [0.3, -1.2, 2.0, 0.7];
        let moved = |v: &[f64]| {
            v.iter()
                .zip(&start)
                .map(|(a, b)| a - b)
                .collect::<Vec<f64>>()
        };
        let mut v = start;
        null.project(&rows, &mut v);
        assert!(norm(&values(&v)) < 1e-14);
        assert!(free.iter().all(|w| dot(w, &moved(&v)).abs() < 1e-14));
        let mut v = start;
        null.restore(&rows, &[2.0, -0.5], &mut v);
        let found = values(&v);
        assert!((found[0] - 2.0).abs() < 1e-14 && (found[1] + 0.5).abs() < 1e-14);
        assert!(free.iter().all(|w| dot(w, &moved(&v)).abs() < 1e-14));
        // the residual beside the pull is orthogonal to every row
        let alpha = null.amplitudes(&rows, &start);
        let mut left = start;
        rows.iter()
            .zip(&alpha)
            .for_each(|(row, a)| row.add_to(*a, &mut left));
        assert!(norm(&values(&left)) < 1e-14);
    }
}
