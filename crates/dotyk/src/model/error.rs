//! Why a model has no answer.

use crate::contact::ContactError;
use crate::fem::{FemError, show};
use crate::geometry::Point;
use crate::model::nouns::{Body, Model};
use crate::model::solution::Solution;

/// Why a probe cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProbeError<const D: usize> {
    /// A quantity that varies, without a place.
    #[error("`at` or `reduce` is missing")]
    NoPlace,
    /// A point in no cell of the body.
    #[error("the point {} lies outside the body", show(*point))]
    Outside {
        /// The point.
        point: Point<D>,
    },
    /// A point beside the nonmortar side.
    #[error("the point {} does not lie on the nonmortar side", show(*point))]
    Beside {
        /// The point.
        point: Point<D>,
    },
    /// A body has no such side.
    #[error(transparent)]
    Side(#[from] FemError),
    /// A point on a side of a body in space.
    #[error("reading at a point of a side in space is not supported yet; use a reduction")]
    SideInSpace,
}

/// The part of a model that an error is about, by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    /// A body.
    Body(String),
    /// A contact.
    Contact(String),
    /// A probe.
    Probe(String),
}

impl<const D: usize> Error<D> {
    /// What is wrong with a body.
    pub(crate) fn in_body(body: &Body<D>, source: FemError) -> Self {
        Self::Body {
            body: body.name.clone(),
            source,
        }
    }

    /// The same of one step of several, which its message names; `earlier` are the steps before it.
    pub(crate) fn in_step(self, model: &Model<D>, step: usize, earlier: Vec<Solution<D>>) -> Self {
        match model.times[..] {
            [_] => self,
            _ => Self::Step {
                step,
                time: model.times[step - 1],
                source: Box::new(self),
                earlier,
            },
        }
    }

    /// What the error is about, where it is one part of the model.
    pub fn subject(&self) -> Option<Subject> {
        match self {
            Self::Body { body, .. }
            | Self::NotHeld { body, .. }
            | Self::PulledAway { body, .. } => Some(Subject::Body(body.clone())),
            Self::Contact { contact, .. } => Some(Subject::Contact(contact.clone())),
            Self::Probe { probe, .. } => Some(Subject::Probe(probe.clone())),
            Self::Step { source, .. } => source.subject(),
            Self::Model(_) | Self::Solver(_) | Self::NotConverged { .. } => None,
        }
    }
}

/// An error of the whole model: it names body, contact, side or node and says what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error<const D: usize> {
    /// A body cannot be assembled or factored.
    #[error("body \"{body}\": {source}")]
    Body {
        /// Its name.
        body: String,
        /// What is wrong.
        source: FemError,
    },
    /// A contact cannot be paired.
    #[error("contact \"{contact}\": {source}")]
    Contact {
        /// Its name.
        contact: String,
        /// What is wrong.
        source: ContactError,
    },
    /// The model itself is wrong.
    #[error("{0}")]
    Model(String),
    /// Neither supports nor contacts hold a body.
    #[error(
        "body \"{body}\" is not held: its supports leave {motion} free, and {reason}; add a support or a contact"
    )]
    NotHeld {
        /// Its name.
        body: String,
        /// The free motion in words.
        motion: String,
        /// Why that is an error.
        reason: String,
    },
    /// The load pulls a floating body away from everything that could hold it.
    #[error(
        "the load pulls body \"{body}\" away from everything that could hold it ({motion}, resultant {load:.4e}): its contacts only push; add a support, turn the load, or tie the contact"
    )]
    PulledAway {
        /// Its name.
        body: String,
        /// The motion in words.
        motion: String,
        /// Work of the load for a unit motion.
        load: f64,
    },
    /// A probe cannot be read.
    #[error("probe \"{probe}\": {source}")]
    Probe {
        /// Its name.
        probe: String,
        /// What is wrong.
        source: ProbeError<D>,
    },
    /// The contact solver cannot treat the problem.
    #[error("solver: {0}")]
    Solver(String),
    /// One load step of several has no answer.
    #[error("step {step} (t = {time}): {source}")]
    Step {
        /// From 1.
        step: usize,
        /// Its time.
        time: f64,
        /// What is wrong there.
        source: Box<Error<D>>,
        /// The load steps before it, which have converged.
        earlier: Vec<Solution<D>>,
    },
    /// The certificate does not hold; carries the last iterate.
    #[error("not converged: {reason}")]
    NotConverged {
        /// Why.
        reason: String,
        /// The last iterate, with `converged` false.
        solution: Box<Solution<D>>,
        /// The load steps before it, which have converged.
        earlier: Vec<Solution<D>>,
    },
}
