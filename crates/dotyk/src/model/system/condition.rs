//! Conditions: connections of two or more parts, each with rows of B on them, gaps, and admissible forces.
//!
//! ```text
//!   gap = g₀ − Σ B_part u_part,        λ = offset + μ,  μ ∈ Λ of its law
//! ```
//!
//! Contacts (`contact.rs`), what fills them (`gasket.rs`), couples (`couple.rs`), sectors (`cyclic.rs`), bolts (`bolt.rs`), and beds and
//! members (`links.rs`) are made in files of their own; all later code uses rows, gaps and laws only, and needs the source just to report
//! results.

use crate::contact::{Interface, InterfaceNode, Role, Row, Sample};
use crate::dual::Block;
use crate::fem::{CoupleKind, Turn};
use crate::geometry::{Field, Point, add_scaled, dot, sub};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::*;
use crate::model::system::filling::Filling;
use crate::model::system::parts::Owner;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// The source of a condition, by places in the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// A contact.
    Contact(usize),
    /// What has a part of its own: a couple, by its point, a bed or a member; a body that is a sector.
    Of(Owner),
}

impl Source {
    /// Its kind, in a word.
    pub fn kind<const D: usize>(self, model: &Model<D>) -> &'static str {
        match self {
            Self::Contact(_) => "contact",
            Self::Of(owner) => owner.kind(model),
        }
    }

    /// The kind of its couple.
    pub fn couple<const D: usize>(self, model: &Model<D>) -> Option<CoupleKind> {
        match self {
            Self::Of(Owner::Point(of, place)) => Some(model.bodies[of].couples[place].kind),
            _ => None,
        }
    }

    /// The place of its member, whose forces are told apart from those of contacts.
    pub fn member(self) -> Option<usize> {
        match self {
            Self::Of(Owner::Member(place)) => Some(place),
            Self::Contact(_)
            | Self::Of(
                Owner::Body(_)
                | Owner::Obstacle(_)
                | Owner::Point(..)
                | Owner::Gasket(_)
                | Owner::Bed(..),
            ) => None,
        }
    }
}

/// A connection of parts.
pub(crate) struct Condition<const D: usize> {
    /// Its source.
    pub source: Source,
    /// Its name; of a couple "BODY.POINT", of a bed "spring of BODY.SIDE", of a sector "cyclic symmetry of BODY".
    pub name: String,
    /// Side that carries the multipliers.
    pub nonmortar: SideRef,
    /// The other side; `None` for an obstacle, a point or a link.
    pub mortar: Option<SideRef>,
    /// The part on which the rows of `interface.mortar` act: a body, a free obstacle, a point, or the elastic part of a link.
    pub opposite: Option<usize>,
    /// Rows on further parts.
    pub further: Vec<(usize, Vec<Row<D>>)>,
    /// Rows, gaps and weights.
    pub interface: Interface<D>,
    /// The block of each of its nodes; `None`: any force. For contacts it follows from their law at a time (`admissible.rs`).
    pub law: Option<Block>,
    /// Offsets of the forces of the problem: minus the tensile strength of a whole joint, the middle of the force range of a member.
    pub offset: Vec<f64>,
    /// B u_a (m of the condition,), the displacements in the rows of a link when it came; empty for others.
    pub came_with: Vec<f64>,
    /// Forces at nodes of bodies besides those of rows, while a member is tightened: body, node, force.
    pub steady: Vec<(usize, usize, Point<D>)>,
    /// Its elastic part.
    pub elastic: Option<Elastic<D>>,
    /// Places of its rows, if not at nodes.
    pub places: Vec<Point<D>>,
    /// Further data of the sides of a contact.
    pub touch: Touch<D>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// The elastic part of a link, by nodes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Elastic<const D: usize> {
    /// Stiffness of each dof; a dof of stiffness 0 is held.
    pub stiffness: Vec<[f64; D]>,
    /// Load of each dof.
    pub load: Vec<[f64; D]>,
}

/// Data of the sides of a contact besides their rows.
pub(crate) struct Touch<const D: usize> {
    /// Prescribed displacement of the obstacle; zero where it is free.
    pub obstacle_motion: [f64; D],
    /// Points between the nodes with an opposite side, for each facet of the nonmortar side.
    pub samples: Vec<Vec<Sample<D>>>,
    /// Such points on facets with an excluded node: no condition keeps them apart.
    pub left_out: Vec<Sample<D>>,
    /// The displacements to which its sides were fitted.
    pub fit: Fit<D>,
    /// Displacements of its sides when its stage began: slip counts from there, and nodes that were open then are not bonded.
    pub began: Fit<D>,
    /// By node, whether a joint has parted or slipped there.
    pub lost: Vec<bool>,
    /// Errors of the measured gaps because polygons represent curves, at nodes of the nonmortar and of the mortar side.
    pub missed: [BTreeMap<usize, f64>; 2],
    /// Shares of other contacts in its nodes: see `shared.rs`.
    pub sharers: Vec<Sharer>,
    /// Nodes on the borders of a sector with one multiplier: see `border.rs`.
    pub twins: Vec<Twin<D>>,
    /// The gasket in it.
    pub filling: Option<Filling>,
    /// Its multipliers are finer than the softer side, which then may respond alike to different forces.
    pub finer: bool,
}

impl<const D: usize> Default for Touch<D> {
    fn default() -> Self {
        Self {
            obstacle_motion: [0.0; D],
            samples: Vec::new(),
            left_out: Vec::new(),
            fit: Fit::default(),
            began: Fit::default(),
            lost: Vec::new(),
            missed: Default::default(),
            sharers: Vec::new(),
            twins: Vec::new(),
            filling: None,
            finer: false,
        }
    }
}

/// Displacements (nodes,) of the two sides of a contact at some moment; `None` for an absent side.
///
/// Used for the moment when the later one of two bodies appeared (it was fitted to the other one, so that gaps count from there,
/// g₀ + B u_a), and for the beginning of a stage.
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

    /// Sum of the magnitudes of its terms.
    pub fn magnitude(&self, own: &Row<D>, other: &Row<D>) -> f64 {
        let parts = |u: &Option<Arc<[Point<D>]>>, row: &Row<D>| -> f64 {
            let Some(u) = u else { return 0.0 };
            row.iter().map(|&(node, c)| dot(c, u[node]).abs()).sum()
        };
        parts(&self.own, own) + parts(&self.other, other)
    }

    /// Displacement of the nonmortar side relative to the other one at a place, given by nodes and shape functions.
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

impl<const D: usize> Condition<D> {
    /// A condition with rows of a side, and defaults for all else.
    pub fn new(source: Source, name: String, nonmortar: SideRef, interface: Interface<D>) -> Self {
        Self {
            source,
            name,
            nonmortar,
            mortar: None,
            opposite: None,
            further: Vec::new(),
            interface,
            law: None,
            offset: Vec::new(),
            came_with: Vec::new(),
            steady: Vec::new(),
            elastic: None,
            places: Vec::new(),
            touch: Touch::default(),
            warnings: Vec::new(),
        }
    }

    /// Its name in messages.
    pub fn called(&self, model: &Model<D>) -> String {
        let kind = match (self.source, self.source.couple(model)) {
            (_, Some(CoupleKind::Rigid)) => "rigid couple",
            (_, Some(CoupleKind::Average)) => "average couple",
            (Source::Of(Owner::Bed(..) | Owner::Body(_)), None) => return self.name.clone(),
            (source, None) => source.kind(model),
        };
        format!("{kind} \"{}\"", self.name)
    }

    /// The index of its contact in the model.
    pub fn contact(&self) -> Option<usize> {
        match self.source {
            Source::Contact(index) => Some(index),
            _ => None,
        }
    }

    /// It is a link: not a contact, be there a gasket in it or not.
    pub fn is_link(&self) -> bool {
        self.elastic.is_some() && self.contact().is_none()
    }

    /// Removes the multipliers of rows: see [`Interface::drop_rows`].
    pub fn drop_rows(&mut self, rows: &[usize]) {
        let kept = self.interface.drop_rows(rows);
        for (_, rows) in &mut self.further {
            let mut kept = kept.iter();
            rows.retain(|_| kept.next() != Some(&false));
        }
    }

    /// That contact itself.
    pub fn contact_of<'a>(&self, model: &'a Model<D>) -> Option<&'a Contact<D>> {
        self.contact().map(|index| &model.contacts[index])
    }

    /// Full forces of its rows, offsets included, from those of the problem (m,) in these rows.
    pub fn forces(&self, lambda: &[f64]) -> Vec<f64> {
        let offset = self.offset.iter().copied().chain(std::iter::repeat(0.0));
        let each = lambda.iter().zip(offset);
        each.map(|(l, offset)| l + offset).collect()
    }

    /// Whether the gap of each row is a slip: a bounded force does work on it, and it is carried from step to step.
    pub fn slides(&self) -> Vec<bool> {
        match self.contact() {
            Some(_) => self.interface.tangential(),
            None => {
                let yields = matches!(self.law, Some(Block::Interval { .. }));
                vec![yields; self.interface.nonmortar.len()]
            }
        }
    }

    /// Undeformed position of a node of its interface; `points` are those of the nonmortar body.
    pub fn place(&self, node: usize, points: &[Point<D>]) -> Point<D> {
        let own = self.places.get(node).copied();
        own.unwrap_or_else(|| points[self.interface.nodes[node].node])
    }

    /// The parts that its rows act on, and these.
    pub fn ends(&self) -> impl Iterator<Item = (usize, &[Row<D>])> {
        let own = (self.nonmortar.body.0, &self.interface.nonmortar[..]);
        let opposite = self.opposite.map(|part| (part, &self.interface.mortar[..]));
        let further = self.further.iter();
        let further = further.map(|(part, rows)| (*part, &rows[..]));
        std::iter::once(own).chain(opposite).chain(further)
    }

    /// Joins this part of a contact with another part.
    pub fn followed_by(mut self, further: Self) -> Self {
        self.interface.append(further.interface);
        self.touch.samples.extend(further.touch.samples);
        for (missed, more) in self.touch.missed.iter_mut().zip(further.touch.missed) {
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

    /// Sets initial gaps to zero that are rounding of the coordinates, so that touching sides neither press nor part by rounding.
    pub fn settle(&mut self, points: &[Point<D>]) {
        let nodes = self.interface.nodes.iter();
        let coordinates = nodes.flat_map(|node| points[node.node]);
        let rounding = NO_GAP * coordinates.fold(0.0, |s: f64, x| s.max(x.abs()));
        self.interface.settle(rounding);
        let samples = self.touch.samples.iter_mut().flatten();
        let none = samples.filter(|sample| sample.at.gap.abs() <= rounding);
        none.for_each(|sample| sample.at.gap = 0.0);
    }

    /// Leaves nodes out, with the samples between them and their neighbours.
    pub fn exclude(&mut self, out: &BTreeSet<usize>) {
        self.interface.exclude(out);
        for samples in &mut self.touch.samples {
            let nodes = samples.iter().flat_map(|sample| &sample.at.own);
            if nodes.into_iter().any(|(node, _)| out.contains(node)) {
                self.touch.left_out.append(samples);
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
            *gap += self.touch.fit.along(own, other);
        }
        let came_with = gaps.iter_mut().zip(&self.came_with);
        came_with.for_each(|(gap, came)| *gap += came);
        if self.mortar.is_none() {
            for (gap, row) in gaps.iter_mut().zip(&self.interface.mortar) {
                let along = row.iter().map(|(_, c)| dot(*c, self.touch.obstacle_motion));
                *gap -= along.sum::<f64>();
            }
        }
        gaps
    }

    /// Relative motion of the sides in a row, from their fitting until the stage began: B (u − u_a).
    pub fn moved_before(&self, row: usize) -> f64 {
        let [own, other] =
            [&self.interface.nonmortar, &self.interface.mortar].map(|rows| &rows[row]);
        self.touch.began.along(own, other) - self.touch.fit.along(own, other)
    }
}

/// Prescribed displacement of the obstacle of a contact at a time; zero where it is free, or without an obstacle.
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

/// Every condition with the range of its rows among those of all.
pub(crate) fn row_ranges<const D: usize>(
    conditions: &[Condition<D>],
) -> impl Iterator<Item = (Range<usize>, &Condition<D>)> {
    let mut start = 0;
    conditions.iter().map(move |condition| {
        let rows = start..start + condition.interface.nonmortar.len();
        start = rows.end;
        (rows, condition)
    })
}

/// The contacts among the conditions, with their places and rows: other conditions have no sides that could overlap.
pub(crate) fn contact_rows<const D: usize>(
    conditions: &[Condition<D>],
) -> impl Iterator<Item = (usize, (Range<usize>, &Condition<D>))> {
    let all = row_ranges(conditions);
    all.filter_map(|(rows, condition)| Some((condition.contact()?, (rows, condition))))
}

/// The gaps g₀ of all multipliers; in tangential rows the motion of a rigid obstacle.
pub(crate) fn initial_gaps<const D: usize>(conditions: &[Condition<D>]) -> Vec<f64> {
    conditions.iter().flat_map(Condition::gaps).collect()
}

/// The same without shears: the distance to the contacts that may hold a body; infinite in tangential rows, whose gap is a slip.
pub(crate) fn clearances<const D: usize>(conditions: &[Condition<D>]) -> Vec<f64> {
    let of_condition = |condition: &Condition<D>| {
        if condition.is_link() {
            // wherever a link came, its play alone is between it and a force
            return condition.interface.gaps();
        }
        let gaps = condition.gaps().into_iter();
        let far = |(gap, slides)| if slides { f64::INFINITY } else { gap };
        gaps.zip(condition.slides()).map(far).collect()
    };
    conditions.iter().flat_map(of_condition).collect()
}

/// Contact or couple and undeformed position of every multiplier.
pub(crate) fn carriers<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
) -> Vec<(usize, [f64; D])> {
    let each = conditions
        .iter()
        .enumerate()
        .flat_map(|(contact, condition)| {
            let points = model.bodies[condition.nonmortar.body.0].mesh.points();
            let rows = |node: &InterfaceNode<D>| node.rows.iter().flatten().count();
            let carriers = condition.interface.nodes.iter().enumerate();
            let carriers = carriers.filter(|(_, node)| node.role == Role::Multiplier);
            carriers
                .flat_map(move |(k, node)| vec![(contact, condition.place(k, points)); rows(node)])
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

/// The share of a contact in a node whose multiplier another contact carries.
#[derive(Debug, Clone)]
pub(crate) struct Sharer {
    /// Place of the node in the interface that carries the multiplier.
    pub place: usize,
    /// The contact with this share, and the place of the node there.
    pub at: (usize, usize),
    /// Weight and extent of its facets.
    pub weight: f64,
    pub extent: f64,
}

/// Two nodes of a contact that are one place, see `border.rs`.
#[derive(Debug, Clone)]
pub(crate) struct Twin<const D: usize> {
    /// Places in the interface: of the node that carries the multiplier, and of the other one.
    pub places: [usize; 2],
    /// Takes the first to the second.
    pub turn: Turn<D>,
}

/// Gaps below this part of the coordinates are rounding.
pub(crate) const NO_GAP: f64 = 16.0 * f64::EPSILON;

/// The initial gap of a contact between its undeformed surfaces, where it is given and may depend on time.
pub(crate) fn varying_gap<const D: usize>(contact: &Contact<D>) -> Option<&Field> {
    let field = match (&contact.pair, &contact.gap) {
        (Pair::Obstacle { obstacle, .. }, _) => match &obstacle.shape {
            Rigid::Gap(field) => Some(field),
            Rigid::Surface { .. } | Rigid::Tool(_) => None,
        },
        (_, Some(Gap::Given(field))) => Some(field),
        _ => None,
    };
    field.filter(|field| field.as_constant().is_none())
}
