//! Gλ = e, the balance of the floating bodies, and its coordinates: Ĝλ = ê, k orthonormal rows without the modes that no
//! contact controls.
//!
//! `split.rs` gives M = Σ⁻¹ZG, the work of contact forces on the controlled modes, and the coarse problem MMᵀ = LLᵀ. The
//! solvers work with Ĝ = L⁻¹M, whose rows are orthonormal, so that dependent modes need no care there: Ĝ is never formed,
//! a product with it is one with the sparse M and one with the sparse L⁻¹. Amplitudes come back as α = ZᵀΣ⁻¹L⁻ᵀα̂, with no
//! part along the uncontrolled modes (least norm). Of few modes M is orthonormal by itself, and L = I.

use crate::dual::modes::transposed;
use crate::dual::split::Split;
use crate::dual::{AdmissibleSet, Mat, ModeSplit, Modes, Projector};
use crate::linalg::dense::{cholesky_in_place, gram, solve_lower_in_place};
use crate::linalg::{LinalgError, SparseVector};
use rayon::prelude::*;

/// Gλ = e; r = 0 when nothing floats. Amplitudes α̂ belong to Ĝ: Gᵀα = Ĝᵀα̂.
#[derive(Debug, Clone)]
pub struct Balance {
    /// G, (r, m).
    modes: Modes,
    /// e, (r,).
    load: Vec<f64>,
    moments: Vec<bool>,
    /// Z, Σ, M and L, or why there are none.
    split: Split,
    failure: Option<LinalgError>,
    /// M by columns, m vectors (k,).
    columns: Vec<SparseVector>,
    /// ê, (k,).
    target: Vec<f64>,
}

impl Balance {
    /// The balance of modes G (r, m) and loads e (r,), all rows taken as forces.
    pub fn new(modes: impl Into<Modes>, load: Vec<f64>) -> Self {
        let modes = modes.into();
        let (split, failure) = match Split::new(&modes) {
            Ok(split) => (split, None),
            Err(error) => (Split::default(), Some(error)),
        };
        let mut balance = Self {
            columns: transposed(&split.rows, modes.ncols()),
            moments: vec![false; load.len()],
            load: Vec::new(),
            target: Vec::new(),
            modes,
            split,
            failure,
        };
        balance.set_load(load);
        balance
    }

    /// Nothing floats: r = 0 with `m` contact forces.
    pub fn none(m: usize) -> Self {
        Self::new(Modes::of_rows(&[], m), Vec::new())
    }

    /// The same, told which rows balance moments (r,). A mode is scaled to largest displacement 1, so the row of a rotation
    /// is its moment over the largest distance from its axis: a force.
    pub fn with_moments(self, moments: Vec<bool>) -> Self {
        Self { moments, ..self }
    }

    /// Replaces the load by e (r,).
    pub fn set_load(&mut self, load: Vec<f64>) {
        // a load of another length is an error of the problem, which its check tells
        let fits = load.len() == self.modes.nrows();
        let modes = self.split.modes.controlled.iter().zip(&self.split.sigma);
        let part =
            |(z, sigma): (&SparseVector, &f64)| if fits { z.dot(&load) / sigma } else { 0.0 };
        let mut parts: Vec<f64> = modes.map(part).collect();
        self.orthonormal(&mut parts);
        (self.target, self.load) = (parts, load);
    }

    /// G, (r, m).
    pub fn modes(&self) -> &Modes {
        &self.modes
    }

    /// e, (r,): work of the loads on each mode.
    pub fn load(&self) -> &[f64] {
        &self.load
    }

    /// Which rows balance moments, (r,).
    pub fn moments(&self) -> &[bool] {
        &self.moments
    }

    /// What contact controls of the modes, and what not.
    ///
    /// # Errors
    /// [`LinalgError::NoConvergence`] of a singular value decomposition: entries are not finite.
    pub fn split(&self) -> Result<&ModeSplit, LinalgError> {
        self.failure.map_or(Ok(&self.split.modes), Err)
    }

    /// ê, (k,).
    pub fn target(&self) -> &[f64] {
        &self.target
    }

    /// Projections onto `admissible` ∩ {Gλ = e}.
    pub fn projector<'a>(&'a self, admissible: &'a AdmissibleSet) -> Projector<'a> {
        Projector::new(admissible, self)
    }

    /// Number k of controlled modes.
    pub fn rank(&self) -> usize {
        self.split.rows.len()
    }

    /// M, what contact forces do on the modes behind Ĝ = L⁻¹M: k rows (m,), of few entries where bodies are many.
    pub fn rows(&self) -> &[SparseVector] {
        &self.split.rows
    }

    /// M by columns, m vectors (k,).
    pub fn columns(&self) -> &[SparseVector] {
        &self.columns
    }

    /// Whether L = I, so that M is Ĝ.
    pub fn is_orthonormal(&self) -> bool {
        self.split.coarse.is_none()
    }

    /// v ← L⁻¹v, (k,): from what M gives to what Ĝ gives.
    pub fn orthonormal(&self, v: &mut [f64]) {
        if let Some(coarse) = &self.split.coarse {
            v.copy_from_slice(&coarse.forward(v));
        }
    }

    /// Ĝ on some unknowns, from the rows of M there.
    pub fn orthonormal_rows(&self, rows: Vec<SparseVector>) -> Vec<SparseVector> {
        let Some(coarse) = &self.split.coarse else {
            return rows;
        };
        let columns = transposed(&rows, rows.first().map_or(0, SparseVector::len));
        let forward =
            |column: &SparseVector| SparseVector::from_dense(&coarse.forward(&column.to_dense()));
        let columns: Vec<SparseVector> = columns.par_iter().map(forward).collect();
        transposed(&columns, rows.len())
    }

    /// What a unit force `i` does on the modes, Ĝᵢ (k,).
    pub fn column(&self, i: usize) -> Vec<f64> {
        let mut column = self.columns[i].to_dense();
        self.orthonormal(&mut column);
        column
    }

    /// Ĝλ − ê, (k,), into `out`.
    pub fn imbalance(&self, lambda: &[f64], out: &mut [f64]) {
        self.apply(lambda, out);
        out.iter_mut()
            .zip(&self.target)
            .for_each(|(out, load)| *out -= load);
    }

    /// Ĝv, (k,), into `out`.
    pub fn apply(&self, v: &[f64], out: &mut [f64]) {
        for (out, row) in out.iter_mut().zip(&self.split.rows) {
            *out = row.dot(v);
        }
        self.orthonormal(out);
    }

    /// Adds factor · Ĝᵀα̂ to `out`, (m,).
    pub fn add_transposed(&self, factor: f64, alpha: &[f64], out: &mut [f64]) {
        let add = |amplitudes: &[f64], out: &mut [f64]| {
            for (row, amplitude) in self.split.rows.iter().zip(amplitudes) {
                row.add_to(factor * amplitude, out);
            }
        };
        match self.is_orthonormal() {
            true => add(alpha, out),
            false => add(&self.to_rows(alpha), out),
        }
    }

    /// Amplitudes β = L⁻ᵀα̂ of the rows of M: Mᵀβ = Ĝᵀα̂.
    pub fn to_rows(&self, alpha: &[f64]) -> Vec<f64> {
        match &self.split.coarse {
            Some(coarse) => coarse.backward(alpha.to_vec()),
            None => alpha.to_vec(),
        }
    }

    /// α̂ = Lᵀβ = L⁻¹M(Mᵀβ) from amplitudes of the rows of M.
    pub fn from_rows(&self, beta: Vec<f64>) -> Vec<f64> {
        if self.is_orthonormal() {
            return beta;
        }
        let mut moved = vec![0.0; self.columns.len()];
        for (row, beta) in self.split.rows.iter().zip(&beta) {
            row.add_to(*beta, &mut moved);
        }
        let mut alpha = vec![0.0; self.rank()];
        self.apply(&moved, &mut alpha);
        alpha
    }

    /// What is left of the balance of the rows of M, L times that of Ĝ.
    pub fn rest_of_rows(&self, rest: &[f64]) -> Vec<f64> {
        if self.is_orthonormal() {
            return rest.to_vec();
        }
        let mut push = vec![0.0; self.columns.len()];
        self.add_transposed(1.0, rest, &mut push);
        self.split.rows.iter().map(|row| row.dot(&push)).collect()
    }

    /// α (r,) with Gᵀα = Ĝᵀα̂, of least norm.
    pub fn to_original(&self, alpha: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let modes = self.split.modes.controlled.iter().zip(&self.split.sigma);
        let mut add = |beta: &[f64]| {
            for ((mode, sigma), beta) in modes.clone().zip(beta) {
                mode.add_to(beta / sigma, out);
            }
        };
        match self.is_orthonormal() {
            true => add(alpha),
            false => add(&self.to_rows(alpha)),
        }
    }

    /// α̂ (k,) with Ĝᵀα̂ = Gᵀα.
    pub fn from_original(&self, alpha: &[f64], out: &mut [f64]) {
        let modes = self.split.modes.controlled.iter().zip(&self.split.sigma);
        let beta = modes.map(|(mode, sigma)| mode.dot(alpha) * sigma);
        out.copy_from_slice(&self.from_rows(beta.collect()));
    }

    /// Orthonormal α̂ whose pull vanishes on unknowns, from the rows of M there; `None` where bodies are few, or some are
    /// held only together.
    pub(crate) fn loose(&self, rows: &[SparseVector]) -> Option<Vec<Vec<f64>>> {
        if self.is_orthonormal() {
            return None;
        }
        let split = Split::by_body(rows)?;
        let motions = split.modes.uncontrolled.iter();
        let mut loose: Vec<Vec<f64>> = motions.map(|z| self.from_rows(z.to_dense())).collect();
        // twice: the second pass removes what rounding left
        for _ in 0..2 {
            let rows = Mat::from_fn(loose.len(), self.rank(), |i, j| loose[i][j]);
            let mut gram = gram(&rows.transpose().to_owned());
            cholesky_in_place(&mut gram).ok()?;
            let mut orthonormal = rows;
            solve_lower_in_place(&gram, &mut orthonormal);
            for (i, z) in loose.iter_mut().enumerate() {
                let row = (0..z.len()).map(|j| orthonormal[(i, j)]);
                z.iter_mut().zip(row).for_each(|(z, value)| *z = value);
            }
        }
        Some(loose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normals of a full ring: translations are controlled, the spin is not.
    fn ring(m: usize) -> Balance {
        let angle = |j: usize| std::f64::consts::TAU * j as f64 / m as f64;
        Balance::new(
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
        let balance = ring(24);
        let split = balance.split().unwrap();
        assert_eq!(split.controlled.len(), 2);
        assert_eq!(split.uncontrolled.len(), 1);
        for j in 0..24 {
            let image: f64 = (0..3)
                .map(|i| balance.modes()[(i, j)] * split.uncontrolled[0][i])
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
        let balance = ring(24);
        assert_eq!(balance.rank(), 2);
        for (i, a) in balance.rows().iter().enumerate() {
            for (j, b) in balance.rows().iter().enumerate() {
                let product = a.dot(&b.to_dense());
                assert!((product - f64::from(i == j)).abs() < 1e-14);
            }
        }
        // λ of least norm that balances the reduced rows balances the original ones, the redundant included.
        let mut lambda = vec![0.0; 24];
        balance.add_transposed(1.0, balance.target(), &mut lambda);
        for i in 0..3 {
            let sum: f64 = (0..24).map(|j| balance.modes()[(i, j)] * lambda[j]).sum();
            assert!((sum - balance.load()[i]).abs() < 1e-14);
        }
    }

    #[test]
    fn amplitudes_keep_their_contact_displacements() {
        let balance = ring(24);
        let alpha = [0.4, -1.1, 0.7];
        let (mut reduced, mut back) = ([0.0; 2], [0.0; 3]);
        balance.from_original(&alpha, &mut reduced);
        balance.to_original(&reduced, &mut back);
        let mut image = vec![0.0; 24];
        balance.add_transposed(1.0, &reduced, &mut image);
        for (j, image) in image.iter().enumerate() {
            let of =
                |alpha: &[f64]| -> f64 { (0..3).map(|i| balance.modes()[(i, j)] * alpha[i]).sum() };
            assert!((of(&alpha) - image).abs() < 1e-14);
            assert!((of(&back) - image).abs() < 1e-14);
        }
        let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        assert!(square(&back) < square(&alpha));
    }
}
