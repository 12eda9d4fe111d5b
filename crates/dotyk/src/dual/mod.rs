//! The waist: the dual contact problem, its admissible set, its projection and its certificate. Pure algebra.
//!
//! ```text
//!   min  1/2 λᵀFλ − dᵀλ    over λ ∈ Λ,  subject to  Gλ = e,     gap(λ, α) = Fλ − d − Gᵀα
//! ```
//!
//! It knows no mesh, no body, no dimension.

use crate::linalg::{LinearOperator, Mat};

/// F, the compliance of the bodies seen from the contact unknowns: (m, m), symmetric, positive semidefinite.
pub enum Compliance {
    /// Assembled.
    Dense(Mat<f64>),
    /// Applied by one solve with each factored body.
    Operator {
        /// x ↦ Fx.
        apply: Box<dyn LinearOperator>,
        /// x ↦ Mx, an approximation of F⁻¹ (scaled Dirichlet preconditioner).
        preconditioner: Box<dyn LinearOperator>,
    },
}

/// What one contact node can bear; its block of λ is (normal, tangential..).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Block {
    /// Any force of that many components (tied).
    Free {
        /// Number of components.
        size: usize,
    },
    /// One normal component, λₙ ≥ 0.
    Unilateral,
    /// λₙ ≥ 0 and ‖λₜ‖ ≤ bound (a force).
    Tresca {
        /// Number of tangential components.
        tangents: usize,
        /// Bound of the tangential force.
        bound: f64,
    },
    /// λₙ ≥ 0 and ‖λₜ‖ ≤ coefficient · λₙ.
    Coulomb {
        /// Number of tangential components.
        tangents: usize,
        /// Coefficient of friction.
        coefficient: f64,
    },
}

/// Gλ = e, the balance of the floating bodies; r = 0 when nothing floats.
pub struct Equilibrium {
    /// G, (r, m).
    pub modes: Mat<f64>,
    /// e, (r,): work of the loads on each mode.
    pub load: Vec<f64>,
}

/// λ and α: contact forces (m,) and rigid amplitudes (r,), the multiplier of Gλ = e.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipliers {
    /// Contact forces (m,).
    pub lambda: Vec<f64>,
    /// Rigid displacement amplitudes of the floating bodies (r,).
    pub alpha: Vec<f64>,
}

/// One figure of the certificate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figure {
    /// The violation in the problem's units.
    pub value: f64,
    /// The violation over its scale.
    pub relative: f64,
    /// Largest admissible `relative`.
    pub limit: f64,
}

impl Figure {
    /// A violation against its scale (1 where the scale is zero).
    pub fn new(value: f64, scale: f64, limit: f64) -> Self {
        let relative = if scale > 0.0 { value / scale } else { value };
        Self {
            value,
            relative,
            limit,
        }
    }

    /// The figure is within its limit; NaN is not.
    pub fn holds(&self) -> bool {
        self.relative <= self.limit
    }
}

/// What was checked of an answer: the only judge of convergence, whoever solved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Certificate {
    /// Largest penetration, a length.
    pub penetration: Figure,
    /// Largest tension of a unilateral contact, a force.
    pub tension: Figure,
    /// Σ|λ·gap|, an energy.
    pub complementarity: Figure,
    /// Largest resultant force of a body that is not balanced.
    pub imbalance_force: Figure,
    /// Largest resultant moment of a body that is not balanced.
    pub imbalance_moment: Figure,
    /// Difference of primal and dual energy.
    pub energy_gap: Figure,
    /// Violation of the friction law, a force.
    pub slip_violation: Figure,
}

impl Certificate {
    /// The figures with their names in `summary.json`, in its order.
    pub fn figures(&self) -> [(&'static str, Figure); 7] {
        [
            ("penetration", self.penetration),
            ("tension", self.tension),
            ("complementarity", self.complementarity),
            ("imbalance_force", self.imbalance_force),
            ("imbalance_moment", self.imbalance_moment),
            ("energy_gap", self.energy_gap),
            ("slip_violation", self.slip_violation),
        ]
    }

    /// Every figure is within its limit.
    pub fn holds(&self) -> bool {
        self.figures().iter().all(|(_, figure)| figure.holds())
    }
}
