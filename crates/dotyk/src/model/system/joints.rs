//! Joints: contacts that bear tension and cohesion until they part or slip.
//!
//! At a node of weight w, with the strength T in tension, the cohesion c and the coefficient of friction μ:
//!
//! ```text
//!   whole      λₙ ≥ −Tw,  gap ≥ 0,  (λₙ + Tw) gap = 0,     ‖λₜ‖ ≤ cw + μλₙ,  no force where it is open
//!   lost       λₙ ≥ 0,    ...                              ‖λₜ‖ ≤ μλₙ
//! ```
//!
//! With λₙ = λ' − Tw a whole joint is a contact with the cohesion c − μT ≥ 0 for λ', and its tensile strength a load of its own,
//! Bᵀ(Tw): the problem of a step is one of contact with friction. A node that is open after a step, or has slipped in it, is lost from
//! the next step on, for good. A node whose sides are apart when the joint comes, by a clearance or because they have parted before,
//! was never whole; nodes of a body that is fitted to displaced neighbours are whole.
//!
//! `march/torn.rs` finds the nodes lost after a step and within it.

use crate::contact::{ContactError, InterfaceNode};
use crate::fem::show;
use crate::geometry::distance;
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::{Contact, Law, Model};
use crate::model::system::admissible::prepare_law;
use crate::model::system::condition::Condition;

/// A gap counts above this part of the extent of its node.
const GAP: f64 = 1e-9;

/// The joints of a model with their interfaces.
pub(crate) fn joints<'a, const D: usize>(
    model: &'a Model<D>,
    conditions: &'a [Condition<D>],
) -> impl Iterator<Item = (usize, &'a Contact<D>, &'a Condition<D>)> {
    let contacts = conditions.iter().enumerate();
    let contacts = contacts
        .filter_map(|(index, condition)| Some((index, condition.contact_of(model)?, condition)));
    contacts.filter(|(_, contact, _)| matches!(contact.law, Law::Cohesive { .. }))
}

/// State of the nodes of a joint after a step.
#[derive(Debug, Clone)]
pub(crate) struct Lost {
    /// The side that carried the multipliers: its name, and whether its body is the first of the two.
    side: (String, bool),
    /// Every node, and whether it is lost; `None` where it had no condition.
    nodes: Vec<(usize, Option<bool>)>,
}

impl Lost {
    /// The state of a contact after a step.
    pub fn of<const D: usize>(condition: &Condition<D>, lost: &[bool]) -> Self {
        let nodes = condition.interface.nodes.iter().zip(lost);
        let nodes = nodes.map(|(node, &lost)| {
            let known = lost || node.rows[0].is_some();
            (node.node, known.then_some(lost))
        });
        Self {
            side: carrying(condition),
            nodes: nodes.collect(),
        }
    }

    /// Known states of the nodes of the same contact now. Supports may have moved its multipliers to its other side, whose nodes take the
    /// state of the nearest previous ones.
    fn at<const D: usize>(&self, model: &Model<D>, condition: &Condition<D>) -> Vec<Option<bool>> {
        let nodes = &condition.interface.nodes;
        let (true, other) = (self.side != carrying(condition), &condition.mortar) else {
            return self.nodes.iter().map(|(_, lost)| *lost).collect();
        };
        let points = |side: &SideRef| model.bodies[side.body.0].mesh.points();
        let (now, then) = (points(&condition.nonmortar), other.as_ref().map(points));
        let nearest = |node: &InterfaceNode<D>| {
            let then = then?;
            let far = |(other, _): &&(usize, Option<bool>)| distance(now[node.node], then[*other]);
            let nearest = self.nodes.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            nearest.and_then(|(_, lost)| *lost)
        };
        nodes.iter().map(nearest).collect()
    }
}

/// Finds the state of a joint by the name of its contact.
pub(crate) type Losses<'a> = dyn Fn(&str) -> Option<&'a Lost> + 'a;

/// Which side carries the multipliers of a contact: bodies keep their order from stage to stage.
pub(crate) fn carrying<const D: usize>(condition: &Condition<D>) -> (String, bool) {
    let own = &condition.nonmortar;
    let first = condition.mortar.as_ref();
    let first = first.is_none_or(|other| own.body.0 <= other.body.0);
    (own.side.clone(), first)
}

/// Which nodes are lost from the beginning, by contact: those whose sides are apart.
pub(crate) fn whole<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
) -> Vec<Vec<bool>> {
    let mut lost = vec![Vec::new(); conditions.len()];
    for (index, _, condition) in joints(model, conditions) {
        let apart = |node: &InterfaceNode<D>| {
            let (moved, known) = node.rows[0].map_or((0.0, 0.0), |row| {
                let [own, other] = [&condition.interface.nonmortar, &condition.interface.mortar];
                let parts = condition.touch.began.magnitude(&own[row], &other[row]);
                (condition.moved_before(row), model.solver.tolerance * parts)
            });
            node.gap - moved > GAP * node.extent.abs() + known
        };
        lost[index] = condition.interface.nodes.iter().map(apart).collect();
    }
    lost
}

/// Marks the nodes lost before in the interfaces, by the names of contacts.
pub(crate) fn restore<const D: usize>(
    model: &Model<D>,
    conditions: &mut [Condition<D>],
    before: &Losses<'_>,
) {
    let new = whole(model, conditions);
    for (condition, mut new) in conditions.iter_mut().zip(new) {
        let known = before(&condition.name).map(|lost| lost.at(model, condition));
        for (lost, known) in new.iter_mut().zip(known.into_iter().flatten()) {
            *lost = known.unwrap_or(*lost);
        }
        condition.touch.lost = new;
    }
}

/// Sets the tensile strengths of joints, at a time.
///
/// Errors: a strength that is negative, not finite, or more than cohesion over coefficient.
pub(crate) fn set_offsets<const D: usize>(
    model: &Model<D>,
    conditions: &mut [Condition<D>],
    time: f64,
) -> Result<(), Error<D>> {
    for condition in conditions {
        let Some(contact) = condition.contact_of(model) else {
            continue;
        };
        let Some(tension) = contact.law.tension() else {
            condition.offset.clear();
            continue;
        };
        condition.offset = vec![0.0; condition.interface.nonmortar.len()];
        let points = model.bodies[condition.nonmortar.body.0].mesh.points();
        prepare_law(contact, condition, points, time);
        for (node, lost) in condition.interface.nodes.iter().zip(&condition.touch.lost) {
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
                        side: condition.nonmortar.side.clone(),
                        text: tension.to_string(),
                        point: show(at),
                        value,
                        most,
                    },
                });
            }
            condition.offset[row] = -value * node.weight;
        }
    }
    Ok(())
}
