//! What a probe reads: the quantities of bodies and contacts, and the words that name them.
//!
//! ```text
//!   BODY.displacement.x   BODY.stress.von_mises   BODY.reaction.y   BODY.SIDE.reaction.y
//!   CONTACT.pressure      CONTACT.resultant.x     CONTACT.length
//! ```
//!
//! A new quantity is a variant with its word here, and its value in `probe.rs`.

use crate::fem::Body;
use std::fmt;
use std::ops::Range;

/// What a probe reads, as a text names it.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    text: String,
    pub(crate) parts: Parts,
}

/// The parts of a quantity: index of the body or contact first, index of the axis last.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Parts {
    /// Displacement of a body; a field.
    Displacement(usize, Displacement),
    /// Stress of a body; a field.
    Stress(usize, Stress),
    /// Force of the supports on a body, of all or those of a side; a number.
    Reaction(usize, Option<String>, usize),
    /// What varies along a contact; a field.
    Along(usize, ContactField),
    /// Force of a contact on its nonmortar body; a number.
    Resultant(usize, usize),
    /// Its moment in space about a centre; a number.
    Moment(usize, usize),
    /// Length or area in contact; a number.
    Length(usize),
}

/// A component of a displacement, or its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Displacement {
    Axis(usize),
    Magnitude,
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

/// What varies along a contact. Shear and slip are along the tangent in the plane, lengths in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactField {
    Pressure,
    Gap,
    Shear,
    Slip,
    DisplacementNonmortar,
    DisplacementMortar,
}

use ContactField::{DisplacementMortar, DisplacementNonmortar, Gap, Pressure, Shear, Slip};

/// What a quantity is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// A length.
    Length,
    /// A force.
    Force,
    /// A force per area.
    Stress,
    /// A length times a length.
    Area,
    /// A force times a length.
    Moment,
    /// An integral of another one.
    Other,
}

const AXES: [(&str, usize); 3] = [("x", 0), ("y", 1), ("z", 2)];

/// The two last are those of space, the one before them that of the plane.
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

/// Why a text is no quantity: which of its words is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QuantityError {
    /// What is wrong with the word.
    pub mistake: Mistake,
    /// The word.
    pub word: String,
    /// Its bytes in the text.
    pub at: Range<usize>,
    /// The words that are known in its place, or after it, where the text ends too early.
    pub known: Vec<String>,
}

/// What is wrong with a word of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// It should be one of these.
    Unknown(&'static str),
    /// The quantity ends after it.
    Incomplete,
    /// The quantity goes on after it.
    TooLong,
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = &self.word;
        match self.mistake {
            Mistake::Unknown(what) => write!(f, "unknown {what} `{word}`"),
            Mistake::Incomplete => write!(f, "the quantity ends after `{word}`"),
            Mistake::TooLong => write!(f, "`{word}` of a contact has no components"),
        }
    }
}

impl std::error::Error for QuantityError {}

impl Quantity {
    /// The quantity that a text names, of these bodies and contacts.
    ///
    /// Errors: the word that is wrong, and what is known in its place.
    pub fn parse<const D: usize>(
        text: &str,
        bodies: &[Body<D>],
        contacts: &[&str],
    ) -> Result<Self, QuantityError> {
        let words = Words(text.split('.').collect());
        let owner = words.0[0];
        let body = bodies.iter().position(|body| body.name == owner);
        let contact = contacts.iter().position(|name| *name == owner);
        let of_body = |body: usize| of_body(&words, body, &bodies[body]);
        let parts = match (body, contact) {
            (Some(body), None) => of_body(body)?,
            (None, Some(contact)) => of_contact::<D>(&words, contact)?,
            // a name shared by a body and a contact: the quantity tells which is meant
            (Some(body), Some(contact)) => {
                of_contact::<D>(&words, contact).or_else(|_| of_body(body))?
            }
            (None, None) => {
                let bodies = bodies.iter().map(|body| body.name.as_str());
                let owners = bodies.chain(contacts.iter().copied());
                return Err(words.mistake(Mistake::Unknown("body or contact"), 0, owners));
            }
        };
        let text = text.to_string();
        Ok(Self { text, parts })
    }

    /// What it is measured in.
    pub fn dimension(&self) -> Dimension {
        match self.parts {
            Parts::Reaction(..) | Parts::Resultant(..) => Dimension::Force,
            Parts::Stress(..) | Parts::Along(_, Pressure | Shear) => Dimension::Stress,
            Parts::Displacement(..) | Parts::Along(..) | Parts::Length(_) => Dimension::Length,
            Parts::Moment(..) => Dimension::Moment,
        }
    }

    /// It varies from place to place.
    pub fn is_field(&self) -> bool {
        use Parts::{Length, Moment, Reaction, Resultant};
        !matches!(
            self.parts,
            Reaction(..) | Resultant(..) | Moment(..) | Length(_)
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

    /// It is the length of a contact, or in space its area.
    pub(crate) fn is_extent(&self) -> bool {
        matches!(self.parts, Parts::Length(_))
    }

    /// It belongs to the nodes of a contact.
    pub fn is_of_contact(&self) -> bool {
        matches!(self.parts, Parts::Along(..))
    }

    /// The body whose displacement it is.
    pub(crate) fn displaced_body(&self) -> Option<usize> {
        match self.parts {
            Parts::Displacement(body, _) => Some(body),
            _ => None,
        }
    }

    /// A rigid motion can be taken away from it.
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
    const QUANTITIES: [&str; 3] = ["displacement", "stress", "reaction"];
    let axes = &AXES[..D];
    let moved = axes.iter().map(|&(word, i)| (word, Displacement::Axis(i)));
    let moved: Vec<_> = moved
        .chain([("magnitude", Displacement::Magnitude)])
        .collect();
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
        ["stress", _] => Ok(Parts::Stress(index, words.one_of(2, "stress", stresses)?)),
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
        ["displacement"] => Err(words.incomplete(names(&moved))),
        ["stress"] => Err(words.incomplete(names(stresses))),
        ["reaction"] | [_, "reaction"] => Err(words.incomplete(names(axes))),
        [] => Err(words.incomplete(QUANTITIES)),
        [_, ..] => Err(words.mistake(Mistake::Unknown("quantity of a body"), 1, QUANTITIES)),
    }
}

fn of_contact<const D: usize>(words: &Words<'_>, contact: usize) -> Result<Parts, QuantityError> {
    let moment = (D == 3).then_some("moment");
    let quantities = || {
        let numbers = ["resultant", "length"].into_iter().chain(moment);
        names(&FIELDS).chain(numbers)
    };
    match words.0[1..] {
        ["length"] => Ok(Parts::Length(contact)),
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
        [word, ref more @ ..] => match FIELDS.iter().find(|(name, _)| *name == word) {
            Some(&(_, field)) if more.is_empty() => Ok(Parts::Along(contact, field)),
            _ if quantities().any(|name| name == word) => {
                Err(words.mistake(Mistake::TooLong, 1, []))
            }
            _ => Err(words.mistake(Mistake::Unknown("quantity of a contact"), 1, quantities())),
        },
    }
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
        let found = table.iter().find(|(word, _)| *word == self.0[at]);
        let found = found.map(|(_, value)| *value);
        found.ok_or_else(|| self.mistake(Mistake::Unknown(what), at, names(table)))
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
