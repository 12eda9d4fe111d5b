//! Cells as images of reference cells: shape functions at the points of a rule, gradients and volumes there.

use crate::fem::enhanced::has_modes;
use crate::fem::nouns::{Analysis, Formulation};
use crate::fem::quadrature;
use crate::geometry::{Point, add_scaled, invert};
use crate::mesh::{CellKind, MAX_CELL_NODES};

/// Factor of an area in the (r, z) or (x, y) plane: thickness, 2πr, or 1 in 3D.
pub(crate) fn measure<const D: usize>(analysis: Analysis, thickness: f64, point: Point<D>) -> f64 {
    match analysis {
        Analysis::PlaneStrain | Analysis::PlaneStress => thickness,
        Analysis::Axisymmetric => 2.0 * std::f64::consts::PI * point[0],
        Analysis::Solid => 1.0,
    }
}

/// Shape functions and their reference gradients at the points of a rule.
pub(crate) struct CellTable<const D: usize> {
    nodes: usize,
    weights: Vec<f64>,
    shapes: Vec<[f64; MAX_CELL_NODES]>,
    gradients: Vec<[[f64; D]; MAX_CELL_NODES]>,
    /// Reference points.
    points: Vec<[f64; 3]>,
    /// Reference gradients at the centre, where the cells have incompatible modes.
    centre: Option<[[f64; D]; MAX_CELL_NODES]>,
}

impl<const D: usize> CellTable<D> {
    /// At the points of a rule that integrates polynomials of the given degree.
    pub fn new(kind: CellKind, degree: usize) -> Self {
        let rule = quadrature::rule(kind, degree).into_iter();
        let points: Vec<([f64; 3], f64)> = rule.map(|point| (point.xi, point.weight)).collect();
        Self::at(kind, &points)
    }

    /// At given reference points with weights.
    pub fn at(kind: CellKind, rule: &[([f64; 3], f64)]) -> Self {
        let mut table = Self {
            nodes: kind.nodes(),
            weights: Vec::new(),
            shapes: Vec::new(),
            gradients: Vec::new(),
            points: rule.iter().map(|(xi, _)| *xi).collect(),
            centre: None,
        };
        for &(xi, weight) in rule {
            let (mut shape, mut gradient) = ([0.0; MAX_CELL_NODES], [[0.0; D]; MAX_CELL_NODES]);
            kind.shape(&xi, &mut shape);
            kind.gradients(&xi, &mut gradient);
            table.weights.push(weight);
            table.shapes.push(shape);
            table.gradients.push(gradient);
        }
        table
    }

    /// The same with incompatible modes, where cells of this kind and formulation have some.
    pub fn formulated(mut self, kind: CellKind, formulation: Formulation) -> Self {
        if formulation == Formulation::Enhanced && has_modes(kind) {
            let mut gradients = [[0.0; D]; MAX_CELL_NODES];
            kind.gradients(&kind.domain().centre(), &mut gradients);
            self.centre = Some(gradients);
        }
        self
    }

    /// Number of nodes and of incompatible modes, whose gradients follow those of the nodes.
    pub fn count(&self) -> usize {
        self.nodes + if self.centre.is_some() { D } else { 0 }
    }

    /// Its reference points with their weights.
    pub fn rule(&self) -> Vec<([f64; 3], f64)> {
        let points = self.points.iter().copied();
        points.zip(self.weights.iter().copied()).collect()
    }

    /// Its reference points.
    pub fn places(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Shape functions at point q.
    pub fn shape(&self, q: usize) -> &[f64] {
        &self.shapes[q][..self.nodes]
    }

    /// Image of point q, gradients ∇Nₐ there and the volume weight·det J, for a cell whose nodes lie at `at(local)`.
    pub fn map(
        &self,
        q: usize,
        at: impl Fn(usize) -> Point<D>,
    ) -> (Point<D>, [[f64; D]; MAX_CELL_NODES], f64) {
        let (shape, reference) = (&self.shapes[q], &self.gradients[q]);
        let mut point = [0.0; D];
        let mut jacobian = [[0.0; D]; D]; // ∂xᵢ/∂ξⱼ
        for a in 0..self.nodes {
            let x = at(a);
            for i in 0..D {
                point[i] += shape[a] * x[i];
                for j in 0..D {
                    jacobian[i][j] += x[i] * reference[a][j];
                }
            }
        }
        let (inverse, det) = invert(&jacobian);
        let mut gradients = [[0.0; D]; MAX_CELL_NODES];
        for a in 0..self.nodes {
            for i in 0..D {
                gradients[a][i] = (0..D).map(|j| reference[a][j] * inverse[j][i]).sum();
            }
        }
        if let Some(centre) = &self.centre {
            let mut jacobian = [[0.0; D]; D];
            for (a, slope) in centre.iter().enumerate().take(self.nodes) {
                for (row, c) in jacobian.iter_mut().zip(at(a)) {
                    *row = add_scaled(*row, c, *slope);
                }
            }
            let (inverse, middle) = invert(&jacobian);
            for k in 0..D {
                let slope = -2.0 * self.points[q][k] * middle / det;
                gradients[self.nodes + k] = inverse[k].map(|c| slope * c);
            }
        }
        (point, gradients, det * self.weights[q])
    }
}

/// The table of the stiffness of the cells of a body.
pub(crate) fn stiffness_table<const D: usize>(
    kind: CellKind,
    analysis: Analysis,
    formulation: Formulation,
) -> CellTable<D> {
    CellTable::new(kind, stiffness_degree(kind, analysis)).formulated(kind, formulation)
}

/// Degree of the quadrature of the stiffness. With axial symmetry it integrates the forces of a constant stress exactly,
/// and one point is not enough: the hoop strain varies.
pub(crate) fn stiffness_degree(kind: CellKind, analysis: Analysis) -> usize {
    match analysis {
        Analysis::Axisymmetric => kind.stiffness_degree().max(2),
        _ => kind.stiffness_degree(),
    }
}
