//! The outer surface of a body as simplices, for any positions of its nodes: which points lie inside, and how deep.
//!
//! ```text
//!   φ(p) = ± min over the surface of ‖p − y‖,     negative inside
//! ```
//!
//! Where the nearest point is a corner or an edge, the sign is that of the simplices around it together: their normals, each
//! weighted with its angle there (J. A. Baerentzen, H. Aanaes, Signed distance computation using the angle weighted
//! pseudonormal, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243–253). Facets of second order are divided at their nodes.

use crate::geometry::{
    Groups, Point, add_scaled, bounding_box, cross, distance, dot, norm, sub, unit,
};
use crate::mesh::{CellKind, Mesh};
use rstar::{AABB, PointDistance, RTree, RTreeObject};
use std::collections::BTreeSet;

/// Simplices that are this near to a point, in parts of its distance and their size, meet there.
const MEETING: f64 = 1e-9;

/// Facets whose normals have a cosine below this, that of 30 degrees, meet at a corner, and do not approximate a curve there.
pub(crate) const SHARP: f64 = 0.866;

/// The outer surface of a mesh, divided into simplices of D corners.
#[derive(Debug, Clone)]
pub(crate) struct Skin<const D: usize> {
    /// Nodes of the simplices, which turn as facets do: outwards.
    simplices: Vec<[u32; D]>,
    /// Nodes of the surface, ascending.
    nodes: Vec<u32>,
    /// Data of each of these.
    at_nodes: Vec<AtNode>,
    /// The edges of the simplices, each once: the simplices themselves in the plane.
    edges: Vec<[u32; 2]>,
    /// Where two simplices meet: ends as those of `sharp`, and the two.
    ridges: Vec<([u32; 2], [usize; 2])>,
    /// Where simplices meet sharply: the ends of edges in space, twice the corner in the plane.
    sharp: Vec<[u32; 2]>,
    /// Where one simplex ends and no other begins, of an open surface: ends as those of `sharp`.
    open: Vec<[u32; 2]>,
}

/// The surface at one of its nodes.
#[derive(Debug, Clone, Default)]
struct AtNode {
    /// The nodes that share a simplex with it.
    beside: Vec<u32>,
    /// Distance of the simplices from the curve that they approximate.
    bow: Bow,
}

/// Distances of a surface from the curve that it approximates, lengths.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bow {
    /// On either side.
    pub off: f64,
    /// Beyond the surface, for a hollow curve: its chords lie outside of the body, where a neighbour may be; those of a round one
    /// lie inside.
    pub beyond: f64,
}

impl<const D: usize> Skin<D> {
    /// The skin of a mesh: its facets that belong to one cell only.
    pub fn of(mesh: &Mesh<D>) -> Self {
        let mut simplices = Vec::new();
        for facet in mesh.boundary_facets() {
            let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
            let parts = divided(mesh.facet_kind(facet)).iter();
            simplices.extend(parts.map(|part| std::array::from_fn(|k| nodes[part[k]])));
        }
        let mut nodes: Vec<u32> = simplices.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut skin = Self {
            simplices,
            at_nodes: vec![AtNode::default(); nodes.len()],
            nodes,
            edges: Vec::new(),
            ridges: Vec::new(),
            sharp: Vec::new(),
            open: Vec::new(),
        };
        skin.look_around(mesh.points());
        skin
    }

    /// Sets the data of the nodes. Two simplices that turn by θ approximate a curve from which they are up to hθ/8 off.
    fn look_around(&mut self, points: &[Point<D>]) {
        let mut ridges: Vec<([u32; 2], usize)> = Vec::new();
        for (index, simplex) in self.simplices.iter().enumerate() {
            for k in 0..D {
                // the corner of a segment, the edge of a triangle
                let ends = match D {
                    2 => [simplex[k], simplex[k]],
                    _ => [simplex[k], simplex[(k + 1) % D]],
                };
                ridges.push(([ends[0].min(ends[1]), ends[0].max(ends[1])], index));
            }
        }
        ridges.sort_unstable();
        let pairs = ridges.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        self.ridges = pairs.map(|p| (p[0].0, [p[0].1, p[1].1])).collect();
        let all = ridges.chunk_by(|a, b| a.0 == b.0);
        self.open = all
            .filter(|one| one.len() == 1)
            .map(|one| one[0].0)
            .collect();
        let turns = self.ridges.iter();
        let sharp = turns.filter(|(_, both)| self.cosine(*both, points) <= SHARP);
        self.sharp = sharp.map(|(ends, _)| *ends).collect();
        let bows = self.bows(points);
        for simplex in &self.simplices {
            for node in simplex {
                let place = self.place(*node);
                let others = simplex.iter().filter(|other| *other != node);
                self.at_nodes[place].beside.extend(others);
            }
        }
        for (at, bow) in self.at_nodes.iter_mut().zip(bows) {
            at.beside.sort_unstable();
            at.beside.dedup();
            at.bow = bow;
        }
        self.edges = match D {
            2 => self.simplices.iter().map(|s| [s[0], s[1]]).collect(),
            _ => ridges.into_iter().map(|(ends, _)| ends).collect(),
        };
        self.edges.dedup();
    }

    /// The cosine between the normals of two simplices, with the nodes at `points`.
    fn cosine(&self, both: [usize; 2], points: &[Point<D>]) -> f64 {
        let [a, b] = both.map(|index| self.simplex(index, points).normal());
        dot(a, b)
    }

    /// Distances of the surface at its nodes, in their order, from the curve that it approximates with the nodes of its mesh at
    /// `points`: that of the body, or of its displacement.
    pub fn bows(&self, points: &[Point<D>]) -> Vec<Bow> {
        let mut bows = vec![Bow::default(); self.nodes.len()];
        for (ends, both) in &self.ridges {
            let cosine = self.cosine(*both, points);
            if cosine > SHARP {
                let [a, b] = both.map(|index| self.simplex(index, points));
                let bow = a.size().max(b.size()) * cosine.min(1.0).acos() / 8.0;
                let hollow = dot(a.normal(), sub(b.middle(), a.middle())) > 0.0;
                for &node in ends {
                    let at = &mut bows[self.place(node)];
                    at.off = at.off.max(bow);
                    if hollow {
                        at.beyond = at.beyond.max(bow);
                    }
                }
            }
        }
        bows
    }

    /// The simplices at a node, or at an edge between two.
    pub fn around(&self, ends: [u32; 2]) -> impl Iterator<Item = &[u32; D]> {
        let holds = move |s: &&[u32; D]| ends.iter().all(|node| s.contains(node));
        self.simplices.iter().filter(holds)
    }

    /// Its edges: two nodes of each.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Whether a point is within `reach` of a sharp edge of the surface, with its nodes at `points`.
    pub fn is_sharp_at(&self, points: &[Point<D>], x: Point<D>, reach: f64) -> bool {
        let edges = self.sharp.iter();
        let mut edges = edges.map(|ends| ends.map(|node| points[node as usize]));
        edges.any(|edge| distance(x, on_segment(edge, x)) <= reach)
    }

    fn simplex(&self, index: usize, points: &[Point<D>]) -> Simplex<D> {
        let nodes = self.simplices[index];
        Simplex {
            corners: nodes.map(|node| points[node as usize]),
            nodes,
        }
    }

    /// The smooth continuation, without a sharp edge, of the simplices between some nodes, with the nodes of its mesh at `points`.
    pub fn going_on_from(&self, nodes: &BTreeSet<u32>, points: &[Point<D>]) -> Surrounding<D> {
        let mut groups = Groups::new(self.simplices.len());
        for (_, both) in &self.ridges {
            if self.cosine(*both, points) > SHARP {
                groups.join(both[0], both[1]);
            }
        }
        let between = |index: &usize| self.simplices[*index].iter().all(|n| nodes.contains(n));
        let all = 0..self.simplices.len();
        let from = all.clone().filter(between);
        let from: BTreeSet<usize> = from.map(|k| groups.first(k)).collect();
        let goes_on = all.filter(|&index| from.contains(&groups.first(index)));
        let simplices = goes_on.map(|index| self.simplex(index, points));
        Surrounding::of(simplices.collect())
    }

    /// The place of one of its nodes among them.
    pub fn place(&self, node: u32) -> usize {
        self.nodes.binary_search(&node).unwrap_or(0)
    }

    /// Its nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Distance of the surface at one of its nodes from the curve that it approximates.
    pub fn bow(&self, node: u32) -> Bow {
        self.at_nodes[self.place(node)].bow
    }

    /// Nodes that share a simplex with one of its nodes, ascending.
    pub fn beside(&self, node: u32) -> &[u32] {
        &self.at_nodes[self.place(node)].beside
    }

    /// The surface with the nodes of its mesh at some points (nodes,), as far as it meets a box.
    pub fn at(&self, points: &[Point<D>], (low, high): (Point<D>, Point<D>)) -> Surrounding<D> {
        let near = AABB::from_corners(low, high);
        let simplices = (0..self.simplices.len()).map(|index| self.simplex(index, points));
        let meets = |simplex: &Simplex<D>| rstar::Envelope::intersects(&simplex.envelope(), &near);
        let ends = self
            .open
            .iter()
            .map(|ends| ends.map(|node| points[node as usize]));
        Surrounding {
            ends: ends.collect(),
            ..Surrounding::of(simplices.filter(meets).collect())
        }
    }
}

/// Division of the facets of a kind into lines and triangles, by places of their nodes.
pub(crate) fn divided(kind: CellKind) -> &'static [[usize; 3]] {
    match kind {
        CellKind::Line2 => &[[0, 1, 1]],
        CellKind::Line3 => &[[0, 2, 2], [2, 1, 1]],
        CellKind::Tri3 => &[[0, 1, 2]],
        CellKind::Tri6 => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
        CellKind::Quad4 => &[[0, 1, 2], [0, 2, 3]],
        CellKind::Quad8 => &[
            [0, 4, 7],
            [4, 1, 5],
            [5, 2, 6],
            [6, 3, 7],
            [4, 5, 6],
            [4, 6, 7],
        ],
        CellKind::Quad9 => &[
            [0, 4, 8],
            [0, 8, 7],
            [4, 1, 5],
            [4, 5, 8],
            [8, 5, 2],
            [8, 2, 6],
            [7, 8, 6],
            [7, 6, 3],
        ],
        _ => &[],
    }
}

/// A part of a surface, somewhere.
#[derive(Debug)]
pub(crate) struct Surrounding<const D: usize> {
    simplices: RTree<Simplex<D>>,
    /// Where an open surface ends.
    ends: Vec<[Point<D>; 2]>,
}

impl<const D: usize> Surrounding<D> {
    fn of(simplices: Vec<Simplex<D>>) -> Self {
        Self {
            simplices: RTree::bulk_load(simplices),
            ends: Vec::new(),
        }
    }

    /// Whether a point of the surface lies on its end.
    fn is_end(&self, x: Point<D>) -> bool {
        self.ends.iter().any(|&edge| {
            let size = distance(edge[0], edge[1]) + norm(x);
            distance(x, on_segment(edge, x)) <= MEETING * size
        })
    }

    /// Depth of a point inside of the surface, negative outside and beyond the end of an open one; and the nodes of the nearest
    /// simplex. `None` if no part of the surface lies in the box.
    pub fn depth(&self, p: Point<D>) -> Option<(f64, [u32; D])> {
        let nearest = self.simplices.nearest_neighbor(p)?;
        let at = nearest.closest(p);
        let length = distance(p, at);
        let reach = length + MEETING * (length + nearest.size());
        let around = self.simplices.locate_within_distance(p, reach * reach);
        // their own nearest points are known to the root of rounding alone: they may part where the simplices meet
        let meets = |other: &&Simplex<D>| {
            distance(other.closest(at), at) <= MEETING * (nearest.size() + other.size())
        };
        let outward = around
            .filter(meets)
            .fold([0.0; D], |sum, s| add_scaled(sum, s.angle(at), s.normal()));
        let outside = dot(sub(p, at), outward) >= 0.0 || self.is_end(at);
        Some((if outside { -length } else { length }, nearest.nodes))
    }

    /// The point of the surface nearest to another one, and the normal of its simplex outwards; `None` for an empty surface.
    pub fn closest(&self, p: Point<D>) -> Option<(Point<D>, Point<D>)> {
        let nearest = self.simplices.nearest_neighbor(p)?;
        Some((nearest.closest(p), nearest.normal()))
    }

    /// The distance of a point from the surface; infinite for an empty surface.
    pub fn distance(&self, p: Point<D>) -> f64 {
        let nearest = self.simplices.nearest_neighbor(p);
        nearest.map_or(f64::INFINITY, |simplex| distance(p, simplex.closest(p)))
    }

    /// Crossings of the segment from one point to another with the surface, as parts of the segment, ascending.
    pub fn crossings(&self, way: [Point<D>; 2]) -> Vec<f64> {
        let (low, high) = bounding_box(&way);
        let near = AABB::from_corners(low, high);
        let near = self.simplices.locate_in_envelope_intersecting(near);
        let mut at: Vec<f64> = near.filter_map(|s| s.crossed(way)).collect();
        at.sort_unstable_by(f64::total_cmp);
        at
    }
}

/// A segment of the plane, a triangle of space.
#[derive(Debug)]
struct Simplex<const D: usize> {
    corners: [Point<D>; D],
    nodes: [u32; D],
}

impl<const D: usize> Simplex<D> {
    fn size(&self) -> f64 {
        let (low, high) = bounding_box(&self.corners);
        distance(low, high)
    }

    fn middle(&self) -> Point<D> {
        let share = 1.0 / D as f64;
        let corners = self.corners.iter();
        corners.fold([0.0; D], |sum, &c| add_scaled(sum, share, c))
    }

    /// Unit normal outwards; zero for a degenerate simplex.
    fn normal(&self) -> Point<D> {
        let c = &self.corners;
        let along = sub(c[1], c[0]);
        let normal: Point<D> = match D {
            2 => {
                let mut n = [0.0; D];
                (n[0], n[1]) = (along[1], -along[0]);
                n
            }
            _ => {
                let n = cross(along, sub(c[2], c[0]));
                std::array::from_fn(|i| n[i])
            }
        };
        unit(normal).unwrap_or([0.0; D])
    }

    /// The angle that it fills at one of its points, up to a factor that is the same for all that meet there: at a corner of a
    /// triangle its own, half a turn elsewhere.
    fn angle(&self, at: Point<D>) -> f64 {
        if D < 3 {
            return 1.0;
        }
        let c = &self.corners;
        let near = MEETING * self.size();
        let Some(k) = (0..D).find(|&k| distance(c[k], at) <= near) else {
            return std::f64::consts::PI;
        };
        let ends = [1, 2].map(|step| unit(sub(c[(k + step) % D], c[k])));
        match ends {
            [Some(a), Some(b)] => dot(a, b).clamp(-1.0, 1.0).acos(),
            _ => 0.0,
        }
    }

    /// Its crossing with the segment from a to b, as a part of that.
    fn crossed(&self, [a, b]: [Point<D>; 2]) -> Option<f64> {
        let normal = self.normal();
        let [from, to] = [a, b].map(|p| dot(sub(p, self.corners[0]), normal));
        if from * to >= 0.0 {
            return None;
        }
        let part = from / (from - to);
        let at = add_scaled(a, part, sub(b, a));
        (distance(at, self.closest(at)) <= MEETING * self.size()).then_some(part)
    }

    /// Its point that is nearest to p.
    fn closest(&self, p: Point<D>) -> Point<D> {
        let c = &self.corners;
        if D < 3 {
            return on_segment([c[0], c[1]], p);
        }
        let (a, b) = (sub(c[1], c[0]), sub(c[2], c[0]));
        let from = sub(p, c[0]);
        let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
        let (pa, pb) = (dot(from, a), dot(from, b));
        let det = aa * bb - ab * ab;
        let (s, t) = ((bb * pa - ab * pb) / det, (aa * pb - ab * pa) / det);
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
            return add_scaled(add_scaled(c[0], s, a), t, b);
        }
        let edges = [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]];
        let mut best = on_segment(edges[0], p);
        for edge in &edges[1..] {
            let other = on_segment(*edge, p);
            if distance(p, other) < distance(p, best) {
                best = other;
            }
        }
        best
    }
}

fn on_segment<const D: usize>([a, b]: [Point<D>; 2], p: Point<D>) -> Point<D> {
    let along = sub(b, a);
    let length = norm(along);
    if length == 0.0 {
        return a;
    }
    let part = dot(sub(p, a), along) / (length * length);
    match part {
        _ if part <= 0.0 => a,
        _ if part >= 1.0 => b,
        _ => add_scaled(a, part, along),
    }
}

impl<const D: usize> RTreeObject for Simplex<D> {
    type Envelope = AABB<Point<D>>;

    fn envelope(&self) -> Self::Envelope {
        let (low, high) = bounding_box(&self.corners);
        AABB::from_corners(low, high)
    }
}

impl<const D: usize> PointDistance for Simplex<D> {
    fn distance_2(&self, p: &Point<D>) -> f64 {
        let from = sub(*p, self.closest(*p));
        dot(from, from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Cuboid, Diagonals, Rectangle};

    const EVERYWHERE: f64 = 1e9;

    fn depths<const D: usize>(mesh: &Mesh<D>, points: &[(Point<D>, f64)]) {
        let whole = ([-EVERYWHERE; D], [EVERYWHERE; D]);
        let surface = Skin::of(mesh).at(mesh.points(), whole);
        for &(p, expected) in points {
            let (depth, _) = surface.depth(p).unwrap();
            assert!((depth - expected).abs() < 1e-14, "{p:?}: {depth}");
        }
    }

    #[test]
    fn points_of_the_plane_know_how_deep_they_are() {
        for cell in [CellKind::Tri3, CellKind::Quad4, CellKind::Quad8] {
            let block = Rectangle {
                from: [0.0, 0.0],
                to: [4.0, 2.0],
                cells: [4, 2],
                cell,
                diagonals: Diagonals::default(),
            };
            depths(
                &block.build().unwrap(),
                &[
                    ([1.0, 0.3], 0.3),
                    ([1.25, 1.9], 0.1),
                    ([2.0, 1.0], 1.0),
                    ([1.0, -0.3], -0.3),
                    // beyond a corner, and on its bisector inside
                    ([-3.0, -4.0], -5.0),
                    ([0.1, 0.1], 0.1),
                    ([5.0, 2.0], -1.0),
                ],
            );
        }
    }

    #[test]
    fn points_of_space_know_how_deep_they_are() {
        for cell in [
            CellKind::Tet4,
            CellKind::Hex8,
            CellKind::Hex20,
            CellKind::Hex27,
        ] {
            let block = Cuboid {
                from: [0.0; 3],
                to: [2.0, 2.0, 1.0],
                cells: [2, 2, 1],
                cell,
            };
            depths(
                &block.build().unwrap(),
                &[
                    ([1.0, 0.9, 0.2], 0.2),
                    ([0.1, 0.6, 0.5], 0.1),
                    ([0.3, 0.6, -0.5], -0.5),
                    ([-3.0, -4.0, 0.5], -5.0),
                    ([-1.0, -2.0, -2.0], -3.0),
                    ([0.1, 0.1, 0.1], 0.1),
                ],
            );
        }
    }

    #[test]
    fn a_point_above_a_corner_is_outside_whatever_rounding_does_to_the_sides_there() {
        // the sides at the corner (0, 0) lean by rounding: the points of both that are nearest to one far above it lie apart
        let places = (0..60).flat_map(|k| {
            let leans = [-1e-9, 0.0, 2.4e-9, 5e-9, 1e-8].into_iter();
            leans.flat_map(move |lean| {
                [-1e-9, 0.0, 2.5e-11, 1e-10, 1e-9].map(|x| (0.1 * f64::from(k), lean, x))
            })
        });
        for (angle, lean, x) in places {
            let (sine, cosine) = angle.sin_cos();
            let turned = |[x, y]: Point<2>| [cosine * x - sine * y, sine * x + cosine * y];
            let corners = [[0.0, -1.0], [1.0, -1.0], [1.0, lean], [0.0, 0.0]];
            let block = crate::mesh::CellBlock {
                kind: CellKind::Quad4,
                group: None,
                nodes: vec![0, 1, 2, 3],
            };
            let mesh = Mesh::new(corners.map(turned).to_vec(), vec![block]).unwrap();
            depths(&mesh, &[(turned([x, 0.75]), -0.75)]);
        }
    }

    #[test]
    fn a_notch_is_outside() {
        // an L of three squares: points in its corner are nearest to the vertex that points into it
        let points = [
            [0., 0.],
            [2., 0.],
            [2., 1.],
            [1., 1.],
            [1., 2.],
            [0., 2.],
            [0., 1.],
            [1., 0.],
        ];
        let block = crate::mesh::CellBlock {
            kind: CellKind::Quad4,
            group: None,
            nodes: vec![0, 7, 3, 6, 7, 1, 2, 3, 6, 3, 4, 5],
        };
        let mesh = Mesh::new(points.to_vec(), vec![block]).unwrap();
        let deep = 0.1 * 2f64.sqrt();
        depths(
            &mesh,
            &[([1.1, 1.3], -0.1), ([0.9, 0.9], deep), ([0.5, 0.5], 0.5)],
        );
    }
}
