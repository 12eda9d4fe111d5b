//! The numbers of a supernodal Cholesky factor, front by front.
//!
//! The front of a supernode is the part of the matrix that its elimination touches: its columns, and the rows of its pattern
//! in the columns of its ancestors,
//!
//! ```text
//!   [ A₁₁  ·   ]   [ L₁₁     ]
//!   [ A₂₁  A₂₂ ] → [ L₂₁  U  ]     A₁₁ = L₁₁L₁₁ᵀ,  L₂₁ = A₂₁L₁₁⁻ᵀ,  U = A₂₂ − L₂₁L₂₁ᵀ
//! ```
//!
//! U is added to the front of its parent in the elimination tree; there is one of it alive for each child that waits. Subtrees
//! are eliminated in parallel, what is above them one after the other, large fronts in blocks in parallel. Which subtrees and
//! blocks follows from sizes alone, and children are added in their order: the bits are the same for any number of threads.
//!
//! Source: I. S. Duff, J. K. Reid, The multifrontal solution of indefinite sparse symmetric linear equations,
//! ACM Trans. Math. Softw. 9 (1983) 302–325.

use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Columns of a large front that are eliminated together, and of a block that one thread updates.
const BLOCK: usize = 128;

/// A front with more rows is eliminated in blocks.
const LARGE: usize = 3 * BLOCK;

/// Subtrees have at most this part of all operations each: enough of them to share among threads evenly.
const SHARE: f64 = 1.0 / 48.0;

/// Operations that are not worth a task of their own.
const SMALL_TASK: f64 = 2e6;

/// Operations that moving an entry of a front costs, beside arithmetic on it.
const MOVE: f64 = 10.0;

const ROOT: u32 = u32::MAX;

/// How much of a factorisation is done; it may be looked at from any thread.
#[derive(Debug, Default)]
pub struct Work {
    /// Operations to do.
    pub all: AtomicU64,
    /// Operations that are done.
    pub done: AtomicU64,
    /// Bytes of the factors.
    pub bytes: AtomicU64,
}

impl Work {
    /// The part that is done, in [0, 1].
    pub fn part(&self) -> f64 {
        let [done, all] = [&self.done, &self.all].map(|count| count.load(Ordering::Relaxed));
        done as f64 / all.max(1) as f64
    }
}

/// The elimination tree of the supernodes, and in which order who eliminates them.
#[derive(Debug)]
pub(super) struct Tree {
    /// Children of each supernode, ascending.
    children: Vec<Vec<u32>>,
    /// Subtrees that are eliminated in parallel, each in an order in which children precede their parents.
    subtrees: Vec<Vec<u32>>,
    /// What is above them, in such an order.
    above: Vec<u32>,
    /// Operations on the front of each supernode.
    operations: Vec<f64>,
}

/// Columns of a supernode, and the rows of its pattern below them.
fn shape(symbolic: &SymbolicSupernodalCholesky<u32>, s: usize) -> (Range<usize>, &[u32]) {
    let columns = symbolic.supernode_begin()[s] as usize..symbolic.supernode_end()[s] as usize;
    (columns, symbolic.supernode(s).pattern())
}

impl Tree {
    pub fn new(symbolic: &SymbolicSupernodalCholesky<u32>) -> Self {
        let count = symbolic.n_supernodes();
        let mut owner = vec![0u32; symbolic.nrows()];
        let (mut parent, mut operations) = (vec![ROOT; count], vec![0.0; count]);
        for (s, operations) in operations.iter_mut().enumerate() {
            let (columns, pattern) = shape(symbolic, s);
            owner[columns.clone()].fill(s as u32);
            let (n, m) = (columns.len() as f64, pattern.len() as f64);
            *operations = n * (n * n / 3.0 + m * n + m * m) + MOVE * (n + m) * (n + m);
        }
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); count];
        let mut below = operations.clone();
        for s in 0..count {
            if let Some(&row) = shape(symbolic, s).1.first() {
                let above = owner[row as usize];
                parent[s] = above;
                children[above as usize].push(s as u32);
                // a parent has a larger number than its children
                below[above as usize] += below[s];
            }
        }
        let limit = SMALL_TASK.max(SHARE * operations.iter().sum::<f64>());
        let (mut subtrees, mut above) = (Vec::new(), Vec::new());
        for s in 0..count {
            let beyond = parent[s] == ROOT || below[parent[s] as usize] > limit;
            match below[s] > limit {
                true => above.push(s as u32),
                false if beyond => subtrees.push(subtree(&children, s as u32)),
                false => {}
            }
        }
        Self {
            children,
            subtrees,
            above,
            operations,
        }
    }

    /// There are several subtrees, and fronts that are eliminated in blocks.
    #[cfg(test)]
    pub fn is_shared(&self) -> bool {
        let large = 2.0 * MOVE * (LARGE * LARGE) as f64;
        self.subtrees.len() > 8 && self.operations.iter().any(|&operations| operations > large)
    }

    /// Operations of the whole factorisation.
    pub fn operations(&self) -> f64 {
        self.operations.iter().sum()
    }
}

/// A supernode and all below it, children before their parents, and a child's subtree before the next child.
fn subtree(children: &[Vec<u32>], root: u32) -> Vec<u32> {
    let (mut order, mut open) = (Vec::new(), vec![root]);
    while let Some(s) = open.pop() {
        order.push(s);
        open.extend(&children[s as usize]);
    }
    order.reverse();
    order
}

/// The matrix that is factored: entries on and below the diagonal, by columns in the order of elimination.
#[derive(Clone, Copy)]
pub(super) struct Lower<'a> {
    pub col_start: &'a [u32],
    pub row_index: &'a [u32],
    pub values: &'a [f64],
}

/// Everything that the elimination of a front needs to know.
#[derive(Clone, Copy)]
struct Elimination<'a> {
    symbolic: &'a SymbolicSupernodalCholesky<u32>,
    tree: &'a Tree,
    lower: Lower<'a>,
    work: &'a Work,
}

/// What a thread needs for itself.
struct Scratch {
    /// Place in the current front of every row of the matrix that it has.
    place: Vec<u32>,
    /// Places in a front of the rows of a child.
    rows: Vec<usize>,
    memory: MemBuffer,
}

/// U of a front with the rows of the pattern of its supernode, by columns, the lower triangle.
type Update = Vec<f64>;

/// The values of L in the layout of its supernodes, `values` zero before; `work` counts operations.
///
/// Errors: the place in the order of elimination of a pivot that is not positive.
pub(super) fn factorise(
    symbolic: &SymbolicSupernodalCholesky<u32>,
    tree: &Tree,
    lower: Lower<'_>,
    values: &mut [f64],
    work: &Work,
) -> Result<(), usize> {
    let elimination = Elimination {
        symbolic,
        tree,
        lower,
        work,
    };
    let mut blocks = blocks_of(symbolic, values);
    let mut updates: Vec<Option<Update>> = vec![None; symbolic.n_supernodes()];
    let tasks: Vec<(&[u32], Vec<&mut [f64]>)> = tree
        .subtrees
        .iter()
        .map(|order| {
            let own = order
                .iter()
                .map(|&s| std::mem::take(&mut blocks[s as usize]));
            (&order[..], own.collect())
        })
        .collect();
    let done: Vec<Result<Update, usize>> = tasks
        .into_par_iter()
        .map_init(
            || elimination.scratch(),
            |scratch, (order, blocks)| elimination.subtree(order, blocks, scratch),
        )
        .collect();
    // the first pivot that failed, whichever thread met it
    if let Some(pivot) = done.iter().filter_map(|done| done.as_ref().err()).min() {
        return Err(*pivot);
    }
    for (order, update) in tree.subtrees.iter().zip(done) {
        let root = order.last().map_or(0, |&root| root as usize);
        updates[root] = update.ok();
    }
    let mut scratch = elimination.scratch();
    for &s in &tree.above {
        let s = s as usize;
        let below = tree.children[s].iter();
        let below: Vec<(u32, Update)> = below
            .filter_map(|&child| Some((child, updates[child as usize].take()?)))
            .collect();
        let block = std::mem::take(&mut blocks[s]);
        updates[s] = Some(elimination.front(s, &below, block, &mut scratch)?);
    }
    Ok(())
}

/// The values of each supernode.
fn blocks_of<'v>(
    symbolic: &SymbolicSupernodalCholesky<u32>,
    mut values: &'v mut [f64],
) -> Vec<&'v mut [f64]> {
    let starts = symbolic.col_ptr_for_val().windows(2);
    let sizes = starts.map(|pair| (pair[1] - pair[0]) as usize);
    sizes
        .map(|size| {
            let (block, rest) = std::mem::take(&mut values).split_at_mut(size);
            values = rest;
            block
        })
        .collect()
}

impl Elimination<'_> {
    fn scratch(&self) -> Scratch {
        let widest = (0..self.symbolic.n_supernodes()).map(|s| shape(self.symbolic, s).0.len());
        let widest = widest.max().unwrap_or(0);
        Scratch {
            place: vec![0; self.symbolic.nrows()],
            rows: Vec::new(),
            memory: MemBuffer::new(cholesky_in_place_scratch::<f64>(
                widest,
                Par::Seq,
                Default::default(),
            )),
        }
    }

    /// Eliminates a subtree, and returns what it leaves to the parent of its root.
    fn subtree(
        &self,
        order: &[u32],
        blocks: Vec<&mut [f64]>,
        scratch: &mut Scratch,
    ) -> Result<Update, usize> {
        // children are the last that were eliminated and not yet added
        let mut waiting: Vec<(u32, Update)> = Vec::new();
        for (&s, block) in order.iter().zip(blocks) {
            let first = waiting.len() - self.tree.children[s as usize].len();
            let update = self.front(s as usize, &waiting[first..], block, scratch)?;
            waiting.truncate(first);
            waiting.push((s, update));
        }
        Ok(waiting.pop().map_or(Vec::new(), |(_, update)| update))
    }

    /// Assembles and eliminates the front of a supernode.
    fn front(
        &self,
        s: usize,
        below: &[(u32, Update)],
        block: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<Update, usize> {
        let (columns, pattern) = shape(self.symbolic, s);
        let (n, m) = (columns.len(), pattern.len());
        for (place, &row) in pattern.iter().enumerate() {
            scratch.place[row as usize] = (n + place) as u32;
        }
        for (place, row) in columns.clone().enumerate() {
            scratch.place[row] = place as u32;
        }
        for (column, values) in columns.clone().zip(block.chunks_exact_mut(n + m)) {
            let entries =
                self.lower.col_start[column] as usize..self.lower.col_start[column + 1] as usize;
            for entry in entries {
                let row = self.lower.row_index[entry] as usize;
                values[scratch.place[row] as usize] += self.lower.values[entry];
            }
        }
        let mut update = vec![0.0; m * m];
        for (child, part) in below {
            let rows = shape(self.symbolic, *child as usize).1;
            scratch.rows.clear();
            let places = rows.iter().map(|&row| scratch.place[row as usize] as usize);
            scratch.rows.extend(places);
            add(&scratch.rows, part, (n, m), block, &mut update);
        }
        let left = MatMut::from_column_major_slice_mut(block, n + m, n);
        let right = MatMut::from_column_major_slice_mut(&mut update, m, m);
        let stack = MemStack::new(&mut scratch.memory);
        let eliminated = match n + m > LARGE {
            true => eliminate_in_blocks(left, right, stack),
            false => eliminate(left, right, stack),
        };
        eliminated.map_err(|pivot| columns.start + pivot)?;
        let operations = self.tree.operations[s] as u64;
        self.work.done.fetch_add(operations, Ordering::Relaxed);
        Ok(update)
    }
}

/// Adds what a child leaves, with its rows at these places, to a front of n + m rows.
fn add(
    rows: &[usize],
    part: &[f64],
    (n, m): (usize, usize),
    block: &mut [f64],
    update: &mut [f64],
) {
    for (k, (&column, values)) in rows.iter().zip(part.chunks_exact(rows.len())).enumerate() {
        let (into, first) = match column.checked_sub(n) {
            None => (&mut block[column * (n + m)..][..n + m], 0),
            Some(column) => (&mut update[column * m..][..m], n),
        };
        for (&row, value) in rows[k..].iter().zip(&values[k..]) {
            into[row - first] += value;
        }
    }
}

/// L₁₁, L₂₁ and U of a front. Errors: the place of a pivot that is not positive.
fn eliminate(
    left: MatMut<'_, f64>,
    right: MatMut<'_, f64>,
    stack: &mut MemStack,
) -> Result<(), usize> {
    let n = left.ncols();
    let (mut diagonal, mut lower) = left.split_at_row_mut(n);
    cholesky(diagonal.rb_mut(), stack)?;
    solve_lower_triangular_in_place(diagonal.rb(), lower.rb_mut().transpose_mut(), Par::Seq);
    subtract_square(right, lower.rb());
    Ok(())
}

/// The same in blocks that threads share.
fn eliminate_in_blocks(
    mut left: MatMut<'_, f64>,
    right: MatMut<'_, f64>,
    stack: &mut MemStack,
) -> Result<(), usize> {
    let n = left.ncols();
    for start in (0..n).step_by(BLOCK) {
        let width = BLOCK.min(n - start);
        let (_, rest) = left.rb_mut().split_at_row_mut(start);
        let (_, rest) = rest.split_at_col_mut(start);
        let (panel, behind) = rest.split_at_col_mut(width);
        let (mut diagonal, mut lower) = panel.split_at_row_mut(width);
        cholesky(diagonal.rb_mut(), stack).map_err(|pivot| start + pivot)?;
        let diagonal = diagonal.rb();
        let mut chunks = Vec::new();
        let mut below = lower.rb_mut();
        while below.nrows() > 0 {
            let rows = BLOCK.min(below.nrows());
            let (chunk, next) = below.split_at_row_mut(rows);
            chunks.push(chunk);
            below = next;
        }
        chunks.into_par_iter().for_each(|chunk| {
            solve_lower_triangular_in_place(diagonal, chunk.transpose_mut(), Par::Seq);
        });
        let (_, behind) = behind.split_at_row_mut(width);
        subtract_in_blocks(behind, lower.rb());
    }
    let (_, lower) = left.split_at_row_mut(n);
    subtract_in_blocks(right, lower.rb());
    Ok(())
}

/// L of the lower triangle of a block. Errors: the place of a pivot that is not positive.
fn cholesky(diagonal: MatMut<'_, f64>, stack: &mut MemStack) -> Result<(), usize> {
    let done = cholesky_in_place(
        diagonal,
        Default::default(),
        Par::Seq,
        stack,
        Default::default(),
    );
    done.map(|_| ())
        .map_err(|LltError::NonPositivePivot { index }| index)
}

/// target −= LLᵀ, lower triangle.
fn subtract_square(target: MatMut<'_, f64>, l: MatRef<'_, f64>) {
    triangular::matmul(
        target,
        BlockStructure::TriangularLower,
        Accum::Add,
        l,
        BlockStructure::Rectangular,
        l.transpose(),
        BlockStructure::Rectangular,
        -1.0,
        Par::Seq,
    );
}

/// The first columns, as many as the target has, of target −= LLᵀ on and below the diagonal, in blocks that threads share.
fn subtract_in_blocks(target: MatMut<'_, f64>, l: MatRef<'_, f64>) {
    let mut blocks = Vec::new();
    let (mut rest, mut start) = (target, 0);
    while rest.ncols() > 0 {
        let width = BLOCK.min(rest.ncols());
        let (block, next) = rest.split_at_col_mut(width);
        blocks.push((start, block));
        (rest, start) = (next, start + width);
    }
    blocks.into_par_iter().for_each(|(start, block)| {
        let width = block.ncols();
        let (_, block) = block.split_at_row_mut(start);
        let (diagonal, below) = block.split_at_row_mut(width);
        let own = l.subrows(start, width);
        subtract_square(diagonal, own);
        let others = l.subrows(start + width, l.nrows() - start - width);
        matmul(below, Accum::Add, others, own.transpose(), -1.0, Par::Seq);
    });
}
