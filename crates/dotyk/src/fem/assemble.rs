//! Stiffness, loads, held dofs and rigid modes of one body.

use crate::fem::block::Cells;

use crate::fem::enhanced::has_modes;
use crate::fem::error::{FemError, show};
use crate::fem::loads::{NodalLoads, Size, nodal_loads};
use crate::fem::modes::{RigidBasis, carried_motion, free_modes};
use crate::fem::nouns::{Analysis, Body, Elastic, Formulation, History, Material, Part};
use crate::fem::springs::{spring_loads, spring_stiffness, sprung_directions};
use crate::fem::supports::{Constraints, ON_AXIS};
use crate::geometry::{Point, add_scaled, dot, norm};
use crate::linalg::{
    CellMatrices, Connectivity, Graph, LinalgError, SymmetricMatrix, assemble_blocks,
};
use crate::mesh::CellBlock;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The discrete equilibrium of one body, in the frames of its nodes.
pub struct BodySystem<const D: usize> {
    /// Node graph of the mesh.
    pub graph: Graph,
    /// K, (D·n, D·n), held dofs included; of a body that is to be divided without the entries between different nodes of cells at
    /// which nothing is held: the diagonal is whole, and so is K u_D.
    pub stiffness: SymmetricMatrix,
    /// f, (D·n,), a force.
    pub load: Vec<f64>,
    /// Resultant of the largest single load.
    pub largest_load: f64,
    /// Held directions, by node.
    pub constraints: Constraints<D>,
    /// Whether a dof is held, (D·n,).
    pub held: Vec<bool>,
    /// u_D, (D·n,): the prescribed displacement of held dofs, zero elsewhere.
    pub prescribed: Vec<f64>,
    /// The rigid motion that fits u_D best in the least-squares sense, (D·n,). Only the rest of u_D strains the body; it is computed
    /// separately, so that small strains are not lost in the rounding of a large motion.
    pub carried: Vec<f64>,
    /// u_D less `carried` on held dofs, zero elsewhere, (D·n,).
    pub lift: Vec<f64>,
    /// Axes (rows) of the nodes whose held directions are not along the global axes, and of those that were turned into the direction
    /// of their contact forces.
    pub frames: BTreeMap<usize, [[f64; D]; D]>,
    /// Rigid motions that the supports leave free: R, one column (D·n,) each, largest displacement 1.
    pub modes: Vec<Vec<f64>>,
    /// State of its supports, springs and neighbours after earlier load steps.
    pub(crate) history: History<D>,
    /// K has all of its entries.
    pub(crate) is_whole: bool,
}

impl<const D: usize> Body<D> {
    /// The material of a block of cells.
    pub(crate) fn material(&self, block: &CellBlock) -> Result<&Material, FemError> {
        let fits = |group: &Option<String>| group.is_none() || *group == block.group;
        let found = self.materials.iter().find(|m| fits(&m.group));
        found.ok_or_else(|| FemError::NoMaterial {
            group: block.group.clone().unwrap_or_else(|| "(none)".to_string()),
        })
    }

    /// The elasticity of a block of cells.
    pub(crate) fn elastic(&self, block: &CellBlock) -> Result<Elastic, FemError> {
        self.material(block).map(|material| material.elastic)
    }

    fn check_materials(&self) -> Result<(), FemError> {
        for material in &self.materials {
            let Elastic { young, poisson } = material.elastic;
            if !(young > 0.0 && young.is_finite()) {
                return Err(FemError::Material {
                    name: "young",
                    value: young,
                    range: "it must be positive",
                });
            }
            if !(poisson > -1.0 && poisson < 0.5) {
                let range =
                    "it must lie in (-1, 0.5); incompressible materials (0.5) are not supported";
                return Err(FemError::Material {
                    name: "poisson",
                    value: poisson,
                    range,
                });
            }
            if let Some(strength) = &material.strength {
                strength.check()?;
            }
            if let Some(group) = &material.group {
                let groups: Vec<&str> = self
                    .mesh
                    .blocks()
                    .iter()
                    .filter_map(|b| b.group.as_deref())
                    .collect();
                if !groups.contains(&group.as_str()) {
                    return Err(FemError::UnknownGroup {
                        group: group.clone(),
                        known: groups.join(", "),
                    });
                }
            }
        }
        if !(self.thickness > 0.0 && self.thickness.is_finite()) {
            return Err(FemError::Material {
                name: "thickness",
                value: self.thickness,
                range: "it must be positive",
            });
        }
        Ok(())
    }
}

/// Assembles one body at a time.
///
/// Errors: materials out of range, an analysis of another dimension, unknown or empty sides, contradictory supports, values
/// that are not finite.
pub fn assemble<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    time: f64,
) -> Result<BodySystem<D>, FemError> {
    assemble_after((body, History::default()), analysis, time, true)
}

/// The same, with the history of earlier load steps; of a body that is to be divided not the whole of K.
pub(crate) fn assemble_after<const D: usize>(
    (body, history): (&Body<D>, History<D>),
    analysis: Analysis,
    time: f64,
    is_whole: bool,
) -> Result<BodySystem<D>, FemError> {
    body.check_materials()?;
    if (analysis == Analysis::Solid) != (D == 3) {
        return Err(FemError::Dimension {
            analysis: analysis.name(),
            dimension: D,
        });
    }
    check_formulation(body, analysis)?;
    body.check_plastic(analysis)?;
    if history.yielded.is_none() {
        body.check_initial(analysis, time)?;
    }
    body.check_ages(analysis)?;
    if let Some(why) = body.initial.unfit(analysis) {
        return Err(FemError::Initial { why });
    }
    if analysis == Analysis::Axisymmetric {
        check_radii(body)?;
    }
    let constraints = Constraints::new((body, &history), analysis, time)?;
    let frames = frames(&constraints);
    let blocks: Vec<Connectivity<'_>> = body
        .mesh
        .blocks()
        .iter()
        .map(|block| Connectivity {
            nodes: &block.nodes,
            nodes_per_cell: block.kind.nodes(),
        })
        .collect();
    let graph = Graph::from_cells(body.mesh.points().len(), &blocks).placed(body.mesh.points());
    let mut stiffness = match is_whole {
        true => stiffness(body, analysis, &graph)?,
        false => stiffness_at(body, analysis, &constraints)?,
    };
    for (row, column, value) in spring_stiffness(body, analysis)? {
        if is_whole || stiffness.stores(row, column) {
            stiffness.add(row, column, value);
        }
    }
    stiffness.turn(&frames);
    let mut held = vec![false; D * body.mesh.points().len()];
    for (dof, _) in held_dofs(&constraints, &frames) {
        held[dof] = true;
    }
    let sprung = sprung_directions(body, analysis)?;
    let held_by = (&constraints, &sprung[..]);
    let mut modes = free_modes(&body.mesh, held_by, RigidBasis::of(analysis));
    for mode in &mut modes {
        into_frames(&frames, mode);
        // held components of a free mode are zero up to rounding: make them exactly zero
        for (value, _) in mode.iter_mut().zip(&held).filter(|(_, held)| **held) {
            *value = 0.0;
        }
    }
    let with = (body, &history);
    let mut driving = Driving::new(with, analysis, time, (&constraints, &frames))?;
    driving.add_yielded(with, analysis, &frames)?;
    Ok(BodySystem {
        graph,
        stiffness,
        load: driving.load,
        largest_load: driving.largest_load,
        constraints,
        held,
        prescribed: driving.prescribed,
        carried: driving.carried,
        lift: driving.lift,
        frames,
        modes,
        history,
        is_whole,
    })
}

/// Coefficients and components of a row below this part of its largest coefficient are rounding: the normals of flat sides and the
/// integrals of biorthogonal functions are that accurate, and the limit of the balance is a thousand times larger.
pub(crate) const ALONG: f64 = 1e-13;

/// Length of the largest coefficient of a row.
pub(crate) fn largest_coefficient<const D: usize>(row: &[(usize, Point<D>)]) -> f64 {
    let lengths = row.iter().map(|(_, coefficients)| norm(*coefficients));
    lengths.fold(0.0, f64::max)
}

/// Driving terms of a body at a time: its loads and prescribed displacements.
struct Driving {
    load: Vec<f64>,
    largest_load: f64,
    prescribed: Vec<f64>,
    carried: Vec<f64>,
    lift: Vec<f64>,
}

impl Driving {
    fn new<const D: usize>(
        (body, history): (&Body<D>, &History<D>),
        analysis: Analysis,
        time: f64,
        (constraints, frames): (&Constraints<D>, &BTreeMap<usize, [[f64; D]; D]>),
    ) -> Result<Self, FemError> {
        let NodalLoads {
            forces: mut load,
            largest: largest_load,
            rounding,
        } = nodal_loads((body, history), analysis, time)?;
        let mut prescribed = vec![0.0; load.len()];
        for (dof, value) in held_dofs(constraints, frames) {
            prescribed[dof] = value;
        }
        for (_, came) in spring_loads((body, history), analysis)? {
            load.iter_mut()
                .zip(came.iter().flatten())
                .for_each(|(f, k)| *f += k);
        }
        // a rigid motion strains springs, too
        let mut carried = match body.springs.is_empty() {
            true => carried_motion(&body.mesh, constraints, RigidBasis::of(analysis)),
            false => vec![0.0; load.len()],
        };
        into_frames(frames, &mut load);
        into_frames(frames, &mut carried);
        // rounding of an initial stress and its loads must not move the body
        for (force, known) in load.chunks_exact_mut(D).zip(rounding) {
            let none = force.iter_mut().filter(|c| c.abs() <= known);
            none.for_each(|c| *c = 0.0);
        }
        let mut lift = vec![0.0; load.len()];
        let largest = prescribed.iter().fold(0.0f64, |l, v| l.max(v.abs()));
        for (dof, value) in held_dofs(constraints, frames) {
            let rest = value - carried[dof];
            // exactly zero where only rounding remains
            if rest.abs() > 1e-13 * largest {
                lift[dof] = rest;
            }
        }
        Ok(Self {
            load,
            largest_load,
            prescribed,
            carried,
            lift,
        })
    }
}

impl Driving {
    /// Driving terms within a step, between those before and those at its end.
    fn on_the_way(&mut self, part: Part, before: Option<Self>) {
        let before = before.as_ref();
        part.mix(&mut self.load, before.map(|b| &b.load[..]));
        part.mix(&mut self.prescribed, before.map(|b| &b.prescribed[..]));
        part.mix(&mut self.carried, before.map(|b| &b.carried[..]));
        part.mix(&mut self.lift, before.map(|b| &b.lift[..]));
    }

    /// Adds the load of the plastic strain.
    fn add_yielded<const D: usize>(
        &mut self,
        (body, history): (&Body<D>, &History<D>),
        analysis: Analysis,
        frames: &BTreeMap<usize, [[f64; D]; D]>,
    ) -> Result<(), FemError> {
        if let Some(yielded) = &history.yielded {
            let forces = yielded.forces(body, analysis)?;
            self.largest_load = self.largest_load.max(Size::of(&forces).scale());
            let mut plastic = forces.concat();
            into_frames(frames, &mut plastic);
            let sums = self.load.iter_mut().zip(plastic);
            sums.for_each(|(sum, force)| *sum += force);
        }
        Ok(())
    }
}

/// Held dofs in the frames of their nodes, with the prescribed displacements.
fn held_dofs<const D: usize>(
    constraints: &Constraints<D>,
    frames: &BTreeMap<usize, [[f64; D]; D]>,
) -> Vec<(usize, f64)> {
    let mut dofs = Vec::new();
    for (&node, directions) in &constraints.nodes {
        let own_frame = frames.contains_key(&node);
        for (k, h) in directions.iter().enumerate() {
            dofs.push(match axis_of(h.axis) {
                Some(axis) if !own_frame => (D * node + axis, h.value * h.axis[axis].signum()),
                _ => (D * node + k, h.value),
            });
        }
    }
    dofs
}

impl<const D: usize> BodySystem<D> {
    /// An elastic part whose dofs are separate springs: stiffness and load of each, dofs without stiffness held. Shapes: (nodes,).
    pub fn elastic(stiffness: &[[f64; D]], load: &[Point<D>]) -> Self {
        let held: Vec<[Option<f64>; D]> = stiffness
            .iter()
            .map(|k| k.map(|k| (k == 0.0).then_some(0.0)))
            .collect();
        let diagonal = stiffness.as_flattened().iter().enumerate();
        let diagonal: Vec<_> = diagonal.map(|(i, &k)| (i, i, k)).collect();
        Self {
            stiffness: SymmetricMatrix::from_triplets(diagonal.len(), &diagonal),
            modes: Vec::new(),
            ..Self::rigid(load, &held)
        }
    }

    /// A rigid part, without stiffness: each component of its nodes is held at a value, or is a mode of its own. Prescribed values
    /// cause no strain in it. Shapes: (nodes,).
    pub fn rigid(load: &[Point<D>], held: &[[Option<f64>; D]]) -> Self {
        let nodes: Vec<u32> = (0..load.len() as u32).collect();
        let single = Connectivity {
            nodes: &nodes,
            nodes_per_cell: 1,
        };
        let held: Vec<Option<f64>> = held.iter().flatten().copied().collect();
        let prescribed: Vec<f64> = held.iter().map(|value| value.unwrap_or(0.0)).collect();
        let held: Vec<bool> = held.iter().map(Option::is_some).collect();
        let dofs = held.len();
        let unit = |i: usize| (0..dofs).map(|j| f64::from(u8::from(i == j))).collect();
        Self {
            graph: Graph::from_cells(load.len(), &[single]),
            stiffness: SymmetricMatrix::from_triplets(dofs, &[]),
            largest_load: load.iter().map(|&force| norm(force)).fold(0.0, f64::max),
            load: load.concat(),
            constraints: Constraints::default(),
            carried: prescribed.clone(),
            prescribed,
            lift: vec![0.0; dofs],
            frames: BTreeMap::new(),
            modes: (0..dofs).filter(|&i| !held[i]).map(unit).collect(),
            held,
            history: History::default(),
            is_whole: true,
        }
    }

    /// Loads and prescribed displacements of a rigid part on the way from another time to this one.
    pub(crate) fn on_the_way(&mut self, part: Part, before: Option<&Self>) {
        part.mix(&mut self.load, before.map(|b| &b.load[..]));
        part.mix(&mut self.prescribed, before.map(|b| &b.prescribed[..]));
        part.mix(&mut self.carried, before.map(|b| &b.carried[..]));
    }

    /// The same body at another time: loads and prescribed displacements are updated; held dofs, K and R stay, because the
    /// directions in which supports hold do not depend on time.
    ///
    /// `body` and `analysis` are those that the system was assembled from.
    /// Errors: contradictory supports, values that are not finite.
    pub fn at_time(self, body: &Body<D>, analysis: Analysis, time: f64) -> Result<Self, FemError> {
        self.at_part(body, analysis, time, None)
    }

    /// The same; with `part` at a fraction of a step.
    pub(crate) fn at_part(
        self,
        body: &Body<D>,
        analysis: Analysis,
        time: f64,
        part: Option<Part>,
    ) -> Result<Self, FemError> {
        let with = (body, &self.history);
        let at = |time: f64| {
            let constraints = Constraints::new(with, analysis, time)?;
            let driving = Driving::new(with, analysis, time, (&constraints, &self.frames))?;
            Ok((constraints, driving))
        };
        let (constraints, mut driving) = at(time)?;
        if let Some(part) = part {
            let before = part.before.map(at).transpose()?;
            driving.on_the_way(part, before.map(|(_, driving)| driving));
        }
        driving.add_yielded(with, analysis, &self.frames)?;
        Ok(Self {
            constraints,
            load: driving.load,
            largest_load: driving.largest_load,
            prescribed: driving.prescribed,
            carried: driving.carried,
            lift: driving.lift,
            ..self
        })
    }

    /// Turns the frames of nodes, the first axis along a direction of length 1 each. Supported nodes keep the frames of their
    /// supports, and turned nodes stay as they are.
    pub(crate) fn turn(&mut self, directions: impl Iterator<Item = (usize, Point<D>)>) {
        let (held, turned) = (&self.constraints.nodes, &self.frames);
        let free = directions.filter(|(n, _)| !held.contains_key(n) && !turned.contains_key(n));
        let frames = free.map(|(node, direction)| (node, completed(vec![direction])));
        let frames: BTreeMap<usize, [[f64; D]; D]> = frames.collect();
        self.stiffness.turn(&frames);
        let vectors = [&mut self.load, &mut self.carried];
        for vector in vectors.into_iter().chain(&mut self.modes) {
            into_frames(&frames, vector);
        }
        self.frames.extend(frames);
    }

    /// Whether frames of nodes have been turned.
    pub(crate) fn is_turned(&self) -> bool {
        let held = &self.constraints.nodes;
        !self.frames.keys().all(|node| held.contains_key(node))
    }

    /// Rotates a vector of global components (D·n,) into the node frames.
    pub fn to_frames(&self, vector: &mut [f64]) {
        into_frames(&self.frames, vector);
    }

    /// Rotates a vector of frame components (D·n,) into global axes, node by node.
    pub fn to_global(&self, vector: &[f64]) -> Vec<Point<D>> {
        let mut points: Vec<Point<D>> = vector
            .chunks_exact(D)
            .map(|c| std::array::from_fn(|i| c[i]))
            .collect();
        for (&node, axes) in &self.frames {
            let local = points[node];
            points[node] = (0..D).fold([0.0; D], |sum, k| add_scaled(sum, local[k], axes[k]));
        }
        points
    }

    /// Adds a multiple of a row of global coefficients by node to the load.
    pub(crate) fn add_force(&mut self, row: &[(usize, Point<D>)], factor: f64) {
        for (dof, value) in self.row_in_frames(row).collect::<Vec<_>>() {
            self.load[dof] += factor * value;
        }
    }

    /// A row of global coefficients by node, by dofs along the frames; rounding relative to its largest coefficient (1e-13) is left
    /// out.
    pub fn row_in_frames(&self, row: &[(usize, Point<D>)]) -> impl Iterator<Item = (usize, f64)> {
        let rounding = ALONG * largest_coefficient(row);
        row.iter().flat_map(move |&(node, row)| {
            let axes = self.frames.get(&node);
            let row = axes.map_or(row, |axes| std::array::from_fn(|k| dot(axes[k], row)));
            let dofs = row.into_iter().enumerate();
            let dofs = dofs.map(move |(k, value)| (D * node + k, value));
            dofs.filter(move |(_, value)| value.abs() > rounding)
        })
    }
}

pub(super) fn into_frames<const D: usize>(
    frames: &BTreeMap<usize, [[f64; D]; D]>,
    vector: &mut [f64],
) {
    for (&node, axes) in frames {
        let global: Point<D> = std::array::from_fn(|i| vector[D * node + i]);
        for k in 0..D {
            vector[D * node + k] = dot(axes[k], global);
        }
    }
}

/// The global axis that a direction is along, either way.
fn axis_of<const D: usize>(direction: Point<D>) -> Option<usize> {
    direction.iter().position(|c| c.abs() == 1.0)
}

/// Frames of the nodes with oblique held directions, these first.
fn frames<const D: usize>(constraints: &Constraints<D>) -> BTreeMap<usize, [[f64; D]; D]> {
    let oblique = constraints
        .nodes
        .iter()
        .filter(|(_, held)| held.iter().any(|h| axis_of(h.axis).is_none()));
    oblique
        .map(|(&node, held)| (node, completed(held.iter().map(|h| h.axis).collect())))
        .collect()
}

/// Any orthonormal completion of orthonormal axes.
pub(crate) fn completed<const D: usize>(mut axes: Vec<Point<D>>) -> [[f64; D]; D] {
    for i in 0..D {
        let unit: Point<D> = std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 });
        let rest = axes
            .iter()
            .fold(unit, |rest, &axis| add_scaled(rest, -dot(unit, axis), axis));
        // of D + |axes| candidates at least one per missing direction keeps this much
        if axes.len() < D && norm(rest) > 0.5 / (D as f64).sqrt() {
            let size = norm(rest);
            axes.push(rest.map(|c| c / size));
        }
    }
    std::array::from_fn(|k| axes[k])
}

fn check_formulation<const D: usize>(body: &Body<D>, analysis: Analysis) -> Result<(), FemError> {
    let modes = |block: &CellBlock| has_modes(block.kind);
    match body.formulation {
        Formulation::Enhanced if analysis == Analysis::Axisymmetric => Err(FemError::Formulation {
            why: "is not supported yet with axial symmetry: use quadratic cells",
        }),
        Formulation::Enhanced if !body.mesh.blocks().iter().any(modes) => {
            Err(FemError::Formulation {
                why: "is for quad4 and hex8 cells, and the body has none: leave it out, or change `cell`",
            })
        }
        _ => Ok(()),
    }
}

fn check_radii<const D: usize>(body: &Body<D>) -> Result<(), FemError> {
    let tolerance = -ON_AXIS * body.mesh.diameter();
    match body.mesh.points().iter().position(|p| p[0] < tolerance) {
        None => Ok(()),
        Some(node) => Err(FemError::NegativeRadius {
            node,
            point: show(body.mesh.points()[node]),
        }),
    }
}

/// Cells per parallel task.
const CHUNK: usize = 128;

/// What is to be kept of the matrices of some cells of a body, `size` numbers of each; `keep` gets a matrix, row by row, and the number
/// of its columns.
fn of_cells<const D: usize>(
    own: &Cells<'_, D>,
    (nodes, each): (&[u32], usize),
    size: usize,
    keep: impl Fn(&[f64], usize, &mut [f64]) + Sync,
) -> Vec<f64> {
    let whole = own.size();
    let mut values = vec![0.0; size * (nodes.len() / each)];
    let chunks = values.par_chunks_mut(size * CHUNK);
    chunks
        .zip(nodes.par_chunks(each * CHUNK))
        .for_each(|(out, cells)| {
            let mut matrix = vec![0.0; whole * whole];
            for (out, cell) in out.chunks_exact_mut(size).zip(cells.chunks_exact(each)) {
                own.stiffness(cell, &mut matrix);
                keep(&matrix, whole, out);
            }
        });
    values
}

/// The packed lower triangles of the matrices of some cells.
fn triangles<const D: usize>(own: &Cells<'_, D>, nodes: &[u32], each: usize) -> Vec<f64> {
    let size = D * each;
    of_cells(
        own,
        (nodes, each),
        size * (size + 1) / 2,
        |matrix, columns, out| {
            for i in 0..size {
                let row = i * (i + 1) / 2;
                out[row..=row + i].copy_from_slice(&matrix[i * columns..=i * columns + i]);
            }
        },
    )
}

/// The same of the block of each of their nodes alone.
fn blocks_of_nodes<const D: usize>(own: &Cells<'_, D>, nodes: &[u32], each: usize) -> Vec<f64> {
    let packed = D * (D + 1) / 2;
    of_cells(own, (nodes, each), packed * each, |matrix, columns, out| {
        for (node, out) in out.chunks_exact_mut(packed).enumerate() {
            for i in 0..D {
                let (row, from) = (i * (i + 1) / 2, (D * node + i) * columns + D * node);
                out[row..=row + i].copy_from_slice(&matrix[from..=from + i]);
            }
        }
    })
}

pub(super) fn stiffness<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    graph: &Graph,
) -> Result<SymmetricMatrix, FemError> {
    let mut matrices = Vec::new();
    for block in body.mesh.blocks() {
        let own = Cells::new(body, block, analysis, body.formulation)?;
        matrices.push(triangles(&own, &block.nodes, block.kind.nodes()));
    }
    let blocks = body.mesh.blocks().iter().zip(&matrices);
    let cells = blocks.map(|(block, values)| CellMatrices {
        nodes: &block.nodes,
        nodes_per_cell: block.kind.nodes(),
        values,
    });
    let cells: Vec<CellMatrices<'_>> = cells.collect();
    assemble_blocks::<D>(graph, &cells).map_err(|source| not_finite(body, source))
}

/// The stiffness of cells at which some node is held, and of the others the blocks of their nodes.
fn stiffness_at<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    constraints: &Constraints<D>,
) -> Result<SymmetricMatrix, FemError> {
    let mut parts = Vec::new();
    for block in body.mesh.blocks() {
        let own = Cells::new(body, block, analysis, body.formulation)?;
        let each = block.kind.nodes();
        let is_held = |cell: &&[u32]| {
            let mut nodes = cell.iter();
            nodes.any(|&node| constraints.nodes.contains_key(&(node as usize)))
        };
        let (held, free): (Vec<&[u32]>, Vec<&[u32]>) = block.cells().partition(is_held);
        let (held, free) = (held.concat(), free.concat());
        let values = triangles(&own, &held, each);
        parts.push((held, each, values));
        let values = blocks_of_nodes(&own, &free, each);
        parts.push((free, 1, values));
    }
    let cells = parts.iter().map(|(nodes, each, values)| CellMatrices {
        nodes,
        nodes_per_cell: *each,
        values,
    });
    let cells: Vec<CellMatrices<'_>> = cells.collect();
    let pairs: Vec<Connectivity<'_>> = cells.iter().map(CellMatrices::connectivity).collect();
    let graph = Graph::from_cells(body.mesh.points().len(), &pairs);
    assemble_blocks::<D>(&graph, &cells).map_err(|source| not_finite(body, source))
}

fn not_finite<const D: usize>(body: &Body<D>, source: LinalgError) -> FemError {
    let node = match source {
        LinalgError::NotFinite { row } => row / D,
        _ => 0,
    };
    FemError::Singular {
        node,
        point: show(body.mesh.points()[node]),
        source,
    }
}
