//! Excess stiffness of the linear cells of a body, because they bend, keep their volume, or are too large.
//!
//! Such cells lack the part s of their compliance, which is found from the displacements u of their nodes alone. With the strain
//! energy E of the body
//!
//! ```text
//!   s = 1 − (1 − (M + J) / E) / (1 + G / E)
//! ```
//!
//! * M, quadrilaterals and hexahedra: the energy that incompatible modes would release at the same u ([`crate::fem::enhanced`]).
//!   Zero under constant stress; close to E where a thin body bends with one cell through its thickness.
//! * J, simplices and prisms: the energy of the difference between the strain of the cells and
//!   the continuous one recovered at the nodes of the same material, the error estimate of Zienkiewicz and Zhu (Int. J.
//!   Numer. Methods Eng. 24 (1987) 337–357). Where that and the energy of the recovered strain are more than the energy of
//!   the cells, E in the first fraction is their sum.
//! * G, the same cells, nearly incompressible: they resist by pressures that jump from cell to cell, whose energy is small
//!   because the bulk modulus K is large, and that u hardly shows. The difference δp = K (tr ε − tr ε*) from the recovered one
//!   loads the inner nodes by f = ∫ δp ∇N. If it were released, they would move by v = −f / k, k the stiffness of each against
//!   distortion, and one step of steepest descent releases G = (f·v)² / 4 W(v), W the energy of distortion. Pressures that
//!   alternate without forces, as they do in pairs of triangles, add nothing.
//!
//! A body with an initial strain expands without effort: where its strain varies much, its mean, which bends no cell, does not count in E,
//! M and J.

use crate::fem::block::{Cells, Deformation};
use crate::fem::borders::Borders;
use crate::fem::enhanced::{has_modes, relative, released};
use crate::fem::error::FemError;
use crate::fem::nouns::{Analysis, Body, Elastic, Formulation};
use crate::geometry::{Point, dot};
use crate::mesh::{CellBlock, CellKind};

/// Above this Poisson's ratio cells lock by their volume rather than by bending.
pub(crate) const INCOMPRESSIBLE: f64 = 0.45;

/// Cells of a block that are sampled, evenly spread: enough for a share of the energy of the whole body.
const LOOKED_AT: usize = 4096;

/// The compliance that linear cells lack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unseen {
    /// The part of its compliance that a body lacks.
    pub part: f64,
    /// The kind of cells with most of it; `None` without linear cells.
    pub kind: Option<CellKind>,
}

/// Strains whose energy about their mean is below this part of the whole vary at few places alone.
const VARIES: f64 = 0.1;

/// Energies of some cells.
#[derive(Debug, Clone, Copy, Default)]
struct Energies {
    all: f64,
    modes: f64,
    jumps: f64,
    /// Of the recovered strain, where there are jumps.
    smooth: f64,
    /// That of all, with the mean strain.
    with_mean: f64,
}

/// The compliance that the linear cells of a body lack.
///
/// Shapes: displacement (nodes,), recovered strain (places,) of [`Borders`]. Errors: a group of cells without a material; an
/// initial strain that is not finite.
pub(crate) fn unseen<const D: usize>(
    body: &Body<D>,
    (analysis, time): (Analysis, f64),
    displacement: &[Point<D>],
    strain: &[[f64; 6]],
) -> Result<Unseen, FemError> {
    let (mut all, mut excess, mut own, mut freed) = (0.0, 0.0, 0.0, 0.0);
    let (mut most, mut whole_energy) = ((0.0, None), 0.0);
    let borders = Borders::of(body)?;
    let mut whole = Whole {
        body,
        analysis,
        time,
        displacement,
        strain,
        borders: &borders,
        mean: [0.0; 6],
    };
    if body.initial.strain.is_some() {
        whole.mean = whole.mean_strain()?;
    }
    for elastic in elastic(body)? {
        let part = Part { whole, elastic };
        for (place, block) in part.blocks() {
            let found = part.energies(place, block)?;
            all += found.all;
            whole_energy += found.with_mean;
            let unseen = found.modes + found.jumps;
            own += unseen;
            if found.jumps > 0.0 {
                excess += (found.jumps + found.smooth - found.all).max(0.0);
            }
            if unseen > most.0 {
                most = (unseen, Some(block.kind));
            }
        }
        freed += part.freed()?;
    }
    let all = if all > VARIES * whole_energy {
        all
    } else {
        whole_energy
    };
    let part = if all > 0.0 {
        1.0 - (1.0 - own / (all + excess)) / (1.0 + freed / all)
    } else {
        0.0
    };
    Ok(Unseen { part, kind: most.1 })
}

/// The materials of a body.
fn elastic<const D: usize>(body: &Body<D>) -> Result<Vec<Elastic>, FemError> {
    let mut materials: Vec<Elastic> = Vec::new();
    for block in body.mesh.blocks() {
        let elastic = body.elastic(block)?;
        if !materials.contains(&elastic) {
            materials.push(elastic);
        }
    }
    Ok(materials)
}

/// A body, displaced, with the strain recovered at its places.
#[derive(Clone, Copy)]
struct Whole<'a, const D: usize> {
    body: &'a Body<D>,
    analysis: Analysis,
    time: f64,
    displacement: &'a [Point<D>],
    strain: &'a [[f64; 6]],
    borders: &'a Borders,
    /// What does not count of the strain, the same everywhere.
    mean: [f64; 6],
}

impl<const D: usize> Whole<'_, D> {
    /// The mean strain of its displacements. Errors: a group of cells without a material.
    fn mean_strain(&self) -> Result<[f64; 6], FemError> {
        let (mut sum, mut volume) = ([0.0; 6], 0.0);
        for block in self.body.mesh.blocks() {
            let own = Cells::new(self.body, block, self.analysis, Formulation::Displacement)?;
            let stride = block.cells().len().div_ceil(LOOKED_AT).max(1);
            for cell in block.cells().step_by(stride) {
                for q in 0..own.table.len() {
                    let here = own.deformation(q, (cell, &[]), self.displacement);
                    let strain = own.lame.strain(here.gradient, here.hoop);
                    let part = stride as f64 * here.volume;
                    volume += part;
                    let both = sum.iter_mut().zip(strain);
                    both.for_each(|(sum, e)| *sum += part * e);
                }
            }
        }
        Ok(sum.map(|sum| sum / volume))
    }
}

/// The cells of a body that have one material.
struct Part<'a, const D: usize> {
    whole: Whole<'a, D>,
    elastic: Elastic,
}

impl<'a, const D: usize> Part<'a, D> {
    /// Its blocks, with their places among all of the body.
    fn blocks(&self) -> impl Iterator<Item = (usize, &'a CellBlock)> + use<'_, 'a, D> {
        let body = self.whole.body;
        let own =
            |(_, block): &(usize, &CellBlock)| body.elastic(block).is_ok_and(|e| e == self.elastic);
        body.mesh.blocks().iter().enumerate().filter(own)
    }

    /// Whether cells of a kind are judged by the modes that they lack.
    fn lacks_modes(&self, kind: CellKind) -> bool {
        has_modes(kind) && self.whole.body.formulation == Formulation::Displacement
    }

    /// Whether cells of a kind are judged by the jumps from cell to cell.
    fn has_jumps(kind: CellKind) -> bool {
        kind.order() == 1 && !has_modes(kind)
    }

    fn cells(&self, block: &CellBlock, formulation: Formulation) -> Result<Cells<'a, D>, FemError> {
        Cells::new(self.whole.body, block, self.whole.analysis, formulation)
    }

    /// The recovered strain at a point of a cell of a block with these shape functions.
    fn recovered(&self, block: usize, cell: &[u32], shape: &[f64]) -> [f64; 6] {
        let Whole {
            strain, borders, ..
        } = self.whole;
        std::array::from_fn(|c| {
            let nodes = cell.iter().zip(shape);
            let parts = nodes.map(|(&node, n)| n * strain[borders.place(block, node as usize)][c]);
            parts.sum()
        })
    }

    fn energies(&self, place: usize, block: &CellBlock) -> Result<Energies, FemError> {
        let Whole {
            body,
            displacement,
            time,
            mean,
            ..
        } = self.whole;
        let own = self.cells(block, body.formulation)?;
        let of_initial = own.for_initial(block);
        let lacking = self.lacks_modes(block.kind);
        let jumps = Self::has_jumps(block.kind);
        let stride = block.cells().len().div_ceil(LOOKED_AT).max(1);
        let mut sums = Energies::default();
        for cell in block.cells().step_by(stride) {
            let held = body.initial.held_modes(&of_initial, (cell, time))?;
            let modes = own.modes(cell, displacement, &held);
            for q in 0..own.table.len() {
                let here = own.deformation(q, (cell, &modes), displacement);
                let found = own.lame.stress(here.gradient, here.hoop);
                sums.with_mean += here.volume * own.lame.energy(found);
                let found = less(found, own.lame.stress_of(mean, self.whole.analysis));
                sums.all += here.volume * own.lame.energy(found);
                if jumps {
                    let smooth = less(self.recovered(place, cell, own.table.shape(q)), mean);
                    let smooth = own.lame.stress_of(smooth, self.whole.analysis);
                    let jump = less(smooth, found);
                    sums.jumps += here.volume * own.lame.energy(jump);
                    sums.smooth += here.volume * own.lame.energy(smooth);
                }
            }
        }
        if lacking {
            let free = self.cells(block, Formulation::Enhanced)?;
            let cells = block.cells().step_by(stride);
            sums.modes = released_by(&free, cells, displacement);
        }
        let scale = stride as f64;
        Ok(Energies {
            all: scale * sums.all,
            modes: scale * sums.modes,
            jumps: scale * sums.jumps,
            smooth: scale * sums.smooth,
            with_mean: scale * sums.with_mean,
        })
    }

    /// The energy that pressures which jump from cell to cell hold back.
    fn freed(&self) -> Result<f64, FemError> {
        let keeps =
            self.elastic.poisson > INCOMPRESSIBLE && self.whole.analysis != Analysis::PlaneStress;
        let jumping = |(_, block): &(usize, &CellBlock)| Self::has_jumps(block.kind);
        let blocks: Vec<(usize, &CellBlock)> = self.blocks().filter(jumping).collect();
        if !keeps || blocks.is_empty() {
            return Ok(0.0);
        }
        let mut force = vec![[0.0; D]; self.whole.displacement.len()];
        let mut stiffness = force.clone();
        for &(place, block) in &blocks {
            let own = self.cells(block, Formulation::Displacement)?;
            for cell in block.cells() {
                for q in 0..own.table.len() {
                    let here = own.deformation(q, (cell, &[]), self.whole.displacement);
                    let shape = own.table.shape(q);
                    let smooth = trace(self.recovered(place, cell, shape));
                    let own_trace = trace(own.lame.strain(here.gradient, here.hoop));
                    let jump = here.volume * own.lame.bulk() * (own_trace - smooth);
                    let opposed = here.volume * own.lame.mu;
                    for (a, &node) in cell.iter().enumerate() {
                        let (slope, hoop) = (here.gradients[a], self.hoop(&here, shape[a]));
                        for i in 0..D {
                            let hoop = if i == 0 { hoop } else { 0.0 };
                            force[node as usize][i] += jump * (slope[i] + hoop);
                            let both = slope[i] * slope[i] + dot(slope, slope);
                            stiffness[node as usize][i] += opposed * (both + 2.0 * hoop * hoop);
                        }
                    }
                }
            }
        }
        let free = self.inner_nodes(&blocks);
        let nodes = force.iter().zip(&stiffness).zip(&free);
        let motion = |((f, k), free): ((&Point<D>, &Point<D>), &bool)| match free {
            true => std::array::from_fn(|i| f[i] / k[i]),
            false => [0.0; D],
        };
        let motion: Vec<Point<D>> = nodes.map(motion).collect();
        let work: f64 = force.iter().zip(&motion).map(|(f, v)| dot(*f, *v)).sum();
        let mut opposed = 0.0;
        for (_, block) in &blocks {
            let own = self.cells(block, Formulation::Displacement)?;
            for cell in block.cells() {
                for q in 0..own.table.len() {
                    let here = own.deformation(q, (cell, &[]), &motion);
                    let strain = own.lame.strain(here.gradient, here.hoop);
                    opposed += here.volume * own.lame.distortion(strain);
                }
            }
        }
        Ok(if opposed > 0.0 {
            work * work / (4.0 * opposed)
        } else {
            0.0
        })
    }

    /// The hoop strain per radial displacement of a node.
    fn hoop(&self, here: &Deformation<D>, shape: f64) -> f64 {
        match self.whole.analysis {
            Analysis::Axisymmetric => shape / here.point[0],
            _ => 0.0,
        }
    }

    /// Nodes (nodes,) inside some blocks: neither on the boundary nor on cells of other blocks.
    fn inner_nodes(&self, blocks: &[(usize, &CellBlock)]) -> Vec<bool> {
        let mesh = &self.whole.body.mesh;
        let mut inner = vec![false; mesh.points().len()];
        let mut mark = |nodes: &mut dyn Iterator<Item = u32>, value: bool| {
            nodes.for_each(|node| inner[node as usize] = value);
        };
        for (_, block) in blocks {
            mark(&mut block.nodes.iter().copied(), true);
        }
        let others = mesh.blocks().iter();
        for block in
            others.filter(|block| !blocks.iter().any(|(_, own)| std::ptr::eq(*own, *block)))
        {
            mark(&mut block.nodes.iter().copied(), false);
        }
        for facet in mesh.boundary_facets() {
            mark(&mut mesh.facet_nodes(facet), false);
        }
        inner
    }
}

fn less(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|c| a[c] - b[c])
}

fn trace(strain: [f64; 6]) -> f64 {
    strain[..3].iter().sum()
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
        // around an axis a radial motion is a strain
        let motion = match free.analysis {
            Analysis::Axisymmetric => cell
                .iter()
                .flat_map(|&n| displacement[n as usize])
                .collect(),
            _ => relative(cell, displacement),
        };
        released(&matrix, size, &motion)
    };
    cells.map(of_cell).sum()
}
