//! One run of a method on the dual problem of a step, and why it has no answer.
//!
//! Failing to converge is not yet an error: what follows from it is decided where all moves of a step are (`equilibrate.rs`). A
//! solver from outside is called once.

use crate::dual::Multipliers;
use crate::fem::show;
use crate::geometry::{bounding_box, distance, norm, sub};
use crate::model::march::sliding::{slides_along, sliding};
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::event::Event;
use crate::model::nouns::model::{Bolts, Method, Model};
use crate::model::nouns::solution::HistoryPoint;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, carriers};
use crate::solve::{
    Accelerated, ContactSolver, FixedBounds, Foreign, Gradient, Iterate, Mprgp, Newton, Outcome,
    Secant, SolveError, Uzawa,
};
use std::ops::ControlFlow;

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
    pub fn is_unfinished(&self) -> bool {
        self.failure.is_some() && self.outcome.iterations > 0
    }

    /// Another run has gone on from its answer, or begun anew.
    pub fn follow(&mut self, further: Self) {
        let mut outcome = further.outcome;
        let done = self.outcome.iterations;
        let later = further.history.iter().map(|point| HistoryPoint {
            iteration: done + point.iteration,
            ..*point
        });
        self.history.extend(later);
        outcome.iterations += done;
        outcome.products += self.outcome.products;
        let moved = self.outcome.bolts.drain(..).filter(|bolt| bolt.moved);
        outcome.bolts = moved.chain(outcome.bolts).collect();
        (self.method, self.outcome, self.failure) = (further.method, outcome, further.failure);
    }

    /// This run behind others.
    pub fn behind(self, before: Option<Self>) -> Self {
        match before {
            Some(mut before) => {
                before.follow(self);
                before
            }
            None => self,
        }
    }
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
            conditions[index].called(model),
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
    use crate::model::system::compliance::ASSEMBLED;
    use crate::model::system::condense::{Purpose, linearise};
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
        let (stage, anew) = (Stage::whole(&model), (None, Purpose::others(ASSEMBLED)));
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
