//! Cohesion: closed nodes bear shear up to cohesion + coefficient · λₙ, open ones none. Judged by all states of small problems.
//!
//! The judge shares no code with the solvers: for every choice of open, stick and slip either way of one or two nodes it solves
//! the linear system of gaps and balance, and keeps what satisfies the law. Signs as in `friction.rs`: the tangential gap is
//! minus the slip. Units: none.

use std::ops::ControlFlow;

use crate::friction::Random;
use dotyk::dual::{AdmissibleSet, Balance, Compliance, DualProblem, Friction, Multipliers};
use dotyk::linalg::Mat;
use dotyk::model::Law;
use dotyk::prelude::*;
use dotyk::solve::{Accelerated, ContactSolver, Iterate, Mprgp, Newton, SolveError};

fn silent(_: &Iterate<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The data of a problem of nodes with one tangent, and of at most one rigid mode.
#[derive(Clone)]
struct Small {
    compliance: Vec<Vec<f64>>,
    shift: Vec<f64>,
    /// Rows of G and e.
    balance: Vec<(Vec<f64>, f64)>,
    /// (cohesion, coefficient) of each node.
    laws: Vec<(f64, f64)>,
}

/// What a node does; the sign is that of its shear.
#[derive(Clone, Copy)]
enum State {
    Open,
    Stick,
    Slip(f64),
}

const STATES: [State; 4] = [
    State::Open,
    State::Stick,
    State::Slip(1.0),
    State::Slip(-1.0),
];

impl Small {
    fn random(random: &mut Random) -> Self {
        let nodes = 1 + usize::from(random.unit() < 0.7);
        let m = 2 * nodes;
        let a: Vec<Vec<f64>> = (0..m)
            .map(|_| (0..m).map(|_| random.signed()).collect())
            .collect();
        let entry = |i: usize, j: usize| -> f64 {
            let product: f64 = (0..m).map(|l| a[i][l] * a[j][l]).sum();
            product + if i == j { 0.2 } else { 0.0 }
        };
        let compliance = (0..m)
            .map(|i| (0..m).map(|j| entry(i, j)).collect())
            .collect();
        let laws: Vec<(f64, f64)> = (0..nodes)
            .map(|_| {
                let coefficient = if random.unit() < 0.3 {
                    0.0
                } else {
                    random.unit()
                };
                (0.05 + random.unit(), coefficient)
            })
            .collect();
        let mut balance = Vec::new();
        if random.unit() < 0.4 {
            // a load that some closed nodes bear
            let mode: Vec<f64> = (0..m).map(|_| random.signed()).collect();
            let mut load = 0.0;
            for (node, (cohesion, coefficient)) in laws.iter().enumerate() {
                let normal = random.unit();
                let shear = 0.8 * random.signed() * (cohesion + coefficient * normal);
                load += mode[2 * node] * normal + mode[2 * node + 1] * shear;
            }
            balance.push((mode, load));
        }
        Self {
            compliance,
            shift: (0..m).map(|_| 2.0 * random.signed() + 0.4).collect(),
            balance,
            laws,
        }
    }

    fn problem(&self) -> DualProblem {
        let m = self.shift.len();
        let modes = Mat::from_fn(self.balance.len(), m, |r, i| self.balance[r].0[i]);
        let load = self.balance.iter().map(|(_, load)| *load).collect();
        let block = |&(cohesion, coefficient): &(f64, f64)| {
            let law = Friction::Cohesive {
                cohesion,
                coefficient,
            };
            law.block(1)
        };
        DualProblem::new(
            Compliance::Dense(Mat::from_fn(m, m, |i, j| self.compliance[i][j])),
            self.shift.clone(),
            AdmissibleSet::new(self.laws.iter().map(block).collect()),
            Balance::new(modes, load),
        )
        .unwrap()
    }

    /// λ and α that follow from the states of the nodes; `None` where these do not determine them.
    fn forces(&self, states: &[State]) -> Option<Vec<f64>> {
        let (m, r) = (self.shift.len(), self.balance.len());
        let mut rows = Vec::new();
        // the gap of a component, and minus what is known of it
        let gap = |i: usize| {
            let mut row = self.compliance[i].clone();
            row.extend(self.balance.iter().map(|(mode, _)| -mode[i]));
            row.push(self.shift[i]);
            row
        };
        let force = |terms: &[(usize, f64)], known: f64| {
            let mut row = vec![0.0; m + r + 1];
            terms.iter().for_each(|&(i, weight)| row[i] = weight);
            row[m + r] = known;
            row
        };
        for (node, state) in states.iter().enumerate() {
            let (n, t) = (2 * node, 2 * node + 1);
            let (cohesion, coefficient) = self.laws[node];
            match state {
                State::Open => rows.extend([force(&[(n, 1.0)], 0.0), force(&[(t, 1.0)], 0.0)]),
                State::Stick => rows.extend([gap(n), gap(t)]),
                State::Slip(s) => {
                    rows.push(gap(n));
                    rows.push(force(&[(t, 1.0), (n, -s * coefficient)], s * cohesion));
                }
            }
        }
        for (mode, load) in &self.balance {
            let terms: Vec<(usize, f64)> = mode.iter().copied().enumerate().collect();
            rows.push(force(&terms, *load));
        }
        solve(rows)
    }

    /// By how much λ and α miss the law and the balance.
    fn violation(&self, lambda: &[f64], alpha: &[f64]) -> f64 {
        let mut worst: f64 = 0.0;
        for (node, (cohesion, coefficient)) in self.laws.iter().enumerate() {
            let [n, t] = [2 * node, 2 * node + 1].map(|i| {
                let image: f64 = (0..lambda.len())
                    .map(|j| self.compliance[i][j] * lambda[j])
                    .sum();
                let rigid = self
                    .balance
                    .iter()
                    .zip(alpha)
                    .map(|((mode, _), a)| mode[i] * a);
                image - self.shift[i] - rigid.sum::<f64>()
            });
            let (normal, shear) = (lambda[2 * node], lambda[2 * node + 1]);
            let bound = match normal > 1e-7 {
                true => cohesion + coefficient * normal,
                false => 0.0,
            };
            let (open, slip) = (n.abs().min(normal.abs()), -t);
            // a shear below its bound goes with no slip, one at it with slip along it
            let sticks = if shear.abs() < bound - 1e-7 {
                slip.abs()
            } else {
                0.0
            };
            let against = (bound * slip.abs() - shear * slip).min(slip.abs());
            for value in [-n, -normal, open, shear.abs() - bound, sticks, against] {
                worst = worst.max(value);
            }
        }
        for (mode, load) in &self.balance {
            let carried: f64 = mode.iter().zip(lambda).map(|(g, l)| g * l).sum();
            worst = worst.max((carried - load).abs());
        }
        worst
    }

    /// Every λ that satisfies the law, by the states of the nodes.
    fn solutions(&self) -> Vec<Vec<f64>> {
        let m = self.shift.len();
        let choices = STATES.len().pow(self.laws.len() as u32);
        let of = |choice: usize| {
            let node = |node: usize| STATES[choice / STATES.len().pow(node as u32) % STATES.len()];
            let states: Vec<State> = (0..self.laws.len()).map(node).collect();
            let forces = self.forces(&states)?;
            let (lambda, alpha) = forces.split_at(m);
            (self.violation(lambda, alpha) < 1e-9).then(|| lambda.to_vec())
        };
        (0..choices).filter_map(of).collect()
    }
}

/// Gaussian elimination with row pivots of rows that end with their right side.
fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k].abs() < 1e-9 {
            return None;
        }
        let above = rows[k].clone();
        for row in &mut rows[k + 1..] {
            let factor = row[k] / above[k];
            row.iter_mut()
                .zip(&above)
                .for_each(|(x, a)| *x -= factor * a);
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * x[j]).sum();
        x[k] = (rows[k][n] - known) / rows[k][k];
    }
    Some(x)
}

const TOLERANCE: f64 = 1e-10;

fn newton() -> Newton {
    Newton {
        tolerance: TOLERANCE,
        ..Newton::default()
    }
}

/// Newton, and two methods that reach the law as a fixed point of given bounds.
fn solvers() -> [Box<dyn ContactSolver>; 3] {
    [
        Box::new(newton()),
        Box::new(Mprgp {
            tolerance: TOLERANCE,
            ..Mprgp::default()
        }),
        Box::new(Accelerated {
            tolerance: TOLERANCE,
            ..Accelerated::default()
        }),
    ]
}

/// The certified answer of a solver, which satisfies the law; `None` where it does not converge.
fn answer(solver: &dyn ContactSolver, small: &Small, what: &str) -> Option<Multipliers> {
    let problem = small.problem();
    match solver.solve(&problem, None, &mut silent) {
        Ok(outcome) => {
            let Multipliers { lambda, alpha } = &outcome.multipliers;
            let certificate = problem.certify(&outcome.multipliers, 1e-9);
            assert!(certificate.holds(), "{what}\n{certificate}");
            let violation = small.violation(lambda, alpha);
            assert!(violation < 1e-6, "{what}: {violation:e} at {lambda:?}");
            Some(outcome.multipliers)
        }
        Err(SolveError::NotConverged { .. }) => None,
        Err(SolveError::Infeasible { .. }) => {
            assert_eq!(small.solutions(), Vec::<Vec<f64>>::new(), "{what}");
            None
        }
        Err(error) => panic!("{what}: {error}"),
    }
}

#[test]
fn certified_answers_are_among_those_of_all_states_and_are_found_where_there_are_any() {
    let (mut solvable, mut found, mut open) = (0, [0; 3], 0);
    for seed in 0..3000 {
        let small = Small::random(&mut Random(seed));
        let solutions = small.solutions();
        solvable += usize::from(!solutions.is_empty());
        // methods that go round bounds take long where these do not settle
        let few = if seed % 20 == 0 { 3 } else { 1 };
        for (solver, found) in solvers().iter().zip(&mut found).take(few) {
            let what = format!("{}, seed {seed}", solver.name());
            let Some(answer) = answer(solver.as_ref(), &small, &what) else {
                continue;
            };
            let away = |solution: &Vec<f64>| -> f64 {
                let apart = solution
                    .iter()
                    .zip(&answer.lambda)
                    .map(|(a, b)| (a - b).abs());
                apart.fold(0.0, f64::max)
            };
            let nearest = solutions.iter().map(away).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-6, "{what}: {nearest:e} from {solutions:?}");
            *found += 1;
            open += usize::from(answer.lambda.chunks(2).any(|node| node[0] == 0.0));
        }
    }
    assert!(solvable > 2500 && open > 1000, "{solvable}, {open}");
    assert!(
        found[0] as f64 > 0.99 * solvable as f64,
        "{found:?} of {solvable}"
    );
    assert!(found[1].min(found[2]) > 120, "{found:?}");
}

/// Where a component stands in a twin, and with which sign.
type Place<'a> = &'a dyn Fn(usize) -> (usize, f64);

#[test]
fn other_units_and_other_axes_give_the_same_answer() {
    let mut compared = 0;
    for seed in 0..200 {
        let small = Small::random(&mut Random(seed));
        let Some(own) = answer(&newton(), &small, &format!("seed {seed}")) else {
            continue;
        };
        if small.solutions().len() != 1 {
            continue;
        }
        // other units; the other tangent; the nodes the other way round
        let (force, length) = (2f64.powi(20), 2f64.powi(-10));
        let mut scaled = small.clone();
        scaled
            .compliance
            .iter_mut()
            .flatten()
            .for_each(|f| *f *= length / force);
        scaled.shift.iter_mut().for_each(|d| *d *= length);
        scaled
            .balance
            .iter_mut()
            .for_each(|(_, load)| *load *= force);
        scaled
            .laws
            .iter_mut()
            .for_each(|(cohesion, _)| *cohesion *= force);
        let m = small.shift.len();
        let permuted = |of: &dyn Fn(usize) -> usize, sign: f64| {
            let s = |i: usize| if i % 2 == 1 { sign } else { 1.0 };
            let row = |i: usize| -> Vec<f64> {
                (0..m)
                    .map(|j| s(i) * s(j) * small.compliance[of(i)][of(j)])
                    .collect()
            };
            let vector = |v: &[f64]| -> Vec<f64> { (0..m).map(|i| s(i) * v[of(i)]).collect() };
            Small {
                compliance: (0..m).map(row).collect(),
                shift: vector(&small.shift),
                balance: small.balance.iter().map(|(g, e)| (vector(g), *e)).collect(),
                laws: (0..m / 2)
                    .map(|node| small.laws[of(2 * node) / 2])
                    .collect(),
            }
        };
        let turned = permuted(&|i| i, -1.0);
        let back = |i: usize| m - 2 - (i - i % 2) + i % 2;
        let reversed = permuted(&back, 1.0);
        let twins: [(Small, f64, Place<'_>); 3] = [
            (scaled, force, &|i| (i, 1.0)),
            (turned, 1.0, &|i| (i, if i % 2 == 1 { -1.0 } else { 1.0 })),
            (reversed, 1.0, &|i| (back(i), 1.0)),
        ];
        for (twin, (other, scale, place)) in twins.iter().enumerate() {
            let what = format!("seed {seed}, twin {twin}");
            let problem = other.problem();
            let Ok(outcome) = newton().solve(&problem, None, &mut silent) else {
                continue;
            };
            for (i, force) in own.lambda.iter().enumerate() {
                let (j, sign) = place(i);
                let apart = (sign * outcome.multipliers.lambda[j] / scale - force).abs();
                assert!(apart < 1e-7, "{what}: {apart:e}");
            }
            compared += 1;
        }
    }
    assert!(compared > 300, "{compared}");
}

/// A block of 4 × 1 pressed by 12000 on another body, pushed by `push`, everything turned by `angle`.
fn pushed(push: f64, angle: f64, swapped: bool) -> Model<2> {
    let (sin, cos) = angle.sin_cos();
    let turn = |[x, y]: Point<2>| [cos * x - sin * y, sin * x + cos * y];
    let mesh = |from: Point<2>, to: Point<2>, cells: [usize; 2]| {
        let mesh = Rectangle {
            from,
            to,
            cells,
            cell: CellKind::Quad4,
            diagonals: Default::default(),
        };
        mesh.build().unwrap().map_points(turn).unwrap()
    };
    let mut model = Model::<2>::new();
    let soft = Elastic {
        young: 2e6,
        poisson: 0.0,
    };
    let block = model.body("block", mesh([0.0, 0.0], [4.0, 1.0], [7, 2]), soft);
    let floor = model.body("floor", mesh([0.0, -1.0], [4.0, 0.0], [5, 2]), soft);
    model.fix(floor, "bottom", [Some(0.0), Some(0.0)]);
    let shear = push / 4.0;
    let loads = [
        (block, "top", [shear, -3000.0]),
        (block, "right", [0.0, shear]),
        (block, "left", [0.0, -shear]),
        (floor, "right", [0.0, shear]),
        (floor, "left", [0.0, -shear]),
    ];
    for (body, side, traction) in loads {
        let traction = turn(traction).map(Field::constant);
        let side = side.to_string();
        model.load(body, Load::Traction { side, traction });
    }
    let (nonmortar, mortar) = match swapped {
        false => ((block, "bottom"), (floor, "top")),
        true => ((floor, "top"), (block, "bottom")),
    };
    model.contact(nonmortar, mortar).law = Law::Cohesive {
        cohesion: Field::constant(500.0),
        coefficient: Field::constant(0.3),
        tension: Field::constant(0.0),
    };
    model
}

#[test]
fn a_block_holds_up_to_cohesion_and_friction_however_it_lies_and_whichever_side_bears_the_forces() {
    // 500 · 4 + 0.3 · 12000
    let limit = 5600.0;
    for angle in [0.0, 0.7, -2.0] {
        for swapped in [false, true] {
            let held = pushed(0.99 * limit, angle, swapped).solve().unwrap();
            for node in &held.contacts[0].nodes {
                assert_eq!(node.status, Status::Stick);
                assert!((node.pressure - 3000.0).abs() < 1e-6);
                let shear = node.shear.iter().map(|s| s * s).sum::<f64>().sqrt();
                assert!((shear - 0.99 * 1400.0).abs() < 1e-6);
            }
            let error = pushed(1.01 * limit, angle, swapped).solve().unwrap_err();
            let text = error.to_string();
            for word in ["\"block\" slides", "0.990099 of the load"] {
                assert!(text.contains(word), "{text}");
            }
        }
    }
}
