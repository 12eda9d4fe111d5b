//! Bodies at a time: K, f, R and the held dofs, assembled, with the rows of B that touch them.
//!
//! Rigid parts that move follow the bodies (`parts.rs`). Loads, prescribed displacements, gaps and the motion of obstacles change with
//! time; K and B stay.

use crate::contact::Row;
use crate::fem::{ALONG, BodySystem, History, assemble_after, largest_coefficient};
use crate::geometry::{Point, add_scaled, dot, norm};
use crate::host::in_order;
use crate::linalg::SparseMatrix;
use crate::mesh::Count;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Body, Model};
use crate::model::system::condition::{Condition, row_ranges};
use crate::model::system::memory;
use crate::model::system::parts::rigid_systems;
use crate::model::system::pieces::pieces;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The rows of B that touch one body, in the frames of its nodes, prescribed dofs included.
pub(crate) struct BodyRows {
    /// Global index of each local row, ascending.
    pub index: Vec<usize>,
    /// Local rows by dofs of the body.
    pub matrix: SparseMatrix,
}

impl BodyRows {
    /// Bu: the global index of every row, and its product with the displacements of the body, (D·n,).
    pub fn products(&self, u: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let rows = self.index.iter().enumerate();
        rows.map(|(local, &row)| {
            let parts = self.matrix.row(local).map(|(dof, value)| value * u[dof]);
            (row, parts.sum())
        })
    }

    /// The dofs that they read, some of them several times.
    pub fn dofs(&self) -> impl Iterator<Item = usize> {
        let rows = 0..self.index.len();
        rows.flat_map(|local| self.matrix.row(local).map(|(dof, _)| dof))
    }

    /// out += factor · Bᵀλ; shapes (m,) and (D·n,).
    pub fn add_forces(&self, factor: f64, lambda: &[f64], out: &mut [f64]) {
        let local: Vec<f64> = self.index.iter().map(|&row| factor * lambda[row]).collect();
        self.matrix.mul_transpose_add(&local, out);
    }
}

/// One body, ready to be factored.
pub(crate) struct LoadedBody<const D: usize> {
    /// Its discrete equilibrium.
    pub system: BodySystem<D>,
    /// Its rows of B.
    pub rows: Arc<BodyRows>,
    /// f − K u_D on the free dofs, zero on the held ones; u_D less the rigid motion that it contains.
    pub reduced_load: Vec<f64>,
}

impl<const D: usize> LoadedBody<D> {
    /// Forces of the supports ON the dofs of a rigid part, under forces `lambda` (m,); zero at free dofs.
    pub fn held_forces(&self, lambda: &[f64]) -> Vec<f64> {
        let mut forces: Vec<f64> = self.system.load.iter().map(|f| -f).collect();
        self.rows.add_forces(1.0, lambda, &mut forces);
        let free = forces.iter_mut().zip(&self.system.held);
        free.filter(|(_, held)| !**held)
            .for_each(|(force, _)| *force = 0.0);
        forces
    }

    /// Adds the lift of the prescribed displacements to the load.
    pub fn new(system: BodySystem<D>, rows: Arc<BodyRows>) -> Self {
        let mut reduced_load = system.load.clone();
        if system.lift.iter().any(|&value| value != 0.0) {
            let mut product = vec![0.0; reduced_load.len()];
            system.stiffness.mul(&system.lift, &mut product);
            reduced_load
                .iter_mut()
                .zip(&product)
                .for_each(|(f, ku)| *f -= ku);
        }
        for (value, _) in reduced_load
            .iter_mut()
            .zip(&system.held)
            .filter(|(_, held)| **held)
        {
            *value = 0.0;
        }
        Self {
            system,
            rows,
            reduced_load,
        }
    }
}

/// Assembles all bodies at a time, each with its history. Bodies that were assembled before take only new loads and prescribed
/// displacements; rigid parts follow.
pub(crate) fn systems<const D: usize>(
    model: &Model<D>,
    (before, histories): (Vec<Option<BodySystem<D>>>, Vec<History<D>>),
    time: f64,
) -> Result<Vec<BodySystem<D>>, Error<D>> {
    memory::check_meshes(model)?;
    type Own<'b, const D: usize> = (
        &'b Body<D>,
        Option<BodySystem<D>>,
        History<D>,
        Option<Count>,
    );
    let system = |(body, before, history, pieces): Own<'_, D>| {
        let is_whole = pieces.is_none();
        let system = match before.filter(|before| before.is_whole || !is_whole) {
            Some(before) => BodySystem { history, ..before }.at_time(body, model.analysis, time),
            None => assemble_after((body, history), model.analysis, time, is_whole),
        };
        system.map_err(|source| Error::in_body(body, source))
    };
    let bodies = (&model.bodies, before, histories, pieces(model)).into_par_iter();
    let mut systems = in_order(bodies.map(system))?;
    systems.extend(rigid_systems(model, time)?);
    Ok(systems)
}

/// Turns nodes on which contact forces act in a single oblique direction into that direction: with one contact dof instead of D
/// the boundary stiffness is D² times smaller. That applies to flat sides without friction and, with forces node by node, to curved
/// ones. In the plane, where contacts are short, it has no benefit.
pub(crate) fn turn_to_forces<const D: usize>(
    systems: &mut [BodySystem<D>],
    conditions: &[Condition<D>],
) {
    if D == 2 {
        return;
    }
    let mut rows: Vec<Vec<&Row<D>>> = vec![Vec::new(); systems.len()];
    for condition in conditions {
        for (body, more) in condition.ends() {
            // a rigid part is not a body
            if let Some(rows) = rows.get_mut(body) {
                rows.extend(more);
            }
        }
    }
    (systems, rows)
        .into_par_iter()
        .for_each(|(system, rows)| system.turn(oblique_forces(&rows)));
}

/// Nodes at which all of some rows have one direction that is not along an axis, and that direction, of length 1.
fn oblique_forces<const D: usize>(rows: &[&Row<D>]) -> impl Iterator<Item = (usize, Point<D>)> {
    // at each node the coefficient that is largest relative to its row: that ratio, and its direction
    let mut largest: BTreeMap<usize, (f64, Point<D>)> = BTreeMap::new();
    for row in rows {
        let scale = largest_coefficient(row);
        for &(node, coefficients) in *row {
            let size = norm(coefficients);
            let found = largest.entry(node).or_insert((0.0, [0.0; D]));
            if size > found.0 * scale {
                *found = (size / scale, coefficients.map(|c| c / size));
            }
        }
    }
    for row in rows {
        let rounding = ALONG * largest_coefficient(row);
        for (node, coefficients) in *row {
            let along = largest.get(node).map(|found| found.1);
            let off = along.map(|a| norm(add_scaled(*coefficients, -dot(*coefficients, a), a)));
            if off.is_some_and(|off| off > rounding) {
                largest.remove(node);
            }
        }
    }
    let oblique = |along: Point<D>| along.into_iter().filter(|c| c.abs() > ALONG).count() > 1;
    let found = largest.into_iter().map(|(node, (_, along))| (node, along));
    found.filter(move |(_, along)| oblique(*along))
}

/// Collects the rows of B of every body.
pub(crate) fn body_rows<const D: usize>(
    systems: &[BodySystem<D>],
    conditions: &[Condition<D>],
) -> Vec<Arc<BodyRows>> {
    let mut triplets: Vec<Vec<(usize, usize, f64)>> = vec![Vec::new(); systems.len()];
    for (range, contact) in row_ranges(conditions) {
        let start = range.start;
        for (body, rows) in contact.ends() {
            for (local, row) in rows.iter().enumerate() {
                let in_frames = systems[body].row_in_frames(row);
                triplets[body].extend(in_frames.map(|(dof, value)| (start + local, dof, value)));
            }
        }
    }
    triplets
        .into_iter()
        .zip(systems)
        .map(|(triplets, system)| {
            let mut index: Vec<usize> = triplets.iter().map(|t| t.0).collect();
            index.sort_unstable();
            index.dedup();
            let local: Vec<(usize, usize, f64)> = triplets
                .into_iter()
                .map(|(row, dof, value)| (index.partition_point(|&i| i < row), dof, value))
                .collect();
            let matrix = SparseMatrix::from_triplets(index.len(), system.load.len(), &local);
            Arc::new(BodyRows { index, matrix })
        })
        .collect()
}

/// Compliance of every row if only its own dofs move, (len,): Σ b²/K_ii over the free dofs of all bodies. It bounds the compliance
/// of the row from below and does not depend on how floating bodies are grounded.
pub(crate) fn least_softness<const D: usize>(bodies: &[LoadedBody<D>], len: usize) -> Vec<f64> {
    let mut softness = vec![0.0; len];
    for body in bodies {
        let stiffness = body.system.stiffness.diagonal();
        for (local, &row) in body.rows.index.iter().enumerate() {
            let free = body
                .rows
                .matrix
                .row(local)
                .filter(|&(dof, _)| !body.system.held[dof] && stiffness[dof] > 0.0);
            softness[row] += free.map(|(dof, b)| b * b / stiffness[dof]).sum::<f64>();
        }
    }
    softness
}

/// The largest resultant load of a body, or of a single load.
pub(crate) fn largest_load<const D: usize>(bodies: &[LoadedBody<D>]) -> f64 {
    let resultant = |body: &LoadedBody<D>| {
        let forces = body.system.to_global(&body.system.load).into_iter();
        norm(forces.fold([0.0; D], |sum, f| add_scaled(sum, 1.0, f)))
    };
    let loads = bodies
        .iter()
        .map(|body| resultant(body).max(body.system.largest_load));
    loads.fold(0.0, f64::max)
}

/// out += factor · B u.
pub(crate) fn add_rows<const D: usize>(
    bodies: &[LoadedBody<D>],
    factor: f64,
    u: &[Vec<f64>],
    out: &mut [f64],
) {
    for (body, u) in bodies.iter().zip(u) {
        for (row, product) in body.rows.products(u) {
            out[row] += factor * product;
        }
    }
}

/// Sum of the magnitudes of the nodal forces of a body: the scale of its load.
pub(crate) fn load_size<const D: usize>(body: &LoadedBody<D>) -> f64 {
    body.system.load.iter().map(|f| f.abs()).sum()
}
