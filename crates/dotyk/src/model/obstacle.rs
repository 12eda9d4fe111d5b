//! Rigid obstacles that are free to translate: bodies behind the model's own, with K⁺ = 0 and translations as modes.
//!
//! A part is a body of the model, or behind them a free obstacle, in the order of the contacts.

use crate::fem::BodySystem;
use crate::geometry::{Field, Point};
use crate::model::error::Error;
use crate::model::nouns::*;
use std::borrow::Cow;

impl<const D: usize> Model<D> {
    /// Contacts whose obstacle is free, with its force.
    fn free_obstacles(&self) -> impl Iterator<Item = (&Contact<D>, &[Field; D])> {
        self.contacts.iter().filter_map(|contact| {
            let Pair::Obstacle { obstacle, .. } = &contact.pair else {
                return None;
            };
            match &obstacle.motion {
                Motion::Loaded(force) => Some((contact, force)),
                Motion::Prescribed(_) => None,
            }
        })
    }

    /// The part that the free obstacle of a contact is.
    pub(crate) fn obstacle_part(&self, contact: &Contact<D>) -> Option<usize> {
        let place = self
            .free_obstacles()
            .position(|(c, _)| c.name == contact.name);
        place.map(|place| self.bodies.len() + place)
    }

    /// The systems of all free obstacles at a time.
    ///
    /// Errors: a force that is not finite.
    pub(crate) fn obstacle_systems(&self, time: f64) -> Result<Vec<BodySystem<D>>, Error<D>> {
        let system = |(contact, force): (&Contact<D>, &[Field; D])| {
            let mut value = [0.0; D];
            for (value, field) in value.iter_mut().zip(force) {
                *value = field.at([0.0; D], time);
                if !value.is_finite() {
                    return Err(Error::Model(format!(
                        "contact \"{}\": the force on the obstacle, {field}, is not finite",
                        contact.name
                    )));
                }
            }
            Ok(BodySystem::rigid(value, self.analysis))
        };
        self.free_obstacles().map(system).collect()
    }

    /// Name of a part in messages.
    pub(crate) fn part_name(&self, part: usize) -> String {
        match part.checked_sub(self.bodies.len()) {
            None => self.bodies[part].name.clone(),
            Some(place) => {
                let contact = self.free_obstacles().nth(place);
                contact.map_or_else(String::new, |(contact, _)| {
                    format!("obstacle of {}", contact.name)
                })
            }
        }
    }

    /// Nodes of a part; those of an obstacle only tell its size, that of all bodies.
    pub(crate) fn part_points(&self, part: usize) -> Cow<'_, [Point<D>]> {
        match self.bodies.get(part) {
            Some(body) => Cow::Borrowed(body.mesh.points()),
            None => Cow::Owned(vec![[0.0; D]]),
        }
    }
}
