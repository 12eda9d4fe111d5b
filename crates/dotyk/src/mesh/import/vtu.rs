//! VTU files (VTK's XML unstructured grids): one piece, arrays as text, base64 or appended, raw or zlib.
//!
//! The groups of cells and of their edges are the numbers of an integer cell array `gmsh:physical` or `group`; zero is
//! no group. Other arrays are reported. Only as much XML is read as these files use: tags with attributes, no entities.
//! Source: VTK file formats, section "XML file formats" (vtk.org).

use crate::mesh::MAX_CELL_NODES;
use crate::mesh::import::content::{Content, ElementType};
use crate::mesh::import::error::{FilePlace, ImportError};
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Cell arrays that hold groups.
const GROUPS: [&str; 2] = ["gmsh:physical", "group"];

/// VTK's number, name, dimension and nodes of the kinds that are known.
const TYPES: [(i64, &str, u8, usize); 21] = [
    (1, "point", 0, 1),
    (3, "line2", 1, 2),
    (5, "tri3", 2, 3),
    (8, "pixel", 2, 4),
    (9, "quad4", 2, 4),
    (10, "tet4", 3, 4),
    (11, "voxel", 3, 8),
    (12, "hex8", 3, 8),
    (13, "prism6", 3, 6),
    (14, "pyramid5", 3, 5),
    (21, "line3", 1, 3),
    (22, "tri6", 2, 6),
    (23, "quad8", 2, 8),
    (24, "tet10", 3, 10),
    (25, "hex20", 3, 20),
    (26, "prism15", 3, 15),
    (27, "pyramid13", 3, 13),
    (28, "quad9", 2, 9),
    (29, "hex27", 3, 27),
    (34, "tri7", 2, 7),
    (35, "line4", 1, 4),
];

/// Whether the bytes look like a VTK file.
pub(crate) fn recognised(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    find(start, b"<VTKFile").is_some()
}

/// Reads a VTU file.
pub(crate) fn read(file: &str, bytes: &[u8]) -> Result<Content, ImportError> {
    let document = Document::scan(file, bytes)?;
    let mut content = Content::default();
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

/// A tag and the place behind it.
struct Tag {
    /// With a slash in front where it closes.
    name: String,
    attributes: Vec<(String, String)>,
    /// It ends with a slash.
    empty: bool,
    at: usize,
    end: usize,
}

impl Tag {
    /// The next tag from a byte on, comments and the XML declaration left out; `Err` holds the place of one that does
    /// not end.
    fn next(bytes: &[u8], from: usize) -> Result<Option<Self>, usize> {
        let mut from = from;
        loop {
            let Some(offset) = find(&bytes[from..], b"<") else {
                return Ok(None);
            };
            let at = from + offset;
            let rest = &bytes[at..];
            let (end, mark): (&[u8], _) = match rest {
                [b'<', b'!', b'-', b'-', ..] => (b"-->", true),
                [b'<', b'?' | b'!', ..] => (b">", true),
                _ => (b">", false),
            };
            let length = find(rest, end).ok_or(at)?;
            from = at + length + end.len();
            if mark {
                continue;
            }
            let text = String::from_utf8_lossy(&rest[1..length]);
            let text = text.trim();
            let inner = text.trim_end_matches('/');
            let name = inner.split_whitespace().next().unwrap_or("");
            return Ok(Some(Self {
                name: name.to_string(),
                attributes: attributes(&inner[name.len()..]),
                empty: text.ends_with('/'),
                at,
                end: from,
            }));
        }
    }

    fn attribute(&self, key: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(k, _)| k == key);
        found.map(|(_, value)| value.as_str())
    }
}

/// `key="value"` pairs; what is none ends them.
fn attributes(text: &str) -> Vec<(String, String)> {
    let mut pairs = Vec::new();
    let mut rest = text;
    while let Some((key, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let Some(quote) = after.chars().next().filter(|c| "\"'".contains(*c)) else {
            break;
        };
        let Some((value, behind)) = after[1..].split_once(quote) else {
            break;
        };
        pairs.push((key.trim().to_string(), value.to_string()));
        rest = behind;
    }
    pairs
}

/// A data array, not yet decoded.
struct Array<'b> {
    parent: String,
    name: String,
    kind: String,
    format: String,
    /// Place in the appended data.
    offset: Option<usize>,
    /// What stands between the tags.
    inline: &'b [u8],
    at: usize,
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
    counts: [usize; 2],
    arrays: Vec<Array<'b>>,
    appended: Option<Appended<'b>>,
}

impl<'b> Document<'b> {
    fn scan(file: &'b str, bytes: &'b [u8]) -> Result<Self, ImportError> {
        let mut document = Self {
            file,
            big_endian: false,
            header: 4,
            compressed: false,
            counts: [0; 2],
            arrays: Vec::new(),
            appended: None,
        };
        let (mut at, mut parent, mut pieces) = (0, String::new(), 0);
        let unclosed = |at| {
            document_error(
                file,
                "a tag",
                at,
                "the tag does not end: the file is cut off",
            )
        };
        while let Some(tag) = Tag::next(bytes, at).map_err(unclosed)? {
            at = tag.end;
            match tag.name.as_str() {
                "VTKFile" => document.attributes(&tag)?,
                "Piece" => {
                    pieces += 1;
                    document.piece(&tag, pieces)?;
                }
                "Points" | "Cells" | "CellData" | "PointData" | "FieldData" => parent = tag.name,
                "DataArray" | "Array" => {
                    let length = match tag.empty {
                        true => 0,
                        false => find(&bytes[at..], b"<").ok_or_else(|| unclosed(tag.at))?,
                    };
                    document
                        .arrays
                        .push(array(&tag, &parent, &bytes[at..at + length]));
                }
                "AppendedData" => {
                    let start = find(&bytes[at..], b"_").ok_or_else(|| unclosed(tag.at))?;
                    document.appended = Some(Appended {
                        raw: tag.attribute("encoding") == Some("raw"),
                        data: &bytes[at + start + 1..],
                    });
                    // What follows may be any bytes.
                    return Ok(document);
                }
                _ => {}
            }
        }
        if find(&bytes[bytes.len().saturating_sub(200)..], b"</VTKFile>").is_none() {
            return Err(unclosed(bytes.len()));
        }
        Ok(document)
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

    fn piece(&mut self, tag: &Tag, number: usize) -> Result<(), ImportError> {
        if number > 1 {
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
            let used = &own[..slice.len().min(MAX_CELL_NODES)];
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
        let Some(&(_, name, dimension, count)) = TYPES.iter().find(|known| known.0 == kind) else {
            let what = format!(
                "cell {cell} is of VTK's type {kind}, which is not known: mesh with triangles and quadrilaterals of first or second order"
            );
            return Err(self.error(array, &what));
        };
        if count != nodes {
            let what = format!("cell {cell} is a {name} and has {nodes} nodes, {count} are needed");
            return Err(self.error(array, &what));
        }
        Ok(ElementType {
            name,
            dimension,
            nodes,
        })
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

    /// The bytes of an array that is not text: behind their counts, unpacked.
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
            let unpacked = ZlibDecoder::new(&packed[..])
                .take(size as u64)
                .read_to_end(&mut bytes);
            unpacked
                .map_err(|e| self.error(array, &format!("the data cannot be unpacked: {e}")))?;
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

fn array<'b>(tag: &Tag, parent: &str, inline: &'b [u8]) -> Array<'b> {
    let text = |key: &str| tag.attribute(key).unwrap_or("").to_string();
    Array {
        parent: parent.to_string(),
        name: text("Name"),
        kind: text("type"),
        format: text("format"),
        offset: tag
            .attribute("offset")
            .and_then(|offset| offset.parse().ok()),
        inline,
        at: tag.at,
    }
}

/// Decodes base64 (RFC 4648) until something else comes. Padding may stand inside: parts of an array are coded apart.
fn base64(text: &[u8]) -> impl Iterator<Item = u8> + '_ {
    let mut symbols = text.iter().filter(|byte| !byte.is_ascii_whitespace());
    std::iter::from_fn(move || {
        let mut word = 0;
        let mut kept = 3;
        for _ in 0..4 {
            let symbol = *symbols.next()?;
            let digit = match symbol {
                b'A'..=b'Z' => symbol - b'A',
                b'a'..=b'z' => symbol - b'a' + 26,
                b'0'..=b'9' => symbol - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                b'=' => {
                    kept -= 1;
                    0
                }
                _ => return None,
            };
            word = word << 6 | u32::from(digit);
        }
        let [_, a, b, c] = word.to_be_bytes();
        Some(
            [a, b, c]
                .into_iter()
                .take(usize::try_from(kept).unwrap_or(0)),
        )
    })
    .flatten()
}
