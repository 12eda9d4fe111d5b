//! Cattaneo–Mindlin: a Hertz line contact, then a tangential force below the friction limit.
//!
//! C. Cattaneo, Rend. Accad. Naz. Lincei 27 (1938) 342–348, 434–436, 474–478; R. D. Mindlin, J. Appl. Mech. 16 (1949)
//! 259–268; K. L. Johnson, Contact Mechanics, 1985, section 7.2. Two elastically similar bodies (identical materials),
//! first P, then 0 ≤ Q ≤ μP: the middle |x| < c sticks, the flanks slip,
//!
//! ```text
//!   q(x) = μp0 [√(1−x²/a²) − (c/a) √(1−x²/c²)],     c/a = √(1 − Q/(μP))
//! ```
//!
//! (the second root only where |x| < c). q acts in the direction of Q.

use crate::analytic::hertz::HalfPlane;

/// A line contact under normal, then tangential force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineContact {
    /// The normal problem.
    pub normal: HalfPlane,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Tangential force Q per unit thickness, 0 ≤ Q ≤ μP.
    pub tangential: f64,
}

impl LineContact {
    /// Half-width c of the zone that sticks; NaN when Q exceeds μP.
    pub fn stick_half_width(&self) -> f64 {
        let limit = self.friction * self.normal.force();
        self.normal.a * (1.0 - self.tangential / limit).sqrt()
    }

    /// Shear traction q at x; zero outside the contact.
    pub fn traction(&self, x: f64) -> f64 {
        let c = self.stick_half_width();
        let inner = HalfPlane {
            a: c,
            p0: self.normal.p0 * c / self.normal.a,
        };
        let held = if x.abs() < c { inner.pressure(x) } else { 0.0 };
        self.friction * (self.normal.pressure(x) - held)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, derivative, integral};

    fn contact(share: f64) -> LineContact {
        let normal = HalfPlane { a: 2.0, p0: 5.0 };
        LineContact {
            normal,
            friction: 0.3,
            tangential: share * 0.3 * normal.force(),
        }
    }

    #[test]
    fn the_traction_carries_the_tangential_force_within_the_friction_limit() {
        let contact = contact(0.6);
        let c = contact.stick_half_width();
        let q = |x: f64| contact.traction(x);
        let carried =
            integral(q, -2.0, -c, 4000) + integral(q, -c, c, 4000) + integral(q, c, 2.0, 4000);
        close(carried, contact.tangential, 1e-5);
        for x in [0.0, 0.3, 1.0, 1.3, 1.7, 1.99] {
            let limit = 0.3 * contact.normal.pressure(x);
            assert!(q(x) >= 0.0 && q(x) <= limit + 1e-15);
            assert_eq!(
                x > c,
                (q(x) - limit).abs() < 1e-15,
                "slip only in the flanks"
            );
        }
    }

    #[test]
    fn the_middle_does_not_slip() {
        // The relative tangential displacement is −k∫q ln|x−s| ds: its slope vanishes where the bodies stick only.
        let contact = contact(0.5);
        let c = contact.stick_half_width();
        let shift = |x: f64| {
            let f = |s: f64| contact.traction(s) * (x - s).abs().ln();
            let mut ends = [-2.0, -c, c, 2.0, x];
            ends.sort_by(f64::total_cmp);
            ends.windows(2)
                .map(|w| integral(f, w[0], w[1], 20_000))
                .sum::<f64>()
        };
        for x in [0.2, 0.7, 0.9 * c] {
            close(derivative(shift, x, 1e-2), 0.0, 1e-5);
        }
        assert!(derivative(shift, 1.7, 1e-2).abs() > 0.05);
    }

    #[test]
    fn stick_width_by_the_catalogue() {
        close(contact(0.6).stick_half_width() / 2.0, 0.63246, 5e-6);
        close(contact(0.0).stick_half_width(), 2.0, 1e-15);
        close(contact(1.0).stick_half_width(), 0.0, 0.0);
        assert!(contact(1.1).stick_half_width().is_nan());
    }
}
