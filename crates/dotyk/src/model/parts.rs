//! Parts of a model: its bodies, and behind them the rigid obstacles that are free to translate, in the order of the
//! contacts, as bodies with K⁺ = 0 and translations as modes.

use crate::fem::BodySystem;
use crate::geometry::{Field, Point};
use crate::model::error::Error;
use crate::model::nouns::{Contact, Model, Motion, Pair};
use std::borrow::Cow;

/// Contacts whose obstacle is free, with its force.
fn free_obstacles<const D: usize>(
    model: &Model<D>,
) -> impl Iterator<Item = (&Contact<D>, &[Field; D])> {
    model.contacts.iter().filter_map(|contact| {
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
pub(crate) fn obstacle_part<const D: usize>(
    model: &Model<D>,
    contact: &Contact<D>,
) -> Option<usize> {
    let place = free_obstacles(model).position(|(c, _)| c.name == contact.name);
    place.map(|place| model.bodies.len() + place)
}

/// The systems of all free obstacles at a time.
///
/// Errors: a force that is not finite.
pub(crate) fn obstacle_systems<const D: usize>(
    model: &Model<D>,
    time: f64,
) -> Result<Vec<BodySystem<D>>, Error<D>> {
    let system = |(contact, force): (&Contact<D>, &[Field; D])| {
        let mut value = [0.0; D];
        for (value, field) in value.iter_mut().zip(force) {
            *value = field.at([0.0; D], time);
            if !value.is_finite() {
                return Err(Error::Obstacle {
                    contact: contact.name.clone(),
                    what: "force on",
                    field: field.clone(),
                });
            }
        }
        Ok(BodySystem::rigid(value, model.analysis))
    };
    free_obstacles(model).map(system).collect()
}

/// Name of a part in messages.
pub(crate) fn part_name<const D: usize>(model: &Model<D>, part: usize) -> String {
    match part.checked_sub(model.bodies.len()) {
        None => model.bodies[part].name.clone(),
        Some(place) => {
            let contact = free_obstacles(model).nth(place);
            contact.map_or_else(String::new, |(contact, _)| {
                format!("obstacle of {}", contact.name)
            })
        }
    }
}

/// Nodes of a part; those of an obstacle only tell its size, that of all bodies.
pub(crate) fn part_points<const D: usize>(model: &Model<D>, part: usize) -> Cow<'_, [Point<D>]> {
    match model.bodies.get(part) {
        Some(body) => Cow::Borrowed(body.mesh.points()),
        None => Cow::Owned(vec![[0.0; D]]),
    }
}
