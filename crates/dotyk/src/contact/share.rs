//! Contributions of the stations of a facet to the rows of its nodes: sums over points of integration, and the places where gaps
//! are taken.

use crate::contact::lever::Lever;
use crate::contact::search::Hit;
use crate::contact::{GapPoint, Row};
use crate::geometry::{Point, add_scaled};
use std::collections::BTreeMap;

/// Everything at one point of integration.
pub(super) struct Station<const D: usize> {
    pub cell: usize,
    /// Index of its piece.
    pub piece: usize,
    /// Reference coordinates on the facet.
    pub xi: [f64; 2],
    pub area: f64,
    /// Without thickness or 2πr.
    pub extent: f64,
    /// Its opposite.
    pub at: GapPoint<D>,
    /// Where the line from it meets the other side.
    pub hit: Option<Hit>,
}

/// A place where the gap of a row is taken.
pub(super) enum GapAt<const D: usize> {
    /// A point of integration, by its index.
    Station(usize),
    /// Where the force of the row acts.
    Place(GapPoint<D>),
}

/// Contribution of one facet to the sums of one of its nodes.
pub(super) struct Share<const D: usize> {
    pub node: usize,
    pub extent: f64,
    weight: [f64; D],
    /// ∫ψ n of the normal row.
    normal: Point<D>,
    /// Where the gap of the normal row is taken, with weights that sum to its own.
    gaps: Vec<(GapAt<D>, f64)>,
    nonmortar: [Row<D>; D],
    mortar: [Row<D>; D],
    /// The last piece in each of these.
    piece: [usize; D],
}

/// Sums over the stations of one node.
pub(super) struct Sums<const D: usize> {
    /// ∫ of the node's hat, and its weights at the stations.
    pub own: f64,
    pub hats: Vec<(usize, f64)>,
    pub extent: f64,
    pub weight: [f64; D],
    pub normal: Point<D>,
    pub gaps: Vec<(GapAt<D>, f64)>,
    nonmortar: [BTreeMap<usize, Point<D>>; D],
    mortar: [BTreeMap<usize, Point<D>>; D],
}

impl<const D: usize> Share<D> {
    pub fn new(node: usize) -> Self {
        Self {
            node,
            extent: 0.0,
            weight: [0.0; D],
            normal: [0.0; D],
            gaps: Vec::new(),
            nonmortar: std::array::from_fn(|_| Vec::new()),
            mortar: std::array::from_fn(|_| Vec::new()),
            piece: [usize::MAX; D],
        }
    }

    /// Adds ψ·area at a station to the row of a component along a direction, with the lever of one that is not the normal there.
    pub fn add(
        &mut self,
        (component, direction): (usize, Point<D>),
        weight: f64,
        station: &Station<D>,
        lever: Option<&Lever<D>>,
    ) {
        self.weight[component] += weight;
        if component == 0 {
            self.normal = add_scaled(self.normal, weight, direction);
        }
        let own = &mut self.nonmortar[component];
        let other = &mut self.mortar[component];
        if own.is_empty() {
            own.extend(station.at.own.iter().map(|&(node, _)| (node, [0.0; D])));
        }
        // the nodes opposite are the same all over a piece
        if self.piece[component] != station.piece {
            self.piece[component] = station.piece;
            let nodes = station.at.opposite.iter();
            other.extend(nodes.map(|&(node, _)| (node, [0.0; D])));
        }
        for (entry, (_, shape)) in own.iter_mut().zip(&station.at.own) {
            entry.1 = add_scaled(entry.1, weight * shape, direction);
        }
        let start = other.len() - station.at.opposite.len();
        for (entry, (_, shape)) in other[start..].iter_mut().zip(&station.at.opposite) {
            entry.1 = add_scaled(entry.1, -weight * shape, direction);
        }
        if let Some(lever) = lever {
            for (place, entry) in other[start..].iter_mut().enumerate() {
                entry.1 = add_scaled(entry.1, weight, lever.along(direction, place));
            }
        }
    }

    /// Takes the gap of the normal row at a place, too, with a weight.
    pub fn take_gap(&mut self, at: GapAt<D>, weight: f64) {
        self.gaps.push((at, weight));
    }
}

impl<const D: usize> Sums<D> {
    pub fn new() -> Self {
        Self {
            own: 0.0,
            hats: Vec::new(),
            extent: 0.0,
            weight: [0.0; D],
            normal: [0.0; D],
            gaps: Vec::new(),
            nonmortar: std::array::from_fn(|_| BTreeMap::new()),
            mortar: std::array::from_fn(|_| BTreeMap::new()),
        }
    }

    pub fn add(&mut self, share: Share<D>) {
        self.extent += share.extent;
        self.normal = add_scaled(self.normal, 1.0, share.normal);
        self.gaps.extend(share.gaps);
        for c in 0..D {
            self.weight[c] += share.weight[c];
            let sides = [
                (&mut self.nonmortar[c], &share.nonmortar[c]),
                (&mut self.mortar[c], &share.mortar[c]),
            ];
            for (row, terms) in sides {
                for &(node, coefficient) in terms {
                    let entry = row.entry(node).or_insert([0.0; D]);
                    *entry = add_scaled(*entry, 1.0, coefficient);
                }
            }
        }
    }

    /// Rows of a component on both sides, divided by a weight.
    pub fn rows(&self, component: usize, weight: f64) -> [Row<D>; 2] {
        [&self.nonmortar[component], &self.mortar[component]].map(|row| {
            let scale = 1.0 / weight;
            row.iter()
                .map(|(&node, c)| (node, c.map(|c| c * scale)))
                .collect()
        })
    }
}
