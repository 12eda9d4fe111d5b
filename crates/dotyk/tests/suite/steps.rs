//! Load steps: each is the answer that a run of its own gives, whatever came before it.

use dotyk::mesh::Diagonals;
use dotyk::model::{Event, Law, Motion, Pair, Reuse, Study, Varied};
use dotyk::prelude::*;

fn field(text: &str) -> Field {
    dotyk::case::parse_expression(text).unwrap()
}

fn rectangle(from: Point<2>, to: Point<2>, cells: [usize; 2]) -> Mesh<2> {
    Rectangle {
        from,
        to,
        cells,
        cell: CellKind::Quad4,
        diagonals: Diagonals::default(),
    }
    .build()
    .unwrap()
}

const STEEL: Elastic = Elastic {
    young: 210e3,
    poisson: 0.3,
};

/// A punch that only contact holds along y, on a block: load, support, gap and body force change with time.
fn punch(times: &[f64]) -> Model<2> {
    let mut model = Model::<2>::new();
    let block = model.body("block", rectangle([0.0, 0.0], [4.0, 1.0], [32, 8]), STEEL);
    let punch = model.body("punch", rectangle([1.0, 1.0], [3.0, 2.0], [16, 8]), STEEL);
    model
        .fix(block, "bottom", [Some(0.0), None])
        .fix(punch, "left", [Some(0.0), None])
        .fix(punch, "right", [Some(0.0), None]);
    model.bodies[0].supports[0].components[1] = Some(field("1e-3 * t * sin(3*x)"));
    model.bodies[1].body_force[1] = field("-20 * t");
    model.load(
        punch,
        Load::Traction {
            side: "top".to_string(),
            traction: [Field::constant(0.0), field("-300 * t * (1 + 0.6*(x - 2))")],
        },
    );
    let sole = model.contact((punch, "bottom"), (block, "top"));
    sole.name = "sole".to_string();
    sole.gap = Some(Gap::Given(field("2e-3 * (x - 2)^2 * (2 - t)")));
    let tip = Reading::At([2.0, 2.0]);
    model.probe("tip", "punch.displacement.y", tip).unwrap();
    model.times = times.to_vec();
    model
}

/// All numbers of an answer that matter, with their largest values.
fn numbers(solution: &Solution<2>) -> Vec<(&'static str, Vec<f64>)> {
    let contacts = || solution.contacts.iter();
    let nodes = || contacts().flat_map(|c| &c.nodes);
    let bodies = || solution.bodies.iter();
    vec![
        ("pressure", nodes().map(|n| n.pressure).collect()),
        ("gap", nodes().map(|n| n.gap).collect()),
        (
            "displacement",
            bodies().flat_map(|b| b.displacement.concat()).collect(),
        ),
        ("stress", bodies().flat_map(|b| b.stress.concat()).collect()),
        ("reaction", bodies().flat_map(|b| b.reaction).collect()),
        ("force", contacts().flat_map(|c| c.resultant).collect()),
        ("probe", solution.probes.iter().map(|p| p.value).collect()),
    ]
}

#[track_caller]
fn assert_same(a: &Solution<2>, b: &Solution<2>, tolerance: f64) {
    for ((name, a), (_, b)) in numbers(a).into_iter().zip(numbers(b)) {
        assert_eq!(a.len(), b.len());
        let scale = a.iter().fold(0.0f64, |s, v| s.max(v.abs()));
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() <= tolerance * scale, "{name}: {a} and {b}");
        }
    }
}

#[test]
fn every_step_is_the_answer_of_a_run_of_its_own() {
    let times = [0.2, 0.7, 1.0, 1.6];
    let steps = punch(&times).solve_steps().unwrap();
    assert_eq!(steps.len(), 4);
    for (step, time) in steps.iter().zip(times) {
        let alone = punch(&[time]).solve().unwrap();
        assert!(step.converged && step.time == time);
        // the same linear systems, another way to the active set: rounding times the condition of F
        assert_same(step, &alone, 1e-11);
    }
    let closed = |s: &Solution<2>| {
        s.contacts[0]
            .nodes
            .iter()
            .filter(|n| n.pressure > 0.0)
            .count()
    };
    let counts: Vec<usize> = steps.iter().map(closed).collect();
    assert!(counts.windows(2).any(|w| w[0] != w[1]), "{counts:?}");
    let last = punch(&times).solve().unwrap();
    assert_same(&last, &steps[3], 0.0);
}

#[test]
fn every_method_gives_every_step_the_same_answer() {
    let model = punch(&[0.2, 0.7, 1.6]);
    let newton = model.solve_steps().unwrap();
    for method in Method::NAMED {
        let mut other = model.clone();
        other.solver.method = method;
        for (a, b) in newton.iter().zip(other.solve_steps().unwrap()) {
            let pressures = |s: &Solution<2>| -> Vec<f64> {
                s.contacts[0].nodes.iter().map(|n| n.pressure).collect()
            };
            let (a, b) = (pressures(a), pressures(&b));
            let largest = a.iter().fold(0.0f64, |s, p| s.max(p.abs()));
            let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
            // the certificate holds to 1e-8 in gaps; the least eigenvalue of F costs up to three digits of forces
            assert!(
                off.fold(0.0, f64::max) < 1e-5 * largest,
                "{}",
                method.name()
            );
        }
    }
}

#[test]
fn a_warm_start_from_a_similar_step_needs_no_more_iterations() {
    for method in [Method::Newton, Method::Mprgp, Method::Accelerated] {
        let mut model = punch(&[0.2, 0.21, 0.22]);
        model.solver.method = method;
        let warm = model.solve_steps().unwrap();
        for step in &warm[1..] {
            model.times = vec![step.time];
            let cold = model.solve().unwrap().solver.iterations;
            let found = step.solver.iterations;
            assert!(found <= cold, "{}: {found} and {cold}", method.name());
        }
    }
    let mut model = punch(&[0.2, 0.2001]);
    model.solver.method = Method::Newton;
    let warm = model.solve_steps().unwrap();
    assert!(warm[1].solver.iterations < warm[0].solver.iterations);
}

#[test]
fn a_closed_contact_is_homogeneous_in_the_load() {
    let mut model = punch(&[0.01, 1.0, 100.0]);
    model.bodies[0].supports[0].components[1] = Some(field("1e-2 * t * sin(3*x)"));
    model.contacts[0].gap = Some(Gap::Closed);
    let steps = model.solve_steps().unwrap();
    let unit = &steps[1].contacts[0].nodes;
    assert!(unit.iter().any(|n| n.status == Status::Open));
    assert!(unit.iter().any(|n| n.status == Status::Closed));
    let largest = unit.iter().fold(0.0f64, |s, n| s.max(n.pressure));
    for step in &steps {
        for (node, unit) in step.contacts[0].nodes.iter().zip(unit) {
            assert_eq!(node.status, unit.status);
            let expected = step.time * unit.pressure;
            assert!((node.pressure - expected).abs() < 1e-11 * step.time * largest);
        }
    }
}

#[test]
fn an_obstacle_that_moves_presses_from_the_time_on_when_it_touches() {
    let mut model = Model::<2>::new();
    let block = model.body("block", rectangle([0.0, 0.0], [2.0, 1.0], [4, 3]), STEEL);
    model
        .fix(block, "top", [None, Some(0.0)])
        .fix(block, "left", [Some(0.0), None]);
    let contact = model.obstacle((block, "bottom"), field("0.001 * (1 + t)"));
    if let Pair::Obstacle { obstacle, .. } = &mut contact.pair {
        obstacle.motion = Motion::Prescribed([field("0"), field("0.004 * t")]);
    }
    model.times = vec![0.0, 0.25, 1.0, 2.0];
    let steps = model.solve_steps().unwrap();
    for step in &steps {
        let approach = 0.004 * step.time - 0.001 * (1.0 + step.time);
        let pressure = STEEL.young / (1.0 - 0.09) * f64::max(approach, 0.0);
        for node in &step.contacts[0].nodes {
            // uniform stress: rounding
            assert!((node.pressure - pressure).abs() < 1e-9, "{}", step.time);
            assert!((node.gap - f64::max(-approach, 0.0)).abs() < 1e-15);
            assert!((node.displacement_mortar + 0.004 * step.time).abs() < 1e-15);
        }
    }
}

#[test]
fn times_that_do_not_increase_are_refused() {
    for times in [vec![], vec![1.0, 1.0], vec![2.0, 1.0], vec![f64::NAN]] {
        let error = punch(&times).solve_steps().unwrap_err().to_string();
        assert!(error.contains("step"), "{error}");
        let check = punch(&times).check();
        assert_eq!(check.errors.len(), 1);
    }
}

#[test]
fn an_error_of_one_step_names_it() {
    let mut model = punch(&[0.5, 1.0]);
    let traction = [Field::constant(0.0), field("800 * (2*t - 1.5)")];
    let side = "top".to_string();
    model.bodies[1].loads = vec![Load::Traction { side, traction }];
    model.bodies[1].body_force[1] = Field::constant(0.0);
    let error = model.solve_steps().unwrap_err();
    assert!(
        matches!(&error, Error::Step { step: 2, source, .. } if matches!(**source, Error::PulledAway { .. })),
        "{error}"
    );
    assert!(error.to_string().starts_with("step 2 (t = 1): "), "{error}");
    assert!(error.subject().is_some());
    let found = model.check().errors;
    assert!(found[0].starts_with("step 2 (t = 1): "), "{found:?}");

    model.times = vec![1.0, 3.0];
    model.bodies[1].loads = vec![Load::Traction {
        side: "top".to_string(),
        traction: [Field::constant(0.0), field("-1 / abs(1 - t)")],
    }];
    let found = model.check().errors;
    assert!(found[0].starts_with("step 1 (t = 1): "), "{found:?}");
    assert!(found[0].contains("not finite"), "{found:?}");
}

#[test]
fn a_step_that_does_not_converge_keeps_those_before_it() {
    let mut model = punch(&[0.0, 1.0, 2.0]);
    model.contacts[0].gap = Some(Gap::Closed);
    model.solver.method = Method::Mprgp;
    model.solver.max_iterations = Some(1);
    let Err(Error::NotConverged {
        solution, earlier, ..
    }) = model.solve_steps()
    else {
        panic!("one iteration cannot be enough");
    };
    // nothing happens at t = 0
    let times: Vec<f64> = earlier.iter().map(|s| s.time).collect();
    assert_eq!(times, [0.0]);
    assert!(earlier[0].converged);
    assert!(!solution.converged && solution.time == 1.0);
}

#[test]
fn the_observer_hears_of_every_step_and_of_one_factorisation() {
    let (mut steps, mut factored) = (Vec::new(), 0);
    let mut observe = |event: Event| match event {
        Event::Step {
            step,
            steps: of,
            time,
        } => steps.push((step, of, time)),
        Event::Stage("factor") => factored += 1,
        _ => {}
    };
    punch(&[0.5, 1.0]).solve_steps_with(&mut observe).unwrap();
    assert_eq!(steps, [(1, 2, 0.5), (2, 2, 1.0)]);
    assert_eq!(factored, 1);
}

#[test]
fn comparing_and_condensing_take_the_last_step() {
    use dotyk::model::DENSE_LIMIT;
    let several = punch(&[0.2, 1.0]).dual_problem(DENSE_LIMIT).unwrap();
    let alone = punch(&[1.0]).dual_problem(DENSE_LIMIT).unwrap();
    assert_eq!(several.shift, alone.shift);
    assert_eq!(several.balance.load(), alone.balance.load());
}

/// What a change does to a model, and whether its stiffness stays.
type Change = (&'static str, fn(&mut Model<2>), bool);

const CHANGES: [Change; 11] = [
    (
        "a force beside a node",
        |m| {
            let force = [0.0, -5.0].map(Field::constant);
            let point = [1.51, 2.0];
            m.load(BodyId(1), Load::Force { point, force });
        },
        true,
    ),
    (
        "load",
        |m| m.bodies[1].body_force[1] = field("-35 * t"),
        true,
    ),
    (
        "one more load",
        |m| {
            m.press(BodyId(1), "top", 90.0);
        },
        true,
    ),
    (
        "support",
        |m| m.bodies[0].supports[0].components[1] = Some(field("2e-3 * t")),
        true,
    ),
    (
        "gap",
        |m| m.contacts[0].gap = Some(Gap::Given(field("1e-3 * (x - 2)^2"))),
        true,
    ),
    ("times", |m| m.times = vec![0.3, 0.9], true),
    ("probe", |m| drop(m.probes.pop()), true),
    (
        "friction",
        |m| m.contacts[0].law = Law::Coulomb(Field::constant(0.4)),
        false,
    ),
    (
        "stiffness",
        |m| m.bodies[0].materials[0].elastic.young *= 1.5,
        false,
    ),
    (
        "held",
        |m| m.bodies[0].supports[0].components[0] = None,
        false,
    ),
    (
        "constant gap",
        |m| m.contacts[0].gap = Some(Gap::Given(Field::constant(1e-4))),
        false,
    ),
];

#[test]
fn what_a_model_of_the_same_stiffness_left_is_taken_up_and_nothing_else() {
    for (name, change, same) in CHANGES {
        let first = punch(&[0.5, 1.0]);
        let mut second = first.clone();
        change(&mut second);
        assert_eq!(second.has_stiffness_of(&first), same, "{name}");
        let mut reuse = Reuse::default();
        first.solve_steps_reusing(&mut reuse, &mut |_| {}).unwrap();
        let mut factored = false;
        let mut watch = |event| factored |= matches!(event, Event::Stage("factor"));
        let reused = second.solve_steps_reusing(&mut reuse, &mut watch).unwrap();
        assert_eq!(factored, !same, "{name}");
        let alone = second.solve_steps().unwrap();
        assert_eq!(reused.len(), alone.len());
        for (reused, alone) in reused.iter().zip(&alone) {
            // the same problem, but for rounding of its right-hand side
            assert_same(reused, alone, 1e-11);
            assert_eq!(reused.warnings, alone.warnings, "{name}");
        }
    }
}

/// A body comes in the second step: the first stage of the next model begins behind the last one of this.
#[test]
fn models_with_stages_take_up_bodies_that_are_the_same() {
    let with = |young: f64, load: f64| {
        let mut model = punch(&[0.5, 1.0]);
        model.bodies[0].materials[0].elastic.young = young;
        model.press(BodyId(1), "top", load);
        let mesh = rectangle([5.0, 0.0], [6.0, 1.0], [4, 4]);
        let late = model.body("late", mesh, STEEL);
        model.fix(late, "bottom", [Some(0.0); 2]);
        model.press(late, "top", load);
        model.bodies[late.0].active.from = 0.75;
        model
    };
    let mut reuse = Reuse::default();
    for (young, load) in [(210e3, 10.0), (210e3, 20.0), (100e3, 20.0)] {
        let model = with(young, load);
        let reused = model.solve_steps_reusing(&mut reuse, &mut |_| {}).unwrap();
        let alone = model.solve_steps().unwrap();
        assert_eq!(reused.len(), alone.len());
        for (reused, alone) in reused.iter().zip(&alone) {
            // the same problem, but for rounding of its right-hand side
            assert_same(reused, alone, 1e-11);
            assert_eq!(reused.warnings, alone.warnings);
        }
    }
}

#[test]
fn friction_of_another_strength_and_failures_leave_what_was_factored() {
    let with = |coefficient: f64, push: f64| {
        let mut model = punch(&[1.0]);
        model.bodies[1].supports.clear();
        model.bodies[1].body_force[0] = Field::constant(push);
        model.contacts[0].law = Law::Coulomb(Field::constant(coefficient));
        model.contacts[0].gap = Some(Gap::Closed);
        model
    };
    let mut reuse = Reuse::default();
    for (k, (coefficient, push)) in [(0.5, 10.0), (0.2, 10.0), (0.2, 1e4), (0.3, -10.0)]
        .into_iter()
        .enumerate()
    {
        let model = with(coefficient, push);
        let mut factored = false;
        let mut watch = |event| factored |= matches!(event, Event::Stage("factor"));
        let reused = model.solve_steps_reusing(&mut reuse, &mut watch);
        assert_eq!(factored, k == 0);
        match (reused, model.solve_steps()) {
            (Ok(reused), Ok(alone)) => assert_same(&reused[0], &alone[0], 1e-8),
            (Err(reused), Err(alone)) => assert_eq!(reused.to_string(), alone.to_string()),
            (reused, alone) => panic!("{:?} {:?}", reused.is_ok(), alone.is_ok()),
        }
    }
}

#[test]
fn a_study_gives_every_member_the_answer_of_its_own_run_and_failures_their_reason() {
    let make = |values: &[f64]| {
        let [young, load] = values else {
            unreachable!()
        };
        if *load > 1e3 {
            return Err("too much".to_string());
        }
        let mut model = punch(&[0.5, 1.0]);
        model.bodies[0].materials[0].elastic.young = *young;
        model.press(BodyId(1), "top", *load);
        Ok(model)
    };
    let varied = |name: &str, values: &[f64]| Varied {
        name: name.to_string(),
        values: values.to_vec(),
        log: false,
    };
    let varied = vec![
        varied("young", &[1e5, 2e5, 3e5]),
        varied("load", &[0.0, 10.0, 2e3]),
    ];
    let count = std::sync::atomic::AtomicUsize::new(0);
    let one_more = || {
        count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    };
    let own = [1e5, 10.0];
    let model: Model<2> = make(&own).unwrap();
    let study = model.study(&own, varied, &make, &one_more);
    assert_eq!((study.members.len(), count.into_inner()), (9, 9));
    assert!(!study.converged());
    for (k, member) in study.members.iter().enumerate() {
        assert_eq!(
            member.values,
            [[1e5, 2e5, 3e5][k / 3], [0.0, 10.0, 2e3][k % 3]]
        );
        assert_eq!(study.places(k), [k / 3, k % 3]);
        match make(&member.values) {
            Ok(model) => {
                assert!(member.converged && member.reason.is_empty());
                assert_eq!(
                    (&member.times[..], member.steps.len()),
                    (&[0.5, 1.0][..], 2)
                );
                for (step, alone) in member.steps.iter().zip(model.solve_steps().unwrap()) {
                    let alone = alone.probes[0].value;
                    assert!((step[0] - alone).abs() < 1e-11 * alone.abs());
                }
                assert_eq!(member.probes, member.steps[1]);
            }
            Err(reason) => {
                assert_eq!((member.converged, &member.reason), (false, &reason));
                assert!(member.probes[0].is_nan() && member.steps.is_empty());
            }
        }
    }
    let study = Study {
        all_steps: true,
        ..study
    };
    let heads: Vec<&str> = study.heads().collect();
    assert_eq!(heads[..4], ["young", "load", "step", "time"]);
    let rows = study.rows();
    assert_eq!(rows.len(), 6 * 2 + 3);
    for pair in rows[..4].chunks(2) {
        let told: Vec<_> = pair.iter().map(|row| row.step).collect();
        assert_eq!(told, [Some((1, 0.5)), Some((2, 1.0))]);
    }
    let failed = &rows[4];
    assert!(!failed.converged && failed.probes[0].is_nan() && !failed.reason.is_empty());
    assert!(
        failed
            .step
            .is_some_and(|(step, time)| step == 1 && time.is_nan())
    );
}

/// A block that is pressed against a wall and then dragged: with little friction the second step slides.
#[test]
fn a_member_that_fails_in_a_later_step_keeps_the_earlier_ones() {
    let text = r#"
analysis = "plane-strain"
parameters = { mu = 0.5 }
[[body]]
name = "b"
mesh = { rectangle = { from = [0, 0], to = [2, 1], cells = [4, 2] } }
material = { young = 1000, poisson = 0 }
load = [{ side = "top", traction = ["0.3*(t - 1)", -1] }]
[[contact]]
name = "floor"
nonmortar = "b.bottom"
obstacle = { plane = { point = [0, 0], normal = [0, 1] } }
friction = "mu"
[[step]]
time = 1
[[step]]
time = 2
[[probe]]
name = "force"
quantity = "floor.resultant.y"
[[probe]]
name = "late"
quantity = "floor.gap"
along = "b.bottom"
[[probe]]
name = "drag"
quantity = "floor.resultant.x"
"#;
    let case = dotyk::case::Case::<2>::from_str(text, "case.toml", std::path::Path::new("."));
    let case = case.unwrap();
    let varied = vec![Varied {
        name: "mu".to_string(),
        values: vec![0.1, 0.5],
        log: false,
    }];
    let study = case.study(&[], varied, &|| ()).unwrap();
    let study = Study {
        all_steps: true,
        ..study
    };
    let rows = study.rows();
    let told: Vec<_> = rows
        .iter()
        .map(|r| (r.step.unwrap(), r.converged))
        .collect();
    let [one, two] = [(1, 1.0), (2, 2.0)];
    assert_eq!(told, [(one, true), (two, false), (one, true), (two, true)]);
    assert!((rows[0].probes[0] - 2.0).abs() < 1e-9 && rows[1].probes[0].is_nan());
    assert!(
        (rows[3].probes[1] + 0.6).abs() < 1e-9,
        "{:?}",
        rows[3].probes
    );
    assert!(rows[1].reason.contains("slides"), "{}", rows[1].reason);
    assert!(study.members[0].probes[0].is_nan() && !study.converged());
}
