//! Node-to-node pairing: one multiplier for each pair of coincident nodes.
//!
//! Row i is nᵢ·(u_s,i − u_m,j(i)); the weight of a node is ∫Nᵢ over those facets of the nonmortar side all of whose
//! nodes have a partner. Where supports hold the same direction on both sides (a plane of symmetry), the normal is
//! projected onto what they leave free; if nothing is left, the node is fixed and carries no multiplier.
//!
//! Source: Janovský & Procházka (1980) III, section 7 (normals by the bisector rule, axis direction on the axis).

use crate::contact::weights::nodal_weights;
use crate::contact::{ContactError, End, InitialGap, Interface, InterfaceNode, Role, Row};
use crate::fem::{Analysis, node_normals, show, side_facets};
use crate::geometry::{Field, Point, add_scaled, distance, dot, norm, sub};
use crate::mesh::Mesh;
use std::collections::{BTreeMap, BTreeSet};

/// Two nodes coincide within this fraction of the local edge.
const COINCIDENT: f64 = 1e-6;

/// Partner on the mortar side of every node of the nonmortar side (`None` where there is none within 1e-6 of the local
/// edge), and the distance of the nearest node.
pub fn matching_nodes<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
) -> Result<BTreeMap<usize, (Option<usize>, f64)>, ContactError> {
    let (s, m) = (&nonmortar.body.mesh, &mortar.body.mesh);
    facets(mortar)?;
    let mut partners: Vec<usize> = m
        .side_nodes(mortar.side)
        .unwrap_or_default()
        .into_iter()
        .map(|node| node as usize)
        .collect();
    // sorted along x: candidates lie in a short window
    partners.sort_by(|&a, &b| m.points()[a][0].total_cmp(&m.points()[b][0]));
    let edges = shortest_edges(s, facets(nonmortar)?);
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

/// Shortest facet that meets at each node of a side.
fn shortest_edges<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[crate::mesh::Facet],
) -> BTreeMap<usize, f64> {
    let mut edges = BTreeMap::new();
    for &facet in facets {
        let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|node| node as usize).collect();
        let length = distance(mesh.points()[nodes[0]], mesh.points()[nodes[1]]);
        for node in nodes {
            let edge = edges.entry(node).or_insert(f64::INFINITY);
            *edge = length.min(*edge);
        }
    }
    edges
}

pub(super) fn facets<'a, const D: usize>(
    end: End<'a, D>,
) -> Result<&'a [crate::mesh::Facet], ContactError> {
    side_facets(&end.body.mesh, end.side).map_err(|source| ContactError::Side {
        body: end.body.name.clone(),
        source,
    })
}

/// Pairs the coincident nodes of two sides.
///
/// Errors: unknown or empty sides, a nodal weight that is not positive, a gap that is not finite.
pub fn pair_nodes<const D: usize>(
    nonmortar: End<'_, D>,
    mortar: End<'_, D>,
    gap: InitialGap<'_>,
    analysis: Analysis,
    time: f64,
) -> Result<Interface<D>, ContactError> {
    let matches = matching_nodes(nonmortar, mortar)?;
    let (s, m) = (&nonmortar.body.mesh, &mortar.body.mesh);
    build(
        nonmortar,
        analysis,
        |node| matches[&node].0.is_some(),
        |node, normal| {
            let partner = matches[&node].0;
            let Some(j) = partner else {
                return Ok(Opposite::Nothing);
            };
            let free = project(
                normal,
                shared(nonmortar.constraints.at(node), mortar.constraints.at(j)),
            );
            let point = s.points()[node];
            let normal = free.unwrap_or(normal);
            let gap = match gap {
                InitialGap::Measured => dot(normal, sub(m.points()[j], point)),
                InitialGap::Closed => 0.0,
                InitialGap::Given(field) => finite_gap(field, point, time, nonmortar)?,
            };
            Ok(Opposite::Something {
                partner,
                normal,
                gap,
                fixed: free.is_none(),
            })
        },
    )
}

/// A side against a rigid obstacle whose distance along the normal is given, and which moves by `displacement`.
///
/// Errors: as [`pair_nodes`].
pub fn pair_obstacle<const D: usize>(
    nonmortar: End<'_, D>,
    distance: &Field,
    displacement: Point<D>,
    analysis: Analysis,
    time: f64,
) -> Result<Interface<D>, ContactError> {
    let mesh = &nonmortar.body.mesh;
    build(
        nonmortar,
        analysis,
        |_| true,
        |node, normal| {
            let held: Vec<Point<D>> = nonmortar
                .constraints
                .at(node)
                .iter()
                .map(|h| h.axis)
                .collect();
            let free = project(normal, held);
            let normal = free.unwrap_or(normal);
            let gap = finite_gap(distance, mesh.points()[node], time, nonmortar)?
                + dot(normal, displacement);
            Ok(Opposite::Something {
                partner: None,
                normal,
                gap,
                fixed: free.is_none(),
            })
        },
    )
}

/// What lies opposite a node.
enum Opposite<const D: usize> {
    Nothing,
    Something {
        partner: Option<usize>,
        normal: Point<D>,
        gap: f64,
        fixed: bool,
    },
}

fn build<const D: usize>(
    nonmortar: End<'_, D>,
    analysis: Analysis,
    faces: impl Fn(usize) -> bool,
    opposite: impl Fn(usize, Point<D>) -> Result<Opposite<D>, ContactError>,
) -> Result<Interface<D>, ContactError> {
    let mesh = &nonmortar.body.mesh;
    let facets = facets(nonmortar)?;
    let normals = node_normals(mesh, facets);
    let facing = facets
        .iter()
        .copied()
        .filter(|&facet| mesh.facet_nodes(facet).all(|node| faces(node as usize)));
    let weights = nodal_weights(mesh, facing, analysis, nonmortar.body.thickness);
    let whole = nodal_weights(
        mesh,
        facets.iter().copied(),
        analysis,
        nonmortar.body.thickness,
    );
    // at the axis of symmetry ∫N 2πr of a quadratic facet vanishes: what is left is rounding
    let negligible = 1e-12
        * weights
            .values()
            .fold(0.0, |largest, &w| f64::max(largest, w));
    let chains = mesh.chain(nonmortar.side).unwrap_or_default();
    let cyclic = chains.len() == 1 && chains[0].cyclic;
    let mut seen = BTreeSet::new();
    let along = chains
        .iter()
        .flat_map(|chain| &chain.nodes)
        .map(|&node| node as usize);
    let order: Vec<usize> = along.filter(|&node| seen.insert(node)).collect();
    let mut interface = Interface {
        nodes: Vec::new(),
        cyclic,
        nonmortar: Vec::new(),
        mortar: Vec::new(),
    };
    for node in order {
        let Some(&normal) = normals.get(&node) else {
            continue;
        };
        // a node whose partner exists but none of whose facets faces the other side carries nothing
        let state = if weights.contains_key(&node) {
            opposite(node, normal)?
        } else {
            Opposite::Nothing
        };
        let entry = match state {
            Opposite::Nothing => InterfaceNode {
                node,
                partner: None,
                normal,
                weight: whole[&node],
                gap: f64::NAN,
                role: Role::Alone,
            },
            Opposite::Something {
                partner,
                normal,
                gap,
                fixed,
            } => {
                let weight = weights[&node];
                if weight.is_nan() || weight <= negligible {
                    let point = show(mesh.points()[node]);
                    return Err(ContactError::Weight {
                        side: nonmortar.name(),
                        node,
                        point,
                    });
                }
                let role = if fixed {
                    Role::Fixed
                } else {
                    Role::Multiplier(interface.nonmortar.len())
                };
                if !fixed {
                    interface.nonmortar.push(vec![(node, normal)]);
                    let row: Row<D> = partner.iter().map(|&j| (j, normal.map(|c| -c))).collect();
                    interface.mortar.push(row);
                }
                InterfaceNode {
                    node,
                    partner,
                    normal,
                    weight,
                    gap,
                    role,
                }
            }
        };
        interface.nodes.push(entry);
    }
    Ok(interface)
}

fn finite_gap<const D: usize>(
    field: &Field,
    point: Point<D>,
    time: f64,
    end: End<'_, D>,
) -> Result<f64, ContactError> {
    let value = field.at(point, time);
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ContactError::NotFinite {
            side: end.name(),
            text: field.to_string(),
            point: show(point),
        })
    }
}

/// Directions that both sets of held directions contain.
fn shared<const D: usize>(a: &[crate::fem::Held<D>], b: &[crate::fem::Held<D>]) -> Vec<Point<D>> {
    let inside = |axis: Point<D>| {
        let rest = b
            .iter()
            .fold(axis, |rest, h| add_scaled(rest, -dot(axis, h.axis), h.axis));
        norm(rest) < COINCIDENT
    };
    let all: Vec<Point<D>> = if b.len() == D {
        a.iter().map(|h| h.axis).collect()
    } else if a.len() == D {
        b.iter().map(|h| h.axis).collect()
    } else {
        a.iter()
            .map(|h| h.axis)
            .filter(|&axis| inside(axis))
            .collect()
    };
    all
}

/// Unit vector along the part of the normal that is orthogonal to some orthonormal directions; `None` if nothing is left.
fn project<const D: usize>(normal: Point<D>, directions: Vec<Point<D>>) -> Option<Point<D>> {
    let rest = directions.iter().fold(normal, |rest, &axis| {
        add_scaled(rest, -dot(rest, axis), axis)
    });
    let size = norm(rest);
    (size > COINCIDENT).then(|| rest.map(|c| c / size))
}
