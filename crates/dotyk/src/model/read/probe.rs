//! Probes: numbers read off a solution, interpolated in the containing cell or along the nonmortar side.
//!
//! Nodal vectors and tensors are interpolated first, and the requested number is taken of the result at the point:
//! σ_m = m·(ΣNₐσₐ)·m with the direction m there, not ΣNₐ(mₐ·σₐ·mₐ). A cell has the stress and the strength of its own material.
//! Means and integrals are Σ wₖ q(xₖ) over points of integration; largest and smallest values are those at nodes.

use crate::contact::frame;
use crate::fem::{
    Body, RigidBasis, Strength, fit_rigid, principal, side_facets, volume_points, von_mises,
};
use crate::geometry::{Point, add_scaled, centroid, cross, distance, dot, norm, padded, sub};
use crate::mesh::{Facet, Located, Mesh, locate, locate_all, locate_on_side};
use crate::model::nouns::error::{Error, ProbeError};
use crate::model::nouns::field::FieldKind;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::member::{MemberSolution, MemberStation};
use crate::model::nouns::model::{Along, Analysis, Model, Probe, Reading};
use crate::model::nouns::quantity::{BedQuantity, ContactField, Parts, Since, Stress, Touching};
use crate::model::nouns::section::{SectionQuantity, SectionSolution};
use crate::model::nouns::solution::{
    BedPoint, BedSolution, BodySolution, ContactNode, LinePoint, ProbeValue, Solution,
    effective_stress,
};
use crate::model::read::formulas::compute;
use crate::model::read::line::{
    Breaks, Station, points_between, stations_along, stations_at, stations_within,
};
use crate::model::read::on_side::{OnSide, fitting};
use crate::model::system::condition::Condition;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// A smaller shape function is rounding: that node does not contribute to the value.
const NO_WEIGHT: f64 = 1e-12;

/// A point nearer to a node, in parts of the distance to the next one, is that node: places are typed with six digits.
const ON_THE_NODE: f64 = 1e-6;

/// Where a probe is read: the same in every load step.
#[derive(Default)]
pub(crate) struct Site<const D: usize> {
    /// The places along which it is read; empty where it is read otherwise.
    stations: Vec<Station<D>>,
    /// Source of its value at a point: the mean of the values at one or two places.
    at: Vec<Located<D>>,
}

/// Reads all probes of a model off a solution, each at its site.
///
/// Errors: a quantity without a place, with the probe's name.
pub(crate) fn read_probes<const D: usize>(
    model: &Model<D>,
    sites: &[Site<D>],
    solution: &Solution<D>,
) -> Result<Vec<ProbeValue>, Error<D>> {
    let read = |(probe, site): (&Probe<D>, &Site<D>)| {
        value(model, solution, probe, site).map_err(|source| in_probe(probe, source))
    };
    let values = model.probes.iter().zip(sites).map(read);
    let mut values = values.collect::<Result<Vec<_>, _>>()?;
    compute(model, &mut values, solution.time);
    Ok(values)
}

fn value<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    probe: &Probe<D>,
    site: &Site<D>,
) -> Result<ProbeValue, ProbeError<D>> {
    let read = read(model, solution, probe, site)?;
    Ok(ProbeValue {
        name: probe.name.clone(),
        quantity: match &probe.factor {
            Some(factor) => format!("({factor}) {}", probe.quantity),
            None => probe.quantity.to_string(),
        },
        dimension: probe.dimension(),
        value: read.value,
        at: read.at.map(padded),
        line: read.line,
    })
}

/// Where each probe is read, before anything is solved.
///
/// Errors: no place, points outside, lines that miss their body, sides that are not there, with the probe's name.
pub(crate) fn sites<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
) -> Result<Vec<Site<D>>, Error<D>> {
    let sides: Vec<Sides> = conditions
        .iter()
        .map(|condition| (&condition.nonmortar, condition.mortar.is_some()))
        .collect();
    let named = |probe| site(model, &sides, probe).map_err(|source| in_probe(probe, source));
    model.probes.iter().map(named).collect()
}

/// Reads a probe that the model does not have off a solution of one of its stages.
///
/// Errors: as [`sites`] and [`read_probes`].
pub(crate) fn read_probe<const D: usize>(
    model: &Model<D>,
    probe: &Probe<D>,
    solution: &Solution<D>,
) -> Result<ProbeValue, Error<D>> {
    let contacts = solution.contacts.iter();
    let sides: Vec<Sides> = contacts
        .map(|contact| (&contact.nonmortar, contact.mortar.is_some()))
        .collect();
    let value = site(model, &sides, probe).and_then(|site| value(model, solution, probe, &site));
    value.map_err(|source| in_probe(probe, source))
}

/// The nonmortar side of a contact, and whether another body is opposite.
type Sides<'a> = (&'a SideRef, bool);

fn site<const D: usize>(
    model: &Model<D>,
    sides: &[Sides<'_>],
    probe: &Probe<D>,
) -> Result<Site<D>, ProbeError<D>> {
    let nowhere = Site::default();
    if probe.quantity.is_absent() {
        return Ok(nowhere);
    }
    if let Reading::Coupled(_) = probe.reading {
        let couple = probe.coupled(model).ok_or(ProbeError::NoPlace);
        return couple.map(|_| nowhere);
    }
    let carrier = match &probe.quantity.parts {
        Parts::Displacement(of, _)
        | Parts::Stress(of, _)
        | Parts::Utilisation(of)
        | Parts::Field(of, ..) => Carrier::Body(*of),
        Parts::Rotation(..) => return Err(ProbeError::NoCouple),
        Parts::Obstacle(of, _) if sides[*of].1 => {
            return Err(ProbeError::NoObstacle);
        }
        Parts::Along(of, _) => Carrier::Side(sides[*of].0),
        Parts::Reaction(of, Some(side), _) => {
            return Ok(side_facets(&model.bodies[*of].mesh, side).map(|_| nowhere)?);
        }
        Parts::Reaction(..)
        | Parts::Resultant(..)
        | Parts::Moment(..)
        | Parts::Length(..)
        | Parts::Dissipated(..)
        | Parts::Shortening(_)
        | Parts::Bed(.., BedQuantity::ClosedArea)
        | Parts::Formula(_)
        | Parts::Obstacle(..) => return Ok(nowhere),
        Parts::Section(..) | Parts::Member(_) | Parts::Bed(..) => {
            match (&probe.along, probe.reading) {
                (None, Reading::Whole) if probe.quantity.is_of_member() => return Ok(nowhere),
                (Some(_), _)
                | (_, Reading::Whole | Reading::MeanOfNeighbours(_) | Reading::Coupled(_)) => {
                    return Err(ProbeError::StationsAlone);
                }
                _ => return Ok(nowhere),
            }
        }
    };
    match (&probe.along, probe.reading) {
        (None, Reading::Whole) => return Err(ProbeError::NoPlace),
        (Some(Along::Line { .. }), Reading::Mean | Reading::Integral) => {
            return Err(ProbeError::LineHasNoArea);
        }
        _ => {}
    }
    let located = |at| -> Result<Vec<Located<D>>, ProbeError<D>> {
        let found = located(model, carrier, at)?;
        Ok(match probe.reading {
            Reading::MeanOfNeighbours(_) => {
                neighbours(&model.bodies[carrier.body()].mesh, found, at)
            }
            _ => vec![found],
        })
    };
    let at = probe.reading.point().map(located).transpose()?;
    Ok(Site {
        stations: stations(model, probe, carrier)?,
        at: at.unwrap_or_default(),
    })
}

fn in_probe<const D: usize>(probe: &Probe<D>, source: ProbeError<D>) -> Error<D> {
    Error::Probe {
        probe: probe.name.clone(),
        source,
    }
}

/// A number, and where it is if it is the largest or smallest one; or the values along a line.
struct Read<const D: usize> {
    value: f64,
    at: Option<Point<D>>,
    line: Vec<LinePoint>,
}

impl<const D: usize> From<f64> for Read<D> {
    fn from(value: f64) -> Self {
        Self {
            value,
            at: None,
            line: Vec::new(),
        }
    }
}

fn read<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    probe: &Probe<D>,
    site: &Site<D>,
) -> Result<Read<D>, ProbeError<D>> {
    if probe.quantity.is_absent() {
        return Ok(f64::NAN.into());
    }
    let factor = |point: Point<D>| -> f64 {
        let own = probe.factor.as_ref();
        own.map_or(1.0, |factor| factor.at(point, solution.time))
    };
    if let Parts::Section(of, field) = probe.quantity.parts {
        let section = &solution.sections[of];
        // sums along the axis are those of whole cuts, whatever lies between the places
        let summed = matches!(probe.reading, Reading::Mean | Reading::Integral);
        let exact = summed && probe.factor.is_none() && field != SectionQuantity::Utilisation;
        let section = match exact {
            true => section.mean(),
            false => Cow::Borrowed(section),
        };
        return Ok(along_section(&section, field, (probe.reading, &factor)));
    }
    if let Parts::Member(of) = probe.quantity.parts {
        let member = &solution.members[of];
        return Ok(along_member(member, (probe.reading, &factor)));
    }
    if let Parts::Bed(of, side, quantity) = &probe.quantity.parts {
        let of_side = |bed: &&BedSolution<D>| bed.side.body.0 == *of && bed.side.side == *side;
        let bed = solution.beds.iter().find(of_side);
        return Ok(bed.map_or(f64::NAN.into(), |bed| {
            within_bed(bed, *quantity, (probe.reading, &factor))
        }));
    }
    let field = match field(model, solution, probe) {
        Quantified::Number(number) => {
            let couple = probe.coupled(model);
            let place = couple.map_or([f64::NAN; D], |couple| couple.point);
            return Ok((number * factor(place)).into());
        }
        Quantified::Varies(field) if probe.factor.is_some() => {
            let points = model.bodies[field.carrier.body()].mesh.points();
            let ReadField { carrier, value } = field;
            ReadField::new(carrier, move |found| {
                value(found) * factor(found.interpolate(|node| points[node]))
            })
        }
        Quantified::Varies(field) => field,
    };
    if probe.is_line() {
        let line = site.stations.iter().map(|station| field.on_line(station));
        return Ok(Read {
            line: line.collect(),
            ..f64::NAN.into()
        });
    }
    let reduced = match (&probe.along, field.carrier) {
        (Some(_), _) => {
            let value = |station: &Station<D>| field.on_line(station).value;
            let samples = site.stations.iter().map(|s| (s.point, s.share, value(s)));
            reduced(probe.reading, samples)
        }
        (None, Carrier::Body(of)) => {
            let samples = within(&model.bodies[of], model.analysis, probe.reading, &field);
            reduced(probe.reading, samples.into_iter())
        }
        (None, Carrier::Side(_)) => {
            let Parts::Along(of, _) = probe.quantity.parts else {
                return Err(ProbeError::NoPlace);
            };
            // a mean covers the part of the side with an opposite side
            let facing = |n: &&ContactNode<D>| probe.reading != Reading::Mean || !n.gap.is_nan();
            let nodes = solution.contacts[of].nodes.iter().filter(facing);
            // quantities of a contact depend on no material
            let value = |n: &ContactNode<D>| (field.value)(&Located::at_node(0, n.node, n.normal));
            reduced(probe.reading, nodes.map(|n| (n.point, n.weight, value(n))))
        }
    };
    if let Some(read) = reduced {
        return Ok(read);
    }
    if site.at.is_empty() {
        return Err(ProbeError::NoPlace);
    }
    let sum: f64 = site.at.iter().map(|found| (field.value)(found)).sum();
    Ok((sum / site.at.len() as f64).into())
}

/// Values within a body: at its nodes in their order, or, where they are weighted, at points of integration with their volumes.
fn within<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    reading: Reading<D>,
    field: &ReadField<'_, D>,
) -> Vec<Sample<D>> {
    let mut samples = Vec::new();
    if !matches!(reading, Reading::Mean | Reading::Integral) {
        let blocks = body.mesh.blocks().iter().enumerate();
        let nodes = blocks.flat_map(|(block, own)| own.nodes.iter().map(move |&n| (n, block)));
        let nodes: BTreeSet<(u32, usize)> = nodes.collect();
        samples.extend(nodes.into_iter().map(|(node, block)| {
            let found = Located::at_node(block, node as usize, [0.0; D]);
            (
                body.mesh.points()[node as usize],
                0.0,
                (field.value)(&found),
            )
        }));
        return samples;
    }
    volume_points(body, analysis, |at| {
        let found = Located {
            block: at.block,
            cell: Some(at.number),
            nodes: at.cell.iter().map(|&node| node as usize).collect(),
            shape: at.shape.to_vec(),
            normal: [0.0; D],
            outside: 0.0,
        };
        samples.push(([0.0; D], at.volume, (field.value)(&found)));
    });
    samples
}

/// The factor of a value at a point.
type Factor<'a, const D: usize> = &'a dyn Fn(Point<D>) -> f64;

/// A quantity of a section, read at its stations; mean and integral run over s.
fn along_section<const D: usize>(
    section: &SectionSolution,
    quantity: SectionQuantity,
    (reading, factor): (Reading<D>, Factor<'_, D>),
) -> Read<D> {
    let stations = &section.stations;
    // the trapezoidal rule between stations that are there, at each place along the axis with its part of the length
    let count = (stations.len() / section.places()).max(1);
    let share = |k: usize| {
        let to = |other: usize| {
            let row = stations.get(other).filter(|_| other / count == k / count);
            let there = row.filter(|other| !other.normal.is_nan());
            there.map_or(stations[k].s, |other| other.s)
        };
        let before = stations[k].s - to(k.wrapping_sub(1));
        let after = to(k + 1) - stations[k].s;
        section.share(k / count) * 0.5 * (before.max(0.0) + after.max(0.0))
    };
    let all = stations.iter().enumerate();
    let all = all.map(|(k, at)| {
        let place = at.place();
        let point = std::array::from_fn(|i| place[i]);
        (point, share(k), quantity.at(at) * factor(point))
    });
    at_stations(all, reading)
}

/// The force of a member, read at its stations; alone it is the one of the largest magnitude.
fn along_member<const D: usize>(
    member: &MemberSolution<D>,
    (reading, factor): (Reading<D>, Factor<'_, D>),
) -> Read<D> {
    if reading == Reading::Whole {
        let weighed = member.stations.iter();
        let weighed = weighed.map(|at| (at.point, at.force * factor(at.point)));
        let larger = |best: (Point<D>, f64), next: (Point<D>, f64)| {
            if next.1.abs() > best.1.abs() {
                next
            } else {
                best
            }
        };
        let largest = weighed.reduce(larger);
        return Read {
            at: largest.map(|(point, _)| point),
            ..largest.map_or(f64::NAN, |(_, value)| value).into()
        };
    }
    let stations = member.stations.iter();
    let value = |at: &MemberStation<D>| at.force * factor(at.point);
    at_stations(stations.map(|at| (at.point, at.length, value(at))), reading)
}

/// A quantity of a bed, read at its points.
fn within_bed<const D: usize>(
    bed: &BedSolution<D>,
    quantity: BedQuantity,
    (reading, factor): (Reading<D>, Factor<'_, D>),
) -> Read<D> {
    let value = |at: &BedPoint<D>| {
        factor(at.point)
            * match quantity {
                BedQuantity::Gap => at.gap,
                BedQuantity::Pressure | BedQuantity::ClosedArea => at.pressure,
            }
    };
    match quantity {
        BedQuantity::ClosedArea => (bed.closed_area() * factor([f64::NAN; D])).into(),
        _ => at_stations(
            bed.points.iter().map(|at| (at.point, at.area, value(at))),
            reading,
        ),
    }
}

/// The value at the station (place, share, value) nearest to a point, or the reduction of all.
fn at_stations<const D: usize>(
    stations: impl Iterator<Item = (Point<D>, f64, f64)>,
    reading: Reading<D>,
) -> Read<D> {
    if let Reading::At(point) = reading {
        let far = |station: &(Point<D>, f64, f64)| distance(station.0, point);
        let nearest = stations.min_by(|a, b| far(a).total_cmp(&far(b)));
        return nearest.map_or(f64::NAN, |station| station.2).into();
    }
    reduced(reading, stations).unwrap_or(f64::NAN.into())
}

/// The nodes at which a quantity is read: those of a body, or of the nonmortar side of a contact.
#[derive(Clone, Copy)]
enum Carrier<'a> {
    Body(usize),
    Side(&'a SideRef),
}

impl Carrier<'_> {
    fn body(self) -> usize {
        match self {
            Self::Body(body) => body,
            Self::Side(side) => side.body.0,
        }
    }
}

/// The values of a quantity in a solution.
enum Quantified<'a, const D: usize> {
    Number(f64),
    Varies(ReadField<'a, D>),
}

/// A quantity that varies from place to place: its number at one.
struct ReadField<'a, const D: usize> {
    carrier: Carrier<'a>,
    value: Box<dyn Fn(&Located<D>) -> f64 + 'a>,
}

impl<'a, const D: usize> ReadField<'a, D> {
    fn new(carrier: Carrier<'a>, value: impl Fn(&Located<D>) -> f64 + 'a) -> Self {
        Self {
            carrier,
            value: Box::new(value),
        }
    }

    fn on_line(&self, station: &Station<D>) -> LinePoint {
        let found = station.located.as_ref();
        LinePoint {
            s: station.s,
            point: padded(station.point),
            value: found.map_or(f64::NAN, |found| (self.value)(found)),
            starts: station.starts,
        }
    }
}

/// The quantity of a probe, before its place is chosen.
fn field<'a, const D: usize>(
    model: &'a Model<D>,
    solution: &'a Solution<D>,
    probe: &'a Probe<D>,
) -> Quantified<'a, D> {
    let rigid = probe
        .minus_rigid
        .map(|body| free_motion(model, solution, body));
    let minus = move |point: Point<D>| rigid.as_ref().map_or([0.0; D], |motion| motion(point));
    let body = |index: usize| (&model.bodies[index].mesh, &solution.bodies[index]);
    let number = |value: f64| Quantified::Number(value);
    match probe.quantity.parts {
        Parts::Reaction(of, None, axis) => number(body(of).1.reaction[axis]),
        Parts::Reaction(of, Some(ref side), axis) => {
            let solved = body(of).1;
            let of =
                |forces: &BTreeMap<String, Point<D>>| forces.get(side).map_or(0.0, |f| f[axis]);
            number(of(&solved.side_reactions) + of(&solved.part_reactions))
        }
        Parts::Resultant(of, axis) => number(solution.contacts[of].resultant[axis]),
        Parts::Moment(of, axis) => {
            let contact = &solution.contacts[of];
            number(contact.moment[axis] - cross(probe.center, contact.resultant)[axis])
        }
        Parts::Length(of, what) => {
            let contact = &solution.contacts[of];
            number(match what {
                Touching::Whole => contact.length,
                Touching::Stick => contact.length_stick,
                Touching::Slip => contact.length_slip,
            })
        }
        Parts::Dissipated(of, since) => {
            let contact = &solution.contacts[of];
            number(match since {
                Since::Step => contact.dissipated,
                Since::Start => contact.dissipated_total,
            })
        }
        Parts::Obstacle(of, component) => {
            let moved = solution.contacts[of].obstacle;
            number(moved.map_or(f64::NAN, |u| component.of(u)))
        }
        Parts::Shortening(of) => number(solution.members[of].shortening.unwrap_or(f64::NAN)),
        Parts::Section(..) | Parts::Member(_) | Parts::Bed(..) => number(f64::NAN),
        // of the numbers that were read in the step
        Parts::Formula(ref formula) => {
            number(formula.value(|name| solution.probe(name), solution.time))
        }
        Parts::Rotation(of, axis) => number(rotation(body(of).1, probe.reading, axis)),
        Parts::Displacement(of, component) => {
            let (mesh, solved) = body(of);
            if let Reading::Coupled(place) = probe.reading
                && let Some(couple) = solved.couples.get(place)
            {
                let u = sub(couple.displacement, minus(couple.point));
                return number(component.of(u));
            }
            let relative =
                move |node: usize| sub(solved.displacement[node], minus(mesh.points()[node]));
            let value = move |at: &Located<D>| component.of(at.interpolate(&relative));
            Quantified::Varies(ReadField::new(Carrier::Body(of), value))
        }
        Parts::Stress(of, component) => {
            let (mesh, solved) = body(of);
            let plane = model.analysis != Analysis::Axisymmetric;
            let value = move |at: &Located<D>| {
                let point = at.interpolate(|node| mesh.points()[node]);
                let from = plane.then(|| sub(point, probe.center));
                let tensor = at.interpolate(|node| solved.stress_in(at.block, node));
                stress(component, tensor, at.normal, from)
            };
            Quantified::Varies(ReadField::new(Carrier::Body(of), value))
        }
        Parts::Utilisation(of) => {
            let solved = body(of).1;
            let body = &model.bodies[of];
            let blocks = body.mesh.blocks().iter();
            let strengths: Vec<Option<Strength>> = blocks
                .map(|block| body.material(block).ok()?.strength)
                .collect();
            let value = move |at: &Located<D>| {
                // material that yields has at most its yield stress at points, whatever lies between nodes
                if let (Some(_), Some(own)) = (&solved.yielding, &solved.utilisation) {
                    let place = |node: usize| solved.borders.place(at.block, node);
                    return at.interpolate(|node| [own.nodal[place(node)]])[0];
                }
                let mut tensor = at.interpolate(|node| solved.stress_in(at.block, node));
                if let Some(water) = &solved.pore_pressure {
                    let place = |node: usize| solved.borders.place(at.block, node);
                    let [p] = at.interpolate(|node| [water[place(node)]]);
                    tensor = effective_stress(&[tensor], &[p])[0];
                }
                strengths[at.block].map_or(f64::NAN, |strength| strength.utilisation(tensor))
            };
            Quantified::Varies(ReadField::new(Carrier::Body(of), value))
        }
        Parts::Field(of, field, component) => {
            let (kind, (mesh, solved)) = (&FieldKind::ALL[field], body(of));
            let count = kind.shape.components();
            let values = (kind.values)(solved);
            let of_cells = FieldKind::of_cells_named(kind.name);
            let of_cells = of_cells.and_then(|kind| (kind.values)(solved));
            let value = move |at: &Located<D>| {
                if let (Some(values), Some(cell)) = (&of_cells, at.cell) {
                    return values[count * (mesh.cells_before(at.block) + cell) + component];
                }
                values.as_ref().map_or(f64::NAN, |values| {
                    let place = |node: usize| solved.borders.place(at.block, node);
                    at.interpolate(|node| [values[count * place(node) + component]])[0]
                })
            };
            Quantified::Varies(ReadField::new(Carrier::Body(of), value))
        }
        Parts::Along(of, field) => {
            let contact = &solution.contacts[of];
            let field = (field, contact.sign());
            let mesh = &model.bodies[contact.nonmortar.body.0].mesh;
            let side = OnSide::new(mesh, contact);
            let mut between: BTreeMap<usize, Vec<(Point<D>, f64)>> = BTreeMap::new();
            for place in side.between() {
                let mean = place.mean(|node| along(field, node, &minus));
                let values = between.entry(place.node).or_default();
                values.push((place.normal, mean));
            }
            let value = move |node: usize, normal: Point<D>| {
                if let Some(state) = side.state(node, normal) {
                    return along(field, state, &minus);
                }
                let values = between.get(&node).into_iter().flatten();
                fitting(values, normal, |value| value.0).map_or(f64::NAN, |value| value.1)
            };
            let value = move |at: &Located<D>| at.interpolate(|node| [value(node, at.normal)])[0];
            Quantified::Varies(ReadField::new(Carrier::Side(&contact.nonmortar), value))
        }
    }
}

/// Rotation about an axis of the point of a couple; in the plane there is one. NaN where it is read at no such point.
fn rotation<const D: usize>(body: &BodySolution<D>, reading: Reading<D>, axis: usize) -> f64 {
    let Reading::Coupled(place) = reading else {
        return f64::NAN;
    };
    let couple = body.couples.get(place);
    let turns = couple.map_or(&[][..], |couple| &couple.rotation);
    let axis = if D == 3 { axis } else { 0 };
    turns.get(axis).copied().unwrap_or(f64::NAN)
}

/// The places along which a probe is read; empty where it is read otherwise.
///
/// Errors: a line that misses the body or leaves the side of the contact; a side that the quantity is not of.
fn stations<const D: usize>(
    model: &Model<D>,
    probe: &Probe<D>,
    carrier: Carrier<'_>,
) -> Result<Vec<Station<D>>, ProbeError<D>> {
    match probe.along {
        Some(Along::Side(ref side)) => {
            check_owner(model, carrier, side)?;
            if D == 3 && probe.is_line() {
                return Err(ProbeError::SideInSpace);
            }
            let body = &model.bodies[side.body.0];
            let of_contact = probe.quantity.is_of_contact();
            if !of_contact && matches!(probe.reading, Reading::Mean | Reading::Integral) {
                return stations_within(body, &side.side, model.analysis);
            }
            // places where normal or material has two values
            let breaks = Breaks {
                corners: probe.quantity.needs_side() || of_contact,
                materials: probe.quantity.depends_on_material(),
            };
            stations_along(body, &side.side, model.analysis, breaks)
        }
        _ if probe.quantity.needs_side() => Err(ProbeError::NoSide),
        Some(Along::Line { from, to, points }) => {
            let points = points_between(from, to, points);
            let found = match carrier {
                Carrier::Body(of) => locate_all(&model.bodies[of].mesh, &points),
                Carrier::Side(_) => {
                    let found = points.iter().map(|&at| located(model, carrier, at));
                    found
                        .map(|found| found.map(Some))
                        .collect::<Result<_, _>>()?
                }
            };
            if found.iter().all(Option::is_none) {
                return Err(ProbeError::LineOutside { from, to });
            }
            Ok(stations_at(&points, found))
        }
        None => Ok(Vec::new()),
    }
}

/// Errors: a side of another body; one that is no part of the nonmortar side.
fn check_owner<const D: usize>(
    model: &Model<D>,
    carrier: Carrier<'_>,
    side: &SideRef,
) -> Result<(), ProbeError<D>> {
    let name = |side: &SideRef| format!("{}.{}", model.bodies[side.body.0].name, side.side);
    match carrier {
        Carrier::Body(of) if side.body.0 == of => Ok(()),
        Carrier::Body(of) => Err(ProbeError::OtherBody {
            side: name(side),
            body: model.bodies[of].name.clone(),
        }),
        Carrier::Side(nonmortar) => {
            let facets = |side: &SideRef| side_facets(&model.bodies[side.body.0].mesh, &side.side);
            let (part, whole) = (facets(side)?, facets(nonmortar)?);
            let within = |facet: &Facet| whole.binary_search(facet).is_ok();
            if side.body == nonmortar.body && part.iter().all(within) {
                return Ok(());
            }
            Err(ProbeError::NotNonmortar {
                side: name(side),
                nonmortar: name(nonmortar),
            })
        }
    }
}

/// A quantity at a node of a contact; a displacement is that beside the rigid motion `minus`. Vectors are told for the side
/// that is named first: `sign` is −1 where that is the mortar side.
fn along<const D: usize>(
    (field, sign): (ContactField, f64),
    node: &ContactNode<D>,
    minus: &dyn Fn(Point<D>) -> Point<D>,
) -> f64 {
    let tangential = |vector: Point<D>| match D {
        2 => dot(vector, frame(node.normal, &[])[1]),
        _ => norm(vector),
    };
    let beside_rigid = |u: f64| u - dot(node.normal, minus(node.point));
    match field {
        ContactField::Pressure => node.pressure,
        ContactField::Gap => node.gap,
        ContactField::Shear => tangential(node.shear),
        ContactField::ShearVector(component) => component.of(node.shear.map(|t| sign * t)),
        ContactField::Slip => tangential(node.slip),
        ContactField::SlipVector(component) => component.of(node.slip.map(|s| sign * s)),
        ContactField::DisplacementNonmortar => beside_rigid(node.displacement_nonmortar),
        ContactField::DisplacementMortar => beside_rigid(node.displacement_mortar),
    }
}

/// A component of a stress at a point with this normal; `from` is its position relative to the centre, `None` with axial symmetry.
fn stress<const D: usize>(
    component: Stress,
    s: [f64; 6],
    normal: Point<D>,
    from: Option<Point<D>>,
) -> f64 {
    match component {
        Stress::Component(i) => s[i],
        Stress::VonMises => von_mises(s),
        Stress::First => principal(s)[0],
        Stress::Second => principal(s)[1],
        Stress::Third => principal(s)[2],
        Stress::Tresca => principal(s)[0] - principal(s)[2],
        // around the axis of symmetry it is zz
        Stress::Hoop => from.map_or(s[2], |from| hoop(s, from)),
        Stress::Normal => across(s, normal),
    }
}

/// n·σ·n of (xx yy zz xy yz xz).
fn across<const D: usize>(s: [f64; 6], normal: Point<D>) -> f64 {
    let [x, y, z] = padded(normal);
    s[0] * x * x + s[1] * y * y + s[2] * z * z + 2.0 * (s[3] * x * y + s[4] * y * z + s[5] * x * z)
}

/// Hoop stress of a plane analysis around a centre, at a position relative to it; NaN in the centre.
fn hoop<const D: usize>(s: [f64; 6], from: Point<D>) -> f64 {
    let [x, y] = [from[0], from[1]];
    (s[0] * y * y + s[1] * x * x - 2.0 * s[3] * x * y) / (x * x + y * y)
}

/// The rigid motion that a body's own supports leave free, at its least-squares amplitude, as a function of place.
fn free_motion<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    body: BodyId,
) -> impl Fn(Point<D>) -> Point<D> + use<D> {
    let BodySolution {
        displacement,
        floating_modes,
        ..
    } = &solution.bodies[body.0];
    let points = model.bodies[body.0].mesh.points();
    let centre = centroid(points);
    let mut rest: Vec<Point<D>> = displacement.clone();
    let mut motions = Vec::new();
    // modes need not be orthogonal: two sweeps of Gram–Schmidt on them, then plain projections
    let mut basis: Vec<Vec<Point<D>>> = Vec::new();
    for mode in floating_modes {
        let mut own = mode.displacement.clone();
        for _ in 0..2 {
            for other in &basis {
                let part = inner(&own, other) / inner(other, other);
                own.iter_mut()
                    .zip(other)
                    .for_each(|(u, v)| *u = add_scaled(*u, -part, *v));
            }
        }
        let amplitude = inner(&rest, &own) / inner(&own, &own);
        rest.iter_mut()
            .zip(&own)
            .for_each(|(u, v)| *u = add_scaled(*u, -amplitude, *v));
        let (translation, spin) = fit_rigid(RigidBasis::Full, points, &own, centre);
        let spin: Vec<f64> = spin.iter().map(|s| amplitude * s).collect();
        motions.push((translation.map(|t| amplitude * t), spin));
        basis.push(own);
    }
    move |point: Point<D>| {
        let x = sub(point, centre);
        motions.iter().fold([0.0; D], |sum, (translation, spin)| {
            let moved = add_scaled(sum, 1.0, *translation);
            let turns = spin.iter().enumerate();
            turns.fold(moved, |sum, (k, s)| {
                add_scaled(sum, *s, RigidBasis::Full.displacement(k, x))
            })
        })
    }
}

fn inner<const D: usize>(a: &[Point<D>], b: &[Point<D>]) -> f64 {
    a.iter().zip(b).map(|(&x, &y)| dot(x, y)).sum()
}

/// A value at a node with its place and its share of volume or side.
type Sample<const D: usize> = (Point<D>, f64, f64);

/// The reduction of nodal values to one number, NaN left out. `None` where the probe is read at a point.
fn reduced<const D: usize>(
    reading: Reading<D>,
    samples: impl Iterator<Item = Sample<D>>,
) -> Option<Read<D>> {
    let samples = samples.filter(|(.., value)| !value.is_nan());
    match reading {
        Reading::Largest => Some(first(samples, |a, b| a > b)),
        Reading::Smallest => Some(first(samples, |a, b| a < b)),
        Reading::Mean => {
            let (whole, sum) = sums(samples);
            Some((sum / whole).into())
        }
        Reading::Integral => Some(sums(samples).1.into()),
        Reading::Whole | Reading::At(_) | Reading::Coupled(_) | Reading::MeanOfNeighbours(_) => {
            None
        }
    }
}

/// The value that precedes all others, and its place; of equal ones the first.
fn first<const D: usize>(
    samples: impl Iterator<Item = Sample<D>>,
    before: fn(f64, f64) -> bool,
) -> Read<D> {
    let found = samples.reduce(|best, next| if before(next.2, best.2) { next } else { best });
    Read {
        value: found.map_or(f64::NAN, |(.., value)| value),
        at: found.map(|(point, ..)| point),
        line: Vec::new(),
    }
}

/// Sum of the shares, and of the shares times the values.
fn sums<const D: usize>(samples: impl Iterator<Item = Sample<D>>) -> (f64, f64) {
    samples.fold((0.0, 0.0), |(whole, sum), (_, share, value)| {
        // shares of corners of quadratic cells may be negative
        let part = if value.is_infinite() {
            value
        } else {
            share * value
        };
        (whole + share, sum + part)
    })
}

/// Nodes and shape functions at a point of the carrier of a quantity.
///
/// Errors: a point outside the body or beside the side.
fn located<const D: usize>(
    model: &Model<D>,
    carrier: Carrier<'_>,
    at: Point<D>,
) -> Result<Located<D>, ProbeError<D>> {
    let mesh = &model.bodies[carrier.body()].mesh;
    let side = match carrier {
        Carrier::Body(_) => return locate(mesh, at).ok_or(ProbeError::Outside { point: at }),
        Carrier::Side(side) => side_facets(mesh, &side.side)?,
    };
    let mut found = locate_on_side(mesh, side, at).ok_or(ProbeError::Beside { point: at })?;
    // a node without a contribution may have no value, which is NaN
    let none = found.shape.iter_mut().filter(|n| n.abs() < NO_WEIGHT);
    none.for_each(|n| *n = 0.0);
    Ok(found)
}

/// The two nodes nearest to a point of a facet; a point on a node takes that node.
fn neighbours<const D: usize>(mesh: &Mesh<D>, found: Located<D>, at: Point<D>) -> Vec<Located<D>> {
    let Located {
        block,
        mut nodes,
        normal,
        ..
    } = found;
    // on a curved facet the middle node splits it: the neighbours are the two nodes nearest to the point
    nodes.sort_by(|&a, &b| {
        distance(mesh.points()[a], at).total_cmp(&distance(mesh.points()[b], at))
    });
    let spacing = distance(mesh.points()[nodes[0]], mesh.points()[nodes[1]]);
    let count = match distance(mesh.points()[nodes[0]], at) < ON_THE_NODE * spacing {
        true => 1,
        false => 2,
    };
    let nearest = nodes[..count].iter();
    nearest
        .map(|&node| Located::at_node(block, node, normal))
        .collect()
}

/// Values of all probes of a model, in their order; NaN for those of absent parts.
pub(crate) fn all_probes<const D: usize>(
    model: &Model<D>,
    mut found: Vec<ProbeValue>,
) -> Vec<ProbeValue> {
    let one = |probe: &Probe<D>| {
        let place = found.iter().position(|value| value.name == probe.name);
        place.map_or_else(
            || ProbeValue {
                name: probe.name.clone(),
                quantity: probe.quantity.to_string(),
                dimension: probe.dimension(),
                value: f64::NAN,
                at: None,
                line: Vec::new(),
            },
            |place| found.swap_remove(place),
        )
    };
    model.probes.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_principal_stress_and_trescas_are_read() {
        let state = [3.0, 1.0, -2.0, 0.0, 0.0, 0.0];
        let read = |component: Stress| stress(component, state, [0.0; 2], None);
        assert!((read(Stress::Second) - 1.0).abs() < 1e-12);
        assert!((read(Stress::Tresca) - 5.0).abs() < 1e-12);
    }
}
