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
    /// The pattern, with zeros.
    pattern: SymmetricMatrix,
    /// Where the products of two entries of a column belong among its values: for each entry those with the entries up to it,
    /// column by column.
    places: Vec<u32>,
    analysis: Analysis,
}

impl WeightedGram {
    /// Analyses the pattern of `columns`, each (rows,).
    ///
    /// # Errors
    /// [`LinalgError::TooLarge`].
    pub fn new(rows: usize, columns: &[SparseVector]) -> Result<Self, LinalgError> {
        let edges = edges(rows, columns);
        let nodes: Vec<u32> = edges.iter().flatten().copied().collect();
        let pairs = Connectivity {
            nodes: &nodes,
            nodes_per_cell: 2,
        };
        let graph = Graph::from_cells(rows, &[pairs]);
        let order = fill_reducing_order(&graph, &vec![true; rows], &[]);
        let zeros = edges.iter().map(|&[i, j]| (i as usize, j as usize, 0.0));
        let pattern = SymmetricMatrix::from_triplets(rows, &zeros.collect::<Vec<_>>());
        let mut places = Vec::new();
        for column in columns {
            for (i, _) in column.entries() {
                let until = column.entries().take_while(|&(j, _)| j <= i);
                places.extend(
                    until
                        .filter_map(|(j, _)| pattern.place(i, j))
                        .map(|p| p as u32),
                );
            }
        }
        Ok(Self {
            analysis: Analysis::new(&pattern, &order, 0)?,
            pattern,
            places,
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
        let mut values = self.pattern.values().to_vec();
        for i in 0..self.pattern.len() {
            let diagonal = self.pattern.place(i, i).expect("the diagonal is stored");
            values[diagonal] = shift;
        }
        let mut places = self.places.iter();
        for (index, column) in columns.iter().enumerate() {
            let weight = weight(index);
            for (i, x) in column.entries() {
                let until = column.entries().take_while(|&(j, _)| j <= i);
                for ((_, y), &place) in until.zip(places.by_ref()) {
                    values[place as usize] += weight * x * y;
                }
            }
        }
        self.analysis.factor(&self.pattern.with_values(values))
    }
}

/// Pairs (i, j), j < i, of rows that some column has both, each once.
fn edges(rows: usize, columns: &[SparseVector]) -> Vec<[u32; 2]> {
    let mut met: Vec<Vec<usize>> = vec![Vec::new(); rows];
    for (place, column) in columns.iter().enumerate() {
        column.entries().for_each(|(i, _)| met[i].push(place));
    }
    let mut last = vec![usize::MAX; rows];
    let mut edges = Vec::new();
    for (i, met) in met.iter().enumerate() {
        for &place in met {
            for (j, _) in columns[place].entries().take_while(|&(j, _)| j < i) {
                if last[j] != i {
                    last[j] = i;
                    edges.push([i as u32, j as u32]);
                }
            }
        }
    }
    edges
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
