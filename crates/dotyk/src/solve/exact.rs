//! Exact steps on the states of contact nodes: guess open, stick or slip for each of them, solve for the forces of that guess,
//! and derive the next guess from the result.
//!
//! One step is one linear problem (`system.rs`). Its forces λ and gaps give the next guess by the trial forces λ − gap/c
//! with the compliance c of each contact: closed where these press, slipping where their shear is beyond its bound. A guess
//! that reproduces itself is the answer, exact but for the rounding of one solve. From a good start that takes a few
//! steps; on general compliances the guesses may run in a circle, and then the steps end and return the next guess.
//!
//! [`Search`] is the iterate of these steps and of the stages that follow where they fail: forces, residual, the best forces so far,
//! and the work done.
//!
//! As described in Hintermüller, Ito & Kunisch (2003) without friction, Alart & Curnier (1991) with it.

use std::collections::HashSet;
use std::ops::Range;

use crate::dual::{Block, Compliance, Multipliers};
use crate::linalg::Mat;
use crate::linalg::dense::{cholesky_in_place, solve_lower_in_place};
use crate::linalg::signed::least_norm_within;
use crate::solve::hold::held;
use crate::solve::iteration::tell;
use crate::solve::setup::{Forces, Judge, Setup};
use crate::solve::states::{Shear, State};
use crate::solve::system::System;
use crate::solve::{Observer, Outcome, SolveError, dot, largest, levels};

/// How long exact steps may go on.
pub(crate) struct Patience {
    /// Most steps.
    pub steps: usize,
    /// Each residual must be at most this part of the one before.
    pub factor: f64,
    /// From this step on fewer states must change than in the step before, or the residual must fall.
    pub settling: usize,
    /// Steps that only open contacts do not count: no states come twice on the way.
    pub opening: bool,
}

impl Patience {
    pub const fn new(steps: usize, factor: f64) -> Self {
        Self {
            steps,
            factor,
            settling: usize::MAX,
            opening: false,
        }
    }

    /// The same, not counting steps that only open contacts.
    pub const fn opening(self) -> Self {
        Self {
            opening: true,
            ..self
        }
    }

    /// The same; from step `settling` on fewer states must change each time, or the residual must fall.
    pub const fn settling(self, settling: usize) -> Self {
        Self { settling, ..self }
    }
}

/// Steps that are near the answer.
pub(crate) const NEAR: Patience = Patience::new(6, 0.5);

/// Most products with an applied compliance, several times as many as large problems need: where these are not enough, the
/// problem is too ill-conditioned for iterations within a step.
const PRODUCTS: usize = 3000;

/// Changes the states that come next, given those before.
type Adjust<'a> = dyn Fn(&mut Vec<State>, &[State]) + 'a;

/// Why a search ended without an answer.
pub(crate) const STALLED: &str = "the residual did not fall below the tolerance";

/// Residuals that are near an answer.
pub(crate) const NEARBY: f64 = 1e-2;

/// A residual below this part of the tolerance is an answer whatever the states are: those that still change are rounding.
pub(crate) const CERTAIN: f64 = 1e-3;

/// Accuracy of iterations within a step as a part of the tolerance, so that their error does not decide.
const INNER_ACCURACY: f64 = 1e-2;

/// Their highest accuracy: beyond it lies the rounding of the products; a lower one would show in the certificate.
const MOST_ACCURATE: f64 = 1e-13;
const LEAST_ACCURATE: f64 = 1e-10;

/// Their accuracy at the beginning, where the states are guesses: two digits determine most of them.
const BEGINNING: f64 = 1e-2;

/// The same of bodies in pieces, of which many products make one digit; and where the states repeat themselves, as few of them change
/// then. A ball in pieces on a block takes 221 products with these two, 369 with two digits.
const IN_PIECES: f64 = 0.1;
const SETTLED: f64 = 1e-3;

/// Accuracy of iterations within a step where the start is good: rougher forces would spoil it.
const CLOSE: f64 = 1e-9;

/// A gap that a motion of unit length changes by less does not move with it: ten times the rounding of orthonormal modes.
const UNMOVED: f64 = 1e-12;

/// Forces below this part of the largest are rounding of the linear solves.
const FORCE_ROUNDING: f64 = 1e-14;

/// Loads below this part of those of other domains are their rounding.
const UNLOADED: f64 = 1e-16;

/// Forces below this part of those of the overlaps may be their rounding: as much as a matrix of condition 10⁶ makes of it.
const MOVED_ALONG: f64 = 1e-9;

/// How a phase ended.
pub(crate) enum Ended {
    Converged,
    Stopped,
    /// No answer; the states that come next.
    Stuck(Vec<State>),
}

/// Accuracy of iterations within a step at the end.
pub(crate) fn tight(tolerance: f64) -> f64 {
    (INNER_ACCURACY * tolerance).clamp(MOST_ACCURATE, LEAST_ACCURATE)
}

/// Accuracy where that is not enough: with many contacts the error of one is small beside that of all.
pub(crate) fn finest(tolerance: f64) -> f64 {
    INNER_ACCURACY * tight(tolerance)
}

/// The accuracy that comes next where states repeat themselves.
fn finer(accuracy: f64, tolerance: f64) -> f64 {
    match accuracy {
        rough if rough > BEGINNING => SETTLED.max(tight(tolerance)),
        rough if rough > tight(tolerance) => tight(tolerance),
        _ => finest(tolerance),
    }
}

/// An exact step from states that do not change any more.
const ONCE: Patience = Patience::new(1, f64::INFINITY);

/// States of successive iterates. Mostly they are those of the answer long before the iterates converge: exact steps from there
/// find out, once for the same states.
#[derive(Default)]
pub(crate) struct Settled {
    /// The last states, and for how many iterates they have been the same.
    last: Vec<(bool, u8)>,
    times: usize,
    tried: HashSet<Vec<(bool, u8)>>,
}

impl Settled {
    /// Exact steps if `states` have been the same `times` times in a row. Otherwise, or if no answer follows, `None` and an unchanged
    /// search.
    pub fn exact(
        &mut self,
        search: &mut Search<'_>,
        states: Vec<State>,
        times: usize,
        observe: Observer<'_>,
    ) -> Option<Ended> {
        let keys = State::keys(&states);
        self.times = if keys == self.last { self.times + 1 } else { 1 };
        self.last.clone_from(&keys);
        if self.times < times || !self.tried.insert(keys.clone()) {
            return None;
        }
        let here = (search.residual, search.kind, search.point.clone());
        // directions of slip may still turn in space, bounds may bend
        let patience = match State::turning(&states, &search.setup.admissible) > 0.0 {
            true => &NEAR,
            false => &ONCE,
        };
        let adjust = held(search.setup);
        let mut ended = search.exact(states, patience, &adjust, observe);
        // the step has corrected the one node that was still wrong
        if let Ended::Stuck(next) = &ended
            && differing(&keys, &State::keys(next)) == 1
        {
            ended = search.exact(next.clone(), patience, &adjust, observe);
        }
        match ended {
            Ended::Stuck(_) => {
                (search.residual, search.kind, search.point) = here;
                None
            }
            ended => Some(ended),
        }
    }
}

/// In how many nodes states differ.
fn differing(these: &[(bool, u8)], those: &[(bool, u8)]) -> usize {
    these.iter().zip(those).filter(|(a, b)| a != b).count()
}

/// Names of stages that other files begin, too.
pub(crate) const EXACT_STEPS: &str = "exact steps";
pub(crate) const COARSER: &str = "a coarser problem";
pub(crate) const INTERIOR: &str = "interior points";

/// The iterate and its history.
pub(crate) struct Search<'a> {
    /// Residual below which an answer is accepted, and the most linear solves on the problem itself.
    pub tolerance: f64,
    pub most: usize,
    pub setup: &'a Setup<'a>,
    pub point: Forces,
    pub judge: Judge,
    pub residual: f64,
    /// The least residual so far, and where it was.
    pub best: (f64, Forces),
    /// Compliance of the trial forces (m,).
    softness: Vec<f64>,
    /// Largest force |d|/softness of the overlaps.
    asked: f64,
    /// Domains that nothing loads.
    still: Vec<bool>,
    /// Linear solves on the problem itself.
    pub steps: usize,
    /// Those on coarser problems, in solves of this size.
    coarse: f64,
    /// Products with F that came before.
    products: usize,
    /// Relative accuracy asked of iterations within a step.
    pub accuracy: f64,
    /// Kind of the last step, as in [`crate::solve::Iterate`].
    pub kind: char,
    /// The states of the last exact step determine its forces.
    pub unique: bool,
    /// Forces and gaps (m,) with which floating bodies rest under given bounds of friction, once they are known.
    pub rested: Option<(Vec<f64>, Vec<f64>)>,
    /// Names of the stages that were entered.
    pub tried: Vec<&'static str>,
}

/// Shears of discs with given bounds are at most this many times as soft as with all other nodes held.
const HELD: f64 = 10.0;

/// The compliances with which a search asks for forces, (m,): those of the problem. Where a body is weakly supported they are so large that
/// a trial shear is hardly longer than its bound, whatever the slip. Directions of slip, which a node of space has beside a given bound, then
/// turn slowly or for ever; so there they are bounded by those of a node all others beside which are held, 1/(F⁻¹)ᵢᵢ.
fn softness(setup: &Setup<'_>) -> Vec<f64> {
    let mut softness = setup.problem.softness.clone();
    let discs = || {
        let blocks = setup.admissible.iter();
        blocks.filter(|(block, range)| block.friction().is_some() && range.len() > 2)
    };
    let Compliance::Dense(matrix) = &setup.problem.compliance else {
        return softness;
    };
    if setup.admissible.bounds_follow() || discs().next().is_none() {
        return softness;
    }
    let m = matrix.nrows();
    let mut factor = matrix.clone();
    (0..m).for_each(|i| factor[(i, i)] *= 1.0 + SINGULAR);
    if cholesky_in_place(&mut factor).is_err() {
        return softness;
    }
    let mut inverse = Mat::<f64>::identity(m, m);
    solve_lower_in_place(&factor, &mut inverse);
    let held = |i: usize| {
        let column = inverse.col_as_slice(i).iter();
        1.0 / column.map(|c| c * c).sum::<f64>()
    };
    for (block, range) in discs() {
        let shear = block.shear(&range);
        let mean = shear.clone().map(held).sum::<f64>() / shear.len() as f64;
        shear.for_each(|i| softness[i] = softness[i].min(HELD * mean));
    }
    softness
}

/// A compliance that leaves some forces without a gap is made definite by this part of its diagonal.
const SINGULAR: f64 = 1e-10;

impl<'a> Search<'a> {
    /// Begins without any force.
    pub fn new((tolerance, most): (f64, usize), setup: &'a Setup<'a>) -> Self {
        // the forces of the overlaps: a force within their rounding counts as zero, whatever the solution
        let asked = setup.problem.shift.iter().zip(&setup.problem.softness);
        let force = asked.fold(0.0, |s: f64, (d, c)| s.max((d / c).abs()));
        Self {
            tolerance,
            most,
            setup,
            point: Forces::none(setup),
            judge: setup.judge(),
            residual: f64::INFINITY,
            best: (f64::INFINITY, Forces::none(setup)),
            softness: softness(setup),
            asked: if force.is_finite() { force } else { 0.0 },
            still: still(setup),
            steps: 0,
            coarse: 0.0,
            products: setup.products(),
            kind: 'n',
            unique: false,
            rested: None,
            tried: Vec::new(),
            accuracy: match setup.problem.compliance {
                Compliance::Dense(_) | Compliance::Sparse(_) => finest(tolerance),
                Compliance::Operator { glue: None, .. } => BEGINNING,
                Compliance::Operator { .. } => IN_PIECES,
            },
        }
    }

    /// The states of a starting point: contacts with a force are closed, shears at their bound slip.
    ///
    /// Errors: a starting point of another size, or one that is not finite.
    pub fn states_of_guess(&mut self, guess: &Multipliers) -> Result<Vec<State>, SolveError> {
        self.point.lambda = self.setup.start(Some(guess))?;
        let balance = &self.setup.balance;
        balance.from_original(&guess.alpha, &mut self.point.alpha);
        let admissible = &self.setup.admissible;
        Ok(State::of_all_forces(admissible, &self.point.lambda))
    }

    /// Goes to some forces, and returns the states of their trial forces.
    ///
    /// Errors: as [`Self::states_of_guess`].
    pub fn states_asked_by(&mut self, forces: &Multipliers) -> Result<Vec<State>, SolveError> {
        let states = self.states_of_guess(forces)?;
        self.move_to(forces.lambda.clone(), self.point.alpha.clone());
        Ok(self.next_states(&states, &self.judge.gap))
    }

    /// Every contact closed, no node slips.
    pub fn all_closed(&self) -> Vec<State> {
        let blocks = self.setup.admissible.blocks().iter();
        blocks.map(|block| State::sticking(block, true)).collect()
    }

    /// These states, open where the bodies would not overlap without contact forces, at the rigid motions of the last step; `None`
    /// where what is left cannot balance the load.
    ///
    /// A side that is closed far beyond its contact opens from its edge only, by a few nodes in each step.
    pub fn overlapping(&self, states: &[State]) -> Option<Vec<State>> {
        let setup = self.setup;
        let mut overlap = setup.shift.clone();
        let balance = &setup.balance;
        balance.add_transposed(1.0, &self.point.alpha, &mut overlap);
        let of_block = |(state, (block, range)): (&State, (&Block, Range<usize>))| {
            let apart = state.closed && block.is_normal() && overlap[range.start] <= 0.0;
            match apart {
                true => State::sticking(block, false),
                false => state.clone(),
            }
        };
        let both = states.iter().zip(setup.admissible.iter());
        let states: Vec<State> = both.map(of_block).collect();
        let system = System::of(setup, &states, None, self.softness());
        system.carries().then_some(states)
    }

    /// Takes over the forces and states of a coarser problem.
    pub fn begin(&mut self, start: levels::Start) -> Vec<State> {
        self.point.lambda = start.lambda;
        self.point.alpha = start.alpha;
        self.coarse += start.steps;
        self.accuracy = self.accuracy.min(CLOSE);
        start.states
    }

    /// Enters a stage; one that took no step was not tried.
    pub fn stage(&mut self, name: &'static str, run: impl FnOnce(&mut Self) -> Ended) -> Ended {
        self.tried.push(name);
        let before = self.steps;
        let ended = run(self);
        if matches!(ended, Ended::Stuck(_)) && self.steps == before {
            self.tried.pop();
        }
        ended
    }

    /// All linear solves, in solves of this size.
    pub fn iterations(&self) -> usize {
        self.steps + self.coarse.ceil() as usize
    }

    /// Whether the allowed work is used up.
    pub fn exhausted(&self) -> bool {
        let products = self.setup.products() - self.products;
        let enough = self.setup.problem.compliance.enough();
        self.iterations() >= self.most || products >= PRODUCTS.min(enough)
    }

    pub fn softness(&self) -> &[f64] {
        &self.softness
    }

    /// Exact steps within `patience` until the states repeat themselves; `adjust` may change the next states.
    ///
    /// Forces that pass are an answer even where their states are not reproduced: between stiff bodies the rounding of a gap stands
    /// for a force that is not negligible beside those of soft ones. Further steps may be better; if no step is, they are taken back.
    pub fn exact(
        &mut self,
        states: Vec<State>,
        patience: &Patience,
        adjust: &Adjust<'_>,
        observe: Observer<'_>,
    ) -> Ended {
        let mut answer = None;
        let ended = self.steps_on(states, patience, (adjust, &mut answer), observe);
        match (ended, answer) {
            (Ended::Stuck(_), Some((residual, point))) => {
                (self.residual, self.point, self.kind) = (residual, point, 'n');
                self.unique = false;
                Ended::Converged
            }
            (ended, _) => ended,
        }
    }

    /// The steps of [`Self::exact`]; `answer` is the best point that passes.
    fn steps_on(
        &mut self,
        mut states: Vec<State>,
        patience: &Patience,
        (adjust, answer): (&Adjust<'_>, &mut Option<(f64, Forces)>),
        observe: Observer<'_>,
    ) -> Ended {
        let mut seen = HashSet::new();
        let mut last = f64::INFINITY;
        let mut changing = usize::MAX;
        let mut step = 1;
        while step <= patience.steps {
            if self.exhausted() || !self.exact_step(&states) {
                return Ended::Stuck(states);
            }
            if self.tell(observe) {
                return Ended::Stopped;
            }
            let mut next = self.next_states(&states, &self.judge.gap);
            adjust(&mut next, &states);
            let (now, then) = (State::keys(&states), State::keys(&next));
            let same = now == then;
            let passes = self.residual <= self.tolerance;
            if passes && (same || self.residual <= CERTAIN * self.tolerance) {
                return Ended::Converged;
            }
            if passes
                && answer
                    .as_ref()
                    .is_none_or(|(least, _)| self.residual < *least)
            {
                *answer = Some((self.residual, self.point.clone()));
            }
            if same && self.accuracy > finest(self.tolerance) {
                self.accuracy = finer(self.accuracy, self.tolerance);
                step += 1;
                continue;
            }
            let changed = differing(&now, &then);
            let repeated = !seen.insert(now);
            let before = std::mem::replace(&mut last, self.residual);
            let settles =
                changed < std::mem::replace(&mut changing, changed) || self.residual < before;
            let falls = self.residual <= patience.factor * before;
            let turning = State::turning(&states, &self.setup.admissible);
            let turns = turning > 0.0 && self.residual <= turning * before;
            if (repeated || same) && !turns || !falls || step >= patience.settling && !settles {
                return Ended::Stuck(next);
            }
            let enough = (0.1 * self.residual).max(tight(self.tolerance));
            self.accuracy = self.accuracy.min(enough);
            if !(patience.opening && State::only_open(&states, &next)) {
                step += 1;
            }
            states = next;
        }
        Ended::Stuck(states)
    }

    /// Solves for the forces of `states` and judges them; `false` where the system is singular or cannot balance the load.
    pub fn exact_step(&mut self, states: &[State]) -> bool {
        let setup = self.setup;
        let mut system = System::of(setup, states, None, self.softness());
        if !system.carries() {
            return false;
        }
        self.steps += 1;
        self.kind = 'n';
        let solved = system.solve(&self.point, self.accuracy);
        self.unique = system.unique;
        let loose = std::mem::take(&mut system.loose);
        let Some(point) = solved else { return false };
        self.point = point;
        self.drop_rounding();
        self.judge();
        self.drop_forces_of_motion();
        if !loose.is_empty() {
            let mut open = vec![false; setup.len()];
            for (state, (_, range)) in states.iter().zip(setup.admissible.iter()) {
                open[range.start] = !state.closed;
            }
            let gap = &self.judge.gap;
            open_gaps(setup, &loose, gap, |i| open[i], &mut self.point.alpha);
            self.judge();
        }
        true
    }

    /// Forces that are rounding of the largest one, or of the forces of the overlaps, become zero: their signs mean nothing.
    fn drop_rounding(&mut self) {
        let force = largest(self.asked, &self.point.lambda);
        let mut rest = false;
        for (block, range) in self.setup.admissible.iter() {
            let forces = &mut self.point.lambda[range];
            if !block.is_free() && forces[0].abs() <= FORCE_ROUNDING * force {
                forces[0] = 0.0;
                if block.friction().is_some_and(|law| !law.bears(false)) {
                    forces.fill(0.0);
                }
            }
            rest |= forces.iter().any(|own| own.abs() > FORCE_ROUNDING * force);
        }
        // bodies that move along without contact: couples bear rounding
        if !rest {
            self.point.lambda.fill(0.0);
            self.point.product.fill(0.0);
        } else if self.still.contains(&true) {
            self.leave_still();
        }
    }

    /// Where bodies move along without any force, what is left of the forces that parted them is rounding: none are tried, and kept
    /// where they are better.
    fn drop_forces_of_motion(&mut self) {
        let force = largest(0.0, &self.point.lambda);
        let along = force > 0.0 && force <= MOVED_ALONG * self.asked;
        if self.residual <= self.tolerance || !along {
            return;
        }
        let here = (self.residual, self.point.clone());
        self.point.lambda.fill(0.0);
        self.point.product.fill(0.0);
        self.judge();
        if self.residual.is_nan() || self.residual >= here.0 {
            (self.residual, self.point) = here;
            self.judge();
        }
    }

    /// Domains that nothing loads have no forces and do not move: theirs are rounding of those of the others.
    fn leave_still(&mut self) {
        let (setup, still) = (self.setup, &self.still);
        let coupled = &setup.problem.coupled;
        for row in (0..setup.len()).filter(|&row| still[coupled.domain_of(row)]) {
            self.point.lambda[row] = 0.0;
            self.point.product[row] = 0.0;
        }
        let mut alpha = vec![0.0; setup.balance.load().len()];
        setup.balance.to_original(&self.point.alpha, &mut alpha);
        for (mode, alpha) in alpha.iter_mut().enumerate() {
            if still[coupled.domain_of_mode(mode)] {
                *alpha = 0.0;
            }
        }
        setup.balance.from_original(&alpha, &mut self.point.alpha);
    }

    pub fn judge(&mut self) {
        let point = self.point.at(self.setup, self.kind);
        self.residual = self.judge.residual(self.setup, &point);
        if self.residual < self.best.0 {
            self.best = (self.residual, self.point.clone());
        }
    }

    /// Tells the observer; `true` when it is satisfied.
    pub fn tell(&self, observe: Observer<'_>) -> bool {
        let point = self.point.at(self.setup, self.kind);
        tell(observe, self.iterations(), &point, self.residual)
    }

    /// The next states, from the forces of the last step and their gaps (m,). A node whose slip turned against its shear sticks
    /// next: it never flips its direction.
    pub fn next_states(&self, states: &[State], gap: &[f64]) -> Vec<State> {
        self.next_states_of(states, gap, self.softness())
    }

    /// The same by trial forces of the compliance `softness` (m,).
    pub fn next_states_of(&self, states: &[State], gap: &[f64], softness: &[f64]) -> Vec<State> {
        let lambda = &self.point.lambda;
        let blocks = self.setup.admissible.iter();
        let next = |(state, (block, range)): (&State, (&_, Range<usize>))| {
            let trial: Vec<f64> = range
                .clone()
                .map(|i| lambda[i] - gap[i] / softness[i])
                .collect();
            let mut next = State::of_trial(block, &trial);
            if state.closed != next.closed && !block.is_free() {
                // an active contact has no gap, an inactive one no force: rounding of the other must not decide
                let first = range.start;
                let closed = match state.closed {
                    true => lambda[first] > 0.0,
                    false => gap[first] < 0.0,
                };
                if closed == state.closed {
                    next = State {
                        closed,
                        ..state.clone()
                    };
                }
            }
            if let (Shear::Slip { direction, .. }, Shear::Slip { direction: new, .. }) =
                (&state.shear, &next.shear)
                && dot(direction, new) <= 0.0
            {
                next.shear = Shear::Stick;
            }
            next
        };
        states.iter().zip(blocks).map(next).collect()
    }

    /// The point with these forces and amplitudes.
    pub fn at_forces(&mut self, lambda: Vec<f64>, alpha: Vec<f64>) -> Forces {
        let mut product = vec![0.0; lambda.len()];
        self.setup.multiply(&lambda, &mut product);
        Forces {
            lambda,
            alpha,
            product,
        }
    }

    /// Goes to some forces, which no exact step made, and judges them.
    pub fn move_to(&mut self, lambda: Vec<f64>, alpha: Vec<f64>) {
        self.kind = 'p';
        self.point = self.at_forces(lambda, alpha);
        self.judge();
    }

    /// Goes to the point of least residual, where that is near an answer.
    pub fn go_back(&mut self) {
        if self.best.0 < self.residual.min(NEARBY) {
            (self.residual, self.point) = self.best.clone();
            self.kind = 'p';
        }
    }

    pub fn outcome(&self, stopped_by_observer: bool) -> Outcome {
        Outcome {
            iterations: self.iterations(),
            exact: self.kind == 'n',
            stopped_by_observer,
            tried: self.tried.clone(),
            ..self.setup.outcome(&self.point)
        }
    }

    /// No answer: the point of least residual.
    pub fn not_converged(mut self, method: &'static str, reason: &str) -> SolveError {
        self.go_back();
        SolveError::NotConverged {
            method: method.to_string(),
            outcome: Box::new(self.outcome(false)),
            residual: self.residual,
            reason: reason.to_string(),
        }
    }
}

/// Domains whose overlaps and loads are zero, or rounding beside those of others: no forces and no motion are their answer.
fn still(setup: &Setup<'_>) -> Vec<bool> {
    let (problem, load) = (setup.problem, setup.balance.load());
    let coupled = &problem.coupled;
    let mut loaded = vec![0.0f64; coupled.domains()];
    let mut count = |domain: usize, force: f64| loaded[domain] = loaded[domain].max(force.abs());
    for (row, (shift, softness)) in setup.shift.iter().zip(&problem.softness).enumerate() {
        count(coupled.domain_of(row), shift / softness);
    }
    for (mode, load) in load.iter().enumerate() {
        count(coupled.domain_of_mode(mode), *load);
    }
    let all = loaded.iter().copied().fold(0.0, f64::max);
    let is_still = |own: f64| all > 0.0 && own <= UNLOADED * all;
    loaded.into_iter().map(is_still).collect()
}

/// Moves α̂ along its undetermined directions `loose`, by the least norm, until no gap of an `open` contact overlaps.
fn open_gaps(
    setup: &Setup<'_>,
    loose: &[Vec<f64>],
    gap: &[f64],
    open: impl Fn(usize) -> bool,
    alpha: &mut [f64],
) {
    let image = |z: &Vec<f64>| {
        let mut image = vec![0.0; setup.len()];
        setup.balance.add_transposed(1.0, z, &mut image);
        image
    };
    let images: Vec<Vec<f64>> = loose.iter().map(image).collect();
    let mut largest = vec![0.0f64; setup.len()];
    for image in &images {
        let both = largest.iter_mut().zip(image);
        both.for_each(|(largest, x)| *largest = largest.max(x.abs()));
    }
    // A gap that the loose motion does not change is left to the active set.
    let moved: Vec<usize> = (0..setup.len())
        .filter(|&i| open(i) && largest[i] > UNMOVED)
        .collect();
    let bounds: Vec<f64> = moved.iter().map(|&i| gap[i]).collect();
    if bounds.iter().all(|&gap| gap >= 0.0) {
        return;
    }
    let row = |&i: &usize| images.iter().map(|image| image[i]).collect();
    let rows: Vec<Vec<f64>> = moved.iter().map(row).collect();
    if let Some(motion) = least_norm_within(&rows, &bounds, loose.len()) {
        for (motion, z) in motion.iter().zip(loose) {
            for (alpha, z) in alpha.iter_mut().zip(z) {
                *alpha += motion * z;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, DualProblem, Friction};
    use crate::linalg::Mat;
    use crate::solve::Iterate;
    use crate::solve::levels::Start;
    use crate::solve::tests::{apart, applied, by_trial, circle, definite, of, silent};
    use std::ops::ControlFlow;

    fn pressed(m: usize) -> DualProblem {
        let shift: Vec<f64> = (0..m).map(|i| (1.7 * i as f64).cos()).collect();
        let f = Compliance::Dense(definite(m));
        of(f, &shift, vec![Block::Unilateral; m], (&[], &[]))
    }

    fn springs(compliance: &[f64], shift: &[f64], blocks: Vec<Block>) -> DualProblem {
        let m = shift.len();
        let f = Mat::from_fn(m, m, |i, j| if i == j { compliance[i] } else { 0.0 });
        of(Compliance::Dense(f), shift, blocks, (&[], &[]))
    }

    #[test]
    fn accuracy_follows_the_tolerance_between_bounds() {
        assert!((tight(1e-9) / 1e-11 - 1.0).abs() < 1e-15);
        assert_eq!(tight(1e-3), 1e-10);
        assert_eq!(tight(1e-30), 1e-13);
        assert!((finest(1e-9) / 1e-13 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn search_begins_without_forces_and_knows_what_the_overlaps_ask_for() {
        let problem = springs(&[2.0, 0.5], &[3.0, -4.0], vec![Block::Unilateral; 2]);
        let setup = Setup::new(&problem).unwrap();
        let search = Search::new((1e-9, 7), &setup);
        assert_eq!(search.asked, 8.0);
        assert_eq!(search.point.lambda, [0.0, 0.0]);
        assert_eq!(search.accuracy, finest(1e-9));
        assert_eq!(
            (search.tolerance, search.most, search.iterations()),
            (1e-9, 7, 0)
        );
        let of_operator = of(
            applied(&definite(2), definite(2)),
            &[0.0, 0.0],
            vec![Block::Unilateral; 2],
            (&[], &[]),
        );
        let setup = Setup::new(&of_operator).unwrap();
        let search = Search::new((1e-9, 7), &setup);
        assert_eq!((search.asked, search.accuracy), (0.0, BEGINNING));
        // where states repeat themselves forces become accurate step by step
        let [tight, finest] = [tight(1e-9), finest(1e-9)];
        for (accuracy, next) in [
            (IN_PIECES, SETTLED),
            (SETTLED, tight),
            (BEGINNING, tight),
            (tight, finest),
            (finest, finest),
        ] {
            assert_eq!(finer(accuracy, 1e-9), next);
        }
    }

    #[test]
    fn work_that_is_allowed_counts_steps_and_products_since_the_search_began() {
        let problem = pressed(3);
        let setup = Setup::new(&problem).unwrap();
        setup.count(5000);
        let mut search = Search::new((1e-9, 7), &setup);
        assert!(!search.exhausted());
        setup.count(2999);
        assert!(!search.exhausted());
        setup.count(1);
        assert!(search.exhausted());
        let setup = Setup::new(&problem).unwrap();
        search = Search::new((1e-9, 7), &setup);
        search.steps = 6;
        assert!(!search.exhausted());
        search.steps = 7;
        assert!(search.exhausted());
    }

    #[test]
    fn coarser_problem_gives_forces_states_and_its_share_of_steps() {
        let problem = pressed(2);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-4, 50), &setup);
        let states = search.all_closed();
        assert_eq!(State::keys(&states), [(true, 0); 2]);
        search.accuracy = 1e-2;
        let start = |accuracy: f64, search: &mut Search<'_>| {
            search.accuracy = accuracy;
            search.begin(Start {
                lambda: vec![1.0, 2.0],
                alpha: Vec::new(),
                states: vec![State::sticking(&Block::Unilateral, false); 2],
                solved: true,
                steps: 1.2,
            })
        };
        let states = start(1e-2, &mut search);
        assert_eq!(State::keys(&states), [(false, 0); 2]);
        assert_eq!((search.accuracy, search.iterations()), (1e-9, 2));
        assert_eq!(search.point.lambda, [1.0, 2.0]);
        search.steps = 3;
        start(1e-12, &mut search);
        // 3 + 2.4
        assert_eq!((search.accuracy, search.iterations()), (1e-12, 6));
    }

    #[test]
    fn steps_begin_where_bodies_overlap_without_contact_forces() {
        // two contacts of a body that floats, moved by its last amplitude, and a shear that slips
        let blocks = vec![
            Block::Unilateral,
            Block::Unilateral,
            Block::Interval { bound: 0.5 },
        ];
        let compliance = Compliance::Dense(definite(3));
        let problem = of(
            compliance,
            &[-1.0, -3.0, -1.0],
            blocks,
            (&[vec![1.0, 1.0, 0.0]], &[2.0]),
        );
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-9, 7), &setup);
        let mut states = search.all_closed();
        states[2].shear = Shear::Slip {
            direction: vec![1.0],
            share: 0.5,
        };
        let slip = states[2].clone();
        let closed = |states: Vec<State>| {
            assert_eq!(states[2], slip);
            states.iter().map(|s| s.closed).collect::<Vec<_>>()
        };
        for (amplitude, expected) in [
            (4.0, Some(vec![true, true, true])),
            (2.0, Some(vec![true, false, true])),
            // nothing would bear the load
            (0.0, None),
        ] {
            setup
                .balance
                .from_original(&[amplitude], &mut search.point.alpha);
            assert_eq!(search.overlapping(&states).map(&closed), expected);
        }
    }

    #[test]
    fn exact_steps_end_with_the_forces_that_trial_finds() {
        let problem = pressed(9);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-10, 50), &setup);
        let mut shown = Vec::new();
        let mut observe = |at: &Iterate<'_>| {
            shown.push((at.iteration, at.step));
            ControlFlow::Continue(())
        };
        let patience = Patience::new(20, f64::INFINITY);
        let closed = search.all_closed();
        let ended = search.exact(closed, &patience, &|_, _| {}, &mut observe);
        assert!(matches!(ended, Ended::Converged) && search.unique);
        let expected = by_trial(&definite(9), &problem.shift, (&[], &[]));
        assert!(apart(&search.point.lambda, &expected.lambda) < 1e-13);
        let numbered: Vec<(usize, char)> = (1..=search.steps).map(|k| (k, 'n')).collect();
        assert_eq!(shown, numbered);
        assert!((2..8).contains(&search.steps), "{}", search.steps);
        let outcome = search.outcome(false);
        assert!(outcome.exact && !outcome.stopped_by_observer);
        assert_eq!(outcome.iterations, search.steps);
    }

    #[test]
    fn patience_and_observers_end_exact_steps() {
        let problem = pressed(9);
        let setup = Setup::new(&problem).unwrap();
        let ended = |patience: Patience, most: usize, observe: Observer<'_>| {
            let mut search = Search::new((1e-10, most), &setup);
            let closed = search.all_closed();
            let ended = search.exact(closed, &patience, &|_, _| {}, observe);
            (ended, search.steps)
        };
        // the residual of the first step is no less than anything
        let (end, steps) = ended(Patience::new(1, f64::INFINITY), 50, &mut silent);
        let Ended::Stuck(next) = end else {
            panic!("one step does");
        };
        assert_eq!(steps, 1);
        assert!(
            State::keys(&next).contains(&(false, 0)),
            "the states that come next"
        );
        let (end, steps) = ended(Patience::new(20, 1e-9), 50, &mut silent);
        assert!(matches!(end, Ended::Stuck(_)) && steps == 2, "{steps}");
        let (end, steps) = ended(Patience::new(20, f64::INFINITY), 2, &mut silent);
        assert!(matches!(end, Ended::Stuck(_)) && steps == 2, "{steps}");
        let mut satisfied = |_: &Iterate<'_>| ControlFlow::Break(());
        let (end, steps) = ended(Patience::new(20, f64::INFINITY), 50, &mut satisfied);
        assert!(matches!(end, Ended::Stopped) && steps == 1);
    }

    #[test]
    fn steps_that_change_no_fewer_states_end_where_they_are_to_settle() {
        let problem = circle();
        let setup = Setup::new(&problem).unwrap();
        let steps = |patience: Patience| {
            let mut search = Search::new((1e-10, 50), &setup);
            let closed = search.all_closed();
            let ended = search.exact(closed, &patience, &|_, _| {}, &mut silent);
            assert!(matches!(ended, Ended::Stuck(_)));
            search.steps
        };
        let plain = || Patience::new(20, f64::INFINITY);
        let found = [2, 4, 20].map(|from| steps(plain().settling(from)));
        assert!(found[0] < found[2], "{found:?}");
        assert!(found[0] >= 2 && found[1] >= 4, "{found:?}");
        assert_eq!(found[2], steps(plain()), "{found:?}");
    }

    #[test]
    fn a_node_that_is_wrong_when_states_have_settled_is_told_by_the_first_step() {
        let problem = pressed(9);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-10, 50), &setup);
        let closed = search.all_closed();
        let plain = Patience::new(20, f64::INFINITY);
        let ended = search.exact(closed, &plain, &|_, _| {}, &mut silent);
        assert!(matches!(ended, Ended::Converged));
        let answer = search.next_states(
            &State::of_all_forces(&setup.admissible, &search.point.lambda),
            &search.judge.gap,
        );
        let edge = answer.iter().position(|state| !state.closed).unwrap();
        let mut wrong = answer.clone();
        wrong[edge] = State::sticking(&Block::Unilateral, true);

        let mut search = Search::new((1e-10, 50), &setup);
        let mut settled = Settled::default();
        let first = settled.exact(&mut search, wrong.clone(), 2, &mut silent);
        assert!(first.is_none() && search.steps == 0, "once is not settled");
        let second = settled.exact(&mut search, wrong, 2, &mut silent);
        assert!(matches!(second, Some(Ended::Converged)));
        assert_eq!(search.steps, 2);

        // where two are wrong the search is unchanged, and the same states are not tried again
        let far: Vec<State> = answer
            .iter()
            .map(|state| State::sticking(&Block::Unilateral, !state.closed))
            .collect();
        let mut search = Search::new((1e-10, 50), &setup);
        let mut settled = Settled::default();
        let here = search.point.lambda.clone();
        let ended = settled.exact(&mut search, far.clone(), 1, &mut silent);
        assert!(ended.is_none() && search.steps == 1);
        assert_eq!(search.point.lambda, here);
        let ended = settled.exact(&mut search, far, 1, &mut silent);
        assert!(ended.is_none() && search.steps == 1);
    }

    #[test]
    fn guess_that_cannot_balance_the_load_is_no_step() {
        let problem = of(
            Compliance::Dense(definite(2)),
            &[0.1, 0.1],
            vec![Block::Unilateral; 2],
            (&[vec![1.0, 1.0]], &[2.0]),
        );
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-10, 50), &setup);
        let open = vec![State::sticking(&Block::Unilateral, false); 2];
        assert!(!search.exact_step(&open));
        assert_eq!(search.steps, 0);
        let closed = search.all_closed();
        assert!(search.exact_step(&closed));
        assert_eq!(search.steps, 1);
        assert!(search.residual < 1e-12 && search.best.0 == search.residual);
    }

    #[test]
    fn forces_that_are_rounding_are_none() {
        let coulomb = Friction::Coulomb { coefficient: 0.5 }.block(1);
        let tresca = Friction::Tresca { bound: 1.0 }.block(1);
        let blocks = vec![
            Block::Unilateral,
            Block::Unilateral,
            coulomb,
            tresca,
            Block::Free { size: 1 },
        ];
        let problem = springs(&[1.0; 7], &[2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], blocks);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-10, 50), &setup);
        // the overlap asks for 2, the largest force is 4
        let small = 3.9e-14;
        search.point.lambda = vec![-small, 4.2e-14, small, 1.0, small, 1.0, small];
        search.point.lambda[3] = 4.0;
        search.point.product = vec![1.0; 7];
        search.drop_rounding();
        let kept = [0.0, 4.2e-14, 0.0, 0.0, 0.0, 1.0, small];
        assert_eq!(search.point.lambda, kept);
        assert_eq!(search.point.product, [1.0; 7]);
        // without other forces the forces of the overlaps decide, and no force causes no displacement
        search.point.lambda = vec![1.9e-14, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        search.drop_rounding();
        assert_eq!(search.point.lambda, [0.0; 7]);
        assert_eq!(search.point.product, [0.0; 7]);
        search.point.lambda = vec![2.1e-14, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        search.drop_rounding();
        assert_eq!(search.point.lambda[0], 2.1e-14);
    }

    #[test]
    fn rounding_of_the_other_does_not_change_a_state() {
        let problem = springs(&[1.0; 4], &[0.0; 4], vec![Block::Unilateral; 4]);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-10, 50), &setup);
        let state = |closed| State::sticking(&Block::Unilateral, closed);
        let states = [true, true, false, false].map(state);
        // closed ones with a force whatever their gap is, open ones with a gap whatever their force is
        search.point.lambda = vec![1e-9, 0.0, 1.0, 1.0];
        let next = search.next_states(&states, &[1.0, 1.0, 0.5, -0.5]);
        assert_eq!(next.map_closed(), [true, false, false, true]);
        let next = search.next_states(&states, &[1.0, 1.0, 0.0, 1e-3]);
        assert_eq!(next.map_closed(), [true, false, false, false]);
    }

    trait Closed {
        fn map_closed(&self) -> Vec<bool>;
    }

    impl Closed for Vec<State> {
        fn map_closed(&self) -> Vec<bool> {
            self.iter().map(|state| state.closed).collect()
        }
    }

    #[test]
    fn slip_that_turns_against_its_shear_sticks_first() {
        let block = Friction::Coulomb { coefficient: 0.5 }.block(1);
        let problem = springs(&[1.0, 2.0], &[0.0; 2], vec![block]);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-10, 50), &setup);
        search.point.lambda = vec![2.0, 1.0];
        let slip = |sign: f64| State {
            closed: true,
            shear: Shear::Slip {
                direction: vec![sign],
                share: 0.5,
            },
            excess: 0.0,
            normal: 0.0,
        };
        // the trial shear is 1 − gap/2
        let next =
            |state: State, gap: f64| search.next_states(&[state], &[0.0, gap]).remove(0).shear;
        let ahead = Shear::Slip {
            direction: vec![1.0],
            share: 0.5,
        };
        assert_eq!(next(slip(1.0), -2.0), ahead);
        assert_eq!(next(slip(-1.0), -2.0), Shear::Stick);
        assert_eq!(next(State::sticking(&block, true), -2.0), ahead);
        assert_eq!(next(slip(1.0), 1.0), Shear::Stick);
    }

    #[test]
    fn best_forces_come_back_where_they_are_near_an_answer() {
        let problem = pressed(2);
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-10, 50), &setup);
        search.move_to(vec![1.0, 1.0], Vec::new());
        let best = search.residual;
        assert_eq!(search.kind, 'p');
        search.move_to(vec![50.0, 1.0], Vec::new());
        assert!(search.residual > best && search.best.0 == best);
        search.kind = 'n';
        // far from an answer: stays
        assert!(best > NEARBY);
        search.go_back();
        assert_eq!((search.point.lambda[0], search.kind), (50.0, 'n'));
        search.best.0 = 0.9 * NEARBY;
        search.go_back();
        assert_eq!(search.point.lambda, [1.0, 1.0]);
        assert_eq!((search.residual, search.kind), (0.9 * NEARBY, 'p'));
        let SolveError::NotConverged {
            outcome,
            residual,
            reason,
            ..
        } = search.not_converged("newton", "because")
        else {
            panic!("another error");
        };
        assert_eq!((residual, reason.as_str()), (0.9 * NEARBY, "because"));
        assert!(!outcome.exact && outcome.multipliers.lambda == [1.0, 1.0]);
    }

    #[test]
    fn loose_motion_is_the_least_that_opens_what_overlaps() {
        let modes = [vec![1.0, 1.0, 1.0], vec![-1.0, 0.0, 1.0]];
        let problem = of(
            Compliance::Dense(definite(3)),
            &[0.0; 3],
            vec![Block::Unilateral; 3],
            (&modes, &[0.0, 0.0]),
        );
        let setup = Setup::new(&problem).unwrap();
        let loose = [vec![1.0, 0.0], vec![0.0, 1.0]];
        let moved = |gap: [f64; 3], open: [bool; 3]| {
            let mut alpha = vec![0.0; 2];
            open_gaps(&setup, &loose, &gap, |i| open[i], &mut alpha);
            let mut after = gap;
            setup.balance.add_transposed(-1.0, &alpha, &mut after);
            (alpha, after)
        };
        let (alpha, _) = moved([0.0, 0.5, 0.1], [true; 3]);
        assert_eq!(alpha, [0.0, 0.0]);
        // closed contacts are not considered
        let (alpha, _) = moved([-1.0, 0.5, 0.1], [false, true, true]);
        assert_eq!(alpha, [0.0, 0.0]);
        let (alpha, after) = moved([-1.0, 2.0, 2.0], [true; 3]);
        assert!(
            after[0].abs() < 1e-12 && after[1] > 0.0 && after[2] > 0.0,
            "{after:?}"
        );
        // the shortest way to one plane is along its normal
        let mut normal = [0.0; 2];
        for (j, normal) in normal.iter_mut().enumerate() {
            let mut image = vec![0.0; 3];
            setup.balance.add_transposed(1.0, &loose[j], &mut image);
            *normal = image[0];
        }
        assert!((alpha[0] * normal[1] - alpha[1] * normal[0]).abs() < 1e-12);
    }
}
