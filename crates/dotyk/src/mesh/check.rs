//! Requirements on every mesh before it is used.
//!
//! Indices exist, coordinates are finite, no cell repeats a node, no node is loose, and the Jacobian det ∂x/∂ξ of
//! every cell is positive. The Jacobian is sampled at the reference nodes and at the points of the usual quadrature
//! rules: at the nodes it may vanish (a corner of 180°, a quarter-point cell), inside it may not.
//! A cell numbered the other way round is turned, which its facets follow.

use crate::geometry::{Point, bounding_box, determinant, distance, padded};
use crate::mesh::cell::{CellBlock, MAX_CELL_NODES};
use crate::mesh::error::MeshError;
use crate::mesh::reference::CellKind;

/// Checks everything, turns cells; returns for each block the cells that were turned, ascending.
pub(crate) fn check<const D: usize>(
    points: &[Point<D>],
    blocks: &mut [CellBlock],
) -> Result<Vec<Vec<u32>>, MeshError> {
    finite(points)?;
    let mut used = vec![false; points.len()];
    for (index, block) in blocks.iter().enumerate() {
        indices(points, index, block, &mut used)?;
    }
    if blocks.iter().all(|block| block.nodes.is_empty()) {
        return Err(MeshError::Empty);
    }
    if let Some(node) = used.iter().position(|&used| !used) {
        let point = padded(points[node]);
        return Err(MeshError::LooseNode { node, point });
    }
    let (low, high) = bounding_box(points);
    let magnitude = low
        .iter()
        .chain(&high)
        .fold(0.0, |m: f64, c| m.max(c.abs()));
    blocks
        .iter_mut()
        .enumerate()
        .map(|(index, block)| orient(points, magnitude, index, block))
        .collect()
}

fn finite<const D: usize>(points: &[Point<D>]) -> Result<(), MeshError> {
    match points
        .iter()
        .position(|point| point.iter().any(|c| !c.is_finite()))
    {
        None => Ok(()),
        Some(node) => Err(MeshError::NotFinite {
            node,
            point: padded(points[node]),
        }),
    }
}

fn indices<const D: usize>(
    points: &[Point<D>],
    block: usize,
    cells: &CellBlock,
    used: &mut [bool],
) -> Result<(), MeshError> {
    let kind = cells.kind;
    if kind.dimension() != D || D < 2 {
        return Err(MeshError::Dimension {
            block,
            kind: kind.name(),
            dimension: D,
        });
    }
    if !cells.nodes.len().is_multiple_of(kind.nodes()) {
        return Err(MeshError::RaggedBlock {
            block,
            kind: kind.name(),
            length: cells.nodes.len(),
            nodes: kind.nodes(),
        });
    }
    for (cell, nodes) in cells.cells().enumerate() {
        for (i, &node) in nodes.iter().enumerate() {
            let Some(used) = used.get_mut(node as usize) else {
                return Err(MeshError::NodeOutOfRange {
                    block,
                    cell,
                    node,
                    points: points.len(),
                });
            };
            *used = true;
            if nodes[..i].contains(&node) {
                return Err(MeshError::RepeatedNode { block, cell, node });
            }
        }
    }
    Ok(())
}

/// Gradients at the points where the Jacobian is sampled: at the nodes, then inside.
fn samples<const D: usize>(kind: CellKind) -> Vec<[[f64; D]; MAX_CELL_NODES]> {
    kind.reference_nodes()
        .iter()
        .chain(kind.interior())
        .map(|xi| {
            let mut gradients = [[0.0; D]; MAX_CELL_NODES];
            kind.gradients(xi, &mut gradients);
            gradients
        })
        .collect()
}

fn orient<const D: usize>(
    points: &[Point<D>],
    magnitude: f64,
    index: usize,
    block: &mut CellBlock,
) -> Result<Vec<u32>, MeshError> {
    let kind = block.kind;
    let samples = samples::<D>(kind);
    let mut turned = Vec::new();
    for (cell, nodes) in block.nodes.chunks_exact_mut(kind.nodes()).enumerate() {
        let mut buffer = [[0.0; D]; MAX_CELL_NODES];
        for (x, &node) in buffer.iter_mut().zip(nodes.iter()) {
            *x = points[node as usize];
        }
        let x = &buffer[..kind.nodes()];
        match orientation(kind, x, &samples, magnitude) {
            Orientation::Positive => {}
            Orientation::Negative => {
                let before = nodes.to_vec();
                for (node, &from) in nodes.iter_mut().zip(kind.mirror()) {
                    *node = before[from];
                }
                turned.push(cell as u32);
            }
            Orientation::None(jacobian) => {
                return Err(MeshError::ZeroVolume {
                    block: index,
                    cell,
                    near: mean(x),
                    jacobian,
                });
            }
            Orientation::Both(low, high) => {
                return Err(MeshError::Folded {
                    block: index,
                    cell,
                    near: mean(x),
                    low,
                    high,
                });
            }
        }
    }
    Ok(turned)
}

enum Orientation {
    Positive,
    Negative,
    /// Largest absolute Jacobian.
    None(f64),
    /// Smallest and largest Jacobian.
    Both(f64, f64),
}

fn orientation<const D: usize>(
    kind: CellKind,
    x: &[Point<D>],
    samples: &[[[f64; D]; MAX_CELL_NODES]],
    magnitude: f64,
) -> Orientation {
    let (at_nodes, inside) = samples.split_at(kind.nodes());
    let (inner_low, inner_high) = range(x, inside);
    let (low, high) = range(x, at_nodes);
    let (low, high) = (low.min(inner_low), high.max(inner_high));
    // Below this a Jacobian is rounding: of the coordinates (a few units in the last place of the largest one), and of
    // a cell whose height is 1e-12 of its length.
    let (from, to) = bounding_box(x);
    let size = distance(from, to);
    let rounding = (16.0 * f64::EPSILON * magnitude + 1e-12 * size) * size.powi(D as i32 - 1);
    let largest = high.max(-low);
    if largest <= rounding {
        return Orientation::None(largest);
    }
    if low >= -rounding && inner_low > 0.0 {
        Orientation::Positive
    } else if high <= rounding && inner_high < 0.0 {
        Orientation::Negative
    } else {
        Orientation::Both(low, high)
    }
}

/// Smallest and largest Jacobian at the samples.
fn range<const D: usize>(x: &[Point<D>], samples: &[[[f64; D]; MAX_CELL_NODES]]) -> (f64, f64) {
    samples
        .iter()
        .map(|gradients| determinant(&jacobian(x, gradients)))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), det| {
            (low.min(det), high.max(det))
        })
}

/// ∂x/∂ξ, one row per reference coordinate.
fn jacobian<const D: usize>(x: &[Point<D>], gradients: &[[f64; D]]) -> [[f64; D]; D] {
    let mut rows = [[0.0; D]; D];
    for (point, gradient) in x.iter().zip(gradients) {
        for (row, g) in rows.iter_mut().zip(gradient) {
            for (entry, c) in row.iter_mut().zip(point) {
                *entry += g * c;
            }
        }
    }
    rows
}

fn mean<const D: usize>(x: &[Point<D>]) -> [f64; 3] {
    let mut sum = [0.0; D];
    for point in x {
        for d in 0..D {
            sum[d] += point[d];
        }
    }
    padded(sum.map(|c| c / x.len() as f64))
}
