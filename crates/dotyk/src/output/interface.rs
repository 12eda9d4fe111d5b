//! Figure "Contact pressure and gap along the interface": aligned plots against arc length, and the pressure as arrows
//! on the interface.
//!
//! Signs: gap ≥ 0 open, pressure ≥ 0 compression. The arc length runs along the nonmortar side, undeformed.

use crate::geometry::{Point, add_scaled, bounding_box, distance, dot, norm, sub};
use crate::model::{ContactNode, ContactSolution, Law, Status};
use crate::output::chain::{angles, arc_lengths, tangent};
use crate::output::json::{in_contact, largest};
use crate::output::markup::Markup;
use crate::output::plot::{Axis, Frame};
use crate::output::scene::{PHONE, Scene, outline_path, polyline, ticks};
use crate::output::svg::{
    Anchor, CLOSED, INK, MUTED, OPEN, Pixel, SERIES, SLIP, STICK, Svg, TINTS, Type, segments,
    text_width,
};
use crate::output::text::{Labels, number, quantity, without_noise};

/// More nodes than this are drawn as a line without dots.
const MOST_DOTS: usize = 120;

/// What touches on a smaller part of its side is drawn alone, with its surroundings.
const SMALL: f64 = 0.2;

/// A part of an interface, and whether it is not all of it.
pub struct Stretch<'a> {
    /// In their order along the side.
    chain: Vec<&'a ContactNode<2>>,
    /// Arc lengths, negative before the first node of a closed interface.
    arcs: Vec<f64>,
    /// Length of the whole side.
    whole: f64,
    part: bool,
}

impl<'a> Stretch<'a> {
    /// What touches with its surroundings, where the whole side would show it as a spike; otherwise all of it. `None` for a contact
    /// that touches nowhere.
    pub fn of(contact: &'a ContactSolution<2>) -> Option<Self> {
        let mut chain: Vec<&ContactNode<2>> = contact.nodes.iter().collect();
        if contact.cyclic {
            chain.push(&contact.nodes[0]);
        }
        let points: Vec<Point<2>> = chain.iter().map(|n| n.point).collect();
        let mut arcs = arc_lengths(&points);
        let whole = *arcs.last()?;
        if contact.cyclic {
            cut_where_open(&mut chain, &mut arcs, whole);
        }
        let touches = |node: &&ContactNode<2>| in_contact(node.status);
        let (first, last) = (
            chain.iter().position(touches)?,
            chain.iter().rposition(touches)?,
        );
        // a single node touches halfway to its neighbours
        let ends = [first.saturating_sub(1), (last + 1).min(chain.len() - 1)];
        let size = (arcs[last] - arcs[first]).max(0.5 * (arcs[ends[1]] - arcs[ends[0]]));
        let part = size < SMALL * whole;
        if part {
            let (low, high) = (arcs[first] - size, arcs[last] + size);
            let seen = |arc: f64| arc >= low && arc <= high;
            let from = arcs.iter().position(|&arc| seen(arc)).unwrap_or(first);
            let to = arcs.iter().rposition(|&arc| seen(arc)).unwrap_or(last);
            let range = from.min(ends[0])..to.max(ends[1]) + 1;
            chain = chain[range.clone()].to_vec();
            arcs = arcs[range].to_vec();
        }
        Some(Self {
            chain,
            arcs,
            whole,
            part,
        })
    }

    /// Words for the caption, where it is a part.
    pub fn in_words(&self, labels: &Labels) -> String {
        let shown = self.arcs.last().unwrap_or(&0.0) - self.arcs.first().unwrap_or(&0.0);
        match self.part {
            true => format!(
                " Of the side, {} long, the {} around what touches are drawn.",
                quantity(self.whole, &labels.length),
                quantity(shown, &labels.length)
            ),
            false => String::new(),
        }
    }
}

/// Begins a closed interface amid its longest open part if its first node touches, so that what touches is one piece; arcs before the
/// first node are negative.
fn cut_where_open(chain: &mut Vec<&ContactNode<2>>, arcs: &mut Vec<f64>, whole: f64) {
    let open = |k: usize| !in_contact(chain[k].status);
    if open(0) || !(0..chain.len()).any(open) {
        return;
    }
    let (mut longest, mut start) = (0..0, None);
    for k in 0..chain.len() {
        match (open(k), start) {
            (true, None) => start = Some(k),
            (false, Some(from)) => {
                if arcs[k] - arcs[from] > arcs[longest.end] - arcs[longest.start] {
                    longest = from..k;
                }
                start = None;
            }
            _ => {}
        }
    }
    let cut = (longest.start + longest.end) / 2;
    // the last node is the first one again
    let nodes = chain[cut..].iter().chain(&chain[1..=cut]).copied();
    let places = arcs[cut..].iter().map(|arc| arc - whole);
    let places: Vec<f64> = places.chain(arcs[1..=cut].iter().copied()).collect();
    (*chain, *arcs) = (nodes.collect(), places);
}

/// The figure as an SVG element.
pub fn interface_figure(
    scene: &Scene,
    contact: &ContactSolution<2>,
    stretch: &Stretch<'_>,
    law: &Law,
    (id, full): (&str, f64),
) -> Markup {
    let labels = Labels::of(scene.model);
    let Stretch { chain, arcs, .. } = stretch;
    let points: Vec<Point<2>> = chain.iter().map(|n| n.point).collect();
    let (low, high) = bounding_box(&points);
    let extent = sub(high, low);
    let beside = extent[1] > 0.4 * extent[0] && full > PHONE;
    let panels = panels(chain, law, scene.model.last_time(), &labels);
    let picture_width = if beside { 236.0 } else { full };
    let heights: f64 = panels.iter().map(|p| p.height + 12.0).sum();
    let angles = angles(&points);
    let head = if angles.is_some() { 46.0 } else { 26.0 };

    let description = format!("Contact pressure and gap along {}", contact.name);
    let mut svg = Svg::new(id, &description, full, 0.0);
    let strip = if beside {
        0.0
    } else {
        let tall = extent[1] / extent[0].max(f64::MIN_POSITIVE) + 0.24;
        (tall * 0.8 * full + 36.0).min(300.0)
    };
    let left = 74.0;
    let width = if beside {
        full - picture_width - left - 30.0
    } else {
        full - left - 16.0
    };
    let top = strip + head;
    draw_panels(
        &mut svg,
        &panels,
        (chain, arcs, angles.as_deref()),
        [left, top],
        width,
        &labels,
    );
    let bottom = top + heights + 44.0;
    let (corner, size) = match beside {
        true => (
            [full - picture_width, 6.0],
            [picture_width - 2.0, bottom - 12.0],
        ),
        false => ([left, 4.0], [width, strip - 8.0]),
    };
    picture(&mut svg, scene, contact, chain, corner, size, &labels);
    svg.set_height(bottom);
    svg.finish()
}

/// One plot of the stack.
struct Panel {
    axis: Axis,
    values: Vec<f64>,
    height: f64,
    colour: &'static str,
    /// Upper bound and its negative, of shear.
    bound: Option<Vec<f64>>,
}

fn panels(chain: &[&ContactNode<2>], law: &Law, time: f64, labels: &Labels) -> Vec<Panel> {
    let panel = |name: &str,
                 unit: &str,
                 values: Vec<f64>,
                 bound: Option<Vec<f64>>,
                 height: f64,
                 series: usize| {
        let mut seen = values.clone();
        seen.extend(bound.iter().flatten());
        Panel {
            axis: Axis::linear(name, unit, &seen, true, 5).widened(0.06),
            values,
            height,
            colour: SERIES[series],
            bound,
        }
    };
    let pressures: Vec<f64> = chain.iter().map(|n| n.pressure).collect();
    let scale = length_scale(chain.iter().copied());
    let quiet = |length: f64| without_noise(length, scale);
    let gaps: Vec<f64> = chain.iter().map(|n| quiet(n.gap)).collect();
    let mut list = vec![
        panel("Pressure", &labels.stress, pressures, None, 170.0, 0),
        panel("Gap", &labels.length, gaps, None, 118.0, 1),
    ];
    if !matches!(law, Law::Frictionless) {
        let shear = chain
            .iter()
            .map(|n| dot(n.shear, tangent(n.normal)))
            .collect();
        let slip = chain
            .iter()
            .map(|n| quiet(dot(n.slip, tangent(n.normal))))
            .collect();
        let bound = |n: &&ContactNode<2>| law.shear_limit(n.pressure, n.point, time);
        let bound = chain.iter().map(bound).collect::<Option<_>>();
        let both = bound.map(|b: Vec<f64>| b.iter().copied().chain(b.iter().map(|v| -v)).collect());
        list.push(panel("Shear", &labels.stress, shear, both, 118.0, 2));
        list.push(panel("Slip", &labels.length, slip, None, 100.0, 3));
    }
    list
}

fn draw_panels(
    svg: &mut Svg,
    panels: &[Panel],
    (chain, arcs, angles): (&[&ContactNode<2>], &[f64], Option<&[f64]>),
    corner: Pixel,
    width: f64,
    labels: &Labels,
) {
    let x = Axis::linear(
        "Arc length along the interface",
        &labels.length,
        arcs,
        false,
        ticks(width + 90.0),
    );
    let mut top = corner[1];
    for (k, panel) in panels.iter().enumerate() {
        let frame = Frame {
            corner: [corner[0], top],
            size: [width, panel.height],
            x: x.clone(),
            y: panel.axis.clone(),
        };
        shade(svg, &frame, chain, arcs);
        frame.draw(svg, k + 1 == panels.len());
        if let Some(bound) = &panel.bound {
            for half in bound.chunks(arcs.len()) {
                let curve: Vec<[f64; 2]> = arcs
                    .iter()
                    .copied()
                    .zip(half.iter().copied())
                    .map(<[f64; 2]>::from)
                    .collect();
                frame.curve(svg, &curve, MUTED, 0.9);
            }
        }
        let curve: Vec<[f64; 2]> = arcs
            .iter()
            .zip(&panel.values)
            .map(|(&s, &v)| [s, v])
            .collect();
        frame.curve(svg, &curve, panel.colour, 1.8);
        if chain.len() <= MOST_DOTS {
            for (node, p) in chain.iter().zip(&curve).filter(|(_, p)| p[1].is_finite()) {
                let title = format!("node {}: {}", node.node, number(p[1]));
                svg.circle(frame.at(p[0], p[1]), 2.2, panel.colour, "#fff", &title);
            }
        }
        if k == 0 {
            key(
                svg,
                [
                    corner[0] + width,
                    top - if angles.is_some() { 36.0 } else { 10.0 },
                ],
                chain,
            );
            if let Some(angles) = angles {
                angle_axis(svg, &frame, arcs, angles);
            }
        }
        top += panel.height + 12.0;
    }
}

/// Name, colour and states of a band.
type Band = (&'static str, &'static str, fn(Status) -> bool);

/// Bands by state: open, closed or tied, stick, slip.
const BANDS: [Band; 4] = [
    ("open", OPEN, |s| s == Status::Open),
    ("closed", CLOSED, |s| {
        in_contact(s) && s != Status::Stick && s != Status::Slip
    }),
    ("stick", STICK, |s| s == Status::Stick),
    ("slip", SLIP, |s| s == Status::Slip),
];

/// Bands in the background, by the state of the nodes.
fn shade(svg: &mut Svg, frame: &Frame, chain: &[&ContactNode<2>], arcs: &[f64]) {
    let fill = |node: &ContactNode<2>| {
        let band = BANDS.iter().find(|band| band.2(node.status));
        band.map(|band| band.1)
    };
    let mut start = 0;
    for i in 1..=chain.len() {
        if i < chain.len() && fill(chain[i]) == fill(chain[start]) {
            continue;
        }
        let from = if start == 0 {
            arcs[0]
        } else {
            0.5 * (arcs[start - 1] + arcs[start])
        };
        let to = if i == chain.len() {
            arcs[i - 1]
        } else {
            0.5 * (arcs[i - 1] + arcs[i])
        };
        if let Some(colour) = fill(chain[start]) {
            frame.band(svg, from, to, colour);
        }
        start = i;
    }
}

/// The key of the bands, right-aligned at `end`.
fn key(svg: &mut Svg, end: Pixel, chain: &[&ContactNode<2>]) {
    let mut x = end[0];
    let occurs = |band: &&Band| chain.iter().any(|n| band.2(n.status));
    for (name, fill, _) in BANDS.iter().filter(|band| occurs(band)) {
        let small = Type::SMALL.coloured(MUTED);
        x -= text_width(name, 10.5);
        svg.text([x, end[1]], name, small.anchored(Anchor::Start));
        x -= 18.0;
        svg.rectangle([x, end[1] - 8.5], [13.0, 9.0], MUTED, fill);
        x -= 14.0;
    }
}

/// A second scale above the plot where the interface is a circle: the angle from +x.
fn angle_axis(svg: &mut Svg, frame: &Frame, arcs: &[f64], angles: &[f64]) {
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    let span = (last - first).abs();
    let every = [5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0]
        .into_iter()
        .find(|e| span / e <= 9.0)
        .unwrap_or(90.0);
    let small = Type::SMALL.coloured(MUTED);
    let y = frame.corner[1];
    let (low, high) = (first.min(last), first.max(last));
    let mut k = (low / every - 1e-6).ceil();
    while k * every <= high + 1e-6 * every {
        let angle = k * every;
        let t = (angle - first) / (last - first);
        let x = frame.across(arcs[0] + t * (arcs[arcs.len() - 1] - arcs[0]));
        svg.line([x, y - 4.0], [x, y], INK, 0.8);
        // Beyond a full turn the scale starts again.
        let shown = if angle > 180.0 + 1e-6 {
            angle - 360.0
        } else {
            angle
        } + 0.0;
        svg.text(
            [x, y - 8.0],
            &format!("{shown:.0}°").replace('-', "−"),
            small,
        );
        k += 1.0;
    }
    let at = [frame.corner[0], y - 25.0];
    svg.text(at, "Angle from +x", small.anchored(Anchor::Start));
}

/// The interface as it lies, with the pressure on the nonmortar body as arrows.
fn picture(
    svg: &mut Svg,
    scene: &Scene,
    contact: &ContactSolution<2>,
    chain: &[&ContactNode<2>],
    corner: Pixel,
    size: Pixel,
    labels: &Labels,
) {
    let most = largest(chain.iter().map(|n| n.pressure)).max(0.0);
    let points: Vec<Point<2>> = chain.iter().map(|n| n.point).collect();
    let (low, high) = bounding_box(&points);
    let caption = 18.0;
    let room = [size[0] - 12.0, size[1] - 12.0 - caption];
    // Arrows take 15 % of the interface's size, at least what can be seen.
    let reach = 0.16
        * (high[0] - low[0])
            .max(high[1] - low[1])
            .max(f64::MIN_POSITIVE);
    let tips = chain.iter().map(|n| add_scaled(n.point, reach, n.normal));
    let (low, high) = bounding_box(&points.iter().copied().chain(tips).collect::<Vec<_>>());
    let margin = 0.25 * reach;
    let scale = [0, 1]
        .map(|i| room[i] / (high[i] - low[i] + 2.0 * margin))
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let middle = [0, 1].map(|i| 0.5 * (low[i] + high[i]));
    let center = [
        corner[0] + 0.5 * size[0],
        corner[1] + 0.5 * (size[1] - caption),
    ];
    let pixel = |p: Point<2>| {
        [
            center[0] + scale * (p[0] - middle[0]),
            center[1] - scale * (p[1] - middle[1]),
        ]
    };

    svg.begin_clip(corner, [size[0], size[1] - caption]);
    // a body out of sight is left out: each of many contacts has its own picture
    let meets = |(low, high): (Point<2>, Point<2>)| {
        let (low, high) = (pixel(low), pixel(high));
        let (end, beside) = ([0, 1].map(|i| corner[i] + size[i]), (high[0] >= corner[0]));
        beside && low[0] <= end[0] && high[1] <= end[1] && low[1] >= corner[1]
    };
    let bodies = scene.model.bodies.iter().enumerate();
    for (i, body) in bodies.filter(|(i, _)| meets(scene.extents[*i])) {
        let path = outline_path(&scene.outlines[i], &|n| pixel(body.mesh.points()[n]));
        svg.path(
            &path,
            "#9aa5b0",
            0.8,
            TINTS[i % TINTS.len()],
            "fill-rule=\"evenodd\"",
        );
    }
    let length = |pressure: f64| {
        if most > 0.0 && pressure.is_finite() {
            reach * pressure.max(0.0) / most
        } else {
            0.0
        }
    };
    let tops: Vec<Pixel> = chain
        .iter()
        .map(|n| pixel(add_scaled(n.point, length(n.pressure), n.normal)))
        .collect();
    let feet: Vec<Pixel> = chain.iter().map(|n| pixel(n.point)).collect();
    let fence: Vec<Pixel> = feet
        .iter()
        .copied()
        .chain(tops.iter().rev().copied())
        .collect();
    svg.path(
        &segments(&fence, true),
        "none",
        0.0,
        SERIES[0],
        "fill-opacity=\"0.14\"",
    );
    // As many arrows as can stand side by side.
    let along: f64 = feet.windows(2).map(|w| distance(w[0], w[1])).sum();
    let every = (chain.len() as f64 * 7.0 / along.max(1.0)).ceil().max(1.0) as usize;
    for i in (0..chain.len()).step_by(every) {
        svg.arrow(tops[i], feet[i], SERIES[0], 0.8);
    }
    svg.path(
        &polyline(&tops),
        SERIES[0],
        1.2,
        "none",
        "stroke-linejoin=\"round\"",
    );
    interface_line(svg, chain, &feet);
    svg.end_clip();
    let text = format!("{}: p ≤ {}", contact.name, quantity(most, &labels.stress));
    svg.text(
        [center[0], corner[1] + size[1] - 3.0],
        &text,
        Type::SMALL.coloured(MUTED),
    );
}

/// Heavy where closed, thin and grey where open.
fn interface_line(svg: &mut Svg, chain: &[&ContactNode<2>], feet: &[Pixel]) {
    for (closed, colour, width) in [(false, MUTED, 1.2), (true, INK, 2.4)] {
        let path: String = (1..chain.len())
            .filter(|&i| (in_contact(chain[i].status) && in_contact(chain[i - 1].status)) == closed)
            .map(|i| segments(&[feet[i - 1], feet[i]], false))
            .collect();
        svg.path(&path, colour, width, "none", "stroke-linecap=\"round\"");
    }
}

/// Weight of the places in [`length_scale`]: their differences are rounding below 10⁻¹⁴ of them.
const OF_PLACES: f64 = 1e-4;

/// The largest length whose difference is a gap; of the places themselves only a small part, as they are exact up to the last
/// digits.
pub fn length_scale<'a, const D: usize>(nodes: impl Iterator<Item = &'a ContactNode<D>>) -> f64 {
    let lengths = nodes.flat_map(|n| {
        let place = OF_PLACES * norm(n.point);
        [
            n.displacement_nonmortar,
            n.displacement_mortar,
            n.gap,
            place,
        ]
    });
    largest(lengths.map(f64::abs))
}

/// Largest gap of a contact, zero if it is only rounding; NaN if no node has a gap.
pub fn largest_gap<const D: usize>(nodes: &[ContactNode<D>]) -> f64 {
    let gap = largest(nodes.iter().map(|n| n.gap));
    without_noise(gap, length_scale(nodes.iter()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scene::WIDTH;
    use crate::output::tunnel;

    #[test]
    fn friction_adds_shear_and_slip() {
        let (model, solution) = tunnel::solved();
        let scene = Scene::new(&model);
        let contact = &solution.contacts[0];
        let stretch = Stretch::of(contact).unwrap();
        let drawn = |law: &Law, width| {
            let figure = interface_figure(&scene, contact, &stretch, law, ("a", width));
            figure.into_string()
        };
        for width in [WIDTH, PHONE] {
            let plain = drawn(&Law::Frictionless, width);
            assert!(plain.contains("Pressure [MN/m²]") && !plain.contains("Slip"));
            let with = drawn(&Law::Coulomb(0.3.into()), width);
            assert!(with.contains("Shear [MN/m²]") && with.contains("Slip ["));
        }
    }

    #[test]
    fn what_touches_in_a_small_part_is_drawn_with_its_surroundings_alone() {
        let (model, mut solution) = tunnel::solved();
        let contact = &mut solution.contacts[0];
        let labels = Labels::of(&model);
        let all = contact.nodes.len();
        let touch = |contact: &mut ContactSolution<2>, closed: &[usize]| {
            for (k, node) in contact.nodes.iter_mut().enumerate() {
                node.status = match closed.contains(&k) {
                    true => Status::Closed,
                    false => Status::Open,
                };
            }
        };
        touch(contact, &[]);
        assert!(Stretch::of(contact).is_none());
        let middle: Vec<usize> = (0..all).collect();
        touch(contact, &middle);
        let stretch = Stretch::of(contact).unwrap();
        assert_eq!((stretch.chain.len(), stretch.part), (all, false));
        assert_eq!(stretch.in_words(&labels), "");
        touch(contact, &[5, 6]);
        let stretch = Stretch::of(contact).unwrap();
        let shown: Vec<_> = stretch.chain.iter().map(|n| n.node).collect();
        let expected: Vec<_> = contact.nodes[4..8].iter().map(|n| n.node).collect();
        assert_eq!(shown, expected);
        assert!(stretch.in_words(&labels).contains("around what touches"));
        // across the first node of a closed interface it is one piece
        contact.cyclic = true;
        for (k, node) in contact.nodes.iter_mut().enumerate() {
            let (s, c) = (std::f64::consts::TAU * k as f64 / all as f64).sin_cos();
            node.point = [c, s];
        }
        touch(contact, &[0, all - 1]);
        let stretch = Stretch::of(contact).unwrap();
        assert!(stretch.part && stretch.arcs.is_sorted());
        assert!(stretch.arcs[0] < 0.0 && stretch.arcs[stretch.arcs.len() - 1] > 0.0);
        assert!(stretch.chain.len() <= 6);
    }
}
