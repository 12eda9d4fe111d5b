//! Internal forces from strains: fₐ = ∫ σ·∇Nₐ dV, cell by cell.
//!
//! K u gives the same numbers, but rounds each entry of K against the whole displacement: a slender body that bends a lot
//! then misses its balance by 1e-9. Here displacements enter as differences within a cell, so that the forces of a cell
//! sum to zero to the rounding of its stresses.

use crate::fem::assemble::cell_stiffness;
use crate::fem::cells::{CellTable, measure, stiffness_table};
use crate::fem::elasticity::Lame;
use crate::fem::enhanced::{amplitudes, eliminate, relative};
use crate::fem::error::FemError;
use crate::fem::nouns::{Analysis, Body};
use crate::geometry::{Point, add_scaled, sub};
use crate::mesh::MAX_CELL_NODES;
use rayon::prelude::*;

/// Internal nodal forces (n,) and the strain energy of a body with the given nodal displacements.
///
/// Units: force and energy, for the body's thickness or the full 2π. Errors: a group of cells without a material.
pub(crate) fn internal_forces<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
) -> Result<(Vec<Point<D>>, f64), FemError> {
    let mut forces = vec![[0.0; D]; displacement.len()];
    let mut energy = 0.0;
    for block in body.mesh.blocks() {
        let lame = Lame::new(body.elastic(block)?, analysis);
        let table = stiffness_table::<D>(block.kind, analysis, body.formulation);
        let k = block.kind.nodes();
        let mut cells = vec![([0.0; D], 0.0); block.nodes.len()];
        // each cell writes its own slice; the gather below is in cell order
        cells
            .par_chunks_mut(k * CHUNK)
            .zip(block.nodes.par_chunks(k * CHUNK))
            .for_each(|(out, nodes)| {
                for (out, cell) in out.chunks_exact_mut(k).zip(nodes.chunks_exact(k)) {
                    let (own, stored) =
                        cell_forces(body, analysis, lame, &table, cell, displacement);
                    for (slot, force) in out.iter_mut().zip(own) {
                        slot.0 = force;
                    }
                    out[0].1 = stored;
                }
            });
        for (&node, (force, stored)) in block.nodes.iter().zip(&cells) {
            forces[node as usize] = add_scaled(forces[node as usize], 1.0, *force);
            energy += stored;
        }
    }
    Ok((forces, energy))
}

/// The amplitudes of the incompatible modes of a cell under the given nodal displacements; empty where it has none.
pub(crate) fn mode_amplitudes<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    lame: Lame,
    table: &CellTable<D>,
    cell: &[u32],
    displacement: &[Point<D>],
) -> Vec<Point<D>> {
    if table.count() == cell.len() {
        return Vec::new();
    }
    let size = D * table.count();
    let mut matrix = vec![0.0; size * size];
    cell_stiffness(body, analysis, lame, table, cell, &mut matrix);
    eliminate(&mut matrix, size, D * cell.len());
    amplitudes(&matrix, size, &relative(cell, displacement))
}

/// Adds the part of incompatible modes to the displacement gradient.
pub(crate) fn add_modes<const D: usize>(
    h: &mut [[f64; D]; D],
    modes: &[Point<D>],
    gradients: &[Point<D>],
) {
    for (amplitude, gradient) in modes.iter().zip(gradients) {
        for (row, &a) in h.iter_mut().zip(amplitude) {
            *row = add_scaled(*row, a, *gradient);
        }
    }
}

/// Cells per parallel task.
const CHUNK: usize = 256;

fn cell_forces<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    lame: Lame,
    table: &CellTable<D>,
    cell: &[u32],
    displacement: &[Point<D>],
) -> ([Point<D>; MAX_CELL_NODES], f64) {
    let points = body.mesh.points();
    let first = displacement[cell[0] as usize];
    let modes = mode_amplitudes(body, analysis, lame, table, cell, displacement);
    let mut forces = [[0.0; D]; MAX_CELL_NODES];
    let mut energy = 0.0;
    for q in 0..table.len() {
        let (point, gradients, volume) = table.map(q, |local| points[cell[local] as usize]);
        let mut h = [[0.0; D]; D];
        let mut radial = 0.0;
        for (local, &node) in cell.iter().enumerate() {
            let u = displacement[node as usize];
            let relative = sub(u, first);
            for i in 0..D {
                for j in 0..D {
                    h[i][j] += relative[i] * gradients[local][j];
                }
            }
            radial += table.shape(q)[local] * u[0];
        }
        add_modes(&mut h, &modes, &gradients[cell.len()..]);
        let hoop = if analysis == Analysis::Axisymmetric {
            radial / point[0]
        } else {
            0.0
        };
        let s = lame.stress(h, hoop);
        let sigma = |i: usize, j: usize| s[[[0, 3, 5], [3, 1, 4], [5, 4, 2]][i][j]];
        let w = volume * measure(analysis, body.thickness, point);
        for (local, force) in forces.iter_mut().enumerate().take(cell.len()) {
            for (i, force) in force.iter_mut().enumerate() {
                let along: f64 = (0..D).map(|j| sigma(i, j) * gradients[local][j]).sum();
                *force += w * along;
            }
            if analysis == Analysis::Axisymmetric {
                force[0] += w * s[2] * table.shape(q)[local] / point[0];
            }
        }
        let work: f64 = (0..D)
            .map(|i| (0..D).map(|j| sigma(i, j) * h[i][j]).sum::<f64>())
            .sum();
        energy += 0.5
            * w
            * (work
                + if analysis == Analysis::Axisymmetric {
                    s[2] * hoop
                } else {
                    0.0
                });
    }
    (forces, energy)
}
