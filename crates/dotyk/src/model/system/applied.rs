//! F as products only, each one solve with every body, and a preconditioner that needs no F.
//!
//! ```text
//!   F = Σ B_b K_b⁺ B_bᵀ,        M = Σ δ_b² E_b S_b E_bᵀ ≈ F⁻¹ on the balanced forces
//! ```

use crate::dual::Glue;
use crate::fem::BodySystem;
use crate::linalg::dense::{dot, least_squares, norm};
use crate::linalg::{Cholesky, Glued, LinearOperator, Mat, SparseMatrix, SymmetricMatrix, analyse};
use crate::model::system::bodies::{BodyRows, LoadedBody};
use crate::model::system::factor::{FactoredBody, Inverse, Ordered};
use crate::model::system::spread::spread;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// x ↦ Fx by one solve with every body.
pub(crate) struct CompliantBodies {
    len: usize,
    bodies: Vec<(Arc<Inverse>, Arc<BodyRows>)>,
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

/// F of bodies some of which are in pieces, with the forces of their glue.
pub(crate) struct GluedBodies {
    /// Inverse and rows of every body that is touched, and its first force of glue and rigid motion of pieces among all.
    bodies: Vec<(Arc<Inverse>, Arc<BodyRows>, [usize; 2])>,
    glue: usize,
    modes: usize,
    /// BR.
    motions: Vec<Vec<(usize, f64)>>,
    boundary: BoundaryStiffness,
    /// Products that cost as much as wholes.
    enough: usize,
}

impl GluedBodies {
    /// `None` where all touched bodies are whole; `enough` products cost as much as wholes.
    pub fn new(
        compliant: &CompliantBodies,
        boundary: &BoundaryStiffness,
        enough: usize,
    ) -> Option<Self> {
        let (mut glue, mut modes) = (0, 0);
        let mut motions = vec![Vec::new(); compliant.len];
        let place = |(inverse, rows): &(Arc<Inverse>, Arc<BodyRows>)| {
            let first = [glue, modes];
            if let Some(glued) = inverse.glued() {
                glue += glued.border();
                modes += glued.whole().coarse();
                let own = glued.whole().motions(&rows.matrix);
                for (&row, own) in rows.index.iter().zip(own) {
                    let own = own
                        .into_iter()
                        .map(|(mode, motion)| (first[1] + mode, motion));
                    motions[row].extend(own);
                }
            }
            (Arc::clone(inverse), Arc::clone(rows), first)
        };
        let bodies = compliant.bodies.iter().map(place).collect();
        (glue > 0).then(|| Self {
            bodies,
            glue,
            modes,
            motions,
            boundary: boundary.clone(),
            enough,
        })
    }

    /// The bodies in pieces: these, their rows, and the places of their forces of glue and of their rigid motions.
    fn divided(&self) -> impl Iterator<Item = (&Glued, &BodyRows, [Range<usize>; 2])> {
        self.bodies.iter().filter_map(|(inverse, rows, first)| {
            let glued = inverse.glued()?;
            let [glue, modes] = *first;
            let places = [
                glue..glue + glued.border(),
                modes..modes + glued.whole().coarse(),
            ];
            Some((glued, &**rows, places))
        })
    }
}

impl Glue for GluedBodies {
    fn len(&self) -> usize {
        self.glue
    }

    fn modes(&self) -> usize {
        self.modes
    }

    fn motions(&self) -> &[Vec<(usize, f64)>] {
        &self.motions
    }

    fn yields(&self) -> &[bool] {
        &self.boundary.yields
    }

    fn network(&self) -> Vec<(usize, usize, f64)> {
        let of_bodies = self.divided().flat_map(|(glued, _, [_, modes])| {
            let matrix = glued.whole().network();
            (0..matrix.len()).flat_map(move |j| {
                let rows = matrix.rows_of(j).iter().zip(matrix.values_of(j));
                let first = modes.start;
                rows.map(move |(&i, &value)| (first + i as usize, first + j, value))
            })
        });
        of_bodies.collect()
    }

    fn works(&self, t: &[f64], work: &mut [f64]) {
        for (glued, _, [glue, modes]) in self.divided() {
            work[modes].copy_from_slice(&glued.whole().works(&t[glue]));
        }
    }

    fn pulls(&self, jumps: &[f64], pull: &mut [f64]) {
        for (glued, _, [glue, modes]) in self.divided() {
            pull[modes].copy_from_slice(&glued.whole().pulls(&jumps[glue]));
        }
    }

    fn push(&self, amplitudes: &[f64], t: &mut [f64]) {
        for (glued, _, [glue, modes]) in self.divided() {
            glued.whole().push(&amplitudes[modes], &mut t[glue]);
        }
    }

    fn part(&self, amplitudes: &[f64], jumps: &mut [f64]) {
        for (glued, _, [glue, modes]) in self.divided() {
            glued.whole().part(&amplitudes[modes], &mut jumps[glue]);
        }
    }

    fn respond(
        &self,
        (lambda, t): (&[f64], &[f64]),
        placed: bool,
        product: &mut [f64],
        jumps: &mut [f64],
    ) {
        let bodies = self.bodies.par_iter();
        let moved = bodies.map(|(inverse, rows, [first, _])| {
            let mut u = vec![0.0; rows.matrix.cols()];
            rows.add_forces(1.0, lambda, &mut u);
            let mut jumps = Vec::new();
            match inverse.glued() {
                Some(glued) => {
                    let t = &t[*first..first + glued.border()];
                    (u, jumps) = glued.move_under(&u, t, placed);
                }
                None => inverse.solve(&mut u),
            }
            let mut out = vec![0.0; rows.index.len()];
            rows.matrix.mul(&u, &mut out);
            (out, jumps)
        });
        let (parts, of_bodies): (Vec<_>, Vec<_>) = moved.collect::<Vec<_>>().into_iter().unzip();
        scatter(self.bodies.iter().map(|body| &*body.1), &parts, product);
        jumps.copy_from_slice(&of_bodies.concat());
    }

    fn enough(&self) -> usize {
        self.enough
    }

    fn keep(&self, lambda: &[f64], t: &[f64]) {
        for (glued, rows, [glue, _]) in self.divided() {
            let mut push = vec![0.0; rows.matrix.cols()];
            rows.add_forces(1.0, lambda, &mut push);
            glued.keep(push, t[glue].to_vec());
        }
    }

    fn precondition(&self, product: &[f64], jumps: &[f64], lambda: &mut [f64], t: &mut [f64]) {
        self.boundary.apply_with(product, jumps, lambda, t);
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

/// The scaled Dirichlet preconditioner M = Σ δ_b² E S_b Eᵀ, an approximation of F⁻¹ on the balanced forces.
///
/// S_b is the boundary stiffness (contact dofs free, all else condensed), E spreads what rows measure over their dofs (`spread.rs`); δ_b
/// is the body's share of the compliance, so that a row between two bodies weighs them by their softness. A row with one body has δ = 1, one that nothing yields to none.
///
/// For forces of one wave length let r be the ratio of the stiffnesses of two bodies, so that F⁻¹ = S₁/(1 + r). With the shares
/// δ₁ = 1/(1 + s), δ₂ = s/(1 + s), M = F⁻¹ where r = s, and M = (1 + s/(1 + s)² · (r/s + s/r − 2)) F⁻¹ elsewhere. A thin plate on a
/// block is as stiff as the block under forces from node to node, and softer by many powers of ten under long waves: with the softness
/// of short waves alone M would be wrong by the same powers. s is the geometric mean of the ratios for the shortest and the longest
/// waves, so that the error is the same at both ends.
///
/// A row that is spread over many nodes of a body measures little of displacements that alternate from node to node. Its softness for
/// these, with the squares of its entries, is its share, so that the side whose nodes bear the forces has most of it.
/// Source: as described for FETI methods by Z. Dostál and others (scaled Dirichlet preconditioner).
#[derive(Clone)]
pub(crate) struct BoundaryStiffness {
    len: usize,
    /// Whether some dof yields to a force on a row, (m,).
    yields: Vec<bool>,
    bodies: Vec<Arc<BoundaryPart>>,
}

struct BoundaryPart {
    rows: Arc<BodyRows>,
    inner: Inner,
    contact: Vec<usize>,
    held: Vec<bool>,
    /// δ_b of each local row.
    weight: Vec<f64>,
    /// E_b.
    spread: SparseMatrix,
}

/// What condenses a body onto its contact dofs.
enum Inner {
    /// K, and its factor with the contact dofs held as well.
    Whole(Cholesky, SymmetricMatrix),
    /// Pieces, their borders held.
    Pieces(Arc<Inverse>),
}

impl BoundaryStiffness {
    pub fn new<const D: usize>(
        len: usize,
        bodies: &[LoadedBody<D>],
        factored: &[FactoredBody],
        ordered: &[Arc<Ordered>],
    ) -> Self {
        let parts = (bodies, factored, ordered).into_par_iter();
        let part = |(b, f, o): (&_, &FactoredBody, &Arc<Ordered>)| boundary_part(b, &f.factor, o);
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
            for (weight, &row) in part.weight.iter_mut().zip(&part.rows.index) {
                if total[row] > 0.0 {
                    *weight /= total[row];
                }
            }
        }
        Self {
            len,
            yields: total.iter().map(|softness| *softness > 0.0).collect(),
            bodies: parts.into_iter().map(Arc::new).collect(),
        }
    }
}

/// `None` where no row touches the body, and for a rigid part, which has no compliance.
fn boundary_part<const D: usize>(
    body: &LoadedBody<D>,
    factor: &Arc<Inverse>,
    ordered: &Ordered,
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
    let inner = match ordered.divided() {
        Some(_) => Inner::Pieces(Arc::clone(factor)),
        None => whole_inner(system, &on_contact, &ordered.grounded)?,
    };
    let short = contact.iter().map(|&dof| 1.0 / diagonal[dof]).sum::<f64>();
    let short = short / contact.len().max(1) as f64;
    // the borders of pieces hold what long waves would move
    let long = match &inner {
        Inner::Whole(..) => largest_softness(body, factor).max(short),
        Inner::Pieces(_) => short,
    };
    let softness = (short * long).sqrt();
    let of_row = |local: usize| {
        let free = rows.matrix.row(local).filter(|(dof, _)| !system.held[*dof]);
        softness * free.map(|(_, value)| value * value).sum::<f64>()
    };
    Some(BoundaryPart {
        weight: (0..rows.index.len()).map(of_row).collect(),
        spread: spread(system, &rows.matrix),
        rows,
        inner,
        contact,
        held: system.held.clone(),
    })
}

/// The factor of a body with its contact dofs held.
fn whole_inner<const D: usize>(
    system: &BodySystem<D>,
    on_contact: &[bool],
    grounded: &[usize],
) -> Option<Inner> {
    let mut keep: Vec<bool> = (0..on_contact.len())
        .map(|dof| !on_contact[dof] && !system.held[dof])
        .collect();
    let inner = factored(system, &keep).or_else(|| {
        // a body that floats on few contact nodes; grounded, its interior cannot fail: it is a part of what was factored
        grounded.iter().for_each(|&dof| keep[dof] = false);
        factored(system, &keep)
    })?;
    Some(Inner::Whole(inner, system.stiffness.clone()))
}

/// Products with F_b after which its largest eigenvalue is known well enough for a weight.
const PRODUCTS: usize = 6;

/// Forces of which less than this part is balanced cause rigid motions only.
const BALANCED: f64 = 1e-10;

/// About the largest softness of a body under balanced contact forces: that of the longest waves.
fn largest_softness<const D: usize>(body: &LoadedBody<D>, factor: &Inverse) -> f64 {
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
    let analysis = analyse::<D>(&system.graph, &system.stiffness, keep, &[]).ok()?;
    analysis.factor(&system.stiffness).ok()
}

impl BoundaryStiffness {
    /// y = Mx, and the forces of the glue of all bodies in pieces for some jumps, one body after the other.
    fn apply_with(&self, x: &[f64], jumps: &[f64], y: &mut [f64], t: &mut [f64]) {
        let mut first = 0;
        let with_jumps = |part: &Arc<BoundaryPart>| {
            let range = first..first + part.inner.glued().map_or(0, Glued::border);
            first = range.end;
            (Arc::clone(part), range)
        };
        let parts: Vec<_> = self.bodies.iter().map(with_jumps).collect();
        let forces = parts.into_par_iter();
        let forces = forces.map(|(part, range)| part.apply(x, &jumps[range]));
        let (parts, of_glue): (Vec<_>, Vec<_>) = forces.collect::<Vec<_>>().into_iter().unzip();
        scatter(self.bodies.iter().map(|part| &*part.rows), &parts, y);
        t.copy_from_slice(&of_glue.concat());
    }
}

impl LinearOperator for BoundaryStiffness {
    fn len(&self) -> usize {
        self.len
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let parts: Vec<Vec<f64>> = self
            .bodies
            .par_iter()
            .map(|part| part.apply(x, &[]).0)
            .collect();
        scatter(self.bodies.iter().map(|part| &*part.rows), &parts, y);
    }
}

impl Inner {
    fn glued(&self) -> Option<&Glued> {
        match self {
            Self::Whole(..) => None,
            Self::Pieces(inverse) => inverse.glued(),
        }
    }

    /// S v on the contact dofs: (K w)_c with w = v there, and K w = 0 inside; and the forces of the glue for some jumps, which may be
    /// left out.
    fn boundary_forces(&self, v: &[f64], jumps: &[f64], contact: &[usize]) -> (Vec<f64>, Vec<f64>) {
        let (inner, stiffness) = match self {
            Self::Whole(inner, stiffness) => (inner, stiffness),
            Self::Pieces(inverse) => {
                return match inverse.glued() {
                    Some(glued) if jumps.is_empty() => (glued.touched_forces(v), Vec::new()),
                    Some(glued) => glued.forces_of(v, jumps),
                    None => (vec![0.0; v.len()], Vec::new()),
                };
            }
        };
        let n = v.len();
        let mut force = vec![0.0; n];
        stiffness.mul(v, &mut force);
        let mut inside = force.clone();
        inner.solve(&mut inside);
        let mut correction = vec![0.0; n];
        stiffness.mul(&inside, &mut correction);
        let mut boundary = vec![0.0; n];
        for &dof in contact {
            boundary[dof] = force[dof] - correction[dof];
        }
        (boundary, Vec::new())
    }
}

impl BoundaryPart {
    /// δ E S Eᵀ δ x on the local rows, and the forces of the glue for some jumps.
    fn apply(&self, x: &[f64], jumps: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let local: Vec<f64> = self
            .rows
            .index
            .iter()
            .zip(&self.weight)
            .map(|(&row, w)| w * x[row])
            .collect();
        let n = self.held.len();
        let mut v = vec![0.0; n];
        self.spread.mul_transpose_add(&local, &mut v);
        for (value, &held) in v.iter_mut().zip(&self.held) {
            if held {
                *value = 0.0;
            }
        }
        let (boundary, glue) = self.inner.boundary_forces(&v, jumps, &self.contact);
        let mut out = vec![0.0; local.len()];
        self.spread.mul(&boundary, &mut out);
        out.iter_mut()
            .zip(&self.weight)
            .for_each(|(value, w)| *value *= w);
        (out, glue)
    }
}
