//! F as products only, each one solve with every body, and a preconditioner that needs no F.
//!
//! ```text
//!   F = Σ B_b K_b⁺ B_bᵀ,        M = Σ δ_b² B_b S_b B_bᵀ ≈ F⁻¹ on the balanced forces
//! ```

use crate::fem::BodySystem;
use crate::linalg::dense::{dot, least_squares, norm};
use crate::linalg::{Cholesky, LinearOperator, Mat, SymmetricMatrix};
use crate::model::system::bodies::{BodyRows, LoadedBody};
use crate::model::system::factor::{FactoredBody, Ordered, analyse};
use rayon::prelude::*;
use std::sync::Arc;

/// x ↦ Fx by one solve with every body.
pub(crate) struct CompliantBodies {
    len: usize,
    bodies: Vec<(Arc<Cholesky>, Arc<BodyRows>)>,
}

impl CompliantBodies {
    pub fn new<const D: usize>(
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
                let mut u = vec![0.0; rows.matrix.cols()];
                rows.add_forces(1.0, x, &mut u);
                factor.solve(&mut u);
                let mut out = vec![0.0; rows.index.len()];
                rows.matrix.mul(&u, &mut out);
                out
            })
            .collect();
        scatter(self.bodies.iter().map(|(_, rows)| &**rows), &parts, y);
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
                        rows.add_forces(1.0, x.col_as_slice(first + j), u.col_as_slice_mut(j));
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

/// y = the sum over all bodies of the values on their rows.
fn scatter<'a>(rows: impl Iterator<Item = &'a BodyRows>, parts: &[Vec<f64>], y: &mut [f64]) {
    y.fill(0.0);
    for (rows, part) in rows.zip(parts) {
        for (&row, value) in rows.index.iter().zip(part) {
            y[row] += value;
        }
    }
}

/// The scaled Dirichlet preconditioner M = Σ δ_b² B S_b Bᵀ, an approximation of F⁻¹ on the balanced forces.
///
/// S_b is the boundary stiffness (contact dofs free, all else condensed); δ_b is the body's share of the compliance, so
/// that a row between two bodies weighs them by their softness. A row with one body has δ = 1.
///
/// For forces of one wave length let r be the ratio of the stiffnesses of two bodies, so that F⁻¹ = S₁/(1 + r). With the shares
/// δ₁ = 1/(1 + s), δ₂ = s/(1 + s), M = F⁻¹ where r = s, and M = (1 + s/(1 + s)² · (r/s + s/r − 2)) F⁻¹ elsewhere. A thin plate on a
/// block is as stiff as the block under forces from node to node, and softer by many powers of ten under long waves: with the softness
/// of short waves alone M would be wrong by the same powers. s is the geometric mean of the ratios for the shortest and the longest
/// waves, so that the error is the same at both ends.
/// Source: as described for FETI methods by Z. Dostál and others (scaled Dirichlet preconditioner).
pub(crate) struct BoundaryStiffness {
    len: usize,
    bodies: Vec<BoundaryPart>,
}

struct BoundaryPart {
    rows: Arc<BodyRows>,
    /// Factor of K with the contact dofs held as well.
    inner: Cholesky,
    stiffness: SymmetricMatrix,
    contact: Vec<usize>,
    held: Vec<bool>,
    /// δ_b/|B_row|² of each local row.
    weight: Vec<f64>,
}

impl BoundaryStiffness {
    pub fn new<const D: usize>(
        len: usize,
        bodies: &[LoadedBody<D>],
        factored: &[FactoredBody],
        ordered: &[Arc<Ordered>],
    ) -> Self {
        let parts = (bodies, factored, ordered).into_par_iter();
        let part = |(b, f, o): (&_, &FactoredBody, &Arc<Ordered>)| {
            boundary_part(b, &f.factor, &o.grounded)
        };
        let parts = parts.map(part);
        let parts: Vec<Option<BoundaryPart>> = parts.collect();
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
                if total[row] > 0.0 {
                    part.weight[local] /= total[row] * size;
                }
            }
        }
        Self { len, bodies: parts }
    }
}

/// `None` where no row touches the body, and for a rigid part, which has no compliance.
fn boundary_part<const D: usize>(
    body: &LoadedBody<D>,
    factor: &Cholesky,
    grounded: &[usize],
) -> Option<BoundaryPart> {
    let rows = body.rows.clone();
    let system = &body.system;
    let diagonal = system.stiffness.diagonal();
    if rows.index.is_empty() || diagonal.iter().all(|&stiffness| stiffness == 0.0) {
        return None;
    }
    let mut on_contact = vec![false; system.load.len()];
    for local in 0..rows.index.len() {
        for (dof, _) in rows.matrix.row(local) {
            on_contact[dof] = true;
        }
    }
    let contact: Vec<usize> = (0..on_contact.len())
        .filter(|&dof| on_contact[dof] && !system.held[dof])
        .collect();
    let mut keep: Vec<bool> = (0..on_contact.len())
        .map(|dof| !on_contact[dof] && !system.held[dof])
        .collect();
    let inner = factored(system, &keep).or_else(|| {
        // a body that floats on few contact nodes; grounded, its interior cannot fail: it is a part of what was factored
        grounded.iter().for_each(|&dof| keep[dof] = false);
        factored(system, &keep)
    })?;
    let short = contact.iter().map(|&dof| 1.0 / diagonal[dof]).sum::<f64>();
    let short = short / contact.len().max(1) as f64;
    let softness = (short * largest_softness(body, factor).max(short)).sqrt();
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

/// Products with F_b after which its largest eigenvalue is known well enough for a weight.
const PRODUCTS: usize = 6;

/// Forces of which less than this part is balanced cause rigid motions only.
const BALANCED: f64 = 1e-10;

/// About the largest softness of a body under balanced contact forces: that of the longest waves.
fn largest_softness<const D: usize>(body: &LoadedBody<D>, factor: &Cholesky) -> f64 {
    let rows = &body.rows;
    let of_modes = Mat::from_fn(rows.index.len(), body.system.modes.len(), |local, mode| {
        let mode = &body.system.modes[mode];
        let row = rows.matrix.row(local);
        row.map(|(dof, value)| value * mode[dof]).sum()
    });
    let balanced = |x: &mut [f64]| {
        let given = Mat::from_fn(x.len(), 1, |i, _| x[i]);
        if let Ok(found) = least_squares(&of_modes, &given, 1e-10) {
            for (mode, amount) in found.col_as_slice(0).iter().enumerate() {
                let column = of_modes.col_as_slice(mode);
                x.iter_mut().zip(column).for_each(|(x, g)| *x -= amount * g);
            }
        }
    };
    // not a rigid motion of the body, and the same for any order of sums
    let start = |i: usize| 1.0 + (1.7 * i as f64).sin();
    let mut x: Vec<f64> = (0..rows.index.len()).map(start).collect();
    let mut softness = 0.0;
    for _ in 0..PRODUCTS {
        let whole = norm(&x);
        balanced(&mut x);
        let size = norm(&x);
        // without a balanced part only rounding remains
        if size <= BALANCED * whole {
            break;
        }
        x.iter_mut().for_each(|x| *x /= size);
        let mut u = vec![0.0; rows.matrix.cols()];
        rows.matrix.mul_transpose_add(&x, &mut u);
        factor.solve(&mut u);
        let before = x.clone();
        rows.matrix.mul(&u, &mut x);
        softness = dot(&before, &x);
    }
    softness
}

/// The factor of K on the kept dofs, if these are held.
fn factored<const D: usize>(system: &BodySystem<D>, keep: &[bool]) -> Option<Cholesky> {
    let analysis = analyse(system, keep, &[]).ok()?;
    analysis.factor(&system.stiffness).ok()
}

impl LinearOperator for BoundaryStiffness {
    fn len(&self) -> usize {
        self.len
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let parts: Vec<Vec<f64>> = self.bodies.par_iter().map(|part| part.apply(x)).collect();
        scatter(self.bodies.iter().map(|part| &*part.rows), &parts, y);
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
