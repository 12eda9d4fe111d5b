//! Load steps: each from the answer of the one before it, until one has none.

use crate::dual::Multipliers;
use crate::model::attempt::certified_attempt;
use crate::model::compliance::DENSE_LIMIT;
use crate::model::condense::{Condensed, advance, condense, restart};
use crate::model::error::{Error, Objection};
use crate::model::event::{Event, Lap};
use crate::model::finish::finish;
use crate::model::judge::Judged;
use crate::model::nouns::Model;
use crate::model::objection::objection;
use crate::model::pair::initial_gaps;
use crate::model::past::{Past, check_past, recorded, same_forces};
use crate::model::reuse::Reuse;
use crate::model::solution::Solution;
use std::time::Instant;

/// How a load step ended: what the next one begins from.
struct End {
    multipliers: Multipliers,
    /// Relative tangential displacement in every row under friction, zero in the others, (m,).
    slip: Vec<f64>,
}

impl End {
    /// The answer as a starting point. Contacts that bear nothing tell nothing: the solver's own start is better.
    fn guess(&self) -> Option<&Multipliers> {
        let touching = self.multipliers.lambda.iter().any(|&force| force != 0.0);
        touching.then_some(&self.multipliers)
    }
}

/// Solves all load steps of a valid model, in the order of the times, after those that were solved in the `past`; an observer
/// is told what happens. What is in `reuse` serves a model of the same stiffness, and is left there.
///
/// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
pub(crate) fn solve_steps<const D: usize>(
    model: &Model<D>,
    past: &[Past<D>],
    mut reuse: Option<&mut Reuse<D>>,
    observe: &mut dyn FnMut(Event),
) -> Result<Vec<Solution<D>>, Error<D>> {
    check_past(model, past)?;
    let start = Instant::now();
    let mut done: Vec<Solution<D>> = Vec::with_capacity(model.times.len());
    let mut condensed = reuse.as_mut().and_then(|reuse| reuse.take(model));
    let mut last: Option<End> = None;
    for (index, &time) in model.times.iter().enumerate() {
        let (step, steps) = (index + 1, model.times.len());
        observe(Event::Step { step, steps, time });
        let made = match (condensed.take(), &last) {
            (Some(before), Some(last)) => advance(model, before, &last.slip, time, observe),
            (Some(kept), None) => restart(model, kept, time, observe),
            _ => condense(model, time, DENSE_LIMIT, observe),
        };
        let mut here = match made {
            Ok(here) => here,
            Err(error) => return Err(error.in_step(model, step, done)),
        };
        let solved = match past.get(index) {
            Some(done) => solve_again(model, &mut here, (step, done), start, observe),
            None => {
                let guess = last.as_ref().and_then(End::guess);
                solve_step(model, &mut here, guess, start, observe)
            }
        };
        let failure = match solved {
            Ok((end, solution, None)) => {
                done.push(solution);
                (condensed, last) = (Some(here), Some(end));
                continue;
            }
            Ok((_, solution, Some(reason))) => Error::NotConverged {
                reason: Box::new(reason),
                solution: Box::new(solution),
                earlier: done,
            },
            Err(error @ Error::Past { .. }) => error,
            Err(error) => error.in_step(model, step, done),
        };
        keep(reuse, model, Some(here));
        return Err(failure);
    }
    keep(reuse, model, condensed);
    Ok(done)
}

/// Leaves what was factored for another model.
fn keep<const D: usize>(
    reuse: Option<&mut Reuse<D>>,
    model: &Model<D>,
    condensed: Option<Condensed<D>>,
) {
    if let (Some(reuse), Some(condensed)) = (reuse, condensed) {
        reuse.kept = Some((model.clone(), condensed));
    }
}

/// The end of a step, its solution, and why it is not an answer.
type Solved<const D: usize> = (End, Solution<D>, Option<Objection<D>>);

/// Solves the contact problem of a step that was solved before: from its forces to the same forces.
fn solve_again<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    (step, done): (usize, &Past<D>),
    start: Instant,
    observe: &mut dyn FnMut(Event),
) -> Result<Solved<D>, Error<D>> {
    let differs = |what: String| Error::Past { step, what };
    let recorded = recorded(condensed, model, done).map_err(differs)?;
    let (end, mut solution, objection) =
        solve_step(model, condensed, Some(&recorded), start, observe)?;
    if let Some(objection) = objection {
        return Err(differs(format!("it has no answer here ({objection})")));
    }
    same_forces(condensed, model, &recorded, &end.multipliers).map_err(differs)?;
    solution.solver.iterations = done.iterations;
    Ok((end, solution, None))
}

/// Solves the contact problem of one step from a guess, such as the answer of the step before it.
fn solve_step<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    guess: Option<&Multipliers>,
    start: Instant,
    observe: &mut dyn FnMut(Event),
) -> Result<Solved<D>, Error<D>> {
    observe(Event::Stage("contact"));
    let mut lap = Lap::start();
    let (attempt, judged) = certified_attempt(model, condensed, guess, observe)?;
    condensed.seconds.contact += lap.seconds();
    observe(Event::Stage("recover"));
    let objection = objection(model, condensed, &attempt, &judged);
    let end = End {
        multipliers: attempt.outcome.multipliers.clone(),
        slip: slip(&judged, condensed),
    };
    let mut solution = finish(model, condensed, attempt, judged, objection.is_none())?;
    condensed.seconds.recover += lap.seconds();
    condensed.seconds.total = start.elapsed().as_secs_f64();
    solution.seconds = condensed.seconds;
    Ok((end, solution, objection))
}

/// Relative tangential displacements in the rows under friction, zero in the others, (m,).
fn slip<const D: usize>(judged: &Judged<D>, condensed: &Condensed<D>) -> Vec<f64> {
    let tangential = condensed
        .paired
        .iter()
        .flat_map(|p| p.interface.tangential());
    // gap = g₀ + slip at the last step − slip now
    let undeformed = initial_gaps(&condensed.paired);
    let slips = condensed
        .gaps
        .iter()
        .zip(&undeformed)
        .zip(&judged.displaced.gaps);
    tangential
        .zip(slips)
        .map(|(is, ((before, g0), after))| if is { before - g0 - after } else { 0.0 })
        .collect()
}
