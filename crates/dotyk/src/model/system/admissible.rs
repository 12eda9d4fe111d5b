//! Λ of all conditions: the admissible forces of each of their nodes.

use crate::contact::{ContactError, Coupling, Role};
use crate::dual::{AdmissibleSet, Block, Friction};
use crate::fem::{CoupleKind, show};
use crate::geometry::{Field, Point};
use crate::mesh::CellKind;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Contact, Law, Model};
use crate::model::system::condition::{Condition, Source};
use crate::model::system::parts::Owner;
use crate::model::system::shared::coefficients;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Λ of all contacts and couples at a time, in the order of their rows.
///
/// Errors: a coefficient or bound of friction that is negative or not finite.
pub(crate) fn admissible_set<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
    time: f64,
) -> Result<AdmissibleSet, Error<D>> {
    let mut blocks = Vec::new();
    for condition in conditions {
        if let Some(index) = condition.contact() {
            blocks.extend(of_contact(model, (index, condition), time)?);
            continue;
        }
        blocks.extend(condition.interface.carriers().map(|node| {
            let size = node.rows.iter().flatten().count();
            condition.law.unwrap_or(Block::Free { size })
        }));
    }
    Ok(AdmissibleSet::new(blocks))
}

/// Blocks of the nodes of a contact, given by its place.
fn of_contact<const D: usize>(
    model: &Model<D>,
    (index, condition): (usize, &Condition<D>),
    time: f64,
) -> Result<Vec<Block>, Error<D>> {
    let contact = &model.contacts[index];
    let points = model.bodies[condition.nonmortar.body.0].mesh.points();
    prepare_law(contact, condition, points, time);
    let nodes = condition.interface.nodes.iter().enumerate();
    let carriers = nodes.filter(|(_, node)| node.role == Role::Multiplier);
    let blocks = carriers.map(|(place, node)| {
        let size = node.rows.iter().flatten().count();
        let tangents = size.saturating_sub(1);
        let value = |field: &Field| friction_at(contact, condition, field, points[node.node], time);
        let shared = condition.sharers_at(place).next().is_some();
        if shared && matches!(contact.law, Law::Coulomb(_)) {
            let all = coefficients(model, (index, condition), place, value)?;
            let coefficient = all.iter().sum();
            return Ok(Friction::Coulomb { coefficient }.block(tangents));
        }
        let law = match condition.touch.lost.get(place) {
            Some(true) => Cow::Owned(contact.law.dry()),
            _ => Cow::Borrowed(&contact.law),
        };
        Ok(match law.friction(value, node.weight)? {
            Some(law) if tangents > 0 => law.block(tangents),
            None if condition.interface.coupling == Coupling::Tied => Block::Free { size },
            _ => Block::Unilateral,
        })
    });
    blocks.collect()
}

/// Evaluates the fields of a contact's law at its nodes beforehand.
pub(crate) fn prepare_law<const D: usize>(
    contact: &Contact<D>,
    condition: &Condition<D>,
    points: &[Point<D>],
    time: f64,
) {
    let nodes = condition.interface.nodes.iter();
    let carriers = nodes.filter(|node| node.role == Role::Multiplier);
    let places = carriers.map(|node| points[node.node]);
    Field::prepare(contact.law.fields(), places, time);
}

/// Coefficient or bound of friction at a point.
fn friction_at<const D: usize>(
    contact: &Contact<D>,
    condition: &Condition<D>,
    field: &Field,
    point: [f64; D],
    time: f64,
) -> Result<f64, Error<D>> {
    let value = field.at(point, time);
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(Error::Contact {
        contact: contact.name.clone(),
        source: ContactError::Friction {
            side: condition.nonmortar.side.clone(),
            text: field.to_string(),
            point: show(point),
            value,
        },
    })
}

/// Pairs of blocks of [`admissible_set`] whose nodes share a facet.
pub(crate) fn neighbours<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    let mut first = 0;
    for condition in conditions {
        let carriers = || {
            let carriers = condition.interface.carriers().enumerate();
            carriers.map(|(k, n)| (n.node, first + k))
        };
        let block: BTreeMap<usize, usize> = carriers().collect();
        if matches!(condition.source, Source::Of(Owner::Bed(..))) {
            // the points of a bed that are nearest to one node
            let both = carriers().map(|(node, k)| [block[&node].min(k), block[&node].max(k)]);
            pairs.extend(both.filter(|[a, b]| a != b));
        }
        // a corner carries one for each of its faces
        first += condition.interface.carriers().count();
        let mesh = &model.bodies[condition.nonmortar.body.0].mesh;
        // the rows of an average couple stand for the whole side
        let nodal = condition.source.couple(model) != Some(CoupleKind::Average);
        let facets = mesh.side(&condition.nonmortar.side).filter(|_| nodal);
        for &facet in facets.unwrap_or_default() {
            let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|n| n as usize).collect();
            // middle nodes lie between the corners: in the plane a facet is a chain of its nodes
            let edges = match (mesh.facet_kind(facet), &nodes[..]) {
                (CellKind::Line3, &[a, b, middle]) => vec![[a, middle], [middle, b]],
                (kind, _) => {
                    let corners = kind.corner_edges().iter().enumerate();
                    let ends = corners.flat_map(|(a, ends)| ends.iter().map(move |&b| (a, b)));
                    ends.map(|(a, b)| [nodes[a], nodes[b]]).collect()
                }
            };
            pairs.extend(edges.iter().filter_map(|[a, b]| {
                let [a, b] = [block.get(a)?, block.get(b)?];
                Some([*a.min(b), *a.max(b)])
            }));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
