//! Whether bodies can be held at all, from statics, with a margin on either side of the limit.

use crate::cone::{cone, distance};
use crate::problem::Known;
use crate::random::Random;
use crate::vector::{cross, length, mean, minus, plus, raised, times};

/// Margin to bodies that fall: this part of lengths, and of coefficients of friction.
pub const MARGIN: f64 = 0.009;

/// Edges of the pyramids that replace cones of friction.
const EDGES: usize = 64;

/// A possible push: its point, its unit direction (into the body), and its coefficient of friction.
#[derive(Debug, Clone, Copy)]
pub struct Push<const D: usize = 2> {
    pub at: [f64; D],
    pub direction: [f64; D],
    pub friction: f64,
}

/// Whether pushes can hold a load (a force and a moment about the origin); `inside` is the margin of held bodies.
pub fn held<const D: usize>(
    (force, moment): ([f64; D], [f64; 3]),
    pushes: &[Push<D>],
    inside: f64,
) -> Known {
    let places: Vec<[f64; D]> = pushes.iter().map(|p| p.at).collect();
    let middle = mean(&places);
    let far = places.iter().map(|&x| length(minus(x, middle)));
    let arm = far.fold(1e-9, f64::max);
    let turned = minus(moment, cross(middle, force));
    let scale = length(force).max(length(turned) / arm);
    if scale == 0.0 {
        return Known::Open;
    }
    let row = |force: [f64; D], moment: [f64; 3]| {
        let ([a, b, c], [d, e, f]) = (raised(force), times(1.0 / arm, moment));
        [a, b, c, d, e, f]
    };
    let target = row(force, turned).map(|c| -c / scale);
    let off = |stretch: f64, around: bool| {
        let mut columns = Vec::new();
        for push in pushes {
            let to = times(stretch, minus(push.at, middle));
            for f in cone(push.direction, stretch * push.friction, EDGES, around) {
                columns.push(row(f, cross(to, f)));
            }
        }
        distance(&columns, target)
    };
    if off(1.0 - inside, false) < 1e-12 {
        Known::Holds
    } else if off(1.0 + MARGIN, true) > 1e-4 * MARGIN {
        Known::Falls
    } else {
        Known::Open
    }
}

/// The sum of two loads.
pub fn both<const D: usize>(
    a: ([f64; D], [f64; 3]),
    b: ([f64; D], [f64; 3]),
) -> ([f64; D], [f64; 3]) {
    (plus(a.0, 1.0, b.0), plus(a.1, 1.0, b.1))
}

/// A factor of the limit: just inside, just outside, or farther from it.
pub fn beside_limit(random: &mut Random) -> f64 {
    match random.count(0, 5) {
        0 | 1 => 0.99,
        2 | 3 => 1.011,
        4 => random.between(0.2, 0.98),
        _ => random.between(1.02, 1.5),
    }
}

/// Poisson's ratio of a material.
pub fn poisson(random: &mut Random) -> f64 {
    match random.count(0, 9) {
        0 => 0.0,
        1 => 0.45,
        _ => random.between(0.15, 0.4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pushes from below at the corners of a rectangle of length 2 and breadth 1, or at its ends in the plane.
    fn floor<const D: usize>() -> Vec<Push<D>> {
        let push = |[x, y]: [f64; 2]| {
            let up = if D == 2 {
                [0.0, 1.0, 0.0]
            } else {
                [0.0, 0.0, 1.0]
            };
            let at = if D == 2 { [x, 0.0, 0.0] } else { [x, y, 0.0] };
            Push {
                at: std::array::from_fn(|d| at[d]),
                direction: std::array::from_fn(|d| up[d]),
                friction: 0.5,
            }
        };
        [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]
            .map(push)
            .to_vec()
    }

    fn at<const D: usize>(x: [f64; D], f: [f64; D]) -> Known {
        held((f, cross(x, f)), &floor(), MARGIN)
    }

    #[test]
    fn statics_of_the_plane_knows_what_tips_and_what_slides() {
        let down = |x: f64| at([x, 0.0], [0.0, -1.0]);
        assert_eq!(down(1.97), Known::Holds);
        assert_eq!(down(2.03), Known::Falls);
        assert_eq!(down(1.999), Known::Open);
        assert_eq!(at([1.0, 0.0], [0.49, -1.0]), Known::Holds);
        assert_eq!(at([1.0, 0.0], [0.51, -1.0]), Known::Falls);
        assert_eq!(at([1.0, 0.0], [0.0, 1.0]), Known::Falls);
    }

    #[test]
    fn statics_of_space_knows_what_tips_slides_and_spins() {
        let down = |x: f64, y: f64| at([x, y, 0.0], [0.0, 0.0, -1.0]);
        assert_eq!(down(1.97, 0.5), Known::Holds);
        assert_eq!(down(2.03, 0.5), Known::Falls);
        assert_eq!(down(1.0, 1.03), Known::Falls);
        let (s, c) = 0.77f64.sin_cos();
        let drawn = |part: f64| at([1.0, 0.5, 0.0], [part * c, part * s, -1.0]);
        assert_eq!(drawn(0.49), Known::Holds);
        assert_eq!(drawn(0.51), Known::Falls);
        assert_eq!(at([1.0, 0.5, 0.0], [0.0, 0.0, 1.0]), Known::Falls);
        // four corners at a distance of √1.25 with a quarter of the force each
        let spun = |m: f64| held(([0.0, 0.0, -1.0], [-0.5, 1.0, m]), &floor(), MARGIN);
        assert_eq!(spun(0.54), Known::Holds);
        assert_eq!(spun(0.58), Known::Falls);
    }
}
