//! Location of a point on a side in space: a facet, and the place on it.
//!
//! ```text
//!   min 1/2 |x(ξ) − p|²   over ξ in the reference facet,      ξ ← ξ + (JᵀJ)⁻¹Jᵀ(p − x(ξ)),  J = ∂x/∂ξ
//! ```
//!
//! Gauss–Newton steps, each drawn back into the reference facet, on all facets whose box is near enough; the nearest one is
//! taken. A point may lie beside the side by the sagitta of a polyhedron, and over an edge or a corner between its facets as
//! well as over a facet; beyond its rim only by rounding.

use crate::geometry::{Point, add_scaled, bounding_box, distance, dot, norm, sub, unit};
use crate::mesh::locate::{BESIDE, BEYOND, Located, SETTLED};
use crate::mesh::{CellKind, Facet, MAX_CELL_NODES, Mesh};
use std::collections::BTreeSet;

/// A corner with less than this weight does not count at a place.
const ABSENT: f64 = 1e-9;

/// A place on a facet.
struct Place<const D: usize> {
    facet: Facet,
    xi: [f64; 2],
    point: Point<D>,
    /// From the searched point.
    distance: f64,
    /// Of the box of the facet.
    size: f64,
}

/// Nodes and shape functions of the facet that is nearest to a point; `None` where the point lies beside the side.
pub(crate) fn locate_on_surface<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[Facet],
    point: Point<D>,
) -> Option<Located<D>> {
    let mut best: Option<Place<D>> = None;
    for &facet in facets {
        let corners: Vec<Point<D>> = mesh.facet_points(facet).collect();
        let (low, high) = bounding_box(&corners);
        let size = distance(low, high);
        let outside = std::array::from_fn(|i| (low[i] - point[i]).max(point[i] - high[i]).max(0.0));
        let reach = norm::<D>(outside);
        if reach > BESIDE * size || best.as_ref().is_some_and(|b| reach > b.distance) {
            continue;
        }
        let place = nearest(mesh, facet, point, size);
        if best.as_ref().is_none_or(|b| place.distance < b.distance) {
            best = Some(place);
        }
    }
    let place = best.filter(|place| place.distance <= BESIDE * place.size)?;
    if on_rim(mesh, facets, &place) && beyond(mesh, &place, point) > BEYOND * place.size {
        return None;
    }
    Some(Located::on_facet(mesh, place.facet, &place.xi))
}

/// The two tangents of a facet at a place.
fn tangents<const D: usize>(mesh: &Mesh<D>, facet: Facet, xi: [f64; 2]) -> [Point<D>; 2] {
    let mut gradients = [[0.0; 2]; MAX_CELL_NODES];
    mesh.facet_kind(facet).gradients(&xi, &mut gradients);
    let mut tangents = [[0.0; D]; 2];
    for (x, gradient) in mesh.facet_points(facet).zip(gradients) {
        for (tangent, slope) in tangents.iter_mut().zip(gradient) {
            *tangent = add_scaled(*tangent, slope, x);
        }
    }
    tangents
}

fn nearest<const D: usize>(mesh: &Mesh<D>, facet: Facet, point: Point<D>, size: f64) -> Place<D> {
    let kind = mesh.facet_kind(facet);
    let triangle = kind.corners() == 3;
    let mut xi = if triangle { [1.0 / 3.0; 2] } else { [0.0; 2] };
    for _ in 0..30 {
        let [a, b] = tangents(mesh, facet, xi);
        let rest = sub(point, mesh.facet_point(facet, &xi));
        let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
        let (ra, rb) = (dot(rest, a), dot(rest, b));
        let det = aa * bb - ab * ab;
        let step = [(ra * bb - rb * ab) / det, (rb * aa - ra * ab) / det];
        let next = drawn_back([xi[0] + step[0], xi[1] + step[1]], triangle);
        let moved = (next[0] - xi[0]).abs().max((next[1] - xi[1]).abs());
        xi = next;
        // a facet without area has no step
        if moved < SETTLED || moved.is_nan() {
            break;
        }
    }
    let at = mesh.facet_point(facet, &xi);
    Place {
        facet,
        xi,
        point: at,
        distance: distance(at, point),
        size,
    }
}

/// The nearest coordinates of the reference triangle or square.
fn drawn_back([a, b]: [f64; 2], triangle: bool) -> [f64; 2] {
    if !triangle {
        return [a.clamp(-1.0, 1.0), b.clamp(-1.0, 1.0)];
    }
    let excess = 0.5 * (a + b - 1.0).max(0.0);
    let a = (a - excess).clamp(0.0, 1.0);
    [a, (b - excess).clamp(0.0, 1.0 - a)]
}

/// Whether a place is on an edge that belongs to one facet of the side alone.
fn on_rim<const D: usize>(mesh: &Mesh<D>, facets: &[Facet], place: &Place<D>) -> bool {
    let kind = mesh.facet_kind(place.facet);
    let straight = match kind.corners() {
        3 => CellKind::Tri3,
        _ => CellKind::Quad4,
    };
    let mut weights = [0.0; MAX_CELL_NODES];
    straight.shape(&place.xi, &mut weights);
    let corners = mesh.facet_nodes(place.facet).take(kind.corners());
    let present = corners.zip(weights).filter(|(_, w)| w.abs() > ABSENT);
    let present: Vec<u32> = present.map(|(node, _)| node).collect();
    if present.len() > 2 {
        return false;
    }
    let mut once: BTreeSet<[u32; 2]> = BTreeSet::new();
    for &facet in facets {
        let count = mesh.facet_kind(facet).corners();
        let nodes: Vec<u32> = mesh.facet_nodes(facet).take(count).collect();
        for (k, &node) in nodes.iter().enumerate() {
            let mut edge = [node, nodes[(k + 1) % count]];
            edge.sort_unstable();
            if !once.insert(edge) {
                once.remove(&edge);
            }
        }
    }
    let mut rim = once.iter();
    rim.any(|edge| present.iter().all(|node| edge.contains(node)))
}

/// Distance of a point from a place along the facet.
fn beyond<const D: usize>(mesh: &Mesh<D>, place: &Place<D>, point: Point<D>) -> f64 {
    let rest = sub(point, place.point);
    let normal = mesh.outward_normal(place.facet, &place.xi);
    let Some(normal) = unit(normal) else {
        return norm(rest);
    };
    norm(add_scaled(rest, -dot(rest, normal), normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Cuboid;

    fn bent(cell: CellKind) -> Mesh<3> {
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [2.0, 1.0, 1.0],
            cells: [4, 3, 1],
            cell,
        };
        let bend = |[x, y, z]: Point<3>| [x, y + 0.1 * x, z + 0.05 * x * y];
        cuboid.build().unwrap().map_points(bend).unwrap()
    }

    #[test]
    fn a_point_of_a_facet_is_found_at_its_place() {
        for cell in [CellKind::Hex8, CellKind::Tet4] {
            let mesh = bent(cell);
            let side = mesh.side("top").unwrap();
            for &facet in side {
                for xi in [[0.25, 0.5], [0.1, 0.8], [0.0, 0.3], [0.5, 0.5]] {
                    let point = mesh.facet_point(facet, &xi);
                    let Located { nodes, shape, .. } =
                        locate_on_surface(&mesh, side, point).unwrap();
                    let mut found = [0.0; 3];
                    for (&node, n) in nodes.iter().zip(&shape) {
                        found = add_scaled(found, *n, mesh.points()[node]);
                    }
                    assert!(distance(found, point) < 1e-12, "{cell:?} {xi:?}");
                    assert!((shape.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn a_point_may_lie_over_an_edge_of_facets_and_not_beyond_the_rim() {
        let mesh = Cuboid {
            from: [0.0; 3],
            to: [1.0, 1.0, 1.0],
            cells: [2, 2, 1],
            cell: CellKind::Hex8,
        };
        // a roof along y
        let roof = |[x, y, z]: Point<3>| [x, y, z - 0.4 * (x - 0.5_f64).abs()];
        let mesh = mesh.build().unwrap().map_points(roof).unwrap();
        let side = mesh.side("top").unwrap();
        let found = |point| locate_on_surface(&mesh, side, point);
        assert!(found([0.5, 0.3, 1.02]).is_some());
        assert!(found([0.5, 0.3, 1.2]).is_none());
        assert!(found([0.5, 1.0 + 1e-9, 1.0]).is_some());
        assert!(found([0.5, 1.01, 1.0]).is_none());
        assert!(found([-0.01, 0.5, 0.8]).is_none());
        // over the middle of the ridge, a corner of four facets
        let Located { nodes, shape, .. } = found([0.5, 0.5, 1.01]).unwrap();
        let most = shape.iter().position(|n| *n > 0.99).unwrap();
        assert!(distance(mesh.points()[nodes[most]], [0.5, 0.5, 1.0]) < 1e-12);
    }
}
