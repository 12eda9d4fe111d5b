//! assemble → order → factor → condense → solve → recover, each stage a function of the one before.
//!
//! Load steps share everything but the data of their times: stiffness, factors, pairs and F are made once. A step takes
//! loads, prescribed displacements and gaps anew, which changes d and e alone, and begins from the answer of the step
//! before it.

use crate::contact::InterfaceNode;
use crate::dual::{BETWEEN_NODES, Certificate, DualProblem, Multipliers, Scales};
use crate::fem::{BodySystem, Constraints, FemError, Short, assemble, show};
use crate::geometry::{add_scaled, bounding_box, distance, norm};
use crate::model::condense::{
    DENSE_LIMIT, FactoredBody, LoadedBody, Ordered, body_rows, compliance, factor, gaps_after,
    initial_gaps, is_assembled, least_softness, order, overlap,
};
use crate::model::dependent::{drop_implied, shared_forces};
use crate::model::error::Error;
use crate::model::floating::Floating;
use crate::model::nouns::*;
use crate::model::pair::{Paired, admissible_set, gaps_at, neighbours, pair_all};
use crate::model::recover::{Judged, judge};
use crate::model::solution::*;
use crate::solve::{
    Accelerated, ContactSolver, Gradient, Iterate, Mprgp, Newton, Outcome, SolveError, Uzawa,
    correction, loaded,
};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

/// What an observer of [`Model::solve_with`] is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A load step begins; its stages and iterations follow.
    Step {
        /// From 1.
        step: usize,
        /// Number of steps of the model.
        steps: usize,
        /// Its time.
        time: f64,
    },
    /// A stage begins.
    Stage(&'static str),
    /// An iteration of the contact solver is done.
    Iteration {
        /// From 1.
        iteration: usize,
        /// Largest relative violation of the optimality conditions.
        residual: f64,
        /// Contact unknowns with a force.
        active: usize,
    },
}

/// The bodies of a model condensed onto the contact unknowns, at one time.
pub(crate) struct Condensed<const D: usize> {
    pub bodies: Vec<LoadedBody<D>>,
    pub factored: Vec<FactoredBody>,
    pub paired: Vec<Paired<D>>,
    pub gaps: Vec<f64>,
    pub floating: Floating,
    pub problem: DualProblem,
    /// What the user should know of the pairs.
    pub warnings: Vec<String>,
    /// Spent so far, earlier steps included.
    pub seconds: Seconds,
    pub time: f64,
    /// Time and e of the step before.
    pub before: Option<(f64, Vec<f64>)>,
}

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

impl<const D: usize> Model<D> {
    /// Solves the model and returns the solution of its last load step.
    ///
    /// Errors: see [`Error`]; `NotConverged` carries the last iterate.
    pub fn solve(&self) -> Result<Solution<D>, Error<D>> {
        self.solve_with(&mut |_| {})
    }

    /// The same, and tells an observer what happens.
    ///
    /// Errors: see [`Error`]; `NotConverged` carries the last iterate.
    pub fn solve_with(&self, observe: &mut dyn FnMut(Event)) -> Result<Solution<D>, Error<D>> {
        let last = self.solve_steps_with(observe)?.pop();
        last.ok_or_else(|| Error::Model(NO_STEP.to_string()))
    }

    /// Solves all load steps and returns their solutions in the order of the times, at least one.
    ///
    /// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
    pub fn solve_steps(&self) -> Result<Vec<Solution<D>>, Error<D>> {
        self.solve_steps_with(&mut |_| {})
    }

    /// The same, and tells an observer what happens.
    ///
    /// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
    pub fn solve_steps_with(
        &self,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Vec<Solution<D>>, Error<D>> {
        let start = Instant::now();
        self.validate()?;
        let mut done: Vec<Solution<D>> = Vec::with_capacity(self.times.len());
        let mut condensed: Option<Condensed<D>> = None;
        let mut last: Option<End> = None;
        for (index, &time) in self.times.iter().enumerate() {
            let (step, steps) = (index + 1, self.times.len());
            observe(Event::Step { step, steps, time });
            let solved = match (condensed.take(), &last) {
                (Some(before), Some(last)) => self.advance(before, &last.slip, time, observe),
                _ => self.condense(time, DENSE_LIMIT, observe),
            }
            .and_then(|mut here| {
                let solved = self.solve_step(&mut here, last.as_ref(), start, observe)?;
                Ok((here, solved))
            });
            match solved {
                Err(error) => return Err(self.in_step(step, error, done)),
                Ok((_, (_, solution, Some(reason)))) => {
                    return Err(Error::NotConverged {
                        reason,
                        solution: Box::new(solution),
                        earlier: done,
                    });
                }
                Ok((here, (end, solution, None))) => {
                    done.push(solution);
                    (condensed, last) = (Some(here), Some(end));
                }
            }
        }
        Ok(done)
    }

    /// An error of one step of several, which its message names; `earlier` are the steps before it.
    pub(crate) fn in_step(
        &self,
        step: usize,
        error: Error<D>,
        earlier: Vec<Solution<D>>,
    ) -> Error<D> {
        match self.times[..] {
            [_] => error,
            _ => Error::Step {
                step,
                time: self.times[step - 1],
                source: Box::new(error),
                earlier,
            },
        }
    }

    /// Solves the contact problem of one step from the answer of the step before it, and why it is not an answer.
    fn solve_step(
        &self,
        condensed: &mut Condensed<D>,
        previous: Option<&End>,
        start: Instant,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(End, Solution<D>, Option<String>), Error<D>> {
        observe(Event::Stage("contact"));
        let clock = Instant::now();
        let guess = previous.and_then(End::guess);
        let (attempt, judged) = self.certified_attempt(condensed, guess, observe)?;
        condensed.seconds.contact += clock.elapsed().as_secs_f64();
        self.finish(condensed, attempt, judged, start, observe)
    }

    /// The dual contact problem of the model, for running or comparing solvers without the model: every multiplier in
    /// the order of the contacts and, within one, of [`crate::model::ContactSolution::nodes`] (nodes whose normal
    /// displacement is prescribed have none).
    ///
    /// It is that of the last load step. F is assembled up to `dense_limit` nodes, or as many entries in all as theirs
    /// ([`DENSE_LIMIT`] in [`Self::solve`]), of many bodies without its zeros; above, each product is one solve with every
    /// body.
    /// Errors: as [`Self::solve`], but for those of the contact solver.
    pub fn dual_problem(&self, dense_limit: usize) -> Result<DualProblem, Error<D>> {
        self.validate()?;
        let condensed = self.condense(self.last_time(), dense_limit, &mut |_| {})?;
        Ok(condensed.problem)
    }

    /// Runs the solver until the certificate holds.
    ///
    /// The solver knows F and d, the certificate judges displacements and energies computed afresh. Where they differ
    /// (rounding of the factorisation in a slender body, another scale of the energy), Newton's answer is corrected by exact
    /// steps in increments, whose gaps are those of the displacements; then, and after other methods, the iteration goes on
    /// from there. Where an applied or sparse F does not do (slender bodies), F is assembled after all.
    fn certified_attempt(
        &self,
        condensed: &mut Condensed<D>,
        guess: Option<&Multipliers>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(Attempt, Judged<D>), Error<D>> {
        let method = self.solver.method;
        let tolerance = self.solver.tolerance;
        let exact = matches!(method, Method::Auto | Method::Newton);
        let mut attempt = self.run_solver(condensed, method, tolerance, guess, observe)?;
        if exact && attempt.unfinished() && condensed.problem.assemble(ASSEMBLED) {
            let again = self.run_solver(condensed, method, tolerance, guess, observe)?;
            attempt = attempt.followed_by(again);
        }
        let mut judged = judge(self, condensed, &attempt.outcome, None)?;
        if exact {
            (attempt, judged) = self.corrected(condensed, attempt, judged, observe)?;
        }
        self.continued(condensed, attempt, judged, observe)
    }

    /// Corrects an answer by exact steps in increments until its certificate holds; the best one counts.
    fn corrected(
        &self,
        condensed: &Condensed<D>,
        mut attempt: Attempt,
        judged: Judged<D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(Attempt, Judged<D>), Error<D>> {
        let solved = attempt.outcome.iterations > 0;
        let mut least = excess(&judged.certificate);
        let mut best = (attempt.outcome, judged);
        // the last one, where it is not the best
        let mut last: Option<(Outcome, Judged<D>)> = None;
        for _ in 0..CORRECTIONS {
            let (outcome, judged) = last.as_ref().unwrap_or(&best);
            if least <= 1.0 || !solved {
                break;
            }
            let known = (&judged.gaps[..], &judged.rounding[..]);
            let Some(change) = correction(&condensed.problem, &outcome.multipliers, known) else {
                break;
            };
            let outcome = outcome.corrected(&change);
            let judged = judge(self, condensed, &outcome, Some((judged, &change.lambda)))?;
            let left = excess(&judged.certificate);
            let (iteration, residual) = (outcome.iterations, left * self.solver.tolerance);
            let active = loaded(&outcome.multipliers.lambda);
            observe(Event::Iteration {
                iteration,
                residual,
                active,
            });
            attempt.history.push(HistoryPoint {
                iteration,
                residual,
                active,
            });
            if left < least {
                (least, best, last) = (left, (outcome, judged), None);
            } else {
                last = Some((outcome, judged));
            }
        }
        if least <= 1.0 && best.0.exact {
            attempt.failure = None;
        }
        let iterations = last.map_or(best.0.iterations, |(outcome, _)| outcome.iterations);
        attempt.outcome = Outcome {
            iterations,
            ..best.0
        };
        Ok((attempt, best.1))
    }

    /// Goes on from an answer whose certificate does not hold, with a tolerance that much smaller and d corrected so that the
    /// gap of the dual problem at its forces is the gap of the displacements.
    fn continued(
        &self,
        condensed: &mut Condensed<D>,
        mut attempt: Attempt,
        mut judged: Judged<D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(Attempt, Judged<D>), Error<D>> {
        let mut tolerance = self.solver.tolerance;
        for _ in 0..3 {
            let worst = excess(&judged.certificate);
            if attempt.failure.is_some() || worst <= 1.0 {
                break;
            }
            tolerance *= 0.5 / worst.min(1e3);
            let guess = attempt.outcome.multipliers.clone();
            let known = condensed.problem.gap(&guess);
            let shift = condensed.problem.shift.iter_mut();
            for ((d, gap), known) in shift.zip(&judged.gaps).zip(&known) {
                *d -= gap - known;
            }
            let method = self.solver.method;
            let further = self.run_solver(condensed, method, tolerance, Some(&guess), observe)?;
            if further.failure.is_some() {
                break;
            }
            let change = further.outcome.multipliers.lambda.iter().zip(&guess.lambda);
            let change: Vec<f64> = change.map(|(after, before)| after - before).collect();
            attempt = attempt.followed_by(further);
            judged = judge(self, condensed, &attempt.outcome, Some((&judged, &change)))?;
        }
        Ok((attempt, judged))
    }

    /// Everything before the contact solver: the bodies at a time as a dual problem of at most `dense_limit` assembled
    /// unknowns. The model must be valid.
    pub(crate) fn condense(
        &self,
        time: f64,
        dense_limit: usize,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Condensed<D>, Error<D>> {
        let mut seconds = Seconds::default();
        let mut lap = Lap::start();
        observe(Event::Stage("assemble"));
        self.check_probes()?;
        let systems = self.systems(time)?;
        let constraints: Vec<&Constraints<D>> = systems.iter().map(|s| &s.constraints).collect();
        let mut paired = pair_all(self, &constraints, time)?;
        let mut warnings = drop_implied(self, &systems, &mut paired);
        warnings.extend(paired.iter().flat_map(|pair| pair.warnings.clone()));
        warnings.extend(self.remarks(&paired));
        let rows = body_rows(&systems, &paired);
        let gaps = initial_gaps(&paired);
        seconds.assemble = lap.seconds();
        // the limit counts nodes: under friction each has one more row
        let rough = paired.iter().flat_map(|p| p.interface.tangential());
        let rows_per_node = 1 + usize::from(rough.into_iter().any(|tangential| tangential));
        let dense = is_assembled(&rows, gaps.len(), dense_limit, rows_per_node);
        observe(Event::Stage("order"));
        let ordered: Vec<Ordered> = (&systems, &rows)
            .into_par_iter()
            .enumerate()
            .map(|(body, (s, r))| order(self, body, s, r, dense))
            .collect::<Result<_, _>>()?;
        seconds.order = lap.seconds();
        observe(Event::Stage("factor"));
        let loaded = systems
            .into_par_iter()
            .zip(rows)
            .map(|(system, rows)| LoadedBody::new(system, rows));
        let bodies: Vec<LoadedBody<D>> = loaded.collect();
        let factored = self.factor_bodies(&bodies, &ordered)?;
        seconds.factor = lap.seconds();
        observe(Event::Stage("condense"));
        let compliance = compliance(&bodies, &factored, &ordered, gaps.len(), dense);
        let floating = Floating::new(self, &bodies, &gaps)?;
        let equilibrium = floating.equilibrium.clone();
        let admissible = admissible_set(self, &paired, time)?;
        let shift = overlap(&bodies, &factored, &gaps);
        let mut problem = DualProblem::new(compliance, shift, admissible, equilibrium)
            .map_err(|error| Error::Solver(error.to_string()))?;
        problem.scales = self.scales(&bodies, &factored, &problem.shift);
        problem.soften(least_softness(&bodies, gaps.len()));
        problem.neighbours = neighbours(self, &paired);
        seconds.condense = lap.seconds();
        Ok(Condensed {
            bodies,
            factored,
            paired,
            gaps,
            floating,
            problem,
            warnings,
            seconds,
            time,
            before: None,
        })
    }

    /// The same bodies at another time, after a slip: d, e and the friction bounds are taken anew, all else stays.
    fn advance(
        &self,
        before: Condensed<D>,
        slip: &[f64],
        time: f64,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Condensed<D>, Error<D>> {
        let mut lap = Lap::start();
        let mut seconds = before.seconds;
        observe(Event::Stage("loads"));
        let (bodies, paired) = self.driven(before.bodies, before.paired, time)?;
        let gaps = gaps_after(&paired, slip);
        seconds.assemble += lap.seconds();
        observe(Event::Stage("condense"));
        let factored: Vec<FactoredBody> = (&bodies, before.factored)
            .into_par_iter()
            .map(|(body, factored)| FactoredBody::new(body, factored.factor))
            .collect();
        let floating = before.floating.at_time(self, &bodies, &gaps)?;
        let mut problem = before.problem;
        let load_before = problem.equilibrium.load.clone();
        problem.admissible = admissible_set(self, &paired, time)?;
        problem.equilibrium = floating.equilibrium.clone();
        problem.shift = overlap(&bodies, &factored, &gaps);
        problem
            .check()
            .map_err(|error| Error::Solver(error.to_string()))?;
        problem.scales = self.scales(&bodies, &factored, &problem.shift);
        seconds.condense += lap.seconds();
        Ok(Condensed {
            bodies,
            factored,
            paired,
            gaps,
            floating,
            problem,
            warnings: before.warnings,
            seconds,
            time,
            before: Some((before.time, load_before)),
        })
    }

    /// Bodies and pairs with the loads, prescribed displacements and gaps of another time.
    pub(crate) fn driven(
        &self,
        bodies: Vec<LoadedBody<D>>,
        paired: Vec<Paired<D>>,
        time: f64,
    ) -> Result<(Vec<LoadedBody<D>>, Vec<Paired<D>>), Error<D>> {
        let mut obstacles = bodies;
        let bodies = obstacles.drain(..self.bodies.len()).collect::<Vec<_>>();
        let mut bodies: Vec<LoadedBody<D>> = (&self.bodies, bodies)
            .into_par_iter()
            .map(|(body, loaded)| {
                let system = loaded.system.at_time(body, self.analysis, time);
                let system = system.map_err(|source| in_body(body, source))?;
                Ok(LoadedBody::new(system, loaded.rows))
            })
            .collect::<Result<_, _>>()?;
        let systems = self.obstacle_systems(time)?.into_iter();
        let rows = obstacles.into_iter().map(|obstacle| obstacle.rows);
        bodies.extend(systems.zip(rows).map(|(s, r)| LoadedBody::new(s, r)));
        let constraints: Vec<&Constraints<D>> =
            bodies.iter().map(|b| &b.system.constraints).collect();
        let paired = gaps_at(self, &constraints, paired, time)?;
        Ok((bodies, paired))
    }

    /// Assembles all bodies at a time; free obstacles follow them.
    pub(crate) fn systems(&self, time: f64) -> Result<Vec<BodySystem<D>>, Error<D>> {
        let bodies = self.bodies.par_iter();
        let system =
            |body| assemble(body, self.analysis, time).map_err(|source| in_body(body, source));
        let mut systems = bodies.map(system).collect::<Result<Vec<_>, _>>()?;
        systems.extend(self.obstacle_systems(time)?);
        Ok(systems)
    }

    fn factor_bodies(
        &self,
        bodies: &[LoadedBody<D>],
        ordered: &[Ordered],
    ) -> Result<Vec<FactoredBody>, Error<D>> {
        let each = bodies.par_iter().zip(ordered).enumerate();
        each.map(|(index, (body, ordered))| {
            let factor = factor(self, index, &body.system, ordered)?;
            Ok(FactoredBody::new(body, Arc::new(factor)))
        })
        .collect()
    }

    /// The scales of the certificate: see its documentation.
    fn scales(&self, bodies: &[LoadedBody<D>], factored: &[FactoredBody], shift: &[f64]) -> Scales {
        // a floating body's energy without contact depends on how it is held for K⁺: leave it out
        let held = bodies
            .iter()
            .zip(factored)
            .filter(|(body, _)| body.system.modes.is_empty());
        let stored = held.map(|(body, f)| -> f64 {
            f.base
                .iter()
                .zip(&body.reduced_load)
                .map(|(u, f)| 0.5 * u * f)
                .sum()
        });
        Scales {
            length: shift.iter().fold(0.0, |largest, d| largest.max(d.abs())),
            force: largest_load(bodies),
            moment_arm: self
                .bodies
                .iter()
                .map(|body| body.mesh.diameter())
                .fold(0.0, f64::max),
            energy: stored.sum::<f64>().abs(),
        }
    }

    pub(crate) fn validate(&self) -> Result<(), Error<D>> {
        if self.bodies.is_empty() {
            return Err(Error::Model("the model has no body".to_string()));
        }
        if (self.analysis == Analysis::Solid) != (D == 3) {
            return Err(Error::Model(format!(
                "analysis \"{}\" does not fit {D} dimensions",
                self.analysis.name()
            )));
        }
        if self.times.is_empty() {
            return Err(Error::Model(NO_STEP.to_string()));
        }
        let rising = |pair: &[f64]| pair[0] < pair[1];
        if !self.times.iter().all(|time| time.is_finite()) || !self.times.windows(2).all(rising) {
            return Err(Error::Model(format!(
                "the times of the load steps must be finite and increase, found {:?}",
                self.times
            )));
        }
        let bodies = self.bodies.iter().map(|body| ("body", &body.name));
        let contacts = self
            .contacts
            .iter()
            .map(|contact| ("contact", &contact.name));
        let mut seen = BTreeSet::new();
        for (kind, name) in bodies.chain(contacts) {
            if !seen.insert((kind, name)) {
                return Err(Error::Model(format!("two {kind}s are named \"{name}\"")));
            }
        }
        Ok(())
    }

    /// Runs one method on the condensed problem; failing to converge is not yet an error.
    pub(crate) fn run_solver(
        &self,
        condensed: &Condensed<D>,
        method: Method,
        tolerance: f64,
        guess: Option<&Multipliers>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Attempt, Error<D>> {
        let solver = self.solver(condensed, method, tolerance)?;
        let mut history = Vec::new();
        let mut watch = |iterate: &Iterate<'_>| {
            let Iterate {
                iteration,
                residual,
                active,
                ..
            } = *iterate;
            history.push(HistoryPoint {
                iteration,
                residual,
                active,
            });
            observe(Event::Iteration {
                iteration,
                residual,
                active,
            });
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
            }) => (
                *outcome,
                Some(match residual.is_finite() {
                    true => format!("{reason} (residual {residual:.1e})"),
                    false => reason,
                }),
            ),
            Err(SolveError::Infeasible { direction }) => {
                let Some(slides) = self.sliding(condensed) else {
                    let floating = &condensed.floating;
                    return Err(floating.pulled_away(self, &condensed.bodies, &direction));
                };
                let multipliers = Multipliers {
                    lambda: vec![0.0; condensed.gaps.len()],
                    alpha: vec![0.0; condensed.problem.equilibrium.load.len()],
                };
                (Outcome::unsolved(multipliers), Some(slides))
            }
            Err(SolveError::DependentBolts { bolts, modes }) => {
                let carriers = self.carriers(&condensed.paired);
                let places: Vec<String> = bolts.iter().map(|&i| show(carriers[i].1)).collect();
                return Err(Error::Solver(format!(
                    "the bolts at {} do not hold the rigid motions that the contacts control, {modes} in number: name one contact node for each, or leave out `bolt`",
                    places.join(", ")
                )));
            }
            Err(other) => return Err(Error::Solver(other.to_string())),
        };
        Ok(Attempt {
            method: solver.name(),
            outcome,
            history,
            failure,
        })
    }

    fn solver(
        &self,
        condensed: &Condensed<D>,
        method: Method,
        tolerance: f64,
    ) -> Result<Box<dyn ContactSolver>, Error<D>> {
        let limit = self.solver.max_iterations;
        let rho = self.solver.rho;
        Ok(match method {
            Method::Auto | Method::Newton => {
                let default = Newton::default();
                Box::new(Newton {
                    tolerance,
                    max_iterations: limit.unwrap_or(default.max_iterations),
                })
            }
            Method::Mprgp => {
                let default = Mprgp::default();
                Box::new(Mprgp {
                    tolerance,
                    max_iterations: limit.unwrap_or(default.max_iterations),
                })
            }
            Method::Gradient => {
                let default = Gradient::default();
                Box::new(Gradient {
                    rho,
                    tolerance,
                    max_iterations: limit.unwrap_or(default.max_iterations),
                })
            }
            Method::Accelerated => {
                let default = Accelerated::default();
                Box::new(Accelerated {
                    tolerance,
                    max_iterations: limit.unwrap_or(default.max_iterations),
                })
            }
            Method::Uzawa => {
                let default = Uzawa::default();
                let bolts = self.bolt_indices(condensed)?;
                let max_iterations = limit.unwrap_or(default.max_iterations);
                Box::new(Uzawa {
                    bolts,
                    rho,
                    tolerance,
                    max_iterations,
                    ..default
                })
            }
        })
    }

    /// Contact unknowns nearest to the named bolts.
    fn bolt_indices(&self, condensed: &Condensed<D>) -> Result<Option<Vec<usize>>, Error<D>> {
        let Bolts::Points(points) = &self.solver.bolts else {
            return Ok(None);
        };
        let carriers = self.carriers(&condensed.paired);
        points
            .iter()
            .map(|&point| {
                let nearest = carriers.iter().enumerate().min_by(|(_, a), (_, b)| {
                    distance(a.1, point).total_cmp(&distance(b.1, point))
                });
                let (index, &(contact, at)) = nearest
                    .ok_or_else(|| Error::Solver("a bolt is named, but there is no contact".to_string()))?;
                let side = &condensed.paired[contact].nonmortar;
                let (low, high) = bounding_box(self.bodies[side.body.0].mesh.points());
                if distance(at, point) > 0.1 * distance(low, high) {
                    return Err(Error::Solver(format!(
                        "bolt {}: the nearest contact node, {}, is {:.3e} away; name a point on a contact",
                        show(point),
                        show(at),
                        distance(at, point)
                    )));
                }
                Ok(index)
            })
            .collect::<Result<Vec<_>, _>>()
            .map(Some)
    }

    /// Contact and undeformed position of every multiplier.
    pub(crate) fn carriers(&self, paired: &[Paired<D>]) -> Vec<(usize, [f64; D])> {
        let each = paired.iter().enumerate().flat_map(|(contact, pair)| {
            let points = self.bodies[pair.nonmortar.body.0].mesh.points();
            let rows = |node: &InterfaceNode<D>| node.rows.iter().flatten().count();
            pair.interface
                .carriers()
                .flat_map(move |node| vec![(contact, points[node.node]); rows(node)])
        });
        each.collect()
    }

    /// Recovers the solution of an attempt, and why it is not an answer.
    fn finish(
        &self,
        condensed: &mut Condensed<D>,
        attempt: Attempt,
        judged: Judged<D>,
        start: Instant,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(End, Solution<D>, Option<String>), Error<D>> {
        observe(Event::Stage("recover"));
        let clock = Instant::now();
        let Attempt {
            method,
            outcome,
            history,
            failure,
        } = attempt;
        let Judged {
            certificate,
            overlap,
            ..
        } = judged;
        let mut warnings = condensed.warnings.clone();
        warnings.extend(condensed.floating.warnings.iter().cloned());
        let bolts = self.bolt_reports(&outcome, &condensed.paired, &mut warnings);
        warnings.extend(outcome.remarks.iter().cloned());
        // a body that slides away has no position to tell of
        let placed = failure.is_none() || outcome.iterations > 0;
        for body in judged.hovering.iter().filter(|_| placed) {
            warnings.push(format!(
                "body \"{body}\" hovers: it touches nothing and carries no load; it is placed by least norm of the displacement"
            ));
        }
        warnings.extend(judged.crude_gaps(self, condensed));
        warnings.extend(shared_forces(
            self,
            condensed,
            &outcome.multipliers.lambda,
            &judged.gaps,
        ));
        let slip = judged.slip(condensed);
        let (bodies, contacts) = judged.dress(self, condensed, &outcome.multipliers.lambda)?;
        let converged = failure.is_none() && certificate.holds();
        let mut solution = Solution {
            time: condensed.time,
            dofs: bodies.iter().map(|body| body.dofs).sum(),
            bodies,
            contacts,
            certificate,
            converged,
            solver: SolverReport {
                method,
                iterations: outcome.iterations,
                products: outcome.products,
                rho: outcome.rho,
                history,
                bolts,
                contraction: outcome.fixed_point.and_then(|found| found.contraction),
            },
            warnings,
            probes: Vec::new(),
            contact_unknowns: condensed.gaps.len(),
            threads: rayon::current_num_threads(),
            seconds: condensed.seconds,
        };
        solution.probes = self.read_probes(&solution)?;
        condensed.seconds.recover += clock.elapsed().as_secs_f64();
        condensed.seconds.total = start.elapsed().as_secs_f64();
        solution.seconds = condensed.seconds;
        let certificate = &solution.certificate;
        let multipliers = outcome.multipliers;
        let objection = (!converged).then(|| {
            let overlap = overlap.filter(|_| !certificate.between_nodes.holds());
            let objection = || match overlap {
                Some(place) => format!(
                    "{}: the sides of contact \"{}\" overlap by {} at {}",
                    certificate.objection(),
                    self.contacts[place.contact].name,
                    Short(place.depth),
                    show(place.point)
                ),
                None => certificate.objection(),
            };
            match failure {
                Some(reason) if outcome.iterations > 0 => {
                    reason + &self.unsettled(condensed, &multipliers)
                }
                Some(reason) => reason,
                None => objection(),
            }
        });
        Ok((End { multipliers, slip }, solution, objection))
    }

    fn bolt_reports(
        &self,
        outcome: &Outcome,
        paired: &[Paired<D>],
        warnings: &mut Vec<String>,
    ) -> Vec<BoltReport<D>> {
        let carriers = self.carriers(paired);
        let report = |bolt: &crate::solve::Bolt| {
            let (contact, point) = carriers[bolt.index];
            let contact = self.contacts[contact].name.clone();
            BoltReport {
                contact,
                point,
                force: bolt.force,
                moved: bolt.moved,
            }
        };
        let reports: Vec<BoltReport<D>> = outcome.bolts.iter().map(report).collect();
        for bolt in reports.iter().filter(|bolt| bolt.moved) {
            warnings.push(format!(
                "the bolt of contact \"{}\" at {} was improper: its force was {:.6e}, a tension; it was moved",
                bolt.contact,
                show(bolt.point),
                bolt.force
            ));
        }
        reports
    }
}

/// The largest resultant load of any body, and of any load by itself.
pub(crate) fn largest_load<const D: usize>(bodies: &[LoadedBody<D>]) -> f64 {
    let resultant = |body: &LoadedBody<D>| {
        let forces = body.system.to_global(&body.system.load).into_iter();
        norm(forces.fold([0.0; D], |sum, f| add_scaled(sum, 1.0, f)))
    };
    let loads = bodies
        .iter()
        .map(|body| resultant(body).max(body.system.largest_load));
    loads.fold(0.0, f64::max)
}

const NO_STEP: &str = "the model has no load step; give it at least one time";

fn in_body<const D: usize>(body: &Body<D>, source: FemError) -> Error<D> {
    Error::Body {
        body: body.name.clone(),
        source,
    }
}

/// A stopwatch of stages.
struct Lap(Instant);

impl Lap {
    fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the last call.
    fn seconds(&mut self) -> f64 {
        let last = std::mem::replace(&mut self.0, Instant::now());
        last.elapsed().as_secs_f64()
    }
}

/// Most contact unknowns for which F is assembled where iterations within a step do not do (512 MB).
const ASSEMBLED: usize = 8192;

/// Most corrections of an answer.
const CORRECTIONS: usize = 8;

/// The worst figure of a certificate in its limits, infinite where one is no number; but for what happens between the nodes,
/// which is not the solver's.
fn excess(certificate: &Certificate) -> f64 {
    let figures = certificate.figures().into_iter();
    figures
        .filter(|(name, _)| *name != BETWEEN_NODES)
        .map(|(_, f)| f.relative / f.limit)
        .fold(
            0.0,
            |s: f64, x| if x.is_nan() { f64::INFINITY } else { s.max(x) },
        )
}

/// One run of a method.
pub(crate) struct Attempt {
    pub method: &'static str,
    pub outcome: Outcome,
    pub history: Vec<HistoryPoint>,
    /// Why it did not converge.
    pub failure: Option<String>,
}

impl Attempt {
    /// It began and did not converge.
    fn unfinished(&self) -> bool {
        self.failure.is_some() && self.outcome.iterations > 0
    }

    /// This run and one that went on from its answer.
    fn followed_by(mut self, further: Self) -> Self {
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
