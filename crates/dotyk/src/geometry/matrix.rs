//! Small square matrices, by rows.

/// Determinant of a matrix of order one, two or three, given by rows.
pub fn determinant<const D: usize>(m: &[[f64; D]; D]) -> f64 {
    match D {
        1 => m[0][0],
        2 => m[0][0] * m[1][1] - m[0][1] * m[1][0],
        _ => {
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        }
    }
}

/// Inverse and determinant of a matrix of order one, two or three, by cofactors; a singular one gives values that are not
/// finite.
pub fn invert<const D: usize>(m: &[[f64; D]; D]) -> ([[f64; D]; D], f64) {
    let determinant = determinant(m);
    let cofactor = |i: usize, j: usize| match D {
        1 => 1.0,
        2 => {
            let sign = if i == j { 1.0 } else { -1.0 };
            sign * m[1 - i][1 - j]
        }
        _ => {
            let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            m[a][c] * m[b][d] - m[a][d] * m[b][c]
        }
    };
    let inverse = std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / determinant));
    (inverse, determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const D: usize>(m: [[f64; D]; D], expected: f64) {
        let (inverse, determinant) = invert(&m);
        assert!((determinant - expected).abs() < 1e-14 * expected.abs());
        for (i, row) in m.iter().enumerate() {
            let product: [f64; D] =
                std::array::from_fn(|j| (0..D).map(|k| row[k] * inverse[k][j]).sum());
            for (j, entry) in product.into_iter().enumerate() {
                let unit = f64::from(u8::from(i == j));
                assert!((entry - unit).abs() < 1e-14, "({i}, {j}): {entry}");
            }
        }
    }

    #[test]
    fn a_matrix_times_its_inverse_is_the_identity() {
        check([[4.0]], 4.0);
        check([[1.0, 2.0], [3.0, 5.0]], -1.0);
        check([[2.0, 1.0, 0.5], [0.0, 3.0, 1.0], [1.0, -1.0, 4.0]], 25.5);
    }
}
