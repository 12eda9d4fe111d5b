//! Which parts of two sides face each other although their nodes do not coincide.
//!
//! A facet sees the other side when the line from one of its points along its outward normal meets a facet there whose
//! outward normal is opposed. Node-to-node pairing is right where no facet with a node of its own sees the other side.

use crate::contact::node_to_node::matching_nodes;
use crate::contact::search::{Hit, Line, SideSearch};
use crate::contact::{ContactError, End};
use crate::geometry::{Point, add_scaled, sub, unit};
use crate::mesh::{Facet, Mesh};
use std::collections::BTreeSet;

/// A node without a partner on a facet that faces the other side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unmatched<const D: usize> {
    /// It belongs to the mortar side.
    pub of_mortar: bool,
    /// The node.
    pub node: usize,
    /// Its position.
    pub point: Point<D>,
    /// Distance of the nearest node of the other side.
    pub distance: f64,
}

/// The first facet that faces the other side and has a node without a partner; `None` if node-to-node pairing is complete,
/// because all nodes there coincide or the sides do not face each other.
///
/// Errors: unknown or empty sides.
pub fn unmatched_facing<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
) -> Result<Option<Unmatched<D>>, ContactError> {
    for (own, other, of_mortar) in [(nonmortar, mortar, false), (mortar, nonmortar, true)] {
        let matches = matching_nodes(own, other)?;
        let mesh = &own.body.mesh;
        let search = SideSearch::new(mesh, &other.body.mesh, other.facets()?);
        for &facet in own.facets()? {
            let lonely = mesh
                .facet_nodes(facet)
                .map(|node| node as usize)
                .find(|node| matches[node].0.is_none());
            if let Some(node) = lonely
                && sees(mesh, facet, &search)
            {
                return Ok(Some(Unmatched {
                    of_mortar,
                    node,
                    point: mesh.points()[node],
                    distance: matches[&node].1,
                }));
            }
        }
    }
    Ok(None)
}

/// Whether facets that face each other have the same nodes: else coincident nodes bear different parts of a pressure on the
/// two sides (a quadratic facet over two linear ones, triangles over squares), and node-to-node pairing does not transmit a
/// uniform pressure.
///
/// Errors: unknown or empty sides.
pub fn facets_coincide<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
) -> Result<bool, ContactError> {
    let (mesh, other) = (&nonmortar.body.mesh, &mortar.body.mesh);
    let matches = matching_nodes(nonmortar, mortar)?;
    let opposite = mortar.facets()?;
    let search = SideSearch::new(mesh, other, opposite);
    let nodes_of = |mesh: &Mesh<D>, facet: Facet| -> BTreeSet<usize> {
        mesh.facet_nodes(facet).map(|node| node as usize).collect()
    };
    let known: BTreeSet<BTreeSet<usize>> = opposite
        .iter()
        .map(|&facet| nodes_of(other, facet))
        .collect();
    let own = nonmortar.facets()?.iter();
    Ok(own.copied().all(|facet| {
        let partners = nodes_of(mesh, facet).into_iter();
        let partners: Option<BTreeSet<usize>> = partners.map(|node| matches[&node].0).collect();
        partners.is_none_or(|nodes| known.contains(&nodes) || !sees(mesh, facet, &search))
    }))
}

/// Lines start at the middle of a facet and at these parts of the way to its corners. Where two sides share less than a thousandth
/// of their facets nodes have no multipliers in any pairing; the judge finds overlaps there between the nodes.
const STARTS: [f64; 5] = [0.0, 0.5, 0.9, 0.99, 0.999];

fn sees<const D: usize>(mesh: &Mesh<D>, facet: Facet, search: &SideSearch<'_, D>) -> bool {
    first_seen(mesh, facet, search, |_, _| true).is_some()
}

/// What a facet sees first, of what satisfies a condition on the line and its hit; lines start at all its [`STARTS`].
pub(crate) fn first_seen<const D: usize>(
    mesh: &Mesh<D>,
    facet: Facet,
    search: &SideSearch<'_, D>,
    satisfies: impl Fn(Line<D>, Hit) -> bool,
) -> Option<Hit> {
    let shallow = mesh.facet_length(facet);
    let kind = mesh.facet_kind(facet);
    let (corners, centre) = (kind.corners(), kind.domain().centre());
    let starts = STARTS.iter().flat_map(|part| {
        // they all start at the middle
        let corners = if *part == 0.0 { 1 } else { corners };
        let towards = kind.reference_nodes()[..corners].iter();
        towards.map(move |corner| add_scaled(centre, *part, sub(*corner, centre)))
    });
    starts.into_iter().find_map(|xi| {
        let line = Line {
            start: mesh.facet_point(facet, &xi),
            direction: unit(mesh.outward_normal(facet, &xi))?,
        };
        let hit = search.opposite(line, shallow)?;
        satisfies(line, hit).then_some(hit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, cube, end, flat, node_at, wall};
    use crate::fem::{Body, Constraints};
    use crate::mesh::{CellKind, Cuboid};

    fn unmatched(own: &Body<2>, other: &Body<2>) -> Option<Unmatched<2>> {
        let free = Constraints::default();
        unmatched_facing(end(own, "bottom", &free), end(other, "bottom", &free)).unwrap()
    }

    fn coincide(own: &Body<2>, other: &Body<2>) -> bool {
        let free = Constraints::default();
        facets_coincide(end(own, "bottom", &free), end(other, "bottom", &free)).unwrap()
    }

    #[test]
    fn sides_with_the_same_nodes_leave_none_unmatched() {
        let upper = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
        let same = flat(&[0.0, 1.0, 2.0], -1.0, CellKind::Quad4);
        assert_eq!(unmatched(&upper, &same), None);
        // a longer one has nodes without a partner where it faces nothing
        let longer = flat(&[-1.0, 0.0, 1.0, 2.0], -1.0, CellKind::Quad4);
        assert_eq!(unmatched(&upper, &longer), None);
        assert_eq!(unmatched(&longer, &upper), None);
        // nor does one that looks away
        let behind = flat(&[0.0, 1.3, 2.0], 1.0, CellKind::Quad4);
        assert_eq!(unmatched(&upper, &behind), None);
    }

    #[test]
    fn the_first_unmatched_node_is_told_with_its_side_and_distance() {
        let upper = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
        let lower = flat(&[0.0, 0.75, 1.0, 2.0], -1.0, CellKind::Quad4);
        let found = unmatched(&upper, &lower).unwrap();
        assert!(found.of_mortar);
        let node = node_at(&lower, [0.75, 0.0]);
        assert_eq!(
            (found.node, found.point, found.distance),
            (node, [0.75, 0.0], 0.25)
        );
        let found = unmatched(&lower, &upper).unwrap();
        assert!(!found.of_mortar);
        assert_eq!(
            (found.node, found.point, found.distance),
            (node, [0.75, 0.0], 0.25)
        );
    }

    #[test]
    fn a_facet_looks_from_its_middle_and_towards_its_ends() {
        // over a narrow body: seen at ξ = 0, ±0.5, ±0.9, ±0.99 and ±0.999 alone, else only by that body
        let upper = flat(&[-1.0, 1.0], 1.0, CellKind::Quad4);
        for (place, seen) in [
            (0.0, true),
            (0.5, true),
            (-0.5, true),
            (0.9, true),
            (-0.9, true),
            (0.25, false),
            (-0.25, false),
            (0.6, false),
            (0.96, true),
            (-0.96, true),
            (0.95, false),
            (-0.95, false),
        ] {
            let narrow = flat(&[place - 0.03, place + 0.03], -1.0, CellKind::Quad4);
            let found = unmatched(&upper, &narrow).unwrap();
            assert_eq!(found.of_mortar, !seen, "{place}");
        }
    }

    #[test]
    fn facets_coincide_when_they_have_the_same_nodes() {
        let places = [0.0, 1.0, 2.0, 3.0, 4.0];
        let build = |cell, height| flat(&places, height, cell);
        let (linear, quadratic) = (CellKind::Quad4, CellKind::Quad8);
        assert!(coincide(&build(linear, 1.0), &build(linear, -1.0)));
        assert!(coincide(&build(quadratic, 1.0), &build(quadratic, -1.0)));
        // one quadratic facet over two linear ones
        assert!(!coincide(&build(quadratic, 1.0), &build(linear, -1.0)));
        assert!(!coincide(&build(linear, 1.0), &build(quadratic, -1.0)));
        // facets that do not face the other side may have any nodes
        assert!(coincide(&build(quadratic, 1.0), &build(linear, 1.0)));
        // nodes without a partner are tested elsewhere
        let other = flat(&[0.0, 1.5, 4.0], -1.0, linear);
        assert!(coincide(&build(linear, 1.0), &other));
    }

    #[test]
    fn triangles_over_squares_do_not_coincide() {
        let free = Constraints::default();
        let tetrahedra = cube(0.0);
        let upper = |cell| {
            let cuboid = Cuboid {
                from: [0.0, 0.0, 1.0],
                to: [1.0, 1.2, 2.0],
                cells: [3; 3],
                cell,
            };
            body(cuboid.build().unwrap())
        };
        for (cell, same) in [(CellKind::Tet4, true), (CellKind::Hex8, false)] {
            let upper = upper(cell);
            let ends = [end(&tetrahedra, "top", &free), end(&upper, "bottom", &free)];
            assert_eq!(unmatched_facing(ends[0], ends[1]), Ok(None));
            assert_eq!(facets_coincide(ends[0], ends[1]), Ok(same));
            assert_eq!(facets_coincide(ends[1], ends[0]), Ok(same));
        }
    }

    #[test]
    fn an_overlap_as_deep_as_a_facet_is_seen() {
        // a thin body that is 0.9 or 1.1 of a facet deep in another
        for (depth, seen) in [(0.9, true), (1.1, false)] {
            let upper = flat(&[0.0, 1.0, 2.0], 0.1, CellKind::Quad4);
            let points = [[0.0, depth], [0.7, depth], [2.0, depth]];
            let lower = wall(&points, -0.2, CellKind::Quad4);
            let found = unmatched(&upper, &lower);
            assert_eq!(found.is_some_and(|found| !found.of_mortar), seen, "{depth}");
        }
    }
}
