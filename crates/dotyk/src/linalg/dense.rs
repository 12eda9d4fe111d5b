//! Dense kernels on `Mat<f64>` and slices: product, Cholesky, small general systems, symmetric eigenvalues.
//!
//! All of them run sequentially, so that the bits do not depend on the number of threads. Matrices are
//! column-major; symmetric ones are read from their lower triangle.

use dyn_stack::{MemBuffer, MemStack};
use faer::diag::Diag;
use faer::linalg::cholesky::llt::{factor, solve};
use faer::linalg::evd;
use faer::linalg::matmul::matmul;
use faer::{Accum, ColMut, ColRef, Mat, Par};

/// Why a dense matrix could not be factored.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DenseError {
    /// The pivot of this row is not positive.
    #[error("the matrix is not positive definite: pivot {row} is not positive")]
    NotPositiveDefinite {
        /// Row of the pivot, from 0.
        row: usize,
    },
    /// No pivot is left at this step of the elimination.
    #[error("the matrix is singular: no pivot at step {step}")]
    Singular {
        /// Step of the elimination, from 0.
        step: usize,
    },
    /// The eigenvalue iteration did not converge (the matrix has entries that are not finite).
    #[error("eigenvalues did not converge: the matrix has entries that are not finite")]
    NoEigenvalues,
}

/// y = Ax. Shapes: A (m, n), x (n,), y (m,).
pub fn matvec(a: &Mat<f64>, x: &[f64], y: &mut [f64]) {
    matmul(
        ColMut::from_slice_mut(y).as_mat_mut(),
        Accum::Replace,
        a.as_ref(),
        ColRef::from_slice(x).as_mat(),
        1.0,
        Par::Seq,
    );
}

/// Replaces the lower triangle of a symmetric positive definite A (n, n) by L with A = LLᵀ.
///
/// Errors: `NotPositiveDefinite` with the row of the first pivot that is not positive.
pub fn cholesky_in_place(a: &mut Mat<f64>) -> Result<(), DenseError> {
    let n = a.nrows();
    let scratch = factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    factor::cholesky_in_place(
        a.as_mut(),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map(|_| ())
    .map_err(
        |factor::LltError::NonPositivePivot { index }| DenseError::NotPositiveDefinite {
            row: index,
        },
    )
}

/// Replaces b by A⁻¹b, given `l` from [`cholesky_in_place`]. Shapes: l (n, n), b (n,).
pub fn solve_cholesky_in_place(l: &Mat<f64>, b: &mut [f64]) {
    let scratch = solve::solve_in_place_scratch::<f64>(l.nrows(), 1, Par::Seq);
    let mut memory = MemBuffer::new(scratch);
    solve::solve_in_place(
        l.as_ref(),
        ColMut::from_slice_mut(b).as_mat_mut(),
        Par::Seq,
        MemStack::new(&mut memory),
    );
}

/// Replaces b by A⁻¹b for a small general matrix: elimination with complete pivoting. Shapes: A (n, n), b (n,).
///
/// Errors: `Singular` where the largest pivot left is below 1e-13 of the first.
pub fn solve_general(a: &Mat<f64>, b: &mut [f64]) -> Result<(), DenseError> {
    let n = a.nrows();
    let mut a = a.clone();
    let mut columns: Vec<usize> = (0..n).collect();
    let mut first = 0.0;
    for step in 0..n {
        let (mut row, mut column, mut largest) = (step, step, 0.0);
        for j in step..n {
            for i in step..n {
                if a[(i, j)].abs() > largest {
                    (row, column, largest) = (i, j, a[(i, j)].abs());
                }
            }
        }
        if step == 0 {
            first = largest;
        }
        if largest.is_nan() || largest <= 1e-13 * first {
            return Err(DenseError::Singular { step });
        }
        b.swap(step, row);
        columns.swap(step, column);
        for j in 0..n {
            let swapped = a[(row, j)];
            a[(row, j)] = a[(step, j)];
            a[(step, j)] = swapped;
        }
        for i in 0..n {
            let swapped = a[(i, column)];
            a[(i, column)] = a[(i, step)];
            a[(i, step)] = swapped;
        }
        for i in step + 1..n {
            let factor = a[(i, step)] / a[(step, step)];
            for j in step..n {
                let above = a[(step, j)];
                a[(i, j)] -= factor * above;
            }
            b[i] -= factor * b[step];
        }
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| a[(i, j)] * b[j]).sum();
        b[i] = (b[i] - known) / a[(i, i)];
    }
    let ordered = b.to_vec();
    for (value, &column) in ordered.iter().zip(&columns) {
        b[column] = *value;
    }
    Ok(())
}

/// Eigenvalues in increasing order and orthonormal eigenvectors (columns) of a symmetric A (n, n).
///
/// Errors: `NoEigenvalues` when entries are not finite.
pub fn symmetric_eigen(a: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), DenseError> {
    let n = a.nrows();
    if n == 0 {
        return Ok((Vec::new(), Mat::zeros(0, 0)));
    }
    let mut values = Diag::<f64>::zeros(n);
    let mut vectors = Mat::<f64>::zeros(n, n);
    let scratch = evd::self_adjoint_evd_scratch::<f64>(
        n,
        evd::ComputeEigenvectors::Yes,
        Par::Seq,
        Default::default(),
    );
    let mut memory = MemBuffer::new(scratch);
    evd::self_adjoint_evd(
        a.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|_| DenseError::NoEigenvalues)?;
    let values = (0..n).map(|i| values[i]).collect();
    Ok((values, vectors))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Symmetric positive definite: second differences plus a rank-one term.
    fn stiffness(n: usize) -> Mat<f64> {
        Mat::from_fn(n, n, |i, j| {
            let band = match i.abs_diff(j) {
                0 => 2.0,
                1 => -1.0,
                _ => 0.0,
            };
            band + 0.01 * (i + 1) as f64 * (j + 1) as f64
        })
    }

    #[test]
    fn cholesky_and_elimination_undo_the_product() {
        let n = 37;
        let a = stiffness(n);
        let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).sin()).collect();
        let mut product = vec![0.0; n];
        matvec(&a, &x, &mut product);
        let mut by_cholesky = product.clone();
        let mut l = a.clone();
        cholesky_in_place(&mut l).unwrap();
        solve_cholesky_in_place(&l, &mut by_cholesky);
        let mut by_elimination = product;
        solve_general(&a, &mut by_elimination).unwrap();
        for i in 0..n {
            assert!((by_cholesky[i] - x[i]).abs() < 1e-11);
            assert!((by_elimination[i] - x[i]).abs() < 1e-11);
        }
    }

    #[test]
    fn indefinite_and_singular_matrices_are_errors() {
        let mut indefinite = stiffness(5);
        indefinite[(3, 3)] = -1.0;
        assert_eq!(
            cholesky_in_place(&mut indefinite),
            Err(DenseError::NotPositiveDefinite { row: 3 })
        );
        let rank_one = Mat::from_fn(3, 3, |i, j| ((i + 1) * (j + 1)) as f64);
        assert_eq!(
            solve_general(&rank_one, &mut [1.0, 0.0, 0.0]),
            Err(DenseError::Singular { step: 1 })
        );
    }

    #[test]
    fn eigenvectors_diagonalise() {
        let n = 9;
        let a = stiffness(n);
        let (values, vectors) = symmetric_eigen(&a).unwrap();
        let mut image = vec![0.0; n];
        for j in 0..n {
            matvec(&a, vectors.col_as_slice(j), &mut image);
            for i in 0..n {
                assert!((image[i] - values[j] * vectors[(i, j)]).abs() < 1e-12);
            }
        }
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1]));
    }
}
