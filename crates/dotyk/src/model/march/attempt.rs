//! The contact solver and the certificate, in turns until the certificate holds.
//!
//! The solver knows F and d, the certificate judges displacements and energies computed afresh. Where they differ
//! (rounding of the factorisation in a slender body, another scale of the energy), Newton's answer is corrected by exact
//! steps in increments, whose gaps are those of the displacements; then, and after other methods, the iteration goes on
//! from there. Where an applied or sparse F is not enough (slender bodies), F is assembled after all.
//! A solver from outside is called once, and its answer is judged as it is.

use crate::dual::{Certificate, Multipliers, NOT_OF_THE_SOLVER};
use crate::fem::show;
use crate::geometry::{bounding_box, distance, norm, sub};
use crate::model::march::judge::{Judged, judge};
use crate::model::march::sliding::{slides_along, sliding};
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::event::Event;
use crate::model::nouns::model::{Bolts, Method, Model};
use crate::model::nouns::solution::HistoryPoint;
use crate::model::system::compliance::ASSEMBLED;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, carriers};
use crate::solve::{
    Accelerated, ContactSolver, FixedBounds, Foreign, Gradient, Iterate, Mprgp, Newton, Outcome,
    Secant, SolveError, Uzawa, correction, loaded,
};
use std::ops::ControlFlow;

/// Most corrections of an answer.
const CORRECTIONS: usize = 8;

/// One run of a method.
pub(crate) struct Attempt<const D: usize> {
    pub method: String,
    pub outcome: Outcome,
    pub history: Vec<HistoryPoint>,
    /// Why it did not converge.
    pub failure: Option<Objection<D>>,
}

/// How the contact problem of a load step is solved.
#[derive(Clone, Copy, Default)]
pub(crate) struct Start<'a> {
    /// A solver from outside, in place of the method of the model.
    pub own: Option<&'a dyn ContactSolver>,
    /// The forces to start from.
    pub guess: Option<&'a Multipliers>,
}

impl<const D: usize> Attempt<D> {
    /// It began and did not converge.
    fn unfinished(&self) -> bool {
        self.failure.is_some() && self.outcome.iterations > 0
    }

    /// This run and one that went on from its answer.
    pub fn followed_by(mut self, further: Self) -> Self {
        let done = self.outcome.iterations;
        self.history
            .extend(further.history.iter().map(|h| HistoryPoint {
                iteration: done + h.iteration,
                ..*h
            }));
        let (iterations, products) = (
            done + further.outcome.iterations,
            self.outcome.products + further.outcome.products,
        );
        let bolts = self
            .outcome
            .bolts
            .into_iter()
            .filter(|bolt| bolt.moved)
            .chain(further.outcome.bolts)
            .collect();
        let outcome = Outcome {
            iterations,
            products,
            bolts,
            ..further.outcome
        };
        Self {
            method: further.method,
            outcome,
            history: self.history,
            failure: further.failure,
        }
    }
}

/// Runs the solver until the certificate holds.
///
/// The solver knows F and d, the certificate judges displacements and energies computed afresh. Where they differ
/// (rounding of the factorisation in a slender body, another scale of the energy), Newton's answer is corrected by exact
/// steps in increments, whose gaps are those of the displacements; then, and after other methods, the iteration goes on
/// from there. Where an applied or sparse F is not enough (slender bodies), F is assembled after all, except for a crowd. The
/// answer of a solver from outside is not corrected.
pub(crate) fn certified_attempt<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    Start { own, guess }: Start<'_>,
    observe: &mut dyn FnMut(Event),
) -> Result<(Attempt<D>, Judged<D>), Error<D>> {
    let mut attempt = run(model, condensed, Start { own, guess }, observe)?;
    if own.is_some() {
        let judged = judge(model, condensed, &attempt.outcome, None)?;
        return Ok((attempt, judged));
    }
    let method = model.solver.method;
    let tolerance = model.solver.tolerance;
    let exact = matches!(method, Method::Auto | Method::Newton);
    let crowd = condensed.problem.is_crowd();
    if exact && attempt.unfinished() && !crowd && condensed.problem.assemble(ASSEMBLED) {
        let how = (method, tolerance, attempt.outcome.iterations);
        let again = run_method(model, condensed, how, guess, observe)?;
        attempt = attempt.followed_by(again);
    }
    let mut judged = judge(model, condensed, &attempt.outcome, None)?;
    if exact {
        (attempt, judged) = corrected(model, condensed, attempt, judged, observe)?;
    }
    continued(model, condensed, attempt, judged, observe)
}

/// Runs the method of the model, or a solver from outside, once.
///
/// Errors: bolts that are not at contact nodes; a problem that the method cannot solve.
pub(crate) fn run<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    Start { own, guess }: Start<'_>,
    observe: &mut dyn FnMut(Event),
) -> Result<Attempt<D>, Error<D>> {
    match own {
        Some(own) => run_solver(model, condensed, &Foreign(own), guess, &mut |_| {}, observe),
        None => {
            let how = (model.solver.method, model.solver.tolerance, 0);
            run_method(model, condensed, how, guess, observe)
        }
    }
}

/// Corrects an answer by exact steps in increments until its certificate holds; the best one counts.
fn corrected<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    mut attempt: Attempt<D>,
    judged: Judged<D>,
    observe: &mut dyn FnMut(Event),
) -> Result<(Attempt<D>, Judged<D>), Error<D>> {
    let solved = attempt.outcome.iterations > 0;
    let most = model.solver.max_iterations.unwrap_or(usize::MAX);
    let mut least = excess(&judged.certificate);
    let mut best = (attempt.outcome, judged);
    // the last one, where it is not the best
    let mut last: Option<(Outcome, Judged<D>)> = None;
    for _ in 0..CORRECTIONS {
        let (outcome, judged) = last.as_ref().unwrap_or(&best);
        if least <= 1.0 || !solved || outcome.iterations >= most {
            break;
        }
        let known = (&judged.displaced.gaps[..], &judged.displaced.rounding[..]);
        let Some(change) = correction(&condensed.problem, &outcome.multipliers, known) else {
            break;
        };
        let outcome = outcome.corrected(&change);
        let judged = judge(model, condensed, &outcome, Some((judged, &change.lambda)))?;
        let left = excess(&judged.certificate);
        let point = HistoryPoint {
            iteration: outcome.iterations,
            residual: left * model.solver.tolerance,
            active: loaded(&outcome.multipliers.lambda),
        };
        observe(Event::Iteration(point));
        attempt.history.push(point);
        if left < least {
            (least, best, last) = (left, (outcome, judged), None);
        } else {
            last = Some((outcome, judged));
        }
    }
    if least <= 1.0 && (best.0.exact || is_unloaded(condensed, &best.0.multipliers.lambda)) {
        attempt.failure = None;
    }
    let iterations = last.map_or(best.0.iterations, |(outcome, _)| outcome.iterations);
    attempt.outcome = Outcome {
        iterations,
        ..best.0
    };
    Ok((attempt, best.1))
}

/// Forces below this part of the loads in their domain are rounding.
const UNLOADED: f64 = 1e-13;

/// Whether all forces are rounding: the contacts then bear no force, and a residual relative to it is meaningless.
fn is_unloaded<const D: usize>(condensed: &Condensed<D>, lambda: &[f64]) -> bool {
    let coupled = &condensed.problem.coupled;
    let rows = lambda.iter().zip(&coupled.contact);
    rows.into_iter().all(|(force, &contact)| {
        force.abs() <= UNLOADED * coupled.scales[coupled.domain[contact]].force
    })
}

/// Goes on from an answer whose certificate does not hold, with a tolerance smaller by its excess, and with d corrected so that
/// the gap of the dual problem at its forces is the gap of the displacements.
fn continued<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    mut attempt: Attempt<D>,
    mut judged: Judged<D>,
    observe: &mut dyn FnMut(Event),
) -> Result<(Attempt<D>, Judged<D>), Error<D>> {
    let mut tolerance = model.solver.tolerance;
    for _ in 0..3 {
        let worst = excess(&judged.certificate);
        if attempt.failure.is_some() || worst <= 1.0 {
            break;
        }
        tolerance *= 0.5 / worst.min(1e3);
        let guess = attempt.outcome.multipliers.clone();
        let known = condensed.problem.gap(&guess);
        let shift = condensed.problem.shift.iter_mut();
        for ((d, gap), known) in shift.zip(&judged.displaced.gaps).zip(&known) {
            *d -= gap - known;
        }
        let how = (model.solver.method, tolerance, attempt.outcome.iterations);
        let further = run_method(model, condensed, how, Some(&guess), observe)?;
        if further.failure.is_some() {
            break;
        }
        let change = further.outcome.multipliers.lambda.iter().zip(&guess.lambda);
        let change: Vec<f64> = change.map(|(after, before)| after - before).collect();
        attempt = attempt.followed_by(further);
        judged = judge(model, condensed, &attempt.outcome, Some((&judged, &change)))?;
    }
    Ok((attempt, judged))
}

/// The worst figure of a certificate over its limit, infinite with a NaN; figures that no solver can change are left out.
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

/// Runs one method to a tolerance on the condensed problem, with the iterations that the model still allows after those done;
/// failing to converge is not yet an error.
pub(crate) fn run_method<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    (method, tolerance, done): (Method, f64, usize),
    guess: Option<&Multipliers>,
    observe: &mut dyn FnMut(Event),
) -> Result<Attempt<D>, Error<D>> {
    let most = model.solver.max_iterations;
    let left = most.map(|most| most.saturating_sub(done));
    let solver = solver(model, condensed, method, (tolerance, left))?;
    let exact = matches!(method, Method::Auto | Method::Newton);
    let mut unrest = Unrest::default();
    let mut look = |iterate: &Iterate<'_>| unrest.look_at(iterate);
    let solver = solver.as_ref();
    let mut attempt = run_solver(model, condensed, solver, guess, &mut look, observe)?;
    if let (Some(Objection::Unsettled { reason, .. }), Some(most)) = (&mut attempt.failure, most)
        && done + attempt.outcome.iterations >= most
    {
        *reason += &format!("; `max_iterations` allows {most}");
    }
    if exact && attempt.failure.is_none() {
        let remark = unrest.remark(model, &condensed.conditions, attempt.outcome.iterations);
        attempt.outcome.remarks.extend(remark);
    }
    Ok(attempt)
}

fn run_solver<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    solver: &dyn ContactSolver,
    guess: Option<&Multipliers>,
    look: &mut dyn FnMut(&Iterate<'_>),
    observe: &mut dyn FnMut(Event),
) -> Result<Attempt<D>, Error<D>> {
    let mut history = Vec::new();
    let mut watch = |iterate: &Iterate<'_>| {
        look(iterate);
        let point = HistoryPoint {
            iteration: iterate.iteration,
            residual: iterate.residual,
            active: iterate.active,
        };
        observe(Event::Iteration(point));
        history.push(point);
        ControlFlow::Continue(())
    };
    let outcome = solver.solve(&condensed.problem, guess, &mut watch);
    let (outcome, failure) = match outcome {
        Ok(outcome) => (outcome, None),
        Err(SolveError::NotConverged {
            outcome,
            residual,
            reason,
            ..
        }) => {
            let tried = &outcome.tried;
            let reason = match tried.is_empty() {
                true => reason,
                false => format!("{reason}; tried: {}", tried.join(", ")),
            };
            let failure = Objection::Unsettled {
                reason,
                residual,
                worst: None,
            };
            (*outcome, Some(failure))
        }
        Err(SolveError::Infeasible { direction, factor }) => {
            let before = condensed.state.load.as_ref();
            let admissible = &condensed.problem.admissible;
            let step = before.map(|(time, e)| ([*time, condensed.time], &e[..]));
            let Condensed {
                floating,
                bodies,
                conditions,
                ..
            } = condensed;
            let parts = (floating, &bodies[..], &conditions[..]);
            let slides = sliding(model, parts, admissible, (&direction, factor), step)?;
            (nowhere(condensed), Some(slides))
        }
        Err(SolveError::Slides { direction, factor }) => {
            let slides = slides_along(model, condensed, &direction, factor);
            (nowhere(condensed), Some(slides))
        }
        Err(SolveError::DependentBolts { bolts, modes }) => {
            let carriers = carriers(model, &condensed.conditions);
            let bolts = bolts.iter().map(|&i| carriers[i].1).collect();
            return Err(Error::Bolts { bolts, modes });
        }
        Err(other) => return Err(Error::Solver(other)),
    };
    Ok(Attempt {
        method: solver.name().to_string(),
        outcome,
        history,
        failure,
    })
}

/// The outcome for bodies that slide away: zero forces.
fn nowhere<const D: usize>(condensed: &Condensed<D>) -> Outcome {
    let multipliers = Multipliers {
        lambda: vec![0.0; condensed.gaps.len()],
        alpha: vec![0.0; condensed.problem.balance.load().len()],
    };
    Outcome::new(multipliers, 0)
}

/// Newton's method takes fewer iterations where friction is harmless: of ten thousand random problems 99 in 100 took less
/// than 40.
const MANY: usize = 60;

/// How much each force has changed in all iterations, the first half of [`MANY`] left out.
#[derive(Default)]
struct Unrest {
    iterations: usize,
    last: Vec<f64>,
    changes: Vec<f64>,
}

impl Unrest {
    fn look_at(&mut self, iterate: &Iterate<'_>) {
        self.iterations += 1;
        if self.iterations < MANY / 2 {
            return;
        }
        self.changes.resize(iterate.lambda.len(), 0.0);
        if !self.last.is_empty() {
            let both = iterate.lambda.iter().zip(&self.last);
            let moved = self.changes.iter_mut().zip(both);
            moved.for_each(|(sum, (now, before))| *sum += (now - before).abs());
        }
        self.last.clear();
        self.last.extend(iterate.lambda);
    }

    /// A remark on an answer that friction made hard to find.
    fn remark<const D: usize>(
        &self,
        model: &Model<D>,
        conditions: &[Condition<D>],
        iterations: usize,
    ) -> Option<String> {
        let rough = |condition: &Condition<D>| condition.slides().contains(&true);
        if iterations <= MANY || !conditions.iter().any(rough) {
            return None;
        }
        let changes = self.changes.iter().enumerate();
        let (row, _) = changes.max_by(|a, b| a.1.total_cmp(b.1))?;
        let (index, point) = *carriers(model, conditions).get(row)?;
        Some(format!(
            "friction took {iterations} iterations, and the forces of {} at {} changed most: the answer is certified, but may not be the only one; smaller load steps tell which one loading leads to",
            conditions[index].called(),
            show(point)
        ))
    }
}

fn solver<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    method: Method,
    (tolerance, most): (f64, Option<usize>),
) -> Result<Box<dyn ContactSolver>, Error<D>> {
    let rho = model.solver.rho;
    Ok(match method {
        Method::Auto | Method::Newton => limited(Newton::default(), tolerance, most),
        Method::Mprgp => limited(Mprgp::default(), tolerance, most),
        Method::Accelerated => limited(Accelerated::default(), tolerance, most),
        Method::Secant => limited(Secant::default(), tolerance, most),
        Method::Gradient => {
            let default = Gradient::default();
            limited(Gradient { rho, ..default }, tolerance, most)
        }
        Method::Uzawa => {
            let (bolts, default) = (bolt_indices(model, condensed)?, Uzawa::default());
            let solver = Uzawa {
                bolts,
                rho,
                ..default
            };
            limited(solver, tolerance, most)
        }
    })
}

/// A method with these limits; by default the number of iterations is its own.
fn limited<S: FixedBounds + 'static>(
    solver: S,
    tolerance: f64,
    most: Option<usize>,
) -> Box<dyn ContactSolver> {
    let most = most.unwrap_or(solver.limits().1);
    Box::new(solver.within(tolerance, most))
}

/// Contact unknowns nearest to the named bolts.
fn bolt_indices<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
) -> Result<Option<Vec<usize>>, Error<D>> {
    let Bolts::Points(points) = &model.solver.bolts else {
        return Ok(None);
    };
    let carriers = carriers(model, &condensed.conditions);
    points
        .iter()
        .map(|&point| {
            let nearest = carriers
                .iter()
                .enumerate()
                .min_by(|(_, a), (_, b)| distance(a.1, point).total_cmp(&distance(b.1, point)));
            let (index, &(contact, at)) = nearest.ok_or(Error::BoltWithoutContact)?;
            let side = &condensed.conditions[contact].nonmortar;
            let (low, high) = bounding_box(model.bodies[side.body.0].mesh.points());
            let distance = distance(at, point);
            if distance > 0.1 * norm(sub(high, low)) {
                return Err(Error::BoltAway {
                    bolt: point,
                    nearest: at,
                    distance,
                });
            }
            Ok(index)
        })
        .collect::<Result<Vec<_>, _>>()
        .map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Field;
    use crate::mesh::{CellKind, Diagonals, Rectangle};
    use crate::model::nouns::model::{CoupleKind, Elastic, Law};
    use crate::model::nouns::presence::Stage;
    use crate::model::system::condense::linearise;
    use crate::model::system::state::State;
    use std::sync::Arc;

    #[test]
    fn a_couple_is_named_where_its_forces_changed_most() {
        let rectangle = Rectangle {
            from: [0.0, 0.0],
            to: [2.0, 1.0],
            cells: [2, 1],
            cell: CellKind::Quad4,
            diagonals: Diagonals::default(),
        };
        let steel = Elastic {
            young: 210e3,
            poisson: 0.3,
        };
        let mut model = Model::new();
        let body = model.body("block", rectangle.build().unwrap(), steel);
        let couple = model.couple(body, "top", ("P", [1.0, 1.0]), CoupleKind::Rigid);
        couple.displacement = [0.0, -1e-3].map(|u| Some(Field::constant(u)));
        let floor = model.obstacle((body, "bottom"), Field::constant(0.0));
        floor.law = Law::Coulomb(Field::constant(0.2));
        let from = (1.0, Arc::new(State::new(&model, 1.0, false)));
        let (stage, anew) = (Stage::whole(&model), (None, ASSEMBLED));
        let made = linearise(&stage, from, anew, |_, _| Ok(()), &mut |_| {});
        let (condensed, ()) = made.unwrap();
        let rows = condensed.gaps.len();
        for (row, named) in [
            (0, "contact \"contact_1\""),
            (rows - 1, "rigid couple \"block.P\""),
        ] {
            let mut unrest = Unrest::default();
            let mut lambda = vec![0.0; rows];
            for iteration in 0..=MANY {
                lambda[row] = iteration as f64;
                unrest.look_at(&Iterate {
                    iteration,
                    lambda: &lambda,
                    residual: 1.0,
                    active: 1,
                    step: 'n',
                });
            }
            let told = unrest
                .remark(&model, &condensed.conditions, MANY + 1)
                .unwrap();
            assert!(told.contains(named), "{told}");
            assert_eq!(unrest.remark(&model, &condensed.conditions, MANY), None);
        }
    }
}
