//! The opposite of a point: intersections of lines with the facets of a side, found through a tree of their boxes.
//!
//! A point x with outward normal n faces the facet that the line x + s·n meets nearest to x (smallest |s|), if the
//! outward normal there is opposed to n, and the segment between them crosses no boundary of the two bodies. In front of x (s > 0)
//! the segment lies outside of both. Behind x (s < 0) the bodies overlap, and it lies inside of both: x itself is inside the other
//! body, so that a surface on the far side of that body is not a partner, nor is one behind the far side of x's own body, nor one that
//! begins at an edge of the other body, which the segment meets from outside. An overlap
//! is resolved in its short direction: a surface at the far end of a long overlap is not a partner either. A body that meets itself, at a
//! slit say, overlaps where it goes on behind the surface that is met; where it ends there the segment is its own thickness.
//! Cost: O(log n) for each line.

use crate::contact::relative::frame;
use crate::geometry::{
    Point, Settling, add_scaled, bounding_box, clip, distance, dot, invert, norm, sub, unit,
};
use crate::mesh::{CellKind, Domain, Facet, Mesh};
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};
use std::cmp::Ordering;
use std::sync::{Arc, OnceLock};

/// Facets count as opposed when the cosine between the normals is below this.
const OPPOSED: f64 = -0.1;

/// A line may miss the end of a facet by this much in its reference coordinate: only rounding.
const END: f64 = 1e-9;

/// The whole line.
const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Where a line meets a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// The facet.
    pub facet: Facet,
    /// Reference coordinates on it, missing ones zero.
    pub xi: [f64; 2],
    /// Distance s along the direction of the line.
    pub distance: f64,
}

/// A line: a point and a unit direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<const D: usize> {
    /// Where s = 0.
    pub start: Point<D>,
    /// Unit vector.
    pub direction: Point<D>,
}

impl<const D: usize> Line<D> {
    /// Component of x − start across a line of the plane (positive on the right).
    pub fn across(&self, x: Point<D>) -> f64 {
        let d = sub(x, self.start);
        d[0] * self.direction[1] - d[1] * self.direction[0]
    }

    /// Component of x − start along the line.
    pub fn along(&self, x: Point<D>) -> f64 {
        dot(sub(x, self.start), self.direction)
    }
}

/// Some facets of a mesh, prepared for intersection with lines.
pub(crate) struct Screen<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    tree: RTree<Boxed<D>>,
}

struct Boxed<const D: usize> {
    facet: Facet,
    envelope: AABB<Point<D>>,
}

impl<const D: usize> RTreeObject for Boxed<D> {
    type Envelope = AABB<Point<D>>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

/// Selects the boxes that satisfy a condition.
struct Selected<F>(F);

impl<const D: usize, F: Fn(Point<D>, Point<D>) -> bool> SelectionFunction<Boxed<D>>
    for Selected<F>
{
    fn should_unpack_parent(&self, envelope: &AABB<Point<D>>) -> bool {
        self.0(envelope.lower(), envelope.upper())
    }

    fn should_unpack_leaf(&self, leaf: &Boxed<D>) -> bool {
        self.should_unpack_parent(&leaf.envelope)
    }
}

/// Whether a line meets a box between two distances: the interval of s in which it is between the faces of every axis is not empty.
fn meets_box<const D: usize>(
    line: Line<D>,
    [mut from, mut to]: [f64; 2],
    low: Point<D>,
    high: Point<D>,
) -> bool {
    for d in 0..D {
        let (start, slope) = (line.start[d], line.direction[d]);
        if slope == 0.0 {
            if start < low[d] || start > high[d] {
                return false;
            }
            continue;
        }
        let (a, b) = ((low[d] - start) / slope, (high[d] - start) / slope);
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    from <= to
}

/// Whether a box may meet some line between two lines of the plane: not if it lies beyond both on the same side.
fn meets_between(lines: [Line<2>; 2], low: Point<2>, high: Point<2>) -> bool {
    let corners = [low, [high[0], low[1]], [low[0], high[1]], high];
    let hand = |line: Line<2>| {
        let across = corners.map(|corner| line.across(corner));
        match across.iter().all(|c| *c > 0.0) {
            true => 1,
            false if across.iter().all(|c| *c < 0.0) => -1,
            false => 0,
        }
    };
    hand(lines[0]) * hand(lines[1]) != 1
}

impl<'a, const D: usize> Screen<'a, D> {
    /// These facets of a mesh.
    pub fn new(mesh: &'a Mesh<D>, facets: &[Facet]) -> Self {
        let boxes = facets.iter().map(|&facet| {
            let mut points: Vec<Point<D>> = mesh.facet_points(facet).collect();
            if let (CellKind::Line3, [a, b, middle]) = (mesh.facet_kind(facet), &points[..]) {
                // a parabola lies in the hull of its ends and this control point
                let ends = add_scaled(*a, 1.0, *b);
                points[2] = add_scaled(middle.map(|c| 2.0 * c), -0.5, ends);
            }
            let (low, high) = bounding_box(&points);
            let margin = END * distance(low, high) + bulge(mesh, facet, &points);
            let envelope = AABB::from_corners(low.map(|c| c - margin), high.map(|c| c + margin));
            Boxed { facet, envelope }
        });
        let tree = RTree::bulk_load(boxes.collect());
        Self { mesh, tree }
    }

    /// Facets whose boxes satisfy a condition on their corners, in ascending order.
    fn select(&self, meets: impl Fn(Point<D>, Point<D>) -> bool) -> Vec<Facet> {
        let found = self.tree.locate_with_selection_function(Selected(meets));
        let mut facets: Vec<Facet> = found.map(|boxed| boxed.facet).collect();
        facets.sort_unstable();
        facets
    }

    /// Hits of a line between two distances whose cosine to the outward normal satisfies a condition, in ascending order of facets,
    /// with these cosines.
    pub fn meets(
        &self,
        line: Line<D>,
        [from, to]: [f64; 2],
        condition: impl Fn(f64) -> bool,
    ) -> Vec<(Hit, f64)> {
        let facets = self.select(|low, high| meets_box(line, [from, to], low, high));
        let on_facet = |facet: Facet| {
            let hit = meet(self.mesh, facet, line)?;
            let normal = self.mesh.outward_normal(facet, &hit.xi);
            let cosine = dot(normal, line.direction) / norm(normal);
            let inside = self.mesh.facet_kind(facet).domain().outside(&hit.xi) <= END
                && (from..=to).contains(&hit.distance);
            (inside && condition(cosine)).then_some((hit, cosine))
        };
        facets.into_iter().filter_map(on_facet).collect()
    }
}

/// How far a curved facet of space may lie outside the box of its nodes: control points of its edges lie beyond the middle nodes
/// by the distance of these from the chords, that of its middle at most by twice that distance.
fn bulge<const D: usize>(mesh: &Mesh<D>, facet: Facet, points: &[Point<D>]) -> f64 {
    let kind = mesh.facet_kind(facet);
    let linear = kind.domain().linear();
    if D < 3 || kind == linear {
        return 0.0;
    }
    let off = |(xi, point): (&[f64; 3], &Point<D>)| {
        let mut hats = [0.0; 4];
        linear.shape(xi, &mut hats);
        let middle = points.iter().zip(&hats[..linear.nodes()]);
        let middle = middle.fold([0.0; D], |sum, (&x, &hat)| add_scaled(sum, hat, x));
        distance(middle, *point)
    };
    let nodes = kind.reference_nodes().iter().zip(points);
    3.0 * nodes.map(off).fold(0.0, f64::max)
}

/// Where a line meets a facet or its continuation, nearest to the facet's middle; `None` when it does not.
pub(crate) fn meet<const D: usize>(mesh: &Mesh<D>, facet: Facet, line: Line<D>) -> Option<Hit> {
    let xi = match mesh.facet_kind(facet).domain() {
        Domain::Line => [meet_line(mesh, facet, line)?, 0.0],
        _ => meet_surface(mesh, facet, line)?,
    };
    let distance = line.along(mesh.facet_point(facet, &xi));
    distance.is_finite().then_some(Hit {
        facet,
        xi,
        distance,
    })
}

/// Where a line of the plane meets a straight or parabolic facet.
fn meet_line<const D: usize>(mesh: &Mesh<D>, facet: Facet, line: Line<D>) -> Option<f64> {
    let mut across = [0.0; 3];
    for (value, point) in across.iter_mut().zip(mesh.facet_points(facet)) {
        *value = line.across(point);
    }
    let [a, b, middle] = across;
    match mesh.facet_kind(facet) {
        CellKind::Line2 => Some((a + b) / (a - b)),
        _ => quadratic_root(0.5 * (a + b) - middle, 0.5 * (b - a), middle),
    }
}

/// Where a line meets a facet of space, from its middle by Newton's method for ξ and s.
fn meet_surface<const D: usize>(mesh: &Mesh<D>, facet: Facet, line: Line<D>) -> Option<[f64; 2]> {
    let [x, y, _] = mesh.facet_kind(facet).domain().centre();
    let (mut xi, mut s, mut settling) = ([x, y], 0.0, Settling::new());
    for _ in 0..LINE_STEPS {
        let rest = sub(
            add_scaled(line.start, s, line.direction),
            mesh.facet_point(facet, &xi),
        );
        let tangents = mesh.facet_tangents(facet, &xi);
        // columns: the two tangents, and against the line
        let jacobian = std::array::from_fn(|i| {
            let column = |j: usize| match j + 1 == D {
                true => -line.direction[i],
                false => tangents[j][i],
            };
            std::array::from_fn(column)
        });
        let (inverse, _) = invert::<D>(&jacobian);
        let change = inverse.map(|row| dot(row, rest));
        xi = std::array::from_fn(|k| xi[k] + change[k]);
        s += change[D - 1];
        if settling.ends(&change[..2], &xi) {
            return Some(xi);
        }
    }
    None
}

/// Most steps to where a line meets a facet.
const LINE_STEPS: usize = 20;

/// The root of αξ² + βξ + γ that is smaller in magnitude; `None` without a real root.
fn quadratic_root(alpha: f64, beta: f64, gamma: f64) -> Option<f64> {
    // NaN where no root is real
    let root = (beta * beta - 4.0 * alpha * gamma).sqrt();
    let q = -0.5 * (beta + root.copysign(beta));
    let root = if gamma == 0.0 { 0.0 } else { gamma / q };
    root.is_finite().then_some(root)
}

/// The whole boundary of a body, made on first use: only where sides lie apart.
pub(crate) struct Boundary<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    screen: OnceLock<Arc<Screen<'a, D>>>,
}

impl<'a, const D: usize> Boundary<'a, D> {
    /// That of a mesh.
    pub fn of(mesh: &'a Mesh<D>) -> Self {
        Self {
            mesh,
            screen: OnceLock::new(),
        }
    }

    fn screen(&self) -> &Arc<Screen<'a, D>> {
        let whole = || Arc::new(Screen::new(self.mesh, &self.mesh.boundary_facets()));
        self.screen.get_or_init(whole)
    }

    /// Whether a line is inside of the body somewhere between its start and a distance: it enters before that, or leaves after the
    /// start, or its middle is inside, where both ends are. Only the surface itself at either end, within `rounding`, is not inside.
    pub fn is_between(&self, line: Line<D>, distance: f64, rounding: f64) -> bool {
        let met = |way: [f64; 2]| {
            self.screen()
                .meets(line, way, |cosine| cosine.abs() > ALONG)
        };
        let through = met([-rounding, distance + rounding]);
        let crosses = through.iter().any(|(hit, cosine)| match *cosine < 0.0 {
            true => hit.distance <= distance - rounding,
            false => hit.distance >= rounding,
        });
        let ahead = || met([0.5 * distance, f64::INFINITY]).into_iter();
        let next = || ahead().min_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
        crosses || next().is_some_and(|(_, cosine)| cosine > 0.0)
    }

    /// How thick the body is behind a point of its surface, against this outward normal.
    pub fn thickness(&self, point: Point<D>, normal: Point<D>, rounding: f64) -> f64 {
        let line = Line {
            start: point,
            direction: normal.map(|c| -c),
        };
        let through = self.crossing(line, [rounding, f64::INFINITY], rounding);
        through.unwrap_or(f64::INFINITY)
    }

    /// Whether the body is twice at a place on a line: on its way to infinity the line leaves it twice more than it enters it. Facets that
    /// meet at a place of the line count once.
    fn is_twice(&self, line: Line<D>, distance: f64, rounding: f64) -> bool {
        let way = [distance, f64::INFINITY];
        let mut met = self
            .screen()
            .meets(line, way, |cosine| cosine.abs() > ALONG);
        met.sort_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
        let times = |leaves: bool| {
            let met = met.iter().filter(|(_, cosine)| (*cosine > 0.0) == leaves);
            let distances: Vec<f64> = met.map(|(hit, _)| hit.distance).collect();
            let places = distances.chunk_by(|a, b| b - a <= rounding);
            places.count()
        };
        times(true) >= times(false) + 2
    }

    /// Whether a line passes through it between two distances.
    fn crossed(&self, line: Line<D>, way: [f64; 2], rounding: f64) -> bool {
        self.crossing(line, way, rounding).is_some()
    }

    /// The first distance between two at which a line crosses it.
    fn crossing(&self, line: Line<D>, way: [f64; 2], rounding: f64) -> Option<f64> {
        let first = self.first_crossing(line, way, rounding);
        first.map(|(hit, _)| hit.distance)
    }

    /// Whether a place on a line is inside of the body: what the line crosses next, it leaves.
    fn holds(&self, line: Line<D>, distance: f64, rounding: f64) -> bool {
        let next = self.first_crossing(line, [distance, f64::INFINITY], rounding);
        next.is_some_and(|(_, cosine)| cosine > 0.0)
    }

    /// The first crossing of a line between two distances, with the cosine there. Two facets back to back within `rounding` do not count
    /// as one: at the seam between two parts of one body, or at an edge that the line touches.
    fn first_crossing(&self, line: Line<D>, way: [f64; 2], rounding: f64) -> Option<(Hit, f64)> {
        let met = self
            .screen()
            .meets(line, way, |cosine| cosine.abs() > ALONG);
        let back_to_back = |&&(a, cosine): &&(Hit, f64)| {
            let mut others = met.iter();
            others.any(|(b, other)| {
                cosine * other < 0.0 && (a.distance - b.distance).abs() <= rounding
            })
        };
        let through = met.iter().filter(|met| !back_to_back(met));
        through
            .min_by(|a, b| a.0.distance.total_cmp(&b.0.distance))
            .copied()
    }
}

/// A line nearly parallel to a facet, with a cosine up to this, does not cross it.
const ALONG: f64 = 1e-6;

/// Boundaries within this part of a facet from the ends of a segment do not count.
pub(crate) const NEAR: f64 = 1e-6;

/// An overlap that is longer along a line than this multiple of its width is resolved across the line, not along it.
const LONGEST: f64 = 2.0;

/// The search from points of one body for a side of another.
pub(crate) struct SideSearch<'a, const D: usize> {
    side: Arc<Screen<'a, D>>,
    own: Arc<Boundary<'a, D>>,
    other: Arc<Boundary<'a, D>>,
}

impl<'a, const D: usize> SideSearch<'a, D> {
    /// Prepares a search from `own` for these facets of `other`.
    pub fn new(own: &'a Mesh<D>, other: &'a Mesh<D>, facets: &[Facet]) -> Self {
        Self {
            side: Arc::new(Screen::new(other, facets)),
            own: Arc::new(Boundary::of(own)),
            other: Arc::new(Boundary::of(other)),
        }
    }

    /// Prepares a search from one body for a side of another, of parts that are kept.
    pub fn from_to(
        own: &Arc<Boundary<'a, D>>,
        other: &Arc<Boundary<'a, D>>,
        side: &Arc<Screen<'a, D>>,
    ) -> Self {
        Self {
            side: Arc::clone(side),
            own: Arc::clone(own),
            other: Arc::clone(other),
        }
    }

    /// The opposite of a point with this outward normal. For overlaps up to `shallow`, the length of its facet, the line may have left
    /// its own body: beside an edge it does.
    pub fn opposite(&self, line: Line<D>, shallow: f64) -> Option<Hit> {
        self.opposite_among(line, shallow, |_| true)
    }

    /// The same among the facets that satisfy a condition.
    pub fn opposite_among(
        &self,
        line: Line<D>,
        shallow: f64,
        of: impl Fn(Facet) -> bool,
    ) -> Option<Hit> {
        let hits = self
            .side
            .meets(line, EVERYWHERE, |cosine| cosine < OPPOSED)
            .into_iter();
        let mut hits: Vec<Hit> = hits.map(|(hit, _)| hit).filter(|h| of(h.facet)).collect();
        hits.sort_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        hits.into_iter()
            .find(|hit| self.clear(line, hit.distance, shallow))
    }

    /// Whether the segment along a line to a distance crosses no boundary, and does not run along a long overlap.
    fn clear(&self, line: Line<D>, distance: f64, shallow: f64) -> bool {
        let rounding = NEAR * shallow;
        let way = [distance.min(0.0) + rounding, distance.max(0.0) - rounding];
        let beside_own = distance < 0.0 && -distance <= shallow;
        // not longer than rounding
        way[0].partial_cmp(&way[1]) != Some(Ordering::Less)
            || !self.other.crossed(line, way, rounding)
                && (beside_own || !self.own.crossed(line, way, rounding))
                && (distance > 0.0 || self.is_short(line, -distance, rounding))
                && (distance > 0.0 || self.overlaps(line, -distance, rounding))
    }

    /// Whether what lies behind the start of a line to a depth, within one body or two, is an overlap: of one with itself, not its own
    /// thickness; of two within the other one, not beside it up to an edge.
    fn overlaps(&self, line: Line<D>, depth: f64, rounding: f64) -> bool {
        let back = Line {
            start: line.start,
            direction: line.direction.map(|c| -c),
        };
        match std::ptr::eq(self.own.mesh, self.other.mesh) {
            true => self.own.is_twice(back, 0.5 * depth, rounding),
            false => self.other.holds(back, 0.5 * depth, rounding),
        }
    }

    /// Whether the overlap of the bodies behind the start of a line is at most [`LONGEST`] times as deep as it is wide half way there.
    /// The search for its width ends at that depth.
    fn is_short(&self, line: Line<D>, depth: f64, rounding: f64) -> bool {
        let middle = add_scaled(line.start, -0.5 * depth, line.direction);
        let to_the_end = |direction: Point<D>| {
            let line = Line {
                start: middle,
                direction,
            };
            let ends = [&self.own, &self.other];
            let ends = ends.map(|body| body.crossing(line, [rounding, depth], rounding));
            ends.into_iter().flatten().fold(depth, f64::min)
        };
        let across = frame(line.direction, &[]);
        let mut across = across[1..].iter();
        across.all(|&axis| {
            let width = to_the_end(axis) + to_the_end(axis.map(|c| -c));
            depth <= LONGEST * width
        })
    }
}

impl SideSearch<'_, 2> {
    /// Facets of the other side that lines between these two may meet.
    pub fn between(&self, lines: [Line<2>; 2]) -> Vec<Facet> {
        let meets = |low, high| meets_between(lines, low, high);
        self.side.select(meets)
    }
}

/// The volume swept by lines along the normals of a facet of space, slightly enlarged.
#[derive(Debug, Clone)]
pub(crate) struct Prism {
    middle: Point<3>,
    /// Two axes across the mean normal, and that.
    axes: [Point<3>; 3],
    /// How far the facet extends along the first two.
    reach: [f64; 2],
    /// Divergence of the lines from the mean normal, per length.
    spread: f64,
}

impl Prism {
    /// Of the nodes of a facet and the normals at its corners.
    pub fn new(points: impl Iterator<Item = Point<3>>, normals: &[Point<3>]) -> Self {
        let points: Vec<Point<3>> = points.collect();
        let sum = normals
            .iter()
            .fold([0.0; 3], |sum, &n| add_scaled(sum, 1.0, n));
        let [normal, first, second] = frame(unit(sum).unwrap_or(normals[0]), &[]);
        let share = 1.0 / points.len() as f64;
        let middle = points
            .iter()
            .fold([0.0; 3], |sum, &x| add_scaled(sum, share, x));
        let extent = |axis: Point<3>| {
            let along = points.iter().map(|&x| dot(axis, sub(x, middle)).abs());
            along.fold(0.0, f64::max)
        };
        let parting = normals.iter().map(|&n| norm(sub(n, normal)));
        Self {
            middle,
            reach: [first, second].map(|axis| (1.0 + END) * extent(axis)),
            axes: [first, second, normal],
            spread: 1.1 * parting.fold(0.0, f64::max),
        }
    }

    /// Whether a box may reach into it.
    fn meets(&self, low: Point<3>, high: Point<3>) -> bool {
        let centre: Point<3> = std::array::from_fn(|d| 0.5 * (low[d] + high[d]));
        let half: Point<3> = std::array::from_fn(|d| 0.5 * (high[d] - low[d]));
        let at = sub(centre, self.middle);
        let [first, second, depth] = self.axes.map(|axis| {
            let radius: f64 = (0..3).map(|d| half[d] * axis[d].abs()).sum();
            (dot(axis, at).abs(), radius)
        });
        let parting = self.spread * (depth.0 + depth.1);
        [first, second]
            .into_iter()
            .zip(self.reach)
            .all(|((at, radius), reach)| at <= reach + radius + parting)
    }

    /// The part of a polygon near it. Its width grows with depth, because the lines diverge: a large polygon is cut until its depth no
    /// longer decreases.
    pub fn clip(&self, polygon: &[Point<3>]) -> Vec<Point<3>> {
        let from = |y: Point<3>, axis: Point<3>| dot(axis, sub(y, self.middle));
        let depth_of = |polygon: &[Point<3>]| {
            let depth = polygon.iter().map(|&y| from(y, self.axes[2]).abs());
            depth.fold(0.0, f64::max)
        };
        let cut = |polygon: Vec<Point<3>>, depth: f64| {
            let sides = [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)];
            sides.into_iter().fold(polygon, |left, (k, sign)| {
                let reach = 1.5 * self.reach[k] + self.spread * depth;
                let inside = |y: Point<3>| reach - sign * from(y, self.axes[k]);
                clip(&left, inside, |p, q, t| add_scaled(p, t, sub(q, p)))
            })
        };
        let (mut left, mut depth) = (polygon.to_vec(), depth_of(polygon));
        loop {
            left = cut(left, depth);
            let before = std::mem::replace(&mut depth, depth_of(&left));
            if depth > 0.5 * before || depth <= self.reach[0].max(self.reach[1]) {
                return cut(left, depth);
            }
        }
    }
}

impl SideSearch<'_, 3> {
    /// Facets of the other side that may reach into the volume swept by the normals of a facet.
    pub fn within(&self, prism: &Prism) -> Vec<Facet> {
        self.side.select(|low, high| prism.meets(low, high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{flat, noise, together, wall};
    use crate::geometry::unit;
    use crate::mesh::{CellBlock, CellKind, Cuboid, Rectangle, Ring};

    fn block(from: Point<2>, to: Point<2>, cell: CellKind) -> Mesh<2> {
        let rectangle = Rectangle {
            from,
            to,
            cells: [4, 2],
            cell,
            diagonals: Default::default(),
        };
        rectangle.build().unwrap()
    }

    fn up(x: f64, y: f64) -> Line<2> {
        Line {
            start: [x, y],
            direction: [0.0, 1.0],
        }
    }

    #[test]
    fn lines_meet_straight_and_curved_facets_at_their_place() {
        for cell in [CellKind::Quad4, CellKind::Quad9] {
            let lower = block([0.0, 0.0], [4.0, 1.0], cell);
            let upper = block([1.0, 1.5], [5.0, 2.5], cell)
                .map_points(|[x, y]| [x, y + 0.1 * x * x])
                .unwrap();
            let facets = upper.side("bottom").unwrap();
            let search = SideSearch::new(&lower, &upper, facets);
            let hit = search.opposite(up(2.3, 1.0), 1.0).unwrap();
            let [x, _] = upper.facet_point(hit.facet, &hit.xi);
            assert!((x - 2.3).abs() < 1e-14);
            if cell == CellKind::Quad9 {
                assert!((hit.distance - (0.5 + 0.1 * 2.3 * 2.3)).abs() < 1e-14);
            }
            assert_eq!(search.opposite(up(0.9, 1.0), 1.0), None);
        }
    }

    #[test]
    fn the_far_side_of_the_other_body_is_no_overlap() {
        let lower = block([0.0, 0.0], [4.0, 1.0], CellKind::Quad4);
        let upper = block([0.0, 0.9], [4.0, 2.0], CellKind::Quad4);
        let all = upper.boundary_facets();
        let search = SideSearch::new(&lower, &upper, &all);
        let overlap = search.opposite(up(1.3, 1.0), 0.01).unwrap();
        assert!((overlap.distance + 0.1).abs() < 1e-14);
        // from the bottom, looking down: the top of the upper body is behind, but outside the lower one
        let down = Line {
            start: [1.3, 0.0],
            direction: [0.0, -1.0],
        };
        assert_eq!(search.opposite(down, 0.01), None);
    }

    /// A strip bent to a ring whose ends overlap by an angle of 0.01: the ends meet each other, the sides do not meet through the strip.
    #[test]
    fn a_body_overlaps_itself_where_it_goes_on_behind() {
        let rectangle = Rectangle {
            from: [0.0, 1.0],
            to: [std::f64::consts::TAU + 0.01, 2.0],
            cells: [64, 2],
            cell: CellKind::Quad4,
            diagonals: Default::default(),
        };
        let bent = |[a, r]: Point<2>| [r * a.sin(), r * a.cos()];
        let strip = rectangle.build().unwrap().map_points(bent).unwrap();
        let end = SideSearch::new(&strip, &strip, strip.side("right").unwrap());
        let line = |start: Point<2>, direction: Point<2>| Line { start, direction };
        let hit = end.opposite(line([0.0, 1.5], [-1.0, 0.0]), 0.1).unwrap();
        assert!((hit.distance + 0.015).abs() < 1e-4, "{hit:?}");
        let inner = SideSearch::new(&strip, &strip, strip.side("bottom").unwrap());
        assert_eq!(inner.opposite(line([0.0, -2.0], [0.0, -1.0]), 0.1), None);
        let across = inner.opposite(line([0.9, 0.0], [-1.0, 0.0]), 0.1).unwrap();
        assert!((across.distance - 1.9).abs() < 1e-2, "{across:?}");
    }

    #[test]
    fn a_flank_beside_a_corner_that_is_sunk_a_little_does_not_face_what_is_far_behind() {
        let lower = block([0.0, 0.0], [4.0, 1.0], CellKind::Quad4);
        let upper = block([0.1, 0.999], [6.0, 2.0], CellKind::Quad4);
        let all = upper.boundary_facets();
        let search = SideSearch::new(&lower, &upper, &all);
        // its left side is behind, inside of the lower body all the way
        let right = Line {
            start: [4.0, 0.9995],
            direction: [1.0, 0.0],
        };
        assert_eq!(search.opposite(right, 0.5), None);
        // the top is sunk by as much as it faces, up to its ends
        for x in [0.11, 0.2, 2.3, 3.99] {
            let found = search.opposite(up(x, 1.0), 1e-3).unwrap();
            assert!((found.distance + 1e-3).abs() < 1e-14);
        }
    }

    #[test]
    fn what_lies_on_the_far_side_of_the_other_body_is_no_partner() {
        let plate = |from: f64, to: f64| block([0.0, from], [4.0, to], CellKind::Quad4);
        let (lower, sunk) = (plate(0.0, 1.0), plate(0.95, 2.0));
        let left = Line {
            start: [0.0, 0.97],
            direction: [-1.0, 0.0],
        };
        // its right end lies behind the left one of the lower plate and inside that plate, at the given distance
        for squeeze in [0.25, 0.5] {
            let upper = sunk.clone().map_points(|[x, y]| [squeeze * x + 1.0, y]);
            let upper = upper.unwrap();
            let search = SideSearch::new(&lower, &upper, &upper.boundary_facets());
            assert_eq!(search.opposite(left, 1.0), None);
            assert_eq!(search.opposite(left, 9.0), None);
            let overlap = search.opposite(up(1.7, 1.0), 1.0).unwrap();
            assert!((overlap.distance + 0.05).abs() < 1e-14);
        }
    }

    #[test]
    fn what_lies_behind_a_part_of_either_body_is_no_partner() {
        let plate = |from: f64, to: f64| block([0.0, from], [4.0, to], CellKind::Quad4);
        let (lower, upper, far) = (plate(0.0, 1.0), plate(1.1, 2.0), plate(3.0, 4.0));
        let at = |mesh: &Mesh<2>, height: f64| -> Vec<Facet> {
            let level = |facet: &Facet| mesh.facet_points(*facet).all(|x| x[1] == height);
            let facets = mesh.boundary_facets().into_iter();
            facets.filter(level).collect()
        };
        let met = |own: &Mesh<2>, other: &Mesh<2>, height: f64| {
            let search = SideSearch::new(own, other, &at(other, height));
            search.opposite(up(1.3, 1.0), 1.0).map(|hit| hit.distance)
        };
        let near = |found: Option<f64>, s: f64| (found.unwrap() - s).abs() < 1e-14;
        assert!(near(met(&lower, &upper, 1.1), 0.1));
        assert!(near(met(&lower, &far, 3.0), 2.0));
        // a side that leaves the near plate out
        let other = together(&upper, &far);
        assert!(near(met(&lower, &other, 1.1), 0.1));
        assert_eq!(met(&lower, &other, 3.0), None);
        // a part of the own body is in between
        let own = together(&lower, &upper);
        assert_eq!(met(&own, &far, 3.0), None);
        // two touching parts of the other body count as one
        let (near_part, far_part) = (plate(0.5, 0.8), plate(0.8, 2.0));
        let other = together(&near_part, &far_part);
        assert!(near(met(&lower, &other, 0.5), -0.5));
    }

    #[test]
    fn a_place_has_a_part_along_a_line_and_a_part_to_its_right() {
        let line = Line {
            start: [1.0, 2.0],
            direction: [0.6, 0.8],
        };
        // (2, 3) from the start: 3.6 along, 0.2 to the left; a few roundings
        assert!((line.along([3.0, 5.0]) - 3.6).abs() < 1e-14);
        assert!((line.across([3.0, 5.0]) + 0.2).abs() < 1e-14);
    }

    /// Whether a line meets the boundary of a box, asked face by face.
    fn meets_a_face<const D: usize>(line: Line<D>, low: Point<D>, high: Point<D>) -> bool {
        let faces = (0..D).flat_map(|d| [(d, low[d]), (d, high[d])]);
        faces.into_iter().any(|(d, at)| {
            let s = (at - line.start[d]) / line.direction[d];
            let x = add_scaled(line.start, s, line.direction);
            (0..D).all(|e| e == d || (low[e] <= x[e] && x[e] <= high[e]))
        })
    }

    fn check_boxes<const D: usize>() {
        let mut noise = noise();
        let mut met = 0;
        for _ in 0..400 {
            let [start, direction, a, b]: [Point<D>; 4] =
                std::array::from_fn(|_| std::array::from_fn(|_| noise()));
            let (low, high) = bounding_box(&[a, b]);
            let line = Line { start, direction };
            let meets = meets_box(line, EVERYWHERE, low, high);
            assert_eq!(meets, meets_a_face(line, low, high), "{line:?}");
            met += usize::from(meets);
        }
        assert!((40..360).contains(&met));
    }

    #[test]
    fn a_line_meets_a_box_where_it_meets_a_face() {
        check_boxes::<2>();
        check_boxes::<3>();
    }

    #[test]
    fn a_line_meets_a_box_that_it_touches() {
        let (low, high) = ([0.0, 0.0], [1.0, 2.0]);
        let along_an_axis = [
            (-0.05, false),
            (0.0, true),
            (0.5, true),
            (1.0, true),
            (1.05, false),
        ];
        for (x, meets) in along_an_axis {
            assert_eq!(meets_box(up(x, 7.0), EVERYWHERE, low, high), meets, "{x}");
        }
        for (y, meets) in [(2.95, true), (3.0, true), (3.05, false)] {
            let line = Line {
                start: [1.0, y],
                direction: [-1.0, -1.0],
            };
            // through the corner (0, 2) at y = 3
            assert_eq!(meets_box(line, EVERYWHERE, low, high), meets, "{y}");
        }
    }

    #[test]
    fn a_box_beyond_both_lines_meets_none_between_them() {
        let lines = [up(1.0, 0.0), up(2.0, 5.0)];
        let meets = |from: f64, to: f64| meets_between(lines, [from, -1.0], [to, 3.0]);
        assert!(!meets(0.5, 0.95) && !meets(2.05, 2.5));
        // between them, over one, over both, touching one
        assert!(meets(1.2, 1.8) && meets(0.5, 1.1) && meets(1.9, 3.0) && meets(0.5, 2.5));
        assert!(meets(0.5, 1.0) && meets(2.0, 2.5));
        // one that crosses lines that are not parallel: beyond both below, between them above
        let fan = [
            up(0.0, 0.0),
            Line {
                start: [0.0, 0.0],
                direction: [0.6, 0.8],
            },
        ];
        assert!(!meets_between(fan, [1.0, 0.0], [2.0, 1.0]));
        assert!(meets_between(fan, [1.0, 0.0], [2.0, 2.0]));
        // a box on the left of one line and on the right of the other is between them
        assert!(meets_between(fan, [0.5, 3.0], [0.6, 4.0]));
    }

    #[test]
    fn lines_between_two_lines_may_meet_the_facets_there_alone() {
        let upper = flat(&[0.0, 1.0, 2.0, 3.0, 4.0], 1.0, CellKind::Quad4);
        let facets = upper.mesh.side("bottom").unwrap();
        let search = SideSearch::new(&upper.mesh, &upper.mesh, facets);
        let found = search.between([up(1.2, -1.0), up(2.7, -1.0)]);
        assert_eq!(found, facets[1..3]);
    }

    /// Lines through known places of facets meet them there; `size`: of the mesh.
    fn check_meet<const D: usize>(mesh: &Mesh<D>, facets: &[Facet], size: f64) {
        let mut noise = noise();
        for &facet in facets.iter().cycle().take(60) {
            let xi = match mesh.facet_kind(facet).domain() {
                Domain::Triangle => [0.1 + 0.3 * noise().abs(), 0.1 + 0.3 * noise().abs()],
                _ => [0.9 * noise(), 0.9 * noise()],
            };
            let place = mesh.facet_point(facet, &xi);
            let normal = unit(mesh.outward_normal(facet, &xi)).unwrap();
            let direction = unit(normal.map(|c| c + 0.3 * noise())).unwrap();
            let s = 3.0 * size * noise();
            let start = add_scaled(place, -s, direction);
            let hit = meet(mesh, facet, Line { start, direction }).unwrap();
            let found = mesh.facet_point(facet, &hit.xi);
            // a hundred roundings at the size of the start
            assert!(distance(found, place) < 1e-13 * size, "{hit:?} {xi:?}");
            assert!((hit.distance - s).abs() < 1e-13 * size);
            assert_eq!(hit.facet, facet);
        }
    }

    #[test]
    fn lines_meet_facets_of_every_kind_where_they_pass_through_them() {
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            let bent = block([-2.0, 1.0], [2.0, 2.0], cell)
                .map_points(|[x, y]| [x + 0.05 * y * y, y + 0.1 * x * x])
                .unwrap();
            check_meet(&bent, &bent.boundary_facets(), 5.0);
        }
        for cell in [CellKind::Tet4, CellKind::Hex8] {
            for size in [1e-6, 1.0, 1e6] {
                let cuboid = Cuboid {
                    from: [0.0; 3],
                    to: [size; 3],
                    cells: [2; 3],
                    cell,
                };
                let warped = cuboid
                    .build()
                    .unwrap()
                    .map_points(|[x, y, z]| [x + 0.1 * y * z / size, y, z + 0.15 * x * y / size]);
                let warped = warped.unwrap();
                check_meet(&warped, &warped.boundary_facets(), 5.0 * size);
            }
        }
    }

    #[test]
    fn a_line_beside_a_facet_does_not_meet_it() {
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            let mesh = block([0.0, 0.0], [4.0, 1.0], cell);
            let facet = mesh.side("left").unwrap()[0];
            assert_eq!(meet(&mesh, facet, up(-1.0, 0.0)), None);
        }
        let cuboid = Cuboid {
            from: [0.0; 3],
            to: [1.0; 3],
            cells: [1; 3],
            cell: CellKind::Hex8,
        };
        let mesh = cuboid.build().unwrap();
        let line = Line {
            start: [0.3, 0.4, 2.0],
            direction: [1.0, 0.0, 0.0],
        };
        assert_eq!(meet(&mesh, mesh.side("top").unwrap()[0], line), None);
    }

    #[test]
    fn of_two_roots_the_one_nearer_to_zero_is_taken() {
        let mut noise = noise();
        for _ in 0..50 {
            let (near, far, alpha) = (0.9 * noise(), 2.0 + noise(), 1.0 + 0.5 * noise());
            for far in [far, -far] {
                let found = quadratic_root(alpha, -alpha * (near + far), alpha * near * far);
                // no cancellation: a few roundings
                assert!((found.unwrap() - near).abs() < 1e-14);
            }
        }
        // a straight line, a double root, one root at zero
        assert_eq!(quadratic_root(0.0, 2.0, -1.0), Some(0.5));
        assert_eq!(quadratic_root(1.0, 2.0, 1.0), Some(-1.0));
        assert_eq!(quadratic_root(1.0, 0.0, 0.0), Some(0.0));
        assert_eq!(quadratic_root(3.0, 1.0, 0.0), Some(0.0));
        // never zero: above it, and a constant
        assert_eq!(quadratic_root(1.0, 0.2, 0.02), None);
        assert_eq!(quadratic_root(0.0, 0.0, 1.0), None);
    }

    #[test]
    fn a_parabola_is_found_beyond_its_nodes() {
        // y = 1 + ξ/2 − ξ²/2 rises to 1.125 between the nodes at 1 and 1
        let nodes = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0]];
        let offsets = [[30.0, 50.0], [-30.0, 50.0], [30.0, -50.0], [-30.0, -50.0]];
        for [dx, dy] in offsets {
            let moved = nodes.map(|[x, y]| [x + dx, y + dy]);
            let body = wall(&moved, 3.0 + dy, CellKind::Quad8);
            let search = SideSearch::new(&body.mesh, &body.mesh, body.mesh.side("bottom").unwrap());
            let line = Line {
                start: [dx + 5.0, dy + 1.1],
                direction: [-1.0, 0.0],
            };
            // where ξ = 1/2 − √0.05
            let expected = 5.0 - (1.5 - 0.05f64.sqrt());
            let hit = search.opposite(line, f64::INFINITY).unwrap();
            // the root stands where the line is nearly tangent: cancellation of coordinates as large as 50
            assert!((hit.distance - expected).abs() < 1e-12, "{hit:?}");
        }
    }

    #[test]
    fn a_line_may_miss_the_end_of_a_facet_by_rounding_alone() {
        for (from, end, beyond) in [(0.0, 0.0, -1.0), (-1.0, 0.0, 1.0)] {
            let body = flat(&[from, from + 1.0], 1.0, CellKind::Quad4);
            let search = SideSearch::new(&body.mesh, &body.mesh, body.mesh.side("bottom").unwrap());
            // the reference coordinate is twice as long as the facet
            for (part, met) in [(0.0, true), (0.47e-9, true), (0.53e-9, false)] {
                let line = up(end + beyond * part, -2.0);
                assert_eq!(search.opposite(line, 1.0).is_some(), met, "{part}");
            }
        }
    }

    #[test]
    fn a_facet_that_is_nearly_along_the_line_is_not_opposed() {
        // its normal is twice as long as a unit vector
        let body = flat(&[0.0, 4.0], 1.0, CellKind::Quad4);
        let search = SideSearch::new(&body.mesh, &body.mesh, body.mesh.side("bottom").unwrap());
        for (sine, opposed) in [(0.105, true), (0.095, false), (-0.105, false)] {
            let direction = [f64::sqrt(1.0 - sine * sine), sine];
            let start = add_scaled([2.0, 0.0], -0.2, direction);
            let hit = search.opposite(Line { start, direction }, 1.0);
            assert_eq!(hit.is_some(), opposed, "{sine}");
        }
    }

    /// The search agrees with asking every facet, for lines in all directions from around a point.
    fn check_search<const D: usize>(mesh: &Mesh<D>, centre: Point<D>) {
        let facets = mesh.boundary_facets();
        let search = SideSearch::new(mesh, mesh, &facets);
        let mut noise = noise();
        let mut met = 0;
        for _ in 0..300 {
            let start = centre.map(|c| c + 1.5 * noise());
            let direction = unit(centre.map(|_| noise())).unwrap();
            let line = Line { start, direction };
            let facing = facets.iter().filter_map(|&facet| {
                let hit = meet(mesh, facet, line)?;
                let normal = unit(mesh.outward_normal(facet, &hit.xi))?;
                let inside = mesh.facet_kind(facet).domain().outside(&hit.xi) <= END;
                (inside && dot(normal, direction) < OPPOSED).then_some(hit)
            });
            let nearest = facing.min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
            // so that every overlap is accepted
            let found = search.opposite(line, f64::INFINITY);
            assert_eq!(found, nearest);
            met += usize::from(found.is_some());
        }
        assert!((100..300).contains(&met), "{met}");
    }

    #[test]
    fn the_tree_finds_what_asking_every_facet_finds() {
        for center in [[20.0, -40.0], [-20.0, 40.0]] {
            let ring = Ring {
                center,
                inner: 0.4,
                outer: 1.0,
                angles: None,
                cells: [5, 1],
                ratio: 1.0,
                grade: 1.0,
                cell: CellKind::Quad9,
                diagonals: Default::default(),
            };
            check_search(&ring.build().unwrap(), center);
        }
        let cuboid = Cuboid {
            from: [-1.0; 3],
            to: [1.0; 3],
            cells: [2, 3, 2],
            cell: CellKind::Hex8,
        };
        let warped = cuboid
            .build()
            .unwrap()
            .map_points(|[x, y, z]| [x + 0.1 * y * z, y, z + 0.1 * x * y]);
        check_search(&warped.unwrap(), [0.0; 3]);
    }

    #[test]
    fn of_two_facets_at_the_same_distance_the_first_is_opposite() {
        let body = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
        let facets = body.mesh.side("bottom").unwrap();
        let search = SideSearch::new(&body.mesh, &body.mesh, facets);
        let hit = search.opposite(up(1.0, -0.5), 1.0).unwrap();
        assert_eq!((hit.facet, hit.distance), (facets[0], 0.5));
    }

    #[test]
    fn what_begins_at_an_edge_that_the_line_touches_behind_its_own_body_is_no_partner() {
        let triangle = |points: [Point<2>; 3]| {
            let block = CellBlock {
                kind: CellKind::Tri3,
                nodes: vec![0, 1, 2],
                group: None,
            };
            Mesh::new(points.to_vec(), vec![block]).unwrap()
        };
        let own = triangle([[0.0, 0.0], [1.0, 1.0], [-1.0, 1.0]]);
        // beside it, with a corner at its lower one; the lower side of that faces up
        let beside = |x: f64| triangle([[x, 0.0], [x + 2.0, 0.5], [x + 2.0, 1.0]]);
        let met = |x: f64| {
            let other = beside(x);
            let search = SideSearch::new(&own, &other, &other.boundary_facets());
            search.opposite(up(0.0, 1.0), 2.0)
        };
        assert_eq!(met(0.0), None);
        // a little to either side: beside the line, and the line enters it before
        assert_eq!(met(0.1), None);
        assert_eq!(met(-0.1), None);
        // one in which the line begins is overlapped, up to its lower side
        let around = triangle([[0.0, 0.0], [2.0, 0.5], [-2.0, 3.0]]);
        let search = SideSearch::new(&own, &around, &around.boundary_facets());
        let hit = search.opposite(up(0.1, 1.0), 2.0).unwrap();
        assert!((hit.distance + 0.975).abs() < 1e-14, "{hit:?}");
    }

    #[test]
    fn a_deep_overlap_counts_while_the_line_is_inside_its_own_body() {
        // at any scale; the lines start at the top of the lower body
        for scale in [1e-5, 1.0, 1e5] {
            let place = |x: Point<2>| x.map(|c| scale * c);
            let build = |from, to| block(from, to, CellKind::Quad4).map_points(place).unwrap();
            let (thin, thick) = (
                build([0.0, 0.95], [4.0, 1.0]),
                build([0.0, 0.0], [4.0, 1.0]),
            );
            let upper = build([0.0, 0.9], [4.0, 2.0]);
            let facets = upper.side("bottom").unwrap();
            let line = up(1.3 * scale, scale);
            for (own, shallow, found) in [
                (&thin, 0.105, true),
                (&thin, 0.095, false),
                (&thick, 0.095, true),
            ] {
                let search = SideSearch::new(own, &upper, facets);
                let hit = search.opposite(line, shallow * scale);
                assert_eq!(hit.is_some(), found, "{scale} {shallow}");
                if let Some(hit) = hit {
                    assert!((hit.distance + 0.1 * scale).abs() < 1e-14 * scale);
                }
            }
        }
    }
}
