//! Approximate minimum degree.
//!
//! Source: P. R. Amestoy, T. A. Davis, I. S. Duff, An approximate minimum degree ordering algorithm, SIAM J. Matrix Anal. Appl. 17
//! (1996) 886–905.

use dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// Approximate minimum degree of `n` nodes, each with its neighbours among them.
pub(super) fn minimum_degree<N: Iterator<Item = u32>>(
    n: usize,
    neighbours: impl Fn(usize) -> N,
) -> Vec<u32> {
    let mut col_start = Vec::with_capacity(n + 1);
    let mut row_index = Vec::with_capacity(8 * n);
    col_start.push(0u32);
    for j in 0..n {
        row_index.extend(neighbours(j).filter(|&i| (i as usize) < j));
        row_index.push(j as u32);
        col_start.push(row_index.len() as u32);
    }
    let upper = SymbolicSparseColMatRef::new_unsorted_checked(n, n, &col_start, None, &row_index);
    let (mut order, mut inverse) = (vec![0u32; n], vec![0u32; n]);
    let mut memory = MemBuffer::new(amd::order_scratch::<u32>(n, row_index.len()));
    let stack = MemStack::new(&mut memory);
    match amd::order(
        &mut order,
        &mut inverse,
        upper,
        amd::Control::default(),
        stack,
    ) {
        Ok(_) => order,
        // Only a graph beyond 32-bit indices fails; any order is a valid one.
        Err(_) => (0..n as u32).collect(),
    }
}
