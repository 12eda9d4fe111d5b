//! C D Cᵀ + shift · I of many sparse columns, factored repeatedly with different weights D, diagonal or in small blocks.
//!
//! Entry (i, j) is not zero where some column, or some block of columns, has both: in the balance of bodies, where these touch.
//! The pattern is ordered and analysed once.

use crate::linalg::{
    Cholesky, Graph, LinalgError, SparseVector, SymbolicCholesky, SymmetricMatrix,
    fill_reducing_order,
};
use std::ops::Range;

/// The analysed pattern of C D Cᵀ.
pub struct WeightedGram {
    /// The columns of each block of D.
    blocks: Vec<Range<usize>>,
    /// The pattern, with zeros.
    pattern: SymmetricMatrix,
    /// Places of the products of two entries among its values: for each entry of a column those with the entries up to it of
    /// every column of its block.
    places: Vec<u32>,
    analysis: SymbolicCholesky,
}

impl WeightedGram {
    /// Analyses the pattern of `columns`, each (rows,), for a diagonal D.
    ///
    /// Errors: [`LinalgError::TooLarge`].
    pub fn new(rows: usize, columns: &[SparseVector]) -> Result<Self, LinalgError> {
        Self::of_blocks(
            rows,
            columns,
            (0..columns.len()).map(|i| i..i + 1).collect(),
        )
    }

    /// The same for a D that couples the columns of each of `blocks`, which follow each other.
    ///
    /// Errors: [`LinalgError::TooLarge`].
    pub fn of_blocks(
        rows: usize,
        columns: &[SparseVector],
        blocks: Vec<Range<usize>>,
    ) -> Result<Self, LinalgError> {
        let edges = edges(rows, columns, &blocks);
        let graph = Graph::of_edges(rows, edges.iter().copied());
        let order = fill_reducing_order(&graph, &vec![true; rows], &[]);
        let zeros = edges.iter().map(|&[i, j]| (i as usize, j as usize, 0.0));
        let pattern = SymmetricMatrix::from_triplets(rows, &zeros.collect::<Vec<_>>());
        let mut places = Vec::new();
        products(columns, &blocks, |_, i, j, _| {
            places.extend(pattern.place(i, j).map(|place| place as u32));
        });
        Ok(Self {
            analysis: SymbolicCholesky::new(&pattern, &order, 0)?,
            blocks,
            pattern,
            places,
        })
    }

    /// Factors C D Cᵀ + shift · I with the entries `weight(a, b)` of D; `columns` are those that were analysed.
    ///
    /// Errors: [`LinalgError::NotPositiveDefinite`], [`LinalgError::NearlySingular`], [`LinalgError::NotFinite`].
    pub fn factor(
        &self,
        columns: &[SparseVector],
        weight: impl Fn(usize, usize) -> f64,
        shift: f64,
    ) -> Result<Cholesky, LinalgError> {
        let mut values = self.pattern.values().to_vec();
        for i in 0..self.pattern.len() {
            let diagonal = self.pattern.place(i, i).expect("the diagonal is stored");
            values[diagonal] = shift;
        }
        let mut places = self.places.iter();
        products(columns, &self.blocks, |(a, b), _, _, product| {
            if let Some(&place) = places.next() {
                values[place as usize] += weight(a, b) * product;
            }
        });
        self.analysis.factor(&self.pattern.with_values(values))
    }
}

/// Calls back with (a, b), i, j ≤ i and C_ia C_jb of all columns a, b of each block, always in the same order.
fn products(
    columns: &[SparseVector],
    blocks: &[Range<usize>],
    mut tell: impl FnMut((usize, usize), usize, usize, f64),
) {
    for block in blocks {
        for (a, b) in block
            .clone()
            .flat_map(|a| block.clone().map(move |b| (a, b)))
        {
            for (i, x) in columns[a].entries() {
                let until = columns[b].entries().take_while(|&(j, _)| j <= i);
                until.for_each(|(j, y)| tell((a, b), i, j, x * y));
            }
        }
    }
}

/// Pairs (i, j), j < i, of rows that some block has both, each once.
fn edges(rows: usize, columns: &[SparseVector], blocks: &[Range<usize>]) -> Vec<[u32; 2]> {
    let mut met: Vec<Vec<usize>> = vec![Vec::new(); rows];
    for (place, block) in blocks.iter().enumerate() {
        let entries = columns[block.clone()]
            .iter()
            .flat_map(SparseVector::entries);
        entries.for_each(|(i, _)| met[i].push(place));
    }
    let mut last = vec![usize::MAX; rows];
    let mut edges = Vec::new();
    for (i, met) in met.iter().enumerate() {
        for column in met
            .iter()
            .flat_map(|&place| &columns[blocks[place].clone()])
        {
            for (j, _) in column.entries().take_while(|&(j, _)| j < i) {
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
        let alone = WeightedGram::new(10, &columns).unwrap();
        let pairs = (0..3).map(|b| 3 * b..3 * b + 3).collect();
        let pairs = WeightedGram::of_blocks(10, &columns, pairs).unwrap();
        let diagonal = |a: usize, _: usize| 1.0 + a as f64;
        let coupled = |a: usize, b: usize| if a == b { 2.0 + a as f64 } else { 0.5 };
        check(&columns, &alone, diagonal, |a, b| a == b);
        check(&columns, &pairs, coupled, |a, b| a / 3 == b / 3);
    }

    fn check(
        columns: &[SparseVector],
        gram: &WeightedGram,
        weight: impl Fn(usize, usize) -> f64,
        coupled: impl Fn(usize, usize) -> bool,
    ) {
        let x: Vec<f64> = (0..10).map(|i| (i as f64).sin()).collect();
        let mut right: Vec<f64> = x.iter().map(|x| 0.3 * x).collect();
        for (a, own) in columns.iter().enumerate() {
            for (b, other) in columns.iter().enumerate().filter(|&(b, _)| coupled(a, b)) {
                own.add_to(weight(a, b) * other.dot(&x), &mut right);
            }
        }
        let factor = gram.factor(columns, weight, 0.3).unwrap();
        factor.solve(&mut right);
        for (found, x) in right.iter().zip(&x) {
            assert!((found - x).abs() < 1e-13);
        }
    }
}
