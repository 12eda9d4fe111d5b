//! Initial state of a body: a stress σ₀ (in-situ stress of ground) and a strain ε₀ (temperature, shrinkage, swelling).
//!
//! ```text
//!   σ = C(ε(u) − ε₀) + σ₀,        ∫ σ·∇Nₐ dV = fₐ    ⟺    K u = f − ∫ (σ₀ − Cε₀)·∇Nₐ dV
//! ```
//!
//! so that both enter the load alone, and u = 0 where σ₀ balances the loads. The forces of σ₀ − Cε₀ sum to zero in every
//! cell, do no work on rigid motions, and are integrated as exactly as the body force: expressions in equilibrium are in
//! equilibrium at the nodes, too, also in curved cells.
//!
//! The incompatible modes of enhanced cells (`enhanced.rs`) respond to ε₀, but neither to σ₀ nor to the body force, which balance each
//! other: the stress of other loads adds to σ₀, and undisturbed ground does not move in these modes either.
//!
//! *Rest.* The unbalanced part of the loads is a difference of large forces. Gradients of shape functions have the rounding of
//! coordinates x relative to the size h of the cell, and expressions that of the largest stress, so that a nodal force is known to
//!
//! ```text
//!   a few ε · max|σ| (h + |x|) h^(D−2) per cell,      ε the unit of rounding
//! ```
//!
//! and is set to zero where it is less: undisturbed ground is at rest, not loaded by rounding.
//!
//! Tensile stress and elongation are positive; components xx yy zz xy yz xz, of strains tensorial (half the shear angle);
//! with axial symmetry zz is the hoop component.

use crate::fem::block::Cells;
use crate::fem::cells::measure;
use crate::fem::elasticity::Lame;
use crate::fem::error::FemError;
use crate::fem::loads::{Load, add_body_force, prepare_within};
use crate::fem::nouns::{Analysis, Body, Place};
use crate::fem::stress::sampled_points;
use crate::fem::supports::{finite, nearest_node};
use crate::geometry::{Field, Point, add_scaled, bounding_box, cross, distance, norm, padded};
use crate::mesh::{CellBlock, Facet};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Components xx yy zz xy yz xz of a stress or strain that may depend on place and time.
#[derive(Debug, Clone)]
pub struct Components(pub [Field; 6]);

impl Components {
    /// The same along xx, yy and zz, without shear: a negative pressure, or an isotropic strain.
    pub fn isotropic(value: Field) -> Self {
        let direct = [value.clone(), value.clone(), value];
        let [xx, yy, zz] = direct;
        let none = || Field::constant(0.0);
        Self([xx, yy, zz, none(), none(), none()])
    }

    /// The stress of ground, tension positive, along a vertical n of any length and sign, and `k0` times it across:
    ///
    /// ```text
    ///   σ₀ = s (n nᵀ + k₁ a aᵀ + k₂ b bᵀ),        n, a, b orthonormal
    /// ```
    ///
    /// In the plane a lies in it and b out of it; with axial symmetry b is the hoop direction; in space a and b are the two axes
    /// beside that of n, in their order, turned as little as makes them horizontal where n is oblique.
    pub fn ground<const D: usize>(vertical: Point<D>, stress: Field, k0: [Field; 2]) -> Self {
        let [n, a, b] = triad(padded(vertical));
        let directions = [
            (n, Field::constant(1.0)),
            (a, k0[0].clone()),
            (b, k0[1].clone()),
        ];
        let component = |c: usize| {
            let (i, j) = AXES[c];
            let parts = directions.iter().filter_map(|(d, k)| match d[i] * d[j] {
                0.0 => None,
                1.0 => Some(k.clone()),
                part => Some(Field::constant(part) * k.clone()),
            });
            let factor = parts.reduce(|sum, part| sum + part);
            match factor.map(|factor| (factor.as_constant(), factor)) {
                None => Field::constant(0.0),
                Some((Some(1.0), _)) => stress.clone(),
                Some((_, factor)) => factor * stress.clone(),
            }
        };
        Self(std::array::from_fn(component))
    }

    /// Values at a point and time; those of some expressions may not be finite.
    pub fn at<const D: usize>(&self, point: Point<D>, time: f64) -> [f64; 6] {
        std::array::from_fn(|c| self.0[c].at(point, time))
    }

    /// As [`Self::at`]; an error names the first expression that is not finite.
    pub(crate) fn finite_at<const D: usize>(
        &self,
        what: &str,
        point: Point<D>,
        time: f64,
    ) -> Result<[f64; 6], FemError> {
        let mut values = [0.0; 6];
        for ((value, field), name) in values.iter_mut().zip(&self.0).zip(NAMES) {
            *value = finite(field, point, time, || format!("{what} {name}"))?;
        }
        Ok(values)
    }

    /// The traction σ·n on a face with the outward unit normal n.
    pub fn traction<const D: usize>(
        &self,
        point: Point<D>,
        normal: Point<D>,
        time: f64,
    ) -> Point<D> {
        along(self.at(point, time), normal)
    }
}

/// Names of the components.
pub const NAMES: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "xz"];

/// The axes of each component.
const AXES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];

/// The unit vector of n, the first axis other than that of its largest component, made perpendicular to it, and the one across both.
fn triad(n: [f64; 3]) -> [[f64; 3]; 3] {
    let size = norm(n);
    let n = n.map(|c| c / size);
    let own = (0..3).fold(0, |own, axis| match n[axis].abs() > n[own].abs() {
        true => axis,
        false => own,
    });
    let first = usize::from(own == 0);
    let mut a = add_scaled([0.0; 3], -n[first], n);
    a[first] += 1.0;
    let length = norm(a);
    let a = a.map(|c| c / length);
    [n, a, cross(n, a)]
}

/// Index of a component σᵢⱼ.
pub(crate) const PLACE: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Initial state of a body.
#[derive(Debug, Clone, Default)]
pub struct Initial {
    /// σ₀, a total stress.
    pub stress: Option<Components>,
    /// Pressure of the water in its pores, a part of σ₀ already ([`Self::with_pores`]): the grains bear σ + p, and their strength is that
    /// of this effective stress.
    pub pore: Option<Field>,
    /// ε₀.
    pub strain: Option<Components>,
    /// The vertical of a stress given by [`Components::ground`]: the body force must act along it.
    pub vertical: Option<[f64; 3]>,
}

/// The material of some cells in an analysis.
type Law = (Lame, Analysis);

impl Initial {
    /// The same state with water in the pores, whose pressure −p adds to the stress so far, that between the grains:
    ///
    /// ```text
    ///   σ = σ′ − p 1,       div σ + b = 0:   grains bear b − grad p, with b the weight of both
    /// ```
    pub fn with_pores(mut self, pressure: Field) -> Self {
        let [xx, yy, zz, xy, yz, xz] = match self.stress.take() {
            Some(Components(stress)) => stress,
            None => std::array::from_fn(|_| Field::constant(0.0)),
        };
        let less = |stress: Field| stress + Field::constant(-1.0) * pressure.clone();
        self.stress = Some(Components([less(xx), less(yy), less(zz), xy, yz, xz]));
        self.pore = Some(pressure);
        self
    }

    /// The pore pressure at a point; `None` without water.
    ///
    /// Errors: an expression that is not finite.
    pub(crate) fn pore_at<const D: usize>(
        &self,
        point: Point<D>,
        time: f64,
    ) -> Result<Option<f64>, FemError> {
        let pore = self.pore.as_ref();
        pore.map(|pore| finite(pore, point, time, || "pore_pressure".to_string()))
            .transpose()
    }

    /// Why an analysis does not allow this, if so.
    pub fn unfit(&self, analysis: Analysis) -> Option<&'static str> {
        let has = |of: &Option<Components>, component: usize| {
            let field = of.as_ref().map(|values| &values.0[component]);
            field.is_some_and(|field| field.as_constant() != Some(0.0))
        };
        let shear = |of: &Option<Components>| has(of, 4) || has(of, 5);
        let [stress, strain] = [&self.stress, &self.strain];
        match analysis {
            Analysis::Axisymmetric if self.vertical.is_some_and(|n| n[0] != 0.0) => {
                Some("with axial symmetry the vertical is the axis: its direction is [0, 1]")
            }
            Analysis::PlaneStress if self.pore.is_some() => {
                Some("in plane stress nothing presses across the plane, and water in pores would")
            }
            Analysis::PlaneStress if has(stress, 2) || shear(stress) => {
                Some("in plane stress zz, yz and xz of the initial stress must be zero")
            }
            Analysis::Axisymmetric if shear(stress) || shear(strain) => Some(
                "a body that is symmetric about its axis does not twist: yz and xz must be zero",
            ),
            Analysis::PlaneStress | Analysis::PlaneStrain if shear(strain) => Some(
                "a plane body does not move out of its plane: yz and xz of the initial strain must be zero",
            ),
            _ => None,
        }
    }

    /// −Cε₀ at a point, the stress of the initial strain at zero displacement.
    ///
    /// Errors: an expression that is not finite.
    pub(crate) fn of_strain<const D: usize>(
        &self,
        (lame, analysis): Law,
        point: Point<D>,
        time: f64,
    ) -> Result<[f64; 6], FemError> {
        let Some(strain) = &self.strain else {
            return Ok([0.0; 6]);
        };
        let strain = strain.finite_at("initial_strain", point, time)?;
        Ok(lame.stress_of(strain, analysis).map(|s| -s))
    }

    /// What the initial strain adds to the strain across the plane in plane stress: ε₀zz + ν/(1 − ν) (ε₀xx + ε₀yy), as the elastic
    /// strain alone leaves σzz = 0. Zero in other analyses.
    ///
    /// Errors: an expression that is not finite.
    pub(crate) fn across<const D: usize>(
        &self,
        lame: Lame,
        point: Point<D>,
        time: f64,
    ) -> Result<f64, FemError> {
        let Some(strain) = self.strain.as_ref().filter(|_| lame.is_flat()) else {
            return Ok(0.0);
        };
        let [xx, yy, zz, ..] = strain.finite_at("initial_strain", point, time)?;
        Ok(zz + lame.lambda / (2.0 * lame.mu) * (xx + yy))
    }

    /// σ₀ at a point. Errors: an expression that is not finite.
    pub(crate) fn stress_at<const D: usize>(
        &self,
        point: Point<D>,
        time: f64,
    ) -> Result<[f64; 6], FemError> {
        // told by its own name, although it is part of the stress
        self.pore_at(point, time)?;
        match &self.stress {
            Some(stress) => stress.finite_at("initial_stress", point, time),
            None => Ok([0.0; 6]),
        }
    }

    /// Prepares σ₀ at some points.
    pub(crate) fn prepare_stress<const D: usize>(&self, points: &[Point<D>], time: f64) {
        let stress = self.stress.iter().flat_map(|stress| &stress.0);
        let fields: Vec<&Field> = stress.chain(&self.pore).collect();
        if fields.iter().any(|field| field.is_sampled()) {
            Field::prepare(fields, points.iter().copied(), time);
        }
    }

    /// Prepares both at all points where they are evaluated, those of the recovery of stresses included.
    fn prepare<const D: usize>(&self, body: &Body<D>, time: f64) {
        let stress = self.stress.iter().flat_map(|stress| &stress.0);
        let stress: Vec<&Field> = stress.chain(&self.pore).collect();
        if !stress.is_empty() {
            prepare_within(body, stress, || body.mesh.points().to_vec(), time);
        }
        if let Some(strain) = &self.strain {
            prepare_within(body, &strain.0, || sampled_points(&body.mesh), time);
        }
    }

    /// The nodal forces that hold σ₀ − Cε₀ in each cell of a block, (nodes of the block's cells,), in global axes:
    /// ∫ σ·∇Nₐ dV of the cell alone, with thickness or 2πr; and the largest component of σ₀ or Cε₀. `None` without an initial state.
    ///
    /// Errors: an expression that is not finite; a group of cells without a material.
    pub(crate) fn cell_forces<const D: usize>(
        &self,
        body: &Body<D>,
        block: &CellBlock,
        analysis: Analysis,
        time: f64,
    ) -> Result<Option<(Vec<Point<D>>, f64)>, FemError> {
        if self.stress.is_none() && self.strain.is_none() {
            return Ok(None);
        }
        let cells = Cells::new(body, block, analysis, body.formulation)?.for_initial(block);
        self.prepare(body, time);
        let k = block.kind.nodes();
        let mut forces = vec![[0.0; D]; block.nodes.len()];
        let largest = forces
            .par_chunks_mut(k * CHUNK)
            .zip(block.nodes.par_chunks(k * CHUNK))
            .map(|(out, nodes)| {
                let mut largest = 0.0f64;
                for (out, cell) in out.chunks_exact_mut(k).zip(nodes.chunks_exact(k)) {
                    largest = largest.max(self.add_cell(&cells, (cell, time), out)?);
                }
                Ok(largest)
            })
            .try_reduce(|| 0.0, |a, b| Ok(f64::max(a, b)))?;
        Ok(Some((forces, largest)))
    }

    /// The forces that hold −Cε₀ in the incompatible modes of one cell, (modes,), by the rule of these cells; empty without modes or
    /// without a strain.
    ///
    /// Errors: an expression that is not finite.
    pub(crate) fn held_modes<const D: usize>(
        &self,
        cells: &Cells<'_, D>,
        (cell, time): (&[u32], f64),
    ) -> Result<Vec<Point<D>>, FemError> {
        let count = cells.table.count() - cell.len();
        if count == 0 || self.strain.is_none() {
            return Ok(Vec::new());
        }
        let mut held = vec![[0.0; D]; count];
        for q in 0..cells.table.len() {
            let (point, gradients, weight) = cells.map(q, cell);
            let stress = self.of_strain((cells.lame, cells.analysis), point, time)?;
            for (held, gradient) in held.iter_mut().zip(&gradients[cell.len()..]) {
                *held = add_scaled(*held, weight, along(stress, *gradient));
            }
        }
        Ok(held)
    }

    /// Adds the forces of one cell, (nodes of the cell,), by the rule of these cells, and returns the largest component of σ₀ or
    /// Cε₀; `None` without an initial state.
    ///
    /// Errors: an expression that is not finite.
    pub(crate) fn add_cell<const D: usize>(
        &self,
        cells: &Cells<'_, D>,
        (cell, time): (&[u32], f64),
        forces: &mut [Point<D>],
    ) -> Result<f64, FemError> {
        let mut largest = 0.0f64;
        if self.stress.is_none() && self.strain.is_none() {
            return Ok(largest);
        }
        let law = (cells.lame, cells.analysis);
        for q in 0..cells.table.len() {
            let (point, gradients, weight) = cells.map(q, cell);
            let mut stress = self.of_strain(law, point, time)?;
            let initial = self.stress_at(point, time)?;
            let parts = stress.iter().chain(&initial);
            largest = parts.fold(largest, |largest, s| largest.max(s.abs()));
            stress.iter_mut().zip(initial).for_each(|(s, i)| *s += i);
            let nodes = forces.iter_mut().zip(&gradients);
            for ((force, gradient), shape) in nodes.zip(cells.table.shape(q)) {
                *force = add_scaled(*force, weight, along(stress, *gradient));
                if law.1 == Analysis::Axisymmetric {
                    force[0] += weight * stress[2] * shape / point[0];
                }
            }
        }
        cells.hand_on(cell, &self.held_modes(cells, (cell, time))?, forces);
        Ok(largest)
    }

    /// Adds the load −∫ (σ₀ − Cε₀)·∇Nₐ dV to nodal forces (D·n,) of a body in global axes; `None` without an initial state.
    ///
    /// Errors: an expression that is not finite; a group of cells without a material.
    pub(crate) fn add_load<const D: usize>(
        &self,
        body: &Body<D>,
        analysis: Analysis,
        time: f64,
        forces: &mut [f64],
    ) -> Result<Option<Held>, FemError> {
        if self.stress.is_none() && self.strain.is_none() {
            return Ok(None);
        }
        let (mut largest, mut cells) = (0.0f64, vec![0.0; body.mesh.points().len()]);
        let mut all = vec![[0.0; D]; body.mesh.points().len()];
        for block in body.mesh.blocks() {
            let Some((held, stress)) = self.cell_forces(body, block, analysis, time)? else {
                continue;
            };
            largest = largest.max(stress);
            for (&node, force) in block.nodes.iter().zip(held) {
                all[node as usize] = add_scaled(all[node as usize], -1.0, force);
            }
            for cell in block.cells() {
                let known = known_area(body, analysis, cell);
                cell.iter().for_each(|&node| cells[node as usize] += known);
            }
        }
        let sums = forces.iter_mut().zip(all.as_flattened());
        sums.for_each(|(sum, force)| *sum += force);
        Ok(Some(Held {
            magnitude: all.into_iter().map(norm).sum(),
            rounding: cells
                .into_iter()
                .map(|area| SUM_ROUNDING * largest * area)
                .collect(),
        }))
    }
}

/// Relative rounding of forces as sums; in cells of all kinds, near and far from the origin, up to 0.6 ε was observed.
const SUM_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Nodal forces of the initial stress and strain of a body.
pub(crate) struct Held {
    /// Sum of the magnitudes of the nodal forces.
    pub magnitude: f64,
    /// By node, the uncertainty of a force there, (n,).
    pub rounding: Vec<f64>,
}

/// Area over which a cell transfers a stress to a node, for the rounding, with thickness or 2πr: (h + |x|) h^(D−2).
fn known_area<const D: usize>(body: &Body<D>, analysis: Analysis, cell: &[u32]) -> f64 {
    let points: Vec<Point<D>> = (cell.iter())
        .map(|&node| body.mesh.points()[node as usize])
        .collect();
    let (low, high) = bounding_box(&points);
    let size = distance(low, high);
    let far = low
        .iter()
        .chain(&high)
        .fold(0.0, |s: f64, x| s.max(x.abs()));
    (size + far) * size.powi(D as i32 - 2) * measure(analysis, body.thickness, high)
}

/// σ·g of a stress and a gradient.
pub(crate) fn along<const D: usize>(stress: [f64; 6], gradient: [f64; D]) -> Point<D> {
    std::array::from_fn(|i| (0..D).map(|j| stress[PLACE[i][j]] * gradient[j]).sum())
}

/// Degree of the quadrature of body forces and initial stresses: exact for ones that are linear in the place, in cells with
/// curved edges, 2πr included.
pub(crate) fn body_degree(order: usize) -> usize {
    2 * order + 4
}

/// Cells per parallel task.
const CHUNK: usize = 64;

/// A vertical and a resultant of body forces are different directions if the sine of their angle exceeds this.
const TILTED: f64 = 1e-3;

/// The resultant of the body force if it does not act along the vertical of the initial stress.
///
/// Errors: an expression that is not finite.
pub(crate) fn tilted<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    time: f64,
) -> Result<Option<(Point<D>, Point<D>)>, FemError> {
    // around an axis radial forces have no resultant
    let (Some(_), Some(vertical), false) = (
        &body.initial.stress,
        body.initial.vertical,
        analysis == Analysis::Axisymmetric,
    ) else {
        return Ok(None);
    };
    let mut forces = vec![[0.0; D]; body.mesh.points().len()];
    add_body_force(body, analysis, time, forces.as_flattened_mut())?;
    let all = forces
        .iter()
        .fold([0.0; D], |sum, &f| add_scaled(sum, 1.0, f));
    let sizes: f64 = forces.iter().map(|&f| norm(f)).sum();
    let across = norm(cross(padded(all), vertical)) / norm(vertical);
    let vertical = std::array::from_fn(|i| vertical[i]);
    // the rounding of forces that cancel has no direction
    let tilted = norm(all) > BALANCED * sizes && across > TILTED * norm(all);
    Ok(tilted.then_some((vertical, all)))
}

/// An imbalance that would move an undisturbed body.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OutOfBalance<const D: usize> {
    /// The largest nodal force of initial stress and body force together.
    pub force: f64,
    /// That force relative to those of the stress in the cells around the node.
    pub part: f64,
    /// The node.
    pub at: Point<D>,
}

/// Forces below this part of those of the cells around are rounding, or quadrature of smooth functions.
const BALANCED: f64 = 1e-6;

/// Imbalance of initial stress and body force at nodes where no other force acts: inside, and at free parts of the boundary.
/// Sides with a support or a load and those in `touched` may carry any force; where some side has an in-situ load, free
/// sides have been excavated.
///
/// Errors: an expression that is not finite; an unknown side; a group of cells without a material.
pub(crate) fn out_of_balance<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    time: f64,
    touched: &BTreeSet<&str>,
) -> Result<Option<OutOfBalance<D>>, FemError> {
    if body.initial.stress.is_none() {
        return Ok(None);
    }
    let n = body.mesh.points().len();
    let (mut rest, mut size) = (vec![[0.0; D]; n], vec![0.0; n]);
    add_body_force(body, analysis, time, rest.as_flattened_mut())?;
    // initial strains move bodies, as intended
    let stressed = Initial {
        strain: None,
        ..body.initial.clone()
    };
    for block in body.mesh.blocks() {
        let forces = stressed.cell_forces(body, block, analysis, time)?;
        let forces = forces.map(|(forces, _)| forces).unwrap_or_default();
        let cells = forces.chunks_exact(block.kind.nodes());
        for (cell, forces) in block.cells().zip(cells) {
            // the force of the stress at a node in the middle of a cell may be zero
            let most = forces.iter().map(|&force| norm(force)).fold(0.0, f64::max);
            for (&node, force) in cell.iter().zip(forces) {
                rest[node as usize] = add_scaled(rest[node as usize], -1.0, *force);
                size[node as usize] += most;
            }
        }
    }
    let left_out = carrying(body, touched)?;
    let judged = (0..n).filter(|node| !left_out.contains(node));
    let parts = judged.map(|node| (node, norm(rest[node])));
    let parts = parts.filter(|&(node, force)| force > BALANCED * size[node]);
    let worst = parts.max_by(|a, b| a.1.total_cmp(&b.1));
    Ok(worst.map(|(node, force)| OutOfBalance {
        force,
        part: force / size[node],
        at: body.mesh.points()[node],
    }))
}

/// Nodes with other forces than body force and initial stress.
fn carrying<const D: usize>(
    body: &Body<D>,
    touched: &BTreeSet<&str>,
) -> Result<BTreeSet<usize>, FemError> {
    let mesh = &body.mesh;
    let places = body.held_places().chain(body.loads.iter().map(Load::place));
    let sides = touched
        .iter()
        .copied()
        .chain(body.couples.iter().map(|c| c.side.as_str()));
    let places = places.chain(sides.map(|side| Place::Side(side.to_string())));
    let mut nodes = BTreeSet::new();
    let mut add = |facets: &[Facet]| {
        let all = facets.iter().flat_map(|&facet| mesh.facet_nodes(facet));
        nodes.extend(all.map(|node| node as usize));
    };
    let mut points = Vec::new();
    for place in places {
        match place {
            Place::Side(side) => add(mesh.side(&side).unwrap_or_default()),
            Place::Point(point) => points.push(nearest_node(mesh, point, "load")?),
        }
    }
    if body
        .loads
        .iter()
        .any(|load| matches!(load, Load::InSitu { .. }))
    {
        add(&mesh.boundary_facets());
    }
    nodes.extend(points);
    Ok(nodes)
}
