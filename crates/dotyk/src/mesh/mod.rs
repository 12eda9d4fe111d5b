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

impl<const D: usize> Mesh<D> {
    /// Coordinates of the nodes.
    pub fn points(&self) -> &[Point<D>] {
        &self.points
    }

    /// Blocks of cells.
    pub fn blocks(&self) -> &[CellBlock] {
        &self.blocks
    }

    /// Facets of a side.
    pub fn side(&self, name: &str) -> Option<&[Facet]> {
        self.sides.get(name).map(Vec::as_slice)
    }

    /// Nodes of a facet: its ends, then its middle node.
    pub fn facet_nodes(&self, facet: Facet) -> Vec<u32> {
        let block = &self.blocks[facet.block as usize];
        let (corners, local) = (block.kind.corners(), facet.local as usize);
        let nodes = &block.nodes[facet.cell as usize * block.kind.nodes()..];
        let mut list = vec![nodes[local], nodes[(local + 1) % corners]];
        if block.kind.nodes() > corners {
            list.push(nodes[corners + local]);
        }
        list
    }

    /// Facets that belong to one cell only.
    pub fn boundary_facets(&self) -> Vec<Facet> {
        let mut count = BTreeMap::new();
        for (b, block) in self.blocks.iter().enumerate() {
            for (c, _) in block.cells().enumerate() {
                for local in 0..block.kind.corners() {
                    let facet = Facet {
                        block: b as u32,
                        cell: c as u32,
                        local: local as u32,
                    };
                    let nodes = self.facet_nodes(facet);
                    let key = (nodes[0].min(nodes[1]), nodes[0].max(nodes[1]));
                    count.entry(key).or_insert_with(Vec::new).push(facet);
                }
            }
        }
        count
            .into_values()
            .filter(|facets| facets.len() == 1)
            .flatten()
            .collect()
    }

    /// A mesh of its parts, unchecked.
    #[cfg(test)]
    pub(crate) fn from_parts(
        points: Vec<Point<D>>,
        blocks: Vec<CellBlock>,
        sides: BTreeMap<String, Vec<Facet>>,
    ) -> Self {
        Self {
            points,
            blocks,
            sides,
        }
    }
}
