//! Node-to-node pairing: one multiplier for each pair of coincident nodes.
//!
//! Row i is nᵢ·(u_s,i − u_m,j(i)), and likewise with the tangents where friction or a tie couples them; the weight of a node is
//! ∫Nᵢ over those facets of the nonmortar side all of whose nodes have a partner. Where supports hold the same direction on both
//! sides (a plane of symmetry), the normal is projected onto the free directions; if its projection vanishes, the node is fixed and
//! carries no multiplier.
//!
//! Source: Janovský & Procházka (1980) III, section 7 (normals by the bisector rule, axis direction on the axis).

use crate::contact::corners::Corners;
use crate::contact::normals::Normals;
use crate::contact::obstacle::{Driven, Rigid, beyond, finite_gap};
use crate::contact::relative::{Relative, axes, frame, shared};
use crate::contact::weights::nodal_weights;
use crate::contact::{
    ContactError, Coupling, End, GapPoint, GapShares, InitialGap, Interface, InterfaceNode, Role,
};
use crate::fem::{Analysis, show};
use crate::geometry::{Point, distance, dot, sub};
use crate::mesh::{Facet, Mesh};
use std::collections::{BTreeMap, BTreeSet};

/// Two nodes coincide within this fraction of the local edge.
const COINCIDENT: f64 = 1e-6;

/// Partner on the mortar side of every node of the nonmortar side (`None` without a node within 1e-6 of the local edge), and
/// the distance of the nearest node.
pub fn matching_nodes<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
) -> Result<BTreeMap<usize, (Option<usize>, f64)>, ContactError> {
    let (s, m) = (&nonmortar.body.mesh, &mortar.body.mesh);
    mortar.facets()?;
    let mut partners: Vec<usize> = m
        .side_nodes(mortar.side)
        .unwrap_or_default()
        .into_iter()
        .map(|node| node as usize)
        .collect();
    // sorted along x: candidates lie in a short window
    partners.sort_by(|&a, &b| m.points()[a][0].total_cmp(&m.points()[b][0]));
    let edges = shortest_edges(s, nonmortar.facets()?);
    let mut matches = BTreeMap::new();
    for (&node, &edge) in &edges {
        let point = s.points()[node];
        matches.insert(node, nearest_sorted(m, &partners, point, COINCIDENT * edge));
    }
    Ok(matches)
}

/// The nearest of some nodes sorted along x, with its distance; the partner only within `limit`.
fn nearest_sorted<const D: usize>(
    mesh: &Mesh<D>,
    sorted: &[usize],
    point: Point<D>,
    limit: f64,
) -> (Option<usize>, f64) {
    let x = |node: usize| mesh.points()[node][0];
    let start = sorted.partition_point(|&node| x(node) < point[0]);
    let mut best = (None, f64::INFINITY);
    let mut visit = |node: usize| {
        let d = distance(mesh.points()[node], point);
        if d < best.1 {
            best = (Some(node), d);
        }
        (x(node) - point[0]).abs() <= best.1
    };
    for &node in &sorted[start..] {
        if !visit(node) {
            break;
        }
    }
    for &node in sorted[..start].iter().rev() {
        if !visit(node) {
            break;
        }
    }
    (best.0.filter(|_| best.1 <= limit), best.1)
}

/// Shortest edge of the facets that meet at each node of a side.
fn shortest_edges<const D: usize>(mesh: &Mesh<D>, facets: &[Facet]) -> BTreeMap<usize, f64> {
    let mut edges = BTreeMap::new();
    for &facet in facets {
        let corners: Vec<Point<D>> = mesh.facet_points(facet).collect();
        let around = mesh.facet_kind(facet).corner_edges().iter().enumerate();
        let lengths = around.map(|(a, ends)| distance(corners[a], corners[ends[0]]));
        let shortest = lengths.fold(f64::INFINITY, f64::min);
        for node in mesh.facet_nodes(facet) {
            let edge = edges.entry(node as usize).or_insert(f64::INFINITY);
            *edge = shortest.min(*edge);
        }
    }
    edges
}

/// Pairs the coincident nodes of two sides.
///
/// Errors: unknown or empty sides, a nodal weight that is not positive, a gap that is not finite.
pub fn pair_nodes<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
    gap: InitialGap<'_>,
    coupling: Coupling,
    analysis: Analysis,
    time: f64,
) -> Result<Interface<D>, ContactError> {
    let matches = matching_nodes(nonmortar, mortar)?;
    let (s, m) = (&nonmortar.body.mesh, &mortar.body.mesh);
    build(
        nonmortar,
        coupling,
        (analysis, &Corners::new()),
        |node, _| matches[&node].0.is_some(),
        |node, normal| {
            let Some(j) = matches[&node].0 else {
                return Ok(None);
            };
            let (own, other) = (nonmortar.constraints.at(node), mortar.constraints.at(j));
            let relative = match std::ptr::eq(nonmortar.body, mortar.body) && node == j {
                true => Relative::none(),
                false => Relative {
                    prescribed: shared(&axes(own, |_| true), &axes(other, |_| true)),
                    still: shared(&axes(own, |h| h.still), &axes(other, |h| h.still)),
                },
            };
            let point = s.points()[node];
            let facing = normal;
            let normal = relative.free_normal(facing);
            let gap = match gap {
                InitialGap::Measured => dot(normal, sub(m.points()[j], point)),
                InitialGap::Adjusted(most) => beyond(most, dot(normal, sub(m.points()[j], point))),
                InitialGap::Closed => 0.0,
                InitialGap::Given(field) => finite_gap(field, point, time, nonmortar)?,
            };
            Ok(Some(OppositeNode {
                nodes: vec![(j, 1.0)],
                facing,
                normal,
                gap,
                relative,
            }))
        },
    )
}

/// A side, or a part of it, against a rigid obstacle; its rows on the other side act on the translation of the obstacle. `corners` are
/// those of the whole side where the end is a part.
///
/// Errors: as [`pair_nodes`].
pub fn pair_obstacle<const D: usize>(
    nonmortar: End<'_, D>,
    (rigid, driven, corners): (&Rigid<D>, Driven, &Corners<D>),
    coupling: Coupling,
    analysis: Analysis,
    time: f64,
) -> Result<Interface<D>, ContactError> {
    let mesh = &nonmortar.body.mesh;
    build(
        nonmortar,
        coupling,
        (analysis, corners),
        |node, normal| rigid.faces(mesh.points()[node], normal),
        |node, normal| {
            let held = nonmortar.constraints.at(node);
            let relative = Relative {
                prescribed: axes(held, |_| driven != Driven::Free),
                still: axes(held, |h| h.still && driven == Driven::Still),
            };
            let place = (mesh.points()[node], normal);
            let Some((facing, gap)) = rigid.opposite(place, time, nonmortar)? else {
                return Ok(None);
            };
            Ok(Some(OppositeNode {
                nodes: vec![(0, 1.0)],
                facing,
                normal: relative.free_normal(facing),
                gap,
                relative,
            }))
        },
    )
}

/// The opposite of a node.
struct OppositeNode<const D: usize> {
    nodes: Vec<(usize, f64)>,
    /// The direction to it.
    facing: Point<D>,
    /// The part of it that supports leave free.
    normal: Point<D>,
    gap: f64,
    relative: Relative<D>,
}

fn build<const D: usize>(
    nonmortar: End<'_, D>,
    coupling: Coupling,
    (analysis, corners): (Analysis, &Corners<D>),
    faces: impl Fn(usize, Point<D>) -> bool,
    opposite: impl Fn(usize, Point<D>) -> Result<Option<OppositeNode<D>>, ContactError>,
) -> Result<Interface<D>, ContactError> {
    let mesh = &nonmortar.body.mesh;
    let facets = nonmortar.facets()?;
    let mut normals = Normals::new(nonmortar, facets)?.nodal();
    for (node, normal) in &mut normals {
        *normal = corners.get(node).map_or(*normal, |corner| corner.normal);
    }
    let facing = facets.iter().copied().filter(|&facet| {
        let mut nodes = mesh.facet_nodes(facet).map(|node| node as usize);
        nodes.all(|node| normals.get(&node).is_some_and(|&n| faces(node, n)))
    });
    let thickness = nonmortar.body.thickness;
    let mut weights = nodal_weights(mesh, facing, analysis, thickness);
    let mut whole = nodal_weights(mesh, facets.iter().copied(), analysis, thickness);
    let own: BTreeSet<Facet> = facets.iter().copied().collect();
    for (&node, corner) in corners {
        let [facing, all] = corner.weights;
        weights.insert(node, facing);
        whole.insert(node, all);
    }
    let (order, cyclic) = mesh.side_order(nonmortar.side).unwrap_or_default();
    let mut interface = Interface {
        cyclic: nonmortar.part.is_none() && cyclic,
        ..Interface::empty(coupling)
    };
    for node in order.into_iter().map(|node| node as usize) {
        let Some(&normal) = normals.get(&node) else {
            continue;
        };
        if corners.get(&node).is_some_and(|c| !own.contains(&c.owner)) {
            continue;
        }
        // a node with a partner but without a facet that faces the other side carries no multiplier
        let state = match weights.get(&node) {
            Some(&weight) => opposite(node, normal)?.map(|state| (state, weight)),
            None => None,
        };
        let mut entry = InterfaceNode {
            node,
            opposite: Vec::new(),
            frame: frame(normal, &[]),
            weight: whole[&node].area,
            extent: 0.0,
            share: 0.0,
            gap: f64::NAN,
            clearance: f64::NAN,
            shares: GapShares::default(),
            role: Role::Alone,
            rows: [None; D],
        };
        if let Some((state, weight)) = state {
            if weight.negligible {
                return Err(ContactError::Weight {
                    side: nonmortar.name(),
                    node,
                    point: show(mesh.points()[node]),
                });
            }
            let rough = coupling == Coupling::Frictional;
            if rough && state.relative.oblique(state.facing).is_some() {
                interface.unborne += 1;
            }
            entry.role = Role::Fixed;
            entry.frame = frame(state.normal, &state.relative.prescribed);
            let held = state.relative.decided(entry.frame, coupling);
            for (component, direction) in entry.frame.into_iter().enumerate() {
                if held[component] {
                    continue;
                }
                entry.role = Role::Multiplier;
                entry.rows[component] = Some(interface.nonmortar.len());
                interface.nonmortar.push(vec![(node, direction)]);
                let opposite = state.nodes.iter();
                let row = opposite.map(|&(j, shape)| (j, direction.map(|c| -shape * c)));
                interface.mortar.push(row.collect());
            }
            entry.shares.mean = vec![(interface.points.len(), 1.0)];
            interface.points.push(GapPoint {
                own: vec![(node, 1.0)],
                opposite: state.nodes.clone(),
                normal: state.normal,
                gap: state.gap,
            });
            entry.opposite = state.nodes;
            (entry.weight, entry.extent) = (weight.area, weight.extent);
            entry.share = weight.area / whole[&node].area;
            (entry.gap, entry.clearance) = (state.gap, state.gap);
        }
        interface.nodes.push(entry);
    }
    Ok(interface)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{body, cube, end, flat, held, node_at, ring, wall};
    use crate::fem::{Body, Constraints};
    use crate::geometry::{Field, Surface};
    use crate::mesh::{CellKind, Cuboid};

    #[test]
    fn partners_are_the_nearest_nodes_if_they_coincide() {
        // three cells over four, and over three with the same nodes
        let own = cube(0.0);
        for cells in [3, 4] {
            let cuboid = Cuboid {
                from: [0.0, 0.0, 1.0],
                to: [1.0, 1.2, 2.0],
                cells: [cells; 3],
                cell: CellKind::Hex8,
            };
            let other = body(cuboid.build().unwrap());
            let free = Constraints::default();
            let found = matching_nodes(end(&own, "top", &free), end(&other, "bottom", &free));
            let found = found.unwrap();
            assert_eq!(found.len(), 16);
            for (node, (partner, distance_found)) in found {
                let place = own.mesh.points()[node];
                let others = other.mesh.side_nodes("bottom").unwrap().into_iter();
                let away = |node: u32| distance(other.mesh.points()[node as usize], place);
                let nearest = others.clone().map(away).fold(f64::INFINITY, f64::min);
                assert_eq!(distance_found, nearest);
                let same = others.clone().find(|&node| away(node) < 1e-9);
                assert_eq!(partner, same.map(|node| node as usize));
            }
        }
    }

    #[test]
    fn nodes_coincide_within_a_millionth_of_the_shortest_edge_beside_them() {
        let own = flat(&[0.0, 1.0, 1.5, 3.5], 1.0, CellKind::Quad4);
        let free = Constraints::default();
        for (x, edge) in [(0.0, 1.0), (1.0, 0.5), (1.5, 0.5), (3.5, 2.0)] {
            for (part, same) in [(0.95e-6, true), (1.05e-6, false)] {
                let points = [0.0, 1.0, 1.5, 3.5].map(|at| match at == x {
                    true => [at, part * edge],
                    false => [at, 0.0],
                });
                let other = wall(&points, -1.0, CellKind::Quad4);
                let matches =
                    matching_nodes(end(&own, "bottom", &free), end(&other, "bottom", &free));
                let (partner, away) = matches.unwrap()[&node_at(&own, [x, 0.0])];
                assert_eq!(partner.is_some(), same, "{x} {part}");
                assert!((away - part * edge).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_triangle_has_the_shortest_of_its_edges() {
        let mesh = Cuboid {
            from: [0.0; 3],
            to: [1.0, 3.0, 2.0],
            cells: [1; 3],
            cell: CellKind::Tet4,
        };
        let mesh = mesh.build().unwrap();
        for (side, shortest) in [("top", 1.0), ("left", 2.0), ("front", 1.0)] {
            let edges = shortest_edges(&mesh, mesh.side(side).unwrap());
            assert!(edges.len() == 4 && edges.values().all(|&edge| edge == shortest));
        }
    }

    /// A side at x = 0, 1, 2, 3 over one at x = 0, 1, 2, with these supports and a given gap.
    fn paired(
        own: &Constraints<2>,
        other: &Constraints<2>,
        gap: InitialGap<'_>,
        coupling: Coupling,
    ) -> Interface<2> {
        let upper = above();
        let lower = below();
        let analysis = Analysis::PlaneStrain;
        let ends = [end(&upper, "bottom", own), end(&lower, "bottom", other)];
        pair_nodes(ends[0], ends[1], gap, coupling, analysis, 2.0).unwrap()
    }

    fn above() -> Body<2> {
        flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4)
    }

    fn below() -> Body<2> {
        flat(&[0.0, 1.0, 2.0], -1.0, CellKind::Quad4)
    }

    #[test]
    fn coincident_nodes_share_rows_and_the_weight_of_the_facets_that_face_the_other_side() {
        let free = Constraints::default();
        let gap = Field::function("x + t", |p, t| p[0] + t);
        let given = InitialGap::Given(&gap);
        let interface = paired(&free, &free, given, Coupling::Frictional);
        let expected = [(0.0, 0.5), (1.0, 1.0), (2.0, 0.5)];
        for (node, (x, weight)) in interface.nodes.iter().zip(expected) {
            let own = node_at(&above(), [x, 0.0]);
            let other = node_at(&below(), [x, 0.0]);
            assert_eq!((node.node, node.role), (own, Role::Multiplier));
            assert!((node.weight - weight).abs() < 1e-15 && node.extent == node.weight);
            assert_eq!((node.gap, node.clearance), (x + 2.0, x + 2.0));
            assert_eq!(node.opposite, [(other, 1.0)]);
            for (row, direction) in node.rows.into_iter().zip(node.frame) {
                let row = row.unwrap();
                assert_eq!(interface.nonmortar[row], [(own, direction)]);
                let against = direction.map(|c| -c);
                assert_eq!(interface.mortar[row], [(other, against)]);
            }
            let point = &interface.points[node.shares.mean[0].0];
            assert_eq!(node.shares.mean[0].1, 1.0);
            assert_eq!(
                (&point.own, &point.opposite),
                (&vec![(own, 1.0)], &node.opposite)
            );
            assert_eq!(point.normal, [0.0, -1.0]);
        }
        let alone = &interface.nodes[3];
        assert_eq!((alone.role, alone.rows), (Role::Alone, [None; 2]));
        assert!(alone.gap.is_nan() && (alone.weight - 0.5).abs() < 1e-15);
        assert_eq!(interface.nodes.len(), 4);
        let closed = paired(&free, &free, InitialGap::Closed, Coupling::Normal);
        assert_eq!(closed.gaps(), [0.0; 3]);
    }

    #[test]
    fn a_measured_gap_is_the_way_along_the_normal() {
        let (upper, free) = (above(), Constraints::default());
        for off in [0.5e-6, -0.5e-6] {
            let points = [0.0, 1.0, 2.0].map(|x| [x, off]);
            let lower = wall(&points, -1.0, CellKind::Quad4);
            let ends = [end(&upper, "bottom", &free), end(&lower, "bottom", &free)];
            let (gap, coupling) = (InitialGap::Measured, Coupling::Normal);
            let analysis = Analysis::PlaneStrain;
            let interface = pair_nodes(ends[0], ends[1], gap, coupling, analysis, 0.0).unwrap();
            // the body is above: outward is down
            assert_eq!(interface.gaps(), [-off; 3]);
        }
    }

    #[test]
    fn a_node_that_only_touches_the_other_side_carries_nothing() {
        let (upper, free) = (above(), Constraints::default());
        let lower = flat(&[-2.0, -1.0, 0.0], -1.0, CellKind::Quad4);
        let ends = [end(&upper, "bottom", &free), end(&lower, "bottom", &free)];
        let (gap, coupling) = (InitialGap::Closed, Coupling::Normal);
        let analysis = Analysis::PlaneStrain;
        let interface = pair_nodes(ends[0], ends[1], gap, coupling, analysis, 0.0).unwrap();
        assert!(interface.nodes.iter().all(|node| node.role == Role::Alone));
        assert!(interface.nonmortar.is_empty());
    }

    #[test]
    fn a_direction_that_both_sides_hold_carries_no_multiplier() {
        let (own, other) = (node_at(&above(), [1.0, 0.0]), node_at(&below(), [1.0, 0.0]));
        let (x, y) = ([1.0, 0.0], [0.0, 1.0]);
        let rows = |own: &[(usize, Point<2>, bool)], other: &[(usize, Point<2>, bool)]| {
            let (own, other) = (held(own), held(other));
            let interface = paired(&own, &other, InitialGap::Closed, Coupling::Frictional);
            let node = &interface.nodes[1];
            assert_eq!(node.role == Role::Fixed, node.rows == [None; 2]);
            node.rows.map(|row| row.is_some())
        };
        assert_eq!(rows(&[(own, y, true)], &[]), [true, true]);
        assert_eq!(rows(&[], &[(other, y, true)]), [true, true]);
        assert_eq!(rows(&[(own, y, true)], &[(other, y, true)]), [false, false]);
        // for the normal a prescribed motion is enough
        assert_eq!(
            rows(&[(own, y, false)], &[(other, y, false)]),
            [false, false]
        );
        // along the tangent only a direction without any motion drops the row
        assert_eq!(rows(&[(own, x, true)], &[(other, x, true)]), [true, false]);
        assert_eq!(rows(&[(own, x, true)], &[(other, x, false)]), [true, true]);
        assert_eq!(rows(&[(own, x, false)], &[(other, x, true)]), [true, true]);
        assert_eq!(rows(&[(own, x, true)], &[(other, y, true)]), [true, true]);
    }

    #[test]
    fn an_inclined_normal_is_turned_into_what_both_supports_leave_free() {
        let inclined = [[0.0, 0.0], [1.0, 0.5], [2.0, 1.0]];
        let (upper, lower) = (
            wall(&inclined, 3.0, CellKind::Quad4),
            wall(&inclined, -2.0, CellKind::Quad4),
        );
        let x = [1.0, 0.0];
        let own = held(&[(node_at(&upper, inclined[1]), x, true)]);
        let other = held(&[(node_at(&lower, inclined[1]), x, true)]);
        let ends = [end(&upper, "bottom", &own), end(&lower, "bottom", &other)];
        let (gap, coupling) = (InitialGap::Closed, Coupling::Normal);
        let analysis = Analysis::PlaneStrain;
        let interface = pair_nodes(ends[0], ends[1], gap, coupling, analysis, 0.0).unwrap();
        assert_eq!(interface.nodes[1].normal(), [0.0, -1.0]);
        let free = interface.nodes[0].normal();
        assert!((free[0] / free[1] + 0.5).abs() < 1e-14, "{free:?}");
    }

    #[test]
    fn what_moves_an_obstacle_decides_which_rows_are_left() {
        let upper = above();
        let node = node_at(&upper, [1.0, 0.0]);
        let rigid = Rigid::Surface {
            surface: Surface::Plane {
                point: [0.0, -0.25],
                normal: [0.0, 1.0],
            },
            inside: false,
        };
        let (x, y) = ([1.0, 0.0], [0.0, 1.0]);
        for (axis, still, driven, rows) in [
            (y, true, Driven::Still, [false, false]),
            (y, false, Driven::Prescribed, [false, false]),
            (y, true, Driven::Free, [true, true]),
            (x, true, Driven::Still, [true, false]),
            (x, false, Driven::Still, [true, true]),
            (x, true, Driven::Prescribed, [true, true]),
            (x, true, Driven::Free, [true, true]),
        ] {
            let supports = held(&[(node, axis, still)]);
            let nonmortar = end(&upper, "bottom", &supports);
            let (coupling, analysis) = (Coupling::Frictional, Analysis::PlaneStrain);
            let found = pair_obstacle(
                nonmortar,
                (&rigid, driven, &Corners::new()),
                coupling,
                analysis,
                0.0,
            );
            let interface = found.unwrap();
            let found = interface.nodes[1].rows.map(|row| row.is_some());
            assert_eq!(found, rows, "{axis:?} {still} {driven:?}");
            // the others act on the translation of the obstacle
            assert_eq!(interface.nodes[0].gap, 0.25);
            assert_eq!(interface.mortar[0], [(0, [0.0, 1.0])]);
        }
    }

    #[test]
    fn a_node_on_the_axis_without_weight_is_named() {
        let places = [0.0, 0.5, 1.0];
        let (upper, lower) = (
            flat(&places, 1.0, CellKind::Quad8),
            flat(&places, -1.0, CellKind::Quad8),
        );
        let free = Constraints::default();
        let ends = [end(&upper, "bottom", &free), end(&lower, "bottom", &free)];
        let pair = |analysis| {
            let (gap, coupling) = (InitialGap::Closed, Coupling::Normal);
            pair_nodes(ends[0], ends[1], gap, coupling, analysis, 0.0)
        };
        match pair(Analysis::Axisymmetric) {
            Err(ContactError::Weight { node, .. }) => {
                assert_eq!(node, node_at(&upper, [0.0, 0.0]));
            }
            other => panic!("{other:?}"),
        }
        assert!(pair(Analysis::PlaneStrain).is_ok());
    }

    #[test]
    fn a_full_ring_closes_on_itself_and_a_part_of_it_does_not() {
        let (ring, free) = (ring([0.0, 0.0], [1.0, 2.0], 8), Constraints::default());
        let rigid = Rigid::Gap(Field::constant(0.0));
        let pair = |nonmortar| {
            let (coupling, analysis) = (Coupling::Normal, Analysis::PlaneStrain);
            pair_obstacle(
                nonmortar,
                (&rigid, Driven::Still, &Corners::new()),
                coupling,
                analysis,
                0.0,
            )
            .unwrap()
        };
        let whole = end(&ring, "outer", &free);
        assert!(pair(whole).cyclic);
        let part = End {
            part: Some(&whole.facets().unwrap()[2..5]),
            ..whole
        };
        let part = pair(part);
        assert!(!part.cyclic);
        assert_eq!(part.nodes.len(), 4);
    }
}
