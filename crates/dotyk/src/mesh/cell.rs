//! Kinds of cells: their shape functions and the data for meshes, files and quadrature. Blocks of cells.
//!
//! The definition of a kind is in `reference.rs`, as data.

use crate::mesh::basis::Basis;
use crate::mesh::error::MeshError;
use crate::mesh::reference::{CellKind, Domain};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::LazyLock;

/// Largest number of nodes of any cell: the length of buffers on the stack.
pub const MAX_CELL_NODES: usize = most_nodes(false);

/// Largest number of nodes of any facet.
pub const MAX_FACET_NODES: usize = most_nodes(true);

const fn most_nodes(of_facets: bool) -> usize {
    let (mut most, mut kind) = (0, 0);
    while kind < CellKind::ALL.len() {
        let data = CellKind::ALL[kind].data();
        let mut nodes = if of_facets { 0 } else { data.nodes.len() };
        let mut facet = 0;
        while of_facets && facet < data.facets.len() {
            let count = data.facets[facet].1.len();
            nodes = if count > nodes { count } else { nodes };
            facet += 1;
        }
        most = if nodes > most { nodes } else { most };
        kind += 1;
    }
    most
}

/// Shape functions of every kind, in the order of [`CellKind::ALL`].
static BASES: LazyLock<[Basis; CellKind::ALL.len()]> = LazyLock::new(|| {
    CellKind::ALL.map(|kind| Basis::new(kind.data().nodes, kind.data().monomials))
});

impl Domain {
    /// Number of reference coordinates.
    pub fn dimension(self) -> usize {
        self.data().dimension
    }

    /// Number of corners.
    pub fn corners(self) -> usize {
        self.data().corner_edges.len()
    }

    /// Length, area or volume.
    pub fn volume(self) -> f64 {
        self.data().volume
    }

    /// Its centre, missing coordinates zero.
    pub fn centre(self) -> [f64; 3] {
        self.data().centre
    }

    /// The linear cell of this shape.
    pub(crate) fn linear(self) -> CellKind {
        match self {
            Self::Line => CellKind::Line2,
            Self::Triangle => CellKind::Tri3,
            Self::Square => CellKind::Quad4,
            Self::Tetrahedron => CellKind::Tet4,
            Self::Cube => CellKind::Hex8,
            Self::Prism => CellKind::Prism6,
        }
    }

    /// Distance of reference coordinates outside; negative inside.
    pub fn outside(self, xi: &[f64]) -> f64 {
        let xi = &xi[..self.dimension()];
        let simplex = |xi: &[f64]| {
            let rest = xi.iter().sum::<f64>() - 1.0;
            xi.iter().fold(rest, |largest, c| largest.max(-c))
        };
        let cube = |xi: &[f64]| {
            let beyond = xi.iter().map(|c| c.abs() - 1.0);
            beyond.fold(f64::NEG_INFINITY, f64::max)
        };
        match self {
            Self::Triangle | Self::Tetrahedron => simplex(xi),
            Self::Line | Self::Square | Self::Cube => cube(xi),
            Self::Prism => simplex(&xi[..2]).max(cube(&xi[2..])),
        }
    }
}

impl CellKind {
    /// The kinds of cells that a mesh of a dimension may consist of.
    pub fn of_dimension(dimension: usize) -> impl Iterator<Item = Self> {
        let fits = move |kind: &Self| kind.dimension() == dimension;
        Self::ALL.into_iter().filter(fits)
    }

    /// The name in a case file, such as `quad4`.
    pub fn name(self) -> &'static str {
        self.data().name
    }

    /// The kind of that name; `None` if it is unknown.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Its number in VTK's files.
    pub fn vtk(self) -> u8 {
        self.data().vtk
    }

    /// Its number in Gmsh's files.
    pub fn gmsh(self) -> u8 {
        self.data().gmsh
    }

    /// The nodes of a cell in our order, which is VTK's, from those in the order of a file of Gmsh.
    pub(crate) fn reorder_from_gmsh<T: Copy>(self, nodes: &mut [T]) {
        let order = self.data().gmsh_order;
        if !order.is_empty() {
            let theirs = nodes.to_vec();
            for (node, &place) in nodes.iter_mut().zip(order) {
                *node = theirs[place];
            }
        }
    }

    /// Nodes per cell.
    pub fn nodes(self) -> usize {
        self.data().nodes.len()
    }

    /// Shape of the reference cell.
    pub fn domain(self) -> Domain {
        self.data().domain
    }

    /// Dimension of the reference cell.
    pub fn dimension(self) -> usize {
        self.domain().dimension()
    }

    /// 1 linear, 2 quadratic.
    pub fn order(self) -> usize {
        self.data().order
    }

    /// Number of corner nodes; they come first.
    pub fn corners(self) -> usize {
        self.domain().corners()
    }

    /// Kind and local nodes of each facet, the cell on the left, in space behind.
    pub fn facets(self) -> &'static [(Self, &'static [usize])] {
        self.data().facets
    }

    /// Reference coordinates of the nodes, (nodes, 3), missing coordinates zero.
    pub fn reference_nodes(self) -> &'static [[f64; 3]] {
        self.data().nodes
    }

    /// The local nodes between corners, each with the weights of linear interpolation: corners and their parts, which sum to one.
    pub(crate) fn between_corners(self) -> impl Iterator<Item = (usize, Vec<(usize, f64)>)> {
        let (corners, linear) = (self.corners(), self.domain().linear());
        (corners..self.nodes()).map(move |node| {
            let mut shape = [0.0; MAX_CELL_NODES];
            linear.shape(&self.reference_nodes()[node], &mut shape);
            let parts = shape[..corners].iter().copied().enumerate();
            (node, parts.filter(|(_, part)| *part != 0.0).collect())
        })
    }

    /// Local node at each place of the same cell numbered the other way round.
    pub fn mirror(self) -> &'static [usize] {
        self.data().mirror
    }

    /// Neighbours of each corner along its edges, in the order that makes the determinant of the edges positive.
    pub fn corner_edges(self) -> &'static [&'static [usize]] {
        self.domain().data().corner_edges
    }

    /// Values Nᵢ(ξ) of the shape functions.
    ///
    /// Shapes: `xi` at least (dimension,), further entries are ignored; `values` at least (nodes,), the first are written.
    pub fn shape(self, xi: &[f64], values: &mut [f64]) {
        debug_assert!(xi.len() >= self.dimension() && values.len() >= self.nodes());
        BASES[self as usize].values(xi, values);
    }

    /// Gradients ∂Nᵢ/∂ξ of the shape functions in reference coordinates.
    ///
    /// Shapes: `xi` as in [`Self::shape`]; `gradients` at least (nodes, E), the first are written, E ≥ dimension and the
    /// entries beyond the dimension are zero.
    pub fn gradients<const E: usize>(self, xi: &[f64], gradients: &mut [[f64; E]]) {
        debug_assert!(E >= self.dimension());
        debug_assert!(xi.len() >= self.dimension() && gradients.len() >= self.nodes());
        BASES[self as usize].gradients(xi, gradients);
    }

    /// Degree of the quadrature of its stiffness: exact where it is undistorted.
    pub fn stiffness_degree(self) -> usize {
        self.data().stiffness_degree
    }

    /// Places of stress samples between the centre and the corners, as parts along each coordinate; zero: only at the centre.
    pub(crate) fn sampling(self) -> [f64; 3] {
        self.data().sampling
    }

    /// Points of the reference cell inside which the Jacobian must be positive: those of the usual quadrature rules.
    pub(crate) fn interior(self) -> &'static [[f64; 3]] {
        self.data().interior
    }

    /// Determinant of the unit vectors along the edges of a corner of the regular cell.
    pub(crate) fn regular(self) -> f64 {
        self.domain().data().regular
    }
}

/// Cells of one kind, and of one group when the mesh file names groups.
#[derive(Debug, Clone, PartialEq)]
pub struct CellBlock {
    /// Kind of all cells of the block.
    pub kind: CellKind,
    /// Node indices, `kind.nodes()` per cell.
    pub nodes: Vec<u32>,
    /// Name of the group, for materials.
    pub group: Option<String>,
}

impl CellBlock {
    /// Nodes of each cell.
    pub fn cells(&self) -> std::slice::ChunksExact<'_, u32> {
        self.nodes.chunks_exact(self.kind.nodes())
    }
}

/// Keeps the first of cells that are listed several times, in one block or in several; returns how many were dropped.
///
/// Errors: two cells with the same corners that differ otherwise.
pub fn drop_repeated(blocks: &mut Vec<CellBlock>) -> Result<usize, MeshError> {
    let sorted = |nodes: &[u32]| {
        let mut nodes = nodes.to_vec();
        nodes.sort_unstable();
        nodes
    };
    // by its corners the kind, the nodes and the place of a cell
    type Cell = (CellKind, Vec<u32>, (usize, usize));
    let mut seen: HashMap<Vec<u32>, Cell> = HashMap::new();
    let mut dropped = 0;
    for (index, block) in blocks.iter_mut().enumerate() {
        let kind = block.kind;
        let mut kept = Vec::with_capacity(block.nodes.len());
        for (cell, nodes) in block.nodes.chunks_exact(kind.nodes()).enumerate() {
            let (own, place) = (sorted(nodes), (index, cell));
            match seen.entry(sorted(&nodes[..kind.corners()])) {
                Entry::Vacant(free) => {
                    free.insert((kind, own, place));
                    kept.extend_from_slice(nodes);
                }
                Entry::Occupied(known) if known.get().0 == kind && known.get().1 == own => {
                    dropped += 1;
                }
                Entry::Occupied(known) => {
                    return Err(MeshError::Overlap {
                        first: known.get().2,
                        second: place,
                    });
                }
            }
        }
        block.nodes = kept;
    }
    blocks.retain(|block| !block.nodes.is_empty());
    Ok(dropped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn values(kind: CellKind, xi: [f64; 3]) -> Vec<f64> {
        let mut values = vec![f64::NAN; kind.nodes()];
        kind.shape(&xi, &mut values);
        values
    }

    #[test]
    fn cells_that_are_listed_twice_count_once() {
        let block = |kind: CellKind, nodes: &[u32], group: &str| CellBlock {
            kind,
            nodes: nodes.to_vec(),
            group: Some(group.to_string()),
        };
        let mut blocks = vec![
            block(CellKind::Tri3, &[0, 1, 2, 2, 1, 3], "low"),
            // the second again, from another corner; the first the other way round
            block(CellKind::Tri3, &[1, 3, 2, 0, 2, 1, 3, 1, 4], "all"),
            block(CellKind::Tri3, &[1, 4, 3], "high"),
        ];
        assert_eq!(drop_repeated(&mut blocks).unwrap(), 3);
        let left: Vec<_> = blocks.iter().map(|block| &block.nodes[..]).collect();
        assert_eq!(left, [&[0, 1, 2, 2, 1, 3][..], &[3, 1, 4]]);
        let mut blocks = vec![
            block(CellKind::Tri3, &[0, 1, 2], "a"),
            block(CellKind::Tri6, &[0, 1, 2, 3, 4, 5], "b"),
        ];
        let error = drop_repeated(&mut blocks).unwrap_err();
        assert!(matches!(
            error,
            MeshError::Overlap {
                first: (0, 0),
                second: (1, 0)
            }
        ));
    }

    #[test]
    fn names_and_numbers_lead_back_to_their_kind() {
        for kind in CellKind::ALL {
            assert_eq!(CellKind::from_name(kind.name()), Some(kind));
            assert!(kind.nodes() <= MAX_CELL_NODES);
            let same = |other: &CellKind| other.vtk() == kind.vtk() || other.gmsh() == kind.gmsh();
            assert_eq!(CellKind::ALL.iter().filter(|other| same(other)).count(), 1);
            assert_eq!(kind.domain().linear().domain(), kind.domain());
        }
        assert_eq!(CellKind::from_name("quad5"), None);
        assert_eq!((MAX_CELL_NODES, MAX_FACET_NODES), (27, 9));
    }

    #[test]
    fn each_shape_function_is_one_at_its_own_node_only() {
        for kind in CellKind::ALL {
            for (i, node) in kind.reference_nodes().iter().enumerate() {
                for (j, value) in values(kind, *node).into_iter().enumerate() {
                    assert_eq!(value, f64::from(u8::from(i == j)), "{kind:?} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn the_serendipity_corner_is_the_textbook_formula() {
        let (x, y) = (0.3, -0.7);
        let expected = -0.25 * (1.0 - x) * (1.0 - y) * (1.0 + x + y);
        let computed = values(CellKind::Quad8, [x, y, 0.0])[0];
        assert!((computed - expected).abs() < 1e-15);
    }

    #[test]
    fn facets_are_cells_of_their_kind_on_the_boundary_and_look_outwards() {
        for kind in CellKind::ALL {
            let inside = kind.domain().centre();
            for &(facet, local) in kind.facets() {
                assert_eq!(facet.dimension() + 1, kind.dimension());
                assert_eq!(local.len(), facet.nodes());
                let at = |i: usize| kind.reference_nodes()[local[i]];
                // The linear facet through the corners has the other nodes at their places.
                let linear = facet.domain().linear();
                for (i, xi) in facet.reference_nodes().iter().enumerate() {
                    let shape = values(linear, *xi);
                    for d in 0..3 {
                        let sum: f64 = shape.iter().enumerate().map(|(c, n)| n * at(c)[d]).sum();
                        assert_eq!(at(i)[d], sum, "{kind:?}");
                    }
                    assert_eq!(kind.domain().outside(&at(i)), 0.0);
                }
                let along =
                    |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|d| b[d] - a[d]) };
                let first = along(at(0), at(1));
                let second = match kind.dimension() {
                    2 => [0.0, 0.0, 1.0],
                    _ => along(at(0), at(facet.corners() - 1)),
                };
                let normal = crate::geometry::cross(first, second);
                let inwards = crate::geometry::dot(normal, along(at(0), inside));
                assert!(inwards < 0.0, "{kind:?}");
            }
        }
    }

    #[test]
    fn edges_of_a_corner_are_right_handed_and_those_of_the_regular_cell_have_the_determinant_told()
    {
        for kind in CellKind::of_dimension(3) {
            let nodes = kind.reference_nodes();
            for (corner, ends) in kind.corner_edges().iter().enumerate() {
                let edge = |k: usize| crate::geometry::sub(nodes[ends[k]], nodes[corner]);
                let product = crate::geometry::cross(edge(0), edge(1));
                assert!(
                    crate::geometry::dot(product, edge(2)) > 0.0,
                    "{kind:?} {corner}"
                );
            }
        }
        // A regular tetrahedron with a corner at the origin and edges √2: every second corner of the unit cube.
        let edges = [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
        let product = crate::geometry::cross(edges[0], edges[1]);
        let regular = crate::geometry::dot(product, edges[2]) / 2f64.sqrt().powi(3);
        assert!((CellKind::Tet4.regular() - regular).abs() < 1e-15);
    }

    #[test]
    fn gmsh_lists_middles_by_the_tables_of_its_manual() {
        // ends of the edges, then corners of the faces, in the order of the section on node ordering
        type Tables = (CellKind, &'static [&'static [usize]]);
        let tables: [Tables; 5] = [
            (
                CellKind::Tet10,
                &[&[0, 1], &[1, 2], &[0, 2], &[0, 3], &[2, 3], &[1, 3]],
            ),
            (CellKind::Hex20, &HEXAHEDRON[..12]),
            (CellKind::Hex27, &HEXAHEDRON),
            (CellKind::Prism15, &PRISM[..9]),
            (CellKind::Prism18, &PRISM),
        ];
        for (kind, middles) in tables {
            let nodes = kind.reference_nodes();
            let mut file = nodes[..kind.corners()].to_vec();
            for middle in middles {
                let sum = |d: usize| middle.iter().map(|&i| nodes[i][d]).sum::<f64>();
                file.push([0, 1, 2].map(|d| sum(d) / middle.len() as f64));
            }
            kind.reorder_from_gmsh(&mut file);
            assert_eq!(file, nodes, "{kind:?}");
        }
    }

    const HEXAHEDRON: [&[usize]; 19] = [
        &[0, 1],
        &[0, 3],
        &[0, 4],
        &[1, 2],
        &[1, 5],
        &[2, 3],
        &[2, 6],
        &[3, 7],
        &[4, 5],
        &[4, 7],
        &[5, 6],
        &[6, 7],
        &[0, 3, 2, 1],
        &[0, 1, 5, 4],
        &[0, 4, 7, 3],
        &[1, 2, 6, 5],
        &[2, 3, 7, 6],
        &[4, 5, 6, 7],
        &[0, 1, 2, 3, 4, 5, 6, 7],
    ];
    const PRISM: [&[usize]; 12] = [
        &[0, 1],
        &[0, 2],
        &[0, 3],
        &[1, 2],
        &[1, 4],
        &[2, 5],
        &[3, 4],
        &[3, 5],
        &[4, 5],
        &[0, 1, 4, 3],
        &[0, 3, 5, 2],
        &[1, 2, 5, 4],
    ];

    #[test]
    fn the_mirror_maps_the_reference_cell_onto_itself() {
        // All reference cells but the line are symmetric under the exchange of ξ and η, which keeps corner 0.
        for kind in CellKind::ALL {
            for (place, &from) in kind.mirror().iter().enumerate() {
                let [x, y, z] = kind.reference_nodes()[from];
                let expected = match kind.dimension() {
                    1 => [-x, y, z],
                    _ => [y, x, z],
                };
                assert_eq!(kind.reference_nodes()[place], expected, "{kind:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn shape_functions_sum_to_one_and_reproduce_linear_functions(
            x in -1.0..1.0, y in -1.0..1.0, z in -1.0..1.0
        ) {
            for kind in CellKind::ALL {
                let xi = [x, y, z];
                let values = values(kind, xi);
                let sum = |d: usize| -> f64 {
                    values.iter().zip(kind.reference_nodes()).map(|(v, n)| v * n[d]).sum()
                };
                // A handful of operations on numbers of size one to ten.
                prop_assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                for (d, x) in xi.iter().enumerate().take(kind.dimension()) {
                    prop_assert!((sum(d) - x).abs() < 1e-14);
                }
            }
        }

        #[test]
        fn gradients_are_the_difference_quotients(
            x in -1.0..1.0, y in -1.0..1.0, z in -1.0..1.0
        ) {
            // Central differences of polynomials of degree at most two in each variable are exact but for rounding / h.
            let h = 1e-3;
            for kind in CellKind::ALL {
                let mut gradients = vec![[f64::NAN; 3]; kind.nodes()];
                kind.gradients(&[x, y, z], &mut gradients);
                for d in 0..3 {
                    let moved = |step: f64| {
                        let mut xi = [x, y, z];
                        xi[d] += step;
                        values(kind, xi)
                    };
                    let differences = moved(h).into_iter().zip(moved(-h));
                    for (gradient, (ahead, back)) in gradients.iter().zip(differences) {
                        prop_assert!((gradient[d] - (ahead - back) / (2.0 * h)).abs() < 1e-11);
                    }
                }
            }
        }
    }
}
