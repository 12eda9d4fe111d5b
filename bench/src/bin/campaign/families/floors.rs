//! Several obstacles under one side, moving obstacles, and obstacles moved by a force.

use super::{Scene, course};
use crate::amount::{Amount, Time};
use crate::plane::rotated;
use crate::problem::{
    Drive, Edge, Known, Law, Place, Shape, Surface, clamp, hold, moved, on, side, steps,
};

/// A block above two to four obstacles of all kinds, in any order, at different distances.
pub fn floors(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.8, 2.0),
        scene.random.between(0.4, 1.2),
    );
    scene.block("block", [0.0, 0.0], [w, h], 1);
    let reach = scene.strain * h * scene.random.magnitude(0.05, 2.0);
    let count = scene.random.pick(&[1, 1, 2]);
    scene.problem.times = steps(count);
    let n = scene.random.count(2, 4);
    let rough = scene.random.chance(0.25);
    let mut whole = false;
    for _ in 0..n {
        let gap = reach * scene.random.pick(&[0.0, 0.2, 0.5, 1.0]);
        let surface = match scene.random.count(0, 4) {
            0 | 1 => {
                whole = true;
                Surface::Plane {
                    point: [0.0, -gap],
                    normal: [0.0, 1.0],
                }
            }
            2 => {
                let angle = scene.strain * scene.random.between(-0.5, 0.5);
                whole = true;
                Surface::Plane {
                    point: [0.5 * w, -gap],
                    normal: rotated([0.0, 1.0], angle),
                }
            }
            3 => {
                whole = true;
                let slope = reach * scene.random.between(-0.3, 0.3) / w;
                Surface::Gap(Amount::new(
                    gap - 0.5 * slope * w,
                    [slope, 0.0],
                    Time::Always,
                ))
            }
            _ => {
                let radius = scene.random.between(1.0, 5.0) * w;
                let x = scene.random.between(0.3, 0.7) * w;
                Surface::Round {
                    center: [x, -gap - radius],
                    radius,
                    inside: false,
                }
            }
        };
        let law = if rough {
            scene.law(0.7)
        } else {
            Law::Frictionless
        };
        scene.stand(side("block", "bottom"), surface, Drive::Nothing, law);
    }
    let p = scene.strain;
    let time = match course(&mut scene.random, count) {
        Time::Wave(..) => Time::Line(1.2, -0.5 / count as f64),
        other => other,
    };
    let body = &mut scene.problem.bodies[0];
    body.press("top", Amount::timed(p, time));
    match scene.random.count(0, 2) {
        0 => scene.problem.bodies[0].supports.push(hold(on("left"), 0)),
        1 => scene.problem.bodies[0]
            .supports
            .push(hold(Place::Point([0.0, 0.0]), 0)),
        _ => {
            scene.problem.bodies[0].supports.push(hold(on("left"), 0));
            scene.problem.bodies[0].supports.push(hold(on("right"), 0));
        }
    }
    let held_level = scene.problem.bodies[0].supports[0].place == on("left");
    if whole || held_level {
        scene.holds("pressed evenly above a floor that reaches under the whole block");
    }
}

/// A floor that moves across, along or both ways under a block that is held at its top, with or without friction.
pub fn moving(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    scene.block("block", [0.0, 0.0], [w, h], 1);
    let count = scene.random.count(1, 6);
    scene.problem.times = steps(count);
    let stroke = scene.strain * h;
    let wave = |scene: &mut Scene, size: f64| {
        let time = match count {
            1 => Time::Always,
            _ => match scene.random.count(0, 2) {
                0 => Time::Line(0.0, 1.0 / count as f64),
                _ => Time::Wave(
                    scene.random.between(0.6, 2.2),
                    scene.random.between(0.0, 3.0),
                ),
            },
        };
        Amount::timed(size, time)
    };
    let law = match scene.random.count(0, 3) {
        0 => Law::Frictionless,
        1 => Law::Tresca(Amount::from(scene.strain * scene.random.between(0.1, 0.6))),
        _ => scene.varied_law(1.0),
    };
    let size = stroke * scene.random.between(-2.0, 2.0);
    let along = wave(scene, size);
    let across = if scene.random.chance(0.5) {
        let size = stroke * scene.random.between(-1.0, 1.0);
        wave(scene, size)
    } else {
        Amount::default()
    };
    let surface = match scene.random.count(0, 3) {
        0 => Surface::Gap(Amount::from(stroke * scene.random.between(-0.5, 0.3))),
        1 => Surface::Round {
            center: [0.5 * w, -3.0 * w],
            radius: 3.0 * w,
            inside: false,
        },
        _ => Surface::Plane {
            point: [0.0, stroke * scene.random.between(-0.3, 0.5)],
            normal: [0.0, 1.0],
        },
    };
    scene.stand(
        side("block", "bottom"),
        surface,
        Drive::Displacement([along, across]),
        law,
    );
    let body = &mut scene.problem.bodies[0];
    if scene.random.chance(0.5) {
        body.supports.push(clamp(on("top")));
    } else {
        body.supports.push(hold(on("top"), 0));
        body.supports
            .push(moved(on("top"), 1, Amount::from(-0.8 * stroke)));
    }
    scene.holds("the block is clamped at its top");
}

/// A stamp that a force presses against a clamped block or against a loose one between two of them.
pub fn free_obstacle(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    scene.block("block", [0.0, 0.0], [w, h], 1);
    let count = scene.random.pick(&[1, 1, 3]);
    scene.problem.times = steps(count);
    let force = scene.strain * w * scene.problem.bodies[0].thickness;
    let time = match course(&mut scene.random, count) {
        Time::Wave(omega, _) => Time::Wave(0.3 * omega, 0.4),
        other => other,
    };
    let clear = scene.strain * h * scene.random.pick(&[0.0, 0.3, 1.0]);
    let round = scene.random.chance(0.3);
    let surface = if round {
        let radius = 4.0 * w;
        Surface::Round {
            center: [0.5 * w, -radius - clear],
            radius,
            inside: false,
        }
    } else {
        Surface::Plane {
            point: [0.0, -clear],
            normal: [0.0, 1.0],
        }
    };
    let rough = scene.random.chance(0.3);
    let law = if rough {
        scene.law(1.0)
    } else {
        Law::Frictionless
    };
    let drawn = match &law {
        Law::Coulomb(mu) => force * mu.at([0.0; 2], 0.0) * scene.random.between(-0.8, 0.8),
        _ => 0.0,
    };
    let drive = [Amount::timed(drawn, time), Amount::timed(force, time)];
    scene.stand(side("block", "bottom"), surface, Drive::Force(drive), law);
    scene.problem.bodies[0].supports.push(clamp(on("top")));
    scene.problem.known = if round { Known::Open } else { Known::Holds };
    scene.problem.reason = "the stamp presses a clamped block".to_string();
    if scene
        .problem
        .times
        .iter()
        .any(|&t| Amount::timed(1.0, time).at([0.0; 2], t) <= 0.0)
    {
        scene.problem.known = Known::Falls;
        scene.problem.reason = "the stamp is pulled away".to_string();
    }
}

/// A polygon of straight edges with names.
pub fn polygon(
    size: f64,
    corners: &[[f64; 2]],
    names: &[&'static str],
    cells: &[Option<usize>],
) -> Shape {
    let n = corners.len();
    let edges = (0..n)
        .map(|k| Edge {
            to: corners[(k + 1) % n],
            name: names[k],
            center: None,
            cells: cells.get(k).copied().flatten(),
        })
        .collect();
    Shape::Outline {
        size,
        from: corners[0],
        edges,
    }
}
