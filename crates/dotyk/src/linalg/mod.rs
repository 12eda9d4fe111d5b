//! Sparse matrices, orderings and factorisations; the only module that names the linear-algebra library.

pub(crate) mod dense;

pub use faer::{Mat, MatMut, MatRef};

/// A symmetric linear map of vectors of length `len`.
pub trait LinearOperator: Send + Sync {
    /// Length of its vectors.
    fn len(&self) -> usize;
    /// Whether its vectors are empty.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// y = Ax.
    fn apply(&self, x: &[f64], y: &mut [f64]);
}
