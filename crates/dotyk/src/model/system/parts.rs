//! Parts of a model: its bodies, and behind them what is rigid and moves, as bodies with K⁺ = 0 whose components are modes where
//! nothing holds them: the obstacles that are free to translate, in the order of the contacts, then the reference points of
//! couples, in the order of the bodies. Behind these stand the elastic parts of links (`links.rs`).

use crate::fem::{BodySystem, Couple};
use crate::geometry::{Field, Point};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Analysis, Body, Contact, Model, Motion, Pair};

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

/// All couples with the index of their body, in the order of their parts.
pub(crate) fn couples<const D: usize>(
    model: &Model<D>,
) -> impl Iterator<Item = (usize, &Couple<D>)> {
    let bodies = model.bodies.iter().enumerate();
    bodies.flat_map(|(index, body)| body.couples.iter().map(move |couple| (index, couple)))
}

/// The part that the point of the first couple is.
pub(crate) fn first_point<const D: usize>(model: &Model<D>) -> usize {
    model.bodies.len() + free_obstacles(model).count()
}

/// The systems of all rigid parts at a time.
///
/// Errors: a force or a prescribed value that is not finite; what drives a point with axial symmetry but along the axis.
pub(crate) fn rigid_systems<const D: usize>(
    model: &Model<D>,
    time: f64,
) -> Result<Vec<BodySystem<D>>, Error<D>> {
    let obstacles = free_obstacles(model).map(|obstacle| obstacle_system(model, obstacle, time));
    let point = |(body, couple): (usize, &Couple<D>)| {
        let body: &Body<D> = &model.bodies[body];
        let arm = couple.arm(body);
        let drive = arm.and_then(|arm| couple.drive(model.analysis, arm, time));
        let drive = drive.map_err(|source| Error::in_body(body, source))?;
        Ok(BodySystem::rigid(&drive.load, &drive.held))
    };
    obstacles.chain(couples(model).map(point)).collect()
}

fn obstacle_system<const D: usize>(
    model: &Model<D>,
    (contact, force): (&Contact<D>, &[Field; D]),
    time: f64,
) -> Result<BodySystem<D>, Error<D>> {
    let (mut value, mut held) = ([0.0; D], [None; D]);
    for (axis, field) in force.iter().enumerate() {
        let component = field.at([0.0; D], time);
        if !component.is_finite() {
            return Err(Error::Obstacle {
                contact: contact.name.clone(),
                what: "force on",
                field: field.clone(),
            });
        }
        // with axial symmetry what is rigid moves along the axis alone
        match model.analysis == Analysis::Axisymmetric && axis != 1 {
            true => held[axis] = Some(0.0),
            false => value[axis] = component,
        }
    }
    Ok(BodySystem::rigid(&[value], &[held]))
}

/// Name of a part in messages.
pub(crate) fn part_name<const D: usize>(model: &Model<D>, part: usize) -> String {
    if let Some(body) = model.bodies.get(part) {
        return body.name.clone();
    }
    match part.checked_sub(first_point(model)) {
        None => {
            let contact = free_obstacles(model).nth(part - model.bodies.len());
            contact.map_or_else(String::new, |(contact, _)| {
                format!("obstacle of {}", contact.name)
            })
        }
        Some(place) => {
            let couple = couples(model).nth(place);
            couple.map_or_else(
                || link_name(model, part - first_link(model)),
                |(body, couple)| format!("{}.{}", model.bodies[body].name, couple.name),
            )
        }
    }
}

/// Nodes of a part; those of what is rigid only tell its size, that of all bodies.
pub(crate) fn part_points<const D: usize>(model: &Model<D>, part: usize) -> Cow<'_, [Point<D>]> {
    match model.bodies.get(part) {
        Some(body) => Cow::Borrowed(body.mesh.points()),
        None => Cow::Owned(vec![[0.0; D]]),
    }
}

/// The part that the first link has.
pub(crate) fn first_link<const D: usize>(model: &Model<D>) -> usize {
    first_point(model) + couples(model).count()
}

/// Beds that only press: body, and place of the spring in it.
pub(crate) fn beds<const D: usize>(model: &Model<D>) -> impl Iterator<Item = (usize, usize)> {
    model.bodies.iter().enumerate().flat_map(|(index, body)| {
        let pressing = body.springs.iter().enumerate();
        let pressing = pressing.filter(|(_, spring)| spring.presses().is_some());
        pressing.map(move |(place, _)| (index, place))
    })
}

/// Name of the part of a link, by its place among them.
pub(crate) fn link_name<const D: usize>(model: &Model<D>, place: usize) -> String {
    if let Some((body, _)) = beds(model).nth(place) {
        return format!("bed of {}", model.bodies[body].name);
    }
    let bar = place.checked_sub(beds(model).count());
    let bar = bar.and_then(|place| model.bars.get(place));
    bar.map_or_else(String::new, |bar| bar.name.clone())
}
