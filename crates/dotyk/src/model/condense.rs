//! Condensation: one factorisation per body, then everything on the contact unknowns.
//!
//! With the contact dofs ordered last, the trailing block of the Cholesky factor, L_c, is the factor of the body's
//! boundary stiffness (the paper's (7.8)). Hence
//!
//! ```text
//!   F_b = B_c K⁺ B_cᵀ = XᵀX,  X = L_c⁻¹ B_cᵀ,        d = B (u_D + K⁺(f − K u_D)) − g₀
//! ```
//!
//! A floating body is held for the factorisation at r dofs away from its contacts, chosen by pivoting on R. Which ones
//! does not change the answer: a different choice changes F by Gᵀ(..) + (..)G only, which Gλ = e and α absorb.
//! Above [`DENSE_LIMIT`] unknowns F is not assembled: each product is one solve with every body.
//!
//! Source: Janovský & Procházka (1980) III, section 7, (7.5)–(7.9).

use crate::dual::Compliance;
use crate::fem::{BodySystem, FemError, show};
use crate::linalg::{
    Cholesky, LinalgError, LinearOperator, Mat, SparseMatrix, SymbolicCholesky, expand_to_dofs,
    fill_reducing_order, gram, solve_lower_in_place,
};
use crate::model::error::Error;
use crate::model::nouns::Model;
use crate::model::pair::Paired;
use rayon::prelude::*;
use std::sync::Arc;

/// Most contact unknowns for which F is assembled (72 MB); above, products with F go through the bodies' factors, which takes
/// less time from there on.
pub const DENSE_LIMIT: usize = 3000;

/// F of more unknowns than the first number, of which less than one in the second has an entry, is assembled without its
/// zeros: many bodies.
const FEW: usize = 500;
const SCATTERED: usize = 8;

/// Overlaps that are all below this part of the displacements they are differences of mean nothing.
const ROUNDING: f64 = 1e-12;

/// The rows of B that touch one body, in the frames of its nodes, prescribed dofs included.
pub(crate) struct BodyRows {
    /// Global index of each local row, ascending.
    pub index: Vec<usize>,
    /// Local rows by dofs of the body.
    pub matrix: SparseMatrix,
}

impl BodyRows {
    /// out += B u; shapes (D·n,) and (m,).
    fn add_product(&self, u: &[f64], out: &mut [f64]) {
        for (local, &row) in self.index.iter().enumerate() {
            let product = self.matrix.row(local).map(|(dof, value)| value * u[dof]);
            out[row] += product.sum::<f64>();
        }
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

/// The factor of one body, and what it does without contact.
pub(crate) struct FactoredBody {
    /// Factor of K on the free dofs, grounded ones left out.
    pub factor: Arc<Cholesky>,
    /// u_D + K⁺(f − K u_D), (D·n,), less the rigid motion that u_D contains.
    pub base: Vec<f64>,
}

impl FactoredBody {
    /// Solves for the displacement without contact.
    pub fn new<const D: usize>(body: &LoadedBody<D>, factor: Arc<Cholesky>) -> Self {
        let mut base = body.reduced_load.clone();
        factor.solve(&mut base);
        base.iter_mut()
            .zip(&body.system.lift)
            .for_each(|(u, lift)| *u += lift);
        Self { factor, base }
    }
}

/// What every row gives way where only its own dofs move, (len,): Σ b²/K_ii over the free dofs of all bodies. It bounds the
/// compliance of the row from below and does not depend on how floating bodies are grounded.
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

/// The gaps g₀ of all multipliers; in tangential rows the motion of a rigid obstacle.
pub(crate) fn initial_gaps<const D: usize>(paired: &[Paired<D>]) -> Vec<f64> {
    paired.iter().flat_map(Paired::gaps).collect()
}

/// The gaps g₀ of a step that begins with a slip, (m,): friction counts the slip from there.
pub(crate) fn gaps_after<const D: usize>(paired: &[Paired<D>], slip: &[f64]) -> Vec<f64> {
    let gaps = initial_gaps(paired).into_iter().zip(slip);
    gaps.map(|(gap, slip)| gap + slip).collect()
}

/// Collects the rows of B of every body.
pub(crate) fn body_rows<const D: usize>(
    systems: &[BodySystem<D>],
    paired: &[Paired<D>],
) -> Vec<Arc<BodyRows>> {
    let mut triplets: Vec<Vec<(usize, usize, f64)>> = vec![Vec::new(); systems.len()];
    let mut next = 0;
    for contact in paired {
        let start = next;
        next += contact.interface.nonmortar.len();
        let mut add = |body: usize, rows: &[crate::contact::Row<D>]| {
            for (local, row) in rows.iter().enumerate() {
                for &(node, coefficients) in row {
                    let in_frame = systems[body].row_in_frame(node, coefficients);
                    for (component, &value) in in_frame.iter().enumerate() {
                        if value != 0.0 {
                            triplets[body].push((start + local, D * node + component, value));
                        }
                    }
                }
            }
        };
        add(contact.nonmortar.body.0, &contact.interface.nonmortar);
        if let Some(part) = contact.opposite {
            add(part, &contact.interface.mortar);
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

/// Elimination order of one body, with its symbolic analysis.
pub(crate) struct Ordered {
    analysis: SymbolicCholesky,
    /// Contact dofs, the last ones of the order.
    trailing: Vec<usize>,
}

/// Orders a body: free dofs, contact nodes last (when F is assembled), grounded dofs left out.
pub(crate) fn order<const D: usize>(
    model: &Model<D>,
    body: usize,
    system: &BodySystem<D>,
    rows: &BodyRows,
    dense: bool,
) -> Result<Ordered, Error<D>> {
    let mut contact_node = vec![false; system.graph.nodes()];
    for local in 0..rows.index.len() {
        for (dof, _) in rows.matrix.row(local) {
            contact_node[dof / D] = true;
        }
    }
    let mut keep: Vec<bool> = system.held.iter().map(|held| !held).collect();
    for dof in grounded_dofs(system, &keep, &contact_node) {
        keep[dof] = false;
    }
    let keep_node: Vec<bool> = keep
        .chunks_exact(D)
        .map(|dofs| dofs.contains(&true))
        .collect();
    let last: Vec<usize> = match dense {
        true => (0..contact_node.len())
            .filter(|&node| contact_node[node] && keep_node[node])
            .collect(),
        false => Vec::new(),
    };
    let nodes = fill_reducing_order(&system.graph, &keep_node, &last);
    let dofs = expand_to_dofs(&nodes, D, &keep);
    let trailing = expand_to_dofs(&last, D, &keep);
    let analysis = SymbolicCholesky::new(&system.stiffness, &dofs, trailing.len())
        .map_err(|source| singular(model, body, source))?;
    Ok(Ordered { analysis, trailing })
}

/// Dofs that hold the free rigid modes for the factorisation: complete pivoting on R, away from the contacts if possible.
fn grounded_dofs<const D: usize>(
    system: &BodySystem<D>,
    keep: &[bool],
    contact_node: &[bool],
) -> Vec<usize> {
    let mut modes = system.modes.clone();
    let mut grounded: Vec<usize> = Vec::new();
    let mut open: Vec<usize> = (0..modes.len()).collect();
    let candidates = |away: bool| {
        (0..keep.len()).filter(move |&dof| keep[dof] && (!away || !contact_node[dof / D]))
    };
    while !open.is_empty() {
        let best = |away: bool| {
            let mut best = (0.0, 0, 0);
            for (position, &mode) in open.iter().enumerate() {
                for dof in candidates(away) {
                    let size = modes[mode][dof].abs();
                    if size > best.0 {
                        best = (size, position, dof);
                    }
                }
            }
            best
        };
        let mut pivot = best(true);
        if pivot.0 < 1e-3 {
            pivot = best(false);
        }
        let (size, position, dof) = pivot;
        if size == 0.0 {
            break;
        }
        let mode = open.remove(position);
        grounded.push(dof);
        let row = modes[mode].clone();
        for &other in &open {
            let factor = modes[other][dof] / row[dof];
            modes[other]
                .iter_mut()
                .zip(&row)
                .for_each(|(value, r)| *value -= factor * r);
        }
    }
    grounded
}

/// Factors a body.
pub(crate) fn factor<const D: usize>(
    model: &Model<D>,
    body: usize,
    system: &BodySystem<D>,
    ordered: &Ordered,
) -> Result<Cholesky, Error<D>> {
    ordered
        .analysis
        .factor(&system.stiffness)
        .map_err(|source| singular(model, body, source))
}

/// Names the node of a dof where the linear algebra failed.
fn singular<const D: usize>(model: &Model<D>, body: usize, source: LinalgError) -> Error<D> {
    let dof = match &source {
        LinalgError::NotPositiveDefinite { dof } | LinalgError::NearlySingular { dof, .. } => *dof,
        LinalgError::NotFinite { row } => *row,
        _ => 0,
    };
    let node = dof / D;
    let body = &model.bodies[body];
    let point = show(body.mesh.points()[node]);
    Error::Body {
        body: body.name.clone(),
        source: FemError::Singular {
            node,
            point,
            source,
        },
    }
}

/// d of all bodies: by how much they overlap where there is no contact force.
pub(crate) fn overlap<const D: usize>(
    bodies: &[LoadedBody<D>],
    factored: &[FactoredBody],
    gaps: &[f64],
) -> Vec<f64> {
    let mut overlap: Vec<f64> = gaps.iter().map(|gap| -gap).collect();
    // rigid motions first: they may cancel a clearance that is large beside the strains
    for body in bodies {
        body.rows.add_product(&body.system.carried, &mut overlap);
    }
    let mut largest = gaps.iter().fold(0.0, |s: f64, gap| s.max(gap.abs()));
    for (body, factored) in bodies.iter().zip(factored) {
        body.rows.add_product(&factored.base, &mut overlap);
        let moved = body.system.carried.iter().chain(&factored.base);
        largest = moved.fold(largest, |s, u| s.max(u.abs()));
    }
    // Bodies that their supports carry along together do not overlap: what is left is rounding of the displacement.
    if overlap.iter().all(|d| d.abs() <= ROUNDING * largest) {
        overlap.fill(0.0);
    }
    overlap
}

/// Whether F is assembled: up to `limit` nodes that carry `per_node` rows each, or as many entries in the bodies' parts.
pub(crate) fn is_assembled(
    rows: &[Arc<BodyRows>],
    m: usize,
    limit: usize,
    per_node: usize,
) -> bool {
    let most = limit.saturating_mul(per_node);
    let entries: usize = rows.iter().map(|rows| rows.index.len().pow(2)).sum();
    m <= most || entries <= most.saturating_mul(most)
}

/// F of all bodies: (m, m), assembled where `dense`, without its zeros where these are most of it.
pub(crate) fn compliance<const D: usize>(
    bodies: &[LoadedBody<D>],
    factored: &[FactoredBody],
    ordered: &[Ordered],
    m: usize,
    dense: bool,
) -> Compliance {
    if !dense {
        let apply = Box::new(CompliantBodies::new(m, bodies, factored));
        let preconditioner = Box::new(BoundaryStiffness::new(m, bodies));
        return Compliance::Operator {
            apply,
            preconditioner,
        };
    }
    let blocks: Vec<Mat<f64>> = (bodies, factored, ordered)
        .into_par_iter()
        .map(|(b, f, o)| boundary_compliance(b, f, o))
        .collect();
    let entries: usize = blocks.iter().map(|block| block.nrows().pow(2)).sum();
    if m > FEW && entries < m * m / SCATTERED {
        let mut triplets = Vec::with_capacity(entries);
        for (body, block) in bodies.iter().zip(&blocks) {
            let index = &body.rows.index;
            for (j, &column) in index.iter().enumerate() {
                let rows = index.iter().enumerate();
                triplets.extend(rows.map(|(i, &row)| (row, column, block[(i, j)])));
            }
        }
        return Compliance::Sparse(SparseMatrix::from_triplets(m, m, &triplets));
    }
    let mut f = Mat::<f64>::zeros(m, m);
    for (body, block) in bodies.iter().zip(&blocks) {
        let index = &body.rows.index;
        for (j, &column) in index.iter().enumerate() {
            for (i, &row) in index.iter().enumerate() {
                f[(row, column)] += block[(i, j)];
            }
        }
    }
    Compliance::Dense(f)
}

/// F of one body on its own rows: XᵀX with X = L_c⁻¹ B_cᵀ.
fn boundary_compliance<const D: usize>(
    body: &LoadedBody<D>,
    factored: &FactoredBody,
    ordered: &Ordered,
) -> Mat<f64> {
    let rows = &body.rows;
    let mut position = vec![usize::MAX; body.system.load.len()];
    for (k, &dof) in ordered.trailing.iter().enumerate() {
        position[dof] = k;
    }
    let mut x = Mat::<f64>::zeros(ordered.trailing.len(), rows.index.len());
    for local in 0..rows.index.len() {
        for (dof, value) in rows.matrix.row(local) {
            // held and grounded dofs do not move under contact forces
            if position[dof] != usize::MAX {
                x[(position[dof], local)] = value;
            }
        }
    }
    solve_lower_in_place(&factored.factor.trailing_factor(), &mut x);
    gram(&x)
}

/// x ↦ Fx by one solve with every body.
struct CompliantBodies {
    len: usize,
    bodies: Vec<(Arc<Cholesky>, Arc<BodyRows>)>,
}

impl CompliantBodies {
    fn new<const D: usize>(
        len: usize,
        bodies: &[LoadedBody<D>],
        factored: &[FactoredBody],
    ) -> Self {
        let touched = bodies
            .iter()
            .zip(factored)
            .filter(|(body, _)| !body.rows.index.is_empty());
        Self {
            len,
            bodies: touched
                .map(|(body, f)| (f.factor.clone(), body.rows.clone()))
                .collect(),
        }
    }
}

impl LinearOperator for CompliantBodies {
    fn len(&self) -> usize {
        self.len
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let parts: Vec<Vec<f64>> = self
            .bodies
            .par_iter()
            .map(|(factor, rows)| {
                let local: Vec<f64> = rows.index.iter().map(|&row| x[row]).collect();
                let mut u = vec![0.0; rows.matrix.cols()];
                rows.matrix.mul_transpose_add(&local, &mut u);
                factor.solve(&mut u);
                let mut out = vec![0.0; local.len()];
                rows.matrix.mul(&u, &mut out);
                out
            })
            .collect();
        scatter(
            &self
                .bodies
                .iter()
                .map(|(_, rows)| rows.clone())
                .collect::<Vec<_>>(),
            &parts,
            y,
        );
    }

    fn apply_many(&self, x: &Mat<f64>) -> Mat<f64> {
        let mut y = Mat::zeros(self.len, x.ncols());
        y.par_col_chunks_mut(BLOCK)
            .enumerate()
            .for_each(|(chunk, mut y)| {
                let first = chunk * BLOCK;
                for (factor, rows) in &self.bodies {
                    let mut u = Mat::zeros(rows.matrix.cols(), y.ncols());
                    for j in 0..y.ncols() {
                        let x = x.col_as_slice(first + j);
                        let local: Vec<f64> = rows.index.iter().map(|&row| x[row]).collect();
                        rows.matrix.mul_transpose_add(&local, u.col_as_slice_mut(j));
                    }
                    factor.solve_many(&mut u);
                    let mut out = vec![0.0; rows.index.len()];
                    for j in 0..y.ncols() {
                        rows.matrix.mul(u.col_as_slice(j), &mut out);
                        for (&row, value) in rows.index.iter().zip(&out) {
                            y[(row, j)] += value;
                        }
                    }
                }
            });
        y
    }
}

/// Columns that products with F take at a time: enough to share the reading of a factor, few enough for the memory.
const BLOCK: usize = 16;

fn scatter(rows: &[Arc<BodyRows>], parts: &[Vec<f64>], y: &mut [f64]) {
    y.fill(0.0);
    for (rows, part) in rows.iter().zip(parts) {
        for (&row, value) in rows.index.iter().zip(part) {
            y[row] += value;
        }
    }
}

/// The scaled Dirichlet preconditioner M = Σ δ_b² B S_b Bᵀ, an approximation of F⁻¹ on the balanced forces.
///
/// S_b is the boundary stiffness (contact dofs free, all else condensed); δ_b is the body's share of the compliance, so
/// that a row between two bodies weighs them by their softness. A row with one body has δ = 1.
/// Source: as described for FETI methods by Z. Dostál and others (scaled Dirichlet preconditioner).
struct BoundaryStiffness {
    len: usize,
    bodies: Vec<BoundaryPart>,
}

struct BoundaryPart {
    rows: Arc<BodyRows>,
    /// Factor of K with the contact dofs held as well.
    inner: Cholesky,
    stiffness: crate::linalg::SymmetricMatrix,
    contact: Vec<usize>,
    held: Vec<bool>,
    /// δ_b/|B_row|² of each local row.
    weight: Vec<f64>,
}

impl BoundaryStiffness {
    fn new<const D: usize>(len: usize, bodies: &[LoadedBody<D>]) -> Self {
        let parts: Vec<Option<BoundaryPart>> = bodies.par_iter().map(boundary_part).collect();
        let mut parts: Vec<BoundaryPart> = parts.into_iter().flatten().collect();
        let mut total = vec![0.0; len];
        for part in &parts {
            for (&row, w) in part.rows.index.iter().zip(&part.weight) {
                total[row] += w;
            }
        }
        for part in &mut parts {
            for (local, &row) in part.rows.index.iter().enumerate() {
                let size: f64 = part
                    .rows
                    .matrix
                    .row(local)
                    .map(|(_, value)| value * value)
                    .sum();
                part.weight[local] /= total[row] * size;
            }
        }
        Self { len, bodies: parts }
    }
}

/// `None` where no row touches the body, or its interior cannot be factored (then it adds nothing).
fn boundary_part<const D: usize>(body: &LoadedBody<D>) -> Option<BoundaryPart> {
    let rows = body.rows.clone();
    if rows.index.is_empty() {
        return None;
    }
    let system = &body.system;
    let mut on_contact = vec![false; system.load.len()];
    for local in 0..rows.index.len() {
        for (dof, _) in rows.matrix.row(local) {
            on_contact[dof] = true;
        }
    }
    let contact: Vec<usize> = (0..on_contact.len())
        .filter(|&dof| on_contact[dof] && !system.held[dof])
        .collect();
    let keep: Vec<bool> = (0..on_contact.len())
        .map(|dof| !on_contact[dof] && !system.held[dof])
        .collect();
    let keep_node: Vec<bool> = keep
        .chunks_exact(D)
        .map(|dofs| dofs.contains(&true))
        .collect();
    let nodes = fill_reducing_order(&system.graph, &keep_node, &[]);
    let dofs = expand_to_dofs(&nodes, D, &keep);
    let inner = SymbolicCholesky::new(&system.stiffness, &dofs, 0)
        .ok()?
        .factor(&system.stiffness)
        .ok()?;
    // softness of the body as one number: mean of 1/K_ii over its contact dofs
    let diagonal = system.stiffness.diagonal();
    let softness =
        contact.iter().map(|&dof| 1.0 / diagonal[dof]).sum::<f64>() / contact.len().max(1) as f64;
    let weight = vec![softness; rows.index.len()];
    Some(BoundaryPart {
        rows,
        inner,
        stiffness: system.stiffness.clone(),
        contact,
        held: system.held.clone(),
        weight,
    })
}

impl LinearOperator for BoundaryStiffness {
    fn len(&self) -> usize {
        self.len
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let parts: Vec<Vec<f64>> = self.bodies.par_iter().map(|part| part.apply(x)).collect();
        let rows: Vec<Arc<BodyRows>> = self.bodies.iter().map(|part| part.rows.clone()).collect();
        scatter(&rows, &parts, y);
    }
}

impl BoundaryPart {
    /// δ B S Bᵀ δ x on the local rows.
    fn apply(&self, x: &[f64]) -> Vec<f64> {
        let local: Vec<f64> = self
            .rows
            .index
            .iter()
            .zip(&self.weight)
            .map(|(&row, w)| w * x[row])
            .collect();
        let n = self.held.len();
        let mut v = vec![0.0; n];
        self.rows.matrix.mul_transpose_add(&local, &mut v);
        for (value, &held) in v.iter_mut().zip(&self.held) {
            if held {
                *value = 0.0;
            }
        }
        // S v = (K w)_c with w = v on the contact dofs and K w = 0 inside
        let mut force = vec![0.0; n];
        self.stiffness.mul(&v, &mut force);
        let mut inside = force.clone();
        self.inner.solve(&mut inside);
        let mut correction = vec![0.0; n];
        self.stiffness.mul(&inside, &mut correction);
        let mut boundary = vec![0.0; n];
        for &dof in &self.contact {
            boundary[dof] = force[dof] - correction[dof];
        }
        let mut out = vec![0.0; local.len()];
        self.rows.matrix.mul(&boundary, &mut out);
        out.iter_mut()
            .zip(&self.weight)
            .for_each(|(value, w)| *value *= w);
        out
    }
}
