//! Hertz: smooth frictionless contact of two elastic bodies, with the stress below the surface.
//!
//! Line contact (H. Hertz, J. reine angew. Math. 92 (1882) 156–171; K. L. Johnson, Contact Mechanics, 1985,
//! section 4.2): two cylinders touch over |x| ≤ a under the force P per unit thickness,
//!
//! ```text
//!   a = √(4PR/(πE*))     p0 = 2P/(πa) = aE*/(2R)     p(x) = p0 √(1 − x²/a²)
//!   1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂                   1/R = 1/R₁ + 1/R₂   (a groove has R < 0, a plane 1/R = 0)
//! ```
//!
//! Stress (E. McEwen, Phil. Mag. 40 (1949) 454–459; Johnson, section 4.2c): x along the surface, z into the body;
//! with A = a² − x² + z², S = √(A² + 4x²z²), m² = (S+A)/2, n² = (S−A)/2, mn = |x|z:
//!
//! ```text
//!   σx  = −(p0/a) [m (1 + (z²+n²)/S) − 2z]
//!   σz  = −(p0/a)  m (1 − (z²+n²)/S)
//!   τxz = −(p0/a)  n (m² − z²)/S · sign x
//! ```
//!
//! Point contact (Johnson, section 4.2a): spheres under the force P touch over r ≤ a,
//! a³ = 3PR/(4E*), p0 = 3P/(2πa²), approach δ = a²/R, p(r) = p0 √(1 − r²/a²).
//!
//! Stress below it (M. T. Huber, Ann. Phys. 14 (1904) 153–163): r from the axis, z into the body, u the larger root of
//! r²/(a²+u) + z²/u = 1, s = √u, q = z/s, k = a²u/(u² + a²z²), t = s/a · atan(a/s):
//!
//! ```text
//!   σr  =  p0 { (1−2ν)/3 · a²/r² (1−q³) + q³k + q [ (1−ν)u/(a²+u) + (1+ν)t − 2 ] }
//!   σθ  = −p0 { (1−2ν)/3 · a²/r² (1−q³)       + q [ (1−ν)u/(a²+u) − (1+ν)t + 2ν ] }
//!   σz  = −p0 q³k
//!   τrz = −p0 · r z² / (u² + a²z²) · a²s/(a²+u)
//! ```
//!
//! It is checked against equilibrium and compatibility. Beside the contact the surface sinks by
//! p0/(2aE') [ (2a²−r²) asin(a/r) + a √(r²−a²) ] (Johnson, equation 3.42).
//!
//! Units: lengths, forces and moduli in any consistent ones. Pressure and P are positive in compression,
//! stress in tension.

use crate::analytic::{Material, Plane};
use std::f64::consts::PI;

/// Contact modulus E* of two materials, 1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂.
pub fn contact_modulus(first: Material, second: Material) -> f64 {
    1.0 / (1.0 / rigid_contact_modulus(first) + 1.0 / rigid_contact_modulus(second))
}

/// Contact modulus E* = E/(1−ν²) of a material against a rigid body.
pub fn rigid_contact_modulus(material: Material) -> f64 {
    material.in_plane(Plane::Strain).young
}

/// Combined radius R, 1/R = 1/R₁ + 1/R₂; a groove has a negative radius, a plane an infinite one.
pub fn combined_radius(first: f64, second: f64) -> f64 {
    1.0 / (1.0 / first + 1.0 / second)
}

/// An elastic half-plane (x along the surface, z ≥ 0 into the body) under the Hertz pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    /// Half-width of the contact.
    pub a: f64,
    /// Largest pressure.
    pub p0: f64,
}

impl HalfPlane {
    /// Line contact under `force` (per unit thickness, > 0) of bodies with combined `radius` and contact modulus.
    pub fn under_force(force: f64, radius: f64, contact_modulus: f64) -> Self {
        let a = (4.0 * force * radius / (PI * contact_modulus)).sqrt();
        Self {
            a,
            p0: 2.0 * force / (PI * a),
        }
    }

    /// Line contact of half-width `a` of bodies with combined `radius` and contact modulus.
    pub fn of_half_width(a: f64, radius: f64, contact_modulus: f64) -> Self {
        Self {
            a,
            p0: 0.5 * a * contact_modulus / radius,
        }
    }

    /// P = πap0/2: force per unit thickness.
    pub fn force(&self) -> f64 {
        0.5 * PI * self.a * self.p0
    }

    /// Contact pressure at x; zero outside the contact.
    pub fn pressure(&self, x: f64) -> f64 {
        let s = x / self.a;
        self.p0 * (1.0 - s * s).max(0.0).sqrt()
    }

    /// Stress [σx, σz, τxz] at (x, z), z ≥ 0; NaN at the two contact edges (±a, 0).
    ///
    /// Plane strain and plane stress alike; σy follows from the plane problem.
    pub fn stress(&self, x: f64, z: f64) -> [f64; 3] {
        let scale = -self.p0 / self.a;
        let (m, n, s) = self.root(x, z);
        let part = (z * z + n * n) / s;
        [
            scale * (m * (1.0 + part) - 2.0 * z),
            scale * m * (1.0 - part),
            scale * n * (m * m - z * z) / s * sign(x),
        ]
    }

    /// m, n ≥ 0 with m − i n sign x = √(a² − (x + iz)²), and s = m² + n².
    pub(crate) fn root(&self, x: f64, z: f64) -> (f64, f64, f64) {
        let area = self.a * self.a - x * x + z * z;
        let s = area.hypot(2.0 * x * z);
        // m n = |x| z gives the smaller of the two without cancellation.
        let larger = (0.5 * (s + area.abs())).sqrt();
        let smaller = x.abs() * z / larger;
        match area >= 0.0 {
            true => (larger, smaller, s),
            false => (smaller, larger, s),
        }
    }
}

/// −1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Point contact of two spheres, or a sphere and a half-space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Radius of the contact.
    pub a: f64,
    /// Largest pressure.
    pub p0: f64,
    /// Approach of distant points.
    pub approach: f64,
}

impl Sphere {
    /// Contact under `force` (> 0) of spheres with combined `radius` and contact modulus.
    pub fn under_force(force: f64, radius: f64, contact_modulus: f64) -> Self {
        let a = (0.75 * force * radius / contact_modulus).cbrt();
        Self {
            a,
            p0: 1.5 * force / (PI * a * a),
            approach: a * a / radius,
        }
    }

    /// Two equal spheres of `radius` and one material whose centres approach by `approach`.
    pub fn equal_pair(approach: f64, radius: f64, material: Material) -> Self {
        Self {
            a: (0.5 * radius * approach).sqrt(),
            p0: rigid_contact_modulus(material) / PI * (2.0 * approach / radius).sqrt(),
            approach,
        }
    }

    /// P = 2πa²p0/3.
    pub fn force(&self) -> f64 {
        2.0 / 3.0 * PI * self.a * self.a * self.p0
    }

    /// Contact pressure at distance r from the axis; zero outside the contact.
    pub fn pressure(&self, r: f64) -> f64 {
        let s = r / self.a;
        self.p0 * (1.0 - s * s).max(0.0).sqrt()
    }

    /// Stress [σr, σθ, σz, τrz] at distance r ≥ 0 from the axis and depth z > 0 of a body with this Poisson's ratio, or at
    /// the surface z = 0 beside the contact.
    pub fn stress(&self, r: f64, z: f64, poisson: f64) -> [f64; 4] {
        let a2 = self.a * self.a;
        let half = 0.5 * (r * r + z * z - a2);
        let u = half + half.hypot(self.a * z);
        let s = u.sqrt();
        let (q, squares) = (z / s, u * u + a2 * z * z);
        let (q3, k) = (q.powi(3), a2 * u / squares);
        let t = s / self.a * self.a.atan2(s);
        // (1 − q³)/r² without cancellation near the axis, by 1 − q² = r²/(a²+u)
        let common = (1.0 - 2.0 * poisson) / 3.0 * a2 / (a2 + u) * (1.0 + q + q * q) / (1.0 + q);
        let share = (1.0 - poisson) * u / (a2 + u);
        let turn = (1.0 + poisson) * t;
        [
            self.p0 * (common + q3 * k + q * (share + turn - 2.0)),
            -self.p0 * (common + q * (share - turn + 2.0 * poisson)),
            -self.p0 * q3 * k,
            -self.p0 * r * z * z / squares * a2 * s / (a2 + u),
        ]
    }

    /// Sinking of the surface of a body with this material at r ≥ a, relative to its distant points.
    pub fn depression(&self, r: f64, material: Material) -> f64 {
        let a = self.a;
        let beside = (2.0 * a * a - r * r) * (a / r).asin() + a * (r * r - a * a).sqrt();
        self.p0 / (2.0 * a * rigid_contact_modulus(material)) * beside
    }

    /// Principal stresses [σr = σθ, σz] on the axis at depth z ≥ 0 of a body with this Poisson's ratio
    /// (Johnson, equations 3.45).
    pub fn axis_stress(&self, z: f64, poisson: f64) -> [f64; 2] {
        let s = z / self.a;
        let decay = 1.0 / (1.0 + s * s);
        // s·atan(1/s), with its limit 0 at the surface.
        let angle = s * 1f64.atan2(s);
        [
            -self.p0 * ((1.0 + poisson) * (1.0 - angle) - 0.5 * decay),
            -self.p0 * decay,
        ]
    }

    /// Radial stress at the contact edge, (1−2ν)p0/3: the largest tension of the contact.
    pub fn edge_tension(&self, poisson: f64) -> f64 {
        (1.0 - 2.0 * poisson) * self.p0 / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, derivative, hilbert, integral};

    const FIELD: HalfPlane = HalfPlane { a: 1.3, p0: 0.7 };
    const POINTS: [[f64; 2]; 5] = [[0.0, 0.4], [0.6, 0.3], [-1.2, 0.5], [1.6, 0.2], [3.0, 2.5]];

    fn steel() -> Material {
        Material {
            young: 210_000.0,
            poisson: 0.3,
        }
    }

    #[test]
    fn the_stress_is_in_equilibrium() {
        for [x, z] in POINTS {
            let h = 1e-3;
            let dx = |i: usize| derivative(|s| FIELD.stress(s, z)[i], x, h);
            let dz = |i: usize| derivative(|s| FIELD.stress(x, s)[i], z, h);
            // Differences of fourth order with h = 1e-3 at distances ≥ 0.3 from the singular edges.
            close(dx(0) + dz(2), 0.0, 1e-8);
            close(dx(2) + dz(1), 0.0, 1e-8);
        }
    }

    #[test]
    fn the_stress_below_a_sphere_is_in_equilibrium_and_compatible() {
        let sphere = Sphere {
            a: 1.3,
            p0: 0.7,
            approach: 0.0,
        };
        let poisson = 0.3;
        for [r, z] in [[0.6, 0.4], [1.9, 0.3], [2.0, 3.0], [0.2, 1.0]] {
            let at = |r: f64, z: f64| sphere.stress(r, z, poisson);
            let h = 1e-3;
            let dr = |i: usize| derivative(|s| at(s, z)[i], r, h);
            let dz = |i: usize| derivative(|s| at(r, s)[i], z, h);
            let [radial, hoop, axial, shear] = at(r, z);
            // Differences of fourth order with h = 1e-3 at distances ≥ 0.2 from axis and edge.
            close(dr(0) + dz(3) + (radial - hoop) / r, 0.0, 1e-8);
            close(dr(3) + dz(2) + shear / r, 0.0, 1e-8);
            let moved = |s: f64| {
                let [radial, hoop, axial, _] = at(s, z);
                s * (hoop - poisson * (radial + axial))
            };
            let strain = radial - poisson * (hoop + axial);
            close(derivative(moved, r, h), strain, 1e-8);
        }
        let [radial, hoop, axial, shear] = sphere.stress(0.0, 0.8, poisson);
        let [across, along] = sphere.axis_stress(0.8, poisson);
        close(radial, across, 1e-14);
        close(hoop, across, 1e-14);
        close(axial, along, 1e-14);
        close(shear, 0.0, 0.0);
        let [radial, ..] = sphere.stress(sphere.a + 1e-12, 0.0, poisson);
        close(radial, sphere.edge_tension(poisson), 1e-8);
        // the surface is continuous at the edge, where the gap of the parabola closes: δ − a²/(2R)
        let touching = Sphere::under_force(1000.0, 10.0, rigid_contact_modulus(steel()));
        let edge = touching.approach - touching.a * touching.a / 20.0;
        close(touching.depression(touching.a, steel()), edge, 1e-12);
    }

    #[test]
    fn the_stress_is_compatible() {
        // Plane elasticity without body forces: σx + σz is harmonic.
        let trace = |x: f64, z: f64| FIELD.stress(x, z)[0] + FIELD.stress(x, z)[1];
        for [x, z] in POINTS {
            let h = 2e-3;
            let second = |f: &dyn Fn(f64) -> f64, s: f64| derivative(|t| derivative(f, t, h), s, h);
            let laplace = second(&|s| trace(s, z), x) + second(&|s| trace(x, s), z);
            close(laplace, 0.0, 1e-6);
        }
    }

    #[test]
    fn the_surface_carries_the_pressure_and_no_shear() {
        for x in [-2.0, -1.2, -0.4, 0.0, 0.9, 1.29, 1.31, 5.0] {
            let [_, normal, shear] = FIELD.stress(x, 0.0);
            close(normal, -FIELD.pressure(x), 1e-14);
            close(shear, 0.0, 1e-14);
        }
    }

    #[test]
    fn the_stress_is_a_superposition_of_line_forces() {
        // Flamant: a force p ds at (s, 0) gives the radial stress −2p z/(π r²) only.
        let [x, z] = [0.8, 0.45];
        let part = |i: usize| {
            integral(
                |s| {
                    let (dx, r2) = (x - s, (x - s).powi(2) + z * z);
                    let radial = -2.0 * FIELD.pressure(s) * z / (PI * r2);
                    radial * [dx * dx, z * z, dx * z][i] / r2
                },
                -FIELD.a,
                FIELD.a,
                4000,
            )
        };
        let stress = FIELD.stress(x, z);
        for (i, value) in stress.into_iter().enumerate() {
            close(value, part(i), 1e-10);
        }
    }

    #[test]
    fn any_depth_carries_the_force() {
        // σz decays like |x|⁻⁴: the tail beyond ±400 is below 1e-8.
        let carried = integral(|x| FIELD.stress(x, 1.1)[1], -400.0, 400.0, 200_000);
        close(carried, -FIELD.force(), 1e-7);
        let pressed = integral(|x| FIELD.pressure(x), -FIELD.a, FIELD.a, 200);
        close(pressed, FIELD.force(), 1e-4);
    }

    #[test]
    fn the_pressed_surface_is_the_parabola() {
        // Slope of the surface of a half-plane, u_z'(x) = −2/(πE*) PV∫p(s)/(x−s) ds, must be −x/R.
        let (radius, modulus) = (12.0, 58_605.2);
        let line = HalfPlane::under_force(1000.0, radius, modulus);
        for x in [-0.7, 0.2, 0.5] {
            let x = x * line.a;
            let slope = -2.0 / (PI * modulus) * hilbert(|s| line.pressure(s), x, line.a, 20_000);
            close(slope, -x / radius, 1e-8);
        }
        let same = HalfPlane::of_half_width(line.a, radius, modulus);
        close(same.p0, line.p0, 1e-9);
    }

    #[test]
    fn largest_shear_lies_below_the_surface() {
        let shear = |z: f64| {
            let [x, z, _] = FIELD.stress(0.0, z * FIELD.a);
            0.5 * (x - z) / FIELD.p0
        };
        // Catalogue: 0.300283 p0 at z = 0.786151 a.
        close(shear(0.786151), 0.300283, 5e-7);
        close(derivative(shear, 0.786151, 1e-3), 0.0, 1e-6);
    }

    #[test]
    fn steel_cylinder_on_aluminium_cylinder() {
        let aluminium = Material {
            young: 70_000.0,
            poisson: 0.33,
        };
        let modulus = contact_modulus(steel(), aluminium);
        close(modulus, 58_605.20, 5e-3);
        let line = HalfPlane::under_force(1000.0, combined_radius(20.0, 30.0), modulus);
        close(line.a, 0.510596, 5e-7);
        close(line.p0, 1246.816, 5e-4);
        let groove = HalfPlane::under_force(1000.0, combined_radius(20.0, -30.0), modulus);
        close(groove.a, 1.141728, 5e-7);
        close(groove.p0, 557.593, 5e-4);
    }

    #[test]
    fn the_pressed_half_space_is_the_sphere() {
        // u_z = 1/(πE*) ∫∫ p/ρ dA with polar coordinates (ρ, φ) about the point: δ − r²/(2R).
        let (radius, modulus) = (10.0, 115_384.6);
        let sphere = Sphere::under_force(1000.0, radius, modulus);
        for r in [0.0, 0.3, 0.8] {
            let r = r * sphere.a;
            let ray = |phi: f64| {
                let (along, across) = (r * phi.cos(), r * phi.sin());
                let chord = (sphere.a * sphere.a - across * across).sqrt();
                integral(
                    |rho| sphere.pressure((rho + along).hypot(across)),
                    0.0,
                    chord - along,
                    200,
                )
            };
            let turns = 64;
            let around = (0..turns)
                .map(|k| ray(2.0 * PI * k as f64 / turns as f64))
                .sum::<f64>()
                * 2.0
                * PI
                / turns as f64;
            let sunk = around / (PI * modulus);
            close(sunk, sphere.approach - r * r / (2.0 * radius), 1e-6);
        }
        let pressed = integral(|r| 2.0 * PI * r * sphere.pressure(r), 0.0, sphere.a, 400);
        close(pressed, 1000.0, 1e-2);
    }

    #[test]
    fn steel_sphere_on_steel_plane() {
        let sphere = Sphere::under_force(1000.0, 10.0, contact_modulus(steel(), steel()));
        close(sphere.a, 0.402073, 5e-7);
        close(sphere.p0, 2953.47, 5e-3);
        close(sphere.approach, 0.0161662, 5e-8);
        // Catalogue: the largest shear stress on the axis, τ/p0 at z/a, for three Poisson's ratios.
        for (poisson, value, depth) in [
            (0.25, 0.32168, 0.46431),
            (0.30, 0.31002, 0.48086),
            (0.33, 0.30317, 0.49082),
        ] {
            let shear = |s: f64| {
                let [r, z] = sphere.axis_stress(s * sphere.a, poisson);
                0.5 * (r - z) / sphere.p0
            };
            close(shear(depth), value, 5e-6);
            // The depth is printed to 5e-6, the curvature there is about 2.
            close(derivative(shear, depth, 1e-3), 0.0, 2e-5);
        }
        close(sphere.edge_tension(0.5), 0.0, 1e-12);
    }

    #[test]
    fn the_axis_of_a_sphere_is_a_superposition_of_point_forces() {
        // Boussinesq on the axis: σz = −3P z³/(2πR⁵).
        let sphere = Sphere::under_force(1.0, 3.0, 2.0);
        let z = 0.7 * sphere.a;
        let sum = integral(
            |r| {
                let far = r.hypot(z);
                -3.0 * z.powi(3) * sphere.pressure(r) * r / far.powi(5)
            },
            0.0,
            sphere.a,
            4000,
        );
        close(sphere.axis_stress(z, 0.2)[1], sum, 1e-6);
    }

    #[test]
    fn two_equal_spheres_are_one_sphere_of_half_the_radius() {
        let pair = Sphere::equal_pair(0.02, 50.0, steel());
        let modulus = contact_modulus(steel(), steel());
        let one = Sphere::under_force(pair.force(), combined_radius(50.0, 50.0), modulus);
        close(one.a, pair.a, 1e-12);
        close(one.approach, pair.approach, 1e-15);
    }
}
