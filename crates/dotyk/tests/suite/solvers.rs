//! Every solver on every small problem whose solution is known by construction.
//!
//! A problem is built from its answer: λ* and the gap s* are chosen complementary (λ* ≥ 0, s* ≥ 0, λ*s* = 0), α*, F and G
//! freely, and then d = Fλ* − Gᵀα* − s* and e = Gλ*. Signs: gap ≥ 0 is open, λ ≥ 0 is compression. Units: none.

use crate::friction::Random;
use std::ops::ControlFlow;
use std::path::Path;

use dotyk::case::Case;
use dotyk::dual::{
    AdmissibleSet, Balance, Block, Compliance, DualProblem, Friction, Multipliers, Scales,
};
use dotyk::linalg::{LinearOperator, Mat, SparseMatrix};
use dotyk::solve::{
    Accelerated, Bolt, ContactSolver, Gradient, Iterate, Mprgp, Newton, Outcome, Secant,
    SolveError, Uzawa,
};

/// Residual asked of every solver: the conditioning of these problems then leaves 1e-9 in λ.
const TOLERANCE: f64 = 1e-12;

/// AᵀA/m + `floor`·I.
fn compliance(random: &mut Random, m: usize, floor: f64) -> Mat<f64> {
    let a = Mat::from_fn(m, m, |_, _| random.signed());
    Mat::from_fn(m, m, |i, j| {
        let product: f64 = (0..m).map(|l| a[(l, i)] * a[(l, j)]).sum();
        product / m as f64 + if i == j { floor } else { 0.0 }
    })
}

fn product(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..matrix.nrows())
        .map(|i| (0..x.len()).map(|j| matrix[(i, j)] * x[j]).sum())
        .collect()
}

/// A problem with its answer.
struct Known {
    name: String,
    problem: DualProblem,
    matrix: Mat<f64>,
    lambda: Vec<f64>,
}

/// Builds the problem from F, G, λ*, s*, α*.
fn known(
    name: String,
    matrix: Mat<f64>,
    modes: Mat<f64>,
    blocks: Vec<Block>,
    answer: (Vec<f64>, Vec<f64>, Vec<f64>),
) -> Known {
    let (lambda, gap, alpha) = answer;
    let m = lambda.len();
    let image = product(&matrix, &lambda);
    let shift = (0..m)
        .map(|i| {
            let rigid: f64 = (0..alpha.len()).map(|j| modes[(j, i)] * alpha[j]).sum();
            image[i] - rigid - gap[i]
        })
        .collect();
    let load = product(&modes, &lambda);
    let problem = DualProblem::new(
        Compliance::Dense(matrix.clone()),
        shift,
        AdmissibleSet::new(blocks),
        Balance::new(modes, load),
    )
    .unwrap();
    Known {
        name,
        problem,
        matrix,
        lambda,
    }
}

/// What the contacts of a problem do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pattern {
    Half,
    AllClosed,
    AllOpen,
    /// A third of the contacts has λ = gap = 0.
    Degenerate,
}

fn random_problem(m: usize, r: usize, pattern: Pattern, free: usize, seed: u64) -> Known {
    let mut random = Random(seed);
    let matrix = compliance(&mut random, m, 0.3);
    let modes = Mat::from_fn(r, m, |_, _| random.signed());
    let (mut lambda, mut gap) = (vec![0.0; m], vec![0.0; m]);
    for i in 0..m {
        let (force, opening) = (0.2 + random.unit(), 0.2 + random.unit());
        let closed = match pattern {
            Pattern::AllClosed => true,
            Pattern::AllOpen => false,
            Pattern::Half => i % 2 == 0,
            Pattern::Degenerate if i % 3 == 2 => continue,
            Pattern::Degenerate => i % 3 == 0,
        };
        if i < free {
            // Tied: any force, no gap.
            lambda[i] = if pattern == Pattern::AllOpen {
                0.0
            } else {
                random.signed()
            };
        } else if closed {
            lambda[i] = force;
        } else {
            gap[i] = opening;
        }
    }
    let alpha = (0..r).map(|_| random.signed()).collect();
    let mut blocks = vec![Block::Unilateral; m - free];
    if free > 0 {
        blocks.insert(0, Block::Free { size: free });
    }
    let name = format!("{pattern:?}, m = {m}, r = {r}, free = {free}, seed {seed}");
    known(name, matrix, modes, blocks, (lambda, gap, alpha))
}

/// The same problem with a redundant row of G and one that no contact controls.
fn with_redundant_modes(mut known: Known) -> Known {
    let (modes, load) = (known.problem.balance.modes(), known.problem.balance.load());
    let (r, m) = (modes.nrows(), modes.ncols());
    let extended = Mat::from_fn(r + 2, m, |i, j| {
        if i < r {
            modes[(i, j)]
        } else if i == r {
            modes[(0, j)] - 0.5 * modes[(r - 1, j)]
        } else {
            // Rounding of a mode that slides along every contact.
            1e-16 * ((i + j) as f64).sin()
        }
    });
    let mut load = load.to_vec();
    load.extend([load[0] - 0.5 * load[r - 1], 0.0]);
    known.problem.balance = Balance::new(extended, load);
    known.name += ", redundant modes";
    known
}

fn family() -> Vec<Known> {
    let mut all = Vec::new();
    for r in 0..=3 {
        for seed in 0..3 {
            for pattern in [Pattern::Half, Pattern::AllClosed, Pattern::Degenerate] {
                all.push(random_problem(24, r, pattern, 0, seed));
                all.push(random_problem(24, r, pattern, 5, 100 + seed));
            }
            all.push(random_problem(24, r, Pattern::AllOpen, 0, 200 + seed));
        }
    }
    for seed in 0..3 {
        all.push(random_problem(1, 0, Pattern::AllClosed, 0, seed));
        all.push(random_problem(1, 0, Pattern::AllOpen, 0, seed));
        all.push(random_problem(1, 1, Pattern::AllClosed, 0, seed));
        all.push(with_redundant_modes(random_problem(
            24,
            2,
            Pattern::Half,
            0,
            300 + seed,
        )));
    }
    all
}

/// Every solver with the most iterations it may need on the small problems.
fn solvers() -> Vec<(Box<dyn ContactSolver>, usize)> {
    vec![
        (
            Box::new(Uzawa {
                tolerance: TOLERANCE,
                ..Uzawa::default()
            }),
            20_000,
        ),
        (
            Box::new(Gradient {
                tolerance: TOLERANCE,
                ..Gradient::default()
            }),
            400,
        ),
        (
            Box::new(Accelerated {
                tolerance: TOLERANCE,
                ..Accelerated::default()
            }),
            250,
        ),
        (
            Box::new(Mprgp {
                tolerance: TOLERANCE,
                ..Mprgp::default()
            }),
            250,
        ),
        (
            Box::new(Secant {
                tolerance: TOLERANCE,
                ..Secant::default()
            }),
            250,
        ),
        (
            Box::new(Newton {
                tolerance: TOLERANCE,
                ..Newton::default()
            }),
            20,
        ),
    ]
}

fn silent(_: &Iterate<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[test]
fn every_solver_finds_the_constructed_solution_and_is_certified() {
    for known in family() {
        for (solver, ceiling) in solvers() {
            let what = format!("{}: {}", solver.name(), known.name);
            let outcome = solver
                .solve(&known.problem, None, &mut silent)
                .unwrap_or_else(|error| panic!("{what}: {error}"));
            let error = worst(&outcome.multipliers.lambda, &known.lambda);
            assert!(error < 1e-9, "{what}: error {error:e}");
            let certificate = known.problem.certify(&outcome.multipliers, 1e-9);
            assert!(certificate.holds(), "{what}\n{certificate}");
            assert!(
                outcome.iterations <= ceiling,
                "{what}: {} iterations",
                outcome.iterations
            );
        }
    }
}

#[test]
fn solution_as_starting_point_needs_no_second_iteration() {
    for known in family() {
        for (solver, _) in solvers() {
            let first = solver.solve(&known.problem, None, &mut silent).unwrap();
            let again = solver
                .solve(&known.problem, Some(&first.multipliers), &mut silent)
                .unwrap();
            // The p,A-algorithm may have to leave its bolts again.
            let ceiling = match solver.name() {
                "uzawa" => first.iterations.max(1),
                // contacts with neither force nor gap come and go by rounding
                _ if known.name.contains("Degenerate") => 4,
                _ => 2,
            };
            assert!(
                again.iterations <= ceiling,
                "{}: {}: {} after {}",
                solver.name(),
                known.name,
                again.iterations,
                first.iterations
            );
            let error = worst(&again.multipliers.lambda, &known.lambda);
            assert!(error < 1e-9, "{}: {}: {error:e}", solver.name(), known.name);
        }
    }
}

#[test]
fn wrong_answers_fail_certification() {
    for known in family() {
        let right = Newton::default()
            .solve(&known.problem, None, &mut silent)
            .unwrap()
            .multipliers;
        for i in 0..right.lambda.len() {
            let mut wrong = right.clone();
            wrong.lambda[i] += 1e-3;
            assert!(
                !known.problem.certify(&wrong, 1e-8).holds(),
                "{}: force {i} is wrong",
                known.name
            );
        }
    }
}

#[test]
fn units_do_not_change_the_iterations() {
    // Force × 1e6, length × 1e-3: F × 1e-9.
    for known in family() {
        let Compliance::Dense(matrix) = &known.problem.compliance else {
            unreachable!("the family is dense");
        };
        let scaled = DualProblem::new(
            Compliance::Dense(Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
                1e-9 * matrix[(i, j)]
            })),
            known.problem.shift.iter().map(|d| 1e-3 * d).collect(),
            known.problem.admissible.clone(),
            Balance::new(
                known.problem.balance.modes().clone(),
                known
                    .problem
                    .balance
                    .load()
                    .iter()
                    .map(|e| 1e6 * e)
                    .collect(),
            ),
        )
        .unwrap();
        // Zero loads and shifts have no scale of their own.
        if known.problem.scales.force == 0.0 || known.lambda.iter().all(|l| *l == 0.0) {
            continue;
        }
        for solver in [
            &Newton::default() as &dyn ContactSolver,
            &Accelerated::default(),
            &Gradient::default(),
        ] {
            let plain = solver.solve(&known.problem, None, &mut silent).unwrap();
            let other = solver.solve(&scaled, None, &mut silent).unwrap();
            assert!(
                plain.iterations.abs_diff(other.iterations) <= 1,
                "{}: {}: {} and {}",
                solver.name(),
                known.name,
                plain.iterations,
                other.iterations
            );
        }
    }
}

#[test]
fn load_that_pulls_away_is_refused_with_its_direction() {
    let known = random_problem(12, 0, Pattern::Half, 0, 7);
    // Mode 0 opens every contact; the load works on it. Mode 1 is held by both signs.
    let modes = Mat::from_fn(
        2,
        12,
        |i, j| if i == 0 { -1.0 } else { j as f64 / 11.0 - 0.4 },
    );
    let problem = DualProblem::new(
        Compliance::Dense(known.matrix),
        known.problem.shift,
        known.problem.admissible,
        Balance::new(modes, vec![2.0, 0.1]),
    )
    .unwrap();
    for (solver, _) in solvers() {
        let Err(SolveError::Infeasible { direction, .. }) =
            solver.solve(&problem, None, &mut silent)
        else {
            panic!("{} found a force that cannot exist", solver.name());
        };
        let balance = &problem.balance;
        let work: f64 = (0..2).map(|i| direction[i] * balance.load()[i]).sum();
        assert!(work > 0.1, "{}: work {work}", solver.name());
        for j in 0..12 {
            let closing: f64 = (0..2).map(|i| direction[i] * balance.modes()[(i, j)]).sum();
            assert!(
                closing < 1e-12,
                "{}: contact {j} closes by {closing:e}",
                solver.name()
            );
        }
    }
}

#[test]
fn load_of_rounding_size_on_a_free_body_is_no_load() {
    let mut known = random_problem(12, 1, Pattern::AllOpen, 0, 5);
    let modes = Mat::from_fn(1, 12, |_, j| -1.0 - 0.1 * j as f64);
    known.problem.balance = Balance::new(modes, vec![1e-14]);
    known.problem.scales.force = 1.0;
    for (solver, _) in solvers() {
        let outcome = solver.solve(&known.problem, None, &mut silent).unwrap();
        assert!(outcome.multipliers.lambda.iter().all(|l| l.abs() < 1e-12));
        assert!(known.problem.certify(&outcome.multipliers, 1e-8).holds());
    }
}

#[test]
fn hovering_body_takes_the_nearest_open_position() {
    // All contacts overlap by 1, 2, 3 at rest; the body must rise by 3, no force is left.
    let problem = DualProblem::new(
        Compliance::Dense(Mat::from_fn(3, 3, |i, j| f64::from(i == j))),
        vec![1.0, 2.0, 3.0],
        AdmissibleSet::new(vec![Block::Unilateral; 3]),
        Balance::new(Mat::from_fn(1, 3, |_, _| 1.0), vec![0.0]),
    )
    .unwrap();
    let outcome = Newton::default()
        .solve(&problem, None, &mut silent)
        .unwrap();
    assert_eq!(outcome.multipliers.lambda, vec![0.0; 3]);
    assert!((outcome.multipliers.alpha[0] + 3.0).abs() < 1e-12);
    for (solver, _) in solvers() {
        let outcome = solver.solve(&problem, None, &mut silent).unwrap();
        assert!(
            problem.certify(&outcome.multipliers, 1e-9).holds(),
            "{}",
            solver.name()
        );
    }
}

#[test]
fn no_contact_at_all_is_legal_for_held_bodies_and_infeasible_for_loaded_floating_ones() {
    let empty = |load: Vec<f64>| {
        DualProblem::new(
            Compliance::Dense(Mat::zeros(0, 0)),
            Vec::new(),
            AdmissibleSet::new(Vec::new()),
            Balance::new(Mat::zeros(load.len(), 0), load),
        )
        .unwrap()
    };
    for (solver, _) in solvers() {
        for load in [vec![], vec![0.0]] {
            let outcome = solver
                .solve(&empty(load.clone()), None, &mut silent)
                .unwrap();
            assert_eq!(outcome.multipliers.alpha, load);
        }
        assert!(matches!(
            solver.solve(&empty(vec![1.0]), None, &mut silent),
            Err(SolveError::Infeasible { .. })
        ));
    }
}

/// λ after each iteration.
fn history(solver: &dyn ContactSolver, problem: &DualProblem, count: usize) -> Vec<Vec<f64>> {
    let mut iterates = Vec::new();
    let result = solver.solve(problem, None, &mut |iterate: &Iterate<'_>| {
        iterates.push(iterate.lambda.to_vec());
        if iterates.len() == count {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    assert!(result.unwrap().stopped_by_observer);
    iterates
}

#[test]
fn bolt_algorithm_is_projected_gradient_on_the_reduced_problem() {
    let known = random_problem(15, 1, Pattern::Half, 0, 11);
    let (problem, bolt, rho, count) = (&known.problem, 4, 0.2, 60);
    let uzawa = Uzawa {
        bolts: Some(vec![bolt]),
        rho: Some(rho),
        tolerance: 0.0,
        ..Uzawa::default()
    };
    let iterates = history(&uzawa, problem, count);
    // λ = λ⁰ + Zμ with λ_A eliminated; μ ← max(0, μ − ρ(S_A μ − b)) in plain matrices.
    let g = |i: usize| problem.balance.modes()[(0, i)];
    let others: Vec<usize> = (0..15).filter(|&i| i != bolt).collect();
    let z = Mat::from_fn(15, 14, |i, j| {
        if i == bolt {
            -g(others[j]) / g(bolt)
        } else {
            f64::from(i == others[j])
        }
    });
    let mut offset = vec![0.0; 15];
    offset[bolt] = problem.balance.load()[0] / g(bolt);
    let mut mu = vec![0.0; 14];
    for (k, iterate) in iterates.iter().enumerate() {
        let forces = |mu: &[f64]| -> Vec<f64> {
            product(&z, mu)
                .iter()
                .zip(&offset)
                .map(|(a, b)| a + b)
                .collect()
        };
        let image = product(&known.matrix, &forces(&mu));
        for j in 0..14 {
            let slope: f64 = (0..15)
                .map(|i| z[(i, j)] * (image[i] - problem.shift[i]))
                .sum();
            mu[j] = (mu[j] - rho * slope).max(0.0);
        }
        let error = worst(iterate, &forces(&mu));
        assert!(error < 1e-12, "iterate {}: {error:e}", k + 1);
    }
}

#[test]
fn bolt_algorithm_is_the_gradient_method_where_nothing_floats() {
    let known = random_problem(15, 0, Pattern::Half, 0, 12);
    let uzawa = Uzawa {
        rho: Some(0.3),
        tolerance: 0.0,
        ..Uzawa::default()
    };
    let gradient = Gradient {
        rho: Some(0.3),
        tolerance: 0.0,
        ..Gradient::default()
    };
    let (a, b) = (
        history(&uzawa, &known.problem, 40),
        history(&gradient, &known.problem, 40),
    );
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        assert!(worst(a, b) < 1e-14, "iterate {}", k + 1);
    }
}

fn bolted(problem: &DualProblem, bolt: usize, move_improper: bool) -> Result<Outcome, SolveError> {
    Uzawa {
        bolts: Some(vec![bolt]),
        tolerance: TOLERANCE,
        move_improper,
        ..Uzawa::default()
    }
    .solve(problem, None, &mut silent)
}

#[test]
fn proper_bolt_has_the_limit_of_the_exact_projection() {
    for seed in 0..5 {
        let known = random_problem(16, 1, Pattern::Half, 0, 20 + seed);
        let exact = Gradient {
            tolerance: TOLERANCE,
            ..Gradient::default()
        };
        let reference = exact.solve(&known.problem, None, &mut silent).unwrap();
        for bolt in [2, 6, 10] {
            let outcome = bolted(&known.problem, bolt, false).unwrap();
            let error = worst(&outcome.multipliers.lambda, &reference.multipliers.lambda);
            assert!(error < 1e-9, "bolt {bolt}: {error:e}");
            assert_eq!(outcome.bolts.len(), 1);
            let force = known.lambda[bolt];
            assert!((outcome.bolts[0].force - force).abs() < 1e-9 && !outcome.bolts[0].moved);
        }
    }
}

#[test]
fn improper_bolt_is_reported_and_never_accepted() {
    let mut tried = 0;
    for seed in 0..5 {
        let known = random_problem(16, 1, Pattern::Half, 0, 20 + seed);
        for bolt in [1, 5, 9] {
            // Open in the solution: the bolt must pull.
            let result = bolted(&known.problem, bolt, false);
            let Err(SolveError::ImproperBolt {
                bolt: found,
                outcome,
            }) = result
            else {
                panic!("seed {seed}: bolt {bolt} was accepted");
            };
            assert!(found.index == bolt && found.force < -1e-3, "{found:?}");
            assert!(worst(&outcome.multipliers.lambda, &known.lambda) > 1e-3);
            assert!(!known.problem.certify(&outcome.multipliers, 1e-8).holds());
            let moved = bolted(&known.problem, bolt, true).unwrap();
            assert_eq!(
                moved.bolts[0],
                Bolt {
                    moved: true,
                    ..found
                }
            );
            assert!(worst(&moved.multipliers.lambda, &known.lambda) < 1e-9);
            let settled = moved.bolts.last().unwrap();
            assert!(!settled.moved || !moved.remarks.is_empty());
            tried += usize::from(!settled.moved);
        }
    }
    assert!(tried > 5, "moving the bolt helped only {tried} times");
}

#[test]
fn bolts_that_hold_nothing_are_named() {
    let mut known = random_problem(10, 1, Pattern::AllClosed, 0, 3);
    let mut modes = known.problem.balance.modes().to_dense();
    modes[(0, 4)] = 0.0;
    let load = product(&modes, &known.lambda);
    known.problem.balance = Balance::new(modes, load);
    for bolts in [vec![4], vec![], vec![1, 2]] {
        let uzawa = Uzawa {
            bolts: Some(bolts.clone()),
            ..Uzawa::default()
        };
        match uzawa.solve(&known.problem, None, &mut silent) {
            Err(SolveError::DependentBolts {
                bolts: named,
                modes: 1,
            }) => assert_eq!(named, bolts),
            other => panic!("{bolts:?}: {other:?}"),
        }
    }
    let beyond = Uzawa {
        bolts: Some(vec![10]),
        ..Uzawa::default()
    };
    let error = beyond.solve(&known.problem, None, &mut silent).unwrap_err();
    assert!(error.to_string().contains("10"), "{error}");
}

#[test]
fn several_bolts_hold_several_modes() {
    let known = random_problem(20, 3, Pattern::AllClosed, 0, 31);
    let uzawa = Uzawa {
        bolts: Some(vec![3, 8, 15]),
        tolerance: TOLERANCE,
        ..Uzawa::default()
    };
    let outcome = uzawa.solve(&known.problem, None, &mut silent).unwrap();
    assert!(worst(&outcome.multipliers.lambda, &known.lambda) < 1e-9);
    let mut modes: Vec<usize> = outcome.bolts.iter().map(|bolt| bolt.mode).collect();
    modes.sort_unstable();
    assert_eq!(modes, vec![0, 1, 2]);
}

#[test]
fn step_beyond_its_limit_is_named_with_the_limit() {
    let known = random_problem(20, 1, Pattern::AllClosed, 0, 41);
    let solvers: [Box<dyn ContactSolver>; 2] = [
        Box::new(Uzawa {
            bolts: Some(vec![2]),
            rho: Some(1e3),
            ..Uzawa::default()
        }),
        Box::new(Gradient {
            rho: Some(1e3),
            max_iterations: 500,
            ..Gradient::default()
        }),
    ];
    for solver in solvers {
        let error = solver.solve(&known.problem, None, &mut silent).unwrap_err();
        assert!(matches!(error, SolveError::NotConverged { .. }), "{error}");
        let text = error.to_string();
        assert!(
            text.contains("rho = 1.0") && text.contains("2/λ_max"),
            "{text}"
        );
    }
    for rho in [0.0, -1.0, f64::NAN] {
        let gradient = Gradient {
            rho: Some(rho),
            ..Gradient::default()
        };
        assert!(matches!(
            gradient.solve(&known.problem, None, &mut silent),
            Err(SolveError::Invalid(_))
        ));
    }
}

#[test]
fn too_few_iterations_are_an_error_with_the_last_iterate() {
    let known = random_problem(30, 2, Pattern::Half, 0, 51);
    let solvers: [Box<dyn ContactSolver>; 4] = [
        Box::new(Uzawa {
            max_iterations: 3,
            ..Uzawa::default()
        }),
        Box::new(Gradient {
            max_iterations: 3,
            ..Gradient::default()
        }),
        Box::new(Accelerated {
            max_iterations: 3,
            ..Accelerated::default()
        }),
        Box::new(Mprgp {
            max_iterations: 3,
            ..Mprgp::default()
        }),
    ];
    for solver in solvers {
        let mut seen = Vec::new();
        let result = solver.solve(&known.problem, None, &mut |iterate: &Iterate<'_>| {
            seen.push((iterate.iteration, iterate.residual));
            ControlFlow::Continue(())
        });
        let Err(SolveError::NotConverged {
            outcome, residual, ..
        }) = result
        else {
            panic!("{} cannot converge in three iterations", solver.name());
        };
        assert_eq!(outcome.iterations, 3, "{}", solver.name());
        assert_eq!(seen.len(), 3, "{}", solver.name());
        assert!(residual > 1e-8 && seen.iter().all(|(_, residual)| residual.is_finite()));
        assert_eq!(outcome.multipliers.lambda.len(), 30);
    }
}

#[test]
fn friction_with_applied_compliance_is_solved_by_every_method() {
    let known = random_problem(4, 0, Pattern::AllClosed, 0, 1);
    let blocks = vec![
        Block::Unilateral,
        Block::Unilateral,
        Friction::Coulomb { coefficient: 0.3 }.block(1),
    ];
    let problem = DualProblem::new(
        Compliance::Operator {
            apply: Box::new(Applied(known.matrix)),
            preconditioner: Box::new(Applied(Mat::identity(4, 4))),
            glue: None,
        },
        known.problem.shift,
        AdmissibleSet::new(blocks),
        Balance::none(4),
    )
    .unwrap();
    for (solver, _) in solvers() {
        let outcome = solver
            .solve(&problem, None, &mut silent)
            .unwrap_or_else(|error| panic!("{}: {error}", solver.name()));
        assert!(problem.certify(&outcome.multipliers, 1e-9).holds());
    }
}

/// Contacts in space, each between two of `bodies` rigid bodies with six motions; overlaps that some motion undoes.
fn rigid_bodies(
    contacts: usize,
    bodies: usize,
    coefficient: f64,
    random: &mut Random,
) -> DualProblem {
    let (m, motions) = (3 * contacts, 6 * bodies);
    let mut rows = Mat::zeros(m, motions);
    for contact in 0..contacts {
        let body = contact % bodies;
        let further = 1 + (random.unit() * (bodies - 1) as f64) as usize;
        let other = (body + further) % bodies;
        for i in 3 * contact..3 * contact + 3 {
            for motion in 0..6 {
                rows[(i, 6 * body + motion)] = random.signed();
                rows[(i, 6 * other + motion)] = random.signed();
            }
        }
    }
    let compliance = Mat::from_fn(m, m, |i, j| {
        (0..motions).map(|l| rows[(i, l)] * rows[(j, l)]).sum()
    });
    let motion: Vec<f64> = (0..motions).map(|_| random.signed()).collect();
    let block = Friction::Coulomb { coefficient }.block(2);
    DualProblem::new(
        Compliance::Dense(compliance),
        product(&rows, &motion),
        AdmissibleSet::new(vec![block; contacts]),
        Balance::none(m),
    )
    .unwrap()
}

#[test]
fn friction_in_space_on_a_compliance_of_low_rank_takes_few_steps() {
    // half the rank: forces are not unique, and exact steps meet singular systems
    for seed in 0..12 {
        let problem = rigid_bodies(40, 10, 0.7, &mut Random(7000 + seed));
        let outcome = Newton::default()
            .solve(&problem, None, &mut silent)
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let certificate = problem.certify(&outcome.multipliers, 1e-8);
        assert!(certificate.holds(), "seed {seed}\n{certificate}");
        assert!(
            outcome.iterations <= 60,
            "seed {seed}: {}",
            outcome.iterations
        );
    }
}

#[test]
fn bad_numbers_and_sizes_are_errors() {
    let known = random_problem(6, 1, Pattern::AllClosed, 0, 1);
    let shift_with = |value: f64| {
        let mut shift = known.problem.shift.clone();
        shift[3] = value;
        shift
    };
    let build = |shift: Vec<f64>| {
        DualProblem::new(
            Compliance::Dense(known.matrix.clone()),
            shift,
            known.problem.admissible.clone(),
            known.problem.balance.clone(),
        )
    };
    let text = build(shift_with(f64::NAN)).err().unwrap().to_string();
    assert!(text.contains("entry 3 of d is NaN"), "{text}");
    assert!(build(vec![0.0; 5]).is_err());
    for guess in [vec![0.0; 5], vec![f64::INFINITY; 6]] {
        let guess = Multipliers {
            lambda: guess,
            alpha: vec![0.0],
        };
        for (solver, _) in solvers() {
            assert!(matches!(
                solver.solve(&known.problem, Some(&guess), &mut silent),
                Err(SolveError::Invalid(_))
            ));
        }
    }
}

/// A dense matrix as an operator.
struct Applied(Mat<f64>);

#[test]
fn sparse_compliance_gives_the_solution_of_the_assembled_one() {
    for mut known in family() {
        known.problem.compliance = Compliance::Sparse(SparseMatrix::from_dense(&known.matrix));
        for (solver, ceiling) in solvers() {
            let what = format!("{}: {}", solver.name(), known.name);
            let outcome = solver.solve(&known.problem, None, &mut silent);
            let outcome = outcome.unwrap_or_else(|error| panic!("{what}: {error}"));
            let error = worst(&outcome.multipliers.lambda, &known.lambda);
            assert!(error < 1e-9, "{what}: {error:e}");
            assert!(
                outcome.iterations <= ceiling,
                "{what}: {}",
                outcome.iterations
            );
            assert!(known.problem.certify(&outcome.multipliers, 1e-9).holds());
        }
    }
}

/// Blocks on each other, pressed and pushed aside, with friction: `n` floating bodies, each of which touches two others.
fn tower(n: usize) -> DualProblem {
    let mut text = "analysis = \"plane-strain\"\n".to_string();
    for k in 0..n {
        let (low, high) = (k as f64, k as f64 + 1.0);
        // meshes that do not match, stiff beside soft
        let (cells, young) = (12 + k % 3, [1e3, 3e4][k % 2]);
        text += &format!(
            "[[body]]\nname = \"b{k}\"\n\
             mesh = {{ rectangle = {{ from = [0.0, {low:?}], to = [2.0, {high:?}], cells = [{cells}, 3] }} }}\n\
             material = {{ young = {young:?}, poisson = 0.3 }}\n"
        );
        if k + 1 == n {
            text += "load = [{ side = \"top\", traction = [0.003, -1.0] }]\n";
        }
    }
    text += "[[contact]]\nname = \"floor\"\nnonmortar = \"b0.bottom\"\nfriction = 0.4\n\
             obstacle = { plane = { point = [0.0, 0.0], normal = [0.0, 1.0] } }\n";
    for k in 1..n {
        text += &format!(
            "[[contact]]\nname = \"c{k}\"\nfriction = 0.4\nnonmortar = \"b{k}.bottom\"\nmortar = \"b{}.top\"\n",
            k - 1
        );
    }
    let case = Case::<2>::from_str(&text, "case.toml", Path::new(".")).unwrap();
    case.model.dual_problem(usize::MAX).unwrap()
}

#[test]
fn many_bodies_have_a_sparse_compliance_with_the_same_answer() {
    let mut problem = tower(40);
    assert!(matches!(problem.compliance, Compliance::Sparse(_)));
    assert!(problem.balance.load().len() > 96, "many modes");
    let solve = |problem: &DualProblem| {
        let outcome = Newton::default().solve(problem, None, &mut silent).unwrap();
        let certificate = problem.certify(&outcome.multipliers, 1e-8);
        assert!(certificate.holds(), "{certificate}");
        outcome
    };
    let few = solve(&problem);
    assert!(few.iterations <= 8, "{}", few.iterations);
    // the weight of the load goes through every joint
    let pressed = few.multipliers.lambda.iter().filter(|l| **l > 0.0).count();
    assert!(pressed > 400, "{pressed}");
    assert!(problem.assemble(usize::MAX));
    let all = solve(&problem);
    let error = worst(&few.multipliers.lambda, &all.multipliers.lambda);
    assert!(error < 1e-9, "{error:e}");
}

impl LinearOperator for Applied {
    fn len(&self) -> usize {
        self.0.nrows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.copy_from_slice(&product(&self.0, x));
    }
}

#[test]
fn applied_compliance_gives_the_solution_of_the_assembled_one() {
    for known in family() {
        let m = known.lambda.len();
        let problem = DualProblem::new(
            Compliance::Operator {
                apply: Box::new(Applied(known.matrix.clone())),
                glue: None,
                preconditioner: Box::new(Applied(Mat::from_fn(m, m, |i, j| {
                    if i == j {
                        1.0 / known.matrix[(i, i)]
                    } else {
                        0.0
                    }
                }))),
            },
            known.problem.shift.clone(),
            known.problem.admissible.clone(),
            known.problem.balance.clone(),
        )
        .unwrap();
        for (solver, ceiling) in solvers() {
            let outcome = solver
                .solve(&problem, None, &mut silent)
                .unwrap_or_else(|error| panic!("{}: {}: {error}", solver.name(), known.name));
            let error = worst(&outcome.multipliers.lambda, &known.lambda);
            assert!(error < 1e-9, "{}: {}: {error:e}", solver.name(), known.name);
            // Inner solves that are first loose, then tight, cost a few more faces.
            assert!(
                outcome.iterations <= ceiling + 8,
                "{}: {}: {} {:?}",
                solver.name(),
                known.name,
                outcome.iterations,
                outcome.remarks
            );
        }
    }
}

#[test]
fn dependent_rows_of_the_compliance_do_no_harm() {
    // Contact 1 repeats contact 0, contact 3 is rigid and held by the balance alone.
    let known = random_problem(8, 1, Pattern::AllClosed, 0, 61);
    let source = |i: usize| if i == 1 { 0 } else { i };
    let matrix = Mat::from_fn(8, 8, |i, j| {
        if i == 3 || j == 3 {
            0.0
        } else {
            known.matrix[(source(i), source(j))]
        }
    });
    let modes = Mat::from_fn(1, 8, |_, j| 1.0 + 0.1 * source(j) as f64);
    let lambda = vec![0.5, 0.5, 1.0, 0.7, 0.0, 0.9, 0.0, 1.2];
    let gap = vec![0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.4, 0.0];
    let known = dependent_rows(matrix, modes, lambda, gap);
    for (solver, _) in solvers() {
        let outcome = solver.solve(&known.problem, None, &mut silent).unwrap();
        let certificate = known.problem.certify(&outcome.multipliers, 1e-9);
        assert!(certificate.holds(), "{}\n{certificate}", solver.name());
        let found = &outcome.multipliers.lambda;
        // Only the sum of the two forces on the same spot is determined.
        assert!(
            (found[0] + found[1] - 1.0).abs() < 1e-9,
            "{}",
            solver.name()
        );
        assert!(
            worst(&found[2..], &known.lambda[2..]) < 1e-9,
            "{}",
            solver.name()
        );
    }
}

fn dependent_rows(matrix: Mat<f64>, modes: Mat<f64>, lambda: Vec<f64>, gap: Vec<f64>) -> Known {
    let blocks = vec![Block::Unilateral; lambda.len()];
    known(
        "dependent rows".to_string(),
        matrix,
        modes,
        blocks,
        (lambda, gap, vec![0.4]),
    )
}

#[test]
fn local_contact_of_a_floating_punch_takes_few_iterations() {
    // A rounded punch that may sink and tilt, over part of a half plane with logarithmic compliance.
    let m = 100;
    let at = |i: usize| i as f64 / m as f64;
    let matrix = Mat::from_fn(m, m, |i, j| {
        1.0 - ((at(i) - at(j)).abs() + 0.3 / m as f64).ln() / 3.0
    });
    let modes = Mat::from_fn(2, m, |i, j| if i == 0 { 1.0 } else { at(j) - 0.5 });
    let problem = DualProblem::new(
        Compliance::Dense(matrix),
        (0..m).map(|i| -40.0 * (at(i) - 0.45).powi(2)).collect(),
        AdmissibleSet::new(vec![Block::Unilateral; m]),
        Balance::new(modes, vec![1.0, -0.02]),
    )
    .unwrap();
    let exact = Newton::default()
        .solve(&problem, None, &mut silent)
        .unwrap();
    assert!(exact.iterations <= 20, "newton: {}", exact.iterations);
    let closed = exact
        .multipliers
        .lambda
        .iter()
        .filter(|l| **l > 0.0)
        .count();
    assert!((10..30).contains(&closed), "{closed} contacts are closed");
    for (solver, ceiling) in [
        (&Mprgp::default() as &dyn ContactSolver, 100),
        (&Accelerated::default(), 120),
        (&Secant::default(), 60),
    ] {
        let outcome = solver.solve(&problem, None, &mut silent).unwrap();
        let (name, count) = (solver.name(), outcome.iterations);
        assert!(count <= ceiling, "{name}: {count} iterations");
        assert!(
            problem.certify(&outcome.multipliers, 1e-8).holds(),
            "{name}"
        );
        // The residual is 1e-8 of max|d|; the smallest stiffness on the contact magnifies it.
        let error = worst(&outcome.multipliers.lambda, &exact.multipliers.lambda);
        assert!(error < 1e-5, "{name}: {error:e}");
    }
}

#[test]
fn active_sets_that_cycle_are_rescued() {
    // Far from M-matrices: nearly dependent contacts, where plain active sets run in circles.
    let (mut rescued, mut total) = (0, 0);
    for seed in 0..400 {
        for r in 0..=1 {
            let mut random = Random(1000 + seed);
            let m = 3 + (seed % 10) as usize;
            let rank = 1 + m / 3;
            let a = Mat::from_fn(rank, m, |_, _| random.signed());
            let matrix = Mat::from_fn(m, m, |i, j| {
                let product: f64 = (0..rank).map(|l| a[(l, i)] * a[(l, j)]).sum();
                product + if i == j { 1e-3 } else { 0.0 }
            });
            let modes = Mat::from_fn(r, m, |_, _| random.signed());
            let lambda: Vec<f64> = (0..m)
                .map(|i| if i % 2 == 0 { random.unit() } else { 0.0 })
                .collect();
            let gap: Vec<f64> = (0..m)
                .map(|i| if i % 2 == 1 { random.unit() } else { 0.0 })
                .collect();
            let blocks = vec![Block::Unilateral; m];
            let alpha = vec![0.3; r];
            let known = known(
                format!("seed {seed}"),
                matrix,
                modes,
                blocks,
                (lambda, gap, alpha),
            );
            let mut kinds = String::new();
            let outcome = Newton::default()
                .solve(&known.problem, None, &mut |iterate: &Iterate<'_>| {
                    kinds.push(iterate.step);
                    ControlFlow::Continue(())
                })
                .unwrap_or_else(|error| panic!("seed {seed}, r = {r}: {error}"));
            let certificate = known.problem.certify(&outcome.multipliers, 1e-8);
            assert!(certificate.holds(), "seed {seed}, r = {r}\n{certificate}");
            rescued += usize::from(kinds.contains(['i', 'p']));
            total += 1;
        }
    }
    assert!(
        rescued > 0,
        "no cycle in {total} problems: the guard was not tried"
    );
}

#[test]
fn observer_that_is_satisfied_stops_every_solver() {
    let known = random_problem(24, 1, Pattern::Half, 0, 71);
    for (solver, _) in solvers() {
        let mut last = Vec::new();
        let outcome = solver
            .solve(&known.problem, None, &mut |iterate: &Iterate<'_>| {
                last = iterate.lambda.to_vec();
                assert_eq!(iterate.active, last.iter().filter(|l| **l != 0.0).count());
                ControlFlow::Break(())
            })
            .unwrap();
        assert!(
            outcome.stopped_by_observer && outcome.iterations == 1,
            "{}",
            solver.name()
        );
        assert_eq!(outcome.multipliers.lambda, last, "{}", solver.name());
    }
}

#[test]
fn scales_of_the_model_replace_those_of_the_data() {
    let mut known = random_problem(10, 1, Pattern::Half, 0, 81);
    let outcome = Newton::default()
        .solve(&known.problem, None, &mut silent)
        .unwrap();
    let mut wrong = outcome.multipliers;
    wrong.alpha[0] += 1e-6;
    assert!(!known.problem.certify(&wrong, 1e-8).holds());
    known.problem.scales = Scales {
        length: 1e3,
        // of a load a millionth counts beside contact forces
        force: 1e12,
        moment_arm: 1.0,
        energy: 1e6,
    };
    assert!(known.problem.certify(&wrong, 1e-8).holds());
}
