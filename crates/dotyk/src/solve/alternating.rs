//! Alternating directions: the law of every node separately, then the bodies with a compliance between them, by turns. The
//! matrix stays the same.
//!
//! ```text
//!   λ = P(t)                                     the law, node by node
//!   (F + a) x − Gᵀα = d + a (2λ − t),  Gx = e    the bodies, linear
//!   t ← t + ω (x − λ)
//! ```
//!
//! At a fixed point λ = x and t = λ − gap/a: λ solves the problem. Where bounds of friction are given this is the splitting
//! of Douglas and Rachford, which converges from anywhere. With Coulomb's law there is no energy to minimise; P then bounds
//! shears by the normal forces of the same trial. Among many floating bodies, whose contacts share their forces in infinitely
//! many ways, steps that guess states wander. These steps guess no states: the force of a node is a continuous function of its
//! trial force. They converge linearly, and with Anderson's acceleration (`anderson.rs`) some hundred of them are enough,
//! whatever the number of bodies.
//!
//! Of many bodies F = Σ BᵀS⁻¹B (`DualProblem::parts`), and the linear problem is one in their boundary displacements u and
//! amplitudes β of the rows M of the balance. With q = (u, β), D = 1/a and the columns c = (b, −m) of all contacts,
//!
//! ```text
//!   (diag(S, 0) + C D Cᵀ) q = C (w + D d) + (0, e),    x = w + D (d − Cᵀq),    w = 2λ − t
//! ```
//!
//! definite, sparse where each body has few contacts, and of half the size of the problem in forces.
//!
//! As described in Lions & Mercier (1979) for the splitting; Acary, Brémond & Huber (2018) for its use with friction.

use crate::dual::{Compliance, Component, IMBALANCE_LIMIT};
use crate::linalg::dense::{
    cholesky_in_place, dot, product, solve_cholesky_in_place, solve_lower_in_place,
    solve_lower_transpose_in_place,
};
use crate::linalg::{Cholesky, Graph, Mat, SparseVector, SymmetricMatrix, fill_reducing_order};
use crate::solve::Observer;
use crate::solve::anderson::Anderson;
use crate::solve::exact::{Ended, NEARBY, Search, Settled};
use crate::solve::levels::local_softness;
use crate::solve::setup::Setup;
use crate::solve::states::State;

/// a, relative to the compliance of each contact: tried in order, each from the start, until one leads to an answer. Where both
/// do, the first is six times as fast as the second. Forces with which bodies clamp each other, however, are limited only by the
/// law of some node, and change by gap/a in each turn. An iteration that has reached such forces leaves them only with a small a;
/// with a small a from the start it rarely reaches them.
const PARTS: [f64; 3] = [0.3, 0.03, 0.01];

/// Smallest compliance of a contact, relative to the median.
const LEAST_OF_MEDIAN: f64 = 0.1;

/// ω: beyond 1, as usual, below 2, where the splitting would stop converging.
const RELAXATION: f64 = 1.6;

/// Alternations that count for one step, and after which forces are judged: together they cost about a factorisation.
const TOGETHER: usize = 32;

/// The iteration has stalled after so many steps without a residual below this part of the least one.
const TURN_PATIENCE: usize = 25;
const PATIENCE_WITH_FEW: usize = 10;
const PROGRESS: f64 = 0.9;

/// Where possible the residual is reduced to this part of the tolerance.
const TURN_ACCURACY: f64 = 1e-2;

/// Alternates from the forces of the search until its tolerance is met, or until the residual falls no more.
pub(crate) fn alternate(
    search: &mut Search<'_>,
    states: Vec<State>,
    observe: Observer<'_>,
) -> Ended {
    let setup = search.setup;
    let mut lambda = vec![0.0; setup.len()];
    // forces that earlier steps left far from an answer are a worse start than no forces
    let start = match search.steps {
        0 => Some(&search.point.lambda),
        _ => (search.best.0 < NEARBY).then_some(&search.best.1.lambda),
    };
    if let Some(start) = start {
        by_law(setup, start, &mut lambda);
    }
    let gap = vec![0.0; setup.len()];
    alternate_from(search, (lambda, gap), states, observe)
}

/// Alternates from forces and their gaps (m,): the trial forces are λ − gap/a, a fixed point if the forces are an answer. Contacts
/// that are wide open stay open; from forces alone the gaps would have to be found again.
pub(crate) fn alternate_from(
    search: &mut Search<'_>,
    (lambda, gap): (Vec<f64>, Vec<f64>),
    states: Vec<State>,
    observe: Observer<'_>,
) -> Ended {
    let setup = search.setup;
    // where any normal force, however small, brings cohesion, the splitting would end with negligible normal forces
    if setup.admissible.jumps() {
        return Ended::Stuck(states);
    }
    let local = local_compliance(setup);
    let (parts, patience) = match setup.problem.is_crowd() {
        true => (&PARTS[..], TURN_PATIENCE),
        // few bodies have other stages behind this one
        false => (&PARTS[..1], PATIENCE_WITH_FEW),
    };
    for part in parts {
        if search.exhausted() {
            break;
        }
        let compliance: Vec<f64> = local.iter().map(|c| part * c).collect();
        let trial = lambda.iter().zip(&gap).zip(&compliance);
        let trial = trial.map(|((l, g), a)| l - g / a).collect();
        let Some(half) = LinearHalf::new(setup, compliance) else {
            break;
        };
        let (balanced, amplitudes) = match take_turns(search, &half, (trial, patience), observe) {
            Left::Forces(balanced, amplitudes) => (balanced, amplitudes),
            Left::Exact => return Ended::Converged,
            Left::Stopped => return Ended::Stopped,
        };
        // before the last digits balanced forces are a better answer than admissible ones: the balance must hold to ten digits,
        // whatever the tolerance
        if search.residual > IMBALANCE_LIMIT {
            search.move_to(balanced, setup.balance.from_rows(amplitudes));
        }
        if search.residual <= search.tolerance {
            return Ended::Converged;
        }
    }
    search.go_back();
    match search.residual <= search.tolerance {
        true => Ended::Converged,
        false => Ended::Stuck(states),
    }
}

/// The end of one alternation.
enum Left {
    /// The last balanced forces (m,) and amplitudes of the rows of the balance.
    Forces(Vec<f64>, Vec<f64>),
    /// The answer, by exact steps.
    Exact,
    /// It was stopped.
    Stopped,
}

/// Alternates with one matrix from the trial forces (m,), until `patience` steps in a row make no progress.
fn take_turns(
    search: &mut Search<'_>,
    half: &LinearHalf<'_>,
    (mut trial, patience): (Vec<f64>, usize),
    observe: Observer<'_>,
) -> Left {
    let setup = search.setup;
    let roots: Vec<f64> = half.compliance.iter().map(|a| a.sqrt()).collect();
    let mut lambda = vec![0.0; setup.len()];
    let (mut balanced, mut amplitudes) = (Vec::new(), Vec::new());
    let mut anderson = Anderson::default();
    let (mut least, mut still) = (f64::INFINITY, 0);
    let mut settled = Settled::default();
    while !search.exhausted() && still < patience {
        for _ in 0..TOGETHER {
            by_law(setup, &trial, &mut lambda);
            let reflected = lambda.iter().zip(&trial);
            let reflected = reflected.map(|(l, t)| 2.0 * l - t).collect();
            (balanced, amplitudes) = half.solve(reflected);
            let residual = balanced.iter().zip(&lambda).zip(&roots);
            let residual: Vec<f64> = residual
                .map(|((x, l), root)| RELAXATION * (x - l) * root)
                .collect();
            let image = trial.iter().zip(&roots).zip(&residual);
            let image = image.map(|((t, root), r)| t * root + r).collect();
            trial = anderson.next(image, residual);
            let scaled = trial.iter_mut().zip(&roots);
            scaled.for_each(|(t, root)| *t /= root);
        }
        by_law(setup, &trial, &mut lambda);
        search.steps += 1;
        search.move_to(lambda.clone(), setup.balance.from_rows(amplitudes.clone()));
        search.kind = 'd';
        if search.tell(observe) {
            return Left::Stopped;
        }
        if search.residual <= TURN_ACCURACY * search.tolerance {
            break;
        }
        still = match search.residual < PROGRESS * least {
            true => 0,
            false => still + 1,
        };
        if still == 0 {
            least = search.residual;
        }
        // in a crowd the states do not determine the forces
        if setup.problem.is_crowd() {
            continue;
        }
        if let Some(ended) = settled.exact(search, of_trial(setup, &trial), 2, observe) {
            return match ended {
                Ended::Stopped => Left::Stopped,
                _ => Left::Exact,
            };
        }
    }
    Left::Forces(balanced, amplitudes)
}

/// States of all nodes at trial forces (m,).
fn of_trial(setup: &Setup<'_>, trial: &[f64]) -> Vec<State> {
    let blocks = setup.admissible.iter();
    blocks
        .map(|(block, range)| State::of_trial(block, &trial[range]))
        .collect()
}

/// λ of trial forces t, node by node: normal forces ≥ 0, and shears within the bound of that normal force. Shapes: (m,).
///
/// Where bounds follow from normal forces this is not the nearest admissible force: that one has a larger normal force where it
/// slips.
fn by_law(setup: &Setup<'_>, trial: &[f64], lambda: &mut [f64]) {
    let held = lambda.iter_mut().zip(trial).zip(&setup.components);
    for ((lambda, t), component) in held {
        *lambda = if *component == Component::Normal {
            t.max(0.0)
        } else {
            *t
        };
    }
    setup.admissible.bound_tangents(lambda);
}

/// The linear half: the bodies with a compliance between them, factored.
struct LinearHalf<'a> {
    setup: &'a Setup<'a>,
    /// a, (m,): the same for the tangents of a node, so that the law's disc is one in this metric, too.
    compliance: Vec<f64>,
    /// e of the rows of M, (k,).
    load: Vec<f64>,
    factored: Factored,
}

/// The factored matrices.
enum Factored {
    /// F + a = LLᵀ, Y = L⁻¹Mᵀ and YᵀY = L'L'ᵀ.
    Assembled {
        factor: Mat<f64>,
        modes: Mat<f64>,
        coarse: Mat<f64>,
    },
    /// diag(S, 0) + C D Cᵀ, and C by its columns.
    Parts {
        columns: Vec<SparseVector>,
        factor: Cholesky,
    },
}

impl<'a> LinearHalf<'a> {
    /// `None` where F is neither dense nor known by its bodies, and where a factorisation fails.
    fn new(setup: &'a Setup<'a>, compliance: Vec<f64>) -> Option<Self> {
        let factored = match &setup.problem.compliance {
            Compliance::Dense(matrix) => assembled(setup, matrix, &compliance),
            _ if !setup.problem.parts.is_empty() => by_parts(setup, &compliance),
            _ => None,
        };
        Some(Self {
            setup,
            compliance,
            load: setup.balance.rest_of_rows(setup.balance.target()),
            factored: factored?,
        })
    }

    /// x (m,) and β (k,) of the linear problem around `w` (m,).
    fn solve(&self, mut w: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
        let shift = &self.setup.shift;
        let mut load = self.load.clone();
        match &self.factored {
            Factored::Assembled {
                factor,
                modes,
                coarse,
            } => {
                // LLᵀx = b + Mᵀβ with b = d + aw, hence YᵀYβ = e − Yᵀ(L⁻¹b)
                for ((w, a), d) in w.iter_mut().zip(&self.compliance).zip(shift) {
                    *w = d + a * *w;
                }
                let mut right = Mat::from_fn(w.len(), 1, |i, _| w[i]);
                solve_lower_in_place(factor, &mut right);
                let half = right.col_as_slice_mut(0);
                for (j, load) in load.iter_mut().enumerate() {
                    *load -= dot(modes.col_as_slice(j), half);
                }
                solve_cholesky_in_place(coarse, &mut load);
                for (j, beta) in load.iter().enumerate() {
                    let column = modes.col_as_slice(j).iter();
                    half.iter_mut()
                        .zip(column)
                        .for_each(|(h, y)| *h += beta * y);
                }
                solve_lower_transpose_in_place(factor, &mut right);
                (right.col_as_slice(0).to_vec(), load)
            }
            Factored::Parts { columns, factor } => {
                for ((w, a), d) in w.iter_mut().zip(&self.compliance).zip(shift) {
                    *w += d / a;
                }
                let unknowns = columns.first().map_or(0, SparseVector::len);
                let mut q = vec![0.0; unknowns];
                q[unknowns - load.len()..].copy_from_slice(&load);
                for (column, w) in columns.iter().zip(&w) {
                    column.add_to(*w, &mut q);
                }
                factor.solve(&mut q);
                for ((w, a), column) in w.iter_mut().zip(&self.compliance).zip(columns) {
                    *w -= column.dot(&q) / a;
                }
                (w, q.split_off(unknowns - load.len()))
            }
        }
    }
}

/// Compliance of the contacts, (m,): the same for the tangents of a node.
fn local_compliance(setup: &Setup<'_>) -> Vec<f64> {
    let mut local = match setup.problem.parts.is_empty() {
        true => between_neighbours(setup),
        false => of_parts(setup),
    };
    for (block, range) in setup.admissible.iter() {
        if block.friction().is_some() {
            let tangents = &mut local[block.shear(&range)];
            let mean = tangents.iter().sum::<f64>() / tangents.len() as f64;
            tangents.fill(mean);
        }
    }
    local
}

/// Compliance of the contacts relative to their neighbours, at least a part of the median: where a floating body is grounded
/// the compliance is zero.
fn between_neighbours(setup: &Setup<'_>) -> Vec<f64> {
    let mut local = local_softness(setup);
    let mut sorted = local.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    local
        .iter_mut()
        .for_each(|c| *c = c.max(LEAST_OF_MEDIAN * usual));
    local
}

/// 1/s of the bodies that each contact presses, s the mean of the diagonal of the boundary stiffness.
fn of_parts(setup: &Setup<'_>) -> Vec<f64> {
    let mut local = vec![0.0; setup.len()];
    for part in &setup.problem.parts {
        let n = part.stiffness.nrows();
        let trace: f64 = (0..n).map(|i| part.stiffness[(i, i)]).sum();
        if trace > 0.0 {
            part.rows
                .iter()
                .for_each(|&row| local[row] += n as f64 / trace);
        }
    }
    // contacts between rigid parts
    let own = local.iter_mut().zip(&setup.problem.softness);
    own.for_each(|(c, softness)| *c = if *c > 0.0 { *c } else { *softness });
    local
}

fn assembled(setup: &Setup<'_>, matrix: &Mat<f64>, compliance: &[f64]) -> Option<Factored> {
    let mut factor = matrix.clone();
    for (i, a) in compliance.iter().enumerate() {
        factor[(i, i)] += a;
    }
    cholesky_in_place(&mut factor).ok()?;
    let rows = setup.balance.rows();
    let mut modes = Mat::from_fn(setup.len(), rows.len(), |i, j| rows[j][i]);
    solve_lower_in_place(&factor, &mut modes);
    let mut coarse = product(&modes.transpose().to_owned(), &modes);
    cholesky_in_place(&mut coarse).ok()?;
    Some(Factored::Assembled {
        factor,
        modes,
        coarse,
    })
}

fn by_parts(setup: &Setup<'_>, compliance: &[f64]) -> Option<Factored> {
    let parts = &setup.problem.parts;
    let displacements: usize = parts.iter().map(|part| part.stiffness.nrows()).sum();
    let unknowns = displacements + setup.modes();
    let mut entries = vec![Vec::new(); setup.len()];
    let mut first = 0;
    for part in parts {
        for (&row, column) in part.rows.iter().zip(&part.columns) {
            entries[row].extend(column.entries().map(|(i, b)| (first + i, b)));
        }
        first += part.stiffness.nrows();
    }
    let modes = setup.balance.columns().iter();
    let columns: Vec<SparseVector> = entries
        .into_iter()
        .zip(modes)
        .map(|(mut entries, modes)| {
            entries.extend(modes.entries().map(|(j, m)| (displacements + j, -m)));
            SparseVector::sum(unknowns, entries)
        })
        .collect();
    let mut triplets = gram_entries(unknowns, &columns, compliance);
    let mut first = 0;
    for part in parts {
        let n = part.stiffness.nrows();
        for j in 0..n {
            triplets.extend((j..n).map(|i| (first + i, first + j, part.stiffness[(i, j)])));
        }
        first += n;
    }
    let matrix = SymmetricMatrix::from_triplets(unknowns, &triplets);
    let edges = triplets.iter().filter(|(i, j, _)| i != j);
    let graph = Graph::of_edges(unknowns, edges.map(|&(i, j, _)| [i as u32, j as u32]));
    let order = fill_reducing_order(&graph, &vec![true; unknowns], &[]);
    let factor = Cholesky::factor(&matrix, &order, 0).ok()?;
    Some(Factored::Parts { columns, factor })
}

/// Entries (i, j ≤ i) of C D Cᵀ with D = 1/a, each once.
fn gram_entries(
    unknowns: usize,
    columns: &[SparseVector],
    compliance: &[f64],
) -> Vec<(usize, usize, f64)> {
    let mut met: Vec<Vec<(usize, f64)>> = vec![Vec::new(); unknowns];
    for (c, column) in columns.iter().enumerate() {
        column
            .entries()
            .for_each(|(i, value)| met[i].push((c, value)));
    }
    let mut row = vec![0.0; unknowns];
    let mut seen = vec![usize::MAX; unknowns];
    let mut triplets = Vec::new();
    for (i, met) in met.iter().enumerate() {
        let start = triplets.len();
        for &(c, value) in met {
            let weight = value / compliance[c];
            for (j, other) in columns[c].entries().take_while(|&(j, _)| j <= i) {
                if seen[j] != i {
                    seen[j] = i;
                    row[j] = 0.0;
                    triplets.push((i, j, 0.0));
                }
                row[j] += weight * other;
            }
        }
        for (_, j, value) in &mut triplets[start..] {
            *value = row[*j];
        }
    }
    triplets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{AdmissibleSet, Balance, DualProblem, Friction, Part, Scales};
    use crate::linalg::SparseMatrix;
    use crate::solve::tests::{apart, silent, times};
    use crate::solve::{FixedBounds, Newton};

    /// A row of `bodies` floating blocks between two walls, two frictional nodes at each of their joints, in space: each has
    /// six boundary displacements and three translations.
    fn row(bodies: usize, coefficient: f64) -> DualProblem {
        let joints = bodies + 1;
        let m = 6 * joints;
        let wave = |i: usize| (1.7 * i as f64 + 0.3).sin();
        let sign = |body: usize, joint: usize| match joint {
            _ if joint == body => Some(1.0),
            _ if joint == body + 1 => Some(-1.0),
            _ => None,
        };
        let parts: Vec<Part> = (0..bodies)
            .map(|body| {
                let rows: Vec<usize> = (6 * body..6 * body + 12).collect();
                let column = |&row: &usize| {
                    let sign = sign(body, row / 6).unwrap();
                    let own = |c: usize| (c, sign * (1.0 + 0.3 * wave(7 * row + c)));
                    let other = (row + 1) % 6;
                    SparseVector::sum(6, vec![own(row % 6), own(other)])
                };
                Part {
                    columns: rows.iter().map(column).collect(),
                    stiffness: Mat::from_fn(6, 6, |i, j| {
                        0.3 * wave(i + j) + if i == j { 4.0 } else { 0.0 }
                    }),
                    rows,
                }
            })
            .collect();
        let mut f = Mat::<f64>::zeros(m, m);
        for part in &parts {
            let mut factor = part.stiffness.clone();
            cholesky_in_place(&mut factor).unwrap();
            for (j, column) in part.rows.iter().zip(&part.columns) {
                let mut moved = column.to_dense();
                solve_cholesky_in_place(&factor, &mut moved);
                for (i, row) in part.rows.iter().zip(&part.columns) {
                    f[(*i, *j)] += row.dot(&moved);
                }
            }
        }
        let modes = Mat::from_fn(3 * bodies, m, |mode, i| match sign(mode / 3, i / 6) {
            Some(sign) if i % 3 == mode % 3 => sign,
            _ => 0.0,
        });
        let shift: Vec<f64> = (0..m)
            .map(|i| {
                if i % 3 == 0 {
                    1.0 + 0.2 * wave(i)
                } else {
                    0.2 * wave(i)
                }
            })
            .collect();
        let load = (0..3 * bodies).map(|i| if i % 3 == 0 { 0.0 } else { 0.02 * wave(i) });
        let balance = Balance::new(modes, load.collect());
        let block = Friction::Coulomb { coefficient }.block(2);
        let set = AdmissibleSet::new(vec![block; 2 * joints]);
        let sparse = Compliance::Sparse(SparseMatrix::from_dense(&f));
        let scales = Scales::of(&shift, &balance);
        let mut problem = DualProblem::new(sparse, shift, set, balance).unwrap();
        problem.scales = scales;
        problem.parts = parts;
        problem
    }

    #[test]
    fn the_linear_half_is_solved_alike_by_bodies_and_as_a_whole() {
        for bodies in [2, 40] {
            let mut problem = row(bodies, 0.4);
            let f = match &problem.compliance {
                Compliance::Sparse(matrix) => matrix.to_dense(),
                _ => unreachable!(),
            };
            let w: Vec<f64> = (0..f.nrows()).map(|i| (0.9 * i as f64).cos()).collect();
            let mut found = Vec::new();
            for dense in [false, true] {
                let setup = Setup::unchecked(&problem);
                assert_eq!(setup.balance.is_orthonormal(), bodies == 2);
                let own = row(bodies, 0.4);
                let compliance = local_compliance(&Setup::unchecked(&own));
                let mut half = LinearHalf::new(&setup, compliance).unwrap();
                if dense {
                    half.factored = assembled(&setup, &f, &half.compliance).unwrap();
                }
                let (x, beta) = half.solve(w.clone());
                // (F + a) x − Gᵀα = d + a w and Gx = e
                let mut left = times(&f, &x);
                let alpha = setup.balance.from_rows(beta);
                setup.balance.add_transposed(-1.0, &alpha, &mut left);
                for i in 0..x.len() {
                    left[i] += half.compliance[i] * (x[i] - w[i]) - setup.shift[i];
                }
                assert!(apart(&left, &vec![0.0; x.len()]) < 1e-11, "{bodies}");
                let carried = problem.balance.modes().product(&x);
                assert!(apart(&carried, problem.balance.load()) < 1e-11, "{bodies}");
                found.push(x);
                problem.compliance = Compliance::Dense(f.clone());
            }
            assert!(apart(&found[0], &found[1]) < 1e-11);
        }
    }

    #[test]
    fn a_crowd_is_solved_without_a_guess_of_states() {
        for coefficient in [0.05, 0.5] {
            let problem = row(40, coefficient);
            assert!(problem.is_crowd());
            let setup = Setup::new(&problem).unwrap();
            let mut search = Search::new(Newton::default().limits(), &setup);
            let states = search.all_closed();
            let ended = alternate(&mut search, states, &mut silent);
            assert!(matches!(ended, Ended::Converged), "{coefficient}");
            let answer = search.outcome(false).multipliers;
            let certificate = problem.certify(&answer, 1e-8);
            assert!(certificate.holds(), "{certificate}");
            assert!(search.steps <= 20, "{}", search.steps);
        }
    }

    #[test]
    fn few_bodies_are_handed_over_to_exact_steps_once_states_settle() {
        for (bodies, coefficient) in [(4, 0.05), (12, 0.5), (24, 0.3)] {
            let mut problem = row(bodies, coefficient);
            assert!(problem.assemble(1000));
            let setup = Setup::new(&problem).unwrap();
            let mut search = Search::new(Newton::default().limits(), &setup);
            let states = search.all_closed();
            let ended = alternate(&mut search, states, &mut silent);
            assert!(matches!(ended, Ended::Converged), "{bodies}");
            assert_eq!(search.kind, 'n', "{bodies}");
            assert!(search.steps <= 12, "{bodies}: {}", search.steps);
            // after exact steps closed gaps are rounding
            let gap = &search.judge.gap;
            let closed = (0..setup.len())
                .step_by(3)
                .filter(|&i| search.point.lambda[i] > 0.0);
            assert!(closed.fold(0.0, |s: f64, i| s.max(gap[i].abs())) < 1e-12);
        }
    }

    #[test]
    fn forces_short_of_the_last_digits_are_balanced() {
        let problem = row(40, 0.5);
        let setup = Setup::new(&problem).unwrap();
        for tolerance in [1e-2, 1e-4, 1e-6] {
            let newton = Newton {
                tolerance,
                ..Newton::default()
            };
            let mut search = Search::new(newton.limits(), &setup);
            let states = search.all_closed();
            let ended = alternate(&mut search, states, &mut silent);
            assert!(matches!(ended, Ended::Converged), "{tolerance}");
            assert!(search.residual <= tolerance);
            let answer = search.outcome(false).multipliers;
            let certificate = problem.certify(&answer, tolerance);
            assert!(certificate.imbalance_force.holds(), "{certificate}");
        }
    }

    #[test]
    fn shears_are_bounded_by_the_normal_force_of_the_same_trial() {
        let problem = row(2, 0.5);
        let setup = Setup::unchecked(&problem);
        let mut trial = vec![0.0; setup.len()];
        trial[..6].copy_from_slice(&[2.0, 3.0, -4.0, -1.0, 0.1, 0.2]);
        trial[6..9].copy_from_slice(&[2.0, 0.3, -0.4]);
        let mut lambda = vec![9.0; setup.len()];
        by_law(&setup, &trial, &mut lambda);
        assert!(apart(&lambda[..3], &[2.0, 0.6, -0.8]) < 1e-15);
        assert_eq!(lambda[3..6], [0.0; 3]);
        assert_eq!(lambda[6..9], [2.0, 0.3, -0.4]);
    }

    #[test]
    fn a_compliance_that_is_only_applied_is_left_to_others() {
        let mut problem = row(2, 0.5);
        problem.parts.clear();
        let setup = Setup::unchecked(&problem);
        let mut search = Search::new(Newton::default().limits(), &setup);
        let states = search.all_closed();
        let ended = alternate(&mut search, states.clone(), &mut silent);
        let Ended::Stuck(same) = ended else {
            panic!("there is nothing to factor");
        };
        assert_eq!((same, search.steps), (states, 0));
        // a crowd with an unknown F is not left to it alone either
        let mut many = row(40, 0.5);
        assert!(many.is_crowd());
        many.parts.clear();
        assert!(!many.is_crowd());
    }

    #[test]
    fn tangents_of_a_node_have_one_compliance_and_grounded_ones_are_not_stiff() {
        let mut problem = row(2, 0.5);
        problem.parts.clear();
        let m = problem.shift.len();
        problem.softness = (0..m).map(|i| [1.0, 0.0, 2.0][i % 3]).collect();
        let setup = Setup::unchecked(&problem);
        let found = local_compliance(&setup);
        // the tangent with zero compliance counts as a part of the median, 1
        let expected: Vec<f64> = (0..m)
            .map(|i| {
                if i % 3 == 0 {
                    1.0
                } else {
                    0.5 * (LEAST_OF_MEDIAN + 2.0)
                }
            })
            .collect();
        assert!(apart(&found, &expected) < 1e-15, "{found:?}");
    }
}
