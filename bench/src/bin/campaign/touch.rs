//! The geometry of a contact: points of the nonmortar side, the opposite points, and their distances.
//!
//! ```text
//!   gap(x) = g₀(x) + n·(u_other(y) − u_own(x)) ≥ 0,      y = x + s·n
//! ```
//!
//! linearised about the undeformed state, n the outward normal of the nonmortar side, against a plane obstacle minus the
//! plane's. g₀ is s between the meshes, or between the true surfaces behind them, or zero, or given.
//! Facets are cut into the parts that face the other side along lines ([`lines`](crate::lines)) or over areas
//! ([`polygons`](crate::polygons)).

use crate::amount::vector_at;
use crate::cells::{Kind, Place};
use crate::dimension::Dimension;
use crate::elastic::depth;
use crate::problem::{Against, Contact, Drive, Gap, Law, Pairing, Problem, Surface};
use crate::raw::{self, Answer, Mesh, Row};
use crate::side::{At, Hit, SHARP, Skin};
use crate::vector::{across, dot, length, minus, plus, sum, times, unit};
use std::collections::{BTreeMap, BTreeSet};

/// Two nodes coincide within this part of the facets there.
const COINCIDENT: f64 = 1e-6;

/// Sweeps over the faces of a corner: they meet at 30° and more, so that each leaves three quarters of an error at most.
const SWEEPS: usize = 200;

/// A point of the nonmortar side and its opposite point.
#[derive(Debug, Clone)]
pub struct Sample<const D: usize> {
    /// A facet that it lies on.
    pub facet: usize,
    pub x: [f64; D],
    /// Contact normal.
    pub normal: [f64; D],
    /// Shape functions of the own nodes.
    pub own: Vec<(usize, f64)>,
    /// Shape functions of the other side's nodes; empty against an obstacle.
    pub other: Vec<(usize, f64)>,
    /// Distance along the normal between the sides in the meshes.
    pub distance: f64,
    /// Smooth part of the other side.
    pub sheet: usize,
    /// Normal of the opposite facet, and s·∇N of its nodes: the rigid continuation of the other side from y to x.
    lever: ([f64; D], Vec<(usize, [f64; D])>),
}

/// The parts of a side that face the other side.
#[derive(Debug, Default)]
pub struct Facing<const D: usize> {
    /// Facets that face something, with the facets that they face.
    pub seen: BTreeSet<(usize, Option<usize>)>,
    /// Facets beside those may face something between the points that were looked at.
    pub sampled: bool,
    /// Points between the nodes.
    pub between: Vec<Sample<D>>,
    /// The area of all parts, where it is known.
    pub area: Option<f64>,
    /// Points with contact normals: pushes anywhere are sums of pushes at these. Empty where only points were looked at.
    pub points: Vec<([f64; D], [f64; D])>,
}

/// A contact, seen in the undeformed state.
#[derive(Debug)]
pub struct Touch<'a, const D: usize> {
    pub contact: &'a Contact<D>,
    /// Body of the nonmortar side.
    pub own: usize,
    /// Body of the other side.
    pub other: Option<usize>,
    pub skin: Skin<D>,
    pub opposite: Option<Skin<D>>,
    /// Coincident nodes, or an obstacle at nodes: conditions hold node by node.
    pub nodal: bool,
    /// Coincident node of the other side.
    pub partners: BTreeMap<usize, usize>,
    /// All facets of both sides are plane with straight edges.
    pub exact: bool,
    pub facing: Facing<D>,
    /// Facets that face something.
    near: BTreeSet<usize>,
    /// Normals of the rows of each node.
    told: BTreeMap<usize, Vec<[f64; D]>>,
    /// Nodes with a facet that faces something.
    pub faced: BTreeSet<usize>,
    pub faced_other: BTreeSet<usize>,
    /// Samples at nodes of the nonmortar side, one for each smooth part of the side.
    pub at_nodes: BTreeMap<usize, Vec<Sample<D>>>,
    /// Nodes that meet an obstacle between the faces of a sharp corner.
    pub met: BTreeSet<usize>,
    /// Nodes whose facets face several smooth parts of the other side, each with a condition of its own: no condition belongs to the
    /// opposite point of the node alone.
    pub mixed: BTreeSet<usize>,
}

impl<'a, const D: usize> Touch<'a, D>
where
    Problem<D>: Dimension<D>,
{
    /// A contact between the meshes of an answer; the rows tell which side is the nonmortar one.
    pub fn new(
        problem: &'a Problem<D>,
        contact: &'a Contact<D>,
        answer: &Answer<D>,
        raw: &raw::Contact<D>,
    ) -> Self {
        let (own, side) = (raw.nonmortar.0, &raw.nonmortar.1);
        let skin_of = |body: usize, side: &str| {
            let mut surfaces = problem.bodies[body].surfaces.iter();
            let surface = surfaces.find(|(name, _)| name == side);
            Skin::new(&answer.meshes[body], side, surface.map(|s| s.1.clone()))
        };
        let other = match &contact.against {
            Against::Obstacle { .. } => None,
            Against::Side { side: second, .. } => {
                let first = &contact.own;
                let is_first = problem.bodies[own].name == first.body && *side == first.side;
                let mortar = if is_first { second } else { first };
                Some((problem.body(&mortar.body), &mortar.side))
            }
        };
        let opposite = other.map(|(body, side)| skin_of(body, side));
        let mut told: BTreeMap<usize, Vec<[f64; D]>> = BTreeMap::new();
        for row in &raw.rows {
            told.entry(row.node).or_default().push(row.normal);
        }
        let mut touch = Self {
            contact,
            own,
            other: other.map(|(body, _)| body),
            skin: skin_of(own, side),
            opposite,
            nodal: false,
            partners: BTreeMap::new(),
            exact: false,
            facing: Facing::default(),
            near: BTreeSet::new(),
            told,
            faced: BTreeSet::new(),
            faced_other: BTreeSet::new(),
            at_nodes: BTreeMap::new(),
            met: BTreeSet::new(),
            mixed: BTreeSet::new(),
        };
        let flat = |skin: &Skin<D>| skin.flat() && skin.straight;
        touch.exact = flat(&touch.skin)
            && match &contact.against {
                Against::Side { .. } => touch.opposite.as_ref().is_some_and(flat),
                Against::Obstacle { surface, .. } => surface.bent().is_none(),
            };
        touch.find_partners(answer);
        touch.facing = problem.facing(&touch);
        touch.find_faced();
        touch.decide_pairing(problem);
        touch.find_at_nodes(&answer.meshes[own]);
        touch.find_mixed();
        touch
    }
}

impl<const D: usize> Touch<'_, D> {
    /// Largest depth in the search for overlaps: small for lists of sides, so that the search does not pass through a whole body from
    /// a flank that has sunk a little beside a corner.
    fn deepest(&self) -> f64 {
        let other = self.opposite.as_ref().map_or(0.0, |c| c.longest);
        let part = if self.contact.own.side.contains('+') {
            0.05
        } else {
            1.0
        };
        part * self.skin.longest.max(other)
    }

    fn find_partners(&mut self, answer: &Answer<D>) {
        let (Some(other), Some(opposite)) = (self.other, &self.opposite) else {
            return;
        };
        let (mine, theirs) = (&answer.meshes[self.own], &answer.meshes[other]);
        for (&node, facets) in &self.skin.around {
            let lengths = facets.iter().map(|&f| self.skin.facets[f].longest());
            let limit = COINCIDENT * lengths.fold(f64::INFINITY, f64::min);
            let x = mine.points[node];
            let near = |n: &&usize| length(minus(theirs.points[**n], x)) <= limit;
            if let Some(&partner) = opposite.around.keys().find(near) {
                self.partners.insert(node, partner);
            }
        }
    }

    /// Contact normal and distance of the opposite point of a point of a facet, and where it lies on the other side.
    fn opposite(&self, facet: usize, at: &At<D>) -> Option<([f64; D], f64, Option<Hit>)> {
        let n = self.skin.normal(facet, at);
        if let Against::Obstacle { surface, .. } = &self.contact.against {
            let (normal, distance) = surface.opposite(at.x, n)?;
            return Some((normal, distance, None));
        }
        let hit = self.opposite.as_ref()?.hit(at.x, n, self.deepest())?;
        Some((n, hit.distance, Some(hit)))
    }

    /// Whether a point of a facet faces the other side.
    pub fn faces(&self, facet: usize, xi: Place) -> bool {
        let at = self.skin.facets[facet].at(xi);
        self.opposite(facet, &at).is_some()
    }

    /// The sample of a point of a facet, and the opposite facet.
    pub fn look(&self, facet: usize, at: &At<D>) -> Option<(Sample<D>, Option<usize>)> {
        let (normal, distance, hit) = self.opposite(facet, at)?;
        let mut sample = Sample {
            facet,
            x: at.x,
            normal,
            own: at.shape_of(&self.skin.facets[facet].nodes),
            other: Vec::new(),
            distance,
            sheet: 0,
            lever: ([0.0; D], Vec::new()),
        };
        let (Some(hit), Some(opposite)) = (hit, &self.opposite) else {
            return Some((sample, None));
        };
        let other = &opposite.facets[hit.facet];
        let there = other.at(hit.xi);
        sample.distance +=
            opposite.true_offset(there.x, normal) - self.skin.true_offset(at.x, normal);
        sample.sheet = opposite.sheets[hit.facet];
        sample.other = there.shape_of(&other.nodes);
        let slopes = there.gradients().into_iter();
        let slopes = slopes.map(|g| times(hit.distance, g));
        let lever = other.nodes.iter().copied().zip(slopes).collect();
        sample.lever = (unit(there.normal), lever);
        Some((sample, Some(hit.facet)))
    }

    /// Facets and nodes that face the other side.
    fn find_faced(&mut self) {
        let seen = &self.facing.seen;
        let mut near: BTreeSet<usize> = seen.iter().map(|s| s.0).collect();
        let mut near_other: BTreeSet<usize> = seen.iter().filter_map(|s| s.1).collect();
        if self.facing.sampled {
            near = beside(&self.skin, &near);
            if let Some(opposite) = &self.opposite {
                near_other = beside(opposite, &near_other);
            }
        }
        let nodes = |skin: &Skin<D>, facets: &BTreeSet<usize>| {
            let nodes = facets.iter().flat_map(|&f| skin.facets[f].nodes.clone());
            nodes.collect::<BTreeSet<usize>>()
        };
        self.faced = nodes(&self.skin, &near);
        if let Some(opposite) = &self.opposite {
            self.faced_other = nodes(opposite, &near_other);
        }
        self.near = near;
    }

    /// Node by node where an obstacle is touched, or where all facets that face each other have the same nodes; weights of
    /// corners of tri6 and quad8 are not positive, and that of the end of a parabola on the axis of revolution is zero.
    fn decide_pairing(&mut self, problem: &Problem<D>) {
        let facets = &self.skin.facets;
        let negative = |kind: Kind| matches!(kind, Kind::Tri6 | Kind::Quad8);
        let on_axis = problem.analysis.axisymmetric()
            && facets.iter().any(|f| {
                let at_axis = |x: &[f64; D]| x[0].abs() < 1e-9;
                f.kind == Kind::Line3 && f.corners().iter().any(at_axis)
            });
        let same = |&(own, other): &(usize, Option<usize>)| {
            let (Some(other), Some(opposite)) = (other, &self.opposite) else {
                return true;
            };
            let nodes = facets[own].nodes.iter();
            let partners: Option<BTreeSet<usize>> =
                nodes.map(|n| self.partners.get(n).copied()).collect();
            let theirs = opposite.facets[other].nodes.iter().copied().collect();
            partners.is_some_and(|partners| partners == theirs)
        };
        self.nodal = self.contact.pairing != Pairing::Mortar
            && !on_axis
            && !facets.iter().any(|f| negative(f.kind))
            && self.facing.seen.iter().all(same);
    }

    fn find_at_nodes(&mut self, mesh: &Mesh<D>) {
        for (&node, around) in &self.skin.around {
            let x = mesh.points[node];
            if let Some(way) = self.met_at_corner(node, x) {
                let found = self.beyond(around[0], node, x, way);
                self.met.insert(node);
                self.at_nodes.insert(node, found.into_iter().collect());
                continue;
            }
            let groups = self.skin.groups(node).into_iter();
            let near = groups.filter(|group| group.iter().any(|f| self.near.contains(f)));
            let found: Vec<Sample<D>> = near
                .filter_map(|group| self.at_node(node, x, &group))
                .collect();
            if !found.is_empty() {
                self.at_nodes.insert(node, found);
            }
        }
    }

    /// The normal of some facets at a node: that of a row if the angle between the two is at most the turn of the side there. A
    /// support at the end of an arc turns it, and the law holds along it.
    fn normal(&self, node: usize, facets: &[usize]) -> [f64; D] {
        let own = self.skin.mean_normal(facets, node);
        let limit = (1.1 * self.skin.turn).min(1.0);
        let told = self.told.get(&node).into_iter().flatten();
        let near = told.filter(|n| self.nodal && length(minus(**n, own)) <= limit);
        let off = |n: &[f64; D]| length(minus(*n, own));
        let nearest = near.min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.copied().unwrap_or(own)
    }

    /// The sample of a node as a point of some of the facets around it.
    fn at_node(&self, node: usize, x: [f64; D], facets: &[usize]) -> Option<Sample<D>> {
        if matches!(self.contact.against, Against::Obstacle { .. }) {
            let normal = self.normal(node, facets);
            return self.beyond(facets[0], node, x, normal);
        }
        if !self.nodal {
            return facets.iter().find_map(|&f| {
                let at = self.skin.facets[f].at(self.skin.facets[f].place(node)?);
                self.look(f, &at).map(|(sample, _)| sample)
            });
        }
        self.partners.get(&node).map(|&partner| Sample {
            facet: facets[0],
            x,
            normal: self.normal(node, facets),
            own: vec![(node, 1.0)],
            other: vec![(partner, 1.0)],
            distance: 0.0,
            sheet: 0,
            lever: ([0.0; D], Vec::new()),
        })
    }

    /// The sample of a node against an obstacle, along a normal.
    fn beyond(
        &self,
        facet: usize,
        node: usize,
        x: [f64; D],
        normal: [f64; D],
    ) -> Option<Sample<D>> {
        let Against::Obstacle { surface, .. } = &self.contact.against else {
            return None;
        };
        let (normal, distance) = surface.opposite(x, normal)?;
        Some(Sample {
            facet,
            x,
            normal,
            own: vec![(node, 1.0)],
            other: Vec::new(),
            distance,
            sheet: 0,
            lever: ([0.0; D], Vec::new()),
        })
    }

    /// The direction along which a sharp corner meets an obstacle: the direction in the cone of the normals of its faces that is
    /// nearest to the shortest way to the obstacle. `None` if that is the normal of one face.
    fn met_at_corner(&self, node: usize, x: [f64; D]) -> Option<[f64; D]> {
        let Against::Obstacle { surface, .. } = &self.contact.against else {
            return None;
        };
        let integrated = self.contact.pairing == Pairing::Mortar;
        if integrated || self.contact.law == Law::Tied || matches!(surface, Surface::Gap(_)) {
            return None;
        }
        let faces: Vec<[f64; D]> = self.skin.normals_at(node).collect();
        if !apart(&faces) {
            return None;
        }
        let way = surface.way(x);
        // the weights of the faces in turn, until their sum has converged
        let mut weights = vec![0.0; faces.len()];
        let mut rest = way;
        for _ in 0..SWEEPS {
            for (weight, &face) in weights.iter_mut().zip(&faces) {
                let raised = (*weight + dot(rest, face)).max(0.0);
                rest = plus(rest, *weight - raised, face);
                *weight = raised;
            }
        }
        let several = weights.iter().filter(|&&w| w > 1e-9).count() > 1;
        several.then(|| unit(minus(way, rest)))
    }

    /// The facets around its node that a row belongs to, and its sample. At a sharp corner these are some of the facets: those whose
    /// mean normal fits that of the row best.
    pub fn of_row(&self, row: &Row<D>) -> Option<(Vec<usize>, Sample<D>)> {
        let samples = self.at_nodes.get(&row.node)?;
        let around = self.skin.around(row.node);
        if self.met.contains(&row.node) || !self.skin.sharp(row.node) {
            return Some((around.to_vec(), samples.first()?.clone()));
        }
        let normals = around
            .iter()
            .map(|&f| self.skin.mean_normal(&[f], row.node));
        let normals: Vec<[f64; D]> = normals.collect();
        let among = |some: usize| (0..around.len()).filter(move |k| some >> k & 1 == 1);
        let mut best = (f64::NEG_INFINITY, 0usize);
        for some in 1..1usize << around.len() {
            let fit = dot(unit(sum(among(some).map(|k| normals[k]))), row.normal);
            let more = some.count_ones() > best.1.count_ones();
            if fit > best.0 + 1e-9 || (fit > best.0 - 1e-9 && more) {
                best = (fit, some);
            }
        }
        let facets: Vec<usize> = among(best.1).map(|k| around[k]).collect();
        let sample = self.at_node(row.node, samples.first()?.x, &facets)?;
        Some((facets, sample))
    }

    fn find_mixed(&mut self) {
        let Some(_) = self.opposite.as_ref().filter(|_| !self.nodal) else {
            return;
        };
        let mut sheets: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for sample in &self.facing.between {
            for node in &self.skin.facets[sample.facet].nodes {
                sheets.entry(*node).or_default().insert(sample.sheet);
            }
        }
        let several = sheets.into_iter().filter(|(_, sheets)| sheets.len() > 1);
        self.mixed = several.map(|(node, _)| node).collect();
    }

    /// Samples at nodes and between them.
    pub fn samples(&self) -> impl Iterator<Item = &Sample<D>> {
        let at_nodes = self.at_nodes.values().flatten();
        self.facing.between.iter().chain(at_nodes)
    }

    /// The initial gap at a sample.
    pub fn clearance(&self, sample: &Sample<D>, t: f64) -> f64 {
        let measured = match &self.contact.gap {
            Gap::Given(gap) => return gap.at(sample.x, t),
            Gap::Closed => false,
            Gap::Geometric => true,
            Gap::Default => self.other.is_none() || !(self.nodal || self.contact.law == Law::Tied),
        };
        match &self.contact.against {
            Against::Obstacle {
                surface: Surface::Gap(gap),
                ..
            } => gap.at(sample.x, t),
            _ if measured => sample.distance,
            _ => 0.0,
        }
    }

    /// Displacement of the other side relative to the own one at a sample; `obstacle` is that of the obstacle.
    pub fn jump(
        &self,
        sample: &Sample<D>,
        moves: &[Vec<[f64; D]>],
        obstacle: [f64; D],
    ) -> [f64; D] {
        let mean = |body: usize, shape: &[(usize, f64)]| {
            sum(shape.iter().map(|&(n, v)| times(v, moves[body][n])))
        };
        let other = self
            .other
            .map_or(obstacle, |body| mean(body, &sample.other));
        minus(other, mean(self.own, &sample.own))
    }

    /// Displacement of the own side along the surface, relative to the rigid continuation of the other side.
    pub fn slip(
        &self,
        sample: &Sample<D>,
        moves: &[Vec<[f64; D]>],
        obstacle: [f64; D],
    ) -> [f64; D] {
        let jump = self.jump(sample, moves, obstacle);
        let (normal, lever) = &sample.lever;
        let turned = lever.iter().map(|&(node, slope)| {
            let moved = self.other.map_or(obstacle, |body| moves[body][node]);
            times(dot(*normal, moved), slope)
        });
        across(minus(sum(turned), jump), sample.normal)
    }

    /// The gap after deformation.
    pub fn gap(
        &self,
        sample: &Sample<D>,
        moves: &[Vec<[f64; D]>],
        obstacle: [f64; D],
        t: f64,
    ) -> f64 {
        self.clearance(sample, t) + dot(sample.normal, self.jump(sample, moves, obstacle))
    }

    /// Prescribed displacement of the obstacle; `None` where a force moves it.
    pub fn driven(&self, t: f64) -> Option<[f64; D]> {
        match &self.contact.against {
            Against::Obstacle {
                drive: Drive::Force(_),
                ..
            } => None,
            Against::Obstacle {
                drive: Drive::Displacement(field),
                ..
            } => Some(vector_at(field, [0.0; D], t)),
            _ => Some([0.0; D]),
        }
    }

    /// ∫N at the nodes of facets that face something with all their nodes: weights of conditions node by node.
    pub fn weights(&self, problem: &Problem<D>) -> BTreeMap<(usize, usize), f64> {
        let body = &problem.bodies[self.own];
        let mut weights = BTreeMap::new();
        for (index, facet) in self.skin.facets.iter().enumerate() {
            let counts = |node: &usize| match &self.opposite {
                Some(_) => self.partners.contains_key(node),
                None => {
                    let place = facet.place(*node);
                    self.met.contains(node) || place.is_some_and(|xi| self.faces(index, xi))
                }
            };
            if !facet.nodes.iter().all(counts) {
                continue;
            }
            for (xi, weight) in facet.rule() {
                let at = facet.at(xi);
                let area = weight * length(at.normal) * depth(body, problem.analysis, at.x);
                for (node, n) in at.shape_of(&facet.nodes) {
                    *weights.entry((node, index)).or_insert(0.0) += n * area;
                }
            }
        }
        weights
    }

    /// Points that face the other side with the contact normals there.
    pub fn facing_points(&self) -> Vec<([f64; D], [f64; D])> {
        if !self.facing.points.is_empty() || self.facing.area.is_some() {
            return self.facing.points.clone();
        }
        let samples = self.samples().map(|s| (s.x, s.normal));
        let corners = self
            .at_nodes
            .iter()
            .filter(|(node, _)| self.skin.sharp(**node));
        let faces = corners.flat_map(|(&node, samples)| {
            let around = self.skin.around(node).iter();
            let x = samples.first().map(|s| s.x);
            let all = around.filter_map(move |&f| self.at_node(node, x?, &[f]));
            all.map(|s| (s.x, s.normal))
        });
        samples.chain(faces).collect()
    }
}

/// Whether some of these normals are separated from the others by sharp edges only.
fn apart<const D: usize>(faces: &[[f64; D]]) -> bool {
    let mut reached = vec![false; faces.len()];
    for _ in faces {
        for k in 0..faces.len() {
            let near = |j: usize| reached[j] && dot(faces[j], faces[k]) > SHARP;
            reached[k] = reached[k] || k == 0 || (0..faces.len()).any(near);
        }
    }
    reached.contains(&false)
}

/// These facets, and all that share a node with one of them.
fn beside<const D: usize>(skin: &Skin<D>, facets: &BTreeSet<usize>) -> BTreeSet<usize> {
    let nodes = facets.iter().flat_map(|&f| &skin.facets[f].nodes);
    nodes.flat_map(|n| skin.around[n].iter().copied()).collect()
}
