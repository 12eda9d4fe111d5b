//! Stages without any change, runs that continue an earlier one, and ground at rest.

use super::Scene;
use crate::amount::{Amount, Time};
use crate::problem::{Law, Load, Other, Problem, Support, clamp, hold, moved, on, side, steps};

/// A block that is pushed to and fro on a floor with friction, its time standing still from one step to the next.
fn pushed(scene: &mut Scene, count: usize, rest: usize) {
    scene.problem.times = steps(count);
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    let matching = scene.random.chance(0.5);
    if matching {
        let (kind, along) = (scene.kind(), scene.random.count(2, 8));
        scene.rectangle("floor", [0.0, -0.5], [w, 0.0], [along, 3], kind);
        scene.rectangle("block", [0.0, 0.0], [w, h], [along, 3], kind);
    } else {
        scene.block("floor", [-0.2, -0.5], [w + 0.2, 0.0], 2);
        scene.block("block", [0.0, 0.0], [w, h], 2);
    }
    let law = Law::Coulomb(Amount::from(scene.random.between(0.1, 0.5)));
    scene.touch(side("block", "bottom"), side("floor", "top"), law);
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    let wave = |scene: &mut Scene, size: f64| {
        let (omega, phase) = (
            scene.random.between(0.5, 2.0),
            scene.random.between(0.0, 6.0),
        );
        Amount::timed(
            size,
            Time::Rest(omega, phase, rest as f64 - 1.0, rest as f64),
        )
    };
    let p = scene.strain;
    if scene.random.chance(0.5) {
        // moved by its top
        let size = scene.strain * h * scene.random.between(0.2, 1.5);
        let along = wave(scene, size);
        let down = Amount::from(-p * h).and(wave(scene, 0.3 * p * h));
        let supports = &mut scene.problem.bodies[1].supports;
        supports.push(moved(on("top"), 0, along));
        supports.push(moved(on("top"), 1, down));
    } else {
        let pull = wave(scene, 0.4 * p);
        let down = Amount::from(-p).and(wave(scene, 0.3 * p));
        let stroke = scene.strain * scene.random.between(0.0, 0.5);
        let along = wave(scene, stroke);
        let block = &mut scene.problem.bodies[1];
        block.pull("top", [pull, down]);
        block.supports.push(moved(on("left"), 0, along));
    }
    scene.holds("pushed by what is held, pressed down");
}

/// A history with one step in which nothing changes, except that mostly a support comes and holds the nodes where they are.
pub fn stages(scene: &mut Scene) {
    let count = scene.random.count(3, 6);
    let rest = scene.random.count(2, count);
    pushed(scene, count, rest);
    scene.problem.idle = vec![rest];
    // not on a flank: its corner node is in the contact, and the contact drops a condition whose normal is held
    let block = &mut scene.problem.bodies[1];
    if block.supports.iter().all(|s| s.place != on("top")) {
        block.supports.push(Support {
            from: Some(rest as f64),
            ..hold(on("top"), 1)
        });
    }
}

/// A history, and the same history continued from an earlier run of its first steps.
pub fn resumed(scene: &mut Scene) {
    let count = scene.random.count(2, 6);
    let rest = scene.random.count(2, count);
    pushed(scene, count, rest);
    let past = scene.random.count(1, count - 1);
    let problem = Problem {
        past,
        ..scene.problem.clone()
    };
    scene.problem.other = Some(Box::new(Other {
        name: "resumed",
        parts: (0..problem.bodies.len()).map(|b| vec![b]).collect(),
        problem,
        tolerance: 1e-6,
    }));
}

/// Ground in two layers at rest under its own weight: nothing moves, and pressures are those of the given state. Afterwards a
/// flank may be excavated in steps.
pub fn ground(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 2, 4]);
    scene.problem.times = steps(count);
    let dug = count > 1 && scene.random.chance(0.7);
    let w = scene.random.between(1.0, 2.0);
    let (low, high) = (
        scene.random.between(0.4, 1.0),
        scene.random.between(0.4, 1.0),
    );
    scene.block("lower", [0.0, -low], [w, 0.0], 2);
    scene.block("upper", [0.0, 0.0], [w, high], 2);
    let weight = scene.strain * scene.random.between(0.2, 2.0);
    let over = scene.strain * scene.random.pick(&[0.0, 0.5]);
    let k0 = scene.random.between(0.2, 0.9);
    // weight of the ground above y: −(over + weight (high − y))
    let vertical = Amount::new(-over - weight * high, [0.0, weight], Time::Always);
    let plane_stress = scene.problem.analysis == crate::problem::Analysis::PlaneStress;
    let thick = scene.problem.bodies[0].thickness;
    for body in &mut scene.problem.bodies {
        body.thickness = thick;
        let aside = vertical.times(k0);
        let out = if plane_stress {
            Amount::from(0.0)
        } else {
            aside.clone()
        };
        body.more.initial = Some([aside, vertical.clone(), out, Amount::from(0.0)]);
        body.weight = [Amount::from(0.0), Amount::from(-weight)];
        body.supports.push(hold(on("left"), 0));
    }
    let [lower, upper] = &mut scene.problem.bodies[..] else {
        return;
    };
    lower.supports.push(clamp(on("bottom")));
    lower.supports.push(hold(on("right"), 0));
    if over > 0.0 {
        upper.press("top", Amount::from(over));
    }
    let factor = match dug {
        true => Amount::timed(
            1.0,
            Time::Line(1.0 + 1.0 / count as f64, -1.0 / count as f64),
        ),
        false => Amount::from(1.0),
    };
    upper.loads.push(Load::InSitu {
        side: "right".to_string(),
        factor,
    });
    let rough = scene.random.chance(0.7);
    let law = if rough {
        Law::Coulomb(Amount::from(scene.random.between(0.3, 0.8)))
    } else {
        Law::Frictionless
    };
    scene.touch(side("upper", "bottom"), side("lower", "top"), law);
    scene.problem.idle = if dug { vec![1] } else { (1..=count).collect() };
    if !dug {
        scene.problem.uniform = Some(Amount::from(over + weight * high));
    }
    scene.holds("in equilibrium at rest, held at its left flank and its base");
}
