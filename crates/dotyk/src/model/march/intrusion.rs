//! Overlaps of all bodies: their deformed outer surfaces against each other and against rigid obstacles, with or without a contact
//! between them.
//!
//! ```text
//!   grown(x) = max(0, −φ(x + u)) − max(0, −φ₀(x))          φ the signed distance from the other body or obstacle, now and at first
//! ```
//!
//! Conditions of a contact hold between facets that were opposite at first, and only where a contact is named. They do not keep
//! out a body that travels, nor separate bodies without a contact. So the nodes of every outer surface are looked up in every other
//! body in its displaced position, and for edges that pass through it the point half way between entry and exit. An answer of small
//! displacements may overlap by
//!
//! ```text
//!   allowed = 10 × what the meshes of a contact resolve there          dents and bends of the gap, see `between`
//!           + 2 (b₁ + b₂)                          b = hθ/8, how far polygons are off the curves that they stand for, as drawn or
//!                                                  as bent: facets of second order are looked at as polygons; where no contact
//!                                                  is named, of hollow ones alone, whose chords lie in what is beside the body
//!           + s (‖∇u₁‖ + ‖∇u₂‖)                    rotations by angles instead of their sines, over a motion s past each other
//!           + a given clearance that the meshes lack, the closure of a gasket + rounding
//! ```
//!
//! The first and the last but one hold at the sides of contacts only. The third is of second order in the displacements, as the
//! theory is of first: it vanishes for a body that travels without strain. An overlap deeper than the motion since was drawn so.
//! Overlaps beside excluded nodes, and those that an inactive contact would prevent, have warnings of their own. Where a
//! clearance is given, or a gasket is pressed, overlaps of the meshes within that distance from the sides and their smooth continuations do not count.
//! Bodies that meet only at edges have no sides there that a contact could name: such an overlap is as narrow as the motion, and is
//! ignored as long as the motion is small beside the facets.
//!
//! An obstacle exists only for the body whose side its contact names: a plane may represent a punch. A tool of facets is looked at as a
//! body that moves as a whole, its corners in that body and the body's nodes in it. Only nodes can overlap other obstacles: the
//! second term does not count. Of the first a tenth counts where each node has a condition of its own, and zero where a node of the
//! side has no condition. The turn of the obstacle's normal along the motion is added.

use crate::contact::{Moved, Rigid, Role, Tool};
use crate::dual::{BETWEEN_LIMIT, ROUNDING};
use crate::geometry::{Point, add_scaled, bounding_box, distance, norm, sub};
use crate::mesh::{Bow, Skin, Surrounding};
use crate::model::march::between::resolved;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::intrusion::Intrusion;
use crate::model::nouns::model::{Contact, Gap, Model, Pair};
use crate::model::nouns::presence::Stage;
use crate::model::read::view::View;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, contact_rows};
use crate::model::system::displaced::{Displaced, moved};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// Overlaps below this part of the motion are not reported.
const NO_OVERLAP: f64 = 1e-6;

/// Allowed depth of surfaces, as a multiple of their distance from their curves.
const BOWS: f64 = 2.0;

/// Larger gradients do not belong to small displacements.
const LARGEST_GRADIENT: f64 = 1.0;

/// If all facets of an edge lie within this multiple of the motion, its overlap does not count as narrow.
const NARROW: f64 = 10.0;

/// Rounding of a shift of two sides past each other.
const PASSED: f64 = 1e-9;

/// Rounding of coordinates relative to the size of the bodies.
const COORDINATE: f64 = 8.0 * ROUNDING;

/// The worst intrusions, of each body in each other one and in each obstacle, under the forces `lambda` (m,).
pub(crate) fn intrusions<const D: usize>(
    stage: &Stage<'_, D>,
    (condensed, view): (&Condensed<D>, &View<D>),
    displaced: &Displaced<D>,
    lambda: &[f64],
) -> Vec<Intrusion<D>> {
    let model = stage.model.as_ref();
    let skins = view.skins(model);
    let contacts = contact_rows(&condensed.conditions);
    let known = contacts.map(|(index, (rows, condition))| {
        Named::new(
            (model, skins),
            &model.contacts[index],
            condition,
            moved(condition, displaced),
            &lambda[rows],
        )
    });
    // bolts stand behind the contacts
    let bolts = condensed.conditions.iter().filter_map(|condition| {
        let member = &model.members[condition.source.member()?];
        member.kind.bolt()?;
        Named::of_cut((model, skins), &member.name, condition, displaced)
    });
    let mut known: Vec<Named<'_, D>> = known.chain(bolts).collect();
    let bodies = model.bodies.iter().zip(skins).zip(&displaced.states);
    let bodies = bodies
        .map(|((body, skin), state)| Solid::new(&body.name, body.mesh.points(), skin, &state.u));
    let mut bodies: Vec<Solid<'_, D>> = bodies.collect();
    let count = bodies.len();
    for (contact, own) in model.contacts.iter().zip(&mut known) {
        if let Some(tool) = tool_of(contact) {
            own.bodies.1 = Some(bodies.len());
            let moved = vec![own.moved.obstacle; tool.mesh().points().len()];
            let points = tool.mesh().points();
            bodies.push(Solid::placed(
                &contact.name,
                points,
                tool.skin(),
                Cow::Owned(moved),
            ));
        }
    }
    let with_tools = known.iter().flat_map(|own| match own.bodies {
        (body, Some(other)) if other >= count => vec![(body, other), (other, body)],
        _ => Vec::new(),
    });
    let with_tools: Vec<(usize, usize)> = with_tools.collect();
    let pairs = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
    let pairs = pairs.chain(with_tools);
    let near = |&(a, b): &(usize, usize)| a != b && bodies[a].meets(&bodies[b]);
    let pairs: Vec<(usize, usize)> = pairs.filter(near).collect();
    let between = pairs.into_par_iter().filter_map(|(a, b)| {
        let found = in_body(&bodies, &known, (a, b))?;
        if a.max(b) >= count {
            return Some(Intrusion {
                body: bodies[a.min(b)].name.to_string(),
                other: bodies[a.max(b)].name.to_string(),
                obstacle: true,
                ..found
            });
        }
        let waits = stage.waits([a, b]).filter(|_| !found.named);
        let waits = waits.map(str::to_string);
        Some(Intrusion { waits, ..found })
    });
    let deepest: Vec<Intrusion<D>> = between.collect();
    let obstacles = model.contacts.iter().zip(&known);
    let obstacles = obstacles
        .filter_map(|(contact, own)| in_obstacle(&contact.pair, own, &bodies[own.bodies.0]));
    deepest.into_iter().chain(obstacles).collect()
}

/// The tool of facets of a contact.
fn tool_of<const D: usize>(contact: &Contact<D>) -> Option<&Tool<D>> {
    match &contact.pair {
        Pair::Obstacle { obstacle, .. } => match &obstacle.shape {
            Rigid::Tool(tool) => Some(tool),
            _ => None,
        },
        _ => None,
    }
}

/// A contact, and the resolution of its meshes.
struct Named<'a, const D: usize> {
    name: &'a str,
    bodies: (usize, Option<usize>),
    moved: Moved<'a, D>,
    resolved: BTreeMap<usize, f64>,
    /// Closure of a gasket at nodes of the nonmortar side.
    closures: BTreeMap<usize, f64>,
    /// The largest of them, for nodes without a multiplier.
    closed: f64,
    /// The largest clearance, if it is given and not measured.
    given: f64,
    /// The same and the largest closure of a gasket, if there is either, and both undeformed sides, nonmortar and mortar, with their
    /// smooth continuations.
    around: Option<(f64, [Option<Surrounding<D>>; 2])>,
    /// Nodes of the nonmortar side that are excluded, and those beside them: overlaps there are reported separately.
    out: BTreeSet<usize>,
    /// Nodes of the nonmortar side that meet an obstacle node by node and are not excluded; `None` where conditions are means.
    above: Option<BTreeSet<usize>>,
}

impl<'a, const D: usize> Named<'a, D> {
    fn new(
        (model, skins): (&Model<D>, &[Skin<D>]),
        contact: &'a Contact<D>,
        condition: &Condition<D>,
        moved: Moved<'a, D>,
        lambda: &[f64],
    ) -> Self {
        let clearances = condition.interface.nodes.iter().map(|node| node.clearance);
        let side = |side: &SideRef| around(model, skins, side);
        let is_given = matches!(contact.gap, Some(Gap::Given(_)));
        let given = if is_given {
            clearances.fold(0.0, f64::max)
        } else {
            0.0
        };
        let closures = condition.closures(lambda);
        let closed = closures.values().copied().fold(0.0, f64::max);
        let around = (is_given || closed > 0.0).then(|| {
            let mortar = condition.mortar.as_ref().map(side);
            (given + closed, [Some(side(&condition.nonmortar)), mortar])
        });
        let nodes = condition.interface.nodes.iter();
        let out = nodes.filter(|node| node.role == Role::Excluded);
        let beside = condition
            .touch
            .left_out
            .iter()
            .flat_map(|sample| &sample.at.own);
        let out = out
            .map(|node| node.node)
            .chain(beside.map(|(node, _)| *node));
        let shape = match &contact.pair {
            Pair::Obstacle { obstacle, .. } => Some(&obstacle.shape),
            _ => None,
        };
        let nodes = &condition.interface.nodes;
        let above = shape.filter(|_| nodes.iter().all(|node| node.shares.mean.len() < 2));
        let above = above.map(|_| {
            let nodes = nodes.iter().filter(|node| node.role != Role::Excluded);
            nodes.map(|node| node.node).collect()
        });
        Self {
            name: &contact.name,
            out: out.collect(),
            bodies: (
                condition.nonmortar.body.0,
                condition.mortar.as_ref().map(|side| side.body.0),
            ),
            resolved: resolved(condition, &moved, lambda, |x| shape?.distance(x)),
            closures,
            closed,
            above,
            moved,
            given,
            around,
        }
    }

    /// The cut of a bolt between two bodies: at its sides these may overlap by as much as they are drawn over each other.
    fn of_cut(
        (model, skins): (&Model<D>, &[Skin<D>]),
        name: &'a str,
        condition: &Condition<D>,
        displaced: &'a Displaced<D>,
    ) -> Option<Self> {
        let sides = [&condition.nonmortar, condition.mortar.as_ref()?];
        let passed = condition.interface.nodes.iter().map(|node| {
            let beyond = node.opposite.iter().map(|&(node, _)| node);
            let u = |side: usize, node: usize| displaced.nodes(sides[side].body.0)[node];
            let apart = beyond.map(|other| norm(sub(u(0, node.node), u(1, other))));
            apart.fold(0.0, f64::max)
        });
        let passed = passed.fold(0.0, f64::max) * (1.0 + PASSED);
        Some(Self {
            name,
            bodies: (sides[0].body.0, Some(sides[1].body.0)),
            moved: moved(condition, displaced),
            resolved: BTreeMap::new(),
            closures: BTreeMap::new(),
            closed: 0.0,
            given: passed,
            around: Some((passed, sides.map(|side| Some(around(model, skins, side))))),
            out: BTreeSet::new(),
            above: None,
        })
    }

    /// Allowed overlap at a node of its nonmortar side.
    fn allows(&self, node: u32) -> Option<f64> {
        let resolved = self.resolved.get(&(node as usize))?;
        let own = self.closures.get(&(node as usize)).copied();
        let closed = own.unwrap_or(self.closed);
        Some(BETWEEN_LIMIT * resolved + closed + self.given)
    }

    /// Whether a clearance is given, or a gasket lies between, and the undeformed point of body `of`, or the one next to it on the other body, lies within the
    /// clearance from the contact's side of its body or from the continuation of that side.
    fn excuses(&self, of: usize, [own, other]: [Point<D>; 2]) -> bool {
        let Some((clearance, [nonmortar, mortar])) = &self.around else {
            return false;
        };
        let (of_own, of_other) = match self.bodies.0 == of {
            true => (nonmortar, mortar),
            false => (mortar, nonmortar),
        };
        let near = |side: &Option<Surrounding<D>>, x: Point<D>| {
            side.as_ref()
                .is_some_and(|side| side.distance(x) <= *clearance)
        };
        near(of_own, own) || near(of_other, other)
    }

    /// A node of body `of`, next to nodes of the other one, lies where a part of the side is excluded.
    fn leaves_out<const N: usize>(&self, of: usize, node: u32, near: [u32; N]) -> bool {
        let out = |node: u32| self.out.contains(&(node as usize));
        match self.bodies.0 == of {
            true => out(node),
            false => near.into_iter().any(out),
        }
    }
}

/// An undeformed side with its smooth continuations.
fn around<const D: usize>(model: &Model<D>, skins: &[Skin<D>], side: &SideRef) -> Surrounding<D> {
    let mesh = &model.bodies[side.body.0].mesh;
    let facets = mesh.side(&side.side).unwrap_or_default().iter();
    let nodes = facets.flat_map(|facet| mesh.facet_nodes(*facet));
    skins[side.body.0].going_on_from(&nodes.collect(), mesh.points())
}

/// A displaced body.
#[derive(Clone)]
struct Solid<'a, const D: usize> {
    name: &'a str,
    first: &'a [Point<D>],
    skin: &'a Skin<D>,
    moved: Cow<'a, [Point<D>]>,
    now: Vec<Point<D>>,
    bounds: (Point<D>, Point<D>),
    /// Largest displacement of the surface.
    most: f64,
    /// Distance of the displaced skin from the curve that it represents, at its nodes.
    bows: OnceLock<Vec<Bow>>,
}

impl<'a, const D: usize> Solid<'a, D> {
    fn new(name: &'a str, first: &'a [Point<D>], skin: &'a Skin<D>, moved: &'a [Point<D>]) -> Self {
        Self::placed(name, first, skin, Cow::Borrowed(moved))
    }

    fn placed(
        name: &'a str,
        first: &'a [Point<D>],
        skin: &'a Skin<D>,
        moved: Cow<'a, [Point<D>]>,
    ) -> Self {
        let both = first.iter().zip(moved.iter());
        let now: Vec<Point<D>> = both.map(|(x, u)| add_scaled(*x, 1.0, *u)).collect();
        let most = skin.nodes().iter().map(|&node| norm(moved[node as usize]));
        Self {
            most: most.fold(0.0, f64::max),
            bows: OnceLock::new(),
            bounds: bounding_box(&now),
            name,
            first,
            skin,
            moved,
            now,
        }
    }

    fn meets(&self, other: &Self) -> bool {
        let (a, b) = (&self.bounds, &other.bounds);
        (0..D).all(|d| a.0[d] <= b.1[d] && b.0[d] <= a.1[d])
    }

    /// Largest gradient of the displacement along its surface at a node.
    fn gradient(&self, node: u32) -> f64 {
        let at = node as usize;
        let each = self.skin.beside(node).iter().map(|&other| {
            let other = other as usize;
            let apart = distance(self.first[at], self.first[other]);
            distance(self.moved[at], self.moved[other]) / apart
        });
        each.fold(0.0, f64::max).min(LARGEST_GRADIENT)
    }

    /// Overlap that its mesh and its rotation allow at a node past which the other body has moved by `motion`; `named`: a contact
    /// between the two is named.
    fn allows(&self, node: u32, motion: f64, named: bool) -> f64 {
        let bent = self.bows.get_or_init(|| self.skin.bows(&self.now));
        let bows = [self.skin.bow(node), bent[self.skin.place(node)]];
        let bow = bows.map(|bow| if named { bow.off } else { bow.beyond });
        BOWS * bow[0].max(bow[1]) + motion * self.gradient(node)
    }
}

/// A point of an edge of a surface: its first end, or one on the way to the second.
#[derive(Clone, Copy)]
struct Spot {
    ends: [u32; 2],
    part: f64,
}

impl Spot {
    fn node(node: u32) -> Self {
        Self {
            ends: [node; 2],
            part: 0.0,
        }
    }

    /// The interpolated value of nodal ones such as positions or displacements.
    fn of<const D: usize>(&self, values: &[Point<D>]) -> Point<D> {
        let [from, to] = self.ends.map(|node| values[node as usize]);
        add_scaled(from, self.part, sub(to, from))
    }
}

/// Two bodies, of which the first may overlap the second.
struct Meeting<'a, 'b, const D: usize> {
    /// Which of the bodies the first is.
    of: usize,
    own: Cow<'a, Solid<'b, D>>,
    other: Cow<'a, Solid<'b, D>>,
    /// The contacts between them.
    between: Vec<&'a Named<'b, D>>,
    /// Lengths below this one are rounding.
    rounding: f64,
}

/// The worst intrusion of one body in another one.
fn in_body<const D: usize>(
    bodies: &[Solid<'_, D>],
    contacts: &[Named<'_, D>],
    (a, b): (usize, usize),
) -> Option<Intrusion<D>> {
    let between =
        |contact: &&Named<'_, D>| contact.bodies == (a, Some(b)) || contact.bodies == (b, Some(a));
    let between: Vec<&Named<'_, D>> = contacts.iter().filter(between).collect();
    // a body that was fitted to a displaced one counts from that position
    let since = |index: usize| {
        let own = &bodies[index];
        let fitted = between
            .first()
            .and_then(|contact| match contact.bodies.0 == index {
                true => Some(&contact.moved.own),
                false => contact.moved.other.as_ref(),
            });
        let fitted = fitted.filter(|u| matches!(u, Cow::Owned(_)));
        let placed = |u: &Cow<'_, [Point<D>]>| {
            Solid::placed(own.name, own.first, own.skin, Cow::Owned(u.to_vec()))
        };
        fitted.map_or(Cow::Borrowed(own), |u| Cow::Owned(placed(u)))
    };
    let (own, other) = (since(a), since(b));
    let meeting = Meeting {
        of: a,
        rounding: COORDINATE * extent(&[own.bounds, other.bounds]),
        own,
        other,
        between,
    };
    meeting.worst()
}

impl<const D: usize> Meeting<'_, '_, D> {
    fn worst(&self) -> Option<Intrusion<D>> {
        let (own, other) = (&*self.own, &*self.other);
        let motion = own.most + other.most;
        if motion <= self.rounding {
            return None;
        }
        // after such a motion no point is deeper than twice the motion
        let reach = 2.0 * motion + self.rounding;
        let low = std::array::from_fn(|d| own.bounds.0[d].max(other.bounds.0[d]) - reach);
        let high = std::array::from_fn(|d| own.bounds.1[d].min(other.bounds.1[d]) + reach);
        let surface = other.skin.at(&other.now, (low, high));
        let deep = self.spots(&surface).into_iter().filter_map(|spot| {
            let (depth, near) = surface.depth(spot.of(&own.now))?;
            (depth > self.rounding && depth <= reach).then_some((spot, depth, near))
        });
        let deep: Vec<(Spot, f64, [u32; D])> = deep.collect();
        if deep.is_empty() {
            return None;
        }
        let undeformed = other.skin.at(other.first, (low, high));
        let deep = deep.into_iter();
        deep.filter_map(|(spot, depth, near)| self.intrusion(&undeformed, spot, depth, near))
            .reduce(Intrusion::worse)
    }

    /// Points where the first body may be deepest: its nodes, and the middles of edges within the other one.
    fn spots(&self, surface: &Surrounding<D>) -> Vec<Spot> {
        let (own, (low, high)) = (&*self.own, self.other.bounds);
        let nodes = own.skin.nodes().iter().copied().filter(|&node| {
            let p = own.now[node as usize];
            (0..D).all(|d| low[d] <= p[d] && p[d] <= high[d])
        });
        let edges = own.skin.edges().iter();
        let through = edges.flat_map(|&ends| {
            let way = ends.map(|node| own.now[node as usize]);
            let box_of = bounding_box(&way);
            let meets = (0..D).all(|d| low[d] <= box_of.1[d] && box_of.0[d] <= high[d]);
            let at = if meets {
                surface.crossings(way)
            } else {
                Vec::new()
            };
            let between = at.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            let spots = between.map(|part| Spot { ends, part });
            spots.collect::<Vec<Spot>>()
        });
        nodes.map(Spot::node).chain(through).collect()
    }

    /// The intrusion at a spot that is too deep, next to nodes `near` of the other body.
    fn intrusion(
        &self,
        undeformed: &Surrounding<D>,
        spot: Spot,
        depth: f64,
        near: [u32; D],
    ) -> Option<Intrusion<D>> {
        let (own, other, rounding) = (&*self.own, &*self.other, self.rounding);
        let mut ends = spot.ends.iter();
        if ends.any(|&end| {
            self.between
                .iter()
                .any(|c| c.leaves_out(self.of, end, near))
        }) {
            return None;
        }
        let first = spot.of(own.first);
        let (drawn, _) = undeformed.depth(first)?;
        let moved = spot.of(&own.moved);
        let beside = near.map(|node| sub(moved, other.moved[node as usize]));
        let motion = beside.into_iter().map(norm).fold(0.0, f64::max);
        let grown = depth - drawn.max(0.0);
        let unnamed = self.between.is_empty();
        if drawn > motion + rounding
            || grown <= rounding
            || (unnamed && self.is_narrow(undeformed, spot, motion))
        {
            return None;
        }
        let of_contacts = self.of_contacts(spot, near);
        let share = 1.0 / D as f64;
        let next_to = near.iter().fold([0.0; D], |sum, &node| {
            add_scaled(sum, share, other.first[node as usize])
        });
        let mut given = self.between.iter();
        if of_contacts.is_none() && given.any(|c| c.excuses(self.of, [first, next_to])) {
            return None;
        }
        let of_own = spot.ends.map(|node| own.allows(node, motion, !unnamed));
        let of_other = near.map(|node| other.allows(node, motion, !unnamed));
        let allowed = of_contacts.unwrap_or(0.0)
            + of_own.into_iter().fold(0.0, f64::max)
            + of_other.into_iter().fold(0.0, f64::max)
            + NO_OVERLAP * motion
            + rounding;
        Some(Intrusion {
            body: own.name.to_string(),
            other: other.name.to_string(),
            obstacle: false,
            point: first,
            depth: grown,
            allowed,
            named: !unnamed,
            waits: None,
        })
    }

    /// Whether undeformed edges of both meet at a point, and no undeformed facet there lies along the other body.
    fn is_narrow(&self, undeformed: &Surrounding<D>, spot: Spot, motion: f64) -> bool {
        let at = spot.of(self.own.first);
        let reach = NARROW * motion + self.rounding;
        // an edge through a corner has its middle beside it
        let beside = match spot.ends[0] == spot.ends[1] {
            true => self.rounding,
            false => reach,
        };
        let is_edge = |solid: &Solid<'_, D>| solid.skin.is_sharp_at(solid.first, at, beside);
        let touches = |node: &u32| {
            let depth = undeformed.depth(self.own.first[*node as usize]);
            depth.is_some_and(|(depth, _)| depth >= -reach)
        };
        let mut around = self.own.skin.around(spot.ends);
        is_edge(&self.own) && is_edge(&self.other) && !around.any(|s| s.iter().all(touches))
    }

    /// Overlap that the contacts between the two allow there.
    fn of_contacts(&self, spot: Spot, near: [u32; D]) -> Option<f64> {
        let largest = |contact: &&Named<'_, D>, nodes: &[u32]| {
            let allowed = nodes.iter().filter_map(|&node| contact.allows(node));
            allowed.reduce(f64::max)
        };
        let each = self
            .between
            .iter()
            .filter_map(|contact| match contact.bodies.0 == self.of {
                true => largest(contact, &spot.ends),
                false => largest(contact, &near),
            });
        each.reduce(f64::max)
    }
}

/// The size of the bounding box of some boxes.
fn extent<const D: usize>(boxes: &[(Point<D>, Point<D>)]) -> f64 {
    let corners: Vec<Point<D>> = boxes.iter().flat_map(|(low, high)| [*low, *high]).collect();
    let coordinates = corners.iter().flatten();
    coordinates.fold(0.0, |s: f64, c| s.max(c.abs()))
}

/// The worst intrusion of nodes of a body in the obstacle of a contact.
fn in_obstacle<const D: usize>(
    pair: &Pair<D>,
    contact: &Named<'_, D>,
    body: &Solid<'_, D>,
) -> Option<Intrusion<D>> {
    let Pair::Obstacle { obstacle, .. } = pair else {
        return None;
    };
    if let Rigid::Tool(_) = obstacle.shape {
        return None;
    }
    let rounding = COORDINATE * extent(&[body.bounds]);
    let depth = |x: Point<D>| obstacle.shape.distance(x).map(|out| -out);
    let found = body.skin.nodes().iter().filter_map(|&node| {
        let at = node as usize;
        let first = body.first[at];
        let relative = sub(contact.moved.own[at], contact.moved.obstacle);
        let (now, motion) = (add_scaled(first, 1.0, relative), norm(relative));
        let (deep, drawn) = (depth(now)?, depth(first)?);
        let grown = deep - drawn.max(0.0);
        if grown <= rounding || drawn > motion + rounding {
            return None;
        }
        let of_contact = match &contact.above {
            Some(above) if !above.contains(&at) => return None,
            Some(_) => contact.resolved.get(&at).copied().unwrap_or(0.0),
            None => contact.allows(node)?,
        };
        let allowed = of_contact
            + motion * (body.gradient(node) + obstacle.shape.turn(first, now) + NO_OVERLAP)
            + rounding;
        Some(Intrusion {
            body: body.name.to_string(),
            other: contact.name.to_string(),
            obstacle: true,
            point: first,
            depth: grown,
            allowed,
            named: true,
            waits: None,
        })
    });
    found.reduce(Intrusion::worse)
}
