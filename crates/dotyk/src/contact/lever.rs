//! Tangential rows of points that lie apart.

use crate::contact::search::Hit;
use crate::geometry::{Point, add_scaled, dot, invert, unit};
use crate::mesh::{MAX_FACET_NODES, Mesh};

/// Contribution of the rotation W of a facet to tangential rows: s·t·W n, for points at the distance s along n.
///
/// In the tangents aₖ of the facet and its normal ν, t = Σ cₖaₖ + c_ν ν and n = Σ dₖaₖ + d_ν ν, W is known from the derivatives
/// u,ₖ of the displacements along it: ν·W aₖ = ν·u,ₖ and in space a₁·W a₂ = (a₁·u,₂ − a₂·u,₁)/2, hence
///
/// ```text
///   t·W n = Σ (c_ν dₖ − cₖ d_ν) ν·u,ₖ + (c₁d₂ − c₂d₁)(a₁·u,₂ − a₂·u,₁)/2
/// ```
pub(super) struct Lever<const D: usize> {
    distance: f64,
    tangents: [Point<D>; D],
    normal: Point<D>,
    /// Its rows give the cₖ and c_ν of a vector.
    inverse: [Point<D>; D],
    /// dₖ and d_ν.
    along_normal: Point<D>,
    slopes: [[f64; D]; MAX_FACET_NODES],
}

impl<const D: usize> Lever<D> {
    /// At a hit of a line along n.
    pub fn new(mesh: &Mesh<D>, hit: Hit, direction: Point<D>) -> Self {
        let mut slopes = [[0.0; D]; MAX_FACET_NODES];
        mesh.facet_kind(hit.facet).gradients(&hit.xi, &mut slopes);
        let mut tangents = mesh.facet_tangents(hit.facet, &hit.xi);
        let normal = unit(mesh.outward_normal(hit.facet, &hit.xi)).unwrap_or([0.0; D]);
        tangents[D - 1] = normal;
        let columns = std::array::from_fn(|i| tangents.map(|axis| axis[i]));
        let (inverse, _) = invert::<D>(&columns);
        Self {
            distance: hit.distance,
            along_normal: inverse.map(|row| dot(row, direction)),
            tangents,
            normal,
            inverse,
            slopes,
        }
    }

    /// Coefficients of the displacement of the facet's node at this place.
    pub fn along(&self, t: Point<D>, place: usize) -> Point<D> {
        let (d, slope) = (self.along_normal, self.slopes[place]);
        let c = self.inverse.map(|row| dot(row, t));
        let tilt: f64 = (0..D - 1)
            .map(|k| slope[k] * (c[D - 1] * d[k] - c[k] * d[D - 1]))
            .sum();
        let mut sum = self.normal.map(|n| tilt * n);
        if D > 2 {
            let twist = 0.5 * (c[0] * d[1] - c[1] * d[0]);
            sum = add_scaled(sum, twist * slope[1], self.tangents[0]);
            sum = add_scaled(sum, -twist * slope[0], self.tangents[1]);
        }
        sum.map(|x| self.distance * x)
    }
}
