//! Picture "Mesh, supports and loads" of a model in space, from two sides.

use crate::geometry::{Field, Point, norm, unit};
use crate::mesh::Mesh;
use crate::model::{Amount, Borders, Couple, Load, Pair, Place};
use crate::output::html;
use crate::output::markup::Markup;
use crate::output::points::couples;
use crate::output::setup::{
    Flow, NAMED, draw_member, look, name_alone, name_links, name_loads, name_parts,
};
use crate::output::space::camera::{Camera, Window};
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::marks::{Labelled, Mark, force, held, hold, push, seen};
use crate::output::space::scene::{GHOST, HEAVY, Scene, THIN, triad_and_scale};
use crate::output::space::skin::{Look, Skin};
use crate::output::svg::{
    ALARM, INK, LOAD, MUTED, Pixel, SERIES, SUPPORT, Svg, TINTS, Type, segments,
};
use crate::output::text::{Labels, count, number, quantity};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Room around the bodies for arrows and their values.
const MARGIN: f64 = 46.0;

/// Most lines from the point of a couple to its side.
const LINES: usize = 12;

/// Bodies that show less than this many square pixels are named in the legend alone.
const LEAST_SHOWN: f64 = 900.0;

/// Captions below windows.
pub const WORDS: [&str; 2] = ["from above", "other side, from below"];

/// The figure; `alone` are contact nodes without an opposite side.
pub fn model_figure(scene: &Scene<'_>, alone: &[Point<3>]) -> Markup {
    let labels = Labels::of(scene.model);
    let draw = |width| drawing(scene, alone, &labels, width);
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
    html::fitted(&draw, "Mesh, supports and loads", &caption)
}

fn drawing(scene: &Scene<'_>, alone: &[Point<3>], labels: &Labels, width: f64) -> Markup {
    let (windows, height) = scene.windows(MARGIN, width);
    let mut svg = Svg::new("setup", "Mesh, supports and loads", width, height);
    let pictures = windows.par_iter().map(|window| {
        let canvas = surfaces(scene, window);
        let png = canvas.png();
        (canvas, png)
    });
    let pictures: Vec<(Canvas, Vec<u8>)> = pictures.collect();
    for ((window, word), (canvas, png)) in windows.iter().zip(WORDS).zip(pictures) {
        svg.picture(window.corner, window.size, &png);
        let sheet = Sheet {
            svg: &mut svg,
            scene,
            window,
            canvas: &canvas,
            labels,
            notes: Vec::new(),
            arrows: Vec::new(),
        };
        sheet.symbols(alone);
        triad_and_scale(&mut svg, window, labels, word);
    }
    let bottom = legend(
        &mut svg,
        scene,
        labels,
        !alone.is_empty(),
        [width, height + 2.0],
    );
    svg.set_height(bottom);
    svg.finish()
}

/// The bodies in their tints, held sides greenish and loaded ones bluish, with their edges and those of the contacts.
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
        for side in contact.pair.sides() {
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
        borders: Borders::default(),
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
    let held = of.held_places().map(|place| (place, SUPPORT, 0.22));
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

/// One window of the figure, whose symbols stand above its picture.
struct Sheet<'a> {
    svg: &'a mut Svg,
    scene: &'a Scene<'a>,
    window: &'a Window,
    canvas: &'a Canvas,
    labels: &'a Labels,
    /// Values are written after all symbols, so that they keep clear of them.
    notes: Vec<(Pixel, String, &'static str)>,
    /// Arrows by their ends.
    arrows: Vec<[Pixel; 2]>,
}

impl Sheet<'_> {
    fn symbols(mut self, alone: &[Point<3>]) {
        let (scene, window) = (self.scene, self.window);
        self.svg.begin_clip(window.corner, window.size);
        for body in 0..scene.model.bodies.len() {
            self.supports(body);
            self.loads(body);
        }
        for (body, couple) in couples(scene.model) {
            self.couple(&scene.model.bodies[body].mesh, couple);
        }
        for member in &scene.model.members {
            if let Ok(ends) = member.places(scene.model) {
                draw_member(self.svg, ends.map(|end| window.pixel(end)), look(member));
            }
        }
        let mut labelled = Labelled::default();
        self.arrows.iter().for_each(|ends| labelled.keep(*ends));
        for &point in alone {
            if self.canvas.sees(window.place(point), 2.0) {
                let at = window.pixel(point);
                self.svg.circle(at, 2.6, ALARM, "white", "faces nothing");
            }
        }
        let notes = std::mem::take(&mut self.notes).into_iter();
        for (at, text, colour) in notes {
            let style = Type::LABEL.coloured(colour).rimmed();
            labelled.put(self.svg, window, at, &text, style);
        }
        self.names(&mut labelled);
        self.svg.end_clip();
    }

    /// Names of bodies on their visible parts.
    fn names(&mut self, labelled: &mut Labelled) {
        let bodies = &self.scene.model.bodies;
        if bodies.len() > NAMED {
            return;
        }
        for (i, body) in bodies.iter().enumerate() {
            let (area, centre) = self.canvas.shown(i);
            if area < LEAST_SHOWN || !self.canvas.shows(i, centre) {
                continue;
            }
            let at = [0, 1].map(|d| self.window.corner[d] + centre[d]);
            let style = Type::LABEL.bold().rimmed();
            labelled.put(self.svg, self.window, at, &body.name, style);
        }
    }

    fn note(&mut self, at: Pixel, text: String, colour: &'static str) {
        self.notes.push((at, text, colour));
    }

    fn supports(&mut self, index: usize) {
        let (scene, window) = (self.scene, self.window);
        let body = &scene.model.bodies[index];
        let time = scene.model.last_time();
        for support in &body.supports {
            let marks = match &support.place {
                Place::Side(side) => seen(&body.mesh, scene.side(index, side), window, self.canvas),
                Place::Point(target) => {
                    let node = body.mesh.nearest_node(*target);
                    vec![Mark {
                        point: body.mesh.points()[node],
                        normal: [0.0, 0.0, -1.0],
                    }]
                }
            };
            for mark in &marks {
                let at = window.pixel(mark.point);
                let directions = held(support, mark.normal);
                hold(self.svg, window, at, &directions, mark.normal);
            }
            let Some(mark) = marks.get(marks.len() / 2) else {
                continue;
            };
            let at = |field: &Option<Field>| field.as_ref().map_or(0.0, |f| f.at(mark.point, time));
            let along = at(&support.normal);
            let u = [0, 1, 2].map(|i| at(&support.components[i]) + along * mark.normal[i]);
            let Some(direction) = unit(u) else { continue };
            let [x, y, _] = window.camera.turned(direction);
            let tail = window.pixel(mark.point);
            let tip = [tail[0] + 26.0 * x, tail[1] - 26.0 * y];
            self.svg.arrow(tail, tip, SUPPORT, 2.0);
            self.arrows.push([tail, tip]);
            let text = format!("u = {}", quantity(norm(u), &self.labels.length));
            self.note([tip[0], tip[1] - 9.0], text, SUPPORT);
        }
    }

    fn loads(&mut self, index: usize) {
        let (scene, window) = (self.scene, self.window);
        let body = &scene.model.bodies[index];
        let time = scene.model.last_time();
        for load in &body.loads {
            match load.place() {
                Place::Point(target) => {
                    let point = body.mesh.points()[body.mesh.nearest_node(target)];
                    self.force(point, load.at(point, [0.0; 3], time));
                }
                Place::Side(side) => {
                    let facets = scene.side(index, &side);
                    let marks = seen(&body.mesh, facets, window, self.canvas);
                    let places = marks.iter().map(|mark| (mark.point, mark.normal));
                    let values = load.values(&places.collect::<Vec<_>>(), time);
                    let drawn = arrows(self.svg, window, &marks, &values);
                    self.arrows.extend(&drawn);
                    let Some(text) = told(load, &values, self.labels) else {
                        continue;
                    };
                    let outer = drawn.into_iter().map(|ends| ends[1]);
                    let highest = outer.min_by(|a, b| a[1].total_cmp(&b[1]));
                    if let Some([x, y]) = highest {
                        self.note([x, y - 12.0], text, LOAD);
                    }
                }
            }
        }
    }

    /// A force at a point, with its size.
    fn force(&mut self, point: Point<3>, value: Point<3>) {
        if let Some([inner, outer]) = force(self.svg, self.window, point, value) {
            self.arrows.push([inner, outer]);
            let text = quantity(norm(value), &self.labels.force);
            self.note([outer[0], outer[1] - 9.0], text, LOAD);
        }
    }

    /// The point of a couple, lines to its side, its supports and loads.
    fn couple(&mut self, mesh: &Mesh<3>, couple: &Couple<3>) {
        let window = self.window;
        let at = window.pixel(couple.point);
        let nodes = mesh.side_nodes(&couple.side).unwrap_or_default();
        let lines = nodes.len().min(LINES);
        let path: String = (0..lines)
            .map(|k| nodes[k * (nodes.len() - 1) / (lines - 1).max(1)])
            .map(|node| segments(&[at, window.pixel(mesh.points()[node as usize])], false))
            .collect();
        self.svg.path(&path, MUTED, 0.7, "none", "");
        let axes = (0..3).filter(|&i| couple.displacement[i].is_some());
        let directions: Vec<Point<3>> = axes
            .map(|i| [0, 1, 2].map(|d| if d == i { -1.0 } else { 0.0 }))
            .collect();
        hold(self.svg, window, at, &directions, [0.0, 0.0, -1.0]);
        self.svg.circle(at, 3.0, INK, "white", &couple.name);
        self.note([at[0] + 10.0, at[1] - 10.0], couple.name.clone(), INK);
        let time = self.scene.model.last_time();
        let value = couple.force.clone().map(|f| f.at(couple.point, time));
        self.force(couple.point, value);
        let moment = couple.moment.clone().map(|f| f.at(couple.point, time));
        if norm(moment) > 0.0 && norm(moment).is_finite() {
            let text = format!("M = {}", quantity(norm(moment), &self.labels.energy));
            self.note([at[0], at[1] + 16.0], text, LOAD);
        }
    }
}

/// The arrows of a load with these values on a side; returns their ends, the outer ones last.
fn arrows(svg: &mut Svg, window: &Window, marks: &[Mark], values: &[Point<3>]) -> Vec<[Pixel; 2]> {
    let sizes = values.iter().map(|&v| norm(v)).filter(|s| s.is_finite());
    let most = sizes.fold(0.0, f64::max);
    let drawn = marks.iter().zip(values).filter_map(|(mark, &value)| {
        let size = norm(value) / most;
        (size > 0.06).then(|| push(svg, window, mark, value, size))?
    });
    drawn.collect()
}

/// The values of a load on a side in words.
fn told(load: &Load<3>, values: &[Point<3>], labels: &Labels) -> Option<String> {
    let unit = match load.amount() {
        Amount::PerArea => &labels.stress,
        Amount::Whole => &labels.force,
    };
    let (low, high) = values
        .iter()
        .map(|&value| norm(value))
        .filter(|s| s.is_finite())
        .fold((f64::INFINITY, 0.0f64), |(l, h), s| (l.min(s), h.max(s)));
    (high > 0.0).then(|| match high - low <= 1e-9 * high {
        true => quantity(high, unit),
        false => format!("{} … {}", number(low), quantity(high, unit)),
    })
}

/// Names of tints, lines and symbols; returns the lower end.
fn legend(svg: &mut Svg, scene: &Scene<'_>, labels: &Labels, alone: bool, below: [f64; 2]) -> f64 {
    let mut flow = name_parts(svg, scene.model, labels, below);
    name_holds(svg, scene, &mut flow);
    if scene.model.bodies.iter().any(|b| !b.loads.is_empty()) {
        name_loads(svg, &mut flow);
    }
    name_links(svg, scene.model, &mut flow);
    if alone {
        name_alone(svg, &mut flow);
    }
    flow.y + 12.0
}

/// Symbols of supports that occur, in words.
fn name_holds(svg: &mut Svg, scene: &Scene<'_>, flow: &mut Flow) {
    let supports = scene.model.bodies.iter().flat_map(|b| &b.supports);
    let of_supports = supports.map(|s| held(s, [0.0, 0.0, 1.0]).len());
    let of_points = couples(scene.model).map(|(_, c)| c.displacement.iter().flatten().count());
    let counts: BTreeSet<usize> = of_supports.chain(of_points).collect();
    let window = Window::fitted(
        Camera::from([0.0, -1.0, 0.0]),
        ([0.0; 2], [1.0; 2]),
        [0.0; 2],
        [1.0; 2],
        0.0,
    );
    let down = [0.0, 0.0, -1.0];
    for (several, directions, text) in [
        (1..3, &[down][..], "one displacement held (each cone)"),
        (3..4, &[down; 3], "all displacements held"),
    ] {
        if counts.range(several).next().is_some() {
            let at = flow.explain(svg, text);
            hold(svg, &window, [at[0] + 8.0, at[1] - 9.0], directions, down);
        }
    }
}
