//! Remarks of a run and a check on bodies and contacts as they are given.

use crate::contact::{Role, nodal_weights};
use crate::fem::{OutOfBalance, Short, nearest_node, out_of_balance, show, tilted};
use crate::geometry::{Point, distance, unit};
use crate::mesh::Mesh;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::*;
use crate::model::nouns::presence::Stage;
use crate::model::nouns::told::{NAMED, named};
use crate::model::read::unglued::unglued;
use crate::model::system::condition::Condition;
use rayon::prelude::*;

/// Description of one contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCheck<const D: usize> {
    /// Its name.
    pub name: String,
    /// `body.side` of the side that carries the multipliers, and of the other side.
    pub sides: [String; 2],
    /// Multipliers.
    pub unknowns: usize,
    /// Nodes of the nonmortar side.
    pub nodes: usize,
    /// Nodes of the nonmortar side without an opposite side, by position.
    pub alone: Vec<Point<D>>,
    /// Largest initial penetration (zero without any).
    pub penetration: f64,
    /// Smallest initial clearance.
    pub clearance: f64,
    /// Largest initial clearance of a node with a multiplier.
    pub farthest: f64,
    /// Facets of both sides, and their length, in space their area; one of an obstacle.
    pub extents: Vec<(usize, f64)>,
    /// The gap is given, so that a penetration is an intended interference.
    pub given: bool,
    /// Mean length of the facets of the nonmortar side.
    pub facet: f64,
}

/// Cells below this quality are worth a warning.
const POOR: f64 = 0.1;

/// Gaps below this part of the body's size are rounding.
const GAP_ROUNDING: f64 = 1e-12;

/// Penetrations below this part of a facet are inaccuracies of coordinates: nodes that near coincide.
const INACCURATE: f64 = 1e-6;

/// Description of each contact before the solution.
pub(crate) fn check_contacts<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
) -> Vec<ContactCheck<D>> {
    let look = |condition: &Condition<D>| {
        let contact = condition.contact_of(model)?;
        let nodes = &condition.interface.nodes;
        let carriers = nodes.iter().filter(|n| n.role == Role::Multiplier);
        let gaps: Vec<f64> = carriers.map(|n| n.clearance).collect();
        let mesh = &model.bodies[condition.nonmortar.body.0].mesh;
        let alone = nodes.iter().filter(|n| n.role == Role::Alone);
        let negligible = GAP_ROUNDING * mesh.diameter();
        let real = |gap: &f64| if gap.abs() > negligible { *gap } else { 0.0 };
        let gaps: Vec<f64> = gaps.iter().map(real).collect();
        let deep = gaps.iter().filter(|gap| **gap < 0.0);
        let name = |side: &SideRef| format!("{}.{}", model.bodies[side.body.0].name, side.side);
        Some(ContactCheck {
            name: contact.name.clone(),
            sides: [
                name(&condition.nonmortar),
                condition
                    .mortar
                    .as_ref()
                    .map_or("rigid obstacle".to_string(), name),
            ],
            unknowns: gaps.len(),
            nodes: nodes.len(),
            alone: alone.map(|n| mesh.points()[n.node]).collect(),
            penetration: deep.fold(0.0, |largest, gap| f64::max(largest, -gap)),
            clearance: gaps.iter().copied().fold(f64::INFINITY, f64::min),
            farthest: gaps.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            extents: sides_of(condition)
                .map(|side| extent(model, side))
                .collect(),
            given: matches!(contact.gap, Some(Gap::Given(_))),
            facet: mean_facet(mesh, &condition.nonmortar.side),
        })
    };
    conditions.iter().filter_map(look).collect()
}

/// The sides of a condition, that of the multipliers first.
fn sides_of<const D: usize>(condition: &Condition<D>) -> impl Iterator<Item = &SideRef> {
    [&condition.nonmortar].into_iter().chain(&condition.mortar)
}

/// The facets of a side, and their length or area.
fn extent<const D: usize>(model: &Model<D>, side: &SideRef) -> (usize, f64) {
    let mesh = &model.bodies[side.body.0].mesh;
    let facets = mesh.side(&side.side).unwrap_or_default();
    let weights = nodal_weights(mesh, facets.iter().copied(), model.analysis, 1.0);
    (
        facets.len(),
        weights.values().map(|weight| weight.extent).sum(),
    )
}

/// Remarks on bodies that a run reports, too.
pub(crate) fn body_remarks<const D: usize>(stage: &Stage<'_, D>) -> Vec<String> {
    let model = stage.model.as_ref();
    let bodies = model.bodies.par_iter().enumerate();
    let bodies = bodies.flat_map_iter(|(index, _)| of_body(stage, BodyId(index)));
    poor_cells(model)
        .into_iter()
        .chain(bodies.collect::<Vec<_>>())
        .collect()
}

/// Remarks on contacts that a run reports, too, at the time of their gaps.
pub(crate) fn contact_remarks<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
) -> Vec<String> {
    let contacts = check_contacts(model, conditions);
    let mut found = remarks(&contacts);
    found.extend(
        conditions
            .iter()
            .filter_map(|condition| unlike(model, condition.contact_of(model)?, condition)),
    );
    found
}

/// A warning about two bodies of different thickness: a traction refers to one of them.
fn unlike<const D: usize>(
    model: &Model<D>,
    contact: &Contact<D>,
    condition: &Condition<D>,
) -> Option<String> {
    let own = &model.bodies[condition.nonmortar.body.0];
    let other = &model.bodies[condition.mortar.as_ref()?.body.0];
    (own.thickness != other.thickness).then(|| {
        format!(
            "contact \"{}\": body \"{}\" is {} thick and body \"{}\" {}: pressures and bounds of shear are over the thickness of the first, which carries the contact forces",
            contact.name, own.name, own.thickness, other.name, other.thickness
        )
    })
}

/// Warnings about contacts; a warning common to many of them is given once.
pub(crate) fn remarks<const D: usize>(contacts: &[ContactCheck<D>]) -> Vec<String> {
    let idle = |c: &&ContactCheck<D>| !c.alone.is_empty() && c.alone.len() == c.nodes;
    let in_part = |c: &&ContactCheck<D>| !c.alone.is_empty() && c.alone.len() < c.nodes;
    let deep = |c: &&ContactCheck<D>| c.penetration > INACCURATE * c.facet && !c.given;
    let nothing = |c: &ContactCheck<D>| {
        let (name, [own, other]) = (&c.name, &c.sides);
        format!("contact \"{name}\": no node of {own} faces {other}; the contact does nothing")
    };
    let some = |c: &ContactCheck<D>| {
        let (name, alone, nodes, own) = (&c.name, c.alone.len(), c.nodes, &c.sides[0]);
        format!("contact \"{name}\": {alone} of {nodes} nodes of {own} face nothing")
    };
    let pressed = |name: String, depth: f64| {
        format!(
            "contact {name}: initial penetration of {depth:.4e}; the bodies will be pressed apart by it"
        )
    };
    let names = |of: &[&ContactCheck<D>]| named(of.iter().map(|c| c.name.as_str()));
    let mut remarks: Vec<String> = contacts.iter().filter(idle).map(nothing).collect();
    let of: Vec<&ContactCheck<D>> = contacts.iter().filter(in_part).collect();
    match of.len() > NAMED {
        true => remarks.push(format!(
            "contact {}: some nodes of their nonmortar sides face nothing",
            names(&of)
        )),
        false => remarks.extend(of.into_iter().map(some)),
    }
    let of: Vec<&ContactCheck<D>> = contacts.iter().filter(deep).collect();
    match of.len() > NAMED {
        true => {
            let largest = of.iter().map(|c| c.penetration).fold(0.0, f64::max);
            remarks.push(pressed(names(&of), largest));
        }
        false => {
            let each = of.into_iter();
            remarks.extend(each.map(|c| pressed(format!("\"{}\"", c.name), c.penetration)));
        }
    }
    remarks
}

/// Warnings about a body.
fn of_body<const D: usize>(stage: &Stage<'_, D>, id: BodyId) -> Vec<String> {
    let model = stage.model.as_ref();
    let body = &model.bodies[id.0];
    moved_points(body)
        .into_iter()
        .chain(moving_ground(stage, id))
        .chain(out_of_plane(model.analysis, body))
        .chain(unglued(model, id))
        .collect()
}

/// A warning about an initial stress that is not in equilibrium with the body force: ground that moves without any change of
/// loads or supports.
fn moving_ground<const D: usize>(stage: &Stage<'_, D>, id: BodyId) -> Option<String> {
    let model = stage.model.as_ref();
    let (body, touched) = (&model.bodies[id.0], stage.touched(id));
    let first = model.times.first().copied().unwrap_or(1.0);
    if let Some((vertical, weight)) = tilted(body, model.analysis, first).ok()? {
        return Some(format!(
            "body \"{}\": the vertical of its initial stress is along {}, its body force along {}: these are not in equilibrium; give the stress the `direction` in which gravity acts",
            body.name,
            show(vertical),
            show(unit(weight)?)
        ));
    }
    let OutOfBalance { force, part, at } =
        out_of_balance(body, model.analysis, first, &touched).ok()??;
    Some(format!(
        "body \"{}\": its initial stress is not in equilibrium with its body force: at {} a nodal force of {} is left over, {} of those of the stress around it, and moves the ground; make the stress grow with depth as the weight does, and let sides that it reaches carry a support, a contact or `in_situ`",
        body.name,
        show(at),
        Short(force),
        Short(part)
    ))
}

/// Warnings about out-of-plane components of an initial stress: a forgotten one, and shear that an excavation would release.
fn out_of_plane<const D: usize>(analysis: Analysis, body: &Body<D>) -> Vec<String> {
    let (Some(stress), Analysis::PlaneStrain) = (&body.initial.stress, analysis) else {
        return Vec::new();
    };
    let [xx, yy, zz, _, yz, xz] =
        [0, 1, 2, 3, 4, 5].map(|c| stress.0[c].as_constant() != Some(0.0));
    let name = &body.name;
    let mut warnings = Vec::new();
    if xx && yy && !zz {
        warnings.push(format!(
            "body \"{name}\": zz of its initial stress, out of the plane, is zero: stresses along z are told without it"
        ));
    }
    if yz || xz {
        warnings.push(format!(
            "body \"{name}\": yz and xz of its initial stress are told as they are: a plane body does not move out of its plane, and what an excavation releases of them has no effect"
        ));
    }
    warnings
}

/// A point nearer to a node than this part of the body's size is that node: places are typed with ten digits at most.
const ON_A_NODE: f64 = 1e-9;

/// Warnings about point loads and supports that act at a node away from the given point.
fn moved_points<const D: usize>(body: &Body<D>) -> Vec<String> {
    let loads = body.loads.iter().map(|load| ("force", load.place()));
    let supports = body
        .supports
        .iter()
        .map(|support| ("support", support.place.clone()));
    let springs = body.springs.iter().map(|spring| ("spring", spring.place()));
    let moved = loads
        .chain(supports)
        .chain(springs)
        .filter_map(|(what, place)| {
            let Place::Point(point) = place else {
                return None;
            };
            let node = nearest_node(&body.mesh, point, what).ok()?;
            let there = body.mesh.points()[node];
            let away = distance(point, there);
            (away > ON_A_NODE * body.mesh.diameter()).then(|| {
                format!(
                    "body \"{}\": the {what} at {} acts at its nearest node {}, {:.4e} away",
                    body.name,
                    show(point),
                    show(there),
                    away
                )
            })
        });
    moved.collect()
}

/// A warning about bodies with badly shaped cells, beginning with the worst.
fn poor_cells<const D: usize>(model: &Model<D>) -> Option<String> {
    let bodies = model.bodies.par_iter();
    let all = bodies.map(|body| (worst_quality(body), body.name.as_str()));
    let mut poor: Vec<(f64, &str)> = all.filter(|(worst, _)| *worst < POOR).collect();
    poor.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (worst, _) = poor.first()?;
    let names = named(poor.iter().map(|(_, name)| *name));
    Some(format!(
        "body {names}: the worst cell has quality {worst:.3} (1 is best); the result near it is poor"
    ))
}

pub(crate) fn mean_facet<const D: usize>(mesh: &Mesh<D>, side: &str) -> f64 {
    let facets = mesh.side(side).unwrap_or_default();
    let total: f64 = facets.iter().map(|&facet| mesh.facet_length(facet)).sum();
    total / facets.len().max(1) as f64
}

pub(crate) fn worst_quality<const D: usize>(body: &Body<D>) -> f64 {
    let blocks = body.mesh.blocks().iter().enumerate();
    let cells = blocks.flat_map(|(b, block)| (0..block.cells().len()).map(move |c| (b, c)));
    let quality = cells.map(|(b, c)| body.mesh.cell_quality(b, c));
    quality.fold(1.0, f64::min)
}
