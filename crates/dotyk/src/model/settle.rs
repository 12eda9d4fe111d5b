//! Rigid motions that the contact forces leave open: least norm of the displacement without penetration.

use crate::dual::least_norm_within;
use crate::linalg::SparseVector;
use crate::linalg::dense::dot;
use crate::model::bodies::LoadedBody;
use crate::model::floating::Floating;
use std::collections::BTreeMap;

/// What is left of a motion beside others, and what a motion of unit size closes of a gap: below this, rounding.
const NOTHING: f64 = 1e-12;

/// A rigid motion: nodal displacements of the bodies that it moves.
type Motion = BTreeMap<usize, Vec<f64>>;

/// Chooses the rigid amplitudes that the contact leaves open: least norm of the displacement without penetration.
///
/// The norm is that of the first `counted` parts: points of couples go with their sides. `free` lists combinations of modes, (r,) each; `elastic` and `rigid` are the two parts of the nodal displacements of all
/// bodies in their frames; `gaps` those of all multipliers. The last two are updated.
pub(crate) fn settle<const D: usize>(
    bodies: &[LoadedBody<D>],
    floating: &Floating,
    (free, counted): (&[SparseVector], usize),
    elastic: &[Vec<f64>],
    rigid: &mut [Vec<f64>],
    gaps: &mut [f64],
) {
    // orthonormalise the motions over all nodes, so that the least norm of amplitudes is that of displacements
    let mut motions: Vec<Motion> = Vec::new();
    for z in free {
        let mut motion = Motion::new();
        for (mode, a) in z.entries() {
            let (body, mode) = floating.modes[mode];
            let column = &bodies[body].system.modes[mode];
            add_to_body(&mut motion, body, a, column);
        }
        for other in &motions {
            let part = inner(&motion, other, counted);
            if part != 0.0 {
                for (&body, u) in other {
                    add_to_body(&mut motion, body, -part, u);
                }
            }
        }
        let size = inner(&motion, &motion, counted).sqrt();
        if size > NOTHING {
            motion.values_mut().flatten().for_each(|u| *u /= size);
            motions.push(motion);
        }
    }
    for motion in &motions {
        let along =
            |(body, u): (&usize, &Vec<f64>)| dot(u, &elastic[*body]) + dot(u, &rigid[*body]);
        let part: f64 = motion.range(..counted).map(along).sum();
        move_by(bodies, -part, motion, rigid, gaps);
    }
    // closing[i]: which motions close gap i, and by how much; no gap may become negative
    let mut closing: Vec<Vec<(usize, f64)>> = vec![Vec::new(); gaps.len()];
    for (j, motion) in motions.iter().enumerate() {
        let mut change: BTreeMap<usize, f64> = BTreeMap::new();
        for (&body, u) in motion {
            for (row, c) in bodies[body].rows.products(u) {
                *change.entry(row).or_default() += c;
            }
        }
        change
            .iter()
            .for_each(|(&row, &c)| closing[row].push((j, c)));
    }
    let touched: Vec<usize> = (0..gaps.len())
        .filter(|&i| closing[i].iter().any(|(_, c)| c.abs() > NOTHING))
        .collect();
    if touched.iter().all(|&i| gaps[i] >= 0.0) {
        return;
    }
    let bounds: Vec<f64> = touched.iter().map(|&i| gaps[i]).collect();
    let row = |&i: &usize| SparseVector::new(motions.len(), closing[i].iter().copied()).to_dense();
    let closing: Vec<Vec<f64>> = touched.iter().map(row).collect();
    if let Some(beta) = least_norm_within(&closing, &bounds, motions.len()) {
        for (b, motion) in beta.iter().zip(&motions) {
            move_by(bodies, *b, motion, rigid, gaps);
        }
    }
}

fn add_to_body(motion: &mut Motion, body: usize, factor: f64, u: &[f64]) {
    let own = motion.entry(body).or_insert_with(|| vec![0.0; u.len()]);
    own.iter_mut()
        .zip(u)
        .for_each(|(own, u)| *own += factor * u);
}

fn inner(a: &Motion, b: &Motion, counted: usize) -> f64 {
    let common = a
        .range(..counted)
        .filter_map(|(body, u)| Some((u, b.get(body)?)));
    common.map(|(u, v)| dot(u, v)).sum()
}

fn move_by<const D: usize>(
    bodies: &[LoadedBody<D>],
    factor: f64,
    motion: &Motion,
    displacement: &mut [Vec<f64>],
    gaps: &mut [f64],
) {
    for (&body, u) in motion {
        let own = displacement[body].iter_mut().zip(u);
        own.for_each(|(own, u)| *own += factor * u);
        for (row, c) in bodies[body].rows.products(u) {
            gaps[row] -= factor * c;
        }
    }
}
