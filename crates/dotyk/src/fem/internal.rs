//! Internal forces from strains: fₐ = ∫ σ·∇Nₐ dV, cell by cell.
//!
//! K u gives the same numbers, but rounds each entry of K against the whole displacement: a slender body that bends a lot
//! then misses its balance by 1e-9. Here displacements enter as differences within a cell, so that the forces of a cell
//! sum to zero to the rounding of its stresses.

use crate::fem::block::{Cells, Deformation};
use crate::fem::cells::CellTable;
use crate::fem::error::FemError;
use crate::fem::initial::PLACE;
use crate::fem::nouns::{Analysis, Body};
use crate::fem::plastic::{Strained, Yielded, add_cell, plastic_stress};
use crate::geometry::{Point, add_scaled, distance};
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
        let own = Cells::new(body, block, analysis, body.formulation)?;
        let k = block.kind.nodes();
        let mut cells = vec![([0.0; D], 0.0); block.nodes.len()];
        // each cell writes its own slice; the gather below is in cell order
        cells
            .par_chunks_mut(k * CHUNK)
            .zip(block.nodes.par_chunks(k * CHUNK))
            .for_each(|(out, nodes)| {
                for (out, cell) in out.chunks_exact_mut(k).zip(nodes.chunks_exact(k)) {
                    let (forces, stored) = cell_forces(&own, cell, displacement);
                    for (slot, force) in out.iter_mut().zip(forces) {
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

/// Internal forces of single cells by the total stress, that of the displacements and σ₀ − C(ε₀ + ε_p): for cuts through a
/// body.
pub(crate) struct CellForces<'a, const D: usize> {
    /// Plastic strains of each block, `None` without any.
    yielded: Option<Vec<&'a [Strained]>>,
    /// Cells with the rule of the stiffness, and with the rule for initial stresses and strains.
    blocks: Vec<[Cells<'a, D>; 2]>,
    body: &'a Body<D>,
    displacement: &'a [Point<D>],
    time: f64,
}

impl<'a, const D: usize> CellForces<'a, D> {
    /// Cell forces of a body with these nodal displacements at a time. Errors: a group of cells without a material.
    pub fn new(
        (body, analysis): (&'a Body<D>, Analysis),
        (displacement, yielded): (&'a [Point<D>], Option<&'a Yielded>),
        time: f64,
    ) -> Result<Self, FemError> {
        let blocks = body.mesh.blocks().iter().map(|block| {
            let cells = Cells::new(body, block, analysis, body.formulation)?;
            let initial = cells.for_initial(block);
            Ok([cells, initial])
        });
        let yielded = yielded.map(|yielded| yielded.of_blocks(body, analysis));
        Ok(Self {
            yielded: yielded.transpose()?,
            blocks: blocks.collect::<Result<_, _>>()?,
            body,
            displacement,
            time,
        })
    }

    /// Forces of a cell on its nodes, in global axes. Errors: an initial stress or strain that is not finite.
    pub fn of(&self, block: usize, cell: usize) -> Result<[Point<D>; MAX_CELL_NODES], FemError> {
        let nodes = self.body.mesh.cell_nodes(block, cell);
        let [cells, of_initial] = &self.blocks[block];
        let mut forces = cell_forces(cells, nodes, self.displacement).0;
        let own = &mut forces[..nodes.len()];
        let initial = &self.body.initial;
        initial.add_cell(of_initial, (nodes, self.time), own)?;
        if let Some(points) = self.plastic(block, cell) {
            let mut less = [[0.0; D]; MAX_CELL_NODES];
            add_cell(cells, nodes, points, &mut less[..nodes.len()]);
            let both = forces.iter_mut().zip(less);
            both.for_each(|(force, less)| *force = add_scaled(*force, -1.0, less));
        }
        Ok(forces)
    }

    /// Plastic strains of a cell at the points of its stiffness.
    fn plastic(&self, block: usize, cell: usize) -> Option<&'a [Strained]> {
        let count = self.blocks[block][0].table.len();
        let all = self.yielded.as_ref()?[block];
        Some(&all[cell * count..(cell + 1) * count])
    }

    /// Forces of a part of a cell in space on its nodes: ∫σ·∇Nₐ over the points of a rule in it.
    ///
    /// Errors: an initial stress or strain that is not finite.
    pub fn of_part(
        &self,
        block: usize,
        cell: usize,
        rule: &Rule,
    ) -> Result<[Point<D>; MAX_CELL_NODES], FemError> {
        let nodes = self.body.mesh.cell_nodes(block, cell).len();
        let mut forces = [[0.0; D]; MAX_CELL_NODES];
        for (at, stress) in self.stresses(block, cell, rule)? {
            for (force, slope) in forces.iter_mut().zip(&at.gradients).take(nodes) {
                for (i, force) in force.iter_mut().enumerate() {
                    let along = (0..D).map(|j| stress[PLACE[i][j]] * slope[j]);
                    *force += at.volume * along.sum::<f64>();
                }
            }
        }
        Ok(forces)
    }

    /// n·σn at points of a cell, n a unit vector. Errors: as above.
    pub fn normal_stress(
        &self,
        block: usize,
        cell: usize,
        (rule, n): (&Rule, Point<D>),
    ) -> Result<Vec<f64>, FemError> {
        let along = |stress: [f64; 6]| {
            let row = |i: usize| (0..D).map(|j| stress[PLACE[i][j]] * n[j]).sum::<f64>();
            (0..D).map(|i| n[i] * row(i)).sum()
        };
        let stresses = self.stresses(block, cell, rule)?.into_iter();
        Ok(stresses.map(|(_, stress)| along(stress)).collect())
    }

    /// Deformation and total stress at points of a cell.
    fn stresses(
        &self,
        block: usize,
        cell: usize,
        rule: &Rule,
    ) -> Result<Vec<(Deformation<D>, [f64; 6])>, FemError> {
        let kind = self.body.mesh.blocks()[block].kind;
        let nodes = self.body.mesh.cell_nodes(block, cell);
        let cells = &self.blocks[block][0];
        let law = (cells.lame, cells.analysis);
        let modes = cells.modes(nodes, self.displacement, &[]);
        let nearest = self.nearest(block, cell);
        let table = CellTable::at(kind, rule).formulated(kind, self.body.formulation);
        let part = cells.at(table);
        let at_point = |(q, (xi, _)): (usize, &([f64; 3], f64))| {
            let at = part.deformation(q, (nodes, &modes), self.displacement);
            let mut stress = cells.lame.stress(at.gradient, at.hoop);
            let strain = self.body.initial.of_strain(law, at.point, self.time)?;
            let given = self.body.initial.stress_at(at.point, self.time)?;
            for (k, stress) in stress.iter_mut().enumerate() {
                *stress += given[k] + strain[k];
            }
            if let Some(own) = nearest(xi) {
                let plastic = plastic_stress(law.0, law.1, own);
                stress.iter_mut().zip(plastic).for_each(|(s, p)| *s -= p);
            }
            Ok((at, stress))
        };
        rule.iter().enumerate().map(at_point).collect()
    }

    /// In a part of a cell the plastic strain is that of the nearest point; `None` without any.
    fn nearest(&self, block: usize, cell: usize) -> impl Fn(&[f64; 3]) -> Option<&'a Strained> {
        let points = self.plastic(block, cell);
        let points = points.map(|own| (self.blocks[block][0].table.rule(), own));
        move |xi| {
            let (rule, own) = points.as_ref()?;
            let apart = |k: &usize| distance(rule[*k].0, *xi);
            let nearest = (0..rule.len()).min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
            Some(&own[nearest])
        }
    }

    /// Total hoop stress in a part of a cell, or in all of it as its forces are integrated: place, volume and stress at
    /// points of rules, whose sum is the integral. With axial symmetry.
    ///
    /// Errors: an initial stress or strain that is not finite.
    pub fn hoop(
        &self,
        block: usize,
        cell: usize,
        part: Option<&Rule>,
    ) -> Result<Vec<(Point<D>, f64, f64)>, FemError> {
        let kind = self.body.mesh.blocks()[block].kind;
        let nodes = self.body.mesh.cell_nodes(block, cell);
        let [cells, of_initial] = &self.blocks[block];
        let law = (cells.lame, cells.analysis);
        let [elastic, initial] = match part {
            Some(rule) => [rule.clone(), rule.clone()],
            None => [cells.table.rule(), of_initial.table.rule()],
        };
        let nearest = self.nearest(block, cell);
        let hoop = |xi: &[f64; 3]| Some(plastic_stress(law.0, law.1, nearest(xi)?)[2]);
        let cells = cells.at(CellTable::at(kind, &elastic));
        let mut all = Vec::new();
        for (q, (xi, _)) in elastic.iter().enumerate() {
            let at = cells.deformation(q, (nodes, &[]), self.displacement);
            let stress = cells.lame.stress(at.gradient, at.hoop)[2];
            all.push((at.point, at.volume, stress - hoop(xi).unwrap_or(0.0)));
        }
        let cells = cells.at(CellTable::at(kind, &initial));
        for q in 0..initial.len() {
            let at = cells.deformation(q, (nodes, &[]), self.displacement);
            let less = self.body.initial.of_strain(law, at.point, self.time)?;
            let more = self.body.initial.stress_at(at.point, self.time)?;
            all.push((at.point, at.volume, less[2] + more[2]));
        }
        Ok(all)
    }
}

/// Points of a reference cell with their weights.
pub(crate) type Rule = Vec<([f64; 3], f64)>;

/// Cells per parallel task.
const CHUNK: usize = 256;

fn cell_forces<const D: usize>(
    cells: &Cells<'_, D>,
    cell: &[u32],
    displacement: &[Point<D>],
) -> ([Point<D>; MAX_CELL_NODES], f64) {
    let modes = cells.modes(cell, displacement, &[]);
    let axisymmetric = cells.analysis == Analysis::Axisymmetric;
    let mut forces = [[0.0; D]; MAX_CELL_NODES];
    let mut energy = 0.0;
    for q in 0..cells.table.len() {
        let Deformation {
            point,
            gradients,
            volume: w,
            gradient,
            hoop,
        } = cells.deformation(q, (cell, &modes), displacement);
        let s = cells.lame.stress(gradient, hoop);
        let sigma = |i: usize, j: usize| s[PLACE[i][j]];
        for (local, force) in forces.iter_mut().enumerate().take(cell.len()) {
            for (i, force) in force.iter_mut().enumerate() {
                let along: f64 = (0..D).map(|j| sigma(i, j) * gradients[local][j]).sum();
                *force += w * along;
            }
            if axisymmetric {
                force[0] += w * s[2] * cells.table.shape(q)[local] / point[0];
            }
        }
        let work: f64 = (0..D)
            .map(|i| (0..D).map(|j| sigma(i, j) * gradient[i][j]).sum::<f64>())
            .sum();
        let around = if axisymmetric { s[2] * hoop } else { 0.0 };
        energy += 0.5 * w * (work + around);
    }
    (forces, energy)
}
