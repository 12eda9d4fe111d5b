//! Resultant of the loads on the part of a plane body ahead of a straight cut: equilibrium gives the forces in the cut.
//!
//! Let w be a rigid motion, H the step at the cut (0 behind, 1 ahead), and φ a field of nodal values that rises from 0 behind
//! to 1 ahead across the layer of cells about the cut. As the cells on either side of the layer do no work on φw,
//!
//! ```text
//!   F·w = ∫ σ : ∇(φw) dV  −  ∫ (φ − H) f·w     over the layer,       f: loads, reactions, contact forces, body force
//! ```
//!
//! with the total stress σ is the resultant of all forces on the part ahead, H f, to the rounding of the nodal balance. It is exact where
//! statics determines it; elsewhere (a ring) it follows from the displacements, with twice the order of accuracy of stresses. No stress
//! is recovered. With axial symmetry the hoop stress is a force per volume −σ_θ/r along r.
//!
//! * Tractions, body force and springs of sides are integrated exactly up to the cut, through cells and facets.
//! * Of contacts, couples, supports of sides and beds that only press nodal forces are known. They count as the traction of shape
//!   functions on these sides that has these nodal forces, else each cut beside a node would show half of the node's force. Each
//!   acts only on its own side: at the corner of a held end and a bedded long side the reaction of the support belongs to the
//!   end, the force of the bed to the long side, and one traction over both would mix them.
//! * A force at a point of the cut belongs to the part behind; so do all forces on a face at which the body begins. Where the
//!   body ends at the cut, the cut is just before that face: forces there are ahead, except for point loads.
//!
//! Source: the virtual work of a cut as in `docs/theory/sections.md`; forces for the thickness or the full 2π.

use crate::fem::cells::{CellTable, measure};
use crate::fem::error::FemError;
use crate::fem::initial::body_degree;
use crate::fem::internal::{CellForces, Rule};
use crate::fem::loads::{Amount, Load, side_points};
use crate::fem::nouns::{Analysis, Body, History, Place};
use crate::fem::quadrature::gauss;
use crate::fem::springs::{Bed, Spring};
use crate::fem::supports::{nearest_node, side_facets};
use crate::fem::surface::SideNormals;
use crate::geometry::{Point, add_scaled, dot, norm, sub};
use crate::mesh::{CellKind, Cut, Domain, Facet, MAX_CELL_NODES, MAX_FACET_NODES};
use std::collections::{BTreeMap, BTreeSet};

/// A node nearer to the cut than this part of its length lies on it.
const ON_CUT: f64 = 1e-6;

/// Points of the Gauss rules between the places where a cut enters or leaves: loads may be any expression.
const POINTS: usize = 8;

/// Forces ahead of cuts through a body in a state.
pub(crate) struct Ahead<'a, const D: usize> {
    body: &'a Body<D>,
    analysis: Analysis,
    time: f64,
    cells: CellForces<'a, D>,
    displacement: &'a [Point<D>],
    /// Loads of each facet, and the traction per unit of their value.
    loads: BTreeMap<Facet, Vec<(&'a Load<D>, f64)>>,
    springs: Vec<Sprung<'a, D>>,
    /// Known nodal forces on its sides, and those left by bodies that have gone.
    pushed: Vec<Pushed<D>>,
    /// Forces at nodes.
    points: BTreeMap<u32, Point<D>>,
    has_body_force: bool,
    /// Cells of each node, as pairs of block and cell.
    around: Vec<Vec<(u32, u32)>>,
}

/// A spring of a side.
struct Sprung<'a, const D: usize> {
    spring: &'a Spring<D>,
    facets: &'a [Facet],
    normals: SideNormals<'a, D>,
    /// The displacements (nodes,) at which it came.
    came: Option<&'a [Point<D>]>,
}

/// Nodal forces ON a body of one support, bed, contact or couple, or of contacts with common nodes, and the sides over which they
/// are spread.
#[derive(Debug, Clone, Default)]
pub(crate) struct Push<const D: usize> {
    pub sides: BTreeSet<String>,
    pub forces: BTreeMap<usize, Point<D>>,
}

impl<const D: usize> Push<D> {
    /// Adds a force at a node.
    pub fn add(&mut self, node: usize, force: Point<D>) {
        let sum = self.forces.entry(node).or_insert([0.0; D]);
        *sum = add_scaled(*sum, 1.0, force);
    }
}

/// Facets whose nodal forces are known, and the traction at their nodes that has these forces.
struct Pushed<const D: usize> {
    facets: BTreeSet<Facet>,
    traction: Vec<Point<D>>,
}

/// Force and moment about the middle of a cut.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Resultant {
    pub force: Point<2>,
    pub moment: f64,
}

impl Resultant {
    /// Adds another one about the same point.
    pub fn join(&mut self, other: Self) {
        self.force = add_scaled(self.force, 1.0, other.force);
        self.moment += other.moment;
    }

    fn add(&mut self, factor: f64, arm: Point<2>, force: Point<2>) {
        self.force = add_scaled(self.force, factor, force);
        self.moment += factor * (arm[0] * force[1] - arm[1] * force[0]);
    }
}

/// The cells of a body about a cut in which φ rises, and whether φ raises each node of the body.
pub(crate) struct Layer {
    cells: Vec<(u32, u32)>,
    rises: Vec<bool>,
}

impl Layer {
    /// The cut does not divide the body.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// φ is 1 at a node.
    pub fn rises(&self, node: usize) -> bool {
        self.rises[node]
    }
}

fn plane<const D: usize>(point: Point<D>) -> Point<2> {
    [point[0], point[1]]
}

/// The cut as a division of the body.
struct Divide<'c> {
    cut: &'c Cut,
    middle: Point<2>,
    along: Point<2>,
    first: Point<2>,
    half: f64,
}

impl<'c> Divide<'c> {
    fn new(cut: &'c Cut) -> Self {
        Self {
            cut,
            middle: cut.middle(),
            along: cut.along(),
            first: cut.toward_first(),
            half: 0.5 * cut.thickness(),
        }
    }

    fn arm(&self, point: Point<2>) -> Point<2> {
        sub(point, self.middle)
    }

    /// Distance ahead of the line through the cut.
    fn ahead(&self, point: Point<2>) -> f64 {
        dot(self.arm(point), self.along)
    }

    /// H at a point; where it lies on the line of the cut, that of its cell.
    fn step(&self, point: Point<2>, of_cell: impl Fn() -> Point<2>) -> bool {
        let tolerance = 2.0 * ON_CUT * self.half;
        let ahead = self.ahead(point);
        if ahead.abs() > tolerance {
            return ahead > 0.0;
        }
        if dot(self.arm(point), self.first).abs() <= self.half + tolerance {
            return self.cut.last;
        }
        self.ahead(of_cell()) > 0.0
    }
}

impl<'a, const D: usize> Ahead<'a, D> {
    /// From the displacements, the forces on its sides besides loads and springs, and the forces of bars by node, at a time.
    ///
    /// Errors: a group of cells without a material; a side that is not there.
    pub fn new(
        (body, history, analysis): (&'a Body<D>, &'a History<D>, Analysis),
        time: f64,
        displacement: &'a [Point<D>],
        (pushes, bars): (&[Push<D>], &BTreeMap<usize, Point<D>>),
    ) -> Result<Self, FemError> {
        let mesh = &body.mesh;
        let nodes = mesh.points().len();
        let (loads, mut points) = loads(body, analysis, time)?;
        for (&node, &force) in bars {
            let sum = points.entry(node as u32).or_insert([0.0; D]);
            *sum = add_scaled(*sum, 1.0, force);
        }
        let mut springs = Vec::new();
        for (place, spring) in body.springs.iter().enumerate() {
            if let Bed::Side { side, .. } = &spring.bed {
                springs.push(Sprung {
                    spring,
                    facets: side_facets(mesh, side)?,
                    normals: SideNormals::new(body, side)?,
                    came: history.sprung.get(&place).map(|u| &u[..]),
                });
            }
        }
        let spread = |facets: BTreeSet<Facet>, forces: &[Point<D>]| Pushed {
            traction: traction_of((body, analysis), &facets, forces),
            facets,
        };
        let mut pushed = Vec::new();
        for push in pushes {
            let mut facets = BTreeSet::new();
            for side in &push.sides {
                facets.extend(side_facets(mesh, side)?.iter().copied());
            }
            let mut forces = vec![[0.0; D]; nodes];
            push.forces.iter().for_each(|(&node, &f)| forces[node] = f);
            pushed.push(spread(facets, &forces));
        }
        if !history.released.is_empty() {
            let released = released(body, history, time);
            let left = |facet: &Facet| {
                let mut nodes = mesh.facet_nodes(*facet);
                nodes.all(|node| released[node as usize] != [0.0; D])
            };
            let boundary = mesh.boundary_facets().into_iter().filter(left);
            pushed.push(spread(boundary.collect(), &released));
        }
        let mut around = vec![Vec::new(); nodes];
        for (b, block) in mesh.blocks().iter().enumerate() {
            for (c, cell) in block.cells().enumerate() {
                cell.iter()
                    .for_each(|&node| around[node as usize].push((b as u32, c as u32)));
            }
        }
        Ok(Self {
            body,
            analysis,
            time,
            cells: CellForces::new(
                (body, analysis),
                (displacement, history.yielded.as_deref()),
                time,
            )?,
            displacement,
            loads,
            springs,
            pushed,
            points,
            has_body_force: body.body_force.iter().any(|b| b.as_constant() != Some(0.0)),
            around,
        })
    }

    fn measure(&self, point: Point<D>) -> f64 {
        measure(self.analysis, self.body.thickness, point)
    }

    fn at(&self, node: u32) -> Point<2> {
        plane(self.body.mesh.points()[node as usize])
    }

    /// Mean of the nodes of a cell.
    fn centre(&self, (block, cell): (u32, u32)) -> Point<2> {
        let nodes = self.body.mesh.cell_nodes(block as usize, cell as usize);
        let sum = nodes
            .iter()
            .fold([0.0; 2], |sum, &n| add_scaled(sum, 1.0, self.at(n)));
        sum.map(|c| c / nodes.len() as f64)
    }

    /// Resultant of all forces on the part ahead of a cut, from the layer about it.
    ///
    /// Errors: an initial stress or strain that is not finite.
    pub fn of(&self, cut: &Cut, layer: &Layer) -> Result<Resultant, FemError> {
        let divide = Divide::new(cut);
        let mut sum = Resultant::default();
        for &cell in &layer.cells {
            self.add_cell(&divide, &layer.rises, cell, &mut sum)?;
        }
        // a point load at the end of the body is behind the cut, and its node ahead
        if cut.last {
            let cells = layer.cells.iter();
            let nodes = cells.flat_map(|&(b, c)| self.body.mesh.cell_nodes(b as usize, c as usize));
            for node in nodes.copied().collect::<BTreeSet<u32>>() {
                let on = divide.ahead(self.at(node)).abs() <= 2.0 * ON_CUT * divide.half;
                if let (true, Some(force)) = (on, self.points.get(&node)) {
                    sum.add(-1.0, divide.arm(self.at(node)), plane(*force));
                }
            }
        }
        Ok(sum)
    }

    /// Adds −φ f of a force ON the body at a node that φ raises, from another body of the section.
    pub fn push(&self, cut: &Cut, node: usize, force: Point<D>, sum: &mut Resultant) {
        let arm = sub(self.at(node as u32), cut.middle());
        sum.add(-1.0, arm, plane(force));
    }

    /// The layer of cells about a cut in which φ rises; it is empty if the cut does not divide the body.
    pub fn layer(&self, cut: &Cut) -> Layer {
        let divide = Divide::new(cut);
        let centre = |node: u32| {
            let cells = &self.around[node as usize];
            let sum = cells.iter().fold([0.0; 2], |sum, &cell| {
                add_scaled(sum, 1.0, self.centre(cell))
            });
            sum.map(|c| c / cells.len() as f64)
        };
        let rises: Vec<bool> = (0..self.around.len() as u32)
            .map(|node| divide.step(self.at(node), || centre(node)))
            .collect();
        Layer {
            cells: self.rising(&divide, &rises),
            rises,
        }
    }

    /// The cells in which φ rises and that are connected with the cut.
    fn rising(&self, divide: &Divide<'_>, rises: &[bool]) -> Vec<(u32, u32)> {
        let mesh = &self.body.mesh;
        let nodes = |(b, c): (u32, u32)| mesh.cell_nodes(b as usize, c as usize);
        let mixed = |cell: (u32, u32)| {
            let nodes = nodes(cell);
            let first = rises[nodes[0] as usize];
            nodes.iter().any(|&node| rises[node as usize] != first)
        };
        // how far the middle of the cut is from a cell, along the cut
        let far = |cell: (u32, u32)| {
            let along = nodes(cell)
                .iter()
                .map(|&n| dot(divide.arm(self.at(n)), divide.first));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                (l.min(x), h.max(x))
            });
            low.max(-high).max(0.0)
        };
        let blocks = mesh.blocks().iter().enumerate();
        let all = blocks
            .flat_map(|(b, block)| (0..block.cells().len()).map(move |c| (b as u32, c as u32)));
        let on_cut = (1.0 - 2.0 * ON_CUT) * divide.half;
        let mut open: Vec<(u32, u32)> = all
            .filter(|&cell| mixed(cell) && far(cell) < on_cut)
            .collect();
        let mut found: BTreeSet<(u32, u32)> = open.iter().copied().collect();
        while let Some(cell) = open.pop() {
            for &node in nodes(cell) {
                for &next in &self.around[node as usize] {
                    if !found.contains(&next) && mixed(next) {
                        found.insert(next);
                        open.push(next);
                    }
                }
            }
        }
        found.into_iter().collect()
    }

    /// Contribution of a cell of the layer, with its loaded facets.
    fn add_cell(
        &self,
        divide: &Divide<'_>,
        rises: &[bool],
        cell: (u32, u32),
        sum: &mut Resultant,
    ) -> Result<(), FemError> {
        let mesh = &self.body.mesh;
        let (block, index) = (cell.0 as usize, cell.1 as usize);
        let nodes = mesh.cell_nodes(block, index);
        let internal = self.cells.of(block, index)?;
        let ahead = |node: u32| rises[node as usize];
        for (&node, force) in nodes.iter().zip(internal).filter(|(n, _)| ahead(**n)) {
            sum.add(1.0, divide.arm(self.at(node)), plane(force));
        }
        if self.has_body_force || self.analysis == Analysis::Axisymmetric {
            self.add_volume(divide, rises, cell, sum)?;
        }
        let kind = mesh.blocks()[block].kind;
        for local in 0..kind.facets().len() {
            let facet = Facet {
                block: cell.0,
                cell: cell.1,
                local: local as u32,
            };
            let mut pushed = self.pushed.iter();
            if pushed.any(|pushed| pushed.facets.contains(&facet))
                || self.loads.contains_key(&facet)
                || self.springs_at(facet).next().is_some()
            {
                self.add_facet(divide, rises, facet, sum);
            }
        }
        Ok(())
    }

    /// −∫(φ − H) f over a facet.
    fn add_facet(&self, divide: &Divide<'_>, rises: &[bool], facet: Facet, sum: &mut Resultant) {
        let mesh = &self.body.mesh;
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        let kind = mesh.facet_kind(facet);
        let distance = |xi: f64| divide.ahead(plane(mesh.facet_point(facet, &[xi])));
        for [low, high] in pieces([-1.0, 1.0], distance) {
            let middle = plane(mesh.facet_point(facet, &[0.5 * (low + high)]));
            let ahead = divide.step(middle, || self.centre((facet.block, facet.cell)));
            for (x, weight) in gauss(POINTS) {
                let xi = 0.5 * (low + high) + 0.5 * (high - low) * x;
                let (point, normal) = (
                    mesh.facet_point(facet, &[xi]),
                    mesh.outward_normal(facet, &[xi]),
                );
                let length = norm(normal);
                let area = 0.5 * (high - low) * weight * length * self.measure(point);
                let mut shape = [0.0; MAX_FACET_NODES];
                kind.shape(&[xi], &mut shape);
                let normal = normal.map(|n| n / length);
                let force = plane(self.traction((facet, xi), (point, normal), &shape));
                for (&node, n) in nodes.iter().zip(shape).filter(|(n, _)| rises[**n as usize]) {
                    sum.add(-area * n, divide.arm(self.at(node)), force);
                }
                if ahead {
                    sum.add(area, divide.arm(plane(point)), force);
                }
            }
        }
    }

    fn springs_at(&self, facet: Facet) -> impl Iterator<Item = &Sprung<'a, D>> {
        let springs = self.springs.iter();
        springs.filter(move |sprung| sprung.facets.binary_search(&facet).is_ok())
    }

    /// Force per area at a place of a facet, its point and normal, given by its shape functions.
    fn traction(
        &self,
        (facet, xi): (Facet, f64),
        (point, normal): (Point<D>, Point<D>),
        shape: &[f64],
    ) -> Point<D> {
        let of_facet = |values: &[Point<D>]| {
            let nodes = self.body.mesh.facet_nodes(facet).zip(shape);
            nodes.fold([0.0; D], |sum, (node, &n)| {
                add_scaled(sum, n, values[node as usize])
            })
        };
        let mut sum = [0.0; D];
        for (load, share) in self.loads.get(&facet).into_iter().flatten() {
            sum = add_scaled(sum, *share, load.at(point, normal, self.time));
        }
        for sprung in self.springs_at(facet) {
            let u = of_facet(self.displacement);
            let stretched = sprung.came.map_or(u, |came| sub(u, of_facet(came)));
            let along = sprung.normals.at(facet, &[xi]);
            sum = add_scaled(sum, 1.0, sprung.spring.traction(point, along, stretched));
        }
        for pushed in self.pushed.iter().filter(|p| p.facets.contains(&facet)) {
            sum = add_scaled(sum, 1.0, of_facet(&pushed.traction));
        }
        sum
    }

    /// −∫(φ − H) f over a cell, and with axial symmetry −∫ H σ_θ/r, whose other part is in the nodal forces.
    fn add_volume(
        &self,
        divide: &Divide<'_>,
        rises: &[bool],
        cell: (u32, u32),
        sum: &mut Resultant,
    ) -> Result<(), FemError> {
        let mesh = &self.body.mesh;
        let (block, index) = (cell.0 as usize, cell.1 as usize);
        let (kind, nodes) = (mesh.blocks()[block].kind, mesh.cell_nodes(block, index));
        let distances: Vec<f64> = nodes.iter().map(|&n| divide.ahead(self.at(n))).collect();
        let tolerance = 2.0 * ON_CUT * divide.half;
        let beyond = |sign: f64| distances.iter().any(|d| sign * d > tolerance);
        let divided = (beyond(1.0) && beyond(-1.0)).then(|| divided(kind, &distances));
        let is_ahead = divide.ahead(self.centre(cell)) > 0.0;
        if self.has_body_force {
            let parts = match &divided {
                Some([behind, ahead]) => vec![(false, behind.clone()), (true, ahead.clone())],
                // as the nodal loads are integrated
                None => {
                    let table = CellTable::<D>::new(kind, body_degree(kind.order()));
                    vec![(is_ahead, table.rule())]
                }
            };
            for (ahead, rule) in parts {
                self.add_body_force(divide, rises, (cell, ahead, &rule), sum);
            }
        }
        if self.analysis == Analysis::Axisymmetric {
            let hoop = match &divided {
                Some([_, ahead]) => self.cells.hoop(block, index, Some(ahead))?,
                None if is_ahead => self.cells.hoop(block, index, None)?,
                None => Vec::new(),
            };
            for (point, volume, stress) in hoop {
                let point = plane(point);
                sum.add(volume, divide.arm(point), [-stress / point[0], 0.0]);
            }
        }
        Ok(())
    }

    /// −∫(φ − H) f of the body force over a part of a cell, which is ahead or behind.
    fn add_body_force(
        &self,
        divide: &Divide<'_>,
        rises: &[bool],
        (cell, ahead, rule): ((u32, u32), bool, &Rule),
        sum: &mut Resultant,
    ) {
        let mesh = &self.body.mesh;
        let (block, index) = (cell.0 as usize, cell.1 as usize);
        let nodes = mesh.cell_nodes(block, index);
        let table = CellTable::<D>::at(mesh.blocks()[block].kind, rule);
        for q in 0..table.len() {
            let (point, _, volume) = table.map(q, |local| mesh.points()[nodes[local] as usize]);
            let volume = volume * self.measure(point);
            let force: Point<D> =
                std::array::from_fn(|i| self.body.body_force[i].at(point, self.time));
            let force = plane(force);
            let shapes = nodes.iter().zip(table.shape(q));
            for (&node, n) in shapes.filter(|(n, _)| rises[**n as usize]) {
                sum.add(-volume * n, divide.arm(self.at(node)), force);
            }
            if ahead {
                sum.add(volume, divide.arm(plane(point)), force);
            }
        }
    }
}

/// Most steps of the conjugate gradients: with the diagonal divided out the mass of lines has eigenvalues between 1/2 and 2.
const MOST_STEPS: usize = 200;

/// Loads of each facet with the traction per unit of their value, and those of nodes.
type Loads<'a, const D: usize> = (
    BTreeMap<Facet, Vec<(&'a Load<D>, f64)>>,
    BTreeMap<u32, Point<D>>,
);

/// The loads of a body at a time.
fn loads<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    time: f64,
) -> Result<Loads<'_, D>, FemError> {
    let mesh = &body.mesh;
    let mut of_facets: BTreeMap<Facet, Vec<(&Load<D>, f64)>> = BTreeMap::new();
    let mut of_nodes: BTreeMap<u32, Point<D>> = BTreeMap::new();
    for load in &body.loads {
        match load.place() {
            Place::Side(side) => {
                let area = || {
                    side_points(body, &side, analysis).map(|all| all.map(|p| p.area).sum::<f64>())
                };
                let share = match load.amount() {
                    Amount::PerArea => 1.0,
                    Amount::Whole => 1.0 / area()?,
                };
                for &facet in side_facets(mesh, &side)? {
                    of_facets.entry(facet).or_default().push((load, share));
                }
            }
            Place::Point(at) => {
                let node = nearest_node(mesh, at, "point force")?;
                let force = load.at(mesh.points()[node], [0.0; D], time);
                let sum = of_nodes.entry(node as u32).or_insert([0.0; D]);
                *sum = add_scaled(*sum, 1.0, force);
            }
        }
    }
    Ok((of_facets, of_nodes))
}

/// Forces (nodes,) left by bodies that have gone, at a time.
fn released<const D: usize>(body: &Body<D>, history: &History<D>, time: f64) -> Vec<Point<D>> {
    let mut sum = vec![[0.0; D]; body.mesh.points().len()];
    for (left, factor) in &history.released {
        let part = factor.at([0.0; D], time);
        for (sum, force) in sum.iter_mut().zip(left.iter()) {
            *sum = add_scaled(*sum, part, *force);
        }
    }
    sum
}

/// The traction at the nodes of some facets that has these nodal forces: M q = f by conjugate gradients, M the mass of
/// the facets, which is well conditioned.
fn traction_of<const D: usize>(
    (body, analysis): (&Body<D>, Analysis),
    facets: &BTreeSet<Facet>,
    forces: &[Point<D>],
) -> Vec<Point<D>> {
    let mesh = &body.mesh;
    let rule = gauss(4);
    let mut entries: Vec<(usize, usize, f64)> = Vec::new();
    for &facet in facets {
        let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|n| n as usize).collect();
        for &(xi, weight) in &rule {
            let mut shape = [0.0; MAX_FACET_NODES];
            mesh.facet_kind(facet).shape(&[xi], &mut shape);
            let area = weight
                * norm(mesh.outward_normal(facet, &[xi]))
                * measure(analysis, body.thickness, mesh.facet_point(facet, &[xi]));
            for (&a, na) in nodes.iter().zip(shape) {
                for (&b, nb) in nodes.iter().zip(shape) {
                    entries.push((a, b, area * na * nb));
                }
            }
        }
    }
    let mut diagonal = vec![0.0; forces.len()];
    for &(a, b, m) in entries.iter().filter(|e| e.0 == e.1) {
        diagonal[a.min(b)] += m;
    }
    let scaled = |v: &[f64]| -> Vec<f64> {
        v.iter()
            .zip(&diagonal)
            .map(|(v, d)| if *d > 0.0 { v / d } else { 0.0 })
            .collect()
    };
    let product = |v: &[f64]| {
        let mut out = vec![0.0; v.len()];
        entries.iter().for_each(|&(a, b, m)| out[a] += m * v[b]);
        out
    };
    let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut traction = vec![[0.0; D]; forces.len()];
    for axis in 0..D {
        let on_facet = forces.iter().zip(&diagonal);
        let mut rest: Vec<f64> = on_facet
            .map(|(f, d)| if *d > 0.0 { f[axis] } else { 0.0 })
            .collect();
        let mut step = scaled(&rest);
        let mut size = inner(&rest, &step);
        let start = size;
        for _ in 0..MOST_STEPS {
            if size <= f64::EPSILON * f64::EPSILON * start {
                break;
            }
            let image = product(&step);
            let part = size / inner(&step, &image);
            for (q, p) in traction.iter_mut().zip(&step) {
                q[axis] += part * p;
            }
            rest.iter_mut()
                .zip(&image)
                .for_each(|(r, m)| *r -= part * m);
            let next = scaled(&rest);
            let before = std::mem::replace(&mut size, inner(&rest, &next));
            step.iter_mut()
                .zip(&next)
                .for_each(|(p, r)| *p = r + size / before * *p);
        }
    }
    traction
}

/// The places in an interval where a polynomial of degree two at most is zero, ascending.
fn zeros([low, high]: [f64; 2], value: impl Fn(f64) -> f64) -> Vec<f64> {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let [left, middle, right] = [low, centre, high].map(value);
    // a + b x + c x² on [−1, 1]
    let (a, b, c) = (middle, 0.5 * (right - left), 0.5 * (left + right) - middle);
    let size = left.abs().max(middle.abs()).max(right.abs());
    let mut found = Vec::new();
    if c.abs() <= 1e-13 * size {
        found.push(-a / b);
    } else {
        let root = (b * b - 4.0 * a * c).sqrt();
        // the stable pair; no root is NaN
        let q = -0.5 * (b + if b < 0.0 { -root } else { root });
        found.extend([q / c, a / q]);
    }
    found.retain(|x| x.abs() < 1.0);
    found.sort_by(f64::total_cmp);
    found.iter().map(|x| centre + half * x).collect()
}

/// An interval cut where a polynomial of degree two at most changes its sign.
fn pieces(interval: [f64; 2], value: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let mut ends = zeros(interval, value);
    ends.insert(0, interval[0]);
    ends.push(interval[1]);
    ends.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Rules for the parts of a reference cell behind and ahead of a line, by the distances of its nodes ahead of it.
///
/// Lines of the cell along its first coordinate are cut where they meet the line; from one to the other Gauss rules go
/// between the places where the line enters or leaves the cell. Exact for straight cuts through parallelograms and
/// triangles, to rounding through all straight-sided cells.
fn divided(kind: CellKind, distances: &[f64]) -> [Rule; 2] {
    let distance = |x: f64, y: f64| {
        let mut shape = [0.0; MAX_CELL_NODES];
        kind.shape(&[x, y], &mut shape);
        shape.iter().zip(distances).map(|(n, d)| n * d).sum::<f64>()
    };
    let triangle = kind.domain() == Domain::Triangle;
    let range = if triangle { [0.0, 1.0] } else { [-1.0, 1.0] };
    let ends = |y: f64| {
        if triangle {
            [0.0, 1.0 - y]
        } else {
            [-1.0, 1.0]
        }
    };
    let mut breaks = vec![range[0], range[1]];
    for end in 0..2 {
        breaks.extend(zeros(range, |y| distance(ends(y)[end], y)));
    }
    breaks.sort_by(f64::total_cmp);
    let rule = gauss(POINTS);
    let mut parts = [Vec::new(), Vec::new()];
    for panel in breaks.windows(2) {
        let (centre, half) = (0.5 * (panel[0] + panel[1]), 0.5 * (panel[1] - panel[0]));
        for &(v, outer) in rule.iter().filter(|_| half > 0.0) {
            let y = centre + half * v;
            for [low, high] in pieces(ends(y), |x| distance(x, y)) {
                let ahead = distance(0.5 * (low + high), y) > 0.0;
                for &(u, inner) in &rule {
                    let x = 0.5 * (low + high) + 0.5 * (high - low) * u;
                    let weight = half * outer * 0.5 * (high - low) * inner;
                    parts[usize::from(ahead)].push(([x, y, 0.0], weight));
                }
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_divided_cell_keeps_its_area_and_its_centroid() {
        // the line x + 2y = 0.3 through the square, and x − y = 0.1 through the triangle
        for (kind, line) in [
            (CellKind::Quad4, [1.0, 2.0, -0.3]),
            (CellKind::Quad9, [0.2, -1.0, 0.05]),
            (CellKind::Tri6, [1.0, -1.0, -0.1]),
        ] {
            let nodes = kind.reference_nodes().iter();
            let distances: Vec<f64> = nodes
                .map(|n| line[0] * n[0] + line[1] * n[1] + line[2])
                .collect();
            let parts = divided(kind, &distances);
            let sum = |f: &dyn Fn([f64; 3]) -> f64| -> f64 {
                parts.iter().flatten().map(|(x, w)| w * f(*x)).sum()
            };
            assert!((sum(&|_| 1.0) - kind.domain().volume()).abs() < 1e-13);
            let centre = kind.domain().centre();
            for axis in 0..2 {
                assert!((sum(&|x| x[axis]) - centre[axis] * kind.domain().volume()).abs() < 1e-13);
            }
            for (part, sign) in parts.iter().zip([-1.0, 1.0]) {
                let side = |x: &[f64; 3]| line[0] * x[0] + line[1] * x[1] + line[2];
                assert!(!part.is_empty() && part.iter().all(|(x, _)| sign * side(x) > 0.0));
            }
        }
        // the corner of the triangle x + y < 1 beyond x − y = 0.1 has its base on x from 0.1 to 1
        let distances = [-0.1, 0.9, -1.1];
        let [_, ahead] = divided(CellKind::Tri3, &distances);
        let area: f64 = ahead.iter().map(|(_, w)| w).sum();
        assert!((area - 0.5 * 0.9 * 0.45).abs() < 1e-14);
    }
}
