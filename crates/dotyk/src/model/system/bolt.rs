//! Bolts as conditions: the two sides of a cut, with rows at each pair of nodes.
//!
//! With the jump j_i = u⁻_i − u⁺_i of a pair of nodes, the axis a, the tangents t and the shortening s,
//!
//! ```text
//!   t·j_i = 0                                   always
//!   a·j_i − s = 0                               kept or given s                     T = Σ λ_i
//!   a·j_i − a·j_0 = 0   (i > 0),  ±T a/A on the sides                               while it is tightened by T
//! ```
//!
//! the last two the same: s is the multiplier of T, and the rows share the traction T/A out as the jump asks for. A direction that
//! supports hold at both nodes of a pair has no row.

use crate::contact::{Coupling, Interface, InterfaceNode, frame};
use crate::fem::{Analysis, Constraints, show};
use crate::fem::{SAME, coincident, largest_facet, placed, spans};
use crate::geometry::{Point, distance, dot, unit};
use crate::mesh::Facet;
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::member::{ENDS, MemberEnd, MemberError};
use crate::model::nouns::members::{Bolt, Drawn, Member};
use crate::model::nouns::model::Model;
use crate::model::nouns::presence::Stage;
use crate::model::system::condition::{Condition, Source};
use crate::model::system::face::Face;
use crate::model::system::links::{axis, carrier};
use crate::model::system::parts::Owner;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Directions with no larger part along the axis are across it.
const ACROSS: f64 = 1e-6;

/// The least part of the normal of a cut along its axis.
const LEAST_ALONG: f64 = 0.1;

/// The cut of a bolt in its place.
#[derive(Debug, Clone)]
pub(crate) struct LaidCut<const D: usize> {
    /// Its sides behind and ahead of the cut.
    pub sides: [SideRef; 2],
    /// Unit vector along the axis, outward from the side behind.
    pub along: Point<D>,
    /// Of the side behind.
    pub centre: Point<D>,
    /// Distance of its farthest node from there.
    pub radius: f64,
    /// Nodes of the two sides that lie on each other.
    pub pairs: Vec<[usize; 2]>,
    /// What nodes of either side bear of a uniform traction: 1 in all.
    pub shares: [Vec<(usize, f64)>; 2],
}

impl<const D: usize> LaidCut<D> {
    /// The cut of a member that is a bolt.
    ///
    /// Errors: ends that are not sides; a side that is unknown or has no area; sides that do not lie on each other node by node; an axis
    /// along the cut, or with axial symmetry not along that of symmetry; a contact there.
    pub fn new(model: &Model<D>, member: &Member<D>, bolt: &Bolt) -> Result<Self, MemberError> {
        let side = |end: usize| match &member.line.ends[end] {
            MemberEnd::Side(side) => Ok(side.clone()),
            MemberEnd::Point(_) => {
                let message = "a bolt ends at the two sides of a cut, not at points";
                Err(MemberError::new(ENDS[end], message, "a point", ""))
            }
        };
        let sides = [side(0)?, side(1)?];
        let [behind, ahead] =
            [0, 1].map(|end| Face::new((&model.bodies, model.analysis), &sides[end], end));
        let (behind, ahead) = (behind?, ahead?);
        let given = bolt.axis.map(|axis| std::array::from_fn(|d| axis[d]));
        let axial = model.analysis == Analysis::Axisymmetric;
        let normal = if axial { axis(1) } else { behind.normal };
        let through = unit(given.unwrap_or(normal));
        if axial && through.is_some_and(|through| through[0].abs() > ACROSS) {
            let message = "with axial symmetry a bolt is drawn along the axis of symmetry, y";
            return Err(MemberError::new("axis", message, "not along y", ""));
        }
        let tilt = through.map_or(0.0, |axis| dot(axis, behind.normal));
        let along = match through {
            Some(axis) if tilt >= LEAST_ALONG => axis,
            Some(axis) if tilt <= -LEAST_ALONG => axis.map(|c| -c),
            _ => {
                let message = "its axis runs along the cut, not through it";
                return Err(MemberError::new("axis", message, "along the cut", ""));
            }
        };
        kept_apart(model, &sides)?;
        let pairs = paired(model, &sides)?;
        let points = model.bodies[sides[0].body.0].mesh.points();
        let apart = pairs
            .iter()
            .map(|pair| distance(points[pair[0]], behind.centre));
        Ok(Self {
            along,
            centre: behind.centre,
            radius: apart.fold(0.0, f64::max),
            pairs,
            shares: [behind.shares, ahead.shares],
            sides,
        })
    }

    /// Pulls on the two sides, uniform tractions: body, node, force.
    fn pulls(&self, tension: f64) -> Vec<(usize, usize, Point<D>)> {
        let of_side = |(end, sign): (usize, f64)| {
            let shares = self.shares[end].iter();
            shares.map(move |&(node, share)| {
                let force = self.along.map(|c| sign * tension * share * c);
                (self.sides[end].body.0, node, force)
            })
        };
        [(0, 1.0), (1, -1.0)]
            .into_iter()
            .flat_map(of_side)
            .collect()
    }
}

/// Errors: a contact at a side of a cut, which would keep apart what the bolt draws together.
fn kept_apart<const D: usize>(model: &Model<D>, sides: &[SideRef; 2]) -> Result<(), MemberError> {
    let facets = |side: &SideRef| {
        let mesh = &model.bodies[side.body.0].mesh;
        mesh.side(&side.side).unwrap_or_default()
    };
    let cut: BTreeSet<(BodyId, Facet)> = sides
        .iter()
        .flat_map(|side| facets(side).iter().map(|facet| (side.body, *facet)))
        .collect();
    let touches = |side: &SideRef| {
        let mut own = facets(side).iter();
        own.any(|facet| cut.contains(&(side.body, *facet)))
    };
    let mut contacts = model.contacts.iter();
    let Some(contact) = contacts.find(|contact| contact.pair.sides().into_iter().any(touches))
    else {
        return Ok(());
    };
    Err(MemberError::new(
        "from",
        format!(
            "contact \"{}\" acts at its cut, whose sides it draws over each other",
            contact.name
        ),
        "a side of a contact",
        "leave the facets of the cut out of the contact; one that is found names its bodies, without both of these",
    ))
}

/// The nodes of two sides, in pairs that lie on each other.
///
/// Errors: a node of one side that has no partner on the other.
fn paired<const D: usize>(
    model: &Model<D>,
    sides: &[SideRef; 2],
) -> Result<Vec<[usize; 2]>, MemberError> {
    let mesh = |end: usize| &model.bodies[sides[end].body.0].mesh;
    let [own, other] = [0, 1].map(|end| placed(mesh(end), &sides[end].side));
    let within = SAME * largest_facet(mesh(0), &sides[0].side);
    coincident([&own, &other], within).map_err(|place| {
        let at = place.map(|c| c.to_string()).join(", ");
        let message = format!(
            "its two sides are not those of a cut: the node at ({at}) of one has no partner on the other"
        );
        let help = "cut a body by `body` and `at`, or mesh both sides with the same facets";
        MemberError::new("to", message, "other nodes", help)
    })
}

/// The condition of a bolt by its place in the model, at a time.
///
/// Errors: a cut that cannot be laid, or whose sides supports hold; a prestress or shortening that is not finite.
pub(crate) fn drawn_together<const D: usize>(
    stage: &Stage<'_, D>,
    constraints: &[&Constraints<D>],
    (place, bolt): (usize, &Bolt),
    time: f64,
) -> Result<Condition<D>, Error<D>> {
    let member = &stage.model.members[place];
    let refused = |source| refused(member, source);
    let laid = LaidCut::new(&stage.model, member, bolt).map_err(refused)?;
    let drawn = bolt.drawn(stage.tightening[place], time).map_err(refused)?;
    let bodies = laid.sides.each_ref().map(|side| side.body.0);
    if let Some(node) = stuck(&laid, constraints) {
        let at = stage.model.bodies[bodies[0]].mesh.points()[node];
        return Err(refused(MemberError::new(
            "axis",
            format!(
                "supports hold both sides of its cut at {} along its axis: they cannot be drawn together",
                show(at)
            ),
            "not free to move",
            "let the axis run along the plane of symmetry, or support nodes off the cut",
        )));
    }
    let mut interface = Interface::empty(Coupling::Tied);
    let mut held_rows = Vec::new();
    for (k, &[own, other]) in laid.pairs.iter().enumerate() {
        let held = [
            constraints[bodies[0]].at(own),
            constraints[bodies[1]].at(other),
        ];
        let directions: Vec<Point<D>> = held[0].iter().map(|held| held.axis).collect();
        let axes = frame(laid.along, &directions);
        let mut rows = [None; D];
        for (i, &axis) in axes.iter().enumerate() {
            // while it is tightened the first pair moves along the axis as it will, and the others with it
            if matches!((drawn, i, k), (Drawn::Force(_), 0, 0)) {
                continue;
            }
            let row = interface.nonmortar.len();
            rows[i] = Some(row);
            let [mut behind, mut beyond] = [vec![(own, axis)], vec![(other, axis.map(|c| -c))]];
            if let (Drawn::Force(_), 0) = (drawn, i) {
                behind.push((laid.pairs[0][0], axis.map(|c| -c)));
                beyond.push((laid.pairs[0][1], axis));
            }
            if bodies[0] == bodies[1] {
                behind.append(&mut beyond);
            }
            interface.nonmortar.push(behind);
            interface.mortar.push(beyond);
            if held
                .iter()
                .all(|held| spans(held.iter().map(|held| held.axis), axis))
            {
                held_rows.push(row);
            }
        }
        interface.nodes.push(InterfaceNode {
            node: own,
            opposite: vec![(other, 1.0)],
            frame: axes,
            rows,
            ..carrier(0)
        });
    }
    interface.drop_rows(&held_rows);
    let source = Source::Of(Owner::Member(place));
    let [behind, ahead] = laid.sides.clone();
    let apart = bodies[0] != bodies[1];
    let mut condition = Condition {
        mortar: apart.then_some(ahead),
        opposite: apart.then_some(bodies[1]),
        ..Condition::new(source, member.name.clone(), behind, interface)
    };
    draw(&mut condition, &laid, drawn);
    Ok(condition)
}

/// A node of the side behind where supports of both sides hold a direction that is not across the axis.
fn stuck<const D: usize>(laid: &LaidCut<D>, constraints: &[&Constraints<D>]) -> Option<usize> {
    let [behind, ahead] = laid.sides.each_ref().map(|side| constraints[side.body.0]);
    let mut pairs = laid.pairs.iter();
    let pair = pairs.find(|[own, other]| {
        let beyond = || ahead.at(*other).iter().map(|held| held.axis);
        let mut both = behind.at(*own).iter().map(|held| held.axis);
        both.any(|axis| dot(axis, laid.along).abs() > ACROSS && spans(beyond(), axis))
    });
    pair.map(|[own, _]| *own)
}

/// Sets what acts on the sides of a cut.
fn draw<const D: usize>(condition: &mut Condition<D>, laid: &LaidCut<D>, drawn: Drawn) {
    if let Drawn::Force(tension) = drawn {
        condition.steady = laid.pulls(tension);
    }
    if let Drawn::Length(length) = drawn {
        condition
            .interface
            .nodes
            .iter_mut()
            .for_each(|node| node.gap = length);
    }
}

/// Keeps the shortening that a bolt has at displacements `moved` of its one or two bodies, if it is neither tightened nor given one.
pub(crate) fn keep<const D: usize>(
    bolt: &Bolt,
    condition: &mut Condition<D>,
    moved: impl Fn(usize) -> Option<Arc<[Point<D>]>>,
) {
    if !condition.steady.is_empty() || bolt.shortening.is_some() {
        return;
    }
    let mut nodes = condition.interface.nodes.iter();
    let Some(row) = nodes.find_map(|node| node.rows[0]) else {
        return;
    };
    let mut length = 0.0;
    for (body, rows) in condition.ends() {
        let Some(u) = moved(body) else { return };
        length += rows[row]
            .iter()
            .map(|&(node, c)| dot(c, u[node]))
            .sum::<f64>();
    }
    condition
        .interface
        .nodes
        .iter_mut()
        .for_each(|node| node.gap = length);
}

/// Sets prestress and shortening of the bolts among the conditions of a model to another time.
///
/// Errors: values that are not finite.
pub(crate) fn take_tension<const D: usize>(
    model: &Model<D>,
    conditions: &mut [Condition<D>],
    time: f64,
) -> Result<(), Error<D>> {
    for condition in conditions {
        let member = condition.source.member().map(|place| &model.members[place]);
        let Some((member, bolt)) = member.and_then(|m| Some((m, m.kind.bolt()?))) else {
            continue;
        };
        let refused = |source| refused(member, source);
        let drawn = bolt
            .drawn(!condition.steady.is_empty(), time)
            .map_err(refused)?;
        let laid = LaidCut::new(model, member, bolt).map_err(refused)?;
        draw(condition, &laid, drawn);
    }
    Ok(())
}

fn refused<const D: usize>(member: &Member<D>, source: MemberError) -> Error<D> {
    Error::Member {
        kind: member.kind.words(),
        name: member.name.clone(),
        source,
    }
}
