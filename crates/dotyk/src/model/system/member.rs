//! Members as links, one for each of their elements.
//!
//! ```text
//!   any force              gap = e_a − (e − q) = 0      k of its kind      q = (λ − P)/k: lengthened, λ = N
//!   tension                gap ≥ 0, λ ≥ 0, with a play in the gap
//!   compression            the same of −e and −N
//!   yields                 −slip = gap,  −N_y ≤ λ ≤ N_y: the plastic elongation is a slip
//!   both                   0 ≤ λ ≤ N_y, and what is slack keeps its slip
//!   being tightened        no row: both ends are pulled with P
//! ```
//!
//! Members of a plane model count as many times as there are in its thickness.

use crate::contact::{Coupling, Interface, InterfaceNode, Row, frame};
use crate::geometry::{Point, add_scaled, dot, norm};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::member::{MemberSolution, MemberStation};
use crate::model::nouns::presence::Stage;
use crate::model::nouns::solution::BodySolution;
use crate::model::system::condition::{Condition, Elastic, Source, row_ranges};
use crate::model::system::laid::{Anchor, LaidMember, lay_members};
use crate::model::system::links::{axis, carrier, less, linked};
use crate::model::system::parts::Owner;
use std::collections::BTreeSet;

/// Rows of the elements of a member on one body.
fn rows_on<const D: usize>(laid: &LaidMember<D>, sign: f64, body: usize) -> Vec<Row<D>> {
    let row = |[from, to]: [&Anchor<D>; 2]| {
        let mut row: Row<D> = Vec::new();
        for (anchor, sign) in [(from, -sign), (to, sign)] {
            for &(node, n) in anchor.nodes.iter().filter(|_| anchor.body == body) {
                let pull = laid.along.map(|c| sign * n * c);
                match row.iter_mut().find(|entry| entry.0 == node) {
                    Some((_, sum)) => *sum = add_scaled(*sum, 1.0, pull),
                    None => row.push((node, pull)),
                }
            }
        }
        row
    };
    laid.elements().map(row).collect()
}

/// The condition of a member from its place in the model, its laid-out points, and its part.
pub(crate) fn pulling<const D: usize>(
    stage: &Stage<'_, D>,
    (place, laid): (usize, &LaidMember<D>),
    part: usize,
) -> Condition<D> {
    let (member, tightening) = (&stage.model.members[place], stage.tightening[place]);
    let pull = member.kind.pull();
    let law = pull.law(laid.count);
    let mut bodies: Vec<usize> = laid.anchors.iter().map(|anchor| anchor.body).collect();
    bodies.sort_unstable();
    bodies.dedup();
    let prestress = law.sign * laid.count * pull.prestress().unwrap_or(0.0);
    let mut elastic = Elastic::default();
    for [from, to] in laid.elements() {
        let length = laid.length_to(to.point) - laid.length_to(from.point);
        let k = pull.stiffness(laid.count, length);
        elastic.stiffness.push(axis::<D>(0).map(|c| c * k));
        elastic.load.push(axis::<D>(0).map(|c| -c * prestress));
    }
    let mut of_bodies: Vec<(usize, Vec<Row<D>>)> = bodies
        .iter()
        .map(|&body| (body, rows_on(laid, law.sign, body)))
        .collect();
    let mut steady = Vec::new();
    if tightening {
        for (body, rows) in &of_bodies {
            let pulls = rows.iter().flatten();
            let pulls = pulls.map(|&(node, c)| (*body, node, c.map(|c| -prestress * c)));
            steady.extend(pulls);
        }
        of_bodies.iter_mut().for_each(|(_, rows)| rows.clear());
    }
    let mut interface = Interface::empty(match law.block.is_free() || tightening {
        true => Coupling::Tied,
        false => Coupling::Normal,
    });
    let mut of_bodies = of_bodies.into_iter();
    let (body, rows) = of_bodies.next().unwrap_or_default();
    let mut places = Vec::new();
    for (row, (element, [from, to])) in rows.iter().zip(laid.elements().enumerate()) {
        let most = row.iter().max_by(|a, b| norm(a.1).total_cmp(&norm(b.1)));
        interface.nodes.push(InterfaceNode {
            node: most.map_or(0, |&(node, _)| node),
            frame: frame(laid.along.map(|c| law.sign * c), &[]),
            gap: law.gap,
            ..carrier(element)
        });
        interface.mortar.push(less(element, 0));
        places.push(add_scaled(from.point.map(|c| 0.5 * c), 0.5, to.point));
    }
    interface.nonmortar = rows;
    let end = SideRef {
        body: BodyId(body),
        side: String::new(),
    };
    let offset = vec![law.offset; interface.nonmortar.len()];
    let source = (Source::Of(Owner::Member(place)), member.name.clone());
    Condition {
        law: Some(law.block),
        offset,
        further: of_bodies.collect(),
        steady,
        places,
        ..linked(source, (end, part), interface, elastic)
    }
}

/// Forces of all members under forces `lambda` (m,) and the displacements of solved bodies.
///
/// Errors: members that cannot be laid.
pub(crate) fn member_solutions<const D: usize>(
    stage: &Stage<'_, D>,
    conditions: &[Condition<D>],
    lambda: &[f64],
    bodies: &[BodySolution<D>],
) -> Result<Vec<MemberSolution<D>>, Error<D>> {
    let model = stage.model.as_ref();
    let laid = lay_members(model)?;
    let solved = row_ranges(conditions).filter_map(|(rows, condition)| {
        let place = condition.source.member()?;
        let (member, laid) = (&model.members[place], &laid[place]);
        let pull = member.kind.pull();
        let tension = pull.law(laid.count).sign > 0.0;
        let of_one = |force: f64| match tension {
            true => force / laid.count,
            // no compression is 0, and not −0
            false => 0.0 - force / laid.count,
        };
        let along = condition.forces(&lambda[rows]);
        let along: Vec<f64> = match member.kind.bolt() {
            Some(_) => vec![tension_of(condition, laid.along, &along)],
            None => along.into_iter().map(of_one).collect(),
        };
        let mean = |anchor: &Anchor<D>| {
            let nodes = anchor.nodes.iter();
            let along =
                nodes.map(|&(node, n)| n * dot(laid.along, bodies[anchor.body].displacement[node]));
            along.sum::<f64>()
        };
        let shortening = member.kind.bolt();
        let shortening = shortening.map(|_| mean(&laid.anchors[0]) - mean(&laid.anchors[1]));
        let stations = laid.elements().enumerate().map(|(element, [from, to])| {
            let middle = add_scaled(from.point.map(|c| 0.5 * c), 0.5, to.point);
            let own = along.get(element).copied();
            MemberStation {
                s: laid.length_to(middle),
                point: middle,
                length: laid.length_to(to.point) - laid.length_to(from.point),
                force: own.or(pull.prestress()).unwrap_or(0.0),
            }
        });
        let last = laid
            .anchors
            .last()
            .map_or(0.0, |end| laid.length_to(end.point));
        Some(MemberSolution {
            name: member.name.clone(),
            kind: member.kind.words(),
            length: last,
            stations: stations.collect(),
            tightening: stage.tightening[place],
            shortening,
        })
    });
    Ok(solved.collect())
}

/// The tension of a bolt along its axis: of the forces of its rows, and of those that tighten it.
fn tension_of<const D: usize>(condition: &Condition<D>, along: Point<D>, forces: &[f64]) -> f64 {
    let own = condition.nonmortar.body.0;
    let behind: BTreeSet<usize> = condition.interface.nodes.iter().map(|n| n.node).collect();
    let behind = |node: usize| behind.contains(&node);
    let rows = condition.interface.nonmortar.iter().zip(forces);
    let of_row = |(row, force): (&Row<D>, &f64)| {
        let on_side = row.iter().filter(|(node, _)| behind(*node));
        -force * on_side.map(|(_, c)| dot(*c, along)).sum::<f64>()
    };
    let steady = condition.steady.iter();
    let steady = steady.filter(|(body, node, _)| *body == own && behind(*node));
    let drawn: f64 = steady.map(|(.., force)| dot(*force, along)).sum();
    rows.map(of_row).sum::<f64>() + drawn
}
