//! Resultants and moments of contacts: are both sides in balance, and could pushes at points that face the other side have these
//! resultants?
//!
//! Contacts that share nodes of a body form a cluster there: the true forces are known of the cluster. The wrench
//! (force, moment about the middle of the cluster) must lie in the cone of wrenches
//!
//! ```text
//!   (f, (x − c) × f),    f = −n ± μt at points x that face the other side, n the contact normal
//! ```
//!
//! (with the opposite sign on the other body). A block whose load tips it over its edge, or slides it, fails here whatever
//! rows say. On curved sides directions may be off by the angle between facets, because forces act along a field of normals
//! between nodes; there the cone is widened by that angle.

use crate::check::View;
use crate::cone::distance;
use crate::judgement::Judgement;
use crate::plane::{Vector, cross, dot, length, minus, plus, rotated, times, turned};
use crate::problem::{Against, Drive, Law};
use crate::rows::force;
use crate::state::FORCE;
use std::collections::{BTreeMap, BTreeSet};

/// Wrenches outside the cone by less than this part of Σ|force|·length are inside: the ends of the facing part are found
/// to 1e-9 of a facet, and forces are right to 1e-7.
const OUTSIDE: f64 = 1e-6;

/// Contacts that share nodes of a body.
struct Cluster {
    body: usize,
    contacts: Vec<usize>,
    nodes: BTreeSet<usize>,
}

/// The true force on a cluster with its moment about a point, and the tolerance of both.
struct Wrench {
    force: Vector,
    moment: f64,
    /// Directions in which no node is held: the force is known in these.
    directions: Vec<Vector>,
    /// No node is held: the moment is known, too.
    free: bool,
    /// Σ|force|.
    magnitude: f64,
    /// Half the extent.
    arm: f64,
    centre: Vector,
    slack: f64,
}

fn clusters(view: &View<'_>) -> Vec<Cluster> {
    let mut all: Vec<Cluster> = Vec::new();
    for (c, touch) in view.touches.iter().enumerate() {
        let sides = [
            (Some(touch.own), Some(&touch.curve)),
            (touch.other, touch.opposite.as_ref()),
        ];
        for (body, curve) in sides {
            let (Some(body), Some(curve)) = (body, curve) else {
                continue;
            };
            let mut cluster = Cluster {
                body,
                contacts: vec![c],
                nodes: curve.around.keys().copied().collect(),
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

/// The wrench of the true forces on a cluster; `None` where supports hold nodes in both directions.
fn wrench(view: &View<'_>, cluster: &Cluster) -> Option<Wrench> {
    let body = cluster.body;
    let points = &view.answer.meshes[body].points;
    let places: Vec<Vector> = cluster.nodes.iter().map(|&n| points[n]).collect();
    let (low, high) = crate::plane::bounds(&places);
    let centre = times(0.5, plus(low, 1.0, high));
    let mut held: Vec<Vector> = Vec::new();
    for node in &cluster.nodes {
        for &axis in view.state.held[body].get(node).into_iter().flatten() {
            if held.iter().all(|&h| cross(h, axis).abs() > 1e-9) {
                held.push(axis);
            }
        }
    }
    // radial forces sum to zero around the axis
    let radial = [1.0, 0.0];
    if view.problem.analysis.axisymmetric() && held.iter().all(|&h| cross(h, radial).abs() > 1e-9) {
        held.push(radial);
    }
    let mut found = Wrench {
        force: [0.0; 2],
        moment: 0.0,
        directions: match held[..] {
            [] => vec![[1.0, 0.0], [0.0, 1.0]],
            [axis] => vec![turned(axis)],
            _ => return None,
        },
        free: held.is_empty(),
        magnitude: 0.0,
        arm: 0.5 * length(minus(high, low)),
        centre,
        slack: 0.0,
    };
    for &node in &cluster.nodes {
        let force = view.state.rest[body][node];
        found.force = plus(found.force, 1.0, force);
        found.moment += cross(minus(points[node], centre), force);
        found.magnitude += length(view.state.free(body, node, force));
        found.slack += view.state.limits[body][node];
    }
    Some(found)
}

/// All checks of resultants.
pub fn check_wrenches(judgement: &mut Judgement, view: &View<'_>) {
    let mut single: BTreeMap<usize, Vec<Wrench>> = BTreeMap::new();
    for cluster in &clusters(view) {
        let Some(found) = wrench(view, cluster) else {
            continue;
        };
        check_sum(judgement, view, cluster, &found);
        check_footprint(judgement, view, cluster, &found);
        if let [c] = cluster.contacts[..] {
            if view.touches[c].own == cluster.body {
                let told = view.step.contacts[c].resultant;
                compare_forces(judgement, "resultant", &found, told, || {
                    places(view, cluster)
                });
            }
            single.entry(c).or_default().push(found);
        }
    }
    for (c, sides) in single {
        match &sides[..] {
            [own, other] => check_reaction(judgement, view, c, own, other),
            [own] => check_obstacle(judgement, view, c, own),
            _ => {}
        }
    }
}

/// Compares a force with the reported one, in the directions in which it is known.
fn compare_forces(
    judgement: &mut Judgement,
    what: &'static str,
    found: &Wrench,
    told: Vector,
    place: impl Fn() -> String,
) {
    for &direction in &found.directions {
        let off = dot(direction, minus(found.force, told)).abs();
        judgement.compare(what, off, 10.0 * found.slack, &place);
    }
}

/// Forces and moments of both sides of a contact sum to zero.
fn check_reaction(
    judgement: &mut Judgement,
    view: &View<'_>,
    c: usize,
    own: &Wrench,
    other: &Wrench,
) {
    let place = || format!("contact {}", view.touches[c].contact.name);
    let limit = 10.0 * (own.slack + other.slack);
    let sum = plus(own.force, 1.0, other.force);
    let known = |d: &&Vector| other.directions.iter().any(|e| cross(**d, *e).abs() < 1e-9);
    for &direction in own.directions.iter().filter(known) {
        judgement.compare("act and react", dot(direction, sum).abs(), limit, place);
    }
    if own.free && other.free {
        let moved = other.moment + cross(minus(other.centre, own.centre), other.force);
        let arm = own.arm.max(other.arm);
        judgement.compare(
            "act and react",
            (own.moment + moved).abs(),
            limit * arm,
            place,
        );
    }
}

/// The resultant of the rows of all contacts of a cluster is that of the forces.
fn check_sum(judgement: &mut Judgement, view: &View<'_>, cluster: &Cluster, found: &Wrench) {
    let (mut sum, mut turn) = ([0.0; 2], 0.0f64);
    for &c in &cluster.contacts {
        let touch = &view.touches[c];
        let sign = if touch.own == cluster.body { 1.0 } else { -1.0 };
        if !touch.nodal {
            turn = turn.max(touch.curve.turn);
            // at a corner a row stands for two directions; an integrated row against a plane reports another direction than that of its push
            let plane = touch.other.is_none() && !touch.curve.straight();
            if touch.curve.corners || plane {
                return;
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
    for &direction in &found.directions {
        let off = dot(direction, minus(found.force, sum)).abs();
        judgement.compare("row sum", off, limit, || places(view, cluster));
    }
}

fn places(view: &View<'_>, cluster: &Cluster) -> String {
    let names: Vec<&str> = cluster
        .contacts
        .iter()
        .map(|&c| view.touches[c].contact.name.as_str())
        .collect();
    format!(
        "contacts {} of {}",
        names.join(", "),
        view.problem.bodies[cluster.body].name
    )
}

/// The wrench lies in the cone of the points that face something.
fn check_footprint(judgement: &mut Judgement, view: &View<'_>, cluster: &Cluster, found: &Wrench) {
    if found.magnitude <= 1e-3 * view.state.force || found.magnitude <= 1e3 * found.slack {
        return;
    }
    let mut columns: Vec<[f64; 3]> = Vec::new();
    let mut turn: f64 = 0.0;
    let arm = found.arm.max(f64::MIN_POSITIVE);
    let flat = |force: Vector, moment: f64| {
        let along = |k: usize| found.directions.get(k).map_or(0.0, |&d| dot(d, force));
        let moment = if found.free { moment / arm } else { 0.0 };
        [along(0), along(1), moment]
    };
    for &c in &cluster.contacts {
        let touch = &view.touches[c];
        if matches!(touch.contact.law, Law::Tied | Law::Joint { .. }) {
            return;
        }
        turn = turn.max(touch.curve.turn);
        let sign = if touch.own == cluster.body { 1.0 } else { -1.0 };
        for (x, normal) in touch.facing_points() {
            for force in edges(view, c, x, normal) {
                let force = times(sign, force);
                let moment = cross(minus(x, found.centre), force);
                columns.push(flat(force, moment));
            }
        }
    }
    let scale = 1.0 / found.magnitude;
    let target = flat(times(scale, found.force), scale * found.moment);
    let off = distance(&columns, target);
    // on a curve, pushes also act between the sampled points
    let limit = OUTSIDE + scale * 10.0 * found.slack + 0.05 * turn * turn + FORCE;
    judgement.compare("footprint", off, limit, || places(view, cluster));
}

/// Forces per pushing force that a contact may exert on its own body at a point.
fn edges(view: &View<'_>, c: usize, x: Vector, normal: Vector) -> Vec<Vector> {
    let touch = &view.touches[c];
    let push = times(-1.0, normal);
    let mut pushes = vec![push];
    if !touch.curve.straight() {
        pushes.push(rotated(push, touch.curve.turn));
        pushes.push(rotated(push, -touch.curve.turn));
    }
    let along = turned(normal);
    match &touch.contact.law {
        Law::Coulomb(coefficient) => {
            // a coefficient that varies counts with its largest value within a facet
            let mu = coefficient.at(x, view.step.time);
            let near = touch.curve.longest;
            let around = [[near, 0.0], [-near, 0.0], [0.0, near], [0.0, -near]];
            let mu = around
                .iter()
                .map(|&d| coefficient.at(plus(x, 1.0, d), view.step.time))
                .fold(mu, f64::max);
            pushes
                .into_iter()
                .flat_map(|p| [plus(p, mu, along), plus(p, -mu, along)])
                .collect()
        }
        // a bound that does not depend on the pressure defines no cone: any multiple of the shear is allowed here
        Law::Tresca(_) => {
            pushes.push(along);
            pushes.push(times(-1.0, along));
            pushes
        }
        _ => pushes,
    }
}

/// Forces on a free obstacle balance.
fn check_obstacle(judgement: &mut Judgement, view: &View<'_>, c: usize, found: &Wrench) {
    let touch = &view.touches[c];
    if let Against::Obstacle {
        drive: Drive::Force(field),
        ..
    } = &touch.contact.against
    {
        let carried = crate::amount::vector_at(field, [0.0; 2], view.step.time);
        let place = || format!("contact {}", touch.contact.name);
        compare_forces(judgement, "obstacle", found, carried, place);
    }
}
