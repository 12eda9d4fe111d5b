//! Blocks near the limit of sliding or tipping, on either side of it.

use super::{Push, Scene, course, from_below, wrench};
use crate::amount::{Amount, Time};
use crate::plane::rotated;
use crate::problem::{Drive, Edge, Law, Shape, Surface, clamp, moved, on, side, steps};
use crate::statics::beside_limit;
use crate::vector::{dot, minus, times};

/// A block in a corner of two planes or two bodies, pressed into it, with friction on both faces, one, or neither.
pub fn corner(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.5, 1.5),
    );
    let count = scene.random.pick(&[1, 1, 3]);
    scene.problem.times = steps(count);
    scene.block("block", [0.0, 0.0], [w, h], 1);
    let mu = [0, 1].map(|_| {
        let rough = scene.random.chance(0.75);
        if rough { scene.coefficient() } else { 0.0 }
    });
    let bodies = scene.random.chance(0.3);
    if bodies {
        scene.block("floor", [0.0, -0.5], [w + 0.3, 0.0], 2);
        scene.block("wall", [-0.5, 0.0], [0.0, h + 0.2], 2);
        scene.problem.bodies[1].supports.push(clamp(on("bottom")));
        scene.problem.bodies[2].supports.push(clamp(on("left")));
        scene.touch(
            side("block", "bottom"),
            side("floor", "top"),
            Law::rubbing(mu[0]),
        );
        scene.touch(
            side("block", "left"),
            side("wall", "right"),
            Law::rubbing(mu[1]),
        );
    } else {
        let planes = [([0.0, 1.0], "bottom"), ([1.0, 0.0], "left")];
        let mut order = [0, 1];
        scene.random.shuffle(&mut order);
        for k in order {
            let (normal, name) = planes[k];
            let surface = Surface::Plane {
                point: [0.0, 0.0],
                normal,
            };
            scene.stand(
                side("block", name),
                surface,
                Drive::Nothing,
                Law::rubbing(mu[k]),
            );
        }
    }
    let course_top = course(&mut scene.random, count);
    let pushes = [0, 1, 2].map(|_| scene.strain * scene.random.between(0.05, 1.0));
    let body = &mut scene.problem.bodies[0];
    body.pull("top", [Amount::default(), Amount::from(-pushes[0])]);
    let along = scene.random.between(-0.5, 0.5) * pushes[2];
    let time = match course_top {
        Time::Wave(a, b) => Time::Wave(a, b),
        _ => Time::Always,
    };
    body.pull(
        "right",
        [Amount::from(-pushes[1]), Amount::timed(along, time)],
    );
    let wall = |y: f64| Push {
        at: [0.0, y],
        direction: [1.0, 0.0],
        friction: mu[1],
    };
    let mut pushes = from_below([0.0, w], 0.0, mu[0]);
    pushes.extend([wall(0.0), wall(h)]);
    let parts = [(scene.loads(0), pushes)];
    scene.judge(&parts, "statics of the block in the corner");
}

/// The ground of a single block: a rigid plane or a clamped body with a coarser or finer mesh.
fn place(scene: &mut Scene, w: f64, h: f64, law: Law) {
    let coarse = scene.random.magnitude(0.2, 5.0);
    let cells = scene.random.count(2, 16);
    let kind = scene.kind();
    let up = ((cells as f64 * h / w) as usize).clamp(1, 40);
    scene.rectangle("block", [0.0, 0.0], [w, h], [cells, up], kind);
    if scene.random.chance(0.3) {
        let surface = Surface::Plane {
            point: [0.3, 0.0],
            normal: [0.0, 1.0],
        };
        scene.stand(side("block", "bottom"), surface, Drive::Nothing, law);
        return;
    }
    // at either end the floor reaches beyond the block, or ends below it
    let left = scene.random.between(-0.5, 0.3) * w;
    let right = w + scene.random.between(-0.3, 0.5) * w;
    let cell = coarse * w / cells as f64;
    let along = (((right - left) / cell).round() as usize).clamp(1, 80);
    let deep = scene.random.between(0.3, 1.0);
    let down = ((deep / cell).round() as usize).clamp(1, 20);
    let kind = scene.kind();
    scene.rectangle("floor", [left, -deep], [right, 0.0], [along, down], kind);
    scene.problem.bodies[1].supports.push(clamp(on("bottom")));
    scene.touch(side("block", "bottom"), side("floor", "top"), law);
}

/// The part of the block's sole that faces the ground.
fn sole(scene: &Scene, w: f64) -> [f64; 2] {
    match scene.problem.bodies.get(1).map(|floor| &floor.shape) {
        Some(Shape::Block { from, to, .. }) => [from[0].max(0.0), to[0].min(w)],
        _ => [0.0, w],
    }
}

/// A block whose load acts very near its edge, inside or outside.
pub fn tip(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.5, 1.5),
    );
    let rough = scene.random.chance(0.5);
    let mu = if rough {
        scene.random.between(0.4, 1.0)
    } else {
        0.0
    };
    let law = Law::rubbing(mu);
    place(scene, w, h, law);
    let [a, b] = sole(scene, w);
    let lever = beside_limit(&mut scene.random) * scene.random.sign() * 0.5 * (b - a);
    // a uniform pressure on the top, its resultant moved by a linear part: p (1 + s (x − w/2)), shift = s w²/12
    let shift = 0.5 * (a + b) + lever - 0.5 * w;
    let p = scene.strain;
    let slope = p * shift * 12.0 / (w * w);
    let field = Amount::new(p - 0.5 * slope * w, [slope, 0.0], Time::Always);
    let body = &mut scene.problem.bodies[0];
    body.press("top", field);
    let parts = [(scene.loads(0), from_below([a, b], 0.0, mu))];
    scene.judge_sharply(&parts, "the resultant beside the edge of the sole");
}

/// A block drawn with a little less or a little more than the largest friction force, its resultant well inside its sole.
pub fn slide(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.8, 1.5),
        scene.random.between(0.2, 0.6),
    );
    let mu = scene.random.between(0.05, 0.6);
    let count = scene.random.pick(&[1, 1, 3]);
    scene.problem.times = steps(count);
    place(scene, w, h, Law::Coulomb(Amount::from(mu)));
    let [a, b] = sole(scene, w);
    let p = scene.strain;
    let part = beside_limit(&mut scene.random) * scene.random.sign();
    let draw = part * mu * p;
    let time = if count == 1 {
        Time::Always
    } else {
        Time::Line(0.0, 1.0 / count as f64)
    };
    let middle = 0.5 * (a + b) - 0.5 * w;
    // the shear of a uniform state on all sides keeps the resultant where it is
    let slope = p * middle * 12.0 / (w * w);
    let field = Amount::new(-(p - 0.5 * slope * w), [-slope, 0.0], Time::Always);
    let shear = Amount::timed(draw, time);
    let body = &mut scene.problem.bodies[0];
    body.pull("top", [shear.clone(), field]);
    for (name, sign) in [("right", 1.0), ("left", -1.0)] {
        body.pull(name, [Amount::default(), shear.times(sign)]);
    }
    let parts = [(scene.loads(0), from_below([a, b], 0.0, mu))];
    scene.judge_sharply(&parts, "the draw beside the limit of friction");
}

/// A block on an inclined plane, under its weight.
pub fn incline(scene: &mut Scene) {
    let mu = scene.random.between(0.1, 1.0);
    let angle = (beside_limit(&mut scene.random) * mu).atan() * scene.random.sign();
    let (w, h) = (1.0, scene.random.between(0.2, 1.2));
    let corners = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(|x| rotated(x, angle));
    let names = ["sole", "right", "top", "left"];
    let edges = (0..4)
        .map(|k| Edge {
            to: corners[(k + 1) % 4],
            name: names[k],
            center: None,
            cells: (k == 0).then(|| scene.random.count(2, 12)),
        })
        .collect();
    let kind = scene
        .random
        .pick(&[crate::cells::Kind::Tri3, crate::cells::Kind::Tri6]);
    let size = scene.cell_length(w * h, 1, kind).clamp(0.05, 0.5);
    let shape = Shape::Outline {
        size,
        from: corners[0],
        edges,
    };
    scene.add("block", shape, kind);
    let normal = rotated([0.0, 1.0], angle);
    let law = Law::Coulomb(Amount::from(mu));
    let surface = Surface::Plane {
        point: times(0.3, corners[1]),
        normal,
    };
    scene.stand(side("block", "sole"), surface, Drive::Nothing, law);
    let weight = scene.strain;
    scene.problem.bodies[0].weight[1] = Amount::from(-weight);
    let middle = times(0.5, crate::vector::plus(corners[0], 1.0, corners[2]));
    let force = [0.0, -weight * w * h];
    let push = |at| Push {
        at,
        direction: normal,
        friction: mu,
    };
    debug_assert!(dot(normal, minus(middle, corners[0])) > 0.0);
    let parts = [(
        vec![wrench(middle, force)],
        vec![push(corners[0]), push(corners[1])],
    )];
    scene.judge_sharply(&parts, "weight on the incline");
}

/// A block pressed and drawn to and fro against a bound of shear.
pub fn tresca(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    let count = scene.random.pick(&[1, 3, 5, 6]);
    scene.problem.times = steps(count);
    let bound = scene.strain * scene.random.between(0.05, 0.5);
    place(scene, w, h, Law::Tresca(Amount::from(bound)));
    let stroke = scene.strain * h * scene.random.between(0.3, 3.0);
    let time = match count {
        1 => Time::Always,
        _ => Time::Wave(scene.random.between(0.7, 2.0), 0.3),
    };
    let pressed = scene.random.chance(0.5);
    let body = &mut scene.problem.bodies[0];
    if pressed {
        body.supports
            .push(moved(on("left"), 0, Amount::timed(stroke, time)));
        body.press("top", Amount::from(scene.strain));
    } else {
        body.supports
            .push(moved(on("top"), 0, Amount::timed(stroke, time)));
        body.supports
            .push(moved(on("top"), 1, Amount::from(-scene.strain * h)));
    }
    scene.holds("the block is held across, and pressed down");
}
