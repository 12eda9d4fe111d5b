//! Published, analytic and earlier values of a case, and the comparison of computed values with them.
//!
//! `reference.toml` beside the case files holds `[[value]]` tables, each for one case or several. A value is judged by a
//! relative tolerance (|computed − value| ≤ tolerance·|value|; absolute where the value is zero) or by a band fixed
//! beforehand (lo ≤ computed ≤ hi). A published value may be shown without a verdict. A value known to lie outside keeps its
//! band and has a reason (`known`): it is reported with the reason, and is an error as soon as it lies inside.

use crate::case::document::{self, Node, Span, Table};
use crate::case::error::{CaseError, Fault, read_text};
use crate::case::suggest::listed;
use crate::case::{AnyCase, keys};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// Origin of a reference value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A closed formula.
    Analytic,
    /// Somebody's publication.
    Published,
    /// An earlier result of this program: it protects, and verifies nothing.
    Regression,
}

impl Kind {
    /// The name in a reference file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Analytic => "analytic",
            Self::Published => "published",
            Self::Regression => "regression",
        }
    }
}

/// When a computed value agrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Criterion {
    /// Within this multiple of the value; an absolute distance where the value is zero.
    Tolerance(f64),
    /// Between these two numbers, both included.
    Band([f64; 2]),
    /// The difference is shown without a verdict.
    NotJudged,
}

/// Result of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Inside the tolerance or band.
    Within,
    /// Outside, or not a number.
    Outside,
    /// Outside, as its reference says with a reason.
    Known,
    /// Inside, although its reference says that it lies outside.
    Unexpected,
    /// Shown only.
    NotJudged,
}

impl Verdict {
    /// One or two words for a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Within => "ok",
            Self::Outside => "OUTSIDE",
            Self::Known => "OUTSIDE, known",
            Self::Unexpected => "inside, NOT AS KNOWN",
            Self::NotJudged => "not judged",
        }
    }
}

/// A reference value of one probe of one case.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// File name of the case, beside the reference file.
    pub case: String,
    /// Name of the probe.
    pub probe: String,
    /// Another probe of the same step that is subtracted: half of the difference of two places is an amplitude.
    pub minus: Option<String>,
    /// Words for tables; the probes' names unless given.
    pub label: String,
    /// Where it comes from.
    pub kind: Kind,
    /// The value; the middle of the band when only a band is given.
    pub value: f64,
    /// The computed value is multiplied by this before it is compared (1 unless given): 1/q makes p/q of a pressure.
    pub scale: f64,
    /// Load step whose answer is judged, from 1; the last unless given.
    pub step: Option<usize>,
    /// Compare the percentage 100 (computed − other) / other, other being the same probe of this case.
    pub against: Option<String>,
    /// When a computed value agrees.
    pub criterion: Criterion,
    /// Why a computed value lies outside, where that is known.
    pub known: Option<String>,
    /// Citation; may be empty.
    pub source: String,
    /// Why the tolerance or band is what it is; may be empty.
    pub reason: String,
    /// Where its table stands, and the value of each key in it.
    table: Span,
    places: Vec<(&'static str, Span)>,
}

impl Reference {
    /// The compared value: the probe's value scaled, or its percentage against the `other` case; less `minus` in both.
    pub fn computed(&self, value: f64, other: Option<f64>) -> f64 {
        match other {
            None => self.scale * value,
            Some(other) => 100.0 * (value - other) / other,
        }
    }

    /// The step that is judged, of the steps of a run; `None` where the run did not reach it.
    ///
    /// `count` is the number of steps of the case.
    pub fn of<'s, T>(&self, steps: &'s [T], count: usize) -> Option<&'s T> {
        steps.get(self.step.unwrap_or(count).checked_sub(1)?)
    }

    /// Compares a computed value with the reference.
    pub fn judge(&self, computed: f64) -> Verdict {
        let within = match self.criterion {
            Criterion::NotJudged => return Verdict::NotJudged,
            Criterion::Band([low, high]) => low <= computed && computed <= high,
            Criterion::Tolerance(tolerance) => {
                (computed - self.value).abs() <= tolerance * self.size()
            }
        };
        match (within, &self.known) {
            (true, None) => Verdict::Within,
            (true, Some(_)) => Verdict::Unexpected,
            (false, Some(_)) if computed.is_finite() => Verdict::Known,
            (false, _) => Verdict::Outside,
        }
    }

    /// A fault at the value of a key, or at the table where it has no such key.
    fn fault(&self, key: &str, message: String) -> Fault {
        let place = self.places.iter().find(|(name, _)| *name == key);
        Fault::new(place.map_or(&self.table, |(_, span)| span), message)
    }

    /// (computed − value) / |value|; the plain difference where the value is zero.
    pub fn difference(&self, computed: f64) -> f64 {
        (computed - self.value) / self.size()
    }

    /// The scale of relative differences.
    fn size(&self) -> f64 {
        match self.value {
            0.0 => 1.0,
            value => value.abs(),
        }
    }
}

/// A reference file.
#[derive(Debug, Clone, PartialEq)]
pub struct References {
    /// Its values, in its order.
    pub values: Vec<Reference>,
    source_name: Arc<str>,
    source_text: Arc<str>,
}

impl References {
    /// Reads a reference file.
    ///
    /// Errors: as for a case file, with line and column.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        Self::from_str(&read_text(path)?, &path.display().to_string())
    }

    /// Reads the text of a reference file; `name` is how messages call it.
    ///
    /// Errors: as [`References::read`].
    pub fn from_str(text: &str, name: &str) -> Result<Self, CaseError> {
        let values = document::parse(text).and_then(|document| values(&document));
        Ok(Self {
            values: values.map_err(|fault| fault.in_source(name, text))?,
            source_name: name.into(),
            source_text: text.into(),
        })
    }

    /// Checks that all cases, probes and steps exist; `find` finds a case by the name of its file.
    ///
    /// Errors: missing cases, probes or steps, with their places.
    pub fn check<'m>(&self, find: impl Fn(&str) -> Option<&'m AnyCase>) -> Result<(), CaseError> {
        for reference in &self.values {
            let fault = |key, message, label: &str| reference.fault(key, message).label(label);
            let against = reference.against.as_ref().map(|other| ("against", other));
            for (key, case) in [("case", &reference.case)].into_iter().chain(against) {
                let Some(found) = find(case) else {
                    let message = format!("there is no case file `{case}` in the folder");
                    return Err(self.located(fault(key, message, "no such case")));
                };
                let probes = found.probes();
                let names = || probes.iter().map(|(name, _)| *name);
                let minus = reference.minus.as_ref().map(|probe| ("minus", probe));
                for (key, probe) in [("probe", &reference.probe)].into_iter().chain(minus) {
                    if !names().any(|name| name == probe) {
                        let message = format!("`{case}` has no probe `{probe}`");
                        let help = match listed(names()) {
                            known if known.is_empty() => "it has no probes".to_string(),
                            known => format!("its probes: {known}"),
                        };
                        let fault = fault(key, message, "no such probe").help(help);
                        return Err(self.located(fault));
                    }
                    if probes.contains(&(probe.as_str(), true)) {
                        let message = format!("`{probe}` of `{case}` has values along a line");
                        let help = "name a probe of one number: with `at` or `reduce`";
                        let fault = fault(key, message, "not one number").help(help);
                        return Err(self.located(fault));
                    }
                }
                let count = found.steps();
                if let Some(step) = reference.step.filter(|step| *step > count) {
                    let message = format!("`{case}` has no step {step}: it has {count}");
                    let fault = fault("step", message, "no such step")
                        .help("steps count from 1; without `step` the last is meant");
                    return Err(self.located(fault));
                }
            }
        }
        Ok(())
    }

    /// The error that a value lies inside although it is known to lie outside.
    pub fn unexpected(&self, reference: &Reference) -> CaseError {
        let (probe, case) = (&reference.probe, &reference.case);
        let message = format!("`{probe}` of `{case}` agrees, although it is known not to");
        let fault = reference.fault("known", message);
        self.located(fault.label("agrees by now").help("remove `known`"))
    }

    fn located(&self, fault: Fault) -> CaseError {
        fault.in_source(&self.source_name, &self.source_text)
    }
}

const KINDS: [(&str, Kind); 3] = [
    ("analytic", Kind::Analytic),
    ("published", Kind::Published),
    ("regression", Kind::Regression),
];

fn values(document: &Node) -> Result<Vec<Reference>, Fault> {
    let table = document.table(keys::REFERENCES)?;
    let mut values = Vec::new();
    let mut known = HashSet::new();
    for node in table.list("value")? {
        let table = node.table(keys::REFERENCE)?;
        let value = reference(table)?;
        for node in cases(table)? {
            let (case, probe) = (node.text()?.to_string(), value.probe.clone());
            let fault = Fault::new(
                &node.span,
                format!("`{case}` is listed twice for the probe `{probe}`"),
            );
            let (against, source) = (value.against.clone(), value.source.clone());
            let probe = (probe, value.minus.clone());
            if !known.insert((case.clone(), probe, value.step, against, source)) {
                let help = "another value of the same number has another `source`";
                return Err(fault.label("once more").help(help));
            }
            let mut value = value.clone();
            value.case = case;
            value.places.push(("case", node.span.clone()));
            values.push(value);
        }
    }
    Ok(values)
}

/// The cases that a value is for: `case = "NAME"` or `cases = ["NAME", ..]`.
fn cases(table: Table<'_>) -> Result<&[Node], Fault> {
    let Some(entry) = table.entry("cases") else {
        let case = table.require("case", "a reference value")?;
        return Ok(std::slice::from_ref(case));
    };
    if table.get("case").is_some() {
        let message = "a reference value takes one of `case` and `cases`";
        return Err(Fault::new(&entry.key_span, message).label("superfluous beside `case`"));
    }
    let cases = entry.node.list()?;
    if cases.is_empty() {
        return Err(Fault::new(&entry.node.span, "`cases` lists no case").label("empty"));
    }
    Ok(cases)
}

/// A value, still of no case.
fn reference(table: Table<'_>) -> Result<Reference, Fault> {
    let what = "a reference value";
    let probe = table.require("probe", what)?.text()?.to_string();
    let kind = table.require("kind", what)?.choice("kind", &KINDS)?;
    let criterion = criterion(table, kind)?;
    let value = match (table.get("value"), criterion) {
        (Some(node), _) => node.number()?,
        (None, Criterion::Band([low, high])) => 0.5 * (low + high),
        (None, _) => table.require("value", what)?.number()?,
    };
    let text = |key: &str| {
        let text = table.get(key).map(Node::text).transpose()?;
        Ok(text.map(str::to_string))
    };
    let (against, minus) = (text("against")?, text("minus")?);
    let probes = minus.as_ref().map(|minus| format!("{probe} − {minus}"));
    if let (Some(entry), Some(_)) = (table.entry("scale"), &against) {
        let message = "`scale` does not change a percentage";
        return Err(Fault::new(&entry.key_span, message).label("superfluous beside `against`"));
    }
    let place = |key: &&'static str| Some((*key, table.get(key)?.span.clone()));
    let step = table.get("step");
    let step = step.map(|node| node.positive_integer("`step`"));
    Ok(Reference {
        case: String::new(),
        label: text("label")?.unwrap_or_else(|| probes.unwrap_or_else(|| probe.clone())),
        probe,
        minus,
        kind,
        value,
        scale: table.get("scale").map_or(Ok(1.0), Node::number)?,
        step: step.transpose()?,
        against,
        criterion,
        known: known(table, criterion)?,
        source: text("source")?.unwrap_or_default(),
        reason: text("reason")?.unwrap_or_default(),
        table: table.span.clone(),
        places: keys::REFERENCE.iter().filter_map(place).collect(),
    })
}

/// Exactly one of `tolerance`, `band` and `judged = false`.
fn criterion(table: Table<'_>, kind: Kind) -> Result<Criterion, Fault> {
    let judged = table.entry("judged");
    let is_judged = judged.map_or(Ok(true), |entry| entry.node.boolean())?;
    let not_judged = judged.filter(|_| !is_judged);
    if let Some(entry) = not_judged.filter(|_| kind != Kind::Published) {
        let message = format!("a value of the kind `{}` is always judged", kind.name());
        return Err(Fault::new(&entry.key_span, message).label("only for `published`"));
    }
    match (table.get("tolerance"), table.get("band"), not_judged) {
        (Some(node), None, None) => Ok(Criterion::Tolerance(tolerance(node)?)),
        (None, Some(node), None) => {
            let [low, high] = node.point::<2>()?;
            if low <= high {
                return Ok(Criterion::Band([low, high]));
            }
            Err(Fault::new(&node.span, "the band is empty").label("lower bound above the upper"))
        }
        (None, None, Some(_)) => Ok(Criterion::NotJudged),
        (None, None, None) => Err(Fault::new(
            table.span,
            "a reference value needs `tolerance` or `band`",
        )
        .label("nothing to judge by")
        .help("a published value may have `judged = false` instead")),
        _ => Err(Fault::new(
            table.span,
            "a reference value takes one of `tolerance`, `band` and `judged = false`",
        )
        .label("more than one")),
    }
}

/// Why a value that is judged is known to lie outside.
fn known(table: Table<'_>, criterion: Criterion) -> Result<Option<String>, Fault> {
    let Some(entry) = table.entry("known") else {
        return Ok(None);
    };
    if criterion == Criterion::NotJudged {
        let message = "`known` is of a value that is judged";
        return Err(Fault::new(&entry.key_span, message)
            .label("superfluous beside `judged = false`")
            .help("give it `tolerance` or `band`, and `judged = true`"));
    }
    match entry.node.text()?.trim() {
        "" => Err(Fault::new(&entry.node.span, "`known` needs a reason").label("empty")),
        reason => Ok(Some(reason.to_string())),
    }
}

/// A number ≥ 0: zero requires the same number.
fn tolerance(node: &Node) -> Result<f64, Fault> {
    node.not_negative("`tolerance`")
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "\
[[value]]
case = \"case_1.toml\"
probe = \"crown\"
kind = \"analytic\"
value = -2.0
tolerance = 0.01
source = \"a book\"

[[value]]
case = \"case_1.toml\"
probe = \"force\"
kind = \"published\"
value = 1.5
band = [1.4, 1.7]
reason = \"read off a figure\"

[[value]]
case = \"case_1.toml\"
probe = \"gap\"
kind = \"published\"
value = 0.0
judged = false
label = \"gap at D\"

[[value]]
case = \"case_1.toml\"
probe = \"shear\"
kind = \"regression\"
value = 0
tolerance = 1e-9
";

    fn error(from: &str, to: &str) -> CaseError {
        assert!(GOOD.contains(from));
        References::from_str(&GOOD.replacen(from, to, 1), "reference.toml").unwrap_err()
    }

    #[test]
    fn both_ends_of_a_tolerance_and_of_a_band_belong_to_it() {
        let references = References::from_str(GOOD, "reference.toml").unwrap();
        let judge = |i: usize, computed: f64| references.values[i].judge(computed);
        assert_eq!(judge(0, -2.0199), Verdict::Within);
        assert_eq!(judge(0, -2.0201), Verdict::Outside);
        assert_eq!(judge(0, 2.0), Verdict::Outside);
        assert_eq!(judge(1, 1.4), Verdict::Within);
        assert_eq!(judge(1, 1.7), Verdict::Within);
        assert_eq!(judge(1, 1.701), Verdict::Outside);
        assert_eq!(judge(1, f64::NAN), Verdict::Outside);
        assert_eq!(judge(2, 1e30), Verdict::NotJudged);
        assert_eq!(judge(3, -9e-10), Verdict::Within);
        assert_eq!(judge(3, 2e-9), Verdict::Outside);
        assert_eq!(references.values[2].label, "gap at D");
        assert_eq!(references.values[0].label, "crown");
        assert!((references.values[0].difference(-2.2) + 0.1).abs() < 1e-15);
    }

    #[test]
    fn values_are_scaled_and_percentages_taken_against_another_case() {
        let text = GOOD.replacen("value = -2.0", "value = -2.0\nscale = 0.5", 1);
        let references = References::from_str(&text, "reference.toml").unwrap();
        assert_eq!(references.values[0].computed(-4.0, None), -2.0);
        let text = GOOD.replacen("value = -2.0", "value = -2.0\nagainst = \"case_2.toml\"", 1);
        let references = References::from_str(&text, "reference.toml").unwrap();
        assert_eq!(references.values[0].against.as_deref(), Some("case_2.toml"));
        assert_eq!(references.values[0].computed(-3.0, Some(-2.0)), 50.0);
        let both = "value = -2.0\nscale = 2.0\nagainst = \"case_2.toml\"";
        assert!(error("value = -2.0", both).to_string().contains("line 6"));
    }

    #[test]
    fn another_probe_may_be_subtracted() {
        let minus = "value = -2.0\nminus = \"invert\"\nscale = 0.5";
        let text = GOOD.replacen("value = -2.0", minus, 1);
        let references = References::from_str(&text, "reference.toml").unwrap();
        assert_eq!(references.values[0].minus.as_deref(), Some("invert"));
        assert_eq!(references.values[0].label, "crown − invert");
        // a difference is another number than either
        let table = GOOD.split("\n\n").next().unwrap();
        let second = table.replacen("value = -2.0", minus, 1);
        let both = References::from_str(&format!("{table}\n\n{second}"), "reference.toml");
        assert_eq!(both.unwrap().values.len(), 2);
        assert_eq!(
            error("value = -2.0", "value = -2.0\nminus = 3").line(),
            Some(6)
        );
    }

    #[test]
    fn a_regression_value_is_always_judged() {
        let e = error("tolerance = 1e-9", "judged = false");
        assert!(e.message.contains("always judged"));
        assert_eq!(e.line(), Some(30));
    }

    #[test]
    fn one_table_may_be_for_many_cases() {
        let text = GOOD.replacen(
            "case = \"case_1.toml\"",
            "cases = [\"a.toml\", \"b.toml\"]",
            1,
        );
        let references = References::from_str(&text, "reference.toml").unwrap();
        let cases: Vec<&str> = references.values.iter().map(|v| v.case.as_str()).collect();
        assert_eq!(cases[..3], ["a.toml", "b.toml", "case_1.toml"]);
        let probes: Vec<&str> = references.values.iter().map(|v| v.probe.as_str()).collect();
        assert_eq!(probes[..3], ["crown", "crown", "force"]);
        assert_eq!(references.values[1].value, -2.0);
    }

    #[test]
    fn a_case_is_listed_once_for_a_probe_and_a_source() {
        let one = "case = \"case_1.toml\"";
        let place = |e: CaseError| (e.line(), e.column());
        let twice = error(one, "cases = [\"a.toml\", \"a.toml\"]");
        assert!(twice.message.contains("listed twice"), "{twice}");
        assert_eq!(place(twice), (Some(2), Some(20)));
        // in two tables: as long as both cite the same source
        let again = |source: &str| {
            let table = GOOD.split("\n\n").next().unwrap();
            let second = table.replacen("a book", source, 1);
            References::from_str(&format!("{table}\n\n{second}"), "reference.toml")
        };
        assert_eq!(place(again("a book").unwrap_err()), (Some(10), Some(8)));
        assert_eq!(again("another book").unwrap().values.len(), 2);
        let both = format!("{one}\ncases = [\"a.toml\"]");
        assert_eq!(place(error(one, &both)), (Some(3), Some(1)));
        assert_eq!(place(error(one, "cases = []")), (Some(2), Some(9)));
        assert_eq!(place(error(one, "cases = \"a.toml\"")), (Some(2), Some(9)));
        assert_eq!(place(error(one, "")), (Some(1), Some(1)));
    }

    #[test]
    fn a_value_that_is_known_to_be_outside_must_be_outside() {
        let known = "band = [1.4, 1.7]\njudged = true\nknown = \"another mesh\"";
        let text = GOOD.replacen("band = [1.4, 1.7]", known, 1);
        let references = References::from_str(&text, "reference.toml").unwrap();
        let force = &references.values[1];
        assert_eq!(force.known.as_deref(), Some("another mesh"));
        assert_eq!(force.judge(1.71), Verdict::Known);
        assert_eq!(force.judge(1.7), Verdict::Unexpected);
        // a missing value is not a known deviation
        assert_eq!(force.judge(f64::NAN), Verdict::Outside);
        let error_of = references.unexpected(force);
        assert_eq!((error_of.line(), error_of.column()), (Some(16), Some(9)));
        // without a verdict or without words it is useless
        let e = error("judged = false", "judged = false\nknown = \"so\"");
        assert_eq!(e.line(), Some(23));
        assert_eq!(
            error("value = 1.5", "value = 1.5\nknown = \" \"").line(),
            Some(14)
        );
    }

    #[test]
    fn a_value_may_name_its_step() {
        let text = GOOD.replacen("value = -2.0", "value = -2.0\nstep = 2", 1);
        let references = References::from_str(&text, "reference.toml").unwrap();
        let [second, last] = [&references.values[0], &references.values[1]];
        assert_eq!(second.of(&["a", "b", "c"], 3), Some(&"b"));
        assert_eq!(last.of(&["a", "b", "c"], 3), Some(&"c"));
        // a run that ended after its first step
        assert_eq!((second.of(&["a"], 3), last.of(&["a"], 3)), (None, None));
        assert_eq!(error_of_step("0").line(), Some(6));
        assert_eq!(error_of_step("1.5").line(), Some(6));
    }

    fn error_of_step(step: &str) -> CaseError {
        error("value = -2.0", &format!("value = -2.0\nstep = {step}"))
    }

    #[test]
    fn mistakes_have_their_line() {
        assert_eq!(error("tolerance = 0.01", "tolerance = -1").line(), Some(6));
        assert_eq!(error("tolerance = 0.01", "tolerence = 1").line(), Some(6));
        assert_eq!(error("tolerance = 0.01", "").line(), Some(1));
        assert_eq!(
            error("band = [1.4, 1.7]", "band = [1.7, 1.4]").line(),
            Some(14)
        );
        assert_eq!(
            error("kind = \"published\"", "kind = \"rumour\"").line(),
            Some(12)
        );
    }
}
