//! Displacements that count from a load step on: results are told relative to the end of the step before it, and nothing else changes.
//!
//! Let z be the displacements of all bodies at that moment. Later results tell u − z, and pictures draw bodies as if they had their
//! undeformed shapes then. A body that came later counts from its own birth: in pictures it stands on what it was fitted to, less what z
//! was there. Stresses, forces, gaps and slips know nothing of z, and the next step begins with u.

use crate::fem::{Analysis, RigidBasis, fit_rigid};
use crate::geometry::{Point, add_scaled, centroid, dot, sub};
use crate::model::nouns::model::Model;
use crate::model::nouns::solution::{BodySolution, ContactNode, CoupleSolution, Solution};
use crate::model::system::condition::{Condition, contact_rows};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Displacements (nodes,) of a body; `None` for an absent one.
pub(crate) type Motion<const D: usize> = Option<Arc<[Point<D>]>>;

/// The moment from which displacements count; lists are by the bodies of the whole model.
#[derive(Debug, Clone)]
pub(crate) struct Counted<const D: usize> {
    /// Time of the step at whose end displacements are zero.
    pub time: f64,
    /// Displacements then; `None` of bodies that were not there.
    then: Vec<Motion<D>>,
    /// Displacements in pictures then; of bodies that came later those of what they were fitted to.
    placed: Vec<Motion<D>>,
    /// Points of couples then.
    points: Vec<Vec<CoupleSolution<D>>>,
    /// Rigid obstacles then, by contact.
    obstacles: BTreeMap<String, Point<D>>,
}

impl<const D: usize> Counted<D> {
    /// The end of a step: displacements of the bodies, in pictures, and of points and obstacles.
    pub fn at(
        time: f64,
        [then, placed]: [Vec<Motion<D>>; 2],
        points: Vec<Vec<CoupleSolution<D>>>,
        obstacles: BTreeMap<String, Point<D>>,
    ) -> Self {
        Self {
            time,
            then,
            placed,
            points,
            obstacles,
        }
    }

    /// Displacement of a node in pictures at that moment.
    pub fn placed(&self, body: usize, node: usize) -> Point<D> {
        self.placed[body]
            .as_ref()
            .map_or([0.0; D], |placed| placed[node])
    }

    /// A body comes, fitted to neighbours that were displaced by this much then.
    pub fn comes(&mut self, body: usize, fitted_to: Motion<D>) {
        self.then[body] = None;
        self.placed[body] = fitted_to;
        self.points[body].clear();
    }

    /// Makes the displacements of a solution count from here; `whole` is the place of each body of its stage in the whole model.
    pub fn apply(
        &self,
        (model, whole): (&Model<D>, &[usize]),
        conditions: &[Condition<D>],
        solution: &mut Solution<D>,
    ) {
        for (index, (_, condition)) in contact_rows(conditions) {
            let contact = &mut solution.contacts[index];
            let own = &self.then[whole[condition.nonmortar.body.0]];
            let other = condition.mortar.as_ref();
            let other = other.map(|side| &self.then[whole[side.body.0]]);
            let moved = self.obstacles.get(&contact.name).copied();
            let moved = moved.unwrap_or([0.0; D]);
            let of = |motion: &Motion<D>, node: usize| {
                motion.as_ref().map_or([0.0; D], |motion| motion[node])
            };
            let places = condition.interface.nodes.iter();
            for (told, place) in contact.nodes.iter_mut().zip(places) {
                let along = |u: Point<D>| dot(place.normal(), u);
                let opposite = match other {
                    Some(motion) => {
                        let each = place.opposite.iter();
                        each.fold([0.0; D], |sum, &(j, n)| add_scaled(sum, n, of(motion, j)))
                    }
                    None => moved,
                };
                let ContactNode {
                    displacement_nonmortar,
                    displacement_mortar,
                    ..
                } = told;
                *displacement_nonmortar -= along(of(own, place.node));
                *displacement_mortar -= along(opposite);
            }
            if let Some(now) = &mut contact.obstacle {
                *now = sub(*now, moved);
            }
        }
        for (solved, (index, &body)) in solution.bodies.iter_mut().zip(whole.iter().enumerate()) {
            let points = model.bodies[index].mesh.points();
            self.apply_to(solved, body, (model.analysis, points));
        }
        solution.counted_from = Some(self.time);
    }

    fn apply_to(
        &self,
        solved: &mut BodySolution<D>,
        body: usize,
        (analysis, points): (Analysis, &[Point<D>]),
    ) {
        if let Some(then) = &self.then[body] {
            let own = solved.displacement.iter_mut().zip(then.iter());
            own.for_each(|(u, then)| *u = sub(*u, *then));
            let basis = RigidBasis::of(analysis);
            let fit = fit_rigid(basis, points, &solved.displacement, centroid(points));
            (solved.rigid.translation, solved.rigid.rotation) = fit;
            solved.fitted = None;
        } else if let (Some(fitted), Some(placed)) = (&mut solved.fitted, &self.placed[body]) {
            let both = fitted.iter().zip(placed.iter());
            *fitted = both.map(|(now, then)| sub(*now, *then)).collect();
        }
        for (now, then) in solved.couples.iter_mut().zip(&self.points[body]) {
            now.displacement = sub(now.displacement, then.displacement);
            let turned = now.rotation.iter_mut().zip(&then.rotation);
            turned.for_each(|(now, then)| *now -= then);
        }
    }
}
