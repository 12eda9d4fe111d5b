//! Numbers that are computed from the values of other probes: a torque, a mean of two places, a ratio.
//!
//! ```text
//!   value = f(p₁, .., pₙ, t)      with the values pₖ of named probes of the same step, each of one number
//! ```
//!
//! The value is not a number where one of the pₖ is undefined, that is not finite, whatever f does with it: 0·p is no exception.

use std::fmt;
use std::sync::Arc;

type Function = dyn Fn(&[f64], f64) -> f64 + Send + Sync;

/// A number of the values of other probes and of the time.
#[derive(Clone)]
pub struct Formula {
    text: String,
    probes: Vec<String>,
    function: Arc<Function>,
}

impl Formula {
    /// A function of the values of these probes, in their order, and of the time; `text` is how results name it.
    pub fn new(
        text: &str,
        probes: impl IntoIterator<Item = String>,
        function: impl Fn(&[f64], f64) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self {
            text: text.to_string(),
            probes: probes.into_iter().collect(),
            function: Arc::new(function),
        }
    }

    /// Names of the probes whose values it takes.
    pub fn probes(&self) -> &[String] {
        &self.probes
    }

    /// Its value at a time, where `known` gives the values of probes; NaN where one of them is not finite or not there.
    pub(crate) fn value(&self, known: impl Fn(&str) -> Option<f64>, time: f64) -> f64 {
        let values = self.probes.iter().map(|name| known(name));
        let values: Option<Vec<f64>> = values
            .map(|value| value.filter(|value| value.is_finite()))
            .collect();
        values.map_or(f64::NAN, |values| (self.function)(&values, time))
    }
}

impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl fmt::Debug for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Formula({})", self.text)
    }
}

/// By text and probes: of functions nobody knows whether they are the same.
impl PartialEq for Formula {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text && self.probes == other.probes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_undefined_leaves_no_value() {
        let half = Formula::new("0*a + b", ["a", "b"].map(String::from), |v, t| {
            0.0 * v[0] + t * v[1]
        });
        let of = |a: Option<f64>| half.value(|name| if name == "a" { a } else { Some(3.0) }, 2.0);
        assert_eq!(of(Some(1.0)), 6.0);
        for undefined in [None, Some(f64::NAN), Some(f64::INFINITY)] {
            assert!(of(undefined).is_nan());
        }
    }
}
