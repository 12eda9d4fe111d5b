//! Gmsh's `.msh` files of versions 1, 2.0, 2.1, 2.2, 4.0 and 4.1, text and binary with either order of bytes.
//!
//! Read are `$MeshFormat`, `$PhysicalNames`, `$Entities`, `$PartitionedEntities`, `$Nodes` (parametric coordinates are
//! skipped) and `$Elements`, of version 1 `$NOD` and `$ELM`; any other section is reported. Physical tags stand at the elements
//! up to version 2.2, at the geometric entities from 4.0. Partitions are joined, those of one file and those of several.
//! Source: Gmsh reference manual, section "Gmsh file formats", of Gmsh 4.13 and of earlier versions.

mod entities;
mod kinds;
mod listed;
mod partitions;

use crate::mesh::import::content::{Content, ElementType};
use crate::mesh::import::cursor::Cursor;
use crate::mesh::import::error::ImportError;
use crate::mesh::import::gmsh::partitions::Partitions;
use crate::mesh::{CellKind, MAX_CELL_NODES};
use std::collections::{BTreeMap, HashMap};

/// Sections that are read; the format must be known before.
const SECTIONS: [&str; 6] = [
    "PhysicalNames",
    "Entities",
    "PartitionedEntities",
    "Nodes",
    "ParametricNodes",
    "Elements",
];

/// Sections that hold nothing of a body, and nothing that a user would miss.
const SILENT: [&str; 2] = ["Comments", "GhostElements"];

/// Reads files that begin with `$`: one, or the partitions of one mesh.
pub(crate) fn read(files: Vec<Cursor<'_>>, dimension: u8) -> Result<Content, ImportError> {
    let mut files = files.into_iter();
    let first = files.next().unwrap_or_else(|| Cursor::new("", b""));
    let mut reader = Reader {
        cursor: first,
        version: Version::Unknown,
        content: Content::new(dimension),
        points: HashMap::new(),
        entities: BTreeMap::new(),
        names: BTreeMap::new(),
        partitions: Partitions::default(),
        nodes: false,
        elements: false,
    };
    reader.sections()?;
    for file in files {
        reader.cursor = file;
        reader.version = Version::Unknown;
        reader.entities.clear();
        reader.partitions.entities.clear();
        (reader.nodes, reader.elements) = (false, false);
        reader.sections()?;
    }
    reader.spread_names();
    reader.refuse_missing()?;
    Ok(reader.content)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    Unknown,
    /// Without `$MeshFormat`.
    V1,
    V20,
    V21,
    V22,
    V40,
    V41,
}

impl Version {
    /// Groups stand at the geometric entities.
    fn of_entities(self) -> bool {
        matches!(self, Self::V40 | Self::V41)
    }
}

struct Reader<'b> {
    cursor: Cursor<'b>,
    version: Version,
    content: Content,
    /// Index of the point of each node number.
    points: HashMap<u64, u32>,
    /// Physical tags by dimension and number of the entity.
    entities: BTreeMap<(i64, i64), Vec<i64>>,
    /// Names that do not tell their dimension.
    names: BTreeMap<i64, String>,
    partitions: Partitions,
    /// Nodes were read.
    nodes: bool,
    /// Elements were read.
    elements: bool,
}

impl Reader<'_> {
    fn sections(&mut self) -> Result<(), ImportError> {
        while self.cursor.skip_space() {
            let start = self.cursor.at();
            let line = self.cursor.line();
            let Some(name) = line.strip_prefix('$') else {
                let message = format!("expected a section such as `$Nodes`, found `{line:.40}`");
                return Err(self.cursor.malformed(start, message));
            };
            self.cursor.section = format!("section ${name}");
            self.section(name, start)?;
        }
        let old = self.version == Version::V1;
        let missing = match (self.version, self.nodes, self.elements) {
            (Version::Unknown, _, _) => "$MeshFormat",
            (_, false, _) if old => "$NOD",
            (_, false, _) => "$Nodes",
            (_, _, false) if old => "$ELM",
            (_, _, false) => "$Elements",
            _ => return Ok(()),
        };
        let what =
            format!("the file has no section {missing}, or nothing is in it: write it again");
        Err(self.cursor.unsupported(what))
    }

    fn section(&mut self, name: &str, start: usize) -> Result<(), ImportError> {
        let known = SECTIONS.contains(&name);
        if known && self.version == Version::Unknown {
            let message = format!("`${name}` stands before `$MeshFormat`, which must come first");
            return Err(self.cursor.malformed(start, message));
        }
        if name.ends_with("Entities") && self.elements {
            let message = format!("`${name}` stands behind `$Elements`, whose groups it holds");
            return Err(self.cursor.malformed(start, message));
        }
        if self.version == Version::Unknown && ["NOD", "ELM"].contains(&name) {
            self.version = Version::V1;
        }
        match (name, self.version) {
            ("MeshFormat", _) => self.format()?,
            ("PhysicalNames", _) => self.names()?,
            ("Entities", version) if version.of_entities() => self.entities()?,
            ("PartitionedEntities", version) if version.of_entities() => self.partitioned()?,
            ("Nodes", version) if version.of_entities() => self.nodes_of_entities()?,
            ("Nodes" | "NOD", _) => self.nodes(false)?,
            ("ParametricNodes", version) if !version.of_entities() => self.nodes(true)?,
            ("Elements", version) if version.of_entities() => self.elements_of_entities()?,
            ("Elements", _) => self.elements()?,
            ("ELM", Version::V1) => self.elements_of_version_1()?,
            _ => {
                self.leave_out(name);
                return self.cursor.skip_section(name);
            }
        }
        self.nodes |= ["Nodes", "NOD", "ParametricNodes"].contains(&name);
        self.cursor.end_section(name)
    }

    /// Says that a section is not read.
    fn leave_out(&mut self, name: &str) {
        let meaning = match name {
            _ if SILENT.contains(&name) => return,
            "Periodic" => ": periodic nodes are not tied to each other",
            _ => "",
        };
        let remark = format!("section ${name} is left out{meaning}");
        if !self.content.remarks.contains(&remark) {
            self.content.remarks.push(remark);
        }
    }

    fn version_refused(&self, version: &str) -> ImportError {
        let what = format!(
            "version {version} of the format is not read: save the mesh as 4.1 into another file (`gmsh OLD.msh -save -format msh41 -o NEW.msh`)"
        );
        self.cursor.unsupported(what)
    }

    /// Names without a dimension are those of the groups of every dimension that has such a tag.
    fn spread_names(&mut self) {
        let own = self.content.dimension;
        let used = [0, own - 1, own].map(|dimension| (dimension, self.content.used(dimension)));
        for (tag, name) in std::mem::take(&mut self.names) {
            let has = used.iter().filter(|(_, tags)| tags.contains(&tag));
            let mut dimensions: Vec<u8> = has.map(|(dimension, _)| *dimension).collect();
            if dimensions.is_empty() {
                dimensions.push(own);
            }
            for dimension in dimensions {
                let names = &mut self.content.names;
                names.entry((dimension, tag)).or_insert(name.clone());
            }
        }
    }

    /// Refuses a mesh with cells of some of its partitions only; where their number is not told, as in version 2.2, a remark
    /// says which there are.
    fn refuse_missing(&mut self) -> Result<(), ImportError> {
        let Some((count, missing)) = self.partitions.missing() else {
            return Ok(());
        };
        let join = "to join the files part_1.msh, part_2.msh, .. of a mesh name `part.msh`";
        if self.partitions.announced == 0 {
            let remark = format!("no cell is of a partition {missing}: {join}");
            self.content.remarks.push(remark);
            return Ok(());
        }
        let what =
            format!("the mesh has {count} partitions, and there are no cells of {missing}: {join}");
        Err(self.cursor.unsupported(what))
    }

    /// Version, text or binary, bytes of a size, and in binary files the order of bytes.
    fn format(&mut self) -> Result<(), ImportError> {
        let start = self.cursor.next_at();
        let version: f64 = self.cursor.parsed("the version")?;
        self.version = match version {
            2.0 => Version::V20,
            2.1 => Version::V21,
            2.2 => Version::V22,
            4.0 => Version::V40,
            4.1 => Version::V41,
            _ => return Err(self.version_refused(&version.to_string())),
        };
        let mode: u8 = self.cursor.parsed("0 (text) or 1 (binary)")?;
        let size: usize = self.cursor.parsed("the number of bytes of a size")?;
        self.cursor.line();
        match (mode, size) {
            (0, _) => {}
            (1, 4 | 8) => self.cursor.encoding = self.cursor.byte_order(size)?,
            (1, _) => {
                let message = format!("sizes of {size} bytes are not read: 8 or 4 are");
                return Err(self.cursor.malformed(start, message));
            }
            _ => {
                let message = format!("expected 0 (text) or 1 (binary), found {mode}");
                return Err(self.cursor.malformed(start, message));
            }
        }
        Ok(())
    }

    /// A count, which version 2 writes as text in binary files, too.
    fn count(&mut self, what: &str) -> Result<u64, ImportError> {
        let count = self.cursor.parsed(what)?;
        self.cursor.line();
        Ok(count)
    }

    /// Names of groups: text in binary files, too. In version 2.0 they may have no dimension, in files made of these the dimension -1.
    fn names(&mut self) -> Result<(), ImportError> {
        for _ in 0..self.count("the number of names")? {
            let start = self.cursor.next_at();
            let first: i64 = self.cursor.parsed("a dimension")?;
            if self.version == Version::V20 && self.cursor.before_quote() {
                let name = self.cursor.quoted()?;
                self.names.insert(first, name);
                continue;
            }
            let tag: i64 = self.cursor.parsed("a physical tag")?;
            let name = self.cursor.quoted()?;
            // as Gmsh writes the names of version 2.0 into later files
            if first == -1 {
                self.names.insert(tag, name);
                continue;
            }
            let dimension = u8::try_from(first).map_err(|_| {
                let message = format!("expected a dimension, found {first}");
                self.cursor.malformed(start, message)
            })?;
            let other = self.content.names.insert((dimension, tag), name.clone());
            if let Some(other) = other.filter(|other| *other != name) {
                let message = format!(
                    "the group {tag} of dimension {dimension} is called `{other}` and `{name}`: give it one name"
                );
                return Err(self.cursor.malformed(start, message));
            }
        }
        Ok(())
    }

    fn point(&mut self) -> Result<[f64; 3], ImportError> {
        let mut point = [0.0; 3];
        for c in &mut point {
            *c = self.cursor.real("a coordinate")?;
        }
        Ok(point)
    }

    /// One more point; files of partitions repeat the nodes that they share.
    fn add_point(&mut self, number: u64, start: usize, point: [f64; 3]) -> Result<(), ImportError> {
        let Ok(index) = u32::try_from(self.content.points.len()) else {
            return Err(self.cursor.unsupported("the mesh has too many nodes"));
        };
        let known = *self.points.entry(number).or_insert(index);
        match self.content.points.get(known as usize) {
            None => self.content.points.push(point),
            Some(other) if *other == point => {}
            Some(other) => {
                let message =
                    format!("node {number} is given twice, at {other:?} and at {point:?}");
                return Err(self.cursor.malformed(start, message));
            }
        }
        Ok(())
    }

    /// A number above zero.
    fn positive(&mut self, what: &str) -> Result<u64, ImportError> {
        let start = self.cursor.next_at();
        let number = self.cursor.integer(what)?;
        u64::try_from(number).map_err(|_| {
            let message = format!("{what} must be positive, found {number}");
            self.cursor.malformed(start, message)
        })
    }

    fn element_type(&mut self) -> Result<ElementType, ImportError> {
        let start = self.cursor.next_at();
        let number = self.cursor.integer("an element type")?;
        kinds::element_type(number).ok_or_else(|| {
            let message = match number {
                34 | 35 => "polygons and polyhedra are not read: mesh with first or second order"
                    .to_string(),
                _ => format!("element type {number} is not known: mesh with first or second order"),
            };
            self.cursor.malformed(start, message)
        })
    }

    /// One element, its nodes numbered by `number`.
    fn add_element(
        &mut self,
        element: ElementType,
        label: u64,
        tags: u32,
        number: impl Fn(&mut Self) -> Result<u64, ImportError>,
    ) -> Result<(), ImportError> {
        let mut nodes = [0; MAX_CELL_NODES];
        for place in 0..element.nodes {
            let start = self.cursor.next_at();
            let node = number(self)?;
            let Some(&index) = self.points.get(&node) else {
                let message =
                    format!("element {label} names node {node}, which `$Nodes` does not have");
                return Err(self.cursor.malformed(start, message));
            };
            // Kinds with more nodes are counted only.
            if let Some(slot) = nodes.get_mut(place) {
                *slot = index;
            }
        }
        let used = &mut nodes[..element.nodes.min(MAX_CELL_NODES)];
        if let Some(kind) = CellKind::from_name(element.name) {
            kind.reorder_from_gmsh(used);
        }
        self.content.add(element, label, used, tags);
        Ok(())
    }
}
