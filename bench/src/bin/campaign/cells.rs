//! Reference cells, written independently of the program: shape functions and Gauss rules of the five cells of the plane.
//!
//! The reference triangle has the corners (0,0) (1,0) (0,1), the reference square is [−1,1]², the line [−1,1].
//! Corners come first, then the middles of the edges 01 12 20 (01 12 23 30), then the centre. A facet lists its two
//! ends with the cell on the left, then its middle node.
//! The numbers of Gauss points are those of a fully integrated displacement cell (one point and three by radius for
//! tri3, six for tri6, 2×2 for quad4, 3×3 for quad8 and quad9): on curved cells another rule would be another cell.

use crate::plane::Vector;
use crate::raw::Cell;

/// Kinds of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Tri3,
    Tri6,
    Quad4,
    Quad8,
    Quad9,
}

impl Cell for Kind {
    const ALL: &'static [Self] = &[
        Self::Tri3,
        Self::Tri6,
        Self::Quad4,
        Self::Quad8,
        Self::Quad9,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Tri3 => "tri3",
            Self::Tri6 => "tri6",
            Self::Quad4 => "quad4",
            Self::Quad8 => "quad8",
            Self::Quad9 => "quad9",
        }
    }

    /// Nodes of a facet: two ends, and the middle of a quadratic one.
    fn facet(self, local: usize) -> Vec<usize> {
        let corners = if self.triangle() { 3 } else { 4 };
        let mut nodes = vec![local, (local + 1) % corners];
        if !self.linear() {
            nodes.push(corners + local);
        }
        nodes
    }
}

impl Kind {
    /// Number of nodes.
    #[cfg(test)]
    pub fn nodes(self) -> usize {
        match self {
            Self::Tri3 => 3,
            Self::Tri6 => 6,
            Self::Quad4 => 4,
            Self::Quad8 => 8,
            Self::Quad9 => 9,
        }
    }

    /// Sides are polygons.
    pub fn linear(self) -> bool {
        matches!(self, Self::Tri3 | Self::Quad4)
    }

    /// Whether it is a triangle.
    pub fn triangle(self) -> bool {
        matches!(self, Self::Tri3 | Self::Tri6)
    }

    /// Gmsh's number.
    pub fn gmsh(self) -> usize {
        match self {
            Self::Tri3 => 2,
            Self::Tri6 => 9,
            Self::Quad4 => 3,
            Self::Quad8 => 16,
            Self::Quad9 => 10,
        }
    }

    /// Shape functions and their reference gradients at a point.
    pub fn shape(self, xi: Vector) -> (Vec<f64>, Vec<Vector>) {
        let [x, y] = xi;
        match self {
            Self::Tri3 => (
                vec![1.0 - x - y, x, y],
                vec![[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]],
            ),
            Self::Tri6 => {
                let l = [1.0 - x - y, x, y];
                let g = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
                let (mut n, mut d) = (Vec::new(), Vec::new());
                for i in 0..3 {
                    n.push(l[i] * (2.0 * l[i] - 1.0));
                    d.push([0, 1].map(|k| (4.0 * l[i] - 1.0) * g[i][k]));
                }
                for i in 0..3 {
                    let j = (i + 1) % 3;
                    n.push(4.0 * l[i] * l[j]);
                    d.push([0, 1].map(|k| 4.0 * (l[i] * g[j][k] + l[j] * g[i][k])));
                }
                (n, d)
            }
            Self::Quad4 => {
                let corner = |(a, b): (f64, f64)| {
                    (
                        0.25 * (1.0 + a * x) * (1.0 + b * y),
                        [0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)],
                    )
                };
                CORNERS.map(corner).into_iter().unzip()
            }
            Self::Quad8 => {
                let corner = |(a, b): (f64, f64)| {
                    let (p, q, s) = (1.0 + a * x, 1.0 + b * y, a * x + b * y - 1.0);
                    (
                        0.25 * p * q * s,
                        [0.25 * a * q * (s + p), 0.25 * b * p * (s + q)],
                    )
                };
                let (mut n, mut d): (Vec<_>, Vec<_>) = CORNERS.map(corner).into_iter().unzip();
                for (a, b) in [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)] {
                    let (value, slope) = if a == 0.0 {
                        (
                            0.5 * (1.0 - x * x) * (1.0 + b * y),
                            [-x * (1.0 + b * y), 0.5 * b * (1.0 - x * x)],
                        )
                    } else {
                        (
                            0.5 * (1.0 + a * x) * (1.0 - y * y),
                            [0.5 * a * (1.0 - y * y), -y * (1.0 + a * x)],
                        )
                    };
                    n.push(value);
                    d.push(slope);
                }
                (n, d)
            }
            Self::Quad9 => {
                let ((u, du), (v, dv)) = (parabolas(x), parabolas(y));
                // places along x and y: 0 at −1, 1 at +1, 2 in the middle
                let places = [
                    [0, 0],
                    [1, 0],
                    [1, 1],
                    [0, 1],
                    [2, 0],
                    [1, 2],
                    [2, 1],
                    [0, 2],
                    [2, 2],
                ];
                places
                    .into_iter()
                    .map(|[i, j]| (u[i] * v[j], [du[i] * v[j], u[i] * dv[j]]))
                    .unzip()
            }
        }
    }

    /// Gauss points and weights of the stiffness.
    pub fn rule(self, axisymmetric: bool) -> Vec<(Vector, f64)> {
        match self {
            Self::Tri3 if !axisymmetric => vec![([1.0 / 3.0, 1.0 / 3.0], 0.5)],
            Self::Tri3 => orbit(1.0 / 6.0, 1.0 / 6.0),
            Self::Tri6 => {
                let ten = 10.0f64.sqrt();
                let inner = (38.0 - 44.0 * 0.4f64.sqrt()).sqrt();
                let outer = (213_125.0 - 53_320.0 * ten).sqrt();
                let mut rule = orbit((8.0 - ten + inner) / 18.0, (620.0 + outer) / 7440.0);
                rule.extend(orbit((8.0 - ten - inner) / 18.0, (620.0 - outer) / 7440.0));
                rule
            }
            Self::Quad4 => square(2),
            Self::Quad8 | Self::Quad9 => square(3),
        }
    }

    /// Gauss points and weights of a body force: exact for a constant force on curved cells, with the radius, too.
    pub fn fine_rule(self) -> Vec<(Vector, f64)> {
        if !self.triangle() {
            return square(5);
        }
        // the square folded onto the triangle: (s, t) → (s, (1 − s) t)
        let fold = |([a, b], w): (Vector, f64)| {
            let (s, t) = (0.5 * (1.0 + a), 0.5 * (1.0 + b));
            ([s, (1.0 - s) * t], 0.25 * w * (1.0 - s))
        };
        square(6).into_iter().map(fold).collect()
    }
}

const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];

/// Three points (a, a) (1−2a, a) (a, 1−2a), each of this weight.
fn orbit(a: f64, weight: f64) -> Vec<(Vector, f64)> {
    let b = 1.0 - 2.0 * a;
    vec![([a, a], weight), ([b, a], weight), ([a, b], weight)]
}

fn square(n: usize) -> Vec<(Vector, f64)> {
    let line = gauss(n);
    let product = |&(y, v): &(f64, f64)| line.iter().map(move |&(x, w)| ([x, y], w * v));
    line.iter().flat_map(product).collect()
}

/// Gauss's rule with n ≤ 6 points on [−1, 1].
pub fn gauss(n: usize) -> Vec<(f64, f64)> {
    let half: &[(f64, f64)] = match n {
        2 => &[(0.577_350_269_189_625_8, 1.0)],
        3 => &[
            (0.0, 0.888_888_888_888_889),
            (0.774_596_669_241_483_4, 0.555_555_555_555_555_6),
        ],
        5 => &[
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ],
        _ => &[
            (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
            (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
            (0.932_469_514_203_152, 0.171_324_492_379_170_36),
        ],
    };
    let mirror = |&(x, w): &(f64, f64)| match x {
        0.0 => vec![(0.0, w)],
        _ => vec![(-x, w), (x, w)],
    };
    half.iter().flat_map(mirror).collect()
}

/// Values and slopes at x of the parabolas that are one at −1, at +1 and at 0.
fn parabolas(x: f64) -> ([f64; 3], [f64; 3]) {
    (
        [0.5 * x * (x - 1.0), 0.5 * x * (x + 1.0), 1.0 - x * x],
        [x - 0.5, x + 0.5, -2.0 * x],
    )
}

/// Shape functions and slopes along a facet with two or three nodes.
pub fn along(nodes: usize, xi: f64) -> ([f64; 3], [f64; 3]) {
    if nodes == 2 {
        ([0.5 * (1.0 - xi), 0.5 * (1.0 + xi), 0.0], [-0.5, 0.5, 0.0])
    } else {
        parabolas(xi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(kind: Kind) -> Vec<Vector> {
        let corners: Vec<Vector> = match kind.triangle() {
            true => vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            false => CORNERS.iter().map(|&(a, b)| [a, b]).collect(),
        };
        let n = corners.len();
        let mut all = corners.clone();
        for i in 0..n {
            let j = (i + 1) % n;
            all.push([0, 1].map(|k| 0.5 * (corners[i][k] + corners[j][k])));
        }
        all.push([0.0, 0.0]);
        all.truncate(kind.nodes());
        all
    }

    #[test]
    fn shape_functions_are_one_at_their_own_node() {
        for &kind in Kind::ALL {
            for (i, place) in places(kind).into_iter().enumerate() {
                let (n, _) = kind.shape(place);
                assert_eq!(n.len(), kind.nodes());
                for (j, value) in n.into_iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!((value - expected).abs() < 1e-15, "{kind:?} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn gradients_are_differences_of_the_functions() {
        for &kind in Kind::ALL {
            let at = [0.23, 0.41];
            let (_, slopes) = kind.shape(at);
            for d in 0..2 {
                let mut ahead = at;
                let mut behind = at;
                ahead[d] += 1e-5;
                behind[d] -= 1e-5;
                let ((a, _), (b, _)) = (kind.shape(ahead), kind.shape(behind));
                for i in 0..kind.nodes() {
                    assert!(((a[i] - b[i]) / 2e-5 - slopes[i][d]).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn rules_integrate_their_degree() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (kind, degree, axisymmetric) in [
            (Kind::Tri3, 1, false),
            (Kind::Tri3, 2, true),
            (Kind::Tri6, 4, false),
        ] {
            for i in 0..=degree {
                for j in 0..=degree - i {
                    let exact = factorial(i) * factorial(j) / factorial(i + j + 2);
                    for rule in [kind.rule(axisymmetric), kind.fine_rule()] {
                        let sum: f64 = rule
                            .iter()
                            .map(|(x, w)| w * x[0].powi(i) * x[1].powi(j))
                            .sum();
                        assert!((sum - exact).abs() < 1e-15, "{kind:?} {i} {j}");
                    }
                }
            }
        }
        for (n, degree) in [(2, 3), (3, 5), (5, 9), (6, 11)] {
            for i in 0..=degree {
                let exact = if i % 2 == 1 {
                    0.0
                } else {
                    2.0 / f64::from(i + 1)
                };
                let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powi(i)).sum();
                assert!((sum - exact).abs() < 1e-15, "{n} {i}");
            }
        }
    }
}
