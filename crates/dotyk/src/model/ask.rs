//! What a model can be asked: its solution, its dual problem, a check, a comparison of solvers.

use crate::dual::DualProblem;
use crate::model::check::{Check, check};
use crate::model::compare::{ComparisonRow, compare, compare_steps};
use crate::model::condense::condense;
use crate::model::error::Error;
use crate::model::event::Event;
use crate::model::nouns::{Analysis, Contact, Law, Model};
use crate::model::past::Past;
use crate::model::reuse::Reuse;
use crate::model::solution::Solution;
use crate::model::steps::{Given, solve_steps};
use std::collections::BTreeSet;

/// What is generic is compiled again in every program that calls it, at a minute each. So the doors are not: behind them
/// everything is compiled here, once for each dimension.
macro_rules! doors {
    ($($D:literal)*) => {$(
        impl Model<$D> {
            /// Solves the model and returns the solution of its last load step.
            ///
            /// Errors: see [`Error`]; `NotConverged` carries the last iterate.
            pub fn solve(&self) -> Result<Solution<$D>, Error<$D>> {
                let last = self.solve_steps()?.pop();
                last.ok_or(Error::NoStep)
            }

            /// Solves all load steps and returns their solutions in the order of the times, at least one.
            ///
            /// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
            pub fn solve_steps(&self) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.solve_steps_with(&mut |_| {})
            }

            /// The same, and tells an observer what happens.
            ///
            /// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
            pub fn solve_steps_with(
                &self,
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.validate()?;
                solve_steps(self, Given::NONE, None, observe)
            }

            /// The same, after steps that were solved before: the first ones of this model, with the same forces. They
            /// are solved again from these, which takes no iterations to speak of, and are in the answer.
            ///
            /// Errors: as [`Self::solve_steps_with`]; `Past` where such a step is none of this model, `NothingLeft` where
            /// all steps are.
            pub fn solve_steps_after(
                &self,
                past: &[Past<$D>],
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.validate()?;
                let given = Given { past, own: None };
                solve_steps(self, given, None, observe)
            }

            /// All load steps, with what another model of the same stiffness has left: nothing is factored or condensed again where
            /// only loads, friction, prescribed values or steps differ.
            ///
            /// Errors: as [`Self::solve_steps_with`].
            pub fn solve_steps_reusing(
                &self,
                reuse: &mut Reuse<$D>,
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.validate()?;
                solve_steps(self, Given::NONE, Some(reuse), observe)
            }

            /// The dual contact problem of the model, for running or comparing solvers without the model: every
            /// multiplier in the order of the contacts and, within one, of [`crate::model::ContactSolution::nodes`]
            /// (nodes whose normal displacement is prescribed have none).
            ///
            /// It is that of the last load step. F is assembled up to `dense_limit` nodes, or as many entries in all
            /// as theirs ([`DENSE_LIMIT`](crate::model::DENSE_LIMIT) in [`Self::solve`]), of many bodies without its
            /// zeros; above, each product is one solve with every body.
            ///
            /// Errors: as [`Self::solve`], but for those of the contact solver.
            pub fn dual_problem(&self, dense_limit: usize) -> Result<DualProblem, Error<$D>> {
                self.validate()?;
                let condensed = condense(self, self.last_time(), dense_limit, &mut |_| {})?;
                Ok(condensed.problem)
            }

            /// Checks meshes, supports, loads, floating bodies and contacts; solves nothing.
            pub fn check(&self) -> Check<$D> {
                check(self, self.validate())
            }

            /// Runs every named method on the last load step of the model, each from its own start.
            ///
            /// Errors: those of [`Model::solve`] that come before the contact solver.
            pub fn compare(
                &self,
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<ComparisonRow>, Error<$D>> {
                self.validate()?;
                compare(self, observe)
            }

            /// Iterations of the p,A-algorithm and of projected gradient for some steps ρ.
            ///
            /// A run that has not converged after 20 000 iterations counts as not converged.
            /// Source: Janovský & Procházka (1980) III, Fig. 11.
            pub fn compare_steps(
                &self,
                steps: &[f64],
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<ComparisonRow>, Error<$D>> {
                self.validate()?;
                compare_steps(self, steps, observe)
            }
        }
    )*};
}

doors!(2 3);

impl<const D: usize> Model<D> {
    /// Errors: what makes no model, whatever its bodies are.
    fn validate(&self) -> Result<(), Error<D>> {
        let rising = |pair: &[f64]| pair[0] < pair[1];
        if self.bodies.is_empty() {
            return Err(Error::NoBody);
        }
        if (self.analysis == Analysis::Solid) != (D == 3) {
            return Err(Error::Dimension(self.analysis));
        }
        if self.times.is_empty() {
            return Err(Error::NoStep);
        }
        if !self.times.iter().all(|time| time.is_finite()) || !self.times.windows(2).all(rising) {
            return Err(Error::Times(self.times.clone()));
        }
        let cohesive = |contact: &&Contact<D>| matches!(contact.law, Law::Cohesive { .. });
        if self.times.len() > 1
            && let Some(contact) = self.contacts.iter().find(cohesive)
        {
            return Err(Error::CohesiveSteps(contact.name.clone()));
        }
        let bodies = self.bodies.iter().map(|body| ("body", &body.name));
        let contacts = self.contacts.iter();
        let contacts = contacts.map(|contact| ("contact", &contact.name));
        let mut seen = BTreeSet::new();
        match bodies.chain(contacts).find(|named| !seen.insert(*named)) {
            Some((kind, name)) => Err(Error::SameName {
                kind,
                name: name.clone(),
            }),
            None => Ok(()),
        }
    }
}
