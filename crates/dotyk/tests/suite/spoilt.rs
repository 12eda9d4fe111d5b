//! Spoilt files: each is an error with words, or what it says, and soon.
//!
//! Random bytes never get past the first line of a reader. A file that was right before a few edits gets far. The environment
//! variable PROPTEST_CASES says how many files of each kind are tried.

use dotyk::case::{AnyCase, References};
use dotyk::mesh::MeshFile;
use dotyk::model::Model;
use proptest::prelude::*;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Models with at most this many nodes are checked as well.
const SMALL: usize = 600;

/// The longest that a file may take.
const LONGEST: Duration = Duration::from_secs(10);

/// One edit: places count round the length of the file.
#[derive(Debug, Clone)]
enum Edit {
    /// One byte becomes another.
    Byte(usize, u8),
    /// A piece is cut out.
    Cut(usize, usize),
    /// A piece is said twice.
    Double(usize, usize),
    /// The file ends early.
    End(usize),
    /// The next number becomes another one.
    Number(usize, usize),
    /// A piece of another file comes in: where, which file, from where, how much.
    Graft(usize, usize, usize, usize),
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

fn edit() -> impl Strategy<Value = Edit> {
    let (at, length) = (any::<usize>(), 0..256usize);
    prop_oneof![
        (at, any::<u8>()).prop_map(|(at, to)| Edit::Byte(at, to)),
        (at, length.clone()).prop_map(|(at, length)| Edit::Cut(at, length)),
        (at, length.clone()).prop_map(|(at, length)| Edit::Double(at, length)),
        at.prop_map(Edit::End),
        (at, 0..NUMBERS.len()).prop_map(|(at, to)| Edit::Number(at, to)),
        (at, at, at, length).prop_map(|(at, from, start, n)| Edit::Graft(at, from, start, n)),
    ]
}

/// A file and its edits: after more of them no reader gets beyond the first.
fn spoiling() -> impl Strategy<Value = (usize, Vec<Edit>)> {
    (any::<usize>(), prop::collection::vec(edit(), 0..4))
}

/// Files of the repository.
struct Seeds(Vec<(PathBuf, Vec<u8>)>);

impl Seeds {
    /// Those in a folder whose names end so, in the order of their names.
    fn new(folder: &str, ending: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut found = Vec::new();
        collect(&root.join(folder), ending, &mut found);
        found.sort();
        assert!(!found.is_empty(), "no {ending} in {folder}");
        Self(found)
    }

    /// One of them after its edits, and where it lies.
    fn spoilt(&self, seed: usize, edits: &[Edit]) -> (Vec<u8>, &Path) {
        let (path, bytes) = &self.0[seed % self.0.len()];
        let mut bytes = bytes.clone();
        for edit in edits {
            if !bytes.is_empty() {
                self.apply(edit, &mut bytes);
            }
        }
        (bytes, path)
    }

    fn apply(&self, edit: &Edit, bytes: &mut Vec<u8>) {
        let all = bytes.len();
        let piece = |at: usize, length: usize| at % all..(at % all + length).min(all);
        match *edit {
            Edit::Byte(at, to) => bytes[at % all] = to,
            Edit::Cut(at, length) => drop(bytes.drain(piece(at, length))),
            Edit::Double(at, length) => {
                let said = bytes[piece(at, length)].to_vec();
                bytes.splice(at % all..at % all, said);
            }
            Edit::End(at) => bytes.truncate(at % all),
            Edit::Number(at, to) => {
                let Some(first) = (at % all..all).find(|&i| bytes[i].is_ascii_digit()) else {
                    return;
                };
                let of_number = |b: &u8| b.is_ascii_digit() || b".-+eE".contains(b);
                let length = bytes[first..].iter().position(|b| !of_number(b));
                let end = length.map_or(all, |length| first + length);
                bytes.splice(first..end, NUMBERS[to].bytes());
            }
            Edit::Graft(at, from, start, length) => {
                let other = &self.0[from % self.0.len()].1;
                let start = start % other.len();
                let piece = &other[start..(start + length).min(other.len())];
                bytes.splice(at % all..at % all, piece.iter().copied());
            }
        }
    }

    /// Reads spoilt ones, as many as proptest is told to.
    fn all_are_read(&self, read: impl Fn(&[u8], &Path)) {
        let config = ProptestConfig {
            failure_persistence: None,
            ..ProptestConfig::default()
        };
        proptest!(config, |((seed, edits) in spoiling())| {
            let (bytes, path) = self.spoilt(seed, &edits);
            let start = Instant::now();
            read(&bytes, path);
            let passed = start.elapsed();
            prop_assert!(passed < LONGEST, "{:?} for {}", passed, String::from_utf8_lossy(&bytes));
        });
    }
}

fn collect(folder: &Path, ending: &str, found: &mut Vec<(PathBuf, Vec<u8>)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, ending, found);
        } else if path.to_string_lossy().ends_with(ending) {
            let bytes = std::fs::read(&path).unwrap();
            found.push((path, bytes));
        }
    }
}

/// An error must have words.
fn answer<T, E: Display>(read: Result<T, E>) -> Option<T> {
    read.map_err(|error| assert!(!error.to_string().is_empty()))
        .ok()
}

fn is_small<const D: usize>(model: &Model<D>) -> bool {
    let nodes = model.bodies.iter().map(|body| body.mesh.points().len());
    nodes.sum::<usize>() <= SMALL
}

#[test]
fn spoilt_cases_are_errors_or_models() {
    Seeds::new("cases", ".toml").all_are_read(|bytes, path| {
        let text = String::from_utf8_lossy(bytes);
        match answer(AnyCase::from_str(
            &text,
            "spoilt.toml",
            path.parent().unwrap(),
        )) {
            Some(AnyCase::Plane(case)) if is_small(&case.model) => {
                // loads, supports and contacts are looked at, not only read
                case.model.check();
            }
            Some(AnyCase::Space(case)) if is_small(&case.model) => {
                case.model.check();
            }
            _ => (),
        }
    });
}

#[test]
fn spoilt_references_are_errors_or_references() {
    Seeds::new("cases", "reference.toml").all_are_read(|bytes, _| {
        let text = String::from_utf8_lossy(bytes);
        answer(References::from_str(&text, "spoilt.toml"));
    });
}

#[test]
fn spoilt_meshes_are_errors_or_meshes() {
    for ending in [".msh", ".vtu"] {
        Seeds::new("crates/dotyk/tests/data", ending).all_are_read(|bytes, _| {
            answer(MeshFile::from_bytes("spoilt", bytes));
            answer(MeshFile::solid_from_bytes("spoilt", bytes));
        });
    }
}

#[test]
fn surfaces_of_triangles_are_no_meshes() {
    let text = b"solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  endloop\n endfacet\nendsolid a\n";
    let mut binary = vec![0; 80];
    binary.extend([1, 0, 0, 0]);
    binary.extend([0; 50]);
    let surfaces = Seeds(vec![
        ("a.stl".into(), text.to_vec()),
        ("b.stl".into(), binary),
    ]);
    surfaces.all_are_read(|bytes, _| {
        assert!(answer(MeshFile::from_bytes("spoilt", bytes)).is_none());
    });
}
