//! The functions ψ of the multipliers on one facet, and the parts of facets that face the other side.
//!
//! A facet consists of *cells* with linear functions ("hats") of their nodes: in the plane the spans between neighbouring nodes,
//! in space the facet with its corners. Nodes in the middle of edges and facets of space carry no multipliers: the weight ∫N of a
//! corner of a quadratic triangle is zero, of a quadrilateral negative, while hats of corners are positive whatever the facet is,
//! and displacements of second order with pressures of first order have the rates of the second.
//!
//! The *functions of a facet* are in the plane the shape functions of all its nodes, in space the hats of its corners; ψ are
//! biorthogonal to them, or to the hats of the bounding box of the covered part of a cell:
//!
//! ```text
//!   ψ = A N,     A = diag(∫N) M⁻¹,     M = ∫NNᵀ     over the part that faces the other side
//! ```
//!
//! The force of a node then acts at a corner of that box. If a corner is not covered itself, a force there would hold a body beside
//! its support. Then the nearest place p of the covered part replaces it: ψᵢ is a multiple wᵢ of the function whose product with
//! any bilinear function is the value of that function at pᵢ, and the wᵢ are such that the ψ sum to one:
//!
//! ```text
//!   ψᵢ = wᵢ h(pᵢ)ᵀ M⁻¹ h,     Σ wᵢ h(pᵢ) = ∫h,     h the hats of the box
//! ```
//!
//! Source of the biorthogonal functions: as described by B. I. Wohlmuth, SIAM J. Numer. Anal. 38 (2000) 989–1012.

use crate::contact::weights::POSITIVE;
use crate::fem::quadrature::rule;
use crate::mesh::{CellKind, Domain, Facet, Mesh};
use std::collections::BTreeMap;

/// Most functions of a facet.
pub(super) const FUNCTIONS: usize = 4;

/// Values of the functions of a facet or cell; missing ones are zero.
pub(super) type Values = [f64; FUNCTIONS];

/// A stretch of reference coordinates, ξ ↦ (ξ − origin)·scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    origin: [f64; 2],
    scale: [f64; 2],
}

impl Stretch {
    const NONE: Self = Self {
        origin: [0.0; 2],
        scale: [1.0; 2],
    };

    /// Maps the smallest box (in a triangle the smallest similar triangle) around some points to the whole domain.
    fn to_whole(domain: Domain, points: &[[f64; 2]]) -> Self {
        let least =
            |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(f).fold(f64::INFINITY, f64::min);
        let low = [least(&|p| p[0]), least(&|p| p[1])];
        match domain {
            Domain::Triangle => {
                let rest = least(&|p| 1.0 - p[0] - p[1]);
                let scale = 1.0 / (1.0 - low[0] - low[1] - rest);
                Self {
                    origin: low,
                    scale: [scale; 2],
                }
            }
            _ => {
                let high = [-least(&|p| -p[0]), -least(&|p| -p[1])];
                let half = |d: usize| 0.5 * (high[d] - low[d]);
                let middle = |d: usize| 0.5 * (high[d] + low[d]);
                let mut whole = Self::NONE;
                for d in 0..domain.dimension() {
                    (whole.origin[d], whole.scale[d]) = (middle(d), 1.0 / half(d));
                }
                whole
            }
        }
    }

    fn of(&self, xi: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| (xi[d] - self.origin[d]) * self.scale[d])
    }

    fn back(&self, xi: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| xi[d] / self.scale[d] + self.origin[d])
    }

    /// The part of the domain that is mapped to the whole.
    fn part(&self, domain: Domain) -> f64 {
        match domain {
            Domain::Line => 1.0 / self.scale[0],
            _ => 1.0 / (self.scale[0] * self.scale[1]),
        }
    }
}

/// A part of a facet with linear functions of its nodes.
pub(super) struct Cell {
    pub facet: Facet,
    pub nodes: Vec<usize>,
    /// Reference coordinates of its nodes on the facet.
    pub places: Vec<[f64; 2]>,
    /// The kind whose shape functions are the hats.
    kind: CellKind,
    whole: Stretch,
}

impl Cell {
    /// Hats of its nodes at ξ of the facet.
    pub fn hats(&self, xi: [f64; 2]) -> Values {
        values(self.kind, self.whole.of(xi))
    }

    /// Points and weights of integration over the cell, in reference coordinates of the facet.
    pub fn rule(&self, degree: usize) -> impl Iterator<Item = ([f64; 2], f64)> {
        let domain = self.kind.domain();
        let size = self.whole.part(domain);
        let points = rule(self.kind, degree).into_iter();
        points.map(move |point| {
            let xi = self.whole.back([point.xi[0], point.xi[1]]);
            (xi, size * point.weight)
        })
    }
}

/// The cells of a facet, in its own direction.
pub(super) fn cells<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> Vec<Cell> {
    let kind = mesh.facet_kind(facet);
    let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|node| node as usize).collect();
    let linear = kind.domain().linear();
    let cell = |local: &[usize]| {
        let place = |&i: &usize| {
            let [x, y, _] = kind.reference_nodes()[i];
            [x, y]
        };
        let places: Vec<[f64; 2]> = local.iter().map(place).collect();
        Cell {
            facet,
            nodes: local.iter().map(|&i| nodes[i]).collect(),
            whole: Stretch::to_whole(linear.domain(), &places),
            places,
            kind: linear,
        }
    };
    match kind {
        CellKind::Line3 => vec![cell(&[0, 2]), cell(&[2, 1])],
        _ => vec![cell(&[0, 1, 2, 3][..linear.nodes()])],
    }
}

/// Nodes of the functions of a facet, and the kind whose shape functions they are.
pub(super) fn functions<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> (CellKind, Vec<usize>) {
    let kind = mesh.facet_kind(facet);
    let kind = match kind.domain() {
        Domain::Line => kind,
        surface => surface.linear(),
    };
    let nodes = mesh.facet_nodes(facet).map(|node| node as usize);
    (kind, nodes.take(kind.nodes()).collect())
}

fn values(kind: CellKind, xi: [f64; 2]) -> Values {
    let mut values = [0.0; FUNCTIONS];
    kind.shape(&xi, &mut values);
    values
}

/// Part of a cell that faces one facet of the other side (or the obstacle).
pub(super) struct Piece {
    pub cell: usize,
    pub opposite: Option<Facet>,
    /// Reference coordinates on the facet: the ends of an interval, the corners of a polygon.
    pub corners: Vec<[f64; 2]>,
    /// Its part of the whole facet.
    pub part: f64,
    /// Points of integration: ξ and weights, whose sum is its size in reference coordinates.
    pub points: Vec<([f64; 2], f64)>,
}

/// A place counts as inside a piece up to this distance in reference coordinates: on curved sides pieces end on straight lines.
const BESIDE_PIECE: f64 = 0.1;

impl Piece {
    /// Whether a place of the facet lies in the piece, or just beside it.
    pub fn near(&self, xi: [f64; 2]) -> bool {
        let corners = self.corners.len();
        let double: f64 = (0..corners).map(|k| self.edge(k).1).sum();
        (0..corners).all(|k| {
            let ([from, along], _) = self.edge(k);
            let length = along[0].hypot(along[1]);
            let off = [xi[0] - from[0], xi[1] - from[1]];
            let inwards = match double {
                // an interval: along itself
                0.0 => (off[0] * along[0] + off[1] * along[1]) / length,
                _ => double.signum() * (along[0] * off[1] - along[1] * off[0]) / length,
            };
            length == 0.0 || inwards >= -BESIDE_PIECE
        })
    }

    /// Start and direction of an edge, and its contribution to twice the area.
    fn edge(&self, k: usize) -> ([[f64; 2]; 2], f64) {
        let (a, b) = (self.corners[k], self.corners[(k + 1) % self.corners.len()]);
        let along = [b[0] - a[0], b[1] - a[1]];
        ([a, along], a[0] * b[1] - a[1] * b[0])
    }
}

/// A facet is covered, an interval has no hole, when all but this part of it faces the other side: rounding.
const COVERED: f64 = 1e-9;

/// The covered part of a surface cell has the functions of its bounding box if it fills at least this part of the box: for parts of any
/// shape the systems would be so ill-conditioned that one in eight balls on a floor has no answer.
const FILLED: f64 = 0.9;

/// The covered part of a cell: its bounding box, and the places, in the coordinates of the box, where the forces of its nodes act.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Covered {
    pub bound: Stretch,
    pub ends: Vec<[f64; 2]>,
}

impl Covered {
    /// From the corners of its pieces.
    fn new(kind: CellKind, bound: Stretch, corners: &[[f64; 2]]) -> Self {
        let corners: Vec<[f64; 2]> = corners.iter().map(|&xi| bound.of(xi)).collect();
        let of_box = kind.reference_nodes().iter().take(kind.nodes());
        let ends = of_box.map(|&[x, y, _]| nearest(kind.domain(), &corners, [x, y]));
        Self {
            bound,
            ends: ends.collect(),
        }
    }
}

/// The place of the convex hull of some points that is nearest to a place that does not lie inside it: on the line between two
/// of them. Distances are those in a square, or in an equilateral triangle, so that the order of the corners does not count.
fn nearest(domain: Domain, points: &[[f64; 2]], place: [f64; 2]) -> [f64; 2] {
    let less = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| {
        let straight = a[0] * b[0] + a[1] * b[1];
        match domain {
            Domain::Triangle => straight + 0.5 * (a[0] * b[1] + a[1] * b[0]),
            _ => straight,
        }
    };
    let off = |p: [f64; 2]| dot(less(p, place), less(p, place)).sqrt();
    let mut best = (f64::INFINITY, place);
    for (k, &a) in points.iter().enumerate() {
        for &b in &points[k..] {
            let along = less(b, a);
            let square = dot(along, along);
            let part = dot(less(place, a), along);
            let t = if square > 0.0 {
                (part / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let found = [0, 1].map(|d| a[d] + t * along[d]);
            if off(found) < best.0 {
                best = (off(found), found);
            }
        }
    }
    if best.0 > COVERED { best.1 } else { place }
}

/// The parts of the side that face the other one.
pub(super) struct Cover {
    /// Covered part of each facet.
    facets: BTreeMap<Facet, f64>,
    /// The covered part of each cell, where it has no hole.
    cells: BTreeMap<usize, Option<Covered>>,
}

impl Cover {
    pub fn new(all: &[Cell], pieces: &[Piece]) -> Self {
        let (mut facets, mut cells) = (BTreeMap::new(), BTreeMap::new());
        for of_cell in pieces.chunk_by(|a, b| a.cell == b.cell) {
            let cell = &all[of_cell[0].cell];
            let part: f64 = of_cell.iter().map(|piece| piece.part).sum();
            *facets.entry(cell.facet).or_insert(0.0) += part;
            let corners = of_cell.iter().flat_map(|piece| &piece.corners);
            let corners: Vec<[f64; 2]> = corners.copied().collect();
            let domain = cell.kind.domain();
            let bound = Stretch::to_whole(domain, &corners);
            let filled = match domain {
                Domain::Line => bound.part(domain) - part <= 0.5 * COVERED,
                _ => part >= FILLED * bound.part(domain),
            };
            let covered = || Covered::new(cell.kind, bound, &corners);
            cells.insert(of_cell[0].cell, filled.then(covered));
        }
        Self { facets, cells }
    }

    /// All of a facet faces the other side.
    pub fn facet(&self, facet: Facet) -> bool {
        self.facets[&facet] > 1.0 - COVERED
    }

    /// The covered part of a cell; `None` where it has a hole.
    pub fn of_cell(&self, cell: usize) -> Option<&Covered> {
        self.cells[&cell].as_ref()
    }
}

type Matrix = [Values; FUNCTIONS];

/// The functions ψ on one facet or cell.
pub(super) enum Basis {
    /// ψ = A N with the functions N of the facet.
    OfFacet(CellKind, Matrix),
    /// ψ = A h with the hats h of a stretch, and the places where the forces act.
    OfCell(CellKind, Covered, Matrix),
    /// Hats of the cell.
    Hats,
}

impl Basis {
    /// Biorthogonal to the functions of a facet, over points with areas; `None` unless all weights are positive.
    pub fn of_facet(kind: CellKind, points: impl Iterator<Item = ([f64; 2], f64)>) -> Option<Self> {
        let (weights, mass) = moments(points.map(|(xi, area)| (values(kind, xi), area)));
        let n = kind.nodes();
        let mean = weights.iter().sum::<f64>() / n as f64;
        let smallest = weights[..n].iter().fold(mean, |s, w| s.min(*w));
        let matrix = dual(weights, mass, n)?;
        (smallest > POSITIVE * mean).then_some(Self::OfFacet(kind, matrix))
    }

    /// For the covered part of a cell, with forces at its ends; `None` unless all weights are positive.
    pub fn of_cell(
        cell: &Cell,
        covered: &Covered,
        points: impl Iterator<Item = ([f64; 2], f64)>,
    ) -> Option<Self> {
        let Covered { bound, ends } = covered;
        let (kind, n) = (cell.kind, cell.kind.nodes());
        let points = points.map(|(xi, area)| (values(kind, bound.of(xi)), area));
        let (sums, mass) = moments(points);
        let (mut at_ends, mut of_ends) =
            ([[0.0; FUNCTIONS]; FUNCTIONS], [[0.0; FUNCTIONS]; FUNCTIONS]);
        for (i, &end) in ends.iter().enumerate() {
            of_ends[i] = values(kind, end);
            (0..n).for_each(|k| at_ends[k][i] = of_ends[i][k]);
        }
        let weights = inverse(at_ends, n).map(|row| product(&row, &sums));
        let inverse = inverse(mass, n);
        let column = |k: usize| std::array::from_fn(|l: usize| inverse[l][k]);
        let matrix = std::array::from_fn(|i| {
            std::array::from_fn(|k| weights[i] * product(&of_ends[i], &column(k)))
        });
        let positive = weights[..n].iter().all(|&weight| weight > 0.0);
        (positive && tame(&matrix)).then(|| Self::OfCell(kind, covered.clone(), matrix))
    }

    /// ψ of each node of a facet or cell at ξ; where the functions are hats, a node without a multiplier leaves its part to the
    /// others.
    pub fn values(&self, cell: &Cell, xi: [f64; 2], carries: &[bool]) -> Values {
        let dual = |kind: CellKind, xi: [f64; 2], matrix: &Matrix| {
            let functions = values(kind, xi);
            matrix.map(|row| product(&row, &functions))
        };
        match self {
            Self::OfFacet(kind, matrix) => dual(*kind, xi, matrix),
            Self::OfCell(kind, covered, matrix) => dual(*kind, covered.bound.of(xi), matrix),
            Self::Hats => hats(cell, xi, carries),
        }
    }

    /// Where on the facet the force of its k-th function acts: the value there of any function of the facet, in part of a cell of
    /// any linear one, is its mean with ψ. `None` for hats, whose forces are spread.
    pub fn acts_at(&self, k: usize) -> Option<[f64; 2]> {
        match self {
            Self::OfFacet(kind, _) => {
                let [x, y, _] = kind.reference_nodes()[k];
                Some([x, y])
            }
            Self::OfCell(_, covered, _) => Some(covered.bound.back(covered.ends[k])),
            Self::Hats => None,
        }
    }

    /// The share of each node in a point: positive functions that sum to one.
    pub fn shares(&self, cell: &Cell, xi: [f64; 2], carries: &[bool]) -> Values {
        match self {
            Self::OfFacet(kind, _) => values(*kind, xi),
            Self::OfCell(kind, covered, _) => values(*kind, covered.bound.of(xi)),
            Self::Hats => hats(cell, xi, carries),
        }
    }
}

/// Hats at a point; those of nodes without multipliers go to the others, in equal parts.
fn hats(cell: &Cell, xi: [f64; 2], carries: &[bool]) -> Values {
    let hats = cell.hats(xi);
    let carrying = carries.iter().filter(|c| **c).count();
    if carrying == carries.len() {
        return hats;
    }
    let lost: f64 = hats
        .iter()
        .zip(carries)
        .filter(|(_, c)| !**c)
        .map(|(h, _)| h)
        .sum();
    let mut shared = [0.0; FUNCTIONS];
    for ((shared, hat), _) in shared
        .iter_mut()
        .zip(hats)
        .zip(carries)
        .filter(|(_, c)| **c)
    {
        *shared = hat + lost / carrying as f64;
    }
    shared
}

/// ∫N and ∫NNᵀ over points with areas.
fn moments(points: impl Iterator<Item = (Values, f64)>) -> (Values, Matrix) {
    let (mut weights, mut mass) = ([0.0; FUNCTIONS], [[0.0; FUNCTIONS]; FUNCTIONS]);
    for (n, area) in points {
        for i in 0..FUNCTIONS {
            weights[i] += n[i] * area;
            for j in 0..FUNCTIONS {
                mass[i][j] += n[i] * n[j] * area;
            }
        }
    }
    (weights, mass)
}

/// Biorthogonal functions that exceed this somewhere belong to a covered part that fills its box too poorly.
const LARGEST: f64 = 50.0;

/// diag(∫N) M⁻¹ of the first `n` functions; `None` where that is singular.
fn dual(weights: Values, mass: Matrix, n: usize) -> Option<Matrix> {
    let mut matrix = inverse(mass, n);
    for (row, weight) in matrix.iter_mut().zip(weights) {
        row.iter_mut().for_each(|a| *a *= weight);
    }
    tame(&matrix).then_some(matrix)
}

/// Functions with these coefficients are nowhere too large; false for a singular matrix, which gives NaN.
fn tame(matrix: &Matrix) -> bool {
    matrix.iter().flatten().all(|a| a.abs() < LARGEST)
}

fn product(a: &Values, b: &Values) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inverse of the first `n` rows and columns by elimination without pivoting: of symmetric positive matrices, and of such as are
/// nearly the identity.
fn inverse(mut matrix: Matrix, n: usize) -> Matrix {
    let mut inverse = [[0.0; FUNCTIONS]; FUNCTIONS];
    for (i, row) in inverse.iter_mut().enumerate().take(n) {
        row[i] = 1.0;
    }
    for k in 0..n {
        let pivot = 1.0 / matrix[k][k];
        for j in 0..n {
            matrix[k][j] *= pivot;
            inverse[k][j] *= pivot;
        }
        for i in (0..n).filter(|&i| i != k) {
            let factor = matrix[i][k];
            for j in 0..n {
                matrix[i][j] -= factor * matrix[k][j];
                inverse[i][j] -= factor * inverse[k][j];
            }
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, flat};
    use crate::mesh::Cuboid;

    #[test]
    fn cells_are_the_parts_of_a_plane_facet_between_its_nodes() {
        for (cell, ends) in [
            (CellKind::Quad4, vec![[-1.0, 1.0]]),
            (CellKind::Quad8, vec![[-1.0, 0.0], [0.0, 1.0]]),
        ] {
            let body = flat(&[0.0, 1.0, 2.0], 1.0, cell);
            let facet = body.mesh.side("bottom").unwrap()[0];
            let cells = cells(&body.mesh, facet);
            let found = cells
                .iter()
                .map(|cell| [cell.places[0][0], cell.places[1][0]]);
            assert_eq!(found.collect::<Vec<_>>(), ends);
            for cell in cells {
                assert_eq!(cell.facet, facet);
                for (k, (&node, &xi)) in cell.nodes.iter().zip(&cell.places).enumerate() {
                    let place = body.mesh.facet_point(facet, &xi);
                    assert_eq!(body.mesh.points()[node], place);
                    let own = |i: usize| f64::from(u8::from(i == k));
                    assert_eq!(cell.hats(xi), std::array::from_fn(own));
                }
            }
        }
    }

    #[test]
    fn a_facet_of_space_is_a_cell_with_its_corners() {
        for (kind, corners, area) in [(CellKind::Tet4, 3, 0.5), (CellKind::Hex8, 4, 4.0)] {
            let cuboid = Cuboid {
                from: [0.0; 3],
                to: [1.0; 3],
                cells: [1; 3],
                cell: kind,
            };
            let body = body(cuboid.build().unwrap());
            let facet = body.mesh.side("top").unwrap()[0];
            let cells = cells(&body.mesh, facet);
            assert_eq!(cells.len(), 1);
            assert_eq!(cells[0].nodes.len(), corners);
            let rule = cells[0].rule(3);
            assert!((rule.map(|point| point.1).sum::<f64>() - area).abs() < 1e-14);
        }
    }

    /// Whether a facet of the plane is covered by some intervals, and their union.
    fn cover(ends: &[[f64; 2]]) -> (bool, Option<[f64; 2]>) {
        let body = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        let facet = body.mesh.side("bottom").unwrap()[0];
        let cells = cells(&body.mesh, facet);
        let piece = |&[from, to]: &[f64; 2]| Piece {
            cell: 0,
            corners: vec![[from, 0.0], [to, 0.0]],
            part: 0.5 * (to - from),
            opposite: None,
            points: Vec::new(),
        };
        let pieces: Vec<Piece> = ends.iter().map(piece).collect();
        let cover = Cover::new(&cells, &pieces);
        let whole = cover.of_cell(0);
        let ends = whole.map(|covered| [-1.0, 1.0].map(|x| covered.bound.back([x, 0.0])[0]));
        (cover.facet(facet), ends)
    }

    #[test]
    fn pieces_that_join_cover_an_interval_and_all_of_them_the_facet() {
        for (ends, whole, interval) in [
            ([[-1.0, 0.2], [0.2, 1.0]], true, Some([-1.0, 1.0])),
            ([[-0.5, 0.2], [0.2, 0.9]], false, Some([-0.5, 0.9])),
            ([[-1.0, 0.2], [0.3, 1.0]], false, None),
        ] {
            let (covered, found) = cover(&ends);
            assert_eq!((covered, found.is_some()), (whole, interval.is_some()));
            for (a, b) in found
                .into_iter()
                .flatten()
                .zip(interval.into_iter().flatten())
            {
                assert!((a - b).abs() < 1e-15);
            }
        }
        // a billionth is rounding, for the facet and for the place
        assert!(cover(&[[-1.0, 1.0 - 1.8e-9]]).0);
        assert!(!cover(&[[-1.0, 1.0 - 2.2e-9]]).0);
        assert!(cover(&[[-1.0, 0.0], [0.95e-9, 0.5]]).1.is_some());
        assert!(cover(&[[-1.0, 0.0], [1.05e-9, 0.5]]).1.is_none());
    }

    #[test]
    fn a_stretch_takes_the_smallest_box_or_triangle_to_the_whole() {
        let points = [[0.1, 0.2], [0.5, 0.3], [0.2, 0.4]];
        // ξ ≥ 0.1, η ≥ 0.2, ξ + η ≤ 0.8: edges of length 0.5
        let triangle = Stretch::to_whole(Domain::Triangle, &points);
        assert!((triangle.part(Domain::Triangle) - 0.25).abs() < 1e-15);
        let square = Stretch::to_whole(Domain::Square, &points);
        assert!((square.part(Domain::Square) - 0.2 * 0.1).abs() < 1e-15);
        for stretch in [triangle, square] {
            for point in points {
                let same = stretch.back(stretch.of(point));
                assert!((0..2).all(|d| (same[d] - point[d]).abs() < 1e-15));
            }
        }
        for (stretch, low) in [(triangle, [0.0, 0.0]), (square, [-1.0, -1.0])] {
            let found = stretch.of([0.1, 0.2]);
            assert!((0..2).all(|d| (found[d] - low[d]).abs() < 1e-14));
        }
    }

    #[test]
    fn functions_of_a_covered_part_are_biorthogonal_to_its_hats() {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [1.0; 3],
            cells: [1; 3],
            cell: CellKind::Hex8,
        };
        let body = body(cuboid.build().unwrap());
        let facet = body.mesh.side("top").unwrap()[0];
        let cell = &cells(&body.mesh, facet)[0];
        let part = Stretch::to_whole(Domain::Square, &[[-0.2, -1.0], [0.9, 0.3]]);
        let points: Vec<([f64; 2], f64)> = cell
            .rule(5)
            .map(|(xi, weight)| (part.back(xi), weight * part.part(Domain::Square)))
            .collect();
        let all = [[-0.2, -1.0], [0.9, -1.0], [0.9, 0.3], [-0.2, 0.3]];
        let part = Covered::new(CellKind::Quad4, part, &all);
        let basis = Basis::of_cell(cell, &part, points.iter().copied()).unwrap();
        let mut products = [[0.0; FUNCTIONS]; FUNCTIONS];
        let mut weights = [0.0; FUNCTIONS];
        for &(xi, area) in &points {
            let psi = basis.values(cell, xi, &[true; 4]);
            let hats = basis.shares(cell, xi, &[true; 4]);
            assert!((psi.iter().sum::<f64>() - 1.0).abs() < 1e-13);
            for i in 0..4 {
                weights[i] += area * hats[i];
                for j in 0..4 {
                    products[i][j] += area * psi[i] * hats[j];
                }
            }
        }
        for (i, row) in products.into_iter().enumerate() {
            for (j, product) in row.into_iter().enumerate() {
                let expected = if i == j { weights[i] } else { 0.0 };
                assert!((product - expected).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn forces_of_nodes_act_on_what_is_covered() {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [1.0; 3],
            cells: [1; 3],
            cell: CellKind::Hex8,
        };
        let body = body(cuboid.build().unwrap());
        let facet = body.mesh.side("top").unwrap()[0];
        let cell = &cells(&body.mesh, facet)[0];
        // a square without its last corner, ξ + η ≤ 1.4, of which the middle of the cut is nearest to the corner
        let corners = [
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 0.4],
            [0.4, 1.0],
            [-1.0, 1.0],
        ];
        let triangles = corners[1..]
            .windows(2)
            .map(|ends| [corners[0], ends[0], ends[1]]);
        let mut points = Vec::new();
        for [a, b, c] in triangles {
            let edge = |p: [f64; 2]| [p[0] - a[0], p[1] - a[1]];
            let (b, c) = (edge(b), edge(c));
            let double = b[0] * c[1] - b[1] * c[0];
            for point in rule(CellKind::Tri3, 6) {
                let [u, v, _] = point.xi;
                let xi = [0, 1].map(|d| a[d] + u * b[d] + v * c[d]);
                points.push((xi, double * point.weight));
            }
        }
        let piece = Piece {
            cell: 0,
            opposite: None,
            corners: corners.to_vec(),
            part: points.iter().map(|point| point.1).sum::<f64>() / 4.0,
            points: points.clone(),
        };
        let cover = Cover::new(std::slice::from_ref(cell), &[piece]);
        let covered = cover.of_cell(0).unwrap();
        let basis = Basis::of_cell(cell, covered, points.iter().copied()).unwrap();
        let expected = [[-1.0, -1.0], [1.0, -1.0], [0.7, 0.7], [-1.0, 1.0]];
        for (i, expected) in expected.into_iter().enumerate() {
            let mut sums = [0.0; 4];
            for &(xi, area) in &points {
                let psi = basis.values(cell, xi, &[true; 4]);
                assert!((psi.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                let parts = [1.0, xi[0], xi[1], xi[0] * xi[1]];
                sums = std::array::from_fn(|k| sums[k] + area * psi[i] * parts[k]);
            }
            let [weight, x, y, both] = sums;
            assert!(weight > 0.0);
            let at = [x, y, both].map(|moment| moment / weight);
            let [x, y] = expected;
            for (found, expected) in at.into_iter().zip([x, y, x * y]) {
                assert!((found - expected).abs() < 1e-12, "{i} {found} {expected}");
            }
        }
    }

    #[test]
    fn a_place_is_near_the_piece_that_it_lies_in() {
        let piece = |corners: &[[f64; 2]]| Piece {
            cell: 0,
            opposite: None,
            corners: corners.to_vec(),
            part: 0.5,
            points: Vec::new(),
        };
        let triangle = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]];
        let mut turned = triangle;
        turned.reverse();
        for triangle in [triangle, turned] {
            let piece = piece(&triangle);
            for (xi, near) in [
                ([0.1, 0.1], true),
                ([0.2, -0.09], true),
                ([0.2, -0.11], false),
                ([0.31, 0.31], true),
                ([0.33, 0.33], false),
            ] {
                assert_eq!(piece.near(xi), near, "{xi:?}");
            }
        }
        let interval = piece(&[[-0.5, 0.0], [0.2, 0.0]]);
        for (x, near) in [
            (-0.61, false),
            (-0.59, true),
            (0.0, true),
            (0.29, true),
            (0.31, false),
        ] {
            assert_eq!(interval.near([x, 0.0]), near, "{x}");
        }
    }

    #[test]
    fn a_node_that_carries_nothing_leaves_its_hat_to_the_others() {
        let body = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        let facet = body.mesh.side("bottom").unwrap()[0];
        let cell = &cells(&body.mesh, facet)[0];
        let both = Basis::Hats.values(cell, [0.5, 0.0], &[true, true]);
        assert_eq!(both[..2], [0.25, 0.75]);
        let one = Basis::Hats.values(cell, [0.5, 0.0], &[true, false]);
        assert_eq!(one[..2], [1.0, 0.0]);
    }

    #[test]
    fn the_nearest_covered_place_does_not_depend_on_the_order_of_corners() {
        // parts of a triangle by the shares of its corners
        let part = [[0.5, 0.3, 0.2], [0.2, 0.7, 0.1], [0.3, 0.4, 0.3]];
        let ends = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let found = |order: [usize; 3]| {
            let place = |shares: [f64; 3]| [shares[order[1]], shares[order[2]]];
            let corners = part.map(place);
            ends.map(|end| {
                let [x, y] = nearest(Domain::Triangle, &corners, place(end));
                let mut shares = [0.0; 3];
                for (corner, share) in order.into_iter().zip([1.0 - x - y, x, y]) {
                    shares[corner] = share;
                }
                shares
            })
        };
        let first = found([0, 1, 2]);
        for order in [[1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]] {
            let all = found(order).into_iter().flatten();
            let off = all.zip(first.into_iter().flatten());
            assert!(off.map(|(a, b)| (a - b).abs()).all(|off| off < 1e-14));
        }
    }
}
