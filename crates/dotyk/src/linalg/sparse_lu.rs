//! LU with row pivoting of a general sparse matrix.

use crate::linalg::{LinalgError, SparseMatrix};
use dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, MatMut, Par};

/// PAQ = LU with columns ordered for little fill.
pub struct SparseLu {
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    size: usize,
}

impl SparseLu {
    /// Factors a (n, n).
    ///
    /// Errors: [`LinalgError::NotFinite`]; [`LinalgError::Singular`] where its pattern leaves a column without pivot. Rounding hides
    /// other singular matrices: check the residual of a solution.
    pub fn new(a: &SparseMatrix) -> Result<Self, LinalgError> {
        let n = a.rows();
        let mut entries = Vec::with_capacity(a.nonzeros());
        for row in 0..n {
            for (column, value) in a.row(row) {
                if !value.is_finite() {
                    return Err(LinalgError::NotFinite { row });
                }
                entries.push(Triplet::new(row, column, value));
            }
        }
        let too_large = LinalgError::TooLarge { unknowns: n };
        let columns = SparseColMat::try_new_from_triplets(n, n, &entries);
        let columns = columns.map_err(|_| too_large)?;
        let symbolic = factorize_symbolic_lu(columns.symbolic(), Default::default());
        let symbolic = symbolic.map_err(|_| too_large)?;
        let mut numeric = NumericLu::new();
        let scratch = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        symbolic
            .factorize_numeric_lu(
                &mut numeric,
                columns.as_ref(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|error| match error {
                LuError::SymbolicSingular { index } => LinalgError::Singular { column: index },
                LuError::Generic(_) => too_large,
            })?;
        Ok(Self {
            symbolic,
            numeric,
            size: n,
        })
    }

    /// x ← A⁻¹x. Shape: (n,).
    pub fn solve(&self, x: &mut [f64]) {
        let scratch = self.symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        let factors = LuRef::new_unchecked(&self.symbolic, &self.numeric);
        let right = MatMut::from_column_major_slice_mut(x, self.size, 1);
        factors.solve_in_place_with_conj(Conj::No, right, Par::Seq, MemStack::new(&mut memory));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unsymmetric_matrix_with_empty_diagonal_is_solved() {
        // a ring: each row has its two neighbours, and a border of ones with a zero corner
        let n = 41;
        let mut entries = Vec::new();
        for i in 0..n - 1 {
            entries.push((i, (i + 1) % (n - 1), 2.0 + (i as f64).sin()));
            entries.push((i, (i + 5) % (n - 1), -0.7));
            entries.extend([(i, n - 1, 1.0), (n - 1, i, -1.0)]);
        }
        let a = SparseMatrix::from_triplets(n, n, &entries);
        let known: Vec<f64> = (0..n).map(|i| (0.3 * i as f64).cos()).collect();
        let mut x = vec![0.0; n];
        a.mul(&known, &mut x);
        SparseLu::new(&a).unwrap().solve(&mut x);
        for (found, known) in x.iter().zip(&known) {
            assert!((found - known).abs() < 1e-13);
        }
    }

    #[test]
    fn a_matrix_with_an_empty_column_is_singular() {
        let a = SparseMatrix::from_triplets(3, 3, &[(0, 0, 1.0), (1, 0, 2.0), (2, 1, 1.0)]);
        assert!(SparseLu::new(&a).is_err_and(|e| matches!(e, LinalgError::Singular { .. })));
    }
}
