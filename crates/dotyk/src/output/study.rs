//! `study.csv` and the page of a study: probes against the varied parameters.

use crate::model::{Column, Member, Study};
use crate::output::csv::quoted;
use crate::output::html::{self, Head, column, figure, left, plain, table, text};
use crate::output::json::VERSION;
use crate::output::panels::{Abscissae, Panel, Series, panels_figure};
use crate::output::plot::Axis;
use crate::output::text::{Labels, count, number};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Most curves in one plot: more could not be told apart.
const MOST_CURVES: usize = 6;

/// Most warnings on the page.
const MOST_WARNINGS: usize = 20;

/// Content of `study.csv`: values of the varied parameters, probes (of the last load step), whether every step converged, and
/// if not why not.
pub fn study_csv(study: &Study) -> String {
    let names = study.varied.iter().map(|parameter| &parameter.name);
    let probes = study.probes.iter().map(|probe| &probe.name);
    let heads: Vec<String> = names.chain(probes).map(|name| quoted(name)).collect();
    let mut out = heads.join(",") + ",converged,reason\n";
    for member in &study.members {
        for value in member.values.iter().chain(&member.probes) {
            // Writing to a String cannot fail. Adding zero turns −0 into 0.
            let _ = write!(out, "{:?},", value + 0.0);
        }
        let _ = writeln!(out, "{},{}", member.converged, quoted(&member.reason));
    }
    out
}

/// The page: a plot for every probe, and the table.
pub fn study_page(study: &Study, stem: &str) -> String {
    let labels = Labels::new(&study.units, &[]);
    let mut body = banner(study);
    if let Some((svg, caption)) = plots(study, &labels) {
        body += &figure(&svg, "Probes", &caption);
    }
    body += &warnings(study);
    body += &members_table(study, &labels);
    let title = match study.title.as_str() {
        "" => stem,
        title => title,
    };
    let intro = format!("Study of case {stem}: {}", ranges(study));
    let intro = format!("<p class=\"source\">{}</p>\n", html::escape(&intro));
    let footer = format!("Computed with dotyk {VERSION}. Full numbers: study.csv.");
    html::page(title, &intro, &body, &footer)
}

/// "E from 1 to 4 in 10 values, mu …".
fn ranges(study: &Study) -> String {
    let range = |parameter: &crate::model::Varied| {
        let (first, last) = (parameter.values.first(), parameter.values.last());
        let [first, last] = [first, last].map(|v| number(v.copied().unwrap_or(f64::NAN)));
        let steps = if parameter.log {
            " at equal ratios"
        } else {
            ""
        };
        let values = count(parameter.values.len());
        format!(
            "{} from {first} to {last} in {values} values{steps}",
            parameter.name
        )
    };
    study
        .varied
        .iter()
        .map(range)
        .collect::<Vec<_>>()
        .join(", ")
}

fn banner(study: &Study) -> String {
    let failed = study
        .members
        .iter()
        .filter(|member| !member.converged)
        .count();
    let all = count(study.members.len());
    match failed {
        0 => html::banner("good", &format!("{all} members, all certified."), ""),
        failed => {
            let title = format!("{} of {all} members have no answer.", count(failed));
            html::banner("warn", &title, " The table says why.")
        }
    }
}

/// The plots against the parameter with the most values, a curve for each combination of the others.
fn plots(study: &Study, labels: &Labels) -> Option<(String, String)> {
    let sizes = study.varied.iter().map(|parameter| parameter.values.len());
    let (along, most) = sizes
        .enumerate()
        .max_by_key(|&(k, size)| (size, std::cmp::Reverse(k)))?;
    if most < 2 || study.probes.is_empty() {
        return None;
    }
    let parameter = &study.varied[along];
    let curves = curves(study, along);
    let every = curves.len().div_ceil(MOST_CURVES).max(1);
    let shown: Vec<&Curve<'_>> = curves.iter().step_by(every).collect();
    let panels = study.probes.iter().enumerate().map(|(k, probe)| {
        let series = shown.iter().map(|curve| Series {
            name: curve.name.clone(),
            values: curve
                .members
                .iter()
                .map(|member| member.probes[k])
                .collect(),
        });
        Panel {
            // what hardly changes would be a straight line
            zero: false,
            title: probe.name.clone(),
            unit: labels.unit(probe.dimension).to_string(),
            curves: series.collect(),
        }
    });
    let panels: Vec<Panel> = panels.collect();
    let axis = match parameter.log {
        true => Axis::log(&parameter.name, &parameter.values),
        false => Axis::linear(&parameter.name, "", &parameter.values, false, 5).roomy(),
    };
    let x = Abscissae {
        axis,
        values: &parameter.values,
        hint: &|_, value| format!("{} = {}", parameter.name, number(value)),
    };
    let title = format!("Probes against {}", parameter.name);
    let mut caption = format!("In the last load step, against {}", parameter.name);
    caption += match (shown.len(), curves.len()) {
        (1, 1) => ".".to_string(),
        (some, all) if some < all => format!(", {some} of {all} combinations of the others."),
        _ => ", a curve for each combination of the others.".to_string(),
    }
    .as_str();
    Some((panels_figure("study", &title, &panels, &x), caption))
}

/// Members that differ in one parameter alone, in the order of its values.
struct Curve<'a> {
    /// Values of the others, in words.
    name: String,
    members: Vec<&'a Member>,
}

fn curves(study: &Study, along: usize) -> Vec<Curve<'_>> {
    let mut curves: BTreeMap<Vec<usize>, Curve<'_>> = BTreeMap::new();
    for (index, member) in study.members.iter().enumerate() {
        let places = study.places(index);
        let others = study.varied.iter().zip(&member.values).enumerate();
        let others = others.filter(|(k, _)| *k != along);
        let others = others.map(|(_, (p, value))| format!("{} = {}", p.name, number(*value)));
        let mut key = places;
        key[along] = 0;
        let curve = curves.entry(key).or_insert_with(|| Curve {
            name: others.collect::<Vec<_>>().join(", "),
            members: Vec::new(),
        });
        curve.members.push(member);
    }
    curves.into_values().collect()
}

/// The first warnings of the members.
fn warnings(study: &Study) -> String {
    let all = study.warnings();
    if all.is_empty() {
        return String::new();
    }
    let item = |(warning, members): &(String, usize)| {
        let members = count(*members);
        format!("<li>{} ({members} members)</li>\n", html::escape(warning))
    };
    let items: String = all.iter().take(MOST_WARNINGS).map(item).collect();
    let more = match all.len().saturating_sub(MOST_WARNINGS) {
        0 => String::new(),
        more => format!("<p>and {} more</p>\n", count(more)),
    };
    format!("<h2>Warnings</h2>\n<ul>\n{items}</ul>\n{more}")
}

fn members_table(study: &Study, labels: &Labels) -> String {
    let parameters = study
        .varied
        .iter()
        .map(|parameter| column(&parameter.name, ""));
    let unit = |probe: &Column| labels.unit(probe.dimension).to_string();
    let probes = study
        .probes
        .iter()
        .map(|probe| column(&probe.name, &unit(probe)));
    let mut heads: Vec<Head> = parameters.chain(probes).collect();
    heads.extend([left("certified"), left("reason")]);
    let rows = study.members.iter().map(|member| {
        let values = member.values.iter().chain(&member.probes);
        let mut row: Vec<_> = values.map(|value| plain(number(*value))).collect();
        row.push(text(if member.converged { "✓" } else { "✗" }));
        row.push(text(&member.reason));
        row
    });
    "<h2>Members</h2>\n".to_string() + &table(&heads, rows.collect())
}
