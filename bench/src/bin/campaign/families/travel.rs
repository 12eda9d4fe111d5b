//! Open bodies that are moved far compared with their cells, past and into bodies without a contact.
//!
//! The moved body has no load, or a small pressure onto its floor: it keeps its shape, and polygons decide which body it runs
//! into. A penetration deeper than `DEEP` must be refused; a body that stays apart, or slides along its contact, must be answered.

use super::Scene;
use crate::amount::{Amount, Time};
use crate::overlap::depth;
use crate::plane::{Vector, rotated};
use crate::problem::{Edge, Known, Law, Shape, clamp, moved, on, side, steps};
use crate::vector::plus;

/// A deeper penetration must be refused; a distance below a tenth of it is not judged.
const DEEP: f64 = 0.01;

/// A slider above a floor, with or without a contact between them, and a post, a ramp or a disc in its way, held by itself or part
/// of the floor.
pub fn travel(scene: &mut Scene) {
    let count = scene.random.count(1, 3);
    scene.problem.times = steps(count);
    let long = scene.random.between(2.5, 4.0);
    let (w, h) = (
        scene.random.between(0.4, 1.0),
        scene.random.between(0.3, 0.8),
    );
    let named = scene.random.chance(0.6);
    let air = if named && scene.random.chance(0.7) {
        0.0
    } else {
        scene.random.between(0.01, 0.1)
    };
    let slider = [[0.2, air], [0.2 + w, air + h]];
    let far = scene.random.pick(&[0.1, 0.3, 0.9]);
    let way = scene.random.between(0.03, far) * (long - w);
    let (foot, wide, high) = (
        0.2 + w + scene.random.between(0.05, 1.2),
        scene.random.between(0.2, 0.8),
        scene.random.between(0.15, 1.0),
    );
    let lift = scene.random.pick(&[0.02, 0.05, 0.3, 1.2]);
    let floor = [[0.0, -0.5], [long, -0.5], [long, 0.0], [0.0, 0.0]];
    let mut polygons: Vec<Vec<Vector>> = Vec::new();
    let kind = scene.random.count(0, 3);
    let post = match kind {
        // a post, a ramp
        0 => vec![
            [foot, lift],
            [foot + wide, lift],
            [foot + wide, lift + high],
            [foot, lift + high],
        ],
        1 => vec![
            [foot, lift],
            [foot + wide, lift],
            [foot + wide, lift + high],
        ],
        2 => {
            let centre = [foot + 0.5 * wide, lift + 0.5 * wide];
            let around =
                |k: usize| rotated([0.5 * wide, 0.0], std::f64::consts::TAU * k as f64 / 48.0);
            (0..48).map(|k| plus(centre, 1.0, around(k))).collect()
        }
        // the floor itself rises
        _ => Vec::new(),
    };
    let size = scene.random.between(0.1, 0.3);
    if kind == 3 {
        let names = ["low", "end", "top", "top", "top", "start"];
        let corners = [
            [0.0, -0.5],
            [foot + wide, -0.5],
            [foot + wide, high],
            [foot + scene.random.unit() * wide, high],
            [foot, 0.0],
            [0.0, 0.0],
        ];
        let shape = super::floors::polygon(size, &corners, &names, &[]);
        let kind = triangle(scene);
        scene.add("floor", shape, kind);
        scene.problem.bodies[0].supports.push(clamp(on("low")));
        polygons.push(corners.to_vec());
    } else {
        scene.block("floor", floor[0], floor[2], 2);
        scene.problem.bodies[0].supports.push(clamp(on("bottom")));
        polygons.push(floor.to_vec());
        let shape = match kind {
            2 => Shape::Disc {
                size: size.min(0.4 * wide),
                center: [foot + 0.5 * wide, lift + 0.5 * wide],
                radius: 0.5 * wide,
                cells: None,
            },
            _ => {
                let names = ["under", "back", "over", "front"];
                super::floors::polygon(size, &post, &names[..post.len()], &[])
            }
        };
        let kind = triangle(scene);
        scene.add("post", shape, kind);
        let held = if post.len() > 4 { "round" } else { "back" };
        scene.problem.bodies[1].supports.push(clamp(on(held)));
        polygons.push(post);
    }
    let place = scene.problem.bodies.len();
    scene.block("slider", slider[0], slider[1], 2);
    // down by little if the slider has a contact with the floor and touches it, or far if it has no contact
    let down = match (named, air > 0.0) {
        (true, false) => scene.strain * h * scene.random.pick(&[0.0, 1.0]),
        (true, true) => 0.0,
        _ => scene.random.pick(&[0.0, 0.0, 0.0, 0.5, 3.0]) * air,
    };
    let time = Time::Line(0.0, 1.0 / count as f64);
    let supports = &mut scene.problem.bodies[place].supports;
    supports.push(moved(on("top"), 0, Amount::timed(way, time)));
    supports.push(moved(on("top"), 1, Amount::timed(-down, time)));
    if named {
        let law = scene.law(0.2);
        scene.touch(side("slider", "bottom"), side("floor", "top"), law);
    } else if scene.random.chance(0.5) {
        // a contact with another obstacle
        let law = Law::Frictionless;
        scene.stand(
            side("slider", "left"),
            crate::problem::Surface::Plane {
                point: [0.1, 0.0],
                normal: [1.0, 0.0],
            },
            crate::problem::Drive::Nothing,
            law,
        );
    }
    let known = |t: f64| {
        let shift = [way * t, -down * t];
        let [low, far] = slider.map(|x| plus(x, 1.0, shift));
        let own = [low, [far[0], low[1]], far, [low[0], far[1]]];
        polygons
            .iter()
            .enumerate()
            .map(|(index, other)| {
                let (deep, apart) = deepest(&own, other);
                match index {
                    // pressed onto the floor of its contact, it leaves a dent at its first place
                    0 if named && down > 0.0 => Known::Open,
                    // the contact keeps the slider off a ramp of its side, within the limits of small displacements
                    0 if named && deep > 0.0 && kind == 3 => Known::Open,
                    0 if named => Known::Holds,
                    _ if deep > DEEP => Known::Falls,
                    _ if deep > 0.0 || (apart < 0.1 * DEEP && index > 0) => Known::Open,
                    _ => Known::Holds,
                }
            })
            .collect::<Vec<_>>()
    };
    let all: Vec<Known> = (1..=count)
        .flat_map(|k| known(k as f64 / count as f64))
        .collect();
    let reason = if all.contains(&Known::Falls) {
        scene.problem.known = Known::Falls;
        "the slider runs into what nobody named"
    } else if all.contains(&Known::Open) {
        scene.problem.known = Known::Open;
        "the slider comes near to what nobody named"
    } else {
        scene.problem.known = Known::Holds;
        "the slider stays apart from what nobody named"
    };
    scene.problem.reason = reason.to_string();
}

/// A kind of triangles, which fill outlines.
pub fn triangle(scene: &mut Scene) -> crate::cells::Kind {
    use crate::cells::Kind;
    scene.random.pick(&[Kind::Tri3, Kind::Tri6])
}

/// The depth to which two polygons penetrate each other, sampled at many points, and the distance of their outlines.
fn deepest(a: &[Vector], b: &[Vector]) -> (f64, f64) {
    let (mut deep, mut apart) = (0.0f64, f64::INFINITY);
    for (own, other) in [(a, b), (b, a)] {
        let pieces = |of: &[Vector]| -> Vec<[Vector; 2]> {
            (0..of.len())
                .map(|k| [of[k], of[(k + 1) % of.len()]])
                .collect()
        };
        let others = pieces(other);
        for [p, q] in pieces(own) {
            for k in 0..40 {
                let x = plus(p, k as f64 / 40.0, crate::vector::minus(q, p));
                let (inside, near) = depth(x, others.iter().copied());
                (deep, apart) = (deep.max(inside), apart.min(near));
            }
        }
    }
    (deep, apart)
}

/// An edge of an outline.
pub fn edge(to: Vector, name: &'static str) -> Edge {
    Edge {
        to,
        name,
        center: None,
        cells: None,
    }
}
