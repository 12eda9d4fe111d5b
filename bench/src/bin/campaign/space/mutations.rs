//! Tests of the checker: right answers, each spoiled in one way, and the check that must notice.

use super::elastic::nearest;
use super::geometry::{Vector, cross, plus, times};
use super::problem::{
    Against, Body, Contact, Drive, Field, Gap, Held, Law, Load, Number, Shape, Surface, constant,
};
use super::solids::Solid;
use super::{Answer, Mesh, Problem, Step};
use crate::amount::Time;
use crate::problem::{Known, Pairing, side};
use crate::random::Random;
use crate::raw::Status;
use crate::run::Problem as _;
use crate::solve::{Folder, Outcome, solve};

/// A body without supports and loads.
pub fn body(name: &str, shape: Shape, kind: Solid) -> Body {
    Body {
        name: name.to_string(),
        shape,
        kind,
        young: 1.0,
        poisson: 0.3,
        supports: Vec::new(),
        loads: Vec::new(),
        weight: Field::default(),
        surfaces: Vec::new(),
    }
}

pub fn cuboid(from: Vector, to: Vector, cells: [usize; 3]) -> Shape {
    Shape::Cuboid { from, to, cells }
}

pub fn ball(center: Vector, radius: f64, cells: [usize; 2]) -> Shape {
    Shape::Ball {
        center,
        radius,
        cells,
    }
}

fn problem(bodies: Vec<Body>, contacts: Vec<Contact>, count: usize) -> Problem {
    Problem {
        family: "mutations",
        bodies,
        contacts,
        times: (1..=count).map(|t| t as f64).collect(),
        known: Known::Holds,
        reason: String::new(),
        uniform: None,
        spins: false,
        method: "auto".to_string(),
    }
}

/// The mesh that the program makes of a body.
pub fn mesh_of(body: &Body) -> Mesh {
    let text = problem(vec![body.clone()], Vec::new(), 1).text();
    crate::solve::meshes(&text).unwrap().remove(0)
}

fn contact(own: &str, against: Against, law: Law) -> Contact {
    Contact {
        name: "c".to_string(),
        own: side("block", own),
        against,
        pairing: Pairing::Default,
        gap: Gap::Default,
        law,
    }
}

fn plane(normal: Vector, drive: Option<Drive>) -> Against {
    Against::Obstacle {
        surface: Surface::plane([0.0; 3], normal),
        inside: false,
        drive,
    }
}

const UP: Vector = [0.0, 0.0, 1.0];

fn on_floor() -> Against {
    Against::Side {
        side: side("floor", "top"),
        chosen: false,
    }
}

fn block() -> Body {
    let shape = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 3, 2]);
    body("block", shape, Solid::Hex8)
}

fn floor(cells: [usize; 3], out: f64) -> Body {
    let (from, to) = ([-out, -out, -1.0], [2.0 + out, 1.0 + out, 0.0]);
    let mut floor = body("floor", cuboid(from, to, cells), Solid::Hex8);
    hold(&mut floor, "bottom", Field::default());
    floor
}

fn hold(body: &mut Body, side: &str, field: Field) {
    body.supports.push((side.to_string(), Held::All(field)));
}

fn pull(body: &mut Body, side: &str, field: Field) {
    let side = side.to_string();
    body.loads.push(Load::Traction { side, field });
}

/// A block on a rigid plane, pressed, and drawn along a path by its top, until parts of its sole slip.
fn drawn() -> Problem {
    let mut block = block();
    let wave = |size: f64, phase: f64| Number::timed(size, Time::Wave(2.0, phase));
    let path = [wave(6e-4, 0.0), wave(4e-4, 1.0), Number::from(-1e-3)];
    hold(&mut block, "top", path);
    let touch = contact("bottom", plane(UP, None), Law::Coulomb(0.3));
    problem(vec![block], vec![touch], 3)
}

/// A block on a wider one, whose meshes do not fit, with friction, pressed and drawn; nonmortar is the block.
fn paired() -> Problem {
    let mut block = block();
    pull(&mut block, "top", constant([1e-4, -5e-5, -1e-3]));
    let touch = contact("bottom", on_floor(), Law::Coulomb(0.4));
    problem(vec![block, floor([5, 4, 2], 0.3)], vec![touch], 1)
}

/// Two blocks with the same nodes, frictionless.
fn matching() -> Problem {
    let mut block = block();
    let push = Number::new(1e-3, [-2e-4, 0.0, 0.0], Time::Always);
    let top = "top".to_string();
    block.loads.push(Load::Pressure {
        side: top,
        field: push,
    });
    let touch = contact("bottom", on_floor(), Law::Frictionless);
    problem(vec![block, floor([4, 3, 2], 0.0)], vec![touch], 1)
}

/// A block glued below another.
fn glued(cells: [usize; 3]) -> Problem {
    let mut block = block();
    hold(&mut block, "top", Field::default());
    let mut lower = floor(cells, 0.0);
    lower.supports.clear();
    lower.weight = constant([0.0, 3e-4, -1e-3]);
    let touch = contact("bottom", on_floor(), Law::Tied);
    problem(vec![block, lower], vec![touch], 1)
}

/// A stamp that a force presses from below.
fn stamp() -> Problem {
    let mut block = block();
    hold(&mut block, "top", Field::default());
    let force = Some(Drive::Force(constant([0.0, 0.0, 1e-3])));
    let touch = contact("bottom", plane(UP, force), Law::Frictionless);
    problem(vec![block], vec![touch], 1)
}

/// A ball pressed into a block by its weight.
fn round() -> Problem {
    let mut ball = body("block", ball([1.0, 0.5, 1.0], 1.0, [8, 1]), Solid::Hex8);
    ball.weight = constant([0.0, 0.0, -1e-4]);
    // the true surface, as the program knows it for its own meshes
    let sphere = Surface::sphere([1.0, 0.5, 1.0], 1.0);
    ball.surfaces = vec![("outer".to_string(), sphere)];
    let touch = contact("outer", on_floor(), Law::Frictionless);
    problem(vec![ball, floor([5, 4, 2], 0.0)], vec![touch], 1)
}

fn answer(problem: &Problem, name: &str) -> Answer {
    let folder = Folder::new(&format!("space-mutations-{name}")).unwrap();
    match solve(problem, &folder, 60.0) {
        Outcome::Certified(answer) => answer,
        other => panic!("{name}: {other:?}"),
    }
}

fn found(problem: &Problem, answer: &Answer) -> Vec<&'static str> {
    let judgement = problem.check(answer);
    judgement.findings.iter().map(|f| f.what).collect()
}

/// The right answer is right, and the spoiled one is not, for this reason.
fn noticed(
    name: &str,
    problem: &Problem,
    what: &str,
    spoil: impl FnOnce(&mut Problem, &mut Answer),
) {
    let mut answer = answer(problem, &name.replace(' ', "-"));
    let faults = problem.check(&answer).findings;
    assert!(faults.is_empty(), "{name}: {faults:?}");
    let mut other = problem.clone();
    spoil(&mut other, &mut answer);
    let all = found(&other, &answer);
    assert!(all.contains(&what), "{name}: {what} is not among {all:?}");
}

fn last(answer: &mut Answer) -> &mut Step {
    answer.steps.last_mut().unwrap()
}

/// Moves a body rigidly.
fn shift(answer: &mut Answer, body: usize, by: Vector) {
    let moves = &mut last(answer).displacements[body];
    moves.iter_mut().for_each(|u| *u = plus(*u, 1.0, by));
}

#[test]
fn forces_that_are_wrong_inside_are_noticed() {
    noticed("displaced", &matching(), "equilibrium", |_, answer| {
        let inner = nearest(&answer.meshes[0], [1.0, 0.33, 0.5]);
        last(answer).displacements[0][inner][0] += 1e-8;
    });
    noticed("load", &matching(), "equilibrium", |problem, _| {
        problem.bodies[0].weight = constant([0.0, 1e-7, 0.0]);
    });
    noticed("support", &drawn(), "support", |problem, _| {
        hold(&mut problem.bodies[0], "top", constant([0.0; 3]));
    });
}

#[test]
fn bodies_and_obstacles_that_lie_elsewhere_are_noticed() {
    let cases: [(Problem, f64, &str); 6] = [
        (matching(), 1e-7, "open force"),
        (matching(), -1e-7, "penetration"),
        (paired(), 2e-3, "open force"),
        (paired(), -2e-3, "overlap"),
        (paired(), 1e-6, "work"),
        (round(), -5e-1, "overlap"),
    ];
    for (k, (problem, by, what)) in cases.iter().enumerate() {
        let name = format!("lifted {k} {what}");
        noticed(&name, problem, what, |_, answer| {
            shift(answer, 0, [0.0, 0.0, *by]);
        });
    }
    for (name, cells, by) in [("torn", [4, 3, 2], 1e-7), ("torn off", [3, 2, 2], 1e-2)] {
        noticed(name, &glued(cells), "jump", |_, answer| {
            shift(answer, 1, [0.0, by, 0.0]);
        });
    }
    for (name, by, what) in [
        ("raised", 1e-8, "penetration"),
        ("lowered", -1e-8, "open force"),
    ] {
        noticed(name, &drawn(), what, |problem, _| {
            if let Against::Obstacle { surface, .. } = &mut problem.contacts[0].against {
                surface.point[2] += by;
            }
        });
    }
}

#[test]
fn rows_that_say_something_else_are_noticed() {
    type Spoil = fn(&mut super::Row);
    let turned: Spoil = |row| row.shear = cross(row.normal, row.shear);
    let cases: [(Problem, &str, Spoil); 12] = [
        (drawn(), "row force", |row| row.pressure *= 1.001),
        (drawn(), "row force", turned),
        (drawn(), "tension", |row| row.pressure *= -1.0),
        (drawn(), "gap", |row| row.gap += 1e-8),
        (drawn(), "slip", |row| row.slip[0] += 1e-8),
        (drawn(), "penetration", |row| row.gap -= 1e-8),
        (drawn(), "shear sign", turned),
        (drawn(), "weight", |row| {
            (row.weight, row.pressure) = (1.01 * row.weight, row.pressure / 1.01);
        }),
        (paired(), "row sum", |row| row.pressure *= 1.01),
        (paired(), "row sum", turned),
        (paired(), "work", |row| row.gap += 1e-5),
        (paired(), "weight", |row| row.weight *= 1.1),
    ];
    for (k, (problem, what, spoil)) in cases.iter().enumerate() {
        noticed(&format!("row {k} {what}"), problem, what, |_, answer| {
            last(answer).contacts[0].rows.iter_mut().for_each(spoil);
        });
    }
    for problem in [drawn(), paired(), round()] {
        noticed("normal", &problem, "normal", |_, answer| {
            for row in &mut answer.steps[0].contacts[0].rows {
                row.normal = times(-1.0, row.normal);
            }
        });
    }
    noticed("uneven", &matching(), "pressure", |problem, _| {
        problem.uniform = Some(1e-3);
    });
}

#[test]
fn friction_is_judged_by_its_law() {
    noticed("bound", &drawn(), "shear", |problem, _| {
        problem.contacts[0].law = Law::Coulomb(0.27);
    });
    noticed("smooth", &drawn(), "shear", |problem, _| {
        problem.contacts[0].law = Law::Frictionless;
    });
    // another history: stuck nodes have slipped in this step, slipping nodes went the other way
    noticed("stuck", &drawn(), "stuck slip", |_, answer| {
        for row in &mut answer.steps[1].contacts[0].rows {
            row.slip[0] += 1e-6;
        }
    });
    noticed("backwards", &drawn(), "shear sign", |_, answer| {
        for row in &mut answer.steps[1].contacts[0].rows {
            row.slip = times(5.0, row.slip);
        }
    });
}

#[test]
fn resultants_are_compared() {
    noticed("react", &paired(), "act and react", |_, answer| {
        let moves = &mut last(answer).displacements[1];
        moves.iter_mut().for_each(|u| *u = times(1.001, *u));
    });
    noticed("force", &paired(), "resultant", |_, answer| {
        last(answer).contacts[0].resultant[2] *= 1.001;
    });
    noticed("moment", &paired(), "resultant", |_, answer| {
        last(answer).contacts[0].moment[0] *= 1.001;
    });
    noticed("reaction", &paired(), "reaction", |_, answer| {
        last(answer).reactions[1][2] *= 1.001;
    });
    noticed("stamp", &stamp(), "obstacle", |problem, _| {
        if let Against::Obstacle { drive, .. } = &mut problem.contacts[0].against {
            *drive = Some(Drive::Force(constant([0.0, 0.0, 1.001e-3])));
        }
    });
}

#[test]
fn forces_from_where_nothing_faces_are_noticed() {
    for what in ["footprint", "outside"] {
        // half of the floor is missing: the resultant of the block lies in the middle
        noticed(what, &paired(), what, |_, answer| {
            let mesh = &mut answer.meshes[1];
            let points = mesh.points.clone();
            let top = mesh.sides.get_mut("top").unwrap();
            top.retain(|facet| facet.iter().all(|&n| points[n][0] < 0.8));
        });
    }
    // a couple about the normal that only a tie can bear
    noticed("spun", &matching(), "footprint", |problem, answer| {
        let swirl = |slope| Number::new(0.0, slope, Time::Always);
        let field = [
            swirl([0.0, 1e-3, 0.0]),
            swirl([-1e-3, 0.0, 0.0]),
            Number::from(-1e-4),
        ];
        pull(&mut problem.bodies[0], "top", field);
        let mut tied = problem.clone();
        tied.contacts[0].law = Law::Tied;
        *answer = self::answer(&tied, "spun-glued");
        for row in &mut answer.steps[0].contacts[0].rows {
            row.status = Status::Closed;
        }
    });
}

/// Twins of a right answer agree with it, and one under another load does not.
#[test]
fn twins_agree_and_strangers_do_not() {
    let problem = matching();
    let mine = answer(&problem, "twins");
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..12 {
        for mut twin in problem.twins(&mine, &mut Random::new(seed)) {
            if !seen.insert(twin.name) {
                continue;
            }
            let other = answer(&twin.problem, "twin");
            assert_eq!(found(&twin.problem, &other), Vec::<&str>::new());
            let off = |twin: &_, other| crate::twin::difference(&problem, &mine, twin, other);
            assert!(off(&twin, &other).unwrap() < 1e-9, "{}", twin.name);
            for load in twin.problem.bodies.iter_mut().flat_map(|b| &mut b.loads) {
                if let Load::Pressure { field, .. } = load {
                    *field = field.times(1.001);
                }
            }
            let other = answer(&twin.problem, "stranger");
            assert!(off(&twin, &other).unwrap() > 1e-4, "{}", twin.name);
        }
    }
    assert_eq!(seen.len(), 2, "{seen:?}");
}
