//! Is a force the sum of forces that are allowed? Least distance of a vector from a cone.
//!
//! ```text
//!   min |A x − b|   over x ≥ 0
//! ```
//!
//! The columns of A are the edges of the cone, here forces or forces with their moments. The round cone of friction of space is
//! replaced by a pyramid inside it, or around it, which is wider by 1/cos(π/number of edges).
//!
//! Source: the active-set method as described in C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974.

use crate::vector::{plus, tangents, times};
use std::f64::consts::{PI, TAU};

/// Edges of the pyramid around a cone of friction.
pub const EDGES: usize = 16;

/// Edges of a cone of friction about a unit direction: two in the plane; in space those of a pyramid of so many edges, inside it or
/// around it.
pub fn cone<const D: usize>(
    direction: [f64; D],
    friction: f64,
    edges: usize,
    around: bool,
) -> Vec<[f64; D]> {
    let tangents = match tangents(direction)[..] {
        _ if friction == 0.0 => return vec![direction],
        [a] => vec![a, times(-1.0, a)],
        [a, b] => {
            let edge = |k: usize| {
                let (s, c) = (TAU * k as f64 / edges as f64).sin_cos();
                plus(times(c, a), s, b)
            };
            (0..edges).map(edge).collect()
        }
        _ => Vec::new(),
    };
    let reach = match D {
        3 if around => 1.0 / (PI / edges as f64).cos(),
        _ => 1.0,
    };
    let edges = tangents.into_iter();
    edges
        .map(|t| plus(direction, reach * friction, t))
        .collect()
}

/// Distance of b from the cone that the columns span.
pub fn distance<const N: usize>(columns: &[[f64; N]], b: [f64; N]) -> f64 {
    let mut x = vec![0.0; columns.len()];
    let mut active: Vec<usize> = Vec::new();
    let largest = columns.iter().map(size).fold(0.0, f64::max);
    let tolerance = 1e-13 * largest * size(&b);
    for _ in 0..200 {
        let rest = residual(columns, &x, b);
        let slope = |j: usize| product(&columns[j], &rest);
        let candidates = (0..columns.len()).filter(|j| !active.contains(j));
        let Some(next) = candidates.max_by(|&i, &j| slope(i).total_cmp(&slope(j))) else {
            break;
        };
        // the sum never needs more edges than rows
        if slope(next) <= tolerance || size(&rest) <= 1e-14 * size(&b) {
            break;
        }
        active.push(next);
        loop {
            let y = least_squares(columns, &active, b);
            if y.iter().all(|v| *v > 0.0) {
                active.iter().zip(&y).for_each(|(&j, &v)| x[j] = v);
                break;
            }
            let step = active
                .iter()
                .zip(&y)
                .filter(|(_, v)| **v <= 0.0)
                .map(|(&j, &v)| x[j] / (x[j] - v))
                .fold(1.0, f64::min);
            for (&j, &v) in active.iter().zip(&y) {
                x[j] += step * (v - x[j]);
            }
            active.retain(|&j| {
                let stays = x[j] > 1e-15;
                if !stays {
                    x[j] = 0.0;
                }
                stays
            });
            if active.is_empty() {
                break;
            }
        }
    }
    size(&residual(columns, &x, b))
}

fn product<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn size<const N: usize>(a: &[f64; N]) -> f64 {
    product(a, a).sqrt()
}

fn residual<const N: usize>(columns: &[[f64; N]], x: &[f64], b: [f64; N]) -> [f64; N] {
    let mut rest = b;
    for (column, x) in columns.iter().zip(x).filter(|(_, x)| **x != 0.0) {
        rest.iter_mut().zip(column).for_each(|(r, c)| *r -= c * x);
    }
    rest
}

/// Least squares with some columns: orthogonalised one after the other, dependent ones left at zero.
fn least_squares<const N: usize>(columns: &[[f64; N]], active: &[usize], b: [f64; N]) -> Vec<f64> {
    let n = active.len();
    let mut basis: Vec<[f64; N]> = Vec::new();
    let mut upper = vec![vec![0.0; n]; n];
    let mut used = Vec::new();
    for (k, &j) in active.iter().enumerate() {
        let mut rest = columns[j];
        for _ in 0..2 {
            for (q, row) in basis.iter().zip(&used) {
                let part = product(q, &rest);
                let row: usize = *row;
                upper[row][k] += part;
                rest.iter_mut().zip(q).for_each(|(r, q)| *r -= part * q);
            }
        }
        let norm = size(&rest);
        if norm > 1e-13 * size(&columns[j]) {
            upper[k][k] = norm;
            basis.push(rest.map(|r| r / norm));
            used.push(k);
        }
    }
    let mut y = vec![0.0; n];
    for (q, &k) in basis.iter().zip(&used).rev() {
        let known: f64 = (k + 1..n).map(|m| upper[k][m] * y[m]).sum();
        y[k] = (product(q, &b) - known) / upper[k][k];
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn sums_of_edges_are_inside_and_others_keep_their_distance() {
        let plane = [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0]];
        assert!(distance(&plane, [1.0, 0.5, 0.0]) < 1e-14);
        assert!((distance(&plane, [1.0, -0.5, 0.0]) - 0.5).abs() < 1e-14);
        assert!((distance(&plane, [-1.0, 0.0, 0.0]) - 1.0).abs() < 1e-14);
        assert!((distance(&[], [3.0, 4.0, 0.0]) - 5.0).abs() < 1e-14);
        let mut random = Random::new(3);
        for _ in 0..500 {
            let many: Vec<[f64; 3]> = (0..random.count(1, 60))
                .map(|_| [random.between(-1.0, 1.0), 1.0, random.between(-1.0, 1.0)])
                .collect();
            let mut sum = [0.0; 3];
            for column in &many {
                let factor = random.unit();
                sum.iter_mut()
                    .zip(column)
                    .for_each(|(s, c)| *s += factor * c);
            }
            assert!(distance(&many, sum) < 1e-11 * size(&sum));
            // all edges lie in the upper half space: nothing below the plane y = 0 is near
            assert!(distance(&many, [0.0, -2.0, 0.0]) >= 2.0 - 1e-12);
        }
    }

    #[test]
    fn pyramids_lie_inside_and_around_the_cone() {
        let n = [0.0, 0.6, 0.8];
        for k in 0..100 {
            let [a, b] = tangents(n)[..] else { panic!() };
            let (s, c) = (0.0628 * f64::from(k)).sin_cos();
            let along = plus(times(c, a), s, b);
            let at = |reach: f64| plus(n, 0.3 * reach, along);
            let off = |around, reach| distance(&cone(n, 0.3, 16, around), at(reach));
            assert!(off(true, 1.0) < 1e-14 && off(true, 1.03) > 1e-4);
            assert!(off(false, 0.98) < 1e-14 && off(false, 1.0 + 1e-9) > 1e-12);
        }
        let flat = cone([0.0, 1.0], 0.3, 16, true);
        assert_eq!(flat, [[-0.3, 1.0], [0.3, 1.0]]);
    }

    #[test]
    fn the_end_of_a_lever_is_sharp() {
        // pushes between x = 0 and x = 1: a resultant at 1.01 is outside by its couple
        let pushes: Vec<[f64; 3]> = (0..=20).map(|i| [0.0, 1.0, f64::from(i) / 20.0]).collect();
        assert!(distance(&pushes, [0.0, 5.0, 4.999]) < 1e-13);
        let far = distance(&pushes, [0.0, 5.0, 5.05]);
        assert!(far > 0.02 && far < 0.05, "{far}");
    }
}
