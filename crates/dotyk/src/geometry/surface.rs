//! Analytic surfaces: planes, circles or spheres, cylinders and cones, with their closest points and intersections with lines.
//!
//! A surface has no inside: its user knows on which side of it the material lies.
//!
//! A cone with the apex a, the axis d and half the angle β: with h = (x − a)·d along the axis and ρ across it
//!
//! ```text
//!   distance = ρ cos β − h sin β      where h cos β + ρ sin β ≥ 0, else |x − a|
//! ```

use crate::geometry::{Point, add_scaled, distance, dot, norm, sub, unit};

/// A surface given by its equation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Surface<const D: usize> {
    /// A line of the plane, or a plane of space.
    Plane {
        /// A point on it.
        point: Point<D>,
        /// Unit normal.
        normal: Point<D>,
    },
    /// A circle of the plane, or a sphere of space.
    Sphere {
        /// Its centre.
        center: Point<D>,
        /// Its radius, > 0.
        radius: f64,
    },
    /// A cylinder of space without end.
    Cylinder {
        /// A point of its axis.
        point: Point<D>,
        /// Unit vector along the axis.
        axis: Point<D>,
        /// Its radius, > 0.
        radius: f64,
    },
    /// A cone of space that opens without end from its apex.
    Cone {
        /// Its apex.
        apex: Point<D>,
        /// Unit vector from the apex along the axis into the cone.
        axis: Point<D>,
        /// Angle between axis and surface in radians, in (0, π/2).
        half_angle: f64,
    },
}

impl<const D: usize> Surface<D> {
    /// Unit normal at the point of the surface that is nearest to a point: the given one of a plane, outward on a sphere,
    /// cylinder or cone. `None` at the centre of a sphere and on the axis of a cylinder or cone.
    pub fn normal(&self, near: Point<D>) -> Option<Point<D>> {
        match *self {
            Self::Plane { normal, .. } => Some(normal),
            Self::Sphere { center, .. } => unit(sub(near, center)),
            Self::Cylinder { point, axis, .. } => unit(across(sub(near, point), axis)),
            Self::Cone {
                apex,
                axis,
                half_angle,
            } => {
                let from = sub(near, apex);
                if before_apex(from, axis, half_angle) {
                    return unit(from);
                }
                let outward = unit(across(from, axis))?;
                let (sin, cos) = half_angle.sin_cos();
                Some(add_scaled(outward.map(|c| cos * c), -sin, axis))
            }
        }
    }

    /// Signed distance from the surface, positive on the side of its normal.
    pub fn distance(&self, point: Point<D>) -> f64 {
        match *self {
            Self::Plane { point: on, normal } => dot(sub(point, on), normal),
            Self::Sphere { center, radius } => distance(point, center) - radius,
            Self::Cylinder {
                point: on,
                axis,
                radius,
            } => norm(across(sub(point, on), axis)) - radius,
            Self::Cone {
                apex,
                axis,
                half_angle,
            } => {
                let from = sub(point, apex);
                if before_apex(from, axis, half_angle) {
                    return norm(from);
                }
                let (sin, cos) = half_angle.sin_cos();
                cos * norm(across(from, axis)) - sin * dot(from, axis)
            }
        }
    }

    /// The point of the surface nearest to a point; the point itself if there is no normal.
    pub fn closest(&self, point: Point<D>) -> Point<D> {
        match self.normal(point) {
            Some(normal) => add_scaled(point, -self.distance(point), normal),
            None => point,
        }
    }

    /// Parameters s of the intersections x + s·direction, ascending; the direction has unit length.
    pub fn intersections(&self, x: Point<D>, direction: Point<D>) -> Vec<f64> {
        match *self {
            Self::Plane { normal, .. } => {
                let slope = dot(direction, normal);
                let s = -self.distance(x) / slope;
                if s.is_finite() { vec![s] } else { Vec::new() }
            }
            Self::Sphere { center, radius } => round(sub(x, center), direction, radius),
            Self::Cylinder {
                point,
                axis,
                radius,
            } => {
                // in the plane across the axis it is a circle, and a step along the line is shorter
                let step = across(direction, axis);
                let Some(along) = unit(step) else {
                    return Vec::new();
                };
                let hits = round(across(sub(x, point), axis), along, radius);
                hits.into_iter().map(|s| s / norm(step)).collect()
            }
            Self::Cone {
                apex,
                axis,
                half_angle,
            } => through_cone(sub(x, apex), direction, axis, half_angle),
        }
    }
}

/// As [`Surface::intersections`] of a circle or sphere about the origin.
fn round<const D: usize>(from: Point<D>, direction: Point<D>, radius: f64) -> Vec<f64> {
    let half = -dot(from, direction);
    let foot = add_scaled(from, half, direction);
    // (r − |foot|)(r + |foot|): the difference of squares would lose a shallow sagitta
    let rest = norm(foot);
    let square = (radius - rest) * (radius + rest);
    if square < 0.0 {
        return Vec::new();
    }
    let root = square.sqrt();
    let far = half + root.copysign(half);
    // the product of both roots is the power of the point: the near one without cancellation
    let power = (norm(from) - radius) * (norm(from) + radius);
    let near = if far == 0.0 { 0.0 } else { power / far };
    vec![near.min(far), near.max(far)]
}

/// Whether the apex of a cone is its point nearest to one at this vector from it.
fn before_apex<const D: usize>(from: Point<D>, axis: Point<D>, half_angle: f64) -> bool {
    let (sin, cos) = half_angle.sin_cos();
    cos * dot(from, axis) + sin * norm(across(from, axis)) < 0.0
}

/// As [`Surface::intersections`] of a cone with its apex in the origin: cos²β |v|² = (v·d)², v·d ≥ 0.
fn through_cone<const D: usize>(
    from: Point<D>,
    direction: Point<D>,
    axis: Point<D>,
    half_angle: f64,
) -> Vec<f64> {
    let (sin, cos) = half_angle.sin_cos();
    let (height, slope) = (dot(from, axis), dot(direction, axis));
    let across = norm(across(from, axis));
    let square = (cos - slope) * (cos + slope);
    let half = cos * cos * dot(from, direction) - height * slope;
    // the squares of ρ cos β and h sin β, whose difference is small beside the cone
    let constant = (cos * across - sin * height) * (cos * across + sin * height);
    let root = (half * half - square * constant).sqrt();
    if root.is_nan() {
        return Vec::new();
    }
    // the sum of like signs: the other root is the quotient of the product
    let sum = -(half + root.copysign(half));
    let roots = [sum / square, constant / sum];
    let on = |s: &f64| s.is_finite() && height + s * slope >= 0.0;
    let mut hits: Vec<f64> = roots.into_iter().filter(on).collect();
    hits.sort_by(f64::total_cmp);
    hits
}

/// The part of a vector perpendicular to a unit vector.
fn across<const D: usize>(vector: Point<D>, axis: Point<D>) -> Point<D> {
    add_scaled(vector, -dot(vector, axis), axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_meet_a_circle_where_its_equation_holds() {
        let circle = Surface::Sphere {
            center: [1.0, -2.0],
            radius: 3.0,
        };
        for k in 0..20 {
            let angle = f64::from(k);
            let direction = [angle.cos(), angle.sin()];
            for x in [[1.5, -1.0], [4.0, -2.0], [8.0, 3.0], [1.0, -2.0]] {
                for s in circle.intersections(x, direction) {
                    let hit = add_scaled(x, s, direction);
                    assert!(circle.distance(hit).abs() < 1e-13);
                }
            }
            assert_eq!(circle.intersections([1.5, -1.0], direction).len(), 2);
        }
        assert!(circle.intersections([9.0, 9.0], [1.0, 0.0]).is_empty());
    }

    #[test]
    fn a_point_just_off_a_large_circle_keeps_its_small_distance() {
        // With a radius of 1e6 a distance of 1e-6 loses most digits to rounding of the coordinates, but not all.
        let circle = Surface::Sphere {
            center: [0.0, 0.0],
            radius: 1e6,
        };
        let near = circle.intersections([1e6 - 1e-6, 0.0], [1.0, 0.0]);
        assert!((near[1] - 1e-6).abs() < 1e-9, "{near:?}");
    }

    #[test]
    fn closest_points_lie_on_the_surface_along_its_normal() {
        let plane = Surface::Plane {
            point: [0.0, 1.0],
            normal: [0.6, 0.8],
        };
        let closest = plane.closest([3.0, 5.0]);
        assert!(plane.distance(closest).abs() < 1e-15);
        assert!((plane.distance([3.0, 5.0]) - 5.0).abs() < 1e-15);
        let sphere = Surface::Sphere {
            center: [0.0; 3],
            radius: 2.0,
        };
        let closest = sphere.closest([0.0, 3.0, 4.0]);
        assert!((norm(closest) - 2.0).abs() < 1e-15);
        assert_eq!(sphere.normal([0.0; 3]), None);
    }

    #[test]
    fn a_cone_is_met_where_the_angle_to_its_axis_is_its_own() {
        let axis = unit([0.3, -0.4, 1.2]).unwrap();
        let (apex, half_angle) = ([0.2, -0.5, 1.0], 0.6_f64);
        let cone = Surface::Cone {
            apex,
            axis,
            half_angle,
        };
        let angle = |x: Point<3>| (dot(sub(x, apex), axis) / norm(sub(x, apex))).acos();
        let mut met = 0;
        for k in 0..40 {
            let turn = f64::from(k);
            let direction = unit([turn.cos(), turn.sin(), (2.0 * turn).sin()]).unwrap();
            for x in [[0.5, 0.1, 2.5], [4.0, 2.0, 1.0], [-3.0, 0.0, -2.0]] {
                let closest = cone.closest(x);
                assert!(cone.distance(closest).abs() < 1e-13);
                assert!((distance(x, closest) - cone.distance(x).abs()).abs() < 1e-13);
                let hits = cone.intersections(x, direction);
                assert!(hits.is_sorted());
                for s in hits {
                    met += 1;
                    let hit = add_scaled(x, s, direction);
                    assert!((angle(hit) - half_angle).abs() < 1e-11, "{hit:?}");
                    // no neighbouring point of the surface is nearer than the closest one
                    assert!(distance(x, hit) > distance(x, closest) - 1e-12);
                }
                // outside the angle is larger than that of the cone
                let outside = angle(x) > half_angle;
                assert_eq!(cone.distance(x) > 0.0, outside, "{x:?}");
            }
        }
        assert!(met > 40, "{met}");
        // behind the apex it is the nearest point, and along the axis only the apex is met
        let behind = add_scaled(apex, -2.0, axis);
        assert!((cone.distance(behind) - 2.0).abs() < 1e-14);
        assert!(distance(cone.closest(behind), apex) < 1e-14);
        let hits = cone.intersections(behind, axis);
        assert!(hits.iter().all(|s| (s - 2.0).abs() < 1e-7), "{hits:?}");
        let upright = Surface::Cone {
            apex: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            half_angle,
        };
        assert_eq!(upright.normal([0.0, 0.0, 2.0]), None);
    }

    #[test]
    fn a_cylinder_is_met_at_its_radius_from_its_axis() {
        let axis = unit([1.0, -2.0, 0.5]).unwrap();
        let on = [0.3, 0.2, -0.7];
        let cylinder = Surface::Cylinder {
            point: on,
            axis,
            radius: 1.5,
        };
        for k in 0..20 {
            let angle = f64::from(k);
            let direction = unit([angle.cos(), angle.sin(), (2.0 * angle).sin()]).unwrap();
            for x in [[0.5, 0.1, -0.5], [4.0, 2.0, 1.0], [-3.0, 0.0, 2.0]] {
                let from_axis = |x: Point<3>| norm(crate::geometry::cross(sub(x, on), axis));
                assert!((cylinder.distance(x) - from_axis(x) + 1.5).abs() < 1e-14);
                assert!(cylinder.distance(cylinder.closest(x)).abs() < 1e-14);
                for s in cylinder.intersections(x, direction) {
                    assert!((from_axis(add_scaled(x, s, direction)) - 1.5).abs() < 1e-12);
                }
            }
            // from inside a line leaves at both ends
            let inside = cylinder.intersections([0.5, 0.1, -0.5], direction);
            assert!(inside.len() == 2 && inside[0] < 0.0 && inside[1] > 0.0);
        }
        assert!(cylinder.intersections([0.0; 3], axis).is_empty());
        assert_eq!(cylinder.normal(on), None);
    }
}
