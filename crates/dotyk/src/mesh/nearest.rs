//! Queries of a mesh for many points: the nearest node, the cells around it, the extent.
//!
//! The answers are computed on first use, for all nodes at once, and kept with the mesh, which never changes.

use crate::geometry::{Point, bounding_box, distance};
use crate::mesh::Mesh;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::sync::OnceLock;

/// A node with its number.
type Node<const D: usize> = GeomWithData<Point<D>, usize>;

/// Cached answers. They follow from the mesh: a copy begins without them, and all caches are equal.
#[derive(Debug, Default)]
pub(super) struct Found<const D: usize> {
    nodes: OnceLock<RTree<Node<D>>>,
    /// Longest edge of the cells around each node.
    longest: OnceLock<Vec<f64>>,
    bounds: OnceLock<[Point<D>; 2]>,
}

impl<const D: usize> Clone for Found<D> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<const D: usize> PartialEq for Found<D> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Nodes whose distances differ by less, relative to them, are equally near: the first one counts.
const EQUAL: f64 = 1e-12;

impl<const D: usize> Mesh<D> {
    /// The node nearest to a point, of equally near ones the first.
    pub fn nearest_node(&self, point: Point<D>) -> usize {
        let tree = self.found.nodes.get_or_init(|| {
            let nodes = self.points.iter().enumerate();
            RTree::bulk_load(nodes.map(|(node, &at)| Node::new(at, node)).collect())
        });
        let nearest = tree.nearest_neighbor(point);
        let near = nearest.map_or(0.0, |node| distance(*node.geom(), point));
        let within = tree.nearest_neighbor_iter_with_distance_2(point);
        let reach = near * near * (1.0 + EQUAL);
        let equal = within.take_while(|(_, squared)| *squared <= reach);
        let first = equal.map(|(node, _)| node.data).min();
        first.or(nearest.map(|node| node.data)).unwrap_or(0)
    }

    /// Length of the longest edge of the cells around a node.
    pub fn longest_edge_at(&self, node: usize) -> f64 {
        let longest = self.found.longest.get_or_init(|| {
            let mut longest = vec![0.0f64; self.points.len()];
            for (index, block) in self.blocks.iter().enumerate() {
                for (cell, nodes) in block.cells().enumerate() {
                    let edge = self.longest_edge(index, cell);
                    for &node in nodes {
                        longest[node as usize] = longest[node as usize].max(edge);
                    }
                }
            }
            longest
        });
        longest[node]
    }

    /// The least and the largest coordinates of its nodes.
    pub fn bounds(&self) -> [Point<D>; 2] {
        *self.found.bounds.get_or_init(|| {
            let (low, high) = bounding_box(&self.points);
            [low, high]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Diagonals, Rectangle};

    #[test]
    fn the_nearest_node_is_the_first_of_those_at_the_least_distance() {
        let mesh = Rectangle {
            from: [0.0, 0.0],
            to: [3.0, 2.0],
            cells: [30, 20],
            cell: CellKind::Quad8,
            diagonals: Diagonals::default(),
        };
        let mesh = mesh.build().unwrap();
        for k in 0..400 {
            let t = f64::from(k);
            // every second one in the middle of a cell, as far from four nodes
            let point = match k % 2 {
                0 => [
                    0.05 + 0.1 * (t % 30.0).floor(),
                    0.05 + 0.1 * (t % 20.0).floor(),
                ],
                _ => [3.0 * (1.3 * t).sin().abs(), 2.0 * (0.7 * t).cos().abs()],
            };
            let far = |node: &usize| distance(mesh.points()[*node], point);
            let least = (0..mesh.points().len())
                .map(|node| far(&node))
                .fold(f64::MAX, f64::min);
            let first = (0..mesh.points().len()).find(|node| far(node) <= least * (1.0 + 1e-13));
            assert_eq!(Some(mesh.nearest_node(point)), first, "{point:?}");
        }
        assert!((mesh.longest_edge_at(0) - 0.1).abs() < 1e-14);
        assert_eq!(mesh.bounds(), [[0.0, 0.0], [3.0, 2.0]]);
    }
}
