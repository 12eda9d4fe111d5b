//! Isotropic linear elasticity without Voigt notation, so that one expression serves every dimension.
//!
//! With λ, μ after Lamé, gradients gₐ = ∇Nₐ and Mₐᵦ = ∫ gₐ ⊗ gᵦ, the block of the stiffness that couples nodes a and b is
//!
//! ```text
//!   Kₐᵦ = λ Mₐᵦ + μ Mₐᵦᵀ + μ tr(Mₐᵦ) I
//! ```
//!
//! In plane stress λ is replaced by 2λμ/(λ+2μ). With axial symmetry the hoop strain Nₐ/r joins the trace and adds 2μ∫NₐNᵦ/r².

use crate::fem::nouns::{Analysis, Elastic};

/// Lamé's parameters as an analysis uses them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lame {
    /// First parameter (reduced in plane stress).
    pub lambda: f64,
    /// Shear modulus.
    pub mu: f64,
    /// σzz = `out_of_plane` · (εxx + εyy) in plane analyses.
    pub out_of_plane: f64,
}

impl Lame {
    /// Parameters of a material in an analysis.
    pub fn new(elastic: Elastic, analysis: Analysis) -> Self {
        let Elastic { young, poisson } = elastic;
        let mu = young / (2.0 * (1.0 + poisson));
        let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        match analysis {
            Analysis::PlaneStress => Self {
                lambda: 2.0 * lambda * mu / (lambda + 2.0 * mu),
                mu,
                out_of_plane: 0.0,
            },
            _ => Self {
                lambda,
                mu,
                out_of_plane: lambda,
            },
        }
    }

    /// Stress (xx yy zz xy yz xz) of a displacement gradient `h[i][j] = ∂uᵢ/∂xⱼ` and a hoop strain (zero unless axisymmetric).
    pub fn stress<const D: usize>(self, gradient: [[f64; D]; D], hoop: f64) -> [f64; 6] {
        let strain = |i: usize, j: usize| {
            if i < D && j < D {
                0.5 * (gradient[i][j] + gradient[j][i])
            } else {
                0.0
            }
        };
        let trace = (0..D).map(|i| gradient[i][i]).sum::<f64>() + hoop;
        let direct = |i: usize| self.lambda * trace + 2.0 * self.mu * strain(i, i);
        let zz = if D == 3 {
            direct(2)
        } else {
            self.out_of_plane * trace + 2.0 * self.mu * hoop
        };
        let shear = |i: usize, j: usize| 2.0 * self.mu * strain(i, j);
        [
            direct(0),
            direct(1),
            zz,
            shear(0, 1),
            shear(1, 2),
            shear(0, 2),
        ]
    }

    /// Cε of a strain (xx yy zz xy yz xz, tensor components). In plane stress εzz follows from the others, whatever it is
    /// given as.
    pub fn stress_of(self, strain: [f64; 6], analysis: Analysis) -> [f64; 6] {
        let flat = analysis == Analysis::PlaneStress;
        let direct = if flat { 2 } else { 3 };
        let trace: f64 = strain[..direct].iter().sum();
        std::array::from_fn(|c| match c {
            2 if flat => 0.0,
            0..3 => self.lambda * trace + 2.0 * self.mu * strain[c],
            _ => 2.0 * self.mu * strain[c],
        })
    }

    /// Bulk modulus; not for plane stress.
    pub fn bulk(self) -> f64 {
        self.lambda + 2.0 / 3.0 * self.mu
    }

    /// Energy of distortion per volume of a strain (xx yy zz xy yz xz, tensor components).
    pub fn distortion(self, e: [f64; 6]) -> f64 {
        let trace: f64 = e[..3].iter().sum();
        let all = e[..3].iter().map(|c| c * c).sum::<f64>()
            + 2.0 * e[3..].iter().map(|c| c * c).sum::<f64>();
        self.mu * (all - trace * trace / 3.0)
    }

    /// Whether these are the parameters of plane stress, whose λ is 2μν/(1 − ν); without ν there is no difference.
    pub fn is_flat(self) -> bool {
        self.out_of_plane != self.lambda
    }

    /// Strain energy per volume of a stress (xx yy zz xy yz xz).
    pub fn energy(self, s: [f64; 6]) -> f64 {
        let trace = s[0] + s[1] + s[2];
        let all = s[..3].iter().map(|c| c * c).sum::<f64>()
            + 2.0 * s[3..].iter().map(|c| c * c).sum::<f64>();
        // ν/(1 + ν)
        let free = if self.is_flat() { 2.0 } else { 3.0 };
        let lateral = self.lambda / (free * self.lambda + 2.0 * self.mu);
        (all - lateral * trace * trace) / (4.0 * self.mu)
    }

    /// Strain (xx yy zz xy yz xz, tensor components) of a displacement gradient and a hoop strain; in plane stress with the
    /// one out of the plane.
    pub fn strain<const D: usize>(self, gradient: [[f64; D]; D], hoop: f64) -> [f64; 6] {
        let strain = |i: usize, j: usize| match i.max(j) < D {
            true => 0.5 * (gradient[i][j] + gradient[j][i]),
            false => 0.0,
        };
        let in_plane: f64 = (0..D).map(|i| gradient[i][i]).sum();
        let zz = match D {
            3 => strain(2, 2),
            _ if self.is_flat() => -self.lambda / (2.0 * self.mu) * in_plane,
            _ => hoop,
        };
        [
            strain(0, 0),
            strain(1, 1),
            zz,
            strain(0, 1),
            strain(1, 2),
            strain(0, 2),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Elastic = Elastic {
        young: 210.0,
        poisson: 0.3,
    };

    #[test]
    fn uniaxial_stress_follows_hooke() {
        // plane stress, ε = (1, −ν): only σxx = E remains
        let s = Lame::new(STEEL, Analysis::PlaneStress).stress([[1.0, 0.0], [0.0, -0.3]], 0.0);
        assert!((s[0] - 210.0).abs() < 1e-12 && s[1].abs() < 1e-12 && s[2] == 0.0);
        // in 3D with lateral contraction
        let s = Lame::new(STEEL, Analysis::Solid)
            .stress([[1.0, 0.0, 0.0], [0.0, -0.3, 0.0], [0.0, 0.0, -0.3]], 0.0);
        assert!((s[0] - 210.0).abs() < 1e-10 && s[1].abs() < 1e-10 && s[2].abs() < 1e-10);
    }

    #[test]
    fn the_energy_of_a_stress_is_half_its_work() {
        let h = [
            [1e-3, 4e-4, -3e-4],
            [-2e-4, -5e-4, 6e-4],
            [7e-4, 1e-4, 2e-4],
        ];
        let work = |s: [f64; 6], e: [f64; 6]| -> f64 {
            (0..6)
                .map(|c| if c < 3 { 0.5 } else { 1.0 } * s[c] * e[c])
                .sum()
        };
        let lame = Lame::new(STEEL, Analysis::Solid);
        let (s, e) = (lame.stress(h, 0.0), lame.strain(h, 0.0));
        assert!((lame.energy(s) / work(s, e) - 1.0).abs() < 1e-14);
        let volume: f64 = e[..3].iter().sum();
        let parts = lame.distortion(e) + 0.5 * lame.bulk() * volume * volume;
        assert!((parts / work(s, e) - 1.0).abs() < 1e-14);
        let flat = [[1e-3, 4e-4], [-2e-4, -5e-4]];
        for analysis in [Analysis::PlaneStress, Analysis::PlaneStrain] {
            let lame = Lame::new(STEEL, analysis);
            let (s, e) = (lame.stress(flat, 0.0), lame.strain(flat, 0.0));
            assert!((lame.energy(s) / work(s, e) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn plane_strain_keeps_the_out_of_plane_stress() {
        let s = Lame::new(STEEL, Analysis::PlaneStrain).stress([[0.2, 0.1], [0.1, -0.5]], 0.0);
        assert!((s[2] - 0.3 * (s[0] + s[1])).abs() < 1e-10);
        assert!((s[3] - 0.2 * 210.0 / 2.6).abs() < 1e-12);
    }

    #[test]
    fn stress_and_strain_obey_hookes_law_in_space() {
        let Elastic { young, poisson } = STEEL;
        let gradient = [[1e-3, 4e-4], [-2e-4, -5e-4]];
        for analysis in [
            Analysis::PlaneStrain,
            Analysis::PlaneStress,
            Analysis::Axisymmetric,
        ] {
            let hoop = if analysis == Analysis::Axisymmetric {
                7e-4
            } else {
                0.0
            };
            let lame = Lame::new(STEEL, analysis);
            let (s, e) = (lame.stress(gradient, hoop), lame.strain(gradient, hoop));
            let direct = |a: usize, b: usize, c: usize| (s[a] - poisson * (s[b] + s[c])) / young;
            for (a, b, c) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                assert!((direct(a, b, c) - e[a]).abs() < 1e-15, "{analysis:?}");
            }
            assert!((s[3] * (1.0 + poisson) / young - e[3]).abs() < 1e-15);
            assert_eq!(e[4..], [0.0, 0.0]);
        }
    }
}
