//! `study.csv`, the page of a study, probes against the varied parameters, and its picture, probes against each other.

use crate::model::{Column, Study, StudyMember, Varied};
use crate::output::csv::quoted;
use crate::output::html::{self, Head, column, figure, fitted, left, plain, table, text};
use crate::output::json::VERSION;
use crate::output::markup::{Markup, markup};
use crate::output::panels::{Abscissae, Panel, Series, panels_figure};
use crate::output::plot::{Axis, Frame, Stroke, keys};
use crate::output::scene::WIDTH;
use crate::output::svg::Svg;
use crate::output::text::{Labels, count, number};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Most curves in one plot: more would not be distinguishable.
const MOST_CURVES: usize = 6;

/// Most dots of a curve of the picture.
const MOST_DOTS: usize = 200;

/// Most warnings on the page.
const MOST_WARNINGS: usize = 20;

/// Content of `study.csv`: values of the varied parameters, number and time of the load step where all of them are told, probes (else
/// of the last one), whether it has an answer, and if not why not.
pub fn study_csv(study: &Study) -> String {
    let heads: Vec<String> = study.heads().map(quoted).collect();
    let mut out = heads.join(",") + ",converged,reason\n";
    for row in study.rows() {
        for (head, value) in study.heads().zip(row.numbers()) {
            // Writing to a String cannot fail. Adding zero turns −0 into 0.
            let _ = match row.step {
                Some((step, _)) if head == "step" => write!(out, "{step},"),
                _ => write!(out, "{:?},", value + 0.0),
            };
        }
        let _ = writeln!(out, "{},{}", row.converged, quoted(row.reason));
    }
    out
}

/// The page: the picture if there is one, a plot for every probe, and the table.
pub fn study_page(study: &Study, picture: Option<&Markup>, stem: &str) -> Markup {
    let labels = Labels::new(&study.units, &[]);
    let mut body = banner(study);
    if let Some(svg) = picture {
        let caption = "In the last load step; a dot is a member of the study.";
        body += figure(svg, "Against each other", caption);
    }
    if let Some(figure) = plots(study, &labels) {
        body += figure;
    }
    if let Some(figure) = over_steps(study, &labels) {
        body += figure;
    }
    body += warnings(study);
    body += members_table(study, &labels);
    let title = match study.title.as_str() {
        "" => stem,
        title => title,
    };
    let intro = format!("Study of case {stem}: {}", ranges(study));
    let intro = markup!("<p class=\"source\">{}</p>\n", intro);
    let footer = format!("Computed with dotyk {VERSION}. Full numbers: study.csv.");
    html::page(title, &intro, &body, &footer)
}

/// "E from 1 to 4 in 10 values, mu …".
fn ranges(study: &Study) -> String {
    let range = |parameter: &Varied| {
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

fn banner(study: &Study) -> Markup {
    let failed = study
        .members
        .iter()
        .filter(|member| !member.converged)
        .count();
    let all = count(study.members.len());
    match failed {
        0 => html::banner(
            "good",
            &format!("{all} members, all certified."),
            &Markup::default(),
        ),
        failed => {
            let title = format!("{} of {all} members have no answer.", count(failed));
            html::banner("warn", &title, &markup!(" The table says why."))
        }
    }
}

/// Points (x, y) with the name of their curve.
type Drawn = (String, Vec<[f64; 2]>);

/// Content of `study.svg`: columns of the table against each other, `pairs` their names [x, y].
pub fn study_picture(study: &Study, pairs: &[[String; 2]]) -> Markup {
    let labels = Labels::new(&study.units, &[]);
    let drawn = curves_of_pairs(study, pairs);
    let axis = |k: usize, ticks: usize| {
        let names = pairs.iter().map(|pair| pair[k].as_str());
        let unit = names.clone().find_map(|name| unit(study, &labels, name));
        let mut distinct: Vec<&str> = names.collect();
        distinct.dedup();
        let values = drawn.iter().flat_map(|(_, points)| points);
        let values: Vec<f64> = values.map(|point| point[k]).collect();
        let name = distinct.join(", ");
        Axis::linear(&name, unit.unwrap_or_default(), &values, true, ticks).widened(0.05)
    };
    let title = "Columns of the study against each other";
    let mut svg = Svg::new("pairs", title, WIDTH, 0.0);
    let names: Vec<&str> = drawn.iter().map(|(name, _)| name.as_str()).collect();
    // measured on a separate drawing: the background comes first
    let top = keys(&mut Svg::new("", "", WIDTH, 0.0), [70.0, WIDTH], &names) + 6.0;
    let frame = Frame {
        corner: [70.0, top],
        size: [WIDTH - 90.0, 330.0],
        x: axis(0, 8),
        y: axis(1, 6),
    };
    let height = top + frame.size[1] + 46.0;
    svg.set_height(height);
    svg.rectangle([0.0, 0.0], [WIDTH, height], "none", "#fff");
    keys(&mut svg, [70.0, WIDTH], &names);
    frame.draw(&mut svg, true);
    for (k, (name, points)) in drawn.iter().enumerate() {
        let stroke = Stroke::of(k, drawn.len());
        frame.stroke(&mut svg, points, stroke);
        for p in points.iter().filter(|p| seen(p)).take(MOST_DOTS) {
            let hint = format!("{name}: {}, {}", number(p[0]), number(p[1]));
            stroke.dot(&mut svg, frame.at(p[0], p[1]), &hint);
        }
    }
    svg.finish()
}

fn seen(point: &[f64; 2]) -> bool {
    point.iter().all(|value| value.is_finite())
}

/// A curve along the parameter with the most values, for each pair and each combination of the other parameters; a single one
/// if the others have no effect, and no curve without finite points.
fn curves_of_pairs(study: &Study, pairs: &[[String; 2]]) -> Vec<Drawn> {
    let along = longest(study).map_or(0, |(along, _)| along);
    let curves = curves(study, along);
    let mut drawn = Vec::new();
    for [x, y] in pairs {
        let point = |member: &&StudyMember| [x, y].map(|name| value(study, member, name));
        let of_pair = shown(&curves).map(|curve| {
            let points: Vec<[f64; 2]> = curve.members.iter().map(point).collect();
            (named(y, &curve.name), points)
        });
        let of_pair: Vec<Drawn> = of_pair.filter(|(_, p)| p.iter().any(seen)).collect();
        match of_pair.as_slice() {
            [(_, first), rest @ ..] if rest.iter().all(|(_, other)| alike(first, other)) => {
                drawn.push((y.clone(), first.clone()));
            }
            _ => drawn.extend(of_pair),
        }
    }
    drawn
}

/// The name of a curve: its quantity, and the values of the other parameters.
fn named(what: &str, others: &str) -> String {
    match others {
        "" => what.to_string(),
        others => format!("{what}, {others}"),
    }
}

/// Whether two curves are indistinguishable: a thousandth of a pixel would be 1e-6 of an axis.
fn alike(curve: &[[f64; 2]], other: &[[f64; 2]]) -> bool {
    (0..2).all(|k| {
        let largest = curve.iter().fold(0.0f64, |most, p| most.max(p[k].abs()));
        let mut both = curve.iter().zip(other);
        both.all(|(a, b)| (a[k] - b[k]).abs() <= 1e-6 * largest || a[k].is_nan() && b[k].is_nan())
    })
}

/// Value of a varied parameter or a probe; NaN for an unknown name.
fn value(study: &Study, member: &StudyMember, name: &str) -> f64 {
    let names = study.varied.iter().map(|parameter| &parameter.name);
    let mut names = names.chain(study.probes.iter().map(|probe| &probe.name));
    let place = names.position(|other| other == name);
    let mut values = member.values.iter().chain(&member.probes);
    place.and_then(|k| values.nth(k)).map_or(f64::NAN, |v| *v)
}

/// Unit of a probe; a parameter has none.
fn unit<'l>(study: &Study, labels: &'l Labels, name: &str) -> Option<&'l str> {
    let probe = study.probes.iter().find(|probe| probe.name == name)?;
    Some(labels.unit(probe.dimension))
}

/// The parameter with the most values, and how many.
fn longest(study: &Study) -> Option<(usize, usize)> {
    let sizes = study.varied.iter().map(|parameter| parameter.values.len());
    sizes
        .enumerate()
        .max_by_key(|&(k, size)| (size, std::cmp::Reverse(k)))
}

/// At most as many curves as are distinguishable, evenly chosen.
fn shown<'c, 'a>(curves: &'c [Curve<'a>]) -> impl Iterator<Item = &'c Curve<'a>> {
    let every = curves.len().div_ceil(MOST_CURVES).max(1);
    curves.iter().step_by(every)
}

/// The plots against the parameter with the most values, a curve for each combination of the others.
fn plots(study: &Study, labels: &Labels) -> Option<Markup> {
    let (along, most) = longest(study)?;
    if most < 2 || study.probes.is_empty() {
        return None;
    }
    let parameter = &study.varied[along];
    let curves = curves(study, along);
    let shown: Vec<&Curve<'_>> = shown(&curves).collect();
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
            // values that hardly change would be a straight line
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
    let draw = |width| panels_figure("study", &title, &panels, &x, width);
    Some(fitted(&draw, "Probes", &caption))
}

/// The plots over the load steps, a curve for each of some members; over their numbers where members have other times.
fn over_steps(study: &Study, labels: &Labels) -> Option<Markup> {
    let longest = study
        .members
        .iter()
        .max_by_key(|member| member.times.len())?;
    let count = longest.times.len();
    if !study.all_steps || count < 2 || study.probes.is_empty() {
        return None;
    }
    let mut times = study.members.iter().map(|member| &member.times);
    let (what, values) = match times.all(|own| longest.times.starts_with(own)) {
        true => ("time", longest.times.clone()),
        false => ("load step", (1..=count).map(|step| step as f64).collect()),
    };
    let every = study.members.len().div_ceil(MOST_CURVES);
    let shown: Vec<&StudyMember> = study.members.iter().step_by(every).collect();
    let panel = |(k, probe): (usize, &Column)| {
        let curve = |member: &&StudyMember| Series {
            name: in_words(&study.varied, &member.values, None),
            values: (0..count)
                .map(|step| member.steps.get(step).map_or(f64::NAN, |probes| probes[k]))
                .collect(),
        };
        Panel {
            zero: false,
            title: probe.name.clone(),
            unit: labels.unit(probe.dimension).to_string(),
            curves: shown.iter().map(curve).collect(),
        }
    };
    let panels: Vec<Panel> = study.probes.iter().enumerate().map(panel).collect();
    let x = Abscissae {
        axis: Axis::linear(what, "", &values, false, 5).roomy(),
        values: &values,
        hint: &|_, value| format!("{what} {}", number(value)),
    };
    let title = format!("Probes over {what}");
    let caption = match (shown.len(), study.members.len()) {
        (some, all) if some < all => format!("Over {what}, {some} of {all} members."),
        _ => format!("Over {what}, a curve for each member."),
    };
    let draw = |width| panels_figure("steps", &title, &panels, &x, width);
    Some(fitted(&draw, "Probes over the load steps", &caption))
}

/// "E = 1, mu = 2": values of the parameters, but for one.
fn in_words(varied: &[Varied], values: &[f64], without: Option<usize>) -> String {
    let all = varied.iter().zip(values).enumerate();
    let told = all.filter(|(k, _)| Some(*k) != without);
    let told = told.map(|(_, (p, value))| format!("{} = {}", p.name, number(*value)));
    told.collect::<Vec<_>>().join(", ")
}

/// Members that differ in one parameter alone, in the order of its values.
struct Curve<'a> {
    /// Values of the others, in words.
    name: String,
    members: Vec<&'a StudyMember>,
}

fn curves(study: &Study, along: usize) -> Vec<Curve<'_>> {
    let mut curves: BTreeMap<Vec<usize>, Curve<'_>> = BTreeMap::new();
    for (index, member) in study.members.iter().enumerate() {
        let mut key = study.places(index);
        key[along] = 0;
        let curve = curves.entry(key).or_insert_with(|| Curve {
            name: in_words(&study.varied, &member.values, Some(along)),
            members: Vec::new(),
        });
        curve.members.push(member);
    }
    curves.into_values().collect()
}

/// The first warnings of the members.
fn warnings(study: &Study) -> Markup {
    let all = study.warnings();
    if all.is_empty() {
        return Markup::default();
    }
    let item = |(warning, members): &(String, usize)| {
        markup!("<li>{} ({} members)</li>\n", warning, count(*members))
    };
    let items: Markup = all.iter().take(MOST_WARNINGS).map(item).collect();
    let more = match all.len().saturating_sub(MOST_WARNINGS) {
        0 => Markup::default(),
        more => markup!("<p>and {} more</p>\n", count(more)),
    };
    markup!("<h2>Warnings</h2>\n<ul>\n{}</ul>\n{}", items, more)
}

fn members_table(study: &Study, labels: &Labels) -> Markup {
    let unit = |name: &str| unit(study, labels, name).unwrap_or_default();
    let mut heads: Vec<Head> = study.heads().map(|name| column(name, unit(name))).collect();
    heads.extend([left("certified"), left("reason")]);
    let rows = study.rows().into_iter().map(|row| {
        let mut cells: Vec<_> = row.numbers().map(|value| plain(number(value))).collect();
        cells.push(text(if row.converged { "✓" } else { "✗" }));
        cells.push(text(row.reason));
        cells
    });
    markup!("<h2>Members</h2>\n{}", table(&heads, rows.collect()))
}
