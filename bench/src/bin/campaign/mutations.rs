//! Tests of the checker: right answers, each spoiled in one way, and the check that must notice.

use crate::amount::{Amount, Time};
use crate::cells::Kind;
use crate::check::check;
use crate::dimension::Dimension;
use crate::problem::{
    Against, Analysis, Body, Contact, Drive, Field, Gap, Known, Law, Load, Pairing, Place, Problem,
    Shape, Surface, clamp, constant, driven, hold, on, roller, side, steps,
};
use crate::random::Random;
use crate::raw::{Answer, Mesh, Row, Status, Step};
use crate::solve::{Folder, Outcome, Solvable, solve};
use crate::twin::difference;
use crate::vector::{axes, cross, lowered, minus, plus, tangents, times};

/// A body without supports and loads.
pub fn body<const D: usize>(name: &str, shape: Shape<D>, kind: Kind) -> Body<D> {
    Body::new(name, shape, kind, [1.0, 0.3])
}

/// A rectangle or a box.
pub fn block<const D: usize>(from: [f64; D], to: [f64; D], cells: [usize; D]) -> Shape<D> {
    Shape::Block {
        from,
        to,
        cells,
        diagonals: "forward",
    }
}

/// A ball.
pub fn ball(center: [f64; 3], radius: f64, cells: [usize; 2]) -> Shape<3> {
    Shape::Ball {
        center,
        radius,
        cells,
    }
}

/// The mesh that the program makes of a body.
pub fn mesh_of<const D: usize>(body: &Body<D>) -> Mesh<D>
where
    Problem<D>: Solvable<D>,
{
    let text = problem(vec![body.clone()], Vec::new(), 1).text();
    crate::solve::meshes(&text).unwrap().remove(0)
}

fn problem<const D: usize>(
    bodies: Vec<Body<D>>,
    contacts: Vec<Contact<D>>,
    count: usize,
) -> Problem<D> {
    let analysis = if D == 2 {
        Analysis::PlaneStrain
    } else {
        Analysis::Space
    };
    Problem {
        bodies,
        contacts,
        times: steps(count),
        known: Known::Holds,
        ..Problem::new("mutations", analysis)
    }
}

/// A vector along, across (in space alone) and upwards.
fn v<const D: usize>(along: f64, across: f64, up: f64) -> [f64; D] {
    lowered(if D == 2 {
        [along, up, 0.0]
    } else {
        [along, across, up]
    })
}

/// Numbers of cells along, across (in space alone) and upwards.
fn cells<const D: usize>(plane: [usize; 2], space: [usize; 3]) -> [usize; D] {
    std::array::from_fn(|d| if D == 2 { plane[d] } else { space[d] })
}

fn contact<const D: usize>(own: &str, against: Against<D>, law: Law<D>) -> Contact<D> {
    Contact {
        name: "c".to_string(),
        own: side("block", own),
        against,
        pairing: Pairing::Default,
        gap: Gap::Default,
        law,
    }
}

/// A rigid plane through the origin.
fn plane<const D: usize>(normal: [f64; D], drive: Drive<D>) -> Against<D> {
    let point = [0.0; D];
    Against::Obstacle {
        surface: Surface::Plane { point, normal },
        drive,
    }
}

fn ground<const D: usize>() -> Against<D> {
    plane(v(0.0, 0.0, 1.0), Drive::Nothing)
}

fn on_floor<const D: usize>() -> Against<D> {
    Against::Side {
        side: side("floor", "top"),
        chosen: false,
    }
}

fn upper<const D: usize>(cells: [usize; D]) -> Body<D> {
    let shape = block([0.0; D], v(2.0, 1.0, 1.0), cells);
    body(
        "block",
        shape,
        if D == 2 { Kind::Quad4 } else { Kind::Hex8 },
    )
}

fn floor<const D: usize>(cells: [usize; D], out: f64) -> Body<D> {
    let (from, to) = (v(-out, -out, -1.0), v(2.0 + out, 1.0 + out, 0.0));
    let kind = if D == 2 { Kind::Quad4 } else { Kind::Hex8 };
    let mut floor = body("floor", block(from, to, cells), kind);
    floor.supports = vec![clamp(on("bottom"))];
    floor
}

/// A block on a rigid plane, pressed, and drawn along a path by its top, until parts of its sole slip.
fn drawn<const D: usize>() -> Problem<D> {
    let mut block = upper(cells([8, 4], [4, 3, 2]));
    let wave = |size: f64, phase: f64| Amount::timed(size, Time::Wave(2.0, phase));
    let mut path: Field<D> = constant(v(0.0, 0.0, -1e-3));
    path[0] = wave(6e-4, 0.0);
    if D == 3 {
        path[1] = wave(4e-4, 1.0);
    }
    block.supports = vec![driven(on("top"), path)];
    let touch = contact("bottom", ground(), Law::rubbing(0.3));
    problem(vec![block], vec![touch], 3)
}

/// A block on a wider one, whose meshes do not fit, with friction, pressed and drawn; nonmortar is the block.
fn paired<const D: usize>() -> Problem<D> {
    let mut block = upper(cells([7, 4], [4, 3, 2]));
    block.pull("top", constant(v(1e-4, -5e-5, -1e-3)));
    let floor = floor(cells([13, 4], [5, 4, 2]), if D == 2 { 0.5 } else { 0.3 });
    let touch = contact("bottom", on_floor(), Law::rubbing(0.4));
    problem(vec![block, floor], vec![touch], 1)
}

/// Two blocks with the same nodes, frictionless.
fn matching<const D: usize>() -> Problem<D> {
    let mut block = upper(cells([8, 4], [4, 3, 2]));
    block.press(
        "top",
        Amount::new(1e-3, times(-2e-4, axes()[0]), Time::Always),
    );
    if D == 2 {
        block.supports = vec![hold(on("left"), 0)];
    }
    let floor = floor(cells([8, 3], [4, 3, 2]), 0.0);
    let touch = contact("bottom", on_floor(), Law::Frictionless);
    problem(vec![block, floor], vec![touch], 1)
}

/// Two blocks whose rows tell the work of their forces although the meshes do not fit: in the plane without friction.
fn working<const D: usize>() -> Problem<D> {
    if D == 3 {
        return paired();
    }
    let mut problem = matching();
    let point = Place::Point(v(0.0, 0.0, 1.0));
    problem.bodies[0].supports = vec![hold(point, 0)];
    problem.bodies[1] = floor(cells([13, 4], [5, 4, 2]), 0.5);
    problem
}

/// A block glued below another.
fn glued<const D: usize>(matching: bool) -> Problem<D> {
    let mut block = upper(cells([8, 4], [4, 3, 2]));
    block.supports = vec![clamp(on("top"))];
    let mut lower = floor(
        match matching {
            true => cells([8, 4], [4, 3, 2]),
            false => cells([5, 4], [3, 2, 2]),
        },
        0.0,
    );
    lower.supports.clear();
    lower.weight = constant(v(0.0, 3e-4, -1e-3));
    let touch = contact("bottom", on_floor(), Law::Tied);
    problem(vec![block, lower], vec![touch], 1)
}

/// A stamp that a force presses from below.
fn stamp<const D: usize>() -> Problem<D> {
    let mut block = upper(cells([8, 4], [4, 3, 2]));
    block.supports = vec![clamp(on("top"))];
    let force = Drive::Force(constant(v(0.0, 0.0, 1e-3)));
    let against = plane(v(0.0, 0.0, 1.0), force);
    let touch = contact("bottom", against, Law::Frictionless);
    problem(vec![block], vec![touch], 1)
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
        let shape = block([-1.0, -1.0], [1.0, 0.0], [13, 5]);
        let mut floor = body("floor", shape, Kind::Quad4);
        floor.supports = vec![clamp(on("bottom"))];
        let touch = contact("outer", on_floor(), Law::Frictionless);
        return problem(vec![round, floor], vec![touch], 1);
    }
    let touch = contact("outer", ground(), Law::Frictionless);
    problem(vec![round], vec![touch], 1)
}

/// A ball pressed into a block by its weight.
fn round() -> Problem<3> {
    let center = [1.0, 0.5, 1.0];
    let mut ball = body("block", ball(center, 1.0, [8, 1]), Kind::Hex8);
    ball.weight = constant([0.0, 0.0, -1e-4]);
    // the true surface, as the program knows it for its own meshes
    ball.surfaces = vec![crate::problem::round("outer", center, 1.0)];
    let touch = contact("outer", on_floor(), Law::Frictionless);
    problem(vec![ball, floor([5, 4, 2], 0.0)], vec![touch], 1)
}

/// A block in a corner of two planes without friction: its edge is in two contacts.
fn corner<const D: usize>() -> Problem<D> {
    let shape = block([0.0; D], [1.0; D], cells([4, 4], [3, 2, 3]));
    let kind = if D == 2 { Kind::Quad4 } else { Kind::Hex8 };
    let mut block = body("block", shape, kind);
    block.press("top", Amount::from(1e-3));
    block.press("right", Amount::from(1e-3));
    let mut wall = contact("left", plane(axes()[0], Drive::Nothing), Law::Frictionless);
    wall.name = "wall".to_string();
    let floor = contact("bottom", ground(), Law::Frictionless);
    problem(vec![block], vec![floor, wall], 1)
}

fn answer<const D: usize>(problem: &Problem<D>, name: &str) -> Answer<D>
where
    Problem<D>: Dimension<D>,
{
    let name = name.replace(' ', "-");
    let folder = Folder::new(&format!("mutations-{D}-{name}")).unwrap();
    match solve(problem, &folder, 60.0) {
        Outcome::Certified(answer) => answer,
        other => panic!("{name}: {other:?}"),
    }
}

/// The names of the findings.
fn found<const D: usize>(problem: &Problem<D>, answer: &Answer<D>) -> Vec<&'static str>
where
    Problem<D>: Dimension<D>,
{
    let judgement = check(problem, answer);
    judgement.findings.iter().map(|f| f.what).collect()
}

/// The right answer is right, and the spoiled one is not, for this reason.
fn noticed<const D: usize>(
    name: &str,
    problem: &Problem<D>,
    what: &str,
    spoil: impl FnOnce(&mut Problem<D>, &mut Answer<D>),
) where
    Problem<D>: Dimension<D>,
{
    let mut answer = answer(problem, name);
    let faults = check(problem, &answer).findings;
    assert!(faults.is_empty(), "{name}: {faults:?}");
    let mut other = problem.clone();
    spoil(&mut other, &mut answer);
    let all = found(&other, &answer);
    assert!(all.contains(&what), "{name}: {what} is not among {all:?}");
}

fn last<const D: usize>(answer: &mut Answer<D>) -> &mut Step<D> {
    answer.steps.last_mut().unwrap()
}

/// Moves a body rigidly.
fn shift<const D: usize>(answer: &mut Answer<D>, body: usize, by: [f64; D]) {
    let moves = &mut last(answer).displacements[body];
    moves.iter_mut().for_each(|u| *u = plus(*u, 1.0, by));
}

fn wrong_inside<const D: usize>()
where
    Problem<D>: Dimension<D>,
{
    noticed("displaced", &matching::<D>(), "equilibrium", |_, answer| {
        let inner = answer.meshes[0].nearest(v(1.0, 0.33, 0.5));
        last(answer).displacements[0][inner][0] += 1e-8;
    });
    noticed("load", &matching::<D>(), "equilibrium", |problem, _| {
        problem.bodies[0].weight = constant(v(0.0, 0.0, -1e-7));
    });
    noticed("support", &drawn::<D>(), "support", |problem, _| {
        let down = constant(v(0.0, 0.0, -1.001e-3));
        problem.bodies[0].supports[0] = driven(on("top"), down);
    });
    noticed("roller", &matching::<D>(), "support", |problem, _| {
        let supports = &mut problem.bodies[1].supports;
        supports.push(roller("left", Amount::from(1e-6)));
    });
}

#[test]
fn forces_and_supports_that_are_wrong_are_noticed() {
    wrong_inside::<2>();
    wrong_inside::<3>();
}

/// Moves the obstacle upwards.
fn raise<const D: usize>(problem: &mut Problem<D>, by: f64) {
    let contact = problem.contacts.last_mut().unwrap();
    if let Against::Obstacle {
        surface: Surface::Plane { point, .. },
        ..
    } = &mut contact.against
    {
        *point = plus(*point, 1.0, v(0.0, 0.0, by));
    }
}

fn elsewhere<const D: usize>()
where
    Problem<D>: Dimension<D>,
{
    let far = if D == 2 { 1e-3 } else { 2e-3 };
    let cases: [(Problem<D>, f64, &str); 5] = [
        (matching(), 1e-7, "open force"),
        (matching(), -1e-7, "penetration"),
        (paired(), far, "open force"),
        (paired(), -far, "overlap"),
        (working(), 1e-6, "work"),
    ];
    for (k, (problem, by, what)) in cases.iter().enumerate() {
        noticed(&format!("lifted {k}"), problem, what, |_, answer| {
            shift(answer, 0, v(0.0, 0.0, *by));
        });
    }
    let far = if D == 2 { 1e-3 } else { 1e-2 };
    for (name, matching, by) in [("torn", true, 1e-7), ("torn off", false, far)] {
        noticed(name, &glued::<D>(matching), "jump", |_, answer| {
            shift(answer, 1, v(by, by, 0.0));
        });
    }
    noticed("raised", &drawn::<D>(), "penetration", |problem, _| {
        raise(problem, 1e-8);
    });
    noticed("lowered", &drawn::<D>(), "open force", |problem, _| {
        raise(problem, -1e-8);
    });
    noticed("second", &drawn::<D>(), "penetration", |problem, answer| {
        // an obstacle that is missing in the answer: its rows are all open
        problem.contacts.push(problem.contacts[0].clone());
        raise(problem, 1e-6);
        for step in &mut answer.steps {
            let mut open = step.contacts[0].clone();
            for row in &mut open.rows {
                (row.pressure, row.shear) = (0.0, [0.0; D]);
                (row.gap, row.status) = (1.0, Status::Open);
            }
            step.contacts.push(open);
        }
    });
    noticed("moved along", &drawn::<D>(), "stuck slip", |problem, _| {
        if let Against::Obstacle { drive, .. } = &mut problem.contacts[0].against {
            let mut field: Field<D> = constant([0.0; D]);
            field[0] = Amount::timed(1e-5, Time::Line(0.0, 1.0));
            *drive = Drive::Displacement(field);
        }
    });
}

#[test]
fn bodies_and_obstacles_that_lie_elsewhere_are_noticed() {
    elsewhere::<2>();
    elsewhere::<3>();
    noticed("round", &round(), "overlap", |_, answer| {
        shift(answer, 0, [0.0, 0.0, -5e-1]);
    });
}

/// A shear in another direction: backwards, or in space across.
fn astray<const D: usize>(row: &mut Row<D>) {
    row.shear = match D {
        2 => times(-1.0, row.shear),
        _ => lowered(cross(row.normal, row.shear)),
    };
}

/// A case of [`rows`]: a problem, the check that notices, and the change of a row.
type Spoiled<const D: usize> = (Problem<D>, &'static str, fn(&mut Row<D>));

fn rows<const D: usize>()
where
    Problem<D>: Dimension<D>,
{
    let all: [Spoiled<D>; 12] = [
        (drawn(), "row force", |row| row.pressure *= 1.001),
        (drawn(), "row force", astray),
        (drawn(), "tension", |row| row.pressure *= -1.0),
        (drawn(), "gap", |row| row.gap += 1e-8),
        (drawn(), "slip", |row| {
            row.slip = plus(row.slip, 1e-8, tangents(row.normal)[0]);
        }),
        (drawn(), "penetration", |row| row.gap -= 1e-8),
        (drawn(), if D == 2 { "work" } else { "shear sign" }, astray),
        (drawn(), "weight", |row| {
            (row.weight, row.pressure) = (1.01 * row.weight, row.pressure / 1.01);
        }),
        (paired(), "row sum", |row| row.pressure *= 1.01),
        (paired(), "row sum", astray),
        (working(), "work", |row| row.gap += 1e-5),
        (paired(), "weight", |row| row.weight *= 1.1),
    ];
    for (k, (problem, what, spoil)) in all.iter().enumerate() {
        noticed(&format!("rows {k}"), problem, what, |_, answer| {
            last(answer).contacts[0].rows.iter_mut().for_each(spoil);
        });
    }
    let one: [Spoiled<D>; 7] = [
        (drawn(), "row force", |row| row.pressure = 0.0),
        (drawn(), "row force", |row| {
            row.shear = times(-1.0, row.shear)
        }),
        (drawn(), "tension", |row| row.pressure *= -1.0),
        (drawn(), "gap", |row| row.gap += 1e-8),
        (drawn(), "weight", |row| {
            (row.weight, row.pressure) = (1.01 * row.weight, row.pressure / 1.01);
        }),
        (paired(), "row sum", |row| row.pressure = 0.0),
        (paired(), "weight", |row| row.weight *= 1.05),
    ];
    for (k, (problem, what, spoil)) in one.iter().enumerate() {
        noticed(&format!("row {k}"), problem, what, |_, answer| {
            spoil(&mut last(answer).contacts[0].rows[3]);
        });
    }
    noticed("uneven", &matching::<D>(), "pressure", |problem, _| {
        problem.uniform = Some(Amount::from(1e-3));
    });
}

#[test]
fn rows_that_say_something_else_are_noticed() {
    rows::<2>();
    rows::<3>();
}

fn normals<const D: usize>(problems: &[Problem<D>])
where
    Problem<D>: Dimension<D>,
{
    for (k, problem) in problems.iter().enumerate() {
        noticed(&format!("normal {k}"), problem, "normal", |_, answer| {
            for row in &mut answer.steps[0].contacts[0].rows {
                row.normal = match D {
                    2 => plus(times(0.88, row.normal), 0.48, tangents(row.normal)[0]),
                    _ => times(-1.0, row.normal),
                };
            }
        });
    }
}

#[test]
fn normals_of_rows_that_look_elsewhere_are_noticed() {
    normals(&[disc(true), disc(false), matching(), drawn(), paired()]);
    normals(&[round(), matching(), drawn(), paired()]);
}

fn friction<const D: usize>()
where
    Problem<D>: Dimension<D>,
{
    noticed("bound", &drawn::<D>(), "shear", |problem, _| {
        problem.contacts[0].law = Law::rubbing(0.27);
    });
    noticed("smooth", &drawn::<D>(), "shear", |problem, _| {
        problem.contacts[0].law = Law::Frictionless;
    });
    // another history: stuck nodes have slipped in this step, slipping nodes went the other way
    noticed("stuck", &drawn::<D>(), "stuck slip", |_, answer| {
        let before = &mut answer.steps[1].displacements[0];
        before.iter_mut().for_each(|u| u[0] += 1e-6);
    });
    noticed("backwards", &drawn::<D>(), "shear sign", |_, answer| {
        let before = &mut answer.steps[1].displacements[0];
        before.iter_mut().for_each(|u| u[0] *= 3.0);
    });
    noticed("told stuck", &drawn::<D>(), "stuck slip", |_, answer| {
        for row in &mut answer.steps[1].contacts[0].rows {
            row.slip[0] += 1e-6;
        }
    });
    noticed(
        "told backwards",
        &drawn::<D>(),
        "shear sign",
        |_, answer| {
            for row in &mut answer.steps[1].contacts[0].rows {
                row.slip = times(5.0, row.slip);
            }
        },
    );
    let far = if D == 2 { -1e-3 } else { -1e-2 };
    noticed("dragged", &paired::<D>(), "stuck slip", |_, answer| {
        shift(answer, 0, v(far, 0.0, 0.0));
    });
}

#[test]
fn friction_is_judged_by_its_law() {
    friction::<2>();
    friction::<3>();
}

fn resultants<const D: usize>()
where
    Problem<D>: Dimension<D>,
{
    let up = D - 1;
    noticed("react", &paired::<D>(), "act and react", |_, answer| {
        let moves = &mut last(answer).displacements[1];
        moves.iter_mut().for_each(|u| *u = times(1.001, *u));
    });
    noticed("force", &paired::<D>(), "resultant", |_, answer| {
        last(answer).contacts[0].resultant[up] *= 1.001;
    });
    noticed("moment", &paired::<D>(), "resultant", |_, answer| {
        let moment = &mut last(answer).contacts[0].moment;
        *moment = times(1.001, *moment);
    });
    noticed("reaction", &paired::<D>(), "reaction", |_, answer| {
        last(answer).reactions[1][up] *= 1.001;
    });
    noticed("stamp", &stamp::<D>(), "obstacle", |problem, _| {
        if let Against::Obstacle { drive, .. } = &mut problem.contacts[0].against {
            *drive = Drive::Force(constant(v(0.0, 0.0, 1.001e-3)));
        }
    });
}

#[test]
fn resultants_are_compared() {
    resultants::<2>();
    resultants::<3>();
}

/// Replaces the answer by that with glued sides, whose rows say that they touch.
fn as_glued<const D: usize>(problem: &Problem<D>, answer: &mut Answer<D>, name: &str)
where
    Problem<D>: Dimension<D>,
{
    let mut tied = problem.clone();
    tied.contacts[0].law = Law::Tied;
    *answer = self::answer(&tied, name);
    for row in &mut answer.steps[0].contacts[0].rows {
        (row.status, row.pressure) = (Status::Closed, row.pressure.max(0.0));
    }
}

fn nothing_faces<const D: usize>()
where
    Problem<D>: Dimension<D>,
{
    for what in ["footprint", "outside"] {
        // half of the floor is missing: the resultant of the block lies in the middle
        noticed(what, &paired::<D>(), what, |_, answer| {
            let mesh = &mut answer.meshes[1];
            let points = mesh.points.clone();
            let top = mesh.sides.get_mut("top").unwrap();
            top.retain(|facet| facet.iter().all(|&n| points[n][0] < 0.6));
        });
    }
    // the load tips the block: any forces that hold it must pull somewhere
    noticed(
        "tipping",
        &matching::<D>(),
        "footprint",
        |problem, answer| {
            let block = &mut problem.bodies[0];
            block.supports.clear();
            block.loads.clear();
            for (along, up) in [(0.0, 1e-3), (2.0, -2e-3)] {
                block.loads.push(Load::Force {
                    point: v(along, 0.0, 1.0),
                    field: constant(v(0.0, 0.0, up)),
                });
            }
            as_glued(problem, answer, "tipping glued");
        },
    );
}

#[test]
fn forces_from_where_nothing_faces_are_noticed() {
    nothing_faces::<2>();
    nothing_faces::<3>();
    // a couple about the normal that only a tie can bear
    noticed("spun", &matching::<3>(), "footprint", |problem, answer| {
        let swirl = |slope| Amount::new(0.0, slope, Time::Always);
        let field = [
            swirl([0.0, 1e-3, 0.0]),
            swirl([-1e-3, 0.0, 0.0]),
            Amount::from(-1e-4),
        ];
        problem.bodies[0].pull("top", field);
        as_glued(problem, answer, "spun glued");
    });
}

/// Nodes of the block at the edge of the corner lose their rows.
fn lose<const D: usize>(answer: &mut Answer<D>) {
    let points = answer.meshes[0].points.clone();
    for row in last(answer).contacts.iter_mut().flat_map(|c| &mut c.rows) {
        let x = points[row.node];
        if x[0] == 0.0 && x[D - 1] == 0.0 {
            (row.pressure, row.shear) = (f64::NAN, [f64::NAN; D]);
            row.status = Status::Fixed;
        }
    }
}

fn missing<const D: usize>()
where
    Problem<D>: Dimension<D>,
{
    // without its rows the corner is still right
    let right = corner::<D>();
    let mut whole = answer(&right, "corner");
    lose(&mut whole);
    assert_eq!(found(&right, &whole), Vec::<&str>::new());
    noticed("corner pulls", &right, "corner", |problem, answer| {
        lose(answer);
        // a force outwards at the corner that nothing can hold
        problem.bodies[0].loads.push(Load::Force {
            point: [0.0; D],
            field: constant(v(1e-3, 0.0, 1e-3)),
        });
    });
    noticed("corner open", &right, "corner", |problem, answer| {
        lose(answer);
        // the wall is not there
        if let Against::Obstacle {
            surface: Surface::Plane { point, .. },
            ..
        } = &mut problem.contacts[1].against
        {
            *point = minus(*point, times(1e-6, axes()[0]));
        }
    });
}

#[test]
fn the_force_at_a_corner_must_be_one_that_its_contacts_allow() {
    missing::<2>();
    missing::<3>();
}

/// Twins of a right answer agree with it, and one under another load does not.
fn twins_agree<const D: usize>(kinds: usize)
where
    Problem<D>: Dimension<D>,
{
    let problem = matching::<D>();
    let mine = answer(&problem, "twins");
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..60 {
        for mut twin in problem.twins(&mine, &mut Random::new(seed)) {
            if !seen.insert(twin.name) {
                continue;
            }
            let name = twin.name;
            let other = answer(&twin.problem, &format!("twin {name}"));
            assert_eq!(found(&twin.problem, &other), Vec::<&str>::new(), "{name}");
            assert!(difference(&problem, &mine, &twin, &other).unwrap() < 1e-9);
            for load in twin.problem.bodies.iter_mut().flat_map(|b| &mut b.loads) {
                if let Load::Pressure { field, .. } = load {
                    *field = field.times(1.001);
                }
            }
            let other = answer(&twin.problem, &format!("stranger {name}"));
            assert!(difference(&problem, &mine, &twin, &other).unwrap() > 1e-4);
        }
    }
    assert_eq!(seen.len(), kinds, "{seen:?}");
}

#[test]
fn twins_agree_and_strangers_do_not() {
    twins_agree::<2>(5);
    twins_agree::<3>(2);
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
        shift(answer, 0, [0.0, 0.5 * high]);
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
        let node = answer.meshes[1].nearest(bar.at);
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
        shift(answer, 0, [0.0, 1e-4 * stress / young * high]);
    });
    noticed("ground", &at_rest, "pressure", |_, answer| {
        last(answer).contacts[0].rows[0].pressure *= 1.01;
    });
}

#[test]
fn a_joint_that_bears_more_than_its_strength_is_noticed() {
    let strong = (0..).map(|seed| family("joint", seed)).find(|problem| {
        let all = |row: &Row<2>| -row.pressure;
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
