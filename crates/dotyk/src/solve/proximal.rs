//! The proximal problem of Newton's method and its steps: an energy φ of displacements that falls in every one.
//!
//! ```text
//!   φ(μ, α̂) = 1/2 μᵀFμ − ê·α̂ + 1/2 |z|²_a − 1/2 |z − λ|²_a,     z = λ_c − gap/a,   λ = P_Λ(z),   gap = Fμ − d − Ĝᵀα̂
//!   dφ = (μ − λ)·F dμ + (Ĝλ − ê)·dα̂
//! ```
//!
//! φ is convex, and its derivative along a line is monotone: the exact step is its zero. At the minimum F(μ − λ) = 0 and
//! Ĝλ = ê, so that λ solves the problem with F + a and d + aλ_c.

use crate::solve::exact::{Ended, Search, tight};
use crate::solve::levels::local_softness;
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::{Anchor, State};
use crate::solve::system::System;
use crate::solve::{Observer, dot, norm};

/// First compliance, relative to that of a contact between its neighbours, and the factor by which it falls from centre to
/// centre.
const FIRST: f64 = 0.3;
const FALL: f64 = 1e-2;

/// Smallest compliance: below, rounding decides.
const LEAST_PROXIMAL: f64 = 1e-10;

/// Centres without a residual of half the size that end the search.
const PROXIMAL_PATIENCE: usize = 4;

/// An imbalance below this part of the forces is rounding.
const BALANCED: f64 = 1e-11;

/// Factor of the accuracy of iterations within a step where rough ones led nowhere.
const FINER: f64 = 1e-3;

/// First try of how far a body moves until contacts bear its load, in the length of the problem: doubled until it does.
const NUDGE: f64 = 1e-3;

/// The zero along a line is found to this part of the first slope, or of its place: the rounding of either.
const FLAT_ENOUGH: f64 = 1e-13;
const SHORT_ENOUGH: f64 = 1e-15;

/// A slope below this part of the first one ends a search along a line.
const FLAT_SLOPE: f64 = 1e-10;

/// φ is minimal where the slope is below this part of the steepest one of this centre, or is rounding of its terms.
const GAINED: f64 = 1e-9;
const SLOPE_ROUNDING: f64 = 1e-14;

/// A step by a smaller part of the way counts as a standstill.
const STANDING: f64 = 1e-9;

/// Proximal steps from `states`, each ended by an exact one; φ falls in every step.
pub(crate) fn proximal_steps(
    search: &mut Search<'_>,
    states: Vec<State>,
    observe: Observer<'_>,
) -> Ended {
    let setup = search.setup;
    let mut centre = vec![0.0; setup.len()];
    setup.admissible.project(&search.point.lambda, &mut centre);
    let mut at = search.at_forces(centre.clone(), search.point.alpha.clone());
    let mut guessed = Some(states);
    let local = local_softness(setup);
    let (mut part, mut best, mut still) = (FIRST, f64::INFINITY, 0);
    loop {
        let compliance = local.iter().map(|c| part * c).collect();
        let mut proximal = Proximal::new(setup, centre, compliance, at);
        loop {
            if search.exhausted() {
                return Ended::Stuck(proximal.states());
            }
            let progress = proximal.step(guessed.take(), search.accuracy);
            search.steps += 1;
            search.kind = 'p';
            show(search, &proximal);
            if search.tell(observe) {
                return Ended::Stopped;
            }
            match progress {
                Progress::Moved => {}
                Progress::Minimal | Progress::Rough
                    if search.accuracy > tight(search.tolerance) =>
                {
                    search.accuracy = (FINER * search.accuracy).max(tight(search.tolerance));
                }
                Progress::Minimal | Progress::Rough | Progress::Singular => break,
            }
        }
        let states = proximal.states();
        centre = proximal.forces();
        at = proximal.at;
        let alpha = at.alpha.clone();
        // the exact forces of these states may be the answer; else they are a good point to go on from: there the closed
        // contacts have no gap
        if search.exact_step(&states) {
            if search.tell(observe) {
                return Ended::Stopped;
            }
            if search.residual <= search.tolerance {
                return Ended::Converged;
            }
            at = search.point.clone();
        }
        search.move_to(centre.clone(), alpha);
        if search.residual <= search.tolerance {
            return Ended::Converged;
        }
        let falls = search.residual < 0.5 * best;
        still = if falls { 0 } else { still + 1 };
        best = best.min(search.residual);
        if still > PROXIMAL_PATIENCE {
            return Ended::Stuck(states);
        }
        part = (part * FALL).max(LEAST_PROXIMAL);
    }
}

/// Judges the present point of a proximal problem; its forces cause its displacements at its minimum.
fn show(search: &mut Search<'_>, proximal: &Proximal<'_>) {
    search.point = Forces {
        lambda: proximal.forces(),
        ..proximal.at.clone()
    };
    search.judge();
}

/// The problem around one centre, and the present point of its minimisation.
pub(crate) struct Proximal<'a> {
    setup: &'a Setup<'a>,
    /// λ_c, (m,).
    centre: Vec<f64>,
    /// a, (m,).
    compliance: Vec<f64>,
    /// μ, α̂ and Fμ.
    pub at: Forces,
    /// gap at μ and α̂, (m,).
    gap: Vec<f64>,
    /// The steepest slope so far, without its sign.
    steepest: f64,
}

/// Result of a Newton step.
pub(crate) enum Progress {
    /// φ fell.
    Moved,
    /// The states are those of the minimum: φ has no lower value.
    Minimal,
    /// φ did not fall: the linear problem was solved too roughly.
    Rough,
    /// The linear problem could not be solved.
    Singular,
}

impl<'a> Proximal<'a> {
    /// The problem around `centre`, an admissible force, from the displacements of `at`.
    pub fn new(setup: &'a Setup<'a>, centre: Vec<f64>, compliance: Vec<f64>, at: Forces) -> Self {
        let gap = vec![0.0; centre.len()];
        let mut proximal = Self {
            setup,
            centre,
            compliance,
            at,
            gap,
            steepest: 0.0,
        };
        proximal.find_gap();
        proximal
    }

    fn find_gap(&mut self) {
        self.gap.copy_from_slice(&self.at.product);
        let shift = self.setup.problem.shift.iter();
        self.gap
            .iter_mut()
            .zip(shift)
            .for_each(|(gap, d)| *gap -= d);
        self.setup
            .balance
            .add_transposed(-1.0, &self.at.alpha, &mut self.gap);
    }

    /// z = λ_c − (gap + t · change)/a.
    fn trial(&self, t: f64, change: &[f64], z: &mut [f64]) {
        for (i, z) in z.iter_mut().enumerate() {
            *z = self.centre[i] - (self.gap[i] + t * change[i]) / self.compliance[i];
        }
    }

    /// λ at the present displacements.
    pub fn forces(&self) -> Vec<f64> {
        let mut z = vec![0.0; self.gap.len()];
        self.trial(0.0, &vec![0.0; self.gap.len()], &mut z);
        let mut lambda = vec![0.0; z.len()];
        self.setup.admissible.project(&z, &mut lambda);
        lambda
    }

    /// States of the trial forces.
    pub fn states(&self) -> Vec<State> {
        let mut z = vec![0.0; self.gap.len()];
        self.trial(0.0, &vec![0.0; self.gap.len()], &mut z);
        let blocks = self.setup.admissible.iter();
        blocks
            .map(|(block, range)| State::of_trial(block, &z[range]))
            .collect()
    }

    /// One Newton step from the states guessed (or those of the trial forces) with the exact length.
    pub fn step(&mut self, guessed: Option<Vec<State>>, accuracy: f64) -> Progress {
        let setup = self.setup;
        let mut states = guessed.unwrap_or_else(|| self.states());
        // loads that no contact bears move their bodies until one does
        for _ in 0..setup.modes() + 3 {
            let loose = self.system(&states).loose;
            if loose.is_empty() || !self.approach(&loose) {
                break;
            }
            states = self.states();
        }
        let mut system = self.system(&states);
        let solved = system.solve(&self.at, accuracy);
        let Some(mut target) = solved else {
            return Progress::Singular;
        };
        // a body that no contact holds stays in place
        for z in &system.loose {
            let part = dot(z, &self.at.alpha);
            target
                .alpha
                .iter_mut()
                .zip(z)
                .for_each(|(a, z)| *a += part * z);
        }
        self.move_towards(target, &states)
    }

    fn system(&self, states: &[State]) -> System<'a> {
        let anchor = Anchor {
            centre: &self.centre,
            compliance: &self.compliance,
        };
        System::of(self.setup, states, Some(anchor), &self.compliance)
    }

    /// Moves along some directions of α̂ by the exact length; `false` where the load does not drive them.
    fn approach(&mut self, loose: &[Vec<f64>]) -> bool {
        let setup = self.setup;
        let lambda = self.forces();
        let mut rest = vec![0.0; setup.modes()];
        setup.balance.imbalance(&lambda, &mut rest);
        let mut direction = vec![0.0; rest.len()];
        for z in loose {
            let part = -dot(z, &rest);
            direction
                .iter_mut()
                .zip(z)
                .for_each(|(d, z)| *d += part * z);
        }
        let size = norm(setup.balance.target()).max(norm(&lambda));
        if norm(&direction) <= BALANCED * size {
            return false;
        }
        let mut change = vec![0.0; setup.len()];
        setup.balance.add_transposed(-1.0, &direction, &mut change);
        let along = dot(&direction, setup.balance.target());
        let mut workspace = Workspace::new(setup.len());
        // the slope is minus the part of the load that is not borne
        let mut slope = |t: f64, this: &Self| -along - workspace.work(this, t, &change);
        let or_one = |scale: f64| if scale > 0.0 { scale } else { 1.0 };
        let mut far = NUDGE * or_one(setup.problem.scales.length) / norm(&direction);
        for _ in 0..200 {
            if slope(far, self) >= 0.0 {
                break;
            }
            far *= 2.0;
        }
        let length = zero(far, |t| slope(t, self));
        for (alpha, d) in self.at.alpha.iter_mut().zip(&direction) {
            *alpha += length * d;
        }
        self.find_gap();
        true
    }

    /// Moves towards a point by the exact length, at most all the way.
    fn move_towards(&mut self, target: Forces, states: &[State]) -> Progress {
        let setup = self.setup;
        let difference = |to: &[f64], from: &[f64]| -> Vec<f64> {
            to.iter().zip(from).map(|(a, b)| a - b).collect()
        };
        let product = difference(&target.product, &self.at.product);
        let alpha = difference(&target.alpha, &self.at.alpha);
        let mut change = product.clone();
        setup.balance.add_transposed(-1.0, &alpha, &mut change);
        let mut z = vec![0.0; change.len()];
        self.trial(1.0, &change, &mut z);
        let mut blocks = setup.admissible.iter().zip(states);
        let same = |((block, range), state): ((&_, std::ops::Range<usize>), &State)| {
            State::of_trial(block, &z[range]).key() == state.key()
        };
        let settled = blocks.all(same);
        let work = dot(setup.balance.target(), &alpha);
        let (own, further) = (dot(&self.at.lambda, &product), {
            let mu = difference(&target.lambda, &self.at.lambda);
            dot(&mu, &product)
        });
        let mut workspace = Workspace::new(change.len());
        let size = own.abs() + work.abs() + workspace.size(self, &change);
        let mut slope =
            |t: f64, this: &Self| own + t * further - work - workspace.work(this, t, &change);
        let first = slope(0.0, self);
        self.steepest = self.steepest.max(first.abs());
        let settled = settled || first.abs() <= (GAINED * self.steepest).max(SLOPE_ROUNDING * size);
        let whole = settled || slope(1.0, self) <= FLAT_SLOPE * first.abs();
        let length = if whole {
            1.0
        } else {
            zero(1.0, |t| slope(t, self))
        };
        if whole {
            self.at = target;
        } else {
            let part = |at: &mut [f64], by: &[f64]| {
                at.iter_mut().zip(by).for_each(|(a, b)| *a += length * b);
            };
            let mu = difference(&target.lambda, &self.at.lambda);
            part(&mut self.at.lambda, &mu);
            part(&mut self.at.product, &product);
            part(&mut self.at.alpha, &alpha);
        }
        self.find_gap();
        match (settled, length > STANDING) {
            (true, _) => Progress::Minimal,
            (false, true) => Progress::Moved,
            (false, false) => Progress::Rough,
        }
    }
}

/// Room for trial forces along a line.
struct Workspace {
    z: Vec<f64>,
    lambda: Vec<f64>,
}

impl Workspace {
    fn new(m: usize) -> Self {
        Self {
            z: vec![0.0; m],
            lambda: vec![0.0; m],
        }
    }

    /// |λ|·|change|.
    fn size(&mut self, proximal: &Proximal<'_>, change: &[f64]) -> f64 {
        self.work(proximal, 0.0, change);
        let terms = self.lambda.iter().zip(change);
        terms.map(|(l, c)| (l * c).abs()).sum()
    }

    /// λ(t)·change.
    fn work(&mut self, proximal: &Proximal<'_>, t: f64, change: &[f64]) -> f64 {
        proximal.trial(t, change, &mut self.z);
        proximal.setup.admissible.project(&self.z, &mut self.lambda);
        dot(&self.lambda, change)
    }
}

/// The zero of a rising function that is not positive at 0 and not negative at `far`, by the Illinois method.
fn zero(far: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, far);
    let (mut below, mut above) = (f(0.0), f(far));
    let first = below.abs();
    let mut kept = 0;
    for _ in 0..200 {
        if above <= 0.0 || above <= below || (above - below).is_nan() {
            return high;
        }
        let guess = (low * above - high * below) / (above - below);
        let inside = guess > low && guess < high && kept < 3;
        let t = if inside { guess } else { 0.5 * (low + high) };
        let value = f(t);
        if value.abs() <= FLAT_ENOUGH * first || high - low <= SHORT_ENOUGH * high {
            return t;
        }
        if value < 0.0 {
            kept = if low > 0.0 { kept + 1 } else { 0 };
            (low, below) = (t, value);
            above *= 0.5;
        } else {
            kept = 0;
            (high, above) = (t, value);
            below *= 0.5;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Block, Compliance, DualProblem, Friction};
    use crate::linalg::Mat;
    use crate::solve::Iterate;
    use crate::solve::exact::Patience;
    use crate::solve::tests::{apart, by_trial, circle, definite, of, silent, times};
    use std::ops::ControlFlow;

    #[test]
    fn descent_ends_where_exact_steps_run_in_circles() {
        let problem = circle();
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-8, 200), &setup);
        let patience = Patience::new(100, f64::INFINITY);
        let silent = &mut silent;
        let closed = search.all_closed();
        let Ended::Stuck(states) = search.exact(closed, &patience, &|_, _| {}, silent) else {
            panic!("no circle: the descent is not needed");
        };
        assert!(search.steps < 100, "no state came back");
        assert!(matches!(
            proximal_steps(&mut search, states, silent),
            Ended::Converged
        ));
        let answer = search.outcome(false);
        assert!(problem.certify(&answer.multipliers, 1e-8).holds());
    }

    #[test]
    fn zero_of_a_rising_function_is_found_to_rounding_in_few_steps() {
        let found = |far: f64, f: &dyn Fn(f64) -> f64| {
            let mut calls = 0;
            let t = zero(far, |t| {
                calls += 1;
                f(t)
            });
            (t, calls)
        };
        let close = |(t, calls): (f64, usize), expected: f64, most: usize| {
            assert!(
                (t - expected).abs() < 1e-9 * expected,
                "{t} is not {expected}"
            );
            assert!(calls <= most, "{calls} calls");
        };
        close(found(1.0, &|t| t - 0.3), 0.3, 4);
        close(found(8.0, &|t| t * t * t - 1e-3), 0.1, 120);
        close(found(1.0, &|t| (t - 0.2).min(1e3 * (t - 0.2))), 0.2, 120);
        close(found(1.0, &|t| (t - 0.2).max(1e6 * (t - 0.2))), 0.2, 120);
        // no zero between: halved until nothing is left
        close(found(1.0, &|t| if t < 0.7 { -1.0 } else { 1e9 }), 0.7, 202);
        // still falling at the end, or NaN
        assert_eq!(found(2.0, &|t| t - 3.0), (2.0, 2));
        assert_eq!(
            found(2.0, &|t| if t > 1.0 { f64::NAN } else { -1.0 }),
            (2.0, 2)
        );
        assert_eq!(found(2.0, &|_| 1.0), (2.0, 2));
        assert_eq!(found(2.0, &|_| 0.0), (2.0, 2));
    }

    const SHIFT: [f64; 6] = [1.0, -0.4, 0.7, -0.2, -1.0, 0.9];
    const CENTRE: [f64; 6] = [0.3, 0.0, 1.0, 0.2, 0.0, 0.0];
    const ADDED: [f64; 6] = [0.2, 0.5, 0.1, 0.3, 0.4, 0.25];

    fn modes() -> [Vec<f64>; 2] {
        [vec![1.0; 6], (0..6).map(|i| 0.4 * i as f64 - 0.9).collect()]
    }

    fn pressed() -> DualProblem {
        of(
            Compliance::Dense(definite(6)),
            &SHIFT,
            vec![Block::Unilateral; 6],
            (&modes(), &[2.0, 0.3]),
        )
    }

    /// φ from the words of the module, the forces included.
    fn energy(proximal: &Proximal<'_>, project: impl Fn(&[f64]) -> Vec<f64>) -> f64 {
        let (setup, at) = (proximal.setup, &proximal.at);
        let m = setup.len();
        let told = setup.multipliers(&at.lambda, &at.alpha);
        let gap = setup.problem.gap(&told);
        let z: Vec<f64> = (0..m).map(|i| CENTRE[i] - gap[i] / ADDED[i]).collect();
        let lambda = project(&z);
        let stored = 0.5 * dot(&times(&definite(m), &at.lambda), &at.lambda);
        let work = dot(setup.problem.balance.load(), &told.alpha);
        let squares = (0..m).map(|i| 0.5 * ADDED[i] * (z[i] * z[i] - (z[i] - lambda[i]).powi(2)));
        stored - work + squares.sum::<f64>()
    }

    #[test]
    fn energy_falls_to_the_answer_of_the_problem_that_is_softer() {
        let problem = pressed();
        let setup = Setup::new(&problem).unwrap();
        let press = |z: &[f64]| z.iter().map(|z| z.max(0.0)).collect::<Vec<f64>>();
        let softer = Mat::from_fn(6, 6, |i, j| {
            definite(6)[(i, j)] + if i == j { ADDED[i] } else { 0.0 }
        });
        let shift: Vec<f64> = (0..6).map(|i| SHIFT[i] + ADDED[i] * CENTRE[i]).collect();
        let expected = by_trial(&softer, &shift, (&modes(), &[2.0, 0.3]));
        let far = [9.0, -3.0, 4.0, 0.0, 5.0, -7.0];
        for guessed in [
            None,
            Some(State::of_all_forces(&setup.admissible, &[1.0; 6])),
        ] {
            let at = Forces {
                lambda: far.to_vec(),
                product: times(&definite(6), &far),
                ..Forces::none(&setup)
            };
            let mut proximal = Proximal::new(&setup, CENTRE.to_vec(), ADDED.to_vec(), at);
            let (mut before, mut guessed) = (energy(&proximal, press), guessed);
            let mut steps = 0;
            loop {
                let progress = proximal.step(guessed.take(), 1e-13);
                let now = energy(&proximal, press);
                steps += 1;
                match progress {
                    Progress::Moved => assert!(now < before, "step {steps}: {now} {before}"),
                    Progress::Minimal => break,
                    Progress::Rough | Progress::Singular => panic!("step {steps}"),
                }
                before = now;
                assert!(steps < 12);
            }
            let lambda = proximal.forces();
            let alpha = setup.multipliers(&lambda, &proximal.at.alpha).alpha;
            assert!(apart(&lambda, &expected.lambda) < 1e-12);
            assert!(apart(&alpha, &expected.alpha) < 1e-12);
            // there the displacements are those of the forces
            assert!(apart(&proximal.at.product, &times(&definite(6), &lambda)) < 1e-12);
            let closed: Vec<bool> = lambda.iter().map(|force| *force > 0.0).collect();
            let states: Vec<bool> = proximal.states().iter().map(|s| s.closed).collect();
            assert_eq!(states, closed);
        }
    }

    /// How many of three nodes slip at the minimum with given bounds, which meets the law.
    fn slipping(bound: f64) -> usize {
        let block = Friction::Tresca { bound }.block(1);
        let problem = of(
            Compliance::Dense(definite(6)),
            &SHIFT,
            vec![block; 3],
            (&[vec![1.0, 0.0, 1.0, 0.0, 1.0, 0.0]], &[2.0]),
        );
        let setup = Setup::new(&problem).unwrap();
        let at = Forces::none(&setup);
        let mut proximal = Proximal::new(&setup, vec![0.0; 6], ADDED.to_vec(), at);
        let done = (0..20).any(|_| matches!(proximal.step(None, 1e-13), Progress::Minimal));
        assert!(done);
        let lambda = proximal.forces();
        let told = setup.multipliers(&lambda, &proximal.at.alpha);
        let gap = problem.gap(&told);
        for node in 0..3 {
            let (n, t) = (2 * node, 2 * node + 1);
            let trial = |i: usize| lambda[i] - (gap[i] + ADDED[i] * lambda[i]);
            assert!((lambda[n] - trial(n).max(0.0)).abs() < 1e-12);
            assert!((lambda[t] - trial(t).clamp(-bound, bound)).abs() < 1e-12);
        }
        assert!((lambda[0] + lambda[2] + lambda[4] - 2.0).abs() < 1e-12);
        let slips = |t: &usize| lambda[*t].abs() > bound * (1.0 - 1e-12);
        [1, 3, 5].iter().filter(|t| slips(t)).count()
    }

    #[test]
    fn minimum_with_given_bounds_of_friction_meets_the_law() {
        let counts = [0.2, 0.6, 4.0].map(slipping);
        assert_eq!((counts[0], counts[2]), (3, 0), "{counts:?}");
    }

    #[test]
    fn load_that_nothing_bears_moves_the_body_until_contacts_do() {
        // all open by 1, 2 and 3: pressed by 1.5, the first two bear it
        let f = Mat::from_fn(3, 3, |i, j| f64::from(i == j));
        for length in [0.0, 1e-8] {
            let mut problem = of(
                Compliance::Dense(f.clone()),
                &[-1.0, -2.0, -3.0],
                vec![Block::Unilateral; 3],
                (&[vec![1.0; 3]], &[1.5]),
            );
            problem.scales.length = length;
            let setup = Setup::new(&problem).unwrap();
            let none = Forces::none(&setup);
            let mut proximal = Proximal::new(&setup, vec![0.0; 3], vec![1.0; 3], none);
            let loose = proximal.system(&proximal.states()).loose;
            assert_eq!(loose.len(), 1);
            assert!(proximal.approach(&loose));
            // sunk by s: (s − 1) + (s − 2) = 1.5
            assert!(apart(&proximal.forces(), &[1.25, 0.25, 0.0]) < 1e-12);
            assert!(!proximal.approach(&loose), "nothing is left to be borne");
        }
    }

    #[test]
    fn body_that_nothing_holds_or_drives_stays() {
        let problem = of(
            Compliance::Dense(definite(2)),
            &[-1.0, -1.0],
            vec![Block::Unilateral; 2],
            (&[vec![1.0; 2]], &[0.0]),
        );
        let setup = Setup::new(&problem).unwrap();
        let mut at = Forces::none(&setup);
        at.alpha[0] = -0.4;
        let mut proximal = Proximal::new(&setup, vec![0.0; 2], vec![1.0; 2], at);
        assert!(matches!(proximal.step(None, 1e-13), Progress::Minimal));
        assert_eq!(proximal.at.alpha, [-0.4]);
        assert_eq!(proximal.forces(), [0.0; 2]);
    }

    #[test]
    fn work_along_a_line_is_that_of_the_forces_there() {
        let problem = pressed();
        let setup = Setup::new(&problem).unwrap();
        let at = Forces {
            lambda: vec![1.0; 6],
            product: times(&definite(6), &[1.0; 6]),
            ..Forces::none(&setup)
        };
        let proximal = Proximal::new(&setup, CENTRE.to_vec(), ADDED.to_vec(), at);
        let change = [0.5, -1.0, -2.0, 0.3, 0.0, 1.0];
        let product = times(&definite(6), &[1.0; 6]);
        let lambda = |t: f64| -> Vec<f64> {
            (0..6)
                .map(|i| {
                    let gap = product[i] - SHIFT[i] + t * change[i];
                    (CENTRE[i] - gap / ADDED[i]).max(0.0)
                })
                .collect()
        };
        let mut workspace = Workspace::new(6);
        for t in [0.0, 0.3, 2.0] {
            let work = workspace.work(&proximal, t, &change);
            assert!((work - dot(&lambda(t), &change)).abs() < 1e-13);
        }
        let size: f64 = lambda(0.0)
            .iter()
            .zip(change)
            .map(|(l, c)| (l * c).abs())
            .sum();
        assert!((workspace.size(&proximal, &change) - size).abs() < 1e-13);
        assert!(apart(&proximal.forces(), &lambda(0.0)) < 1e-14);
    }

    #[test]
    fn descent_keeps_to_its_limits_and_to_its_observer() {
        let problem = circle();
        let setup = Setup::new(&problem).unwrap();
        let mut search = Search::new((1e-8, 2), &setup);
        let closed = search.all_closed();
        assert!(matches!(
            proximal_steps(&mut search, closed, &mut silent),
            Ended::Stuck(_)
        ));
        assert_eq!((search.steps, search.kind), (2, 'p'));
        let mut search = Search::new((1e-8, 200), &setup);
        let closed = search.all_closed();
        let mut satisfied = |at: &Iterate<'_>| {
            assert_eq!((at.iteration, at.step), (1, 'p'));
            ControlFlow::Break(())
        };
        assert!(matches!(
            proximal_steps(&mut search, closed, &mut satisfied),
            Ended::Stopped
        ));
        // few steps from anywhere, each counted once
        let mut search = Search::new((1e-8, 200), &setup);
        let (closed, mut shown) = (search.all_closed(), 0);
        let mut observe = |at: &Iterate<'_>| {
            shown += 1;
            assert_eq!(at.iteration, shown);
            ControlFlow::Continue(())
        };
        assert!(matches!(
            proximal_steps(&mut search, closed, &mut observe),
            Ended::Converged
        ));
        assert_eq!(search.steps, shown);
        assert!(shown <= 12, "{shown} steps");
        let Compliance::Dense(f) = &problem.compliance else {
            panic!("F is assembled");
        };
        let expected = by_trial(f, &problem.shift, (&[], &[]));
        // the least eigenvalue of F is 0.01: residual 1e-8 leaves 1e-6
        assert!(apart(&search.point.lambda, &expected.lambda) < 1e-6);
    }
}
