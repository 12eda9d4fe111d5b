//! From a judged attempt to the solution of a step, with its warnings.

use crate::contact::{Coupling, Row};
use crate::fem::{Short, show};
use crate::model::march::attempt::Attempt;
use crate::model::march::judge::{Blur, Judged, blurred, held_to_overlap, left_to_overlap};
use crate::model::nouns::error::Error;
use crate::model::nouns::members::Member;
use crate::model::nouns::model::Model;
use crate::model::nouns::presence::Stage;
use crate::model::nouns::solution::*;
use crate::model::nouns::told::{listed, named};
use crate::model::read::assumptions::beyond;
use crate::model::read::fields::fields;
use crate::model::read::probe::read_probes;
use crate::model::read::remarks::contact_remarks;
use crate::model::read::section::{exerted, section_forces};
use crate::model::read::singular::peaks;
use crate::model::read::view::View;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, carriers, contact_rows};
use crate::model::system::factor::division;
use crate::model::system::member::member_solutions;
use crate::solve::{Bolt, Outcome};
use std::collections::BTreeMap;
use std::ops::Range;

/// The solution of a step, without its computing times.
///
/// Errors: a group of cells without a material; a probe that cannot be read.
pub(crate) fn finish<const D: usize>(
    stage: &Stage<'_, D>,
    (condensed, view): (&Condensed<D>, &View<D>),
    attempt: Attempt<D>,
    judged: Judged<D>,
    converged: bool,
) -> Result<Solution<D>, Error<D>> {
    let model = stage.model.as_ref();
    let Attempt {
        method,
        outcome,
        history,
        failure,
    } = attempt;
    let lambda = &outcome.multipliers.lambda;
    let mut warnings = condensed.dropped.clone();
    warnings.extend(
        condensed
            .conditions
            .iter()
            .flat_map(|condition| condition.warnings.clone()),
    );
    warnings.extend(view.remarks.iter().cloned());
    warnings.extend(contact_remarks(model, &condensed.conditions));
    warnings.extend(condensed.floating.warnings.iter().cloned());
    let bolts = bolt_reports(model, &outcome, &condensed.conditions, &mut warnings);
    warnings.extend(outcome.remarks.iter().cloned());
    // a body that slides away has no position to report
    let placed = failure.is_none() || outcome.iterations > 0;
    for body in judged.displaced.hovering.iter().filter(|_| placed) {
        let hangs = |member: &&Member<D>| {
            let mut touched = member.line.touched();
            touched.any(|id| model.bodies[id.0].name == *body)
        };
        let mut several: Vec<&str> = Vec::new();
        for member in model.members.iter().filter(hangs) {
            let own = member.kind.words().apart_plural;
            several.extend((!several.contains(&own)).then_some(own));
        }
        let why = match &several[..] {
            [] => "it touches nothing and carries no load".to_string(),
            all => format!(
                "nothing but {} holds it, which leave it free to move, and no load moves it so",
                listed(all, "and")
            ),
        };
        warnings.push(format!(
            "body \"{body}\" hovers: {why}; it is placed by least norm of the displacement"
        ));
    }
    warnings.extend(crude_gaps(
        model,
        condensed,
        (lambda, &judged.displaced.gaps),
    ));
    for (contact, point, depth) in left_to_overlap(model, condensed, &judged.displaced) {
        warnings.push(format!(
            "contact \"{}\": the sides overlap by up to {} at {}, beside nodes that are excluded: nothing keeps them apart there",
            model.contacts[contact].name,
            Short(depth),
            show(point)
        ));
    }
    warnings.extend(peaks_of_slivers(model, condensed, lambda));
    warnings.extend(judged.remarks.iter().cloned());
    for (contact, point, depth) in held_to_overlap(model, condensed, &judged.displaced) {
        warnings.push(format!(
            "contact \"{}\": supports hold nodes of its nonmortar side up to {} deep in the other side, at {}: such nodes have no condition, and the forces beside them are too small; swap nonmortar and mortar, or support other nodes",
            model.contacts[contact].name,
            Short(depth),
            show(point)
        ));
    }
    for (contact, blur) in blurred(model, condensed, &judged, lambda) {
        let name = &model.contacts[contact].name;
        let told = match blur {
            Blur::Apart(gap) => format!(
                "it bears a force although its sides stay {} apart: conditions are means over facets, and these are too large for its curves; use smaller facets there",
                Short(gap)
            ),
            Blur::Unborne(depth) => format!(
                "its sides overlap by up to {} between nodes none of which is closed: its facets are too large to see the contact; use smaller ones there",
                Short(depth)
            ),
            Blur::Untied(place, jump) => format!(
                "at {} its sides part by {} although they are tied: supports hold the corners of a facet on both sides there, which leaves none of its nodes a condition; use smaller facets there, or support one of the two sides alone",
                show(place),
                Short(jump)
            ),
            Blur::Sunk(depth) => format!(
                "its sides have sunk {} into each other between nodes, most of what they have moved: facets of the nonmortar side are too large for what presses on them; use smaller ones there, or swap nonmortar and mortar",
                Short(depth)
            ),
        };
        warnings.push(format!("contact \"{name}\": {told}"));
    }
    let (certificate, overlap) = (judged.certificate, judged.intrusion.clone());
    let exerted = exerted(model, condensed, &judged.displaced, lambda);
    let (mut bodies, contacts, beds) = fields(model, condensed, judged.displaced, lambda)?;
    let peaks = peaks(model, &view.outlines, &bodies, &contacts, condensed.time);
    for (body, [stress, utilisation]) in bodies.iter_mut().zip(peaks) {
        body.peak = stress;
        if let Some(own) = &mut body.utilisation {
            own.peak = utilisation;
        }
    }
    if placed {
        warnings.extend(beyond(
            (model, condensed.time),
            &condensed.conditions,
            &bodies,
            &contacts,
        )?);
    }
    let sections = section_forces(model, (condensed, &view.laid), (&bodies, &exerted))?;
    Ok(Solution {
        time: condensed.time,
        counted_from: None,
        dofs: bodies.iter().map(|body| body.dofs).sum(),
        members: member_solutions(stage, &condensed.conditions, lambda, &bodies)?,
        bodies,
        contacts,
        beds,
        sections,
        certificate,
        overlap,
        converged,
        solver: SolverReport {
            method,
            tried: outcome.tried,
            iterations: outcome.iterations,
            products: outcome.products,
            rho: outcome.rho,
            history,
            bolts,
            contraction: outcome.fixed_point.and_then(|found| found.contraction),
        },
        division: division(
            &condensed.ordered[..model.bodies.len()],
            &condensed.factored,
        ),
        warnings,
        probes: Vec::new(),
        contact_unknowns: condensed.gaps.len(),
        threads: rayon::current_num_threads(),
        seconds: condensed.seconds,
    })
}

/// Makes the displacements of a solution count from where the model says, and reads its probes: the last that is done to it.
///
/// Errors: those of [`read_probes`].
pub(crate) fn tell<const D: usize>(
    model: &Model<D>,
    (condensed, view): (&Condensed<D>, &View<D>),
    solution: &mut Solution<D>,
) -> Result<(), Error<D>> {
    let conditions = &condensed.conditions;
    condensed.state.count(model, conditions, solution);
    solution.probes = read_probes(model, &view.sites, solution)?;
    Ok(())
}

fn bolt_reports<const D: usize>(
    model: &Model<D>,
    outcome: &Outcome,
    conditions: &[Condition<D>],
    warnings: &mut Vec<String>,
) -> Vec<BoltReport<D>> {
    let carriers = carriers(model, conditions);
    let report = |bolt: &Bolt| {
        let (contact, point) = carriers[bolt.index];
        BoltReport {
            contact: conditions[contact].name.clone(),
            point,
            force: bolt.force,
            moved: bolt.moved,
        }
    };
    let reports: Vec<BoltReport<D>> = outcome.bolts.iter().map(report).collect();
    for bolt in reports.iter().filter(|bolt| bolt.moved) {
        warnings.push(format!(
            "the bolt of contact \"{}\" at {} was improper: its force was {:.6e}, a tension; it was moved",
            bolt.contact,
            show(bolt.point),
            bolt.force
        ));
    }
    reports
}

/// The pressure of a sliver of facets is reported where it exceeds all others of its contact by this factor.
const PEAK: f64 = 1.25;

/// Warnings about contacts whose largest pressure is at a node with only a sliver of its support opposite the other side.
fn peaks_of_slivers<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    lambda: &[f64],
) -> Vec<String> {
    let told = |(index, (rows, condition)): (usize, (Range<usize>, &Condition<D>))| {
        let contact = &model.contacts[index];
        let forces = condition.forces(&lambda[rows]);
        let points = model.bodies[condition.nonmortar.body.0].mesh.points();
        let (mut sliver, mut other) = ((0.0, None), 0.0f64);
        for node in &condition.interface.nodes {
            let Some(force) = node.rows[0].map(|row| forces[row]) else {
                continue;
            };
            let pressure = force / node.weight;
            match node.is_sliver() {
                true if pressure > sliver.0 => sliver = (pressure, Some((node, force))),
                true => {}
                false => other = other.max(pressure),
            }
        }
        let (pressure, node) = sliver;
        let (node, force) = node.filter(|_| pressure > PEAK * other)?;
        Some(format!(
            "contact \"{}\": the largest pressure, {} at {}, is that of a node of whose facets {:.1} % face the other side, beside {} elsewhere: its force {} counts, its pressure says nothing; swap nonmortar and mortar, or let a facet end where the other side does",
            contact.name,
            Short(pressure),
            show(points[node.node]),
            100.0 * node.share,
            Short(other),
            Short(force)
        ))
    };
    let pairs = contact_rows(&condensed.conditions);
    let loose = pairs.filter(|(_, (_, condition))| condition.interface.coupling != Coupling::Tied);
    loose.filter_map(told).collect()
}

/// A polygon's distance from its curve matters when it is more than this part of the displacement jump.
const SAGITTA: f64 = 0.01;

/// A polygon that is nearer to its curve in parts of the body lies on it but for rounding.
const FLAT: f64 = 1e-12;

/// Nodes with less than this part of the largest contact force count as unloaded.
const LOADED: f64 = 1e-9;

/// A warning about gaps that were measured between polygons which stand for curves, where these bear a force; forces and `gaps` (m,)
/// are those of the answer.
fn crude_gaps<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    (lambda, gaps): (&[f64], &[f64]),
) -> Option<String> {
    let mut crude: Vec<(f64, f64, &str)> = Vec::new();
    for (index, (rows, condition)) in contact_rows(&condensed.conditions) {
        let contact = &model.contacts[index];
        if condition.touch.missed.iter().all(BTreeMap::is_empty) {
            continue;
        }
        let jumps = rows
            .clone()
            .map(|row| (gaps[row] - condensed.gaps[row]).abs());
        let jump = jumps.fold(0.0, f64::max);
        let forces = condition.forces(&lambda[rows]);
        let largest = forces.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        let missed = |(sides, rows): (&BTreeMap<usize, f64>, &Row<D>)| {
            let missed = rows.iter().filter_map(|(node, _)| sides.get(node));
            missed.copied().fold(0.0, f64::max)
        };
        let normals = condition
            .interface
            .nodes
            .iter()
            .filter_map(|node| node.rows[0]);
        let loaded = normals.filter(|&row| forces[row].abs() > LOADED * largest);
        let missed = loaded.map(|row| {
            let sides = [
                &condition.interface.nonmortar[row],
                &condition.interface.mortar[row],
            ];
            condition
                .touch
                .missed
                .iter()
                .zip(sides)
                .map(missed)
                .fold(0.0, f64::max)
        });
        let missed = missed.fold(0.0, f64::max);
        let diameter = model.bodies[condition.nonmortar.body.0].mesh.diameter();
        if missed > (SAGITTA * jump).max(FLAT * diameter) {
            crude.push((missed, jump, &contact.name));
        }
    }
    let worst = crude
        .iter()
        .max_by(|a, b| (a.0 * b.1).total_cmp(&(b.0 * a.1)))?;
    Some(format!(
        "contact {}: polygons stand for curves from which they are up to {} away, where the displacement jump is {}: measured gaps are too crude; set gap = \"closed\", or give the true `surface` of both sides, or use quadratic cells",
        named(crude.iter().map(|(.., name)| *name)),
        Short(worst.0),
        Short(worst.1)
    ))
}
