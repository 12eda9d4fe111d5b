//! Points and vectors of the plane and of space, rotations, and rigid motions.

use crate::random::Random;

/// a − b.
pub fn minus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| a[d] - b[d])
}

/// a + s·b.
pub fn plus<const D: usize>(a: [f64; D], s: f64, b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| a[d] + s * b[d])
}

/// s·a.
pub fn times<const D: usize>(s: f64, a: [f64; D]) -> [f64; D] {
    a.map(|c| s * c)
}

/// a·b.
pub fn dot<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// |a|.
pub fn length<const D: usize>(a: [f64; D]) -> f64 {
    a.iter().fold(0.0, |size: f64, c| size.hypot(*c))
}

/// a/|a|; zero stays zero.
pub fn unit<const D: usize>(a: [f64; D]) -> [f64; D] {
    let size = length(a);
    if size > 0.0 { a.map(|c| c / size) } else { a }
}

/// a without its part along a unit vector.
pub fn across<const D: usize>(a: [f64; D], n: [f64; D]) -> [f64; D] {
    plus(a, -dot(a, n), n)
}

/// The sum of some vectors.
pub fn sum<const D: usize>(all: impl IntoIterator<Item = [f64; D]>) -> [f64; D] {
    all.into_iter().fold([0.0; D], |s, v| plus(s, 1.0, v))
}

/// The mean of some points.
pub fn mean<const D: usize>(points: &[[f64; D]]) -> [f64; D] {
    times(
        1.0 / points.len().max(1) as f64,
        sum(points.iter().copied()),
    )
}

/// The unit vectors along the axes, which are the rows of the identity.
pub fn axes<const D: usize>() -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

/// A vector as one of space; the plane is z = 0.
pub fn raised<const D: usize>(a: [f64; D]) -> [f64; 3] {
    std::array::from_fn(|d| a.get(d).copied().unwrap_or(0.0))
}

/// The first components of a vector of space.
pub fn lowered<const D: usize>(a: [f64; 3]) -> [f64; D] {
    std::array::from_fn(|d| a[d])
}

/// a × b; along z for vectors of the plane.
pub fn cross<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; 3] {
    let (a, b) = (raised(a), raised(b));
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The unit vectors perpendicular to a unit vector and to each other: in the plane the one turned by +90°, in space two.
pub fn tangents<const D: usize>(n: [f64; D]) -> Vec<[f64; D]> {
    if D == 2 {
        return vec![lowered([-n[1], n[0], 0.0])];
    }
    let least = (0..D).min_by(|&i, &j| n[i].abs().total_cmp(&n[j].abs()));
    let first = unit(across(axes()[least.unwrap_or(0)], n));
    vec![first, lowered(cross(n, first))]
}

/// Q a, Q given by its rows.
pub fn applied<const D: usize>(rows: [[f64; D]; D], a: [f64; D]) -> [f64; D] {
    rows.map(|row| dot(row, a))
}

/// Qᵀ.
pub fn transposed<const D: usize>(rows: [[f64; D]; D]) -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| rows[j][i]))
}

/// Corners of the smallest box around some points.
pub fn bounds<const D: usize>(points: &[[f64; D]]) -> ([f64; D], [f64; D]) {
    let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for point in points {
        for d in 0..D {
            low[d] = low[d].min(point[d]);
            high[d] = high[d].max(point[d]);
        }
    }
    (low, high)
}

/// A rotation of space, any one as likely as any other: that of a random unit quaternion.
pub fn random_rotation(random: &mut Random) -> [[f64; 3]; 3] {
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

/// Displacements without the rigid motion a + ω × (x − centre) that fits them best (least squares). Bodies of revolution
/// (`revolved`) move rigidly along y alone.
pub fn without_motion<const D: usize>(
    points: &[[f64; D]],
    moves: &[[f64; D]],
    revolved: bool,
) -> Vec<[f64; D]> {
    let (centre, shift) = (mean(points), mean(moves));
    if revolved {
        let along = times(shift[1], axes()[1]);
        return moves.iter().map(|&u| minus(u, along)).collect();
    }
    let mut turns: Vec<Vec<[f64; D]>> = Vec::new();
    let mut rest: Vec<[f64; D]> = moves.iter().map(|&u| minus(u, shift)).collect();
    let product =
        |a: &[[f64; D]], b: &[[f64; D]]| -> f64 { a.iter().zip(b).map(|(&a, &b)| dot(a, b)).sum() };
    // the plane turns about z alone
    for axis in &axes::<3>()[if D == 2 { 2 } else { 0 }..] {
        // each rotation without those before
        let arms = points.iter().map(|&x| raised(minus(x, centre)));
        let mut turn: Vec<[f64; D]> = arms.map(|arm| lowered(cross(*axis, arm))).collect();
        for known in &turns {
            let part = product(&turn, known) / product(known, known);
            for (t, &k) in turn.iter_mut().zip(known) {
                *t = plus(*t, -part, k);
            }
        }
        let size = product(&turn, &turn);
        let part = if size > 0.0 {
            product(&rest, &turn) / size
        } else {
            0.0
        };
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

    fn leaves_nothing<const D: usize>(random: &mut Random) {
        let points: Vec<[f64; D]> = (0..9).map(|_| [0; D].map(|_| random.unit())).collect();
        let spin = |x: [f64; D]| {
            let axis = if D == 2 {
                [0.0, 0.0, 2.0]
            } else {
                [1.0, -2.0, 0.5]
            };
            lowered(cross(axis, raised(x)))
        };
        let moves: Vec<[f64; D]> = points
            .iter()
            .map(|&x| plus(lowered([0.3, -0.2, 0.1]), 0.1, spin(x)))
            .collect();
        for rest in without_motion(&points, &moves, false) {
            assert!(length(rest) < 1e-15);
        }
    }

    #[test]
    fn rotations_turn_and_rigid_motions_leave_nothing() {
        let mut random = Random::new(5);
        let turn = random_rotation(&mut random);
        let back = transposed(turn);
        for (row, axis) in turn.into_iter().zip(axes()) {
            assert!(length(minus(applied(turn, applied(back, axis)), axis)) < 1e-15);
            let [a, b] = tangents(row)[..] else { panic!() };
            assert!(length(minus(cross(a, b), row)) < 1e-15);
        }
        assert!((dot(cross(turn[0], turn[1]), turn[2]) - 1.0).abs() < 1e-15);
        leaves_nothing::<2>(&mut random);
        leaves_nothing::<3>(&mut random);
    }
}
