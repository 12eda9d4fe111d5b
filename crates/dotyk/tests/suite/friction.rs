//! Friction in the dual problem: every solver on small problems whose solution is known, and Newton on contact-like ones.
//!
//! A block of λ is (normal, tangential..). Signs: the tangential gap is minus the slip of this step, so that a slipping
//! node has λₜ = −bound · gapₜ/|gapₜ|. A problem is built from its answer: λ* and gap* that satisfy the laws, then
//! d = Fλ* − Gᵀα* − gap* and e = Gλ*. Units: none.

use std::ops::ControlFlow;

use dotyk::dual::{
    AdmissibleSet, Block, Compliance, DualProblem, Equilibrium, Feasibility, Multipliers,
};
use dotyk::linalg::{LinearOperator, Mat};
use dotyk::solve::{
    Accelerated, ContactSolver, Gradient, Iterate, Mprgp, Newton, Outcome, SolveError, Uzawa,
};

/// Residual asked of every solver: the conditioning of these problems then leaves 1e-9 in λ.
const TOLERANCE: f64 = 1e-12;

/// Pseudo-random numbers (splitmix64), the same in every run.
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [−1, 1).
    fn signed(&mut self) -> f64 {
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
        Box::new(Accelerated {
            tolerance: TOLERANCE,
            ..Accelerated::default()
        }),
        Box::new(Mprgp {
            tolerance: TOLERANCE,
            ..Mprgp::default()
        }),
        Box::new(newton()),
    ]
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
                (Node::Open, Law::Coulomb) => (0.0, s * slip),
                (Node::Stick, _) => (fraction * bound * s, 0.0),
                (Node::Slip, _) | (Node::Open, Law::Tresca) => (bound * s, -slip * s),
            };
            lambda.push(shear);
            gap.push(jump);
        }
        blocks.push(match law {
            Law::Tresca => Block::Tresca { tangents, bound },
            Law::Coulomb => Block::Coulomb {
                tangents,
                coefficient,
            },
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
        Equilibrium::new(modes, load),
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

fn refused(error: &SolveError) -> bool {
    matches!(error, SolveError::Unsupported { .. })
}

#[test]
fn every_solver_finds_the_constructed_solution_and_is_certified() {
    for tangents in [1, 2] {
        for known in family(tangents) {
            for solver in solvers() {
                let what = format!("{}: {}", solver.name(), known.name);
                let outcome = match solver.solve(&known.problem, None, &mut silent) {
                    Err(error) if tangents == 2 && solver.name() == "mprgp" => {
                        assert!(refused(&error), "{what}: {error}");
                        continue;
                    }
                    result => result.unwrap_or_else(|error| panic!("{what}: {error}")),
                };
                let error = worst(&outcome.multipliers.lambda, &known.lambda);
                println!(
                    "{what}: {} its {:?} {:?}",
                    outcome.iterations, outcome.fixed_point, outcome.remarks
                );
                assert!(error < 1e-9, "{what}: error {error:e}");
                let certificate = known.problem.certify(&outcome.multipliers, 1e-9);
                assert!(certificate.holds(), "{what}\n{certificate}");
            }
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
    AdmissibleSet::new(vec![
        Block::Coulomb {
            tangents: 1,
            coefficient,
        };
        nodes
    ])
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

#[test]
fn steps() {
    for nodes in [250] {
        let matrix = half_plane(nodes);
        for mu in [0.05, 0.2, 0.5, 1.0] {
            for curvature in [0.0, 0.5, 4.0, 40.0] {
                for slide in [0.0, 0.05, 0.2, 1.0] {
                    for floating in [false, true] {
                        let modes = if floating {
                            Mat::from_fn(3, 2 * nodes, |r, j| {
                                let x = (j / 2) as f64 / nodes as f64;
                                match (r, j % 2) {
                                    (0, 0) => 1.0,
                                    (1, 1) => 1.0,
                                    (2, 0) => x - 0.5,
                                    _ => 0.0,
                                }
                            })
                        } else {
                            Mat::zeros(0, 2 * nodes)
                        };
                        let load = if floating {
                            vec![1.0, slide * mu * 0.9, -0.02]
                        } else {
                            vec![]
                        };
                        let problem = DualProblem::new(
                            Compliance::Dense(matrix.clone()),
                            punch(nodes, 1.0, curvature, slide),
                            coulomb(nodes, mu),
                            Equilibrium::new(modes, load),
                        )
                        .unwrap();
                        let mut log = String::new();
                        let start = std::time::Instant::now();
                        let outcome =
                            Newton::default().solve(&problem, None, &mut |it: &Iterate<'_>| {
                                log += &format!("{:.0e} ", it.residual);
                                ControlFlow::Continue(())
                            });
                        let time = start.elapsed().as_secs_f64();
                        match outcome {
                            Ok(outcome) => {
                                let l = &outcome.multipliers.lambda;
                                let open = (0..nodes).filter(|&i| l[2 * i] == 0.0).count();
                                let slip = (0..nodes)
                                    .filter(|&i| {
                                        l[2 * i] > 0.0
                                            && l[2 * i + 1].abs() >= mu * l[2 * i] * (1.0 - 1e-12)
                                    })
                                    .count();
                                println!(
                                    "mu {mu} curv {curvature} slide {slide} float {floating}: {} steps open {open} slip {slip} time {time:.2} {:?} {:?} {log}",
                                    outcome.iterations, outcome.fixed_point, outcome.remarks
                                );
                            }
                            Err(error) => println!(
                                "mu {mu} curv {curvature} slide {slide} float {floating}: {error} {log}"
                            ),
                        }
                    }
                }
            }
        }
    }
}
