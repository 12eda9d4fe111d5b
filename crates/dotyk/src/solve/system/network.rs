//! Balance of contact forces and of the glue of pieces at once.
//!
//! Forces x on the conditions of a linear problem and t of the glue move pieces and floating bodies rigidly unless they are balanced,
//! G(x, t) = ĝ, with the rows
//!
//! ```text
//!   pieces:  RᵀBᵀλ + Rᵀt = 0,        bodies:  Ĝλ = ê
//! ```
//!
//! The balance is restored by the forces of the network of rigid pieces and bodies that springs join, those of the glue of stiffness D
//! and those of the conditions of stiffness q, Q = (q, JᵀDJ). Motions, gaps and jumps alike, are measured after the rigid motion that makes
//! them least in the same weights:
//!
//! ```text
//!   (x, t) ← (x, t) − QGᵀT⁻¹(G(x, t) − ĝ),      r ← r − GᵀT⁻¹GQr,      T = GQGᵀ
//! ```
//!
//! Conditions that nothing yields to are stiffer than most others by some powers of ten, so that the rigid motions meet them.
//!
//! With springs of the glue alone, pieces in contact would never answer a gap that changes from piece to piece by moving: the number of
//! iterations would grow with the number of pieces in contact.
//!
//! Source: as the projectors of Z. Dostál, D. Horák, R. Kučera, Total FETI, Commun. Numer. Meth. Engng 22 (2006) 1155–1162.

use crate::dual::Glue;
use crate::linalg::{Cholesky, SparseVector, SymmetricMatrix, factor_scattered};
use crate::solve::norm;
use crate::solve::states::Unknown;
use crate::solve::system::Side;

/// How much stiffer than most others a condition is that nothing yields to, as where supports hold what it joins: no preconditioner
/// sees what it lacks, so that the rigid motions have to meet it. None is stiffer.
const RIGID: f64 = 1e6;

/// Motions are found twice where less than this part of gaps and jumps remains: what remains is rounding of the network, otherwise.
const CANCELLED: f64 = 1e-2;

/// The network of the conditions of a linear problem, for one side of its unknowns: their forces, or the rows of their conditions.
pub(super) struct Network<'s> {
    glue: &'s dyn Glue,
    /// Of each unknown: its rigid motions, those of pieces (N) first, behind them those of bodies (k).
    motions: Vec<Vec<(usize, f64)>>,
    /// q, (n,).
    stiff: Vec<f64>,
    pieces: usize,
    floating: usize,
    factor: Cholesky,
}

impl<'s> Network<'s> {
    /// Of the motions of all forces by those of pieces, and of the balance of bodies over the unknowns, without the directions `loose`
    /// that none of them feels; `softness` (m,) is that of the forces. `None` where some motion meets no resistance.
    pub fn new(
        glue: &'s dyn Glue,
        (unknowns, side): (&[Unknown], Side),
        (floating, loose): (&[SparseVector], &[Vec<f64>]),
        softness: &[f64],
    ) -> Option<Self> {
        let pieces = glue.modes();
        let of_forces = glue.motions();
        let of_pieces = unknowns.iter().map(|unknown| {
            let parts = side.of(unknown).iter().flat_map(|&(i, weight)| {
                let own = of_forces[i].iter();
                own.map(move |&(mode, motion)| (mode, weight * motion))
            });
            SparseVector::sum(pieces, parts.collect())
                .entries()
                .collect()
        });
        let mut motions: Vec<Vec<(usize, f64)>> = of_pieces.collect();
        for (one, row) in floating.iter().enumerate() {
            row.entries()
                .for_each(|(a, motion)| motions[a].push((pieces + one, motion)));
        }
        let yields = glue.yields();
        let soft = unknowns.iter().map(|unknown| {
            let own = side.of(unknown).iter().filter(|(i, _)| yields[*i]);
            let own: f64 = own.map(|&(i, weight)| weight * weight * softness[i]).sum();
            own + unknown.softness
        });
        let soft: Vec<f64> = soft.collect();
        let mut entries = glue.network();
        let of_glue = entries.iter().filter(|(i, j, _)| i == j);
        let of_glue = of_glue.fold(0.0, |s: f64, (_, _, value)| s.max(*value));
        let mut yielding: Vec<f64> = soft.iter().copied().filter(|s| *s > 0.0).collect();
        yielding.sort_unstable_by(f64::total_cmp);
        let typical = yielding.get(yielding.len() / 2).map(|soft| 1.0 / soft);
        let rigid = RIGID * typical.unwrap_or(of_glue);
        let stiff = soft.iter().map(|soft| (1.0 / soft).min(rigid));
        let stiff: Vec<f64> = stiff.collect();
        for (motions, stiff) in motions.iter().zip(&stiff) {
            for &(i, a) in motions {
                let below = motions.iter().filter(|(j, _)| *j <= i);
                entries.extend(below.map(|&(j, b)| (i, j, stiff * a * b)));
            }
        }
        let size = pieces + floating.len();
        let of_bodies = entries.iter().filter(|(i, j, _)| i == j && *i >= pieces);
        let largest = of_bodies.fold(0.0, |s: f64, (_, _, value)| s.max(*value));
        for z in loose {
            for (i, a) in z.iter().enumerate() {
                let below = z[..=i].iter().enumerate();
                entries.extend(below.map(|(j, b)| (pieces + i, pieces + j, largest * a * b)));
            }
        }
        let matrix = SymmetricMatrix::from_triplets(size, &entries);
        Some(Self {
            factor: factor_scattered(&matrix, pieces).ok()?,
            glue,
            motions,
            stiff,
            pieces,
            floating: floating.len(),
        })
    }

    /// The balance ĝ (N + k,) beside known forces (m,), of which bodies lack `floating` (k,).
    pub fn target(&self, known: &[f64], floating: &[f64]) -> Vec<f64> {
        let mut target = vec![0.0; self.pieces];
        for (force, motions) in known.iter().zip(self.glue.motions()) {
            if *force != 0.0 {
                motions
                    .iter()
                    .for_each(|&(mode, motion)| target[mode] -= force * motion);
            }
        }
        target.extend_from_slice(floating);
        target
    }

    /// The forces x and t with the balance ĝ (N + k,), to rounding, or without a resultant where it is not given.
    pub fn restore(&self, target: &[f64], x: &mut [f64], t: &mut [f64]) {
        self.approach(target, x, t);
        if !target.is_empty() {
            // the rounding of a large balance is that of the network, with its stiffest conditions
            self.approach(target, x, t);
        }
    }

    fn approach(&self, target: &[f64], x: &mut [f64], t: &mut [f64]) {
        let mut works = vec![0.0; self.pieces + self.floating];
        self.glue.works(t, &mut works[..self.pieces]);
        for (x, motions) in x.iter().zip(&self.motions) {
            motions
                .iter()
                .for_each(|&(mode, motion)| works[mode] += x * motion);
        }
        works
            .iter_mut()
            .zip(target)
            .for_each(|(work, target)| *work -= target);
        self.factor.solve(&mut works);
        works
            .iter_mut()
            .for_each(|amplitude| *amplitude = -*amplitude);
        for ((x, motions), stiff) in x.iter_mut().zip(&self.motions).zip(&self.stiff) {
            *x += stiff * moved(motions, &works);
        }
        self.glue.push(&works[..self.pieces], t);
    }

    /// Gaps r (n,) and jumps (g,) after the rigid motions that make them least; returns the amplitudes of bodies (k,).
    pub fn place(&self, r: &mut [f64], jumps: &mut [f64]) -> Vec<f64> {
        let before = norm(r).hypot(norm(jumps));
        let mut amplitudes = self.place_once(r, jumps);
        if norm(r).hypot(norm(jumps)) < CANCELLED * before {
            let rest = self.place_once(r, jumps);
            let both = amplitudes.iter_mut().zip(&rest);
            both.for_each(|(amplitude, rest)| *amplitude += rest);
        }
        amplitudes
    }

    fn place_once(&self, r: &mut [f64], jumps: &mut [f64]) -> Vec<f64> {
        let mut pulls = vec![0.0; self.pieces + self.floating];
        self.glue.pulls(jumps, &mut pulls[..self.pieces]);
        for ((r, motions), stiff) in r.iter().zip(&self.motions).zip(&self.stiff) {
            let pull = stiff * r;
            motions
                .iter()
                .for_each(|&(mode, motion)| pulls[mode] += pull * motion);
        }
        self.factor.solve(&mut pulls);
        pulls
            .iter_mut()
            .for_each(|amplitude| *amplitude = -*amplitude);
        for (r, motions) in r.iter_mut().zip(&self.motions) {
            *r += moved(motions, &pulls);
        }
        self.glue.part(&pulls[..self.pieces], jumps);
        pulls.split_off(self.pieces)
    }
}

/// The motion along one row.
fn moved(motions: &[(usize, f64)], amplitudes: &[f64]) -> f64 {
    let parts = motions
        .iter()
        .map(|&(mode, motion)| motion * amplitudes[mode]);
    parts.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::dot;

    /// Three pieces on a line, each of which may move along it: the first two share a dof, and so do the last two. The first and the
    /// last one are in contact, and there are conditions that no piece feels.
    struct Line {
        motions: Vec<Vec<(usize, f64)>>,
    }

    /// D of the copies of the two dofs, the piece of every copy, and how far its motion carries it.
    const STIFF: [f64; 4] = [1.0, 2.0, 3.0, 5.0];
    const OWNER: [usize; 4] = [0, 1, 1, 2];
    const CARRIED: [f64; 4] = [1.0, 1.0, 0.5, 1.0];

    fn line() -> Line {
        Line {
            motions: vec![vec![(0, 2.0), (2, -0.5)], Vec::new(), vec![(2, 1.5)]],
        }
    }

    fn jumps(u: &[f64]) -> Vec<f64> {
        let mut jumps = u.to_vec();
        for pair in [[0, 1], [2, 3]] {
            let sum: f64 = pair.iter().map(|&i| STIFF[i]).sum();
            let mean: f64 = pair.iter().map(|&i| STIFF[i] * u[i] / sum).sum();
            pair.iter().for_each(|&i| jumps[i] -= mean);
        }
        jumps
    }

    fn carried(amplitudes: &[f64]) -> Vec<f64> {
        (0..4).map(|i| CARRIED[i] * amplitudes[OWNER[i]]).collect()
    }

    impl Glue for Line {
        fn len(&self) -> usize {
            4
        }
        fn modes(&self) -> usize {
            3
        }
        fn motions(&self) -> &[Vec<(usize, f64)>] {
            &self.motions
        }
        fn yields(&self) -> &[bool] {
            &[true, false, true]
        }
        fn network(&self) -> Vec<(usize, usize, f64)> {
            let mut entries = Vec::new();
            for j in 0..3 {
                let mut unit = [0.0; 3];
                unit[j] = 1.0;
                let mut column = [0.0; 3];
                self.pulls(&carried(&unit), &mut column);
                entries.extend((0..3).map(|i| (i, j, column[i])));
            }
            entries
        }
        fn works(&self, t: &[f64], work: &mut [f64]) {
            work.fill(0.0);
            (0..4).for_each(|i| work[OWNER[i]] += CARRIED[i] * t[i]);
        }
        fn pulls(&self, u: &[f64], pull: &mut [f64]) {
            let forces = jumps(u).into_iter().zip(STIFF).map(|(u, d)| u * d);
            self.works(&forces.collect::<Vec<_>>(), pull);
        }
        fn push(&self, amplitudes: &[f64], t: &mut [f64]) {
            let apart = jumps(&carried(amplitudes));
            (0..4).for_each(|i| t[i] += STIFF[i] * apart[i]);
        }
        fn part(&self, amplitudes: &[f64], u: &mut [f64]) {
            let apart = jumps(&carried(amplitudes));
            (0..4).for_each(|i| u[i] += apart[i]);
        }
        fn respond(&self, _: (&[f64], &[f64]), _: bool, _: &mut [f64], _: &mut [f64]) {}
        fn keep(&self, _: &[f64], _: &[f64]) {}
        fn precondition(&self, _: &[f64], _: &[f64], _: &mut [f64], _: &mut [f64]) {}
    }

    fn unknowns() -> Vec<Unknown> {
        let unknown = |force: Vec<(usize, f64)>, row: Vec<(usize, f64)>| Unknown {
            force,
            row,
            pull: 0.0,
            softness: 0.0,
        };
        vec![
            unknown(vec![(0, 1.0), (2, 0.3)], vec![(0, 1.0)]),
            unknown(vec![(1, 1.0)], vec![(1, 1.0)]),
            unknown(vec![(2, 2.0)], vec![(2, 2.0)]),
        ]
    }

    /// Of a body that the first two conditions move, beside a direction that none of them feels.
    fn network<'s>(line: &'s Line, unknowns: &[Unknown], side: Side) -> Network<'s> {
        let floating = [[1.0, 2.0, 0.0], [0.0; 3]].map(|row| SparseVector::from_dense(&row));
        // what nothing yields to has some softness all the same
        let softness = [0.5, 7.0, 0.25];
        Network::new(
            line,
            (unknowns, side),
            (&floating, &[vec![0.0, 1.0]]),
            &softness,
        )
        .unwrap()
    }

    #[test]
    fn balance_is_restored() {
        let (line, unknowns) = (line(), unknowns());
        for side in [Side::Forces, Side::Rows] {
            let network = network(&line, &unknowns, side);
            let target = network.target(&[0.2, -0.3, 0.7], &[1.5, 0.0]);
            // the known forces push the pieces
            for (target, expected) in target.iter().zip([-0.4, 0.0, -0.95, 1.5, 0.0]) {
                assert!((target - expected).abs() < 1e-14);
            }
            let (mut x, mut t) = (vec![0.3, -1.0, 2.0], jumps(&[0.1, 0.4, -0.3, 0.2]));
            network.restore(&target, &mut x, &mut t);
            let mut works = [0.0; 3];
            line.works(&t, &mut works);
            for (unknown, x) in unknowns.iter().zip(&x) {
                for &(i, weight) in side.of(unknown) {
                    let own = line.motions[i].iter();
                    own.for_each(|&(mode, motion)| works[mode] += x * weight * motion);
                }
            }
            for (work, target) in works.iter().zip(&target) {
                assert!((work - target).abs() < 1e-12, "{works:?} {target:?}");
            }
            assert!((x[0] + 2.0 * x[1] - 1.5).abs() < 1e-12);
            // what is balanced stays
            let before = (x.clone(), t.clone());
            network.restore(&target, &mut x, &mut t);
            let apart = x.iter().zip(&before.0).chain(t.iter().zip(&before.1));
            apart.for_each(|(a, b)| assert!((a - b).abs() < 1e-12));
        }
    }

    #[test]
    fn conditions_that_nothing_yields_to_are_met_by_rigid_motions() {
        let (line, unknowns) = (line(), unknowns());
        let network = network(&line, &unknowns, Side::Rows);
        // nothing yields to the second one, and the body moves along it
        let (mut r, mut apart) = ([0.7, -0.2, 0.9], jumps(&[0.2, 0.6, -1.0, 0.3]));
        network.place(&mut r, &mut apart);
        assert!(r[1].abs() < 1e-5 && r[0].abs() > 0.1, "{r:?}");
    }

    #[test]
    fn gaps_of_rigid_motions_vanish_and_balanced_forces_do_not_see_them() {
        let (line, unknowns) = (line(), unknowns());
        let network = network(&line, &unknowns, Side::Rows);
        let amplitudes = [0.4, -1.3, 0.8, 2.0, 0.0];
        let mut r: Vec<f64> = network
            .motions
            .iter()
            .map(|motions| moved(motions, &amplitudes))
            .collect();
        let mut apart = vec![0.0; 4];
        line.part(&amplitudes[..3], &mut apart);
        let found = network.place(&mut r, &mut apart);
        assert!(r.iter().chain(&apart).all(|gap| gap.abs() < 1e-12));
        assert!((found[0] + 2.0).abs() < 1e-12 && found[1].abs() < 1e-12);
        // (Πz)·r = z·(Πᵀr)
        let (z, mut s) = ([0.3, 1.1, -0.6], jumps(&[1.0, 0.0, 0.5, -2.0]));
        // forces without a resultant
        s.iter_mut().zip(STIFF).for_each(|(s, stiff)| *s *= stiff);
        let (r, u) = ([0.7, -0.2, 0.9], jumps(&[0.2, 0.6, -1.0, 0.3]));
        let (mut balanced, mut of_glue) = (z.to_vec(), s.clone());
        network.restore(&[], &mut balanced, &mut of_glue);
        let (mut placed, mut parted) = (r.to_vec(), u.clone());
        network.place(&mut placed, &mut parted);
        let one = dot(&balanced, &r) + dot(&of_glue, &u);
        let other = dot(&z, &placed) + dot(&s, &parted);
        assert!((one - other).abs() < 1e-12, "{one} {other}");
    }
}
