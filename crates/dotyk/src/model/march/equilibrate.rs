//! The loop of equilibrium: forces, displacements, what these ask for, and forces again, until the certificate holds and nothing
//! is asked for.
//!
//! ```text
//!   solve ─▶ judge ─▶ bodies whole after all     in pieces they would take longer
//!     ▲                F assembled after all      an applied or sparse F was not enough
//!     │                an increment               an exact step whose gaps are those of the displacements
//!     │                a finer tolerance          the iteration goes on, with d corrected by these gaps
//!     │                a joint that has parted    without what it bore                                   torn.rs
//!     └──────────────  plastic strain             that the displacements return to, with its load        flow.rs
//! ```
//!
//! The solver knows F and d, the certificate judges displacements and energies computed afresh. Where they differ (rounding of the
//! factorisation in a slender body, another scale of the energy) the first four moves bring the forces nearer: they are taken in this
//! order, each until it leads no further, and stay on one linear problem. The last two change what drives; K, its factor, F and the
//! pairs stay. A linear problem passes once. A solver from outside is called once, and its answer is judged as it is.

use crate::dual::{Certificate, NOT_OF_THE_SOLVER};
use crate::model::march::attempt::{Attempt, Start, run, run_method};
use crate::model::march::flow::Turns;
use crate::model::march::judge::{Judged, judge};
use crate::model::march::torn::torn;
use crate::model::nouns::error::Error;
use crate::model::nouns::event::Event;
use crate::model::nouns::model::{Method, Model};
use crate::model::nouns::solution::HistoryPoint;
use crate::model::system::compliance::ASSEMBLED;
use crate::model::system::condense::{Condensed, again, make_whole};
use crate::model::system::dependent::shared_forces;
use crate::solve::{Outcome, correction, loaded};

/// Most increments.
const INCREMENTS: usize = 8;

/// Most finer tolerances.
const FINER: usize = 3;

/// An attempt, how it was judged, and what the user should know of what was lost on the way, and of forces that are not unique.
pub(crate) type Found<const D: usize> = (Attempt<D>, Judged<D>, Vec<String>);

/// Solves until the certificate holds, all joints have a state, and the bodies have yielded as much as their displacements say.
///
/// Errors: bolts that are none; a problem that cannot be solved by the method of the model; those of the law of a body.
pub(crate) fn equilibrate<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    from: Start<'_>,
    observe: &mut dyn FnMut(Event),
) -> Result<Found<D>, Error<D>> {
    let mut turns = Turns::new(model, condensed)?;
    let (mut before, mut parted) = (None, Vec::new());
    let mut at = Reached::begin(model, condensed, from, observe)?;
    loop {
        if at.refine(model, condensed, from, observe)? {
            continue;
        }
        let (attempt, guess);
        if let Some(more) = torn(model, condensed, &at.attempt) {
            again(model, condensed, &more.lost, observe)?;
            parted.push(more.words);
            (attempt, guess) = (at.attempt, None);
        } else {
            let known = (at.attempt, &at.judged, from);
            let (ended, goes_on) = turns.next(model, condensed, known, observe)?;
            if !goes_on {
                let mut ended = ended.behind(before);
                parted.extend(share_out(
                    model,
                    condensed,
                    (&mut ended, &mut at.judged),
                    from,
                )?);
                turns.take_over(model, condensed, &mut at.judged)?;
                return Ok((ended, at.judged, parted));
            }
            guess = Some(ended.outcome.multipliers.clone());
            attempt = ended;
        }
        let guess = guess.as_ref().or(from.guess);
        at = Reached::begin(model, condensed, Start { guess, ..from }, observe)?;
        before = Some(attempt.behind(before));
    }
}

/// Forces that are not unique become the least ones, if the certificate holds with these as well; those of a solver from outside stay.
/// Returns a warning about them.
///
/// Errors: as [`equilibrate`].
fn share_out<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    (attempt, judged): (&mut Attempt<D>, &mut Judged<D>),
    from: Start<'_>,
) -> Result<Option<String>, Error<D>> {
    let pairs = (&condensed.bodies[..], &condensed.conditions[..]);
    let (lambda, gaps) = (&attempt.outcome.multipliers.lambda, &judged.displaced.gaps);
    let Some(shared) = shared_forces(model, pairs, &condensed.problem, lambda, gaps) else {
        return Ok(None);
    };
    let answer = from.own.is_none() && attempt.failure.is_none();
    if let Some(least) = shared.least.filter(|_| answer) {
        let mut outcome = attempt.outcome.clone();
        outcome.multipliers.lambda = least;
        let found = judge(model, condensed, &outcome, None)?;
        if excess(&found.certificate) <= excess(&judged.certificate).max(1.0) {
            (attempt.outcome, *judged) = (outcome, found);
        }
    }
    Ok(Some(shared.words))
}

/// Solves the present linear problem until the certificate holds or no move brings the forces nearer.
///
/// Errors: as [`equilibrate`].
pub(crate) fn certified<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    from: Start<'_>,
    observe: &mut dyn FnMut(Event),
) -> Result<(Attempt<D>, Judged<D>), Error<D>> {
    let mut at = Reached::begin(model, condensed, from, observe)?;
    while at.refine(model, condensed, from, observe)? {}
    Ok((at.attempt, at.judged))
}

/// A move on the linear problem; all that come before it lead no further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Move {
    /// Newton's method once more, with whole bodies that were in pieces for the time that this saves.
    Whole,
    /// Newton's method once more, with all entries of F. A crowd would have too many.
    Assemble,
    /// After Newton's method.
    Increment,
    /// So many have been taken.
    Finer(usize),
    /// There is no further one.
    End,
}

/// Forces of the linear problem, how they were found, and what displacements say of them.
struct Reached<const D: usize> {
    /// With the best forces.
    attempt: Attempt<D>,
    judged: Judged<D>,
    /// The last forces, where an increment has led away from the best ones.
    last: Option<(Outcome, Judged<D>)>,
    increments: usize,
    tolerance: f64,
    next: Move,
}

impl<const D: usize> Reached<D> {
    /// The answer of one run of the method.
    fn begin(
        model: &Model<D>,
        condensed: &Condensed<D>,
        from: Start<'_>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Self, Error<D>> {
        let attempt = run(model, condensed, from, observe)?;
        Ok(Self {
            judged: judge(model, condensed, &attempt.outcome, None)?,
            last: None,
            increments: 0,
            tolerance: model.solver.tolerance,
            next: match (from.own, model.solver.method) {
                (Some(_), _) => Move::End,
                (None, Method::Auto | Method::Newton) => Move::Whole,
                _ => Move::Finer(0),
            },
            attempt,
        })
    }

    /// Makes the next move; `false` where there is none.
    fn refine(
        &mut self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        from: Start<'_>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<bool, Error<D>> {
        loop {
            let (moved, after) = match self.next {
                Move::Whole => {
                    let moved = self.attempt.is_unfinished()
                        && self.make_whole(model, condensed, from, observe)?;
                    (moved, Move::Assemble)
                }
                Move::Assemble => {
                    let moved = self.assemble(model, condensed, from, observe)?;
                    (moved, Move::Increment)
                }
                Move::Increment => match self.increment(model, condensed, observe)? {
                    true => (true, Move::Increment),
                    false => (false, Move::Finer(0)),
                },
                Move::Finer(done) if done < FINER => {
                    match self.finer(model, condensed, observe)? {
                        true => (true, Move::Finer(done + 1)),
                        false => (false, Move::End),
                    }
                }
                // what no other move brings to an answer
                Move::Finer(_) | Move::End => {
                    let wrong = excess(&self.judged.certificate) > 1.0;
                    let moved = wrong
                        && from.own.is_none()
                        && self.make_whole(model, condensed, from, observe)?;
                    if !moved {
                        return Ok(false);
                    }
                    (true, Move::Assemble)
                }
            };
            self.next = after;
            if moved {
                return Ok(true);
            }
        }
    }

    /// Once more with whole bodies, where they are in pieces: where these give no answer, or none in the time of wholes.
    fn make_whole(
        &mut self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        from: Start<'_>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<bool, Error<D>> {
        let most = model.solver.max_iterations.unwrap_or(usize::MAX);
        let spent = self.attempt.outcome.iterations >= most;
        if spent || !make_whole(model, condensed, observe)? {
            return Ok(false);
        }
        (self.last, self.increments) = (None, 0);
        self.once_more(model, condensed, from, observe)?;
        Ok(true)
    }

    /// Newton's method once more on the changed problem.
    fn once_more(
        &mut self,
        model: &Model<D>,
        condensed: &Condensed<D>,
        from: Start<'_>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(), Error<D>> {
        let done = self.attempt.outcome.iterations;
        let how = (model.solver.method, self.tolerance, done);
        let further = run_method(model, condensed, how, from.guess, observe)?;
        self.attempt.follow(further);
        self.judged = judge(model, condensed, &self.attempt.outcome, None)?;
        Ok(())
    }

    /// Where Newton's method has no answer with an F that is applied: once more with all its entries.
    fn assemble(
        &mut self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        from: Start<'_>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<bool, Error<D>> {
        let problem = &mut condensed.problem;
        let open = self.attempt.is_unfinished() && !problem.is_crowd();
        if !open || !problem.assemble(ASSEMBLED) {
            return Ok(false);
        }
        self.once_more(model, condensed, from, observe)?;
        Ok(true)
    }

    /// An exact step in increments; the best forces count.
    fn increment(
        &mut self,
        model: &Model<D>,
        condensed: &Condensed<D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<bool, Error<D>> {
        let least = excess(&self.judged.certificate);
        let most = model.solver.max_iterations.unwrap_or(usize::MAX);
        let (outcome, judged) = match &self.last {
            Some((outcome, judged)) => (outcome, judged),
            None => (&self.attempt.outcome, &self.judged),
        };
        let allowed = (1..most).contains(&outcome.iterations) && self.increments < INCREMENTS;
        let known = (&judged.displaced.gaps[..], &judged.displaced.rounding[..]);
        let change = (allowed && least > 1.0)
            .then(|| correction(&condensed.problem, &outcome.multipliers, known));
        let Some(change) = change.flatten() else {
            self.end_increments(condensed, least);
            return Ok(false);
        };
        let outcome = outcome.corrected(&change);
        let judged = judge(model, condensed, &outcome, Some((judged, &change.lambda)))?;
        self.increments += 1;
        let left = excess(&judged.certificate);
        let point = HistoryPoint {
            iteration: outcome.iterations,
            residual: left * model.solver.tolerance,
            active: loaded(&outcome.multipliers.lambda),
        };
        observe(Event::Iteration(point));
        self.attempt.history.push(point);
        if left < least {
            (self.attempt.outcome, self.judged, self.last) = (outcome, judged, None);
        } else {
            self.last = Some((outcome, judged));
        }
        Ok(true)
    }

    /// The best forces are the answer of the increments. One whose certificate holds is an answer, whatever the method said.
    fn end_increments(&mut self, condensed: &Condensed<D>, least: f64) {
        let outcome = &mut self.attempt.outcome;
        if least <= 1.0 && (outcome.exact || is_unloaded(condensed, &outcome.multipliers.lambda)) {
            self.attempt.failure = None;
        }
        if let Some((last, _)) = self.last.take() {
            outcome.iterations = last.iterations;
        }
    }

    /// Goes on from an answer whose certificate does not hold, with a tolerance that much smaller and d corrected so that the
    /// gap of the dual problem at its forces is the gap of the displacements.
    fn finer(
        &mut self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<bool, Error<D>> {
        let worst = excess(&self.judged.certificate);
        if self.attempt.failure.is_some() || worst <= 1.0 {
            return Ok(false);
        }
        self.tolerance *= 0.5 / worst.min(1e3);
        let guess = self.attempt.outcome.multipliers.clone();
        let known = condensed.problem.gap(&guess);
        let shift = condensed.problem.shift.iter_mut();
        for ((d, gap), known) in shift.zip(&self.judged.displaced.gaps).zip(&known) {
            *d -= gap - known;
        }
        let how = (
            model.solver.method,
            self.tolerance,
            self.attempt.outcome.iterations,
        );
        let further = run_method(model, condensed, how, Some(&guess), observe)?;
        if further.failure.is_some() {
            return Ok(false);
        }
        let change = further.outcome.multipliers.lambda.iter().zip(&guess.lambda);
        let change: Vec<f64> = change.map(|(after, before)| after - before).collect();
        self.attempt.follow(further);
        let from = Some((&self.judged, &change[..]));
        self.judged = judge(model, condensed, &self.attempt.outcome, from)?;
        Ok(true)
    }
}

/// Forces below this part of the loads of what their contact couples are rounding.
const UNLOADED: f64 = 1e-13;

/// Whether all forces are rounding: what the contacts bear then is nothing, and a residual relative to it says nothing.
fn is_unloaded<const D: usize>(condensed: &Condensed<D>, lambda: &[f64]) -> bool {
    let coupled = &condensed.problem.coupled;
    let rows = lambda.iter().zip(&coupled.contact);
    rows.into_iter().all(|(force, &contact)| {
        force.abs() <= UNLOADED * coupled.scales[coupled.domain[contact]].force
    })
}

/// The worst figure of a certificate in its limits, infinite where one is no number; but for what no solver can change.
fn excess(certificate: &Certificate) -> f64 {
    let figures = certificate.figures().into_iter();
    figures
        .filter(|(name, _)| !NOT_OF_THE_SOLVER.contains(name))
        .map(|(_, f)| f.relative / f.limit)
        .fold(
            0.0,
            |s: f64, x| if x.is_nan() { f64::INFINITY } else { s.max(x) },
        )
}
