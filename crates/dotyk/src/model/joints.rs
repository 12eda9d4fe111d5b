//! Joints: contacts that bear tension and cohesion until they part or slip.
//!
//! At a node of weight w, with the strength T in tension, the cohesion c and the coefficient of friction μ:
//!
//! ```text
//!   whole      λₙ ≥ −Tw,  gap ≥ 0,  (λₙ + Tw) gap = 0,     ‖λₜ‖ ≤ cw + μλₙ,  nothing where it is open
//!   lost       λₙ ≥ 0,    ...                              ‖λₜ‖ ≤ μλₙ
//! ```
//!
//! With λₙ = λ' − Tw a whole joint is a contact with the cohesion c − μT ≥ 0 for λ', and what it bears in tension a load of its own,
//! Bᵀ(Tw): the problem of a step is one of contact with friction. A node that is open after a step, or has slipped in it,
//! is lost from the next step on, for good. One that has a gap when it comes was never whole.

use crate::contact::{ContactError, InterfaceNode};
use crate::dual::NONE;
use crate::fem::show;
use crate::model::admissible::prepare_law;
use crate::model::condense::Condensed;
use crate::model::error::Error;
use crate::model::judge::Judged;
use crate::model::nouns::{Contact, Law, Model};
use crate::model::pair::{Paired, row_ranges};
use crate::solve::{Shear, State};
use std::collections::BTreeMap;

/// A gap above this part of what its node stands for is one.
const GAP: f64 = 1e-9;

/// An opening or a slip below this part of the length of the problem is none.
const MOVED: f64 = 1e-8;

/// The joints of a model with their interfaces.
fn joints<'a, const D: usize>(
    model: &'a Model<D>,
    paired: &'a [Paired<D>],
) -> impl Iterator<Item = (usize, &'a Contact<D>, &'a Paired<D>)> {
    let contacts = model.contacts.iter().zip(paired).enumerate();
    let contacts = contacts.map(|(index, (contact, pair))| (index, contact, pair));
    contacts.filter(|(_, contact, _)| matches!(contact.law, Law::Cohesive { .. }))
}

/// Which nodes are lost from the beginning, by contact.
pub(crate) fn whole<const D: usize>(model: &Model<D>, paired: &[Paired<D>]) -> Vec<Vec<bool>> {
    let mut lost = vec![Vec::new(); paired.len()];
    for (index, _, pair) in joints(model, paired) {
        let gaps = pair.gaps();
        let apart = |node: &InterfaceNode<D>| {
            let gap = node.rows[0].map_or(node.gap, |row| gaps[row]);
            gap > GAP * node.extent.abs()
        };
        lost[index] = pair.interface.nodes.iter().map(apart).collect();
    }
    lost
}

/// Tells the interfaces what was lost before, by the names of contacts.
pub(crate) fn restore<const D: usize>(
    model: &Model<D>,
    paired: &mut [Paired<D>],
    before: &BTreeMap<String, Vec<bool>>,
) {
    let new = whole(model, paired);
    for (pair, new) in paired.iter_mut().zip(new) {
        let known = before.get(&pair.name);
        let known = known.filter(|lost| lost.len() == pair.interface.nodes.len());
        pair.lost = known.cloned().unwrap_or(new);
    }
}

/// Sets what joints bear in tension, at a time.
///
/// Errors: a strength that is negative, not finite, or more than cohesion over coefficient.
pub(crate) fn set_base<const D: usize>(
    model: &Model<D>,
    paired: &mut [Paired<D>],
    time: f64,
) -> Result<(), Error<D>> {
    for (contact, pair) in model.contacts.iter().zip(paired) {
        let Some(tension) = contact.law.tension() else {
            pair.base.clear();
            continue;
        };
        pair.base = vec![0.0; pair.interface.nonmortar.len()];
        let points = model.bodies[pair.nonmortar.body.0].mesh.points();
        prepare_law(contact, pair, points, time);
        for (node, lost) in pair.interface.nodes.iter().zip(&pair.lost) {
            let (Some(row), false) = (node.rows[0], lost) else {
                continue;
            };
            let at = points[node.node];
            let value = tension.at(at, time);
            let most = contact.law.most_tension(at, time);
            if !(value >= 0.0 && value.is_finite() && value <= most * (1.0 + GAP)) {
                return Err(Error::Contact {
                    contact: contact.name.clone(),
                    source: ContactError::Tension {
                        side: pair.nonmortar.side.clone(),
                        text: tension.to_string(),
                        point: show(at),
                        value,
                        most,
                    },
                });
            }
            pair.base[row] = -value * node.weight;
        }
    }
    Ok(())
}

/// What is lost after a step, by contact and node, and what the user should know of it.
pub(crate) fn after<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    judged: &Judged<D>,
    lambda: &[f64],
) -> (Vec<Vec<bool>>, Vec<String>) {
    let mut lost: Vec<Vec<bool>> = (condensed.paired.iter())
        .map(|pair| pair.lost.clone())
        .collect();
    let mut warnings = Vec::new();
    let moved = MOVED * condensed.problem.scales.length;
    let none = NONE * lambda.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    let mut slips = vec![false; lambda.len()];
    for (block, range) in condensed.problem.admissible.iter() {
        let state = State::of_forces(block, &lambda[range.clone()]);
        slips[range.start] = state.shear != Shear::Stick;
    }
    let ranges: Vec<_> = row_ranges(&condensed.paired)
        .map(|(rows, _)| rows)
        .collect();
    for (index, contact, pair) in joints(model, &condensed.paired) {
        let first = ranges[index].start;
        let goes = |node: &InterfaceNode<D>| {
            let mut rows = node.rows.iter().flatten().map(|row| first + row);
            let Some(normal) = rows.next() else {
                return false;
            };
            let gap = |row: usize| judged.displaced.gaps[row];
            let open = lambda[normal] <= none && gap(normal) > moved;
            open || slips[normal] && rows.any(|row| gap(row).abs() > moved)
        };
        let mut count = 0;
        for (lost, node) in lost[index].iter_mut().zip(&pair.interface.nodes) {
            if !*lost && goes(node) {
                (*lost, count) = (true, count + 1);
            }
        }
        if count > 0 {
            let nodes = if count == 1 {
                "1 node".to_string()
            } else {
                format!("{count} nodes")
            };
            warnings.push(format!(
                "contact \"{}\": at {nodes} the joint parted or slipped in this step: cohesion and tension are lost there from the next one on",
                contact.name
            ));
        }
    }
    (lost, warnings)
}
