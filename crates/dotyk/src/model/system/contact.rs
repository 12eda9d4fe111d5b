//! Contacts as conditions: how their sides are coupled, and the gaps of their rows at a time.

use crate::contact::{
    Against, ContactError, Corners, Coupling, Driven, End, GapPoint, InitialGap, Interface, Role,
    Sample, check_sectors, corners_above, facets_coincide, missed_by_nodes, pair_mortar,
    pair_nodes, pair_obstacle, samples, smooth_parts, taking_part, unmatched_facing,
};
use crate::fem::{Constraints, Place, Short, describe, show};
use crate::geometry::Field;
use crate::mesh::Facet;
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::*;
use crate::model::system::choose::{chosen, either_may, finer_than_softer};
use crate::model::system::condition::{Condition, Source, Touch, obstacle_motion, varying_gap};
use crate::model::system::parts::{Owner, Parts};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The condition of a contact, by its place, at a time.
///
/// Errors: sides that cannot be paired.
pub(crate) fn touching<const D: usize>(
    (model, parts): (&Model<D>, &Parts),
    constraints: &[&Constraints<D>],
    index: usize,
    time: f64,
) -> Result<Condition<D>, Error<D>> {
    let contacting = Contacting {
        model,
        constraints,
        contact: &model.contacts[index],
        at: (index, parts.find(Owner::Obstacle(index))),
        time,
    };
    contacting.prepare_gap();
    contacting.pair()
}

/// Gives a contact its gaps and the motion of its obstacle at another time; rows, weights and roles stay.
///
/// Errors: those of evaluating them.
pub(crate) fn contact_gaps<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    (index, condition): (usize, &mut Condition<D>),
    time: f64,
) -> Result<(), Error<D>> {
    let contact = &model.contacts[index];
    condition.touch.obstacle_motion = obstacle_motion(contact, time)?;
    let Some(field) = varying_gap(contact) else {
        return Ok(());
    };
    let contacting = Contacting {
        model,
        constraints,
        contact,
        at: (index, condition.opposite),
        time,
    };
    let side = condition.nonmortar.clone();
    let end = contacting.end(&side);
    let fail = |source| contacting.fail(source);
    let points = end.body.mesh.points();
    let touch = &mut condition.touch;
    let samples = touch.samples.iter().flatten().chain(&touch.left_out);
    let seen = condition.interface.points.iter();
    let seen = seen.chain(samples.map(|sample| &sample.at));
    let seen = seen.map(|point| point.place(points));
    Field::prepare([field], seen, time);
    let gap = |point: &GapPoint<D>| point.given(field, end, time);
    condition.interface.measure(gap).map_err(fail)?;
    let samples = touch.samples.iter_mut().flatten();
    for sample in samples.chain(&mut touch.left_out) {
        sample.at.gap = gap(&sample.at).map_err(fail)?;
    }
    Ok(())
}

/// Gaps below this part of the meshes' distance from their curves are rounding: the contact is closed, without a remark.
const CLOSED: f64 = 1e-9;

/// Gaps of one place differ by less than this part of the largest one.
const UNLIKE: f64 = 1e-3;

/// The largest initial gap at nodes and between them, if all are within a bound and not all are rounding of it.
fn all_within<const D: usize>(
    bound: f64,
    interface: &Interface<D>,
    samples: &[Vec<Sample<D>>],
) -> Option<f64> {
    let nodes = interface.nodes.iter().filter(|node| !node.gap.is_nan());
    // the gap of a row is a mean with functions of both signs: it may be larger than any single gap
    let at_nodes = nodes.map(|node| node.clearance);
    let gaps = at_nodes.chain(samples.iter().flatten().map(|s| s.at.gap));
    let largest = gaps.fold(0.0, |s: f64, gap| s.max(gap.abs()));
    (largest <= bound && largest > CLOSED * bound).then_some(largest)
}

/// The drive of an obstacle.
fn driven<const D: usize>(obstacle: &Obstacle<D>) -> Driven {
    let still = |field: &Field| field.as_constant() == Some(0.0);
    match &obstacle.motion {
        Motion::Loaded(_) => Driven::Free,
        Motion::Prescribed(motion) if motion.iter().all(still) => Driven::Still,
        Motion::Prescribed(_) => Driven::Prescribed,
    }
}

/// The opposite of a side.
enum Counterpart<'a, const D: usize> {
    Side(&'a SideRef),
    Rigid(&'a Obstacle<D>),
}

/// One contact on its way to becoming an interface.
struct Contacting<'a, const D: usize> {
    model: &'a Model<D>,
    constraints: &'a [&'a Constraints<D>],
    contact: &'a Contact<D>,
    /// Its place, and the part of its obstacle, if it is a part.
    at: (usize, Option<usize>),
    time: f64,
}

impl<'a, const D: usize> Contacting<'a, D> {
    fn pair(&self) -> Result<Condition<D>, Error<D>> {
        let coupling = self.contact.law.coupling();
        let (nonmortar, opposite) = match &self.contact.pair {
            Pair::Obstacle {
                nonmortar,
                obstacle,
            } => (nonmortar, Counterpart::Rigid(obstacle)),
            Pair::Given { nonmortar, mortar } => (nonmortar, Counterpart::Side(mortar)),
            Pair::Automatic(sides) => return self.chosen(sides, coupling),
        };
        self.paired(nonmortar, opposite, coupling)
    }

    /// Pairs with the chosen one of two sides as the nonmortar side, or with the other if that is as good and has no slivers.
    fn chosen(
        &self,
        sides: &'a [SideRef; 2],
        coupling: Coupling,
    ) -> Result<Condition<D>, Error<D>> {
        let ends = sides.each_ref().map(|side| self.end(side));
        let first = chosen(ends).map_err(|source| self.fail(source))?;
        let with = |first: usize| {
            let opposite = Counterpart::Side(&sides[1 - first]);
            self.paired(&sides[first], opposite, coupling)
        };
        let paired = with(first)?;
        let slivers = |paired: &Condition<D>| paired.interface.nodes.iter().any(|n| n.is_sliver());
        let either = || either_may(ends).map_err(|source| self.fail(source));
        if !slivers(&paired) || !either()? {
            return Ok(paired);
        }
        // if the other side cannot be paired, this one is used
        match with(1 - first) {
            Ok(other) if !slivers(&other) => Ok(other),
            _ => Ok(paired),
        }
    }

    /// The interface of a side and its opposite.
    fn paired(
        &self,
        nonmortar: &'a SideRef,
        opposite: Counterpart<'a, D>,
        coupling: Coupling,
    ) -> Result<Condition<D>, Error<D>> {
        let fail = |source| self.fail(source);
        let whole = self.end(nonmortar);
        let near = self.near(whole, &opposite).map_err(fail)?;
        let [own, far] = near.as_ref().map_or([None; 2], |both| {
            both.each_ref().map(|facets| Some(facets.as_slice()))
        });
        let whole = End { part: own, ..whole };
        // a tie holds both faces of a corner by one condition
        let parts = match coupling {
            Coupling::Tied => vec![whole.facets().map_err(fail)?.to_vec()],
            _ => smooth_parts(whole).map_err(fail)?,
        };
        let corners = match opposite {
            Counterpart::Rigid(obstacle) if coupling != Coupling::Tied => {
                corners_above(whole, &obstacle.shape, self.model.analysis).map_err(fail)?
            }
            _ => Corners::new(),
        };
        let pair = |part: &Vec<Facet>| {
            let end = End {
                part: (parts.len() > 1 || near.is_some()).then_some(part.as_slice()),
                ..whole
            };
            match opposite {
                Counterpart::Rigid(obstacle) => {
                    self.above(nonmortar, end, (obstacle, &corners), coupling)
                }
                Counterpart::Side(mortar) => {
                    let other = End {
                        part: far,
                        ..self.end(mortar)
                    };
                    check_sectors([end, other]).map_err(fail)?;
                    let sides = self.sides([nonmortar, mortar], [end, other], coupling);
                    sides.map_err(fail)
                }
            }
        };
        let mut paired = pair(&parts[0])?;
        for part in &parts[1..] {
            paired = paired.followed_by(pair(part)?);
        }
        paired.settle(whole.body.mesh.points());
        paired.warnings.extend(self.unintegrated(&paired.interface));
        paired
            .warnings
            .extend(self.unlike_gaps(&paired.interface, whole));
        let [out, smooth] = [&self.contact.exclude, &self.contact.friction_exclude];
        for place in out.iter().chain(smooth) {
            self.carrier_at(whole, &paired.interface, place)
                .map_err(fail)?;
        }
        if !out.is_empty() {
            let out = whole.nodes_at(out).map_err(fail)?;
            paired.exclude(&whole.body.with_twins(out));
        }
        if coupling == Coupling::Frictional && !smooth.is_empty() {
            let smooth = whole.nodes_at(smooth).map_err(fail)?;
            paired.interface.smooth(&whole.body.with_twins(smooth));
        }
        match paired.unfit() {
            None => Ok(paired),
            Some(node) => Err(Error::Unfit {
                contact: self.contact.name.clone(),
                node,
                point: whole.body.mesh.points()[node],
            }),
        }
    }

    /// The facets of a side and of its mortar side that take part, where these are not all.
    fn near(
        &self,
        end: End<'_, D>,
        opposite: &Counterpart<'a, D>,
    ) -> Result<Option<[Vec<Facet>; 2]>, ContactError> {
        let Counterpart::Side(mortar) = opposite else {
            return Ok(None);
        };
        let ends = [end, self.end(mortar)];
        let bodies = self.model.bodies.iter();
        let others = bodies.filter(|body| ends.iter().all(|end| end.body.name != body.name));
        let others = others.map(|body| (body.name.as_str(), &*body.mesh));
        taking_part(ends, self.contact.reach, others)
    }

    /// Evaluates a sampled gap at all places where it is needed: a trial pairing with a recording field finds them.
    fn prepare_gap(&self) {
        let Some(field) = varying_gap(self.contact).filter(|gap| gap.is_sampled()) else {
            return;
        };
        let seen: Arc<Mutex<Vec<[f64; 3]>>> = Arc::default();
        let sees = Arc::clone(&seen);
        let closed = Field::function("0", move |point, _| {
            sees.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(point);
            0.0
        });
        let mut contact = self.contact.clone();
        match (&mut contact.pair, &mut contact.gap) {
            (Pair::Obstacle { obstacle, .. }, _) => obstacle.shape = Rigid::Gap(closed),
            (_, gap) => *gap = Some(Gap::Given(closed)),
        }
        let stand_in = Contacting {
            contact: &contact,
            ..*self
        };
        // errors are reported when the contact itself is paired
        let _ = stand_in.pair();
        let mut seen = std::mem::take(&mut *seen.lock().unwrap_or_else(PoisonError::into_inner));
        seen.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
        Field::prepare([field], seen, self.time);
    }

    /// Errors: a place of nodes none of which can carry a multiplier.
    fn carrier_at(
        &self,
        side: End<'_, D>,
        interface: &Interface<D>,
        place: &Place<D>,
    ) -> Result<(), ContactError> {
        let found = side.nodes_at(std::slice::from_ref(place))?;
        let mut carriers = interface.nodes.iter();
        match carriers.any(|node| found.contains(&node.node)) {
            true => Ok(()),
            false => Err(ContactError::NoCarrier {
                side: side.name(),
                place: describe(place),
            }),
        }
    }

    /// Warnings about parts of the sides that the rows of an interface leave out.
    fn unintegrated(&self, interface: &Interface<D>) -> Vec<String> {
        let name = &self.contact.name;
        let [missed, facing] = interface.missed;
        let pieces = (missed > 0).then(|| {
            format!(
                "contact \"{name}\": {missed} of {facing} points that face the other side lie in no part that is integrated: pressures and areas there are not to be trusted; use smaller or less curved facets there"
            )
        });
        let advice = match interface.nodes.iter().any(|node| node.partner().is_some()) {
            true => "set pairing = \"mortar\"",
            false => "use more facets between these supports",
        };
        let count = interface.unborne;
        let shear = (count > 0).then(|| {
            format!(
                "contact \"{name}\": at {count} nodes supports hold both sides along a direction oblique to the contact: shear along it follows from no condition there and is left out, so that its resultant lacks in that of the contact; {advice}, or hold one side only"
            )
        });
        pieces.into_iter().chain(shear).collect()
    }

    /// A warning about a gap from an expression or a tool that differs where the faces of a sector are one place of the whole.
    fn unlike_gaps(&self, interface: &Interface<D>, side: End<'_, D>) -> Option<String> {
        let given = matches!(self.contact.gap, Some(Gap::Given(_)))
            || matches!(self.contact.pair, Pair::Obstacle { .. });
        let twins = side.body.twins().filter(|_| given)?;
        let nodes = interface.nodes.iter();
        let nodes = nodes.filter(|node| !node.clearance.is_nan());
        let gaps: BTreeMap<usize, f64> = nodes.map(|node| (node.node, node.clearance)).collect();
        let largest = gaps
            .values()
            .fold(0.0, |most: f64, gap| most.max(gap.abs()));
        let alike = (UNLIKE * largest).max(CLOSED * side.body.mesh.diameter());
        let both = twins.pairs.iter().filter_map(|pair| {
            let [one, other] = pair.map(|node| gaps.get(&node).copied());
            Some((pair, [one?, other?]))
        });
        let apart = |gaps: [f64; 2]| (gaps[0] - gaps[1]).abs();
        let (pair, gaps) = both.max_by(|a, b| apart(a.1).total_cmp(&apart(b.1)))?;
        let [one, other] = pair.map(|node| show(side.body.mesh.points()[node]));
        (apart(gaps) > alike).then(|| {
            format!(
                "contact \"{}\": the gap is {} at {one} and {} at {other}, which are one place of the whole of which {} is a sector: it should be the same there; the mean counts",
                self.contact.name, Short(gaps[0]), Short(gaps[1]), side.body.name
            )
        })
    }

    fn fail(&self, source: ContactError) -> Error<D> {
        Error::Contact {
            contact: self.contact.name.clone(),
            source,
        }
    }

    fn end<'s>(&self, side: &'s SideRef) -> End<'s, D>
    where
        'a: 's,
    {
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
        leaning: bool,
    ) -> Result<Vec<Vec<Sample<D>>>, ContactError> {
        samples(nonmortar, against, gap, self.time, leaning)
    }

    /// A side, or a part of it, above an obstacle.
    fn above(
        &self,
        nonmortar: &SideRef,
        end: End<'_, D>,
        (obstacle, corners): (&Obstacle<D>, &Corners<D>),
        coupling: Coupling,
    ) -> Result<Condition<D>, Error<D>> {
        let against = Against::Obstacle(&obstacle.shape, driven(obstacle));
        let interface = self.obstacle(end, (obstacle, corners), coupling);
        let samples = self.samples(
            end,
            against,
            InitialGap::Measured,
            coupling != Coupling::Tied,
        );
        let obstacle_motion = obstacle_motion(self.contact, self.time)?;
        let interface = interface.map_err(|source| self.fail(source))?;
        if let Rigid::Tool(tool) = &obstacle.shape {
            tool.check_turned(end).map_err(|source| self.fail(source))?;
        }
        Ok(Condition {
            opposite: self.at.1,
            touch: Touch {
                obstacle_motion,
                samples: samples.map_err(|source| self.fail(source))?,
                ..Touch::default()
            },
            ..self.bare(nonmortar, interface)
        })
    }

    fn obstacle(
        &self,
        end: End<'_, D>,
        (obstacle, corners): (&Obstacle<D>, &Corners<D>),
        coupling: Coupling,
    ) -> Result<Interface<D>, ContactError> {
        let driven = driven(obstacle);
        let (analysis, time) = (self.model.analysis, self.time);
        let rigid = (&obstacle.shape, driven, corners);
        let nodal = || pair_obstacle(end, rigid, coupling, analysis, time);
        let integrated = || {
            let against = Against::Obstacle(&obstacle.shape, driven);
            pair_mortar(end, against, InitialGap::Measured, coupling, analysis, time)
        };
        // nodes may lie between the corners of a tool
        let by_facets = matches!(obstacle.shape, Rigid::Tool(_));
        match self.contact.pairing {
            Some(Pairing::NodeToNode) => nodal(),
            Some(Pairing::Mortar) => integrated(),
            None if by_facets => integrated(),
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
        ends: [End<'_, D>; 2],
        coupling: Coupling,
    ) -> Result<Condition<D>, ContactError> {
        let end = ends[0];
        let conforming = self.conforming(ends, coupling)?;
        let against = Against::Side(ends[1]);
        let gap = self.gap(match (&conforming, coupling) {
            (None, Coupling::Normal | Coupling::Frictional) => InitialGap::Measured,
            _ => InitialGap::Closed,
        });
        // coincident nodes need no direction
        let leaning = conforming.is_none() && coupling != Coupling::Tied;
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
        let mut samples = self.samples(end, against, gap, leaning)?;
        let measured = match &self.contact.gap {
            None => coupling != Coupling::Tied,
            Some(gap) => matches!(gap, Gap::Geometric),
        };
        let mut warnings = Vec::new();
        let mut partners = interface.nodes.iter().filter(|n| n.role != Role::Alone);
        let matching = partners.all(|n| n.partner().is_some());
        let mut crude = Default::default();
        if measured && !matching {
            let [first, second] = ends.map(missed_by_nodes);
            let by_nodes = [first?, second?];
            let most = |of: &BTreeMap<usize, f64>| of.values().copied().fold(0.0, f64::max);
            let missed: [f64; 2] = [most(&by_nodes[0]), most(&by_nodes[1])];
            crude = by_nodes;
            if let Some(largest) = all_within(missed[0] + missed[1], &interface, &samples) {
                interface.close();
                samples.iter_mut().flatten().for_each(|s| s.at.gap = 0.0);
                crude = Default::default();
                warnings.push(format!(
                    "contact \"{}\": all initial gaps lie within {} of zero, which is less than what the meshes miss of the curves that they stand for ({}): they count as closed; set gap = \"closed\" to say so, or give the true `surface` of both sides",
                    self.contact.name,
                    Short(largest),
                    Short(missed[0] + missed[1])
                ));
            }
        }
        let finer = !matching && finer_than_softer(ends, &interface)?;
        if finer {
            warnings.push(format!(
                "contact \"{}\": multipliers finer than the softer side, pressures may oscillate; swap nonmortar and mortar",
                self.contact.name
            ));
        }
        Ok(Condition {
            mortar: Some(mortar.clone()),
            opposite: Some(mortar.body.0),
            touch: Touch {
                samples,
                finer,
                missed: crude,
                ..Touch::default()
            },
            warnings,
            ..self.bare(nonmortar, interface)
        })
    }

    /// The contact with its rows; further data are filled in later.
    fn bare(&self, nonmortar: &SideRef, interface: Interface<D>) -> Condition<D> {
        let name = self.contact.name.clone();
        Condition::new(
            Source::Contact(self.at.0),
            name,
            nonmortar.clone(),
            interface,
        )
    }

    /// The interface of coincident nodes, if wanted and possible: a partial overlap of matching sides is legal, and so are sides that
    /// do not face each other at all.
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
            Some(Gap::Adjusted(most)) => InitialGap::Adjusted(*most),
            Some(Gap::Given(field)) => InitialGap::Given(field),
        }
    }
}
