//! Flat rigid frictionless punch on an elastic half-plane or half-space.
//!
//! Plane (M. A. Sadowsky, Z. angew. Math. Mech. 8 (1928) 107–121): p = P/(π√(a²−x²)).
//! Circular (J. Boussinesq, Application des potentiels, 1885): p = P/(2πa√(a²−r²)), sinking δ = P/(2aE*).
//! Both in K. L. Johnson, Contact Mechanics, 1985, sections 2.8 and 3.4. E* = E/(1−ν²).
//!
//! The pressure is infinite at the edge: compare forces, and pressures at r ≤ 0.7a.
//! P and p are positive in compression, δ into the body.

use std::f64::consts::PI;

/// Pressure at x under a plane punch of half-width `a` and force P per unit thickness; zero outside.
pub fn plane_pressure(force: f64, a: f64, x: f64) -> f64 {
    if x.abs() >= a {
        return 0.0;
    }
    force / (PI * (a * a - x * x).sqrt())
}

/// Pressure at radius r under a circular punch of radius `a` and force P; zero outside.
pub fn circular_pressure(force: f64, a: f64, r: f64) -> f64 {
    if r.abs() >= a {
        return 0.0;
    }
    force / (2.0 * PI * a * (a * a - r * r).sqrt())
}

/// Sinking of a circular punch, P/(2aE*).
pub fn circular_sinking(force: f64, a: f64, contact_modulus: f64) -> f64 {
    force / (2.0 * a * contact_modulus)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, integral};

    #[test]
    fn the_plane_punch_carries_its_force_and_stays_flat() {
        let a = 1.7;
        let pressed = integral(|x| plane_pressure(3.0, a, x), -a, a, 2000);
        close(pressed, 3.0, 1e-9);
        // Surface displacement −2/(πE*) ∫p ln|x−s| ds: the same at every x under the punch.
        let sunk = |x: f64| {
            let kernel = |s: f64| plane_pressure(3.0, a, s) * (x - s).abs().ln();
            integral(kernel, -a, x, 20_000) + integral(kernel, x, a, 20_000)
        };
        let middle = sunk(0.0);
        for x in [0.3, 0.8, 1.5] {
            close(sunk(x), middle, 1e-6);
        }
    }

    #[test]
    fn the_circular_punch_carries_its_force_and_stays_flat() {
        let (a, modulus) = (0.6, 40.0);
        let pressed = integral(
            |r| 2.0 * PI * r * circular_pressure(3.0, a, r),
            0.0,
            a,
            4000,
        );
        close(pressed, 3.0, 1e-5);
        // u_z = 1/(πE*) ∫∫ p/ρ dA in polar coordinates (ρ, φ) about the point.
        for r in [0.0, 0.3 * a, 0.8 * a] {
            let ray = |phi: f64| {
                let (along, across) = (r * phi.cos(), r * phi.sin());
                let chord = (a * a - across * across).sqrt();
                integral(
                    |rho| circular_pressure(3.0, a, (rho + along).hypot(across)),
                    0.0,
                    chord - along,
                    2000,
                )
            };
            let turns = 256;
            let step = 2.0 * PI / turns as f64;
            let around = (0..turns).map(|k| ray(k as f64 * step)).sum::<f64>() * step;
            close(
                around / (PI * modulus),
                circular_sinking(3.0, a, modulus),
                1e-5,
            );
        }
    }
}
