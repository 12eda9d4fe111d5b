//! Points and vectors of the plane, and rigid motions.

pub use crate::vector::{bounds, dot, length, minus, plus, times, unit};

/// A point or vector.
pub type Vector = [f64; 2];

/// a × b.
pub fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// a turned by +90°.
pub fn turned(a: Vector) -> Vector {
    [-a[1], a[0]]
}

/// a turned by an angle.
pub fn rotated(a: Vector, angle: f64) -> Vector {
    let (s, c) = quarter_exact(angle);
    [c * a[0] - s * a[1], s * a[0] + c * a[1]]
}

/// The rows of that rotation.
pub fn rotation(angle: f64) -> [Vector; 2] {
    let (s, c) = quarter_exact(angle);
    [[c, -s], [s, c]]
}

/// Sine and cosine, exact at multiples of 90°.
pub fn quarter_exact(angle: f64) -> (f64, f64) {
    let quarters = angle / std::f64::consts::FRAC_PI_2;
    if (quarters - quarters.round()).abs() < 1e-12 {
        match (quarters.round() as i64).rem_euclid(4) {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        }
    } else {
        angle.sin_cos()
    }
}

/// The rigid motion a + ω × (x − centre) that fits some displacements best (least squares): (centre, a, ω). With axial
/// symmetry only a translation along y.
pub fn fitted_motion(
    points: &[Vector],
    moves: &[Vector],
    axisymmetric: bool,
) -> (Vector, Vector, f64) {
    let n = points.len().max(1) as f64;
    let mean =
        |list: &[Vector]| times(1.0 / n, list.iter().fold([0.0; 2], |s, &v| plus(s, 1.0, v)));
    let (centre, shift) = (mean(points), mean(moves));
    if axisymmetric {
        return (centre, [0.0, shift[1]], 0.0);
    }
    let (mut turn, mut inertia) = (0.0, 0.0);
    for (&x, &u) in points.iter().zip(moves) {
        let arm = minus(x, centre);
        turn += cross(arm, minus(u, shift));
        inertia += dot(arm, arm);
    }
    (
        centre,
        shift,
        if inertia > 0.0 { turn / inertia } else { 0.0 },
    )
}

/// Displacements without the rigid motion that fits them best.
pub fn without_motion(points: &[Vector], moves: &[Vector], axisymmetric: bool) -> Vec<Vector> {
    let (centre, shift, turn) = fitted_motion(points, moves, axisymmetric);
    let rest =
        |(&x, &u): (&Vector, &Vector)| plus(minus(u, shift), -turn, turned(minus(x, centre)));
    points.iter().zip(moves).map(rest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigid_motions_leave_nothing() {
        let points = [[0.0, 0.0], [2.0, 0.5], [1.0, 3.0]];
        let moves = points.map(|p| plus([0.3, -0.2], 0.01, turned(p)));
        for rest in without_motion(&points, &moves, false) {
            assert!(length(rest) < 1e-15);
        }
    }
}
