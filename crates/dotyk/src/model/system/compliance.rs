//! F of the bodies on the contact unknowns: assembled, or applied where that is cheaper (`applied.rs`).
//!
//! With the contact dofs ordered last, the trailing block of the Cholesky factor, L_c, is the factor of the body's
//! boundary stiffness (the paper's (7.8)). Hence
//!
//! ```text
//!   F_b = B_c K⁺ B_cᵀ = XᵀX,  X = L_c⁻¹ B_cᵀ
//! ```
//!
//! Where contacts of the plane are short beside their body, the order knows nothing of them, and X is the part of L⁻¹Bᵀ that they reach: the factor
//! is that of the body without contact.
//!
//! Source: Janovský & Procházka (1980) III, section 7, (7.5)–(7.9).

use crate::dual::{Compliance, Glue, Part};
use crate::linalg::{Mat, SparseMatrix, SparseVector, gram, solve_lower_in_place};
use crate::model::system::applied::{BoundaryStiffness, CompliantBodies, GluedBodies};
use crate::model::system::bodies::{BodyRows, LoadedBody};
use crate::model::system::factor::{FactoredBody, Ordered};
use rayon::prelude::*;
use std::sync::Arc;

/// Contact unknowns up to which F is always assembled (72 MB).
pub const DENSE_LIMIT: usize = 3000;

/// Up to this many times the limit, F of few bodies in space is assembled if that is cheaper than products through their factors.
/// Where many bodies clamp each other, an F known entry by entry is better.
const DEARER: usize = 3;
const FEW_BODIES: usize = 4;

/// Cubes of contact unknowns that cost as much as one entry of the factors: condensation and exact steps take 1.5e-10 s of two
/// cores for each of the former, and the thousand products that a problem needs 3e-7 s for each of the latter. Measured on blocks of
/// 4 to 30 layers, with and without friction.
const CUBES_PER_ENTRY: f64 = 2000.0;

/// F of more unknowns than the first number, of which less than one in the second has an entry, is assembled without its
/// zeros: many bodies.
const FEW: usize = 500;

const SCATTERED: usize = 8;

/// Whether F is assembled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Assembled {
    Always,
    /// Where it [pays](pays).
    IfCheaper,
    Never,
}

/// Whether F of m unknowns is assembled: up to the unknowns of `limit` nodes, or if the blocks of the bodies have at most as many
/// entries as a full F of that size. With few bodies in space, and a method that needs few products, larger ones if that pays.
pub(crate) fn is_assembled<const D: usize>(
    rows: &[Arc<BodyRows>],
    m: usize,
    (limit, rough, few_products): (usize, bool, bool),
) -> Assembled {
    let most = limit.saturating_mul(if rough { D } else { 1 });
    let entries: usize = rows.iter().map(|rows| rows.index.len().pow(2)).sum();
    let few = rows.iter().filter(|rows| !rows.index.is_empty()).count() <= FEW_BODIES;
    // above ASSEMBLED unknowns the choice to apply F could not be reversed
    if D == 3
        && few
        && few_products
        && limit < m
        && m <= ASSEMBLED.min(DEARER.saturating_mul(limit))
    {
        return Assembled::IfCheaper;
    }
    match m <= most || entries <= most.saturating_mul(most) {
        true => Assembled::Always,
        false => Assembled::Never,
    }
}

/// Whether most entries of an assembled F of m unknowns are zero.
pub(crate) fn is_scattered(rows: &[Arc<BodyRows>], m: usize) -> bool {
    let entries: usize = rows.iter().map(|rows| rows.index.len().pow(2)).sum();
    m > FEW && entries < m * m / SCATTERED
}

/// Whether F of m unknowns is cheaper to assemble than to apply, by the factors of the bodies without contacts last.
pub(crate) fn pays(m: usize, ordered: &[Arc<Ordered>]) -> bool {
    let entries: usize = ordered.iter().map(|o| o.stored()).sum();
    (m as f64).powi(3) <= CUBES_PER_ENTRY * entries as f64
}

/// F of all bodies: (m, m), assembled where `dense`; without its zeros where these are most of it, and then body by body, too. If it is
/// applied `enough` times, that costs as much as another way to the answer.
pub(crate) fn compliance<const D: usize>(
    bodies: &[LoadedBody<D>],
    factored: &[FactoredBody],
    ordered: &[Arc<Ordered>],
    m: usize,
    (dense, enough): (bool, usize),
) -> (Compliance, Vec<Part>) {
    if !dense {
        let apply = CompliantBodies::new(m, bodies, factored);
        let preconditioner = BoundaryStiffness::new(m, bodies, factored, ordered);
        let glue = GluedBodies::new(&apply, &preconditioner, enough);
        let operator = Compliance::Operator {
            apply: Box::new(apply),
            preconditioner: Box::new(preconditioner),
            glue: glue.map(|glue| Box::new(glue) as Box<dyn Glue>),
        };
        return (operator, Vec::new());
    }
    let blocks: Vec<Mat<f64>> = (bodies, factored, ordered)
        .into_par_iter()
        .map(|(b, f, o)| boundary_compliance(b, f, o))
        .collect();
    let rows: Vec<Arc<BodyRows>> = bodies.iter().map(|body| Arc::clone(&body.rows)).collect();
    if is_scattered(&rows, m) {
        let mut triplets = Vec::new();
        for (body, block) in bodies.iter().zip(&blocks) {
            let index = &body.rows.index;
            for (j, &column) in index.iter().enumerate() {
                let rows = index.iter().enumerate();
                triplets.extend(rows.map(|(i, &row)| (row, column, block[(i, j)])));
            }
        }
        let matrix = SparseMatrix::from_triplets(m, m, &triplets);
        let parts = (bodies, factored, ordered).into_par_iter();
        let parts = parts.map(|(b, f, o)| part(b, f, o)).collect();
        return (Compliance::Sparse(matrix), parts);
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
    (Compliance::Dense(f), Vec::new())
}

/// F of one body on its own rows: XᵀX with X = L_c⁻¹ B_cᵀ.
fn boundary_compliance<const D: usize>(
    body: &LoadedBody<D>,
    factored: &FactoredBody,
    ordered: &Ordered,
) -> Mat<f64> {
    if ordered.trailing.is_empty() {
        let dofs = body.system.load.len();
        let all = &body.rows;
        let row = |local: usize| SparseVector::sum(dofs, all.matrix.row(local).collect());
        let rows: Vec<SparseVector> = (0..all.index.len()).map(row).collect();
        return factored.factor.compliance(&rows);
    }
    let rows = boundary_rows(body, ordered);
    let mut x = Mat::<f64>::zeros(ordered.trailing.len(), rows.len());
    for (j, row) in rows.iter().enumerate() {
        row.add_to(1.0, x.col_as_slice_mut(j));
    }
    solve_lower_in_place(&factored.factor.trailing_factor(), &mut x);
    gram(&x)
}

/// The same as B_c and the boundary stiffness L_c L_cᵀ.
fn part<const D: usize>(body: &LoadedBody<D>, factored: &FactoredBody, ordered: &Ordered) -> Part {
    let factor = factored.factor.trailing_factor();
    Part {
        rows: body.rows.index.clone(),
        stiffness: gram(&factor.transpose().to_owned()),
        columns: boundary_rows(body, ordered),
    }
}

/// B_c: the rows of a body on its trailing dofs. Held and grounded dofs do not move under contact forces.
fn boundary_rows<const D: usize>(body: &LoadedBody<D>, ordered: &Ordered) -> Vec<SparseVector> {
    let rows = &body.rows;
    let mut position = vec![None; body.system.load.len()];
    for (k, &dof) in ordered.trailing.iter().enumerate() {
        position[dof] = Some(k);
    }
    let row = |local: usize| {
        let entries = rows.matrix.row(local);
        let entries = entries.filter_map(|(dof, value)| Some((position[dof]?, value)));
        SparseVector::sum(ordered.trailing.len(), entries.collect())
    };
    (0..rows.index.len()).map(row).collect()
}

/// Most contact unknowns for which F is assembled where iterations within a step do not do (512 MB).
pub const ASSEMBLED: usize = 8192;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::SparseMatrix;
    use Assembled::*;

    fn bodies(rows: impl IntoIterator<Item = usize>) -> Vec<Arc<BodyRows>> {
        let body = |rows: usize| BodyRows {
            index: (0..rows).collect(),
            matrix: SparseMatrix::from_triplets(rows, 1, &[]),
        };
        rows.into_iter().map(|rows| Arc::new(body(rows))).collect()
    }

    #[test]
    fn few_bodies_in_space_are_assembled_where_it_is_cheaper_and_many_as_far_as_their_entries_go() {
        let of = |m: usize, rough: bool| {
            let two = bodies([m, m]);
            let plane = is_assembled::<2>(&two, m, (3000, rough, true));
            (plane, is_assembled::<3>(&two, m, (3000, rough, true)))
        };
        assert_eq!(of(3000, false), (Always, Always));
        assert_eq!(of(3001, false), (Never, IfCheaper));
        assert_eq!(of(5000, true), (Always, IfCheaper));
        assert_eq!(of(8192, true), (Never, IfCheaper));
        assert_eq!(of(9000, true), (Never, Always));
        assert_eq!(of(9001, true), (Never, Never));
        let space =
            |rows: Vec<usize>, m, few| is_assembled::<3>(&bodies(rows), m, (3000, true, few));
        // a method of many products, and many bodies
        assert_eq!(space(vec![5000; 2], 5000, false), Always);
        assert_eq!(space(vec![2000; 5], 5000, true), Always);
        assert_eq!(space(vec![60; 1000], 20_000, true), Always);
        // F is not assembled with a limit of zero
        assert_eq!(
            is_assembled::<3>(&bodies([4, 4]), 4, (0, true, true)),
            Never
        );
    }
}
