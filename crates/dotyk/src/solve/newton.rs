//! Semismooth Newton = primal-dual active sets: solve on a face, drop the forces that pull, add the gaps that overlap.
//!
//! ```text
//!   repeat:  F_II λ_I − G_Iᵀα = d_I,  G_I λ_I = e,  λ = 0 elsewhere
//!            I ← {i ∈ I: λᵢ > 0} ∪ {i ∉ I: gapᵢ < 0}
//!   until I repeats itself
//! ```
//!
//! Finite and exact: 3 to 10 linear solves from the full set. As described in Hintermüller, Ito & Kunisch (2003) and
//! Hüeber & Wohlmuth (2005), here on the condensed dual problem.
//!
//! Problems with friction go to `slip.rs`.
//!
//! Guards, because convergence is a theorem for M-matrices only:
//! * a new set that cannot balance the load is joined with the old one (the rank decides, not the signs);
//! * a set that was seen before, or a residual that does not fall, ends the phase: some steps of [`Mprgp`], whose rate is
//!   guaranteed, find a better face to begin again; the last resort is the exchange of one contact at a time
//!   (`exchange.rs`), which is finite;
//! * sets that flip between equal solutions (λᵢ = gapᵢ = 0) are accepted as soon as the residual passes;
//! * active contacts that do not determine α leave the α of least norm that opens every gap.

use std::collections::HashSet;
use std::ops::ControlFlow;

use crate::dual::{Compliance, DualProblem, Multipliers, least_norm_within};
use crate::solve::face::{Face, carries};
use crate::solve::{
    ContactSolver, FixedBounds, Iterate, Judge, Mprgp, Observer, Outcome, Setup, SolveError,
    loaded, slip,
};

/// Steps without a smaller residual that end a phase.
const PATIENCE: usize = 8;

/// Forces below this part of the largest are rounding of the linear solves.
const ROUNDING: f64 = 1e-14;

/// Phases, each followed by MPRGP steps, before contacts are exchanged one at a time.
const PHASES: u32 = 2;

/// MPRGP steps after the first phase: a product with F each, cheaper than an active-set step of the same size.
const RESCUE: usize = 400;

/// Primal-dual active sets.
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    /// Residual below which an answer is accepted.
    pub tolerance: f64,
    /// Most active-set steps.
    pub max_iterations: usize,
}

impl Default for Newton {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            max_iterations: 50,
        }
    }
}

impl ContactSolver for Newton {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let setup = Setup::new(problem)?;
        if setup.admissible.has_friction() {
            return slip::solve(self, &setup, guess, observe);
        }
        self.run(&setup, guess, observe)
    }
}

impl FixedBounds for Newton {
    const NAME: &'static str = "newton";

    fn limits(&self) -> (f64, usize) {
        (self.tolerance, self.max_iterations)
    }

    fn within(&self, tolerance: f64, max_iterations: usize) -> Self {
        Self {
            tolerance,
            max_iterations,
        }
    }

    fn run(
        &self,
        setup: &Setup<'_>,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        if setup.admissible.has_friction() {
            return slip::solve(self, setup, guess, observe);
        }
        let start = setup.start(guess)?;
        let mut active: Vec<bool> = (0..setup.len())
            .map(|i| guess.is_none() || start[i] > 0.0 || !setup.bounded(i))
            .collect();
        if !carries(setup, &active) {
            active.fill(true);
        }
        let mut search = Search::new(setup, self.tolerance, start);
        for phase in 0..PHASES {
            let left = self.max_iterations.saturating_sub(search.steps);
            match search.phase(setup, &mut active, left, observe) {
                Phase::Converged => return Ok(search.outcome(setup, false)),
                Phase::Stopped => return Ok(search.outcome(setup, true)),
                Phase::Stuck => {}
            }
            let rescue = Mprgp {
                tolerance: self.tolerance,
                max_iterations: RESCUE << phase,
            };
            let found = match search.rescue(setup, &rescue, observe)? {
                Rescue::Solved(outcome) if outcome.stopped_by_observer => return Ok(outcome),
                Rescue::Solved(outcome) => outcome.multipliers.lambda,
                Rescue::Unfinished(lambda) => lambda,
            };
            for (i, active) in active.iter_mut().enumerate() {
                *active = !setup.bounded(i) || found[i] > 0.0;
            }
            search.face.lambda = found;
        }
        match search.exchange(setup, observe) {
            Phase::Converged => return Ok(search.outcome(setup, false)),
            Phase::Stopped => return Ok(search.outcome(setup, true)),
            Phase::Stuck => {}
        }
        let residual = search.residual;
        match search.rescue(
            setup,
            &Mprgp {
                tolerance: self.tolerance,
                ..Mprgp::default()
            },
            observe,
        )? {
            Rescue::Solved(outcome) => Ok(outcome),
            Rescue::Unfinished(lambda) => {
                search.face.lambda = lambda;
                Err(SolveError::NotConverged {
                    method: Self::NAME,
                    outcome: Box::new(search.outcome(setup, false)),
                    residual,
                    reason: "neither active sets nor MPRGP reached the tolerance: \
                             check the units, the supports and the tolerance"
                        .to_string(),
                })
            }
        }
    }
}

/// What MPRGP reached.
enum Rescue {
    /// An answer that passes, or with which the observer is satisfied; all work counted.
    Solved(Outcome),
    /// Its last forces.
    Unfinished(Vec<f64>),
}

/// How a phase ended.
pub(crate) enum Phase {
    Converged,
    Stopped,
    Stuck,
}

/// The iterate and its history.
pub(crate) struct Search {
    pub face: Face,
    pub judge: Judge,
    pub residual: f64,
    pub tolerance: f64,
    /// Largest force of any step.
    pub force: f64,
    /// Relative accuracy asked of conjugate gradients.
    pub inner: f64,
    /// Active-set steps.
    pub steps: usize,
    /// Active-set and MPRGP steps.
    pub iterations: usize,
}

impl Search {
    fn new(setup: &Setup<'_>, tolerance: f64, start: Vec<f64>) -> Self {
        Self {
            face: Face::new(setup, start),
            judge: setup.judge(),
            residual: f64::INFINITY,
            tolerance,
            force: 0.0,
            inner: 1e-3,
            steps: 0,
            iterations: 0,
        }
    }

    /// Accuracy of conjugate gradients at the end.
    pub fn tight(&self) -> f64 {
        (1e-2 * self.tolerance).clamp(1e-13, 1e-10)
    }

    /// Active-set steps until the set repeats itself.
    fn phase(
        &mut self,
        setup: &Setup<'_>,
        active: &mut Vec<bool>,
        steps: usize,
        observe: Observer<'_>,
    ) -> Phase {
        let exact = matches!(setup.problem.compliance, Compliance::Dense(_));
        let mut seen: HashSet<Vec<bool>> = HashSet::new();
        let (mut best, mut waited) = (f64::INFINITY, 0);
        for _ in 0..steps {
            let before = self.face.lambda.clone();
            self.step(setup, active);
            let stopped = observe(&Iterate {
                iteration: self.iterations,
                lambda: &self.face.lambda,
                residual: self.residual,
                active: loaded(&self.face.lambda),
                step: 'n',
            });
            if stopped == ControlFlow::Break(()) {
                return Phase::Stopped;
            }
            let next = self.next_set(setup, active);
            let passes = self.residual <= self.tolerance;
            if passes && (next == *active || self.residual <= 1e-3 * self.tolerance) {
                return Phase::Converged;
            }
            if next == *active {
                if exact || self.inner <= self.tight() {
                    return Phase::Stuck;
                }
                self.inner = self.tight();
                continue;
            }
            let repeated = !seen.insert(active.clone());
            if repeated && passes {
                return Phase::Converged;
            }
            waited = if self.residual < best { 0 } else { waited + 1 };
            best = best.min(self.residual);
            if repeated && (exact || self.inner <= self.tight()) || waited >= PATIENCE {
                return Phase::Stuck;
            }
            self.inner =
                (0.1 * change(&before, &self.face.lambda).min(self.inner)).max(self.tight());
            *active = next;
            if !carries(setup, active) {
                return Phase::Stuck;
            }
        }
        Phase::Stuck
    }

    /// Solves on the face and judges the result.
    pub fn step(&mut self, setup: &Setup<'_>, active: &[bool]) {
        self.face.solve(setup, active, self.inner);
        self.steps += 1;
        self.iterations += 1;
        self.drop_rounding(setup);
        self.judge(setup);
        if !self.face.loose.is_empty() {
            let open = |i: usize| !active[i];
            let Face { loose, alpha, .. } = &mut self.face;
            open_gaps(setup, loose, &self.judge.gap, open, alpha);
            self.judge(setup);
        }
    }

    /// Forces that are rounding of the largest one met so far are none: their signs mean nothing.
    fn drop_rounding(&mut self, setup: &Setup<'_>) {
        let largest = |s: f64, force: &f64| s.max(force.abs());
        self.force = self.face.lambda.iter().fold(self.force, largest);
        let mut rest = false;
        for (i, force) in self.face.lambda.iter_mut().enumerate() {
            if setup.bounded(i) && force.abs() <= ROUNDING * self.force {
                *force = 0.0;
            }
            rest |= *force != 0.0;
        }
        if !rest {
            self.face.product.fill(0.0);
        }
    }

    fn judge(&mut self, setup: &Setup<'_>) {
        let Face {
            lambda,
            product,
            alpha,
            ..
        } = &self.face;
        self.residual = self
            .judge
            .residual(setup, &setup.components, lambda, product, alpha);
    }

    /// Forces that push stay, gaps that overlap join; never a set that cannot balance the load.
    fn next_set(&self, setup: &Setup<'_>, active: &[bool]) -> Vec<bool> {
        let mut next: Vec<bool> = (0..setup.len())
            .map(|i| {
                !setup.bounded(i)
                    || if active[i] {
                        self.face.lambda[i] > 0.0
                    } else {
                        self.judge.gap[i] < 0.0
                    }
            })
            .collect();
        if !carries(setup, &next) {
            for (next, active) in next.iter_mut().zip(active) {
                *next |= active;
            }
        }
        next
    }

    /// Some MPRGP steps from the current forces, seen by the observer.
    fn rescue(
        &mut self,
        setup: &Setup<'_>,
        method: &Mprgp,
        observe: Observer<'_>,
    ) -> Result<Rescue, SolveError> {
        let guess = self.multipliers(setup);
        let (done, products) = (self.iterations, self.face.products);
        let result = method.run(setup, Some(&guess), &mut |iterate: &Iterate<'_>| {
            observe(&Iterate {
                iteration: done + iterate.iteration,
                ..*iterate
            })
        });
        match result {
            Ok(outcome) => {
                self.iterations += outcome.iterations;
                self.face.products += outcome.products;
                Ok(Rescue::Solved(Outcome {
                    iterations: self.iterations,
                    products: products + outcome.products,
                    remarks: vec!["active sets did not settle; MPRGP finished".to_string()],
                    ..outcome
                }))
            }
            Err(SolveError::NotConverged { outcome, .. }) => {
                self.iterations += outcome.iterations;
                self.face.products += outcome.products;
                Ok(Rescue::Unfinished(outcome.multipliers.lambda))
            }
            Err(error) => Err(error),
        }
    }

    fn multipliers(&self, setup: &Setup<'_>) -> Multipliers {
        setup.multipliers(&self.face.lambda, &self.face.alpha)
    }

    fn outcome(&self, setup: &Setup<'_>, stopped_by_observer: bool) -> Outcome {
        Outcome {
            multipliers: self.multipliers(setup),
            iterations: self.iterations,
            products: self.face.products,
            rho: None,
            bolts: Vec::new(),
            stopped_by_observer,
            fixed_point: None,
            remarks: Vec::new(),
        }
    }
}

/// Moves α̂ along its undetermined directions `loose`, by the least norm, until no gap of an `open` contact overlaps.
pub(crate) fn open_gaps(
    setup: &Setup<'_>,
    loose: &[Vec<f64>],
    gap: &[f64],
    open: impl Fn(usize) -> bool,
    alpha: &mut [f64],
) {
    let (mut rows, mut bounds) = (Vec::new(), Vec::new());
    for i in (0..setup.len()).filter(|&i| open(i)) {
        let row: Vec<f64> = loose
            .iter()
            .map(|z| (0..z.len()).map(|j| z[j] * setup.balance.rows[j][i]).sum())
            .collect();
        // A gap that the loose motion does not change is left to the active set.
        if row.iter().any(|x: &f64| x.abs() > 1e-12) {
            rows.push(row);
            bounds.push(gap[i]);
        }
    }
    if let Some(motion) = least_norm_within(&rows, &bounds, loose.len()) {
        for (motion, z) in motion.iter().zip(loose) {
            for (alpha, z) in alpha.iter_mut().zip(z) {
                *alpha += motion * z;
            }
        }
    }
}

/// ‖after − before‖ / ‖after‖.
fn change(before: &[f64], after: &[f64]) -> f64 {
    let (mut difference, mut size) = (0.0, 0.0);
    for (a, b) in after.iter().zip(before) {
        difference += (a - b).powi(2);
        size += a * a;
    }
    if size > 0.0 {
        (difference / size).sqrt()
    } else {
        0.0
    }
}
