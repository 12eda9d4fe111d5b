//! Dense algebra of the contact unknowns: products, Cholesky, spectra, least squares.
//!
//! Matrices are column-major. Kernels are sequential; where columns of a result are independent they are shared among
//! threads in blocks of a fixed width, so that the bits do not depend on the number of threads.
//! A "lower" factor has zeros above its diagonal. Shapes that do not fit are errors of the program and panic.

use crate::linalg::LinalgError;
use dyn_stack::{MemBuffer, MemStack};
use faer::diag::Diag;
use faer::linalg::cholesky::llt;
use faer::linalg::cholesky::llt_pivoting;
use faer::linalg::evd;
use faer::linalg::lu::partial_pivoting as lu;
use faer::linalg::matmul::matmul;
use faer::linalg::svd;
use faer::linalg::triangular_solve;
use faer::perm::PermRef;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Columns of a result that one task computes.
const COLUMNS_PER_TASK: usize = 64;

/// a · b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Euclidean length.
pub(crate) fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

/// AB; a (m, k), b (k, n).
pub fn product(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    product_of(a.as_ref(), b.as_ref())
}

/// AᵀB; a (k, m), b (k, n).
pub fn transpose_product(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    product_of(a.as_ref().transpose(), b.as_ref())
}

fn product_of(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut result = Mat::zeros(a.nrows(), b.ncols());
    let blocks = result.par_col_chunks_mut(COLUMNS_PER_TASK).enumerate();
    blocks.for_each(|(task, block)| {
        let columns = b.subcols(task * COLUMNS_PER_TASK, block.ncols());
        matmul(block, Accum::Replace, a, columns, 1.0, Par::Seq);
    });
    result
}

/// AᵀA, (n, n), exactly symmetric; a (m, n).
pub fn gram(a: &Mat<f64>) -> Mat<f64> {
    let n = a.ncols();
    let mut result = Mat::zeros(n, n);
    let blocks = result.par_col_chunks_mut(COLUMNS_PER_TASK).enumerate();
    blocks.for_each(|(task, mut block)| {
        let first = task * COLUMNS_PER_TASK;
        let lower = block.as_mut().subrows_mut(first, n - first);
        let rows = a.subcols(first, n - first).transpose();
        let columns = a.subcols(first, lower.ncols());
        matmul(lower, Accum::Replace, rows, columns, 1.0, Par::Seq);
    });
    mirror_lower(&mut result);
    result
}

/// Copies the lower triangle to the upper one, tile by tile to stay in the cache.
pub(super) fn mirror_lower(a: &mut Mat<f64>) {
    const TILE: usize = 32;
    let n = a.ncols();
    for j0 in (0..n).step_by(TILE) {
        for i0 in (j0..n).step_by(TILE) {
            for j in j0..n.min(j0 + TILE) {
                for i in i0.max(j + 1)..n.min(i0 + TILE) {
                    a[(j, i)] = a[(i, j)];
                }
            }
        }
    }
}

/// y = Ax; a (m, n), x (n,), y (m,). One thread: the product waits for the memory, which one thread of two keeps busy (measured
/// for n from 500 to 8000).
pub fn matvec(a: &Mat<f64>, x: &[f64], y: &mut [f64]) {
    let (rows, columns) = (a.nrows(), a.ncols());
    let x = MatRef::from_column_major_slice(x, columns, 1);
    let y = MatMut::from_column_major_slice_mut(y, rows, 1);
    matmul(y, Accum::Replace, a, x, 1.0, Par::Seq);
}

/// Replaces the symmetric (n, n) matrix, of which only the lower triangle is read, by its lower factor L, A = LLᵀ.
///
/// Errors: [`LinalgError::NotFinite`], [`LinalgError::NotPositiveDefinite`]; the matrix is then spoilt.
pub fn cholesky_in_place(a: &mut Mat<f64>) -> Result<(), LinalgError> {
    let n = a.nrows();
    for j in 0..n {
        check_finite(&a.col_as_slice(j)[j..], j)?;
    }
    let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    llt::factor::cholesky_in_place(
        a.as_mut(),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|llt::factor::LltError::NonPositivePivot { index: dof }| {
        LinalgError::NotPositiveDefinite { dof }
    })?;
    // The kernel uses the strict upper triangle as work space.
    for j in 1..n {
        a.col_as_slice_mut(j)[..j].fill(0.0);
    }
    Ok(())
}

/// B ← L⁻¹B; l (n, n) lower, b (n, k).
pub fn solve_lower_in_place(l: &Mat<f64>, b: &mut Mat<f64>) {
    let blocks = b.par_col_chunks_mut(COLUMNS_PER_TASK);
    blocks.for_each(|block| {
        triangular_solve::solve_lower_triangular_in_place(l.as_ref(), block, Par::Seq);
    });
}

/// B ← L⁻ᵀB; l (n, n) lower, b (n, k).
pub fn solve_lower_transpose_in_place(l: &Mat<f64>, b: &mut Mat<f64>) {
    let blocks = b.par_col_chunks_mut(COLUMNS_PER_TASK);
    blocks.for_each(|block| {
        let upper = l.as_ref().transpose();
        triangular_solve::solve_upper_triangular_in_place(upper, block, Par::Seq);
    });
}

/// b ← (LLᵀ)⁻¹b; l (n, n) lower, b (n,).
pub fn solve_cholesky_in_place(l: &Mat<f64>, b: &mut [f64]) {
    let n = b.len();
    let mut column = MatMut::from_column_major_slice_mut(b, n, 1);
    triangular_solve::solve_lower_triangular_in_place(l.as_ref(), column.as_mut(), Par::Seq);
    triangular_solve::solve_upper_triangular_in_place(l.as_ref().transpose(), column, Par::Seq);
}

/// Eigenvalues of a symmetric matrix, ascending, and the orthonormal eigenvectors as columns; only its lower triangle
/// is read.
///
/// Errors: [`LinalgError::NotFinite`], [`LinalgError::NoConvergence`].
pub fn symmetric_eigen(a: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), LinalgError> {
    let n = a.nrows();
    check_matrix(a)?;
    let (mut values, mut vectors) = (Diag::zeros(n), Mat::zeros(n, n));
    if n == 0 {
        // the library's decomposition counts down from n
        return Ok((Vec::new(), vectors));
    }
    let wanted = evd::ComputeEigenvectors::Yes;
    let scratch = evd::self_adjoint_evd_scratch::<f64>(n, wanted, Par::Seq, Default::default());
    evd::self_adjoint_evd(
        a.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .map_err(|_| no_convergence(a))?;
    Ok(((0..n).map(|i| values[i]).collect(), vectors))
}

/// A = U diag(s) Vᵀ with s descending; U and V as wide as requested.
pub struct Spectrum {
    /// U.
    pub left: Mat<f64>,
    /// s, (min(m, n),).
    pub values: Vec<f64>,
    /// V.
    pub right: Mat<f64>,
}

/// A = U diag(s) Vᵀ, a (m, n), U (m, min(m, n)) and the whole V (n, n), s descending.
///
/// Errors: [`LinalgError::NotFinite`], [`LinalgError::NoConvergence`].
pub fn singular_value_decomposition(a: &Mat<f64>) -> Result<Spectrum, LinalgError> {
    let n = a.ncols();
    if a.nrows() == 0 || n == 0 {
        return Ok(Spectrum {
            left: Mat::zeros(a.nrows(), 0),
            values: Vec::new(),
            right: Mat::identity(n, n),
        });
    }
    singular_values(a, a.nrows().min(n), n)
}

impl Spectrum {
    /// Number of singular values above `tolerance` times the largest.
    fn rank(&self, tolerance: f64) -> usize {
        let largest = self.values.first().copied().unwrap_or(0.0);
        let above = |&&s: &&f64| s > tolerance * largest && s > 0.0;
        self.values.iter().take_while(above).count()
    }
}

/// Singular value decomposition with `left` columns of U (none or min(m, n)) and `right` columns of V (min(m, n) or n).
fn singular_values(a: &Mat<f64>, left: usize, right: usize) -> Result<Spectrum, LinalgError> {
    let (m, n) = (a.nrows(), a.ncols());
    check_matrix(a)?;
    let mut values = Diag::zeros(m.min(n));
    let (mut u, mut v) = (Mat::zeros(m, left), Mat::zeros(n, right));
    let computed_left = match left {
        0 => svd::ComputeSvdVectors::No,
        _ => svd::ComputeSvdVectors::Thin,
    };
    let scratch = svd::svd_scratch::<f64>(
        m,
        n,
        computed_left,
        svd::ComputeSvdVectors::Full,
        Par::Seq,
        Default::default(),
    );
    let mut memory = MemBuffer::new(scratch);
    svd::svd(
        a.as_ref(),
        values.as_mut(),
        (left > 0).then(|| u.as_mut()),
        Some(v.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|_| no_convergence(a))?;
    Ok(Spectrum {
        left: u,
        values: (0..m.min(n)).map(|i| values[i]).collect(),
        right: v,
    })
}

/// Orthonormal basis, as columns, of the vectors x with Ax = 0; a (m, n).
///
/// Singular values up to `tolerance` times the largest count as zero.
///
/// Errors: [`LinalgError::NotFinite`], [`LinalgError::NoConvergence`].
pub fn null_space(a: &Mat<f64>, tolerance: f64) -> Result<Mat<f64>, LinalgError> {
    let n = a.ncols();
    if a.nrows() == 0 || n == 0 {
        return Ok(Mat::identity(n, n));
    }
    let spectrum = singular_values(a, 0, n)?;
    let rank = spectrum.rank(tolerance);
    Ok(spectrum.right.subcols(rank, n - rank).to_owned())
}

/// The X of least norm among those that minimise |AX − B|; a (m, n) of any rank, b (m, k), X (n, k).
///
/// Singular values up to `tolerance` times the largest count as zero.
///
/// Errors: [`LinalgError::NotFinite`], [`LinalgError::NoConvergence`].
pub fn least_squares(a: &Mat<f64>, b: &Mat<f64>, tolerance: f64) -> Result<Mat<f64>, LinalgError> {
    check_matrix(b)?;
    let size = a.nrows().min(a.ncols());
    if size == 0 {
        return Ok(Mat::zeros(a.ncols(), b.ncols()));
    }
    let spectrum = singular_values(a, size, size)?;
    let rank = spectrum.rank(tolerance);
    let mut coefficients = transpose_product(&spectrum.left.subcols(0, rank).to_owned(), b);
    for j in 0..coefficients.ncols() {
        let column = coefficients.col_as_slice_mut(j).iter_mut();
        for (c, s) in column.zip(&spectrum.values) {
            *c /= s;
        }
    }
    Ok(product_of(
        spectrum.right.subcols(0, rank),
        coefficients.as_ref(),
    ))
}

/// Splits the rows of a symmetric positive semidefinite matrix into a largest independent set and the rest, both
/// ascending, by Cholesky factorisation with diagonal pivoting.
///
/// The matrix is scaled to a unit diagonal first, so rows of different units are treated alike: a row is dependent when
/// the part of it that is independent of the earlier pivots is at most `tolerance` (of its diagonal entry). Values of
/// `tolerance` below n·2⁻⁵² act as n·2⁻⁵². Only the lower triangle is read.
///
/// Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), section 10.3.
///
/// Errors: [`LinalgError::NotFinite`], [`LinalgError::NotPositiveDefinite`] when a diagonal entry is negative.
pub fn pivoted_cholesky(
    a: &Mat<f64>,
    tolerance: f64,
) -> Result<(Vec<usize>, Vec<usize>), LinalgError> {
    check_matrix(a)?;
    let all = 0..a.nrows();
    if let Some(dof) = all.clone().find(|&i| a[(i, i)] < 0.0) {
        return Err(LinalgError::NotPositiveDefinite { dof });
    }
    let (candidates, mut dependent): (Vec<usize>, Vec<usize>) = all.partition(|&i| a[(i, i)] > 0.0);
    let n = candidates.len();
    if n == 0 {
        return Ok((Vec::new(), dependent));
    }
    let scale: Vec<f64> = candidates
        .iter()
        .map(|&i| a[(i, i)].sqrt().recip())
        .collect();
    let mut scaled = Mat::from_fn(n, n, |i, j| {
        let (row, column) = (candidates[i.max(j)], candidates[i.min(j)]);
        a[(row, column)] * scale[i] * scale[j]
    });
    let (mut order, mut inverse) = (vec![0usize; n], vec![0usize; n]);
    let scratch = llt_pivoting::factor::cholesky_in_place_scratch::<usize, f64>(
        n,
        Par::Seq,
        Default::default(),
    );
    let (info, _) = llt_pivoting::factor::cholesky_in_place(
        scaled.as_mut(),
        &mut order,
        &mut inverse,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .map_err(
        |llt_pivoting::factor::LltError::NonPositivePivot { index }| LinalgError::NotFinite {
            row: candidates[index],
        },
    )?;
    let rank = (0..info.rank)
        .take_while(|&k| scaled[(k, k)].powi(2) > tolerance)
        .count();
    let mut independent: Vec<usize> = order[..rank].iter().map(|&k| candidates[k]).collect();
    dependent.extend(order[rank..].iter().map(|&k| candidates[k]));
    independent.sort_unstable();
    dependent.sort_unstable();
    Ok((independent, dependent))
}

/// A = P⁻¹LU of a square matrix, by rows exchanged for the largest pivot.
pub struct Lu {
    factors: Mat<f64>,
    rows: Vec<usize>,
    inverse: Vec<usize>,
}

impl Lu {
    /// Factors a (n, n).
    ///
    /// Errors: [`LinalgError::NotFinite`]; [`LinalgError::Singular`] when a pivot is at most n·2⁻⁵² times the largest entry.
    pub fn new(a: Mat<f64>) -> Result<Self, LinalgError> {
        let n = a.nrows();
        let largest = (0..n)
            .flat_map(|j| a.col_as_slice(j))
            .fold(0.0, |m: f64, value| m.max(value.abs()));
        Self::with_pivots(a, n as f64 * f64::EPSILON * largest)
    }

    /// The same for a matrix whose small pivots are legitimate, for example because a barrier adds its own size to each diagonal entry.
    ///
    /// Errors: as those of [`Self::new`], but only a pivot that is zero is refused.
    pub fn graded(a: Mat<f64>) -> Result<Self, LinalgError> {
        Self::with_pivots(a, 0.0)
    }

    fn with_pivots(mut a: Mat<f64>, smallest_pivot: f64) -> Result<Self, LinalgError> {
        check_matrix(&a)?;
        let n = a.nrows();
        let (mut rows, mut inverse) = (vec![0usize; n], vec![0usize; n]);
        let scratch =
            lu::factor::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        lu::factor::lu_in_place(
            a.as_mut(),
            &mut rows,
            &mut inverse,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        let vanishes = |pivot: f64| pivot.is_nan() || pivot.abs() <= smallest_pivot;
        match (0..n).find(|&k| vanishes(a[(k, k)])) {
            Some(column) => Err(LinalgError::Singular { column }),
            None => Ok(Self {
                factors: a,
                rows,
                inverse,
            }),
        }
    }

    /// B ← A⁻¹B; b (n, k).
    pub fn solve_in_place(&self, b: &mut Mat<f64>) {
        let (n, columns) = (self.factors.nrows(), b.ncols());
        let scratch = lu::solve::solve_in_place_scratch::<usize, f64>(n, columns, Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        lu::solve::solve_in_place(
            self.factors.as_ref(),
            self.factors.as_ref(),
            PermRef::new_checked(&self.rows, &self.inverse, n),
            b.as_mut(),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

fn check_finite(column: &[f64], first_row: usize) -> Result<(), LinalgError> {
    match column.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(i) => Err(LinalgError::NotFinite { row: first_row + i }),
    }
}

fn check_matrix(a: &Mat<f64>) -> Result<(), LinalgError> {
    (0..a.ncols()).try_for_each(|j| check_finite(a.col_as_slice(j), 0))
}

fn no_convergence(a: &Mat<f64>) -> LinalgError {
    LinalgError::NoConvergence {
        rows: a.nrows(),
        columns: a.ncols(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::grid;

    fn noise(rows: usize, columns: usize) -> Mat<f64> {
        let values = grid::noise(rows * columns);
        Mat::from_fn(rows, columns, |i, j| values[j * rows + i])
    }

    /// AB by the definition.
    fn plain_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(a.nrows(), b.ncols(), |i, j| {
            (0..a.ncols()).map(|k| a[(i, k)] * b[(k, j)]).sum()
        })
    }

    fn assert_close(a: &Mat<f64>, b: &Mat<f64>, tolerance: f64) {
        assert_eq!((a.nrows(), a.ncols()), (b.nrows(), b.ncols()));
        for j in 0..a.ncols() {
            for i in 0..a.nrows() {
                let difference = (a[(i, j)] - b[(i, j)]).abs();
                assert!(difference <= tolerance, "({i}, {j}): {difference:e}");
            }
        }
    }

    /// A well-conditioned symmetric matrix.
    fn definite(n: usize) -> Mat<f64> {
        let mut a = gram(&noise(2 * n + 3, n));
        for i in 0..n {
            a[(i, i)] += 1.0;
        }
        a
    }

    #[test]
    fn products_follow_their_definition() {
        let (a, b) = (noise(37, 21), noise(21, 150));
        assert_close(
            &product(&a, &b),
            &plain_product(a.as_ref(), b.as_ref()),
            1e-13,
        );
        let c = noise(37, 80);
        let expected = plain_product(a.as_ref().transpose(), c.as_ref());
        assert_close(&transpose_product(&a, &c), &expected, 1e-13);
        let (x, mut y) = (grid::noise(21), vec![0.0; 37]);
        matvec(&a, &x, &mut y);
        for i in 0..37 {
            let expected: f64 = (0..21).map(|j| a[(i, j)] * x[j]).sum();
            assert!((y[i] - expected).abs() < 1e-13);
        }
    }

    #[test]
    fn an_empty_matrix_has_no_eigenvalues() {
        assert!(symmetric_eigen(&Mat::zeros(0, 0)).unwrap().0.is_empty());
    }

    #[test]
    fn gram_is_the_exactly_symmetric_product() {
        let a = noise(91, 2 * COLUMNS_PER_TASK + 11);
        let g = gram(&a);
        assert_close(
            &g,
            &plain_product(a.as_ref().transpose(), a.as_ref()),
            1e-13,
        );
        assert!(g == g.transpose().to_owned());
    }

    #[test]
    fn blocked_operations_have_the_same_bits_on_any_number_of_threads() {
        let a = noise(201, 3 * COLUMNS_PER_TASK + 7);
        let run = || {
            let mut l = definite(201);
            cholesky_in_place(&mut l).unwrap();
            let mut x = a.clone();
            solve_lower_in_place(&l, &mut x);
            solve_lower_transpose_in_place(&l, &mut x);
            (gram(&a), product(&l, &a), x)
        };
        assert!(grid::on_threads(1, run) == grid::on_threads(2, run));
    }

    #[test]
    fn cholesky_reproduces_the_matrix_and_solves_with_it() {
        let a = definite(150);
        let mut l = a.clone();
        cholesky_in_place(&mut l).unwrap();
        assert_eq!(l[(3, 90)], 0.0);
        assert_close(
            &plain_product(l.as_ref(), l.as_ref().transpose()),
            &a,
            1e-12,
        );
        let expected = noise(150, 70);
        let mut x = product(&a, &expected);
        for column in 0..x.ncols() {
            solve_cholesky_in_place(&l, x.col_as_slice_mut(column));
        }
        assert_close(&x, &expected, 1e-11);
        let mut half = expected.clone();
        solve_lower_transpose_in_place(&l, &mut half);
        assert_close(&product(&l.transpose().to_owned(), &half), &expected, 1e-12);
    }

    #[test]
    fn a_matrix_without_a_factor_is_refused() {
        let mut a = Mat::from_fn(3, 3, |i, j| if i == j { 1.0 } else { 0.0 });
        a[(1, 1)] = -2.0;
        let refused = cholesky_in_place(&mut a).unwrap_err();
        assert_eq!(refused, LinalgError::NotPositiveDefinite { dof: 1 });
        a[(2, 1)] = f64::INFINITY;
        let refused = cholesky_in_place(&mut a).unwrap_err();
        assert_eq!(refused, LinalgError::NotFinite { row: 2 });
    }

    #[test]
    fn eigenvalues_of_a_chain_are_known() {
        let n = 30;
        let chain = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        let (values, vectors) = symmetric_eigen(&chain).unwrap();
        for (k, value) in values.iter().enumerate() {
            let angle = (k + 1) as f64 * std::f64::consts::PI / (n + 1) as f64;
            assert!((value - (2.0 - 2.0 * angle.cos())).abs() < 1e-13);
        }
        let image = product(&chain, &vectors);
        let scaled = Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j]);
        assert_close(&image, &scaled, 1e-13);
        assert_close(&gram(&vectors), &Mat::identity(n, n), 1e-13);
    }

    #[test]
    fn the_null_space_is_orthonormal_and_complete() {
        for (rows, rank, columns) in [(9, 4, 7), (5, 5, 8), (40, 3, 6), (3, 2, 30)] {
            let a = product(&noise(rows, rank), &noise(rank, columns));
            let basis = null_space(&a, 1e-10).unwrap();
            assert_eq!(basis.ncols(), columns - rank);
            let k = basis.ncols();
            assert_close(&gram(&basis), &Mat::identity(k, k), 1e-13);
            assert_close(&product(&a, &basis), &Mat::zeros(rows, k), 1e-13);
        }
        assert_eq!(null_space(&Mat::zeros(2, 3), 1e-10).unwrap().ncols(), 3);
        assert_eq!(null_space(&Mat::zeros(0, 3), 1e-10).unwrap().ncols(), 3);
    }

    #[test]
    fn least_squares_is_normal_and_of_least_norm() {
        for (rows, rank, columns) in [(12, 5, 5), (5, 5, 12), (10, 3, 7)] {
            let a = product(&noise(rows, rank), &noise(rank, columns));
            let b = noise(rows, 2);
            let x = least_squares(&a, &b, 1e-10).unwrap();
            let ax = product(&a, &x);
            let residual = Mat::from_fn(rows, 2, |i, j| ax[(i, j)] - b[(i, j)]);
            let zero = transpose_product(&a, &residual);
            assert_close(&zero, &Mat::zeros(columns, 2), 1e-12);
            let basis = null_space(&a, 1e-10).unwrap();
            let idle = transpose_product(&basis, &x);
            assert_close(&idle, &Mat::zeros(columns - rank, 2), 1e-12);
        }
    }

    #[test]
    fn dependent_rows_are_found_whatever_their_units() {
        // Rows 3 and 8 repeat combinations of others, row 5 is zero, and the units differ by 1e12.
        let mut factor = noise(40, 10);
        for i in 0..40 {
            factor[(i, 3)] = factor[(i, 1)] - 2.0 * factor[(i, 6)];
            factor[(i, 8)] = factor[(i, 0)];
            factor[(i, 5)] = 0.0;
        }
        for j in 0..10 {
            for i in 0..40 {
                factor[(i, j)] *= if j % 2 == 0 { 1e6 } else { 1e-6 };
            }
        }
        let a = gram(&factor);
        let (independent, dependent) = pivoted_cholesky(&a, 1e-12).unwrap();
        assert_eq!(dependent.len(), 3);
        assert!(dependent.contains(&5));
        assert!(dependent.contains(&0) || dependent.contains(&8));
        let kept = independent.len();
        let mut block = Mat::from_fn(kept, kept, |i, j| {
            let (i, j) = (independent[i], independent[j]);
            a[(i, j)] / (a[(i, i)] * a[(j, j)]).sqrt()
        });
        assert!(cholesky_in_place(&mut block).is_ok());
        let nothing = pivoted_cholesky(&Mat::zeros(2, 2), 1e-12).unwrap();
        assert_eq!(nothing, (vec![], vec![0, 1]));
    }

    #[test]
    fn saddle_point_systems_are_solved_and_singular_ones_refused() {
        // A zero on the diagonal forces a row exchange.
        let a = Mat::from_fn(3, 3, |i, j| {
            [[0.0, 2.0, 1.0], [2.0, 1.0, 0.0], [1.0, 0.0, 0.0]][i][j]
        });
        let mut b = Mat::from_fn(3, 1, |i, _| [7.0, 4.0, 1.0][i]);
        Lu::new(a).unwrap().solve_in_place(&mut b);
        assert_close(&b, &Mat::from_fn(3, 1, |i, _| [1.0, 2.0, 3.0][i]), 1e-15);
        let singular = Mat::from_fn(3, 3, |i, j| (3 * i + j) as f64);
        let refused = Lu::new(singular).err();
        assert_eq!(refused, Some(LinalgError::Singular { column: 2 }));
    }
}
