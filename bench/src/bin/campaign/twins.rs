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
//! "Everything" is the unique part: displacements without the rigid motion of each body that supports leave free, relative to
//! the largest of them. With Coulomb friction answers need not be unique; a difference is reported, but is not a finding.

use crate::amount::carried_vector;
use crate::cells::Kind;
use crate::elastic::conditions;
use crate::held::held_axes;
use crate::plane::{Vector, cross, length, minus, rotated, rotation, times};
use crate::problem::{
    Against, Body, Circle, Contact, Drive, Gap, Law, Load, Place, Problem, Shape, Side, Support,
    Surface,
};
use crate::random::Random;
use crate::raw::{Answer, Mesh};

/// A twin of a problem of the plane.
type Twin = crate::twin::Twin<Problem, 2>;

/// A problem in other units and turned by an angle about the origin; `None` if the mesh generator cannot turn a body.
pub fn carried(problem: &Problem, lengths: f64, forces: f64, angle: f64) -> Option<Problem> {
    let stress = forces / (lengths * lengths);
    let place = |x: Vector| times(lengths, rotated(x, angle));
    let mut twin = problem.clone();
    twin.uniform = problem
        .uniform
        .as_ref()
        .map(|p| p.carried(stress, lengths, angle));
    if let Some(other) = &mut twin.other {
        other.problem = carried(&other.problem, lengths, forces, angle)?;
    }
    // the mesh of a region depends on rounding where distances between points are equal
    if twin.drawing.is_some() || (angle != 0.0 && !twin.sections.is_empty()) {
        return None;
    }
    for section in &mut twin.sections {
        section.stations.iter_mut().for_each(|x| *x = place(*x));
    }
    for body in &mut twin.bodies {
        body.young *= stress;
        for spring in &mut body.more.springs {
            spring.normal *= stress / lengths;
            spring.tangential *= stress / lengths;
        }
        if let Some(couple) = &mut body.more.couple {
            couple.point = place(couple.point);
            couple.area *= lengths * lengths;
        }
        if let Some(bar) = &mut body.more.bar {
            if angle != 0.0 {
                return None;
            }
            (bar.at, bar.stiffness) = (place(bar.at), bar.stiffness * stress * lengths);
            let forces = stress * lengths * lengths;
            if let Some(most) = bar.gives.as_mut().and_then(|gives| gives.most.as_mut()) {
                *most *= forces;
            }
            bar.to = bar.to.take().map(|(body, to)| (body, place(to)));
        }
        if let Some(metal) = &mut body.more.metal {
            (metal.yields, metal.hardening) = (metal.yields * stress, metal.hardening * stress);
        }
        if let Some(beyond) = &mut body.more.beyond {
            (beyond.border, beyond.young) = (beyond.border * lengths, beyond.young * stress);
        }
        if let Some(initial) = &mut body.more.initial {
            // the components would have to be turned, too
            if angle != 0.0 {
                return None;
            }
            for component in initial {
                *component = component.carried(stress, lengths, angle);
            }
        }
        if !problem.analysis.axisymmetric() {
            body.thickness *= lengths;
        }
        body.weight = carried_vector(&body.weight, stress / lengths, lengths, angle);
        let supports = body
            .supports
            .iter()
            .map(|s| carried_support(s, lengths, angle));
        body.supports = supports.collect::<Option<_>>()?;
        for load in &mut body.loads {
            match load {
                Load::Traction { field, .. } => {
                    *field = carried_vector(field, stress, lengths, angle);
                }
                Load::Pressure { field, .. } => *field = field.carried(stress, lengths, angle),
                Load::InSitu { factor, .. } => *factor = factor.carried(1.0, lengths, angle),
                Load::Force { point, field } => {
                    *point = place(*point);
                    *field = carried_vector(field, forces, lengths, angle);
                }
            }
        }
        for circle in &mut body.circles {
            *circle = Circle {
                side: circle.side.clone(),
                center: place(circle.center),
                radius: circle.radius * lengths,
            };
        }
        carry_shape(body, lengths, angle)?;
    }
    for contact in &mut twin.contacts {
        if let Gap::Given(gap) = &mut contact.gap {
            *gap = gap.carried(lengths, lengths, angle);
        }
        match &mut contact.law {
            Law::Tresca(bound) => *bound = bound.carried(stress, lengths, angle),
            Law::Coulomb(coefficient) => *coefficient = coefficient.carried(1.0, lengths, angle),
            Law::Joint {
                cohesion, tension, ..
            } => (*cohesion, *tension) = (*cohesion * stress, *tension * stress),
            _ => {}
        }
        if let Against::Obstacle { surface, drive } = &mut contact.against {
            match surface {
                Surface::Gap(gap) => *gap = gap.carried(lengths, lengths, angle),
                Surface::Plane { point, normal } => {
                    (*point, *normal) = (place(*point), rotated(*normal, angle));
                }
                Surface::Circle { center, radius, .. } => {
                    (*center, *radius) = (place(*center), *radius * lengths);
                }
            }
            match drive {
                Drive::Nothing => {}
                Drive::Displacement(field) => {
                    *field = carried_vector(field, lengths, lengths, angle);
                }
                Drive::Force(field) => *field = carried_vector(field, forces, lengths, angle),
            }
        }
    }
    Some(twin)
}

/// A support in the turned problem; one axis alone can only be turned onto another axis.
fn carried_support(support: &Support, lengths: f64, angle: f64) -> Option<Support> {
    let place = match &support.place {
        Place::Side(side) => Place::Side(side.clone()),
        Place::Point(x) => Place::Point(times(lengths, rotated(*x, angle))),
    };
    let normal = support
        .normal
        .as_ref()
        .map(|n| n.carried(lengths, lengths, angle));
    let axes = match &support.axes {
        [None, None] => [None, None],
        [Some(x), Some(y)] => {
            carried_vector(&[x.clone(), y.clone()], lengths, lengths, angle).map(Some)
        }
        one => {
            let (axis, value) = match one {
                [Some(x), _] => (0, x),
                [_, Some(y)] => (1, y),
                _ => return None,
            };
            let direction = rotated([[1.0, 0.0], [0.0, 1.0]][axis], angle);
            let place = direction.iter().position(|c| c.abs() == 1.0)?;
            let mut axes = [None, None];
            axes[place] = Some(value.carried(lengths * direction[place], lengths, angle));
            axes
        }
    };
    Some(Support {
        place,
        axes,
        normal,
        from: support.from,
    })
}

fn carry_shape(body: &mut Body, lengths: f64, angle: f64) -> Option<()> {
    let place = |x: Vector| times(lengths, rotated(x, angle));
    let straight = angle == 0.0;
    for patch in &mut body.patches {
        if !straight {
            return None;
        }
        (patch.low, patch.high) = (place(patch.low), place(patch.high));
    }
    match &mut body.shape {
        Shape::Rectangle { from, to, .. } => {
            if !straight {
                return None;
            }
            (*from, *to) = (place(*from), place(*to));
        }
        Shape::Ring {
            center,
            radii,
            angles,
            ..
        } => {
            *center = place(*center);
            *radii = radii.map(|r| r * lengths);
            if !straight {
                if angles.is_none() {
                    return None;
                }
                *angles = angles.map(|a| a.map(|a| a + angle.to_degrees()));
            }
        }
        Shape::Outline { size, from, edges } => {
            (*size, *from) = (*size * lengths, place(*from));
            for edge in edges {
                edge.to = place(edge.to);
                edge.center = edge.center.map(place);
            }
        }
        Shape::Disc {
            size,
            center,
            radius,
            ..
        } => {
            if !straight {
                return None;
            }
            (*size, *center, *radius) = (*size * lengths, place(*center), *radius * lengths);
        }
        Shape::File { .. } => return None,
        Shape::Region(_) if straight => {}
        Shape::Region(_) => return None,
    }
    Some(())
}

/// The problem turned by an angle, its meshes as files. Supports of one axis become rollers where their side looks along that
/// axis; where there are others, the angle is a multiple of 90°.
fn turned(problem: &Problem, answer: &Answer, random: &mut Random) -> Option<Twin> {
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
    for (body, mesh) in plain.bodies.iter_mut().zip(&answer.meshes) {
        body.patches.clear();
        body.shape = Shape::Outline {
            size: 1.0,
            from: [0.0; 2],
            edges: Vec::new(),
        };
        let _ = mesh;
    }
    let mut twin = carried(&plain, 1.0, 1.0, angle)?;
    for (body, mesh) in twin.bodies.iter_mut().zip(&answer.meshes) {
        body.shape = Shape::File {
            name: format!("{}.msh", body.name),
            text: gmsh(mesh, angle),
        };
    }
    Some(Twin {
        name: "turned",
        parts: (0..problem.bodies.len()).map(|b| vec![b]).collect(),
        problem: twin,
        lengths: 1.0,
        turn: rotation(angle),
        tolerance: 1e-6,
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
    let normals = mesh.sides[side].iter().map(|facet| {
        let along = minus(mesh.points[facet[1]], mesh.points[facet[0]]);
        crate::plane::unit([along[1], -along[0]])
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

/// A mesh file, its nodes turned.
pub fn gmsh(mesh: &Mesh, angle: f64) -> String {
    let points: Vec<[f64; 3]> = mesh
        .points
        .iter()
        .map(|&x| {
            let [x, y] = rotated(x, angle);
            [x, y, 0.0]
        })
        .collect();
    let cell = |(kind, nodes): &(Kind, Vec<usize>)| (kind.gmsh(), nodes.clone());
    let cells: Vec<_> = mesh.cells.iter().map(cell).collect();
    let facet = |nodes: &Vec<usize>| (if nodes.len() == 2 { 1 } else { 8 }, nodes.clone());
    let side = |(name, facets): (&String, &Vec<Vec<usize>>)| {
        (name.clone(), facets.iter().map(facet).collect())
    };
    crate::gmsh::text(2, &points, &cells, &mesh.sides.iter().map(side).collect())
}

/// The bodies and contacts in another order.
fn reordered(problem: &Problem, random: &mut Random) -> Twin {
    let mut order: Vec<usize> = (0..problem.bodies.len()).collect();
    random.shuffle(&mut order);
    let mut twin = problem.clone();
    twin.bodies = order.iter().map(|&b| problem.bodies[b].clone()).collect();
    random.shuffle(&mut twin.contacts);
    let place = |b: usize| order.iter().position(|&o| o == b).unwrap_or(b);
    Twin {
        name: "order",
        parts: (0..order.len()).map(|b| vec![place(b)]).collect(),
        problem: twin,
        lengths: 1.0,
        turn: rotation(0.0),
        tolerance: 1e-6,
    }
}

/// Nonmortar and mortar sides swapped.
fn swapped(problem: &Problem) -> Option<Twin> {
    let mut twin = problem.clone();
    let mut any = false;
    for contact in &mut twin.contacts {
        if let Against::Side { side, .. } = &mut contact.against {
            std::mem::swap(&mut contact.own, side);
            any = true;
        }
    }
    any.then(|| Twin {
        name: "sides",
        parts: (0..problem.bodies.len()).map(|b| vec![b]).collect(),
        problem: twin,
        lengths: 1.0,
        turn: rotation(0.0),
        tolerance: 1e-6,
    })
}

/// A rectangle cut along x or y and glued, where the cut meets no contact side and no patch.
fn split(problem: &Problem, random: &mut Random) -> Option<Twin> {
    let mut candidates = Vec::new();
    for (b, body) in problem.bodies.iter().enumerate() {
        let Shape::Rectangle { cells, .. } = &body.shape else {
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
    let Shape::Rectangle {
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
        half.shape = Shape::Rectangle {
            from,
            to,
            cells,
            diagonals,
        };
        // objects beyond the cut belong to the other part
        let gone = [["right", "top"], ["left", "bottom"]][usize::from(!low)][axis];
        half.supports
            .retain(|s| s.place != Place::Side(gone.to_string()));
        half.loads.retain(|load| match load {
            Load::Traction { side, .. } | Load::Pressure { side, .. } => side != gone,
            Load::InSitu { side, .. } => side != gone,
            Load::Force { .. } => true,
        });
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
        pairing: crate::problem::Pairing::Default,
        gap: Gap::Default,
        law: Law::Tied,
    });
    let mut parts: Vec<Vec<usize>> = (0..problem.bodies.len()).map(|b| vec![b]).collect();
    parts[b].push(problem.bodies.len());
    Some(Twin {
        name: "split",
        problem: twin,
        lengths: 1.0,
        turn: rotation(0.0),
        parts,
        tolerance: 1e-6,
    })
}

fn touches(problem: &Problem, body: &str, name: &str) -> bool {
    let is = |side: &Side| side.body == body && side.side == name;
    problem.contacts.iter().any(|contact| {
        is(&contact.own) || matches!(&contact.against, Against::Side { side, .. } if is(side))
    })
}

/// Some twins of a problem.
pub fn twins(problem: &Problem, answer: &Answer, random: &mut Random) -> Vec<Twin> {
    let mut all = Vec::new();
    if let Some(other) = &problem.other {
        all.push(Twin {
            name: other.name,
            problem: other.problem.clone(),
            lengths: 1.0,
            turn: rotation(0.0),
            parts: other.parts.clone(),
            tolerance: other.tolerance,
        });
        return all;
    }
    match random.count(0, 4) {
        0 => {
            let forces = random.magnitude(1e-6, 1e6);
            // rounding in the mesh generator depends on the lengths: scaling by powers of two is exact
            let outline = |b: &Body| matches!(b.shape, Shape::Outline { .. } | Shape::Disc { .. });
            let lengths = if problem.bodies.iter().any(outline) {
                2.0f64.powi(random.count(0, 40) as i32 - 20)
            } else {
                random.magnitude(1e-6, 1e6)
            };
            all.extend(carried(problem, lengths, forces, 0.0).map(|twin| Twin {
                name: "units",
                problem: twin,
                lengths,
                turn: rotation(0.0),
                parts: (0..problem.bodies.len()).map(|b| vec![b]).collect(),
                tolerance: 1e-6,
            }));
        }
        1 => all.extend(turned(problem, answer, random)),
        2 => all.push(reordered(problem, random)),
        3 => all.extend(split(problem, random)),
        _ => all.extend(swapped(problem)),
    }
    all
}

/// Supports alone leave a body no rigid motion.
pub fn fully_held(problem: &Problem, body: usize, mesh: &Mesh) -> bool {
    let axes = held_axes(&conditions(
        mesh,
        &problem.bodies[body],
        problem.analysis,
        problem.times[0],
    ));
    if problem.analysis.axisymmetric() {
        return axes.values().flatten().any(|a| a[1].abs() > 0.5);
    }
    // rows (axis, moment of the axis): three independent ones
    let mut basis: Vec<[f64; 3]> = Vec::new();
    let (low, high) = crate::plane::bounds(&mesh.points);
    let (middle, size) = (
        times(0.5, crate::plane::plus(low, 1.0, high)),
        length(minus(high, low)),
    );
    for (&node, held) in &axes {
        for &axis in held {
            let arm = times(1.0 / size, minus(mesh.points[node], middle));
            let mut row = [axis[0], axis[1], cross(arm, axis)];
            for q in &basis {
                let part: f64 = q.iter().zip(&row).map(|(a, b)| a * b).sum();
                row.iter_mut().zip(q).for_each(|(r, q)| *r -= part * q);
            }
            let norm = row.iter().map(|r| r * r).sum::<f64>().sqrt();
            if norm > 1e-6 {
                basis.push(row.map(|r| r / norm));
            }
        }
    }
    basis.len() == 3
}
