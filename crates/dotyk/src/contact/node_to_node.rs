//! Node-to-node pairing: one multiplier for each pair of coincident nodes.
//!
//! Row i is nᵢ·(u_s,i − u_m,j(i)), and likewise with the tangents where friction or a tie couples them; the weight of a node is
//! ∫Nᵢ over those facets of the nonmortar side all of whose nodes have a partner. Where supports hold the same direction on both sides (a plane of symmetry), the normal is
//! projected onto what they leave free; if nothing is left, the node is fixed and carries no multiplier.
//!
//! Source: Janovský & Procházka (1980) III, section 7 (normals by the bisector rule, axis direction on the axis).

use crate::contact::normals::Normals;
use crate::contact::obstacle::{Driven, Rigid, finite_gap};
use crate::contact::relative::{Relative, axes, frame, shared};
use crate::contact::weights::nodal_weights;
use crate::contact::{
    ContactError, Coupling, End, GapPoint, GapShares, InitialGap, Interface, InterfaceNode, Role,
};
use crate::fem::{Analysis, show};
use crate::geometry::{Point, distance, dot, sub};
use crate::mesh::{Facet, Mesh};
use std::collections::BTreeMap;

/// Two nodes coincide within this fraction of the local edge.
const COINCIDENT: f64 = 1e-6;

/// Partner on the mortar side of every node of the nonmortar side (`None` where there is none within 1e-6 of the local
/// edge), and the distance of the nearest node.
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
        analysis,
        |node, _| matches[&node].0.is_some(),
        |node, normal| {
            let Some(j) = matches[&node].0 else {
                return Ok(None);
            };
            let (own, other) = (nonmortar.constraints.at(node), mortar.constraints.at(j));
            let relative = Relative {
                prescribed: shared(&axes(own, |_| true), &axes(other, |_| true)),
                still: shared(&axes(own, |h| h.still), &axes(other, |h| h.still)),
            };
            let point = s.points()[node];
            let normal = relative.free_normal(normal);
            let gap = match gap {
                InitialGap::Measured => dot(normal, sub(m.points()[j], point)),
                InitialGap::Closed => 0.0,
                InitialGap::Given(field) => finite_gap(field, point, time, nonmortar)?,
            };
            Ok(Some(Opposite {
                nodes: vec![(j, 1.0)],
                along: normal,
                normal,
                gap,
                relative,
            }))
        },
    )
}

/// A side against a rigid obstacle; its rows on the other side act on the translation of the obstacle.
///
/// Errors: as [`pair_nodes`].
pub fn pair_obstacle<const D: usize>(
    nonmortar: End<'_, D>,
    (rigid, driven): (&Rigid<D>, Driven),
    coupling: Coupling,
    analysis: Analysis,
    time: f64,
) -> Result<Interface<D>, ContactError> {
    let mesh = &nonmortar.body.mesh;
    build(
        nonmortar,
        coupling,
        analysis,
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
            Ok(Some(Opposite {
                nodes: vec![(0, 1.0)],
                along: normal,
                normal: relative.free_normal(facing),
                gap,
                relative,
            }))
        },
    )
}

/// What lies opposite a node.
struct Opposite<const D: usize> {
    nodes: Vec<(usize, f64)>,
    /// The direction in which it was looked for.
    along: Point<D>,
    normal: Point<D>,
    gap: f64,
    relative: Relative<D>,
}

fn build<const D: usize>(
    nonmortar: End<'_, D>,
    coupling: Coupling,
    analysis: Analysis,
    faces: impl Fn(usize, Point<D>) -> bool,
    opposite: impl Fn(usize, Point<D>) -> Result<Option<Opposite<D>>, ContactError>,
) -> Result<Interface<D>, ContactError> {
    let mesh = &nonmortar.body.mesh;
    let facets = nonmortar.facets()?;
    let normals = Normals::new(nonmortar, facets)?.nodal();
    let facing = facets.iter().copied().filter(|&facet| {
        let mut nodes = mesh.facet_nodes(facet).map(|node| node as usize);
        nodes.all(|node| normals.get(&node).is_some_and(|&n| faces(node, n)))
    });
    let weights = nodal_weights(mesh, facing, analysis, nonmortar.body.thickness);
    let whole = nodal_weights(
        mesh,
        facets.iter().copied(),
        analysis,
        nonmortar.body.thickness,
    );
    let (order, cyclic) = mesh.side_order(nonmortar.side).unwrap_or_default();
    let mut interface = Interface {
        nodes: Vec::new(),
        cyclic: nonmortar.part.is_none() && cyclic,
        coupling,
        nonmortar: Vec::new(),
        mortar: Vec::new(),
        points: Vec::new(),
        implied: Vec::new(),
    };
    for node in order.into_iter().map(|node| node as usize) {
        let Some(&normal) = normals.get(&node) else {
            continue;
        };
        // a node whose partner exists but none of whose facets faces the other side carries nothing
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
                along: state.along,
                gap: state.gap,
            });
            entry.opposite = state.nodes;
            (entry.weight, entry.extent) = (weight.area, weight.extent);
            (entry.gap, entry.clearance) = (state.gap, state.gap);
        }
        interface.nodes.push(entry);
    }
    Ok(interface)
}
