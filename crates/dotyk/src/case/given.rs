//! Parts of a case that no text can express: existing meshes, and functions of a program.
//!
//! A text names them by a [mark](HANDLE) and their number: `file = "\u{E000}0"` is the first mesh,
//! `traction = ["\u{E000}1.0", "\u{E000}1.1"]` both components of the second function. Without such parts the mark has no meaning.

use crate::case::document::{self, Node, Value};
use crate::case::error::{CaseError, Fault};
use crate::case::mesh::{Generated, mesh};
use crate::case::mesh_file::{MeshFiles, Named};
use crate::case::source::Source;
use crate::case::{keys, outline};
use crate::geometry::Field;
use crate::mesh::Mesh;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// First character of a handle, which no key, name or expression contains.
pub const HANDLE: char = '\u{E000}';

/// A mesh of the plane or of space, with the points that a mesh file named.
#[derive(Debug, Clone)]
pub enum GivenMesh {
    /// Of the plane.
    Plane(Arc<Mesh<2>>, Named<2>),
    /// Of space.
    Space(Arc<Mesh<3>>, Named<3>),
}

/// Parts that a text may name by handles, and files that it may name by their paths although no folder has them.
#[derive(Debug, Default)]
pub struct Given {
    /// Contents of mesh and STL files by the path that the text has for them; they come before files of a folder.
    pub files: BTreeMap<String, Vec<u8>>,
    /// Meshes of bodies.
    pub meshes: Vec<GivenMesh>,
    /// Functions, each by its components.
    pub functions: Vec<Vec<Field>>,
}

impl Given {
    /// The component of a function that a text names.
    pub(crate) fn function(&self, text: &str) -> Option<&Field> {
        let handle = text.strip_prefix(HANDLE)?;
        let (function, component) = handle.split_once('.')?;
        let function = self.functions.get(function.parse::<usize>().ok()?)?;
        function.get(component.parse::<usize>().ok()?)
    }

    /// The mesh that a value names; `None` where it names something else.
    pub(crate) fn mesh(&self, node: &Node) -> Option<&GivenMesh> {
        let Value::Text(text) = &node.value else {
            return None;
        };
        let place = text.strip_prefix(HANDLE)?.parse::<usize>().ok()?;
        self.meshes.get(place)
    }
}

/// The error for a mesh of another dimension than that of the case.
pub(crate) fn other_dimension(node: &Node, body: &str, dimension: usize) -> Fault {
    let message = format!(
        "the mesh of body `{body}` is in {}D, and the analysis is in {dimension}D",
        5 - dimension
    );
    Fault::new(&node.span, message).label("another number of dimensions")
}

/// Name of a mesh in messages before a body has it.
const NEW: &str = "new";

/// A mesh that was read.
#[derive(Debug)]
pub struct ReadMesh {
    /// The mesh.
    pub mesh: GivenMesh,
    /// Warnings of reading.
    pub warnings: Vec<String>,
    /// It is made of words alone, and of no file.
    pub of_words: bool,
}

/// The mesh of a text with the key `mesh` of a body, and `drawing` where it is made of regions, in space or in the plane.
///
/// Errors: every mistake in the text; files that cannot be read.
pub fn read_mesh(
    text: &str,
    folder: &Path,
    space: bool,
    given: &Arc<Given>,
) -> Result<ReadMesh, CaseError> {
    let source = Source::parse(text, NEW, folder, &[], given)?;
    let mut files = MeshFiles::new(source.folder);
    let read = match space {
        true => made(&source, &mut files).map(|(mesh, points)| GivenMesh::Space(mesh, points)),
        false => made(&source, &mut files).map(|(mesh, points)| GivenMesh::Plane(mesh, points)),
    };
    let read = read.map(|mesh| ReadMesh {
        mesh,
        of_words: files.named.is_empty(),
        warnings: files.warnings(),
    });
    read.map_err(|fault| {
        let mut error = fault.in_source(NEW, text);
        error.message = error.message.replace(&format!(" of body `{NEW}`"), "");
        error
    })
}

fn made<const D: usize>(
    source: &Source<'_>,
    files: &mut MeshFiles,
) -> Result<(Arc<Mesh<D>>, Named<D>), Fault>
where
    Mesh<D>: Generated<D>,
{
    let table = source.document.table(keys::CASE_MESH)?;
    files.drawing = table.get("drawing").map(outline::drawing).transpose()?;
    let node = table.require("mesh", "a mesh")?;
    let needed = format!("one in {D}D is asked for");
    let (mesh, points) = mesh(node, NEW, &needed, files)?;
    Ok((Arc::new(mesh), points))
}

/// A text of a case file as JSON, its tables in the order of the text.
///
/// Errors: invalid TOML.
pub fn to_json(text: &str, name: &str) -> Result<String, CaseError> {
    let document = document::parse_whole(text).map_err(|fault| fault.in_source(name, text))?;
    Ok(json(&document).to_string())
}

fn json(node: &Node) -> serde_json::Value {
    match &node.value {
        Value::Text(text) => text.as_str().into(),
        Value::Integer(value) => (*value).into(),
        Value::Float(value) => (*value).into(),
        Value::Boolean(value) => (*value).into(),
        Value::Date => serde_json::Value::Null,
        Value::List(list) => list.iter().map(json).collect(),
        Value::Table(entries) => {
            let entries = entries.iter();
            let entries = entries.map(|entry| (entry.key.clone(), json(&entry.node)));
            serde_json::Value::Object(entries.collect())
        }
    }
}
