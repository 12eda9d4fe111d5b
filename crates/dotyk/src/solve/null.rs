//! The balance on some unknowns alone: its null space, and what of least norm restores it.

use crate::linalg::Mat;
use crate::linalg::dense::{gram, symmetric_eigen};
use crate::solve::dot;

/// Eigenvalues of a small balance matrix below this part of the largest count as zero.
const RANK: f64 = 1e-12;

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

/// Null space of the balance on some unknowns.
pub(crate) struct Null {
    gram: Pseudo,
    parts: Vec<f64>,
    right: Vec<f64>,
}

impl Null {
    pub fn new(rows: &[Vec<f64>]) -> Self {
        let columns = Mat::from_fn(rows.first().map_or(0, Vec::len), rows.len(), |a, j| {
            rows[j][a]
        });
        Self {
            gram: Pseudo::new(&gram(&columns)),
            parts: vec![0.0; rows.len()],
            right: vec![0.0; rows.len()],
        }
    }

    /// v ← the nearest vector whose rows vanish.
    pub fn project(&mut self, rows: &[Vec<f64>], v: &mut [f64]) {
        for (part, row) in self.parts.iter_mut().zip(rows) {
            *part = dot(row, v);
        }
        self.subtract(rows, v);
    }

    /// v ← the nearest vector whose rows are `target` (k,).
    pub fn restore(&mut self, rows: &[Vec<f64>], target: &[f64], v: &mut [f64]) {
        for ((part, row), target) in self.parts.iter_mut().zip(rows).zip(target) {
            *part = dot(row, v) - target;
        }
        self.subtract(rows, v);
    }

    fn subtract(&mut self, rows: &[Vec<f64>], v: &mut [f64]) {
        self.gram.solve(&mut self.parts, &mut self.right);
        for (part, row) in self.parts.iter().zip(rows) {
            v.iter_mut().zip(row).for_each(|(v, r)| *v -= part * r);
        }
    }

    /// α̂ of least norm whose pull on the unknowns is nearest to minus what is `open` of their conditions.
    pub fn amplitudes(&mut self, rows: &[Vec<f64>], open: &[f64]) -> Vec<f64> {
        for (part, row) in self.parts.iter_mut().zip(rows) {
            *part = -dot(row, open);
        }
        self.gram.solve(&mut self.parts, &mut self.right);
        self.parts.clone()
    }
}
