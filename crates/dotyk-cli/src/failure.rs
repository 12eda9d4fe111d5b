//! Bad input: one clear message on standard error, underlined in its file where it has a place.

use crate::text::{colours, red, shown, tell};
use dotyk::case::CaseError;
use dotyk::output;
use std::fmt;

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

    /// Files that could not be written into the folder of `--out`.
    pub fn of_output(error: output::Error) -> Self {
        Self::of_files(&error, "--out")
    }

    /// Files that could not be written into the folder of an option; the library does not know the options.
    pub fn of_files(error: &output::Error, option: &str) -> Self {
        let named = format!("another folder with {option}");
        Self::Message(error.to_string().replace("another folder", &named))
    }

    /// Prints the message: with colours on a terminal, plain elsewhere.
    pub fn print(self) {
        let coloured = colours(&std::io::stderr());
        let rendered = self.rendered(coloured);
        tell(&shown(&rendered, coloured));
    }

    fn rendered(&self, colours: bool) -> String {
        let mark = red("x", colours);
        let error = match self {
            Self::Message(message) => return format!("  {mark} {message}\n"),
            Self::File(error) => error,
        };
        let mut text = format!("  {mark} {error}\n") + &underlined(error, colours);
        if let Some(help) = &error.help {
            text += &format!("  help: {}\n", help.replace('\n', "\n        "));
        }
        text
    }
}

/// Most bytes of a line that is shown.
const LONGEST: usize = 2000;

/// The line of a mistake between its neighbours, underlined; an empty text for a mistake without a place.
fn underlined(error: &CaseError, colours: bool) -> String {
    let (Some(line), Some(column), Some(span)) = (error.line(), error.column(), &error.span) else {
        return String::new();
    };
    let width = (line + 1).to_string().len();
    let margin = " ".repeat(width + 2);
    let length = error.source_text.get(span.clone()).unwrap_or_default();
    let length = length.chars().count().max(1);
    let mut text = format!("{margin},-[{}:{line}:{column}]\n", error.source_name);
    let lines = (1..).zip(error.source_text.lines());
    for (number, words) in lines
        .skip_while(|(n, _)| n + 1 < line)
        .take_while(|(n, _)| *n <= line + 1)
    {
        if words.len() > LONGEST {
            // the heading already names the place
            continue;
        }
        // a tab takes one column here, as it does in the number of the column
        let shown = format!(" {number:>width$} | {}", words.replace('\t', " "));
        text += &format!("{}\n", shown.trim_end());
        if number == line {
            let (before, middle) = (" ".repeat(column - 1), length / 2);
            let stem = if error.label.is_empty() { "^" } else { "|" };
            let marks = "^".repeat(middle) + stem + &"^".repeat(length - middle - 1);
            text += &format!("{margin}: {before}{}\n", red(&marks, colours));
            if !error.label.is_empty() {
                let label = format!("`-- {}", error.label);
                let before = before + &" ".repeat(middle);
                text += &format!("{margin}: {before}{}\n", red(&label, colours));
            }
        }
    }
    text + &format!("{margin}`----\n")
}

/// Warnings of a result, one line each.
pub fn warn(warnings: &[String]) {
    let lines: String = warnings.iter().map(|w| format!("warning: {w}\n")).collect();
    tell(&shown(&lines, false));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistake_is_underlined_between_its_neighbours() {
        let text = "[[contact]]\nsides = [\"punch.botom\", \"block.top\"]\n\n[solver]\n";
        let start = text.find("\"punch").unwrap();
        let error = CaseError {
            message: "body `punch` has no side `botom`".to_string(),
            label: "the nearest known side is `bottom`".into(),
            help: Some("its sides: `bottom`, `top`".into()),
            span: Some(start..start + 13),
            source_name: "punch.toml".into(),
            source_text: text.into(),
        };
        let expected = r#"  x punch.toml, line 2, column 10: body `punch` has no side `botom`
   ,-[punch.toml:2:10]
 1 | [[contact]]
 2 | sides = ["punch.botom", "block.top"]
   :          ^^^^^^|^^^^^^
   :                `-- the nearest known side is `bottom`
 3 |
   `----
  help: its sides: `bottom`, `top`
"#;
        assert_eq!(Failure::from(error).rendered(false), expected);
        let plain = Failure::Message("no such folder".to_string());
        assert_eq!(plain.rendered(false), "  x no such folder\n");
    }
}
