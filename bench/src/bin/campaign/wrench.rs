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
//! say. On curved sides directions may be off by the angle between facets, because forces act along a field of normals between
//! nodes, and between the points that are looked at: there the cone is widened by that angle.

use crate::amount::vector_at;
use crate::check::View;
use crate::cone::{EDGES, cone, distance};
use crate::judgement::Judgement;
use crate::problem::{Against, Drive, Law};
use crate::rows::force;
use crate::state::FORCE;
use crate::vector::{axes, bounds, cross, dot, length, minus, plus, tangents, times, unit};
use std::collections::{BTreeMap, BTreeSet};

/// Wrenches outside the cone by less than this part of Σ|force|·length count as inside: the ends of the facing part are found
/// to 1e-9 of a facet, and forces are right to 1e-7.
const OUTSIDE: f64 = 1e-6;

/// Contacts that share nodes of a body.
struct Cluster {
    body: usize,
    contacts: Vec<usize>,
    nodes: BTreeSet<usize>,
}

/// The true force on a cluster with its moment about a point, and the tolerance of both.
struct Wrench<const D: usize> {
    force: [f64; D],
    moment: [f64; 3],
    /// Directions in which no node is held: the force is known in these. If all are free, the moment is known, too.
    directions: Vec<[f64; D]>,
    /// Σ|force|.
    magnitude: f64,
    /// Half the extent.
    arm: f64,
    centre: [f64; D],
    slack: f64,
}

fn clusters<const D: usize>(view: &View<'_, D>) -> Vec<Cluster> {
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

fn wrench<const D: usize>(view: &View<'_, D>, cluster: &Cluster) -> Wrench<D> {
    let body = cluster.body;
    let points = &view.answer.meshes[body].points;
    let places: Vec<[f64; D]> = cluster.nodes.iter().map(|&n| points[n]).collect();
    let (low, high) = bounds(&places);
    let held = cluster
        .nodes
        .iter()
        .filter_map(|n| view.state.held[body].get(n));
    // radial forces sum to zero around the axis
    let radial = view.problem.analysis.axisymmetric().then_some(axes()[0]);
    let held = held.flatten().copied().chain(radial);
    // orthonormal: first the held directions, then the others
    let mut basis: Vec<[f64; D]> = Vec::new();
    let mut free = Vec::new();
    let all = held.map(|axis| (axis, false));
    for (axis, is_free) in all.chain(axes().map(|axis| (axis, true))) {
        let rest = basis.iter().fold(axis, |r, &q| plus(r, -dot(r, q), q));
        if length(rest) > 1e-6 {
            let rest = unit(rest);
            basis.push(rest);
            free.extend(is_free.then_some(rest));
        }
    }
    let mut found = Wrench {
        force: [0.0; D],
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

impl<const D: usize> Wrench<D> {
    fn free(&self) -> bool {
        self.directions.len() == D
    }

    /// Compares a force with the reported one, in the directions in which it is known.
    fn compare(
        &self,
        judgement: &mut Judgement,
        what: &'static str,
        told: [f64; D],
        limit: f64,
        place: impl Fn() -> String,
    ) {
        for &direction in &self.directions {
            let off = dot(direction, minus(self.force, told)).abs();
            judgement.compare(what, off, limit, &place);
        }
    }
}

/// All checks of resultants.
pub fn check_wrenches<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    let mut single: BTreeMap<usize, Vec<Wrench<D>>> = BTreeMap::new();
    for cluster in &clusters(view) {
        let found = wrench(view, cluster);
        let place = || places(view, cluster);
        check_sum(judgement, view, cluster, &found);
        check_footprint(judgement, view, cluster, &found);
        if let [c] = cluster.contacts[..] {
            if view.touches[c].own == cluster.body {
                let told = &view.step.contacts[c];
                let limit = 10.0 * found.slack;
                found.compare(judgement, "resultant", told.resultant, limit, place);
                if found.free() {
                    let moment = plus(found.moment, 1.0, cross(found.centre, found.force));
                    let off = length(minus(moment, told.moment));
                    let arm = found.arm + length(found.centre);
                    judgement.compare("resultant", off, limit * arm, place);
                }
            }
            single.entry(c).or_default().push(found);
        }
    }
    for (c, sides) in single {
        let contact = view.touches[c].contact;
        let place = || format!("contact {}", contact.name);
        match (&sides[..], &contact.against) {
            ([own, other], _) => check_reaction(judgement, own, other, place),
            (
                [own],
                Against::Obstacle {
                    drive: Drive::Force(field),
                    ..
                },
            ) => {
                let carried = vector_at(field, [0.0; D], view.step.time);
                own.compare(judgement, "obstacle", carried, 10.0 * own.slack, place);
            }
            _ => {}
        }
    }
}

/// Forces and moments of both sides of a contact sum to zero.
fn check_reaction<const D: usize>(
    judgement: &mut Judgement,
    own: &Wrench<D>,
    other: &Wrench<D>,
    place: impl Fn() -> String,
) {
    let limit = 10.0 * (own.slack + other.slack);
    let sum = plus(own.force, 1.0, other.force);
    // directions known on both sides: free here, without the held directions there
    for &direction in &own.directions {
        let known = |&d: &[f64; D]| dot(d, direction).abs() > 1.0 - 1e-9;
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
fn check_sum<const D: usize>(
    judgement: &mut Judgement,
    view: &View<'_, D>,
    cluster: &Cluster,
    found: &Wrench<D>,
) {
    let (mut sum, mut turn) = ([0.0; D], 0.0f64);
    for &c in &cluster.contacts {
        let touch = &view.touches[c];
        let sign = if touch.own == cluster.body { 1.0 } else { -1.0 };
        if !touch.nodal {
            turn = turn.max(touch.skin.turn);
            if touch.other.is_none() {
                // integrated rows report the side's own normal, not the plane's
                for (&node, samples) in &touch.at_nodes {
                    for sample in samples {
                        let faces = touch.skin.normals_at(node);
                        let off = faces.map(|n| length(minus(sample.normal, n)));
                        turn = turn.max(off.fold(f64::INFINITY, f64::min));
                    }
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
    let limit = 10.0 * found.slack + turn * found.magnitude;
    found.compare(judgement, "row sum", sum, limit, || places(view, cluster));
}

fn places<const D: usize>(view: &View<'_, D>, cluster: &Cluster) -> String {
    let names = cluster.contacts.iter();
    let names: Vec<&str> = names.map(|&c| &view.touches[c].contact.name[..]).collect();
    let body = &view.problem.bodies[cluster.body].name;
    format!("contacts {} of {body}", names.join(", "))
}

/// The wrench lies in the cone of the points that face something.
fn check_footprint<const D: usize>(
    judgement: &mut Judgement,
    view: &View<'_, D>,
    cluster: &Cluster,
    found: &Wrench<D>,
) {
    if found.magnitude <= 1e-3 * view.state.force || found.magnitude <= 1e3 * found.slack {
        return;
    }
    let arm = found.arm.max(f64::MIN_POSITIVE);
    let flat = |force: [f64; D], moment: [f64; 3]| {
        let mut column = [0.0; 6];
        for (k, &direction) in found.directions.iter().enumerate() {
            column[k] = dot(direction, force);
        }
        if found.free() {
            let moment = times(1.0 / arm, moment);
            column[3..].copy_from_slice(&moment);
        }
        column
    };
    let mut columns = Vec::new();
    let mut turn: f64 = 0.0;
    for &c in &cluster.contacts {
        let touch = &view.touches[c];
        // these pull
        if matches!(touch.contact.law, Law::Tied | Law::Joint { .. }) {
            return;
        }
        let sign = if touch.own == cluster.body { 1.0 } else { -1.0 };
        turn = turn.max(touch.skin.turn);
        for (x, normal) in touch.facing_points() {
            for edge in edges(view, c, x, normal) {
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

/// Forces per pushing force that a contact may exert on its own body at a point.
fn edges<const D: usize>(
    view: &View<'_, D>,
    c: usize,
    x: [f64; D],
    normal: [f64; D],
) -> Vec<[f64; D]> {
    let touch = &view.touches[c];
    let (push, turn) = (times(-1.0, normal), touch.skin.turn);
    match &touch.contact.law {
        Law::Coulomb(coefficient) => {
            // a coefficient that varies counts with its largest value within a facet
            let near = axes()
                .into_iter()
                .flat_map(|axis| [1.0, -1.0].map(|sign| plus(x, sign * touch.skin.longest, axis)));
            let all = near.chain([x]);
            let most = all.map(|x| coefficient.at(x, view.step.time));
            cone(push, most.fold(0.0, f64::max) + turn, EDGES, true)
        }
        // a bound that does not depend on the pressure defines no cone: any multiple of the shear is allowed here
        Law::Tresca(_) => {
            let along = tangents(normal).into_iter();
            let shears = along.flat_map(|t| [t, times(-1.0, t)]);
            shears.chain([push]).collect()
        }
        _ => cone(push, turn, EDGES, true),
    }
}
