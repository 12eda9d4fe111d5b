//! Wedges, discs and rings.

use super::floors::polygon;
use super::{Push, Scene, course, wrench};
use crate::amount::{Amount, Time};
use crate::cells::Kind;
use crate::plane::rotated;
use crate::problem::{
    Drive, Gap, Known, Law, Load, Pairing, Place, Shape, Surface, clamp, hold, moved, on,
    round as circle, side, steps,
};
use crate::vector::{plus, times};
use std::f64::consts::PI;

/// A wedge between two inclined faces, rigid or elastic, pressed into them or out of them.
pub fn wedge(scene: &mut Scene) {
    // half the angle at the tip
    let angle = scene.random.between(0.2, 1.1);
    let (narrow, high) = (
        scene.random.between(0.2, 0.5),
        scene.random.between(0.5, 1.0),
    );
    let wide = narrow + high * angle.tan();
    let corners = [[-narrow, 0.0], [narrow, 0.0], [wide, high], [-wide, high]];
    let kind = scene.random.pick(&[Kind::Tri3, Kind::Tri6]);
    let size = scene
        .cell_length((narrow + wide) * high, 2, kind)
        .clamp(0.04, 0.5);
    let cells = scene.random.count(2, 14);
    let shape = polygon(
        size,
        &corners,
        &["bottom", "right", "top", "left"],
        &[None, Some(cells), None, Some(cells)],
    );
    scene.add("wedge", shape, kind);
    let rough = scene.random.chance(0.5);
    let mu = if rough { scene.coefficient() } else { 0.0 };
    let law = Law::rubbing(mu);
    // inward normals of the faces of the wedge
    let left = rotated([1.0, 0.0], angle);
    let right = rotated([-1.0, 0.0], -angle);
    let elastic = scene.random.chance(0.4);
    for (name, normal, sign) in [("left", left, -1.0), ("right", right, 1.0)] {
        if elastic {
            let out = 0.8;
            let a = [sign * narrow, 0.0];
            let b = [sign * wide, high];
            let far = [sign * (wide + out), high];
            let low = [sign * (narrow + out), 0.0];
            let (corners, names): (Vec<[f64; 2]>, [&'static str; 4]) = if sign < 0.0 {
                (vec![a, b, far, low], ["face", "top", "far", "base"])
            } else {
                (vec![b, a, low, far], ["face", "base", "far", "top"])
            };
            let cells = scene.random.count(2, 14);
            let shape = polygon(size, &corners, &names, &[Some(cells)]);
            let jaw = format!("jaw_{name}");
            let body = scene.add(&jaw, shape, kind);
            scene.problem.bodies[body].supports.push(clamp(on("far")));
            scene.touch(side("wedge", name), side(&jaw, "face"), law.clone());
        } else {
            let surface = Surface::Plane {
                point: [sign * narrow, 0.0],
                normal,
            };
            scene.stand(side("wedge", name), surface, Drive::Nothing, law.clone());
        }
    }
    let out = scene.random.chance(0.15);
    let p = scene.strain * if out { -1.0 } else { 1.0 };
    let tilt = scene.random.between(-0.3, 0.3) * scene.strain;
    let body = &mut scene.problem.bodies[0];
    body.press("top", Amount::from(p));
    if rough || scene.random.chance(0.5) {
        body.pull("top", [Amount::from(tilt), Amount::default()]);
    }
    let drawn = body.loads.len() > 1;
    let force = [if drawn { 2.0 * wide * tilt } else { 0.0 }, -2.0 * wide * p];
    let push = |at, direction| Push {
        at,
        direction,
        friction: mu,
    };
    let pushes = vec![
        push(corners[0], left),
        push(corners[3], left),
        push(corners[1], right),
        push(corners[2], right),
    ];
    // in statics, faces wedged by friction can hold any load; but a load that draws the wedge out does not press the faces
    let jams = out && mu >= angle.tan();
    if !jams {
        scene.judge(
            &[(vec![wrench([0.0, high], force)], pushes)],
            "statics of the wedge",
        );
    }
}

/// A disc: triangles in a circle, or a ring with a small hole. Its side is returned.
fn disc(
    scene: &mut Scene,
    name: &str,
    center: [f64; 2],
    radius: f64,
    cells: usize,
    bodies: usize,
) -> &'static str {
    scene.problem.spins = true;
    let outline = scene.random.chance(0.5);
    if outline {
        let kind = scene.random.pick(&[Kind::Tri3, Kind::Tri6]);
        let size = scene
            .cell_length(PI * radius * radius, bodies, kind)
            .clamp(0.05, 0.5)
            * 1.2;
        let shape = Shape::Disc {
            size,
            center,
            radius,
            cells: Some(cells),
        };
        scene.add(name, shape, kind);
        "round"
    } else {
        let kind = scene.kind();
        let through = scene.random.count(2, 6);
        let shape = Shape::Ring {
            center,
            radii: [0.2 * radius, radius],
            angles: None,
            cells: [cells, through],
            ratio: 1.2,
        };
        scene.add(name, shape, kind);
        "outer"
    }
}

/// Discs in rows and columns in a box that closes, or under their weight.
pub fn disc_box(scene: &mut Scene) {
    let (columns, rows) = (scene.random.count(1, 3), scene.random.count(1, 3));
    let cells = 4 * scene.random.count(4, 12);
    let total = columns * rows;
    let mut sides = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let name = format!("d{i}x{j}");
            let center = [1.0 + 2.0 * i as f64, 1.0 + 2.0 * j as f64];
            let round = disc(scene, &name, center, 1.0, cells, total);
            sides.push((name, round));
        }
    }
    let (width, height) = (2.0 * columns as f64, 2.0 * rows as f64);
    let rough = scene.random.chance(0.25);
    let law = if rough {
        scene.law(1.0)
    } else {
        Law::Frictionless
    };
    let closing = scene.strain * width * scene.random.between(0.2, 1.0);
    let walls = [
        ([0.0, 0.0], [1.0, 0.0], true),
        ([width, 0.0], [-1.0, 0.0], false),
        ([0.0, 0.0], [0.0, 1.0], false),
        ([0.0, height], [0.0, -1.0], true),
    ];
    for j in 0..rows {
        for i in 0..columns {
            let (name, round) = sides[j * columns + i].clone();
            let own = || side(&name, round);
            let at_wall = [i == 0, i + 1 == columns, j == 0, j + 1 == rows];
            for ((point, normal, moves), at) in walls.into_iter().zip(at_wall) {
                if at {
                    let drive = if moves {
                        Drive::Displacement(normal.map(|c| Amount::from(c * closing)))
                    } else {
                        Drive::Nothing
                    };
                    scene.stand(own(), Surface::Plane { point, normal }, drive, law.clone());
                }
            }
            if i > 0 {
                let (other, far) = sides[j * columns + i - 1].clone();
                scene.touch(own(), side(&other, far), law.clone());
            }
            if j > 0 {
                let (other, far) = sides[(j - 1) * columns + i].clone();
                scene.touch(own(), side(&other, far), law.clone());
            }
        }
    }
    if scene.random.chance(0.5) {
        let weight = scene.strain * scene.random.between(0.01, 0.2);
        scene
            .problem
            .bodies
            .iter_mut()
            .for_each(|b| b.weight[1] = Amount::from(-weight));
    }
    scene.holds("the box closes from two sides");
}

/// A disc in a V of two planes, or of two blocks, pressed into it by its weight or a force.
pub fn disc_v(scene: &mut Scene) {
    let cells = 8 * scene.random.count(2, 8);
    let round = disc(scene, "disc", [0.0, 0.0], 1.0, cells, 1);
    // nodes lie at multiples of 45 degrees
    let pair = scene
        .random
        .pick(&[[-0.75, -0.25], [-1.0, -0.25], [-0.5, 0.0], [-1.0, -0.5]]);
    let rough = scene.random.chance(0.5);
    let mu = if rough { scene.coefficient() } else { 0.0 };
    let law = Law::rubbing(mu);
    let mut order = pair;
    scene.random.shuffle(&mut order);
    let clearance = scene.strain * scene.random.pick(&[0.0, 0.0, 1.0]);
    let mut pushes = Vec::new();
    for angle in order {
        let at = rotated([1.0, 0.0], angle * PI);
        let normal = times(-1.0, at);
        let surface = Surface::Plane {
            point: times(1.0 + clearance, at),
            normal,
        };
        scene.stand(side("disc", round), surface, Drive::Nothing, law.clone());
        pushes.push(Push {
            at,
            direction: normal,
            friction: mu,
        });
    }
    let thickness = scene.problem.bodies[0].thickness;
    let weight = scene.strain * scene.random.between(0.1, 0.5);
    let inner = if round == "outer" { 0.2f64 } else { 0.0 };
    let area = PI * (1.0 - inner * inner);
    let force = if scene.random.chance(0.6) {
        scene.problem.bodies[0].weight[1] = Amount::from(-weight);
        wrench([0.0; 2], [0.0, -weight * area])
    } else {
        // at a node: the uppermost or one beside it
        let angle = scene.random.pick(&[0.5, 0.25, 0.75]) * PI;
        let point = rotated([1.0, 0.0], angle);
        let direction = rotated([0.0, -weight], scene.random.between(-0.6, 0.6));
        let field = direction.map(|c| Amount::from(c * thickness));
        scene.problem.bodies[0]
            .loads
            .push(Load::Force { point, field });
        wrench(point, direction)
    };
    if rough || force.1 == [0.0; 3] {
        scene.judge(&[(vec![force], pushes.clone())], "statics of the disc");
        if scene.problem.known == Known::Falls {
            // a disc that rolls a little touches at neighbouring points: it falls only if it falls with these, too
            let beside = |p: &Push| {
                let along = crate::plane::turned(p.direction);
                [-1.0, 0.0, 1.0].map(|s| Push {
                    at: crate::vector::plus(p.at, s, along),
                    ..*p
                })
            };
            let wide = pushes.iter().flat_map(beside).collect();
            scene.judge(&[(vec![force], wide)], "statics of the disc");
            if scene.problem.known == Known::Holds {
                scene.problem.known = Known::Open;
            }
        }
    }
}

/// A disc between two blocks, the upper one pressed down.
pub fn disc_plates(scene: &mut Scene) {
    let cells = 4 * scene.random.count(4, 24);
    let radius = scene.random.between(0.5, 1.0);
    let round = disc(scene, "disc", [0.0, 0.0], radius, cells, 3);
    let wide = scene.random.between(0.4, 1.2);
    scene.block("below", [-wide, -radius - 0.6], [wide, -radius], 3);
    scene.problem.bodies[1].supports.push(clamp(on("bottom")));
    let rough = scene.random.chance(0.4);
    let law = if rough {
        scene.law(1.0)
    } else {
        Law::Frictionless
    };
    scene.touch(side("disc", round), side("below", "top"), law.clone());
    if scene.random.chance(0.6) {
        scene.block("above", [-wide, radius], [wide, radius + 0.5], 3);
        scene.problem.bodies[2].supports.push(hold(on("left"), 0));
        scene.problem.bodies[2].supports.push(hold(on("right"), 0));
        scene.problem.bodies[2].press("top", Amount::from(0.1 * scene.strain));
        scene.touch(side("disc", round), side("above", "bottom"), law);
    } else {
        scene.problem.bodies[0].weight[1] = Amount::from(-0.1 * scene.strain);
    }
    if scene.random.chance(0.3) {
        scene.problem.bodies[0]
            .surfaces
            .push(circle(round, [0.0, 0.0], radius));
    }
    scene.holds("pressed vertically through its middle");
}

/// Rings in rings, quarters or full, with interference or clearance, pressed from outside or inside.
pub fn rings(scene: &mut Scene) {
    let full = scene.random.chance(0.4);
    let n = scene.random.count(2, 3);
    let mut radius = scene.random.between(0.4, 1.0);
    let step_count = scene.random.pick(&[1, 1, 2]);
    scene.problem.times = steps(step_count);
    let matching = scene.random.chance(0.5);
    let around = if full {
        4 * scene.random.count(4, 10)
    } else {
        scene.random.count(4, 20)
    };
    let misfit = scene.strain * scene.random.pick(&[-1.0, 0.0, 0.3, 1.0]);
    let surfaces = scene.random.chance(0.4);
    for k in 0..n {
        let name = format!("r{k}");
        let outer = radius + scene.random.between(0.3, 0.8);
        let cells = [
            if matching {
                around
            } else if full {
                4 * scene.random.count(4, 10)
            } else {
                scene.random.count(4, 20)
            },
            scene.random.count(1, 5),
        ];
        let kind = scene.kind();
        let shape = Shape::Ring {
            center: [0.0, 0.0],
            radii: [radius, outer],
            angles: (!full).then_some([0.0, 90.0]),
            cells,
            ratio: 1.0,
        };
        let body = scene.add(&name, shape, kind);
        let body = &mut scene.problem.bodies[body];
        if !full {
            body.supports.push(hold(on("start"), 1));
            body.supports.push(hold(on("end"), 0));
        } else if k == 0 || misfit < 0.0 {
            body.supports.push(hold(Place::Point([outer, 0.0]), 1));
            body.supports.push(hold(Place::Point([-outer, 0.0]), 1));
            body.supports.push(hold(Place::Point([0.0, outer]), 0));
        }
        if surfaces {
            for (name, r) in [("inner", radius), ("outer", outer)] {
                body.surfaces.push(circle(name, [0.0, 0.0], r));
            }
        }
        if k > 0 {
            let law = scene.law(0.3);
            let inside = format!("r{}", k - 1);
            let c = scene.touch(side(&name, "inner"), side(&inside, "outer"), law);
            // the meshes fit; the interference is given by a number
            scene.problem.contacts[c].gap = if misfit == 0.0 {
                if surfaces {
                    Gap::Geometric
                } else {
                    Gap::Closed
                }
            } else {
                Gap::Given(Amount::from(-misfit * radius))
            };
        }
        radius = outer;
    }
    let time = match course(&mut scene.random, step_count) {
        Time::Wave(..) => Time::Always,
        other => other,
    };
    let p = scene.strain * scene.random.between(0.2, 2.0);
    let (body, name) = if scene.random.chance(0.5) {
        (n - 1, "outer")
    } else {
        (0, "inner")
    };
    scene.problem.bodies[body].press(name, Amount::timed(p, time));
    scene.holds("rings under pressure");
}

/// A ring hangs on a rigid pin, or rests on it from outside.
pub fn pin(scene: &mut Scene) {
    scene.problem.spins = true;
    let inner = scene.random.between(0.5, 1.0);
    let outer = inner + scene.random.between(0.2, 0.8);
    let cells = [4 * scene.random.count(4, 16), scene.random.count(1, 5)];
    let kind = scene.kind();
    let shape = Shape::Ring {
        center: [0.0, 0.0],
        radii: [inner, outer],
        angles: None,
        cells,
        ratio: 1.0,
    };
    scene.add("ring", shape, kind);
    let weight = scene.strain * scene.random.between(0.05, 0.3);
    scene.problem.bodies[0].weight[1] = Amount::from(-weight);
    let law = scene.law(0.4);
    let play = scene.random.pick(&[0.0, 0.05, 0.3]) * inner;
    let radius = inner - play - scene.random.unit() * scene.strain;
    let surface = if scene.random.chance(0.6) {
        // the pin touches the uppermost point of the bore
        Surface::Round {
            center: [0.0, inner - radius],
            radius,
            inside: false,
        }
    } else {
        // a wide rigid tube around the ring
        let radius = outer * scene.random.between(1.05, 3.0);
        Surface::Round {
            center: [0.0, radius - outer],
            radius,
            inside: true,
        }
    };
    let name = match surface {
        Surface::Round { inside: true, .. } => "outer",
        _ => "inner",
    };
    scene.stand(side("ring", name), surface, Drive::Nothing, law);
    scene.holds("the ring hangs on a point");
}

/// An elastic disc in the bore of a block, with play or without, pressed to one side.
pub fn bore(scene: &mut Scene) {
    scene.problem.spins = true;
    let radius = 0.5;
    let cells = 4 * scene.random.count(4, 14);
    let kind = scene.random.pick(&[Kind::Tri3, Kind::Tri6]);
    let outer = scene.random.between(0.9, 1.5);
    let shape = Shape::Ring {
        center: [0.0, 0.0],
        radii: [radius, outer],
        angles: None,
        cells: [4 * scene.random.count(4, 14), scene.random.count(2, 5)],
        ratio: 1.0,
    };
    let plate = scene.kind();
    scene.add("plate", shape, plate);
    scene.problem.bodies[0].supports.push(clamp(on("outer")));
    let play = scene.strain * scene.random.pick(&[0.0, 0.3, 3.0]);
    let shape = Shape::Disc {
        size: scene.random.between(0.1, 0.3),
        center: [0.0, 0.0],
        radius,
        cells: Some(cells),
    };
    scene.add("disc", shape, kind);
    let angle = scene.random.between(0.0, 2.0 * PI);
    let force = rotated([scene.strain, 0.0], angle);
    scene.problem.bodies[1].weight = force.map(Amount::from);
    let law = scene.law(0.4);
    let c = scene.touch(side("disc", "round"), side("plate", "inner"), law);
    scene.problem.contacts[c].gap = if play > 0.0 {
        Gap::Given(Amount::from(play))
    } else {
        Gap::Closed
    };
    scene.holds("pressed through the middle into a bore");
}

/// A block in a pocket that surrounds it from three sides; each of the two sides of the contact has corners.
pub fn pocket(scene: &mut Scene) {
    let (w, h) = (
        scene.random.between(0.5, 1.5),
        scene.random.between(0.4, 1.0),
    );
    let wall = scene.random.between(0.3, 0.6);
    let play = scene.strain * scene.random.pick(&[0.0, 0.0, 0.5, -0.2]);
    let kind = scene.random.pick(&[Kind::Tri3, Kind::Tri6]);
    let size = scene
        .cell_length((w + 2.0 * wall) * (h + wall), 2, kind)
        .clamp(0.06, 0.5);
    let same = scene.random.chance(0.5);
    let mut cells = [0; 3].map(|_| scene.random.count(1, 8));
    let inner = [[0.0, h], [0.0, 0.0], [w, 0.0], [w, h]];
    let outside = [[w + wall, h], [w + wall, -wall], [-wall, -wall], [-wall, h]];
    let corners: Vec<[f64; 2]> = inner.into_iter().chain(outside).collect();
    let names = [
        "pocket",
        "pocket",
        "pocket",
        "rim_right",
        "right",
        "base",
        "left",
        "rim_left",
    ];
    let divided = cells.map(Some);
    let shape = polygon(size, &corners, &names, &divided);
    scene.add("box", shape, kind);
    scene.problem.bodies[0].supports.push(clamp(on("base")));
    if !same {
        cells = [0; 3].map(|_| scene.random.count(1, 8));
    }
    // the block: down its left side, along its bottom, up its right side
    let corners = [[0.0, h], [0.0, 0.0], [w, 0.0], [w, h]];
    let shape = polygon(
        size,
        &corners,
        &["sole", "sole", "sole", "top"],
        &cells.map(Some),
    );
    let kind = if same {
        kind
    } else {
        scene.random.pick(&[Kind::Tri3, Kind::Tri6])
    };
    scene.add("block", shape, kind);
    let law = scene.law(0.4);
    // an interference pushes the corners away from both faces, against friction: for μ ≥ 1 no N₁, N₂ ≥ 0 make both N₁ − μN₂ and
    // N₂ − μN₁ positive
    let jams = play < 0.0 && matches!(&law, Law::Coulomb(mu) if mu.at([0.0; 2], 0.0) >= 1.0);
    let c = scene.touch(side("block", "sole"), side("box", "pocket"), law);
    if play != 0.0 {
        scene.problem.contacts[c].gap = Gap::Given(Amount::from(play));
    }
    let p = scene.strain;
    let aside = scene.random.between(-0.5, 0.5) * p;
    scene.problem.bodies[1].pull("top", [Amount::from(aside), Amount::from(-p)]);
    if !jams {
        scene.holds("pressed into a pocket that surrounds it");
    }
}

/// A corner that is moved onto a round obstacle, into a hollow one or onto a plane, near or far; its faces may not see it.
pub fn edge(scene: &mut Scene) {
    let half = scene.random.between(0.35, 1.2);
    let lean = scene.random.between(-0.5, 0.5) * half;
    let along = [half + lean, lean - half].map(|angle| {
        let long = scene.random.between(0.5, 1.2);
        times(long, [angle.sin(), angle.cos()])
    });
    let far = plus(along[0], 1.0, along[1]);
    let corners = [[0.0; 2], along[0], far, along[1]];
    let kind = scene.random.pick(&[Kind::Tri3, Kind::Tri6]);
    let size = scene.cell_length(1.0, 1, kind).clamp(0.05, 0.3);
    let shape = polygon(size, &corners, &["low", "up", "up", "low"], &[]);
    scene.add("wedge", shape, kind);
    let clear = scene.random.pick(&[0.0, 0.3, 1.0, 30.0, 300.0]) * scene.strain.min(3e-4);
    // with a larger turn another corner would touch first
    let turn = scene.random.between(-0.9, 0.9) * (0.5 * PI - half) - lean;
    let way = [turn.sin(), -turn.cos()];
    let surface = match scene.random.count(0, 2) {
        0 => Surface::Plane {
            point: times(clear, way),
            normal: times(-1.0, way),
        },
        which => {
            let inside = which == 1;
            let radius = scene.random.magnitude(0.5, 5.0) + if inside { 15.0 } else { 0.0 };
            let centre = if inside {
                clear - radius
            } else {
                clear + radius
            };
            Surface::Round {
                center: times(centre, way),
                radius,
                inside,
            }
        }
    };
    let law = scene.law(0.4);
    let c = scene.stand(side("wedge", "low"), surface, Drive::Nothing, law);
    // integrated conditions average along the faces, and say little about the corner between them
    scene.problem.contacts[c].pairing = Pairing::Default;
    let depth = clear + scene.strain * scene.random.between(0.1, 1.0);
    let supports = &mut scene.problem.bodies[0].supports;
    supports.extend([0, 1].map(|axis| moved(on("up"), axis, Amount::from(depth * way[axis]))));
    scene.holds("moved onto what stands still");
}
