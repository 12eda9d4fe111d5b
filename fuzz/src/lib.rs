//! Spoilt files: a seed from the repository, and edits of it.
//!
//! Random bytes never get past the first line of a reader. A file that was right before a few edits gets far.

use bolero::TypeGenerator;
use std::path::{Path, PathBuf};

/// One edit.
#[derive(Debug, Clone, TypeGenerator)]
pub enum Edit {
    /// One byte becomes another.
    Byte { at: u32, to: u8 },
    /// A piece is cut out.
    Cut { at: u32, length: u8 },
    /// A piece is said twice.
    Double { at: u32, length: u8 },
    /// The file ends early.
    End { at: u32 },
    /// A number becomes another one.
    Number { at: u32, to: u8 },
    /// A piece of another file.
    Graft {
        at: u32,
        from: u8,
        start: u32,
        length: u8,
    },
}

/// What numbers become.
const NUMBERS: [&str; 16] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "nan",
    "inf",
    "1e-320",
    "4294967296",
    "-9223372036854775808",
    "0.5",
    "2",
    "1e17",
    "",
    "x",
    "\"t\"",
    "[]",
];

/// Files of the repository with an ending, in the order of their names.
pub fn seeds(folder: &str, ending: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .join(folder);
    let mut found = Vec::new();
    collect(&root, ending, &mut found);
    found.sort();
    assert!(!found.is_empty(), "no .{ending} in {folder}");
    found
}

fn collect(folder: &Path, ending: &str, found: &mut Vec<(PathBuf, Vec<u8>)>) {
    for entry in std::fs::read_dir(folder)
        .expect("a folder of the repository")
        .flatten()
    {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, ending, found);
        } else if path.extension().is_some_and(|e| e == ending) {
            let bytes = std::fs::read(&path).expect("a file of the repository");
            found.push((path, bytes));
        }
    }
}

/// Most edits of one file: after more of them no reader gets beyond the first.
const EDITS: usize = 3;

/// The seed after some edits.
pub fn spoilt(seeds: &[(PathBuf, Vec<u8>)], seed: usize, edits: &[Edit]) -> Vec<u8> {
    let mut bytes = seeds[seed].1.clone();
    let few = match edits {
        [] => edits,
        _ => &edits[..edits.len().min(1 + edits.len() % EDITS)],
    };
    for edit in few {
        if bytes.is_empty() {
            break;
        }
        let place = |at: u32, bytes: &[u8]| at as usize % bytes.len();
        match *edit {
            Edit::Byte { at, to } => {
                let at = place(at, &bytes);
                bytes[at] = to;
            }
            Edit::Cut { at, length } => {
                let at = place(at, &bytes);
                let end = (at + usize::from(length)).min(bytes.len());
                bytes.drain(at..end);
            }
            Edit::Double { at, length } => {
                let at = place(at, &bytes);
                let end = (at + usize::from(length)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            Edit::End { at } => {
                let at = place(at, &bytes);
                bytes.truncate(at);
            }
            Edit::Number { at, to } => {
                let at = place(at, &bytes);
                let digit = |b: &u8| b.is_ascii_digit() || b".-+eE".contains(b);
                let first = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit());
                if let Some(first) = first {
                    let rest = bytes[first..].iter().take_while(|b| digit(b)).count();
                    let number = NUMBERS[usize::from(to) % NUMBERS.len()];
                    bytes.splice(first..first + rest, number.bytes());
                }
            }
            Edit::Graft {
                at,
                from,
                start,
                length,
            } => {
                let at = place(at, &bytes);
                let other = &seeds[usize::from(from) % seeds.len()].1;
                let start = place(start, other);
                let end = (start + usize::from(length)).min(other.len());
                let piece = other[start..end].to_vec();
                bytes.splice(at..at, piece);
            }
        }
    }
    bytes
}
