//! Result lines: aligned columns and short numbers.

use crate::failure::Failure;
use comfy_table::{Cell, CellAlignment, Table};
use std::borrow::Cow;
use std::io::{ErrorKind, IsTerminal, Write};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Writes a text to standard output without control characters for the terminal.
///
/// Errors: as [`put`].
pub fn print(text: &str) -> Result<(), Failure> {
    put(&shown(text, colours(&std::io::stdout())))
}

/// Writes the program's own words to standard output unchanged. A reader that closes the pipe early ends the output without an error.
///
/// Errors: any other failure to write, such as a full disk.
pub fn put(text: &str) -> Result<(), Failure> {
    if is_silent() {
        return Ok(());
    }
    let mut out = std::io::stdout().lock();
    let written = out.write_all(text.as_bytes());
    match written.and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Message(format!(
            "the results cannot be printed, standard output takes no more: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Whether another process prints what this one would print, too.
pub fn is_silent() -> bool {
    dotyk::host::team().rank() > 0
}

/// What silent processes would have written to standard error.
static UNSAID: Mutex<String> = Mutex::new(String::new());

/// Writes to standard error.
pub fn tell(text: &str) {
    if is_silent() {
        unsaid().push_str(text);
        return;
    }
    // an error is ignored: standard error is closed
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// What this process did not say, because the first one was to say it.
pub fn unsaid() -> MutexGuard<'static, String> {
    UNSAID.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The control sequences that begin and end coloured words.
const COLOURS: [&str; 2] = ["\u{1b}[31m", "\u{1b}[0m"];

/// Text whose control characters are escaped as in JSON, because titles and names of files are not trusted. Only the control
/// sequences of `COLOURS` stay, if `coloured`.
pub fn shown(text: &str, coloured: bool) -> Cow<'_, str> {
    if !text.chars().any(commands) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let own = COLOURS
            .iter()
            .find(|own| coloured && rest.starts_with(**own));
        let length = own.map_or(c.len_utf8(), |own| own.len());
        match own.is_none() && commands(c) {
            true => out += &format!("\\u{:04x}", u32::from(c)),
            false => out += &rest[..length],
        }
        rest = &rest[length..];
    }
    Cow::Owned(out)
}

/// Control characters of a terminal, and characters that change the direction of text.
pub fn commands(c: char) -> bool {
    let turns =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || c.is_control() && c != '\n' && c != '\t'
}

/// Whether a stream shows colours: on a terminal, unless the user wants none (<https://no-color.org>).
pub fn colours(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// Words in red, where colours are shown.
pub fn red(words: &str, shown: bool) -> String {
    match shown {
        true => [COLOURS[0], words, COLOURS[1]].concat(),
        false => words.to_string(),
    }
}

/// A vector, such as (1, 2).
pub fn vector(values: &[f64]) -> String {
    let list: Vec<String> = values.iter().map(|v| number(*v)).collect();
    format!("({})", list.join(", "))
}

/// Six significant digits without trailing zeros; `-` for NaN.
pub fn number(value: f64) -> String {
    if value.is_nan() {
        return "-".to_string();
    }
    if value == 0.0 || value.is_infinite() {
        return format!("{}", value + 0.0);
    }
    let scientific = format!("{value:.5e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    match exponent.parse::<i32>() {
        Ok(exponent @ -4..=5) => {
            let decimals = usize::try_from(5 - exponent).unwrap_or(0);
            trimmed(&format!("{value:.decimals$}")).to_string()
        }
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

/// A number without the zeros after its last decimal.
fn trimmed(number: &str) -> &str {
    if !number.contains('.') {
        return number;
    }
    number.trim_end_matches('0').trim_end_matches('.')
}

/// Columns two blanks apart; those in `right` are flush right. Ends with a newline. On a terminal that is too narrow, long
/// cells continue on the next line.
pub fn columns(header: &[&str], rows: &[Vec<String>], right: Range<usize>) -> String {
    let size = console::Term::stdout().size_checked();
    columns_within(size.map(|(_, width)| width), header, rows, right)
}

fn columns_within(
    width: Option<u16>,
    header: &[&str],
    rows: &[Vec<String>],
    right: Range<usize>,
) -> String {
    let mut table = Table::new();
    table.load_style(comfy_table::presets::NOTHING);
    match width {
        Some(width) => table
            .set_content_arrangement(comfy_table::ContentArrangement::Dynamic)
            .set_width(width),
        None => table.set_content_arrangement(comfy_table::ContentArrangement::Disabled),
    };
    let aligned = |i: usize, text: &str| {
        let alignment = if right.contains(&i) {
            CellAlignment::Right
        } else {
            CellAlignment::Left
        };
        Cell::new(text).set_alignment(alignment)
    };
    table.set_header(header.iter().enumerate().map(|(i, text)| aligned(i, text)));
    for row in rows {
        table.add_row(row.iter().enumerate().map(|(i, text)| aligned(i, text)));
    }
    for column in table.column_iter_mut() {
        column.set_padding((0, 2));
    }
    table
        .lines()
        .map(|line| format!("{}\n", line.trim_end()))
        .collect()
}

/// Most files of one kind that are named.
const NAMED: usize = 8;

/// "wrote FOLDER: a, b, c"; for many files of one kind the first, and the number of the others.
pub fn named(files: &[PathBuf]) -> String {
    let Some(folder) = files.first().and_then(|file| file.parent()) else {
        return String::new();
    };
    let kinds = files.chunk_by(|a, b| a.extension() == b.extension());
    let mut names: Vec<String> = Vec::new();
    for kind in kinds {
        let shown = if kind.len() > NAMED { 1 } else { kind.len() };
        let own = kind[..shown].iter().filter_map(|file| file.file_name());
        names.extend(own.map(|name| name.to_string_lossy().into_owned()));
        if let (Some(last), more @ 1..) = (names.last_mut(), kind.len() - shown) {
            *last += &format!(" and {more} more");
        }
    }
    format!("wrote {}: {}\n", folder.display(), names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_keeps_within_the_width_of_the_terminal() {
        let long = "rotation about (0, 0), translation along x, translation along y";
        let rows = [[
            "block".to_string(),
            "0.000614386".to_string(),
            long.to_string(),
        ]
        .to_vec()];
        let table = |width| columns_within(width, &["body", "moves", "floats"], &rows, 1..2);
        assert_eq!(table(None).lines().count(), 2);
        let narrow = table(Some(60));
        assert!(
            narrow.lines().all(|line| line.chars().count() <= 60),
            "{narrow}"
        );
        assert!(
            narrow.contains("0.000614386") && narrow.lines().count() > 2,
            "{narrow}"
        );
        let words = |text: &str| {
            text.split_whitespace()
                .map(str::to_string)
                .collect::<std::collections::BTreeSet<_>>()
        };
        assert_eq!(words(&narrow), words(&table(None)));
        assert_eq!(table(Some(200)), table(None));
    }

    #[test]
    fn a_terminal_obeys_no_text() {
        for (text, expected) in [
            ("plain\tand\nmore, µ", "plain\tand\nmore, µ"),
            (
                "\u{1b}[2J\u{1b}]0;x\u{7}\r",
                "\\u001b[2J\\u001b]0;x\\u0007\\u000d",
            ),
            ("\u{9b}2J\u{202e}", "\\u009b2J\\u202e"),
            // a sequence that would hide the words after it
            ("\u{1b}[8mhidden\u{1b}[3", "\\u001b[8mhidden\\u001b[3"),
        ] {
            assert_eq!(shown(text, false), expected);
            assert_eq!(shown(text, true), expected);
        }
        let coloured = red("NO", true);
        assert_eq!(shown(&coloured, true), coloured);
        assert_eq!(shown(&coloured, false), "\\u001b[31mNO\\u001b[0m");
    }

    #[test]
    fn many_files_of_a_kind_are_counted() {
        let files = |n: usize| -> Vec<PathBuf> {
            let bodies = (0..n).map(|k| PathBuf::from(format!("out/b{k}.vtu")));
            bodies.chain([PathBuf::from("out/contact.csv")]).collect()
        };
        assert_eq!(named(&files(2)), "wrote out: b0.vtu, b1.vtu, contact.csv\n");
        assert_eq!(
            named(&files(40)),
            "wrote out: b0.vtu and 39 more, contact.csv\n"
        );
        assert_eq!(named(&[]), "");
    }

    #[test]
    fn numbers_have_six_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-1234567.0, "-1.23457e6"),
            (123456.4, "123456"),
            (0.1 + 0.2, "0.3"),
            (1e-8, "1e-8"),
            (-0.00012345678, "-0.000123457"),
            (9.999999, "10"),
            (999999.6, "1e6"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(number(value), expected);
        }
    }

    #[test]
    fn columns_are_aligned() {
        let rows = [
            vec!["a".into(), "1.5".into()],
            vec!["long".into(), "10".into()],
        ];
        let text = columns(&["name", "value"], &rows, 1..2);
        assert_eq!(text, "name  value\na       1.5\nlong     10\n");
    }
}
