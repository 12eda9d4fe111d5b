//! Order, analysis and grounding of the stiffness of a body, whose nodes have D dofs each.

use crate::linalg::{
    Cholesky, Graph, LinalgError, SymbolicCholesky, SymmetricMatrix, expand_to_dofs,
    fill_reducing_order,
};

/// A preferred dof is grounded only if a mode, of largest displacement 1, moves it by more than this: else the pivot would cost three
/// digits or more.
const FAR_ENOUGH: f64 = 1e-3;

/// Orders and analyses K on the dofs with `keep`, those of `trailing` at the end.
///
/// Errors: [`LinalgError::TooLarge`].
pub(crate) fn analyse<const D: usize>(
    graph: &Graph,
    stiffness: &SymmetricMatrix,
    keep: &[bool],
    trailing: &[usize],
) -> Result<SymbolicCholesky, LinalgError> {
    let order = elimination_order::<D>(graph, keep, trailing);
    SymbolicCholesky::new(stiffness, &order, trailing.len())
}

/// The dofs with `keep` in an order for their elimination, those of `trailing` at the end.
///
/// If only some dofs of a node are trailing, its other dofs are ordered among the inner nodes: their graph, and with it their
/// elimination tree, is the same.
pub(super) fn elimination_order<const D: usize>(
    graph: &Graph,
    keep: &[bool],
    trailing: &[usize],
) -> Vec<usize> {
    let mut inner = keep.to_vec();
    trailing.iter().for_each(|&dof| inner[dof] = false);
    let [nodes, inner_nodes] = [keep, &inner].map(some_of_node::<D>);
    let last: Vec<usize> = (0..nodes.len())
        .filter(|&node| nodes[node] && !inner_nodes[node])
        .collect();
    let order = fill_reducing_order(graph, &nodes, &last);
    let mut dofs = expand_to_dofs(&order, D, &inner);
    dofs.extend_from_slice(trailing);
    dofs
}

/// The factor of a matrix without nodes, of which the rows from `dense` on are full and eliminated last.
///
/// Errors: those of the factor.
pub(crate) fn factor_scattered(
    matrix: &SymmetricMatrix,
    dense: usize,
) -> Result<Cholesky, LinalgError> {
    let edges = (0..dense).flat_map(|j| {
        let rows = matrix.rows_of(j).iter();
        let rows = rows.filter(move |&&i| i as usize != j && (i as usize) < dense);
        rows.map(move |&i| [i, j as u32])
    });
    let graph = Graph::of_edges(dense, edges);
    let mut order = fill_reducing_order(&graph, &vec![true; dense], &[]);
    order.extend(dense..matrix.len());
    Cholesky::factor(matrix, &order, 0)
}

/// Whether some dof of each node is marked.
pub(crate) fn some_of_node<const D: usize>(marked: &[bool]) -> Vec<bool> {
    let nodes = marked.chunks_exact(D);
    nodes.map(|dofs| dofs.contains(&true)).collect()
}

/// Dofs among those with `keep` that hold rigid modes, columns of largest displacement 1: complete pivoting, on dofs that are
/// `preferred` if possible.
pub(crate) fn ground(modes: &[Vec<f64>], keep: &[bool], preferred: &[bool]) -> Vec<usize> {
    let mut modes = modes.to_vec();
    let mut grounded: Vec<usize> = Vec::new();
    let mut open: Vec<usize> = (0..modes.len()).collect();
    while !open.is_empty() {
        let best = |among: &[bool]| {
            let mut best = (0.0, 0, 0);
            for (position, &mode) in open.iter().enumerate() {
                for (dof, _) in among.iter().enumerate().filter(|(_, among)| **among) {
                    let size = modes[mode][dof].abs();
                    if size > best.0 {
                        best = (size, position, dof);
                    }
                }
            }
            best
        };
        let mut pivot = best(preferred);
        if pivot.0 < FAR_ENOUGH {
            pivot = best(keep);
        }
        let (size, position, dof) = pivot;
        if size == 0.0 {
            break;
        }
        let mode = open.remove(position);
        grounded.push(dof);
        let row = modes[mode].clone();
        for &other in &open {
            let factor = modes[other][dof] / row[dof];
            modes[other]
                .iter_mut()
                .zip(&row)
                .for_each(|(value, r)| *value -= factor * r);
        }
    }
    grounded
}
