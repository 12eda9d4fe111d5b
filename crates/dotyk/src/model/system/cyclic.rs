//! Cyclic symmetry as a condition: the two faces of a sector move alike, but for the turn R from one to the other.
//!
//! ```text
//!   d·(u(R x) − R u(x)) = 0      a row for each direction d:  d at R x,  −Rᵀd at x
//! ```
//!
//! Where the nodes of the two faces lie on each other after the turn a row is that of a pair of nodes, on the axis of a single node; else
//! it is a mean over the faces, as that of a tied contact with the turned body. Forces of the rows are those between neighbouring sectors.

use crate::contact::{
    Against, ContactError, Coupling, End, InitialGap, Interface, InterfaceNode, Role, Row, frame,
    pair_mortar,
};
use crate::fem::{AGREE, Body, Constraints, Cyclic, FemError, Held, Short, Turn, show};
use crate::fem::{SAME, coincident, largest_facet, placed, spans};
use crate::geometry::{Point, add_scaled, distance, dot, norm, sub, unit};
use crate::mesh::Mesh;
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::{Analysis, Model};
use crate::model::system::condition::{Condition, Source};
use crate::model::system::face::Face;
use crate::model::system::links::{axis, carrier};
use crate::model::system::parts::Owner;
use std::sync::Arc;

/// Faces are the same after the turn if their areas and centroids differ by less than this part: meshes of a curved face may differ.
const ALIKE: f64 = 1e-2;

/// A row of a single node vanishes below this part of its direction: the node lies on the axis, along which it moves as it will.
const VANISHES: f64 = 1e-9;

/// The condition of a body that is a sector.
///
/// Errors: faces that are unknown, or not the same after the turn; those of [`check_faces`].
pub(crate) fn repeated<const D: usize>(
    model: &Model<D>,
    constraints: &Constraints<D>,
    of: usize,
    cyclic: &Cyclic<D>,
) -> Result<Condition<D>, Error<D>> {
    let body = &model.bodies[of];
    let fail = |source| Error::in_body(body, source);
    let turn = turn(body, cyclic, model.analysis).map_err(fail)?;
    let mut from = placed(&body.mesh, &cyclic.from);
    for (_, place) in &mut from {
        *place = turn.place(*place);
    }
    let to = placed(&body.mesh, &cyclic.to);
    let within = SAME * largest_facet(&body.mesh, &cyclic.to);
    let interface = match coincident([&to, &from], within) {
        Ok(pairs) => of_pairs(&pairs, constraints, &turn),
        Err(_) => of_means(model, (body, constraints), cyclic, &turn).map_err(fail)?,
    };
    check_faces(body, cyclic, constraints, &interface).map_err(fail)?;
    let side = SideRef {
        body: BodyId(of),
        side: cyclic.to.clone(),
    };
    let source = Source::Of(Owner::Body(of));
    let name = format!("cyclic symmetry of {}", body.name);
    Ok(Condition::new(source, name, side, interface))
}

/// The turn that takes one face of a sector to the other.
///
/// Errors: a number of sectors below 2, an axis without direction; faces that are unknown, or whose areas or centroids differ.
pub(crate) fn turn<const D: usize>(
    body: &Body<D>,
    cyclic: &Cyclic<D>,
    analysis: Analysis,
) -> Result<Turn<D>, FemError> {
    let [from, to] = [&cyclic.from, &cyclic.to].map(|side| Face::of(body, side, analysis));
    let (from, to) = (from?, to?);
    let turns = [true, false].map(|right_handed| cyclic.turn(right_handed));
    let [Some(one), Some(other)] = turns else {
        return Err(cyclic.unlike("no axis: `axis` needs a direction, and `sectors` 2 or more"));
    };
    let off = |turn: &Turn<D>| distance(turn.place(from.centre), to.centre);
    let turn = if off(&other) < off(&one) { other } else { one };
    let length = body.mesh.diameter();
    if off(&turn) > ALIKE * length {
        return Err(cyclic.unlike(&format!(
            "its centroid comes to {}, and that of `{}` is {}",
            show(turn.place(from.centre)),
            cyclic.to,
            show(to.centre)
        )));
    }
    if (from.area - to.area).abs() > ALIKE * to.area {
        return Err(cyclic.unlike(&format!(
            "its size is {}, and that of `{}` is {}",
            Short(from.area),
            cyclic.to,
            Short(to.area)
        )));
    }
    Ok(turn)
}

/// The sector beside a body, with its facets alone, because ties do not ask for true surfaces, and its held directions.
///
/// Errors: cells that rounding has folded.
fn turned<const D: usize>(
    body: &Body<D>,
    (cyclic, constraints): (&Cyclic<D>, &Constraints<D>),
    turn: &Turn<D>,
) -> Result<(Body<D>, Constraints<D>), FemError> {
    let mesh = Mesh::clone(&body.mesh).map_points(|x| turn.place(x));
    let mesh = mesh.map_err(|error| cyclic.unlike(&error.to_string()))?;
    let nodes = constraints.nodes.iter().map(|(&node, held)| {
        let turned = held.iter().map(|held| Held {
            axis: turn.vector(held.axis),
            ..held.clone()
        });
        (node, turned.collect())
    });
    let nodes = nodes.collect();
    let body = Body::of(&body.name, Arc::new(mesh));
    Ok((body, Constraints { nodes }))
}

/// Errors: supports of the two faces that hold a node and the one that it comes to in ways that no turn takes to each other.
pub(crate) fn check_faces<const D: usize>(
    body: &Body<D>,
    cyclic: &Cyclic<D>,
    constraints: &Constraints<D>,
    interface: &Interface<D>,
) -> Result<(), FemError> {
    for implied in &interface.implied {
        let (mut sum, mut terms, mut known) = (0.0, 0.0, true);
        for &(node, c) in implied.rows.iter().flatten() {
            let held = constraints.at(node);
            known &= unit(c).is_some_and(|c| spans(held.iter().map(|held| held.axis), c));
            for held in held {
                sum += dot(c, held.axis) * held.value;
                terms += dot(c, held.axis).abs() * held.terms;
            }
        }
        if known && sum.abs() > AGREE * terms {
            let node = interface.nodes[implied.node].node;
            return Err(FemError::HeldApart {
                from: cyclic.from.clone(),
                to: cyclic.to.clone(),
                point: show(body.mesh.points()[node]),
                off: sum.abs(),
            });
        }
    }
    Ok(())
}

/// Rows of pairs of nodes: one of the face `to`, and one of `from` that lies there after the turn.
fn of_pairs<const D: usize>(
    pairs: &[[usize; 2]],
    constraints: &Constraints<D>,
    turn: &Turn<D>,
) -> Interface<D> {
    let mut interface = Interface::empty(Coupling::Tied);
    let mut held_rows = Vec::new();
    for &[own, other] in pairs {
        let axes = |node: usize| constraints.at(node).iter().map(|held| held.axis);
        let beside: Vec<Point<D>> = axes(other).map(|axis| turn.vector(axis)).collect();
        let held = [axes(own).collect(), beside];
        let given = held.iter().max_by_key(|held| held.len());
        let given = given.map_or(&[][..], |held| held);
        let axes = match given.split_first() {
            Some((&first, further)) => frame(first, further),
            None => std::array::from_fn(axis),
        };
        let mut rows = [None; D];
        for (row, &axis) in rows.iter_mut().zip(&axes) {
            let back = turn.back(axis);
            let entries = match own == other {
                true => vec![(own, sub(axis, back))],
                false => vec![(own, axis), (other, back.map(|c| -c))],
            };
            if norm(entries[0].1) < VANISHES {
                continue;
            }
            let held = held.iter().all(|held| spans(held.iter().copied(), axis));
            held_rows.extend(held.then_some(interface.nonmortar.len()));
            *row = Some(interface.nonmortar.len());
            interface.nonmortar.push(entries);
            interface.mortar.push(Row::new());
        }
        interface.nodes.push(InterfaceNode {
            node: own,
            frame: axes,
            rows,
            ..carrier(0)
        });
    }
    interface.drop_rows(&held_rows);
    interface
}

/// Rows of means over the faces: those of a tied contact with the turned body.
///
/// Errors: faces that do not lie on each other after the turn.
fn of_means<const D: usize>(
    model: &Model<D>,
    (body, constraints): (&Body<D>, &Constraints<D>),
    cyclic: &Cyclic<D>,
    turn: &Turn<D>,
) -> Result<Interface<D>, FemError> {
    let (beside, held) = turned(body, (cyclic, constraints), turn)?;
    let end = |body, side, constraints| End {
        body,
        side,
        constraints,
        part: None,
    };
    let to = end(body, &cyclic.to, constraints);
    let from = end(&beside, &cyclic.from, &held);
    let paired = pair_mortar(
        to,
        Against::Side(from),
        InitialGap::Measured,
        Coupling::Tied,
        model.analysis,
        0.0,
    );
    let mut interface = paired.map_err(|error: ContactError| cyclic.unlike(&error.to_string()))?;
    let room = ALIKE * largest_facet(&body.mesh, &cyclic.to);
    let away = |node: &&InterfaceNode<D>| {
        node.role == Role::Alone || node.clearance.is_nan() || node.clearance.abs() > room
    };
    if let Some(node) = interface.nodes.iter().find(away) {
        return Err(cyclic.unlike(&format!(
            "`{}` has a node at {} that it does not reach",
            cyclic.to,
            show(body.mesh.points()[node.node])
        )));
    }
    interface.close();
    for (own, beyond) in interface.nonmortar.iter_mut().zip(&mut interface.mortar) {
        for (node, c) in std::mem::take(beyond) {
            let back = turn.back(c);
            match own.iter_mut().find(|entry| entry.0 == node) {
                Some((_, sum)) => *sum = add_scaled(*sum, 1.0, back),
                None => own.push((node, back)),
            }
        }
    }
    Ok(interface)
}
