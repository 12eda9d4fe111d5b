//! u = A⁻¹f from a matrix that is the sum of the matrices of pieces, which float and are glued by forces (total FETI).
//!
//! With u_p the displacements of piece p and t_p the forces of the glue on its border,
//!
//! ```text
//!   A = Σ E_pᵀK_pE_p,      K_p u_p = f_p + t_p,      Σ t_p = 0 at every dof of the border,      u_p alike there
//! ```
//!
//! so that u_p = K_p⁺(f_p + t_p) + R_pα_p with R_pᵀ(f_p + t_p) = 0, and t minimises 1/2 tᵀK⁺t + tᵀK⁺f over the balanced forces of the
//! glue. Forces and displacements are *broken* vectors, with one entry for each copy of a dof of the border. With the stiffnesses D of
//! the copies as weights, those of one cell, the jump of a displacement and the forces without a resultant are
//!
//! ```text
//!   (Ju)_p = u_p − Σ D_q u_q / Σ D_q,             DJ = JᵀD
//! ```
//!
//! and no multiplier of a pair of copies is needed. Held dofs are glued, too, to what does not move: their mean is zero, and the glue
//! may have a resultant there. So every piece floats, and none is nearly loose on the few nodes of a support that it has. The balance is kept by the rigid amplitudes β of the coarse problem
//! T = RᵀDJR: t + DJRβ with Tβ = −Rᵀ(f + t), and displacements are compared after the rigid motions that make their jumps least in
//! the same weights, α = −T⁻¹RᵀDJu. In between stand conjugate gradients with the Dirichlet preconditioner JᵀSJ, where S_p is the
//! stiffness of a piece seen from its border: their number grows slowly with the number of cells across a piece and with the number of
//! pieces, and not with jumps of the stiffness from piece to piece.
//!
//! The displacements of the copies are averaged in the end, and the rest of the forces is solved for again: A u = f to rounding.
//!
//! Of several processes that work side by side each has the matrices of some pieces, one behind the other. All have the broken
//! vectors and the coarse problem, and iterate alike; S_p and S_p⁺ are the parts that are shared out, and joined after each product.
//!
//! Sources: Z. Dostál, D. Horák, R. Kučera, Total FETI, Commun. Numer. Meth. Engng 22 (2006) 1155–1162; D. Rixen, C. Farhat, A simple and
//! efficient extension of a class of substructure based preconditioners, Int. J. Numer. Meth. Engng 44 (1999) 489–516.

use crate::host::{Team, in_order, largest_share, share};
use crate::linalg::condensed::{Bordered, Factors, Kind, Outline, Piece};
use crate::linalg::dense::{dot, least_squares, norm};
use crate::linalg::{
    Cholesky, LinalgError, Mat, SparseMatrix, SymmetricMatrix, agreed, factor_scattered,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// Residuals of the iterations of a pass fall by this factor; what averaging the copies leaves is solved for in the next pass.
const REDUCTION: f64 = 1e-9;

/// The same for corrections.
const CORRECTED: f64 = 1e-3;

/// Most passes: the second one reaches rounding.
const PASSES: usize = 4;

/// Forces that remain below this part of the terms whose sum they are, in the norm over all dofs, are rounding.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Most iterations of a pass.
const ITERATIONS: usize = 500;

/// Loads that differ by less than this part of their squares count as one.
const ALIKE: f64 = 1e-14;

/// Places of broken vectors that a thread takes at a time.
const PLACES: usize = 4096;

/// A piece with its place among the others.
struct Placed {
    /// The dofs of the whole that it has.
    dofs: Vec<u32>,
    /// R on the border, columns (border,).
    rigid: Vec<Vec<f64>>,
    /// The places of its border and of its rigid motions among those of all pieces.
    border: Range<usize>,
    modes: Range<usize>,
}

/// The pieces of a whole, analysed.
///
/// Broken vectors have an entry for each copy of the dofs of the border, piece by piece. Dofs that forces from outside meet belong to
/// the border, too; those that only one piece has have no jumps, and so no forces of the glue.
pub(crate) struct Divided {
    team: Arc<dyn Team>,
    /// The pieces of this process, those of `own_pieces`.
    own: Vec<Bordered>,
    own_pieces: Range<usize>,
    /// Entries of all K_p and of all factors, and operations of the factorisations.
    stiffness: usize,
    stored: usize,
    operations: f64,
    /// Dofs that take part.
    free: Vec<bool>,
    /// K_ii, (dofs,).
    diagonal: Vec<f64>,
    pieces: Vec<Placed>,
    /// Number of rigid motions of all pieces, and T, by which the springs of the glue resist them.
    modes: usize,
    network: SymmetricMatrix,
    /// The dof of every place of broken vectors, and its number among the dofs of the border.
    dofs: Vec<u32>,
    group: Vec<u32>,
    /// The places of the i-th dof of the border are those of `copies` from `shares[i]` on.
    copies: Vec<u32>,
    shares: Vec<usize>,
    /// D, and its part of the sum over all copies; none of held dofs.
    stiff: Vec<f64>,
    part: Vec<f64>,
    /// Places that forces from outside meet.
    touched: Vec<u32>,
}

impl Divided {
    /// The pieces of nodes with D dofs of a whole, of which the dofs with `free` take part; forces from outside meet those that are
    /// `touched`. Of all pieces those are given that this process has, [`share`] of them.
    ///
    /// Errors: those of the analyses, with dofs of the whole; pieces whose rigid motions cannot be found.
    pub fn new<const D: usize>(
        free: Vec<bool>,
        touched: &[bool],
        pieces: Vec<Piece>,
        team: Arc<dyn Team>,
    ) -> Result<Self, LinalgError> {
        let (owners, diagonal) = of_dofs(free.len(), &pieces, &*team);
        let kind = |dof: u32| Kind {
            shared: !free[dof as usize] || owners[dof as usize] > 1,
            touched: touched[dof as usize],
        };
        let bordered = pieces.into_par_iter();
        let bordered = bordered.map(|piece| Bordered::new::<D>(piece, &kind));
        let bordered = in_order(bordered);
        let (own, outlines): (Vec<_>, Vec<_>) = agreed(&*team, bordered)?.into_iter().unzip();
        let coded = outlines.iter().flat_map(Outline::coded).collect();
        drop(outlines);
        let outlines = Outline::decoded(&team.join("outlines of pieces", coded));
        let stiffness = outlines.iter().map(|piece| piece.stiffness).sum();
        let stored = outlines.iter().map(|piece| piece.stored).sum();
        let operations = outlines.iter().map(|piece| piece.operations).sum();
        let stiff: Vec<f64> = outlines
            .iter()
            .flat_map(|piece| piece.stiff.iter().copied())
            .collect();
        let dofs: Vec<u32> = outlines
            .iter()
            .flat_map(|piece| piece.border.iter().copied())
            .collect();
        let (mut border, mut modes) = (0, 0);
        let placed = outlines.into_iter().map(|piece| {
            let (first, mode) = (border, modes);
            border += piece.border.len();
            modes += piece.rigid.len();
            Placed {
                dofs: piece.dofs,
                rigid: piece.rigid,
                border: first..border,
                modes: mode..modes,
            }
        });
        let pieces: Vec<Placed> = placed.collect();
        let (copies, shares) = copies(&dofs);
        let (mut group, mut part) = (vec![0; border], vec![0.0; border]);
        for (i, share) in shares.windows(2).enumerate() {
            let copies = &copies[share[0]..share[1]];
            let sum: f64 = copies.iter().map(|&i| stiff[i as usize]).sum();
            for &place in copies {
                group[place as usize] = i as u32;
                // what is held has the displacement of none of its copies
                if free[dofs[place as usize] as usize] {
                    part[place as usize] = stiff[place as usize] / sum;
                }
            }
        }
        let is_met = |dof: usize| free[dof] && touched[dof];
        let met = (0..border as u32).filter(|&place| is_met(dofs[place as usize] as usize));
        let mut divided = Self {
            own_pieces: share(&*team, pieces.len()),
            team,
            own,
            stiffness,
            stored,
            operations,
            touched: met.collect(),
            free,
            diagonal,
            pieces,
            modes,
            network: SymmetricMatrix::from_triplets(0, &[]),
            dofs,
            group,
            copies,
            shares,
            stiff,
            part,
        };
        divided.network = divided.resisted();
        Ok(divided)
    }

    /// Number of pieces.
    pub fn pieces(&self) -> usize {
        self.pieces.len()
    }

    /// Number of their rigid motions: the size of the coarse problem.
    pub fn coarse(&self) -> usize {
        self.modes
    }

    /// Entries of the factors of all processes.
    pub fn stored(&self) -> usize {
        self.stored
    }

    /// Entries of the stiffnesses of pieces, and of their factors, that a process has at most.
    pub fn in_process(&self) -> [usize; 2] {
        let share = largest_share(&*self.team, self.pieces.len());
        [self.stiffness, self.stored].map(|all| (share * all as f64) as usize)
    }

    /// Operations of all factorisations.
    pub fn operations(&self) -> f64 {
        self.operations
    }

    /// Whether these are the dofs that forces from outside meet.
    pub fn is_touched_at(&self, touched: &[bool]) -> bool {
        let mut known = vec![false; self.free.len()];
        for &place in &self.touched {
            known[self.dofs[place as usize] as usize] = true;
        }
        let free = touched.iter().zip(&self.free);
        free.map(|(touched, free)| *touched && *free).eq(known)
    }

    /// Factors all pieces, on the threads there are.
    ///
    /// Errors: those of the factors, with dofs of the whole; a whole that is not definite.
    pub fn glue(self: &Arc<Self>) -> Result<Glued, LinalgError> {
        let factors = self.own.par_iter().map(Bordered::factor);
        Ok(Glued {
            factors: agreed(&*self.team, in_order(factors))?,
            coarse: self.coarse_problem()?,
            whole: Arc::clone(self),
            memory: Mutex::default(),
            iterations: AtomicUsize::new(0),
        })
    }
}

/// How many pieces have each dof of a whole, and K_ii, of those that the processes have.
fn of_dofs(dofs: usize, own: &[Piece], team: &dyn Team) -> (Vec<u8>, Vec<f64>) {
    let (mut owners, mut diagonal) = (vec![0u8; dofs], vec![0.0; dofs]);
    let numbers = own
        .iter()
        .flat_map(|piece| piece.dofs.iter().map(|&dof| f64::from(dof)));
    let numbers = team.join("dofs of pieces", numbers.collect());
    let values = own.iter().flat_map(|piece| piece.stiffness.diagonal());
    let values = team.join("their stiffness", values.collect());
    for (&dof, value) in numbers.iter().zip(&values) {
        let dof = dof as usize;
        owners[dof] = owners[dof].saturating_add(1);
        diagonal[dof] += value;
    }
    (owners, diagonal)
}

/// The places of every dof of the border, and where those of each dof begin.
fn copies(dofs: &[u32]) -> (Vec<u32>, Vec<usize>) {
    let mut places: Vec<u32> = (0..dofs.len() as u32).collect();
    places.sort_by_key(|&place| dofs[place as usize]);
    let mut shares = vec![0];
    for group in places.chunk_by(|&a, &b| dofs[a as usize] == dofs[b as usize]) {
        shares.push(shares[shares.len() - 1] + group.len());
    }
    (places, shares)
}

/// A whole, factored by its pieces.
pub(crate) struct Glued {
    whole: Arc<Divided>,
    factors: Vec<Factors>,
    /// Factor of T; `None` where no piece floats.
    coarse: Option<Cholesky>,
    memory: Mutex<Memory>,
    iterations: AtomicUsize,
}

/// Loads with the forces of the glue that belong to them.
#[derive(Default)]
struct Memory {
    /// Of the last two solutions, and of the last contact forces.
    solved: [Option<(Vec<f64>, Vec<f64>)>; 2],
    kept: Option<(Vec<f64>, Vec<f64>)>,
}

impl Glued {
    /// Solutions with every piece so far.
    pub fn iterations(&self) -> usize {
        self.iterations.load(Ordering::Relaxed)
    }

    /// u = A⁻¹f in place, over all dofs; those that are not free are ignored on entry and zero on return. The forces of the glue of
    /// the last solutions are remembered, and give a start.
    pub fn solve(&self, f: &mut [f64]) {
        let start = self.remembered(f);
        let (u, t) = self.solved(f, start);
        self.remember(f.to_vec(), t);
        f.copy_from_slice(&u);
    }

    /// The same without memory, so that it does not depend on other solutions at the same time.
    pub fn solve_afresh(&self, f: &mut [f64]) {
        let (u, _) = self.solved(f, None);
        f.copy_from_slice(&u);
    }

    /// u ≈ A⁻¹f in place, to three digits.
    pub fn correct(&self, f: &mut [f64]) {
        let both = f.iter_mut().zip(&self.whole.free);
        both.filter(|(_, free)| !**free).for_each(|(f, _)| *f = 0.0);
        let (u, _) = self.displacements(f, None, CORRECTED);
        f.copy_from_slice(&u);
    }

    /// u = A⁻¹f, and the forces of the glue, from a start of these.
    fn solved(&self, f: &mut [f64], start: Option<Vec<f64>>) -> (Vec<f64>, Vec<f64>) {
        let both = f.iter_mut().zip(&self.whole.free);
        both.filter(|(_, free)| !**free).for_each(|(f, _)| *f = 0.0);
        let (mut u, mut t) = self.displacements(f, start, REDUCTION);
        let (mut rest, terms) = self.whole.rest(f, &u);
        let mut size = norm(&rest);
        for _ in 1..PASSES {
            let enough = ROUNDING * terms;
            if size.is_nan() || size <= enough {
                break;
            }
            let reduction = (0.1 * enough / size).max(REDUCTION);
            let (change, forces) = self.displacements(&rest, None, reduction);
            let next: Vec<f64> = u.iter().zip(&change).map(|(u, c)| u + c).collect();
            let (left, _) = self.whole.rest(f, &next);
            // what this pass has changed was rounding
            if norm(&left).is_nan() || norm(&left) >= size {
                break;
            }
            size = norm(&left);
            (u, rest) = (next, left);
            t.iter_mut().zip(&forces).for_each(|(t, force)| *t += force);
        }
        (u, t)
    }

    /// Keeps the forces of the glue of a load.
    pub fn keep(&self, f: Vec<f64>, t: Vec<f64>) {
        if let Ok(mut memory) = self.memory.lock() {
            memory.kept = Some((f, t));
        }
    }

    fn remember(&self, f: Vec<f64>, t: Vec<f64>) {
        if let Ok(mut memory) = self.memory.lock() {
            memory.solved.swap(0, 1);
            memory.solved[0] = Some((f, t));
        }
    }

    /// The forces of the glue of the combination of known loads that is nearest to a load.
    fn remembered(&self, f: &[f64]) -> Option<Vec<f64>> {
        let memory = self.memory.lock().ok()?;
        let known: Vec<_> = memory
            .solved
            .iter()
            .chain([&memory.kept])
            .flatten()
            .collect();
        let count = known.len();
        let products = Mat::from_fn(count, count, |i, j| dot(&known[i].0, &known[j].0));
        let right = Mat::from_fn(count, 1, |i, _| dot(&known[i].0, f));
        if count == 0 {
            return None;
        }
        let parts = least_squares(&products, &right, ALIKE).ok()?;
        let mut t = vec![0.0; self.border()];
        for (i, (_, forces)) in known.iter().enumerate() {
            let part = parts[(i, 0)];
            t.iter_mut()
                .zip(forces)
                .for_each(|(t, force)| *t += part * force);
        }
        Some(t)
    }

    /// The displacements under loads f, copies averaged, and the forces of the glue, whose jumps are reduced by a factor from those
    /// without a start.
    pub fn displacements(
        &self,
        f: &[f64],
        start: Option<Vec<f64>>,
        reduction: f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let loads = self.condensed(f);
        let mut t = vec![0.0; self.border()];
        let (mut u, mut z) = self.begin(&loads, &mut t);
        let goal = reduction * reduction * dot(&u, &z);
        if let Some(start) = start {
            t = start;
            (u, z) = self.begin(&loads, &mut t);
        }
        let (mut direction, mut slope) = (z.clone(), dot(&u, &z));
        for _ in 0..ITERATIONS {
            if slope.is_nan() || slope <= goal {
                break;
            }
            let mut moved = direction.clone();
            self.respond(&mut moved);
            let curvature = dot(&direction, &moved);
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let step = slope / curvature;
            for i in 0..t.len() {
                t[i] -= step * direction[i];
                u[i] -= step * moved[i];
            }
            self.place(&mut u);
            let z = self.pull(&u);
            let next = dot(&u, &z);
            for (direction, z) in direction.iter_mut().zip(&z) {
                *direction = z + next / slope * *direction;
            }
            slope = next;
        }
        let mut u = sum_of(&loads, &t);
        self.respond(&mut u);
        self.place(&mut u);
        (self.inside(f, &self.whole.mean(&u)), t)
    }

    /// Balances t beside condensed loads; the displacements under both, and the forces that their jumps pull with.
    fn begin(&self, loads: &[f64], t: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        self.balance(loads, t);
        let mut u = sum_of(loads, t);
        self.respond(&mut u);
        self.place(&mut u);
        let z = self.pull(&u);
        (u, z)
    }

    /// Number of forces of the glue.
    pub fn border(&self) -> usize {
        self.whole.dofs.len()
    }

    /// The displacements of the touched dofs, (dofs,) of the whole with zeros elsewhere, of copies the mean, and the jumps under loads
    /// f on touched dofs and balanced forces of the glue t, pieces `placed` such that the jumps are least, or somewhere.
    pub fn move_under(&self, f: &[f64], t: &[f64], placed: bool) -> (Vec<f64>, Vec<f64>) {
        let mut u = sum_of(&self.whole.on_touched(f), t);
        self.respond(&mut u);
        if placed {
            self.place(&mut u);
        }
        let mut moved = vec![0.0; f.len()];
        for &place in &self.whole.touched {
            let place = place as usize;
            moved[self.whole.dofs[place] as usize] += self.whole.part[place] * u[place];
        }
        self.whole.jumps(&mut u);
        (moved, u)
    }

    /// Forces of the touched dofs (dofs,) and of the glue that would cause displacements v (dofs,) of the former, and jumps, if the
    /// borders had no other stiffness.
    pub fn forces_of(&self, v: &[f64], jumps: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut moved = jumps.to_vec();
        self.whole.jumps(&mut moved);
        for &place in &self.whole.touched {
            moved[place as usize] += v[self.whole.dofs[place as usize] as usize];
        }
        self.resist(&mut moved);
        let mut forces = vec![0.0; v.len()];
        for &place in &self.whole.touched {
            forces[self.whole.dofs[place as usize] as usize] += moved[place as usize];
        }
        self.whole.without_resultant(&mut moved);
        (forces, moved)
    }

    /// u ← S⁺u of all pieces.
    fn respond(&self, u: &mut [f64]) {
        self.iterations.fetch_add(1, Ordering::Relaxed);
        let pieces = self.factors.par_iter().zip(self.whole.split_own(u));
        pieces.for_each(|(factor, u)| factor.respond(u));
        self.whole.tell(u);
    }

    /// u ← Su of all pieces.
    fn resist(&self, u: &mut [f64]) {
        let pieces = self.whole.own.par_iter().zip(&self.factors);
        let pieces = pieces.zip(self.whole.split_own(u));
        pieces.for_each_init(Vec::new, |product, ((piece, factor), u)| {
            factor.resist(piece, u, product);
        });
        self.whole.tell(u);
    }

    /// Loads f (dofs,) as the borders of all pieces feel them.
    fn condensed(&self, f: &[f64]) -> Vec<f64> {
        let pieces = self.whole.own.par_iter().zip(&self.factors);
        let passed = pieces.map(|(piece, factor)| factor.passed_on(piece, piece.inner_of(f)));
        let mut loads = self
            .whole
            .team
            .join("loads", passed.collect::<Vec<_>>().concat());
        for (place, load) in loads.iter_mut().enumerate() {
            *load += self.whole.part[place] * f[self.whole.dofs[place] as usize];
        }
        loads
    }

    /// The displacements (dofs,) under loads f (dofs,) with those of the border given, (dofs,).
    fn inside(&self, f: &[f64], border: &[f64]) -> Vec<f64> {
        let pieces = self.whole.own.par_iter().zip(&self.factors);
        let own = pieces.map(|(piece, factor)| factor.inside(piece, f, border));
        let own = own.collect::<Vec<Vec<f64>>>().concat();
        let mut u = border.to_vec();
        for (dof, own) in self.whole.of_pieces(own) {
            u[dof] = own;
        }
        u
    }

    /// JᵀSJu, balanced: forces of the glue that would remove the jumps of u if the border had no other stiffness.
    fn pull(&self, u: &[f64]) -> Vec<f64> {
        let mut forces = u.to_vec();
        self.whole.jumps(&mut forces);
        self.resist(&mut forces);
        self.whole.without_resultant(&mut forces);
        self.balance(&[], &mut forces);
        forces
    }

    /// Forces (dofs,) of touched dofs displaced by v, the border held where it is not touched: an approximation of their
    /// stiffness.
    pub fn touched_forces(&self, v: &[f64]) -> Vec<f64> {
        self.forces_of(v, &vec![0.0; self.border()]).0
    }

    /// t ← t + DJRβ with Rᵀ(f + t) = 0, of condensed loads f, of which there may be none.
    fn balance(&self, loads: &[f64], t: &mut [f64]) {
        let Some(coarse) = &self.coarse else { return };
        let mut amplitudes = match loads {
            [] => self.whole.works(t),
            _ => self.whole.works(&sum_of(loads, t)),
        };
        amplitudes.iter_mut().for_each(|work| *work = -*work);
        coarse.solve(&mut amplitudes);
        self.whole.push(&amplitudes, t);
    }

    /// u ← u + Rα with the least jumps.
    fn place(&self, u: &mut [f64]) {
        let Some(coarse) = &self.coarse else { return };
        let mut amplitudes = self.whole.pulls(u);
        amplitudes.iter_mut().for_each(|pull| *pull = -*pull);
        coarse.solve(&mut amplitudes);
        self.whole.move_borders(&amplitudes, u);
    }

    /// The pieces, analysed.
    pub fn whole(&self) -> &Divided {
        &self.whole
    }
}

fn sum_of(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// What needs no factor.
impl Divided {
    /// The parts of a broken vector that the pieces of this process have.
    fn split_own<'v>(&self, v: &'v mut [f64]) -> Vec<&'v mut [f64]> {
        let mut v = &mut v[self.own_border()];
        let part = |piece: &Placed| v.split_off_mut(..piece.border.len()).unwrap_or_default();
        self.pieces[self.own_pieces.clone()]
            .iter()
            .map(part)
            .collect()
    }

    /// The places of broken vectors that this process has.
    fn own_border(&self) -> Range<usize> {
        let own = &self.pieces[self.own_pieces.clone()];
        let ends = own.first().zip(own.last());
        ends.map_or(0..0, |(first, last)| first.border.start..last.border.end)
    }

    /// Tells the others the own part of a broken vector, and hears theirs.
    fn tell(&self, v: &mut [f64]) {
        if self.team.size() > 1 {
            let own = v[self.own_border()].to_vec();
            v.copy_from_slice(&self.team.join("borders", own));
        }
    }

    /// The values of the dofs of all pieces, of those of the own ones.
    fn of_pieces(&self, own: Vec<f64>) -> impl Iterator<Item = (usize, f64)> {
        let dofs = self.pieces.iter().flat_map(|piece| &piece.dofs);
        dofs.map(|&dof| dof as usize)
            .zip(self.team.join("pieces", own))
    }

    /// A broken vector in its pieces.
    fn split<'v>(&self, mut v: &'v mut [f64]) -> Vec<&'v mut [f64]> {
        let part = |piece: &Placed| v.split_off_mut(..piece.border.len()).unwrap_or_default();
        self.pieces.iter().map(part).collect()
    }

    /// f − Au on the free dofs, and the size √Σ(K_ii u_i)² of its terms.
    fn rest(&self, f: &[f64], u: &[f64]) -> (Vec<f64>, f64) {
        let force = |piece: &Bordered| {
            let own = piece.dofs.iter().map(|&dof| u[dof as usize]);
            piece.forces(&own.collect::<Vec<f64>>())
        };
        let forces = self.own.par_iter().map(force);
        let forces = forces.collect::<Vec<Vec<f64>>>().concat();
        let mut rest = f.to_vec();
        for (dof, force) in self.of_pieces(forces) {
            if self.free[dof] {
                rest[dof] -= force;
            }
        }
        let terms = self.diagonal.iter().zip(u).map(|(k, u)| (k * u).powi(2));
        (rest, terms.sum::<f64>().sqrt())
    }

    /// Loads f (dofs,) of touched dofs, shared by their copies.
    fn on_touched(&self, f: &[f64]) -> Vec<f64> {
        let mut loads = vec![0.0; self.dofs.len()];
        for &place in &self.touched {
            let place = place as usize;
            loads[place] = self.part[place] * f[self.dofs[place] as usize];
        }
        loads
    }

    /// The displacements (dofs,) of the border, of copies the mean, and zeros elsewhere.
    fn mean(&self, u: &[f64]) -> Vec<f64> {
        let mut mean = vec![0.0; self.free.len()];
        for ((&dof, part), u) in self.dofs.iter().zip(&self.part).zip(u) {
            mean[dof as usize] += part * u;
        }
        mean
    }

    /// A sum over the copies of every dof of the border.
    fn sums(&self, of: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
        let shares = self.shares.par_windows(2).with_min_len(PLACES);
        let sum = |share: &[usize]| -> f64 {
            let copies = &self.copies[share[0]..share[1]];
            copies.iter().map(|&place| of(place as usize)).sum()
        };
        shares.map(sum).collect()
    }

    /// u ← Ju.
    fn jumps(&self, u: &mut [f64]) {
        let means = self.sums(|place| self.part[place] * u[place]);
        let places = u.par_iter_mut().zip(&self.group).with_min_len(PLACES);
        places.for_each(|(u, &group)| *u -= means[group as usize]);
    }

    /// Forces of the glue without their resultants at every dof: t ← t − D Σt / ΣD.
    fn without_resultant(&self, t: &mut [f64]) {
        let resultants = self.sums(|place| t[place]);
        let places = t.par_iter_mut().zip(&self.group).zip(&self.part);
        let places = places.with_min_len(PLACES);
        places.for_each(|((t, &group), part)| *t -= part * resultants[group as usize]);
    }

    /// Rigid motions of all pieces added to broken displacements u.
    fn move_borders(&self, amplitudes: &[f64], u: &mut [f64]) {
        let pieces = self.pieces.par_iter().zip(self.split(u));
        pieces.for_each(|(piece, u)| {
            let motions = piece.rigid.iter().zip(&amplitudes[piece.modes.clone()]);
            for (column, amplitude) in motions {
                u.iter_mut()
                    .zip(column)
                    .for_each(|(u, r)| *u += amplitude * r);
            }
        });
    }

    /// t ← t + DJRβ.
    pub fn push(&self, amplitudes: &[f64], t: &mut [f64]) {
        let mut forces = vec![0.0; t.len()];
        self.part(amplitudes, &mut forces);
        let forces = forces.iter().zip(&self.stiff);
        let both = t.iter_mut().zip(forces);
        both.for_each(|(t, (force, stiff))| *t += stiff * force);
    }

    /// Jumps ← jumps + JRα.
    pub fn part(&self, amplitudes: &[f64], jumps: &mut [f64]) {
        let mut moved = vec![0.0; jumps.len()];
        self.move_borders(amplitudes, &mut moved);
        self.jumps(&mut moved);
        jumps
            .iter_mut()
            .zip(&moved)
            .for_each(|(jump, moved)| *jump += moved);
    }

    /// RᵀDJu of broken displacements.
    pub fn pulls(&self, u: &[f64]) -> Vec<f64> {
        let mut pulls = u.to_vec();
        self.jumps(&mut pulls);
        let both = pulls.iter_mut().zip(&self.stiff);
        both.for_each(|(pull, stiff)| *pull *= stiff);
        self.works(&pulls)
    }

    /// BR: what rows over the dofs, of which they meet touched ones, measure of every rigid motion.
    pub fn motions(&self, rows: &SparseMatrix) -> Vec<Vec<(usize, f64)>> {
        let mut places: Vec<u32> = self.touched.clone();
        places.sort_by_key(|&place| self.dofs[place as usize]);
        let copies = |dof: usize| {
            let dof_of = |place: &u32| self.dofs[*place as usize] as usize;
            let first = places.partition_point(|place| dof_of(place) < dof);
            let own = places[first..].iter();
            own.take_while(move |place| dof_of(place) == dof)
        };
        let of_row = |row: usize| {
            let mut motions: BTreeMap<usize, f64> = BTreeMap::new();
            for (dof, value) in rows.row(row) {
                for &place in copies(dof) {
                    let place = place as usize;
                    let piece = self.owner(place);
                    let share = value * self.part[place];
                    for (k, column) in piece.rigid.iter().enumerate() {
                        *motions.entry(piece.modes.start + k).or_default() +=
                            share * column[place - piece.border.start];
                    }
                }
            }
            motions.into_iter().collect()
        };
        (0..rows.rows()).into_par_iter().map(of_row).collect()
    }

    /// The piece that has a place of broken vectors.
    fn owner(&self, place: usize) -> &Placed {
        let after = self
            .pieces
            .partition_point(|piece| piece.border.end <= place);
        &self.pieces[after]
    }

    /// Rᵀt of broken forces.
    pub fn works(&self, t: &[f64]) -> Vec<f64> {
        let of = |piece: &Placed| {
            let t = &t[piece.border.clone()];
            let works = piece.rigid.iter().map(|column| dot(column, t));
            works.collect::<Vec<f64>>()
        };
        self.pieces.par_iter().map(of).collect::<Vec<_>>().concat()
    }

    /// The factor of T = RᵀDJR.
    ///
    /// Errors: a whole that some rigid motions of its pieces do not strain.
    fn coarse_problem(&self) -> Result<Option<Cholesky>, LinalgError> {
        if self.modes == 0 {
            return Ok(None);
        }
        let of_whole = |mode: usize| {
            let owner = self.pieces.partition_point(|piece| piece.modes.end <= mode);
            self.pieces[owner].dofs[0] as usize
        };
        let factor = factor_scattered(&self.network, self.modes);
        factor.map(Some).map_err(|error| error.at(of_whole))
    }

    /// T = RᵀDJR: the stiffness of rigid pieces that the springs of the glue join.
    pub fn network(&self) -> &SymmetricMatrix {
        &self.network
    }

    /// The entries of T, summed over all dofs of the border.
    fn resisted(&self) -> SymmetricMatrix {
        let owners = self.pieces.iter().enumerate();
        let owners = owners.flat_map(|(p, piece)| piece.border.clone().map(move |_| p as u32));
        let owner: Vec<u32> = owners.collect();
        let mut blocks: BTreeMap<(u32, u32), Mat<f64>> = BTreeMap::new();
        for share in self.shares.windows(2) {
            let copies = &self.copies[share[0]..share[1]];
            for &i in copies {
                let not_above = |j: &&u32| owner[**j as usize] <= owner[i as usize];
                for &j in copies.iter().filter(not_above) {
                    let [i, j] = [i, j].map(|k| k as usize);
                    let own = if i == j { self.stiff[i] } else { 0.0 };
                    let weight = own - self.stiff[i] * self.part[j];
                    let [(a, i_own), (b, j_own)] = [i, j].map(|k| {
                        let piece = &self.pieces[owner[k] as usize];
                        (&piece.rigid, k - piece.border.start)
                    });
                    let block = blocks.entry((owner[i], owner[j]));
                    let block = block.or_insert_with(|| Mat::zeros(a.len(), b.len()));
                    for (l, b) in b.iter().enumerate() {
                        let right = weight * b[j_own];
                        for (k, a) in a.iter().enumerate() {
                            block[(k, l)] += right * a[i_own];
                        }
                    }
                }
            }
        }
        let mut entries = Vec::new();
        for ((p, q), block) in &blocks {
            let [first, other] = [p, q].map(|&p| self.pieces[p as usize].modes.start);
            for l in 0..block.ncols() {
                let rows = (0..block.nrows()).map(|k| (first + k, other + l, block[(k, l)]));
                entries.extend(rows);
            }
        }
        SymmetricMatrix::from_triplets(self.modes, &entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::{in_teams, team};
    use crate::linalg::grid::{cells, clamped_left, noise, on_threads, stiffness};
    use crate::linalg::{CellMatrices, Graph, assemble_blocks};

    /// A part of a grid of n × n squares: two triangles of each of `squares`, of the stiffness of the grid times a factor.
    fn piece(n: usize, squares: &[usize], factor: f64) -> Piece {
        let (nodes, values) = (cells(n, n), stiffness(n, n));
        let packed = values.len() / (2 * n * n);
        let own = squares
            .iter()
            .flat_map(|&square| [2 * square, 2 * square + 1]);
        let own: Vec<usize> = own.collect();
        let corners = || own.iter().flat_map(|&cell| &nodes[3 * cell..3 * cell + 3]);
        let mut all: Vec<u32> = corners().copied().collect();
        all.sort_unstable();
        all.dedup();
        let place = |node: &u32| all.partition_point(|other| other < node) as u32;
        let local: Vec<u32> = corners().map(place).collect();
        let values = own
            .iter()
            .flat_map(|&c| &values[packed * c..packed * (c + 1)]);
        let values: Vec<f64> = values.map(|value| value * factor).collect();
        let block = CellMatrices {
            nodes: &local,
            nodes_per_cell: 3,
            values: &values,
        };
        let graph = Graph::from_cells(all.len(), &[block.connectivity()]);
        let motion = |k: usize| -> Vec<f64> {
            let at = |&node: &u32| {
                let [x, y] = [node as usize % (n + 1), node as usize / (n + 1)].map(|c| c as f64);
                [[1.0, 0.0], [0.0, 1.0], [-y / n as f64, x / n as f64]][k]
            };
            all.iter().flat_map(at).collect()
        };
        Piece {
            dofs: all
                .iter()
                .flat_map(|&node| [2 * node, 2 * node + 1])
                .collect(),
            stiffness: assemble_blocks::<2>(&graph, &[block]).unwrap(),
            graph,
            motions: (0..3).map(motion).collect(),
        }
    }

    /// The grid in p × p pieces, every third one of them stiffer by a factor.
    fn pieces(n: usize, p: usize, factor: f64) -> Vec<Piece> {
        let of = |square: usize| (square % n) * p / n + p * ((square / n) * p / n);
        let own = |piece: usize| (0..n * n).filter(move |&square| of(square) == piece);
        let factor = |piece: usize| if piece % 3 == 1 { factor } else { 1.0 };
        (0..p * p)
            .map(|k| piece(n, &own(k).collect::<Vec<_>>(), factor(k)))
            .collect()
    }

    fn glued(free: &[bool], pieces: Vec<Piece>) -> Result<Glued, LinalgError> {
        let touched = vec![false; free.len()];
        Arc::new(Divided::new::<2>(free.to_vec(), &touched, pieces, team())?).glue()
    }

    /// The sum of all pieces as one matrix.
    fn sum(dofs: usize, pieces: &[Piece]) -> SymmetricMatrix {
        let mut entries = Vec::new();
        for piece in pieces {
            for j in 0..piece.dofs.len() {
                let rows = piece
                    .stiffness
                    .rows_of(j)
                    .iter()
                    .zip(piece.stiffness.values_of(j));
                entries.extend(rows.map(|(&i, &value)| {
                    let [i, j] = [i as usize, j].map(|k| piece.dofs[k] as usize);
                    (i.max(j), i.min(j), value)
                }));
            }
        }
        SymmetricMatrix::from_triplets(dofs, &entries)
    }

    fn apart(a: &[f64], b: &[f64]) -> f64 {
        let largest = b.iter().fold(0.0, |s: f64, b| s.max(b.abs()));
        let apart = a
            .iter()
            .zip(b)
            .fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()));
        apart / largest
    }

    #[test]
    fn pieces_answer_as_the_whole() {
        for (n, p, factor) in [
            (6, 2, 1.0),
            (9, 3, 1.0),
            (9, 3, 1e4),
            (12, 4, 1e-3),
            (4, 4, 1.0),
        ] {
            let free = clamped_left(n, n);
            let pieces = pieces(n, p, factor);
            let whole = sum(free.len(), &pieces);
            let order: Vec<usize> = (0..free.len()).filter(|&dof| free[dof]).collect();
            let whole = Cholesky::factor(&whole, &order, 0).unwrap();
            let glued = glued(&free, pieces).unwrap();
            // no memory, memory of another load, memory of the same one
            let first = noise(free.len());
            let other: Vec<f64> = (0..free.len()).map(|i| (1.3 * i as f64).sin()).collect();
            for load in [&first, &other, &first] {
                let (mut u, mut expected) = (load.clone(), load.clone());
                glued.solve(&mut u);
                whole.solve(&mut expected);
                assert!(apart(&u, &expected) < 1e-10, "{n} {p} {factor}");
            }
        }
    }

    #[test]
    fn iterations_grow_slowly_with_the_number_of_pieces() {
        let iterations = |n: usize, p: usize, factor: f64| {
            let free = clamped_left(n, n);
            let glued = glued(&free, pieces(n, p, factor)).unwrap();
            glued.displacements(&noise(free.len()), None, 1e-6);
            glued.iterations()
        };
        // 13, and 19 with six times as many pieces
        let few = iterations(16, 4, 1.0);
        let many = iterations(40, 10, 1.0);
        assert!(few < 16 && many < 22, "{few} {many}");
        assert!(iterations(40, 10, 1e4) <= many);
    }

    #[test]
    fn load_that_was_solved_before_takes_few_iterations() {
        let (n, p) = (16, 4);
        let free = clamped_left(n, n);
        let glued = glued(&free, pieces(n, p, 1.0)).unwrap();
        let [first, other] = [1.3, 0.7].map(|w: f64| {
            (0..free.len())
                .map(|i| (w * i as f64).sin())
                .collect::<Vec<f64>>()
        });
        let mut counts = Vec::new();
        let both: Vec<f64> = first.iter().zip(&other).map(|(a, b)| a - 3.0 * b).collect();
        for load in [first, other, both] {
            let before = glued.iterations();
            glued.solve(&mut load.clone());
            counts.push(glued.iterations() - before);
        }
        assert!(3 * counts[2] < 2 * counts[0].min(counts[1]), "{counts:?}");
    }

    #[test]
    fn all_pieces_float() {
        let n = 6;
        let free = clamped_left(n, n);
        let divided = |free: &[bool]| {
            Divided::new::<2>(
                free.to_vec(),
                &vec![false; free.len()],
                pieces(n, 3, 1.0),
                team(),
            )
            .unwrap()
        };
        // the three at the edge, too, and one of which one node is held
        let one: Vec<bool> = (0..free.len()).map(|dof| dof > 1).collect();
        for free in [&free, &one] {
            assert_eq!(divided(free).coarse(), 3 * 9);
        }
    }

    #[test]
    fn rows_and_springs_feel_the_motions_of_pieces() {
        let n = 6;
        let free = clamped_left(n, n);
        let mut touched = vec![false; free.len()];
        // a node of four pieces, one of two, and one inside
        let nodes = [16, 18, 40];
        nodes.iter().for_each(|node| touched[2 * node] = true);
        let divided = Divided::new::<2>(free, &touched, pieces(n, 3, 1e2), team()).unwrap();
        let rows = nodes
            .iter()
            .enumerate()
            .map(|(row, node)| (row, 2 * node, 0.5));
        let triplets: Vec<_> = rows.chain([(0, 2 * nodes[1], -2.0)]).collect();
        let rows = SparseMatrix::from_triplets(3, touched.len(), &triplets);
        let motions = divided.motions(&rows);
        for mode in 0..divided.coarse() {
            let mut amplitudes = vec![0.0; divided.coarse()];
            amplitudes[mode] = 1.0;
            let mut moved = vec![0.0; divided.dofs.len()];
            divided.move_borders(&amplitudes, &mut moved);
            let mut measured = [0.0; 3];
            rows.mul(&divided.mean(&moved), &mut measured);
            for (own, measured) in motions.iter().zip(measured) {
                let own = own.iter().filter(|(other, _)| *other == mode);
                let own: f64 = own.map(|(_, motion)| motion).sum();
                assert!((own - measured).abs() < 1e-12);
            }
            let pulls = divided.pulls(&moved);
            for (other, pull) in pulls.iter().enumerate() {
                let entry = divided.network().get(other.max(mode), other.min(mode));
                assert!((entry - pull).abs() < 1e-12 * divided.stiff.iter().sum::<f64>());
            }
        }
    }

    #[test]
    fn whole_that_may_move_is_refused() {
        let n = 6;
        let one: Vec<bool> = (0..2 * (n + 1) * (n + 1)).map(|dof| dof > 1).collect();
        let refused = glued(&one, pieces(n, 3, 1.0)).err();
        assert!(matches!(
            refused,
            Some(LinalgError::NotPositiveDefinite { .. } | LinalgError::NearlySingular { .. })
        ));
    }

    #[test]
    fn bits_do_not_depend_on_threads() {
        let n = 12;
        let free = clamped_left(n, n);
        let solved = |threads| {
            on_threads(threads, || {
                let glued = glued(&free, pieces(n, 3, 10.0)).unwrap();
                let mut u = noise(free.len());
                glued.solve(&mut u);
                u
            })
        };
        assert_eq!(solved(1), solved(3));
    }

    #[test]
    fn bits_do_not_depend_on_processes() {
        let n = 12;
        let free = clamped_left(n, n);
        let touched: Vec<bool> = (0..free.len()).map(|dof| dof % 7 == 0).collect();
        let solved = |team: Arc<dyn Team>| {
            let mut own = pieces(n, 3, 10.0);
            own = own.drain(share(&*team, 9)).collect();
            let divided = Divided::new::<2>(free.clone(), &touched, own, team).unwrap();
            let sizes = (divided.stored(), divided.coarse(), divided.pieces());
            let glued = Arc::new(divided).glue().unwrap();
            let mut u = noise(free.len());
            glued.solve(&mut u);
            let moved = glued.move_under(&u, &vec![0.0; glued.border()], true);
            (u, moved, sizes)
        };
        let alone = solved(team());
        // some of eleven have no piece
        for size in [2, 3, 11] {
            for one in in_teams(size, solved) {
                assert!(one == alone, "{size}");
            }
        }
    }

    #[test]
    fn all_processes_have_the_error_of_one() {
        let n = 6;
        let free = vec![true; 2 * (n + 1) * (n + 1)];
        let solved = |team: Arc<dyn Team>| {
            let mut own = pieces(n, 3, 1.0);
            own[7].motions.truncate(2);
            own = own.drain(share(&*team, 9)).collect();
            let touched = vec![false; free.len()];
            let divided = Divided::new::<2>(free.clone(), &touched, own, team)?;
            Arc::new(divided).glue().map(drop)
        };
        let told = solved(team());
        assert!(told.is_err());
        assert!(in_teams(3, solved).into_iter().all(|one| one == told));
    }

    #[test]
    fn touched_dofs_are_as_stiff_as_their_piece_with_its_border_held() {
        let n = 4;
        let free = clamped_left(n, n);
        let mut touched = vec![false; free.len()];
        // the upper right node, inside of its piece
        let dof = free.len() - 2;
        touched[dof] = true;
        let parts = pieces(n, 2, 1.0);
        let whole = sum(free.len(), &parts);
        let mut held = free.clone();
        let mut owners = vec![0; free.len()];
        parts
            .iter()
            .flat_map(|piece| &piece.dofs)
            .for_each(|&dof| owners[dof as usize] += 1);
        (0..held.len()).for_each(|k| held[k] &= owners[k] == 1);
        let order: Vec<usize> = (0..held.len()).filter(|&k| held[k]).collect();
        let mut unit = vec![0.0; free.len()];
        unit[dof] = 1.0;
        Cholesky::factor(&whole, &order, 0)
            .unwrap()
            .solve(&mut unit);
        let divided = Divided::new::<2>(free.clone(), &touched, parts, team()).unwrap();
        assert!(
            divided.is_touched_at(&touched) && !divided.is_touched_at(&vec![false; free.len()])
        );
        let glued = Arc::new(divided).glue().unwrap();
        let mut moved = vec![0.0; free.len()];
        moved[dof] = 1.0;
        let force = glued.touched_forces(&moved);
        assert!((force[dof] * unit[dof] - 1.0).abs() < 1e-12);
        assert_eq!(force.iter().filter(|force| **force != 0.0).count(), 1);
    }
}
