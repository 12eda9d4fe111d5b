//! `dotyk study`: one case for many values of its parameters.

use crate::Outcome;
use crate::failure::{Failure, warn};
use crate::given::Given;
use crate::progress::Count;
use crate::run::output_folder;
use crate::text::{columns, named, number, print};
use dotyk::model::{Model, Study, Varied};
use dotyk::output;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `dotyk study`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Case file
    case: PathBuf,
    #[command(flatten)]
    given: Given,
    /// Values of a parameter, ends included, such as E=1e9..4e9:10; of several all combinations
    #[arg(long, value_name = "NAME=A..B:COUNT", value_parser = varied, required = true)]
    vary: Vec<Varied>,
    /// Space the values of this parameter by equal ratios; may be repeated
    #[arg(long, value_name = "NAME")]
    log: Vec<String>,
    /// Load steps in tables and plots: the last one of each combination, or all of them, each with a row
    #[arg(long, value_name = "WHICH", default_value = "last")]
    steps: Steps,
    /// Draw a probe or varied parameter against another one, of all such pairs one picture, study.svg; may be repeated
    #[arg(long, value_name = "X:Y")]
    plot: Vec<String>,
    /// Output folder [default: CASE-out]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

/// Which load steps are told.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Steps {
    Last,
    All,
}

/// Most members of a study.
const MOST: usize = 1_000_000;

fn varied(text: &str) -> Result<Varied, String> {
    let expected = "expected NAME=A..B:COUNT, such as E=1e9..4e9:10";
    let parts = || {
        let (name, range) = text.split_once('=')?;
        let (ends, count) = range.rsplit_once(':')?;
        let (from, to) = ends.split_once("..")?;
        Some((name.trim(), [from.trim(), to.trim()], count.trim()))
    };
    let (name, ends, count) = parts().ok_or(expected)?;
    let end = |text: &str| match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a number; {expected}")),
    };
    let [from, to] = [end(ends[0])?, end(ends[1])?];
    let count = match count.parse::<usize>() {
        Ok(count) if (1..=MOST).contains(&count) => count,
        Ok(count) if count > MOST => {
            return Err(format!("{count} values are too many, at most {MOST}"));
        }
        _ => return Err(format!("`{count}` is not a number of values; {expected}")),
    };
    if name.is_empty() {
        return Err(expected.to_string());
    }
    if count == 1 && from != to {
        return Err("one value cannot be both ends; use a count of 2 or more".to_string());
    }
    Ok(Varied {
        name: name.to_string(),
        values: spaced([from, to], count),
        log: false,
    })
}

/// Values from one end to the other, both included.
fn spaced([from, to]: [f64; 2], count: usize) -> Vec<f64> {
    let last = (count - 1).max(1) as f64;
    let inner = |k: usize| match k {
        0 => from,
        k if k == count - 1 => to,
        k => from + (to - from) * (k as f64 / last),
    };
    (0..count).map(inner).collect()
}

/// The same ends and count with equal ratios.
fn at_equal_ratios(parameter: &mut Varied) -> Result<(), String> {
    let ends = [parameter.values.first(), parameter.values.last()];
    let [Some(&from), Some(&to)] = ends else {
        return Ok(());
    };
    if from <= 0.0 || to <= 0.0 {
        return Err(format!(
            "--log {}: both ends must be positive to be spaced by equal ratios",
            parameter.name
        ));
    }
    let count = parameter.values.len();
    for (k, exponent) in spaced([from.ln(), to.ln()], count).into_iter().enumerate() {
        // the ends stay exact
        if k > 0 && k + 1 < count {
            parameter.values[k] = exponent.exp();
        }
    }
    parameter.log = true;
    Ok(())
}

/// The varied parameters, from the command line.
fn all_varied(arguments: &Arguments) -> Result<Vec<Varied>, String> {
    let mut varied = arguments.vary.clone();
    for k in 1..varied.len() {
        if varied[..k]
            .iter()
            .any(|before| before.name == varied[k].name)
        {
            return Err(format!("--vary {} is given twice", varied[k].name));
        }
    }
    let names = varied.iter().map(|parameter| &parameter.name);
    if let Some(name) = names.clone().find(|name| arguments.given.sets(name)) {
        return Err(format!(
            "{name} is varied and set: leave out --set {name}=..."
        ));
    }
    for name in &arguments.log {
        let known = varied.iter_mut().find(|parameter| parameter.name == *name);
        let parameter =
            known.ok_or_else(|| format!("--log {name}: --vary {name}=... is missing"))?;
        at_equal_ratios(parameter)?;
    }
    match varied
        .iter()
        .try_fold(1usize, |n, p| n.checked_mul(p.values.len()))
    {
        Some(1..=MOST) => Ok(varied),
        _ => Err(format!("these are more than {MOST} combinations")),
    }
}

/// Solves all members, writes, prints.
pub fn study(arguments: &Arguments) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let varied = all_varied(arguments).map_err(Failure::Message)?;
    let all_steps = arguments.steps == Steps::All;
    let case = arguments.given.read_case(&arguments.case)?;
    let (study, pairs, stem, folder) = of_any!(case, |case| {
        let folder = output_folder(arguments.out.as_deref(), &case.stem)?;
        warn(&case.warnings);
        say_what_is_no_column(&case.model);
        if let Some(name) = Study::doubled(&case.model, &varied, all_steps) {
            let message = format!(
                "two columns of study.csv are both named `{name}`: rename the probe or parameter"
            );
            return Err(Failure::of(&arguments.case, message));
        }
        let pairs = pairs(&arguments.plot, &case.model, &varied).map_err(Failure::Message)?;
        let count = Count::new(Study::count(&varied), arguments.quiet);
        let given = arguments.given.pairs();
        let study = case.study(given, varied, &|| count.one_more());
        count.finish();
        let study = Study {
            all_steps,
            ..study?
        };
        (study, pairs, case.stem, folder)
    });
    let files = output::write_study(&study, &pairs, &stem, &folder);
    let files = files.map_err(Failure::of_output)?;
    let seconds = start.elapsed().as_secs_f64();
    warn(&told(&study));
    print(&(members(&study) + &verdict(&study, seconds) + &named(&files)))?;
    Ok(match study.converged() {
        true => Outcome::Done,
        false => Outcome::Unsatisfied,
    })
}

/// The names [x, y] of each pair to draw; names may contain colons.
fn pairs<const D: usize>(
    plots: &[String],
    model: &Model<D>,
    varied: &[Varied],
) -> Result<Vec<[String; 2]>, String> {
    let probes = model.probes.iter().filter(|probe| !probe.is_line());
    // the unit of a parameter is unknown
    let probes = probes.map(|probe| (probe.name.as_str(), Some(probe.dimension())));
    let parameters = varied
        .iter()
        .map(|parameter| (parameter.name.as_str(), None));
    let columns: Vec<_> = parameters.chain(probes).collect();
    let column = |name: &str| columns.iter().find(|(own, _)| *own == name.trim());

    let mut list: Vec<[String; 2]> = Vec::new();
    let mut measured = [None; 2];
    for text in plots {
        let mut splits = text.match_indices(':');
        let both = splits.find_map(|(k, _)| Some([column(&text[..k])?, column(&text[k + 1..])?]));
        let Some(both) = both else {
            let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
            let names = names.join(", ");
            return Err(format!(
                "--plot {text}: expected X:Y, each one of what is varied and read: {names}"
            ));
        };
        for (axis, (name, dimension)) in measured.iter_mut().zip(both) {
            let Some(dimension) = dimension else {
                continue;
            };
            let (first, expected) = *axis.get_or_insert((*name, *dimension));
            if expected != *dimension {
                return Err(format!(
                    "--plot {text}: `{name}` is measured in something else than `{first}` and cannot share its axis"
                ));
            }
        }
        list.push(both.map(|(name, _)| name.to_string()));
    }
    Ok(list)
}

/// Warns of probes that the table will not have.
fn say_what_is_no_column<const D: usize>(model: &Model<D>) {
    if model.probes.is_empty() {
        warn(&[
            "the case has no [[probe]]: the study tells of each member only whether it converged"
                .to_string(),
        ]);
    }
    for probe in model.probes.iter().filter(|probe| probe.is_line()) {
        warn(&[format!(
            "the probe `{}` has values along a line, and no column in a study",
            probe.name
        )]);
    }
}

/// Most warnings that are printed.
const MOST_WARNINGS: usize = 6;

/// The warnings of the members, each with the number of those that have it.
fn told(study: &Study) -> Vec<String> {
    let all = study.warnings();
    let lines = all.iter().take(MOST_WARNINGS);
    let mut lines: Vec<String> = lines
        .map(|(warning, members)| {
            format!("{members} of {} members: {warning}", study.members.len())
        })
        .collect();
    if all.len() > MOST_WARNINGS {
        lines.push(format!(
            "and {} more, see study.html",
            all.len() - MOST_WARNINGS
        ));
    }
    lines
}

/// Up to this many members are printed; of more the first and the last ones.
const MOST_LINES: usize = 40;

fn members(study: &Study) -> String {
    let told = study.rows();
    let (all, half) = (told.len(), MOST_LINES / 2);
    let shown = |k: usize| all <= MOST_LINES || k < half || k >= all - half;
    let rows = told.iter().enumerate().filter(|(k, _)| shown(*k));
    let rows: Vec<Vec<String>> = rows
        .map(|(_, row)| {
            let values = row.numbers().map(number);
            values.chain([row.reason.to_string()]).collect()
        })
        .collect();
    let header: Vec<&str> = study.heads().chain([""]).collect();
    let table = columns(&header, &rows, 0..header.len() - 1);
    let what = if study.all_steps { "rows" } else { "members" };
    match all - rows.len() {
        0 => table,
        more => format!("{table}{more} {what} between are left out: all are in study.csv\n"),
    }
}

fn verdict(study: &Study, seconds: f64) -> String {
    let all = study.members.len();
    let good = study
        .members
        .iter()
        .filter(|member| member.converged)
        .count();
    let word = if good == all {
        "converged"
    } else {
        "NOT CONVERGED"
    };
    format!("\n{word}: {good} of {all} members, {seconds:.2} s\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_are_among_the_values() {
        let parameter = varied("E=1e9..4e9:4").unwrap();
        assert_eq!(parameter.name, "E");
        assert_eq!(parameter.values, [1e9, 2e9, 3e9, 4e9]);
        let mut falling = varied("g = 8..-1:4").unwrap();
        assert_eq!(falling.values, [8.0, 5.0, 2.0, -1.0]);
        assert!(at_equal_ratios(&mut falling).is_err());
        let mut ratio = varied("k=1..8:4").unwrap();
        at_equal_ratios(&mut ratio).unwrap();
        for (value, expected) in ratio.values.iter().zip([1.0, 2.0, 4.0, 8.0]) {
            assert!((value - expected).abs() < 1e-14, "{value}");
        }
        assert_eq!(varied("k=3..3:1").unwrap().values, [3.0]);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for text in [
            "E",
            "E=1",
            "E=1..2",
            "E=1..2:0",
            "E=1..2:x",
            "E=a..2:3",
            "=1..2:3",
            "E=1..2:1",
            "E=1..inf:3",
            "E=1..2:1e3",
        ] {
            assert!(varied(text).is_err(), "{text}");
        }
    }
}
