//! Published, analytic and earlier values of a case, and how a computed value is judged against them.
//!
//! `reference.toml` beside the case files holds `[[value]]` tables. A value is judged by a relative tolerance
//! (|computed − value| ≤ tolerance·|value|; absolute where the value is zero) or by a band fixed beforehand
//! (lo ≤ computed ≤ hi). A published value may be shown without a verdict.

use crate::case::document::{self, Node, Span, Table};
use crate::case::error::{CaseError, Fault, read_text};
use crate::case::keys;
use std::path::Path;
use std::sync::Arc;

/// Where a reference value comes from.
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

/// What comes of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Inside the tolerance or band.
    Within,
    /// Outside, or not a number.
    Outside,
    /// Shown only.
    NotJudged,
}

impl Verdict {
    /// One or two words for a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Within => "ok",
            Self::Outside => "OUTSIDE",
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
    /// Words for tables; the probe's name unless given.
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
    /// Citation; may be empty.
    pub source: String,
    /// Why the tolerance or band is what it is; may be empty.
    pub reason: String,
    case_span: Span,
    probe_span: Span,
    step_span: Span,
    against_span: Span,
}

impl Reference {
    /// What is compared: the probe's value scaled, or its percentage against the `other` case.
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
                let scale = if self.value == 0.0 {
                    1.0
                } else {
                    self.value.abs()
                };
                (computed - self.value).abs() <= tolerance * scale
            }
        };
        if within {
            Verdict::Within
        } else {
            Verdict::Outside
        }
    }

    /// (computed − value) / |value|; the plain difference where the value is zero.
    pub fn difference(&self, computed: f64) -> f64 {
        let scale = if self.value == 0.0 {
            1.0
        } else {
            self.value.abs()
        };
        (computed - self.value) / scale
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

    /// The error that the case of this reference is not there.
    pub fn unknown_case(&self, reference: &Reference) -> CaseError {
        let message = format!("there is no case file `{}` in the folder", reference.case);
        Fault::new(&reference.case_span, message)
            .label("no such case")
            .in_source(&self.source_name, &self.source_text)
    }

    /// The error that the case it is compared against is not there.
    pub fn unknown_other(&self, reference: &Reference) -> CaseError {
        let other = reference.against.as_deref().unwrap_or_default();
        let message = format!("there is no case file `{other}` in the folder");
        Fault::new(&reference.against_span, message)
            .label("no such case")
            .in_source(&self.source_name, &self.source_text)
    }

    /// The error that a case has no such step; `count` is the number of its steps.
    pub fn unknown_step(&self, reference: &Reference, case: &str, count: usize) -> CaseError {
        let step = reference.step.unwrap_or(count);
        let message = format!("`{case}` has no step {step}: it has {count}");
        Fault::new(&reference.step_span, message)
            .label("no such step")
            .help("steps count from 1; without `step` the last is meant")
            .in_source(&self.source_name, &self.source_text)
    }

    /// The error that its case has no such probe; `known` are the probes that it has.
    pub fn unknown_probe<'a>(
        &self,
        reference: &Reference,
        known: impl IntoIterator<Item = &'a str>,
    ) -> CaseError {
        let known = crate::case::suggest::listed(known);
        let help = match known.is_empty() {
            true => "it has no probes".to_string(),
            false => format!("its probes: {known}"),
        };
        let message = format!("`{}` has no probe `{}`", reference.case, reference.probe);
        Fault::new(&reference.probe_span, message)
            .label("no such probe")
            .help(help)
            .in_source(&self.source_name, &self.source_text)
    }
}

const KINDS: [(&str, Kind); 3] = [
    ("analytic", Kind::Analytic),
    ("published", Kind::Published),
    ("regression", Kind::Regression),
];

fn values(document: &Node) -> Result<Vec<Reference>, Fault> {
    let table = document.table(keys::REFERENCES)?;
    table.list("value")?.iter().map(reference).collect()
}

fn reference(node: &Node) -> Result<Reference, Fault> {
    let table = node.table(keys::REFERENCE)?;
    let what = "a reference value";
    let case = table.require("case", what)?;
    let probe = table.require("probe", what)?;
    let kind = table.require("kind", what)?.choice("kind", &KINDS)?;
    let criterion = criterion(table, kind)?;
    let value = match (table.get("value"), criterion) {
        (Some(node), _) => node.number()?,
        (None, Criterion::Band([low, high])) => 0.5 * (low + high),
        (None, _) => table.require("value", what)?.number()?,
    };
    let text = |key: &str| {
        let node = table.get(key);
        node.map_or(Ok(""), Node::text).map(str::to_string)
    };
    let label = text("label")?;
    let scale = table.get("scale").map_or(Ok(1.0), Node::number)?;
    let step = table.get("step");
    let against = table.get("against");
    if let (Some(entry), Some(_)) = (table.entry("scale"), against) {
        let message = "`scale` does not change a percentage";
        return Err(Fault::new(&entry.key_span, message).label("superfluous beside `against`"));
    }
    Ok(Reference {
        case: case.text()?.to_string(),
        probe: probe.text()?.to_string(),
        label: if label.is_empty() {
            probe.text()?.to_string()
        } else {
            label
        },
        kind,
        value,
        scale,
        step: step
            .map(|node| node.positive_integer("`step`"))
            .transpose()?,
        against: against.map(Node::text).transpose()?.map(str::to_string),
        criterion,
        source: text("source")?,
        reason: text("reason")?,
        case_span: case.span.clone(),
        probe_span: probe.span.clone(),
        step_span: step.map_or_else(|| case.span.clone(), |node| node.span.clone()),
        against_span: against.map_or_else(|| case.span.clone(), |node| node.span.clone()),
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

/// A number ≥ 0: zero asks for the same number.
fn tolerance(node: &Node) -> Result<f64, Fault> {
    let value = node.number()?;
    if value >= 0.0 {
        return Ok(value);
    }
    Err(Fault::new(&node.span, "`tolerance` must not be negative").label("not ≥ 0"))
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
    fn a_regression_value_is_always_judged() {
        let e = error("tolerance = 1e-9", "judged = false");
        assert!(e.message.contains("always judged"));
        assert_eq!(e.line(), Some(30));
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
        let error = references.unknown_step(second, "case_1.toml", 1);
        assert_eq!((error.line(), error.column()), (Some(6), Some(8)));
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

    #[test]
    fn an_unknown_probe_is_found_where_it_is_named() {
        let references = References::from_str(GOOD, "reference.toml").unwrap();
        let error = references.unknown_probe(&references.values[1], ["crown"]);
        assert_eq!((error.line(), error.column()), (Some(11), Some(9)));
        assert_eq!(
            references.unknown_case(&references.values[1]).line(),
            Some(10)
        );
    }
}
