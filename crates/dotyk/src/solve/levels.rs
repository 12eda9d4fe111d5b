//! Starting points from coarser problems: neighbouring contact nodes as one, solved, and what came out spread again.
//!
//! ```text
//!   λ = Pλ', every node of a cluster bears an equal part;   F' = PᵀFP,  d' = Pᵀd,  G' = GP
//! ```
//!
//! Newton's method moves the edge of a contact by a few nodes in each step, however fine the mesh: its steps grow with the
//! number of nodes. On a coarse problem these are few and cheap, and from there a finer one begins with a contact that is
//! right to a node.
//!
//! Assembled F: clusters are pairs of neighbours, and the coarser problem begins from a coarser one itself. Applied F, where
//! every column of FP costs a solve with the bodies: the clusters are a cut through the tree of pairs of pairs, coarse at
//! first and then finer where contacts end or begin to slip, which takes few columns.

use std::collections::HashMap;
use std::mem::discriminant;
use std::ops::ControlFlow;

use crate::dual::{
    AdmissibleSet, Balance, Block, Compliance, DualProblem, Friction, Modes, Multipliers,
};
use crate::linalg::{LinearOperator, Mat, SparseVector};
use crate::solve::setup::Setup;
use crate::solve::states::State;
use crate::solve::{Observer, Outcome, SolveError};

/// Connected contacts with at most this many blocks stay as they are.
const FEW: usize = 8;

/// A coarser problem must have at most this part of the blocks to be worth its solves.
const WORTH: f64 = 0.75;

/// Accuracy of a coarser problem: its answer is a guess.
const ACCURACY: f64 = 1e-4;

/// Most linear solves on a coarser problem.
const STEPS: usize = 40;

/// Applied F: blocks of the coarsest problem and how many times fewer these must be, most columns of FP, by how many pairings
/// clusters become finer at once, and up to how many clusters beside a change of states.
const COARSEST: usize = 64;
const FEWER: usize = 4;
const COLUMNS: usize = 1024;
const FINER: usize = 2;
const BESIDE: usize = 2;

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

/// Solves coarser problems by `solve`; `None` where there are none, or the last of them has no answer.
pub(crate) fn start(setup: &Setup<'_>, solve: CoarseSolver<'_>) -> Option<Start> {
    let problem = setup.problem;
    if problem.neighbours.is_empty() {
        return None;
    }
    match &problem.compliance {
        Compliance::Dense(matrix) => {
            let members = pairs(setup.admissible.blocks(), &problem.neighbours);
            if members.len() as f64 > WORTH * setup.admissible.blocks().len() as f64 {
                return None;
            }
            let clusters = Clusters::new(members, setup);
            let found = clusters.solve(setup, clusters.reduced(matrix), solve)?;
            Some(clusters.start(setup, &found))
        }
        Compliance::Sparse(_) => None,
        Compliance::Operator { apply, .. } => Cut::new(setup)?.refine(setup, &**apply, solve),
    }
}

/// Solves a coarser problem to a residual, with at most that many linear solves.
pub(crate) type CoarseSolver<'a> =
    &'a dyn Fn((f64, usize), &Setup<'_>, Observer<'_>) -> Result<Outcome, SolveError>;

/// Blocks of each cluster: pairs of neighbours of one kind, in the order of the blocks; some remain alone.
fn pairs(blocks: &[Block], neighbours: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let beside = beside(blocks.len(), neighbours);
    let sizes = component_sizes(&beside);
    let kind = |block: usize| {
        let (block, law) = (&blocks[block], blocks[block].friction());
        (
            block.size(),
            discriminant(block),
            law.as_ref().map(discriminant),
        )
    };
    let alike = |a: usize, b: usize| kind(a) == kind(b);
    let mut members: Vec<Vec<usize>> = Vec::new();
    let mut taken = vec![false; blocks.len()];
    for block in 0..blocks.len() {
        if taken[block] {
            continue;
        }
        let open = |other: &&usize| !taken[**other] && **other != block && alike(block, **other);
        let partner = match sizes[block] > FEW {
            true => beside[block].iter().filter(open).min().copied(),
            false => None,
        };
        let pair: Vec<usize> = std::iter::once(block).chain(partner).collect();
        pair.iter().for_each(|&member| taken[member] = true);
        members.push(pair);
    }
    members
}

/// Neighbours of every one of `count` blocks.
fn beside(count: usize, neighbours: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let mut beside: Vec<Vec<usize>> = vec![Vec::new(); count];
    for &[a, b] in neighbours {
        beside[a].push(b);
        beside[b].push(a);
    }
    beside
}

/// Neighbours of clusters, each pair once; `of` is the cluster of each block.
fn joined(neighbours: &[[usize; 2]], of: &[usize]) -> Vec<[usize; 2]> {
    let pairs = neighbours.iter().map(|pair| pair.map(|block| of[block]));
    let pairs = pairs.filter(|[a, b]| a != b);
    let mut joined: Vec<[usize; 2]> = pairs.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    joined.sort_unstable();
    joined.dedup();
    joined
}

/// Blocks that become one.
struct Clusters {
    /// Λ of the clusters: bounds add up, coefficients are means.
    admissible: AdmissibleSet,
    neighbours: Vec<[usize; 2]>,
    /// Component of λ' that each component of λ is a part of, and the part.
    place: Vec<(usize, f64)>,
}

/// A coarser problem and what came out.
struct Coarse {
    outcome: Outcome,
    /// Its solves, each counted by its share of unknowns.
    steps: f64,
}

impl Clusters {
    fn new(members: Vec<Vec<usize>>, setup: &Setup<'_>) -> Self {
        let fine = &setup.admissible;
        let together = members.iter().map(|members| together(fine, members));
        let admissible = AdmissibleSet::new(together.collect());
        let mut of = vec![0; fine.blocks().len()];
        let mut place = vec![(0, 0.0); setup.len()];
        for (cluster, members) in members.iter().enumerate() {
            let share = 1.0 / members.len() as f64;
            for &member in members {
                of[member] = cluster;
                for (from, to) in fine.range(member).zip(admissible.range(cluster)) {
                    place[from] = (to, share);
                }
            }
        }
        Self {
            neighbours: joined(&setup.problem.neighbours, &of),
            admissible,
            place,
        }
    }

    /// PᵀFP.
    fn reduced(&self, matrix: &Mat<f64>) -> Mat<f64> {
        let m = self.admissible.len();
        let mut compliance = Mat::zeros(m, m);
        for (j, &(to_j, share_j)) in self.place.iter().enumerate() {
            let from = matrix.col_as_slice(j);
            let to = compliance.col_as_slice_mut(to_j);
            for (f, &(to_i, share_i)) in from.iter().zip(&self.place) {
                to[to_i] += share_i * share_j * f;
            }
        }
        compliance
    }

    /// Solves the problem of the clusters, whose compliance is given; `None` where it has no answer.
    fn solve(
        &self,
        setup: &Setup<'_>,
        compliance: Mat<f64>,
        solve: CoarseSolver<'_>,
    ) -> Option<Coarse> {
        let coarse = self.problem(setup, compliance)?;
        let coarse_setup = Setup::new(&coarse).ok()?;
        let limits = (ACCURACY, STEPS);
        let outcome = match solve(limits, &coarse_setup, &mut |_| ControlFlow::Continue(())) {
            Ok(outcome) => outcome,
            // a guess that is rough is still one
            Err(SolveError::NotConverged { outcome, .. }) => *outcome,
            Err(_) => return None,
        };
        let Multipliers { lambda, alpha } = &outcome.multipliers;
        let finite = lambda.iter().chain(alpha).all(|x| x.is_finite());
        let share = coarse.len() as f64 / setup.len() as f64;
        finite.then_some(Coarse {
            steps: share * outcome.iterations as f64,
            outcome,
        })
    }

    /// The problem of the clusters; `None` where its data are not those of a problem.
    fn problem(&self, setup: &Setup<'_>, compliance: Mat<f64>) -> Option<DualProblem> {
        let fine = setup.problem;
        let m = self.admissible.len();
        let mut shift = vec![0.0; m];
        let modes = fine.balance.modes();
        let mut sums: Vec<Vec<(usize, f64)>> = vec![Vec::new(); m];
        for (i, &(to, share)) in self.place.iter().enumerate() {
            shift[to] += share * fine.shift[i];
            let parts = modes.column(i).entries();
            sums[to].extend(parts.map(|(row, g)| (row, share * g)));
        }
        let columns = sums.into_iter();
        let columns = columns.map(|parts| SparseVector::sum(modes.nrows(), parts));
        let modes = Modes::new(modes.nrows(), columns.collect());
        let balance = Balance::new(modes, fine.balance.load().to_vec())
            .with_moments(fine.balance.moments().to_vec());
        let compliance = Compliance::Dense(compliance);
        let admissible = self.admissible.clone();
        let mut problem = DualProblem::new(compliance, shift, admissible, balance).ok()?;
        problem.scales = fine.scales;
        problem.neighbours = self.neighbours.clone();
        Some(problem)
    }

    /// Where the fine problem begins.
    fn start(&self, setup: &Setup<'_>, found: &Coarse) -> Start {
        let forces = &found.outcome.multipliers;
        let part = |&(to, share): &(usize, f64)| share * forces.lambda[to];
        let lambda: Vec<f64> = self.place.iter().map(part).collect();
        let mut alpha = vec![0.0; setup.modes()];
        setup.balance.from_original(&forces.alpha, &mut alpha);
        let mut states = State::of_all_forces(&setup.admissible, &lambda);
        widen(&mut states, &setup.admissible, &setup.problem.neighbours);
        Start {
            lambda,
            alpha,
            states,
            steps: found.steps,
        }
    }
}

/// The law of blocks that are one.
fn together(fine: &AdmissibleSet, members: &[usize]) -> Block {
    let laws = members
        .iter()
        .filter_map(|&member| fine.blocks()[member].friction());
    let laws: Vec<Friction> = laws.collect();
    fine.blocks()[members[0]].with_friction(|law| law.together(&laws))
}

/// Contacts become wider by one node, which does what the one beside it does: sticking, it would drag at the others.
fn widen(states: &mut [State], admissible: &AdmissibleSet, neighbours: &[[usize; 2]]) {
    let before = states.to_vec();
    for &[a, b] in neighbours {
        for (open, beside) in [(a, b), (b, a)] {
            let alike = admissible.blocks()[open].size() == admissible.blocks()[beside].size();
            if alike && !before[open].closed && before[beside].closed {
                states[open] = before[beside].clone();
            }
        }
    }
}

// Applied F

/// The tree of pairs of pairs, and clusters that are a cut through it.
struct Cut {
    /// Fine blocks of each node of the tree, and what it was made of.
    blocks: Vec<Vec<usize>>,
    children: Vec<Vec<usize>>,
    /// Nodes of the tree that are the clusters.
    cut: Vec<usize>,
    /// F times the columns of P of a node, one for each component.
    columns: HashMap<usize, Vec<Vec<f64>>>,
}

impl Cut {
    /// The coarsest clusters; `None` where these are not few.
    fn new(setup: &Setup<'_>) -> Option<Self> {
        let fine = &setup.admissible;
        let count = fine.blocks().len();
        let mut tree = Self {
            blocks: (0..count).map(|block| vec![block]).collect(),
            children: vec![Vec::new(); count],
            cut: (0..count).collect(),
            columns: HashMap::new(),
        };
        let mut neighbours = setup.problem.neighbours.clone();
        while tree.cut.len() > COARSEST {
            let laws = tree
                .cut
                .iter()
                .map(|&node| together(fine, &tree.blocks[node]));
            let laws: Vec<Block> = laws.collect();
            let members = pairs(&laws, &neighbours);
            if members.len() as f64 > WORTH * tree.cut.len() as f64 {
                break;
            }
            let mut of = vec![0; tree.cut.len()];
            let mut next = Vec::with_capacity(members.len());
            for (cluster, members) in members.iter().enumerate() {
                members.iter().for_each(|&member| of[member] = cluster);
                next.push(tree.join(members));
            }
            tree.cut = next;
            neighbours = joined(&neighbours, &of);
        }
        (FEWER * tree.cut.len() <= count).then_some(tree)
    }

    /// The node of the tree that some places of the cut become.
    fn join(&mut self, places: &[usize]) -> usize {
        let nodes: Vec<usize> = places.iter().map(|&place| self.cut[place]).collect();
        if let [node] = nodes[..] {
            return node;
        }
        let blocks = nodes.iter().flat_map(|&node| self.blocks[node].clone());
        self.blocks.push(blocks.collect());
        self.children.push(nodes);
        self.blocks.len() - 1
    }

    /// Solves the problem of the clusters, again and again, finer where states change.
    fn refine(
        mut self,
        setup: &Setup<'_>,
        matrix: &dyn LinearOperator,
        solve: CoarseSolver<'_>,
    ) -> Option<Start> {
        let mut steps = 0.0;
        let mut last = None;
        while self.fill(setup, matrix) {
            let members = self.cut.iter().map(|&node| self.blocks[node].clone());
            let clusters = Clusters::new(members.collect(), setup);
            let compliance = self.compliance(&clusters);
            let Some(found) = clusters.solve(setup, compliance, solve) else {
                break;
            };
            steps += found.steps;
            let start = clusters.start(setup, &found);
            last = Some(Start { steps, ..start });
            let states =
                State::of_all_forces(&clusters.admissible, &found.outcome.multipliers.lambda);
            if !self.split(&clusters, &states) {
                break;
            }
        }
        last
    }

    /// Finds the columns of F that the cut needs; `false` where they are too many.
    fn fill(&mut self, setup: &Setup<'_>, matrix: &dyn LinearOperator) -> bool {
        let fine = &setup.admissible;
        let open = self
            .cut
            .iter()
            .filter(|node| !self.columns.contains_key(*node));
        let open: Vec<usize> = open.copied().collect();
        let size = |node: usize| fine.blocks()[self.blocks[node][0]].size();
        let count: usize = open.iter().map(|&node| size(node)).sum();
        if self.columns.values().map(Vec::len).sum::<usize>() + count > COLUMNS {
            return false;
        }
        let mut forces = Mat::zeros(setup.len(), count);
        let mut next = 0;
        for &node in &open {
            let share = 1.0 / self.blocks[node].len() as f64;
            for &block in &self.blocks[node] {
                for (component, i) in fine.range(block).enumerate() {
                    forces[(i, next + component)] = share;
                }
            }
            next += size(node);
        }
        let gaps = matrix.apply_many(&forces);
        setup.count(count);
        let mut next = 0;
        for &node in &open {
            let own = next..next + size(node);
            next = own.end;
            let columns = own.map(|column| gaps.col_as_slice(column).to_vec());
            self.columns.insert(node, columns.collect());
        }
        true
    }

    /// PᵀFP of the cut.
    fn compliance(&self, clusters: &Clusters) -> Mat<f64> {
        let m = clusters.admissible.len();
        let mut compliance = Mat::<f64>::zeros(m, m);
        let columns = self.cut.iter().flat_map(|node| &self.columns[node]);
        for (j, column) in columns.enumerate() {
            let to = compliance.col_as_slice_mut(j);
            for (gap, &(i, share)) in column.iter().zip(&clusters.place) {
                to[i] += share * gap;
            }
        }
        Mat::from_fn(m, m, |i, j| 0.5 * (compliance[(i, j)] + compliance[(j, i)]))
    }

    /// Makes clusters finer that are beside a change of states; `false` where there are none.
    fn split(&mut self, clusters: &Clusters, states: &[State]) -> bool {
        let mut near: Vec<bool> = vec![false; states.len()];
        for &[a, b] in &clusters.neighbours {
            if states[a].key() != states[b].key() {
                (near[a], near[b]) = (true, true);
            }
        }
        for _ in 1..BESIDE {
            let before = near.clone();
            for &[a, b] in &clusters.neighbours {
                near[a] |= before[b];
                near[b] |= before[a];
            }
        }
        let mut finer = false;
        let mut cut = Vec::new();
        for (&node, near) in self.cut.iter().zip(near) {
            let mut parts = vec![node];
            for _ in 0..if near { FINER } else { 0 } {
                let halves = parts.iter().map(|&part| match &self.children[part][..] {
                    [] => vec![part],
                    halves => halves.to_vec(),
                });
                parts = halves.flatten().collect();
            }
            finer |= parts != [node];
            cut.extend(parts);
        }
        self.cut = cut;
        finer
    }
}

/// Number of blocks that each block is connected with, itself counted.
fn component_sizes(beside: &[Vec<usize>]) -> Vec<usize> {
    let mut sizes = vec![0; beside.len()];
    for first in 0..beside.len() {
        if sizes[first] != 0 {
            continue;
        }
        sizes[first] = 1;
        let (mut met, mut next) = (vec![first], 0);
        while next < met.len() {
            for &other in &beside[met[next]] {
                if sizes[other] == 0 {
                    sizes[other] = 1;
                    met.push(other);
                }
            }
            next += 1;
        }
        met.iter().for_each(|&block| sizes[block] = met.len());
    }
    sizes
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
    let alike = |&[a, b]: &[usize; 2]| blocks[a].size() == blocks[b].size();
    let neighbours = problem.neighbours.iter().copied().filter(alike);
    let beside = beside(blocks.len(), &neighbours.collect::<Vec<_>>());
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
