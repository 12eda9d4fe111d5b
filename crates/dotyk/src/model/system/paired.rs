//! What two sides are once they are paired: rows, gaps and what else there is of a contact, a couple or a link.

use crate::contact::{Interface, InterfaceNode, Role, Row, Sample};
use crate::fem::CoupleKind;
use crate::geometry::{Field, Point, add_scaled, dot, sub};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::*;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// What sides are paired for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// They touch.
    Contact,
    /// A side moves with a point.
    Couple(CoupleKind),
    /// A spring that only presses, by its place among those of the body.
    Bed(usize),
    /// A bar, by its place.
    Bar(usize),
}

/// One contact, couple or link of the model, paired.
pub(crate) struct Paired<const D: usize> {
    /// What it is.
    pub kind: Kind,
    /// Its name; of a couple "BODY.POINT", of a bed "spring of BODY.SIDE".
    pub name: String,
    /// Side that carries the multipliers.
    pub nonmortar: SideRef,
    /// The other side; `None` for an obstacle or a point.
    pub mortar: Option<SideRef>,
    /// The part that the rows of `interface.mortar` act on: a body, a free obstacle, a point, or the part of a link.
    pub opposite: Option<usize>,
    /// Prescribed displacement of the obstacle; zero where it is free.
    pub obstacle_motion: [f64; D],
    /// Rows, gaps and weights.
    pub interface: Interface<D>,
    /// Points between the nodes that face something, for each facet of the nonmortar side.
    pub samples: Vec<Vec<Sample<D>>>,
    /// Those of facets with a node that takes no part: nothing keeps them apart.
    pub left_out: Vec<Sample<D>>,
    /// What its sides were fitted to.
    pub fit: Fit<D>,
    /// Where its sides were when its stage began: slip counts from there, and what was apart there is bonded to nothing.
    pub began: Fit<D>,
    /// What else there is of a link.
    pub link: Link<D>,
    /// Where the forces of the problem count from, λ = offset + μ: minus what a whole joint bears in tension, the middle of what a
    /// bar bears.
    pub offset: Vec<f64>,
    /// By node, whether a joint has parted or slipped there.
    pub lost: Vec<bool>,
    /// How far the measured gaps are off because polygons stand for curves, at nodes of the nonmortar and of the mortar side.
    pub missed: [BTreeMap<usize, f64>; 2],
    /// What other contacts have of its nodes: see `shared.rs`.
    pub sharers: Vec<Sharer>,
    /// Its multipliers are finer than the softer side, which then need not tell their forces apart.
    pub finer: bool,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Displacements (nodes,) of the two sides of a contact at some moment; `None` of one that was not there.
///
/// Of the moment when the later one of two bodies appeared: it was fitted to the other one, so that gaps count from there,
/// g₀ + B u_a; and of the beginning of a stage.
#[derive(Debug, Clone)]
pub(crate) struct Fit<const D: usize> {
    /// Of the nonmortar body.
    pub own: Option<Arc<[Point<D>]>>,
    /// Of the mortar body; of an obstacle, which moves as one, a single one.
    pub other: Option<Arc<[Point<D>]>>,
}

impl<const D: usize> Default for Fit<D> {
    fn default() -> Self {
        Self {
            own: None,
            other: None,
        }
    }
}

impl<const D: usize> Fit<D> {
    /// B u_a of a row.
    pub fn along(&self, own: &Row<D>, other: &Row<D>) -> f64 {
        let product = |u: &Option<Arc<[Point<D>]>>, row: &Row<D>| -> f64 {
            let Some(u) = u else { return 0.0 };
            row.iter().map(|&(node, c)| dot(c, u[node])).sum()
        };
        product(&self.own, own) + product(&self.other, other)
    }

    /// Sum of the magnitudes of the parts of that: what it is a difference of.
    pub fn magnitude(&self, own: &Row<D>, other: &Row<D>) -> f64 {
        let parts = |u: &Option<Arc<[Point<D>]>>, row: &Row<D>| -> f64 {
            let Some(u) = u else { return 0.0 };
            row.iter().map(|&(node, c)| dot(c, u[node]).abs()).sum()
        };
        parts(&self.own, own) + parts(&self.other, other)
    }

    /// By how much the nonmortar side was ahead of the other one at a place, given by nodes and shape functions.
    pub fn jump(&self, own: &[(usize, f64)], other: &[(usize, f64)]) -> Point<D> {
        let at = |u: &Option<Arc<[Point<D>]>>, nodes: &[(usize, f64)]| {
            let Some(u) = u else { return [0.0; D] };
            nodes
                .iter()
                .fold([0.0; D], |sum, &(node, n)| add_scaled(sum, n, u[node]))
        };
        sub(at(&self.own, own), at(&self.other, other))
    }
}

impl<const D: usize> Paired<D> {
    /// Rows of a side and of nothing else that anybody has told.
    pub fn new(kind: Kind, name: String, nonmortar: SideRef, interface: Interface<D>) -> Self {
        Self {
            kind,
            name,
            nonmortar,
            mortar: None,
            opposite: None,
            obstacle_motion: [0.0; D],
            interface,
            samples: Vec::new(),
            left_out: Vec::new(),
            fit: Fit::default(),
            began: Fit::default(),
            link: Link::default(),
            offset: Vec::new(),
            lost: Vec::new(),
            missed: Default::default(),
            sharers: Vec::new(),
            finer: false,
            warnings: Vec::new(),
        }
    }

    /// As messages call it.
    pub fn called(&self) -> String {
        let kind = match self.kind {
            Kind::Contact => "contact",
            Kind::Couple(CoupleKind::Rigid) => "rigid couple",
            Kind::Couple(CoupleKind::Average) => "average couple",
            Kind::Bed(_) => return self.name.clone(),
            Kind::Bar(_) => "bar",
        };
        format!("{kind} \"{}\"", self.name)
    }

    /// It has an elastic part of its own.
    pub fn is_link(&self) -> bool {
        matches!(self.kind, Kind::Bed(_) | Kind::Bar(_))
    }

    /// All of the forces of its rows, of those of the problem (m,) in these.
    pub fn forces(&self, lambda: &[f64]) -> Vec<f64> {
        let offset = self.offset.iter().copied().chain(std::iter::repeat(0.0));
        let each = lambda.iter().zip(offset);
        each.map(|(l, offset)| l + offset).collect()
    }

    /// Whether the gap of each row is a slip: a force that is bounded does work on it, and it counts from step to step.
    pub fn slides(&self) -> Vec<bool> {
        match self.link.yields {
            true => vec![true; self.interface.nonmortar.len()],
            false => self.interface.tangential(),
        }
    }

    /// Where a node of its interface is, undeformed; `points` are those of the nonmortar body.
    pub fn place(&self, node: usize, points: &[Point<D>]) -> Point<D> {
        let own = self.link.places.get(node).copied();
        own.unwrap_or_else(|| points[self.interface.nodes[node].node])
    }

    /// The parts that its rows act on, and these.
    pub fn ends(&self) -> impl Iterator<Item = (usize, &[Row<D>])> {
        let own = (self.nonmortar.body.0, &self.interface.nonmortar[..]);
        let opposite = self.opposite.map(|part| (part, &self.interface.mortar[..]));
        let further = self.link.further.iter();
        let further = further.map(|(part, rows)| (*part, &rows[..]));
        std::iter::once(own).chain(opposite).chain(further)
    }

    /// This part of a contact and another one.
    pub fn followed_by(mut self, further: Self) -> Self {
        self.interface.append(further.interface);
        self.samples.extend(further.samples);
        for (missed, more) in self.missed.iter_mut().zip(further.missed) {
            for (node, more) in more {
                let most = missed.entry(node).or_default();
                *most = most.max(more);
            }
        }
        let new = further.warnings.into_iter();
        let new: Vec<String> = new
            .filter(|warning| !self.warnings.contains(warning))
            .collect();
        self.warnings.extend(new);
        self
    }

    /// Takes initial gaps for zero that are rounding of the coordinates they are differences of: sides that touch neither press nor
    /// part by that.
    pub fn settle(&mut self, points: &[Point<D>]) {
        let nodes = self.interface.nodes.iter();
        let coordinates = nodes.flat_map(|node| points[node.node]);
        let rounding = NO_GAP * coordinates.fold(0.0, |s: f64, x| s.max(x.abs()));
        self.interface.settle(rounding);
        let samples = self.samples.iter_mut().flatten();
        let none = samples.filter(|sample| sample.at.gap.abs() <= rounding);
        none.for_each(|sample| sample.at.gap = 0.0);
    }

    /// Leaves nodes out, and what lies between them and their neighbours.
    pub fn exclude(&mut self, out: &BTreeSet<usize>) {
        self.interface.exclude(out);
        for samples in &mut self.samples {
            let nodes = samples.iter().flat_map(|sample| &sample.at.own);
            if nodes.into_iter().any(|(node, _)| out.contains(node)) {
                self.left_out.append(samples);
            }
        }
    }

    /// A node whose condition has a coefficient that is not finite.
    pub fn unfit(&self) -> Option<usize> {
        let rows = self.interface.nonmortar.iter().zip(&self.interface.mortar);
        let fit = |(own, other): (&Row<D>, &Row<D>)| {
            let coefficients = own.iter().chain(other).flat_map(|(_, c)| c);
            coefficients.into_iter().all(|c| c.is_finite())
        };
        let row = rows.map(fit).position(|fit| !fit)?;
        let mut nodes = self.interface.nodes.iter();
        nodes
            .find(|node| node.rows.contains(&Some(row)))
            .map(|node| node.node)
    }

    /// g₀ of every row: the initial gap where the row is a normal one, plus the motion of the obstacle along the row.
    pub fn gaps(&self) -> Vec<f64> {
        let mut gaps = self.interface.gaps();
        let rows = self.interface.nonmortar.iter().zip(&self.interface.mortar);
        for (gap, (own, other)) in gaps.iter_mut().zip(rows) {
            *gap += self.fit.along(own, other);
        }
        let came_with = gaps.iter_mut().zip(&self.link.came_with);
        came_with.for_each(|(gap, came)| *gap += came);
        if self.mortar.is_none() {
            for (gap, row) in gaps.iter_mut().zip(&self.interface.mortar) {
                let along = row.iter().map(|(_, c)| dot(*c, self.obstacle_motion));
                *gap -= along.sum::<f64>();
            }
        }
        gaps
    }

    /// What the sides have moved along each other, or apart, since they were fitted to each other until the stage began, in a row:
    /// B (u − u_a).
    pub fn moved_before(&self, row: usize) -> f64 {
        let [own, other] =
            [&self.interface.nonmortar, &self.interface.mortar].map(|rows| &rows[row]);
        self.began.along(own, other) - self.fit.along(own, other)
    }
}

/// Prescribed displacement of the obstacle of a contact at a time; zero where it is free, or where there is none.
///
/// Errors: a displacement that is not finite.
pub(crate) fn obstacle_motion<const D: usize>(
    contact: &Contact<D>,
    time: f64,
) -> Result<Point<D>, Error<D>> {
    let mut motion = [0.0; D];
    let Pair::Obstacle { obstacle, .. } = &contact.pair else {
        return Ok(motion);
    };
    if let Motion::Prescribed(fields) = &obstacle.motion {
        for (component, field) in motion.iter_mut().zip(fields) {
            *component = field.at([0.0; D], time);
            if !component.is_finite() {
                return Err(Error::Obstacle {
                    contact: contact.name.clone(),
                    what: "displacement of",
                    field: field.clone(),
                });
            }
        }
    }
    Ok(motion)
}

/// Every contact, then every couple, with the range of its rows among those of all.
pub(crate) fn row_ranges<const D: usize>(
    paired: &[Paired<D>],
) -> impl Iterator<Item = (Range<usize>, &Paired<D>)> {
    let mut start = 0;
    paired.iter().map(move |pair| {
        let rows = start..start + pair.interface.nonmortar.len();
        start = rows.end;
        (rows, pair)
    })
}

/// The gaps g₀ of all multipliers; in tangential rows the motion of a rigid obstacle.
pub(crate) fn initial_gaps<const D: usize>(paired: &[Paired<D>]) -> Vec<f64> {
    paired.iter().flat_map(Paired::gaps).collect()
}

/// The same without shears: how far it is to what may hold a body; infinite in tangential rows, whose gap is a slip.
pub(crate) fn clearances<const D: usize>(paired: &[Paired<D>]) -> Vec<f64> {
    let of_pair = |pair: &Paired<D>| {
        let both = pair.gaps().into_iter().zip(pair.slides());
        let far = |(gap, slides)| match (pair.is_link(), slides) {
            // a link is there already
            (true, _) => 0.0,
            (false, true) => f64::INFINITY,
            (false, false) => gap,
        };
        both.map(far).collect::<Vec<_>>()
    };
    paired.iter().flat_map(of_pair).collect()
}

/// Contact or couple and undeformed position of every multiplier.
pub(crate) fn carriers<const D: usize>(
    model: &Model<D>,
    paired: &[Paired<D>],
) -> Vec<(usize, [f64; D])> {
    let each = paired.iter().enumerate().flat_map(|(contact, pair)| {
        let points = model.bodies[pair.nonmortar.body.0].mesh.points();
        let rows = |node: &InterfaceNode<D>| node.rows.iter().flatten().count();
        let carriers = pair.interface.nodes.iter().enumerate();
        let carriers = carriers.filter(|(_, node)| node.role == Role::Multiplier);
        carriers.flat_map(move |(k, node)| vec![(contact, pair.place(k, points)); rows(node)])
    });
    each.collect()
}

/// Whether g₀ of a contact may depend on time, be it by its gap or by the motion of its obstacle.
pub(crate) fn gap_varies<const D: usize>(contact: &Contact<D>) -> bool {
    let moved = match &contact.pair {
        Pair::Obstacle { obstacle, .. } => match &obstacle.motion {
            Motion::Prescribed(motion) => motion.iter().any(|c| c.as_constant().is_none()),
            Motion::Loaded(_) => false,
        },
        _ => false,
    };
    moved || varying_gap(contact).is_some()
}

/// What links have besides an interface between two parts.
#[derive(Debug, Clone)]
pub(crate) struct Link<const D: usize> {
    /// Rows on further bodies.
    pub further: Vec<(usize, Vec<Row<D>>)>,
    /// B u_a (m of the link,): what its rows came with.
    pub came_with: Vec<f64>,
    /// Forces at nodes of bodies while a bar is tightened: body, node, force.
    pub steady: Vec<(usize, usize, Point<D>)>,
    /// Stiffness of each dof of its part, (nodes of the part, D); 0 is held.
    pub stiffness: Vec<[f64; D]>,
    /// Load of its part.
    pub load: Vec<[f64; D]>,
    /// Bars in the thickness of the model.
    pub count: f64,
    /// Its gaps are plastic elongations: slips.
    pub yields: bool,
    /// Where its rows are, if not at nodes.
    pub places: Vec<Point<D>>,
}

impl<const D: usize> Default for Link<D> {
    fn default() -> Self {
        Self {
            further: Vec::new(),
            came_with: Vec::new(),
            steady: Vec::new(),
            stiffness: Vec::new(),
            load: Vec::new(),
            count: 1.0,
            yields: false,
            places: Vec::new(),
        }
    }
}

/// What a contact has of a node whose multiplier another one carries.
#[derive(Debug, Clone)]
pub(crate) struct Sharer {
    /// Place of the node in the interface that carries the multiplier.
    pub place: usize,
    /// The contact that has a part of it, and the place of the node there.
    pub at: (usize, usize),
    /// Weight and extent of its facets.
    pub weight: f64,
    pub extent: f64,
}

/// Gaps below this part of the coordinates are rounding.
pub(crate) const NO_GAP: f64 = 16.0 * f64::EPSILON;

/// The initial gap of a contact between its undeformed surfaces, where it is given and may depend on time.
pub(crate) fn varying_gap<const D: usize>(contact: &Contact<D>) -> Option<&Field> {
    let field = match (&contact.pair, &contact.gap) {
        (Pair::Obstacle { obstacle, .. }, _) => match &obstacle.shape {
            Rigid::Gap(field) => Some(field),
            Rigid::Surface { .. } => None,
        },
        (_, Some(Gap::Given(field))) => Some(field),
        _ => None,
    };
    field.filter(|field| field.as_constant().is_none())
}
