//! G, the work of contact forces on rigid modes: sparse, because a contact does work on the modes of two bodies only.

use crate::linalg::{Mat, SparseVector};
use std::ops::Index;

/// G (r, m), by its columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    rows: usize,
    columns: Vec<SparseVector>,
}

impl Modes {
    /// The modes with these columns, each (r,).
    ///
    /// # Panics
    /// When a column has another length.
    pub fn new(rows: usize, columns: Vec<SparseVector>) -> Self {
        assert!(columns.iter().all(|column| column.len() == rows));
        Self { rows, columns }
    }

    /// The modes with these rows, each (m,).
    pub fn of_rows(rows: &[SparseVector], columns: usize) -> Self {
        Self::new(rows.len(), transposed(rows, columns))
    }

    /// Number r of modes.
    pub fn nrows(&self) -> usize {
        self.rows
    }

    /// Number m of contact forces.
    pub fn ncols(&self) -> usize {
        self.columns.len()
    }

    /// Work of a unit force `i` on the modes, (r,).
    pub fn column(&self, i: usize) -> &SparseVector {
        &self.columns[i]
    }

    /// All columns, m vectors (r,).
    pub fn columns(&self) -> &[SparseVector] {
        &self.columns
    }

    /// r vectors (m,).
    pub fn rows(&self) -> Vec<SparseVector> {
        transposed(&self.columns, self.rows)
    }

    /// Gλ, (r,). Shape: λ (m,).
    pub fn product(&self, lambda: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.rows];
        for (column, force) in self.columns.iter().zip(lambda) {
            column.add_to(*force, &mut sum);
        }
        sum
    }

    /// (Gᵀα)ᵢ, the motion of contact `i` along its force. Shape: α (r,).
    pub fn motion(&self, i: usize, alpha: &[f64]) -> f64 {
        self.columns[i].dot(alpha)
    }

    /// Largest |G|.
    pub fn largest(&self) -> f64 {
        let entries = self.columns.iter().flat_map(SparseVector::entries);
        entries.fold(0.0, |s, (_, g)| s.max(g.abs()))
    }

    /// All entries.
    pub fn to_dense(&self) -> Mat<f64> {
        let mut dense = Mat::zeros(self.rows, self.ncols());
        for (j, column) in self.columns.iter().enumerate() {
            column.add_to(1.0, dense.col_as_slice_mut(j));
        }
        dense
    }
}

impl From<Mat<f64>> for Modes {
    fn from(dense: Mat<f64>) -> Self {
        let columns = (0..dense.ncols()).map(|j| SparseVector::from_dense(dense.col_as_slice(j)));
        Self::new(dense.nrows(), columns.collect())
    }
}

impl Index<(usize, usize)> for Modes {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.columns[j][i]
    }
}

/// The columns of the matrix that has these rows, `columns` in number.
pub(super) fn transposed(rows: &[SparseVector], columns: usize) -> Vec<SparseVector> {
    let mut entries: Vec<Vec<(usize, f64)>> = vec![Vec::new(); columns];
    for (i, row) in rows.iter().enumerate() {
        row.entries()
            .for_each(|(j, value)| entries[j].push((i, value)));
    }
    let columns = entries.into_iter();
    columns.map(|e| SparseVector::new(rows.len(), e)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_the_same_by_columns_by_rows_and_with_their_zeros() {
        let dense = Mat::from_fn(2, 3, |i, j| [[0.5, 0.0, -3.0], [0.0, 0.25, 2.0]][i][j]);
        let modes = Modes::from(dense.clone());
        assert_eq!((modes.nrows(), modes.ncols()), (2, 3));
        assert_eq!(modes.to_dense(), dense);
        assert_eq!(Modes::of_rows(&modes.rows(), 3), modes);
        assert_eq!(Modes::new(2, modes.columns().to_vec()), modes);
        for j in 0..3 {
            assert_eq!(modes.column(j).to_dense(), dense.col_as_slice(j));
            for i in 0..2 {
                assert_eq!(
                    (modes[(i, j)], modes.rows()[i][j]),
                    (dense[(i, j)], dense[(i, j)])
                );
            }
        }
        assert_eq!(modes.product(&[2.0, 4.0, 1.0]), [-2.0, 3.0]);
        let motion = [0, 1, 2].map(|j| modes.motion(j, &[2.0, 4.0]));
        assert_eq!(motion, [1.0, 1.0, 2.0]);
    }

    #[test]
    fn largest_entry_is_that_of_its_size() {
        let of = |g: f64| Modes::from(Mat::from_fn(1, 2, |_, j| [0.5 * g, g][j])).largest();
        assert_eq!((of(-3.0), of(3.0), of(-1e-3)), (3.0, 3.0, 1e-3));
        assert_eq!(Modes::of_rows(&[], 4).largest(), 0.0);
    }
}
