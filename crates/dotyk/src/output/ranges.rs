//! Colour ranges of the von Mises stress: which bodies share one, where it ends, and its bar.
//!
//! A soft seal between steel parts would be of one colour with them: bodies whose largest stresses differ by much have ranges of their
//! own, as far as their bars fit beside a picture. Bodies of one material, and those that are tied, have one range, so that colours do
//! not jump where stresses do not.

use crate::model::{Body, BodySolution, Dimension, Law, Model, Solution};
use crate::output::colour;
use crate::output::encode::png;
use crate::output::json::largest;
use crate::output::plot::Axis;
use crate::output::svg::{Anchor, INK, MUTED, Pixel, Svg, Type, segments, text_width};
use crate::output::text::{Labels, Scales, count, quantity, vector};
use std::collections::BTreeMap;

/// Bodies whose largest stresses differ by more than this factor have their own ranges.
const APART: f64 = 4.0;
/// Most ranges of a picture.
const MOST: usize = 4;
/// A range ends below the largest stress if it then is shorter than this part of it.
pub const CLEARLY: f64 = 0.8;
/// Room for a colour bar with its numbers.
pub const BAR: f64 = 92.0;
/// Least height of a bar with its words.
const LEAST: f64 = 104.0;

/// Bodies with one colour range, which begins at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// Stress at its end.
    pub high: f64,
}

/// The end of the range of a body: its largest stress, or, if that is at a place where stresses are not finite, the usual one if it
/// is clearly less.
fn shown_stress<const D: usize>(body: &BodySolution<D>) -> f64 {
    let most = largest(body.von_mises.iter().copied().filter(|v| v.is_finite())).max(0.0);
    let Some(singular) = body.peak.and_then(|peak| peak.place) else {
        return most;
    };
    match singular.usual > 0.0 && singular.usual < CLEARLY * most {
        true => singular.usual,
        false => most,
    }
}

/// The ranges of all bodies in these solutions of a model or of its stages: each takes the bodies down to a part of its end, the last
/// one all others.
pub fn stress_ranges<'a, const D: usize>(
    model: &Model<D>,
    solutions: impl IntoIterator<Item = &'a Solution<D>>,
) -> Vec<Range> {
    let mut groups = alike(model);
    for solution in solutions {
        let scales = Scales::of(solution);
        for body in &solution.bodies {
            let high = scales.without_noise(shown_stress(body), Dimension::Stress);
            let own = groups.iter_mut();
            for group in own.filter(|group| group.bodies.contains(&body.name)) {
                group.high = group.high.max(high);
            }
        }
    }
    let order: Vec<String> = groups.iter().map(|group| group.bodies[0].clone()).collect();
    let mut left = groups;
    let mut ranges: Vec<Range> = Vec::new();
    while !left.is_empty() {
        let high = largest(left.iter().map(|group| group.high));
        let apart = |group: &Range| APART * group.high < high;
        let last = ranges.len() + 1 == MOST || !left.iter().any(|g| g.high > 0.0 && apart(g));
        let (own, others): (Vec<Range>, Vec<Range>) =
            left.into_iter().partition(|group| last || !apart(group));
        left = others;
        let bodies = own.into_iter().flat_map(|group| group.bodies).collect();
        ranges.push(Range { bodies, high });
    }
    // in the order of the bodies, which does not change from step to step
    let place = |range: &Range| order.iter().position(|name| *name == range.bodies[0]);
    ranges.sort_by_key(place);
    ranges
}

/// The bodies of a model, those of one material and those that are tied together, with empty ranges.
fn alike<const D: usize>(model: &Model<D>) -> Vec<Range> {
    let mut group: Vec<usize> = (0..model.bodies.len()).collect();
    let mut join = |a: usize, b: usize| {
        let [kept, gone] = [group[a].min(group[b]), group[a].max(group[b])];
        group
            .iter_mut()
            .filter(|own| **own == gone)
            .for_each(|own| *own = kept);
    };
    for (b, body) in model.bodies.iter().enumerate() {
        let own = |other: &Body<D>| other.materials == body.materials;
        let first = model.bodies[..b].iter().position(own);
        first.inspect(|&first| join(first, b));
    }
    for contact in model
        .contacts
        .iter()
        .filter(|contact| matches!(contact.law, Law::Tied))
    {
        if let [a, b] = contact.pair.sides()[..] {
            join(a.body.0, b.body.0);
        }
    }
    let mut groups: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for (body, group) in model.bodies.iter().zip(group) {
        groups.entry(group).or_default().push(body.name.clone());
    }
    let groups = groups.into_values();
    groups.map(|bodies| Range { bodies, high: 0.0 }).collect()
}

/// The end of the range of a body, above zero.
pub fn end_for(ranges: &[Range], body: &str) -> f64 {
    let own = ranges
        .iter()
        .find(|range| range.bodies.iter().any(|name| name == body));
    own.map(|range| range.high)
        .filter(|high| *high > 0.0)
        .unwrap_or(1.0)
}

/// Words on the ranges, where there are several, and on values beyond their ends.
pub fn in_words<const D: usize>(
    solution: &Solution<D>,
    ranges: &[Range],
    labels: &Labels,
) -> String {
    let beyond = ranges
        .iter()
        .filter_map(|range| beyond(solution, range, labels));
    let own = match ranges.len() {
        0 | 1 => String::new(),
        _ => {
            let each = ranges.iter().map(|range| {
                let end = quantity(range.high, &labels.stress);
                format!("{} up to {end}", range.bodies.join(", "))
            });
            format!(" Colour ranges: {}.", each.collect::<Vec<_>>().join("; "))
        }
    };
    own + &beyond.collect::<String>()
}

fn beyond<const D: usize>(
    solution: &Solution<D>,
    range: &Range,
    labels: &Labels,
) -> Option<String> {
    let bodies = solution
        .bodies
        .iter()
        .filter(|body| range.bodies.contains(&body.name));
    let peaks = bodies.filter_map(|body| Some((body, body.peak?)));
    let beyond = peaks.filter(|(_, peak)| peak.most.value > range.high);
    let (body, peak) = beyond.max_by(|a, b| a.1.most.value.total_cmp(&b.1.most.value))?;
    let singular = peak.place?;
    Some(format!(
        " The colours end at {}, which {} % of {} does not exceed: its largest, {} at {}, is at {}, where the theory has no finite \
         stress.",
        quantity(range.high, &labels.stress),
        // rounded down: never 100 %
        (1000.0 * singular.share).floor() / 10.0,
        body.name,
        quantity(peak.most.value, &labels.stress),
        vector(&peak.most.at, ""),
        singular.place,
    ))
}

/// Least height of a figure with the bars of these ranges.
pub fn least_height(ranges: &[Range]) -> f64 {
    16.0 + LEAST * ranges.len() as f64
}

/// One bar per range, at the right of a figure of this size.
pub fn colour_bars<const D: usize>(
    svg: &mut Svg,
    solution: &Solution<D>,
    ranges: &[Range],
    labels: &Labels,
    [width, height]: Pixel,
) {
    let each = height / ranges.len() as f64;
    let left = width - BAR + 18.0;
    for (k, range) in ranges.iter().enumerate() {
        let top = 16.0 + each * k as f64;
        let axis = Axis::linear("Von Mises", &labels.stress, &[0.0, range.high], true, 5);
        let mut start = top + 4.0;
        if ranges.len() > 1 {
            let small = Type::SMALL.anchored(Anchor::Start);
            svg.text([left, start], &short_name(range, small.size), small.bold());
            start += 13.0;
        }
        start = name_bar(svg, &axis, [left, start]);
        let bodies = solution
            .bodies
            .iter()
            .filter(|body| range.bodies.contains(&body.name));
        let mut peaks = bodies.filter_map(|body| body.peak);
        let more = peaks.any(|peak| peak.most.value > range.high);
        colour_bar(svg, [left, start], top + each - 22.0 - start, &axis, more);
    }
}

/// Quantity and unit above a bar, in a line each; returns where the bar begins.
pub fn name_bar(svg: &mut Svg, axis: &Axis, [left, top]: Pixel) -> f64 {
    let small = Type::SMALL.coloured(MUTED);
    let (name, unit) = match axis.label.split_once(" [") {
        Some((name, unit)) => (name, format!("[{unit}")),
        None => (axis.label.as_str(), String::new()),
    };
    let mut y = top;
    for line in [name, &unit].into_iter().filter(|line| !line.is_empty()) {
        // a long unit ends at the edge of the figure
        match text_width(line, small.size) < BAR - 20.0 {
            true => svg.text([left, y], line, small.anchored(Anchor::Start)),
            false => svg.text([left + BAR - 20.0, y], line, small.anchored(Anchor::End)),
        }
        y += 13.0;
    }
    y
}

/// Names of the bodies of a range as far as there is room beside a picture, else their number.
fn short_name(range: &Range, size: f64) -> String {
    let names = range.bodies.join(", ");
    match (
        text_width(&names, 1.1 * size) < BAR - 20.0,
        range.bodies.as_slice(),
    ) {
        (true, _) => names,
        (false, [one]) => {
            let start: String = one.chars().take(9).collect();
            format!("{start}…")
        }
        (false, several) => format!("{} bodies", count(several.len())),
    }
}

/// A strip of the colours with the ticks of its axis, and its height; with a tip if values exceed its end.
pub fn colour_bar(svg: &mut Svg, [left, top]: Pixel, height: f64, axis: &Axis, more: bool) -> f64 {
    let strip: Vec<u8> = (0..colour::STEPS).rev().map(|i| 1 + i as u8).collect();
    let picture = png(1, colour::STEPS, &strip, &colour::palette());
    let size = [14.0, height.clamp(40.0, 260.0)];
    svg.picture([left, top], size, &picture);
    svg.rectangle([left, top], size, INK, "none");
    if more {
        // values beyond the end of the scale have a colour, too
        let tip = [[left, top], [left + 14.0, top], [left + 7.0, top - 9.0]];
        let end = colour::palette()[colour::STEPS];
        let fill = format!("#{:02x}{:02x}{:02x}", end[0], end[1], end[2]);
        svg.path(&segments(&tip, true), INK, 1.0, &fill, "");
    }
    let mut last = f64::INFINITY;
    for (value, text) in &axis.ticks {
        let y = top + (1.0 - axis.fraction(*value)) * size[1];
        svg.line([left + 14.0, y], [left + 18.0, y], INK, 0.8);
        // numbers of a short bar would touch
        if last - y > 11.0 {
            let style = Type::SMALL.anchored(Anchor::Start);
            svg.text([left + 21.0, y + 3.6], text, style);
            last = y;
        }
    }
    size[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel;

    #[test]
    fn very_different_stresses_get_their_own_ranges() {
        let (mut model, mut solution) = tunnel::solved();
        let ranges = stress_ranges(&model, [&solution]);
        let names: Vec<&[String]> = ranges.iter().map(|range| &range.bodies[..]).collect();
        assert_eq!(names, [["ring"], ["rock"]]);
        assert!(end_for(&ranges, "ring") > APART * end_for(&ranges, "rock"));
        // tied, or of one material, they have one
        let law = std::mem::replace(&mut model.contacts[0].law, Law::Tied);
        assert_eq!(stress_ranges(&model, [&solution]).len(), 1);
        model.contacts[0].law = law;
        let rock = model.bodies[1].materials.clone();
        let own = std::mem::replace(&mut model.bodies[0].materials, rock);
        assert_eq!(stress_ranges(&model, [&solution]).len(), 1);
        model.bodies[0].materials = own;
        let rock = solution.bodies[1].von_mises.clone();
        solution.bodies[0].von_mises = rock;
        assert_eq!(stress_ranges(&model, [&solution]).len(), 1);
    }

    #[test]
    fn many_bodies_share_a_few_ranges_and_the_weakest_the_last() {
        let (mut model, mut solution) = tunnel::solved();
        let body = solution.bodies[1].clone();
        let layer = model.bodies[1].clone();
        model.contacts.clear();
        model.bodies = (0..9)
            .map(|k| {
                let mut own = layer.clone();
                own.name = format!("layer{k}");
                own.materials[0].elastic.young += f64::from(k);
                own
            })
            .collect();
        solution.bodies = (0..9)
            .map(|k| {
                let mut body = body.clone();
                body.name = format!("layer{k}");
                body.peak = None;
                body.von_mises = vec![100.0 / 3_f64.powi(k)];
                body
            })
            .collect();
        solution.bodies[8].von_mises = vec![0.0];
        let ranges = stress_ranges(&model, [&solution]);
        let sizes: Vec<usize> = ranges.iter().map(|range| range.bodies.len()).collect();
        assert_eq!(sizes, [2, 2, 2, 3]);
        assert_eq!(end_for(&ranges, "layer8"), ranges[3].high);
    }
}
