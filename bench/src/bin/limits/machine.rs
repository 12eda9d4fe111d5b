//! The rates of a machine.

use dotyk::linalg::{Mat, product};
use rayon::prelude::*;
use std::time::Instant;

/// What so many threads do together.
pub struct Machine {
    pub threads: usize,
    /// GFlop/s of products of dense matrices.
    pub peak: f64,
    /// GB/s of sums of long vectors.
    pub read: f64,
    /// GB/s of a ← b + sc.
    pub triad: f64,
}

/// Rows of the matrices, and numbers of the vectors of a thread: beyond any cache.
const ROWS: usize = 1024;
const NUMBERS: usize = 1 << 24;

/// Each is measured so often; the fastest counts.
const TURNS: usize = 5;

impl Machine {
    pub fn measured(threads: usize) -> Self {
        let each = |work: &(dyn Fn(usize) + Sync)| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let all = || (0..threads).into_par_iter().for_each(work);
            let mut least = f64::INFINITY;
            for _ in 0..TURNS {
                let clock = Instant::now();
                match &pool {
                    Ok(pool) => pool.install(all),
                    Err(_) => all(),
                }
                least = least.min(clock.elapsed().as_secs_f64());
            }
            least
        };
        let matrix = Mat::from_fn(ROWS, ROWS, |i, j| ((3 * i + 7 * j) % 11) as f64 - 5.0);
        let seconds = each(&|_| {
            std::hint::black_box(product(&matrix, &matrix));
        });
        let flops = 2.0 * (ROWS as f64).powi(3) * threads as f64;
        let vectors = |value: f64| vec![vec![value; NUMBERS]; threads];
        let (b, c) = (vectors(1.0), vectors(2.0));
        let summed = each(&|thread| {
            std::hint::black_box(sum(&b[thread]));
        });
        let a: Vec<_> = vectors(0.0)
            .into_iter()
            .map(std::sync::Mutex::new)
            .collect();
        let added = each(&|thread| {
            if let Ok(mut a) = a[thread].lock() {
                let terms = b[thread].iter().zip(&c[thread]);
                a.iter_mut()
                    .zip(terms)
                    .for_each(|(a, (b, c))| *a = b + 3.0 * c);
            }
        });
        let bytes = 8.0 * (NUMBERS * threads) as f64;
        Self {
            threads,
            peak: 1e-9 * flops / seconds,
            read: 1e-9 * bytes / summed,
            triad: 3e-9 * bytes / added,
        }
    }
}

/// The sum in eight parts, so that no addition waits for the one before.
fn sum(values: &[f64]) -> f64 {
    let mut parts = [0.0; 8];
    for eight in values.chunks_exact(8) {
        parts.iter_mut().zip(eight).for_each(|(part, x)| *part += x);
    }
    parts.iter().sum()
}
