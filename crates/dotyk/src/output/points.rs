//! Points of couples on paper: thin lines to their sides, their supports and loads.

use crate::geometry::{Point, distance, norm, unit};
use crate::model::{Couple, CoupleKind, Model, Solution};
use crate::output::scene::Scene;
use crate::output::svg::{Anchor, INK, LOAD, MUTED, Pixel, SUPPORT, Svg, Type, segments};
use crate::output::symbols::{Hold, draw_force, draw_hold};
use crate::output::text::{Labels, number, quantity};
use crate::output::view::View;

/// Most lines from a point to its side.
const LINES: usize = 9;

/// Pixels from a point to the arrow of its moment.
const TO_MOMENT: f64 = 16.0;

/// Points farther from all bodies than this many times their size are left out of the picture.
const OUT_OF_PICTURE: f64 = 1.0;

/// All couples of a model with the index of their body.
pub fn couples<const D: usize>(model: &Model<D>) -> impl Iterator<Item = (usize, &Couple<D>)> {
    let bodies = model.bodies.iter().enumerate();
    bodies.flat_map(|(index, body)| body.couples.iter().map(move |couple| (index, couple)))
}

/// A couple in words.
pub fn in_words<const D: usize>(body: &str, couple: &Couple<D>) -> String {
    let side = format!("{body}.{}", couple.side);
    match couple.kind {
        CoupleKind::Rigid => format!("{side} moves rigidly with point {}", couple.name),
        CoupleKind::Average => format!("point {} has the mean motion of {side}", couple.name),
    }
}

/// The points that are near enough to the box of all bodies to be in its picture.
pub fn in_reach<const D: usize>(
    model: &Model<D>,
    (low, high): (Point<D>, Point<D>),
) -> impl Iterator<Item = Point<D>> {
    let size = OUT_OF_PICTURE * distance(low, high);
    let near = move |p: &Point<D>| (0..D).all(|i| p[i] >= low[i] - size && p[i] <= high[i] + size);
    couples(model).map(|(_, couple)| couple.point).filter(near)
}

/// The points with their lines, supports and loads.
pub fn draw_points(svg: &mut Svg, scene: &Scene, view: &View, labels: &Labels) {
    for (body, couple) in couples(scene.model) {
        let points = scene.model.bodies[body].mesh.points();
        let at = view.pixel(couple.point);
        fan(svg, scene, (body, couple), at, &|node| {
            view.pixel(points[node])
        });
        drive(svg, scene, view, couple, labels);
        dot(svg, at, &couple.name);
    }
}

/// The points and their lines where they have gone, displacements magnified.
pub fn draw_moved(svg: &mut Svg, scene: &Scene, solution: &Solution<2>, view: &View, factor: f64) {
    let moved = |x: Point<2>, u: Point<2>| view.pixel([0, 1].map(|i| x[i] + factor * u[i]));
    for (body, couple) in couples(scene.model) {
        let solved = &solution.bodies[body];
        let own = solved.couples.iter().find(|c| c.name == couple.name);
        let Some(own) = own else { continue };
        let points = scene.model.bodies[body].mesh.points();
        let at = moved(couple.point, own.displacement);
        let node = |n: usize| moved(points[n], solved.displacement[n]);
        fan(svg, scene, (body, couple), at, &node);
        dot(svg, at, &couple.name);
    }
}

/// Thin lines from a point to its side.
fn fan(
    svg: &mut Svg,
    scene: &Scene,
    (body, couple): (usize, &Couple<2>),
    at: Pixel,
    place: &dyn Fn(usize) -> Pixel,
) {
    let mut lines = String::new();
    for strand in scene.body_side(body, &couple.side) {
        let starts = strand.links.iter().map(|link| link.ends[0]);
        let last = strand.links.last().map(|link| link.ends[1]);
        let nodes: Vec<usize> = starts.chain(last).collect();
        let count = nodes.len().min(LINES);
        for k in 0..count {
            let node = nodes[k * (nodes.len() - 1) / (count - 1).max(1)];
            lines += &segments(&[at, place(node)], false);
        }
    }
    svg.path(&lines, MUTED, 0.7, "none", "");
}

fn dot(svg: &mut Svg, at: Pixel, name: &str) {
    svg.circle(at, 3.0, INK, "white", name);
    let style = Type::SMALL.anchored(Anchor::Start);
    svg.text([at[0] + 11.0, at[1] - 11.0], name, style);
}

/// Supports, force and moment of a point.
fn drive(svg: &mut Svg, scene: &Scene, view: &View, couple: &Couple<2>, labels: &Labels) {
    let at = view.pixel(couple.point);
    if !view.sees(at) {
        return;
    }
    let hold = match &couple.displacement {
        [Some(_), Some(_)] => Some(Hold::Clamp),
        [Some(_), None] => Some(Hold::Axis(0)),
        [None, Some(_)] => Some(Hold::Axis(1)),
        [None, None] => None,
    };
    let (low, high) = scene.bounds;
    let middle = [0, 1].map(|i| 0.5 * (low[i] + high[i]));
    if let Some(hold) = hold {
        draw_hold(svg, at, hold, (couple.point, middle));
    }
    if couple.rotation[2].is_some() {
        svg.rectangle([at[0] - 5.0, at[1] - 5.0], [10.0, 10.0], SUPPORT, "none");
    }
    let time = scene.model.last_time();
    let force = [0, 1].map(|i| couple.force[i].at(couple.point, time));
    draw_force(svg, view, at, force, labels);
    let moment = couple.moment[2].at(couple.point, time);
    if moment != 0.0 && moment.is_finite() {
        turn(svg, at, moment > 0.0);
        let text = match labels.energy.as_str() {
            "" => format!("M = {}", number(moment)),
            unit => format!("M = {}", quantity(moment, unit)),
        };
        let style = Type::LABEL.coloured(LOAD).anchored(Anchor::Start);
        svg.text([at[0] + TO_MOMENT + 5.0, at[1] + 12.0], &text, style);
    }
}

/// An arrow around a point, counterclockwise or not.
fn turn(svg: &mut Svg, at: Pixel, left: bool) {
    let on_arc = |k: u32| {
        let angle = (-60.0 + 300.0 / 20.0 * f64::from(k)).to_radians();
        let x = if left { angle.cos() } else { -angle.cos() };
        [at[0] + TO_MOMENT * x, at[1] - TO_MOMENT * angle.sin()]
    };
    let arc: Vec<Pixel> = (0..19).map(on_arc).collect();
    svg.path(&segments(&arc, false), LOAD, 1.6, "none", "");
    svg.arrow(on_arc(17), on_arc(20), LOAD, 1.6);
}

/// Tail of the force arrow of a point, with the place of the point: room for the arrow.
pub fn forces(scene: &Scene) -> Vec<(Point<2>, Point<2>)> {
    let time = scene.model.last_time();
    let from = |(_, couple): (usize, &Couple<2>)| {
        let force = [0, 1].map(|i| couple.force[i].at(couple.point, time));
        let along = unit(force).filter(|_| norm(force).is_finite())?;
        Some((couple.point, along.map(|c| -c)))
    };
    couples(scene.model).filter_map(from).collect()
}
