//! Solids of revolution of plane meshes that touch their axis.
//!
//! A node on the axis is the same one on all levels, so that cells there lose corners:
//!
//! ```text
//!   quadrilateral with an edge on the axis     a prism along the axis: a triangle at each end of the edge
//!   triangle with an edge on it                a tetrahedron
//!   triangle with a corner on it               a pyramid, which is two tetrahedra
//!   quadrilateral with one corner on it        seven corners, and no cell
//! ```
//!
//! A pyramid is cut by a diagonal, so that its neighbours are cut, too: a mesh of triangles alone becomes one of tetrahedra alone. The
//! layer over a triangle with the nodes p < q < r is (p₀ q₀ r₀ r₁), (p₀ q₀ q₁ r₁), (p₀ p₁ q₁ r₁), less what has an edge from a node to
//! itself: the face over an edge has the diagonal from its lower node below to its higher one above, for both cells at it.
//!
//! A node of a solid cell in the middle of some of its corners stands over the node of the plane cell in the middle of theirs, at the
//! mean level of those that are off the axis.

use crate::geometry::{Point, Surface};
use crate::mesh::generate::layers::carried;
use crate::mesh::generate::wrong;
use crate::mesh::{CellBlock, CellKind, Domain, Facet, MAX_CELL_NODES, Mesh, MeshError};
use std::collections::BTreeMap;

/// A solid cell of a layer over a plane cell.
struct Piece {
    kind: CellKind,
    /// Its corners: that of the plane cell, and 0 at the begin of the layer, 1 at its end.
    corners: Vec<(usize, usize)>,
    /// Its nodes: that of the plane cell, and the level from the begin of the layer.
    nodes: Vec<(usize, usize)>,
}

/// A solid cell with its place in the mesh.
struct Laid<'a> {
    piece: &'a Piece,
    layer: usize,
    /// The plane cell, by block and place.
    under: (u32, u32),
    /// Its own block and place.
    own: (u32, u32),
}

impl Laid<'_> {
    /// Its facets whose corners have a property.
    fn facets(&self, is: impl Fn(&[(usize, usize)]) -> bool) -> Vec<Facet> {
        let (block, cell) = self.own;
        let local = self.piece.facets(is).into_iter();
        local.map(|local| Facet { block, cell, local }).collect()
    }
}

/// The corners of a cell that a reference node of it is in the middle of.
fn amid(kind: CellKind, node: &[f64; 3]) -> Vec<usize> {
    let linear = match kind.domain() {
        Domain::Line => CellKind::Line2,
        Domain::Triangle => CellKind::Tri3,
        Domain::Square => CellKind::Quad4,
        Domain::Tetrahedron => CellKind::Tet4,
        Domain::Cube => CellKind::Hex8,
        Domain::Prism => CellKind::Prism6,
    };
    let mut shares = [0.0; MAX_CELL_NODES];
    linear.shape(node, &mut shares);
    let corners = 0..linear.nodes();
    // the smallest share is that of a corner in the centre of a cube
    corners.filter(|&corner| shares[corner] > 0.1).collect()
}

impl Piece {
    /// The cell with these corners over a plane cell, whose nodes are on the axis or not.
    fn new(kind: CellKind, corners: Vec<(usize, usize)>, plane: CellKind, on: &[bool]) -> Self {
        let below: Vec<Vec<usize>> = plane
            .reference_nodes()
            .iter()
            .map(|node| amid(plane, node))
            .collect();
        let place = |node: &[f64; 3]| {
            let among: Vec<(usize, usize)> = amid(kind, node)
                .into_iter()
                .map(|corner| corners[corner])
                .collect();
            let mut under: Vec<usize> = among.iter().map(|corner| corner.0).collect();
            under.sort_unstable();
            under.dedup();
            let off: Vec<usize> = among
                .iter()
                .filter(|corner| !on[corner.0])
                .map(|corner| corner.1)
                .collect();
            let level = off.iter().sum::<usize>() * plane.order() / off.len().max(1);
            let node = below.iter().position(|own| *own == under);
            (node.unwrap_or(0), level)
        };
        let nodes = kind.reference_nodes().iter().map(place).collect();
        Self {
            kind,
            corners,
            nodes,
        }
    }

    /// Its facets whose corners have a property, by their places.
    fn facets(&self, is: impl Fn(&[(usize, usize)]) -> bool) -> Vec<u32> {
        let facets = self.kind.facets().iter().enumerate();
        let corners = |shape: CellKind, local: &[usize]| -> Vec<(usize, usize)> {
            let own = local[..shape.corners()].iter();
            own.map(|&corner| self.corners[corner]).collect()
        };
        let facets = facets.filter(|(_, (shape, local))| is(&corners(*shape, local)));
        facets.map(|(place, _)| place as u32).collect()
    }
}

/// The cells of a layer over a plane cell with these nodes, whose nodes are on the axis or not; `cut` makes tetrahedra of triangles.
fn pieces(
    plane: CellKind,
    (nodes, on): (&[u32], &[bool]),
    (full, cut): (bool, bool),
) -> Result<Vec<Piece>, MeshError> {
    let count = plane.corners();
    let touching: Vec<usize> = (0..count).filter(|&corner| on[corner]).collect();
    let tetrahedron = match plane.order() {
        1 => CellKind::Tet4,
        _ => CellKind::Tet10,
    };
    if cut {
        let mut sorted = [0, 1, 2];
        sorted.sort_unstable_by_key(|&corner| nodes[corner]);
        let [p, q, r] = sorted;
        let all = [
            [(p, 0), (q, 0), (r, 0), (r, 1)],
            [(p, 0), (q, 0), (q, 1), (r, 1)],
            [(p, 0), (p, 1), (q, 1), (r, 1)],
        ];
        let twice = [r, q, p];
        let kept = all.into_iter().zip(twice).filter(|(_, twice)| !on[*twice]);
        let tetrahedra =
            kept.map(|(corners, _)| Piece::new(tetrahedron, corners.to_vec(), plane, on));
        return Ok(tetrahedra.collect());
    }
    // the corner from which an edge runs along the axis
    let edge = touching
        .iter()
        .copied()
        .find(|&corner| on[(corner + 1) % count]);
    let piece = match (touching.len(), count, edge) {
        (0, ..) => {
            let corners = [0, 1].into_iter();
            let corners = corners.flat_map(|end| (0..count).map(move |corner| (corner, end)));
            Piece::new(carried(plane, full), corners.collect(), plane, on)
        }
        (2, 3, Some(a)) => {
            let [b, c] = [1, 2].map(|k| (a + k) % 3);
            let corners = vec![(a, 0), (b, 0), (c, 0), (c, 1)];
            Piece::new(tetrahedron, corners, plane, on)
        }
        (2, 4, Some(a)) => {
            let [b, c, d] = [1, 2, 3].map(|k| (a + k) % 4);
            let corners = vec![(a, 0), (d, 0), (d, 1), (b, 0), (c, 0), (c, 1)];
            let prism = match (plane.order(), full) {
                (1, _) => CellKind::Prism6,
                (_, true) => CellKind::Prism18,
                _ => CellKind::Prism15,
            };
            Piece::new(prism, corners, plane, on)
        }
        _ => {
            let value = format!("through one corner of a {}", plane.name());
            let need = "where it touches the mesh, quadrilaterals have a whole edge on it; or let the mesh be of triangles alone";
            return Err(wrong("extrude", "axis", value, need));
        }
    };
    Ok(vec![piece])
}

/// Errors: a curved edge that touches the axis between its ends, or leaves it there.
fn check_edges(kind: CellKind, on: &[bool]) -> Result<(), MeshError> {
    let nodes = kind.reference_nodes().iter().enumerate();
    let wrongly = |(node, place): (usize, &[f64; 3])| {
        on[node] != amid(kind, place).iter().all(|&corner| on[corner])
    };
    match nodes.skip(kind.corners()).any(wrongly) {
        false => Ok(()),
        true => {
            let value = "along a curved edge".to_string();
            let need = "an edge of the mesh that touches it lies on it, or only ends there";
            Err(wrong("extrude", "axis", value, need))
        }
    }
}

/// A plane mesh of one order that touches its axis at the nodes `on`, carried around it in layers, which close on themselves or not.
/// Callbacks give the point from node and level, and the surface over an edge. The ends are the sides `first` and `last`; what lies on the
/// axis is no part of a side, and a side without facets goes.
///
/// Errors: cells that touch the axis in a way that makes no solid cell.
pub(super) fn around_axis(
    (plane, on): (&Mesh<2>, &[bool]),
    full: bool,
    (layers, closed): (usize, bool),
    at: impl Fn(Point<2>, usize) -> Point<3>,
    over: impl Fn(&Mesh<2>, Facet) -> Option<Surface<3>>,
) -> Result<Mesh<3>, MeshError> {
    let pieces = all_pieces(plane, on, full)?;
    let (kinds, laid) = lay(&pieces, layers);
    let order = plane.blocks()[0].kind.order();
    let place = |own: &Laid<'_>, (local, level): (usize, usize)| {
        let node = nodes_of(plane, own.under)[local];
        let level = order * own.layer + level;
        match (on[node as usize], closed) {
            (true, _) => (0, node),
            (_, true) => (level % (order * layers), node),
            _ => (level, node),
        }
    };
    let mut numbers: BTreeMap<(usize, u32), u32> = BTreeMap::new();
    for own in &laid {
        numbers.extend(own.piece.nodes.iter().map(|&node| (place(own, node), 0)));
    }
    let mut points = Vec::with_capacity(numbers.len());
    for (number, (&(level, node), own)) in numbers.iter_mut().enumerate() {
        *own = number as u32;
        points.push(at(plane.points()[node as usize], level));
    }
    let block = |&(under, kind): &(u32, CellKind)| CellBlock {
        kind,
        nodes: Vec::new(),
        group: plane.blocks()[under as usize].group.clone(),
    };
    let mut blocks: Vec<CellBlock> = kinds.iter().map(block).collect();
    for own in &laid {
        let nodes = own.piece.nodes.iter();
        let nodes = nodes.map(|&node| numbers[&place(own, node)]);
        blocks[own.own.0 as usize].nodes.extend(nodes);
    }
    let faces = Faces::new(plane, &laid);
    let mut sides = faces.sides();
    let ends = [("first", 0, 0), ("last", 1, layers - 1)];
    for (name, end, layer) in ends.into_iter().filter(|_| !closed) {
        let facets = faces.end(end, layer, on);
        if sides.insert(name.to_string(), facets).is_some() {
            let side = name.to_string();
            return Err(MeshError::SideExists { side });
        }
    }
    let mut curves = BTreeMap::new();
    for edge in plane.boundary_facets() {
        if let Some(surface) = over(plane, edge) {
            curves.extend(faces.over(edge).into_iter().map(|facet| (facet, surface)));
        }
    }
    Mesh::assembled(points, blocks, sides, curves)
}

/// Nodes of a plane cell by block and place.
fn nodes_of(plane: &Mesh<2>, (block, cell): (u32, u32)) -> &[u32] {
    let block = &plane.blocks()[block as usize];
    let count = block.kind.nodes();
    &block.nodes[count * cell as usize..][..count]
}

/// The pieces of one layer over every plane cell, by its block and place.
fn all_pieces(
    plane: &Mesh<2>,
    on: &[bool],
    full: bool,
) -> Result<BTreeMap<(u32, u32), Vec<Piece>>, MeshError> {
    let cut = plane.blocks().iter().all(|block| block.kind.corners() == 3);
    let mut all = BTreeMap::new();
    for (index, block) in plane.blocks().iter().enumerate() {
        for (cell, nodes) in block.cells().enumerate() {
            let on: Vec<bool> = nodes.iter().map(|&node| on[node as usize]).collect();
            check_edges(block.kind, &on)?;
            let made = pieces(block.kind, (nodes, &on), (full, cut))?;
            all.insert((index as u32, cell as u32), made);
        }
    }
    Ok(all)
}

/// The blocks, by that of the plane and kind, and all cells with their places in these, layer after layer.
fn lay(
    pieces: &BTreeMap<(u32, u32), Vec<Piece>>,
    layers: usize,
) -> (Vec<(u32, CellKind)>, Vec<Laid<'_>>) {
    let (mut kinds, mut counts, mut laid) = (Vec::new(), Vec::new(), Vec::new());
    for layer in 0..layers {
        for (&under, pieces) in pieces {
            for piece in pieces {
                let key = (under.0, piece.kind);
                let block = kinds.iter().position(|known| *known == key);
                let block = block.unwrap_or_else(|| {
                    kinds.push(key);
                    counts.push(0);
                    kinds.len() - 1
                });
                let own = (block as u32, counts[block]);
                counts[block] += 1;
                laid.push(Laid {
                    piece,
                    layer,
                    under,
                    own,
                });
            }
        }
    }
    (kinds, laid)
}

/// The facets of the solid.
struct Faces<'a> {
    plane: &'a Mesh<2>,
    /// Its cells over each plane cell.
    over: BTreeMap<(u32, u32), Vec<&'a Laid<'a>>>,
}

impl<'a> Faces<'a> {
    fn new(plane: &'a Mesh<2>, laid: &'a [Laid<'a>]) -> Self {
        let mut over: BTreeMap<(u32, u32), Vec<&Laid<'_>>> = BTreeMap::new();
        for own in laid {
            over.entry(own.under).or_default().push(own);
        }
        Self { plane, over }
    }

    /// Those over an edge of the plane mesh, none where it lies on the axis.
    fn over(&self, edge: Facet) -> Vec<Facet> {
        let kind = self.plane.blocks()[edge.block as usize].kind;
        let ends = &kind.facets()[edge.local as usize].1[..2];
        let cells = self.over.get(&(edge.block, edge.cell));
        let on_edge =
            |corners: &[(usize, usize)]| corners.iter().all(|corner| ends.contains(&corner.0));
        let cells = cells.into_iter().flatten();
        cells.flat_map(|own| own.facets(on_edge)).collect()
    }

    /// The sides over those of the plane mesh that do not lie on the axis.
    fn sides(&self) -> BTreeMap<String, Vec<Facet>> {
        let sides = self.plane.sides().iter().map(|(name, edges)| {
            let facets = edges.iter().flat_map(|&edge| self.over(edge));
            (name.clone(), facets.collect::<Vec<_>>())
        });
        sides.filter(|(_, facets)| !facets.is_empty()).collect()
    }

    /// The plane mesh itself, at the begin (0) or end (1) of a layer.
    fn end(&self, end: usize, layer: usize, on: &[bool]) -> Vec<Facet> {
        let cells = self.over.values().flatten();
        let cells = cells.filter(|own| own.layer == layer);
        let facets = cells.flat_map(|own| {
            let nodes = nodes_of(self.plane, own.under);
            own.facets(|corners| {
                let mut under: Vec<usize> = corners.iter().map(|corner| corner.0).collect();
                under.sort_unstable();
                under.dedup();
                let mut corners = corners.iter();
                under.len() > 2
                    && corners.all(|corner| corner.1 == end || on[nodes[corner.0] as usize])
            })
        });
        facets.collect()
    }
}
