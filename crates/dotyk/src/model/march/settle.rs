//! Rigid motions that the contact forces leave open: least norm of the displacement without penetration.

use crate::linalg::SparseVector;
use crate::linalg::dense::dot;
use crate::linalg::signed::least_norm_within;
use crate::model::system::bodies::LoadedBody;
use crate::model::system::floating::Floating;
use std::collections::{BTreeMap, BTreeSet};

/// A change of a gap by a motion of unit size below this is rounding.
const NO_CHANGE: f64 = 1e-12;

/// A motion is dependent on others if at most this part of it is orthogonal to them. Lists of motions overlap where a body that is
/// uncontrolled in one direction has no contact. The remainder is rounding, and scaled to unit size it would strain the body.
const DEPENDENT: f64 = 1e-9;

/// Nodal displacements of the bodies that a rigid motion moves.
type Moved = BTreeMap<usize, Vec<f64>>;

/// A rigid motion.
#[derive(Default)]
struct Motion {
    /// Amplitudes of the modes, by their index.
    amplitudes: BTreeMap<usize, f64>,
    moved: Moved,
}

impl Motion {
    /// A combination (r,) of modes.
    fn new<const D: usize>(
        bodies: &[LoadedBody<D>],
        floating: &Floating,
        combination: &SparseVector,
    ) -> Self {
        let mut motion = Self::default();
        for (mode, a) in combination.entries() {
            let (body, own) = floating.modes[mode];
            motion.amplitudes.insert(mode, a);
            add_to_body(&mut motion.moved, body, a, &bodies[body].system.modes[own]);
        }
        motion
    }

    fn add(&mut self, factor: f64, other: &Self) {
        for (&mode, a) in &other.amplitudes {
            *self.amplitudes.entry(mode).or_insert(0.0) += factor * a;
        }
        for (&body, u) in &other.moved {
            add_to_body(&mut self.moved, body, factor, u);
        }
    }

    fn scale(&mut self, factor: f64) {
        let amplitudes = self.amplitudes.values_mut();
        let all = amplitudes.chain(self.moved.values_mut().flatten());
        all.for_each(|value| *value *= factor);
    }
}

/// Chooses the rigid amplitudes that the contact leaves open: least norm of the displacement without penetration. Returns the
/// change of the amplitudes of all modes, (r,).
///
/// The previous amplitudes may be as large as the bodies, and the remaining motion tiny. Subtracted from the displacement of every
/// node they would leave a different rounding at each node, which strains the body. So the change must be added to amplitudes.
///
/// The norm is that of the first `counted` parts: points of couples follow their sides. `free` lists combinations of modes, (r,)
/// each; `elastic` and `rigid` are the two parts of the nodal displacements of all bodies in their frames; `gaps` (m,) are those
/// that must not become negative.
pub(crate) fn settle<const D: usize>(
    bodies: &[LoadedBody<D>],
    floating: &Floating,
    (free, counted): (&[SparseVector], usize),
    [elastic, rigid]: [&[Vec<f64>]; 2],
    gaps: &[Option<f64>],
) -> SparseVector {
    let all = free.iter().map(|z| Motion::new(bodies, floating, z));
    let motions = orthonormal(all, counted);
    let mut settled = Motion::default();
    for motion in &motions {
        let along =
            |(body, u): (&usize, &Vec<f64>)| dot(u, &elastic[*body]) + dot(u, &rigid[*body]);
        let part: f64 = motion.moved.range(..counted).map(along).sum();
        settled.add(-part, motion);
    }
    // closing of each gap by each motion
    let changes: Vec<BTreeMap<usize, f64>> = motions.iter().map(|m| closed_by(bodies, m)).collect();
    let entries = changes.iter().flatten();
    let beyond_rounding = entries.filter(|(_, change)| change.abs() > NO_CHANGE);
    let touched: BTreeSet<usize> = beyond_rounding.map(|(&row, _)| row).collect();
    let closed = closed_by(bodies, &settled);
    let limited = |&row: &usize| Some((row, gaps[row]? - closed.get(&row).unwrap_or(&0.0)));
    let (rows, bounds): (Vec<usize>, Vec<f64>) = touched.iter().filter_map(limited).unzip();
    if bounds.iter().any(|&gap| gap < 0.0) {
        let of_row = |row: &usize| {
            let each = changes.iter();
            each.map(|change| change.get(row).copied().unwrap_or(0.0))
                .collect()
        };
        let closing: Vec<Vec<f64>> = rows.iter().map(of_row).collect();
        // where rounding leaves no admissible place, no body moves
        let Some(least) = least_norm_within(&closing, &bounds, motions.len()) else {
            return SparseVector::new(floating.modes.len(), []);
        };
        for (b, motion) in least.iter().zip(&motions) {
            settled.add(*b, motion);
        }
    }
    SparseVector::new(floating.modes.len(), settled.amplitudes)
}

/// Motions that span the same, orthonormal over all nodes of the first `counted` parts: the least norm of their amplitudes is
/// that of displacements.
fn orthonormal(all: impl Iterator<Item = Motion>, counted: usize) -> Vec<Motion> {
    let size = |motion: &Motion| inner(&motion.moved, &motion.moved, counted).sqrt();
    let mut motions: Vec<Motion> = Vec::new();
    for mut motion in all {
        let whole = size(&motion);
        // twice: the second pass removes rounding
        for other in motions.iter().chain(&motions) {
            let part = inner(&motion.moved, &other.moved, counted);
            if part != 0.0 {
                motion.add(-part, other);
            }
        }
        let left = size(&motion);
        if left > DEPENDENT * whole {
            motion.scale(1.0 / left);
            motions.push(motion);
        }
    }
    motions
}

/// Change of the gaps of rows by a motion, closing positive.
fn closed_by<const D: usize>(bodies: &[LoadedBody<D>], motion: &Motion) -> BTreeMap<usize, f64> {
    let mut closed = BTreeMap::new();
    for (&body, u) in &motion.moved {
        for (row, c) in bodies[body].rows.products(u) {
            *closed.entry(row).or_insert(0.0) += c;
        }
    }
    closed
}

fn add_to_body(moved: &mut Moved, body: usize, factor: f64, u: &[f64]) {
    let own = moved.entry(body).or_insert_with(|| vec![0.0; u.len()]);
    own.iter_mut()
        .zip(u)
        .for_each(|(own, u)| *own += factor * u);
}

fn inner(a: &Moved, b: &Moved, counted: usize) -> f64 {
    let common = a
        .range(..counted)
        .filter_map(|(body, u)| Some((u, b.get(body)?)));
    common.map(|(u, v)| dot(u, v)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(body: usize, amplitudes: [f64; 2], moved: [f64; 3]) -> Motion {
        Motion {
            amplitudes: amplitudes.into_iter().enumerate().collect(),
            moved: BTreeMap::from([(body, moved.to_vec())]),
        }
    }

    #[test]
    fn what_rounding_leaves_of_a_motion_that_others_make_is_none() {
        let rounding = 3e-11;
        let all = [
            motion(0, [1.0, 0.0], [1e3, 2e3, 0.0]),
            motion(0, [0.0, 1.0], [0.0, 1e3, 1e3]),
            motion(0, [1.0, 1.0], [1e3, 3e3, 1e3 + rounding]),
            motion(1, [0.0, 0.0], [0.0; 3]),
        ];
        let motions = orthonormal(all.into_iter(), 2);
        assert_eq!(motions.len(), 2);
        for (k, own) in motions.iter().enumerate() {
            for (l, other) in motions.iter().enumerate() {
                let expected = f64::from(k == l);
                assert!((inner(&own.moved, &other.moved, 2) - expected).abs() < 1e-15);
            }
            // a motion of unit size has the amplitudes that make it
            let [a, b] = [0, 1].map(|k| own.amplitudes[&k]);
            let made = [1e3 * a, 2e3 * a + 1e3 * b, 1e3 * b];
            for (made, u) in made.iter().zip(&own.moved[&0]) {
                assert!((made - u).abs() < 1e-15);
            }
        }
    }
}
