//! Consistent nodal forces: f = ∫ N·b dV + ∫ N·t dS + point forces, on the undeformed body.

use crate::fem::cells::{CellTable, measure};
use crate::fem::error::FemError;
use crate::fem::nouns::{Analysis, Body, Load};
use crate::fem::quadrature::{self, QuadraturePoint};
use crate::fem::supports::{finite, nearest_node, side_facets};
use crate::geometry::{Point, add_scaled, norm};
use crate::mesh::MAX_FACET_NODES;

/// Nodal forces of the loads of one body.
pub(crate) struct NodalLoads {
    /// (D·nodes,) in global axes.
    pub forces: Vec<f64>,
    /// Resultant of the largest single load, a force. A load that nearly balances itself, such as pressure all around
    /// a ring, counts with the sum of its magnitudes: its resultant is rounding.
    pub largest: f64,
}

/// A load counts as balanced in itself when its resultant is below this fraction of the sum of its magnitudes.
const BALANCED: f64 = 1e-3;

/// Resultant of one load, and the sum of its magnitudes.
struct Size<const D: usize> {
    resultant: Point<D>,
    magnitude: f64,
}

impl<const D: usize> Size<D> {
    fn zero() -> Self {
        Self {
            resultant: [0.0; D],
            magnitude: 0.0,
        }
    }

    fn add(&mut self, force: Point<D>) {
        self.resultant = add_scaled(self.resultant, 1.0, force);
        self.magnitude += norm(force);
    }

    fn scale(&self) -> f64 {
        let resultant = norm(self.resultant);
        if resultant < BALANCED * self.magnitude {
            self.magnitude
        } else {
            resultant
        }
    }
}

/// Nodal forces of all loads of a body at a time.
pub(crate) fn nodal_loads<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    time: f64,
) -> Result<NodalLoads, FemError> {
    let mut forces = vec![0.0; D * body.mesh.points().len()];
    let mut largest = add_body_force(body, analysis, time, &mut forces)?.scale();
    for load in &body.loads {
        let size = match load {
            Load::Traction { side, traction } => {
                let what = || format!("traction on side \"{side}\"");
                add_side_load(body, side, analysis, &mut forces, |point, _| {
                    let mut t = [0.0; D];
                    for (component, field) in t.iter_mut().zip(traction) {
                        *component = finite(field, point, time, what)?;
                    }
                    Ok(t)
                })?
            }
            Load::Pressure { side, pressure } => {
                let what = || format!("pressure on side \"{side}\"");
                add_side_load(body, side, analysis, &mut forces, |point, normal| {
                    let p = finite(pressure, point, time, what)?;
                    Ok(normal.map(|n| -p * n))
                })?
            }
            Load::Force { point, force } => {
                let node = nearest_node(&body.mesh, *point, "point force")?;
                let mut size = Size::zero();
                let mut total = [0.0; D];
                for (i, field) in force.iter().enumerate() {
                    total[i] = finite(field, body.mesh.points()[node], time, || {
                        "point force".to_string()
                    })?;
                    forces[D * node + i] += total[i];
                }
                size.add(total);
                size
            }
        };
        largest = largest.max(size.scale());
    }
    Ok(NodalLoads { forces, largest })
}

/// Adds ∫ N·t dS over a side and returns its size; `traction` maps (point, outward unit normal) to t.
fn add_side_load<const D: usize>(
    body: &Body<D>,
    side: &str,
    analysis: Analysis,
    forces: &mut [f64],
    traction: impl Fn(Point<D>, Point<D>) -> Result<Point<D>, FemError>,
) -> Result<Size<D>, FemError> {
    let mesh = &body.mesh;
    let mut size = Size::zero();
    for &facet in side_facets(mesh, side)? {
        let kind = mesh.facet_kind(facet);
        let mut shape = [0.0; MAX_FACET_NODES];
        for QuadraturePoint { xi, weight } in quadrature::rule(kind, LOAD_DEGREE) {
            kind.shape(&xi, &mut shape);
            let point = mesh.facet_point(facet, &xi);
            let normal = mesh.outward_normal(facet, &xi);
            let area = norm(normal);
            let t = traction(point, normal.map(|n| n / area))?;
            let w = weight * area * measure(analysis, body.thickness, point);
            size.add(t.map(|c| w * c));
            for (node, n) in mesh.facet_nodes(facet).zip(shape) {
                for i in 0..D {
                    forces[D * node as usize + i] += w * n * t[i];
                }
            }
        }
    }
    Ok(size)
}

/// Loads may be any expression: integrate them to well above the order of the cells.
const LOAD_DEGREE: usize = 9;

fn add_body_force<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    time: f64,
    forces: &mut [f64],
) -> Result<Size<D>, FemError> {
    let mut size = Size::zero();
    if body
        .body_force
        .iter()
        .all(|field| field.as_constant() == Some(0.0))
    {
        return Ok(size);
    }
    let mesh = &body.mesh;
    for block in mesh.blocks() {
        let table = CellTable::<D>::new(block.kind, 2 * block.kind.order() + 2);
        for cell in block.cells() {
            for q in 0..table.len() {
                let (point, _, volume) = table.map(q, |local| mesh.points()[cell[local] as usize]);
                let w = volume * measure(analysis, body.thickness, point);
                let mut force = [0.0; D];
                for (i, field) in body.body_force.iter().enumerate() {
                    let b = finite(field, point, time, || "body_force".to_string())?;
                    force[i] = w * b;
                    for (local, &node) in cell.iter().enumerate() {
                        forces[D * node as usize + i] += w * table.shape(q)[local] * b;
                    }
                }
                size.add(force);
            }
        }
    }
    Ok(size)
}
