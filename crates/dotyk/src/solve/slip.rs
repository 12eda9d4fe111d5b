//! Semismooth Newton with friction: every contact node is open, sticks or slips; one linear solve per guess of these.
//!
//! ```text
//!   open:   λₙ = 0, λₜ = 0
//!   stick:  gapₙ = 0, gapₜ = 0
//!   slip:   gapₙ = 0, λₜ = bound · s,     bound = coefficient · λₙ (Coulomb) or given (Tresca)
//!   balance of the floating bodies: Ĝλ = ê
//! ```
//!
//! The unknowns are the forces that are left: λ = λ⁰ + Σ xₐ cₐ, where the column cₐ of a slipping Coulomb node is
//! (1, coefficient · s). Each is tested by its row wₐ (gap · wₐ = 0), which is cₐ but for that node, where only the
//! normal gap vanishes: the matrix is unsymmetric, and is solved by LU with pivoting.
//!
//! Next states: closed where λₙ > 0 or gapₙ < 0; slip where the trial z = λₜ − gapₜ/F is longer than the bound at
//! λₙ − gapₙ/F, along s = z/|z|: a node that closes while it moves sideways slips at once (as sticking nodes those would
//! bear large shears and open their neighbours again). With one tangent s is a sign, so that the method ends exactly after finitely many states. With more,
//! the force across s is an unknown, too, with the linearised law (1 − β)λ + (β/F) gap = 0 across s, β = bound/|z| < 1,
//! a term ≥ 0 on the diagonal; convergence is then superlinear.
//!
//! Tresca's bound holds in open contacts as well, which keeps that problem convex.
//!
//! Guards:
//! * a node whose slip turns against its shear sticks next, it never flips its direction;
//! * states in which a body could slide or fly off freely keep those nodes sticking that want to slip least, and
//!   then those closed that were;
//! * states that were seen before, or a residual that does not fall, give way to the fixed point of `coulomb.rs` for
//!   Coulomb's law (first roughly, for better states to begin with) and to [`Accelerated`] for Tresca's, whose convergence
//!   is known.
//!
//! As described in Alart & Curnier (1991) and Hüeber, Stadler & Wohlmuth (2008), here on the condensed dual problem.

use std::collections::HashSet;
use std::ops::{ControlFlow, Range};

use crate::dual::{Block, Compliance, Multipliers};
use crate::linalg::Mat;
use crate::linalg::dense::{least_squares, product, solve_general};
use crate::solve::coulomb::fixed_point;
use crate::solve::face::Pseudo;
use crate::solve::newton::open_gaps;
use crate::solve::{
    Accelerated, FixedBounds, Iterate, Judge, Newton, Observer, Outcome, Setup, SolveError, loaded,
    norm,
};

/// Steps without a smaller residual that end the search.
const PATIENCE: usize = 10;

/// Forces below this part of the largest are rounding of the linear solves.
const ROUNDING: f64 = 1e-14;

/// Solves with given bounds for which the fixed point has steps.
const SOLVES: usize = 40;

/// A shear within this part of its bound is at it.
const AT_BOUND: f64 = 1e-9;

/// Accuracies of the bounds from whose states Newton begins again.
const ROUGHLY: [f64; 2] = [1e-3, 1e-6];

/// Largest system whose solution is refined: beyond, a second factorisation costs more than it gives.
const REFINED: usize = 400;

/// Largest system that is solved by least norm where it is singular.
const SINGULAR: usize = 1200;

/// Newton on the problem of `setup`, which has friction.
///
/// Errors: `Unsupported` where F is not assembled; `NotConverged`.
pub(crate) fn solve(
    method: &Newton,
    setup: &Setup<'_>,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let Compliance::Dense(matrix) = &setup.problem.compliance else {
        return Err(unsupported(setup));
    };
    let start = setup.start(guess)?;
    let mut search = Search::new(method, setup, matrix, start);
    let mut states = search.first_states(guess.map(|_| AT_BOUND));
    search.hold(&mut states, None);
    match search.iterate(states, observe) {
        Ended::Converged => Ok(search.outcome(false)),
        Ended::Stopped => Ok(search.outcome(true)),
        Ended::Stuck => search.begin_again(observe),
    }
}

fn unsupported(setup: &Setup<'_>) -> SolveError {
    let blocks = setup.admissible.blocks();
    let block = blocks.iter().position(|block| block.bound(0.0).is_some());
    let block = block.unwrap_or(0);
    SolveError::Unsupported {
        method: Newton::NAME,
        block,
        found: blocks[block],
        reason: "with friction it needs the assembled compliance, but there are too many contact unknowns \
                 for that: use accelerated or mprgp, or a coarser contact",
    }
}

/// What the shear of a node does.
#[derive(Debug, Clone, PartialEq)]
enum Shear {
    /// No slip.
    Stick,
    /// At the bound along `direction` (unit); across it the node gives way by `softness` (length over force).
    Slip { direction: Vec<f64>, softness: f64 },
    /// The bound is zero.
    Smooth,
}

/// State of one block.
#[derive(Debug, Clone, PartialEq)]
struct State {
    closed: bool,
    shear: Shear,
    /// |z| − bound of the trial, a force: how much the node wants to slip.
    excess: f64,
}

impl State {
    /// What decides whether two states are the same.
    fn key(&self) -> (bool, Vec<u64>) {
        let shear = match &self.shear {
            Shear::Stick => vec![1],
            Shear::Smooth => vec![2],
            Shear::Slip { direction, .. } => direction.iter().map(|x| x.to_bits()).collect(),
        };
        (self.closed, shear)
    }
}

/// One unknown of the linear system.
struct Unknown {
    /// cₐ: components of λ that it moves.
    force: Vec<(usize, f64)>,
    /// wₐ: gaps that it closes.
    row: Vec<(usize, f64)>,
    softness: f64,
}

impl Unknown {
    fn plain(i: usize) -> Self {
        Self {
            force: vec![(i, 1.0)],
            row: vec![(i, 1.0)],
            softness: 0.0,
        }
    }
}

/// Product of a short list of components with a vector.
fn along(list: &[(usize, f64)], v: &[f64]) -> f64 {
    list.iter().map(|&(i, weight)| weight * v[i]).sum()
}

enum Ended {
    Converged,
    Stopped,
    Stuck,
}

struct Search<'a> {
    method: &'a Newton,
    setup: &'a Setup<'a>,
    matrix: &'a Mat<f64>,
    lambda: Vec<f64>,
    alpha: Vec<f64>,
    product: Vec<f64>,
    judge: Judge,
    residual: f64,
    /// Largest force of any step, or that of the overlaps.
    force: f64,
    iterations: usize,
    products: usize,
}

impl<'a> Search<'a> {
    fn new(
        method: &'a Newton,
        setup: &'a Setup<'a>,
        matrix: &'a Mat<f64>,
        lambda: Vec<f64>,
    ) -> Self {
        // The forces that the overlaps ask for: what is rounding of these is none, whatever the solution.
        let largest = |s: f64, overlap: &f64| s.max(overlap.abs());
        let overlap = setup.problem.shift.iter().fold(0.0, largest);
        let softest = (0..lambda.len())
            .map(|i| matrix[(i, i)])
            .fold(0.0, f64::max);
        let force = if softest > 0.0 {
            overlap / softest
        } else {
            0.0
        };
        Self {
            method,
            setup,
            matrix,
            product: vec![0.0; lambda.len()],
            alpha: vec![0.0; setup.modes()],
            judge: setup.judge(),
            residual: f64::INFINITY,
            force,
            iterations: 0,
            products: 0,
            lambda,
        }
    }

    /// States of the present forces, shears within a part of their bounds at them; without that part, all contacts are
    /// closed and stick.
    fn first_states(&self, at_bound: Option<f64>) -> Vec<State> {
        let from_guess = at_bound.is_some();
        let at_bound = at_bound.unwrap_or(AT_BOUND);
        let state = |(block, range): (&Block, Range<usize>)| {
            let normal = self.lambda.get(range.start).copied().unwrap_or(0.0);
            let closed = !from_guess || normal > 0.0 || matches!(block, Block::Free { .. });
            let mut state = State {
                closed,
                shear: Shear::Stick,
                excess: 0.0,
            };
            match block.bound(normal) {
                Some(_) if is_smooth(block) => state.shear = Shear::Smooth,
                Some(bound) if from_guess => {
                    let shear = &self.lambda[range.start + 1..range.end];
                    let length = norm(shear);
                    if length >= bound * (1.0 - at_bound) && length > 0.0 {
                        state.shear = Shear::Slip {
                            direction: shear.iter().map(|t| t / length).collect(),
                            softness: 0.0,
                        };
                    }
                }
                _ => {}
            }
            state
        };
        self.setup.admissible.iter().map(state).collect()
    }

    /// Steps until the states repeat themselves.
    fn iterate(&mut self, mut states: Vec<State>, observe: Observer<'_>) -> Ended {
        let directed = |block: &Block| block.bound(0.0).is_some() && block.size() > 2;
        let exact = !self.setup.admissible.blocks().iter().any(directed);
        let tolerance = self.method.tolerance;
        let mut seen = HashSet::new();
        let (mut best, mut waited) = (f64::INFINITY, 0);
        for _ in 0..self.method.max_iterations {
            if !self.step(&states) {
                return Ended::Stuck;
            }
            let stopped = observe(&Iterate {
                iteration: self.iterations,
                lambda: &self.lambda,
                residual: self.residual,
                active: loaded(&self.lambda),
                step: 'n',
            });
            if stopped == ControlFlow::Break(()) {
                return Ended::Stopped;
            }
            let passes = self.residual <= tolerance;
            if passes && (!exact || self.residual <= 1e-3 * tolerance) {
                return Ended::Converged;
            }
            let mut next = self.next_states(&states);
            self.hold(&mut next, Some(&states));
            let key = |states: &[State]| states.iter().map(State::key).collect::<Vec<_>>();
            let (now, then) = (key(&states), key(&next));
            let repeated = now == then || !seen.insert(now);
            if repeated && passes {
                return Ended::Converged;
            }
            waited = if self.residual < best { 0 } else { waited + 1 };
            best = best.min(self.residual);
            if repeated || waited >= PATIENCE {
                return Ended::Stuck;
            }
            states = next;
        }
        Ended::Stuck
    }

    /// Solves for the forces of `states` and judges them; `false` where the system is singular.
    fn step(&mut self, states: &[State]) -> bool {
        let setup = self.setup;
        let mut offset = vec![0.0; setup.len()];
        let unknowns = self.unknowns(states, &mut offset);
        let loose = self.loose(&unknowns);
        self.iterations += 1;
        let Some(x) = self.linear_solve(&unknowns, &offset, &loose) else {
            return false;
        };
        let (forces, amplitudes) = x.split_at(unknowns.len());
        self.lambda = offset;
        for (unknown, x) in unknowns.iter().zip(forces) {
            for &(i, weight) in &unknown.force {
                self.lambda[i] += x * weight;
            }
        }
        self.alpha.copy_from_slice(amplitudes);
        for z in &loose {
            let part: f64 = z.iter().zip(&self.alpha).map(|(z, a)| z * a).sum();
            for (alpha, z) in self.alpha.iter_mut().zip(z) {
                *alpha -= part * z;
            }
        }
        self.drop_rounding();
        let compliance = &setup.problem.compliance;
        compliance.apply(&self.lambda, &mut self.product);
        self.products += 1;
        self.judge();
        if !loose.is_empty() {
            let mut open = vec![false; setup.len()];
            for (state, (_, range)) in states.iter().zip(setup.admissible.iter()) {
                if let Some(i) = range.clone().next() {
                    open[i] = !state.closed;
                }
            }
            let gap = &self.judge.gap;
            open_gaps(setup, &loose, gap, |i| open[i], &mut self.alpha);
            self.judge();
        }
        true
    }

    /// Forces that are rounding of the largest one met so far are none: their signs mean nothing.
    fn drop_rounding(&mut self) {
        let largest = |s: f64, force: &f64| s.max(force.abs());
        self.force = self.lambda.iter().fold(self.force, largest);
        for (block, range) in self.setup.admissible.iter() {
            let forces = &mut self.lambda[range];
            if matches!(block, Block::Free { .. }) || forces[0].abs() > ROUNDING * self.force {
                continue;
            }
            forces[0] = 0.0;
            if matches!(block, Block::Coulomb { .. }) {
                forces.fill(0.0);
            }
        }
    }

    fn judge(&mut self) {
        self.residual = self.judge.residual(
            self.setup,
            &self.setup.components,
            &self.lambda,
            &self.product,
            &self.alpha,
        );
    }

    /// The forces that `states` leave unknown; those that are known are written to `offset`.
    fn unknowns(&self, states: &[State], offset: &mut [f64]) -> Vec<Unknown> {
        let mut unknowns = Vec::new();
        for (state, (block, range)) in states.iter().zip(self.setup.admissible.iter()) {
            let first = range.start;
            match *block {
                Block::Free { .. } => unknowns.extend(range.map(Unknown::plain)),
                Block::Unilateral => {
                    unknowns.extend(state.closed.then(|| Unknown::plain(first)));
                }
                Block::Tresca { bound, .. } => {
                    unknowns.extend(state.closed.then(|| Unknown::plain(first)));
                    if let Shear::Slip { direction, .. } = &state.shear {
                        for (i, s) in range.clone().skip(1).zip(direction) {
                            offset[i] = bound * s;
                        }
                    }
                    tangential(&state.shear, first + 1..range.end, &mut unknowns);
                }
                Block::Coulomb { coefficient, .. } if state.closed => {
                    let mut normal = Unknown::plain(first);
                    if let Shear::Slip { direction, .. } = &state.shear {
                        let shear = (first + 1..).zip(direction.iter().map(|s| coefficient * s));
                        normal.force.extend(shear);
                    }
                    unknowns.push(normal);
                    tangential(&state.shear, first + 1..range.end, &mut unknowns);
                }
                Block::Coulomb { .. } => {}
            }
        }
        unknowns
    }

    /// (Ĝ cₐ or Ĝ wₐ) as k rows over the unknowns.
    fn modes_of<'u>(
        &self,
        unknowns: &'u [Unknown],
        side: impl Fn(&'u Unknown) -> &'u [(usize, f64)],
    ) -> Vec<Vec<f64>> {
        let rows = self.setup.balance.rows.iter();
        rows.map(|row| unknowns.iter().map(|u| along(side(u), row)).collect())
            .collect()
    }

    /// Directions of α̂ that no gap row determines, orthonormal.
    fn loose(&self, unknowns: &[Unknown]) -> Vec<Vec<f64>> {
        null_of(&self.modes_of(unknowns, |u| &u.row))
    }

    /// x and α̂ of the linear system, (n + k,).
    fn linear_solve(
        &self,
        unknowns: &[Unknown],
        offset: &[f64],
        loose: &[Vec<f64>],
    ) -> Option<Vec<f64>> {
        let (n, k) = (unknowns.len(), self.setup.modes());
        if n + k == 0 {
            return Some(Vec::new());
        }
        let mut known = vec![0.0; offset.len()];
        if offset.iter().any(|x| *x != 0.0) {
            self.setup.problem.compliance.apply(offset, &mut known);
        }
        let forces = self.modes_of(unknowns, |u| &u.force);
        let rows = self.modes_of(unknowns, |u| &u.row);
        let mut system = Mat::zeros(n + k, n + k);
        let mut column = vec![0.0; offset.len()];
        for (b, unknown) in unknowns.iter().enumerate() {
            column.fill(0.0);
            for &(i, weight) in &unknown.force {
                for (c, f) in column.iter_mut().zip(self.matrix.col_as_slice(i)) {
                    *c += weight * f;
                }
            }
            let out = system.col_as_slice_mut(b);
            for (out, other) in out.iter_mut().zip(unknowns) {
                *out = along(&other.row, &column);
            }
            out[b] += unknown.softness;
        }
        // In units in which the balance is as large as the compliance: pivots are compared with each other.
        let largest = (0..n).fold(0.0, |s: f64, a| s.max(system[(a, a)].abs()));
        let unit = if largest > 0.0 { largest } else { 1.0 };
        for j in 0..k {
            for a in 0..n {
                system[(a, n + j)] = -unit * rows[j][a];
                system[(n + j, a)] = unit * forces[j][a];
            }
            for i in 0..k {
                system[(n + i, n + j)] = loose.iter().map(|z| unit * z[i] * z[j]).sum();
            }
        }
        let mut rest = vec![0.0; k];
        self.setup.balance.imbalance(offset, &mut rest);
        let shift = &self.setup.problem.shift;
        let right = Mat::from_fn(n + k, 1, |a, _| match unknowns.get(a) {
            Some(unknown) => along(&unknown.row, shift) - along(&unknown.row, &known),
            None => -unit * rest[a - n],
        });
        let mut x = factored(system, &right)?;
        x[n..].iter_mut().for_each(|alpha| *alpha *= unit);
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// States that the forces and gaps of the last step ask for.
    fn next_states(&self, states: &[State]) -> Vec<State> {
        let gap = &self.judge.gap;
        let blocks = self.setup.admissible.iter();
        let next = |(state, (block, range)): (&State, (&Block, Range<usize>))| {
            if matches!(block, Block::Free { .. }) {
                return state.clone();
            }
            let first = range.start;
            let closed = if state.closed {
                self.lambda[first] > 0.0
            } else {
                gap[first] < 0.0
            };
            let (shear, excess) = self.next_shear(state, block, range, closed);
            State {
                closed,
                shear,
                excess,
            }
        };
        states.iter().zip(blocks).map(next).collect()
    }

    /// Next shear of a block and its excess over the bound.
    fn next_shear(
        &self,
        state: &State,
        block: &Block,
        range: Range<usize>,
        closed: bool,
    ) -> (Shear, f64) {
        let first = range.start;
        let pressed = self.lambda[first] - self.judge.gap[first] / self.scale(first..first + 1);
        let Some(bound) = block.bound(pressed) else {
            return (Shear::Stick, 0.0);
        };
        if is_smooth(block) {
            return (Shear::Smooth, 0.0);
        }
        if matches!(block, Block::Coulomb { .. }) && !closed {
            return (Shear::Stick, 0.0);
        }
        let tangents = range.start + 1..range.end;
        let compliance = self.scale(tangents.clone());
        let trial: Vec<f64> = tangents
            .map(|i| self.lambda[i] - self.judge.gap[i] / compliance)
            .collect();
        let length = norm(&trial);
        let excess = length - bound;
        let turned = match &state.shear {
            Shear::Slip { direction, .. } => {
                direction
                    .iter()
                    .zip(&trial)
                    .map(|(s, z)| s * z)
                    .sum::<f64>()
                    <= 0.0
            }
            _ => false,
        };
        if length <= bound || turned {
            return (Shear::Stick, excess.min(0.0));
        }
        let softness = (excess / bound).min(1e6) * compliance;
        let direction = trial.iter().map(|z| z / length).collect();
        (
            Shear::Slip {
                direction,
                softness,
            },
            excess,
        )
    }

    /// Mean of F on the diagonal, a length over force; 1 where it vanishes.
    fn scale(&self, components: Range<usize>) -> f64 {
        let count = components.len() as f64;
        let mean = components.map(|i| self.matrix[(i, i)]).sum::<f64>() / count;
        if mean > 0.0 { mean } else { 1.0 }
    }

    /// Changes `states` until they hold the floating bodies: nodes that want to slip least stick, then contacts of
    /// `before` stay closed (all of them where there is no before).
    fn hold(&self, states: &mut [State], before: Option<&[State]>) {
        if self.setup.modes() == 0 {
            return;
        }
        self.stick_where_free(states);
        let mut offset = vec![0.0; self.setup.len()];
        let unknowns = self.unknowns(states, &mut offset);
        if self.carries(&unknowns, &offset) {
            return;
        }
        for (place, state) in states.iter_mut().enumerate() {
            match before.map(|before| &before[place]) {
                Some(before) if before.closed && !state.closed => *state = before.clone(),
                None => state.closed = true,
                _ => {}
            }
        }
        self.stick_where_free(states);
    }

    /// Nodes stick, those first that want to slip least, until no body slides freely.
    fn stick_where_free(&self, states: &mut [State]) {
        loop {
            let unknowns = self.unknowns(states, &mut vec![0.0; self.setup.len()]);
            let loose = self.loose(&unknowns);
            if loose.is_empty() {
                return;
            }
            let rows = &self.setup.balance.rows;
            let moves = |i: usize| {
                let along_mode =
                    |z: &Vec<f64>| z.iter().zip(rows).map(|(z, row)| z * row[i]).sum::<f64>();
                loose.iter().any(|z| along_mode(z).abs() > 1e-9)
            };
            let slipping = |place: &usize| {
                let state = &states[*place];
                let coulomb = matches!(
                    self.setup.admissible.blocks()[*place],
                    Block::Coulomb { .. }
                );
                matches!(state.shear, Shear::Slip { .. })
                    && (state.closed || !coulomb)
                    && self.setup.admissible.range(*place).skip(1).any(moves)
            };
            let least = (0..states.len())
                .filter(slipping)
                .min_by(|&a, &b| states[a].excess.total_cmp(&states[b].excess));
            let Some(place) = least else { return };
            states[place].shear = Shear::Stick;
        }
    }

    /// Some values of the unknowns balance the load.
    fn carries(&self, unknowns: &[Unknown], offset: &[f64]) -> bool {
        let forces = self.modes_of(unknowns, |u| &u.force);
        let mut rest = vec![0.0; self.setup.modes()];
        self.setup.balance.imbalance(offset, &mut rest);
        let size = norm(&self.setup.balance.load).max(norm(&rest));
        null_of(&forces).iter().all(|z| {
            let part: f64 = z.iter().zip(&rest).map(|(z, rest)| z * rest).sum();
            part.abs() <= 1e-9 * size
        })
    }

    /// Bounds that are iterated roughly tell better states to begin with; only where these do not settle either, the
    /// method whose convergence is known finishes.
    fn begin_again(mut self, observe: Observer<'_>) -> Result<Outcome, SolveError> {
        if !self.setup.admissible.has_coulomb() {
            return self.fall_back(observe);
        }
        for tolerance in ROUGHLY {
            let rounds = self.method.within(tolerance, self.method.max_iterations);
            let done = self.iterations;
            let guess = self.setup.multipliers(&self.lambda, &self.alpha);
            let finite = guess
                .lambda
                .iter()
                .chain(&guess.alpha)
                .all(|x| x.is_finite());
            let mut shifted = |iterate: &Iterate<'_>| {
                observe(&Iterate {
                    iteration: done + iterate.iteration,
                    ..*iterate
                })
            };
            let result = fixed_point(&rounds, self.setup, finite.then_some(&guess), &mut shifted);
            let outcome = match result {
                Ok(outcome) => outcome,
                Err(SolveError::NotConverged { outcome, .. }) => *outcome,
                Err(error) => return Err(error),
            };
            self.iterations += outcome.iterations;
            self.products += outcome.products;
            if outcome.stopped_by_observer {
                return Ok(Outcome {
                    iterations: self.iterations,
                    products: self.products,
                    ..outcome
                });
            }
            self.lambda = outcome.multipliers.lambda;
            let mut states = self.first_states(Some(10.0 * tolerance));
            self.hold(&mut states, None);
            match self.iterate(states, observe) {
                Ended::Converged => return Ok(self.outcome(false)),
                Ended::Stopped => return Ok(self.outcome(true)),
                Ended::Stuck => {}
            }
        }
        self.fall_back(observe)
    }

    /// The method whose convergence is known takes over from the last forces.
    fn fall_back(mut self, observe: Observer<'_>) -> Result<Outcome, SolveError> {
        let finite = self.lambda.iter().chain(&self.alpha).all(|x| x.is_finite());
        let guess = finite.then(|| self.setup.multipliers(&self.lambda, &self.alpha));
        let done = self.iterations;
        let mut shifted = |iterate: &Iterate<'_>| {
            observe(&Iterate {
                iteration: done + iterate.iteration,
                ..*iterate
            })
        };
        let (result, remark) = if self.setup.admissible.has_coulomb() {
            let Newton {
                tolerance,
                max_iterations,
            } = *self.method;
            let rounds = self.method.within(tolerance, SOLVES * max_iterations);
            let result = fixed_point(&rounds, self.setup, guess.as_ref(), &mut shifted);
            (
                result,
                "the states of friction did not settle: bounds were iterated",
            )
        } else {
            let rescue = Accelerated {
                tolerance: self.method.tolerance,
                ..Accelerated::default()
            };
            let result = rescue.run(self.setup, guess.as_ref(), &mut shifted);
            (
                result,
                "the states of friction did not settle: accelerated finished",
            )
        };
        let mut finish = |outcome: Outcome| {
            self.iterations += outcome.iterations;
            let mut remarks = vec![remark.to_string()];
            remarks.extend(outcome.remarks.iter().filter(|own| *own != remark).cloned());
            Outcome {
                iterations: self.iterations,
                products: self.products + outcome.products,
                rho: None,
                remarks,
                ..outcome
            }
        };
        match result {
            Ok(outcome) => Ok(finish(outcome)),
            Err(SolveError::NotConverged {
                outcome,
                residual,
                reason,
                ..
            }) => Err(SolveError::NotConverged {
                method: Newton::NAME,
                outcome: Box::new(finish(*outcome)),
                residual,
                reason,
            }),
            Err(error) => Err(error),
        }
    }

    fn outcome(&self, stopped_by_observer: bool) -> Outcome {
        Outcome {
            multipliers: self.setup.multipliers(&self.lambda, &self.alpha),
            iterations: self.iterations,
            products: self.products,
            rho: None,
            bolts: Vec::new(),
            stopped_by_observer,
            fixed_point: None,
            remarks: Vec::new(),
        }
    }
}

/// The law can bear no shear at all.
fn is_smooth(block: &Block) -> bool {
    match *block {
        Block::Tresca { bound, .. } => bound <= 0.0,
        Block::Coulomb { coefficient, .. } => coefficient <= 0.0,
        Block::Free { .. } | Block::Unilateral => false,
    }
}

/// Unknown tangential forces: all of a sticking node, those across the slip of a slipping one.
fn tangential(shear: &Shear, tangents: Range<usize>, unknowns: &mut Vec<Unknown>) {
    match shear {
        Shear::Smooth => {}
        Shear::Stick => unknowns.extend(tangents.map(Unknown::plain)),
        Shear::Slip {
            direction,
            softness,
        } => {
            for across in complement(direction) {
                let list: Vec<(usize, f64)> = tangents.clone().zip(across).collect();
                unknowns.push(Unknown {
                    force: list.clone(),
                    row: list,
                    softness: *softness,
                });
            }
        }
    }
}

/// Orthonormal vectors across the unit vector `direction`, by the reflection that turns it into the first axis.
fn complement(direction: &[f64]) -> Vec<Vec<f64>> {
    let mut mirror = direction.to_vec();
    mirror[0] += 1.0_f64.copysign(direction[0]);
    let square: f64 = mirror.iter().map(|x| x * x).sum();
    let reflected = |axis: usize| -> Vec<f64> {
        (0..direction.len())
            .map(|i| f64::from(i == axis) - 2.0 * mirror[axis] * mirror[i] / square)
            .collect()
    };
    (1..direction.len()).map(reflected).collect()
}

/// Orthonormal z (k,) with zᵀ`rows` = 0.
fn null_of(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let gram = Mat::from_fn(rows.len(), rows.len(), |i, j| {
        rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum()
    });
    Pseudo::new(&gram).null
}

/// The solution of a square system; of least norm where it is singular and small, `None` where it is singular and large.
///
/// Rows and columns are scaled to size one by powers of two, which rounds nothing: a stiff body beside a soft one must not
/// drown in its pivots. One step of refinement follows.
fn factored(mut system: Mat<f64>, right: &Mat<f64>) -> Option<Vec<f64>> {
    let n = system.nrows();
    let power = |largest: f64| match largest > 0.0 && largest.is_finite() {
        true => (-largest.log2().round()).exp2(),
        false => 1.0,
    };
    let columns: Vec<f64> = (0..n)
        .map(|j| {
            let column = system.col_as_slice_mut(j);
            let scale = power(column.iter().fold(0.0, |s: f64, a| s.max(a.abs())));
            column.iter_mut().for_each(|a| *a *= scale);
            scale
        })
        .collect();
    let mut largest = vec![0.0f64; n];
    for j in 0..n {
        let column = system.col_as_slice(j).iter();
        largest
            .iter_mut()
            .zip(column)
            .for_each(|(s, a)| *s = s.max(a.abs()));
    }
    let rows: Vec<f64> = largest.into_iter().map(power).collect();
    for j in 0..n {
        let column = system.col_as_slice_mut(j).iter_mut();
        column.zip(&rows).for_each(|(a, scale)| *a *= scale);
    }
    let right = Mat::from_fn(n, 1, |i, _| rows[i] * right[(i, 0)]);
    let solve = |right: &Mat<f64>| {
        let (mut spoilt, mut x) = (system.clone(), right.clone());
        if solve_general(&mut spoilt, &mut x).is_err() {
            if n > SINGULAR {
                return None;
            }
            x = least_squares(&system, right, 1e-13).ok()?;
        }
        Some(x)
    };
    let mut x = solve(&right)?;
    let image = product(&system, &x);
    let rest = Mat::from_fn(n, 1, |i, _| right[(i, 0)] - image[(i, 0)]);
    if n <= REFINED {
        let correction = solve(&rest)?;
        x = Mat::from_fn(n, 1, |i, _| x[(i, 0)] + correction[(i, 0)]);
    }
    Some((0..n).map(|j| columns[j] * x[(j, 0)]).collect())
}
