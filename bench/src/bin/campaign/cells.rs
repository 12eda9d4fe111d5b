//! Reference cells of the plane and of space, written independently of the program: nodes, facets, shape functions, Gauss rules.
//!
//! A cell of fewer than three dimensions has reference coordinates whose last components are zero. Line, square and cube are
//! −1 ≤ ξ ≤ 1 along each axis; triangle and tetrahedron have a corner at the origin and one at the end of each axis; the prism is
//! the triangle of the first two axes times −1 ≤ ζ ≤ 1. Corners come first, then the middles of edges, of faces with four corners,
//! and of the cell. Facets list their corners with the cell on the left (in space counter-clockwise from outside), then the middles.
//! The Gauss points are those of a fully integrated displacement cell: on curved or tapered cells another rule would be another
//! cell. That is 1 point of tri3 (3 by radius), 6 of tri6, 2×2 of quad4, 3×3 of quad8 and quad9, 1 of tet4, 8 of tet10, 2×2×2 of
//! hex8, 3×3×3 of hex20 and hex27, 3×2 of prism6, 6×3 of prism15 and prism18.
//!
//! Source of the eight points of tet10: as described in P. Keast, Comput. Methods Appl. Mech. Eng. 55 (1986) 339–348.

use crate::vector::{mean, plus, times};
use std::ops::{Add, Mul, Sub};

/// Reference coordinates.
pub type Place = [f64; 3];

/// A Gauss point with its weight.
pub type Point = (Place, f64);

/// Shape functions of the nodes of a cell, with their reference gradients.
pub type Functions = Vec<(f64, Place)>;

/// Kinds of cells; lines are facets of cells of the plane, triangles and quadrilaterals also those of cells of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Line2,
    Line3,
    Tri3,
    Tri6,
    Quad4,
    Quad8,
    Quad9,
    Tet4,
    Tet10,
    Hex8,
    Hex20,
    Hex27,
    Prism6,
    Prism15,
    Prism18,
}

use Kind::*;

/// Corners of the reference cells.
const LINE: [Place; 2] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
const TRIANGLE: [Place; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const TET: [Place; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const SQUARE: [Place; 4] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
];
const HEX: [Place; 8] = layers(&SQUARE);
const PRISM: [Place; 6] = layers(&TRIANGLE);

/// A polygon at z = −1 and at z = 1.
const fn layers<const N: usize>(polygon: &[Place]) -> [Place; N] {
    let mut corners = [[0.0; 3]; N];
    let mut k = 0;
    while k < N {
        let [x, y, _] = polygon[k % polygon.len()];
        corners[k] = [x, y, if k < polygon.len() { -1.0 } else { 1.0 }];
        k += 1;
    }
    corners
}

impl Kind {
    /// Cells of the plane.
    pub const PLANE: [Self; 5] = [Tri3, Tri6, Quad4, Quad8, Quad9];

    /// Cells of space.
    pub const SPACE: [Self; 8] = [Tet4, Tet10, Hex8, Hex20, Hex27, Prism6, Prism15, Prism18];

    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Line2 => "line2",
            Line3 => "line3",
            Tri3 => "tri3",
            Tri6 => "tri6",
            Quad4 => "quad4",
            Quad8 => "quad8",
            Quad9 => "quad9",
            Tet4 => "tet4",
            Tet10 => "tet10",
            Hex8 => "hex8",
            Hex20 => "hex20",
            Hex27 => "hex27",
            Prism6 => "prism6",
            Prism15 => "prism15",
            Prism18 => "prism18",
        }
    }

    /// Gmsh's number.
    pub fn gmsh(self) -> usize {
        match self {
            Line2 => 1,
            Line3 => 8,
            Tri3 => 2,
            Tri6 => 9,
            Quad4 => 3,
            Quad8 => 16,
            Quad9 => 10,
            Tet4 => 4,
            Tet10 => 11,
            Hex8 => 5,
            Hex20 => 17,
            Hex27 => 12,
            Prism6 => 6,
            Prism15 => 18,
            Prism18 => 13,
        }
    }

    /// Nodes of a cell in Gmsh's order: of cells of space it lists edges and faces by their smaller corners.
    pub fn in_gmsh(self, nodes: &[usize]) -> Vec<usize> {
        if self.dimension() < 3 {
            return nodes.to_vec();
        }
        let (first, edges) = (self.corners().len(), self.edges());
        let mut sorted: Vec<usize> = (0..edges.len()).collect();
        let key = |e: &usize| {
            let [a, b] = edges[*e];
            [a.min(b), a.max(b)]
        };
        match self {
            // the edges at the last corner come from 3 to 0, 2, 1
            Tet4 | Tet10 => sorted = vec![0, 1, 2, 3, 5, 4],
            _ => sorted.sort_by_key(key),
        }
        let mut order: Vec<usize> = (0..first).chain(sorted.iter().map(|e| first + e)).collect();
        let faces: &[usize] = match self {
            Hex27 => &[4, 2, 0, 1, 3, 5],
            Prism18 => &[0, 2, 1],
            _ => &[],
        };
        debug_assert!(faces.len() == self.middles().len());
        order.extend(faces.iter().map(|f| first + edges.len() + f));
        order.truncate(nodes.len());
        order.extend(order.len()..nodes.len());
        order.into_iter().map(|n| nodes[n]).collect()
    }

    /// Number of reference coordinates.
    pub fn dimension(self) -> usize {
        match self {
            Line2 | Line3 => 1,
            Tri3 | Tri6 | Quad4 | Quad8 | Quad9 => 2,
            _ => 3,
        }
    }

    /// Edges are straight; else they have a node in their middle.
    pub fn linear(self) -> bool {
        matches!(self, Line2 | Tri3 | Quad4 | Tet4 | Hex8 | Prism6)
    }

    /// It is a triangle.
    pub fn triangle(self) -> bool {
        matches!(self, Tri3 | Tri6)
    }

    /// The kind of a facet with this number of nodes, of a cell of so many dimensions.
    pub fn of_facet(dimension: usize, nodes: usize) -> Self {
        match (dimension, nodes) {
            (2, 2) => Line2,
            (2, _) => Line3,
            (_, 3) => Tri3,
            (_, 4) => Quad4,
            (_, 6) => Tri6,
            (_, 8) => Quad8,
            _ => Quad9,
        }
    }

    /// Corners of the reference cell.
    pub fn corners(self) -> &'static [Place] {
        match self {
            Line2 | Line3 => &LINE,
            Tri3 | Tri6 => &TRIANGLE,
            Quad4 | Quad8 | Quad9 => &SQUARE,
            Tet4 | Tet10 => &TET,
            Hex8 | Hex20 | Hex27 => &HEX,
            Prism6 | Prism15 | Prism18 => &PRISM,
        }
    }

    /// Corners of each edge, in the order of the nodes in their middles.
    fn edges(self) -> Vec<[usize; 2]> {
        table(match self {
            Line2 | Line3 => "01",
            Tri3 | Tri6 => "01 12 20",
            Quad4 | Quad8 | Quad9 => "01 12 23 30",
            Tet4 | Tet10 => "01 12 20 03 13 23",
            Hex8 | Hex20 | Hex27 => "01 12 23 30 45 56 67 74 04 15 26 37",
            Prism6 | Prism15 | Prism18 => "01 12 20 34 45 53 03 14 25",
        })
        .iter()
        .map(|edge| [edge[0], edge[1]])
        .collect()
    }

    /// Corners of each facet, with the cell on the left or counter-clockwise from outside.
    pub fn facets(self) -> Vec<Vec<usize>> {
        match self {
            Tet4 | Tet10 => table("021 013 123 032"),
            Hex8 | Hex20 | Hex27 => table("0321 4567 0154 1265 2376 3047"),
            Prism6 | Prism15 | Prism18 => table("021 345 0143 1254 2035"),
            _ => self.edges().into_iter().map(Vec::from).collect(),
        }
    }

    /// Faces with a node in their middle, in the order of these nodes.
    fn middles(self) -> Vec<Vec<usize>> {
        table(match self {
            Hex27 => "0347 1256 0145 2367 0123 4567",
            Prism18 => "0134 1245 0235",
            _ => "",
        })
    }

    /// Local nodes of a facet, in the order of the facet's own kind.
    pub fn facet(self, local: usize) -> Vec<usize> {
        let corners = &self.facets()[local];
        let mut nodes = corners.clone();
        if self.linear() {
            return nodes;
        }
        let (first, edges) = (self.corners().len(), self.edges());
        let around = if corners.len() == 2 { 1 } else { corners.len() };
        for (k, &a) in corners.iter().enumerate().take(around) {
            let b = corners[(k + 1) % corners.len()];
            let edge = edges
                .iter()
                .position(|e| *e == [a, b] || *e == [b, a])
                .unwrap_or_else(|| panic!("{self:?} has no edge {a} {b}"));
            nodes.push(first + edge);
        }
        let same = |face: &Vec<usize>| face.iter().all(|n| corners.contains(n));
        if let Some(place) = self.middles().iter().position(same) {
            nodes.push(first + edges.len() + place);
        }
        nodes
    }

    /// Places of all nodes of a cell with these corners, straight edges and flat faces.
    pub fn places<const D: usize>(self, corners: &[[f64; D]]) -> Vec<[f64; D]> {
        let mut places = corners.to_vec();
        if self.linear() {
            return places;
        }
        let middle = |of: &[usize]| {
            let ends: Vec<[f64; D]> = of.iter().map(|&n| corners[n]).collect();
            mean(&ends)
        };
        places.extend(self.edges().iter().map(|edge| middle(edge)));
        places.extend(self.middles().iter().map(|face| middle(face)));
        if matches!(self, Quad9 | Hex27) {
            places.push(mean(corners));
        }
        places
    }

    /// Reference coordinates of all nodes.
    pub fn nodes(self) -> Vec<Place> {
        self.places(self.corners())
    }

    /// Shape functions and their reference gradients at a point.
    pub fn shape(self, xi: Place) -> Functions {
        let x: [Slope; 3] = std::array::from_fn(|d| Slope::variable(xi[d], d));
        let one = Slope::from(1.0);
        let axes = 0..self.dimension();
        let nodes = self.nodes();
        let each = nodes.iter().map(|node| match self {
            Tri3 | Tri6 | Tet4 | Tet10 => {
                let from_all = |x: &[Slope; 3]| {
                    let own = &x[axes.clone()];
                    let rest = own.iter().fold(one, |l, &x| l - x);
                    let mut all = vec![rest];
                    all.extend(own);
                    all
                };
                quadratic(&from_all(&x), &from_all(&node.map(Slope::from)), self)
            }
            Prism6 | Prism15 | Prism18 => {
                let l = [one - x[0] - x[1], x[0], x[1]];
                let p = [1.0 - node[0] - node[1], node[0], node[1]].map(Slope::from);
                let corner = p.iter().position(|p| p.value == 1.0);
                let vertical = one - x[2] * x[2];
                match (self, corner, node[2]) {
                    (Prism6, Some(c), z) => l[c] * (one + x[2] * z) * 0.5,
                    (Prism15, Some(c), 0.0) => l[c] * vertical,
                    (Prism15, Some(c), z) => {
                        l[c] * ((l[c] * 2.0 - one) * (one + x[2] * z) - vertical) * 0.5
                    }
                    (Prism15, None, z) => quadratic(&l, &p, self) * (one + x[2] * z) * 0.5,
                    _ => quadratic(&l, &p, self) * parabola(x[2], node[2]),
                }
            }
            Line3 | Quad9 | Hex27 => axes.clone().fold(one, |n, d| n * parabola(x[d], node[d])),
            Line2 | Quad4 | Quad8 | Hex8 | Hex20 => {
                let factor = |d: usize| match node[d] {
                    0.0 => one - x[d] * x[d],
                    a => (one + x[d] * a) * 0.5,
                };
                let product = axes.clone().fold(one, |n, d| n * factor(d));
                let corner = axes.clone().all(|d| node[d] != 0.0);
                if self.linear() || !corner {
                    return product;
                }
                let sum = axes
                    .clone()
                    .fold(Slope::from(1.0 - axes.len() as f64), |s, d| {
                        s + x[d] * node[d]
                    });
                product * sum
            }
        });
        each.map(|slope| (slope.value, slope.gradient)).collect()
    }

    /// Gauss points and weights of the stiffness; for bodies of revolution (`revolved`) tri3 has three.
    pub fn rule(self, revolved: bool) -> Vec<Point> {
        match self {
            Line2 => line(2),
            Line3 => line(3),
            Tri3 if revolved => orbit(1.0 / 6.0, 1.0 / 6.0),
            Tri3 => vec![([1.0 / 3.0, 1.0 / 3.0, 0.0], 0.5)],
            Tri6 => {
                let ten = 10.0f64.sqrt();
                let inner = (38.0 - 44.0 * 0.4f64.sqrt()).sqrt();
                let outer = (213_125.0 - 53_320.0 * ten).sqrt();
                let mut rule = orbit((8.0 - ten + inner) / 18.0, (620.0 + outer) / 7440.0);
                rule.extend(orbit((8.0 - ten - inner) / 18.0, (620.0 - outer) / 7440.0));
                rule
            }
            Quad4 => square(2),
            Quad8 | Quad9 => square(3),
            Tet4 => vec![([0.25; 3], 1.0 / 6.0)],
            Tet10 => {
                let orbit = |a: f64, weight: f64| {
                    let b = 1.0 - 3.0 * a;
                    [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|x| (x, weight / 6.0))
                };
                let mut rule = orbit(0.328_054_696_711_426_7, 0.138_527_966_511_862_15).to_vec();
                rule.extend(orbit(0.106_952_273_932_930_68, 0.111_472_033_488_137_85));
                rule
            }
            Hex8 => along(&square(2), 2),
            Hex20 | Hex27 => along(&square(3), 3),
            Prism6 => along(&Tri3.rule(true), 2),
            Prism15 | Prism18 => along(&Tri6.rule(false), 3),
        }
    }

    /// Gauss points and weights of loads: exact for a constant one on curved cells, with the radius, too.
    pub fn fine_rule(self) -> Vec<Point> {
        match self {
            Line2 | Line3 => line(6),
            Tri3 | Tri6 => square(6).into_iter().map(folded).collect(),
            Quad4 | Quad8 | Quad9 => square(5),
            Tet4 | Tet10 => {
                // the cube folded onto the tetrahedron
                let fold = |([a, b, c], w): Point| {
                    let [r, s, t] = [a, b, c].map(|x| 0.5 * (1.0 + x));
                    let (y, left) = ((1.0 - r) * s, (1.0 - r) * (1.0 - s));
                    ([r, y, left * t], 0.125 * w * (1.0 - r) * left)
                };
                along(&square(5), 5).into_iter().map(fold).collect()
            }
            Hex8 | Hex20 | Hex27 => along(&square(5), 5),
            Prism6 | Prism15 | Prism18 => along(&Tri6.fine_rule(), 5),
        }
    }
}

/// Numbers of one digit, word by word.
fn table(words: &str) -> Vec<Vec<usize>> {
    let digits = |word: &str| word.bytes().map(|b| usize::from(b - b'0')).collect();
    words.split_whitespace().map(digits).collect()
}

/// The function of a simplex, linear or quadratic, that is one at a corner or in the middle of an edge: `l` and `node` are the
/// barycentric coordinates of the point and of the node.
fn quadratic(l: &[Slope], node: &[Slope], kind: Kind) -> Slope {
    let ends: Vec<usize> = (0..l.len()).filter(|&i| node[i].value > 0.25).collect();
    match ends[..] {
        [i] if kind.linear() => l[i],
        [i] => l[i] * (l[i] * 2.0 - Slope::from(1.0)),
        [i, j] => l[i] * l[j] * 4.0,
        _ => Slope::from(f64::NAN),
    }
}

/// The parabola of x that is one at `place`, of −1, 0 and 1, and zero at the other two.
fn parabola(x: Slope, place: f64) -> Slope {
    match place {
        0.0 => Slope::from(1.0) - x * x,
        a => x * (x + Slope::from(a)) * 0.5,
    }
}

/// Three points (a, a) (1−2a, a) (a, 1−2a), each of this weight.
fn orbit(a: f64, weight: f64) -> Vec<Point> {
    let b = 1.0 - 2.0 * a;
    [[a, a, 0.0], [b, a, 0.0], [a, b, 0.0]]
        .map(|x| (x, weight))
        .to_vec()
}

/// A point of the square on the triangle: (s, t) → (s, (1 − s) t).
fn folded(([a, b, _], w): Point) -> Point {
    let (s, t) = (0.5 * (1.0 + a), 0.5 * (1.0 + b));
    ([s, (1.0 - s) * t, 0.0], 0.25 * w * (1.0 - s))
}

fn line(n: usize) -> Vec<Point> {
    let each = gauss(n).into_iter();
    each.map(|(x, w)| ([x, 0.0, 0.0], w)).collect()
}

fn square(n: usize) -> Vec<Point> {
    let line = gauss(n);
    let row = |&(y, v): &(f64, f64)| line.iter().map(move |&(x, w)| ([x, y, 0.0], w * v));
    line.iter().flat_map(row).collect()
}

/// A rule of the plane at the points of Gauss's rule along the third axis.
fn along(plane: &[Point], n: usize) -> Vec<Point> {
    let layer =
        |&([x, y, _], w): &Point| gauss(n).into_iter().map(move |(z, v)| ([x, y, z], w * v));
    plane.iter().flat_map(layer).collect()
}

/// Gauss's rule with 2, 3, 5 or 6 points on [−1, 1].
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

/// A number with its gradient.
#[derive(Debug, Clone, Copy)]
struct Slope {
    value: f64,
    gradient: Place,
}

impl Slope {
    fn variable(value: f64, axis: usize) -> Self {
        let mut gradient = [0.0; 3];
        gradient[axis] = 1.0;
        Self { value, gradient }
    }
}

impl From<f64> for Slope {
    fn from(value: f64) -> Self {
        let gradient = [0.0; 3];
        Self { value, gradient }
    }
}

impl Add for Slope {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let gradient = plus(self.gradient, 1.0, other.gradient);
        let value = self.value + other.value;
        Self { value, gradient }
    }
}

impl Mul for Slope {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let gradient = times(other.value, self.gradient);
        Self {
            value: self.value * other.value,
            gradient: plus(gradient, self.value, other.gradient),
        }
    }
}

impl Mul<f64> for Slope {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self * Self::from(factor)
    }
}

impl Sub for Slope {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{axes, cross, dot, minus};

    fn all() -> impl Iterator<Item = Kind> {
        let lines = [Line2, Line3].into_iter();
        lines.chain(Kind::PLANE).chain(Kind::SPACE)
    }

    #[test]
    fn shape_functions_are_one_at_their_own_node_and_gradients_are_their_differences() {
        for kind in all() {
            for (i, place) in kind.nodes().into_iter().enumerate() {
                for (j, (value, _)) in kind.shape(place).into_iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!((value - expected).abs() < 1e-15, "{kind:?} {i} {j}");
                }
            }
            let at = [0.23, 0.31, 0.17];
            for d in 0..kind.dimension() {
                let step = |s: f64| kind.shape(plus(at, s, axes()[d]));
                let (ahead, behind) = (step(1e-5), step(-1e-5));
                for ((a, b), (_, slope)) in ahead.iter().zip(&behind).zip(kind.shape(at)) {
                    assert!(((a.0 - b.0) / 2e-5 - slope[d]).abs() < 1e-9, "{kind:?}");
                }
            }
        }
    }

    #[test]
    fn rules_integrate_their_degree() {
        // ∫ over the unit simplex xⁱyʲzᵏ = i! j! k!/(i + j + k + dimension)!
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let line = |i: i32| {
            if i % 2 == 1 {
                0.0
            } else {
                2.0 / f64::from(i + 1)
            }
        };
        for (kind, degree, revolved) in [
            (Line2, 3, false),
            (Line3, 5, false),
            (Tri3, 1, false),
            (Tri3, 2, true),
            (Tri6, 4, false),
            (Quad4, 3, false),
            (Quad9, 5, false),
            (Tet4, 1, false),
            (Tet10, 3, false),
            (Hex8, 3, false),
            (Hex20, 5, false),
            (Prism6, 2, false),
            (Prism15, 4, false),
        ] {
            let n = kind.dimension();
            let most = |d: usize| if d < n { degree } else { 0 };
            for (i, j, k) in (0..=degree)
                .flat_map(|i| (0..=most(1).min(degree - i)).map(move |j| (i, j)))
                .flat_map(|(i, j)| (0..=most(2).min(degree - i - j)).map(move |k| (i, j, k)))
            {
                let exact = match kind {
                    Tri3 | Tri6 => factorial(i) * factorial(j) / factorial(i + j + 2),
                    Tet4 | Tet10 => {
                        factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3)
                    }
                    Prism6 | Prism15 => {
                        factorial(i) * factorial(j) / factorial(i + j + 2) * line(k)
                    }
                    _ => [i, j, k].into_iter().take(n).map(line).product(),
                };
                for rule in [kind.rule(revolved), kind.fine_rule()] {
                    let each = rule
                        .iter()
                        .map(|(x, w)| w * x[0].powi(i) * x[1].powi(j) * x[2].powi(k));
                    let sum: f64 = each.sum();
                    assert!((sum - exact).abs() < 1e-14, "{kind:?} {i} {j} {k}");
                }
            }
        }
        for i in 0..=11 {
            let sum: f64 = gauss(6).iter().map(|(x, w)| w * x.powi(i)).sum();
            assert!((sum - line(i)).abs() < 1e-15, "{i}");
        }
    }

    #[test]
    fn facets_look_outwards_with_their_middles_where_they_are() {
        for kind in Kind::PLANE.into_iter().chain(Kind::SPACE) {
            let (places, centre) = (kind.nodes(), mean(kind.corners()));
            for (local, corners) in kind.facets().iter().enumerate() {
                let n = corners.len();
                let nodes = kind.facet(local);
                let at: Vec<Place> = nodes.iter().map(|&n| places[n]).collect();
                let along = minus(at[1], at[0]);
                let normal = match n {
                    2 => cross(along, [0.0, 0.0, 1.0]),
                    _ => cross(along, minus(at[2], at[0])),
                };
                assert!(dot(normal, minus(at[0], centre)) > 0.0, "{kind:?} {local}");
                for (k, &middle) in at[n..].iter().enumerate().take(n) {
                    assert_eq!(middle, mean(&[at[k], at[(k + 1) % n]]), "{kind:?}");
                }
                if at.len() > 2 * n {
                    assert_eq!(at[2 * n], mean(&at[..n]));
                }
                let facet = Kind::of_facet(kind.dimension(), at.len());
                assert_eq!(facet.nodes().len(), at.len());
            }
        }
    }
}
