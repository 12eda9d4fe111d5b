//! assemble → order → factor → condense → solve → recover, each stage a function of the one before.

use crate::contact::InterfaceNode;
use crate::dual::{DualProblem, Multipliers, Scales};
use crate::fem::{BodySystem, assemble, show};
use crate::geometry::{bounding_box, distance, norm};
use crate::model::condense::{
    DENSE_LIMIT, FactoredBody, LoadedBody, Ordered, base_solution, body_rows,
    compliance_and_overlap, factor, order,
};
use crate::model::dependent::drop_dependent;
use crate::model::error::Error;
use crate::model::floating::Floating;
use crate::model::nouns::*;
use crate::model::pair::{Paired, admissible_set, pair_all};
use crate::model::recover::{Judged, judge};
use crate::model::solution::*;
use crate::solve::{
    Accelerated, ContactSolver, Gradient, Iterate, Mprgp, Newton, Outcome, SolveError, Uzawa,
};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::time::Instant;

/// What an observer of [`Model::solve_with`] is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
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

/// The bodies of a model condensed onto the contact unknowns.
pub(crate) struct Condensed<const D: usize> {
    pub bodies: Vec<LoadedBody<D>>,
    pub factored: Vec<FactoredBody>,
    pub paired: Vec<Paired<D>>,
    pub gaps: Vec<f64>,
    pub floating: Floating,
    pub problem: DualProblem,
    pub warnings: Vec<String>,
    pub seconds: Seconds,
}

impl<const D: usize> Model<D> {
    /// Solves the model.
    ///
    /// Errors: see [`Error`]; `NotConverged` carries the last iterate.
    pub fn solve(&self) -> Result<Solution<D>, Error<D>> {
        self.solve_with(&mut |_| {})
    }

    /// Solves the model and tells an observer what happens.
    ///
    /// Errors: see [`Error`]; `NotConverged` carries the last iterate.
    pub fn solve_with(&self, observe: &mut dyn FnMut(Event)) -> Result<Solution<D>, Error<D>> {
        let start = Instant::now();
        let mut condensed = self.condense(DENSE_LIMIT, observe)?;
        observe(Event::Stage("contact"));
        let clock = Instant::now();
        let (attempt, judged) = self.certified_attempt(&mut condensed, observe)?;
        condensed.seconds.contact = clock.elapsed().as_secs_f64();
        self.finish(condensed, attempt, judged, start, observe)
    }

    /// The dual contact problem of the model, for running or comparing solvers without the model: every multiplier in
    /// the order of the contacts and, within one, of [`crate::model::ContactSolution::nodes`] (nodes whose normal
    /// displacement is prescribed have none).
    ///
    /// F is assembled up to `dense_limit` unknowns ([`DENSE_LIMIT`] in [`Self::solve`]); above, each product is one solve
    /// with every body.
    /// Errors: as [`Self::solve`], but for those of the contact solver.
    pub fn dual_problem(&self, dense_limit: usize) -> Result<DualProblem, Error<D>> {
        Ok(self.condense(dense_limit, &mut |_| {})?.problem)
    }

    /// Runs the solver until the certificate holds.
    ///
    /// The solver knows F and d, the certificate judges displacements and energies computed afresh. Where they differ
    /// (rounding of the factorisation in a slender body, another scale of the energy), d is corrected so that the gap of
    /// the dual problem at the present λ is the gap of the displacements, and the solver goes on from its answer with a
    /// tolerance that much smaller: iterative refinement of the contact problem.
    fn certified_attempt(
        &self,
        condensed: &mut Condensed<D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<(Attempt, Judged<D>), Error<D>> {
        let mut tolerance = self.solver.tolerance;
        let mut attempt =
            self.run_solver(condensed, self.solver.method, tolerance, None, observe)?;
        let mut judged = judge(self, condensed, &attempt.outcome.multipliers)?;
        for _ in 0..3 {
            if attempt.failure.is_some() || judged.certificate.holds() {
                break;
            }
            let figures = judged.certificate.figures();
            let worst = figures
                .iter()
                .map(|(_, f)| f.relative / f.limit)
                .fold(1.0, f64::max);
            tolerance *= 0.5 / worst.min(1e3);
            let guess = attempt.outcome.multipliers.clone();
            let known = condensed.problem.gap(&guess);
            for ((d, gap), known) in condensed
                .problem
                .shift
                .iter_mut()
                .zip(&judged.gaps)
                .zip(&known)
            {
                *d -= gap - known;
            }
            let further = self.run_solver(
                condensed,
                self.solver.method,
                tolerance,
                Some(&guess),
                observe,
            )?;
            attempt = attempt.followed_by(further);
            judged = judge(self, condensed, &attempt.outcome.multipliers)?;
        }
        Ok((attempt, judged))
    }

    /// Everything before the contact solver: the bodies as a dual problem of at most `dense_limit` assembled unknowns.
    pub(crate) fn condense(
        &self,
        dense_limit: usize,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Condensed<D>, Error<D>> {
        self.validate()?;
        let mut seconds = Seconds::default();
        let mut clock = Instant::now();
        let mut lap = || {
            std::mem::replace(&mut clock, Instant::now())
                .elapsed()
                .as_secs_f64()
        };
        observe(Event::Stage("assemble"));
        self.check_probes()?;
        let systems = self.systems()?;
        let mut paired = pair_all(self, &systems)?;
        let mut warnings = drop_dependent(self, &systems, &mut paired);
        warnings.extend(paired.iter().flat_map(|pair| pair.warnings.clone()));
        let (rows, gaps) = body_rows(self, &systems, &paired);
        seconds.assemble = lap();
        let dense = gaps.len() <= dense_limit;
        observe(Event::Stage("order"));
        let ordered: Vec<Ordered> = (&systems, &rows)
            .into_par_iter()
            .enumerate()
            .map(|(body, (s, r))| order(self, body, s, r, dense))
            .collect::<Result<_, _>>()?;
        seconds.order = lap();
        observe(Event::Stage("factor"));
        let loaded = systems
            .into_par_iter()
            .zip(rows)
            .map(|(system, rows)| LoadedBody::new(system, rows));
        let bodies: Vec<LoadedBody<D>> = loaded.collect();
        let factored = self.factor_bodies(&bodies, &ordered)?;
        seconds.factor = lap();
        observe(Event::Stage("condense"));
        let (compliance, shift) =
            compliance_and_overlap(&bodies, &factored, &ordered, &gaps, dense);
        let floating = Floating::new(self, &bodies, &gaps)?;
        let equilibrium = floating.equilibrium.clone();
        let admissible = admissible_set(&paired);
        let mut problem = DualProblem::new(compliance, shift, admissible, equilibrium)
            .map_err(|error| Error::Solver(error.to_string()))?;
        problem.scales = self.scales(&bodies, &factored, &problem);
        seconds.condense = lap();
        warnings.extend(floating.warnings.iter().cloned());
        Ok(Condensed {
            bodies,
            factored,
            paired,
            gaps,
            floating,
            problem,
            warnings,
            seconds,
        })
    }

    /// Assembles all bodies.
    pub(crate) fn systems(&self) -> Result<Vec<BodySystem<D>>, Error<D>> {
        self.bodies
            .par_iter()
            .map(|body| {
                assemble(body, self.analysis, self.time).map_err(|source| Error::Body {
                    body: body.name.clone(),
                    source,
                })
            })
            .collect()
    }

    fn factor_bodies(
        &self,
        bodies: &[LoadedBody<D>],
        ordered: &[Ordered],
    ) -> Result<Vec<FactoredBody>, Error<D>> {
        let each = bodies.par_iter().zip(ordered).enumerate();
        each.map(|(index, (body, ordered))| {
            Ok(base_solution(
                body,
                factor(self, index, &body.system, ordered)?,
            ))
        })
        .collect()
    }

    /// The scales of the certificate: see its documentation.
    fn scales(
        &self,
        bodies: &[LoadedBody<D>],
        factored: &[FactoredBody],
        problem: &DualProblem,
    ) -> Scales {
        let resultant = |body: &LoadedBody<D>| {
            let forces = body.system.to_global(&body.system.load);
            norm(
                forces
                    .iter()
                    .fold([0.0; D], |sum, &f| crate::geometry::add_scaled(sum, 1.0, f)),
            )
        };
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
            length: problem
                .shift
                .iter()
                .fold(0.0, |largest, d| largest.max(d.abs())),
            force: bodies
                .iter()
                .map(|body| resultant(body).max(body.system.largest_load))
                .fold(0.0, f64::max),
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
                Some(format!("{reason} (residual {residual:.1e})")),
            ),
            Err(SolveError::Infeasible { direction }) => {
                return Err(condensed
                    .floating
                    .pulled_away(self, &condensed.bodies, &direction));
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
    fn carriers(&self, paired: &[Paired<D>]) -> Vec<(usize, [f64; D])> {
        let each = paired.iter().enumerate().flat_map(|(contact, pair)| {
            let points = self.bodies[pair.nonmortar.body.0].mesh.points();
            let rows = |node: &InterfaceNode<D>| node.rows.iter().flatten().count();
            pair.interface
                .carriers()
                .flat_map(move |node| vec![(contact, points[node.node]); rows(node)])
        });
        each.collect()
    }

    /// Recovers the solution of an attempt and judges it.
    pub(crate) fn finish(
        &self,
        condensed: Condensed<D>,
        attempt: Attempt,
        judged: Judged<D>,
        start: Instant,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Solution<D>, Error<D>> {
        observe(Event::Stage("recover"));
        let clock = Instant::now();
        let Attempt {
            method,
            outcome,
            history,
            failure,
        } = attempt;
        let Judged { certificate, .. } = judged;
        let mut warnings = condensed.warnings.clone();
        let bolts = self.bolt_reports(&outcome, &condensed.paired, &mut warnings);
        warnings.extend(outcome.remarks.iter().cloned());
        for body in &judged.hovering {
            warnings.push(format!(
                "body \"{body}\" hovers: it touches nothing and carries no load; it is placed by least norm of the displacement"
            ));
        }
        let (bodies, contacts) = judged.dress(self, &condensed, &outcome.multipliers.lambda)?;
        let converged = failure.is_none() && certificate.holds();
        let mut solution = Solution {
            time: self.time,
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
            },
            warnings,
            probes: Vec::new(),
            contact_unknowns: condensed.gaps.len(),
            threads: rayon::current_num_threads(),
            seconds: condensed.seconds,
        };
        solution.probes = self.read_probes(&solution)?;
        solution.seconds.recover = clock.elapsed().as_secs_f64();
        solution.seconds.total = start.elapsed().as_secs_f64();
        if solution.converged {
            return Ok(solution);
        }
        let reason = failure.unwrap_or_else(|| solution.certificate.objection());
        Err(Error::NotConverged {
            reason,
            solution: Box::new(solution),
        })
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

/// One run of a method.
pub(crate) struct Attempt {
    pub method: &'static str,
    pub outcome: Outcome,
    pub history: Vec<HistoryPoint>,
    /// Why it did not converge.
    pub failure: Option<String>,
}

impl Attempt {
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
