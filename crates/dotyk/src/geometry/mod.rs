//! Points and small vectors of `[f64; D]`, scalar fields over them, and analytic surfaces.
//!
//! Plain functions on arrays: nothing here knows a mesh or a body.

mod field;
mod matrix;
mod surface;
mod union;

pub use field::{Field, Sampler};
pub(crate) use matrix::{determinant, invert};
pub use surface::Surface;
pub(crate) use union::Groups;

/// A point or vector of the D-dimensional space.
pub type Point<const D: usize> = [f64; D];

/// a − b.
pub fn sub<const D: usize>(a: Point<D>, b: Point<D>) -> Point<D> {
    std::array::from_fn(|i| a[i] - b[i])
}

/// a + s·b.
pub fn add_scaled<const D: usize>(a: Point<D>, s: f64, b: Point<D>) -> Point<D> {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// Inner product a·b.
pub fn dot<const D: usize>(a: Point<D>, b: Point<D>) -> f64 {
    (0..D).map(|i| a[i] * b[i]).sum()
}

/// Euclidean length of a.
pub fn norm<const D: usize>(a: Point<D>) -> f64 {
    dot(a, a).sqrt()
}

/// Distance of two points.
pub fn distance<const D: usize>(a: Point<D>, b: Point<D>) -> f64 {
    norm(sub(a, b))
}

/// a × b in three dimensions, missing components zero; in the plane only the third component is not zero.
pub fn cross<const D: usize>(a: Point<D>, b: Point<D>) -> [f64; 3] {
    let (a, b) = (padded(a), padded(b));
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// a/|a|, or `None` when a is zero or not finite.
pub fn unit<const D: usize>(a: Point<D>) -> Option<Point<D>> {
    let length = norm(a);
    (length > 0.0 && length.is_finite()).then(|| a.map(|c| c / length))
}

/// The first three components, missing ones zero, for files with three components.
pub fn padded<const D: usize>(a: Point<D>) -> [f64; 3] {
    std::array::from_fn(|i| if i < D { a[i] } else { 0.0 })
}

/// Smallest box that holds all points: (lower corner, upper corner). Empty input gives an inverted infinite box.
pub fn bounding_box<const D: usize>(points: &[Point<D>]) -> (Point<D>, Point<D>) {
    let mut low = [f64::INFINITY; D];
    let mut high = [f64::NEG_INFINITY; D];
    for point in points {
        for i in 0..D {
            low[i] = low[i].min(point[i]);
            high[i] = high[i].max(point[i]);
        }
    }
    (low, high)
}

/// The end of Newton's steps to a place on a facet or in a cell.
///
/// Coordinates that are large beside the facet round every step, so that no fixed limit is possible: steps end where they are
/// negligible beside the place, and near it as soon as they no longer decrease.
pub(crate) struct Settling {
    before: f64,
}

impl Settling {
    /// Steps below this part of a place are negligible.
    const NOTHING: f64 = 1e-13;

    /// Steps that no longer decrease are rounding below this part; above it Newton's method may still converge.
    const NEAR: f64 = 1e-7;

    pub fn new() -> Self {
        Self {
            before: f64::INFINITY,
        }
    }

    /// Whether a step to a place, both in reference coordinates, was the last.
    pub fn ends(&mut self, step: &[f64], at: &[f64]) -> bool {
        let largest = |v: &[f64]| v.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        let part = largest(step) / (1.0 + largest(at));
        let falls = part < 0.5 * std::mem::replace(&mut self.before, part);
        step.iter().all(|c| c.is_finite()) && (part < Self::NOTHING || part < Self::NEAR && !falls)
    }
}

/// The part of a convex polygon where a linear function is not negative.
pub(crate) fn clip<P: Copy>(
    polygon: &[P],
    inside: impl Fn(P) -> f64,
    between: impl Fn(P, P, f64) -> P,
) -> Vec<P> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (a, b) = (inside(p), inside(q));
        if a >= 0.0 {
            left.push(p);
        }
        if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
            left.push(between(p, q, a / (a - b)));
        }
    }
    left
}

/// Mean of some points.
pub(crate) fn centroid<const D: usize>(points: &[Point<D>]) -> Point<D> {
    let sum = points
        .iter()
        .fold([0.0; D], |sum, &x| add_scaled(sum, 1.0, x));
    sum.map(|c| c / points.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_vector_has_no_direction() {
        assert_eq!(unit([0.0, 0.0]), None);
        assert_eq!(unit([0.0, -2.0]), Some([0.0, -1.0]));
    }
}
