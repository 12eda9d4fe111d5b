//! Numbers that depend linearly on the place and somehow on the time: loads, prescribed displacements, gaps.

use crate::plane::{Vector, dot, rotated};

/// How a term depends on the time t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Time {
    /// Not at all.
    Always,
    /// a + b·t.
    Line(f64, f64),
    /// sin(ω·t + φ).
    Wave(f64, f64),
}

impl Time {
    fn at(self, t: f64) -> f64 {
        match self {
            Self::Always => 1.0,
            Self::Line(a, b) => a + b * t,
            Self::Wave(omega, phase) => (omega * t + phase).sin(),
        }
    }
}

/// (constant + slope·x)·time.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    pub constant: f64,
    pub slope: Vector,
    pub time: Time,
}

/// A sum of terms; an empty one is zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Amount(pub Vec<Term>);

impl From<f64> for Amount {
    fn from(constant: f64) -> Self {
        Self::new(constant, [0.0; 2], Time::Always)
    }
}

impl Amount {
    /// A sum of one term.
    pub fn new(constant: f64, slope: Vector, time: Time) -> Self {
        Self(vec![Term {
            constant,
            slope,
            time,
        }])
    }

    /// A constant times a function of time.
    pub fn timed(constant: f64, time: Time) -> Self {
        Self::new(constant, [0.0; 2], time)
    }

    /// The sum of two.
    pub fn and(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Value at a point and a time.
    pub fn at(&self, x: Vector, t: f64) -> f64 {
        let terms = self.0.iter();
        terms
            .map(|term| (term.constant + dot(term.slope, x)) * term.time.at(t))
            .sum()
    }

    /// It is zero everywhere and always.
    pub fn is_zero(&self) -> bool {
        self.0
            .iter()
            .all(|term| term.constant == 0.0 && term.slope == [0.0; 2])
    }

    /// factor times the same at places that were moved from x to `lengths`·Qx, Q a rotation by an angle.
    pub fn carried(&self, factor: f64, lengths: f64, angle: f64) -> Self {
        let term = |term: &Term| Term {
            constant: factor * term.constant,
            slope: rotated(term.slope, angle).map(|c| factor * c / lengths),
            time: term.time,
        };
        Self(self.0.iter().map(term).collect())
    }

    /// factor times this.
    pub fn times(&self, factor: f64) -> Self {
        self.carried(factor, 1.0, 0.0)
    }

    /// As a case file has it: a number, or an expression in quotes.
    pub fn text(&self) -> String {
        match &self.0[..] {
            [] => "0.0".to_string(),
            [
                Term {
                    constant,
                    slope: [0.0, 0.0],
                    time: Time::Always,
                },
            ] => format!("{constant:?}"),
            terms => {
                let each: Vec<String> = terms.iter().map(expression).collect();
                format!("\"{}\"", each.join(" + "))
            }
        }
    }
}

fn expression(term: &Term) -> String {
    let mut place = format!("{:?}", term.constant);
    for (slope, name) in term.slope.iter().zip(["x", "y"]) {
        if *slope != 0.0 {
            place += &format!(" + ({slope:?})*{name}");
        }
    }
    match term.time {
        Time::Always => format!("({place})"),
        Time::Line(a, b) => format!("({place})*({a:?} + ({b:?})*t)"),
        Time::Wave(omega, phase) => format!("({place})*sin({omega:?}*t + ({phase:?}))"),
    }
}

/// Both components of a vector field at a place and a time.
pub fn vector_at(field: &[Amount; 2], x: Vector, t: f64) -> Vector {
    [field[0].at(x, t), field[1].at(x, t)]
}

/// A vector field of the same vectors, turned and carried to other places: f·Q v(x) at lengths·Qx.
pub fn carried_vector(field: &[Amount; 2], factor: f64, lengths: f64, angle: f64) -> [Amount; 2] {
    let (s, c) = crate::plane::quarter_exact(angle);
    let part = |a: f64, b: f64| {
        let mut sum = Amount::default();
        for (weight, component) in [(a, &field[0]), (b, &field[1])] {
            if weight != 0.0 && !component.is_zero() {
                sum = sum.and(component.carried(weight * factor, lengths, angle));
            }
        }
        sum
    };
    [part(c, -s), part(s, c)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::times;

    #[test]
    fn a_turned_field_gives_turned_vectors_at_turned_places() {
        let field = [
            Amount::new(1.0, [0.5, -2.0], Time::Wave(1.1, 0.2)),
            Amount::new(-0.3, [0.1, 0.7], Time::Line(0.0, 2.0)),
        ];
        let (angle, x, t) = (0.7, [0.4, -1.2], 1.5);
        let turned = carried_vector(&field, 3.0, 2.0, angle);
        let there = times(2.0, rotated(x, angle));
        let expected = times(3.0, rotated(vector_at(&field, x, t), angle));
        let found = vector_at(&turned, there, t);
        assert!((0..2).all(|d| (found[d] - expected[d]).abs() < 1e-14));
    }

    #[test]
    fn constants_are_numbers_and_the_rest_expressions() {
        assert_eq!(Amount::from(-2.5).text(), "-2.5");
        let wave = Amount::new(1.0, [0.0, -2.0], Time::Line(0.5, -1.0));
        assert_eq!(wave.text(), "\"(1.0 + (-2.0)*y)*(0.5 + (-1.0)*t)\"");
    }
}
