//! Constraints by supports on the relative motion of two opposite points, and the directions of their forces.
//!
//! **Supports oblique to the contact.** Where both sides are held along h, the relative motion δ has δ·h = 0. With the normal n,
//! h = cos β · t + sin β · n and a tangent t, the only free motion besides the other tangent is along
//! n' = cos β · n − sin β · t, and
//!
//! ```text
//!   gap = cos β · δ·n',     slip along t = −sin β · δ·n' = −tan β · gap
//! ```
//!
//! These are two conditions on one motion: a closed node does not slip along t, and the work of the forces λₙ, λₜ determines
//! only cos β λₙ − sin β λₜ. Equilibrium does not separate them; the rest of both, along h, goes into the supports. The
//! tractions of the sides do separate them: they are continuous, and next to such a node shear and pressure are known. So the
//! node keeps its normal condition and its own pressure, and its shear is that of its neighbours, which have the functions ψ of
//! the component t on its facets (mortar.rs). Where h lies in the plane of the contact (β = 0) there is no such motion: the side
//! ends at a plane of symmetry, shear along h vanishes, and the node has no such row. (Normals that are off that plane because
//! facets are straight have been turned back into it, normals.rs.)

use crate::contact::Coupling;
use crate::fem::Held;
use crate::geometry::{Point, add_scaled, cross, dot, norm, padded, unit};

/// Parts of directions below this are rounding.
const DIRECTION_ROUNDING: f64 = 1e-6;

/// The unit vectors in which the forces of a contact are counted: its normal, then the tangents, in the plane the normal
/// turned by +90°.
///
/// In space any two tangents are possible, because the laws are isotropic in the tangent plane; but if supports hold a direction
/// of that plane (`held`), it is one of them, so that a row is either held or free. Else the first tangent is the axis that is
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
    // a held direction along the normal has no direction in the tangent plane
    let held = held.iter().map(|&direction| across(direction));
    let along = held.max_by(|a, b| norm(*a).total_cmp(&norm(*b)));
    let first = along
        .filter(|rest| norm(*rest) > DIRECTION_ROUNDING)
        .and_then(unit);
    frame[1] = first.or_else(|| unit(across(axis))).unwrap_or(axis);
    let last = cross(padded(normal), padded(frame[1]));
    frame[2] = std::array::from_fn(|d| last[d]);
    frame
}

/// Which components of a frame are those of tangents that have a part along a direction.
pub(super) fn tangents_along<const D: usize>(
    frame: &[Point<D>; D],
    direction: Point<D>,
) -> [bool; D] {
    std::array::from_fn(|c| c > 0 && dot(frame[c], direction).abs() > DIRECTION_ROUNDING)
}

/// Whether no held direction has parts along two tangents: a row is either held or free.
pub(super) fn separates<const D: usize>(frame: &[Point<D>; D], held: &[Point<D>]) -> bool {
    let parts = |&direction: &Point<D>| {
        let along = tangents_along(frame, direction);
        along.iter().filter(|along| **along).count()
    };
    held.iter().map(parts).all(|parts| parts < 2)
}

/// A frame carried to another normal nearby, by the smallest rotation, which takes a unit vector a to b:
/// v − ((a + b)·v)/(1 + a·b) (a + b) + 2 (a·v) b.
pub(super) fn carried<const D: usize>(frame: [Point<D>; D], normal: Point<D>) -> [Point<D>; D] {
    let from = frame[0];
    let both = add_scaled(from, 1.0, normal);
    let scale = 1.0 / (1.0 + dot(from, normal));
    let mut carried = frame.map(|axis| {
        let parts = scale * (dot(axis, from) + dot(axis, normal));
        add_scaled(
            add_scaled(axis, -parts, both),
            2.0 * dot(axis, from),
            normal,
        )
    });
    carried[0] = normal;
    carried
}

/// Constraints by supports on the relative motion of two opposite points; orthonormal directions.
pub(super) struct Relative<const D: usize> {
    /// Directions in which the motion is prescribed.
    pub prescribed: Vec<Point<D>>,
    /// Those of them without motion at all times: no slip is possible.
    pub still: Vec<Point<D>>,
}

impl<const D: usize> Relative<D> {
    /// No motion at all.
    pub fn none() -> Self {
        let axes = || (0..D).map(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        Self {
            prescribed: axes().collect(),
            still: axes().collect(),
        }
    }

    /// The normal without its prescribed part; unchanged if nothing remains.
    pub fn free_normal(&self, normal: Point<D>) -> Point<D> {
        free_part(normal, self.prescribed.iter().copied()).unwrap_or(normal)
    }

    /// A direction without relative motion that is oblique to a normal that is free: slip along its part in the tangent plane
    /// follows from the gap.
    pub fn oblique(&self, normal: Point<D>) -> Option<Point<D>> {
        free_part(normal, self.prescribed.iter().copied())?;
        let mut still = self.still.iter().copied();
        still.find(|&h| dot(h, normal).abs() > DIRECTION_ROUNDING)
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
                _ => normal_held || part(&self.still, frame[c]) > DIRECTION_ROUNDING,
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
        norm(rest) < DIRECTION_ROUNDING
    };
    match (a.len() == D, b.len() == D) {
        (_, true) => a.to_vec(),
        (true, _) => b.to_vec(),
        _ => a.iter().copied().filter(inside).collect(),
    }
}

/// Unit vector along the part of a normal that is orthogonal to some orthonormal directions; `None` if that vanishes.
pub(super) fn free_part<const D: usize>(
    normal: Point<D>,
    directions: impl IntoIterator<Item = Point<D>>,
) -> Option<Point<D>> {
    let rest = directions.into_iter().fold(normal, |rest, axis| {
        add_scaled(rest, -dot(rest, axis), axis)
    });
    unit(rest).filter(|_| norm(rest) > DIRECTION_ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::gaps::tests::noise;

    #[test]
    fn frames_are_right_handed_unit_vectors() {
        let mut noise = noise();
        for _ in 0..50 {
            let normal = unit([noise(), noise(), noise()]).unwrap();
            let direction = [noise(), noise(), noise()];
            for held in [vec![], vec![direction]] {
                let [n, a, b] = frame(normal, &held);
                assert_eq!(n, normal);
                for (x, y, expected) in [(a, a, 1.0), (b, b, 1.0), (n, a, 0.0), (a, b, 0.0)] {
                    assert!((dot(x, y) - expected).abs() < 1e-14);
                }
                let last = cross(n, a);
                assert!((0..3).all(|d| (last[d] - b[d]).abs() < 1e-15));
            }
        }
        assert_eq!(frame([0.6, 0.8], &[]), [[0.6, 0.8], [-0.8, 0.6]]);
    }

    #[test]
    fn the_first_tangent_is_the_axis_farthest_from_the_normal_less_its_normal_part() {
        for farthest in 0..3 {
            let mut normal = [0.8, 0.8, 0.8];
            normal[farthest] = -0.36;
            normal[(farthest + 1) % 3] = -0.48;
            let normal = unit(normal).unwrap();
            let tangent = frame(normal, &[])[1];
            // of all tangents it is nearest to the axis: their cosine is the sine between normal and axis
            let sine = (1.0 - normal[farthest] * normal[farthest]).sqrt();
            assert!((tangent[farthest] - sine).abs() < 1e-15, "{tangent:?}");
        }
        assert_eq!(frame([0.0, 0.6, 0.8], &[])[1], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_held_direction_of_the_tangent_plane_is_a_tangent() {
        let normal = [0.0, 0.0, 1.0];
        let held = [0.6, 0.8, 0.0];
        assert_eq!(frame(normal, &[held])[1], held);
        // of several, the one that is most in the plane
        let steep = unit([1.0, 0.0, 0.5]).unwrap();
        for both in [[steep, held], [held, steep]] {
            assert_eq!(frame(normal, &both)[1], held);
        }
        // whatever part of it is beyond rounding
        for (part, taken) in [(0.5f64, true), (1.05e-6, true), (0.95e-6, false)] {
            let slanted = [0.0, part, (1.0 - part * part).sqrt()];
            let first = if taken {
                [0.0, 1.0, 0.0]
            } else {
                [1.0, 0.0, 0.0]
            };
            assert_eq!(frame(normal, &[slanted])[1], first, "{part}");
        }
    }

    #[test]
    fn what_is_left_of_a_normal_is_orthogonal_to_what_is_held() {
        let normal = unit([1.0, 2.0, -2.0]).unwrap();
        let (a, b) = ([0.6, 0.8, 0.0], [0.0, 0.0, 1.0]);
        let left = free_part(normal, [a, b]).unwrap();
        assert!(dot(left, a).abs() < 1e-15 && dot(left, b).abs() < 1e-15);
        assert!((norm(left) - 1.0).abs() < 1e-15 && dot(left, normal) > 0.0);
        assert_eq!(free_part(normal, []), unit(normal));
        // a millionth is rounding
        for (part, free) in [(1.05e-6, true), (0.95e-6, false)] {
            let held = unit([1.0, part]).unwrap();
            let left = free_part([1.0, 0.0], [held]);
            assert_eq!(left.is_some(), free, "{part}");
        }
        let relative = |prescribed: &[Point<2>]| Relative {
            prescribed: prescribed.to_vec(),
            still: Vec::new(),
        };
        let (x, y) = ([1.0, 0.0], [0.0, 1.0]);
        assert_eq!(relative(&[x]).free_normal([0.6, 0.8]), y);
        // nothing is left: unchanged
        assert_eq!(relative(&[x, y]).free_normal([0.6, 0.8]), [0.6, 0.8]);
    }

    /// The components without multipliers in a frame of the plane, normal and tangent along the axes.
    fn decided(prescribed: &[Point<2>], still: &[Point<2>], coupling: Coupling) -> [bool; 2] {
        let relative = Relative {
            prescribed: prescribed.to_vec(),
            still: still.to_vec(),
        };
        relative.decided([[1.0, 0.0], [0.0, 1.0]], coupling)
    }

    #[test]
    fn only_what_supports_leave_free_and_the_law_couples_carries_a_multiplier() {
        let (x, y) = ([1.0, 0.0], [0.0, 1.0]);
        let diagonal = [0.8, 0.6];
        let normal = |prescribed: &[Point<2>]| decided(prescribed, &[], Coupling::Normal);
        assert_eq!(normal(&[]), [false, true]);
        assert_eq!(normal(&[y]), [false, true]);
        assert_eq!(normal(&[diagonal]), [false, true]);
        assert_eq!(normal(&[x]), [true, true]);
        assert_eq!(normal(&[x, y]), [true, true]);
        let frictional = |prescribed: &[Point<2>], still: &[Point<2>]| {
            decided(prescribed, still, Coupling::Frictional)
        };
        assert_eq!(frictional(&[], &[]), [false, false]);
        // prescribed along the tangent: it slips as prescribed, with friction; without motion there is no friction
        assert_eq!(frictional(&[y], &[]), [false, false]);
        assert_eq!(frictional(&[y], &[y]), [false, true]);
        assert_eq!(frictional(&[x], &[]), [true, true]);
        let tied = |prescribed: &[Point<2>]| decided(prescribed, &[], Coupling::Tied);
        assert_eq!(tied(&[]), [false, false]);
        assert_eq!(tied(&[y]), [false, true]);
        assert_eq!(tied(&[x]), [true, false]);
        // as many components as are prescribed, those that are nearest to them
        assert_eq!(tied(&[diagonal]), [true, false]);
        assert_eq!(tied(&[[0.6, 0.8]]), [false, true]);
        assert_eq!(tied(&[x, y]), [true, true]);
    }

    #[test]
    fn a_part_of_a_still_direction_beyond_rounding_holds_the_tangent() {
        for (part, holds) in [(1.05e-6, true), (0.95e-6, false)] {
            let still = unit([1.0, part]).unwrap();
            // the normal itself is free
            let decided = decided(&[], &[still], Coupling::Frictional);
            assert_eq!(decided, [false, holds], "{part}");
        }
    }

    #[test]
    fn a_tie_in_space_loses_the_components_nearest_to_what_is_prescribed() {
        let relative = Relative {
            prescribed: vec![
                unit([0.1, 0.9, 0.2]).unwrap(),
                unit([0.9, -0.1, 0.0]).unwrap(),
            ],
            still: Vec::new(),
        };
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(relative.decided(axes, Coupling::Tied), [true, true, false]);
        assert_eq!(
            relative.decided(axes, Coupling::Normal),
            [false, true, true]
        );
        assert_eq!(relative.decided(axes, Coupling::Frictional), [false; 3]);
    }

    #[test]
    fn a_direction_is_oblique_that_is_neither_tangent_nor_held_normal() {
        let (x, z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let relative = Relative {
            prescribed: vec![z],
            still: vec![z],
        };
        let normal = [0.0, 0.8, 0.6];
        assert_eq!(relative.oblique(normal), Some(z));
        assert_eq!(relative.oblique([0.0, 1.0, 0.0]), None);
        assert_eq!(relative.oblique(z), None);
        // it has a part along the first tangent; the other tangent is left to other supports
        let frame = frame(normal, &[z]);
        assert_eq!(tangents_along(&frame, z), [false, true, false]);
        assert!(separates(&frame, &[x, z]));
        assert!(!separates(&frame, &[unit([1.0, 0.0, 1.0]).unwrap()]));
    }

    #[test]
    fn shared_directions_are_those_that_both_sides_hold() {
        let (x, y) = ([1.0, 0.0], [0.0, 1.0]);
        let diagonal = [0.6, 0.8];
        let across = [-0.8, 0.6];
        assert_eq!(shared(&[x], &[x]), [x]);
        assert_eq!(shared(&[x], &[y]), Vec::<Point<2>>::new());
        assert_eq!(shared(&[x], &[diagonal]), Vec::<Point<2>>::new());
        assert_eq!(shared(&[], &[x, y]), Vec::<Point<2>>::new());
        // a set that holds all directions contains those of the other
        assert_eq!(shared(&[diagonal], &[x, y]), [diagonal]);
        assert_eq!(shared(&[x, y], &[diagonal]), [diagonal]);
        assert_eq!(shared(&[x, y], &[diagonal, across]), [x, y]);
        let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let slanted = [0.6, 0.8, 0.0];
        assert_eq!(shared(&[slanted, z], &[x, y]), [slanted]);
        for (part, same) in [(0.95e-6, true), (1.05e-6, false)] {
            let nearly = unit([1.0, part]).unwrap();
            assert_eq!(
                shared(&[nearly], &[[1.0, 0.0]]).len(),
                usize::from(same),
                "{part}"
            );
        }
    }

    #[test]
    fn axes_are_those_of_the_held_directions_that_are_asked_for() {
        let held = |axis, still| Held {
            axis,
            value: 0.0,
            terms: 0.0,
            still,
            supports: Vec::new(),
        };
        let both = [held([1.0, 0.0], true), held([0.0, 1.0], false)];
        assert_eq!(axes(&both, |h| h.still), [[1.0, 0.0]]);
        assert_eq!(axes(&both, |_| true), [[1.0, 0.0], [0.0, 1.0]]);
    }
}
