//! Surfaces without a body behind them, for rigid tools.
//!
//! A facet belongs to a cell. The cells of a shell only carry its facets: behind each stands one with a corner of its own. They may cut
//! each other, and nothing is computed in them; the boundary of a shell are its facets alone.

use crate::geometry::{Point, Surface, add_scaled, cross, distance, norm, sub};
use crate::mesh::{CellBlock, CellKind, Contour, Facet, Mesh, MeshError, OutlineEdge, OutlinePart};
use std::collections::BTreeMap;

/// The cell behind a facet is this part of the facet deep.
const DEPTH: f64 = 0.5;

impl<const D: usize> Mesh<D> {
    /// The shell of these facets, each of D corners: segments of the plane with the solid on their left, triangles of space that turn
    /// outwards; with the true curves behind some of them, by their places. Its side has this name.
    ///
    /// Errors: as [`Self::new`].
    pub(crate) fn shell(
        name: &str,
        mut points: Vec<Point<D>>,
        facets: &[[u32; D]],
        curves: &BTreeMap<usize, Surface<D>>,
    ) -> Result<Self, MeshError> {
        let corners = points.len();
        let mut nodes = Vec::new();
        for facet in facets {
            let apex = points.len() as u32;
            points.push(behind(facet.map(|node| points[node as usize])));
            nodes.extend(facet);
            nodes.push(apex);
            if D == 3 {
                // a cell turns the other way round than what one sees of its first facet from outside
                let last = nodes.len();
                nodes.swap(last - 3, last - 2);
            }
        }
        let kind = if D == 3 {
            CellKind::Tet4
        } else {
            CellKind::Tri3
        };
        let block = CellBlock {
            kind,
            group: None,
            nodes,
        };
        let mut mesh = Self::new(points, vec![block])?;
        let front = |cell: usize| {
            let facets = (0..kind.facets().len()).map(|local| Facet {
                block: 0,
                cell: cell as u32,
                local: local as u32,
            });
            let whole = |facet: &Facet| {
                mesh.facet_nodes(*facet)
                    .all(|node| (node as usize) < corners)
            };
            facets.into_iter().find(whole)
        };
        let front: Vec<Facet> = (0..facets.len()).filter_map(front).collect();
        let curves = curves.iter().map(|(&place, &curve)| (front[place], curve));
        mesh.curves = curves.collect();
        mesh.shell = true;
        mesh.sides.insert(name.to_string(), front);
        Ok(mesh)
    }
}

/// An arc of an outline becomes facets of at most this angle, with their circle behind them.
const TURN: f64 = std::f64::consts::PI / 60.0;

/// The parts of a shell in the plane.
pub(crate) struct Segments {
    /// Their ends.
    pub points: Vec<Point<2>>,
    /// Two ends of each; the solid lies on the left of the way.
    pub segments: Vec<[u32; 2]>,
    /// The circles behind some of them, by their places.
    pub curves: BTreeMap<usize, Surface<2>>,
}

impl Segments {
    /// Those of a path from a point along some edges, which closes where it ends at its beginning.
    ///
    /// Errors: edges without a length, arcs whose ends are not equally far from their centre, coordinates that are not finite.
    pub fn of(from: Point<2>, edges: &[OutlineEdge]) -> Result<Self, MeshError> {
        let path = Contour::Path {
            from,
            edges: edges.to_vec(),
        };
        let mut all = Self {
            points: vec![from],
            segments: Vec::new(),
            curves: BTreeMap::new(),
        };
        for drawn in path.curves(OutlinePart::Line(0))? {
            let circle = drawn.curve.circle();
            let turn = match circle {
                Some(Surface::Sphere { radius, .. }) => drawn.curve.length() / radius,
                _ => 0.0,
            };
            let pieces = ((turn / TURN).ceil() as usize).max(1);
            for piece in 1..=pieces {
                let end = drawn.curve.point(piece as f64 / pieces as f64);
                let before = all.points.len() as u32 - 1;
                let closes = piece == pieces && end == from;
                if !closes {
                    all.points.push(end);
                }
                let end = if closes { 0 } else { before + 1 };
                all.curves
                    .extend(circle.map(|circle| (all.segments.len(), circle)));
                all.segments.push([before, end]);
            }
        }
        Ok(all)
    }
}

/// A point behind a facet with these corners.
fn behind<const D: usize>(corners: [Point<D>; D]) -> Point<D> {
    let share = 1.0 / D as f64;
    let middle = corners
        .iter()
        .fold([0.0; D], |sum, &x| add_scaled(sum, share, x));
    let along = sub(corners[1], corners[0]);
    let outward: Point<D> = match D {
        2 => {
            let mut right = [0.0; D];
            (right[0], right[1]) = (along[1], -along[0]);
            right
        }
        _ => {
            let normal = cross(along, sub(corners[D - 1], corners[0]));
            std::array::from_fn(|d| normal[d])
        }
    };
    let size = corners
        .iter()
        .map(|&x| distance(x, corners[0]))
        .fold(0.0, f64::max);
    add_scaled(
        middle,
        -DEPTH * size / norm(outward).max(f64::MIN_POSITIVE),
        outward,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_looks_outwards_and_has_no_other_boundary() {
        let corners = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]];
        let shell = Mesh::shell("tool", corners, &[[0, 1], [1, 2]], &BTreeMap::new()).unwrap();
        let facets = shell.boundary_facets();
        assert_eq!(facets, shell.side("tool").unwrap());
        let normals: Vec<Point<2>> = facets
            .iter()
            .map(|&f| shell.outward_normal(f, &[0.0]))
            .collect();
        assert!(normals[0][1] < 0.0 && normals[1][0] > 0.0, "{normals:?}");

        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let outward = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let shell = Mesh::shell("tool", corners, &outward, &BTreeMap::new()).unwrap();
        for (facet, outward) in shell.boundary_facets().into_iter().zip(outward) {
            let nodes: Vec<u32> = shell.facet_nodes(facet).collect();
            assert!(outward.iter().all(|node| nodes.contains(node)));
            let middle = shell.facet_point(facet, &[1.0 / 3.0, 1.0 / 3.0]);
            let normal = shell.outward_normal(facet, &[1.0 / 3.0, 1.0 / 3.0]);
            let from_inside = sub(middle, [0.25; 3]);
            assert!(crate::geometry::dot(normal, from_inside) > 0.0);
        }
    }
}
