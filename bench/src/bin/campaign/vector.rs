//! Small vectors of any dimension.

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
