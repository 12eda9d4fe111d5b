//! The text of a deck as cards: a line with a keyword and its parameters, and the lines of data below it.
//!
//! ```text
//! ** a comment
//! *KEYWORD, PARAMETER=VALUE, PARAMETER,
//! ANOTHER=VALUE                  (a line that ends with a comma goes on)
//! data, data, data
//! *INCLUDE, INPUT=other.inp      (stands for the lines of that file)
//! ```
//!
//! Words are compared in capitals and without blanks, as CalculiX does; values keep their spelling. Empty lines are passed over.

use crate::error::{DeckError, Fault};
use crate::keywords::{entry, parameter};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Deepest chain of files that include each other.
const DEEPEST: usize = 16;

/// A line of a file, by the index of the file and the number of the line, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Place {
    /// Index into [`Sources::files`].
    pub file: u32,
    /// Number of the line, from 1.
    pub line: u32,
}

/// A file of a deck.
#[derive(Debug, Clone)]
pub struct Source {
    /// As messages call it.
    pub name: Arc<str>,
    /// Its content.
    pub text: Arc<str>,
}

/// The files of a deck, the deck itself first.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    /// Every file once for each time it is included.
    pub files: Vec<Source>,
}

/// A line of data.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub place: Place,
    /// Between commas, without blanks around; what follows the last comma is left out where it is empty.
    pub fields: Vec<String>,
}

/// A keyword with what belongs to it.
#[derive(Debug, Clone)]
pub(crate) struct Card {
    pub place: Place,
    /// In capitals, one blank between words: `CONTACT PAIR`.
    pub keyword: String,
    /// Names in capitals, values as written.
    pub parameters: Vec<(String, String)>,
    pub rows: Vec<Row>,
}

impl Card {
    /// The value of a parameter; empty where it has none.
    pub fn get(&self, name: &str) -> Option<&str> {
        let mut known = self.parameters.iter().filter(|(known, _)| known == name);
        known.next().map(|(_, value)| value.as_str())
    }

    /// The same in capitals without blanks.
    pub fn word(&self, name: &str) -> Option<String> {
        self.get(name).map(folded)
    }

    /// An error at the line of the keyword.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        self.fault_at(self.place, message)
    }

    /// An error at a line of the card.
    pub fn fault_at(&self, place: Place, message: impl Into<String>) -> Fault {
        Fault::new(place, &self.keyword, message)
    }
}

impl Row {
    /// A field; empty where the line ends before it.
    pub fn field(&self, index: usize) -> &str {
        self.fields.get(index).map_or("", String::as_str)
    }

    /// A number; `default` where the field is empty.
    pub fn number_or(&self, card: &Card, index: usize, default: f64) -> Result<f64, Fault> {
        match self.field(index) {
            "" => Ok(default),
            text => number(text).ok_or_else(|| {
                card.fault_at(
                    self.place,
                    format!("expected a number in field {}, found `{text}`", index + 1),
                )
            }),
        }
    }

    /// A number that must be there; `what` is its name in messages.
    pub fn number(&self, card: &Card, index: usize, what: &str) -> Result<f64, Fault> {
        if self.field(index).is_empty() {
            let message = format!("{what} is missing in field {}", index + 1);
            return Err(card.fault_at(self.place, message));
        }
        self.number_or(card, index, 0.0)
    }

    /// A degree of freedom.
    pub fn freedom(&self, card: &Card, index: usize) -> Result<u8, Fault> {
        let text = self.field(index);
        let known = text.parse::<u8>().ok().filter(|k| (1..=6).contains(k));
        known.ok_or_else(|| {
            let field = index + 1;
            let message = format!(
                "expected a degree of freedom from 1 to 6 in field {field}, found `{text}`"
            );
            card.fault_at(self.place, message)
        })
    }

    /// A number of a node or element.
    pub fn id(&self, card: &Card, index: usize, what: &str) -> Result<u64, Fault> {
        let text = self.field(index);
        let id = text.parse::<u64>().ok().filter(|id| *id > 0);
        id.ok_or_else(|| {
            let message = format!("expected {what} in field {}, found `{text}`", index + 1);
            card.fault_at(self.place, message)
        })
    }
}

/// A word in capitals without blanks: how names are compared.
pub(crate) fn folded(text: &str) -> String {
    let kept = text.chars().filter(|c| !c.is_whitespace() && *c != '"');
    kept.flat_map(char::to_uppercase).collect()
}

/// A number as Fortran writes it, too: `1.D-3`.
pub(crate) fn number(text: &str) -> Option<f64> {
    let value = match text.parse::<f64>() {
        Ok(value) => value,
        Err(_) => text.replace(['d', 'D'], "e").parse().ok()?,
    };
    value.is_finite().then_some(value)
}

/// The cards of a deck and of the files that it includes.
///
/// Errors: a file that cannot be read or includes itself; data before the first keyword.
pub(crate) fn cards(path: &Path) -> Result<(Sources, Vec<Card>), DeckError> {
    let mut reader = Reader::default();
    let name = path.display().to_string();
    let read = text_of(path);
    let text = read.map_err(|why| DeckError::Unreadable {
        name,
        why: format!("cannot read the file: {why}"),
    })?;
    let done = reader.file(path, text, &mut Vec::new());
    match done {
        Ok(()) => Ok((reader.sources, reader.cards)),
        Err(fault) => Err(fault.in_sources(&reader.sources)),
    }
}

#[derive(Default)]
struct Reader {
    sources: Sources,
    cards: Vec<Card>,
}

impl Reader {
    fn file(&mut self, path: &Path, text: String, above: &mut Vec<PathBuf>) -> Result<(), Fault> {
        let file = self.sources.files.len() as u32;
        let text: Arc<str> = text.into();
        self.sources.files.push(Source {
            name: path.display().to_string().into(),
            text: Arc::clone(&text),
        });
        above.push(path.to_path_buf());
        let mut going_on: Option<(Place, String)> = None;
        for (index, line) in text.lines().enumerate() {
            let place = Place {
                file,
                line: index as u32 + 1,
            };
            let line = line.trim();
            if line.is_empty() || line.starts_with("**") {
                continue;
            }
            if let Some((start, mut first)) = going_on.take() {
                first.push_str(line);
                match line.ends_with(',') && goes_on(&text, index, &first) {
                    true => going_on = Some((start, first)),
                    false => self.keyword(start, &first, above)?,
                }
            } else if line.starts_with('*') {
                match line.ends_with(',') && goes_on(&text, index, line) {
                    true => going_on = Some((place, line.to_string())),
                    false => self.keyword(place, line, above)?,
                }
            } else {
                self.data(place, line)?;
            }
        }
        if let Some((start, first)) = going_on {
            self.keyword(start, &first, above)?;
        }
        above.pop();
        Ok(())
    }

    fn keyword(&mut self, place: Place, line: &str, above: &mut Vec<PathBuf>) -> Result<(), Fault> {
        let mut words = line[1..].split(',').map(str::trim);
        let written = words.next().unwrap_or_default().split_whitespace();
        let written = written.collect::<Vec<_>>().join(" ").to_uppercase();
        let entry = entry(&written);
        let parameters = words.filter(|word| !word.is_empty()).map(|word| {
            let (name, value) = word.split_once('=').unwrap_or((word, ""));
            let name = name
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ")
                .to_uppercase();
            let known = entry.and_then(|entry| parameter(entry, &name));
            let name = known.map_or(name, str::to_string);
            (name, value.trim().trim_matches('"').to_string())
        });
        let card = Card {
            place,
            parameters: parameters.collect(),
            keyword: entry.map_or(written, |entry| entry.0.to_string()),
            rows: Vec::new(),
        };
        if card.keyword == "INCLUDE" {
            return self.include(&card, above);
        }
        self.cards.push(card);
        Ok(())
    }

    fn include(&mut self, card: &Card, above: &mut Vec<PathBuf>) -> Result<(), Fault> {
        let Some(name) = card.get("INPUT").filter(|name| !name.is_empty()) else {
            return Err(card.fault("INPUT=FILE is missing"));
        };
        let folder = above.last().and_then(|path| path.parent());
        let path = folder.unwrap_or(Path::new("")).join(name);
        if above.contains(&path) || above.len() >= DEEPEST {
            return Err(card.fault(format!("{} includes itself", path.display())));
        }
        let text = text_of(&path);
        let text = text.map_err(|why| card.fault(format!("{}: {why}", path.display())))?;
        self.file(&path, text, above)
    }

    fn data(&mut self, place: Place, line: &str) -> Result<(), Fault> {
        let mut fields: Vec<String> = line.split(',').map(|f| f.trim().to_string()).collect();
        while fields.len() > 1 && fields.last().is_some_and(String::is_empty) {
            fields.pop();
        }
        let row = Row { place, fields };
        match self.cards.last_mut() {
            Some(card) => {
                card.rows.push(row);
                Ok(())
            }
            None => Err(Fault::new(
                place,
                "",
                "data before the first keyword: a deck begins with a line such as *NODE",
            )),
        }
    }
}

/// Whether a line that ends with a comma goes on below: the next line that counts has `=` or nothing but parameters of the keyword. A line
/// of data begins with a number or the name of a set, which may be called like a parameter.
fn goes_on(text: &str, index: usize, keyword: &str) -> bool {
    let below = text.lines().skip(index + 1).map(str::trim);
    let mut below = below.filter(|line| !line.is_empty() && !line.starts_with("**"));
    let next = below.next().unwrap_or_default();
    let word = keyword
        .trim_start_matches('*')
        .split(',')
        .next()
        .unwrap_or_default();
    let mut own = next.split(',').map(str::trim).filter(|own| !own.is_empty());
    let known = |entry| own.all(|own| parameter(entry, own).is_some());
    !next.is_empty()
        && !next.starts_with('*')
        && (next.contains('=') || entry(word).is_some_and(known))
}

/// The text of a file; what is not UTF-8 is taken byte by byte, and a mark of byte order is passed over.
fn text_of(path: &Path) -> Result<String, String> {
    let bytes = dotyk::host::read(path)?;
    if bytes.contains(&0) {
        return Err("this is not a text".to_string());
    }
    // comments of other languages may be in a code of one byte
    let text = String::from_utf8(bytes);
    let text = text.unwrap_or_else(|e| e.into_bytes().into_iter().map(char::from).collect());
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_string(),
        None => text,
    })
}
