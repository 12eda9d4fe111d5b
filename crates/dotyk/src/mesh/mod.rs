//! Meshes: points, cell blocks, named sides.

mod cell;
mod generate;

pub use cell::{CellKind, FacetKind};
pub use generate::{Diagonals, Rectangle, Ring, TunnelRock};

use crate::geometry::Point;
use std::collections::BTreeMap;

/// Cells of one kind, and of one group when the mesh file names groups.
#[derive(Debug, Clone, PartialEq)]
pub struct CellBlock {
    /// Kind of all cells of the block.
    pub kind: CellKind,
    /// Node indices, `kind.nodes()` per cell.
    pub nodes: Vec<u32>,
    /// Name of the group, for materials.
    pub group: Option<String>,
}

impl CellBlock {
    /// Nodes of each cell.
    pub fn cells(&self) -> std::slice::ChunksExact<'_, u32> {
        self.nodes.chunks_exact(self.kind.nodes())
    }
}

/// A facet: the `local`-th facet of a cell of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// Index of the block.
    pub block: u32,
    /// Index of the cell in its block.
    pub cell: u32,
    /// Index into `kind.facets()`.
    pub local: u32,
}

/// A finite-element mesh with named sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh<const D: usize> {
    points: Vec<Point<D>>,
    blocks: Vec<CellBlock>,
    sides: BTreeMap<String, Vec<Facet>>,
}
