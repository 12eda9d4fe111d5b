//! Bodies of revolution.

use super::Scene;
use crate::amount::Amount;
use crate::cells::Kind;
use crate::problem::{
    Analysis, Drive, Edge, Gap, Law, Shape, Surface, clamp, hold, on, round, side, steps,
};

fn revolve(scene: &mut Scene) {
    scene.problem.analysis = Analysis::Axisymmetric;
    let count = scene.random.pick(&[1, 1, 1, 3]);
    scene.problem.times = steps(count);
}

/// All bodies without a thickness.
fn no_thickness(scene: &mut Scene) {
    scene
        .problem
        .bodies
        .iter_mut()
        .for_each(|body| body.thickness = 1.0);
}

/// Discs and rings on top of each other, pressed down.
pub fn stack(scene: &mut Scene) {
    revolve(scene);
    let n = scene.random.count(1, 5);
    let mut y = 0.0;
    let on_axis = scene.random.chance(0.5);
    let matching = scene.random.chance(0.3);
    let (kind, along) = (scene.kind(), scene.random.count(2, 10));
    let rough = scene.random.chance(0.3);
    for k in 0..n {
        let name = format!("b{k}");
        let h = scene.random.between(0.3, 1.0);
        let (inner, outer) = if matching {
            (if on_axis { 0.0 } else { 0.5 }, 1.5)
        } else {
            let inner = if on_axis {
                0.0
            } else {
                scene.random.between(0.3, 0.7)
            };
            (inner, scene.random.between(1.0, 2.0))
        };
        if matching && scene.random.chance(0.5) {
            let up = ((along as f64 * h) as usize).max(1);
            scene.rectangle(&name, [inner, y], [outer, y + h], [along, up], kind);
        } else {
            scene.block(&name, [inner, y], [outer, y + h], n);
        }
        y += h;
        let law = if rough {
            scene.law(1.0)
        } else {
            Law::Frictionless
        };
        if k > 0 {
            scene.touch(
                side(&name, "bottom"),
                side(&format!("b{}", k - 1), "top"),
                law,
            );
        } else if scene.random.chance(0.5) {
            scene.problem.bodies[0].supports.push(hold(on("bottom"), 1));
        } else {
            let surface = Surface::Plane {
                point: [0.0, 0.0],
                normal: [0.0, 1.0],
            };
            scene.stand(side(&name, "bottom"), surface, Drive::Nothing, law);
        }
    }
    let p = Amount::from(scene.strain);
    scene.problem.bodies[n - 1].press("top", p);
    if scene.problem.contacts.is_empty() {
        let surface = Surface::Gap(Amount::from(scene.strain * 0.1));
        scene.stand(
            side("b0", "right"),
            surface,
            Drive::Nothing,
            Law::Frictionless,
        );
    }
    no_thickness(scene);
    if matching && !rough {
        scene.problem.uniform = Some(Amount::from(scene.strain));
        scene.problem.contacts.retain(|c| c.own.side != "right");
        if scene.problem.contacts.is_empty() {
            scene.problem.uniform = None;
            let surface = Surface::Gap(Amount::from(0.0));
            scene.stand(
                side("b0", "right"),
                surface,
                Drive::Nothing,
                Law::Frictionless,
            );
        }
    }
    scene.holds("pressed down along the axis");
}

/// A ball's lower half on a block or a rigid plane.
pub fn sphere(scene: &mut Scene) {
    revolve(scene);
    let kind = scene.random.pick(&[Kind::Tri3, Kind::Tri6]);
    let cells = scene.random.count(6, 30);
    let size = scene.cell_length(0.8, 2, kind).clamp(0.04, 0.3);
    // from the pole along the meridian to the equator
    let shape = Shape::Outline {
        size,
        from: [0.0, 0.0],
        edges: vec![
            Edge {
                to: [1.0, 1.0],
                name: "cap",
                center: Some([0.0, 1.0]),
                cells: Some(cells),
            },
            Edge {
                to: [0.0, 1.0],
                name: "top",
                center: None,
                cells: None,
            },
            Edge {
                to: [0.0, 0.0],
                name: "axis",
                center: None,
                cells: None,
            },
        ],
    };
    scene.add("ball", shape, kind);
    let law = scene.law(0.3);
    if scene.random.chance(0.6) {
        scene.block("plate", [0.0, -0.8], [1.2, 0.0], 2);
        scene.problem.bodies[1].supports.push(clamp(on("bottom")));
        scene.touch(side("ball", "cap"), side("plate", "top"), law);
        if scene.random.chance(0.4) {
            scene.problem.bodies[0]
                .surfaces
                .push(round("cap", [0.0, 1.0], 1.0));
        }
    } else {
        let surface = Surface::Plane {
            point: [0.0, 0.0],
            normal: [0.0, 1.0],
        };
        scene.stand(side("ball", "cap"), surface, Drive::Nothing, law);
    }
    let p = Amount::from(0.1 * scene.strain);
    scene.problem.bodies[0].press("top", p);
    no_thickness(scene);
    scene.holds("pressed down along the axis");
}

/// A hub on a shaft: interference or clearance, pressed from outside, drawn along with friction.
pub fn fit(scene: &mut Scene) {
    revolve(scene);
    let (inner, fit) = (scene.random.pick(&[0.0, 0.4]), 1.0);
    let outer = fit + scene.random.between(0.3, 1.0);
    let long = scene.random.between(0.5, 2.0);
    let wide = scene.random.between(0.4, 1.0) * long;
    let matching = scene.random.chance(0.4);
    let kind = scene.kind();
    if matching {
        let up = scene.random.count(2, 12);
        scene.rectangle("shaft", [inner, 0.0], [fit, long], [3, up], kind);
        scene.rectangle("hub", [fit, 0.0], [outer, long], [3, up], kind);
    } else {
        let low = 0.5 * (long - wide);
        scene.block("shaft", [inner, 0.0], [fit, long], 2);
        scene.block("hub", [fit, low], [outer, low + wide], 2);
    }
    let law = scene.law(0.5);
    let misfit = scene.strain * scene.random.pick(&[-0.5, 0.5, 1.0]);
    let c = scene.touch(side("hub", "left"), side("shaft", "right"), law);
    scene.problem.contacts[c].gap = Gap::Given(Amount::from(-misfit));
    scene.problem.bodies[0].supports.push(hold(on("bottom"), 1));
    scene.problem.bodies[1].supports.push(hold(on("bottom"), 1));
    let p = Amount::from(scene.strain * scene.random.between(0.1, 1.0));
    scene.problem.bodies[1].press("right", p);
    no_thickness(scene);
    scene.holds("both are held along the axis");
}
