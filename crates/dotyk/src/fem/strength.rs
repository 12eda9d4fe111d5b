//! Utilisation of a material by a stress, 1 at failure, by the four usual criteria.
//!
//! With the principal stresses σ₁ ≥ σ₂ ≥ σ₃ counted positive in compression (the tensor itself has tension positive) a criterion
//! consists of one or two demands with their capacities, and the utilisation is the largest demand / capacity:
//!
//! ```text
//!   von Mises         σᵥ to the yield stress
//!   principal         σ₁ to the compressive strength,        −σ₃ to the tensile strength
//!   Mohr–Coulomb      σ₁ − σ₃ to (σ₃ + c cot φ) 2 sin φ/(1 − sin φ),   −σ₃ to the tensile strength, at most c cot φ
//!   Hoek–Brown        σ₁ − σ₃ to σ_ci (m_b σ₃/σ_ci + s)^a,   −σ₃ to s σ_ci/m_b
//! ```
//!
//! The capacity of σ₁ − σ₃ is σ₁f(σ₃) − σ₃, the diameter of the circle of Mohr that fails with the same σ₃. It is negative beyond
//! the apex of the criterion: there the utilisation is infinite. The intermediate principal stress counts for von Mises alone;
//! in plane strain any of the three may be the one across the plane.
//! It judges an elastic stress, without yielding.
//!
//! Source: E. Hoek, C. Carranza-Torres, B. Corkum, Hoek–Brown failure criterion, 2002 edition, Proc. NARMS-TAC (2002), as described
//! in textbooks of rock mechanics; J. C. Jaeger, N. G. W. Cook, R. W. Zimmerman, Fundamentals of Rock Mechanics, for Coulomb's.

use crate::fem::error::FemError;
use crate::fem::stress::{principal, von_mises};

/// The strength of a material. Strengths are stresses, all of them counted positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strength {
    /// Von Mises.
    VonMises {
        /// Yield stress, > 0.
        yield_stress: f64,
    },
    /// Largest and smallest principal stress, each by itself.
    Principal {
        /// Tensile strength, ≥ 0.
        tension: f64,
        /// Compressive strength, > 0.
        compression: f64,
    },
    /// Mohr–Coulomb, cut off in tension.
    MohrCoulomb {
        /// φ in degrees, in [0, 90).
        friction_angle: f64,
        /// c, ≥ 0; not zero together with φ.
        cohesion: f64,
        /// Tensile strength, in [0, c cot φ]; `None`: the apex, c cot φ.
        tension: Option<f64>,
    },
    /// Hoek–Brown, generalised.
    HoekBrown {
        /// Uniaxial compressive strength of the intact rock, > 0.
        sci: f64,
        /// m_b of the rock mass, > 0.
        mb: f64,
        /// s, in [0, 1].
        s: f64,
        /// a, in (0, 1].
        a: f64,
    },
}

/// Relative tolerance of a tensile strength above the apex: that of numbers typed with ten digits.
const TYPED: f64 = 1e-9;

impl Strength {
    /// Utilisation of a stress (xx yy zz xy yz xz, tension positive): ≥ 0, 1 at failure, infinite beyond the apex, 0 without stress.
    pub fn utilisation(&self, stress: [f64; 6]) -> f64 {
        let ratios = self.demands(stress).map(|[demand, capacity]| {
            if capacity < 0.0 {
                f64::INFINITY
            } else if demand <= 0.0 {
                0.0
            } else {
                demand / capacity
            }
        });
        ratios[0].max(ratios[1])
    }

    /// Excess of the stress over the strength, in the unit of stress: with the sign of utilisation − 1, and continuous where that
    /// is not.
    pub fn excess(&self, stress: [f64; 6]) -> f64 {
        let [first, second] = self
            .demands(stress)
            .map(|[demand, capacity]| demand - capacity);
        first.max(second)
    }

    /// Each [demand, capacity].
    fn demands(&self, stress: [f64; 6]) -> [[f64; 2]; 2] {
        // largest first, where tension is positive
        let [most, _, least] = principal(stress);
        let [major, minor] = [-least, -most];
        match *self {
            Self::VonMises { yield_stress } => [[von_mises(stress), yield_stress]; 2],
            Self::Principal {
                tension,
                compression,
            } => [[major, compression], [-minor, tension]],
            Self::MohrCoulomb {
                friction_angle,
                cohesion,
                tension,
            } => {
                let apex = apex(friction_angle, cohesion);
                let sine = friction_angle.to_radians().sin();
                let capacity = match apex.is_finite() {
                    true => (minor + apex) * 2.0 * sine / (1.0 - sine),
                    false => 2.0 * cohesion,
                };
                let tension = tension.map_or(apex, |tension| tension.min(apex));
                [[major - minor, capacity], [-minor, tension]]
            }
            Self::HoekBrown { sci, mb, s, a } => {
                let apex = s * sci / mb;
                let base = (minor + apex) * mb / sci;
                let capacity = sci * base.abs().powf(a).copysign(base);
                [[major - minor, capacity], [-minor, apex]]
            }
        }
    }

    /// Checks that its constants are in their ranges.
    ///
    /// Errors: [`FemError::Material`] with the key of the case file that is out of range.
    pub fn check(&self) -> Result<(), FemError> {
        let out = |name: &'static str, value: f64, range: &'static str| {
            Err(FemError::Material { name, value, range })
        };
        // false for NaN
        let positive = |name: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => out(name, value, "it must be positive"),
        };
        let not_negative = |name: &'static str, value: f64| match value >= 0.0 && value.is_finite()
        {
            true => Ok(()),
            false => out(name, value, "it must not be negative"),
        };
        match *self {
            Self::VonMises { yield_stress } => positive("yield", yield_stress),
            Self::Principal {
                tension,
                compression,
            } => {
                not_negative("tension", tension)?;
                positive("compression", compression)
            }
            Self::MohrCoulomb {
                friction_angle,
                cohesion,
                tension,
            } => {
                if !(0.0..90.0).contains(&friction_angle) {
                    let range = "it must lie in [0, 90) degrees";
                    return out("friction_angle", friction_angle, range);
                }
                not_negative("cohesion", cohesion)?;
                if friction_angle == 0.0 && cohesion == 0.0 {
                    let range = "without friction it must be positive: else nothing is borne";
                    return out("cohesion", cohesion, range);
                }
                let Some(tension) = tension else {
                    return Ok(());
                };
                not_negative("tension", tension)?;
                match tension <= (1.0 + TYPED) * apex(friction_angle, cohesion) {
                    true => Ok(()),
                    false => out(
                        "tension",
                        tension,
                        "it must not exceed cohesion * cot(friction_angle), the apex, which is the default",
                    ),
                }
            }
            Self::HoekBrown { sci, mb, s, a } => {
                positive("sci", sci)?;
                positive("mb", mb)?;
                if !(0.0..=1.0).contains(&s) {
                    return out("s", s, "it must lie in [0, 1]; intact rock has 1");
                }
                match a > 0.0 && a <= 1.0 {
                    true => Ok(()),
                    false => out("a", a, "it must lie in (0, 1]; rock has 0.5 to 0.67"),
                }
            }
        }
    }
}

/// c cot φ, the tension at which the line of Coulomb ends; infinite without friction.
fn apex(friction_angle: f64, cohesion: f64) -> f64 {
    match friction_angle == 0.0 {
        true => f64::INFINITY,
        false => cohesion / friction_angle.to_radians().tan(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use proptest::prelude::*;

    /// R diag(−values) Rᵀ, compression of the values positive: a stress tensor with axes from a quaternion.
    fn turned(compressions: [f64; 3], quaternion: [f64; 4]) -> [f64; 6] {
        let length = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
        let [w, x, y, z] = quaternion.map(|c| c / length);
        let axes: [Point<3>; 3] = [
            [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y + w * z),
                2.0 * (x * z - w * y),
            ],
            [
                2.0 * (x * y - w * z),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z + w * x),
            ],
            [
                2.0 * (x * z + w * y),
                2.0 * (y * z - w * x),
                1.0 - 2.0 * (x * x + y * y),
            ],
        ];
        [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]].map(|[i, j]| {
            (0..3)
                .map(|k| -compressions[k] * axes[k][i] * axes[k][j])
                .sum()
        })
    }

    /// Compressions along the axes x, y, z.
    fn along_axes(compressions: [f64; 3]) -> [f64; 6] {
        let [x, y, z] = compressions.map(|c| -c);
        [x, y, z, 0.0, 0.0, 0.0]
    }

    /// Where a function that is negative at 0 and positive at `high` changes its sign.
    fn root(high: f64, of: impl Fn(f64) -> f64) -> f64 {
        let (mut low, mut high) = (0.0, high);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            match of(middle) < 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }

    /// Diameter of the circle of Mohr that ends at `minor` and touches the line |τ| = c + σ tan φ: by bisection on the distance of
    /// the line from its centre, without a formula of the criterion in principal stresses.
    fn touching(minor: f64, friction_angle: f64, cohesion: f64) -> f64 {
        let slope = friction_angle.to_radians().tan();
        let scale = 1e6 * (minor.abs() + cohesion + 1.0);
        root(scale, |diameter| {
            let centre = minor + 0.5 * diameter;
            let distance = (cohesion + centre * slope) / (1.0 + slope * slope).sqrt();
            0.5 * diameter - distance
        })
    }

    /// Diameter of the circle that the curve of Hoek and Brown allows, from its logarithmic form by bisection.
    fn curve(minor: f64, [sci, mb, s, a]: [f64; 4]) -> f64 {
        root(1e6 * (sci + minor.abs()), |diameter| {
            (diameter / sci).ln() / a - (mb * minor / sci + s).ln()
        })
    }

    const COULOMB: Strength = Strength::MohrCoulomb {
        friction_angle: 30.0,
        cohesion: 2.0,
        tension: None,
    };
    const HOEK: Strength = Strength::HoekBrown {
        sci: 50.0,
        mb: 2.5,
        s: 0.004,
        a: 0.5,
    };

    fn close(found: f64, expected: f64) {
        // twelve digits, the accuracy of bisection and principal stresses
        let off = (found - expected).abs();
        assert!(off <= 1e-12 * expected.abs().max(1.0), "{found} {expected}");
    }

    #[test]
    fn triaxial_states_by_hand() {
        // φ = 30°: σ₁f = 3 σ₃ + 2 c √3; with σ₃ = 1, c = 2: 9.92820323…; σ₁ = 5 has (5 − 1)/(8.928…)
        let capacity = 2.0 + 4.0 * 3f64.sqrt();
        close(
            COULOMB.utilisation(along_axes([1.0, 5.0, 2.0])),
            4.0 / capacity,
        );
        // uniaxial compression 2 c cos φ/(1 − sin φ) fails
        close(
            COULOMB.utilisation(along_axes([0.0, 4.0 * 3f64.sqrt(), 0.0])),
            1.0,
        );
        // uniaxial tension 2 c cos φ/(1 + sin φ) fails by the circle, before its tension reaches c cot φ
        let tension = 4.0 / 3f64.sqrt();
        close(COULOMB.utilisation(along_axes([-tension, 0.0, 0.0])), 1.0);
        // Hoek–Brown, uniaxial: σ_ci s^a = 50 · 0.0632…
        close(
            HOEK.utilisation(along_axes([0.0, 50.0 * 0.004f64.sqrt(), 0.0])),
            1.0,
        );
        // σ₃ = 2: 50 √(0.1 + 0.004) = 16.124…
        close(
            HOEK.utilisation(along_axes([10.0, 2.0, 3.0])),
            8.0 / (50.0 * 0.104f64.sqrt()),
        );
        let steel = Strength::VonMises {
            yield_stress: 235.0,
        };
        close(
            steel.utilisation([0.0, 0.0, 0.0, 235.0 / 3f64.sqrt(), 0.0, 0.0]),
            1.0,
        );
        close(steel.utilisation(along_axes([-117.5, 0.0, 0.0])), 0.5);
        let concrete = Strength::Principal {
            tension: 2.0,
            compression: 30.0,
        };
        close(concrete.utilisation(along_axes([15.0, -0.5, 0.0])), 0.5);
        close(concrete.utilisation(along_axes([15.0, -1.5, 0.0])), 0.75);
        close(concrete.utilisation(along_axes([30.0, 20.0, 10.0])), 1.0);
    }

    #[test]
    fn equal_principal_stresses_the_apex_and_no_stress() {
        let all = |c: f64| along_axes([c; 3]);
        for strength in [COULOMB, HOEK] {
            let apex = match strength {
                Strength::HoekBrown { sci, mb, s, .. } => s * sci / mb,
                _ => 2.0 / 30f64.to_radians().tan(),
            };
            assert_eq!(strength.utilisation([0.0; 6]), 0.0);
            assert_eq!(strength.utilisation(all(1e3)), 0.0);
            close(strength.utilisation(all(-0.5 * apex)), 0.5);
            assert_eq!(strength.utilisation(all(-apex)), 1.0);
            // beyond the apex, also where σ₁ = σ₃
            assert_eq!(strength.utilisation(all(-1.001 * apex)), f64::INFINITY);
            let beyond = along_axes([-1.001 * apex, 5.0 * apex, 0.0]);
            assert_eq!(strength.utilisation(beyond), f64::INFINITY);
            assert!(strength.excess(beyond) > 0.0);
        }
        // no cohesion: no stress is borne without confinement, but a hydrostatic pressure is
        let sand = Strength::MohrCoulomb {
            friction_angle: 30.0,
            cohesion: 0.0,
            tension: None,
        };
        assert_eq!(sand.utilisation([0.0; 6]), 0.0);
        assert_eq!(sand.utilisation(all(1.0)), 0.0);
        assert_eq!(sand.utilisation(along_axes([1.0, 0.0, 0.0])), f64::INFINITY);
        close(sand.utilisation(along_axes([3.0, 1.0, 2.0])), 1.0);
        // a cut-off lies before the apex: beyond it the utilisation is finite
        let cut = Strength::MohrCoulomb {
            friction_angle: 30.0,
            cohesion: 2.0,
            tension: Some(0.5),
        };
        close(cut.utilisation(all(-1.0)), 2.0);
        // no friction: Tresca, tension alone is not a failure
        let tresca = Strength::MohrCoulomb {
            friction_angle: 0.0,
            cohesion: 2.0,
            tension: None,
        };
        assert_eq!(tresca.utilisation(all(-1e3)), 0.0);
        close(tresca.utilisation(along_axes([-1.0, 2.0, 0.0])), 0.75);
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let coulomb =
            |friction_angle: f64, cohesion: f64, tension: Option<f64>| Strength::MohrCoulomb {
                friction_angle,
                cohesion,
                tension,
            };
        let hoek = |sci, mb, s, a| Strength::HoekBrown { sci, mb, s, a };
        let bad = [
            (Strength::VonMises { yield_stress: 0.0 }, "yield"),
            (
                Strength::VonMises {
                    yield_stress: f64::NAN,
                },
                "yield",
            ),
            (
                Strength::Principal {
                    tension: -1.0,
                    compression: 1.0,
                },
                "tension",
            ),
            (
                Strength::Principal {
                    tension: 1.0,
                    compression: 0.0,
                },
                "compression",
            ),
            (coulomb(90.0, 1.0, None), "friction_angle"),
            (coulomb(-1.0, 1.0, None), "friction_angle"),
            (coulomb(30.0, -1.0, None), "cohesion"),
            (coulomb(0.0, 0.0, None), "cohesion"),
            (coulomb(45.0, 1.0, Some(1.001)), "tension"),
            (coulomb(45.0, 1.0, Some(-0.1)), "tension"),
            (hoek(0.0, 1.0, 1.0, 0.5), "sci"),
            (hoek(1.0, 0.0, 1.0, 0.5), "mb"),
            (hoek(1.0, 1.0, 1.1, 0.5), "s"),
            (hoek(1.0, 1.0, 1.0, 0.0), "a"),
            (hoek(1.0, 1.0, 1.0, 1.1), "a"),
        ];
        for (strength, key) in bad {
            let Err(FemError::Material { name, .. }) = strength.check() else {
                panic!("{strength:?}");
            };
            assert_eq!(name, key);
        }
        for good in [
            COULOMB,
            HOEK,
            coulomb(45.0, 1.0, Some(1.0)),
            coulomb(0.0, 1.0, Some(7.0)),
            coulomb(30.0, 0.0, None),
        ] {
            assert!(good.check().is_ok(), "{good:?}");
        }
    }

    proptest! {
        #[test]
        fn circles_of_mohr_touch_the_line_at_utilisation_one(
            (angle, cohesion) in (1.0..60.0f64, 0.1..10.0f64),
            // in parts of the tension of the apex, beyond which there is no circle
            minor in -0.9..20.0f64,
            (share, between) in (0.0..1.5f64, 0.0..1.0f64),
            quaternion in prop::array::uniform4(0.1..1.0f64),
        ) {
            let minor = minor * cohesion / angle.to_radians().tan();
            let full = touching(minor, angle, cohesion);
            let strength = Strength::MohrCoulomb {
                friction_angle: angle,
                cohesion,
                tension: None,
            };
            let state = |share: f64| {
                let major = minor + share * full;
                let middle = minor + between * share * full;
                turned([minor, middle, major], quaternion)
            };
            // the eigenvalues are known to rounding of the largest stress, here beside the diameter of the circle
            let digits = 1e-13 * (1.0 + (minor.abs() + share * full) / full);
            let tension = -minor * angle.to_radians().tan() / cohesion;
            let expected = share.max(tension);
            let found = strength.utilisation(state(share));
            prop_assert!((found - expected).abs() < 50.0 * digits, "{} {}", found, expected);
            prop_assert!((strength.utilisation(state(1.0)) - 1.0).abs() < 50.0 * digits);
            prop_assert!(strength.excess(state(1.01)) > 0.0 && strength.excess(state(0.99)) < 0.0);
        }

        #[test]
        fn the_curve_of_hoek_and_brown_is_utilisation_one(
            (sci, mb, s, a) in (1.0..200.0f64, 0.1..20.0f64, 0.0001..1.0f64, 0.5..0.67f64),
            minor in -0.9..3.0f64,
            (share, between) in (0.0..1.5f64, 0.0..1.0f64),
            quaternion in prop::array::uniform4(0.1..1.0f64),
        ) {
            // in parts of the apex where it is tension, of the intact strength where it is compression
            let apex = s * sci / mb;
            let minor = minor * if minor < 0.0 { apex } else { sci };
            let full = curve(minor, [sci, mb, s, a]);
            let strength = Strength::HoekBrown { sci, mb, s, a };
            let state = |share: f64| {
                let major = minor + share * full;
                let middle = minor + between * share * full;
                turned([minor, middle, major], quaternion)
            };
            let expected = share.max(-minor / apex);
            let found = strength.utilisation(state(share));
            // rounding of the largest stress, by the slope of the curve there
            let slope = mb * a * (mb * minor / sci + s).powf(a - 1.0);
            let digits = 1e-13 * (minor.abs() + full) * (1.0 / full + slope / full + 1.0 / apex);
            prop_assert!((found - expected).abs() < 20.0 * (1e-13 + digits), "{} {}", found, expected);
        }

        #[test]
        fn utilisation_does_not_depend_on_the_axes(
            compressions in prop::array::uniform3(-1.0..10.0f64),
            [one, other] in prop::array::uniform2(prop::array::uniform4(0.1..1.0f64)),
        ) {
            for strength in [
                COULOMB,
                HOEK,
                Strength::VonMises { yield_stress: 3.0 },
                Strength::Principal { tension: 1.0, compression: 8.0 },
            ] {
                let [a, b] = [one, other].map(|q| strength.utilisation(turned(compressions, q)));
                let known = strength.utilisation(along_axes(compressions));
                // near the apex rounding of σ₃ has a large effect
                let digits = 1e-12 * known.max(1.0) * known.max(1.0);
                prop_assert!(a == b || ((a - known).abs() < digits && (b - known).abs() < digits), "{} {} {}", a, b, known);
            }
        }

        #[test]
        fn von_mises_is_that_of_the_deviator(
            compressions in prop::array::uniform3(-5.0..5.0f64),
            quaternion in prop::array::uniform4(0.1..1.0f64),
        ) {
            // √(3/2 s : s)
            let mean = compressions.iter().sum::<f64>() / 3.0;
            let deviator: f64 = compressions.iter().map(|c| (c - mean).powi(2)).sum();
            let strength = Strength::VonMises { yield_stress: 2.5 };
            let found = strength.utilisation(turned(compressions, quaternion));
            prop_assert!((found - (1.5 * deviator).sqrt() / 2.5).abs() < 1e-12);
        }
    }
}
