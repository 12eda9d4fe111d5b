//! Sparse Cholesky factorisation PAPᵀ = LLᵀ of a symmetric positive definite matrix, with a trailing block.
//!
//! The elimination order lists the dofs that take part, those of a long contact last. With A split into inner (i) and
//! trailing (c) dofs, the trailing block L_cc of the factor is the Cholesky factor of the Schur complement
//!
//! ```text
//!   S = A_cc − A_ci A_ii⁻¹ A_ic = L_cc L_ccᵀ
//! ```
//!
//! so that a body is condensed to its contact by the one factorisation that also solves with it. A floating body is
//! grounded first: dofs that hold it are left out of the order.
//!
//! Vectors are over all dofs of the matrix. Dofs that are not listed (prescribed, grounded) are ignored on entry and
//! zero on return. Memory: 8 bytes per stored entry of L, 12 per entry of A for the analysis, 8 more while factoring,
//! and what [`SymbolicCholesky::beside`] tells.
//!
//! Factors of few operations are left to the library, on one thread; larger ones are formed by all threads (`fronts.rs`). Several
//! right-hand sides are shared among threads in blocks of a fixed size. The bits do not depend on the number of threads.
//!
//! Source: J. W. H. Liu, E. G. Ng, B. W. Peyton, On finding supernodes for sparse matrix computations,
//! SIAM J. Matrix Anal. Appl. 14 (1993) 242–252.

use crate::linalg::fronts::{self, Tree};
use crate::linalg::sparse::accumulate;
use crate::linalg::{LinalgError, SymmetricMatrix};
use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::simplicial;
use faer::sparse::linalg::cholesky::supernodal::{
    self, SupernodalLltRef, SymbolicSupernodalCholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par};
use rayon::prelude::*;
use std::sync::Arc;

pub(super) const NO_COLUMN: u32 = u32::MAX;

/// Right-hand sides solved together by one task: enough to reuse each entry of L, few enough for the cache.
const COLUMNS_PER_TASK: usize = 16;

/// Operations from which on a factor is formed by all threads: 20 ms of one. Below, on one thread, the library takes up to a
/// third less time for bodies in space.
const WORTH_SHARING: f64 = 1e9;

/// Pivots below this part of their diagonal entry are checked by their energy, for the price of half a solution.
const SUSPICIOUS_PIVOT: f64 = 1e-4;

/// Smallest relative energy uᵀAu / Σ aᵢᵢuᵢ² that counts as not zero. Mechanisms are below 1e-16 (the half unit of rounding)
/// at every size tried, up to 161 200 dofs; a sound beam, one cell thick and 5000 long, is at 2.5e-15.
const SMALLEST_ENERGY: f64 = 1e-15;

/// Symbolic part of a factorisation: elimination order, pattern of L, places of the entries of A.
#[derive(Debug)]
pub struct SymbolicCholesky {
    structure: Arc<Structure>,
    lower: Pattern,
    /// Place in the values of A of each entry of `lower`.
    source: Vec<u32>,
    stored: usize,
    operations: f64,
    /// Of a factor that all threads form.
    tree: Option<Box<Tree>>,
}

/// Dofs and supernodes, shared by the analysis and its factors.
#[derive(Debug)]
struct Structure {
    dofs: usize,
    order: Vec<u32>,
    trailing: usize,
    symbolic: SymbolicSupernodalCholesky<u32>,
}

/// Columns of a sparse pattern.
#[derive(Debug)]
struct Pattern {
    col_start: Vec<u32>,
    row_index: Vec<u32>,
}

impl Pattern {
    fn columns(&self) -> usize {
        self.col_start.len() - 1
    }

    fn column(&self, j: usize) -> std::ops::Range<usize> {
        self.col_start[j] as usize..self.col_start[j + 1] as usize
    }

    fn view(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.columns();
        SymbolicSparseColMatRef::new_unsorted_checked(n, n, &self.col_start, None, &self.row_index)
    }
}

impl SymbolicCholesky {
    /// Analyses the pattern of a matrix; `order` lists the dofs to keep in elimination order, the last `trailing` of
    /// them form the trailing block.
    ///
    /// Errors: [`LinalgError::InvalidOrder`] when a dof is listed twice or does not exist, [`LinalgError::WrongPattern`] when
    /// the trailing block is longer than the order, [`LinalgError::TooLarge`] when L has more than 2³¹ entries.
    pub fn new(
        matrix: &SymmetricMatrix,
        order: &[usize],
        trailing: usize,
    ) -> Result<Self, LinalgError> {
        if trailing > order.len() {
            let (expected, found) = (order.len(), trailing);
            return Err(LinalgError::WrongPattern { expected, found });
        }
        let too_large = LinalgError::TooLarge {
            unknowns: order.len(),
        };
        if matrix.stored() > i32::MAX as usize || matrix.len() > i32::MAX as usize {
            return Err(too_large);
        }
        let position = positions(matrix.len(), order)?;
        let (upper, upper_source) = permuted_upper(matrix, &position, order.len());
        let (symbolic, (lower, source)) =
            rayon::join(|| supernodes(&upper), || transposed(&upper, &upper_source));
        let symbolic = symbolic.ok_or(too_large)?;
        let operations = fronts::operations(&symbolic);
        let tree = (operations > WORTH_SHARING).then(|| Box::new(Tree::of(&symbolic)));
        let structure = Structure {
            dofs: matrix.len(),
            order: order.iter().map(|&dof| dof as u32).collect(),
            trailing,
            symbolic,
        };
        Ok(Self {
            structure: Arc::new(structure),
            lower,
            source,
            stored: matrix.stored(),
            operations,
            tree,
        })
    }

    /// Number of entries of L that will be stored, some of them zeros within supernodes.
    pub fn stored(&self) -> usize {
        self.structure.symbolic.len_val()
    }

    /// Numbers that are kept beside L while one thread forms it.
    pub fn beside(&self) -> usize {
        self.tree.as_ref().map_or(0, |tree| tree.most_left())
    }

    /// Operations of the factorisation.
    pub fn operations(&self) -> f64 {
        self.operations
    }

    /// Factors a matrix of the analysed pattern.
    ///
    /// Errors: [`LinalgError::NotPositiveDefinite`], [`LinalgError::NearlySingular`], [`LinalgError::NotFinite`], or
    /// [`LinalgError::WrongPattern`] for another matrix than the analysed one.
    pub fn factor(&self, matrix: &SymmetricMatrix) -> Result<Cholesky, LinalgError> {
        if matrix.stored() != self.stored || matrix.len() != self.structure.dofs {
            let (expected, found) = (self.stored, matrix.stored());
            return Err(LinalgError::WrongPattern { expected, found });
        }
        let values = self.permuted_values(matrix)?;
        let structure = &self.structure;
        let symbolic = &structure.symbolic;
        let lower = SparseColMatRef::new(self.lower.view(), &values[..]);
        let factor = match &self.tree {
            Some(tree) => fronts::factor(symbolic, tree, lower),
            None => factor_alone(symbolic, lower),
        };
        let factor = factor.map_err(|column| {
            let dof = structure.order[column] as usize;
            LinalgError::NotPositiveDefinite { dof }
        })?;
        let cholesky = Cholesky {
            structure: Arc::clone(structure),
            values: factor,
        };
        // The diagonal entry is the first of its column.
        let diagonal = |j: usize| values[self.lower.col_start[j] as usize];
        cholesky.check_definite(diagonal)?;
        Ok(cholesky)
    }

    fn permuted_values(&self, matrix: &SymmetricMatrix) -> Result<Vec<f64>, LinalgError> {
        let all = matrix.values();
        let values: Vec<f64> = self.source.iter().map(|&k| all[k as usize]).collect();
        if let Some(entry) = values.iter().position(|value| !value.is_finite()) {
            let row = self.lower.row_index[entry] as usize;
            let row = self.structure.order[row] as usize;
            return Err(LinalgError::NotFinite { row });
        }
        Ok(values)
    }
}

/// The factor by one thread.
///
/// Errors: the first column whose pivot is not positive.
fn factor_alone(
    symbolic: &SymbolicSupernodalCholesky<u32>,
    lower: SparseColMatRef<'_, u32, f64>,
) -> Result<Vec<f64>, usize> {
    let need = supernodal::factorize_supernodal_numeric_llt_scratch::<u32, f64>(
        symbolic,
        Par::Seq,
        Default::default(),
    );
    let mut factor = vec![0.0; symbolic.len_val()];
    supernodal::factorize_supernodal_numeric_llt(
        &mut factor,
        lower,
        Default::default(),
        symbolic,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(need)),
        Default::default(),
    )
    .map_err(|LltError::NonPositivePivot { index }| index)?;
    Ok(factor)
}

/// Place of each dof in the order, [`NONE`] where it is not listed.
fn positions(dofs: usize, order: &[usize]) -> Result<Vec<u32>, LinalgError> {
    let mut position = vec![NO_COLUMN; dofs];
    for (k, &dof) in order.iter().enumerate() {
        match position.get_mut(dof) {
            Some(place) if *place == NO_COLUMN => *place = k as u32,
            _ => return Err(LinalgError::InvalidOrder { dof }),
        }
    }
    Ok(position)
}

/// Upper triangle of the permuted matrix by columns, rows unsorted, and the place of each entry in the matrix.
fn permuted_upper(matrix: &SymmetricMatrix, position: &[u32], n: usize) -> (Pattern, Vec<u32>) {
    let mut col_start = vec![0u32; n + 1];
    for (j, &q) in position.iter().enumerate() {
        if q != NO_COLUMN {
            for &i in matrix.rows_of(j) {
                let p = position[i as usize];
                if p != NO_COLUMN {
                    col_start[p.max(q) as usize + 1] += 1;
                }
            }
        }
    }
    accumulate(&mut col_start);
    let mut next = col_start.clone();
    let mut row_index = vec![0u32; col_start[n] as usize];
    let mut source = vec![0u32; col_start[n] as usize];
    let mut entry = 0u32;
    for (j, &q) in position.iter().enumerate() {
        let rows = matrix.rows_of(j);
        if q != NO_COLUMN {
            for (k, &i) in rows.iter().enumerate() {
                let p = position[i as usize];
                if p != NO_COLUMN {
                    let place = &mut next[p.max(q) as usize];
                    row_index[*place as usize] = p.min(q);
                    source[*place as usize] = entry + k as u32;
                    *place += 1;
                }
            }
        }
        entry += rows.len() as u32;
    }
    let pattern = Pattern {
        col_start,
        row_index,
    };
    (pattern, source)
}

/// The transposed pattern, rows ascending, with the sources of its entries.
fn transposed(pattern: &Pattern, source: &[u32]) -> (Pattern, Vec<u32>) {
    let n = pattern.columns();
    let mut col_start = vec![0u32; n + 1];
    for &i in &pattern.row_index {
        col_start[i as usize + 1] += 1;
    }
    accumulate(&mut col_start);
    let mut next = col_start.clone();
    let mut row_index = vec![0u32; source.len()];
    let mut moved = vec![0u32; source.len()];
    for j in 0..n {
        for k in pattern.column(j) {
            let place = &mut next[pattern.row_index[k] as usize];
            row_index[*place as usize] = j as u32;
            moved[*place as usize] = source[k];
            *place += 1;
        }
    }
    let pattern = Pattern {
        col_start,
        row_index,
    };
    (pattern, moved)
}

/// Supernodes of the factor; `None` if its entries cannot be counted.
fn supernodes(upper: &Pattern) -> Option<SymbolicSupernodalCholesky<u32>> {
    let n = upper.columns();
    let (mut tree, mut counts) = (vec![0i32; n], vec![0u32; n]);
    let entries = upper.row_index.len();
    let mut memory = MemBuffer::new(
        simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, entries)
            .or(supernodal::factorize_supernodal_symbolic_cholesky_scratch::<u32>(n)),
    );
    let tree = simplicial::prefactorize_symbolic_cholesky(
        &mut tree,
        &mut counts,
        upper.view(),
        MemStack::new(&mut memory),
    );
    supernodal::factorize_supernodal_symbolic_cholesky(
        upper.view(),
        tree,
        &counts,
        MemStack::new(&mut memory),
        SymbolicSupernodalParams::default(),
    )
    .ok()
}

/// A factor PAPᵀ = LLᵀ.
#[derive(Debug, Clone)]
pub struct Cholesky {
    structure: Arc<Structure>,
    values: Vec<f64>,
}

impl Cholesky {
    /// Analyses and factors; see [`SymbolicCholesky::new`] and [`SymbolicCholesky::factor`].
    ///
    /// Errors: Those of the two steps.
    pub fn factor(
        matrix: &SymmetricMatrix,
        order: &[usize],
        trailing: usize,
    ) -> Result<Self, LinalgError> {
        SymbolicCholesky::new(matrix, order, trailing)?.factor(matrix)
    }

    /// Number of dofs that take part.
    pub fn kept(&self) -> usize {
        self.structure.order.len()
    }

    /// Number of dofs of the trailing block.
    pub fn trailing(&self) -> usize {
        self.structure.trailing
    }

    /// Number of stored entries of L, some of them zeros within supernodes.
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    /// Bytes that the factor occupies.
    pub fn bytes(&self) -> usize {
        let symbolic = &self.structure.symbolic;
        // Each supernode has its begin, two column pointers, a count, a row pointer and its rows twice.
        let indices = 5 * symbolic.n_supernodes() + 2 * symbolic.row_idx().len() + self.kept();
        8 * self.values.len() + 4 * indices
    }

    /// u = A⁻¹f in place, over all dofs.
    ///
    /// Panics when the length is not that of the matrix.
    pub fn solve(&self, rhs: &mut [f64]) {
        let mut kept = self.gather(rhs);
        self.solve_kept(MatMut::from_column_major_slice_mut(
            &mut kept,
            self.kept(),
            1,
        ));
        self.scatter(&kept, rhs);
    }

    /// U = A⁻¹F in place, each column over all dofs; columns are shared among threads.
    ///
    /// Panics when the number of rows is not that of the matrix.
    pub fn solve_many(&self, rhs: &mut Mat<f64>) {
        assert_eq!(rhs.nrows(), self.structure.dofs);
        let tasks = rhs.par_col_chunks_mut(COLUMNS_PER_TASK);
        tasks.for_each(|mut block| {
            let order = &self.structure.order;
            let mut kept = Mat::from_fn(order.len(), block.ncols(), |k, j| {
                block[(order[k] as usize, j)]
            });
            self.solve_kept(kept.as_mut());
            block.fill(0.0);
            for j in 0..block.ncols() {
                for (k, &dof) in order.iter().enumerate() {
                    block[(dof as usize, j)] = kept[(k, j)];
                }
            }
        });
    }

    /// y = L⁻¹Pf, (kept,): the first half of a solution. Its last entries belong to the trailing block.
    ///
    /// Panics when the length is not that of the matrix.
    pub fn forward(&self, rhs: &[f64]) -> Vec<f64> {
        let mut y = self.gather(rhs);
        let x = MatMut::from_column_major_slice_mut(&mut y, self.kept(), 1);
        let mut memory = self.scratch(1);
        let stack = MemStack::new(&mut memory);
        self.view().l_solve_with_conj(Conj::No, x, Par::Seq, stack);
        y
    }

    /// u = PᵀL⁻ᵀy over all dofs: the second half of a solution. With the trailing entries of y replaced by L_ccᵀu_c it
    /// continues given trailing displacements u_c to the inner dofs.
    ///
    /// Panics when y is not of length [`kept`](Self::kept).
    pub fn backward(&self, mut y: Vec<f64>) -> Vec<f64> {
        let x = MatMut::from_column_major_slice_mut(&mut y, self.kept(), 1);
        let mut memory = self.scratch(1);
        let stack = MemStack::new(&mut memory);
        self.view()
            .l_transpose_solve_with_conj(Conj::No, x, Par::Seq, stack);
        self.spread(&y)
    }

    /// L_cc, (trailing, trailing) lower triangular: the Cholesky factor of the Schur complement on the trailing dofs.
    pub fn trailing_factor(&self) -> Mat<f64> {
        let first = self.kept() - self.structure.trailing;
        let symbolic = &self.structure.symbolic;
        let mut block = Mat::zeros(self.structure.trailing, self.structure.trailing);
        let ends = symbolic.supernode_end();
        let straddling = ends.partition_point(|&end| end as usize <= first);
        for s in straddling..symbolic.n_supernodes() {
            let supernode = self.view().supernode(s);
            let (start, entries) = (supernode.start(), supernode.val());
            for j in first.saturating_sub(start)..entries.ncols() {
                let column = start + j - first;
                for i in j..entries.ncols() {
                    block[(start + i - first, column)] = entries[(i, j)];
                }
                for (i, &row) in supernode.pattern().iter().enumerate() {
                    block[(row as usize - first, column)] = entries[(entries.ncols() + i, j)];
                }
            }
        }
        block
    }

    /// The supernodes.
    pub(super) fn symbolic(&self) -> &SymbolicSupernodalCholesky<u32> {
        &self.structure.symbolic
    }

    /// Place of each dof in the order, [`NO_COLUMN`] where it is not listed.
    pub(super) fn places(&self) -> Vec<u32> {
        let mut place = vec![NO_COLUMN; self.structure.dofs];
        for (k, &dof) in self.structure.order.iter().enumerate() {
            place[dof as usize] = k as u32;
        }
        place
    }

    pub(super) fn view(&self) -> SupernodalLltRef<'_, u32, f64> {
        SupernodalLltRef::new(&self.structure.symbolic, &self.values)
    }

    fn scratch(&self, columns: usize) -> MemBuffer {
        let symbolic = &self.structure.symbolic;
        MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq))
    }

    fn solve_kept(&self, x: MatMut<'_, f64>) {
        let mut memory = self.scratch(x.ncols());
        let stack = MemStack::new(&mut memory);
        self.view()
            .solve_in_place_with_conj(Conj::No, x, Par::Seq, stack);
    }

    /// Those in the order, of values over all dofs.
    pub(super) fn gather(&self, full: &[f64]) -> Vec<f64> {
        assert_eq!(full.len(), self.structure.dofs);
        let order = self.structure.order.iter();
        order.map(|&dof| full[dof as usize]).collect()
    }

    /// Over all dofs, from those in the order.
    pub(super) fn spread(&self, kept: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.structure.dofs];
        self.scatter(kept, &mut full);
        full
    }

    fn scatter(&self, kept: &[f64], full: &mut [f64]) {
        full.fill(0.0);
        for (&dof, &value) in self.structure.order.iter().zip(kept) {
            full[dof as usize] = value;
        }
    }

    /// Finds displacements without energy.
    ///
    /// A small pivot alone proves nothing: a long lever magnifies the rounding of a mechanism (to 1e-10 of the diagonal at
    /// 40 times the depth) and lowers the pivots of a sound beam alike. With u = L⁻ᵀeⱼ for the smallest relative pivot j,
    /// uᵀAu = 1, and the comparison with Σ aᵢᵢuᵢ² depends neither on levers nor on units.
    fn check_definite(&self, diagonal: impl Fn(usize) -> f64) -> Result<(), LinalgError> {
        let (mut smallest, mut place) = (f64::INFINITY, 0);
        for s in 0..self.structure.symbolic.n_supernodes() {
            let supernode = self.view().supernode(s);
            let entries = supernode.val();
            for i in 0..entries.ncols() {
                let j = supernode.start() + i;
                let ratio = entries[(i, i)] * entries[(i, i)] / diagonal(j);
                if !ratio.is_finite() {
                    let row = self.structure.order[j] as usize;
                    return Err(LinalgError::NotFinite { row });
                }
                if ratio < smallest {
                    (smallest, place) = (ratio, j);
                }
            }
        }
        if smallest > SUSPICIOUS_PIVOT {
            return Ok(());
        }
        let mut unit = vec![0.0; self.kept()];
        unit[place] = 1.0;
        let u = self.backward(unit);
        let order = self.structure.order.iter().enumerate();
        let scale: f64 = order
            .map(|(j, &dof)| diagonal(j) * u[dof as usize].powi(2))
            .sum();
        let ratio = 1.0 / scale;
        if ratio < SMALLEST_ENERGY {
            let dof = self.structure.order[place] as usize;
            return Err(LinalgError::NearlySingular { dof, ratio });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dense::cholesky_in_place;
    use crate::linalg::{Lu, expand_to_dofs, fill_reducing_order, grid, product};

    /// The listed rows and columns of a matrix.
    fn dense(matrix: &SymmetricMatrix, dofs: &[usize]) -> Mat<f64> {
        Mat::from_fn(dofs.len(), dofs.len(), |i, j| matrix.get(dofs[i], dofs[j]))
    }

    /// A⁻¹f on the listed dofs by dense elimination, zero elsewhere.
    fn dense_solution(matrix: &SymmetricMatrix, dofs: &[usize], rhs: &[f64]) -> Vec<f64> {
        let mut b = Mat::from_fn(dofs.len(), 1, |i, _| rhs[dofs[i]]);
        Lu::new(dense(matrix, dofs)).unwrap().solve_in_place(&mut b);
        let mut u = vec![0.0; rhs.len()];
        for (i, &dof) in dofs.iter().enumerate() {
            u[dof] = b[(i, 0)];
        }
        u
    }

    fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
    }

    /// Clamped grid with the nodes of its right edge last: matrix, order of the dofs, size of the trailing block.
    fn clamped(nx: usize, ny: usize) -> (SymmetricMatrix, Vec<usize>, usize) {
        let (graph, matrix) = grid::body(nx, ny);
        let keep = grid::clamped_left(nx, ny);
        let nodes: Vec<bool> = keep.chunks(2).map(|c| c[0] || c[1]).collect();
        let last: Vec<usize> = (0..=ny).map(|j| j * (nx + 1) + nx).collect();
        let order = fill_reducing_order(&graph, &nodes, &last);
        (matrix, expand_to_dofs(&order, 2, &keep), 2 * (ny + 1))
    }

    #[test]
    fn solutions_agree_with_dense_elimination() {
        let (matrix, order, trailing) = clamped(9, 6);
        let rhs = grid::noise(matrix.len());
        let factor = Cholesky::factor(&matrix, &order, trailing).unwrap();
        let mut u = rhs.clone();
        factor.solve(&mut u);
        // The condition number is near 1e4 and displacements near 1e2.
        assert!(largest_difference(&u, &dense_solution(&matrix, &order, &rhs)) < 1e-10);
    }

    #[test]
    fn the_order_of_elimination_does_not_change_the_solution() {
        let (matrix, order, _) = clamped(14, 11);
        let rhs = grid::noise(matrix.len());
        let mut ascending = order.clone();
        ascending.sort_unstable();
        let descending: Vec<usize> = ascending.iter().rev().copied().collect();
        let solutions: Vec<Vec<f64>> = [order, ascending, descending]
            .iter()
            .map(|order| {
                let mut u = rhs.clone();
                Cholesky::factor(&matrix, order, 0).unwrap().solve(&mut u);
                u
            })
            .collect();
        assert!(largest_difference(&solutions[0], &solutions[1]) < 1e-10);
        assert!(largest_difference(&solutions[0], &solutions[2]) < 1e-10);
    }

    /// S = A_cc − A_ci A_ii⁻¹ A_ic of the last `trailing` dofs by dense elimination.
    fn schur_complement(matrix: &SymmetricMatrix, order: &[usize], trailing: usize) -> Mat<f64> {
        let (inner, last) = order.split_at(order.len() - trailing);
        let coupling = Mat::from_fn(inner.len(), trailing, |i, j| matrix.get(inner[i], last[j]));
        let mut x = coupling.clone();
        Lu::new(dense(matrix, inner))
            .unwrap()
            .solve_in_place(&mut x);
        let through_inner = product(&coupling.transpose().to_owned(), &x);
        let block = dense(matrix, last);
        Mat::from_fn(trailing, trailing, |i, j| {
            block[(i, j)] - through_inner[(i, j)]
        })
    }

    #[test]
    fn large_factors_have_the_same_bits_on_any_number_of_threads() {
        // chains that all end in one large supernode
        let (chains, end) = (400, 1500);
        let wave = |i: usize, j: usize| ((i * 31 + j * 17) as f64).sin();
        let mut triplets = Vec::new();
        for i in 0..chains + end {
            triplets.push((i, i, 1000.0));
            let far = if i < chains {
                chains + end - 200
            } else {
                chains + end
            };
            let own = if i < chains { i + 1..i + 2 } else { i + 1..far };
            triplets.extend(own.map(|j| (j, i, wave(i, j))));
            if i < chains {
                triplets.extend((far..chains + end).map(|j| (j, i, wave(i, j))));
            }
        }
        let n = chains + end;
        let matrix = SymmetricMatrix::from_triplets(n, &triplets);
        let order: Vec<usize> = (0..n).collect();
        let analysis = SymbolicCholesky::new(&matrix, &order, 0).unwrap();
        assert!(analysis.operations() > WORTH_SHARING);
        let values = |workers: usize| {
            let factor = grid::on_threads(workers, || analysis.factor(&matrix));
            factor.unwrap().values
        };
        let one = values(1);
        for workers in [2, 3, 8] {
            assert!(values(workers) == one, "{workers}");
        }
        // the same, formed column by column
        let entries = analysis.permuted_values(&matrix).unwrap();
        let lower = SparseColMatRef::new(analysis.lower.view(), &entries[..]);
        let library = factor_alone(&analysis.structure.symbolic, lower).unwrap();
        let factor = |values: &[f64]| Cholesky {
            structure: Arc::clone(&analysis.structure),
            values: values.to_vec(),
        };
        let noise = grid::noise(n);
        let [mut found, mut expected] = [noise.clone(), noise];
        factor(&one).solve(&mut found);
        factor(&library).solve(&mut expected);
        assert!(largest_difference(&found, &expected) < 1e-12);
    }

    #[test]
    fn pivots_that_are_not_positive_are_named_alike_on_any_number_of_threads() {
        let (matrix, order, _) = clamped(70, 60);
        // dofs in subtrees of their own, far apart in the order
        let bad = [order[order.len() / 5], order[3 * order.len() / 5]];
        let mut triplets = Vec::new();
        for j in 0..matrix.len() {
            for (&i, &value) in matrix.rows_of(j).iter().zip(matrix.values_of(j)) {
                let sign = if i as usize == j && bad.contains(&j) {
                    -1.0
                } else {
                    1.0
                };
                triplets.push((i as usize, j, sign * value));
            }
        }
        let matrix = SymmetricMatrix::from_triplets(matrix.len(), &triplets);
        let analysis = SymbolicCholesky::new(&matrix, &order, 0).unwrap();
        let entries = analysis.permuted_values(&matrix).unwrap();
        let symbolic = &analysis.structure.symbolic;
        let tree = Tree::of(symbolic);
        let failed = |workers: usize| {
            let lower = SparseColMatRef::new(analysis.lower.view(), &entries[..]);
            let column = grid::on_threads(workers, || fronts::factor(symbolic, &tree, lower));
            analysis.structure.order[column.unwrap_err()] as usize
        };
        let mut order = analysis.structure.order.iter().map(|&dof| dof as usize);
        let first = order.find(|dof| bad.contains(dof)).unwrap();
        for workers in [1, 2, 8] {
            assert_eq!(failed(workers), first);
        }
    }

    #[test]
    fn fronts_form_the_factor_of_the_library() {
        // several roots: two bodies, and lone dofs of which nothing else knows
        let (matrix, order, _) = clamped(40, 31);
        let n = matrix.len();
        let mut twice = vec![(2 * n, 2 * n, 3.0)];
        for j in 0..n {
            for (&i, &value) in matrix.rows_of(j).iter().zip(matrix.values_of(j)) {
                let i = i as usize;
                twice.extend([(i, j, value), (n + i, n + j, 2.0 * value)]);
            }
        }
        let twice = SymmetricMatrix::from_triplets(2 * n + 1, &twice);
        let mut both = order.clone();
        both.push(2 * n);
        both.extend(order.iter().map(|dof| n + dof));
        let (small, few, _) = clamped(3, 2);
        for (matrix, order) in [(&matrix, &order), (&twice, &both), (&small, &few)] {
            let analysis = SymbolicCholesky::new(matrix, order, 0).unwrap();
            let entries = analysis.permuted_values(matrix).unwrap();
            let lower = || SparseColMatRef::new(analysis.lower.view(), &entries[..]);
            let symbolic = &analysis.structure.symbolic;
            let factors = [
                fronts::factor(symbolic, &Tree::of(symbolic), lower()).unwrap(),
                factor_alone(symbolic, lower()).unwrap(),
            ];
            let [found, expected] = factors.map(|values| {
                let structure = Arc::clone(&analysis.structure);
                let mut u = grid::noise(matrix.len());
                Cholesky { structure, values }.solve(&mut u);
                u
            });
            let scale = expected.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            assert!(largest_difference(&found, &expected) < 1e-10 * scale);
        }
    }

    #[test]
    fn the_trailing_factor_is_that_of_the_schur_complement() {
        let (matrix, order, edge) = clamped(8, 7);
        // Blocks that begin within a supernode, a single dof, the whole matrix, and an empty block.
        for trailing in [edge, edge - 1, edge + 5, 1, order.len(), 0] {
            let factor = Cholesky::factor(&matrix, &order, trailing).unwrap();
            let found = factor.trailing_factor();
            let mut expected = schur_complement(&matrix, &order, trailing);
            cholesky_in_place(&mut expected).unwrap();
            assert_eq!((found.nrows(), found.ncols()), (trailing, trailing));
            for j in 0..trailing {
                let (found, expected) = (found.col_as_slice(j), expected.col_as_slice(j));
                assert!(largest_difference(found, expected) < 1e-12, "{trailing}");
            }
        }
    }

    #[test]
    fn the_trailing_factor_of_uncoupled_parts_is_complete() {
        // A path 0-3-1 and the lone dofs 2 and 4: the trailing block falls into three supernodes or more.
        let triplets = [
            (0, 0, 4.0),
            (1, 1, 5.0),
            (2, 2, 9.0),
            (3, 3, 6.0),
            (4, 4, 16.0),
            (3, 0, 1.0),
            (3, 1, 2.0),
        ];
        let matrix = SymmetricMatrix::from_triplets(5, &triplets);
        let factor = Cholesky::factor(&matrix, &[3, 0, 4, 1, 2], 4).unwrap();
        let l = factor.trailing_factor();
        let mut expected = schur_complement(&matrix, &[3, 0, 4, 1, 2], 4);
        cholesky_in_place(&mut expected).unwrap();
        for j in 0..4 {
            assert!(largest_difference(l.col_as_slice(j), expected.col_as_slice(j)) < 1e-14);
        }
        assert_eq!(l[(1, 1)], 4.0);
    }

    #[test]
    fn a_floating_body_is_refused_until_its_rigid_motions_are_grounded() {
        let (nx, ny) = (6, 5);
        let (graph, matrix) = grid::body(nx, ny);
        let order = fill_reducing_order(&graph, &vec![true; graph.nodes()], &[]);
        let mut keep = vec![true; matrix.len()];
        let order_of = |keep: &[bool]| expand_to_dofs(&order, 2, keep);
        assert!(Cholesky::factor(&matrix, &order_of(&keep), 0).is_err());
        // Both translations at the first corner, and the rotation at the next one.
        for dof in [0, 1, 2 * nx + 1] {
            keep[dof] = false;
        }
        let factor = Cholesky::factor(&matrix, &order_of(&keep), 0).unwrap();
        // Opposite pulls at two corners are balanced: the grounded dofs need no force.
        let mut force = vec![0.0; matrix.len()];
        let far = matrix.len() - 2;
        let across = [(far - 2 * nx, -1.0), (far, 1.0)];
        across.iter().for_each(|&(dof, value)| force[dof] = value);
        let (mut u, mut found) = (force.clone(), vec![0.0; matrix.len()]);
        factor.solve(&mut u);
        matrix.mul(&u, &mut found);
        assert!(largest_difference(&found, &force) < 1e-12);
    }

    #[test]
    fn two_half_solutions_make_a_whole_one() {
        let (matrix, order, trailing) = clamped(10, 5);
        let factor = Cholesky::factor(&matrix, &order, trailing).unwrap();
        let rhs = grid::noise(matrix.len());
        let mut whole = rhs.clone();
        factor.solve(&mut whole);
        assert_eq!(factor.backward(factor.forward(&rhs)), whole);
    }

    #[test]
    fn given_trailing_displacements_are_continued_to_the_inner_dofs() {
        let (matrix, order, trailing) = clamped(10, 5);
        let factor = Cholesky::factor(&matrix, &order, trailing).unwrap();
        let mut y = vec![0.0; order.len()];
        let first = order.len() - trailing;
        let given = grid::noise(trailing);
        let l = factor.trailing_factor();
        for (j, y) in y[first..].iter_mut().enumerate() {
            *y = (j..trailing).map(|i| l[(i, j)] * given[i]).sum();
        }
        let u = factor.backward(y);
        let mut force = vec![0.0; matrix.len()];
        matrix.mul(&u, &mut force);
        for (&dof, given) in order[first..].iter().zip(&given) {
            assert!((u[dof] - given).abs() < 1e-12);
        }
        assert!(order[..first].iter().all(|&dof| force[dof].abs() < 1e-12));
    }

    #[test]
    fn many_right_hand_sides_have_the_same_bits_on_any_number_of_threads() {
        let (matrix, order, trailing) = clamped(40, 31);
        let columns = 2 * COLUMNS_PER_TASK + 5;
        let noise = grid::noise(matrix.len() * columns);
        let rhs = Mat::from_fn(matrix.len(), columns, |i, j| noise[j * matrix.len() + i]);
        let run = || {
            let factor = Cholesky::factor(&matrix, &order, trailing).unwrap();
            let mut u = rhs.clone();
            factor.solve_many(&mut u);
            (factor.values, u)
        };
        let (one, two) = (grid::on_threads(1, run), grid::on_threads(2, run));
        assert!(one == two);
        let factor = Cholesky::factor(&matrix, &order, trailing).unwrap();
        for j in [0, columns - 1] {
            let mut u = rhs.col_as_slice(j).to_vec();
            factor.solve(&mut u);
            assert!(largest_difference(&u, one.1.col_as_slice(j)) < 1e-9);
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused_at_its_dof() {
        let (nx, ny) = (6, 6);
        let (matrix, order, trailing) = clamped(nx, ny);
        let mut triplets = Vec::new();
        for j in 0..matrix.len() {
            let rows = matrix.rows_of(j).iter().zip(matrix.values_of(j));
            triplets.extend(rows.map(|(&i, &value)| (i as usize, j, value)));
        }
        let dof = order[17];
        let mut negative = triplets.clone();
        negative.push((dof, dof, -100.0));
        let negative = SymmetricMatrix::from_triplets(matrix.len(), &negative);
        let refused = Cholesky::factor(&negative, &order, trailing).unwrap_err();
        assert_eq!(refused, LinalgError::NotPositiveDefinite { dof });
        triplets.push((dof, dof, f64::NAN));
        let undefined = SymmetricMatrix::from_triplets(matrix.len(), &triplets);
        let refused = Cholesky::factor(&undefined, &order, trailing).unwrap_err();
        assert_eq!(refused, LinalgError::NotFinite { row: dof });
    }

    #[test]
    fn a_matrix_without_free_dofs_has_an_empty_factor() {
        let (_, matrix) = grid::body(2, 2);
        let factor = Cholesky::factor(&matrix, &[], 0).unwrap();
        let mut u = vec![1.0; matrix.len()];
        factor.solve(&mut u);
        assert!(u.iter().all(|&u| u == 0.0));
        assert_eq!(factor.trailing_factor().nrows(), 0);
        assert_eq!(factor.backward(factor.forward(&u)), u);
        assert_eq!(factor.stored(), 0);
        let mut many = Mat::from_fn(matrix.len(), 3, |_, _| 1.0);
        factor.solve_many(&mut many);
        assert!(many == Mat::<f64>::zeros(matrix.len(), 3));
    }

    #[test]
    fn an_order_that_repeats_or_invents_a_dof_is_refused() {
        let (_, matrix) = grid::body(1, 1);
        let repeated = Cholesky::factor(&matrix, &[2, 3, 2], 0).unwrap_err();
        assert_eq!(repeated, LinalgError::InvalidOrder { dof: 2 });
        let invented = Cholesky::factor(&matrix, &[2, 8], 0).unwrap_err();
        assert_eq!(invented, LinalgError::InvalidOrder { dof: 8 });
    }

    /// Two grids of nx × ny that share one corner node: the second can turn about it.
    fn hinged(nx: usize, ny: usize) -> (SymmetricMatrix, Vec<usize>) {
        use crate::linalg::{CellMatrices, Graph, assemble_blocks};
        let own = (nx + 1) * (ny + 1);
        let first = grid::cells(nx, ny);
        let second = first.iter().map(|&node| own as u32 - 1 + node);
        let nodes: Vec<u32> = first.iter().copied().chain(second).collect();
        let values = grid::stiffness(nx, ny).repeat(2);
        let block = CellMatrices {
            nodes: &nodes,
            nodes_per_cell: 3,
            values: &values,
        };
        let graph = Graph::from_cells(2 * own - 1, &[block.connectivity()]);
        let matrix = assemble_blocks::<2>(&graph, &[block]).unwrap();
        let mut keep = grid::clamped_left(nx, ny);
        keep.resize(matrix.len(), true);
        let nodes: Vec<bool> = keep.chunks(2).map(|c| c[0] || c[1]).collect();
        let order = fill_reducing_order(&graph, &nodes, &[]);
        (matrix, expand_to_dofs(&order, 2, &keep))
    }

    #[test]
    fn a_mechanism_is_found_whatever_its_size() {
        for (nx, ny) in [(1, 1), (3, 2), (20, 7), (200, 5), (90, 80)] {
            let (matrix, order) = hinged(nx, ny);
            let refused = Cholesky::factor(&matrix, &order, 0).unwrap_err();
            assert!(
                matches!(
                    refused,
                    LinalgError::NearlySingular { .. } | LinalgError::NotPositiveDefinite { .. }
                ),
                "{refused}"
            );
        }
    }

    #[test]
    fn a_slender_beam_is_not_taken_for_a_mechanism() {
        let (matrix, order, _) = clamped(5000, 1);
        assert!(Cholesky::factor(&matrix, &order, 0).is_ok());
    }

    #[test]
    fn units_do_not_make_a_mechanism() {
        // One spring chain whose far half is 1e9 times softer, in units 1e-20 times smaller.
        let triplets: Vec<_> = (0..10)
            .flat_map(|i| {
                let k = if i < 5 { 1e-20 } else { 1e-29 };
                [(i, i, k), (i + 1, i + 1, k), (i + 1, i, -k)]
            })
            .collect();
        let matrix = SymmetricMatrix::from_triplets(11, &triplets);
        let order: Vec<usize> = (1..11).rev().collect();
        assert!(Cholesky::factor(&matrix, &order, 0).is_ok());
    }
}
