//! Sparse matrices, orderings and factorisations; the only module that names the linear-algebra library.
//!
//! A body's stiffness is gathered from its cell matrices ([`assemble_blocks`] on a [`Graph`]), its nodes are
//! ordered ([`fill_reducing_order`]), and it is factored once ([`SymbolicCholesky`], [`Cholesky`]); with
//! the contact dofs last the trailing block of the factor is the factor of the stiffness seen from the contact.
//! The dense functions serve the small problems on the contact. Public are the parts needed to assemble, factor and condense a
//! body elsewhere: matrices, orderings, factors and the products of dense matrices; not the decompositions of dense matrices.
//!
//! Invariant: the same bits for any number of threads. Kernels are sequential; threads take disjoint blocks and subtrees whose
//! borders depend on the problem alone. The operators of [`Mat`] (`&a * &b`) choose threads by themselves: use
//! [`product()`] and its relatives instead.
//!
//! Units are those of the caller. Indices are stored as `u32`: at most 2³¹ entries in a matrix or a factor.

mod cholesky;
mod condensed;
mod degree;
pub(crate) mod dense;
mod dissection;
mod elimination;
mod fronts;
mod glued;
mod gram;
mod order;
mod reached;
pub(crate) mod signed;
mod sparse;
mod sparse_lu;

use crate::host::Team;
pub use cholesky::{Cholesky, SymbolicCholesky};
pub use dense::{Lu, gram, product, transpose_product};
pub use faer::Mat;
pub use order::{expand_to_dofs, fill_reducing_order};
pub use sparse::{
    CellMatrices, Connectivity, Graph, SparseMatrix, SparseVector, SymmetricMatrix, assemble_blocks,
};

pub(crate) use condensed::Piece;
pub(crate) use dense::{least_squares, null_space, pivoted_cholesky, solve_lower_in_place};
use elimination::elimination_order;
pub(crate) use elimination::{analyse, factor_scattered, ground, some_of_node};
pub(crate) use glued::{Divided, Glued};
pub(crate) use gram::WeightedGram;
pub(crate) use reached::Reached;
pub(crate) use sparse_lu::SparseLu;

/// A symmetric linear map of vectors of length `len`, in the units of the caller.
pub trait LinearOperator: Send + Sync {
    /// Length of its vectors.
    fn len(&self) -> usize;
    /// Whether its vectors are empty.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// y = Ax. Shapes: both (len,); y is overwritten.
    fn apply(&self, x: &[f64], y: &mut [f64]);
    /// AX. Shapes: both (len, n). For operators for which many columns together are cheaper than one by one.
    fn apply_many(&self, x: &Mat<f64>) -> Mat<f64> {
        let mut y = Mat::zeros(self.len(), x.ncols());
        for j in 0..x.ncols() {
            self.apply(x.col_as_slice(j), y.col_as_slice_mut(j));
        }
        y
    }
}

/// Why a matrix could not be factored or a system not be solved. Numbers of dofs are the caller's, not permuted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LinalgError {
    /// A pivot is zero or negative.
    #[error(
        "the matrix is not positive definite at dof {dof}: check the supports and the material"
    )]
    NotPositiveDefinite {
        /// The dof of the pivot.
        dof: usize,
    },
    /// The energy of some displacement is not distinguishable from rounding.
    #[error(
        "the matrix is singular to working precision (relative energy {ratio:.1e} at dof {dof}): part of the body can move freely, check its supports and joints"
    )]
    NearlySingular {
        /// The dof of the smallest relative pivot.
        dof: usize,
        /// uᵀAu / Σ aᵢᵢuᵢ² of the free displacement u.
        ratio: f64,
    },
    /// An entry is infinite or NaN.
    #[error(
        "an entry in row {row} of the matrix is not finite: check the coordinates and the data"
    )]
    NotFinite {
        /// The row.
        row: usize,
    },
    /// The elimination order names a dof twice, or one that the matrix does not have.
    #[error(
        "the elimination order is invalid at dof {dof}: name each dof of the matrix at most once"
    )]
    InvalidOrder {
        /// The dof.
        dof: usize,
    },
    /// The matrix has another size or pattern than the analysed one, or a wrong number of entries is given.
    #[error("{found} entries where {expected} are expected: analyse this matrix first")]
    WrongPattern {
        /// Number of entries expected.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// More entries than the indices can count, or than the memory holds.
    #[error(
        "the problem of {unknowns} unknowns is too large for a direct factorisation: use a coarser mesh"
    )]
    TooLarge {
        /// Number of unknowns.
        unknowns: usize,
    },
    /// A dense system has no unique solution.
    #[error("the system of equations is singular at column {column}")]
    Singular {
        /// The column of the vanishing pivot.
        column: usize,
    },
    /// A spectral decomposition did not converge.
    #[error("the spectral decomposition of a ({rows}, {columns}) matrix did not converge")]
    NoConvergence {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
}

impl LinalgError {
    /// The same with the dof of a whole for each dof of a part.
    pub(crate) fn at(self, of_whole: impl Fn(usize) -> usize) -> Self {
        match self {
            Self::NotPositiveDefinite { dof } => Self::NotPositiveDefinite { dof: of_whole(dof) },
            Self::NearlySingular { dof, ratio } => Self::NearlySingular {
                dof: of_whole(dof),
                ratio,
            },
            Self::NotFinite { row } => Self::NotFinite { row: of_whole(row) },
            other => other,
        }
    }

    /// As numbers: its kind, and what it tells.
    fn coded(self) -> [f64; 3] {
        let (kind, told, other) = match self {
            Self::NotPositiveDefinite { dof } => (0, dof, 0.0),
            Self::NearlySingular { dof, ratio } => (1, dof, ratio),
            Self::NotFinite { row } => (2, row, 0.0),
            Self::InvalidOrder { dof } => (3, dof, 0.0),
            Self::WrongPattern { expected, found } => (4, expected, found as f64),
            Self::TooLarge { unknowns } => (5, unknowns, 0.0),
            Self::Singular { column } => (6, column, 0.0),
            Self::NoConvergence { rows, columns } => (7, rows, columns as f64),
        };
        [f64::from(kind), told as f64, other]
    }

    fn decoded([kind, told, other]: [f64; 3]) -> Self {
        let (dof, found) = (told as usize, other as usize);
        match kind as usize {
            0 => Self::NotPositiveDefinite { dof },
            1 => Self::NearlySingular { dof, ratio: other },
            2 => Self::NotFinite { row: dof },
            3 => Self::InvalidOrder { dof },
            4 => Self::WrongPattern {
                expected: dof,
                found,
            },
            5 => Self::TooLarge { unknowns: dof },
            6 => Self::Singular { column: dof },
            _ => Self::NoConvergence {
                rows: dof,
                columns: found,
            },
        }
    }
}

/// What a process has, unless another one has met an error: then all have the error of the first that has.
fn agreed<T>(team: &dyn Team, own: Result<T, LinalgError>) -> Result<T, LinalgError> {
    let (own, told) = match own {
        Ok(own) => (Some(own), Vec::new()),
        Err(error) => (None, error.coded().to_vec()),
    };
    match (team.join("errors", told).first_chunk(), own) {
        (Some(told), _) => Err(LinalgError::decoded(*told)),
        (None, Some(own)) => Ok(own),
        // a process with an error has told it
        (None, None) => Err(LinalgError::TooLarge { unknowns: 0 }),
    }
}

/// Elastic grids for the tests of this module.
#[cfg(test)]
pub(crate) mod grid {
    use crate::linalg::{CellMatrices, Graph, SymmetricMatrix, assemble_blocks};

    /// Packed lower triangle of the plane-strain stiffness of a linear triangle, E = 1, ν = 0.3.
    pub fn triangle(x: [[f64; 2]; 3]) -> Vec<f64> {
        let (lame, shear) = (0.3 / (1.3 * 0.4), 0.5 / 1.3);
        let twice_area =
            (x[1][0] - x[0][0]) * (x[2][1] - x[0][1]) - (x[2][0] - x[0][0]) * (x[1][1] - x[0][1]);
        let gradient: Vec<[f64; 2]> = (0..3)
            .map(|a| {
                let (b, c) = (x[(a + 1) % 3], x[(a + 2) % 3]);
                [(b[1] - c[1]) / twice_area, (c[0] - b[0]) / twice_area]
            })
            .collect();
        let mut packed = Vec::new();
        for row in 0..6 {
            for column in 0..=row {
                let (a, i, b, j) = (row / 2, row % 2, column / 2, column % 2);
                let (g, h) = (gradient[a], gradient[b]);
                let trace = if i == j {
                    g[0] * h[0] + g[1] * h[1]
                } else {
                    0.0
                };
                let value = lame * g[i] * h[j] + shear * (g[j] * h[i] + trace);
                packed.push(0.5 * twice_area * value);
            }
        }
        packed
    }

    /// Cells of nx × ny squares of side 1, each cut in two; node (i, j) is j(nx + 1) + i.
    pub fn cells(nx: usize, ny: usize) -> Vec<u32> {
        let node = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
        let mut nodes = Vec::new();
        for j in 0..ny {
            for i in 0..nx {
                nodes.extend([node(i, j), node(i + 1, j), node(i + 1, j + 1)]);
                nodes.extend([node(i, j), node(i + 1, j + 1), node(i, j + 1)]);
            }
        }
        nodes
    }

    /// Cell matrices that go with [`cells`].
    pub fn stiffness(nx: usize, ny: usize) -> Vec<f64> {
        let lower = triangle([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        let upper = triangle([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let pair = [lower, upper].concat();
        pair.repeat(nx * ny)
    }

    /// Graph and unsupported stiffness of the grid.
    pub fn body(nx: usize, ny: usize) -> (Graph, SymmetricMatrix) {
        let (nodes, values) = (cells(nx, ny), stiffness(nx, ny));
        let block = CellMatrices {
            nodes: &nodes,
            nodes_per_cell: 3,
            values: &values,
        };
        let graph = Graph::from_cells((nx + 1) * (ny + 1), &[block.connectivity()]);
        let matrix = assemble_blocks::<2>(&graph, &[block]).unwrap();
        (graph, matrix)
    }

    /// Dofs that remain when the left edge is clamped, by dof.
    pub fn clamped_left(nx: usize, ny: usize) -> Vec<bool> {
        (0..(nx + 1) * (ny + 1))
            .flat_map(|node| [node % (nx + 1) != 0; 2])
            .collect()
    }

    /// Repeatable numbers in (−1, 1) without a pattern.
    pub fn noise(length: usize) -> Vec<f64> {
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        (0..length).map(|_| next()).collect()
    }

    /// Runs on a pool of that many threads.
    pub fn on_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(run)
    }
}
