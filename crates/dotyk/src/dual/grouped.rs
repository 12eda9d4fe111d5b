//! The balance of many bodies: G is sparse, because a contact does work on the modes of two bodies alone.
//!
//! Modes that lie side by side in G and meet the same contacts are those of one body. What a body by itself has no control
//! of is found by a singular value decomposition of its own rows. Let Z (k, r) be the orthonormal rest, local to bodies,
//! and M = ZG. That no combination of several bodies moves without work either is *proved* by a Cholesky factorisation of
//! MMᵀ − δ·I, which exists only where all eigenvalues of MMᵀ exceed δ: singular values of G then reach from 1 to [`FAR`]
//! times the largest, and MMᵀ = LLᵀ may stand for M. Where the proof fails (bodies that several contacts hold only
//! together, say) there is no answer, and the caller decomposes G as a whole.
//!
//! A row of bodies that press each other has singular values down to 1/(its length): rows of many hundred bodies are
//! proved.

use crate::dual::balance::singular_directions;
use crate::dual::modes::transposed;
use crate::dual::{Mat, ModeSplit, Modes};
use crate::linalg::{Cholesky, SparseVector, WeightedGram};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// Fewest modes that are looked at in this way: below, the whole decomposition takes no time.
pub(super) const MANY: usize = 96;

/// Singular values above this part of the largest are far from zero.
const FAR: f64 = 1e-3;

/// Most modes that are taken together.
const TOGETHER: usize = 12;

/// Modes of many bodies, each split by itself.
pub(super) struct Grouped {
    pub split: ModeSplit,
    /// M, the k images (m,) of the controlled modes.
    pub images: Vec<SparseVector>,
    /// L.
    pub factor: Cholesky,
    /// M by columns, m vectors (k,).
    columns: Vec<SparseVector>,
}

impl Grouped {
    /// Splits the modes G (r, m); `None` where there are few, or some are almost dependent.
    pub fn new(modes: &Modes) -> Option<Self> {
        if modes.nrows() < MANY {
            return None;
        }
        Self::of_rows(&modes.rows())
    }

    /// The same for the rows of G, each (m,).
    pub fn of_rows(rows: &[SparseVector]) -> Option<Self> {
        let (r, m) = (rows.len(), rows.first()?.len());
        let entries = rows.iter().flat_map(SparseVector::entries);
        let largest = entries.fold(0.0, |s: f64, (_, g)| s.max(g.abs()));
        let mut split = ModeSplit {
            controlled: Vec::new(),
            uncontrolled: Vec::new(),
        };
        let mut images = Vec::new();
        for group in groups(rows) {
            let met = met(&rows[group.clone()]);
            let own = Mat::from_fn(group.len(), met.len(), |i, j| rows[group.start + i][met[j]]);
            for direction in singular_directions(&own, largest) {
                let parts = group.clone().zip(direction.mode);
                let mode = SparseVector::new(r, parts);
                if direction.controlled {
                    let parts = met.iter().copied().zip(direction.image);
                    images.push(SparseVector::new(m, parts));
                    split.controlled.push(mode);
                } else {
                    split.uncontrolled.push(mode);
                }
            }
        }
        let columns = transposed(&images, m);
        let gram = WeightedGram::new(images.len(), &columns).ok()?;
        let sizes = images.iter().map(|image| image.norm().powi(2));
        let size = sizes.fold(0.0, f64::max);
        gram.factor(&columns, |_| 1.0, -FAR * FAR * size).ok()?;
        let factor = gram.factor(&columns, |_| 1.0, 0.0).ok()?;
        Some(Self {
            split,
            images,
            factor,
            columns,
        })
    }

    /// Ĝ = L⁻¹M, k orthonormal rows (m,).
    pub fn orthonormal_rows(&self) -> Vec<SparseVector> {
        let forward = |column: &SparseVector| {
            SparseVector::from_dense(&self.factor.forward(&column.to_dense()))
        };
        let columns: Vec<SparseVector> = self.columns.par_iter().map(forward).collect();
        transposed(&columns, self.images.len())
    }
}

/// Neighbouring rows that share most of their columns.
fn groups(rows: &[SparseVector]) -> Vec<Range<usize>> {
    let mut groups: Vec<Range<usize>> = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        match groups.last_mut() {
            Some(group) if group.len() < TOGETHER && meet_alike(&rows[i - 1], row) => {
                group.end += 1
            }
            _ => groups.push(i..i + 1),
        }
    }
    groups
}

/// At least half of the columns of the shorter row are among those of the other.
fn meet_alike(a: &SparseVector, b: &SparseVector) -> bool {
    let columns = |v: &SparseVector| v.entries().map(|e| e.0).collect::<BTreeSet<usize>>();
    let (a, b) = (columns(a), columns(b));
    2 * a.intersection(&b).count() >= a.len().min(b.len())
}

/// Columns in which some of the rows have an entry, ascending.
fn met(rows: &[SparseVector]) -> Vec<usize> {
    let columns = rows.iter().flat_map(SparseVector::entries).map(|e| e.0);
    let columns: BTreeSet<usize> = columns.collect();
    columns.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Balance, Equilibrium};

    /// A row of discs between two walls, two contact nodes at each joint, modes: along the row, across it, spin. Joints lie
    /// a little off the row, so that all are controlled but the spins.
    fn row_of_discs(n: usize) -> Mat<f64> {
        Mat::from_fn(3 * n, 2 * (n + 1), |i, j| {
            let (disc, mode, joint, node) = (i / 3, i % 3, j / 2, j % 2);
            let slope = [-0.2, 0.3][node];
            let normal: f64 = [1.0, slope, 0.5 * slope][mode];
            match joint {
                _ if joint == disc => normal,
                _ if joint == disc + 1 => -normal,
                _ => 0.0,
            }
        })
    }

    #[test]
    fn many_bodies_split_as_one_decomposition_does() {
        let n = 40;
        let modes = row_of_discs(n);
        let Some(grouped) = Grouped::new(&modes.clone().into()) else {
            panic!("the joints hold every disc");
        };
        let sizes = (
            grouped.split.controlled.len(),
            grouped.split.uncontrolled.len(),
        );
        assert_eq!(sizes, (2 * n, n));
        let whole = singular_directions(&modes, 1.0);
        assert_eq!(whole.iter().filter(|d| d.controlled).count(), 2 * n);
        for z in &grouped.split.uncontrolled {
            for d in whole.iter().filter(|d| d.controlled) {
                assert!(z.dot(&d.mode).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn balance_of_many_bodies_has_orthonormal_rows_and_the_same_amplitudes() {
        let modes = row_of_discs(40);
        let load: Vec<f64> = (0..120)
            .map(|i| [(i as f64).sin(), 0.1, 0.05][i % 3])
            .collect();
        let balance = Balance::new(&Equilibrium::new(modes.clone(), load.clone()));
        let (k, m) = (balance.rank(), modes.ncols());
        for (i, a) in balance.rows.iter().enumerate() {
            for (j, b) in balance.rows.iter().enumerate() {
                let product = a.dot(&b.to_dense());
                assert!(
                    (product - f64::from(i == j)).abs() < 1e-11,
                    "{i} {j} {product}"
                );
            }
        }
        let alpha: Vec<f64> = (0..120).map(|i| (0.7 * i as f64).cos()).collect();
        let (mut reduced, mut back) = (vec![0.0; k], vec![0.0; 120]);
        balance.from_original(&alpha, &mut reduced);
        balance.to_original(&reduced, &mut back);
        let mut image = vec![0.0; m];
        balance.add_transposed(1.0, &reduced, &mut image);
        for (j, image) in image.iter().enumerate() {
            let of = |alpha: &[f64]| -> f64 { (0..120).map(|i| modes[(i, j)] * alpha[i]).sum() };
            assert!((of(&alpha) - image).abs() < 1e-12);
            assert!((of(&back) - image).abs() < 1e-12);
        }
        let mut forces = vec![0.0; m];
        balance.add_transposed(1.0, &balance.load, &mut forces);
        for i in 0..120 {
            let sum: f64 = (0..m).map(|j| modes[(i, j)] * forces[j]).sum();
            // the spins carry half of what goes across
            assert!((sum - load[i]).abs() < 1e-11, "{i}: {sum}");
        }
    }

    #[test]
    fn modes_that_are_controlled_only_together_are_left_to_the_whole_decomposition() {
        // without the walls the row moves as a whole
        let mut modes = row_of_discs(40);
        for joint in [0, 1, 80, 81] {
            modes.col_as_slice_mut(joint).fill(0.0);
        }
        assert!(Grouped::new(&modes.into()).is_none());
    }
}
