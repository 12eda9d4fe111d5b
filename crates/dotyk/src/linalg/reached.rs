//! BA⁻¹Bᵀ for rows B with few entries, from the part of a factor that they reach.
//!
//! With Y = L⁻¹PBᵀ this is YᵀY. A row of B has entries of Y only in the supernodes of its dofs and in their ancestors in the elimination
//! tree. With L_J the triangle of a supernode J, L_R the rows below it, and Y_J that begins as its part of PBᵀ,
//!
//! ```text
//!   Y_J ← L_J⁻¹ Y_J,      Y_R ← Y_R − L_R Y_J,      YᵀY ← YᵀY + Y_JᵀY_J
//! ```
//!
//! takes |R(J)|n(n + 2m) + |R(J)|²n operations for n columns, m rows below and R(J) rows of B that reach it. Contacts are short beside the
//! ground around them: few supernodes are reached, only those near the root by all rows, and the order of elimination may forget the
//! contact.
//!
//! Rows are sorted by their places in the order and taken in blocks of a fixed size, side by side on the threads there are: the bits do
//! not depend on the number of these.
//!
//! A solution for f − Bᵀλ with a λ that depends on what f does to the rows is one in halves: of y = L⁻¹Pf, which is whole, Bu needs L⁻ᵀy
//! in the reached places alone, and L⁻¹PBᵀλ changes y there alone.
//!
//! Source: P. R. Amestoy, I. S. Duff, J.-Y. L'Excellent, Y. Robert, F.-H. Rouet, B. Uçar, On computing inverse entries of a sparse matrix
//! in an out-of-core environment, SIAM J. Sci. Comput. 34 (2012) A1975–A1999, for right-hand sides that reach a part of the tree.

use crate::linalg::cholesky::{Cholesky, NO_COLUMN};
use crate::linalg::dense::mirror_lower;
use crate::linalg::{Mat, SparseVector};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::ops::Range;

/// Rows of B that are solved for together.
const ROWS: usize = 64;

/// Entries of a row of B: places in the order, ascending, and values.
type Row = Vec<(u32, f64)>;

/// The supernodes above others, and that of each place in the order.
struct Tree {
    parent: Vec<Option<usize>>,
    of_place: Vec<u32>,
}

/// A supernode that rows of a block reach, those in `rows`; its part of Yᵀ begins at a column.
struct Part {
    supernode: usize,
    rows: Range<usize>,
    columns: Range<usize>,
}

/// Yᵀ of a block of rows, (rows, places that they reach).
struct Block {
    parts: Vec<Part>,
    y: Mat<f64>,
}

/// The part of a factor that some dofs reach: their supernodes and the ancestors of these.
pub(crate) struct Reached {
    /// Children before parents.
    supernodes: Vec<usize>,
}

impl Cholesky {
    /// The part that some dofs reach; those that are not listed in the order reach nothing.
    pub(crate) fn reached(&self, dofs: impl Iterator<Item = usize>) -> Reached {
        let (place, tree) = (self.places(), Tree::of(self.symbolic()));
        let mut reached = vec![false; tree.parent.len()];
        for place in dofs.map(|dof| place[dof]).filter(|&p| p != NO_COLUMN) {
            reached[tree.of_place[place as usize] as usize] = true;
        }
        for (supernode, &parent) in tree.parent.iter().enumerate() {
            if let (true, Some(parent)) = (reached[supernode], parent) {
                reached[parent] = true;
            }
        }
        let supernodes = (0..reached.len()).filter(|&supernode| reached[supernode]);
        Reached {
            supernodes: supernodes.collect(),
        }
    }

    /// u = PᵀL⁻ᵀy over all dofs, in the reached places; zero elsewhere.
    pub(crate) fn backward_reached(&self, y: &[f64], reached: &Reached) -> Vec<f64> {
        let (mut x, mut beyond) = (vec![0.0; y.len()], Vec::new());
        for &supernode in reached.supernodes.iter().rev() {
            let supernode = self.view().supernode(supernode);
            let columns = supernode.val().ncols();
            let own = supernode.start()..supernode.start() + columns;
            let (triangle, rest) = supernode.val().split_at_row(columns);
            beyond.clear();
            beyond.extend(supernode.pattern().iter().map(|&row| x[row as usize]));
            x[own.clone()].copy_from_slice(&y[own.clone()]);
            let mut own = MatMut::from_column_major_slice_mut(&mut x[own], columns, 1);
            let beyond = MatRef::from_column_major_slice(&beyond, rest.nrows(), 1);
            let rest = rest.transpose();
            matmul(own.as_mut(), Accum::Add, rest, beyond, -1.0, Par::Seq);
            solve_upper_triangular_in_place(triangle.transpose(), own, Par::Seq);
        }
        self.spread(&x)
    }

    /// y ← y + L⁻¹Pf, of an f over all dofs whose entries reach no more.
    pub(crate) fn forward_reached(&self, f: &[f64], reached: &Reached, y: &mut [f64]) {
        let (mut z, mut below) = (self.gather(f), Vec::new());
        for &supernode in &reached.supernodes {
            let supernode = self.view().supernode(supernode);
            let columns = supernode.val().ncols();
            let own = supernode.start()..supernode.start() + columns;
            let (triangle, rest) = supernode.val().split_at_row(columns);
            let mut part = MatMut::from_column_major_slice_mut(&mut z[own.clone()], columns, 1);
            solve_lower_triangular_in_place(triangle, part.as_mut(), Par::Seq);
            below.clear();
            below.resize(rest.nrows(), 0.0);
            let change = MatMut::from_column_major_slice_mut(&mut below, rest.nrows(), 1);
            matmul(change, Accum::Replace, rest, part.as_ref(), 1.0, Par::Seq);
            for (&row, change) in supernode.pattern().iter().zip(&below) {
                z[row as usize] -= change;
            }
            y[own.clone()]
                .iter_mut()
                .zip(&z[own])
                .for_each(|(y, z)| *y += z);
        }
    }

    /// BA⁻¹Bᵀ, (rows, rows), of rows over all dofs; dofs that are not listed in the order do not move.
    pub(crate) fn compliance(&self, rows: &[SparseVector]) -> Mat<f64> {
        let place = self.places();
        let of_row = |entries: &SparseVector| {
            let listed = entries
                .entries()
                .filter(|(dof, _)| place[*dof] != NO_COLUMN);
            let mut row: Row = listed.map(|(dof, value)| (place[dof], value)).collect();
            row.sort_unstable_by_key(|entry| entry.0);
            row
        };
        let of_rows: Vec<Row> = rows.iter().map(of_row).collect();
        let mut sorted: Vec<usize> = (0..rows.len()).collect();
        sorted.sort_by_key(|&row| of_rows[row].first().map(|entry| entry.0));
        let tree = Tree::of(self.symbolic());
        let blocks = sorted.par_chunks(ROWS);
        let blocks = blocks.map(|of_block| {
            let rows: Vec<&Row> = of_block.iter().map(|&row| &of_rows[row]).collect();
            self.forward_block(&tree, &rows)
        });
        let products = products(&blocks.collect::<Vec<Block>>(), rows.len());
        let mut place = vec![0; rows.len()];
        sorted
            .iter()
            .enumerate()
            .for_each(|(k, &row)| place[row] = k);
        Mat::from_fn(rows.len(), rows.len(), |i, j| {
            products[(place[i], place[j])]
        })
    }

    /// Yᵀ of at most [`ROWS`] rows.
    fn forward_block(&self, tree: &Tree, rows: &[&Row]) -> Block {
        let symbolic = self.symbolic();
        let begin = symbolic.supernode_begin();
        let parts = tree.parts(symbolic, rows);
        let mut start = vec![0; symbolic.n_supernodes()];
        parts
            .iter()
            .for_each(|part| start[part.supernode] = part.columns.start);
        let column = |place: u32| {
            let supernode = tree.of_place[place as usize] as usize;
            start[supernode] + (place - begin[supernode]) as usize
        };
        let columns = parts.last().map_or(0, |part| part.columns.end);
        let mut y = Mat::zeros(rows.len(), columns);
        for (i, row) in rows.iter().enumerate() {
            for &(place, value) in *row {
                y[(i, column(place))] += value;
            }
        }
        let below = |part: &Part| symbolic.supernode(part.supernode).pattern().len();
        let mut product = Mat::zeros(rows.len(), parts.iter().map(below).max().unwrap_or(0));
        for part in &parts {
            let supernode = self.view().supernode(part.supernode);
            let (own, count) = (part.columns.clone(), part.rows.len());
            let (triangle, rest) = supernode.val().split_at_row(own.len());
            let mut of_part =
                y.as_mut()
                    .submatrix_mut(part.rows.start, own.start, count, own.len());
            solve_lower_triangular_in_place(triangle, of_part.as_mut().transpose_mut(), Par::Seq);
            let mut change = product.as_mut().submatrix_mut(0, 0, count, rest.nrows());
            let (own, rest) = (of_part.as_ref(), rest.transpose());
            matmul(change.as_mut(), Accum::Replace, own, rest, 1.0, Par::Seq);
            for (i, &place) in supernode.pattern().iter().enumerate() {
                let to = &mut y.col_as_slice_mut(column(place))[part.rows.clone()];
                let changes = &product.col_as_slice(i)[..count];
                to.iter_mut()
                    .zip(changes)
                    .for_each(|(y, change)| *y -= change);
            }
        }
        Block { parts, y }
    }
}

impl Block {
    /// Y_Jᵀ of the rows that reach a part.
    fn of_part(&self, part: &Part) -> MatRef<'_, f64> {
        let columns = self
            .y
            .as_ref()
            .subcols(part.columns.start, part.columns.len());
        columns.subrows(part.rows.start, part.rows.len())
    }
}

impl Tree {
    fn of(symbolic: &SymbolicSupernodalCholesky<u32>) -> Self {
        let supernodes = 0..symbolic.n_supernodes();
        let [begin, end] = [symbolic.supernode_begin(), symbolic.supernode_end()];
        let places = supernodes
            .clone()
            .flat_map(|s| (begin[s]..end[s]).map(move |_| s as u32));
        let of_place: Vec<u32> = places.collect();
        let parent = supernodes.map(|s| {
            let first = symbolic.supernode(s).pattern().first();
            first.map(|&row| of_place[row as usize] as usize)
        });
        Self {
            parent: parent.collect(),
            of_place,
        }
    }

    /// The supernodes that some rows reach, children before parents.
    fn parts(&self, symbolic: &SymbolicSupernodalCholesky<u32>, rows: &[&Row]) -> Vec<Part> {
        let mut reaching = vec![0..0; self.parent.len()];
        let widen = |all: &mut Range<usize>, more: &Range<usize>| {
            *all = match Range::is_empty(all) {
                true => more.clone(),
                false => all.start.min(more.start)..all.end.max(more.end),
            };
        };
        for (i, row) in rows.iter().enumerate() {
            for &(place, _) in *row {
                widen(
                    &mut reaching[self.of_place[place as usize] as usize],
                    &(i..i + 1),
                );
            }
        }
        let (mut parts, mut columns) = (Vec::new(), 0);
        for (supernode, &parent) in self.parent.iter().enumerate() {
            let rows = reaching[supernode].clone();
            if rows.is_empty() {
                continue;
            }
            if let Some(parent) = parent {
                widen(&mut reaching[parent], &rows);
            }
            let start = columns;
            columns += (symbolic.supernode_end()[supernode] - symbolic.supernode_begin()[supernode])
                as usize;
            parts.push(Part {
                supernode,
                rows,
                columns: start..columns,
            });
        }
        parts
    }
}

/// YᵀY of blocks that have so many rows together.
fn products(blocks: &[Block], rows: usize) -> Mat<f64> {
    let mut all = Mat::zeros(rows, rows);
    let columns = all.par_col_chunks_mut(ROWS).zip(blocks).enumerate();
    columns.for_each(|(place, (mut all, of_columns))| {
        for (i, of_rows) in blocks.iter().enumerate().skip(place) {
            for (a, b) in common(&of_rows.parts, &of_columns.parts) {
                let [first, column] = [ROWS * i + a.rows.start, b.rows.start];
                let to = all
                    .as_mut()
                    .submatrix_mut(first, column, a.rows.len(), b.rows.len());
                let own = of_columns.of_part(b);
                matmul(
                    to,
                    Accum::Add,
                    of_rows.of_part(a),
                    own.transpose(),
                    1.0,
                    Par::Seq,
                );
            }
        }
    });
    mirror_lower(&mut all);
    all
}

/// Parts of the same supernodes, both in ascending order.
fn common<'p>(a: &'p [Part], b: &'p [Part]) -> impl Iterator<Item = (&'p Part, &'p Part)> {
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    std::iter::from_fn(move || {
        loop {
            match a.peek()?.supernode.cmp(&b.peek()?.supernode) {
                Ordering::Less => drop(a.next()),
                Ordering::Greater => drop(b.next()),
                Ordering::Equal => return a.next().zip(b.next()),
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{expand_to_dofs, fill_reducing_order, grid};

    /// A grid held on its left, and rows of one to six entries in places without order, some of them at held dofs.
    fn problem() -> (Cholesky, Vec<SparseVector>) {
        let (nx, ny) = (23, 17);
        let (graph, matrix) = grid::body(nx, ny);
        let keep = grid::clamped_left(nx, ny);
        let nodes: Vec<bool> = keep.chunks(2).map(|c| c[0] || c[1]).collect();
        let order = fill_reducing_order(&graph, &nodes, &[]);
        let order = expand_to_dofs(&order, 2, &keep);
        let factor = Cholesky::factor(&matrix, &order, 0).unwrap();
        let noise = grid::noise(matrix.len());
        let row = |i: usize| {
            let entry = |k: usize| {
                (
                    (i * 31 + k * 127) % noise.len(),
                    noise[(i + k) % noise.len()],
                )
            };
            SparseVector::sum(noise.len(), (0..1 + i % 6).map(entry).collect())
        };
        (factor, (0..150).map(row).collect())
    }

    #[test]
    fn products_are_those_of_whole_solutions() {
        let (factor, rows) = problem();
        let f = factor.compliance(&rows);
        let largest = (0..rows.len()).fold(0.0f64, |m, i| m.max(f[(i, i)]));
        for (j, row) in rows.iter().enumerate() {
            let mut u = row.to_dense();
            factor.solve(&mut u);
            for (i, other) in rows.iter().enumerate() {
                let product: f64 = other.entries().map(|(dof, value)| value * u[dof]).sum();
                assert!((f[(i, j)] - product).abs() < 1e-13 * largest, "{i} {j}");
            }
        }
    }

    #[test]
    fn a_solution_in_halves_is_a_whole_one() {
        let (factor, rows) = problem();
        let rows = &rows[..9];
        let dofs = || {
            rows.iter()
                .flat_map(|row| row.entries().map(|entry| entry.0))
        };
        let reached = factor.reached(dofs());
        assert!(!reached.supernodes.is_empty());
        assert!(reached.supernodes.len() < factor.symbolic().n_supernodes());
        let load = grid::noise(rows[0].to_dense().len());
        let mut whole = load.clone();
        factor.solve(&mut whole);
        let mut y = factor.forward(&load);
        let base = factor.backward_reached(&y, &reached);
        let largest = whole.iter().fold(0.0f64, |m, u| m.max(u.abs()));
        assert!(dofs().all(|dof| (base[dof] - whole[dof]).abs() < 1e-13 * largest));
        let mut forces = vec![0.0; load.len()];
        for (i, row) in rows.iter().enumerate() {
            row.entries()
                .for_each(|(dof, value)| forces[dof] -= (1.0 + i as f64) * value);
        }
        factor.forward_reached(&forces, &reached, &mut y);
        let u = factor.backward(y);
        let mut both: Vec<f64> = load.iter().zip(&forces).map(|(f, g)| f + g).collect();
        factor.solve(&mut both);
        let largest = both.iter().fold(0.0f64, |m, u| m.max(u.abs()));
        assert!(
            u.iter()
                .zip(&both)
                .all(|(a, b)| (a - b).abs() < 1e-13 * largest)
        );
    }

    #[test]
    fn products_have_the_same_bits_on_any_number_of_threads() {
        let (factor, rows) = problem();
        let of = |threads: usize| grid::on_threads(threads, || factor.compliance(&rows));
        let one = of(1);
        assert!([2, 3, 8].into_iter().all(|threads| of(threads) == one));
        assert!((0..rows.len()).all(|i| (0..i).all(|j| one[(i, j)] == one[(j, i)])));
    }
}
