//! Picture "Mesh, supports and loads" of a model in space, from two sides.

use crate::geometry::{Point, norm, unit};
use crate::model::{Amount, Couple, Load, Pair, Place};
use crate::output::html;
use crate::output::scene::WIDTH;
use crate::output::setup::{Flow, NAMED, body_text};
use crate::output::space::camera::Window;
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::marks::{Labelled, Mark, force, held, hold, push, seen};
use crate::output::space::scene::{GHOST, HEAVY, Scene, THIN, contact_sides, triad_and_scale};
use crate::output::space::skin::{Look, Skin};
use crate::output::svg::{
    ALARM, Anchor, INK, LOAD, MUTED, Pixel, RULE, SERIES, SUPPORT, Svg, TINTS, Type, segments,
};
use crate::output::symbols::nearest;
use crate::output::text::{Labels, count, number, quantity};

/// Room around the bodies for arrows and their values.
const MARGIN: f64 = 46.0;

/// Most lines from the point of a couple to its side.
const LINES: usize = 12;

/// Bodies that show less than this many square pixels are named in the legend alone.
const LEAST_SHOWN: f64 = 900.0;

/// What is written below windows.
pub const WORDS: [&str; 2] = ["from above", "other side, from below"];

/// The figure; `alone` are contact nodes that face nothing.
pub fn model_figure(scene: &Scene<'_>, alone: &[Point<3>]) -> String {
    let labels = Labels::of(scene.model);
    let (windows, height) = scene.windows(&scene.cameras, MARGIN, 0.0);
    let mut svg = Svg::new("setup", "Mesh, supports and loads", WIDTH, height);
    for (window, word) in windows.iter().zip(WORDS) {
        let canvas = surfaces(scene, window);
        svg.picture(window.corner, window.size, &canvas.png());
        symbols(&mut svg, scene, window, &canvas, alone, &labels);
        triad_and_scale(&mut svg, window, &labels, word);
    }
    let bottom = legend(&mut svg, scene, &labels, !alone.is_empty(), height + 2.0);
    svg.set_height(bottom);
    let cells: usize = scene.model.bodies.iter().map(|b| b.mesh.cell_count()).sum();
    let nodes: usize = scene
        .model
        .bodies
        .iter()
        .map(|b| b.mesh.points().len())
        .sum();
    let caption = format!(
        "{} cells, {} nodes, from two opposite directions. Symbols stand where their side is seen; arrows of one load are to \
         scale among themselves, shortened by the view.",
        count(cells),
        count(nodes)
    );
    html::figure(&svg.finish(), "Mesh, supports and loads", &caption)
}

/// The bodies in their tints, what is held greenish and what is loaded bluish, with their edges and those of the contacts.
fn surfaces(scene: &Scene<'_>, window: &Window) -> Canvas {
    let mut inks = vec![THIN, GHOST, HEAVY];
    inks.extend(SERIES.map(|colour| Ink {
        colour: rgb(colour),
        cover: 1.0,
        width: 2.0,
        depth: Some(2.2),
    }));
    let mut canvas = Canvas::new(window.size, &inks);
    for (body, skin) in scene.skins.iter().enumerate() {
        let colours = tints(scene, body);
        let look = Look::at(window, skin.mesh.points());
        skin.fill(&mut canvas, &look, body, &|facet| {
            Paint::Plain(colours[facet])
        });
    }
    for skin in &scene.skins {
        let look = Look::at(window, skin.mesh.points());
        skin.outline(&mut canvas, window, &look, [Some(0), Some(2)]);
    }
    for (i, contact) in scene.model.contacts.iter().enumerate() {
        let ink = 3 + i % SERIES.len();
        for side in contact_sides(&contact.pair) {
            let Some(body) = scene.model.bodies.get(side.body.0) else {
                continue;
            };
            let facets = scene.side(side.body.0, &side.side).to_vec();
            let skin = Skin::new(&body.mesh, facets);
            let look = Look::at(window, body.mesh.points());
            skin.outline(&mut canvas, window, &look, [None, Some(ink)]);
        }
        obstacle(&mut canvas, scene, window, &contact.pair);
    }
    canvas
}

/// The edge of the part of a rigid obstacle that lies opposite its side, seen through the bodies.
fn obstacle(canvas: &mut Canvas, scene: &Scene<'_>, window: &Window, pair: &Pair<3>) {
    let Pair::Obstacle {
        nonmortar,
        obstacle,
    } = pair
    else {
        return;
    };
    let Some(body) = scene.model.bodies.get(nonmortar.body.0) else {
        return;
    };
    let (mesh, time) = (&body.mesh, scene.model.last_time());
    let mut places = vec![[f64::NAN; 3]; mesh.points().len()];
    let facets = scene.side(nonmortar.body.0, &nonmortar.side);
    for &facet in facets {
        let kind = mesh.facet_kind(facet);
        for (node, xi) in mesh.facet_nodes(facet).zip(kind.reference_nodes()) {
            let point = mesh.points()[node as usize];
            if let Some(normal) = unit(mesh.outward_normal(facet, xi)) {
                let opposite = obstacle.shape.drawn(point, normal, time);
                places[node as usize] = window.place(opposite);
            }
        }
    }
    let look = Look {
        places,
        values: Vec::new(),
    };
    let skin = Skin::new(mesh, facets.to_vec());
    skin.outline(canvas, window, &look, [None, Some(1)]);
}

/// Colour of every facet of a body.
fn tints(scene: &Scene<'_>, body: usize) -> Vec<[u8; 3]> {
    let facets = &scene.skins[body].facets;
    let own = rgb(TINTS[body % TINTS.len()]);
    let mut colours = vec![own; facets.len()];
    let of = &scene.model.bodies[body];
    let held = of.supports.iter().map(|s| (s.place.clone(), SUPPORT, 0.22));
    let loaded = of.loads.iter().map(|l| (l.place(), LOAD, 0.2));
    for (place, colour, part) in held.chain(loaded) {
        let Place::Side(side) = place else { continue };
        let mixed = mix(own, rgb(colour), part);
        for facet in scene.side(body, &side) {
            if let Ok(index) = facets.binary_search(facet) {
                colours[index] = mixed;
            }
        }
    }
    colours
}

/// A colour of the drawings as red, green and blue.
pub fn rgb(hex: &str) -> [u8; 3] {
    [1, 3, 5].map(|i| {
        let digits = hex.get(i..i + 2).unwrap_or("00");
        u8::from_str_radix(digits, 16).unwrap_or(0)
    })
}

fn mix(a: [u8; 3], b: [u8; 3], part: f64) -> [u8; 3] {
    [0, 1, 2].map(|i| (f64::from(a[i]) * (1.0 - part) + f64::from(b[i]) * part).round() as u8)
}

fn symbols(
    svg: &mut Svg,
    scene: &Scene<'_>,
    window: &Window,
    canvas: &Canvas,
    alone: &[Point<3>],
    labels: &Labels,
) {
    svg.begin_clip(window.corner, window.size);
    let mut labelled = Labelled::default();
    // values are written after all symbols, so that they keep clear of them; without text: the end of an arrow
    let mut notes: Vec<(Pixel, String, &'static str)> = Vec::new();
    for body in 0..scene.model.bodies.len() {
        supports(svg, scene, window, canvas, body, labels, &mut notes);
        loads(svg, scene, window, canvas, body, labels, &mut notes);
    }
    for (index, body) in scene.model.bodies.iter().enumerate() {
        for couple in &body.couples {
            draw_couple(svg, scene, window, (index, couple), labels, &mut notes);
        }
    }
    // where arrows end there is no place for letters
    for (at, ..) in notes.iter().filter(|n| n.1.is_empty()) {
        labelled.keep(*at, [4.0, 4.0]);
    }
    for &point in alone {
        let place = window.place(point);
        if canvas.sees(place, 2.0) {
            svg.circle(window.pixel(point), 2.6, ALARM, "white", "faces nothing");
        }
    }
    for (at, text, colour) in notes.into_iter().filter(|n| !n.1.is_empty()) {
        let style = Type::LABEL.coloured(colour).rimmed();
        labelled.put(svg, window, at, &text, style);
    }
    names(svg, scene, window, canvas, &mut labelled);
    svg.end_clip();
}

/// Names of bodies on what is seen of them.
pub fn names(
    svg: &mut Svg,
    scene: &Scene<'_>,
    window: &Window,
    canvas: &Canvas,
    labelled: &mut Labelled,
) {
    if scene.model.bodies.len() > NAMED {
        return;
    }
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let (area, centre) = canvas.shown(i);
        if area < LEAST_SHOWN || !canvas.shows(i, centre) {
            continue;
        }
        let at = [0, 1].map(|d| window.corner[d] + centre[d]);
        let style = Type::LABEL.bold().rimmed();
        labelled.put(svg, window, at, &body.name, style);
    }
}

fn supports(
    svg: &mut Svg,
    scene: &Scene<'_>,
    window: &Window,
    canvas: &Canvas,
    index: usize,
    labels: &Labels,
    notes: &mut Vec<(Pixel, String, &'static str)>,
) {
    let body = &scene.model.bodies[index];
    let time = scene.model.last_time();
    for support in &body.supports {
        let marks = match &support.place {
            Place::Side(side) => seen(&body.mesh, scene.side(index, side), window, canvas),
            Place::Point(target) => {
                let node = nearest(body.mesh.points(), *target);
                let here = node.map(|&point| Mark {
                    point,
                    normal: [0.0, 0.0, -1.0],
                });
                here.into_iter().collect()
            }
        };
        for mark in &marks {
            let directions = held(support, mark.normal);
            hold(
                svg,
                window,
                window.pixel(mark.point),
                &directions,
                mark.normal,
            );
        }
        let Some(mark) = marks.get(marks.len() / 2) else {
            continue;
        };
        let at = |field: &Option<crate::geometry::Field>| {
            field.as_ref().map_or(0.0, |f| f.at(mark.point, time))
        };
        let along = at(&support.normal);
        let u = [0, 1, 2].map(|i| at(&support.components[i]) + along * mark.normal[i]);
        let Some(direction) = unit(u) else { continue };
        let [x, y, _] = window.camera.turned(direction);
        let tail = window.pixel(mark.point);
        let tip = [tail[0] + 26.0 * x, tail[1] - 26.0 * y];
        svg.arrow(tail, tip, SUPPORT, 2.0);
        let text = format!("u = {}", quantity(norm(u), &labels.length));
        notes.push(([tip[0], tip[1] - 9.0], text, SUPPORT));
    }
}

fn loads(
    svg: &mut Svg,
    scene: &Scene<'_>,
    window: &Window,
    canvas: &Canvas,
    index: usize,
    labels: &Labels,
    notes: &mut Vec<(Pixel, String, &'static str)>,
) {
    let body = &scene.model.bodies[index];
    let time = scene.model.last_time();
    for load in &body.loads {
        match load.place() {
            Place::Point(target) => {
                let Some(&point) = nearest(body.mesh.points(), target) else {
                    continue;
                };
                let value = load.at(point, [0.0; 3], time);
                if let Some(outer) = force(svg, window, point, value) {
                    let text = quantity(norm(value), &labels.force);
                    notes.push(([outer[0], outer[1] - 9.0], text, LOAD));
                }
            }
            Place::Side(side) => {
                let marks = seen(&body.mesh, scene.side(index, &side), window, canvas);
                let ends = arrows(svg, window, load, &marks, time);
                let Some(text) = told(load, &marks, time, labels) else {
                    continue;
                };
                notes.extend(ends.iter().map(|&end| (end, String::new(), LOAD)));
                let feet = marks.iter().map(|mark| window.pixel(mark.point));
                notes.extend(feet.map(|foot| (foot, String::new(), LOAD)));
                let highest = ends.into_iter().min_by(|a, b| a[1].total_cmp(&b[1]));
                if let Some([x, y]) = highest {
                    notes.push(([x, y - 12.0], text, LOAD));
                }
            }
        }
    }
}

/// The arrows of a load on a side; returns their outer ends.
fn arrows(svg: &mut Svg, window: &Window, load: &Load<3>, marks: &[Mark], time: f64) -> Vec<Pixel> {
    let values: Vec<Point<3>> = marks
        .iter()
        .map(|m| load.at(m.point, m.normal, time))
        .collect();
    let sizes = values.iter().map(|&v| norm(v)).filter(|s| s.is_finite());
    let most = sizes.fold(0.0, f64::max);
    let drawn = marks.iter().zip(values).filter_map(|(mark, value)| {
        let size = norm(value) / most;
        (size > 0.06).then(|| push(svg, window, mark, value, size))?
    });
    drawn.collect()
}

/// The values of a load on a side in words.
fn told(load: &Load<3>, marks: &[Mark], time: f64, labels: &Labels) -> Option<String> {
    let unit = match load.amount() {
        Amount::PerArea => &labels.stress,
        Amount::Whole => &labels.force,
    };
    let values = marks.iter().map(|m| norm(load.at(m.point, m.normal, time)));
    let (low, high) = values
        .filter(|s| s.is_finite())
        .fold((f64::INFINITY, 0.0f64), |(l, h), s| (l.min(s), h.max(s)));
    (high > 0.0).then(|| match high - low <= 1e-9 * high {
        true => quantity(high, unit),
        false => format!("{} … {}", number(low), quantity(high, unit)),
    })
}

/// The point of a couple, lines to its side, what holds and drives it.
fn draw_couple(
    svg: &mut Svg,
    scene: &Scene<'_>,
    window: &Window,
    (body, couple): (usize, &Couple<3>),
    labels: &Labels,
    notes: &mut Vec<(Pixel, String, &'static str)>,
) {
    let mesh = &scene.model.bodies[body].mesh;
    let at = window.pixel(couple.point);
    let nodes = mesh.side_nodes(&couple.side).unwrap_or_default();
    let lines = nodes.len().min(LINES);
    let path: String = (0..lines)
        .map(|k| nodes[k * (nodes.len() - 1) / (lines - 1).max(1)])
        .map(|node| segments(&[at, window.pixel(mesh.points()[node as usize])], false))
        .collect();
    svg.path(&path, MUTED, 0.7, "none", "");
    let axes = (0..3).filter(|&i| couple.displacement[i].is_some());
    let directions: Vec<Point<3>> = axes
        .map(|i| [0, 1, 2].map(|d| if d == i { -1.0 } else { 0.0 }))
        .collect();
    hold(svg, window, at, &directions, [0.0, 0.0, -1.0]);
    svg.circle(at, 3.0, INK, "white", &couple.name);
    notes.push(([at[0] + 10.0, at[1] - 10.0], couple.name.clone(), INK));
    let time = scene.model.last_time();
    let value = couple.force.clone().map(|f| f.at(couple.point, time));
    if let Some(outer) = force(svg, window, couple.point, value) {
        let text = quantity(norm(value), &labels.force);
        notes.push(([outer[0], outer[1] - 9.0], text, LOAD));
    }
    let moment = couple.moment.clone().map(|f| f.at(couple.point, time));
    if norm(moment) > 0.0 && norm(moment).is_finite() {
        let text = format!("M = {}", quantity(norm(moment), &labels.energy));
        notes.push(([at[0], at[1] + 16.0], text, LOAD));
    }
}

/// Names of tints, lines and symbols; returns the lower end.
fn legend(svg: &mut Svg, scene: &Scene<'_>, labels: &Labels, alone: bool, top: f64) -> f64 {
    svg.line([0.0, top], [WIDTH, top], RULE, 1.0);
    let mut flow = Flow {
        x: 4.0,
        y: top + 20.0,
    };
    let bodies = &scene.model.bodies;
    for (i, body) in bodies.iter().enumerate().take(NAMED) {
        let tint = TINTS[i % TINTS.len()];
        let text = body_text(body, labels);
        let at = flow.next(&text);
        svg.rectangle([at[0], at[1] - 9.0], [16.0, 10.0], INK, tint);
        words(svg, at, &text);
    }
    for (i, contact) in scene.model.contacts.iter().enumerate().take(NAMED) {
        let text = format!("contact {} ({})", contact.name, contact.law);
        let at = flow.next(&text);
        let y = at[1] - 4.0;
        svg.line([at[0], y], [at[0] + 16.0, y], SERIES[i % SERIES.len()], 2.6);
        words(svg, at, &text);
    }
    for (total, what) in [
        (bodies.len(), "bodies"),
        (scene.model.contacts.len(), "contacts"),
    ] {
        if total > NAMED {
            let text = format!("and {} more {what}", count(total - NAMED));
            let at = flow.next(&text);
            words(svg, at, &text);
        }
    }
    symbol_words(svg, scene, &mut flow, alone);
    flow.y + 12.0
}

fn words(svg: &mut Svg, at: Pixel, text: &str) {
    let style = Type::LABEL.anchored(Anchor::Start);
    svg.text([at[0] + 22.0, at[1]], text, style);
}

/// Symbols that occur, in words.
fn symbol_words(svg: &mut Svg, scene: &Scene<'_>, flow: &mut Flow, alone: bool) {
    let bodies = &scene.model.bodies;
    let supports = || bodies.iter().flat_map(|b| &b.supports);
    let count = |s: &crate::model::Support<3>| held(s, [0.0, 0.0, 1.0]).len();
    let window = Window::fitted(
        crate::output::space::camera::Camera::from([0.0, -1.0, 0.0]),
        ([0.0; 2], [1.0; 2]),
        [0.0; 2],
        [1.0; 2],
        0.0,
    );
    let down = [0.0, 0.0, -1.0];
    if supports().any(|s| (1..3).contains(&count(s))) {
        let text = "one displacement held (each cone)";
        let at = flow.next(text);
        hold(svg, &window, [at[0] + 8.0, at[1] - 9.0], &[down], down);
        words(svg, at, text);
    }
    if supports().any(|s| count(s) >= 3) {
        let text = "all displacements held";
        let at = flow.next(text);
        hold(svg, &window, [at[0] + 8.0, at[1] - 9.0], &[down; 3], down);
        words(svg, at, text);
    }
    if bodies.iter().any(|b| !b.loads.is_empty()) {
        let text = "load on the undeformed surface";
        let at = flow.next(text);
        svg.arrow([at[0], at[1] - 4.0], [at[0] + 17.0, at[1] - 4.0], LOAD, 1.3);
        words(svg, at, text);
    }
    if alone {
        let text = "contact node that faces nothing";
        let at = flow.next(text);
        svg.circle([at[0] + 8.0, at[1] - 4.0], 2.6, ALARM, "white", "");
        words(svg, at, text);
    }
}
