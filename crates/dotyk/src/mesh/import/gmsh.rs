//! Gmsh's `.msh` files of versions 4.1 and 2.2, text and binary with either order of bytes.
//!
//! Read are `$MeshFormat`, `$PhysicalNames`, `$Entities`, `$Nodes` (parametric coordinates are skipped) and `$Elements`;
//! any other section is reported. Physical tags stand at the elements in version 2.2, at the geometric entities in 4.1.
//! Source: Gmsh reference manual, section "Gmsh file formats".

use crate::mesh::import::content::{Content, ElementType};
use crate::mesh::import::cursor::{Cursor, Encoding};
use crate::mesh::import::error::ImportError;
use crate::mesh::{CellKind, MAX_CELL_NODES};
use std::collections::{BTreeMap, HashMap};

const fn kind(name: &'static str, dimension: u8, nodes: usize) -> ElementType {
    ElementType {
        name,
        dimension,
        nodes,
    }
}

/// Gmsh's numbers of element types that are not supported.
const OTHER_TYPES: [(i64, ElementType); 30] = [
    (7, kind("pyramid5", 3, 5)),
    (14, kind("pyramid14", 3, 14)),
    (15, kind("point", 0, 1)),
    (19, kind("pyramid13", 3, 13)),
    (20, kind("tri9", 2, 9)),
    (21, kind("tri10", 2, 10)),
    (22, kind("tri12", 2, 12)),
    (23, kind("tri15", 2, 15)),
    (24, kind("tri15 of order 5", 2, 15)),
    (25, kind("tri21", 2, 21)),
    (26, kind("line4", 1, 4)),
    (27, kind("line5", 1, 5)),
    (28, kind("line6", 1, 6)),
    (29, kind("tet20", 3, 20)),
    (30, kind("tet35", 3, 35)),
    (31, kind("tet56", 3, 56)),
    (32, kind("tet22", 3, 22)),
    (33, kind("tet28", 3, 28)),
    (36, kind("quad16", 2, 16)),
    (37, kind("quad25", 2, 25)),
    (38, kind("quad36", 2, 36)),
    (39, kind("quad12", 2, 12)),
    (40, kind("quad16 of order 4", 2, 16)),
    (41, kind("quad20", 2, 20)),
    (92, kind("hex64", 3, 64)),
    (93, kind("hex125", 3, 125)),
    (94, kind("hex216", 3, 216)),
    (99, kind("hex32", 3, 32)),
    (100, kind("hex44", 3, 44)),
    (118, kind("pyramid30", 3, 30)),
];

/// Sections that are read; the format must be known before.
const SECTIONS: [&str; 5] = [
    "PhysicalNames",
    "Entities",
    "Nodes",
    "ParametricNodes",
    "Elements",
];

/// Reads a file that begins with `$`.
pub(crate) fn read(cursor: Cursor<'_>, dimension: u8) -> Result<Content, ImportError> {
    let mut reader = Reader {
        cursor,
        version: Version::Unknown,
        content: Content::new(dimension),
        points: HashMap::new(),
        entities: BTreeMap::new(),
        elements: false,
    };
    reader.sections()?;
    Ok(reader.content)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    Unknown,
    V2,
    V4,
}

struct Reader<'b> {
    cursor: Cursor<'b>,
    version: Version,
    content: Content,
    /// Index of the point of each node number.
    points: HashMap<u64, u32>,
    /// Physical tags by dimension and number of the entity.
    entities: BTreeMap<(i64, i64), Vec<i64>>,
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
        let missing = match (self.version, self.points.is_empty(), self.elements) {
            (Version::Unknown, _, _) => "$MeshFormat",
            (_, true, _) => "$Nodes",
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
        if name == "Entities" && self.elements {
            let message = "`$Entities` stands behind `$Elements`, whose groups it holds";
            return Err(self.cursor.malformed(start, message));
        }
        match (name, self.version) {
            ("MeshFormat", _) => self.format()?,
            ("PhysicalNames", _) => self.names()?,
            ("Entities", Version::V4) => self.entities()?,
            ("Nodes", Version::V4) => self.nodes_of_entities()?,
            ("Nodes", _) => self.nodes(false)?,
            ("ParametricNodes", Version::V2) => self.nodes(true)?,
            ("Elements", Version::V4) => self.elements_of_entities()?,
            ("Elements", _) => self.elements()?,
            ("NOD" | "ELM", _) => return Err(self.version_refused("1")),
            ("PartitionedEntities", _) => {
                let what = "the mesh is partitioned: save it without partitions (in Gmsh: Mesh, Unpartition)";
                return Err(self.cursor.unsupported(what));
            }
            ("Comments", _) => return self.cursor.skip_section(name),
            _ => {
                let remark = format!("section ${name} is left out");
                if !self.content.remarks.contains(&remark) {
                    self.content.remarks.push(remark);
                }
                return self.cursor.skip_section(name);
            }
        }
        self.cursor.end_section(name)
    }

    fn version_refused(&self, version: &str) -> ImportError {
        let what = format!(
            "version {version} of the format is not read: save the mesh as 4.1 or 2.2 (`gmsh FILE -save -format msh41`)"
        );
        self.cursor.unsupported(what)
    }

    /// Version, text or binary, bytes of a size, and in binary files the order of bytes.
    fn format(&mut self) -> Result<(), ImportError> {
        let start = self.cursor.next_at();
        let version: f64 = self.cursor.parsed("the version")?;
        self.version = match version {
            2.2 => Version::V2,
            4.1 => Version::V4,
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

    /// A count, which version 2.2 writes as text in binary files, too.
    fn count(&mut self, what: &str) -> Result<u64, ImportError> {
        let count = self.cursor.parsed(what)?;
        self.cursor.line();
        Ok(count)
    }

    /// Names of groups: text in binary files, too.
    fn names(&mut self) -> Result<(), ImportError> {
        for _ in 0..self.count("the number of names")? {
            let dimension: u8 = self.cursor.parsed("a dimension")?;
            let tag: i64 = self.cursor.parsed("a physical tag")?;
            let name = self.cursor.quoted()?;
            self.content.names.insert((dimension, tag), name);
        }
        Ok(())
    }

    /// Physical tags of the geometric entities; their positions and boundaries are not needed.
    fn entities(&mut self) -> Result<(), ImportError> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = self.cursor.size("the number of entities")?;
        }
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let tag = self.cursor.integer("the number of an entity")?;
                let coordinates = if dimension == 0 { 3 } else { 6 };
                for _ in 0..coordinates {
                    // A bounding box may be infinite where an entity is empty.
                    self.cursor.number("a coordinate")?;
                }
                let physical = self.integers("a physical tag")?;
                if dimension > 0 {
                    self.integers("an entity of the boundary")?;
                }
                self.entities.insert((dimension, tag), physical);
            }
        }
        Ok(())
    }

    /// A size and as many integers.
    fn integers(&mut self, what: &str) -> Result<Vec<i64>, ImportError> {
        let count = self.cursor.size("a number of tags")?;
        (0..count).map(|_| self.cursor.integer(what)).collect()
    }

    fn point(&mut self) -> Result<[f64; 3], ImportError> {
        let mut point = [0.0; 3];
        for c in &mut point {
            *c = self.cursor.real("a coordinate")?;
        }
        Ok(point)
    }

    fn add_point(&mut self, number: u64, start: usize, point: [f64; 3]) -> Result<(), ImportError> {
        let Ok(index) = u32::try_from(self.content.points.len()) else {
            return Err(self.cursor.unsupported("the mesh has too many nodes"));
        };
        if self.points.insert(number, index).is_some() {
            let message = format!("node {number} is given twice");
            return Err(self.cursor.malformed(start, message));
        }
        self.content.points.push(point);
        Ok(())
    }

    /// `$Nodes` and `$ParametricNodes` of version 2.2.
    fn nodes(&mut self, parametric: bool) -> Result<(), ImportError> {
        for _ in 0..self.count("the number of nodes")? {
            let start = self.cursor.next_at();
            let number = self.node_number()?;
            let point = self.point()?;
            self.add_point(number, start, point)?;
            if parametric {
                let dimension = self.cursor.integer("a dimension")?;
                self.cursor.integer("the number of an entity")?;
                // Nodes inside volumes have no parameters here.
                let parameters = if dimension > 2 { 0 } else { dimension };
                for _ in 0..parameters {
                    self.cursor.real("a parameter")?;
                }
            }
        }
        Ok(())
    }

    /// The number of a node in version 2.2, where it is an integer.
    fn node_number(&mut self) -> Result<u64, ImportError> {
        let start = self.cursor.next_at();
        let number = self.cursor.integer("the number of a node")?;
        u64::try_from(number).map_err(|_| {
            let message = format!("the number of a node must be positive, found {number}");
            self.cursor.malformed(start, message)
        })
    }

    /// `$Nodes` of version 4.1.
    fn nodes_of_entities(&mut self) -> Result<(), ImportError> {
        let start = self.cursor.next_at();
        let blocks = self.cursor.size("the number of blocks of nodes")?;
        let total = self.cursor.size("the number of nodes")?;
        self.cursor.size("the smallest number of a node")?;
        self.cursor.size("the largest number of a node")?;
        for _ in 0..blocks {
            let dimension = self.cursor.integer("a dimension")?;
            self.cursor.integer("the number of an entity")?;
            let parametric = self.cursor.integer("0, or 1 for parametric nodes")?;
            let count = self.cursor.size("the number of nodes of a block")?;
            let mut numbers = Vec::new();
            for _ in 0..count {
                let start = self.cursor.next_at();
                numbers.push((self.cursor.size("the number of a node")?, start));
            }
            for (number, start) in numbers {
                let point = self.point()?;
                self.add_point(number, start, point)?;
                let parameters = if parametric == 0 { 0 } else { dimension };
                for _ in 0..parameters {
                    self.cursor.real("a parameter")?;
                }
            }
        }
        self.agree(start, total, self.content.points.len() as u64, "nodes")
    }

    /// The total of a section of version 4.1 must be that of its blocks.
    fn agree(&self, start: usize, total: u64, read: u64, what: &str) -> Result<(), ImportError> {
        if total == read {
            return Ok(());
        }
        let message = format!(
            "the section announces {total} {what}, its blocks have {read}: write the file again"
        );
        Err(self.cursor.malformed(start, message))
    }

    fn element_type(&mut self) -> Result<ElementType, ImportError> {
        let start = self.cursor.next_at();
        let number = self.cursor.integer("an element type")?;
        let ours = |kind: &CellKind| i64::from(kind.gmsh()) == number;
        let ours = CellKind::ALL.into_iter().find(ours).map(ElementType::of);
        let other = OTHER_TYPES.iter().find(|(known, _)| *known == number);
        ours.or(other.map(|other| other.1)).ok_or_else(|| {
            let message =
                format!("element type {number} is not known: mesh with first or second order");
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

    /// `$Elements` of version 2.2.
    fn elements(&mut self) -> Result<(), ImportError> {
        self.elements = true;
        let total = self.count("the number of elements")?;
        let mut read = 0;
        while read < total {
            let text = self.cursor.encoding == Encoding::Text;
            let start = self.cursor.next_at();
            let mut label = if text {
                self.cursor.integer("the number of an element")?
            } else {
                0
            };
            let element = self.element_type()?;
            let count = if text {
                1
            } else {
                self.cursor.integer("a number of elements")?
            };
            let tags = self.cursor.integer("the number of tags")?;
            if count < 1 || tags < 0 {
                let message = format!("a block of {count} elements with {tags} tags");
                return Err(self.cursor.malformed(start, message));
            }
            for _ in 0..count {
                if !text {
                    label = self.cursor.integer("the number of an element")?;
                }
                let mut own = Vec::new();
                for place in 0..tags {
                    let tag = self.cursor.integer("a tag")?;
                    // The first is the physical tag, the others are the entity and partitions.
                    if place == 0 {
                        own.push(tag);
                    }
                }
                let set = self.content.tag_set(own);
                self.add_element(element, label.unsigned_abs(), set, Self::node_number)?;
            }
            read += count.unsigned_abs();
        }
        match read == total {
            true => Ok(()),
            false => {
                let message =
                    format!("the section announces {total} elements and has {read} or more");
                Err(self.cursor.malformed(self.cursor.at(), message))
            }
        }
    }

    /// `$Elements` of version 4.1.
    fn elements_of_entities(&mut self) -> Result<(), ImportError> {
        self.elements = true;
        let start = self.cursor.next_at();
        let blocks = self.cursor.size("the number of blocks of elements")?;
        let total = self.cursor.size("the number of elements")?;
        self.cursor.size("the smallest number of an element")?;
        self.cursor.size("the largest number of an element")?;
        let mut read = 0;
        for _ in 0..blocks {
            let dimension = self.cursor.integer("a dimension")?;
            let entity = self.cursor.integer("the number of an entity")?;
            let element = self.element_type()?;
            let count = self.cursor.size("the number of elements of a block")?;
            let physical = self.entities.get(&(dimension, entity));
            let set = self.content.tag_set(physical.cloned().unwrap_or_default());
            for _ in 0..count {
                let label = self.cursor.size("the number of an element")?;
                self.add_element(element, label, set, |reader| {
                    reader.cursor.size("the number of a node")
                })?;
                read += 1;
            }
        }
        self.agree(start, total, read, "elements")
    }
}
