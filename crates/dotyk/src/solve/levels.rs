//! Starting points from coarser problems: neighbouring contact nodes act as one, and the solution is spread over them again.
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
const COARSE_STEPS: usize = 40;

/// Applied F: most blocks of the coarsest problem; the least ratio of fine to coarse blocks; most columns of FP; by how many
/// pairings clusters become finer at once; and up to how many clusters away from a change of states.
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
    /// The coarser problem has an answer and did not stall.
    pub solved: bool,
    /// Linear solves, each counted by its share of unknowns.
    pub steps: f64,
}

/// Solves coarser problems by `solve`; `None` where there is no coarser problem, or the last one has no answer.
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
        // a product with bodies in pieces costs as much as a rough step
        Compliance::Operator { glue: Some(_), .. } => None,
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

/// Neighbours of each of `count` blocks.
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

/// A coarser problem and its answer.
struct Coarse {
    outcome: Outcome,
    solved: bool,
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

    /// Solves the problem of the clusters with the given compliance; `None` where it has no answer.
    fn solve(
        &self,
        setup: &Setup<'_>,
        compliance: Mat<f64>,
        solve: CoarseSolver<'_>,
    ) -> Option<Coarse> {
        let coarse = self.problem(setup, compliance)?;
        let coarse_setup = Setup::new(&coarse).ok()?;
        let limits = (ACCURACY, COARSE_STEPS);
        let (outcome, solved) =
            match solve(limits, &coarse_setup, &mut |_| ControlFlow::Continue(())) {
                Ok(outcome) => (outcome, true),
                // a rough guess is still a guess
                Err(SolveError::NotConverged { outcome, .. }) => (*outcome, false),
                Err(_) => return None,
            };
        let Multipliers { lambda, alpha } = &outcome.multipliers;
        let finite = lambda.iter().chain(alpha).all(|x| x.is_finite());
        let share = coarse.len() as f64 / setup.len() as f64;
        finite.then_some(Coarse {
            steps: share * outcome.iterations as f64,
            outcome,
            solved,
        })
    }

    /// The problem of the clusters; `None` where its data are invalid.
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

    /// The start of the fine problem.
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
            solved: found.solved,
            steps: found.steps,
        }
    }
}

/// The law of blocks that act as one.
fn together(fine: &AdmissibleSet, members: &[usize]) -> Block {
    let laws = members
        .iter()
        .filter_map(|&member| fine.blocks()[member].friction());
    let laws: Vec<Friction> = laws.collect();
    fine.blocks()[members[0]].with_friction(|law| law.together(&laws))
}

/// Contacts become wider by one node, which takes the state of its neighbour: a sticking one would drag at the others.
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
    /// The coarsest clusters; `None` where they are too many.
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

    /// Solves the problem of the clusters repeatedly, each time finer where states change.
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

    /// Splits clusters beside a change of states; `false` where there is no such cluster.
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

/// Compliance of every component relative to its neighbours, (m,), length over force: wᵀFw with w = 1 at the component and minus
/// their mean at the neighbours. The compliance of slender bodies as a whole is far larger than from node to node.
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
            local[i] = value.clamp(LEAST_RELATIVE * local[i], local[i]);
        }
    }
    local
}

/// A relative compliance below this part of the component's own is rounding.
const LEAST_RELATIVE: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::states::Shear;
    use crate::solve::tests::{apart, applied, definite, of, times};

    const COULOMB: Friction = Friction::Coulomb { coefficient: 0.5 };

    fn chain(count: usize) -> Vec<[usize; 2]> {
        (1..count).map(|i| [i - 1, i]).collect()
    }

    /// y = 2x.
    struct Double(usize);

    impl LinearOperator for Double {
        fn len(&self) -> usize {
            self.0
        }

        fn apply(&self, x: &[f64], y: &mut [f64]) {
            y.iter_mut().zip(x).for_each(|(y, x)| *y = 2.0 * x);
        }
    }

    /// A chain of contacts that press, with an applied F = 2.
    fn long(count: usize) -> DualProblem {
        let compliance = Compliance::Operator {
            apply: Box::new(Double(count)),
            preconditioner: Box::new(Double(count)),
            glue: None,
        };
        let shift = vec![1.0; count];
        let blocks = vec![Block::Unilateral; count];
        let mut problem = of(compliance, &shift, blocks, (&[], &[]));
        problem.neighbours = chain(count);
        problem
    }

    /// A chain of `count` nodes with friction on a body that two motions move.
    fn nodes(count: usize) -> DualProblem {
        let m = 2 * count;
        let blocks: Vec<Block> = (0..count)
            .map(|i| {
                Friction::Coulomb {
                    coefficient: 0.1 * (1 + i) as f64,
                }
                .block(1)
            })
            .collect();
        let shift: Vec<f64> = (0..m).map(|i| (i as f64).sin()).collect();
        let modes = [
            (0..m).map(|i| f64::from(u8::from(i % 2 == 0))).collect(),
            (0..m).map(|i| 0.1 * i as f64 - 0.5).collect(),
        ];
        let f = Compliance::Dense(definite(m));
        let mut problem = of(f, &shift, blocks, (&modes, &[2.0, 0.3]));
        problem.neighbours = chain(count);
        problem
    }

    #[test]
    fn neighbours_of_one_kind_become_pairs_where_many_are_connected() {
        let pairs_of = |count: usize| pairs(&vec![Block::Unilateral; count], &chain(count));
        let alone: Vec<Vec<usize>> = (0..FEW).map(|i| vec![i]).collect();
        assert_eq!(pairs_of(FEW), alone);
        let nine: [&[usize]; 5] = [&[0, 1], &[2, 3], &[4, 5], &[6, 7], &[8]];
        assert_eq!(pairs_of(9), nine);
        // the partner of least number, and none of another kind or size
        let mut blocks = vec![Block::Unilateral; 10];
        (blocks[1], blocks[2]) = (COULOMB.block(1), COULOMB.block(2));
        blocks[3] = Friction::Tresca { bound: 1.0 }.block(1);
        let mut neighbours = chain(10);
        neighbours.extend([[9, 0], [0, 5], [4, 4]]);
        let found = pairs(&blocks, &neighbours);
        let expected: [&[usize]; 7] = [&[0, 5], &[1], &[2], &[3], &[4], &[6, 7], &[8, 9]];
        assert_eq!(found, expected);
    }

    #[test]
    fn graphs_of_contacts_and_of_clusters() {
        let links = beside(6, &[[0, 2], [2, 1], [4, 3]]);
        let expected: [&[usize]; 6] = [&[2], &[2], &[0, 1], &[4], &[3], &[]];
        assert_eq!(links, expected);
        assert_eq!(component_sizes(&links), [3, 3, 3, 2, 2, 1]);
        let neighbours = [[0, 1], [2, 1], [3, 2], [1, 2], [4, 0]];
        assert_eq!(joined(&neighbours, &[0, 0, 1, 1, 2]), [[0, 1], [0, 2]]);
    }

    /// Parts of every force in those of the clusters, (m, m').
    fn parts(members: &[Vec<usize>], size: usize, m: usize) -> Mat<f64> {
        let mut parts = Mat::<f64>::zeros(m, size * members.len());
        for (cluster, members) in members.iter().enumerate() {
            for &member in members {
                for c in 0..size {
                    parts[(size * member + c, size * cluster + c)] = 1.0 / members.len() as f64;
                }
            }
        }
        parts
    }

    #[test]
    fn problem_of_clusters_is_that_of_equal_parts() {
        let problem = nodes(10);
        let setup = Setup::new(&problem).unwrap();
        let mut members: Vec<Vec<usize>> = (0..4).map(|i| vec![2 * i, 2 * i + 1]).collect();
        members.extend([vec![8], vec![9]]);
        let p = parts(&members, 2, 20);
        let clusters = Clusters::new(members, &setup);
        let f = definite(20);
        let reduced = clusters.reduced(&f);
        let coarse = clusters.problem(&setup, reduced.clone()).unwrap();
        for j in 0..12 {
            let column: Vec<f64> = (0..20).map(|i| p[(i, j)]).collect();
            let image = times(&f, &column);
            for i in 0..12 {
                let expected: f64 = (0..20).map(|a| p[(a, i)] * image[a]).sum();
                assert!((reduced[(i, j)] - expected).abs() < 1e-14);
            }
            let shift: f64 = column.iter().zip(&problem.shift).map(|(p, d)| p * d).sum();
            assert!((coarse.shift[j] - shift).abs() < 1e-15);
            for r in 0..2 {
                let mode: f64 = (0..20)
                    .map(|a| problem.balance.modes()[(r, a)] * column[a])
                    .sum();
                assert!((coarse.balance.modes()[(r, j)] - mode).abs() < 1e-15);
            }
        }
        assert_eq!(coarse.neighbours, chain(6));
        assert_eq!(coarse.balance.load(), problem.balance.load());
        assert_eq!(coarse.scales, problem.scales);
        // coefficients are means: of 0.3 and 0.4
        let touch = coarse.admissible.blocks()[1].friction().unwrap().touch(0.0);
        assert!(touch.given == 0.0 && (touch.growth - 0.35).abs() < 1e-15);
    }

    #[test]
    fn coarser_answer_is_spread_evenly_and_counted_by_its_share() {
        let problem = nodes(10);
        let setup = Setup::new(&problem).unwrap();
        let told = |outcome: &dyn Fn(&Setup<'_>) -> Result<Outcome, SolveError>| {
            start(&setup, &|limits, coarse, _| {
                assert_eq!(limits, (1e-4, 40));
                outcome(coarse)
            })
        };
        let answer = |coarse: &Setup<'_>| {
            let multipliers = Multipliers {
                // five pairs; the second one open
                lambda: (0..coarse.len())
                    .map(|i| [2.0, 0.0, 0.0, 0.0, 4.0, 0.0, 6.0, 0.0, 8.0, 0.0][i])
                    .collect(),
                alpha: vec![0.7, -0.3],
            };
            Outcome::new(multipliers, 6)
        };
        let found = told(&|coarse| Ok(answer(coarse))).unwrap();
        let normals = [1.0, 1.0, 0.0, 0.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0];
        let expected: Vec<f64> = normals.iter().flat_map(|n| [*n, 0.0]).collect();
        assert_eq!(found.lambda, expected);
        assert!(
            apart(
                &setup.multipliers(&found.lambda, &found.alpha).alpha,
                &[0.7, -0.3]
            ) < 1e-14
        );
        // 6 of half the unknowns
        assert_eq!(found.steps, 3.0);
        // open nodes beside closed ones close: 2 and 3 are beside 1 and 4
        assert!(found.states.iter().all(|state| state.closed));
        let rough = |coarse: &Setup<'_>| SolveError::NotConverged {
            method: "newton".to_string(),
            outcome: Box::new(answer(coarse)),
            residual: 1.0,
            reason: String::new(),
        };
        assert_eq!(told(&|coarse| Err(rough(coarse))).unwrap().lambda, expected);
        assert!(told(&|_| Err(SolveError::Invalid(String::new()))).is_none());
        let wild = |which: usize| {
            move |coarse: &Setup<'_>| {
                let mut outcome = answer(coarse);
                let forces = &mut outcome.multipliers;
                match which {
                    0 => forces.lambda[3] = f64::NAN,
                    _ => forces.alpha[1] = f64::INFINITY,
                }
                Ok(outcome)
            }
        };
        assert!(told(&wild(0)).is_none() && told(&wild(1)).is_none());
    }

    #[test]
    fn coarser_problem_must_be_worth_its_solves() {
        // twelve in a chain become six beside others that stay alone: at most three quarters
        let with = |alone: usize, neighbours: Vec<[usize; 2]>| {
            let m = 12 + alone;
            let blocks = vec![Block::Unilateral; m];
            let f = Compliance::Dense(definite(m));
            let mut problem = of(f, &vec![1.0; m], blocks, (&[], &[]));
            problem.neighbours = neighbours;
            let setup = Setup::new(&problem).unwrap();
            let zero = |coarse: &Setup<'_>| {
                let multipliers = Multipliers {
                    lambda: vec![0.0; coarse.len()],
                    alpha: Vec::new(),
                };
                Outcome::new(multipliers, 0)
            };
            start(&setup, &|_, coarse, _| Ok(zero(coarse))).is_some()
        };
        assert!(with(12, chain(12)));
        assert!(!with(13, chain(12)));
        assert!(!with(0, Vec::new()));
    }

    #[test]
    fn contacts_widen_by_one_node_that_does_what_the_one_beside_it_does() {
        let block = COULOMB.block(1);
        let admissible =
            AdmissibleSet::new(vec![block, block, block, block, block, Block::Unilateral]);
        let open = State::sticking(&block, false);
        let slips = State {
            closed: true,
            shear: Shear::Slip {
                direction: vec![-1.0],
                share: 0.25,
            },
            excess: 3.0,
            normal: 0.0,
        };
        let mut states = vec![
            open.clone(),
            open.clone(),
            open.clone(),
            slips.clone(),
            open.clone(),
        ];
        states.push(State::sticking(&Block::Unilateral, false));
        // the last one is beside a closed node of another size
        let neighbours = [[0, 1], [1, 2], [2, 3], [4, 3], [5, 3]];
        widen(&mut states, &admissible, &neighbours);
        assert_eq!(states[..2], [open.clone(), open.clone()]);
        assert_eq!(states[2..5], [slips.clone(), slips.clone(), slips]);
        assert!(!states[5].closed);
    }

    #[test]
    fn tree_is_cut_where_few_clusters_are_left() {
        let cut = |count: usize| {
            let problem = long(count);
            let setup = Setup::new(&problem).unwrap();
            Cut::new(&setup).map(|tree| {
                let of = |node: &usize| tree.blocks[*node].clone();
                tree.cut.iter().map(of).collect::<Vec<Vec<usize>>>()
            })
        };
        // 300, 150, 75, 38: eight in each cluster
        let clusters = cut(300).unwrap();
        assert_eq!(clusters.len(), 38);
        assert_eq!(clusters[0], (0..8).collect::<Vec<usize>>());
        assert_eq!(clusters.concat(), (0..300).collect::<Vec<usize>>());
        // 252, 126, 63: a fourth
        assert_eq!(cut(252).unwrap().len(), 63);
        assert!(cut(251).is_none());
        // 64 nodes are not paired: the clusters are not fewer than all nodes
        assert!(cut(64).is_none());
    }

    #[test]
    fn columns_of_clusters_give_their_compliance_and_are_found_once() {
        let (m, f) = (300, definite(300));
        let shift = vec![1.0; m];
        let mut problem = of(
            applied(&f, Mat::identity(m, m)),
            &shift,
            vec![Block::Unilateral; m],
            (&[], &[]),
        );
        problem.neighbours = chain(m);
        let setup = Setup::new(&problem).unwrap();
        let Compliance::Operator { apply, .. } = &problem.compliance else {
            panic!("it is applied");
        };
        let mut tree = Cut::new(&setup).unwrap();
        assert!(tree.fill(&setup, &**apply));
        assert_eq!(setup.products(), 38);
        let members: Vec<Vec<usize>> = tree
            .cut
            .iter()
            .map(|&node| tree.blocks[node].clone())
            .collect();
        let clusters = Clusters::new(members, &setup);
        let (found, expected) = (tree.compliance(&clusters), clusters.reduced(&f));
        for i in 0..38 {
            for j in 0..38 {
                assert!((found[(i, j)] - expected[(i, j)]).abs() < 1e-14);
            }
        }
        // a change of states between clusters 9 and 10: these and those beside them fall into fourths
        let states: Vec<State> = (0..38)
            .map(|i| State::sticking(&Block::Unilateral, i < 10))
            .collect();
        let before = tree.cut.clone();
        assert!(tree.split(&clusters, &states));
        assert_eq!(tree.cut.len(), 38 + 4 * 3);
        assert_eq!(
            (&tree.cut[..8], &tree.cut[24..]),
            (&before[..8], &before[12..])
        );
        let blocks = tree.cut.iter().flat_map(|&node| tree.blocks[node].clone());
        assert_eq!(
            blocks.collect::<Vec<usize>>(),
            (0..300).collect::<Vec<usize>>()
        );
        assert!(
            tree.cut[8..24]
                .iter()
                .all(|&node| tree.blocks[node].len() == 2)
        );
        assert!(tree.fill(&setup, &**apply));
        assert_eq!(setup.products(), 38 + 16);
        // without a change of states no cluster becomes finer
        let members = tree.cut.iter().map(|&node| tree.blocks[node].clone());
        let clusters = Clusters::new(members.collect(), &setup);
        let all = vec![State::sticking(&Block::Unilateral, true); 50];
        assert!(!tree.split(&clusters, &all));
        assert_eq!(tree.cut.len(), 50);
    }

    #[test]
    fn columns_have_an_end() {
        let problem = long(1100);
        let setup = Setup::new(&problem).unwrap();
        let fills = |count: usize| {
            let mut tree = Cut::new(&setup).unwrap();
            tree.cut = (0..count).collect();
            tree.fill(&setup, &Double(1100))
        };
        assert!(fills(1024) && !fills(1025));
    }

    #[test]
    fn refined_clusters_begin_near_the_answer_of_an_applied_compliance() {
        // overlaps along the first 93 contacts alone: these bear half of them
        let mut problem = long(300);
        problem.shift = (0..300).map(|i| if i < 93 { 1.0 } else { -1.0 }).collect();
        let setup = Setup::new(&problem).unwrap();
        let solve = |coarse: &Setup<'_>| {
            let Compliance::Dense(f) = &coarse.problem.compliance else {
                panic!("a coarser problem is assembled");
            };
            let lambda = (0..coarse.len()).map(|i| (coarse.shift[i] / f[(i, i)]).max(0.0));
            let multipliers = Multipliers {
                lambda: lambda.collect(),
                alpha: Vec::new(),
            };
            Outcome::new(multipliers, 2)
        };
        let mut sizes = Vec::new();
        let told = std::cell::RefCell::new(&mut sizes);
        let found = start(&setup, &|_, coarse, _| {
            told.borrow_mut().push(coarse.len());
            Ok(solve(coarse))
        })
        .unwrap();
        // the clusters of the edge fall apart to single contacts
        let half = (0..300).map(|i| if i < 93 { 0.5 } else { 0.0 });
        assert!(apart(&found.lambda, &half.collect::<Vec<f64>>()) < 1e-14);
        let (first, last) = (sizes[0], *sizes.last().unwrap());
        assert!(first == 38 && last > first && last < 80, "{sizes:?}");
        let steps: f64 = sizes.iter().map(|&size| 2.0 * size as f64 / 300.0).sum();
        assert!((found.steps - steps).abs() < 1e-12);
        // one wider than the answer
        let closed = found.states.iter().filter(|state| state.closed).count();
        assert_eq!(closed, 94);
    }

    #[test]
    fn local_softness_is_what_gives_way_between_neighbours() {
        let f = definite(6);
        let blocks = vec![
            COULOMB.block(1),
            COULOMB.block(1),
            Block::Unilateral,
            Block::Unilateral,
        ];
        let mut problem = of(
            Compliance::Dense(f.clone()),
            &[1.0; 6],
            blocks.clone(),
            (&[], &[]),
        );
        // the contact in the middle is beside two; blocks of other sizes are no neighbours
        problem.neighbours = vec![[0, 1], [1, 2], [2, 3]];
        let setup = Setup::new(&problem).unwrap();
        let pair = |i: usize, j: usize| f[(i, i)] - 2.0 * f[(i, j)] + f[(j, j)];
        let own = &problem.softness;
        let expected: Vec<f64> = [(0, 2), (1, 3), (2, 0), (3, 1), (4, 5), (5, 4)]
            .iter()
            .map(|&(i, j)| pair(i, j).clamp(1e-12 * own[i], own[i]))
            .collect();
        assert!(apart(&local_softness(&setup), &expected) < 1e-14);
        assert!(expected.iter().zip(own).any(|(e, o)| e < o));
        // in a chain the middle one is measured against the mean of both
        problem.admissible = AdmissibleSet::new(vec![Block::Unilateral; 6]);
        problem.neighbours = chain(3);
        let setup = Setup::new(&problem).unwrap();
        let w = [-0.5, 1.0, -0.5, 0.0, 0.0, 0.0];
        let own: f64 = times(&f, &w).iter().zip(w).map(|(a, b)| a * b).sum();
        let local = local_softness(&setup);
        assert!((local[1] - own).abs() < 1e-14);
        assert_eq!(local[3..], problem.softness[3..]);
    }

    #[test]
    fn local_softness_is_no_more_than_the_own_and_more_than_nothing() {
        let with = |own: f64, beside: f64| {
            let f = Mat::from_fn(2, 2, |i, j| if i == j { own } else { beside });
            let blocks = vec![Block::Unilateral; 2];
            let mut problem = of(Compliance::Dense(f), &[1.0; 2], blocks, (&[], &[]));
            problem.neighbours = chain(2);
            local_softness(&Setup::new(&problem).unwrap())
        };
        // 2 (own − beside)
        assert_eq!(with(4.0, 3.0), [2.0; 2]);
        assert_eq!(with(4.0, -1.0), [4.0; 2]);
        assert_eq!(with(4.0, 4.0), [4e-12; 2]);
        let problem = long(5);
        let setup = Setup::new(&problem).unwrap();
        assert_eq!(local_softness(&setup), problem.softness);
    }
}
