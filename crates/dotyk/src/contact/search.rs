//! What lies opposite a point: intersections of lines with the facets of a side, found through a tree of their boxes.
//!
//! A point x with outward normal n faces the facet that the line x + s·n meets nearest to x (smallest |s|), if the
//! outward normal there is opposed to n. Behind x (s < 0) the bodies overlap; that counts only where the line is still
//! inside x's own body, so that the far side of the other body is not taken for an overlap.
//! Cost: O(log n) for each line. Plane meshes only.

use crate::geometry::{Point, add_scaled, bounding_box, dot, norm, sub};
use crate::mesh::{Facet, Mesh};
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
    /// Reference coordinate on it.
    pub xi: f64,
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
    /// Component of x − start across the line (positive on the right).
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
    tree: RTree<Boxed>,
}

struct Boxed {
    facet: Facet,
    envelope: AABB<[f64; 2]>,
}

impl RTreeObject for Boxed {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

/// Selects the boxes that may meet some line between two lines.
struct Between<const D: usize>([Line<D>; 2]);

impl<const D: usize> Between<D> {
    /// False when the whole box lies beyond both lines on the same hand.
    fn meets(&self, envelope: &AABB<[f64; 2]>) -> bool {
        let (low, high) = (envelope.lower(), envelope.upper());
        let hand = |line: &Line<D>| {
            let corner = |x: f64, y: f64| {
                let mut corner = line.start;
                (corner[0], corner[1]) = (x, y);
                line.across(corner)
            };
            let corners = [
                corner(low[0], low[1]),
                corner(high[0], low[1]),
                corner(low[0], high[1]),
                corner(high[0], high[1]),
            ];
            match corners.iter().all(|c| *c > 0.0) {
                true => 1,
                false if corners.iter().all(|c| *c < 0.0) => -1,
                false => 0,
            }
        };
        hand(&self.0[0]) * hand(&self.0[1]) != 1
    }
}

impl<const D: usize> SelectionFunction<Boxed> for Between<D> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 2]>) -> bool {
        self.meets(envelope)
    }

    fn should_unpack_leaf(&self, leaf: &Boxed) -> bool {
        self.meets(&leaf.envelope)
    }
}

impl<'a, const D: usize> Screen<'a, D> {
    fn new(mesh: &'a Mesh<D>, facets: &[Facet]) -> Self {
        let boxes = facets.iter().map(|&facet| {
            let mut points: Vec<Point<D>> = mesh.facet_points(facet).collect();
            if let [a, b, middle] = points[..] {
                // a parabola lies in the hull of its ends and this control point
                let ends = add_scaled(a, 1.0, b);
                points[2] = add_scaled(middle.map(|c| 2.0 * c), -0.5, ends);
            }
            let (low, high) = bounding_box(&points);
            let margin = END * (high[0] - low[0]).hypot(high[1] - low[1]);
            let envelope = AABB::from_corners(
                [low[0] - margin, low[1] - margin],
                [high[0] + margin, high[1] + margin],
            );
            Boxed { facet, envelope }
        });
        let tree = RTree::bulk_load(boxes.collect());
        Self { mesh, tree }
    }

    /// Facets that some line between two lines may meet, in ascending order.
    fn between(&self, lines: [Line<D>; 2]) -> Vec<Facet> {
        let found = self.tree.locate_with_selection_function(Between(lines));
        let mut facets: Vec<Facet> = found.map(|boxed| boxed.facet).collect();
        facets.sort_unstable();
        facets
    }

    /// All hits of a line whose outward normal satisfies a condition on its cosine with the line.
    fn hits(&self, line: Line<D>, cosine: impl Fn(f64) -> bool) -> impl Iterator<Item = Hit> {
        let facets = self.between([line; 2]).into_iter();
        facets.filter_map(move |facet| {
            let hit = meet(self.mesh, facet, line)?;
            let normal = self.mesh.outward_normal(facet, &[hit.xi]);
            let inside = hit.xi.abs() <= 1.0 + END;
            (inside && cosine(dot(normal, line.direction) / norm(normal))).then_some(hit)
        })
    }
}

/// Where a line meets a facet or its continuation, nearest to the facet's middle; `None` when it does not.
pub(crate) fn meet<const D: usize>(mesh: &Mesh<D>, facet: Facet, line: Line<D>) -> Option<Hit> {
    let mut across = [0.0; 3];
    let mut count = 0;
    for (value, point) in across.iter_mut().zip(mesh.facet_points(facet)) {
        *value = line.across(point);
        count += 1;
    }
    let [a, b, middle] = across;
    let xi = match count {
        2 => (a + b) / (a - b),
        _ => quadratic_root(0.5 * (a + b) - middle, 0.5 * (b - a), middle)?,
    };
    let distance = line.along(mesh.facet_point(facet, &[xi]));
    distance.is_finite().then_some(Hit {
        facet,
        xi,
        distance,
    })
}

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

    /// Facets of the other side that lines between these two may meet.
    pub fn between(&self, lines: [Line<D>; 2]) -> Vec<Facet> {
        self.other.between(lines)
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
            let [x, _] = upper.facet_point(hit.facet, &[hit.xi]);
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
