//! Vectors of space, rotations, and rigid motions.

use crate::random::Random;
pub use crate::vector::{applied, bounds, dot, length, minus, plus, times, unit};

/// A point or vector.
pub type Vector = [f64; 3];

/// The rows of a matrix.
pub type Matrix = [Vector; 3];

/// The directions x, y and z, and the identity rotation.
pub const AXES: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// a × b.
pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// a without its part along a unit vector.
pub fn across(a: Vector, n: Vector) -> Vector {
    plus(a, -dot(a, n), n)
}

/// Two unit vectors perpendicular to a unit vector and to each other.
pub fn tangents(n: Vector) -> [Vector; 2] {
    let least = (0..3).min_by(|&i, &j| n[i].abs().total_cmp(&n[j].abs()));
    let first = unit(across(AXES[least.unwrap_or(0)], n));
    [first, cross(n, first)]
}

/// The mean of some points.
pub fn mean(points: &[Vector]) -> Vector {
    let sum = points.iter().fold([0.0; 3], |s, &p| plus(s, 1.0, p));
    times(1.0 / points.len().max(1) as f64, sum)
}

/// A rotation, any one as likely as any other: that of a random unit quaternion.
pub fn random_rotation(random: &mut Random) -> Matrix {
    let [w, x, y, z] = loop {
        let q = [0; 4].map(|_| random.between(-1.0, 1.0));
        if (0.01..1.0).contains(&dot(q, q)) {
            break unit(q);
        }
    };
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// Displacements without the rigid motion a + ω × (x − centre) that fits them best (least squares).
pub fn without_motion(points: &[Vector], moves: &[Vector]) -> Vec<Vector> {
    let (centre, shift) = (mean(points), mean(moves));
    let mut turns: Vec<Vec<Vector>> = Vec::new();
    let mut rest: Vec<Vector> = moves.iter().map(|&u| minus(u, shift)).collect();
    let product =
        |a: &[Vector], b: &[Vector]| -> f64 { a.iter().zip(b).map(|(&a, &b)| dot(a, b)).sum() };
    for axis in AXES {
        // the three rotations, each without those before
        let mut turn: Vec<Vector> = points
            .iter()
            .map(|&x| cross(axis, minus(x, centre)))
            .collect();
        for known in &turns {
            let part = product(&turn, known) / product(known, known);
            for (t, &k) in turn.iter_mut().zip(known) {
                *t = plus(*t, -part, k);
            }
        }
        let part = product(&rest, &turn) / product(&turn, &turn);
        for (r, &t) in rest.iter_mut().zip(&turn) {
            *r = plus(*r, -part, t);
        }
        turns.push(turn);
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::transposed;

    #[test]
    fn rotations_turn_and_rigid_motions_leave_nothing() {
        let mut random = Random::new(5);
        let turn = random_rotation(&mut random);
        let back = transposed(turn);
        for (row, axis) in turn.into_iter().zip(AXES) {
            assert!(length(minus(applied(turn, applied(back, axis)), axis)) < 1e-15);
            let [a, b] = tangents(row);
            assert!(length(minus(cross(a, b), row)) < 1e-15);
        }
        assert!((dot(cross(turn[0], turn[1]), turn[2]) - 1.0).abs() < 1e-15);
        let points: Vec<Vector> = (0..9).map(|_| [0; 3].map(|_| random.unit())).collect();
        let moves: Vec<Vector> = points
            .iter()
            .map(|&x| plus([0.3, -0.2, 0.1], 0.1, cross([1.0, -2.0, 0.5], x)))
            .collect();
        for rest in without_motion(&points, &moves) {
            assert!(length(rest) < 1e-15);
        }
    }
}
