//! Couples as conditions: rows between a side and a point, which is a part.

use crate::contact::{End, Interface, Row, pair_couple};
use crate::fem::{AGREE, Constraints, CoupleKind, FemError, describe, show};
use crate::geometry::Point;
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::*;
use crate::model::system::condition::{Condition, Source};
use crate::model::system::parts::Owner;

/// The condition of a couple, from its body and its place there, and its point, which is a part; the constraints are those of a time.
///
/// Errors: a side that cannot be coupled; those of [`check_held`].
pub(crate) fn coupling<const D: usize>(
    model: &Model<D>,
    constraints: &Constraints<D>,
    ((of, place), part): ((usize, usize), usize),
    time: f64,
) -> Result<Condition<D>, Error<D>> {
    let body = &model.bodies[of];
    let couple = &body.couples[place];
    let end = End {
        body,
        side: &couple.side,
        constraints,
        part: None,
    };
    let interface = pair_couple(couple, end, model.analysis);
    let interface = interface.map_err(|source| Error::in_body(body, source))?;
    check_held(model, constraints, (of, place), &interface, time)?;
    let side = SideRef {
        body: BodyId(of),
        side: couple.side.clone(),
    };
    let name = format!("{}.{}", body.name, couple.name);
    let source = Source::Of(Owner::Point(of, place));
    Ok(Condition {
        opposite: Some(part),
        ..Condition::new(source, name, side, interface)
    })
}

/// Errors: a support of a node of a rigid side contradicts those of its point, where these hold all its dofs.
pub(crate) fn check_held<const D: usize>(
    model: &Model<D>,
    constraints: &Constraints<D>,
    (of, place): (usize, usize),
    interface: &Interface<D>,
    time: f64,
) -> Result<(), Error<D>> {
    let body = &model.bodies[of];
    let couple = &body.couples[place];
    let fail = |source| Error::in_body(body, source);
    let arm = couple.arm(body).map_err(fail)?;
    let drive = couple.drive(model.analysis, arm, time).map_err(fail)?;
    let held: Option<Vec<f64>> = drive.held.iter().flatten().copied().collect();
    let (Some(held), CoupleKind::Rigid) = (held, couple.kind) else {
        return Ok(());
    };
    // the displacement along a row, and the size of its terms, which may cancel
    let at_point = |row: &Row<D>| -> [f64; 2] {
        let of_node = |&(node, c): &(usize, Point<D>)| {
            let u = &held[D * node..];
            c.into_iter().enumerate().map(move |(i, c)| c * u[i])
        };
        let terms = || row.iter().flat_map(of_node);
        [terms().sum(), terms().map(f64::abs).sum()]
    };
    let largest = held
        .iter()
        .fold(0.0, |largest: f64, u| largest.max(u.abs()));
    for node in &interface.nodes {
        let of_row = |row: Option<usize>| row.map_or([0.0; 2], |k| at_point(&interface.mortar[k]));
        let moved = node.rows.map(of_row);
        let supports = constraints.at(node.node).iter();
        for support in supports.filter(|h| !h.supports.is_empty()) {
            let parts = support.axis.iter().zip(&moved);
            let along: f64 = parts.clone().map(|(a, [u, _])| -a * u).sum();
            let terms: f64 = parts.map(|(a, [_, terms])| a.abs() * terms).sum();
            let terms = terms.max(largest).max(support.terms);
            if (along - support.value).abs() > AGREE * terms {
                return Err(fail(FemError::Contradiction {
                    node: node.node,
                    point: show(body.mesh.points()[node.node]),
                    first: describe(&body.supports[support.supports[0]].place),
                    second: format!("at point \"{}\"", couple.name),
                    a: support.value,
                    b: along,
                }));
            }
        }
    }
    Ok(())
}
