//! `dotyk import`: a deck as a case file and a mesh.

use crate::Outcome;
use crate::failure::{Failure, warn};
use crate::run::output_folder;
use crate::text::{named, print};
use dotyk::case::CaseError;
use dotyk::output::Stage;
use std::path::PathBuf;

/// Arguments of `dotyk import`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Deck of Abaqus or CalculiX (.inp)
    deck: PathBuf,
    /// Folder for the case file and the mesh [default: DECK-out]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Reads the deck, checks the case, writes both files.
pub fn import(arguments: &Arguments) -> Result<Outcome, Failure> {
    if !dotyk_deck::is_deck(&arguments.deck) {
        let message = "a deck of Abaqus or CalculiX is expected, whose name ends with .inp";
        return Err(Failure::of(&arguments.deck, message));
    }
    let stem = arguments.deck.file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy();
    let (case, mesh) = (format!("{stem}.toml"), format!("{stem}.msh"));
    let deck = dotyk_deck::read(&arguments.deck, &mesh).map_err(CaseError::from)?;
    // what the case shows to be wrong is told before anything is written
    deck.case()?;
    warn(&deck.notes);
    let folder = output_folder(arguments.out.as_deref(), &stem)?;
    let mut stage = Stage::open(&folder).map_err(Failure::of_output)?;
    let files = [(case, &deck.text), (mesh, &deck.mesh)];
    for (name, content) in &files {
        let put = stage.put(name, content.as_bytes());
        put.map_err(Failure::of_output)?;
    }
    stage.commit(&[]).map_err(Failure::of_output)?;
    print(&named(&files.map(|(name, _)| folder.path().join(name))))?;
    Ok(Outcome::Done)
}
