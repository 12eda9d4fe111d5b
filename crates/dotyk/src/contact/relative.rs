//! What supports leave of the relative motion of two opposite points, and in which directions their forces are counted.

use crate::contact::Coupling;
use crate::fem::Held;
use crate::geometry::{Point, add_scaled, cross, dot, norm, padded, unit};

/// Parts of directions below this are rounding.
const ROUNDING: f64 = 1e-6;

/// The unit vectors in which the forces of a contact are counted: its normal, then the tangents, in the plane the normal
/// turned by +90°.
///
/// In space any two would do, because the laws know no direction of the tangent plane; but where supports hold a direction of
/// that plane (`held`), it is one of them, so that a row is either held or free. Else the first tangent is the axis that is
/// farthest from the normal, less its normal part; the three vectors are right-handed.
pub fn frame<const D: usize>(normal: Point<D>, held: &[Point<D>]) -> [Point<D>; D] {
    let mut frame = [normal; D];
    if D == 2 {
        (frame[1][0], frame[1][1]) = (-normal[1], normal[0]);
        return frame;
    }
    let farthest = (0..D).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()));
    let axis = std::array::from_fn(|d| f64::from(u8::from(Some(d) == farthest)));
    let across = |direction: Point<D>| add_scaled(direction, -dot(direction, normal), normal);
    // supports that hold a direction nearly along the normal hold the normal: their rest is no direction
    let held = held.iter().map(|&direction| across(direction));
    let along = held.max_by(|a, b| norm(*a).total_cmp(&norm(*b)));
    let first = along.filter(|rest| norm(*rest) > 0.5).and_then(unit);
    frame[1] = first.or_else(|| unit(across(axis))).unwrap_or(axis);
    let last = cross(padded(normal), padded(frame[1]));
    frame[2] = std::array::from_fn(|d| last[d]);
    frame
}

/// What supports leave of the relative motion of two opposite points; orthonormal directions.
pub(super) struct Relative<const D: usize> {
    /// Directions in which it is prescribed.
    pub prescribed: Vec<Point<D>>,
    /// Those of them in which there is none at any time: nothing can slip.
    pub still: Vec<Point<D>>,
}

impl<const D: usize> Relative<D> {
    /// The normal without what is prescribed; unchanged where nothing is left.
    pub fn free_normal(&self, normal: Point<D>) -> Point<D> {
        free_part(normal, self.prescribed.iter().copied()).unwrap_or(normal)
    }

    /// Which components along a frame carry no multiplier, because they are prescribed or not coupled at all.
    pub fn decided(&self, frame: [Point<D>; D], coupling: Coupling) -> [bool; D] {
        let part = |directions: &[Point<D>], axis: Point<D>| -> f64 {
            directions.iter().map(|&h| dot(h, axis).abs()).sum()
        };
        let normal_held = free_part(frame[0], self.prescribed.iter().copied()).is_none();
        match coupling {
            Coupling::Normal => std::array::from_fn(|c| c > 0 || normal_held),
            Coupling::Frictional => std::array::from_fn(|c| match c {
                0 => normal_held,
                _ => normal_held || part(&self.still, frame[c]) > ROUNDING,
            }),
            Coupling::Tied => {
                let held = |c: &usize| part(&self.prescribed, frame[*c]);
                let mut order: Vec<usize> = (0..D).collect();
                order.sort_by(|a, b| held(b).total_cmp(&held(a)));
                let mut components = [false; D];
                let prescribed = order.iter().take(self.prescribed.len());
                prescribed.for_each(|&c| components[c] = true);
                components
            }
        }
    }
}

/// Held directions that satisfy a condition.
pub(super) fn axes<const D: usize>(
    held: &[Held<D>],
    which: impl Fn(&Held<D>) -> bool,
) -> Vec<Point<D>> {
    let chosen = held.iter().filter(|h| which(h));
    chosen.map(|h| h.axis).collect()
}

/// Directions that both sets of orthonormal directions contain.
pub(super) fn shared<const D: usize>(a: &[Point<D>], b: &[Point<D>]) -> Vec<Point<D>> {
    let inside = |axis: &Point<D>| {
        let rest = b
            .iter()
            .fold(*axis, |rest, &h| add_scaled(rest, -dot(*axis, h), h));
        norm(rest) < ROUNDING
    };
    match (a.len() == D, b.len() == D) {
        (_, true) => a.to_vec(),
        (true, _) => b.to_vec(),
        _ => a.iter().copied().filter(inside).collect(),
    }
}

/// Unit vector along the part of a normal that is orthogonal to some orthonormal directions; `None` if nothing is left.
pub(super) fn free_part<const D: usize>(
    normal: Point<D>,
    directions: impl IntoIterator<Item = Point<D>>,
) -> Option<Point<D>> {
    let rest = directions.into_iter().fold(normal, |rest, axis| {
        add_scaled(rest, -dot(rest, axis), axis)
    });
    unit(rest).filter(|_| norm(rest) > ROUNDING)
}
