//! What one contact node can bear: its block of Λ, and the laws of friction.
//!
//! ```text
//!   λₙ ≥ 0,   ‖λₜ‖ ≤ bound(λₙ) = given + growth · λₙ
//!   where ‖λₜ‖ < bound nothing slips, else λₜ = bound · slip/‖slip‖
//! ```
//!
//! | Law | given | growth | an open node, λₙ = 0 |
//! |---|---|---|---|
//! | Tresca | its bound | 0 | bears shear up to the bound, too: the problem is the minimum of a convex functional |
//! | Coulomb | 0 | its coefficient | bears none |
//! | Cohesive | its cohesion | its coefficient | bears none |
//!
//! A law is told by given, growth and whether its bound *follows* from the normal force. Where a bound follows the problem
//! minimises nothing: it is solved as a fixed point of problems whose bounds are given, or by Newton's method on what the
//! nodes do. All else is derived from these three: the projection onto {λₙ ≥ 0, ‖λₜ‖ ≤ given + growth · λₙ}, which is convex,
//! and its derivative; forces that generate this set; the law of several nodes taken as one; the block without slip.
//!
//! The bound of a cohesive law jumps where the node opens. At λₙ = 0 the node is open, with a gap or without: what bears shear
//! without a normal force could not be told from what merely touches. So that no rounding decides about a shear, a normal force
//! that is nothing beside the largest one counts as zero there. The set above is then the closure of the convex hull of what
//! the law allows, and a problem need not have a solution: a shear may ask for a normal force that it itself takes away.
//!
//! A node has one tangent in the plane and two in space: the set is a disc beside every λₙ, and nothing here counts them.

use crate::linalg::dense::{dot, norm};

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
    /// λₙ ≥ 0, and a law bounds the tangential force.
    Frictional {
        /// Number of tangential components.
        tangents: usize,
        /// Which law.
        law: Friction,
    },
}

/// A law of friction: the bound of the tangential force beside a normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Friction {
    /// ‖λₜ‖ ≤ bound (a force), whatever λₙ is.
    Tresca {
        /// Bound of the tangential force.
        bound: f64,
    },
    /// ‖λₜ‖ ≤ coefficient · λₙ.
    Coulomb {
        /// Coefficient of friction.
        coefficient: f64,
    },
    /// ‖λₜ‖ ≤ cohesion + coefficient · λₙ while the node is closed, λₙ > 0; an open one bears no shear.
    Cohesive {
        /// What it bears beside no more than a trace of a normal force: a force.
        cohesion: f64,
        /// Coefficient of friction.
        coefficient: f64,
    },
}

/// A normal force below this part of the largest force is none: projected methods leave traces where a contact is open.
pub(crate) const NONE: f64 = 1e-10;

impl Friction {
    /// The block of a node with this law.
    pub fn block(self, tangents: usize) -> Block {
        let law = self;
        Block::Frictional { tangents, law }
    }

    /// Given, a force, and growth, a number: the bound of a closed node is given + growth · λₙ.
    pub(crate) fn terms(&self) -> (f64, f64) {
        match *self {
            Self::Tresca { bound } => (bound, 0.0),
            Self::Coulomb { coefficient } => (0.0, coefficient),
            Self::Cohesive {
                cohesion,
                coefficient,
            } => (cohesion, coefficient),
        }
    }

    /// The bound follows from the normal force, and an open node bears no shear.
    pub(crate) fn follows(&self) -> bool {
        !matches!(self, Self::Tresca { .. })
    }

    /// The law of several nodes taken as one, which all have this kind of law: forces add up, coefficients are averaged.
    pub(crate) fn together(self, all: &[Self]) -> Self {
        let sum =
            |term: fn((f64, f64)) -> f64| all.iter().map(|law| term(law.terms())).sum::<f64>();
        let mean = || sum(|(_, growth)| growth) / all.len() as f64;
        match self {
            Self::Tresca { .. } => Self::Tresca {
                bound: sum(|(given, _)| given),
            },
            Self::Coulomb { .. } => Self::Coulomb {
                coefficient: mean(),
            },
            Self::Cohesive { .. } => Self::Cohesive {
                cohesion: sum(|(given, _)| given),
                coefficient: mean(),
            },
        }
    }

    /// Whether a node bears shear at all, by whether it is closed.
    pub(crate) fn bears(&self, closed: bool) -> bool {
        closed || !self.follows()
    }

    /// The bound jumps from zero where the node closes.
    pub(super) fn jumps(&self) -> bool {
        self.follows() && self.terms().0 > 0.0
    }

    /// No node bears shear, whatever its normal force is.
    pub(crate) fn is_smooth(&self) -> bool {
        let (given, growth) = self.terms();
        given <= 0.0 && growth <= 0.0
    }

    /// Largest tangential force beside the normal force `normal`.
    pub fn bound(&self, normal: f64) -> f64 {
        let (given, growth) = self.terms();
        match self.bears(normal > 0.0) {
            true => given + growth * normal.max(0.0),
            false => 0.0,
        }
    }

    /// Nearest point of {λₙ ≥ 0, ‖λₜ‖ ≤ given + growth · λₙ}. Shapes: (1 + tangents,).
    fn project(&self, from: &[f64], to: &mut [f64]) {
        let (given, growth) = self.terms();
        let (n, length) = (from[0], norm(&from[1..]));
        if n >= 0.0 && length <= given + growth * n {
            to.copy_from_slice(from);
            return;
        }
        to[0] = self.beside(n, length).max(0.0);
        let bound = given + growth * to[0];
        let factor = if length > bound { bound / length } else { 1.0 };
        for (to, from) in to[1..].iter_mut().zip(&from[1..]) {
            // where nothing is borne, zero has no sign
            *to = if bound > 0.0 { factor * from } else { 0.0 };
        }
    }

    /// Normal component of the nearest point with ‖λₜ‖ = given + growth · λₙ, of whatever sign.
    fn beside(&self, n: f64, length: f64) -> f64 {
        let (given, growth) = self.terms();
        (n + growth * (length - given)) / (1.0 + growth * growth)
    }

    /// Derivative of the projection at y in direction v. Shapes: all (1 + tangents,).
    fn project_derivative(&self, y: &[f64], v: &[f64], out: &mut [f64]) {
        let (given, growth) = self.terms();
        let (n, length) = (y[0], norm(&y[1..]));
        if n > 0.0 && length <= given + growth * n {
            out.copy_from_slice(v);
            return;
        }
        let normal = self.beside(n, length);
        let change = match normal > 0.0 {
            true => (v[0] + growth * (dot(&y[1..], &v[1..]) / length)) / (1.0 + growth * growth),
            false => 0.0,
        };
        out[0] = change;
        let bound = given + growth * normal.max(0.0);
        let (y, v, out) = (&y[1..], &v[1..], &mut out[1..]);
        if bound <= 0.0 {
            out.fill(0.0);
        } else if length <= bound {
            out.copy_from_slice(v);
        } else {
            turn(y, length, bound / length, growth * change, v, out);
        }
    }
}

/// out = across · (v − t(t·v)) + along · t, with t = y/‖y‖.
fn turn(y: &[f64], length: f64, across: f64, along: f64, v: &[f64], out: &mut [f64]) {
    let component = dot(y, v) / length;
    for ((out, v), y) in out.iter_mut().zip(v).zip(y) {
        let t = y / length;
        *out = across * (v - component * t) + along * t;
    }
}

/// Σ sⱼ shearsⱼ with the unit vector s for which it lies farthest along `towards`. Shapes: all (k,).
pub(super) fn farthest(shears: &[Vec<f64>], towards: &[f64]) -> Vec<f64> {
    let along: Vec<f64> = shears.iter().map(|shear| dot(shear, towards)).collect();
    let length = norm(&along);
    let mut sum = vec![0.0; towards.len()];
    if length > 0.0 {
        for (shear, along) in shears.iter().zip(&along) {
            for (sum, x) in sum.iter_mut().zip(shear) {
                *sum += along / length * x;
            }
        }
    }
    sum
}

/// What the forces of a block do: the sums of `rays` with weights ≥ 0, of the edges of a round cone with weights ≥ 0, and of
/// one point of a disc. Of a law whose bound follows this is the convex hull of what it allows.
#[derive(Default)]
pub(super) struct Generators {
    pub rays: Vec<Vec<f64>>,
    /// Axis and radii: its edges are axis + Σ sⱼ radiiⱼ, ‖s‖ = 1. Those along the radii are among the rays.
    pub cone: Option<(Vec<f64>, Vec<Vec<f64>>)>,
    /// Radii.
    pub disc: Option<Vec<Vec<f64>>>,
}

impl Block {
    /// Number of components of λ in the block.
    pub fn size(&self) -> usize {
        match *self {
            Self::Free { size } => size,
            Self::Unilateral => 1,
            Self::Frictional { tangents, .. } => 1 + tangents,
        }
    }

    /// Any force is admissible.
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free { .. })
    }

    /// Its law of friction, where it has one.
    pub fn friction(&self) -> Option<Friction> {
        match *self {
            Self::Frictional { law, .. } => Some(law),
            Self::Free { .. } | Self::Unilateral => None,
        }
    }

    /// Largest tangential force beside the normal force `normal`; `None` where there is no friction law.
    pub fn bound(&self, normal: f64) -> Option<f64> {
        self.friction().map(|law| law.bound(normal))
    }

    /// The same block with another law of friction, where it has one.
    pub(crate) fn with_friction(self, law: impl FnOnce(Friction) -> Friction) -> Self {
        match self {
            Self::Frictional { tangents, law: own } => law(own).block(tangents),
            other => other,
        }
    }

    /// The blocks that bear any shear beside a normal force, if this one bears any shear at all: it cannot slip.
    pub(super) fn sticking(self) -> Vec<Self> {
        match self {
            Self::Frictional { tangents, law } if law.is_smooth() => {
                vec![Friction::Tresca { bound: 0.0 }.block(tangents)]
            }
            Self::Frictional { tangents, .. } => {
                vec![Self::Unilateral, Self::Free { size: tangents }]
            }
            other => vec![other],
        }
    }

    /// Nearest force that the block can bear. Shapes: (size,).
    pub(super) fn project(&self, from: &[f64], to: &mut [f64]) {
        match self {
            Self::Free { .. } => to.copy_from_slice(from),
            Self::Unilateral => to[0] = from[0].max(0.0),
            Self::Frictional { law, .. } => law.project(from, to),
        }
    }

    /// Derivative of the projection at y in direction v. Shapes: (size,).
    pub(super) fn project_derivative(&self, y: &[f64], v: &[f64], out: &mut [f64]) {
        match self {
            Self::Free { .. } => out.copy_from_slice(v),
            Self::Unilateral => out[0] = if y[0] > 0.0 { v[0] } else { 0.0 },
            Self::Frictional { law, .. } => law.project_derivative(y, v, out),
        }
    }

    /// What generates the images of its forces, from the images of its components.
    pub(super) fn generators(&self, mut images: Vec<Vec<f64>>) -> Generators {
        let scaled = |factor: f64, images: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let scale = |image: &Vec<f64>| image.iter().map(|x| factor * x).collect();
            images.iter().map(scale).collect()
        };
        let mut all = Generators::default();
        let Some((given, growth)) = self.friction().map(|law| law.terms()) else {
            if self.is_free() {
                let opposite = scaled(-1.0, &images);
                let pairs = opposite.into_iter().zip(images);
                images = pairs.flat_map(|(a, b)| [a, b]).collect();
            }
            all.rays = images;
            return all;
        };
        if given > 0.0 {
            all.disc = Some(scaled(given, &images[1..]));
        }
        let radii = scaled(growth, &images[1..]);
        let axis = images.swap_remove(0);
        if growth <= 0.0 {
            all.rays.push(axis);
            return all;
        }
        for radius in &radii {
            for sign in [-1.0, 1.0] {
                let edge = axis.iter().zip(radius).map(|(n, t)| n + sign * t);
                all.rays.push(edge.collect());
            }
        }
        all.cone = (radii.len() > 1).then_some((axis, radii));
        all
    }
}
