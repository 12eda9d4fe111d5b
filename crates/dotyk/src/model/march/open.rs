//! Uncertainty of contact forces by rounding.
//!
//! Where multipliers are finer than the softer side, that side responds alike to forces that differ by a null vector of its part of
//! F. Only the stiffer side distinguishes them, by gaps δg = F δλ that may be less than the uncertainty of any gap: the rounding of
//! displacements and of the coordinates from which initial gaps are measured. So the exact step with the answer's states gives the δλ
//! of such gaps (`solve/correct.rs`), and the certificate compares it with the forces of the contact.

use crate::dual::Multipliers;
use crate::geometry::{Point, add_scaled, norm};
use crate::model::nouns::model::{Gap, Model};
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, contact_rows, row_ranges};
use crate::model::system::displaced::Displaced;
use crate::solve::{FREE, left_open};
use std::collections::BTreeMap;
use std::ops::Range;

/// Uncertainty of the forces on nodes whose contacts have multipliers finer than the softer side (m,), zero at others; `None` without
/// such a contact.
///
/// The gaps of an answer are known to the rounding of the displacements, measured initial gaps to that of the coordinates. The share
/// of the single conditions in the force of a node does not count: a corner has more conditions than it needs.
pub(crate) fn open_forces<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    multipliers: &Multipliers,
) -> Option<Vec<f64>> {
    let finer =
        contact_rows(&condensed.conditions).filter(|(_, (_, condition))| condition.touch.finer);
    let mut asked = vec![false; displaced.gaps.len()];
    let mut rounding = displaced.rounding.clone();
    for (contact, (rows, condition)) in finer {
        asked[rows.clone()].fill(true);
        let given = model.contacts[contact].gap.as_ref();
        if given.is_some_and(|gap| !matches!(gap, Gap::Geometric | Gap::Adjusted(_))) {
            continue;
        }
        let points = model.bodies[condition.nonmortar.body.0].mesh.points();
        let coordinates = points.iter().flatten();
        let far = coordinates.fold(0.0, |s: f64, x| s.max(x.abs()));
        // initial gaps of zero are exact
        let measured = condition
            .interface
            .carriers()
            .filter(|node| node.gap != 0.0);
        for row in measured.filter_map(|node| node.rows[0]) {
            rounding[rows.start + row] += f64::EPSILON * far;
        }
    }
    if !asked.contains(&true) {
        return None;
    }
    let known = (&displaced.gaps[..], &rounding[..]);
    let found = left_open(&condensed.problem, multipliers, known)?;
    let mut open = on_nodes(&condensed.conditions, &found.change);
    if !found.free.is_empty() {
        let free = on_nodes(&condensed.conditions, &found.free);
        let free = open.iter_mut().zip(&free).filter(|(_, free)| **free > FREE);
        free.for_each(|(open, _)| *open = f64::INFINITY);
    }
    let others = open.iter_mut().zip(&asked).filter(|(_, asked)| !**asked);
    others.for_each(|(open, _)| *open = 0.0);
    Some(open)
}

/// The contact, in words, with the most uncertain force.
pub(crate) fn most_open<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    multipliers: &Multipliers,
) -> Option<String> {
    let open = open_forces(model, condensed, displaced, multipliers)?;
    let most = |rows: Range<usize>| open[rows].iter().copied().fold(0.0, f64::max);
    let each =
        contact_rows(&condensed.conditions).map(|(_, (rows, condition))| (most(rows), condition));
    let (_, condition) = each.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(condition.called(model))
}

/// Size of the force of all rows together on the node of each row (m,): where contacts meet, their forces on a node may cancel, and
/// such forces move no body.
fn on_nodes<const D: usize>(conditions: &[Condition<D>], forces: &[f64]) -> Vec<f64> {
    let mut sums: BTreeMap<(usize, usize), Point<D>> = BTreeMap::new();
    for (rows, condition) in row_ranges(conditions) {
        let own = (
            Some(condition.nonmortar.body.0),
            &condition.interface.nonmortar,
        );
        for (part, sides) in [own, (condition.opposite, &condition.interface.mortar)] {
            let Some(part) = part else {
                continue;
            };
            for (row, force) in sides.iter().zip(&forces[rows.clone()]) {
                for &(node, c) in row {
                    let sum = sums.entry((part, node)).or_insert([0.0; D]);
                    *sum = add_scaled(*sum, *force, c);
                }
            }
        }
    }
    let mut sizes = vec![0.0; forces.len()];
    for (rows, condition) in row_ranges(conditions) {
        for node in condition.interface.carriers() {
            let sum = sums.get(&(condition.nonmortar.body.0, node.node));
            for row in node.rows.iter().flatten() {
                sizes[rows.start + row] = sum.copied().map_or(0.0, norm);
            }
        }
    }
    sizes
}
