//! Numbers that are linear functions of the place, times a function of time: loads, prescribed displacements, gaps.

use crate::vector::{applied, dot};

/// The factor of a term as a function of the time t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Time {
    /// Constant.
    Always,
    /// a + b·t.
    Line(f64, f64),
    /// sin(ω·t + φ).
    Wave(f64, f64),
    /// The same wave with a clock that stands still between two times: ω, φ, from, to.
    Rest(f64, f64, f64, f64),
}

impl Time {
    fn at(self, t: f64) -> f64 {
        match self {
            Self::Always => 1.0,
            Self::Line(a, b) => a + b * t,
            Self::Wave(omega, phase) => (omega * t + phase).sin(),
            Self::Rest(omega, phase, from, to) => {
                (omega * (t.min(from) + (t - to).max(0.0)) + phase).sin()
            }
        }
    }
}

/// (constant + slope·x)·time.
#[derive(Debug, Clone, PartialEq)]
pub struct Term<const D: usize = 2> {
    pub constant: f64,
    pub slope: [f64; D],
    pub time: Time,
}

/// A sum of terms; an empty one is zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Amount<const D: usize = 2>(pub Vec<Term<D>>);

impl<const D: usize> From<f64> for Amount<D> {
    fn from(constant: f64) -> Self {
        Self::new(constant, [0.0; D], Time::Always)
    }
}

impl<const D: usize> Amount<D> {
    /// A sum of one term.
    pub fn new(constant: f64, slope: [f64; D], time: Time) -> Self {
        Self(vec![Term {
            constant,
            slope,
            time,
        }])
    }

    /// A constant times a function of time.
    pub fn timed(constant: f64, time: Time) -> Self {
        Self::new(constant, [0.0; D], time)
    }

    /// The sum of two numbers.
    pub fn and(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Value at a point and a time.
    pub fn at(&self, x: [f64; D], t: f64) -> f64 {
        let terms = self.0.iter();
        terms
            .map(|term| (term.constant + dot(term.slope, x)) * term.time.at(t))
            .sum()
    }

    /// It is zero everywhere and always.
    pub fn is_zero(&self) -> bool {
        self.0
            .iter()
            .all(|term| term.constant == 0.0 && term.slope == [0.0; D])
    }

    /// factor times the same at places that were moved from x to `lengths`·Qx.
    pub fn moved(&self, factor: f64, lengths: f64, turn: [[f64; D]; D]) -> Self {
        let term = |term: &Term<D>| Term {
            constant: factor * term.constant,
            slope: applied(turn, term.slope).map(|c| factor * c / lengths),
            time: term.time,
        };
        Self(self.0.iter().map(term).collect())
    }

    /// factor times this.
    pub fn times(&self, factor: f64) -> Self {
        let term = |term: &Term<D>| Term {
            constant: factor * term.constant,
            slope: term.slope.map(|c| factor * c),
            time: term.time,
        };
        Self(self.0.iter().map(term).collect())
    }

    /// In the form of a case file: a number, or an expression in quotes.
    pub fn text(&self) -> String {
        match &self.0[..] {
            [] => "0.0".to_string(),
            [
                Term {
                    constant,
                    slope,
                    time: Time::Always,
                },
            ] if *slope == [0.0; D] => format!("{constant:?}"),
            terms => {
                let each: Vec<String> = terms.iter().map(expression).collect();
                format!("\"{}\"", each.join(" + "))
            }
        }
    }
}

fn expression<const D: usize>(term: &Term<D>) -> String {
    let mut place = format!("{:?}", term.constant);
    for (slope, name) in term.slope.iter().zip(["x", "y", "z"]) {
        if *slope != 0.0 {
            place += &format!(" + ({slope:?})*{name}");
        }
    }
    match term.time {
        Time::Always => format!("({place})"),
        Time::Line(a, b) => format!("({place})*({a:?} + ({b:?})*t)"),
        Time::Wave(omega, phase) => format!("({place})*sin({omega:?}*t + ({phase:?}))"),
        Time::Rest(omega, phase, from, to) => format!(
            "({place})*sin({omega:?}*(min(t, {from:?}) + max(0, t - {to:?})) + ({phase:?}))"
        ),
    }
}

/// All components of a vector field at a place and a time.
pub fn vector_at<const D: usize>(field: &[Amount<D>; D], x: [f64; D], t: f64) -> [f64; D] {
    field.each_ref().map(|component| component.at(x, t))
}

/// A vector field with turned vectors at turned and scaled places: f·Q v(x) at lengths·Qx.
pub fn moved_vector<const D: usize>(
    field: &[Amount<D>; D],
    factor: f64,
    lengths: f64,
    turn: [[f64; D]; D],
) -> [Amount<D>; D] {
    turn.map(|row| {
        let mut sum = Amount::default();
        for (weight, component) in row.into_iter().zip(field) {
            if weight != 0.0 && !component.is_zero() {
                sum = sum.and(component.moved(weight * factor, lengths, turn));
            }
        }
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::{rotated, rotation};
    use crate::vector::times;

    #[test]
    fn a_turned_field_gives_turned_vectors_at_turned_places() {
        let field = [
            Amount::new(1.0, [0.5, -2.0], Time::Wave(1.1, 0.2)),
            Amount::new(-0.3, [0.1, 0.7], Time::Line(0.0, 2.0)),
        ];
        let (angle, x, t) = (0.7, [0.4, -1.2], 1.5);
        let turned = moved_vector(&field, 3.0, 2.0, rotation(angle));
        let there = times(2.0, rotated(x, angle));
        let expected = times(3.0, rotated(vector_at(&field, x, t), angle));
        let found = vector_at(&turned, there, t);
        assert!((0..2).all(|d| (found[d] - expected[d]).abs() < 1e-14));
    }

    #[test]
    fn constants_are_numbers_and_the_rest_expressions() {
        assert_eq!(Amount::<2>::from(-2.5).text(), "-2.5");
        let wave = Amount::new(1.0, [0.0, -2.0], Time::Line(0.5, -1.0));
        assert_eq!(wave.text(), "\"(1.0 + (-2.0)*y)*(0.5 + (-1.0)*t)\"");
    }
}
