//! Mortar pairing in the plane: contact conditions as weighted means along the nonmortar side.
//!
//! Two meshes that do not match have no common nodes at which a gap could be asked for. So every node j of the nonmortar side
//! carries a multiplier λⱼ, a force that is spread along the side with a weight ψⱼ(x), and its condition is that the mean of
//! the gap with this weight is not negative:
//!
//! ```text
//!   row j:  ∫ψⱼ n(x)·(u_s(x) − u_m(y)) dx / ∫ψⱼ dx,      g₀ⱼ = ∫ψⱼ s dx / ∫ψⱼ dx
//! ```
//!
//! x runs along the nonmortar side, n is its normal ([`Normals`]), y the point where the line x + s·n(x) meets the other side
//! at the distance s, u_s and u_m are the displacements of the two sides. The gap s is measured between the true surfaces
//! where a side has one. Both bodies feel the force at the two ends of one line along n, so that forces and moments balance
//! whatever the two polygons are.
//!
//! **Integration.** Facets are cut where the line from them meets a node of the other side (`pieces.rs`): on each piece all
//! shape functions are smooth, and a Gauss rule is exact for straight facets.
//!
//! **Weights.** On a facet that faces the other side as a whole, the ψ are biorthogonal to the shape functions N of its
//! nodes, ∫ψᵢNⱼ = δᵢⱼ∫Nⱼ. They sum to one, so that a uniform pressure is exact, and on matching meshes they give what pairing
//! node by node gives. There are three exceptions.
//! * A facet that faces the other side in part: biorthogonal functions of the whole facet would act as forces at nodes that
//!   face nothing. There the ψ are biorthogonal to linear functions on the covered part of each span between neighbouring
//!   nodes, and act at the two ends of that part. As the cover grows to the whole of a straight facet, both become the same.
//!   Where the cover of a span has a hole, ψ are the linear functions of its two nodes.
//! * A weight ∫N that is not positive (a quadratic facet that ends at the axis of revolution): ψ are linear between
//!   neighbouring nodes, middle nodes included.
//! * A node without a multiplier, because its displacement is prescribed or less than a thousandth of its surroundings faces
//!   the other side: on its facets ψ are linear, and its own share goes to the neighbours.
//!
//! **Tangential rows** compare u_s with what u_m would be at x if the other side were carried on rigidly from y to x, by the
//! rotation of its facet: forces along t at two points a distance s apart would be a couple.
//!
//! Against a rigid obstacle u_m is its translation, and the rows on the other side act on it. Not here: bodies in space.
//!
//! Source of the biorthogonal functions: as described by B. I. Wohlmuth, SIAM J. Numer. Anal. 38 (2000) 989–1012.

use crate::contact::opposite::{Opposite, shape};
use crate::contact::pieces::{Piece, Span, pieces, spans};
use crate::contact::relative::{Relative, axes, frame};
use crate::contact::search::{Hit, meet};
use crate::contact::weights::POSITIVE;
use crate::contact::{
    Against, ContactError, Coupling, Driven, End, GapPoint, GapShares, InitialGap, Interface,
    InterfaceNode, Role, Row,
};
use crate::fem::{Analysis, measure, quadrature};
use crate::geometry::{Point, add_scaled, dot, invert, norm};
use crate::mesh::{Facet, Mesh};
use rayon::prelude::*;
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};

/// Nodes of whose support less than this part faces the other side carry no multiplier.
const SLIVER: f64 = 1e-3;

/// Most nodes of a facet of the plane.
const FACET_NODES: usize = 3;

/// Gauss points on each piece: exact for straight sides, beyond rounding for curved ones.
const POINTS: usize = 6;

/// Everything at one point of integration.
struct Station {
    span: usize,
    /// Reference coordinate on the facet.
    xi: f64,
    /// Values of the two hats of the span.
    hats: [f64; 2],
    area: f64,
    /// Without thickness or 2πr.
    length: f64,
    /// The point of the interface that it is.
    index: usize,
    /// What it faces.
    at: GapPoint<2>,
    /// s times the rotation of the opposite facet, as coefficients of its nodes' displacements.
    lever: Vec<(usize, Point<2>)>,
}

/// Sums over the stations of one node.
struct Sums {
    /// ∫ of the node's hat, and times the gap.
    own: [f64; 2],
    /// The weights of that at the stations, and those of ψ of the normal row.
    hats: Vec<(usize, f64)>,
    psi: Vec<(usize, f64)>,
    extent: f64,
    weight: [f64; 2],
    gap: f64,
    nonmortar: [BTreeMap<usize, Point<2>>; 2],
    mortar: [BTreeMap<usize, Point<2>>; 2],
}

impl Sums {
    fn new() -> Self {
        Self {
            own: [0.0; 2],
            hats: Vec::new(),
            psi: Vec::new(),
            extent: 0.0,
            weight: [0.0; 2],
            gap: 0.0,
            nonmortar: std::array::from_fn(|_| BTreeMap::new()),
            mortar: std::array::from_fn(|_| BTreeMap::new()),
        }
    }

    /// Adds ψ·area at a station to the row of a component.
    fn add(&mut self, component: usize, psi: f64, station: &Station) {
        let weight = psi * station.area;
        let direction = frame(station.at.normal, &[])[component];
        self.weight[component] += weight;
        if component == 0 {
            self.gap += weight * station.at.gap;
            self.psi.push((station.index, weight));
        }
        let sides = [
            (&mut self.nonmortar[component], &station.at.own, weight),
            (&mut self.mortar[component], &station.at.opposite, -weight),
        ];
        for (row, nodes, weight) in sides {
            for &(node, shape) in nodes {
                let entry = row.entry(node).or_insert([0.0; 2]);
                *entry = add_scaled(*entry, weight * shape, direction);
            }
        }
        if component > 0 {
            for &(node, coefficients) in &station.lever {
                let entry = self.mortar[component].entry(node).or_insert([0.0; 2]);
                *entry = add_scaled(*entry, weight, coefficients);
            }
        }
    }

    /// Rows of a component on both sides, divided by the weight.
    fn rows(&self, component: usize) -> [Row<2>; 2] {
        [&self.nonmortar[component], &self.mortar[component]].map(|row| {
            let scale = 1.0 / self.weight[component];
            row.iter()
                .map(|(&node, c)| (node, c.map(|c| c * scale)))
                .collect()
        })
    }
}

/// Pairs a side with another, or with an obstacle, by mortar integration.
///
/// Errors: unknown or empty sides, nodes off their true surface, a gap that is not finite, supports that hold the whole
/// nonmortar side, bodies in space.
pub fn pair_mortar<const D: usize>(
    nonmortar: End<'_, D>,
    against: Against<'_, D>,
    gap: InitialGap<'_>,
    coupling: Coupling,
    analysis: Analysis,
    time: f64,
) -> Result<Interface<D>, ContactError> {
    let in_space = || ContactError::MortarInSpace {
        side: nonmortar.name(),
    };
    let (Some(side), Some(against)) = (nonmortar.in_plane(), against.in_plane()) else {
        return Err(in_space());
    };
    let pairing = Pairing::new(Opposite::new(side, against, gap, time)?, analysis);
    let interface = pairing.interface(&pieces(&pairing.sides, &pairing.spans), coupling)?;
    // the plane is what D is here
    let same: Box<dyn Any> = Box::new(interface);
    same.downcast().map(|same| *same).map_err(|_| in_space())
}

struct Pairing<'a> {
    sides: Opposite<'a, 2>,
    analysis: Analysis,
    spans: Vec<Span>,
    cyclic: bool,
}

impl<'a> Pairing<'a> {
    fn new(sides: Opposite<'a, 2>, analysis: Analysis) -> Self {
        let (nonmortar, mesh) = (sides.nonmortar, sides.mesh());
        let chains = mesh.chain(nonmortar.side).unwrap_or_default();
        let of_part = |facet: &&Facet| nonmortar.part.is_none_or(|part| part.contains(facet));
        let along = chains.iter().flat_map(|chain| &chain.facets);
        let along = along.filter(of_part);
        Self {
            spans: along.flat_map(|&facet| spans(mesh, facet)).collect(),
            cyclic: nonmortar.part.is_none() && chains.len() == 1 && chains[0].cyclic,
            sides,
            analysis,
        }
    }

    fn mesh(&self) -> &'a Mesh<2> {
        self.sides.mesh()
    }

    /// Everything at ξ of a piece; `None` where the line misses the facet by rounding of a tangent.
    fn station(
        &self,
        piece: &Piece,
        xi: f64,
        reference: f64,
    ) -> Result<Option<Station>, ContactError> {
        let span = &self.spans[piece.span];
        let mesh = self.mesh();
        let line = self.sides.line(span.facet, &[xi]);
        let own = shape(mesh, span.facet, &[xi]);
        let tangent = norm(mesh.outward_normal(span.facet, &[xi]));
        let thickness = self.sides.nonmortar.body.thickness;
        let length = reference * tangent;
        let area = length * measure(self.analysis, thickness, line.start);
        let mut lever = Vec::new();
        let (normal, opposite, gap) = match (self.sides.against, piece.opposite) {
            (Against::Side(mortar), Some(facet)) => {
                let Some(hit) = meet(&mortar.body.mesh, facet, line) else {
                    return Ok(None);
                };
                lever = rotation(&mortar.body.mesh, hit);
                (
                    line.direction,
                    shape(&mortar.body.mesh, facet, &hit.xi),
                    self.sides.gap_at(span.facet, line, hit)?,
                )
            }
            (Against::Obstacle(rigid, _), _) => {
                let place = (line.start, line.direction);
                let Some((normal, gap)) =
                    rigid.opposite(place, self.sides.time, self.sides.nonmortar)?
                else {
                    return Ok(None);
                };
                (normal, vec![(0, 1.0)], gap)
            }
            (Against::Side(_), None) => return Ok(None),
        };
        Ok(Some(Station {
            span: piece.span,
            xi,
            hats: hats_of(span.ends, xi),
            area,
            length,
            index: 0,
            at: GapPoint {
                own,
                opposite,
                normal,
                along: line.direction,
                gap,
            },
            lever,
        }))
    }

    fn interface(
        &self,
        pieces: &[Piece],
        coupling: Coupling,
    ) -> Result<Interface<2>, ContactError> {
        let stations = self.stations(pieces)?;
        let mut sums: BTreeMap<usize, Sums> = BTreeMap::new();
        for station in &stations {
            let nodes = self.spans[station.span].nodes;
            for (node, hat) in nodes.into_iter().zip(station.hats) {
                let sums = sums.entry(node).or_insert_with(Sums::new);
                sums.own[0] += hat * station.area;
                sums.own[1] += hat * station.area * station.at.gap;
                sums.hats.push((station.index, hat * station.area));
            }
        }
        let whole = self.whole_weights();
        let normals = self.sides.normals.nodal();
        let kept = self.kept(&sums, &whole, &normals, coupling, &stations);
        let cover = Cover::new(&self.spans, pieces);
        // pieces follow the chain, so the stations of a facet follow one another
        let facet = |station: &Station| self.spans[station.span].facet;
        for stations in stations.chunk_by(|a, b| facet(a) == facet(b)) {
            for component in 0..2 {
                // under friction shear and pressure share their functions, and with them their weights
                let shared = match coupling {
                    Coupling::Tied => component,
                    _ => 0,
                };
                let carries = |node: usize| kept[&node][shared];
                let whole = match cover.facet(facet(&stations[0])) {
                    true => Basis::of_facet(stations, carries),
                    false => None,
                };
                let mut in_part = (usize::MAX, Basis::Hats);
                for station in stations {
                    let nodes = self.spans[station.span].nodes;
                    let basis = match &whole {
                        Some(basis) => basis,
                        None if in_part.0 == station.span => &in_part.1,
                        None => {
                            let span = stations.iter().filter(|s| s.span == station.span);
                            let hats = match nodes.into_iter().all(carries) {
                                true => cover.interval(station.span),
                                false => None,
                            };
                            let basis = hats.and_then(|ends| Basis::of_interval(span, ends));
                            in_part = (station.span, basis.unwrap_or(Basis::Hats));
                            &in_part.1
                        }
                    };
                    for (node, share) in basis.shares(station, nodes, carries) {
                        if component == 0
                            && let Some(sums) = sums.get_mut(&node)
                        {
                            sums.extent += share * station.length;
                        }
                    }
                    for (node, psi) in basis.values(station, nodes, carries) {
                        if psi != 0.0
                            && kept[&node][component]
                            && let Some(sums) = sums.get_mut(&node)
                        {
                            sums.add(component, psi, station);
                        }
                    }
                }
            }
        }
        let points = stations.into_iter().map(|station| station.at).collect();
        self.assembled(&sums, &whole, &normals, &kept, coupling, points)
    }

    /// The points of integration of all pieces.
    fn stations(&self, pieces: &[Piece]) -> Result<Vec<Station>, ContactError> {
        let rule = quadrature::gauss(POINTS);
        let each = pieces.par_iter().map(|piece| {
            let half = 0.5 * (piece.ends[1] - piece.ends[0]);
            let middle = 0.5 * (piece.ends[1] + piece.ends[0]);
            let stations = rule.iter().filter_map(|&(x, weight)| {
                self.station(piece, middle + half * x, half * weight)
                    .transpose()
            });
            stations.collect::<Result<Vec<_>, _>>()
        });
        let each: Vec<Vec<_>> = each.collect::<Result<_, _>>()?;
        let mut stations: Vec<Station> = each.into_iter().flatten().collect();
        for (index, station) in stations.iter_mut().enumerate() {
            station.index = index;
        }
        Ok(stations)
    }

    /// ∫ of the hat of every node over the whole side.
    fn whole_weights(&self) -> BTreeMap<usize, f64> {
        let rule = quadrature::gauss(POINTS);
        let thickness = self.sides.nonmortar.body.thickness;
        let mut whole = BTreeMap::new();
        for span in &self.spans {
            let half = 0.5 * (span.ends[1] - span.ends[0]);
            for &(x, weight) in &rule {
                let t = 0.5 * (1.0 + x);
                let xi = span.ends[0] + 2.0 * half * t;
                let tangent = norm(self.mesh().outward_normal(span.facet, &[xi]));
                let point = self.mesh().facet_point(span.facet, &[xi]);
                let area = half * weight * tangent * measure(self.analysis, thickness, point);
                for (node, hat) in span.nodes.into_iter().zip([1.0 - t, t]) {
                    *whole.entry(node).or_insert(0.0) += hat * area;
                }
            }
        }
        whole
    }

    /// Which components of which nodes carry multipliers.
    fn kept(
        &self,
        sums: &BTreeMap<usize, Sums>,
        whole: &BTreeMap<usize, f64>,
        normals: &BTreeMap<usize, Point<2>>,
        coupling: Coupling,
        stations: &[Station],
    ) -> BTreeMap<usize, [bool; 2]> {
        let covered = |node: &usize| sums.get(node).map_or(0.0, |s| s.own[0]) / whole[node];
        let mut kept: BTreeMap<usize, [bool; 2]> = whole
            .keys()
            .map(|node| {
                let held = self.sides.nonmortar.constraints.at(*node);
                let relative = Relative {
                    prescribed: axes(held, |_| true),
                    still: axes(held, |h| h.still && self.opposite_held(*node, h.axis, true)),
                };
                let normal = normals.get(node).copied().unwrap_or([0.0; 2]);
                (
                    *node,
                    relative
                        .decided(frame(normal, &[]), coupling)
                        .map(|held| !held),
                )
            })
            .collect();
        let spans: BTreeSet<usize> = stations.iter().map(|station| station.span).collect();
        // a prescribed node gives its functions to its neighbours; between two of them it keeps its own
        let lone = |span: &usize| self.spans[*span].nodes.iter().all(|n| !kept[n][0]);
        let alone: BTreeSet<usize> = spans.iter().copied().filter(lone).collect();
        if coupling != Coupling::Tied && spans.iter().any(|span| !alone.contains(span)) {
            for node in alone.iter().flat_map(|&span| self.spans[span].nodes) {
                let normal = normals.get(&node).copied().unwrap_or([0.0; 2]);
                if !self.opposite_held(node, normal, false) {
                    let frictional = coupling == Coupling::Frictional;
                    kept.insert(node, std::array::from_fn(|c| c == 0 || frictional));
                }
            }
        }
        // a sliver gives way to a neighbour that carries more
        for span in spans {
            let [a, b] = self.spans[span].nodes;
            for (node, other) in [(a, b), (b, a)] {
                let replaced = covered(&node) < SLIVER && covered(&other) > covered(&node);
                if replaced && kept[&other][0] {
                    kept.insert(node, [false; 2]);
                }
            }
        }
        kept
    }

    fn assembled(
        &self,
        sums: &BTreeMap<usize, Sums>,
        whole: &BTreeMap<usize, f64>,
        normals: &BTreeMap<usize, Point<2>>,
        kept: &BTreeMap<usize, [bool; 2]>,
        coupling: Coupling,
        points: Vec<GapPoint<2>>,
    ) -> Result<Interface<2>, ContactError> {
        let mut interface = Interface {
            nodes: Vec::new(),
            cyclic: self.cyclic,
            coupling,
            nonmortar: Vec::new(),
            mortar: Vec::new(),
            points,
            implied: Vec::new(),
        };
        let mut seen = BTreeSet::new();
        let along = self.spans.iter().flat_map(|span| {
            let places = span.nodes.into_iter().zip(span.ends);
            places.map(|(node, xi)| (node, span.facet, xi))
        });
        for (node, facet, xi) in along {
            if !seen.insert(node) {
                continue;
            }
            let normal = normals.get(&node).copied().unwrap_or([0.0; 2]);
            let mut entry = InterfaceNode {
                node,
                opposite: Vec::new(),
                frame: frame(normal, &[]),
                weight: whole[&node],
                extent: 0.0,
                gap: f64::NAN,
                clearance: f64::NAN,
                shares: GapShares::default(),
                role: Role::Alone,
                rows: [None; 2],
            };
            let sums = sums.get(&node).filter(|s| s.own[0] > SLIVER * whole[&node]);
            if let Some(sums) = sums {
                if let Some(found) = self.sides.at(facet, &[xi])? {
                    (entry.opposite, entry.clearance) = (found.nodes.clone(), found.gap);
                    entry.shares.at_node = Some(interface.points.len());
                    let along = self.sides.line(facet, &[xi]).direction;
                    interface.points.push(GapPoint {
                        own: vec![(node, 1.0)],
                        opposite: found.nodes,
                        normal: along,
                        along,
                        gap: found.gap,
                    });
                }
                entry.shares.mean = sums.hats.clone();
                entry.role = Role::Fixed;
                entry.weight = sums.own[0];
                entry.gap = sums.own[1] / sums.own[0];
                for component in (0..2).filter(|&c| kept[&node][c] && sums.weight[c] > 0.0) {
                    if entry.role == Role::Fixed {
                        (entry.weight, entry.extent) = (sums.weight[component], sums.extent);
                    }
                    entry.role = Role::Multiplier;
                    entry.rows[component] = Some(interface.nonmortar.len());
                    let [own, other] = sums.rows(component);
                    interface.nonmortar.push(own);
                    interface.mortar.push(other);
                    if component == 0 {
                        entry.gap = sums.gap / sums.weight[0];
                        entry.shares.mean = sums.psi.clone();
                    }
                }
                if entry.clearance.is_nan() {
                    entry.clearance = entry.gap;
                }
            }
            interface.nodes.push(entry);
        }
        let fixed = |node: &InterfaceNode<2>| node.role == Role::Fixed;
        if interface.nonmortar.is_empty() && interface.nodes.iter().any(fixed) {
            let side = self.sides.nonmortar.name();
            return Err(ContactError::AllFixed { side });
        }
        Ok(interface)
    }

    /// Whether the motion of the other side along an axis is prescribed where it lies opposite a node, and if `still`
    /// is asked, to be none at any time.
    fn opposite_held(&self, node: usize, axis: Point<2>, still: bool) -> bool {
        let mortar = match self.sides.against {
            Against::Obstacle(_, Driven::Free) => return false,
            Against::Obstacle(_, driven) => return driven == Driven::Still || !still,
            Against::Side(mortar) => mortar,
        };
        let places = self.spans.iter().flat_map(|span| {
            let ends = span.nodes.into_iter().zip(span.ends);
            ends.map(|(node, xi)| (node, span.facet, xi))
        });
        let mut own = places.filter(|place| place.0 == node);
        let opposite =
            own.find_map(|(_, facet, xi)| Some(self.sides.at(facet, &[xi]).ok()??.nodes));
        let held = |node: usize| {
            let held = axes(mortar.constraints.at(node), |h| h.still || !still);
            let part: f64 = held.iter().map(|&h| dot(h, axis).powi(2)).sum();
            part > 1.0 - 1e-6
        };
        let bearing = |&&(_, shape): &&(usize, f64)| shape.abs() > 1e-6;
        opposite.is_none_or(|nodes| nodes.iter().filter(bearing).all(|(node, _)| held(*node)))
    }
}

/// A facet is covered when all but this part of it faces the other side: rounding.
const COVERED: f64 = 1e-9;

/// Which parts of the side face the other one.
struct Cover {
    /// How much of each facet, in its reference coordinate: 2 is all of it.
    facets: BTreeMap<Facet, f64>,
    /// The covered part of each span, where it is one interval; in reference coordinates of the facet.
    spans: BTreeMap<usize, Option<[f64; 2]>>,
}

impl Cover {
    fn new(all: &[Span], pieces: &[Piece]) -> Self {
        let (mut facets, mut spans) = (BTreeMap::new(), BTreeMap::new());
        for piece in pieces {
            let [from, to] = piece.ends;
            *facets.entry(all[piece.span].facet).or_insert(0.0) += to - from;
            let interval = spans.entry(piece.span).or_insert(Some([from, from]));
            *interval = interval.and_then(|[start, end]| {
                let joins = (from - end).abs() <= COVERED;
                joins.then_some([start, to])
            });
        }
        Self { facets, spans }
    }

    /// All of a facet faces the other side.
    fn facet(&self, facet: Facet) -> bool {
        self.facets[&facet] > 2.0 * (1.0 - COVERED)
    }

    /// The covered part of a span; `None` where it has a hole.
    fn interval(&self, span: usize) -> Option<[f64; 2]> {
        self.spans[&span]
    }
}

/// The functions ψ on one facet or span.
enum Basis {
    /// ψ = A N on a facet.
    Biorthogonal([[f64; FACET_NODES]; FACET_NODES]),
    /// ψ = A h with the hats h of an interval.
    Interval([f64; 2], [[f64; 2]; 2]),
    Hats,
}

impl Basis {
    /// A = diag(∫N) M⁻¹ with M = ∫NNᵀ, where all nodes of the facet carry multipliers and all weights are positive.
    fn of_facet(stations: &[Station], carries: impl Fn(usize) -> bool) -> Option<Self> {
        let nodes: Vec<usize> = stations[0].at.own.iter().map(|&(node, _)| node).collect();
        let mut weights = [0.0; FACET_NODES];
        let mut mass = [[0.0; FACET_NODES]; FACET_NODES];
        for station in stations {
            for (i, &(_, a)) in station.at.own.iter().enumerate() {
                weights[i] += a * station.area;
                for (j, &(_, b)) in station.at.own.iter().enumerate() {
                    mass[i][j] += a * b * station.area;
                }
            }
        }
        let mean = weights.iter().sum::<f64>() / nodes.len() as f64;
        let smallest = weights[..nodes.len()].iter().fold(mean, |s, w| s.min(*w));
        if smallest <= POSITIVE * mean || !nodes.iter().all(|&node| carries(node)) {
            return None;
        }
        let mut matrix = match nodes.len() {
            2 => {
                let (inverse, _) = invert(&[[mass[0][0], mass[0][1]], [mass[1][0], mass[1][1]]]);
                let mut padded = [[0.0; FACET_NODES]; FACET_NODES];
                for (row, from) in padded.iter_mut().zip(inverse) {
                    row[..2].copy_from_slice(&from);
                }
                padded
            }
            _ => invert(&mass).0,
        };
        for (row, weight) in matrix.iter_mut().zip(weights) {
            row.iter_mut().for_each(|a| *a *= weight);
        }
        let finite = matrix.iter().flatten().all(|a| a.is_finite());
        finite.then_some(Self::Biorthogonal(matrix))
    }

    /// A = diag(∫h) M⁻¹ with M = ∫hhᵀ and the hats h of an interval of the facet's reference coordinate.
    fn of_interval<'s>(
        stations: impl Iterator<Item = &'s Station>,
        ends: [f64; 2],
    ) -> Option<Self> {
        let (mut weights, mut mass) = ([0.0; 2], [[0.0; 2]; 2]);
        for station in stations {
            let hats = hats_of(ends, station.xi);
            for (i, a) in hats.into_iter().enumerate() {
                weights[i] += a * station.area;
                for (j, b) in hats.into_iter().enumerate() {
                    mass[i][j] += a * b * station.area;
                }
            }
        }
        let (mut matrix, _) = invert(&mass);
        for (row, weight) in matrix.iter_mut().zip(weights) {
            row.iter_mut().for_each(|a| *a *= weight);
        }
        let finite = matrix.iter().flatten().all(|a| a.is_finite());
        finite.then_some(Self::Interval(ends, matrix))
    }

    /// ψ of each node at a station.
    fn values(
        &self,
        station: &Station,
        nodes: [usize; 2],
        carries: impl Fn(usize) -> bool,
    ) -> Vec<(usize, f64)> {
        match self {
            Self::Biorthogonal(matrix) => {
                let value = |row: &[f64]| -> f64 {
                    let terms = row.iter().zip(&station.at.own);
                    terms.map(|(a, (_, shape))| a * shape).sum()
                };
                let nodes = station.at.own.iter().map(|&(node, _)| node);
                nodes
                    .zip(matrix)
                    .map(|(node, row)| (node, value(row)))
                    .collect()
            }
            Self::Interval(ends, matrix) => {
                let hats = hats_of(*ends, station.xi);
                let psi = matrix.map(|[a, b]| a * hats[0] + b * hats[1]);
                nodes.into_iter().zip(psi).collect()
            }
            Self::Hats => hats(station, nodes, carries),
        }
    }

    /// The part of a station that each node stands for: positive functions that sum to one.
    fn shares(
        &self,
        station: &Station,
        nodes: [usize; 2],
        carries: impl Fn(usize) -> bool,
    ) -> Vec<(usize, f64)> {
        match self {
            Self::Biorthogonal(_) => station.at.own.clone(),
            Self::Interval(ends, _) => {
                let hats = hats_of(*ends, station.xi);
                nodes.into_iter().zip(hats).collect()
            }
            Self::Hats => hats(station, nodes, carries),
        }
    }
}

/// The two hats of an interval.
fn hats_of([from, to]: [f64; 2], xi: f64) -> [f64; 2] {
    let t = (xi - from) / (to - from);
    [1.0 - t, t]
}

/// Hats at a station; where one of the two nodes carries nothing the other takes its part.
fn hats(
    station: &Station,
    nodes: [usize; 2],
    carries: impl Fn(usize) -> bool,
) -> Vec<(usize, f64)> {
    let psi = match nodes.map(&carries) {
        [true, true] => station.hats,
        carries => carries.map(|c| f64::from(u8::from(c))),
    };
    nodes.into_iter().zip(psi).collect()
}

/// Rotation of a facet at a hit, times the distance, as coefficients of its nodes' displacements: −Σ Nₐ' n·uₐ/|y'|.
fn rotation(mesh: &Mesh<2>, hit: Hit) -> Vec<(usize, Point<2>)> {
    let mut slopes = [[0.0; 2]; FACET_NODES];
    mesh.facet_kind(hit.facet).gradients(&hit.xi, &mut slopes);
    // as long as |y'|
    let normal = mesh.outward_normal(hit.facet, &hit.xi);
    let scale = -hit.distance / dot(normal, normal);
    let nodes = mesh.facet_nodes(hit.facet).map(|node| node as usize);
    nodes
        .zip(slopes)
        .map(|(node, slope)| (node, normal.map(|c| scale * slope[0] * c)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{end, flat, held, node_at, ring, wall};
    use crate::contact::{Rigid, pair_nodes};
    use crate::fem::{Body, Constraints};
    use crate::geometry::{Field, Surface};
    use crate::mesh::CellKind;

    /// One side over another, nothing held.
    fn paired(own: &Body<2>, other: &Body<2>, coupling: Coupling) -> Interface<2> {
        let free = Constraints::default();
        let against = Against::Side(end(other, "bottom", &free));
        let gap = InitialGap::Measured;
        let analysis = Analysis::PlaneStrain;
        pair_mortar(
            end(own, "bottom", &free),
            against,
            gap,
            coupling,
            analysis,
            0.0,
        )
        .unwrap()
    }

    /// A row times the displacements of its body, given as a function of place.
    fn times(row: &Row<2>, body: &Body<2>, u: impl Fn(Point<2>) -> Point<2>) -> f64 {
        let terms = row.iter();
        terms
            .map(|&(node, c)| dot(c, u(body.mesh.points()[node])))
            .sum()
    }

    fn arc(from: f64, to: f64, count: usize, lift: f64) -> Vec<Point<2>> {
        let place = |k: usize| from + (to - from) * k as f64 / (count - 1) as f64;
        let points = (0..count).map(place);
        points.map(|x| [x, 0.15 * x * x + lift]).collect()
    }

    #[test]
    fn a_rigid_motion_of_both_bodies_together_neither_opens_nor_slips() {
        let motion = |[x, y]: Point<2>| [0.3 - 0.7 * y, -0.2 + 0.7 * x];
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            for other in [CellKind::Quad4, CellKind::Quad8] {
                let upper = wall(&arc(-1.5, 1.5, 9, 0.0), 4.0, cell);
                let lower = wall(&arc(-1.2, 2.0, 7, -0.3), -3.0, other);
                for coupling in [Coupling::Frictional, Coupling::Tied] {
                    let interface = paired(&upper, &lower, coupling);
                    assert!(interface.nonmortar.len() >= 14);
                    for (own, other) in interface.nonmortar.iter().zip(&interface.mortar) {
                        let moved = times(own, &upper, motion) + times(other, &lower, motion);
                        // rounding
                        assert!(moved.abs() < 1e-13, "{moved}");
                    }
                }
            }
        }
    }

    #[test]
    fn rows_times_their_weights_add_up_to_the_integrals_over_what_is_covered() {
        // from 0.5 to 3.5, of the thickness 2
        let us = |[x, _]: Point<2>| [1.0 + 0.5 * x, 0.3 + 0.2 * x];
        let um = |[x, _]: Point<2>| [2.0 - 0.5 * x, 0.1 * x];
        let free = Constraints::default();
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            for other in [CellKind::Quad4, CellKind::Quad8] {
                let mut upper = flat(&[0.0, 1.0, 2.0, 3.0, 4.0], 1.0, cell);
                upper.thickness = 2.0;
                let lower = flat(&[0.5, 1.3, 2.1, 2.7, 3.5], -1.0, other);
                let gap = Field::function("x² t", |p, t| p[0] * p[0] * t);
                let interface = pair_mortar(
                    end(&upper, "bottom", &free),
                    Against::Side(end(&lower, "bottom", &free)),
                    InitialGap::Given(&gap),
                    Coupling::Frictional,
                    Analysis::PlaneStress,
                    3.0,
                );
                let interface = interface.unwrap();
                let sum = |f: &dyn Fn(&InterfaceNode<2>) -> f64| -> f64 {
                    interface.carriers().map(|node| node.weight * f(node)).sum()
                };
                let row = |node: &InterfaceNode<2>, component: usize| node.rows[component].unwrap();
                let (own, other) = (&interface.nonmortar, &interface.mortar);
                let found = [
                    sum(&|_| 1.0),
                    interface.carriers().map(|node| node.extent).sum(),
                    sum(&|node| node.gap),
                    sum(&|node| times(&own[row(node, 0)], &upper, us)),
                    sum(&|node| times(&own[row(node, 1)], &upper, us)),
                    sum(&|node| times(&other[row(node, 0)], &lower, um)),
                    sum(&|node| times(&other[row(node, 1)], &lower, um)),
                ];
                // the normal is −y, the tangent +x
                let expected = [6.0, 3.0, 6.0 * 14.25, -4.2, 12.0, 1.2, -6.0];
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn nodes_of_covered_facets_have_rows_of_their_own() {
        let places = [0.0, 1.0, 2.0, 3.0, 4.0];
        for (cell, weights) in [
            (CellKind::Quad4, [0.5, 1.0, 1.0, 1.0, 0.5]),
            // a third, four thirds, two thirds of a half
            (
                CellKind::Quad8,
                [1.0, 4.0, 2.0, 4.0, 1.0].map(|w: f64| w / 3.0),
            ),
        ] {
            let upper = flat(&places, 1.0, cell);
            let sloping = [-1.0, 0.7, 2.3, 4.5].map(|x| [x, -1.0 + 0.1 * x]);
            let lower = wall(&sloping, -3.0, CellKind::Quad4);
            let interface = paired(&upper, &lower, Coupling::Frictional);
            let nodes = interface.nodes.iter().zip(places).zip(weights);
            for ((node, x), weight) in nodes {
                assert_eq!(node.node, node_at(&upper, [x, 0.0]));
                assert!((node.weight - weight).abs() < 1e-13 && node.extent > 0.0);
                // a mean of a linear gap is that at the node
                assert!((node.gap - (1.0 - 0.1 * x)).abs() < 1e-12, "{}", node.gap);
                assert!((node.clearance - (1.0 - 0.1 * x)).abs() < 1e-13);
                let point = &interface.points[node.shares.at_node.unwrap()];
                assert_eq!(point.own, [(node.node, 1.0)]);
                for (row, direction) in node.rows.into_iter().zip([[0.0, -1.0], [1.0, 0.0]]) {
                    let row = row.unwrap();
                    for &(j, c) in &interface.nonmortar[row] {
                        let own = f64::from(u8::from(j == node.node));
                        let rest = add_scaled(c, -own, direction);
                        assert!(norm(rest) < 1e-12, "{c:?}");
                    }
                    if direction[1] != 0.0 {
                        // linear displacements of the other side are taken at the node as well
                        let u = |[x, _]: Point<2>| [9.0, 2.0 + x];
                        let found = times(&interface.mortar[row], &lower, u);
                        assert!((found - (2.0 + x)).abs() < 1e-12, "{found}");
                    }
                }
            }
        }
    }

    #[test]
    fn on_matching_meshes_rows_are_those_of_the_pairs() {
        let places = [0.0, 1.0, 1.8, 3.0, 4.0];
        let (upper, lower) = (
            flat(&places, 1.0, CellKind::Quad4),
            flat(&places, -1.0, CellKind::Quad4),
        );
        let free = Constraints::default();
        let mortar = paired(&upper, &lower, Coupling::Frictional);
        let ends = [end(&upper, "bottom", &free), end(&lower, "bottom", &free)];
        let (gap, coupling) = (InitialGap::Measured, Coupling::Frictional);
        let analysis = Analysis::PlaneStrain;
        let nodal = pair_nodes(ends[0], ends[1], gap, coupling, analysis, 0.0).unwrap();
        let u = |[x, y]: Point<2>| [(3.0 * x).sin() + y, (2.0 * x).cos()];
        for (a, b) in mortar.nodes.iter().zip(&nodal.nodes) {
            assert_eq!((a.node, a.rows, a.role), (b.node, b.rows, b.role));
            assert!((a.weight - b.weight).abs() < 1e-13 && (a.extent - b.extent).abs() < 1e-13);
        }
        let rows = |interface: &Interface<2>| -> Vec<[f64; 2]> {
            let rows = interface.nonmortar.iter().zip(&interface.mortar);
            rows.map(|(own, other)| [times(own, &upper, u), times(other, &lower, u)])
                .collect()
        };
        for (a, b) in rows(&mortar).into_iter().zip(rows(&nodal)) {
            assert!((a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_facet_that_is_covered_in_part_is_loaded_at_the_ends_of_that_part() {
        let upper = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
        let lower = flat(&[0.5, 1.0, 3.0], -1.0, CellKind::Quad4);
        let interface = paired(&upper, &lower, Coupling::Normal);
        let u = |[x, _]: Point<2>| [9.0, 2.0 + x];
        for (node, (place, weight)) in
            interface
                .nodes
                .iter()
                .zip([(0.5, 0.25), (1.0, 0.75), (2.0, 0.5)])
        {
            assert!((node.weight - weight).abs() < 1e-14);
            let row = node.rows[0].unwrap();
            let found = times(&interface.nonmortar[row], &upper, u);
            assert!((found + 2.0 + place).abs() < 1e-13, "{found}");
        }
    }

    #[test]
    fn over_a_hole_the_functions_are_linear() {
        let upper = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        let lower = flat(&[0.0, 0.4, 0.6, 1.0], -1.0, CellKind::Quad4);
        let free = Constraints::default();
        let whole = end(&lower, "bottom", &free);
        let facets = whole.facets().unwrap();
        let mortar = End {
            part: Some(&[facets[0], facets[2]]),
            ..whole
        };
        let interface = pair_mortar(
            end(&upper, "bottom", &free),
            Against::Side(mortar),
            InitialGap::Measured,
            Coupling::Normal,
            Analysis::PlaneStrain,
            0.0,
        );
        let interface = interface.unwrap();
        // ∫(1 − x) and ∫(1 − x) x over 0 … 0.4 and 0.6 … 1
        let weight = 0.4;
        let first = 0.5 * (0.16 + 1.0 - 0.36) - (0.064 + 1.0 - 0.216) / 3.0;
        let row = &interface.nonmortar[interface.nodes[0].rows[0].unwrap()];
        assert!((interface.nodes[0].weight - weight).abs() < 1e-14);
        let found = times(row, &upper, |[x, _]| [0.0, x]);
        assert!((found + first / weight).abs() < 1e-13, "{found}");
    }

    #[test]
    fn a_prescribed_node_gives_its_facets_to_its_neighbours() {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let lower = flat(&[-1.0, 1.5, 4.0], -1.0, CellKind::Quad4);
        let middle = node_at(&upper, [1.0, 0.0]);
        let supports = held(&[(middle, [0.0, 1.0], true)]);
        let free = Constraints::default();
        let interface = pair_mortar(
            end(&upper, "bottom", &supports),
            Against::Side(end(&lower, "bottom", &free)),
            InitialGap::Measured,
            Coupling::Frictional,
            Analysis::PlaneStrain,
            0.0,
        );
        let interface = interface.unwrap();
        let fixed = &interface.nodes[1];
        assert_eq!((fixed.role, fixed.rows), (Role::Fixed, [None; 2]));
        // what faces the other side there, all the same
        assert!((fixed.weight - 1.0).abs() < 1e-14 && fixed.gap.abs() < 1e-14);
        let u = |[x, _]: Point<2>| [0.0, x];
        for (place, weight, mean) in [(0, 1.0, 0.5), (2, 1.5, (1.5 + 1.0) / 1.5), (3, 0.5, 3.0)] {
            let node = &interface.nodes[place];
            assert!((node.weight - weight).abs() < 1e-14);
            assert!((node.extent - weight).abs() < 1e-14);
            let found = times(&interface.nonmortar[node.rows[0].unwrap()], &upper, u);
            assert!((found + mean).abs() < 1e-13, "{found}");
        }
    }

    /// Which rows the nodes of a side at x = 0, 1, 2, 3 have over a plane.
    fn over_a_plane(
        directions: &[(f64, Point<2>, bool)],
        driven: Driven,
        coupling: Coupling,
    ) -> Result<Vec<[bool; 2]>, ContactError> {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let directions: Vec<_> = directions
            .iter()
            .map(|&(x, axis, still)| (node_at(&upper, [x, 0.0]), axis, still))
            .collect();
        let supports = held(&directions);
        let rigid = Rigid::Surface {
            surface: Surface::Plane {
                point: [0.0, -0.5],
                normal: [0.0, 1.0],
            },
            inside: false,
        };
        let interface = pair_mortar(
            end(&upper, "bottom", &supports),
            Against::Obstacle(&rigid, driven),
            InitialGap::Measured,
            coupling,
            Analysis::PlaneStrain,
            0.0,
        )?;
        assert!(
            interface
                .nodes
                .iter()
                .all(|node| (node.gap - 0.5).abs() < 1e-14)
        );
        assert!(interface.nodes.iter().all(|node| node.opposite.is_empty()));
        let length: f64 = interface.carriers().map(|node| node.weight).sum();
        assert!(coupling == Coupling::Tied || (length - 3.0).abs() < 1e-13);
        let rows = |node: &InterfaceNode<2>| node.rows.map(|row| row.is_some());
        Ok(interface.nodes.iter().map(rows).collect())
    }

    const X: Point<2> = [1.0, 0.0];
    const Y: Point<2> = [0.0, 1.0];
    const BOTH: [bool; 2] = [true, true];
    const NONE: [bool; 2] = [false, false];
    const NORMAL: [bool; 2] = [true, false];

    #[test]
    fn a_node_that_stays_still_slips_against_an_obstacle_that_moves() {
        for (driven, still, rows) in [
            (Driven::Still, true, NORMAL),
            (Driven::Still, false, BOTH),
            (Driven::Prescribed, true, BOTH),
            (Driven::Free, true, BOTH),
        ] {
            let found = over_a_plane(&[(1.0, X, still)], driven, Coupling::Frictional).unwrap();
            assert_eq!(found, [BOTH, rows, BOTH, BOTH], "{driven:?} {still}");
        }
    }

    #[test]
    fn between_two_prescribed_nodes_a_free_obstacle_is_borne() {
        let two = [(0.0, Y, true), (1.0, Y, true)];
        for (coupling, free) in [(Coupling::Frictional, BOTH), (Coupling::Normal, NORMAL)] {
            let found = |driven| over_a_plane(&two, driven, coupling);
            // forces may move the obstacle against them
            assert_eq!(found(Driven::Free), Ok(vec![free; 4]));
        }
        // a tie of what is prescribed is none
        let found = over_a_plane(&two, Driven::Free, Coupling::Tied).unwrap();
        assert_eq!(found, [[false, true], [false, true], BOTH, BOTH]);
        // one alone gives way
        let found = over_a_plane(&two[..1], Driven::Free, Coupling::Frictional).unwrap();
        assert_eq!(found, [NONE, BOTH, BOTH, BOTH]);
        let all = [0.0, 1.0, 2.0, 3.0].map(|x| (x, Y, true));
        let side = "body.bottom".to_string();
        let found = over_a_plane(&all, Driven::Free, Coupling::Normal);
        assert_eq!(found, Err(ContactError::AllFixed { side }));
    }

    /// Which rows the nodes of a side at x = 0, 1, 2, 3 have over one at x = −1, 0.5, 1.5, 4.
    fn over_a_side(
        own: &[(f64, Point<2>, bool)],
        other: &[(f64, Point<2>, bool)],
    ) -> Vec<[bool; 2]> {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let lower = flat(&[-1.0, 0.5, 1.5, 4.0], -1.0, CellKind::Quad4);
        let supports = |body: &Body<2>, directions: &[(f64, Point<2>, bool)]| {
            let directions = directions.iter();
            let directions: Vec<_> = directions
                .map(|&(x, axis, still)| (node_at(body, [x, 0.0]), axis, still))
                .collect();
            held(&directions)
        };
        let (own, other) = (supports(&upper, own), supports(&lower, other));
        let interface = pair_mortar(
            end(&upper, "bottom", &own),
            Against::Side(end(&lower, "bottom", &other)),
            InitialGap::Measured,
            Coupling::Frictional,
            Analysis::PlaneStrain,
            0.0,
        );
        let rows = |node: &InterfaceNode<2>| node.rows.map(|row| row.is_some());
        interface.unwrap().nodes.iter().map(rows).collect()
    }

    #[test]
    fn nothing_slips_where_both_sides_stay_still() {
        let own = [(1.0, X, true)];
        // the node at x = 1 lies between those at 0.5 and 1.5
        for (other, rows) in [
            (vec![(0.5, X, true), (1.5, X, true)], NORMAL),
            (vec![(0.5, X, true)], BOTH),
            (vec![(1.5, X, true)], BOTH),
            (vec![(0.5, X, true), (1.5, X, false)], BOTH),
            (vec![(0.5, Y, true), (1.5, Y, true)], BOTH),
            (vec![], BOTH),
        ] {
            assert_eq!(
                over_a_side(&own, &other),
                [BOTH, rows, BOTH, BOTH],
                "{other:?}"
            );
        }
    }

    #[test]
    fn prescribed_neighbours_keep_their_pressure_unless_the_other_side_is_prescribed_too() {
        let own = [(1.0, Y, true), (2.0, Y, false)];
        // the node at x = 1 lies between those at 0.5 and 1.5, that at x = 2 between those at 1.5 and 4
        for (other, rows) in [
            (vec![], [BOTH; 4]),
            (
                vec![(0.5, Y, true), (1.5, Y, false)],
                [BOTH, NONE, BOTH, BOTH],
            ),
            (
                vec![(1.5, Y, false), (4.0, Y, false)],
                [BOTH, BOTH, NONE, BOTH],
            ),
            (vec![(1.5, X, true), (4.0, X, true)], [BOTH; 4]),
        ] {
            assert_eq!(over_a_side(&own, &other), rows, "{other:?}");
        }
    }

    #[test]
    fn a_node_of_whose_surroundings_less_than_a_thousandth_is_covered_carries_nothing() {
        // over the last ε of its facet the hat of an end node is ε² of its whole
        for (cover, carries) in [(0.031, false), (0.0322, true)] {
            let upper = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
            let lower = flat(&[1.0 - cover, 3.0], -1.0, CellKind::Quad4);
            let interface = paired(&upper, &lower, Coupling::Normal);
            let first = &interface.nodes[0];
            assert_eq!(first.rows[0].is_some(), carries, "{cover}");
            assert_eq!(first.role == Role::Alone, !carries);
            // what it leaves goes to its neighbour
            let length: f64 = interface.carriers().map(|node| node.weight).sum();
            assert!((length - 1.0 - cover).abs() < 1e-13);
            let expected = if carries { 0.5 * cover } else { 0.5 };
            assert!((first.weight - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn what_faces_nothing_weighs_its_surroundings() {
        let turn = 2.0 * std::f64::consts::PI;
        let free = Constraints::default();
        let other = flat(&[3.5, 5.0], -1.0, CellKind::Quad4);
        for (cell, analysis, weights) in [
            (CellKind::Quad4, Analysis::PlaneStrain, [1.0, 2.0, 2.0]),
            (CellKind::Quad8, Analysis::PlaneStrain, [1.0, 2.0, 2.0]),
            // ∫N r of a facet of length L from r to R: L (2r + R)/6
            (
                CellKind::Quad4,
                Analysis::Axisymmetric,
                [turn / 6.0, turn, 2.0 * turn],
            ),
        ] {
            let mut upper = flat(&[0.0, 1.0, 2.0, 3.0, 4.0], 1.0, cell);
            upper.thickness = 2.0;
            let interface = pair_mortar(
                end(&upper, "bottom", &free),
                Against::Side(end(&other, "bottom", &free)),
                InitialGap::Measured,
                Coupling::Normal,
                analysis,
                0.0,
            );
            let interface = interface.unwrap();
            for (node, weight) in interface.nodes.iter().zip(weights) {
                assert_eq!((node.role, node.rows), (Role::Alone, [None; 2]));
                assert!(
                    (node.weight - weight).abs() < 1e-13,
                    "{} {weight}",
                    node.weight
                );
                assert!(node.gap.is_nan() && node.clearance.is_nan() && node.extent == 0.0);
                assert_eq!(node.normal(), [0.0, -1.0]);
            }
        }
    }

    #[test]
    fn where_a_node_weighs_too_little_the_functions_are_linear() {
        // the inner end of a quadratic facet from r to r + 1 weighs r/2 : (r + 1/2) of the mean
        let free = Constraints::default();
        for (radius, own) in [(0.12, false), (0.13, true)] {
            let places = [radius, radius + 0.5, radius + 1.0];
            let upper = flat(&places, 1.0, CellKind::Quad8);
            let lower = flat(&[0.0, 2.0], -1.0, CellKind::Quad4);
            let interface = pair_mortar(
                end(&upper, "bottom", &free),
                Against::Side(end(&lower, "bottom", &free)),
                InitialGap::Measured,
                Coupling::Normal,
                Analysis::Axisymmetric,
                0.0,
            );
            let interface = interface.unwrap();
            let first = &interface.nodes[0];
            let row = &interface.nonmortar[first.rows[0].unwrap()];
            let others = row.iter().filter(|(node, _)| *node != first.node);
            let largest = others.map(|(_, c)| norm(*c)).fold(0.0, f64::max);
            assert_eq!(largest < 1e-9, own, "{radius} {largest}");
        }
    }

    #[test]
    fn a_ring_closes_on_itself_and_neither_its_parts_nor_two_circles_do() {
        let (mut inner, outer) = (
            ring([0.0, 0.0], [1.0, 2.0], 12),
            ring([0.0, 0.0], [2.1, 3.0], 17),
        );
        inner.mesh = inner.mesh.with_side("both", |_| true);
        let free = Constraints::default();
        let pair = |nonmortar: End<'_, 2>| {
            let against = Against::Side(end(&outer, "inner", &free));
            let (gap, coupling) = (InitialGap::Measured, Coupling::Normal);
            pair_mortar(
                nonmortar,
                against,
                gap,
                coupling,
                Analysis::PlaneStrain,
                0.0,
            )
            .unwrap()
        };
        let whole = end(&inner, "outer", &free);
        let interface = pair(whole);
        assert!(interface.cyclic);
        let order: Vec<usize> = interface.nodes.iter().map(|node| node.node).collect();
        let chain = &inner.mesh.chain("outer").unwrap()[0];
        let expected: Vec<usize> = chain.nodes.iter().map(|&node| node as usize).collect();
        assert_eq!(order, expected);
        let part = End {
            part: Some(&chain.facets[1..4]),
            ..whole
        };
        let part = pair(part);
        assert!(!part.cyclic && part.nodes.len() == 4);
        assert!(!pair(end(&inner, "both", &free)).cyclic);
    }

    #[test]
    fn sides_that_are_not_there_and_gaps_that_are_no_numbers_are_errors() {
        let body = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        let free = Constraints::default();
        let gap = Field::constant(f64::NAN);
        let lower = flat(&[0.0, 1.0], -1.0, CellKind::Quad4);
        for (own, other, word) in [
            ("nowhere", "bottom", "nowhere"),
            ("bottom", "elsewhere", "elsewhere"),
            ("bottom", "bottom", "not finite"),
        ] {
            let against = Against::Side(end(&lower, other, &free));
            let (gap, coupling) = (InitialGap::Given(&gap), Coupling::Normal);
            let own = end(&body, own, &free);
            let found = pair_mortar(own, against, gap, coupling, Analysis::PlaneStrain, 0.0);
            let message = found.unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }

    /// The cover of a facet with one span by these pieces.
    fn cover(ends: &[[f64; 2]]) -> (bool, Option<[f64; 2]>) {
        let body = flat(&[0.0, 1.0], 1.0, CellKind::Quad4);
        let facet = body.mesh.side("bottom").unwrap()[0];
        let spans = spans(&body.mesh, facet);
        let pieces: Vec<Piece> = ends
            .iter()
            .map(|&ends| Piece {
                span: 0,
                ends,
                opposite: None,
            })
            .collect();
        let cover = Cover::new(&spans, &pieces);
        (cover.facet(facet), cover.interval(0))
    }

    #[test]
    fn pieces_that_join_cover_an_interval_and_all_of_them_the_facet() {
        assert_eq!(cover(&[[-1.0, 0.2], [0.2, 1.0]]), (true, Some([-1.0, 1.0])));
        assert_eq!(
            cover(&[[-0.5, 0.2], [0.2, 0.9]]),
            (false, Some([-0.5, 0.9]))
        );
        assert_eq!(cover(&[[-1.0, 0.2], [0.3, 1.0]]), (false, None));
        // a billionth is rounding, of the facet as of the place
        assert!(cover(&[[-1.0, 1.0 - 1.8e-9]]).0);
        assert!(!cover(&[[-1.0, 1.0 - 2.2e-9]]).0);
        assert!(cover(&[[-1.0, 0.0], [0.95e-9, 0.5]]).1.is_some());
        assert!(cover(&[[-1.0, 0.0], [1.05e-9, 0.5]]).1.is_none());
    }

    #[test]
    fn a_tie_of_a_node_that_is_held_along_the_normal_keeps_its_tangent() {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0], 1.0, CellKind::Quad4);
        let lower = flat(&[-1.0, 0.4, 1.5, 4.0], -1.0, CellKind::Quad4);
        let middle = node_at(&upper, [1.0, 0.0]);
        let supports = held(&[(middle, Y, true)]);
        let free = Constraints::default();
        let interface = pair_mortar(
            end(&upper, "bottom", &supports),
            Against::Side(end(&lower, "bottom", &free)),
            InitialGap::Measured,
            Coupling::Tied,
            Analysis::PlaneStrain,
            0.0,
        );
        let interface = interface.unwrap();
        let u = |[x, _]: Point<2>| [5.0 + x, x];
        let nodes = &interface.nodes;
        assert_eq!(nodes[1].rows[0], None);
        let times = |row: Option<usize>| times(&interface.nonmortar[row.unwrap()], &upper, u);
        // the neighbour's pressure spreads over the facet, the shear of each node stands for itself
        assert!((times(nodes[0].rows[0]) + 0.5).abs() < 1e-13);
        for (node, x) in nodes.iter().zip([0.0, 1.0, 2.0, 3.0]) {
            assert!((times(node.rows[1]) - 5.0 - x).abs() < 1e-13);
        }
        // its weight is that of the row that it has
        assert!((nodes[1].weight - 1.0).abs() < 1e-14);
        assert!((nodes[0].weight - 1.0).abs() < 1e-14);
        assert_eq!(nodes[1].role, Role::Multiplier);
    }
}
