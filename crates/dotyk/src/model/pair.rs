//! Contacts as interfaces: which side carries the multipliers, and how the sides are coupled.

use crate::contact::{
    Against, ContactError, Coupling, Driven, End, InitialGap, Interface, Role, Sample,
    facets_coincide, pair_mortar, pair_nodes, pair_obstacle, sagitta, samples, smooth_parts,
    straight_turn, unmatched_facing,
};
use crate::dual::{AdmissibleSet, Block};
use crate::fem::{Constraints, FemError, Short, node_normals, show, side_facets};
use crate::geometry::{Field, dot};
use crate::mesh::Facet;
use crate::model::error::Error;
use crate::model::nouns::*;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Bodies whose stiffness differs by more than this factor, ten but for rounding, are soft and stiff; within it the finer
/// side carries the multipliers, unless it would show the facets of the other.
const SOFTER: f64 = 10.0 * (1.0 + 1e-9);

/// The displacement of straight facets of length H has kinks, which the pressures of a finer side with facets of length h
/// answer: by its relative stiffness times ln(H/h), a few per cent where this is above the following.
const SHOWS: f64 = 1.6;

/// Around a curve, where they turn by θ, the pressures of the finer side oscillate by about this times θ ln(H/h) (measured
/// on rings, 16 to 40 facets on a quarter of the circle, h = H/5 to H/2), times its relative stiffness if above 1.
const KINKS: f64 = 0.19;

/// Largest part of their mean by which they may.
const VISIBLE: f64 = 0.02;

/// Sides whose edges differ by less than this factor are equally fine.
const ALIKE: f64 = 1.05;

/// One contact of the model, paired.
pub(crate) struct Paired<const D: usize> {
    /// Side that carries the multipliers.
    pub nonmortar: SideRef,
    /// The other side; `None` for an obstacle.
    pub mortar: Option<SideRef>,
    /// The part that the rows of `interface.mortar` act on: a body, or a free obstacle.
    pub opposite: Option<usize>,
    /// Prescribed displacement of the obstacle; zero where it is free.
    pub obstacle_motion: [f64; D],
    /// Rows, gaps and weights.
    pub interface: Interface<D>,
    /// Points between the nodes that face something, for each facet of the nonmortar side.
    pub samples: Vec<Vec<Sample<D>>>,
    /// How far the measured gaps are off because polygons stand for curves.
    pub sagitta: f64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Pairs all contacts, with the gaps at a time.
pub(crate) fn pair_all<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    time: f64,
) -> Result<Vec<Paired<D>>, Error<D>> {
    let contacting = |contact| Contacting {
        model,
        constraints,
        contact,
        time,
    };
    let contacts = model.contacts.par_iter();
    contacts.map(|contact| contacting(contact).pair()).collect()
}

impl<const D: usize> Paired<D> {
    /// This part of a contact and another one.
    fn followed_by(mut self, further: Self) -> Self {
        self.interface.append(further.interface);
        self.samples.extend(further.samples);
        self.sagitta = self.sagitta.max(further.sagitta);
        let new = further.warnings.into_iter();
        let new: Vec<String> = new
            .filter(|warning| !self.warnings.contains(warning))
            .collect();
        self.warnings.extend(new);
        self
    }

    /// g₀ of every row: the initial gap where the row is a normal one, plus the motion of the obstacle along the row.
    pub fn gaps(&self) -> Vec<f64> {
        let mut gaps = self.interface.gaps();
        if self.mortar.is_none() {
            for (gap, row) in gaps.iter_mut().zip(&self.interface.mortar) {
                let along = row.iter().map(|(_, c)| dot(*c, self.obstacle_motion));
                *gap -= along.sum::<f64>();
            }
        }
        gaps
    }
}

/// The same pairs with the gaps and the motion of obstacles at another time; rows, weights and roles stay.
pub(crate) fn gaps_at<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    paired: Vec<Paired<D>>,
    time: f64,
) -> Result<Vec<Paired<D>>, Error<D>> {
    let at_time = |(contact, mut before): (&Contact<D>, Paired<D>)| {
        let contacting = Contacting {
            model,
            constraints,
            contact,
            time,
        };
        if let Pair::Obstacle { obstacle, .. } = &contact.pair {
            before.obstacle_motion = contacting.motion(obstacle)?;
        }
        if shape_varies(contact) {
            let now = contacting.pair()?;
            let nodes = before.interface.nodes.iter_mut();
            nodes.zip(now.interface.nodes).for_each(|(node, now)| {
                (node.gap, node.clearance) = (now.gap, now.clearance);
            });
            before.samples = now.samples;
        }
        Ok(before)
    };
    let both = model.contacts.par_iter().zip(paired);
    both.map(at_time).collect()
}

/// Whether the initial gap of a contact between its undeformed surfaces may depend on time.
fn shape_varies<const D: usize>(contact: &Contact<D>) -> bool {
    let field = match (&contact.pair, &contact.gap) {
        (Pair::Obstacle { obstacle, .. }, _) => match &obstacle.shape {
            Rigid::Gap(field) => Some(field),
            Rigid::Surface { .. } => None,
        },
        (_, Some(Gap::Given(field))) => Some(field),
        _ => None,
    };
    field.is_some_and(|field| field.as_constant().is_none())
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
    moved || shape_varies(contact)
}

/// Λ of all contacts at a time, in the order of their rows.
///
/// Errors: a coefficient or bound of friction that is negative or not finite.
pub(crate) fn admissible_set<const D: usize>(
    model: &Model<D>,
    paired: &[Paired<D>],
    time: f64,
) -> Result<AdmissibleSet, Error<D>> {
    let mut blocks = Vec::new();
    for (contact, pair) in model.contacts.iter().zip(paired) {
        let points = model.bodies[pair.nonmortar.body.0].mesh.points();
        for node in pair.interface.carriers() {
            let size = node.rows.iter().flatten().count();
            let value = |field: &Field| friction_at(contact, pair, field, points[node.node], time);
            let tangents = size.saturating_sub(1);
            blocks.push(match &contact.law {
                Law::Tied => Block::Free { size },
                Law::Coulomb(field) if tangents > 0 => Block::Coulomb {
                    tangents,
                    coefficient: value(field)?,
                },
                Law::Tresca(field) if tangents > 0 => Block::Tresca {
                    tangents,
                    bound: value(field)? * node.weight,
                },
                _ => Block::Unilateral,
            });
        }
    }
    Ok(AdmissibleSet::new(blocks))
}

/// Pairs of blocks of [`admissible_set`] whose nodes share a facet.
pub(crate) fn neighbours<const D: usize>(
    model: &Model<D>,
    paired: &[Paired<D>],
) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    let mut first = 0;
    for pair in paired {
        let carriers = pair.interface.carriers().enumerate();
        let block: BTreeMap<usize, usize> = carriers.map(|(k, n)| (n.node, first + k)).collect();
        first += block.len();
        let mesh = &model.bodies[pair.nonmortar.body.0].mesh;
        for &facet in mesh.side(&pair.nonmortar.side).unwrap_or_default() {
            // middle nodes lie between the corners: in the plane a facet is a chain of its nodes
            let mut nodes: Vec<usize> = mesh.facet_nodes(facet).map(|n| n as usize).collect();
            if let [_, _, middle] = nodes[..] {
                nodes.swap(1, 2);
                nodes[1] = middle;
            }
            let ends = nodes.windows(2).filter_map(|pair| {
                let [a, b] = [block.get(&pair[0])?, block.get(&pair[1])?];
                Some([*a.min(b), *a.max(b)])
            });
            pairs.extend(ends);
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Coefficient or bound of friction at a point.
fn friction_at<const D: usize>(
    contact: &Contact<D>,
    pair: &Paired<D>,
    field: &Field,
    point: [f64; D],
    time: f64,
) -> Result<f64, Error<D>> {
    let value = field.at(point, time);
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(Error::Contact {
        contact: contact.name.clone(),
        source: ContactError::Friction {
            side: pair.nonmortar.side.clone(),
            text: field.to_string(),
            point: show(point),
            value,
        },
    })
}

/// The largest initial gap at nodes and between them, if all are within a bound and not all are rounding of it.
fn all_within<const D: usize>(
    bound: f64,
    interface: &Interface<D>,
    samples: &[Vec<Sample<D>>],
) -> Option<f64> {
    let nodes = interface.nodes.iter().filter(|node| !node.gap.is_nan());
    // the gap of a row is a mean with functions of both signs: it may be larger than any single gap
    let at_nodes = nodes.map(|node| node.clearance);
    let gaps = at_nodes.chain(samples.iter().flatten().map(|s| s.gap));
    let largest = gaps.fold(0.0, |s: f64, gap| s.max(gap.abs()));
    (largest <= bound && largest > 1e-9 * bound).then_some(largest)
}

/// What moves an obstacle.
fn driven<const D: usize>(obstacle: &Obstacle<D>) -> Driven {
    let still = |field: &Field| field.as_constant() == Some(0.0);
    match &obstacle.motion {
        Motion::Loaded(_) => Driven::Free,
        Motion::Prescribed(motion) if motion.iter().all(still) => Driven::Still,
        Motion::Prescribed(_) => Driven::Prescribed,
    }
}

/// What a side may touch.
enum Opposite<'a, const D: usize> {
    Side(&'a SideRef),
    Rigid(&'a Obstacle<D>),
}

/// One contact on its way to becoming an interface.
struct Contacting<'a, const D: usize> {
    model: &'a Model<D>,
    constraints: &'a [&'a Constraints<D>],
    contact: &'a Contact<D>,
    time: f64,
}

impl<'a, const D: usize> Contacting<'a, D> {
    fn pair(&self) -> Result<Paired<D>, Error<D>> {
        let fail = |source| self.fail(source);
        let coupling = match &self.contact.law {
            Law::Frictionless => Coupling::Normal,
            Law::Tied => Coupling::Tied,
            Law::Coulomb(_) | Law::Tresca(_) => Coupling::Frictional,
        };
        let (nonmortar, opposite) = match &self.contact.pair {
            Pair::Obstacle {
                nonmortar,
                obstacle,
            } => (nonmortar, Opposite::Rigid(obstacle)),
            Pair::Given { nonmortar, mortar } => (nonmortar, Opposite::Side(mortar)),
            Pair::Automatic(sides) => {
                let [nonmortar, mortar] = self.choose(sides).map_err(fail)?;
                (nonmortar, Opposite::Side(mortar))
            }
        };
        let whole = self.end(nonmortar);
        // a tie holds both faces of a corner by one condition
        let parts = match coupling {
            Coupling::Tied => vec![facets(whole).map_err(fail)?.to_vec()],
            _ => smooth_parts(whole).map_err(fail)?,
        };
        let pair = |part: &Vec<Facet>| {
            let end = End {
                part: (parts.len() > 1).then_some(part.as_slice()),
                ..whole
            };
            match opposite {
                Opposite::Rigid(obstacle) => self.above(nonmortar, end, obstacle, coupling),
                Opposite::Side(mortar) => {
                    let sides = self.sides([nonmortar, mortar], end, coupling);
                    sides.map_err(fail)
                }
            }
        };
        let mut paired = pair(&parts[0])?;
        for part in &parts[1..] {
            paired = paired.followed_by(pair(part)?);
        }
        Ok(paired)
    }

    fn fail(&self, source: ContactError) -> Error<D> {
        Error::Contact {
            contact: self.contact.name.clone(),
            source,
        }
    }

    fn end(&self, side: &'a SideRef) -> End<'a, D> {
        End {
            body: &self.model.bodies[side.body.0],
            side: &side.side,
            constraints: self.constraints[side.body.0],
            part: None,
        }
    }

    fn samples(
        &self,
        nonmortar: End<'_, D>,
        against: Against<'_, D>,
        gap: InitialGap<'_>,
    ) -> Result<Vec<Vec<Sample<D>>>, ContactError> {
        samples(nonmortar, against, gap, self.model.analysis, self.time)
    }

    /// A side, or a part of it, above an obstacle.
    fn above(
        &self,
        nonmortar: &SideRef,
        end: End<'_, D>,
        obstacle: &Obstacle<D>,
        coupling: Coupling,
    ) -> Result<Paired<D>, Error<D>> {
        let against = Against::Obstacle(&obstacle.shape, driven(obstacle));
        let interface = self.obstacle(end, obstacle, coupling);
        let samples = self.samples(end, against, InitialGap::Measured);
        Ok(Paired {
            nonmortar: nonmortar.clone(),
            mortar: None,
            opposite: self.model.obstacle_part(self.contact),
            obstacle_motion: self.motion(obstacle)?,
            interface: interface.map_err(|source| self.fail(source))?,
            samples: samples.map_err(|source| self.fail(source))?,
            sagitta: 0.0,
            warnings: Vec::new(),
        })
    }

    /// Prescribed displacement of an obstacle; zero when it is free.
    fn motion(&self, obstacle: &Obstacle<D>) -> Result<[f64; D], Error<D>> {
        let mut motion = [0.0; D];
        if let Motion::Prescribed(fields) = &obstacle.motion {
            for (component, field) in motion.iter_mut().zip(fields) {
                *component = field.at([0.0; D], self.time);
                if !component.is_finite() {
                    return Err(Error::Model(format!(
                        "contact \"{}\": the displacement of the obstacle, {field}, is not finite",
                        self.contact.name
                    )));
                }
            }
        }
        Ok(motion)
    }

    fn obstacle(
        &self,
        end: End<'_, D>,
        obstacle: &Obstacle<D>,
        coupling: Coupling,
    ) -> Result<Interface<D>, ContactError> {
        let driven = driven(obstacle);
        let (analysis, time) = (self.model.analysis, self.time);
        let nodal = || pair_obstacle(end, (&obstacle.shape, driven), coupling, analysis, time);
        let integrated = || {
            let against = Against::Obstacle(&obstacle.shape, driven);
            pair_mortar(end, against, InitialGap::Measured, coupling, analysis, time)
        };
        match self.contact.pairing {
            Some(Pairing::NodeToNode) => nodal(),
            Some(Pairing::Mortar) => integrated(),
            None => match nodal() {
                Err(ContactError::Weight { .. }) => integrated(),
                other => other,
            },
        }
    }

    /// A side, or a part of it, and a mortar side.
    fn sides(
        &self,
        [nonmortar, mortar]: [&'a SideRef; 2],
        end: End<'_, D>,
        coupling: Coupling,
    ) -> Result<Paired<D>, ContactError> {
        let ends = [end, self.end(mortar)];
        let conforming = self.conforming(ends, coupling)?;
        let against = Against::Side(ends[1]);
        let gap = self.gap(match (&conforming, coupling) {
            (None, Coupling::Normal | Coupling::Frictional) => InitialGap::Measured,
            _ => InitialGap::Closed,
        });
        let mut interface = match conforming {
            Some(interface) => interface,
            None => pair_mortar(
                ends[0],
                against,
                gap,
                coupling,
                self.model.analysis,
                self.time,
            )?,
        };
        let mut samples = self.samples(end, against, gap)?;
        let measured = match &self.contact.gap {
            None => coupling != Coupling::Tied,
            Some(gap) => matches!(gap, Gap::Geometric),
        };
        let mut warnings = Vec::new();
        let mut partners = interface.nodes.iter().filter(|n| n.role != Role::Alone);
        let matching = partners.all(|n| n.partner().is_some());
        let mut crude = 0.0;
        if measured && !matching {
            let missed = [sagitta(ends[0])?, sagitta(ends[1])?];
            crude = missed[0].max(missed[1]);
            if let Some(largest) = all_within(missed[0] + missed[1], &interface, &samples) {
                interface.close();
                samples.iter_mut().flatten().for_each(|s| s.gap = 0.0);
                crude = 0.0;
                warnings.push(format!(
                    "contact \"{}\": all initial gaps lie within {} of zero, which is less than what the meshes miss of the curves that they stand for ({}): they count as closed; set gap = \"closed\" to say so, or give the true `surface` of both sides",
                    self.contact.name,
                    Short(largest),
                    Short(missed[0] + missed[1])
                ));
            }
        }
        if !matching
            && self.stiffness(mortar) * SOFTER < self.stiffness(nonmortar)
            && self.mean_edge(nonmortar)? < 0.99 * self.mean_edge(mortar)?
        {
            warnings.push(format!(
                "contact \"{}\": multipliers finer than the softer side, pressures may oscillate; swap nonmortar and mortar",
                self.contact.name
            ));
        }
        Ok(Paired {
            nonmortar: nonmortar.clone(),
            mortar: Some(mortar.clone()),
            opposite: Some(mortar.body.0),
            obstacle_motion: [0.0; D],
            interface,
            samples,
            sagitta: crude,
            warnings,
        })
    }

    /// The interface of coincident nodes, where that is what is wanted and possible: a partial overlap of matching sides is
    /// legal, and so are sides that do not face each other at all.
    fn conforming(
        &self,
        ends: [End<'_, D>; 2],
        coupling: Coupling,
    ) -> Result<Option<Interface<D>>, ContactError> {
        let [nonmortar, mortar] = ends;
        let nodal = || {
            let gap = self.gap(InitialGap::Closed);
            let (analysis, time) = (self.model.analysis, self.time);
            pair_nodes(nonmortar, mortar, gap, coupling, analysis, time)
        };
        match (self.contact.pairing, unmatched_facing(nonmortar, mortar)?) {
            (Some(Pairing::Mortar), _) | (None, Some(_)) => Ok(None),
            (Some(Pairing::NodeToNode), None) => nodal().map(Some),
            (Some(Pairing::NodeToNode), Some(unmatched)) => {
                let (own, other) = match unmatched.of_mortar {
                    true => (mortar, nonmortar),
                    false => (nonmortar, mortar),
                };
                Err(ContactError::Unpaired {
                    side: own.name(),
                    other: other.name(),
                    node: unmatched.node,
                    point: show(unmatched.point),
                    distance: unmatched.distance,
                })
            }
            (None, None) if !facets_coincide(nonmortar, mortar)? => Ok(None),
            (None, None) => match nodal() {
                Err(ContactError::Weight { .. }) => Ok(None),
                other => other.map(Some),
            },
        }
    }

    fn gap(&self, default: InitialGap<'a>) -> InitialGap<'a> {
        match &self.contact.gap {
            None => default,
            Some(Gap::Closed) => InitialGap::Closed,
            Some(Gap::Geometric) => InitialGap::Measured,
            Some(Gap::Given(field)) => InitialGap::Given(field),
        }
    }

    /// The more compliant body carries the multipliers; within a factor 10 the finer side, unless that would show the
    /// straight facets of the other. A side that supports hold altogether cannot carry them.
    fn choose(&self, [a, b]: &'a [SideRef; 2]) -> Result<[&'a SideRef; 2], ContactError> {
        let stiff = [self.stiffness(a), self.stiffness(b)];
        let held = [self.held(a)?, self.held(b)?];
        let edge = [self.mean_edge(a)?, self.mean_edge(b)?];
        let (fine, coarse) = if edge[0] <= edge[1] { (0, 1) } else { (1, 0) };
        let first = if held[0] != held[1] {
            usize::from(held[0])
        } else if stiff[0].max(stiff[1]) > SOFTER * stiff[0].min(stiff[1]) {
            usize::from(stiff[1] < stiff[0])
        } else if edge[coarse] < ALIKE * edge[fine] {
            fine
        } else {
            let turn = straight_turn(self.end([a, b][coarse]))?;
            let stiffer = stiff[fine] / stiff[coarse];
            let finer = (edge[coarse] / edge[fine]).ln();
            let shown = |turn: f64| {
                stiffer * finer > SHOWS || KINKS * turn * finer * stiffer.max(1.0) > VISIBLE
            };
            if turn.is_some_and(shown) {
                coarse
            } else {
                fine
            }
        };
        Ok(if first == 0 { [a, b] } else { [b, a] })
    }

    /// Smallest plane modulus E/(1 − ν²) of the cells at a side: what pressures that change from node to node feel.
    fn stiffness(&self, side: &SideRef) -> f64 {
        let body = &self.model.bodies[side.body.0];
        let facets = body.mesh.side(&side.side).unwrap_or_default();
        let blocks = facets
            .iter()
            .map(|facet| &body.mesh.blocks()[facet.block as usize]);
        let elastic = blocks.filter_map(|block| body.elastic(block).ok());
        elastic
            .map(|e| e.plane_modulus())
            .fold(f64::INFINITY, f64::min)
    }

    /// Supports hold the normal displacement of every node of the side.
    fn held(&self, side: &'a SideRef) -> Result<bool, ContactError> {
        let end = self.end(side);
        let normals = node_normals(&end.body.mesh, facets(end)?);
        Ok(normals.iter().all(|(&node, &normal)| {
            let held = end.constraints.at(node).iter();
            let rest: f64 = 1.0 - held.map(|h| dot(h.axis, normal).powi(2)).sum::<f64>();
            rest < 1e-12
        }))
    }

    fn mean_edge(&self, side: &'a SideRef) -> Result<f64, ContactError> {
        let end = self.end(side);
        let mesh = &end.body.mesh;
        let facets = facets(end)?;
        // between neighbouring nodes: a quadratic facet counts as two
        let count: usize = facets
            .iter()
            .map(|&facet| mesh.facet_kind(facet).order())
            .sum();
        let total: f64 = facets.iter().map(|&facet| mesh.facet_length(facet)).sum();
        Ok(total / count as f64)
    }
}

fn facets<'a, const D: usize>(end: End<'a, D>) -> Result<&'a [crate::mesh::Facet], ContactError> {
    side_facets(&end.body.mesh, end.side).map_err(|source: FemError| ContactError::Side {
        body: end.body.name.clone(),
        source,
    })
}
