//! Checks of cells in bodies that bend or keep their volume: linear cells are too stiff, and pressures at single nodes may
//! vanish wrongly.

use crate::fem::{Analysis, INCOMPRESSIBLE, Unseen, unseen};
use crate::geometry::{Point, dot};
use crate::mesh::CellKind;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Body, Model};
use crate::model::nouns::solution::{BodySolution, ContactNode, ContactSolution, Status};
use std::collections::{BTreeMap, BTreeSet};

/// Linear cells that lack more than this part of the compliance of their body are reported.
const LACKING: f64 = 0.08;

/// Stresses of the displacements below this part of the total ones, and strains of that part of a motion, are rounding.
const UNDISTURBED: f64 = 1e-10;

/// A body with less than this part of the energy of all bodies does not count.
const NEGLIGIBLE: f64 = 1e-6;

/// From this Poisson's ratio on, pressures may differ from cell to cell although displacements are right.
const KEEPS_VOLUME: f64 = 0.49;

/// Largest relative difference of pressures from the stresses beside them.
const UNEVEN: f64 = 0.12;

/// A warning about a body whose linear cells are too stiff; `all` is the strain energy of all bodies.
///
/// Errors: a group of cells without a material.
pub(crate) fn too_stiff<const D: usize>(
    (model, time): (&Model<D>, f64),
    body: &Body<D>,
    solved: &BodySolution<D>,
    all: f64,
) -> Result<Option<String>, Error<D>> {
    if solved.strain_energy <= NEGLIGIBLE * all || rests(body, solved) {
        return Ok(None);
    }
    let found = unseen(
        body,
        (model.analysis, time),
        &solved.displacement,
        &solved.strain,
    );
    let Unseen { part, kind } = found.map_err(|source| Error::in_body(body, source))?;
    let Some(kind) = kind.filter(|_| part > LACKING) else {
        return Ok(None);
    };
    let poisson = poisson(body);
    let locks = poisson > INCOMPRESSIBLE && model.analysis != Analysis::PlaneStress;
    let cause = match kind {
        _ if locks => {
            format!("is nearly incompressible (ν = {poisson}), where linear cells lock")
        }
        CellKind::Quad4 => "bends, and its linear quadrilaterals cannot".to_string(),
        CellKind::Hex8 => "bends, and its linear hexahedra cannot".to_string(),
        _ => "bends, or its linear cells are too large".to_string(),
    };
    let cure = instead(kind, model.analysis, locks);
    // around an axis the hoop strain also resists changes of volume, and no mode releases it; heat bends beside what it lengthens
    let turns = model.analysis == Analysis::Axisymmetric;
    let heated = body.initial.strain.is_some();
    let least = if locks && turns || heated {
        "at least"
    } else {
        "about"
    };
    let place = if heated { " where heat bends it" } else { "" };
    Ok(Some(format!(
        "body \"{}\" {cause}: {:.0} % of its energy is in strains of the cells alone, and it gives way too little by {least} as much{place}: use {cure}",
        solved.name,
        100.0 * part
    )))
}

/// A warning about a body that has yielded in linear cells: plastic flow keeps the volume, and such cells then lock.
pub(crate) fn locks_plastic<const D: usize>(
    body: &Body<D>,
    solved: &BodySolution<D>,
) -> Option<String> {
    let yielded = solved.yielding.as_ref().is_some_and(|own| own.extent > 0.0);
    let kinds = body.mesh.blocks().iter().map(|block| block.kind);
    let linear = kinds.into_iter().find(|kind| kind.order() == 1);
    let kind = linear.filter(|_| yielded)?;
    Some(format!(
        "body \"{}\" yields in linear cells ({}): what yields keeps its volume, which they cannot do and deform freely, so that they give way too little and bear too much; use quadratic cells",
        solved.name,
        kind.name()
    ))
}

/// Cells that bend, or keep their volume, in place of linear ones.
fn instead(kind: CellKind, analysis: Analysis, locks: bool) -> &'static str {
    let turns = analysis == Analysis::Axisymmetric;
    match kind {
        CellKind::Quad4 if locks && turns => "tri6",
        CellKind::Quad4 if locks => "tri6, or formulation = \"enhanced\"",
        CellKind::Quad4 if turns => "quad8 or quad9",
        CellKind::Quad4 => "quad8 or quad9, or formulation = \"enhanced\"",
        CellKind::Hex8 if locks => "tet10, or formulation = \"enhanced\"",
        CellKind::Hex8 => "hex20 or hex27, or formulation = \"enhanced\"",
        CellKind::Prism6 => "prism15",
        CellKind::Tet4 => "tet10",
        _ => "tri6",
    }
}

fn poisson<const D: usize>(body: &Body<D>) -> f64 {
    let ratios = body.materials.iter().map(|m| m.elastic.poisson);
    ratios.fold(0.0, f64::max)
}

/// Whether the strains of a body are rounding: in undisturbed ground, and where it moves as a whole.
fn rests<const D: usize>(body: &Body<D>, solved: &BodySolution<D>) -> bool {
    let most = |of: &[f64]| of.iter().fold(0.0, |s: f64, c| s.max(c.abs()));
    let strain = most(solved.strain.as_flattened());
    let young = body.materials.iter().map(|m| m.elastic.young);
    let stiffest = young.fold(0.0, f64::max);
    let motion = most(solved.displacement.as_flattened());
    stiffest * strain <= UNDISTURBED * most(solved.stress.as_flattened())
        || strain * body.mesh.diameter() <= UNDISTURBED * motion
}

/// A warning about a contact of a nearly incompressible body whose pressures differ from the stresses beside them.
///
/// Their sums are right, as displacements are; where the body is too stiff, only that is reported.
pub(crate) fn uneven_pressures<const D: usize>(
    model: &Model<D>,
    contact: &ContactSolution<D>,
    solved: &BodySolution<D>,
    enough: usize,
) -> Option<String> {
    let body = &model.bodies[contact.nonmortar.body.0];
    let ratio = poisson(body);
    if ratio < KEEPS_VOLUME || model.analysis == Analysis::PlaneStress {
        return None;
    }
    let enclosed = enclosed(model, contact);
    let borne = |node: &&ContactNode<D>| match node.status {
        Status::Open => enclosed.contains(&node.node),
        _ => node.pressure > 0.0,
    };
    let mut count = 0;
    let (mut all, mut off) = (0.0, 0.0);
    for node in contact.nodes.iter().filter(borne) {
        let beside = -along(solved.stress[node.node], node.normal);
        count += 1;
        all += node.weight * node.pressure;
        off += node.weight * (node.pressure - beside).abs();
    }
    let turns = model.analysis == Analysis::Axisymmetric;
    let use_ = match D {
        3 => "tet10",
        _ if turns => "smaller tri6",
        _ => "tri6, or quad4 with formulation = \"enhanced\"",
    };
    (count >= enough && off > UNEVEN * all).then(|| {
        format!(
            "contact \"{}\": its pressures differ from the stresses of \"{}\" beside them by {:.0} % on average, because the body is nearly incompressible (ν = {ratio}): forces and displacements hold, pressures and stresses at single nodes alternate; use {use_}",
            contact.name,
            solved.name,
            100.0 * off / all
        )
    })
}

/// Open nodes of the nonmortar side within the contact area: all neighbours along the edges of facets are closed, two at least. If
/// pressures alternate between zero and twice the right value, every second node is such a node.
pub(crate) fn enclosed<const D: usize>(
    model: &Model<D>,
    contact: &ContactSolution<D>,
) -> BTreeSet<usize> {
    let mesh = &model.bodies[contact.nonmortar.body.0].mesh;
    let facing = || contact.nodes.iter().filter(|node| !node.gap.is_nan());
    let closed = facing().filter(|node| node.status != Status::Open);
    let closed: BTreeSet<usize> = closed.map(|node| node.node).collect();
    let mut beside: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for &facet in mesh.side(&contact.nonmortar.side).unwrap_or_default() {
        let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|node| node as usize).collect();
        let corners = mesh.facet_kind(facet).corners();
        let edges = if corners == 2 { 1 } else { corners };
        for k in 0..edges {
            let ends = [nodes[k], nodes[(k + 1) % corners]];
            // a middle node stands between them
            let pairs = match nodes.get(corners + k) {
                Some(&middle) => vec![[ends[0], middle], [middle, ends[1]]],
                None => vec![ends],
            };
            for [a, b] in pairs {
                beside.entry(a).or_default().insert(b);
                beside.entry(b).or_default().insert(a);
            }
        }
    }
    let within = |node: &usize| {
        let surrounded = |beside: &BTreeSet<usize>| beside.len() > 1 && beside.is_subset(&closed);
        !closed.contains(node) && beside.get(node).is_some_and(surrounded)
    };
    facing().map(|node| node.node).filter(within).collect()
}

/// n·σ·n.
fn along<const D: usize>(s: [f64; 6], normal: Point<D>) -> f64 {
    let entry = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    let traction: Point<D> =
        std::array::from_fn(|i| (0..D).map(|j| s[entry[i][j]] * normal[j]).sum());
    dot(traction, normal)
}
