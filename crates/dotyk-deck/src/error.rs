//! Errors of a deck, with the line and the keyword that they are about.

use crate::lines::{Place, Sources};
use dotyk::case::CaseError;

/// An error at a line, before its file is known.
#[derive(Debug, Clone)]
pub(crate) struct Fault {
    pub place: Place,
    pub keyword: String,
    pub message: String,
}

/// Why a deck cannot be read.
#[derive(Debug, Clone, thiserror::Error)]
pub enum DeckError {
    /// The file cannot be read, or not so.
    #[error("{name}: {why}")]
    Unreadable {
        /// The file.
        name: String,
        /// Why.
        why: String,
    },
    /// A mistake at a line.
    #[error("{0}")]
    At(CaseError),
}

impl From<DeckError> for CaseError {
    fn from(error: DeckError) -> Self {
        match error {
            DeckError::At(error) => error,
            DeckError::Unreadable { name, why } => Self {
                message: why,
                label: "".into(),
                help: None,
                span: None,
                source_name: name.into(),
                source_text: "".into(),
            },
        }
    }
}

impl Fault {
    pub fn new(place: Place, keyword: &str, message: impl Into<String>) -> Self {
        Self {
            place,
            keyword: keyword.to_string(),
            message: message.into(),
        }
    }

    /// The error with its file, underlined at its line.
    pub fn in_sources(self, sources: &Sources) -> DeckError {
        let message = match self.keyword.is_empty() {
            true => self.message,
            false => format!("*{}: {}", self.keyword, self.message),
        };
        DeckError::At(at(sources, self.place, &message))
    }
}

/// An error of a file at a line.
pub(crate) fn at(sources: &Sources, place: Place, message: &str) -> CaseError {
    let source = &sources.files[place.file as usize];
    let before = source
        .text
        .split_inclusive('\n')
        .take(place.line as usize - 1);
    let start: usize = before.map(str::len).sum();
    let line = source.text[start..].lines().next().unwrap_or_default();
    CaseError {
        message: message.to_string(),
        label: "".into(),
        help: None,
        span: Some(start..start + line.trim_end().len()),
        source_name: source.name.clone(),
        source_text: source.text.clone(),
    }
}
