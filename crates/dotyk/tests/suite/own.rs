//! Solvers and forces of one's own: what a model makes of them, and the dual problem that they are found on.
//!
//! Tolerances: 1e-8 of the largest value between two answers that meet the certificate; 1e-10 for what is the same number
//! computed another way, the rounding of a linear solve.

use dotyk::dual::{Certificate, DualProblem, Multipliers};
use dotyk::fem::assemble;
use dotyk::geometry::{Field, distance};
use dotyk::mesh::{CellKind, Diagonals, Mesh, Rectangle};
use dotyk::model::{
    BodyId, CoupleKind, DENSE_LIMIT, Dual, Elastic, Error, Gap, Law, Method, Model, Motion,
    Objection, Pair, Solution,
};
use dotyk::solve::{Accelerated, ContactSolver, Iterate, Newton, Observer, Outcome, SolveError};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

const SOFT: Elastic = Elastic {
    young: 1000.0,
    poisson: 0.3,
};

fn rectangle(from: [f64; 2], to: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let (cell, diagonals) = (CellKind::Quad4, Diagonals::default());
    let rectangle = Rectangle {
        from,
        to,
        cells,
        cell,
        diagonals,
    };
    rectangle.build().unwrap()
}

/// A block on the floor and a punch that is free to sink, or `held` at its sides; meshes 12:5.
fn punch(held: bool, law: Law) -> Model<2> {
    let mut model = Model::<2>::new();
    let block = model.body("block", rectangle([0.0, 0.0], [4.0, 1.0], [12, 3]), SOFT);
    let punch = model.body("punch", rectangle([1.0, 1.0], [3.0, 2.0], [5, 3]), SOFT);
    let vertical = held.then_some(0.0);
    model
        .fix(block, "bottom", [Some(0.0), Some(0.0)])
        .fix(punch, "left", [Some(0.0), vertical])
        .fix(punch, "right", [Some(0.0), vertical])
        .pull(punch, "top", [0.0, -10.0]);
    let sole = model.contact((punch, "bottom"), (block, "top"));
    sole.law = law;
    sole.gap = Some(Gap::Given(Field::function("bowl", |p, _| {
        1e-3 * (p[0] - 2.0).powi(2)
    })));
    model
}

/// A block that friction holds on a floor, pushed to and fro.
fn hysteresis(times: &[f64]) -> Model<2> {
    let mut model = Model::<2>::new();
    let floor = model.body("floor", rectangle([0.0, 0.0], [4.0, 1.0], [12, 3]), SOFT);
    let block = model.body("block", rectangle([1.0, 1.0], [3.0, 2.0], [6, 3]), SOFT);
    model
        .fix(floor, "bottom", [Some(0.0), Some(0.0)])
        .fix(block, "top", [Some(0.0), Some(0.0)]);
    model.bodies[1].supports[0].components = [
        Some(Field::function("to and fro", |_, t| 4e-3 * (3.0 * t).sin())),
        Some(Field::constant(-5e-3)),
    ];
    model.contact((block, "bottom"), (floor, "top")).law = Law::Coulomb(Field::constant(0.3));
    model.times = times.to_vec();
    model
}

/// A solver that is a function.
struct Mine<S>(S);

impl<S> ContactSolver for Mine<S>
where
    S: Fn(&DualProblem, Option<&Multipliers>, Observer<'_>) -> Result<Outcome, SolveError> + Sync,
{
    fn name(&self) -> &str {
        "mine"
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        (self.0)(problem, guess, observe)
    }
}

/// What one of our own methods returns, without any mark of it; so accurate that the certificate asks for no more.
fn borrowed(
    problem: &DualProblem,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let outcome = match problem.admissible.bounds_follow() {
        true => Newton::default().solve(problem, guess, observe)?,
        false => {
            let tight = Accelerated {
                tolerance: 1e-12,
                ..Accelerated::default()
            };
            tight.solve(problem, guess, observe)?
        }
    };
    Ok(Outcome::new(outcome.multipliers, outcome.iterations))
}

fn silent(_: &Iterate<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        let undefined = found.is_nan() && expected.is_nan();
        assert!(
            undefined || (found - expected).abs() <= relative * scale,
            "{found} {expected}"
        );
    }
}

#[track_caller]
fn assert_same(found: &Solution<2>, expected: &Solution<2>) {
    for (found, expected) in found.bodies.iter().zip(&expected.bodies) {
        let (u, v) = (found.displacement.concat(), expected.displacement.concat());
        assert_near(&u, &v, 1e-8);
        assert_near(&found.stress.concat(), &expected.stress.concat(), 1e-8);
    }
    for (found, expected) in found.contacts.iter().zip(&expected.contacts) {
        let pressures = |c: &dotyk::model::ContactSolution<2>| -> Vec<f64> {
            c.nodes.iter().map(|n| n.pressure).collect()
        };
        assert_near(&pressures(found), &pressures(expected), 1e-8);
        assert_near(&found.resultant, &expected.resultant, 1e-8);
    }
}

#[test]
fn an_own_solver_gives_a_solution_with_its_name_its_history_and_everything_else() {
    let model = punch(false, Law::Frictionless);
    let own = model.solve_by(&Mine(borrowed)).unwrap();
    assert!(own.converged && own.certificate.holds());
    assert_eq!(own.solver.method, "mine");
    assert!(own.solver.iterations > 1);
    assert_eq!(own.solver.history.len(), own.solver.iterations);
    assert_same(&own, &model.solve().unwrap());
}

#[test]
fn an_own_solver_is_asked_once_in_each_step_from_the_answer_of_the_step_before() {
    let model = hysteresis(&[0.4, 0.8, 1.2]);
    let asked = AtomicUsize::new(0);
    let before = std::sync::Mutex::new(None);
    let solver = Mine(
        |problem: &DualProblem, guess: Option<&Multipliers>, observe: Observer<'_>| {
            asked.fetch_add(1, Ordering::Relaxed);
            assert_eq!(guess.cloned(), *before.lock().unwrap());
            let outcome = borrowed(problem, guess, observe)?;
            *before.lock().unwrap() = Some(outcome.multipliers.clone());
            Ok(outcome)
        },
    );
    let own = model.solve_steps_by(&solver, &mut |_| {}).unwrap();
    assert_eq!((own.len(), asked.into_inner()), (3, 3));
    for (own, expected) in own.iter().zip(&model.solve_steps().unwrap()) {
        assert_same(own, expected);
    }
}

#[test]
fn forces_that_are_off_are_judged_and_not_improved() {
    let asked = AtomicUsize::new(0);
    let solver = Mine(
        |problem: &DualProblem, guess: Option<&Multipliers>, observe: Observer<'_>| {
            asked.fetch_add(1, Ordering::Relaxed);
            let mut outcome = borrowed(problem, guess, observe)?;
            outcome.multipliers.lambda[2] *= 1.0 + 1e-3;
            Ok(outcome)
        },
    );
    let model = punch(true, Law::Frictionless);
    let Err(Error::NotConverged {
        reason, solution, ..
    }) = model.solve_by(&solver)
    else {
        panic!("forces off by a part in a thousand are no answer");
    };
    assert!(matches!(*reason, Objection::Violated { .. }), "{reason}");
    assert!(!solution.converged && solution.solver.method == "mine");
    assert_eq!(asked.load(Ordering::Relaxed), 1);
    // the forces are those of the solver: a thousandth beside the answer there, and the answer elsewhere; the corner node is
    // held and has none
    let expected = model.solve().unwrap();
    let force = |s: &Solution<2>, k: usize| s.contacts[0].nodes[k].pressure;
    assert_near(&[force(&solution, 2)], &[force(&expected, 2)], 1e-7);
    let ratio = force(&solution, 3) / force(&expected, 3);
    assert!((ratio - 1.001).abs() < 1e-7, "{ratio}");
}

#[test]
fn a_step_that_an_own_solver_misses_leaves_the_steps_before_it() {
    let asked = AtomicUsize::new(0);
    let solver = Mine(
        |problem: &DualProblem, guess: Option<&Multipliers>, observe: Observer<'_>| {
            let outcome = borrowed(problem, guess, observe)?;
            match asked.fetch_add(1, Ordering::Relaxed) {
                0 => Ok(outcome),
                _ => Err(SolveError::NotConverged {
                    method: "mine".to_string(),
                    outcome: Box::new(outcome),
                    residual: 0.5,
                    reason: "it was tired".to_string(),
                }),
            }
        },
    );
    let model = hysteresis(&[0.4, 0.8, 1.2]);
    let Err(Error::NotConverged {
        reason, earlier, ..
    }) = model.solve_steps_by(&solver, &mut |_| {})
    else {
        panic!("the second step has no answer");
    };
    assert_eq!(earlier.len(), 1);
    assert!(reason.to_string().contains("it was tired"), "{reason}");
}

#[test]
fn what_is_no_answer_at_all_is_an_error_that_names_the_solver() {
    let model = punch(false, Law::Frictionless);
    let answers: [(&[f64], &str); 2] = [(&[1.0], "length 1"), (&[f64::NAN; 6], "entry 0 of λ")];
    for (lambda, expected) in answers {
        let solver = Mine(
            |_: &DualProblem, _: Option<&Multipliers>, _: Observer<'_>| {
                let (lambda, alpha) = (lambda.to_vec(), vec![0.0]);
                Ok(Outcome::new(Multipliers { lambda, alpha }, 1))
            },
        );
        let error = model.solve_by(&solver).unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, Error::Solver(_)), "{message}");
        assert!(
            message.contains("mine") && message.contains(expected),
            "{message}"
        );
    }
}

#[test]
fn forces_of_anybody_become_a_solution_and_are_certified() {
    for law in [
        Law::Frictionless,
        Law::Tied,
        Law::Tresca(Field::constant(1.0)),
        Law::Coulomb(Field::constant(0.2)),
    ] {
        for held in [true, false] {
            let model = punch(held, law.clone());
            let expected = model.solve().unwrap();
            let mut dual = model.dual(1.0).unwrap();
            let elsewhere = borrowed(dual.problem(), None, &mut silent).unwrap();
            let own = dual.solve(Method::Newton).unwrap();
            for forces in [&elsewhere.multipliers, &own] {
                assert!(dual.certify(forces).unwrap().holds(), "{law}");
                let solution = dual.recover(forces).unwrap();
                assert!(solution.converged && solution.solver.method == "given");
                assert_same(&solution, &expected);
            }
        }
    }
}

#[test]
fn each_unknown_is_the_contact_node_and_the_direction_that_it_tells() {
    let model = punch(false, Law::Coulomb(Field::constant(0.2)));
    let mut dual = model.dual(1.0).unwrap();
    let forces = dual.solve(Method::Auto).unwrap();
    let solution = dual.recover(&forces).unwrap();
    let gaps = dual.problem().gap(&forces);
    let unknowns = dual.unknowns();
    assert_eq!(unknowns.len(), dual.problem().len());
    assert_eq!(unknowns.len(), 2 * solution.contacts[0].nodes.len());
    for (i, unknown) in unknowns.iter().enumerate() {
        let node = &solution.contacts[unknown.contact].nodes[unknown.place];
        assert_eq!((node.node, node.point), (unknown.node, unknown.point));
        let per_area = forces.lambda[i] / unknown.weight;
        let traction: f64 = match unknown.component {
            0 => node.pressure,
            _ => (0..2).map(|c| -node.shear[c] * unknown.direction[c]).sum(),
        };
        assert!((per_area - traction).abs() <= 1e-10 * 10.0, "row {i}");
        if unknown.component == 0 {
            assert!((gaps[i] - node.gap).abs() <= 1e-10 * dual.problem().scales.length);
        }
    }
    for (index, (block, range)) in dual.problem().admissible.iter().enumerate() {
        assert!(unknowns[range.clone()].iter().all(|u| u.block == index));
        assert_eq!(block.size(), range.len());
    }
}

/// x with Kx = b on the dofs that are not held, by conjugate gradients.
fn compliant(system: &dotyk::fem::BodySystem<2>, b: &[f64]) -> Vec<f64> {
    let free = |v: &mut [f64]| {
        let held = v.iter_mut().zip(&system.held);
        held.filter(|(_, held)| **held).for_each(|(v, _)| *v = 0.0);
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (mut x, mut rest) = (vec![0.0; b.len()], b.to_vec());
    free(&mut rest);
    let mut along = rest.clone();
    let mut product = vec![0.0; b.len()];
    let first = dot(&rest, &rest);
    for _ in 0..10 * b.len() {
        let before = dot(&rest, &rest);
        if before <= 1e-28 * first {
            break;
        }
        system.stiffness.mul(&along, &mut product);
        free(&mut product);
        let step = before / dot(&along, &product);
        for i in 0..x.len() {
            x[i] += step * along[i];
            rest[i] -= step * product[i];
        }
        let ratio = dot(&rest, &rest) / before;
        for (along, rest) in along.iter_mut().zip(&rest) {
            *along = rest + ratio * *along;
        }
    }
    x
}

#[test]
fn compliance_is_that_of_the_rows_and_the_stiffness_of_the_bodies() {
    let model = punch(true, Law::Coulomb(Field::constant(0.2)));
    let dual = model.dual(1.0).unwrap();
    let (rows, problem) = (dual.rows(), dual.problem());
    let m = problem.len();
    let mut f = vec![0.0; m * m];
    let mut d: Vec<f64> = dual.initial_gaps().iter().map(|gap| -gap).collect();
    for (body, (name, columns)) in model.bodies.iter().zip(dual.columns()) {
        assert_eq!(body.name, name);
        let system = assemble(body, model.analysis, 1.0).unwrap();
        assert_eq!(system.load.len(), columns.len());
        let own = |i: usize| {
            let mut row = vec![0.0; columns.len()];
            let entries = rows.row(i).filter(|(j, _)| columns.contains(j));
            entries.for_each(|(j, value)| row[j - columns.start] = value);
            row
        };
        let of_load = compliant(&system, &system.load);
        for i in 0..m {
            let row = own(i);
            let moved = compliant(&system, &row);
            let product =
                |v: &[f64], u: &[f64]| -> f64 { v.iter().zip(u).map(|(v, u)| v * u).sum() };
            d[i] += product(&row, &of_load);
            for j in 0..m {
                f[i * m + j] += product(&own(j), &moved);
            }
        }
    }
    let columns = (0..m).flat_map(|j| {
        let unit: Vec<f64> = (0..m).map(|i| f64::from(u8::from(i == j))).collect();
        let mut column = vec![0.0; m];
        problem.compliance.apply(&unit, &mut column);
        column
    });
    assert_near(&columns.collect::<Vec<f64>>(), &f, 1e-10);
    assert_near(&problem.shift, &d, 1e-10);
}

/// B of the displacements and the forces of the contacts, from a solution.
fn check_rows(dual: &Dual<2>, forces: &Multipliers, solution: &Solution<2>) {
    let rows = dual.rows();
    let mut u: Vec<f64> = solution
        .bodies
        .iter()
        .flat_map(|body| body.displacement.concat())
        .collect();
    let bodies = u.len();
    // the points of couples: their displacement, and their rotation at the end of an arm
    for (body, solved) in dual.model().bodies.iter().zip(&solution.bodies) {
        for (couple, point) in body.couples.iter().zip(&solved.couples) {
            let nodes = body.mesh.side_nodes(&couple.side).unwrap();
            let away = |node: u32| distance(body.mesh.points()[node as usize], couple.point);
            let arm = nodes.into_iter().map(away).fold(0.0, f64::max);
            u.extend(point.displacement);
            u.extend([point.rotation[0] * arm, 0.0]);
        }
    }
    let known = u.len() == rows.cols();
    u.resize(rows.cols(), 0.0);
    let mut push = vec![0.0; rows.cols()];
    rows.mul_transpose_add(&forces.lambda, &mut push);
    let felt: Vec<f64> = solution
        .bodies
        .iter()
        .flat_map(|body| body.contact_forces.concat())
        .collect();
    let exerted: Vec<f64> = push[..bodies].iter().map(|push| -push).collect();
    assert_near(&exerted, &felt, 1e-10);
    // that of an obstacle is not
    if known {
        let mut moved = vec![0.0; rows.rows()];
        rows.mul(&u, &mut moved);
        let left = dual.initial_gaps().iter().zip(&moved);
        let left: Vec<f64> = left.map(|(g0, moved)| g0 - moved).collect();
        // gaps are differences of displacements
        let scale = u.iter().fold(0.0, |s: f64, u| s.max(u.abs()));
        for (left, gap) in left.iter().zip(dual.problem().gap(forces)) {
            assert!((left - gap).abs() <= 1e-10 * scale, "{left} {gap}");
        }
    }
}

#[test]
fn rows_turn_displacements_into_gaps_and_forces_into_nodal_forces() {
    for (held, law) in [
        (true, Law::Tied),
        (false, Law::Coulomb(Field::constant(0.2))),
    ] {
        let mut model = punch(held, law);
        // a support along an oblique direction turns the frames of its nodes
        model.roller(BodyId(1), "left", 1e-3);
        model.bodies[1].supports.remove(0);
        let mut dual = model.dual(1.0).unwrap();
        let forces = dual.solve(Method::Auto).unwrap();
        check_rows(&dual, &forces, &dual.recover(&forces).unwrap());
    }
    for kind in [CoupleKind::Rigid, CoupleKind::Average] {
        let mut model = punch(false, Law::Coulomb(Field::constant(0.2)));
        let top = model.bodies[1].mesh.side_nodes("top").unwrap();
        let at = model.bodies[1].mesh.points()[top[0] as usize];
        let couple = model.couple(BodyId(1), "top", ("P", [at[0] + 0.3, at[1] + 0.7]), kind);
        couple.force = [0.5, -4.0].map(Field::constant);
        let mut dual = model.dual(1.0).unwrap();
        let forces = dual.solve(Method::Auto).unwrap();
        let solution = dual.recover(&forces).unwrap();
        assert!(solution.bodies[1].couples[0].rotation[0] != 0.0);
        check_rows(&dual, &forces, &solution);
    }
    // an obstacle that a force presses from above
    let mut model = punch(true, Law::Frictionless);
    model.contacts.clear();
    model.bodies.truncate(1);
    let contact = model.obstacle((BodyId(0), "top"), Field::constant(0.0));
    contact.name = "plate".to_string();
    let Pair::Obstacle { obstacle, .. } = &mut contact.pair else {
        panic!("it was made against an obstacle");
    };
    obstacle.motion = Motion::Loaded([Field::constant(0.0), Field::constant(-7.0)]);
    let mut dual = model.dual(1.0).unwrap();
    let parts = dual.columns();
    let (name, columns) = parts.last().unwrap();
    assert_eq!((name.as_str(), columns.len()), ("obstacle of plate", 2));
    let forces = dual.solve(Method::Auto).unwrap();
    check_rows(&dual, &forces, &dual.recover(&forces).unwrap());
    let mut push = vec![0.0; columns.end];
    dual.rows().mul_transpose_add(&forces.lambda, &mut push);
    // the contact carries what presses the plate
    assert!((push[columns.end - 1] + 7.0).abs() < 1e-10 * 7.0);
}

#[test]
fn friction_counts_slip_from_the_step_before_the_time_that_is_asked_for() {
    let model = hysteresis(&[0.4, 0.8, 1.2]);
    let steps = model.solve_steps().unwrap();
    for (k, time) in [(1, 0.8), (2, 1.2)] {
        let mut dual = model.dual(time).unwrap();
        assert_eq!(dual.time(), time);
        let forces = dual.solve(Method::Newton).unwrap();
        assert_same(&dual.recover(&forces).unwrap(), &steps[k]);
    }
    // without what came before it would be another problem
    let mut alone = hysteresis(&[1.2]).dual(1.2).unwrap();
    let forces = alone.solve(Method::Newton).unwrap();
    let shear = |s: &Solution<2>| s.contacts[0].resultant[0];
    let alone = alone.recover(&forces).unwrap();
    assert!((shear(&alone) - shear(&steps[2])).abs() > 1e-3 * shear(&steps[2]).abs());
}

#[test]
fn a_dual_problem_does_not_change_by_being_solved() {
    let model = punch(false, Law::Frictionless);
    let mut dual = model.dual(1.0).unwrap();
    let fresh = model.dual_problem(DENSE_LIMIT).unwrap();
    for method in Method::NAMED {
        let forces = dual.solve(method).unwrap();
        assert!(dual.certify(&forces).unwrap().holds());
        assert_eq!(dual.problem().shift, fresh.shift);
        assert_eq!(dual.model().solver.method, Method::Auto);
    }
    assert!(matches!(model.dual(f64::NAN), Err(Error::Times(_))));
}

#[test]
fn forces_of_another_shape_are_refused() {
    let dual = punch(false, Law::Frictionless).dual(1.0).unwrap();
    let m = dual.problem().len();
    let refused = |lambda: Vec<f64>, alpha: Vec<f64>| {
        let forces = Multipliers { lambda, alpha };
        let errors = [
            dual.certify(&forces).unwrap_err(),
            dual.recover(&forces).unwrap_err(),
        ];
        assert!(errors.iter().all(|e| matches!(e, Error::Solver(_))));
        errors[0].to_string()
    };
    let message = refused(vec![0.0; m + 1], vec![0.0]);
    assert!(message.contains("λ has length 7, but 6"), "{message}");
    let message = refused(vec![0.0; m], Vec::new());
    assert!(message.contains("α has length 0, but 1"), "{message}");
    let message = refused(vec![0.0; m], vec![f64::INFINITY]);
    assert!(message.contains("entry 0 of α is inf"), "{message}");
}

/// A problem with friction and bodies that float, condensed once for all of them.
static ROUGH: LazyLock<Dual<2>> = LazyLock::new(|| {
    punch(false, Law::Coulomb(Field::constant(0.2)))
        .dual(1.0)
        .unwrap()
});

proptest! {
    #[test]
    fn forces_without_any_sense_are_judged_without_panic(
        lambda in prop::collection::vec(-1e3f64..1e3, 12),
        exponent in -300i32..300,
        alpha in -1e3f64..1e3,
    ) {
        let scale = 10f64.powi(exponent);
        let lambda = lambda.iter().map(|l| l * scale).collect();
        let forces = Multipliers { lambda, alpha: vec![alpha * scale] };
        prop_assert_eq!(forces.lambda.len(), ROUGH.problem().len());
        let certificate: Option<Certificate> = ROUGH.certify(&forces).ok();
        prop_assert!(certificate.is_none_or(|certificate| !certificate.holds()));
        prop_assert!(ROUGH.recover(&forces).is_err());
    }
}
