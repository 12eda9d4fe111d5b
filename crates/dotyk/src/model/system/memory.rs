//! Checks that a model fits its memory limit, before the factorisation.
//!
//! ```text
//!   a body:    24|K| + 8|L| + 8(t² + tr + r²)     its stiffness as it is, permuted and analysed; its factor; L_c, X and F_b
//!                or 24|K| + 8(|L| + s), if more      s what is kept beside a factor while one thread forms it
//!   applied:   24|K| + 16|L| + 8s                 with the factor of the preconditioner, which has not more entries
//!   in pieces: 24|K| + 8|L|                      K and L those of all pieces of a process, and what is assembled of the whole
//!   yielding:  600 per dof                        44 displacements of Anderson's method and around it, and four plastic strains of
//!                                                 7 numbers at about as many points as there are dofs
//!   all:       8 · 3m²                            F, and the system of an exact step with its factor
//! ```
//!
//! A mesh alone gives a lower bound: |K| of a large regular one, and |L| ≥ |K|. That is checked before it is made, and before it is
//! assembled.
//!
//! |K| and |L| are stored entries, t contact dofs and r rows of a body, m all rows. Where F is assembled without its zeros,
//! Σr² stands for m². Meshes and results are small beside this.

use crate::host::team;
use crate::mesh::{CellKind, Mesh};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::system::parts::part_name;
use crate::model::system::pieces::pieces;

/// Sizes of a body that determine its memory.
pub(crate) struct Demand {
    /// Its contact dofs.
    pub trailing: usize,
    /// Entries of its factor.
    pub factor: usize,
    /// Numbers that are kept beside it while it is formed.
    pub beside: usize,
    /// Entries of the stiffnesses and factors of its pieces, of a body that is divided.
    pub pieces: Option<[usize; 2]>,
    /// Entries of its stiffness.
    pub stiffness: usize,
    /// Its dofs.
    pub dofs: usize,
    /// Its rows of B.
    pub rows: usize,
    /// It may yield.
    pub yields: bool,
}

/// Bytes for each dof of a body that may yield.
const YIELDING: u64 = 600;

impl Demand {
    /// Bytes, with F assembled or applied.
    fn bytes(&self, dense: bool) -> u64 {
        let [t, r, beside] = [self.trailing, self.rows, self.beside].map(|n| n as u64);
        let factor = 8 * self.factor as u64;
        let own = match (self.pieces, dense) {
            (Some([stiffness, factors]), _) => 24 * stiffness as u64 + 8 * factors as u64,
            (None, true) => factor + 8 * (t * t + t * r + r * r).max(beside),
            (None, false) => 2 * factor + 8 * beside,
        };
        let yielding = if self.yields { YIELDING } else { 0 };
        24 * self.stiffness as u64 + own + yielding * self.dofs as u64
    }
}

/// Least bytes of the stiffness and factor of so many cells.
pub(crate) fn least<const D: usize>(kind: CellKind, cells: u64) -> u64 {
    cells
        .saturating_mul(pairs(kind))
        .saturating_mul((32 * D * D) as u64)
}

/// Pairs of nodes that share a cell, each once, of a large regular mesh, for each of its cells, rounded down.
const fn pairs(kind: CellKind) -> u64 {
    use CellKind::*;
    match kind {
        Line2 | Line3 => 1,
        Tri3 => 2,
        Tri6 => 11,
        Quad4 => 5,
        Quad8 => 24,
        Quad9 => 34,
        Tet4 => 1,
        Tet10 => 15,
        Hex8 => 14,
        Hex20 => 110,
        Hex27 => 260,
        Prism6 => 5,
        Prism15 => 40,
        Prism18 => 70,
    }
}

/// The same of a mesh.
fn of_mesh<const D: usize>(mesh: &Mesh<D>) -> u64 {
    let blocks = mesh.blocks().iter();
    let each = blocks.map(|block| least::<D>(block.kind, block.cells().len() as u64));
    each.sum()
}

/// Errors: [`Error::Memory`] if the meshes alone show that their bodies need more than the model may take.
pub(crate) fn check_meshes<const D: usize>(model: &Model<D>) -> Result<(), Error<D>> {
    let processes = team().size() as u64;
    let each = model.bodies.iter().zip(pieces(model));
    let own = each.map(|(body, pieces)| match pieces {
        Some(_) => of_mesh(&body.mesh) / processes,
        None => of_mesh(&body.mesh),
    });
    let own: Vec<u64> = own.collect();
    let dofs = |body: usize| D * model.bodies[body].mesh.points().len();
    within(model, &own, 0, dofs)
}

/// Errors: [`Error::Memory`] if the bodies need more than the model may take, with the largest body.
pub(crate) fn check<const D: usize>(
    model: &Model<D>,
    bodies: &[Demand],
    dense: bool,
    m: usize,
) -> Result<(), Error<D>> {
    let own: Vec<u64> = bodies.iter().map(|body| body.bytes(dense)).collect();
    let blocks: u64 = bodies.iter().map(|body| (body.rows as u64).pow(2)).sum();
    let shared = match dense {
        true => 24 * blocks.min((m as u64).pow(2)),
        false => 0,
    };
    within(model, &own, shared, |body| bodies[body].dofs)
}

/// Errors: [`Error::Memory`] if the bodies and their shared data need more than the model may take.
fn within<const D: usize>(
    model: &Model<D>,
    own: &[u64],
    shared: u64,
    dofs: impl Fn(usize) -> usize,
) -> Result<(), Error<D>> {
    let Some(free) = model.solver.memory else {
        return Ok(());
    };
    let needed = own.iter().sum::<u64>() + shared;
    let largest = own.iter().enumerate().max_by_key(|(_, bytes)| **bytes);
    match largest {
        Some((body, &bytes)) if needed > free => Err(Error::Memory {
            body: part_name(model, body),
            unknowns: dofs(body),
            bytes,
            needed,
            free,
        }),
        _ => Ok(()),
    }
}
