//! Decks of Abaqus and CalculiX (`.inp`) as cases of dotyk.
//!
//! ```text
//! DECK.inp -> cards (lines) -> deck -> bodies -> case: text, and mesh with groups -> dotyk
//! ```
//!
//! A deck becomes the text of a case and a mesh file: what `dotyk import` writes is what `dotyk run` solves. Every line of the
//! case comes from a line of the deck, so that a mistake that only dotyk finds is told at the deck's own line.
//! Contract: what changes the answer and is not understood is an error at its line; what only tunes a solver is passed over
//! with a remark.

mod answer;
mod bodies;
mod case;
mod course;
mod dat;
mod deck;
mod elements;
mod equations;
mod error;
mod frd;
mod keywords;
mod lines;
mod msh;
mod names;
mod number;
mod pretension;
mod reach;
mod results;
mod steps;

pub use error::DeckError;
pub use lines::{Place, Source, Sources};

use crate::bodies::Bodies;
use crate::deck::Deck as Cards;
use crate::names::Names;
use dotyk::case::{AnyCase, CaseError, Given};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// A deck as a case.
#[derive(Debug)]
pub struct Deck {
    /// The text of the case, which calls its mesh file by the name that it was given.
    pub text: String,
    /// The mesh file: Gmsh 2.2, as text.
    pub mesh: String,
    /// Name of the mesh file in the text.
    file: String,
    /// Name of the deck without extension.
    pub stem: String,
    /// What was passed over, one line each.
    pub notes: Vec<String>,
    origins: Vec<Place>,
    sources: Sources,
    deck: Cards,
    bodies: Bodies,
    contacts: Vec<case::Named>,
    /// Body and name of the point of each reference node.
    references: BTreeMap<deck::Index, (usize, String)>,
    /// Node and bolt of each pre-tension section.
    shortenings: Vec<(deck::Index, String)>,
}

/// Whether a file is a deck, by its name.
pub fn is_deck(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("inp"))
}

/// The case of a case file with other values of its parameters, or of a deck, by the name of the file.
///
/// Errors: as [`AnyCase::read_with`], and as [`read`] and [`Deck::case`]; values for a deck, which has no parameters.
pub fn read_case(
    path: &Path,
    set: &[(String, String)],
) -> Result<(AnyCase, Option<Box<Deck>>), CaseError> {
    if !is_deck(path) {
        return Ok((AnyCase::read_with(path, set)?, None));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let deck = read(path, &name)?;
    if let Some((parameter, _)) = set.first() {
        let why =
            format!("a deck has no parameter `{parameter}`: `dotyk import` makes a case of it");
        return Err(DeckError::Unreadable {
            name: path.display().to_string(),
            why,
        }
        .into());
    }
    Ok((deck.case()?, Some(Box::new(deck))))
}

/// Reads a deck; `file` is how the text of the case calls its mesh file.
///
/// Errors: files that cannot be read; the first mistake, at its line.
pub fn read(path: &Path, file: &str) -> Result<Deck, DeckError> {
    let (sources, cards) = lines::cards(path)?;
    let kept = sources.clone();
    converted(path, file, sources, &cards).map_err(|fault| fault.in_sources(&kept))
}

fn converted(
    path: &Path,
    file: &str,
    sources: Sources,
    cards: &[lines::Card],
) -> Result<Deck, error::Fault> {
    let mut deck = Cards::new(sources, cards)?;
    let mut names = Names::default();
    let bodies = Bodies::new(&deck, &mut names)?;
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let writer = case::Writer::new(&mut deck, &bodies, names, file, &stem)?;
    let (text, groups) = (writer.text, writer.groups);
    let (contacts, references) = (writer.contacts, writer.references);
    let shortenings = writer.shortenings;
    Ok(Deck {
        mesh: msh::text(&deck, &bodies, &groups),
        origins: text.origins,
        text: text.text,
        file: file.to_string(),
        notes: deck.notes.clone(),
        sources: deck.sources.clone(),
        stem,
        deck,
        bodies,
        contacts,
        references,
        shortenings,
    })
}

impl Deck {
    /// The case, with what was passed over among its warnings.
    ///
    /// Errors: mistakes that only the case shows, at the line of the deck.
    pub fn case(&self) -> Result<AnyCase, CaseError> {
        let mut given = Given::default();
        given
            .files
            .insert(self.file.clone(), self.mesh.clone().into_bytes());
        let (name, given) = (format!("{}.toml", self.stem), Arc::new(given));
        let read = AnyCase::from_parts(&self.text, &name, Path::new(""), &[], &given);
        let mut read = read.map_err(|error| self.located(error))?;
        let warnings = match &mut read {
            AnyCase::Plane(case) => &mut case.warnings,
            AnyCase::Space(case) => &mut case.warnings,
        };
        warnings.splice(0..0, self.notes.iter().cloned());
        Ok(read)
    }

    /// An error in the text of the case as one of the deck.
    pub fn located(&self, error: CaseError) -> CaseError {
        let Some(place) = error.line().and_then(|line| self.origins.get(line - 1)) else {
            let name = self.sources.files.first().map(|source| source.name.clone());
            return CaseError {
                source_name: name.unwrap_or_default(),
                span: None,
                ..error
            };
        };
        let at = error::at(&self.sources, *place, &error.message);
        CaseError {
            label: error.label,
            help: error.help,
            ..at
        }
    }
}
