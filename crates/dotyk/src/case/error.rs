//! Errors of a text file, with the place in it.

use crate::case::suggest::{listed, meaning, nearest};
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// An error in a file: message, place and advice.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseError {
    /// The fault, in words.
    pub message: String,
    /// A word or two for the place itself; may be empty.
    pub label: Box<str>,
    /// Advice.
    pub help: Option<Box<str>>,
    /// Bytes of the text that the error is about, on one line; `None` when the file could not be read.
    pub span: Option<Range<usize>>,
    /// Name of the file as the user gave it.
    pub source_name: Arc<str>,
    /// Text of the file; empty when it could not be read.
    pub source_text: Arc<str>,
}

impl CaseError {
    /// Line of the error, from 1.
    pub fn line(&self) -> Option<usize> {
        let start = self.span.as_ref()?.start;
        Some(self.source_text.get(..start)?.matches('\n').count() + 1)
    }

    /// Column of the error in characters, from 1.
    pub fn column(&self) -> Option<usize> {
        let before = self.source_text.get(..self.span.as_ref()?.start)?;
        let line = before.rsplit('\n').next()?;
        Some(line.chars().count() + 1)
    }

    /// A file that could not be read.
    pub(crate) fn unreadable(name: &str, why: &str) -> Self {
        Self::unplaced(name, &format!("cannot read the file: {why}"))
    }

    /// An error of a whole file.
    pub(crate) fn unplaced(name: &str, message: &str) -> Self {
        Self {
            message: message.to_string(),
            label: "".into(),
            help: None,
            span: None,
            source_name: name.into(),
            source_text: "".into(),
        }
    }
}

impl fmt::Display for CaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.source_name)?;
        if let (Some(line), Some(column)) = (self.line(), self.column()) {
            write!(f, ", line {line}, column {column}")?;
        }
        write!(f, ": {}", self.message)
    }
}

impl std::error::Error for CaseError {}

/// An error at a place of a text that the code below does not carry along.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    pub message: String,
    pub label: Box<str>,
    pub help: Option<Box<str>>,
    pub span: Range<usize>,
}

impl Fault {
    pub fn new(span: &Range<usize>, message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            label: "".into(),
            help: None,
            span: span.clone(),
        }
    }

    pub fn label(mut self, label: impl Into<Box<str>>) -> Self {
        self.label = label.into();
        self
    }

    pub fn help(mut self, help: impl Into<Box<str>>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the meaning of an unknown word, or the nearest known one, after `label`, and all known words after `help`.
    pub fn nearest<'k>(
        self,
        word: &str,
        [label, help]: [&str; 2],
        known: impl Iterator<Item = &'k str> + Clone,
    ) -> Self {
        let label = meaning(word, known.clone()).unwrap_or_else(|| {
            let near = nearest(word, known.clone()).unwrap_or_default();
            format!("{label} is `{near}`")
        });
        self.label(label).help(format!("{help}: {}", listed(known)))
    }

    /// The error with its file. A span over several lines is cut to its first one, which is what a report can underline.
    pub fn in_source(self, name: &str, text: &str) -> CaseError {
        let start = floor(text, self.span.start);
        let end = floor(text, self.span.end.max(start));
        let first_line = text[start..end].lines().next().map_or(0, str::len);
        CaseError {
            message: self.message,
            label: self.label,
            help: self.help,
            span: Some(start..start + first_line),
            source_name: name.into(),
            source_text: text.into(),
        }
    }
}

/// The largest character boundary of `text` that is not beyond `index`.
fn floor(text: &str, index: usize) -> usize {
    (0..=index.min(text.len()))
        .rev()
        .find(|i| text.is_char_boundary(*i))
        .unwrap_or(0)
}

/// The text of a file, or an error that names the file.
pub(crate) fn read_text(path: &std::path::Path) -> Result<String, CaseError> {
    crate::host::read_text(path)
        .map_err(|why| CaseError::unreadable(&path.display().to_string(), &why))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_and_not_bytes() {
        let text = "a = 1\nř = \"žlutý\" x\n";
        let at = text.find('x').unwrap();
        let error = Fault::new(&(at..at + 1), "m").in_source("f", text);
        assert_eq!((error.line(), error.column()), (Some(2), Some(13)));
        assert_eq!(error.to_string(), "f, line 2, column 13: m");
    }

    #[test]
    fn spans_outside_the_text_are_cut() {
        let error = Fault::new(&(3..99), "m").in_source("f", "ab\ncd\nef");
        assert_eq!(error.span, Some(3..5));
        assert_eq!(
            Fault::new(&(50..99), "m").in_source("f", "ab").span,
            Some(2..2)
        );
    }
}
