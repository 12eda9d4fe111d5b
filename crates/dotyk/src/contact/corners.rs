//! Sides with sharp corners, in space edges, taken apart: a corner has a normal, and a condition, for each of its faces.
//!
//! One condition along the mean of two normals would let the corner of a block slide through the floor of the pocket that
//! it sits in, as soon as it leaves the wall.

use crate::contact::curved::true_surface;
use crate::contact::{ContactError, End};
use crate::geometry::{Groups, Point, dot};
use crate::mesh::{Facet, SHARP};
use std::collections::BTreeMap;

/// The parts of a side between its sharp corners or edges, in the order of its chain, in space of their first facets; the whole
/// where it has none.
///
/// Errors: unknown or empty sides, nodes off the true surface of the side.
pub fn smooth_parts<const D: usize>(end: End<'_, D>) -> Result<Vec<Vec<Facet>>, ContactError> {
    let (mesh, side) = (&end.body.mesh, end.facets()?);
    let Surfaces { first, sharp } = surfaces(end)?;
    if !sharp {
        return Ok(vec![side.to_vec()]);
    }
    let mut parts: BTreeMap<usize, Vec<Facet>> = BTreeMap::new();
    for (&facet, &first) in side.iter().zip(&first) {
        parts.entry(first).or_default().push(facet);
    }
    let mut parts: Vec<Vec<Facet>> = parts.into_values().collect();
    if let Some(plane) = mesh.in_plane() {
        let chains = plane.chain(end.side).unwrap_or_default();
        let along = chains.iter().flat_map(|chain| &chain.facets).enumerate();
        let place: BTreeMap<Facet, usize> = along.map(|(place, &facet)| (facet, place)).collect();
        let first = |part: &Vec<Facet>| part.iter().filter_map(|facet| place.get(facet)).min();
        parts.sort_by_key(|part| first(part).copied());
    }
    Ok(parts)
}

/// The smooth surfaces of a side: facets that meet at common nodes without a corner.
pub(super) struct Surfaces {
    /// By facet of the side, the index of the first one of its surface.
    pub first: Vec<usize>,
    /// Some facets meet at a corner.
    pub sharp: bool,
}

/// Errors: unknown or empty sides, nodes off the true surface of the side.
pub(super) fn surfaces<const D: usize>(end: End<'_, D>) -> Result<Surfaces, ContactError> {
    let (mesh, side) = (&end.body.mesh, end.facets()?);
    let known = true_surface(end, side)?;
    let mut around: BTreeMap<usize, Vec<(usize, Point<D>)>> = BTreeMap::new();
    for (index, &facet) in side.iter().enumerate() {
        let kind = mesh.facet_kind(facet);
        for (node, xi) in mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
            let normal = known.normal(facet, xi);
            around
                .entry(node as usize)
                .or_default()
                .push((index, normal));
        }
    }
    let (mut groups, mut sharp) = (Groups::new(side.len()), false);
    for meeting in around.values() {
        for (place, &(a, normal)) in meeting.iter().enumerate() {
            for &(b, other) in &meeting[place + 1..] {
                match dot(normal, other) > SHARP {
                    true => groups.join(a, b),
                    false => sharp = true,
                }
            }
        }
    }
    Ok(Surfaces {
        first: (0..side.len()).map(|index| groups.first(index)).collect(),
        sharp,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, end, plate, ring, wall};
    use crate::fem::{Body, Constraints};
    use crate::mesh::{CellKind, Cuboid, Mesh};

    fn parts<const D: usize>(mesh: Mesh<D>, side: &str) -> (Body<D>, Vec<Vec<Facet>>) {
        let (body, free) = (body(mesh), Constraints::default());
        let parts = smooth_parts(end(&body, side, &free)).unwrap();
        (body, parts)
    }

    #[test]
    fn the_four_faces_of_a_plate_are_parts_in_the_order_of_the_chain() {
        let mesh = plate([0.0, 0.0], [3.0, 1.0], [4, 2]).mesh;
        let mesh = mesh.with_side("all", |[x, y]| {
            [x, 3.0 - x, y, 1.0 - y].into_iter().any(|c| c.abs() < 1e-9)
        });
        let (body, parts) = parts(mesh, "all");
        assert_eq!(parts.iter().map(Vec::len).sum::<usize>(), 12);
        let along = body.mesh.chain("all").unwrap()[0].facets.clone();
        let place = |facet: &Facet| along.iter().position(|f| f == facet).unwrap();
        let firsts: Vec<usize> = parts
            .iter()
            .map(|part| part.iter().map(place).min().unwrap())
            .collect();
        assert!(firsts.is_sorted());
        for name in ["bottom", "right", "top", "left"] {
            let face = body.mesh.side(name).unwrap();
            assert!(parts.iter().any(|part| part == face), "{name}");
        }
    }

    #[test]
    fn facets_meet_at_a_corner_when_their_normals_turn_too_far() {
        for (angle, count) in [(30.0f64, 1), (30.1, 2)] {
            let (s, c) = angle.to_radians().sin_cos();
            for cell in [CellKind::Quad4, CellKind::Quad8] {
                let points = [
                    [-2.0, 0.0],
                    [-1.0, 0.0],
                    [0.0, 0.0],
                    [c, s],
                    [2.0 * c, 2.0 * s],
                ];
                let mesh = wall(&points, 4.0, cell).mesh;
                let (body, parts) = parts(mesh, "bottom");
                assert_eq!(parts.len(), count, "{angle}");
                let whole = body.mesh.side("bottom").unwrap();
                let all: Vec<Facet> = parts.into_iter().flatten().collect();
                assert_eq!(all, whole);
            }
        }
    }

    #[test]
    fn a_smooth_side_stays_whole() {
        let (body, found) = parts(ring([0.0, 0.0], [1.0, 2.0], 12).mesh, "outer");
        assert_eq!(found, [body.mesh.side("outer").unwrap()]);
        // so do two faces that do not touch
        let mesh = plate([0.0, 0.0], [3.0, 1.0], [4, 2]).mesh;
        let mesh = mesh.with_side("both", |[_, y]| y * (1.0 - y) < 1e-9);
        let (body, found) = parts(mesh, "both");
        assert_eq!(found, [body.mesh.side("both").unwrap()]);
    }

    #[test]
    fn the_faces_of_a_box_are_parts_whatever_the_order_of_their_facets() {
        for cell in [CellKind::Tet4, CellKind::Hex8] {
            let cuboid = Cuboid {
                from: [0.0; 3],
                to: [1.0; 3],
                cells: [3, 3, 3],
                cell,
            };
            let mesh = cuboid.build().unwrap();
            let mesh = mesh.with_side("all", |_| true);
            let (body, parts) = parts(mesh, "all");
            assert_eq!(parts.len(), 6);
            for name in ["left", "right", "front", "back", "bottom", "top"] {
                let face = body.mesh.side(name).unwrap();
                assert!(parts.iter().any(|part| part == face), "{name}");
            }
            let firsts: Vec<Facet> = parts.iter().map(|part| part[0]).collect();
            assert!(firsts.is_sorted());
        }
    }

    #[test]
    fn an_unknown_side_has_no_parts() {
        let (body, free) = (
            plate([0.0, 0.0], [1.0, 1.0], [1, 1]),
            Constraints::default(),
        );
        let error = smooth_parts(end(&body, "nowhere", &free)).unwrap_err();
        assert!(error.to_string().contains("nowhere"), "{error}");
    }
}
