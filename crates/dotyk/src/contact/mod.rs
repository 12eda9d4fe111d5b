//! Interfaces: from two sides to rows B, initial gaps g₀ and weights, so that
//!
//! ```text
//!   gap = g₀ − B u ≥ 0,     (B u)ᵢ = ∫ψᵢ n·(u_nonmortar − u_mortar) / ∫ψᵢ,     pressure = λ / weight,  weight = ∫ψᵢ
//! ```
//!
//! n is the outward normal of the nonmortar side. λ is a force, the gap a length, the weight an area. Node-to-node
//! pairing is the same with the integrals replaced by values at nodes. Tangential rows have t instead of n and no gap.
//! An interface knows the two meshes and what their supports hold, but no stiffness.

mod corners;
mod curved;
mod error;
mod facing;
mod mortar;
mod node_to_node;
mod normals;
mod sampling;
mod search;
mod weights;

pub use corners::smooth_parts;
pub use curved::{sagitta, straight_turn};
pub use error::ContactError;
pub use facing::{facets_coincide, unmatched_facing};
pub use mortar::{Against, pair_mortar};
pub use node_to_node::{Driven, Rigid, pair_nodes, pair_obstacle};
pub use sampling::{Sample, samples};

use crate::fem::{Body, Constraints};
use crate::geometry::{Field, Point};
use crate::mesh::Facet;

/// Which components of the displacement jump an interface couples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// The normal one.
    Normal,
    /// The normal one, and with it the tangential ones.
    Frictional,
    /// All, each by itself.
    Tied,
}

/// One end of an interface: a side of a body, with what the body's supports hold.
#[derive(Clone, Copy)]
pub struct End<'a, const D: usize> {
    /// The body.
    pub body: &'a Body<D>,
    /// Name of the side.
    pub side: &'a str,
    /// Held directions of the body's nodes.
    pub constraints: &'a Constraints<D>,
    /// These facets of the side alone.
    pub part: Option<&'a [Facet]>,
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
    /// It carries multipliers.
    Multiplier,
    /// Nothing is opposite.
    Alone,
    /// Its displacement is prescribed (node-to-node: on both sides), or its condition follows from others.
    Fixed,
}

/// A node of the nonmortar side.
#[derive(Debug, Clone, PartialEq)]
pub struct InterfaceNode<const D: usize> {
    /// Node of the nonmortar mesh.
    pub node: usize,
    /// Nodes of the mortar mesh and their shape functions at the point opposite; empty where there is none.
    pub opposite: Vec<(usize, f64)>,
    /// Outward unit normal, after the projection onto what the supports leave free.
    pub normal: Point<D>,
    /// ∫ψ: an area, times thickness or 2πr.
    pub weight: f64,
    /// The part of the side that the multiplier stands for: a length (in space an area) without thickness or 2πr.
    pub extent: f64,
    /// Initial gap, ∫ψ s/∫ψ; NaN where nothing is opposite.
    pub gap: f64,
    /// Initial gap at the node itself: between the surfaces, or as given. NaN where nothing is opposite.
    pub clearance: f64,
    /// What it is to the interface.
    pub role: Role,
    /// Rows of its multipliers: normal, then tangential.
    pub rows: [Option<usize>; D],
}

impl<const D: usize> InterfaceNode<D> {
    /// The coincident node of the mortar mesh.
    pub fn partner(&self) -> Option<usize> {
        match self.opposite[..] {
            [(node, _)] => Some(node),
            _ => None,
        }
    }
}

/// The unit vectors in which a contact node's forces are counted: its normal, then the tangents (in the plane the normal
/// turned by +90°).
pub fn frame<const D: usize>(normal: Point<D>) -> [Point<D>; D] {
    let mut frame = [normal; D];
    if D == 2 {
        (frame[1][0], frame[1][1]) = (-normal[1], normal[0]);
    }
    frame
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
    /// What the rows couple.
    pub coupling: Coupling,
    /// Row of every multiplier on the nonmortar body.
    pub nonmortar: Vec<Row<D>>,
    /// Row of every multiplier on the mortar body (sign included); of an obstacle, on its translation (node 0).
    pub mortar: Vec<Row<D>>,
    /// Conditions that others imply.
    pub implied: Vec<Implied<D>>,
}

/// A condition without a multiplier, because others imply it. It is judged all the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Implied<const D: usize> {
    /// Place of its node in [`Interface::nodes`].
    pub node: usize,
    /// 0: normal, else tangential.
    pub component: usize,
    /// Its rows on the nonmortar and on the mortar body.
    pub rows: [Row<D>; 2],
}

impl<const D: usize> Interface<D> {
    /// Takes over the nodes and rows of another part of the side. No condition of that may be implied yet.
    pub fn append(&mut self, part: Self) {
        let before = self.nonmortar.len();
        let moved = part.nodes.into_iter().map(|node| InterfaceNode {
            rows: node.rows.map(|row| row.map(|row| row + before)),
            ..node
        });
        self.nodes.extend(moved);
        self.nonmortar.extend(part.nonmortar);
        self.mortar.extend(part.mortar);
        self.cyclic = false;
    }

    /// Initial gap between the undeformed surfaces in every row; tangential rows have none.
    pub fn gaps(&self) -> Vec<f64> {
        let mut gaps = vec![0.0; self.nonmortar.len()];
        for node in &self.nodes {
            if let Some(row) = node.rows[0] {
                gaps[row] = node.gap;
            }
        }
        gaps
    }

    /// Whether each row is tangential under friction.
    pub fn tangential(&self) -> Vec<bool> {
        let mut tangential = vec![false; self.nonmortar.len()];
        if self.coupling == Coupling::Frictional {
            let rows = self.nodes.iter().flat_map(|node| &node.rows[1..]);
            rows.flatten().for_each(|&row| tangential[row] = true);
        }
        tangential
    }

    /// Takes all initial gaps for zero.
    pub fn close(&mut self) {
        for node in self.nodes.iter_mut().filter(|node| !node.gap.is_nan()) {
            (node.gap, node.clearance) = (0.0, 0.0);
        }
    }

    /// Takes the multipliers of rows away, and with a normal row under friction those of the tangential ones: the rows
    /// become implied ones, those after them move up, and nodes that lose all rows become fixed.
    pub fn drop_rows(&mut self, rows: &[usize]) {
        let mut kept = vec![true; self.nonmortar.len()];
        rows.iter().for_each(|&row| kept[row] = false);
        if self.coupling == Coupling::Frictional {
            for node in &self.nodes {
                if node.rows[0].is_some_and(|row| !kept[row]) {
                    node.rows
                        .iter()
                        .flatten()
                        .for_each(|&row| kept[row] = false);
                }
            }
        }
        for (place, node) in self.nodes.iter().enumerate() {
            for (component, row) in node.rows.iter().enumerate() {
                if let Some(row) = row.filter(|&row| !kept[row]) {
                    self.implied.push(Implied {
                        node: place,
                        component,
                        rows: [self.nonmortar[row].clone(), self.mortar[row].clone()],
                    });
                }
            }
        }
        let mut next = 0;
        let place: Vec<Option<usize>> = kept
            .iter()
            .map(|&kept| {
                next += usize::from(kept);
                kept.then(|| next - 1)
            })
            .collect();
        for node in &mut self.nodes {
            node.rows = node.rows.map(|row| row.and_then(|row| place[row]));
            if node.role == Role::Multiplier && node.rows.iter().all(Option::is_none) {
                node.role = Role::Fixed;
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
            .filter(|node| node.role == Role::Multiplier)
    }
}
