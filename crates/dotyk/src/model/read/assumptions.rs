//! Checks of the assumptions of the theory: small strains, rotations and slips, and a contact of many nodes.
//!
//! The theory is linear and the sides stay paired as they were: with strains, rotations or slips (in parts of a facet) of 5 %
//! the answer is off by about as much. Peaks at single points, where stresses are singular, do not count: a hundredth of the
//! nodes is skipped.

use crate::contact::Coupling;
use crate::fem::{Short, recover_spin, show};
use crate::geometry::{Point, Surface, add_scaled, dot, norm, sub};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Body, Contact, Model, Pair, Rigid};
use crate::model::nouns::solution::{BodySolution, ContactNode, ContactSolution, Status};
use crate::model::nouns::told::named;
use crate::model::read::remarks::mean_facet;
use crate::model::read::stiff::{enclosed, locks_plastic, too_stiff, uneven_pressures};
use crate::model::system::condition::Condition;
use rayon::prelude::*;

/// Strains and rotations above this are large.
const LARGE: f64 = 0.05;

/// Part of the nodes that may be singular.
const SINGULAR: f64 = 0.01;

/// A slip above this part of the smaller facet takes a node to another facet.
const FAR_SLIP: f64 = 0.5;

/// Fewer closed nodes than this locate the edge of a contact only roughly.
const FEW: usize = 5;

/// Warnings about bodies and contacts beyond the assumptions.
///
/// Errors: a group of cells without a material.
pub(crate) fn beyond<const D: usize>(
    (model, time): (&Model<D>, f64),
    conditions: &[Condition<D>],
    bodies: &[BodySolution<D>],
    contacts: &[ContactSolution<D>],
) -> Result<Vec<String>, Error<D>> {
    let all: f64 = bodies.iter().map(|solved| solved.strain_energy).sum();
    let each = model.bodies.par_iter().zip(bodies);
    let each = each.map(|(body, solved)| {
        let stiff = too_stiff((model, time), body, solved, all)?;
        let stiff = stiff.into_iter().chain(locks_plastic(body, solved));
        Ok((large((model, time), body, solved)?, stiff.collect()))
    });
    let told: Vec<(Vec<String>, Vec<String>)> = each.collect::<Result<_, Error<D>>>()?;
    let of_bodies = told
        .iter()
        .flat_map(|(large, stiff)| large.iter().chain(stiff));
    let mut warnings: Vec<String> = of_bodies.cloned().collect();
    let is_loose = |condition: &Condition<D>| condition.interface.coupling != Coupling::Tied;
    let loose = contacts.iter().zip(conditions);
    let loose = loose.filter(|(_, condition)| is_loose(condition));
    let loose: Vec<&ContactSolution<D>> = loose.map(|(contact, _)| contact).collect();
    warnings.extend(few_closed(model, &loose));
    warnings.extend(loose.iter().filter_map(|contact| far_slip(model, contact)));
    let uneven = loose.iter().filter_map(|contact| {
        let body = contact.nonmortar.body.0;
        let enough = FEW * (D - 1);
        let holds = told[body].1.is_empty();
        holds.then(|| uneven_pressures(model, contact, &bodies[body], enough))?
    });
    warnings.extend(uneven);
    let both = model.contacts.iter().zip(contacts).zip(conditions);
    let rolled = both.filter(|(_, condition)| is_loose(condition));
    for ((contact, solved), condition) in rolled {
        let rolled = along_a_curve(contact, solved);
        warnings.extend(rolled.or_else(|| met_elsewhere(contact, condition, (solved, bodies))));
    }
    Ok(warnings)
}

/// Warnings about large strains or rotations of a body.
fn large<const D: usize>(
    (model, time): (&Model<D>, f64),
    body: &Body<D>,
    solved: &BodySolution<D>,
) -> Result<Vec<String>, Error<D>> {
    let spins = recover_spin(body, model.analysis, &solved.displacement, time);
    let spins = spins.map_err(|source| Error::in_body(body, source))?;
    let strain = |e: &[f64; 6]| e.iter().fold(0.0, |largest: f64, e| largest.max(e.abs()));
    let strains = solved.strain.iter().map(strain).collect();
    let turns = spins.iter().map(|spin| norm(*spin)).collect();
    let figures = [("strained", usual(strains)), ("turned", usual(turns))];
    let large = figures.into_iter().filter(|(_, value)| *value > LARGE);
    let told = large.map(|(what, value)| {
        format!(
            "body \"{}\" is {what} by up to {:.1} %: the theory is for small strains and rotations, and off by about as much",
            solved.name,
            100.0 * value
        )
    });
    Ok(told.collect())
}

/// The largest of some values, those of singular places skipped.
fn usual(mut values: Vec<f64>) -> f64 {
    let singular = (SINGULAR * values.len() as f64).ceil() as usize;
    let last = values.len().checked_sub(1 + singular);
    last.map_or(0.0, |last| {
        *values.select_nth_unstable_by(last, f64::total_cmp).1
    })
}

/// Contacts with few closed nodes, whose edges lie between nodes.
fn few_closed<const D: usize>(
    model: &Model<D>,
    contacts: &[&ContactSolution<D>],
) -> Option<String> {
    let few = |contact: &&&ContactSolution<D>| {
        let facing = || contact.nodes.iter().filter(|node| !node.gap.is_nan());
        let closed = facing().filter(|node| node.status != Status::Open).count();
        let few = (1..FEW).contains(&closed) && closed < facing().count();
        few && closed + enclosed(model, contact).len() < FEW
    };
    let names: Vec<&str> = contacts
        .iter()
        .filter(few)
        .map(|contact| contact.name.as_str())
        .collect();
    if names.is_empty() {
        return None;
    }
    let names = named(names.into_iter());
    Some(format!(
        "contact {names}: fewer than {FEW} nodes are closed: pressures and lengths in contact are as coarse as that; use smaller facets there"
    ))
}

/// A curved obstacle along which a closed node slips so far that the obstacle curves away from it, by s²/2R where it is round, by as much
/// as the approach of the sides.
fn along_a_curve<const D: usize>(of: &Contact<D>, contact: &ContactSolution<D>) -> Option<String> {
    let Pair::Obstacle { obstacle, .. } = &of.pair else {
        return None;
    };
    let round = |slip: Point<D>, straight: Point<D>, radius: f64| {
        let around = norm(add_scaled(slip, -dot(slip, straight), straight));
        (around, around * around / (2.0 * radius))
    };
    let away = |node: &ContactNode<D>| match &obstacle.shape {
        Rigid::Gap(_) => (0.0, 0.0),
        Rigid::Surface { surface, .. } => match surface {
            Surface::Sphere { radius, .. } => round(node.slip, [0.0; D], *radius),
            // along its axis it is straight
            Surface::Cylinder { radius, axis, .. } => round(node.slip, *axis, *radius),
            Surface::Plane { .. } | Surface::Cone { .. } => (0.0, 0.0),
        },
        Rigid::Tool(tool) => {
            let out = |part: f64| tool.distance(add_scaled(node.point, part, node.slip));
            // along its facet it does not curve
            let along = tool.normal(node.point).map_or(0.0, |n| dot(n, node.slip));
            let away = out(1.0) - out(0.0) - along;
            let rounding = AWAY_ROUNDING * (norm(node.point) + norm(node.slip));
            (norm(node.slip), if away > rounding { away } else { 0.0 })
        }
    };
    let closed = contact
        .nodes
        .iter()
        .filter(|n| n.status != Status::Open && n.slip.iter().all(|s| s.is_finite()));
    let (slip, away, approach) = closed.fold((0.0f64, 0.0f64, 0.0f64), |most, node| {
        let jump = node.displacement_nonmortar - node.displacement_mortar;
        let (slip, away) = away(node);
        (most.0.max(slip), most.1.max(away), most.2.max(jump.abs()))
    });
    (away > LARGE * approach).then(|| {
        format!(
            "contact \"{}\": its curved obstacle slips along it by up to {}, over which it curves away by {}: the contact stays where it was found before anything moved; move the obstacle to its place in the case, and only press it there",
            contact.name,
            Short(slip),
            Short(away)
        )
    })
}

/// A curved obstacle that moves in front of nodes to which it was not opposite: its overlap with nodes without a force.
fn met_elsewhere<const D: usize>(
    of: &Contact<D>,
    condition: &Condition<D>,
    (contact, bodies): (&ContactSolution<D>, &[BodySolution<D>]),
) -> Option<String> {
    let Pair::Obstacle { obstacle, .. } = &of.pair else {
        return None;
    };
    let shape = &obstacle.shape;
    if let Rigid::Gap(_)
    | Rigid::Surface {
        surface: Surface::Plane { .. },
        ..
    } = shape
    {
        return None;
    }
    let motion = condition.touch.obstacle_motion;
    let u = &bodies[contact.nonmortar.body.0].displacement;
    let approach = contact.nodes.iter().map(|node| {
        let jump = node.displacement_nonmortar - node.displacement_mortar;
        if jump.is_finite() { jump.abs() } else { 0.0 }
    });
    let approach = approach.fold(0.0, f64::max);
    let open = contact
        .nodes
        .iter()
        .filter(|node| node.status == Status::Open);
    let depth = |node: &ContactNode<D>| {
        let jump = sub(u[node.node], motion);
        let place = add_scaled(node.point, 1.0, jump);
        let inward = shape.towards(place)?;
        let depth = -shape.distance(place)?;
        // the rest of mean conditions at a node is visible without the motion along the side, too
        let seen = dot(node.normal, jump) - shape.distance(node.point)?;
        let new = node.gap.is_nan() || seen < 0.5 * depth;
        // the far side of the obstacle does not count
        (new && dot(inward, node.normal) > 0.0).then_some((depth, node.point))
    };
    let (depth, point) = open.filter_map(depth).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let seen = LARGE * approach + DRIVE_ROUNDING * norm(motion);
    (depth > seen).then(|| {
        format!(
            "contact \"{}\": its obstacle moves to where it overlaps {} by {}, and no force acts there: a contact sees what lies opposite before anything moves; put the obstacle to its place in the case, and only press it there",
            contact.name,
            show(point),
            Short(depth)
        )
    })
}

/// What a tool curves away along a slip below this part of the coordinates is rounding.
const AWAY_ROUNDING: f64 = 1e-12;

/// Overlaps below this part of the motion of an obstacle are rounding.
const DRIVE_ROUNDING: f64 = 1e-9;

/// A contact with a node that slips to another facet.
fn far_slip<const D: usize>(model: &Model<D>, contact: &ContactSolution<D>) -> Option<String> {
    let mortar = contact.mortar.as_ref()?;
    let facet = |side: &crate::model::nouns::ids::SideRef| {
        mean_facet(&model.bodies[side.body.0].mesh, &side.side)
    };
    let facet = facet(&contact.nonmortar).min(facet(mortar));
    let closed = contact
        .nodes
        .iter()
        .filter(|node| node.status != Status::Open);
    let slips = closed.map(|node| (norm(node.slip), node.point));
    let farthest = slips.filter(|(slip, _)| slip.is_finite());
    let (slip, point) = farthest.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (slip > FAR_SLIP * facet).then(|| {
        format!(
            "contact \"{}\": a closed node at {} slips by {:.1} facets of the finer side: sides stay paired as they were before; use smaller loads or larger facets",
            contact.name,
            show(point),
            slip / facet
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hundredth_of_the_values_is_passed_over() {
        let mut values: Vec<f64> = (0..200).map(|k| f64::from(k) / 200.0).collect();
        values.push(7.0);
        assert_eq!(usual(values), 197.0 / 200.0);
        assert_eq!(usual(vec![1.0]), 0.0);
        assert_eq!(usual(Vec::new()), 0.0);
    }
}
