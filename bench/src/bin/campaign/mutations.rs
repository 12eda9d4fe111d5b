//! Tests of the checker: right answers, each spoiled in one way, and the check that must notice.

use crate::amount::{Amount, Time};
use crate::cells::Kind;
use crate::check::check;
use crate::plane::{minus, plus, rotated, times, turned};
use crate::problem::{
    Against, Analysis, Body, Contact, Drive, Gap, Known, Law, Load, Pairing, Problem, Shape,
    Support, Surface, clamp, hold, moved, on, side, steps,
};
use crate::raw::{Answer, Status};
use crate::solve::{Folder, Outcome, solve};

fn body(name: &str, shape: Shape, kind: Kind) -> Body {
    Body {
        name: name.to_string(),
        shape,
        kind,
        patches: Vec::new(),
        young: 1.0,
        poisson: 0.3,
        thickness: 1.0,
        supports: Vec::new(),
        loads: Vec::new(),
        weight: Default::default(),
        circles: Vec::new(),
        more: Default::default(),
    }
}

fn block(name: &str, from: [f64; 2], to: [f64; 2], cells: [usize; 2]) -> Body {
    let shape = Shape::Rectangle {
        from,
        to,
        cells,
        diagonals: "forward",
    };
    body(name, shape, Kind::Quad4)
}

fn contact(own: &str, own_side: &str, against: Against, law: Law) -> Contact {
    Contact {
        name: "c".to_string(),
        own: side(own, own_side),
        against,
        pairing: Pairing::Default,
        gap: Gap::Default,
        law,
    }
}

fn problem(bodies: Vec<Body>, contacts: Vec<Contact>, count: usize) -> Problem {
    Problem {
        family: "mutations",
        analysis: Analysis::PlaneStrain,
        bodies,
        contacts,
        times: steps(count),
        known: Known::Holds,
        reason: String::new(),
        uniform: None,
        spins: false,
        method: "auto".to_string(),
        drawing: None,
        sections: Vec::new(),
        other: None,
        idle: Vec::new(),
        past: 0,
    }
}

fn plane() -> Against {
    Against::Obstacle {
        surface: Surface::Plane {
            point: [0.0, 0.0],
            normal: [0.0, 1.0],
        },
        drive: Drive::Nothing,
    }
}

fn top_load(field: [Amount; 2]) -> Load {
    Load::Traction {
        side: "top".to_string(),
        field,
    }
}

fn floor_body() -> Against {
    Against::Side {
        side: side("floor", "top"),
        chosen: false,
    }
}

/// A block on a rigid plane, pressed, and drawn to and fro along its top, until parts of its sole slip.
fn drawn() -> Problem {
    let mut block = block("block", [0.0, 0.0], [2.0, 1.0], [8, 4]);
    block.supports = vec![
        moved(on("top"), 0, Amount::timed(6e-4, Time::Wave(2.0, 0.0))),
        moved(on("top"), 1, Amount::from(-1e-3)),
    ];
    let law = Law::Coulomb(Amount::from(0.3));
    problem(
        vec![block],
        vec![contact("block", "bottom", plane(), law)],
        3,
    )
}

/// A block on a wider one, whose meshes do not fit, with friction, pressed and drawn; nonmortar is the block.
fn paired() -> Problem {
    let mut upper = block("block", [0.0, 0.0], [2.0, 1.0], [7, 4]);
    upper.loads = vec![top_load([Amount::from(1e-4), Amount::from(-1e-3)])];
    let mut floor = block("floor", [-0.5, -1.0], [2.5, 0.0], [13, 4]);
    floor.supports = vec![clamp(on("bottom"))];
    let law = Law::Coulomb(Amount::from(0.4));
    let touch = contact("block", "bottom", floor_body(), law);
    problem(vec![upper, floor], vec![touch], 1)
}

/// Two blocks with the same nodes, frictionless.
fn matching() -> Problem {
    let mut upper = block("block", [0.0, 0.0], [2.0, 1.0], [8, 4]);
    upper.supports = vec![hold(on("left"), 0)];
    upper.loads = vec![top_load([
        Amount::default(),
        Amount::new(-1e-3, [2e-4, 0.0], Time::Always),
    ])];
    let mut floor = block("floor", [0.0, -1.0], [2.0, 0.0], [8, 3]);
    floor.supports = vec![clamp(on("bottom"))];
    let touch = contact("block", "bottom", floor_body(), Law::Frictionless);
    problem(vec![upper, floor], vec![touch], 1)
}

/// A block glued below another.
fn glued(matching: bool) -> Problem {
    let mut upper = block("block", [0.0, 0.0], [2.0, 1.0], [8, 4]);
    upper.supports = vec![clamp(on("top"))];
    let mut lower = block(
        "floor",
        [0.0, -1.0],
        [2.0, 0.0],
        [if matching { 8 } else { 5 }, 4],
    );
    lower.weight[1] = Amount::from(-1e-3);
    problem(
        vec![upper, lower],
        vec![contact("block", "bottom", floor_body(), Law::Tied)],
        1,
    )
}

/// A stamp that a force presses from below.
fn stamp() -> Problem {
    let mut upper = block("block", [0.0, 0.0], [2.0, 1.0], [8, 4]);
    upper.supports = vec![clamp(on("top"))];
    let mut against = plane();
    if let Against::Obstacle { drive, .. } = &mut against {
        *drive = Drive::Force([Amount::from(0.0), Amount::from(1e-3)]);
    }
    problem(
        vec![upper],
        vec![contact("block", "bottom", against, Law::Frictionless)],
        1,
    )
}

/// A disc under its weight on a plane or on a block.
fn disc(elastic: bool) -> Problem {
    let shape = Shape::Ring {
        center: [0.0, 1.0],
        radii: [0.2, 1.0],
        angles: None,
        cells: [32, 4],
        ratio: 1.2,
    };
    let mut round = body("block", shape, Kind::Quad4);
    round.weight[1] = Amount::from(-1e-4);
    if elastic {
        let mut floor = block("floor", [-1.0, -1.0], [1.0, 0.0], [13, 5]);
        floor.supports = vec![clamp(on("bottom"))];
        let touch = contact("block", "outer", floor_body(), Law::Frictionless);
        return problem(vec![round, floor], vec![touch], 1);
    }
    problem(
        vec![round],
        vec![contact("block", "outer", plane(), Law::Frictionless)],
        1,
    )
}

/// A block in a corner of two planes without friction: its corner node is in two contacts.
fn corner() -> Problem {
    let mut block = block("block", [0.0, 0.0], [1.0, 1.0], [4, 4]);
    block.loads = vec![
        top_load([Amount::default(), Amount::from(-1e-3)]),
        Load::Traction {
            side: "right".to_string(),
            field: [Amount::from(-1e-3), Amount::default()],
        },
    ];
    let mut wall = contact("block", "left", plane(), Law::Frictionless);
    wall.name = "wall".to_string();
    if let Against::Obstacle { surface, .. } = &mut wall.against {
        *surface = Surface::Plane {
            point: [0.0, 0.0],
            normal: [1.0, 0.0],
        };
    }
    let floor = contact("block", "bottom", plane(), Law::Frictionless);
    problem(vec![block], vec![floor, wall], 1)
}

fn answer(problem: &Problem, name: &str) -> Answer {
    let folder = Folder::new(&format!("mutations-{name}")).unwrap();
    match solve(problem, &folder, 60.0) {
        Outcome::Certified(answer) => answer,
        other => panic!("{name}: {other:?}"),
    }
}

/// The names of the findings.
fn found(problem: &Problem, answer: &Answer) -> Vec<&'static str> {
    check(problem, answer)
        .findings
        .iter()
        .map(|f| f.what)
        .collect()
}

/// The right answer is right, and the spoiled one is not, for this reason.
fn noticed(
    name: &str,
    problem: &Problem,
    what: &str,
    spoil: impl FnOnce(&mut Problem, &mut Answer),
) {
    let mut answer = answer(problem, name);
    assert_eq!(
        found(problem, &answer),
        Vec::<&str>::new(),
        "{name} is right"
    );
    let mut other = problem.clone();
    spoil(&mut other, &mut answer);
    let all = found(&other, &answer);
    assert!(all.contains(&what), "{name}: {what} is not among {all:?}");
}

/// The node of the first body nearest to a point.
fn node(answer: &Answer, x: [f64; 2]) -> usize {
    crate::elastic::nearest(&answer.meshes[0], x)
}

fn last(answer: &mut Answer) -> &mut crate::raw::Step {
    answer.steps.last_mut().unwrap()
}

#[test]
fn a_displaced_node_is_noticed() {
    noticed("displaced", &matching(), "equilibrium", |_, answer| {
        let inner = node(answer, [1.0, 0.5]);
        last(answer).displacements[0][inner][0] += 1e-8;
    });
}

#[test]
fn another_load_or_support_is_noticed() {
    noticed("load", &matching(), "equilibrium", |problem, _| {
        problem.bodies[0].weight[1] = Amount::from(-1e-7);
    });
    noticed("support", &drawn(), "support", |problem, _| {
        problem.bodies[0].supports[1] = moved(on("top"), 1, Amount::from(-1.001e-3));
    });
}

/// Moves the first body rigidly.
fn lifted(answer: &mut Answer, by: [f64; 2]) {
    last(answer).displacements[0]
        .iter_mut()
        .for_each(|u| *u = plus(*u, 1.0, by));
}

#[test]
fn a_lifted_or_sunken_body_is_noticed() {
    noticed("lifted", &matching(), "open force", |_, answer| {
        lifted(answer, [0.0, 1e-7])
    });
    noticed("sunken", &matching(), "penetration", |_, answer| {
        lifted(answer, [0.0, -1e-7])
    });
    noticed(
        "lifted on other nodes",
        &paired(),
        "open force",
        |_, answer| {
            lifted(answer, [0.0, 1e-3]);
        },
    );
    noticed(
        "sunken on other nodes",
        &paired(),
        "overlap",
        |_, answer| {
            lifted(answer, [0.0, -1e-3]);
        },
    );
    noticed("torn", &glued(true), "jump", |_, answer| {
        last(answer).displacements[1]
            .iter_mut()
            .for_each(|u| u[0] += 1e-7);
    });
    noticed("torn on other nodes", &glued(false), "jump", |_, answer| {
        last(answer).displacements[1]
            .iter_mut()
            .for_each(|u| u[0] += 1e-3);
    });
}

#[test]
fn a_moved_obstacle_is_noticed() {
    let move_plane = |problem: &mut Problem, by: f64| {
        if let Against::Obstacle {
            surface: Surface::Plane { point, .. },
            ..
        } = &mut problem.contacts[0].against
        {
            point[1] += by;
        }
    };
    noticed("raised", &drawn(), "penetration", |problem, _| {
        move_plane(problem, 1e-8)
    });
    noticed("lowered", &drawn(), "open force", |problem, _| {
        move_plane(problem, -1e-8)
    });
    noticed(
        "second obstacle",
        &drawn(),
        "penetration",
        |problem, answer| {
            // an obstacle that is missing in the answer: its rows are all open
            let mut higher = problem.contacts[0].clone();
            if let Against::Obstacle {
                surface: Surface::Plane { point, .. },
                ..
            } = &mut higher.against
            {
                point[1] = 1e-6;
            }
            problem.contacts.push(higher);
            for step in &mut answer.steps {
                let mut open = step.contacts[0].clone();
                for row in &mut open.rows {
                    (row.pressure, row.shear, row.gap, row.status) =
                        (0.0, [0.0; 2], 1.0, Status::Open);
                }
                step.contacts.push(open);
            }
        },
    );
    noticed("moved along", &drawn(), "stuck slip", |problem, _| {
        if let Against::Obstacle { drive, .. } = &mut problem.contacts[0].against {
            *drive =
                Drive::Displacement([Amount::timed(1e-5, Time::Line(0.0, 1.0)), Amount::default()]);
        }
    });
}

#[test]
fn dropped_and_changed_rows_are_noticed() {
    noticed("dropped", &drawn(), "row force", |_, answer| {
        last(answer).contacts[0].rows[3].pressure = 0.0;
    });
    noticed("shear flipped", &drawn(), "row force", |_, answer| {
        let row = &mut last(answer).contacts[0].rows[3];
        row.shear = times(-1.0, row.shear);
    });
    noticed(
        "dropped on other nodes",
        &paired(),
        "row sum",
        |_, answer| {
            last(answer).contacts[0].rows[3].pressure = 0.0;
        },
    );
    noticed("pulling", &drawn(), "tension", |_, answer| {
        last(answer).contacts[0].rows[3].pressure *= -1.0;
    });
    noticed("weight", &drawn(), "weight", |_, answer| {
        let row = &mut last(answer).contacts[0].rows[3];
        (row.weight, row.pressure) = (row.weight * 1.01, row.pressure / 1.01);
    });
    noticed(
        "weights on other nodes",
        &paired(),
        "weight",
        |_, answer| {
            last(answer).contacts[0].rows[3].weight *= 1.05;
        },
    );
    for (name, problem) in [
        ("disc", disc(true)),
        ("disc on a plane", disc(false)),
        ("flat", matching()),
    ] {
        noticed(name, &problem, "normal", |_, answer| {
            for row in &mut answer.steps[0].contacts[0].rows {
                row.normal = rotated(row.normal, 0.5);
            }
        });
    }
    noticed("uneven", &matching(), "pressure", |problem, _| {
        problem.uniform = Some(Amount::from(1e-3));
    });
}

/// Wrong laws, shears and slips are noticed.
#[test]
fn friction_is_judged_by_its_law() {
    noticed("bound", &drawn(), "shear", |problem, _| {
        problem.contacts[0].law = Law::Coulomb(Amount::from(0.27));
    });
    noticed("stuck", &drawn(), "stuck slip", |_, answer| {
        // another history: what stuck now slipped in this step
        let before = &mut answer.steps[1].displacements[0];
        before.iter_mut().for_each(|u| u[0] += 1e-6);
    });
    noticed("backwards", &drawn(), "shear sign", |_, answer| {
        let before = &mut answer.steps[1].displacements[0];
        before.iter_mut().for_each(|u| u[0] *= 3.0);
    });
    noticed(
        "backwards on other nodes",
        &paired(),
        "stuck slip",
        |_, answer| {
            lifted(answer, [-1e-3, 0.0]);
        },
    );
    noticed("smooth", &drawn(), "shear", |problem, _| {
        problem.contacts[0].law = Law::Frictionless;
    });
}

#[test]
fn sides_that_feel_different_forces_are_noticed() {
    noticed("react", &paired(), "act and react", |_, answer| {
        last(answer).displacements[1]
            .iter_mut()
            .for_each(|u| *u = times(1.001, *u));
    });
    noticed("stamp", &stamp(), "obstacle", |problem, _| {
        if let Against::Obstacle { drive, .. } = &mut problem.contacts[0].against {
            *drive = Drive::Force([Amount::from(0.0), Amount::from(1.001e-3)]);
        }
    });
}

#[test]
fn forces_from_where_nothing_faces_are_noticed() {
    let cut = |answer: &mut Answer, keep: fn(f64) -> bool| {
        let mesh = &mut answer.meshes[1];
        let points = mesh.points.clone();
        let top = mesh.sides.get_mut("top").unwrap();
        top.retain(|facet| facet.iter().all(|&n| keep(points[n][0])));
    };
    // half of the floor is missing: the resultant of the block lies in the middle
    noticed("footprint", &paired(), "footprint", move |_, answer| {
        cut(answer, |x| x < 0.6)
    });
    noticed("outside", &paired(), "outside", move |_, answer| {
        cut(answer, |x| x < 0.6)
    });
    // the load tips the block: any forces that hold it must pull somewhere
    noticed("tipping", &matching(), "footprint", |problem, answer| {
        let [a, b] = [[0.0, 1.0], [2.0, 1.0]].map(|x| node(answer, x));
        let force = |x, y| Load::Force {
            point: x,
            field: [Amount::default(), Amount::from(y)],
        };
        problem.bodies[0].supports.clear();
        problem.bodies[0].loads.clear();
        problem.bodies[0].loads.push(force([0.0, 1.0], 1e-3));
        problem.bodies[0].loads.push(force([2.0, 1.0], -2e-3));
        // displacements that no contact could cause, but the forces of a glued sole
        let mut tied = problem.clone();
        tied.contacts[0].law = Law::Tied;
        *answer = self::answer(&tied, "tipping glued");
        debug_assert!(a != b);
        for row in &mut answer.steps[0].contacts[0].rows {
            row.status = Status::Closed;
            row.pressure = row.pressure.max(0.0);
        }
    });
}

#[test]
fn the_force_at_a_corner_must_be_one_that_its_contacts_allow() {
    let lose = |answer: &mut Answer| {
        let corner = node(answer, [0.0, 0.0]);
        for contact in &mut last(answer).contacts {
            for row in contact.rows.iter_mut().filter(|r| r.node == corner) {
                (row.pressure, row.shear, row.status) = (f64::NAN, [f64::NAN; 2], Status::Fixed);
            }
        }
    };
    // without its rows the corner is still right
    let right = corner();
    let mut whole = answer(&right, "corner");
    lose(&mut whole);
    assert_eq!(found(&right, &whole), Vec::<&str>::new());
    noticed("corner pulls", &right, "corner", move |problem, answer| {
        lose(answer);
        // a force outwards at the corner that nothing can hold
        problem.bodies[0].loads.push(Load::Force {
            point: [0.0, 0.0],
            field: [Amount::from(1e-3), Amount::from(1e-3)],
        });
    });
    noticed("corner open", &right, "corner", move |problem, answer| {
        lose(answer);
        // the wall is not there
        if let Against::Obstacle {
            surface: Surface::Plane { point, .. },
            ..
        } = &mut problem.contacts[1].against
        {
            *point = minus(*point, [1e-6, 0.0]);
        }
    });
}

/// Every kind of twin of a right answer agrees with it, and one under another load does not.
#[test]
fn twins_agree_and_strangers_do_not() {
    let problem = matching();
    let mine = answer(&problem, "twins");
    let folder = Folder::new("mutations-twins-asked").unwrap();
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..60 {
        let mut random = crate::random::Random::new(seed);
        for mut twin in crate::twins::twins(&problem, &mine, &mut random) {
            if !seen.insert(twin.name) {
                continue;
            }
            let ask = |twin: &Problem| match solve(twin, &folder, 60.0) {
                Outcome::Certified(other) => other,
                other => panic!("{other:?}"),
            };
            let other = ask(&twin.problem);
            assert_eq!(
                found(&twin.problem, &other),
                Vec::<&str>::new(),
                "{}",
                twin.name
            );
            let off = crate::twin::difference(&problem, &mine, &twin, &other).unwrap();
            assert!(off < 1e-9, "{}: {off}", twin.name);
            for load in twin.problem.bodies.iter_mut().flat_map(|b| &mut b.loads) {
                if let Load::Traction { field, .. } = load {
                    *field = [field[0].times(1.001), field[1].times(1.001)];
                }
            }
            let other = ask(&twin.problem);
            let off = crate::twin::difference(&problem, &mine, &twin, &other).unwrap();
            assert!(off > 1e-4, "{}: {off}", twin.name);
        }
    }
    assert_eq!(seen.len(), 5, "{seen:?}");
}

#[test]
fn wrong_columns_and_sums_are_noticed() {
    noticed("gap", &drawn(), "gap", |_, answer| {
        last(answer).contacts[0].rows[2].gap += 1e-8
    });
    noticed("slip", &drawn(), "slip", |_, answer| {
        let row = &mut last(answer).contacts[0].rows[2];
        row.slip = plus(row.slip, 1e-8, turned(row.normal));
    });
    noticed("resultant", &paired(), "resultant", |_, answer| {
        last(answer).contacts[0].resultant[1] *= 1.001;
    });
    noticed("reaction", &paired(), "reaction", |_, answer| {
        last(answer).reactions[1][1] *= 1.001;
    });
    noticed("roller", &matching(), "support", |problem, _| {
        problem.bodies[1].supports.push(Support {
            place: on("left"),
            axes: [None, None],
            normal: Some(Amount::from(1e-6)),
            from: None,
        });
    });
}

/// A problem of a family by name.
fn family(name: &str, seed: u64) -> Problem {
    crate::families::problem(seed, Some(name), false)
}

#[test]
fn a_body_that_stands_in_one_that_nobody_named_is_noticed() {
    let apart = (0..).map(|seed| family("travel", seed)).find(|problem| {
        problem.known == Known::Holds && problem.contacts.is_empty() && problem.bodies.len() == 3
    });
    noticed("travel", &apart.unwrap(), "stands in", |_, answer| {
        // the floor rises into post and slider
        let points = answer.meshes.iter().flat_map(|mesh| &mesh.points);
        let high = points.fold(0.0, |s: f64, x| s.max(x[1]));
        lifted(answer, [0.0, 0.5 * high]);
    });
}

#[test]
fn another_bed_bar_or_material_is_noticed() {
    noticed("bed", &family("bed", 0), "equilibrium", |problem, _| {
        problem.bodies[0].more.springs[0].normal *= 1.001;
    });
    noticed("bar", &family("bar", 0), "equilibrium", |problem, _| {
        problem.bodies[1].more.bar.as_mut().unwrap().stiffness *= 1.01;
    });
    // one that has yielded: its elastic stiffness is far larger than its tangent stiffness
    let yields = |p: &Problem| {
        let gives = p.bodies[1].more.bar.as_ref().unwrap().gives.as_ref();
        gives.is_some_and(|gives| gives.most.is_some())
    };
    let has_yielded = (0..).map(|seed| family("yielding", seed)).filter(yields);
    let has_yielded = has_yielded.into_iter().find(|problem| {
        let answer = answer(problem, "yielding");
        let bar = problem.bodies[1].more.bar.as_ref().unwrap();
        let node = crate::elastic::nearest(&answer.meshes[1], bar.at);
        let ways = answer.steps.iter().map(|s| s.displacements[1][node][0]);
        Some(bar.tension(ways).abs()) == bar.gives.as_ref().unwrap().most
    });
    noticed(
        "yielding",
        &has_yielded.unwrap(),
        "equilibrium",
        |problem, _| {
            let bar = problem.bodies[1].more.bar.as_mut().unwrap();
            *bar.gives.as_mut().unwrap().most.as_mut().unwrap() *= 1.01;
        },
    );
    noticed(
        "layers",
        &family("layers", 0),
        "equilibrium",
        |problem, _| {
            problem.bodies[0].more.beyond.as_mut().unwrap().young *= 1.001;
        },
    );
}

#[test]
fn another_force_in_a_section_is_noticed() {
    // many cells, so that the tractions beside the punch have decayed at the held end
    let fine = (0..).map(|seed| family("section", seed));
    let fine = fine.into_iter().find(|p| p.sections[0].stations.len() > 24);
    let fine = fine.unwrap();
    for force in 2..5 {
        noticed("section", &fine, "section", |_, answer| {
            let stations = &mut last(answer).sections[0];
            let sizes = stations.iter().map(|station| station[force].abs());
            let largest = sizes.fold(0.0, f64::max);
            stations[0][force] += 0.05 * largest;
        });
    }
}

#[test]
fn ground_that_moves_at_rest_or_presses_otherwise_is_noticed() {
    let at_rest = (0..).map(|seed| family("ground", seed));
    let at_rest = at_rest.into_iter().find(|p| p.uniform.is_some()).unwrap();
    noticed("ground", &at_rest, "idle", |problem, answer| {
        let stress = problem.bodies[0].more.initial.as_ref().unwrap()[1].at([0.0; 2], 1.0);
        let young = problem.bodies[0].young;
        let high = answer.meshes[0].points[0][1].abs();
        lifted(answer, [0.0, 1e-4 * stress / young * high]);
    });
    noticed("ground", &at_rest, "pressure", |_, answer| {
        last(answer).contacts[0].rows[0].pressure *= 1.01;
    });
}

#[test]
fn a_joint_that_bears_more_than_its_strength_is_noticed() {
    let strong = (0..).map(|seed| family("joint", seed)).find(|problem| {
        let all = |row: &crate::raw::Row| -row.pressure;
        let folder = Folder::new("mutations-joint").unwrap();
        let Outcome::Certified(answer) = solve(problem, &folder, 60.0) else {
            return false;
        };
        let rows = answer.steps.iter().flat_map(|s| &s.contacts[0].rows);
        rows.map(all).fold(0.0, f64::max) > 0.0
    });
    noticed("joint", &strong.unwrap(), "tension", |problem, _| {
        if let Law::Joint { tension, .. } = &mut problem.contacts[0].law {
            *tension = 0.0;
        }
    });
}

#[test]
fn metal_that_yields_elsewhere_or_hardens_otherwise_is_noticed() {
    let is_soft = |p: &Problem| p.bodies.len() == 2 && p.bodies[1].more.metal.is_some();
    let has_yielded = |problem: &Problem| {
        let folder = Folder::new("mutations-metal").unwrap();
        let Outcome::Certified(answer) = solve(problem, &folder, 60.0) else {
            return false;
        };
        let mut elastic = problem.clone();
        elastic.bodies[1].more.metal = None;
        found(&elastic, &answer).contains(&"equilibrium")
    };
    let hardens = |p: &Problem| {
        let metal = p.bodies[1].more.metal.as_ref();
        metal.is_some_and(|metal| metal.hardening > 0.0)
    };
    let all = (0..).map(|seed| family("metal", seed)).filter(is_soft);
    let found = all.filter(hardens).find(has_yielded).unwrap();
    noticed("metal", &found, "equilibrium", |problem, _| {
        problem.bodies[1].more.metal.as_mut().unwrap().yields *= 1.01;
    });
    noticed("metal", &found, "equilibrium", |problem, _| {
        problem.bodies[1].more.metal.as_mut().unwrap().hardening *= 1.5;
    });
}
