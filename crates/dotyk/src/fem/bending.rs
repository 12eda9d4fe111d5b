//! How much of its energy a body of linear cells spends on what they cannot show: a sign that it bends, or that its cells
//! are too large.
//!
//! * Quadrilaterals and hexahedra: the energy that incompatible modes would release at the same displacements of the nodes,
//!   over the energy of the body. Zero under constant stress; close to one where a thin body bends with one cell through its
//!   thickness. The displacements are too small by about as much.
//! * Simplices and prisms have no such modes. There it is the energy of the difference between the stress of the cells and
//!   the continuous one recovered at the nodes, over that of the body: what Zienkiewicz and Zhu take for the error (Int. J.
//!   Numer. Methods Eng. 24 (1987) 337–357).

use crate::fem::block::Cells;
use crate::fem::enhanced::{has_modes, relative, released};
use crate::fem::error::FemError;
use crate::fem::nouns::{Analysis, Body, Formulation};
use crate::geometry::Point;

/// Parts of the energy of a body, those of quadrilaterals and hexahedra, and those of simplices and prisms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unseen {
    pub modes: f64,
    pub jumps: f64,
}

/// Cells of a block that are looked at, spread evenly: a share of the energy of the whole body needs no more.
const LOOKED_AT: usize = 4096;

/// What linear cells of a body in space spend on what they cannot show; zero where it has none, or of several materials at
/// whose borders stresses jump.
///
/// Shapes: displacement and recovered strain (nodes,). Errors: a group of cells without a material.
pub(crate) fn unseen<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
    strain: &[[f64; 6]],
) -> Result<Unseen, FemError> {
    let (mut all, mut modes, mut jumps) = (0.0, 0.0, 0.0);
    for block in body.mesh.blocks() {
        let own = Cells::new(body, block, analysis, Formulation::Displacement)?;
        let energy = |s: [f64; 6]| own.lame.energy(s);
        let linear = block.kind.order() == 1;
        let free = has_modes(block.kind) && body.formulation == Formulation::Displacement;
        let stride = block.cells().len().div_ceil(LOOKED_AT).max(1);
        let (mut own_energy, mut own_jumps) = (0.0, 0.0);
        for cell in block.cells().step_by(stride) {
            for q in 0..own.table.len() {
                let here = own.deformation(q, (cell, &[]), displacement);
                let found = own.lame.stress(here.gradient, 0.0);
                own_energy += here.volume * energy(found);
                if linear && !has_modes(block.kind) && body.materials.len() == 1 {
                    let shape = own.table.shape(q);
                    let recovered = std::array::from_fn(|c| {
                        let nodes = cell.iter().zip(shape);
                        nodes.map(|(&node, n)| n * strain[node as usize][c]).sum()
                    });
                    let recovered = own.lame.stress_of(recovered, analysis);
                    let jump = std::array::from_fn(|c| recovered[c] - found[c]);
                    own_jumps += here.volume * energy(jump);
                }
            }
        }
        let scale = stride as f64;
        all += scale * own_energy;
        jumps += scale * own_jumps;
        if free {
            let free = Cells::new(body, block, analysis, Formulation::Enhanced)?;
            let cells = block.cells().step_by(stride);
            modes += scale * released_by(&free, cells, displacement);
        }
    }
    let part = |energy: f64| if all > 0.0 { energy / all } else { 0.0 };
    Ok(Unseen {
        modes: part(modes),
        jumps: part(jumps),
    })
}

/// The energy that the incompatible modes of some cells would release.
fn released_by<'m, const D: usize>(
    free: &Cells<'_, D>,
    cells: impl Iterator<Item = &'m [u32]>,
    displacement: &[Point<D>],
) -> f64 {
    let size = free.size();
    let mut matrix = vec![0.0; size * size];
    let of_cell = |cell: &[u32]| {
        free.stiffness(cell, &mut matrix);
        released(&matrix, size, &relative(cell, displacement))
    };
    cells.map(of_cell).sum()
}
