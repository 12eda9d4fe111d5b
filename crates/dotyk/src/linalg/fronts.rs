//! The numbers of a sparse Cholesky factor, front by front.
//!
//! A supernode has n columns J and m rows R below them. With what its children in the elimination tree leave, its front is
//!
//! ```text
//!   [ F_JJ      ]         [ A_JJ   ]                      F_JJ = L_JJ L_JJᵀ      L_RJ = F_RJ L_JJ⁻ᵀ
//!   [ F_RJ  F_RR]   =     [ A_RJ  0]  +  Σ U_child        U = F_RR − L_RJ L_RJᵀ
//! ```
//!
//! where U, of which only the lower triangle is formed, is what the supernode leaves to its parent, the supernode of its first row
//! below. [L_JJ; L_RJ] is its part of the factor.
//!
//! Subtrees know nothing of each other and are eliminated side by side, and so are blocks of large fronts. Every front is the
//! same sum in the same order whoever forms it and when: the same bits on any number of threads. Memory beside the factor: what
//! is left to fronts that are not formed yet, 6 % of the factor for bodies in the plane and 25 % in space on one thread; children
//! are taken in the order that keeps it low (Liu 1986).
//!
//! Sources: I. S. Duff, J. K. Reid, The multifrontal solution of indefinite sparse symmetric linear equations, ACM Trans.
//! Math. Softw. 9 (1983) 302–325; J. W. H. Liu, On the storage requirement in the out-of-core multifrontal method, ACM Trans.
//! Math. Softw. 12 (1986) 249–264.

use dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{self as dense, LltError};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::AcqRel};

/// Columns of an update that are formed and stored together.
const WIDTH: usize = 512;

/// Lower triangles up to this size are formed by strips of so many columns, larger ones by recursion.
const FEW: usize = 192;
const STRIP: usize = 32;

/// Rows of a front that one task solves for.
const ROWS: usize = 256;

/// Subtrees with fewer operations than this part of the whole are eliminated by one task.
const TASKS: f64 = 64.0;

/// Fronts with more operations than this are shared among threads; so is the dense factor of more columns than this.
const LARGE: f64 = 1e8;
const WIDE: usize = 512;
const SHARES: usize = 4;

/// Numbers on a page of memory.
const PAGE: usize = 512;

const NONE: u32 = u32::MAX;

/// The tree of the supernodes.
#[derive(Debug)]
pub(super) struct Tree {
    parent: Vec<u32>,
    /// Children of each supernode, in the order in which they are eliminated.
    children: Vec<Vec<u32>>,
    /// Supernodes, children before parents, each subtree together.
    order: Vec<u32>,
    /// Subtrees for one task, as ranges of `order`, and the most that is left at a time to supernodes of one that are not formed yet.
    tasks: Vec<(Range<usize>, usize)>,
    /// Whether an even number of supernodes is above each.
    is_even: Vec<bool>,
    /// Supernodes without children that are too large for such a task.
    tips: Vec<u32>,
    /// The most numbers that are left at a time by supernodes whose parents are not formed yet, on one thread.
    most: usize,
}

/// Rows and columns of a supernode.
#[derive(Clone, Copy)]
struct Shape<'a> {
    begin: usize,
    end: usize,
    below: &'a [u32],
}

impl<'a> Shape<'a> {
    fn of(symbolic: &'a SymbolicSupernodalCholesky<u32>, s: usize) -> Self {
        Self {
            begin: symbolic.supernode_begin()[s] as usize,
            end: symbolic.supernode_end()[s] as usize,
            below: symbolic.supernode(s).pattern(),
        }
    }

    fn columns(&self) -> usize {
        self.end - self.begin
    }

    fn operations(&self) -> f64 {
        let [n, m] = [self.columns(), self.below.len()].map(|k| k as f64);
        n * (n * n / 3.0 + m * n + m * m)
    }

    /// Its rows below that are columns of its parent.
    fn own_of(&self, parent: &Self) -> usize {
        self.below
            .partition_point(|&row| (row as usize) < parent.end)
    }
}

impl Tree {
    pub fn of(symbolic: &SymbolicSupernodalCholesky<u32>) -> Self {
        let count = symbolic.n_supernodes();
        let shape = |s: usize| Shape::of(symbolic, s);
        let ends = symbolic.supernode_end();
        let parent = |s: usize| match shape(s).below.first() {
            Some(&row) => ends.partition_point(|&end| end <= row) as u32,
            None => NONE,
        };
        let parent: Vec<u32> = (0..count).map(parent).collect();
        let mut children = vec![Vec::new(); count];
        let mut whole: Vec<f64> = (0..count).map(|s| shape(s).operations()).collect();
        let mut size = vec![1; count];
        let left = |s: u32| Packed(shape(s as usize).below.len()).len();
        // the most that is kept at a time while a subtree is eliminated
        let mut peak = vec![0; count];
        for s in 0..count {
            let own: &mut Vec<u32> = &mut children[s];
            own.sort_by_key(|&child| left(child) as i64 - peak[child as usize] as i64);
            let (mut most, mut kept) = (0, 0);
            for &child in &*own {
                most = most.max(kept + peak[child as usize]);
                kept += left(child);
            }
            peak[s] = most.max(kept + left(s as u32));
            if let Some(above) = children.get_mut(parent[s] as usize) {
                above.push(s as u32);
                whole[parent[s] as usize] += whole[s];
                size[parent[s] as usize] += size[s];
            }
        }
        let order = postorder(&parent, &children);
        let is_root = |s: usize| parent[s] == NONE;
        let mut is_even = vec![true; count];
        for s in (0..count).rev().filter(|&s| !is_root(s)) {
            is_even[s] = !is_even[parent[s] as usize];
        }
        let share = operations(symbolic) / TASKS;
        let small = |s: usize| whole[s] <= share;
        let alone = |s: usize| small(s) && (is_root(s) || !small(parent[s] as usize));
        let tasks = order.iter().enumerate().filter_map(|(place, &s)| {
            let s = s as usize;
            alone(s).then(|| (place + 1 - size[s]..place + 1, peak[s]))
        });
        let tips = (0..count).filter(|&s| !small(s) && children[s].is_empty());
        Self {
            tasks: tasks.collect(),
            tips: tips.map(|s| s as u32).collect(),
            is_even,
            parent,
            children,
            order,
            most: peak.into_iter().max().unwrap_or(0),
        }
    }

    /// The most numbers that are kept beside the factor at a time, on one thread.
    pub fn most_left(&self) -> usize {
        self.most
    }
}

/// Operations of a factorisation.
pub(super) fn operations(symbolic: &SymbolicSupernodalCholesky<u32>) -> f64 {
    let all = 0..symbolic.n_supernodes();
    all.map(|s| Shape::of(symbolic, s).operations()).sum()
}

/// Children before parents.
fn postorder(parent: &[u32], children: &[Vec<u32>]) -> Vec<u32> {
    let mut order = Vec::with_capacity(parent.len());
    let mut path: Vec<(u32, usize)> = Vec::new();
    for root in (0..parent.len()).filter(|&s| parent[s] == NONE) {
        path.push((root as u32, 0));
        while let Some((s, next)) = path.last_mut() {
            match children[*s as usize].get(*next) {
                Some(&child) => {
                    *next += 1;
                    path.push((child, 0));
                }
                None => {
                    order.push(*s);
                    path.pop();
                }
            }
        }
    }
    order
}

/// Lower triangle of a symmetric matrix of this size, by blocks of [`WIDTH`] columns: each block full, from its first row down.
#[derive(Clone, Copy)]
struct Packed(usize);

impl Packed {
    fn len(self) -> usize {
        self.start(self.0)
    }

    /// Where a column begins: its block's first row.
    fn start(self, column: usize) -> usize {
        // Σ (m − c) over the columns of whole blocks, c the first column of each
        let blocks = column / WIDTH;
        let whole =
            WIDTH * blocks * self.0 - WIDTH * WIDTH * (blocks * blocks.saturating_sub(1) / 2);
        whole + column % WIDTH * (self.0 - WIDTH * blocks)
    }

    /// A column from the first row of its block down, and that row.
    fn column(self, j: usize) -> (Range<usize>, usize) {
        let first = j / WIDTH * WIDTH;
        let start = self.start(j);
        (start..start + self.0 - first, first)
    }
}

/// A factorisation on its way.
struct Elimination<'a> {
    symbolic: &'a SymbolicSupernodalCholesky<u32>,
    tree: &'a Tree,
    matrix: SparseColMatRef<'a, u32, f64>,
    fronts: Vec<Front<'a>>,
    spare: Mutex<Vec<f64>>,
    /// The least column whose pivot was found not positive.
    failed: AtomicUsize,
}

struct Front<'a> {
    /// Its part of the factor.
    panel: Mutex<&'a mut [f64]>,
    /// What it leaves to its parent; `None` if it failed.
    left: Mutex<Option<Vec<f64>>>,
    /// Children that are not done.
    waits: AtomicUsize,
}

/// The factor of a matrix given by the columns of its lower triangle, rows ascending.
///
/// Errors: the least of the columns whose pivots were found not positive, the same on any number of threads.
pub(super) fn factor(
    symbolic: &SymbolicSupernodalCholesky<u32>,
    tree: &Tree,
    matrix: SparseColMatRef<'_, u32, f64>,
) -> Result<Vec<f64>, usize> {
    let mut values = vec![0.0; symbolic.len_val()];
    let mut rest = &mut values[..];
    let starts = symbolic.col_ptr_for_val().windows(2);
    let fronts = starts.zip(&tree.children).map(|(ends, children)| {
        let length = (ends[1] - ends[0]) as usize;
        let (panel, after) = std::mem::take(&mut rest).split_at_mut(length);
        rest = after;
        Front {
            panel: Mutex::new(panel),
            left: Mutex::new(None),
            waits: AtomicUsize::new(children.len()),
        }
    });
    let elimination = Elimination {
        symbolic,
        tree,
        matrix,
        fronts: fronts.collect(),
        spare: Mutex::new(Vec::new()),
        failed: AtomicUsize::new(usize::MAX),
    };
    elimination.run();
    match elimination.failed.into_inner() {
        usize::MAX => Ok(values),
        column => Err(column),
    }
}

impl Elimination<'_> {
    fn run(&self) {
        rayon::scope(|scope| {
            for &tip in &self.tree.tips {
                scope.spawn(move |scope| self.upwards(scope, tip));
            }
            // a thread takes what it was given last first
            for task in self.tree.tasks.iter().rev() {
                scope.spawn(move |scope| {
                    self.subtree(task);
                    self.done(scope, self.tree.order[task.0.end - 1]);
                });
            }
        });
    }

    fn shape(&self, s: u32) -> Shape<'_> {
        Shape::of(self.symbolic, s as usize)
    }

    fn fail(&self, column: usize) {
        self.failed.fetch_min(column, AcqRel);
    }

    /// Goes on with the parent of a supernode if that was its last child.
    fn done<'s>(&'s self, scope: &rayon::Scope<'s>, s: u32) {
        let Some(parent) = self.fronts.get(self.tree.parent[s as usize] as usize) else {
            return;
        };
        if parent.waits.fetch_sub(1, AcqRel) == 1 {
            let parent = self.tree.parent[s as usize];
            scope.spawn(move |scope| self.upwards(scope, parent));
        }
    }

    /// Eliminates a supernode whose children are done.
    fn upwards<'s>(&'s self, scope: &rayon::Scope<'s>, s: u32) {
        let children = &self.tree.children[s as usize];
        let left = children.iter().map(|&child| {
            let mut left = lock(&self.fronts[child as usize].left);
            Some((child, left.take()?))
        });
        // one that failed leaves nothing
        if let Some(left) = left.collect::<Option<Vec<_>>>() {
            let own = Packed(self.shape(s).below.len()).len();
            let mut update = self.spare(own);
            let parts: Vec<(u32, &[f64])> = left.iter().map(|(s, left)| (*s, &left[..])).collect();
            match self.eliminate(s, &parts, &mut update[..own], &mut Scratch::default()) {
                Ok(()) => *lock(&self.fronts[s as usize].left) = Some(update),
                Err(column) => self.fail(column),
            }
            self.keep_largest(left.into_iter().map(|(_, left)| left));
        }
        self.done(scope, s);
    }

    /// Memory that was used before, so that it need not be got from the system anew.
    fn spare(&self, length: usize) -> Vec<f64> {
        let spare = std::mem::take(&mut *lock(&self.spare));
        match spare.len() >= length {
            true => spare,
            false => vec![0.0; length],
        }
    }

    /// Keeps the largest of what is no longer needed, and gives the others back.
    fn keep_largest(&self, unused: impl Iterator<Item = Vec<f64>>) {
        if let Some(largest) = unused.max_by_key(Vec::len) {
            let mut spare = lock(&self.spare);
            if spare.len() < largest.len() {
                *spare = largest;
            }
        }
    }

    /// Eliminates a subtree by one thread.
    ///
    /// What supernodes of even and of odd depth leave stands on two stacks: that of the children of a supernode is on top of one of
    /// them when it puts its own on the other.
    fn subtree(&self, (places, most): &(Range<usize>, usize)) {
        let mut scratch = Scratch::default();
        let mut stacks = [(); 2].map(|()| Stack {
            memory: vec![0.0; *most],
            used: 0,
        });
        for &s in &self.tree.order[places.clone()] {
            let [even, odd] = &mut stacks;
            let (own, other) = match self.tree.is_even[s as usize] {
                true => (even, odd),
                false => (odd, even),
            };
            let size = |s: u32| Packed(self.shape(s).below.len()).len();
            let children = &self.tree.children[s as usize];
            let below: usize = children.iter().map(|&child| size(child)).sum();
            let mut rest = other.top(below);
            let parts = children.iter().map(|&child| {
                let (part, after) = rest.split_at(size(child));
                rest = after;
                (child, part)
            });
            let parts: Vec<(u32, &[f64])> = parts.collect();
            if let Err(column) = self.eliminate(s, &parts, own.push(size(s)), &mut scratch) {
                self.fail(column);
                return;
            }
            other.used -= below;
        }
        let top = self.tree.order[places.end - 1] as usize;
        let [even, odd] = stacks;
        let left = if self.tree.is_even[top] { even } else { odd };
        *lock(&self.fronts[top].left) = Some(left.memory[..left.used].to_vec());
    }

    /// Forms the front of a supernode from what its children leave, and its parts of the factor and of what is left.
    fn eliminate(
        &self,
        s: u32,
        parts: &[(u32, &[f64])],
        update: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), usize> {
        let shape = self.shape(s);
        let (n, m) = (shape.columns(), shape.below.len());
        let rows = n + m;
        let mut panel = lock(&self.fronts[s as usize].panel);
        if rows > PAGE {
            // written before it is read, or the system would map each page twice
            panel.fill(0.0);
        }
        self.put_matrix(&shape, &mut panel);
        scratch.places.clear();
        for &(child, part) in parts {
            let child = self.shape(child);
            let first = scratch.places.len();
            places(&child, &shape, &mut scratch.places);
            let packed = Packed(child.below.len());
            for j in 0..child.own_of(&shape) {
                let (column, start) = packed.column(j);
                let places = &scratch.places[first..];
                let to = &mut panel[places[j] as usize * rows..][..rows];
                add(&part[column][j - start..], &places[j..], 0, to);
            }
        }
        let is_large = shape.operations() > LARGE;
        let panel = MatMut::from_column_major_slice_mut(&mut panel, rows, n);
        let (mut corner, mut rest) = panel.split_at_row_mut(n);
        let threads = match is_large && n > WIDE {
            true => Par::rayon(SHARES),
            false => Par::Seq,
        };
        scratch
            .factor(corner.as_mut(), threads)
            .map_err(|column| shape.begin + column)?;
        if m == 0 {
            return Ok(());
        }
        let corner = corner.as_ref();
        let solve = |rows: MatMut<'_, f64>| {
            solve_lower_triangular_in_place(corner, rows.transpose_mut(), Par::Seq);
        };
        match is_large {
            true => rest.as_mut().par_row_chunks_mut(ROWS).for_each(solve),
            false => solve(rest.as_mut()),
        }
        leave(rest.as_ref(), update, is_large);
        let mut places = &scratch.places[..];
        for &(child, part) in parts {
            let child = self.shape(child);
            let (own, after) = places.split_at(child.below.len());
            places = after;
            pass_on(&child, child.own_of(&shape), part, (own, n), (m, update));
        }
        Ok(())
    }

    /// Entries of the matrix into a front.
    fn put_matrix(&self, shape: &Shape<'_>, panel: &mut [f64]) {
        let (n, rows) = (shape.columns(), shape.columns() + shape.below.len());
        for (j, to) in panel.chunks_exact_mut(rows).enumerate() {
            let column = shape.begin + j;
            let entries = self.matrix.row_idx_of_col_raw(column).iter();
            let mut below = 0;
            for (&row, value) in entries.zip(self.matrix.val_of_col(column)) {
                let place = if (row as usize) < shape.end {
                    row as usize - shape.begin
                } else {
                    below += shape.below[below..].partition_point(|&other| other < row);
                    n + below
                };
                to[place] = *value;
            }
        }
    }
}

/// Rows below a child as rows of the front of its parent.
fn places(child: &Shape<'_>, parent: &Shape<'_>, places: &mut Vec<u32>) {
    let n = parent.columns();
    let mut below = 0;
    places.extend(child.below.iter().map(|&row| {
        if (row as usize) < parent.end {
            return row - parent.begin as u32;
        }
        while parent.below[below] < row {
            below += 1;
        }
        (n + below) as u32
    }));
}

/// Adds values to the rows `places`, the first of which is `first`.
fn add(values: &[f64], places: &[u32], first: usize, to: &mut [f64]) {
    for (value, &place) in values.iter().zip(places) {
        to[place as usize - first] += value;
    }
}

/// −L_RJ L_RJᵀ.
fn leave(l: MatRef<'_, f64>, update: &mut [f64], is_large: bool) {
    let m = l.nrows();
    let block = |(k, to): (usize, &mut [f64])| {
        let first = k * WIDTH;
        let (height, width) = (m - first, WIDTH.min(m - first));
        let to = MatMut::from_column_major_slice_mut(to, height, width);
        let (corner, below) = to.split_at_row_mut(width);
        let (own, others) = l.subrows(first, height).split_at_row(width);
        lower_product(corner, own);
        matmul(
            below,
            Accum::Replace,
            others,
            own.transpose(),
            -1.0,
            Par::Seq,
        );
    };
    let mut rest = update;
    let blocks = (0..m).step_by(WIDTH).map(|first| {
        let size = (m - first) * WIDTH.min(m - first);
        let (block, after) = std::mem::take(&mut rest).split_at_mut(size);
        rest = after;
        block
    });
    let blocks = blocks.enumerate();
    match is_large {
        true => blocks.collect::<Vec<_>>().into_par_iter().for_each(block),
        false => blocks.for_each(block),
    }
}

/// Lower triangle of −L Lᵀ; above it anything.
fn lower_product(mut to: MatMut<'_, f64>, l: MatRef<'_, f64>) {
    let m = l.nrows();
    if m > FEW {
        let full = BlockStructure::Rectangular;
        let lower = BlockStructure::TriangularLower;
        let right = l.transpose();
        triangular::matmul(
            to,
            lower,
            Accum::Replace,
            l,
            full,
            right,
            full,
            -1.0,
            Par::Seq,
        );
        return;
    }
    for first in (0..m).step_by(STRIP) {
        let (height, width) = (m - first, STRIP.min(m - first));
        let strip = to.as_mut().submatrix_mut(first, first, height, width);
        let l = l.subrows(first, height);
        let right = l.subrows(0, width).transpose();
        matmul(strip, Accum::Replace, l, right, -1.0, Par::Seq);
    }
}

/// Adds what a child leaves beyond the columns of the front to what that leaves.
fn pass_on(
    child: &Shape<'_>,
    own: usize,
    part: &[f64],
    (places, n): (&[u32], usize),
    (m, update): (usize, &mut [f64]),
) {
    let packed = Packed(child.below.len());
    for j in own..child.below.len() {
        let (from, start) = packed.column(j);
        let (to, first) = Packed(m).column(places[j] as usize - n);
        add(
            &part[from][j - start..],
            &places[j..],
            n + first,
            &mut update[to],
        );
    }
}

/// Memory that is used from its beginning.
struct Stack {
    memory: Vec<f64>,
    used: usize,
}

impl Stack {
    fn top(&self, length: usize) -> &[f64] {
        &self.memory[self.used - length..self.used]
    }

    fn push(&mut self, length: usize) -> &mut [f64] {
        let start = self.used;
        self.used += length;
        &mut self.memory[start..self.used]
    }
}

#[derive(Default)]
struct Scratch {
    /// Rows below each child as rows of the front, one child behind the other.
    places: Vec<u32>,
    /// Of the dense factor, and the columns it suffices for.
    memory: Option<(MemBuffer, usize)>,
}

impl Scratch {
    /// Errors: the first column whose pivot is not positive.
    fn factor(&mut self, matrix: MatMut<'_, f64>, threads: Par) -> Result<(), usize> {
        let n = matrix.ncols();
        let enough = |(_, columns): &(MemBuffer, usize)| *columns >= n;
        if !self.memory.as_ref().is_some_and(enough) {
            let need = dense::cholesky_in_place_scratch::<f64>(n, threads, Default::default());
            self.memory = Some((MemBuffer::new(need), n));
        }
        let mut none = MemBuffer::new(dyn_stack::StackReq::EMPTY);
        let memory = self.memory.as_mut().map_or(&mut none, |(memory, _)| memory);
        let stack = MemStack::new(memory);
        dense::cholesky_in_place(
            matrix,
            Default::default(),
            threads,
            stack,
            Default::default(),
        )
        .map(|_| ())
        .map_err(|LltError::NonPositivePivot { index }| index)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}
