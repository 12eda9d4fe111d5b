//! Triangles inside a divided boundary, of a wanted size and as regular as the boundary permits.
//!
//! 1. The constrained Delaunay triangulation of the boundary nodes; its pieces are never divided.
//! 2. A front: beside an edge that has a good triangle on its other side, or belongs to the boundary, a node is put on the
//!    perpendicular bisector so that the new triangle has the wanted circumradius h/√3, but not beyond the present
//!    circumcentre (S. Rebay, J. Comput. Phys. 106 (1993) 125-138, as described in the documentation of Gmsh).
//! 3. Circumcentres of triangles with an angle below 30° (as described by J. R. Shewchuk, Comput. Geom. 22 (2002) 21-74);
//!    where one would come too near to a piece of the boundary, the triangle stays.
//! 4. Nodes move towards the weighted centroid of their triangles where that does not worsen the worst angle around
//!    them, and the triangulation is made anew: both steps can only raise the smallest angle.
//!
//! 5. For a mesh that is made anew with a size field: edges longer than 1.4·h in the middle of their triangle get a node in their
//!    middle. There are few, where nodes came too near to others or to the boundary.
//!
//! h at a new node is the smallest h_v + g·|x − v| over the nodes v of the triangles that it replaces, which starts from the
//! boundary. Everything is sequential and in a fixed order: same input, same bits. The triangulation decides orientations
//! exactly; it works on coordinates scaled by a power of two, which changes no digit.

use crate::geometry::{Point, add_scaled, distance, dot, sub};
use crate::mesh::outline::curve::cross;
use crate::mesh::outline::divide::Sizes;
use spade::handles::{FixedDirectedEdgeHandle, FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, Point2, PositionInTriangulation, Triangulation,
};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A triangle is large when its circumradius exceeds that of the equilateral one by this factor.
const LARGE: f64 = 1.2;

/// Longest edge within a face over the size in the middle of a triangle beside it, where sizes are binding.
const LONGEST: f64 = 1.4;

/// Rounds of moving nodes; later ones change little.
const ROUNDS: usize = 4;

/// Coordinates below this are zero to the triangulation, which refuses them.
const TINY: f64 = 1e-40;

/// Why the filling failed; indices of pieces.
pub(crate) enum Unfilled {
    /// Two pieces cross, or a node of one lies on the other.
    Meet(usize, usize),
    /// More nodes than wanted.
    TooMany,
}

/// Boundary to be filled: nodes, pieces with the body on the left, wanted size at each node, most nodes in all.
pub(crate) struct Boundary {
    pub nodes: Vec<Point<2>>,
    pub pieces: Vec<[u32; 2]>,
    pub sizes: Vec<f64>,
    pub most: usize,
}

/// Nodes, those of the boundary first and as given, and triangles, counter-clockwise.
pub(crate) struct Filled {
    pub nodes: Vec<Point<2>>,
    pub triangles: Vec<[u32; 3]>,
}

/// Fills a boundary.
pub(crate) fn fill(boundary: &Boundary, sizes: &Sizes<'_>) -> Result<Filled, Unfilled> {
    let mut fill = Fill::new(
        boundary,
        sizes,
        boundary.nodes.clone(),
        boundary.sizes.clone(),
    )?;
    fill.advance()?;
    fill.improve()?;
    for _ in 0..ROUNDS {
        let (mut nodes, triangles) = fill.triangles();
        smooth(&mut nodes, &triangles, &fill.sizes, boundary.nodes.len());
        let wanted = std::mem::take(&mut fill.sizes);
        fill = Fill::new(boundary, sizes, nodes, wanted)?;
    }
    if sizes.binding {
        fill.shorten()?;
    }
    let (nodes, triangles) = fill.triangles();
    Ok(Filled { nodes, triangles })
}

/// A node of the triangulation.
#[derive(Clone, Copy)]
struct Vertex {
    position: Point2<f64>,
    node: u32,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

type Face = FixedFaceHandle<InnerTag>;

struct Fill<'a> {
    boundary: &'a Boundary,
    field: &'a Sizes<'a>,
    triangulation: ConstrainedDelaunayTriangulation<Vertex>,
    /// Triangulation coordinates over real ones.
    scale: f64,
    nodes: Vec<Point<2>>,
    sizes: Vec<f64>,
    /// By the index of a face: is it in the body, how often was it changed.
    inside: Vec<bool>,
    version: Vec<u32>,
    /// Circumradius over that of the equilateral triangle of the wanted size; zero where it stays as it is.
    largeness: Vec<f64>,
}

/// A triangle that waits, the worst first, ties by index.
#[derive(PartialEq)]
struct Waiting {
    badness: f64,
    face: Face,
    version: u32,
}

impl Eq for Waiting {}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_badness = self.badness.total_cmp(&other.badness);
        by_badness
            .then(other.face.index().cmp(&self.face.index()))
            .then(self.version.cmp(&other.version))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The cavity of a new node.
struct Cavity {
    /// Wanted size there.
    size: f64,
    /// A piece of the boundary subtends more than 90° at the node.
    encroaches: bool,
    /// Distance to the nearest node around.
    clearance: f64,
}

impl<'a> Fill<'a> {
    /// The constrained triangulation of all nodes.
    fn new(
        boundary: &'a Boundary,
        field: &'a Sizes<'a>,
        nodes: Vec<Point<2>>,
        sizes: Vec<f64>,
    ) -> Result<Self, Unfilled> {
        let largest = nodes.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
        let mut fill = Self {
            boundary,
            field,
            triangulation: ConstrainedDelaunayTriangulation::new(),
            scale: (-largest.log2().floor()).exp2(),
            nodes,
            sizes,
            inside: Vec::new(),
            version: Vec::new(),
            largeness: Vec::new(),
        };
        let handles = fill.insert_all()?;
        let inner = fill.insert_pieces(&handles)?;
        fill.mark_inside(inner);
        Ok(fill)
    }

    fn scaled(&self, p: Point<2>) -> Point2<f64> {
        let [x, y] = p.map(|c| {
            if (c * self.scale).abs() < TINY {
                0.0
            } else {
                c * self.scale
            }
        });
        Point2::new(x, y)
    }

    fn insert_all(&mut self) -> Result<Vec<FixedVertexHandle>, Unfilled> {
        let mut handles = vec![FixedVertexHandle::from_index(0); self.nodes.len()];
        let mut hint = None;
        for node in insertion_order(&self.nodes) {
            let position = self.scaled(self.nodes[node]);
            let before = self.triangulation.num_vertices();
            let vertex = Vertex {
                position,
                node: node as u32,
            };
            let inserted = match hint {
                Some(hint) => self.triangulation.insert_with_hint(vertex, hint),
                None => self.triangulation.insert(vertex),
            };
            let handle = inserted.map_err(|_| Unfilled::TooMany)?;
            if self.triangulation.num_vertices() == before {
                // The vertex took over the number of this node: two nodes at one place.
                let place = handles.iter().position(|&h| h == handle).unwrap_or(node);
                let from = |node: usize| {
                    let mut pieces = self.boundary.pieces.iter();
                    pieces.position(|piece| piece[0] as usize == node)
                };
                let [here, there] = [place, node].map(|node| from(node).unwrap_or(node));
                return Err(Unfilled::Meet(here, there));
            }
            handles[node] = handle;
            hint = Some(handle);
        }
        Ok(handles)
    }

    /// Makes the pieces edges of the triangulation; returns the edges with the body on the left.
    fn insert_pieces(
        &mut self,
        handles: &[FixedVertexHandle],
    ) -> Result<Vec<FixedDirectedEdgeHandle>, Unfilled> {
        let ends = |piece: [u32; 2]| piece.map(|node| handles[node as usize]);
        for (index, &piece) in self.boundary.pieces.iter().enumerate() {
            let [from, to] = ends(piece);
            let added = self.triangulation.try_add_constraint(from, to);
            if added.len() != 1 || !self.triangulation.exists_constraint(from, to) {
                let across = self
                    .triangulation
                    .get_conflicting_edges_between_vertices(from, to)
                    .next();
                let met = across.map(|edge| edge.vertices().map(|v| v.data().node));
                let is_met = |p: &[u32; 2]| met.is_some_and(|m| *p == m || *p == [m[1], m[0]]);
                let other = self.boundary.pieces.iter().position(is_met);
                return Err(Unfilled::Meet(index, other.unwrap_or(index)));
            }
        }
        let pieces = self.boundary.pieces.iter();
        let edges = pieces.filter_map(|&piece| {
            let [from, to] = ends(piece);
            let edge = self.triangulation.get_edge_from_neighbors(from, to)?;
            Some(edge.fix())
        });
        Ok(edges.collect())
    }

    /// All faces reached from the left of the pieces without crossing one.
    fn mark_inside(&mut self, pieces: Vec<FixedDirectedEdgeHandle>) {
        let faces = self.triangulation.num_all_faces();
        self.inside = vec![false; faces];
        self.version = vec![0; faces];
        self.largeness = vec![0.0; faces];
        let mut waiting = pieces;
        while let Some(edge) = waiting.pop() {
            let edge = self.triangulation.directed_edge(edge);
            let Some(face) = edge.face().as_inner() else {
                continue;
            };
            if std::mem::replace(&mut self.inside[face.index()], true) {
                continue;
            }
            let around = face.adjacent_edges();
            let open = around.iter().filter(|e| !e.is_constraint_edge());
            waiting.extend(open.map(|e| e.rev().fix()));
            let face = face.fix();
            self.largeness[face.index()] = self.measured(face);
        }
    }

    fn corners(&self, face: Face) -> [u32; 3] {
        let face = self.triangulation.face(face);
        face.vertices().map(|v| v.data().node)
    }

    fn places(&self, face: Face) -> [Point<2>; 3] {
        self.corners(face).map(|node| self.nodes[node as usize])
    }

    fn measured(&self, face: Face) -> f64 {
        let places = self.places(face);
        let (_, radius) = circumcircle(places);
        radius * 3.0_f64.sqrt() / self.wanted(face, places)
    }

    fn wanted(&self, face: Face, places: [Point<2>; 3]) -> f64 {
        let mean = self.corners(face).map(|node| self.sizes[node as usize]);
        (mean.iter().sum::<f64>() / 3.0).min(self.field.near(centroid_of(places)))
    }

    fn is_done(&self, face: Face) -> bool {
        self.largeness[face.index()] <= LARGE
    }

    /// The shortest edge of a large triangle beside which the front stands.
    fn front(&self, face: Face) -> Option<FixedDirectedEdgeHandle> {
        let face = self.triangulation.face(face);
        let fronts =
            face.adjacent_edges().into_iter().filter(|edge| {
                edge.is_constraint_edge()
                    || edge.rev().face().as_inner().is_none_or(|other| {
                        !self.inside[other.index()] || self.is_done(other.fix())
                    })
            });
        fronts
            .min_by(|a, b| a.length_2().total_cmp(&b.length_2()))
            .map(|edge| edge.fix())
    }

    /// Puts nodes until no triangle is large.
    fn advance(&mut self) -> Result<(), Unfilled> {
        let mut heap = BinaryHeap::new();
        for face in self.triangulation.fixed_inner_faces() {
            self.offer_large(face, &mut heap);
        }
        while let Some(waiting) = heap.pop() {
            let face = waiting.face;
            if self.version[face.index()] != waiting.version || self.is_done(face) {
                continue;
            }
            let Some(edge) = self.front(face) else {
                // Its turn comes when a neighbour is done.
                continue;
            };
            let place = self.beside(face, edge);
            let accepted = self
                .cavity(face, place)
                .filter(|cavity| !cavity.encroaches && cavity.clearance > 0.5 * cavity.size);
            let changed = match accepted {
                Some(cavity) => self.insert(face, place, cavity.size)?,
                None => {
                    self.largeness[face.index()] = 0.0;
                    vec![face]
                }
            };
            for face in changed {
                self.offer_large(face, &mut heap);
                if self.is_done(face) {
                    for other in self.neighbours(face) {
                        self.offer_large(other, &mut heap);
                    }
                }
            }
        }
        Ok(())
    }

    fn offer_large(&self, face: Face, heap: &mut BinaryHeap<Waiting>) {
        let index = face.index();
        if self.inside[index] && !self.is_done(face) && self.front(face).is_some() {
            heap.push(Waiting {
                badness: self.largeness[index],
                face,
                version: self.version[index],
            });
        }
    }

    fn neighbours(&self, face: Face) -> Vec<Face> {
        let face = self.triangulation.face(face);
        let around = face.adjacent_edges().into_iter();
        let open = around.filter(|edge| !edge.is_constraint_edge());
        open.filter_map(|edge| Some(edge.rev().face().as_inner()?.fix()))
            .collect()
    }

    /// The place beside an edge of a triangle where the wanted circumradius is met.
    fn beside(&self, face: Face, edge: FixedDirectedEdgeHandle) -> Point<2> {
        let places = self.places(face);
        let edge = self.triangulation.directed_edge(edge);
        let [a, b] = edge.vertices().map(|v| self.nodes[v.data().node as usize]);
        let along = sub(b, a);
        let middle = add_scaled(a, 0.5, along);
        let half = 0.5 * distance(a, b);
        let normal = [-along[1], along[0]].map(|c| c / (2.0 * half));
        let (center, _) = circumcircle(places);
        let depth = dot(sub(center, middle), normal);
        if depth <= 0.0 {
            // The centre lies beyond this edge: the centroid is inside.
            return centroid_of(places);
        }
        let wanted = self.wanted(face, places) / 3.0_f64.sqrt();
        let radius = wanted
            .max(half)
            .min((half * half + depth * depth) / (2.0 * depth));
        let height = radius + (radius * radius - half * half).max(0.0).sqrt();
        add_scaled(middle, height, normal)
    }

    /// The cavity of a node at a place near a triangle; `None` where a node is impossible.
    fn cavity(&self, near: Face, place: Point<2>) -> Option<Cavity> {
        if !place.iter().all(|c| c.is_finite()) {
            // The circumcentre of a triangle that is flat to rounding.
            return None;
        }
        let hint = self.triangulation.face(near).vertices()[0].fix();
        let first = match self
            .triangulation
            .locate_with_hint(self.scaled(place), hint)
        {
            PositionInTriangulation::OnFace(face) => face,
            PositionInTriangulation::OnEdge(edge) => {
                let edge = self.triangulation.directed_edge(edge);
                if edge.is_constraint_edge() {
                    return None;
                }
                edge.face().as_inner()?.fix()
            }
            _ => return None,
        };
        if !self.inside[first.index()] {
            return None;
        }
        let mut cavity = Cavity {
            size: self.field.near(place),
            encroaches: false,
            clearance: f64::INFINITY,
        };
        let mut found = vec![first];
        let mut next = 0;
        while let Some(&face) = found.get(next) {
            next += 1;
            for node in self.corners(face) {
                let away = distance(self.nodes[node as usize], place);
                let allowed = self.sizes[node as usize] + self.field.growth * away;
                cavity.size = cavity.size.min(allowed);
                cavity.clearance = cavity.clearance.min(away);
            }
            for edge in self.triangulation.face(face).adjacent_edges() {
                if edge.is_constraint_edge() {
                    let ends = edge.vertices().map(|v| self.nodes[v.data().node as usize]);
                    let [a, b] = ends.map(|end| sub(end, place));
                    cavity.encroaches |= dot(a, b) < 0.0;
                    continue;
                }
                let Some(other) = edge.rev().face().as_inner().map(|other| other.fix()) else {
                    continue;
                };
                let (center, radius) = circumcircle(self.places(other));
                if distance(center, place) < radius && !found.contains(&other) {
                    found.push(other);
                }
            }
        }
        Some(cavity)
    }

    /// Puts a node; returns the triangles around it, which are all that changed.
    fn insert(&mut self, near: Face, place: Point<2>, size: f64) -> Result<Vec<Face>, Unfilled> {
        if self.nodes.len() >= self.boundary.most {
            return Err(Unfilled::TooMany);
        }
        let hint = self.triangulation.face(near).vertices()[0].fix();
        let vertex = Vertex {
            position: self.scaled(place),
            node: self.nodes.len() as u32,
        };
        self.nodes.push(place);
        self.sizes.push(size);
        let inserted = self.triangulation.insert_with_hint(vertex, hint);
        let handle = inserted.map_err(|_| Unfilled::TooMany)?;
        let faces = self.triangulation.num_all_faces();
        self.inside.resize(faces, true);
        self.version.resize(faces, 0);
        self.largeness.resize(faces, 0.0);
        let around = self.triangulation.vertex(handle).out_edges();
        let changed: Vec<Face> = around
            .filter_map(|edge| Some(edge.face().as_inner()?.fix()))
            .collect();
        for face in &changed {
            self.version[face.index()] += 1;
            self.largeness[face.index()] = self.measured(*face);
        }
        Ok(changed)
    }

    /// Puts circumcentres of triangles with an angle below 30°.
    fn improve(&mut self) -> Result<(), Unfilled> {
        let mut heap = BinaryHeap::new();
        for face in self.triangulation.fixed_inner_faces() {
            self.offer_thin(face, &mut heap);
        }
        while let Some(waiting) = heap.pop() {
            let face = waiting.face;
            if self.version[face.index()] != waiting.version {
                continue;
            }
            let (center, _) = circumcircle(self.places(face));
            // A node nearer than this to another makes triangles worse than the one that it replaces.
            let accepted = self
                .cavity(face, center)
                .filter(|cavity| !cavity.encroaches && cavity.clearance > 0.3 * cavity.size);
            if let Some(cavity) = accepted {
                for face in self.insert(face, center, cavity.size)? {
                    self.offer_thin(face, &mut heap);
                }
            }
        }
        Ok(())
    }

    fn offer_thin(&self, face: Face, heap: &mut BinaryHeap<Waiting>) {
        let index = face.index();
        let places = self.places(face);
        let (_, radius) = circumcircle(places);
        let shortest = (0..3)
            .map(|k| distance(places[k], places[(k + 1) % 3]))
            .fold(f64::INFINITY, f64::min);
        // The sine of the smallest angle is half of this quotient's inverse.
        let badness = radius / shortest;
        if self.inside[index] && badness > 1.0 {
            heap.push(Waiting {
                badness,
                face,
                version: self.version[index],
            });
        }
    }

    /// Halves edges within the body that are too long for a triangle beside them.
    fn shorten(&mut self) -> Result<(), Unfilled> {
        let mut waiting: Vec<Face> = self.triangulation.fixed_inner_faces().collect();
        while let Some(face) = waiting.pop() {
            let middle = centroid_of(self.places(face));
            let longest = LONGEST * self.field.near(middle);
            let edges = self.triangulation.face(face).adjacent_edges().into_iter();
            let open = edges.filter(|edge| self.inside[face.index()] && !edge.is_constraint_edge());
            let long = open.map(|edge| edge.vertices().map(|v| self.nodes[v.data().node as usize]));
            let long = long.filter(|[a, b]| distance(*a, *b) > longest);
            let long = long.max_by(|[a, b], [c, d]| distance(*a, *b).total_cmp(&distance(*c, *d)));
            if let Some([a, b]) = long {
                let middle = add_scaled(a, 0.5, sub(b, a));
                let size = self.field.near(middle);
                waiting.extend(self.insert(face, middle, size)?);
            }
        }
        Ok(())
    }

    /// Nodes and triangles of the body, each with its smallest node first.
    fn triangles(&self) -> (Vec<Point<2>>, Vec<[u32; 3]>) {
        let faces = self.triangulation.fixed_inner_faces();
        let inside = faces.filter(|face| self.inside[face.index()]);
        let mut triangles: Vec<[u32; 3]> = inside
            .map(|face| {
                let mut corners = self.corners(face);
                let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
                corners.rotate_left(first);
                corners
            })
            .collect();
        triangles.sort_unstable();
        (self.nodes.clone(), triangles)
    }
}

fn centroid_of(places: [Point<2>; 3]) -> Point<2> {
    [0, 1].map(|d| (places[0][d] + places[1][d] + places[2][d]) / 3.0)
}

/// Centre and radius; not finite for three points on a line.
fn circumcircle([a, b, c]: [Point<2>; 3]) -> (Point<2>, f64) {
    let (u, v) = (sub(b, a), sub(c, a));
    let (uu, vv) = (dot(u, u), dot(v, v));
    let twice = 2.0 * cross(u, v);
    let offset = [
        (v[1] * uu - u[1] * vv) / twice,
        (u[0] * vv - v[0] * uu) / twice,
    ];
    (add_scaled(a, 1.0, offset), offset[0].hypot(offset[1]))
}

/// An order in which incremental insertion is fast: rounds of doubling length, each along a curve that fills the plane.
fn insertion_order(nodes: &[Point<2>]) -> Vec<usize> {
    let (low, high) = crate::geometry::bounding_box(nodes);
    let extent = (high[0] - low[0]).max(high[1] - low[1]);
    let key = |index: usize| {
        let cell = |d: usize| ((nodes[index][d] - low[d]) / extent * 65535.0) as u32;
        let mixed = (index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let round = (mixed ^ (mixed >> 29)).leading_zeros().min(12);
        (std::cmp::Reverse(round), hilbert(cell(0), cell(1)))
    };
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by_cached_key(|&index| key(index));
    order
}

/// Place of a cell of the 2¹⁶ × 2¹⁶ lattice along Hilbert's curve.
fn hilbert(mut x: u32, mut y: u32) -> u64 {
    let mut place = 0;
    for level in (0..16).rev() {
        let side = 1 << level;
        let (right, upper) = ((x & side) != 0, (y & side) != 0);
        let quarter = u64::from((3 * u32::from(right)) ^ u32::from(upper));
        place = 4 * place + quarter;
        if !upper {
            if right {
                (x, y) = (65535 - x, 65535 - y);
            }
            (x, y) = (y, x);
        }
    }
    place
}

/// Moves each inner node towards the centroid of its triangles, weighted by area over h³, where no angle gets smaller
/// than the smallest one around it.
fn smooth(nodes: &mut [Point<2>], triangles: &[[u32; 3]], sizes: &[f64], fixed: usize) {
    let mut starts = vec![0; nodes.len() + 1];
    for &node in triangles.iter().flatten() {
        starts[node as usize + 1] += 1;
    }
    for node in 0..nodes.len() {
        starts[node + 1] += starts[node];
    }
    let mut around = vec![0; 3 * triangles.len()];
    let mut filled = starts.clone();
    for (index, triangle) in triangles.iter().enumerate() {
        for &node in triangle {
            around[filled[node as usize]] = index;
            filled[node as usize] += 1;
        }
    }
    for node in fixed..nodes.len() {
        let star = &around[starts[node]..starts[node + 1]];
        let before = nodes[node];
        let target = centroid(nodes, triangles, sizes, star);
        let worst = smallest_sine(nodes, triangles, star);
        // The whole way, half of it, a quarter.
        for share in [1.0, 0.5, 0.25] {
            nodes[node] = add_scaled(before, share, sub(target, before));
            if smallest_sine(nodes, triangles, star) > worst {
                break;
            }
            nodes[node] = before;
        }
    }
}

fn centroid(nodes: &[Point<2>], triangles: &[[u32; 3]], sizes: &[f64], star: &[usize]) -> Point<2> {
    let (mut sum, mut total) = ([0.0; 2], 0.0);
    for &triangle in star {
        let corners = triangles[triangle];
        let [a, b, c] = corners.map(|node| nodes[node as usize]);
        let size = corners
            .iter()
            .map(|&node| sizes[node as usize])
            .sum::<f64>();
        let weight = cross(sub(b, a), sub(c, a)) / size.powi(3);
        for d in 0..2 {
            sum[d] += weight * (a[d] + b[d] + c[d]) / 3.0;
        }
        total += weight;
    }
    sum.map(|s| s / total)
}

/// Smallest sine of an angle of some triangles; negative where one is turned over.
fn smallest_sine(nodes: &[Point<2>], triangles: &[[u32; 3]], star: &[usize]) -> f64 {
    let sines = star.iter().map(|&triangle| {
        let places = triangles[triangle].map(|node| nodes[node as usize]);
        let lengths = [0, 1, 2].map(|k| distance(places[k], places[(k + 1) % 3]));
        let twice = cross(sub(places[1], places[0]), sub(places[2], places[0]));
        // The sine at the corner between two sides is twice the area over their product: the longest two.
        let product = lengths[0] * lengths[1] * lengths[2];
        let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        twice * shortest / product
    });
    sines.fold(f64::INFINITY, f64::min)
}
