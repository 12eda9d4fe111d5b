//! Symbols of supports and loads, drawn along the sides of bodies.

use crate::geometry::{Field, Point, bounding_box, dot, norm, unit};
use crate::model::{Amount, Bed, Load, Place, Spring, Support};
use crate::output::scene::{Mark, Scene, Strand, polyline};
use crate::output::svg::{LOAD, Pixel, SUPPORT, Svg, Type, segments, text_width};
use crate::output::text::{Labels, number, quantity};
use crate::output::view::{View, beside, on_paper};
use std::ops::Range;

/// Longest load arrow.
const ARROW: f64 = 30.0;

/// From one support symbol to the next.
const SPACING: f64 = 30.0;

/// The motions that a support holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hold {
    /// One component, along this axis.
    Axis(usize),
    /// The normal component.
    Normal,
    /// Everything.
    Clamp,
}

/// The motions that a support holds; `None` without a component.
pub fn hold(support: &Support<2>) -> Option<Hold> {
    match (&support.normal, &support.components) {
        (_, [Some(_), Some(_)]) => Some(Hold::Clamp),
        (Some(_), [None, None]) => Some(Hold::Normal),
        (Some(_), _) => Some(Hold::Clamp),
        (None, [Some(_), None]) => Some(Hold::Axis(0)),
        (None, [None, Some(_)]) => Some(Hold::Axis(1)),
        (None, [None, None]) => None,
    }
}

/// The symbols of a support.
pub fn draw_support(
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
            let point = mesh.points()[mesh.nearest_node(*target)];
            draw_hold(
                svg,
                view.pixel(point),
                hold,
                (point, middle_of(mesh.bounds())),
            );
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

/// The symbol of a support of a point, on the outer side as seen from a centre.
pub fn draw_hold(svg: &mut Svg, at: Pixel, hold: Hold, (point, center): (Point<2>, Point<2>)) {
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
    svg.circle(at, 2.6, "none", SUPPORT, "");
    match hold {
        Hold::Axis(axis) => roller(svg, at, on_paper(outward(axis))),
        Hold::Normal | Hold::Clamp => pin(svg, at, on_paper(outward(1))),
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
            .marks(points, parts, false)
            .iter()
            .map(|s| (view.pixel(s.point), on_paper(s.normal)))
            .filter(|(p, _)| view.sees(*p))
            .collect();
        hatch(svg, &surface, SUPPORT);
        return;
    }
    let parts = ((length / SPACING).round() as usize).clamp(1, 4000);
    for mark in strand.marks(points, parts, true) {
        let at = view.pixel(mark.point);
        // Half a symbol at the edge of the window would be useless.
        let whole = [-7.0, 7.0]
            .iter()
            .all(|step| view.sees([at[0], at[1] + step]));
        if !(view.sees(at) && whole) {
            continue;
        }
        match hold {
            Hold::Axis(axis) => {
                let mut d = [0.0, 0.0];
                d[axis] = if mark.normal[axis] < 0.0 { -1.0 } else { 1.0 };
                // Along the side itself: beside it, so that it does not hide in the outline.
                let beside = if mark.normal[axis].abs() < 0.3 {
                    5.0
                } else {
                    0.0
                };
                let n = on_paper(mark.normal);
                roller(
                    svg,
                    [at[0] + beside * n[0], at[1] + beside * n[1]],
                    on_paper(d),
                );
            }
            _ => roller(svg, at, on_paper(mark.normal)),
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
    let Some(mark) = strand.marks(points, 1, true).first().copied() else {
        return;
    };
    let value = |field: &Option<Field>| field.as_ref().map_or(0.0, |f| f.at(mark.point, time));
    let along = value(&support.normal);
    let u: Point<2> = [0, 1].map(|i| value(&support.components[i]) + along * mark.normal[i]);
    let Some(direction) = unit(u) else { return };
    let n = on_paper(mark.normal);
    let d = on_paper(direction);
    let base = view.pixel(mark.point);
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
pub fn roller(svg: &mut Svg, at: Pixel, d: Pixel) {
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

/// Short slanted strokes behind a line; `surface` holds points and outward directions.
pub fn hatch(svg: &mut Svg, surface: &[(Pixel, Pixel)], colour: &str) {
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

/// The arrows of a load.
pub fn draw_load(
    svg: &mut Svg,
    scene: &Scene,
    view: &View,
    body: usize,
    load: &Load<2>,
    labels: &Labels,
) {
    let time = scene.model.last_time();
    let mesh = &scene.model.bodies[body].mesh;
    match load.place() {
        Place::Side(side) => {
            let traction = |marks: &[Mark]| {
                let places = marks.iter().map(|mark| (mark.point, mark.normal));
                load.values(&places.collect::<Vec<_>>(), time)
            };
            let unit = match load.amount() {
                Amount::PerArea => &labels.stress,
                Amount::Whole => &labels.force,
            };
            draw_fence(svg, scene, view, body, &side, &traction, unit);
        }
        Place::Point(point) => {
            let node = mesh.points()[mesh.nearest_node(point)];
            let force = load.at(node, [0.0; 2], time);
            draw_force(svg, view, view.pixel(node), force, labels);
        }
    }
}

/// The arrow of a force at a point in sight, with its value.
pub fn draw_force(svg: &mut Svg, view: &View, tip: Pixel, force: Point<2>, labels: &Labels) {
    let Some(direction) = unit(force).filter(|_| view.sees(tip)) else {
        return;
    };
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

/// Arrows of a distributed load along a side, a line along their outer ends, and the value.
fn draw_fence(
    svg: &mut Svg,
    scene: &Scene,
    view: &View,
    body: usize,
    side: &str,
    traction: &dyn Fn(&[Mark]) -> Vec<Point<2>>,
    units: &str,
) {
    let points = scene.model.bodies[body].mesh.points();
    let held = scene.model.bodies[body]
        .supports
        .iter()
        .any(|s| s.place == Place::Side(side.to_string()));
    let fences: Vec<(Strand, Vec<Mark>, Vec<Point<2>>)> = scene
        .body_side(body, side)
        .into_iter()
        .map(|strand| {
            let pixels = strand.length(points) * view.scale;
            let parts = ((pixels / 15.0).round() as usize).clamp(1, 2000);
            let marks = strand.marks(points, parts, false);
            let values = traction(&marks);
            (strand, marks, values)
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
        quantity(high, units)
    } else {
        format!("{} … {}", number(low), quantity(high, units))
    };
    for (strand, marks, values) in &fences {
        if hidden(scene, view, strand, points, 40.0) {
            continue;
        }
        let lift = if held { 16.0 } else { 2.0 };
        let mut outer = Vec::new();
        for (mark, &t) in marks.iter().zip(values) {
            let n = on_paper(mark.normal);
            let base = view.pixel(mark.point);
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
            if !view.sees(view.pixel(mark.point)) {
                outer.push([f64::NAN; 2]);
                continue;
            }
            if size > 2.0 {
                svg.arrow(tail, tip, LOAD, 1.1);
            }
            outer.push(if dot(d, n) < 0.0 { tail } else { tip });
        }
        let runs = runs(marks, &outer);
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
            label_fence(svg, view, &marks[run.clone()], &outer[run], &text);
        }
    }
}

/// Pieces of a fence in sight and without a corner.
fn runs(marks: &[Mark], outer: &[Pixel]) -> Vec<Range<usize>> {
    let mut list: Vec<Range<usize>> = Vec::new();
    for i in (0..outer.len()).filter(|&i| outer[i][0].is_finite()) {
        match list.last_mut() {
            Some(run) if run.end == i && dot(marks[i - 1].normal, marks[i].normal) > 0.8 => {
                run.end = i + 1
            }
            _ => list.push(i..i + 1),
        }
    }
    list
}

/// The value beside the middle of a piece of the fence, clear of its highest arrow.
fn label_fence(svg: &mut Svg, view: &View, marks: &[Mark], outer: &[Pixel], text: &str) {
    let middle = outer.len() / 2;
    let n = on_paper(marks[middle].normal);
    let base = view.pixel(marks[middle].point);
    let reach = outer
        .iter()
        .map(|p| dot([p[0] - base[0], p[1] - base[1]], n))
        .fold(0.0, f64::max);
    let upright = n[0].abs() > n[1].abs();
    let at = [0, 1].map(|k| base[k] + (reach + 10.0) * n[k]);
    beside(svg, view, at, text, LOAD, upright);
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

/// Distance between the springs of a side on paper.
const SPRINGS_APART: f64 = 34.0;

/// The symbols of a spring: all along a side, or at a point along the axes that it holds.
pub fn draw_spring(svg: &mut Svg, scene: &Scene, view: &View, body: usize, spring: &Spring<2>) {
    let mesh = &scene.model.bodies[body].mesh;
    let points = mesh.points();
    match &spring.bed {
        Bed::Side { side, .. } => {
            for strand in scene.body_side(body, side) {
                if hidden(scene, view, &strand, points, 40.0) {
                    continue;
                }
                let parts = (strand.length(points) * view.scale / SPRINGS_APART).round() as usize;
                for mark in strand.marks(points, parts.clamp(1, 400), true) {
                    let at = view.pixel(mark.point);
                    if view.sees(at) {
                        zigzag(svg, at, on_paper(mark.normal));
                    }
                }
            }
        }
        Bed::Point { point, stiffness } => {
            let node = points[mesh.nearest_node(*point)];
            // away from the body
            let centre = middle_of(mesh.bounds());
            for axis in (0..2).filter(|&axis| stiffness[axis] > 0.0) {
                let away = if node[axis] < centre[axis] { -1.0 } else { 1.0 };
                let direction: Point<2> =
                    std::array::from_fn(|i| if i == axis { away } else { 0.0 });
                zigzag(svg, view.pixel(node), on_paper(direction));
            }
        }
    }
}

/// A spring from a point in a direction, on the ground.
pub fn zigzag(svg: &mut Svg, at: Pixel, d: Pixel) {
    let place = |along: f64, across: f64| -> Pixel {
        [
            at[0] + along * d[0] - across * d[1],
            at[1] + along * d[1] + across * d[0],
        ]
    };
    let turns = [
        (0.0, 0.0),
        (2.0, 0.0),
        (3.5, 3.0),
        (6.0, -3.0),
        (8.5, 3.0),
        (10.0, 0.0),
        (12.0, 0.0),
    ];
    let path: Vec<Pixel> = turns.iter().map(|&(s, q)| place(s, q)).collect();
    svg.path(
        &polyline(&path),
        SUPPORT,
        1.1,
        "none",
        "stroke-linejoin=\"round\"",
    );
    svg.line(place(12.0, -4.5), place(12.0, 4.5), SUPPORT, 1.6);
}

fn middle_of([low, high]: [Point<2>; 2]) -> Point<2> {
    [0, 1].map(|i| 0.5 * (low[i] + high[i]))
}
