//! Nodes of joints (`system/joints.rs`) that part or slip, after a step and within it.
//!
//! A shear that a whole joint bears may lift a node off, and without it the node is pressed on again: then neither a whole nor a
//! parted joint is in equilibrium there. On the way to the load of the step it has parted, which cannot be undone: it is lost
//! in this step already, and the answer is that of its friction.
//!
//! A gap or a slip counts where it exceeds the uncertainty of the answer: rounding of displacements, rounding of forces times
//! compliance, and the gap change at the node by the largest error of a force that the certificate accepts,
//!
//! ```text
//!   |gap| > ε (max|u| + Fᵢᵢ max|λ|) + 10 tolerances · cᵢ max|λ|,      cᵢ = Σ b²/K
//! ```
//!
//! with the largest force of its domain, and the dofs b/K of the row. Fᵢᵢ is large where supports are weak, cᵢ is not.

use crate::contact::InterfaceNode;
use crate::dual::{FORCE_LIMIT, NONE, ROUNDING};
use crate::fem::show;
use crate::model::march::attempt::Attempt;
use crate::model::march::judge::Judged;
use crate::model::nouns::error::Objection;
use crate::model::nouns::model::Model;
use crate::model::system::bodies::least_softness;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::row_ranges;
use crate::model::system::joints::joints;
use crate::solve::{Shear, State, torn as torn_component};

/// A node of a joint that is lost on the way to the end of a step.
pub(crate) struct Torn {
    /// Lost nodes, by contact and node.
    pub lost: Vec<Vec<bool>>,
    /// A remark for the user.
    pub words: String,
}

/// A node of a joint without a state of equilibrium, where an attempt found no answer.
pub(crate) fn torn<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    attempt: &Attempt<D>,
) -> Option<Torn> {
    let unsettled = matches!(attempt.failure, Some(Objection::Unsettled { .. }));
    let forces = unsettled.then_some(&attempt.outcome.multipliers)?;
    let component = torn_component(&condensed.problem, forces)?;
    let mut ranges = row_ranges(&condensed.conditions).enumerate();
    let (index, (rows, condition)) = ranges.find(|(_, (rows, _))| rows.contains(&component))?;
    let row = component - rows.start;
    let mut nodes = condition.interface.nodes.iter();
    let place = nodes.position(|node| node.rows[0] == Some(row))?;
    let mut lost: Vec<Vec<bool>> = (condensed.conditions.iter())
        .map(|condition| condition.touch.lost.clone())
        .collect();
    let own = lost.get_mut(index)?.get_mut(place)?;
    if std::mem::replace(own, true) {
        return None;
    }
    let node = condition.interface.nodes[place].node;
    let at = model.bodies[condition.nonmortar.body.0].mesh.points()[node];
    let words = format!(
        "contact \"{}\": at node {node} {} the shear that the joint bears lifts it off, and without that shear it is pressed on again: the joint has parted there within this step, cohesion and tension are lost in it already, and dry friction is left; smaller load steps tell when it parts",
        condition.name,
        show(at)
    );
    Some(Torn { lost, words })
}

/// Nodes of joints lost after a step, by contact and node, with a remark for the user.
pub(crate) fn after<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    judged: &Judged<D>,
    lambda: &[f64],
) -> (Vec<Vec<bool>>, Vec<String>) {
    let mut lost: Vec<Vec<bool>> = (condensed.conditions.iter())
        .map(|condition| condition.touch.lost.clone())
        .collect();
    let mut warnings = Vec::new();
    let known = known_gaps(model, condensed, judged, lambda);
    let mut slips = vec![false; lambda.len()];
    for (block, range) in condensed.problem.admissible.iter() {
        let state = State::of_forces(block, &lambda[range.clone()]);
        slips[range.start] = state.shear != Shear::Stick;
    }
    let ranges: Vec<_> = row_ranges(&condensed.conditions)
        .map(|(rows, _)| rows)
        .collect();
    for (index, contact, condition) in joints(model, &condensed.conditions) {
        let first = ranges[index].start;
        let own = lambda[ranges[index].clone()].iter();
        let none = NONE * own.fold(0.0, |s: f64, l| s.max(l.abs()));
        let moved = |row: usize| judged.displaced.gaps[row].abs() > known[row];
        let goes = |node: &InterfaceNode<D>| {
            let mut rows = node.rows.iter().flatten().map(|row| first + row);
            let Some(normal) = rows.next() else {
                return false;
            };
            let parts = judged.displaced.gaps[normal] > 0.0 && moved(normal);
            let open = lambda[normal] <= none && parts;
            open || slips[normal] && rows.any(moved)
        };
        let mut count = 0;
        for (lost, node) in lost[index].iter_mut().zip(&condition.interface.nodes) {
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

/// Uncertainty of the gaps of an answer, (m,).
fn known_gaps<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    judged: &Judged<D>,
    lambda: &[f64],
) -> Vec<f64> {
    let coupled = &condensed.problem.coupled;
    let mut largest = vec![0.0f64; coupled.domains()];
    for (row, force) in lambda.iter().enumerate() {
        let own = &mut largest[coupled.domain_of(row)];
        *own = own.max(force.abs());
    }
    let error = FORCE_LIMIT * model.solver.tolerance;
    let alone = least_softness(&condensed.bodies, lambda.len());
    let known = |(row, rounding): (usize, &f64)| {
        let gives = ROUNDING * condensed.problem.softness[row] + error * alone[row];
        rounding + gives * largest[coupled.domain_of(row)]
    };
    judged
        .displaced
        .rounding
        .iter()
        .enumerate()
        .map(known)
        .collect()
}
