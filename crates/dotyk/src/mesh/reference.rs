//! Reference cells as data: one entry for each kind of cell says everything that is known of it.
//!
//! Conventions: the reference line is [−1, 1], square and cube are its powers, triangle and tetrahedron have a corner at
//! the origin and one at the end of each unit vector. Corner nodes come first, then the middles of the edges 01 12 20
//! (01 12 23 30), then the centre, as in VTK and Gmsh. A facet is a cell of one dimension less: its nodes are listed in the
//! order of its own kind, such that its outward normal is its tangent turned by −90° (the cell on the left), in space the
//! product of its two tangents (counter-clockwise from outside).
//! Invariant: a cell whose Jacobian is positive is numbered counter-clockwise.

/// Kinds of cells; a line is a facet of the plane, a triangle or a square one of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CellKind {
    /// Two end nodes.
    Line2,
    /// Two end nodes, then the middle node.
    Line3,
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
    /// Linear tetrahedron.
    Tet4,
    /// Trilinear hexahedron.
    Hex8,
}

/// Shapes of reference cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Domain {
    /// [−1, 1].
    Line,
    /// Corners (0,0) (1,0) (0,1).
    Triangle,
    /// [−1, 1]².
    Square,
    /// Corners (0,0,0) (1,0,0) (0,1,0) (0,0,1).
    Tetrahedron,
    /// [−1, 1]³.
    Cube,
}

/// What cells of one shape have in common.
pub(crate) struct DomainData {
    pub dimension: usize,
    pub volume: f64,
    pub centre: [f64; 3],
    /// Neighbours of each corner along its edges, in the order that makes their determinant positive.
    pub corner_edges: &'static [&'static [usize]],
    /// That determinant for edges of length one in the regular cell.
    pub regular: f64,
}

/// One kind of cell.
pub(crate) struct CellData {
    /// In a case file.
    pub name: &'static str,
    pub domain: Domain,
    /// 1 linear, 2 quadratic.
    pub order: usize,
    pub nodes: &'static [[f64; 3]],
    /// Exponents of ξ, η, ζ in the monomials that span its shape functions.
    pub monomials: &'static [[u8; 3]],
    /// Kind and local nodes of each facet.
    pub facets: &'static [(CellKind, &'static [usize])],
    /// Local node at each place of the same cell numbered the other way round.
    pub mirror: &'static [usize],
    /// Where the sign of the Jacobian is checked beside the nodes: at the points of the usual quadrature rules.
    pub interior: &'static [[f64; 3]],
    /// Degree that integrates the stiffness of an undistorted cell exactly, and that of a curved one well.
    pub stiffness_degree: usize,
    /// Stress is sampled at the corners, drawn towards the centre by this factor: where it is most accurate. Zero: at the
    /// centre alone.
    pub sampling: f64,
    /// Its numbers in VTK's and Gmsh's files; both list the nodes in the order of `nodes`.
    pub vtk: u8,
    pub gmsh: u8,
}

impl Domain {
    pub(crate) const fn data(self) -> &'static DomainData {
        match self {
            Self::Line => &DomainData {
                dimension: 1,
                volume: 2.0,
                centre: [0.0; 3],
                corner_edges: &[&[1], &[0]],
                regular: 1.0,
            },
            Self::Triangle => &DomainData {
                dimension: 2,
                volume: 0.5,
                centre: [THIRD, THIRD, 0.0],
                corner_edges: &[&[1, 2], &[2, 0], &[0, 1]],
                regular: EQUILATERAL,
            },
            Self::Square => &DomainData {
                dimension: 2,
                volume: 4.0,
                centre: [0.0; 3],
                corner_edges: &[&[1, 3], &[2, 0], &[3, 1], &[0, 2]],
                regular: 1.0,
            },
            Self::Tetrahedron => &DomainData {
                dimension: 3,
                volume: SIXTH,
                centre: [0.25; 3],
                corner_edges: &[&[1, 2, 3], &[2, 0, 3], &[0, 1, 3], &[0, 2, 1]],
                regular: std::f64::consts::FRAC_1_SQRT_2,
            },
            Self::Cube => &DomainData {
                dimension: 3,
                volume: 8.0,
                centre: [0.0; 3],
                corner_edges: &[
                    &[1, 3, 4],
                    &[2, 0, 5],
                    &[3, 1, 6],
                    &[0, 2, 7],
                    &[7, 5, 0],
                    &[4, 6, 1],
                    &[5, 7, 2],
                    &[6, 4, 3],
                ],
                regular: 1.0,
            },
        }
    }
}

impl CellKind {
    /// Every kind.
    pub const ALL: [Self; 9] = [
        Self::Line2,
        Self::Line3,
        Self::Tri3,
        Self::Tri6,
        Self::Quad4,
        Self::Quad8,
        Self::Quad9,
        Self::Tet4,
        Self::Hex8,
    ];

    pub(crate) const fn data(self) -> &'static CellData {
        match self {
            Self::Line2 => &LINE2,
            Self::Line3 => &LINE3,
            Self::Tri3 => &TRI3,
            Self::Tri6 => &TRI6,
            Self::Quad4 => &QUAD4,
            Self::Quad8 => &QUAD8,
            Self::Quad9 => &QUAD9,
            Self::Tet4 => &TET4,
            Self::Hex8 => &HEX8,
        }
    }
}

const LINE2: CellData = CellData {
    name: "line2",
    domain: Domain::Line,
    order: 1,
    nodes: LINE.split_at(2).0,
    monomials: L2.split_at(2).0,
    facets: &[],
    mirror: &[1, 0],
    interior: LINE.split_at(2).1,
    stiffness_degree: 1,
    sampling: 0.0,
    vtk: 3,
    gmsh: 1,
};
const LINE3: CellData = CellData {
    name: "line3",
    domain: Domain::Line,
    order: 2,
    nodes: &LINE,
    monomials: &L2,
    facets: &[],
    mirror: &[1, 0, 2],
    interior: LINE.split_at(2).1,
    stiffness_degree: 2,
    sampling: GAUSS_2,
    vtk: 21,
    gmsh: 8,
};
const TRI3: CellData = CellData {
    name: "tri3",
    domain: Domain::Triangle,
    order: 1,
    nodes: TRIANGLE.split_at(3).0,
    monomials: P2.split_at(3).0,
    facets: &[
        (CellKind::Line2, &[0, 1]),
        (CellKind::Line2, &[1, 2]),
        (CellKind::Line2, &[2, 0]),
    ],
    mirror: &[0, 2, 1],
    interior: TRIANGLE_INTERIOR.split_at(1).0,
    stiffness_degree: 1,
    sampling: 0.0,
    vtk: 5,
    gmsh: 2,
};
const TRI6: CellData = CellData {
    name: "tri6",
    domain: Domain::Triangle,
    order: 2,
    nodes: &TRIANGLE,
    monomials: &P2,
    facets: &[
        (CellKind::Line3, &[0, 1, 3]),
        (CellKind::Line3, &[1, 2, 4]),
        (CellKind::Line3, &[2, 0, 5]),
    ],
    mirror: &[0, 2, 1, 5, 4, 3],
    interior: &TRIANGLE_INTERIOR,
    stiffness_degree: 4,
    sampling: 0.5,
    vtk: 22,
    gmsh: 9,
};
const QUAD4: CellData = CellData {
    name: "quad4",
    domain: Domain::Square,
    order: 1,
    nodes: SQUARE.split_at(4).0,
    monomials: Q2.split_at(4).0,
    facets: &[
        (CellKind::Line2, &[0, 1]),
        (CellKind::Line2, &[1, 2]),
        (CellKind::Line2, &[2, 3]),
        (CellKind::Line2, &[3, 0]),
    ],
    mirror: &[0, 3, 2, 1],
    interior: SQUARE_INTERIOR.split_at(1).0,
    stiffness_degree: 3,
    sampling: GAUSS_2,
    vtk: 9,
    gmsh: 3,
};
const QUAD8: CellData = CellData {
    name: "quad8",
    nodes: SQUARE.split_at(8).0,
    monomials: Q2.split_at(8).0,
    mirror: QUAD9.mirror.split_at(8).0,
    vtk: 23,
    gmsh: 16,
    ..QUAD9
};
const TET4: CellData = CellData {
    name: "tet4",
    domain: Domain::Tetrahedron,
    order: 1,
    nodes: &TETRAHEDRON,
    monomials: &P1_SPACE,
    facets: &[
        (CellKind::Tri3, &[0, 2, 1]),
        (CellKind::Tri3, &[0, 1, 3]),
        (CellKind::Tri3, &[1, 2, 3]),
        (CellKind::Tri3, &[0, 3, 2]),
    ],
    mirror: &[0, 2, 1, 3],
    interior: &[[0.25; 3]],
    stiffness_degree: 1,
    sampling: 0.0,
    vtk: 10,
    gmsh: 4,
};
const HEX8: CellData = CellData {
    name: "hex8",
    domain: Domain::Cube,
    order: 1,
    nodes: &CUBE,
    monomials: &Q1_SPACE,
    facets: &[
        (CellKind::Quad4, &[0, 3, 2, 1]),
        (CellKind::Quad4, &[4, 5, 6, 7]),
        (CellKind::Quad4, &[0, 1, 5, 4]),
        (CellKind::Quad4, &[1, 2, 6, 5]),
        (CellKind::Quad4, &[2, 3, 7, 6]),
        (CellKind::Quad4, &[3, 0, 4, 7]),
    ],
    mirror: &[0, 3, 2, 1, 4, 7, 6, 5],
    interior: &CUBE_INTERIOR,
    stiffness_degree: 3,
    sampling: GAUSS_2,
    vtk: 12,
    gmsh: 5,
};
const QUAD9: CellData = CellData {
    name: "quad9",
    domain: Domain::Square,
    order: 2,
    nodes: &SQUARE,
    monomials: &Q2,
    facets: &[
        (CellKind::Line3, &[0, 1, 4]),
        (CellKind::Line3, &[1, 2, 5]),
        (CellKind::Line3, &[2, 3, 6]),
        (CellKind::Line3, &[3, 0, 7]),
    ],
    mirror: &[0, 3, 2, 1, 7, 6, 5, 4, 8],
    interior: &SQUARE_INTERIOR,
    stiffness_degree: 5,
    sampling: GAUSS_2,
    vtk: 28,
    gmsh: 10,
};

const LINE: [[f64; 3]; 3] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
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
const TETRAHEDRON: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];
const CUBE: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

const L2: [[u8; 3]; 3] = [[0, 0, 0], [1, 0, 0], [2, 0, 0]];
/// The first three are those of the linear triangle.
const P2: [[u8; 3]; 6] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [2, 0, 0],
    [1, 1, 0],
    [0, 2, 0],
];
/// The first four are those of the bilinear cell, the first eight those of the serendipity cell.
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
const P1_SPACE: [[u8; 3]; 4] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
const Q1_SPACE: [[u8; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [0, 1, 1],
    [1, 0, 1],
    [1, 1, 1],
];

const THIRD: f64 = 1.0 / 3.0;
const SIXTH: f64 = 1.0 / 6.0;
/// √3/2, the sine of 60°.
const EQUILATERAL: f64 = 0.866_025_403_784_438_6;
/// 1/√3 and √(3/5).
const GAUSS_2: f64 = 0.577_350_269_189_625_8;
const GAUSS_3: f64 = 0.774_596_669_241_483_4;

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
/// The centre and the points of the 2 × 2 × 2 Gauss rule.
const CUBE_INTERIOR: [[f64; 3]; 9] = [
    [0.0, 0.0, 0.0],
    [-GAUSS_2, -GAUSS_2, -GAUSS_2],
    [GAUSS_2, -GAUSS_2, -GAUSS_2],
    [-GAUSS_2, GAUSS_2, -GAUSS_2],
    [GAUSS_2, GAUSS_2, -GAUSS_2],
    [-GAUSS_2, -GAUSS_2, GAUSS_2],
    [GAUSS_2, -GAUSS_2, GAUSS_2],
    [-GAUSS_2, GAUSS_2, GAUSS_2],
    [GAUSS_2, GAUSS_2, GAUSS_2],
];
