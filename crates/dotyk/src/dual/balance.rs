//! Gλ = e in orthonormal coordinates: what the contact can control of the rigid modes, and what it cannot.
//!
//! Gᵀ = Σ σⱼ gⱼ zⱼᵀ with orthonormal gⱼ (m,) and zⱼ (r,). Combinations z of modes with Gᵀz = 0 move no contact node
//! along its normal: no contact force can hold them. The solvers work with the rows gⱼ of the others, so that
//! dependent modes need no care there; amplitudes α come back with no part along the uncontrolled modes
//! (least norm). Modes are expected scaled to largest displacement 1. The eigenvalues of GGᵀ would lose half of the
//! digits, hence the singular value decomposition.
//!
//! Of many bodies each touches few others, and G is sparse (`grouped.rs`). Where the modes that every body by itself has
//! under control are together far from dependent, MMᵀ = LLᵀ of these modes M = ZG loses nothing, and Ĝ = L⁻¹M with
//! α̂ = LᵀZα takes the place of the decomposition: an entry of Ĝ is not zero only on the way from a contact to the last
//! body that is eliminated.

use crate::dual::grouped::Grouped;
use crate::dual::{Equilibrium, Mat, Modes};
use crate::linalg::dense::{
    cholesky_in_place, gram, singular_value_decomposition, solve_lower_in_place,
};
use crate::linalg::{Cholesky, SparseVector};

/// Largest |Gᵀz| of an uncontrolled mode over the largest |G|.
const UNCONTROLLED: f64 = 1e-8;

/// Orthonormal basis of R^r, split by what the contact controls.
#[derive(Debug, Clone)]
pub struct ModeSplit {
    /// k modes (r,) that some contact force does work on.
    pub controlled: Vec<SparseVector>,
    /// r − k modes (r,) that no contact force does work on.
    pub uncontrolled: Vec<SparseVector>,
}

/// Splits R^r into the modes that the contact controls and those with Gᵀz = 0. Shapes: `modes` (r, m).
pub fn uncontrolled_modes(modes: &Modes) -> ModeSplit {
    if let Some(grouped) = Grouped::new(modes) {
        return grouped.split;
    }
    let split = singular_directions(&modes.to_dense(), modes.largest());
    let (controlled, uncontrolled): (Vec<_>, Vec<_>) =
        split.into_iter().partition(|d| d.controlled);
    let sparse = |list: Vec<Direction>| {
        let modes = list.iter().map(|d| SparseVector::from_dense(&d.mode));
        modes.collect()
    };
    ModeSplit {
        controlled: sparse(controlled),
        uncontrolled: sparse(uncontrolled),
    }
}

/// Gλ = e without the uncontrolled modes, with orthonormal rows: Ĝλ = ê, k rows.
///
/// Amplitudes α̂ belong to Ĝ: Gᵀα = Ĝᵀα̂.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Ĝ: k rows of length m, orthonormal.
    pub rows: Vec<SparseVector>,
    /// ê, (k,).
    pub load: Vec<f64>,
    /// zⱼ, k orthonormal vectors of length r.
    modes: Vec<SparseVector>,
    scale: Scale,
    /// r.
    original: usize,
}

/// How α̂ follows from Zα.
#[derive(Debug, Clone)]
enum Scale {
    /// σⱼ of each.
    Singular(Vec<f64>),
    /// The images M of the modes, and L.
    Factored(Vec<SparseVector>, Cholesky),
}

impl Balance {
    /// Orthonormal form of `equilibrium`.
    pub fn new(equilibrium: &Equilibrium) -> Self {
        let mut balance = match Grouped::new(&equilibrium.modes) {
            Some(grouped) => Self::factored(grouped),
            None => Self::singular(&equilibrium.modes),
        };
        balance.original = equilibrium.modes.nrows();
        balance.load = vec![0.0; balance.rank()];
        balance.set_load(&equilibrium.load);
        balance
    }

    fn singular(modes: &Modes) -> Self {
        let mut balance = Self {
            rows: Vec::new(),
            load: Vec::new(),
            modes: Vec::new(),
            scale: Scale::Singular(Vec::new()),
            original: 0,
        };
        let mut values = Vec::new();
        for direction in singular_directions(&modes.to_dense(), modes.largest()) {
            if direction.controlled {
                let mut row = SparseVector::from_dense(&direction.image);
                row.scale(1.0 / direction.sigma);
                balance.rows.push(row);
                balance
                    .modes
                    .push(SparseVector::from_dense(&direction.mode));
                values.push(direction.sigma);
            }
        }
        balance.scale = Scale::Singular(values);
        balance
    }

    fn factored(grouped: Grouped) -> Self {
        Self {
            rows: grouped.orthonormal_rows(),
            load: Vec::new(),
            modes: grouped.split.controlled,
            scale: Scale::Factored(grouped.images, grouped.factor),
            original: 0,
        }
    }

    /// Replaces the load by e (r,).
    pub fn set_load(&mut self, load: &[f64]) {
        let parts = self.modes.iter().map(|mode| mode.dot(load));
        self.load = match &self.scale {
            Scale::Singular(sigma) => parts.zip(sigma).map(|(part, s)| part / s).collect(),
            Scale::Factored(_, factor) => factor.forward(&parts.collect::<Vec<f64>>()),
        };
    }

    /// Number k of controlled modes.
    pub fn rank(&self) -> usize {
        self.rows.len()
    }

    /// Ĝλ − ê, (k,), into `out`.
    pub fn imbalance(&self, lambda: &[f64], out: &mut [f64]) {
        for ((out, row), load) in out.iter_mut().zip(&self.rows).zip(&self.load) {
            *out = row.dot(lambda) - load;
        }
    }

    /// Ĝv, (k,), into `out`.
    pub fn apply(&self, v: &[f64], out: &mut [f64]) {
        for (out, row) in out.iter_mut().zip(&self.rows) {
            *out = row.dot(v);
        }
    }

    /// Adds factor · Ĝᵀα̂ to `out`, (m,).
    pub fn add_transposed(&self, factor: f64, alpha: &[f64], out: &mut [f64]) {
        for (row, alpha) in self.rows.iter().zip(alpha) {
            row.add_to(factor * alpha, out);
        }
    }

    /// α (r,) with Gᵀα = Ĝᵀα̂, of least norm.
    pub fn to_original(&self, alpha: &[f64], out: &mut [f64]) {
        let parts: Vec<f64> = match &self.scale {
            Scale::Singular(sigma) => alpha.iter().zip(sigma).map(|(a, s)| a / s).collect(),
            Scale::Factored(_, factor) => factor.backward(alpha.to_vec()),
        };
        out.fill(0.0);
        for (mode, part) in self.modes.iter().zip(parts) {
            mode.add_to(part, out);
        }
    }

    /// α̂ (k,) with Ĝᵀα̂ = Gᵀα.
    pub fn from_original(&self, alpha: &[f64], out: &mut [f64]) {
        let parts = self.modes.iter().map(|mode| mode.dot(alpha));
        match &self.scale {
            Scale::Singular(sigma) => {
                let scaled = parts.zip(sigma).map(|(part, s)| part * s);
                out.iter_mut().zip(scaled).for_each(|(out, a)| *out = a);
            }
            Scale::Factored(images, factor) => {
                out.copy_from_slice(&reduced(images, factor, parts.enumerate()));
            }
        }
    }

    /// The modes M = LĜ behind the rows, whose entries are few: k rows (m,). `None` where the rows are all there is.
    pub(crate) fn images(&self) -> Option<&[SparseVector]> {
        match &self.scale {
            Scale::Factored(images, _) => Some(images),
            Scale::Singular(_) => None,
        }
    }

    /// Amplitudes β of the images: Mᵀβ = Ĝᵀα̂.
    pub(crate) fn to_images(&self, alpha: &[f64]) -> Vec<f64> {
        match &self.scale {
            Scale::Factored(_, factor) => factor.backward(alpha.to_vec()),
            Scale::Singular(_) => alpha.to_vec(),
        }
    }

    /// α̂ from amplitudes of the images.
    pub(crate) fn amplitudes_of_images(&self, beta: Vec<f64>) -> Vec<f64> {
        match &self.scale {
            Scale::Factored(images, factor) => {
                reduced(images, factor, beta.into_iter().enumerate())
            }
            Scale::Singular(_) => beta,
        }
    }

    /// What is left of the balance of the images, L times that of the rows.
    pub(crate) fn rest_of_images(&self, rest: &[f64]) -> Vec<f64> {
        let Scale::Factored(images, _) = &self.scale else {
            return rest.to_vec();
        };
        let mut push = vec![0.0; images.first().map_or(0, SparseVector::len)];
        self.add_transposed(1.0, rest, &mut push);
        images.iter().map(|image| image.dot(&push)).collect()
    }

    /// Orthonormal α̂ whose pull vanishes on unknowns, on which `part` gives rows of forces; `None` where `grouped.rs` cannot
    /// tell.
    pub(crate) fn loose(
        &self,
        part: impl Fn(&[SparseVector]) -> Vec<SparseVector>,
    ) -> Option<Vec<Vec<f64>>> {
        let Scale::Factored(images, factor) = &self.scale else {
            return None;
        };
        let grouped = Grouped::of_rows(&part(images))?;
        let motions = grouped.split.uncontrolled.iter();
        let mut loose: Vec<Vec<f64>> = motions
            .map(|z| reduced(images, factor, z.entries()))
            .collect();
        // twice: the second pass removes what rounding left
        for _ in 0..2 {
            let rows = Mat::from_fn(loose.len(), self.rank(), |i, j| loose[i][j]);
            let mut gram = gram(&rows.transpose().to_owned());
            cholesky_in_place(&mut gram).ok()?;
            let mut orthonormal = rows;
            solve_lower_in_place(&gram, &mut orthonormal);
            for (i, z) in loose.iter_mut().enumerate() {
                z.iter_mut()
                    .enumerate()
                    .for_each(|(j, z)| *z = orthonormal[(i, j)]);
            }
        }
        Some(loose)
    }

    /// Number r of modes.
    pub fn original_len(&self) -> usize {
        self.original
    }
}

/// One singular triple of Gᵀ.
pub(super) struct Direction {
    /// z, (r,), unit.
    pub mode: Vec<f64>,
    /// Gᵀz = σ g, (m,).
    pub image: Vec<f64>,
    pub sigma: f64,
    pub controlled: bool,
}

/// The singular triples of Gᵀ, and the modes without an image behind them; `largest` is that of all |G|.
pub(super) fn singular_directions(modes: &Mat<f64>, largest: f64) -> Vec<Direction> {
    let (r, m) = (modes.nrows(), modes.ncols());
    let transposed = Mat::from_fn(m, r, |i, j| modes[(j, i)]);
    // a matrix that is not finite is an error of the problem, which its check tells
    let Ok(spectrum) = singular_value_decomposition(&transposed) else {
        return Vec::new();
    };
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

/// α̂ = Lᵀa = L⁻¹M(Mᵀa) of amplitudes a of the modes with the images M.
fn reduced(
    images: &[SparseVector],
    factor: &Cholesky,
    amplitudes: impl Iterator<Item = (usize, f64)>,
) -> Vec<f64> {
    let mut moved = vec![0.0; images.first().map_or(0, SparseVector::len)];
    amplitudes.for_each(|(mode, a)| images[mode].add_to(a, &mut moved));
    let parts: Vec<f64> = images.iter().map(|image| image.dot(&moved)).collect();
    factor.forward(&parts)
}

fn largest_of(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest: f64, x| largest.max(x.abs()))
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
        assert_eq!(split.controlled.len(), 2);
        assert_eq!(split.uncontrolled.len(), 1);
        for j in 0..24 {
            let image: f64 = (0..3)
                .map(|i| equilibrium.modes[(i, j)] * split.uncontrolled[0][i])
                .sum();
            assert!(image.abs() < 1e-15);
        }
        let expected = [0.3, -0.2, -1.0].map(|x: f64| x / 1.13f64.sqrt());
        let sign = -split.uncontrolled[0][2].signum();
        for (i, expected) in expected.iter().enumerate() {
            assert!((sign * split.uncontrolled[0][i] - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn orthonormal_form_has_the_same_solutions() {
        let equilibrium = ring(24);
        let balance = Balance::new(&equilibrium);
        assert_eq!(balance.rank(), 2);
        for (i, a) in balance.rows.iter().enumerate() {
            for (j, b) in balance.rows.iter().enumerate() {
                let product = a.dot(&b.to_dense());
                assert!((product - f64::from(i == j)).abs() < 1e-14);
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
        let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        assert!(square(&back) < square(&alpha));
    }
}
