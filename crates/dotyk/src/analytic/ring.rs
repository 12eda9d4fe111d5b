//! A thick ring in an infinite elastic plate that is compressed from afar: the lined tunnel, exactly.
//!
//! The ring (inner radius b, outer radius R) fills the hole of the plate before the load acts. Far away
//! σyy = −sv (vertical, compression positive) and σxx = −K sv. θ is measured from the springline (+x).
//! J. H. Michell, Proc. London Math. Soc. 31 (1899) 100–124, general series; of it the harmonics n = 0 and 2 are present
//! (J. R. Barber, Elasticity, 2010, chapters 8 and 9). With ρ = r/R and Airy's function R²φ,
//!
//! ```text
//!   φ = A ln ρ + C ρ² + (a ρ² + b ρ⁴ + c ρ⁻² + d) cos 2θ
//!   σrr =   A/ρ² + 2C − (2a           + 6c/ρ⁴ + 4d/ρ²) cos 2θ
//!   σθθ = − A/ρ² + 2C + (2a + 12b ρ² + 6c/ρ⁴         ) cos 2θ
//!   τrθ =               (2a +  6b ρ² − 6c/ρ⁴ − 2d/ρ²) sin 2θ
//!   2μ ur/R = −A/ρ + (κ−1)C ρ + (−2aρ + (κ−3)bρ³ + 2c/ρ³ + (κ+1)d/ρ) cos 2θ
//!   2μ uθ/R =                   ( 2aρ + (κ+3)bρ³ + 2c/ρ³ − (κ−1)d/ρ) sin 2θ
//! ```
//!
//! Plate: C = −sv(1+K)/4 and a = −sv(1−K)/4 are the far field, b = 0; unknown A, c, d.
//! Ring: A, C and a, b, c, d unknown.
//!
//! n = 0, three equations: ring σrr = 0 at ρ = b/R; σrr and ur continuous at ρ = 1.
//! n = 2, six equations: ring σrr = τrθ = 0 at ρ = b/R; σrr and ur continuous at ρ = 1; and there
//! full slip: τrθ = 0 on both sides; bonded: τrθ and uθ continuous.
//!
//! The contact is bilateral here: it is the solution of the unilateral problem when [`RingInPlate::pressure`] is
//! nowhere negative. Pressure is positive in compression, stress in tension; lengths and stresses in any consistent units.

use crate::analytic::{Material, Plane, solve};
use crate::geometry::Point;

/// The law of the interface between ring and plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    /// No friction.
    FullSlip,
    /// No relative displacement.
    Bonded,
}

/// The ring or the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// inner ≤ r ≤ radius.
    Ring,
    /// r ≥ radius.
    Plate,
}

/// A ring that fills a round hole at the origin of an infinite plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingInPlate {
    /// Inner radius of the ring, > 0.
    pub inner: f64,
    /// Radius of the interface, > inner.
    pub radius: f64,
    /// Material of the ring.
    pub ring: Material,
    /// Material of the plate.
    pub plate: Material,
    /// Plane strain or plane stress, for both.
    pub plane: Plane,
    /// Vertical compression sv far away.
    pub vertical: f64,
    /// K: horizontal over vertical compression far away.
    pub ratio: f64,
    /// Full slip or bonded.
    pub interface: Interface,
}

/// Stress in polar components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarStress {
    /// σrr.
    pub radial: f64,
    /// σθθ.
    pub hoop: f64,
    /// τrθ.
    pub shear: f64,
}

/// Mean and cos 2θ (or sin 2θ) amplitude of a quantity on one circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonics {
    /// Mean value.
    pub mean: f64,
    /// Amplitude of cos 2θ (radial and hoop components) or sin 2θ (shear and tangential ones).
    pub second: f64,
}

impl RingInPlate {
    /// Contact pressure p(θ) = p0 + p2 cos 2θ, θ in radians from the springline.
    pub fn pressure(&self, theta: f64) -> f64 {
        let Harmonics { mean, second } = self.pressure_harmonics();
        mean + second * (2.0 * theta).cos()
    }

    /// p0 and p2 of the contact pressure.
    pub fn pressure_harmonics(&self) -> Harmonics {
        let [radial, ..] = self.stress_harmonics(self.radius, Part::Plate);
        Harmonics {
            mean: -radial.mean,
            second: -radial.second,
        }
    }

    /// Harmonics of σrr, σθθ (cos 2θ) and τrθ (sin 2θ) on the circle of radius r.
    pub fn stress_harmonics(&self, r: f64, part: Part) -> [Harmonics; 3] {
        self.series(part).stress_harmonics(r)
    }

    /// Harmonics of ur (cos 2θ) and uθ (sin 2θ) on the circle of radius r; radial displacement positive outward.
    pub fn displacement_harmonics(&self, r: f64, part: Part) -> [Harmonics; 2] {
        self.series(part).displacement_harmonics(r)
    }

    /// Stress in polar components at radius r and angle θ (radians).
    pub fn polar_stress(&self, r: f64, theta: f64, part: Part) -> PolarStress {
        self.series(part).polar_stress(r, theta)
    }

    /// Stress [σxx, σyy, τxy] at a point.
    pub fn stress(&self, point: Point<2>, part: Part) -> [f64; 3] {
        self.series(part).stress(point)
    }

    /// Traction σn on a cut with unit normal n, in the plate outside the interface and on it, in the ring inside.
    pub fn traction(&self, point: Point<2>, normal: [f64; 2]) -> [f64; 2] {
        let part = if point[0].hypot(point[1]) >= self.radius {
            Part::Plate
        } else {
            Part::Ring
        };
        let [xx, yy, xy] = self.stress(point, part);
        [
            xx * normal[0] + xy * normal[1],
            xy * normal[0] + yy * normal[1],
        ]
    }

    /// Displacement [ux, uy] at a point; the rigid motion is the one that keeps both axes of symmetry in place.
    pub fn displacement(&self, point: Point<2>, part: Part) -> [f64; 2] {
        self.series(part).displacement(point)
    }

    fn material(&self, part: Part) -> Material {
        match part {
            Part::Ring => self.ring,
            Part::Plate => self.plate,
        }
    }

    fn series(&self, part: Part) -> Series {
        self.series_under(Loading::FromAfar, part)
    }

    /// The series of one part; that of the plate includes the far field, whose stress is present under both loadings.
    pub(super) fn series_under(&self, loading: Loading, part: Part) -> Series {
        let [ring_log, ring_square, plate_log] = self.solve_mean(loading);
        let [ra, rb, rc, rd, pc, pd] = self.solve_second(loading);
        let (mean, second) = match part {
            Part::Ring => ([ring_log, ring_square], [ra, rb, rc, rd]),
            Part::Plate => (
                [plate_log, self.far_mean()],
                [self.far_second(), 0.0, pc, pd],
            ),
        };
        Series {
            radius: self.radius,
            material: self.material(part),
            plane: self.plane,
            mean,
            second,
        }
    }

    /// C of the plate.
    pub(super) fn far_mean(&self) -> f64 {
        -0.25 * self.vertical * (1.0 + self.ratio)
    }

    /// a of the plate.
    pub(super) fn far_second(&self) -> f64 {
        -0.25 * self.vertical * (1.0 - self.ratio)
    }

    /// Shear modulus of the plate over that of the ring: displacement equations are multiplied by 2μ of the plate.
    fn stiffness_ratio(&self) -> f64 {
        self.plate.shear() / self.ring.shear()
    }

    /// n = 0: A and C of the ring, A of the plate.
    fn solve_mean(&self, loading: Loading) -> [f64; 3] {
        let rho = self.inner / self.radius;
        let s = self.stiffness_ratio();
        let ring = self.ring.kolosov(self.plane) - 1.0;
        let plate = self.plate.kolosov(self.plane) - 1.0;
        let far = self.far_mean();
        solve(
            [
                [1.0 / (rho * rho), 2.0, 0.0],
                [1.0, 2.0, -1.0],
                [-s, s * ring, 1.0],
            ],
            [0.0, 2.0 * far, loading.moves() * plate * far],
        )
    }

    /// n = 2: a, b, c, d of the ring, c and d of the plate.
    fn solve_second(&self, loading: Loading) -> [f64; 6] {
        let [inner_radial, _, inner_shear] = second_stress(self.inner / self.radius);
        let [radial, _, shear] = second_stress(1.0);
        let s = self.stiffness_ratio();
        let [ring_ur, ring_ut] =
            second_displacement(1.0, self.ring.kolosov(self.plane)).map(|row| row.map(|v| s * v));
        let [plate_ur, plate_ut] = second_displacement(1.0, self.plate.kolosov(self.plane));

        // Ring minus plate = the far field of the plate, for one component on the interface.
        let join = |ring: [f64; 4], plate: [f64; 4]| {
            let [a, b, c, d] = ring;
            let row = [a, b, c, d, -plate[2], -plate[3]];
            (row, plate[0] * self.far_second())
        };
        let join_moves = |ring: [f64; 4], plate: [f64; 4]| {
            let (row, far) = join(ring, plate);
            (row, loading.moves() * far)
        };
        let last = match self.interface {
            Interface::FullSlip => [join(shear, [0.0; 4]), join([0.0; 4], shear)],
            Interface::Bonded => [join(shear, shear), join_moves(ring_ut, plate_ut)],
        };
        let rows = [
            join(inner_radial, [0.0; 4]),
            join(inner_shear, [0.0; 4]),
            join(radial, radial),
            join_moves(ring_ur, plate_ur),
            last[0],
            last[1],
        ];
        solve(rows.map(|(row, _)| row), rows.map(|(_, right)| right))
    }
}

/// The reference state of displacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Loading {
    /// The ring fills the hole, then the plate is compressed: the far field moves the interface, too.
    FromAfar,
    /// The plate is compressed, then the hole is cut and the ring put in: the far field has moved already.
    Excavation,
}

impl Loading {
    /// The part of the far field's displacement that the interface follows.
    fn moves(self) -> f64 {
        match self {
            Self::FromAfar => 1.0,
            Self::Excavation => 0.0,
        }
    }
}

/// The harmonics n = 0 and 2 of one part: stress and displacement at every point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Series {
    /// R, the radius that ρ = r/R counts in.
    pub radius: f64,
    pub material: Material,
    pub plane: Plane,
    /// A and C.
    pub mean: [f64; 2],
    /// a, b, c, d.
    pub second: [f64; 4],
}

impl Series {
    /// Harmonics of σrr, σθθ (cos 2θ) and τrθ (sin 2θ) on the circle of radius r.
    pub fn stress_harmonics(&self, r: f64) -> [Harmonics; 3] {
        let rho = r / self.radius;
        let [radial, hoop, shear] = second_stress(rho).map(|row| product(row, self.second));
        let [log, square] = self.mean;
        let mean = log / (rho * rho);
        [
            Harmonics {
                mean: mean + 2.0 * square,
                second: radial,
            },
            Harmonics {
                mean: -mean + 2.0 * square,
                second: hoop,
            },
            Harmonics {
                mean: 0.0,
                second: shear,
            },
        ]
    }

    /// Harmonics of ur (cos 2θ) and uθ (sin 2θ) on the circle of radius r.
    pub fn displacement_harmonics(&self, r: f64) -> [Harmonics; 2] {
        let rho = r / self.radius;
        let kappa = self.material.kolosov(self.plane);
        let scale = 0.5 * self.radius / self.material.shear();
        let [radial, tangential] =
            second_displacement(rho, kappa).map(|row| scale * product(row, self.second));
        let [log, square] = self.mean;
        [
            Harmonics {
                mean: scale * (-log / rho + (kappa - 1.0) * square * rho),
                second: radial,
            },
            Harmonics {
                mean: 0.0,
                second: tangential,
            },
        ]
    }

    /// Stress in polar components at radius r and angle θ (radians).
    pub fn polar_stress(&self, r: f64, theta: f64) -> PolarStress {
        let [radial, hoop, shear] = self.stress_harmonics(r);
        let (sine, cosine) = (2.0 * theta).sin_cos();
        PolarStress {
            radial: radial.mean + radial.second * cosine,
            hoop: hoop.mean + hoop.second * cosine,
            shear: shear.second * sine,
        }
    }

    /// Stress [σxx, σyy, τxy] at a point.
    pub fn stress(&self, [x, y]: Point<2>) -> [f64; 3] {
        let PolarStress {
            radial,
            hoop,
            shear,
        } = self.polar_stress(x.hypot(y), y.atan2(x));
        let (s, c) = y.atan2(x).sin_cos();
        [
            radial * c * c + hoop * s * s - 2.0 * shear * s * c,
            radial * s * s + hoop * c * c + 2.0 * shear * s * c,
            (radial - hoop) * s * c + shear * (c * c - s * s),
        ]
    }

    /// Displacement [ux, uy] at a point.
    pub fn displacement(&self, [x, y]: Point<2>) -> [f64; 2] {
        let theta = y.atan2(x);
        let [radial, tangential] = self.displacement_harmonics(x.hypot(y));
        let ur = radial.mean + radial.second * (2.0 * theta).cos();
        let ut = tangential.second * (2.0 * theta).sin();
        let (s, c) = theta.sin_cos();
        [ur * c - ut * s, ur * s + ut * c]
    }

    /// ∫σθθ dr and ∫σθθ r dr between two radii, harmonics of cos 2θ, and the sin 2θ amplitude of ∫τrθ dr.
    pub fn sections(&self, inner: f64, outer: f64) -> ([Harmonics; 2], f64) {
        let at = |r: f64| self.antiderivatives(r / self.radius);
        let (from, to) = (at(inner), at(outer));
        let [force, moment] = [0, 1].map(|k| {
            let scale = self.radius.powi(k as i32 + 1);
            Harmonics {
                mean: scale * (to.0[k].mean - from.0[k].mean),
                second: scale * (to.0[k].second - from.0[k].second),
            }
        });
        ([force, moment], self.radius * (to.1 - from.1))
    }

    /// Antiderivatives of σθθ, ρσθθ and τrθ with respect to ρ.
    fn antiderivatives(&self, rho: f64) -> ([Harmonics; 2], f64) {
        let ([log, square], [a, b, c, d]) = (self.mean, self.second);
        let (two, three) = (rho * rho, rho * rho * rho);
        let force = Harmonics {
            mean: log / rho + 2.0 * square * rho,
            second: 2.0 * a * rho + 4.0 * b * three - 2.0 * c / three,
        };
        let moment = Harmonics {
            mean: -log * rho.ln() + square * two,
            second: a * two + 3.0 * b * two * two - 3.0 * c / two,
        };
        let shear = 2.0 * a * rho + 2.0 * b * three + 2.0 * c / three + 2.0 * d / rho;
        ([force, moment], shear)
    }
}

/// σrr, σθθ, τrθ of the harmonic n = 2: coefficients of a, b, c, d at ρ.
fn second_stress(rho: f64) -> [[f64; 4]; 3] {
    let square = rho * rho;
    let fourth = square * square;
    [
        [-2.0, 0.0, -6.0 / fourth, -4.0 / square],
        [2.0, 12.0 * square, 6.0 / fourth, 0.0],
        [2.0, 6.0 * square, -6.0 / fourth, -2.0 / square],
    ]
}

/// 2μ ur/R and 2μ uθ/R of the harmonic n = 2: coefficients of a, b, c, d at ρ.
fn second_displacement(rho: f64, kappa: f64) -> [[f64; 4]; 2] {
    let cube = rho * rho * rho;
    [
        [
            -2.0 * rho,
            (kappa - 3.0) * cube,
            2.0 / cube,
            (kappa + 1.0) / rho,
        ],
        [
            2.0 * rho,
            (kappa + 3.0) * cube,
            2.0 / cube,
            (1.0 - kappa) / rho,
        ],
    ]
}

fn product(row: [f64; 4], coefficients: [f64; 4]) -> f64 {
    (0..4).map(|i| row[i] * coefficients[i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, derivative};
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    const ROCK: Material = Material {
        young: 2000.0,
        poisson: 0.25,
    };

    fn tunnel(ratio: f64, interface: Interface) -> RingInPlate {
        RingInPlate {
            inner: 12.0,
            radius: 15.0,
            ring: Material {
                young: 2.1e6,
                poisson: 0.15,
            },
            plate: ROCK,
            plane: Plane::Strain,
            vertical: 1.0,
            ratio,
            interface,
        }
    }

    /// A row of the catalogue: K, interface, p0, p2, springline, crown, u0, u2, intrados hoop at springline and crown.
    type Row = (f64, Interface, [f64; 4], [f64; 2], [f64; 2]);

    #[test]
    fn every_row_of_the_catalogue_to_its_digits() {
        use Interface::{Bonded, FullSlip};
        let rows: [Row; 6] = [
            (
                1.0 / 3.0,
                FullSlip,
                [0.996749, -0.793434, 0.20332, 1.79018],
                [-3.04760e-5, 6.96812e-4],
                [-45.699, 34.624],
            ),
            (
                1.0 / 3.0,
                Bonded,
                [0.996749, -0.425338, 0.57141, 1.42209],
                [-3.04760e-5, 5.33511e-4],
                [-37.659, 26.584],
            ),
            (
                0.5,
                FullSlip,
                [1.12134, -0.59508, 0.52627, 1.71642],
                [-3.42855e-5, 5.22609e-4],
                [-36.351, 23.891],
            ),
            (
                0.7,
                FullSlip,
                [1.270855, -0.357045, 0.91381, 1.62790],
                [-3.88569e-5, 3.13566e-4],
                [-25.133, 11.012],
            ),
            (
                1.0,
                FullSlip,
                [1.49512, 0.0, 1.49512, 1.49512],
                [-4.57140e-5, 0.0],
                [-8.3062, -8.3062],
            ),
            (
                1.0,
                Bonded,
                [1.49512, 0.0, 1.49512, 1.49512],
                [-4.57140e-5, 0.0],
                [-8.3062, -8.3062],
            ),
        ];
        for (ratio, interface, pressure, displacement, hoop) in rows {
            let exact = tunnel(ratio, interface);
            let p = exact.pressure_harmonics();
            // One unit of the last digit that the catalogue prints.
            close(p.mean, pressure[0], 1e-5);
            close(p.second, pressure[1], 1e-5);
            close(exact.pressure(0.0), pressure[2], 1e-5);
            close(exact.pressure(FRAC_PI_2), pressure[3], 1e-5);
            for part in [Part::Ring, Part::Plate] {
                let [ur, _] = exact.displacement_harmonics(15.0, part);
                close(ur.mean, displacement[0], 1e-10);
                close(ur.second, displacement[1], 1e-9);
            }
            for (theta, value) in [(0.0, hoop[0]), (FRAC_PI_2, hoop[1])] {
                close(
                    exact.polar_stress(12.0, theta, Part::Ring).hoop,
                    value,
                    1e-3,
                );
            }
        }
    }

    #[test]
    fn both_parts_are_in_equilibrium() {
        let exact = tunnel(0.4, Interface::Bonded);
        for (part, [x, y]) in points() {
            let dx = |i: usize| derivative(|s| exact.stress([s, y], part)[i], x, 1e-2);
            let dy = |i: usize| derivative(|s| exact.stress([x, s], part)[i], y, 1e-2);
            close(dx(0) + dy(2), 0.0, 1e-7);
            close(dx(2) + dy(1), 0.0, 1e-7);
        }
    }

    #[test]
    fn displacement_and_stress_obey_hooke() {
        for interface in [Interface::FullSlip, Interface::Bonded] {
            for plane in [Plane::Strain, Plane::Stress] {
                let exact = RingInPlate {
                    plane,
                    ..tunnel(0.4, interface)
                };
                for (part, [x, y]) in points() {
                    let u = |p: Point<2>| exact.displacement(p, part);
                    let dx = |i: usize| derivative(|s| u([s, y])[i], x, 1e-2);
                    let dy = |i: usize| derivative(|s| u([x, s])[i], y, 1e-2);
                    let Material { young, poisson } = exact.material(part);
                    let [xx, yy, xy] = exact.stress([x, y], part);
                    let zz = match plane {
                        Plane::Strain => poisson * (xx + yy),
                        Plane::Stress => 0.0,
                    };
                    let tolerance = 1e-8 / young * ROCK.young;
                    close(dx(0), (xx - poisson * (yy + zz)) / young, tolerance);
                    close(dy(1), (yy - poisson * (xx + zz)) / young, tolerance);
                    let shear = 2.0 * (1.0 + poisson) * xy / young;
                    close(dx(1) + dy(0), shear, tolerance);
                }
            }
        }
    }

    fn points() -> [(Part, Point<2>); 4] {
        [
            (Part::Ring, [12.6, 3.0]),
            (Part::Ring, [-4.0, 13.0]),
            (Part::Plate, [14.0, -9.0]),
            (Part::Plate, [-31.0, 20.0]),
        ]
    }

    #[test]
    fn the_bore_is_free_and_the_interface_transmits_what_it_may() {
        for interface in [Interface::FullSlip, Interface::Bonded] {
            let exact = tunnel(0.4, interface);
            for theta in [0.0, 0.5, 1.1, 2.9] {
                let bore = exact.polar_stress(12.0, theta, Part::Ring);
                close(bore.radial, 0.0, 1e-11);
                close(bore.shear, 0.0, 1e-11);
                let ring = exact.polar_stress(15.0, theta, Part::Ring);
                let plate = exact.polar_stress(15.0, theta, Part::Plate);
                close(ring.radial, plate.radial, 1e-12);
                close(ring.shear, plate.shear, 1e-12);
                close(exact.pressure(theta), -ring.radial, 1e-12);
                if interface == Interface::FullSlip {
                    close(plate.shear, 0.0, 1e-12);
                }
                let point = [15.0 * theta.cos(), 15.0 * theta.sin()];
                let inside = exact.displacement(point, Part::Ring);
                let outside = exact.displacement(point, Part::Plate);
                let jump = [inside[0] - outside[0], inside[1] - outside[1]];
                let normal = jump[0] * theta.cos() + jump[1] * theta.sin();
                close(normal, 0.0, 1e-16);
                if interface == Interface::Bonded {
                    close(jump[0].hypot(jump[1]), 0.0, 1e-16);
                }
            }
        }
    }

    #[test]
    fn far_away_the_plate_knows_no_ring() {
        let exact = tunnel(0.4, Interface::FullSlip);
        let [xx, yy, xy] = exact.stress([1.2e6, 0.9e6], Part::Plate);
        close(xx, -0.4, 1e-9);
        close(yy, -1.0, 1e-9);
        close(xy, 0.0, 1e-9);
    }

    #[test]
    fn a_bonded_ring_of_the_same_material_is_a_smaller_hole() {
        // Kirsch 1898: hoop stress −(3 sv − sh) at the springline and −(3 sh − sv) at the crown of the hole.
        let exact = RingInPlate {
            ring: ROCK,
            ..tunnel(0.25, Interface::Bonded)
        };
        let hoop = |theta: f64| exact.polar_stress(12.0, theta, Part::Ring).hoop;
        close(hoop(0.0), -(3.0 - 0.25), 1e-12);
        close(hoop(FRAC_PI_2), -(3.0 * 0.25 - 1.0), 1e-12);
    }

    #[test]
    fn a_quarter_of_the_plate_is_balanced_by_its_tractions() {
        let exact = tunnel(1.0 / 3.0, Interface::FullSlip);
        let (near, far, n) = (16.0, 45.0, 4000);
        let mut sum = [0.0; 2];
        let mut add = |point: Point<2>, normal: [f64; 2], length: f64| {
            let t = exact.traction(point, normal);
            sum[0] += t[0] * length;
            sum[1] += t[1] * length;
        };
        for k in 0..n {
            let s = (k as f64 + 0.5) / n as f64;
            let r = near + (far - near) * s;
            add([r, 0.0], [0.0, -1.0], (far - near) / n as f64);
            add([0.0, r], [-1.0, 0.0], (far - near) / n as f64);
            let (sine, cosine) = (FRAC_PI_2 * s).sin_cos();
            for (radius, side) in [(near, -1.0), (far, 1.0)] {
                add(
                    [radius * cosine, radius * sine],
                    [side * cosine, side * sine],
                    FRAC_PI_2 * radius / n as f64,
                );
            }
        }
        // Midpoint rule with 4000 points of smooth functions.
        close(sum[0], 0.0, 1e-5);
        close(sum[1], 0.0, 1e-5);
    }

    #[test]
    fn a_soft_ring_takes_no_pressure() {
        let exact = RingInPlate {
            ring: Material {
                young: 2e-6,
                poisson: 0.15,
            },
            ..tunnel(1.0 / 3.0, Interface::FullSlip)
        };
        for theta in [0.0, FRAC_PI_4, FRAC_PI_2] {
            close(exact.pressure(theta), 0.0, 1e-7);
        }
    }
}
