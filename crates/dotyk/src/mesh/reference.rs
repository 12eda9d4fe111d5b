//! Reference cells as data: one complete entry for each kind of cell.
//!
//! Conventions: the reference line is [−1, 1], square and cube are its powers, triangle and tetrahedron have a corner at
//! the origin and one at the end of each unit vector; the prism is triangle times line. Corner nodes come first, then the
//! middles of the edges, of the faces with four corners and of the cell, in the order of VTK (9.7 and later: before, and in
//! meshio, the two triangles of the linear prism are numbered the other way round): edges 01 12 20 (01 12 23 30)
//! of the bottom, the same of the top, those between; faces −x +x −y +y −z +z of the cube, over the edges 01 12 20 of a
//! prism. In space Gmsh has another order. A facet is a cell of one dimension less: its nodes are listed in the
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
    /// Quadratic tetrahedron.
    Tet10,
    /// Trilinear hexahedron.
    Hex8,
    /// Serendipity hexahedron.
    Hex20,
    /// Triquadratic hexahedron.
    Hex27,
    /// Linear wedge.
    Prism6,
    /// Serendipity wedge.
    Prism15,
    /// Quadratic wedge.
    Prism18,
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
    /// Triangle × [−1, 1].
    Prism,
}

/// Common data of cells of one shape.
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
    /// Points besides the nodes at which the sign of the Jacobian is checked: those of the usual quadrature rules.
    pub interior: &'static [[f64; 3]],
    /// Degree that integrates the stiffness of an undistorted cell exactly, and that of a curved one well.
    pub stiffness_degree: usize,
    /// Stress is sampled at the corners, drawn towards the centre by these factors: where it is most accurate. Zero: at the
    /// centre alone.
    pub sampling: [f64; 3],
    /// Its numbers in VTK's and Gmsh's files; VTK lists the nodes in the order of `nodes` (prisms: since 9.7).
    pub vtk: u8,
    pub gmsh: u8,
    /// Place in a file of Gmsh of each node; empty: the same.
    pub gmsh_order: &'static [usize],
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
            Self::Prism => &DomainData {
                dimension: 3,
                volume: 1.0,
                centre: [THIRD, THIRD, 0.0],
                corner_edges: &[
                    &[1, 2, 3],
                    &[2, 0, 4],
                    &[0, 1, 5],
                    &[5, 4, 0],
                    &[3, 5, 1],
                    &[4, 3, 2],
                ],
                regular: EQUILATERAL,
            },
        }
    }
}

impl CellKind {
    /// Every kind.
    pub const ALL: [Self; 15] = [
        Self::Line2,
        Self::Line3,
        Self::Tri3,
        Self::Tri6,
        Self::Quad4,
        Self::Quad8,
        Self::Quad9,
        Self::Tet4,
        Self::Tet10,
        Self::Hex8,
        Self::Hex20,
        Self::Hex27,
        Self::Prism6,
        Self::Prism15,
        Self::Prism18,
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
            Self::Tet10 => &TET10,
            Self::Hex8 => &HEX8,
            Self::Hex20 => &HEX20,
            Self::Hex27 => &HEX27,
            Self::Prism6 => &PRISM6,
            Self::Prism15 => &PRISM15,
            Self::Prism18 => &PRISM18,
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
    sampling: [0.0; 3],
    vtk: 3,
    gmsh: 1,
    gmsh_order: &[],
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
    sampling: [GAUSS_2; 3],
    vtk: 21,
    gmsh: 8,
    gmsh_order: &[],
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
    sampling: [0.0; 3],
    vtk: 5,
    gmsh: 2,
    gmsh_order: &[],
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
    sampling: [0.5; 3],
    vtk: 22,
    gmsh: 9,
    gmsh_order: &[],
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
    sampling: [GAUSS_2; 3],
    vtk: 9,
    gmsh: 3,
    gmsh_order: &[],
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
    nodes: TETRAHEDRON.split_at(4).0,
    monomials: P2_SPACE.split_at(4).0,
    facets: &[
        (CellKind::Tri3, &[0, 2, 1]),
        (CellKind::Tri3, &[0, 1, 3]),
        (CellKind::Tri3, &[1, 2, 3]),
        (CellKind::Tri3, &[0, 3, 2]),
    ],
    mirror: &[0, 2, 1, 3],
    interior: TETRAHEDRON_INTERIOR.split_at(1).0,
    stiffness_degree: 1,
    sampling: [0.0; 3],
    vtk: 10,
    gmsh: 4,
    gmsh_order: &[],
};
const HEX8: CellData = CellData {
    name: "hex8",
    domain: Domain::Cube,
    order: 1,
    nodes: CUBE.split_at(8).0,
    monomials: Q2_SPACE.split_at(8).0,
    facets: &[
        (CellKind::Quad4, &[0, 3, 2, 1]),
        (CellKind::Quad4, &[4, 5, 6, 7]),
        (CellKind::Quad4, &[0, 1, 5, 4]),
        (CellKind::Quad4, &[1, 2, 6, 5]),
        (CellKind::Quad4, &[2, 3, 7, 6]),
        (CellKind::Quad4, &[3, 0, 4, 7]),
    ],
    mirror: &[0, 3, 2, 1, 4, 7, 6, 5],
    interior: CUBE_INTERIOR.split_at(9).0,
    stiffness_degree: 3,
    sampling: [GAUSS_2; 3],
    vtk: 12,
    gmsh: 5,
    gmsh_order: &[],
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
    sampling: [GAUSS_2; 3],
    vtk: 28,
    gmsh: 10,
    gmsh_order: &[],
};

const TET10: CellData = CellData {
    name: "tet10",
    domain: Domain::Tetrahedron,
    order: 2,
    nodes: &TETRAHEDRON,
    monomials: &P2_SPACE,
    facets: &[
        (CellKind::Tri6, &[0, 2, 1, 6, 5, 4]),
        (CellKind::Tri6, &[0, 1, 3, 4, 8, 7]),
        (CellKind::Tri6, &[1, 2, 3, 5, 9, 8]),
        (CellKind::Tri6, &[0, 3, 2, 7, 9, 6]),
    ],
    mirror: &[0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
    interior: &TETRAHEDRON_INTERIOR,
    stiffness_degree: 3,
    sampling: [GAUSS_TETRAHEDRON; 3],
    vtk: 24,
    gmsh: 11,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
};
const HEX20: CellData = CellData {
    name: "hex20",
    domain: Domain::Cube,
    order: 2,
    nodes: CUBE.split_at(20).0,
    monomials: Q2_SPACE.split_at(20).0,
    facets: &[
        (CellKind::Quad8, &[0, 3, 2, 1, 11, 10, 9, 8]),
        (CellKind::Quad8, &[4, 5, 6, 7, 12, 13, 14, 15]),
        (CellKind::Quad8, &[0, 1, 5, 4, 8, 17, 12, 16]),
        (CellKind::Quad8, &[1, 2, 6, 5, 9, 18, 13, 17]),
        (CellKind::Quad8, &[2, 3, 7, 6, 10, 19, 14, 18]),
        (CellKind::Quad8, &[3, 0, 4, 7, 11, 16, 15, 19]),
    ],
    mirror: &[
        0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17,
    ],
    interior: &CUBE_INTERIOR,
    stiffness_degree: 5,
    sampling: [GAUSS_2; 3],
    vtk: 25,
    gmsh: 17,
    gmsh_order: &[
        0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15,
    ],
};
const HEX27: CellData = CellData {
    name: "hex27",
    domain: Domain::Cube,
    order: 2,
    nodes: &CUBE,
    monomials: &Q2_SPACE,
    facets: &[
        (CellKind::Quad9, &[0, 3, 2, 1, 11, 10, 9, 8, 24]),
        (CellKind::Quad9, &[4, 5, 6, 7, 12, 13, 14, 15, 25]),
        (CellKind::Quad9, &[0, 1, 5, 4, 8, 17, 12, 16, 22]),
        (CellKind::Quad9, &[1, 2, 6, 5, 9, 18, 13, 17, 21]),
        (CellKind::Quad9, &[2, 3, 7, 6, 10, 19, 14, 18, 23]),
        (CellKind::Quad9, &[3, 0, 4, 7, 11, 16, 15, 19, 20]),
    ],
    mirror: &[
        0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17, 22, 23, 20, 21, 24,
        25, 26,
    ],
    interior: &CUBE_INTERIOR,
    stiffness_degree: 5,
    sampling: [GAUSS_2; 3],
    vtk: 29,
    gmsh: 12,
    gmsh_order: &[
        0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20,
        25, 26,
    ],
};
const PRISM6: CellData = CellData {
    name: "prism6",
    domain: Domain::Prism,
    order: 1,
    nodes: PRISM.split_at(6).0,
    monomials: P2_BY_Q2.split_at(6).0,
    facets: &[
        (CellKind::Tri3, &[0, 2, 1]),
        (CellKind::Tri3, &[3, 4, 5]),
        (CellKind::Quad4, &[0, 1, 4, 3]),
        (CellKind::Quad4, &[1, 2, 5, 4]),
        (CellKind::Quad4, &[2, 0, 3, 5]),
    ],
    mirror: &[0, 2, 1, 3, 5, 4],
    interior: PRISM_INTERIOR.split_at(7).0,
    stiffness_degree: 2,
    sampling: [0.5, 0.5, GAUSS_2],
    vtk: 13,
    gmsh: 6,
    gmsh_order: &[],
};
const PRISM15: CellData = CellData {
    name: "prism15",
    domain: Domain::Prism,
    order: 2,
    nodes: PRISM.split_at(15).0,
    monomials: P2_BY_Q2.split_at(15).0,
    facets: &[
        (CellKind::Tri6, &[0, 2, 1, 8, 7, 6]),
        (CellKind::Tri6, &[3, 4, 5, 9, 10, 11]),
        (CellKind::Quad8, &[0, 1, 4, 3, 6, 13, 9, 12]),
        (CellKind::Quad8, &[1, 2, 5, 4, 7, 14, 10, 13]),
        (CellKind::Quad8, &[2, 0, 3, 5, 8, 12, 11, 14]),
    ],
    mirror: &[0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13],
    interior: &PRISM_INTERIOR,
    stiffness_degree: 4,
    sampling: [0.5, 0.5, GAUSS_2],
    vtk: 26,
    gmsh: 18,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
};
const PRISM18: CellData = CellData {
    name: "prism18",
    domain: Domain::Prism,
    order: 2,
    nodes: &PRISM,
    monomials: &P2_BY_Q2,
    facets: &[
        (CellKind::Tri6, &[0, 2, 1, 8, 7, 6]),
        (CellKind::Tri6, &[3, 4, 5, 9, 10, 11]),
        (CellKind::Quad9, &[0, 1, 4, 3, 6, 13, 9, 12, 15]),
        (CellKind::Quad9, &[1, 2, 5, 4, 7, 14, 10, 13, 16]),
        (CellKind::Quad9, &[2, 0, 3, 5, 8, 12, 11, 14, 17]),
    ],
    mirror: &[0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13, 17, 16, 15],
    interior: &PRISM_INTERIOR,
    stiffness_degree: 4,
    sampling: [0.5, 0.5, GAUSS_2],
    vtk: 32,
    gmsh: 13,
    gmsh_order: &[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16],
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
const TETRAHEDRON: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];
const CUBE: [[f64; 3]; 27] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [0.0, -1.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, -1.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [-1.0, 0.0, 1.0],
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, 0.0],
];
const PRISM: [[f64; 3]; 18] = [
    [0.0, 0.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.5, 0.0, -1.0],
    [0.5, 0.5, -1.0],
    [0.0, 0.5, -1.0],
    [0.5, 0.0, 1.0],
    [0.5, 0.5, 1.0],
    [0.0, 0.5, 1.0],
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
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
/// The first four are those of the linear tetrahedron.
const P2_SPACE: [[u8; 3]; 10] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [2, 0, 0],
    [1, 1, 0],
    [0, 2, 0],
    [1, 0, 1],
    [0, 1, 1],
    [0, 0, 2],
];
/// The first eight are those of the trilinear cell, the first twenty those of the serendipity cell.
const Q2_SPACE: [[u8; 3]; 27] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [0, 1, 1],
    [1, 0, 1],
    [1, 1, 1],
    [2, 0, 0],
    [2, 0, 1],
    [2, 1, 0],
    [2, 1, 1],
    [0, 2, 0],
    [0, 2, 1],
    [1, 2, 0],
    [1, 2, 1],
    [0, 0, 2],
    [0, 1, 2],
    [1, 0, 2],
    [1, 1, 2],
    [0, 2, 2],
    [1, 2, 2],
    [2, 0, 2],
    [2, 1, 2],
    [2, 2, 0],
    [2, 2, 1],
    [2, 2, 2],
];
/// Of triangle and line; the first six are those of the linear wedge, the first fifteen those of the serendipity wedge.
const P2_BY_Q2: [[u8; 3]; 18] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [0, 1, 1],
    [2, 0, 0],
    [1, 1, 0],
    [0, 2, 0],
    [2, 0, 1],
    [1, 1, 1],
    [0, 2, 1],
    [0, 0, 2],
    [1, 0, 2],
    [0, 1, 2],
    [2, 0, 2],
    [1, 1, 2],
    [0, 2, 2],
];

const THIRD: f64 = 1.0 / 3.0;
const SIXTH: f64 = 1.0 / 6.0;
/// √3/2, the sine of 60°.
const EQUILATERAL: f64 = 0.866_025_403_784_438_6;
/// 1/√3 and √(3/5).
const GAUSS_2: f64 = 0.577_350_269_189_625_8;
const GAUSS_3: f64 = 0.774_596_669_241_483_4;
/// 1/√5: the points of the rule of degree 2 lie at this share of the way from the centre to the corners.
const GAUSS_TETRAHEDRON: f64 = 0.447_213_595_499_957_9;

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
/// The centre, the points of the 2 × 2 × 2 and of the 3 × 3 × 3 Gauss rule.
const CUBE_INTERIOR: [[f64; 3]; 36] = stacked(&[
    (SQUARE_INTERIOR.split_at(1).0, &[0.0]),
    (SQUARE_INTERIOR.split_at(5).0.split_at(1).1, &TWO),
    (SQUARE_INTERIOR.split_at(1).0, &THREE),
    (SQUARE_INTERIOR.split_at(5).1, &THREE),
]);
/// The centre and the points of the rules of degree 2 and 3.
const TETRAHEDRON_INTERIOR: [[f64; 3]; 13] = {
    let (mut points, mut count) = ([[0.25; 3]; 13], 1);
    let mut orbit = 0;
    while orbit < ORBITS.len() {
        let mut place = 0;
        while place < 4 {
            points[count] = [ORBITS[orbit]; 3];
            if place < 3 {
                points[count][place] = 1.0 - 3.0 * ORBITS[orbit];
            }
            (place, count) = (place + 1, count + 1);
        }
        orbit += 1;
    }
    points
};
const ORBITS: [f64; 3] = [
    0.138_196_601_125_010_5,
    0.328_054_696_711_426_7,
    0.106_952_273_932_930_68,
];
/// The centre and the points of the rules of degree 2 and 4.
const PRISM_INTERIOR: [[f64; 3]; 25] = stacked(&[
    (TRIANGLE_INTERIOR.split_at(1).0, &[0.0]),
    (TRIANGLE_INTERIOR.split_at(4).0.split_at(1).1, &TWO),
    (TRIANGLE_INTERIOR.split_at(4).1, &THREE),
]);
const TWO: [f64; 2] = [-GAUSS_2, GAUSS_2];
const THREE: [f64; 3] = [-GAUSS_3, 0.0, GAUSS_3];

/// Points of the plane at some heights each.
const fn stacked<const N: usize>(layers: &[(&[[f64; 3]], &[f64])]) -> [[f64; 3]; N] {
    let (mut points, mut count, mut layer) = ([[0.0; 3]; N], 0, 0);
    while layer < layers.len() {
        let (plane, heights) = layers[layer];
        let mut place = 0;
        while place < plane.len() * heights.len() {
            points[count] = plane[place % plane.len()];
            points[count][2] = heights[place / plane.len()];
            (place, count) = (place + 1, count + 1);
        }
        layer += 1;
    }
    points
}
