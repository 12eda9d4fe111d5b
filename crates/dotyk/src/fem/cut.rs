//! Resultant of the loads on the part of a body ahead of a straight cut: equilibrium gives the forces in the cut. In space the body is
//! extruded along an axis a, and the cut goes all along it.
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
//! *Along the axis* the forces per unit of length are found, too. With the hat ψ of a level of nodes and the nodal field v = Σ ψ w N, in
//! place of w, the same identity holds but for the work of the part ahead in v, which is no rigid motion:
//!
//! ```text
//!   ∫ ψ w·t dA over the cut = ∫ σ : ∇(φv) dV  −  ∫ H σ : ∇v dV  −  ∫ (φ − H) f·v     over the layer,      t: force on the part behind
//! ```
//!
//! The values at the levels are those of which these weighted ones are the integrals, by weights that are exact for polynomials of degree
//! two (`Along::values`): with hats alone they would be off by (kh)²/12 for waves cos kz on levels at distances h. The sum over the hats
//! is the resultant of the whole cut. Turns w are about the middle line there: arms have no component along the axis.
//!
//! * Tractions, body force and springs of sides are integrated exactly up to the cut, through cells and facets.
//! * Of contacts, couples, supports of sides and beds that only press nodal forces are known. They count as the traction of shape
//!   functions on these sides that has these nodal forces, else each cut beside a node would show half of the node's force. Each
//!   acts only on its own side: at the corner of a held end and a bedded long side the reaction of the support belongs to the
//!   end, the force of the bed to the long side, and one traction over both would mix them.
//! * On the ends of an extruded body the normal stress of the cells is taken as a part of the traction (`take_normal_stress`).
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
use crate::fem::quadrature::{self, QuadraturePoint, gauss};
use crate::fem::sides::side_facets;
use crate::fem::springs::{Bed, Spring};
use crate::fem::supports::nearest_node;
use crate::fem::surface::SideNormals;
use crate::geometry::{Point, add_scaled, cross, dot, norm, sub};
use crate::mesh::{Axes, CellKind, Cut, Domain, Facet, MAX_CELL_NODES, MAX_FACET_NODES, Mesh};
use std::collections::{BTreeMap, BTreeSet};

/// A node nearer to the cut than this part of its length lies on it.
const ON_CUT: f64 = 1e-6;

/// Points of the Gauss rules between the places where a cut enters or leaves: loads may be any expression.
const POINTS: usize = 8;

/// Degree of the rules of whole facets in space, and of the parts of divided cells there: loads may be any expression.
const FACET_DEGREE: usize = 8;
const PART_DEGREE: usize = 4;

/// Forces ahead of cuts through a body in a state.
pub(crate) struct Ahead<'a, const D: usize> {
    body: &'a Body<D>,
    analysis: Analysis,
    time: f64,
    axes: Axes<D>,
    along: &'a Along,
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
    /// The normal stress of the cells is a part of it, and not of these forces.
    on_ends: bool,
}

/// Ratio of two steps along the axis from which weights that are exact for parabolas are not positive any more: 1.62.
const UNEVEN: f64 = 1.5;

/// Where forces are found along the axis of a cut.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Along {
    /// The middle of the body along the axis.
    pub middle: f64,
    /// The levels at which forces per length are found, ascending; none: those of the whole cut.
    pub levels: Vec<f64>,
    /// Where they are told.
    pub places: Vec<f64>,
}

impl Along {
    /// Number of places at which a cut is told.
    pub fn count(&self) -> usize {
        self.places.len().max(1)
    }

    /// The hats that are not zero at a place of the axis, and their values.
    fn hats(&self, at: f64) -> [(usize, f64); 2] {
        let Some(last) = self.levels.len().checked_sub(1) else {
            return [(0, 1.0), (0, 0.0)];
        };
        let next = self.levels.partition_point(|level| *level <= at);
        let next = next.clamp(1, last);
        let [low, high] = [self.levels[next - 1], self.levels[next]];
        let part = ((at - low) / (high - low)).clamp(0.0, 1.0);
        [(next - 1, 1.0 - part), (next, part)]
    }

    /// The values at the places of smooth forces per length of which these (levels,) are the integrals with the hats.
    ///
    /// Between levels they are those of the parabola through three of them.
    fn values(&self, mut weighted: Vec<Resultant>) -> Vec<Resultant> {
        let Some(last) = self.levels.len().checked_sub(1) else {
            return weighted;
        };
        let mut rows = self.weights();
        // the third weight of an end goes by the row beside it, which has the same levels
        for (end, beside, [near, far, third]) in [(0, 1, [1, 2, 0]), (last, last - 1, [1, 0, 2])] {
            if rows[end][third] != 0.0 {
                let part = rows[end][third] / rows[beside][far];
                let (row, above) = (rows[beside], weighted[beside]);
                rows[end][near] -= part * row[third];
                rows[end][far] -= part * row[near];
                rows[end][third] = 0.0;
                weighted[end].join(-part, above);
            }
        }
        for k in 1..=last {
            let factor = rows[k][0] / rows[k - 1][1];
            rows[k][1] -= factor * rows[k - 1][2];
            let above = weighted[k - 1];
            weighted[k].join(-factor, above);
        }
        for k in (0..=last).rev() {
            if k < last {
                let below = weighted[k + 1];
                weighted[k].join(-rows[k][2], below);
            }
            weighted[k].scale(1.0 / rows[k][1]);
        }
        let at = |place: &f64| {
            let mut sum = Resultant::default();
            for (k, part) in self.parabola(*place) {
                sum.join(part, weighted[k]);
            }
            sum
        };
        self.places.iter().map(at).collect()
    }

    /// The weights [before, own, after] of values in the integral with the hat of each level, by its moments m₀, m₁, m₂ about it: exact for
    /// polynomials of degree two, where steps are uneven for lines. An end has no neighbour on one side: the weight there is that of the
    /// level behind its only neighbour.
    fn weights(&self) -> Vec<[f64; 3]> {
        let levels = &self.levels;
        let last = levels.len() - 1;
        let step = |k: usize| levels[k + 1] - levels[k];
        let even = |a: f64, b: f64| a < UNEVEN * b && b < UNEVEN * a;
        let end = |near: f64, next: Option<f64>| match next {
            Some(next) if even(near, next) => {
                let far = near + next;
                let third = -near.powi(3) / 12.0 / (far * next);
                let second = near / 6.0 - far * third / near;
                [0.5 * near - second - third, second, third]
            }
            _ => [near / 3.0, near / 6.0, 0.0],
        };
        let row = |k: usize| {
            if k == 0 {
                let [own, second, third] = end(step(0), (last > 1).then(|| step(1)));
                return [third, own, second];
            }
            if k == last {
                let [own, second, third] = end(step(k - 1), (last > 1).then(|| step(k - 2)));
                return [second, own, third];
            }
            let (a, b) = (step(k - 1), step(k));
            if !even(a, b) {
                return [a / 6.0, (a + b) / 3.0, b / 6.0];
            }
            let (m1, m2) = ((b * b - a * a) / 6.0, (a.powi(3) + b.powi(3)) / 12.0);
            let after = (m2 + a * m1) / (b * (a + b));
            let before = (m2 - b * m1) / (a * (a + b));
            [before, 0.5 * (a + b) - before - after, after]
        };
        (0..=last).map(row).collect()
    }

    /// Levels with their parts in the parabola through the three around a place, or in the line through two.
    fn parabola(&self, at: f64) -> Vec<(usize, f64)> {
        let count = self.levels.len().min(3);
        let next = self.levels.partition_point(|level| *level <= at);
        // the nearer of the two that may be the third
        let far = |k: usize| {
            self.levels
                .get(k)
                .map_or(f64::INFINITY, |level| (level - at).abs())
        };
        let before = next >= 2 && far(next - 2) <= far(next + 1);
        let first = next.saturating_sub(if before { 2 } else { 1 });
        let first = first.min(self.levels.len() - count);
        let own = first..first + count;
        let part = |k: usize| {
            let others = own.clone().filter(|&i| i != k);
            let parts = others.map(|i| (at - self.levels[i]) / (self.levels[k] - self.levels[i]));
            parts.product()
        };
        own.clone().map(|k| (k, part(k))).collect()
    }
}

/// Force and moment about the middle of a cut, in the axes of the cut.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Resultant {
    pub force: [f64; 3],
    pub moment: [f64; 3],
}

impl Resultant {
    /// That of a cut where nothing is.
    pub fn nowhere() -> Self {
        Self {
            force: [f64::NAN; 3],
            moment: [f64::NAN; 3],
        }
    }

    /// Adds another one about the same point, times a factor.
    pub fn join(&mut self, factor: f64, other: Self) {
        self.force = add_scaled(self.force, factor, other.force);
        self.moment = add_scaled(self.moment, factor, other.moment);
    }

    fn scale(&mut self, factor: f64) {
        self.force = self.force.map(|c| factor * c);
        self.moment = self.moment.map(|c| factor * c);
    }

    fn add(&mut self, factor: f64, arm: [f64; 3], force: [f64; 3]) {
        self.force = add_scaled(self.force, factor, force);
        self.moment = add_scaled(self.moment, factor, cross(arm, force));
    }
}

/// The resultants of a cut, weighted with the hat of each level along the axis.
pub(crate) struct Sums<'s> {
    along: &'s Along,
    middle: Point<2>,
    all: Vec<Resultant>,
}

impl<'s> Sums<'s> {
    /// Zero, about the middle of a cut.
    pub fn new(along: &'s Along, cut: &Cut) -> Self {
        Self {
            along,
            middle: cut.middle(),
            all: vec![Resultant::default(); along.levels.len().max(1)],
        }
    }

    /// Adds those of another body.
    pub fn join(&mut self, other: &Self) {
        let both = self.all.iter_mut().zip(&other.all);
        both.for_each(|(own, other)| own.join(1.0, *other));
    }

    /// Per unit of length at the places, or those of the whole cut.
    pub fn values(self) -> Vec<Resultant> {
        self.along.values(self.all)
    }

    /// Those of the whole cut; moments about the middle line where they are weighted with hats.
    pub fn whole(&self) -> Resultant {
        let mut sum = Resultant::default();
        self.all.iter().for_each(|own| sum.join(1.0, *own));
        sum
    }

    /// Adds a force at a point, both in the axes of the cut, times a factor.
    fn add(&mut self, factor: f64, at: [f64; 3], force: [f64; 3]) {
        let out = match self.along.levels.is_empty() {
            true => at[2] - self.along.middle,
            false => 0.0,
        };
        let arm = [at[0] - self.middle[0], at[1] - self.middle[1], out];
        for (k, hat) in self.along.hats(at[2]) {
            if hat != 0.0 {
                self.all[k].add(factor * hat, arm, force);
            }
        }
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

    fn arm(&self, point: [f64; 3]) -> Point<2> {
        sub([point[0], point[1]], self.middle)
    }

    /// Distance ahead of the line through the cut.
    fn ahead(&self, point: [f64; 3]) -> f64 {
        dot(self.arm(point), self.along)
    }

    /// The line through the cut divides what has nodes at these distances ahead of it.
    fn divides(&self, distances: &[f64]) -> bool {
        let tolerance = 2.0 * ON_CUT * self.half;
        let beyond = |sign: f64| distances.iter().any(|d| sign * d > tolerance);
        beyond(1.0) && beyond(-1.0)
    }

    /// H at a point; where it lies on the line of the cut, that of its cell.
    fn step(&self, point: [f64; 3], of_cell: impl Fn() -> [f64; 3]) -> bool {
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
    /// From the displacements, the forces on its sides besides loads and springs, and the forces of bars by node, at a time; in
    /// axes of which the first two are those of the cuts.
    ///
    /// Errors: a group of cells without a material; a side that is not there.
    pub fn new(
        (body, history, analysis): (&'a Body<D>, &'a History<D>, Analysis),
        time: f64,
        displacement: &'a [Point<D>],
        (pushes, bars): (&[Push<D>], &BTreeMap<usize, Point<D>>),
        (axes, along): (Axes<D>, &'a Along),
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
        let cells = CellForces::new(
            (body, analysis),
            (displacement, history.yielded.as_deref()),
            time,
        )?;
        let mut pushed = Vec::new();
        for push in pushes {
            let mut facets = BTreeSet::new();
            for side in &push.sides {
                facets.extend(side_facets(mesh, side)?.iter().copied());
            }
            let mut forces = vec![[0.0; D]; nodes];
            push.forces.iter().for_each(|(&node, &f)| forces[node] = f);
            let across = |facet: &Facet| is_across(mesh, *facet, axes.axis());
            let along = |force: &Point<D>| dot(*force, axes.axis()) != 0.0;
            let on_ends = facets.iter().all(across) && push.forces.values().any(along);
            if on_ends {
                take_normal_stress(mesh, &facets, (&cells, axes.axis()), &mut forces)?;
            }
            pushed.push(Pushed {
                traction: traction_of((body, analysis), &facets, &forces),
                facets,
                on_ends,
            });
        }
        if !history.released.is_empty() {
            let released = released(body, history, time);
            let left = |facet: &Facet| {
                let mut nodes = mesh.facet_nodes(*facet);
                nodes.all(|node| released[node as usize] != [0.0; D])
            };
            let boundary = mesh.boundary_facets().into_iter().filter(left);
            let facets = boundary.collect();
            pushed.push(Pushed {
                traction: traction_of((body, analysis), &facets, &released),
                facets,
                on_ends: false,
            });
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
            axes,
            along,
            cells,
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

    /// A node in the axes of the cuts.
    fn at(&self, node: u32) -> [f64; 3] {
        self.axes.local(self.body.mesh.points()[node as usize])
    }

    /// Mean of the nodes of a cell.
    fn centre(&self, (block, cell): (u32, u32)) -> [f64; 3] {
        let nodes = self.body.mesh.cell_nodes(block as usize, cell as usize);
        let sum = nodes
            .iter()
            .fold([0.0; 3], |sum, &n| add_scaled(sum, 1.0, self.at(n)));
        sum.map(|c| c / nodes.len() as f64)
    }

    /// Resultants of all forces on the part ahead of a cut, from the layer about it.
    ///
    /// Errors: an initial stress or strain that is not finite.
    pub fn of(&self, cut: &Cut, layer: &Layer) -> Result<Sums<'a>, FemError> {
        let divide = Divide::new(cut);
        let mut sum = Sums::new(self.along, cut);
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
                    sum.add(-1.0, self.at(node), self.axes.local(*force));
                }
            }
        }
        Ok(sum)
    }

    /// Adds −φ f of a force ON the body at a node that φ raises, from another body of the section.
    pub fn push(&self, node: usize, force: Point<D>, sum: &mut Sums<'_>) {
        sum.add(-1.0, self.at(node as u32), self.axes.local(force));
    }

    /// The layer of cells about a cut in which φ rises; it is empty if the cut does not divide the body.
    pub fn layer(&self, cut: &Cut) -> Layer {
        let divide = Divide::new(cut);
        let centre = |node: u32| {
            let cells = &self.around[node as usize];
            let sum = cells.iter().fold([0.0; 3], |sum, &cell| {
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
        sum: &mut Sums<'_>,
    ) -> Result<(), FemError> {
        let mesh = &self.body.mesh;
        let (block, index) = (cell.0 as usize, cell.1 as usize);
        let nodes = mesh.cell_nodes(block, index);
        let internal = self.cells.of(block, index)?;
        let ahead = |node: u32| rises[node as usize];
        for (&node, force) in nodes.iter().zip(internal).filter(|(n, _)| ahead(**n)) {
            sum.add(1.0, self.at(node), self.axes.local(force));
        }
        let bends = !self.along.levels.is_empty();
        if bends || self.has_body_force || self.analysis == Analysis::Axisymmetric {
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
                self.add_facet(divide, rises, facet, sum)?;
            }
        }
        Ok(())
    }

    /// −∫(φ − H) f over a facet.
    fn add_facet(
        &self,
        divide: &Divide<'_>,
        rises: &[bool],
        facet: Facet,
        sum: &mut Sums<'_>,
    ) -> Result<(), FemError> {
        let mesh = &self.body.mesh;
        let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
        let kind = mesh.facet_kind(facet);
        let mut pushed = self.pushed.iter();
        let on_ends = pushed.any(|p| p.on_ends && p.facets.contains(&facet));
        for (ahead, rule) in self.parts_of_facet(divide, facet) {
            let places: Vec<[f64; 3]> = rule.iter().map(|(xi, _)| *xi).collect();
            let of_cell = match on_ends {
                true => normal_stresses(mesh, &self.cells, (facet, &places), self.axes.axis())?,
                false => vec![0.0; rule.len()],
            };
            for ((xi, weight), of_cell) in rule.into_iter().zip(of_cell) {
                let (point, normal) = (
                    mesh.facet_point(facet, &xi),
                    mesh.outward_normal(facet, &xi),
                );
                let size = norm(normal);
                let area = weight * size * self.measure(point);
                let mut shape = [0.0; MAX_FACET_NODES];
                kind.shape(&xi, &mut shape);
                let normal = normal.map(|n| n / size);
                let force = self.traction((facet, &xi), (point, normal), (&shape, of_cell));
                let force = self.axes.local(force);
                for (&node, n) in nodes.iter().zip(shape) {
                    if let Some(part) = step_less_rise(ahead, rises[node as usize]) {
                        sum.add(part * area * n, self.at(node), force);
                    }
                }
            }
        }
        Ok(())
    }

    /// Rules for the parts of a facet, each with whether it is ahead.
    fn parts_of_facet(&self, divide: &Divide<'_>, facet: Facet) -> Vec<(bool, Rule)> {
        let mesh = &self.body.mesh;
        let local = |xi: &[f64]| self.axes.local(mesh.facet_point(facet, xi));
        let step = |xi: &[f64]| divide.step(local(xi), || self.centre((facet.block, facet.cell)));
        let kind = mesh.facet_kind(facet);
        if kind.domain() == Domain::Line {
            let parts = pieces([-1.0, 1.0], |xi| divide.ahead(local(&[xi]))).into_iter();
            let parts = parts.map(|[low, high]| {
                let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
                let points = gauss(POINTS).into_iter();
                let rule = points.map(|(x, weight)| ([centre + half * x, 0.0, 0.0], half * weight));
                (step(&[centre]), rule.collect())
            });
            return parts.collect();
        }
        let nodes = mesh.facet_nodes(facet);
        let distances: Vec<f64> = nodes.map(|node| divide.ahead(self.at(node))).collect();
        if divide.divides(&distances) {
            let [behind, ahead] = divided(kind, &distances);
            return vec![(false, behind), (true, ahead)];
        }
        let points = quadrature::rule(kind, FACET_DEGREE).into_iter();
        let rule = points.map(|point| (point.xi, point.weight)).collect();
        vec![(step(&kind.domain().centre()), rule)]
    }

    fn springs_at(&self, facet: Facet) -> impl Iterator<Item = &Sprung<'a, D>> {
        let springs = self.springs.iter();
        springs.filter(move |sprung| sprung.facets.binary_search(&facet).is_ok())
    }

    /// Force per area at a place of a facet, its point and normal, given by its shape functions and the normal stress of its cell.
    fn traction(
        &self,
        (facet, xi): (Facet, &[f64]),
        (point, normal): (Point<D>, Point<D>),
        (shape, of_cell): (&[f64], f64),
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
            let along = sprung.normals.at(facet, xi);
            sum = add_scaled(sum, 1.0, sprung.spring.traction(point, along, stretched));
        }
        for pushed in self.pushed.iter().filter(|p| p.facets.contains(&facet)) {
            sum = add_scaled(sum, 1.0, of_facet(&pushed.traction));
            if pushed.on_ends {
                sum = add_scaled(sum, of_cell, normal);
            }
        }
        sum
    }

    /// −∫(φ − H) f over a cell, with axial symmetry −∫ H σ_θ/r, whose other part is in the nodal forces, and with levels along the
    /// axis −∫ H σ : ∇v.
    fn add_volume(
        &self,
        divide: &Divide<'_>,
        rises: &[bool],
        cell: (u32, u32),
        sum: &mut Sums<'_>,
    ) -> Result<(), FemError> {
        let mesh = &self.body.mesh;
        let (block, index) = (cell.0 as usize, cell.1 as usize);
        let (kind, nodes) = (mesh.blocks()[block].kind, mesh.cell_nodes(block, index));
        let distances: Vec<f64> = nodes.iter().map(|&n| divide.ahead(self.at(n))).collect();
        let divided = divide.divides(&distances).then(|| match D {
            2 => divided(kind, &distances),
            _ => divided_solid(kind, &distances),
        });
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
                self.add_body_force(rises, (cell, ahead, &rule), sum);
            }
        }
        let part = match &divided {
            Some([_, ahead]) => Some(ahead),
            None if is_ahead => None,
            None => return Ok(()),
        };
        if self.analysis == Analysis::Axisymmetric {
            for (point, volume, stress) in self.cells.hoop(block, index, part)? {
                let force = std::array::from_fn(|i| if i == 0 { -stress / point[0] } else { 0.0 });
                sum.add(volume, self.axes.local(point), force);
            }
        }
        if !self.along.levels.is_empty() {
            let internal = match part {
                Some(rule) => self.cells.of_part(block, index, rule)?,
                None => self.cells.of(block, index)?,
            };
            for (&node, force) in nodes.iter().zip(internal) {
                sum.add(-1.0, self.at(node), self.axes.local(force));
            }
        }
        Ok(())
    }

    /// −∫(φ − H) f of the body force over a part of a cell, which is ahead or behind.
    fn add_body_force(
        &self,
        rises: &[bool],
        (cell, ahead, rule): ((u32, u32), bool, &Rule),
        sum: &mut Sums<'_>,
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
            let force = self.axes.local(force);
            for (&node, n) in nodes.iter().zip(table.shape(q)) {
                if let Some(part) = step_less_rise(ahead, rises[node as usize]) {
                    sum.add(part * volume * n, self.at(node), force);
                }
            }
        }
    }
}

/// H − φ of a node, if it is not zero.
fn step_less_rise(ahead: bool, rises: bool) -> Option<f64> {
    match (ahead, rises) {
        (true, false) => Some(1.0),
        (false, true) => Some(-1.0),
        _ => None,
    }
}

/// Degree of the rule of the mass of facets.
const MASS_DEGREE: usize = 7;

/// A plane facet across a direction; zero in the plane, where there is none.
fn is_across<const D: usize>(mesh: &Mesh<D>, facet: Facet, axis: Point<D>) -> bool {
    let kind = mesh.facet_kind(facet);
    let corners = &kind.reference_nodes()[..kind.corners()];
    corners.iter().all(|xi| {
        let normal = mesh.outward_normal(facet, xi);
        dot(normal, axis).abs() > (1.0 - ON_CUT) * norm(normal)
    })
}

/// n·σn of its cell at places of a plane facet across a direction n.
fn normal_stresses<const D: usize>(
    mesh: &Mesh<D>,
    cells: &CellForces<'_, D>,
    (facet, places): (Facet, &[[f64; 3]]),
    n: Point<D>,
) -> Result<Vec<f64>, FemError> {
    let (block, cell) = (facet.block as usize, facet.cell as usize);
    let kind = mesh.blocks()[block].kind;
    let (of_facet, local) = kind.facets()[facet.local as usize];
    let in_cell = |xi: &[f64; 3]| {
        let mut shape = [0.0; MAX_FACET_NODES];
        of_facet.shape(xi, &mut shape);
        let nodes = local.iter().zip(shape);
        let at = nodes.fold([0.0; 3], |sum, (&node, n)| {
            add_scaled(sum, n, kind.reference_nodes()[node])
        });
        (at, 1.0)
    };
    let rule: Rule = places.iter().map(in_cell).collect();
    cells.normal_stress(block, cell, (&rule, n))
}

/// Takes from nodal forces on the ends of a body those of the normal stress of its cells.
///
/// A reaction is the force of that stress where all is the same along the axis. As a traction of shape functions it would have the same
/// nodal forces, but another share ahead of a cut through the facets, and the forces along the axis at the ends, which are that
/// share in a layer of cells, would grow with the number of layers.
fn take_normal_stress<const D: usize>(
    mesh: &Mesh<D>,
    facets: &BTreeSet<Facet>,
    (cells, axis): (&CellForces<'_, D>, Point<D>),
    forces: &mut [Point<D>],
) -> Result<(), FemError> {
    for &facet in facets {
        let kind = mesh.facet_kind(facet);
        let rule = quadrature::rule(kind, MASS_DEGREE);
        let places: Vec<[f64; 3]> = rule.iter().map(|point| point.xi).collect();
        let stresses = normal_stresses(mesh, cells, (facet, &places), axis)?;
        for (QuadraturePoint { xi, weight }, stress) in rule.iter().zip(stresses) {
            // as long as the facet is large there
            let normal = mesh.outward_normal(facet, xi);
            let mut shape = [0.0; MAX_FACET_NODES];
            kind.shape(xi, &mut shape);
            for (node, n) in mesh.facet_nodes(facet).zip(shape) {
                let force = &mut forces[node as usize];
                *force = add_scaled(*force, -weight * stress * n, normal);
            }
        }
    }
    Ok(())
}

/// Most steps of the conjugate gradients: with the diagonal divided out the mass of lines has eigenvalues between 1/2 and 2, that of
/// plane facets between 1/16 and 8.
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
    let mut rules: BTreeMap<CellKind, Vec<QuadraturePoint>> = BTreeMap::new();
    let mut entries: Vec<(usize, usize, f64)> = Vec::new();
    for &facet in facets {
        let kind = mesh.facet_kind(facet);
        let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|n| n as usize).collect();
        let rule = rules
            .entry(kind)
            .or_insert_with(|| quadrature::rule(kind, MASS_DEGREE));
        for QuadraturePoint { xi, weight } in rule.iter() {
            let mut shape = [0.0; MAX_FACET_NODES];
            kind.shape(xi, &mut shape);
            let area = weight
                * norm(mesh.outward_normal(facet, xi))
                * measure(analysis, body.thickness, mesh.facet_point(facet, xi));
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

/// Rules for the parts of a plane reference cell behind and ahead of a line, by the distances of its nodes ahead of it.
fn divided(kind: CellKind, distances: &[f64]) -> [Rule; 2] {
    let distance = |x: f64, y: f64| interpolated(kind, &[x, y], distances);
    divided_by(kind.domain() == Domain::Triangle, distance, POINTS)
}

/// Nodal values at a point of a cell.
fn interpolated(kind: CellKind, xi: &[f64], values: &[f64]) -> f64 {
    let mut shape = [0.0; MAX_CELL_NODES];
    kind.shape(xi, &mut shape);
    shape.iter().zip(values).map(|(n, d)| n * d).sum()
}

/// Rules for the parts of the reference triangle or square where a distance, of degree two at most along x, is negative and positive.
///
/// Lines of the cell along its first coordinate are cut where they meet the line; from one to the other Gauss rules go
/// between the places where the line enters or leaves the cell. Exact for straight cuts through parallelograms and
/// triangles, to rounding through all straight-sided cells.
fn divided_by(triangle: bool, distance: impl Fn(f64, f64) -> f64, points: usize) -> [Rule; 2] {
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
    let rule = gauss(points);
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

/// Tetrahedra of which a reference cell consists.
fn tetrahedra(domain: Domain) -> Vec<[[f64; 3]; 4]> {
    // a cube around its diagonal
    let corners: &[[usize; 4]] = match domain {
        Domain::Cube => &[
            [0, 1, 2, 6],
            [0, 2, 3, 6],
            [0, 3, 7, 6],
            [0, 7, 4, 6],
            [0, 4, 5, 6],
            [0, 5, 1, 6],
        ],
        Domain::Prism => &[[0, 1, 2, 3], [1, 2, 3, 4], [2, 3, 4, 5]],
        _ => &[[0, 1, 2, 3]],
    };
    let nodes = domain.linear().reference_nodes();
    corners.iter().map(|four| four.map(|k| nodes[k])).collect()
}

/// Most times that a tetrahedron is divided into eight where the distance is not linear in it, and the part of the distances of a
/// cell below which it counts as linear.
const MOST_DIVISIONS: usize = 2;
const LINEAR: f64 = 1e-4;

/// The part of the distances of a cell below which they are the same: rounding.
const CONSTANT: f64 = 1e-9;

/// Points of the Gauss rules across the parts of cells in space, and one less along them: exact for forces of degree two on cells with
/// straight sides.
const SOLID_POINTS: usize = 4;

/// The reference coordinate along which nodal values do not change, of cells that go along one.
fn constant_along(kind: CellKind, values: &[f64]) -> Option<usize> {
    let size = values.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
    let candidates = match kind.domain() {
        Domain::Cube => 0..3,
        Domain::Prism => 2..3,
        _ => 0..0,
    };
    let nodes = || kind.reference_nodes().iter().zip(values);
    let same = |k: usize| {
        let apart = |a: &[f64; 3], b: &[f64; 3]| (0..3).any(|i| i != k && a[i] != b[i]);
        nodes().all(|(a, x)| nodes().all(|(b, y)| apart(a, b) || (x - y).abs() <= CONSTANT * size))
    };
    candidates.into_iter().find(|k| same(*k))
}

/// Rules for the parts of a reference cell in space behind and ahead of a plane, by the distances of its nodes ahead of it.
///
/// Cells along whose one coordinate the distance does not change, those of extruded meshes, are divided as plane ones; others into
/// tetrahedra until the distance is linear in each, which are cut: exact where edges are parallel.
fn divided_solid(kind: CellKind, distances: &[f64]) -> [Rule; 2] {
    let distance = |xi: &[f64; 3]| interpolated(kind, xi, distances);
    if let Some(k) = constant_along(kind, distances) {
        let place = |x: f64, y: f64, z: f64| {
            let mut xi = [0.0; 3];
            (xi[(k + 1) % 3], xi[(k + 2) % 3], xi[k]) = (x, y, z);
            xi
        };
        let triangle = kind.domain() == Domain::Prism;
        let parts = divided_by(triangle, |x, y| distance(&place(x, y, 0.0)), SOLID_POINTS);
        let rule = gauss(SOLID_POINTS - 1);
        let carried = |([x, y, _], weight): ([f64; 3], f64)| {
            let rule = rule.iter();
            rule.map(move |&(z, w)| (place(x, y, z), weight * w))
                .collect::<Rule>()
        };
        return parts.map(|part| part.into_iter().flat_map(carried).collect());
    }
    let size = distances.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
    let mut parts = [Vec::new(), Vec::new()];
    let mut open: Vec<(usize, [[f64; 3]; 4])> = tetrahedra(kind.domain())
        .into_iter()
        .map(|t| (0, t))
        .collect();
    let between = |a: [f64; 3], b: [f64; 3]| add_scaled(a, 0.5, sub(b, a));
    while let Some((depth, corners)) = open.pop() {
        let values = corners.each_ref().map(distance);
        let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        let middles = edges.map(|[i, j]| between(corners[i], corners[j]));
        let off = |(k, [i, j]): (usize, [usize; 2])| {
            (distance(&middles[k]) - 0.5 * (values[i] + values[j])).abs()
        };
        let bent = edges.into_iter().enumerate().map(off).fold(0.0, f64::max);
        let nearest = values
            .iter()
            .fold(f64::INFINITY, |least, d| least.min(d.abs()));
        let same = values.iter().all(|d| *d >= 0.0) || values.iter().all(|d| *d <= 0.0);
        let linear = bent <= LINEAR * size || (same && nearest > 2.0 * bent);
        if linear || depth == MOST_DIVISIONS {
            cut_tetrahedron(corners, values, &mut parts);
            continue;
        }
        let [ab, ac, ad, bc, bd, cd] = middles;
        let [a, b, c, d] = corners;
        let eight = [
            [a, ab, ac, ad],
            [ab, b, bc, bd],
            [ac, bc, c, cd],
            [ad, bd, cd, d],
            [ab, ac, ad, cd],
            [ab, ad, bd, cd],
            [ab, bd, bc, cd],
            [ab, bc, ac, cd],
        ];
        open.extend(eight.map(|small| (depth + 1, small)));
    }
    parts
}

/// Adds the points of a rule in the parts of a tetrahedron where a linear function is negative and positive.
fn cut_tetrahedron(corners: [[f64; 3]; 4], values: [f64; 4], parts: &mut [Rule; 2]) {
    let mut add = |ahead: bool, corners: [[f64; 3]; 4]| {
        let [a, b, c, d] = corners;
        let (u, v, w) = (sub(b, a), sub(c, a), sub(d, a));
        let volume = dot(cross(u, v), w).abs();
        for QuadraturePoint { xi, weight } in quadrature::rule(CellKind::Tet4, PART_DEGREE) {
            let at = add_scaled(add_scaled(add_scaled(a, xi[0], u), xi[1], v), xi[2], w);
            parts[usize::from(ahead)].push((at, weight * volume));
        }
    };
    let mut order = [0, 1, 2, 3];
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let negative = values.iter().filter(|d| **d < 0.0).count();
    let at = order.map(|k| corners[k]);
    let zero = |i: usize, j: usize| {
        let (low, high) = (values[order[i]], values[order[j]]);
        add_scaled(at[i], low / (low - high), sub(at[j], at[i]))
    };
    // a prism between two triangles, as three tetrahedra
    let prism = |add: &mut dyn FnMut(bool, [[f64; 3]; 4]),
                 ahead: bool,
                 [a, b, c]: [[f64; 3]; 3],
                 [d, e, f]: [[f64; 3]; 3]| {
        add(ahead, [a, b, c, d]);
        add(ahead, [b, c, d, e]);
        add(ahead, [c, d, e, f]);
    };
    match negative {
        0 | 4 => add(negative == 0, corners),
        1 => {
            let cut = [zero(0, 1), zero(0, 2), zero(0, 3)];
            add(false, [at[0], cut[0], cut[1], cut[2]]);
            prism(&mut add, true, cut, [at[1], at[2], at[3]]);
        }
        3 => {
            let cut = [zero(0, 3), zero(1, 3), zero(2, 3)];
            add(true, [at[3], cut[0], cut[1], cut[2]]);
            prism(&mut add, false, cut, [at[0], at[1], at[2]]);
        }
        _ => {
            let [ac, ad, bc, bd] = [zero(0, 2), zero(0, 3), zero(1, 2), zero(1, 3)];
            prism(&mut add, false, [at[0], ac, ad], [at[1], bc, bd]);
            prism(&mut add, true, [at[2], ac, bc], [at[3], ad, bd]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_along_an_axis_are_those_of_their_integrals_with_the_hats() {
        let polynomial = |degree: i32, z: f64| 2.0 - z + 0.7 * z.powi(degree);
        // even ones bear parabolas, uneven ones lines; two levels lines
        for (levels, degree) in [
            (vec![-1.0, 0.5], 1),
            (vec![0.0, 0.4, 0.9], 2),
            (vec![-1.0, -0.7, -0.3, 0.2, 0.6, 0.9], 2),
            (vec![0.0, 0.1, 1.0, 1.2], 1),
            (vec![0.0, 0.5, 1.0, 3.0], 1),
        ] {
            let (first, last) = (levels[0], levels[levels.len() - 1]);
            let along = Along {
                middle: 0.0,
                places: vec![first, 0.3 * first + 0.7 * last, last],
                levels: levels.clone(),
            };
            let mut weighted = vec![Resultant::default(); levels.len()];
            for pair in levels.windows(2) {
                let half = 0.5 * (pair[1] - pair[0]);
                for (x, weight) in gauss(4) {
                    let z = pair[0] + half * (1.0 + x);
                    for (k, hat) in along.hats(z) {
                        weighted[k].force[0] += weight * half * hat * polynomial(degree, z);
                    }
                }
            }
            let values = along.values(weighted);
            for (place, value) in along.places.iter().zip(values) {
                let error = value.force[0] - polynomial(degree, *place);
                assert!(error.abs() < 1e-12, "{levels:?} at {place}: {error:.1e}");
            }
        }
    }

    #[test]
    fn a_divided_solid_keeps_its_volume_and_its_centroid() {
        // a plane through all kinds of cells, and one along one of their coordinates
        for plane in [[0.7, -1.0, 0.4, 0.1], [0.8, 0.3, 0.0, -0.1]] {
            for kind in [
                CellKind::Tet4,
                CellKind::Tet10,
                CellKind::Hex8,
                CellKind::Hex20,
                CellKind::Hex27,
                CellKind::Prism6,
                CellKind::Prism15,
            ] {
                let ahead = |x: &[f64; 3]| dot([plane[0], plane[1], plane[2]], *x) + plane[3];
                let nodes = kind.reference_nodes().iter();
                let parts = divided_solid(kind, &nodes.map(ahead).collect::<Vec<_>>());
                let sum = |f: &dyn Fn(&[f64; 3]) -> f64| -> f64 {
                    parts.iter().flatten().map(|(x, w)| w * f(x)).sum()
                };
                let volume = kind.domain().volume();
                assert!((sum(&|_| 1.0) - volume).abs() < 1e-12, "{kind:?}");
                let centre = kind.domain().centre();
                for axis in 0..3 {
                    assert!((sum(&|x| x[axis]) - centre[axis] * volume).abs() < 1e-12);
                }
                for (part, sign) in parts.iter().zip([-1.0, 1.0]) {
                    assert!(!part.is_empty());
                    // a corner of the cube lies on the plane to rounding
                    let beside = |(x, _): &([f64; 3], f64)| sign * ahead(x) > -1e-14;
                    assert!(part.iter().all(beside), "{kind:?}");
                }
            }
        }
        // the corner x + y + z < 1/2 of a tetrahedron is an eighth of it
        let [behind, _] = divided_solid(CellKind::Tet4, &[-0.5, 0.5, 0.5, 0.5]);
        let volume: f64 = behind.iter().map(|(_, w)| w).sum();
        assert!((volume - 1.0 / 48.0).abs() < 1e-14);
    }

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
