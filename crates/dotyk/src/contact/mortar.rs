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
