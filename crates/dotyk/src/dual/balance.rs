//! Gλ = e in orthonormal coordinates: what the contact can control of the rigid modes, and what it cannot.
//!
//! Gᵀ = Σ σⱼ gⱼ zⱼᵀ with orthonormal gⱼ (m,) and zⱼ (r,). Combinations z of modes with Gᵀz = 0 move no contact node
//! along its normal: no contact force can hold them. The solvers work with the rows gⱼ of the others, so that
//! dependent modes need no care there; amplitudes α come back with no part along the uncontrolled modes
//! (least norm). Modes are expected scaled to largest displacement 1. The eigenvalues of GGᵀ would lose half of the
//! digits, hence the singular value decomposition.

use crate::dual::{Equilibrium, Mat};
use crate::linalg::dense::singular_value_decomposition;

/// Largest |Gᵀz| of an uncontrolled mode over the largest |G|.
const UNCONTROLLED: f64 = 1e-8;

/// Orthonormal basis of R^r, split by what the contact controls.
#[derive(Debug, Clone)]
pub struct ModeSplit {
    /// (r, k): modes that some contact force does work on.
    pub controlled: Mat<f64>,
    /// (r, r − k): modes that no contact force does work on.
    pub uncontrolled: Mat<f64>,
}

/// Splits R^r into the modes that the contact controls and those with Gᵀz = 0. Shapes: `modes` (r, m).
pub fn uncontrolled_modes(modes: &Mat<f64>) -> ModeSplit {
    let r = modes.nrows();
    let split = singular_directions(modes);
    let columns = |wanted: bool| {
        let chosen: Vec<&Vec<f64>> = split
            .iter()
            .filter(|direction| direction.controlled == wanted)
            .map(|direction| &direction.mode)
            .collect();
        Mat::from_fn(r, chosen.len(), |i, j| chosen[j][i])
    };
    ModeSplit {
        controlled: columns(true),
        uncontrolled: columns(false),
    }
}

/// Gλ = e without the uncontrolled modes, with orthonormal rows: Ĝλ = ê, k rows.
///
/// Amplitudes α̂ belong to Ĝ: Gᵀα = Ĝᵀα̂.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Ĝ: k rows of length m, orthonormal.
    pub rows: Vec<Vec<f64>>,
    /// ê, (k,).
    pub load: Vec<f64>,
    /// zⱼ, k vectors of length r.
    modes: Vec<Vec<f64>>,
    /// σⱼ.
    sigma: Vec<f64>,
    /// r.
    original: usize,
}

impl Balance {
    /// Orthonormal form of `equilibrium`.
    pub fn new(equilibrium: &Equilibrium) -> Self {
        let mut balance = Self {
            rows: Vec::new(),
            load: Vec::new(),
            modes: Vec::new(),
            sigma: Vec::new(),
            original: equilibrium.modes.nrows(),
        };
        for direction in singular_directions(&equilibrium.modes) {
            if direction.controlled {
                let inverse = 1.0 / direction.sigma;
                balance
                    .load
                    .push(inverse * dot(&direction.mode, &equilibrium.load));
                balance
                    .rows
                    .push(direction.image.iter().map(|x| inverse * x).collect());
                balance.modes.push(direction.mode);
                balance.sigma.push(direction.sigma);
            }
        }
        balance
    }

    /// Replaces the load by e (r,).
    pub fn set_load(&mut self, load: &[f64]) {
        for ((own, mode), sigma) in self.load.iter_mut().zip(&self.modes).zip(&self.sigma) {
            *own = dot(mode, load) / sigma;
        }
    }

    /// Number k of controlled modes.
    pub fn rank(&self) -> usize {
        self.rows.len()
    }

    /// Ĝλ − ê, (k,), into `out`.
    pub fn imbalance(&self, lambda: &[f64], out: &mut [f64]) {
        for ((out, row), load) in out.iter_mut().zip(&self.rows).zip(&self.load) {
            *out = dot(row, lambda) - load;
        }
    }

    /// Ĝv, (k,), into `out`.
    pub fn apply(&self, v: &[f64], out: &mut [f64]) {
        for (out, row) in out.iter_mut().zip(&self.rows) {
            *out = dot(row, v);
        }
    }

    /// Adds factor · Ĝᵀα̂ to `out`, (m,).
    pub fn add_transposed(&self, factor: f64, alpha: &[f64], out: &mut [f64]) {
        for (row, alpha) in self.rows.iter().zip(alpha) {
            let scale = factor * alpha;
            for (out, row) in out.iter_mut().zip(row) {
                *out += scale * row;
            }
        }
    }

    /// α (r,) with Gᵀα = Ĝᵀα̂, of least norm.
    pub fn to_original(&self, alpha: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for ((mode, sigma), alpha) in self.modes.iter().zip(&self.sigma).zip(alpha) {
            for (out, z) in out.iter_mut().zip(mode) {
                *out += alpha / sigma * z;
            }
        }
    }

    /// α̂ (k,) with Ĝᵀα̂ = Gᵀα.
    pub fn from_original(&self, alpha: &[f64], out: &mut [f64]) {
        for ((out, mode), sigma) in out.iter_mut().zip(&self.modes).zip(&self.sigma) {
            *out = sigma * dot(mode, alpha);
        }
    }

    /// Number r of modes.
    pub fn original_len(&self) -> usize {
        self.original
    }
}

/// One singular triple of Gᵀ.
struct Direction {
    /// z, (r,), unit.
    mode: Vec<f64>,
    /// Gᵀz = σ g, (m,).
    image: Vec<f64>,
    sigma: f64,
    controlled: bool,
}

/// The singular triples of Gᵀ, and the modes without an image behind them.
fn singular_directions(modes: &Mat<f64>) -> Vec<Direction> {
    let (r, m) = (modes.nrows(), modes.ncols());
    let transposed = Mat::from_fn(m, r, |i, j| modes[(j, i)]);
    // a matrix that is not finite is an error of the problem, which its check tells
    let Ok(spectrum) = singular_value_decomposition(&transposed) else {
        return Vec::new();
    };
    let largest = (0..r)
        .map(|i| largest_of((0..m).map(|j| modes[(i, j)])))
        .fold(0.0, f64::max);
    (0..r)
        .map(|j| {
            let sigma = spectrum.values.get(j).copied().unwrap_or(0.0);
            let image: Vec<f64> = match j < spectrum.left.ncols() {
                true => spectrum
                    .left
                    .col_as_slice(j)
                    .iter()
                    .map(|u| sigma * u)
                    .collect(),
                false => vec![0.0; m],
            };
            Direction {
                mode: spectrum.right.col_as_slice(j).to_vec(),
                controlled: largest_of(image.iter().copied()) > UNCONTROLLED * largest,
                sigma,
                image,
            }
        })
        .collect()
}

fn largest_of(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normals of a full ring: translations are controlled, the spin is not.
    fn ring(m: usize) -> Equilibrium {
        let angle = |j: usize| std::f64::consts::TAU * j as f64 / m as f64;
        Equilibrium::new(
            Mat::from_fn(3, m, |i, j| {
                let (sin, cos) = angle(j).sin_cos();
                // The spin about another point: tangent · normal = 0 plus translations.
                [cos, sin, 0.3 * cos - 0.2 * sin][i]
            }),
            vec![1.0, -2.0, 0.3 * 1.0 + 0.2 * 2.0],
        )
    }

    #[test]
    fn spin_of_a_ring_is_the_only_uncontrolled_mode() {
        let equilibrium = ring(24);
        let split = uncontrolled_modes(&equilibrium.modes);
        assert_eq!(split.controlled.ncols(), 2);
        assert_eq!(split.uncontrolled.ncols(), 1);
        for j in 0..24 {
            let image: f64 = (0..3)
                .map(|i| equilibrium.modes[(i, j)] * split.uncontrolled[(i, 0)])
                .sum();
            assert!(image.abs() < 1e-15);
        }
        let expected = [0.3, -0.2, -1.0].map(|x: f64| x / 1.13f64.sqrt());
        let sign = -split.uncontrolled[(2, 0)].signum();
        for (i, expected) in expected.iter().enumerate() {
            assert!((sign * split.uncontrolled[(i, 0)] - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn orthonormal_form_has_the_same_solutions() {
        let equilibrium = ring(24);
        let balance = Balance::new(&equilibrium);
        assert_eq!(balance.rank(), 2);
        for (i, a) in balance.rows.iter().enumerate() {
            for (j, b) in balance.rows.iter().enumerate() {
                assert!((dot(a, b) - f64::from(i == j)).abs() < 1e-14);
            }
        }
        // λ of least norm that balances the reduced rows balances the original ones, the redundant included.
        let mut lambda = vec![0.0; 24];
        balance.add_transposed(1.0, &balance.load, &mut lambda);
        for i in 0..3 {
            let sum: f64 = (0..24).map(|j| equilibrium.modes[(i, j)] * lambda[j]).sum();
            assert!((sum - equilibrium.load[i]).abs() < 1e-14);
        }
    }

    #[test]
    fn amplitudes_keep_their_contact_displacements() {
        let equilibrium = ring(24);
        let balance = Balance::new(&equilibrium);
        let alpha = [0.4, -1.1, 0.7];
        let (mut reduced, mut back) = ([0.0; 2], [0.0; 3]);
        balance.from_original(&alpha, &mut reduced);
        balance.to_original(&reduced, &mut back);
        let mut image = vec![0.0; 24];
        balance.add_transposed(1.0, &reduced, &mut image);
        for (j, image) in image.iter().enumerate() {
            let of = |alpha: &[f64]| -> f64 {
                (0..3).map(|i| equilibrium.modes[(i, j)] * alpha[i]).sum()
            };
            assert!((of(&alpha) - image).abs() < 1e-14);
            assert!((of(&back) - image).abs() < 1e-14);
        }
        assert!(dot(&back, &back) < dot(&alpha, &alpha));
    }
}
