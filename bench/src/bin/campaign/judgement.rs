//! Findings of a checker, and the distance of every quantity from its limit.

use std::collections::BTreeMap;

/// A violated condition.
#[derive(Debug, Clone)]
pub struct Finding {
    /// Number of the load step, from 1.
    pub step: usize,
    pub what: &'static str,
    pub place: String,
    /// Violation over its limit.
    pub times: f64,
}

/// All findings, and the margins of all checks.
#[derive(Debug, Default)]
pub struct Judgement {
    pub findings: Vec<Finding>,
    /// The largest violation over its limit, by check.
    pub margins: BTreeMap<&'static str, f64>,
    step: usize,
}

impl Judgement {
    /// Begins a step, from 1: later findings belong to it.
    pub fn begin(&mut self, step: usize) {
        self.step = step;
    }

    /// Compares a violation with its limit; NaN is a finding, too.
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
