//! Quantities that probes read of bodies and contacts, and the words that name them.
//!
//! ```text
//!   BODY.displacement.x   BODY.stress.von_mises   BODY.reaction.y   BODY.SIDE.reaction.y
//!   BODY.rotation.z       CONTACT.pressure        CONTACT.shear.x
//!   CONTACT.resultant.x   CONTACT.length          CONTACT.dissipated_work
//!   SECTION.N             SECTION.M               SECTION.utilisation
//!   MEMBER.force          BODY.SIDE.pressure      BODY.SIDE.closed_area
//! ```
//!
//! Or a quantity is a formula of other probes.
//!
//! A new quantity is a variant with its word here, and its value in `probe.rs`.

use crate::fem::{Bed, Body};
use crate::geometry::{Point, norm};
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::field::{FieldKind, Needs, Shape};
use crate::model::nouns::formula::Formula;
use crate::model::nouns::member::MemberWords;
use crate::model::nouns::members::{Member, MemberKind};
use crate::model::nouns::section::SectionQuantity;
use crate::model::nouns::told::listed;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;

/// The quantity of a probe, as a text names it.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    text: String,
    pub(crate) parts: Parts,
    /// Its contact was sought and not found: it has no value, and the index of its contact no meaning.
    absent: bool,
}

/// The parts of a quantity: index of the body or contact first, index of the axis last.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Parts {
    /// Displacement of a body; a field.
    Displacement(usize, Component),
    /// Rotation of the point of a couple of a body, in radians; a number.
    Rotation(usize, usize),
    /// Stress of a body; a field.
    Stress(usize, Stress),
    /// Stress of a body over its strength; a field.
    Utilisation(usize),
    /// A result of a body read from its nodal values, by its place in the list of results, and its component; a field.
    Field(usize, usize, usize),
    /// Force of the supports on a body, of all or those of a side; a number.
    Reaction(usize, Option<String>, usize),
    /// A quantity that varies along a contact; a field.
    Along(usize, ContactField),
    /// Force of a contact on its nonmortar body; a number.
    Resultant(usize, usize),
    /// Its moment in space about a centre; a number.
    Moment(usize, usize),
    /// Length or area in contact; a number.
    Length(usize, Touching),
    /// Work that friction has dissipated; a number.
    Dissipated(usize, Since),
    /// Displacement of the rigid obstacle of a contact; a number.
    Obstacle(usize, Component),
    /// A quantity that varies along a section; a field of its stations.
    Section(usize, SectionQuantity),
    /// Force of a member; a field of its stations, and alone the one of the largest magnitude.
    Member(usize),
    /// Shortening of a bolt; a number.
    Shortening(usize),
    /// A quantity of the bed of a side of a body.
    Bed(usize, String, BedQuantity),
    /// A number of the values of other probes.
    Formula(Formula),
}

/// A quantity of a bed: a field of its points of integration, or a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BedQuantity {
    Pressure,
    Gap,
    ClosedArea,
}

/// A component of a vector, or its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Component {
    Axis(usize),
    Magnitude,
}

impl Component {
    /// The component of a vector.
    pub(crate) fn of<const D: usize>(self, vector: Point<D>) -> f64 {
        match self {
            Self::Axis(axis) => vector[axis],
            Self::Magnitude => norm(vector),
        }
    }
}

/// The part of a contact that is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Touching {
    /// All closed parts.
    Whole,
    /// Sticking parts.
    Stick,
    /// Slipping parts.
    Slip,
}

/// Where a sum over load steps begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Since {
    /// With the step itself.
    Step,
    /// With the first one.
    Start,
}

/// One of xx yy zz xy yz xz by its place there, von Mises, a principal stress, or the difference of the largest and the
/// smallest one, after Tresca.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stress {
    Component(usize),
    VonMises,
    First,
    Second,
    Third,
    Tresca,
    /// Of the plane: around a centre; with axial symmetry around the axis.
    Hoop,
    /// Normal to the side that it is read along.
    Normal,
}

/// A quantity that varies along a contact. Shear and slip are along the tangent in the plane, lengths in space; or components in
/// global axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactField {
    Pressure,
    Gap,
    Shear,
    ShearVector(Component),
    Slip,
    SlipVector(Component),
    DisplacementNonmortar,
    DisplacementMortar,
}

use ContactField::{
    DisplacementMortar, DisplacementNonmortar, Gap, Pressure, Shear, ShearVector, Slip, SlipVector,
};

const AXES: [(&str, usize); 3] = [("x", 0), ("y", 1), ("z", 2)];

/// Components of a tensor.
const TENSOR: [(&str, usize); 6] = [
    ("xx", 0),
    ("yy", 1),
    ("zz", 2),
    ("xy", 3),
    ("yz", 4),
    ("xz", 5),
];

/// Those of principal values.
const PRINCIPAL: [(&str, usize); 3] = [("s1", 0), ("s2", 1), ("s3", 2)];

/// The force of a member.
const FORCE: &str = "force";
const SHORTENING: &str = "shortening";

/// The displacement of the rigid obstacle of a contact.
const OBSTACLE: &str = "displacement_obstacle";

/// The last two are those of space, the one before them that of the plane.
const STRESSES: [(&str, Stress); 13] = [
    ("xx", Stress::Component(0)),
    ("yy", Stress::Component(1)),
    ("zz", Stress::Component(2)),
    ("xy", Stress::Component(3)),
    ("von_mises", Stress::VonMises),
    ("s1", Stress::First),
    ("s2", Stress::Second),
    ("s3", Stress::Third),
    ("tresca", Stress::Tresca),
    ("normal", Stress::Normal),
    ("hoop", Stress::Hoop),
    ("yz", Stress::Component(4)),
    ("xz", Stress::Component(5)),
];

const FIELDS: [(&str, ContactField); 6] = [
    ("pressure", Pressure),
    ("gap", Gap),
    ("shear", Shear),
    ("slip", Slip),
    ("displacement_nonmortar", DisplacementNonmortar),
    ("displacement_mortar", DisplacementMortar),
];

const OF_BED: [(&str, BedQuantity); 3] = [
    ("pressure", BedQuantity::Pressure),
    ("gap", BedQuantity::Gap),
    ("closed_area", BedQuantity::ClosedArea),
];

const LENGTHS: [(&str, Touching); 3] = [
    ("length", Touching::Whole),
    ("length_stick", Touching::Stick),
    ("length_slip", Touching::Slip),
];

const WORKS: [(&str, Since); 2] = [
    ("dissipated_work", Since::Step),
    ("dissipated_work_total", Since::Start),
];

/// Why a text is not a quantity: which of its words is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QuantityError {
    /// The mistake in the word.
    pub mistake: Mistake,
    /// The word.
    pub word: String,
    /// Its bytes in the text.
    pub at: Range<usize>,
    /// The words known in its place, or after it, where the text ends too early.
    pub known: Vec<String>,
}

/// A mistake in a word of a quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Mistake {
    /// It should be one of these.
    Unknown(Cow<'static, str>),
    /// The quantity ends after it.
    Incomplete,
    /// The quantity goes on after it.
    TooLong,
    /// No material of the body has a strength.
    NoStrength,
    /// No material of the body yields.
    NotPlastic,
    /// The body has no water in its pores.
    NoWater,
    /// The side has no springs.
    NoBed,
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = &self.word;
        match &self.mistake {
            Mistake::Unknown(what) => write!(f, "unknown {what} `{word}`"),
            Mistake::Incomplete => write!(f, "the quantity ends after `{word}`"),
            Mistake::NoStrength => write!(
                f,
                "`{word}` of a body without `strength`: give its material one"
            ),
            Mistake::NotPlastic => write!(
                f,
                "`{word}` of a body that does not yield: give its material `plastic = true`"
            ),
            Mistake::NoWater => write!(
                f,
                "`{word}` of a body without water in its pores: give it `pore_pressure`"
            ),
            Mistake::NoBed => write!(
                f,
                "side `{word}` has no bed: give the body `spring = [{{ side = \"{word}\", normal = .. }}]`"
            ),
            Mistake::TooLong => write!(f, "`{word}` has no components here"),
        }
    }
}

impl std::error::Error for QuantityError {}

impl Quantity {
    /// The quantity that a text names, of these bodies, of contacts and sections with these names, and of these members; all names are distinct.
    ///
    /// Errors: the wrong word, and the words known in its place.
    pub fn parse<const D: usize>(
        text: &str,
        bodies: &[Body<D>],
        [contacts, sections]: [&[&str]; 2],
        members: &[Member<D>],
    ) -> Result<Self, QuantityError> {
        let words = Words(text.split('.').collect());
        let owner = words.0[0];
        let among = |names: &[&str]| names.iter().position(|name| *name == owner);
        let body = bodies.iter().position(|body| body.name == owner);
        let member = members.iter().position(|member| member.name == owner);
        let parts = match (body, among(contacts), among(sections), member) {
            (Some(body), ..) => of_body(&words, body, &bodies[body])?,
            (_, Some(contact), ..) => of_contact::<D>(&words, contact)?,
            (.., Some(section), _) => of_section::<D>(&words, section)?,
            (.., Some(member)) => of_member(&words, member, &members[member].kind)?,
            (None, None, None, None) => {
                let bodies = bodies.iter().map(|body| body.name.as_str());
                let others = contacts.iter().chain(sections).copied();
                let others = others.chain(members.iter().map(|member| member.name.as_str()));
                let has = |kind: &&MemberWords| members.iter().any(|m| m.kind.words() == **kind);
                let kinds = MemberKind::ALL.iter().filter(has);
                let section = (!sections.is_empty()).then_some("section");
                let more = section.into_iter().chain(kinds.map(|kind| kind.key));
                let what: Vec<&str> = ["body", "contact"].into_iter().chain(more).collect();
                let what = listed(&what, "or");
                return Err(words.mistake(Mistake::Unknown(what.into()), 0, bodies.chain(others)));
            }
        };
        let text = text.to_string();
        Ok(Self {
            text,
            parts,
            absent: false,
        })
    }

    /// The same with other indices of bodies, contacts, sections and members; `None` where its part has no index.
    pub(crate) fn placed(
        &self,
        [bodies, contacts, sections, members]: [&[Option<usize>]; 4],
    ) -> Option<Self> {
        if self.absent {
            return None;
        }
        let mut parts = self.parts.clone();
        match &mut parts {
            Parts::Displacement(body, _)
            | Parts::Rotation(body, _)
            | Parts::Stress(body, _)
            | Parts::Utilisation(body)
            | Parts::Field(body, ..)
            | Parts::Bed(body, ..)
            | Parts::Reaction(body, ..) => *body = bodies[*body]?,
            Parts::Along(contact, _)
            | Parts::Resultant(contact, _)
            | Parts::Moment(contact, _)
            | Parts::Length(contact, _)
            | Parts::Dissipated(contact, _)
            | Parts::Obstacle(contact, _) => *contact = contacts[*contact]?,
            Parts::Section(section, _) => *section = sections[*section]?,
            Parts::Member(member) | Parts::Shortening(member) => *member = members[*member]?,
            Parts::Formula(_) => {}
        }
        let text = self.text.clone();
        Some(Self {
            text,
            parts,
            absent: false,
        })
    }

    /// The quantity that a text names, of a contact that was sought between bodies and not found: it has no value.
    ///
    /// Errors: as [`Self::parse`].
    pub fn of_absent<const D: usize>(text: &str, contact: &str) -> Result<Self, QuantityError> {
        let quantity = Self::parse::<D>(text, &[], [&[contact], &[]], &[])?;
        Ok(Self {
            absent: true,
            ..quantity
        })
    }

    /// A number of the values of other probes.
    pub fn of_formula(formula: Formula) -> Self {
        Self {
            text: formula.to_string(),
            parts: Parts::Formula(formula),
            absent: false,
        }
    }

    /// The formula that it is.
    pub fn formula(&self) -> Option<&Formula> {
        match &self.parts {
            Parts::Formula(formula) => Some(formula),
            _ => None,
        }
    }

    /// Its contact was not found.
    pub fn is_absent(&self) -> bool {
        self.absent
    }

    /// Its physical dimension.
    pub fn dimension(&self) -> Dimension {
        match self.parts {
            Parts::Reaction(..) | Parts::Resultant(..) | Parts::Member(_) => Dimension::Force,
            Parts::Stress(..)
            | Parts::Bed(.., BedQuantity::Pressure)
            | Parts::Along(_, Pressure | Shear | ShearVector(_)) => Dimension::Stress,
            Parts::Bed(.., BedQuantity::ClosedArea) => Dimension::Area,
            Parts::Displacement(..)
            | Parts::Along(..)
            | Parts::Length(..)
            | Parts::Shortening(_)
            | Parts::Bed(.., BedQuantity::Gap)
            | Parts::Obstacle(..) => Dimension::Length,
            Parts::Moment(..) => Dimension::Moment,
            Parts::Dissipated(..) => Dimension::Energy,
            Parts::Rotation(..) => Dimension::Angle,
            Parts::Utilisation(..) => Dimension::Ratio,
            Parts::Field(_, field, _) => FieldKind::<3>::ALL[field].dimension,
            Parts::Section(_, quantity) => quantity.dimension(),
            Parts::Formula(_) => Dimension::Other,
        }
    }

    /// It varies from place to place.
    pub fn is_field(&self) -> bool {
        use Parts::*;
        matches!(
            self.parts,
            Displacement(..)
                | Rotation(..)
                | Stress(..)
                | Utilisation(..)
                | Field(..)
                | Along(..)
                | Section(..)
                | Member(_)
                | Bed(.., BedQuantity::Pressure | BedQuantity::Gap)
        )
    }

    /// It is taken about a centre.
    pub fn has_center(&self) -> bool {
        matches!(
            self.parts,
            Parts::Stress(_, Stress::Hoop) | Parts::Moment(..)
        )
    }

    /// It is read along a side: it depends on the normal.
    pub fn needs_side(&self) -> bool {
        matches!(self.parts, Parts::Stress(_, Stress::Normal))
    }

    /// It jumps between the materials of a body.
    pub(crate) fn depends_on_material(&self) -> bool {
        matches!(
            self.parts,
            Parts::Stress(..) | Parts::Utilisation(_) | Parts::Field(..)
        )
    }

    /// It is the length of a contact, or in space its area.
    pub(crate) fn is_extent(&self) -> bool {
        matches!(self.parts, Parts::Length(..))
    }

    /// It belongs to the nodes of a contact.
    pub fn is_of_contact(&self) -> bool {
        matches!(self.parts, Parts::Along(..))
    }

    /// It is known only at the stations of a section or of a member, or at the points of a bed.
    pub fn is_of_stations(&self) -> bool {
        matches!(self.parts, Parts::Section(..) | Parts::Member(_)) || self.is_of_bed()
    }

    /// It is a pressure or gap of a bed.
    pub fn is_of_bed(&self) -> bool {
        matches!(self.parts, Parts::Bed(..)) && self.is_field()
    }

    /// It is the force of a member.
    pub fn is_of_member(&self) -> bool {
        matches!(self.parts, Parts::Member(_))
    }

    /// The section whose force it is.
    pub fn of_section(&self) -> Option<(usize, SectionQuantity)> {
        match self.parts {
            Parts::Section(section, quantity) => Some((section, quantity)),
            _ => None,
        }
    }

    /// It is read at the point of a couple, and nowhere else.
    pub(crate) fn is_rotation(&self) -> bool {
        matches!(self.parts, Parts::Rotation(..))
    }

    /// The body whose displacement or rotation it is.
    pub(crate) fn displaced_body(&self) -> Option<usize> {
        match self.parts {
            Parts::Displacement(body, _) | Parts::Rotation(body, _) => Some(body),
            _ => None,
        }
    }

    /// A rigid motion can be subtracted from it.
    pub fn is_displacement(&self) -> bool {
        use Parts::{Along, Displacement};
        matches!(
            self.parts,
            Displacement(..) | Along(_, DisplacementNonmortar | DisplacementMortar)
        )
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn of_body<const D: usize>(
    words: &Words<'_>,
    index: usize,
    body: &Body<D>,
) -> Result<Parts, QuantityError> {
    let quantities = || {
        let plain = FieldKind::<D>::ALL.iter().filter(|kind| kind.plain);
        QUANTITIES.into_iter().chain(plain.map(|kind| kind.name))
    };
    let axes = &AXES[..D];
    let moved = components::<D>();
    let turns = if D == 3 { &AXES[..] } else { &AXES[2..] };
    let stresses: Vec<(&str, Stress)> = match D {
        3 => STRESSES
            .iter()
            .copied()
            .filter(|s| s.1 != Stress::Hoop)
            .collect(),
        _ => STRESSES[..11].to_vec(),
    };
    let stresses = &stresses[..];
    match words.0[1..] {
        ["displacement", _] => {
            let component = words.one_of(2, "displacement", &moved)?;
            Ok(Parts::Displacement(index, component))
        }
        ["rotation", _] => {
            let axis = words.one_of(2, "component", turns)?;
            Ok(Parts::Rotation(index, axis))
        }
        ["stress", _] => Ok(Parts::Stress(index, words.one_of(2, "stress", stresses)?)),
        ["utilisation"] => match body.materials.iter().any(|m| m.strength.is_some()) {
            true => Ok(Parts::Utilisation(index)),
            false => Err(words.mistake(Mistake::NoStrength, 1, [])),
        },
        ["reaction", _] => {
            let axis = words.one_of(2, "component", axes)?;
            Ok(Parts::Reaction(index, None, axis))
        }
        [side, "reaction", _] => {
            let sides: Vec<_> = body.mesh.side_names().map(|side| (side, ())).collect();
            words.one_of(1, "side", &sides)?;
            let axis = words.one_of(3, "component", axes)?;
            Ok(Parts::Reaction(index, Some(side.to_string()), axis))
        }
        [side, word] if find(&OF_BED, word).is_some() && body.mesh.side(side).is_some() => {
            let quantity = words.one_of(2, "quantity of a bed", &OF_BED)?;
            let bedded = bedded(body);
            match bedded.contains(side) {
                true => Ok(Parts::Bed(index, side.to_string(), quantity)),
                false => Err(words.mistake(Mistake::NoBed, 1, bedded)),
            }
        }
        ["displacement"] => Err(words.incomplete(names(&moved))),
        ["rotation"] => Err(words.incomplete(names(turns))),
        ["stress"] => Err(words.incomplete(names(stresses))),
        ["reaction"] | [_, "reaction"] => Err(words.incomplete(names(axes))),
        [] => Err(words.incomplete(quantities())),
        [word, ..] => {
            let mut kinds = FieldKind::<D>::ALL.iter();
            match kinds.position(|kind| kind.plain && kind.name == word) {
                Some(field) => of_field(words, (index, body), field),
                None if body.mesh.side(word).is_some() => {
                    let beds: &[_] = if bedded(body).contains(word) {
                        &OF_BED
                    } else {
                        &[]
                    };
                    let known = ["reaction"].into_iter().chain(names(beds));
                    Err(match words.0.len() {
                        2 => words.incomplete(known),
                        _ => words.mistake(Mistake::Unknown("quantity of a side".into()), 2, known),
                    })
                }
                None => Err(words.mistake(
                    Mistake::Unknown("quantity of a body".into()),
                    1,
                    quantities(),
                )),
            }
        }
    }
}

/// Quantities of bodies that have a reading of their own.
const QUANTITIES: [&str; 5] = [
    "displacement",
    "rotation",
    "stress",
    "reaction",
    "utilisation",
];

/// The sides of a body that have a bed.
fn bedded<const D: usize>(body: &Body<D>) -> BTreeSet<&str> {
    let beds = body.springs.iter().filter_map(|spring| match &spring.bed {
        Bed::Side { side, .. } => Some(side.as_str()),
        Bed::Point { .. } => None,
    });
    beds.collect()
}

/// A result that is read from its nodal values.
fn of_field<const D: usize>(
    words: &Words<'_>,
    (index, body): (usize, &Body<D>),
    field: usize,
) -> Result<Parts, QuantityError> {
    let kind = &FieldKind::<D>::ALL[field];
    if let Some(needs) = kind.needs.filter(|needs| !needs.met(body)) {
        let mistake = match needs {
            Needs::Yielding => Mistake::NotPlastic,
            Needs::Water => Mistake::NoWater,
        };
        return Err(words.mistake(mistake, 1, []));
    }
    let known: &[(&str, usize)] = match kind.shape {
        Shape::Number => &[],
        Shape::Vector => &AXES[..D],
        Shape::Tensor => &TENSOR,
        Shape::Principal => &PRINCIPAL,
    };
    match (&words.0[2..], known) {
        ([], []) => Ok(Parts::Field(index, field, 0)),
        ([], known) => Err(words.incomplete(names(known))),
        ([_], [_, ..]) => {
            let component = words.one_of(2, "component", known)?;
            Ok(Parts::Field(index, field, component))
        }
        ([_, ..], []) => Err(words.mistake(Mistake::TooLong, 1, [])),
        _ => Err(words.mistake(Mistake::TooLong, 2, [])),
    }
}

/// The words of the components of a vector.
fn components<const D: usize>() -> Vec<(&'static str, Component)> {
    let axes = AXES[..D].iter();
    let axes = axes.map(|&(word, i)| (word, Component::Axis(i)));
    axes.chain([("magnitude", Component::Magnitude)]).collect()
}

fn of_contact<const D: usize>(words: &Words<'_>, contact: usize) -> Result<Parts, QuantityError> {
    let moment = (D == 3).then_some("moment");
    let quantities = || {
        let vectors = ["resultant"].into_iter().chain(moment).chain([OBSTACLE]);
        let numbers = names(&LENGTHS).chain(names(&WORKS));
        names(&FIELDS).chain(vectors).chain(numbers)
    };
    let components = components::<D>();
    match words.0[1..] {
        [OBSTACLE, _] => {
            let component = words.one_of(2, "component", &components)?;
            Ok(Parts::Obstacle(contact, component))
        }
        [OBSTACLE] => Err(words.incomplete(names(&components))),
        ["resultant", _] => {
            let axis = words.one_of(2, "component", &AXES[..D])?;
            Ok(Parts::Resultant(contact, axis))
        }
        ["moment", _] if D == 3 => {
            let axis = words.one_of(2, "component", &AXES)?;
            Ok(Parts::Moment(contact, axis))
        }
        ["moment"] if D == 3 => Err(words.incomplete(names(&AXES))),
        ["resultant"] => Err(words.incomplete(names(&AXES[..D]))),
        [] => Err(words.incomplete(quantities())),
        [word @ ("shear" | "slip"), _] => {
            let component = words.one_of(2, "component", &components)?;
            let vector = if word == "shear" {
                ShearVector
            } else {
                SlipVector
            };
            Ok(Parts::Along(contact, vector(component)))
        }
        [word] => {
            let field = find(&FIELDS, word).map(|field| Parts::Along(contact, field));
            let length = || find(&LENGTHS, word).map(|what| Parts::Length(contact, what));
            let work = || find(&WORKS, word).map(|since| Parts::Dissipated(contact, since));
            let unknown = || {
                words.mistake(
                    Mistake::Unknown("quantity of a contact".into()),
                    1,
                    quantities(),
                )
            };
            field.or_else(length).or_else(work).ok_or_else(unknown)
        }
        [word, ..] if quantities().any(|name| name == word) => {
            Err(words.mistake(Mistake::TooLong, 1, []))
        }
        _ => Err(words.mistake(
            Mistake::Unknown("quantity of a contact".into()),
            1,
            quantities(),
        )),
    }
}

fn of_section<const D: usize>(words: &Words<'_>, section: usize) -> Result<Parts, QuantityError> {
    let known = SectionQuantity::ALL.into_iter();
    let known = known.filter(|quantity| D == 3 || !quantity.is_across());
    let known: Vec<_> = known.map(|quantity| (quantity.name(), quantity)).collect();
    match words.0[1..] {
        [] => Err(words.incomplete(names(&known))),
        [_] => {
            let quantity = words.one_of(1, "quantity of a section", &known)?;
            Ok(Parts::Section(section, quantity))
        }
        _ => Err(words.mistake(Mistake::TooLong, 1, [])),
    }
}

fn of_member(words: &Words<'_>, member: usize, kind: &MemberKind) -> Result<Parts, QuantityError> {
    let shortening = kind.bolt().map(|_| SHORTENING);
    let known = || std::iter::once(FORCE).chain(shortening);
    match words.0[1..] {
        [] => Err(words.incomplete(known())),
        [FORCE] => Ok(Parts::Member(member)),
        [SHORTENING] if shortening.is_some() => Ok(Parts::Shortening(member)),
        [word, _, ..] if known().any(|own| own == word) => {
            Err(words.mistake(Mistake::TooLong, 1, []))
        }
        _ => {
            let what = format!("quantity of a {}", kind.words().key);
            Err(words.mistake(Mistake::Unknown(what.into()), 1, known()))
        }
    }
}

/// The meaning of a word.
fn find<T: Copy>(table: &[(&str, T)], word: &str) -> Option<T> {
    let found = table.iter().find(|(name, _)| *name == word);
    found.map(|(_, value)| *value)
}

fn names<'k, T>(table: &[(&'k str, T)]) -> impl Iterator<Item = &'k str> {
    table.iter().map(|(word, _)| *word)
}

/// The words of a text between its dots, at least one.
struct Words<'t>(Vec<&'t str>);

impl Words<'_> {
    /// The meaning of the word `at`.
    fn one_of<T: Copy>(
        &self,
        at: usize,
        what: &'static str,
        table: &[(&str, T)],
    ) -> Result<T, QuantityError> {
        let found = find(table, self.0[at]);
        found.ok_or_else(|| self.mistake(Mistake::Unknown(what.into()), at, names(table)))
    }

    fn incomplete<'k>(&self, next: impl IntoIterator<Item = &'k str>) -> QuantityError {
        self.mistake(Mistake::Incomplete, self.0.len() - 1, next)
    }

    fn mistake<'k>(
        &self,
        mistake: Mistake,
        at: usize,
        known: impl IntoIterator<Item = &'k str>,
    ) -> QuantityError {
        let start: usize = self.0[..at].iter().map(|word| word.len() + 1).sum();
        QuantityError {
            mistake,
            word: self.0[at].to_string(),
            at: start..start + self.0[at].len(),
            known: known.into_iter().map(str::to_string).collect(),
        }
    }
}
