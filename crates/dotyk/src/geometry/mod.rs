//! Points and small vectors of `[f64; D]`, scalar fields over them, and analytic surfaces.
//!
//! Plain functions on arrays: nothing here knows a mesh or a body.

mod matrix;
mod surface;

pub(crate) use matrix::{determinant, invert};
pub use surface::Surface;

use std::fmt;
use std::ops::{Add, Mul};
use std::sync::Arc;

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

/// The first three components, missing ones zero: what files with three components want.
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

/// When Newton's steps to a place on a facet or in a cell have come to an end.
///
/// Rounding of coordinates that are large beside the facet shows in every step, so that no fixed number tells: steps end
/// where they are nothing beside the place, and near it as soon as they no longer fall.
pub(crate) struct Settling {
    before: f64,
}

impl Settling {
    /// Steps below this part of a place are nothing.
    const NOTHING: f64 = 1e-13;

    /// Steps that no longer fall are rounding below this part; above, Newton's method may still find its way.
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

type Function = dyn Fn([f64; 3], f64) -> f64 + Send + Sync;

/// A number that may depend on the place (x, y, z; missing coordinates are zero) and the time t.
#[derive(Clone)]
pub struct Field {
    constant: f64,
    function: Option<Arc<Function>>,
    text: String,
}

impl Field {
    /// The same value everywhere.
    pub fn constant(value: f64) -> Self {
        Self {
            constant: value,
            function: None,
            text: format!("{value}"),
        }
    }

    /// A function of ([x, y, z], t); `text` is how messages and reports name it.
    pub fn function(text: &str, f: impl Fn([f64; 3], f64) -> f64 + Send + Sync + 'static) -> Self {
        Self {
            constant: 0.0,
            function: Some(Arc::new(f)),
            text: text.to_string(),
        }
    }

    /// Value at a point and time. May be not finite: the caller knows which side and point to name.
    pub fn at<const D: usize>(&self, point: Point<D>, time: f64) -> f64 {
        match &self.function {
            None => self.constant,
            Some(f) => f(padded(point), time),
        }
    }

    /// The value, when it is the same everywhere.
    pub fn as_constant(&self) -> Option<f64> {
        self.function.is_none().then_some(self.constant)
    }
}

impl Add for Field {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        match [self.as_constant(), other.as_constant()] {
            [Some(a), Some(b)] => Self::constant(a + b),
            [Some(0.0), _] => other,
            [_, Some(0.0)] => self,
            _ => {
                let text = format!("{self} + {other}");
                Self::function(&text, move |x, t| self.at(x, t) + other.at(x, t))
            }
        }
    }
}

impl Mul for Field {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        match [self.as_constant(), other.as_constant()] {
            [Some(a), Some(b)] => Self::constant(a * b),
            [Some(0.0), _] | [_, Some(0.0)] => Self::constant(0.0),
            _ => {
                let text = format!("({self}) * ({other})");
                Self::function(&text, move |x, t| self.at(x, t) * other.at(x, t))
            }
        }
    }
}

impl From<f64> for Field {
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl fmt::Debug for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Field({})", self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_vector_has_no_direction() {
        assert_eq!(unit([0.0, 0.0]), None);
        assert_eq!(unit([0.0, -2.0]), Some([0.0, -1.0]));
    }

    #[test]
    fn fields_know_whether_they_are_constant() {
        assert_eq!(Field::from(2.0).as_constant(), Some(2.0));
        let f = Field::function("x + t", |p, t| p[0] + t);
        assert_eq!(f.as_constant(), None);
        assert_eq!(f.at([3.0, 0.0], 0.5), 3.5);
    }

    #[test]
    fn fields_add_up() {
        let f = || Field::function("x + t", |p, t| p[0] + t);
        let sum = f() + Field::from(2.0);
        assert_eq!((sum.at([3.0, 0.0], 0.5), sum.as_constant()), (5.5, None));
        assert_eq!(sum.to_string(), "x + t + 2");
        let constant = Field::from(2.0) + Field::from(-0.5);
        assert_eq!(constant.as_constant(), Some(1.5));
        assert_eq!((f() + Field::from(0.0)).to_string(), "x + t");
        assert_eq!((Field::from(0.0) + f()).to_string(), "x + t");
    }

    #[test]
    fn fields_multiply() {
        let f = || Field::function("x + t", |p, t| p[0] + t);
        let product = Field::from(2.0) * f();
        assert_eq!(product.at([3.0, 0.0], 0.5), 7.0);
        assert_eq!(product.as_constant(), None);
        assert_eq!(product.to_string(), "(2) * (x + t)");
        let constant = Field::from(2.0) * Field::from(-0.5);
        assert_eq!(constant.as_constant(), Some(-1.0));
        assert_eq!((f() * Field::from(0.0)).as_constant(), Some(0.0));
    }
}
