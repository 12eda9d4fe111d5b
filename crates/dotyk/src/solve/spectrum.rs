//! Upper bound of the largest eigenvalue of a symmetric operator: a few Lanczos steps and a residual bound.
//!
//! The largest Ritz value θ plus the norm of its residual bounds an eigenvalue from above; in practice the largest
//! one. The start is a fixed pseudo-random vector, so that the bits are the same in every run.

use crate::linalg::Mat;
use crate::linalg::dense::symmetric_eigen;
use crate::solve::{dot, norm};

/// Lanczos steps used by the solvers: each is one product.
pub(crate) const STEPS: usize = 10;

/// A new vector below this part of its image is rounding: the space before is invariant.
const INVARIANT: f64 = 1e-14;

/// θ + residual after at most `steps` products y = Ax with vectors of length `n`; zero for the zero operator.
pub(crate) fn largest_eigenvalue(
    n: usize,
    steps: usize,
    mut apply: impl FnMut(&[f64], &mut [f64]),
) -> f64 {
    let mut basis = vec![start(n)];
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut image = vec![0.0; n];
    for step in 0..steps.min(n) {
        apply(&basis[step], &mut image);
        diagonal.push(dot(&basis[step], &image));
        let size = norm(&image);
        for _ in 0..2 {
            for q in &basis {
                let part = dot(q, &image);
                for (w, q) in image.iter_mut().zip(q) {
                    *w -= part * q;
                }
            }
        }
        let rest = norm(&image);
        if rest <= INVARIANT * size {
            beside.push(0.0);
            break;
        }
        beside.push(rest);
        basis.push(image.iter().map(|w| w / rest).collect());
    }
    let k = diagonal.len();
    let tridiagonal = Mat::from_fn(k, k, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    match symmetric_eigen(&tridiagonal) {
        Ok((values, vectors)) if k > 0 => {
            let residual = beside[k - 1] * vectors[(k - 1, k - 1)].abs();
            values[k - 1] + residual
        }
        _ => 0.0,
    }
}

/// Unit vector of uniform pseudo-random numbers (splitmix64).
pub(crate) fn start(n: usize) -> Vec<f64> {
    let mut state: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut vector: Vec<f64> = (0..n)
        .map(|_| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        })
        .collect();
    let length = norm(&vector);
    vector.iter_mut().for_each(|x| *x /= length);
    vector
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bound_lies_above_the_largest_eigenvalue_and_close() {
        // Eigenvalues 1, 1/4, 1/9, ...: those of a compliance with smooth modes.
        let mut products = 0;
        let apply = |x: &[f64], y: &mut [f64]| {
            products += 1;
            for (i, (y, x)) in y.iter_mut().zip(x).enumerate() {
                *y = x / ((i + 1) * (i + 1)) as f64;
            }
        };
        let bound = largest_eigenvalue(200, STEPS, apply);
        assert!((1.0..1.01).contains(&bound), "{bound}");
        assert_eq!(products, STEPS);
    }

    #[test]
    fn small_and_zero_operators_are_exact() {
        let bound = largest_eigenvalue(1, STEPS, |x, y| y[0] = 3.0 * x[0]);
        assert!((bound - 3.0).abs() < 1e-15);
        let zero = largest_eigenvalue(5, STEPS, |_, y| y.fill(0.0));
        assert_eq!(zero, 0.0);
        assert_eq!(largest_eigenvalue(0, STEPS, |_, _| ()), 0.0);
    }

    #[test]
    fn start_is_the_sequence_of_splitmix_without_its_first_number() {
        // the second to the fourth number of the generator with seed 0, as its authors print them
        let numbers: [u64; 3] = [
            0x6e78_9e6a_a1b9_65f4,
            0x06c4_5d18_8009_454f,
            0xf88b_b8a8_724c_81ec,
        ];
        let uniform = numbers.map(|x| (x >> 11) as f64 / 2f64.powi(53) - 0.5);
        let length = uniform.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (found, x) in start(3).iter().zip(uniform) {
            assert!((found - x / length).abs() < 1e-15);
        }
    }

    #[test]
    fn as_many_steps_as_unknowns_give_the_largest_eigenvalue_itself() {
        // eigenvalues 1, 2, .. in the basis of a reflection; the largest one in size is negative
        for n in [2usize, 5, STEPS] {
            let v: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            let square: f64 = v.iter().map(|x| x * x).sum();
            let values: Vec<f64> = (0..n)
                .map(|i| if i == 0 { -20.0 } else { i as f64 })
                .collect();
            let reflect = |x: &[f64]| -> Vec<f64> {
                let part = 2.0 * dot(&v, x) / square;
                x.iter().zip(&v).map(|(x, v)| x - part * v).collect()
            };
            let bound = largest_eigenvalue(n, STEPS, |x, y| {
                let mut inside = reflect(x);
                inside
                    .iter_mut()
                    .zip(&values)
                    .for_each(|(x, value)| *x *= value);
                y.copy_from_slice(&reflect(&inside));
            });
            assert!(
                (bound - (n - 1) as f64).abs() < 1e-12 * 20.0,
                "{n}: {bound}"
            );
        }
    }

    #[test]
    fn two_steps_give_the_ritz_value_and_the_norm_of_its_residual() {
        let n = 30;
        let value = |i: usize| 1.0 / (1.0 + i as f64);
        let apply = |x: &[f64], y: &mut [f64]| {
            (0..x.len()).for_each(|i| y[i] = value(i) * x[i]);
        };
        let bound = largest_eigenvalue(n, 2, apply);
        // the plane of the start and its image, by hand
        let image = |x: &[f64]| {
            let mut y = vec![0.0; n];
            apply(x, &mut y);
            y
        };
        let q = start(n);
        let (own, mut w) = (dot(&q, &image(&q)), image(&q));
        w.iter_mut().zip(&q).for_each(|(w, q)| *w -= own * q);
        let beside = norm(&w);
        w.iter_mut().for_each(|w| *w /= beside);
        let other = dot(&w, &image(&w));
        let half = 0.5 * (own - other);
        let theta = 0.5 * (own + other) + (half * half + beside * beside).sqrt();
        let turn = f64::atan2(theta - own, beside);
        let ritz: Vec<f64> = q
            .iter()
            .zip(&w)
            .map(|(q, w)| turn.cos() * q + turn.sin() * w)
            .collect();
        let left = image(&ritz)
            .iter()
            .zip(&ritz)
            .map(|(a, r)| a - theta * r)
            .collect::<Vec<_>>();
        assert!((bound - theta - norm(&left)).abs() < 1e-13, "{bound}");
    }

    #[test]
    fn invariant_subspace_ends_the_steps() {
        // two eigenvalues: the third vector is rounding
        let mut products = 0;
        let bound = largest_eigenvalue(40, STEPS, |x, y| {
            products += 1;
            (0..40).for_each(|i| y[i] = if i < 20 { 3.0 * x[i] } else { x[i] });
        });
        assert!((bound - 3.0).abs() < 1e-13, "{bound}");
        assert_eq!(products, 2);
    }
}
