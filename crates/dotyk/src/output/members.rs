//! Sections "Bars", "Springs" of the report, one for each kind of members: the forces of all, their course over the load steps, and
//! along grouted ones.

use crate::model::{Bond, LinePoint, Member, MemberSolution, MemberWords, Solution};
use crate::output::Overview;
use crate::output::html::{Head, column, fitted, left, plain, table, text};
use crate::output::json::range;
use crate::output::lines::{Curve, line_figure, spread};
use crate::output::markup::{Markup, markup};
use crate::output::plot::{Axis, Frame, Stroke, keys};
use crate::output::scene::ticks;
use crate::output::svg::{SERIES, Svg};
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
    let draw = |width| over_steps(run, of, labels, width);
    out += fitted(
        &draw,
        &format!("Forces of the {plural} over the load steps"),
        &format!(
            "The force of the largest magnitude of each {key} against the time t of the steps; below, how much it has changed since the \
             first step with this {key}."
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

/// The forces over time, and below them their changes: a prestress is so much larger that the axis from zero hides these.
fn over_steps<const D: usize>(
    run: &Overview<'_, D>,
    (kind, members): &OfKind<'_, D>,
    labels: &Labels,
    width: f64,
) -> Markup {
    let shown: Vec<&Member<D>> = members.iter().copied().take(SERIES.len()).collect();
    let times: Vec<f64> = run.steps().map(|solution| solution.time).collect();
    let of = |member: &&Member<D>| -> Vec<f64> {
        let at = |solution: &Solution<D>| {
            let own = solution.member(&member.name);
            let force = own.and_then(MemberSolution::largest);
            force.map_or(f64::NAN, |station| station.force)
        };
        run.steps().map(at).collect()
    };
    let forces: Vec<Vec<f64>> = shown.iter().map(of).collect();
    let since_first = |forces: &Vec<f64>| -> Vec<f64> {
        let first = forces.iter().copied().find(|force| force.is_finite());
        let first = first.unwrap_or(f64::NAN);
        let change = |&force: &f64| without_noise(force - first, first.abs());
        forces.iter().map(change).collect()
    };
    let changes: Vec<Vec<f64>> = forces.iter().map(since_first).collect();
    let title = format!("Forces of the {} over the load steps", kind.plural);
    let mut svg = Svg::new(kind.plural, &title, width, 0.0);
    let names: Vec<&str> = shown.iter().map(|member| member.name.as_str()).collect();
    let mut top = keys(&mut svg, [86.0, width], &names) + 2.0;
    for (name, curves, height) in [("N", &forces, 170.0), ("change of N", &changes, 130.0)] {
        let frame = Frame {
            corner: [86.0, top],
            size: [width - 106.0, height],
            x: Axis::linear("t", "", &times, false, ticks(width)).roomy(),
            y: Axis::linear(name, &labels.force, &curves.concat(), true, 5).widened(0.06),
        };
        top += height + 14.0;
        frame.draw(&mut svg, name != "N");
        for (k, (member, values)) in shown.iter().zip(curves).enumerate() {
            let stroke = Stroke::of(k, shown.len());
            let points: Vec<[f64; 2]> = times.iter().zip(values).map(|(&t, &v)| [t, v]).collect();
            frame.stroke(&mut svg, &points, stroke);
            for [time, force] in points.iter().filter(|point| point[1].is_finite()) {
                let hint = format!(
                    "{} at t = {}: {name} = {}",
                    member.name,
                    number(*time),
                    quantity(*force, &labels.force)
                );
                stroke.dot(&mut svg, frame.at(*time, *force), &hint);
            }
        }
    }
    svg.set_height(top + 30.0);
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
        let shown = spread(course.len(), SERIES.len());
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
        let id = format!("{}-{index}", kind.key);
        let named = (("s", named.0.as_str()), named.1);
        let draw = |width| line_figure(&id, named, &curves, labels, width);
        let caption = format!(
            "Along the {}; s counts from its beginning. One force for each element, drawn at its middle.",
            kind.key
        );
        fitted(&draw, &member.name, &caption)
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
