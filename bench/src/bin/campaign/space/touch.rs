//! The geometry of a contact: points of the nonmortar side, the opposite points, and their distances.
//!
//! ```text
//!   gap(x) = g₀(x) + n·(u_other(y) − u_own(x)) ≥ 0,      y = x + s·n
//! ```
//!
//! linearised about the undeformed state, n the outward normal of the nonmortar side, against a plane obstacle minus the
//! plane's. g₀ is s between the meshes, or between the true surfaces behind them, or zero, or given.
//! Between two plane sides the polygons in which facets face each other are cut out exactly; else points are sampled.

use super::geometry::{Vector, cross, dot, length, mean, minus, plus, times, unit};
use super::problem::{Against, Contact, Drive, Form, Gap, Law, Problem};
use super::side::{At, Skin};
use super::{Answer, Mesh, Row};
use crate::amount::vector_at;
use crate::problem::Pairing;
use crate::raw;
use crate::side::SHARP;
use std::collections::{BTreeMap, BTreeSet};

/// Sampled points along an edge of a facet of a curved side.
const POINTS: usize = 5;

/// Two nodes coincide within this part of the facets there.
const COINCIDENT: f64 = 1e-6;

/// Sweeps over the faces of a corner: they meet at 30° and more, so that each leaves three quarters of an error at most.
const SWEEPS: usize = 200;

/// Polygons of a smaller part of their facet are rounding.
const SLIVER: f64 = 1e-9;

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
}

/// A part of a plane facet of the nonmortar side that faces one thing.
#[derive(Debug)]
pub struct Polygon {
    pub corners: Vec<Vector>,
    /// Contact normal there: plane facets that meet at sharp edges have one each.
    pub normal: Vector,
}

/// A contact, seen in the undeformed state.
#[derive(Debug)]
pub struct Touch<'a> {
    pub contact: &'a Contact,
    /// Body of the nonmortar side.
    pub own: usize,
    /// Body of the other side.
    pub other: Option<usize>,
    pub skin: Skin,
    pub opposite: Option<Skin>,
    /// Coincident nodes, or an obstacle at nodes: conditions hold node by node.
    pub nodal: bool,
    /// Coincident node of the other side.
    pub partners: BTreeMap<usize, usize>,
    /// All facets of both sides are plane with straight edges, and `polygons` are the parts of them that face the other side.
    pub exact: bool,
    pub polygons: Vec<Polygon>,
    /// Nodes with a facet that faces something.
    pub faced: BTreeSet<usize>,
    pub faced_other: BTreeSet<usize>,
    /// Samples at nodes of the nonmortar side.
    pub at_nodes: BTreeMap<usize, Sample>,
    /// Samples between the nodes.
    pub between: Vec<Sample>,
}

impl<'a> Touch<'a> {
    /// A contact between the meshes of an answer; the rows tell which side is the nonmortar one.
    pub fn new(
        problem: &'a Problem,
        contact: &'a Contact,
        answer: &Answer,
        raw: &raw::Contact<3>,
    ) -> Self {
        let (own, side) = (raw.nonmortar.0, &raw.nonmortar.1);
        let skin_of = |body: usize, side: &str| {
            let mut surfaces = problem.bodies[body].surfaces.iter();
            let surface = surfaces.find(|(name, _)| name == side).map(|s| s.1);
            Skin::new(&answer.meshes[body], side, surface)
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
        let mut touch = Self {
            contact,
            own,
            other: other.map(|(body, _)| body),
            skin: skin_of(own, side),
            opposite,
            nodal: false,
            partners: BTreeMap::new(),
            exact: false,
            polygons: Vec::new(),
            faced: BTreeSet::new(),
            faced_other: BTreeSet::new(),
            at_nodes: BTreeMap::new(),
            between: Vec::new(),
        };
        let flat = |skin: &Skin| skin.flat() && skin.straight;
        touch.exact = flat(&touch.skin)
            && match &contact.against {
                Against::Side { .. } => touch.opposite.as_ref().is_some_and(flat),
                Against::Obstacle { surface, .. } => surface.form == Form::Plane,
            };
        touch.find_partners(answer);
        let seen = touch.find_between();
        touch.decide_pairing(&seen);
        touch.find_at_nodes(&answer.meshes[own]);
        touch
    }

    /// Largest depth in the search for overlaps.
    fn deepest(&self) -> f64 {
        let other = self.opposite.as_ref().map_or(0.0, |c| c.longest);
        self.skin.longest.max(other)
    }

    fn find_partners(&mut self, answer: &Answer) {
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

    /// The sample of a point of a facet, and the opposite facet.
    fn look(&self, facet: usize, at: &At) -> Option<(Sample, Option<usize>)> {
        let n = self.skin.normal(facet, at);
        let nodes = self.skin.facets[facet].nodes.iter().copied();
        let mut sample = Sample {
            facet,
            x: at.x,
            normal: n,
            own: nodes.zip(at.shape.iter().copied()).collect(),
            other: Vec::new(),
            distance: 0.0,
        };
        if let Against::Obstacle {
            surface, inside, ..
        } = &self.contact.against
        {
            (sample.normal, sample.distance) = surface.opposite(*inside, at.x, n)?;
            return Some((sample, None));
        }
        let opposite = self.opposite.as_ref()?;
        let hit = opposite.hit(at.x, n, self.deepest())?;
        let other = &opposite.facets[hit.facet];
        let there = other.at(hit.xi);
        sample.distance =
            hit.distance + opposite.true_offset(there.x, n) - self.skin.true_offset(at.x, n);
        sample.other = other.nodes.iter().copied().zip(there.shape).collect();
        Some((sample, Some(hit.facet)))
    }

    /// Points that face something, between the nodes; the facets that face each other.
    fn find_between(&mut self) -> BTreeSet<(usize, Option<usize>)> {
        let mut seen = BTreeSet::new();
        let mut between = Vec::new();
        for (index, facet) in self.skin.facets.iter().enumerate() {
            if self.exact {
                let mut polygons: Vec<(Vec<Vector>, Option<usize>)> = Vec::new();
                match &self.opposite {
                    None => polygons.push((facet.corners().to_vec(), None)),
                    Some(opposite) => {
                        for (other, theirs) in opposite.facets.iter().enumerate() {
                            let cut = clipped(facet.corners(), theirs.corners());
                            polygons.push((cut, Some(other)));
                        }
                    }
                }
                let whole = area(facet.corners());
                for (polygon, other) in polygons {
                    if area(&polygon) < SLIVER * whole {
                        continue;
                    }
                    let centre = mean(&polygon);
                    let facing = self.inside(index, centre);
                    // another layer of facets, or one that looks away, lies there
                    let Some((facing, _)) = facing.filter(|(_, found)| *found == other) else {
                        continue;
                    };
                    for &corner in &polygon {
                        for part in [1.0 - 1e-6, 0.6] {
                            let x = plus(centre, part, minus(corner, centre));
                            between.extend(self.inside(index, x).map(|(sample, _)| sample));
                        }
                    }
                    between.extend(self.inside(index, centre).map(|(sample, _)| sample));
                    seen.insert((index, other));
                    self.polygons.push(Polygon {
                        corners: polygon,
                        normal: facing.normal,
                    });
                }
                continue;
            }
            for xi in lattice(facet.kind.triangle()) {
                if let Some((sample, other)) = self.look(index, &facet.at(xi)) {
                    between.push(sample);
                    seen.insert((index, other));
                }
            }
        }
        let mut near: BTreeSet<usize> = seen.iter().map(|s| s.0).collect();
        let mut near_other: BTreeSet<usize> = seen.iter().filter_map(|s| s.1).collect();
        if !self.exact {
            // facets that face the other side only between the sampled points lie beside them
            near = beside(&self.skin, &near);
            if let Some(opposite) = &self.opposite {
                near_other = beside(opposite, &near_other);
            }
        }
        let nodes = |skin: &Skin, facets: &BTreeSet<usize>| {
            let nodes = facets.iter().flat_map(|&f| skin.facets[f].nodes.clone());
            nodes.collect::<BTreeSet<usize>>()
        };
        self.faced = nodes(&self.skin, &near);
        if let Some(opposite) = &self.opposite {
            self.faced_other = nodes(opposite, &near_other);
        }
        self.between = between;
        seen
    }

    /// The sample of a point of the plane of a facet, inside the facet.
    fn inside(&self, facet: usize, x: Vector) -> Option<(Sample, Option<usize>)> {
        let own = &self.skin.facets[facet];
        let (xi, _) = own.hit(x, unit(doubled(own.corners())))?;
        self.look(facet, &own.at(xi))
    }

    /// Node by node where an obstacle is touched, or where all facets that face each other have the same nodes; weights of
    /// corners of tri6 and quad8 are not positive.
    fn decide_pairing(&mut self, seen: &BTreeSet<(usize, Option<usize>)>) {
        use crate::cells::Kind::{Quad8, Tri6};
        let positive = |facet: usize| {
            let kind = self.skin.facets[facet].kind;
            kind != Tri6 && kind != Quad8
        };
        let same = |&(own, other): &(usize, Option<usize>)| {
            let (Some(other), Some(opposite)) = (other, &self.opposite) else {
                return true;
            };
            let nodes = self.skin.facets[own].nodes.iter();
            let partners: Option<BTreeSet<usize>> =
                nodes.map(|n| self.partners.get(n).copied()).collect();
            let theirs = opposite.facets[other].nodes.iter().copied().collect();
            partners.is_some_and(|partners| partners == theirs)
        };
        self.nodal = self.contact.pairing != Pairing::Mortar
            && (0..self.skin.facets.len()).all(positive)
            && seen.iter().all(same);
    }

    fn find_at_nodes(&mut self, mesh: &Mesh) {
        let nodes: Vec<usize> = self.faced.iter().copied().collect();
        for node in nodes {
            let normal = self.skin.normal_at(node);
            let facets = &self.skin.around[&node];
            let sample = Sample {
                facet: facets[0],
                x: mesh.points[node],
                normal,
                own: vec![(node, 1.0)],
                other: Vec::new(),
                distance: 0.0,
            };
            let found = match (&self.opposite, &self.contact.against) {
                (Some(_), _) if self.nodal => self.partners.get(&node).map(|&partner| Sample {
                    other: vec![(partner, 1.0)],
                    ..sample
                }),
                (Some(_), _) => facets.iter().find_map(|&f| {
                    let at = self.skin.facets[f].at(self.skin.place(f, node)?);
                    self.look(f, &at).map(|(sample, _)| sample)
                }),
                (None, Against::Obstacle { .. }) => {
                    let met = self.met_at_corner(node, mesh.points[node]);
                    self.beyond(&sample, met.unwrap_or(normal))
                }
                _ => None,
            };
            self.at_nodes.extend(found.map(|sample| (node, sample)));
        }
    }

    /// The sample of a node against an obstacle, along a normal.
    fn beyond(&self, sample: &Sample, normal: Vector) -> Option<Sample> {
        let Against::Obstacle {
            surface, inside, ..
        } = &self.contact.against
        else {
            return None;
        };
        let found = surface.opposite(*inside, sample.x, normal);
        found.map(|(normal, distance)| Sample {
            normal,
            distance,
            ..sample.clone()
        })
    }

    /// The normals of the facets around a node at which some facets meet in a sharp edge; empty at other nodes.
    pub fn faces(&self, node: usize) -> Vec<Vector> {
        let faces: Vec<Vector> = self.skin.normals_at(node).collect();
        let sharp = |a: &Vector| faces.iter().any(|b| dot(*a, *b) <= SHARP);
        match faces.iter().any(sharp) {
            true => faces,
            false => Vec::new(),
        }
    }

    /// The direction along which a sharp corner meets a curved obstacle: the direction in the cone of the normals of its faces that is
    /// nearest to the shortest way to the obstacle. `None` if that is the normal of one face.
    fn met_at_corner(&self, node: usize, x: Vector) -> Option<Vector> {
        let Against::Obstacle {
            surface, inside, ..
        } = &self.contact.against
        else {
            return None;
        };
        let faces = self.faces(node);
        if self.contact.law == Law::Tied || surface.form == Form::Plane || !apart(&faces) {
            return None;
        }
        let way = times(if *inside { 1.0 } else { -1.0 }, surface.normal(x));
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

    /// The sample of a face at a node.
    fn of_face(&self, sample: &Sample, normal: Vector) -> Option<Sample> {
        match &self.contact.against {
            Against::Obstacle { .. } => self.beyond(sample, normal),
            Against::Side { .. } => Some(Sample {
                normal,
                ..sample.clone()
            }),
        }
    }

    /// The sample of a row. At a sharp corner the row belongs to some of the facets: those whose mean normal fits its own best.
    pub fn at_row(&self, row: &Row) -> Option<Sample> {
        let sample = self.at_nodes.get(&row.node)?;
        if self.met_at_corner(row.node, sample.x).is_some() {
            return Some(sample.clone());
        }
        let faces = self.faces(row.node);
        let some = (1..1usize << faces.len()).filter_map(|some| {
            let own = faces.iter().enumerate().filter(|(k, _)| some >> k & 1 == 1);
            let normal = own.fold([0.0; 3], |sum, (_, &n)| plus(sum, 1.0, n));
            self.of_face(sample, unit(normal))
        });
        let fit = |sample: &Sample| dot(sample.normal, row.normal);
        let best = some.max_by(|a, b| fit(a).total_cmp(&fit(b)));
        best.or_else(|| faces.is_empty().then(|| sample.clone()))
    }

    /// The initial gap at a sample.
    pub fn clearance(&self, sample: &Sample) -> f64 {
        let measured = match self.contact.gap {
            Gap::Given(gap) => return gap,
            Gap::Closed => false,
            Gap::Geometric => true,
            Gap::Default => self.other.is_none() || !(self.nodal || self.contact.law == Law::Tied),
        };
        if measured { sample.distance } else { 0.0 }
    }

    /// Displacement of the other side relative to the own one at a sample; `obstacle` is that of the obstacle.
    pub fn jump(&self, sample: &Sample, moves: &[Vec<Vector>], obstacle: Vector) -> Vector {
        let sum = |body: usize, shape: &[(usize, f64)]| {
            let nodes = shape.iter();
            nodes.fold([0.0; 3], |s, &(n, v)| plus(s, v, moves[body][n]))
        };
        let other = self.other.map_or(obstacle, |body| sum(body, &sample.other));
        minus(other, sum(self.own, &sample.own))
    }

    /// The gap after deformation.
    pub fn gap(&self, sample: &Sample, moves: &[Vec<Vector>], obstacle: Vector) -> f64 {
        self.clearance(sample) + dot(sample.normal, self.jump(sample, moves, obstacle))
    }

    /// Prescribed displacement of the obstacle; `None` where a force moves it.
    pub fn driven(&self, t: f64) -> Option<Vector> {
        match &self.contact.against {
            Against::Obstacle {
                drive: Some(Drive::Force(_)),
                ..
            } => None,
            Against::Obstacle {
                drive: Some(Drive::Displacement(field)),
                ..
            } => Some(vector_at(field, [0.0; 3], t)),
            _ => Some([0.0; 3]),
        }
    }

    /// ∫N at the nodes over the facets that face something with all their nodes: weights of conditions node by node.
    pub fn weights(&self) -> BTreeMap<usize, f64> {
        let mut weights = BTreeMap::new();
        for facet in &self.skin.facets {
            let counts = match &self.opposite {
                Some(_) => facet.nodes.iter().all(|n| self.partners.contains_key(n)),
                None => facet.nodes.iter().all(|n| self.at_nodes.contains_key(n)),
            };
            for (xi, weight) in facet.rule().into_iter().filter(|_| counts) {
                let at = facet.at(xi);
                for (&node, n) in facet.nodes.iter().zip(&at.shape) {
                    *weights.entry(node).or_insert(0.0) += n * weight * length(at.normal);
                }
            }
        }
        weights
    }

    /// Points that face the other side with the contact normals there; of plane facets the corners of the polygons, because pushes
    /// between these are sums of pushes at them.
    pub fn facing_points(&self) -> Vec<(Vector, Vector)> {
        if !self.exact {
            let faces = self.at_nodes.iter().flat_map(|(&node, sample)| {
                let faces = self.faces(node).into_iter();
                faces.filter_map(|normal| self.of_face(sample, normal))
            });
            let all = self.between.iter().chain(self.at_nodes.values());
            return all.cloned().chain(faces).map(|s| (s.x, s.normal)).collect();
        }
        let each = self.polygons.iter();
        each.flat_map(|p| p.corners.iter().map(|&x| (x, p.normal)))
            .collect()
    }
}

/// Whether some of these normals are separated from the others by sharp edges only.
fn apart(faces: &[Vector]) -> bool {
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
fn beside(skin: &Skin, facets: &BTreeSet<usize>) -> BTreeSet<usize> {
    let nodes = facets.iter().flat_map(|&f| &skin.facets[f].nodes);
    nodes.flat_map(|n| skin.around[n].iter().copied()).collect()
}

/// Reference coordinates of points all over a facet.
fn lattice(triangle: bool) -> Vec<[f64; 2]> {
    let step = |k: usize| (k as f64 + 0.5) / POINTS as f64;
    let all = (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| [step(i), step(j)]));
    all.map(|[a, b]| match triangle {
        // folded onto the triangle
        true => [a * (1.0 - b), b],
        false => [2.0 * a - 1.0, 2.0 * b - 1.0],
    })
    .collect()
}

/// Twice the area of a plane polygon, as a vector.
fn doubled(polygon: &[Vector]) -> Vector {
    let pairs = polygon.windows(2).skip(1);
    pairs.fold([0.0; 3], |s, p| {
        plus(
            s,
            1.0,
            cross(minus(p[0], polygon[0]), minus(p[1], polygon[0])),
        )
    })
}

/// The area of a plane polygon.
pub fn area(polygon: &[Vector]) -> f64 {
    0.5 * length(doubled(polygon))
}

/// The part of a convex plane polygon that lies behind another one, looked at along its normal.
fn clipped(own: &[Vector], other: &[Vector]) -> Vec<Vector> {
    let n = crate::vector::unit(doubled(own));
    let mut polygon = own.to_vec();
    let around = dot(doubled(other), n).signum();
    for (&a, &b) in other.iter().zip(other.iter().cycle().skip(1)) {
        // the plane through an edge of the other, along the normal; inside is where its normal points
        let inwards = times(around, cross(n, minus(b, a)));
        let height = |x: Vector| dot(inwards, minus(x, a));
        let mut cut = Vec::new();
        for (&p, &q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let (low, high) = (height(p), height(q));
            if low >= 0.0 {
                cut.push(p);
            }
            if (low < 0.0) != (high < 0.0) {
                cut.push(plus(p, low / (low - high), minus(q, p)));
            }
        }
        polygon = cut;
        if polygon.len() < 3 {
            return Vec::new();
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::geometry::tangents;

    #[test]
    fn polygons_are_cut_where_they_lie_behind_each_other() {
        let [u, v] = tangents([0.0, 0.6, 0.8]);
        let at = |x: f64, y: f64, z: f64| plus(plus(times(x, u), y, v), z, cross(u, v));
        let own = [at(0.0, 0.0, 0.0), at(2.0, 0.0, 0.0), at(0.0, 2.0, 0.0)];
        let other = [
            at(1.0, 3.0, 1.0),
            at(1.0, 0.5, 1.0),
            at(-1.0, 0.5, 2.0),
            at(-1.0, 3.0, 2.0),
        ];
        let cut = clipped(&own, &other);
        // 0 ≤ x ≤ 1, 0.5 ≤ y ≤ 2 − x
        assert!((area(&cut) - 1.0).abs() < 1e-14, "{}", area(&cut));
        assert!(clipped(&own, &other.map(|x| plus(x, 5.0, u))).is_empty());
    }
}
