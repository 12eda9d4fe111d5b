//! Incompatible modes: linear quadrilaterals and hexahedra that can bend.
//!
//! The displacements of such a cell are linear along its edges. In bending it shows a spurious shear, which grows with its length.
//! Here each cell has additional fields φₖ = 1 − ξₖ², with amplitudes αₖ of its own:
//!
//! ```text
//!   H = Σ uₐ ⊗ ∇Nₐ + Σ αₖ ⊗ gₖ,      gₖ = −2ξₖ (j₀/j) J₀⁻ᵀeₖ,      min over α of ½∫ σ(H):H dV
//! ```
//!
//! With the Jacobian J₀ of the centre and the ratio of its determinant to that of the point, ∫gₖ dV = 0 in cells of any shape:
//! a constant stress does no work on them, so that the patch test holds. The amplitudes are eliminated cell by cell,
//! K = Kᵤᵤ − Kᵤₐ Kₐₐ⁻¹ Kₐᵤ, and recovered from the displacements for forces and stresses.
//!
//! An initial strain ε₀ (`initial.rs`) holds the modes by hₐ = −∫ Cε₀ gₖ dV, with which
//!
//! ```text
//!   α = −Kₐₐ⁻¹(hₐ + Kₐᵤ u),      forces of the cell on its nodes: K u + hᵤ − Kᵤₐ Kₐₐ⁻¹ hₐ
//! ```
//!
//! so that a cell bends freely where ε₀ is linear. hₐ = 0 where ε₀ is constant.
//! Source: as described in R. L. Taylor, P. J. Beresford and E. L. Wilson, Int. J. Numer. Methods Eng. 10 (1976) 1211–1219.

use crate::geometry::{Point, sub};
use crate::mesh::CellKind;

/// Whether cells of a kind have incompatible modes.
pub(crate) fn has_modes(kind: CellKind) -> bool {
    matches!(kind, CellKind::Quad4 | CellKind::Hex8)
}

/// Eliminates the dofs of a symmetric positive matrix (size, size) after the first `kept`: its leading part becomes that of the
/// kept dofs, and the rows of the eliminated ones give their values.
pub(crate) fn eliminate(matrix: &mut [f64], size: usize, kept: usize) {
    for p in (kept..size).rev() {
        let pivot = matrix[p * size + p];
        for i in 0..p {
            let factor = matrix[i * size + p] / pivot;
            for j in 0..p {
                matrix[i * size + j] -= factor * matrix[p * size + j];
            }
        }
    }
}

/// Displacements of the nodes of a cell relative to its first one, (D·nodes,): a rigid motion does not affect the modes.
pub(crate) fn relative<const D: usize>(cell: &[u32], displacement: &[Point<D>]) -> Vec<f64> {
    let first = displacement[cell[0] as usize];
    let of_node = |&node: &u32| sub(displacement[node as usize], first);
    cell.iter().flat_map(of_node).collect()
}

/// Transfers forces (size,) on the dofs after the first `kept` to the kept ones, with the matrix as [`eliminate`] left it.
pub(crate) fn condense(matrix: &[f64], size: usize, kept: usize, forces: &mut [f64]) {
    for p in (kept..size).rev() {
        let row = &matrix[p * size..(p + 1) * size];
        let part = forces[p] / row[p];
        let before = forces[..p].iter_mut().zip(row);
        before.for_each(|(force, k)| *force -= k * part);
    }
}

/// The amplitudes of the modes, from the matrix as [`eliminate`] left it, the displacements of the nodes, and the forces that hold
/// the modes as [`condense`] left them.
pub(crate) fn amplitudes<const D: usize>(
    matrix: &[f64],
    size: usize,
    relative: &[f64],
    held: &[f64],
) -> Vec<Point<D>> {
    let mut values = relative.to_vec();
    for p in relative.len()..size {
        let row = &matrix[p * size..(p + 1) * size];
        let sum: f64 = row.iter().zip(&values).map(|(k, u)| k * u).sum();
        values.push(-(held[p] + sum) / row[p]);
    }
    let modes = values[relative.len()..].chunks_exact(D);
    modes.map(|c| std::array::from_fn(|i| c[i])).collect()
}

/// The energy that the modes would release if they were free, at these displacements of the nodes.
pub(crate) fn released(matrix: &[f64], size: usize, relative: &[f64]) -> f64 {
    let of_row = |p: usize| {
        let row = &matrix[p * size..(p + 1) * size];
        let sum: f64 = row.iter().zip(relative).map(|(k, u)| k * u).sum();
        0.5 * sum * sum / row[p]
    };
    (relative.len()..size).map(of_row).sum()
}
