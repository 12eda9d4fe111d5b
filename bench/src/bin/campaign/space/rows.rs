//! The rows of `contact.csv` against the true forces, and the laws of contact row by row.

use super::Row;
use super::check::View;
use super::geometry::{Vector, dot, length, minus, plus, times};
use super::problem::Law;
use super::touch::{Touch, area};
use crate::judgement::Judgement;
use crate::raw::Status;
use std::collections::{BTreeMap, BTreeSet};

/// Force of a row on its node of the nonmortar body; `None` where it is not defined.
pub fn force(row: &Row) -> Option<Vector> {
    let push = times(-row.pressure * row.weight, row.normal);
    let force = plus(push, row.weight, row.shear);
    force.iter().all(|c| c.is_finite()).then_some(force)
}

/// The laws of contact in every row, and the rows against the true forces.
pub fn check_rows(judgement: &mut Judgement, view: &View<'_>) {
    for (c, raw) in view.step.contacts.iter().enumerate() {
        check_weights(judgement, view, c);
        check_work(judgement, view, c);
        for (place, row) in raw.rows.iter().enumerate() {
            if row.status != Status::Fixed && row.status != Status::Tied {
                let before = view.before.map(|step| &step.contacts[c].rows[place]);
                check_row(judgement, view, c, row, before);
            }
        }
    }
    check_forces(judgement, view);
}

fn check_weights(judgement: &mut Judgement, view: &View<'_>, c: usize) {
    let touch = &view.touches[c];
    let rows = &view.step.contacts[c].rows;
    let known = rows.iter().filter(|r| !r.gap.is_nan());
    if rows.iter().any(|r| r.status == Status::Fixed) {
        return;
    }
    if touch.nodal {
        let weights = touch.weights();
        // where a round side turns away from the other side, there is no contact and weights have no meaning;
        // of a sharp edge only some faces may touch
        let asked =
            known.filter(|r| touch.exact || r.pressure > 0.0 && touch.faces(r.node).is_empty());
        let asked: BTreeSet<usize> = asked.map(|r| r.node).collect();
        // a node at a sharp edge has a row for each of its faces
        let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
        for row in rows.iter().filter(|r| asked.contains(&r.node)) {
            *sums.entry(row.node).or_default() += row.weight;
        }
        for (node, sum) in sums {
            let own = weights.get(&node).copied().unwrap_or(0.0);
            // on a curved facet the area is no polynomial: its value depends on the Gauss rule
            let limit = if touch.skin.flat() { 1e-6 } else { 1e-3 };
            judgement.compare("weight", (sum - own).abs(), limit * own, || {
                view.node(touch.own, node)
            });
        }
    } else if touch.exact && !touch.polygons.is_empty() {
        let sum: f64 = known.map(|r| r.weight).sum();
        let facing: f64 = touch.polygons.iter().map(|p| area(&p.corners)).sum();
        // a sliver of a facet that the program leaves out is less than a thousandth of its nodes' weight
        judgement.compare("weight", (sum - facing).abs(), 1e-3 * facing, || {
            let name = &touch.contact.name;
            format!("contact {name}: sum {sum:.6e}, facing {facing:.6e}")
        });
    }
}

/// The initial gap of a row, where it is known: at its own node, or the same everywhere.
fn initial(touch: &Touch<'_>, row: &Row, spread: Option<f64>) -> Option<f64> {
    match touch.nodal {
        true => touch.at_row(row).map(|s| touch.clearance(&s)),
        false => spread,
    }
}

/// The work of the forces of a contact on the displacements equals that of its rows on their gaps and slips:
///
/// ```text
///   Σ f·u = Σ pressure·weight·(gap − g₀) + Σ weight·shear·slip
/// ```
fn check_work(judgement: &mut Judgement, view: &View<'_>, c: usize) {
    let touch = &view.touches[c];
    let samples = touch.between.iter().chain(touch.at_nodes.values());
    let clear: Vec<f64> = samples.map(|s| touch.clearance(s)).collect();
    let low = clear.iter().copied().fold(f64::INFINITY, f64::min);
    let high = clear.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let same = (high - low <= 1e-13 * view.state.size).then_some(low);
    let Some(obstacle) = touch.driven(view.step.time) else {
        return;
    };
    let members = view.members();
    let (mut work, mut limit) = (0.0, 0.0);
    for (body, skin, own) in view.sides(c) {
        for &node in skin.around.keys() {
            let alone = members[&(body, node)].len() == 1;
            if !alone || view.state.held[body].contains_key(&node) {
                return;
            }
            let moved = view.step.displacements[body][node];
            // the opposite force acts on an obstacle
            let moved = match own && touch.other.is_none() {
                true => minus(moved, obstacle),
                false => moved,
            };
            work += dot(view.state.rest[body][node], moved);
            limit += 10.0 * view.state.limits[body][node] * view.state.moves;
        }
    }
    for row in &view.step.contacts[c].rows {
        let push = row.pressure * row.weight;
        if row.gap.is_nan() || (push == 0.0 && length(row.shear) == 0.0) {
            continue;
        }
        let Some(initial) = initial(touch, row, same) else {
            return;
        };
        // ties are closed and do not slip, frictionless rows have no shear
        let slip = match touch.contact.law.rough() {
            true => row.weight * dot(row.shear, row.slip),
            false => 0.0,
        };
        work -= push * (row.gap - initial) + slip;
        limit += 1e-13 * view.state.size * push.abs();
    }
    judgement.compare("work", work.abs(), limit, || {
        format!("contact {}", touch.contact.name)
    });
}

/// Largest shear force of a row with this pushing force.
fn bound(law: Law, row: &Row, push: f64) -> f64 {
    match law {
        Law::Frictionless => 0.0,
        Law::Coulomb(coefficient) => coefficient * push.max(0.0),
        Law::Tresca(traction) => traction * row.weight,
        Law::Tied => f64::INFINITY,
    }
}

fn check_row(
    judgement: &mut Judgement,
    view: &View<'_>,
    c: usize,
    row: &Row,
    before: Option<&Row>,
) {
    let touch = &view.touches[c];
    let limit = view.state.limits[touch.own][row.node];
    let place = || view.node(touch.own, row.node);
    let push = row.pressure * row.weight;
    judgement.compare("tension", -push, limit, place);
    let (shear, most) = (
        times(row.weight, row.shear),
        bound(touch.contact.law, row, push),
    );
    let size = length(shear);
    judgement.compare("shear", size - most, 10.0 * limit, place);
    judgement.compare("shear", dot(shear, row.normal).abs(), 10.0 * limit, place);
    if row.gap.is_nan() {
        return;
    }
    let tiny = view.state.tiny_length();
    judgement.compare("penetration", -row.gap, tiny, place);
    if push > 10.0 * limit {
        judgement.compare("open force", row.gap, tiny, place);
    }
    // held along a tangent: a part of the shear is not determined
    let held = view.state.held[touch.own].contains_key(&row.node);
    if !touch.contact.law.rough() || held || most <= 0.0 {
        return;
    }
    let slip = before.map_or(row.slip, |before| minus(row.slip, before.slip));
    let far = length(slip);
    if size < most - 10.0 * limit - 1e-6 * most {
        judgement.compare("stuck slip", far, tiny, place);
    }
    if far > tiny {
        // the shear on the own body is against its slip, and as large as it may be
        let against = -dot(shear, slip) / far;
        let blurred = 1e-5 + (tiny / far).powi(2);
        judgement.compare(
            "shear sign",
            most - against,
            100.0 * limit + blurred * most,
            place,
        );
    }
}

/// The forces of the rows at every node of contacts whose conditions hold node by node, against the true ones.
fn check_forces(judgement: &mut Judgement, view: &View<'_>) {
    let mut sums: BTreeMap<(usize, usize), Option<Vector>> = BTreeMap::new();
    let mut add = |place: (usize, usize), force: Option<Vector>| {
        let sum = sums.entry(place).or_insert(Some([0.0; 3]));
        *sum = sum.zip(force).map(|(sum, force)| plus(sum, 1.0, force));
    };
    for (c, touch) in view.touches.iter().enumerate() {
        for (body, skin, _) in view.sides(c) {
            let known = touch.nodal.then_some([0.0; 3]);
            skin.around.keys().for_each(|&n| add((body, n), known));
        }
        for row in view.step.contacts[c].rows.iter().filter(|_| touch.nodal) {
            add((touch.own, row.node), force(row));
            if let (Some(body), Some(&partner)) = (touch.other, touch.partners.get(&row.node)) {
                add((body, partner), force(row).map(|f| times(-1.0, f)));
            }
        }
    }
    for ((body, node), sum) in sums {
        let Some(sum) = sum else { continue };
        let off = minus(view.state.rest[body][node], sum);
        let off = length(view.state.free(body, node, off));
        let limit = 10.0 * view.state.limits[body][node];
        judgement.compare("row force", off, limit, || view.node(body, node));
    }
}
