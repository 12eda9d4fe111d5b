//! Interfaces: from two sides to rows B, initial gaps g₀ and weights, so that
//!
//! ```text
//!   gap = g₀ − B u ≥ 0,     (B u)ᵢ = nᵢ·(u_nonmortar − u_mortar),     pressure = λ / weight
//! ```
//!
//! n is the outward normal of the nonmortar side. λ is a force, the gap a length, the weight ∫ψ an area.
//! An interface knows the two meshes and what their supports hold, but no stiffness.

mod error;
mod facing;
mod node_to_node;
mod weights;

pub use error::ContactError;
pub use facing::{Unmatched, unmatched_facing};
pub use node_to_node::{matching_nodes, pair_nodes, pair_obstacle};
pub(crate) use weights::nodal_weights;

use crate::fem::{Body, Constraints};
use crate::geometry::{Field, Point};

/// One end of an interface: a side of a body, with what the body's supports hold.
#[derive(Clone, Copy)]
pub struct End<'a, const D: usize> {
    /// The body.
    pub body: &'a Body<D>,
    /// Name of the side.
    pub side: &'a str,
    /// Held directions of the body's nodes.
    pub constraints: &'a Constraints<D>,
}

impl<const D: usize> End<'_, D> {
    /// `body.side`, as in the case file.
    pub fn name(&self) -> String {
        format!("{}.{}", self.body.name, self.side)
    }
}

/// The initial gap of node pairs.
#[derive(Clone, Copy)]
pub enum InitialGap<'a> {
    /// Measured between the nodes along the normal.
    Measured,
    /// Zero.
    Closed,
    /// Given at the undeformed nonmortar point.
    Given(&'a Field),
}

/// What a node of the nonmortar side is to the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It carries the multiplier of this row.
    Multiplier(usize),
    /// Nothing is opposite.
    Alone,
    /// Its normal displacement is prescribed on both sides, or its condition follows from others.
    Fixed,
}

/// A node of the nonmortar side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterfaceNode<const D: usize> {
    /// Node of the nonmortar mesh.
    pub node: usize,
    /// Coincident node of the mortar mesh (node-to-node).
    pub partner: Option<usize>,
    /// Outward unit normal, after the projection onto what the supports leave free.
    pub normal: Point<D>,
    /// ∫ψ: an area, times thickness or 2πr.
    pub weight: f64,
    /// Initial gap; NaN where nothing is opposite.
    pub gap: f64,
    /// What it is to the interface.
    pub role: Role,
}

/// A row of B: coefficients of global displacement vectors at nodes.
pub type Row<const D: usize> = Vec<(usize, Point<D>)>;

/// Two sides, or a side and an obstacle, ready for condensation.
#[derive(Debug, Clone, PartialEq)]
pub struct Interface<const D: usize> {
    /// Nodes of the nonmortar side in the order of its chain.
    pub nodes: Vec<InterfaceNode<D>>,
    /// The chain closes on itself.
    pub cyclic: bool,
    /// Row of every multiplier on the nonmortar body.
    pub nonmortar: Vec<Row<D>>,
    /// Row of every multiplier on the mortar body (sign included); empty for an obstacle.
    pub mortar: Vec<Row<D>>,
}

impl<const D: usize> Interface<D> {
    /// Initial gap of every multiplier.
    pub fn gaps(&self) -> Vec<f64> {
        self.carriers().map(|node| node.gap).collect()
    }

    /// Takes rows away: their nodes become fixed, and the rows after them move up.
    pub fn drop_rows(&mut self, rows: &[usize]) {
        let mut kept = vec![true; self.nonmortar.len()];
        rows.iter().for_each(|&row| kept[row] = false);
        let mut next = 0;
        let place: Vec<Role> = kept
            .iter()
            .map(|&kept| {
                next += usize::from(kept);
                if kept {
                    Role::Multiplier(next - 1)
                } else {
                    Role::Fixed
                }
            })
            .collect();
        for node in &mut self.nodes {
            if let Role::Multiplier(row) = node.role {
                node.role = place[row];
            }
        }
        for side in [&mut self.nonmortar, &mut self.mortar] {
            let mut kept = kept.iter();
            side.retain(|_| kept.next().copied().unwrap_or(true));
        }
    }

    /// The nodes that carry multipliers, in the order of the rows.
    pub fn carriers(&self) -> impl Iterator<Item = &InterfaceNode<D>> {
        self.nodes
            .iter()
            .filter(|node| matches!(node.role, Role::Multiplier(_)))
    }
}
