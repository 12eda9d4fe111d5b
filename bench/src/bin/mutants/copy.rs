//! All changes in one program: a copy of the workspace in which each place checks at run time whether its change is active.
//!
//! `a + b` becomes `(if crate::dotyk_mutant(7) { a - b } else { a + b })`. So the tests are built once, and not once for
//! each change. The copy reads the number of the change from an environment variable; the program itself does not.

use crate::places::{Bytes, Piece, Place};
use std::path::{Path, PathBuf};

/// Environment variable: the active change.
pub const CHANGE: &str = "DOTYK_MUTANT";
/// Environment variable: a file for the numbers of the reached places, one per line.
pub const REACHED: &str = "DOTYK_REACHED";

/// Code at the beginning and the end of the library of the copy.
const HEAD: &str = "#![allow(warnings, unconditional_panic, arithmetic_overflow)]\n";
const TAIL: &str = r#"
/// Is this change active?
pub fn dotyk_mutant(number: usize) -> bool {
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicBool, Ordering};
    static CHANGE: OnceLock<(Option<usize>, Option<String>)> = OnceLock::new();
    static REACHED: [AtomicBool; 4096] = [const { AtomicBool::new(false) }; 4096];
    let (change, log) = CHANGE.get_or_init(|| {
        let change = std::env::var("DOTYK_MUTANT").ok();
        (change.and_then(|number| number.parse().ok()), std::env::var("DOTYK_REACHED").ok())
    });
    if let Some(path) = log && !REACHED[number].swap(true, Ordering::Relaxed) {
        use std::io::Write;
        let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
        writeln!(file.unwrap(), "{number}").unwrap();
    }
    *change == Some(number)
}
"#;
/// The copy is built for one run of its tests; with overflow checks, a wrap-around is a failure of a test.
const PROFILE: &str = "\n[profile.release.package.dotyk]\nopt-level = 1\noverflow-checks = true\n";

/// A place of a file of the workspace.
#[derive(Debug, Clone)]
pub struct Mutant {
    /// Path from the root of the workspace.
    pub file: PathBuf,
    pub place: Place,
}

/// Writes the changes into a copy of the workspace; their numbers are indices of `mutants`, those in `dropped` are omitted.
pub fn write(
    root: &Path,
    to: &Path,
    mutants: &[Mutant],
    dropped: &[bool],
) -> Result<(), std::io::Error> {
    let mut files: Vec<&Path> = mutants.iter().map(|m| m.file.as_path()).collect();
    files.sort_unstable();
    files.dedup();
    for file in files {
        let text = std::fs::read_to_string(root.join(file))?;
        let own = mutants.iter().enumerate();
        let own = own.filter(|(k, m)| m.file == file && !dropped[*k]);
        let places: Vec<(usize, &Place)> = own.map(|(k, m)| (k, &m.place)).collect();
        write_if_new(&to.join(file), &changed(&text, places))?;
    }
    let library = Path::new("crates/dotyk/src/lib.rs");
    let text = std::fs::read_to_string(root.join(library))?;
    write_if_new(&to.join(library), &format!("{HEAD}{text}{TAIL}"))?;
    let manifest = std::fs::read_to_string(root.join("Cargo.toml"))?;
    write_if_new(&to.join("Cargo.toml"), &(manifest + PROFILE))
}

/// An unchanged file is not written, so that it is not built again.
fn write_if_new(path: &Path, text: &str) -> Result<(), std::io::Error> {
    match std::fs::read_to_string(path) {
        Ok(old) if old == text => Ok(()),
        _ => std::fs::write(path, text),
    }
}

/// Copies a folder without hidden files and build outputs.
pub fn copy_folder(from: &Path, to: &Path) -> Result<(), std::io::Error> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let (path, name) = entry.map(|entry| (entry.path(), entry.file_name()))?;
        let target = to.join(&name);
        let name = name.to_string_lossy();
        if name.starts_with('.') || name == "target" || name.ends_with("-out") {
            continue;
        }
        if path.is_dir() {
            copy_folder(&path, &target)?;
        } else {
            std::fs::copy(&path, &target)?;
        }
    }
    Ok(())
}

/// The text with all these changes in it, each under its number.
fn changed(text: &str, mut places: Vec<(usize, &Place)>) -> String {
    // outer changes first; an insertion before an expression counts as outside of it
    places.sort_by_key(|(_, place)| {
        let Bytes { start, end } = place.bytes;
        (start, start < end, std::cmp::Reverse(end))
    });
    written(text, 0..text.len(), &places)
}

/// A range of the text with those of the changes that lie in it.
fn written(text: &str, range: Bytes, places: &[(usize, &Place)]) -> String {
    let (mut out, mut at) = (String::new(), range.start);
    for (k, (number, place)) in places.iter().enumerate() {
        let Bytes { start, end } = place.bytes;
        let inside = end <= range.end && (start > range.start || (start == at && start < end));
        if start < at || !inside {
            continue;
        }
        let inner = &places[k + 1..];
        let piece = |piece: &Piece| match piece {
            Piece::Same(bytes) => written(text, bytes.clone(), inner),
            Piece::Words(words) => words.clone(),
        };
        let new: String = place.changed.iter().map(piece).collect();
        let is_it = format!("if crate::dotyk_mutant({number})");
        out += &text[at..start];
        out += &match (start < end, place.changed.is_empty()) {
            (false, _) => format!("{is_it} {{{new}}}"),
            (true, true) => {
                let old = written(text, start..end, inner);
                format!("{is_it} {{}} else {{{old}}}")
            }
            (true, false) => {
                let old = written(text, start..end, inner);
                format!("({is_it} {{{new}}} else {{{old}}})")
            }
        };
        at = end;
    }
    out + &text[at..range.end]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::places::places;

    #[test]
    fn changes_nest_and_each_has_its_number() {
        let text = "fn f(a: f64, b: f64) -> f64 {a + -b}";
        let found = places(text).unwrap();
        let whats: Vec<&str> = found.iter().map(|p| p.what.as_str()).collect();
        assert_eq!(whats.len(), 4);
        let numbered: Vec<(usize, &Place)> = found.iter().enumerate().skip(1).collect();
        let m = |k| format!("if crate::dotyk_mutant({k})");
        let minus = format!("({} {{b}} else {{-b}})", m(3));
        let sum = format!("({} {{a - {minus}}} else {{a + {minus}}})", m(2));
        let early = format!("{} {{return 1.0;}}", m(1));
        let expected = format!("fn f(a: f64, b: f64) -> f64 {{{early}{sum}}}");
        assert_eq!(changed(text, numbered), expected);
    }

    #[test]
    fn two_changes_of_one_place_are_told_apart() {
        let text = "fn f() { g(a < b); return; }";
        let found = places(text).unwrap();
        let numbered: Vec<(usize, &Place)> = found.iter().enumerate().skip(1).collect();
        let m = |k| format!("if crate::dotyk_mutant({k})");
        let second = format!("({} {{a > b}} else {{a < b}})", m(2));
        let first = format!("({} {{a <= b}} else {{{second}}})", m(1));
        let dropped = format!("{} {{}} else {{return;}}", m(3));
        let expected = format!("fn f() {{ g({first}); {dropped} }}");
        assert_eq!(changed(text, numbered), expected);
    }
}
