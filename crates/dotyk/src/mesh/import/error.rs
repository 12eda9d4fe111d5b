//! Errors of a mesh file: each names the file, the place in it and the remedy.

use crate::mesh::MeshError;
use std::fmt;
use thiserror::Error;

/// A place in a mesh file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FilePlace {
    /// Line of a text, from 1.
    Line(usize),
    /// Byte of a binary file, from 0, and the section or array that it belongs to.
    Byte {
        /// Section of a `.msh` file or array of a VTU file.
        section: String,
        /// Bytes before it.
        offset: usize,
    },
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte { section, offset } => write!(f, "{section}, byte {offset}"),
        }
    }
}

/// Why a mesh file gives no mesh.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ImportError {
    /// The file is not there, or may not be read.
    #[error("{file}: cannot read the file: {why}")]
    Unreadable {
        /// The file.
        file: String,
        /// The error of the system.
        why: String,
    },
    /// A format, a version or a feature of a format that is not read.
    #[error("{file}: {what}")]
    Unsupported {
        /// The file.
        file: String,
        /// The feature, and advice.
        what: String,
    },
    /// The file breaks the rules of its format.
    #[error("{file}, {place}: {what}")]
    Malformed {
        /// The file.
        file: String,
        /// Where.
        place: FilePlace,
        /// The expected and the found content.
        what: String,
    },
    /// A group of cells that the file does not have.
    #[error("{file} has no group of cells `{group}`; {}", groups(known))]
    UnknownGroup {
        /// The file.
        file: String,
        /// Name that was asked for.
        group: String,
        /// Groups of cells that exist.
        known: Vec<String>,
    },
    /// A group of faces cannot be a body: it has no volume.
    #[error(
        "{file}: `{group}` is a group of faces, a shell; a body needs cells with volume: mesh in 3D and name a group of volumes; {}",
        groups(known)
    )]
    Shell {
        /// The file.
        file: String,
        /// Name that was asked for.
        group: String,
        /// Groups of cells that exist.
        known: Vec<String>,
    },
    /// A file read for one dimension is asked for a body of another.
    #[error("{file} was read for bodies of dimension {dimension}: read it again for the other")]
    Dimension {
        /// The file.
        file: String,
        /// Of the bodies that it was read for.
        dimension: u8,
    },
    /// Two groups that would have the same name.
    #[error(
        "{file}: the groups `{first}` and `{second}` would both be called `{name}` (letters, digits, `_` and `-` are kept): rename one of them"
    )]
    NameClash {
        /// The file.
        file: String,
        /// One group as the file calls it.
        first: String,
        /// The other.
        second: String,
        /// The name of both.
        name: String,
    },
    /// There are no cells for a body.
    #[error("{file} has no cells {cells}; {found}")]
    NoCells {
        /// The file.
        file: String,
        /// Which cells are needed.
        cells: &'static str,
        /// The cells that exist instead.
        found: String,
    },
    /// Cells of the body are of a kind that is not supported.
    #[error(
        "{file}: {count} cells of the body are of the kind {kind}, which is not supported yet; the first is element {element}: {}",
        instead(kind, known)
    )]
    UnsupportedCells {
        /// The file.
        file: String,
        /// Name of the kind.
        kind: String,
        /// How many.
        count: usize,
        /// Number of the first of them in the file.
        element: u64,
        /// Kinds that are supported.
        known: String,
    },
    /// A cell that belongs to two of the groups that the body is made of.
    #[error(
        "{file}: element {element} belongs to the groups `{first}` and `{second}`: choose groups that do not overlap"
    )]
    TwoGroups {
        /// The file.
        file: String,
        /// Number of the element in the file.
        element: u64,
        /// One group.
        first: String,
        /// The other.
        second: String,
    },
    /// Two cells on the same corners.
    #[error(
        "{file}: the elements {first} and {second} have the same corners and are not the same: remove one of them"
    )]
    Overlap {
        /// The file.
        file: String,
        /// Number of one element in the file.
        first: u64,
        /// Number of the other.
        second: u64,
    },
    /// Cells that meet at an edge, in space at a face, and do not fit together there.
    #[error(
        "{file}: the elements {} do not fit together at one {place}: two cells may share it, with {}",
        listed(elements),
        match *place {
            "edge" => "its middle node; mesh all of the body with one order",
            _ => "the same corners and middle nodes; mesh all of the body with one order, quadrilaterals against quadrilaterals",
        }
    )]
    NotConforming {
        /// The file.
        file: String,
        /// Where they meet: an edge or a face.
        place: &'static str,
        /// Numbers of the elements in the file.
        elements: Vec<u64>,
    },
    /// The body does not lie in a plane z = constant.
    #[error(
        "{file}: z runs from {low} to {high} in the body: a plane mesh has one z, and its coordinates are x and y{}",
        solids(*of_space)
    )]
    NotPlane {
        /// The file.
        file: String,
        /// Smallest z.
        low: f64,
        /// Largest z.
        high: f64,
        /// Cells of space in the file.
        of_space: usize,
    },
    /// The cells make no mesh; blocks, cells and nodes of `error` are those of the body, not of the file.
    #[error("{file}{}: {error}", number(*element))]
    Mesh {
        /// The file.
        file: String,
        /// Number in the file of the element that the error is about.
        element: Option<u64>,
        /// The fault.
        error: MeshError,
    },
}

fn groups(known: &[String]) -> String {
    match known.len() {
        0 => "it has none: leave `group` out to take all cells".to_string(),
        _ => format!("it has {}", known.join(", ")),
    }
}

/// What to do with a mesh of space that is read for bodies of the plane.
pub(crate) fn solids(count: usize) -> String {
    match count {
        0 => String::new(),
        _ => format!(
            "; it is a mesh of space, with {count} cells of space: bodies of them need `analysis = \"3d\"`"
        ),
    }
}

/// What to mesh with, instead of a kind that is not supported.
fn instead(kind: &str, known: &str) -> String {
    match kind.starts_with("pyramid") {
        true => "mesh the body without pyramids, or make two bodies, of its tetrahedra and of its hexahedra, tied by a [[contact]] with `tied = true`".to_string(),
        false => format!("mesh with order 1 or 2 ({known})"),
    }
}

fn listed(elements: &[u64]) -> String {
    let texts: Vec<String> = elements.iter().map(u64::to_string).collect();
    texts.join(", ")
}

fn number(element: Option<u64>) -> String {
    element.map_or(String::new(), |element| format!(", element {element}"))
}
