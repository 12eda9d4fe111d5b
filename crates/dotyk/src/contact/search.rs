//! What lies opposite a point: intersections of lines with the facets of a side, found through a tree of their boxes.
//!
//! A point x with outward normal n faces the facet that the line x + s·n meets nearest to x (smallest |s|), if the
//! outward normal there is opposed to n. Behind x (s < 0) the bodies overlap; that counts only where the line is still
//! inside x's own body, so that the far side of the other body is not taken for an overlap.
//! Cost: O(log n) for each line.

use crate::geometry::{Point, add_scaled, bounding_box, distance, dot, invert, norm, sub};
use crate::mesh::{CellKind, Domain, Facet, Mesh};
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};
use std::sync::OnceLock;

/// Facets count as opposed when the cosine between the normals is below this.
const OPPOSED: f64 = -0.1;

/// A line may miss the end of a facet by this much in its reference coordinate: rounding, not more.
const END: f64 = 1e-9;

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

/// Some facets of a mesh, ready to be met by lines.
struct Screen<'a, const D: usize> {
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

/// Whether a line meets a box: the interval of s in which it is between the faces of every axis is not empty.
fn meets_box<const D: usize>(line: Line<D>, low: Point<D>, high: Point<D>) -> bool {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
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

/// Whether a box may meet some line between two lines of the plane: not when it lies beyond both on the same hand.
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
    fn new(mesh: &'a Mesh<D>, facets: &[Facet]) -> Self {
        let boxes = facets.iter().map(|&facet| {
            let mut points: Vec<Point<D>> = mesh.facet_points(facet).collect();
            if let (CellKind::Line3, [a, b, middle]) = (mesh.facet_kind(facet), &points[..]) {
                // a parabola lies in the hull of its ends and this control point
                let ends = add_scaled(*a, 1.0, *b);
                points[2] = add_scaled(middle.map(|c| 2.0 * c), -0.5, ends);
            }
            let (low, high) = bounding_box(&points);
            let margin = END * distance(low, high);
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

    /// All hits of a line whose outward normal satisfies a condition on its cosine with the line.
    fn hits(&self, line: Line<D>, cosine: impl Fn(f64) -> bool) -> impl Iterator<Item = Hit> {
        let facets = self.select(|low, high| meets_box(line, low, high));
        facets.into_iter().filter_map(move |facet| {
            let hit = meet(self.mesh, facet, line)?;
            let normal = self.mesh.outward_normal(facet, &hit.xi);
            let inside = self.mesh.facet_kind(facet).domain().outside(&hit.xi) <= END;
            (inside && cosine(dot(normal, line.direction) / norm(normal))).then_some(hit)
        })
    }
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

/// Where a line meets a facet of space, from its middle by Newton's method for ξ and s; one step where the facet is plane.
fn meet_surface<const D: usize>(mesh: &Mesh<D>, facet: Facet, line: Line<D>) -> Option<[f64; 2]> {
    let [x, y, _] = mesh.facet_kind(facet).domain().centre();
    let (mut xi, mut s) = ([x, y], 0.0);
    for _ in 0..STEPS {
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
        if xi.iter().all(|c| c.is_finite()) && change[..2].iter().all(|c| c.abs() < SETTLED) {
            return Some(xi);
        }
    }
    None
}

/// Most steps to where a line meets a facet, and when they have settled, in reference coordinates.
const STEPS: usize = 20;
const SETTLED: f64 = 1e-12;

/// The root of αξ² + βξ + γ that is smaller in magnitude.
fn quadratic_root(alpha: f64, beta: f64, gamma: f64) -> Option<f64> {
    let discriminant = beta * beta - 4.0 * alpha * gamma;
    if discriminant < 0.0 {
        return None;
    }
    let q = -0.5 * (beta + discriminant.sqrt().copysign(beta));
    let root = if q == 0.0 { 0.0 } else { gamma / q };
    root.is_finite().then_some(root)
}

/// The search from points of one body for a side of another.
pub(crate) struct Search<'a, const D: usize> {
    own: &'a Mesh<D>,
    other: Screen<'a, D>,
    /// The whole boundary of the own body, needed only for deep overlaps.
    boundary: OnceLock<Screen<'a, D>>,
}

impl<'a, const D: usize> Search<'a, D> {
    /// Prepares a search from `own` for these facets of `other`.
    pub fn new(own: &'a Mesh<D>, other: &'a Mesh<D>, facets: &[Facet]) -> Self {
        Self {
            own,
            other: Screen::new(other, facets),
            boundary: OnceLock::new(),
        }
    }

    /// What lies opposite a point with this outward normal; overlaps up to `shallow` are believed without asking whether
    /// the line is still inside the own body.
    pub fn opposite(&self, line: Line<D>, shallow: f64) -> Option<Hit> {
        let hits = self.other.hits(line, |cosine| cosine < OPPOSED);
        let mut best: Option<Hit> = None;
        for hit in hits {
            let nearer = best.is_none_or(|b| hit.distance.abs() < b.distance.abs());
            if nearer && (hit.distance >= -shallow || -hit.distance <= self.depth(line, shallow)) {
                best = Some(hit);
            }
        }
        best
    }

    /// How far the line against its direction stays inside the own body.
    fn depth(&self, line: Line<D>, shallow: f64) -> f64 {
        let boundary = self
            .boundary
            .get_or_init(|| Screen::new(self.own, &self.own.boundary_facets()));
        let behind = boundary
            .hits(line, |cosine| cosine < 0.0)
            .map(|hit| -hit.distance);
        let leaving = behind.filter(|depth| *depth > 1e-6 * shallow);
        leaving.fold(f64::INFINITY, f64::min)
    }
}

impl Search<'_, 2> {
    /// Facets of the other side that lines between these two may meet.
    pub fn between(&self, lines: [Line<2>; 2]) -> Vec<Facet> {
        let meets = |low, high| meets_between(lines, low, high);
        self.other.select(meets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Rectangle};

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
            let search = Search::new(&lower, &upper, facets);
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
        let search = Search::new(&lower, &upper, &all);
        let overlap = search.opposite(up(1.3, 1.0), 0.01).unwrap();
        assert!((overlap.distance + 0.1).abs() < 1e-14);
        // from the bottom, looking down: the top of the upper body is behind, but outside the lower one
        let down = Line {
            start: [1.3, 0.0],
            direction: [0.0, -1.0],
        };
        assert_eq!(search.opposite(down, 0.01), None);
    }
}
