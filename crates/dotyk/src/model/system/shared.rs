//! Common nodes of several contacts.
//!
//! Where the sides of two contacts meet at a node, and both have the same opposite there, each accounts for its own facets, of the
//! weight w_k. Their conditions are the same; so there is one multiplier λ, of the weight W = Σ w_k, at the first contact, and
//!
//! ```text
//!   λₙ,k = (w_k/W) λₙ,      ‖λₜ‖ ≤ Σ μ_k λₙ,k,      λₜ,k = (μ_k w_k / Σ μ_j w_j) λₜ
//! ```
//!
//! are the parts of the contacts: the pressure λₙ/W is the same in all of them, and the sum of their forces the traction of the side.
//! With other laws than Coulomb's nodes are shared only if these are alike, with the parts w_k/W. Beside a tie the multiplier is
//! the tie's: it bears all of the shear, and all of a tensile λₙ, since a contact bears no tension.
//!
//! Conditions are the same if their rows are, at all dofs that ever move, and their gaps; which of two bodies carries the
//! multipliers does not matter. Others stay separate: two bodies beside each other under a third one, faces of a corner, near and
//! far sheets. A contact that repeats another does not share its nodes, because W would count the same facets twice; its conditions
//! are implied (`dependent.rs`).

use crate::contact::{Coupling, Row, pushed};
use crate::fem::{Body, BodySystem, Constraints};
use crate::geometry::{Field, add_scaled};
use crate::mesh::Facet;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::{Contact, Law, Model, Motion, Pair};
use crate::model::nouns::solution::{ContactSolution, Status};
use crate::model::system::condition::{Condition, Sharer, gap_varies, row_ranges};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;

/// A row at the dofs that move at some time, by body.
type Moving = Vec<((usize, usize), f64)>;

/// The dofs of a row, by body: the same for the rows of a common node.
type Dofs = Vec<(usize, usize)>;

/// Coefficients are the same within this part of the largest, gaps within this part of the size of the body.
const SAME_ROW: f64 = 1e-10;

/// Gives every common node of contacts to the one with most rows, the first of equal ones; the rows of the others are dropped.
pub(crate) fn share_nodes<const D: usize>(
    model: &Model<D>,
    systems: &[BodySystem<D>],
    conditions: &mut [Condition<D>],
) {
    let mut at_nodes: BTreeMap<Dofs, Vec<(usize, usize)>> = BTreeMap::new();
    let mut rows: BTreeMap<(usize, usize), Vec<Moving>> = BTreeMap::new();
    for (contact, condition) in conditions.iter().enumerate() {
        if !may_share(model, condition) {
            continue;
        }
        for (place, node) in condition.interface.nodes.iter().enumerate() {
            let own = node.rows.iter().flatten();
            let own: Vec<Moving> = own.map(|&row| moving(systems, condition, row)).collect();
            if let Some(normal) = own.first().filter(|normal| !normal.is_empty()) {
                let dofs = normal.iter().map(|(dof, _)| *dof).collect();
                at_nodes.entry(dofs).or_default().push((contact, place));
                rows.insert((contact, place), own);
            }
        }
    }
    let mut dropped: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut twice: BTreeMap<[usize; 2], BTreeSet<usize>> = BTreeMap::new();
    for nodes in at_nodes.into_values().filter(|nodes| nodes.len() > 1) {
        let first = |at: &(usize, usize)| (is_tied(&model.contacts[at.0]), rows[at].len());
        let mut nodes = nodes;
        // stable: of ties before others the first of those with most rows
        nodes.sort_by_key(|at| Reverse(first(at)));
        let mut owners: Vec<(usize, usize)> = Vec::new();
        for at in nodes {
            let alike = |owner: &&(usize, usize)| {
                let laws = [at.0, owner.0].map(|contact| &model.contacts[contact]);
                at.0 != owner.0
                    && laws_agree(laws)
                    && same_rows(&rows[&at], &rows[owner])
                    && same_gap(model, conditions, [at, **owner])
                    && !twice
                        .entry([at.0, owner.0])
                        .or_insert_with_key(|&both| repeated(model, conditions, both))
                        .contains(&conditions[at.0].interface.nodes[at.1].node)
            };
            let Some(&owner) = owners.iter().find(alike) else {
                owners.push(at);
                continue;
            };
            let node = &conditions[at.0].interface.nodes[at.1];
            let (weight, extent) = (node.weight, node.extent);
            dropped
                .entry(at.0)
                .or_default()
                .extend(node.rows.iter().flatten());
            let condition = &mut conditions[owner.0];
            let whole = &mut condition.interface.nodes[owner.1];
            whole.weight += weight;
            whole.extent += extent;
            condition.touch.sharers.push(Sharer {
                place: owner.1,
                at,
                weight,
                extent,
            });
        }
    }
    for (contact, rows) in dropped {
        conditions[contact].drop_rows(&rows);
    }
}

/// Nodes of the nonmortar side of a contact on facets that another contact has, too, against the same opposite.
fn repeated<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
    [contact, other]: [usize; 2],
) -> BTreeSet<usize> {
    let mesh = |side: &SideRef| &model.bodies[side.body.0].mesh;
    let facets = |side: &SideRef| mesh(side).side(&side.side).unwrap_or_default();
    let (own, other) = (&conditions[contact], &conditions[other]);
    let common = |side: &SideRef| -> Vec<Facet> {
        let others = [Some(&other.nonmortar), other.mortar.as_ref()];
        let others = others.into_iter().flatten();
        let others = others.filter(|of| of.body == side.body).flat_map(facets);
        let others: BTreeSet<&Facet> = others.collect();
        let both = facets(side).iter().filter(|facet| others.contains(facet));
        both.copied().collect()
    };
    if own
        .mortar
        .as_ref()
        .is_some_and(|side| common(side).is_empty())
    {
        return BTreeSet::new();
    }
    let nodes = common(&own.nonmortar).into_iter();
    let nodes = nodes.flat_map(|facet| mesh(&own.nonmortar).facet_nodes(facet));
    nodes.map(|node| node as usize).collect()
}

/// A contact that may share nodes: its gaps do not vary, its obstacle does not move, and there is no gasket in it.
fn may_share<const D: usize>(model: &Model<D>, condition: &Condition<D>) -> bool {
    let moved = |contact: &Contact<D>| match &contact.pair {
        Pair::Obstacle { obstacle, .. } => matches!(obstacle.motion, Motion::Loaded(_)),
        _ => false,
    };
    let contact = condition.contact_of(model);
    // gaskets in two contacts are springs beside each other
    contact.is_some_and(|c| !gap_varies(c) && !moved(c) && c.gasket.is_none())
}

fn is_tied<const D: usize>(contact: &Contact<D>) -> bool {
    matches!(contact.law, Law::Tied)
}

/// Two laws that have a common bound which can be divided among the contacts; the second contact carries the multiplier.
fn laws_agree<const D: usize>([a, b]: [&Contact<D>; 2]) -> bool {
    let dry = |law: &Law| matches!(law, Law::Frictionless | Law::Coulomb(_));
    if is_tied(b) && dry(&a.law) {
        return true;
    }
    let constant =
        |law: &Law| -> Vec<Option<f64>> { law.fields().iter().map(|f| f.as_constant()).collect() };
    let same = std::mem::discriminant(&a.law) == std::mem::discriminant(&b.law);
    let values = [constant(&a.law), constant(&b.law)];
    let known = !values[0].contains(&None);
    dry(&a.law) && dry(&b.law) || same && known && values[0] == values[1]
}

/// A row at the dofs that move at some time.
fn moving<const D: usize>(
    systems: &[BodySystem<D>],
    condition: &Condition<D>,
    row: usize,
) -> Moving {
    let mut sums: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for (body, rows) in condition.ends() {
        let system = &systems[body];
        let still = |constraints: &Constraints<D>, dof: usize| {
            system.held[dof] && constraints.at(dof / D).iter().all(|held| held.still)
        };
        let in_frames = system.row_in_frames(&rows[row]);
        for (dof, value) in in_frames.filter(|(dof, _)| !still(&system.constraints, *dof)) {
            *sums.entry((body, dof)).or_insert(0.0) += value;
        }
    }
    sums.into_iter().collect()
}

/// Whether the rows of one node are the first ones of another node with at least as many: the normal one, then the tangents.
fn same_rows(some: &[Moving], all: &[Moving]) -> bool {
    let largest = |row: &Moving| row.iter().fold(0.0, |s: f64, (_, c)| s.max(c.abs()));
    let same = |(a, b): (&Moving, &Moving)| {
        let limit = SAME_ROW * largest(a).max(largest(b));
        a.len() == b.len()
            && a.iter()
                .zip(b)
                .all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() <= limit)
    };
    some.iter().zip(all).all(same)
}

fn same_gap<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
    at: [(usize, usize); 2],
) -> bool {
    let gap = |(contact, place): (usize, usize)| {
        let condition = &conditions[contact];
        let node = &condition.interface.nodes[place];
        let row = node.rows[0]?;
        let interface = &condition.interface;
        let rows = [&interface.nonmortar[row], &interface.mortar[row]];
        let fitted = condition.touch.fit.along(rows[0], rows[1]);
        Some(node.gap + fitted)
    };
    let size = |contact: usize| {
        let body = conditions[contact].nonmortar.body.0;
        model.bodies[body].mesh.diameter()
    };
    match at.map(gap) {
        [Some(a), Some(b)] => (a - b).abs() <= SAME_ROW * size(at[0].0),
        _ => false,
    }
}

impl<const D: usize> Condition<D> {
    /// Shares of other contacts in one of its nodes.
    pub fn sharers_at(&self, place: usize) -> impl Iterator<Item = &Sharer> {
        self.touch.sharers.iter().filter(move |s| s.place == place)
    }

    /// Weight of the facets of a node that are its own.
    pub fn own_weight(&self, place: usize) -> f64 {
        let others: f64 = self.sharers_at(place).map(|s| s.weight).sum();
        self.interface.nodes[place].weight - others
    }
}

/// Coefficients of friction of the dry contacts at a node, times the parts of its weight: of the one that carries the multiplier, then
/// of the others. Their sum is the coefficient of the node.
pub(crate) fn coefficients<const D: usize, E>(
    model: &Model<D>,
    (contact, condition): (usize, &Condition<D>),
    place: usize,
    at: impl Fn(&Field) -> Result<f64, E>,
) -> Result<Vec<f64>, E> {
    let whole = condition.interface.nodes[place].weight;
    let own = std::iter::once((contact, condition.own_weight(place)));
    let others = condition.sharers_at(place).map(|s| (s.at.0, s.weight));
    own.chain(others)
        .map(|(contact, weight)| match &model.contacts[contact].law {
            Law::Coulomb(field) => Ok(weight / whole * at(field)?),
            _ => Ok(0.0),
        })
        .collect()
}

/// Weight of the facets at a node that bear its normal force: only tied ones if it is a tension.
pub(crate) fn bearing_weight<const D: usize>(
    model: &Model<D>,
    (contact, condition): (usize, &Condition<D>),
    place: usize,
    pulls: bool,
) -> f64 {
    let whole = condition.interface.nodes[place].weight;
    if !pulls || !is_tied(&model.contacts[contact]) {
        return whole;
    }
    let others = condition.sharers_at(place);
    let others = others.filter(|s| !is_tied(&model.contacts[s.at.0]));
    whole - others.map(|s| s.weight).sum::<f64>()
}

/// The parts of a node's shear that its contacts bear, as [`coefficients`] lists them.
pub(crate) fn shear_parts<const D: usize>(
    model: &Model<D>,
    (contact, condition): (usize, &Condition<D>),
    place: usize,
    time: f64,
) -> Vec<f64> {
    let by_weight = || {
        let tied = is_tied(&model.contacts[contact]);
        let whole = bearing_weight(model, (contact, condition), place, tied);
        let bears = |of: usize| !tied || is_tied(&model.contacts[of]);
        let own = std::iter::once(condition.own_weight(place));
        let others = condition.sharers_at(place);
        let others = others.map(|s| if bears(s.at.0) { s.weight } else { 0.0 });
        own.chain(others).map(|weight| weight / whole).collect()
    };
    if !matches!(model.contacts[contact].law, Law::Coulomb(_)) {
        return by_weight();
    }
    let node = condition.interface.nodes[place].node;
    let point = model.bodies[condition.nonmortar.body.0].mesh.points()[node];
    let at = |field: &Field| Ok::<f64, Infallible>(field.at(point, time));
    let Ok(parts) = coefficients(model, (contact, condition), place, at);
    let sum: f64 = parts.iter().sum();
    match sum > 0.0 {
        true => parts.into_iter().map(|part| part / sum).collect(),
        false => by_weight(),
    }
}

/// Gives every contact its part of the forces at common nodes; `lambda` (m,), gaps (m,).
pub(crate) fn share_out<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
    [lambda, gaps]: [&[f64]; 2],
    time: f64,
    contacts: &mut [ContactSolution<D>],
) {
    for (contact, (rows, condition)) in row_ranges(conditions).take(contacts.len()).enumerate() {
        let forces = condition.forces(&lambda[rows.clone()]);
        let mut places: Vec<usize> = condition.touch.sharers.iter().map(|s| s.place).collect();
        places.dedup();
        for place in places {
            let node = &condition.interface.nodes[place];
            let shears = shear_parts(model, (contact, condition), place, time);
            let whole = contacts[contact].nodes[place];
            let pulls = whole.pressure < 0.0;
            let bearing = bearing_weight(model, (contact, condition), place, pulls);
            let traction = whole.pressure * (node.weight / bearing);
            let parts = condition.sharers_at(place).zip(&shears[1..]);
            for (sharer, &shear) in parts {
                let tied = is_tied(&model.contacts[sharer.at.0]);
                // beside a tie that pulls
                let none = bearing < node.weight && !tied;
                let part_of = |component: usize| match component {
                    0 if none => 0.0,
                    0 => sharer.weight / bearing,
                    _ => shear,
                };
                let of_rows = node.rows.iter().enumerate();
                let of_rows = of_rows.filter_map(|(c, row)| Some((c, (*row)?)));
                let moved: Vec<(usize, usize, f64)> = of_rows
                    .map(|(c, row)| (c, row, part_of(c) * forces[row]))
                    .collect();
                let work = moved.iter().filter(|(c, ..)| *c > 0);
                let work = work.map(|&(_, row, l)| -l * gaps[rows.start + row]);
                let work: f64 = work.sum();
                let own = moved
                    .iter()
                    .map(|&(_, row, l)| (&condition.interface.nonmortar[row], l));
                contacts[contact].take_over(
                    &model.bodies[condition.nonmortar.body.0],
                    own.map(|(row, l)| (row, -l)),
                    (-work, -sharer.extent, whole.status),
                );
                let other = &conditions[sharer.at.0];
                let implied = other.interface.implied.iter();
                let implied = implied.filter(|condition| condition.node == sharer.at.1);
                let theirs = implied.filter_map(|condition| {
                    let found = moved.iter().find(|(c, ..)| *c == condition.component);
                    found.map(|&(_, _, l)| (&condition.rows[0], l))
                });
                let of_node = &other.interface.nodes[sharer.at.1];
                let rough = other.interface.coupling != Coupling::Normal;
                let status = match whole.status {
                    Status::Tied if none => Status::Open,
                    Status::Tied if !tied && rough => Status::Stick,
                    Status::Tied if !tied => Status::Closed,
                    Status::Stick | Status::Slip if !rough => Status::Closed,
                    status => status,
                };
                contacts[sharer.at.0].take_over(
                    &model.bodies[other.nonmortar.body.0],
                    theirs,
                    (work, sharer.extent, status),
                );
                let shown = &mut contacts[sharer.at.0].nodes[sharer.at.1];
                let pressure = if none { 0.0 } else { traction };
                (shown.gap, shown.pressure, shown.status) = (whole.gap, pressure, status);
                let tangents = of_node.frame.iter().enumerate().skip(1);
                shown.shear = tangents.fold([0.0; D], |sum, (c, &direction)| {
                    let found = moved.iter().find(|(component, ..)| *component == c);
                    let force = found.filter(|_| rough).map_or(0.0, |&(_, _, l)| -l);
                    add_scaled(sum, force / sharer.weight, direction)
                });
            }
            let own = condition.own_weight(place);
            let shown = &mut contacts[contact].nodes[place];
            let of_whole = shears[0] * node.weight / own;
            (shown.weight, shown.shear) = (own, shown.shear.map(|t| of_whole * t));
            shown.pressure = traction;
        }
    }
}

impl<const D: usize> ContactSolution<D> {
    /// Adds the forces of some rows on the nonmortar body, the work of friction in them, and the extent of a node in some state.
    fn take_over<'a>(
        &mut self,
        body: &Body<D>,
        rows: impl Iterator<Item = (&'a Row<D>, f64)>,
        (work, extent, status): (f64, f64, Status),
    ) {
        for (row, force) in rows {
            let (push, moment) = pushed(
                std::slice::from_ref(row),
                &[force],
                body.mesh.points(),
                [0.0; D],
            );
            self.resultant = add_scaled(self.resultant, 1.0, push);
            self.moment = add_scaled(self.moment, 1.0, moment);
        }
        self.dissipated += work;
        self.dissipated_total += work;
        if status != Status::Open {
            self.length += extent;
        }
        match status {
            Status::Stick => self.length_stick += extent,
            Status::Slip => self.length_slip += extent,
            _ => {}
        }
    }
}
