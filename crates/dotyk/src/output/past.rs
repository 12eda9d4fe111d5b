//! The steps of an earlier run, read back from its `summary.json` and `contact.csv`.

use crate::model::{Past, PastBody, PastNode, Status};
use crate::output::chain::tangent;
use crate::output::csv::unguarded;
use crate::output::files;
use crate::output::state::{STATE, read_state};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Why the steps of an earlier run cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {why}", file.display())]
pub struct PastError {
    /// The file or folder.
    pub file: PathBuf,
    /// The fault and its remedy.
    pub why: String,
}

/// The relevant part of `summary.json`.
#[derive(Deserialize)]
struct Summary {
    #[serde(flatten)]
    last: Step,
    steps: Option<Vec<Step>>,
}

#[derive(Deserialize)]
struct Step {
    converged: bool,
    iterations: usize,
    time: f64,
    displacements_from: Option<f64>,
    bodies: Vec<Body>,
}

#[derive(Deserialize)]
struct Body {
    name: String,
    max_displacement: f64,
    strain_energy: f64,
}

/// The steps that have an answer in the results of an earlier run, at least one.
///
/// Errors: files that are missing or not from a run; a run without an answer, or one whose files are not all in place.
pub(crate) fn past<const D: usize>(dir: &Path) -> Result<Vec<Past<D>>, PastError> {
    let fail = |file: &Path, why: String| PastError {
        file: file.to_path_buf(),
        why,
    };
    if files::is_unfinished(dir) {
        let why = "its files belong to two runs, of which the second was ended while it put its own in their places; run that again";
        return Err(fail(dir, why.to_string()));
    }
    let read = |name: &str| {
        let file = dir.join(name);
        let bytes = crate::host::read(&file).map_err(|why| {
            let what = "a run goes on from the folder that `dotyk run` wrote its results to";
            fail(&file, format!("cannot be read ({why}); {what}"))
        })?;
        let text =
            String::from_utf8(bytes).map_err(|_| fail(&file, "is not UTF-8 text".to_string()))?;
        Ok((file, text))
    };
    let ((file, text), (csv_file, csv)) = loop {
        let both = (read("summary.json")?, read("contact.csv")?);
        // another run may have put its answer in their place between the two
        if read("summary.json")?.1 == both.0.1 {
            break both;
        }
    };
    let summary: Summary = serde_json::from_str(&text)
        .map_err(|e| fail(&file, format!("is no summary of a run: {e}")))?;
    let steps = match summary.steps {
        Some(steps) => steps,
        None => vec![summary.last],
    };
    let mut past: Vec<Past<D>> = steps
        .iter()
        .filter(|step| step.converged)
        .map(|step| Past {
            time: step.time,
            iterations: step.iterations,
            counted_from: step.displacements_from,
            contacts: Vec::new(),
            bodies: step
                .bodies
                .iter()
                .map(|body| PastBody {
                    name: body.name.clone(),
                    max_displacement: body.max_displacement,
                    strain_energy: body.strain_energy,
                    yielded: None,
                })
                .collect(),
        })
        .collect();
    if past.is_empty() {
        let why = "no step of this run has an answer: there is nothing to go on from";
        return Err(fail(&file, why.to_string()));
    }
    contacts(&csv, &mut past).map_err(|why| fail(&csv_file, why))?;
    let file = dir.join(STATE);
    // without yielding there is no such file
    if file.exists() {
        let cannot = |why| fail(&file, format!("cannot be read ({why})"));
        let bytes = crate::host::read(&file).map_err(cannot)?;
        read_state(&bytes, &mut past).map_err(|why| fail(&file, why))?;
    }
    Ok(past)
}

/// Adds the rows of `contact.csv` to their steps.
fn contacts<const D: usize>(text: &str, past: &mut [Past<D>]) -> Result<(), String> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let place = |name: &str| names.iter().position(|known| *known == name);
    let column = |name: &'static str| {
        let place = place(name);
        place.map_or_else(
            || Err(format!("has no column `{name}`")),
            |at| Ok((at, name)),
        )
    };
    let [step, contact, node, status] = ["step", "contact", "node", "status"].map(column);
    let (step, contact, node, status) = (step?, contact?, node?, status?);
    let [weight, gap, pressure] = ["weight", "gap", "pressure"].map(column);
    let numbers = [weight?, gap?, pressure?];
    // in the plane along the tangent, from the normal; absent without friction and ties
    let vectors: [&[&'static str]; 2] = match D {
        2 => [&["nx", "ny"], &["shear"]],
        _ => [&[], &["shear_x", "shear_y", "shear_z"]],
    };
    let bears = place(vectors[1][0]).is_some();
    let vectors = vectors.concat();
    let vectors = vectors.into_iter().filter(|_| bears).map(column);
    let vectors = vectors.collect::<Result<Vec<_>, _>>()?;
    for (index, line) in lines.enumerate() {
        let row = Row {
            number: index + 2,
            cells: line.split(',').collect(),
        };
        let step: usize = row.number(step)?;
        let into = step.checked_sub(1).and_then(|k| past.get_mut(k));
        let Some(into) = into else {
            return Err(format!(
                "line {}: step {step} has no answer in summary.json",
                row.number
            ));
        };
        let [weight, gap, pressure] = numbers.map(|column| row.number::<f64>(column));
        let vectors = vectors.iter().map(|column| row.number::<f64>(*column));
        let vectors = vectors.collect::<Result<Vec<_>, _>>()?;
        let mut shear = [0.0; D];
        match vectors[..] {
            [nx, ny, along] if D == 2 => {
                let tangent = tangent([nx, ny]);
                shear
                    .iter_mut()
                    .zip(tangent)
                    .for_each(|(s, t)| *s = along * t);
            }
            ref shears => shear.iter_mut().zip(shears).for_each(|(s, t)| *s = *t),
        }
        let read = PastNode {
            node: row.number(node)?,
            weight: weight?,
            gap: gap?,
            pressure: pressure?,
            shear,
            status: row.status(status)?,
        };
        let name = unguarded(row.cell(contact)?);
        match into.contacts.last_mut().filter(|(known, _)| known == name) {
            Some((_, nodes)) => nodes.push(read),
            None => into.contacts.push((name.to_string(), vec![read])),
        }
    }
    Ok(())
}

/// A line of a table.
struct Row<'t> {
    number: usize,
    cells: Vec<&'t str>,
}

impl<'t> Row<'t> {
    fn cell(&self, (at, name): (usize, &str)) -> Result<&'t str, String> {
        let cell = self.cells.get(at).copied();
        cell.ok_or_else(|| format!("line {} ends before the column `{name}`", self.number))
    }

    fn number<T: std::str::FromStr>(&self, column: (usize, &str)) -> Result<T, String> {
        let cell = self.cell(column)?;
        let wrong = || {
            format!(
                "line {}: `{cell}` is no number for `{}`",
                self.number, column.1
            )
        };
        cell.parse().map_err(|_| wrong())
    }

    fn status(&self, column: (usize, &str)) -> Result<Status, String> {
        let cell = self.cell(column)?;
        let found = Status::ALL.into_iter().find(|status| status.name() == cell);
        found.ok_or_else(|| format!("line {}: `{cell}` is no status", self.number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Law, Model};
    use crate::output::{csv, json, tunnel};

    fn written(
        test: &str,
        change: impl Fn(&str, String) -> String,
    ) -> Result<Vec<Past<2>>, PastError> {
        let (mut model, solution): (Model<2>, _) = tunnel::solved();
        model.contacts[0].law = Law::Coulomb(crate::geometry::Field::constant(0.3));
        let dir = tunnel::Scratch::new(test);
        let steps = std::slice::from_ref(&solution);
        let summary = json::summary(&tunnel::run(&model, &solution));
        let csv = csv::contact_csv(
            &vec![std::borrow::Cow::Borrowed(&model); steps.len()],
            steps,
        );
        for (name, text) in [("summary.json", summary), ("contact.csv", csv)] {
            std::fs::write(dir.path().join(name), change(name, text)).unwrap();
        }
        past(dir.path())
    }

    #[test]
    fn what_was_written_is_read_back() {
        let (_, solution) = tunnel::solved();
        let read = written("past", |_, text| text).unwrap();
        let expected = Past::from(&solution);
        assert_eq!(read.len(), 1);
        assert_eq!(
            (read[0].time, read[0].iterations),
            (expected.time, expected.iterations)
        );
        assert_eq!(read[0].bodies, expected.bodies);
        let ((name, nodes), (known, original)) = (&read[0].contacts[0], &expected.contacts[0]);
        assert_eq!((name, nodes.len()), (known, original.len()));
        for (a, b) in nodes.iter().zip(original) {
            assert_eq!(
                (a.node, a.weight, a.pressure, a.status),
                (b.node, b.weight, b.pressure, b.status)
            );
            assert!(a.gap == b.gap || a.gap.is_nan() && b.gap.is_nan());
            assert!((0..2).all(|d| (a.shear[d] - b.shear[d]).abs() <= 1e-15 * b.pressure.abs()));
        }
    }

    #[test]
    fn a_name_that_begins_as_a_formula_is_read_back() {
        let read = written("formula", |_, text| text.replace(",lining,", ",'-lining,")).unwrap();
        assert_eq!(read[0].contacts[0].0, "-lining");
    }

    #[test]
    fn what_is_spoilt_is_told_with_its_line() {
        let spoil = |name: &'static str, from: &'static str, to: &'static str| {
            let change = |file: &str, text: String| match file == name {
                true => text.replacen(from, to, 1),
                false => text,
            };
            written("spoilt", change).unwrap_err().to_string()
        };
        for (error, words) in [
            (spoil("summary.json", "{", "["), "is no summary of a run"),
            (
                spoil(
                    "summary.json",
                    "\"converged\": true",
                    "\"converged\": false",
                ),
                "nothing to go on from",
            ),
            (
                spoil("contact.csv", "weight", "wait"),
                "has no column `weight`",
            ),
            (
                spoil("contact.csv", "\n1,lining", "\n2,lining"),
                "line 2: step 2 has no answer",
            ),
            (
                spoil("contact.csv", "\n1,lining", "\n1.5,lining"),
                "line 2: `1.5` is no number for `step`",
            ),
            (
                spoil("contact.csv", ",closed", ",shut"),
                "`shut` is no status",
            ),
        ] {
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}
