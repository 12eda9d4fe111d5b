//! Errors: why a model has no answer.

use crate::contact::ContactError;
use crate::dual::Certificate;
use crate::fem::{Analysis, Body, FemError, Short, show};
use crate::geometry::{Field, Point};
use crate::host::told;
use crate::linalg::LinalgError;
use crate::mesh::MeshError;
use crate::model::nouns::file_names::NameError;
use crate::model::nouns::intrusion::Intrusion;
use crate::model::nouns::member::{MemberError, MemberWords};
use crate::model::nouns::members::MemberKind;
use crate::model::nouns::model::Model;
use crate::model::nouns::section::SectionError;
use crate::model::nouns::solution::Solution;
use crate::model::nouns::told::listed;
use crate::solve::SolveError;
use std::fmt;

/// The part of a model that an error is about, by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    /// A body.
    Body(String),
    /// A contact.
    Contact(String),
    /// A probe.
    Probe(String),
    /// A section.
    Section(String),
    /// A member, with the words for its kind.
    Member(MemberWords, String),
}

impl Subject {
    /// The name of the part.
    pub fn name(&self) -> &str {
        match self {
            Self::Body(name)
            | Self::Contact(name)
            | Self::Probe(name)
            | Self::Section(name)
            | Self::Member(_, name) => name,
        }
    }
}

/// The parts with unique names, in words.
fn named_parts() -> String {
    let members = MemberKind::ALL.iter().map(|kind| kind.plural);
    let parts = ["bodies", "contacts", "sections"]
        .into_iter()
        .chain(members);
    let parts: Vec<&str> = parts.chain(["coupled points"]).collect();
    listed(&parts, "and")
}

/// An error of the whole model: it names body, contact, side or node and says what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error<const D: usize> {
    /// There is nothing to solve.
    #[error("the model has no body")]
    NoBody,
    /// An analysis of the plane in space, or the other way round.
    #[error("analysis \"{}\" does not fit {D} dimensions", .0.name())]
    Dimension(Analysis),
    /// There is no load step.
    #[error("the model has no load step; give it at least one time")]
    NoStep,
    /// Times that are not finite or do not increase.
    #[error("the times of the load steps must be finite and increase, found {0:?}")]
    Times(Vec<f64>),
    /// A load step that was solved before does not belong to this model.
    #[error("step {step} of the run before is not one of this model: {what}")]
    Past {
        /// From 1.
        step: usize,
        /// The difference.
        what: String,
    },
    /// All load steps were solved before.
    #[error("all {0} steps were solved before; add a step to go on")]
    NothingLeft(usize),
    /// Two parts have one name.
    #[error(
        "two parts of the model are named \"{name}\": {} need names of their own; rename the {kind}",
        named_parts()
    )]
    SameName {
        /// The kind of the second one: "body", "contact", "section", a kind of members or "coupled point".
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// The result file of a body cannot have its name.
    #[error("body \"{body}\": {source}")]
    FileName {
        /// Its name.
        body: String,
        /// The fault of the name.
        source: NameError,
    },
    /// A body cannot be meshed anew.
    #[error("body \"{body}\": {source}")]
    Mesh {
        /// Its name.
        body: String,
        /// The fault.
        source: MeshError,
    },
    /// A body cannot be assembled or factored.
    #[error("body \"{body}\": {source}")]
    Body {
        /// Its name.
        body: String,
        /// The fault.
        source: FemError,
    },
    /// The factors need more memory than there is.
    #[error(
        "{} of memory are needed, and {} are free: body \"{body}\" of {unknowns} unknowns alone needs {}; coarsen its mesh, or take a machine with more memory",
        told(*needed), told(*free), told(*bytes)
    )]
    Memory {
        /// The body that needs most.
        body: String,
        /// Its dofs.
        unknowns: usize,
        /// Bytes that it needs.
        bytes: u64,
        /// Bytes that all bodies and their contacts need.
        needed: u64,
        /// Bytes that the model may take.
        free: u64,
    },
    /// The factor of a body has more entries than can be counted.
    #[error(
        "body \"{body}\" of {unknowns} unknowns: its factor has more than 2^31 entries (17 GB) and is too large for a direct solution; coarsen its mesh"
    )]
    TooLarge {
        /// Its name.
        body: String,
        /// Its dofs.
        unknowns: usize,
    },
    /// A contact cannot be paired.
    #[error("contact \"{contact}\": {source}")]
    Contact {
        /// Its name.
        contact: String,
        /// The fault.
        source: ContactError,
    },
    /// A condition of a contact is not finite.
    #[error(
        "contact \"{contact}\": the condition of node {node} at {} is not finite; check the coordinates and the `surface` of its sides",
        show(*point)
    )]
    Unfit {
        /// Name of the contact.
        contact: String,
        /// Node of the nonmortar body.
        node: usize,
        /// Its position.
        point: Point<D>,
    },
    /// A force or displacement of an obstacle is not finite.
    #[error("contact \"{contact}\": the {what} the obstacle, {field}, is not finite")]
    Obstacle {
        /// Name of the contact.
        contact: String,
        /// "force on" or "displacement of".
        what: &'static str,
        /// The component that is not.
        field: Field,
    },
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
        reason: NotHeld,
    },
    /// Something is there in no load step.
    #[error(
        "{what} \"{}\" is there in no load step: look at the times of the steps and at what is `active`, of it and of its bodies",
        subject.name()
    )]
    NeverThere {
        /// What it is.
        what: &'static str,
        /// It, or its body.
        subject: Subject,
    },
    /// The load pulls a floating body away from everything that could hold it.
    #[error(
        "the load pulls body \"{body}\" away from everything that could hold it ({motion}, resultant {load:.4e}{}): what holds it only pushes; add a support, turn the load, or tie the contact",
        .until.map_or_else(String::new, |t| format!(", it is held until t = {}", Short(t)))
    )]
    PulledAway {
        /// Its name.
        body: String,
        /// The motion in words.
        motion: String,
        /// Work of the load for a unit motion.
        load: f64,
        /// The time within a step until which it is held; `None` where it never is.
        until: Option<f64>,
    },
    /// The sides of a floating body could hold its load, but not by forces at their nodes.
    #[error(
        "no forces at the nodes of contact {contacts} hold body \"{body}\" against {motion}, although pushes between them would: too few facets face the other side there; use smaller ones"
    )]
    OutOfReach {
        /// Its name.
        body: String,
        /// The motion in words.
        motion: String,
        /// Names of the contacts, in words.
        contacts: String,
    },
    /// A probe cannot be read.
    #[error("probe \"{probe}\": {source}")]
    Probe {
        /// Its name.
        probe: String,
        /// The fault.
        source: ProbeError<D>,
    },
    /// A spring or member has a stiffness out of range.
    #[error("{part}: its stiffness is out of range: {source}")]
    Part {
        /// Which.
        part: String,
        /// Why not.
        source: LinalgError,
    },
    /// A member cannot be laid.
    #[error("{} \"{name}\": {source}", kind.key)]
    Member {
        /// Its kind.
        kind: MemberWords,
        /// Its name.
        name: String,
        /// Why not.
        source: MemberError,
    },
    /// A section cannot be cut.
    #[error("section \"{section}\": {source}")]
    Section {
        /// Its name.
        section: String,
        /// The fault.
        source: SectionError,
    },
    /// A bolt is named where no contact is.
    #[error("solver: a bolt is named, but there is no contact")]
    BoltWithoutContact,
    /// A bolt is named beside the contacts.
    #[error("solver: bolt {}: the nearest contact node, {}, is {distance:.3e} away; name a point on a contact", show(*bolt), show(*nearest))]
    BoltAway {
        /// Where it is named.
        bolt: Point<D>,
        /// The nearest contact node.
        nearest: Point<D>,
        /// How far that is.
        distance: f64,
    },
    /// The named bolts do not hold the floating bodies.
    #[error("solver: the bolts at {} do not hold the rigid motions that the contacts control, {modes} in number: name one contact node for each, or leave out `bolt`", bolts.iter().map(|&bolt| show(bolt)).collect::<Vec<_>>().join(", "))]
    Bolts {
        /// The contact nodes that were named.
        bolts: Vec<Point<D>>,
        /// Number of motions to be held.
        modes: usize,
    },
    /// The contact solver cannot treat the problem.
    #[error("solver: {0}")]
    Solver(#[source] SolveError),
    /// The rigid modes cannot be split by what the contacts control.
    #[error("what the contacts control of the rigid motions cannot be told: {0}")]
    RigidModes(LinalgError),
    /// One load step of several has no answer.
    #[error("step {step} (t = {time}): {source}")]
    Step {
        /// From 1.
        step: usize,
        /// Its time.
        time: f64,
        /// The fault in that step.
        source: Box<Error<D>>,
        /// The load steps before it, which have converged.
        earlier: Vec<Solution<D>>,
    },
    /// The certificate does not hold; carries the last iterate.
    #[error("not converged: {reason}")]
    NotConverged {
        /// Why.
        reason: Box<Objection<D>>,
        /// The last iterate, with `converged` false.
        solution: Box<Solution<D>>,
        /// The load steps before it, which have converged.
        earlier: Vec<Solution<D>>,
    },
}

impl<const D: usize> Error<D> {
    /// The error of a fault of a body.
    pub(crate) fn in_body(body: &Body<D>, source: FemError) -> Self {
        let body = body.name.clone();
        Self::Body { body, source }
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

    /// The load steps before the one with the error, which have converged.
    pub(crate) fn into_earlier(self) -> Vec<Solution<D>> {
        match self {
            Self::Step { earlier, .. } | Self::NotConverged { earlier, .. } => earlier,
            _ => Vec::new(),
        }
    }

    /// The part of the model with the error, if it is one part.
    pub fn subject(&self) -> Option<Subject> {
        match self {
            Self::Body { body, .. }
            | Self::Mesh { body, .. }
            | Self::FileName { body, .. }
            | Self::NotHeld { body, .. }
            | Self::OutOfReach { body, .. }
            | Self::PulledAway { body, .. } => Some(Subject::Body(body.clone())),
            Self::NeverThere { subject, .. } => Some(subject.clone()),
            Self::Contact { contact, .. }
            | Self::Unfit { contact, .. }
            | Self::Obstacle { contact, .. } => Some(Subject::Contact(contact.clone())),
            Self::Probe { probe, .. } => Some(Subject::Probe(probe.clone())),
            Self::Member { kind, name, .. } => Some(Subject::Member(*kind, name.clone())),
            Self::Section { section, .. } => Some(Subject::Section(section.clone())),
            Self::Step { source, .. } => source.subject(),
            // these are about all of it, or about parts that have no place of their own
            Self::NoBody
            | Self::Dimension(_)
            | Self::NoStep
            | Self::Times(_)
            | Self::Past { .. }
            | Self::NothingLeft(_)
            | Self::SameName { .. }
            | Self::Memory { .. }
            | Self::TooLarge { .. }
            | Self::Part { .. }
            | Self::BoltWithoutContact
            | Self::BoltAway { .. }
            | Self::Bolts { .. }
            | Self::Solver(_)
            | Self::RigidModes(_)
            | Self::NotConverged { .. } => None,
        }
    }
}

/// Why a motion that supports leave free is an error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotHeld {
    /// There is no contact.
    #[error("no contact faces it")]
    Alone,
    /// Contacts are so far away that strains would drown in rounding.
    #[error(
        "its contacts are out of reach: the smallest clearance, {clearance:.4e}, is more than a million times its size"
    )]
    OutOfReach {
        /// The smallest clearance.
        clearance: f64,
    },
    /// The load drives a motion that no contact or spring controls.
    #[error(
        "its load does work on it (resultant {load:.4e}) and no contact or spring can resist it"
    )]
    Driven {
        /// Work of the load for a unit motion.
        load: f64,
    },
}

/// Why a probe cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProbeError<const D: usize> {
    /// A quantity that varies, without a place.
    #[error("`at`, `along` or `reduce` is missing")]
    NoPlace,
    /// A stress normal to a side, without a side.
    #[error("a stress normal to a side is read along one: `along = \"BODY.SIDE\"` is missing")]
    NoSide,
    /// A rotation that is not that of a point of a couple.
    #[error("a rotation is that of the point of a couple, and is read `at` one")]
    NoCouple,
    /// The displacement of the obstacle of a contact between two bodies.
    #[error("the other side of the contact belongs to a body, and is no rigid obstacle")]
    NoObstacle,
    /// A point in no cell of the body.
    #[error("the point {} lies outside the body", show(*point))]
    Outside {
        /// The point.
        point: Point<D>,
    },
    /// A line all of whose points lie in no cell of the body.
    #[error("no point of the line from {} to {} lies in the body", show(*from), show(*to))]
    LineOutside {
        /// Its first point.
        from: Point<D>,
        /// Its last point.
        to: Point<D>,
    },
    /// A mean or an integral along a line.
    #[error(
        "a line has no area: a mean or an integral is one over all of the body or contact, or over a side"
    )]
    LineHasNoArea,
    /// The side belongs to another body than the quantity.
    #[error("{side} is no side of the body \"{body}\", which the quantity is of")]
    OtherBody {
        /// `body.side`.
        side: String,
        /// Body of the quantity.
        body: String,
    },
    /// A quantity of a contact along a side that is not its own.
    #[error(
        "{side} is no part of {nonmortar}, the nonmortar side, at whose nodes the contact is read"
    )]
    NotNonmortar {
        /// `body.side`.
        side: String,
        /// `body.side` that carries the multipliers.
        nonmortar: String,
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
    /// A section, a member or a bed otherwise than at its stations.
    #[error(
        "it is known at stations, or points of integration: read it at the nearest one, `at`, or reduced over all of them, `reduce`"
    )]
    StationsAlone,
    /// A formula of a probe that is not there.
    #[error("there is no probe `{name}`")]
    NoProbe {
        /// Its name.
        name: String,
    },
    /// A formula of a probe with values along a line.
    #[error(
        "the probe `{name}` has values along a line, and an expression takes one number: read it with `at` or `reduce`"
    )]
    OfLine {
        /// Its name.
        name: String,
    },
    /// A formula that takes itself.
    #[error("its value depends on itself: {way}")]
    Circular {
        /// Names of probes, from the first to itself.
        way: String,
    },
    /// The nodes of a side in space as a line.
    #[error(
        "the nodes of a side in space have no order along a line: give `reduce`, or `along` from one point to another"
    )]
    SideInSpace,
}

/// Why the last iterate is not an answer.
#[derive(Debug, Clone, PartialEq)]
pub enum Objection<const D: usize> {
    /// Loss of equilibrium: friction, or the contacts of the bodies, do not hold the load.
    Slides {
        /// The bodies that move, first the one that moves most.
        bodies: Vec<String>,
        /// Its motion in words.
        motion: String,
        /// The exhausted resistance: friction, or another one; `None` where no friction could hold the load.
        by: Option<&'static str>,
        /// The part of the load along this motion, or of the change of load in the step, that it holds.
        held: f64,
        /// Times of the step before and of this one.
        step: Option<[f64; 2]>,
    },
    /// The iteration ended before the optimality conditions were met.
    Unsettled {
        /// The reason, in the words of the solver.
        reason: String,
        /// Its residual.
        residual: f64,
        /// The worst contact or couple, in words, its place, and advice.
        worst: Option<(String, Point<D>, Advice)>,
    },
    /// The certificate does not hold.
    Violated {
        /// The checked figures.
        certificate: Box<Certificate>,
        /// The contact, in words, whose forces are too uncertain by rounding.
        open: Option<String>,
        /// Forces are not balanced, and bodies are in pieces: the iterations that glue them did not get there.
        glued: bool,
        /// Contact, place and depth where two sides overlap most between their nodes, if by too much.
        overlap: Option<(String, Point<D>, f64)>,
        /// The intrusion of a deformed body into another one, if it is deeper than allowed.
        intrusion: Option<Box<Intrusion<D>>>,
    },
    /// Loss of equilibrium: the load exceeds the limit load of bodies that yield; or the plastic strain did not settle where there is no
    /// limit load.
    Yields {
        /// Number of elastic problems without equilibrium; `None`: there is an equilibrium in which cells bear more than the material,
        /// because they cannot flow at constant volume.
        turns: Option<usize>,
        /// There is no limit load: what flows hardens, or prescribed motion does a good part of the work, and may go any distance.
        unlimited: bool,
        /// The part of the step that they can bear, on a straight line from the loads before it; `None` where that is not known.
        carried: Option<f64>,
    },
    /// A floating body is hardly held against turning: it turns farther than the theory of small rotations allows.
    Turned {
        /// The body.
        body: String,
        /// Its motion in words.
        motion: String,
        /// By how much, in radians.
        turn: f64,
    },
}

/// Advice where an iteration does not settle.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Advice {
    /// A body that is far more compliant than its cells.
    #[error(
        "body \"{body}\" is slender, it gives way {times:.0e} times as much as its cells do: divide it into bodies that are `tied` to each other"
    )]
    Divide {
        /// The body.
        body: String,
        /// The ratio of compliances.
        times: f64,
    },
    /// A node on two rough faces, where contact forces need not exist.
    #[error(
        "{node} lies on two rough faces, which jam it: sliding off one it leans on the other, and with coefficients of {} and {} there need not be any forces; use less than {}, or `exclude` the node from one of the contacts",
        Short(coefficients[0]), Short(coefficients[1]), Short(*limit)
    )]
    Jammed {
        /// The node in words.
        node: String,
        /// Coefficients of friction of the two faces.
        coefficients: [f64; 2],
        /// Below this coefficient of both nothing jams.
        limit: f64,
    },
    /// A body between two rough faces, where contact forces need not exist.
    #[error(
        "body \"{body}\" stands between two rough faces, which jam it: with coefficients of {} and {} friction could hold any load, even one that draws it out, but there need not be any forces that do; hold it by a support, or by a load that presses it in (below a coefficient of {} nothing jams)",
        Short(coefficients[0]), Short(coefficients[1]), Short(*limit)
    )]
    Wedged {
        /// The body.
        body: String,
        /// Coefficients of friction of the two faces.
        coefficients: [f64; 2],
        /// Below this coefficient of both nothing jams.
        limit: f64,
    },
    /// Forces that go with the slips.
    #[error(
        "within the bounds of friction some forces balance the load, but those that go with the slips were not found, or are not unique: try smaller load steps or a smaller coefficient; where a clearance closes, close it in a step of its own, before loads that turn a body or push it along"
    )]
    SmallerSteps,
    /// Bodies that clamp each other in many ways.
    #[error(
        "among so many bodies that clamp each other the forces that go with the slips are found slowly: `tolerance = {tolerance:.0e}` under [solver] ends with balanced forces and that part of accuracy; to all digits nodes that match, or smaller coefficients, help"
    )]
    Crowd {
        /// A tolerance that the forces found are likely to meet.
        tolerance: f64,
    },
    /// Neither.
    #[error("try a larger `tolerance`, or stiffnesses that differ less")]
    LargerTolerance,
}

/// Most bodies that move together and are named.
const NAMED: usize = 4;

/// Bodies in words: the first few, and how many more there are.
fn moving(bodies: &[String]) -> String {
    let shown = bodies.iter().take(NAMED).map(|name| format!("\"{name}\""));
    let shown: Vec<String> = shown.collect();
    let more = bodies.len().saturating_sub(NAMED);
    match (&shown[..], more) {
        ([one], _) => format!("body {one}"),
        ([others @ .., last], 0) => format!("bodies {} and {last}", others.join(", ")),
        (all, _) => format!("bodies {} and {more} more", all.join(", ")),
    }
}

impl<const D: usize> fmt::Display for Objection<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slides {
                bodies,
                motion,
                by,
                held,
                step,
            } => {
                let (moved, alone) = (moving(bodies), bodies.len() == 1);
                let (does, by) = match (by, alone) {
                    (Some(by), true) => ("slides", *by),
                    (Some(by), false) => ("slide", *by),
                    (None, true) => ("tips", "what it touches"),
                    (None, false) => ("tip", "what they touch"),
                };
                write!(
                    f,
                    "loss of equilibrium: {moved} {does} ({motion}); {by} holds "
                )?;
                // "1 of the load" would be all of it
                let held_part = match format!("{}", Short(*held)).as_str() {
                    "1" if *held < 1.0 => format!("all but {}", Short(1.0 - held)),
                    part => part.to_string(),
                };
                match step {
                    Some([before, now]) => write!(
                        f,
                        "it up to {held_part} of the change of load from t = {before} to t = {now} (t = {})",
                        Short(before + held * (now - before))
                    ),
                    None => write!(f, "{held_part} of the load along this motion"),
                }
            }
            Self::Unsettled {
                reason,
                residual,
                worst,
            } => {
                f.write_str(reason)?;
                if residual.is_finite() {
                    write!(f, " (residual {residual:.1e})")?;
                }
                let Some((called, point, advice)) = worst else {
                    return Ok(());
                };
                let at = show(*point);
                write!(f, "; it is worst at {at} of {called}; {advice}")
            }
            Self::Violated {
                certificate,
                open,
                glued,
                overlap,
                intrusion,
            } => {
                f.write_str(&certificate.objection())?;
                if let Some(called) = open {
                    write!(
                        f,
                        ": rounding of coordinates and displacements decides forces of {called}, whose multipliers are finer than the softer side; swap its nonmortar and mortar"
                    )?;
                }
                if *glued {
                    f.write_str(": the pieces of bodies were not glued to that accuracy; `subdomains = 1` under [solver] keeps bodies whole")?;
                }
                if let Some((contact, point, depth)) = overlap {
                    let (depth, at) = (Short(*depth), show(*point));
                    write!(
                        f,
                        ": the sides of contact \"{contact}\" overlap by {depth} at {at}"
                    )?;
                }
                let Some(found) = intrusion else {
                    return Ok(());
                };
                let (depth, at) = (Short(found.depth), show(found.point));
                write!(
                    f,
                    ": as they have moved, body \"{}\" stands {depth} deep in {} with what was at {at}; {}",
                    found.body,
                    found.what(),
                    match found.named {
                        true =>
                            "a contact knows what its sides faced at first, and no others: name all that may touch as its sides; a corner that lies between the nodes of the other side has a condition only as part of the nonmortar one, and motions of more than a facet are beyond small displacements",
                        false => "no contact is named between them",
                    }
                )
            }
            Self::Yields {
                turns: Some(turns),
                unlimited: true,
                carried,
            } => {
                write!(f, "what yields did not settle in {turns} elastic problems")?;
                match carried {
                    Some(part) => write!(
                        f,
                        ": it does up to {} of the step; go there in more steps",
                        Short(*part)
                    ),
                    None => write!(f, ": go there in more steps"),
                }
            }
            Self::Yields { turns, carried, .. } => {
                write!(
                    f,
                    "loss of equilibrium: what yields does not bear the load, "
                )?;
                match turns {
                    Some(turns) => write!(f, "{turns} elastic problems find no balance")?,
                    None => write!(f, "only cells that cannot flow at constant volume hold it")?,
                }
                match carried {
                    Some(carried) => write!(f, "; it holds {} of the step", Short(*carried)),
                    None => Ok(()),
                }
            }
            Self::Turned { body, motion, turn } => write!(
                f,
                "body \"{body}\" is turned by {} rad ({motion}), and the theory knows small rotations alone: hardly anything holds it against turning; hold it by a support, or let more of its nodes touch, by smaller facets",
                Short(*turn)
            ),
        }
    }
}
