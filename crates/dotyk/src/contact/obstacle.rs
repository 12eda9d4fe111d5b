//! Rigid obstacles: the point of their surface opposite a point of a side, and their motion.

use crate::contact::{ContactError, End, Tool};
use crate::fem::show;
use crate::geometry::{Field, Point, Surface, add_scaled, dot, norm};
use std::sync::Arc;

/// The shape of a rigid obstacle.
#[derive(Debug, Clone)]
pub enum Rigid<const D: usize> {
    /// Its distance from the undeformed nonmortar point along the contact normal; negative is an interference.
    Gap(Field),
    /// A plane, or a sphere, which is a circle in the plane. The plane's normal points towards the body; a sphere is the
    /// obstacle, or with `inside` the hole in the obstacle.
    Surface {
        /// The surface.
        surface: Surface<D>,
        /// The body is inside the sphere.
        inside: bool,
    },
    /// A surface of facets.
    Tool(Arc<Tool<D>>),
}

impl<const D: usize> Rigid<D> {
    /// The point of the obstacle that lies opposite a point with this outward normal, or nearest to it: for drawing.
    pub fn drawn(&self, point: Point<D>, normal: Point<D>, time: f64) -> Point<D> {
        match self {
            Self::Gap(field) => add_scaled(point, field.at(point, time), normal),
            Self::Surface { surface, .. } => surface.closest(point),
            Self::Tool(tool) => tool.closest(point),
        }
    }

    /// Distance of a point from the obstacle, negative inside; `None` for a given gap, which is unknown for displaced points.
    pub fn distance(&self, point: Point<D>) -> Option<f64> {
        match self {
            Self::Gap(_) => None,
            Self::Surface { surface, inside } => {
                let outward = if *inside { -1.0 } else { 1.0 };
                Some(outward * surface.distance(point))
            }
            Self::Tool(tool) => Some(tool.distance(point)),
        }
    }

    /// The vector to the nearest point of the obstacle; `None` for a given gap.
    pub fn towards(&self, point: Point<D>) -> Option<Point<D>> {
        match self {
            Self::Gap(_) => None,
            Self::Surface { surface, inside } => {
                let normal = surface.normal(point)?;
                Some(if *inside { normal } else { normal.map(|c| -c) })
            }
            Self::Tool(tool) => Some(tool.normal(point)?.map(|c| -c)),
        }
    }

    /// The angle between its normals next to two points, in radians; zero where they are not known.
    pub fn turn(&self, a: Point<D>, b: Point<D>) -> f64 {
        match (self.towards(a), self.towards(b)) {
            (Some(a), Some(b)) => dot(a, b).clamp(-1.0, 1.0).acos(),
            _ => 0.0,
        }
    }

    /// Whether a point with this outward normal faces the obstacle.
    pub(super) fn faces(&self, point: Point<D>, normal: Point<D>) -> bool {
        match self {
            Self::Gap(_) => true,
            Self::Surface { surface, inside } => {
                surface_opposite(surface, *inside, point, normal).is_some()
            }
            // it is paired as a side
            Self::Tool(_) => false,
        }
    }

    /// Contact normal and gap at a point with this outward normal; `None` where it does not face the obstacle.
    pub(super) fn opposite(
        &self,
        (point, normal): (Point<D>, Point<D>),
        time: f64,
        end: End<'_, D>,
    ) -> Result<Option<(Point<D>, f64)>, ContactError> {
        Ok(match self {
            Self::Gap(field) => Some((normal, finite_gap(field, point, time, end)?)),
            Self::Surface { surface, inside } => surface_opposite(surface, *inside, point, normal),
            // it is paired as a side
            Self::Tool(_) => None,
        })
    }
}

/// Points that are closer than this part of their coordinates are the same.
const SAME_POINT: f64 = 1e-13;

/// Surfaces count as opposed when the cosine between the normals is below this.
const OPPOSED: f64 = -0.1;

fn surface_opposite<const D: usize>(
    surface: &Surface<D>,
    inside: bool,
    point: Point<D>,
    normal: Point<D>,
) -> Option<(Point<D>, f64)> {
    if let Surface::Plane { normal: up, .. } = surface {
        let facing = dot(normal, *up) < OPPOSED;
        return facing.then(|| (up.map(|c| -c), surface.distance(point)));
    }
    let outward = |s: f64| {
        let n = surface.normal(add_scaled(point, s, normal))?;
        Some(if inside { n.map(|c| -c) } else { n })
    };
    // a point outside the obstacle has no obstacle behind it, through the body
    let out = surface.distance(point) * if inside { -1.0 } else { 1.0 };
    let rounding = SAME_POINT * (norm(point) + norm(surface.closest(point)));
    let back = if out < rounding { f64::INFINITY } else { 0.0 };
    let hits = surface.intersections(point, normal).into_iter();
    let hits = hits.filter(|&s| s >= -back);
    let facing = hits.filter(|&s| outward(s).is_some_and(|n| dot(n, normal) < OPPOSED));
    let nearest = facing.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some((normal, nearest))
}

/// Motion of a rigid obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driven {
    /// It stays in place at all times.
    Still,
    /// A prescribed displacement.
    Prescribed,
    /// Forces: it is free to translate.
    Free,
}

/// A gap that counts as closed up to a length.
pub(super) fn beyond(most: f64, gap: f64) -> f64 {
    if gap <= most { 0.0 } else { gap }
}

/// Value of a gap at a point; an error when it is not finite.
pub(super) fn finite_gap<const D: usize>(
    field: &Field,
    point: Point<D>,
    time: f64,
    end: End<'_, D>,
) -> Result<f64, ContactError> {
    let value = field.at(point, time);
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ContactError::NotFinite {
            side: end.name(),
            text: field.to_string(),
            point: show(point),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::{end, plate};
    use crate::fem::Constraints;
    use crate::geometry::norm;

    /// The unit vector whose cosine with +y is this.
    fn leaning(cosine: f64) -> Point<2> {
        [f64::sqrt(1.0 - cosine * cosine), cosine]
    }

    fn opposite(rigid: &Rigid<2>, point: Point<2>, normal: Point<2>) -> Option<(Point<2>, f64)> {
        let (plate, free) = (
            plate([0.0, 0.0], [1.0, 1.0], [1, 1]),
            Constraints::default(),
        );
        let found = rigid.opposite((point, normal), 3.0, end(&plate, "top", &free));
        let found = found.unwrap();
        assert_eq!(rigid.faces(point, normal), found.is_some());
        found
    }

    #[test]
    fn a_plane_is_faced_by_what_looks_against_its_normal() {
        let rigid = Rigid::Surface {
            surface: Surface::Plane {
                point: [7.0, -1.0],
                normal: [0.0, 1.0],
            },
            inside: false,
        };
        for (cosine, faces) in [
            (-0.105, true),
            (-0.095, false),
            (0.105, false),
            (-1.0, true),
        ] {
            let found = opposite(&rigid, [2.0, 0.5], leaning(cosine));
            assert_eq!(found.is_some(), faces, "{cosine}");
            if let Some((normal, gap)) = found {
                // towards the plane, and the distance from it
                assert_eq!((normal, gap), ([0.0, -1.0], 1.5));
            }
        }
        assert_eq!(rigid.drawn([2.0, 0.5], [0.0, -1.0], 0.0), [2.0, -1.0]);
    }

    #[test]
    fn a_ball_is_met_on_its_near_side_and_a_hole_on_its_far_one() {
        let rigid = |inside| Rigid::Surface {
            surface: Surface::Sphere {
                center: [0.0, -3.0],
                radius: 2.0,
            },
            inside,
        };
        let down = [0.0, -1.0];
        for (point, inside, gap) in [
            ([0.0, 0.5], false, Some(1.5)),
            ([0.0, -1.25], false, Some(-0.25)),
            ([1.2, 0.0], false, Some(1.4)),
            ([2.1, 0.0], false, None),
            // the ball lies behind, through the body
            ([0.0, -5.5], false, None),
            ([0.0, 0.5], true, Some(5.5)),
            ([0.0, -2.0], true, Some(3.0)),
            ([0.0, -5.25], true, Some(-0.25)),
        ] {
            let found = opposite(&rigid(inside), point, down);
            assert_eq!(found.is_some(), gap.is_some(), "{point:?}");
            if let (Some((normal, found)), Some(gap)) = (found, gap) {
                assert_eq!(normal, down);
                assert!((found - gap).abs() < 1e-14, "{found}");
            }
        }
        // grazed: the cosine between the normals is −0.105, or −0.095
        for (cosine, faces) in [(0.105f64, true), (0.095, false)] {
            let x = 2.0 * f64::sqrt(1.0 - cosine * cosine);
            let found = opposite(&rigid(false), [x, 0.0], down);
            assert_eq!(found.is_some(), faces, "{cosine}");
        }
        let drawn = rigid(false).drawn([3.0, 1.0], down, 0.0);
        assert!((norm([drawn[0], drawn[1] + 3.0]) - 2.0).abs() < 1e-14);
    }

    #[test]
    fn a_given_gap_is_taken_at_the_point_and_the_time() {
        let rigid = Rigid::Gap(Field::function("x + 10 t", |p, t| p[0] + 10.0 * t));
        let up = [0.0, 1.0];
        assert_eq!(opposite(&rigid, [2.0, 0.5], up), Some((up, 32.0)));
        assert_eq!(rigid.drawn([2.0, 0.5], up, 0.1), [2.0, 3.5]);
    }

    #[test]
    fn a_gap_that_is_not_finite_is_an_error_with_its_place() {
        let (plate, free) = (
            plate([0.0, 0.0], [1.0, 1.0], [1, 1]),
            Constraints::default(),
        );
        let field = Field::function("1/x", |p, _| 1.0 / p[0]);
        let end = end(&plate, "top", &free);
        assert_eq!(finite_gap(&field, [2.0, 0.0], 0.0, end), Ok(0.5));
        let error = finite_gap(&field, [0.0, 5.0], 0.0, end).unwrap_err();
        let message = error.to_string();
        for word in ["1/x", "body.top", "5"] {
            assert!(message.contains(word), "{message}");
        }
    }
}
