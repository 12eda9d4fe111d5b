//! Reference cells as data: nodes, basis, facets and numbering of each kind.
//!
//! The basis of every kind is `Nᵢ(ξ) = Σₖ Cₖᵢ mₖ(ξ)` with the monomials mₖ of the kind and C the inverse of their
//! values at the reference nodes, so a new kind is a new table and no new formula.
//!
//! Conventions: the reference triangle has the corners (0,0) (1,0) (0,1), the reference quadrilateral is [−1,1]²,
//! the reference line is [−1,1]. Corner nodes come first, then the middles of the edges 01 12 20 (01 12 23 30), then the
//! centre, as in VTK and Gmsh. A facet lists its ends in the order that keeps the cell on the left, then its middle.
//! Invariant: a cell whose Jacobian is positive is numbered counter-clockwise.

use std::sync::LazyLock;

/// Largest number of nodes of any [`CellKind`]: the length of buffers on the stack.
pub const MAX_CELL_NODES: usize = 9;

/// Largest number of nodes of any [`FacetKind`].
pub const MAX_FACET_NODES: usize = 3;

/// Kinds of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CellKind {
    /// Linear triangle.
    Tri3,
    /// Quadratic triangle.
    Tri6,
    /// Bilinear quadrilateral.
    Quad4,
    /// Serendipity quadrilateral.
    Quad8,
    /// Biquadratic quadrilateral.
    Quad9,
}

/// Kinds of facets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FacetKind {
    /// Two end nodes.
    Line2,
    /// Two end nodes, then the middle node.
    Line3,
}

struct Cell {
    name: &'static str,
    dimension: usize,
    order: usize,
    corners: usize,
    nodes: &'static [[f64; 3]],
    facet_kind: FacetKind,
    facets: &'static [&'static [usize]],
    /// Local node at each place of the same cell numbered the other way round.
    mirror: &'static [usize],
    /// Neighbours of each corner along its edges, in the order that makes their determinant positive.
    corner_edges: &'static [&'static [usize]],
    /// That determinant for edges of length one in the regular cell.
    regular: f64,
    /// Where the sign of the Jacobian is checked beside the nodes.
    interior: &'static [[f64; 3]],
    basis: LazyLock<Basis>,
}

struct FacetData {
    name: &'static str,
    dimension: usize,
    order: usize,
    corners: usize,
    nodes: &'static [[f64; 3]],
    basis: LazyLock<Basis>,
}

const TRIANGLE: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
];
const SQUARE: [[f64; 3]; 9] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0],
];
const LINE: [[f64; 3]; 3] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]];

/// Exponents of ξ, η, ζ in the monomials of each kind.
const P1: [[u8; 3]; 3] = [[0, 0, 0], [1, 0, 0], [0, 1, 0]];
const P2: [[u8; 3]; 6] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [2, 0, 0],
    [1, 1, 0],
    [0, 2, 0],
];
const Q1: [[u8; 3]; 4] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]];
/// The first eight are those of the serendipity cell.
const Q2: [[u8; 3]; 9] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [1, 1, 0],
    [2, 0, 0],
    [0, 2, 0],
    [2, 1, 0],
    [1, 2, 0],
    [2, 2, 0],
];
const L2: [[u8; 3]; 3] = [[0, 0, 0], [1, 0, 0], [2, 0, 0]];

const THIRD: f64 = 1.0 / 3.0;
const SIXTH: f64 = 1.0 / 6.0;
/// Points of the triangle rules of degree 1, 2 and 4. The Jacobian of the quadratic triangle has degree 2.
const TRIANGLE_INTERIOR: [[f64; 3]; 10] = [
    [THIRD, THIRD, 0.0],
    [SIXTH, SIXTH, 0.0],
    [4.0 * SIXTH, SIXTH, 0.0],
    [SIXTH, 4.0 * SIXTH, 0.0],
    [0.445_948_490_915_965, 0.445_948_490_915_965, 0.0],
    [0.108_103_018_168_070, 0.445_948_490_915_965, 0.0],
    [0.445_948_490_915_965, 0.108_103_018_168_070, 0.0],
    [0.091_576_213_509_771, 0.091_576_213_509_771, 0.0],
    [0.816_847_572_980_459, 0.091_576_213_509_771, 0.0],
    [0.091_576_213_509_771, 0.816_847_572_980_459, 0.0],
];
/// 1/√3 and √(3/5).
const GAUSS_2: f64 = 0.577_350_269_189_625_8;
const GAUSS_3: f64 = 0.774_596_669_241_483_4;
/// Points of the 2 × 2 and 3 × 3 Gauss rules.
const SQUARE_INTERIOR: [[f64; 3]; 13] = [
    [0.0, 0.0, 0.0],
    [-GAUSS_2, -GAUSS_2, 0.0],
    [GAUSS_2, -GAUSS_2, 0.0],
    [-GAUSS_2, GAUSS_2, 0.0],
    [GAUSS_2, GAUSS_2, 0.0],
    [-GAUSS_3, -GAUSS_3, 0.0],
    [0.0, -GAUSS_3, 0.0],
    [GAUSS_3, -GAUSS_3, 0.0],
    [-GAUSS_3, 0.0, 0.0],
    [GAUSS_3, 0.0, 0.0],
    [-GAUSS_3, GAUSS_3, 0.0],
    [0.0, GAUSS_3, 0.0],
    [GAUSS_3, GAUSS_3, 0.0],
];

const TRIANGLE_EDGES: &[&[usize]] = &[&[1, 2], &[2, 0], &[0, 1]];
const SQUARE_EDGES: &[&[usize]] = &[&[1, 3], &[2, 0], &[3, 1], &[0, 2]];
/// √3/2, the sine of 60°.
const EQUILATERAL: f64 = 0.866_025_403_784_438_6;

static TRI3: Cell = Cell {
    name: "tri3",
    dimension: 2,
    order: 1,
    corners: 3,
    nodes: TRIANGLE.split_at(3).0,
    facet_kind: FacetKind::Line2,
    facets: &[&[0, 1], &[1, 2], &[2, 0]],
    mirror: &[0, 2, 1],
    corner_edges: TRIANGLE_EDGES,
    regular: EQUILATERAL,
    interior: TRIANGLE_INTERIOR.split_at(1).0,
    basis: LazyLock::new(|| Basis::new(&TRIANGLE[..3], &P1)),
};
static TRI6: Cell = Cell {
    name: "tri6",
    dimension: 2,
    order: 2,
    corners: 3,
    nodes: &TRIANGLE,
    facet_kind: FacetKind::Line3,
    facets: &[&[0, 1, 3], &[1, 2, 4], &[2, 0, 5]],
    mirror: &[0, 2, 1, 5, 4, 3],
    corner_edges: TRIANGLE_EDGES,
    regular: EQUILATERAL,
    interior: &TRIANGLE_INTERIOR,
    basis: LazyLock::new(|| Basis::new(&TRIANGLE, &P2)),
};
static QUAD4: Cell = Cell {
    name: "quad4",
    dimension: 2,
    order: 1,
    corners: 4,
    nodes: SQUARE.split_at(4).0,
    facet_kind: FacetKind::Line2,
    facets: &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
    mirror: &[0, 3, 2, 1],
    corner_edges: SQUARE_EDGES,
    regular: 1.0,
    interior: SQUARE_INTERIOR.split_at(1).0,
    basis: LazyLock::new(|| Basis::new(&SQUARE[..4], &Q1)),
};
static QUAD8: Cell = Cell {
    name: "quad8",
    dimension: 2,
    order: 2,
    corners: 4,
    nodes: SQUARE.split_at(8).0,
    facet_kind: FacetKind::Line3,
    facets: &[&[0, 1, 4], &[1, 2, 5], &[2, 3, 6], &[3, 0, 7]],
    mirror: &[0, 3, 2, 1, 7, 6, 5, 4],
    corner_edges: SQUARE_EDGES,
    regular: 1.0,
    interior: &SQUARE_INTERIOR,
    basis: LazyLock::new(|| Basis::new(&SQUARE[..8], &Q2[..8])),
};
static QUAD9: Cell = Cell {
    name: "quad9",
    dimension: 2,
    order: 2,
    corners: 4,
    nodes: &SQUARE,
    facet_kind: FacetKind::Line3,
    facets: &[&[0, 1, 4], &[1, 2, 5], &[2, 3, 6], &[3, 0, 7]],
    mirror: &[0, 3, 2, 1, 7, 6, 5, 4, 8],
    corner_edges: SQUARE_EDGES,
    regular: 1.0,
    interior: &SQUARE_INTERIOR,
    basis: LazyLock::new(|| Basis::new(&SQUARE, &Q2)),
};
static LINE2: FacetData = FacetData {
    name: "line2",
    dimension: 1,
    order: 1,
    corners: 2,
    nodes: LINE.split_at(2).0,
    basis: LazyLock::new(|| Basis::new(&LINE[..2], &L2[..2])),
};
static LINE3: FacetData = FacetData {
    name: "line3",
    dimension: 1,
    order: 2,
    corners: 2,
    nodes: &LINE,
    basis: LazyLock::new(|| Basis::new(&LINE, &L2)),
};

impl CellKind {
    /// Every kind.
    pub const ALL: [Self; 5] = [
        Self::Tri3,
        Self::Tri6,
        Self::Quad4,
        Self::Quad8,
        Self::Quad9,
    ];

    fn data(self) -> &'static Cell {
        match self {
            Self::Tri3 => &TRI3,
            Self::Tri6 => &TRI6,
            Self::Quad4 => &QUAD4,
            Self::Quad8 => &QUAD8,
            Self::Quad9 => &QUAD9,
        }
    }

    /// The name in a case file, such as `quad4`.
    pub fn name(self) -> &'static str {
        self.data().name
    }

    /// The kind of that name; `None` when there is none.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Nodes per cell.
    pub fn nodes(self) -> usize {
        self.data().nodes.len()
    }

    /// Dimension of the reference cell.
    pub fn dimension(self) -> usize {
        self.data().dimension
    }

    /// 1 linear, 2 quadratic.
    pub fn order(self) -> usize {
        self.data().order
    }

    /// Number of corner nodes; they come first.
    pub fn corners(self) -> usize {
        self.data().corners
    }

    /// Kind of all facets.
    pub fn facet_kind(self) -> FacetKind {
        self.data().facet_kind
    }

    /// Local nodes of each facet, in the order of [`FacetKind`], the cell on the left.
    pub fn facets(self) -> &'static [&'static [usize]] {
        self.data().facets
    }

    /// Reference coordinates of the nodes, (nodes, 3), missing coordinates zero.
    pub fn reference_nodes(self) -> &'static [[f64; 3]] {
        self.data().nodes
    }

    /// Local node at each place of the same cell numbered the other way round.
    pub fn mirror(self) -> &'static [usize] {
        self.data().mirror
    }

    /// Neighbours of each corner along its edges, in the order that makes the determinant of the edges positive.
    pub fn corner_edges(self) -> &'static [&'static [usize]] {
        self.data().corner_edges
    }

    /// Values Nᵢ(ξ) of the shape functions.
    ///
    /// Shapes: `xi` at least (dimension,), further entries are ignored; `values` at least (nodes,), the first are written.
    pub fn shape(self, xi: &[f64], values: &mut [f64]) {
        debug_assert!(xi.len() >= self.dimension() && values.len() >= self.nodes());
        self.data().basis.values(xi, values);
    }

    /// Gradients ∂Nᵢ/∂ξ of the shape functions in reference coordinates.
    ///
    /// Shapes: `xi` as in [`Self::shape`]; `gradients` at least (nodes, D), the first are written, D = dimension.
    pub fn gradients<const D: usize>(self, xi: &[f64], gradients: &mut [[f64; D]]) {
        debug_assert!(D == self.dimension());
        debug_assert!(xi.len() >= D && gradients.len() >= self.nodes());
        self.data().basis.gradients(xi, gradients);
    }

    /// Points of the reference cell inside which the Jacobian must be positive: those of the usual quadrature rules.
    pub(crate) fn interior(self) -> &'static [[f64; 3]] {
        self.data().interior
    }

    /// Determinant of the unit vectors along the edges of a corner of the regular cell.
    pub(crate) fn regular(self) -> f64 {
        self.data().regular
    }
}

impl FacetKind {
    /// Every kind.
    pub const ALL: [Self; 2] = [Self::Line2, Self::Line3];

    fn data(self) -> &'static FacetData {
        match self {
            Self::Line2 => &LINE2,
            Self::Line3 => &LINE3,
        }
    }

    /// Its name, such as `line2`.
    pub fn name(self) -> &'static str {
        self.data().name
    }

    /// Nodes per facet.
    pub fn nodes(self) -> usize {
        self.data().nodes.len()
    }

    /// Dimension of the reference facet.
    pub fn dimension(self) -> usize {
        self.data().dimension
    }

    /// 1 linear, 2 quadratic.
    pub fn order(self) -> usize {
        self.data().order
    }

    /// Number of corner (end) nodes; they come first.
    pub fn corners(self) -> usize {
        self.data().corners
    }

    /// Reference coordinates of the nodes, (nodes, 3), missing coordinates zero.
    pub fn reference_nodes(self) -> &'static [[f64; 3]] {
        self.data().nodes
    }

    /// Values Nᵢ(ξ) of the shape functions, ξ in [−1, 1].
    ///
    /// Shapes: `xi` at least (dimension,), further entries are ignored; `values` at least (nodes,), the first are written.
    pub fn shape(self, xi: &[f64], values: &mut [f64]) {
        debug_assert!(xi.len() >= self.dimension() && values.len() >= self.nodes());
        self.data().basis.values(xi, values);
    }

    /// Derivatives ∂Nᵢ/∂ξ in reference coordinates.
    ///
    /// Shapes: `xi` as in [`Self::shape`]; `gradients` at least (nodes, E), the first are written, E ≥ dimension and the
    /// entries beyond the dimension are zero.
    pub fn gradients<const E: usize>(self, xi: &[f64], gradients: &mut [[f64; E]]) {
        debug_assert!(E >= self.dimension());
        debug_assert!(xi.len() >= self.dimension() && gradients.len() >= self.nodes());
        self.data().basis.gradients(xi, gradients);
    }
}

/// Polynomials that are one at their own node and zero at the others.
struct Basis {
    exponents: &'static [[u8; 3]],
    /// C, (monomials, nodes).
    coefficients: Vec<f64>,
}

impl Basis {
    /// Inverts the values V (nodes, monomials) of the monomials at the nodes.
    fn new(nodes: &[[f64; 3]], exponents: &'static [[u8; 3]]) -> Self {
        let n = nodes.len();
        let mut left: Vec<Vec<f64>> = nodes
            .iter()
            .map(|node| exponents.iter().map(|&e| monomial(node, e)).collect())
            .collect();
        let mut right: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
            .collect();
        for k in 0..n {
            let pivot = (k..n)
                .max_by(|&a, &b| left[a][k].abs().total_cmp(&left[b][k].abs()))
                .unwrap_or(k);
            left.swap(k, pivot);
            right.swap(k, pivot);
            let scale = 1.0 / left[k][k];
            for j in 0..n {
                left[k][j] *= scale;
                right[k][j] *= scale;
            }
            for i in (0..n).filter(|&i| i != k) {
                let factor = left[i][k];
                for j in 0..n {
                    left[i][j] -= factor * left[k][j];
                    right[i][j] -= factor * right[k][j];
                }
            }
        }
        // The coefficients of all kinds are multiples of 1/8: rounding to them removes the error of the elimination,
        // so that the values at the nodes are exactly zero and one.
        let coefficients = right
            .concat()
            .iter()
            .map(|c| (8.0 * c).round() / 8.0)
            .collect();
        Self {
            exponents,
            coefficients,
        }
    }

    fn values(&self, xi: &[f64], values: &mut [f64]) {
        let n = self.exponents.len();
        values[..n].fill(0.0);
        for (&exponents, row) in self.exponents.iter().zip(self.coefficients.chunks_exact(n)) {
            let m = monomial(xi, exponents);
            for (value, c) in values.iter_mut().zip(row) {
                *value += c * m;
            }
        }
    }

    fn gradients<const D: usize>(&self, xi: &[f64], gradients: &mut [[f64; D]]) {
        let n = self.exponents.len();
        gradients[..n].fill([0.0; D]);
        for (&exponents, row) in self.exponents.iter().zip(self.coefficients.chunks_exact(n)) {
            let slope: [f64; D] = std::array::from_fn(|d| {
                let mut lower = exponents;
                match exponents.get(d) {
                    Some(&e) if e > 0 => {
                        lower[d] = e - 1;
                        f64::from(e) * monomial(xi, lower)
                    }
                    _ => 0.0,
                }
            });
            for (gradient, c) in gradients.iter_mut().zip(row) {
                for d in 0..D {
                    gradient[d] += c * slope[d];
                }
            }
        }
    }
}

/// ξ^a η^b ζ^c; coordinates beyond the last count as one.
fn monomial(xi: &[f64], exponents: [u8; 3]) -> f64 {
    xi.iter()
        .zip(exponents)
        .map(|(&x, e)| x.powi(i32::from(e)))
        .product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn values(kind: CellKind, xi: [f64; 2]) -> Vec<f64> {
        let mut values = vec![f64::NAN; kind.nodes()];
        kind.shape(&xi, &mut values);
        values
    }

    #[test]
    fn names_lead_back_to_their_kind() {
        for kind in CellKind::ALL {
            assert_eq!(CellKind::from_name(kind.name()), Some(kind));
            assert!(kind.nodes() <= MAX_CELL_NODES);
        }
        assert_eq!(CellKind::from_name("quad5"), None);
    }

    #[test]
    fn each_shape_function_is_one_at_its_own_node_only() {
        for kind in CellKind::ALL {
            for (i, node) in kind.reference_nodes().iter().enumerate() {
                let mut at = vec![f64::NAN; kind.nodes()];
                kind.shape(node, &mut at);
                for (j, &value) in at.iter().enumerate() {
                    assert_eq!(value, f64::from(u8::from(i == j)), "{kind:?} {i} {j}");
                }
            }
        }
        for kind in FacetKind::ALL {
            for (i, node) in kind.reference_nodes().iter().enumerate() {
                let mut at = vec![f64::NAN; kind.nodes()];
                kind.shape(node, &mut at);
                for (j, &value) in at.iter().enumerate() {
                    assert_eq!(value, f64::from(u8::from(i == j)), "{kind:?} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn the_serendipity_corner_is_the_textbook_formula() {
        let (x, y) = (0.3, -0.7);
        let expected = -0.25 * (1.0 - x) * (1.0 - y) * (1.0 + x + y);
        let computed = values(CellKind::Quad8, [x, y])[0];
        assert!((computed - expected).abs() < 1e-15);
    }

    #[test]
    fn facet_nodes_lie_on_an_edge_of_the_reference_cell_in_facet_order() {
        for kind in CellKind::ALL {
            let facet_kind = kind.facet_kind();
            for local in kind.facets() {
                assert_eq!(local.len(), facet_kind.nodes());
                let at = |i: usize| kind.reference_nodes()[local[i]];
                for (i, xi) in facet_kind.reference_nodes().iter().enumerate() {
                    let t = 0.5 * (1.0 + xi[0]);
                    for d in 0..2 {
                        assert_eq!(at(i)[d], at(0)[d] * (1.0 - t) + at(1)[d] * t);
                    }
                }
                // The centre of the cell is on the left.
                let (a, b, c) = (at(0), at(1), kind.interior()[0]);
                let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                assert!(cross > 0.0);
            }
        }
    }

    #[test]
    fn the_mirror_maps_the_reference_cell_onto_itself() {
        // Both reference cells are symmetric under the exchange of ξ and η, which keeps corner 0.
        for kind in CellKind::ALL {
            for (place, &from) in kind.mirror().iter().enumerate() {
                let [x, y, _] = kind.reference_nodes()[from];
                assert_eq!(kind.reference_nodes()[place], [y, x, 0.0], "{kind:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn shape_functions_sum_to_one_and_reproduce_linear_functions(x in -1.0..1.0, y in -1.0..1.0) {
            for kind in CellKind::ALL {
                let values = values(kind, [x, y]);
                let sum = |d: usize| -> f64 {
                    values.iter().zip(kind.reference_nodes()).map(|(v, n)| v * n[d]).sum()
                };
                // A handful of operations on numbers of size one to ten.
                prop_assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                prop_assert!((sum(0) - x).abs() < 1e-14);
                prop_assert!((sum(1) - y).abs() < 1e-14);
            }
        }

        #[test]
        fn gradients_are_the_difference_quotients(x in -1.0..1.0, y in -1.0..1.0) {
            // Central differences of polynomials of degree at most two in each variable are exact but for rounding / h.
            let h = 1e-3;
            for kind in CellKind::ALL {
                let mut gradients = vec![[f64::NAN; 2]; kind.nodes()];
                kind.gradients(&[x, y], &mut gradients);
                let right = values(kind, [x + h, y]);
                let left = values(kind, [x - h, y]);
                let above = values(kind, [x, y + h]);
                let below = values(kind, [x, y - h]);
                for i in 0..kind.nodes() {
                    prop_assert!((gradients[i][0] - (right[i] - left[i]) / (2.0 * h)).abs() < 1e-11);
                    prop_assert!((gradients[i][1] - (above[i] - below[i]) / (2.0 * h)).abs() < 1e-11);
                }
            }
            for kind in FacetKind::ALL {
                let at = |x: f64| { let mut v = vec![0.0; kind.nodes()]; kind.shape(&[x], &mut v); v };
                let mut gradients = vec![[f64::NAN; 1]; kind.nodes()];
                kind.gradients(&[x], &mut gradients);
                for (i, gradient) in gradients.iter().enumerate() {
                    prop_assert!((gradient[0] - (at(x + h)[i] - at(x - h)[i]) / (2.0 * h)).abs() < 1e-11);
                }
            }
        }
    }
}
