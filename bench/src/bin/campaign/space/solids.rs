//! Cells of space, written independently of the program: nodes, facets, shape functions, Gauss rules.
//!
//! The reference cube is [−1,1]³, the tetrahedron has a corner at the origin and one at the end of each axis, the prism is the
//! triangle of the first two axes times [−1,1]. Corners come first, then the middles of edges, of faces with four corners, of
//! the cell. Facets list their corners counter-clockwise from outside, then the middles.
//! The Gauss points are those of a fully integrated displacement cell (1 of tet4, 8 of tet10, 2×2×2 of hex8, 3×3×3 of hex20
//! and hex27, 3×2 of prism6, 6×3 of prism15 and prism18): on curved or tapered cells another rule would be another cell.
//!
//! Source of the eight points of tet10: as described in P. Keast, Comput. Methods Appl. Mech. Eng. 55 (1986) 339–348.

use super::geometry::{AXES, Vector, mean, plus, times};
use crate::cells::{Kind, gauss};
use crate::raw::Cell;
use std::ops::{Add, Mul, Sub};

/// Kinds of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solid {
    Tet4,
    Tet10,
    Hex8,
    Hex20,
    Hex27,
    Prism6,
    Prism15,
    Prism18,
}

use Solid::*;

/// Corners of the reference cells.
const TET: [Vector; 4] = [[0.0; 3], AXES[0], AXES[1], AXES[2]];
const HEX: [Vector; 8] = {
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut corners = [[0.0; 3]; 8];
    let mut k = 0;
    while k < 8 {
        let [x, y] = square[k % 4];
        corners[k] = [x, y, if k < 4 { -1.0 } else { 1.0 }];
        k += 1;
    }
    corners
};
const PRISM: [Vector; 6] = {
    let mut corners = [[0.0; 3]; 6];
    let mut k = 0;
    while k < 6 {
        let [x, y, _] = TET[k % 3];
        corners[k] = [x, y, if k < 3 { -1.0 } else { 1.0 }];
        k += 1;
    }
    corners
};

impl Cell for Solid {
    const ALL: &'static [Self] = &[Tet4, Tet10, Hex8, Hex20, Hex27, Prism6, Prism15, Prism18];

    fn name(self) -> &'static str {
        match self {
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

    fn facet(self, local: usize) -> Vec<usize> {
        let corners = &self.faces()[local];
        let mut nodes = corners.clone();
        if self.linear() {
            return nodes;
        }
        let (first, edges) = (self.corners().len(), self.edges());
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            let edge = edges
                .iter()
                .position(|e| *e == [a, b] || *e == [b, a])
                .unwrap_or_else(|| panic!("{self:?} has no edge {a} {b}"));
            nodes.push(first + edge);
        }
        let middles = self.middles();
        let same = |face: &Vec<usize>| face.iter().all(|n| corners.contains(n));
        if let Some(place) = middles.iter().position(same) {
            nodes.push(first + edges.len() + place);
        }
        nodes
    }
}

impl Solid {
    /// Whether Gauss points are exact with straight edges and flat faces.
    pub fn linear(self) -> bool {
        matches!(self, Tet4 | Hex8 | Prism6)
    }

    /// Gmsh's number.
    pub fn gmsh(self) -> usize {
        match self {
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

    /// Nodes of a cell in Gmsh's order: it lists edges and faces by their smaller corners.
    pub fn in_gmsh(self, nodes: &[usize]) -> Vec<usize> {
        let (first, edges, middles) = (self.corners().len(), self.edges(), self.middles());
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
        debug_assert!(faces.len() == middles.len());
        order.extend(faces.iter().map(|f| first + edges.len() + f));
        order.truncate(nodes.len());
        order.extend(order.len()..nodes.len());
        order.into_iter().map(|n| nodes[n]).collect()
    }

    /// Corners of the reference cell.
    pub fn corners(self) -> &'static [Vector] {
        match self {
            Tet4 | Tet10 => &TET,
            Hex8 | Hex20 | Hex27 => &HEX,
            Prism6 | Prism15 | Prism18 => &PRISM,
        }
    }

    /// Corners of each edge, in the order of the nodes in their middles.
    pub fn edges(self) -> Vec<[usize; 2]> {
        table(match self.corners().len() {
            4 => "01 12 20 03 13 23",
            8 => "01 12 23 30 45 56 67 74 04 15 26 37",
            _ => "01 12 20 34 45 53 03 14 25",
        })
        .iter()
        .map(|edge| [edge[0], edge[1]])
        .collect()
    }

    /// Corners of each face, counter-clockwise from outside.
    fn faces(self) -> Vec<Vec<usize>> {
        table(match self.corners().len() {
            4 => "021 013 123 032",
            8 => "0321 4567 0154 1265 2376 3047",
            _ => "021 345 0143 1254 2035",
        })
    }

    /// Faces with a node in their middle, in the order of these nodes.
    fn middles(self) -> Vec<Vec<usize>> {
        table(match self {
            Hex27 => "0347 1256 0145 2367 0123 4567",
            Prism18 => "0134 1245 0235",
            _ => "",
        })
    }

    /// Reference coordinates of all nodes, which lie at corners and in the middles of edges, faces and the cell.
    pub fn places(self, corners: &[Vector]) -> Vec<Vector> {
        let mut places = corners.to_vec();
        if self.linear() {
            return places;
        }
        let middle = |of: &[usize]| {
            let ends: Vec<Vector> = of.iter().map(|&n| corners[n]).collect();
            mean(&ends)
        };
        places.extend(self.edges().iter().map(|edge| middle(edge)));
        places.extend(self.middles().iter().map(|face| middle(face)));
        if self == Hex27 {
            places.push(mean(corners));
        }
        places
    }

    /// Shape functions and their reference gradients at a point.
    pub fn shape(self, xi: Vector) -> Vec<(f64, Vector)> {
        let x: [Slope; 3] = std::array::from_fn(|d| Slope::variable(xi[d], d));
        let one = Slope::from(1.0);
        let nodes = self.places(self.corners());
        let each = nodes.iter().map(|node| match self {
            Tet4 | Tet10 => quadratic(&barycentric(&x), &barycentric(&node.map(Slope::from)), self),
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
            Hex27 => (0..3).fold(one, |n, d| n * parabola(x[d], node[d])),
            _ => {
                let factor = |d: usize| match node[d] {
                    0.0 => one - x[d] * x[d],
                    a => (one + x[d] * a) * 0.5,
                };
                let product = (0..3).fold(one, |n, d| n * factor(d));
                match self == Hex20 && node.iter().all(|a| *a != 0.0) {
                    true => {
                        let sum = x[0] * node[0] + x[1] * node[1] + x[2] * node[2];
                        product * (sum - Slope::from(2.0))
                    }
                    false => product,
                }
            }
        });
        each.map(|slope| (slope.value, slope.gradient)).collect()
    }

    /// Gauss points and weights of the stiffness.
    pub fn rule(self) -> Vec<(Vector, f64)> {
        match self {
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
            Hex8 => cube(2),
            Hex20 | Hex27 => cube(3),
            Prism6 => along(&Kind::Tri3.rule(true), 2),
            Prism15 | Prism18 => along(&Kind::Tri6.rule(false), 3),
        }
    }

    /// Gauss points and weights of a body force: exact for a constant one on curved cells.
    pub fn fine_rule(self) -> Vec<(Vector, f64)> {
        match self {
            Tet4 | Tet10 => {
                // the cube folded onto the tetrahedron
                let fold = |([a, b, c], w): (Vector, f64)| {
                    let [r, s, t] = [a, b, c].map(|x| 0.5 * (1.0 + x));
                    let (y, left) = ((1.0 - r) * s, (1.0 - r) * (1.0 - s));
                    ([r, y, left * t], 0.125 * w * (1.0 - r) * left)
                };
                cube(5).into_iter().map(fold).collect()
            }
            Hex8 | Hex20 | Hex27 => cube(5),
            _ => along(&Kind::Tri6.fine_rule(), 5),
        }
    }
}

/// Numbers of one digit, word by word.
fn table(words: &str) -> Vec<Vec<usize>> {
    let digits = |word: &str| word.bytes().map(|b| usize::from(b - b'0')).collect();
    words.split_whitespace().map(digits).collect()
}

/// Barycentric coordinates in the tetrahedron.
fn barycentric(x: &[Slope; 3]) -> [Slope; 4] {
    [Slope::from(1.0) - x[0] - x[1] - x[2], x[0], x[1], x[2]]
}

/// The function of a simplex, linear or quadratic, that is one at a corner or in the middle of an edge: `l` and `node` are the
/// barycentric coordinates of the point and of the node.
fn quadratic(l: &[Slope], node: &[Slope], kind: Solid) -> Slope {
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

fn along(triangle: &[([f64; 2], f64)], n: usize) -> Vec<(Vector, f64)> {
    let layer =
        |&([x, y], w): &([f64; 2], f64)| gauss(n).into_iter().map(move |(z, v)| ([x, y, z], w * v));
    triangle.iter().flat_map(layer).collect()
}

fn cube(n: usize) -> Vec<(Vector, f64)> {
    let line = gauss(n);
    let square = line
        .iter()
        .flat_map(|&(x, w)| line.iter().map(move |&(y, v)| ([x, y], w * v)));
    along(&square.collect::<Vec<_>>(), n)
}

/// A number with its gradient.
#[derive(Debug, Clone, Copy)]
struct Slope {
    value: f64,
    gradient: Vector,
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
    use crate::space::geometry::{cross, dot, minus};

    #[test]
    fn shape_functions_are_one_at_their_own_node_and_gradients_are_their_differences() {
        for &kind in Solid::ALL {
            for (i, place) in kind.places(kind.corners()).into_iter().enumerate() {
                for (j, (value, _)) in kind.shape(place).into_iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!((value - expected).abs() < 1e-15, "{kind:?} {i} {j}");
                }
            }
            let at = [0.23, 0.31, 0.17];
            for d in 0..3 {
                let step = |s: f64| kind.shape(plus(at, s, crate::space::geometry::AXES[d]));
                let (ahead, behind) = (step(1e-5), step(-1e-5));
                for ((a, b), (_, slope)) in ahead.iter().zip(&behind).zip(kind.shape(at)) {
                    assert!(((a.0 - b.0) / 2e-5 - slope[d]).abs() < 1e-9, "{kind:?}");
                }
            }
        }
    }

    #[test]
    fn rules_integrate_their_degree() {
        // ∫ over the unit tetrahedron xⁱyʲzᵏ = i! j! k!/(i + j + k + 3)!
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let line = |i: i32| {
            if i % 2 == 1 {
                0.0
            } else {
                2.0 / f64::from(i + 1)
            }
        };
        for (kind, degree) in [
            (Tet4, 1),
            (Tet10, 3),
            (Hex8, 3),
            (Hex20, 5),
            (Prism6, 2),
            (Prism15, 4),
        ] {
            for (i, j, k) in (0..=degree)
                .flat_map(|i| (0..=degree - i).map(move |j| (i, j)))
                .flat_map(|(i, j)| (0..=degree - i - j).map(move |k| (i, j, k)))
            {
                let exact = match kind.corners().len() {
                    4 => factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3),
                    6 => factorial(i) * factorial(j) / factorial(i + j + 2) * line(k),
                    _ => line(i) * line(j) * line(k),
                };
                for rule in [kind.rule(), kind.fine_rule()] {
                    let each = rule
                        .iter()
                        .map(|(x, w)| w * x[0].powi(i) * x[1].powi(j) * x[2].powi(k));
                    let sum: f64 = each.sum();
                    assert!((sum - exact).abs() < 1e-14, "{kind:?} {i} {j} {k}");
                }
            }
        }
    }

    #[test]
    fn facets_are_counter_clockwise_from_outside_with_their_middles_where_they_are() {
        for &kind in Solid::ALL {
            let places = kind.places(kind.corners());
            let centre = mean(kind.corners());
            for local in 0..kind.faces().len() {
                let nodes = kind.facet(local);
                let at: Vec<Vector> = nodes.iter().map(|&n| places[n]).collect();
                let normal = cross(minus(at[1], at[0]), minus(at[2], at[0]));
                assert!(dot(normal, minus(at[0], centre)) > 0.0, "{kind:?} {local}");
                let corners = kind.faces()[local].len();
                for (k, &middle) in at[corners..].iter().enumerate().take(corners) {
                    let ends = mean(&[at[k], at[(k + 1) % corners]]);
                    assert_eq!(middle, ends, "{kind:?}");
                }
                if at.len() > 2 * corners {
                    assert_eq!(at[2 * corners], mean(&at[..corners]));
                }
            }
        }
    }
}
