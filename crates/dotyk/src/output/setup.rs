//! Figure "Mesh, supports and loads": the model as a textbook draws it.

use crate::geometry::{Field, Point, bounding_box, distance, dot, norm, unit};
use crate::model::{Body, Contact, Law, Load, Pair, Place, Support};
use crate::output::plot::round_down_to_125;
use crate::output::scene::{
    Margin, Scene, Station, Strand, View, WIDTH, contact_sides, mesh_lines, outline_path, polyline,
};
use crate::output::svg::{
    Anchor, INK, LOAD, MUTED, Pixel, RULE, SERIES, SUPPORT, Svg, TINTS, Type, segments, text_width,
};
use crate::output::text::{Labels, number, quantity, vector};
use std::ops::Range;

/// Longest load arrow.
const ARROW: f64 = 30.0;
/// From one support symbol to the next.
const SPACING: f64 = 30.0;
/// Room around the bodies for arrows and their values, where there are any.
const LOADED: f64 = 68.0;
/// Room around the bodies for support symbols.
const BARE: f64 = 30.0;
/// Colour of contact nodes that face nothing.
const ALONE: &str = "#b3261e";
/// Most bodies and most contacts that the legend names.
const NAMED: usize = 12;
/// Room below them for axes and scale bar.
const STRIP: f64 = 34.0;

/// The figure as an SVG element; `alone` are contact nodes that face nothing.
pub fn setup_figure(scene: &Scene, alone: &[Point<2>]) -> String {
    let labels = Labels::of(scene.model);
    let (views, height) = scene.views(margin(scene), STRIP, 0.0);
    let mut svg = Svg::new("setup", "Mesh, supports and loads", WIDTH, height);
    for view in &views {
        draw_view(&mut svg, scene, view, &labels);
        for &point in alone.iter().filter(|p| view.sees(view.pixel(**p))) {
            svg.circle(view.pixel(point), 2.6, ALONE, "white", "faces nothing");
        }
    }
    if let [whole, detail] = views.as_slice() {
        mark_detail(&mut svg, whole, detail);
    }
    let bottom = legend(&mut svg, scene, &labels, !alone.is_empty(), height + 6.0);
    svg.set_height(bottom);
    svg.finish()
}

/// Room where arrows stand outside the bodies.
fn margin(scene: &Scene) -> Margin {
    let (low, high) = scene.bounds;
    let near = 0.12 * (high[0] - low[0]).max(high[1] - low[1]);
    let mut margin = Margin::all(BARE);
    let mut mark = |point: Point<2>, outward: Point<2>| {
        let sides = [
            (&mut margin.left, point[0] - low[0], -outward[0]),
            (&mut margin.right, high[0] - point[0], outward[0]),
            (&mut margin.bottom, point[1] - low[1], -outward[1]),
            (&mut margin.top, high[1] - point[1], outward[1]),
        ];
        for (room, distance, along) in sides {
            if distance < near && along > 0.3 {
                *room = LOADED;
            }
        }
    };
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let points = body.mesh.points();
        for load in &body.loads {
            match load {
                Load::Traction { side, .. } | Load::Pressure { side, .. } => {
                    for strand in scene.body_side(i, side) {
                        let stations = strand.stations(points, 24, true);
                        stations.iter().for_each(|s| mark(s.point, s.normal));
                    }
                }
                Load::Force { point, force } => {
                    let force: Point<2> =
                        [0, 1].map(|k| force[k].at(*point, scene.model.last_time()));
                    if let Some(along) = unit(force) {
                        mark(*point, along.map(|c| -c));
                    }
                }
            }
        }
    }
    margin
}

fn draw_view(svg: &mut Svg, scene: &Scene, view: &View, labels: &Labels) {
    svg.begin_clip(view.corner, view.size);
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let place = |n: usize| view.pixel(body.mesh.points()[n]);
        let outline = outline_path(&scene.outlines[i], &place);
        svg.path(
            &outline,
            "none",
            0.0,
            TINTS[i % TINTS.len()],
            "fill-rule=\"evenodd\"",
        );
        svg.path(
            &mesh_lines(&body.mesh, view, &place),
            "#7c8894",
            0.4,
            "none",
            "",
        );
        svg.path(&outline, INK, 0.9, "none", "stroke-linejoin=\"round\"");
    }
    for (i, contact) in scene.model.contacts.iter().enumerate() {
        contact_line(svg, scene, view, contact, SERIES[i % SERIES.len()]);
    }
    if labels.axes[0] == "r" {
        let x = view.pixel([0.0, 0.0])[0];
        let line = [[x, view.corner[1]], [x, view.corner[1] + view.size[1]]];
        svg.path(
            &polyline(&line),
            MUTED,
            0.8,
            "none",
            "stroke-dasharray=\"12 3 2 3\"",
        );
    }
    for (i, body) in scene.model.bodies.iter().enumerate() {
        for load in &body.loads {
            draw_load(svg, scene, view, i, load, labels);
        }
    }
    for (i, body) in scene.model.bodies.iter().enumerate() {
        for support in &body.supports {
            draw_support(svg, scene, view, i, support, labels);
        }
    }
    svg.end_clip();
    scale_bar(svg, view, labels);
}

/// Frame around the detail, and where it is in the whole.
pub fn mark_detail(svg: &mut Svg, whole: &View, detail: &View) {
    let (a, b) = (
        whole.pixel([detail.low[0], detail.high[1]]),
        whole.pixel([detail.high[0], detail.low[1]]),
    );
    let path = segments(&[a, [b[0], a[1]], b, [a[0], b[1]]], true);
    svg.path(&path, INK, 0.8, "none", "stroke-dasharray=\"3 2\"");
    let label = Type {
        size: 10.5,
        ..Type::LABEL
    }
    .coloured(MUTED)
    .rimmed();
    svg.text(
        [b[0] + 4.0, a[1] + 9.0],
        "detail",
        label.anchored(Anchor::Start),
    );
    let path = segments(
        &[
            detail.corner,
            [detail.corner[0] + detail.size[0], detail.corner[1]],
            [
                detail.corner[0] + detail.size[0],
                detail.corner[1] + detail.size[1],
            ],
            [detail.corner[0], detail.corner[1] + detail.size[1]],
        ],
        true,
    );
    svg.path(&path, MUTED, 0.8, "none", "stroke-dasharray=\"3 2\"");
}

/// Both sides of a contact, heavy; a rigid obstacle as a hatched line.
fn contact_line(svg: &mut Svg, scene: &Scene, view: &View, contact: &Contact<2>, colour: &str) {
    for side in contact_sides(&contact.pair) {
        let points = scene.model.bodies[side.body.0].mesh.points();
        for strand in scene.side(side) {
            let path = strand.path(&|n| view.pixel(points[n]));
            svg.path(&path, colour, 2.4, "none", "stroke-linecap=\"round\"");
        }
    }
    if let Pair::Obstacle {
        nonmortar,
        obstacle,
    } = &contact.pair
    {
        let points = scene.model.bodies[nonmortar.body.0].mesh.points();
        for strand in scene.side(nonmortar) {
            let surface: Vec<(Pixel, Pixel)> = strand
                .stations(points, 60, false)
                .iter()
                .map(|s| {
                    let point = obstacle
                        .shape
                        .drawn(s.point, s.normal, scene.model.last_time());
                    (view.pixel(point), [s.normal[0], -s.normal[1]])
                })
                .collect();
            let line: Vec<Pixel> = surface.iter().map(|s| s.0).collect();
            svg.path(&polyline(&line), INK, 1.6, "none", "");
            hatch(svg, &surface, INK);
        }
    }
}

/// Short slanted strokes behind a line; `surface` holds points and outward directions.
fn hatch(svg: &mut Svg, surface: &[(Pixel, Pixel)], colour: &str) {
    let strokes: String = surface
        .iter()
        .filter(|(p, _)| p[0].is_finite() && p[1].is_finite())
        .map(|(p, n)| {
            let t = [-n[1], n[0]];
            let end = [0, 1].map(|i| p[i] + 6.0 * n[i] + 4.0 * t[i]);
            segments(&[*p, end], false)
        })
        .collect();
    svg.path(&strokes, colour, 0.8, "none", "");
}

/// What a support takes away.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hold {
    /// One component, along this axis.
    Axis(usize),
    /// The normal component.
    Normal,
    /// Everything.
    Clamp,
}

fn hold(support: &Support<2>) -> Option<Hold> {
    match (&support.normal, &support.components) {
        (_, [Some(_), Some(_)]) => Some(Hold::Clamp),
        (Some(_), [None, None]) => Some(Hold::Normal),
        (Some(_), _) => Some(Hold::Clamp),
        (None, [Some(_), None]) => Some(Hold::Axis(0)),
        (None, [None, Some(_)]) => Some(Hold::Axis(1)),
        (None, [None, None]) => None,
    }
}

fn draw_support(
    svg: &mut Svg,
    scene: &Scene,
    view: &View,
    body: usize,
    support: &Support<2>,
    labels: &Labels,
) {
    let Some(hold) = hold(support) else { return };
    let mesh = &scene.model.bodies[body].mesh;
    match &support.place {
        Place::Point(target) => {
            let Some(&point) = nearest(mesh.points(), *target) else {
                return;
            };
            let center = middle_of(mesh.points());
            let outward = |axis: usize| {
                let mut d = [0.0, 0.0];
                // Below the body unless the point is clearly in its upper part, and to the left likewise.
                d[axis] = if point[axis] > center[axis] {
                    1.0
                } else {
                    -1.0
                };
                d
            };
            let at = view.pixel(point);
            svg.circle(at, 2.6, "none", SUPPORT, "");
            match hold {
                Hold::Axis(axis) => roller(svg, at, on_paper(outward(axis))),
                Hold::Normal | Hold::Clamp => pin(svg, at, on_paper(outward(1))),
            }
        }
        Place::Side(side) => {
            for strand in scene.body_side(body, side) {
                if hidden(scene, view, &strand, mesh.points(), SPACING) {
                    continue;
                }
                side_support(svg, view, &strand, mesh.points(), hold);
                prescribed(
                    svg,
                    view,
                    &strand,
                    mesh.points(),
                    support,
                    scene.model.last_time(),
                    labels,
                );
            }
        }
    }
}

fn side_support(svg: &mut Svg, view: &View, strand: &Strand, points: &[Point<2>], hold: Hold) {
    let length = strand.length(points) * view.scale;
    if hold == Hold::Clamp {
        svg.path(
            &strand.path(&|n| view.pixel(points[n])),
            SUPPORT,
            2.0,
            "none",
            "",
        );
        let parts = ((length / 6.0) as usize).clamp(2, 4000);
        let surface: Vec<(Pixel, Pixel)> = strand
            .stations(points, parts, false)
            .iter()
            .map(|s| (view.pixel(s.point), on_paper(s.normal)))
            .filter(|(p, _)| view.sees(*p))
            .collect();
        hatch(svg, &surface, SUPPORT);
        return;
    }
    let parts = ((length / SPACING).round() as usize).clamp(1, 4000);
    for station in strand.stations(points, parts, true) {
        let at = view.pixel(station.point);
        // Half a symbol at the edge of the window would say nothing.
        let whole = [-7.0, 7.0]
            .iter()
            .all(|step| view.sees([at[0], at[1] + step]));
        if !(view.sees(at) && whole) {
            continue;
        }
        match hold {
            Hold::Axis(axis) => {
                let mut d = [0.0, 0.0];
                d[axis] = if station.normal[axis] < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                // Along the side itself: beside it, so that it does not hide in the outline.
                let beside = if station.normal[axis].abs() < 0.3 {
                    5.0
                } else {
                    0.0
                };
                let n = on_paper(station.normal);
                roller(
                    svg,
                    [at[0] + beside * n[0], at[1] + beside * n[1]],
                    on_paper(d),
                );
            }
            _ => roller(svg, at, on_paper(station.normal)),
        }
    }
}

/// Arrow and value of a prescribed displacement that is not zero.
fn prescribed(
    svg: &mut Svg,
    view: &View,
    strand: &Strand,
    points: &[Point<2>],
    support: &Support<2>,
    time: f64,
    labels: &Labels,
) {
    let Some(station) = strand.stations(points, 1, true).first().copied() else {
        return;
    };
    let value = |field: &Option<Field>| field.as_ref().map_or(0.0, |f| f.at(station.point, time));
    let along = value(&support.normal);
    let u: Point<2> = [0, 1].map(|i| value(&support.components[i]) + along * station.normal[i]);
    let Some(direction) = unit(u) else { return };
    let n = on_paper(station.normal);
    let d = on_paper(direction);
    let base = view.pixel(station.point);
    let tail = [0, 1].map(|i| base[i] + 20.0 * n[i]);
    let tip = [0, 1].map(|i| tail[i] + 22.0 * d[i]);
    svg.arrow(tail, tip, SUPPORT, 2.0);
    let text = format!("u = {}", quantity(norm(u), &labels.length));
    // Clear of the arrow on its outer side.
    let level = n[0].abs() > n[1].abs();
    let away = if level {
        26.0 + 0.5 * text_width(&text, Type::LABEL.size)
    } else {
        52.0
    };
    beside(
        svg,
        view,
        [0, 1].map(|i| base[i] + away * n[i]),
        &text,
        SUPPORT,
        false,
    );
}

/// A triangle on wheels whose tip supports the body at `at`; `d` points away from the body.
fn roller(svg: &mut Svg, at: Pixel, d: Pixel) {
    let go = frame(at, d);
    triangle(svg, &go);
    for side in [-2.6, 2.6] {
        svg.circle(go(9.6, side), 1.7, SUPPORT, "#fff", "");
    }
    svg.line(go(12.0, -6.5), go(12.0, 6.5), SUPPORT, 1.2);
}

/// A triangle on hatched ground.
fn pin(svg: &mut Svg, at: Pixel, d: Pixel) {
    let go = frame(at, d);
    triangle(svg, &go);
    svg.line(go(8.0, -7.5), go(8.0, 7.5), SUPPORT, 1.2);
    for side in [-6.0, -2.0, 2.0, 6.0] {
        svg.line(go(8.0, side), go(12.0, side - 3.0), SUPPORT, 0.8);
    }
}

fn triangle(svg: &mut Svg, go: &dyn Fn(f64, f64) -> Pixel) {
    let path = segments(&[go(0.0, 0.0), go(8.0, -4.6), go(8.0, 4.6)], true);
    svg.path(&path, SUPPORT, 1.0, "#fff", "stroke-linejoin=\"round\"");
}

/// (outward, sideways) ↦ pixel.
fn frame(at: Pixel, d: Pixel) -> impl Fn(f64, f64) -> Pixel {
    move |out, aside| {
        [
            at[0] + out * d[0] - aside * d[1],
            at[1] + out * d[1] + aside * d[0],
        ]
    }
}

fn draw_load(
    svg: &mut Svg,
    scene: &Scene,
    view: &View,
    body: usize,
    load: &Load<2>,
    labels: &Labels,
) {
    let time = scene.model.last_time();
    let mesh = &scene.model.bodies[body].mesh;
    match load {
        Load::Traction { side, traction } => {
            let at = |s: &Station| [0, 1].map(|i| traction[i].at(s.point, time));
            draw_fence(svg, scene, view, body, side, &at, labels);
        }
        Load::Pressure { side, pressure } => {
            let at = |s: &Station| s.normal.map(|n| -n * pressure.at(s.point, time));
            draw_fence(svg, scene, view, body, side, &at, labels);
        }
        Load::Force { point, force } => {
            let Some(&node) = nearest(mesh.points(), *point) else {
                return;
            };
            let force: Point<2> = [0, 1].map(|i| force[i].at(node, time));
            let (tip, Some(direction)) = (view.pixel(node), unit(force)) else {
                return;
            };
            if !view.sees(tip) {
                return;
            }
            let d = on_paper(direction);
            let tail = [0, 1].map(|i| tip[i] - (ARROW + 6.0) * d[i]);
            svg.arrow(tail, tip, LOAD, 2.0);
            let at = [0, 1].map(|i| tail[i] - 9.0 * d[i]);
            beside(
                svg,
                view,
                at,
                &quantity(norm(force), &labels.force),
                LOAD,
                d[0].abs() > d[1].abs(),
            );
        }
    }
}

/// Arrows of a distributed load along a side, a line along their outer ends, and the value.
fn draw_fence(
    svg: &mut Svg,
    scene: &Scene,
    view: &View,
    body: usize,
    side: &str,
    traction: &dyn Fn(&Station) -> Point<2>,
    labels: &Labels,
) {
    let points = scene.model.bodies[body].mesh.points();
    let held = scene.model.bodies[body]
        .supports
        .iter()
        .any(|s| s.place == Place::Side(side.to_string()));
    let fences: Vec<(Strand, Vec<Station>, Vec<Point<2>>)> = scene
        .body_side(body, side)
        .into_iter()
        .map(|strand| {
            let pixels = strand.length(points) * view.scale;
            let parts = ((pixels / 15.0).round() as usize).clamp(1, 2000);
            let stations = strand.stations(points, parts, false);
            let values = stations.iter().map(traction).collect();
            (strand, stations, values)
        })
        .collect();
    let sizes = || {
        fences
            .iter()
            .flat_map(|f| &f.2)
            .map(|&t| norm(t))
            .filter(|s| s.is_finite())
    };
    let (low, high) = sizes().fold((f64::INFINITY, 0.0f64), |(l, h), s| (l.min(s), h.max(s)));
    if high == 0.0 {
        return;
    }
    let text = if high - low <= 1e-9 * high {
        quantity(high, &labels.stress)
    } else {
        format!("{} … {}", number(low), quantity(high, &labels.stress))
    };
    for (strand, stations, values) in &fences {
        if hidden(scene, view, strand, points, 40.0) {
            continue;
        }
        let lift = if held { 16.0 } else { 2.0 };
        let mut outer = Vec::new();
        for (station, &t) in stations.iter().zip(values) {
            let n = on_paper(station.normal);
            let base = view.pixel(station.point);
            let base = [0, 1].map(|i| base[i] + lift * n[i]);
            let size = ARROW * norm(t) / high;
            let d = on_paper(unit(t).unwrap_or([0.0, 0.0]));
            let (tail, tip) = match dot(d, n) {
                c if c < -0.2 => ([0, 1].map(|i| base[i] - size * d[i]), base),
                c if c > 0.2 => (base, [0, 1].map(|i| base[i] + size * d[i])),
                // Along the side: beside it.
                _ => {
                    let base = [0, 1].map(|i| base[i] + 6.0 * n[i]);
                    let step = size.min(12.0);
                    (base, [0, 1].map(|i| base[i] + step * d[i]))
                }
            };
            if !view.sees(view.pixel(station.point)) {
                outer.push([f64::NAN; 2]);
                continue;
            }
            if size > 2.0 {
                svg.arrow(tail, tip, LOAD, 1.1);
            }
            outer.push(if dot(d, n) < 0.0 { tail } else { tip });
        }
        let runs = runs(stations, &outer);
        for run in &runs {
            svg.path(
                &polyline(&outer[run.clone()]),
                LOAD,
                0.9,
                "none",
                "stroke-linejoin=\"round\"",
            );
        }
        if let Some(run) = runs.into_iter().max_by_key(std::ops::Range::len) {
            label_fence(svg, view, &stations[run.clone()], &outer[run], &text);
        }
    }
}

/// Pieces of a fence in sight and without a corner.
fn runs(stations: &[Station], outer: &[Pixel]) -> Vec<Range<usize>> {
    let mut list: Vec<Range<usize>> = Vec::new();
    for i in (0..outer.len()).filter(|&i| outer[i][0].is_finite()) {
        match list.last_mut() {
            Some(run) if run.end == i && dot(stations[i - 1].normal, stations[i].normal) > 0.8 => {
                run.end = i + 1
            }
            _ => list.push(i..i + 1),
        }
    }
    list
}

/// The value beside the middle of a piece of the fence, clear of its highest arrow.
fn label_fence(svg: &mut Svg, view: &View, stations: &[Station], outer: &[Pixel], text: &str) {
    let middle = outer.len() / 2;
    let n = on_paper(stations[middle].normal);
    let base = view.pixel(stations[middle].point);
    let reach = outer
        .iter()
        .map(|p| dot([p[0] - base[0], p[1] - base[1]], n))
        .fold(0.0, f64::max);
    let upright = n[0].abs() > n[1].abs();
    let at = [0, 1].map(|k| base[k] + (reach + 10.0) * n[k]);
    beside(svg, view, at, text, LOAD, upright);
}

/// A label kept inside the window; `upright` turns it by a quarter.
fn beside(svg: &mut Svg, view: &View, at: Pixel, text: &str, colour: &'static str, upright: bool) {
    if !view.sees(at) && view.detail {
        return;
    }
    let style = Type::LABEL.coloured(colour).rimmed();
    let half = 0.5 * text_width(text, style.size) + 2.0;
    let keep = |value: f64, axis: usize, room: f64| {
        let (low, high) = (
            view.corner[axis] + room,
            view.corner[axis] + view.size[axis] - room,
        );
        if low <= high {
            value.clamp(low, high)
        } else {
            0.5 * (low + high)
        }
    };
    if upright {
        let (x, y) = (keep(at[0], 0, 9.0), keep(at[1], 1, half));
        svg.turned_text([x + 4.0, y], text, style, -90.0);
    } else {
        let (x, y) = (keep(at[0], 0, half), keep(at[1], 1, 9.0));
        svg.text([x, y + 4.0], text, style);
    }
}

/// A side so small in the whole that its symbols are drawn in the detail only.
fn hidden(scene: &Scene, view: &View, strand: &Strand, points: &[Point<2>], least: f64) -> bool {
    let ends: Vec<Point<2>> = strand
        .links
        .iter()
        .flat_map(|l| l.ends)
        .map(|n| points[n])
        .collect();
    let (low, high) = bounding_box(&ends);
    let size = (high[0] - low[0]).max(high[1] - low[1]) * view.scale;
    let in_detail = scene
        .detail
        .is_some_and(|(a, b)| (0..2).all(|i| low[i] >= a[i] && high[i] <= b[i]));
    !view.detail && in_detail && size < least
}

/// Axes at the lower left, and a bar of round length.
pub fn scale_bar(svg: &mut Svg, view: &View, labels: &Labels) {
    let y = view.corner[1] + view.size[1] + STRIP - 14.0;
    let left = view.corner[0] + 8.0;
    let small = Type {
        size: 10.5,
        ..Type::LABEL
    }
    .coloured(MUTED);
    let mut start = left;
    if !view.detail {
        let origin = [left + 2.0, y + 4.0];
        svg.arrow(origin, [origin[0] + 24.0, origin[1]], MUTED, 1.0);
        svg.arrow(origin, [origin[0], origin[1] - 24.0], MUTED, 1.0);
        svg.text([origin[0] + 30.0, origin[1] + 3.0], labels.axes[0], small);
        svg.text([origin[0] + 7.0, origin[1] - 19.0], labels.axes[1], small);
        start = left + 50.0;
    }
    let most = (0.3 * view.size[0]).min(140.0);
    let length = round_down_to_125(most / view.scale);
    let end = start + length * view.scale;
    let path = segments(
        &[
            [start, y - 3.0],
            [start, y + 3.0],
            [start, y],
            [end, y],
            [end, y - 3.0],
            [end, y + 3.0],
        ],
        false,
    );
    svg.path(&path, INK, 1.1, "none", "");
    svg.text(
        [end + 6.0, y + 3.8],
        &quantity(length, &labels.length),
        small.anchored(Anchor::Start),
    );
}

/// Names of tints, lines and symbols; returns the lower end.
fn legend(svg: &mut Svg, scene: &Scene, labels: &Labels, alone: bool, top: f64) -> f64 {
    svg.line([0.0, top], [WIDTH, top], RULE, 1.0);
    let mut flow = Flow {
        x: 4.0,
        y: top + 20.0,
    };
    let more = |svg: &mut Svg, flow: &mut Flow, count: usize, what: &str| {
        if count > NAMED {
            let text = format!("and {} more {what}", count - NAMED);
            let at = flow.next(&text);
            let start = Type::LABEL.coloured(MUTED).anchored(Anchor::Start);
            svg.text([at[0] + 22.0, at[1]], &text, start);
        }
    };
    for (i, body) in scene.model.bodies.iter().enumerate().take(NAMED) {
        let text = body_text(body, labels);
        let at = flow.next(&text);
        svg.rectangle(
            [at[0], at[1] - 9.0],
            [16.0, 10.0],
            INK,
            TINTS[i % TINTS.len()],
        );
        svg.text(
            [at[0] + 22.0, at[1]],
            &text,
            Type::LABEL.anchored(Anchor::Start),
        );
    }
    more(svg, &mut flow, scene.model.bodies.len(), "bodies");
    for (i, contact) in scene.model.contacts.iter().enumerate().take(NAMED) {
        let law = match &contact.law {
            Law::Frictionless => "frictionless".to_string(),
            Law::Coulomb(f) => format!("Coulomb friction {f}"),
            Law::Tresca(f) => format!("Tresca friction {f}"),
            Law::Tied => "tied".to_string(),
        };
        let text = format!("contact {} ({law})", contact.name);
        let at = flow.next(&text);
        let colour = SERIES[i % SERIES.len()];
        svg.line(
            [at[0], at[1] - 4.0],
            [at[0] + 16.0, at[1] - 4.0],
            colour,
            2.6,
        );
        svg.text(
            [at[0] + 22.0, at[1]],
            &text,
            Type::LABEL.anchored(Anchor::Start),
        );
    }
    more(svg, &mut flow, scene.model.contacts.len(), "contacts");
    if alone {
        let text = "contact node that faces nothing";
        let at = flow.next(text);
        svg.circle([at[0] + 8.0, at[1] - 4.0], 2.6, ALONE, "white", "");
        let start = Type::LABEL.anchored(Anchor::Start);
        svg.text([at[0] + 22.0, at[1]], text, start);
    }
    symbols(svg, scene, &mut flow);
    flow.y + 12.0
}

/// Support symbols and loads that occur, in words.
fn symbols(svg: &mut Svg, scene: &Scene, flow: &mut Flow) {
    let supports = || scene.model.bodies.iter().flat_map(|b| &b.supports);
    let rolling = |s: &Support<2>| matches!(hold(s), Some(Hold::Axis(_) | Hold::Normal));
    let clamped = |s: &Support<2>| hold(s) == Some(Hold::Clamp);
    let start = Type::LABEL.anchored(Anchor::Start);
    if supports().any(rolling) {
        let text = "one displacement held";
        let at = flow.next(text);
        roller(svg, [at[0] + 8.0, at[1] - 11.0], [0.0, 1.0]);
        svg.text([at[0] + 22.0, at[1]], text, start);
    }
    if supports().any(clamped) {
        let text = "both displacements held";
        let at = flow.next(text);
        svg.line(
            [at[0], at[1] - 8.0],
            [at[0] + 16.0, at[1] - 8.0],
            SUPPORT,
            2.0,
        );
        let ground: Vec<(Pixel, Pixel)> = (0..4)
            .map(|k| ([at[0] + 3.0 + 4.5 * f64::from(k), at[1] - 8.0], [0.0, 1.0]))
            .collect();
        hatch(svg, &ground, SUPPORT);
        svg.text([at[0] + 22.0, at[1]], text, start);
    }
    if scene.model.bodies.iter().any(|b| !b.loads.is_empty()) {
        let text = "load on the undeformed surface";
        let at = flow.next(text);
        svg.arrow([at[0], at[1] - 4.0], [at[0] + 17.0, at[1] - 4.0], LOAD, 1.1);
        svg.text([at[0] + 22.0, at[1]], text, start);
    }
}

/// Name, stiffness and body force.
fn body_text(body: &Body<2>, labels: &Labels) -> String {
    let mut text = body.name.clone();
    if let [material] = body.materials.as_slice() {
        let elastic = material.elastic;
        text += &format!(
            " (E = {}, ν = {})",
            quantity(elastic.young, &labels.stress),
            number(elastic.poisson)
        );
    }
    if body.body_force.iter().any(|f| f.as_constant() != Some(0.0)) {
        let constant: Option<Vec<f64>> = body.body_force.iter().map(Field::as_constant).collect();
        text += &match constant {
            Some(values) => format!(", body force {}", vector(&values, &labels.density)),
            None => format!(
                ", body force ({}, {})",
                body.body_force[0], body.body_force[1]
            ),
        };
    }
    text
}

/// Places entries in rows.
struct Flow {
    x: f64,
    y: f64,
}

impl Flow {
    /// Place of the next entry: a symbol of 16 px and its text.
    fn next(&mut self, text: &str) -> Pixel {
        let width = 22.0 + text_width(text, Type::LABEL.size) + 20.0;
        if self.x > 4.0 && self.x + width > WIDTH {
            (self.x, self.y) = (4.0, self.y + 20.0);
        }
        let at = [self.x, self.y];
        self.x += width;
        at
    }
}

/// A direction of the world on paper, where y points down.
fn on_paper(d: Point<2>) -> Pixel {
    [d[0], -d[1]]
}

fn nearest(points: &[Point<2>], target: Point<2>) -> Option<&Point<2>> {
    points
        .iter()
        .min_by(|a, b| distance(**a, target).total_cmp(&distance(**b, target)))
}

fn middle_of(points: &[Point<2>]) -> Point<2> {
    let (low, high) = bounding_box(points);
    [0, 1].map(|i| 0.5 * (low[i] + high[i]))
}
