//! Where an answer leaves what the theory assumes: small strains, rotations and slips, and a contact of many nodes.
//!
//! The theory is linear and the sides stay paired as they were: with strains, rotations or slips (in parts of a facet) of 5 %
//! the answer is off by about as much. Peaks at single points, where stresses are singular, say nothing of the whole: a
//! hundredth of the nodes is passed over.

use crate::contact::Coupling;
use crate::fem::{Analysis, Short, Unseen, recover_spin, show, unseen};
use crate::geometry::{Point, Surface, add_scaled, dot, norm, sub};
use crate::model::check::mean_facet;
use crate::model::error::Error;
use crate::model::nouns::{Body, Contact, Model, Pair, Rigid};
use crate::model::pair::Paired;
use crate::model::solution::{BodySolution, ContactNode, ContactSolution, Status};
use rayon::prelude::*;

/// Strains and rotations above this are large.
const LARGE: f64 = 0.05;

/// A body whose linear cells spend more of its energy on what they cannot show gives way by about as much too little.
const UNSEEN: f64 = 0.25;

/// Above this ratio of Poisson it is rather the volume that linear cells cannot keep than their bending.
const INCOMPRESSIBLE: f64 = 0.45;

/// Stresses of the displacements below this part of the total ones are rounding.
const UNDISTURBED: f64 = 1e-10;

/// Part of the nodes that may be singular.
const SINGULAR: f64 = 0.01;

/// A slip above this part of the smaller facet takes a node to another facet.
const FAR: f64 = 0.5;

/// Most contacts that a warning names.
pub(crate) const NAMED: usize = 4;

/// Fewer closed nodes than this tell the edge of a contact only roughly.
const FEW: usize = 5;

/// Warnings about bodies and contacts that leave what is assumed.
///
/// Errors: a group of cells without a material.
pub(crate) fn beyond<const D: usize>(
    (model, time): (&Model<D>, f64),
    paired: &[Paired<D>],
    bodies: &[BodySolution<D>],
    contacts: &[ContactSolution<D>],
) -> Result<Vec<String>, Error<D>> {
    let each = model.bodies.par_iter().zip(bodies);
    let each = each.map(|(body, solved)| of_body((model, time), body, solved));
    let large: Vec<Vec<String>> = each.collect::<Result<_, _>>()?;
    let mut warnings = large.concat();
    let is_loose = |pair: &Paired<D>| pair.interface.coupling != Coupling::Tied;
    let loose = contacts.iter().zip(paired);
    let loose = loose.filter(|(_, pair)| is_loose(pair));
    let loose: Vec<&ContactSolution<D>> = loose.map(|(contact, _)| contact).collect();
    warnings.extend(few_closed(&loose));
    warnings.extend(loose.iter().filter_map(|contact| far_slip(model, contact)));
    let both = model.contacts.iter().zip(contacts).zip(paired);
    let rolled = both.filter(|(_, pair)| is_loose(pair));
    for ((contact, solved), pair) in rolled {
        let rolled = along_a_curve(contact, solved);
        warnings.extend(rolled.or_else(|| met_elsewhere(contact, pair, (solved, bodies))));
    }
    Ok(warnings)
}

/// Warnings about a body that is strained or turned by much, or bends.
fn of_body<const D: usize>(
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
    Ok(told.chain(bent(model, body, solved)?).collect())
}

/// A body of space whose linear cells bend.
fn bent<const D: usize>(
    model: &Model<D>,
    body: &Body<D>,
    solved: &BodySolution<D>,
) -> Result<Option<String>, Error<D>> {
    let most = |of: &[[f64; 6]]| {
        of.as_flattened()
            .iter()
            .fold(0.0, |s: f64, c| s.max(c.abs()))
    };
    let stiffest = body
        .materials
        .iter()
        .map(|m| m.elastic.young)
        .fold(0.0, f64::max);
    // in ground that nobody touches strains are rounding
    let rests = stiffest * most(&solved.strain) <= UNDISTURBED * most(&solved.stress);
    if model.analysis != Analysis::Solid || rests {
        return Ok(None);
    }
    let found = unseen(body, model.analysis, &solved.displacement, &solved.strain);
    let Unseen { modes, jumps } = found.map_err(|source| Error::in_body(body, source))?;
    let name = &solved.name;
    let ratios = body.materials.iter().map(|m| m.elastic.poisson);
    let poisson = ratios.fold(0.0, f64::max);
    let locks = (poisson > INCOMPRESSIBLE)
        .then(|| format!("is nearly incompressible (ν = {poisson}), where linear cells lock"));
    let or = |usual: &str| locks.clone().unwrap_or(usual.to_string());
    Ok(if modes > UNSEEN {
        let part = 100.0 * modes;
        let cause = or("bends, and its linear hexahedra cannot");
        Some(format!(
            "body \"{name}\" {cause}: {part:.0} % of its energy is in strains of the cells alone, and it gives way too little by about as much: use hex20 or hex27, or formulation = \"enhanced\""
        ))
    } else if jumps > UNSEEN {
        let part = 100.0 * jumps;
        let cause = or("bends, or its linear cells are too large");
        Some(format!(
            "body \"{name}\" {cause}: its stresses jump from cell to cell by {part:.0} % of its energy, and it gives way too little: use quadratic cells (tet10, prism15)"
        ))
    } else {
        None
    })
}

/// The largest of some values, those of singular places passed over.
fn usual(mut values: Vec<f64>) -> f64 {
    let singular = (SINGULAR * values.len() as f64).ceil() as usize;
    let last = values.len().checked_sub(1 + singular);
    last.map_or(0.0, |last| {
        *values.select_nth_unstable_by(last, f64::total_cmp).1
    })
}

/// Some names in quotes: the first ones, and how many more there are.
pub(crate) fn named<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let more = match names.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let first: Vec<String> = names
        .take(NAMED)
        .map(|name| format!("\"{name}\""))
        .collect();
    first.join(", ") + &more
}

/// Contacts whose edges lie between nodes, and that have few of them.
fn few_closed<const D: usize>(contacts: &[&ContactSolution<D>]) -> Option<String> {
    let few = |contact: &&&ContactSolution<D>| {
        let facing = || contact.nodes.iter().filter(|node| !node.gap.is_nan());
        let closed = facing().filter(|node| node.status != Status::Open).count();
        (1..FEW).contains(&closed) && closed < facing().count()
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

/// A curved obstacle along which a closed node slips so far that it curves away, s²/2R, by as much as the sides approach.
fn along_a_curve<const D: usize>(of: &Contact<D>, contact: &ContactSolution<D>) -> Option<String> {
    let Pair::Obstacle { obstacle, .. } = &of.pair else {
        return None;
    };
    let Rigid::Surface { surface, .. } = &obstacle.shape else {
        return None;
    };
    // along its axis a cylinder is straight
    let (radius, straight) = match surface {
        Surface::Sphere { radius, .. } => (radius, [0.0; D]),
        Surface::Cylinder { radius, axis, .. } => (radius, *axis),
        Surface::Plane { .. } | Surface::Cone { .. } => return None,
    };
    let around = |slip: Point<D>| norm(add_scaled(slip, -dot(slip, straight), straight));
    let closed = contact
        .nodes
        .iter()
        .filter(|n| n.status != Status::Open && n.slip.iter().all(|s| s.is_finite()));
    let (slip, approach) = closed.fold((0.0f64, 0.0f64), |(slip, approach), node| {
        let jump = node.displacement_nonmortar - node.displacement_mortar;
        (slip.max(around(node.slip)), approach.max(jump.abs()))
    });
    let away = slip * slip / (2.0 * radius);
    (away > LARGE * approach).then(|| {
        format!(
            "contact \"{}\": its curved obstacle slips along it by up to {}, over which it curves away by {}: the contact stays where it was found before anything moved; move the obstacle to its place in the case, and only press it there",
            contact.name,
            Short(slip),
            Short(away)
        )
    })
}

/// A curved obstacle whose motion brings it to where it was not opposite: its overlap with nodes that have no force.
fn met_elsewhere<const D: usize>(
    of: &Contact<D>,
    pair: &Paired<D>,
    (contact, bodies): (&ContactSolution<D>, &[BodySolution<D>]),
) -> Option<String> {
    let Pair::Obstacle { obstacle, .. } = &of.pair else {
        return None;
    };
    let Rigid::Surface { surface, inside } = &obstacle.shape else {
        return None;
    };
    if matches!(surface, Surface::Plane { .. }) {
        return None;
    }
    let motion = pair.obstacle_motion;
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
    let sign = if *inside { -1.0 } else { 1.0 };
    let depth = |node: &ContactNode<D>| {
        let jump = sub(u[node.node], motion);
        let place = add_scaled(node.point, 1.0, jump);
        let outward = surface.normal(place)?.map(|c| sign * c);
        let depth = -sign * surface.distance(place);
        // what conditions in the mean leave at a node is seen as well without the way along the side
        let seen = dot(node.normal, jump) - sign * surface.distance(node.point);
        let new = node.gap.is_nan() || seen < 0.5 * depth;
        // the far side of the obstacle is another one
        (new && dot(outward, node.normal) < 0.0).then_some((depth, node.point))
    };
    let (depth, point) = open.filter_map(depth).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let seen = LARGE * approach + ROUNDING * norm(motion);
    (depth > seen).then(|| {
        format!(
            "contact \"{}\": its obstacle moves to where it overlaps {} by {}, and no force acts there: a contact sees what lies opposite before anything moves; put the obstacle to its place in the case, and only press it there",
            contact.name,
            show(point),
            Short(depth)
        )
    })
}

/// Overlaps below this part of the motion of an obstacle are rounding.
const ROUNDING: f64 = 1e-9;

/// A contact with a node that slips to another facet.
fn far_slip<const D: usize>(model: &Model<D>, contact: &ContactSolution<D>) -> Option<String> {
    let mortar = contact.mortar.as_ref()?;
    let facet = |side: &crate::model::nouns::SideRef| {
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
    (slip > FAR * facet).then(|| {
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
