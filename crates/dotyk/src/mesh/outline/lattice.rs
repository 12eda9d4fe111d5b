//! Structured meshes of the plane made anew: the outline of their sides, which are lines and arcs, filled with triangles of the same
//! order.
//!
//! A square of area A becomes a wish for h = √(2A/√3) at its place: equilateral triangles of this size have as many nodes per area.

use crate::geometry::{Point, Surface, sub};
use crate::mesh::outline::curve::cross;
use crate::mesh::outline::nouns::{Contour, EdgeShape, GROWTH, Outline, OutlineEdge};
use crate::mesh::{CellKind, Generator, Mesh, MeshError, Rectangle, Ring, SizeField, TunnelRock};

macro_rules! filled {
    ($($Lattice:ident)*) => {$(
        impl Generator<2> for $Lattice {
            fn anew(&self, sizes: &SizeField<2>, nodes: &[Point<2>]) -> Result<Mesh<2>, MeshError> {
                triangles(&self.build()?, sizes, nodes)
            }
        }
    )*};
}

filled!(Rectangle Ring TunnelRock);

/// The outline of a lattice, filled with triangles.
fn triangles(
    lattice: &Mesh<2>,
    sizes: &SizeField<2>,
    nodes: &[Point<2>],
) -> Result<Mesh<2>, MeshError> {
    let block = &lattice.blocks()[0];
    let corners = block.kind.corners();
    let own = block.cells().map(|cell| {
        let at = |k: usize| lattice.points()[cell[k] as usize];
        let from = |k: usize| sub(at(k), at(0));
        let twice: f64 = (2..corners).map(|k| cross(from(k - 1), from(k))).sum();
        // A square has two triangles.
        let triangle = 0.5 * twice / (corners - 2) as f64;
        (4.0 * triangle / 3.0_f64.sqrt()).sqrt()
    });
    let own: Vec<f64> = own.collect();
    let largest = own.iter().copied().fold(0.0, f64::max);
    let field = SizeField::of_cells(lattice, &own, GROWTH)?;
    let outline = Outline {
        cell: match block.kind.order() {
            1 => CellKind::Tri3,
            _ => CellKind::Tri6,
        },
        ..outline(lattice, largest.min(lattice.diameter()))
    };
    outline.anew(&field.and(sizes), nodes)
}

/// The outline of a mesh each of whose sides has chains of straight facets on a line, or of facets on an arc.
fn outline(mesh: &Mesh<2>, size: f64) -> Outline {
    let (mut circles, mut open) = (Vec::new(), Vec::new());
    for side in mesh.side_names() {
        for chain in mesh.chain(side).into_iter().flatten() {
            let at = |k: usize| mesh.points()[chain.nodes[k] as usize];
            let circle = match mesh.curve(chain.facets[0]) {
                Some(Surface::Sphere { center, radius }) => Some((center, radius)),
                _ => None,
            };
            if let (true, Some((center, radius))) = (chain.cyclic, circle) {
                let circle = Contour::Circle {
                    center,
                    radius,
                    names: vec![side.to_string()],
                    division: None,
                };
                circles.push((radius, circle));
                continue;
            }
            let (from, to) = (at(0), at(chain.nodes.len() - 1));
            let shape = circle.map_or(EdgeShape::Line, |(center, _)| EdgeShape::Center {
                center,
                clockwise: cross(sub(from, center), sub(at(1), center)) < 0.0,
            });
            open.push((from, OutlineEdge::of(to, shape).named(side)));
        }
    }
    // The outer circle last.
    circles.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut contours: Vec<Contour> = circles.into_iter().map(|(_, circle)| circle).collect();
    if let Some((from, edge)) = open.pop() {
        let mut edges = vec![edge];
        while let Some(next) = open
            .iter()
            .position(|(from, _)| *from == edges[edges.len() - 1].to)
        {
            edges.push(open.swap_remove(next).1);
        }
        contours.push(Contour::Path { from, edges });
    }
    let boundary = contours.pop().unwrap_or_else(|| Contour::polygon(&[]));
    Outline {
        holes: contours,
        ..Outline::new(boundary, size)
    }
}
