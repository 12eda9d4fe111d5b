//! Values of parameters from the command line.

use crate::failure::Failure;
use dotyk::case::{AnyCase, CaseError};
use dotyk_deck::Deck;
use std::path::Path;

/// A case as a command reads it: of a case file, or of a deck.
pub struct Input {
    pub case: AnyCase,
    pub deck: Option<Box<Deck>>,
}

/// An error in the text of a case at the line of the deck that it was made of.
pub fn located(deck: Option<&Deck>, error: CaseError) -> CaseError {
    match deck {
        Some(deck) => deck.located(error),
        None => error,
    }
}

/// Arguments of every command that reads one case.
#[derive(clap::Args, Default)]
pub struct Given {
    /// Value of a parameter of the case instead of its own; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    set: Vec<(String, String)>,
}

/// Name and value of `NAME=VALUE`; the case knows which are right.
fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_string(), value.trim().to_string()))
        }
        _ => Err("expected NAME=VALUE, such as E=3e9".to_string()),
    }
}

impl Given {
    /// Names and values.
    pub fn pairs(&self) -> &[(String, String)] {
        &self.set
    }

    /// Whether a parameter is given a value.
    pub fn sets(&self, name: &str) -> bool {
        self.set.iter().any(|(known, _)| known == name)
    }

    /// The case with these values; no deck, whose case is a file only when it is imported.
    pub fn read_case(&self, case: &Path) -> Result<AnyCase, Failure> {
        if dotyk_deck::is_deck(case) {
            let message =
                "a deck is run and checked; for this make a case of it with `dotyk import`";
            return Err(Failure::of(case, message));
        }
        Ok(self.read(case)?.case)
    }

    /// The case with these values, or that of a deck, which has no parameters.
    pub fn read(&self, case: &Path) -> Result<Input, Failure> {
        for (k, (name, _)) in self.set.iter().enumerate() {
            if self.set[..k].iter().any(|(before, _)| before == name) {
                return Err(Failure::Message(format!("--set {name} is given twice")));
            }
        }
        let (case, deck) = dotyk_deck::read_case(case, &self.set)?;
        Ok(Input { case, deck })
    }
}
