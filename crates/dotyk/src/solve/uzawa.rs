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

use std::ops::ControlFlow;

use crate::dual::{Component, DualProblem, Multipliers};
use crate::linalg::Mat;
use crate::linalg::dense::Lu;
use crate::solve::gradient::{check_rho, rho_reason};
use crate::solve::states::Unknown;
use crate::solve::system::{Forces, System};
use crate::solve::{
    Bolt, ContactSolver, FixedBounds, Gradient, Iterate, Judge, Observer, Outcome, Setup,
    SolveError, completed, counting_from, dot, loaded, norm, solve_with, spectrum, steeper_than,
};

/// How often an improper bolt is moved before the exact projection takes over.
const MOVES: usize = 3;

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
            tolerance: 1e-8,
            max_iterations: 200_000,
            move_improper: true,
        }
    }
}

impl ContactSolver for Uzawa {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        solve_with(self, problem, guess, observe)
    }
}

impl FixedBounds for Uzawa {
    const NAME: &'static str = "uzawa";

    fn limits(&self) -> (f64, usize) {
        (self.tolerance, self.max_iterations)
    }

    fn within(&self, tolerance: f64, max_iterations: usize) -> Self {
        Self {
            tolerance,
            max_iterations,
            ..self.clone()
        }
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        check_rho(self.rho)?;
        let mut run = Run::new(setup, setup.start(guess)?);
        let chosen = match &self.bolts {
            Some(named) => Some(named_bolts(setup, named)?),
            None => run.bolts_of_bilateral_solution(setup),
        };
        let Some(mut bolted) = chosen else {
            return run.exact_projection(
                self,
                setup,
                observe,
                if setup.components.contains(&Component::Tangent) {
                    "the normal forces that press when all contacts are closed do not hold every motion, \
                     so there is no place for a bolt"
                } else {
                    "no contact is pressed when all are closed, so there is no place for a bolt"
                },
            );
        };
        for moves in 0..=MOVES {
            if run.iterate(self, setup, &bolted, observe)? {
                return Ok(run.outcome(setup, true));
            }
            let forces: Vec<f64> = bolted.nodes.iter().map(|&node| run.lambda[node]).collect();
            let tension = -self.tolerance * run.force(setup);
            let improper =
                |place: usize| setup.bounded(bolted.nodes[place]) && forces[place] < tension;
            let bolt = |place: usize, moved: bool| Bolt {
                index: bolted.nodes[place],
                mode: bolted.modes[place],
                force: forces[place],
                moved,
            };
            let places = 0..bolted.nodes.len();
            let Some(first) = places.clone().find(|&place| improper(place)) else {
                run.bolts.extend(places.map(|place| bolt(place, false)));
                return Ok(run.outcome(setup, false));
            };
            if !self.move_improper {
                return Err(SolveError::ImproperBolt {
                    bolt: bolt(first, false),
                    outcome: Box::new(run.outcome(setup, false)),
                });
            }
            let moved = places.filter(|&place| improper(place));
            run.bolts.extend(moved.map(|place| bolt(place, true)));
            match choose(setup, &pressed(setup, &run.lambda)) {
                Some(next) if moves < MOVES && next.nodes != bolted.nodes => bolted = next,
                _ => break,
            }
        }
        run.exact_projection(
            self,
            setup,
            observe,
            "every bolt that was tried ended in tension",
        )
    }
}

/// Bolts that hold the k controlled modes.
struct Bolted {
    /// Contact unknowns.
    nodes: Vec<usize>,
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
            let column = setup.problem.equilibrium.modes.column(node).to_dense();
            let best = (0..column.len())
                .filter(|mode| !modes.contains(mode))
                .max_by(|&a, &b| column[a].abs().total_cmp(&column[b].abs()).then(b.cmp(&a)));
            modes.push(best.unwrap_or(0));
        }
        Some(Self {
            nodes,
            modes,
            inverse,
        })
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
    let components = setup.components.iter().zip(lambda);
    components
        .map(|(component, force)| match component {
            Component::Tangent => 0.0,
            Component::Free | Component::Normal => force.max(0.0),
        })
        .collect()
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
            .filter(|&i| norm(&columns[i]) > 1e-8 * sizes[i] && merit(i) > 0.0)
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
    if named.len() != setup.balance.original_len() {
        return Err(dependent());
    }
    let mut weights = vec![0.0; setup.len()];
    for &node in named {
        weights[node] = 1.0;
    }
    choose(setup, &weights).ok_or_else(dependent)
}

/// The iterate and what it took.
struct Run {
    lambda: Vec<f64>,
    alpha: Vec<f64>,
    judge: Judge,
    rho: f64,
    iterations: usize,
    products: usize,
    bolts: Vec<Bolt>,
}

impl Run {
    fn new(setup: &Setup<'_>, lambda: Vec<f64>) -> Self {
        Self {
            lambda,
            alpha: vec![0.0; setup.modes()],
            judge: setup.judge(),
            rho: 0.0,
            iterations: 0,
            products: 0,
            bolts: Vec::new(),
        }
    }

    /// Scale of forces in the certificate.
    fn force(&self, setup: &Setup<'_>) -> f64 {
        let largest = |s: f64, force: &f64| s.max(force.abs());
        self.lambda.iter().fold(setup.problem.scales.force, largest)
    }

    /// Bolts where the solution with all contacts closed presses hardest; `None` where it presses nowhere.
    fn bolts_of_bilateral_solution(&mut self, setup: &Setup<'_>) -> Option<Bolted> {
        if setup.modes() == 0 {
            return Bolted::new(setup, Vec::new());
        }
        let none = vec![0.0; setup.len()];
        let all: Vec<Unknown> = (0..setup.len()).map(Unknown::of).collect();
        let mut system = System::new(setup, &all, &none);
        let rest = Forces::none(setup);
        let closed = system.solve(&rest, 1e-3);
        self.products += system.products;
        choose(setup, &pressed(setup, &closed?.lambda))
    }

    /// Iterates with the bolts `bolted` until the residual passes with λ_A free; `true`: stopped by the observer.
    fn iterate(
        &mut self,
        options: &Uzawa,
        setup: &Setup<'_>,
        bolted: &Bolted,
        observe: Observer<'_>,
    ) -> Result<bool, SolveError> {
        let problem = setup.problem;
        let m = setup.len();
        let mut components = setup.components.clone();
        for &node in &bolted.nodes {
            components[node] = Component::Free;
        }
        let bounded: Vec<bool> = components.iter().map(|c| *c == Component::Normal).collect();
        let mut is_bolt = vec![false; m];
        bolted.nodes.iter().for_each(|&node| is_bolt[node] = true);
        let mut bound = match options.rho {
            Some(rho) => 1.9 / rho,
            None => reduced_bound(setup, bolted, &mut self.products),
        };
        self.rho = options.rho.unwrap_or(1.9 / bound);
        let mut parts = vec![0.0; setup.modes()];
        for (force, bounded) in self.lambda.iter_mut().zip(&bounded) {
            *force = if *bounded { force.max(0.0) } else { *force };
        }
        setup.admissible.bound_tangents(&mut self.lambda);
        bolted.close(setup, &mut self.lambda, &mut parts);
        let (mut product, mut before) = (vec![0.0; m], vec![0.0; m]);
        let mut previous = self.lambda.clone();
        let mut ceiling = f64::INFINITY;
        let mut first = true;
        loop {
            before.copy_from_slice(&product);
            problem.compliance.apply(&self.lambda, &mut product);
            self.products += 1;
            if options.rho.is_none() && !first {
                let (now, then) = (
                    (&self.lambda[..], &product[..]),
                    (&previous[..], &before[..]),
                );
                if let Some(quotient) = steeper_than(bound, now, then, |i| !is_bolt[i]) {
                    bound = 1.05 * quotient;
                    self.rho = 1.9 / bound;
                }
            }
            bolted.shift(|node| product[node] - problem.shift[node], &mut self.alpha);
            let residual =
                self.judge
                    .residual(setup, &components, &self.lambda, &product, &self.alpha);
            let stopped = !first
                && observe(&Iterate {
                    iteration: self.iterations,
                    lambda: &self.lambda,
                    residual,
                    active: loaded(&self.lambda),
                    step: 'u',
                }) == ControlFlow::Break(());
            if stopped || residual <= options.tolerance {
                return Ok(stopped);
            }
            // A fixed step beyond its limit grows by a factor per iteration.
            let force = self.force(setup);
            let diverged = !residual.is_finite() || force > ceiling;
            if diverged || self.iterations >= options.max_iterations {
                return Err(self.not_converged(options, setup, bolted, residual));
            }
            previous.copy_from_slice(&self.lambda);
            let step = self.rho;
            for ((force, gap), bounded) in self.lambda.iter_mut().zip(&self.judge.gap).zip(&bounded)
            {
                let trial = *force - step * gap;
                *force = if *bounded { trial.max(0.0) } else { trial };
            }
            setup.admissible.bound_tangents(&mut self.lambda);
            bolted.close(setup, &mut self.lambda, &mut parts);
            self.iterations += 1;
            if first {
                ceiling = 1e12 * self.force(setup);
                first = false;
            }
        }
    }

    fn not_converged(
        &self,
        options: &Uzawa,
        setup: &Setup<'_>,
        bolted: &Bolted,
        residual: f64,
    ) -> SolveError {
        let reason = match options.rho {
            None => "allow more iterations, or use newton".to_string(),
            Some(rho) => rho_reason(rho, reduced_bound(setup, bolted, &mut 0)),
        };
        SolveError::NotConverged {
            method: Uzawa::NAME,
            outcome: Box::new(self.outcome(setup, false)),
            residual,
            reason,
        }
    }

    /// Projected gradient with the exact projection, from the forces reached so far.
    fn exact_projection(
        self,
        options: &Uzawa,
        setup: &Setup<'_>,
        observe: Observer<'_>,
        why: &str,
    ) -> Result<Outcome, SolveError> {
        let exact = Gradient {
            rho: None,
            tolerance: options.tolerance,
            max_iterations: options.max_iterations.saturating_sub(self.iterations),
        };
        let guess = setup.multipliers(&self.lambda, &self.alpha);
        let mut after = counting_from(self.iterations, observe);
        let result = exact.run(setup, Some(&guess), &mut after);
        completed(Uzawa::NAME, result, |outcome| Outcome {
            iterations: self.iterations + outcome.iterations,
            products: self.products + outcome.products,
            bolts: self.bolts,
            remarks: vec![format!(
                "{why}: solved with the exact projection instead of bolts"
            )],
            ..outcome
        })
    }

    fn outcome(&self, setup: &Setup<'_>, stopped_by_observer: bool) -> Outcome {
        Outcome {
            multipliers: setup.multipliers(&self.lambda, &self.alpha),
            iterations: self.iterations,
            products: self.products,
            rho: Some(self.rho),
            bolts: self.bolts.clone(),
            exact: false,
            stopped_by_observer,
            fixed_point: None,
            remarks: Vec::new(),
        }
    }
}

/// Upper bound of λ_max(S_A), S_A = ZᵀFZ; see [`Setup::usable_bound`] for the zero operator.
fn reduced_bound(setup: &Setup<'_>, bolted: &Bolted, products: &mut usize) -> f64 {
    let (m, k) = (setup.len(), setup.modes());
    let mut is_bolt = vec![false; m];
    bolted.nodes.iter().for_each(|&node| is_bolt[node] = true);
    let others: Vec<usize> = (0..m).filter(|&i| !is_bolt[i]).collect();
    let (mut inside, mut image) = (vec![0.0; m], vec![0.0; m]);
    let (mut parts, mut forces) = (vec![0.0; k], vec![0.0; k]);
    let (bound, count) = spectrum::largest_eigenvalue(others.len(), spectrum::STEPS, |x, y| {
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
        setup.problem.compliance.apply(&inside, &mut image);
        bolted.shift(|node| image[node], &mut parts);
        setup.balance.add_transposed(-1.0, &parts, &mut image);
        for (y, &i) in y.iter_mut().zip(&others) {
            *y = image[i];
        }
    });
    *products += count;
    setup.usable_bound(bound)
}
