//! Sparse matrices and the graph of a mesh, and their assembly from cells.
//!
//! Problem: A = Σ Aₑ over cells, where a cell couples its nodes and each node carries D dofs (dof = D·node + component).
//! Each node gathers its D columns from its incident cells in the order of the cells, into its own slice of the
//! values: no colours, no atomics, the same bits for any number of threads.
//!
//! Invariants: row indices of a column and neighbours of a node ascend; the diagonal of a [`SymmetricMatrix`] is
//! always stored, first in its column. Memory: 12 bytes per stored entry (value and `u32` index).

use crate::linalg::dense::norm;
use crate::linalg::{LinalgError, Mat};
use rayon::prelude::*;
use std::array;
use std::collections::BTreeMap;
use std::ops::AddAssign;

/// Nodes per task: enough work to hide the cost of a task, enough tasks to share.
const NODES_PER_TASK: usize = 1024;

/// A vector of which few entries are not zero; 12 bytes for each that is not.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SparseVector {
    length: usize,
    index: Vec<u32>,
    values: Vec<f64>,
}

impl SparseVector {
    /// A vector of `length` entries from those that are not zero, indices ascending.
    ///
    /// Panics when indices do not ascend or are out of range.
    pub fn new(length: usize, entries: impl IntoIterator<Item = (usize, f64)>) -> Self {
        let mut vector = Self {
            length,
            ..Self::default()
        };
        for (i, value) in entries.into_iter().filter(|entry| entry.1 != 0.0) {
            let last = vector.index.last();
            assert!(i < length && last.is_none_or(|&last| (last as usize) < i));
            vector.index.push(i as u32);
            vector.values.push(value);
        }
        vector
    }

    /// A vector of `length` entries from parts in any order, which add up where they have the same index.
    ///
    /// Panics when an index is out of range.
    pub fn sum(length: usize, mut parts: Vec<(usize, f64)>) -> Self {
        parts.sort_by_key(|part| part.0);
        let mut entries: Vec<(usize, f64)> = Vec::with_capacity(parts.len());
        for (i, value) in parts {
            match entries.last_mut() {
                Some(last) if last.0 == i => last.1 += value,
                _ => entries.push((i, value)),
            }
        }
        Self::new(length, entries)
    }

    /// The entries of a dense vector that are not zero.
    pub fn from_dense(v: &[f64]) -> Self {
        Self::new(v.len(), v.iter().copied().enumerate())
    }

    /// Number of entries, zeros included.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Whether it has no entries.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// All entries.
    pub fn to_dense(&self) -> Vec<f64> {
        let mut v = vec![0.0; self.length];
        self.add_to(1.0, &mut v);
        v
    }

    /// (index, value) of the entries that are not zero, ascending.
    pub fn entries(&self) -> impl Iterator<Item = (usize, f64)> {
        let index = self.index.iter().map(|&i| i as usize);
        index.zip(self.values.iter().copied())
    }

    /// The entries that are not zero.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The product with a dense vector.
    pub fn dot(&self, v: &[f64]) -> f64 {
        self.entries().map(|(i, value)| value * v[i]).sum()
    }

    /// out += factor · self.
    pub fn add_to(&self, factor: f64, out: &mut [f64]) {
        for (i, value) in self.entries() {
            out[i] += factor * value;
        }
    }

    /// Multiplies all entries.
    pub fn scale(&mut self, factor: f64) {
        self.values.iter_mut().for_each(|value| *value *= factor);
    }

    /// The same vector times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        scaled.scale(factor);
        scaled
    }

    /// self + Σ factorⱼ · otherⱼ of vectors of the same length.
    pub fn plus<'a>(&self, others: impl IntoIterator<Item = (f64, &'a Self)>) -> Self {
        let mut parts: Vec<(usize, f64)> = self.entries().collect();
        for (factor, other) in others {
            parts.extend(other.entries().map(|(i, value)| (i, factor * value)));
        }
        Self::sum(self.length, parts)
    }

    /// Euclidean length.
    pub fn norm(&self) -> f64 {
        norm(&self.values)
    }
}

impl std::ops::Index<usize> for SparseVector {
    type Output = f64;

    fn index(&self, i: usize) -> &f64 {
        if self.values.len() == self.length {
            return &self.values[i];
        }
        match self.index.binary_search(&(i as u32)) {
            Ok(place) => &self.values[place],
            Err(_) => &0.0,
        }
    }
}

/// A general (rows, cols) matrix by rows; 12 bytes per entry and 8 per row.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    cols: usize,
    row_start: Vec<usize>,
    col_index: Vec<u32>,
    values: Vec<f64>,
}

impl SparseMatrix {
    /// Sums (row, column, value) triplets; duplicates are added in the order given.
    ///
    /// Panics when an index is out of range.
    pub fn from_triplets(rows: usize, cols: usize, triplets: &[(usize, usize, f64)]) -> Self {
        let mut row_start = vec![0; rows + 1];
        for &(row, col, _) in triplets {
            assert!(
                row < rows && col < cols,
                "entry ({row}, {col}) of a ({rows}, {cols}) matrix"
            );
            row_start[row + 1] += 1;
        }
        accumulate(&mut row_start);
        let mut next = row_start.clone();
        let mut entries = vec![(0u32, 0.0); triplets.len()];
        for &(row, col, value) in triplets {
            entries[next[row]] = (col as u32, value);
            next[row] += 1;
        }
        let mut col_index = Vec::with_capacity(entries.len());
        let mut values = Vec::with_capacity(entries.len());
        for row in 0..rows {
            let slice = row_start[row]..row_start[row + 1];
            row_start[row] = values.len();
            let entries = &mut entries[slice];
            entries.sort_by_key(|entry| entry.0);
            for (i, &(col, value)) in entries.iter().enumerate() {
                if i > 0 && entries[i - 1].0 == col {
                    *values.last_mut().expect("an entry precedes its duplicate") += value;
                } else {
                    col_index.push(col);
                    values.push(value);
                }
            }
        }
        row_start[rows] = values.len();
        Self {
            cols,
            row_start,
            col_index,
            values,
        }
    }

    /// The entries of a dense (rows, cols) matrix that are not zero.
    pub fn from_dense(dense: &Mat<f64>) -> Self {
        let all = (0..dense.ncols()).flat_map(|j| (0..dense.nrows()).map(move |i| (i, j)));
        let entries = all.map(|(i, j)| (i, j, dense[(i, j)]));
        let entries: Vec<_> = entries.filter(|entry| entry.2 != 0.0).collect();
        Self::from_triplets(dense.nrows(), dense.ncols(), &entries)
    }

    /// All entries, (rows, cols).
    pub fn to_dense(&self) -> Mat<f64> {
        let mut dense = Mat::zeros(self.rows(), self.cols());
        for i in 0..self.rows() {
            self.row(i).for_each(|(j, value)| dense[(i, j)] = value);
        }
        dense
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Number of stored entries.
    pub fn nonzeros(&self) -> usize {
        self.values.len()
    }

    /// All stored entries, row by row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// (column, value) of the entries of a row, columns ascending.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let entries = self.row_start[i]..self.row_start[i + 1];
        let columns = self.col_index[entries.clone()]
            .iter()
            .map(|&col| col as usize);
        columns.zip(self.values[entries].iter().copied())
    }

    /// y = Ax; x (cols,), y (rows,).
    pub fn mul(&self, x: &[f64], y: &mut [f64]) {
        assert!(x.len() == self.cols && y.len() == self.rows());
        for (i, y) in y.iter_mut().enumerate() {
            *y = self.row(i).map(|(j, value)| value * x[j]).sum();
        }
    }

    /// y += Aᵀx; x (rows,), y (cols,).
    pub fn mul_transpose_add(&self, x: &[f64], y: &mut [f64]) {
        assert!(x.len() == self.rows() && y.len() == self.cols);
        for (i, &x) in x.iter().enumerate() {
            for (j, value) in self.row(i) {
                y[j] += value * x;
            }
        }
    }
}

/// Nodes of the cells of one kind.
#[derive(Debug, Clone, Copy)]
pub struct Connectivity<'a> {
    /// Node numbers, `nodes_per_cell` for each cell.
    pub nodes: &'a [u32],
    /// Number of nodes of a cell.
    pub nodes_per_cell: usize,
}

/// Dense symmetric matrices of the cells of one kind.
#[derive(Debug, Clone, Copy)]
pub struct CellMatrices<'a> {
    /// Node numbers, `nodes_per_cell` = k for each cell.
    pub nodes: &'a [u32],
    /// Number of nodes of a cell.
    pub nodes_per_cell: usize,
    /// For each cell the lower triangle of its (kD, kD) matrix, packed by rows: entry (i, j ≤ i) is number
    /// i(i + 1)/2 + j of the kD(kD + 1)/2; the dof of local node a and component c is i = D·a + c.
    pub values: &'a [f64],
}

impl<'a> CellMatrices<'a> {
    /// The nodes without the matrices.
    pub fn connectivity(&self) -> Connectivity<'a> {
        Connectivity {
            nodes: self.nodes,
            nodes_per_cell: self.nodes_per_cell,
        }
    }
}

/// The nodes that share a cell with a node, and the cells at each node.
///
/// A slot is a place in the concatenated node lists of all blocks: it gives the cell and the local node.
/// Memory: 4 bytes per neighbour and per slot, 16 per node, 24 for its place.
#[derive(Debug, Clone)]
pub struct Graph {
    /// Coordinates of the nodes, those of the plane with a zero; none if they are not known.
    places: Vec<[f64; 3]>,
    start: Vec<usize>,
    neighbours: Vec<u32>,
    slot_start: Vec<usize>,
    slots: Vec<u32>,
}

impl Graph {
    /// Adjacency of `nodes` nodes by pairs of them.
    ///
    /// Panics when a pair names a node that does not exist.
    pub(crate) fn of_edges(nodes: usize, edges: impl Iterator<Item = [u32; 2]>) -> Self {
        let ends: Vec<u32> = edges.flatten().collect();
        let pairs = Connectivity {
            nodes: &ends,
            nodes_per_cell: 2,
        };
        Self::from_cells(nodes, &[pairs])
    }

    /// Adjacency of `nodes` nodes by the cells of all blocks.
    ///
    /// Panics when a cell names a node that does not exist.
    pub fn from_cells(nodes: usize, blocks: &[Connectivity]) -> Self {
        let (slot_start, slots) = incident_slots(nodes, blocks);
        let tasks: Vec<usize> = (0..nodes).step_by(NODES_PER_TASK).collect();
        let chunks: Vec<(Vec<u32>, Vec<u32>)> = tasks
            .into_par_iter()
            .map(|first| {
                let last = nodes.min(first + NODES_PER_TASK);
                neighbours_of(first..last, &slot_start, &slots, blocks)
            })
            .collect();
        let mut start = Vec::with_capacity(nodes + 1);
        let mut neighbours = Vec::with_capacity(chunks.iter().map(|c| c.1.len()).sum());
        start.push(0);
        for (counts, chunk) in &chunks {
            for &count in counts {
                start.push(start[start.len() - 1] + count as usize);
            }
            neighbours.extend_from_slice(chunk);
        }
        Self {
            places: Vec::new(),
            start,
            neighbours,
            slot_start,
            slots,
        }
    }

    /// The same of nodes at known places, which tell where to cut it.
    ///
    /// Panics when there is not one place for each node.
    pub fn placed<const D: usize>(mut self, places: &[[f64; D]]) -> Self {
        assert_eq!(places.len(), self.nodes());
        let place = |x: &[f64; D]| std::array::from_fn(|k| x.get(k).copied().unwrap_or(0.0));
        self.places = places.iter().map(place).collect();
        self
    }

    /// Coordinates of the nodes; none if they are not known.
    pub(super) fn places(&self) -> &[[f64; 3]] {
        &self.places
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// Nodes that share a cell with a node, ascending, without the node itself.
    pub fn neighbours(&self, node: usize) -> &[u32] {
        &self.neighbours[self.start[node]..self.start[node + 1]]
    }

    /// Number of ordered pairs of different nodes that share a cell.
    pub fn edges(&self) -> usize {
        self.neighbours.len()
    }

    /// Slots that name a node, one for each cell at it.
    pub(super) fn slots(&self, node: usize) -> &[u32] {
        &self.slots[self.slot_start[node]..self.slot_start[node + 1]]
    }

    /// Neighbours with a greater number.
    fn greater(&self, node: usize) -> &[u32] {
        let all = self.neighbours(node);
        &all[all.partition_point(|&other| (other as usize) < node)..]
    }
}

/// For each node the slots that name it, ascending.
fn incident_slots(nodes: usize, blocks: &[Connectivity]) -> (Vec<usize>, Vec<u32>) {
    let mut start = vec![0; nodes + 1];
    for block in blocks {
        for &node in block.nodes {
            start[node as usize + 1] += 1;
        }
    }
    accumulate(&mut start);
    let mut next = start.clone();
    let mut slots = vec![0; start[nodes]];
    let all = blocks.iter().flat_map(|block| block.nodes);
    for (slot, &node) in all.enumerate() {
        slots[next[node as usize]] = slot as u32;
        next[node as usize] += 1;
    }
    (start, slots)
}

/// Numbers of neighbours of the nodes, and the neighbours.
fn neighbours_of(
    nodes: std::ops::Range<usize>,
    slot_start: &[usize],
    slots: &[u32],
    blocks: &[Connectivity],
) -> (Vec<u32>, Vec<u32>) {
    let mut counts = Vec::with_capacity(nodes.len());
    let mut neighbours = Vec::with_capacity(8 * nodes.len());
    let mut found = Vec::new();
    for node in nodes {
        found.clear();
        for &slot in &slots[slot_start[node]..slot_start[node + 1]] {
            let (block, slot) = locate(blocks.iter().map(|b| b.nodes.len()), slot as usize);
            let block = &blocks[block];
            let first = slot - slot % block.nodes_per_cell;
            found.extend_from_slice(&block.nodes[first..first + block.nodes_per_cell]);
        }
        found.sort_unstable();
        found.dedup();
        let before = neighbours.len();
        neighbours.extend(found.iter().filter(|&&other| other as usize != node));
        counts.push((neighbours.len() - before) as u32);
    }
    (counts, neighbours)
}

/// The block that holds a slot, and the slot within it. There are few blocks.
fn locate(lengths: impl Iterator<Item = usize>, slot: usize) -> (usize, usize) {
    let mut slot = slot;
    for (block, length) in lengths.enumerate() {
        if slot < length {
            return (block, slot);
        }
        slot -= length;
    }
    unreachable!("a slot lies in one of the blocks")
}

/// A symmetric (n, n) matrix: its lower triangle by columns; 12 bytes per stored entry and 8 per column.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricMatrix {
    col_start: Vec<usize>,
    row_index: Vec<u32>,
    values: Vec<f64>,
}

impl SymmetricMatrix {
    /// Sums (row, column, value) triplets of the lower triangle; those above the diagonal are ignored, so that the
    /// full matrix may be given. Missing diagonal entries are stored as zeros.
    ///
    /// Panics when an index is out of range.
    pub fn from_triplets(n: usize, triplets: &[(usize, usize, f64)]) -> Self {
        let diagonal = (0..n).map(|i| (i, i, 0.0));
        let lower = triplets.iter().filter(|t| t.0 >= t.1);
        let columns: Vec<_> = diagonal.chain(lower.map(|&(i, j, v)| (j, i, v))).collect();
        let by_columns = SparseMatrix::from_triplets(n, n, &columns);
        Self {
            col_start: by_columns.row_start,
            row_index: by_columns.col_index,
            values: by_columns.values,
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.col_start.len() - 1
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of stored entries: those of the lower triangle.
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    /// Bytes it occupies.
    pub fn bytes(&self) -> usize {
        12 * self.values.len() + 8 * self.col_start.len()
    }

    /// Where the entry (i, j), j ≤ i, is among the values, if it is stored.
    pub(super) fn place(&self, i: usize, j: usize) -> Option<usize> {
        let found = self.rows_of(j).binary_search(&(i as u32)).ok()?;
        Some(self.col_start[j] + found)
    }

    /// The matrix of the same pattern with other values.
    pub(super) fn with_values(&self, values: Vec<f64>) -> Self {
        assert_eq!(values.len(), self.values.len());
        Self {
            values,
            ..self.clone()
        }
    }

    /// Row indices of the stored entries of a column: the column itself first, then ascending.
    pub fn rows_of(&self, column: usize) -> &[u32] {
        &self.row_index[self.col_start[column]..self.col_start[column + 1]]
    }

    /// Values that go with [`rows_of`](Self::rows_of).
    pub fn values_of(&self, column: usize) -> &[f64] {
        &self.values[self.col_start[column]..self.col_start[column + 1]]
    }

    /// All stored values, column by column.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Entry (i, j) of either triangle; zero if it is not stored.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        let (row, column) = (i.max(j), i.min(j));
        let place = self.place(row, column);
        place.map_or(0.0, |place| self.values[place])
    }

    /// Adds to an entry that is stored; entries above the diagonal are ignored, so that those of a full matrix may be given.
    ///
    /// Panics if it is not stored.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        if row < column {
            return;
        }
        let place = self.place(row, column);
        #[expect(clippy::expect_used, reason = "documented panic")]
        let place = place.expect("an entry that is stored");
        self.values[place] += value;
    }

    /// Whether an entry is stored, or is ignored by [`Self::add`].
    pub(crate) fn stores(&self, row: usize, column: usize) -> bool {
        row < column || self.place(row, column).is_some()
    }

    /// The diagonal, (n,).
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.len())
            .map(|j| self.values[self.col_start[j]])
            .collect()
    }

    /// y = Ax, both (n,).
    pub fn mul(&self, x: &[f64], y: &mut [f64]) {
        assert!(x.len() == self.len() && y.len() == self.len());
        y.fill(0.0);
        for j in 0..self.len() {
            let (rows, values) = (self.rows_of(j), self.values_of(j));
            let mut sum = values[0] * x[j];
            for (&i, value) in rows[1..].iter().zip(&values[1..]) {
                sum += value * x[i as usize];
                y[i as usize] += value * x[j];
            }
            y[j] += sum;
        }
    }

    /// QAQᵀ, for a matrix of nodes with D dofs each whose blocks are stored whole, as [`assemble_blocks`] makes it. Q turns the dofs
    /// of some nodes; its rows there are their `axes`.
    pub(crate) fn turn<const D: usize>(&mut self, axes: &BTreeMap<usize, [[f64; D]; D]>) {
        if axes.is_empty() {
            return;
        }
        let unit = |i: usize| array::from_fn(|j| f64::from(u8::from(i == j)));
        let mut turns = vec![None; self.len() / D];
        for (&node, &axes) in axes {
            turns[node] = Some(axes);
        }
        let of = |turn: Option<[[f64; D]; D]>| turn.unwrap_or_else(|| array::from_fn(unit));
        for (node, &own) in turns.iter().enumerate() {
            let start: [usize; D] = array::from_fn(|c| self.col_start[D * node + c]);
            if let Some(own) = own {
                // the block of the node itself is a lower triangle
                let place = |r: usize, c: usize| start[r.min(c)] + r.abs_diff(c);
                let block = array::from_fn(|r| array::from_fn(|c| self.values[place(r, c)]));
                let block = turned(&own, &block, &own);
                for (r, row) in block.iter().enumerate() {
                    for (c, &value) in row[..=r].iter().enumerate() {
                        self.values[place(r, c)] = value;
                    }
                }
            }
            let below = (self.col_start[D * node + 1] - start[0]) / D - 1;
            for k in 0..below {
                let place = |r: usize, c: usize| start[c] + D - c + D * k + r;
                let other = turns[self.row_index[place(0, 0)] as usize / D];
                if own.is_none() && other.is_none() {
                    continue;
                }
                let block = array::from_fn(|r| array::from_fn(|c| self.values[place(r, c)]));
                let block = turned(&of(other), &block, &of(own));
                for (r, row) in block.iter().enumerate() {
                    for (c, &value) in row.iter().enumerate() {
                        self.values[place(r, c)] = value;
                    }
                }
            }
        }
    }
}

/// ABCᵀ.
fn turned<const D: usize>(
    a: &[[f64; D]; D],
    b: &[[f64; D]; D],
    c: &[[f64; D]; D],
) -> [[f64; D]; D] {
    let along: [[f64; D]; D] =
        array::from_fn(|i| array::from_fn(|j| (0..D).map(|k| a[i][k] * b[k][j]).sum()));
    array::from_fn(|i| array::from_fn(|j| (0..D).map(|k| along[i][k] * c[j][k]).sum()))
}

/// Sums cell matrices into the matrix of D·nodes dofs; `graph` must be made of the same blocks.
///
/// Errors: [`LinalgError::WrongPattern`] when a block has the wrong number of values or the graph other cells.
pub fn assemble_blocks<const D: usize>(
    graph: &Graph,
    blocks: &[CellMatrices],
) -> Result<SymmetricMatrix, LinalgError> {
    check_blocks::<D>(graph, blocks)?;
    let nodes = graph.nodes();
    let mut col_start = Vec::with_capacity(D * nodes + 1);
    let mut entries = 0;
    for node in 0..nodes {
        let below = D * graph.greater(node).len();
        for component in 0..D {
            col_start.push(entries);
            entries += D - component + below;
        }
    }
    col_start.push(entries);

    let mut row_index = vec![0; entries];
    let mut values = vec![0.0; entries];
    let mut tasks = Vec::with_capacity(nodes.div_ceil(NODES_PER_TASK));
    let (mut free_rows, mut free_values) = (&mut row_index[..], &mut values[..]);
    for first in (0..nodes).step_by(NODES_PER_TASK) {
        let last = nodes.min(first + NODES_PER_TASK);
        let length = col_start[D * last] - col_start[D * first];
        let (rows, rest) = free_rows.split_at_mut(length);
        free_rows = rest;
        let (sums, rest) = free_values.split_at_mut(length);
        free_values = rest;
        tasks.push((first..last, rows, sums));
    }
    tasks.into_par_iter().for_each(|(nodes, rows, sums)| {
        let mut offset = 0;
        for node in nodes {
            let length = col_start[D * node + D] - col_start[D * node];
            let own = offset..offset + length;
            list_rows::<D>(graph, node, &mut rows[own.clone()]);
            gather_node::<D>(graph, blocks, node, &mut sums[own]);
            offset += length;
        }
    });
    Ok(SymmetricMatrix {
        col_start,
        row_index,
        values,
    })
}

fn check_blocks<const D: usize>(graph: &Graph, blocks: &[CellMatrices]) -> Result<(), LinalgError> {
    for block in blocks {
        let dofs = D * block.nodes_per_cell;
        let cells = block.nodes.len() / block.nodes_per_cell.max(1);
        let (expected, found) = (cells * dofs * (dofs + 1) / 2, block.values.len());
        if expected != found {
            return Err(LinalgError::WrongPattern { expected, found });
        }
    }
    let expected = graph.slots.len();
    let found = blocks.iter().map(|block| block.nodes.len()).sum();
    if expected != found {
        return Err(LinalgError::WrongPattern { expected, found });
    }
    Ok(())
}

/// Row indices of the D columns of a node.
fn list_rows<const D: usize>(graph: &Graph, node: usize, rows: &mut [u32]) {
    let mut next = 0;
    for component in 0..D {
        for other in component..D {
            rows[next] = (D * node + other) as u32;
            next += 1;
        }
        for &other in graph.greater(node) {
            for c in 0..D {
                rows[next] = D as u32 * other + c as u32;
                next += 1;
            }
        }
    }
}

/// Adds the contributions of the cells at a node to its D columns.
fn gather_node<const D: usize>(
    graph: &Graph,
    blocks: &[CellMatrices],
    node: usize,
    sums: &mut [f64],
) {
    let greater = graph.greater(node);
    let below = D * greater.len();
    let mut column_start = [0; D];
    for component in 1..D {
        column_start[component] = column_start[component - 1] + D - (component - 1) + below;
    }
    for &slot in graph.slots(node) {
        let (block, slot) = locate(blocks.iter().map(|b| b.nodes.len()), slot as usize);
        let block = &blocks[block];
        let k = block.nodes_per_cell;
        let (cell, local) = (slot / k, slot % k);
        let packed = D * k * (D * k + 1) / 2;
        let matrix = &block.values[cell * packed..(cell + 1) * packed];
        for (other_local, &other) in block.nodes[cell * k..(cell + 1) * k].iter().enumerate() {
            if (other as usize) < node {
                continue;
            }
            // The block of the node itself is a lower triangle, that of a neighbour is full.
            let place = greater.binary_search(&other).ok();
            for (column, &start) in column_start.iter().enumerate() {
                let (first_row, offset) = match place {
                    None => (column, start),
                    Some(place) => (0, start + D - column + D * place),
                };
                for row in first_row..D {
                    let (i, j) = (D * other_local + row, D * local + column);
                    let (i, j) = (i.max(j), i.min(j));
                    sums[offset + row - first_row] += matrix[i * (i + 1) / 2 + j];
                }
            }
        }
    }
}

/// Counts at 1.. become starts.
pub(crate) fn accumulate<T: Copy + AddAssign>(counts: &mut [T]) {
    for i in 1..counts.len() {
        let before = counts[i - 1];
        counts[i] += before;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::grid;

    #[test]
    fn duplicate_triplets_are_summed() {
        let a = SparseMatrix::from_triplets(
            3,
            4,
            &[
                (2, 3, 1.0),
                (0, 1, 2.0),
                (2, 0, 5.0),
                (2, 3, 0.25),
                (0, 1, -1.0),
            ],
        );
        assert_eq!((a.rows(), a.cols(), a.nonzeros()), (3, 4, 3));
        assert_eq!(a.row(0).collect::<Vec<_>>(), [(1, 1.0)]);
        assert_eq!(a.row(1).count(), 0);
        assert_eq!(a.row(2).collect::<Vec<_>>(), [(0, 5.0), (3, 1.25)]);
        let mut y = [9.0; 3];
        a.mul(&[1.0, 2.0, 3.0, 4.0], &mut y);
        assert_eq!(y, [2.0, 0.0, 10.0]);
        let mut z = [1.0; 4];
        a.mul_transpose_add(&[1.0, 7.0, 2.0], &mut z);
        assert_eq!(z, [11.0, 2.0, 1.0, 3.5]);
    }

    #[test]
    fn neighbours_share_a_cell_of_any_block() {
        let triangles = Connectivity {
            nodes: &[0, 1, 2],
            nodes_per_cell: 3,
        };
        let quads = Connectivity {
            nodes: &[1, 3, 4, 2, 5, 4, 3, 6],
            nodes_per_cell: 4,
        };
        let graph = Graph::from_cells(8, &[triangles, quads]);
        assert_eq!(graph.neighbours(0), [1, 2]);
        assert_eq!(graph.neighbours(3), [1, 2, 4, 5, 6]);
        assert_eq!(graph.neighbours(4), [1, 2, 3, 5, 6]);
        assert_eq!(graph.neighbours(7), [0u32; 0]);
        assert_eq!(graph.edges(), 2 + 4 + 4 + 5 + 5 + 3 + 3);
    }

    /// Sum of the cell matrices by their definition, entry by entry.
    fn dense_sum<const D: usize>(n: usize, blocks: &[CellMatrices]) -> Vec<Vec<f64>> {
        let mut sum = vec![vec![0.0; n]; n];
        for block in blocks {
            let k = block.nodes_per_cell;
            let mut packed = block.values.iter();
            for cell in block.nodes.chunks(k) {
                let dofs: Vec<usize> = cell
                    .iter()
                    .flat_map(|&node| (0..D).map(move |c| D * node as usize + c))
                    .collect();
                for i in 0..dofs.len() {
                    for j in 0..=i {
                        let value = packed.next().unwrap();
                        sum[dofs[i]][dofs[j]] += value;
                        if i != j {
                            sum[dofs[j]][dofs[i]] += value;
                        }
                    }
                }
            }
        }
        sum
    }

    fn assembly_of_two_kinds_of_cells<const D: usize>() {
        let triangles = [0, 1, 2, 6, 2, 1];
        let quads = [4, 3, 1, 2, 3, 4, 5, 6];
        let size = |k: usize| D * k * (D * k + 1) / 2;
        let values = grid::noise(2 * size(3) + 2 * size(4));
        let (first, second) = values.split_at(2 * size(3));
        let blocks = [
            CellMatrices {
                nodes: &triangles,
                nodes_per_cell: 3,
                values: first,
            },
            CellMatrices {
                nodes: &quads,
                nodes_per_cell: 4,
                values: second,
            },
        ];
        let graph = Graph::from_cells(7, &blocks.map(|b| b.connectivity()));
        let matrix = assemble_blocks::<D>(&graph, &blocks).unwrap();
        let expected = dense_sum::<D>(7 * D, &blocks);
        for (i, row) in expected.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((matrix.get(i, j) - value).abs() < 1e-14, "entry ({i}, {j})");
            }
            assert!(matrix.rows_of(i).is_sorted());
            assert_eq!(matrix.rows_of(i)[0], i as u32);
        }
        let x = grid::noise(7 * D);
        let mut y = vec![0.0; 7 * D];
        matrix.mul(&x, &mut y);
        for (i, row) in expected.iter().enumerate() {
            let sum: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((y[i] - sum).abs() < 1e-13);
        }
    }

    #[test]
    fn assembly_is_the_sum_of_the_cell_matrices() {
        assembly_of_two_kinds_of_cells::<1>();
        assembly_of_two_kinds_of_cells::<2>();
        assembly_of_two_kinds_of_cells::<3>();
    }

    #[test]
    fn a_block_with_missing_values_is_refused() {
        let block = CellMatrices {
            nodes: &[0, 1, 2],
            nodes_per_cell: 3,
            values: &[0.0; 20],
        };
        let graph = Graph::from_cells(3, &[block.connectivity()]);
        assert_eq!(
            assemble_blocks::<2>(&graph, &[block]),
            Err(LinalgError::WrongPattern {
                expected: 21,
                found: 20
            })
        );
    }

    #[test]
    fn rigid_motions_of_an_assembled_body_need_no_force() {
        let (nx, ny) = (7, 4);
        let (_, matrix) = grid::body(nx, ny);
        let mut force = vec![0.0; matrix.len()];
        for mode in 0..3 {
            let u: Vec<f64> = (0..(nx + 1) * (ny + 1))
                .flat_map(|node| {
                    let (x, y) = ((node % (nx + 1)) as f64, (node / (nx + 1)) as f64);
                    [[1.0, 0.0], [0.0, 1.0], [-y, x]][mode]
                })
                .collect();
            matrix.mul(&u, &mut force);
            // Displacements are up to 7 and stiffnesses near 1: rounding is below 1e-14.
            assert!(force.iter().all(|f| f.abs() < 1e-13), "mode {mode}");
        }
    }

    #[test]
    fn assembly_has_the_same_bits_on_any_number_of_threads() {
        let one = grid::on_threads(1, || grid::body(70, 61));
        let two = grid::on_threads(2, || grid::body(70, 61));
        assert_eq!(one.1, two.1);
        assert_eq!(one.0.neighbours, two.0.neighbours);
    }
}
