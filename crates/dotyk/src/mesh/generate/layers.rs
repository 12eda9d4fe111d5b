//! Solids from layers: a plane mesh, or any surface of triangles and quadrilaterals, carried step by step.
//!
//! Quadrilaterals become hexahedra, triangles prisms, of their order. A quadratic layer has a level of nodes in its middle,
//! so that there are order · layers + 1 levels, one less where the last layer ends at the first. Node n of the surface has
//! one node at each level, on the middle levels only where a cell has one there. Reference cells show where, since the node of a
//! solid cell at (ξ, η, ζ) lies above the node of the surface at (ξ, η).

use crate::geometry::Point;
use crate::mesh::{CellBlock, CellKind, Facet};
use std::collections::BTreeMap;

/// No node at that level.
const NO_NODE: u32 = u32::MAX;

/// The solid made from a surface.
pub(super) struct Layers<'a> {
    surface: &'a [CellBlock],
    /// Of each block of the surface.
    kinds: Vec<CellKind>,
    layers: usize,
    /// Numbers of the nodes, level by level, `NONE` where there is none.
    numbers: Vec<Vec<u32>>,
    /// Number of nodes, those of a given first level included.
    pub count: usize,
}

/// The solid kind made from a plane cell; `full`: with all nodes of its order.
pub(super) fn carried(kind: CellKind, full: bool) -> CellKind {
    match kind {
        CellKind::Quad4 => CellKind::Hex8,
        CellKind::Quad8 => CellKind::Hex20,
        CellKind::Quad9 => CellKind::Hex27,
        CellKind::Tri6 if full => CellKind::Prism18,
        CellKind::Tri6 => CellKind::Prism15,
        _ => CellKind::Prism6,
    }
}

/// The level of a node of a layer, and the node of the plane cell below it.
fn stands_on(solid: CellKind, plane: CellKind) -> Vec<(usize, usize)> {
    let below = plane.reference_nodes();
    let place = |&[x, y, z]: &[f64; 3]| {
        let level = if z < 0.0 {
            0
        } else if z > 0.0 {
            plane.order()
        } else {
            1
        };
        let node = below.iter().position(|&n| n == [x, y, 0.0]);
        (node.unwrap_or(0), level)
    };
    solid.reference_nodes().iter().map(place).collect()
}

impl<'a> Layers<'a> {
    /// The levels over a surface of `nodes` nodes; all blocks have one order. `first`: existing numbers of the nodes of the first
    /// level, and the next free number.
    pub fn new(
        surface: &'a [CellBlock],
        kinds: Vec<CellKind>,
        nodes: usize,
        layers: usize,
        closed: bool,
        first: Option<(Vec<u32>, usize)>,
    ) -> Self {
        let order = surface.first().map_or(1, |block| block.kind.order());
        let mut used = vec![vec![false; nodes]; order];
        for (block, &kind) in surface.iter().zip(&kinds) {
            let places = stands_on(kind, block.kind);
            for cell in block.cells() {
                for &(node, level) in &places {
                    used[level % order][cell[node] as usize] = true;
                }
            }
        }
        let (given, mut count) = match first {
            Some((numbers, next)) => (Some(numbers), next),
            None => (None, 0),
        };
        let levels = order * layers + usize::from(!closed);
        let mut numbers: Vec<Vec<u32>> = given.into_iter().collect();
        for level in numbers.len()..levels {
            let of_node = |&used: &bool| {
                let number = if used { count as u32 } else { NO_NODE };
                count += usize::from(used);
                number
            };
            numbers.push(used[level % order].iter().map(of_node).collect());
        }
        Self {
            surface,
            kinds,
            layers,
            numbers,
            count,
        }
    }

    /// Appends the points of the levels whose numbers were not given, from node and level.
    pub fn points(&self, points: &mut Vec<Point<3>>, at: impl Fn(usize, usize) -> Point<3>) {
        for (level, numbers) in self.numbers.iter().enumerate() {
            for (node, &number) in numbers.iter().enumerate() {
                if number != NO_NODE && number as usize >= points.len() {
                    points.push(at(node, level));
                }
            }
        }
    }

    /// The cells, layer after layer.
    pub fn blocks(&self) -> Vec<CellBlock> {
        let both = self.surface.iter().zip(&self.kinds);
        let block = |(plane, &kind): (&CellBlock, &CellKind)| {
            let (places, order) = (stands_on(kind, plane.kind), plane.kind.order());
            let mut nodes = Vec::with_capacity(self.layers * plane.cells().len() * kind.nodes());
            for layer in 0..self.layers {
                for cell in plane.cells() {
                    nodes.extend(places.iter().map(|&(node, level)| {
                        let level = (order * layer + level) % self.numbers.len();
                        self.numbers[level][cell[node] as usize]
                    }));
                }
            }
            CellBlock {
                kind,
                nodes,
                group: plane.group.clone(),
            }
        };
        both.map(block).collect()
    }

    /// The facets over an edge of the surface, layer after layer.
    pub fn over(&self, edge: Facet) -> impl Iterator<Item = Facet> + '_ {
        (0..self.layers).map(move |layer| Facet {
            block: edge.block,
            cell: self.cell(edge.block, edge.cell, layer),
            // after bottom and top
            local: edge.local + 2,
        })
    }

    /// The facets of the first or of the last level.
    pub fn ends(&self, last: bool) -> Vec<Facet> {
        let layer = if last { self.layers - 1 } else { 0 };
        let blocks = self.surface.iter().enumerate();
        let facets = blocks.flat_map(|(block, cells)| {
            (0..cells.cells().len() as u32).map(move |cell| (block as u32, cell))
        });
        let facet = |(block, cell)| Facet {
            block,
            cell: self.cell(block, cell, layer),
            local: u32::from(last),
        };
        facets.map(facet).collect()
    }

    /// The sides over those of the surface.
    pub fn sides(&self, edges: &BTreeMap<String, Vec<Facet>>) -> BTreeMap<String, Vec<Facet>> {
        let over = |edges: &Vec<Facet>| edges.iter().flat_map(|&edge| self.over(edge)).collect();
        let named = edges
            .iter()
            .map(|(name, edges)| (name.clone(), over(edges)));
        named.collect()
    }

    fn cell(&self, block: u32, cell: u32, layer: usize) -> u32 {
        (layer * self.surface[block as usize].cells().len()) as u32 + cell
    }
}
