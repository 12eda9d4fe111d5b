//! Load steps: each from the answer of the one before it, until one has none.

use crate::dual::Multipliers;
use crate::model::march::attempt::{Start, certified_attempt};
use crate::model::march::finish::finish;
use crate::model::march::judge::Judged;
use crate::model::march::objection::objection;
use crate::model::march::past::{Past, check_past, recorded, same_bodies, same_forces};
use crate::model::march::reuse::Reuse;
use crate::model::march::torn;
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::event::{Event, Lap};
use crate::model::nouns::model::{Law, Model};
use crate::model::nouns::solution::Solution;
use crate::model::nouns::told::told_once;
use crate::model::read::probe::all_probes;
use crate::model::read::view::View;
use crate::model::system::compliance::DENSE_LIMIT;
use crate::model::system::condense::{
    Condensed, Friction, Staged, advance, again, assemble, restart,
};
use crate::model::system::paired::{Kind, initial_gaps, row_ranges};
use crate::model::system::track::Track;
use crate::solve::ContactSolver;
use std::borrow::Cow;
use std::mem::take;
use std::time::Instant;

/// How a load step ended: what the next one begins from.
struct End {
    multipliers: Multipliers,
    friction: Friction,
}

impl End {
    /// The answer as a starting point. Contacts that bear nothing tell nothing: the solver's own start is better.
    fn guess(&self) -> Option<&Multipliers> {
        let touching = self.multipliers.lambda.iter().any(|&force| force != 0.0);
        touching.then_some(&self.multipliers)
    }
}

/// What a run of load steps is given besides the model.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a, const D: usize> {
    /// The first steps, which were solved before.
    pub past: &'a [Past<D>],
    /// A solver of the caller's own for the others, instead of the model's method.
    pub own: Option<&'a dyn ContactSolver>,
}

impl<const D: usize> Given<'_, D> {
    /// Nothing.
    pub const NONE: Self = Self {
        past: &[],
        own: None,
    };
}

/// Solves all load steps of a valid model, in the order of the times; an observer is told what happens. What is in `reuse`
/// serves a model of the same stiffness, and is left there.
///
/// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
pub(crate) fn solve_steps<const D: usize>(
    model: &Model<D>,
    given: Given<'_, D>,
    mut reuse: Option<&mut Reuse<D>>,
    observe: &mut dyn FnMut(Event),
) -> Result<Vec<Solution<D>>, Error<D>> {
    check_past(model, given.past)?;
    // what is there at the end is not what was at the beginning
    let mut reuse = reuse.take().filter(|_| !model.is_staged());
    let mut march = March {
        here: reuse.as_mut().and_then(|reuse| reuse.take(model)),
        staged: model.is_staged(),
        ..March::new(DENSE_LIMIT)
    };
    let solved = march.solve(model, given, observe);
    if let (Some(reuse), Some((condensed, view))) = (reuse, march.here) {
        reuse.kept = Some((model.clone(), condensed, view));
    }
    solved.map(|()| march.done)
}

/// The dual problem of the load step at a time, of at most `dense_limit` assembled unknowns, and the stage that it is of.
/// Friction counts the slip since the last of the model's steps before it, and stages go on from where the last ones ended:
/// these are solved where there is either, and nothing else depends on them.
///
/// Errors: those of [`solve_steps`].
pub(crate) fn condense_step<const D: usize>(
    model: &Model<D>,
    time: f64,
    dense_limit: usize,
    observe: &mut dyn FnMut(Event),
) -> Result<(Model<D>, Here<D>), Error<D>> {
    let mut march = March {
        staged: model.is_staged() || model.has_stage_at(time),
        ..March::new(dense_limit)
    };
    let smooth = |law: &Law| matches!(law, Law::Frictionless | Law::Tied);
    let rough = !model.contacts.iter().all(|contact| smooth(&contact.law));
    let mut earlier = model.clone();
    earlier.times.retain(|&before| before < time);
    if rough || march.staged {
        march.solve(&earlier, Given::NONE, observe)?;
    }
    let step = earlier.times.len() + 1;
    let here = march.next(model, (step, time), observe)?;
    let stage = march.stage.map_or_else(|| model.clone(), Cow::into_owned);
    Ok((stage, here))
}

/// A stage at the time of a step, and what its steps are looked at with.
type Here<const D: usize> = (Condensed<D>, View<D>);

/// The load steps that are done, and what the next one begins from.
struct March<'m, const D: usize> {
    done: Vec<Solution<D>>,
    here: Option<Here<D>>,
    last: Option<End>,
    dense_limit: usize,
    /// Things come and go between the steps of the whole model.
    staged: bool,
    /// What has come and gone.
    track: Option<Track<D>>,
    /// What is there now.
    stage: Option<Cow<'m, Model<D>>>,
}

impl<'m, const D: usize> March<'m, D> {
    fn new(dense_limit: usize) -> Self {
        Self {
            done: Vec::new(),
            here: None,
            last: None,
            dense_limit,
            staged: false,
            track: None,
            stage: None,
        }
    }

    /// All steps of the model.
    fn solve(
        &mut self,
        model: &'m Model<D>,
        Given { past, own }: Given<'_, D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(), Error<D>> {
        let start = Instant::now();
        for (index, &time) in model.times.iter().enumerate() {
            let (step, steps) = (index + 1, model.times.len());
            observe(Event::Step { step, steps, time });
            let mut here = match self.next(model, (step, time), observe) {
                Ok(here) => here,
                Err(error) => return Err(error.in_step(model, step, take(&mut self.done))),
            };
            let stage = self.stage.as_deref().unwrap_or(model);
            let guess = self.last.as_ref().and_then(End::guess);
            let mut solved = match past.get(index) {
                Some(done) => {
                    let past = (step, done, guess);
                    solve_again(stage, &mut here, past, start, observe)
                }
                None => solve_step(stage, &mut here, Start { own, guess }, start, observe),
            };
            self.here = Some(here);
            if let (Ok((_, solution, _)), Some(track)) = (&mut solved, &mut self.track) {
                solution.probes = all_probes(model, take(&mut solution.probes));
                track.remember(solution);
            }
            match solved {
                Ok((end, solution, None)) => {
                    self.done.push(solution);
                    self.last = Some(end);
                }
                Ok((_, solution, Some(reason))) => {
                    return Err(Error::NotConverged {
                        reason: Box::new(reason),
                        solution: Box::new(solution),
                        earlier: take(&mut self.done),
                    });
                }
                Err(error @ Error::Past { .. }) => return Err(error),
                Err(error) => return Err(error.in_step(model, step, take(&mut self.done))),
            }
        }
        Ok(())
    }

    /// The dual problem of the next step, at its time, of the stage that is then there.
    fn next(
        &mut self,
        model: &'m Model<D>,
        (step, time): (usize, f64),
        observe: &mut dyn FnMut(Event),
    ) -> Result<Here<D>, Error<D>> {
        if self.changes(model, (step, time)) {
            return self.begin_stage(time, observe);
        }
        let stage = self.stage.as_deref().unwrap_or(model);
        match (self.here.take(), &self.last) {
            (Some((before, view)), Some(last)) => {
                let condensed = advance(stage, before, &last.friction, time, observe)?;
                Ok((condensed, view))
            }
            (Some((kept, view)), None) => {
                let view = view.of_same(stage, &kept.paired)?;
                Ok((restart(stage, kept, time, observe)?, view))
            }
            _ => {
                let first = |track| Staged { track, last: None };
                let staged = self.track.as_ref().map(first);
                begin(stage, time, (self.dense_limit, staged), observe)
            }
        }
    }

    /// Goes on to a step; whether something comes or goes there.
    fn changes(&mut self, model: &'m Model<D>, (step, time): (usize, f64)) -> bool {
        let Some(track) = &mut self.track else {
            if self.staged {
                let track = Track::new(model, time);
                self.stage = Some(track.stage(model));
                self.track = Some(track);
            }
            return false;
        };
        let last = self.here.as_ref().zip(self.last.as_ref());
        let last = last.map(|((here, _), end)| (&here.paired[..], &end.multipliers.lambda[..]));
        let changes = track.change(model, (step, time), last);
        if changes {
            self.stage = Some(track.stage(model));
        }
        changes
    }

    /// The dual problem of the first step of a stage, after the last one.
    fn begin_stage(
        &mut self,
        time: f64,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Here<D>, Error<D>> {
        let (Some(track), Some(stage)) = (&self.track, self.stage.as_deref()) else {
            return Err(Error::NoStep);
        };
        let last = self.here.take().zip(self.last.take());
        let last = last.map(|((condensed, _), end)| (condensed, end.friction));
        let staged = Staged { track, last };
        begin(stage, time, (self.dense_limit, Some(staged)), observe)
    }
}

/// A stage at its first step. What it is looked at with is asked for before anything is factored.
fn begin<const D: usize>(
    stage: &Model<D>,
    time: f64,
    (dense_limit, staged): (usize, Option<Staged<'_, D>>),
    observe: &mut dyn FnMut(Event),
) -> Result<Here<D>, Error<D>> {
    let assembled = assemble(stage, time, staged, observe)?;
    let view = View::new(stage, &assembled.paired)?;
    Ok((assembled.condense(stage, dense_limit, observe)?, view))
}

/// The end of a step, its solution, and why it is not an answer.
type Solved<const D: usize> = (End, Solution<D>, Option<Objection<D>>);

/// Solves the contact problem of a step that was solved before: from its forces to the same forces, or from those of the step
/// before it where some are not recorded.
fn solve_again<const D: usize>(
    model: &Model<D>,
    here: &mut Here<D>,
    (step, done, before): (usize, &Past<D>, Option<&Multipliers>),
    start: Instant,
    observe: &mut dyn FnMut(Event),
) -> Result<Solved<D>, Error<D>> {
    let differs = |what: String| Error::Past { step, what };
    let recorded = recorded(&here.0, model, done).map_err(differs)?;
    let coupled = here.0.paired.len() > model.contacts.len();
    let from = Start {
        guess: if coupled { before } else { Some(&recorded) },
        own: None,
    };
    let (end, mut solution, objection) = solve_step(model, here, from, start, observe)?;
    if let Some(objection) = objection {
        return Err(differs(format!("it has no answer here ({objection})")));
    }
    same_forces(&here.0, model, &recorded, &end.multipliers).map_err(differs)?;
    same_bodies((&here.0, model), &done.bodies, &solution.bodies).map_err(differs)?;
    solution.solver.iterations = done.iterations;
    Ok((end, solution, None))
}

/// Solves the contact problem of one step. What comes out has the reason with it where it is not an answer.
fn solve_step<const D: usize>(
    model: &Model<D>,
    (condensed, view): &mut Here<D>,
    from: Start<'_>,
    start: Instant,
    observe: &mut dyn FnMut(Event),
) -> Result<Solved<D>, Error<D>> {
    observe(Event::Stage("contact"));
    let mut lap = Lap::start();
    let (mut attempt, mut judged) = certified_attempt(model, condensed, from, observe)?;
    let mut parted = Vec::new();
    while let Some(more) = torn::torn(model, condensed, &attempt) {
        again(model, condensed, &more.lost, observe)?;
        parted.push(more.words);
        let (further, again) = certified_attempt(model, condensed, from, observe)?;
        (attempt, judged) = (attempt.followed_by(further), again);
    }
    condensed.seconds.contact += lap.seconds();
    observe(Event::Stage("recover"));
    if attempt.failure.is_none() {
        judged.look_for_intrusion(
            model,
            (condensed, view),
            &attempt.outcome.multipliers.lambda,
        );
    }
    let objection = objection(model, condensed, &attempt, &judged);
    let multipliers = attempt.outcome.multipliers.clone();
    let slip = slip(model, &judged, condensed);
    let (lost, after) = torn::after(model, condensed, &judged, &multipliers.lambda);
    let mut solution = finish(
        model,
        (condensed, view),
        attempt,
        judged,
        objection.is_none(),
    )?;
    solution.warnings.extend(parted.into_iter().chain(after));
    solution.warnings = told_once(solution.warnings);
    let works = solution.contacts.iter().map(|c| c.dissipated_total);
    let friction = Friction {
        slip,
        dissipated: works.collect(),
        lost,
    };
    let end = End {
        multipliers,
        friction,
    };
    condensed.seconds.recover += lap.seconds();
    condensed.seconds.total = start.elapsed().as_secs_f64();
    solution.seconds = condensed.seconds;
    Ok((end, solution, objection))
}

/// Relative tangential displacements in the rows under friction, zero in the others, (m,).
fn slip<const D: usize>(
    model: &Model<D>,
    judged: &Judged<D>,
    condensed: &Condensed<D>,
) -> Vec<f64> {
    let mut slip = vec![0.0; condensed.gaps.len()];
    // gap = g₀ + slip at the last step − slip now
    let undeformed = initial_gaps(&condensed.paired);
    for (rows, pair) in row_ranges(&condensed.paired) {
        let slackens = matches!(pair.kind, Kind::Bar(bar) if model.bars[bar].slackens());
        for (row, tangential) in rows.zip(pair.slides()) {
            let before = condensed.gaps[row] - undeformed[row];
            let now = before - judged.displaced.gaps[row];
            slip[row] = match (tangential, slackens) {
                (false, _) => 0.0,
                (true, false) => now,
                // what a slack bar gives way is not plastic
                (true, true) => now.max(before),
            };
        }
    }
    slip
}
