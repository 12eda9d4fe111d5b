//! Change of volume of cells that flow plastically.
//!
//! Metal flows at constant volume. If that held at every point of a quadrilateral or hexahedron of second order, 9 or 27 of them, its
//! nodes would have no motion to flow with: such cells lock, and bear any load. So they resist only the linear part θ̄ of their change
//! of volume θ = ∇·u,
//!
//! ```text
//!   σ = C(ε − ε_p − ⅓(θ − θ̄) I),        θ̄ = the linear function of the cell nearest to θ in ∫(θ − θ̄)² dV
//! ```
//!
//! Their mean stress is linear then, does work on θ̄ alone, ∫ p̄ ∇·v dV = ∫ p̄ θ̄(v) dV, and the forces are those of a convex energy
//! that is nowhere more than the elastic one. Other cells have no more points than motions, or are of first order and reported to lock.
//!
//! Source: J. C. Nagtegaal, D. M. Parks, J. R. Rice, Comput. Methods Appl. Mech. Engrg. 4 (1974) 153–177; the linear mean stress as
//! described in T. J. R. Hughes, The Finite Element Method, section 4.4.

use crate::mesh::CellKind;

/// Most points of the stiffness of a cell.
pub(crate) const MOST: usize = 27;

/// Cells that resist only the linear part of their change of volume where they flow.
pub(crate) fn gives_way(kind: CellKind) -> bool {
    use CellKind::*;
    matches!(kind, Quad8 | Quad9 | Hex20 | Hex27)
}

/// Subtracts from values at points of a cell the linear function nearest to them; the points are given by their volumes and reference
/// coordinates, of which `dimension` count.
pub(crate) fn take_linear(
    dimension: usize,
    (places, volumes): (&[[f64; 3]], &[f64]),
    values: &mut [f64],
) {
    let product = |a: &[f64], b: &[f64]| -> f64 {
        let parts = volumes.iter().zip(a.iter().zip(b));
        parts.map(|(volume, (a, b))| volume * a * b).sum()
    };
    let count = values.len();
    let mut basis = [[0.0; MOST]; 4];
    for k in 0..=dimension {
        let (before, rest) = basis.split_at_mut(k);
        let own = &mut rest[0][..count];
        for (value, xi) in own.iter_mut().zip(places) {
            *value = if k == 0 { 1.0 } else { xi[k - 1] };
        }
        for other in &*before {
            take(other, product(own, other) / product(other, other), own);
        }
        take(own, product(values, own) / product(own, own), values);
    }
}

fn take(vector: &[f64], factor: f64, from: &mut [f64]) {
    let both = from.iter_mut().zip(vector);
    both.for_each(|(value, part)| *value -= factor * part);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_has_no_linear_part() {
        let places: Vec<[f64; 3]> = (0..9)
            .map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0])
            .collect();
        let volume = |xi: &[f64; 3]| 1.0 + 0.3 * xi[0] - 0.2 * xi[0] * xi[1];
        let volumes: Vec<f64> = places.iter().map(volume).collect();
        let all = (&places[..], &volumes[..]);
        let linear = |xi: &[f64; 3]| 2.0 - xi[0] + 3.0 * xi[1];
        let mut values: Vec<f64> = places.iter().map(linear).collect();
        take_linear(2, all, &mut values);
        assert!(values.iter().all(|value| value.abs() < 1e-14));
        let other = |xi: &[f64; 3]| (xi[0] + 2.0 * xi[1]).exp();
        let mut values: Vec<f64> = places.iter().map(other).collect();
        take_linear(2, all, &mut values);
        for function in [
            |_: &[f64; 3]| 1.0,
            |xi: &[f64; 3]| xi[0],
            |xi: &[f64; 3]| xi[1],
        ] {
            let parts = places.iter().zip(&volumes).zip(&values);
            let work: f64 = parts.map(|((xi, w), v)| w * v * function(xi)).sum();
            assert!(work.abs() < 1e-13, "{work}");
        }
        assert!(values.iter().any(|value| value.abs() > 0.1));
    }
}
