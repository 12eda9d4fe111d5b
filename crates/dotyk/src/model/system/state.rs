//! State: all that load steps pass on to those after them.
//!
//! Where bodies, supports and contacts come and go:
//!
//! * a body that appears is free of stress and fits its neighbours: the gaps of its contacts count from the displacements
//!   u_a of the bodies that were there, g₀ + B u_a, in normal and tangential rows;
//! * a support that appears holds the nodes of its body where they are;
//! * a spring or a member that appears bears no force at the displacements of that moment; a prestressed bar pulls in its first step
//!   with its prestress, whatever the displacements;
//! * friction counts from the positions of the sides of a contact when its stage began, B u of the last step in the present
//!   directions of the tangents: slips stay when a support of a side goes, and a contact or an obstacle that comes has no slip;
//! * a joint that comes is whole where its sides are not apart then, g₀ + B (u_a − u), whether or not one of its bodies comes, too;
//! * a gasket keeps the closure of its largest pressure, whatever else comes or goes;
//! * a body that goes leaves, where it is released, the forces −Bᵀλ of its last step on its neighbours, times the remaining part
//!   of them at a time.
//!
//! All of these u_a are the displacements of the bodies when a part came.

use crate::dual::Multipliers;
use crate::fem::{History, Yielded};
use crate::geometry::{Field, Point, add_scaled, distance, dot};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::{Contact, Law, Model};
use crate::model::nouns::presence::{Presence, Stage, places};
use crate::model::nouns::solution::{CoupleSolution, Solution};
use crate::model::system::bolt::keep;
use crate::model::system::condition::{Condition, Fit, Source, obstacle_motion, row_ranges};
use crate::model::system::counted::{Counted, Motion};
use crate::model::system::drive::Before;
use crate::model::system::filling::Filling;
use crate::model::system::joints::Lost;
use crate::model::system::parts::Owner;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Displacements of the bodies of a whole model at some moment.
type Moved<const D: usize> = Arc<[Motion<D>]>;

/// Plastic strain of each of some bodies, `None` without any.
pub(crate) type AllYielded = Vec<Option<Arc<Yielded>>>;

/// A part that comes later than the first load step, by its place in the whole model or by its name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Thing {
    Body(usize),
    /// By its body and its place there.
    Support(usize, usize),
    /// The same.
    Spring(usize, usize),
    /// A tie between bodies that were there: it holds them in their present positions.
    Tie(String),
    /// A member: its elongation counts from the moment when it begins to bear.
    Member(String),
}

/// The moment when a part came.
#[derive(Debug, Clone)]
struct Birth<const D: usize> {
    /// Number of its first step.
    step: usize,
    /// Displacements of that moment.
    moved: Moved<D>,
}

/// State of a condition between parts.
#[derive(Debug, Clone, Default)]
struct Record {
    /// Slip of its sides, or plastic elongation of a member, in the rows of its stage (m of the condition,) where a bounded force does work;
    /// zero in the others. `None`: the slip follows from displacements.
    slip: Option<Vec<f64>>,
    /// Work that its friction has dissipated.
    dissipated: f64,
    /// Nodes at which a joint has parted or slipped.
    lost: Option<Lost>,
    /// State of a gasket.
    filling: Option<Filling>,
}

/// The state of a whole model that a load step passes on to the next one; empty before the first step.
#[derive(Debug, Clone)]
pub(crate) struct State<const D: usize> {
    /// Parts come and go, or are tightened.
    staged: bool,
    /// The present parts.
    presence: Presence,
    /// Time of the last step.
    time: Option<f64>,
    /// Displacements of the bodies after it.
    moved: Moved<D>,
    /// Displacements of obstacles after it, by contact.
    obstacles: BTreeMap<String, Point<D>>,
    births: BTreeMap<Thing, Birth<D>>,
    /// By body, the displacements to which it was fitted, at its nodes.
    fitted: Vec<Motion<D>>,
    /// By body, the points of its couples after the last step.
    points: Vec<Vec<CoupleSolution<D>>>,
    /// The moment from which displacements count in results.
    counted: Option<Arc<Counted<D>>>,
    /// By body, the forces of neighbours that have gone, each with the remaining part of it at a time.
    released: Vec<Vec<(Arc<[Point<D>]>, Field)>>,
    /// By the names of contacts and links.
    records: BTreeMap<String, Record>,
    /// By body, its plastic strains at the points of its cells.
    yielded: AllYielded,
    /// Forces and amplitudes of the last step of this stage, then its time and e.
    pub forces: Option<Multipliers>,
    pub load: Option<(f64, Vec<f64>)>,
}

impl<const D: usize> State<D> {
    /// The state at the first step of a model; `staged`: it has several stages.
    pub fn new(model: &Model<D>, time: f64, staged: bool) -> Self {
        let count = model.bodies.len();
        Self {
            staged,
            presence: Presence::at(model, time),
            time: None,
            moved: vec![None; count].into(),
            obstacles: BTreeMap::new(),
            births: BTreeMap::new(),
            fitted: vec![None; count],
            points: vec![Vec::new(); count],
            counted: None,
            released: vec![Vec::new(); count],
            records: BTreeMap::new(),
            yielded: vec![None; count],
            forces: None,
            load: None,
        }
    }

    /// Its present stage.
    pub fn stage<'m>(&self, model: &'m Model<D>) -> Stage<'m, D> {
        Stage::of(model, &self.presence)
    }

    /// A step has been solved.
    pub fn goes_on(&self) -> bool {
        self.time.is_some()
    }

    /// Time of the last step, if there was one.
    pub fn time(&self) -> Option<f64> {
        self.time
    }

    /// The forces as a starting point. Without any contact force the solver's own start is better.
    pub fn guess(&self) -> Option<&Multipliers> {
        let touches = |forces: &&Multipliers| forces.lambda.iter().any(|&force| force != 0.0);
        self.forces.as_ref().filter(touches)
    }

    /// Nodes of each of so many parts that contacts of this or another stage touch; empty without another stage.
    pub fn lasting(&self, stage: &Stage<'_, D>, parts: usize) -> Vec<Vec<usize>> {
        let mut nodes = vec![Vec::new(); parts];
        for (index, body) in stage.model.bodies.iter().enumerate() {
            let sides = self.staged.then(|| stage.touched(BodyId(index)));
            let sides = sides.into_iter().flatten();
            let touched = sides.flat_map(|side| body.mesh.side_nodes(side).unwrap_or_default());
            let touched: BTreeSet<usize> = touched.map(|node| node as usize).collect();
            nodes[index] = touched.into_iter().collect();
        }
        nodes
    }

    /// Place of each body of the stage in the whole model.
    fn whole(&self) -> Vec<usize> {
        let there = &self.presence.bodies;
        (0..there.len()).filter(|&body| there[body]).collect()
    }

    /// Remembers a solved step of the stage: e (r,) and the forces, slips (m,) and lost nodes of its conditions, and the plastic strains of
    /// its bodies; notes in the solution the displacements to which bodies were fitted.
    pub fn remember(
        &mut self,
        solution: &mut Solution<D>,
        conditions: &[Condition<D>],
        (load, forces): (&[f64], Multipliers),
        (slip, lost): (&[f64], &[Vec<bool>]),
        yielded: AllYielded,
    ) {
        self.load = Some((solution.time, load.to_vec()));
        for ((rows, condition), lost) in row_ranges(conditions).zip(lost) {
            let record = self.records.entry(condition.name.clone()).or_default();
            record.filling = condition.filled_after(&forces.lambda[rows.clone()]);
            record.slip = Some(slip[rows].to_vec());
            record.lost = Some(Lost::of(condition, lost));
        }
        self.forces = Some(forces);
        self.obstacles.clear();
        for contact in &solution.contacts {
            let record = self.records.entry(contact.name.clone()).or_default();
            record.dissipated = contact.dissipated_total;
            let moved = contact.obstacle.map(|moved| (contact.name.clone(), moved));
            self.obstacles.extend(moved);
        }
        for (body, yielded) in self.whole().into_iter().zip(yielded) {
            self.yielded[body] = yielded;
        }
        self.time = Some(solution.time);
        let mut moved = vec![None; self.moved.len()];
        for (body, solved) in self.whole().into_iter().zip(&mut solution.bodies) {
            solved.fitted.clone_from(&self.fitted[body]);
            moved[body] = Some(Arc::from(solved.displacement.clone()));
            self.points[body].clone_from(&solved.couples);
        }
        self.moved = moved.into();
    }

    /// Makes the displacements of a solution of the stage count from where the model says.
    pub fn count(&self, model: &Model<D>, conditions: &[Condition<D>], solution: &mut Solution<D>) {
        if let Some(counted) = &self.counted {
            counted.apply((model, &self.whole()), conditions, solution);
        }
    }

    /// The present moment as the one from which displacements count.
    fn counted_from(&self, time: f64) -> Counted<D> {
        let placed = self.moved.iter().zip(&self.fitted);
        let placed = placed.map(|(moved, fitted)| match (moved, fitted) {
            (Some(moved), Some(fitted)) => {
                let both = moved.iter().zip(fitted.iter());
                Some(both.map(|(u, v)| add_scaled(*u, 1.0, *v)).collect())
            }
            (moved, _) => moved.clone(),
        });
        let both = [self.moved.to_vec(), placed.collect()];
        Counted::at(time, both, self.points.clone(), self.obstacles.clone())
    }

    /// Goes on to a step; returns whether parts come, go or age there. `last` are the conditions of the last step.
    ///
    /// Errors: those of [`Body::aged`].
    pub fn go_on(
        &mut self,
        model: &Model<D>,
        (step, time): (usize, f64),
        last: Option<&[Condition<D>]>,
    ) -> Result<bool, Error<D>> {
        let zeroed = |before: &f64| model.zeroed.iter().any(|&at| *before < at && at <= time);
        if let Some(before) = self.time.filter(zeroed) {
            self.counted = Some(Arc::new(self.counted_from(before)));
        }
        let next = self.staged.then(|| Presence::at(model, time));
        let Some(next) = next.filter(|next| *next != self.presence) else {
            return Ok(false);
        };
        self.age(model, &next)?;
        let forces = self.forces.take();
        self.load = None;
        if let (Some(conditions), Some(forces)) = (last, &forces) {
            self.release(model, &next, (conditions, &forces.lambda));
            // the rows change; plastic elongations of members stay
            for condition in conditions.iter().filter(|c| !c.is_link()) {
                let record = self.records.get_mut(&condition.name);
                record.into_iter().for_each(|record| record.slip = None);
            }
        }
        for thing in self.new_things(model, &next) {
            if let Thing::Body(body) = thing {
                self.fitted[body] = self.fitted_to(model, body, |of, node| {
                    let before = self.fitted[of].as_ref().map_or([0.0; D], |own| own[node]);
                    Some(add_scaled(self.moved[of].as_ref()?[node], 1.0, before))
                });
                if let Some(counted) = &self.counted {
                    let then = self.fitted_to(model, body, |of, node| {
                        let there = self.moved[of].is_some();
                        there.then(|| counted.placed(of, node))
                    });
                    let counted = self.counted.as_mut().map(Arc::make_mut);
                    counted
                        .into_iter()
                        .for_each(|own| own.comes(body, then.clone()));
                }
                self.yielded[body] = None;
            }
            let moved = self.moved.clone();
            self.births.insert(thing, Birth { step, moved });
        }
        self.presence = next;
        Ok(true)
    }

    /// Bodies whose moduli change keep their stress.
    fn age(&mut self, model: &Model<D>, next: &Presence) -> Result<(), Error<D>> {
        for (place, body) in model.bodies.iter().enumerate() {
            let young = [&self.presence.young[place], &next.young[place]];
            let (Some(moved), Some(time)) = (&self.moved[place], self.time) else {
                continue;
            };
            if young[0] == young[1] || !next.bodies[place] {
                continue;
            }
            let [now, later] = young.map(|young| body.with_moduli(young));
            let before = self.yielded[place].as_deref();
            let kept = now.aged(&later, model.analysis, (&moved[..], time), before);
            let kept = kept.map_err(|source| Error::in_body(body, source))?;
            self.yielded[place] = Some(Arc::new(kept));
        }
        Ok(())
    }

    /// Parts that come with the next stage.
    fn new_things(&self, model: &Model<D>, next: &Presence) -> Vec<Thing> {
        let now = &self.presence;
        let comes = |now: &[bool], next: &[bool]| -> Vec<usize> {
            let places = 0..next.len();
            places.filter(|&k| next[k] && !now[k]).collect()
        };
        let mut things = Vec::new();
        for body in (0..model.bodies.len()).filter(|&body| next.bodies[body]) {
            if self.moved[body].is_none() {
                things.push(Thing::Body(body));
                continue;
            }
            let supports = comes(&now.supports[body], &next.supports[body]).into_iter();
            things.extend(supports.map(|k| Thing::Support(body, k)));
            let springs = comes(&now.springs[body], &next.springs[body]).into_iter();
            things.extend(springs.map(|k| Thing::Spring(body, k)));
        }
        for index in comes(&now.contacts, &next.contacts) {
            let contact = &model.contacts[index];
            let mut sides = contact.pair.sides().into_iter();
            let both = sides.all(|side| self.moved[side.body.0].is_some());
            if both && matches!(contact.law, Law::Tied) {
                things.push(Thing::Tie(contact.name.clone()));
            }
        }
        let holds = |there: &Presence| -> Vec<bool> {
            let each = there.members.iter().zip(&there.tightening);
            each.map(|(there, tightening)| *there && !tightening)
                .collect()
        };
        let members = comes(&holds(now), &holds(next)).into_iter();
        things.extend(members.map(|place| Thing::Member(model.members[place].name.clone())));
        things
    }

    /// Whether the same parts are present as in another state, and came in the same steps.
    pub fn has_things_of(&self, other: &Self) -> bool {
        let came = |state: &Self| {
            let births = state.births.iter();
            births
                .map(|(thing, birth)| (thing.clone(), birth.step))
                .collect::<Vec<_>>()
        };
        let fillings = |state: &Self| {
            let records = state.records.iter();
            let filled = records.filter_map(|(name, r)| Some((name.clone(), r.filling.clone()?)));
            filled.collect::<Vec<_>>()
        };
        self.presence == other.presence
            && came(self) == came(other)
            && fillings(self) == fillings(other)
    }

    /// History of each body of the stage: its later supports and springs, released forces and plastic strain.
    pub fn histories(&self) -> Vec<History<D>> {
        let of_body = |body: usize| {
            let came = |there: &[bool], thing: fn(usize, usize) -> Thing| {
                let there = places(there).into_iter().enumerate();
                let came = there.filter_map(|(k, place)| {
                    let birth = self.births.get(&thing(body, k))?;
                    Some((place?, birth.moved[body].clone()?))
                });
                came.collect()
            };
            History {
                placed: came(&self.presence.supports[body], Thing::Support),
                sprung: came(&self.presence.springs[body], Thing::Spring),
                released: self.released[body].clone(),
                yielded: self.yielded[body].clone(),
            }
        };
        self.whole().into_iter().map(of_body).collect()
    }

    /// Plastic strain of each body of the stage.
    pub fn yielded(&self) -> AllYielded {
        let there = self.whole().into_iter();
        there.map(|body| self.yielded[body].clone()).collect()
    }

    /// Displacements of each body of the stage after the last step; `None` before the first one and for a body that comes.
    pub fn displacements(&self) -> Vec<Option<&[Point<D>]>> {
        let there = self.whole().into_iter();
        there.map(|body| self.moved[body].as_deref()).collect()
    }

    /// Displacement of the obstacle of a contact then.
    pub fn obstacle(&self, contact: &str) -> Option<Point<D>> {
        self.obstacles.get(contact).copied()
    }

    /// Work that the friction of a contact has dissipated.
    pub fn dissipated(&self, contact: &str) -> f64 {
        let record = self.records.get(contact);
        record.map_or(0.0, |record| record.dissipated)
    }

    /// The same state, with gaskets in other ones, by the names of their contacts.
    pub fn with_fillings(&self, fillings: Vec<(String, Filling)>) -> Self {
        let mut state = self.clone();
        for (name, filling) in fillings {
            state.records.entry(name).or_default().filling = Some(filling);
        }
        state
    }

    /// State of the nodes of a joint, and of a gasket, by the name of their contact.
    pub fn before(&self, contact: &str) -> Before<'_> {
        let record = self.records.get(contact);
        let lost = record.and_then(|record| record.lost.as_ref());
        (lost, record.and_then(|record| record.filling.as_ref()))
    }

    /// The slip from which friction counts, in all rows (m,): relative motions of the sides of contacts, and plastic elongations of members.
    pub fn slips(&self, conditions: &[Condition<D>]) -> Vec<f64> {
        let of_condition = |condition: &Condition<D>| {
            let slides = condition.slides();
            let known = self.records.get(&condition.name);
            let known = known.and_then(|record| record.slip.as_ref());
            match known.filter(|known| known.len() == slides.len()) {
                Some(known) => known.clone(),
                None => {
                    let rows = slides.iter().enumerate();
                    rows.map(|(row, &along)| {
                        if along {
                            condition.moved_before(row)
                        } else {
                            0.0
                        }
                    })
                    .collect()
                }
            }
        };
        conditions.iter().flat_map(of_condition).collect()
    }

    /// Sets in the conditions of the stage the displacements of their sides when their bodies appeared and when the stage begins, and in
    /// links those of the moment when they came.
    ///
    /// Errors: a prescribed displacement of an obstacle that is not finite.
    pub fn place(&self, model: &Model<D>, conditions: &mut [Condition<D>]) -> Result<(), Error<D>> {
        let whole = self.whole();
        for condition in conditions {
            if let Some(contact) = condition.contact_of(model) {
                condition.touch.began = self.began(&whole, contact, condition)?;
            }
            if let Some(mortar) = &condition.mortar {
                let [own, other] = [condition.nonmortar.body, mortar.body].map(|id| whole[id.0]);
                condition.touch.fit = self.fit(&condition.name, own, other);
            }
            let bolt = condition
                .source
                .member()
                .and_then(|of| model.members[of].kind.bolt());
            if let Some(bolt) = bolt {
                if let Some(birth) = self.births.get(&Thing::Member(condition.name.clone())) {
                    keep(bolt, condition, |body| birth.moved[whole[body]].clone());
                }
                continue;
            }
            let birth = match condition.source {
                Source::Of(Owner::Bed(of, place)) => self.spring(whole[of], place),
                Source::Of(Owner::Member(_)) => {
                    self.births.get(&Thing::Member(condition.name.clone()))
                }
                // contacts are fitted, and points of couples come with their bodies
                Source::Contact(_)
                | Source::Of(
                    Owner::Body(_) | Owner::Obstacle(_) | Owner::Point(..) | Owner::Gasket(_),
                ) => None,
            };
            let Some(birth) = birth else { continue };
            let mut came_with = vec![0.0; condition.came_with.len()];
            for (body, rows) in condition.ends() {
                let Some(Some(u)) = whole.get(body).map(|&body| &birth.moved[body]) else {
                    continue;
                };
                for (came, row) in came_with.iter_mut().zip(rows) {
                    *came += row.iter().map(|&(node, c)| dot(c, u[node])).sum::<f64>();
                }
            }
            condition.came_with = came_with;
        }
        Ok(())
    }

    /// Birth of a spring of a body, by its place among the present ones.
    fn spring(&self, body: usize, place: usize) -> Option<&Birth<D>> {
        let there = &self.presence.springs[body];
        let place = (0..there.len()).filter(|&k| there[k]).nth(place)?;
        self.births.get(&Thing::Spring(body, place))
    }

    /// Displacements of the two sides of a contact of the stage at the end of the last step. An obstacle that comes has its prescribed
    /// displacement of that time; one that forces move comes undisplaced.
    fn began(
        &self,
        whole: &[usize],
        contact: &Contact<D>,
        condition: &Condition<D>,
    ) -> Result<Fit<D>, Error<D>> {
        let Some(time) = self.time else {
            return Ok(Fit::default());
        };
        let moved = |side: &SideRef| self.moved[whole[side.body.0]].clone();
        let other = match &condition.mortar {
            Some(mortar) => moved(mortar),
            None => Some(Arc::from(vec![match self.obstacles.get(&contact.name) {
                Some(&moved) => moved,
                None => obstacle_motion(contact, time)?,
            }])),
        };
        Ok(Fit {
            own: moved(&condition.nonmortar),
            other,
        })
    }

    /// The fit of the sides of a contact between these two bodies: the later body to the one that was there.
    fn fit(&self, contact: &str, own: usize, other: usize) -> Fit<D> {
        if let Some(birth) = self.births.get(&Thing::Tie(contact.to_string())) {
            let [own, other] = [own, other].map(|body| birth.moved[body].clone());
            return Fit { own, other };
        }
        let birth = |body: usize| self.births.get(&Thing::Body(body));
        let appeared = |body: usize| birth(body).map_or(0, |birth| birth.step);
        let seen = |later: usize, earlier: usize| {
            let found = birth(later).filter(|_| appeared(later) > appeared(earlier))?;
            found.moved[earlier].clone()
        };
        Fit {
            own: seen(other, own),
            other: seen(own, other),
        }
    }

    /// At each node of a body that appears, the displacement of the nearest node on the other side of its contacts, by body and node; `None`
    /// if it has no contact with a present body.
    fn fitted_to(
        &self,
        model: &Model<D>,
        body: usize,
        moved: impl Fn(usize, usize) -> Option<Point<D>>,
    ) -> Motion<D> {
        let mut opposite: Vec<(Point<D>, Point<D>)> = Vec::new();
        for contact in &model.contacts {
            let sides = contact.pair.sides();
            if !sides.iter().any(|side| side.body.0 == body) {
                continue;
            }
            for side in sides.into_iter().filter(|side| side.body.0 != body) {
                let mesh = &model.bodies[side.body.0].mesh;
                let nodes = mesh.side_nodes(&side.side).unwrap_or_default();
                opposite.extend(nodes.into_iter().filter_map(|node| {
                    let node = node as usize;
                    Some((mesh.points()[node], moved(side.body.0, node)?))
                }));
            }
        }
        let nearest = |point: &Point<D>| {
            let apart = |other: &&(Point<D>, Point<D>)| distance(*point, other.0);
            let found = opposite.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
            found.map(|found| found.1)
        };
        let points = model.bodies[body].mesh.points().par_iter();
        points.map(nearest).collect()
    }

    /// Leaves the forces of the contacts of released bodies that go to their neighbours that stay.
    fn release(
        &mut self,
        model: &Model<D>,
        next: &Presence,
        (conditions, lambda): (&[Condition<D>], &[f64]),
    ) {
        let whole = self.whole();
        for (rows, condition) in row_ranges(conditions) {
            let Some(mortar) = &condition.mortar else {
                continue;
            };
            let [own, other] = [condition.nonmortar.body, mortar.body].map(|id| whole[id.0]);
            let interface = &condition.interface;
            let ends = [
                (own, other, &interface.nonmortar),
                (other, own, &interface.mortar),
            ];
            for (stays, goes, coefficients) in ends {
                let Some(factor) = model.bodies[goes].release.clone() else {
                    continue;
                };
                if !next.bodies[stays] || next.bodies[goes] {
                    continue;
                }
                let mut forces = vec![[0.0; D]; model.bodies[stays].mesh.points().len()];
                for (row, force) in coefficients
                    .iter()
                    .zip(condition.forces(&lambda[rows.clone()]))
                {
                    for &(node, c) in row {
                        forces[node] = add_scaled(forces[node], -force, c);
                    }
                }
                self.released[stays].push((forces.into(), factor));
            }
        }
    }
}
