//! What vectors of the plane alone have: a product that is a number, and rotations by an angle.

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
fn quarter_exact(angle: f64) -> (f64, f64) {
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
