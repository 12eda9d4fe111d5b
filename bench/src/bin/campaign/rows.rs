//! The rows of `contact.csv` against the true forces, and the laws of contact row by row.

use crate::check::{View, resolution};
use crate::cone::{EDGES, cone, distance};
use crate::held::free_part;
use crate::judgement::Judgement;
use crate::problem::Law;
use crate::raw::{Row, Status, Step};
use crate::state::State;
use crate::touch::{Sample, Touch};
use crate::vector::{across, dot, length, minus, plus, raised, tangents, times, unit};
use std::collections::BTreeMap;

/// Force of a row on its node of the nonmortar body; `None` where it is not defined.
pub fn force<const D: usize>(row: &Row<D>) -> Option<[f64; D]> {
    let push = times(-row.pressure * row.weight, row.normal);
    let force = plus(push, row.weight, row.shear);
    force.iter().all(|c| c.is_finite()).then_some(force)
}

/// Displacement of an obstacle that a force moves: the least one with which the rows that bear force are closed.
pub fn placed_obstacle<const D: usize>(
    touch: &Touch<'_, D>,
    step: &Step<D>,
    c: usize,
    state: &State<D>,
) -> Option<[f64; D]> {
    let rows = &step.contacts[c].rows;
    let forces = rows.iter().map(|r| r.pressure * r.weight);
    let largest = forces.fold(0.0, f64::max);
    if largest <= 1e-6 * state.force {
        return None;
    }
    let bearing = rows
        .iter()
        .filter(|r| r.pressure * r.weight > 1e-6 * largest);
    let samples: Vec<Sample<D>> = bearing
        .filter_map(|row| touch.of_row(row).map(|(_, sample)| sample))
        .collect();
    // conjugate gradients for the normal equations: directions without any row get no displacement
    let felt = |f: &dyn Fn(&Sample<D>) -> f64| {
        let each = samples.iter();
        each.fold([0.0; D], |s, sample| plus(s, f(sample), sample.normal))
    };
    let mut moved = [0.0; D];
    for _ in 0..3 {
        let mut rest = felt(&|s| -touch.gap(s, &step.displacements, moved, step.time));
        let (mut along, first) = (rest, dot(rest, rest));
        for _ in 0..D {
            let size = dot(rest, rest);
            let image = felt(&|s| dot(s.normal, along));
            let give = dot(along, image);
            // the rest is rounding, or in directions without any row
            if size <= 1e-28 * first || give <= 1e-12 * dot(along, along) {
                break;
            }
            let part = size / give;
            (moved, rest) = (plus(moved, part, along), plus(rest, -part, image));
            along = plus(rest, dot(rest, rest) / size, along);
        }
    }
    Some(moved)
}

/// Slip of the own side relative to the other in this step, from displacements.
fn slip<const D: usize>(view: &View<'_, D>, c: usize, sample: &Sample<D>) -> Option<[f64; D]> {
    let touch = &view.touches[c];
    let now = touch.driven(view.step.time)?;
    let before = view.before.obstacles[c];
    let after = touch.slip(sample, &view.step.displacements, now);
    Some(minus(after, touch.slip(sample, &view.before.moves, before)))
}

/// The slips of rows are those of their own conditions. In the plane, rows of integrated conditions tell the slips of their nodes.
fn tells_own_slip<const D: usize>(touch: &Touch<'_, D>) -> bool {
    D == 3 || touch.nodal
}

/// Largest shear force of a row with this pushing force.
fn bound<const D: usize>(view: &View<'_, D>, c: usize, row: &Row<D>, push: f64) -> f64 {
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
pub fn lost<const D: usize>(view: &View<'_, D>) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let limit = 100.0 * view.state.tiny_length();
    for (c, touch) in view.touches.iter().enumerate() {
        if !matches!(touch.contact.law, Law::Joint { .. }) || !touch.nodal {
            continue;
        }
        for (&node, samples) in &touch.at_nodes {
            let gone = samples.iter().any(|sample| {
                let gap = touch.gap(sample, &view.step.displacements, [0.0; D], view.step.time);
                gap > limit || slip(view, c, sample).is_some_and(|slip| length(slip) > limit)
            });
            found.extend(gone.then_some((c, node)));
        }
    }
    found
}

/// The laws of contact in every row, and the rows against the true forces.
pub fn check_rows<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    for (c, raw) in view.step.contacts.iter().enumerate() {
        check_weights(judgement, view, c);
        check_work(judgement, view, c);
        let resolved = resolution(view, c);
        for (place, row) in raw.rows.iter().enumerate() {
            if row.status != Status::Fixed && row.status != Status::Tied {
                let before = view.before.step.and_then(|step| {
                    let rows = &step.contacts[c].rows;
                    rows.get(place).filter(|before| before.node == row.node)
                });
                check_row(judgement, view, c, (row, before), &resolved);
            }
        }
    }
    check_forces(judgement, view);
    check_pushes(judgement, view);
}

fn check_weights<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>, c: usize) {
    let touch = &view.touches[c];
    let rows = &view.step.contacts[c].rows;
    let known: Vec<&Row<D>> = rows.iter().filter(|r| !r.gap.is_nan()).collect();
    if known.is_empty() || rows.iter().any(|r| r.status == Status::Fixed) {
        return;
    }
    let (flat, name) = (touch.skin.flat(), &touch.contact.name);
    if let (false, Some(facing)) = (touch.nodal, touch.facing.area) {
        if facing > 0.0 {
            let sum: f64 = known.iter().map(|r| r.weight).sum();
            // a sliver of a facet that the program leaves out is less than a thousandth of its nodes' weight
            judgement.compare("weight", (sum - facing).abs(), 1e-3 * facing, || {
                format!("contact {name}: sum {sum:.6e}, facing {facing:.6e}")
            });
        }
        return;
    }
    if !touch.nodal {
        return;
    }
    let weights = touch.weights(view.problem);
    // where a round side turns away from the other side, there is no contact and weights have no meaning;
    // of a sharp edge of it only some faces may touch
    let asked = known
        .into_iter()
        .filter(|r| flat || r.pressure > 0.0 && !touch.skin.sharp(r.node));
    // several rows may share the facets of a corner
    let mut sums: BTreeMap<(usize, Vec<usize>), f64> = BTreeMap::new();
    for row in asked {
        let facets = match touch.of_row(row) {
            Some((facets, _)) if touch.other.is_some() => facets,
            _ => touch.skin.around(row.node).to_vec(),
        };
        *sums.entry((row.node, facets)).or_default() += row.weight;
    }
    for ((node, facets), sum) in sums {
        let each = facets.iter().filter_map(|&f| weights.get(&(node, f)));
        let own: f64 = each.sum();
        // a sharp corner may bear although none of its facets faces the obstacle
        if own == 0.0 && touch.met.contains(&node) {
            continue;
        }
        // on a curved facet the area is no polynomial: its value depends on the Gauss rule
        let limit = if flat { 1e-6 } else { 1e-3 };
        judgement.compare("weight", (sum - own).abs(), limit * sum, || {
            view.node(touch.own, node)
        });
    }
}

/// The initial gap of a row, where it is known: at its own node, or the same everywhere.
fn initial<const D: usize>(
    touch: &Touch<'_, D>,
    row: &Row<D>,
    spread: Option<f64>,
    t: f64,
) -> Option<f64> {
    match touch.nodal {
        true => touch
            .of_row(row)
            .map(|(_, sample)| touch.clearance(&sample, t)),
        false => spread,
    }
}

/// The work of the forces of a contact on the displacements equals that of its rows on their gaps and slips:
///
/// ```text
///   Σ f·u = Σ pressure·weight·(gap − g₀) + Σ weight·shear·slip
/// ```
fn check_work<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>, c: usize) {
    let (touch, t) = (&view.touches[c], view.step.time);
    let clear: Vec<f64> = touch.samples().map(|s| touch.clearance(s, t)).collect();
    let low = clear.iter().copied().fold(f64::INFINITY, f64::min);
    let high = clear.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let same = (high - low <= 1e-13 * view.state.size).then_some(low);
    let Some(obstacle) = touch.driven(t) else {
        return;
    };
    if touch.contact.law.rough() && !tells_own_slip(touch) {
        return;
    }
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
        let Some(initial) = initial(touch, row, same, t) else {
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

fn check_row<const D: usize>(
    judgement: &mut Judgement,
    view: &View<'_, D>,
    c: usize,
    (row, before): (&Row<D>, Option<&Row<D>>),
    resolved: &[f64],
) {
    let touch = &view.touches[c];
    let law = &touch.contact.law;
    let limit = view.state.limits[touch.own][row.node];
    let place = || view.node(touch.own, row.node);
    let push = row.pressure * row.weight;
    let strength = match law {
        Law::Joint { tension, .. } if !view.lost.contains(&(c, row.node)) => tension * row.weight,
        _ => 0.0,
    };
    judgement.compare("tension", -push - strength, limit + 1e-6 * strength, place);
    let (shear, most) = (times(row.weight, row.shear), bound(view, c, row, push));
    let few = if law.rough() { 10.0 * limit } else { limit };
    judgement.compare("shear", length(shear) - most, few, place);
    judgement.compare("shear", dot(shear, row.normal).abs(), few, place);
    if row.gap.is_nan() {
        return;
    }
    let tiny = view.state.tiny_length();
    judgement.compare("penetration", -row.gap, tiny, place);
    if push > 10.0 * limit {
        judgement.compare("open force", row.gap, tiny, place);
    }
    // held along a tangent: a part of the shear is not determined
    let held = view.state.held[touch.own].get(&row.node);
    let free = |t: &[f64; D]| length(free_part(*t, held)) > 1.0 - 1e-9;
    let free = tangents(row.normal).iter().all(free);
    if !law.rough() || matches!(law, Law::Joint { .. }) || !free || most <= 0.0 {
        return;
    }
    let slide = Slide {
        shear,
        most,
        limit,
        tiny,
    };
    if tells_own_slip(touch) {
        let told = before.map_or(row.slip, |before| minus(row.slip, before.slip));
        slide.check(judgement, told, tiny, true, place);
    }
    let known = touch
        .of_row(row)
        .filter(|_| !touch.mixed.contains(&row.node));
    let Some((_, sample)) = known else { return };
    let Some(own) = slip(view, c, &sample) else {
        return;
    };
    if touch.nodal {
        slide.check(judgement, own, tiny, true, place);
        return;
    }
    // the condition is a mean over the facets around, on which the slip may differ from that at the node
    let around = touch.skin.around(row.node);
    let between = touch.facing.between.iter();
    let nearby = between.filter(|s| around.contains(&s.facet));
    let others = nearby.filter_map(|s| Some(length(minus(slip(view, c, s)?, own))));
    let smallest = resolved[sample.facet] + others.fold(0.0, f64::max);
    slide.check(judgement, own, smallest, false, place);
}

/// The shear force of a row, which may be as large as `most`.
struct Slide<const D: usize> {
    shear: [f64; D],
    most: f64,
    /// Rounding of forces and of lengths.
    limit: f64,
    tiny: f64,
}

impl<const D: usize> Slide<D> {
    /// The law of friction with a slip: smaller ones than `smallest` count as none; `sharp` if it belongs to the row alone.
    fn check(
        &self,
        judgement: &mut Judgement,
        slip: [f64; D],
        smallest: f64,
        sharp: bool,
        place: impl Fn() -> String,
    ) {
        let (most, limit, far) = (self.most, self.limit, length(slip));
        if length(self.shear) < most - 10.0 * limit - 1e-6 * most {
            judgement.compare("stuck slip", far, smallest, &place);
        }
        if far <= smallest {
            return;
        }
        // the shear on the own body is against its slip, and as large as it may be
        let against = -dot(self.shear, unit(slip));
        if !sharp {
            // in space the mean of slips, with weights of both signs, may have another direction
            if D == 2 {
                judgement.compare("shear sign", -against, 100.0 * limit + 1e-2 * most, place);
            }
            return;
        }
        // in space, rounding turns a small slip
        let angle = if D == 2 { 0.0 } else { self.tiny / far };
        let blurred = 1e-5 + angle * angle;
        let allowed = 100.0 * limit + blurred * most;
        judgement.compare("shear sign", most - against, allowed, place);
    }
}

/// The forces of the rows at every node of contacts whose conditions hold node by node, against the true ones.
fn check_forces<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    let mut sums: BTreeMap<(usize, usize), Option<[f64; D]>> = BTreeMap::new();
    let mut add = |place: (usize, usize), force: Option<[f64; D]>| {
        let sum = sums.entry(place).or_insert(Some([0.0; D]));
        *sum = sum.zip(force).map(|(sum, force)| plus(sum, 1.0, force));
    };
    for (c, touch) in view.touches.iter().enumerate() {
        for (body, skin, _) in view.sides(c) {
            let known = touch.nodal.then_some([0.0; D]);
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

/// Nodal forces push: into the body, along the normal of its own side.
fn check_pushes<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    for ((body, node), contacts) in view.members() {
        let [(c, own)] = contacts[..] else { continue };
        let touch = &view.touches[c];
        let bears = matches!(touch.contact.law, Law::Tied | Law::Joint { .. });
        let skin = match &touch.opposite {
            Some(opposite) if !own => opposite,
            _ => &touch.skin,
        };
        if bears || view.state.held[body].contains_key(&node) || skin.sharp(node) {
            continue;
        }
        // a parabola that carries biorthogonal multipliers pulls between its nodes
        if !touch.nodal && !own && !touch.skin.linear() {
            continue;
        }
        let normal = skin.normal_at(node);
        let force = view.state.rest[body][node];
        let limit = 10.0 * view.state.limits[body][node];
        let rough = touch.contact.law.rough();
        let allowed = if touch.nodal {
            // normals of both sides differ by the angle of a facet where friction or a curve turns the force
            let parts = if rough { 1.5 } else { 0.5 };
            let lean = if rough { lean(view, c) } else { 0.0 };
            limit + (parts * skin.turn + lean) * length(force)
        } else {
            // each along its own normal: a node whose neighbours push elsewhere on a curve may pull, too
            let nodes = || skin.around.keys().map(|&n| (n, view.state.rest[body][n]));
            let push = nodes().map(|(n, f)| -dot(f, skin.normal_at(n)));
            let push = push.fold(0.0, f64::max);
            let size = nodes().map(|(_, f)| length(f)).fold(0.0, f64::max);
            let aside = if rough {
                (turned_shear(touch) + lean(view, c)) * size
            } else {
                0.0
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
fn turned_shear<const D: usize>(touch: &Touch<'_, D>) -> f64 {
    let opposite = touch.opposite.as_ref();
    if touch.skin.corners || opposite.is_some_and(|o| o.corners) {
        return 2.0;
    }
    let turn = touch.skin.turn + opposite.map_or(0.0, |o| o.turn);
    3.0 * turn.min(std::f64::consts::FRAC_PI_2).sin()
}

/// Largest sine between the normal of an obstacle and that of a side at its nodes: shear along the one pulls at the other.
fn lean<const D: usize>(view: &View<'_, D>, c: usize) -> f64 {
    let touch = &view.touches[c];
    if touch.opposite.is_some() {
        return 0.0;
    }
    let rows = view.step.contacts[c].rows.iter();
    let sines = rows.map(|row| length(across(row.normal, touch.skin.normal_at(row.node))));
    sines.fold(0.0, f64::max)
}

/// Where a row has no force, the contacts there must still allow the force on its node.
pub fn check_corners<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    for ((body, node), contacts) in view.members() {
        let nodal = |&(c, own): &(usize, bool)| own && view.touches[c].nodal;
        // a bound that does not depend on the pressure defines no cone
        let cones = |&(c, _): &(usize, bool)| {
            let law = &view.touches[c].contact.law;
            matches!(law, Law::Frictionless | Law::Coulomb(_))
        };
        if !contacts.iter().all(nodal) || !contacts.iter().all(cones) {
            continue;
        }
        let rows = contacts.iter().flat_map(|&(c, _)| {
            let rows = view.step.contacts[c].rows.iter();
            rows.filter(|r| r.node == node).map(move |row| (c, row))
        });
        let rows: Vec<(usize, &Row<D>)> = rows.collect();
        if !rows.iter().any(|(_, row)| row.pressure.is_nan()) {
            continue;
        }
        let held = view.state.held[body].get(&node);
        let flat = |v: [f64; D]| raised(free_part(v, held));
        let edges = rows.iter().flat_map(|(c, row)| allowed(view, *c, row));
        let columns: Vec<[f64; 3]> = edges.map(flat).collect();
        let force = view.state.rest[body][node];
        let off = distance(&columns, flat(force));
        let limit = 10.0 * view.state.limits[body][node];
        judgement.compare("corner", off, limit, || view.node(body, node));
    }
}

/// Edges of the cone of forces that a contact may exert on a node with its gap and its slip.
fn allowed<const D: usize>(view: &View<'_, D>, c: usize, row: &Row<D>) -> Vec<[f64; D]> {
    let touch = &view.touches[c];
    let (Some((_, sample)), Some(obstacle)) = (touch.of_row(row), view.obstacles[c]) else {
        return Vec::new();
    };
    let tiny = view.state.tiny_length();
    let gap = touch.gap(&sample, &view.step.displacements, obstacle, view.step.time);
    if gap > tiny {
        return Vec::new();
    }
    let push = times(-1.0, sample.normal);
    let coefficient = bound(view, c, row, 1.0);
    match slip(view, c, &sample) {
        Some(slip) if length(slip) > tiny => vec![plus(push, -coefficient, unit(slip))],
        _ => cone(push, coefficient, EDGES, true),
    }
}
