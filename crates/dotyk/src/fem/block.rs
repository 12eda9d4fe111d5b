//! The cells of a block, which have one material and one quadrature: stiffness, incompatible modes, deformation.

use crate::fem::cells::{CellTable, measure, stiffness_table};
use crate::fem::elasticity::Lame;
use crate::fem::enhanced::{amplitudes, condense, eliminate, relative};
use crate::fem::error::FemError;
use crate::fem::initial::body_degree;
use crate::fem::nouns::{Analysis, Body, Formulation};
use crate::geometry::{Point, add_scaled, dot, sub};
use crate::mesh::{CellBlock, MAX_CELL_NODES};

/// The cells of a block.
pub(crate) struct Cells<'a, const D: usize> {
    body: &'a Body<D>,
    pub analysis: Analysis,
    pub lame: Lame,
    pub table: CellTable<D>,
}

/// Deformation of a cell at a point of its rule.
pub(crate) struct Deformation<const D: usize> {
    /// Undeformed.
    pub point: Point<D>,
    /// ∇Nₐ of the nodes, then the gradients of the modes.
    pub gradients: [[f64; D]; MAX_CELL_NODES],
    /// Weight of the point, with thickness or 2πr.
    pub volume: f64,
    /// ∂uᵢ/∂xⱼ.
    pub gradient: [[f64; D]; D],
    /// Hoop strain with axial symmetry, else zero.
    pub hoop: f64,
}

impl<'a, const D: usize> Cells<'a, D> {
    /// With the quadrature of the stiffness. Errors: a group of cells without a material.
    pub fn new(
        body: &'a Body<D>,
        block: &CellBlock,
        analysis: Analysis,
        formulation: Formulation,
    ) -> Result<Self, FemError> {
        Ok(Self {
            body,
            analysis,
            lame: Lame::new(body.elastic(block)?, analysis),
            table: stiffness_table(block.kind, analysis, formulation),
        })
    }

    /// The same cells at the points that initial stresses and strains are integrated with.
    pub fn for_initial(&self, block: &CellBlock) -> Self {
        let table = CellTable::new(block.kind, body_degree(block.kind.order()));
        self.at(table.formulated(block.kind, self.body.formulation))
    }

    /// The same cells at other points.
    pub fn at(&self, table: CellTable<D>) -> Self {
        Self { table, ..*self }
    }

    /// Dofs of a cell, those of its modes included: the order of its stiffness.
    pub fn size(&self) -> usize {
        D * self.table.count()
    }

    /// Image of point q, gradients there and its volume, with thickness or 2πr, for a cell whose nodes lie at `at(local)`.
    ///
    /// With axial symmetry the gradients of the modes are those of the plane less their mean over the ring, so that a constant
    /// stress does no work on them there either; they have no hoop strain.
    fn image(
        &self,
        q: usize,
        at: impl Fn(usize) -> Point<D>,
    ) -> (Point<D>, [[f64; D]; MAX_CELL_NODES], f64) {
        let (point, mut gradients, volume) = self.table.map(q, &at);
        let nodes = self.table.shape(q).len();
        if self.analysis == Analysis::Axisymmetric && self.table.count() > nodes {
            let (mut sums, mut ring) = ([[0.0; D]; D], 0.0);
            for q in 0..self.table.len() {
                let (point, slopes, volume) = self.table.map(q, &at);
                let weight = volume * point[0];
                ring += weight;
                for (sum, slope) in sums.iter_mut().zip(&slopes[nodes..]) {
                    *sum = add_scaled(*sum, weight, *slope);
                }
            }
            for (slope, sum) in gradients[nodes..].iter_mut().zip(&sums) {
                *slope = add_scaled(*slope, -1.0 / ring, *sum);
            }
        }
        let measure = measure(self.analysis, self.body.thickness, point);
        (point, gradients, volume * measure)
    }

    /// Stiffness of a cell, dense and row-major (size, size), in global axes, its modes eliminated: the leading part is that
    /// of the nodes, and the rows after it give the modes.
    pub fn stiffness(&self, cell: &[u32], matrix: &mut [f64]) {
        let (k, size) = (self.table.count(), self.size());
        let (lame, points) = (self.lame, self.body.mesh.points());
        let mut at = [[0.0; D]; MAX_CELL_NODES];
        for (x, &node) in at.iter_mut().zip(cell) {
            *x = points[node as usize];
        }
        matrix.fill(0.0);
        for q in 0..self.table.len() {
            let (point, g, w) = self.image(q, |local| at[local]);
            let mut hoop = [0.0; MAX_CELL_NODES];
            if self.analysis == Analysis::Axisymmetric {
                for (h, n) in hoop.iter_mut().zip(self.table.shape(q)) {
                    *h = n / point[0];
                }
            }
            for a in 0..k {
                for b in a..k {
                    let gg = w * lame.mu * dot(g[a], g[b]);
                    for i in 0..D {
                        for j in 0..D {
                            // the hoop strain enters the trace through the first (radial) component only
                            let (ta, tb) = (
                                g[a][i] + if i == 0 { hoop[a] } else { 0.0 },
                                g[b][j] + if j == 0 { hoop[b] } else { 0.0 },
                            );
                            matrix[(D * a + i) * size + D * b + j] +=
                                w * (lame.lambda * ta * tb + lame.mu * g[a][j] * g[b][i]);
                        }
                        matrix[(D * a + i) * size + D * b + i] += gg;
                    }
                    matrix[D * a * size + D * b] += 2.0 * w * lame.mu * hoop[a] * hoop[b];
                }
            }
        }
        for row in 0..size {
            for column in 0..row {
                matrix[row * size + column] = matrix[column * size + row];
            }
        }
        eliminate(matrix, size, D * cell.len());
    }

    /// The amplitudes of the incompatible modes of a cell under the given nodal displacements and holding forces (modes,); empty
    /// without modes.
    pub fn modes(
        &self,
        cell: &[u32],
        displacement: &[Point<D>],
        held: &[Point<D>],
    ) -> Vec<Point<D>> {
        if self.table.count() == cell.len() {
            return Vec::new();
        }
        let (matrix, forces) = self.condensed(cell, held);
        let relative = relative(cell, displacement);
        amplitudes(&matrix, self.size(), &relative, &forces)
    }

    /// Adds the nodal equivalent of forces that hold the modes of a cell (modes,).
    pub fn hand_on(&self, cell: &[u32], held: &[Point<D>], forces: &mut [Point<D>]) {
        if held.is_empty() {
            return;
        }
        let condensed = self.condensed(cell, held).1;
        let sums = forces.as_flattened_mut().iter_mut().zip(condensed);
        sums.for_each(|(sum, force)| *sum += force);
    }

    /// The stiffness of a cell, its modes eliminated, and forces on these (modes,) transferred to the nodes: (size,).
    fn condensed(&self, cell: &[u32], held: &[Point<D>]) -> (Vec<f64>, Vec<f64>) {
        let (size, kept) = (self.size(), D * cell.len());
        let mut matrix = vec![0.0; size * size];
        self.stiffness(cell, &mut matrix);
        let mut forces = vec![0.0; size];
        let behind = forces[kept..].iter_mut().zip(held.as_flattened());
        behind.for_each(|(force, held)| *force = *held);
        condense(&matrix, size, kept, &mut forces);
        (matrix, forces)
    }

    /// Image of point q of a cell, gradients there, those of the modes behind those of the nodes, and its weight, with thickness
    /// or 2πr.
    pub fn map(&self, q: usize, cell: &[u32]) -> (Point<D>, [[f64; D]; MAX_CELL_NODES], f64) {
        let points = self.body.mesh.points();
        self.image(q, |a| points[cell[a] as usize])
    }

    /// The deformation of a cell at point q under the given nodal displacements and the amplitudes of its modes.
    ///
    /// Displacements enter as differences within the cell, so that a rigid motion does not round its strains.
    pub fn deformation(
        &self,
        q: usize,
        (cell, modes): (&[u32], &[Point<D>]),
        displacement: &[Point<D>],
    ) -> Deformation<D> {
        let (point, gradients, volume) = self.map(q, cell);
        let first = displacement[cell[0] as usize];
        let relative = cell.iter().map(|&n| sub(displacement[n as usize], first));
        let amplitudes = relative.chain(modes.iter().copied());
        let mut gradient = [[0.0; D]; D];
        for (u, slope) in amplitudes.zip(&gradients) {
            for (row, c) in gradient.iter_mut().zip(u) {
                *row = add_scaled(*row, c, *slope);
            }
        }
        let hoop = match self.analysis {
            Analysis::Axisymmetric => {
                let radial = cell.iter().zip(self.table.shape(q));
                let radial = radial.map(|(&node, n)| n * displacement[node as usize][0]);
                radial.sum::<f64>() / point[0]
            }
            _ => 0.0,
        };
        Deformation {
            point,
            gradients,
            volume,
            gradient,
            hoop,
        }
    }
}
