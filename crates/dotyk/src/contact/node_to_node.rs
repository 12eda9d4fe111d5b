//! Node-to-node pairing: one multiplier for each pair of coincident nodes.
//!
//! Row i is nᵢ·(u_s,i − u_m,j(i)), and likewise with the tangent where friction or a tie couples it; the weight of a node is ∫Nᵢ over those facets of the nonmortar side all of whose
//! nodes have a partner. Where supports hold the same direction on both sides (a plane of symmetry), the normal is
//! projected onto what they leave free; if nothing is left, the node is fixed and carries no multiplier.
//!
//! Source: Janovský & Procházka (1980) III, section 7 (normals by the bisector rule, axis direction on the axis).

use crate::contact::normals::Normals;
use crate::contact::weights::nodal_weights;
use crate::contact::{
    ContactError, Coupling, End, InitialGap, Interface, InterfaceNode, Role, frame,
};
use crate::fem::{Analysis, Held, show, side_facets};
use crate::geometry::{Field, Point, Surface, add_scaled, distance, dot, norm, sub, unit};
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
    if let Some(part) = end.part {
        return Ok(part);
    }
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
                normal,
                gap,
                relative,
            }))
        },
    )
}

/// The shape of a rigid obstacle.
#[derive(Debug, Clone)]
pub enum Rigid<const D: usize> {
    /// Its distance from the undeformed nonmortar point along the contact normal; negative is an interference.
    Gap(Field),
    /// A plane or a circle. The plane's normal points towards the body; a circle is the obstacle, or with `inside` the hole
    /// in the obstacle.
    Surface {
        /// The surface.
        surface: Surface<D>,
        /// The body is inside the circle.
        inside: bool,
    },
}

impl<const D: usize> Rigid<D> {
    /// The point of the obstacle that lies opposite a point with this outward normal, or nearest to it: for drawing.
    pub fn drawn(&self, point: Point<D>, normal: Point<D>, time: f64) -> Point<D> {
        match self {
            Self::Gap(field) => add_scaled(point, field.at(point, time), normal),
            Self::Surface { surface, .. } => surface.closest(point),
        }
    }

    /// Whether a point with this outward normal faces the obstacle.
    pub(super) fn faces(&self, point: Point<D>, normal: Point<D>) -> bool {
        match self {
            Self::Gap(_) => true,
            Self::Surface { surface, inside } => {
                surface_opposite(surface, *inside, point, normal).is_some()
            }
        }
    }

    /// Contact normal and gap at a point with this outward normal; `None` where it faces nothing.
    pub(super) fn opposite(
        &self,
        (point, normal): (Point<D>, Point<D>),
        time: f64,
        end: End<'_, D>,
    ) -> Result<Option<(Point<D>, f64)>, ContactError> {
        Ok(match self {
            Self::Gap(field) => Some((normal, finite_gap(field, point, time, end)?)),
            Self::Surface { surface, inside } => surface_opposite(surface, *inside, point, normal),
        })
    }
}

/// Surfaces count as opposed when the cosine between the normals is below this.
const OPPOSED: f64 = -0.1;

fn surface_opposite<const D: usize>(
    surface: &Surface<D>,
    inside: bool,
    point: Point<D>,
    normal: Point<D>,
) -> Option<(Point<D>, f64)> {
    if let Surface::Plane { normal: up, .. } = surface {
        let facing = dot(normal, *up) < OPPOSED;
        return facing.then(|| (up.map(|c| -c), surface.distance(point)));
    }
    let outward = |s: f64| {
        let n = surface.normal(add_scaled(point, s, normal))?;
        Some(if inside { n.map(|c| -c) } else { n })
    };
    let hits = surface.intersections(point, normal).into_iter();
    let facing = hits.filter(|&s| outward(s).is_some_and(|n| dot(n, normal) < OPPOSED));
    let nearest = facing.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some((normal, nearest))
}

/// What moves a rigid obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driven {
    /// Nothing: it stays where it is at all times.
    Still,
    /// A prescribed displacement.
    Prescribed,
    /// Forces: it is free to translate.
    Free,
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
            let Some((normal, gap)) = rigid.opposite(place, time, nonmortar)? else {
                return Ok(None);
            };
            let normal = relative.free_normal(normal);
            Ok(Some(Opposite {
                nodes: vec![(0, 1.0)],
                normal,
                gap,
                relative,
            }))
        },
    )
}

/// What lies opposite a node.
struct Opposite<const D: usize> {
    nodes: Vec<(usize, f64)>,
    normal: Point<D>,
    gap: f64,
    relative: Relative<D>,
}

/// What supports leave of the relative motion of two opposite points; orthonormal directions.
pub(super) struct Relative<const D: usize> {
    /// Directions in which it is prescribed.
    pub prescribed: Vec<Point<D>>,
    /// Those of them in which there is none at any time: nothing can slip.
    pub still: Vec<Point<D>>,
}

impl<const D: usize> Relative<D> {
    /// The normal without what is prescribed; unchanged where nothing is left.
    fn free_normal(&self, normal: Point<D>) -> Point<D> {
        free_part(normal, self.prescribed.iter().copied()).unwrap_or(normal)
    }

    /// Which components carry no multiplier, because they are prescribed or not coupled at all: normal, then tangential.
    pub fn decided(&self, normal: Point<D>, coupling: Coupling) -> [bool; D] {
        let frame = frame(normal);
        let part = |directions: &[Point<D>], axis: Point<D>| -> f64 {
            directions.iter().map(|&h| dot(h, axis).abs()).sum()
        };
        let normal_held = free_part(normal, self.prescribed.iter().copied()).is_none();
        match coupling {
            Coupling::Normal => std::array::from_fn(|c| c > 0 || normal_held),
            Coupling::Frictional => std::array::from_fn(|c| match c {
                0 => normal_held,
                _ => normal_held || part(&self.still, frame[c]) > COINCIDENT,
            }),
            Coupling::Tied => {
                let held = |c: &usize| part(&self.prescribed, frame[*c]);
                let mut order: Vec<usize> = (0..D).collect();
                order.sort_by(|a, b| held(b).total_cmp(&held(a)));
                let mut components = [false; D];
                let prescribed = order.iter().take(self.prescribed.len());
                prescribed.for_each(|&c| components[c] = true);
                components
            }
        }
    }
}

/// Held directions that satisfy a condition.
pub(super) fn axes<const D: usize>(
    held: &[Held<D>],
    which: impl Fn(&Held<D>) -> bool,
) -> Vec<Point<D>> {
    let chosen = held.iter().filter(|h| which(h));
    chosen.map(|h| h.axis).collect()
}

fn build<const D: usize>(
    nonmortar: End<'_, D>,
    coupling: Coupling,
    analysis: Analysis,
    faces: impl Fn(usize, Point<D>) -> bool,
    opposite: impl Fn(usize, Point<D>) -> Result<Option<Opposite<D>>, ContactError>,
) -> Result<Interface<D>, ContactError> {
    let mesh = &nonmortar.body.mesh;
    let facets = facets(nonmortar)?;
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
    let chains = mesh.chain(nonmortar.side).unwrap_or_default();
    let along = chains.iter().flat_map(|chain| &chain.nodes);
    let mut seen = BTreeSet::new();
    let order: Vec<usize> = along
        .map(|&node| node as usize)
        .filter(|&node| seen.insert(node))
        .collect();
    let mut interface = Interface {
        nodes: Vec::new(),
        cyclic: nonmortar.part.is_none() && chains.len() == 1 && chains[0].cyclic,
        coupling,
        nonmortar: Vec::new(),
        mortar: Vec::new(),
        implied: Vec::new(),
    };
    for node in order {
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
            normal,
            weight: whole[&node].area,
            extent: 0.0,
            gap: f64::NAN,
            clearance: f64::NAN,
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
            let held = state.relative.decided(state.normal, coupling);
            for (component, direction) in frame(state.normal).into_iter().enumerate() {
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
            entry.opposite = state.nodes;
            entry.normal = state.normal;
            (entry.weight, entry.extent) = (weight.area, weight.extent);
            (entry.gap, entry.clearance) = (state.gap, state.gap);
        }
        interface.nodes.push(entry);
    }
    Ok(interface)
}

pub(super) fn finite_gap<const D: usize>(
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

/// Directions that both sets of orthonormal directions contain.
fn shared<const D: usize>(a: &[Point<D>], b: &[Point<D>]) -> Vec<Point<D>> {
    let inside = |axis: &Point<D>| {
        let rest = b
            .iter()
            .fold(*axis, |rest, &h| add_scaled(rest, -dot(*axis, h), h));
        norm(rest) < COINCIDENT
    };
    match (a.len() == D, b.len() == D) {
        (_, true) => a.to_vec(),
        (true, _) => b.to_vec(),
        _ => a.iter().copied().filter(inside).collect(),
    }
}

/// Unit vector along the part of a normal that is orthogonal to some orthonormal directions; `None` if nothing is left.
pub(super) fn free_part<const D: usize>(
    normal: Point<D>,
    directions: impl IntoIterator<Item = Point<D>>,
) -> Option<Point<D>> {
    let rest = directions.into_iter().fold(normal, |rest, axis| {
        add_scaled(rest, -dot(rest, axis), axis)
    });
    unit(rest).filter(|_| norm(rest) > COINCIDENT)
}
