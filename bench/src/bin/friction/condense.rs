//! Global problems in local form: the motions are eliminated.
//!
//! ```text
//!   Mv = Hr + f,  u = Hᵀv + w     ⇒     W = HᵀM⁻¹H = XᵀX,  q = XᵀL⁻¹f + w,     M = LLᵀ,  X = L⁻¹H
//! ```
//!
//! M (dofs, dofs): masses, or a stiffness with them; symmetric, positive definite. H (dofs, n). The factor is sparse.

use dotyk::linalg::{
    Cholesky, Connectivity, Graph, Mat, SparseMatrix, SymmetricMatrix, fill_reducing_order, gram,
    matvec_transpose,
};

/// Parts of the largest entry by which M may differ from its transpose.
const SYMMETRY: f64 = 1e-9;

/// M, H, f, w.
#[derive(Debug)]
pub struct Global {
    /// M, (dofs, dofs).
    pub mass: SparseMatrix,
    /// H, (dofs, n).
    pub rows: SparseMatrix,
    /// f, (dofs,).
    pub load: Vec<f64>,
    /// w, (n,).
    pub velocity: Vec<f64>,
}

/// W and q. Errors in words: sizes that do not fit, an M that is not symmetric positive definite.
pub fn condense(global: &Global) -> Result<(SparseMatrix, Vec<f64>), String> {
    let Global {
        mass,
        rows,
        load,
        velocity,
    } = global;
    let (dofs, n) = (mass.rows(), rows.cols());
    if (mass.cols(), rows.rows(), load.len(), velocity.len()) != (dofs, dofs, dofs, n) {
        return Err("the sizes of M, H, f and w do not fit".to_string());
    }
    let factor = factor(mass)?;
    let mut columns = vec![vec![0.0; dofs]; n];
    for i in 0..dofs {
        for (j, x) in rows.row(i) {
            columns[j][i] += x;
        }
    }
    let mut half = Mat::zeros(dofs, n);
    for (j, column) in columns.iter().enumerate() {
        half.col_as_slice_mut(j)
            .copy_from_slice(&factor.forward(column));
    }
    let product = gram(&half);
    let mut free = vec![0.0; n];
    matvec_transpose(&half, &factor.forward(load), &mut free);
    free.iter_mut().zip(velocity).for_each(|(q, w)| *q += w);
    let mut triplets = Vec::new();
    for j in 0..n {
        let column = product.col_as_slice(j).iter().enumerate();
        triplets.extend(column.filter(|(_, x)| **x != 0.0).map(|(i, &x)| (i, j, x)));
    }
    Ok((SparseMatrix::from_triplets(n, n, &triplets), free))
}

fn factor(mass: &SparseMatrix) -> Result<Cholesky, String> {
    let dofs = mass.rows();
    let mut triplets = Vec::with_capacity(mass.nonzeros());
    for i in 0..dofs {
        triplets.extend(mass.row(i).map(|(j, x)| (i, j, x)));
    }
    let largest = triplets.iter().fold(0.0, |s: f64, t| s.max(t.2.abs()));
    let mirrored = triplets.iter().map(|&(i, j, x)| (j, i, -x));
    let both: Vec<_> = triplets.iter().copied().chain(mirrored).collect();
    let difference = SparseMatrix::from_triplets(dofs, dofs, &both);
    let unequal = |i: &usize| {
        let mut row = difference.row(*i);
        row.any(|(_, x)| x.abs() > SYMMETRY * largest)
    };
    if let Some(i) = (0..dofs).find(unequal) {
        return Err(format!("row {i} of M differs from its column"));
    }
    let pairs: Vec<u32> = triplets
        .iter()
        .flat_map(|&(i, j, _)| [i as u32, j as u32])
        .collect();
    let cells = Connectivity {
        nodes: &pairs,
        nodes_per_cell: 2,
    };
    let graph = Graph::from_cells(dofs, &[cells]);
    let order = fill_reducing_order(&graph, &vec![true; dofs], &[]);
    let symmetric = SymmetricMatrix::from_triplets(dofs, &triplets);
    Cholesky::factor(&symmetric, &order, 0)
        .map_err(|error| format!("M cannot be factored: {error}"))
}

/// A matrix of entries (row, column, value), those in the same place added. Errors in words: a place outside.
pub fn assembled(
    rows: usize,
    columns: usize,
    entries: &[(usize, usize, f64)],
) -> Result<SparseMatrix, String> {
    match entries.iter().find(|t| t.0 >= rows || t.1 >= columns) {
        Some(&(i, j, _)) => Err(format!(
            "entry ({i}, {j}) lies outside a matrix of {rows} by {columns}"
        )),
        None => Ok(SparseMatrix::from_triplets(rows, columns, entries)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn global(coupling: f64) -> Global {
        let mass = [(0, 0, 2.0), (1, 1, 2.0), (0, 1, 1.0), (1, 0, coupling)];
        Global {
            mass: assembled(2, 2, &mass).unwrap(),
            rows: assembled(2, 2, &[(0, 0, 3.0), (1, 1, 3.0)]).unwrap(),
            load: vec![3.0, 0.0],
            velocity: vec![0.5, 0.0],
        }
    }

    #[test]
    fn motions_are_eliminated() {
        // M⁻¹ = [2 −1; −1 2] / 3.
        let (matrix, free) = condense(&global(1.0)).unwrap();
        let expected = [[6.0, -3.0], [-3.0, 6.0]];
        for (i, expected) in expected.iter().enumerate() {
            for (j, x) in matrix.row(i) {
                assert!((x - expected[j]).abs() < 1e-14);
            }
        }
        assert!((free[0] - 6.5).abs() < 1e-14 && (free[1] + 3.0).abs() < 1e-14);
    }

    #[test]
    fn masses_that_are_none_are_told() {
        assert!(condense(&global(0.9)).unwrap_err().contains("row 0"));
        let mut indefinite = global(1.0);
        indefinite.mass = assembled(2, 2, &[(0, 0, 1.0), (1, 1, -1.0)]).unwrap();
        assert!(condense(&indefinite).unwrap_err().contains("factored"));
        assert!(
            assembled(2, 2, &[(2, 0, 1.0)])
                .unwrap_err()
                .contains("outside")
        );
    }
}
