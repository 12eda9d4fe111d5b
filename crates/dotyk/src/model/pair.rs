//! Contacts as interfaces: which side carries the multipliers, and how the sides are coupled.

use crate::contact::{
    ContactError, End, InitialGap, Interface, pair_nodes, pair_obstacle, unmatched_facing,
};
use crate::fem::{Constraints, FemError, show, side_facets};
use crate::geometry::{Field, distance};
use crate::model::error::Error;
use crate::model::nouns::*;
use rayon::prelude::*;

/// One contact of the model, paired.
pub(crate) struct Paired<const D: usize> {
    /// Side that carries the multipliers.
    pub nonmortar: SideRef,
    /// The other side; `None` for an obstacle.
    pub mortar: Option<SideRef>,
    /// Displacement of the obstacle.
    pub obstacle_motion: [f64; D],
    /// Rows, gaps and weights.
    pub interface: Interface<D>,
}

/// Pairs all contacts, with the gaps at a time.
pub(crate) fn pair_all<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    time: f64,
) -> Result<Vec<Paired<D>>, Error<D>> {
    model
        .contacts
        .par_iter()
        .map(|contact| pair(model, constraints, contact, time))
        .collect()
}

/// The same pairs with the gaps and the motion of obstacles at another time; rows, weights and roles stay.
pub(crate) fn gaps_at<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    paired: Vec<Paired<D>>,
    time: f64,
) -> Result<Vec<Paired<D>>, Error<D>> {
    let at_time = |(contact, mut before): (&Contact<D>, Paired<D>)| {
        if moves(contact) {
            let now = pair(model, constraints, contact, time)?;
            before.obstacle_motion = now.obstacle_motion;
            let nodes = before.interface.nodes.iter_mut();
            nodes
                .zip(now.interface.nodes)
                .for_each(|(node, now)| node.gap = now.gap);
        }
        Ok(before)
    };
    let both = model.contacts.par_iter().zip(paired);
    both.map(at_time).collect()
}

/// Whether the initial gap of a contact may depend on time.
fn moves<const D: usize>(contact: &Contact<D>) -> bool {
    let varies = |field: &Field| field.as_constant().is_none();
    match (&contact.pair, &contact.gap) {
        (Pair::Obstacle { obstacle, .. }, _) => {
            varies(&obstacle.gap) || obstacle.displacement.iter().any(varies)
        }
        (_, Some(Gap::Given(field))) => varies(field),
        _ => false,
    }
}

fn pair<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    contact: &Contact<D>,
    time: f64,
) -> Result<Paired<D>, Error<D>> {
    let fail = |source: ContactError| Error::Contact {
        contact: contact.name.clone(),
        source,
    };
    let end = |side: &'_ SideRef| -> (usize, String) { (side.body.0, side.side.clone()) };
    match &contact.law {
        Law::Frictionless => {}
        Law::Tied => {
            return Err(fail(ContactError::NotYet {
                what: "a tied interface",
            }));
        }
        Law::Coulomb(_) | Law::Tresca(_) => {
            return Err(fail(ContactError::NotYet { what: "friction" }));
        }
    }
    if let Pair::Obstacle {
        nonmortar,
        obstacle,
    } = &contact.pair
    {
        let (body, side) = end(nonmortar);
        let ends = End {
            body: &model.bodies[body],
            side: &side,
            constraints: constraints[body],
        };
        let mut motion = [0.0; D];
        for (component, field) in motion.iter_mut().zip(&obstacle.displacement) {
            *component = field.at([0.0; D], time);
            if !component.is_finite() {
                return Err(Error::Model(format!(
                    "contact \"{}\": the displacement of the obstacle, {field}, is not finite",
                    contact.name
                )));
            }
        }
        let interface =
            pair_obstacle(ends, &obstacle.gap, motion, model.analysis, time).map_err(fail)?;
        let nonmortar = nonmortar.clone();
        return Ok(Paired {
            nonmortar,
            mortar: None,
            obstacle_motion: motion,
            interface,
        });
    }
    let (nonmortar, mortar) = match &contact.pair {
        Pair::Given { nonmortar, mortar } => (nonmortar.clone(), mortar.clone()),
        Pair::Automatic([a, b]) => choose_nonmortar(model, a, b).map_err(fail)?,
        Pair::Obstacle { .. } => unreachable!("obstacles are paired above"),
    };
    let (s, m) = (end(&nonmortar), end(&mortar));
    let ends = [&s, &m].map(|(body, side)| End {
        body: &model.bodies[*body],
        side,
        constraints: constraints[*body],
    });
    if contact.pairing == Some(Pairing::Mortar) {
        return Err(fail(ContactError::NotYet {
            what: "pairing \"mortar\"",
        }));
    }
    // a partial overlap of matching sides is legal, and so are sides that do not face each other at all
    if let Some(unmatched) = unmatched_facing(ends[0], ends[1]).map_err(fail)? {
        let (own, other) = if unmatched.of_mortar {
            (ends[1], ends[0])
        } else {
            (ends[0], ends[1])
        };
        return Err(fail(ContactError::Unpaired {
            side: own.name(),
            other: other.name(),
            consequence: match contact.pairing {
                Some(_) => "pairing \"node-to-node\" needs coincident nodes",
                None => {
                    "contact of sides with different nodes (pairing \"mortar\") is not supported yet"
                }
            },
            node: unmatched.node,
            point: show(unmatched.point),
            distance: unmatched.distance,
        }));
    }
    let gap = match &contact.gap {
        None | Some(Gap::Closed) => InitialGap::Closed,
        Some(Gap::Geometric) => InitialGap::Measured,
        Some(Gap::Given(field)) => InitialGap::Given(field),
    };
    let interface = pair_nodes(ends[0], ends[1], gap, model.analysis, time).map_err(fail)?;
    Ok(Paired {
        nonmortar,
        mortar: Some(mortar),
        obstacle_motion: [0.0; D],
        interface,
    })
}

/// The more compliant body carries the multipliers; within a factor 10 the finer side.
fn choose_nonmortar<const D: usize>(
    model: &Model<D>,
    a: &SideRef,
    b: &SideRef,
) -> Result<(SideRef, SideRef), ContactError> {
    let softest = |side: &SideRef| {
        let moduli = model.bodies[side.body.0]
            .materials
            .iter()
            .map(|m| m.elastic.young);
        moduli.fold(f64::INFINITY, f64::min)
    };
    let (soft_a, soft_b) = (softest(a), softest(b));
    let a_first = if soft_a.max(soft_b) > 10.0 * soft_a.min(soft_b) {
        soft_a < soft_b
    } else {
        mean_edge(model, a)? <= mean_edge(model, b)?
    };
    Ok(if a_first {
        (a.clone(), b.clone())
    } else {
        (b.clone(), a.clone())
    })
}

fn mean_edge<const D: usize>(model: &Model<D>, side: &SideRef) -> Result<f64, ContactError> {
    let body = &model.bodies[side.body.0];
    let facets =
        side_facets(&body.mesh, &side.side).map_err(|source: FemError| ContactError::Side {
            body: body.name.clone(),
            source,
        })?;
    let total: f64 = facets
        .iter()
        .map(|&facet| {
            let ends: Vec<usize> = body
                .mesh
                .facet_nodes(facet)
                .take(2)
                .map(|node| node as usize)
                .collect();
            distance(body.mesh.points()[ends[0]], body.mesh.points()[ends[1]])
        })
        .sum();
    Ok(total / facets.len() as f64)
}
