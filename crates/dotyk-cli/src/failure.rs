//! Bad input: one clear message on standard error, underlined in its file where it has a place.

use dotyk::case::CaseError;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource};
use std::fmt;
use std::io::{IsTerminal, Write};
use std::path::Path;

/// Why a command refuses to go on.
#[derive(Debug)]
pub enum Failure {
    /// A mistake in a file.
    File(CaseError),
    /// Anything else.
    Message(String),
}

impl From<CaseError> for Failure {
    fn from(error: CaseError) -> Self {
        Self::File(error)
    }
}

impl Failure {
    /// A message about a file or folder.
    pub fn of(path: &Path, message: impl fmt::Display) -> Self {
        Self::Message(format!("{}: {message}", path.display()))
    }

    /// Prints the message: with colours on a terminal, plain elsewhere.
    pub fn print(self) {
        let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
        let theme = if colours {
            GraphicalTheme::unicode()
        } else {
            GraphicalTheme::none()
        };
        let handler = GraphicalReportHandler::new_themed(theme).with_wrap_lines(false);
        let handler = handler.without_cause_chain();
        let report = Report::new(self);
        let mut rendered = String::new();
        if handler.render_report(&mut rendered, &report).is_err() {
            rendered = format!("{report}\n");
        }
        // Nobody is left to tell when standard error is closed.
        let _ = std::io::stderr().write_all(rendered.as_bytes());
    }
}

/// Warnings of a result, one line each.
pub fn warn(warnings: &[String]) {
    let lines: String = warnings.iter().map(|w| format!("warning: {w}\n")).collect();
    // As above.
    let _ = std::io::stderr().write_all(lines.as_bytes());
}

/// A failure in the form that the renderer takes.
#[derive(Debug)]
struct Report {
    message: String,
    source: Option<NamedSource<String>>,
    label: Option<LabeledSpan>,
    help: Option<String>,
}

impl Report {
    fn new(failure: Failure) -> Self {
        let error = match failure {
            Failure::File(error) => error,
            Failure::Message(message) => {
                return Self {
                    message,
                    source: None,
                    label: None,
                    help: None,
                };
            }
        };
        let text = error.source_text.to_string();
        let label = error.span.as_ref().map(|span| {
            let words = (!error.label.is_empty()).then(|| error.label.to_string());
            LabeledSpan::new(words, span.start, span.len())
        });
        Self {
            message: error.to_string(),
            source: label
                .is_some()
                .then(|| NamedSource::new(error.source_name.as_ref(), text)),
            label,
            help: error.help.map(String::from),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Report {}

impl Diagnostic for Report {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let help = self.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        let source = self.source.as_ref()?;
        Some(source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = self.label.clone()?;
        Some(Box::new(std::iter::once(label)))
    }
}
