//! Values at the ends of steps as expressions of t.

use crate::steps::{Course, Step};

/// A stretch of steps in which a value is there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
    /// First step, and the first behind the last.
    pub from: usize,
    pub until: usize,
    /// A number, or an expression in quotes.
    pub text: String,
}

/// The stretches of a course. Values between the ends of steps are never asked for.
pub(crate) fn stretches(values: &[Option<f64>], steps: &[Step]) -> Vec<Stretch> {
    let mut all = Vec::new();
    let mut from = 0;
    while from < values.len() {
        let there = values[from..]
            .iter()
            .take_while(|value| value.is_some())
            .count();
        if there == 0 {
            from += 1;
            continue;
        }
        let own: Vec<f64> = values[from..from + there]
            .iter()
            .flatten()
            .copied()
            .collect();
        let text = quoted(&expression(&own, &steps[from..from + there]));
        all.push(Stretch {
            from,
            until: from + there,
            text,
        });
        from += there;
    }
    all
}

/// Straight lines between the values at the ends of steps, without quotes.
pub(crate) fn expression(values: &[f64], steps: &[Step]) -> String {
    let mut text = format!("{:?}", values[0]);
    for k in 1..values.len() {
        let change = values[k] - values[k - 1];
        if change != 0.0 {
            let (before, length) = (steps[k - 1].time, steps[k].time - steps[k - 1].time);
            text += &format!(" + {change:?}*min(1, max(0, (t - {before:?})/{length:?}))");
        }
    }
    text
}

/// An expression as a value of a case: a number without quotes.
pub(crate) fn quoted(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(_) => text.to_string(),
        Err(_) => format!("\"{text}\""),
    }
}

/// The key `active` of a stretch with a comma before it; empty where it is always there.
pub(crate) fn active(stretch: &Stretch, steps: &[Step]) -> String {
    let mut keys = Vec::new();
    if stretch.from > 0 {
        keys.push(format!("from = {:?}", steps[stretch.from].time));
    }
    if stretch.until < steps.len() {
        keys.push(format!("until = {:?}", steps[stretch.until].time));
    }
    match keys.is_empty() {
        true => String::new(),
        false => format!(", active = {{ {} }}", keys.join(", ")),
    }
}

impl Course {
    /// Its values so that equal courses have equal keys.
    pub fn key(&self) -> Vec<Option<u64>> {
        self.values
            .iter()
            .map(|value| value.map(f64::to_bits))
            .collect()
    }

    /// Its values, zero where it is not there.
    pub fn filled(&self) -> Vec<f64> {
        self.values
            .iter()
            .map(|value| value.unwrap_or(0.0))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(times: &[f64]) -> Vec<Step> {
        times
            .iter()
            .map(|time| Step {
                time: *time,
                ..Step::default()
            })
            .collect()
    }

    #[test]
    fn values_that_come_and_go_are_stretches() {
        let steps = steps(&[1.0, 2.0, 3.0, 4.0]);
        let found = stretches(&[None, Some(2.0), Some(5.0), None], &steps);
        let text = "\"2.0 + 3.0*min(1, max(0, (t - 2.0)/1.0))\"".to_string();
        assert_eq!(
            found,
            [Stretch {
                from: 1,
                until: 3,
                text
            }]
        );
        assert_eq!(
            active(&found[0], &steps),
            ", active = { from = 2.0, until = 4.0 }"
        );
        let always = stretches(&[Some(1.5); 4], &steps);
        assert_eq!(
            (always[0].text.as_str(), active(&always[0], &steps).as_str()),
            ("1.5", "")
        );
    }
}
