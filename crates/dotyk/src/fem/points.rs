//! Stress and strain at the points of integration, and nodal forces of the total stress: what other programs print of an answer.

use crate::fem::block::Cells;
use crate::fem::error::FemError;
use crate::fem::internal::CellForces;
use crate::fem::nouns::{Analysis, Body};
use crate::fem::stress::{strain, sum};
use crate::geometry::{Point, add_scaled};

/// Stress and strain (xx yy zz xy yz xz, tensor components) at the points of integration of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct CellPoints {
    /// Index of the block.
    pub block: usize,
    /// Index of the cell in its block.
    pub cell: usize,
    /// Stress at each point; the first reference coordinate runs fastest, the last slowest.
    pub stress: Vec<[f64; 6]>,
    /// Strain there.
    pub strain: Vec<[f64; 6]>,
}

/// Stress and strain at the points at which the stiffness of an elastic body is integrated, cell by cell.
///
/// Errors: a group of cells without a material; an initial stress or strain that is not finite.
pub fn cell_points<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
    time: f64,
) -> Result<Vec<CellPoints>, FemError> {
    let mut all = Vec::new();
    for (index, block) in body.mesh.blocks().iter().enumerate() {
        let cells = Cells::new(body, block, analysis, body.formulation)?;
        let of_initial = cells.for_initial(block);
        let rule = cells.table.rule();
        let mut order: Vec<usize> = (0..rule.len()).collect();
        let backwards = |q: usize| [rule[q].0[2], rule[q].0[1], rule[q].0[0]];
        order.sort_by(|&a, &b| backwards(a).partial_cmp(&backwards(b)).unwrap_or(a.cmp(&b)));
        for (number, cell) in block.cells().enumerate() {
            let held = body.initial.held_modes(&of_initial, (cell, time))?;
            let modes = cells.modes(cell, displacement, &held);
            let mut points = CellPoints {
                block: index,
                cell: number,
                stress: Vec::with_capacity(order.len()),
                strain: Vec::with_capacity(order.len()),
            };
            for &q in &order {
                let here = cells.deformation(q, (cell, &modes), displacement);
                let law = (cells.lame, analysis);
                let held = body.initial.of_strain(law, here.point, time)?;
                let held = sum(held, body.initial.stress_at(here.point, time)?);
                let elastic = cells.lame.stress(here.gradient, here.hoop);
                points.stress.push(sum(elastic, held));
                points.strain.push(strain(body, cells.lame, &here, time)?);
            }
            all.push(points);
        }
    }
    Ok(all)
}

/// Nodal forces ∫ σ·∇Nₐ dV of the total stress of an elastic body (n,): the sum of all forces that act on its nodes.
///
/// Units: force, for the body's thickness or the full 2π. Errors: as [`cell_points`].
pub fn nodal_forces<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
    time: f64,
) -> Result<Vec<Point<D>>, FemError> {
    let forces = CellForces::new((body, analysis), (displacement, None), time)?;
    let mut sums = vec![[0.0; D]; body.mesh.points().len()];
    for (index, block) in body.mesh.blocks().iter().enumerate() {
        for (number, cell) in block.cells().enumerate() {
            for (&node, force) in cell.iter().zip(forces.of(index, number)?) {
                let sum = &mut sums[node as usize];
                *sum = add_scaled(*sum, 1.0, force);
            }
        }
    }
    Ok(sums)
}
