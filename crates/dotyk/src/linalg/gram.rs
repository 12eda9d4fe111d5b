//! C D Cᵀ + shift · I of many sparse columns, factored again and again for other weights D.
//!
//! Entry (i, j) is not zero where some column has both: for the balance of bodies that is where they touch. The pattern is
//! ordered and analysed once.

use crate::linalg::{
    Analysis, Cholesky, Connectivity, Graph, LinalgError, SparseVector, SymmetricMatrix,
    fill_reducing_order,
};

/// The analysed pattern of C D Cᵀ.
pub struct WeightedGram {
    rows: usize,
    analysis: Analysis,
}

impl WeightedGram {
    /// Analyses the pattern of `columns`, each (rows,).
    ///
    /// # Errors
    /// [`LinalgError::TooLarge`].
    pub fn new(rows: usize, columns: &[SparseVector]) -> Result<Self, LinalgError> {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for column in columns {
            for (i, _) in column.entries() {
                let before = column.entries().take_while(|&(j, _)| j < i);
                edges.extend(before.map(|(j, _)| [i as u32, j as u32]));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let nodes: Vec<u32> = edges.into_iter().flatten().collect();
        let pairs = Connectivity {
            nodes: &nodes,
            nodes_per_cell: 2,
        };
        let graph = Graph::from_cells(rows, &[pairs]);
        let order = fill_reducing_order(&graph, &vec![true; rows], &[]);
        let pattern = matrix(rows, columns, |_| 0.0, 0.0);
        Ok(Self {
            rows,
            analysis: Analysis::new(&pattern, &order, 0)?,
        })
    }

    /// Factors C diag(weights) Cᵀ + shift · I; `columns` are those that were analysed.
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`], [`LinalgError::NearlySingular`], [`LinalgError::NotFinite`].
    pub fn factor(
        &self,
        columns: &[SparseVector],
        weight: impl Fn(usize) -> f64,
        shift: f64,
    ) -> Result<Cholesky, LinalgError> {
        self.analysis
            .factor(&matrix(self.rows, columns, weight, shift))
    }
}

fn matrix(
    rows: usize,
    columns: &[SparseVector],
    weight: impl Fn(usize) -> f64,
    shift: f64,
) -> SymmetricMatrix {
    let mut triplets: Vec<(usize, usize, f64)> = (0..rows).map(|i| (i, i, shift)).collect();
    for (place, column) in columns.iter().enumerate() {
        let weight = weight(place);
        for (i, x) in column.entries() {
            let before = column.entries().take_while(|&(j, _)| j <= i);
            triplets.extend(before.map(|(j, y)| (i, j, weight * x * y)));
        }
    }
    SymmetricMatrix::from_triplets(rows, &triplets)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighted_gram_solves_what_its_columns_say() {
        let columns: Vec<SparseVector> = (0..9)
            .map(|j| SparseVector::new(10, [(j, 1.0), (j + 1, -0.5)]))
            .collect();
        let gram = WeightedGram::new(10, &columns).unwrap();
        let weight = |j: usize| 1.0 + j as f64;
        let x: Vec<f64> = (0..10).map(|i| (i as f64).sin()).collect();
        let mut right: Vec<f64> = x.iter().map(|x| 0.3 * x).collect();
        for (j, column) in columns.iter().enumerate() {
            column.add_to(weight(j) * column.dot(&x), &mut right);
        }
        gram.factor(&columns, weight, 0.3)
            .unwrap()
            .solve(&mut right);
        for (found, x) in right.iter().zip(&x) {
            assert!((found - x).abs() < 1e-13);
        }
    }
}
