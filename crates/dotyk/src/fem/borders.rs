//! Borders between the materials of a body, across which stress and strain jump.
//!
//! Values recovered at the nodes are averaged only over cells of one elasticity, so that a node on a border has one value for each
//! elasticity that meets there. Such values are given at *places*: one for every node, followed by a further one for each node on a
//! border and each further elasticity:
//!
//! ```text
//!   place(block, node) = node                     for the first elasticity, in the order of the blocks, of the cells around
//!                      = nodes, nodes + 1, ...    for the others
//! ```
//!
//! A body of one elasticity has no borders, and its places are its nodes.

use crate::fem::error::FemError;
use crate::fem::nouns::{Body, Elastic};
use std::collections::BTreeMap;

/// The places of a body at which stress and strain are recovered: its nodes, and behind them those on borders between
/// materials again, once for each further material.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Borders {
    /// Number of nodes of the body.
    nodes: usize,
    /// Which elasticity each block has.
    kinds: Vec<usize>,
    /// The node of each further place.
    again: Vec<u32>,
    /// The further places by elasticity and node.
    further: BTreeMap<(usize, u32), u32>,
}

impl Borders {
    /// The borders of a body. Errors: a group of cells without a material.
    pub fn of<const D: usize>(body: &Body<D>) -> Result<Self, FemError> {
        let mut elastic: Vec<Elastic> = Vec::new();
        let mut kinds = Vec::new();
        for block in body.mesh.blocks() {
            let own = body.elastic(block)?;
            let known = elastic.iter().position(|other| *other == own);
            kinds.push(known.unwrap_or(elastic.len()));
            if known.is_none() {
                elastic.push(own);
            }
        }
        let mut found = Self {
            nodes: body.mesh.points().len(),
            kinds,
            ..Self::default()
        };
        if elastic.len() < 2 {
            return Ok(found);
        }
        let mut first = vec![usize::MAX; found.nodes];
        for kind in 0..elastic.len() {
            let blocks = body.mesh.blocks().iter().zip(&found.kinds);
            for (block, _) in blocks.filter(|(_, own)| **own == kind) {
                for &node in &block.nodes {
                    let owner = &mut first[node as usize];
                    *owner = (*owner).min(kind);
                    if *owner < kind && !found.further.contains_key(&(kind, node)) {
                        let place = found.nodes + found.again.len();
                        found.further.insert((kind, node), place as u32);
                        found.again.push(node);
                    }
                }
            }
        }
        Ok(found)
    }

    /// The place of a node for the cells of a block.
    pub fn place(&self, block: usize, node: usize) -> usize {
        if self.further.is_empty() {
            return node;
        }
        let further = self.further.get(&(self.kinds[block], node as u32));
        further.map_or(node, |&place| place as usize)
    }

    /// The node of a place.
    pub fn node(&self, place: usize) -> usize {
        match place.checked_sub(self.nodes) {
            Some(further) => self.again[further] as usize,
            None => place,
        }
    }

    /// The nodes of all places.
    pub fn nodes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.count()).map(|place| self.node(place))
    }

    /// For every node the place with the largest value (places,), NaN ignored.
    pub fn largest(&self, values: &[f64]) -> Vec<usize> {
        let mut found: Vec<usize> = (0..self.nodes).collect();
        for (further, &node) in self.again.iter().enumerate() {
            let (best, place) = (&mut found[node as usize], self.nodes + further);
            if values[place] > values[*best] || values[*best].is_nan() {
                *best = place;
            }
        }
        found
    }

    /// Number of places.
    pub fn count(&self) -> usize {
        self.nodes + self.again.len()
    }
}
