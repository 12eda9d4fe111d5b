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
//! Guards, because convergence is a theorem for M-matrices only:
//! * a new set that cannot balance the load is joined with the old one (the rank decides, not the signs);
//! * a set that was seen before, or a residual that does not fall, ends the phase: some steps of [`Mprgp`], whose rate is
//!   guaranteed, find a better face to begin again;
//! * sets that flip between equal solutions (λᵢ = gapᵢ = 0) are accepted as soon as the residual passes;
//! * active contacts that do not determine α leave the α of least norm that opens every gap.

use std::collections::HashSet;
use std::ops::ControlFlow;

use crate::dual::{Compliance, DualProblem, Multipliers, least_norm_within};
use crate::solve::face::{Face, carries};
use crate::solve::{
    ContactSolver, Iterate, Judge, Mprgp, Observer, Outcome, Setup, SolveError, loaded,
};

/// Steps without a smaller residual that end a phase.
const PATIENCE: usize = 8;

/// Phases with MPRGP steps between them before MPRGP finishes alone.
const PHASES: u32 = 4;

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
        "newton"
    }

    fn solve(
        &self,
        problem: &DualProblem,
        guess: Option<&Multipliers>,
        observe: Observer<'_>,
    ) -> Result<Outcome, SolveError> {
        let setup = Setup::new(problem, self.name())?;
        let start = setup.start(guess)?;
        let mut active: Vec<bool> = (0..setup.len())
            .map(|i| guess.is_none() || start[i] > 0.0 || !setup.bounded(i))
            .collect();
        if !carries(&setup, &active) {
            active.fill(true);
        }
        let mut search = Search::new(&setup, self.tolerance, start);
        for phase in 0..=PHASES {
            let left = self.max_iterations.saturating_sub(search.steps);
            match search.phase(&setup, &mut active, left, observe) {
                Phase::Converged => return Ok(search.outcome(&setup, false)),
                Phase::Stopped => return Ok(search.outcome(&setup, true)),
                Phase::Stuck => {}
            }
            let last = phase == PHASES || search.steps >= self.max_iterations;
            let rescue = Mprgp {
                tolerance: self.tolerance,
                max_iterations: if last {
                    Mprgp::default().max_iterations
                } else {
                    50 << phase
                },
            };
            let guess = search.multipliers(&setup);
            let done = search.iterations;
            let result = rescue.solve(problem, Some(&guess), &mut |iterate: &Iterate<'_>| {
                observe(&Iterate {
                    iteration: done + iterate.iteration,
                    ..*iterate
                })
            });
            match result {
                Ok(outcome) if outcome.stopped_by_observer || last => {
                    return Ok(search.finish_with(outcome));
                }
                Ok(outcome) => {
                    // Solved; the exact solution on its face is cheap.
                    let sharp = search.sharpen(&setup, &outcome.multipliers.lambda);
                    return Ok(sharp.unwrap_or_else(|| search.finish_with(outcome)));
                }
                Err(SolveError::NotConverged {
                    outcome, residual, ..
                }) => {
                    if last {
                        return Err(SolveError::NotConverged {
                            method: self.name(),
                            outcome: Box::new(search.finish_with(*outcome)),
                            residual,
                            reason: "neither active sets nor MPRGP reached the tolerance: \
                                     check the units and the tolerance"
                                .to_string(),
                        });
                    }
                    search.iterations += outcome.iterations;
                    search.face.products += outcome.products;
                    for i in 0..setup.len() {
                        active[i] = !setup.bounded(i) || outcome.multipliers.lambda[i] > 0.0;
                    }
                    search.face.lambda = outcome.multipliers.lambda;
                }
                Err(error) => return Err(error),
            }
        }
        Err(SolveError::Invalid(
            "newton ended without a verdict: max_iterations must be positive".to_string(),
        ))
    }
}

enum Phase {
    Converged,
    Stopped,
    Stuck,
}

/// The iterate and its history.
struct Search {
    face: Face,
    judge: Judge,
    residual: f64,
    tolerance: f64,
    /// Relative accuracy asked of conjugate gradients.
    inner: f64,
    /// Active-set steps.
    steps: usize,
    /// Active-set and MPRGP steps.
    iterations: usize,
}

impl Search {
    fn new(setup: &Setup<'_>, tolerance: f64, start: Vec<f64>) -> Self {
        Self {
            face: Face::new(setup, start),
            judge: setup.judge(),
            residual: f64::INFINITY,
            tolerance,
            inner: 1e-3,
            steps: 0,
            iterations: 0,
        }
    }

    /// Accuracy of conjugate gradients at the end.
    fn tight(&self) -> f64 {
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
            self.inner = (0.1 * change(&before, &self.face.lambda)).clamp(self.tight(), self.inner);
            *active = next;
            if !carries(setup, active) {
                return Phase::Stuck;
            }
        }
        Phase::Stuck
    }

    /// Solves on the face and judges the result.
    fn step(&mut self, setup: &Setup<'_>, active: &[bool]) {
        self.face.solve(setup, active, self.inner);
        self.steps += 1;
        self.iterations += 1;
        self.judge(setup);
        if !self.face.loose.is_empty() {
            self.open_gaps(setup, active);
            self.judge(setup);
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

    /// Moves α̂ along its undetermined directions, by the least norm, until no inactive gap overlaps.
    fn open_gaps(&mut self, setup: &Setup<'_>, active: &[bool]) {
        let loose = &self.face.loose;
        let (mut rows, mut bounds) = (Vec::new(), Vec::new());
        for i in (0..setup.len()).filter(|&i| !active[i]) {
            let row: Vec<f64> = loose
                .iter()
                .map(|z| (0..z.len()).map(|j| z[j] * setup.balance.rows[j][i]).sum())
                .collect();
            // A gap that the loose motion does not change is left to the active set.
            if row.iter().any(|x: &f64| x.abs() > 1e-12) {
                rows.push(row);
                bounds.push(self.judge.gap[i]);
            }
        }
        if let Some(motion) = least_norm_within(&rows, &bounds, loose.len()) {
            for (motion, z) in motion.iter().zip(loose) {
                for (alpha, z) in self.face.alpha.iter_mut().zip(z) {
                    *alpha += motion * z;
                }
            }
        }
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

    /// The exact solution on the face of `lambda`, if it is one.
    fn sharpen(&mut self, setup: &Setup<'_>, lambda: &[f64]) -> Option<Outcome> {
        let active: Vec<bool> = (0..setup.len())
            .map(|i| !setup.bounded(i) || lambda[i] > 0.0)
            .collect();
        self.face.lambda.copy_from_slice(lambda);
        self.inner = self.tight();
        self.step(setup, &active);
        (self.residual <= self.tolerance).then(|| self.outcome(setup, false))
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
            remarks: Vec::new(),
        }
    }

    /// The answer of the rescue with all work counted.
    fn finish_with(&self, rescue: Outcome) -> Outcome {
        Outcome {
            iterations: self.iterations + rescue.iterations,
            products: self.face.products + rescue.products,
            remarks: vec!["active sets did not settle; MPRGP finished".to_string()],
            ..rescue
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
