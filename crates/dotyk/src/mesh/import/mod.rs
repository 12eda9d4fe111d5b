//! Meshes from files: Gmsh `.msh` of versions 1, 2 and 4 (text and binary), and VTU.
//!
//! A file is read for bodies of the plane or of space. It holds cells and edges, in space cells and faces, in groups. A body
//! is made of all cells or of some groups of them; the groups of edges or faces on its boundary are its sides, and `boundary`
//! is the whole boundary where no such group has that name. Groups of points name nodes.
//! Points and cells keep the order of the file, second-order cells their middle nodes. In the plane x and y are the
//! coordinates, z must be the same everywhere in the body.
//!
//! Names: a group is called by its physical name, without one by its number. Runs of characters other than letters of
//! ASCII, digits, `_` and `-` become one `_`, with a warning, so that the name can stand in a case file.
//! Nothing is guessed: data without a meaning for a body are listed in the warnings, and unsupported data that a body would
//! need are an error. Coincident nodes are not merged.

mod body;
mod content;
mod cursor;
mod error;
mod gmsh;
mod groups;
mod parts;
mod remarks;
pub(crate) mod stl;
mod vtu;

pub use body::Imported;
pub use error::{FilePlace, ImportError};

use crate::mesh::import::content::{Content, NamedNode, ReadCell, ReadSide, Refused};
use crate::mesh::import::cursor::Cursor;
use crate::mesh::import::error::solids;
use crate::mesh::import::groups::Groups;
use crate::mesh::import::remarks::described;
use std::collections::HashMap;
use std::path::Path;

/// A mesh file, read and checked: the bodies of one or several cases can be cut out of it.
///
/// ```no_run
/// # use dotyk::mesh::MeshFile;
/// let file = MeshFile::read("part.msh".as_ref())?;
/// let rock = file.mesh(&["rock"])?;
/// println!("{} cells, warnings: {:?}", rock.mesh.cell_count(), rock.warnings);
/// # Ok::<(), dotyk::mesh::ImportError>(())
/// ```
#[derive(Debug, Clone)]
pub struct MeshFile {
    name: String,
    /// Of the bodies that it is read for.
    dimension: u8,
    points: Vec<[f64; 3]>,
    cells: Vec<ReadCell>,
    sides: Vec<ReadSide>,
    nodes: Vec<NamedNode>,
    refused: Vec<Refused>,
    /// Groups by the index that elements hold.
    cell_sets: Vec<Vec<usize>>,
    side_sets: Vec<Vec<usize>>,
    node_sets: Vec<Vec<usize>>,
    cell_groups: Groups,
    side_groups: Groups,
    point_groups: Groups,
    warnings: Vec<String>,
}

impl MeshFile {
    /// Reads a file for bodies of the plane; its content tells the format.
    ///
    /// Errors: a file that cannot be read or has no known format; violations of the format, with line, or section and byte;
    /// versions and features that are not read; groups whose names are indistinguishable; no cells.
    pub fn read(path: &Path) -> Result<Self, ImportError> {
        Self::open(path, 2)
    }

    /// Reads a file for bodies of space.
    ///
    /// Errors: as [`Self::read`].
    pub fn read_solid(path: &Path) -> Result<Self, ImportError> {
        Self::open(path, 3)
    }

    fn open(path: &Path, dimension: u8) -> Result<Self, ImportError> {
        let files = parts::files(path)?.into_iter().map(|path| {
            let file = path.display().to_string();
            match crate::host::read(&path) {
                Ok(bytes) => Ok((file, bytes)),
                Err(why) => Err(ImportError::Unreadable { file, why }),
            }
        });
        let files: Vec<(String, Vec<u8>)> = files.collect::<Result<_, _>>()?;
        let files: Vec<(&str, &[u8])> = files.iter().map(|(n, b)| (n.as_str(), &b[..])).collect();
        Self::parse(&path.display().to_string(), &files, dimension)
    }

    /// Reads the content of a file that messages call `name`, for bodies of the plane.
    ///
    /// Errors: as [`Self::read`].
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, ImportError> {
        Self::parse(name, &[(name, bytes)], 2)
    }

    /// The same for bodies of space.
    ///
    /// Errors: as [`Self::read`].
    pub fn solid_from_bytes(name: &str, bytes: &[u8]) -> Result<Self, ImportError> {
        Self::parse(name, &[(name, bytes)], 3)
    }

    /// Reads a mesh of one or, with partitions in files of their own, several files.
    fn parse(name: &str, files: &[(&str, &[u8])], dimension: u8) -> Result<Self, ImportError> {
        let mut cursors = Vec::new();
        for &(file, bytes) in files {
            let mut cursor = Cursor::new(file, bytes);
            cursor.skip_space();
            if bytes.get(cursor.at()) == Some(&b'$') {
                cursors.push(cursor);
            } else if vtu::recognised(bytes) && files.len() == 1 {
                return Self::new(name, vtu::read(file, bytes, dimension)?);
            } else {
                return Err(cursor.unsupported(
                    "this is neither a Gmsh mesh (.msh, which begins with $MeshFormat or $NOD) nor a VTU file",
                ));
            }
        }
        Self::new(name, gmsh::read(cursors, dimension)?)
    }

    fn new(name: &str, mut content: Content) -> Result<Self, ImportError> {
        let repeated = drop_repeated(name, &mut content)?;
        let of_cells = content.dimension;
        let groups =
            |dimension| Groups::new(name, dimension, &content.used(dimension), &content.names);
        let cell_groups = groups(of_cells)?;
        let side_groups = groups(of_cells - 1)?;
        let point_groups = groups(0)?;
        let mut file = Self {
            name: name.to_string(),
            dimension: of_cells,
            cell_sets: cell_groups.sets(&content.tags),
            side_sets: side_groups.sets(&content.tags),
            node_sets: point_groups.sets(&content.tags),
            cell_groups,
            side_groups,
            point_groups,
            warnings: Vec::new(),
            points: std::mem::take(&mut content.points),
            cells: std::mem::take(&mut content.cells),
            sides: std::mem::take(&mut content.sides),
            nodes: std::mem::take(&mut content.nodes),
            refused: std::mem::take(&mut content.refused),
        };
        let cells = |r: &Refused| r.element.dimension == of_cells;
        if file.cells.is_empty() && !file.refused.iter().any(cells) {
            return Err(file.no_cells());
        }
        file.warnings = file.remarks(&content, repeated);
        Ok(file)
    }

    fn no_cells(&self) -> ImportError {
        let mut found: Vec<String> = self.refused.iter().map(described).collect();
        if !self.sides.is_empty() {
            found.push(format!("{} {}", self.sides.len(), self.sides_word()));
        }
        let (mesh, parts) = match self.dimension {
            2 => ("mesh in 2D, and ", "surfaces"),
            _ => ("mesh in 3D, and ", "volumes"),
        };
        // a surface mesh of space is not just a mistake of groups
        let again = if self.dimension == 2 { "" } else { mesh };
        let flat = self.dimension == 3 && !self.sides.is_empty() && self.is_flat();
        ImportError::NoCells {
            file: self.name.clone(),
            cells: match self.dimension {
                2 => "of the plane (triangles or quadrilaterals)",
                _ => "of space (tetrahedra, hexahedra or prisms)",
            },
            found: match (found.len(), self.of_space()) {
                (0, _) => format!(
                    "it has no elements at all: in Gmsh, {mesh}put the {parts} in physical groups"
                ),
                (_, 0) if flat => format!(
                    "it has {}, all at one z: a mesh of the plane, whose bodies need an `analysis` of the plane (plane-strain, plane-stress or axisymmetric)",
                    found.join(", ")
                ),
                (_, solid) => format!(
                    "it has {}: in Gmsh, {again}put the {parts} in physical groups, or save all elements{}",
                    found.join(", "),
                    if self.dimension == 2 {
                        solids(solid)
                    } else {
                        String::new()
                    }
                ),
            },
        }
    }

    /// Cells of space, where the file is read for bodies of the plane.
    fn of_space(&self) -> usize {
        let solid = self.refused.iter().filter(|r| r.element.dimension == 3);
        solid.map(|r| r.count).sum()
    }

    /// Whether all nodes have one z.
    fn is_flat(&self) -> bool {
        let mut heights = self.points.iter().map(|point| point[2]);
        let first = heights.next();
        heights.all(|z| Some(z) == first)
    }

    /// Elements of sides.
    fn sides_word(&self) -> &'static str {
        match self.dimension {
            2 => "edges",
            _ => "faces",
        }
    }

    /// Where cells are, for messages.
    fn space_word(&self) -> &'static str {
        match self.dimension {
            2 => "the plane",
            _ => "space",
        }
    }

    /// Names of the groups of cells, by ascending tag.
    pub fn cell_groups(&self) -> &[String] {
        &self.cell_groups.names
    }

    /// Names of the groups of edges, in space of faces, by ascending tag.
    pub fn side_groups(&self) -> &[String] {
        &self.side_groups.names
    }

    /// Names of the groups of points, by ascending tag.
    pub fn point_groups(&self) -> &[String] {
        &self.point_groups.names
    }

    /// Remarks on omitted or renamed parts of the whole file, which name the file.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// Keeps the first of equal cells, with the groups of all of them; returns how many were dropped without bringing a group.
///
/// Version 2.2 of the format repeats an element for each of its groups.
fn drop_repeated(file: &str, content: &mut Content) -> Result<usize, ImportError> {
    let mut seen: HashMap<[u32; 8], usize> = HashMap::new();
    let mut kept: Vec<ReadCell> = Vec::with_capacity(content.cells.len());
    let mut repeated = 0;
    for cell in std::mem::take(&mut content.cells) {
        let Some(&place) = seen.get(&cell.corners()) else {
            seen.insert(cell.corners(), kept.len());
            kept.push(cell);
            continue;
        };
        let first = &mut kept[place];
        let sorted = |cell: &ReadCell| {
            let mut nodes = cell.nodes;
            nodes.sort_unstable();
            nodes
        };
        if first.kind != cell.kind || sorted(first) != sorted(&cell) {
            return Err(ImportError::Overlap {
                file: file.to_string(),
                first: first.number,
                second: cell.number,
            });
        }
        let tags = |cell: &ReadCell| content.tags[cell.tags as usize].clone();
        let both = union(tags(first), tags(&cell));
        repeated += usize::from(both.len() == content.tags[first.tags as usize].len());
        first.tags = content.tag_set(both);
    }
    content.cells = kept;
    Ok(repeated)
}

fn union(mut a: Vec<i64>, b: Vec<i64>) -> Vec<i64> {
    a.extend(b);
    a.sort_unstable();
    a.dedup();
    a
}
