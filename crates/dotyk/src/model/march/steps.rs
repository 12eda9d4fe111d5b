//! Load steps: each from the answer of the one before it, until a step has no answer.

use crate::contact::ContactError;
use crate::dual::Multipliers;
use crate::fem::FemError;
use crate::model::march::attempt::Start;
use crate::model::march::borne::hold_to;
use crate::model::march::equilibrate::equilibrate;
use crate::model::march::finish::{finish, tell};
use crate::model::march::judge::Judged;
use crate::model::march::objection::objection;
use crate::model::march::past::{
    Past, assume_recorded, check_past, parted, recorded, same_bodies, same_forces,
};
use crate::model::march::reuse::Reuse;
use crate::model::march::torn;
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::event::{Event, Lap};
use crate::model::nouns::model::{Law, Model};
use crate::model::nouns::presence::Stage;
use crate::model::nouns::solution::Solution;
use crate::model::nouns::told::told_once;
use crate::model::read::probe::all_probes;
use crate::model::read::view::View;
use crate::model::system::compliance::DENSE_LIMIT;
use crate::model::system::condense::{Condensed, Purpose, again, assume, linearise};
use crate::model::system::condition::{Condition, contact_rows, row_ranges};
use crate::model::system::filling::{Filling, Moves};
use crate::model::system::state::State;
use crate::solve::ContactSolver;
use std::mem::take;
use std::sync::Arc;
use std::time::Instant;

/// Is shown the finished steps of a run.
type Kept<'a, const D: usize> = dyn Fn(&[Solution<D>]) + 'a;

/// Input of a run of load steps besides the model.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a, const D: usize> {
    /// The first steps, which were solved before.
    pub past: &'a [Past<D>],
    /// A solver of the caller for the other steps, instead of the model's method.
    pub own: Option<&'a dyn ContactSolver>,
    /// Is shown the finished steps after each of them.
    pub kept: Option<&'a Kept<'a, D>>,
}

impl<const D: usize> Given<'_, D> {
    /// No past steps, no solver from outside.
    pub const NONE: Self = Self {
        past: &[],
        own: None,
        kept: None,
    };
}

/// Solves all load steps of a valid model, in the order of the times, with an observer of the events. The data in `reuse` serve a
/// model of the same stiffness, and those of this model are left there.
///
/// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
pub(crate) fn solve_steps<const D: usize>(
    model: &Model<D>,
    given: Given<'_, D>,
    mut reuse: Option<&mut Reuse<D>>,
    observe: &mut dyn FnMut(Event),
) -> Result<Vec<Solution<D>>, Error<D>> {
    check_past(model, given.past)?;
    let purpose = match given.own {
        Some(_) => Purpose::others(DENSE_LIMIT),
        None => Purpose::ANSWERS,
    };
    let mut march = March {
        here: reuse.as_mut().and_then(|reuse| reuse.kept.take()),
        ..March::new(model.is_staged(), purpose)
    };
    let solved = march.solve(model, given, observe);
    if let Some(reuse) = reuse {
        reuse.kept = march.here;
    }
    solved.map(|()| march.done)
}

/// The dual problem of the load step at a time, with at most `dense_limit` assembled unknowns, and its stage. Friction counts the
/// slip since the last of the model's steps before that time, and stages go on from the end of the earlier ones: the steps before
/// are solved only if there is friction or there are stages.
///
/// Errors: those of [`solve_steps`].
pub(crate) fn condense_step<const D: usize>(
    model: &Model<D>,
    time: f64,
    dense_limit: usize,
    observe: &mut dyn FnMut(Event),
) -> Result<(Stage<'static, D>, Here<D>), Error<D>> {
    check_linear(model)?;
    let staged = model.is_staged() || model.has_stage_at(time);
    let mut march = March::new(staged, Purpose::others(dense_limit));
    let smooth = |law: &Law| matches!(law, Law::Frictionless | Law::Tied);
    let rough = !model.contacts.iter().all(|contact| smooth(&contact.law));
    let mut earlier = model.clone();
    earlier.times.retain(|&before| before < time);
    if rough || staged {
        march.solve(&earlier, Given::NONE, observe)?;
    }
    let step = earlier.times.len() + 1;
    let here = march.next(model, (step, time), observe)?;
    let stage = march.stage.unwrap_or_else(|| Stage::whole(model));
    Ok((stage.into_owned(), here))
}

/// Errors: a body that yields, or a gasket, which no dual problem with one F describes.
pub(crate) fn check_linear<const D: usize>(model: &Model<D>) -> Result<(), Error<D>> {
    if let Some(contact) = model.contacts.iter().find(|c| c.gasket.is_some()) {
        return Err(Error::Contact {
            contact: contact.name.clone(),
            source: ContactError::Gasket {
                why: "its law has several lines, and other solvers would know one: run the case instead".to_string(),
            },
        });
    }
    let why = "makes bodies answer otherwise than in proportion to what acts on them: their dual problem is none for other solvers; leave it out, or run the case";
    match model.bodies.iter().find(|body| body.is_plastic()) {
        Some(body) => Err(Error::in_body(body, FemError::Plastic { why })),
        None => Ok(()),
    }
}

/// A stage at the time of a step, and the view by which its steps are read.
type Here<const D: usize> = (Condensed<D>, View<D>);

/// The finished load steps, and the start of the next one.
struct March<'m, const D: usize> {
    done: Vec<Solution<D>>,
    /// State after the last step.
    state: Option<State<D>>,
    /// The stage that is there now.
    stage: Option<Stage<'m, D>>,
    here: Option<Here<D>>,
    purpose: Purpose,
    /// Parts come and go between the steps of the whole model.
    staged: bool,
}

impl<'m, const D: usize> March<'m, D> {
    fn new(staged: bool, purpose: Purpose) -> Self {
        Self {
            done: Vec::new(),
            state: None,
            stage: None,
            here: None,
            purpose,
            staged,
        }
    }

    /// All steps of the model.
    fn solve(
        &mut self,
        model: &'m Model<D>,
        Given { past, own, kept }: Given<'_, D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(), Error<D>> {
        let start = Instant::now();
        for (index, &time) in model.times.iter().enumerate() {
            let (step, steps) = (index + 1, model.times.len());
            observe(Event::Step { step, steps, time });
            let here = match self.next(model, (step, time), observe) {
                Ok(here) => here,
                Err(error) => return Err(error.in_step(model, step, take(&mut self.done))),
            };
            let solve =
                |stage: &Stage<'_, D>, here: &mut Here<D>, observe: &mut dyn FnMut(Event)| {
                    match past.get(index) {
                        // lines of gaskets are not recorded: their steps are solved anew
                        Some(done) if !model.has_gaskets() => {
                            solve_again(stage, here, (step, done), start, observe)
                        }
                        _ => solve_step(stage, here, (own, None), start, observe),
                    }
                };
            let solved = self.until_filled(time, here, &solve, observe);
            let (state, mut solution, objection) = match solved {
                Ok(solved) => solved,
                Err(error @ Error::Past { .. }) => return Err(error),
                Err(error) => return Err(error.in_step(model, step, take(&mut self.done))),
            };
            if self.staged {
                solution.probes = all_probes(model, take(&mut solution.probes));
            }
            if let Some(reason) = objection {
                return Err(Error::NotConverged {
                    reason: Box::new(reason),
                    solution: Box::new(solution),
                    earlier: take(&mut self.done),
                });
            }
            self.done.push(solution);
            self.state = Some(state);
            if let Some(kept) = kept {
                kept(&self.done);
            }
        }
        Ok(())
    }

    /// Solves a step at its time, and again with other lines of its gaskets until all pressures lie on those with which it was solved;
    /// `here` remains as the start of the next one.
    ///
    /// Errors: those of `solve`; gaskets that do not come to an end.
    fn until_filled(
        &mut self,
        time: f64,
        mut here: Here<D>,
        solve: &Solve<'_, D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Solved<D>, Error<D>> {
        let mut iterations = 0;
        for turns in 0..MOST_TURNS {
            let stage = self.stage.as_ref().ok_or(Error::NoStep)?;
            let solved = solve(stage, &mut here, observe);
            let refilled = refilled(&here.0, &solved, turns);
            let before = here.0.state.clone();
            self.here = Some(here);
            let (state, mut solution, objection) = solved?;
            solution.solver.iterations += iterations;
            if refilled.is_empty() {
                return Ok((state, solution, objection));
            }
            iterations = solution.solver.iterations;
            here = self.linear(before.with_fillings(refilled), time, observe)?;
        }
        let gaskets = contact_rows(&here.0.conditions);
        let mut gaskets = gaskets.filter(|(_, (_, condition))| condition.touch.filling.is_some());
        let first = gaskets
            .next()
            .map(|(_, (_, condition))| condition.name.clone());
        Err(Error::Contact {
            contact: first.unwrap_or_default(),
            source: ContactError::Gasket {
                why: format!(
                    "its law and the forces do not agree after {MOST_TURNS} turns; give more load steps"
                ),
            },
        })
    }

    /// The dual problem of the next step, at its time, of the stage that is then there.
    fn next(
        &mut self,
        model: &'m Model<D>,
        (step, time): (usize, f64),
        observe: &mut dyn FnMut(Event),
    ) -> Result<Here<D>, Error<D>> {
        let new = || State::new(model, time, self.staged);
        let mut state = self.state.take().unwrap_or_else(new);
        let last = self.here.as_ref().map(|(here, _)| &here.conditions[..]);
        let begins = state.go_on(model, (step, time), last)? || self.stage.is_none();
        let stage = self.stage.take().filter(|_| !begins);
        self.stage = Some(stage.unwrap_or_else(|| state.stage(model)));
        self.linear(state, time, observe)
    }

    /// The dual problem of the present stage at a time, from a state.
    fn linear(
        &mut self,
        state: State<D>,
        time: f64,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Here<D>, Error<D>> {
        let stage = self.stage.as_ref().ok_or(Error::NoStep)?;
        let (goes_on, from) = (state.goes_on(), (time, Arc::new(state)));
        let (before, view) = self.here.take().unzip();
        let look = |conditions: &[Condition<D>], same| match view.filter(|_| same) {
            Some(view) if goes_on => Ok(view),
            Some(view) => view.of_same(stage, conditions),
            None => View::new(stage, conditions),
        };
        linearise(stage, from, (before, self.purpose), look, observe)
    }
}

/// Most solutions of a step with gaskets; up to which of them their nodes take the lines on which they lie, and the next ones. Of 460
/// random problems one needed more than 40.
const MOST_TURNS: usize = 1000;
const TURNS_OF_ALL: usize = 4;
const TURNS_TO_NEXT: usize = 40;

/// The gaskets whose pressures lie on other lines than those with which a step was solved, by contact.
fn refilled<const D: usize>(
    here: &Condensed<D>,
    solved: &Result<Solved<D>, Error<D>>,
    turns: usize,
) -> Vec<(String, Filling)> {
    let forces = solved
        .as_ref()
        .ok()
        .and_then(|(state, ..)| state.forces.as_ref());
    let Some(forces) = forces else {
        return Vec::new();
    };
    let moves = match turns {
        0..TURNS_OF_ALL => Moves::All,
        TURNS_OF_ALL..TURNS_TO_NEXT => Moves::Next,
        _ => Moves::First,
    };
    let refilled = contact_rows(&here.conditions).filter_map(|(_, (rows, condition))| {
        let filling = condition.filled_otherwise(&forces.lambda[rows], moves)?;
        Some((condition.name.clone(), filling))
    });
    let one = if moves == Moves::First { 1 } else { usize::MAX };
    refilled.take(one).collect()
}

/// Solves a step of a stage.
type Solve<'a, const D: usize> =
    dyn Fn(&Stage<'_, D>, &mut Here<D>, &mut dyn FnMut(Event)) -> Result<Solved<D>, Error<D>> + 'a;

/// State after a step, its solution, and why it is not an answer.
type Solved<const D: usize> = (State<D>, Solution<D>, Option<Objection<D>>);

/// Solves the contact problem of a step that was solved before, which must have the recorded results again: from its forces; where these
/// lead elsewhere, or some are not recorded, from the step before, as it was solved at first. Several answers may exist where joints part
/// within a step or a body hovers, and the way to them decides.
fn solve_again<const D: usize>(
    stage: &Stage<'_, D>,
    here: &mut Here<D>,
    (step, done): (usize, &Past<D>),
    start: Instant,
    observe: &mut dyn FnMut(Event),
) -> Result<Solved<D>, Error<D>> {
    let model = stage.model.as_ref();
    let differs = |what: String| Error::Past { step, what };
    let mut forces = recorded(&here.0, model, done).map_err(differs)?;
    let conditions = here.0.conditions.iter();
    let lost: Vec<Vec<bool>> = conditions.map(|c| c.touch.lost.clone()).collect();
    assume_recorded(&mut here.0, model, done)?.map_err(differs)?;
    let coupled = here.0.conditions.iter().any(|c| c.contact().is_none());
    if let Some(lost) = parted(&here.0, model, &forces).filter(|_| !coupled) {
        again(model, &mut here.0, &lost, observe)?;
        forces = recorded(&here.0, model, done).map_err(differs)?;
    }
    let guess = (!coupled).then_some(&forces);
    let solved = match solve_as_recorded(stage, here, (done, guess), start, observe)? {
        Ok(solved) => Ok(solved),
        Err(_) => {
            let yielded = here.0.state.yielded();
            assume(model, &mut here.0, yielded)?;
            again(model, &mut here.0, &lost, observe)?;
            solve_as_recorded(stage, here, (done, None), start, observe)?
        }
    };
    let (state, mut solution) = solved.map_err(differs)?;
    solution.solver.iterations = done.iterations;
    Ok((state, solution, None))
}

/// The answer of a step from given forces, or from those of the step before, where it is the recorded one; else why it is not.
fn solve_as_recorded<const D: usize>(
    stage: &Stage<'_, D>,
    here: &mut Here<D>,
    (done, guess): (&Past<D>, Option<&Multipliers>),
    start: Instant,
    observe: &mut dyn FnMut(Event),
) -> Result<Result<(State<D>, Solution<D>), String>, Error<D>> {
    let model = stage.model.as_ref();
    let (state, solution, objection) = solve_step(stage, here, (None, guess), start, observe)?;
    if let Some(objection) = objection {
        return Ok(Err(format!("it has no answer here ({objection})")));
    }
    let same = || {
        if let Some(found) = &state.forces {
            same_forces(&here.0, model, &recorded(&here.0, model, done)?, found)?;
        }
        same_bodies((&here.0, model), done, &solution)
    };
    Ok(same().map(|()| (state, solution)))
}

/// Solves the contact problem of one step, by a solver of the caller or by the model's method, from given forces or from those of the
/// step before. A result that is not an answer carries the reason.
fn solve_step<const D: usize>(
    stage: &Stage<'_, D>,
    (condensed, view): &mut Here<D>,
    (own, given): (Option<&dyn ContactSolver>, Option<&Multipliers>),
    start: Instant,
    observe: &mut dyn FnMut(Event),
) -> Result<Solved<D>, Error<D>> {
    let (model, state) = (stage.model.as_ref(), Arc::clone(&condensed.state));
    let guess = given.or_else(|| state.guess());
    let from = Start { own, guess };
    observe(Event::Stage("contact"));
    let mut lap = Lap::start();
    let (mut attempt, mut judged, parted) = equilibrate(model, condensed, from, observe)?;
    if own.is_none() {
        hold_to(model, condensed, attempt.failure.as_mut(), from)?;
    }
    condensed.seconds.contact += lap.seconds();
    observe(Event::Stage("recover"));
    if attempt.failure.is_none() {
        judged.look_for_intrusion(
            stage,
            (condensed, view),
            &attempt.outcome.multipliers.lambda,
        );
    }
    let objection = objection(model, condensed, &attempt, &judged);
    let forces = attempt.outcome.multipliers.clone();
    let slip = slip(model, &judged, condensed);
    let (lost, after) = torn::after(model, condensed, &judged, &forces.lambda);
    let mut solution = finish(
        stage,
        (condensed, view),
        attempt,
        judged,
        objection.is_none(),
    )?;
    solution.warnings.extend(parted.into_iter().chain(after));
    solution.warnings = told_once(solution.warnings);
    let mut state = State::clone(&state);
    let load = condensed.problem.balance.load();
    let slid = (&slip[..], &lost[..]);
    let of_bodies = condensed.bodies.iter().take(model.bodies.len());
    let yielded = of_bodies.map(|body| body.system.history.yielded.clone());
    let (of_conditions, yielded) = (&condensed.conditions[..], yielded.collect());
    state.remember(&mut solution, of_conditions, (load, forces), slid, yielded);
    tell(model, (condensed, view), &mut solution)?;
    condensed.seconds.recover += lap.seconds();
    condensed.seconds.total = start.elapsed().as_secs_f64();
    solution.seconds = condensed.seconds;
    Ok((state, solution, objection))
}

/// Relative tangential displacements in the rows under friction, zero in the others, (m,).
fn slip<const D: usize>(
    model: &Model<D>,
    judged: &Judged<D>,
    condensed: &Condensed<D>,
) -> Vec<f64> {
    let mut slip = vec![0.0; condensed.gaps.len()];
    // gap = g₀ + slip at the last step − slip now
    let before = condensed.state.slips(&condensed.conditions);
    for (rows, condition) in row_ranges(&condensed.conditions) {
        let member = condition.source.member();
        let slackens = member.is_some_and(|place| model.members[place].kind.pull().slackens());
        for (row, tangential) in rows.zip(condition.slides()) {
            let before = before[row];
            let now = before - judged.displaced.gaps[row];
            slip[row] = match (tangential, slackens) {
                (false, _) => 0.0,
                (true, false) => now,
                // the elongation of what is slack is not plastic
                (true, true) => now.max(before),
            };
        }
    }
    slip
}
