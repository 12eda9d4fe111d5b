//! Equilibrium of bodies that yield: a sequence of elastic problems with contact, until the plastic strain no longer changes.
//!
//! ```text
//!   t ─ R ─▶ ε_p ─ K, F, contact ─▶ u(ε_p) =: T(t),        T(t) = t
//! ```
//!
//! R is the return mapping of displacements t (`fem/plastic.rs`), from the plastic strain at the beginning of the step; the load
//! of ε_p then moves the bodies to u, with the factors and F of the elastic bodies and contact solved fully. With von Mises'
//! law and contact without friction T is the steepest descent of a convex energy in the norm of the elastic energy, with a
//! step that never overshoots. Anderson's method reduces hundreds of steps to some tens.
//!
//! *When it ends.* (u, R(u)) is the answer: its stress is admissible, and the unbalanced nodal forces are the load of R(u) − ε_p.
//! Where these are negligible beside the largest force of a cell on a node of the same body (forces of other bodies may be far
//! larger), the answer is judged as that of the elastic problem. Where no body may yield this file does nothing.
//!
//! *Just above first yield* a body may have neither state: as an elastic one some point of it yields, and with cells that change volume
//! as those of a flowing body (`fem/volume.rs`), which are more compliant, none does. After some changes to and fro such a body keeps
//! these cells for the step.

use crate::dual::OfYield;
use crate::fem::{Analysis, Body, FemError, Increment, Yielded};
use crate::geometry::{Point, dot, norm, sub};
use crate::model::march::attempt::{Attempt, Start, run};
use crate::model::march::judge::Judged;
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::event::Event;
use crate::model::nouns::model::Model;
use crate::model::system::condense::{Condensed, assume, go_part};
use crate::model::system::condition::contact_rows;
use crate::model::system::displaced::Displaced;
use crate::model::system::recover::elastic_displacement;
use crate::model::system::state::AllYielded;
use crate::solve::{Anderson, Outcome};
use rayon::prelude::*;
use std::sync::Arc;

/// Most elastic problems of one step.
const MOST_PROBLEMS: usize = 600;

/// Most elastic problems in the search for the part of a step that bodies can bear, and the resolution of that part.
const FEWER: usize = 200;
const NARROW: f64 = 1e-3;

/// The accelerated steps end at this part of the allowed imbalance: the judge still solves once more.
const BELOW: f64 = 0.1;

/// After so many steps the scales of forces are taken anew: a body may have been unloaded at first.
const RESCALED: usize = 10;

/// Bodies flow under their loads, and are not driven, where prescribed motion does at most this part of the dissipated work.
const DRIVEN: f64 = 0.1;

/// A body that has begun and ceased to yield so often in a step keeps the cells of a flowing one.
const UNDECIDED: usize = 12;

/// Displacements that strain each body, (D·n,), in the frames of its nodes.
type Strained = Vec<Vec<f64>>;

/// The search for the plastic strain of a step.
pub(crate) struct Turns {
    /// Of bodies that may yield.
    began: Vec<Option<Began>>,
    /// Elastic problems that have been solved.
    done: usize,
    /// Prescribed motion makes the bodies flow, and may go any distance.
    driven: bool,
}

/// A body that may yield.
struct Began {
    /// Its plastic strain at the beginning of the step.
    yielded: Yielded,
    /// Some point has a plastic strain under the last displacements, and how often that has changed.
    yields: bool,
    changes: usize,
}

impl Began {
    /// Its cells change volume as those of a flowing body, whether a point yields or not.
    fn gives_way(&self) -> bool {
        self.changes >= UNDECIDED
    }

    /// R of displacements.
    fn returned<const D: usize>(
        &self,
        of: (&Body<D>, Analysis),
        state: (&[Point<D>], f64),
    ) -> Result<Yielded, FemError> {
        self.yielded.returned(of, state, self.gives_way())
    }
}

impl Turns {
    /// The search of a step, which begins with the plastic strain of the steps before.
    pub fn new<const D: usize>(
        model: &Model<D>,
        condensed: &Condensed<D>,
    ) -> Result<Self, Error<D>> {
        let before = condensed.state.yielded().into_iter();
        let began = before.zip(&model.bodies).map(|(before, body)| {
            let yielded = match (body.is_plastic(), before) {
                (false, _) => return Ok(None),
                (true, Some(before)) => Ok(Yielded::clone(&before)),
                (true, None) => Yielded::nothing(body, model.analysis),
            };
            let yielded = yielded.map_err(|why| Error::in_body(body, why))?;
            Ok(Some(Began {
                yields: !yielded.is_nothing(),
                changes: 0,
                yielded,
            }))
        });
        Ok(Self {
            began: began.collect::<Result<_, _>>()?,
            done: 0,
            driven: false,
        })
    }

    /// Goes on from a certified attempt whose plastic strain is not that of its displacements; returns the new attempt, and whether it
    /// went on. Where equilibrium is impossible the attempt says why. The bodies carry the plastic strain of the last step.
    ///
    /// Errors: those of [`run`], and of the law of a body.
    pub fn next<const D: usize>(
        &mut self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        (mut attempt, judged, from): (Attempt<D>, &Judged<D>, Start<'_>),
        observe: &mut dyn FnMut(Event),
    ) -> Result<(Attempt<D>, bool), Error<D>> {
        if attempt.failure.is_some() || self.began.iter().all(Option::is_none) {
            return Ok((attempt, false));
        }
        let strained = &judged.displaced.strained;
        let left = self.left(model, condensed, strained)?;
        let done = self.increments(model, condensed, strained)?;
        let balanced = are_small(&left, model.solver.tolerance, &sizes(&done));
        let held = balanced && held_by_cells(&done);
        if held || self.done >= MOST_PROBLEMS {
            let lambda = &attempt.outcome.multipliers.lambda;
            let work = prescribed_work(condensed, &judged.displaced, lambda);
            self.driven = work > DRIVEN * dissipated(&done);
        }
        if balanced && (!held || self.driven) {
            return Ok((attempt, false));
        }
        if balanced || self.done >= MOST_PROBLEMS {
            let start = (strained.clone(), &attempt, from);
            let carried = self.carried(model, condensed, start)?;
            attempt.failure = Some(Objection::Yields {
                turns: (!balanced).then_some(MOST_PROBLEMS),
                unlimited: self.driven || !balanced && hardens(&done),
                carried,
            });
            return Ok((attempt, false));
        }
        let start = (strained.clone(), attempt, from);
        let (_, attempt) = self.settle(model, condensed, start, observe)?;
        Ok((attempt, true))
    }

    /// Applies `make` to each body that may yield: its index, its plastic strain at the beginning, and its displacements in global
    /// axes.
    fn each<const D: usize, T: Send>(
        &self,
        model: &Model<D>,
        condensed: &Condensed<D>,
        strained: &Strained,
        make: impl Fn(usize, &Began, &[Point<D>]) -> Result<T, FemError> + Sync,
    ) -> Result<Vec<Option<T>>, Error<D>> {
        let each = self.began.par_iter().enumerate().map(|(index, began)| {
            let Some(began) = began else { return Ok(None) };
            let u = condensed.bodies[index].system.to_global(&strained[index]);
            let made = make(index, began, &u);
            made.map(Some)
                .map_err(|why| Error::in_body(&model.bodies[index], why))
        });
        each.collect()
    }

    /// R of displacements; bodies that do not yield keep the stress that they have kept.
    fn returned<const D: usize>(
        &self,
        model: &Model<D>,
        condensed: &Condensed<D>,
        strained: &Strained,
    ) -> Result<AllYielded, Error<D>> {
        let returned = self.each(model, condensed, strained, |index, began, u| {
            let of = (&model.bodies[index], model.analysis);
            began.returned(of, (u, condensed.time))
        })?;
        let all = returned.into_iter().zip(&self.began);
        let all = all.zip(&condensed.bodies);
        let all = all.map(|((yielded, began), body)| {
            let Some((yielded, began)) = yielded.zip(began.as_ref()) else {
                return body.system.history.yielded.clone();
            };
            let some = began.gives_way() || !yielded.is_nothing();
            some.then(|| Arc::new(yielded))
        });
        Ok(all.collect())
    }

    /// The largest unbalanced nodal force of each body if the plastic strain of the displacements replaces that of the load.
    fn left<const D: usize>(
        &self,
        model: &Model<D>,
        condensed: &Condensed<D>,
        strained: &Strained,
    ) -> Result<Vec<Option<f64>>, Error<D>> {
        self.each(model, condensed, strained, |index, began, u| {
            let of = (&model.bodies[index], model.analysis);
            let loaded = &condensed.bodies[index];
            let now = began.returned(of, (u, condensed.time))?;
            let assumed = loaded.system.history.yielded.as_deref();
            let rest = now.less(assumed).forces(of.0, of.1)?;
            Ok(largest(rest.into_iter().map(norm)))
        })
    }

    /// The plastic increments since the step began, of each body that may yield.
    fn increments<const D: usize>(
        &self,
        model: &Model<D>,
        condensed: &Condensed<D>,
        strained: &Strained,
    ) -> Result<Vec<Option<Increment<D>>>, Error<D>> {
        self.each(model, condensed, strained, |index, began, u| {
            let of = (&model.bodies[index], model.analysis);
            let now = began.returned(of, (u, condensed.time))?;
            now.since(&began.yielded, of, (u, condensed.time))
        })
    }

    /// Accelerated steps from some displacements, until the imbalance is small or no step can be made; returns the displacements, and
    /// leaves the plastic strain of the last step with the bodies.
    fn settle<const D: usize>(
        &mut self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        (mut state, mut attempt, from): (Strained, Attempt<D>, Start<'_>),
        observe: &mut dyn FnMut(Event),
    ) -> Result<(Strained, Attempt<D>), Error<D>> {
        let mut anderson = Anderson::default();
        let mut scales = Vec::new();
        for turn in 0.. {
            if self.done >= MOST_PROBLEMS {
                break;
            }
            self.done += 1;
            let mut yielded = self.returned(model, condensed, &state)?;
            if self.decide(&yielded) {
                yielded = self.returned(model, condensed, &state)?;
                anderson = Anderson::default();
            }
            assume(model, condensed, yielded)?;
            let guess = attempt.outcome.multipliers.clone();
            let start = Start {
                guess: Some(&guess),
                ..from
            };
            attempt.follow(run(model, condensed, start, observe)?);
            if attempt.failure.is_some() {
                break;
            }
            let lambda = &attempt.outcome.multipliers.lambda;
            let bodies = condensed.bodies.par_iter().zip(&condensed.factored);
            let image = bodies.take(model.bodies.len());
            let image =
                image.map(|(body, factored)| elastic_displacement(body, factored, lambda, None));
            let image: Strained = image.collect();
            if turn % RESCALED == 0 {
                scales = sizes(&self.increments(model, condensed, &image)?);
            }
            let left = self.left(model, condensed, &image)?;
            if are_small(&left, BELOW * model.solver.tolerance, &scales) {
                return Ok((image, attempt));
            }
            let (after, before) = (self.flat(&image), self.flat(&state));
            let residual = after.iter().zip(&before).map(|(a, b)| a - b).collect();
            let mut next = anderson.next(after, residual).into_iter();
            state = image;
            let yielding = state.iter_mut().zip(&self.began);
            for (u, _) in yielding.filter(|(_, began)| began.is_some()) {
                u.iter_mut().zip(&mut next).for_each(|(u, next)| *u = next);
            }
        }
        Ok((state, attempt))
    }

    /// Counts how often bodies have begun and ceased to yield; `true` where that decides about some body.
    fn decide(&mut self, yielded: &AllYielded) -> bool {
        let mut decides = false;
        for (began, yielded) in self.began.iter_mut().zip(yielded) {
            let Some(began) = began.as_mut().filter(|began| !began.gives_way()) else {
                continue;
            };
            began.changes += usize::from(began.yields != yielded.is_some());
            began.yields = yielded.is_some();
            decides |= began.gives_way();
        }
        decides
    }

    /// The displacements of bodies that may yield, one behind the other.
    fn flat(&self, all: &Strained) -> Vec<f64> {
        let yielding = all.iter().zip(&self.began);
        let yielding = yielding.filter(|(_, began)| began.is_some());
        yielding.flat_map(|(u, _)| u.iter().copied()).collect()
    }

    /// The part of the step that the bodies can bear, by bisection; afterwards the problem is that of the whole step again. `None` where
    /// such a body has an initial stress or strain: that would be scaled with the load, and is in the law, too.
    fn carried<const D: usize>(
        &mut self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        (start, attempt, from): (Strained, &Attempt<D>, Start<'_>),
    ) -> Result<Option<f64>, Error<D>> {
        let mut plastic = model.bodies.iter().filter(|body| body.is_plastic());
        if plastic.any(|body| body.initial.stress.is_some() || body.initial.strain.is_some()) {
            return Ok(None);
        }
        let mut state: Strained = start.iter().map(|u| vec![0.0; u.len()]).collect();
        let [mut low, mut high] = [0.0, 1.0];
        while high - low > NARROW {
            let share = 0.5 * (low + high);
            go_part(model, condensed, Some(share))?;
            self.done = MOST_PROBLEMS - FEWER;
            let begun = Attempt {
                method: attempt.method.clone(),
                outcome: Outcome::new(attempt.outcome.multipliers.clone(), 0),
                history: Vec::new(),
                failure: None,
            };
            let from_here = (state.clone(), begun, from);
            let (found, ended) = self.settle(model, condensed, from_here, &mut |_| {})?;
            let settled = ended.failure.is_none() && self.done < MOST_PROBLEMS;
            let held = || {
                let done = self.increments(model, condensed, &found)?;
                Ok(!self.driven && held_by_cells(&done))
            };
            match settled && !held()? {
                true => (low, state) = (share, found),
                false => high = share,
            }
        }
        go_part(model, condensed, None)?;
        Ok(Some(low))
    }

    /// Adopts the plastic strain of the displacements, and judges it.
    ///
    /// The imbalance is found from stresses: the nodal forces without the load of the plastic strain, less the nodal forces of the
    /// returned stress. So an error of that load is noticed, too.
    ///
    /// Errors: those of the law of a body.
    pub fn take_over<const D: usize>(
        &self,
        model: &Model<D>,
        condensed: &mut Condensed<D>,
        judged: &mut Judged<D>,
    ) -> Result<(), Error<D>> {
        if self.began.iter().all(Option::is_none) {
            return Ok(());
        }
        let strained = &judged.displaced.strained;
        let done = self.increments(model, condensed, strained)?;
        let left = self.each(model, condensed, strained, |index, _, _| {
            let system = &condensed.bodies[index].system;
            let mut rest = judged.displaced.states[index].total.clone();
            let mut take = |forces: &[Point<D>]| {
                let both = rest.iter_mut().zip(forces);
                both.for_each(|(rest, force)| *rest = sub(*rest, *force));
            };
            if let Some(assumed) = &system.history.yielded {
                take(&assumed.forces(&model.bodies[index], model.analysis)?);
            }
            take(done[index].as_ref().map_or(&[], |own| &own.held));
            Ok(largest(rest.into_iter().map(norm)))
        })?;
        let yielded = self.returned(model, condensed, strained)?;
        // a body that has neither yielded nor a plastic load is judged as an elastic one
        let loads = condensed.bodies.iter().zip(&yielded);
        let plastic =
            loads.map(|(body, own)| body.system.history.yielded.is_some() || own.is_some());
        let left = left.into_iter().zip(plastic);
        let left = left.map(|(left, plastic)| left.filter(|_| plastic));
        let left = worst_of(&left.collect::<Vec<_>>(), &sizes(&done));
        let stresses = |of: fn(&Increment<D>) -> f64| -> Vec<Option<f64>> {
            done.iter().map(|own| own.as_ref().map(of)).collect()
        };
        let beyond = worst_of(&stresses(|own| own.beyond), &stresses(|own| own.trial));
        let states = judged.displaced.states.iter();
        let energy = states.map(|state| state.strain_energy).sum();
        let gained = done.iter().flatten().map(|own| own.gained).sum::<f64>();
        judged.certificate.yields = Some(OfYield::new(
            (left, model.solver.tolerance),
            beyond,
            [-gained, energy],
        ));
        for (state, own) in judged.displaced.states.iter_mut().zip(&done) {
            if let Some(own) = own {
                (state.strain_energy, state.yielded) = (own.stored, own.extent);
            }
        }
        for (body, own) in condensed.bodies.iter_mut().zip(yielded) {
            body.system.history.yielded = own;
        }
        Ok(())
    }
}

/// The largest force of a cell on a node, of each body.
fn sizes<const D: usize>(done: &[Option<Increment<D>>]) -> Vec<Option<f64>> {
    done.iter()
        .map(|own| own.as_ref().map(|own| own.force))
        .collect()
}

/// Whether values of bodies are all within this part of their scales.
fn are_small(values: &[Option<f64>], part: f64, scales: &[Option<f64>]) -> bool {
    let [value, scale] = worst_of(values, scales);
    value <= part * scale
}

/// The value that is largest relative to its scale, and that scale.
fn worst_of(values: &[Option<f64>], scales: &[Option<f64>]) -> [f64; 2] {
    let known = values.iter().zip(scales);
    let known = known.filter_map(|(value, scale)| Some([(*value)?, (*scale)?]));
    let part = |[value, scale]: &[f64; 2]| if *value == 0.0 { 0.0 } else { value / scale };
    let worst = known.max_by(|a, b| part(a).total_cmp(&part(b)));
    worst.unwrap_or_default()
}

/// The constrained cells of some body prevent its flow: see [`Increment::flow`].
fn held_by_cells<const D: usize>(done: &[Option<Increment<D>>]) -> bool {
    let mut flows = done.iter().flatten().map(|own| own.flow);
    flows.any(|flow| flow.is_held_by_cells())
}

/// What flows hardens, in all bodies.
fn hardens<const D: usize>(done: &[Option<Increment<D>>]) -> bool {
    let mut flows = done.iter().flatten().map(|own| own.flow);
    flows.all(|flow| flow.dissipated <= 0.0 || flow.hardens())
}

/// The work that all bodies dissipate.
fn dissipated<const D: usize>(done: &[Option<Increment<D>>]) -> f64 {
    done.iter().flatten().map(|own| own.flow.dissipated).sum()
}

/// Work that prescribed motion of supports, points and obstacles has done since the last step, under forces `lambda` (m,); that of points
/// since the first one.
fn prescribed_work<const D: usize>(
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    lambda: &[f64],
) -> f64 {
    let mut work = 0.0;
    let before = condensed.state.displacements();
    for (state, before) in displaced.states.iter().zip(before) {
        for (node, (force, u)) in state.reactions.iter().zip(&state.u).enumerate() {
            let then = before.map_or([0.0; D], |u| u[node]);
            work += dot(*force, sub(*u, then));
        }
    }
    let parts = condensed.bodies.iter().enumerate();
    for (part, loaded) in parts.skip(displaced.states.len()) {
        let moved = displaced.nodes(part).as_flattened().iter();
        let held = loaded.held_forces(lambda).into_iter().zip(moved);
        work += held.map(|(force, u)| force * u).sum::<f64>();
    }
    let contacts = contact_rows(&condensed.conditions);
    let prescribed =
        contacts.filter(|(_, (_, own))| own.mortar.is_none() && own.opposite.is_none());
    for (_, (rows, condition)) in prescribed {
        let motion = condition.touch.obstacle_motion;
        let then = condensed.state.obstacle(&condition.name);
        let motion = sub(motion, then.unwrap_or([0.0; D]));
        for (row, force) in condition.interface.mortar.iter().zip(&lambda[rows]) {
            let along = row.iter().map(|(_, c)| dot(*c, motion));
            work += force * along.sum::<f64>();
        }
    }
    work
}

/// The largest of some numbers ≥ 0; zero without any.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}
