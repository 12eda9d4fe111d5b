//! Bodies near the limit of friction; corners of walls; moving obstacles.

use super::boxes::{floor, pressed};
use super::{Drive, Field, Law, Margin, Number, Push, Scene, Shape, Surface, course, from_below};
use crate::amount::Time;
use crate::cells::Kind;
use crate::problem::{Known, constant, round, side};
use crate::statics::beside_limit;
use crate::vector::{cross, plus, times, unit};
use std::f64::consts::TAU;

/// A box or a column under its weight on a slope of any direction, a rigid plane or another body.
pub fn incline(scene: &mut Scene) {
    let [w, d] = [0, 1].map(|_| scene.random.between(0.8, 1.5));
    let mu = scene.random.between(0.05, 0.8);
    // low enough not to tip
    let h = scene.random.between(0.15, 0.3) * w.min(d) / (0.5 + mu);
    let column = scene.random.chance(0.3);
    let (block, sole) = match column {
        true => (add_column(scene, w, h), "first"),
        false => (scene.cuboid("block", [0.0; 3], [w, d, h], 2), "bottom"),
    };
    let slope = beside_limit(&mut scene.random) * mu;
    let [x, y] = scene.direction(slope, [1.0, 1.0]);
    let g = scene.strain;
    scene.problem.bodies[block].weight = constant(times(g, unit([x, y, -1.0])));
    let law = Law::rubbing(mu);
    let (mut low, mut high) = ([0.0; 2], [w, d]);
    if scene.random.chance(0.4) {
        scene.stand(side("block", sole), floor(0.0), Drive::Nothing, law);
    } else {
        let least = if column { w } else { -0.1 };
        let out = [0; 4].map(|_| scene.random.between(least, least + 0.5));
        let (from, to) = ([-out[0], -out[1], -0.4], [w + out[2], d + out[3], 0.0]);
        let lower = scene.cuboid("slope", from, to, 2);
        scene.hold(lower, "bottom", Field::default());
        scene.touch(side("block", sole), side("slope", "top"), law);
        low = [from[0].max(0.0), from[1].max(0.0)];
        high = [to[0].min(w), to[1].min(d)];
    }
    let mut pushes = from_below(low, high, 0.0, mu);
    if let Shape::Column { corners, .. } = &scene.problem.bodies[block].shape {
        let corners = corners.iter();
        let each = corners.map(|&[x, y]| Push {
            at: [x, y, 0.0],
            direction: [0.0, 0.0, 1.0],
            friction: mu,
        });
        pushes = each.collect();
    }
    scene.must_hold(vec![block], pushes, Margin::Sharp, "weight on the slope");
}

/// A column over a polygon about the origin.
fn add_column(scene: &mut Scene, radius: f64, height: f64) -> usize {
    let n = scene.random.count(3, 6);
    let first = scene.random.between(0.0, 1.0);
    let corner = |k: usize| {
        let (s, c) = (TAU * (first + k as f64 / n as f64)).sin_cos();
        [radius * c, radius * s]
    };
    let corners: Vec<[f64; 2]> = (0..n).map(corner).collect();
    let shape = Shape::Column {
        names: vec!["flank"; corners.len()],
        corners,
        size: radius * scene.random.between(0.5, 1.2),
        height,
        layers: 1,
    };
    let kind = scene.random.pick(&[Kind::Prism6, Kind::Prism15]);
    scene.add("block", shape, kind)
}

/// A prism in the groove of two planes, under its weight and drawn along the groove.
pub fn groove(scene: &mut Scene) {
    let count = scene.steps(&[1, 1, 2]);
    let half: f64 = scene.random.between(0.4, 1.2);
    let (h, long) = (
        scene.random.between(0.5, 1.0),
        scene.random.between(0.5, 1.5),
    );
    let a = h * half.tan();
    let blunt = scene.random.chance(0.5);
    // the groove is along z, its bottom along y = 0
    let foot = if blunt { 0.3 } else { 0.0 };
    let mut corners = vec![[foot * a, foot * h], [a, h], [-a, h]];
    let mut names = vec!["right", "top", "left"];
    if blunt {
        corners.push([-foot * a, foot * h]);
        names.push("foot");
    }
    let kind = scene.random.pick(&[Kind::Prism6, Kind::Prism15]);
    let size = h * scene.random.between(0.4, 0.9);
    let layers = scene.random.count(1, 3);
    let shape = Shape::Column {
        corners: corners.clone(),
        names,
        size,
        height: long,
        layers,
    };
    let wedge = scene.add("wedge", shape, kind);
    let mu = [0; 2].map(|_| {
        if scene.random.chance(0.8) {
            scene.coefficient()
        } else {
            0.0
        }
    });
    let mut pushes = Vec::new();
    for ((name, sign), mu) in [("right", 1.0), ("left", -1.0)].into_iter().zip(mu) {
        let along = unit([sign * a, h, 0.0]);
        let normal = cross([0.0, 0.0, sign], along);
        let surface = Surface::Plane {
            point: times(0.7, along),
            normal,
        };
        let law = Law::rubbing(mu);
        scene.stand(side("wedge", name), surface, Drive::Nothing, law);
        for y in [foot * h, h] {
            for z in [0.0, long] {
                let at = [sign * y * half.tan(), y, z];
                pushes.push(Push {
                    at,
                    direction: normal,
                    friction: mu,
                });
            }
        }
    }
    let g = scene.strain;
    let part = mu[0].max(mu[1]) * scene.random.between(0.0, 1.5) / half.sin();
    let time = course(&mut scene.random, count);
    let along = match mu[0].max(mu[1]) > 0.0 {
        true => Number::timed(g * part, time),
        false => Number::default(),
    };
    scene.problem.bodies[wedge].weight = [Number::default(), Number::from(-g), along];
    scene.must_hold(
        vec![wedge],
        pushes,
        Margin::Unknown,
        "statics of the prism in the groove",
    );
}

/// A box in a corner of two or three walls, pressed into it and drawn along.
pub fn corner(scene: &mut Scene) {
    let count = scene.steps(&[1, 1, 3]);
    let size = [0; 3].map(|_| scene.random.between(0.5, 1.3));
    let block = scene.cuboid("block", [0.0; 3], size, 1);
    let walls = scene.random.count(2, 3);
    let mut axes = [0, 1, 2];
    scene.random.shuffle(&mut axes);
    let names = [("left", "right"), ("front", "back"), ("bottom", "top")];
    let mut pushes = Vec::new();
    let p = scene.strain;
    for &axis in &axes[..walls] {
        let mu = if scene.random.chance(0.75) {
            scene.coefficient()
        } else {
            0.0
        };
        let law = Law::rubbing(mu);
        let clear = p * scene.random.pick(&[0.0, 0.0, 0.0, 0.2]);
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        let surface = Surface::Plane {
            point: times(-clear, normal),
            normal,
        };
        scene.stand(side("block", names[axis].0), surface, Drive::Nothing, law);
        let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
        for (s, t) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let mut at = [0.0; 3];
            (at[b], at[c]) = (s * size[b], t * size[c]);
            pushes.push(Push {
                at,
                direction: normal,
                friction: mu,
            });
        }
        // into the wall, and some shear along it
        let mut field = [0; 3].map(|_| {
            let shear = if mu > 0.0 { 0.3 * mu * p } else { 0.0 };
            let time = course(&mut scene.random, count);
            Number::timed(shear * scene.random.between(-1.0, 1.0), time)
        });
        field[axis] = Number::from(-p * scene.random.between(0.2, 1.0));
        scene.pull(block, names[axis].1, field);
    }
    scene.must_hold(
        vec![block],
        pushes,
        Margin::Wide,
        "statics of the box in the corner",
    );
}

/// A box that is held at its bottom, and an obstacle that is pressed on it, drawn along and lifted, or moved by a force.
pub fn mover(scene: &mut Scene) {
    let count = scene.steps(&[1, 2, 3, 5]);
    let [w, d] = [0, 1].map(|_| scene.random.between(0.6, 1.4));
    let h = scene.random.between(0.4, 1.0);
    let block = scene.cuboid("block", [0.0; 3], [w, d, h], 1);
    scene.hold(block, "bottom", Field::default());
    let depth = scene.strain * h;
    let clear = depth * scene.random.pick(&[0.0, 0.0, 0.3]);
    let radius = scene.random.between(0.8, 5.0);
    let over = [
        w * scene.random.between(0.3, 0.7),
        d * scene.random.between(0.3, 0.7),
    ];
    let center = [over[0], over[1], h + clear + radius];
    let surface = match scene.random.count(0, 3) {
        0 => round("", center, radius).1,
        1 => {
            let [x, y] = scene.direction(1.0, [1.0, 1.0]);
            Surface::Cylinder {
                point: center,
                axis: [x, y, 0.0],
                radius,
                inside: false,
            }
        }
        _ => {
            // a little tilted
            let tilt = scene.direction(scene.strain, [-0.3, 0.3]);
            let point = [over[0], over[1], h + clear];
            Surface::Plane {
                point,
                normal: unit([tilt[0], tilt[1], -1.0]),
            }
        }
    };
    let law = match scene.random.chance(0.1) {
        true => Law::Tresca(Number::from(scene.strain * scene.random.between(0.05, 0.4))),
        false => scene.law(0.7),
    };
    if scene.random.chance(0.75) {
        let drive = pressed(scene, depth, count);
        scene.stand(side("block", "top"), surface, drive, law);
        scene.holds("the box is held at its bottom");
        return;
    }
    let force = scene.strain * w * d * 0.3;
    let time = Time::Line(0.1, 1.0 / count as f64);
    let drawn = match &law {
        Law::Coulomb(_) => scene.direction(force * law.coefficient(), [0.0, 0.8]),
        _ => [0.0; 2],
    };
    let force = plus([drawn[0], drawn[1], 0.0], -force, [0.0, 0.0, 1.0]);
    let drive = Drive::Force(force.map(|c| Number::timed(c, time)));
    scene.stand(side("block", "top"), surface, drive, law);
    scene.problem.known = Known::Open;
    scene.problem.reason = "a force presses the obstacle on a box that is held".to_string();
}
