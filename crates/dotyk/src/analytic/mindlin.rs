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
//! (the second root only where |x| < c). q acts in the direction of Q. With p_b(x) = p0 (b/a) √(1−x²/b²), the Hertz pressure
//! of half-width b and force P b²/a², this is q = μ (p_a − p_c). When Q then falls from its largest value Q* to −Q*, and
//! rises again (R. D. Mindlin, H. Deresiewicz, J. Appl. Mech. 20 (1953) 327–344; Johnson, section 7.4), slip begins anew at
//! the edges and bears twice the change:
//!
//! ```text
//!   falling   q = −μ (p_a − 2 p_c′ + p_c*)     c′/a = √(1 − (Q*−Q)/(2μP))     c*/a = √(1 − Q*/(μP))
//!   rising    q = +μ (p_a − 2 p_c′ + p_c*)     c′/a = √(1 − (Q*+Q)/(2μP))
//! ```
//!
//! Slip: the surface under p_b as a shear traction has the slope ∓x/(2R) inside b and ∓(x − √(x²−b²))/(2R) beyond, the factors
//! of a sum of p_b above add up to zero, and so the body loaded by q is displaced against the other by
//!
//! ```text
//!   s(x) = (μ/R) Σ factor · F_b(x)     F_b(x) = ½ [|x| √(x²−b²) − b² arcosh(|x|/b)] where |x| > b, else 0
//! ```
//!
//! Dissipated work: in the flanks |q| = μp, hence W = ∫μp |Δs| dx since Q last turned. By ∂F_b/∂b = −b arcosh(|x|/b) and
//! ∫ √(a²−x²) arcosh(x/b) dx from b to a = (π/4) [a² ln(a/b) − (a²−b²)/2], with k = c²/a²,
//!
//! ```text
//!   W = μ²P²/(2πE*) · [1 − k² + 2k ln k] on the first branch, twice that of k = c′²/a² on each later one
//! ```
//!
//! Stress below the shear traction q0 √(1−x²/a²) along +x (Johnson, section 7.1): by the line force, σz and τxz are the τxz and
//! σx of the same pressure, and
//!
//! ```text
//!   σx = (q0/a) {n [2 − (z²−m²)/(m²+n²)] sign x − 2x}
//! ```
//!
//! with m, n of [`crate::analytic::hertz`].

use crate::analytic::hertz::HalfPlane;
use std::f64::consts::PI;

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
        let held = if x.abs() < c {
            similar(self.normal, c).pressure(x)
        } else {
            0.0
        };
        self.friction * (self.normal.pressure(x) - held)
    }
}

/// p_b: the Hertz pressure of the same bodies with another half-width.
fn similar(normal: HalfPlane, half_width: f64) -> HalfPlane {
    HalfPlane {
        a: half_width,
        p0: normal.p0 * half_width / normal.a,
    }
}

/// Branch of the tangential force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// From zero towards Q*, for the first time.
    First,
    /// From Q* towards −Q*.
    Falling,
    /// From −Q* towards Q*.
    Rising,
}

/// A line contact under constant P while the tangential force goes 0 → Q* → −Q* → Q* → ...
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// The normal problem.
    pub normal: HalfPlane,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Largest tangential force Q*, 0 ≤ Q* ≤ μP.
    pub largest: f64,
    /// Present tangential force Q, −Q* ≤ Q ≤ Q*, not negative on the first branch.
    pub tangential: f64,
    /// Its branch.
    pub way: Way,
}

impl Cycle {
    /// c²/a² or c′²/a²: the part that has not slipped since the force last turned.
    fn stuck(&self) -> f64 {
        let limit = self.friction * self.normal.force();
        match self.way {
            Way::First => 1.0 - self.tangential / limit,
            Way::Falling => 1.0 - 0.5 * (self.largest - self.tangential) / limit,
            Way::Rising => 1.0 - 0.5 * (self.largest + self.tangential) / limit,
        }
    }

    /// Half-width of the zone that has not slipped since the force last turned: c on the first branch, then c′.
    pub fn stick_half_width(&self) -> f64 {
        self.normal.a * self.stuck().sqrt()
    }

    /// The shear traction over μ as a sum of factor · p_b.
    fn parts(&self) -> impl Iterator<Item = (f64, HalfPlane)> {
        let Self { normal, .. } = *self;
        let turned = 1.0 - self.largest / (self.friction * normal.force());
        let now = similar(normal, self.stick_half_width());
        let then = similar(normal, normal.a * turned.sqrt());
        let (sign, [inner, oldest]) = match self.way {
            Way::First => (1.0, [-1.0, 0.0]),
            Way::Falling => (-1.0, [-2.0, 1.0]),
            Way::Rising => (1.0, [-2.0, 1.0]),
        };
        [(1.0, normal), (inner, now), (oldest, then)]
            .into_iter()
            .filter(|(factor, part)| *factor != 0.0 && part.a > 0.0)
            .map(move |(factor, part)| (sign * factor, part))
    }

    /// Shear traction q at x; zero outside the contact.
    pub fn traction(&self, x: f64) -> f64 {
        let parts = self.parts().map(|(factor, part)| factor * part.pressure(x));
        self.friction * parts.sum::<f64>()
    }

    /// Stress [σx, σz, τxz] at (x, z), z ≥ 0, of the shear traction alone, in the body loaded by it along +x.
    ///
    /// The other body, mirrored so that its z points inward too, has minus this. Plane strain and plane stress alike.
    pub fn stress(&self, x: f64, z: f64) -> [f64; 3] {
        self.parts().fold([0.0; 3], |sum, (factor, part)| {
            let stress = sheared(part, x, z);
            std::array::from_fn(|i| sum[i] + self.friction * factor * stress[i])
        })
    }

    /// Tangential displacement, at |x| ≤ a of the surface, of the body loaded by q along +x, relative to the other.
    ///
    /// Unit: length. It is zero where the bodies have always stuck.
    pub fn slip(&self, x: f64, contact_modulus: f64) -> f64 {
        let curvature = 2.0 * self.normal.p0 / (self.normal.a * contact_modulus);
        let slipped = self
            .parts()
            .map(|(factor, part)| factor * beyond(x.abs(), part.a));
        self.friction * curvature * slipped.sum::<f64>()
    }

    /// Work per unit thickness that friction has dissipated since the force last turned, ≥ 0.
    pub fn dissipated(&self, contact_modulus: f64) -> f64 {
        let k = self.stuck();
        // k ln k, with its limit 0
        let logarithm = if k > 0.0 { k * k.ln() } else { 0.0 };
        let limit = self.friction * self.normal.force();
        let ways = match self.way {
            Way::First => 1.0,
            Way::Falling | Way::Rising => 2.0,
        };
        ways * limit * limit / (2.0 * PI * contact_modulus) * (1.0 - k * k + 2.0 * logarithm)
    }
}

/// F_b(x) for x ≥ 0.
fn beyond(x: f64, b: f64) -> f64 {
    if x > b {
        0.5 * (x * (x * x - b * b).sqrt() - b * b * (x / b).acosh())
    } else {
        0.0
    }
}

/// Stress [σx, σz, τxz] at (x, z), z ≥ 0, below the shear traction q0 √(1−x²/a²) along +x; `shear` holds q0 as its p0.
fn sheared(shear: HalfPlane, x: f64, z: f64) -> [f64; 3] {
    let [along, _, across] = shear.stress(x, z);
    let (m, n, _) = shear.root(x, z);
    // n sign x − x is the real part of √(ζ²−a²) − ζ = −a²/(ζ + √(ζ²−a²)), ζ = x + iz: no cancellation far away
    let (real, imaginary) = (x + n.copysign(x), z + m);
    let decay = shear.a * shear.a * real / (real * real + imaginary * imaginary);
    [-2.0 * shear.p0 / shear.a * decay - across, across, along]
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

    const MODULUS: f64 = 7.0;

    /// A cycle of Q* = 0.6 μP at Q = `share` μP.
    fn cycle(share: f64, way: Way) -> Cycle {
        let LineContact {
            normal, friction, ..
        } = contact(0.6);
        let limit = friction * normal.force();
        Cycle {
            normal,
            friction,
            largest: 0.6 * limit,
            tangential: share * limit,
            way,
        }
    }

    const STATES: [(f64, Way); 7] = [
        (0.25, Way::First),
        (0.6, Way::First),
        (0.3, Way::Falling),
        (-0.2, Way::Falling),
        (-0.6, Way::Falling),
        (-0.1, Way::Rising),
        (0.6, Way::Rising),
    ];

    /// ∫f over the contact, cut where roots end.
    fn over_the_contact(cycle: &Cycle, f: impl Fn(f64) -> f64) -> f64 {
        let mut ends: Vec<f64> = cycle.parts().flat_map(|(_, p)| [-p.a, p.a]).collect();
        ends.sort_by(f64::total_cmp);
        let pieces = ends.windows(2).filter(|w| w[0] < w[1]);
        pieces.map(|w| integral(&f, w[0], w[1], 2000)).sum()
    }

    #[test]
    fn a_cycle_carries_its_force_and_closes() {
        for (share, way) in STATES {
            let cycle = cycle(share, way);
            let limit = cycle.friction * cycle.normal.force();
            close(
                over_the_contact(&cycle, |x| cycle.traction(x)),
                share * limit,
                1e-5,
            );
            let c = cycle.stick_half_width();
            for x in [-1.95, -1.4, -0.9, 0.0, 0.5, 1.0, 1.2, 1.7, 1.99] {
                let (q, bound) = (cycle.traction(x), cycle.friction * cycle.normal.pressure(x));
                assert!(q.abs() <= bound + 1e-15);
                let direction = if way == Way::Falling { -1.0 } else { 1.0 };
                assert!(x.abs() <= c || (q - direction * bound).abs() < 1e-14);
            }
        }
        // at a turning point both branches agree, and the end of a cycle equals its beginning
        let same = [
            [(0.6, Way::First), (0.6, Way::Falling)],
            [(-0.6, Way::Falling), (-0.6, Way::Rising)],
            [(0.6, Way::Rising), (0.6, Way::First)],
        ];
        for pair in same {
            let [a, b] = pair.map(|(share, way)| cycle(share, way));
            for x in [0.1, 0.9, 1.3, 1.6, 1.99] {
                close(a.traction(x), b.traction(x), 1e-14);
                close(a.slip(x, MODULUS), b.slip(x, MODULUS), 1e-14);
            }
        }
        for x in [0.1, 0.9, 1.3, 1.6] {
            close(
                cycle(0.6, Way::First).traction(x),
                contact(0.6).traction(x),
                1e-15,
            );
        }
    }

    #[test]
    fn the_slip_is_the_relative_displacement_of_the_surfaces() {
        // ds/dx = −2/(πE*) PV∫q(t)/(x−t) dt
        for (share, way) in STATES {
            let cycle = cycle(share, way);
            for x in [-1.8, 0.4, 1.1, 1.75] {
                let slope = derivative(|x| cycle.slip(x, MODULUS), x, 1e-4);
                let at_x = cycle.traction(x);
                let regular = over_the_contact(&cycle, |t| {
                    let distance: f64 = x - t;
                    if distance.abs() < 1e-9 {
                        0.0
                    } else {
                        (cycle.traction(t) - at_x) / distance
                    }
                });
                let a = cycle.normal.a;
                let principal = regular + at_x * ((x + a) / (a - x)).ln();
                // 2000 points a piece, and the kinks of q at the ends of the pieces
                close(slope, -2.0 / (PI * MODULUS) * principal, 1e-4);
            }
        }
    }

    #[test]
    fn the_dissipated_work_is_friction_times_slip() {
        for (share, way) in STATES {
            let now = cycle(share, way);
            let turn = match way {
                Way::First => 0.0,
                Way::Falling => 0.6,
                Way::Rising => -0.6,
            };
            let then = cycle(turn, way);
            let work = over_the_contact(&now, |x| {
                let moved = now.slip(x, MODULUS) - then.slip(x, MODULUS);
                now.friction * now.normal.pressure(x) * moved.abs()
            });
            close(now.dissipated(MODULUS), work, 1e-6);
            assert!(now.dissipated(MODULUS) > 1e-3);
        }
        // small forces: Q³/(6πE*μP)
        let small = cycle(1e-2, Way::First);
        let limit = small.friction * small.normal.force();
        let cubic = small.tangential.powi(3) / (6.0 * PI * MODULUS * limit);
        // the next term of the series is Q/(2μP) of the first
        close(small.dissipated(MODULUS) / cubic, 1.0, 6e-3);
        close(cycle(0.0, Way::First).dissipated(MODULUS), 0.0, 0.0);
    }

    const POINTS: [[f64; 2]; 6] = [
        [0.0, 0.4],
        [0.9, 0.3],
        [-1.8, 0.5],
        [2.4, 0.2],
        [-4.0, 3.0],
        [30.0, 2.0],
    ];

    #[test]
    fn the_stress_of_the_shear_is_in_equilibrium_and_compatible() {
        let field = cycle(-0.2, Way::Falling);
        for [x, z] in POINTS {
            let h = 1e-3;
            let dx = |i: usize| derivative(|s| field.stress(s, z)[i], x, h);
            let dz = |i: usize| derivative(|s| field.stress(x, s)[i], z, h);
            // Differences of fourth order with h = 1e-3 at distances ≥ 0.2 from the singular ends.
            close(dx(0) + dz(2), 0.0, 1e-8);
            close(dx(2) + dz(1), 0.0, 1e-8);
            let trace = |x: f64, z: f64| field.stress(x, z)[0] + field.stress(x, z)[1];
            let h = 4e-3;
            let second = |f: &dyn Fn(f64) -> f64, s: f64| derivative(|t| derivative(f, t, h), s, h);
            let laplace = second(&|s| trace(s, z), x) + second(&|s| trace(x, s), z);
            close(laplace, 0.0, 1e-5);
        }
    }

    #[test]
    fn the_stress_of_the_shear_is_a_superposition_of_line_forces() {
        // a tangential force q ds at (t, 0) gives the radial stress −2q (x−t)/(π r²) only
        let field = cycle(-0.2, Way::Falling);
        for [x, z] in POINTS {
            for (i, value) in field.stress(x, z).into_iter().enumerate() {
                let sum = over_the_contact(&field, |t| {
                    let (dx, r2) = (x - t, (x - t).powi(2) + z * z);
                    let radial = -2.0 * field.traction(t) * dx / (PI * r2);
                    radial * [dx * dx, z * z, dx * z][i] / r2
                });
                close(value, sum, 1e-7);
            }
        }
    }

    #[test]
    fn the_surface_bears_the_shear_alone() {
        for (share, way) in STATES {
            let field = cycle(share, way);
            for x in [-3.0, -1.9, -0.4, 0.0, 0.9, 1.5, 2.1] {
                let [_, normal, shear] = field.stress(x, 0.0);
                // the outward normal is −z: the traction along x is −τxz
                close(-shear, field.traction(x), 1e-14);
                close(normal, 0.0, 1e-14);
            }
        }
    }
}
