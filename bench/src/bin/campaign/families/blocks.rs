//! Rectangles on, beside and in each other.

use super::{Scene, course, from_below};
use crate::amount::{Amount, Time};
use crate::problem::{
    Drive, Gap, Law, Load, Patch, Place, Surface, clamp, hold, moved, on, side, steps,
};
use crate::statics::both;

/// The support of the lowest block.
fn ground(scene: &mut Scene, name: &str, y: f64, law: Law) {
    let surface = if scene.random.chance(0.5) {
        Surface::Plane {
            point: [0.0, y],
            normal: [0.0, 1.0],
        }
    } else {
        Surface::Gap(Amount::from(0.0))
    };
    scene.stand(side(name, "bottom"), surface, Drive::Nothing, law);
}

/// A pressure on a side that may vary along it, a history of the problem's steps.
fn press(scene: &mut Scene, largest: f64, from: f64, to: f64) -> Amount {
    let n = scene.problem.times.len();
    let time = match course(&mut scene.random, n) {
        Time::Wave(..) => Time::Line(0.3, 0.7 / n as f64),
        other => other,
    };
    let tilt = if scene.random.chance(0.5) {
        scene.random.between(-0.6, 0.6)
    } else {
        0.0
    };
    // p (1 + tilt (2 (x − from)/(to − from) − 1))
    let slope = 2.0 * tilt * largest / (to - from);
    Amount::new(largest * (1.0 - tilt) - slope * from, [slope, 0.0], time)
}

/// Boxes on top of each other, 1 to 12 high, as wide as each other or not, guided, pinned, rough or free to move across.
pub fn stack(scene: &mut Scene) {
    let high = scene.random.count(1, 12);
    let equal = scene.random.chance(0.4);
    let rough = scene.random.chance(0.4);
    let guided = !rough && scene.random.chance(0.4);
    let on_clamped = high > 1 && scene.random.chance(0.4);
    let count = scene.random.pick(&[1, 1, 2, 4]);
    scene.problem.times = steps(count);
    // a small clearance between the boxes, a small interference, or neither
    let air = scene.strain * scene.random.pick(&[0.0, 0.0, 0.0, 0.3, -0.3]);
    let mut y = 0.0;
    let mut boxes: Vec<([f64; 2], f64)> = Vec::new();
    let matching = equal && scene.random.chance(0.5);
    let kind = scene.kind();
    let along = scene.random.count(2, 10);
    for k in 0..high {
        let name = format!("b{k}");
        let (w, h) = if equal {
            (1.0, scene.random.between(0.3, 1.0))
        } else {
            (
                scene.random.between(0.5, 1.5),
                scene.random.between(0.3, 1.0),
            )
        };
        let left = if equal {
            0.0
        } else {
            scene.random.between(-0.15, 0.15) - 0.5 * w
        };
        let (from, to) = ([left, y], [left + w, y + h]);
        if matching {
            let up = ((along as f64 * h).round() as usize).max(1);
            scene.rectangle(&name, from, to, [along, up], kind);
        } else {
            scene.block(&name, from, to, high);
        }
        boxes.push(([left, left + w], y));
        y += h + air * scene.random.unit();
    }
    let top = high - 1;
    let [left, right] = boxes[top].0;
    let load = press(scene, scene.strain, left, right);
    let body = &mut scene.problem.bodies[top];
    body.press("top", load.clone());
    if scene.random.chance(0.4) {
        let weight = scene.strain * scene.random.between(0.1, 1.0);
        let bodies = scene.problem.bodies.iter_mut();
        bodies.for_each(|b| b.weight[1] = Amount::from(-weight));
    }
    let mut coefficients = Vec::new();
    for k in 0..high {
        let law = if rough {
            scene.law(1.0)
        } else {
            Law::Frictionless
        };
        coefficients.push(law.coefficient());
        if k > 0 {
            let (above, below) = (format!("b{k}"), format!("b{}", k - 1));
            scene.touch(side(&above, "bottom"), side(&below, "top"), law);
        } else if on_clamped {
            scene.problem.bodies[0].supports.push(clamp(on("bottom")));
        } else {
            ground(scene, "b0", 0.0, law);
        }
    }
    if rough && scene.random.chance(0.7) {
        let push = scene.strain * scene.random.between(-0.3, 0.3);
        let time = course(&mut scene.random, scene.problem.times.len());
        scene.problem.bodies[top].pull("top", [Amount::timed(push, time), Amount::default()]);
    }
    let first = scene.problem.bodies[0].thickness;
    let plain = |b: &crate::problem::Body| b.weight[1].is_zero() && b.thickness == first;
    let plain = scene.problem.bodies.iter().all(plain);
    if let ([load], true) = (&load.0[..], equal && plain && !rough && !on_clamped) {
        // a column under even pressure without friction: the same uniaxial stress in all boxes
        scene.problem.uniform = (load.slope == [0.0; 2]).then(|| Amount(vec![load.clone()]));
    }
    if guided {
        for body in &mut scene.problem.bodies {
            body.supports.push(hold(on("left"), 0));
        }
        scene.holds("every box is guided along its left side and pressed down");
        return;
    }
    if !rough && scene.random.chance(0.5) {
        for (body, &([x, _], y)) in scene.problem.bodies.iter_mut().zip(&boxes) {
            body.supports.push(hold(Place::Point([x, y]), 0));
        }
    }
    // statics of every interface: all loads above it
    let mut above: Vec<_> = scene
        .problem
        .times
        .iter()
        .map(|_| ([0.0; 2], [0.0; 3]))
        .collect();
    let mut parts = Vec::new();
    for k in (0..high).rev() {
        let own = scene.loads(k);
        above
            .iter_mut()
            .zip(own)
            .for_each(|(a, o)| *a = both(*a, o));
        let ([a, b], y) = boxes[k];
        let interval = match k {
            0 if on_clamped => continue,
            0 => [a, b],
            _ => [a.max(boxes[k - 1].0[0]), b.min(boxes[k - 1].0[1])],
        };
        parts.push((above.clone(), from_below(interval, y, coefficients[k])));
    }
    scene.judge(&parts, "statics of every interface of the tower");
}

/// Boxes side by side between two walls, with clearances and interferences, the walls moving.
pub fn chain(scene: &mut Scene) {
    let n = scene.random.count(1, 8);
    let count = scene.random.pick(&[1, 1, 3, 5]);
    scene.problem.times = steps(count);
    let mut x = 0.0;
    let height = scene.random.between(0.5, 1.5);
    let clearance = scene.strain * scene.random.pick(&[0.0, 0.1, 0.5]);
    for k in 0..n {
        let name = format!("b{k}");
        let w = scene.random.between(0.3, 1.2);
        let gap = if k > 0 {
            clearance * scene.random.between(-1.0, 1.0)
        } else {
            0.0
        };
        // a gap in the coordinates, or by a number below
        let body = scene.block(&name, [x, 0.0], [x + w, height], n);
        scene.problem.bodies[body]
            .supports
            .push(hold(on("bottom"), 1));
        x += w;
        if k > 0 {
            let law = scene.varied_law(0.3);
            let c = scene.touch(
                side(&format!("b{}", k - 1), "right"),
                side(&name, "left"),
                law,
            );
            if gap != 0.0 {
                // open at one end, mostly
                let slope = gap * scene.random.pick(&[0.0, 0.0, 0.5, -1.0]) / height;
                let gap = Amount::new(gap, [0.0, slope], Time::Always);
                scene.problem.contacts[c].gap = Gap::Given(gap);
            }
        }
    }
    let stroke = scene.strain * x * scene.random.between(0.3, 2.0);
    let time = course(&mut scene.random, count);
    let law = scene.law(0.3);
    scene.stand(
        side("b0", "left"),
        Surface::Plane {
            point: [0.0, 0.0],
            normal: [1.0, 0.0],
        },
        Drive::Displacement([Amount::timed(stroke, time), Amount::default()]),
        law,
    );
    let last = format!("b{}", n - 1);
    if scene.random.chance(0.5) {
        let law = scene.law(0.3);
        let surface = if scene.random.chance(0.5) {
            Surface::Gap(Amount::from(clearance * scene.random.unit()))
        } else {
            Surface::Plane {
                point: [x, 0.0],
                normal: [-1.0, 0.0],
            }
        };
        scene.stand(side(&last, "right"), surface, Drive::Nothing, law);
    } else {
        scene.problem.bodies[n - 1]
            .supports
            .push(hold(on("right"), 0));
    }
    scene.holds("walls press or leave, no load acts");
}

/// Courses of bricks, each on two below, half bricks at the ends, with or without joints that touch.
pub fn masonry(scene: &mut Scene) {
    let (courses, wide) = (scene.random.count(2, 4), scene.random.count(2, 3));
    let (w, h) = (1.0, scene.random.between(0.3, 0.6));
    let joints = scene.random.chance(0.6);
    let rough = scene.random.chance(0.5);
    let total = courses * (wide + 1);
    let matching = scene.random.chance(0.5);
    // bricks side by side without a joint stand apart: otherwise they would penetrate, and there is no answer
    let joints = joints || matching;
    let apart = if joints { 0.0 } else { 0.05 * w };
    let (kind, along) = (scene.kind(), 2 * scene.random.count(1, 3));
    let mut rows: Vec<Vec<(String, [f64; 2])>> = Vec::new();
    for j in 0..courses {
        let mut row = Vec::new();
        let mut x = 0.0;
        let mut index = 0;
        while x < wide as f64 * w - 1e-9 {
            let half = j % 2 == 1 && (index == 0 || x + w > wide as f64 * w + 1e-9);
            let width = if half { 0.5 * w } else { w };
            let name = format!("b{j}x{index}");
            let (from, to) = ([x, j as f64 * h], [x + width - apart, (j + 1) as f64 * h]);
            if matching {
                let cells = ((along as f64 * width).round() as usize).max(1);
                scene.rectangle(&name, from, to, [cells, 2], kind);
            } else {
                scene.block(&name, from, to, total);
            }
            row.push((name, [x, x + width]));
            x += width;
            index += 1;
        }
        rows.push(row);
    }
    let weight = scene.strain * scene.random.between(0.2, 1.0);
    scene
        .problem
        .bodies
        .iter_mut()
        .for_each(|b| b.weight[1] = Amount::from(-weight));
    let law = if rough {
        scene.law(1.0)
    } else {
        Law::Frictionless
    };
    for j in 0..courses {
        for (name, [a, b]) in rows[j].clone() {
            if j == 0 {
                let body = scene.problem.body(&name);
                scene.problem.bodies[body]
                    .supports
                    .push(clamp(on("bottom")));
                continue;
            }
            for (below, [c, d]) in rows[j - 1].clone() {
                if b.min(d) - a.max(c) > 1e-9 {
                    scene.touch(side(&name, "bottom"), side(&below, "top"), law.clone());
                }
            }
        }
        for k in 1..rows[j].len() {
            if joints {
                let (a, b) = (rows[j][k - 1].0.clone(), rows[j][k].0.clone());
                let law = if rough {
                    scene.law(0.5)
                } else {
                    Law::Frictionless
                };
                scene.touch(side(&a, "right"), side(&b, "left"), law);
            }
        }
    }
    if scene.random.chance(0.6) {
        let p = Amount::from(scene.strain);
        for (name, _) in rows[courses - 1].clone() {
            let body = scene.problem.body(&name);
            scene.problem.bodies[body].press("top", p.clone());
        }
    }
    scene.holds("uniform vertical pressure holds every brick");
}

/// A punch on a wider block, its load inside its sole.
pub fn punch(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 2, 4]);
    scene.problem.times = steps(count);
    let width = scene.random.between(0.3, 1.2);
    let left = scene.random.between(0.2, 1.8 - width);
    let deep = scene.random.between(0.5, 1.0);
    scene.block("block", [0.0, 0.0], [2.0, deep], 2);
    let high = scene.random.between(0.3, 0.8);
    scene.block("punch", [left, deep], [left + width, deep + high], 2);
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    let load = press(scene, scene.strain, left, left + width);
    let punch = &mut scene.problem.bodies[1];
    punch.press("top", load);
    let mut top = "top".to_string();
    if scene.random.chance(0.4) {
        top = "part".to_string();
        scene.problem.bodies[0].patches.push(Patch {
            name: top.clone(),
            of: "top",
            low: [left - 0.4, deep - 0.1],
            high: [left + width + 0.4, deep + 0.1],
        });
        if let crate::problem::Shape::Block { cells, .. } = &mut scene.problem.bodies[0].shape {
            cells[0] = cells[0].max(8);
        }
    }
    let law = scene.law(0.5);
    let friction = law.coefficient();
    let c = scene.touch(side("punch", "bottom"), side("block", &top), law);
    let style = scene.random.count(0, 2);
    if style == 0 {
        scene.problem.bodies[1].supports.push(hold(on("left"), 0));
        scene.holds("the punch is guided and pressed down");
        if scene.random.chance(0.15) {
            // pressed first, pulled in the last step
            let count = scene.problem.times.len() as f64;
            let (a, b) = if count == 1.0 {
                (-1.0, 0.0)
            } else {
                (1.0, -1.2 / count)
            };
            scene.problem.bodies[1].loads = vec![Load::Pressure {
                side: "top".to_string(),
                field: Amount::timed(scene.strain, Time::Line(a, b)),
            }];
            scene.problem.known = crate::problem::Known::Falls;
            scene.problem.reason = "the punch is pulled away".to_string();
        }
        return;
    }
    if friction == 0.0 && style == 1 {
        scene.problem.bodies[1]
            .supports
            .push(hold(Place::Point([left, deep]), 0));
    }
    if friction > 0.0 {
        let push = scene.strain * friction * scene.random.between(-0.8, 0.8);
        let time = course(&mut scene.random, count);
        scene.problem.bodies[1].pull("top", [Amount::timed(push, time), Amount::default()]);
    }
    if scene.random.chance(0.2) {
        scene.problem.contacts[c].gap = Gap::Geometric;
    }
    let parts = [(
        scene.loads(1),
        from_below([left, left + width], deep, friction),
    )];
    scene.judge(&parts, "statics of the punch");
}

/// A slender beam over several supports, some lower than others.
pub fn beam(scene: &mut Scene) {
    let n = scene.random.count(2, 4);
    let long = scene.random.between(4.0, 12.0);
    let deep = scene.random.between(0.3, 0.8);
    let kind = scene.kind();
    let cell = scene.cell_length(long * deep, 2, kind).min(deep);
    let along = ((long / cell) as usize).clamp(8, 150);
    let through = ((deep / cell) as usize).clamp(1, 8);
    scene.rectangle("beam", [0.0, 0.0], [long, deep], [along, through], kind);
    // the beam bends by about strain · long² / deep
    let lower = scene.strain * long * long / deep;
    let mut places: Vec<f64> = (0..n)
        .map(|k| long * (k as f64 + scene.random.between(0.1, 0.9)) / n as f64)
        .collect();
    let half = scene.random.between(0.5, 1.5) * long / along as f64;
    let blocks = scene.random.chance(0.5);
    // blocks stand apart
    let half = match blocks {
        true => half.min(0.09 * long / n as f64),
        false => half,
    };
    places[0] = places[0].max(1.1 * half);
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    let mut order: Vec<usize> = (0..n).collect();
    scene.random.shuffle(&mut order);
    for k in order {
        let x = places[k].min(long - 1.1 * half);
        let gap = if k > 0 && k + 1 < n {
            lower * scene.random.between(0.0, 0.3)
        } else {
            0.0
        };
        let law = scene.law(0.2);
        if blocks {
            let name = format!("s{k}");
            let b = scene.block(&name, [x - half, -0.5], [x + half, 0.0], 2 * n);
            scene.problem.bodies[b].supports.push(clamp(on("bottom")));
            let c = scene.touch(side("beam", "bottom"), side(&name, "top"), law);
            if gap > 0.0 {
                scene.problem.contacts[c].gap = Gap::Given(Amount::from(gap));
            }
            ends = [ends[0].min(x - half), ends[1].max(x + half)];
        } else {
            let name = format!("p{k}");
            let (low, high) = ([x - 1.1 * half, -0.1], [x + 1.1 * half, 0.1]);
            scene.problem.bodies[0].patches.push(Patch {
                name: name.clone(),
                of: "bottom",
                low,
                high,
            });
            let cell = long / along as f64;
            let first = (low[0] / cell).ceil() * cell;
            let last = (high[0] / cell).floor() * cell;
            if last - first < 0.9 * cell {
                let patch = scene.problem.bodies[0].patches.last_mut();
                patch
                    .into_iter()
                    .for_each(|p| (p.low[0], p.high[0]) = (x - 1.05 * cell, x + 1.05 * cell));
            }
            let surface = Surface::Gap(Amount::from(gap));
            scene.stand(side("beam", &name), surface, Drive::Nothing, law);
            ends = [ends[0].min(x), ends[1].max(x)];
        }
    }
    let p = scene.strain * (deep / long).powi(2);
    let corner = Place::Point([0.0, 0.0]);
    scene.problem.bodies[0].supports.push(hold(corner, 0));
    let at = scene.random.between(ends[0], ends[1]);
    let node = (at / long * along as f64).round() / along as f64 * long;
    let force = -p * long * scene.random.between(0.2, 1.0);
    let beam = &mut scene.problem.bodies[0];
    let thickness = beam.thickness;
    beam.loads.push(Load::Force {
        point: [node, deep],
        field: [Amount::default(), Amount::from(force * thickness)],
    });
    if scene.random.chance(0.7) {
        let beam = &mut scene.problem.bodies[0];
        beam.weight[1] = Amount::from(-p / deep);
    }
    let parts = [(scene.loads(0), from_below(ends, 0.0, 0.0))];
    scene.judge(&parts, "statics of the beam");
    if scene.problem.known == crate::problem::Known::Falls {
        scene.problem.known = crate::problem::Known::Open;
    }
}

/// Blocks glued below each other hang from a ceiling; the lowest may meet a floor.
pub fn hanging(scene: &mut Scene) {
    let n = scene.random.count(1, 4);
    let mut y = 0.0;
    let mut above = String::new();
    let mut length = 0.0;
    for k in 0..=n {
        let name = format!("h{k}");
        let (w, h) = (
            scene.random.between(0.5, 1.2),
            scene.random.between(0.3, 1.0),
        );
        let x = scene.random.between(-0.2, 0.2);
        let body = scene.block(&name, [x - 0.5 * w, y - h], [x + 0.5 * w, y], n + 1);
        if k == 0 {
            scene.problem.bodies[body].supports.push(clamp(on("top")));
        } else {
            scene.touch(side(&above, "bottom"), side(&name, "top"), Law::Tied);
        }
        scene.problem.bodies[body].weight[1] = Amount::from(-scene.strain);
        above = name;
        y -= h;
        length += h;
    }
    if scene.random.chance(0.5) {
        let body = &mut scene.problem.bodies[n];
        body.pull("bottom", [Amount::default(), Amount::from(-scene.strain)]);
    }
    let reach = scene.strain * length * scene.random.between(0.2, 4.0);
    let law = scene.law(0.4);
    scene.stand(
        side(&above, "bottom"),
        Surface::Plane {
            point: [0.0, y - reach],
            normal: [0.0, 1.0],
        },
        Drive::Nothing,
        law,
    );
    scene.holds("everything is glued to a clamped body");
}

/// A bar hangs by its head from two ledges and is pulled down.
pub fn hook(scene: &mut Scene) {
    let stem = scene.random.between(0.3, 0.6);
    let ledge = scene.random.between(0.3, 0.6);
    let play = scene.random.between(0.05, 0.3);
    let (rough, glued) = (scene.random.chance(0.4), scene.random.chance(0.8));
    let half = 0.5 * stem + play + ledge;
    let head = 0.5 * stem + play + ledge * scene.random.between(0.4, 1.2);
    let matching = scene.random.chance(0.3);
    let law = if rough {
        scene.law(1.0)
    } else {
        Law::Frictionless
    };
    let thick = scene.random.between(0.3, 0.8);
    for (name, [a, b]) in [
        ("left", [-half, -half + ledge]),
        ("right", [half - ledge, half]),
    ] {
        let body = scene.block(name, [a, -0.5], [b, 0.0], 4);
        scene.problem.bodies[body]
            .supports
            .push(clamp(on("bottom")));
    }
    scene.block("head", [-head, 0.0], [head, thick], 4);
    let long = scene.random.between(0.5, 2.0);
    // the stem begins at the lower face of the head
    let kind = scene.kind();
    let cells = [
        if matching {
            4
        } else {
            scene.random.count(1, 8)
        },
        scene.random.count(2, 12),
    ];
    scene.rectangle("stem", [-0.5 * stem, -long], [0.5 * stem, 0.0], cells, kind);
    let pull = scene.strain * scene.random.between(0.2, 1.0);
    let stem_body = &mut scene.problem.bodies[3];
    stem_body.pull("bottom", [Amount::default(), Amount::from(-pull)]);
    scene.touch(side("head", "bottom"), side("left", "top"), law.clone());
    scene.touch(side("head", "bottom"), side("right", "top"), law);
    scene.touch(side("stem", "top"), side("head", "bottom"), Law::Tied);
    if !rough {
        let support = hold(Place::Point([-0.5 * stem, -long]), 0);
        scene.problem.bodies[3].supports.push(support);
    }
    if !glued {
        // the stem may close its clearance and touch the ledges
        scene.touch(
            side("stem", "left"),
            side("left", "right"),
            Law::Frictionless,
        );
        scene.touch(
            side("stem", "right"),
            side("right", "left"),
            Law::Frictionless,
        );
    }
    scene.holds("the pull acts between the ledges");
}

/// A block glued from parts and pressed onto a ground, one of the parts perhaps over an edge.
pub fn tied(scene: &mut Scene) {
    let n = scene.random.count(2, 4);
    let count = scene.random.pick(&[1, 1, 3]);
    scene.problem.times = steps(count);
    let tall = scene.random.between(0.4, 1.0);
    let mut x = 0.0;
    let matching = scene.random.chance(0.4);
    let (kind, up) = (scene.kind(), scene.random.count(1, 8));
    for k in 0..n {
        let name = format!("t{k}");
        let w = scene.random.between(0.3, 1.0);
        if matching {
            let across = ((w * up as f64 / tall) as usize).max(1);
            scene.rectangle(&name, [x, 0.0], [x + w, tall], [across, up], kind);
        } else {
            scene.block(&name, [x, 0.0], [x + w, tall], n);
        }
        if k > 0 {
            scene.touch(
                side(&format!("t{}", k - 1), "right"),
                side(&name, "left"),
                Law::Tied,
            );
        }
        x += w;
    }
    let law = scene.law(0.3);
    let floor = scene.random.chance(0.5);
    if floor {
        scene.block("floor", [-0.3, -0.6], [x + 0.3, 0.0], n);
        scene.problem.bodies[n].supports.push(clamp(on("bottom")));
    }
    for k in 0..n {
        let name = format!("t{k}");
        // on an elastic floor every part has a contact: a part without one would penetrate the floor
        if scene.random.chance(0.15) && k > 0 && k + 1 < n && !floor {
            continue;
        }
        if floor {
            scene.touch(side(&name, "bottom"), side("floor", "top"), law.clone());
        } else {
            ground(scene, &name, 0.0, law.clone());
        }
    }
    for k in 0..n {
        let p = scene.strain * scene.random.between(0.1, 1.0);
        let body = &mut scene.problem.bodies[k];
        body.press("top", Amount::from(p));
    }
    let drive = scene.random.chance(0.5);
    let support = if drive && count > 1 {
        let push = scene.strain * x * scene.random.between(0.1, 1.0);
        moved(on("left"), 0, Amount::timed(push, Time::Wave(1.3, 0.4)))
    } else {
        hold(on("left"), 0)
    };
    scene.problem.bodies[0].supports.push(support);
    scene.holds("the first part is guided, all are pressed down and glued");
}

/// A block whose sole is moved as a whole, or by a rotation, onto another block: supports on a contact side.
pub fn indenter(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 3]);
    scene.problem.times = steps(count);
    let width = scene.random.between(0.3, 1.0);
    let left = scene.random.between(0.2, 1.8 - width);
    let deep = scene.random.between(0.5, 1.0);
    scene.block("block", [0.0, 0.0], [2.0, deep], 2);
    scene.block("stamp", [left, deep], [left + width, deep + 0.4], 2);
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    let stroke = scene.strain * scene.random.between(0.2, 1.0);
    let turn = stroke * scene.random.between(-1.5, 1.5) / width;
    let middle = left + 0.5 * width;
    let time = course(&mut scene.random, count);
    let down = Amount::new(-stroke - turn * middle, [turn, 0.0], time);
    let stamp = &mut scene.problem.bodies[1];
    stamp.supports.push(moved(on("bottom"), 1, down));
    if scene.random.chance(0.5) {
        let aside = stroke * scene.random.between(-0.5, 0.5);
        let time = course(&mut scene.random, count);
        let support = moved(on("bottom"), 0, Amount::timed(aside, time));
        scene.problem.bodies[1].supports.push(support);
    } else {
        scene.problem.bodies[1].supports.push(hold(on("left"), 0));
    }
    let law = scene.varied_law(0.5);
    let (own, other) = (side("block", "top"), side("stamp", "bottom"));
    let c = scene.touch(own.clone(), other.clone(), law);
    // a side whose displacement is prescribed cannot carry multipliers
    let contact = &mut scene.problem.contacts[c];
    let chosen = scene.random.chance(0.5);
    (contact.own, contact.against) = (
        own,
        crate::problem::Against::Side {
            side: other,
            chosen,
        },
    );
    scene.holds("the stamp moves as prescribed");
}
