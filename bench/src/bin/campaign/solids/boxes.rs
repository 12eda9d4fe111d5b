//! Boxes on boxes.

use super::{
    Drive, Field, Law, Margin, Number, Scene, Shape, Surface, course, from_below, upwards,
};
use crate::amount::Time;
use crate::cells::Kind;
use crate::problem::{Gap, Known, side};

/// Boxes of one cross-section on each other, pressed evenly: the pressure is the same everywhere, whatever the meshes are.
pub fn uniform(scene: &mut Scene) {
    let [w, d] = [0, 1].map(|_| scene.random.between(0.5, 1.5));
    let n = scene.random.count(1, 3);
    let rigid = scene.random.chance(0.3);
    let rollers = scene.random.chance(0.4);
    let mut z = 0.0;
    for b in 0..n {
        let height = scene.random.between(0.3, 1.0);
        let body = scene.cuboid(&format!("b{b}"), [0.0, 0.0, z], [w, d, z + height], n);
        if rollers {
            scene.roll(body, "left");
            scene.roll(body, "front");
        }
        if b > 0 {
            let (lower, upper) = (format!("b{}", b - 1), format!("b{b}"));
            scene.touch(
                side(&upper, "bottom"),
                side(&lower, "top"),
                Law::Frictionless,
            );
        }
        z += height;
    }
    if rigid || n == 1 {
        let surface = floor(0.0);
        let law = Law::Frictionless;
        scene.stand(side("b0", "bottom"), surface, Drive::Nothing, law);
    } else {
        scene.roll(0, "bottom");
    }
    let p = scene.strain;
    scene.problem.bodies[n - 1].press("top", Number::from(p));
    scene.problem.uniform = Some(Number::from(p));
    scene.holds("boxes of one cross-section under an even pressure");
}

/// A plane that looks upwards.
pub fn floor(z: f64) -> Surface {
    Surface::Plane {
        point: [0.3, 0.2, z],
        normal: [0.0, 0.0, 1.0],
    }
}

/// Boxes on each other that overlap in part, tied, rough or smooth, pressed, drawn and turned.
pub fn stack(scene: &mut Scene) {
    let n = scene.random.count(2, 4);
    let count = scene.steps(&[1, 1, 1, 2, 3]);
    let rigid = scene.random.chance(0.25);
    let matching = scene.random.chance(0.3);
    let mut below = ([0.0, 0.0], [0, 1].map(|_| scene.random.between(0.6, 1.5)));
    let mut z = 0.0;
    let mut smooth = false;
    let mut friction = f64::INFINITY;
    for b in 0..n {
        let (mut low, mut high) = below;
        for d in (0..2).filter(|_| b > 0 && !matching) {
            let size = below.1[d] - below.0[d];
            low[d] = below.0[d] + size * scene.random.between(-0.4, 0.4);
            high[d] = (low[d] + size * scene.random.between(0.5, 1.3)).max(below.0[d] + 0.4 * size);
        }
        let height = scene.random.between(0.2, 0.8);
        let (from, to) = ([low[0], low[1], z], [high[0], high[1], z + height]);
        let body = scene.cuboid(&format!("b{b}"), from, to, n);
        if matching && b > 0 {
            scene.problem.bodies[b].kind = scene.problem.bodies[0].kind;
            let cells = |shape: &mut Shape| match shape {
                Shape::Block { cells, .. } => *cells,
                _ => [1; 3],
            };
            let first = cells(&mut scene.problem.bodies[0].shape);
            if let Shape::Block { cells, .. } = &mut scene.problem.bodies[b].shape {
                (cells[0], cells[1]) = (first[0], first[1]);
            }
        }
        let law = match scene.random.count(0, 9) {
            0 | 1 => Law::Tied,
            _ => scene.law(0.6),
        };
        let mu = law.coefficient();
        let tied = law == Law::Tied;
        if b == 0 && rigid {
            let law = if tied { Law::Frictionless } else { law };
            scene.stand(side("b0", "bottom"), floor(0.0), Drive::Nothing, law);
        } else if b == 0 {
            scene.hold(body, "bottom", Field::default());
        } else {
            let (lower, upper) = (format!("b{}", b - 1), format!("b{b}"));
            scene.touch(side(&upper, "bottom"), side(&lower, "top"), law);
        }
        if (b > 0 && !tied) || (b == 0 && rigid) {
            let at = |d: usize| (low[d].max(below.0[d]), high[d].min(below.1[d]));
            let [x, y] = [at(0), at(1)];
            let pushes = from_below([x.0, y.0], [x.1, y.1], z, mu);
            let above = (b..n).collect();
            scene.must_hold(
                above,
                pushes,
                Margin::Wide,
                "statics of each interface of the stack",
            );
            smooth |= mu == 0.0;
            friction = friction.min(mu);
        }
        (below, z) = ((low, high), z + height);
    }
    let p = scene.strain;
    let (low, high) = below;
    // a pressure that varies over the top moves its resultant
    let slope = [0, 1].map(|d| p * scene.random.between(-0.8, 0.8) / (high[d] - low[d]));
    let constant = p - slope[0] * 0.5 * (low[0] + high[0]) - slope[1] * 0.5 * (low[1] + high[1]);
    let time = match course(&mut scene.random, count) {
        Time::Wave(omega, _) => Time::Wave(0.2 * omega, 0.4),
        other => other,
    };
    let field = Number::new(constant, [slope[0], slope[1], 0.0], time);
    scene.problem.bodies[n - 1].press("top", field);
    if !smooth || scene.random.chance(0.05) {
        let part = if friction.is_finite() { friction } else { 1.0 };
        let [x, y] = scene.direction(part * p, [0.1, 1.2]);
        let field = [
            Number::timed(x, time),
            Number::timed(y, time),
            Number::default(),
        ];
        scene.pull(n - 1, "top", field);
    }
    for b in 0..n {
        if scene.random.chance(0.3) {
            scene.problem.bodies[b].weight = upwards(-p * scene.random.between(0.0, 1.0));
        }
    }
}

/// Two pillars on a floor or on a plane, and a lintel over both; some of the contacts are tied.
pub fn bridge(scene: &mut Scene) {
    scene.steps(&[1, 1, 2]);
    let span = scene.random.between(1.0, 1.8);
    let h = scene.random.between(0.3, 0.8);
    let rigid = scene.random.chance(0.5);
    let clear = match scene.random.chance(0.5) {
        true => scene.strain * scene.random.between(0.0, 0.5),
        false => 0.0,
    };
    let wide = scene.random.between(0.3, 0.5);
    for (name, x, top) in [("left", 0.0, h), ("right", span - wide, h - clear)] {
        let deep = scene.random.between(0.4, 0.8);
        scene.cuboid(name, [x, 0.1, 0.0], [x + wide, 0.1 + deep, top], 4);
    }
    let thick = scene.random.between(0.2, 0.4);
    scene.cuboid("lintel", [-0.1, 0.0, h], [span + 0.1, 1.0, h + thick], 3);
    let rough = scene.random.chance(0.6);
    let laws = [0; 4].map(|_| match scene.random.chance(0.15) {
        true => Law::Tied,
        false => scene.law(if rough { 1.0 } else { 0.0 }),
    });
    if rigid {
        for (b, name) in ["left", "right"].into_iter().enumerate() {
            scene.hold(b, "bottom", Field::default());
            scene.touch(side("lintel", "bottom"), side(name, "top"), laws[b].clone());
        }
    } else {
        let floor = scene.cuboid("floor", [-0.2, -0.2, -0.4], [span + 0.2, 1.2, 0.0], 3);
        scene.hold(floor, "bottom", Field::default());
        for (b, name) in ["left", "right"].into_iter().enumerate() {
            scene.touch(
                side(name, "bottom"),
                side("floor", "top"),
                laws[2 + b].clone(),
            );
            scene.touch(side("lintel", "bottom"), side(name, "top"), laws[b].clone());
        }
    }
    for contact in &mut scene.problem.contacts {
        // the clearance of ties counts, too
        if contact.law == Law::Tied {
            contact.gap = Gap::Closed;
        }
    }
    let p = scene.strain;
    scene.problem.bodies[2].weight = upwards(-p * scene.random.between(0.2, 1.0));
    let time = Time::Line(0.0, 1.0);
    if rough && scene.random.chance(0.5) {
        let [x, y] = scene.direction(0.02 * p, [0.1, 1.0]);
        let field = [
            Number::timed(x, time),
            Number::timed(y, time),
            Number::default(),
        ];
        scene.pull(2, "top", field);
    }
    if !rough && laws.iter().all(|law| *law == Law::Frictionless) {
        scene.problem.known = Known::Open;
    }
}

/// A box on another, pressed, drawn along paths that turn, drawn back and lifted; held by its top or loaded there.
pub fn history(scene: &mut Scene) {
    let count = scene.steps(&[2, 3, 4, 6]);
    let [w, d] = [0, 1].map(|_| scene.random.between(0.6, 1.4));
    let [low, h] = [0, 1].map(|_| scene.random.between(0.3, 0.8));
    let out = [0, 1].map(|_| scene.random.between(-0.3, 0.4));
    let rigid = scene.random.chance(0.3);
    let upper = scene.cuboid("upper", [0.0, 0.0, 0.0], [w, d, h], 2);
    let mu = scene.coefficient();
    let law = match scene.random.chance(0.15) {
        true => Law::Tresca(Number::from(scene.strain * scene.random.between(0.05, 0.4))),
        false => Law::Coulomb(Number::from(mu)),
    };
    let coulomb = matches!(law, Law::Coulomb(_));
    if rigid {
        scene.stand(side("upper", "bottom"), floor(0.0), Drive::Nothing, law);
    } else {
        let (from, to) = ([-out[0], -out[1], -low], [w + 0.2, d + 0.3, 0.0]);
        let lower = scene.cuboid("lower", from, to, 2);
        scene.hold(lower, "bottom", Field::default());
        scene.touch(side("upper", "bottom"), side("lower", "top"), law);
    }
    let p = scene.strain;
    if scene.random.chance(0.6) {
        let [x, y] = scene.path(p * h, [0.3, 2.0], count);
        let down = match scene.random.chance(0.3) {
            // pressed, and lifted at last
            true => Number::timed(-p * h, Time::Wave(3.3 / count as f64, 0.0)),
            false => Number::from(-p * h),
        };
        scene.hold(upper, "top", [x, y, down]);
        scene.holds("the box is held at its top");
        return;
    }
    let [x, y] = scene.path(p * mu, [0.2, 0.95], count);
    scene.pull(upper, "top", [x, y, Number::from(-p)]);
    if coulomb {
        let at = if rigid {
            [0.0; 2]
        } else {
            [(-out[0]).max(0.0), (-out[1]).max(0.0)]
        };
        let pushes = from_below(at, [w, d], 0.0, mu);
        scene.must_hold(
            vec![upper],
            pushes,
            Margin::Wide,
            "statics of the box on the other",
        );
    }
}

/// Sides of a box behind and before the neighbour along each axis.
const SIDES: [[&str; 2]; 3] = [["left", "right"], ["front", "back"], ["bottom", "top"]];

/// Boxes of random size between planes at random places, on a floor and within walls, each of its own material and weight,
/// pressed from above: many boxes that clamp each other in many ways.
pub fn crowd(scene: &mut Scene) {
    let rows = [
        [3, 3, 2],
        [2, 3, 3],
        [4, 2, 2],
        [3, 3, 3],
        [4, 3, 2],
        [2, 2, 5],
    ];
    let rows = scene.random.pick(&rows);
    let division = scene.random.count(1, 2);
    let rough = scene.random.magnitude(0.05, 0.8);
    let planes = rows.map(|row| {
        let mut planes = vec![0.0];
        for _ in 0..row {
            let last = planes[planes.len() - 1];
            planes.push(last + scene.random.between(0.5, 1.5));
        }
        planes
    });
    let place = |i: [usize; 3]| (i[2] * rows[1] + i[1]) * rows[0] + i[0];
    let count = rows.iter().product();
    let all = (0..count).map(|k| [k % rows[0], k / rows[0] % rows[1], k / rows[0] / rows[1]]);
    let p = scene.strain;
    for i in all.clone() {
        let [from, to] = [0, 1].map(|end| std::array::from_fn(|d| planes[d][i[d] + end]));
        let cells = [division; 3];
        let name = format!("b{}", place(i));
        let shape = Shape::Block {
            from,
            to,
            cells,
            diagonals: "",
        };
        let body = scene.add(&name, shape, Kind::Hex8);
        scene.problem.bodies[body].weight = upwards(-p * scene.random.between(0.0, 0.5));
        if i[2] + 1 == rows[2] && scene.random.chance(0.7) {
            let field = Number::from(p * scene.random.between(0.1, 1.0));
            scene.problem.bodies[body].press("top", field);
        }
    }
    for i in all {
        let name = format!("b{}", place(i));
        for (axis, [behind, before]) in SIDES.into_iter().enumerate() {
            let mut law = || match scene.random.chance(0.9) {
                true => Law::Coulomb(Number::from(scene.random.between(0.0, rough))),
                false => Law::Frictionless,
            };
            let (first, second) = (law(), law());
            let wall = |at: f64, sign: f64| {
                let axes =
                    |value: f64| std::array::from_fn(|d| if d == axis { value } else { 0.0 });
                Surface::Plane {
                    point: axes(at),
                    normal: axes(sign),
                }
            };
            if i[axis] == 0 {
                scene.stand(side(&name, behind), wall(0.0, 1.0), Drive::Nothing, first);
            }
            if i[axis] + 1 < rows[axis] {
                let mut next = i;
                next[axis] += 1;
                let next = format!("b{}", place(next));
                scene.touch(side(&name, before), side(&next, behind), second);
            } else if axis < 2 {
                let wall = wall(planes[axis][rows[axis]], -1.0);
                scene.stand(side(&name, before), wall, Drive::Nothing, second);
            }
        }
    }
    scene.holds("each column stands on the floor");
}

/// The drive of an obstacle that presses from above.
pub fn pressed(scene: &mut Scene, depth: f64, count: usize) -> Drive {
    let [x, y] = scene.path(depth, [0.3, 4.0], count);
    let down = match scene.random.count(0, 2) {
        0 => Number::from(-depth),
        1 => Number::timed(-depth, Time::Line(0.0, 1.0 / count as f64)),
        _ => Number::timed(-depth, Time::Wave(3.3 / count as f64, 0.0)),
    };
    Drive::Displacement([x, y, down])
}
