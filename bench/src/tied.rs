//! The tied model: both bodies of a case welded together at the coincident nodes of their contact.
//!
//! One body with two materials, one factorisation, one right-hand side: the least cost of any linear analysis of these
//! meshes, by the same kernels as the contact problem. Nodes, sides and groups of the second body follow those
//! of the first; sides are called `BODY.SIDE`, groups by the name of the body.

use dotyk::fem::{
    Analysis, Bed, Body, BodySystem, Load, Material, Place, Spring, Support, assemble,
};
use dotyk::geometry::distance;
use dotyk::linalg::{self, Cholesky, expand_to_dofs, fill_reducing_order};
use dotyk::mesh::{CellBlock, Facet, Mesh};
use dotyk::model::{Model, Pair};
use std::collections::BTreeMap;
use std::time::Instant;

/// Two nodes are one within this part of the size of the body.
const COINCIDENT: f64 = 1e-9;

/// Wall seconds of the stages of a linear analysis.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stages {
    /// Stiffness, loads, supports.
    pub assemble: f64,
    /// Fill-reducing order and symbolic analysis.
    pub order: f64,
    /// Numerical factorisation.
    pub factor: f64,
    /// One right-hand side.
    pub solve: f64,
}

impl Stages {
    /// The sum of all stages.
    pub fn total(&self) -> f64 {
        self.assemble + self.order + self.factor + self.solve
    }
}

/// The two bodies of the first contact of a model as one body.
///
/// Errors: in words, when the model has no contact of two bodies or the merged mesh is not valid.
pub fn weld(model: &Model<2>) -> Result<Body<2>, String> {
    let Some(Pair::Given { nonmortar, mortar }) = model.contacts.first().map(|c| &c.pair) else {
        return Err("the case has no contact with a nonmortar and a mortar side".to_string());
    };
    let (first, second) = (
        &model.bodies[nonmortar.body.0],
        &model.bodies[mortar.body.0],
    );
    let side_nodes = |body: &Body<2>, side: &str| body.mesh.side_nodes(side).unwrap_or_default();
    let near = COINCIDENT * first.mesh.diameter();
    let mut points = first.mesh.points().to_vec();
    let mut number = vec![u32::MAX; second.mesh.points().len()];
    let shared = side_nodes(first, &nonmortar.side);
    for node in side_nodes(second, &mortar.side) {
        let at = second.mesh.points()[node as usize];
        let twin = shared
            .iter()
            .find(|&&other| distance(points[other as usize], at) <= near);
        number[node as usize] =
            *twin.ok_or_else(|| format!("no node of {} lies at {at:?}", first.name))?;
    }
    for (number, &point) in number.iter_mut().zip(second.mesh.points()) {
        if *number == u32::MAX {
            *number = points.len() as u32;
            points.push(point);
        }
    }
    let own = |body: &Body<2>, block: &CellBlock, nodes: Vec<u32>| CellBlock {
        kind: block.kind,
        nodes,
        group: Some(body.name.clone()),
    };
    let mut blocks: Vec<CellBlock> = first
        .mesh
        .blocks()
        .iter()
        .map(|b| own(first, b, b.nodes.clone()))
        .collect();
    let before = blocks.len() as u32;
    blocks.extend(second.mesh.blocks().iter().map(|b| {
        let nodes = b.nodes.iter().map(|&node| number[node as usize]).collect();
        own(second, b, nodes)
    }));
    let mut sides: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
    for (body, shift) in [(first, 0), (second, before)] {
        for (side, facets) in body.mesh.sides() {
            let moved = facets.iter().map(|f| Facet {
                block: f.block + shift,
                ..*f
            });
            sides.insert(format!("{}.{side}", body.name), moved.collect());
        }
    }
    let mesh = Mesh::new(points, blocks).and_then(|mesh| mesh.with_sides(sides));
    Ok(Body {
        name: "tied".to_string(),
        mesh: mesh.map_err(|error| error.to_string())?.into(),
        materials: [first, second].into_iter().flat_map(materials).collect(),
        thickness: first.thickness,
        body_force: first.body_force.clone(),
        initial: first.initial.clone(),
        active: first.active,
        release: first.release.clone(),
        supports: [first, second].into_iter().flat_map(supports).collect(),
        springs: [first, second].into_iter().flat_map(springs).collect(),
        loads: [first, second].into_iter().flat_map(loads).collect(),
        formulation: Default::default(),
        couples: Vec::new(),
        cyclic: None,
        surfaces: Default::default(),
        points: Default::default(),
    })
}

fn materials(body: &Body<2>) -> impl Iterator<Item = Material> {
    let group = Some(body.name.clone());
    body.materials.iter().map(move |material| Material {
        group: group.clone(),
        ..material.clone()
    })
}

fn springs(body: &Body<2>) -> impl Iterator<Item = Spring<2>> {
    body.springs.iter().cloned().map(|mut spring| {
        if let Bed::Side { side, .. } = &mut spring.bed {
            *side = format!("{}.{side}", body.name);
        }
        spring
    })
}

fn supports(body: &Body<2>) -> impl Iterator<Item = Support<2>> {
    body.supports.iter().map(|support| Support {
        place: match &support.place {
            Place::Side(side) => Place::Side(format!("{}.{side}", body.name)),
            Place::Point(point) => Place::Point(*point),
        },
        ..support.clone()
    })
}

fn loads(body: &Body<2>) -> impl Iterator<Item = Load<2>> {
    let name = |side: &str| format!("{}.{side}", body.name);
    body.loads.iter().map(move |load| match load {
        Load::Traction { side, traction } => Load::Traction {
            side: name(side),
            traction: traction.clone(),
        },
        Load::Pressure { side, pressure } => Load::Pressure {
            side: name(side),
            pressure: pressure.clone(),
        },
        force => force.clone(),
    })
}

/// Assembles, factors and solves a supported body; its displacement (dofs,) and the seconds.
///
/// Errors: in words.
pub fn solve(
    body: &Body<2>,
    analysis: Analysis,
) -> Result<(BodySystem<2>, Vec<f64>, Stages), String> {
    let mut clock = Instant::now();
    let mut lap = || {
        std::mem::replace(&mut clock, Instant::now())
            .elapsed()
            .as_secs_f64()
    };
    let mut stages = Stages::default();
    let system = assemble(body, analysis, 1.0).map_err(|error| error.to_string())?;
    stages.assemble = lap();
    let keep: Vec<bool> = system.held.iter().map(|held| !held).collect();
    let keep_node: Vec<bool> = keep
        .chunks_exact(2)
        .map(|dofs| dofs[0] || dofs[1])
        .collect();
    let nodes = fill_reducing_order(&system.graph, &keep_node, &[]);
    let order = expand_to_dofs(&nodes, 2, &keep);
    let analysis = linalg::SymbolicCholesky::new(&system.stiffness, &order, 0)
        .map_err(|error| error.to_string())?;
    stages.order = lap();
    let factor: Cholesky = analysis
        .factor(&system.stiffness)
        .map_err(|error| error.to_string())?;
    stages.factor = lap();
    let mut displacement = system.load.clone();
    factor.solve(&mut displacement);
    stages.solve = lap();
    Ok((system, displacement, stages))
}

/// Largest entry of f − Ku on the free dofs, relative to the largest entry of f.
pub fn residual(system: &BodySystem<2>, displacement: &[f64]) -> f64 {
    let mut product = vec![0.0; displacement.len()];
    system.stiffness.mul(displacement, &mut product);
    let free = (0..product.len()).filter(|&dof| !system.held[dof]);
    let largest = free
        .map(|dof| (system.load[dof] - product[dof]).abs())
        .fold(0.0, f64::max);
    largest / system.load.iter().fold(0.0, |s: f64, f| s.max(f.abs()))
}
