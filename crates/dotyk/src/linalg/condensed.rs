//! A piece of a whole, condensed onto its border: the dofs that it shares with other pieces or with supports, and those that forces from
//! outside meet.
//!
//! ```text
//!   S u = g,      S = K_bb − K_bi K_ii⁻¹ K_ib = LLᵀ,      g = f_b − K_bi K_ii⁻¹ f_i,      u_i = K_ii⁻¹(f_i − K_ib u)
//! ```
//!
//! L is the last block of a factor of K with the border ordered last, and all that iterations read: S⁻¹ is two solutions with it, and
//! S two products. A piece that floats has rigid motions R, SR = 0. Held at as many dofs g of its border, the others k have the factor
//! LLᵀ = S_kk; with C = R_k R_g⁻¹,
//!
//! ```text
//!   S = [1; −Cᵀ] LLᵀ [1, −C],      S⁺ = LLᵀ⁻¹ on k, zero on g
//! ```

use crate::linalg::dense::dot;
use crate::linalg::{
    Cholesky, Graph, LinalgError, Lu, Mat, SymbolicCholesky, SymmetricMatrix, elimination_order,
    ground, null_space,
};

/// A rigid motion is held if its energy is above this part of that of its terms.
const HELD: f64 = 1e-12;

/// A part of a matrix.
pub(crate) struct Piece {
    /// The dof of the whole for each of its own, D for each node.
    pub dofs: Vec<u32>,
    /// Its nodes.
    pub graph: Graph,
    /// K_p, held dofs included.
    pub stiffness: SymmetricMatrix,
    /// Columns of rigid motions, (own dofs,), of which those without energy are its kernel.
    pub motions: Vec<Vec<f64>>,
}

/// What a dof of the whole is.
pub(super) struct Kind {
    /// Held, or another piece has it, too.
    pub shared: bool,
    /// Forces from outside meet it.
    pub touched: bool,
}

/// A piece with its border and its orders of elimination.
pub(super) struct Bordered {
    pub dofs: Vec<u32>,
    stiffness: SymmetricMatrix,
    /// Elimination order of its inner dofs.
    inner: Vec<usize>,
    /// Its border, own dofs: those of L, and behind them those that ground it.
    pub border: Vec<u32>,
    /// C, a column (dofs of L,) for each that grounds it.
    levers: Vec<Vec<f64>>,
}

/// What all processes know of a piece.
pub(super) struct Outline {
    /// The dofs of the whole that it has, and those on its border.
    pub dofs: Vec<u32>,
    pub border: Vec<u32>,
    /// R on the border, columns (border,).
    pub rigid: Vec<Vec<f64>>,
    /// D of its border: of every cell at a node the mean of K_ii, so that ragged borders weigh as straight ones.
    pub stiff: Vec<f64>,
    /// Entries of K_p and of its factors, and operations of the factorisation.
    pub stiffness: usize,
    pub stored: usize,
    pub operations: f64,
}

impl Outline {
    /// As numbers.
    pub fn coded(&self) -> Vec<f64> {
        let sizes = [
            self.dofs.len(),
            self.border.len(),
            self.rigid.len(),
            self.stiffness,
            self.stored,
        ];
        let head = sizes.into_iter().map(|size| size as f64);
        let numbers = self.dofs.iter().chain(&self.border);
        let numbers = numbers.map(|&dof| f64::from(dof));
        let values = self.stiff.iter().chain(self.rigid.iter().flatten());
        let head = head.chain([self.operations]);
        head.chain(numbers).chain(values.copied()).collect()
    }

    /// All of some pieces, one behind the other.
    pub fn decoded(mut coded: &[f64]) -> Vec<Self> {
        let mut all = Vec::new();
        while let Some((head, rest)) = coded.split_first_chunk() {
            let [dofs, border, rigid, stiffness, stored, operations] = *head;
            let [dofs, border] = [dofs, border].map(|size| size as usize);
            coded = rest;
            let mut take = |count: usize| {
                let (taken, rest) = coded.split_at(count);
                coded = rest;
                taken
            };
            let numbers = |values: &[f64]| values.iter().map(|&value| value as u32).collect();
            all.push(Self {
                dofs: numbers(take(dofs)),
                border: numbers(take(border)),
                stiff: take(border).to_vec(),
                rigid: (0..rigid as usize).map(|_| take(border).to_vec()).collect(),
                stiffness: stiffness as usize,
                stored: stored as usize,
                operations,
            });
        }
        all
    }
}

impl Bordered {
    /// Errors: those of the analyses, with dofs of the whole; rigid motions that cannot be found.
    pub fn new<const D: usize>(
        piece: Piece,
        kind: &(impl Fn(u32) -> Kind + Sync),
    ) -> Result<(Self, Outline), LinalgError> {
        let Piece {
            dofs,
            graph,
            stiffness,
            motions,
        } = piece;
        let kinds: Vec<Kind> = dofs.iter().map(|&dof| kind(dof)).collect();
        let all = |has: &dyn Fn(&Kind) -> bool| kinds.iter().map(has).collect::<Vec<bool>>();
        let mut free = vec![true; dofs.len()];
        let outer = all(&|kind| kind.shared || kind.touched);
        let rigid = kernel(&motions, &stiffness)?;
        let grounded = ground(&rigid, &outer, &outer);
        if grounded.len() < rigid.len() {
            // it turns about what joins it to the others
            let dof = dofs[0] as usize;
            return Err(LinalgError::NearlySingular { dof, ratio: 0.0 });
        }
        grounded.iter().for_each(|&dof| free[dof] = false);
        let kept = (0..dofs.len()).filter(|&dof| outer[dof] && free[dof]);
        let kept: Vec<usize> = kept.collect();
        let order = elimination_order::<D>(&graph, &free, &kept);
        let inner = order[..order.len() - kept.len()].to_vec();
        let at = |error: LinalgError| error.at(|local| dofs[local] as usize);
        let analysis = |order: &[usize], last: usize| {
            SymbolicCholesky::new(&stiffness, order, last).map_err(at)
        };
        let (whole, own) = (analysis(&order, kept.len())?, analysis(&inner, 0)?);
        let levers = levers(&rigid, &kept, &grounded)?;
        let border = kept.iter().chain(&grounded).map(|&dof| dof as u32);
        let border: Vec<u32> = border.collect();
        let diagonal = stiffness.diagonal();
        let of_cell = |dof: usize| diagonal[dof] / graph.slots(dof / D).len() as f64;
        let outline = Outline {
            dofs: dofs.clone(),
            border: border.iter().map(|&dof| dofs[dof as usize]).collect(),
            rigid: rigid.iter().map(|motion| on(&border, motion)).collect(),
            stiff: border.iter().map(|&dof| of_cell(dof as usize)).collect(),
            stiffness: stiffness.stored(),
            stored: kept.len() * (kept.len() + 1) / 2 + own.stored(),
            operations: whole.operations() + own.operations(),
        };
        let bordered = Self {
            dofs,
            stiffness,
            inner,
            border,
            levers,
        };
        Ok((bordered, outline))
    }

    /// Errors: those of the factors, with dofs of the whole.
    pub fn factor(&self) -> Result<Factors, LinalgError> {
        let at = |error: LinalgError| error.at(|local| self.dofs[local] as usize);
        let kept = self.border.len() - self.levers.len();
        let last = self.border[..kept].iter().map(|&dof| dof as usize);
        let order: Vec<usize> = self.inner.iter().copied().chain(last).collect();
        let factor = |order: &[usize], last: usize| {
            Cholesky::factor(&self.stiffness, order, last).map_err(at)
        };
        Ok(Factors {
            triangle: Triangle::of(&factor(&order, kept)?.trailing_factor()),
            inner: factor(&self.inner, 0)?,
        })
    }

    /// The loads (own dofs,) of its inner dofs, of those of the whole.
    pub fn inner_of(&self, f: &[f64]) -> Vec<f64> {
        let mut own = vec![0.0; self.dofs.len()];
        for &dof in &self.inner {
            own[dof] = f[self.dofs[dof] as usize];
        }
        own
    }

    /// K_p u, (own dofs,).
    pub fn forces(&self, u: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; u.len()];
        self.stiffness.mul(u, &mut forces);
        forces
    }
}

/// The entries of a vector (own dofs,) on a border.
fn on(border: &[u32], own: &[f64]) -> Vec<f64> {
    border.iter().map(|&dof| own[dof as usize]).collect()
}

/// C = R_k R_g⁻¹ by columns, of motions that the dofs g hold.
fn levers(
    rigid: &[Vec<f64>],
    kept: &[usize],
    grounded: &[usize],
) -> Result<Vec<Vec<f64>>, LinalgError> {
    let count = grounded.len();
    if count == 0 {
        return Ok(Vec::new());
    }
    // Cᵀ = R_g⁻ᵀ R_kᵀ
    let held = Lu::new(Mat::from_fn(count, count, |i, j| rigid[i][grounded[j]]))?;
    let mut moved = Mat::from_fn(count, kept.len(), |i, k| rigid[i][kept[k]]);
    held.solve_in_place(&mut moved);
    let column = |i: usize| (0..kept.len()).map(|k| moved[(i, k)]).collect();
    Ok((0..count).map(column).collect())
}

/// The factors of a piece.
pub(super) struct Factors {
    triangle: Triangle,
    /// Of K_ii.
    inner: Cholesky,
}

impl Factors {
    /// u ← S⁺u on the border.
    pub fn respond(&self, u: &mut [f64]) {
        let (kept, grounded) = u.split_at_mut(self.triangle.size);
        self.triangle.solve(kept);
        grounded.fill(0.0);
    }

    /// u ← Su on the border; `product` is workspace.
    pub fn resist(&self, piece: &Bordered, u: &mut [f64], product: &mut Vec<f64>) {
        let (kept, grounded) = u.split_at_mut(self.triangle.size);
        for (lever, moved) in piece.levers.iter().zip(&*grounded) {
            kept.iter_mut()
                .zip(lever)
                .for_each(|(u, c)| *u -= c * moved);
        }
        self.triangle.multiply(kept, product);
        for (lever, force) in piece.levers.iter().zip(grounded) {
            *force = -dot(lever, kept);
        }
    }

    /// g − f_b on the border, of loads (own dofs,) whose entries on the border are zero.
    pub fn passed_on(&self, piece: &Bordered, mut f: Vec<f64>) -> Vec<f64> {
        if f.iter().all(|f| *f == 0.0) {
            return vec![0.0; piece.border.len()];
        }
        self.inner.solve(&mut f);
        let mut passed = on(&piece.border, &piece.forces(&f));
        passed.iter_mut().for_each(|force| *force = -*force);
        passed
    }

    /// u (own dofs,) of loads and displacements of the border of the whole, which are zero elsewhere.
    pub fn inside(&self, piece: &Bordered, f: &[f64], border: &[f64]) -> Vec<f64> {
        let moved: Vec<f64> = piece.dofs.iter().map(|&dof| border[dof as usize]).collect();
        let mut u = piece.inner_of(f);
        let forces = piece.forces(&moved);
        u.iter_mut().zip(&forces).for_each(|(f, force)| *f -= force);
        self.inner.solve(&mut u);
        u.iter_mut().zip(&moved).for_each(|(u, moved)| *u += moved);
        u
    }
}

/// A lower triangle, column by column.
struct Triangle {
    size: usize,
    values: Vec<f64>,
}

impl Triangle {
    /// The lower triangle of a square matrix.
    fn of(matrix: &Mat<f64>) -> Self {
        let size = matrix.ncols();
        let mut values = Vec::with_capacity(size * (size + 1) / 2);
        (0..size).for_each(|j| values.extend_from_slice(&matrix.col_as_slice(j)[j..]));
        Self { size, values }
    }

    /// Where column j begins.
    fn start(&self, j: usize) -> usize {
        j * self.size - j * j.saturating_sub(1) / 2
    }

    /// x ← (LLᵀ)⁻¹x.
    fn solve(&self, x: &mut [f64]) {
        let mut columns = &self.values[..];
        for j in 0..self.size {
            let (column, rest) = columns.split_at(self.size - j);
            columns = rest;
            x[j] /= column[0];
            let own = x[j];
            let below = x[j + 1..].iter_mut().zip(&column[1..]);
            below.for_each(|(x, l)| *x -= own * l);
        }
        for j in (0..self.size).rev() {
            let column = &self.values[self.start(j)..][..self.size - j];
            x[j] = (x[j] - wide_dot(&column[1..], &x[j + 1..])) / column[0];
        }
    }

    /// x ← LLᵀx; L is read once, and `product` is workspace.
    fn multiply(&self, x: &mut [f64], product: &mut Vec<f64>) {
        product.clear();
        product.resize(self.size, 0.0);
        let mut columns = &self.values[..];
        for j in 0..self.size {
            let (column, rest) = columns.split_at(self.size - j);
            columns = rest;
            let own = wide_dot(column, &x[j..]);
            let below = product[j..].iter_mut().zip(column);
            below.for_each(|(y, l)| *y += own * l);
        }
        x.copy_from_slice(product);
    }
}

/// Σ a_i b_i in eight sums that go side by side: one alone would wait for each addition.
fn wide_dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums.iter().sum::<f64>() + dot(a_rest, b_rest)
}

/// Combinations of motions that no energy opposes.
fn kernel(motions: &[Vec<f64>], stiffness: &SymmetricMatrix) -> Result<Vec<Vec<f64>>, LinalgError> {
    let forces = motions.iter().map(|motion| {
        let mut force = vec![0.0; motion.len()];
        stiffness.mul(motion, &mut force);
        force
    });
    let forces: Vec<Vec<f64>> = forces.collect();
    let diagonal = stiffness.diagonal();
    let size = |motion: &Vec<f64>| -> f64 {
        let terms = motion.iter().zip(&diagonal);
        terms.map(|(u, k)| k * u * u).sum()
    };
    let largest = motions.iter().map(size).fold(0.0, f64::max);
    let energy = Mat::from_fn(motions.len(), motions.len(), |i, j| {
        let own = dot(&motions[i], &forces[j]) / largest;
        // rounding holds nothing
        if own.abs() <= HELD { 0.0 } else { own }
    });
    // energies are parts of the whole already: where springs are soft, rounding of the cells remains beside theirs
    let entries = (0..energy.ncols()).flat_map(|j| energy.col_as_slice(j));
    let most = entries.fold(HELD, |s: f64, e| s.max(e.abs()));
    let open = null_space(&energy, HELD / most)?;
    let of = |j: usize| {
        let mut sum = vec![0.0; diagonal.len()];
        for (column, &part) in motions.iter().zip(open.col_as_slice(j)) {
            sum.iter_mut().zip(column).for_each(|(s, c)| *s += part * c);
        }
        let size = sum.iter().fold(0.0, |s: f64, u| s.max(u.abs()));
        sum.iter_mut().for_each(|u| *u /= size);
        sum
    };
    Ok((0..open.ncols()).map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::dense::norm;
    use crate::linalg::grid::{body, clamped_left, noise};
    use crate::linalg::least_squares;

    /// A grid of n × n squares, of which the upper and lower edges are shared, and the left one if it is clamped.
    fn piece(n: usize, clamped: bool) -> (Bordered, Outline, Factors, SymmetricMatrix) {
        let (graph, stiffness) = body(n, n);
        let nodes = (n + 1) * (n + 1);
        let motion = |k: usize| -> Vec<f64> {
            let at = |node: usize| {
                let [x, y] = [node % (n + 1), node / (n + 1)].map(|c| c as f64 / n as f64);
                [[1.0, 0.0], [0.0, 1.0], [-y, x]][k]
            };
            (0..nodes).flat_map(at).collect()
        };
        let free = match clamped {
            true => clamped_left(n, n),
            false => vec![true; 2 * nodes],
        };
        let piece = Piece {
            dofs: (0..2 * nodes as u32).collect(),
            graph,
            stiffness: stiffness.clone(),
            motions: (0..3).map(motion).collect(),
        };
        let kind = |dof: u32| {
            let row = dof as usize / 2 / (n + 1);
            Kind {
                shared: !free[dof as usize] || row == 0 || row == n,
                touched: false,
            }
        };
        let (own, outline) = Bordered::new::<2>(piece, &kind).unwrap();
        let factors = own.factor().unwrap();
        (own, outline, factors, stiffness)
    }

    #[test]
    fn forces_on_the_border_are_those_of_the_whole_with_a_free_inside() {
        for clamped in [false, true] {
            let (own, outline, factors, stiffness) = piece(5, clamped);
            assert_eq!(outline.rigid.len(), 3);
            let mut border = vec![0.0; own.dofs.len()];
            let moved = noise(own.border.len());
            for (&dof, u) in own.border.iter().zip(&moved) {
                border[dof as usize] = *u;
            }
            let u = factors.inside(&own, &vec![0.0; own.dofs.len()], &border);
            let mut force = vec![0.0; u.len()];
            stiffness.mul(&u, &mut force);
            let mut seen = moved.clone();
            factors.resist(&own, &mut seen, &mut Vec::new());
            let expected = on(&own.border, &force);
            for (a, b) in seen.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-11 * norm(&expected));
            }
            // no forces elsewhere
            let inner: f64 = own.inner.iter().map(|&dof| force[dof].abs()).sum();
            assert!(inner < 1e-11 * norm(&expected));
        }
    }

    #[test]
    fn displacements_of_the_border_answer_balanced_forces() {
        for clamped in [false, true] {
            let (own, outline, factors, _) = piece(6, clamped);
            // S of something is balanced
            let mut forces = noise(own.border.len());
            factors.resist(&own, &mut forces, &mut Vec::new());
            let mut u = forces.clone();
            factors.respond(&mut u);
            factors.resist(&own, &mut u, &mut Vec::new());
            for (a, b) in u.iter().zip(&forces) {
                assert!((a - b).abs() < 1e-11 * norm(&forces));
            }
            // rigid motions meet no resistance
            for motion in &outline.rigid {
                let mut moved = motion.clone();
                factors.resist(&own, &mut moved, &mut Vec::new());
                assert!(norm(&moved) < 1e-12 * norm(&forces));
            }
        }
    }

    #[test]
    fn loads_inside_are_passed_on_to_the_border() {
        let (own, outline, factors, stiffness) = piece(5, true);
        let loads = own.inner_of(&noise(own.dofs.len()));
        let mut u = factors.passed_on(&own, loads.clone());
        // forces of the border balance them
        let rigid = Mat::from_fn(u.len(), 3, |i, k| outline.rigid[k][i]);
        let right = Mat::from_fn(u.len(), 1, |i, _| u[i]);
        let parts = least_squares(&rigid, &right, 1e-12).unwrap();
        let balance =
            |i: usize| -> f64 { -(0..3).map(|k| rigid[(i, k)] * parts[(k, 0)]).sum::<f64>() };
        let balance: Vec<f64> = (0..u.len()).map(balance).collect();
        u.iter_mut()
            .zip(&balance)
            .for_each(|(u, force)| *u += force);
        factors.respond(&mut u);
        let (mut border, mut expected) = (vec![0.0; own.dofs.len()], loads.clone());
        for ((&dof, u), force) in own.border.iter().zip(&u).zip(&balance) {
            border[dof as usize] = *u;
            expected[dof as usize] = *force;
        }
        let u = factors.inside(&own, &loads, &border);
        let mut force = vec![0.0; u.len()];
        stiffness.mul(&u, &mut force);
        for (force, expected) in force.iter().zip(&expected) {
            assert!((force - expected).abs() < 1e-12 * norm(&loads));
        }
    }

    #[test]
    fn piece_that_turns_about_what_joins_it_is_refused() {
        let (graph, stiffness) = body(2, 2);
        let motions = vec![vec![1.0; 18]];
        let piece = Piece {
            dofs: (100..118).collect(),
            graph,
            stiffness,
            motions,
        };
        let alone = |_| Kind {
            shared: false,
            touched: false,
        };
        let refused = Bordered::new::<2>(piece, &alone).err();
        let expected = LinalgError::NearlySingular {
            dof: 100,
            ratio: 0.0,
        };
        assert_eq!(refused, Some(expected));
    }
}
