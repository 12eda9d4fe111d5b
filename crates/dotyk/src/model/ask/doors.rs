//! Entry points of a model: its solution, its dual problem, a check, a comparison of solvers.

use crate::dual::{Certificate, DualProblem, Multipliers};
use crate::linalg::SparseMatrix;
use crate::model::ask::check::{Check, check};
use crate::model::ask::compare::{ComparisonRow, compare, compare_steps};
use crate::model::ask::dual::{Dual, Unknown};
use crate::model::ask::study::{Make, Study, Varied};
use crate::model::march::past::Past;
use crate::model::march::reuse::Reuse;
use crate::model::march::steps::{Given, condense_step, solve_steps};
use crate::model::nouns::error::Error;
use crate::model::nouns::event::Event;
use crate::model::nouns::file_names::check_file_names;
use crate::model::nouns::model::{Analysis, Method, Model};
use crate::model::nouns::solution::Solution;
use crate::model::system::compliance::DENSE_LIMIT;
use crate::model::system::parts::Parts;
use crate::solve::ContactSolver;
use std::collections::BTreeSet;
use std::ops::Range;

/// Generic functions are compiled again in every program that calls them, which takes a minute each. So the entry points are
/// not generic: all code behind them is compiled here, once for each dimension.
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

            /// The same, with an observer of its events.
            ///
            /// Errors: see [`Error`]; `NotConverged` carries the last iterate and the steps before it.
            pub fn solve_steps_with(
                &self,
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.validate()?;
                solve_steps(self, Given::NONE, None, observe)
            }

            /// The same, after steps that were solved before: the first ones of this model, with the same contact forces,
            /// displacements and strain energies. They are solved again from these forces, which takes hardly any iteration,
            /// and are part of the answer. Forces of couples are not recorded; with couples the steps are repeated in full.
            ///
            /// Errors: as [`Self::solve_steps_with`]; `Past` where such a step is not one of this model, `NothingLeft` where
            /// all steps were solved before.
            pub fn solve_steps_after(
                &self,
                past: &[Past<$D>],
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.solve_steps_keeping(past, observe, &|_| {})
            }

            /// The same, and `kept` is shown the finished steps after each of them, so that a run that does not come to its end
            /// loses none of them.
            ///
            /// Errors: as [`Self::solve_steps_after`].
            pub fn solve_steps_keeping(
                &self,
                past: &[Past<$D>],
                observe: &mut dyn FnMut(Event),
                kept: &dyn Fn(&[Solution<$D>]),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.validate()?;
                let given = Given { past, kept: Some(kept), ..Given::NONE };
                solve_steps(self, given, None, observe)
            }

            /// All load steps, with the factors that another model of the same stiffness has left: where only loads, friction,
            /// prescribed values or steps differ, no body is factored or condensed again.
            ///
            /// Errors: as [`Self::solve_steps_with`].
            pub fn solve_steps_reusing(
                &self,
                reuse: &mut Reuse<$D>,
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.solve_reusing(reuse, observe)
            }

            /// Solves the models that `make` makes for all combinations of parameter values. This one has the values `own`;
            /// `observe` is called when a member is done. A model that cannot be made or solved is a member with its reason.
            pub fn study(
                self,
                own: &[f64],
                varied: Vec<Varied>,
                make: &Make<'_, $D>,
                observe: &(dyn Fn() + Sync),
            ) -> Study {
                Study::run((self, own), varied, make, observe)
            }

            /// Solves the model with a solver of one's own and returns the solution of its last load step.
            ///
            /// The solver is asked once in each step, from the answer of the step before. Its forces are judged as those
            /// of every method, and are not corrected: figures come from the displacements, and may need some digits more
            /// than [`DualProblem::kkt_residual`].
            ///
            /// Errors: see [`Error`]; `NotConverged` where the certificate does not hold, with the solution of its forces;
            /// `Solver` with its own error, or where its forces have wrong lengths or are not finite.
            pub fn solve_by(&self, solver: &dyn ContactSolver) -> Result<Solution<$D>, Error<$D>> {
                let last = self.solve_steps_by(solver, &mut |_| {})?.pop();
                last.ok_or(Error::NoStep)
            }

            /// The same for all load steps, with an observer of its events.
            ///
            /// Errors: as [`Self::solve_by`], with the steps before the one that failed.
            pub fn solve_steps_by(
                &self,
                solver: &dyn ContactSolver,
                observe: &mut dyn FnMut(Event),
            ) -> Result<Vec<Solution<$D>>, Error<$D>> {
                self.validate()?;
                let own = Some(solver);
                solve_steps(self, Given { own, ..Given::NONE }, None, observe)
            }

            /// The dual problem of the load step at a time, with the way from its forces to a solution. Friction counts
            /// the slip since the last of the model's steps before that time; these are solved where there is friction.
            ///
            /// Errors: as [`Self::solve`], but for those of the contact solver in this step.
            pub fn dual(&self, time: f64) -> Result<Dual<$D>, Error<$D>> {
                self.validate()?;
                if !time.is_finite() {
                    return Err(Error::Times(vec![time]));
                }
                let (stage, (condensed, view)) = condense_step(self, time, DENSE_LIMIT, &mut |_| {})?;
                Ok(Dual { stage, condensed, view })
            }

            /// The dual problem of the last load step alone, for running or comparing solvers without the model.
            ///
            /// F is assembled up to `dense_limit` nodes, or as many entries in all as theirs ([`DENSE_LIMIT`] in
            /// [`Self::solve`]), of many bodies without its zeros; above, each product is one solve with every body. Of few bodies
            /// in space, solved by Newton's method, the cheaper of both is taken from as many unknowns to three times as many.
            ///
            /// Errors: as [`Self::dual`].
            pub fn dual_problem(&self, dense_limit: usize) -> Result<DualProblem, Error<$D>> {
                self.validate()?;
                let (_, (condensed, _)) = condense_step(self, self.last_time(), dense_limit, &mut |_| {})?;
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

        impl Dual<$D> {
            /// Description of each contact force, (m,).
            pub fn unknowns(&self) -> Vec<Unknown<$D>> {
                self.list_unknowns()
            }

            /// B (m, n): the gaps are g₀ − Bu, and −Bᵀλ are the nodal forces of the contacts on the bodies. u are the
            /// displacements in global axes, prescribed ones included, node by node, of the parts that
            /// [`Self::columns`] names.
            pub fn rows(&self) -> SparseMatrix {
                self.assemble_rows()
            }

            /// Name and columns of B of each body, then of each obstacle that a force moves and of the point of each couple.
            pub fn columns(&self) -> Vec<(String, Range<usize>)> {
                self.list_columns()
            }

            /// Assembles F where it is applied and has at most [`ASSEMBLED`](crate::model::ASSEMBLED) unknowns; `true`
            /// where it is assembled, with or without its zeros.
            pub fn assemble(&mut self) -> bool {
                self.assemble_compliance()
            }

            /// λ and α by one of the methods, as [`Model::solve`] finds them in this step.
            ///
            /// Errors: as [`Model::solve`]; `NotConverged` carries the last iterate.
            pub fn solve(&mut self, method: Method) -> Result<Multipliers, Error<$D>> {
                self.solved(method, &mut |_| {})
            }

            /// The certificate of λ and α, whatever their source, from the displacements that they cause.
            ///
            /// Errors: `Solver` where lengths differ from (m,) and (r,), or a number is not finite.
            pub fn certify(&self, multipliers: &Multipliers) -> Result<Certificate, Error<$D>> {
                self.certified(multipliers)
            }

            /// The solution with λ and α, whatever their source: displacements, stresses, reactions, contacts, probes.
            ///
            /// Errors: as [`Self::certify`]; `NotConverged` where the certificate does not hold, with the solution.
            pub fn recover(&self, multipliers: &Multipliers) -> Result<Solution<$D>, Error<$D>> {
                self.recovered(multipliers)
            }
        }
    )*};
}

doors!(2 3);

impl<const D: usize> Dual<D> {
    /// The model, whose tolerance is the limit of certificates.
    pub fn model(&self) -> &Model<D> {
        &self.stage.model
    }

    /// F, d, Λ, G and e.
    pub fn problem(&self) -> &DualProblem {
        &self.condensed.problem
    }

    /// Time at which loads, supports and gaps were taken.
    pub fn time(&self) -> f64 {
        self.condensed.time
    }

    /// Name of a contact by its index in [`Unknown::contact`]; "BODY.POINT" of a couple. Empty for an unknown index.
    pub fn contact_name(&self, contact: usize) -> &str {
        let conditions = self.condensed.conditions.get(contact);
        conditions.map_or("", |condition| condition.name.as_str())
    }

    /// g₀ (m,): gaps without displacements; in a tangential row those from the slip in earlier steps and the motion
    /// of an obstacle.
    pub fn initial_gaps(&self) -> &[f64] {
        &self.condensed.gaps
    }
}

impl<const D: usize> Model<D> {
    /// As [`Model::solve_steps_reusing`].
    pub(crate) fn solve_reusing(
        &self,
        reuse: &mut Reuse<D>,
        observe: &mut dyn FnMut(Event),
    ) -> Result<Vec<Solution<D>>, Error<D>> {
        self.validate()?;
        solve_steps(self, Given::NONE, Some(reuse), observe)
    }

    /// Errors: an invalid model, whatever its bodies are.
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
        self.check_presence()?;
        self.check_formulas()?;
        let bodies = self.bodies.iter().map(|body| ("body", &body.name));
        let contacts = self.contacts.iter();
        let contacts = contacts.map(|contact| ("contact", &contact.name));
        let names: Vec<String> = Parts::of(self)
            .points(self)
            .map(|(_, body, couple)| format!("{}.{}", self.bodies[body].name, couple.name))
            .collect();
        let couples = names.iter().map(|name| ("coupled point", name));
        let sections = self.sections.iter();
        let sections = sections.map(|section| ("section", &section.name));
        let members = self.members.iter();
        let members = members.map(|member| (member.kind.words().key, &member.name));
        let mut seen = BTreeSet::new();
        match bodies
            .chain(contacts)
            .chain(sections)
            .chain(members)
            .chain(couples)
            .find(|(_, name)| !seen.insert(*name))
        {
            Some((kind, name)) => Err(Error::SameName {
                kind,
                name: name.clone(),
            }),
            None => self.check_file_names(),
        }
    }

    /// Errors: a body whose name cannot be that of a file, or equals another one on some systems.
    fn check_file_names(&self) -> Result<(), Error<D>> {
        let names = self.bodies.iter().map(|body| &body.name[..]);
        check_file_names(names).map_err(|source| Error::FileName {
            body: source.name().to_string(),
            source,
        })
    }
}
