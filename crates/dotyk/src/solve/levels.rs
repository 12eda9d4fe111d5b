//! Starting points from coarser problems: neighbouring contact nodes as one, solved, and what came out spread again.
//!
//! ```text
//!   λ = Pλ', every node of a cluster bears an equal part;   F' = PᵀFP,  d' = Pᵀd,  G' = GP
//! ```
//!
//! Newton's method moves the edge of a contact by a few nodes in each step, however fine the mesh: its steps grow with the
//! number of nodes. On the coarsest problem these are few and cheap, and from there each finer one begins with a contact
//! that is right to a node. Clusters are pairs of neighbours; contacts with few nodes stay as they are.

use std::ops::ControlFlow;

use crate::dual::{AdmissibleSet, Block, Compliance, DualProblem, Equilibrium};
use crate::linalg::Mat;
use crate::solve::states::State;
use crate::solve::{Newton, Observer, Outcome, Setup, SolveError};

/// Connected contacts with at most this many blocks stay as they are.
const FEW: usize = 8;

/// A coarser problem must have at most this part of the blocks to be worth its solves.
const WORTH: f64 = 0.75;

/// Accuracy of a coarser problem: its answer is a guess.
const ACCURACY: f64 = 1e-4;

/// Most linear solves on a coarser problem.
const STEPS: usize = 40;

/// Where to begin.
pub(crate) struct Start {
    /// λ, (m,).
    pub lambda: Vec<f64>,
    /// α̂, (k,).
    pub alpha: Vec<f64>,
    pub states: Vec<State>,
    /// Linear solves, each counted by its share of unknowns.
    pub steps: f64,
}

/// Solves a coarser problem by `solve`; `None` where there is none, or it has no answer.
pub(crate) fn start(
    setup: &Setup<'_>,
    solve: impl Fn(&Newton, &Setup<'_>, Observer<'_>) -> Result<Outcome, SolveError>,
) -> Option<Start> {
    let problem = setup.problem;
    let Compliance::Dense(matrix) = &problem.compliance else {
        return None;
    };
    let blocks = setup.admissible.blocks();
    if problem.neighbours.is_empty() {
        return None;
    }
    let clusters = Clusters::pairs(&setup.admissible, &problem.neighbours);
    if clusters.members.len() as f64 > WORTH * blocks.len() as f64 {
        return None;
    }
    let coarse = clusters.problem(setup, matrix)?;
    let coarse_setup = Setup::new(&coarse).ok()?;
    let method = Newton {
        tolerance: ACCURACY,
        max_iterations: STEPS,
    };
    let outcome = match solve(&method, &coarse_setup, &mut |_| ControlFlow::Continue(())) {
        Ok(outcome) => outcome,
        // a guess that is rough is still one
        Err(SolveError::NotConverged { outcome, .. }) => *outcome,
        Err(_) => return None,
    };
    let found = &outcome.multipliers;
    if !found
        .lambda
        .iter()
        .chain(&found.alpha)
        .all(|x| x.is_finite())
    {
        return None;
    }
    let lambda = clusters.spread(&setup.admissible, &coarse.admissible, &found.lambda);
    let mut alpha = vec![0.0; setup.modes()];
    setup.balance.from_original(&found.alpha, &mut alpha);
    let share = coarse.len() as f64 / setup.len() as f64;
    Some(Start {
        states: clusters.states(&setup.admissible, &problem.neighbours, &lambda),
        lambda,
        alpha,
        steps: share * outcome.iterations as f64,
    })
}

/// Blocks that become one.
struct Clusters {
    /// Blocks of each cluster, one or two.
    members: Vec<Vec<usize>>,
    /// Cluster of each block.
    of: Vec<usize>,
}

impl Clusters {
    /// Pairs of neighbours of one kind, in the order of the blocks.
    fn pairs(admissible: &AdmissibleSet, neighbours: &[[usize; 2]]) -> Self {
        let blocks = admissible.blocks();
        let mut beside: Vec<Vec<usize>> = vec![Vec::new(); blocks.len()];
        for &[a, b] in neighbours {
            beside[a].push(b);
            beside[b].push(a);
        }
        let sizes = component_sizes(&beside);
        let kind = |block: usize| std::mem::discriminant(&blocks[block]);
        let alike = |a: usize, b: usize| kind(a) == kind(b) && blocks[a].size() == blocks[b].size();
        let mut clusters = Self {
            members: Vec::new(),
            of: vec![usize::MAX; blocks.len()],
        };
        for block in 0..blocks.len() {
            if clusters.of[block] != usize::MAX {
                continue;
            }
            let open = |other: &&usize| {
                clusters.of[**other] == usize::MAX && **other != block && alike(block, **other)
            };
            let partner = match sizes[block] > FEW {
                true => beside[block].iter().filter(open).min().copied(),
                false => None,
            };
            let members: Vec<usize> = std::iter::once(block).chain(partner).collect();
            for &member in &members {
                clusters.of[member] = clusters.members.len();
            }
            clusters.members.push(members);
        }
        clusters
    }

    /// The problem of the clusters; `None` where its data are not those of a problem.
    fn problem(&self, setup: &Setup<'_>, matrix: &Mat<f64>) -> Option<DualProblem> {
        let fine = setup.problem;
        let admissible = self.admissible(&setup.admissible);
        let m = admissible.len();
        // component of λ' that each component of λ is a part of, and the part
        let mut place = vec![(0, 0.0); setup.len()];
        for (cluster, members) in self.members.iter().enumerate() {
            let share = 1.0 / members.len() as f64;
            for &member in members {
                let to = admissible.range(cluster);
                for (from, to) in setup.admissible.range(member).zip(to) {
                    place[from] = (to, share);
                }
            }
        }
        let mut compliance = Mat::zeros(m, m);
        for (j, &(to_j, share_j)) in place.iter().enumerate() {
            let from = matrix.col_as_slice(j);
            let to = compliance.col_as_slice_mut(to_j);
            for (f, &(to_i, share_i)) in from.iter().zip(&place) {
                to[to_i] += share_i * share_j * f;
            }
        }
        let mut shift = vec![0.0; m];
        let modes = &fine.equilibrium.modes;
        let mut reduced = Mat::zeros(modes.nrows(), m);
        for (i, &(to, share)) in place.iter().enumerate() {
            shift[to] += share * fine.shift[i];
            let from = modes.col_as_slice(i).iter();
            let column = reduced.col_as_slice_mut(to).iter_mut();
            column.zip(from).for_each(|(to, g)| *to += share * g);
        }
        let equilibrium = Equilibrium {
            modes: reduced,
            load: fine.equilibrium.load.clone(),
            moments: fine.equilibrium.moments.clone(),
        };
        let compliance = Compliance::Dense(compliance);
        let mut problem = DualProblem::new(compliance, shift, admissible, equilibrium).ok()?;
        problem.scales = fine.scales;
        let joined = fine
            .neighbours
            .iter()
            .map(|pair| pair.map(|block| self.of[block]));
        let mut joined: Vec<[usize; 2]> = joined
            .filter(|[a, b]| a != b)
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        joined.sort_unstable();
        joined.dedup();
        problem.neighbours = joined;
        Some(problem)
    }

    /// Bounds add up, coefficients are means.
    fn admissible(&self, fine: &AdmissibleSet) -> AdmissibleSet {
        let cluster = |members: &Vec<usize>| {
            let blocks = members.iter().map(|&member| fine.blocks()[member]);
            let value = |block: Block| match block {
                Block::Tresca { bound, .. } => bound,
                Block::Coulomb { coefficient, .. } => coefficient,
                Block::Free { .. } | Block::Unilateral => 0.0,
            };
            let sum: f64 = blocks.map(value).sum();
            match fine.blocks()[members[0]] {
                Block::Tresca { tangents, .. } => Block::Tresca {
                    tangents,
                    bound: sum,
                },
                Block::Coulomb { tangents, .. } => Block::Coulomb {
                    tangents,
                    coefficient: sum / members.len() as f64,
                },
                other => other,
            }
        };
        AdmissibleSet::new(self.members.iter().map(cluster).collect())
    }

    /// Pλ'.
    fn spread(&self, fine: &AdmissibleSet, coarse: &AdmissibleSet, forces: &[f64]) -> Vec<f64> {
        let mut lambda = vec![0.0; fine.len()];
        for (cluster, members) in self.members.iter().enumerate() {
            for &member in members {
                let to = fine.range(member);
                for (to, from) in to.zip(coarse.range(cluster)) {
                    lambda[to] = forces[from] / members.len() as f64;
                }
            }
        }
        lambda
    }

    /// States of spread forces, contacts widened by one node.
    fn states(
        &self,
        admissible: &AdmissibleSet,
        neighbours: &[[usize; 2]],
        lambda: &[f64],
    ) -> Vec<State> {
        let blocks = admissible.iter();
        let mut states: Vec<State> = blocks
            .map(|(block, range)| {
                let mut trial = lambda[range].to_vec();
                trial[1..].iter_mut().for_each(|t| *t *= 1.0 + 1e-6);
                State::of_trial(block, &trial)
            })
            .collect();
        let closed: Vec<bool> = states.iter().map(|state| state.closed).collect();
        for &[a, b] in neighbours {
            for (open, beside) in [(a, b), (b, a)] {
                if !closed[open] && closed[beside] && !states[open].closed {
                    states[open] = State::sticking(&admissible.blocks()[open], true);
                }
            }
        }
        states
    }
}

/// Number of blocks that each block is connected with, itself counted.
fn component_sizes(beside: &[Vec<usize>]) -> Vec<usize> {
    let mut component = vec![usize::MAX; beside.len()];
    let mut counts = Vec::new();
    for first in 0..beside.len() {
        if component[first] != usize::MAX {
            continue;
        }
        let own = counts.len();
        let mut open = vec![first];
        component[first] = own;
        let mut count = 0;
        while let Some(block) = open.pop() {
            count += 1;
            for &next in &beside[block] {
                if component[next] == usize::MAX {
                    component[next] = own;
                    open.push(next);
                }
            }
        }
        counts.push(count);
    }
    component.into_iter().map(|c| counts[c]).collect()
}

/// What every component gives way while its neighbours stay behind, (m,), length over force: wᵀFw with w one there and
/// minus the mean of the neighbours. Slender bodies give way as a whole far more than from node to node.
pub(crate) fn local_softness(setup: &Setup<'_>) -> Vec<f64> {
    let problem = setup.problem;
    let mut local = problem.softness.clone();
    let Compliance::Dense(matrix) = &problem.compliance else {
        return local;
    };
    let blocks = setup.admissible.blocks();
    let mut beside: Vec<Vec<usize>> = vec![Vec::new(); blocks.len()];
    for &[a, b] in &problem.neighbours {
        if blocks[a].size() == blocks[b].size() {
            beside[a].push(b);
            beside[b].push(a);
        }
    }
    for (block, others) in beside
        .iter()
        .enumerate()
        .filter(|(_, others)| !others.is_empty())
    {
        let range = setup.admissible.range(block);
        let part = -1.0 / others.len() as f64;
        let starts = others
            .iter()
            .map(|&other| setup.admissible.range(other).start);
        let starts: Vec<usize> = starts.collect();
        for (component, i) in range.enumerate() {
            let own = [(i, 1.0)].into_iter();
            let w: Vec<(usize, f64)> = own
                .chain(starts.iter().map(|start| (start + component, part)))
                .collect();
            let product = |&(a, wa): &(usize, f64)| -> f64 {
                w.iter().map(|&(b, wb)| wa * wb * matrix[(a, b)]).sum()
            };
            let value: f64 = w.iter().map(product).sum();
            local[i] = value.clamp(LEAST * local[i], local[i]);
        }
    }
    local
}

/// Below this part of its own softness a difference is rounding.
const LEAST: f64 = 1e-12;
