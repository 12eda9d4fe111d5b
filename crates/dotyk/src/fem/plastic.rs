//! Metal that yields: von Mises' criterion with linear isotropic hardening H, at the points of integration of the stiffness.
//!
//! ```text
//!   f = σᵥ − (σ_Y + H p) ≤ 0,        dε_p = dp · 3s/(2σᵥ),        dp ≥ 0,  f dp = 0,        σ = C(ε(u) − ε₀ − ε_p) + σ₀
//! ```
//!
//! with the deviator s of the stress, the plastic strain ε_p and the equivalent plastic strain p. A load step is one implicit
//! increment of them: from those of the step before, the trial stress σ* is returned along its own deviator,
//!
//! ```text
//!   Δp = max(0, σᵥ* − σ_Y − H p⁰)/(3μ + H),        ε_p = ε_p⁰ + Δp · 3s*/(2σᵥ*)
//! ```
//!
//! *Equilibrium.* ε_p enters as an initial strain, like that of temperature (`initial.rs`), and thus the load alone:
//! K u = f + ∫ Cε_p·∇N dV. The stiffness stays that of the elastic body. The unknown is a fixed point,
//! ε_p = R(ε(u(ε_p))). The increment minimises a convex energy whose stiffness is at most C, so that u ← u(R(ε(u))) is
//! a descent that never overshoots; it is accelerated (`model/march/flow.rs`).
//!
//! Cells that flow resist only a part of their change of volume (`volume.rs`). Works and energies of the flow show whether a load is
//! borne by constrained cells instead of the material.
//!
//! Components xx yy zz xy yz xz, tensorial, elongation positive; with axial symmetry zz is the hoop component.
//! Source: as described in J. C. Simo and T. J. R. Hughes, Computational Inelasticity, chapters 2 and 3.

use crate::fem::block::Cells;
use crate::fem::cells::measure;
use crate::fem::elasticity::Lame;
use crate::fem::error::{FemError, show};
use crate::fem::initial::along;
use crate::fem::nouns::{Analysis, Body, Formulation, Material};
use crate::fem::strength::Strength;
use crate::fem::stress::{sum, von_mises};
use crate::fem::volume::{MOST, gives_way, take_linear};
use crate::geometry::{Point, add_scaled, norm};
use crate::mesh::{CellBlock, MAX_CELL_NODES};
use rayon::prelude::*;
use std::ops::Range;

/// How a material yields where its stress reaches its strength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plastic {
    /// H, by how much the yield stress grows with the equivalent plastic strain, ≥ 0, a stress.
    pub hardening: f64,
}

/// The law of the points of some cells.
#[derive(Debug, Clone, Copy)]
struct Metal {
    lame: Lame,
    yield_stress: f64,
    hardening: f64,
}

/// Plastic strain, then the equivalent one, and the change of volume that is not resisted (`volume.rs`).
pub(crate) type Strained = [f64; 8];

/// State of a point in a body that has not yielded.
const NOTHING: Strained = [0.0; 8];

/// Index of the equivalent plastic strain.
const EQUIVALENT: usize = 6;

/// Plastic strains of a body at the points of all cells, in their order, zero where it has not yielded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Yielded(pub Vec<Strained>);

/// Results of an increment of plastic strain.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Increment<const D: usize> {
    /// ∫ C(ε − ε_p)·∇Nₐ dV, the nodal forces of the stress besides the initial one, (nodes,), in global axes.
    pub held: Vec<Point<D>>,
    /// The largest force of the total stress of a cell on a node, for yielding cells within [`SCALES`] of that of their yield stress.
    pub force: f64,
    /// The largest remaining stress beyond the yield stress.
    pub beyond: f64,
    /// The largest von Mises stress before the return.
    pub trial: f64,
    /// Elastic energy, ½∫ (ε − ε_p):C(ε − ε_p) dV.
    pub stored: f64,
    /// ∫ σ:Δε_p dV over the points where it is negative.
    pub gained: f64,
    /// Area of the section, volume in space, of points whose plastic strain is not zero.
    pub extent: f64,
    /// Works and energies of the flow.
    pub flow: Flow,
}

/// Works and energies of the plastic flow in a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Flow {
    /// ∫ σ:Δε_p dV.
    pub dissipated: f64,
    /// The part of that which hardening takes, ∫ H p Δp dV.
    pub hardened: f64,
    /// The largest elastic shear energy there, ∫ (σ_Y + H p)²/6μ dV.
    pub sheared: f64,
    /// Energy of the deviation of the mean stress from its average in each cell.
    pub swings: f64,
}

impl Flow {
    /// A body whose dissipation exceeds its elastic shear energy by this factor is a mechanism: perfect tubes reach 7 to 21 at 0.999
    /// of their collapse load, and 25 to 70 at 0.9999, with b/a of 1.3 to 3 and ν of 0.1 and 0.3.
    const FAR: f64 = 50.0;

    /// Hardening work below this part of the dissipation does not stop a mechanism.
    const FLAT: f64 = 0.02;

    /// In a mechanism the work of the loads is dissipated. If this part of it is stored in mean stresses that oscillate within cells
    /// instead, the material does not bear the load: the cells cannot flow at constant volume, however far they are moved.
    const HELD: f64 = 5e-3;

    /// Loads are borne by constrained cells, and not by their material.
    pub fn is_held_by_cells(self) -> bool {
        let flows = self.dissipated > Self::FAR * self.sheared;
        flows && !self.hardens() && self.swings > Self::HELD * self.dissipated
    }

    /// What flows bears more the farther it flows.
    pub fn hardens(self) -> bool {
        self.hardened >= Self::FLAT * self.dissipated
    }

    fn add(&mut self, other: Self) {
        self.dissipated += other.dissipated;
        self.hardened += other.hardened;
        self.sheared += other.sheared;
        self.swings += other.swings;
    }
}

/// Bounds of the scale of a cell's forces, relative to those of its yield stress; the lower one only where it has yielded. An unloaded
/// cell has no stress, and its nodal forces are rounding of those of Cε_p and Cε, which cancel. Beyond the limit load displacements run
/// away, and with them the rounding of stresses; a scale that followed would hide the imbalance.
const SCALES: [f64; 2] = [1e-2, 10.0];

impl Metal {
    /// The law of a material that yields; `None` if it does not.
    fn of(material: &Material, analysis: Analysis) -> Option<Self> {
        let (Some(plastic), Some(Strength::VonMises { yield_stress })) =
            (material.plastic, material.strength)
        else {
            return None;
        };
        Some(Self {
            lame: Lame::new(material.elastic, analysis),
            yield_stress,
            hardening: plastic.hardening,
        })
    }

    /// The yield stress at the equivalent plastic strain p.
    fn strength(self, p: f64) -> f64 {
        self.yield_stress + self.hardening * p
    }

    /// Excess of a stress beyond the yield stress.
    fn beyond(self, stress: [f64; 6], p: f64) -> f64 {
        von_mises(stress) - self.strength(p)
    }

    /// The plastic strain after the return of a trial stress, the stress at the plastic strain of before.
    fn returned(self, trial: [f64; 6], before: Strained) -> Strained {
        let beyond = self.beyond(trial, before[EQUIVALENT]);
        if beyond <= 0.0 {
            return before;
        }
        let more = beyond / (3.0 * self.lame.mu + self.hardening);
        let mean = (trial[0] + trial[1] + trial[2]) / 3.0;
        let along = 1.5 * more / von_mises(trial);
        std::array::from_fn(|c| match c {
            0..3 => before[c] + along * (trial[c] - mean),
            3..6 => before[c] + along * trial[c],
            6 => before[c] + more,
            _ => before[c],
        })
    }
}

impl<const D: usize> Body<D> {
    /// Some material of it yields.
    pub fn is_plastic(&self) -> bool {
        self.materials.iter().any(|m| m.plastic.is_some())
    }

    /// Errors: a material that yields without a strength or with an unsupported one; a negative hardening; an analysis or formulation
    /// without plasticity.
    pub(crate) fn check_plastic(&self, analysis: Analysis) -> Result<(), FemError> {
        for material in &self.materials {
            let Some(plastic) = material.plastic else {
                continue;
            };
            plastic.check(material.strength.as_ref())?;
        }
        let why = match (self.is_plastic(), analysis, self.formulation) {
            (false, ..) => return Ok(()),
            (_, Analysis::PlaneStress, _) => {
                "is not supported yet in plane stress: use plane strain, axial symmetry or space"
            }
            (_, _, Formulation::Enhanced) => {
                "is not supported yet with `formulation = \"enhanced\"`: use quadratic cells"
            }
            _ => return Ok(()),
        };
        Err(FemError::Plastic { why })
    }

    /// Errors: an initial stress outside the yield surface at a time, where the body has not yielded yet.
    pub(crate) fn check_initial(&self, analysis: Analysis, time: f64) -> Result<(), FemError> {
        if self.initial.stress.is_none() || !self.is_plastic() {
            return Ok(());
        }
        let nodes = self.mesh.points();
        let mut worst: Option<(f64, f64, Point<D>)> = None;
        for own in points(self, analysis)? {
            let Some(metal) = own.metal else { continue };
            let table = &own.cells.table;
            let places = own.block.cells().flat_map(|cell| {
                (0..table.len()).map(move |q| table.map(q, |local| nodes[cell[local] as usize]).0)
            });
            let places: Vec<Point<D>> = places.collect();
            self.initial.prepare_stress(&places, time);
            for place in places {
                let stress = self.initial.stress_at(place, time)?;
                let beyond = metal.beyond(stress, 0.0);
                let least = worst.map_or(UNBORNE * metal.yield_stress, |(most, ..)| most);
                if beyond > least {
                    worst = Some((beyond, von_mises(stress), place));
                }
            }
        }
        match worst {
            None => Ok(()),
            Some((beyond, stress, place)) => Err(FemError::Unborne {
                place: show(place),
                stress,
                beyond,
            }),
        }
    }
}

/// An initial stress beyond the yield surface by this part of the yield stress is outside.
const UNBORNE: f64 = 1e-9;

impl Plastic {
    /// Checks its constants, and the strength at which yielding begins.
    ///
    /// Errors: [`FemError::Plastic`] and [`FemError::Material`] with the reason.
    pub(crate) fn check(&self, strength: Option<&Strength>) -> Result<(), FemError> {
        if !(self.hardening >= 0.0 && self.hardening.is_finite()) {
            return Err(FemError::Material {
                name: "hardening",
                value: self.hardening,
                range: "it must not be negative",
            });
        }
        match strength {
            Some(Strength::VonMises { .. }) => Ok(()),
            Some(_) => Err(FemError::Plastic {
                why: "is supported for von Mises' criterion alone so far, `strength = { yield = .. }`",
            }),
            None => Err(FemError::Plastic {
                why: "needs a strength at which it begins: add `strength = { yield = .. }`",
            }),
        }
    }
}

/// The points of a block of cells.
pub(super) struct Points<'a, const D: usize> {
    pub block: &'a CellBlock,
    pub cells: Cells<'a, D>,
    /// `None`: they do not yield.
    metal: Option<Metal>,
    /// Their places among all points of the body.
    pub range: Range<usize>,
}

/// The points of all blocks of a body. Errors: a group of cells without a material.
pub(super) fn points<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
) -> Result<Vec<Points<'_, D>>, FemError> {
    let mut end = 0;
    let blocks = body.mesh.blocks().iter().map(|block| {
        let cells = Cells::new(body, block, analysis, body.formulation)?;
        let start = end;
        end += cells.table.len() * block.cells().len();
        Ok(Points {
            block,
            metal: Metal::of(body.material(block)?, analysis),
            cells,
            range: start..end,
        })
    });
    blocks.collect()
}

impl Yielded {
    /// No point has yielded.
    pub fn is_nothing(&self) -> bool {
        self.0.iter().all(|point| point[EQUIVALENT] == 0.0)
    }

    /// Zero plastic strains. Errors: a group of cells without a material.
    pub fn nothing<const D: usize>(body: &Body<D>, analysis: Analysis) -> Result<Self, FemError> {
        let points = points(body, analysis)?;
        Ok(Self(vec![
            NOTHING;
            points.last().map_or(0, |last| last.range.end)
        ]))
    }

    /// The plastic strains of each block of a body, (cells · points,).
    ///
    /// Errors: a group of cells without a material.
    pub fn of_blocks<const D: usize>(
        &self,
        body: &Body<D>,
        analysis: Analysis,
    ) -> Result<Vec<&[Strained]>, FemError> {
        let points = points(body, analysis)?.into_iter();
        Ok(points.map(|own| &self.0[own.range]).collect())
    }

    /// The plastic strains under nodal displacements at a time, from these of before. With the first point that yields a body flows, and
    /// its cells change volume as in `volume.rs`; if it `gives_way` they do so anyway. Yielding does not depend on the mean stress: these
    /// displacements alone determine it.
    ///
    /// Errors: a group of cells without a material; an initial stress or strain that is not finite.
    pub fn returned<const D: usize>(
        &self,
        of: (&Body<D>, Analysis),
        state: (&[Point<D>], f64),
        gives_way: bool,
    ) -> Result<Self, FemError> {
        let flows = gives_way || !self.is_nothing();
        let after = self.after(of, state, flows)?;
        match flows || after.is_nothing() {
            true => Ok(after),
            false => self.after(of, state, true),
        }
    }

    fn after<const D: usize>(
        &self,
        (body, analysis): (&Body<D>, Analysis),
        state: (&[Point<D>], f64),
        flows: bool,
    ) -> Result<Self, FemError> {
        let mut after = self.clone();
        for own in points(body, analysis)? {
            let (cells, Some(metal)) = (&own.cells, own.metal) else {
                continue;
            };
            let (count, k) = (cells.table.len(), own.block.kind.nodes());
            let gives_way = flows && gives_way(own.block.kind);
            after.0[own.range]
                .par_chunks_mut(count)
                .zip(own.block.nodes.par_chunks(k))
                .with_min_len(CHUNK)
                .try_for_each(|(points, cell)| {
                    if gives_way {
                        give_way(cells, cell, state.0, points);
                    }
                    for (q, point) in points.iter_mut().enumerate() {
                        let trial = stress(body, cells, (cell, q), state, point)?;
                        *point = metal.returned(trial, *point);
                    }
                    Ok(())
                })?;
        }
        Ok(after)
    }

    /// The increment from `before` to here, under nodal displacements at a time.
    ///
    /// Errors: those of [`Self::returned`].
    pub fn since<const D: usize>(
        &self,
        before: &Self,
        (body, analysis): (&Body<D>, Analysis),
        state: (&[Point<D>], f64),
    ) -> Result<Increment<D>, FemError> {
        let mut done = Increment {
            held: vec![[0.0; D]; state.0.len()],
            ..Increment::default()
        };
        for own in points(body, analysis)? {
            let (cells, count) = (&own.cells, own.cells.table.len());
            let mut each = self.0[own.range.clone()].iter().zip(&before.0[own.range]);
            for cell in own.block.cells() {
                let mut forces = [[[0.0; D]; MAX_CELL_NODES]; 2];
                let mut borne = [0.0; MAX_CELL_NODES];
                let (mut flow, mut swelling) = (Flow::default(), [0.0; 3]);
                for (q, (now, before)) in (&mut each).take(count).enumerate() {
                    let here = cells.deformation(q, (cell, &[]), state.0);
                    let (strain, rest) =
                        (cells.lame.strain(here.gradient, here.hoop), inelastic(now));
                    let elastic = std::array::from_fn(|c| strain[c] - rest[c]);
                    let own_stress = cells.lame.stress_of(elastic, analysis);
                    let found = stress(body, cells, (cell, q), state, now)?;
                    for (forces, stress) in forces.iter_mut().zip([own_stress, found]) {
                        add_stress(cells, (cell, q), stress, &mut forces[..cell.len()]);
                    }
                    done.stored += 0.5 * here.volume * work(own_stress, elastic);
                    let Some(metal) = own.metal else { continue };
                    let mut start = *before;
                    start[7] = now[7];
                    let trial = stress(body, cells, (cell, q), state, &start)?;
                    done.beyond = done.beyond.max(metal.beyond(found, now[EQUIVALENT]));
                    for (borne, gradient) in borne.iter_mut().zip(&here.gradients) {
                        *borne += here.volume * metal.strength(now[EQUIVALENT]) * norm(*gradient);
                    }
                    done.trial = done.trial.max(von_mises(trial));
                    if now[EQUIVALENT] == 0.0 {
                        continue;
                    }
                    let more = std::array::from_fn(|c| now[c] - before[c]);
                    let dissipated = here.volume * work(found, more);
                    done.gained += dissipated.min(0.0);
                    let strength = metal.strength(now[EQUIVALENT]);
                    flow.add(Flow {
                        dissipated,
                        hardened: here.volume
                            * metal.hardening
                            * now[EQUIVALENT]
                            * (now[EQUIVALENT] - before[EQUIVALENT]),
                        sheared: here.volume * strength.powi(2) / (6.0 * cells.lame.mu),
                        swings: 0.0,
                    });
                    let change = elastic[0] + elastic[1] + elastic[2];
                    for (sum, power) in swelling.iter_mut().zip([1.0, change, change * change]) {
                        *sum += here.volume * power;
                    }
                    done.extent += here.volume / measure(analysis, body.thickness, here.point);
                }
                let [held, whole] = forces;
                for (&node, force) in cell.iter().zip(held) {
                    let sum = &mut done.held[node as usize];
                    *sum = add_scaled(*sum, 1.0, force);
                }
                if own.metal.is_some() {
                    let [volume, sum, squares] = swelling;
                    if volume > 0.0 {
                        flow.swings = 0.5 * cells.lame.bulk() * (squares - sum * sum / volume);
                    }
                    done.flow.add(flow);
                    let [whole, borne] = [largest(whole.into_iter().map(norm)), largest(borne)];
                    let [least, most] = SCALES.map(|part| part * borne);
                    let least = if volume > 0.0 { least } else { 0.0 };
                    // no `clamp`: displacements that run away may give NaN
                    done.force = done.force.max(whole.min(most).max(least));
                }
            }
        }
        Ok(done)
    }

    /// The difference to other plastic strains.
    pub fn less(mut self, other: Option<&Self>) -> Self {
        let both = self.0.iter_mut().zip(other.into_iter().flat_map(|o| &o.0));
        for (own, other) in both {
            own.iter_mut().zip(other).for_each(|(a, b)| *a -= b);
        }
        self
    }

    /// ∫ Cε_p·∇Nₐ dV, the load of the plastic strain, (nodes,), in global axes.
    ///
    /// Errors: a group of cells without a material.
    pub fn forces<const D: usize>(
        &self,
        body: &Body<D>,
        analysis: Analysis,
    ) -> Result<Vec<Point<D>>, FemError> {
        let mut forces = vec![[0.0; D]; body.mesh.points().len()];
        for own in points(body, analysis)? {
            let (cells, k) = (&own.cells, own.block.kind.nodes());
            let mut of_cells = vec![[0.0; D]; own.block.nodes.len()];
            (of_cells.par_chunks_mut(k))
                .zip(own.block.nodes.par_chunks(k))
                .zip(self.0[own.range].par_chunks(cells.table.len()))
                .with_min_len(CHUNK)
                .for_each(|((out, cell), points)| add_cell(cells, cell, points, out));
            for (&node, force) in own.block.nodes.iter().zip(of_cells) {
                forces[node as usize] = add_scaled(forces[node as usize], 1.0, force);
            }
        }
        Ok(forces)
    }
}

/// The largest of some numbers ≥ 0; zero without any.
fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// σ:ε.
fn work(stress: [f64; 6], strain: [f64; 6]) -> f64 {
    let part = |c: usize| stress[c] * strain[c] * if c < 3 { 1.0 } else { 2.0 };
    (0..6).map(part).sum()
}

/// Adds ∫ Cε_p·∇Nₐ dV of one cell, whose points have these plastic strains, to forces on its nodes.
pub(crate) fn add_cell<const D: usize>(
    cells: &Cells<'_, D>,
    cell: &[u32],
    points: &[Strained],
    forces: &mut [Point<D>],
) {
    let yielded = points.iter().enumerate();
    for (q, point) in yielded.filter(|(_, point)| **point != NOTHING) {
        let less = plastic_stress(cells.lame, cells.analysis, point);
        add_stress(cells, (cell, q), less, forces);
    }
}

/// Adds the nodal forces of a stress at a point of a cell, σ·∇Nₐ dV.
fn add_stress<const D: usize>(
    cells: &Cells<'_, D>,
    (cell, q): (&[u32], usize),
    stress: [f64; 6],
    forces: &mut [Point<D>],
) {
    let (at, gradients, weight) = cells.map(q, cell);
    let nodes = forces.iter_mut().zip(&gradients).zip(cells.table.shape(q));
    for ((force, gradient), shape) in nodes {
        *force = add_scaled(*force, weight, along(stress, *gradient));
        if cells.analysis == Analysis::Axisymmetric {
            force[0] += weight * stress[2] * shape / at[0];
        }
    }
}

/// Inelastic strain: the plastic one, and the change of volume that is not resisted.
pub(super) fn inelastic(point: &Strained) -> [f64; 6] {
    std::array::from_fn(|c| point[c] + if c < 3 { point[7] / 3.0 } else { 0.0 })
}

/// C of that.
pub(crate) fn plastic_stress(lame: Lame, analysis: Analysis, point: &Strained) -> [f64; 6] {
    lame.stress_of(inelastic(point), analysis)
}

/// Sets the unresisted change of volume at the points of a cell under nodal displacements.
fn give_way<const D: usize>(
    cells: &Cells<'_, D>,
    cell: &[u32],
    displacement: &[Point<D>],
    points: &mut [Strained],
) {
    let (mut changes, mut volumes) = ([0.0; MOST], [0.0; MOST]);
    for (q, (change, volume)) in changes
        .iter_mut()
        .zip(&mut volumes)
        .take(points.len())
        .enumerate()
    {
        let here = cells.deformation(q, (cell, &[]), displacement);
        let strain = cells.lame.strain(here.gradient, here.hoop);
        (*change, *volume) = (strain[0] + strain[1] + strain[2], here.volume);
    }
    let changes = &mut changes[..points.len()];
    take_linear(D, (cells.table.places(), &volumes), changes);
    let both = points.iter_mut().zip(changes);
    both.for_each(|(point, change)| point[7] = *change);
}

/// The total stress of a point of a cell that has this plastic strain.
pub(crate) fn stress<const D: usize>(
    body: &Body<D>,
    cells: &Cells<'_, D>,
    (cell, q): (&[u32], usize),
    (displacement, time): (&[Point<D>], f64),
    plastic: &Strained,
) -> Result<[f64; 6], FemError> {
    let here = cells.deformation(q, (cell, &[]), displacement);
    let law = (cells.lame, cells.analysis);
    let elastic = cells.lame.stress(here.gradient, here.hoop);
    let less = plastic_stress(cells.lame, cells.analysis, plastic);
    let strain = body.initial.of_strain(law, here.point, time)?;
    let stress = body.initial.stress_at(here.point, time)?;
    let elastic = std::array::from_fn(|c| elastic[c] - less[c]);
    Ok(sum(sum(elastic, strain), stress))
}

/// Cells per parallel task.
const CHUNK: usize = 64;
