//! Sources from which several bodies are cut.
//!
//! `mesh = { file = { path, group } }`: mesh files, each read once for all bodies of a case that have the same dimension: an
//! extruded mesh and a solid may come from one file. `mesh = { region }`: the drawing of the case.
//!
//! The parts of a file that no body uses are known only when all bodies have been read: [`MeshFiles::warnings`].

use crate::case::document::{Node, Span, Value};
use crate::case::error::Fault;
use crate::case::given::other_dimension;
use crate::case::keys;
use crate::case::mesh::Generated;
use crate::case::suggest::{listed, nearest};
use crate::geometry::Point;
use crate::mesh::{ImportError, Imported, Mesh, MeshFile, Regions};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Points by name; a mesh file may give one name to several.
pub(crate) type Named<const D: usize> = BTreeMap<String, Vec<Point<D>>>;

/// The mesh files and the drawing of a case.
pub(crate) struct MeshFiles {
    /// Where relative paths start.
    folder: PathBuf,
    files: Vec<Opened>,
    /// The regions of the drawing.
    pub drawing: Option<Regions>,
    /// Regions that bodies are made of: region, body, place of the name.
    pub used: Vec<(String, String, Span)>,
    /// Paths of the files, as the text has them.
    pub named: BTreeSet<String>,
    warnings: Vec<String>,
}

/// A file read for bodies of one dimension, and its parts that no such body has used so far.
struct Opened {
    path: PathBuf,
    dimension: usize,
    file: MeshFile,
    unused: Option<Unused>,
}

struct Unused {
    cells: Vec<String>,
    sides: Vec<String>,
    points: Vec<String>,
    loose: usize,
}

impl MeshFiles {
    /// The content of a file that a node names, given or in the folder of the case.
    ///
    /// Errors: why it cannot be read.
    pub fn bytes(&mut self, node: &Node, path: &str) -> Result<Vec<u8>, String> {
        self.named.insert(path.to_string());
        match node.given().files.get(path) {
            Some(bytes) => Ok(bytes.clone()),
            None => crate::host::read(&self.folder.join(path)),
        }
    }

    /// Adds a warning of reading.
    pub fn warn(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_path_buf(),
            files: Vec::new(),
            drawing: None,
            used: Vec::new(),
            named: BTreeSet::new(),
            warnings: Vec::new(),
        }
    }

    /// The mesh of a body from the table `file`, and the points that the file names.
    pub fn mesh<const D: usize>(
        &mut self,
        node: &Node,
        body: &str,
    ) -> Result<(Mesh<D>, Named<D>), Fault>
    where
        Mesh<D>: Generated<D>,
    {
        if let Some(given) = node.given().mesh(node) {
            let own = Mesh::<D>::given(given);
            return own.ok_or_else(|| other_dimension(node, body, D));
        }
        if let Value::Text(name) = &node.value {
            let message = "a mesh file is a table";
            return Err(Fault::new(&node.span, message)
                .label("not a table")
                .help(format!("write `file = {{ path = \"{name}\" }}`")));
        }
        let table = node.table(keys::FILE)?;
        let path = table.require("path", "a mesh file")?;
        let groups = table.get("group").map_or(Ok(Vec::new()), groups)?;
        let group_span = table.get("group").map_or(&path.span, |node| &node.span);
        let opened = self.open::<D>(path, body)?;
        let names: Vec<&str> = groups.iter().map(|(name, _)| *name).collect();
        let imported = Mesh::<D>::cut(&opened.file, &names);
        let imported = imported.map_err(|error| match &error {
            ImportError::UnknownGroup { group, known, .. } => {
                let named = groups.iter().find(|(name, _)| name == group);
                let span = named.map_or(group_span, |(_, span)| span);
                unknown_group(&error, group, known, span, body)
            }
            ImportError::Shell { .. } => refused(&error, group_span, body),
            _ => refused(&error, &path.span, body),
        })?;
        opened.use_of(&imported);
        let warnings = imported.warnings.iter();
        self.warnings
            .extend(warnings.map(|w| format!("body `{body}`: {w}")));
        Ok((imported.mesh, imported.points))
    }

    /// The mesh of a body from the regions that a node names.
    pub fn regions(&mut self, node: &Node, body: &str) -> Result<Mesh<2>, Fault> {
        let Some(drawing) = &self.drawing else {
            let message = format!("body `{body}` is a region, and the case has no drawing");
            return Err(Fault::new(&node.span, message)
                .label("region of what?")
                .help("add `[drawing]` with `size`, `lines` and `regions`"));
        };
        let names = groups(node)?;
        for (k, (region, span)) in names.iter().enumerate() {
            if !drawing.names().any(|known| known == *region) {
                let message = format!("the drawing has no region `{region}`");
                let words = ["the nearest known region", "its regions"];
                return Err(Fault::new(span, message).nearest(region, words, drawing.names()));
            }
            if names[..k].iter().any(|(before, _)| before == region) {
                let message = format!("the region `{region}` is listed twice");
                return Err(Fault::new(span, message).label("second time"));
            }
        }
        let used = names.iter();
        let used = used.map(|(name, span)| (name.to_string(), body.to_string(), span.clone()));
        self.used.extend(used);
        let names: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        let mesh = drawing.mesh(&names);
        mesh.map_err(|e| {
            let message = format!("the mesh of body `{body}`: {e}");
            Fault::new(&node.span, message).label("cannot be meshed")
        })
    }

    /// The file of a path for bodies of D dimensions, read on first use.
    fn open<const D: usize>(&mut self, node: &Node, body: &str) -> Result<&mut Opened, Fault>
    where
        Mesh<D>: Generated<D>,
    {
        let name = node.text()?;
        self.named.insert(name.to_string());
        let path = self.folder.join(name);
        let known = |opened: &Opened| opened.path == path && opened.dimension == D;
        let place = match self.files.iter().position(known) {
            Some(place) => place,
            None => {
                let file = match node.given().files.get(name) {
                    Some(bytes) => Mesh::<D>::from_bytes(name, bytes),
                    None => Mesh::<D>::read(&path),
                };
                let file = file.map_err(|error| refused(&error, &node.span, body))?;
                let said = file.warnings();
                match self.files.iter().find(|opened| opened.path == path) {
                    // parts left out for one dimension may be used by the other
                    Some(other) => self.warnings.retain(|warning| {
                        !other.file.warnings().contains(warning) || said.contains(warning)
                    }),
                    None => self.warnings.extend(said.iter().cloned()),
                }
                self.files.push(Opened {
                    path,
                    dimension: D,
                    file,
                    unused: None,
                });
                self.files.len() - 1
            }
        };
        Ok(&mut self.files[place])
    }

    /// Warnings of reading, and the parts of the files that no body uses.
    pub fn warnings(self) -> Vec<String> {
        let mut warnings = self.warnings;
        let regions = self.drawing.iter().flat_map(Regions::names);
        let unused = regions.filter(|region| !self.used.iter().any(|(used, ..)| used == region));
        let unused: Vec<&str> = unused.collect();
        if !unused.is_empty() {
            let unused = listed(unused);
            warnings.push(format!("drawing: no body has the regions {unused}"));
        }
        let used = self.files.iter().flat_map(Opened::used);
        let used: BTreeSet<(&Path, &str)> = used.collect();
        for opened in &self.files {
            let Some(unused) = &opened.unused else {
                continue;
            };
            let name = opened.path.display();
            let left = |names: &[String]| {
                let left = names.iter().map(String::as_str);
                let left = left.filter(|name| !used.contains(&(opened.path.as_path(), name)));
                let left: Vec<&str> = left.collect();
                (!left.is_empty()).then(|| listed(left))
            };
            if let Some(groups) = left(&unused.cells) {
                warnings.push(format!("{name}: no body has the groups of cells {groups}"));
            }
            if let Some(groups) = left(&unused.sides) {
                let sides = if opened.dimension == 2 {
                    "edges"
                } else {
                    "faces"
                };
                warnings.push(format!(
                    "{name}: the groups of {sides} {groups} are on the boundary of no body"
                ));
            }
            if let Some(groups) = left(&unused.points) {
                warnings.push(format!(
                    "{name}: the groups of points {groups} have a node in no body"
                ));
            }
            if unused.loose > 0 {
                let count = unused.loose;
                warnings.push(format!(
                    "{name}: {count} cells belong to no physical group and are in no body"
                ));
            }
        }
        warnings
    }
}

impl Opened {
    /// The groups that bodies use, with the file.
    fn used(&self) -> impl Iterator<Item = (&Path, &str)> {
        let unused = self.unused.iter();
        let unused = unused.flat_map(|u| [&u.cells, &u.sides, &u.points]);
        let unused: BTreeSet<&String> = unused.flatten().collect();
        let file = &self.file;
        let known = [file.cell_groups(), file.side_groups(), file.point_groups()];
        let used = known.into_iter().flatten();
        let used = used.filter(move |name| !unused.contains(name));
        used.map(|name| (self.path.as_path(), name.as_str()))
    }

    /// Removes the parts that a body uses from the list of unused ones.
    fn use_of<const D: usize>(&mut self, imported: &Imported<D>) {
        let before = self.unused.take().unwrap_or_else(|| Unused {
            cells: imported.unused_cells.clone(),
            sides: imported.unused_sides.clone(),
            points: imported.unused_points.clone(),
            loose: imported.unused_loose,
        });
        let common = |names: Vec<String>, other: &[String]| {
            names
                .into_iter()
                .filter(|name| other.contains(name))
                .collect()
        };
        self.unused = Some(Unused {
            cells: common(before.cells, &imported.unused_cells),
            sides: common(before.sides, &imported.unused_sides),
            points: common(before.points, &imported.unused_points),
            loose: before.loose.min(imported.unused_loose),
        });
    }
}

/// One name or a list of names, with their places.
fn groups(node: &Node) -> Result<Vec<(&str, Span)>, Fault> {
    match &node.value {
        Value::Text(text) => Ok(vec![(text, node.span.clone())]),
        Value::List(list) if !list.is_empty() => {
            let names = list
                .iter()
                .map(|node| Ok((node.text()?, node.span.clone())));
            names.collect()
        }
        _ => Err(node.expected("the name of a group or a list of names")),
    }
}

fn unknown_group(
    error: &ImportError,
    group: &str,
    known: &[String],
    span: &Span,
    body: &str,
) -> Fault {
    let names = || known.iter().map(String::as_str);
    let Some(near) = nearest(group, names()) else {
        return refused(error, span, body);
    };
    Fault::new(
        span,
        format!("the mesh of body `{body}`: the file has no group of cells `{group}`"),
    )
    .label(format!("the nearest known group is `{near}`"))
    .help(format!("its groups of cells: {}", listed(names())))
}

fn refused(error: &ImportError, span: &Span, body: &str) -> Fault {
    Fault::new(span, format!("the mesh of body `{body}`: {error}")).label("cannot be read")
}
