//! Probes: numbers read off a solution, interpolated in the containing cell or along the nonmortar side.

use crate::contact::frame;
use crate::fem::{RigidBasis, fit_rigid, nodal_volumes, principal, side_facets, von_mises};
use crate::geometry::{Point, add_scaled, distance, dot, norm, padded, sub};
use crate::mesh::Mesh;
use crate::model::error::{Error, ProbeError};
use crate::model::locate::{locate, locate_on_side};
use crate::model::nouns::{Analysis, BodyId, Model, Probe, Reading, SideRef};
use crate::model::quantity::{ContactField, Displacement, Parts, Stress};
use crate::model::recover::centroid;
use crate::model::solution::{BodySolution, ContactNode, ProbeValue, Solution};
use std::collections::BTreeMap;

/// A smaller shape function is rounding: that node has no part in the value.
const NO_WEIGHT: f64 = 1e-12;

/// A point nearer to a node, in parts of the distance to the next one, is that node: places are typed with six digits.
const ON_THE_NODE: f64 = 1e-6;

/// Reads all probes of a model off a solution.
///
/// Errors: a quantity without a place, points outside, with the probe's name.
pub(crate) fn read_probes<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
) -> Result<Vec<ProbeValue>, Error<D>> {
    let read = |probe: &Probe<D>| {
        let read = read(model, solution, probe).map_err(|source| in_probe(probe, source))?;
        Ok(ProbeValue {
            name: probe.name.clone(),
            quantity: probe.quantity.to_string(),
            dimension: probe.dimension(),
            value: read.value,
            at: read.at.map(padded),
        })
    };
    model.probes.iter().map(read).collect()
}

/// Checks that every probe can be read, before anything is solved.
pub(crate) fn check_probes<const D: usize>(model: &Model<D>) -> Result<(), Error<D>> {
    let mesh = |body: usize| &model.bodies[body].mesh;
    let check = |probe: &Probe<D>| match (&probe.quantity.parts, probe.reading.point()) {
        (&(Parts::Displacement(body, _) | Parts::Stress(body, _)), Some(at)) => {
            in_cell(mesh(body), at).map(|_| ())
        }
        (Parts::Reaction(body, Some(side), _), _) => {
            Ok(side_facets(mesh(*body), side).map(|_| ())?)
        }
        _ => Ok(()),
    };
    let named = |probe: &Probe<D>| check(probe).map_err(|source| in_probe(probe, source));
    model.probes.iter().try_for_each(named)
}

fn in_probe<const D: usize>(probe: &Probe<D>, source: ProbeError<D>) -> Error<D> {
    Error::Probe {
        probe: probe.name.clone(),
        source,
    }
}

/// A number, and where it is if it is the largest or smallest one.
struct Read<const D: usize> {
    value: f64,
    at: Option<Point<D>>,
}

impl<const D: usize> From<f64> for Read<D> {
    fn from(value: f64) -> Self {
        Self { value, at: None }
    }
}

fn read<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    probe: &Probe<D>,
) -> Result<Read<D>, ProbeError<D>> {
    let rigid = probe
        .minus_rigid
        .map(|body| free_motion(model, solution, body));
    let minus = |point: Point<D>| rigid.as_ref().map_or([0.0; D], |motion| motion(point));
    let body = |index: usize| (&model.bodies[index].mesh, &solution.bodies[index]);
    let volumes = |index: usize| nodal_volumes(&model.bodies[index], model.analysis);
    let reading = probe.reading;
    match probe.quantity.parts {
        Parts::Reaction(of, None, axis) => Ok(body(of).1.reaction[axis].into()),
        Parts::Reaction(of, Some(ref side), axis) => {
            let solved = body(of).1;
            let of =
                |forces: &BTreeMap<String, Point<D>>| forces.get(side).map_or(0.0, |f| f[axis]);
            Ok((of(&solved.side_reactions) + of(&solved.part_reactions)).into())
        }
        Parts::Resultant(of, axis) => Ok(solution.contacts[of].resultant[axis].into()),
        Parts::Length(of) => Ok(solution.contacts[of].length.into()),
        Parts::Displacement(of, component) => {
            let (mesh, solved) = body(of);
            let relative = |node: usize| sub(solved.displacement[node], minus(mesh.points()[node]));
            let volumes = || volumes(of);
            match component {
                Displacement::Axis(axis) => {
                    in_body((mesh, &volumes), reading, |node| relative(node)[axis])
                }
                // at a point the length of the interpolated vector
                Displacement::Magnitude if reading.point().is_some() => {
                    let part = |i: usize| {
                        let read = in_body((mesh, &volumes), reading, |node| relative(node)[i])?;
                        Ok(read.value * read.value)
                    };
                    let squares: Result<f64, ProbeError<D>> = (0..D).map(part).sum();
                    Ok(squares?.sqrt().into())
                }
                Displacement::Magnitude => {
                    in_body((mesh, &volumes), reading, |node| norm(relative(node)))
                }
            }
        }
        Parts::Stress(of, component) => {
            let (mesh, solved) = body(of);
            let value = |node: usize| match component {
                Stress::Hoop if model.analysis != Analysis::Axisymmetric => {
                    hoop(solved.stress[node], sub(mesh.points()[node], probe.center))
                }
                _ => stress(component, solved.stress[node]),
            };
            in_body((mesh, &|| volumes(of)), reading, value)
        }
        Parts::Along(of, field) => {
            let contact = &solution.contacts[of];
            let value = |node: &ContactNode<D>| along(field, node, &minus);
            let nodal = |node: usize| {
                let found = contact.nodes.iter().find(|n| n.node == node);
                found.map_or(f64::NAN, value)
            };
            let samples = contact.nodes.iter();
            let samples = samples.map(|node| (node.point, node.weight, value(node)));
            match reduced(reading, samples) {
                Some(read) => Ok(read),
                None => Ok(on_side(model, &contact.nonmortar, reading, nodal)?.into()),
            }
        }
    }
}

/// A quantity at a node of a contact; a displacement is that beside the rigid motion `minus`.
fn along<const D: usize>(
    field: ContactField,
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
        ContactField::Slip => tangential(node.slip),
        ContactField::DisplacementNonmortar => beside_rigid(node.displacement_nonmortar),
        ContactField::DisplacementMortar => beside_rigid(node.displacement_mortar),
    }
}

fn stress(component: Stress, s: [f64; 6]) -> f64 {
    match component {
        Stress::Component(i) => s[i],
        Stress::VonMises => von_mises(s),
        Stress::First => principal(s)[0],
        Stress::Second => principal(s)[1],
        Stress::Third => principal(s)[2],
        Stress::Tresca => principal(s)[0] - principal(s)[2],
        // around the axis of symmetry
        Stress::Hoop => s[2],
    }
}

/// Stress of a plane analysis in the direction around a centre, at this place from it; NaN in the centre.
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

/// One number of some at nodes; those that are no numbers do not count. `None` where it is read at a point.
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
        Reading::Whole | Reading::At(_) | Reading::MeanOfNeighbours(_) => None,
    }
}

/// The value that is before all others, and its place; of equal ones the first.
fn first<const D: usize>(
    samples: impl Iterator<Item = Sample<D>>,
    before: fn(f64, f64) -> bool,
) -> Read<D> {
    let found = samples.reduce(|best, next| if before(next.2, best.2) { next } else { best });
    Read {
        value: found.map_or(f64::NAN, |(.., value)| value),
        at: found.map(|(point, ..)| point),
    }
}

/// Sum of the shares, and of the shares times the values.
fn sums<const D: usize>(samples: impl Iterator<Item = Sample<D>>) -> (f64, f64) {
    samples.fold((0.0, 0.0), |(whole, sum), (_, share, value)| {
        (whole + share, sum + share * value)
    })
}

fn in_body<const D: usize>(
    (mesh, volumes): (&Mesh<D>, &dyn Fn() -> Vec<f64>),
    reading: Reading<D>,
    value: impl Fn(usize) -> f64,
) -> Result<Read<D>, ProbeError<D>> {
    let volumes = matches!(reading, Reading::Mean | Reading::Integral).then(volumes);
    let volume = |node: usize| volumes.as_ref().map_or(0.0, |volumes| volumes[node]);
    let nodes = mesh.points().iter().enumerate();
    let samples = nodes.map(|(node, &point)| (point, volume(node), value(node)));
    if let Some(reduced) = reduced(reading, samples) {
        return Ok(reduced);
    }
    let at = reading.point().ok_or(ProbeError::NoPlace)?;
    Ok(interpolated(mesh, reading, in_cell(mesh, at)?, value).into())
}

fn in_cell<const D: usize>(
    mesh: &Mesh<D>,
    at: Point<D>,
) -> Result<(Vec<usize>, Vec<f64>), ProbeError<D>> {
    locate(mesh, at).ok_or(ProbeError::Outside { point: at })
}

fn on_side<const D: usize>(
    model: &Model<D>,
    side: &SideRef,
    reading: Reading<D>,
    value: impl Fn(usize) -> f64,
) -> Result<f64, ProbeError<D>> {
    let at = reading.point().ok_or(ProbeError::NoPlace)?;
    if D != 2 {
        return Err(ProbeError::SideInSpace);
    }
    let mesh = &model.bodies[side.body.0].mesh;
    let found = locate_on_side(mesh, side_facets(mesh, &side.side)?, at);
    let mut found = found.ok_or(ProbeError::Beside { point: at })?;
    // a node with no part in the value may have none, which is NaN
    found
        .1
        .iter_mut()
        .filter(|n| n.abs() < NO_WEIGHT)
        .for_each(|n| *n = 0.0);
    Ok(interpolated(mesh, reading, found, value))
}

/// The value at a point of a cell or facet with these nodes and shape functions; a node without weight does not count.
fn interpolated<const D: usize>(
    mesh: &Mesh<D>,
    reading: Reading<D>,
    (nodes, shape): (Vec<usize>, Vec<f64>),
    value: impl Fn(usize) -> f64,
) -> f64 {
    if let Reading::MeanOfNeighbours(at) = reading {
        return mean_of_neighbours(mesh, nodes, at, value);
    }
    let parts = nodes.into_iter().zip(shape);
    let part = |(node, n): (usize, f64)| if n == 0.0 { 0.0 } else { n * value(node) };
    parts.map(part).sum()
}

/// Mean of the values at the two end nodes of a facet; a point on a node takes that node.
fn mean_of_neighbours<const D: usize>(
    mesh: &Mesh<D>,
    mut nodes: Vec<usize>,
    at: Point<D>,
    value: impl Fn(usize) -> f64,
) -> f64 {
    // on a curved facet the middle node splits it: the neighbours are the two nodes nearest to the point
    nodes.sort_by(|&a, &b| {
        distance(mesh.points()[a], at).total_cmp(&distance(mesh.points()[b], at))
    });
    let spacing = distance(mesh.points()[nodes[0]], mesh.points()[nodes[1]]);
    if distance(mesh.points()[nodes[0]], at) < ON_THE_NODE * spacing {
        return value(nodes[0]);
    }
    0.5 * (value(nodes[0]) + value(nodes[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_principal_stress_and_trescas_are_read() {
        let state = [3.0, 1.0, -2.0, 0.0, 0.0, 0.0];
        let read = |component: Stress| stress(component, state);
        assert!((read(Stress::Second) - 1.0).abs() < 1e-12);
        assert!((read(Stress::Tresca) - 5.0).abs() < 1e-12);
    }
}
