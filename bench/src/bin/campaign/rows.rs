//! The rows of `contact.csv` against the true forces, and the laws of contact row by row.

use crate::check::{View, resolution};
use crate::cone::distance;
use crate::held::free_part;
use crate::judgement::Judgement;
use crate::plane::{Vector, dot, length, minus, plus, times, turned};
use crate::problem::Law;
use crate::raw::{Row, Status, Step};
use crate::state::State;
use crate::touch::{Sample, Touch};
use std::collections::BTreeMap;

/// Force of a row on its node of the nonmortar body; `None` where it is not defined.
pub fn force(row: &Row) -> Option<Vector> {
    let push = plus(
        times(-row.pressure * row.weight, row.normal),
        row.shear() * row.weight,
        turned(row.normal),
    );
    push.iter().all(|c| c.is_finite()).then_some(push)
}

/// Displacement of an obstacle that a force moves: the least one with which the rows that bear force are closed.
pub fn placed_obstacle(
    touch: &Touch<'_>,
    step: &Step,
    contact: usize,
    state: &State,
) -> Option<Vector> {
    let rows = &step.contacts[contact].rows;
    let largest = rows
        .iter()
        .fold(0.0, |s: f64, r| s.max(r.pressure * r.weight));
    if largest <= 1e-6 * state.force {
        return None;
    }
    let bearing = rows
        .iter()
        .filter(|r| r.pressure * r.weight > 1e-6 * largest);
    let samples: Vec<&Sample> = bearing
        .filter_map(|r| touch.at_nodes.get(&r.node))
        .collect();
    let mut matrix = [[0.0; 2]; 2];
    for n in samples.iter().map(|s| s.normal) {
        for i in 0..2 {
            for j in 0..2 {
                matrix[i][j] += n[i] * n[j];
            }
        }
    }
    // directions without any row get no displacement
    let small = 1e-9 * (matrix[0][0] + matrix[1][1]);
    let (a, b, d) = (matrix[0][0] + small, matrix[0][1], matrix[1][1] + small);
    let volume = a * d - b * b;
    let mut moved = [0.0; 2];
    // repeated: each time the error of that small number shrinks by the same factor
    for _ in 0..4 {
        let mut right = [0.0; 2];
        for sample in &samples {
            let gap = touch.gap(sample, &step.displacements, moved, step.time);
            right = plus(right, -gap, sample.normal);
        }
        moved[0] += (d * right[0] - b * right[1]) / volume;
        moved[1] += (a * right[1] - b * right[0]) / volume;
    }
    Some(moved)
}

/// Slip of the own side relative to the other in this step, along the tangent.
fn slip(view: &View<'_>, c: usize, sample: &Sample) -> Option<f64> {
    let touch = &view.touches[c];
    let now = touch.driven(view.step.time)?;
    let before = view.before.obstacles[c];
    let after = touch.slip(sample, &view.step.displacements, now);
    Some(after - touch.slip(sample, &view.before.moves, before))
}

/// Largest shear force of a row with this pushing force.
fn bound(view: &View<'_>, c: usize, row: &Row, push: f64) -> f64 {
    let x = view.answer.meshes[view.touches[c].own].points[row.node];
    match &view.touches[c].contact.law {
        Law::Frictionless => 0.0,
        Law::Coulomb(coefficient) => coefficient.at(x, view.step.time) * push.max(0.0),
        Law::Tresca(traction) => traction.at(x, view.step.time) * row.weight,
        Law::Tied => f64::INFINITY,
        Law::Joint { coulomb, .. } if view.lost.contains(&(c, row.node)) => coulomb * push.max(0.0),
        Law::Joint {
            coulomb, cohesion, ..
        } => (coulomb * push + cohesion * row.weight).max(0.0),
    }
}

/// Nodes of joints that have parted or slipped in this step, by far more than rounding.
pub fn lost(view: &View<'_>) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let limit = 100.0 * view.state.tiny_length();
    for (c, touch) in view.touches.iter().enumerate() {
        if !matches!(touch.contact.law, Law::Joint { .. }) || !touch.nodal {
            continue;
        }
        for (&node, sample) in &touch.at_nodes {
            let gap = touch.gap(sample, &view.step.displacements, [0.0; 2], view.step.time);
            let slipped = slip(view, c, sample).is_some_and(|slip| slip.abs() > limit);
            if gap > limit || slipped {
                found.push((c, node));
            }
        }
    }
    found
}

/// The laws of contact in every row, and the rows against the true forces.
pub fn check_rows(judgement: &mut Judgement, view: &View<'_>) {
    for c in 0..view.touches.len() {
        let weights = view.touches[c].weights(view.problem);
        check_weights(judgement, view, c, &weights);
        for row in &view.step.contacts[c].rows {
            if row.status != Status::Fixed && row.status != Status::Tied {
                check_row(judgement, view, c, row);
            }
        }
    }
    check_forces(judgement, view);
    check_pushes(judgement, view);
}

fn check_weights(
    judgement: &mut Judgement,
    view: &View<'_>,
    c: usize,
    weights: &BTreeMap<usize, f64>,
) {
    let touch = &view.touches[c];
    let rows = &view.step.contacts[c].rows;
    if rows.iter().any(|r| r.status == Status::Fixed) {
        return;
    }
    if touch.nodal {
        // where a round side turns away from the other side, there is no contact and weights have no meaning
        for row in rows
            .iter()
            .filter(|r| touch.curve.straight() || r.pressure > 0.0)
        {
            if row.gap.is_nan() {
                continue;
            }
            // a sharp corner may bear although none of its facets faces the obstacle
            let own = match weights.get(&row.node) {
                None if touch.met.contains(&row.node) => row.weight,
                own => own.copied().unwrap_or(0.0),
            };
            let off = (row.weight - own).abs();
            // on a curved facet the area is no polynomial: its value depends on the Gauss rule
            let limit = if touch.curve.straight() { 1e-6 } else { 1e-3 };
            judgement.compare("weight", off, limit * row.weight, || {
                view.node(touch.own, row.node)
            });
        }
    } else if touch.curve.straight()
        && touch.opposite.as_ref().is_none_or(|o| o.straight())
        && rows.iter().any(|r| !r.gap.is_nan())
    {
        let sum: f64 = rows
            .iter()
            .filter(|r| !r.gap.is_nan())
            .map(|r| r.weight)
            .sum();
        let area = touch.facing_area(view.problem);
        // a sliver of a facet that the program leaves out is less than a thousandth of its nodes' weight
        judgement.compare("weight", (sum - area).abs(), 1e-3 * area, || {
            format!(
                "contact {}: sum {sum:.6e}, facing {area:.6e}",
                touch.contact.name
            )
        });
    }
}

fn check_row(judgement: &mut Judgement, view: &View<'_>, c: usize, row: &Row) {
    let touch = &view.touches[c];
    let limit = view.state.limits[touch.own][row.node];
    let place = || view.node(touch.own, row.node);
    let push = row.pressure * row.weight;
    let strength = match touch.contact.law {
        Law::Joint { tension, .. } if !view.lost.contains(&(c, row.node)) => tension * row.weight,
        _ => 0.0,
    };
    judgement.compare("tension", -push - strength, limit + 1e-6 * strength, place);
    if !touch.contact.law.rough() {
        let shear = (row.shear() * row.weight).abs();
        judgement.compare("shear", shear, limit, place);
        return;
    }
    let shear = row.shear() * row.weight;
    let most = bound(view, c, row, push);
    judgement.compare("shear", shear.abs() - most, 10.0 * limit, place);
    if matches!(touch.contact.law, Law::Joint { .. }) {
        return;
    }
    let Some(sample) = touch.at_nodes.get(&row.node) else {
        return;
    };
    if row.gap.is_nan()
        || matches!(row.status, Status::Open) && most == 0.0
        || touch.mixed(row.node)
    {
        return;
    }
    let Some(slip) = slip(view, c, sample) else {
        return;
    };
    let smallest = if touch.nodal {
        view.state.tiny_length()
    } else {
        // the condition is a mean over the facets around, on which the slip may differ from that at the node
        let around = &touch.curve.around[&row.node];
        let nearby = touch.between.iter().filter(|s| around.contains(&s.facet));
        let others = nearby.filter_map(|s| Some((self::slip(view, c, s)? - slip).abs()));
        resolution(view, c)[sample.facet] + others.fold(0.0, f64::max)
    };
    // held along the tangent on both sides: the shear is not determined
    let held = view.state.held[touch.own].get(&row.node);
    if length(free_part(turned(row.normal), held)) < 1.0 - 1e-9 {
        return;
    }
    if shear.abs() < most - 10.0 * limit - 1e-6 * most {
        judgement.compare("stuck slip", slip.abs(), smallest, place);
    }
    if slip.abs() > smallest {
        // the shear on the own body is against its slip, and as large as it may be
        let against = -shear * slip.signum();
        if touch.nodal {
            judgement.compare(
                "shear sign",
                most - against,
                100.0 * limit + 1e-5 * most,
                place,
            );
        } else {
            judgement.compare("shear sign", -against, 100.0 * limit + 1e-2 * most, place);
        }
    }
}

/// The forces of the rows at every node of contacts whose conditions hold node by node, against the true ones.
fn check_forces(judgement: &mut Judgement, view: &View<'_>) {
    let mut sums: BTreeMap<(usize, usize), Option<Vector>> = BTreeMap::new();
    let mut add = |place: (usize, usize), force: Option<Vector>| {
        let sum = sums.entry(place).or_insert(Some([0.0; 2]));
        *sum = match (*sum, force) {
            (Some(sum), Some(force)) => Some(plus(sum, 1.0, force)),
            _ => None,
        };
    };
    for (c, touch) in view.touches.iter().enumerate() {
        let sides = [
            (Some(touch.own), Some(&touch.curve)),
            (touch.other, touch.opposite.as_ref()),
        ];
        for (body, curve) in sides {
            if let (Some(body), Some(curve)) = (body, curve) {
                let known = if touch.nodal { Some([0.0; 2]) } else { None };
                curve
                    .around
                    .keys()
                    .for_each(|&node| add((body, node), known));
            }
        }
        if !touch.nodal {
            continue;
        }
        for row in &view.step.contacts[c].rows {
            let force = force(row);
            add((touch.own, row.node), force);
            if let (Some(body), Some(&partner)) = (touch.other, touch.partners.get(&row.node)) {
                add((body, partner), force.map(|f| times(-1.0, f)));
            }
        }
    }
    for ((body, node), sum) in sums {
        let Some(sum) = sum else { continue };
        let off = view
            .state
            .free(body, node, minus(view.state.rest[body][node], sum));
        let limit = 10.0 * view.state.limits[body][node];
        judgement.compare("row force", length(off), limit, || view.node(body, node));
    }
}

/// Nodal forces push: into the body, along the normal of its own side.
fn check_pushes(judgement: &mut Judgement, view: &View<'_>) {
    for ((body, node), contacts) in view.members() {
        let [(c, own)] = contacts[..] else { continue };
        let touch = &view.touches[c];
        let bears = matches!(touch.contact.law, Law::Tied | Law::Joint { .. });
        if bears || view.state.held[body].contains_key(&node) {
            continue;
        }
        let curve = if own {
            Some(&touch.curve)
        } else {
            touch.opposite.as_ref()
        };
        let Some(curve) = curve else { continue };
        // a parabola that carries biorthogonal multipliers pulls between its nodes
        let parabolas = touch.curve.facets.iter().any(|f| f.nodes.len() == 3);
        if parabolas && !touch.nodal && !own {
            continue;
        }
        let normal = curve.normal_at(node);
        let force = view.state.rest[body][node];
        let limit = 10.0 * view.state.limits[body][node];
        let allowed = if touch.nodal {
            // normals of both sides differ by the angle of a facet where friction or a curve turns the force
            limit
                + (0.5 * curve.turn + f64::from(u8::from(touch.contact.law.rough())) * curve.turn)
                    * length(force)
        } else {
            let nodes = || curve.around.keys().map(|&n| view.state.rest[body][n]);
            let push = nodes().fold(0.0, |s: f64, f| s.max(-dot(f, normal)));
            let size = nodes().fold(0.0, |s: f64, f| s.max(length(f)));
            let aside = match touch.contact.law.rough() {
                true => turned_shear(touch) * size,
                false => 0.0,
            };
            limit + (2.0 * push + aside).min(2.0 * push.max(size))
        };
        judgement.compare("tension", dot(force, normal), allowed, || {
            view.node(body, node)
        });
    }
}

/// Largest pull of the shears of integrated rows at a node along its normal n, as a part of the largest force of the side.
///
/// With the contact normal ν and its tangent t the tractions λ and τ of the rows exert ∫N (∓λ ν·n ± τ t·n) there, N the shape function
/// of the node. On a facet τ is the linear function whose moments with the hat functions of its ends are those of the rows. It is
/// 2q₀ − q₁ at an end: at most three times the larger row if the two differ in sign, else twice, and of any sign, although the law
/// holds in each row. But |t·n| is the sine of the angle between ν and n, which is at most the angle between neighbouring facets of
/// both sides. Shears of straight sides do not pull.
fn turned_shear(touch: &Touch<'_>) -> f64 {
    let opposite = touch.opposite.as_ref();
    if touch.curve.corners || opposite.is_some_and(|o| o.corners) {
        return 2.0;
    }
    let turn = touch.curve.turn + opposite.map_or(0.0, |o| o.turn);
    3.0 * turn.min(std::f64::consts::FRAC_PI_2).sin()
}

/// Where a row has no force, the contacts there must still allow the force on its node.
pub fn check_corners(judgement: &mut Judgement, view: &View<'_>) {
    for ((body, node), contacts) in view.members() {
        let rows: Vec<(usize, Option<&Row>)> = contacts
            .iter()
            .map(|&(c, own)| {
                let rows = view.step.contacts[c].rows.iter();
                (c, rows.into_iter().find(|r| own && r.node == node))
            })
            .collect();
        let all_own = contacts
            .iter()
            .all(|&(c, own)| own && view.touches[c].nodal);
        let missing = rows
            .iter()
            .any(|(_, row)| row.is_some_and(|r| r.pressure.is_nan()));
        let tresca = rows.iter().any(|(c, _)| {
            matches!(
                view.touches[*c].contact.law,
                Law::Tresca(_) | Law::Tied | Law::Joint { .. }
            )
        });
        if !all_own || !missing || tresca {
            continue;
        }
        let mut edges = Vec::new();
        for (c, row) in &rows {
            if let Some(row) = row {
                edges.extend(allowed(view, *c, row));
            }
        }
        let held = view.state.held[body].get(&node);
        let flat = |v: Vector| {
            let v = free_part(v, held);
            [v[0], v[1], 0.0]
        };
        let columns: Vec<[f64; 3]> = edges.into_iter().map(flat).collect();
        let force = view.state.rest[body][node];
        let off = distance(&columns, flat(force));
        let limit = 10.0 * view.state.limits[body][node];
        judgement.compare("corner", off, limit, || view.node(body, node));
    }
}

/// Edges of the cone of forces that a contact may exert on a node with its gap and its slip.
fn allowed(view: &View<'_>, c: usize, row: &Row) -> Vec<Vector> {
    let touch = &view.touches[c];
    let (Some(sample), Some(obstacle)) = (touch.at_nodes.get(&row.node), view.obstacles[c]) else {
        return Vec::new();
    };
    let gap = touch.gap(sample, &view.step.displacements, obstacle, view.step.time);
    if gap > view.state.tiny_length() {
        return Vec::new();
    }
    let push = times(-1.0, sample.normal);
    let along = turned(sample.normal);
    let coefficient = bound(view, c, row, 1.0);
    if coefficient == 0.0 {
        return vec![push];
    }
    let ends = [
        plus(push, coefficient, along),
        plus(push, -coefficient, along),
    ];
    match slip(view, c, sample) {
        Some(slip) if slip > view.state.tiny_length() => vec![ends[1]],
        Some(slip) if slip < -view.state.tiny_length() => vec![ends[0]],
        _ => ends.to_vec(),
    }
}
