//! Friction in the dual problem: every solver on small problems whose solution is known, and Newton on contact-like ones.
//!
//! A block of λ is (normal, tangential..). Signs: the tangential gap is minus the slip of this step, so that a slipping
//! node has λₜ = −bound · gapₜ/|gapₜ|. A problem is built from its answer: λ* and gap* that satisfy the laws, then
//! d = Fλ* − Gᵀα* − gap* and e = Gλ*. Units: none.

use std::ops::ControlFlow;

use dotyk::dual::{AdmissibleSet, Balance, Block, Compliance, DualProblem, Friction, Multipliers};
use dotyk::linalg::{Mat, SparseMatrix};
use dotyk::solve::{
    Accelerated, ContactSolver, FixedPoint, Gradient, Iterate, Mprgp, Newton, Outcome, Secant,
    SolveError, Uzawa,
};

/// Residual asked of every solver: the conditioning of these problems then leaves 1e-9 in λ.
const TOLERANCE: f64 = 1e-12;

/// Pseudo-random numbers (splitmix64), the same in every run.
pub(crate) struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [−1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
}

fn silent(_: &Iterate<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

fn product(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..matrix.nrows())
        .map(|i| (0..x.len()).map(|j| matrix[(i, j)] * x[j]).sum())
        .collect()
}

/// Every solver, with a tolerance that leaves its λ comparable.
fn solvers() -> Vec<Box<dyn ContactSolver>> {
    vec![
        Box::new(Uzawa {
            tolerance: TOLERANCE,
            ..Uzawa::default()
        }),
        Box::new(Gradient {
            tolerance: TOLERANCE,
            ..Gradient::default()
        }),
        Box::new(accelerated()),
        Box::new(Mprgp {
            tolerance: TOLERANCE,
            ..Mprgp::default()
        }),
        Box::new(Secant {
            tolerance: TOLERANCE,
            ..Secant::default()
        }),
        Box::new(newton()),
    ]
}

fn accelerated() -> Accelerated {
    Accelerated {
        tolerance: TOLERANCE,
        ..Accelerated::default()
    }
}

fn newton() -> Newton {
    Newton {
        tolerance: TOLERANCE,
        ..Newton::default()
    }
}

/// A problem with its answer.
struct Known {
    name: String,
    problem: DualProblem,
    lambda: Vec<f64>,
}

/// What the node does in the answer.
#[derive(Clone, Copy)]
enum Node {
    Open,
    Stick,
    Slip,
}

/// Which friction law the nodes have.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    Tresca,
    Coulomb,
    Cohesive,
}

/// `nodes` with `tangents` each that are open, stick and slip in turn, in front of them two tied forces.
fn random_problem(law: Law, tangents: usize, nodes: usize, r: usize, seed: u64) -> Known {
    let mut random = Random(seed);
    let coefficient = 0.4;
    let size = 1 + tangents;
    let m = 2 + size * nodes;
    // Close to diagonal: Coulomb's law then has one solution.
    let a = Mat::from_fn(m, m, |_, _| random.signed());
    let matrix = Mat::from_fn(m, m, |i, j| {
        let product: f64 = (0..m).map(|l| a[(l, i)] * a[(l, j)]).sum();
        product / m as f64 + if i == j { 1.0 } else { 0.0 }
    });
    let modes = Mat::from_fn(r, m, |_, _| random.signed());
    let mut blocks = vec![Block::Free { size: 2 }];
    let mut lambda = vec![random.signed(), random.signed()];
    let mut gap = vec![0.0; 2];
    for i in 0..nodes {
        let node = [Node::Slip, Node::Stick, Node::Open][i % 3];
        let (force, opening) = (0.2 + random.unit(), 0.2 + random.unit());
        let bound = match law {
            Law::Coulomb => coefficient * force,
            Law::Cohesive => 0.1 + coefficient * force,
            // Small: the tangential force of an open node is bounded all the same.
            Law::Tresca => 0.1 + 0.3 * random.unit(),
        };
        let direction = unit((0..tangents).map(|_| random.signed()).collect());
        let (fraction, slip) = (0.9 * random.unit(), 0.2 + random.unit());
        let normal = match node {
            Node::Open => (0.0, opening),
            Node::Stick | Node::Slip => (force, 0.0),
        };
        lambda.push(normal.0);
        gap.push(normal.1);
        for s in direction {
            let (shear, jump) = match (node, law) {
                (Node::Open, Law::Coulomb | Law::Cohesive) => (0.0, s * slip),
                (Node::Stick, _) => (fraction * bound * s, 0.0),
                (Node::Slip, _) | (Node::Open, Law::Tresca) => (bound * s, -slip * s),
            };
            lambda.push(shear);
            gap.push(jump);
        }
        blocks.push(match law {
            Law::Tresca => Friction::Tresca { bound }.block(tangents),
            Law::Coulomb => Friction::Coulomb { coefficient }.block(tangents),
            Law::Cohesive => Friction::Cohesive {
                cohesion: 0.1,
                coefficient,
            }
            .block(tangents),
        });
    }
    let alpha: Vec<f64> = (0..r).map(|_| random.signed()).collect();
    let image = product(&matrix, &lambda);
    let shift = (0..m)
        .map(|i| {
            let rigid: f64 = (0..r).map(|j| modes[(j, i)] * alpha[j]).sum();
            image[i] - rigid - gap[i]
        })
        .collect();
    let load = product(&modes, &lambda);
    let problem = DualProblem::new(
        Compliance::Dense(matrix),
        shift,
        AdmissibleSet::new(blocks),
        Balance::new(modes, load),
    )
    .unwrap();
    Known {
        name: format!("{law:?}, {tangents} tangents, {nodes} nodes, r = {r}, seed {seed}"),
        problem,
        lambda,
    }
}

fn unit(v: Vec<f64>) -> Vec<f64> {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.iter().map(|x| x / length).collect()
}

fn family(tangents: usize) -> Vec<Known> {
    let mut all = Vec::new();
    for law in [Law::Tresca, Law::Coulomb] {
        for r in 0..=3 {
            for seed in 0..4 {
                all.push(random_problem(law, tangents, 9, r, seed));
            }
        }
    }
    all
}

/// The answer of `solver`, or `None` where it refuses discs by name.
fn answer(solver: &dyn ContactSolver, problem: &DualProblem, what: &str) -> Option<Outcome> {
    let disc = |block: &Block| !matches!(block, Block::Free { .. }) && block.size() > 2;
    let discs = problem.admissible.blocks().iter().any(disc);
    match solver.solve(problem, None, &mut silent) {
        Err(SolveError::Unsupported { .. }) if discs && solver.name() == "mprgp" => None,
        Ok(outcome) => Some(outcome),
        Err(error) => panic!("{}: {what}: {error}", solver.name()),
    }
}

#[test]
fn every_solver_finds_the_constructed_solution_and_is_certified() {
    for tangents in [1, 2] {
        for known in family(tangents) {
            for solver in solvers() {
                let what = format!("{}: {}", solver.name(), known.name);
                let Some(outcome) = answer(solver.as_ref(), &known.problem, &known.name) else {
                    continue;
                };
                let error = worst(&outcome.multipliers.lambda, &known.lambda);
                assert!(error < 1e-9, "{what}: error {error:e}");
                let certificate = known.problem.certify(&outcome.multipliers, 1e-9);
                assert!(certificate.holds(), "{what}\n{certificate}");
                let direct = solver.name() == "newton";
                let coulomb = known.problem.admissible.bounds_follow();
                assert_eq!(outcome.fixed_point.is_some(), coulomb && !direct, "{what}");
                if let Some(found) = outcome.fixed_point {
                    assert!(found.contraction.unwrap() < 0.5, "{what}: {found:?}");
                    assert!(found.iterations < 20, "{what}: {found:?}");
                }
                if direct {
                    assert!(outcome.iterations <= 20, "{what}: {}", outcome.iterations);
                }
            }
        }
    }
}

#[test]
fn newton_finds_the_constructed_solution_with_cohesion() {
    let mut found = 0;
    for tangents in [1, 2] {
        for r in 0..=3 {
            for seed in 0..4 {
                let known = random_problem(Law::Cohesive, tangents, 9, r, seed);
                let Ok(outcome) = newton().solve(&known.problem, None, &mut silent) else {
                    continue;
                };
                let certificate = known.problem.certify(&outcome.multipliers, 1e-9);
                assert!(certificate.holds(), "{}\n{certificate}", known.name);
                found += usize::from(worst(&outcome.multipliers.lambda, &known.lambda) < 1e-9);
            }
        }
    }
    assert!(found >= 24, "{found} of 32");
}

#[test]
fn sparse_compliance_gives_the_solution_of_the_assembled_one() {
    for tangents in [1, 2] {
        for mut known in family(tangents) {
            let Compliance::Dense(matrix) = &known.problem.compliance else {
                panic!("{}", known.name);
            };
            known.problem.compliance = Compliance::Sparse(SparseMatrix::from_dense(matrix));
            let outcome = answer(&newton(), &known.problem, &known.name).unwrap();
            let error = worst(&outcome.multipliers.lambda, &known.lambda);
            assert!(error < 1e-9, "{}: error {error:e}", known.name);
            assert!(outcome.iterations <= 20, "{}", known.name);
        }
    }
}

#[test]
fn wrong_answers_fail_certification() {
    for tangents in [1, 2] {
        for known in family(tangents) {
            let right = answer(&newton(), &known.problem, &known.name).unwrap();
            for i in 0..known.lambda.len() {
                let mut wrong = right.multipliers.clone();
                wrong.lambda[i] += 1e-3;
                let certificate = known.problem.certify(&wrong, 1e-8);
                assert!(!certificate.holds(), "{}: force {i}", known.name);
                assert!(known.problem.kkt_residual(&wrong) > 1e-8);
            }
        }
    }
}

#[test]
fn solution_as_starting_point_needs_no_second_step() {
    for known in family(1) {
        let first = answer(&newton(), &known.problem, &known.name).unwrap();
        let again = newton()
            .solve(&known.problem, Some(&first.multipliers), &mut silent)
            .unwrap();
        assert_eq!(again.iterations, 1, "{}", known.name);
        assert!(worst(&again.multipliers.lambda, &known.lambda) < 1e-9);
    }
}

#[test]
fn dissipated_work_is_the_bound_times_the_slip() {
    for tangents in [1, 2] {
        for known in family(tangents) {
            let outcome = answer(&newton(), &known.problem, &known.name).unwrap();
            let lambda = &outcome.multipliers.lambda;
            let gap = known.problem.gap(&outcome.multipliers);
            let set = &known.problem.admissible;
            let mut expected = 0.0;
            for ((_, range), bound) in set.iter().zip(set.bounds(lambda)) {
                let slip = gap[range].iter().skip(1).map(|t| t * t).sum::<f64>().sqrt();
                expected += bound * slip;
            }
            let found = known.problem.dissipation(lambda, &gap);
            assert!(expected > 0.01, "{}: nothing slips", known.name);
            assert!((found - expected).abs() < 1e-10, "{}: {found}", known.name);
        }
    }
}

#[test]
fn tresca_is_coulomb_when_its_bounds_are_those_of_the_solution() {
    for tangents in [1, 2] {
        for r in 0..=3 {
            let coulomb = random_problem(Law::Coulomb, tangents, 12, r, 40 + r as u64);
            let set = &coulomb.problem.admissible;
            let tresca = DualProblem {
                admissible: set.with_bounds(&set.bounds(&coulomb.lambda)),
                ..coulomb.problem
            };
            for solver in solvers() {
                if let Some(outcome) = answer(solver.as_ref(), &tresca, &coulomb.name) {
                    let error = worst(&outcome.multipliers.lambda, &coulomb.lambda);
                    assert!(error < 1e-9, "{}: {error:e}", solver.name());
                    assert_eq!(outcome.fixed_point, None);
                }
            }
        }
    }
}

#[test]
fn coefficient_zero_is_the_problem_without_friction() {
    let nodes = 20;
    let matrix = half_plane(nodes);
    let shift = punch(nodes, 1.0, 8.0, 0.3);
    let normals = Mat::from_fn(nodes, nodes, |i, j| matrix[(2 * i, 2 * j)]);
    let smooth = DualProblem::new(
        Compliance::Dense(normals),
        shift.iter().step_by(2).copied().collect(),
        AdmissibleSet::new(vec![Block::Unilateral; nodes]),
        Balance::none(nodes),
    )
    .unwrap();
    let expected = answer(&newton(), &smooth, "smooth").unwrap();
    let problem = held(matrix, shift, coulomb(nodes, 0.0));
    for solver in solvers() {
        let outcome = answer(solver.as_ref(), &problem, "coefficient 0").unwrap();
        for (node, force) in expected.multipliers.lambda.iter().enumerate() {
            let found = &outcome.multipliers.lambda[2 * node..][..2];
            assert!((found[0] - force).abs() < 1e-9, "{}", solver.name());
            assert_eq!(found[1], 0.0, "{}", solver.name());
        }
    }
}

/// A half plane under `nodes` contact nodes on [0, 1]: (normal, tangential) of each node, modulus such that the surface
/// under a line load sinks by −ln|x|, Poisson's ratio 0.3 through the coupling of normal load and tangential motion.
fn half_plane(nodes: usize) -> Mat<f64> {
    let step = 1.0 / nodes as f64;
    let coupling = std::f64::consts::PI * (1.0 - 2.0 * 0.3) / (4.0 * (1.0 - 0.3));
    Mat::from_fn(2 * nodes, 2 * nodes, |i, j| {
        let distance = (i / 2) as f64 * step - (j / 2) as f64 * step;
        if i % 2 == j % 2 {
            2.0 - (distance.abs() + 0.3 * step).ln()
        } else if distance == 0.0 {
            0.0
        } else {
            // u_t of a normal load points towards it: antisymmetric in place, symmetric as a matrix.
            let sign = if i % 2 == 1 { 1.0 } else { -1.0 };
            -sign * coupling * distance.signum()
        }
    })
}

fn coulomb(nodes: usize, coefficient: f64) -> AdmissibleSet {
    AdmissibleSet::new(vec![Friction::Coulomb { coefficient }.block(1); nodes])
}

/// Overlap of a punch at rest: `depth`, rounded by `curvature`, moved sideways by `slide`.
fn punch(nodes: usize, depth: f64, curvature: f64, slide: f64) -> Vec<f64> {
    let normal = |x: f64| depth - curvature * (x - 0.45).powi(2);
    (0..2 * nodes)
        .map(|i| match i % 2 {
            0 => normal((i / 2) as f64 / nodes as f64),
            _ => slide,
        })
        .collect()
}

/// The problem of held bodies.
fn held(matrix: Mat<f64>, shift: Vec<f64>, set: AdmissibleSet) -> DualProblem {
    let m = shift.len();
    DualProblem::new(Compliance::Dense(matrix), shift, set, Balance::none(m)).unwrap()
}

/// Sinking, sliding and tilting of a punch over `nodes` nodes on [0, 1], about its middle.
fn punch_modes(nodes: usize) -> Mat<f64> {
    Mat::from_fn(3, 2 * nodes, |mode, i| {
        let x = (i / 2) as f64 / nodes as f64;
        match (mode, i % 2) {
            (0, 0) | (1, 1) => 1.0,
            (2, 0) => x - 0.5,
            _ => 0.0,
        }
    })
}

/// Every punch of the step counts: held at a depth and moved sideways, or floating under a load.
fn punches(nodes: usize, coefficient: f64) -> Vec<(String, DualProblem)> {
    let mut all = Vec::new();
    for curvature in [0.0, 0.5, 4.0, 40.0] {
        for slide in [0.0, 0.05, 0.2, 1.0] {
            for floating in [false, true] {
                let balance = if floating {
                    let load = vec![1.0, 0.9 * slide * coefficient, -0.02];
                    Balance::new(punch_modes(nodes), load)
                } else {
                    Balance::none(2 * nodes)
                };
                let name = format!(
                    "coefficient {coefficient}, curvature {curvature}, slide {slide}, floating {floating}"
                );
                let problem = DualProblem::new(
                    Compliance::Dense(half_plane(nodes)),
                    punch(nodes, 1.0, curvature, slide),
                    coulomb(nodes, coefficient),
                    balance,
                )
                .unwrap();
                all.push((name, problem));
            }
        }
    }
    all
}

#[test]
fn newton_takes_few_steps_on_a_half_plane_and_ends_exactly() {
    let nodes = 250;
    for coefficient in [0.2, 0.5, 1.0] {
        for (name, problem) in punches(nodes, coefficient) {
            let outcome = Newton::default()
                .solve(&problem, None, &mut silent)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            // With coefficient 1 the slip still spreads from node to node where nearly all of them slip in the end.
            let ceiling = if coefficient < 1.0 || !name.contains("slide 1") {
                12
            } else {
                14
            };
            assert!(
                outcome.iterations <= ceiling,
                "{name}: {}",
                outcome.iterations
            );
            assert_eq!(outcome.fixed_point, None, "{name}");
            let residual = problem.kkt_residual(&outcome.multipliers);
            assert!(residual < 1e-12, "{name}: {residual:e}");
        }
    }
}

#[test]
fn every_solver_finds_the_same_punch() {
    let nodes = 16;
    for coefficient in [0.2, 0.5] {
        for (name, problem) in punches(nodes, coefficient) {
            let exact = answer(&newton(), &problem, &name).unwrap().multipliers;
            for solver in solvers() {
                // Bolts make a punch on a half plane a matter of a million iterations.
                if solver.name() == "uzawa" && !problem.balance.load().is_empty() {
                    continue;
                }
                let outcome = answer(solver.as_ref(), &problem, &name).unwrap();
                let what = format!("{}: {name}", solver.name());
                if let Some(FixedPoint { contraction, .. }) = outcome.fixed_point {
                    assert!(
                        contraction.is_none_or(|factor| factor < 0.9),
                        "{what} {contraction:?}"
                    );
                }
                let error = worst(&outcome.multipliers.lambda, &exact.lambda);
                assert!(error < 1e-8, "{what}: {error:e}");
            }
        }
    }
}

/// A block on `nodes` springs that overlaps by `overlap` (normal, tangential): sinking, sliding and tilting.
fn block(nodes: usize, coefficient: f64, load: [f64; 3], overlap: [f64; 2]) -> DualProblem {
    let m = 2 * nodes;
    DualProblem::new(
        Compliance::Dense(Mat::from_fn(m, m, |i, j| {
            if i == j { 1.0 + 0.1 * i as f64 } else { 0.0 }
        })),
        (0..m).map(|i| overlap[i % 2]).collect(),
        coulomb(nodes, coefficient),
        Balance::new(punch_modes(nodes), load.to_vec()),
    )
    .unwrap()
}

#[test]
fn block_on_a_plane_rests_below_the_limit_of_friction_and_is_refused_above() {
    let (nodes, coefficient) = (7, 0.3);
    // At the limit itself every node is at its bound, and no gap tells how far the block has slid.
    for part in [0.0, 0.5, 0.99, -0.99, 1.0] {
        let problem = block(
            nodes,
            coefficient,
            [1.0, part * coefficient, 0.05],
            [0.0; 2],
        );
        for solver in solvers() {
            let outcome = answer(solver.as_ref(), &problem, "block").unwrap();
            let certificate = problem.certify(&outcome.multipliers, 1e-9);
            assert!(certificate.holds(), "{}\n{certificate}", solver.name());
            let shear: f64 = outcome.multipliers.lambda.iter().skip(1).step_by(2).sum();
            assert!(
                (shear - part * coefficient).abs() < 1e-10,
                "{}",
                solver.name()
            );
        }
    }
    for part in [1.01, -1.5] {
        let problem = block(
            nodes,
            coefficient,
            [1.0, part * coefficient, 0.05],
            [0.0; 2],
        );
        for solver in solvers() {
            let Err(SolveError::Infeasible { direction, .. }) =
                solver.solve(&problem, None, &mut silent)
            else {
                panic!("{} found a force that cannot exist", solver.name());
            };
            assert!((direction[1] - part.signum()).abs() < 1e-9, "{direction:?}");
        }
    }
}

#[test]
fn hovering_body_with_friction_takes_no_force() {
    let problem = block(5, 0.4, [0.0; 3], [1.0, 0.3]);
    for solver in solvers() {
        let outcome = answer(solver.as_ref(), &problem, "hovering").unwrap();
        let largest = worst(&outcome.multipliers.lambda, &[0.0; 10]);
        assert!(largest < 1e-11, "{}: {largest:e}", solver.name());
        let certificate = problem.certify(&outcome.multipliers, 1e-9);
        assert!(certificate.holds(), "{}\n{certificate}", solver.name());
    }
}

#[test]
fn cyclic_sliding_dissipates_in_each_step_and_a_rest_does_not() {
    let (nodes, coefficient) = (40, 0.2);
    let mut slip = vec![0.0; nodes];
    let mut guess: Option<Multipliers> = None;
    for (step, slide) in [0.3, -0.3, 0.3, 0.3].into_iter().enumerate() {
        let mut shift = punch(nodes, 1.0, 2.0, slide);
        for (node, slip) in slip.iter().enumerate() {
            shift[2 * node + 1] -= slip;
        }
        let problem = held(half_plane(nodes), shift, coulomb(nodes, coefficient));
        let outcome = newton()
            .solve(&problem, guess.as_ref(), &mut silent)
            .unwrap();
        let gap = problem.gap(&outcome.multipliers);
        let work = problem.dissipation(&outcome.multipliers.lambda, &gap);
        if step < 3 {
            assert!(work > 1e-3, "step {step}: {work:e}");
        } else {
            // The same load again: nothing slips, no force changes.
            assert!(work.abs() < 1e-12, "{work:e}");
            let before = &guess.as_ref().unwrap().lambda;
            assert!(worst(before, &outcome.multipliers.lambda) < 1e-10);
        }
        for (node, slip) in slip.iter_mut().enumerate() {
            *slip -= gap[2 * node + 1];
        }
        guess = Some(outcome.multipliers);
    }
}

/// One node with F = [[1, b], [b, 1]] that slips: bound ↦ coefficient · (dₙ − b · bound) contracts by b · coefficient.
fn coupled_node(b: f64, coefficient: f64) -> DualProblem {
    let matrix = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { b });
    held(matrix, vec![1.0, 5.0], coulomb(1, coefficient))
}

#[test]
fn contraction_of_the_bounds_is_measured() {
    let problem = coupled_node(0.6, 0.5);
    for solver in solvers() {
        let outcome = answer(solver.as_ref(), &problem, "one node").unwrap();
        let normal = 1.0 / (1.0 + 0.6 * 0.5);
        assert!((outcome.multipliers.lambda[0] - normal).abs() < 1e-11);
        if let Some(FixedPoint { contraction, .. }) = outcome.fixed_point {
            let factor = contraction.unwrap();
            // Near the end the change of the bounds is small against the accuracy of the problems.
            assert!((factor - 0.3).abs() < 0.02, "{}: {factor}", solver.name());
        }
    }
}

#[test]
fn bounds_that_do_not_contract_are_found_by_parts_of_the_way_and_told() {
    let problem = coupled_node(0.9, 1.5);
    let exact = 1.0 / (1.0 + 0.9 * 1.5);
    let direct = newton().solve(&problem, None, &mut silent).unwrap();
    assert!((direct.multipliers.lambda[0] - exact).abs() < 1e-12);
    assert_eq!(direct.fixed_point, None);
    let outcome = Accelerated::default()
        .solve(&problem, None, &mut silent)
        .unwrap();
    assert!((outcome.multipliers.lambda[0] - exact).abs() < 1e-7);
    assert!(outcome.fixed_point.unwrap().contraction.unwrap() > 0.99);
    let told = |remark: &String| remark.contains("may not be unique");
    assert!(outcome.remarks.iter().any(told), "{:?}", outcome.remarks);
}

#[test]
fn units_do_not_change_the_steps() {
    // Force × 1e6, length × 1e-3: F × 1e-9.
    for (name, problem) in punches(30, 0.5) {
        let Compliance::Dense(matrix) = &problem.compliance else {
            unreachable!("the punches are dense");
        };
        let m = matrix.nrows();
        let load = problem.balance.load();
        let scaled = DualProblem::new(
            Compliance::Dense(Mat::from_fn(m, m, |i, j| 1e-9 * matrix[(i, j)])),
            problem.shift.iter().map(|d| 1e-3 * d).collect(),
            problem.admissible.clone(),
            Balance::new(
                problem.balance.modes().clone(),
                load.iter().map(|e| 1e6 * e).collect(),
            ),
        )
        .unwrap();
        let plain = answer(&newton(), &problem, &name).unwrap();
        let other = answer(&newton(), &scaled, &name).unwrap();
        let count = (plain.iterations, other.iterations);
        assert!(count.0.abs_diff(count.1) <= 1, "{name}: {count:?}");
        let back: Vec<f64> = other.multipliers.lambda.iter().map(|l| 1e-6 * l).collect();
        assert!(worst(&plain.multipliers.lambda, &back) < 1e-9, "{name}");
    }
}

#[test]
fn states_that_cycle_are_rescued() {
    // Far from elastic bodies: nearly dependent contacts.
    let (mut rescued, mut total) = (0, 0);
    for law in [Law::Tresca, Law::Coulomb] {
        for seed in 0..200 {
            let mut random = Random(3000 + seed);
            let nodes = 2 + (seed % 8) as usize;
            let (m, rank) = (2 * nodes, 1 + nodes);
            let a = Mat::from_fn(rank, m, |_, _| random.signed());
            let matrix = Mat::from_fn(m, m, |i, j| {
                let product: f64 = (0..rank).map(|l| a[(l, i)] * a[(l, j)]).sum();
                product + if i == j { 1e-2 } else { 0.0 }
            });
            let set = match law {
                Law::Tresca => coulomb(nodes, 0.1).with_all_bounds(0.2),
                _ => coulomb(nodes, 0.1),
            };
            let shift = (0..m).map(|_| random.signed()).collect();
            let problem = held(matrix, shift, set);
            let mut kinds = String::new();
            let solved = Newton::default().solve(&problem, None, &mut |iterate: &Iterate<'_>| {
                kinds.push(iterate.step);
                ControlFlow::Continue(())
            });
            match solved {
                Ok(outcome) => {
                    let certificate = problem.certify(&outcome.multipliers, 1e-8);
                    assert!(certificate.holds(), "{law:?}, seed {seed}\n{certificate}");
                    rescued += usize::from(kinds.contains(['i', 'p']));
                    total += 1;
                }
                Err(error) => {
                    // Only Coulomb's law may have no fixed point that can be reached.
                    assert!(law == Law::Coulomb, "seed {seed}: {error}");
                    assert!(error.to_string().contains("may not be unique"), "{error}");
                }
            }
        }
    }
    assert!(
        rescued > 0,
        "no cycle in {total} problems: the guard was not tried"
    );
    assert!(total >= 390, "{total}");
}

#[test]
fn observer_that_is_satisfied_stops_every_solver() {
    let known = random_problem(Law::Coulomb, 1, 8, 1, 71);
    for solver in solvers() {
        let mut last = Vec::new();
        let outcome = solver
            .solve(&known.problem, None, &mut |iterate: &Iterate<'_>| {
                last = iterate.lambda.to_vec();
                if iterate.iteration == 2 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
            .unwrap();
        assert!(outcome.stopped_by_observer, "{}", solver.name());
        assert_eq!(outcome.iterations, 2, "{}", solver.name());
        assert_eq!(outcome.multipliers.lambda, last, "{}", solver.name());
    }
}

#[test]
fn too_few_iterations_are_an_error_with_the_last_iterate() {
    let known = random_problem(Law::Coulomb, 1, 12, 2, 51);
    let accelerated = Accelerated {
        max_iterations: 9,
        ..Accelerated::default()
    };
    let mut seen = 0;
    let result = accelerated.solve(&known.problem, None, &mut |iterate: &Iterate<'_>| {
        seen = iterate.iteration;
        ControlFlow::Continue(())
    });
    let Err(SolveError::NotConverged {
        outcome, residual, ..
    }) = result
    else {
        panic!("nine iterations cannot suffice");
    };
    assert_eq!((outcome.iterations, seen), (9, 9));
    assert!(residual > 1e-8 && outcome.multipliers.lambda.len() == 26);
}

/// A half space under n × n nodes of a unit square, (normal, two tangential) each, Poisson's ratio 0.3: the surface
/// displacements of point loads after Boussinesq and Cerruti, with the distance cut off at part of the spacing.
fn half_space(n: usize) -> Mat<f64> {
    let poisson = 0.3;
    let at = |node: usize| [(node % n) as f64 / n as f64, (node / n) as f64 / n as f64];
    let cut = 0.4 / n as f64;
    let m = 3 * n * n;
    Mat::from_fn(m, m, |i, j| {
        let (a, b) = (at(i / 3), at(j / 3));
        let apart = [a[0] - b[0], a[1] - b[1]];
        let distance = (apart[0].powi(2) + apart[1].powi(2) + cut * cut).sqrt();
        let along = |component: usize| apart[component - 1] / distance;
        let coupling = 0.5 * (1.0 - 2.0 * poisson);
        let unit = match (i % 3, j % 3) {
            (0, 0) => 1.0 - poisson,
            (0, k) => -coupling * along(k),
            (k, 0) => coupling * along(k),
            (k, l) => (1.0 - poisson) * f64::from(k == l) + poisson * along(k) * along(l),
        };
        unit / distance
    })
}

#[test]
fn newton_takes_few_steps_in_space_where_directions_of_slip_turn() {
    let n = 8;
    for coefficient in [0.2, 0.5, 1.0] {
        for slide in [0.0, 0.1, 0.5] {
            for twist in [0.0, 0.3] {
                let shift = (0..3 * n * n)
                    .map(|i| {
                        let x = (i / 3 % n) as f64 / n as f64 - 0.45;
                        let y = (i / 3 / n) as f64 / n as f64 - 0.45;
                        match i % 3 {
                            0 => 1.0 - 3.0 * (x * x + y * y),
                            1 => slide - twist * y,
                            _ => twist * x,
                        }
                    })
                    .collect();
                let block = Friction::Coulomb { coefficient }.block(2);
                let set = AdmissibleSet::new(vec![block; n * n]);
                let problem = held(half_space(n), shift, set);
                let name = format!("coefficient {coefficient}, slide {slide}, twist {twist}");
                let direct = answer(&newton(), &problem, &name).unwrap();
                assert!(direct.iterations <= 10, "{name}: {}", direct.iterations);
                assert_eq!(direct.fixed_point, None, "{name}");
                let other = answer(&accelerated(), &problem, &name).unwrap();
                let error = worst(&direct.multipliers.lambda, &other.multipliers.lambda);
                assert!(error < 1e-8, "{name}: {error:e}");
            }
        }
    }
}

#[test]
fn friction_that_is_no_number_from_zero_on_is_an_error() {
    for value in [-0.1, f64::NAN, f64::INFINITY] {
        let coulomb = Friction::Coulomb { coefficient: value }.block(1);
        let tresca = Friction::Tresca { bound: value }.block(1);
        for block in [coulomb, tresca] {
            let result = DualProblem::new(
                Compliance::Dense(Mat::identity(3, 3)),
                vec![0.0; 3],
                AdmissibleSet::new(vec![Block::Unilateral, block]),
                Balance::none(3),
            );
            let text = result.err().unwrap().to_string();
            assert!(text.contains("friction of block 1"), "{text}");
        }
    }
}

/// The same problem with the compliance that a grounded floating body leaves: none along the rows of G.
fn grounded(mut known: Known) -> Known {
    let Compliance::Dense(matrix) = &known.problem.compliance else {
        unreachable!("the family is dense");
    };
    let modes = known.problem.balance.modes();
    let m = known.lambda.len();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for row in 0..modes.nrows() {
        let mut v: Vec<f64> = (0..m).map(|i| modes[(row, i)]).collect();
        for q in &basis {
            let part: f64 = q.iter().zip(&v).map(|(q, v)| q * v).sum();
            v.iter_mut().zip(q).for_each(|(v, q)| *v -= part * q);
        }
        basis.push(unit(v));
    }
    let across = Mat::from_fn(m, m, |i, j| {
        let held: f64 = basis.iter().map(|q| q[i] * q[j]).sum();
        f64::from(i == j) - held
    });
    let soft = &across * matrix * &across;
    let (before, after) = (
        product(matrix, &known.lambda),
        product(&soft, &known.lambda),
    );
    for (d, (before, after)) in known
        .problem
        .shift
        .iter_mut()
        .zip(before.iter().zip(&after))
    {
        *d += after - before;
    }
    known.problem.compliance = Compliance::Dense(soft);
    known.name += ", grounded";
    known
}

#[test]
fn compliance_of_grounded_bodies_is_semidefinite_and_does_no_harm() {
    for known in family(1).into_iter().map(grounded) {
        for solver in solvers() {
            let outcome = answer(solver.as_ref(), &known.problem, &known.name).unwrap();
            let error = worst(&outcome.multipliers.lambda, &known.lambda);
            let what = format!("{}: {}", solver.name(), known.name);
            assert!(error < 1e-9, "{what}: {error:e}");
            if solver.name() == "newton" {
                assert!(outcome.iterations <= 10, "{what}: {}", outcome.iterations);
                assert!(outcome.remarks.is_empty(), "{what}: {:?}", outcome.remarks);
            }
        }
    }
}
