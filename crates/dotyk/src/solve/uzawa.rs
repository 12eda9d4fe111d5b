//! The p,A-algorithm: Uzawa's iteration with a fixed step, the floating bodies held by bolts.
//!
//! One bolt A per rigid mode. Its force is not held to λ_A ≥ 0; it is whatever the balance asks for, and the rigid shift
//! is such that the gap at A closes:
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

/// A bolt of whose column less than this part is left beside the bolts before holds nothing more: half the digits.
const HELD: f64 = 1e-8;

/// Accuracy of the bilateral solution where F is applied: it only tells where contacts press hardest.
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
            let mut steps = Steps::new(self, setup, &bolted, multipliers.lambda);
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
struct Steps<'a> {
    setup: &'a Setup<'a>,
    bolted: &'a Bolted,
    step: FixedStep,
    /// What λ is held to: the bolts are free.
    components: Vec<Component>,
    /// The iterate and the one before.
    at: Forces,
    then: Forces,
    parts: Vec<f64>,
}

impl<'a> Steps<'a> {
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

    /// The forces that are admissible and in balance: all others to their bounds, those of the bolts as the balance asks.
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

impl Iteration for Steps<'_> {
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
    /// Contact unknowns, and which they are of all (m,).
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

/// Bolts where the solution with all contacts closed presses hardest; `None` where it presses nowhere.
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
