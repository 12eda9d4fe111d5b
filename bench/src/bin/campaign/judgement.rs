//! What a checker found, and how far everything is from its limit.

use std::collections::BTreeMap;

/// Something that does not hold.
#[derive(Debug, Clone)]
pub struct Finding {
    /// From 1.
    pub step: usize,
    pub what: &'static str,
    pub place: String,
    /// Violation over its limit.
    pub times: f64,
}

/// All that was found, and by how much everything else holds.
#[derive(Debug, Default)]
pub struct Judgement {
    pub findings: Vec<Finding>,
    /// The largest violation over its limit, by check.
    pub margins: BTreeMap<&'static str, f64>,
    step: usize,
}

impl Judgement {
    /// What follows is said of this step, from 1.
    pub fn begin(&mut self, step: usize) {
        self.step = step;
    }

    /// Compares a violation with its limit; what is not a number is no good either.
    pub fn compare(
        &mut self,
        what: &'static str,
        violation: f64,
        limit: f64,
        place: impl FnOnce() -> String,
    ) {
        let times = if violation <= 0.0 {
            0.0
        } else {
            violation / limit
        };
        let margin = self.margins.entry(what).or_insert(0.0);
        *margin = margin.max(times);
        if times <= 1.0 {
            return;
        }
        let known = self
            .findings
            .iter_mut()
            .find(|f| f.what == what && f.step == self.step);
        match known {
            Some(known) if known.times >= times => {}
            Some(known) => (known.times, known.place) = (times, place()),
            None => self.findings.push(Finding {
                step: self.step,
                what,
                place: place(),
                times,
            }),
        }
    }

    /// The findings, the worst first.
    pub fn worst(&self) -> Option<&Finding> {
        let findings = self.findings.iter();
        findings.max_by(|a, b| a.times.total_cmp(&b.times))
    }
}
