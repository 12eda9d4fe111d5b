//! Cutting a body out of a mesh file: its cells, points, blocks and sides, and errors where they do not fit.

use crate::geometry::Point;
use crate::mesh::import::content::ReadCell;
use crate::mesh::import::error::ImportError;
use crate::mesh::import::remarks::quoted;
use crate::mesh::{CellBlock, CellKind, Facet, FacetTable, Mesh, MeshError, MeshFile};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// The side that every imported mesh has, unless a group of the file has its name.
const BOUNDARY: &str = "boundary";

/// A body's mesh, and the parts of the file that are not in it.
#[derive(Debug, Clone)]
pub struct Imported<const D: usize = 2> {
    /// The cells with their groups, and the sides.
    pub mesh: Mesh<D>,
    /// The nodes of the body in groups of points, by the name of the group; groups without such a node are left out.
    pub points: BTreeMap<String, Vec<Point<D>>>,
    /// Remarks on omitted or unexpected parts.
    pub warnings: Vec<String>,
    /// Groups of cells that the body does not contain.
    pub unused_cells: Vec<String>,
    /// Groups of edges or faces that do not touch the body.
    pub unused_sides: Vec<String>,
    /// Groups of points without a node of the body.
    pub unused_points: Vec<String>,
    /// Cells of no group that the body does not contain.
    pub unused_loose: usize,
}

/// The cells of a body.
#[derive(Default)]
struct Selection<'f> {
    cells: Vec<(&'f ReadCell, Option<usize>)>,
    /// Groups of cells none of which are in the body.
    unused: BTreeSet<usize>,
    /// Cells of no group that are not in the body.
    unused_loose: usize,
}

impl MeshFile {
    /// The mesh of a body of the plane: the cells of these groups, or all cells where none is given.
    ///
    /// A group may be named as in the file or as in [`Self::cell_groups`]. The blocks of the mesh keep the names of the
    /// groups, for materials; without `groups`, cells of several groups have none.
    /// Errors: an unknown group; a cell in two of the groups; cells of a kind that is not supported; z not constant;
    /// the errors of [`Mesh::new`], with the number of the element.
    pub fn mesh(&self, groups: &[&str]) -> Result<Imported, ImportError> {
        self.body(groups)
    }

    /// The mesh of a body of space, as [`Self::mesh`].
    ///
    /// Errors: as [`Self::mesh`]; a group of faces.
    pub fn solid(&self, groups: &[&str]) -> Result<Imported<3>, ImportError> {
        self.body(groups)
    }

    fn body<const D: usize>(&self, groups: &[&str]) -> Result<Imported<D>, ImportError> {
        if usize::from(self.dimension) != D {
            return Err(ImportError::Dimension {
                file: self.name.clone(),
                dimension: self.dimension,
            });
        }
        let chosen = self.chosen(groups)?;
        let mut warnings = Vec::new();
        let body = self.select(&chosen, &mut warnings)?;
        self.refuse_unsupported(&chosen)?;
        if body.cells.is_empty() {
            return Err(self.no_cells());
        }
        let (points, renumbered) = self.points_of(&body)?;
        let (blocks, numbers) = self.blocks(&body, &renumbered);
        let mesh = Mesh::new(points, blocks).map_err(|error| self.refused_mesh(error, &numbers))?;
        let table = mesh.facet_table();
        self.refuse_gaps(&mesh, &table, &numbers)?;
        let sides = self.sides(&mesh, &table, &renumbered, &mut warnings);
        let unused_sides = self.side_groups.names.iter();
        let unused_sides = unused_sides.filter(|name| !sides.contains_key(*name));
        let unused_sides = unused_sides.cloned().collect();
        let points = self.named_points(&mesh, &renumbered);
        let unused_points = self.point_groups.names.iter();
        let unused_points = unused_points.filter(|name| !points.contains_key(*name));
        let unused_points = unused_points.cloned().collect();
        let unused_cells = body.unused.iter();
        let unused_cells = unused_cells.map(|&group| self.cell_groups.names[group].clone());
        let mesh = mesh
            .with_sides(sides)
            .map_err(|error| self.refused_mesh(error, &numbers))?;
        Ok(Imported {
            mesh,
            points,
            warnings,
            unused_cells: unused_cells.collect(),
            unused_sides,
            unused_points,
            unused_loose: body.unused_loose,
        })
    }

    /// Indices of the groups that a user names.
    fn chosen(&self, groups: &[&str]) -> Result<Vec<usize>, ImportError> {
        let mut chosen = Vec::new();
        for &group in groups {
            let found = self.cell_groups.find(group);
            let found = found.ok_or_else(|| {
                let (file, group) = (self.name.clone(), group.to_string());
                let known = self.cell_groups.names.clone();
                match self.dimension == 3 && self.side_groups.find(&group).is_some() {
                    true => ImportError::Shell { file, group, known },
                    false => ImportError::UnknownGroup { file, group, known },
                }
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
        let mut selection = Selection {
            unused: (0..self.cell_groups.names.len()).collect(),
            ..Selection::default()
        };
        let (mut loose, mut several) = (0, BTreeSet::new());
        for cell in &self.cells {
            let set = &self.cell_sets[cell.tags as usize];
            let Some(group) = self.membership(cell, chosen)? else {
                selection.unused_loose += usize::from(set.is_empty());
                continue;
            };
            loose += usize::from(set.is_empty());
            for group in set {
                selection.unused.remove(group);
            }
            if group.is_none() {
                several.extend(set);
            }
            selection.cells.push((cell, group));
        }
        if !chosen.is_empty() {
            let refused = self.refused.iter().filter(|refused| {
                refused.element.dimension == self.dimension
                    && self.cell_sets[refused.tags as usize].is_empty()
            });
            selection.unused_loose += refused.map(|refused| refused.count).sum::<usize>();
        }
        let (file, count) = (&self.name, selection.cells.len());
        if loose > 0 && loose < count {
            warnings.push(format!(
                "{loose} of its {count} cells belong to no physical group of {file}"
            ));
        }
        if !several.is_empty() {
            let names = several
                .iter()
                .map(|&&group| self.cell_groups.names[group].clone());
            let names = quoted(&names.collect::<Vec<_>>());
            warnings.push(format!(
                "some of its cells belong to several groups of {file} ({names}): materials cannot name these; list groups that do not overlap in `group`"
            ));
        }
        Ok(selection)
    }

    /// Whether a cell is in a body, and its group there: the chosen one, or its only one.
    fn membership(
        &self,
        cell: &ReadCell,
        chosen: &[usize],
    ) -> Result<Option<Option<usize>>, ImportError> {
        let set = &self.cell_sets[cell.tags as usize];
        if chosen.is_empty() {
            let only = (set.len() == 1).then(|| set[0]);
            return Ok(Some(only));
        }
        let mut own = set.iter().copied().filter(|group| chosen.contains(group));
        match (own.next(), own.next()) {
            (Some(first), Some(second)) => {
                let name = |group: usize| self.cell_groups.names[group].clone();
                Err(ImportError::TwoGroups {
                    file: self.name.clone(),
                    element: cell.number,
                    first: name(first),
                    second: name(second),
                })
            }
            (group, _) => Ok(group.map(Some)),
        }
    }

    /// Refuses cells of a kind that is not supported, where the body would have them.
    fn refuse_unsupported(&self, chosen: &[usize]) -> Result<(), ImportError> {
        let needed = self.refused.iter().find(|refused| {
            let set = &self.cell_sets[refused.tags as usize];
            let wanted = chosen.is_empty() || set.iter().any(|group| chosen.contains(group));
            refused.element.dimension == self.dimension && wanted
        });
        match needed {
            None => Ok(()),
            Some(refused) => Err(ImportError::UnsupportedCells {
                file: self.name.clone(),
                kind: refused.element.to_string(),
                count: refused.count,
                element: refused.first,
                known: CellKind::of_dimension(usize::from(self.dimension))
                    .map(CellKind::name)
                    .collect::<Vec<_>>()
                    .join(", "),
            }),
        }
    }

    /// Points of the nodes that the body uses, in the order of the file, and the new index of each.
    fn points_of<const D: usize>(
        &self,
        body: &Selection<'_>,
    ) -> Result<(Vec<Point<D>>, Vec<u32>), ImportError> {
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
            points.push(std::array::from_fn(|d| point[d]));
            for d in 0..3 {
                low[d] = low[d].min(point[d]);
                high[d] = high[d].max(point[d]);
            }
        }
        // Rounding of a plane that was turned into this one.
        let width = (high[0] - low[0]).hypot(high[1] - low[1]);
        if D == 2 && high[2] - low[2] > 1e-9 * width {
            return Err(ImportError::NotPlane {
                file: self.name.clone(),
                low: low[2],
                high: high[2],
                of_space: self.of_space(),
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

    /// Refuses cells that share the corners of an edge or face and not its middle nodes, more than two cells there, and
    /// facets of the boundary on a part of another one: triangles on a quadrilateral, facets between its middle nodes.
    fn refuse_gaps<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        table: &FacetTable,
        numbers: &[Vec<u64>],
    ) -> Result<(), ImportError> {
        let refused = |facets: &[Facet]| {
            let number = |facet: &Facet| numbers[facet.block as usize][facet.cell as usize];
            let elements: BTreeSet<u64> = facets.iter().map(number).collect();
            Err(ImportError::NotConforming {
                file: self.name.clone(),
                place: if D == 2 { "edge" } else { "face" },
                elements: elements.into_iter().collect(),
            })
        };
        let middle = |facet: Facet| {
            let corners = mesh.facet_kind(facet).corners();
            mesh.facet_nodes(facet)
                .skip(corners)
                .collect::<BTreeSet<u32>>()
        };
        let mut boundary = Vec::new();
        for facets in table.groups() {
            match facets {
                [(_, only)] => boundary.push(*only),
                [(_, a), (_, b)] if middle(*a) == middle(*b) => {}
                _ => return refused(&facets.iter().map(|f| f.1).collect::<Vec<_>>()),
            }
        }
        let mut starting_at: HashMap<u32, Vec<Facet>> = HashMap::new();
        for &facet in &boundary {
            let start = mesh.facet_nodes(facet).next().unwrap_or(u32::MAX);
            starting_at.entry(start).or_default().push(facet);
        }
        for &whole in &boundary {
            let nodes: Vec<u32> = mesh.facet_nodes(whole).collect();
            let within = |part: &Facet| {
                let corners = mesh.facet_kind(*part).corners();
                let mut corners = mesh.facet_nodes(*part).take(corners);
                *part != whole && corners.all(|corner| nodes.contains(&corner))
            };
            let beside = nodes.iter().filter_map(|node| starting_at.get(node));
            let mut facets: Vec<Facet> = beside.flatten().copied().filter(within).collect();
            if !facets.is_empty() {
                facets.push(whole);
                return refused(&facets);
            }
        }
        Ok(())
    }

    /// The nodes of a body in each group of points.
    fn named_points<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        renumbered: &[u32],
    ) -> BTreeMap<String, Vec<Point<D>>> {
        let mut points: BTreeMap<String, Vec<Point<D>>> = BTreeMap::new();
        // version 2.2 of the format repeats an element for each of its groups
        let mut listed: HashSet<(usize, u32)> = HashSet::new();
        for named in &self.nodes {
            let Some(&point) = mesh.points().get(renumbered[named.node as usize] as usize) else {
                continue;
            };
            for &group in &self.node_sets[named.tags as usize] {
                if listed.insert((group, named.node)) {
                    let name = self.point_groups.names[group].clone();
                    points.entry(name).or_default().push(point);
                }
            }
        }
        points
    }

    /// The groups of edges or faces on the boundary of a body, and its whole boundary.
    fn sides<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        table: &FacetTable,
        renumbered: &[u32],
        warnings: &mut Vec<String>,
    ) -> BTreeMap<String, Vec<Facet>> {
        let mut sides: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
        let mut inside: BTreeMap<usize, usize> = BTreeMap::new();
        for side in &self.sides {
            let corners = side.corners().iter();
            let corners: Vec<u32> = corners.map(|&node| renumbered[node as usize]).collect();
            // a face that leaves the body may have all but one corner on a facet of it
            if corners.contains(&u32::MAX) {
                continue;
            }
            let facets: Vec<Facet> = table.find(&corners).collect();
            for &group in &self.side_sets[side.tags as usize] {
                match facets[..] {
                    [] => {}
                    [facet] => {
                        let name = self.side_groups.names[group].clone();
                        sides.entry(name).or_default().push(facet);
                    }
                    _ => *inside.entry(group).or_insert(0) += 1,
                }
            }
        }
        let word = self.sides_word();
        for (group, count) in inside {
            let name = &self.side_groups.names[group];
            warnings.push(format!(
                "{count} {word} of the group `{name}` lie inside it and are left out: sides are on the boundary; where the cells on both sides of `{name}` are in groups of their own, each can be a body, and a [[contact]] between them (`tied = true`, or one that opens) has `{name}` as its side on either"
            ));
        }
        if self.side_groups.names.is_empty() {
            warnings.push(format!(
                "{} has no physical groups of {word}: its one side is `{BOUNDARY}`",
                self.name
            ));
        }
        if self.side_groups.find(BOUNDARY).is_none() {
            sides.insert(BOUNDARY.to_string(), mesh.boundary_facets());
        }
        sides
    }
}
