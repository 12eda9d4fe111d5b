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
    /// Z, Σ, M and L, or the error of the decomposition.
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

    /// The same with the rows marked that balance moments (r,). A mode is scaled to largest displacement 1, so the row of a rotation
    /// is its moment over the largest distance from its axis: a force.
    pub fn with_moments(self, moments: Vec<bool>) -> Self {
        Self { moments, ..self }
    }

    /// Replaces the load by e (r,).
    pub fn set_load(&mut self, load: Vec<f64>) {
        // `DualProblem::check` reports a load of another length
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

    /// The modes that contact controls, and those that it does not.
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

    /// M, the work of contact forces on the controlled modes (Ĝ = L⁻¹M): k rows (m,), sparse where bodies are many.
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

    /// v ← L⁻¹v, (k,): from a product with M to the product with Ĝ.
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

    /// Work of a unit force `i` on the controlled modes, Ĝᵢ (k,).
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

    /// The imbalance in the rows of M: L times the one of Ĝ.
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

    /// Orthonormal α̂ with Ĝᵀα̂ = 0 on the unknowns of these `rows` of M; `None` where bodies are few, or where some are held
    /// only together.
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
    use crate::dual::split::tests::row_of_discs;

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
        // The λ of least norm that balances the reduced rows balances the original ones, too, redundant rows included.
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

    /// Row of discs, so long that it is decomposed body by body.
    fn many() -> Balance {
        let modes = row_of_discs(40);
        let load = (0..modes.nrows()).map(|i| (0.3 * i as f64).sin()).collect();
        Balance::new(modes, load)
    }

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|i| (1.7 * i as f64).cos()).collect()
    }

    fn assert_near(a: &[f64], b: &[f64], tolerance: f64) {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() < tolerance, "{a} {b}");
        }
    }

    #[test]
    fn nothing_floats_without_modes() {
        let none = Balance::none(5);
        assert_eq!(
            (none.rank(), none.modes().ncols(), none.load().len()),
            (0, 5, 0)
        );
        assert!(none.is_orthonormal() && none.target().is_empty() && none.moments().is_empty());
        assert_eq!(none.columns().len(), 5);
    }

    #[test]
    fn a_new_load_is_another_target() {
        for mut balance in [ring(24), many()] {
            let (m, k) = (balance.modes().ncols(), balance.rank());
            let forces = wave(m);
            let load = balance.modes().product(&forces);
            balance.set_load(load.clone());
            assert_eq!(balance.load(), load);
            // forces that carry the load leave nothing
            let mut rest = vec![9.0; k];
            balance.imbalance(&forces, &mut rest);
            assert_near(&rest, &vec![0.0; k], 1e-12);
            let mut image = vec![9.0; k];
            balance.apply(&forces, &mut image);
            assert_near(&image, balance.target(), 1e-12);
            balance.set_load(vec![0.0; load.len()]);
            balance.imbalance(&forces, &mut rest);
            assert_near(&rest, &image, 1e-15);
            // a load of another length has no target
            balance.set_load(vec![1.0; load.len() + 1]);
            assert_eq!(balance.target(), vec![0.0; k]);
        }
    }

    #[test]
    fn rows_are_forces_unless_they_are_told_to_be_moments() {
        assert_eq!(ring(8).moments(), [false; 3]);
        let told = ring(8).with_moments(vec![false, false, true]);
        assert_eq!(told.moments(), [false, false, true]);
        assert_eq!(told.load(), ring(8).load());
    }

    #[test]
    fn modes_that_are_no_numbers_have_no_split() {
        let broken = Balance::new(Mat::from_fn(2, 3, |_, _| f64::NAN), vec![0.0; 2]);
        assert!(broken.split().is_err());
        assert_eq!(broken.rank(), 0);
        assert!(ring(8).split().is_ok());
    }

    #[test]
    fn columns_are_what_unit_forces_do() {
        for (balance, orthonormal) in [(ring(24), true), (many(), false)] {
            assert_eq!(balance.is_orthonormal(), orthonormal);
            let (m, k) = (balance.modes().ncols(), balance.rank());
            let rows = balance.orthonormal_rows(balance.rows().to_vec());
            for i in 0..m {
                let mut unit = vec![0.0; m];
                unit[i] = 1.0;
                let mut image = vec![9.0; k];
                balance.apply(&unit, &mut image);
                assert_near(&balance.column(i), &image, 1e-14);
                let entries: Vec<f64> = rows.iter().map(|row| row[i]).collect();
                assert_near(&entries, &image, 1e-14);
                let sparse: Vec<f64> = balance.rows().iter().map(|row| row[i]).collect();
                assert_eq!(balance.columns()[i].to_dense(), sparse);
                // and of a pull the other way round
                let mut pull = vec![0.0; m];
                balance.add_transposed(1.0, &wave(k), &mut pull);
                let product: f64 = image.iter().zip(wave(k)).map(|(a, b)| a * b).sum();
                assert!((pull[i] - product).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn pulls_are_added_with_their_factor() {
        for balance in [ring(24), many()] {
            let (m, k) = (balance.modes().ncols(), balance.rank());
            let mut once = vec![0.0; m];
            balance.add_transposed(1.0, &wave(k), &mut once);
            let mut more = wave(m);
            balance.add_transposed(-3.0, &wave(k), &mut more);
            let expected: Vec<f64> = wave(m)
                .iter()
                .zip(&once)
                .map(|(a, b)| a - 3.0 * b)
                .collect();
            assert_near(&more, &expected, 1e-13);
        }
    }

    #[test]
    fn amplitudes_of_the_rows_and_of_their_orthonormal_form_are_told_from_each_other() {
        for balance in [ring(24), many()] {
            let (m, k) = (balance.modes().ncols(), balance.rank());
            let alpha = wave(k);
            let beta = balance.to_rows(&alpha);
            assert_near(&balance.from_rows(beta.clone()), &alpha, 1e-12);
            // Mᵀβ = Ĝᵀα̂
            let (mut with_rows, mut pull) = (vec![0.0; m], vec![0.0; m]);
            for (row, beta) in balance.rows().iter().zip(&beta) {
                row.add_to(*beta, &mut with_rows);
            }
            balance.add_transposed(1.0, &alpha, &mut pull);
            assert_near(&with_rows, &pull, 1e-12);
            if balance.is_orthonormal() {
                assert_eq!(
                    (&beta, balance.rest_of_rows(&alpha)),
                    (&alpha, alpha.clone())
                );
            }
            // what is left of Ĝλ = ê is that of Mλ, turned
            let mut rest = balance.rest_of_rows(&alpha);
            balance.orthonormal(&mut rest);
            assert_near(&rest, &alpha, 1e-12);
            let mut image = vec![0.0; k];
            balance.apply(&wave(m), &mut image);
            let products: Vec<f64> = balance.rows().iter().map(|row| row.dot(&wave(m))).collect();
            assert_near(&balance.rest_of_rows(&image), &products, 1e-12);
        }
    }

    #[test]
    fn motions_that_some_contacts_do_not_hold_are_orthonormal_and_pull_at_none_of_them() {
        let balance = many();
        // the first twenty joints hold twenty discs; the other twenty discs may move along and across the row
        let seen = 40;
        let of = |row: &SparseVector| SparseVector::new(seen, row.entries().filter(|e| e.0 < seen));
        let rows: Vec<SparseVector> = balance.rows().iter().map(of).collect();
        let loose = balance.loose(&rows).unwrap();
        assert_eq!(loose.len(), 40);
        for (i, a) in loose.iter().enumerate() {
            for (j, b) in loose.iter().enumerate() {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                assert!((product - f64::from(i == j)).abs() < 1e-14, "{i} {j}");
            }
            let mut pull = vec![0.0; balance.modes().ncols()];
            balance.add_transposed(1.0, a, &mut pull);
            assert!(pull[..seen].iter().all(|pull| pull.abs() < 1e-13));
        }
        let all = balance.loose(balance.rows());
        assert!(
            all.is_some_and(|loose| loose.is_empty()),
            "the walls hold all"
        );
        assert!(ring(24).loose(ring(24).rows()).is_none(), "few bodies");
    }
}
