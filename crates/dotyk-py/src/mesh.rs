//! Meshes: from arrays, from the words of a case file, and back to arrays.

use crate::errors;
use crate::worker::{Caller, wait};
use dotyk::case::{Given, GivenMesh, read_mesh};
use dotyk::mesh::{CellBlock, CellKind, Facet, FacetTable, Mesh as Core, drop_repeated};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

/// A checked mesh, of the plane or of space.
#[pyclass(frozen, module = "dotyk._dotyk")]
pub struct Mesh {
    pub given: GivenMesh,
    warnings: Vec<String>,
    /// What makes it anew, with its curves.
    words: Option<Words>,
}

/// Text, folder, whether it is one of space, and the meshes that it names by handles.
type Words = (String, PathBuf, bool, Vec<Py<Mesh>>);

/// Kind, group and nodes (m, k) of cells.
type Block<'py> = (String, Option<String>, Bound<'py, PyArray2<u32>>);

/// Does the same with a mesh of the plane and with one of space.
macro_rules! of_mesh {
    ($given:expr, |$mesh:ident| $body:expr) => {
        match $given {
            GivenMesh::Plane($mesh, _) => $body,
            GivenMesh::Space($mesh, _) => $body,
        }
    };
}

#[pymethods]
impl Mesh {
    /// The mesh of a text with the key `mesh`; meshes that it names by handles are given.
    #[staticmethod]
    #[pyo3(signature = (text, folder, space, meshes))]
    fn of_text(
        py: Python<'_>,
        text: String,
        folder: PathBuf,
        space: bool,
        meshes: Vec<Py<Self>>,
    ) -> PyResult<Self> {
        let given = Arc::new(Given {
            meshes: meshes.iter().map(|mesh| mesh.get().given.clone()).collect(),
            functions: Vec::new(),
            ..Given::default()
        });
        let caller = Arc::new(Caller::default());
        let words = (text.clone(), folder.clone(), space, meshes);
        let read = wait(py, &caller, None, move |_| {
            read_mesh(&text, &folder, space, &given)
        })?;
        let read = read.map_err(|error| errors::of_case(py, &error, &errors::Origin::Python))?;
        Ok(Self {
            given: read.mesh,
            warnings: read.warnings,
            words: read.of_words.then_some(words),
        })
    }

    /// The arguments of `of_text` that make the same mesh; `None` where it is none of words.
    fn words(&self, py: Python<'_>) -> Option<Words> {
        let (text, folder, space, meshes) = self.words.as_ref()?;
        let meshes = meshes.iter().map(|mesh| mesh.clone_ref(py)).collect();
        Some((text.clone(), folder.clone(), *space, meshes))
    }

    /// A mesh from points (n, 2 or 3), blocks of cells (kind, group, nodes (m, k)) and sides by name: nodes of facets (f, k).
    ///
    /// With `boundary` the whole boundary is a side of that name, unless a given one has it. A set of nodes is a side where
    /// it covers facets of the boundary and no side has its name, else its nodes are points of its name. A mesh of another
    /// program comes with `notes` about it: of its sides only the facets on the boundary are kept.
    #[staticmethod]
    #[pyo3(signature = (points, blocks, sides, named, boundary=false, sets=Vec::new(), notes=None))]
    #[expect(clippy::too_many_arguments)]
    fn of_arrays(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        blocks: Vec<(String, Option<String>, PyReadonlyArray2<'_, i64>)>,
        sides: Vec<(String, PyReadonlyArray2<'_, i64>)>,
        named: BTreeMap<String, Vec<Vec<f64>>>,
        boundary: bool,
        sets: Vec<(String, Vec<u32>)>,
        notes: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let dimension = points.as_array().ncols();
        let blocks = blocks
            .iter()
            .map(|(kind, group, nodes)| block(py, kind, group, nodes));
        let mut blocks = blocks.collect::<PyResult<Vec<_>>>()?;
        let repeated = drop_repeated(&mut blocks).map_err(|error| errors::input(py, error))?;
        let sides = sides.iter();
        let sides =
            sides.map(|(name, nodes)| Ok((name.clone(), facets(py, name, nodes, dimension)?)));
        let sides = sides.collect::<PyResult<Vec<_>>>()?;
        let told = format!("{repeated} repeated cells are left out");
        let mut warnings: Vec<String> = (repeated > 0).then_some(told).into_iter().collect();
        let strict = notes.is_none();
        warnings.extend(notes.unwrap_or_default());
        let parts = Parts {
            sides,
            strict,
            named,
            boundary,
            sets,
        };
        let given = match dimension {
            2 => {
                let (mesh, named) = made(py, &points, blocks, parts, &mut warnings)?;
                GivenMesh::Plane(Arc::new(mesh), named)
            }
            3 => {
                let (mesh, named) = made(py, &points, blocks, parts, &mut warnings)?;
                GivenMesh::Space(Arc::new(mesh), named)
            }
            other => {
                let message = format!("points have 2 or 3 coordinates, not {other}");
                return Err(errors::input(py, message));
            }
        };
        Ok(Self {
            given,
            warnings,
            words: None,
        })
    }

    #[getter]
    fn dimension(&self) -> usize {
        match &self.given {
            GivenMesh::Plane(..) => 2,
            GivenMesh::Space(..) => 3,
        }
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Coordinates of the nodes, (n, 2 or 3).
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        of_mesh!(&self.given, |mesh| rows(py, mesh.points().to_vec()))
    }

    /// The blocks of cells.
    fn blocks<'py>(&self, py: Python<'py>) -> PyResult<Vec<Block<'py>>> {
        let blocks = of_mesh!(&self.given, |mesh| mesh.blocks());
        let blocks = blocks.iter().map(|block| {
            let nodes = PyArray1::from_slice(py, &block.nodes);
            let nodes = nodes.reshape([block.cells().len(), block.kind.nodes()])?;
            Ok((block.kind.name().to_string(), block.group.clone(), nodes))
        });
        blocks.collect()
    }

    /// Nodes of the facets of every side, (f, k); facets of several kinds of a side in several arrays.
    fn sides<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyArray2<u32>>)>> {
        of_mesh!(&self.given, |mesh| {
            let mut list = Vec::new();
            for (name, facets) in mesh.sides() {
                let mut by_size: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
                for &facet in facets {
                    let nodes = mesh.facet_nodes(facet);
                    by_size.entry(nodes.len()).or_default().extend(nodes);
                }
                for (size, nodes) in by_size {
                    let count = nodes.len() / size;
                    list.push((
                        name.clone(),
                        PyArray1::from_vec(py, nodes).reshape([count, size])?,
                    ));
                }
            }
            Ok(list)
        })
    }

    /// Named points, each by its coordinates.
    fn named(&self) -> BTreeMap<String, Vec<Vec<f64>>> {
        fn listed<const D: usize>(
            points: &BTreeMap<String, Vec<[f64; D]>>,
        ) -> BTreeMap<String, Vec<Vec<f64>>> {
            let listed = points.iter();
            let listed =
                listed.map(|(name, all)| (name.clone(), all.iter().map(|p| p.to_vec()).collect()));
            listed.collect()
        }
        match &self.given {
            GivenMesh::Plane(_, points) => listed(points),
            GivenMesh::Space(_, points) => listed(points),
        }
    }
}

impl Mesh {
    /// A mesh of a case.
    pub fn of_given(given: GivenMesh) -> Self {
        Self {
            given,
            warnings: Vec::new(),
            words: None,
        }
    }
}

/// An array (n, D) of points.
pub fn rows<const D: usize>(
    py: Python<'_>,
    points: Vec<[f64; D]>,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let count = points.len();
    PyArray1::from_vec(py, points.into_flattened()).reshape([count, D])
}

fn places<const D: usize>(
    named: &BTreeMap<String, Vec<Vec<f64>>>,
) -> BTreeMap<String, Vec<[f64; D]>> {
    let point = |own: &Vec<f64>| std::array::from_fn(|d| own.get(d).copied().unwrap_or(0.0));
    let named = named.iter();
    named
        .map(|(name, all)| (name.clone(), all.iter().map(point).collect()))
        .collect()
}

fn indices(py: Python<'_>, what: &str, nodes: &PyReadonlyArray2<'_, i64>) -> PyResult<Vec<u32>> {
    let nodes = nodes.as_array();
    let nodes = nodes.iter().map(|&node| {
        u32::try_from(node)
            .map_err(|_| errors::input(py, format!("{what}: {node} is not the number of a node")))
    });
    nodes.collect()
}

fn block(
    py: Python<'_>,
    name: &str,
    group: &Option<String>,
    nodes: &PyReadonlyArray2<'_, i64>,
) -> PyResult<CellBlock> {
    let Some(kind) = CellKind::from_name(name) else {
        let known = CellKind::ALL.map(CellKind::name).join(", ");
        return Err(errors::input(
            py,
            format!("unknown kind of cells `{name}`; known: {known}"),
        ));
    };
    let found = nodes.as_array().ncols();
    if found != kind.nodes() {
        let message = format!(
            "cells of the kind {name} have {} nodes each, not {found}",
            kind.nodes()
        );
        return Err(errors::input(py, message));
    }
    Ok(CellBlock {
        kind,
        group: group.clone(),
        nodes: indices(py, &format!("cells of the kind {name}"), nodes)?,
    })
}

/// Corners of the facets of a side.
fn facets(
    py: Python<'_>,
    name: &str,
    nodes: &PyReadonlyArray2<'_, i64>,
    dimension: usize,
) -> PyResult<Vec<Vec<u32>>> {
    let columns = nodes.as_array().ncols();
    let corners = match (dimension, columns) {
        (2, 2 | 3) => 2,
        (3, 3 | 6) => 3,
        (3, 4 | 8 | 9) => 4,
        _ => {
            let message = format!(
                "side `{name}`: a facet in {dimension}D has no {columns} nodes; give its corners"
            );
            return Err(errors::input(py, message));
        }
    };
    let all = indices(py, &format!("side `{name}`"), nodes)?;
    Ok(all
        .chunks_exact(columns)
        .map(|facet| facet[..corners].to_vec())
        .collect())
}

/// What arrays name of a mesh.
struct Parts {
    /// Corners of the facets of each.
    sides: Vec<(String, Vec<Vec<u32>>)>,
    /// Every facet of a side must be there.
    strict: bool,
    named: BTreeMap<String, Vec<Vec<f64>>>,
    boundary: bool,
    /// Nodes of each.
    sets: Vec<(String, Vec<u32>)>,
}

/// The side that is the whole boundary, as in meshes of files.
const BOUNDARY: &str = "boundary";

/// Points by name.
type Named<const D: usize> = BTreeMap<String, Vec<[f64; D]>>;

fn made<const D: usize>(
    py: Python<'_>,
    points: &PyReadonlyArray2<'_, f64>,
    blocks: Vec<CellBlock>,
    parts: Parts,
    warnings: &mut Vec<String>,
) -> PyResult<(Core<D>, Named<D>)> {
    let points = points.as_array();
    let rows = points.rows().into_iter();
    let points: Vec<[f64; D]> = rows.map(|row| std::array::from_fn(|d| row[d])).collect();
    let refused = |error: dotyk::mesh::MeshError| errors::input(py, error);
    let mesh = Core::new(points, blocks).map_err(refused)?;
    let table = (!parts.strict).then(|| mesh.facet_table());
    let mut found: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
    for (name, corners) in parts.sides {
        let facets = match &table {
            Some(table) => outer(table, &corners, &name, warnings),
            None => mesh.facets_at(&corners).map_err(|k| {
                let message = format!(
                    "side `{name}`: no cell has the facet {k} with the corners {:?}",
                    corners[k]
                );
                errors::input(py, message)
            })?,
        };
        if !facets.is_empty() || parts.strict {
            found.entry(name).or_default().extend(facets);
        }
    }
    let mut named = places(&parts.named);
    let boundary = match parts.boundary || !parts.sets.is_empty() {
        true => mesh.boundary_facets(),
        false => Vec::new(),
    };
    for (name, nodes) in parts.sets {
        let nodes: BTreeSet<u32> = nodes.into_iter().collect();
        let facets = covered(&mesh, &boundary, &nodes);
        if facets.is_empty() {
            let own = nodes.iter().filter_map(|&n| mesh.points().get(n as usize));
            named.entry(name).or_insert_with(|| own.copied().collect());
        } else if let Entry::Vacant(side) = found.entry(name) {
            warnings.extend(beside(&mesh, &facets, &nodes, side.key()));
            side.insert(facets);
        }
    }
    if parts.boundary {
        found.entry(BOUNDARY.to_string()).or_insert(boundary);
    }
    Ok((mesh.with_sides(found).map_err(refused)?, named))
}

/// The facets with these corners that are on the boundary, and warnings of the others.
fn outer(
    table: &FacetTable,
    corners: &[Vec<u32>],
    name: &str,
    warnings: &mut Vec<String>,
) -> Vec<Facet> {
    let (mut facets, mut inside, mut missing) = (Vec::new(), 0, 0);
    for corners in corners {
        let cells: Vec<Facet> = table.find(corners).collect();
        match cells[..] {
            [facet] => facets.push(facet),
            [] => missing += 1,
            _ => inside += 1,
        }
    }
    for (count, place) in [(inside, "lie inside the body"), (missing, "are of no cell")] {
        if count > 0 {
            warnings.push(format!(
                "{count} facets of the group `{name}` {place} and are left out: sides are on the boundary"
            ));
        }
    }
    facets
}

/// The facets whose nodes are all in a set; where there are none, those whose corners are.
fn covered<const D: usize>(
    mesh: &Core<D>,
    boundary: &[Facet],
    nodes: &BTreeSet<u32>,
) -> Vec<Facet> {
    let within = |facet: &Facet, count: usize| {
        let mut own = mesh.facet_nodes(*facet).take(count);
        own.all(|node| nodes.contains(&node))
    };
    let whole = boundary.iter().filter(|facet| within(facet, usize::MAX));
    let whole: Vec<Facet> = whole.copied().collect();
    if !whole.is_empty() {
        return whole;
    }
    let corners = |facet: &&Facet| within(facet, mesh.facet_kind(**facet).corners());
    boundary.iter().filter(corners).copied().collect()
}

/// A warning where a set has nodes on none of its facets.
fn beside<const D: usize>(
    mesh: &Core<D>,
    facets: &[Facet],
    nodes: &BTreeSet<u32>,
    name: &str,
) -> Option<String> {
    let on = facets.iter().flat_map(|&facet| mesh.facet_nodes(facet));
    let on: BTreeSet<u32> = on.collect();
    let off = nodes.difference(&on).count();
    let count = nodes.len();
    (off > 0).then(|| {
        format!(
            "{off} of the {count} nodes of the set `{name}` are on no facet of the boundary that has all of its nodes in the set: they are left out of the side `{name}`"
        )
    })
}
