//! Newton's method with Coulomb's law: open, stick or slip, one linear problem for each guess, in three stages.
//!
//! The law minimises nothing, so that no energy tells a good step from a bad one. What is done instead:
//!
//! 1. Exact steps: few and exact where friction is moderate and the start is good.
//! 2. Proximal steps: λ ← the solution with F + a and d + aλ, whose states come from trial forces λ − gap/a. The compliance a
//!    outweighs what friction couples, so that these Newton iterations end; it falls where they do and rises where they do
//!    not. Redundant contacts (F of low rank) do no harm.
//! 3. Bounds ← coefficient · λₙ, and the convex problem of these bounds, again and again (`coulomb.rs`): a contraction for
//!    small coefficients.
//!
//! States in which a body could slide or fly off freely keep those nodes sticking that want to slip least, then those closed
//! that were.
//!
//! As described in Alart & Curnier (1991); the proximal point loop around it as in Acary, Brémond & Huber (2018).

use crate::dual::{Block, Multipliers};
use crate::solve::coulomb::fixed_point;
use crate::solve::levels;
use crate::solve::newton::{Ended, NEAR, Patience, Search};
use crate::solve::states::{Anchor, Shear, State, unknowns};
use crate::solve::system::{Forces, System};
use crate::solve::{
    FixedBounds, Newton, Observer, Outcome, Setup, SolveError, completed, counting_from,
};
use std::collections::HashSet;

/// Exact steps: their residuals may rise on the way.
const EXACT: Patience = Patience {
    steps: 14,
    factor: f64::INFINITY,
};

/// First compliance of proximal steps, relative to that of each contact; its factors after a success and a failure.
const FIRST: f64 = 0.1;
const FALL: f64 = 0.1;
const RISE: f64 = 10.0;

/// Smallest and largest compliance of proximal steps.
const LEAST: f64 = 1e-10;
const LARGEST: f64 = 1e4;

/// Most Newton steps for one centre.
const INNER: usize = 20;

/// Newton on the problem of `setup`, which has Coulomb's law.
///
/// Errors: `NotConverged`.
pub(crate) fn solve(
    method: &Newton,
    setup: &Setup<'_>,
    guess: Option<&Multipliers>,
    observe: Observer<'_>,
) -> Result<Outcome, SolveError> {
    let mut search = Search::new(method, setup);
    let mut states = match guess {
        Some(guess) => search.states_of_guess(guess)?,
        None => match levels::start(setup, &|method, coarse, tell| {
            solve(method, coarse, None, tell)
        }) {
            Some(start) => search.begin(start),
            None => search.all_closed(),
        },
    };
    hold(setup, &mut states, None);
    let adjust = |next: &mut Vec<State>, before: &[State]| hold(setup, next, Some(before));
    let ended = match search.exact(states, &EXACT, &adjust, observe) {
        Ended::Stuck(states) => proximal(&mut search, states, observe),
        ended => ended,
    };
    match ended {
        Ended::Converged => Ok(search.outcome(false)),
        Ended::Stopped => Ok(search.outcome(true)),
        Ended::Stuck(_) => iterate_bounds(search, observe),
    }
}

/// Proximal steps, each ended by an exact one.
fn proximal(search: &mut Search<'_>, states: Vec<State>, observe: Observer<'_>) -> Ended {
    let setup = search.setup;
    let mut centre = vec![0.0; setup.len()];
    setup.admissible.project(&search.point.lambda, &mut centre);
    let mut at = search.at_forces(centre.clone(), search.point.alpha.clone());
    let mut states = states;
    let adjust = |next: &mut Vec<State>, before: &[State]| hold(setup, next, Some(before));
    let mut part = FIRST;
    let (mut best, mut still) = (f64::INFINITY, 0);
    while part <= LARGEST && !search.exhausted() {
        let compliance: Vec<f64> = setup.problem.softness.iter().map(|c| part * c).collect();
        let anchor = Anchor {
            centre: &centre,
            compliance: &compliance,
        };
        let inner = anchored(search, states.clone(), anchor, &at, observe);
        let (found, settled) = match inner {
            Inner::Stopped => return Ended::Stopped,
            Inner::Settled(point, states) => (point, states),
            Inner::Failed => {
                part *= RISE;
                continue;
            }
        };
        states = settled;
        // the exact forces of these states, where they are the answer or lead there
        match search.exact(states.clone(), &NEAR, &adjust, observe) {
            Ended::Stuck(_) => {}
            ended => return ended,
        }
        centre = found.lambda.clone();
        at = found;
        search.point = at.clone();
        search.judge();
        if search.residual <= search.method.tolerance {
            return Ended::Converged;
        }
        still = if search.residual < 0.9 * best {
            0
        } else {
            still + 1
        };
        best = best.min(search.residual);
        if still > 10 {
            break;
        }
        part = (part * FALL).max(LEAST);
    }
    Ended::Stuck(states)
}

/// How the Newton steps for one centre ended.
enum Inner {
    Settled(Forces, Vec<State>),
    Failed,
    Stopped,
}

/// Newton steps on anchored conditions until the states repeat themselves.
fn anchored(
    search: &mut Search<'_>,
    mut states: Vec<State>,
    anchor: Anchor<'_>,
    at: &Forces,
    observe: Observer<'_>,
) -> Inner {
    let setup = search.setup;
    let mut seen = HashSet::new();
    let mut at = at.clone();
    for _ in 0..INNER {
        if search.exhausted() {
            return Inner::Failed;
        }
        let mut offset = vec![0.0; setup.len()];
        let list = unknowns(
            &setup.admissible,
            &states,
            Some(anchor),
            anchor.compliance,
            &mut offset,
        );
        let mut system = System::new(setup, &list, &offset);
        search.steps += 1;
        search.kind = 'p';
        let solved = system.solve(&at, 1e-10);
        search.products += system.products;
        let Some(point) = solved else {
            return Inner::Failed;
        };
        at = point;
        search.point = at.clone();
        search.judge();
        if search.tell(observe) {
            return Inner::Stopped;
        }
        let gap = &search.judge.gap;
        let trial: Vec<f64> = (0..setup.len())
            .map(|i| anchor.centre[i] - gap[i] / anchor.compliance[i])
            .collect();
        let blocks = setup.admissible.iter();
        let mut next: Vec<State> = blocks
            .map(|(block, range)| State::of_trial(block, &trial[range]))
            .collect();
        if states.iter().zip(&next).all(|(now, then)| now.agrees(then)) {
            return Inner::Settled(at, next);
        }
        let now: Vec<_> = states.iter().map(State::key).collect();
        let turns = states.iter().any(State::may_turn);
        hold(setup, &mut next, Some(&states));
        if !seen.insert(now) && !turns {
            return Inner::Failed;
        }
        states = next;
    }
    Inner::Failed
}

/// Bounds of friction, and the convex problem of these bounds, again and again.
fn iterate_bounds(search: Search<'_>, observe: Observer<'_>) -> Result<Outcome, SolveError> {
    let setup = search.setup;
    let point = &search.point;
    let finite = point
        .lambda
        .iter()
        .chain(&point.alpha)
        .all(|x| x.is_finite());
    let guess = finite.then(|| setup.multipliers(&point.lambda, &point.alpha));
    let done = search.iterations();
    let mut after = counting_from(done, observe);
    let result = fixed_point(search.method, setup, guess.as_ref(), &mut after);
    completed(Newton::NAME, result, |outcome| Outcome {
        iterations: done + outcome.iterations,
        products: search.products + outcome.products,
        ..outcome
    })
}

/// Changes `states` until they hold the floating bodies: nodes that want to slip least stick, then contacts of `before`
/// stay closed (all of them where there is no before).
fn hold(setup: &Setup<'_>, states: &mut [State], before: Option<&[State]>) {
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
        let rows = &setup.balance.rows;
        let moves = |i: usize| {
            let along = |z: &Vec<f64>| z.iter().zip(rows).map(|(z, row)| z * row[i]).sum::<f64>();
            loose.iter().any(|z| along(z).abs() > 1e-9)
        };
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
