//! Tetrahedra from hexahedra and prisms.
//!
//! Every cell is cut by its own node numbers: a quadrilateral by the diagonal from its lowest corner, a cell into pyramids
//! and tetrahedra from its lowest corner to the faces without that corner. Both cells at a face cut it in the same
//! way, whatever the mesh is; a hexahedron gives six, a prism three. In a box numbered along its axes these are the six
//! paths from the lowest to the highest corner of each cell.
//! New edges lie in the middles of faces and cells, where quadratic cells with all their nodes have one.

use crate::mesh::{CellBlock, CellKind, Facet, Mesh, MeshError};
use std::collections::BTreeMap;

/// The same solid, sides and surfaces in tetrahedra of the order of its cells, which are hexahedra and prisms with all the
/// nodes of their order.
pub(super) fn tetrahedra(mesh: &Mesh<3>) -> Result<Mesh<3>, MeshError> {
    let mut pieces: BTreeMap<Facet, Vec<Facet>> = BTreeMap::new();
    for &facet in mesh.sides.values().flatten().chain(mesh.curves.keys()) {
        pieces.insert(facet, Vec::new());
    }
    let mut blocks = Vec::new();
    for (index, block) in mesh.blocks.iter().enumerate() {
        let middles = middles(block.kind);
        let kind = match block.kind.order() {
            1 => CellKind::Tet4,
            _ => CellKind::Tet10,
        };
        let mut nodes = Vec::new();
        let mut count = 0;
        for (cell, own) in block.cells().enumerate() {
            for corners in cut(block.kind, own) {
                let facets = block.kind.facets().iter().enumerate();
                for (local, (shape, of_facet)) in facets {
                    let parent = Facet {
                        block: index as u32,
                        cell: cell as u32,
                        local: local as u32,
                    };
                    let Some(pieces) = pieces.get_mut(&parent) else {
                        continue;
                    };
                    let on = |&i: &usize| of_facet[..shape.corners()].contains(&corners[i]);
                    let mut of_tet = kind.facets().iter();
                    let place = of_tet.position(|(_, local)| local[..3].iter().all(on));
                    pieces.extend(place.map(|local| Facet {
                        block: index as u32,
                        cell: count,
                        local: local as u32,
                    }));
                }
                nodes.extend(corners.map(|corner| own[corner]));
                if kind == CellKind::Tet10 {
                    let ends = EDGES.map(|[a, b]| [corners[a], corners[b]]);
                    nodes.extend(ends.map(|[a, b]| own[middles[a][b]]));
                }
                count += 1;
            }
        }
        let group = block.group.clone();
        blocks.push(CellBlock { kind, nodes, group });
    }
    let of = |facets: &Vec<Facet>| facets.iter().flat_map(|f| pieces[f].clone()).collect();
    let sides = mesh
        .sides
        .iter()
        .map(|(name, facets)| (name.clone(), of(facets)));
    let curves = mesh.curves.iter();
    let curves = curves.flat_map(|(f, &surface)| pieces[f].iter().map(move |&f| (f, surface)));
    Mesh::assembled(
        mesh.points.clone(),
        blocks,
        sides.collect(),
        curves.collect(),
    )
}

/// Ends of the edges of a tetrahedron, in the order of its middle nodes.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Local corners of the tetrahedra of a cell with these nodes.
fn cut(kind: CellKind, nodes: &[u32]) -> Vec<[usize; 4]> {
    let lowest = |corners: &[usize]| {
        let least = (0..corners.len()).min_by_key(|&i| nodes[corners[i]]);
        least.unwrap_or(0)
    };
    let all: Vec<usize> = (0..kind.corners()).collect();
    let apex = lowest(&all);
    let mut tetrahedra = Vec::new();
    for (shape, of_facet) in kind.facets() {
        let corners = &of_facet[..shape.corners()];
        if corners.contains(&apex) {
            continue;
        }
        let start = lowest(corners);
        let corner = |k: usize| corners[(start + k) % corners.len()];
        let fan = (1..corners.len() - 1).map(|k| [apex, corner(0), corner(k), corner(k + 1)]);
        tetrahedra.extend(fan);
    }
    tetrahedra
}

/// The node in the middle between two corners, (corners, corners); not used for linear cells, which have no such node.
fn middles(kind: CellKind) -> Vec<Vec<usize>> {
    let nodes = kind.reference_nodes();
    let corners = &nodes[..kind.corners()];
    let between = |a: &[f64; 3], b: &[f64; 3]| {
        let middle: [f64; 3] = std::array::from_fn(|d| 0.5 * (a[d] + b[d]));
        nodes.iter().position(|&node| node == middle).unwrap_or(0)
    };
    let row = |a| corners.iter().map(|b| between(a, b)).collect();
    corners.iter().map(row).collect()
}
