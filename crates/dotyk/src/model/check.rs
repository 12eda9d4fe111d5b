//! `check`: what can be said of a model before anything is solved.

use crate::contact::Role;
use crate::dual::{Feasibility, NO_WORK};
use crate::fem::{
    BodySystem, Constraints, OutOfBalance, RigidBasis, Short, describe_motion, fit_rigid,
    list_motions, nearest_node, out_of_balance, show, tilted,
};
use crate::geometry::{Point, add_scaled, distance, dot, norm, unit};
use crate::mesh::Mesh;
use crate::model::admissible::admissible_set;
use crate::model::assumptions::{NAMED, named};
use crate::model::bodies::{LoadedBody, body_rows, driven, largest_load, systems};
use crate::model::error::{Error, Subject};
use crate::model::floating::Floating;
use crate::model::links::complete;
use crate::model::nouns::*;
use crate::model::pair::{Kind, Paired, pair_all, row_ranges};
use crate::model::parts::{couples, first_point};
use crate::model::probe::sites;
use crate::model::section::lay_out;
use crate::model::sliding::sliding;
use crate::model::told::{told_in_steps, told_once};
use crate::model::unglued::unglued;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

/// A contact that does less work on a motion has no part in holding it: modes are scaled to a largest displacement of 1, and half
/// the digits of their normals are good.
const NO_PART: f64 = 1e-8;

/// What was found about one body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyCheck<const D: usize> {
    /// Its name.
    pub name: String,
    /// Nodes and cells.
    pub size: [usize; 2],
    /// Quality of the worst cell, in (0, 1].
    pub worst_quality: f64,
    /// Resultant of its loads, with those at points of its couples; what is a rounding of loads that cancel is zero.
    pub load: Point<D>,
    /// Number of held dofs.
    pub held: usize,
    /// Rigid motions that the supports leave free, each with what holds it; in one text where nothing can.
    pub floating: Vec<String>,
    /// Its couples, each with what its point is held by and carries.
    pub couples: Vec<String>,
}

/// What was found about one contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCheck<const D: usize> {
    /// Its name.
    pub name: String,
    /// `body.side` of the side that carries the multipliers, and of what it touches.
    pub sides: [String; 2],
    /// Multipliers.
    pub unknowns: usize,
    /// Nodes of the nonmortar side.
    pub nodes: usize,
    /// Nodes of the nonmortar side that face nothing, by position.
    pub alone: Vec<Point<D>>,
    /// Largest initial penetration (zero: none).
    pub penetration: f64,
    /// Smallest initial clearance.
    pub clearance: f64,
    /// The gap is given, so that a penetration is an interference that is meant.
    pub given: bool,
    /// Mean length of the facets of the nonmortar side.
    pub facet: f64,
}

/// What was found about a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Check<const D: usize> {
    /// One per body.
    pub bodies: Vec<BodyCheck<D>>,
    /// One per contact.
    pub contacts: Vec<ContactCheck<D>>,
    /// What makes a solution impossible.
    pub errors: Vec<String>,
    /// What the first error is about.
    pub subject: Option<Subject>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Cells below this quality are worth a warning.
const POOR: f64 = 0.1;

/// Gaps below this part of the body's size are rounding.
const ROUNDING: f64 = 1e-12;

/// Penetrations below this part of a facet are inaccuracies of coordinates: nodes that near coincide.
const INACCURATE: f64 = 1e-6;

/// What is found of a model that is `valid`, or why it is not.
pub(crate) fn check<const D: usize>(model: &Model<D>, valid: Result<(), Error<D>>) -> Check<D> {
    let mut check = Check::default();
    if let Err(error) = valid.and_then(|()| fill(model, &mut check)) {
        check.subject = error.subject();
        check.errors.push(error.to_string());
    }
    check
}

/// Describes the model in each of its runs of load steps between which nothing comes or goes; of what is there in several,
/// what is said of the last.
fn fill<const D: usize>(model: &Model<D>, check: &mut Check<D>) -> Result<(), Error<D>> {
    let mut before = 0;
    let mut warnings: Vec<Vec<String>> = Vec::new();
    for run in model.runs() {
        let mut of_run = Check::default();
        // what was found before a mistake is told, too
        let filled = fill_run(&run, (model, before), &mut of_run);
        before += run.times.len();
        check
            .bodies
            .retain(|body| !of_run.bodies.iter().any(|b| b.name == body.name));
        check
            .contacts
            .retain(|contact| !of_run.contacts.iter().any(|c| c.name == contact.name));
        check.bodies.append(&mut of_run.bodies);
        check.contacts.append(&mut of_run.contacts);
        warnings.push(told_once(of_run.warnings));
        check.warnings = told_in_steps(warnings.iter().map(Vec::as_slice));
        filled?;
    }
    let place = |name: &str| model.bodies.iter().position(|body| body.name == name);
    check.bodies.sort_by_key(|body| place(&body.name));
    let place = |name: &str| {
        model
            .contacts
            .iter()
            .position(|contact| contact.name == name)
    };
    check.contacts.sort_by_key(|contact| place(&contact.name));
    Ok(())
}

/// Describes a run at its last load step, then looks at the loads of the steps before; `before` it are so many steps of the
/// whole model.
fn fill_run<const D: usize>(
    model: &Model<D>,
    (whole, before): (&Model<D>, usize),
    check: &mut Check<D>,
) -> Result<(), Error<D>> {
    let time = model.last_time();
    let in_step = |error: Error<D>, step: usize| error.in_step(whole, before + step, Vec::new());
    let last = |error: Error<D>| in_step(error, model.times.len());
    let mut systems = systems(model, none(model), time).map_err(last)?;
    let mut motions = Vec::new();
    check.warnings.extend(body_remarks(model));
    for (index, body) in model.bodies.iter().enumerate() {
        let loads = Loads::of(model, index, &systems).map_err(last)?;
        let free = free_motions(model.analysis, body, &systems[index], &loads);
        check
            .bodies
            .push(check_body(body, &systems[index], &loads, &free));
        motions.push(free);
    }
    let points = first_point(model)..;
    for (part, (body, couple)) in points.zip(couples(model)) {
        let arm = couple.arm(&model.bodies[body]);
        let arm = arm.map_err(|source| Error::in_body(&model.bodies[body], source))?;
        let found = check_couple(model, (couple, arm), &systems[part]);
        check.bodies[body].couples.push(found);
    }
    let constraints: Vec<&Constraints<D>> = systems.iter().map(|s| &s.constraints).collect();
    let mut paired = pair_all(model, &constraints, time).map_err(last)?;
    let nothing = BTreeMap::new();
    let dropped = complete(model, &mut systems, (&mut paired, &nothing), time).map_err(last)?;
    sites(model, &paired)?;
    lay_out(model)?;
    check.warnings.extend(dropped);
    let of_pairs = paired.iter().flat_map(|pair| pair.warnings.clone());
    check.warnings.extend(of_pairs);
    check.contacts = check_contacts(model, &paired);
    check.warnings.extend(remarks(&check.contacts));
    let rows = body_rows(&systems, &paired);
    let loaded = systems
        .into_iter()
        .zip(rows)
        .map(|(system, rows)| LoadedBody::new(system, rows));
    let mut bodies: Vec<LoadedBody<D>> = loaded.collect();
    let mut floating = Floating::new(model, &bodies, &paired).map_err(last)?;
    check.warnings.extend(floating.warnings.iter().cloned());
    describe_floating(model, &floating, &paired, &motions, check);
    check_balance(
        model,
        &floating,
        &bodies,
        &paired,
        time,
        &mut check.warnings,
    )
    .map_err(last)?;
    for (index, &time) in model.times.iter().enumerate().rev().skip(1) {
        let at = |error: Error<D>| in_step(error, index + 1);
        (bodies, paired) = driven(model, bodies, paired, time).map_err(at)?;
        floating.set_loads(model, &bodies, &paired).map_err(at)?;
        check_balance(
            model,
            &floating,
            &bodies,
            &paired,
            time,
            &mut check.warnings,
        )
        .map_err(at)?;
    }
    Ok(())
}

/// No system of any body.
fn none<const D: usize>(model: &Model<D>) -> Vec<Option<BodySystem<D>>> {
    model.bodies.iter().map(|_| None).collect()
}

/// What can be said of each contact before anything is solved.
fn check_contacts<const D: usize>(model: &Model<D>, paired: &[Paired<D>]) -> Vec<ContactCheck<D>> {
    let look = |(contact, pair): (&Contact<D>, &Paired<D>)| {
        let nodes = &pair.interface.nodes;
        let carriers = nodes.iter().filter(|n| n.role == Role::Multiplier);
        let gaps: Vec<f64> = carriers.map(|n| n.clearance).collect();
        let mesh = &model.bodies[pair.nonmortar.body.0].mesh;
        let alone = nodes.iter().filter(|n| n.role == Role::Alone);
        let negligible = ROUNDING * mesh.diameter();
        let real = |gap: &f64| if gap.abs() > negligible { *gap } else { 0.0 };
        let gaps: Vec<f64> = gaps.iter().map(real).collect();
        let deep = gaps.iter().filter(|gap| **gap < 0.0);
        let name = |side: &SideRef| format!("{}.{}", model.bodies[side.body.0].name, side.side);
        ContactCheck {
            name: contact.name.clone(),
            sides: [
                name(&pair.nonmortar),
                pair.mortar
                    .as_ref()
                    .map_or("rigid obstacle".to_string(), name),
            ],
            unknowns: gaps.len(),
            nodes: nodes.len(),
            alone: alone.map(|n| mesh.points()[n.node]).collect(),
            penetration: deep.fold(0.0, |largest, gap| f64::max(largest, -gap)),
            clearance: gaps.iter().copied().fold(f64::INFINITY, f64::min),
            given: matches!(contact.gap, Some(Gap::Given(_))),
            facet: mean_facet(mesh, &pair.nonmortar.side),
        }
    };
    model.contacts.iter().zip(paired).map(look).collect()
}

/// What a run should say of bodies, too.
pub(crate) fn body_remarks<const D: usize>(model: &Model<D>) -> Vec<String> {
    let bodies = model.bodies.par_iter().enumerate();
    let bodies = bodies.flat_map_iter(|(index, _)| of_body(model, BodyId(index)));
    poor_cells(model)
        .into_iter()
        .chain(bodies.collect::<Vec<_>>())
        .collect()
}

/// What a run should say of contacts, too, at the time of their gaps.
pub(crate) fn contact_remarks<const D: usize>(
    model: &Model<D>,
    paired: &[Paired<D>],
) -> Vec<String> {
    let contacts = check_contacts(model, paired);
    let mut found = remarks(&contacts);
    let pairs = model.contacts.iter().zip(paired);
    found.extend(pairs.filter_map(|(contact, pair)| unlike(model, contact, pair)));
    found
}

/// Two bodies of different thickness: a traction is over one of them.
fn unlike<const D: usize>(
    model: &Model<D>,
    contact: &Contact<D>,
    pair: &Paired<D>,
) -> Option<String> {
    let own = &model.bodies[pair.nonmortar.body.0];
    let other = &model.bodies[pair.mortar.as_ref()?.body.0];
    (own.thickness != other.thickness).then(|| {
        format!(
            "contact \"{}\": body \"{}\" is {} thick and body \"{}\" {}: pressures and bounds of shear are over the thickness of the first, which carries the contact forces",
            contact.name, own.name, own.thickness, other.name, other.thickness
        )
    })
}

/// Errors: a load that no contact force can balance.
fn check_balance<const D: usize>(
    model: &Model<D>,
    floating: &Floating,
    bodies: &[LoadedBody<D>],
    paired: &[Paired<D>],
    time: f64,
    warnings: &mut Vec<String>,
) -> Result<(), Error<D>> {
    let admissible = admissible_set(model, paired, time)?;
    let force = largest_load(bodies);
    let feasible = Feasibility::of(&admissible, &floating.balance, force);
    if let Feasibility::Infeasible { direction, factor } = feasible {
        let parts = (floating, bodies, paired);
        let slides = sliding(model, parts, &admissible, (&direction, factor), None)?;
        warnings.push(slides.to_string());
    }
    Ok(())
}

/// Which contacts and couples do work on each of the free `motions` of the bodies.
fn describe_floating<const D: usize>(
    model: &Model<D>,
    floating: &Floating,
    paired: &[Paired<D>],
    motions: &[Vec<FreeMotion>],
    check: &mut Check<D>,
) {
    for body in &mut check.bodies {
        body.floating.clear();
    }
    let ranges: Vec<Range<usize>> = row_ranges(paired).map(|(rows, _)| rows).collect();
    let of_bodies = floating.modes.iter().enumerate();
    for (k, &(body, mode)) in of_bodies.filter(|(_, mode)| mode.0 < model.bodies.len()) {
        let works =
            |range: &Range<usize>| range.clone().any(|i| floating.work(k, i).abs() > NO_PART);
        let holders = |of: fn(Kind) -> bool| {
            let pairs = paired.iter().zip(&ranges);
            let own = pairs.filter(|(pair, _)| of(pair.kind));
            let names = own.filter(|(_, range)| works(range));
            let names = names.map(|(pair, _)| format!("\"{}\"", pair.name));
            names.collect::<Vec<_>>().join(", ")
        };
        let held = [
            ("contact", holders(|kind| kind == Kind::Contact)),
            ("couple", holders(|kind| matches!(kind, Kind::Couple(_)))),
            ("bed", holders(|kind| matches!(kind, Kind::Bed(_)))),
            ("bar", holders(|kind| matches!(kind, Kind::Bar(_)))),
        ];
        let held = held.iter().filter(|(_, names)| !names.is_empty());
        let held = held.map(|(kind, names)| format!("{kind} {names}"));
        let held = match held.collect::<Vec<_>>().join(" and ") {
            none if none.is_empty() => "held by nothing".to_string(),
            all => format!("held by {all}"),
        };
        let FreeMotion { words, load } = &motions[body][mode];
        let found = &mut check.bodies[body].floating;
        found.push(format!("{words}: load on it {}, {held}", Short(*load)));
    }
}

/// What the user should know of contacts; what many of them have in common is told once.
fn remarks<const D: usize>(contacts: &[ContactCheck<D>]) -> Vec<String> {
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

/// What the user should know of a body.
fn of_body<const D: usize>(model: &Model<D>, id: BodyId) -> Vec<String> {
    let body = &model.bodies[id.0];
    moved_points(body)
        .into_iter()
        .chain(moving_ground(model, id))
        .chain(out_of_plane(model.analysis, body))
        .chain(unglued(model, id))
        .collect()
}

/// A warning about an initial stress that is not in equilibrium with the body force: ground that moves before anything is
/// done to it.
fn moving_ground<const D: usize>(model: &Model<D>, id: BodyId) -> Option<String> {
    let body = &model.bodies[id.0];
    let sides = model.contacts.iter().flat_map(|c| c.pair.sides());
    let touched = sides.filter(|side| side.body == id);
    let touched = touched.map(|side| side.side.as_str()).collect();
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

/// Warnings about components of an initial stress out of the plane: one that has been forgotten, and shear that an excavation
/// would release.
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

/// Warnings about point loads and supports that act at a node which is not where they were put.
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

/// A warning about bodies whose cells are badly shaped, first the one with the worst.
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

fn worst_quality<const D: usize>(body: &Body<D>) -> f64 {
    let blocks = body.mesh.blocks().iter().enumerate();
    let cells = blocks.flat_map(|(b, block)| (0..block.cells().len()).map(move |c| (b, c)));
    let quality = cells.map(|(b, c)| body.mesh.cell_quality(b, c));
    quality.fold(1.0, f64::min)
}

/// A couple, and the arm of its rotations, with what its point is held by and carries.
fn check_couple<const D: usize>(
    model: &Model<D>,
    (couple, arm): (&Couple<D>, f64),
    system: &BodySystem<D>,
) -> String {
    let turns = Couple::<D>::turns(model.analysis);
    let about = turns.clone().map(|axis| match D {
        2 => "rotation".to_string(),
        _ => format!("rotation about {}", ["x", "y", "z"][axis]),
    });
    let moves = ["x", "y", "z"].into_iter().take(D);
    let moves = moves.map(|axis| format!("displacement along {axis}"));
    let all: Vec<String> = moves.chain(about).collect();
    let held = all.iter().zip(&system.held).filter(|(_, held)| **held);
    let held: Vec<&str> = held.map(|(name, _)| name.as_str()).collect();
    let held = match held.is_empty() {
        true => "nothing held".to_string(),
        false => format!("held: {}", held.join(", ")),
    };
    let [force, moment] = carried(system);
    let moments: Vec<String> = turns
        .map(|axis| Short(moment[axis - turns_from::<D>()] * arm).to_string())
        .collect();
    let moment = match moments.as_slice() {
        none if none.iter().all(|m| m == "0") => String::new(),
        [one] => format!(", moment {one}"),
        all => format!(", moment ({})", all.join(", ")),
    };
    format!(
        "point \"{}\" at {}: {} couple of side \"{}\", {held}, force {}{moment}",
        couple.name,
        show(couple.point),
        couple.kind.name(),
        couple.side,
        show(force)
    )
}

/// The first axis about which a point of a couple turns.
fn turns_from<const D: usize>() -> usize {
    if D == 2 { 2 } else { 0 }
}

/// What the point of a couple carries: its force, and its moments over the arm.
fn carried<const D: usize>(system: &BodySystem<D>) -> [Point<D>; 2] {
    let loads = system.to_global(&system.load);
    [loads[0], loads[1]]
}

/// What the loads of a body sum up to: those on its nodes, and those at points of its couples, but for what bears a force all the
/// same, such as prestress or the tension of a joint.
struct Loads<'a, const D: usize> {
    /// Forces by node, in the order of the nodes.
    nodes: Vec<Point<D>>,
    /// Couples with their arm, and the system of the point.
    points: Vec<(&'a Couple<D>, f64, &'a BodySystem<D>)>,
}

impl<'a, const D: usize> Loads<'a, D> {
    /// Those of a body, from the systems of all parts.
    ///
    /// Errors: a couple with an unknown side.
    fn of(
        model: &'a Model<D>,
        body: usize,
        systems: &'a [BodySystem<D>],
    ) -> Result<Self, Error<D>> {
        let parts = (first_point(model)..).zip(couples(model));
        let own = parts.filter(|(_, (of, _))| *of == body);
        let point = |(part, (_, couple)): (usize, (usize, &'a Couple<D>))| {
            let arm = couple.arm(&model.bodies[body]);
            let arm = arm.map_err(|source| Error::in_body(&model.bodies[body], source))?;
            Ok((couple, arm, &systems[part]))
        };
        Ok(Self {
            nodes: systems[body].to_global(&systems[body].load),
            points: own.map(point).collect::<Result<_, Error<D>>>()?,
        })
    }

    /// Their resultant, and the sum of their sizes.
    fn resultant(&self) -> (Point<D>, f64) {
        let at_points = self.points.iter().map(|(_, _, system)| carried(system)[0]);
        let all = self.nodes.iter().copied().chain(at_points);
        all.fold(([0.0; D], 0.0), |(sum, size), force| {
            (add_scaled(sum, 1.0, force), size + norm(force))
        })
    }

    /// Their work on a rigid motion, the displacements of all nodes, which takes the points of couples along: Σ f·u + m·ω over
    /// what is free. What is a rounding of the sum is zero.
    fn work(&self, analysis: Analysis, mesh: &Mesh<D>, motion: &[Point<D>]) -> f64 {
        let basis = RigidBasis::of(analysis);
        let mut work: f64 = self
            .nodes
            .iter()
            .zip(motion)
            .map(|(&f, &u)| dot(f, u))
            .sum();
        let mut sizes: f64 = self.nodes.iter().map(|&f| norm(f)).sum();
        for (couple, arm, system) in &self.points {
            let (mut u, spin) = fit_rigid(basis, mesh.points(), motion, couple.point);
            let mut turn = [0.0; D];
            turn.iter_mut().zip(&spin).for_each(|(t, s)| *t = s * arm);
            let [force, moment] = carried(system);
            let free = |k: usize| if system.held[k] { 0.0 } else { 1.0 };
            (0..D).for_each(|k| u[k] *= free(k));
            (0..D).for_each(|k| turn[k] *= free(D + k));
            work += dot(force, u) + dot(moment, turn);
            sizes += norm(force) + norm(moment);
        }
        told(work, sizes)
    }
}

/// A figure that is a sum, with the sum of the sizes of its parts: zero where it is their rounding.
fn told(figure: f64, sizes: f64) -> f64 {
    if figure.abs() <= NO_WORK * sizes {
        0.0
    } else {
        figure
    }
}

/// A rigid motion that the supports of a body leave free, and the work of its loads for a largest displacement of 1.
struct FreeMotion {
    words: String,
    load: f64,
}

/// Each of the motions that the supports of a body leave free.
fn free_motions<const D: usize>(
    analysis: Analysis,
    body: &Body<D>,
    system: &BodySystem<D>,
    loads: &Loads<D>,
) -> Vec<FreeMotion> {
    let describe = |mode: &Vec<f64>| {
        let motion = system.to_global(mode);
        FreeMotion {
            words: describe_motion(body.mesh.points(), &motion),
            load: loads.work(analysis, &body.mesh, &motion),
        }
    };
    system.modes.iter().map(describe).collect()
}

fn check_body<const D: usize>(
    body: &Body<D>,
    system: &BodySystem<D>,
    loads: &Loads<D>,
    free: &[FreeMotion],
) -> BodyCheck<D> {
    let mesh = &body.mesh;
    let (load, sizes) = loads.resultant();
    let words: Vec<String> = free.iter().map(|motion| motion.words.clone()).collect();
    let floating = (!free.is_empty()).then(|| list_motions::<D>(&words));
    BodyCheck {
        name: body.name.clone(),
        size: [mesh.points().len(), mesh.cell_count()],
        worst_quality: worst_quality(body),
        load: load.map(|c| told(c, sizes)),
        held: system.held.iter().filter(|held| **held).count(),
        floating: floating.into_iter().collect(),
        couples: Vec::new(),
    }
}

impl<const D: usize> fmt::Display for Check<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for body in &self.bodies {
            writeln!(
                f,
                "body \"{}\": {} nodes, {} cells, worst cell quality {:.3}, {} dofs held, resultant load {}",
                body.name,
                body.size[0],
                body.size[1],
                body.worst_quality,
                body.held,
                show(body.load)
            )?;
            match body.floating.as_slice() {
                [] => writeln!(f, "  held by its supports")?,
                modes => modes
                    .iter()
                    .try_for_each(|mode| writeln!(f, "  floats: {mode}"))?,
            }
            for couple in &body.couples {
                writeln!(f, "  {couple}")?;
            }
        }
        for contact in &self.contacts {
            write!(
                f,
                "contact \"{}\": {} against {}, {} unknowns",
                contact.name, contact.sides[0], contact.sides[1], contact.unknowns
            )?;
            if !contact.alone.is_empty() {
                write!(f, ", {} nodes face nothing", contact.alone.len())?;
            }
            match contact.penetration {
                _ if contact.unknowns == 0 => writeln!(f)?,
                0.0 if contact.clearance > 0.0 => {
                    writeln!(f, ", initial clearance {:.4e}", contact.clearance)?
                }
                0.0 => writeln!(f, ", touching initially")?,
                depth => writeln!(f, ", initial penetration {depth:.4e}")?,
            }
        }
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        for error in &self.errors {
            writeln!(f, "error: {error}")?;
        }
        Ok(())
    }
}
