//! Balls on boxes, between plates and in bowls; shafts in rings.

use super::boxes::{floor, pressed};
use super::{Drive, Field, Number, Scene, Shape, Surface, upwards};
use crate::amount::Time;
use crate::cells::Kind;
use crate::problem::{Gap, roller, round, side};
use crate::vector::unit;

/// Kinds of cells that round bodies may have.
const ROUND: [Kind; 5] = [Kind::Hex8, Kind::Hex8, Kind::Tet4, Kind::Hex20, Kind::Tet10];

/// A ball of radius one about a point, with its true surface.
fn add_ball(scene: &mut Scene, center: [f64; 3], kinds: &[Kind]) -> usize {
    let kind = scene.random.pick(kinds);
    let around = match kind {
        Kind::Hex8 => scene.random.pick(&[8, 12]),
        _ => 8,
    };
    let shape = Shape::Ball {
        center,
        radius: 1.0,
        cells: [around, 1],
    };
    let ball = scene.add("ball", shape, kind);
    scene.problem.bodies[ball].surfaces = vec![round("outer", center, 1.0)];
    scene.problem.spins = true;
    ball
}

/// A ball on a box or a plane, pressed from above by a plate, rigid or not, which may move along.
pub fn ball(scene: &mut Scene) {
    let count = scene.steps(&[1, 1, 2, 4]);
    let ball = add_ball(scene, [0.0, 0.0, 1.0], &ROUND);
    let depth = scene.strain.min(3e-4) * 3.0;
    let rough = if scene.random.chance(0.5) { 1.0 } else { 0.0 };
    let [below, above] = [0; 2].map(|_| scene.law(rough));
    if scene.random.chance(0.5) {
        scene.stand(side("ball", "outer"), floor(0.0), Drive::Nothing, below);
    } else {
        let out = scene.random.between(0.4, 1.2);
        let lower = scene.cuboid("lower", [-out, -out, -0.6], [out, 0.9, 0.0], 2);
        scene.hold(lower, "bottom", Field::default());
        scene.touch(side("ball", "outer"), side("lower", "top"), below);
    }
    let drive = pressed(scene, depth, count);
    if scene.random.chance(0.5) {
        let surface = Surface::Plane {
            point: [0.0, 0.0, 2.0],
            normal: [0.0, 0.0, -1.0],
        };
        scene.stand(side("ball", "outer"), surface, drive, above);
    } else {
        let upper = scene.cuboid("upper", [-0.7, -0.5, 2.0], [0.6, 0.8, 2.5], 2);
        if let Drive::Displacement(field) = drive {
            scene.hold(upper, "top", field);
        }
        scene.touch(side("ball", "outer"), side("upper", "bottom"), above);
    }
    let body = &mut scene.problem.bodies[ball];
    // the centroid of the tetrahedra is not the centre of the sphere: without friction their weight turns the ball without limit
    let mut spun = false;
    if scene.random.chance(0.3) {
        body.weight = upwards(-0.01 * scene.strain);
        spun = matches!(body.kind, Kind::Tet4 | Kind::Tet10);
    }
    let lifted = scene.problem.times.len() > 1;
    if !lifted && rough == 0.0 && !spun {
        scene.holds("the ball is pressed between two plates");
    }
}

/// A ball in a rigid bowl or groove under its weight, which may lean.
pub fn bowl(scene: &mut Scene) {
    let count = scene.steps(&[1, 1, 3]);
    // the centroid of the hexahedra is the centre of the ball: no moment turns them without friction
    let ball = add_ball(scene, [0.0, 0.0, 1.0], &[Kind::Hex8, Kind::Hex20]);
    let radius = scene.random.magnitude(1.02, 3.0);
    let surface = match scene.random.chance(0.6) {
        true => Surface::Round {
            center: [0.0, 0.0, radius],
            radius,
            inside: true,
        },
        false => {
            let axis = unit([1.0, scene.random.between(-1.0, 1.0), 0.0]);
            Surface::Cylinder {
                point: [0.0, 0.0, radius],
                axis,
                radius,
                inside: true,
            }
        }
    };
    let law = scene.law(0.5);
    let drive = match scene.random.chance(0.3) {
        true => {
            let by = scene.strain * scene.random.between(0.1, 1.0);
            Drive::Displacement(upwards(by))
        }
        false => Drive::Nothing,
    };
    let mu = law.coefficient();
    scene.stand(side("ball", "outer"), surface, drive, law);
    let g = 0.1 * scene.strain.min(3e-4);
    let lean = match mu > 0.0 {
        true => scene.direction(g * mu, [0.0, 0.5]),
        false => [0.0; 2],
    };
    let time = Time::Line(0.0, 1.0 / count as f64);
    scene.problem.bodies[ball].weight = [
        Number::timed(lean[0], time),
        Number::timed(lean[1], time),
        Number::from(-g),
    ];
}

/// A shaft in a ring: pressed in, loose, pushed through or turned aside.
pub fn fit(scene: &mut Scene) {
    let count = scene.steps(&[1, 1, 2, 4]);
    let kinds = [0; 2].map(|_| scene.random.pick(&ROUND));
    let around = [0; 2].map(|_| scene.random.pick(&[8, 8, 12]));
    let fit = 2.0 * scene.strain * scene.random.pick(&[-1.0, -1.0, -0.3, 0.0, 0.5]);
    let given = scene.random.chance(0.4);
    let inner = if given { 1.0 } else { 1.0 + 0.5 * fit };
    let shaft_radius = if given { 1.0 } else { 1.0 - 0.5 * fit };
    let long = scene.random.between(0.5, 1.2);
    let out = scene.random.between(0.0, 0.4);
    let wall = scene.random.between(0.3, 0.8);
    let shapes = [
        ("ring", [inner, 1.0 + wall], 0.0, long),
        ("shaft", [0.0, shaft_radius], -out, long + out),
    ];
    for (b, (name, radii, base, height)) in shapes.into_iter().enumerate() {
        let linear = kinds[b].linear();
        let shape = Shape::Cylinder {
            base: [0.0, 0.0, base],
            axis: [0.0, 0.0, 1.0],
            radii,
            height,
            cells: [
                around[b],
                1,
                if linear { scene.random.count(1, 3) } else { 1 },
            ],
        };
        let body = scene.add(name, shape, kinds[b]);
        let (side, radius) = if b == 0 {
            ("inner", radii[0])
        } else {
            ("outer", radii[1])
        };
        let surface = Surface::Cylinder {
            point: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            radius,
            inside: false,
        };
        scene.problem.bodies[body].surfaces = vec![(side.to_string(), surface)];
    }
    let law = scene.law(0.6);
    scene.touch(side("shaft", "outer"), side("ring", "inner"), law);
    if given {
        let contacts = &mut scene.problem.contacts;
        contacts[0].gap = if fit == 0.0 {
            Gap::Closed
        } else {
            Gap::Given(Number::from(fit))
        };
    }
    scene.problem.spins = true;
    scene.hold(0, "bottom", Field::default());
    let p = scene.strain;
    let [x, y] = scene.path(p, [0.1, 0.6], count);
    match scene.random.count(0, 2) {
        0 => {
            let down = Number::timed(-p * scene.random.between(0.0, 2.0), Time::Line(0.0, 0.5));
            scene.hold(1, "top", [x, y, down]);
            scene.holds("ring and shaft are held");
        }
        1 => {
            scene.roll(1, "bottom");
            scene.pull(1, "top", [x, y, Number::default()]);
        }
        _ => {
            let drawn = Number::timed(p, Time::Line(0.0, 0.5));
            let supports = &mut scene.problem.bodies[1].supports;
            supports.push(roller("bottom", drawn));
        }
    }
}
