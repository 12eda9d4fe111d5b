//! Shape functions of a cell: polynomials that are one at their own node and zero at the others.
//!
//! Nᵢ(ξ) = Σₖ Cₖᵢ mₖ(ξ) with the monomials mₖ of the cell and C the inverse of their values at its nodes, so that a new cell
//! is a new table and no new formula.

/// Polynomials that are one at their own node and zero at the others.
pub(crate) struct Basis {
    exponents: &'static [[u8; 3]],
    /// C, (monomials, nodes).
    coefficients: Vec<f64>,
}

impl Basis {
    /// Inverts the values V (nodes, monomials) of the monomials at the nodes.
    pub fn new(nodes: &[[f64; 3]], exponents: &'static [[u8; 3]]) -> Self {
        let n = nodes.len();
        let mut left: Vec<Vec<f64>> = nodes
            .iter()
            .map(|node| exponents.iter().map(|&e| monomial(node, e)).collect())
            .collect();
        let mut right: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
            .collect();
        for k in 0..n {
            let pivot = (k..n)
                .max_by(|&a, &b| left[a][k].abs().total_cmp(&left[b][k].abs()))
                .unwrap_or(k);
            left.swap(k, pivot);
            right.swap(k, pivot);
            let scale = 1.0 / left[k][k];
            for j in 0..n {
                left[k][j] *= scale;
                right[k][j] *= scale;
            }
            for i in (0..n).filter(|&i| i != k) {
                let factor = left[i][k];
                for j in 0..n {
                    left[i][j] -= factor * left[k][j];
                    right[i][j] -= factor * right[k][j];
                }
            }
        }
        // The coefficients of all kinds are multiples of 1/8: rounding to them removes the error of the elimination,
        // so that the values at the nodes are exactly zero and one.
        let coefficients = right
            .concat()
            .iter()
            .map(|c| (8.0 * c).round() / 8.0)
            .collect();
        Self {
            exponents,
            coefficients,
        }
    }

    /// Nᵢ(ξ); coordinates beyond those of the cell are ignored.
    pub fn values(&self, xi: &[f64], values: &mut [f64]) {
        let n = self.exponents.len();
        values[..n].fill(0.0);
        for (&exponents, row) in self.exponents.iter().zip(self.coefficients.chunks_exact(n)) {
            let m = monomial(xi, exponents);
            for (value, c) in values.iter_mut().zip(row) {
                *value += c * m;
            }
        }
    }

    /// ∂Nᵢ/∂ξ, zero beyond the dimension of the cell.
    pub fn gradients<const D: usize>(&self, xi: &[f64], gradients: &mut [[f64; D]]) {
        let n = self.exponents.len();
        gradients[..n].fill([0.0; D]);
        for (&exponents, row) in self.exponents.iter().zip(self.coefficients.chunks_exact(n)) {
            let slope: [f64; D] = std::array::from_fn(|d| {
                let mut lower = exponents;
                match exponents.get(d) {
                    Some(&e) if e > 0 => {
                        lower[d] = e - 1;
                        f64::from(e) * monomial(xi, lower)
                    }
                    _ => 0.0,
                }
            });
            for (gradient, c) in gradients.iter_mut().zip(row) {
                for d in 0..D {
                    gradient[d] += c * slope[d];
                }
            }
        }
    }
}

/// ξ^a η^b ζ^c, up to squares without a call; coordinates beyond the last count as one.
fn monomial(xi: &[f64], exponents: [u8; 3]) -> f64 {
    xi.iter()
        .zip(exponents)
        .map(|(&x, e)| match e {
            0 => 1.0,
            1 => x,
            2 => x * x,
            e => x.powi(i32::from(e)),
        })
        .product()
}
