//! Splits the rigid modes into those that the contact controls and those that it does not.
//!
//! Combinations z of modes with Gᵀz = 0 move no contact along its force: no contact force can hold them. Modes are expected
//! scaled to largest displacement 1.
//!
//! Few modes: the singular triples Gᵀ = Σ σⱼ gⱼ zⱼᵀ, with orthonormal gⱼ (m,) and zⱼ (r,). The eigenvalues of GGᵀ would lose
//! half of the digits.
//!
//! Modes of many bodies: G is sparse, because a contact does work on the modes of two bodies alone. Modes that lie side by
//! side in G and meet the same contacts are those of one body. Uncontrolled modes of a single body are found by a singular
//! value decomposition of its own rows. Let Z (k, r) be the orthonormal rest, local to bodies, and M = ZG. It remains to prove
//! that no combination of several bodies moves without work either. The proof is a Cholesky factorisation of MMᵀ − δ·I, which
//! exists only where all eigenvalues of MMᵀ exceed δ: singular values of G then lie between `far` times the largest and the
//! largest, and the coarse problem MMᵀ = LLᵀ may stand for M. Where the proof fails (bodies that several contacts hold only
//! together, say) G is decomposed as a whole. A row of n bodies that press each other has singular values down to 1/n, a tower whose
//! joints bear shear down to 1/n²: the proof succeeds for rows of ten thousand bodies and towers of some hundred.

use crate::dual::modes::transposed;
use crate::dual::{Mat, Modes};
use crate::linalg::dense::singular_value_decomposition;
use crate::linalg::{Cholesky, LinalgError, SparseVector, WeightedGram};
use std::collections::BTreeSet;
use std::ops::Range;

/// Fewest modes that are split body by body: with fewer the whole decomposition is fast.
pub(super) const MANY: usize = 96;

/// Fewest modes of which smaller singular values count as far from zero, as the decomposition of G as a whole takes minutes.
const VERY_MANY: usize = 500;

/// Singular values above this part of the largest are far from zero.
const FAR_FROM_ZERO: f64 = 1e-3;

/// The same of very many modes: the coarse problem MMᵀ is then good to rounding over FAR², 1e-6, and more steps are needed.
const FAR_OF_VERY_MANY: f64 = 1e-5;

/// Most modes that are taken together.
const TOGETHER: usize = 12;

/// Largest |Gᵀz| of an uncontrolled mode over the largest |G|.
const UNCONTROLLED: f64 = 1e-8;

/// Orthonormal basis of R^r, split by what the contact controls.
#[derive(Debug, Clone, Default)]
pub struct ModeSplit {
    /// k modes (r,) that some contact force does work on.
    pub controlled: Vec<SparseVector>,
    /// r − k modes (r,) that no contact force does work on.
    pub uncontrolled: Vec<SparseVector>,
}

/// Modes split by what the contact controls, and the coarse problem of those that it does.
#[derive(Debug, Clone, Default)]
pub(super) struct Split {
    /// The modes.
    pub modes: ModeSplit,
    /// σⱼ of each controlled mode, by which its row in M is divided; 1 where the modes are split body by body.
    pub sigma: Vec<f64>,
    /// M = Σ⁻¹ZG, k rows (m,).
    pub rows: Vec<SparseVector>,
    /// L of the coarse problem MMᵀ = LLᵀ; absent where the rows are orthonormal.
    pub coarse: Option<Cholesky>,
}

impl Split {
    /// Splits R^r into the modes that the contact controls and those with Gᵀz = 0. Shapes: `modes` (r, m).
    ///
    /// Errors: a singular value decomposition that does not converge; entries are not finite.
    pub fn new(modes: &Modes) -> Result<Self, LinalgError> {
        let many = modes.nrows() >= MANY;
        let by_body = many.then(|| Self::by_body(&modes.rows())).flatten();
        by_body.map_or_else(|| Self::as_a_whole(modes), Ok)
    }

    fn as_a_whole(modes: &Modes) -> Result<Self, LinalgError> {
        let mut split = Self::default();
        for direction in singular_directions(&modes.to_dense(), modes.largest())? {
            let mode = SparseVector::from_dense(&direction.mode);
            if direction.controlled {
                let mut row = SparseVector::from_dense(&direction.image);
                row.scale(1.0 / direction.sigma);
                split.rows.push(row);
                split.modes.controlled.push(mode);
                split.sigma.push(direction.sigma);
            } else {
                split.modes.uncontrolled.push(mode);
            }
        }
        Ok(split)
    }

    /// Splits the rows of G, each (m,), body by body; `None` where some bodies are held only together.
    pub fn by_body(rows: &[SparseVector]) -> Option<Self> {
        let far = match rows.len() >= VERY_MANY {
            true => FAR_OF_VERY_MANY,
            false => FAR_FROM_ZERO,
        };
        let (r, m) = (rows.len(), rows.first()?.len());
        let entries = rows.iter().flat_map(SparseVector::entries);
        let largest = entries.fold(0.0, |s: f64, (_, g)| s.max(g.abs()));
        let mut split = Self::default();
        for group in groups(rows) {
            let met = met(&rows[group.clone()]);
            let own = Mat::from_fn(group.len(), met.len(), |i, j| rows[group.start + i][met[j]]);
            for direction in singular_directions(&own, largest).ok()? {
                let parts = group.clone().zip(direction.mode);
                let mode = SparseVector::new(r, parts);
                if direction.controlled {
                    let parts = met.iter().copied().zip(direction.image);
                    split.rows.push(SparseVector::new(m, parts));
                    split.modes.controlled.push(mode);
                } else {
                    split.modes.uncontrolled.push(mode);
                }
            }
        }
        split.sigma = vec![1.0; split.rows.len()];
        let columns = transposed(&split.rows, m);
        let gram = WeightedGram::new(split.rows.len(), &columns).ok()?;
        let sizes = split.rows.iter().map(|row| row.norm().powi(2));
        let size = sizes.fold(0.0, f64::max);
        gram.factor(&columns, |_, _| 1.0, -far * far * size).ok()?;
        split.coarse = Some(gram.factor(&columns, |_, _| 1.0, 0.0).ok()?);
        Some(split)
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

/// The singular triples of Gᵀ, followed by the modes without an image; `largest` is the largest |G|.
fn singular_directions(modes: &Mat<f64>, largest: f64) -> Result<Vec<Direction>, LinalgError> {
    let (r, m) = (modes.nrows(), modes.ncols());
    let transposed = Mat::from_fn(m, r, |i, j| modes[(j, i)]);
    let spectrum = singular_value_decomposition(&transposed)?;
    let direction = |j: usize| {
        let sigma = spectrum.values.get(j).copied().unwrap_or(0.0);
        let image: Vec<f64> = match j < spectrum.left.ncols() {
            true => {
                let left = spectrum.left.col_as_slice(j).iter();
                left.map(|u| sigma * u).collect()
            }
            false => vec![0.0; m],
        };
        let moved = image.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
        Direction {
            mode: spectrum.right.col_as_slice(j).to_vec(),
            controlled: moved > UNCONTROLLED * largest,
            sigma,
            image,
        }
    };
    Ok((0..r).map(direction).collect())
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
pub(super) mod tests {
    use super::*;
    use crate::dual::Balance;

    /// A row of discs between two walls, two contact nodes at each joint, modes: along the row, across it, spin. Joints lie
    /// a little off the row, so that all are controlled but the spins.
    pub fn row_of_discs(n: usize) -> Mat<f64> {
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
        let split = Split::new(&modes.clone().into()).unwrap();
        assert!(split.coarse.is_some(), "the joints hold every disc");
        let sizes = (split.modes.controlled.len(), split.modes.uncontrolled.len());
        assert_eq!(sizes, (2 * n, n));
        let whole = singular_directions(&modes, 1.0).unwrap();
        assert_eq!(whole.iter().filter(|d| d.controlled).count(), 2 * n);
        for z in &split.modes.uncontrolled {
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
        let balance = Balance::new(modes.clone(), load.clone());
        let (k, m) = (balance.rank(), modes.ncols());
        let rows = balance.orthonormal_rows(balance.rows().to_vec());
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in rows.iter().enumerate() {
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
        balance.add_transposed(1.0, balance.target(), &mut forces);
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
        assert!(Split::new(&modes.into()).unwrap().coarse.is_none());
    }

    #[test]
    fn very_many_bodies_in_a_row_are_split_body_by_body_and_balanced() {
        // the smallest singular value of a row of n is about 1/n: below the limit of many bodies, above that of very many
        let n = 3000;
        let row = |i: usize| {
            let (disc, mode) = (i / 3, i % 3);
            let entries = [
                (0, 1.0, -0.2),
                (1, 1.0, 0.3),
                (2, -1.0, -0.2),
                (3, -1.0, 0.3),
            ];
            let entries = entries.map(|(node, sign, slope): (usize, f64, f64)| {
                (2 * disc + node, sign * [1.0, slope, 0.5 * slope][mode])
            });
            SparseVector::new(2 * (n + 1), entries)
        };
        let rows: Vec<SparseVector> = (0..3 * n).map(row).collect();
        let split = Split::by_body(&rows).expect("the walls hold the row");
        let sizes = (split.modes.controlled.len(), split.modes.uncontrolled.len());
        assert_eq!(sizes, (2 * n, n));
        let load = |i: usize| [(i as f64).sin(), 0.1, 0.05][i % 3];
        let load: Vec<f64> = (0..3 * n).map(load).collect();
        let balance = Balance::new(Modes::of_rows(&rows, 2 * (n + 1)), load.clone());
        let mut forces = vec![0.0; 2 * (n + 1)];
        balance.add_transposed(1.0, balance.target(), &mut forces);
        let size = forces.iter().fold(0.0f64, |s, f| s.max(f.abs()));
        for (row, load) in rows.iter().zip(&load) {
            let miss = (row.dot(&forces) - load).abs();
            // the certificate asks for 1e-10 of the largest force
            assert!(miss < 1e-11 * size, "{miss:e} of {size:e}");
        }
    }

    #[test]
    fn few_modes_are_split_into_those_with_an_image_and_those_without() {
        // two modes of three that do the same, of sizes far from each other
        let modes = Mat::from_fn(3, 4, |i, j| {
            [
                [1.0, -2.0, 0.5, 3.0],
                [2.0, -4.0, 1.0, 6.0],
                [0.0, 1e-3, 0.0, 0.0],
            ][i][j]
        });
        let split = Split::new(&modes.clone().into()).unwrap();
        assert!(split.coarse.is_none());
        let sizes = (split.modes.controlled.len(), split.modes.uncontrolled.len());
        assert_eq!(sizes, (2, 1));
        let pull =
            |z: &SparseVector, j: usize| -> f64 { (0..3).map(|i| z[i] * modes[(i, j)]).sum() };
        let parts = split
            .modes
            .controlled
            .iter()
            .zip(&split.rows)
            .zip(&split.sigma);
        for ((z, row), sigma) in parts {
            assert!((z.norm() - 1.0).abs() < 1e-14 && (row.norm() - 1.0).abs() < 1e-14);
            for j in 0..4 {
                // rounding of the largest singular value, about 8
                assert!((pull(z, j) - sigma * row[j]).abs() < 1e-14);
            }
        }
        let z = &split.modes.uncontrolled[0];
        assert!((z.norm() - 1.0).abs() < 1e-14);
        assert!((0..4).all(|j| pull(z, j).abs() < 1e-14));
    }

    #[test]
    fn modes_are_controlled_beyond_rounding_of_the_largest() {
        for largest in [1e-3, 1.0, 1e3] {
            let of = |part: f64| {
                let rows = [
                    SparseVector::new(2, [(0, largest)]),
                    SparseVector::new(2, [(1, part * largest)]),
                ];
                Split::new(&Modes::of_rows(&rows, 2)).unwrap().modes
            };
            assert_eq!(of(1.1 * UNCONTROLLED).uncontrolled.len(), 0);
            assert_eq!(of(0.9 * UNCONTROLLED).uncontrolled.len(), 1);
        }
        let still = Modes::of_rows(&[SparseVector::new(2, [])], 2);
        assert_eq!(Split::new(&still).unwrap().modes.uncontrolled.len(), 1);
    }

    #[test]
    fn more_modes_than_contacts_leave_some_uncontrolled() {
        let modes = Modes::from(Mat::from_fn(3, 1, |i, _| [3.0, 0.0, 4.0][i]));
        let split = Split::new(&modes).unwrap();
        assert_eq!((split.rows.len(), split.modes.uncontrolled.len()), (1, 2));
        assert!((split.sigma[0] - 5.0).abs() < 1e-14);
        for z in &split.modes.uncontrolled {
            assert!(z.dot(&[3.0, 0.0, 4.0]).abs() < 1e-14);
        }
    }

    #[test]
    fn bodies_that_push_almost_the_same_are_not_proved_to_be_apart() {
        // MMᵀ of these two rows has the eigenvalues 2ε² and 2 + 2ε², and the proof takes 2ε² > FAR²(1 + 2ε²)
        let proved = |part: f64, size: f64| {
            let entries = |columns: [usize; 3], parts: [f64; 3]| {
                let entries = columns.into_iter().zip(parts.map(|part| size * part));
                SparseVector::new(5, entries)
            };
            let rows = [
                entries([0, 1, 2], [part, part, 1.0]),
                entries([2, 3, 4], [1.0, part, part]),
            ];
            Split::by_body(&rows).is_some()
        };
        let limit = FAR_FROM_ZERO / 2f64.sqrt();
        // whatever the unit of forces is
        for size in [1e-2, 1.0, 1e2] {
            assert!(proved(1.02 * limit, size) && !proved(0.98 * limit, size));
        }
        assert!(Split::by_body(&[]).is_none());
    }

    #[test]
    fn rows_beside_each_other_that_meet_the_same_contacts_are_those_of_a_body() {
        let row = |columns: &[usize]| SparseVector::new(20, columns.iter().map(|&j| (j, 1.0)));
        // half of the columns of the shorter row in common make it the same body, a third does not
        assert!(meet_alike(&row(&[0, 1, 2, 3]), &row(&[3, 9])));
        assert!(meet_alike(&row(&[3, 9]), &row(&[0, 1, 2, 3])));
        assert!(!meet_alike(&row(&[0, 1, 2, 3]), &row(&[3, 8, 9])));
        assert!(meet_alike(&row(&[0]), &row(&[])));
        let rows = [
            row(&[0, 1]),
            row(&[0, 1]),
            row(&[5, 6]),
            row(&[6, 7]),
            row(&[9]),
        ];
        assert_eq!(groups(&rows[..3]), [0..2, 2..3]);
        assert_eq!(groups(&rows), [0..2, 2..4, 4..5]);
        assert_eq!(met(&rows[1..4]), [0, 1, 5, 6, 7]);
        // at most TOGETHER
        let same = vec![row(&[4]); TOGETHER + 3];
        assert_eq!(groups(&same), [0..TOGETHER, TOGETHER..TOGETHER + 3]);
    }

    #[test]
    fn modes_are_taken_body_by_body_where_they_are_many() {
        let of = |discs: usize| Split::new(&row_of_discs(discs).into()).unwrap();
        assert!(of(MANY / 3).coarse.is_some());
        assert!(of(MANY / 3 - 1).coarse.is_none());
        // then rows are not scaled, and z works on them as it is
        assert_eq!(of(MANY / 3).sigma, vec![1.0; 2 * (MANY / 3)]);
        let (split, modes) = (of(MANY / 3), row_of_discs(MANY / 3));
        for (z, row) in split.modes.controlled.iter().zip(&split.rows) {
            assert!((z.norm() - 1.0).abs() < 1e-14);
            for j in 0..modes.ncols() {
                assert!((z.dot(modes.col_as_slice(j)) - row[j]).abs() < 1e-14);
            }
        }
    }
}
