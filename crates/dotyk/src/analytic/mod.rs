//! Closed-form solutions, with which computed results are compared.
//!
//! Each file states author, year and source. Units are any consistent ones.
//! Signs: tensile stress is positive, pressure is positive in compression, lengths along a normal are
//! positive outward. Plane problems are per unit thickness.
//!
//! Nothing here knows a mesh; a value outside the domain of its formula is NaN, never a panic.

pub mod beam;
pub mod hertz;
pub mod lame;
pub mod lining;
pub mod mindlin;
pub mod punch;
pub mod ring;
pub mod scalar;
pub mod structures;

/// The assumption across the thickness of a plane body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    /// No strain across the thickness.
    Strain,
    /// No stress across the thickness.
    Stress,
}

/// Section forces of a lining, a beam or an arch. N is positive in compression; the signs of V and M are stated at each
/// source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionForces {
    /// Normal force N.
    pub normal: f64,
    /// Shear force V.
    pub shear: f64,
    /// Moment M about the middle of the section.
    pub moment: f64,
}

/// Isotropic linear elasticity: Young's modulus (force / area) and Poisson's ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus E.
    pub young: f64,
    /// Poisson's ratio ν.
    pub poisson: f64,
}

impl Material {
    /// The moduli to put into plane-stress formulas: (E, ν) in plane stress, (E/(1−ν²), ν/(1−ν)) in plane strain.
    pub fn in_plane(self, plane: Plane) -> Self {
        match plane {
            Plane::Stress => self,
            Plane::Strain => Self {
                young: self.young / (1.0 - self.poisson * self.poisson),
                poisson: self.poisson / (1.0 - self.poisson),
            },
        }
    }

    /// Shear modulus μ = E/(2(1+ν)); the same in both plane problems.
    pub fn shear(self) -> f64 {
        0.5 * self.young / (1.0 + self.poisson)
    }

    /// Kolosov's constant κ: 3 − 4ν in plane strain, (3−ν)/(1+ν) in plane stress.
    pub fn kolosov(self, plane: Plane) -> f64 {
        let poisson = self.in_plane(plane).poisson;
        (3.0 - poisson) / (1.0 + poisson)
    }
}

/// Solves a small dense system by elimination with partial pivoting; a singular one gives values that are not finite.
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for k in 0..N {
        let size = |i: &usize| matrix[*i][k].abs();
        let pivot = (k..N)
            .max_by(|i, j| size(i).total_cmp(&size(j)))
            .unwrap_or(k);
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        for i in k + 1..N {
            let factor = matrix[i][k] / matrix[k][k];
            let above = matrix[k];
            for (value, pivot) in matrix[i].iter_mut().zip(above).skip(k) {
                *value -= factor * pivot;
            }
            right[i] -= factor * right[k];
        }
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}

/// Numerical operations that know none of the formulas under test.
#[cfg(test)]
pub(crate) mod check {
    /// df/dx by central differences of fourth order.
    pub fn derivative(f: impl Fn(f64) -> f64, x: f64, h: f64) -> f64 {
        (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h)
    }

    /// ∫f from a to b by the midpoint rule in t, x = (a+b)/2 − (b−a)/2 cos t: exact to rounding for
    /// smooth f, and for f with a square root or inverse square root at either end.
    pub fn integral(f: impl Fn(f64) -> f64, a: f64, b: f64, points: usize) -> f64 {
        let step = std::f64::consts::PI / points as f64;
        let half = 0.5 * (b - a);
        (0..points)
            .map(|i| (i as f64 + 0.5) * step)
            .map(|t| f(0.5 * (a + b) - half * t.cos()) * t.sin())
            .sum::<f64>()
            * half
            * step
    }

    /// Principal value of ∫f(s)/(x−s) ds from −a to a, |x| < a, f continuous.
    pub fn hilbert(f: impl Fn(f64) -> f64, x: f64, a: f64, points: usize) -> f64 {
        let at_x = f(x);
        let regular = |s: f64| (f(s) - at_x) / (x - s);
        integral(regular, -a, x, points)
            + integral(regular, x, a, points)
            + at_x * ((x + a) / (a - x)).ln()
    }

    /// Asserts |a − b| ≤ tolerance, naming both.
    #[track_caller]
    pub fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a:e} is not {b:e}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_plane_problems_share_the_shear_modulus() {
        let steel = Material {
            young: 210e3,
            poisson: 0.3,
        };
        let effective = steel.in_plane(Plane::Strain);
        check::close(effective.shear(), steel.shear(), 1e-9);
        check::close(steel.kolosov(Plane::Strain), 3.0 - 4.0 * 0.3, 1e-15);
    }

    #[test]
    fn uniaxial_strain_follows_from_the_effective_moduli() {
        // Hooke's law in three dimensions with εzz = 0 and εyy = 0, against the plane formula.
        let (e, nu) = (7.0, 0.2);
        let exact = e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let m = Material {
            young: e,
            poisson: nu,
        }
        .in_plane(Plane::Strain);
        check::close(m.young / (1.0 - m.poisson * m.poisson), exact, 1e-12);
    }
}
