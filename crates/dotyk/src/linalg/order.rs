//! Elimination orders that keep the Cholesky factor sparse.
//!
//! The nodes are ordered, not the dofs: the same fill at a fraction of the time. Approximate minimum degree is as good as nested
//! dissection for thin bodies and for plane ones of which no nodes have to be last, and several times faster to compute; thick
//! bodies in space take a third of its operations if they are dissected, plane ones with a side last 60 %.
//! The order is postordered by its elimination tree, which changes no fill but puts the columns of a supernode side
//! by side, where the factorisation looks for them.
//!
//! Source: J. W. H. Liu, The role of elimination trees in sparse factorization, SIAM J. Matrix Anal. Appl. 11 (1990) 134–172.

use crate::linalg::Graph;
use crate::linalg::degree::minimum_degree;
use crate::linalg::dissection::dissect;
use dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::simplicial;

const NO_ROW: u32 = u32::MAX;

/// For fewer nodes than [`CERTAINLY_WORTH`] dissection is tried only if minimum degree takes more operations by nodes than this for each neighbour of each node, because
/// dissection itself takes as long as some hundred operations on blocks of 2 × 2 or 3 × 3 for each. Bodies of less than 3000 nodes in
/// the plane and of 300 in space lie below, and thin beams.
const WORTH_DISSECTING: f64 = 150.0;

/// Nodes from which on it is always tried, beside minimum degree where there is another thread.
const CERTAINLY_WORTH: usize = 20_000;

/// Elimination order of the nodes with `keep`: first those not in `last`, then those of `last` in the given order.
///
/// By minimum degree or, where the graph knows the places of its nodes, by dissection of the nodes not in `last`, whichever takes
/// fewer operations; postordered. `keep` (nodes,). Nodes of `last` that are not kept, or named before, are left out.
pub fn fill_reducing_order(graph: &Graph, keep: &[bool], last: &[usize]) -> Vec<usize> {
    let (inner, last) = inner_and_last(keep, last);
    let counted = |order: Vec<u32>| (operations(graph, &order), order);
    let plain = || counted(by_minimum_degree(graph, &inner, &last));
    let dissected = || {
        let mut order = inner.clone();
        dissect(graph, &mut order, &last);
        order.extend_from_slice(&last);
        counted(order)
    };
    let knows_places = !graph.places().is_empty();
    let (plain, dissected) = if knows_places && inner.len() > CERTAINLY_WORTH {
        let (plain, dissected) = rayon::join(plain, dissected);
        (plain, Some(dissected))
    } else {
        let plain = plain();
        let is_worth = plain.0 > WORTH_DISSECTING * graph.edges() as f64;
        let dissected = (knows_places && is_worth).then(dissected);
        (plain, dissected)
    };
    let order = dissected.filter(|other| other.0 < plain.0);
    let (_, order) = order.unwrap_or(plain);
    postordered(graph, &order, last.len())
}

/// The kept nodes that are not in `last`, ascending, and those that are.
fn inner_and_last(keep: &[bool], last: &[usize]) -> (Vec<u32>, Vec<u32>) {
    let mut inner = keep.to_vec();
    let last = last
        .iter()
        .filter(|&&node| std::mem::take(&mut inner[node]));
    let last = last.map(|&node| node as u32).collect();
    let nodes = (0..inner.len()).filter(|&node| inner[node]);
    (nodes.map(|node| node as u32).collect(), last)
}

/// The kept nodes by minimum degree, those of `last` after the others.
///
/// The degrees count the nodes of `last`, which are taken out of the order afterwards: with the edge of a square last
/// that leaves 9 to 28 % fewer operations than the order of the other nodes alone.
fn by_minimum_degree(graph: &Graph, inner: &[u32], last: &[u32]) -> Vec<u32> {
    let mut kept = [inner, last].concat();
    kept.sort_unstable();
    let local = positions(graph.nodes(), &kept);
    let neighbours = |k: usize| {
        let all = graph.neighbours(kept[k] as usize).iter();
        let all = all.map(|&other| local[other as usize]);
        all.filter(|&i| i != NO_ROW)
    };
    let mut is_last = vec![false; graph.nodes()];
    last.iter().for_each(|&node| is_last[node as usize] = true);
    let order = minimum_degree(kept.len(), neighbours);
    let order = order.into_iter().map(|k| kept[k as usize]);
    let order = order.filter(|&node| !is_last[node as usize]);
    order.chain(last.iter().copied()).collect()
}

/// The dofs of the nodes in the same order, `dimension` for each node, without those that `keep` (by dof) excludes.
pub fn expand_to_dofs(order: &[usize], dimension: usize, keep: &[bool]) -> Vec<usize> {
    let mut dofs = Vec::with_capacity(order.len() * dimension);
    for &node in order {
        dofs.extend((dimension * node..dimension * (node + 1)).filter(|&dof| keep[dof]));
    }
    dofs
}

/// Operations of a factorisation with one dof for each node: Σ c² over the entries c of the columns of the factor.
fn operations(graph: &Graph, order: &[u32]) -> f64 {
    let n = order.len();
    let position = positions(graph.nodes(), order);
    let mut col_start = vec![0u32];
    let mut row_index = Vec::new();
    for (k, &node) in order.iter().enumerate() {
        let neighbours = graph.neighbours(node as usize).iter();
        let before = neighbours.map(|&other| position[other as usize]);
        row_index.extend(before.filter(|&i| i < k as u32));
        row_index.push(k as u32);
        col_start.push(row_index.len() as u32);
    }
    let upper = SymbolicSparseColMatRef::new_unsorted_checked(n, n, &col_start, None, &row_index);
    let (mut tree, mut counts) = (vec![0i32; n], vec![0u32; n]);
    let entries = row_index.len();
    let mut memory = MemBuffer::new(simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(
        n, entries,
    ));
    let stack = MemStack::new(&mut memory);
    simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, upper, stack);
    counts.iter().map(|&count| f64::from(count).powi(2)).sum()
}

/// Index of each node in the list, [`NONE`] where it is not listed.
fn positions(nodes: usize, list: &[u32]) -> Vec<u32> {
    let mut position = vec![NO_ROW; nodes];
    for (k, &node) in list.iter().enumerate() {
        position[node as usize] = k as u32;
    }
    position
}

/// Postorder of the elimination tree; the last `fixed` stay where they are.
fn postordered(graph: &Graph, order: &[u32], fixed: usize) -> Vec<usize> {
    let parent = elimination_tree(graph, order);
    let free = order.len() - fixed;
    // Lists of children; those of the fixed nodes are roots.
    let mut first_child = vec![NO_ROW; free];
    let mut next_sibling = vec![NO_ROW; free];
    let mut roots = Vec::new();
    for node in (0..free).rev() {
        match parent[node] as usize {
            p if p < free => {
                next_sibling[node] = first_child[p];
                first_child[p] = node as u32;
            }
            _ => roots.push(node as u32),
        }
    }
    let mut result = Vec::with_capacity(order.len());
    let mut path = Vec::new();
    for root in roots.into_iter().rev() {
        path.push(root);
        while let Some(&node) = path.last() {
            let child = first_child[node as usize];
            if child == NO_ROW {
                result.push(order[node as usize] as usize);
                path.pop();
            } else {
                first_child[node as usize] = next_sibling[child as usize];
                path.push(child);
            }
        }
    }
    result.extend(order[free..].iter().map(|&node| node as usize));
    result
}

/// Parent of each position of the order in the elimination tree, [`NONE`] for roots (Liu 1990, algorithm 4.2).
fn elimination_tree(graph: &Graph, order: &[u32]) -> Vec<u32> {
    let position = positions(graph.nodes(), order);
    let mut parent = vec![NO_ROW; order.len()];
    let mut ancestor = vec![NO_ROW; order.len()];
    for (k, &node) in order.iter().enumerate() {
        let k = k as u32;
        for &other in graph.neighbours(node as usize) {
            let mut i = position[other as usize];
            // The positions after k, and NO_ROW, are not below k.
            while i < k {
                let next = std::mem::replace(&mut ancestor[i as usize], k);
                if next == NO_ROW {
                    parent[i as usize] = k;
                    break;
                }
                i = next;
            }
        }
    }
    parent
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{Connectivity, grid};

    /// Entries of the factor by elimination on sets, the definition of fill.
    fn fill(graph: &Graph, order: &[usize]) -> usize {
        columns(graph, order).iter().sum()
    }

    /// Entries of each column of the factor by elimination on sets.
    fn columns(graph: &Graph, order: &[usize]) -> Vec<usize> {
        let mut place = vec![usize::MAX; graph.nodes()];
        for (k, &node) in order.iter().enumerate() {
            place[node] = k;
        }
        let mut below: Vec<std::collections::BTreeSet<usize>> = order
            .iter()
            .enumerate()
            .map(|(k, &node)| {
                let others = graph.neighbours(node).iter().map(|&o| place[o as usize]);
                others.filter(|&p| p != usize::MAX && p > k).collect()
            })
            .collect();
        let mut entries = Vec::with_capacity(order.len());
        for k in 0..order.len() {
            entries.push(1 + below[k].len());
            let column = std::mem::take(&mut below[k]);
            if let Some(&parent) = column.first() {
                below[parent].extend(column.into_iter().skip(1));
            }
        }
        entries
    }

    /// Nodes of a box of nx × ny × nz hexahedra.
    fn hexahedra([nx, ny, nz]: [usize; 3]) -> Graph {
        let node = |i, j, k| ((k * (ny + 1) + j) * (nx + 1) + i) as u32;
        let mut nodes = Vec::new();
        for (i, j, k) in (0..nx * ny * nz).map(|cell| (cell % nx, cell / nx % ny, cell / (nx * ny)))
        {
            nodes.extend((0..8).map(|c| node(i + c % 2, j + c / 2 % 2, k + c / 4)));
        }
        let cells = Connectivity {
            nodes: &nodes,
            nodes_per_cell: 8,
        };
        let count = (nx + 1) * (ny + 1) * (nz + 1);
        let places: Vec<[f64; 3]> = (0..count)
            .map(|n| {
                [
                    n % (nx + 1),
                    n / (nx + 1) % (ny + 1),
                    n / (nx + 1) / (ny + 1),
                ]
            })
            .map(|place| place.map(|k| k as f64))
            .collect();
        Graph::from_cells(count, &[cells]).placed(&places)
    }

    /// The same nodes at places that nobody knows.
    fn lost(graph: &Graph) -> Graph {
        let edges = (0..graph.nodes()).flat_map(|i| {
            let others = graph.neighbours(i).iter();
            others.map(move |&j| [i as u32, j])
        });
        Graph::of_edges(graph.nodes(), edges)
    }

    /// Triangles of nx × ny squares, and their nodes at y = 0.
    fn triangles(nx: usize, ny: usize) -> (Graph, Vec<usize>) {
        let places = (0..(nx + 1) * (ny + 1)).map(|n| [n % (nx + 1), n / (nx + 1)]);
        let places: Vec<[f64; 2]> = places.map(|place| place.map(|k| k as f64)).collect();
        let (graph, _) = grid::body(nx, ny);
        (graph.placed(&places), (0..=nx).collect())
    }

    fn assert_is_order_of(order: &[usize], keep: &[bool], last: &[usize]) {
        assert_eq!(order[order.len() - last.len()..], *last);
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        let kept: Vec<usize> = (0..keep.len()).filter(|&i| keep[i]).collect();
        assert_eq!(sorted, kept);
    }

    fn as_listed(order: &[usize]) -> Vec<u32> {
        order.iter().map(|&node| node as u32).collect()
    }

    #[test]
    fn operations_are_those_of_elimination_on_sets() {
        let graph = hexahedra([5, 4, 3]);
        let keep = vec![true; graph.nodes()];
        let order = fill_reducing_order(&graph, &keep, &[0, 3, 8]);
        let expected: usize = columns(&graph, &order).iter().map(|c| c * c).sum();
        assert_eq!(operations(&graph, &as_listed(&order)), expected as f64);
        // without an uneliminated node the others have fewer entries
        assert!(operations(&graph, &as_listed(&order[1..])) < expected as f64);
    }

    #[test]
    fn thick_bodies_are_dissected_for_half_of_the_operations() {
        let graph = hexahedra([17, 17, 17]);
        let mut keep = vec![true; graph.nodes()];
        keep[7] = false;
        let top: Vec<usize> = (graph.nodes() - 18 * 18..graph.nodes()).collect();
        for last in [&[][..], &top] {
            let plain = fill_reducing_order(&lost(&graph), &keep, last);
            let order = fill_reducing_order(&graph, &keep, last);
            assert_is_order_of(&order, &keep, last);
            let [plain, less] = [plain, order].map(|o| operations(&graph, &as_listed(&o)));
            assert!(less < 0.5 * plain, "{less:e} of {plain:e}");
        }
    }

    #[test]
    fn plane_bodies_with_a_side_last_are_dissected_for_two_thirds() {
        let (graph, side) = triangles(200, 70);
        let keep = vec![true; graph.nodes()];
        let plain = fill_reducing_order(&lost(&graph), &keep, &side);
        let order = fill_reducing_order(&graph, &keep, &side);
        assert_is_order_of(&order, &keep, &side);
        let [plain, less] = [plain, order].map(|o| operations(&graph, &as_listed(&o)));
        assert!(less < 0.67 * plain, "{less:e} of {plain:e}");
    }

    #[test]
    fn the_order_is_the_same_on_any_number_of_threads() {
        let graph = hexahedra([12, 14, 9]);
        let keep = vec![true; graph.nodes()];
        let order = || fill_reducing_order(&graph, &keep, &[3, 11]);
        let alone = grid::on_threads(1, order);
        assert!((0..3).all(|_| grid::on_threads(4, order) == alone));
    }

    #[test]
    fn nodes_at_one_place_are_ordered_too() {
        let graph = hexahedra([9, 9, 9]);
        let graph = lost(&graph).placed(&vec![[1.0, 2.0]; graph.nodes()]);
        let keep = vec![true; graph.nodes()];
        assert_is_order_of(&fill_reducing_order(&graph, &keep, &[5]), &keep, &[5]);
    }

    #[test]
    fn small_bodies_are_not_dissected() {
        for cells in [[4, 4, 4], [60, 2, 2]] {
            let graph = hexahedra(cells);
            let keep = vec![true; graph.nodes()];
            let [plain, order] =
                [&lost(&graph), &graph].map(|graph| fill_reducing_order(graph, &keep, &[1, 5]));
            assert_eq!(plain, order);
        }
    }

    #[test]
    fn the_order_holds_each_kept_node_once_and_the_last_ones_last() {
        let (graph, _) = grid::body(12, 9);
        let mut keep = vec![true; graph.nodes()];
        keep[3] = false;
        keep[40] = false;
        let order = fill_reducing_order(&graph, &keep, &[20, 3, 7, 100, 7]);
        assert_eq!(order[order.len() - 3..], [20, 7, 100]);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        let kept: Vec<usize> = (0..graph.nodes()).filter(|&i| keep[i]).collect();
        assert_eq!(sorted, kept);
    }

    #[test]
    fn minimum_degree_fills_less_than_the_natural_order() {
        let (graph, _) = grid::body(30, 30);
        let order = fill_reducing_order(&graph, &vec![true; graph.nodes()], &[]);
        let natural: Vec<usize> = (0..graph.nodes()).collect();
        // A band of width 31 holds about 31 entries per column, a good order of this grid less than 20.
        assert!(3 * fill(&graph, &order) < 2 * fill(&graph, &natural));
    }

    #[test]
    fn postordering_keeps_the_fill_and_makes_subtrees_contiguous() {
        let (graph, _) = grid::body(17, 13);
        let nodes: Vec<u32> = (0..graph.nodes() as u32).collect();
        let neighbours = |k: usize| graph.neighbours(k).iter().copied();
        let before = minimum_degree(nodes.len(), neighbours);
        let after = postordered(&graph, &before, 0);
        let plain: Vec<usize> = before.iter().map(|&n| n as usize).collect();
        assert_eq!(fill(&graph, &plain), fill(&graph, &after));
        let after: Vec<u32> = after.iter().map(|&n| n as u32).collect();
        let parent = elimination_tree(&graph, &after);
        let mut size = vec![1; parent.len()];
        for k in 0..parent.len() {
            if parent[k] != NO_ROW {
                let p = parent[k] as usize;
                // A child's subtree ends right before its parent or before the next child's subtree.
                assert!(k < p);
                size[p] += size[k];
            }
        }
        for (k, size) in size.iter().enumerate() {
            let first = k + 1 - size;
            assert!((first..k).all(|i| parent[i] as usize <= k));
        }
    }

    #[test]
    fn nodes_without_neighbours_are_ordered_too() {
        let cell = Connectivity {
            nodes: &[1, 3],
            nodes_per_cell: 2,
        };
        let graph = Graph::from_cells(5, &[cell]);
        let mut order = fill_reducing_order(&graph, &[true; 5], &[]);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4]);
        assert!(fill_reducing_order(&graph, &[false; 5], &[2]).is_empty());
    }

    #[test]
    fn dofs_follow_their_nodes() {
        let keep = [true, false, true, true, true, true];
        assert_eq!(expand_to_dofs(&[2, 0], 2, &keep), [4, 5, 0]);
    }
}
