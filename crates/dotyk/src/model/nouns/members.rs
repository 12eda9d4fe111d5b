//! All kinds of members, each a file of `members/` and a line of the table below.

mod bar;
mod bolt;
mod spring;

pub use bar::Bar;
pub use bolt::Bolt;
pub(crate) use bolt::Drawn;
pub use spring::{Acts, SpringBetween};

use crate::fem::Active;
use crate::model::nouns::member::{Line, MemberWords, Pull};

/// A connection of places of bodies by forces along a line: a bolt, an anchor, a tie, a spring.
#[derive(Debug, Clone, PartialEq)]
pub struct Member<const D: usize> {
    /// Unique name.
    pub name: String,
    /// The places that it connects.
    pub line: Line<D>,
    /// Its law.
    pub kind: MemberKind,
    /// When it is there, as long as its bodies are.
    pub active: Active,
}

impl<const D: usize> Member<D> {
    /// A member along a line, always there.
    pub fn new(name: &str, line: Line<D>, kind: MemberKind) -> Self {
        Self {
            name: name.to_string(),
            line,
            kind,
            active: Active::ALWAYS,
        }
    }
}

/// The members of each kind with at least one, in the order of all kinds.
pub(crate) fn by_kind<T>(
    members: &[T],
    kind: impl Fn(&T) -> MemberWords,
) -> impl Iterator<Item = (MemberWords, Vec<&T>)> {
    let of_kind = move |words: &MemberWords| {
        let own = members.iter().filter(|member| kind(member) == *words);
        (*words, own.collect::<Vec<_>>())
    };
    let kinds = MemberKind::ALL.iter().map(of_kind);
    kinds.filter(|(_, own)| !own.is_empty())
}

macro_rules! kinds {
    ($($file:ident::$kind:ident)*) => {
        /// The kinds of members.
        #[derive(Debug, Clone, PartialEq)]
        pub enum MemberKind {$(
            #[doc = concat!("See [`", stringify!($kind), "`].")]
            $kind($kind),
        )*}

        impl MemberKind {
            /// The words for all kinds, in the order of case files and results.
            pub const ALL: &[MemberWords] = &[$($file::WORDS,)*];

            /// The words for its kind.
            pub fn words(&self) -> MemberWords {
                match self {$(Self::$kind(_) => $file::WORDS,)*}
            }

            /// Its law.
            pub(crate) fn pull(&self) -> &dyn Pull {
                match self {$(Self::$kind(own) => own,)*}
            }
        }
    };
}

impl MemberKind {
    /// Whether it is a bolt: the two sides of a cut instead of a line between two places.
    pub fn is_bolt(&self) -> bool {
        self.bolt().is_some()
    }

    /// Itself, if it is a bolt: the two sides of a cut instead of a line between two places.
    pub(crate) fn bolt(&self) -> Option<&Bolt> {
        match self {
            Self::Bolt(bolt) => Some(bolt),
            Self::Bar(_) | Self::SpringBetween(_) => None,
        }
    }
}

kinds! {
    bar::Bar
    spring::SpringBetween
    bolt::Bolt
}
