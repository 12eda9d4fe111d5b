//! Section "Bars" of the report: the forces of all bars, their course over the load steps, and along grouted ones.

use crate::model::{Bar, BarSolution, Bond, LinePoint};
use crate::output::Overview;
use crate::output::html::{Head, column, figure, left, plain, table, text};
use crate::output::json::range;
use crate::output::lines::{Curve, line_figure, spread};
use crate::output::markup::{Markup, markup};
use crate::output::plot::{Axis, Frame};
use crate::output::scene::WIDTH;
use crate::output::svg::{Anchor, SERIES, Svg, Type, text_width};
use crate::output::text::{Labels, count, number, quantity, without_noise};

/// Most bars whose course along themselves is drawn.
const DRAWN: usize = 6;

/// The section; empty without bars.
pub fn bars_section<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    if run.model.bars.is_empty() {
        return Markup::default();
    }
    let mut out = markup!("<h2>Bars</h2>\n<p>Forces of one bar, tension positive.</p>\n");
    out += forces(run, labels);
    if run.earlier.is_empty() {
        return out + along(run, labels);
    }
    let svg = over_steps(run, labels);
    out += figure(
        &svg,
        "Forces of the bars over the load steps",
        "The force of the largest magnitude of each bar against the time t of the steps.",
    );
    out + along(run, labels)
}

/// Forces of a bar in each step in which it is present: number of the step from 1, and its solution.
fn courses<'a, const D: usize>(
    run: &'a Overview<'_, D>,
    bar: &'a Bar<D>,
) -> impl Iterator<Item = (usize, f64, &'a BarSolution<D>)> {
    run.steps().enumerate().filter_map(|(step, solution)| {
        let found = solution.bars.iter().find(|own| own.name == bar.name)?;
        Some((step + 1, solution.time, found))
    })
}

/// Least and largest force of a bar in a step.
fn extremes<const D: usize>(bar: &BarSolution<D>) -> [f64; 2] {
    range(bar.stations.iter().map(|station| station.force))
}

fn forces<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    let several = !run.earlier.is_empty();
    let mut heads: Vec<Head> = vec![
        left("bar"),
        left("bond"),
        column("length", &labels.length),
        column("least N", &labels.force),
        column("largest N", &labels.force),
    ];
    if several {
        heads.push(column("least of all steps", &labels.force));
        heads.push(column("step", ""));
        heads.push(column("largest of all steps", &labels.force));
        heads.push(column("step", ""));
    }
    let yields = run.model.bars.iter().any(|bar| bar.yields.is_some());
    if yields {
        heads.push(column("most |N| over yield", ""));
    }
    let all = || run.model.bars.iter().flat_map(|bar| courses(run, bar));
    let scale = all().flat_map(|(.., bar)| extremes(bar).map(f64::abs));
    let scale = scale.fold(0.0, f64::max);
    let told = |force: f64| plain(number(without_noise(force, scale)));
    let row = |bar: &Bar<D>| {
        let course: Vec<_> = courses(run, bar)
            .map(|(k, _, own)| (k, extremes(own)))
            .collect();
        let last = run.last.bars.iter().find(|own| own.name == bar.name);
        let length = courses(run, bar).map(|(.., own)| own.length).next();
        let mut row = vec![
            text(&bar.name),
            text(bar.bond.name()),
            plain(number(length.unwrap_or(f64::NAN))),
        ];
        let now = last.map_or([f64::NAN; 2], extremes);
        row.extend(now.map(told));
        let least = course.iter().min_by(|a, b| a.1[0].total_cmp(&b.1[0]));
        let most = course.iter().max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
        if several {
            for (found, which) in [(least, 0), (most, 1)] {
                row.push(told(found.map_or(f64::NAN, |(_, ends)| ends[which])));
                row.push(plain(found.map_or(String::new(), |(step, _)| count(*step))));
            }
        }
        if yields {
            let largest = course.iter().flat_map(|(_, ends)| ends.map(f64::abs));
            let largest = largest.fold(0.0, f64::max);
            let used = bar.yields.map(|stress| largest / (stress * bar.area));
            row.push(plain(used.map_or("–".to_string(), number)));
        }
        row
    };
    let mut out = table(&heads, run.model.bars.iter().map(row).collect());
    let tightened = run.last.bars.iter().filter(|bar| bar.tightening);
    let tightened: Vec<&str> = tightened.map(|bar| bar.name.as_str()).collect();
    if !tightened.is_empty() {
        out += markup!(
            "<p>Tightened in the last step, in which they pull with their prestress whatever gives: {}.</p>\n",
            tightened.join(", ")
        );
    }
    out
}

fn over_steps<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    let shown: Vec<&Bar<D>> = run.model.bars.iter().take(SERIES.len()).collect();
    let times: Vec<f64> = run.steps().map(|solution| solution.time).collect();
    let of = |bar: &Bar<D>| -> Vec<[f64; 2]> {
        let at = |solution: &crate::model::Solution<D>| {
            let own = solution.bars.iter().find(|own| own.name == bar.name);
            let force = own.and_then(BarSolution::largest);
            [
                solution.time,
                force.map_or(f64::NAN, |station| station.force),
            ]
        };
        run.steps().map(at).collect()
    };
    let curves: Vec<Vec<[f64; 2]>> = shown.iter().map(|bar| of(bar)).collect();
    let values: Vec<f64> = curves.iter().flatten().map(|point| point[1]).collect();
    let mut svg = Svg::new(
        "bars",
        "Forces of the bars over the load steps",
        WIDTH,
        300.0,
    );
    let frame = Frame {
        corner: [86.0, 30.0],
        size: [WIDTH - 106.0, 216.0],
        x: Axis::linear("t", "", &times, false, 8).roomy(),
        y: Axis::linear("N", &labels.force, &values, true, 6).widened(0.06),
    };
    frame.draw(&mut svg, true);
    let mut key = frame.corner[0];
    for ((bar, points), colour) in shown.iter().zip(&curves).zip(SERIES) {
        frame.curve(&mut svg, points, colour, 1.8);
        for [time, force] in points.iter().filter(|point| point[1].is_finite()) {
            let hint = format!(
                "{} at t = {}: {}",
                bar.name,
                number(*time),
                quantity(*force, &labels.force)
            );
            svg.circle(frame.at(*time, *force), 2.6, colour, "#fff", &hint);
        }
        let style = Type::LABEL.anchored(Anchor::Start).coloured(colour);
        svg.text([key, 19.0], &bar.name, style);
        key += text_width(&bar.name, style.size) + 16.0;
    }
    svg.finish()
}

/// The forces along grouted bars.
fn along<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    let grouted = run
        .model
        .bars
        .iter()
        .filter(|bar| bar.bond == Bond::Grouted);
    let one = |(index, bar): (usize, &Bar<D>)| {
        let course: Vec<_> = courses(run, bar).collect();
        let shown = spread(course.len());
        let places: Vec<Vec<LinePoint>> = shown
            .iter()
            .map(|&step| points_of(course[step].2))
            .collect();
        let curves = shown.iter().zip(&places).map(|(&step, places)| Curve {
            name: format!("t = {}", number(course[step].1)),
            places,
        });
        let curves: Vec<Curve<'_>> = curves.collect();
        let named = (format!("N of {}", bar.name), labels.force.as_str());
        let svg = line_figure(
            &format!("bar-{index}"),
            (&named.0, named.1),
            &curves,
            labels,
        );
        let caption = "Along the bar; s counts from its beginning. One force for each element, drawn at its middle.";
        figure(&svg, &bar.name, caption)
    };
    let mut out: Markup = grouted.clone().take(DRAWN).enumerate().map(one).collect();
    let left_out = grouted.count().saturating_sub(DRAWN);
    if left_out > 0 {
        out += markup!("<p>{} more grouted bars: bars.csv.</p>\n", count(left_out));
    }
    out
}

fn points_of<const D: usize>(bar: &BarSolution<D>) -> Vec<LinePoint> {
    let stations = bar.stations.iter();
    let point = |at: &[f64; D]| std::array::from_fn(|i| if i < D { at[i] } else { 0.0 });
    let scale = extremes(bar)
        .into_iter()
        .fold(0.0, |s: f64, f| s.max(f.abs()));
    stations
        .map(|station| LinePoint {
            s: station.s,
            point: point(&station.point),
            value: without_noise(station.force, scale),
            starts: false,
        })
        .collect()
}
