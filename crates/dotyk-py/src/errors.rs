//! Exceptions of the package, with the library's own texts.

use dotyk::case::CaseError;
use dotyk_deck::Deck;
use pyo3::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// The package module that defines them.
const MODULE: &str = "dotyk._errors";

fn raised(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let made = py
        .import(MODULE)
        .and_then(|module| module.getattr(class)?.call1((message,)));
    match made {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// Bad input, in words.
pub fn input(py: Python<'_>, message: impl std::fmt::Display) -> PyErr {
    raised(py, "InputError", &message.to_string())
}

/// What a case was read from: whose lines its messages name.
#[derive(Clone)]
pub enum Origin {
    /// A case file.
    File,
    /// A deck, whose lines are not those of the case that it became.
    Deck(Arc<Deck>),
    /// A model built in Python, which has no lines.
    Python,
}

impl Origin {
    /// An error in words, at its place.
    pub fn told(&self, error: &CaseError) -> String {
        match self {
            Self::Python => placed(error),
            _ => self.located(error).to_string(),
        }
    }

    fn located<'a>(&self, error: &'a CaseError) -> Cow<'a, CaseError> {
        match self {
            Self::Deck(deck) => Cow::Owned(deck.located(error.clone())),
            _ => Cow::Borrowed(error),
        }
    }
}

/// An error of a text that the user does not see: behind the keys that lead to it, but for those that it names itself.
fn placed(error: &CaseError) -> String {
    let message = &error.message;
    let name = |step: &String| step.split('`').nth(1).unwrap_or(step).to_string();
    let told = |step: &String| message.contains(&format!("`{}`", name(step)));
    let way: Vec<String> = error.way().into_iter().filter(|step| !told(step)).collect();
    match way.is_empty() {
        true => message.clone(),
        false => format!("{}: {message}", way.join(", ")),
    }
}

/// Bad input at a place of a text.
pub fn of_case(py: Python<'_>, error: &CaseError, origin: &Origin) -> PyErr {
    let mut text = origin.told(error);
    // a label that names a thing is better than its position
    if error.label.contains('`') {
        text = format!("{text}: {}", error.label);
    }
    if let Some(help) = &error.help {
        text = format!("{text}; {help}");
    }
    input(py, text)
}

/// An iteration that ended without an answer, in words.
pub fn not_converged(py: Python<'_>, message: &str) -> PyErr {
    raised(py, "NotConverged", message)
}

/// Something that should not happen.
pub fn internal(py: Python<'_>) -> PyErr {
    raised(
        py,
        "Error",
        "the computation ended without a result; please report it",
    )
}
