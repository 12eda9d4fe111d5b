//! Probes: numbers read off a solution, interpolated in the containing cell or along the nonmortar side.

use crate::fem::{RigidBasis, fit_rigid, show, side_facets};
use crate::geometry::{Point, add_scaled, distance, dot, norm, sub};
use crate::mesh::{Facet, MAX_CELL_NODES, Mesh};
use crate::model::error::Error;
use crate::model::nouns::{Model, Probe, Reduce};
use crate::model::recover::centroid;
use crate::model::solution::{BodySolution, ContactNode, ContactSolution, ProbeValue, Solution};

/// A quantity of the contract, parsed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Quantity<'a> {
    Displacement {
        body: usize,
        component: &'a str,
    },
    Stress {
        body: usize,
        component: &'a str,
    },
    Reaction {
        body: usize,
        side: Option<&'a str>,
        axis: usize,
    },
    Contact {
        contact: usize,
        field: &'a str,
    },
    Resultant {
        contact: usize,
        axis: usize,
    },
    Length {
        contact: usize,
    },
}

impl<const D: usize> Model<D> {
    /// Reads all probes of the model off a solution.
    ///
    /// Errors: unknown quantities, points outside, with the probe's name.
    pub(crate) fn read_probes(&self, solution: &Solution<D>) -> Result<Vec<ProbeValue>, Error<D>> {
        let read = |probe: &Probe<D>| {
            let value = self
                .read_probe(solution, probe)
                .map_err(|message| Error::Probe {
                    probe: probe.name.clone(),
                    message,
                })?;
            Ok(ProbeValue {
                name: probe.name.clone(),
                quantity: probe.quantity.clone(),
                value,
            })
        };
        self.probes.iter().map(read).collect()
    }

    /// Checks that every probe can be read, before anything is solved.
    pub(crate) fn check_probes(&self) -> Result<(), Error<D>> {
        for probe in &self.probes {
            let check =
                self.parse(&probe.quantity)
                    .and_then(|quantity| match (quantity, probe.at) {
                        (
                            Quantity::Displacement { body, .. } | Quantity::Stress { body, .. },
                            Some(at),
                        ) => locate(&self.bodies[body].mesh, at).map(|_| ()),
                        _ => Ok(()),
                    });
            check.map_err(|message| Error::Probe {
                probe: probe.name.clone(),
                message,
            })?;
        }
        Ok(())
    }

    fn parse<'a>(&self, text: &'a str) -> Result<Quantity<'a>, String> {
        let words: Vec<&str> = text.split('.').collect();
        let axis = |name: &str| {
            let found = ["x", "y", "z"]
                .iter()
                .take(D)
                .position(|&axis| axis == name);
            found.ok_or_else(|| format!("\"{text}\": there is no component {name}"))
        };
        let body = self.bodies.iter().position(|body| body.name == words[0]);
        let contact = self
            .contacts
            .iter()
            .position(|contact| contact.name == words[0]);
        match (&words[1..], body, contact) {
            (["displacement", component], Some(body), _) => {
                Ok(Quantity::Displacement { body, component })
            }
            (["stress", component], Some(body), _) => Ok(Quantity::Stress { body, component }),
            (["reaction", component], Some(body), _) => Ok(Quantity::Reaction {
                body,
                side: None,
                axis: axis(component)?,
            }),
            ([side, "reaction", component], Some(body), _) => Ok(Quantity::Reaction {
                body,
                side: Some(side),
                axis: axis(component)?,
            }),
            (["resultant", component], _, Some(contact)) => Ok(Quantity::Resultant {
                contact,
                axis: axis(component)?,
            }),
            (["length"], _, Some(contact)) => Ok(Quantity::Length { contact }),
            ([field], _, Some(contact)) => Ok(Quantity::Contact { contact, field }),
            _ => Err(format!(
                "\"{text}\" is not a quantity of a body or contact of this model"
            )),
        }
    }

    fn read_probe(&self, solution: &Solution<D>, probe: &Probe<D>) -> Result<f64, String> {
        let rigid = match &probe.minus_rigid {
            None => None,
            Some(name) => Some(self.free_motion(solution, name)?),
        };
        let minus = |point: Point<D>| rigid.as_ref().map_or([0.0; D], |motion| motion(point));
        match self.parse(&probe.quantity)? {
            Quantity::Reaction { body, side, axis } => self.reaction(solution, body, side, axis),
            Quantity::Resultant { contact, axis } => Ok(solution.contacts[contact].resultant[axis]),
            Quantity::Length { contact } => Ok(solution.contacts[contact].length),
            Quantity::Displacement { body, component } => {
                let u = &solution.bodies[body].displacement;
                let mesh = &self.bodies[body].mesh;
                let relative: Vec<Point<D>> = u
                    .iter()
                    .zip(mesh.points())
                    .map(|(&u, &x)| sub(u, minus(x)))
                    .collect();
                if component == "magnitude" {
                    let reduced = probe
                        .reduce
                        .map(|reduce| reduce_over(reduce, relative.iter().map(|&u| norm(u))));
                    return match reduced {
                        Some(value) => Ok(value),
                        None => {
                            let parts = (0..D)
                                .map(|i| at_node_or_cell(mesh, probe, |node| relative[node][i]));
                            Ok(parts
                                .map(|p| p.map(|v| v * v))
                                .sum::<Result<f64, _>>()?
                                .sqrt())
                        }
                    };
                }
                let axis = ["x", "y", "z"]
                    .iter()
                    .take(D)
                    .position(|&axis| axis == component);
                let axis = axis
                    .ok_or_else(|| format!("there is no displacement component \"{component}\""))?;
                read_nodal(mesh, probe, |node| relative[node][axis])
            }
            Quantity::Stress { body, component } => {
                let pick = stress_component(component)?;
                let stress = &solution.bodies[body].stress;
                read_nodal(&self.bodies[body].mesh, probe, |node| pick(stress[node]))
            }
            Quantity::Contact { contact, field } => {
                self.read_contact(&solution.contacts[contact], probe, field, &minus)
            }
        }
    }

    fn read_contact(
        &self,
        contact: &ContactSolution<D>,
        probe: &Probe<D>,
        field: &str,
        minus: &dyn Fn(Point<D>) -> Point<D>,
    ) -> Result<f64, String> {
        let tangent = |n: &ContactNode<D>| -> Point<D> {
            std::array::from_fn(|i| {
                if D == 2 {
                    [-n.normal[1], n.normal[0]][i]
                } else {
                    0.0
                }
            })
        };
        let value = |n: &ContactNode<D>| -> f64 {
            match field {
                "pressure" => n.pressure,
                "gap" => n.gap,
                "shear" => dot(n.shear, tangent(n)),
                "slip" => dot(n.slip, tangent(n)),
                "displacement_nonmortar" => {
                    n.displacement_nonmortar - dot(n.normal, minus(n.point))
                }
                "displacement_mortar" => n.displacement_mortar - dot(n.normal, minus(n.point)),
                _ => f64::NAN,
            }
        };
        let known = [
            "pressure",
            "gap",
            "shear",
            "slip",
            "displacement_nonmortar",
            "displacement_mortar",
        ];
        if !known.contains(&field) {
            return Err(format!(
                "a contact has no quantity \"{field}\"; it has {}",
                known.join(", ")
            ));
        }
        if let Some(reduce) = probe.reduce {
            return Ok(reduce_over(reduce, contact.nodes.iter().map(value)));
        }
        let at = probe.at.ok_or("`at` or `reduce` is missing")?;
        let mesh = &self.bodies[contact.nonmortar.body.0].mesh;
        let nodal = |node: usize| {
            contact
                .nodes
                .iter()
                .find(|n| n.node == node)
                .map_or(f64::NAN, value)
        };
        let facets =
            side_facets(mesh, &contact.nonmortar.side).map_err(|error| error.to_string())?;
        let (facet, xi) = nearest_facet(mesh, facets, at)?;
        let kind = mesh.facet_kind(facet);
        let mut shape = [0.0; MAX_CELL_NODES];
        kind.shape(&[xi], &mut shape);
        let nodes = mesh.facet_nodes(facet).map(|node| node as usize);
        if probe.mean_of_neighbours {
            return Ok(mean_of_neighbours(mesh, nodes, at, nodal));
        }
        Ok(nodes
            .zip(shape)
            .map(|(node, n)| {
                if n.abs() < 1e-12 {
                    0.0
                } else {
                    n * nodal(node)
                }
            })
            .sum())
    }

    fn reaction(
        &self,
        solution: &Solution<D>,
        body: usize,
        side: Option<&str>,
        axis: usize,
    ) -> Result<f64, String> {
        let solved = &solution.bodies[body];
        match side {
            None => Ok(solved.reaction[axis]),
            Some(side) => {
                let forces = &solved.side_reactions;
                let known = self.bodies[body].mesh.side(side).is_some();
                match forces.get(side) {
                    Some(force) => Ok(force[axis]),
                    None if known => Ok(0.0),
                    None => Err(format!("body \"{}\" has no side \"{side}\"", solved.name)),
                }
            }
        }
    }

    /// The rigid motion that a body's own supports leave free, at its least-squares amplitude, as a function of place.
    fn free_motion(
        &self,
        solution: &Solution<D>,
        name: &str,
    ) -> Result<impl Fn(Point<D>) -> Point<D> + use<D>, String> {
        let index = self.bodies.iter().position(|body| body.name == name);
        let index = index.ok_or_else(|| format!("minus_rigid: there is no body \"{name}\""))?;
        let BodySolution {
            displacement,
            floating_modes,
            ..
        } = &solution.bodies[index];
        let points = self.bodies[index].mesh.points();
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
            motions.push((translation.map(|t| amplitude * t), amplitude * spin[0]));
            basis.push(own);
        }
        Ok(move |point: Point<D>| {
            let x = sub(point, centre);
            motions.iter().fold([0.0; D], |sum, &(translation, spin)| {
                let turned = std::array::from_fn(|i| match i {
                    0 => -spin * x[1],
                    1 => spin * x[0],
                    _ => 0.0,
                });
                add_scaled(add_scaled(sum, 1.0, translation), 1.0, turned)
            })
        })
    }
}

fn inner<const D: usize>(a: &[Point<D>], b: &[Point<D>]) -> f64 {
    a.iter().zip(b).map(|(&x, &y)| dot(x, y)).sum()
}

fn reduce_over(reduce: Reduce, values: impl Iterator<Item = f64>) -> f64 {
    let numbers = values.filter(|value| !value.is_nan());
    match reduce {
        Reduce::Max => numbers.fold(f64::NAN, f64::max),
        Reduce::Min => numbers.fold(f64::NAN, f64::min),
    }
}

/// Mean of the values at the two end nodes of a facet; a point on a node takes that node.
fn mean_of_neighbours<const D: usize>(
    mesh: &Mesh<D>,
    nodes: impl Iterator<Item = usize>,
    at: Point<D>,
    value: impl Fn(usize) -> f64,
) -> f64 {
    // on a curved facet the middle node splits it: the neighbours are the two nodes nearest to the point
    let mut nodes: Vec<usize> = nodes.collect();
    nodes.sort_by(|&a, &b| {
        distance(mesh.points()[a], at).total_cmp(&distance(mesh.points()[b], at))
    });
    let spacing = distance(mesh.points()[nodes[0]], mesh.points()[nodes[1]]);
    if distance(mesh.points()[nodes[0]], at) < 1e-6 * spacing {
        return value(nodes[0]);
    }
    0.5 * (value(nodes[0]) + value(nodes[1]))
}

fn read_nodal<const D: usize>(
    mesh: &Mesh<D>,
    probe: &Probe<D>,
    value: impl Fn(usize) -> f64,
) -> Result<f64, String> {
    match probe.reduce {
        Some(reduce) => Ok(reduce_over(reduce, (0..mesh.points().len()).map(value))),
        None => at_node_or_cell(mesh, probe, value),
    }
}

fn at_node_or_cell<const D: usize>(
    mesh: &Mesh<D>,
    probe: &Probe<D>,
    value: impl Fn(usize) -> f64,
) -> Result<f64, String> {
    let at = probe.at.ok_or("`at` or `reduce` is missing")?;
    let (nodes, shape) = locate(mesh, at)?;
    if probe.mean_of_neighbours {
        return Ok(mean_of_neighbours(mesh, nodes.into_iter(), at, value));
    }
    Ok(nodes
        .into_iter()
        .zip(shape)
        .map(|(node, n)| n * value(node))
        .sum())
}

fn stress_component(name: &str) -> Result<impl Fn([f64; 6]) -> f64, String> {
    let names = ["xx", "yy", "zz", "xy", "yz", "xz", "von_mises", "s1", "s3"];
    let index = names.iter().position(|&n| n == name);
    let index = index.ok_or_else(|| {
        format!(
            "there is no stress component \"{name}\"; there are {}",
            names.join(", ")
        )
    })?;
    Ok(move |s: [f64; 6]| match index {
        0..=5 => s[index],
        6 => crate::fem::von_mises(s),
        7 => principal(s)[0],
        _ => principal(s)[2],
    })
}

/// Principal stresses, largest first, by the trigonometric solution of the characteristic equation.
fn principal(s: [f64; 6]) -> [f64; 3] {
    let mean = (s[0] + s[1] + s[2]) / 3.0;
    let d = [s[0] - mean, s[1] - mean, s[2] - mean];
    let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    let j2 = 0.5 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) + shear;
    if j2 == 0.0 {
        return [mean; 3];
    }
    // det of the deviator with entries xy = s[3], yz = s[4], xz = s[5]
    let j3 = d[0] * (d[1] * d[2] - s[4] * s[4]) - s[3] * (s[3] * d[2] - s[4] * s[5])
        + s[5] * (s[3] * s[4] - d[1] * s[5]);
    let radius = 2.0 * (j2 / 3.0).sqrt();
    let cosine = (0.5 * j3 * (3.0 / j2).powf(1.5)).clamp(-1.0, 1.0);
    let angle = cosine.acos() / 3.0;
    let third = 2.0 * std::f64::consts::PI / 3.0;
    let mut values = [0.0, -third, third].map(|shift| mean + radius * (angle + shift).cos());
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// A point may lie outside a cell by this much in reference coordinates: a polygon's sagitta, not more.
const OUTSIDE: f64 = 0.1;

/// Nodes and shape functions of the cell that contains a point.
fn locate<const D: usize>(
    mesh: &Mesh<D>,
    point: Point<D>,
) -> Result<(Vec<usize>, Vec<f64>), String> {
    let mut best: Option<(f64, Vec<usize>, [f64; MAX_CELL_NODES])> = None;
    for block in mesh.blocks() {
        for cell in block.cells() {
            let corners: Vec<Point<D>> = cell
                .iter()
                .map(|&node| mesh.points()[node as usize])
                .collect();
            let (low, high) = crate::geometry::bounding_box(&corners);
            let margin = 0.2 * distance(low, high);
            if (0..D).any(|i| point[i] < low[i] - margin || point[i] > high[i] + margin) {
                continue;
            }
            let Some(xi) = invert_map(block.kind, &corners, point) else {
                continue;
            };
            let outside = outside(block.kind, &xi);
            if best.as_ref().is_none_or(|b| outside < b.0) {
                let mut shape = [0.0; MAX_CELL_NODES];
                block.kind.shape(&xi, &mut shape);
                best = Some((
                    outside,
                    cell.iter().map(|&node| node as usize).collect(),
                    shape,
                ));
            }
        }
    }
    match best {
        Some((outside, nodes, shape)) if outside <= OUTSIDE => {
            let shape = shape[..nodes.len()].to_vec();
            Ok((nodes, shape))
        }
        _ => Err(format!("the point {} lies outside the body", show(point))),
    }
}

/// By how much reference coordinates lie outside a plane cell; negative inside.
fn outside(kind: crate::mesh::CellKind, xi: &[f64]) -> f64 {
    match kind.corners() {
        3 => (xi[0] + xi[1] - 1.0).max(-xi[0]).max(-xi[1]),
        _ => xi
            .iter()
            .fold(f64::NEG_INFINITY, |largest, c| largest.max(c.abs() - 1.0)),
    }
}

/// Reference coordinates of a point in a cell by Newton's method; `None` when it does not settle.
fn invert_map<const D: usize>(
    kind: crate::mesh::CellKind,
    nodes: &[Point<D>],
    point: Point<D>,
) -> Option<[f64; D]> {
    let corners = kind.corners();
    let mut xi: [f64; D] = std::array::from_fn(|i| {
        kind.reference_nodes()[..corners]
            .iter()
            .map(|node| node[i])
            .sum::<f64>()
            / corners as f64
    });
    for _ in 0..30 {
        let (mut shape, mut gradients) = ([0.0; MAX_CELL_NODES], [[0.0; D]; MAX_CELL_NODES]);
        kind.shape(&xi, &mut shape);
        kind.gradients(&xi, &mut gradients);
        let mut x = [0.0; D];
        let mut jacobian = [[0.0; D]; D];
        for (a, node) in nodes.iter().enumerate() {
            for i in 0..D {
                x[i] += shape[a] * node[i];
                for j in 0..D {
                    jacobian[i][j] += node[i] * gradients[a][j];
                }
            }
        }
        let (inverse, det) = crate::geometry::invert(&jacobian);
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let rest = sub(point, x);
        let mut step: f64 = 0.0;
        for i in 0..D {
            let change = (0..D).map(|j| inverse[i][j] * rest[j]).sum::<f64>();
            xi[i] += change;
            step = step.max(change.abs());
        }
        if step < 1e-13 {
            break;
        }
    }
    xi.iter().all(|c| c.is_finite()).then_some(xi)
}

/// A point may lie beside a side by this fraction of a facet: the sagitta of a polygon, not more.
const BESIDE: f64 = 0.1;

/// A point may lie beyond the end of a side by this fraction of a facet: rounding, not more.
const BEYOND: f64 = 1e-6;

/// The facet of a side that is nearest to a point, and the coordinate of the nearest point on it.
fn nearest_facet<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[Facet],
    point: Point<D>,
) -> Result<(Facet, f64), String> {
    let mut best: Option<(f64, Facet, f64, f64)> = None;
    for &facet in facets {
        let ends: Vec<Point<D>> = mesh.facet_points(facet).take(2).collect();
        let length = distance(ends[0], ends[1]);
        let chord = sub(ends[1], ends[0]);
        let mut xi =
            (2.0 * dot(sub(point, ends[0]), chord) / (length * length) - 1.0).clamp(-1.0, 1.0);
        for _ in 0..20 {
            let h = 1e-6;
            let (back, here, ahead) = (
                mesh.facet_point(facet, &[xi - h]),
                mesh.facet_point(facet, &[xi]),
                mesh.facet_point(facet, &[xi + h]),
            );
            let tangent = sub(ahead, back).map(|c| c / (2.0 * h));
            let step = dot(sub(point, here), tangent) / dot(tangent, tangent);
            let next = (xi + step).clamp(-1.0, 1.0);
            if (next - xi).abs() < 1e-12 {
                xi = next;
                break;
            }
            xi = next;
        }
        let gap = distance(point, mesh.facet_point(facet, &[xi]));
        if best.is_none_or(|b| gap < b.0) {
            best = Some((gap, facet, xi, length));
        }
    }
    match best {
        Some((gap, facet, xi, length))
            if gap <= BESIDE * length
                && beyond_the_end(mesh, facets, facet, xi, point) <= BEYOND * length =>
        {
            Ok((facet, xi))
        }
        _ => Err(format!(
            "the point {} does not lie on the nonmortar side",
            show(point)
        )),
    }
}

/// By how much a point lies beyond the end of a side whose nearest place is ξ of a facet; zero elsewhere.
fn beyond_the_end<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[Facet],
    facet: Facet,
    xi: f64,
    point: Point<D>,
) -> f64 {
    if xi.abs() < 1.0 {
        return 0.0;
    }
    let ends: Vec<u32> = mesh.facet_nodes(facet).take(2).collect();
    let node = ends[usize::from(xi > 0.0)];
    let touching = facets
        .iter()
        .filter(|&&f| mesh.facet_nodes(f).take(2).any(|n| n == node));
    if touching.count() > 1 {
        return 0.0;
    }
    let [here, inside] = [xi, xi - 1e-6 * xi].map(|xi| mesh.facet_point(facet, &[xi]));
    let outwards = sub(here, inside);
    dot(sub(point, here), outwards) / norm(outwards)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stresses_of_known_states() {
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12);
        assert!(close(
            principal([3.0, 1.0, -2.0, 0.0, 0.0, 0.0]),
            [3.0, 1.0, -2.0]
        ));
        assert!(close(
            principal([0.0, 0.0, 0.0, 5.0, 0.0, 0.0]),
            [5.0, 0.0, -5.0]
        ));
        assert!(close(
            principal([-2.0, -2.0, -2.0, 0.0, 0.0, 0.0]),
            [-2.0; 3]
        ));
    }
}
