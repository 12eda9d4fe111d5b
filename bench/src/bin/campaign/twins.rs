//! Equivalent problems: the answer must be the same.
//!
//! | Twin | What changes | What must agree |
//! |---|---|---|
//! | units | lengths and forces by two factors | everything, 1e-6 |
//! | turned | all of it rotated; meshes from files with rotated nodes | everything, 1e-6 |
//! | order | bodies and contacts in another order | everything, 1e-6 |
//! | split | a rectangle cut in two that are glued node by node | everything, 1e-6 |
//! | sides | nonmortar and mortar swapped | everything where nodes coincide, 1e-6; else the resolution of the mesh |
//!
//! In space one twin is turned, in other units and in another order at once, and may have its sides swapped.
//! "Everything" is the unique part: displacements without the rigid motion of each body that supports leave free, relative to
//! the largest of them. With Coulomb friction answers need not be unique; a difference is reported, but is not a finding.

use crate::carry::Carry;
use crate::check::all_nodal;
use crate::dimension::Dimension;
use crate::plane::rotation;
use crate::problem::{
    Against, Body, Contact, Gap, Law, Load, Pairing, Place, Problem, Shape, Side, Support,
};
use crate::random::Random;
use crate::raw::{Answer, Mesh};
use crate::twin::Twin;
use crate::vector::{axes, minus, random_rotation, unit};

/// A twin with the same bodies.
fn same<const D: usize>(name: &'static str, original: &Problem<D>, problem: Problem<D>) -> Twin<D> {
    Twin {
        name,
        parts: (0..original.bodies.len()).map(|b| vec![b]).collect(),
        problem,
        lengths: 1.0,
        turn: axes(),
        tolerance: 1e-6,
    }
}

/// The problem turned by an angle, its meshes as files. Supports of one axis become rollers where their side looks along that
/// axis; where there are others, the angle is a multiple of 90°.
fn turned(problem: &Problem, answer: &Answer, random: &mut Random) -> Option<Twin<2>> {
    if problem.analysis.axisymmetric() {
        return None;
    }
    let mut plain = problem.clone();
    let mut any_angle = true;
    for (body, mesh) in plain.bodies.iter_mut().zip(&answer.meshes) {
        for support in &mut body.supports {
            any_angle &= as_roller(support, mesh);
        }
    }
    let angle = if any_angle {
        random.between(0.1, 6.0)
    } else {
        plain = problem.clone();
        std::f64::consts::FRAC_PI_2 * random.count(1, 3) as f64
    };
    let carry = Carry::turn(rotation(angle));
    let twin = carry.problem(&plain, Some(&answer.meshes))?;
    Some(Twin {
        turn: carry.turn,
        ..same("turned", problem, twin)
    })
}

/// Turns a support of one axis of a straight side that looks along that axis into a roller; whether it can now be turned.
fn as_roller(support: &mut Support, mesh: &Mesh) -> bool {
    let (axis, value) = match &support.axes {
        [Some(x), None] => (0, x.clone()),
        [None, Some(y)] => (1, y.clone()),
        _ => return true,
    };
    let Place::Side(side) = &support.place else {
        return false;
    };
    let normals = mesh.side(side).map(|facet| {
        let along = minus(mesh.points[facet[1]], mesh.points[facet[0]]);
        unit([along[1], -along[0]])
    });
    let mut sign = 0.0;
    for normal in normals {
        if (normal[axis].abs() - 1.0).abs() > 1e-12 || sign * normal[axis] < 0.0 {
            return false;
        }
        sign = normal[axis].signum();
    }
    support.axes = [None, None];
    support.normal = Some(value.times(sign));
    true
}

/// The bodies and contacts in another order.
fn reordered<const D: usize>(twin: Twin<D>, random: &mut Random) -> Twin<D> {
    let bodies = &twin.problem.bodies;
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    random.shuffle(&mut order);
    let mut problem = twin.problem.clone();
    problem.bodies = order.iter().map(|&b| bodies[b].clone()).collect();
    random.shuffle(&mut problem.contacts);
    let place = |b: usize| order.iter().position(|&o| o == b).unwrap_or(b);
    Twin {
        problem,
        parts: (0..order.len()).map(|b| vec![place(b)]).collect(),
        ..twin
    }
}

/// Nonmortar and mortar sides swapped; whether there are any.
fn swap<const D: usize>(problem: &mut Problem<D>) -> bool {
    let mut any = false;
    for contact in &mut problem.contacts {
        if let Against::Side { side, .. } = &mut contact.against {
            std::mem::swap(&mut contact.own, side);
            any = true;
        }
    }
    any
}

/// A rectangle cut along x or y and glued, where the cut meets no contact side and no patch.
fn split(problem: &Problem, random: &mut Random) -> Option<Twin<2>> {
    let mut candidates = Vec::new();
    for (b, body) in problem.bodies.iter().enumerate() {
        let Shape::Block { cells, .. } = &body.shape else {
            continue;
        };
        for axis in 0..2 {
            // a cut across x meets top and bottom
            let more = &body.more;
            let barred = |other: &Body| {
                let to = other.more.bar.as_ref().and_then(|bar| bar.to.as_ref());
                to.is_some_and(|(name, _)| *name == body.name)
            };
            let plain = more.springs.is_empty()
                && more.initial.is_none()
                && more.bar.is_none()
                // the formulation of the cells depends on yielding: two parts may differ in it
                && more.metal.is_none()
                && !problem.bodies.iter().any(barred)
                && problem.sections.iter().all(|s| s.body != body.name);
            if !plain {
                continue;
            }
            let cut = [["bottom", "top"], ["left", "right"]][axis];
            let free = |side: &&str| !touches(problem, &body.name, side);
            let even = cells[axis] >= 4 || (!body.kind.triangle() && cells[axis] >= 2);
            let forces = body.loads.iter().any(|l| matches!(l, Load::Force { .. }));
            let points = body
                .supports
                .iter()
                .any(|s| matches!(s.place, Place::Point(_)));
            if cut.iter().all(free) && even && body.patches.is_empty() && !forces && !points {
                candidates.push((b, axis));
            }
        }
    }
    if candidates.is_empty() {
        return None;
    }
    let (b, axis) = random.pick(&candidates);
    let body = &problem.bodies[b];
    let Shape::Block {
        from,
        to,
        cells,
        diagonals,
    } = &body.shape
    else {
        return None;
    };
    // an even number of cells in the first part keeps the pattern of the diagonals
    let first = if body.kind.triangle() {
        cells[axis] / 4 * 2
    } else {
        cells[axis] / 2
    };
    let at = from[axis] + (to[axis] - from[axis]) * first as f64 / cells[axis] as f64;
    let part = |low: bool| {
        let (mut from, mut to, mut cells) = (*from, *to, *cells);
        if low {
            (to[axis], cells[axis]) = (at, first);
        } else {
            (from[axis], cells[axis]) = (at, cells[axis] - first);
        }
        let mut half = body.clone();
        half.name = format!("{}_{}", body.name, if low { "a" } else { "b" });
        half.shape = Shape::Block {
            from,
            to,
            cells,
            diagonals,
        };
        // objects beyond the cut belong to the other part
        let gone = [["right", "top"], ["left", "bottom"]][usize::from(!low)][axis];
        half.supports
            .retain(|s| s.place != Place::Side(gone.to_string()));
        half.loads.retain(|load| load.side() != Some(gone));
        half
    };
    let mut twin = problem.clone();
    // the glue is a contact, too
    twin.uniform = None;
    let (low, high) = (part(true), part(false));
    let (names, meet) = (
        [low.name.clone(), high.name.clone()],
        [["right", "left"], ["top", "bottom"]][axis],
    );
    twin.bodies[b] = low;
    twin.bodies.push(high);
    for contact in &mut twin.contacts {
        let rename = |side: &mut Side| {
            if side.body == body.name {
                let low_side = ["left", "bottom"][axis];
                side.body = names[usize::from(side.side != low_side)].clone();
            }
        };
        rename(&mut contact.own);
        if let Against::Side { side, .. } = &mut contact.against {
            rename(side);
        }
    }
    twin.contacts.push(Contact {
        name: "glue".to_string(),
        own: crate::problem::side(&names[0], meet[0]),
        against: Against::Side {
            side: crate::problem::side(&names[1], meet[1]),
            chosen: false,
        },
        pairing: Pairing::Default,
        gap: Gap::Default,
        law: Law::Tied,
    });
    let mut parts: Vec<Vec<usize>> = (0..problem.bodies.len()).map(|b| vec![b]).collect();
    parts[b].push(problem.bodies.len());
    Some(Twin {
        parts,
        ..same("split", problem, twin)
    })
}

fn touches(problem: &Problem, body: &str, name: &str) -> bool {
    let is = |side: &Side| side.body == body && side.side == name;
    problem.contacts.iter().any(|contact| {
        is(&contact.own) || matches!(&contact.against, Against::Side { side, .. } if is(side))
    })
}

/// Some twins of a problem of the plane.
pub fn of_plane(problem: &Problem, answer: &Answer, random: &mut Random) -> Vec<Twin<2>> {
    if let Some(other) = &problem.other {
        return vec![Twin {
            parts: other.parts.clone(),
            tolerance: other.tolerance,
            ..same(other.name, problem, other.problem.clone())
        }];
    }
    let twin = match random.count(0, 4) {
        0 => {
            let forces = random.magnitude(1e-6, 1e6);
            // rounding in the mesh generator depends on the lengths: scaling by powers of two is exact
            let outline = |b: &Body| matches!(b.shape, Shape::Outline { .. } | Shape::Disc { .. });
            let lengths = if problem.bodies.iter().any(outline) {
                2.0f64.powi(random.count(0, 40) as i32 - 20)
            } else {
                random.magnitude(1e-6, 1e6)
            };
            let twin = Carry::units(lengths, forces).problem(problem, None);
            twin.map(|twin| Twin {
                lengths,
                ..same("units", problem, twin)
            })
        }
        1 => turned(problem, answer, random),
        2 => Some(reordered(same("order", problem, problem.clone()), random)),
        3 => split(problem, random),
        _ => {
            let mut twin = problem.clone();
            swap(&mut twin).then(|| same("sides", problem, twin))
        }
    };
    twin.into_iter().collect()
}

/// The twin of a problem of space: turned, in other units, bodies and contacts in another order; or with the two sides of each
/// contact swapped, too.
pub fn of_space(problem: &Problem<3>, answer: &Answer<3>, random: &mut Random) -> Vec<Twin<3>> {
    let carry = Carry {
        turn: random_rotation(random),
        lengths: random.magnitude(1e-3, 1e3),
        forces: random.magnitude(1e-3, 1e3),
        shift: [0.0; 3],
    };
    let Some(carried) = carry.problem(problem, Some(&answer.meshes)) else {
        return Vec::new();
    };
    let mut twin = reordered(same("turned", problem, carried), random);
    (twin.lengths, twin.turn) = (carry.lengths, carry.turn);
    if random.chance(0.3) {
        swap(&mut twin.problem);
        twin.name = "sides";
    }
    vec![twin]
}

/// Whether the answer of this kind of twin must be the same.
pub fn unique<const D: usize>(problem: &Problem<D>, answer: &Answer<D>, twin: &str) -> bool
where
    Problem<D>: Dimension<D>,
{
    // if nothing moves in any step, displacements are only rounding
    if (1..=problem.times.len()).all(|step| problem.idle.contains(&step)) {
        return false;
    }
    // these twins only rewrite the same history
    let same = matches!(twin, "no stage" | "resumed");
    // plastic flow without hardening is not unique
    let mut metals = problem.bodies.iter().filter_map(|b| b.more.metal.as_ref());
    (same || !problem.coulomb())
        && metals.all(|metal| metal.hardening > 0.0)
        && !problem.spins
        && (twin != "sides" || all_nodal(problem, answer))
}
