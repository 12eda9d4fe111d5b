//! Sections "Bars", "Springs" of the report, one for each kind of members: the forces of all, their course over the load steps, and
//! along grouted ones.

use crate::model::{Bond, LinePoint, Member, MemberSolution, MemberWords};
use crate::output::Overview;
use crate::output::html::{Head, column, figure, left, plain, table, text};
use crate::output::json::range;
use crate::output::lines::{Curve, line_figure, spread};
use crate::output::markup::{Markup, markup};
use crate::output::plot::{Axis, Frame};
use crate::output::scene::WIDTH;
use crate::output::svg::{Anchor, SERIES, Svg, Type, text_width};
use crate::output::text::{Labels, count, number, quantity, without_noise};

/// Most members of a kind whose course along themselves is drawn.
const DRAWN: usize = 6;

/// The sections of all kinds; empty without members.
pub fn member_sections<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    let kinds = run.model.members_by_kind();
    kinds.map(|kind| section(run, &kind, labels)).collect()
}

/// A kind, and its members.
type OfKind<'a, const D: usize> = (MemberWords, Vec<&'a Member<D>>);

fn section<const D: usize>(run: &Overview<'_, D>, of: &OfKind<'_, D>, labels: &Labels) -> Markup {
    let MemberWords { key, plural, .. } = of.0;
    let (first, rest) = plural.split_at(1);
    let mut out = markup!(
        "<h2>{}{}</h2>\n<p>Forces of one {}, tension positive.</p>\n",
        first.to_uppercase(),
        rest,
        key
    );
    out += forces(run, of, labels);
    if run.earlier.is_empty() {
        return out + along(run, of, labels);
    }
    let svg = over_steps(run, of, labels);
    out += figure(
        &svg,
        &format!("Forces of the {plural} over the load steps"),
        &format!(
            "The force of the largest magnitude of each {key} against the time t of the steps."
        ),
    );
    out + along(run, of, labels)
}

/// Forces of a member in each step in which it is present: number of the step from 1, its time, and its solution.
fn courses<'a, const D: usize>(
    run: &'a Overview<'_, D>,
    member: &'a Member<D>,
) -> impl Iterator<Item = (usize, f64, &'a MemberSolution<D>)> {
    run.steps().enumerate().filter_map(|(step, solution)| {
        let found = solution.member(&member.name)?;
        Some((step + 1, solution.time, found))
    })
}

/// Least and largest force of a member in a step.
fn extremes<const D: usize>(member: &MemberSolution<D>) -> [f64; 2] {
    range(member.stations.iter().map(|station| station.force))
}

fn forces<const D: usize>(
    run: &Overview<'_, D>,
    (kind, members): &OfKind<'_, D>,
    labels: &Labels,
) -> Markup {
    let several = !run.earlier.is_empty();
    // a cut has no length, and draws its sides together instead
    let drawn = members.iter().any(|member| member.kind.is_bolt());
    let mut heads: Vec<Head> = vec![
        left(kind.key),
        left(kind.choice),
        column(if drawn { "shortening" } else { "length" }, &labels.length),
        column("least N", &labels.force),
        column("largest N", &labels.force),
    ];
    if several {
        heads.push(column("least of all steps", &labels.force));
        heads.push(column("step", ""));
        heads.push(column("largest of all steps", &labels.force));
        heads.push(column("step", ""));
    }
    let strength = |member: &Member<D>| member.kind.pull().strength();
    let yields = members.iter().any(|member| strength(member).is_some());
    if yields {
        heads.push(column("most |N| over yield", ""));
    }
    let all = || members.iter().flat_map(|member| courses(run, member));
    let scale = all().flat_map(|(.., own)| extremes(own).map(f64::abs));
    let scale = scale.fold(0.0, f64::max);
    let told = |force: f64| plain(number(without_noise(force, scale)));
    let row = |member: &&Member<D>| {
        let course: Vec<_> = courses(run, member)
            .map(|(k, _, own)| (k, extremes(own)))
            .collect();
        let last = run.last.member(&member.name);
        let length = match drawn {
            true => last.and_then(|own| own.shortening),
            false => courses(run, member).map(|(.., own)| own.length).next(),
        };
        let mut row = vec![
            text(&member.name),
            text(member.kind.pull().chosen(member.line.bond)),
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
            let used = strength(member).map(|most| largest / most);
            row.push(plain(used.map_or("–".to_string(), number)));
        }
        row
    };
    let mut out = table(&heads, members.iter().map(row).collect());
    let tightened = run.last.members.iter();
    let tightened = tightened.filter(|own| own.kind == *kind && own.tightening);
    let tightened: Vec<&str> = tightened.map(|own| own.name.as_str()).collect();
    if !tightened.is_empty() {
        out += markup!(
            "<p>Tightened in the last step, in which they pull with their prestress whatever gives: {}.</p>\n",
            tightened.join(", ")
        );
    }
    out
}

fn over_steps<const D: usize>(
    run: &Overview<'_, D>,
    (kind, members): &OfKind<'_, D>,
    labels: &Labels,
) -> Markup {
    let shown: Vec<&Member<D>> = members.iter().copied().take(SERIES.len()).collect();
    let times: Vec<f64> = run.steps().map(|solution| solution.time).collect();
    let of = |member: &Member<D>| -> Vec<[f64; 2]> {
        let at = |solution: &crate::model::Solution<D>| {
            let own = solution.member(&member.name);
            let force = own.and_then(MemberSolution::largest);
            [
                solution.time,
                force.map_or(f64::NAN, |station| station.force),
            ]
        };
        run.steps().map(at).collect()
    };
    let curves: Vec<Vec<[f64; 2]>> = shown.iter().map(|member| of(member)).collect();
    let values: Vec<f64> = curves.iter().flatten().map(|point| point[1]).collect();
    let mut svg = Svg::new(
        kind.plural,
        &format!("Forces of the {} over the load steps", kind.plural),
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
    for ((member, points), colour) in shown.iter().zip(&curves).zip(SERIES) {
        frame.curve(&mut svg, points, colour, 1.8);
        for [time, force] in points.iter().filter(|point| point[1].is_finite()) {
            let hint = format!(
                "{} at t = {}: {}",
                member.name,
                number(*time),
                quantity(*force, &labels.force)
            );
            svg.circle(frame.at(*time, *force), 2.6, colour, "#fff", &hint);
        }
        let style = Type::LABEL.anchored(Anchor::Start).coloured(colour);
        svg.text([key, 19.0], &member.name, style);
        key += text_width(&member.name, style.size) + 16.0;
    }
    svg.finish()
}

/// The forces along grouted members.
fn along<const D: usize>(
    run: &Overview<'_, D>,
    (kind, members): &OfKind<'_, D>,
    labels: &Labels,
) -> Markup {
    let grouted = members.iter().copied();
    let grouted = grouted.filter(|member| member.line.bond == Bond::Grouted);
    let one = |(index, member): (usize, &Member<D>)| {
        let course: Vec<_> = courses(run, member).collect();
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
        let named = (format!("N of {}", member.name), labels.force.as_str());
        let svg = line_figure(
            &format!("{}-{index}", kind.key),
            (&named.0, named.1),
            &curves,
            labels,
        );
        let caption = format!(
            "Along the {}; s counts from its beginning. One force for each element, drawn at its middle.",
            kind.key
        );
        figure(&svg, &member.name, &caption)
    };
    let mut out: Markup = grouted.clone().take(DRAWN).enumerate().map(one).collect();
    let left_out = grouted.count().saturating_sub(DRAWN);
    if left_out > 0 {
        out += markup!(
            "<p>{} more grouted {}: {}.csv.</p>\n",
            count(left_out),
            kind.plural,
            kind.plural
        );
    }
    out
}

fn points_of<const D: usize>(member: &MemberSolution<D>) -> Vec<LinePoint> {
    let stations = member.stations.iter();
    let point = |at: &[f64; D]| std::array::from_fn(|i| if i < D { at[i] } else { 0.0 });
    let scale = extremes(member)
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
