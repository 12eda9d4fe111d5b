//! A model solved for many values of its parameters.
//!
//! Members that differ in loads, friction, prescribed values or steps alone share one factorisation ([`Reuse`]): parameters
//! that change the stiffness are varied outermost, and members inside such a loop are solved one after the other. Different
//! stiffnesses are solved in parallel.

use crate::model::march::reuse::Reuse;
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::model::{Model, Units};
use crate::model::nouns::solution::Solution;
use crate::model::nouns::told::told_in_steps;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// A parameter and the values that it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// Name of the parameter.
    pub name: String,
    /// Its values, at least one.
    pub values: Vec<f64>,
    /// The values are spaced by equal ratios: plots are logarithmic.
    pub log: bool,
}

/// A probe of one number that is read in every member.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name of the probe.
    pub name: String,
    /// Its dimension.
    pub dimension: Dimension,
}

/// The case for one choice of values.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyMember {
    /// Values of the varied parameters, in their order.
    pub values: Vec<f64>,
    /// Values of the probes in the last load step, NaN where it has no answer.
    pub probes: Vec<f64>,
    /// Times of its load steps; none where its model cannot be made.
    pub times: Vec<f64>,
    /// Values of the probes in each load step that has an answer.
    pub steps: Vec<Vec<f64>>,
    /// Every load step has its certificate.
    pub converged: bool,
    /// Why not; empty if it has.
    pub reason: String,
    /// Warnings of all its load steps, each once.
    pub warnings: Vec<String>,
}

/// A model solved for all combinations of some values.
#[derive(Debug, Clone)]
pub struct Study {
    /// Title of the model.
    pub title: String,
    /// Its units.
    pub units: Units,
    /// The varied parameters.
    pub varied: Vec<Varied>,
    /// The probes.
    pub probes: Vec<Column>,
    /// All combinations; the first parameter changes slowest.
    pub members: Vec<StudyMember>,
    /// Tables have a row for each load step of a member, and not for the last one alone.
    pub all_steps: bool,
}

/// A row of the table of a study: a member, or one of its load steps.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyRow<'a> {
    /// The member.
    pub member: &'a StudyMember,
    /// Number of the load step, from 1, and its time; `None` where the row is that of the last one.
    pub step: Option<(usize, f64)>,
    /// Values of the probes.
    pub probes: Cow<'a, [f64]>,
    /// It has an answer.
    pub converged: bool,
    /// Why not; empty if it has.
    pub reason: &'a str,
}

/// Makes the model for some values, or gives the reason why it cannot.
pub type Make<'a, const D: usize> = dyn Fn(&[f64]) -> Result<Model<D>, String> + Sync + 'a;

impl Study {
    /// As [`Model::study`].
    pub(crate) fn run<const D: usize>(
        (model, own): (Model<D>, &[f64]),
        varied: Vec<Varied>,
        make: &Make<'_, D>,
        observe: &(dyn Fn() + Sync),
    ) -> Self {
        let numbers = model.probes.iter().filter(|probe| !probe.is_line());
        let probes = numbers.map(|probe| Column {
            name: probe.name.clone(),
            dimension: probe.dimension(),
        });
        let probes: Vec<Column> = probes.collect();
        let stiff = |k: usize| changes_stiffness((&model, own), k, &varied[k], make);
        let stiff: Vec<bool> = (0..varied.len()).map(stiff).collect();
        let members = groups(&varied, &stiff).into_par_iter().map(|group| {
            let mut reuse = Reuse::default();
            let solve = |index: usize| {
                let values = combination(&varied, index);
                let member = member(make(&values), values, &probes, &mut reuse);
                observe();
                (index, member)
            };
            group.into_iter().map(solve).collect::<Vec<_>>()
        });
        let mut members: Vec<(usize, StudyMember)> = members.flatten_iter().collect();
        members.sort_by_key(|(index, _)| *index);
        Self {
            members: members.into_iter().map(|(_, member)| member).collect(),
            title: model.title,
            units: model.units,
            varied,
            probes,
            all_steps: false,
        }
    }

    /// The rows of its table: one for each member, or one for each load step of a member up to the one without an answer.
    pub fn rows(&self) -> Vec<StudyRow<'_>> {
        let whole = |member| StudyRow {
            member,
            step: None,
            probes: Cow::Borrowed(&member.probes[..]),
            converged: member.converged,
            reason: &member.reason,
        };
        match self.all_steps {
            true => self.members.iter().flat_map(StudyMember::rows).collect(),
            false => self.members.iter().map(whole).collect(),
        }
    }

    /// Names of its columns that have numbers: parameters, load step and time where all load steps are told, probes.
    pub fn heads(&self) -> impl Iterator<Item = &str> {
        let varied = self.varied.iter().map(|parameter| parameter.name.as_str());
        let probes = self.probes.iter().map(|probe| probe.name.as_str());
        let steps = step_heads(self.all_steps).iter().copied();
        varied.chain(steps).chain(probes)
    }

    /// A name that two columns of the table would have.
    pub fn doubled<'a, const D: usize>(
        model: &'a Model<D>,
        varied: &'a [Varied],
        all_steps: bool,
    ) -> Option<&'a str> {
        let mut seen = BTreeSet::from(["converged", "reason"]);
        seen.extend(step_heads(all_steps));
        let varied = varied.iter().map(|parameter| parameter.name.as_str());
        let probes = model.probes.iter().map(|probe| probe.name.as_str());
        varied.chain(probes).find(|name| !seen.insert(name))
    }

    /// Which value of every parameter a member has, by its index.
    pub fn places(&self, member: usize) -> Vec<usize> {
        places(&self.varied, member)
    }

    /// Warnings of the members, each once with the number of members that have it, in the order of their first one.
    pub fn warnings(&self) -> Vec<(String, usize)> {
        let mut list: Vec<(String, usize)> = Vec::new();
        for warning in self.members.iter().flat_map(|member| &member.warnings) {
            match list.iter_mut().find(|(known, _)| known == warning) {
                Some((_, count)) => *count += 1,
                None => list.push((warning.clone(), 1)),
            }
        }
        list
    }

    /// Every member has its answer.
    pub fn converged(&self) -> bool {
        self.members.iter().all(|member| member.converged)
    }

    /// Number of members of a study.
    pub fn count(varied: &[Varied]) -> usize {
        varied
            .iter()
            .map(|parameter| parameter.values.len())
            .product()
    }
}

/// Names of the columns of load steps.
fn step_heads(all_steps: bool) -> &'static [&'static str] {
    if all_steps { &["step", "time"] } else { &[] }
}

impl StudyRow<'_> {
    /// The numbers of its columns, in the order of [`Study::heads`].
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let step = self.step.map(|(step, time)| [step as f64, time]);
        let values = self.member.values.iter().copied();
        let probes = self.probes.iter().copied();
        values.chain(step.into_iter().flatten()).chain(probes)
    }
}

impl StudyMember {
    /// A row for each load step up to the one without an answer.
    fn rows(&self) -> Vec<StudyRow<'_>> {
        let time = |index: usize| self.times.get(index).copied().unwrap_or(f64::NAN);
        let good = self
            .steps
            .iter()
            .enumerate()
            .map(|(index, probes)| StudyRow {
                member: self,
                step: Some((index + 1, time(index))),
                probes: Cow::Borrowed(&probes[..]),
                converged: true,
                reason: "",
            });
        let next = self.steps.len();
        let failed = (!self.converged).then(|| StudyRow {
            member: self,
            step: Some((next + 1, time(next))),
            probes: Cow::Owned(vec![f64::NAN; self.probes.len()]),
            converged: false,
            reason: &self.reason,
        });
        good.chain(failed).collect()
    }
}

/// Whether the ends of a parameter's range make another stiffness; then it is varied outermost.
fn changes_stiffness<const D: usize>(
    (model, own): (&Model<D>, &[f64]),
    index: usize,
    parameter: &Varied,
    make: &Make<'_, D>,
) -> bool {
    let ends = [parameter.values.first(), parameter.values.last()];
    ends.into_iter().flatten().any(|&value| {
        let mut values = own.to_vec();
        values[index] = value;
        // a model that cannot be made is not solved
        make(&values).is_ok_and(|other| !other.has_stiffness_of(model))
    })
}

/// Indices of the members, those of each stiffness together.
fn groups(varied: &[Varied], stiff: &[bool]) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<Vec<u64>, Vec<usize>> = BTreeMap::new();
    for index in 0..Study::count(varied) {
        let values = combination(varied, index);
        let values = values.iter().zip(stiff).filter(|(_, stiff)| **stiff);
        let key = values.map(|(value, _)| value.to_bits()).collect();
        groups.entry(key).or_default().push(index);
    }
    groups.into_values().collect()
}

/// Which value of every parameter a member has; the first parameter changes slowest.
fn places(varied: &[Varied], index: usize) -> Vec<usize> {
    let mut rest = index;
    let mut places: Vec<usize> = varied
        .iter()
        .rev()
        .map(|parameter| {
            let place = rest % parameter.values.len();
            rest /= parameter.values.len();
            place
        })
        .collect();
    places.reverse();
    places
}

/// Values of a member.
fn combination(varied: &[Varied], index: usize) -> Vec<f64> {
    let places = places(varied, index).into_iter().zip(varied);
    places
        .map(|(place, parameter)| parameter.values[place])
        .collect()
}

fn member<const D: usize>(
    model: Result<Model<D>, String>,
    values: Vec<f64>,
    probes: &[Column],
    reuse: &mut Reuse<D>,
) -> StudyMember {
    let times = model
        .as_ref()
        .map_or(Vec::new(), |model| model.times.clone());
    let solved = match model {
        Ok(model) => model.solve_reusing(reuse, &mut |_| {}).map_err(|error| {
            let reason = error.to_string();
            (error.into_earlier(), reason)
        }),
        Err(reason) => Err((Vec::new(), reason)),
    };
    let told = solved.iter().flatten();
    let warnings = told_in_steps(told.map(|step| &step.warnings[..]));
    let (steps, reason) = match solved {
        Ok(steps) => (steps, String::new()),
        Err(failed) => failed,
    };
    // by name: a line of an absent part is told as one number
    let number = |step: &Solution<D>, probe: &Column| step.probe(&probe.name).unwrap_or(f64::NAN);
    let numbers = |step| probes.iter().map(|probe| number(step, probe)).collect();
    let steps: Vec<Vec<f64>> = steps.iter().map(numbers).collect();
    let converged = reason.is_empty();
    let last = steps.last().filter(|_| converged);
    StudyMember {
        values,
        converged,
        probes: last.map_or_else(|| vec![f64::NAN; probes.len()], Vec::clone),
        times,
        steps,
        reason,
        warnings,
    }
}
