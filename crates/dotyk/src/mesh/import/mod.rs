//! Meshes from files: Gmsh `.msh` 4.1 and 2.2 (text and binary), and VTU.
//!
//! A file holds cells and edges in groups. A body is made of all plane cells or of some groups of them; the groups of
//! edges on its boundary are its sides, and `boundary` is the whole boundary where no group of edges has that name.
//! Points and cells keep the order of the file, second-order cells their middle nodes. x and y are the coordinates, z
//! must be the same everywhere in the body.
//!
//! Names: a group is called by its physical name, without one by its number. Runs of characters other than letters of
//! ASCII, digits, `_` and `-` become one `_`, with a warning, so that the name can stand in a case file.
//! Nothing is guessed: what has no meaning for a plane body is listed in the warnings, and what a body would need but
//! is not supported is an error. Coincident nodes are not merged.

mod content;
mod cursor;
mod error;
mod gmsh;
mod vtu;

pub use error::{FilePlace, ImportError};

use crate::geometry::Point;
use crate::mesh::import::content::{Cell, Content, Edge, Refused};
use crate::mesh::import::cursor::Cursor;
use crate::mesh::{CellBlock, CellKind, Facet, FacetTable, Mesh, MeshError};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;

/// The side that every imported mesh has, unless a group of the file has its name.
const BOUNDARY: &str = "boundary";

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
    points: Vec<[f64; 3]>,
    cells: Vec<Cell>,
    edges: Vec<Edge>,
    refused: Vec<Refused>,
    /// Groups by the index that elements hold.
    cell_sets: Vec<Vec<usize>>,
    edge_sets: Vec<Vec<usize>>,
    cell_groups: Groups,
    edge_groups: Groups,
    warnings: Vec<String>,
}

/// A body's mesh, and what of the file is not in it.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The cells with their groups, and the sides.
    pub mesh: Mesh<2>,
    /// What was left out or may be unexpected, in words.
    pub warnings: Vec<String>,
    /// Groups of cells that the body does not contain.
    pub unused_cells: Vec<String>,
    /// Groups of edges that do not touch the body.
    pub unused_sides: Vec<String>,
    /// Cells of no group that the body does not contain.
    pub unused_loose: usize,
}

/// Groups of one dimension.
#[derive(Debug, Clone, Default)]
struct Groups {
    names: Vec<String>,
    /// As the file calls them; `None` where it gives a number only.
    originals: Vec<Option<String>>,
    tags: BTreeMap<i64, usize>,
}

impl Groups {
    /// The group that a user calls so: by its name here, or as in the file.
    fn find(&self, name: &str) -> Option<usize> {
        let called = |known: &String| known == name;
        let original = |known: &Option<String>| known.as_deref() == Some(name);
        let found = self.names.iter().position(called);
        found.or_else(|| self.originals.iter().position(original))
    }

    /// Groups of one dimension that elements belong to. Tags of one name are one group.
    fn new(
        file: &str,
        dimension: u8,
        used: &BTreeSet<i64>,
        names: &BTreeMap<(u8, i64), String>,
    ) -> Result<Self, ImportError> {
        let mut groups = Self::default();
        for &tag in used {
            let given = names.get(&(dimension, tag));
            let original = given.filter(|name| !name.trim().is_empty()).cloned();
            let called = original.clone().unwrap_or_else(|| tag.to_string());
            let name = valid_name(&called);
            let known = groups.names.iter().position(|known| *known == name);
            let index = match known {
                None => {
                    groups.names.push(name);
                    groups.originals.push(original);
                    groups.names.len() - 1
                }
                Some(index) if original.is_some() && groups.originals[index] == original => index,
                Some(index) => {
                    let first = groups.originals[index].clone();
                    return Err(ImportError::NameClash {
                        file: file.to_string(),
                        first: first.unwrap_or_else(|| groups.names[index].clone()),
                        second: called,
                        name,
                    });
                }
            };
            groups.tags.insert(tag, index);
        }
        Ok(groups)
    }

    /// Groups of each set of tags, ascending.
    fn sets(&self, tags: &[Vec<i64>]) -> Vec<Vec<usize>> {
        let of = |tags: &Vec<i64>| {
            let mut set: Vec<usize> = tags
                .iter()
                .filter_map(|t| self.tags.get(t).copied())
                .collect();
            set.sort_unstable();
            set.dedup();
            set
        };
        tags.iter().map(of).collect()
    }
}

/// A name that case files can use: each run of other characters is one `_`.
fn valid_name(text: &str) -> String {
    let mut name = String::new();
    let mut replaced = false;
    for c in text.trim().chars() {
        let valid = c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if valid {
            name.push(c);
        } else if !replaced {
            name.push('_');
        }
        replaced = !valid;
    }
    name
}

impl MeshFile {
    /// Reads a file; its content tells the format.
    ///
    /// Errors: a file that cannot be read or is of no known format; what breaks the rules of the format, with line, or
    /// section and byte; versions and features that are not read; groups whose names cannot be told apart; no cells.
    pub fn read(path: &Path) -> Result<Self, ImportError> {
        let unreadable = |why: String| ImportError::Unreadable {
            file: path.display().to_string(),
            why,
        };
        if path.is_dir() {
            return Err(unreadable("it is a folder".to_string()));
        }
        let bytes = std::fs::read(path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => unreadable("there is no such file".to_string()),
            _ => unreadable(e.to_string()),
        })?;
        Self::from_bytes(&path.display().to_string(), &bytes)
    }

    /// Reads the content of a file that messages call `name`.
    ///
    /// Errors: as [`Self::read`].
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, ImportError> {
        let mut cursor = Cursor::new(name, bytes);
        cursor.skip_space();
        let content = if bytes.get(cursor.at()) == Some(&b'$') {
            gmsh::read(cursor)?
        } else if vtu::recognised(bytes) {
            vtu::read(name, bytes)?
        } else {
            return Err(cursor.unsupported(
                "this is neither a Gmsh mesh (.msh, which begins with $MeshFormat) nor a VTU file",
            ));
        };
        Self::new(name, content)
    }

    fn new(name: &str, mut content: Content) -> Result<Self, ImportError> {
        let repeated = drop_repeated(name, &mut content)?;
        let used = |dimension: u8| -> BTreeSet<i64> {
            let own = match dimension {
                1 => content
                    .edges
                    .iter()
                    .map(|e| e.tags)
                    .collect::<BTreeSet<_>>(),
                _ => content.cells.iter().map(|c| c.tags).collect(),
            };
            let refused = content.refused.iter();
            let refused = refused
                .filter(|r| r.element.dimension == dimension)
                .map(|r| r.tags);
            let sets = own.into_iter().chain(refused);
            sets.flat_map(|set| content.tags[set as usize].iter().copied())
                .collect()
        };
        let cell_groups = Groups::new(name, 2, &used(2), &content.names)?;
        let edge_groups = Groups::new(name, 1, &used(1), &content.names)?;
        let mut file = Self {
            name: name.to_string(),
            cell_sets: cell_groups.sets(&content.tags),
            edge_sets: edge_groups.sets(&content.tags),
            cell_groups,
            edge_groups,
            warnings: Vec::new(),
            points: std::mem::take(&mut content.points),
            cells: std::mem::take(&mut content.cells),
            edges: std::mem::take(&mut content.edges),
            refused: std::mem::take(&mut content.refused),
        };
        if file.cells.is_empty() && !file.refused.iter().any(|r| r.element.dimension == 2) {
            return Err(file.no_cells());
        }
        file.warnings = file.remarks(content, repeated);
        Ok(file)
    }

    fn no_cells(&self) -> ImportError {
        let mut found: Vec<String> = self.refused.iter().map(described).collect();
        if !self.edges.is_empty() {
            found.push(format!("{} edges", self.edges.len()));
        }
        ImportError::NoCells {
            file: self.name.clone(),
            found: match found.len() {
                0 => "it has no elements at all: in Gmsh, mesh in 2D, and put the surfaces in physical groups".to_string(),
                _ => format!("it has {}: in Gmsh, put the surfaces in physical groups, or save all elements", found.join(", ")),
            },
        }
    }

    /// Names of the groups of cells, by ascending tag.
    pub fn cell_groups(&self) -> &[String] {
        &self.cell_groups.names
    }

    /// Names of the groups of edges, by ascending tag.
    pub fn side_groups(&self) -> &[String] {
        &self.edge_groups.names
    }

    /// What of the whole file was left out or renamed, in words that name the file.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What the user should know of the file whichever body is cut out of it.
    fn remarks(&self, content: Content, repeated: usize) -> Vec<String> {
        let mut remarks = content.remarks.clone();
        let solid = self.refused.iter().filter(|r| r.element.dimension != 2);
        remarks.extend(
            merged(solid)
                .iter()
                .map(|r| format!("{} are left out", described(r))),
        );
        if repeated > 0 {
            remarks.push(format!("{repeated} repeated cells are left out"));
        }
        let points = content.point_tags.iter().collect::<BTreeSet<_>>();
        let points: Vec<String> = points
            .into_iter()
            .map(|tag| {
                content
                    .names
                    .get(&(0, *tag))
                    .cloned()
                    .unwrap_or_else(|| tag.to_string())
            })
            .collect();
        if !points.is_empty() {
            remarks.push(format!(
                "groups of points are left out: {}",
                quoted(&points)
            ));
        }
        for groups in [&self.cell_groups, &self.edge_groups] {
            for (name, original) in groups.names.iter().zip(&groups.originals) {
                if let Some(original) = original.as_ref().filter(|o| *o != name) {
                    remarks.push(format!("the group `{original}` is called `{name}`: names consist of letters, digits, `_` and `-`"));
                }
            }
        }
        let empty = content
            .names
            .iter()
            .filter(|((dimension, tag), _)| match dimension {
                1 => !self.edge_groups.tags.contains_key(tag),
                2 => !self.cell_groups.tags.contains_key(tag),
                _ => false,
            });
        let empty: Vec<String> = empty.map(|(_, name)| name.clone()).collect();
        if !empty.is_empty() {
            remarks.push(format!("groups without elements: {}", quoted(&empty)));
        }
        self.edge_remarks(&mut remarks);
        remarks
            .into_iter()
            .map(|remark| format!("{}: {remark}", self.name))
            .collect()
    }

    /// Edges without a group, edges of no cell, nodes of no cell.
    fn edge_remarks(&self, remarks: &mut Vec<String>) {
        let groups = |edge: &Edge| &self.edge_sets[edge.tags as usize];
        let loose = self.edges.iter().filter(|edge| groups(edge).is_empty());
        let loose = loose.count();
        if loose > 0 {
            remarks.push(format!(
                "{loose} edges belong to no physical group and are left out"
            ));
        }
        let mut off: HashSet<[u32; 2]> = self.edges.iter().map(|e| ordered(e.ends)).collect();
        let mut in_cells = vec![false; self.points.len()];
        for cell in &self.cells {
            for facet in cell.kind.facets() {
                off.remove(&ordered([cell.nodes[facet[0]], cell.nodes[facet[1]]]));
            }
            for &node in cell.nodes() {
                in_cells[node as usize] = true;
            }
        }
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for edge in self
            .edges
            .iter()
            .filter(|edge| off.contains(&ordered(edge.ends)))
        {
            for &group in groups(edge) {
                *counts.entry(group).or_insert(0) += 1;
            }
        }
        for (group, count) in counts {
            let name = &self.edge_groups.names[group];
            remarks.push(format!(
                "{count} edges of the group `{name}` belong to no cell of the plane and are left out"
            ));
        }
        let nodes = in_cells.iter().filter(|used| !**used).count();
        if nodes > 0 {
            remarks.push(format!(
                "{nodes} nodes belong to no cell of the plane and are left out"
            ));
        }
    }

    /// The mesh of a body: the cells of these groups, or all cells where none is given.
    ///
    /// A group may be named as in the file or as in [`Self::cell_groups`]. The blocks of the mesh keep the names of the
    /// groups, for materials; without `groups`, cells of several groups have none.
    /// Errors: an unknown group; a cell in two of the groups; cells of a kind that is not supported; z not constant;
    /// whatever [`Mesh::new`] refuses, with the number of the element.
    pub fn mesh(&self, groups: &[&str]) -> Result<Imported, ImportError> {
        let chosen = self.chosen(groups)?;
        let mut warnings = Vec::new();
        let body = self.select(&chosen, &mut warnings)?;
        self.refuse_unsupported(&chosen)?;
        if body.cells.is_empty() {
            return Err(self.no_cells());
        }
        let (points, renumbered) = self.plane_points(&body)?;
        let (blocks, numbers) = self.blocks(&body, &renumbered);
        let mesh = Mesh::new(points, blocks).map_err(|error| self.refused_mesh(error, &numbers))?;
        let table = mesh.facet_table();
        self.refuse_gaps(&mesh, &table, &numbers)?;
        let sides = self.sides(&mesh, &table, &renumbered, &mut warnings);
        let unused_sides = self
            .edge_groups
            .names
            .iter()
            .filter(|name| !sides.contains_key(*name));
        let unused_sides = unused_sides.cloned().collect();
        let mesh = mesh
            .with_sides(sides)
            .map_err(|error| self.refused_mesh(error, &numbers))?;
        Ok(Imported {
            mesh,
            warnings,
            unused_cells: body
                .unused
                .iter()
                .map(|&g| self.cell_groups.names[g].clone())
                .collect(),
            unused_sides,
            unused_loose: body.unused_loose,
        })
    }

    /// Indices of the groups that a user names.
    fn chosen(&self, groups: &[&str]) -> Result<Vec<usize>, ImportError> {
        let mut chosen = Vec::new();
        for &group in groups {
            let found = self.cell_groups.find(group);
            let found = found.ok_or_else(|| ImportError::UnknownGroup {
                file: self.name.clone(),
                group: group.to_string(),
                known: self.cell_groups.names.clone(),
            })?;
            if !chosen.contains(&found) {
                chosen.push(found);
            }
        }
        Ok(chosen)
    }

    /// The cells of a body, each with the group that it is in.
    fn select(
        &self,
        chosen: &[usize],
        warnings: &mut Vec<String>,
    ) -> Result<Selection<'_>, ImportError> {
        let mut selection = Selection::default();
        let mut unused: BTreeSet<usize> = (0..self.cell_groups.names.len()).collect();
        let (mut loose, mut several) = (0, BTreeSet::new());
        for cell in &self.cells {
            let set = &self.cell_sets[cell.tags as usize];
            let own: Vec<usize> = match chosen.is_empty() {
                true => set.clone(),
                false => set
                    .iter()
                    .copied()
                    .filter(|group| chosen.contains(group))
                    .collect(),
            };
            match own[..] {
                [] if !chosen.is_empty() => {
                    selection.unused_loose += usize::from(set.is_empty());
                    continue;
                }
                [first, second, ..] if !chosen.is_empty() => {
                    let name = |group: usize| self.cell_groups.names[group].clone();
                    return Err(ImportError::TwoGroups {
                        file: self.name.clone(),
                        element: cell.number,
                        first: name(first),
                        second: name(second),
                    });
                }
                [] => loose += 1,
                [_] => {}
                [..] => several.extend(own.iter().copied()),
            }
            let group = if own.len() == 1 { Some(own[0]) } else { None };
            for group in set {
                unused.remove(group);
            }
            selection.cells.push((cell, group));
        }
        if loose > 0 && loose < selection.cells.len() {
            warnings.push(format!(
                "{loose} of its {} cells belong to no physical group of {}",
                selection.cells.len(),
                self.name
            ));
        }
        if !several.is_empty() {
            let names: Vec<String> = several
                .iter()
                .map(|&group| self.cell_groups.names[group].clone())
                .collect();
            warnings.push(format!("some of its cells belong to several groups of {} ({}): materials cannot name these; list groups that do not overlap in `group`", self.name, quoted(&names)));
        }
        if !chosen.is_empty() {
            let refused = self.refused.iter().filter(|refused| {
                refused.element.dimension == 2 && self.cell_sets[refused.tags as usize].is_empty()
            });
            selection.unused_loose += refused.map(|refused| refused.count).sum::<usize>();
        }
        selection.unused = unused;
        Ok(selection)
    }

    /// Refuses plane cells of a kind that is not supported, where the body would have them.
    fn refuse_unsupported(&self, chosen: &[usize]) -> Result<(), ImportError> {
        let needed = self.refused.iter().find(|refused| {
            let set = &self.cell_sets[refused.tags as usize];
            let wanted = chosen.is_empty() || set.iter().any(|group| chosen.contains(group));
            refused.element.dimension == 2 && wanted
        });
        match needed {
            None => Ok(()),
            Some(refused) => Err(ImportError::UnsupportedCells {
                file: self.name.clone(),
                kind: refused.element.name,
                count: refused.count,
                element: refused.first,
                known: CellKind::ALL.map(CellKind::name).join(", "),
            }),
        }
    }

    /// Points of the nodes that the body uses, in the order of the file, and the new index of each.
    fn plane_points(&self, body: &Selection<'_>) -> Result<(Vec<Point<2>>, Vec<u32>), ImportError> {
        let mut used = vec![false; self.points.len()];
        for &node in body.cells.iter().flat_map(|(cell, _)| cell.nodes()) {
            used[node as usize] = true;
        }
        let mut renumbered = vec![u32::MAX; self.points.len()];
        let mut points = Vec::new();
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (index, &point) in self
            .points
            .iter()
            .enumerate()
            .filter(|(index, _)| used[*index])
        {
            renumbered[index] = points.len() as u32;
            points.push([point[0], point[1]]);
            for d in 0..3 {
                low[d] = low[d].min(point[d]);
                high[d] = high[d].max(point[d]);
            }
        }
        // Rounding of a plane that was turned into this one.
        let width = (high[0] - low[0]).hypot(high[1] - low[1]);
        if high[2] - low[2] > 1e-9 * width {
            return Err(ImportError::NotPlane {
                file: self.name.clone(),
                low: low[2],
                high: high[2],
            });
        }
        Ok((points, renumbered))
    }

    /// A block for every kind and group, in the order of their first cells, and the numbers of its cells in the file.
    fn blocks(&self, body: &Selection<'_>, renumbered: &[u32]) -> (Vec<CellBlock>, Vec<Vec<u64>>) {
        let mut places: HashMap<(CellKind, Option<usize>), usize> = HashMap::new();
        let (mut blocks, mut numbers) = (Vec::new(), Vec::new());
        for &(cell, group) in &body.cells {
            let place = *places.entry((cell.kind, group)).or_insert_with(|| {
                blocks.push(CellBlock {
                    kind: cell.kind,
                    nodes: Vec::new(),
                    group: group.map(|group| self.cell_groups.names[group].clone()),
                });
                numbers.push(Vec::new());
                blocks.len() - 1
            });
            let nodes = cell.nodes().iter().map(|&node| renumbered[node as usize]);
            blocks[place].nodes.extend(nodes);
            numbers[place].push(cell.number);
        }
        (blocks, numbers)
    }

    /// An error of the mesh with the number that its cell has in the file.
    fn refused_mesh(&self, error: MeshError, numbers: &[Vec<u64>]) -> ImportError {
        let place = match error {
            MeshError::RepeatedNode { block, cell, .. }
            | MeshError::ZeroVolume { block, cell, .. }
            | MeshError::Folded { block, cell, .. } => Some((block, cell)),
            _ => None,
        };
        ImportError::Mesh {
            file: self.name.clone(),
            element: place.and_then(|(block, cell)| numbers.get(block)?.get(cell).copied()),
            error,
        }
    }

    /// Refuses cells that share the ends of an edge and not its middle, and more than two cells at one edge.
    fn refuse_gaps(
        &self,
        mesh: &Mesh<2>,
        table: &FacetTable,
        numbers: &[Vec<u64>],
    ) -> Result<(), ImportError> {
        let number = |facet: Facet| numbers[facet.block as usize][facet.cell as usize];
        let middle = |facet: Facet| mesh.facet_nodes(facet).nth(2);
        for facets in table.groups() {
            let fits = match facets {
                [_] => true,
                [(_, a), (_, b)] => middle(*a) == middle(*b),
                _ => false,
            };
            if !fits {
                return Err(ImportError::NotConforming {
                    file: self.name.clone(),
                    elements: facets.iter().map(|(_, facet)| number(*facet)).collect(),
                });
            }
        }
        Ok(())
    }

    /// The groups of edges on the boundary of a body, and its whole boundary.
    fn sides(
        &self,
        mesh: &Mesh<2>,
        table: &FacetTable,
        renumbered: &[u32],
        warnings: &mut Vec<String>,
    ) -> BTreeMap<String, Vec<Facet>> {
        let mut sides: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
        let mut inside: BTreeMap<usize, usize> = BTreeMap::new();
        for edge in &self.edges {
            let ends = edge.ends.map(|node| renumbered[node as usize]);
            let facets: Vec<Facet> = table.find(&ends).collect();
            for &group in &self.edge_sets[edge.tags as usize] {
                match facets[..] {
                    [] => {}
                    [facet] => {
                        let name = self.edge_groups.names[group].clone();
                        sides.entry(name).or_default().push(facet);
                    }
                    _ => *inside.entry(group).or_insert(0) += 1,
                }
            }
        }
        for (group, count) in inside {
            let name = &self.edge_groups.names[group];
            warnings.push(format!("{count} edges of the group `{name}` lie inside it and are left out: sides are on the boundary"));
        }
        if self.edge_groups.names.is_empty() {
            warnings.push(format!(
                "{} has no physical groups of edges: its one side is `{BOUNDARY}`",
                self.name
            ));
        }
        if self.edge_groups.find(BOUNDARY).is_none() {
            sides.insert(BOUNDARY.to_string(), mesh.boundary_facets());
        }
        sides
    }
}

/// The cells of a body.
#[derive(Default)]
struct Selection<'f> {
    cells: Vec<(&'f Cell, Option<usize>)>,
    /// Groups of cells none of which are in the body.
    unused: BTreeSet<usize>,
    /// Cells of no group that are not in the body.
    unused_loose: usize,
}

/// Keeps the first of equal cells, with the groups of all of them; returns how many were dropped without bringing a group.
///
/// Version 2.2 of the format repeats an element for each of its groups.
fn drop_repeated(file: &str, content: &mut Content) -> Result<usize, ImportError> {
    let mut seen: HashMap<[u32; 4], usize> = HashMap::new();
    let mut kept: Vec<Cell> = Vec::with_capacity(content.cells.len());
    let mut repeated = 0;
    for cell in std::mem::take(&mut content.cells) {
        let Some(&place) = seen.get(&cell.corners()) else {
            seen.insert(cell.corners(), kept.len());
            kept.push(cell);
            continue;
        };
        let first = &mut kept[place];
        let sorted = |cell: &Cell| {
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
        let tags = |cell: &Cell| content.tags[cell.tags as usize].clone();
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

/// Refused elements by kind alone.
fn merged<'r>(refused: impl Iterator<Item = &'r Refused>) -> Vec<Refused> {
    let mut kinds: Vec<Refused> = Vec::new();
    for one in refused {
        match kinds.iter_mut().find(|kind| kind.element == one.element) {
            Some(kind) => kind.count += one.count,
            None => kinds.push(one.clone()),
        }
    }
    kinds
}

fn described(refused: &Refused) -> String {
    format!(
        "{} elements of the kind {}",
        refused.count, refused.element.name
    )
}

fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn quoted(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
