//! Beds, beams with sections, two materials in one body, joints, coupled sides, bars, and meshes of extreme grading.

use super::{Scene, course};
use crate::amount::{Amount, Time};
use crate::cells::Kind;
use crate::plane::Vector;
use crate::problem::{
    Bar, Beyond, Couple, Drawing, Gives, Known, Law, Other, Problem, Section, Shape, Spring, clamp,
    hold, moved, on, side, steps,
};
use crate::raw::Mesh;

/// An equivalent problem with the same bodies.
fn otherwise(scene: &mut Scene, name: &'static str, problem: Problem, tolerance: f64) {
    scene.problem.other = Some(Box::new(Other {
        name,
        parts: (0..scene.problem.bodies.len()).map(|b| vec![b]).collect(),
        problem,
        tolerance,
    }));
}

/// A beam on a bed that acts both ways or only presses, a punch on it.
pub fn bed(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 3]);
    scene.problem.times = steps(count);
    let (long, tall) = (
        scene.random.between(1.0, 5.0),
        scene.random.between(0.3, 0.8),
    );
    scene.block("beam", [0.0, 0.0], [long, tall], 2);
    let wide = long * scene.random.between(0.1, 0.3);
    let left = long * scene.random.between(0.38, 0.62) - 0.5 * wide;
    let high = scene.random.between(0.3, 0.6);
    scene.block("punch", [left, tall], [left + wide, tall + high], 2);
    let stiff = scene.random.magnitude(0.03, 30.0);
    let tangential = if scene.random.chance(0.6) {
        stiff * scene.random.between(0.05, 1.0)
    } else {
        0.0
    };
    let beam = &mut scene.problem.bodies[0];
    beam.more.springs.push(Spring {
        side: "bottom".to_string(),
        normal: stiff,
        tangential,
        compression_only: scene.random.chance(0.6),
    });
    if tangential == 0.0 {
        beam.supports.push(hold(on("left"), 0));
    }
    if scene.random.chance(0.4) {
        let weight = scene.strain * scene.random.between(0.05, 0.5);
        beam.weight = [Amount::from(0.0), Amount::from(-weight)];
    }
    let p = scene.strain * scene.random.between(0.2, 1.0);
    let time = match course(&mut scene.random, count) {
        Time::Wave(..) => Time::Line(0.3, 0.7 / count as f64),
        other => other,
    };
    let punch = &mut scene.problem.bodies[1];
    punch.supports.push(hold(on("left"), 0));
    punch.press("top", Amount::timed(p, time));
    let law = scene.law(0.25);
    scene.touch(side("punch", "bottom"), side("beam", "top"), law);
    scene.holds("pressed onto the middle third of a beam on a bed");
}

/// A beam whose end is held, on a bed, loaded along its sides, a punch beyond its sections.
pub fn section(scene: &mut Scene) {
    let (long, tall) = (
        scene.random.between(2.0, 6.0),
        scene.random.between(0.3, 0.8),
    );
    let kind = scene.kind();
    let cells = [scene.random.count(8, 40), scene.random.count(1, 6)];
    scene.rectangle("beam", [0.0, 0.0], [long, tall], cells, kind);
    scene.block("punch", [0.8 * long, tall], [0.95 * long, tall + 0.4], 2);
    let both = scene.random.chance(0.4);
    let beam = &mut scene.problem.bodies[0];
    beam.supports.push(clamp(on("left")));
    if both {
        beam.supports.push(clamp(on("right")));
    }
    if scene.random.chance(0.7) {
        let (sides, stiff) = (["bottom", "top"], scene.random.magnitude(0.01, 3.0));
        beam.more.springs.push(Spring {
            side: sides[usize::from(scene.random.chance(0.2))].to_string(),
            normal: stiff,
            tangential: stiff * scene.random.pick(&[0.0, 0.3, 1.0]),
            compression_only: false,
        });
    }
    let p = scene.strain * scene.random.between(0.01, 0.1);
    let tilt = p * scene.random.between(-0.5, 0.5) / long;
    let along = p * scene.random.between(-1.0, 1.0);
    let where_to = scene.random.pick(&["top", "bottom"]);
    beam.pull(
        where_to,
        [
            Amount::from(along),
            Amount::new(-p, [tilt, 0.0], Time::Always),
        ],
    );
    if scene.random.chance(0.5) {
        let weight = scene.strain * scene.random.between(0.01, 0.1);
        beam.weight = [Amount::from(0.5 * weight), Amount::from(-weight)];
    }
    let punch = &mut scene.problem.bodies[1];
    punch.supports.push(hold(on("left"), 0));
    punch.press("top", Amount::from(scene.strain * 0.1));
    let law = scene.law(0.25);
    scene.touch(side("punch", "bottom"), side("beam", "top"), law);
    // lines of the mesh, the held end among them, short of the punch
    let n = cells[0];
    let at = |k: usize| [long * k as f64 / n as f64, 0.5 * tall];
    let mut stations: Vec<Vector> = (0..n)
        .filter(|k| *k as f64 / (n as f64) < 0.75)
        .map(at)
        .collect();
    if both {
        stations.push(at(n));
    }
    scene.problem.sections.push(Section {
        name: "cuts".to_string(),
        body: "beam".to_string(),
        sides: ["top", "bottom"],
        stations,
    });
    scene.holds("the end of the beam is clamped");
}

/// Two materials in one body; the same as two bodies that are tied where they meet.
pub fn layers(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 2]);
    scene.problem.times = steps(count);
    let (w, h) = (
        scene.random.between(1.0, 2.5),
        scene.random.between(0.4, 1.2),
    );
    let border = w * scene.random.between(0.4, 0.7);
    let cell = super::travel::triangle(scene);
    let drawing = Drawing {
        from: [0.0, 0.0],
        to: [w, h],
        border,
        size: scene.cell_length(w * h, 2, cell).clamp(0.05, 0.5),
        cell,
    };
    scene.add("rock", Shape::Region(vec!["a", "b"]), cell);
    let facet = drawing.size;
    scene.problem.drawing = Some(drawing);
    let wide = border * scene.random.between(0.3, 0.8);
    let left = (border - wide) * scene.random.between(0.05, 0.95);
    scene.block("punch", [left, h], [left + wide, h + 0.4], 2);
    let beyond = Beyond {
        border,
        young: scene.problem.bodies[0].young * scene.random.magnitude(0.01, 100.0),
        poisson: scene.random.between(0.0, 0.45),
    };
    let p = scene.strain * scene.random.between(0.2, 1.0);
    let rock = &mut scene.problem.bodies[0];
    rock.more.beyond = Some(beyond.clone());
    rock.supports.push(clamp(on("bottom")));
    if scene.random.chance(0.5) {
        rock.press("right", Amount::from(0.5 * p));
    }
    let punch = &mut scene.problem.bodies[1];
    punch.supports.push(hold(on("left"), 0));
    punch.press("top", Amount::from(p));
    let law = scene.law(0.25);
    let c = scene.touch(side("punch", "bottom"), side("rock", "top"), law);
    if let crate::problem::Against::Side { chosen, .. } = &mut scene.problem.contacts[c].against {
        *chosen = false;
    }
    let mut apart = scene.problem.clone();
    let mut second = apart.bodies[0].clone();
    let first = &mut apart.bodies[0];
    (first.shape, first.more.beyond) = (Shape::Region(vec!["a"]), None);
    first.loads.clear();
    second.name = "second".to_string();
    (second.shape, second.more.beyond) = (Shape::Region(vec!["b"]), None);
    (second.young, second.poisson) = (beyond.young, beyond.poisson);
    apart.bodies.push(second);
    let mut tie = apart.contacts[0].clone();
    tie.name = "tie".to_string();
    tie.own = side("rock", "border");
    tie.against = crate::problem::Against::Side {
        side: side("second", "border"),
        chosen: false,
    };
    (tie.pairing, tie.law) = (crate::problem::Pairing::Default, Law::Tied);
    apart.contacts.push(tie);
    // if the punch ends on the facet beside the border, the border node as the end of a side has only half of its facets, and so
    // another part that faces the punch
    if left + wide < border - facet {
        scene.problem.other = Some(Box::new(Other {
            name: "tied",
            problem: apart,
            parts: vec![vec![0, 2], vec![1]],
            tolerance: 1e-6,
        }));
    }
    scene.holds("pressed onto a clamped body");
}

/// A block that is glued to a base by a joint of little strength and moved by its head.
pub fn joint(scene: &mut Scene) {
    let count = scene.random.count(1, 5);
    scene.problem.times = steps(count);
    let (w, h) = (
        scene.random.between(0.5, 2.0),
        scene.random.between(0.3, 1.0),
    );
    if scene.random.chance(0.8) {
        let (kind, along) = (scene.kind(), scene.random.count(1, 10));
        scene.rectangle("base", [0.0, -0.5], [w, 0.0], [along, 3], kind);
        scene.rectangle("block", [0.0, 0.0], [w, h], [along, 3], kind);
    } else {
        scene.block("base", [-0.1, -0.5], [w + 0.1, 0.0], 2);
        scene.block("block", [0.0, 0.0], [w, h], 2);
    }
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    let coulomb = scene.random.between(0.1, 0.8);
    let cohesion = scene.strain * scene.random.magnitude(0.1, 3.0);
    let tension = cohesion / coulomb * scene.random.pick(&[0.0, 0.3, 1.0]);
    let law = Law::Joint {
        coulomb,
        cohesion,
        tension,
    };
    scene.touch(side("block", "bottom"), side("base", "top"), law);
    let wave = |scene: &mut Scene, size: f64| {
        let time = match course(&mut scene.random, count) {
            Time::Always => Time::Line(0.0, 1.0 / count as f64),
            other => other,
        };
        Amount::timed(size, time)
    };
    let stroke = scene.strain * h;
    let size = stroke * scene.random.between(-1.5, 1.5);
    let along = wave(scene, size);
    let size = stroke * scene.random.between(-1.0, 1.0);
    let across = wave(scene, size);
    let block = &mut scene.problem.bodies[1];
    block.supports.push(moved(on("top"), 0, along));
    block.supports.push(moved(on("top"), 1, across));
    scene.problem.known = Known::Open;
    scene.problem.reason = "a joint that tears need not have an answer node by node".to_string();
}

/// A block pressed by its top, which is held or drawn evenly; the same by a point that is coupled to it.
pub fn couple(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 3]);
    scene.problem.times = steps(count);
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    scene.block("floor", [-0.2, -0.5], [w + 0.2, 0.0], 2);
    scene.block("block", [0.0, 0.0], [w, h], 2);
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    let law = scene.law(0.4);
    scene.touch(side("block", "bottom"), side("floor", "top"), law);
    let rigid = scene.random.chance(0.5);
    let p = scene.strain * scene.random.between(0.2, 1.0);
    let time = course(&mut scene.random, count);
    let (down, aside) = (p, p * scene.random.between(-0.05, 0.05));
    let block = &mut scene.problem.bodies[1];
    if rigid {
        block
            .supports
            .push(moved(on("top"), 1, Amount::from(-down * h)));
        let along = Amount::timed(aside * h, time);
        block.supports[0].axes[0] = Some(along);
    } else {
        block.supports.push(hold(on("left"), 0));
        block.pull("top", [Amount::timed(aside, time), Amount::from(-down)]);
    }
    let area = w * block.thickness;
    let mut coupled = scene.problem.clone();
    coupled.bodies[1].more.couple = Some(Couple {
        side: "top".to_string(),
        point: [0.5 * w, h],
        area,
        rigid,
    });
    otherwise(scene, "coupled", coupled, 1e-6);
    scene.holds("pressed down, held along");
}

/// A block on a floor beside a wall to which a bar may lead, with `count` steps: the size of the block, its distance to the wall,
/// and a pressure.
fn beside_a_wall(scene: &mut Scene, count: usize) -> ([f64; 2], f64, f64) {
    scene.problem.times = steps(count);
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    scene.block("floor", [-0.2, -0.5], [w + 0.2, 0.0], 3);
    scene.block("block", [0.0, 0.0], [w, h], 3);
    let apart = scene.random.between(0.3, 1.0);
    scene.block("wall", [-apart - 0.4, 0.1], [-apart, h], 3);
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    scene.problem.bodies[2].supports.push(clamp(on("right")));
    let law = scene.law(0.4);
    scene.touch(side("block", "bottom"), side("floor", "top"), law);
    let p = scene.strain * scene.random.between(0.2, 1.0);
    ([w, h], apart, p)
}

/// A block that a spring at its corner draws to its place while it is pushed aside; the same with a bar to a wall.
pub fn bar(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 3]);
    let ([_, h], apart, p) = beside_a_wall(scene, count);
    let time = course(&mut scene.random, count);
    let push = p * scene.random.between(-0.1, 0.1);
    let stiffness = scene.random.magnitude(0.1, 10.0) * scene.problem.bodies[1].thickness;
    let block = &mut scene.problem.bodies[1];
    block.pull("top", [Amount::timed(push, time), Amount::from(-p)]);
    let spring = Bar {
        at: [0.0, h],
        stiffness,
        to: None,
        gives: None,
    };
    let mut barred = scene.problem.clone();
    scene.problem.bodies[1].more.bar = Some(spring.clone());
    barred.bodies[1].more.bar = Some(Bar {
        to: Some(("wall".to_string(), [-apart, h])),
        ..spring
    });
    otherwise(scene, "bar", barred, 1e-6);
    scene.holds("pressed down within its sole, drawn by a spring");
}

/// A block on a floor that is held at its right side, and drawn to and fro beside a bar to a wall that yields, slackens, or does both.
pub fn yielding(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 3, 6]);
    let ([w, h], apart, p) = beside_a_wall(scene, count);
    scene.problem.bodies[1].supports.push(clamp(on("right")));
    let time = Time::Wave(
        scene.random.between(0.5, 2.5),
        scene.random.between(0.0, 6.0),
    );
    let pull = p * scene.random.between(-2.0, 2.0);
    let (slack, yields) = scene
        .random
        .pick(&[(false, true), (true, true), (true, false)]);
    let block = &mut scene.problem.bodies[1];
    let stiffness = scene.random.magnitude(0.1, 10.0) * block.thickness;
    let most = stiffness * scene.strain * w * scene.random.magnitude(0.01, 1.0);
    block.pull("left", [Amount::timed(pull, time), Amount::from(0.0)]);
    block.pull("top", [Amount::from(0.0), Amount::from(-p)]);
    block.more.bar = Some(Bar {
        at: [0.0, h],
        stiffness,
        to: Some(("wall".to_string(), [-apart, h])),
        gives: Some(Gives {
            slack,
            most: yields.then_some(most),
        }),
    });
    scene.holds("held at its right side");
}

/// A block on a floor, both of cells that grow a thousandfold and more from one side to the other.
pub fn graded(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.3, 1.0),
    );
    let margin = scene.random.pick(&[0.0, 0.2]);
    for (name, from, to) in [
        ("floor", [-margin, -0.5], [w + margin, 0.0]),
        ("block", [0.0, 0.0], [w, h]),
    ] {
        let kind = scene.random.pick(&[Kind::Tri3, Kind::Quad4]);
        let mut lines = |from: f64, to: f64| {
            let n = scene.random.count(3, 14);
            let whole = scene.random.magnitude(1.0, 1e5);
            let whole = if scene.random.chance(0.5) {
                whole
            } else {
                1.0 / whole
            };
            let ratio = whole.powf(1.0 / (n - 1) as f64);
            let mut at = vec![0.0];
            for k in 0..n {
                at.push(at[k] + ratio.powi(k as i32));
            }
            let all = at[n];
            let mut places: Vec<f64> = at.iter().map(|x| from + (to - from) * x / all).collect();
            places[n] = to;
            places
        };
        let (xs, ys) = (lines(from[0], to[0]), lines(from[1], to[1]));
        let text = crate::carry::gmsh(&grid(&xs, &ys, kind), |x| x);
        let shape = Shape::File {
            name: format!("{name}.msh"),
            text,
        };
        scene.add(name, shape, kind);
    }
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    scene.press_upright(1);
    let law = scene.law(0.3);
    scene.touch(side("block", "bottom"), side("floor", "top"), law);
    scene.holds("pressed down, upright by its left side");
}

/// A mesh of cells between lines.
fn grid(xs: &[f64], ys: &[f64], kind: Kind) -> Mesh {
    let (nx, ny) = (xs.len(), ys.len());
    let at = |i: usize, j: usize| j * nx + i;
    let points = ys.iter().flat_map(|&y| xs.iter().map(move |&x| [x, y]));
    let mut cells = Vec::new();
    for j in 0..ny - 1 {
        for i in 0..nx - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            match kind.triangle() {
                true => cells.extend([(kind, vec![a, b, c]), (kind, vec![a, c, d])]),
                false => cells.push((kind, vec![a, b, c, d])),
            }
        }
    }
    let across = |j: usize| (0..nx - 1).map(move |i| vec![at(i, j), at(i + 1, j)]);
    let up = |i: usize| (0..ny - 1).map(move |j| vec![at(i, j), at(i, j + 1)]);
    let back = |facets: Vec<Vec<usize>>| -> Vec<Vec<usize>> {
        facets.into_iter().map(|f| vec![f[1], f[0]]).collect()
    };
    Mesh {
        points: points.collect(),
        cells,
        sides: [
            ("bottom", across(0).collect()),
            ("top", back(across(ny - 1).collect())),
            ("left", back(up(0).collect())),
            ("right", up(nx - 1).collect()),
        ]
        .map(|(name, facets)| (name.to_string(), facets))
        .into(),
    }
}
