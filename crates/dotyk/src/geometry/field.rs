//! Numbers that may depend on place and time.
//!
//! Most fields are evaluated point by point. A *sampled* field is evaluated at many points at once, for sources that can only answer
//! so, such as a program in another language: before a loop over points its values there are [prepared](Field::prepare), and looked
//! up by the bits of the coordinates.

use crate::geometry::{Point, padded};
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::ops::{Add, Mul};
use std::sync::{Arc, Mutex, PoisonError};

type Function = dyn Fn([f64; 3], f64) -> f64 + Send + Sync;

/// Returns the values of `size` components at some points and a time, point by point, (points · size,); another length means no
/// answer.
pub type Sampler = dyn Fn(&[[f64; 3]], f64) -> Vec<f64> + Send + Sync;

/// Values at one time, by the bits of the points.
type Values = HashMap<[u64; 3], Box<[f64]>>;

/// Most points that are remembered beyond those of the present time.
const REMEMBERED: usize = 1 << 20;

/// A sampler and its answers, the latest time last.
struct Samples {
    size: usize,
    sampler: Box<Sampler>,
    answers: Mutex<Vec<(u64, Values)>>,
}

fn bits(point: &[f64; 3]) -> [u64; 3] {
    point.map(f64::to_bits)
}

impl Samples {
    /// Samples those of the points that have no answer yet, and calls `then` with all answers at that time.
    fn with<T>(&self, points: &[[f64; 3]], time: f64, then: impl FnOnce(&Values) -> T) -> T {
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        let place = answers
            .iter()
            .position(|(known, _)| *known == time.to_bits());
        let place = place.unwrap_or_else(|| {
            let mut kept: usize = answers.iter().map(|(_, values)| values.len()).sum();
            answers.retain(|(_, values)| {
                let stays = kept <= REMEMBERED;
                kept -= if stays { 0 } else { values.len() };
                stays
            });
            answers.push((time.to_bits(), Values::new()));
            answers.len() - 1
        });
        let values = &mut answers[place].1;
        let mut seen = HashSet::new();
        let missing =
            |point: &&[f64; 3]| !values.contains_key(&bits(point)) && seen.insert(bits(point));
        let asked: Vec<[f64; 3]> = points.iter().filter(missing).copied().collect();
        if !asked.is_empty() {
            let found = (self.sampler)(&asked, time);
            if found.len() == asked.len() * self.size {
                let found = found.chunks_exact(self.size).map(Box::from);
                values.extend(asked.iter().map(bits).zip(found));
            }
        }
        then(values)
    }

    /// Samples those of the points that have no answer yet.
    fn prepare(&self, points: &[[f64; 3]], time: f64) {
        self.with(points, time, |_| ());
    }

    /// A component at a point; NaN without an answer.
    fn at(&self, component: usize, point: [f64; 3], time: f64) -> f64 {
        self.with(&[point], time, |values| {
            let value = values.get(&bits(&point)).and_then(|own| own.get(component));
            value.copied().unwrap_or(f64::NAN)
        })
    }
}

/// A number that may depend on the place (x, y, z; missing coordinates are zero) and the time t.
#[derive(Clone)]
pub struct Field {
    constant: f64,
    function: Option<Arc<Function>>,
    /// Its sampled parts.
    samples: Vec<Arc<Samples>>,
    text: String,
}

impl Field {
    /// The same value everywhere.
    pub fn constant(value: f64) -> Self {
        Self {
            constant: value,
            function: None,
            samples: Vec::new(),
            text: format!("{value}"),
        }
    }

    /// A function of ([x, y, z], t); `text` is how messages and reports name it.
    pub fn function(text: &str, f: impl Fn([f64; 3], f64) -> f64 + Send + Sync + 'static) -> Self {
        Self {
            constant: 0.0,
            function: Some(Arc::new(f)),
            samples: Vec::new(),
            text: text.to_string(),
        }
    }

    /// The `size` components of a sampler, which are sampled together.
    pub fn sampled(text: &str, size: usize, sampler: Box<Sampler>) -> Vec<Self> {
        let samples = Arc::new(Samples {
            size,
            sampler,
            answers: Mutex::default(),
        });
        let component = |component: usize| {
            let own = Arc::clone(&samples);
            let text = match size {
                1 => text.to_string(),
                _ => format!("{text}[{component}]"),
            };
            Self {
                samples: vec![Arc::clone(&samples)],
                ..Self::function(&text, move |point, time| own.at(component, point, time))
            }
        };
        (0..size).map(component).collect()
    }

    /// A function of other fields, which are sampled together with it.
    pub(crate) fn of<const N: usize>(
        text: &str,
        others: [&Self; N],
        f: impl Fn([f64; 3], f64) -> f64 + Send + Sync + 'static,
    ) -> Self {
        let samples = others.into_iter().flat_map(|other| &other.samples);
        Self {
            samples: samples.cloned().collect(),
            ..Self::function(text, f)
        }
    }

    /// Samples the values of sampled fields at all points of a loop at once. Other fields cost nothing.
    pub(crate) fn prepare<'f, const D: usize>(
        fields: impl IntoIterator<Item = &'f Self>,
        points: impl IntoIterator<Item = Point<D>>,
        time: f64,
    ) {
        let mut samples = fields.into_iter().flat_map(|field| &field.samples);
        if let Some(first) = samples.next() {
            let points: Vec<[f64; 3]> = points.into_iter().map(padded).collect();
            first.prepare(&points, time);
            samples.for_each(|samples| samples.prepare(&points, time));
        }
    }

    /// It is sampled at many points at once.
    pub(crate) fn is_sampled(&self) -> bool {
        !self.samples.is_empty()
    }

    /// Value at a point and time. May be not finite: the caller knows which side and point to name.
    pub fn at<const D: usize>(&self, point: Point<D>, time: f64) -> f64 {
        match &self.function {
            None => self.constant,
            Some(f) => f(padded(point), time),
        }
    }

    /// Equal constants, or copies of one function: other functions may have the same values, which nobody knows.
    pub(crate) fn is_copy_of(&self, other: &Self) -> bool {
        match (&self.function, &other.function) {
            (None, None) => self.constant == other.constant,
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            _ => false,
        }
    }

    /// The value, when it is the same everywhere.
    pub fn as_constant(&self) -> Option<f64> {
        self.function.is_none().then_some(self.constant)
    }

    /// Itself, or a number where it is smaller than that; what is no number stays so.
    pub fn at_least(self, least: f64) -> Self {
        let raised = move |value: f64| if value < least { least } else { value };
        match self.as_constant() {
            Some(value) => Self::constant(raised(value)),
            None => {
                let text = format!("max({least}, {self})");
                let own = self.clone();
                Self::of(&text, [&self], move |x, t| raised(own.at(x, t)))
            }
        }
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
                let [a, b] = [self.clone(), other.clone()];
                Self::of(&text, [&self, &other], move |x, t| a.at(x, t) + b.at(x, t))
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
                let [a, b] = [self.clone(), other.clone()];
                Self::of(&text, [&self, &other], move |x, t| a.at(x, t) * b.at(x, t))
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
    use std::sync::atomic::{AtomicUsize, Ordering};

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

    #[test]
    fn sampled_fields_are_asked_once_for_all_points_and_components() {
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        let sampler = |points: &[[f64; 3]], t: f64| {
            CALLS.fetch_add(1, Ordering::Relaxed);
            points.iter().flat_map(|p| [p[0] + t, p[1]]).collect()
        };
        let fields = Field::sampled("f", 2, Box::new(sampler));
        let doubled = fields[0].clone() * Field::from(2.0);
        let points = [[1.0, 2.0], [3.0, 4.0], [1.0, 2.0]];
        Field::prepare([&doubled, &fields[1]], points, 0.5);
        assert_eq!(CALLS.load(Ordering::Relaxed), 1);
        assert_eq!(doubled.at([3.0, 4.0], 0.5), 7.0);
        assert_eq!(fields[1].at([1.0, 2.0], 0.5), 2.0);
        assert_eq!(CALLS.load(Ordering::Relaxed), 1);
        assert_eq!(fields[1].to_string(), "f[1]");
        // at another time, or at an unprepared place, it is sampled again; known values are not sampled twice
        assert_eq!(fields[0].at([1.0, 2.0], 1.0), 2.0);
        assert_eq!(fields[0].at([9.0, 2.0], 1.0), 10.0);
        assert_eq!(fields[0].at([3.0, 4.0], 0.5), 3.5);
        assert_eq!(CALLS.load(Ordering::Relaxed), 3);
    }

    #[test]
    fn a_sampler_without_an_answer_gives_no_number() {
        let fields = Field::sampled("f", 1, Box::new(|_, _| Vec::new()));
        assert!(fields[0].at([1.0, 2.0], 0.5).is_nan());
    }
}
