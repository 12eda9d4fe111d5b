//! Newton's method with Coulomb's law: open, stick or slip, one linear problem for each guess, in four stages.
//!
//! The law minimises nothing, so that no energy tells a good step from a bad one. What is done instead:
//!
//! 1. Exact steps: few and exact where friction is moderate and the start is good.
//! 2. Where bodies float, a convex problem whose bounds of friction are coefficient · λₙ of the best forces so far: its energy
//!    falls, so that it moves the bodies to where contacts hold them. Exact steps go on from there.
//! 3. Proximal steps: λ ← the solution with F + a and d + aλ. The compliance a outweighs what friction couples, so that these
//!    Newton iterations end; it falls where they do and rises where they do not. Redundant contacts (F of low rank) do no harm.
//! 4. Bounds ← coefficient · λₙ, and the convex problem of these bounds, again and again (`coulomb.rs`): a contraction for
//!    small coefficients.
//!
//! The states of proximal steps come, as those of exact ones, from trial forces λ − g/c with the compliance c of each contact
//! and what is left of its condition, g = gap + a(λ − centre). Trial forces centre − gap/a have the same solution, but they
//! outgrow all bounds as a falls: nodes flip from one direction of slip to the other, and in space the linearised law forgets
//! that a direction may turn.
//!
//! A stage begins from the forces of least residual so far: others may have grown without bound.
//!
//! States in which a body could slide or fly off freely keep those nodes sticking that want to slip least, then those closed
//! that were.
//!
//! As described in Alart & Curnier (1991); the proximal point loop around it as in Acary, Brémond & Huber (2018).

use crate::dual::{Block, Multipliers};
use crate::solve::coulomb::{carry, fixed_point};
use crate::solve::levels;
use crate::solve::newton::{Ended, NEAR, NEARBY, Patience, Search};
use crate::solve::states::{Anchor, Shear, State, unknowns};
use crate::solve::system::System;
use crate::solve::{
    Component, FixedBounds, Newton, Observer, Outcome, Setup, SolveError, completed, counting_from,
};
use std::collections::HashSet;

/// Exact steps: their residuals may rise on the way.
const EXACT: Patience = Patience {
    steps: 14,
    factor: f64::INFINITY,
};

/// Most steps on a coarser problem: no more than a guess is asked for.
const COARSE: usize = 20;

/// Most convex problems that look for where floating bodies rest, and their accuracy.
const ROUNDS: usize = 2;
const RESTING: f64 = 1e-4;

/// First compliance of proximal steps, relative to that of each contact; its factors after a success and a failure.
const FIRST: f64 = 0.1;
const FALL: f64 = 0.3;
const RISE: f64 = 10.0;

/// Smallest and largest compliance of proximal steps.
const LEAST: f64 = 1e-6;
const LARGEST: f64 = 1e4;

/// Centres without a smaller residual that end the proximal steps.
const PATIENCE: usize = 10;

/// Most Newton steps for one centre.
const INNER: usize = 40;

/// Errors of the law that Newton steps for one centre leave: a part of the residual of the centre before, at least the second.
const INEXACT: f64 = 1e-3;
const ACCURATE: f64 = 1e-10;

/// Newton on the problem of `setup`, which has Coulomb's law.
///
/// Errors: `NotConverged`.
pub(crate) fn solve(
    method: &Newton,
    setup: &Setup<'_>,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let (search, ended) = steps(method, setup, guess, observe)?;
    match ended {
        Ended::Converged => Ok(search.outcome(false)),
        Ended::Stopped => Ok(search.outcome(true)),
        Ended::Stuck(_) => iterate_bounds(search, observe),
    }
}

/// The best that a few steps find on a coarser problem.
fn coarse(
    method: &Newton,
    setup: &Setup<'_>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let few = method.within(method.tolerance, COARSE);
    let (mut search, _) = steps(&few, setup, None, observe)?;
    search.point = search.best.1.clone();
    Ok(search.outcome(false))
}

/// The first three stages.
fn steps<'a>(
    method: &'a Newton,
    setup: &'a Setup<'a>,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<(Search<'a>, Ended), SolveError> {
    let mut search = Search::new(method, setup);
    let mut states = match guess {
        Some(guess) => search.states_of_guess(guess)?,
        None => match levels::start(setup, &coarse) {
            Some(start) => search.begin(start),
            None => search.all_closed(),
        },
    };
    hold(setup, &mut states, None);
    let adjust = |next: &mut Vec<State>, before: &[State]| hold(setup, next, Some(before));
    let mut ended = search.exact(states, &EXACT, &adjust, observe);
    let rounds = if setup.modes() > 0 { ROUNDS } else { 0 };
    for _ in 0..rounds {
        if !matches!(ended, Ended::Stuck(_)) {
            break;
        }
        let Some(states) = at_rest(&mut search, observe) else {
            break;
        };
        ended = search.exact(states, &EXACT, &adjust, observe);
    }
    if let Ended::Stuck(states) = ended {
        ended = proximal(&mut search, states, observe);
    }
    Ok((search, ended))
}

/// Solves the convex problem whose bounds of friction are those of the best forces so far, or none where these cannot carry
/// the load; the states that its answer asks for, `None` where it has none.
fn at_rest(search: &mut Search<'_>, observe: Observer<'_>) -> Option<Vec<State>> {
    let setup = search.setup;
    let best = &search.best.1;
    let guess = setup.multipliers(&best.lambda, &best.alpha);
    let bounds = setup.admissible.bounds(&best.lambda);
    let (admissible, guess) = match carry(setup, &bounds) {
        true => (setup.admissible.with_bounds(&bounds), Some(&guess)),
        false => (setup.admissible.sticking(), None),
    };
    let left = search.method.max_iterations.saturating_sub(search.steps);
    let method = search.method.within(RESTING, left);
    let mut after = counting_from(search.iterations(), observe);
    let outcome = match method.run(&setup.with_admissible(admissible), guess, &mut after) {
        Ok(outcome) => outcome,
        // what is near may do
        Err(SolveError::NotConverged { outcome, .. }) => *outcome,
        Err(_) => return None,
    };
    search.steps += outcome.iterations;
    search.products += outcome.products;
    let states = search.states_of_guess(&outcome.multipliers).ok()?;
    search.move_to(search.point.lambda.clone(), search.point.alpha.clone());
    let mut next = search.next_states(&states, &search.judge.gap);
    hold(setup, &mut next, Some(&states));
    Some(next)
}

/// Proximal steps, and exact ones where two centres in a row have the same states.
fn proximal(search: &mut Search<'_>, mut states: Vec<State>, observe: Observer<'_>) -> Ended {
    let setup = search.setup;
    let mut centre = vec![0.0; setup.len()];
    setup.admissible.project(&search.best.1.lambda, &mut centre);
    search.move_to(centre, search.best.1.alpha.clone());
    let mut at = search.point.clone();
    let adjust = |next: &mut Vec<State>, before: &[State]| hold(setup, next, Some(before));
    let (mut part, mut error) = (FIRST, INEXACT);
    let (mut best, mut still) = (f64::INFINITY, 0);
    let mut before = Vec::new();
    while part <= LARGEST && still <= PATIENCE && !search.exhausted() {
        let compliance: Vec<f64> = setup.problem.softness.iter().map(|c| part * c).collect();
        let anchor = Anchor {
            centre: &at.lambda,
            compliance: &compliance,
        };
        (at, states) = match anchored(search, states.clone(), anchor, error, observe) {
            Inner::Stopped => return Ended::Stopped,
            Inner::Settled(states) => (search.point.clone(), states),
            Inner::Failed => {
                part *= RISE;
                continue;
            }
        };
        let residual = search.residual;
        if residual <= search.method.tolerance {
            return Ended::Converged;
        }
        let settled: Vec<_> = states.iter().map(State::key).collect();
        if settled == before {
            match search.exact(states.clone(), &NEAR, &adjust, observe) {
                Ended::Stuck(_) => {}
                ended => return ended,
            }
        }
        before = settled;
        let falls = residual < 0.9 * best;
        still = if falls { 0 } else { still + 1 };
        best = best.min(residual);
        error = (INEXACT * residual).clamp(ACCURATE, INEXACT);
        part = (part * FALL).max(LEAST);
    }
    Ended::Stuck(states)
}

/// How the Newton steps for one centre ended.
enum Inner {
    /// The states that come next.
    Settled(Vec<State>),
    Failed,
    Stopped,
}

/// Newton steps on anchored conditions until the error of the law is at most the part `accuracy` of the largest force.
fn anchored(
    search: &mut Search<'_>,
    mut states: Vec<State>,
    anchor: Anchor<'_>,
    accuracy: f64,
    observe: Observer<'_>,
) -> Inner {
    let setup = search.setup;
    let mut seen = HashSet::new();
    for _ in 0..INNER {
        if search.exhausted() || !anchored_step(search, &states, anchor) {
            return Inner::Failed;
        }
        if search.tell(observe) {
            return Inner::Stopped;
        }
        let left = anchor.left(&search.point.lambda, &search.judge.gap);
        let mut next = search.next_states(&states, &left);
        let key = |states: &[State]| states.iter().map(State::key).collect::<Vec<_>>();
        let (now, then) = (key(&states), key(&next));
        // in space the directions of slip go on turning in the same states
        let turns = states.iter().any(State::may_turn);
        let largest = |s: f64, force: &f64| s.max(force.abs());
        let force = search.point.lambda.iter().fold(0.0, largest);
        let settled = law_error(setup, &search.point.lambda, &left) <= accuracy * force;
        let answer = search.residual <= 1e-3 * search.method.tolerance;
        if settled || answer || now == then && !turns {
            return Inner::Settled(next);
        }
        hold(setup, &mut next, Some(&states));
        if !seen.insert(now) && !turns {
            return Inner::Failed;
        }
        states = next;
    }
    Inner::Failed
}

/// Solves for the forces of `states` with anchored conditions and judges them; `false` where the system is singular.
fn anchored_step(search: &mut Search<'_>, states: &[State], anchor: Anchor<'_>) -> bool {
    let setup = search.setup;
    let mut offset = vec![0.0; setup.len()];
    let list = unknowns(
        &setup.admissible,
        states,
        Some(anchor),
        &setup.problem.softness,
        &mut offset,
    );
    let mut system = System::new(setup, &list, &offset);
    search.steps += 1;
    search.kind = 'p';
    let solved = system.solve(&search.point, ACCURATE);
    search.products += system.products;
    let Some(point) = solved else { return false };
    search.point = point;
    search.judge();
    true
}

/// Largest |λ − P(λ − gap/softness)|, a force; shears are held to the bounds that go with λₙ. Shapes: (m,).
fn law_error(setup: &Setup<'_>, lambda: &[f64], gap: &[f64]) -> f64 {
    let trial = |i: usize| lambda[i] - gap[i] / setup.problem.softness[i];
    let error = |(i, component): (usize, &Component)| match component {
        Component::Free => (lambda[i] - trial(i)).abs(),
        Component::Normal => (lambda[i] - trial(i).max(0.0)).abs(),
        Component::Tangent => 0.0,
    };
    let normal = setup.components.iter().enumerate().map(error);
    let shear = setup.admissible.slip_violation(lambda, trial);
    normal.fold(shear, f64::max)
}

/// Bounds of friction, and the convex problem of these bounds, again and again; where that does not converge, the best forces
/// of all.
fn iterate_bounds(mut search: Search<'_>, observe: Observer<'_>) -> Result<Outcome, SolveError> {
    let setup = search.setup;
    let (residual, point) = &search.best;
    let guess = setup.multipliers(&point.lambda, &point.alpha);
    let guess = residual.is_finite().then_some(&guess);
    let done = search.iterations();
    let mut after = counting_from(done, observe);
    let mut result = fixed_point(search.method, setup, guess, &mut after);
    search.go_back();
    if let Err(SolveError::NotConverged {
        outcome, residual, ..
    }) = &mut result
        && search.residual < residual.min(NEARBY)
    {
        outcome.multipliers = setup.multipliers(&search.point.lambda, &search.point.alpha);
        *residual = search.residual;
    }
    completed(Newton::NAME, result, |outcome| Outcome {
        iterations: done + outcome.iterations,
        products: search.products + outcome.products,
        ..outcome
    })
}

/// Changes `states` until they hold the floating bodies: nodes that want to slip least stick, then contacts of `before`
/// stay closed (all of them where there is no before).
pub(crate) fn hold(setup: &Setup<'_>, states: &mut [State], before: Option<&[State]>) {
    if setup.modes() == 0 {
        return;
    }
    stick_where_free(setup, states);
    if carries(setup, states) {
        return;
    }
    for (place, state) in states.iter_mut().enumerate() {
        match before.map(|before| &before[place]) {
            Some(before) if before.closed && !state.closed => *state = before.clone(),
            None => state.closed = true,
            _ => {}
        }
    }
    stick_where_free(setup, states);
}

fn carries(setup: &Setup<'_>, states: &[State]) -> bool {
    let mut offset = vec![0.0; setup.len()];
    let softness = &setup.problem.softness;
    let list = unknowns(&setup.admissible, states, None, softness, &mut offset);
    System::new(setup, &list, &offset).carries()
}

/// Nodes stick, those first that want to slip least, until no body slides freely.
fn stick_where_free(setup: &Setup<'_>, states: &mut [State]) {
    loop {
        let mut offset = vec![0.0; setup.len()];
        let softness = &setup.problem.softness;
        let list = unknowns(&setup.admissible, states, None, softness, &mut offset);
        let loose = System::new(setup, &list, &offset).loose;
        if loose.is_empty() {
            return;
        }
        let motions = loose.iter().map(|z| {
            let mut motion = vec![0.0; setup.len()];
            setup.balance.add_transposed(1.0, z, &mut motion);
            motion
        });
        let motions: Vec<Vec<f64>> = motions.collect();
        let moves = |i: usize| motions.iter().any(|motion| motion[i].abs() > 1e-9);
        let slipping = |place: &usize| {
            let state = &states[*place];
            let coulomb = matches!(setup.admissible.blocks()[*place], Block::Coulomb { .. });
            matches!(state.shear, Shear::Slip { .. })
                && (state.closed || !coulomb)
                && setup.admissible.range(*place).skip(1).any(moves)
        };
        let least = (0..states.len())
            .filter(slipping)
            .min_by(|&a, &b| states[a].excess.total_cmp(&states[b].excess));
        let Some(place) = least else { return };
        states[place].shear = Shear::Stick;
    }
}
