//! Quadrature on reference cells and facets, ∫f ≈ Σ wᵢ f(ξᵢ), exact for polynomials of a given total degree.
//!
//! Simplices use symmetric rules as tables of orbits, above the last table the conical product of Gauss rules;
//! everything else is a tensor product of Gauss rules, exact for that degree in each variable; prisms have the product of
//! triangle and line.
//! Weights sum to the volume of the [`Domain`] of the cell: 1/2 on the triangle, 4 on the square, 2 on the line.
//! Invariants: weights are positive, points lie inside, the order of the points is always the same.
//!
//! Source of the triangle rules: as described in D. A. Dunavant, Int. J. Numer. Methods Eng. 21 (1985) 1129–1148, the
//! digits solved again from the moment equations in 40-digit arithmetic. Of the tetrahedron rules: as described in
//! P. Keast, Comput. Methods Appl. Mech. Eng. 55 (1986) 339–348, and in textbooks, those with positive weights; the digits
//! solved again in the same way.

use crate::mesh::{CellKind, Domain};

/// A point of a quadrature rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates, missing ones zero.
    pub xi: [f64; 3],
    /// Weight; the reference cell's volume is the sum of all.
    pub weight: f64,
}

/// A rule on the reference cell that is exact for polynomials up to a total degree.
pub fn rule(kind: CellKind, degree: usize) -> Vec<QuadraturePoint> {
    let (domain, dimension) = (kind.domain(), kind.dimension());
    let tables: &[Table] = match domain {
        Domain::Line | Domain::Square | Domain::Cube => return product(dimension, degree),
        Domain::Triangle => &TRIANGLE,
        Domain::Tetrahedron => &TETRAHEDRON,
        Domain::Prism => return prism(degree),
    };
    match tables.iter().find(|table| table.degree >= degree) {
        Some(table) => table.points(domain),
        None => conical(dimension, degree),
    }
}

/// Gauss–Legendre rule with n points (at least one) on [−1, 1], exact for degree 2n − 1: (point, weight), ascending.
///
/// Zeros of the Legendre polynomial by Newton's method, symmetric to the last bit.
pub fn gauss(n: usize) -> Vec<(f64, f64)> {
    let n = n.max(1);
    let mut rule = vec![(0.0, 0.0); n];
    for i in 0..n.div_ceil(2) {
        let middle = 2 * i + 1 == n;
        let mut x = match middle {
            true => 0.0,
            false => (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos(),
        };
        // Newton's method converges quadratically from this start: five steps are enough, more change nothing. The middle
        // is a zero already, of an odd polynomial.
        for _ in 0..10 {
            let (value, slope) = legendre(n, x);
            x -= value / slope;
        }
        let (_, slope) = legendre(n, x);
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        rule[i] = (-x, weight);
        rule[n - 1 - i] = (x, weight);
    }
    rule
}

/// Pₙ(x) and Pₙ'(x), n ≥ 1, |x| < 1, by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, value) = (
            value,
            ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k,
        );
    }
    (value, n as f64 * (before - x * value) / (1.0 - x * x))
}

/// Tensor product of Gauss rules on [−1, 1]ᵈ, the first coordinate fastest.
fn product(dimension: usize, degree: usize) -> Vec<QuadraturePoint> {
    let line = gauss(degree / 2 + 1);
    let mut points = vec![QuadraturePoint {
        xi: [0.0; 3],
        weight: 1.0,
    }];
    for d in 0..dimension {
        points = line
            .iter()
            .flat_map(|&(x, weight)| {
                points.iter().map(move |point| {
                    let mut point = *point;
                    point.xi[d] = x;
                    point.weight *= weight;
                    point
                })
            })
            .collect();
    }
    points
}

/// Gauss rules on the cube, mapped onto the simplex: ξ_d = t_d (1 − ξ₁ − … − ξ_{d−1}), t in [0, 1]ᵈ.
fn conical(dimension: usize, degree: usize) -> Vec<QuadraturePoint> {
    // The Jacobian of the map raises the degree by at most dimension − 1.
    let mut points = product(dimension, degree + dimension - 1);
    for point in &mut points {
        let mut rest = 1.0;
        for x in &mut point.xi[..dimension] {
            point.weight *= 0.5 * rest;
            *x = 0.5 * (1.0 + *x) * rest;
            rest -= *x;
        }
    }
    points
}

/// The rule of the triangle times that of the line, the triangle fastest.
fn prism(degree: usize) -> Vec<QuadraturePoint> {
    let triangle = rule(CellKind::Tri3, degree);
    let heights = gauss(degree / 2 + 1).into_iter();
    let layer = |(z, weight): (f64, f64)| {
        let at = move |point: &QuadraturePoint| QuadraturePoint {
            xi: [point.xi[0], point.xi[1], z],
            weight: weight * point.weight,
        };
        triangle.iter().map(at).collect::<Vec<_>>()
    };
    heights.flat_map(layer).collect()
}

/// A symmetric rule on a simplex.
struct Table {
    degree: usize,
    /// Barycentric coordinates of one point of each orbit and the weight of each of its points, over the volume.
    orbits: &'static [(&'static [f64], f64)],
}

impl Table {
    fn points(&self, domain: Domain) -> Vec<QuadraturePoint> {
        let (dimension, volume) = (domain.dimension(), domain.volume());
        self.orbits
            .iter()
            .flat_map(|&(barycentric, weight)| {
                permutations(barycentric).into_iter().map(move |place| {
                    let mut xi = [0.0; 3];
                    xi[..dimension].copy_from_slice(&place[1..]);
                    QuadraturePoint {
                        xi,
                        weight: weight * volume,
                    }
                })
            })
            .collect()
    }
}

/// The distinct orders of some numbers, in lexicographic order.
fn permutations(numbers: &[f64]) -> Vec<Vec<f64>> {
    let mut current = numbers.to_vec();
    current.sort_by(f64::total_cmp);
    let mut all = vec![current.clone()];
    while let Some(i) = current.windows(2).rposition(|pair| pair[0] < pair[1]) {
        let pivot = current[i];
        if let Some(j) = current.iter().rposition(|&x| x > pivot) {
            current.swap(i, j);
        }
        current[i + 1..].reverse();
        all.push(current.clone());
    }
    all
}

const THIRD: f64 = 1.0 / 3.0;
const SIXTH: f64 = 1.0 / 6.0;
const A4: f64 = 0.445_948_490_915_964_9;
const B4: f64 = 0.091_576_213_509_770_74;
const A5: f64 = 0.470_142_064_105_115_1;
const B5: f64 = 0.101_286_507_323_456_34;
const A6: f64 = 0.249_286_745_170_910_43;
const B6: f64 = 0.063_089_014_491_502_23;
const C6: f64 = 0.053_145_049_844_816_95;
const D6: f64 = 0.310_352_451_033_784_4;

static TRIANGLE: [Table; 5] = [
    Table {
        degree: 1,
        orbits: &[(&[THIRD, THIRD, THIRD], 1.0)],
    },
    Table {
        degree: 2,
        orbits: &[(&[SIXTH, SIXTH, 4.0 * SIXTH], THIRD)],
    },
    Table {
        degree: 4,
        orbits: &[
            (&[A4, A4, 1.0 - 2.0 * A4], 0.223_381_589_678_011_47),
            (&[B4, B4, 1.0 - 2.0 * B4], 0.109_951_743_655_321_87),
        ],
    },
    Table {
        degree: 5,
        orbits: &[
            (&[THIRD, THIRD, THIRD], 0.225),
            (&[A5, A5, 1.0 - 2.0 * A5], 0.132_394_152_788_506_2),
            (&[B5, B5, 1.0 - 2.0 * B5], 0.125_939_180_544_827_15),
        ],
    },
    Table {
        degree: 6,
        orbits: &[
            (&[A6, A6, 1.0 - 2.0 * A6], 0.116_786_275_726_379_37),
            (&[B6, B6, 1.0 - 2.0 * B6], 0.050_844_906_370_206_82),
            (&[C6, D6, 1.0 - C6 - D6], 0.082_851_075_618_373_57),
        ],
    },
];

/// (5 − √5)/20, from the second moments of the tetrahedron.
const A2: f64 = 0.138_196_601_125_010_5;

const A3: f64 = 0.328_054_696_711_426_7;
const B3: f64 = 0.106_952_273_932_930_68;
const A5_SPACE: f64 = 0.310_885_919_263_300_6;
const B5_SPACE: f64 = 0.092_735_250_310_891_23;
const C5_SPACE: f64 = 0.045_503_704_125_649_65;
const A6_SPACE: f64 = 0.214_602_871_259_152_03;
const B6_SPACE: f64 = 0.040_673_958_534_611_35;
const C6_SPACE: f64 = 0.322_337_890_142_275_5;
const D6_SPACE: f64 = 0.063_661_001_875_017_53;
const E6_SPACE: f64 = 0.603_005_664_791_649_1;

static TETRAHEDRON: [Table; 5] = [
    Table {
        degree: 1,
        orbits: &[(&[0.25, 0.25, 0.25, 0.25], 1.0)],
    },
    Table {
        degree: 2,
        orbits: &[(&[A2, A2, A2, 1.0 - 3.0 * A2], 0.25)],
    },
    Table {
        degree: 3,
        orbits: &[
            (&[A3, A3, A3, 1.0 - 3.0 * A3], 0.138_527_966_511_862_15),
            (&[B3, B3, B3, 1.0 - 3.0 * B3], 0.111_472_033_488_137_85),
        ],
    },
    Table {
        degree: 5,
        orbits: &[
            (
                &[A5_SPACE, A5_SPACE, A5_SPACE, 1.0 - 3.0 * A5_SPACE],
                0.112_687_925_718_015_85,
            ),
            (
                &[B5_SPACE, B5_SPACE, B5_SPACE, 1.0 - 3.0 * B5_SPACE],
                0.073_493_043_116_361_95,
            ),
            (
                &[C5_SPACE, C5_SPACE, 0.5 - C5_SPACE, 0.5 - C5_SPACE],
                0.042_546_020_777_081_466,
            ),
        ],
    },
    Table {
        degree: 6,
        orbits: &[
            (
                &[A6_SPACE, A6_SPACE, A6_SPACE, 1.0 - 3.0 * A6_SPACE],
                0.039_922_750_258_167_49,
            ),
            (
                &[B6_SPACE, B6_SPACE, B6_SPACE, 1.0 - 3.0 * B6_SPACE],
                0.010_077_211_055_320_643,
            ),
            (
                &[C6_SPACE, C6_SPACE, C6_SPACE, 1.0 - 3.0 * C6_SPACE],
                0.055_357_181_543_654_72,
            ),
            (
                &[
                    D6_SPACE,
                    D6_SPACE,
                    E6_SPACE,
                    1.0 - 2.0 * D6_SPACE - E6_SPACE,
                ],
                0.048_214_285_714_285_716,
            ),
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use quadraturerules::{Domain as Theirs, QuadratureRule, single_integral_quadrature};

    fn factorial(n: usize) -> f64 {
        (1..=n).map(|k| k as f64).product()
    }

    /// ∫xⁱ over [−1, 1].
    fn line_moment(i: usize) -> f64 {
        if i % 2 == 1 {
            0.0
        } else {
            2.0 / (i as f64 + 1.0)
        }
    }

    fn moment(rule: &[QuadraturePoint], powers: &[usize]) -> f64 {
        let value = |p: &QuadraturePoint| -> f64 {
            let factors = powers.iter().zip(p.xi).map(|(&i, x)| x.powi(i as i32));
            factors.product()
        };
        rule.iter().map(|p| p.weight * value(p)).sum()
    }

    /// ∫ξⁱηʲζᵏ over a reference cell.
    fn exact(domain: Domain, powers: &[usize]) -> f64 {
        match domain {
            Domain::Triangle | Domain::Tetrahedron => {
                let total = powers.iter().sum::<usize>() + domain.dimension();
                powers.iter().map(|&i| factorial(i)).product::<f64>() / factorial(total)
            }
            Domain::Prism => exact(Domain::Triangle, &powers[..2]) * line_moment(powers[2]),
            _ => powers.iter().map(|&i| line_moment(i)).product(),
        }
    }

    /// Exponents of all monomials of some variables up to a degree.
    fn monomials(dimension: usize, degree: usize) -> Vec<Vec<usize>> {
        let mut all = vec![Vec::new()];
        for _ in 0..dimension {
            let longer = |powers: &Vec<usize>| {
                let rest = degree - powers.iter().sum::<usize>();
                let next = (0..=rest).map(|i| [powers.as_slice(), &[i]].concat());
                next.collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).collect();
        }
        all
    }

    #[test]
    fn rules_integrate_monomials_up_to_their_degree() {
        for kind in CellKind::ALL {
            for degree in 0..=[12, 12, 8][kind.dimension() - 1] {
                let rule = rule(kind, degree);
                for powers in monomials(kind.dimension(), degree) {
                    let error = moment(&rule, &powers) - exact(kind.domain(), &powers);
                    // Sums of some dozens of numbers of size one.
                    let size = kind.domain().volume().max(0.25);
                    assert!(
                        error.abs() < 4e-15 * size,
                        "{kind:?} {degree}: {powers:?} {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn no_table_promises_less_than_it_holds() {
        // A rule fails one degree further: its degree is neither under- nor overstated.
        let tables = [
            (Domain::Triangle, &TRIANGLE[..]),
            (Domain::Tetrahedron, &TETRAHEDRON[..]),
        ];
        for (domain, tables) in tables {
            for table in tables {
                let points = table.points(domain);
                let next = monomials(domain.dimension(), table.degree + 1);
                let errors = next
                    .iter()
                    .map(|p| (moment(&points, p) - exact(domain, p)).abs());
                assert!(errors.fold(0.0, f64::max) > 1e-8, "degree {}", table.degree);
            }
        }
    }

    #[test]
    fn rules_have_the_known_number_of_points_inside_with_positive_weights() {
        let counts = [1, 1, 3, 6, 6, 7, 12];
        let in_space = [1, 1, 4, 8, 14, 14, 24];
        for (degree, (plane, space)) in counts.into_iter().zip(in_space).enumerate() {
            assert_eq!(rule(CellKind::Tri3, degree).len(), plane);
            assert_eq!(rule(CellKind::Tet4, degree).len(), space);
        }
        for degree in 0..=9 {
            for kind in CellKind::ALL {
                for point in rule(kind, degree) {
                    assert!(point.weight > 0.0 && kind.domain().outside(&point.xi) < 0.0);
                    assert!(point.xi[kind.dimension()..].iter().all(|&x| x == 0.0));
                }
            }
            let n = degree / 2 + 1;
            assert_eq!(rule(CellKind::Quad4, degree).len(), n * n);
            assert_eq!(rule(CellKind::Line3, degree).len(), n);
            let triangle = rule(CellKind::Tri6, degree).len();
            assert_eq!(rule(CellKind::Prism15, degree).len(), n * triangle);
        }
    }

    #[test]
    fn gauss_rules_agree_with_the_encyclopedia() {
        for n in 1..=8 {
            let (points, weights) =
                single_integral_quadrature(QuadratureRule::GaussLegendre, Theirs::Interval, n)
                    .unwrap();
            // Its points are barycentric coordinates on [0, 1].
            let mut expected: Vec<(f64, f64)> = points
                .chunks_exact(2)
                .zip(weights)
                .map(|(p, w)| (p[1] - p[0], 2.0 * w))
                .collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            let computed = gauss(n);
            assert_eq!(computed.len(), expected.len());
            for (a, b) in computed.iter().zip(&expected) {
                // A few units in the last place on either side.
                assert!((a.0 - b.0).abs() < 2e-15, "{n}: {a:?} {b:?}");
                assert!((a.1 - b.1).abs() < 4e-15, "{n}: {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn triangle_rules_agree_with_the_encyclopedia() {
        // Degrees 1, 2, 4 have one symmetric rule with that few points: the same points in some order.
        for degree in [1, 2, 4] {
            let (points, weights) =
                single_integral_quadrature(QuadratureRule::XiaoGimbutas, Theirs::Triangle, degree)
                    .unwrap();
            let computed = rule(CellKind::Tri3, degree);
            assert_eq!(computed.len(), weights.len());
            for (p, w) in points.chunks_exact(3).zip(&weights) {
                let same = computed.iter().filter(|q| {
                    (q.xi[0] - p[1]).abs() < 1e-14
                        && (q.xi[1] - p[2]).abs() < 1e-14
                        && (2.0 * q.weight - w).abs() < 1e-14
                });
                assert_eq!(same.count(), 1, "{degree}: {p:?}");
            }
        }
    }

    #[test]
    fn tetrahedron_rules_converge_to_the_encyclopedias_integral_of_an_analytic_function() {
        let f = |x: f64, y: f64, z: f64| (x - 2.0 * y + 0.7 * z).exp();
        let family = QuadratureRule::XiaoGimbutas;
        let (points, weights) =
            single_integral_quadrature(family, Theirs::Tetrahedron, 15).unwrap();
        let sixth = weights.iter().map(|w| w / 6.0);
        let values = points.chunks_exact(4).map(|p| f(p[1], p[2], p[3]));
        let expected: f64 = values.zip(sixth).map(|(f, w)| w * f).sum();
        let error = |degree: usize| -> f64 {
            let points = rule(CellKind::Tet10, degree);
            let sum: f64 = points
                .iter()
                .map(|p| p.weight * f(p.xi[0], p.xi[1], p.xi[2]))
                .sum();
            (sum - expected).abs()
        };
        let errors = [1, 2, 3, 5, 6, 9].map(error);
        assert!(errors.windows(2).all(|e| e[1] < e[0]), "{errors:?}");
        assert!(error(16) < 1e-15, "{errors:?}");
    }

    #[test]
    fn triangle_rules_converge_to_the_encyclopedias_integral_of_an_analytic_function() {
        let f = |x: f64, y: f64| (x - 2.0 * y).exp();
        let (points, weights) =
            single_integral_quadrature(QuadratureRule::XiaoGimbutas, Theirs::Triangle, 25).unwrap();
        let expected: f64 = points
            .chunks_exact(3)
            .zip(weights)
            .map(|(p, w)| 0.5 * w * f(p[1], p[2]))
            .sum();
        let error = |degree: usize| -> f64 {
            let sum: f64 = rule(CellKind::Tri3, degree)
                .iter()
                .map(|p| p.weight * f(p.xi[0], p.xi[1]))
                .sum();
            (sum - expected).abs()
        };
        assert!(error(2) > error(4) && error(4) > error(5) && error(5) > error(6));
        assert!(error(16) < 1e-15);
    }
}
