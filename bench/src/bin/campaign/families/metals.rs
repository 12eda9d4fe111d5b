//! Bodies of metal that yield: pressed to and fro, rings in each other, and loads near the limit load.

use super::{Scene, rounds};
use crate::amount::{Amount, Time};
use crate::problem::{Analysis, Known, Law, Metal, clamp, hold, moved, on, side, steps};

/// Gives a body a yield stress that the strains of the scene mostly reach, and sometimes do not.
fn alloy(scene: &mut Scene, body: usize, least: f64) {
    let strain = scene.strain * scene.random.between(0.15, 1.5);
    let hard = scene.random.magnitude(1e-3, 0.5).max(least);
    let slope = scene.random.pick(&[least, hard]);
    let body = &mut scene.problem.bodies[body];
    body.more.metal = Some(Metal {
        yields: strain * body.young,
        hardening: slope * body.young,
    });
}

pub fn metal(scene: &mut Scene) {
    // not in plane stress, for which the program has no plasticity
    scene.problem.analysis = Analysis::PlaneStrain;
    scene.dofs = scene.dofs.min(800.0);
    match scene.random.count(0, 9) {
        0..=5 => pressed(scene),
        6 | 7 => rings(scene),
        _ => limit(scene),
    }
}

/// A block on a floor, its top moved down and aside, some steps to and fro.
fn pressed(scene: &mut Scene) {
    let count = scene.random.count(1, 5);
    scene.problem.times = steps(count);
    if scene.random.chance(0.25) {
        scene.problem.analysis = Analysis::Axisymmetric;
    }
    let round = scene.problem.analysis.axisymmetric();
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    if scene.random.chance(0.5) {
        let (kind, along) = (scene.kind(), scene.random.count(2, 6));
        scene.rectangle("floor", [0.0, -0.5], [w, 0.0], [along, 3], kind);
        scene.rectangle("block", [0.0, 0.0], [w, h], [along, 3], kind);
    } else {
        let margin = if round { 0.0 } else { 0.2 };
        scene.block("floor", [-margin, -0.5], [w + 0.2, 0.0], 2);
        scene.block("block", [0.0, 0.0], [w, h], 2);
    }
    let which = scene.random.count(1, 3);
    for body in (0..2).filter(|body| which & (1 << body) != 0) {
        alloy(scene, body, 0.0);
    }
    let law = match scene.random.chance(0.2) {
        true => Law::Tied,
        false => scene.law(0.4),
    };
    scene.touch(side("block", "bottom"), side("floor", "top"), law);
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    let wave = |scene: &mut Scene, size: f64| {
        let (omega, phase) = (
            scene.random.between(0.5, 2.0),
            scene.random.between(0.0, 6.0),
        );
        Amount::timed(size, Time::Wave(omega, phase))
    };
    let p = scene.strain;
    let down = Amount::from(-p * h).and(wave(scene, 0.8 * p * h));
    let aside = match round {
        true => Amount::from(0.0),
        false => wave(scene, 0.5 * p * h),
    };
    let block = &mut scene.problem.bodies[1];
    block.supports.push(moved(on("top"), 0, aside));
    block.supports.push(moved(on("top"), 1, down));
    if round {
        scene
            .problem
            .bodies
            .iter_mut()
            .for_each(|b| b.thickness = 1.0);
    }
    scene.holds("pressed down by what is held");
}

/// Rings in each other, some of which yield; they harden, so that they bear any load.
fn rings(scene: &mut Scene) {
    rounds::rings(scene);
    let count = scene.problem.bodies.len();
    let first = scene.random.count(0, count - 1);
    for body in 0..count {
        if body == first || scene.random.chance(0.4) {
            alloy(scene, body, 0.05);
        }
    }
}

/// Blocks of metal without hardening on each other, guided, under a pressure that grows in steps. Their stress is uniform, and
/// they bear 2/√3 of the yield stress in plane strain, and the yield stress itself as bodies of revolution.
fn limit(scene: &mut Scene) {
    let count = scene.random.count(1, 3);
    scene.problem.times = steps(count);
    if scene.random.chance(0.4) {
        scene.problem.analysis = Analysis::Axisymmetric;
    }
    let round = scene.problem.analysis.axisymmetric();
    let (w, high) = (
        scene.random.between(0.5, 1.5),
        [
            scene.random.between(0.3, 1.0),
            scene.random.between(0.3, 1.0),
        ],
    );
    let blocks = scene.random.count(1, 2);
    let (kind, cells) = (
        scene.kind(),
        [scene.random.count(1, 6), scene.random.count(1, 5)],
    );
    scene.rectangle("lower", [0.0, 0.0], [w, high[0]], cells, kind);
    if blocks == 2 {
        let top = [w, high[0] + high[1]];
        if scene.random.chance(0.5) {
            scene.rectangle("upper", [0.0, high[0]], top, cells, kind);
        } else {
            scene.block("upper", [0.0, high[0]], top, 2);
        }
        scene.touch(
            side("upper", "bottom"),
            side("lower", "top"),
            Law::Frictionless,
        );
    }
    let strain = scene.strain * scene.random.between(0.3, 1.0);
    let thick = match round {
        true => 1.0,
        false => scene.problem.bodies[0].thickness,
    };
    for body in &mut scene.problem.bodies {
        (body.young, body.thickness) = (1.0, thick);
        body.more.metal = Some(Metal {
            yields: strain,
            hardening: 0.0,
        });
        if !round {
            body.supports.push(hold(on("left"), 0));
        }
    }
    scene.problem.bodies[0].supports.push(hold(on("bottom"), 1));
    let most = if round {
        strain
    } else {
        strain * 2.0 / 3f64.sqrt()
    };
    let falls = scene.random.chance(0.5);
    let part = match falls {
        true => scene.random.between(1.02, 3.0),
        false => scene.random.between(0.5, 0.98),
    };
    let pressure = Time::Line(0.0, 1.0 / count as f64);
    scene.problem.bodies[blocks - 1].press("top", Amount::timed(part * most, pressure));
    scene.holds("less than what metal bears");
    if falls {
        (scene.problem.known, scene.problem.reason) =
            (Known::Falls, "more than what metal bears".to_string());
    }
}
