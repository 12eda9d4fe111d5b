//! Global problems in local form: the motions are eliminated.
//!
//! ```text
//!   Mv = Hr + f,  u = Hᵀv + w     ⇒     W = HᵀM⁻¹H,  q = HᵀM⁻¹f + w
//! ```
//!
//! M (dofs, dofs): masses, or a stiffness with them; H (dofs, n). Where M is symmetric (to rounding) W = XᵀX with
//! X = L⁻¹H of a sparse Cholesky factor, so that W is symmetric, too. Some files hold an unsymmetric M (measured: entries
//! of 1e-7 of the largest without their mirror image): then M is used unchanged, by a dense LU.

use dotyk::linalg::{
    Cholesky, Connectivity, Graph, Lu, Mat, SparseMatrix, SymmetricMatrix, fill_reducing_order,
    gram, transpose_product,
};

/// An M counts as symmetric if it differs from its transpose by at most this part of its largest entry.
const SYMMETRY: f64 = 1e-13;

/// Most rows of an unsymmetric M.
const DENSE: usize = 5000;

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

/// W and q. Errors in words: sizes that do not fit, an M that cannot be factored.
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
    // H with f as one more column.
    let mut columns = Mat::zeros(dofs, n + 1);
    for i in 0..dofs {
        rows.row(i).for_each(|(j, x)| columns[(i, j)] = x);
        columns[(i, n)] = load[i];
    }
    let product = if is_symmetric(mass) {
        let factor = factor(mass)?;
        for j in 0..=n {
            let half = factor.forward(columns.col_as_slice(j));
            columns.col_as_slice_mut(j).copy_from_slice(&half);
        }
        gram(&columns)
    } else {
        transpose_product(&columns, &solved(mass, &columns)?)
    };
    let mut triplets = Vec::new();
    for j in 0..n {
        let column = product.col_as_slice(j)[..n].iter().enumerate();
        triplets.extend(column.filter(|(_, x)| **x != 0.0).map(|(i, &x)| (i, j, x)));
    }
    let works = product.col_as_slice(n).iter();
    let free = works.zip(velocity).map(|(work, w)| work + w).collect();
    Ok((SparseMatrix::from_triplets(n, n, &triplets), free))
}

/// M differs from its transpose by rounding only.
fn is_symmetric(mass: &SparseMatrix) -> bool {
    let all = triplets(mass);
    let largest = all.iter().fold(0.0, |s: f64, t| s.max(t.2.abs()));
    let mirrored = all.iter().map(|&(i, j, x)| (j, i, -x));
    let both: Vec<_> = all.iter().copied().chain(mirrored).collect();
    let difference = SparseMatrix::from_triplets(mass.rows(), mass.rows(), &both);
    let rounding = |i: usize| {
        let mut row = difference.row(i);
        row.all(|(_, x)| x.abs() <= SYMMETRY * largest)
    };
    (0..mass.rows()).all(rounding)
}

fn triplets(matrix: &SparseMatrix) -> Vec<(usize, usize, f64)> {
    let row = |i| matrix.row(i).map(move |(j, x)| (i, j, x));
    (0..matrix.rows()).flat_map(row).collect()
}

/// M⁻¹ of columns by a dense LU.
fn solved(mass: &SparseMatrix, columns: &Mat<f64>) -> Result<Mat<f64>, String> {
    let dofs = mass.rows();
    if dofs > DENSE {
        return Err(format!(
            "M is not symmetric and has {dofs} rows, more than the {DENSE} that are factored densely"
        ));
    }
    let mut dense = Mat::zeros(dofs, dofs);
    for (i, j, x) in triplets(mass) {
        dense[(i, j)] = x;
    }
    let mut solution = columns.clone();
    let factors = Lu::new(dense).map_err(|error| format!("M cannot be factored: {error}"))?;
    factors.solve_in_place(&mut solution);
    Ok(solution)
}

fn factor(mass: &SparseMatrix) -> Result<Cholesky, String> {
    let dofs = mass.rows();
    let triplets = triplets(mass);
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
    fn unsymmetric_masses_are_taken_as_they_are() {
        // M⁻¹ = [2 −1; −0.5 2] / 3.5.
        let (matrix, free) = condense(&global(0.5)).unwrap();
        let expected = [[18.0, -9.0], [-4.5, 18.0]];
        for (i, expected) in expected.iter().enumerate() {
            for (j, x) in matrix.row(i) {
                assert!((x - expected[j] / 3.5).abs() < 1e-14);
            }
        }
        assert!((free[0] - 0.5 - 18.0 / 3.5).abs() < 1e-14);
        assert!((free[1] + 4.5 / 3.5).abs() < 1e-14);
    }

    #[test]
    fn masses_that_are_none_are_told() {
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
