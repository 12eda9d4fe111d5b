//! Consistent nodal forces: f = ∫ N·b dV + ∫ N·t dS + point forces − ∫ (σ₀ − Cε₀)·∇N dV, on the undeformed body.

use crate::fem::borders::Borders;
use crate::fem::cells::{CellTable, measure};
use crate::fem::error::FemError;
use crate::fem::initial::{Components, body_degree};
use crate::fem::nouns::{Active, Analysis, Body, History, Place};
use crate::fem::quadrature::{self, QuadraturePoint};
use crate::fem::sides::side_facets;
use crate::fem::supports::{describe, finite, nearest_node};
use crate::geometry::{Field, Point, add_scaled, norm};
use crate::mesh::{CellKind, Facet, MAX_FACET_NODES, Mesh};
use std::collections::BTreeMap;
use std::rc::Rc;

/// An external load on the undeformed body.
#[derive(Debug, Clone)]
pub enum Load<const D: usize> {
    /// Force per area in global axes on a side.
    Traction {
        /// Side of the body.
        side: String,
        /// Components.
        traction: [Field; D],
    },
    /// Pressure on a side; positive pushes into the body.
    Pressure {
        /// Side of the body.
        side: String,
        /// Force per area.
        pressure: Field,
    },
    /// Resultant on a side, in global axes, spread evenly: its force per area is the same everywhere. With axial symmetry
    /// it is that of the full turn.
    Resultant {
        /// Side of the body.
        side: String,
        /// Components, functions of time alone.
        force: [Field; D],
    },
    /// The traction with which ground that is not yet excavated holds a side: its initial stress times the outward normal,
    /// times a factor. 1 is untouched ground, 0 is excavated.
    InSitu {
        /// Side of the body.
        side: String,
        /// The remaining part of the traction.
        factor: Field,
        /// The initial stress of the body.
        stress: Box<Components>,
    },
    /// Force at the node nearest to a point.
    Force {
        /// The point.
        point: Point<D>,
        /// Components.
        force: [Field; D],
    },
}

/// The unit of a load's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Amount {
    /// Force per area.
    PerArea,
    /// Force.
    Whole,
}

impl<const D: usize> Load<D> {
    /// Where it acts.
    pub fn place(&self) -> Place<D> {
        match self {
            Self::Traction { side, .. }
            | Self::Pressure { side, .. }
            | Self::InSitu { side, .. }
            | Self::Resultant { side, .. } => Place::Side(side.clone()),
            Self::Force { point, .. } => Place::Point(*point),
        }
    }

    /// The kind of the values of [`Self::at`].
    pub fn amount(&self) -> Amount {
        match self {
            Self::Traction { .. } | Self::Pressure { .. } | Self::InSitu { .. } => Amount::PerArea,
            Self::Resultant { .. } | Self::Force { .. } => Amount::Whole,
        }
    }

    /// Its values at points of its place with their normals, one for each, as [`Self::at`] has them; what is sampled is so for all at
    /// once.
    pub(crate) fn values(&self, places: &[(Point<D>, Point<D>)], time: f64) -> Vec<Point<D>> {
        Field::prepare(self.fields(), places.iter().map(|place| place.0), time);
        let value = |&(point, normal): &(Point<D>, Point<D>)| self.at(point, normal, time);
        places.iter().map(value).collect()
    }

    /// Its value at a point of its place at a time, in global axes; `normal` is the outward unit normal of a side.
    pub fn at(&self, point: Point<D>, normal: Point<D>, time: f64) -> Point<D> {
        match self {
            Self::Traction {
                traction: values, ..
            }
            | Self::Resultant { force: values, .. }
            | Self::Force { force: values, .. } => {
                std::array::from_fn(|i| values[i].at(point, time))
            }
            Self::Pressure { pressure, .. } => normal.map(|n| -pressure.at(point, time) * n),
            Self::InSitu { factor, stress, .. } => {
                let left = factor.at(point, time);
                stress.traction(point, normal, time).map(|t| left * t)
            }
        }
    }

    /// The same while `active`, zero at other times.
    pub fn during(mut self, active: Active) -> Self {
        let fields: &mut [Field] = match &mut self {
            Self::Traction { traction, .. } => traction,
            Self::Pressure { pressure, .. } => std::slice::from_mut(pressure),
            Self::InSitu { factor, .. } => std::slice::from_mut(factor),
            Self::Resultant { force, .. } | Self::Force { force, .. } => force,
        };
        for field in fields {
            *field = active.gate(field.clone());
        }
        self
    }

    /// All its expressions, those of the initial stress included.
    fn fields(&self) -> impl Iterator<Item = &Field> {
        let stress = match self {
            Self::InSitu { stress, .. } => &stress.0[..],
            _ => &[],
        };
        self.told().1.iter().chain(stress)
    }

    /// Its name in messages, and its expressions.
    fn told(&self) -> (&'static str, &[Field]) {
        match self {
            Self::Traction { traction, .. } => ("traction", traction),
            Self::Pressure { pressure, .. } => ("pressure", std::slice::from_ref(pressure)),
            Self::InSitu { factor, .. } => ("in_situ", std::slice::from_ref(factor)),
            Self::Resultant { force, .. } | Self::Force { force, .. } => ("force", force),
        }
    }

    /// As [`Self::at`]; an error names the expression that is not finite.
    fn finite_at(
        &self,
        point: Point<D>,
        normal: Point<D>,
        time: f64,
    ) -> Result<Point<D>, FemError> {
        let (name, fields) = self.told();
        for field in fields {
            finite(field, point, time, || {
                format!("{name} {}", describe(&self.place()))
            })?;
        }
        if let Self::InSitu { stress, .. } = self {
            stress.finite_at("initial_stress", point, time)?;
        }
        Ok(self.at(point, normal, time))
    }
}

/// Nodal forces of the loads of one body.
pub(crate) struct NodalLoads {
    /// (D·nodes,) in global axes.
    pub forces: Vec<f64>,
    /// Resultant of the largest single load, a force. A load that nearly balances itself, such as pressure all around
    /// a ring, counts with the sum of its magnitudes: its resultant is rounding.
    pub largest: f64,
    /// By node, the uncertainty of the force there as the imbalance of initial stress and loads; empty without an initial stress.
    pub rounding: Vec<f64>,
}

/// Tolerance of parts in [0, 1]: rounding of expressions.
const PART: f64 = 1e-9;

/// A load counts as self-balanced if its resultant is below this fraction of the sum of its magnitudes.
const BALANCED: f64 = 1e-3;

/// Resultant of one load, and the sum of its magnitudes.
pub(crate) struct Size<const D: usize> {
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

    /// Size of nodal forces (nodes,).
    pub fn of(forces: &[Point<D>]) -> Self {
        let mut size = Self::zero();
        forces.iter().for_each(|&force| size.add(force));
        size
    }

    /// The resultant; the sum of magnitudes where the forces balance themselves.
    pub fn scale(&self) -> f64 {
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
    (body, history): (&Body<D>, &History<D>),
    analysis: Analysis,
    time: f64,
) -> Result<NodalLoads, FemError> {
    let mut forces = vec![0.0; D * body.mesh.points().len()];
    let mut largest = add_body_force(body, analysis, time, &mut forces)?.scale();
    // an initial stress balances itself
    let held = body.initial.add_load(body, analysis, time, &mut forces)?;
    let (magnitude, rounding) = held.map_or_else(Default::default, |h| (h.magnitude, h.rounding));
    largest = largest.max(magnitude);
    for load in &body.loads {
        let size = add_load(body, load, analysis, time, &mut forces)?;
        largest = largest.max(size.scale());
    }
    for (left, factor) in &history.released {
        let mut size = Size::zero();
        let part = finite(factor, [0.0; D], time, || "release".to_string())?;
        if !(-PART..=1.0 + PART).contains(&part) {
            return Err(FemError::Release {
                text: factor.to_string(),
                value: part,
                time,
            });
        }
        for (sum, &force) in forces.chunks_exact_mut(D).zip(left.iter()) {
            (0..D).for_each(|i| sum[i] += part * force[i]);
            size.add(force.map(|c| part * c));
        }
        largest = largest.max(size.scale());
    }
    Ok(NodalLoads {
        forces,
        largest,
        rounding,
    })
}

/// Adds ∫ N·t dS over a side, or the force at the node nearest to a point, and returns its size.
fn add_load<const D: usize>(
    body: &Body<D>,
    load: &Load<D>,
    analysis: Analysis,
    time: f64,
    forces: &mut [f64],
) -> Result<Size<D>, FemError> {
    let mesh = &body.mesh;
    let mut size = Size::zero();
    let side = match load.place() {
        Place::Side(side) => side,
        Place::Point(point) => {
            let node = nearest_node(mesh, point, "point force")?;
            Field::prepare(load.fields(), [mesh.points()[node]], time);
            let force = load.finite_at(mesh.points()[node], [0.0; D], time)?;
            (0..D).for_each(|i| forces[D * node + i] += force[i]);
            size.add(force);
            return Ok(size);
        }
    };
    let places = || side_points(body, &side, analysis);
    let share = match load.amount() {
        Amount::PerArea => 1.0,
        Amount::Whole => {
            let area: f64 = places()?.map(|place| place.area).sum();
            if area <= 0.0 {
                return Err(FemError::NoArea { side });
            }
            1.0 / area
        }
    };
    let mut points = Vec::new();
    if load.fields().any(Field::is_sampled) {
        points.extend(places()?.map(|place| place.point));
    }
    Field::prepare(load.fields(), points, time);
    for place in places()? {
        let force = load.finite_at(place.point, place.normal, time)?;
        let force = force.map(|c| share * place.area * c);
        size.add(force);
        for (node, n) in mesh.facet_nodes(place.facet).zip(place.shape) {
            for i in 0..D {
                forces[D * node as usize + i] += n * force[i];
            }
        }
    }
    Ok(size)
}

/// Prepares fields at all points of integration of body forces and initial stresses, and at others.
pub(crate) fn prepare_within<'f, const D: usize>(
    body: &Body<D>,
    fields: impl IntoIterator<Item = &'f Field> + Clone,
    others: impl FnOnce() -> Vec<Point<D>>,
    time: f64,
) {
    if fields.clone().into_iter().any(Field::is_sampled) {
        let within = |kind: CellKind| CellTable::new(kind, body_degree(kind.order()));
        let points = points_within(&body.mesh, within).into_iter();
        Field::prepare(fields, points.chain(others()), time);
    }
}

/// The places of the points of a table in all cells of a mesh.
pub(crate) fn points_within<const D: usize>(
    mesh: &Mesh<D>,
    table: impl Fn(CellKind) -> CellTable<D>,
) -> Vec<Point<D>> {
    let nodes = mesh.points();
    let mut points = Vec::new();
    for block in mesh.blocks() {
        let table = table(block.kind);
        for cell in block.cells() {
            let at = |q| table.map(q, |local| nodes[cell[local] as usize]).0;
            points.extend((0..table.len()).map(at));
        }
    }
    points
}

/// A point of integration of a body.
pub(crate) struct VolumePoint<'a> {
    /// Index of the block of its cell.
    pub block: usize,
    /// The place of its cell in that.
    pub number: usize,
    /// Nodes of its cell.
    pub cell: &'a [u32],
    /// Of the nodes of the cell.
    pub shape: &'a [f64],
    /// Its part of the volume, with thickness or 2πr.
    pub volume: f64,
}

/// Goes through the points of integration of a body.
pub(crate) fn volume_points<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    mut visit: impl FnMut(VolumePoint<'_>),
) {
    let points = body.mesh.points();
    for (index, block) in body.mesh.blocks().iter().enumerate() {
        let table = CellTable::<D>::new(block.kind, 2 * block.kind.order() + 2);
        for (number, cell) in block.cells().enumerate() {
            for q in 0..table.len() {
                let (point, _, volume) = table.map(q, |local| points[cell[local] as usize]);
                visit(VolumePoint {
                    block: index,
                    number,
                    cell,
                    shape: table.shape(q),
                    volume: volume * measure(analysis, body.thickness, point),
                });
            }
        }
    }
}

/// ∫N dV of every place, (places,), with thickness or 2πr: the weights of a field at the places in its integral.
pub(crate) fn nodal_volumes<const D: usize>(
    body: &Body<D>,
    borders: &Borders,
    analysis: Analysis,
) -> Vec<f64> {
    let mut volumes = vec![0.0; borders.count()];
    volume_points(body, analysis, |at| {
        for (&node, shape) in at.cell.iter().zip(at.shape) {
            volumes[borders.place(at.block, node as usize)] += shape * at.volume;
        }
    });
    volumes
}

/// A point of integration of a side.
pub(crate) struct SidePoint<const D: usize> {
    pub facet: Facet,
    /// Reference coordinates on the facet.
    pub xi: [f64; 3],
    /// Of the nodes of the facet.
    pub shape: [f64; MAX_FACET_NODES],
    pub point: Point<D>,
    /// Outward unit normal.
    pub normal: Point<D>,
    /// Its part of the area, thickness or the full turn included.
    pub area: f64,
}

/// The points of integration of a side.
pub(crate) fn side_points<'a, const D: usize>(
    body: &'a Body<D>,
    side: &str,
    analysis: Analysis,
) -> Result<impl Iterator<Item = SidePoint<D>> + 'a, FemError> {
    points_of_degree(body, side, analysis, |_| LOAD_DEGREE)
}

/// The points of integration of a side, by the degree to which a kind of facets is integrated.
pub(crate) fn points_of_degree<'a, const D: usize>(
    body: &'a Body<D>,
    side: &str,
    analysis: Analysis,
    degree: impl Fn(CellKind) -> usize,
) -> Result<impl Iterator<Item = SidePoint<D>> + 'a, FemError> {
    let mesh = &body.mesh;
    let facets = side_facets(mesh, side)?;
    let mut rules: BTreeMap<CellKind, Rc<[Sample]>> = BTreeMap::new();
    for &facet in facets {
        let rule = |kind: &CellKind| samples(*kind, degree(*kind)).collect();
        let kind = mesh.facet_kind(facet);
        rules.entry(kind).or_insert_with_key(rule);
    }
    Ok(facets.iter().flat_map(move |&facet| {
        let rule = Rc::clone(&rules[&mesh.facet_kind(facet)]);
        (0..rule.len()).map(move |k| {
            let (QuadraturePoint { xi, weight }, shape) = &rule[k];
            let point = mesh.facet_point(facet, xi);
            let normal = mesh.outward_normal(facet, xi);
            let area = norm(normal);
            SidePoint {
                facet,
                xi: *xi,
                shape: *shape,
                point,
                normal: normal.map(|n| n / area),
                area: weight * area * measure(analysis, body.thickness, point),
            }
        })
    }))
}

/// A point of a rule on a facet, and the shape functions of the nodes there.
type Sample = (QuadraturePoint, [f64; MAX_FACET_NODES]);

/// The points of integration of a kind of facets.
fn samples(kind: CellKind, degree: usize) -> impl Iterator<Item = Sample> {
    let points = quadrature::rule(kind, degree).into_iter();
    points.map(move |point| {
        let mut shape = [0.0; MAX_FACET_NODES];
        kind.shape(&point.xi, &mut shape);
        (point, shape)
    })
}

/// Loads may be any expression: integrate them to well above the order of the cells.
const LOAD_DEGREE: usize = 9;

/// Adds ∫ N·b dV, and returns its size.
pub(crate) fn add_body_force<const D: usize>(
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
    prepare_within(body, &body.body_force, Vec::new, time);
    let mesh = &body.mesh;
    for block in mesh.blocks() {
        let table = CellTable::<D>::new(block.kind, body_degree(block.kind.order()));
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
