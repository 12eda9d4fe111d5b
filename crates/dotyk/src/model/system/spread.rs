//! Displacements that conditions ask for, spread over the dofs that the conditions meet.
//!
//! A row i of B has at node a the entries bᵢₐ. Where these have one direction, it measures of a motion of all nodes sᵢ = Σₐ|bᵢₐ| times that.
//! Many displacements v have the values r of all rows. A rough one, such as Bᵀr, moves few of the nodes between those that bear
//! forces, with an energy that the right one has not; with its stiffness in a preconditioner the number of iterations grows as cells become
//! smaller and where functions of second degree meet multipliers of first, by which nodes in the middle of edges have no row of their own.
//! A smooth one takes at each node the mean of what the rows there ask for,
//!
//! ```text
//!   v = Eᵀr,     vₐ = Σᵢ wᵢₐ² nᵢₐ rᵢ/sᵢ / largest eigenvalue of Σᵢ wᵢₐ² nᵢₐ nᵢₐᵀ,     wᵢₐ = |bᵢₐ|/sᵢ,     nᵢₐ = ±bᵢₐ/|bᵢₐ|
//! ```
//!
//! where nᵢₐ points along Σₐbᵢₐ, as dual functions are negative on a part of a side, unless this sum vanishes: rotations and differences
//! have both signs. Rows of one node with normals apart are rows of one sum: three of them give each its own component. Where each node
//! has one row, and none a negative part, BEᵀ = 1.

use crate::fem::{BodySystem, principal};
use crate::geometry::{Point, add_scaled, dot, norm};
use crate::linalg::SparseMatrix;

/// Sums below this part of the sizes of their terms are those of differences, and have no direction.
const DIFFERENCE: f64 = 1e-6;

/// The part of a row at a node, in the frame of the node.
struct Part<const D: usize> {
    row: usize,
    node: usize,
    /// wᵢₐ nᵢₐ.
    share: Point<D>,
    /// sᵢ.
    size: f64,
}

/// E, of the shape of the rows of a body, from these rows; in the frames of its nodes, as they are.
pub(crate) fn spread<const D: usize>(system: &BodySystem<D>, rows: &SparseMatrix) -> SparseMatrix {
    let parts = (0..rows.rows()).flat_map(|row| parts(system, row, rows.row(row)));
    let parts: Vec<Part<D>> = parts.collect();
    let mut sums = vec![[[0.0; D]; D]; rows.cols() / D];
    for Part { node, share, .. } in &parts {
        let sum = sums[*node].as_flattened_mut().iter_mut().enumerate();
        sum.for_each(|(k, sum)| *sum += share[k / D] * share[k % D]);
    }
    let largest: Vec<f64> = sums.iter().map(largest_eigenvalue).collect();
    let entries = parts.iter().flat_map(|part| {
        let factor = norm(part.share) / (part.size * largest[part.node]);
        let entry = move |k| (part.row, D * part.node + k, factor * part.share[k]);
        (0..D).map(entry)
    });
    let entries = entries.filter(|(_, _, value)| value.is_finite() && *value != 0.0);
    let entries: Vec<(usize, usize, f64)> = entries.collect();
    SparseMatrix::from_triplets(rows.rows(), rows.cols(), &entries)
}

/// The parts of a row.
fn parts<const D: usize>(
    system: &BodySystem<D>,
    row: usize,
    entries: impl Iterator<Item = (usize, f64)>,
) -> Vec<Part<D>> {
    let mut parts: Vec<Part<D>> = Vec::new();
    for (dof, value) in entries {
        if parts.last().is_none_or(|part| part.node != dof / D) {
            parts.push(Part {
                row,
                node: dof / D,
                share: [0.0; D],
                size: 0.0,
            });
        }
        if let Some(part) = parts.last_mut() {
            part.share[dof % D] = value;
        }
    }
    let global = |part: &Part<D>| match system.frames.get(&part.node) {
        None => part.share,
        Some(axes) => (0..D).fold([0.0; D], |sum, k| add_scaled(sum, part.share[k], axes[k])),
    };
    let mean = parts
        .iter()
        .fold([0.0; D], |sum, part| add_scaled(sum, 1.0, global(part)));
    let size: f64 = parts.iter().map(|part| norm(part.share)).sum();
    if size == 0.0 {
        return Vec::new();
    }
    let one_sided = norm(mean) > DIFFERENCE * size;
    for part in &mut parts {
        let sign = match one_sided && dot(global(part), mean) < 0.0 {
            true => -1.0,
            false => 1.0,
        };
        part.share = part.share.map(|b| sign * b / size);
        part.size = size;
    }
    parts
}

/// That of a symmetric matrix.
fn largest_eigenvalue<const D: usize>(matrix: &[[f64; D]; D]) -> f64 {
    let at = |i: usize, j: usize| if i.max(j) < D { matrix[i][j] } else { 0.0 };
    principal([at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(0, 2)])[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body of so many nodes, the second of which has a frame of its own.
    fn body(nodes: usize, axes: [[f64; 2]; 2]) -> BodySystem<2> {
        let mut system = BodySystem::rigid(&vec![[0.0; 2]; nodes], &vec![[None; 2]; nodes]);
        system.frames.insert(1, axes);
        system
    }

    const AS_THEY_ARE: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

    fn moved(spread: &SparseMatrix, r: &[f64]) -> Vec<f64> {
        let mut v = vec![0.0; spread.cols()];
        spread.mul_transpose_add(r, &mut v);
        v
    }

    #[test]
    fn rows_of_single_nodes_get_what_they_ask_for() {
        // a node with both components, along axes that are turned, and one with one; of several sizes
        let entries = [
            (0, 0, 0.3 * 0.6),
            (0, 1, 0.3 * 0.8),
            (1, 0, 0.5 * 0.8),
            (1, 1, -0.5 * 0.6),
            (2, 3, -7.0),
        ];
        let rows = SparseMatrix::from_triplets(3, 4, &entries);
        let spread = spread(&body(2, AS_THEY_ARE), &rows);
        let asked = [0.2, -0.7, 1.3];
        for (row, r) in asked.iter().enumerate() {
            let mut one = [0.0; 3];
            one[row] = *r;
            let mut measured = [0.0; 3];
            rows.mul(&moved(&spread, &one), &mut measured);
            assert!((measured[row] - r).abs() < 1e-12, "{measured:?}");
        }
    }

    #[test]
    fn alike_values_are_a_motion_of_all_nodes_also_where_functions_are_negative() {
        // dual functions of corners, and the nodes between them, which have no rows; the second node in a turned frame
        let axes = [[0.6, 0.8], [-0.8, 0.6]];
        let n = [0.28, -0.96];
        let weights = [[0.4, 0.3, -0.1], [-0.1, 0.3, 0.4]];
        let in_frame = |node: usize| match node {
            1 => axes.map(|axis| dot(axis, n)),
            _ => n,
        };
        let mut entries = Vec::new();
        for (row, weights) in weights.iter().enumerate() {
            for (node, weight) in weights.iter().enumerate() {
                let part = in_frame(node);
                entries.extend((0..2).map(|k| (row, 2 * node + k, weight * part[k])));
            }
        }
        let rows = SparseMatrix::from_triplets(2, 6, &entries);
        let size = 0.8;
        let v = moved(&spread(&body(3, axes), &rows), &[size; 2]);
        for node in 0..3 {
            for (k, part) in in_frame(node).iter().enumerate() {
                assert!((v[2 * node + k] - part).abs() < 1e-12, "{v:?}");
            }
        }
        // a corner follows its own row, the node between both
        let v = moved(&spread(&body(3, axes), &rows), &[size, 0.0]);
        let along = |node: usize| dot([v[2 * node], v[2 * node + 1]], in_frame(node));
        let corners = 16.0 / 17.0;
        for (node, expected) in [corners, 0.5, 1.0 - corners].iter().enumerate() {
            assert!((along(node) - expected).abs() < 1e-12, "{v:?}");
        }
    }

    #[test]
    fn differences_are_not_a_motion_of_all_nodes() {
        // the rotation of four nodes about their middle, and the jump between two
        let turn = [-0.6, 0.8, -0.8, -0.6, 0.6, -0.8, 0.8, 0.6];
        let jump = [-0.6, -0.8, 0.6, 0.8];
        for values in [&turn[..], &jump] {
            let entries = values
                .iter()
                .enumerate()
                .map(|(dof, value)| (0, dof, *value));
            let entries: Vec<_> = entries.collect();
            let rows = SparseMatrix::from_triplets(1, values.len(), &entries);
            let v = moved(&spread(&body(values.len() / 2, AS_THEY_ARE), &rows), &[1.0]);
            let mut measured = [0.0];
            rows.mul(&v, &mut measured);
            assert!((measured[0] - 1.0).abs() < 1e-12, "{v:?}");
        }
    }

    #[test]
    fn rows_without_entries_ask_for_nothing() {
        let rows = SparseMatrix::from_triplets(2, 4, &[(0, 0, 0.0), (1, 1, 2.0)]);
        let v = moved(&spread(&body(2, AS_THEY_ARE), &rows), &[1.0, 1.0]);
        assert_eq!(v, [0.0, 0.5, 0.0, 0.0]);
    }
}
