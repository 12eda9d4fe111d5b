//! Stress at the nodes, recovered from the displacements.
//!
//! In each cell the stress is sampled at the points where it is most accurate (one point in a linear triangle, three in
//! a quadratic one, 2 × 2 in quadrilaterals), extrapolated to the nodes and averaged there with the cells' volumes.

use crate::fem::assemble::{CellTable, measure};
use crate::fem::elasticity::Lame;
use crate::fem::error::FemError;
use crate::fem::nouns::{Analysis, Body};
use crate::geometry::Point;
use crate::mesh::CellKind;
use rayon::prelude::*;

/// Recovered stress (xx yy zz xy yz xz) at every node of a body with the given nodal displacements.
///
/// Errors: a group of cells without a material.
/// Source: J. Barlow's optimal sampling points, as described in finite-element textbooks.
pub fn recover_stress<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
) -> Result<Vec<[f64; 6]>, FemError> {
    let mesh = &body.mesh;
    let mut sums = vec![[0.0; 7]; mesh.points().len()];
    for block in mesh.blocks() {
        let lame = Lame::new(body.elastic(block)?, analysis);
        let table = CellTable::<D>::at(block.kind, &sampling_points::<D>(block.kind));
        let extrapolation = extrapolation(block.kind);
        let k = block.kind.nodes();
        // each cell writes its own slice: (stress, volume) of its samples; the gather below is in cell order
        let mut samples = vec![[0.0; 7]; table.len() * (block.nodes.len() / k)];
        samples
            .par_chunks_mut(table.len() * CHUNK)
            .zip(block.nodes.par_chunks(k * CHUNK))
            .for_each(|(out, cells)| {
                for (out, cell) in out.chunks_exact_mut(table.len()).zip(cells.chunks_exact(k)) {
                    for (q, sample) in out.iter_mut().enumerate() {
                        *sample =
                            sample_stress(&table, q, body, analysis, lame, cell, displacement);
                    }
                }
            });
        for (cell, samples) in block.cells().zip(samples.chunks_exact(table.len())) {
            let volume: f64 = samples.iter().map(|s| s[6]).sum();
            for (&node, weights) in cell.iter().zip(&extrapolation) {
                let sum = &mut sums[node as usize];
                for c in 0..6 {
                    sum[c] += volume
                        * samples
                            .iter()
                            .zip(weights)
                            .map(|(s, w)| w * s[c])
                            .sum::<f64>();
                }
                sum[6] += volume;
            }
        }
    }
    Ok(sums
        .iter()
        .map(|s| std::array::from_fn(|c| s[c] / s[6]))
        .collect())
}

/// Cells per parallel task.
const CHUNK: usize = 256;

fn sample_stress<const D: usize>(
    table: &CellTable<D>,
    q: usize,
    body: &Body<D>,
    analysis: Analysis,
    lame: Lame,
    cell: &[u32],
    displacement: &[Point<D>],
) -> [f64; 7] {
    let points = body.mesh.points();
    let (point, gradients, volume) = table.map(q, |local| points[cell[local] as usize]);
    let mut h = [[0.0; D]; D];
    let mut radial = 0.0;
    for (local, &node) in cell.iter().enumerate() {
        let u = displacement[node as usize];
        for i in 0..D {
            for j in 0..D {
                h[i][j] += u[i] * gradients[local][j];
            }
        }
        radial += table.shape(q)[local] * u[0];
    }
    let hoop = if analysis == Analysis::Axisymmetric {
        radial / point[0]
    } else {
        0.0
    };
    let s = lame.stress(h, hoop);
    [
        s[0],
        s[1],
        s[2],
        s[3],
        s[4],
        s[5],
        volume * measure(analysis, body.thickness, point),
    ]
}

/// Reference points where the stress is sampled, with weights that sum to the reference volume.
fn sampling_points<const D: usize>(kind: CellKind) -> Vec<(Point<D>, f64)> {
    let plane = |list: &[([f64; 2], f64)]| -> Vec<(Point<D>, f64)> {
        list.iter()
            .map(|&(p, w)| (std::array::from_fn(|i| p[i]), w))
            .collect()
    };
    let (a, b, third) = (1.0 / 6.0, 2.0 / 3.0, 1.0 / 3.0);
    let g = 1.0 / 3f64.sqrt();
    match kind {
        CellKind::Tri3 => plane(&[([third, third], 0.5)]),
        CellKind::Tri6 => plane(&[([a, a], a), ([b, a], a), ([a, b], a)]),
        CellKind::Quad4 | CellKind::Quad8 | CellKind::Quad9 => plane(&[
            ([-g, -g], 1.0),
            ([g, -g], 1.0),
            ([g, g], 1.0),
            ([-g, g], 1.0),
        ]),
    }
}

/// Weights of the samples at each node of the cell: the (bi)linear function through the samples, evaluated there.
fn extrapolation(kind: CellKind) -> Vec<Vec<f64>> {
    let nodes = kind.reference_nodes();
    let weights = |xi: &[f64; 3]| match kind {
        CellKind::Tri3 => vec![1.0],
        CellKind::Tri6 => [1.0 - xi[0] - xi[1], xi[0], xi[1]]
            .map(|l| 2.0 * l - 1.0 / 3.0)
            .to_vec(),
        CellKind::Quad4 | CellKind::Quad8 | CellKind::Quad9 => {
            let (x, y) = (xi[0] * 3f64.sqrt(), xi[1] * 3f64.sqrt());
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(a, b)| 0.25 * (1.0 + a * x) * (1.0 + b * y))
                .to_vec()
        }
    };
    nodes.iter().map(|xi| weights(xi)).collect()
}

/// Von Mises stress of (xx yy zz xy yz xz).
pub fn von_mises(s: [f64; 6]) -> f64 {
    let d = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    (0.5 * d + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt()
}
