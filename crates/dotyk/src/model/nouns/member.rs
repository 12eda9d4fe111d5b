//! Members: connections of points of bodies by forces along a line. Common data of all kinds; each kind is a file of `members/`.
//!
//! A member is a chain of elements between points that move with the bodies. With its direction t, the displacement u_k of its k-th
//! point and the stiffness k_k of its elements, element k pulls its ends together by
//!
//! ```text
//!   N_k = P + k_k (e_k − e_a),       e_k = t·(u_{k+1} − u_k)
//! ```
//!
//! P is its prestress and e_a its reference elongation. A prestressed member pulls with constant P in the step in which it comes, and e_a
//! is the elongation at the end of that step; without prestress e_a is that before the step. What N may be is the law of its kind.
//!
//! A member held at its ends has one element. A grouted one has two or, in cells of second order, four in each cell that it crosses; its
//! points move with the cells in which they lie, and meshes need not fit. Across itself it has no stiffness.
//!
//! Units: N a force, of one member, tension positive. In the plane a model is as thick as its bodies: with `spacing` it holds
//! thickness/spacing members. With axial symmetry it stands for `count` members, each in a meridian plane at an angle of its own from
//! the next: they are spread evenly around the axis, which is a cone of members. All move alike, so that their energy and their work are
//! those of one times the count, and their nodal forces are sums over the full turn as all others:
//!
//! ```text
//!   Π = count · ½ k e²,     f = count · N t    along r and z;   the radial parts balance around the turn
//! ```

use crate::dual::Block;
use crate::geometry::Point;
use crate::model::nouns::ids::{BodyId, SideRef};

/// The line of a member and its connection to the bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Line<const D: usize> {
    /// Where it begins and ends.
    pub ends: [MemberEnd<D>; 2],
    /// The bodies in which its points lie; for sides the bodies of these.
    pub bodies: Vec<BodyId>,
    /// How it is connected to them.
    pub bond: Bond,
    /// Distance of one member to the next across a plane model; `None`: one in the thickness.
    pub spacing: Option<f64>,
    /// How many there are in the full turn, with axial symmetry alone.
    pub count: Option<usize>,
    /// Of each end, if it is at a point: it pulls at a disc of this radius across the member, in the plane at a line twice as long;
    /// `None`: at the point itself.
    pub radius: [Option<f64>; 2],
}

/// The keys of the two ends in a case file.
pub(crate) const ENDS: [&str; 2] = ["from", "to"];

/// Where a member begins or ends.
#[derive(Debug, Clone, PartialEq)]
pub enum MemberEnd<const D: usize> {
    /// A point of one of its bodies.
    Point(Point<D>),
    /// The mean displacement of a side, at its centroid.
    Side(SideRef),
}

/// How a member is connected to its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bond {
    /// At both ends.
    #[default]
    Ends,
    /// All along.
    Grouted,
}

impl Bond {
    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ends => "ends",
            Self::Grouted => "grouted",
        }
    }

    /// The words in a legend.
    pub fn held(self) -> &'static str {
        match self {
            Self::Ends => "held at its ends",
            Self::Grouted => "grouted",
        }
    }
}

impl<const D: usize> Line<D> {
    /// A line between two places, held at its ends, one in the thickness.
    pub fn new(ends: [MemberEnd<D>; 2], bodies: &[BodyId]) -> Self {
        Self {
            ends,
            bodies: bodies.to_vec(),
            bond: Bond::Ends,
            spacing: None,
            count: None,
            radius: [None; 2],
        }
    }

    /// One of the ends is at a point.
    pub fn ends_at_points(&self) -> bool {
        let mut ends = self.ends.iter();
        ends.any(|end| matches!(end, MemberEnd::Point(_)))
    }

    /// All touched bodies.
    pub fn touched(&self) -> impl Iterator<Item = BodyId> {
        let sides = self.ends.iter().filter_map(|end| match end {
            MemberEnd::Side(side) => Some(side.body),
            MemberEnd::Point(_) => None,
        });
        let within = self.ends_at_points() || self.bond == Bond::Grouted;
        let bodies = self.bodies.iter().copied().filter(move |_| within);
        sides.chain(bodies)
    }
}

/// Words for a kind of members.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemberWords {
    /// The key in a case file, and the word for one in messages.
    pub key: &'static str,
    /// The key in results, and the word for several in messages.
    pub plural: &'static str,
    /// The word for one beside springs of bodies.
    pub apart: &'static str,
    /// The word for several beside springs of bodies.
    pub apart_plural: &'static str,
    /// The key of a choice, shown in the report.
    pub choice: &'static str,
}

/// The law of a kind of members.
pub(crate) trait Pull {
    /// Errors: a number out of its range, or a bond that this kind does not have.
    fn check(&self, bond: Bond) -> Result<(), MemberError>;

    /// Stiffness of `count` members in an element of this length.
    fn stiffness(&self, count: f64, length: f64) -> f64;

    /// Forces of `count` members in an element.
    fn law(&self, count: f64) -> PullLaw;

    /// The choice in a word.
    fn chosen(&self, bond: Bond) -> &'static str;

    /// The force in the step in which the member comes; `None`: no force.
    fn prestress(&self) -> Option<f64> {
        None
    }

    /// Whether it is tightened in the step of a time, in which it `comes` or not.
    fn tightened(&self, comes: bool, _time: f64) -> bool {
        comes && self.prestress().is_some()
    }

    /// The largest force of one member.
    fn strength(&self) -> Option<f64> {
        None
    }

    /// The strength in words, alone and beside friction; `None` without a strength.
    fn exhausted(&self) -> Option<[&'static str; 2]> {
        None
    }

    /// The slip is a plastic elongation that only grows, without the slackness.
    fn slackens(&self) -> bool {
        false
    }
}

/// Forces of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PullLaw {
    /// 1: λ is tension, and e an elongation; −1: compression, and e a shortening.
    pub sign: f64,
    /// Of λ besides the offset.
    pub block: Block,
    /// The force at λ = 0.
    pub offset: f64,
    /// Play: the largest e without a force.
    pub gap: f64,
}

/// Why a member is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct MemberError {
    /// The wrong key of the case file; empty: the whole member.
    pub key: &'static str,
    /// The message, with the number or the place.
    pub message: String,
    /// A few words at the place.
    pub label: String,
    /// Advice; may be empty.
    pub help: &'static str,
}

impl MemberError {
    /// An error at a key, with message, label and advice.
    pub(crate) fn new(
        key: &'static str,
        message: impl Into<String>,
        label: impl Into<String>,
        help: &'static str,
    ) -> Self {
        Self {
            key,
            message: message.into(),
            label: label.into(),
            help,
        }
    }

    /// A number out of its range.
    pub(crate) fn number(key: &'static str, value: f64, range: &str) -> Self {
        let message = format!("its {key} is {value}: it must be {range}");
        Self::new(key, message, "not possible", "")
    }

    /// Errors: a number that is not positive.
    pub(crate) fn positive(key: &'static str, value: f64) -> Result<(), Self> {
        match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(Self::number(key, value, "positive")),
        }
    }
}

/// Forces of a member.
#[derive(Debug, Clone, PartialEq)]
pub struct MemberSolution<const D: usize> {
    /// Its name.
    pub name: String,
    /// The words for its kind.
    pub kind: MemberWords,
    /// From its beginning to its end.
    pub length: f64,
    /// One for each of its elements, in their order.
    pub stations: Vec<MemberStation<D>>,
    /// It was tightened in this step.
    pub tightening: bool,
    /// The shortening of a bolt: by how much the sides of its cut have passed each other along its axis.
    pub shortening: Option<f64>,
}

/// Force of an element of a member.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MemberStation<const D: usize> {
    /// Length from the beginning of the member to the middle of the element.
    pub s: f64,
    /// The middle.
    pub point: Point<D>,
    /// Length of the element.
    pub length: f64,
    /// N of one member, tension positive.
    pub force: f64,
}

impl<const D: usize> MemberSolution<D> {
    /// The station with the force of the largest magnitude.
    pub fn largest(&self) -> Option<&MemberStation<D>> {
        let mut stations = self.stations.iter();
        let first = stations.next()?;
        Some(stations.fold(first, |best, next| {
            if next.force.abs() > best.force.abs() {
                next
            } else {
                best
            }
        }))
    }
}
