//! Parts: everything that moves, each once and in one order. The bodies are followed by the rigid parts, which are bodies with K⁺ = 0
//! whose free components are modes: obstacles that are free to translate, and the points of couples. The last are the elastic
//! parts of gaskets, beds and members (`links.rs`).

use crate::fem::{BodySystem, Couple};
use crate::geometry::{Field, Point};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Analysis, Body, Contact, Model, Motion, Pair};

use std::borrow::Cow;

/// The owner of a part, by places in the model. Their order is that of the parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Owner {
    /// A body.
    Body(usize),
    /// The obstacle of a contact, where it is free.
    Obstacle(usize),
    /// The point of a couple: a body, and which of its couples.
    Point(usize, usize),
    /// The elastic part of a contact with a gasket.
    Gasket(usize),
    /// The elastic part of a bed that only presses: a body, and which of its springs.
    Bed(usize, usize),
    /// A member, with the elastic part that all but bolts have.
    Member(usize),
}

impl Owner {
    /// It moves independently, and not just with the bodies that hold it.
    pub fn is_free(self) -> bool {
        matches!(self, Self::Body(_) | Self::Obstacle(_))
    }

    /// The kind in a word.
    pub fn kind<const D: usize>(self, model: &Model<D>) -> &'static str {
        match self {
            Self::Body(_) => "body",
            Self::Obstacle(_) => "obstacle",
            Self::Point(..) => "couple",
            Self::Gasket(_) => "gasket",
            Self::Bed(..) => "bed",
            Self::Member(of) => model.members[of].kind.words().key,
        }
    }

    /// As messages call it.
    pub fn name<const D: usize>(self, model: &Model<D>) -> String {
        let body = |body: usize| &model.bodies[body];
        match self {
            Self::Body(of) => body(of).name.clone(),
            Self::Obstacle(of) => format!("obstacle of {}", model.contacts[of].name),
            Self::Point(of, couple) => {
                format!("{}.{}", body(of).name, body(of).couples[couple].name)
            }
            Self::Gasket(of) => format!("gasket of {}", model.contacts[of].name),
            Self::Bed(of, _) => format!("bed of {}", body(of).name),
            Self::Member(of) => model.members[of].name.clone(),
        }
    }
}

/// The parts of a model.
#[derive(Debug, Clone)]
pub(crate) struct Parts(Vec<Owner>);

impl Parts {
    /// All of them.
    pub fn of<const D: usize>(model: &Model<D>) -> Self {
        let bodies = || model.bodies.iter().enumerate();
        let obstacles = model.contacts.iter().enumerate();
        let obstacles = obstacles.filter(|(_, contact)| free_force(contact).is_some());
        let points = bodies().flat_map(|(index, body)| {
            (0..body.couples.len()).map(move |couple| Owner::Point(index, couple))
        });
        let beds = bodies().flat_map(|(index, body)| {
            let springs = body.springs.iter().enumerate();
            let pressing = springs.filter(|(_, spring)| spring.only_presses());
            pressing.map(move |(place, _)| Owner::Bed(index, place))
        });
        let owners = (0..model.bodies.len()).map(Owner::Body);
        let owners = owners.chain(obstacles.map(|(contact, _)| Owner::Obstacle(contact)));
        let gaskets = model.contacts.iter().enumerate();
        let gaskets = gaskets.filter(|(_, contact)| contact.gasket.is_some());
        let gaskets = gaskets.map(|(contact, _)| Owner::Gasket(contact));
        let owners = owners.chain(points).chain(gaskets).chain(beds);
        // a bolt joins the two sides of a cut without a part between them
        let members = model.members.iter().enumerate();
        let members = members.filter(|(_, member)| member.kind.bolt().is_none());
        let members = members.map(|(place, _)| Owner::Member(place));
        Self(owners.chain(members).collect())
    }

    /// Each part with its owner.
    pub fn iter(&self) -> impl Iterator<Item = (usize, Owner)> {
        self.0.iter().copied().enumerate()
    }

    /// The owner of a part.
    pub fn owner(&self, part: usize) -> Owner {
        self.0[part]
    }

    /// The part of an owner; `None` for an obstacle that is not free, and for a bed that acts both ways.
    pub fn find(&self, owner: Owner) -> Option<usize> {
        self.0.binary_search(&owner).ok()
    }

    /// Number of parts that move independently; they come first.
    pub fn free(&self) -> usize {
        self.0.partition_point(|owner| owner.is_free())
    }

    /// Points of couples: part, body and couple.
    pub fn points<const D: usize>(
        self,
        model: &Model<D>,
    ) -> impl Iterator<Item = (usize, usize, &Couple<D>)> {
        let parts = self.0.into_iter().enumerate();
        parts.filter_map(|(part, owner)| match owner {
            Owner::Point(body, couple) => Some((part, body, &model.bodies[body].couples[couple])),
            _ => None,
        })
    }
}

/// The force on the obstacle of a contact, where it is free.
fn free_force<const D: usize>(contact: &Contact<D>) -> Option<&[Field; D]> {
    match &contact.pair {
        Pair::Obstacle { obstacle, .. } => match &obstacle.motion {
            Motion::Loaded(force) => Some(force),
            Motion::Prescribed(_) => None,
        },
        _ => None,
    }
}

/// The systems of all rigid parts at a time.
///
/// Errors: a force or a prescribed value that is not finite; with axial symmetry a load or displacement of a point off the axis direction.
pub(crate) fn rigid_systems<const D: usize>(
    model: &Model<D>,
    time: f64,
) -> Result<Vec<BodySystem<D>>, Error<D>> {
    let point = |body: &Body<D>, couple: &Couple<D>| {
        let arm = couple.arm(body);
        let drive = arm.and_then(|arm| couple.drive(model.analysis, arm, time));
        let drive = drive.map_err(|source| Error::in_body(body, source))?;
        Ok(BodySystem::rigid(&drive.load, &drive.held))
    };
    let parts = Parts::of(model);
    let systems = parts.iter().filter_map(|(_, owner)| match owner {
        Owner::Obstacle(of) => obstacle_system(model, &model.contacts[of], time),
        Owner::Point(of, couple) => {
            let body = &model.bodies[of];
            Some(point(body, &body.couples[couple]))
        }
        Owner::Body(_) | Owner::Gasket(_) | Owner::Bed(..) | Owner::Member(_) => None,
    });
    systems.collect()
}

fn obstacle_system<const D: usize>(
    model: &Model<D>,
    contact: &Contact<D>,
    time: f64,
) -> Option<Result<BodySystem<D>, Error<D>>> {
    let (mut value, mut held) = ([0.0; D], [None; D]);
    for (axis, field) in free_force(contact)?.iter().enumerate() {
        let component = field.at([0.0; D], time);
        if !component.is_finite() {
            return Some(Err(Error::Obstacle {
                contact: contact.name.clone(),
                what: "force on",
                field: field.clone(),
            }));
        }
        // with axial symmetry rigid parts move along the axis only
        match model.analysis == Analysis::Axisymmetric && axis != 1 {
            true => held[axis] = Some(0.0),
            false => value[axis] = component,
        }
    }
    Some(Ok(BodySystem::rigid(&[value], &[held])))
}

/// Name of a part in messages.
pub(crate) fn part_name<const D: usize>(model: &Model<D>, part: usize) -> String {
    Parts::of(model).owner(part).name(model)
}

/// Nodes of a part; those of a rigid part only give its size, that of all bodies.
pub(crate) fn part_points<const D: usize>(model: &Model<D>, part: usize) -> Cow<'_, [Point<D>]> {
    match model.bodies.get(part) {
        Some(body) => Cow::Borrowed(body.mesh.points()),
        None => Cow::Owned(vec![[0.0; D]]),
    }
}
