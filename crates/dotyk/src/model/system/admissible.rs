//! Λ of all contacts, couples and links: what each of their nodes can bear.

use crate::contact::{ContactError, Coupling, Role};
use crate::dual::{AdmissibleSet, Block, Friction};
use crate::fem::{CoupleKind, show};
use crate::geometry::{Field, Point};
use crate::mesh::CellKind;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Contact, Law, Model};
use crate::model::system::paired::{Kind, Paired};
use crate::model::system::shared::coefficients;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Λ of all contacts and couples at a time, in the order of their rows.
///
/// Errors: a coefficient or bound of friction that is negative or not finite.
pub(crate) fn admissible_set<const D: usize>(
    model: &Model<D>,
    paired: &[Paired<D>],
    time: f64,
) -> Result<AdmissibleSet, Error<D>> {
    let mut blocks = Vec::new();
    for (index, pair) in paired.iter().enumerate() {
        let points = model.bodies[pair.nonmortar.body.0].mesh.points();
        let carriers = pair.interface.nodes.iter().enumerate();
        let carriers = carriers.filter(|(_, node)| node.role == Role::Multiplier);
        if let (Kind::Contact, Some(contact)) = (pair.kind, model.contacts.get(index)) {
            prepare_law(contact, pair, points, time);
        }
        for (place, node) in carriers {
            let size = node.rows.iter().flatten().count();
            let (Kind::Contact, Some(contact)) = (pair.kind, model.contacts.get(index)) else {
                blocks.push(match pair.kind {
                    Kind::Bed(_) => Block::Unilateral,
                    Kind::Bar(bar) => model.bars[bar].law(pair.link.count).0,
                    _ => Block::Free { size },
                });
                continue;
            };
            let value = |field: &Field| friction_at(contact, pair, field, points[node.node], time);
            let shared = pair.sharers_at(place).next().is_some();
            if shared && matches!(contact.law, Law::Coulomb(_)) {
                let all = coefficients(model, (index, pair), place, value)?;
                let coefficient = all.iter().sum();
                blocks.push(Friction::Coulomb { coefficient }.block(size.saturating_sub(1)));
                continue;
            }
            let tangents = size.saturating_sub(1);
            let law = match pair.lost.get(place) {
                Some(true) => Cow::Owned(contact.law.dry()),
                _ => Cow::Borrowed(&contact.law),
            };
            blocks.push(match law.friction(value, node.weight)? {
                Some(law) if tangents > 0 => law.block(tangents),
                None if pair.interface.coupling == Coupling::Tied => Block::Free { size },
                _ => Block::Unilateral,
            });
        }
    }
    Ok(AdmissibleSet::new(blocks))
}

/// Prepares the numbers of a contact's law at its nodes.
pub(crate) fn prepare_law<const D: usize>(
    contact: &Contact<D>,
    pair: &Paired<D>,
    points: &[Point<D>],
    time: f64,
) {
    let nodes = pair.interface.nodes.iter();
    let carriers = nodes.filter(|node| node.role == Role::Multiplier);
    let places = carriers.map(|node| points[node.node]);
    Field::prepare(contact.law.fields(), places, time);
}

/// Coefficient or bound of friction at a point.
fn friction_at<const D: usize>(
    contact: &Contact<D>,
    pair: &Paired<D>,
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
            side: pair.nonmortar.side.clone(),
            text: field.to_string(),
            point: show(point),
            value,
        },
    })
}

/// Pairs of blocks of [`admissible_set`] whose nodes share a facet.
pub(crate) fn neighbours<const D: usize>(
    model: &Model<D>,
    paired: &[Paired<D>],
) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    let mut first = 0;
    for pair in paired {
        let carriers = || {
            let carriers = pair.interface.carriers().enumerate();
            carriers.map(|(k, n)| (n.node, first + k))
        };
        let block: BTreeMap<usize, usize> = carriers().collect();
        if matches!(pair.kind, Kind::Bed(_)) {
            // the points of a bed that are nearest to one node
            let both = carriers().map(|(node, k)| [block[&node].min(k), block[&node].max(k)]);
            pairs.extend(both.filter(|[a, b]| a != b));
        }
        // a corner carries one for each of its faces
        first += pair.interface.carriers().count();
        let mesh = &model.bodies[pair.nonmortar.body.0].mesh;
        // the rows of an average couple stand for the whole side
        let nodal = pair.kind != Kind::Couple(CoupleKind::Average);
        let facets = mesh.side(&pair.nonmortar.side).filter(|_| nodal);
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
