//! The Signorini corner function of the Laplacian on the upper half plane, u = −r^{3/2} sin(3θ/2).
//!
//! Δu = 0 for 0 < θ < π. On θ = 0 the body touches: u = 0 and ∂u/∂n = (3/2)√r ≥ 0 with n = −e_y.
//! On θ = π it is open: u = r^{3/2} ≥ 0 and ∂u/∂n = 0. This is the singularity of every unilateral transition
//! (H^{5/2−ε}). Derived from the real part of z^{3/2}; P. Grisvard, Elliptic Problems in Nonsmooth Domains, 1985, chapter 4.

use crate::geometry::Point;

/// u at a point of the closed upper half plane.
pub fn corner_value([x, y]: Point<2>) -> f64 {
    let theta = y.atan2(x);
    -x.hypot(y).powf(1.5) * (1.5 * theta).sin()
}

/// ∇u at a point of the closed upper half plane.
pub fn corner_gradient([x, y]: Point<2>) -> [f64; 2] {
    let half = 0.5 * y.atan2(x);
    let scale = -1.5 * x.hypot(y).sqrt();
    [scale * half.sin(), scale * half.cos()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::check::{close, derivative};

    #[test]
    fn the_corner_function_is_harmonic_with_that_gradient() {
        for [x, y] in [[0.7, 0.4], [-0.3, 0.6], [-1.0, 0.2]] {
            let [gx, gy] = corner_gradient([x, y]);
            close(gx, derivative(|s| corner_value([s, y]), x, 1e-3), 1e-9);
            close(gy, derivative(|s| corner_value([x, s]), y, 1e-3), 1e-9);
            let laplace = derivative(|s| corner_gradient([s, y])[0], x, 1e-3)
                + derivative(|s| corner_gradient([x, s])[1], y, 1e-3);
            close(laplace, 0.0, 1e-8);
        }
    }

    #[test]
    fn it_touches_on_one_side_and_is_open_on_the_other() {
        close(corner_value([2.0, 0.0]), 0.0, 0.0);
        assert!(-corner_gradient([2.0, 0.0])[1] > 0.0);
        assert!(corner_value([-2.0, 0.0]) > 0.0);
        close(corner_gradient([-2.0, 0.0])[1], 0.0, 1e-15);
    }
}
