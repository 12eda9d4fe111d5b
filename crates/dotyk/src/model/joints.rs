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
//! is lost from the next step on, for good. One whose sides are apart when it comes, be it by a clearance or because they have parted
//! before, was never whole; one of a body that is fitted to what has moved is.
//!
//! A shear that a whole joint bears may lift a node off, and without it the node is pressed on again: then neither a whole nor a
//! parted joint is in equilibrium there. On the way to the load of the step it has parted, which cannot be undone: it is lost
//! in this step already, and what its friction bears is the answer.
//!
//! A gap or a slip is one where it is more than what the answer is known to: rounding of displacements, and of forces in what
//! they displace, and what the largest error that the certificate lets pass in a force closes or opens at the node by itself,
//!
//! ```text
//!   |gap| > ε (max|u| + Fᵢᵢ max|λ|) + 10 tolerances · cᵢ max|λ|,      cᵢ = Σ b²/K
//! ```
//!
//! with the forces of what contacts couple with it, and the dofs b/K of the row. Fᵢᵢ is large where supports are weak, cᵢ is not.

use crate::contact::{ContactError, InterfaceNode};
use crate::dual::{FORCE_LIMIT, NONE, ROUNDING};
use crate::fem::show;
use crate::geometry::distance;
use crate::model::admissible::prepare_law;
use crate::model::attempt::Attempt;
use crate::model::bodies::least_softness;
use crate::model::condense::Condensed;
use crate::model::error::{Error, Objection};
use crate::model::judge::Judged;
use crate::model::nouns::{Contact, Law, Model, SideRef};
use crate::model::pair::{Paired, row_ranges};
use crate::solve::{Shear, State, torn as torn_component};
use std::collections::BTreeMap;

/// A gap above this part of what its node stands for is one.
const GAP: f64 = 1e-9;

/// The joints of a model with their interfaces.
fn joints<'a, const D: usize>(
    model: &'a Model<D>,
    paired: &'a [Paired<D>],
) -> impl Iterator<Item = (usize, &'a Contact<D>, &'a Paired<D>)> {
    let contacts = model.contacts.iter().zip(paired).enumerate();
    let contacts = contacts.map(|(index, (contact, pair))| (index, contact, pair));
    contacts.filter(|(_, contact, _)| matches!(contact.law, Law::Cohesive { .. }))
}

/// What a stage leaves of the nodes of a joint.
pub(crate) struct Lost {
    /// The side that carried the multipliers: its name, and whether its body is the first of the two.
    side: (String, bool),
    /// Every node, and whether it is lost; not known where it had no condition.
    nodes: Vec<(usize, Option<bool>)>,
}

impl Lost {
    /// Of a contact of the last stage.
    pub fn of<const D: usize>(pair: &Paired<D>, lost: &[bool]) -> Self {
        let nodes = pair.interface.nodes.iter().zip(lost);
        let nodes = nodes.map(|(node, &lost)| {
            let known = lost || node.rows[0].is_some();
            (node.node, known.then_some(lost))
        });
        Self {
            side: carrying(pair),
            nodes: nodes.collect(),
        }
    }

    /// What is known of the nodes of the same contact now; supports may have left its multipliers to its other side, whose nodes do
    /// what those nearest to them did.
    fn at<const D: usize>(&self, model: &Model<D>, pair: &Paired<D>) -> Vec<Option<bool>> {
        let nodes = &pair.interface.nodes;
        let (true, other) = (self.side != carrying(pair), &pair.mortar) else {
            return self.nodes.iter().map(|(_, lost)| *lost).collect();
        };
        let points = |side: &SideRef| model.bodies[side.body.0].mesh.points();
        let (now, then) = (points(&pair.nonmortar), other.as_ref().map(points));
        let nearest = |node: &InterfaceNode<D>| {
            let then = then?;
            let far = |(other, _): &&(usize, Option<bool>)| distance(now[node.node], then[*other]);
            let nearest = self.nodes.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            nearest.and_then(|(_, lost)| *lost)
        };
        nodes.iter().map(nearest).collect()
    }
}

/// Which side carries the multipliers of a contact: bodies keep their order from stage to stage.
fn carrying<const D: usize>(pair: &Paired<D>) -> (String, bool) {
    let own = &pair.nonmortar;
    let first = pair.mortar.as_ref();
    let first = first.is_none_or(|other| own.body.0 <= other.body.0);
    (own.side.clone(), first)
}

/// Which nodes are lost from the beginning, by contact: those whose sides are apart.
pub(crate) fn whole<const D: usize>(model: &Model<D>, paired: &[Paired<D>]) -> Vec<Vec<bool>> {
    let mut lost = vec![Vec::new(); paired.len()];
    for (index, _, pair) in joints(model, paired) {
        let apart = |node: &InterfaceNode<D>| {
            let (moved, known) = node.rows[0].map_or((0.0, 0.0), |row| {
                let [own, other] = [&pair.interface.nonmortar, &pair.interface.mortar];
                let parts = pair.began.magnitude(&own[row], &other[row]);
                (pair.moved_before(row), model.solver.tolerance * parts)
            });
            node.gap - moved > GAP * node.extent.abs() + known
        };
        lost[index] = pair.interface.nodes.iter().map(apart).collect();
    }
    lost
}

/// Tells the interfaces what was lost before, by the names of contacts.
pub(crate) fn restore<const D: usize>(
    model: &Model<D>,
    paired: &mut [Paired<D>],
    before: &BTreeMap<String, Lost>,
) {
    let new = whole(model, paired);
    for (pair, mut new) in paired.iter_mut().zip(new) {
        let known = before.get(&pair.name).map(|lost| lost.at(model, pair));
        for (lost, known) in new.iter_mut().zip(known.into_iter().flatten()) {
            *lost = known.unwrap_or(*lost);
        }
        pair.lost = new;
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

/// A node of a joint that is lost on the way to the end of a step.
pub(crate) struct Torn {
    /// What is then lost, by contact and node.
    pub lost: Vec<Vec<bool>>,
    /// What the user should know of it.
    pub words: String,
}

/// A node of a joint that has no state of its own, where an attempt found no answer.
pub(crate) fn torn<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    attempt: &Attempt<D>,
) -> Option<Torn> {
    let unsettled = matches!(attempt.failure, Some(Objection::Unsettled { .. }));
    let forces = unsettled.then_some(&attempt.outcome.multipliers)?;
    let component = torn_component(&condensed.problem, forces)?;
    let mut ranges = row_ranges(&condensed.paired).enumerate();
    let (index, (rows, pair)) = ranges.find(|(_, (rows, _))| rows.contains(&component))?;
    let row = component - rows.start;
    let mut nodes = pair.interface.nodes.iter();
    let place = nodes.position(|node| node.rows[0] == Some(row))?;
    let mut lost: Vec<Vec<bool>> = (condensed.paired.iter())
        .map(|pair| pair.lost.clone())
        .collect();
    let own = lost.get_mut(index)?.get_mut(place)?;
    if std::mem::replace(own, true) {
        return None;
    }
    let node = pair.interface.nodes[place].node;
    let at = model.bodies[pair.nonmortar.body.0].mesh.points()[node];
    let words = format!(
        "contact \"{}\": at node {node} {} the shear that the joint bears lifts it off, and without that shear it is pressed on again: the joint has parted there within this step, cohesion and tension are lost in it already, and dry friction is left; smaller load steps tell when it parts",
        pair.name,
        show(at)
    );
    Some(Torn { lost, words })
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
    let known = known_gaps(model, condensed, judged, lambda);
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

/// To what the gaps of an answer are known, (m,).
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
