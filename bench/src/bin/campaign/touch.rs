//! The geometry of a contact: points of the nonmortar side, the opposite points, and their distances.
//!
//! ```text
//!   gap(x) = g₀(x) + n·(u_other(y) − u_own(x)) ≥ 0,      y = x + s·n
//! ```
//!
//! linearised about the undeformed state, n the outward normal of the nonmortar side, against a plane obstacle minus the
//! plane's. g₀ is s between the meshes, or between the true circles behind them, or zero, or given.

use crate::cells::gauss;
use crate::elastic::depth;
use crate::plane::{Vector, cross, dot, length, minus, plus, times, turned};
use crate::problem::{Against, Contact, Drive, Gap, Law, Pairing, Problem, Surface};
use crate::raw::{self, Answer, Mesh};
use crate::side::{Curve, OPPOSED, on_circle};
use std::collections::{BTreeMap, BTreeSet};

/// Points of a facet, beside its nodes, at which gaps are looked at.
const POINTS: usize = 20;

/// Two nodes coincide within this part of the facets there.
const COINCIDENT: f64 = 1e-6;

/// A point of the nonmortar side and its opposite point.
#[derive(Debug, Clone)]
pub struct Sample {
    /// A facet that it lies on.
    pub facet: usize,
    pub x: Vector,
    /// Contact normal.
    pub normal: Vector,
    /// Shape functions of the own nodes.
    pub own: Vec<(usize, f64)>,
    /// Shape functions of the other side's nodes; empty against an obstacle.
    pub other: Vec<(usize, f64)>,
    /// Distance along the normal.
    distance: f64,
    /// Smooth part of the other side.
    pub sheet: usize,
    /// −s·ω of the opposite facet, as coefficients of its nodes' displacements: the tangential displacement due to the rigid
    /// continuation of the other side from y to x.
    lever: Vec<(usize, Vector)>,
}

impl Sample {
    fn new(facet: usize, x: Vector, own: Vec<(usize, f64)>, opposite: Opposite) -> Self {
        Self {
            facet,
            x,
            normal: opposite.normal,
            own,
            other: opposite.shape,
            distance: opposite.distance,
            sheet: opposite.sheet,
            lever: opposite.lever,
        }
    }
}

/// The opposite point of a point.
struct Opposite {
    /// Contact normal.
    normal: Vector,
    distance: f64,
    /// Smooth part of the other side.
    sheet: usize,
    /// Shape functions of the other side.
    shape: Vec<(usize, f64)>,
    lever: Vec<(usize, Vector)>,
}

/// A contact, seen in the undeformed state.
#[derive(Debug)]
pub struct Touch<'a> {
    pub contact: &'a Contact,
    /// Body of the nonmortar side.
    pub own: usize,
    /// Body of the other side.
    pub other: Option<usize>,
    pub curve: Curve,
    pub opposite: Option<Curve>,
    /// Coincident nodes, or an obstacle at nodes: conditions hold node by node.
    pub nodal: bool,
    /// Coincident node of the other side.
    pub partners: BTreeMap<usize, usize>,
    /// Parts of facets that face something.
    pub facing: Vec<(usize, [f64; 2])>,
    /// Nodes with a facet that faces something.
    pub faced: BTreeSet<usize>,
    pub faced_other: BTreeSet<usize>,
    /// Samples at nodes of the nonmortar side.
    pub at_nodes: BTreeMap<usize, Sample>,
    /// Nodes that meet an obstacle between the faces of a sharp corner.
    pub met: BTreeSet<usize>,
    /// Samples between the nodes.
    pub between: Vec<Sample>,
    /// Nodes at which the normal of a row disagrees with that of the side.
    pub wrong_normals: Vec<usize>,
}

impl<'a> Touch<'a> {
    /// A contact between the meshes of an answer; the rows tell which side is the nonmortar one.
    pub fn new(
        problem: &'a Problem,
        contact: &'a Contact,
        answer: &Answer,
        raw: &raw::Contact,
    ) -> Self {
        let (own, side) = (raw.nonmortar.0, &raw.nonmortar.1);
        let curve_of = |body: usize, side: &str| {
            Curve::new(&answer.meshes[body], side, &problem.bodies[body].circles)
        };
        let mut curve = curve_of(own, side);
        let other = match &contact.against {
            Against::Obstacle { .. } => None,
            Against::Side { side: second, .. } => {
                let first = &contact.own;
                let is_first = problem.bodies[own].name == first.body
                    && crate::corners::whole(side) == first.side;
                let mortar = if is_first { second } else { first };
                Some((problem.body(&mortar.body), mortar.side.clone()))
            }
        };
        let opposite = other.as_ref().map(|(body, side)| curve_of(*body, side));
        let mut wrong_normals = Vec::new();
        let plane = matches!(
            &contact.against,
            Against::Obstacle {
                surface: Surface::Plane { .. },
                ..
            }
        );
        if !plane && !curve.straight() {
            for row in &raw.rows {
                if !curve.believe_normal(row.node, row.normal) {
                    wrong_normals.push(row.node);
                }
            }
        }
        let mut touch = Self {
            contact,
            own,
            other: other.map(|(body, _)| body),
            curve,
            opposite,
            nodal: false,
            partners: BTreeMap::new(),
            facing: Vec::new(),
            faced: BTreeSet::new(),
            faced_other: BTreeSet::new(),
            at_nodes: BTreeMap::new(),
            met: BTreeSet::new(),
            between: Vec::new(),
            wrong_normals,
        };
        touch.find_partners(answer);
        touch.find_facing();
        touch.decide_pairing(problem);
        touch.find_samples(&answer.meshes[own], crate::corners::whole(side));
        touch
    }

    /// Largest depth in the search for overlaps: small for lists of sides, so that the search does not pass through a whole body from
    /// a flank that has sunk a little beside a corner.
    fn deepest(&self) -> f64 {
        let other = self.opposite.as_ref().map_or(0.0, |c| c.longest);
        let part = if self.contact.own.side.contains('+') {
            0.05
        } else {
            1.0
        };
        part * self.curve.longest.max(other)
    }

    fn find_partners(&mut self, answer: &Answer) {
        let (Some(other), Some(opposite)) = (self.other, &self.opposite) else {
            return;
        };
        let (mine, theirs) = (&answer.meshes[self.own], &answer.meshes[other]);
        for (&node, facets) in &self.curve.around {
            let lengths = facets.iter().map(|&f| self.curve.facets[f].length);
            let limit = COINCIDENT * lengths.fold(f64::INFINITY, f64::min);
            let x = mine.points[node];
            let near = |n: &&usize| length(minus(theirs.points[**n], x)) <= limit;
            if let Some(&partner) = opposite.around.keys().find(near) {
                self.partners.insert(node, partner);
            }
        }
    }

    /// The opposite point of ξ on a facet: contact normal, distance, and the other side's shape functions.
    fn opposite_at(&self, facet: usize, xi: f64) -> Option<Opposite> {
        let x = self.curve.facets[facet].point(xi);
        let n = self.curve.normal(facet, xi);
        match &self.contact.against {
            Against::Side { .. } => {
                let opposite = self.opposite.as_ref()?;
                let hit = opposite.hit(x, n, self.deepest())?;
                let y = plus(x, hit.distance, n);
                let distance =
                    hit.distance + opposite.true_offset(y, n) - self.curve.true_offset(x, n);
                let other = &opposite.facets[hit.facet];
                let turn = other.rotation(hit.xi);
                let lever = turn
                    .into_iter()
                    .map(|(node, c)| (node, times(-hit.distance, c)));
                Some(Opposite {
                    normal: n,
                    distance,
                    sheet: opposite.sheets[hit.facet],
                    shape: other.shape(hit.xi),
                    lever: lever.collect(),
                })
            }
            Against::Obstacle { surface, .. } => from_obstacle(surface, x, n),
        }
    }

    /// Cuts every facet where the opposite facet may change, and keeps the parts that face the other side.
    fn find_facing(&mut self) {
        let mut facing = Vec::new();
        for index in 0..self.curve.facets.len() {
            let mut cuts = self.cuts(index);
            cuts.sort_by(f64::total_cmp);
            cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            let parts: Vec<[f64; 2]> = cuts.windows(2).map(|c| [c[0], c[1]]).collect();
            let faces: Vec<bool> = parts
                .iter()
                .map(|c| self.opposite_at(index, 0.5 * (c[0] + c[1])).is_some())
                .collect();
            for (part, [from, to]) in parts.iter().enumerate().filter(|(p, _)| faces[*p]) {
                let (mut from, mut to) = (*from, *to);
                if part > 0 && !faces[part - 1] {
                    from = self.edge(index, 0.5 * (parts[part - 1][0] + from), 0.5 * (from + to));
                }
                if part + 1 < parts.len() && !faces[part + 1] {
                    to = self.edge(index, 0.5 * (to + parts[part + 1][1]), 0.5 * (from + to));
                }
                facing.push((index, [from, to]));
            }
        }
        for &(index, [from, to]) in &facing {
            self.faced.extend(&self.curve.facets[index].nodes);
            for part in [0.25, 0.5, 0.75] {
                if let Some(found) = self.opposite_at(index, from + part * (to - from)) {
                    self.faced_other
                        .extend(found.shape.iter().map(|(node, _)| node));
                }
            }
        }
        self.facing = facing;
    }

    /// Where lines along the normals meet ends of the other side's facets; ends and a few places between.
    fn cuts(&self, index: usize) -> Vec<f64> {
        let facet = &self.curve.facets[index];
        let even = (0..=8).map(|k| -1.0 + 0.25 * f64::from(k));
        let mut cuts: Vec<f64> = even.collect();
        let Some(opposite) = &self.opposite else {
            return cuts;
        };
        let ends = opposite
            .facets
            .iter()
            .flat_map(|f| [f.point(-1.0), f.point(1.0)]);
        for y in ends {
            let across = |xi: f64| cross(self.curve.normal(index, xi), minus(y, facet.point(xi)));
            let (mut low, mut high) = (-1.0, 1.0);
            let (at_low, at_high) = (across(low), across(high));
            if at_low * at_high >= 0.0 {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if (across(middle) < 0.0) == (at_low < 0.0) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            cuts.push(0.5 * (low + high));
        }
        cuts
    }

    /// Where facing begins between a place that does not face anything and one that does.
    fn edge(&self, index: usize, mut alone: f64, mut faces: f64) -> f64 {
        for _ in 0..50 {
            let middle = 0.5 * (alone + faces);
            if self.opposite_at(index, middle).is_some() {
                faces = middle;
            } else {
                alone = middle;
            }
        }
        faces
    }

    /// Node by node where an obstacle is touched, or where all nodes of all facets that face the other side coincide.
    fn decide_pairing(&mut self, problem: &Problem) {
        if self.contact.pairing == Pairing::Mortar {
            return;
        }
        // a quadratic facet that ends on the axis of revolution has no weight there
        let on_axis = problem.analysis.axisymmetric()
            && self.curve.facets.iter().any(|f| {
                f.nodes.len() == 3
                    && (f.point(-1.0)[0].abs() < 1e-9 || f.point(1.0)[0].abs() < 1e-9)
            });
        let Some(opposite) = &self.opposite else {
            self.nodal = !on_axis;
            return;
        };
        let paired: BTreeSet<usize> = self.partners.values().copied().collect();
        let own = self.facing.iter().all(|&(index, _)| {
            let nodes = &self.curve.facets[index].nodes;
            nodes.iter().all(|n| self.partners.contains_key(n))
        });
        let others = opposite.facets.iter().filter(|f| {
            // facets whose middle is opposite something
            let ends = [f.nodes[0], f.nodes[1]];
            ends.iter().all(|n| self.faced_other.contains(n))
        });
        let theirs = others
            .into_iter()
            .all(|f| f.nodes.iter().all(|n| paired.contains(n)));
        // a quadratic facet over two linear ones has their nodes without being one of them
        let known: BTreeSet<BTreeSet<usize>> = opposite
            .facets
            .iter()
            .map(|f| f.nodes.iter().copied().collect())
            .collect();
        let alike = self.facing.iter().all(|&(index, _)| {
            let nodes = self.curve.facets[index].nodes.iter();
            let partners: Option<BTreeSet<usize>> =
                nodes.map(|n| self.partners.get(n).copied()).collect();
            partners.is_some_and(|nodes| known.contains(&nodes))
        });
        self.nodal = own && theirs && alike && !on_axis;
    }

    fn find_samples(&mut self, mesh: &Mesh, whole: &str) {
        let nodes: Vec<usize> = self.curve.around.keys().copied().collect();
        for node in nodes {
            let side = &mesh.sides[whole];
            let met = crate::corners::met(self.contact, mesh, side, node);
            if !self.faced.contains(&node) && met.is_none() {
                continue;
            }
            let normal = self.curve.normal_at(node);
            let x = mesh.points[node];
            let facet = self.curve.around[&node][0];
            let found = match (&self.opposite, &self.contact.against) {
                (Some(_), _) if self.nodal => self.partners.get(&node).map(|&partner| {
                    let opposite = Opposite {
                        normal,
                        distance: 0.0,
                        sheet: 0,
                        shape: vec![(partner, 1.0)],
                        lever: Vec::new(),
                    };
                    (facet, opposite)
                }),
                (Some(_), _) => self.curve.around[&node].iter().find_map(|&f| {
                    let place = self.curve.facets[f].nodes.iter().position(|&n| n == node)?;
                    Some((f, self.opposite_at(f, [-1.0, 1.0, 0.0][place])?))
                }),
                (None, Against::Obstacle { surface, .. }) => {
                    self.met.extend(met.map(|_| node));
                    let towards = met.unwrap_or(normal);
                    from_obstacle(surface, x, towards).map(|opposite| (facet, opposite))
                }
                _ => None,
            };
            if let Some((facet, opposite)) = found {
                let own = vec![(node, 1.0)];
                self.at_nodes
                    .insert(node, Sample::new(facet, x, own, opposite));
            }
        }
        for (index, facet) in self.curve.facets.iter().enumerate() {
            for k in 0..POINTS {
                let xi = -1.0 + 2.0 * (k as f64 + 0.5) / POINTS as f64;
                if let Some(opposite) = self.opposite_at(index, xi) {
                    let (x, own) = (facet.point(xi), facet.shape(xi));
                    self.between.push(Sample::new(index, x, own, opposite));
                }
            }
        }
    }

    /// The facets around a node face several smooth parts of the other side, each with a condition of its own: no condition belongs to
    /// the opposite point of the node alone.
    pub fn mixed(&self, node: usize) -> bool {
        let around = self.curve.around.get(&node);
        let around: Vec<usize> = around.into_iter().flatten().copied().collect();
        let samples = self.between.iter().filter(|s| around.contains(&s.facet));
        let mut sheets: Vec<usize> = samples.map(|s| s.sheet).collect();
        sheets.sort_unstable();
        sheets.dedup();
        !self.nodal && self.opposite.is_some() && sheets.len() > 1
    }

    /// The distance between the sides in the meshes.
    pub fn drawn(&self, sample: &Sample) -> f64 {
        sample.distance
    }

    /// The initial gap at a sample.
    pub fn clearance(&self, sample: &Sample, t: f64) -> f64 {
        let measured = match &self.contact.gap {
            Gap::Given(gap) => return gap.at(sample.x, t),
            Gap::Closed => false,
            Gap::Geometric => true,
            Gap::Default => {
                self.other.is_none() || !(self.nodal || matches!(self.contact.law, Law::Tied))
            }
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
    pub fn jump(&self, sample: &Sample, moves: &[Vec<Vector>], obstacle: Vector) -> Vector {
        let sum = |body: usize, shape: &[(usize, f64)]| {
            shape
                .iter()
                .fold([0.0; 2], |s, &(n, v)| plus(s, v, moves[body][n]))
        };
        let other = self.other.map_or(obstacle, |body| sum(body, &sample.other));
        minus(other, sum(self.own, &sample.own))
    }

    /// Displacement of the own side along the tangent, relative to the rigid continuation of the other side.
    pub fn slip(&self, sample: &Sample, moves: &[Vec<Vector>], obstacle: Vector) -> f64 {
        let along = dot(turned(sample.normal), self.jump(sample, moves, obstacle));
        let turn =
            |&(node, c): &(usize, Vector)| self.other.map_or(0.0, |b| dot(c, moves[b][node]));
        -along - sample.lever.iter().map(turn).sum::<f64>()
    }

    /// The gap after deformation.
    pub fn gap(&self, sample: &Sample, moves: &[Vec<Vector>], obstacle: Vector, t: f64) -> f64 {
        self.clearance(sample, t) + dot(sample.normal, self.jump(sample, moves, obstacle))
    }

    /// Prescribed displacement of the obstacle; `None` where a force moves it.
    pub fn driven(&self, t: f64) -> Option<Vector> {
        match &self.contact.against {
            Against::Obstacle {
                drive: Drive::Force(_),
                ..
            } => None,
            Against::Obstacle {
                drive: Drive::Displacement(field),
                ..
            } => Some(crate::amount::vector_at(field, [0.0; 2], t)),
            _ => Some([0.0; 2]),
        }
    }

    /// ∫N at the nodes over the facets that face something with all their nodes: weights of conditions node by node.
    pub fn weights(&self, problem: &Problem) -> BTreeMap<usize, f64> {
        let body = &problem.bodies[self.own];
        let mut weights = BTreeMap::new();
        for (index, facet) in self.curve.facets.iter().enumerate() {
            let counts = match &self.opposite {
                Some(_) => facet.nodes.iter().all(|n| self.partners.contains_key(n)),
                None => [-1.0, 1.0].iter().zip(&facet.nodes).all(|(&xi, node)| {
                    self.met.contains(node) || self.opposite_at(index, xi).is_some()
                }),
            };
            if !counts {
                continue;
            }
            for (xi, weight) in gauss(6) {
                let area = weight
                    * length(facet.tangent(xi))
                    * depth(body, problem.analysis, facet.point(xi));
                for (node, n) in facet.shape(xi) {
                    *weights.entry(node).or_insert(0.0) += n * area;
                }
            }
        }
        weights
    }

    /// Area of the side that faces something.
    pub fn facing_area(&self, problem: &Problem) -> f64 {
        let body = &problem.bodies[self.own];
        let mut area = 0.0;
        for &(index, [from, to]) in &self.facing {
            let facet = &self.curve.facets[index];
            for (x, weight) in gauss(5) {
                let xi = 0.5 * (from + to) + 0.5 * (to - from) * x;
                let stretch = 0.5 * (to - from) * length(facet.tangent(xi));
                area += weight * stretch * depth(body, problem.analysis, facet.point(xi));
            }
        }
        area
    }
}

/// Whether a point with this outward normal faces an obstacle.
pub fn faces_obstacle(surface: &Surface, x: Vector, n: Vector) -> bool {
    from_obstacle(surface, x, n).is_some()
}

/// Contact normal and distance of an obstacle's surface from a point with this outward normal.
fn from_obstacle(surface: &Surface, x: Vector, n: Vector) -> Option<Opposite> {
    let (normal, distance) = match surface {
        Surface::Gap(_) => Some((n, 0.0)),
        Surface::Plane { point, normal } => (dot(n, *normal) < OPPOSED)
            .then(|| (times(-1.0, *normal), dot(minus(x, *point), *normal))),
        Surface::Circle {
            center,
            radius,
            inside,
        } => {
            let faces = |s: &f64| {
                let outward = crate::plane::unit(minus(plus(x, *s, n), *center));
                let towards_body = if *inside {
                    times(-1.0, outward)
                } else {
                    outward
                };
                dot(towards_body, n) < OPPOSED
            };
            // a point away from the obstacle has none of its surface behind it
            let clear = (length(minus(x, *center)) - radius) * if *inside { -1.0 } else { 1.0 };
            let ahead = |s: &f64| *s >= 0.0 || clear < 1e-12 * radius;
            let hits = on_circle(x, n, *center, *radius)?;
            let facing = hits.into_iter().filter(ahead).filter(faces);
            let nearest = facing.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
            Some((n, nearest))
        }
    }?;
    Some(Opposite {
        normal,
        distance,
        sheet: 0,
        shape: Vec::new(),
        lever: Vec::new(),
    })
}

impl Touch<'_> {
    /// Points that face the other side, ends of the facing parts included, with contact normals.
    pub fn facing_points(&self) -> Vec<(Vector, Vector)> {
        let mut points = Vec::new();
        for &(index, [from, to]) in &self.facing {
            for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let inside = from + (0.5 + (part - 0.5) * (1.0 - 1e-9)) * (to - from);
                if let Some(Opposite { normal, .. }) = self.opposite_at(index, inside) {
                    points.push((
                        self.curve.facets[index].point(from + part * (to - from)),
                        normal,
                    ));
                }
            }
        }
        points
    }
}
