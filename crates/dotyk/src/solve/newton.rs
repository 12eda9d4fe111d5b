//! Newton's method on what contact nodes do: one linear problem for each guess of states, and a way that cannot cycle.
//!
//! *Exact steps* solve for the forces of the guessed states and guess anew from what comes out (primal-dual active sets).
//! From a good start they are finite and exact after a few; on general compliances they may run in circles.
//!
//! *Proximal steps* solve, for a centre λ_c and a small compliance a beside F,
//!
//! ```text
//!   min 1/2 λᵀFλ − dᵀλ + 1/2 (λ − λ_c)ᵀa(λ − λ_c)   over λ ∈ Λ, Ĝλ = ê
//! ```
//!
//! whose minimiser is the next centre, with a smaller each time. Its dual is a convex, once differentiable function of the
//! displacements, here written with forces μ that cause them and rigid amplitudes α̂,
//!
//! ```text
//!   φ(μ, α̂) = 1/2 μᵀFμ − ê·α̂ + 1/2 |λ_c − gap/a|²_a − 1/2 |λ_c − gap/a − λ|²_a,   λ = P_Λ(λ_c − gap/a),
//! ```
//!
//! Newton's direction is the linear problem of the states of the trial forces λ_c − gap/a, and the exact minimum along it is
//! the zero of a monotone function of one variable, at the cost of no further product. φ falls in every step, so that no
//! guess comes back; where no contact holds a body the load moves it until one does, without a linear solve. Redundant
//! contacts do no harm: F + a is definite.
//!
//! Starting points: those of the caller, else, where there are many contacts, a coarser problem (`levels.rs`). Problems with Coulomb's law, which minimise
//! nothing, go to `slip.rs`.
//!
//! As described in Hintermüller, Ito & Kunisch (2003) for the exact steps; Rockafellar (1976) for the proximal point and
//! augmented Lagrangian methods, and the semismooth Newton methods on them since.

use std::collections::HashSet;
use std::ops::{ControlFlow, Range};

use crate::dual::{Block, Compliance, DualProblem, Multipliers, least_norm_within};
use crate::solve::levels::local_softness;
use crate::solve::proximal::{Progress, Proximal};
use crate::solve::states::{Shear, State, unknowns};
use crate::solve::system::{Forces, System};
use crate::solve::{
    ContactSolver, FixedBounds, Iterate, Judge, Observer, Outcome, Setup, SolveError, dot, levels,
    loaded, slip,
};

/// How long exact steps may go on.
pub(crate) struct Patience {
    /// Most steps.
    pub steps: usize,
    /// Each residual is to be at most this part of the one before.
    pub factor: f64,
}

/// One step from all contacts closed, more where there is no coarser problem; none is asked for with fewer blocks than the
/// following. And steps that are near the answer.
const ONE: Patience = Patience {
    steps: 1,
    factor: 1.0,
};
const PLAIN: Patience = Patience {
    steps: 7,
    factor: f64::INFINITY,
};
const SMALL: usize = 96;
pub(crate) const NEAR: Patience = Patience {
    steps: 6,
    factor: 0.5,
};

/// First compliance of proximal steps, relative to what a contact gives way between its neighbours, and by how much it falls
/// from centre to centre.
const FIRST: f64 = 0.3;
const FALL: f64 = 1e-2;

/// Smallest compliance of proximal steps: below, rounding decides.
const LEAST: f64 = 1e-10;

/// Centres without a residual of half the size that end the search.
const PATIENCE: usize = 4;

/// Most products with a compliance that is not assembled, several times those of large problems: where these do not do, the
/// problem is too badly conditioned for iterations within a step.
const PRODUCTS: usize = 3000;

/// Residuals that are near an answer.
pub(crate) const NEARBY: f64 = 1e-2;

/// Shears of a starting point slip within this part of their bounds.
const AT_BOUND: f64 = 1e-9;

/// Accuracy of iterations within a step where the start is good: rougher forces would spoil it.
const CLOSE: f64 = 1e-9;

/// Forces below this part of the largest are rounding of the linear solves.
const ROUNDING: f64 = 1e-14;

/// Newton's method.
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    /// Residual below which an answer is accepted.
    pub tolerance: f64,
    /// Most linear solves on the problem itself.
    pub max_iterations: usize,
}

impl Default for Newton {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            max_iterations: 200,
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
        if setup.admissible.has_coulomb() {
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
        let mut search = Search::new(self, setup);
        let ended = match guess {
            Some(guess) => {
                let states = search.states_of_guess(guess)?;
                search.start_near(states, observe)
            }
            None => search.start_anywhere(observe),
        };
        match ended {
            Ended::Converged => Ok(search.outcome(false)),
            Ended::Stopped => Ok(search.outcome(true)),
            Ended::Stuck(_) => {
                Err(search.not_converged("the residual did not fall below the tolerance"))
            }
        }
    }
}

/// How a phase ended.
pub(crate) enum Ended {
    Converged,
    Stopped,
    /// No answer; the states that come next.
    Stuck(Vec<State>),
}

/// Accuracy of iterations within a step at the end.
fn tight(method: &Newton) -> f64 {
    (1e-2 * method.tolerance).clamp(1e-13, 1e-10)
}

/// Accuracy where that does not do: in many contacts the error of one is small beside that of all.
pub(crate) fn finest(method: &Newton) -> f64 {
    1e-2 * tight(method)
}

/// The iterate and its history.
pub(crate) struct Search<'a> {
    pub method: &'a Newton,
    pub setup: &'a Setup<'a>,
    pub point: Forces,
    pub judge: Judge,
    pub residual: f64,
    /// The least residual so far, and where it was.
    pub best: (f64, Forces),
    /// Largest force that the overlaps ask for.
    asked: f64,
    /// Linear solves on the problem itself.
    pub steps: usize,
    /// Those on coarser problems, in solves of this size.
    coarse: f64,
    pub products: usize,
    /// Relative accuracy asked of iterations within a step.
    accuracy: f64,
    /// What the last step was: exact ('n') or proximal ('p').
    pub kind: char,
    /// The states of the last exact step determine its forces.
    pub unique: bool,
}

impl<'a> Search<'a> {
    /// Begins without any force.
    pub fn new(method: &'a Newton, setup: &'a Setup<'a>) -> Self {
        // the forces that the overlaps ask for: what is rounding of these is none, whatever the solution
        let asked = setup.problem.shift.iter().zip(&setup.problem.softness);
        let force = asked.fold(0.0, |s: f64, (d, c)| s.max((d / c).abs()));
        Self {
            method,
            setup,
            point: Forces::none(setup),
            judge: setup.judge(),
            residual: f64::INFINITY,
            best: (f64::INFINITY, Forces::none(setup)),
            asked: if force.is_finite() { force } else { 0.0 },
            steps: 0,
            coarse: 0.0,
            products: 0,
            kind: 'n',
            unique: false,
            accuracy: match setup.problem.compliance {
                Compliance::Dense(_) | Compliance::Sparse(_) => finest(method),
                Compliance::Operator { .. } => 1e-2,
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
        let state = |(block, range): (&_, Range<usize>)| {
            let mut trial = self.point.lambda[range].to_vec();
            trial[1..].iter_mut().for_each(|t| *t *= 1.0 + AT_BOUND);
            State::of_trial(block, &trial)
        };
        Ok(self.setup.admissible.iter().map(state).collect())
    }

    /// Every contact closed, none slips.
    pub fn all_closed(&self) -> Vec<State> {
        let blocks = self.setup.admissible.blocks().iter();
        blocks.map(|block| State::sticking(block, true)).collect()
    }

    /// Takes over the forces and states of a coarser problem.
    pub fn begin(&mut self, start: levels::Start) -> Vec<State> {
        self.point.lambda = start.lambda;
        self.point.alpha = start.alpha;
        self.coarse += start.steps;
        self.products += start.products;
        self.accuracy = self.accuracy.min(CLOSE);
        start.states
    }

    /// All linear solves, in solves of this size.
    pub fn iterations(&self) -> usize {
        self.steps + self.coarse.ceil() as usize
    }

    /// Whether the work allowed is done.
    pub fn exhausted(&self) -> bool {
        self.steps >= self.method.max_iterations || self.products >= PRODUCTS
    }

    pub fn softness(&self) -> &'a [f64] {
        &self.setup.problem.softness
    }

    /// Exact steps from a start that is thought to be near, then proximal ones from it: steps that led nowhere are taken
    /// back.
    fn start_near(&mut self, states: Vec<State>, observe: Observer<'_>) -> Ended {
        let start = (states.clone(), self.point.clone());
        match self.exact(states, &NEAR, &|_, _| {}, observe) {
            Ended::Stuck(_) => {
                self.point = start.1;
                self.proximal(start.0, observe)
            }
            ended => ended,
        }
    }

    /// Exact steps from all contacts closed; then, where there are many, from a coarser problem.
    fn start_anywhere(&mut self, observe: Observer<'_>) -> Ended {
        let setup = self.setup;
        let mut ended = Ended::Stuck(self.all_closed());
        let small = setup.admissible.blocks().len() < SMALL;
        if !small {
            ended = self.exact(self.all_closed(), &ONE, &|_, _| {}, observe);
            if !matches!(ended, Ended::Stuck(_)) {
                return ended;
            }
            let coarse = levels::start(setup, &|method, coarse, tell| {
                method.run(coarse, None, tell)
            });
            if let Some(start) = coarse {
                let states = self.begin(start);
                return self.start_near(states, observe);
            }
        }
        if let Ended::Stuck(states) = ended {
            ended = self.exact(states, &PLAIN, &|_, _| {}, observe);
        }
        match ended {
            Ended::Stuck(states) => {
                self.point.lambda.fill(0.0);
                self.proximal(states, observe)
            }
            ended => ended,
        }
    }

    // Exact steps

    /// Exact steps while there is patience, until the states repeat themselves; `adjust` may change those that come next.
    pub fn exact(
        &mut self,
        mut states: Vec<State>,
        patience: &Patience,
        adjust: &dyn Fn(&mut Vec<State>, &[State]),
        observe: Observer<'_>,
    ) -> Ended {
        let mut seen = HashSet::new();
        let mut last = f64::INFINITY;
        for _ in 0..patience.steps {
            if self.exhausted() || !self.exact_step(&states) {
                return Ended::Stuck(states);
            }
            if self.tell(observe) {
                return Ended::Stopped;
            }
            let mut next = self.next_states(&states, &self.judge.gap);
            adjust(&mut next, &states);
            let key = |states: &[State]| states.iter().map(State::key).collect::<Vec<_>>();
            let (now, then) = (key(&states), key(&next));
            let same = now == then;
            let passes = self.residual <= self.method.tolerance;
            if passes && (same || self.residual <= 1e-3 * self.method.tolerance) {
                return Ended::Converged;
            }
            if same && self.accuracy > finest(self.method) {
                self.accuracy = match self.accuracy > tight(self.method) {
                    true => tight(self.method),
                    false => finest(self.method),
                };
                continue;
            }
            let repeated = !seen.insert(now);
            if repeated && passes {
                return Ended::Converged;
            }
            let before = std::mem::replace(&mut last, self.residual);
            let falls = self.residual <= patience.factor * before;
            // in space the directions of slip go on turning in the same states
            let turns = states.iter().any(State::may_turn) && self.residual <= 0.5 * before;
            if (repeated || same) && !turns || !falls {
                return Ended::Stuck(next);
            }
            let enough = (0.1 * self.residual).max(tight(self.method));
            self.accuracy = self.accuracy.min(enough);
            states = next;
        }
        Ended::Stuck(states)
    }

    /// Solves for the forces of `states` and judges them; `false` where the system is singular or cannot balance the load.
    pub fn exact_step(&mut self, states: &[State]) -> bool {
        let setup = self.setup;
        let mut offset = vec![0.0; setup.len()];
        let list = unknowns(
            &setup.admissible,
            states,
            None,
            self.softness(),
            &mut offset,
        );
        let mut system = System::new(setup, &list, &offset);
        if !system.carries() {
            return false;
        }
        self.steps += 1;
        self.kind = 'n';
        let solved = system.solve(&self.point, self.accuracy);
        self.products += system.products;
        self.unique = system.unique;
        let loose = std::mem::take(&mut system.loose);
        let Some(point) = solved else { return false };
        self.point = point;
        self.drop_rounding();
        self.judge();
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

    /// Forces that are rounding of the largest one, or of what the overlaps ask for, are none: their signs mean nothing.
    fn drop_rounding(&mut self) {
        let largest = |s: f64, force: &f64| s.max(force.abs());
        let force = self.point.lambda.iter().fold(self.asked, largest);
        let mut rest = false;
        for (block, range) in self.setup.admissible.iter() {
            let forces = &mut self.point.lambda[range];
            if !matches!(block, Block::Free { .. }) && forces[0].abs() <= ROUNDING * force {
                forces[0] = 0.0;
                if matches!(block, Block::Coulomb { .. }) {
                    forces.fill(0.0);
                }
            }
            rest |= forces.iter().any(|force| *force != 0.0);
        }
        if !rest {
            self.point.product.fill(0.0);
        }
    }

    pub fn judge(&mut self) {
        let Forces {
            lambda,
            alpha,
            product,
        } = &self.point;
        let components = &self.setup.components;
        self.residual = self
            .judge
            .residual(self.setup, components, lambda, product, alpha);
        if self.residual < self.best.0 {
            self.best = (self.residual, self.point.clone());
        }
    }

    /// Tells the observer; `true` when it is satisfied.
    pub fn tell(&self, observe: Observer<'_>) -> bool {
        let iterate = Iterate {
            iteration: self.iterations(),
            lambda: &self.point.lambda,
            residual: self.residual,
            active: loaded(&self.point.lambda),
            step: self.kind,
        };
        observe(&iterate) == ControlFlow::Break(())
    }

    /// States that the forces of the last step and their gaps (m,) ask for. A node whose slip turned against its shear sticks
    /// next: it never flips its direction.
    pub fn next_states(&self, states: &[State], gap: &[f64]) -> Vec<State> {
        let (lambda, softness) = (&self.point.lambda, self.softness());
        let blocks = self.setup.admissible.iter();
        let next = |(state, (block, range)): (&State, (&_, Range<usize>))| {
            let trial: Vec<f64> = range
                .clone()
                .map(|i| lambda[i] - gap[i] / softness[i])
                .collect();
            let mut next = State::of_trial(block, &trial);
            if state.closed != next.closed && !matches!(block, Block::Free { .. }) {
                // an active contact has no gap, an inactive one no force: rounding of the other must not decide
                let first = range.start;
                let closed = if state.closed {
                    lambda[first] > 0.0
                } else {
                    gap[first] < 0.0
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

    // Proximal steps

    /// Proximal steps from `states`, each ended by an exact one; φ falls in every step.
    fn proximal(&mut self, states: Vec<State>, observe: Observer<'_>) -> Ended {
        let setup = self.setup;
        let mut centre = vec![0.0; setup.len()];
        setup.admissible.project(&self.point.lambda, &mut centre);
        let mut at = self.at_forces(centre.clone(), self.point.alpha.clone());
        let mut guessed = Some(states);
        let local = local_softness(setup);
        let (mut part, mut best, mut still) = (FIRST, f64::INFINITY, 0);
        loop {
            let compliance = local.iter().map(|c| part * c).collect();
            let mut proximal = Proximal::new(setup, centre, compliance, at);
            loop {
                if self.exhausted() {
                    return Ended::Stuck(proximal.states());
                }
                let progress = proximal.step(guessed.take(), self.accuracy);
                self.products += std::mem::take(&mut proximal.products);
                self.steps += 1;
                self.kind = 'p';
                self.show(&proximal);
                if self.tell(observe) {
                    return Ended::Stopped;
                }
                match progress {
                    Progress::Moved => {}
                    Progress::Minimal | Progress::Rough if self.accuracy > tight(self.method) => {
                        self.accuracy = (1e-3 * self.accuracy).max(tight(self.method));
                    }
                    Progress::Minimal | Progress::Rough | Progress::Singular => break,
                }
            }
            let states = proximal.states();
            centre = proximal.forces();
            at = proximal.at;
            let alpha = at.alpha.clone();
            // the exact forces of these states, where they are the answer; else a good place to go on from: there the closed
            // contacts have no gap
            if self.exact_step(&states) {
                if self.tell(observe) {
                    return Ended::Stopped;
                }
                if self.residual <= self.method.tolerance {
                    return Ended::Converged;
                }
                at = self.point.clone();
            }
            self.move_to(centre.clone(), alpha);
            if self.residual <= self.method.tolerance {
                return Ended::Converged;
            }
            still = if self.residual < 0.5 * best {
                0
            } else {
                still + 1
            };
            best = best.min(self.residual);
            if still > PATIENCE {
                return Ended::Stuck(states);
            }
            part = (part * FALL).max(LEAST);
        }
    }

    /// The point of some forces.
    fn at_forces(&mut self, lambda: Vec<f64>, alpha: Vec<f64>) -> Forces {
        let mut product = vec![0.0; lambda.len()];
        self.setup.problem.compliance.apply(&lambda, &mut product);
        self.products += 1;
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

    /// Judges where a proximal problem is; its forces cause its displacements at its minimum.
    fn show(&mut self, proximal: &Proximal<'_>) {
        self.point = Forces {
            lambda: proximal.forces(),
            ..proximal.at.clone()
        };
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
            multipliers: self
                .setup
                .multipliers(&self.point.lambda, &self.point.alpha),
            iterations: self.iterations(),
            products: self.products,
            rho: None,
            bolts: Vec::new(),
            exact: self.kind == 'n',
            stopped_by_observer,
            fixed_point: None,
            remarks: Vec::new(),
        }
    }

    /// No answer: the point of least residual.
    fn not_converged(mut self, reason: &str) -> SolveError {
        self.go_back();
        SolveError::NotConverged {
            method: Newton::NAME,
            outcome: Box::new(self.outcome(false)),
            residual: self.residual,
            reason: reason.to_string(),
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
        .filter(|&i| open(i) && largest[i] > 1e-12)
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
