//! What load steps leave to those after them, where bodies, supports and contacts come and go:
//!
//! * a body that appears is free of stress and fits what it touches: the gaps of its contacts count from the displacements
//!   u_a of the bodies that were there, g₀ + B u_a, in normal and tangential rows;
//! * a support that appears holds the nodes of its body where they are;
//! * a spring or a bar that appears bears nothing there, but for the prestress of a bar, which in its first step pulls with that
//!   alone, whatever gives;
//! * friction counts from where the sides of a contact were when its stage began, B u of the last step in whatever directions the
//!   tangents are now: a support that leaves a side leaves the slips under it, a contact or an obstacle that comes has none;
//! * a joint that comes, between bodies one of which comes or not, is whole where its sides are not apart then, g₀ + B (u_a − u);
//! * a body that goes leaves, where it is released, the forces −Bᵀλ of its last step on its neighbours, times what is left
//!   of them at a time.

use crate::fem::History;
use crate::geometry::{Point, add_scaled, distance};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::{Body, Contact, Law, Model};
use crate::model::nouns::presence::{Presence, among, kept, places};
use crate::model::nouns::solution::Solution;
use crate::model::system::paired::{Fit, Paired, obstacle_motion, row_ranges};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::mem::take;
use std::sync::Arc;

/// Displacements (nodes,) of the bodies of a whole model; `None` of those that were not there.
type Moved<const D: usize> = Vec<Option<Arc<[Point<D>]>>>;

/// What load steps leave to those after them, of a model all of which it is.
pub(crate) struct Track<const D: usize> {
    presence: Presence,
    moved: Moved<D>,
    /// What was there when a body appeared.
    found: BTreeMap<usize, Moved<D>>,
    /// By body, the displacements of what it was fitted to, at its nodes.
    fitted: Moved<D>,
    /// Displacements, when a tie appeared, of its bodies that were there: it holds them as they are.
    held: BTreeMap<String, Moved<D>>,
    /// Displacements, when a bar was there, of all bodies: it counts from there.
    bars: BTreeMap<String, Moved<D>>,
    /// Number of the step in which a body appeared.
    appeared: Vec<usize>,
    /// By body, what supports and neighbours have left.
    history: Vec<History<D>>,
    /// What was there in the last stage.
    before: Option<Presence>,
    /// Time of the last step, and what obstacles had moved then, by contact.
    last: Option<(f64, BTreeMap<String, Point<D>>)>,
    /// Nodes of each body that some contact of the model may touch.
    touched: Vec<Vec<usize>>,
}

impl<const D: usize> Track<D> {
    /// At the first step of a model.
    pub fn new(model: &Model<D>, time: f64) -> Self {
        let count = model.bodies.len();
        Self {
            presence: Presence::at(model, time),
            moved: vec![None; count],
            found: BTreeMap::new(),
            fitted: vec![None; count],
            held: BTreeMap::new(),
            bars: BTreeMap::new(),
            appeared: vec![0; count],
            history: vec![History::default(); count],
            before: None,
            last: None,
            touched: touched(model),
        }
    }

    /// The stage that it is at.
    pub fn stage<'m>(&self, model: &'m Model<D>) -> Cow<'m, Model<D>> {
        let left = self
            .history
            .iter()
            .any(|h| !(h.placed.is_empty() && h.sprung.is_empty() && h.released.is_empty()));
        if self.presence.is_whole() && !left {
            return Cow::Borrowed(model);
        }
        let mut stage = model.part(&self.presence, None);
        let history = kept(&self.history, &self.presence.bodies);
        let supports = kept(&self.presence.supports, &self.presence.bodies);
        let springs = kept(&self.presence.springs, &self.presence.bodies);
        let held = supports.zip(springs);
        for ((body, history), (supports, springs)) in stage.bodies.iter_mut().zip(history).zip(held)
        {
            body.history = History {
                placed: among(&history.placed, supports),
                sprung: among(&history.sprung, springs),
                released: history.released.clone(),
                touched: take(&mut body.history.touched),
                waits: take(&mut body.history.waits),
            };
        }
        Cow::Owned(stage)
    }

    /// Remembers the displacements of a solved step of the stage, and tells what its bodies were fitted to.
    pub fn remember(&mut self, solution: &mut Solution<D>) {
        let fitted = kept(&self.fitted, &self.presence.bodies);
        for (body, fitted) in solution.bodies.iter_mut().zip(fitted) {
            body.fitted.clone_from(fitted);
        }
        let obstacles = solution.contacts.iter();
        let obstacles = obstacles.filter_map(|c| Some((c.name.clone(), c.obstacle?)));
        self.last = Some((solution.time, obstacles.collect()));
        let mut solved = solution.bodies.iter();
        for (moved, &there) in self.moved.iter_mut().zip(&self.presence.bodies) {
            *moved = match there {
                true => solved.next().map(|body| body.displacement.clone().into()),
                false => None,
            };
        }
    }

    /// Goes on to a step; whether something comes or goes there. `last` are the pairs of the stage before it, and its forces (m,).
    pub fn change(
        &mut self,
        model: &Model<D>,
        (step, time): (usize, f64),
        last: Option<(&[Paired<D>], &[f64])>,
    ) -> bool {
        let next = Presence::at(model, time);
        if next == self.presence {
            return false;
        }
        if let Some(last) = last {
            self.release(model, &next, last);
        }
        for index in 0..model.bodies.len() {
            if !next.bodies[index] {
                continue;
            }
            let Some(moved) = self.moved[index].clone() else {
                self.appeared[index] = step;
                self.found.insert(index, self.moved.clone());
                self.fitted[index] = self.fitted_to(model, index);
                continue;
            };
            let came = |list: fn(&Presence) -> &Vec<Vec<bool>>| {
                let [before, next] = [&self.presence, &next].map(|there| &list(there)[index]);
                let new = (0..next.len()).filter(|&place| next[place] && !before[place]);
                new.map(|place| (place, Arc::clone(&moved)))
                    .collect::<Vec<_>>()
            };
            let (supports, springs) = (came(|p| &p.supports), came(|p| &p.springs));
            self.history[index].placed.extend(supports);
            self.history[index].sprung.extend(springs);
        }
        for (index, contact) in model.contacts.iter().enumerate() {
            let appears = next.contacts[index] && !self.presence.contacts[index];
            let mut sides = contact.pair.sides().into_iter();
            let both = sides.all(|side| self.moved[side.body.0].is_some());
            if appears && both && matches!(contact.law, Law::Tied) {
                self.held.insert(contact.name.clone(), self.moved.clone());
            }
        }
        for (index, bar) in model.bars.iter().enumerate() {
            let holds = |there: &Presence| there.bars[index] && !there.tightening[index];
            if holds(&next) && !holds(&self.presence) {
                self.bars.insert(bar.name.clone(), self.moved.clone());
            }
        }
        self.before = Some(std::mem::replace(&mut self.presence, next));
        true
    }

    /// Place in the last stage of each body of this one that has the same supports as there.
    pub fn going_on(&self) -> Vec<Option<usize>> {
        let Some(before) = &self.before else {
            return self
                .presence
                .bodies
                .iter()
                .filter(|b| **b)
                .map(|_| None)
                .collect();
        };
        let places = places(&before.bodies);
        let there = (0..places.len()).filter(|&body| self.presence.bodies[body]);
        let now = &self.presence;
        let same = |body: usize| {
            before.supports[body] == now.supports[body] && before.springs[body] == now.springs[body]
        };
        there
            .map(|body| places[body].filter(|_| same(body)))
            .collect()
    }

    /// Nodes that contacts of this or another stage touch, of each of so many parts of the stage.
    pub fn lasting(&self, parts: usize) -> Vec<Vec<usize>> {
        let mut nodes: Vec<_> = kept(&self.touched, &self.presence.bodies)
            .cloned()
            .collect();
        nodes.resize(parts, Vec::new());
        nodes
    }

    /// Where the two sides of a contact of the stage were at the end of the last step. What is prescribed of an obstacle that
    /// comes is its way before, too; one that forces move comes as it is drawn.
    ///
    /// Errors: a prescribed displacement that is not finite.
    pub fn moved(&self, contact: &Contact<D>, pair: &Paired<D>) -> Result<Fit<D>, Error<D>> {
        let Some((time, obstacles)) = &self.last else {
            return Ok(Fit::default());
        };
        let there = &self.presence.bodies;
        let moved = |side: &SideRef| {
            let mut whole = (0..there.len()).filter(|&body| there[body]);
            self.moved[whole.nth(side.body.0)?].clone()
        };
        let other = match &pair.mortar {
            Some(mortar) => moved(mortar),
            None => Some(Arc::from(vec![match obstacles.get(&contact.name) {
                Some(&moved) => moved,
                None => obstacle_motion(contact, *time)?,
            }])),
        };
        Ok(Fit {
            own: moved(&pair.nonmortar),
            other,
        })
    }

    /// At each node of a body that appears, what the nearest node on the other side of its contacts has moved; `None` where it
    /// touches nothing that was there.
    fn fitted_to(&self, model: &Model<D>, body: usize) -> Option<Arc<[Point<D>]>> {
        let mut opposite: Vec<(Point<D>, Point<D>)> = Vec::new();
        for contact in &model.contacts {
            let sides = contact.pair.sides();
            if !sides.iter().any(|side| side.body.0 == body) {
                continue;
            }
            for side in sides.into_iter().filter(|side| side.body.0 != body) {
                let Some(moved) = &self.moved[side.body.0] else {
                    continue;
                };
                let mesh = &model.bodies[side.body.0].mesh;
                let before = &self.fitted[side.body.0];
                let nodes = mesh.side_nodes(&side.side).unwrap_or_default();
                opposite.extend(nodes.into_iter().map(|node| {
                    let node = node as usize;
                    let before = before.as_ref().map_or([0.0; D], |before| before[node]);
                    (mesh.points()[node], add_scaled(moved[node], 1.0, before))
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
        (paired, lambda): (&[Paired<D>], &[f64]),
    ) {
        let there = &self.presence.bodies;
        let whole: Vec<usize> = (0..there.len()).filter(|&body| there[body]).collect();
        for (rows, pair) in row_ranges(paired) {
            let Some(mortar) = &pair.mortar else { continue };
            let [own, other] = [pair.nonmortar.body, mortar.body].map(|id| whole[id.0]);
            let interface = &pair.interface;
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
                for (row, force) in coefficients.iter().zip(pair.forces(&lambda[rows.clone()])) {
                    for &(node, c) in row {
                        forces[node] = add_scaled(forces[node], -force, c);
                    }
                }
                self.history[stays].released.push((forces.into(), factor));
            }
        }
    }

    /// Displacements of the bodies of the stage when a bar was there; `None` where it always was.
    pub fn found_by_bar(&self, name: &str) -> Option<Moved<D>> {
        let found = self.bars.get(name)?;
        Some(kept(found, &self.presence.bodies).cloned().collect())
    }

    /// What the sides of a contact of the stage between these two bodies of it were fitted to.
    pub fn fit(&self, contact: &str, nonmortar: BodyId, mortar: BodyId) -> Fit<D> {
        let there = &self.presence.bodies;
        let place = |id: BodyId| (0..there.len()).filter(|&body| there[body]).nth(id.0);
        let (Some(own), Some(other)) = (place(nonmortar), place(mortar)) else {
            return Fit::default();
        };
        if let Some(held) = self.held.get(contact) {
            let [own, other] = [own, other].map(|body| held[body].clone());
            return Fit { own, other };
        }
        // the later one was fitted to the one that was there
        let seen = |later: usize, earlier: usize| {
            let later_came = self.appeared[later] > self.appeared[earlier];
            let found = self.found.get(&later).filter(|_| later_came)?;
            found[earlier].clone()
        };
        Fit {
            own: seen(other, own),
            other: seen(own, other),
        }
    }
}

/// Nodes of each body on sides of contacts.
fn touched<const D: usize>(model: &Model<D>) -> Vec<Vec<usize>> {
    let of_body = |(index, body): (usize, &Body<D>)| {
        let sides = model
            .contacts
            .iter()
            .flat_map(|contact| contact.pair.sides());
        let own = sides.filter(|side| side.body.0 == index);
        let nodes = own.flat_map(|side| body.mesh.side_nodes(&side.side).unwrap_or_default());
        let nodes: BTreeSet<usize> = nodes.map(|node| node as usize).collect();
        nodes.into_iter().collect()
    };
    model.bodies.iter().enumerate().map(of_body).collect()
}
