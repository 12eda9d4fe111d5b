//! Straight lines and circular arcs: points, distances, nearest points of two of them.
//!
//! An arc is its centre, radius, angle of its start and signed sweep (counter-clockwise > 0, below a full turn); its
//! ends are kept as given. The parameter t in [0, 1] runs with the length. Angles are in radians.

use crate::geometry::{Point, Surface, add_scaled, bounding_box, distance, dot, sub, unit};
use std::f64::consts::TAU;

/// z of the product of two plane vectors.
pub(crate) fn cross(a: Point<2>, b: Point<2>) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The vector turned by +90°.
fn turned([x, y]: Point<2>) -> Point<2> {
    [-y, x]
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arc {
    pub center: Point<2>,
    pub radius: f64,
    /// Angle of the start.
    pub first: f64,
    /// Angle of the end, up to full turns.
    pub last: f64,
    /// Signed angle from start to end.
    pub sweep: f64,
}

/// A directed line or arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Curve {
    pub start: Point<2>,
    pub end: Point<2>,
    pub arc: Option<Arc>,
}

impl Curve {
    pub fn line(start: Point<2>, end: Point<2>) -> Self {
        let arc = None;
        Self { start, end, arc }
    }

    /// The arc about a centre, which is moved to equalise its distances from the two ends.
    pub fn arc(start: Point<2>, end: Point<2>, center: Point<2>, clockwise: bool) -> Self {
        if clockwise {
            // So that both ways of drawing an arc give the same numbers.
            return Self::arc(end, start, center, false).reversed();
        }
        // On the perpendicular bisector of the ends both radii are the same number.
        let chord = sub(end, start);
        let middle = add_scaled(start, 0.5, chord);
        let center = match unit(chord) {
            Some(along) => add_scaled(center, dot(sub(middle, center), along), along),
            None => center,
        };
        let [first, last] = [start, end].map(|p| {
            let d = sub(p, center);
            d[1].atan2(d[0])
        });
        let arc = Arc {
            center,
            radius: 0.5 * (distance(start, center) + distance(end, center)),
            first,
            last,
            sweep: (last - first).rem_euclid(TAU),
        };
        Self {
            start,
            end,
            arc: Some(arc),
        }
    }

    /// The four quarters of a circle, counter-clockwise from its rightmost point.
    pub fn quarters(center: Point<2>, radius: f64) -> [Self; 4] {
        let corners = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let corners = corners.map(|direction| add_scaled(center, radius, direction));
        std::array::from_fn(|k| {
            let arc = Arc {
                center,
                radius,
                first: 0.25 * TAU * k as f64,
                last: 0.25 * TAU * (k + 1) as f64,
                sweep: 0.25 * TAU,
            };
            Self {
                start: corners[k],
                end: corners[(k + 1) % 4],
                arc: Some(arc),
            }
        })
    }

    pub fn reversed(&self) -> Self {
        let arc = self.arc.map(|arc| Arc {
            first: arc.last,
            last: arc.first,
            sweep: -arc.sweep,
            ..arc
        });
        Self {
            start: self.end,
            end: self.start,
            arc,
        }
    }

    /// The circle that an arc is a part of.
    pub fn circle(&self) -> Option<Surface<2>> {
        let Arc { center, radius, .. } = self.arc?;
        Some(Surface::Sphere { center, radius })
    }

    /// Whether the curve runs in the direction in which it is divided: the same for a curve and its reverse.
    pub fn is_canonical(&self) -> bool {
        match self.arc {
            Some(arc) => arc.sweep > 0.0,
            None => self.start < self.end,
        }
    }

    pub fn length(&self) -> f64 {
        match self.arc {
            Some(arc) => arc.radius * arc.sweep.abs(),
            None => distance(self.start, self.end),
        }
    }

    /// The point at t; both ends exactly.
    pub fn point(&self, t: f64) -> Point<2> {
        match self.arc {
            _ if t == 0.0 => self.start,
            _ if t == 1.0 => self.end,
            Some(arc) => {
                let (sin, cos) = (arc.first + t * arc.sweep).sin_cos();
                add_scaled(arc.center, arc.radius, [cos, sin])
            }
            None => std::array::from_fn(|d| (1.0 - t) * self.start[d] + t * self.end[d]),
        }
    }

    /// Unit normal to the left of the direction of travel.
    pub fn left(&self, t: f64) -> Point<2> {
        match self.arc {
            Some(arc) => {
                let (sin, cos) = (arc.first + t * arc.sweep).sin_cos();
                [-cos, -sin].map(|c| c * arc.sweep.signum())
            }
            None => turned(unit(sub(self.end, self.start)).unwrap_or([0.0; 2])),
        }
    }

    /// The point of the curve that is nearest to p.
    pub fn nearest(&self, p: Point<2>) -> Point<2> {
        let Some(arc) = self.arc else {
            let along = sub(self.end, self.start);
            let t = dot(sub(p, self.start), along) / dot(along, along);
            return self.point(t.clamp(0.0, 1.0));
        };
        let d = sub(p, arc.center);
        let angle = d[1].atan2(d[0]);
        let turn = match arc.sweep > 0.0 {
            true => (angle - arc.first).rem_euclid(TAU),
            false => (arc.first - angle).rem_euclid(TAU),
        };
        match unit(d) {
            Some(direction) if turn <= arc.sweep.abs() => {
                add_scaled(arc.center, arc.radius, direction)
            }
            _ if distance(p, self.start) <= distance(p, self.end) => self.start,
            _ => self.end,
        }
    }

    /// The parameter of a point of the curve.
    pub fn parameter(&self, p: Point<2>) -> f64 {
        let Some(arc) = self.arc else {
            let along = sub(self.end, self.start);
            return (dot(sub(p, self.start), along) / dot(along, along)).clamp(0.0, 1.0);
        };
        let d = sub(p, arc.center);
        let turn = (d[1].atan2(d[0]) - arc.first) * arc.sweep.signum();
        let (turn, sweep) = (turn.rem_euclid(TAU), arc.sweep.abs());
        match turn <= sweep {
            true => turn / sweep,
            // Rounding puts it before the start or after the end.
            false if TAU - turn < turn - sweep => 0.0,
            false => 1.0,
        }
    }

    /// The part between two parameters, with these ends.
    pub fn part(&self, [from, to]: [f64; 2], [start, end]: [Point<2>; 2]) -> Self {
        let arc = self.arc.map(|arc| Arc {
            first: if from == 0.0 {
                arc.first
            } else {
                arc.first + from * arc.sweep
            },
            last: if to == 1.0 {
                arc.last
            } else {
                arc.first + to * arc.sweep
            },
            sweep: if [from, to] == [0.0, 1.0] {
                arc.sweep
            } else {
                (to - from) * arc.sweep
            },
            ..arc
        });
        Self { start, end, arc }
    }

    /// Whether both are parts of one line or of one circle, up to distances `near`.
    pub fn runs_along(&self, other: &Self, near: f64) -> bool {
        match (self.arc, other.arc) {
            (Some(a), Some(b)) => {
                distance(a.center, b.center) <= near && (a.radius - b.radius).abs() <= near
            }
            (None, None) => {
                let Some(along) = unit(sub(self.end, self.start)) else {
                    return false;
                };
                let beside = |p: Point<2>| cross(along, sub(p, self.start)).abs();
                beside(other.start) <= near && beside(other.end) <= near
            }
            _ => false,
        }
    }

    /// Points where two curves cross or touch within `near`: at ends that lie on the other one, and elsewhere. Coincident curves
    /// meet only at their ends.
    pub fn meetings(&self, other: &Self, near: f64) -> Vec<Point<2>> {
        let on = |curve: &Self, p: Point<2>| distance(curve.nearest(p), p) <= near;
        let ends = [
            (self.start, other),
            (self.end, other),
            (other.start, self),
            (other.end, self),
        ];
        let ends = ends.into_iter().filter(|(p, curve)| on(curve, *p));
        let mut points: Vec<Point<2>> = ends.map(|(p, _)| p).collect();
        if self.runs_along(other, near) {
            return points;
        }
        // Intersections within a thousandth of an edge from there are rounding of a tangent arc.
        let margin = 1e-3 * self.length().min(other.length());
        for p in self.candidates(other) {
            let far = points.iter().all(|&q| distance(p, q) > margin);
            if far && on(self, p) && on(other, p) {
                points.push(p);
            }
        }
        points
    }

    /// Corners of a box that holds the curve.
    pub fn bounds(&self) -> (Point<2>, Point<2>) {
        let mut points = vec![self.start, self.end];
        if let Some(arc) = self.arc {
            for direction in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
                points.push(self.nearest(add_scaled(arc.center, arc.radius, direction)));
            }
        }
        bounding_box(&points)
    }

    /// Twice the area that the curve sweeps about a point, counter-clockwise > 0.
    pub fn twice_area(&self, about: Point<2>) -> f64 {
        let chord = cross(sub(self.start, about), sub(self.end, about));
        let bulge = |arc: Arc| arc.radius * arc.radius * (arc.sweep - arc.sweep.sin());
        chord + self.arc.map_or(0.0, bulge)
    }

    /// Angle by which the direction from p turns along the curve, p not on it.
    pub fn winding(&self, p: Point<2>) -> f64 {
        let (a, b) = (sub(self.start, p), sub(self.end, p));
        let chord = cross(a, b).atan2(dot(a, b));
        let Some(arc) = self.arc else {
            return chord;
        };
        // Between chord and arc, the arc passes on the other side of p than the chord.
        let side = cross(sub(self.end, self.start), sub(p, self.start));
        let within = distance(p, arc.center) < arc.radius && side * arc.sweep < 0.0;
        chord + if within { TAU.copysign(arc.sweep) } else { 0.0 }
    }

    /// The nearest points of two curves, without those within `margin` of `corners`: (distance, point).
    pub fn approach(
        &self,
        other: &Self,
        corners: &[Point<2>],
        margin: f64,
    ) -> Option<(f64, Point<2>)> {
        self.candidates(other)
            .into_iter()
            .map(|p| {
                let on_this = self.nearest(p);
                (distance(on_this, other.nearest(on_this)), on_this)
            })
            .filter(|(_, p)| corners.iter().all(|&c| distance(*p, c) > margin))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Points among which is one where the distance of the two curves is smallest.
    fn candidates(&self, other: &Self) -> Vec<Point<2>> {
        let mut points = vec![self.start, self.end, other.start, other.end];
        match (self.arc, other.arc) {
            (None, None) => {
                let (u, v) = (sub(self.end, self.start), sub(other.end, other.start));
                let t = cross(sub(other.start, self.start), v) / cross(u, v);
                if (0.0..=1.0).contains(&t) {
                    points.push(add_scaled(self.start, t, u));
                }
            }
            (Some(arc), None) => line_and_circle(other, arc, &mut points),
            (None, Some(arc)) => line_and_circle(self, arc, &mut points),
            (Some(a), Some(b)) => two_circles(a, b, &mut points),
        }
        points
    }
}

fn line_and_circle(line: &Curve, arc: Arc, points: &mut Vec<Point<2>>) {
    let Some(along) = unit(sub(line.end, line.start)) else {
        return;
    };
    let foot = add_scaled(line.start, dot(sub(arc.center, line.start), along), along);
    let normal = turned(along);
    let half = arc.radius * arc.radius - dot(sub(foot, arc.center), sub(foot, arc.center));
    for sign in [-1.0, 1.0] {
        points.push(add_scaled(arc.center, sign * arc.radius, normal));
        if half > 0.0 {
            points.push(add_scaled(foot, sign * half.sqrt(), along));
        }
    }
}

fn two_circles(a: Arc, b: Arc, points: &mut Vec<Point<2>>) {
    let between = distance(a.center, b.center);
    let Some(along) = unit(sub(b.center, a.center)) else {
        return;
    };
    let from_a = (between * between + a.radius * a.radius - b.radius * b.radius) / (2.0 * between);
    let half = a.radius * a.radius - from_a * from_a;
    for sign in [-1.0, 1.0] {
        points.push(add_scaled(a.center, sign * a.radius, along));
        points.push(add_scaled(b.center, sign * b.radius, along));
        if half > 0.0 {
            let foot = add_scaled(a.center, from_a, along);
            points.push(add_scaled(foot, sign * half.sqrt(), turned(along)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_nearest_point_of_an_arc_is_on_it_or_an_end() {
        let arc = Curve::arc([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], false);
        let near = arc.nearest([2.0, 2.0]);
        assert!(distance(near, [0.5_f64.sqrt(); 2]) < 1e-15);
        assert_eq!(arc.nearest([-1.0, 0.5]), [0.0, 1.0]);
        let long = Curve::arc([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], true);
        assert!(distance(long.nearest([-2.0, 0.0]), [-1.0, 0.0]) < 1e-15);
        assert!((long.length() - 1.5 * PI).abs() < 1e-14);
    }

    #[test]
    fn winding_counts_a_point_between_chord_and_arc_as_inside() {
        let circle = Curve::quarters([3.0, 4.0], 2.0);
        let turns = |p| circle.iter().map(|c| c.winding(p)).sum::<f64>() / TAU;
        for (p, inside) in [
            ([3.0, 4.0], 1.0),
            ([4.41, 5.41], 1.0),
            ([4.42, 5.42], 0.0),
            ([0.9, 4.0], 0.0),
        ] {
            assert!((turns(p) - inside).abs() < 1e-12, "{p:?}");
        }
    }

    #[test]
    fn two_curves_come_nearest_where_they_cross_or_along_the_line_of_centers() {
        let a = Curve::quarters([0.0, 0.0], 1.0)[0];
        let b = Curve::quarters([3.0, 3.0], 1.0)[2];
        let (gap, _) = a.approach(&b, &[], 0.0).unwrap();
        assert!((gap - (18.0_f64.sqrt() - 2.0)).abs() < 1e-14);
        let cut = Curve::line([0.5, 0.0], [0.5, 2.0]);
        let (gap, at) = a.approach(&cut, &[], 0.0).unwrap();
        assert!(gap < 1e-15 && distance(at, [0.5, 0.75_f64.sqrt()]) < 1e-15);
    }

    #[test]
    fn the_area_of_a_circle_is_that_of_its_quarters() {
        let circle = Curve::quarters([1.0, -2.0], 3.0);
        let twice: f64 = circle.iter().map(|c| c.twice_area([0.5, 0.5])).sum();
        assert!((twice - 18.0 * PI).abs() < 1e-13 * twice);
    }

    #[test]
    fn parts_of_an_arc_are_arcs_between_their_points() {
        for clockwise in [false, true] {
            let whole = Curve::arc([1.0, 0.0], [0.0, -1.0], [0.0, 0.0], clockwise);
            for t in [0.0, 0.3, 0.99, 1.0] {
                assert!((whole.parameter(whole.point(t)) - t).abs() < 1e-15);
            }
            let places = [whole.point(0.25), whole.point(0.75)];
            let part = whole.part([0.25, 0.75], places);
            assert!((part.length() - 0.5 * whole.length()).abs() < 1e-15);
            assert!(distance(part.point(0.5), whole.point(0.5)) < 1e-15);
        }
    }

    #[test]
    fn curves_meet_at_crossings_and_at_ends_that_lie_on_the_other_one() {
        let circle = Curve::quarters([0.0, 0.0], 2.0);
        let level = Curve::line([-3.0, 1.0], [3.0, 1.0]);
        let met = circle[0].meetings(&level, 1e-9);
        assert!(met.len() == 1 && distance(met[0], [3.0_f64.sqrt(), 1.0]) < 1e-15);
        // a tangent line that begins where the arc ends meets it there and nowhere else
        let tangent = Curve::line([2.0, 0.0], [2.0, -3.0]);
        assert_eq!(circle[0].meetings(&tangent, 1e-9), [[2.0, 0.0], [2.0, 0.0]]);
        // along each other
        let half = Curve::line([0.0, 1.0], [5.0, 1.0]);
        let mut met = level.meetings(&half, 1e-9);
        met.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(met, [[0.0, 1.0], [3.0, 1.0]]);
    }
}
