//! Rigid obstacles: where their surface lies opposite a point of a side, and what moves them.

use crate::contact::{ContactError, End};
use crate::fem::show;
use crate::geometry::{Field, Point, Surface, add_scaled, dot};

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
}

impl<const D: usize> Rigid<D> {
    /// The point of the obstacle that lies opposite a point with this outward normal, or nearest to it: for drawing.
    pub fn drawn(&self, point: Point<D>, normal: Point<D>, time: f64) -> Point<D> {
        match self {
            Self::Gap(field) => add_scaled(point, field.at(point, time), normal),
            Self::Surface { surface, .. } => surface.closest(point),
        }
    }

    /// Whether a point with this outward normal faces the obstacle.
    pub(super) fn faces(&self, point: Point<D>, normal: Point<D>) -> bool {
        match self {
            Self::Gap(_) => true,
            Self::Surface { surface, inside } => {
                surface_opposite(surface, *inside, point, normal).is_some()
            }
        }
    }

    /// Contact normal and gap at a point with this outward normal; `None` where it faces nothing.
    pub(super) fn opposite(
        &self,
        (point, normal): (Point<D>, Point<D>),
        time: f64,
        end: End<'_, D>,
    ) -> Result<Option<(Point<D>, f64)>, ContactError> {
        Ok(match self {
            Self::Gap(field) => Some((normal, finite_gap(field, point, time, end)?)),
            Self::Surface { surface, inside } => surface_opposite(surface, *inside, point, normal),
        })
    }
}

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
    let hits = surface.intersections(point, normal).into_iter();
    let facing = hits.filter(|&s| outward(s).is_some_and(|n| dot(n, normal) < OPPOSED));
    let nearest = facing.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some((normal, nearest))
}

/// What moves a rigid obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driven {
    /// Nothing: it stays where it is at all times.
    Still,
    /// A prescribed displacement.
    Prescribed,
    /// Forces: it is free to translate.
    Free,
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
