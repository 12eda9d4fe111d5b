//! Section "Load steps" of the report: curves against time and tables, one row for each step.

use crate::geometry::{norm, sub};
use crate::model::{BodySolution, ContactSolution, MemberWords, Model, Solution};
use crate::output::Overview;
use crate::output::figures::course;
use crate::output::html::{Head, column, fitted, left, plain, table, text};
use crate::output::json::{closed_and_open, largest};
use crate::output::markup::{Markup, markup};
use crate::output::panels::{Abscissae, Panel, Series, panels_figure};
use crate::output::plot::Axis;
use crate::output::svg::SERIES;
use crate::output::text::{Labels, Scales, count, number, vector, without_noise};
use crate::output::utilisation::largest_utilisation;
use crate::output::vtu::judged;
use std::borrow::Cow;

/// More probes than this are left to the table.
const MOST_PANELS: usize = 24;

/// Columns of values in one table of probes.
const COLUMNS: usize = 4;

/// The section; empty with a single step.
pub fn steps_section<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    if run.earlier.is_empty() {
        return Markup::default();
    }
    let steps: Vec<&Solution<D>> = run.steps().collect();
    let mut out = markup!(
        "<h2>Load steps</h2>\n<p>All else on this page shows the last of {} steps, at t = {}.</p>\n",
        count(steps.len()),
        number(run.last.time)
    );
    if let Some(time) = run.last.counted_from {
        out += markup!(
            "<p>Its displacements count from the end of the step at t = {}.</p>\n",
            number(time)
        );
    }
    out += stages(run);
    out += course(run);
    out += steps_figure(&steps, labels);
    out += overview(&steps, labels);
    let told = contact_names(&steps);
    let all = steps
        .iter()
        .map(|step| step.contacts.len())
        .max()
        .unwrap_or(0);
    if told.len() < all {
        out += markup!(
            "<p>Of the contacts the {} that bear most are drawn and told here, all of them in contact.csv.</p>\n",
            count(told.len())
        );
    }
    for contact in told {
        out += contact_table(&steps, contact, labels);
    }
    let probes: Vec<usize> = numbers(run.last).collect();
    let values = probe_values(&steps);
    for (part, chosen) in probes.chunks(COLUMNS).enumerate() {
        if part == 0 {
            out += markup!("<h3>Probes</h3>\n");
        }
        out += probe_table(&steps, &values, chosen, labels);
    }
    out
}

/// What is there in each step; nothing where steps have no names and nothing comes or goes.
fn stages<const D: usize>(run: &Overview<'_, D>) -> Markup {
    let several = run.model.has_stages();
    if !several && (0..run.stages.len()).all(|step| run.step_name(step).is_none()) {
        return Markup::default();
    }
    let kinds: Vec<MemberWords> = run.model.members_by_kind().map(|(kind, _)| kind).collect();
    let mut heads = vec![
        column("step", ""),
        column("t", ""),
        left("name"),
        left("bodies"),
        left("contacts"),
    ];
    heads.extend(kinds.iter().map(|kind| left(kind.plural)));
    let both = || run.steps().zip(&run.stages).enumerate();
    let row = |(step, (solution, stage)): (usize, (&Solution<D>, &Cow<'_, Model<D>>))| {
        let bodies: Vec<&str> = stage.bodies.iter().map(|body| body.name.as_str()).collect();
        let contacts: Vec<&str> = stage.contacts.iter().map(|c| c.name.as_str()).collect();
        let [number, time] = [count(step + 1), number(solution.time)].map(plain);
        let name = run.step_name(step).unwrap_or_default();
        let of_kind = |kind: &MemberWords| {
            let members = solution.members.iter().filter(|own| own.kind == *kind);
            let members = members.map(|own| match own.tightening {
                true => format!("{} (tightened)", own.name),
                false => own.name.clone(),
            });
            text(&members.collect::<Vec<String>>().join(", "))
        };
        let words = [name, &bodies.join(", "), &contacts.join(", ")].map(text);
        let words = words.into_iter().chain(kinds.iter().map(of_kind));
        [number, time].into_iter().chain(words).collect()
    };
    let table = table(&heads, both().map(row).collect());
    markup!("<h3>Stages</h3>\n{}", table)
}

fn panels<const D: usize>(steps: &[&Solution<D>], labels: &Labels) -> Vec<Panel> {
    let Some(last) = steps.last() else {
        return Vec::new();
    };
    let contacts = contact_names(steps);
    let of_contacts = |title: &str, unit: &str, value: fn(&ContactSolution<D>) -> f64| Panel {
        title: title.to_string(),
        unit: unit.to_string(),
        zero: true,
        curves: (contacts.iter())
            .map(|name| Series {
                name: name.to_string(),
                values: (steps.iter())
                    .map(|s| s.contact(name).map_or(f64::NAN, value))
                    .collect(),
            })
            .collect(),
    };
    let values = probe_values(steps);
    let mut list = Vec::new();
    if !contacts.is_empty() {
        let pressure = |c: &ContactSolution<D>| largest(c.nodes.iter().map(|n| n.pressure));
        list.push(of_contacts("Contact force", &labels.force, |c| {
            norm(c.resultant)
        }));
        list.push(of_contacts("Largest pressure", &labels.stress, pressure));
        let (_, unit) = labels.extent();
        list.push(of_contacts(labels.in_contact(), unit, |c| c.length));
    }
    list.extend(numbers(last).take(MOST_PANELS).map(|i| Panel {
        title: last.probes[i].name.clone(),
        unit: labels.unit(last.probes[i].dimension).to_string(),
        zero: true,
        curves: vec![Series {
            name: String::new(),
            values: values.iter().map(|step| step[i]).collect(),
        }],
    }));
    list
}

/// Names of the contacts that bear most in any step, as many as there are kinds of curves; in the order of the model.
fn contact_names<'a, const D: usize>(steps: &[&'a Solution<D>]) -> Vec<&'a str> {
    let mut names: Vec<(&str, f64)> = Vec::new();
    for contact in steps.iter().flat_map(|step| &step.contacts) {
        let force = norm(contact.resultant);
        match names.iter_mut().find(|own| own.0 == contact.name) {
            Some(own) => own.1 = own.1.max(force),
            None => names.push((&contact.name, force)),
        }
    }
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&a, &b| names[b].1.total_cmp(&names[a].1));
    order.truncate(SERIES.len());
    order.sort_unstable();
    order.into_iter().map(|k| names[k].0).collect()
}

/// Indices of the probes of one number.
fn numbers<const D: usize>(solution: &Solution<D>) -> impl Iterator<Item = usize> {
    let probes = solution.probes.iter().enumerate();
    probes
        .filter(|(_, probe)| probe.line.is_empty())
        .map(|(i, _)| i)
}

fn steps_figure<const D: usize>(steps: &[&Solution<D>], labels: &Labels) -> Markup {
    let panels = panels(steps, labels);
    let (Some(last), false) = (steps.last(), panels.is_empty()) else {
        return Markup::default();
    };
    let times: Vec<f64> = steps.iter().map(|s| s.time).collect();
    let title = "Contact and probes against the time of the load steps";
    let draw = |width| {
        let x = Abscissae {
            axis: Axis::linear("t", "", &times, false, 4).roomy(),
            values: &times,
            hint: &|i, t| format!("step {}, t = {}", i + 1, number(t)),
        };
        panels_figure("steps", title, &panels, &x, width)
    };
    let left = numbers(last).count().saturating_sub(MOST_PANELS);
    let more = match left {
        0 => String::new(),
        left => format!(" The last {} probes are in the table alone.", count(left)),
    };
    let caption = format!("Contact and probes against the time t of the steps.{more}");
    fitted(&draw, "Load steps", &caption)
}

fn first_cells<const D: usize>(step: usize, solution: &Solution<D>) -> Vec<String> {
    vec![count(step + 1), number(solution.time)]
}

fn heads(more: Vec<Head>) -> Vec<Head> {
    let mut heads = vec![column("step", ""), column("t", "")];
    heads.extend(more);
    heads
}

fn rows<const D: usize>(
    steps: &[&Solution<D>],
    heads: Vec<Head>,
    row: impl Fn(usize, &Solution<D>) -> Vec<String>,
) -> Markup {
    let rows = steps.iter().enumerate().map(|(i, solution)| {
        let first = first_cells(i, solution).into_iter();
        first.chain(row(i, solution)).map(plain).collect()
    });
    table(&self::heads(heads), rows.collect())
}

fn overview<const D: usize>(steps: &[&Solution<D>], labels: &Labels) -> Markup {
    let (word, unit) = labels.interior();
    let strong = steps.iter().any(|step| judged(step));
    let mut heads = vec![
        column("iterations", ""),
        column("largest displacement", &labels.length),
        column("of this step alone", &labels.length),
        column("largest von Mises", &labels.stress),
        column("elastic energy", &labels.energy),
        column("certified", ""),
    ];
    if strong {
        heads.push(column("largest utilisation", ""));
        heads.push(column(&format!("overstressed {word}"), &unit));
    }
    rows(steps, heads, |index, s| {
        let bodies = || s.bodies.iter();
        let before = index.checked_sub(1).map(|before| steps[before]);
        let stresses = bodies().flat_map(|b| b.von_mises.iter().copied());
        let mut row = vec![
            count(s.solver.iterations),
            number(largest(bodies().map(BodySolution::max_displacement))),
            number(largest(bodies().map(|body| moved_since((body, s), before)))),
            number(largest(stresses)),
            number(bodies().map(|b| b.strain_energy).sum()),
            if s.converged { "✓" } else { "✗" }.to_string(),
        ];
        if strong {
            let own = || bodies().filter_map(|body| body.utilisation.as_ref());
            let most = largest_utilisation(s).map_or(f64::NAN, |(_, peak)| peak.most.value);
            row.push(number(most));
            row.push(number(own().map(|own| own.overstressed).sum()));
        }
        row
    })
}

/// The largest displacement of a body since a step; since it came, where it was not there.
fn moved_since<const D: usize>(
    (body, now): (&BodySolution<D>, &Solution<D>),
    before: Option<&Solution<D>>,
) -> f64 {
    // where displacements count anew, they count from that step
    let before = before.filter(|before| before.counted_from == now.counted_from);
    let mut then = before.iter().flat_map(|solution| &solution.bodies);
    match then.find(|then| then.name == body.name) {
        Some(then) => {
            let both = body.displacement.iter().zip(&then.displacement);
            largest(both.map(|(&now, &then)| norm(sub(now, then))))
        }
        None => body.max_displacement(),
    }
}

fn contact_table<const D: usize>(steps: &[&Solution<D>], name: &str, labels: &Labels) -> Markup {
    let own = steps.iter().filter_map(|step| step.contact(name));
    if own
        .clone()
        .all(|contact| closed_and_open(&contact.nodes).0 == 0)
    {
        return markup!("<p>Contact {}: open everywhere in every step.</p>\n", name);
    }
    let heads = vec![
        column("nodes closed / open", ""),
        column(&labels.in_contact().to_lowercase(), labels.extent().1),
        column("largest pressure", &labels.stress),
        column("force on the first side", &labels.force),
    ];
    let body = rows(steps, heads, |_, s| {
        let Some(c) = s.contact(name) else {
            return vec!["–".to_string(); 4];
        };
        let (closed, open) = closed_and_open(&c.nodes);
        vec![
            format!("{} / {}", count(closed), count(open)),
            number(c.length),
            number(largest(c.nodes.iter().map(|n| n.pressure))),
            vector(&c.resultant, ""),
        ]
    });
    markup!("<h3>Contact {}</h3>\n{}", name, body)
}

fn probe_table<const D: usize>(
    steps: &[&Solution<D>],
    values: &[Vec<f64>],
    chosen: &[usize],
    labels: &Labels,
) -> Markup {
    let Some(last) = steps.last() else {
        return Markup::default();
    };
    let head = |&i: &usize| {
        let probe = &last.probes[i];
        column(&probe.name, labels.unit(probe.dimension))
    };
    let scale = |i: usize| {
        values
            .iter()
            .fold(0.0, |s, step| f64::max(s, step[i].abs()))
    };
    let value = |step: usize, i: usize| number(without_noise(values[step][i], scale(i)));
    rows(steps, chosen.iter().map(head).collect(), |step, _| {
        chosen.iter().map(|&i| value(step, i)).collect()
    })
}

/// Values of all probes by step; zero if they are rounding relative to forces, stresses and displacements of the step.
fn probe_values<const D: usize>(steps: &[&Solution<D>]) -> Vec<Vec<f64>> {
    let of_step = |solution: &&Solution<D>| {
        let scales = Scales::of(solution);
        let probes = solution.probes.iter();
        let values = probes.map(|probe| scales.without_noise(probe.value, probe.dimension));
        values.collect()
    };
    steps.iter().map(of_step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel;

    #[test]
    fn every_step_has_its_row_and_every_probe_its_plot() {
        let (model, solution) = tunnel::solved();
        let mut first = solution.clone();
        first.time = 0.25;
        first.probes[0].value = f64::NAN;
        let earlier = [first];
        let labels = Labels::of(&model);
        let run = Overview {
            earlier: &earlier,
            stages: vec![Cow::Borrowed(&model); 2],
            ..tunnel::run(&model, &solution)
        };
        let section = steps_section(&run, &labels);
        // overview, contact and probes
        assert_eq!(section.matches("<td>0.25</td>").count(), 3);
        assert!(section.contains("last of 2 steps"));
        // three plots of the contact and one of the probe, whose first value is undefined; for pages and for phones
        assert_eq!(section.matches("step 1, t = 0.25").count(), 6);
        assert_eq!(section.matches("step 2, t = 1").count(), 8);
        // a picture of each step
        assert_eq!(section.matches("type=\"radio\"").count(), 2);
        assert!(steps_section(&tunnel::run(&model, &solution), &labels).is_empty());
    }
}
