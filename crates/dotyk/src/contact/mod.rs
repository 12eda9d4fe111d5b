//! Interfaces: from two sides to rows B, initial gaps g₀ and weights, so that
//!
//! ```text
//!   gap = g₀ − B u ≥ 0,     (B u)ᵢ = ∫ψᵢ n·(u_nonmortar − u_mortar) / ∫ψᵢ,     pressure = λ / weight,  weight = ∫ψᵢ
//! ```
//!
//! n is the outward normal of the nonmortar side. λ is a force, the gap a length, the weight an area. Node-to-node
//! pairing is the same with the integrals replaced by values at nodes. Tangential rows, one in the plane and two in space, have
//! t instead of n and no gap.
//! An interface knows the two meshes and what their supports hold, but no stiffness.

mod corners;
mod curved;
mod error;
mod facing;
mod gaps;
mod mortar;
mod node_to_node;
mod normals;
mod obstacle;
mod opposite;
mod pieces;
mod relative;
mod sampling;
mod search;
mod weights;

pub use corners::smooth_parts;
pub use curved::{sagitta, straight_turn};
pub use error::ContactError;
pub use facing::{facets_coincide, unmatched_facing};
pub use gaps::{GapPoint, GapShares, Moved};
pub use mortar::pair_mortar;
pub use node_to_node::{pair_nodes, pair_obstacle};
pub use obstacle::{Driven, Rigid};
pub use relative::frame;
pub use sampling::{Sample, samples};

use crate::fem::{Body, Constraints, side_facets};
use crate::geometry::{Field, Point};
use crate::mesh::Facet;
use std::any::Any;

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

impl<'a, const D: usize> End<'a, D> {
    /// `body.side`, as in the case file.
    pub fn name(&self) -> String {
        format!("{}.{}", self.body.name, self.side)
    }

    /// Its facets; an error when the side is unknown or empty.
    pub fn facets(&self) -> Result<&'a [Facet], ContactError> {
        if let Some(part) = self.part {
            return Ok(part);
        }
        side_facets(&self.body.mesh, self.side).map_err(|source| ContactError::Side {
            body: self.body.name.clone(),
            source,
        })
    }

    /// The same end as one of a plane body; `None` in space.
    pub(crate) fn in_plane(self) -> Option<End<'a, 2>> {
        Some(End {
            body: in_plane(self.body)?,
            side: self.side,
            constraints: in_plane(self.constraints)?,
            part: self.part,
        })
    }
}

/// A thing of D dimensions as one of the plane, where it is one.
fn in_plane<T: Any, P: Any>(thing: &T) -> Option<&P> {
    (thing as &dyn Any).downcast_ref()
}

/// What a nonmortar side is paired with.
#[derive(Clone, Copy)]
pub enum Against<'a, const D: usize> {
    /// A side of another body.
    Side(End<'a, D>),
    /// A rigid obstacle.
    Obstacle(&'a Rigid<D>, Driven),
}

impl<'a, const D: usize> Against<'a, D> {
    /// The same as one of the plane; `None` in space.
    pub(crate) fn in_plane(self) -> Option<Against<'a, 2>> {
        Some(match self {
            Self::Side(end) => Against::Side(end.in_plane()?),
            Self::Obstacle(rigid, driven) => Against::Obstacle(in_plane(rigid)?, driven),
        })
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
    /// The unit vectors of its rows: the outward normal, after the projection onto what the supports leave free, then the
    /// tangents.
    pub frame: [Point<D>; D],
    /// ∫ψ: an area, times thickness or 2πr.
    pub weight: f64,
    /// The part of the side that the multiplier stands for: a length (in space an area) without thickness or 2πr.
    pub extent: f64,
    /// Initial gap, ∫ψ s/∫ψ; NaN where nothing is opposite.
    pub gap: f64,
    /// Initial gap at the node itself: between the surfaces, or as given. NaN where nothing is opposite.
    pub clearance: f64,
    /// How both follow from the points of the interface.
    pub shares: GapShares,
    /// What it is to the interface.
    pub role: Role,
    /// Rows of its multipliers: normal, then tangential.
    pub rows: [Option<usize>; D],
}

impl<const D: usize> InterfaceNode<D> {
    /// Outward unit normal.
    pub fn normal(&self) -> Point<D> {
        self.frame[0]
    }

    /// The coincident node of the mortar mesh.
    pub fn partner(&self) -> Option<usize> {
        match self.opposite[..] {
            [(node, _)] => Some(node),
            _ => None,
        }
    }
}

/// A row of B: coefficients of global displacement vectors at nodes.
pub type Row<const D: usize> = Vec<(usize, Point<D>)>;

/// Two sides, or a side and an obstacle, ready for condensation.
#[derive(Debug, Clone, PartialEq)]
pub struct Interface<const D: usize> {
    /// Nodes of the nonmortar side in its order: along its chain, in space ascending.
    pub nodes: Vec<InterfaceNode<D>>,
    /// The chain closes on itself.
    pub cyclic: bool,
    /// What the rows couple.
    pub coupling: Coupling,
    /// Row of every multiplier on the nonmortar body.
    pub nonmortar: Vec<Row<D>>,
    /// Row of every multiplier on the mortar body (sign included); of an obstacle, on its translation (node 0).
    pub mortar: Vec<Row<D>>,
    /// Where gaps are taken.
    pub points: Vec<GapPoint<D>>,
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
        let points = self.points.len();
        let moved = part.nodes.into_iter().map(|node| InterfaceNode {
            rows: node.rows.map(|row| row.map(|row| row + before)),
            shares: node.shares.after(points),
            ..node
        });
        self.nodes.extend(moved);
        self.points.extend(part.points);
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
        self.points.iter_mut().for_each(|point| point.gap = 0.0);
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
