//! F of the bodies on the contact unknowns: assembled, or, where that is dearer, applied (`applied.rs`).
//!
//! With the contact dofs ordered last, the trailing block of the Cholesky factor, L_c, is the factor of the body's
//! boundary stiffness (the paper's (7.8)). Hence
//!
//! ```text
//!   F_b = B_c K⁺ B_cᵀ = XᵀX,  X = L_c⁻¹ B_cᵀ
//! ```
//!
//! Source: Janovský & Procházka (1980) III, section 7, (7.5)–(7.9).

use crate::dual::Compliance;
use crate::linalg::{Mat, SparseMatrix, gram, solve_lower_in_place};
use crate::model::applied::{BoundaryStiffness, CompliantBodies};
use crate::model::bodies::{BodyRows, LoadedBody};
use crate::model::factor::{FactoredBody, Ordered};
use rayon::prelude::*;
use std::sync::Arc;

/// Most contact unknowns for which F is assembled (72 MB); above, products with F go through the bodies' factors, which takes
/// less time from there on.
pub const DENSE_LIMIT: usize = 3000;

/// F of more unknowns than the first number, of which less than one in the second has an entry, is assembled without its
/// zeros: many bodies.
const FEW: usize = 500;

const SCATTERED: usize = 8;

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
        let preconditioner = Box::new(BoundaryStiffness::new(m, bodies, ordered));
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
