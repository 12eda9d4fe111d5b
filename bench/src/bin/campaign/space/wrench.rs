//! Resultants and moments of contacts: are both sides in balance, and could pushes at points that face the other side have these
//! resultants?
//!
//! Contacts that share nodes of a body form a cluster there: the true forces are known of the cluster. The wrench
//! (force, moment about the middle of the cluster) must lie in the cone of wrenches
//!
//! ```text
//!   (f, (x − c) × f),    f = −n + μt at points x that face the other side, n the contact normal, t a tangent
//! ```
//!
//! (with the opposite sign on the other body). A body whose load tips it over an edge or slides it fails here whatever rows
//! say. The round cone of friction is replaced by a pyramid around it, which is wider by 1/cos(π/[`EDGES`]). On curved sides
//! directions may be off by the angle between facets, because forces act along a field of normals between nodes, and between
//! the points that are looked at: there the cone is widened by that angle.

use super::check::View;
use super::geometry::{AXES, Vector, bounds, cross, dot, length, minus, plus, tangents, times};
use super::problem::{Against, Drive, Law};
use super::rows::force;
use crate::amount::vector_at;
use crate::cone::distance;
use crate::judgement::Judgement;
use crate::state::FORCE;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

/// Wrenches outside the cone by less than this part of Σ|force|·length count as inside.
const OUTSIDE: f64 = 1e-6;

/// Edges of the pyramid that replaces the cone of friction.
const EDGES: usize = 16;

/// Edges of a cone of friction about a unit direction, of a pyramid inside it or around it.
pub fn cone(direction: Vector, friction: f64, edges: usize, around: bool) -> Vec<Vector> {
    if friction == 0.0 {
        return vec![direction];
    }
    let [a, b] = tangents(direction);
    let reach = if around {
        1.0 / (PI / edges as f64).cos()
    } else {
        1.0
    };
    let edge = |k: usize| {
        let (s, c) = (TAU * k as f64 / edges as f64).sin_cos();
        let tangent = plus(times(c, a), s, b);
        plus(direction, reach * friction, tangent)
    };
    (0..edges).map(edge).collect()
}

/// Contacts that share nodes of a body.
struct Cluster {
    body: usize,
    contacts: Vec<usize>,
    nodes: BTreeSet<usize>,
}

/// The true force on a cluster with its moment about a point, and the tolerance of both.
struct Wrench {
    force: Vector,
    moment: Vector,
    /// Directions in which no node is held: the force is known in these. If all three are free, the moment is known, too.
    directions: Vec<Vector>,
    /// Σ|force|.
    magnitude: f64,
    /// Half the extent.
    arm: f64,
    centre: Vector,
    slack: f64,
}

fn clusters(view: &View<'_>) -> Vec<Cluster> {
    let mut all: Vec<Cluster> = Vec::new();
    for c in 0..view.touches.len() {
        for (body, skin, _) in view.sides(c) {
            let mut cluster = Cluster {
                body,
                contacts: vec![c],
                nodes: skin.around.keys().copied().collect(),
            };
            let (joined, apart): (Vec<Cluster>, Vec<Cluster>) = all
                .into_iter()
                .partition(|o| o.body == body && !o.nodes.is_disjoint(&cluster.nodes));
            for other in joined {
                cluster.contacts.extend(other.contacts);
                cluster.nodes.extend(other.nodes);
            }
            all = apart;
            all.push(cluster);
        }
    }
    all
}

fn wrench(view: &View<'_>, cluster: &Cluster) -> Wrench {
    let body = cluster.body;
    let points = &view.answer.meshes[body].points;
    let places: Vec<Vector> = cluster.nodes.iter().map(|&n| points[n]).collect();
    let (low, high) = bounds(&places);
    let held = cluster
        .nodes
        .iter()
        .filter_map(|n| view.state.held[body].get(n));
    // orthonormal: first the held directions, then the others
    let mut basis: Vec<Vector> = Vec::new();
    let mut free = Vec::new();
    let axes = held.flatten().map(|&axis| (axis, false));
    for (axis, is_free) in axes.chain(AXES.map(|axis| (axis, true))) {
        let rest = basis.iter().fold(axis, |r, &q| plus(r, -dot(r, q), q));
        if length(rest) > 1e-6 {
            let rest = super::geometry::unit(rest);
            basis.push(rest);
            free.extend(is_free.then_some(rest));
        }
    }
    let mut found = Wrench {
        force: [0.0; 3],
        moment: [0.0; 3],
        directions: free,
        magnitude: 0.0,
        arm: 0.5 * length(minus(high, low)),
        centre: times(0.5, plus(low, 1.0, high)),
        slack: 0.0,
    };
    for &node in &cluster.nodes {
        let force = view.state.rest[body][node];
        let arm = minus(points[node], found.centre);
        found.force = plus(found.force, 1.0, force);
        found.moment = plus(found.moment, 1.0, cross(arm, force));
        found.magnitude += length(view.state.free(body, node, force));
        found.slack += view.state.limits[body][node];
    }
    found
}

impl Wrench {
    fn free(&self) -> bool {
        self.directions.len() == 3
    }

    /// Compares a force with the reported one, in the directions in which it is known.
    fn compare(
        &self,
        judgement: &mut Judgement,
        what: &'static str,
        told: Vector,
        place: impl Fn() -> String,
    ) {
        for &direction in &self.directions {
            let off = dot(direction, minus(self.force, told)).abs();
            judgement.compare(what, off, 10.0 * self.slack, &place);
        }
    }
}

/// All checks of resultants.
pub fn check_wrenches(judgement: &mut Judgement, view: &View<'_>) {
    let mut single: BTreeMap<usize, Vec<Wrench>> = BTreeMap::new();
    for cluster in &clusters(view) {
        let found = wrench(view, cluster);
        check_sum(judgement, view, cluster, &found);
        check_footprint(judgement, view, cluster, &found);
        if let [c] = cluster.contacts[..] {
            if view.touches[c].own == cluster.body {
                let told = &view.step.contacts[c];
                let place = || places(view, cluster);
                found.compare(judgement, "resultant", told.resultant, place);
                if found.free() {
                    let moment = plus(found.moment, 1.0, cross(found.centre, found.force));
                    let off = length(minus(moment, told.moment));
                    let limit = 10.0 * found.slack * (found.arm + length(found.centre));
                    judgement.compare("resultant", off, limit, place);
                }
            }
            single.entry(c).or_default().push(found);
        }
    }
    for (c, sides) in single {
        let place = || format!("contact {}", view.touches[c].contact.name);
        match &sides[..] {
            [own, other] => check_reaction(judgement, own, other, place),
            [own] => {
                if let Against::Obstacle {
                    drive: Some(Drive::Force(field)),
                    ..
                } = &view.touches[c].contact.against
                {
                    let carried = vector_at(field, [0.0; 3], view.step.time);
                    own.compare(judgement, "obstacle", carried, place);
                }
            }
            _ => {}
        }
    }
}

/// Forces and moments of both sides of a contact sum to zero.
fn check_reaction(
    judgement: &mut Judgement,
    own: &Wrench,
    other: &Wrench,
    place: impl Fn() -> String,
) {
    let limit = 10.0 * (own.slack + other.slack);
    let sum = plus(own.force, 1.0, other.force);
    // directions known on both sides: free here, without the held directions there
    for &direction in &own.directions {
        let known = |&d: &Vector| plus(d, -1.0, direction).iter().all(|c| c.abs() < 1e-9);
        if other.free() || other.directions.iter().any(known) {
            let off = dot(direction, sum).abs();
            judgement.compare("act and react", off, limit, &place);
        }
    }
    if own.free() && other.free() {
        let shift = cross(minus(other.centre, own.centre), other.force);
        let off = plus(plus(own.moment, 1.0, other.moment), 1.0, shift);
        let arm = own.arm.max(other.arm);
        judgement.compare("act and react", length(off), limit * arm, &place);
    }
}

/// The resultant of the rows of all contacts of a cluster is that of the forces.
fn check_sum(judgement: &mut Judgement, view: &View<'_>, cluster: &Cluster, found: &Wrench) {
    let (mut sum, mut turn) = ([0.0; 3], 0.0f64);
    for &c in &cluster.contacts {
        let touch = &view.touches[c];
        let sign = if touch.own == cluster.body { 1.0 } else { -1.0 };
        if !touch.nodal {
            turn = turn.max(touch.skin.turn);
            if touch.other.is_none() {
                // integrated rows report the side's own normal, not the plane's
                for (&node, sample) in &touch.at_nodes {
                    let off = minus(sample.normal, touch.skin.normal_at(node));
                    turn = turn.max(length(off));
                }
            }
        }
        for row in &view.step.contacts[c].rows {
            match force(row) {
                Some(force) => sum = plus(sum, sign, force),
                None => return,
            }
        }
    }
    for &direction in &found.directions {
        let off = dot(direction, minus(found.force, sum)).abs();
        let limit = 10.0 * found.slack + turn * found.magnitude;
        judgement.compare("row sum", off, limit, || places(view, cluster));
    }
}

fn places(view: &View<'_>, cluster: &Cluster) -> String {
    let names = cluster.contacts.iter();
    let names: Vec<&str> = names.map(|&c| &view.touches[c].contact.name[..]).collect();
    let body = &view.problem.bodies[cluster.body].name;
    format!("contacts {} of {body}", names.join(", "))
}

/// The wrench lies in the cone of the points that face something.
fn check_footprint(judgement: &mut Judgement, view: &View<'_>, cluster: &Cluster, found: &Wrench) {
    if found.magnitude <= 1e-3 * view.state.force || found.magnitude <= 1e3 * found.slack {
        return;
    }
    let arm = found.arm.max(f64::MIN_POSITIVE);
    let flat = |force: Vector, moment: Vector| {
        let mut column = [0.0; 6];
        for (k, &direction) in found.directions.iter().enumerate() {
            column[k] = dot(direction, force);
            if found.free() {
                column[3 + k] = dot(direction, moment) / arm;
            }
        }
        column
    };
    let mut columns = Vec::new();
    let mut turn: f64 = 0.0;
    for &c in &cluster.contacts {
        let touch = &view.touches[c];
        let sign = if touch.own == cluster.body { 1.0 } else { -1.0 };
        turn = turn.max(touch.skin.turn);
        let friction = match touch.contact.law {
            Law::Frictionless => touch.skin.turn,
            Law::Coulomb(coefficient) => coefficient + touch.skin.turn,
            // ties pull, and a bound that does not depend on the pressure defines no cone
            _ => return,
        };
        for (x, normal) in touch.facing_points() {
            for edge in cone(times(-1.0, normal), friction, EDGES, true) {
                let force = times(sign, edge);
                columns.push(flat(force, cross(minus(x, found.centre), force)));
            }
        }
    }
    let scale = 1.0 / found.magnitude;
    let target = flat(times(scale, found.force), times(scale, found.moment));
    let off = distance(&columns, target);
    // on a curve, pushes also act between the sampled points
    let limit = OUTSIDE + scale * 10.0 * found.slack + 0.05 * turn * turn + FORCE;
    judgement.compare("footprint", off, limit, || places(view, cluster));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pyramids_lie_inside_and_around_the_cone() {
        let n = [0.0, 0.6, 0.8];
        for k in 0..100 {
            let [a, b] = tangents(n);
            let (s, c) = (0.0628 * f64::from(k)).sin_cos();
            let along = plus(times(c, a), s, b);
            let at = |reach: f64| plus(n, 0.3 * reach, along);
            let off = |around, reach| distance(&cone(n, 0.3, EDGES, around), at(reach));
            assert!(off(true, 1.0) < 1e-14 && off(true, 1.03) > 1e-4);
            assert!(off(false, 0.98) < 1e-14 && off(false, 1.0 + 1e-9) > 1e-12);
        }
    }
}
