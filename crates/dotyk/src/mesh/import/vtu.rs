//! VTU files (VTK's XML unstructured grids): one piece, arrays as text, base64 or appended, raw or zlib.
//!
//! The groups of cells and of their edges are the numbers of an integer cell array `gmsh:physical` or `group`; zero is
//! no group. Other arrays are reported. Compressed data may unpack to a hundred times the file: real coordinates and node numbers
//! stay below that, only data made to fill a memory exceed it. The tags are read one after the other up to appended data, which may
//! be any bytes that are not XML: a tree of the whole document would be impossible. Entities defined by a document are not expanded.
//! Source: VTK file formats, section "XML file formats" (vtk.org).

use crate::mesh::import::content::{Content, ElementType};
use crate::mesh::import::error::{FilePlace, ImportError};
use crate::mesh::{CellKind, MAX_CELL_NODES};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::cell::Cell;
use std::fmt::Display;
use std::io::Read;

/// Largest ratio of the bytes of all arrays to those of the file.
const EXPANSION: usize = 100;

/// Cell arrays that hold groups.
const GROUPS: [&str; 2] = ["gmsh:physical", "group"];

/// VTK's number, name, dimension, order and nodes of kinds that are not supported; zero nodes: any number.
const OTHER_TYPES: [(i64, &str, u8, u8, usize); 25] = [
    (1, "point", 0, 0, 1),
    (2, "set of points", 0, 0, 0),
    (4, "line of several pieces", 1, 1, 0),
    (6, "strip of triangles", 2, 1, 0),
    (7, "polygon", 2, 1, 0),
    (14, "pyramid5", 3, 1, 5),
    (15, "prism of a pentagon", 3, 1, 10),
    (16, "prism of a hexagon", 3, 1, 12),
    (27, "pyramid13", 3, 2, 13),
    (30, "quadrilateral of order 2 by 1 (6 nodes)", 2, 2, 6),
    (31, "prism of order 2 by 1 (12 nodes)", 3, 2, 12),
    (33, "hexahedron of 24 nodes", 3, 2, 24),
    (34, "tri7", 2, 2, 7),
    (35, "line", 1, 3, 4),
    (36, "polygon of order 2", 2, 2, 0),
    (37, "pyramid19", 3, 2, 19),
    (41, "convex set of points", 3, 1, 0),
    (42, "polyhedron", 3, 1, 0),
    (68, "line of Lagrange", 1, 1, 0),
    (69, "triangle of Lagrange", 2, 1, 0),
    (70, "quadrilateral of Lagrange", 2, 1, 0),
    (71, "tetrahedron of Lagrange", 3, 1, 0),
    (72, "hexahedron of Lagrange", 3, 1, 0),
    (73, "prism of Lagrange", 3, 1, 0),
    (74, "pyramid of Lagrange", 3, 1, 0),
];

/// VTK's numbers of Lagrange's cells of any order, and the kinds of first and second order that list their nodes alike.
const LAGRANGE: [(i64, &[CellKind]); 6] = [
    (68, &[CellKind::Line2, CellKind::Line3]),
    (69, &[CellKind::Tri3, CellKind::Tri6]),
    (70, &[CellKind::Quad4, CellKind::Quad9]),
    (71, &[CellKind::Tet4, CellKind::Tet10]),
    (72, &[CellKind::Hex8]),
    (73, &[CellKind::Prism6]),
];

/// VTK's numbers of cells along the axes, whose corners run in rows and not around: two of each row change places.
const ALONG_AXES: [(i64, CellKind, &[[usize; 2]]); 2] = [
    (8, CellKind::Quad4, &[[2, 3]]),
    (11, CellKind::Hex8, &[[2, 3], [6, 7]]),
];

/// The kind of a cell by VTK's number and its number of nodes.
fn known(number: i64, nodes: usize) -> Option<ElementType> {
    let ours = |kind: &CellKind| i64::from(kind.vtk()) == number;
    let along = ALONG_AXES.iter().find(|cell| cell.0 == number);
    let lagrange = LAGRANGE.iter().find(|cell| cell.0 == number);
    let lagrange = lagrange.and_then(|cell| cell.1.iter().find(|k| k.nodes() == nodes));
    let ours = CellKind::ALL.into_iter().find(ours);
    let ours = ours.or(along.map(|cell| cell.1)).or(lagrange.copied());
    if let Some(kind) = ours {
        return Some(ElementType::of(kind));
    }
    let other = OTHER_TYPES.iter().find(|other| other.0 == number);
    other.map(|&(_, name, dimension, order, nodes)| ElementType {
        name,
        dimension,
        nodes,
        order,
    })
}

/// The nodes of a cell in our order, from those of the file.
fn reorder(number: i64, nodes: &mut [u32]) {
    let along = ALONG_AXES.iter().find(|cell| cell.0 == number);
    let swaps = along.into_iter().flat_map(|(_, _, swaps)| *swaps);
    swaps.for_each(|&[a, b]| nodes.swap(a, b));
}

/// Whether the bytes look like a VTK file.
pub(crate) fn recognised(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    find(start, b"<VTKFile").is_some()
}

/// Reads a VTU file.
pub(crate) fn read(file: &str, bytes: &[u8], dimension: u8) -> Result<Content, ImportError> {
    let document = Document::scan(file, bytes)?;
    let mut content = Content::new(dimension);
    content.points = document.points()?;
    document.cells(&mut content)?;
    let left_out = document.arrays.iter().filter(|array| {
        ["PointData", "CellData", "FieldData"].contains(&array.parent.as_str())
            && !(array.parent == "CellData" && GROUPS.contains(&array.name.as_str()))
    });
    let names: Vec<String> = left_out.map(|array| format!("`{}`", array.name)).collect();
    if !names.is_empty() {
        let remark = format!("data arrays are left out: {}", names.join(", "));
        content.remarks.push(remark);
    }
    Ok(content)
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|w| w == wanted)
}

/// A tag that opens or is empty.
struct Tag {
    name: String,
    attributes: Vec<(String, String)>,
    at: usize,
}

impl Tag {
    fn new(start: &BytesStart<'_>, at: usize) -> Result<Self, quick_xml::Error> {
        let attributes = start.attributes().map(|attribute| {
            let attribute = attribute?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0)?;
            Ok((attribute.key.0.to_string(), value.into_owned()))
        });
        Ok(Self {
            name: start.name().0.to_string(),
            attributes: attributes.collect::<Result<_, quick_xml::Error>>()?,
            at,
        })
    }

    fn attribute(&self, key: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(k, _)| k == key);
        found.map(|(_, value)| value.as_str())
    }
}

/// A data array, not yet decoded.
struct Array<'b> {
    parent: String,
    name: String,
    kind: String,
    format: String,
    /// Place in the appended data.
    offset: Option<usize>,
    /// The text between the tags.
    inline: &'b [u8],
    /// Byte of its tag.
    at: usize,
    /// Byte after its tag.
    open: usize,
}

/// Where the bytes of arrays may be appended.
struct Appended<'b> {
    raw: bool,
    data: &'b [u8],
}

/// The tags that matter, and how numbers are stored.
struct Document<'b> {
    file: &'b str,
    big_endian: bool,
    /// Bytes of the counts before the data of an array.
    header: usize,
    compressed: bool,
    pieces: usize,
    /// Of points and cells.
    counts: [usize; 2],
    /// Name of the tag that the next arrays belong to.
    parent: String,
    arrays: Vec<Array<'b>>,
    appended: Option<Appended<'b>>,
    /// Bytes that arrays may still unpack to.
    left: Cell<usize>,
}

impl<'b> Document<'b> {
    fn scan(file: &'b str, bytes: &'b [u8]) -> Result<Self, ImportError> {
        let mut document = Self {
            file,
            big_endian: false,
            header: 4,
            compressed: false,
            pieces: 0,
            counts: [0; 2],
            parent: String::new(),
            arrays: Vec::new(),
            appended: None,
            left: Cell::new(EXPANSION.saturating_mul(bytes.len())),
        };
        let mut closed = false;
        let mut reader = Reader::from_reader(bytes);
        loop {
            let at = reader.buffer_position() as usize;
            let event = reader.read_event();
            let event =
                event.map_err(|e| broken_tag(file, reader.error_position() as usize, &e))?;
            let end = reader.buffer_position() as usize;
            match event {
                Event::Start(start) | Event::Empty(start) => {
                    let tag = Tag::new(&start, at).map_err(|e| broken_tag(file, at, &e))?;
                    if tag.name == "AppendedData" {
                        // The following bytes are arbitrary.
                        document.append(&tag, &bytes[end..])?;
                        return Ok(document);
                    }
                    document.open(tag, end)?;
                }
                // The text of the array opened last; only its first piece if comments interrupt it.
                Event::Text(_) => {
                    if let Some(array) = document.arrays.last_mut().filter(|a| a.open == at) {
                        array.inline = &bytes[at..end];
                    }
                }
                Event::End(tag) => closed |= tag.name().0 == "VTKFile",
                Event::Eof if closed => return Ok(document),
                Event::Eof => return Err(broken_tag(file, at, &"a tag is not closed")),
                _ => {}
            }
        }
    }

    /// Handles a tag; `end` is the byte after it.
    fn open(&mut self, tag: Tag, end: usize) -> Result<(), ImportError> {
        match tag.name.as_str() {
            "VTKFile" => self.attributes(&tag)?,
            "Piece" => self.piece(&tag)?,
            "Points" | "Cells" | "CellData" | "PointData" | "FieldData" => self.parent = tag.name,
            "DataArray" | "Array" => self.arrays.push(array(&tag, &self.parent, end)),
            _ => {}
        }
        Ok(())
    }

    /// Handles appended data; `rest` are the bytes after their tag.
    fn append(&mut self, tag: &Tag, rest: &'b [u8]) -> Result<(), ImportError> {
        let Some(start) = find(rest, b"_") else {
            return Err(broken_tag(self.file, tag.at, &"no data follow behind `_`"));
        };
        self.appended = Some(Appended {
            raw: tag.attribute("encoding") == Some("raw"),
            data: &rest[start + 1..],
        });
        Ok(())
    }

    fn unsupported(&self, what: impl Into<String>) -> ImportError {
        ImportError::Unsupported {
            file: self.file.to_string(),
            what: what.into(),
        }
    }

    fn attributes(&mut self, tag: &Tag) -> Result<(), ImportError> {
        let kind = tag.attribute("type").unwrap_or("");
        if kind != "UnstructuredGrid" {
            let what =
                format!("VTK files of the type {kind} are not read, only UnstructuredGrid (.vtu)");
            return Err(self.unsupported(what));
        }
        self.big_endian = tag.attribute("byte_order") == Some("BigEndian");
        self.header = match tag.attribute("header_type") {
            Some("UInt64") => 8,
            _ => 4,
        };
        self.compressed = match tag.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                let what = format!(
                    "data compressed by {other} are not read: write the file with zlib, or uncompressed"
                );
                return Err(self.unsupported(what));
            }
        };
        Ok(())
    }

    fn piece(&mut self, tag: &Tag) -> Result<(), ImportError> {
        self.pieces += 1;
        if self.pieces > 1 {
            let what = "the grid comes in several pieces: merge them into one file";
            return Err(self.unsupported(what));
        }
        let keys = ["NumberOfPoints", "NumberOfCells"];
        for (count, key) in self.counts.iter_mut().zip(keys) {
            let value = tag.attribute(key).and_then(|text| text.trim().parse().ok());
            *count = value.ok_or_else(|| {
                let what = format!("the piece needs the attribute {key}, an integer");
                document_error(self.file, "Piece", tag.at, &what)
            })?;
        }
        Ok(())
    }

    fn error(&self, array: &Array<'_>, what: &str) -> ImportError {
        document_error(
            self.file,
            &format!("array `{}`", array.name),
            array.at,
            what,
        )
    }

    /// The array of a name, or the only one of Points.
    fn array(&self, parent: &str, name: Option<&str>) -> Result<&Array<'b>, ImportError> {
        let mut arrays = self.arrays.iter();
        let found = arrays.find(|a| a.parent == parent && name.is_none_or(|n| n == a.name));
        found.ok_or_else(|| {
            let name = name.map_or(String::new(), |name| format!(" `{name}`"));
            self.unsupported(format!("there is no data array{name} in {parent}"))
        })
    }

    fn points(&self) -> Result<Vec<[f64; 3]>, ImportError> {
        let array = self.array("Points", None)?;
        let values = self.numbers(array)?;
        if values.len() != self.counts[0].saturating_mul(3) {
            let what = format!(
                "{} points have {} coordinates, 3 each are needed",
                self.counts[0],
                values.len()
            );
            return Err(self.error(array, &what));
        }
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return Err(self.error(
                array,
                &format!("a coordinate must be finite, found {value}"),
            ));
        }
        Ok(values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect())
    }

    /// The elements with their groups, numbered from 0 as VTK does.
    fn cells(&self, content: &mut Content) -> Result<(), ImportError> {
        let connectivity = self.array("Cells", Some("connectivity"))?;
        let nodes = self.integers(connectivity)?;
        let offsets_array = self.array("Cells", Some("offsets"))?;
        let offsets = self.integers(offsets_array)?;
        let types_array = self.array("Cells", Some("types"))?;
        let types = self.integers(types_array)?;
        for (array, length) in [(offsets_array, offsets.len()), (types_array, types.len())] {
            if length != self.counts[1] {
                let what = format!("{} cells have {length} entries", self.counts[1]);
                return Err(self.error(array, &what));
            }
        }
        let groups = self.groups()?;
        let mut start = 0;
        for (cell, (&end, &kind)) in offsets.iter().zip(&types).enumerate() {
            let slice = usize::try_from(end)
                .ok()
                .and_then(|end| nodes.get(start..end));
            let slice = slice.ok_or_else(|| {
                let what = format!("cell {cell} ends at {end}, there are {} nodes of cells and it starts at {start}", nodes.len());
                self.error(offsets_array, &what)
            })?;
            start += slice.len();
            let element = self.element(types_array, cell, kind, slice.len())?;
            let mut own = [0; MAX_CELL_NODES];
            for (place, &node) in slice.iter().enumerate() {
                let index = u32::try_from(node)
                    .ok()
                    .filter(|&n| (n as usize) < self.counts[0]);
                let index = index.ok_or_else(|| {
                    let what = format!(
                        "cell {cell} names point {node}, there are {}",
                        self.counts[0]
                    );
                    self.error(connectivity, &what)
                })?;
                // Kinds with more nodes are counted only.
                if let Some(slot) = own.get_mut(place) {
                    *slot = index;
                }
            }
            let tags = content.tag_set(groups.get(cell).copied().into_iter().collect());
            let used = &mut own[..slice.len().min(MAX_CELL_NODES)];
            reorder(kind, used);
            content.add(element, cell as u64, used, tags);
        }
        Ok(())
    }

    fn element(
        &self,
        array: &Array<'_>,
        cell: usize,
        kind: i64,
        nodes: usize,
    ) -> Result<ElementType, ImportError> {
        let Some(element) = known(kind, nodes) else {
            let what = format!(
                "cell {cell} is of VTK's type {kind}, which is not known: mesh with first or second order"
            );
            return Err(self.error(array, &what));
        };
        if element.nodes != nodes && element.nodes > 0 {
            let (name, count) = (element.name, element.nodes);
            let what = format!("cell {cell} is a {name} and has {nodes} nodes, {count} are needed");
            return Err(self.error(array, &what));
        }
        Ok(element)
    }

    /// The number of the group of each cell; empty where the file has none.
    fn groups(&self) -> Result<Vec<i64>, ImportError> {
        let mut arrays = self
            .arrays
            .iter()
            .filter(|array| array.parent == "CellData");
        let Some(array) = arrays.find(|array| GROUPS.contains(&array.name.as_str())) else {
            return Ok(Vec::new());
        };
        let groups = self.integers(array)?;
        if groups.len() != self.counts[1] {
            let what = format!("{} cells have {} groups", self.counts[1], groups.len());
            return Err(self.error(array, &what));
        }
        Ok(groups)
    }

    fn integers(&self, array: &Array<'_>) -> Result<Vec<i64>, ImportError> {
        if array.kind.starts_with("Float") {
            return Err(self.error(array, "the numbers must be integers"));
        }
        let values = self.numbers(array)?;
        // Indices and tags are below 2^53, where a double holds every integer.
        Ok(values.iter().map(|value| *value as i64).collect())
    }

    /// The numbers of an array.
    fn numbers(&self, array: &Array<'_>) -> Result<Vec<f64>, ImportError> {
        if array.format == "ascii" {
            let text = String::from_utf8_lossy(array.inline);
            let words = text.split_whitespace().map(|word| {
                word.parse().map_err(|_| {
                    self.error(array, &format!("expected a number, found `{word:.40}`"))
                })
            });
            return words.collect();
        }
        let bytes = self.bytes(array)?;
        let big = self.big_endian;
        macro_rules! decoded {
            ($kind:ty) => {
                bytes
                    .chunks_exact(size_of::<$kind>())
                    .filter_map(|chunk| chunk.try_into().ok())
                    .map(|chunk| match big {
                        true => <$kind>::from_be_bytes(chunk) as f64,
                        false => <$kind>::from_le_bytes(chunk) as f64,
                    })
                    .collect()
            };
        }
        Ok(match array.kind.as_str() {
            "Float64" => decoded!(f64),
            "Float32" => decoded!(f32),
            "Int64" => decoded!(i64),
            "Int32" => decoded!(i32),
            "Int16" => decoded!(i16),
            "Int8" => decoded!(i8),
            "UInt64" => decoded!(u64),
            "UInt32" => decoded!(u32),
            "UInt16" => decoded!(u16),
            "UInt8" => decoded!(u8),
            other => {
                return Err(self.error(array, &format!("numbers of the type {other} are not read")));
            }
        })
    }

    /// The bytes of an array that is not text: after their counts, unpacked.
    fn bytes(&self, array: &Array<'b>) -> Result<Vec<u8>, ImportError> {
        let mut stream: Box<dyn Iterator<Item = u8> + '_> = match array.format.as_str() {
            "binary" => Box::new(base64(array.inline)),
            "appended" => {
                let appended = self.appended.as_ref();
                let appended =
                    appended.ok_or_else(|| self.error(array, "there are no appended data"))?;
                let data = array.offset.and_then(|offset| appended.data.get(offset..));
                let data = data
                    .ok_or_else(|| self.error(array, "its offset lies beyond the appended data"))?;
                match appended.raw {
                    true => Box::new(data.iter().copied()),
                    false => Box::new(base64(data)),
                }
            }
            other => return Err(self.error(array, &format!("the format `{other}` is not read"))),
        };
        let short = || self.error(array, "the data end too early: the file is cut off");
        let mut count = || -> Result<usize, ImportError> {
            let mut word: Vec<u8> = stream.by_ref().take(self.header).collect();
            if word.len() < self.header {
                return Err(short());
            }
            if self.big_endian {
                word.reverse();
            }
            let value = word
                .iter()
                .rev()
                .fold(0u64, |value, &byte| value << 8 | u64::from(byte));
            usize::try_from(value).map_err(|_| short())
        };
        if !self.compressed {
            let length = count()?;
            let bytes: Vec<u8> = stream.take(length).collect();
            return if bytes.len() == length {
                Ok(bytes)
            } else {
                Err(short())
            };
        }
        let (blocks, size, _) = (count()?, count()?, count()?);
        let lengths = (0..blocks)
            .map(|_| count())
            .collect::<Result<Vec<_>, _>>()?;
        let mut bytes = Vec::new();
        for length in lengths {
            let packed: Vec<u8> = stream.by_ref().take(length).collect();
            let most = size.min(self.left.get().saturating_add(1));
            let unpacked = ZlibDecoder::new(&packed[..])
                .take(most as u64)
                .read_to_end(&mut bytes);
            let unpacked = unpacked
                .map_err(|e| self.error(array, &format!("the data cannot be unpacked: {e}")))?;
            let left = self.left.get().checked_sub(unpacked).ok_or_else(|| {
                self.unsupported(format!(
                    "its data unpack to more than {EXPANSION} times the file: no mesh does"
                ))
            })?;
            self.left.set(left);
        }
        Ok(bytes)
    }
}

fn document_error(file: &str, section: &str, offset: usize, what: &str) -> ImportError {
    ImportError::Malformed {
        file: file.to_string(),
        place: FilePlace::Byte {
            section: section.to_string(),
            offset,
        },
        what: what.to_string(),
    }
}

/// The error of a file that ends too early or is not XML.
fn broken_tag(file: &str, at: usize, why: &dyn Display) -> ImportError {
    let what = format!("{why}: the file is cut off or spoilt, write it again");
    document_error(file, "a tag", at, &what)
}

fn array<'b>(tag: &Tag, parent: &str, open: usize) -> Array<'b> {
    let text = |key: &str| tag.attribute(key).unwrap_or("").to_string();
    Array {
        parent: parent.to_string(),
        name: text("Name"),
        kind: text("type"),
        format: text("format"),
        offset: tag
            .attribute("offset")
            .and_then(|offset| offset.parse().ok()),
        inline: &[],
        at: tag.at,
        open,
    }
}

/// Decodes base64 (RFC 4648) up to the first other character. Padding may occur inside: parts of an array are coded separately.
fn base64(text: &[u8]) -> impl Iterator<Item = u8> + '_ {
    let mut symbols = text.iter().filter(|byte| !byte.is_ascii_whitespace());
    let mut symbol = move || symbols.next().copied();
    let parts = std::iter::from_fn(move || {
        let four = [symbol()?, symbol()?, symbol()?, symbol()?];
        let mut three = [0; 3];
        let length = STANDARD.decode_slice(four, &mut three).ok()?;
        Some(three.into_iter().take(length))
    });
    parts.flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_that_meshes_consist_of_are_not_listed_again() {
        for kind in CellKind::ALL {
            let number = i64::from(kind.vtk());
            assert!(
                OTHER_TYPES.iter().all(|other| other.0 != number),
                "{number}"
            );
            assert_eq!(known(number, 0), Some(ElementType::of(kind)));
        }
        let called = |number, nodes| known(number, nodes).map(|kind| kind.to_string());
        assert_eq!(called(13, 6).as_deref(), Some("prism6"));
        assert_eq!(called(70, 9).as_deref(), Some("quad9"));
        assert_eq!(called(70, 16).as_deref(), Some("quadrilateral of Lagrange"));
        assert_eq!(called(42, 17).as_deref(), Some("polyhedron"));
        assert_eq!(called(35, 4).as_deref(), Some("line of order 3 (4 nodes)"));
        assert_eq!(called(3333, 2), None);
    }
}
