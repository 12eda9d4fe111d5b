//! The p,A-algorithm: Uzawa's iteration with a fixed step, the floating bodies held by bolts.
//!
//! One bolt A per rigid mode. Its force is not constrained to λ_A ≥ 0 but follows from the balance, and the rigid shift closes
//! the gap at A:
//!
//! ```text
//!   STEP 1: gap = Fλ − d − Gᵀα with α such that gap_A = 0
//!   STEP 2: λᵢ ← max(0, λᵢ − ρ gapᵢ), i ≠ A;   λ_A from Gλ = e
//! ```
//!
//! This is projected gradient with fixed step on the problem without λ_A, whose matrix is S_A = ZᵀFZ; it converges for
//! 0 < ρ < 2/λ_max(S_A). Its limit is the solution if and only if λ_A ≥ 0 there: the bolt is *proper*. The limit with an
//! improper bolt has tension at A and is wrong, so the sign is always tested: an improper bolt is moved to the node with
//! the largest λᵢ‖Gᵢ‖, at most three times, and then the exact projection takes over and says so.
//!
//! Friction with given bounds: tangential forces are projected onto them in STEP 2; bolts are normal forces.
//!
//! ρ: 1.9/L, with L an upper bound of λ_max(S_A) by Lanczos steps. Bolts: largest λᵢ‖Gᵢ‖ of the bilateral solution.
//!
//! Source: Janovský & Procházka, Contact problem of two elastic bodies III, Apl. mat. 25 (1980) 137–146, section 7
//! for the two steps; step length and choice of bolts are ours.

use crate::dual::{Component, Multipliers};
use crate::linalg::Mat;
use crate::linalg::dense::Lu;
use crate::solve::iteration::{FixedStep, Iteration, completed, counting_from, iterate};
use crate::solve::setup::{Forces, Position, Setup};
use crate::solve::states::Unknown;
use crate::solve::system::System;
use crate::solve::{
    Bolt, FixedBounds, Gradient, Observer, Outcome, SolveError, TOLERANCE, dot, norm, spectrum,
};

/// How often an improper bolt is moved before the exact projection takes over.
const MOVES: usize = 3;

/// A node holds no further mode if less than this part of its column is independent of the bolts before: half the digits.
const HELD: f64 = 1e-8;

/// Accuracy of the bilateral solution where F is applied: it only shows where contacts press hardest.
const BILATERAL: f64 = 1e-3;

/// The p,A-algorithm.
#[derive(Debug, Clone, PartialEq)]
pub struct Uzawa {
    /// Contact unknowns that hold the bolts, one per rigid mode; `None`: chosen from the bilateral solution.
    pub bolts: Option<Vec<usize>>,
    /// ρ in forces, unscaled (force / length); `None`: 1.9/L.
    pub rho: Option<f64>,
    /// Residual at which it stops.
    pub tolerance: f64,
    /// Most iterations.
    pub max_iterations: usize,
    /// Move an improper bolt; otherwise it is an error.
    pub move_improper: bool,
}

impl Default for Uzawa {
    fn default() -> Self {
        Self {
            bolts: None,
            rho: None,
            tolerance: TOLERANCE,
            max_iterations: 200_000,
            move_improper: true,
        }
    }
}

impl FixedBounds for Uzawa {
    const NAME: &'static str = "uzawa";

    fn limits_mut(&mut self) -> (&mut f64, &mut usize) {
        (&mut self.tolerance, &mut self.max_iterations)
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        FixedStep::check(self.rho)?;
        let mut outcome = setup.outcome(&Forces {
            lambda: setup.start(guess)?,
            ..Forces::none(setup)
        });
        let chosen = match &self.bolts {
            Some(named) => Some(named_bolts(setup, named)?),
            None => bolts_of_bilateral_solution(setup),
        };
        let Some(mut bolted) = chosen else {
            let why = match setup.components.contains(&Component::Tangent) {
                true => {
                    "the normal forces that press when all contacts are closed do not hold every motion, \
                     so there is no place for a bolt"
                }
                false => {
                    "no contact is pressed when all are closed, so there is no place for a bolt"
                }
            };
            return self.project_exactly(setup, outcome, observe, why);
        };
        for moves in 0..=MOVES {
            let Outcome {
                multipliers,
                iterations,
                bolts,
                ..
            } = outcome;
            let mut steps = BoltedSteps::new(self, setup, &bolted, multipliers.lambda);
            let result = iterate(self, setup, &mut steps, iterations, observe);
            outcome = completed(Self::NAME, result, |outcome| Outcome { bolts, ..outcome })?;
            if outcome.stopped_by_observer {
                return Ok(outcome);
            }
            let lambda = &outcome.multipliers.lambda;
            let tension = -self.tolerance * setup.largest_force(lambda);
            let improper = |bolt: &Bolt| setup.bounded(bolt.index) && bolt.force < tension;
            let mut bolts = bolted.forces(lambda);
            let Some(first) = bolts.iter().copied().find(improper) else {
                outcome.bolts.append(&mut bolts);
                return Ok(outcome);
            };
            if !self.move_improper {
                return Err(SolveError::ImproperBolt {
                    bolt: first,
                    outcome: Box::new(outcome),
                });
            }
            let next = choose(setup, &pressed(setup, lambda));
            let moved = bolts.into_iter().filter(improper);
            let moved = moved.map(|bolt| Bolt {
                moved: true,
                ..bolt
            });
            outcome.bolts.extend(moved);
            match next {
                Some(next) if moves < MOVES && next.nodes != bolted.nodes => bolted = next,
                _ => break,
            }
        }
        let why = "every bolt that was tried ended in tension";
        self.project_exactly(setup, outcome, observe, why)
    }
}

impl Uzawa {
    /// Projected gradient with the exact projection, from the forces reached so far.
    fn project_exactly(
        &self,
        setup: &Setup<'_>,
        reached: Outcome,
        observe: Observer<'_>,
        why: &str,
    ) -> Result<Outcome, SolveError> {
        let done = reached.iterations;
        let exact = Gradient {
            rho: None,
            tolerance: self.tolerance,
            max_iterations: self.max_iterations.saturating_sub(done),
        };
        let mut after = counting_from(done, observe);
        let result = exact.run(setup, Some(&reached.multipliers), &mut after);
        completed(Self::NAME, result, |outcome| Outcome {
            iterations: done + outcome.iterations,
            bolts: reached.bolts,
            remarks: vec![format!(
                "{why}: solved with the exact projection instead of bolts"
            )],
            ..outcome
        })
    }
}

/// The iterate with some bolts.
struct BoltedSteps<'a> {
    setup: &'a Setup<'a>,
    bolted: &'a Bolted,
    step: FixedStep,
    /// Constraints on λ: the bolts are free.
    components: Vec<Component>,
    /// The iterate and the one before.
    at: Forces,
    then: Forces,
    parts: Vec<f64>,
}

impl<'a> BoltedSteps<'a> {
    /// Begins with the forces nearest to `lambda` but for the bolts.
    fn new(method: &Uzawa, setup: &'a Setup<'a>, bolted: &'a Bolted, lambda: Vec<f64>) -> Self {
        let mut components = setup.components.clone();
        for &node in &bolted.nodes {
            components[node] = Component::Free;
        }
        let mut steps = Self {
            setup,
            bolted,
            step: FixedStep::new(method.rho, || reduced_bound(setup, bolted)),
            components,
            at: Forces {
                lambda,
                ..Forces::none(setup)
            },
            then: Forces::none(setup),
            parts: vec![0.0; setup.modes()],
        };
        steps.project();
        steps.then.lambda.clone_from(&steps.at.lambda);
        steps
    }

    /// Admissible, balanced forces: those of the bolts follow from the balance, all others are projected.
    fn project(&mut self) {
        for (force, component) in self.at.lambda.iter_mut().zip(&self.components) {
            if *component == Component::Normal {
                *force = force.max(0.0);
            }
        }
        self.setup.admissible.bound_tangents(&mut self.at.lambda);
        self.bolted
            .close(self.setup, &mut self.at.lambda, &mut self.parts);
    }
}

impl Iteration for BoltedSteps<'_> {
    /// STEP 1: the gaps of the forces, with the rigid shift that closes those of the bolts.
    fn evaluate(&mut self) {
        let (setup, bolted, at) = (self.setup, self.bolted, &mut self.at);
        setup.multiply(&at.lambda, &mut at.product);
        self.step.adapt(at, &self.then, |i| !bolted.held[i]);
        let overlap = |node: usize| at.product[node] - setup.shift[node];
        bolted.shift(overlap, &mut at.alpha);
    }

    /// STEP 2: λᵢ ← max(0, λᵢ − ρ gapᵢ), and λ_A from the balance.
    fn advance(&mut self, gap: &[f64]) -> usize {
        std::mem::swap(&mut self.at, &mut self.then);
        for (i, force) in self.at.lambda.iter_mut().enumerate() {
            *force = self.then.lambda[i] - self.step.rho * gap[i];
        }
        self.project();
        1
    }

    fn point(&self) -> Position<'_> {
        Position {
            components: &self.components,
            ..self.at.at(self.setup, 'u')
        }
    }

    fn rho(&self) -> Option<f64> {
        Some(self.step.rho)
    }

    fn advice(&self) -> String {
        self.step.advice(|| reduced_bound(self.setup, self.bolted))
    }
}

/// Bolts that hold the k controlled modes.
struct Bolted {
    /// Contact unknowns, and flags of them among all (m,).
    nodes: Vec<usize>,
    held: Vec<bool>,
    /// Rigid mode each was chosen for.
    modes: Vec<usize>,
    /// Ĝ_A⁻¹, (k, k).
    inverse: Mat<f64>,
}

impl Bolted {
    fn new(setup: &Setup<'_>, nodes: Vec<usize>) -> Option<Self> {
        let k = setup.modes();
        let columns: Vec<Vec<f64>> = nodes.iter().map(|&i| setup.balance.column(i)).collect();
        let matrix = Mat::from_fn(k, k, |i, j| columns[j][i]);
        let mut inverse = Mat::identity(k, k);
        Lu::new(matrix).ok()?.solve_in_place(&mut inverse);
        let mut modes: Vec<usize> = Vec::new();
        for &node in &nodes {
            let column = setup.problem.balance.modes().column(node).to_dense();
            let best = (0..column.len())
                .filter(|mode| !modes.contains(mode))
                .max_by(|&a, &b| column[a].abs().total_cmp(&column[b].abs()).then(b.cmp(&a)));
            modes.push(best.unwrap_or(0));
        }
        let mut held = vec![false; setup.len()];
        nodes.iter().for_each(|&node| held[node] = true);
        Some(Self {
            nodes,
            held,
            modes,
            inverse,
        })
    }

    /// The bolts with their forces.
    fn forces(&self, lambda: &[f64]) -> Vec<Bolt> {
        let bolt = |(&index, &mode): (&usize, &usize)| Bolt {
            index,
            mode,
            force: lambda[index],
            moved: false,
        };
        self.nodes.iter().zip(&self.modes).map(bolt).collect()
    }

    /// λ_A from the balance of the others. `parts` is workspace (k,).
    fn close(&self, setup: &Setup<'_>, lambda: &mut [f64], parts: &mut [f64]) {
        for &node in &self.nodes {
            lambda[node] = 0.0;
        }
        setup.balance.imbalance(lambda, parts);
        for (row, &node) in self.nodes.iter().enumerate() {
            lambda[node] = -(0..parts.len())
                .map(|j| self.inverse[(row, j)] * parts[j])
                .sum::<f64>();
        }
    }

    /// α̂ for which `overlap` − Ĝᵀα̂ vanishes at the bolts.
    fn shift(&self, overlap: impl Fn(usize) -> f64, alpha: &mut [f64]) {
        for (j, alpha) in alpha.iter_mut().enumerate() {
            *alpha = self
                .nodes
                .iter()
                .enumerate()
                .map(|(row, &node)| self.inverse[(row, j)] * overlap(node))
                .sum();
        }
    }
}

/// Forces that press, 0 for the others: no bolt is put on a tangential force.
fn pressed(setup: &Setup<'_>, lambda: &[f64]) -> Vec<f64> {
    let press = |(component, force): (&Component, &f64)| match component {
        Component::Tangent => 0.0,
        Component::Free | Component::Normal => force.max(0.0),
    };
    setup.components.iter().zip(lambda).map(press).collect()
}

/// Greedy choice: largest λᵢ times the part of column Ĝᵢ that the bolts before do not hold.
fn choose(setup: &Setup<'_>, weights: &[f64]) -> Option<Bolted> {
    let k = setup.modes();
    let mut columns: Vec<Vec<f64>> = (0..setup.len()).map(|i| setup.balance.column(i)).collect();
    let sizes: Vec<f64> = columns.iter().map(|column| norm(column)).collect();
    let mut nodes = Vec::with_capacity(k);
    for _ in 0..k {
        let merit = |i: usize| weights[i] * norm(&columns[i]);
        let best = (0..columns.len())
            .filter(|&i| norm(&columns[i]) > HELD * sizes[i] && merit(i) > 0.0)
            .max_by(|&a, &b| merit(a).total_cmp(&merit(b)).then(b.cmp(&a)))?;
        let length = norm(&columns[best]);
        let held: Vec<f64> = columns[best].iter().map(|x| x / length).collect();
        for column in &mut columns {
            let part = dot(&held, column);
            for (x, held) in column.iter_mut().zip(&held) {
                *x -= part * held;
            }
        }
        nodes.push(best);
    }
    Bolted::new(setup, nodes)
}

/// The user's bolts; where some modes cannot be controlled, as many of them as are needed.
fn named_bolts(setup: &Setup<'_>, named: &[usize]) -> Result<Bolted, SolveError> {
    let dependent = || SolveError::DependentBolts {
        bolts: named.to_vec(),
        modes: setup.modes(),
    };
    if let Some(node) = named.iter().find(|&&node| node >= setup.len()) {
        return Err(SolveError::Invalid(format!(
            "bolt at contact unknown {node}, but there are only {}",
            setup.len()
        )));
    }
    if named.len() == setup.modes() {
        return Bolted::new(setup, named.to_vec()).ok_or_else(dependent);
    }
    if named.len() != setup.balance.load().len() {
        return Err(dependent());
    }
    let mut weights = vec![0.0; setup.len()];
    for &node in named {
        weights[node] = 1.0;
    }
    choose(setup, &weights).ok_or_else(dependent)
}

/// Bolts at the largest pressures of the solution with all contacts closed; `None` where it presses nowhere.
fn bolts_of_bilateral_solution(setup: &Setup<'_>) -> Option<Bolted> {
    if setup.modes() == 0 {
        return Bolted::new(setup, Vec::new());
    }
    let all = (0..setup.len()).map(Unknown::of).collect();
    let closed =
        System::new(setup, all, vec![0.0; setup.len()]).solve(&Forces::none(setup), BILATERAL)?;
    choose(setup, &pressed(setup, &closed.lambda))
}

/// Upper bound of λ_max(S_A), S_A = ZᵀFZ; see [`Setup::usable_bound`] for the zero operator.
fn reduced_bound(setup: &Setup<'_>, bolted: &Bolted) -> f64 {
    let (m, k) = (setup.len(), setup.modes());
    let others: Vec<usize> = (0..m).filter(|&i| !bolted.held[i]).collect();
    let (mut inside, mut image) = (vec![0.0; m], vec![0.0; m]);
    let (mut parts, mut forces) = (vec![0.0; k], vec![0.0; k]);
    let bound = spectrum::largest_eigenvalue(others.len(), spectrum::STEPS, |x, y| {
        inside.fill(0.0);
        for (x, &i) in x.iter().zip(&others) {
            inside[i] = *x;
        }
        setup.balance.apply(&inside, &mut parts);
        for (row, force) in forces.iter_mut().enumerate() {
            *force = -(0..k)
                .map(|j| bolted.inverse[(row, j)] * parts[j])
                .sum::<f64>();
        }
        for (force, &node) in forces.iter().zip(&bolted.nodes) {
            inside[node] = *force;
        }
        setup.multiply(&inside, &mut image);
        bolted.shift(|node| image[node], &mut parts);
        setup.balance.add_transposed(-1.0, &parts, &mut image);
        for (y, &i) in y.iter_mut().zip(&others) {
            *y = image[i];
        }
    });
    setup.usable_bound(bound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance, DualProblem, Friction};
    use crate::solve::ContactSolver;
    use crate::solve::tests::{apart, by_trial, definite, of, silent, times};

    fn modes() -> [Vec<f64>; 2] {
        [vec![1.0; 5], vec![-1.0, -0.5, 0.0, 0.5, 1.0]]
    }

    const SHIFT: [f64; 5] = [1.0, 0.3, -0.5, 0.8, 0.1];

    fn plate() -> DualProblem {
        let blocks = vec![Block::Unilateral; 5];
        of(
            Compliance::Dense(definite(5)),
            &SHIFT,
            blocks,
            (&modes(), &[4.0, 0.5]),
        )
    }

    #[test]
    fn bolts_take_what_the_balance_asks_for_and_close_their_gaps() {
        let problem = plate();
        let setup = Setup::new(&problem).unwrap();
        let bolted = Bolted::new(&setup, vec![4, 1]).unwrap();
        assert_eq!(bolted.held, [false, true, false, false, true]);
        let mut lambda = vec![1.0, 9.0, 0.5, 0.25, -3.0];
        bolted.close(&setup, &mut lambda, &mut [0.0; 2]);
        // a + b + 1.75 = 4 and −a/2 + b − 1 + 1/8 = 1/2 of the forces a at 1 and b at 4
        let (a, b) = ((2.25 - 1.375) / 1.5, (2.25 / 2.0 + 1.375) / 1.5);
        assert!(apart(&lambda, &[1.0, a, 0.5, 0.25, b]) < 1e-14);
        let mut alpha = vec![0.0; 2];
        let product = times(&definite(5), &lambda);
        bolted.shift(|i| product[i] - SHIFT[i], &mut alpha);
        let told = setup.multipliers(&lambda, &alpha);
        let gap = problem.gap(&told);
        assert!(gap[1].abs() < 1e-14 && gap[4].abs() < 1e-14 && gap[0].abs() > 1e-3);
        let bolts = bolted.forces(&lambda);
        let plain = |bolt: &Bolt| (bolt.index, bolt.force, bolt.moved);
        assert_eq!(plain(&bolts[0]), (4, lambda[4], false));
        assert_eq!(plain(&bolts[1]), (1, lambda[1], false));
        // the first of two modes that move it alike, then the other
        assert_eq!((bolts[0].mode, bolts[1].mode), (0, 1));
        assert!(Bolted::new(&setup, vec![2, 2]).is_none());
    }

    #[test]
    fn bolts_are_named_for_the_modes_that_move_them_most() {
        let modes = [vec![0.5, 1.0, 0.1], vec![1.0, -0.9, 0.2]];
        let blocks = vec![Block::Unilateral; 3];
        let problem = of(
            Compliance::Dense(definite(3)),
            &[1.0; 3],
            blocks,
            (&modes, &[1.0, 0.1]),
        );
        let setup = Setup::new(&problem).unwrap();
        assert_eq!(Bolted::new(&setup, vec![1, 0]).unwrap().modes, [0, 1]);
        assert_eq!(Bolted::new(&setup, vec![0, 1]).unwrap().modes, [1, 0]);
        assert_eq!(Bolted::new(&setup, vec![2, 1]).unwrap().modes, [1, 0]);
    }

    #[test]
    fn bound_of_the_step_is_the_largest_eigenvalue_without_the_bolts() {
        let problem = plate();
        let setup = Setup::new(&problem).unwrap();
        let bolted = Bolted::new(&setup, vec![1, 4]).unwrap();
        // columns of Z: a unit force at 0, 2 or 3 and the bolts that balance it
        let column = |i: usize| {
            let x = modes()[1][i];
            let mut z = vec![0.0; 5];
            z[i] = 1.0;
            (z[1], z[4]) = ((x - 1.0) / 1.5, (-0.5 - x) / 1.5);
            z
        };
        let z: Vec<Vec<f64>> = [0, 2, 3].map(column).to_vec();
        assert!(
            z.iter()
                .all(|z| modes().iter().all(|g| dot(g, z).abs() < 1e-14))
        );
        let f = definite(5);
        let s = Mat::from_fn(3, 3, |i, j| dot(&z[i], &times(&f, &z[j])));
        // powers of S on any vector
        let mut v = vec![1.0, 0.7, -0.4];
        let mut value = 0.0;
        for _ in 0..2000 {
            v = times(&s, &v);
            value = norm(&v);
            v.iter_mut().for_each(|x| *x /= value);
        }
        assert!((reduced_bound(&setup, &bolted) - value).abs() < 1e-10 * value);
        let method = Uzawa {
            bolts: Some(vec![1, 4]),
            ..Uzawa::default()
        };
        let outcome = method.solve(&problem, None, &mut silent).unwrap();
        assert!((outcome.rho.unwrap() * value - 1.9).abs() < 1e-9);
    }

    #[test]
    fn bolts_stand_where_forces_press_hardest_on_what_is_not_yet_held() {
        let problem = plate();
        let setup = Setup::new(&problem).unwrap();
        // lever arms in orthonormal modes: 1/√5 and x/√2.5
        let first = |weights: [f64; 5]| choose(&setup, &weights).map(|bolted| bolted.nodes);
        // at ±1 a force counts √0.6, in the middle √0.2
        assert_eq!(first([1.0, 1.0, 1.7, 0.0, 0.0]), Some(vec![0, 2]));
        assert_eq!(first([1.0, 1.0, 1.8, 0.0, 0.0]), Some(vec![2, 0]));
        // the same merit: the first one; less of the other end's column remains than of the middle's
        assert_eq!(
            first([1.0, 0.0, 0.1, 0.0, 1.0]).map(|nodes| nodes[0]),
            Some(0)
        );
        assert_eq!(first([0.0, 0.0, 1.0, 0.0, 0.0]), None);
        assert_eq!(first([0.0; 5]), None);
        let tangents = of(
            Compliance::Dense(definite(4)),
            &[1.0; 4],
            vec![
                Friction::Tresca { bound: 1.0 }.block(1),
                Block::Free { size: 2 },
            ],
            (&[], &[]),
        );
        let setup = Setup::new(&tangents).unwrap();
        assert_eq!(
            pressed(&setup, &[2.0, 3.0, 4.0, -1.0]),
            [2.0, 0.0, 4.0, 0.0]
        );
        assert_eq!(
            pressed(&setup, &[-2.0, -3.0, 0.0, 1.0]),
            [0.0, 0.0, 0.0, 1.0]
        );
    }

    #[test]
    fn named_bolts_are_as_many_as_the_modes_or_as_those_that_can_be_held() {
        let problem = plate();
        let setup = Setup::new(&problem).unwrap();
        let nodes = |named: &[usize]| named_bolts(&setup, named).map(|bolted| bolted.nodes);
        assert_eq!(nodes(&[3, 0]).unwrap(), [3, 0]);
        for wrong in [&[3][..], &[], &[0, 1, 2]] {
            let Err(SolveError::DependentBolts { bolts, modes: 2 }) = nodes(wrong) else {
                panic!("{wrong:?} do not hold two modes");
            };
            assert_eq!(bolts, wrong);
        }
        assert!(nodes(&[4, 0]).is_ok());
        let error = nodes(&[0, 5]).unwrap_err().to_string();
        assert_eq!(error, "bolt at contact unknown 5, but there are only 5");
        // three modes of which contact controls two: as many bolts as modes, of which two are taken
        let mut three = modes().to_vec();
        three.push(modes()[0].iter().map(|x| 2.0 * x).collect());
        let blocks = vec![Block::Unilateral; 5];
        let load = [4.0, 0.5, 8.0];
        let problem = of(
            Compliance::Dense(definite(5)),
            &SHIFT,
            blocks,
            (&three, &load),
        );
        let setup = Setup::new(&problem).unwrap();
        let nodes = |named: &[usize]| named_bolts(&setup, named).map(|bolted| bolted.nodes);
        let mut ends = nodes(&[0, 2, 4]).unwrap();
        ends.sort_unstable();
        assert_eq!(ends, [0, 4]);
        assert!(nodes(&[1]).is_err());
    }

    #[test]
    fn where_there_is_no_place_for_a_bolt_the_projection_takes_over_and_says_why() {
        // a tie that is drawn
        let tie = vec![Block::Free { size: 1 }];
        let modes = [vec![1.0]];
        let problem = of(
            Compliance::Dense(definite(1)),
            &[1.0],
            tie,
            (&modes, &[-2.0]),
        );
        let outcome = Uzawa::default().solve(&problem, None, &mut silent).unwrap();
        let expected = "no contact is pressed when all are closed, so there is no place for a bolt: \
                        solved with the exact projection instead of bolts";
        assert_eq!(outcome.remarks, [expected]);
        assert!(outcome.bolts.is_empty());
        // a load aside that friction alone bears
        let block = Friction::Tresca { bound: 2.0 }.block(1);
        let modes = [vec![0.0, 1.0, 0.0, 1.0]];
        let f = Compliance::Dense(definite(4));
        let problem = of(f, &[1.0, 0.0, 1.0, 0.0], vec![block; 2], (&modes, &[1.0]));
        let outcome = Uzawa::default().solve(&problem, None, &mut silent).unwrap();
        assert!(
            outcome.remarks[0].starts_with("the normal forces that press"),
            "{:?}",
            outcome.remarks
        );
        assert!(problem.certify(&outcome.multipliers, 1e-7).holds());
    }

    #[test]
    fn automatic_bolts_are_proper_and_told_with_their_forces() {
        let problem = plate();
        let outcome = Uzawa::default().solve(&problem, None, &mut silent).unwrap();
        let expected = by_trial(&definite(5), &SHIFT, (&modes(), &[4.0, 0.5]));
        let lambda = &outcome.multipliers.lambda;
        assert!(apart(lambda, &expected.lambda) < 1e-6);
        assert_eq!(outcome.bolts.len(), 2);
        for bolt in &outcome.bolts {
            assert!(!bolt.moved && bolt.force == lambda[bolt.index] && bolt.force > 0.0);
        }
        assert!(outcome.remarks.is_empty());
    }
}
