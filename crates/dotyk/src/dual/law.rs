//! Admissible forces of one contact node: its block of Λ, and the laws of friction.
//!
//! ```text
//!   λₙ ≥ 0,   ‖λₜ‖ ≤ bound(λₙ)
//!   where ‖λₜ‖ < bound nothing slips, else λₜ = bound · slip/‖slip‖
//! ```
//!
//! | Law | bound(λₙ) of a closed node | an open node, λₙ = 0 |
//! |---|---|---|
//! | Tresca | its bound | bears shear up to the bound, too: the problem is the minimum of a convex functional |
//! | Coulomb | coefficient · λₙ | bears none |
//! | Cohesive | cohesion + coefficient · λₙ | bears none |
//!
//! A law answers two questions. *Where does its bound touch* a normal force: which straight line given + growth · λₙ has the value
//! and the slope of the bound there, and how does the slope change? And does the bound *follow* from the normal force? Where it does
//! the problem is no minimum: it is solved as a fixed point of problems with given bounds, or by Newton's method on the states of the
//! nodes. All else is derived from these two: the projection onto {λₙ ≥ 0, ‖λₜ‖ ≤ bound(λₙ)} and its derivative; forces that
//! generate this set; the block without slip.
//!
//! A bound never falls, and is concave: the set is convex, and a touching line lies nowhere below the bound. The bound may be a
//! straight line; if it bends it does so at λₙ = 0 already, and less and less as λₙ grows, so that Newton's method cannot overshoot.
//!
//! The bound of a cohesive law jumps where the node opens. At λₙ = 0 the node is open, with a gap or without: a node that bears
//! shear without a normal force could not be distinguished from one that merely touches. A normal force that is negligible beside
//! the largest one counts as zero there, so that rounding does not decide about a shear. The set above is then the closure of the
//! convex hull of the admissible forces, and a problem need not have a solution: a shear may need a normal force that it removes.
//!
//! A node has one tangent in the plane and two in space: the set is a disc beside every λₙ, and nothing here counts them.
//!
//! A bar that yields in tension and compression bears |λ| ≤ bound: such an interval is a bounded shear without a normal force.
//! λ counts from the middle of the admissible forces; the force there is a load like any other.

use std::ops::Range;

use crate::linalg::SparseVector;
use crate::linalg::dense::{dot, norm};

/// Admissible forces of one contact node; its block of λ is (normal, tangential..).
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
    /// One force along a line, |λ| ≤ bound.
    Interval {
        /// A force.
        bound: f64,
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
        /// Shear that it bears beside a vanishing normal force λₙ > 0: a force.
        cohesion: f64,
        /// Coefficient of friction.
        coefficient: f64,
    },
    /// ‖λₜ‖ ≤ limit · (1 − exp(−coefficient · λₙ / limit)): the law of the tests for bounds that bend.
    #[cfg(test)]
    Saturating {
        /// Shear that no normal force exceeds: a force > 0.
        limit: f64,
        /// Coefficient of friction beside a small normal force.
        coefficient: f64,
    },
}

/// A block as files and other languages know it.
pub struct Told {
    /// Its law, in a word.
    pub name: &'static str,
    /// Its place in [`Block::LAWS`].
    pub kind: usize,
    /// A force: what bounds its shears, or the part of their bound without a normal force.
    pub bound: Option<f64>,
    /// A number: by how much the bound grows with the normal force, from none on.
    pub coefficient: Option<f64>,
}

/// A normal force below this part of the largest force counts as zero: projected methods leave traces where a contact is open.
pub(crate) const NONE: f64 = 1e-10;

/// With this coefficient the least normal force that counts bears the largest force, so that a larger coefficient changes nothing; its
/// square is finite.
const ROUGH: f64 = 1.0 / NONE;

/// A coefficient of friction, at most [`ROUGH`]; one that is not finite is returned unchanged.
fn growth(coefficient: f64) -> f64 {
    match coefficient.is_finite() {
        true => coefficient.min(ROUGH),
        false => coefficient,
    }
}

/// The straight line given + growth · λₙ that touches a bound at a normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    /// Its value at λₙ = 0: a force.
    pub given: f64,
    /// Its slope, a number ≥ 0.
    pub growth: f64,
    /// By how much the slope of the bound changes with the normal force, one over a force; negative, or zero for a straight bound.
    pub bend: f64,
}

impl Touch {
    /// A bound that is this line itself.
    fn straight(given: f64, growth: f64) -> Self {
        let bend = 0.0;
        Self {
            given,
            growth,
            bend,
        }
    }

    /// Its value at the normal force where it touches the bound, a force.
    fn bound(&self, normal: f64) -> f64 {
        self.given + self.growth * normal
    }

    /// What a bend adds to the slope of the condition of the nearest point, for a shear of this length: −bend · (length − bound) ≥ 0.
    fn bending(&self, normal: f64, length: f64) -> f64 {
        match self.bend < 0.0 {
            true => -self.bend * (length - self.bound(normal)).max(0.0),
            false => 0.0,
        }
    }
}

/// Most steps of Newton's method on a bound that bends; five are usual.
const STEPS: usize = 60;

/// Where a force, or a growth, is known to this part of it, they end.
const STILL: f64 = 1e-15;

/// A bound that grows by this part of how much its growth changes is as good as one that has stopped.
const FLAT: f64 = 1e-9;

impl Friction {
    /// The block of a node with this law.
    pub fn block(self, tangents: usize) -> Block {
        let law = self;
        Block::Frictional { tangents, law }
    }

    /// The line that touches the bound of a closed node at a normal force ≥ 0, which may be infinite: its growth is the least one then.
    ///
    /// A coefficient from [`ROUGH`] on never lets the node slide.
    pub(crate) fn touch(
        &self,
        #[cfg_attr(not(test), expect(unused_variables))] normal: f64,
    ) -> Touch {
        match *self {
            Self::Tresca { bound } => Touch::straight(bound, 0.0),
            Self::Coulomb { coefficient } => Touch::straight(0.0, growth(coefficient)),
            Self::Cohesive {
                cohesion,
                coefficient,
            } => Touch::straight(cohesion, growth(coefficient)),
            #[cfg(test)]
            Self::Saturating { limit, coefficient } => {
                let coefficient = growth(coefficient);
                let exponent = -coefficient * normal / limit;
                let slope = coefficient * exponent.exp();
                Touch {
                    given: -limit * exponent.exp_m1() - slope * normal,
                    growth: slope,
                    bend: -slope * coefficient / limit,
                }
            }
        }
    }

    /// What files and other languages call it, and its values.
    fn told(&self) -> Told {
        let told = |name, kind, bound, coefficient: Option<f64>| Told {
            name,
            kind,
            bound,
            coefficient: coefficient.map(growth),
        };
        match *self {
            Self::Tresca { bound } => told("tresca", 2, Some(bound), None),
            Self::Coulomb { coefficient } => told("coulomb", 3, None, Some(coefficient)),
            Self::Cohesive {
                cohesion,
                coefficient,
            } => told("cohesive", 3, Some(cohesion), Some(coefficient)),
            #[cfg(test)]
            Self::Saturating { limit, coefficient } => {
                told("saturating", 3, Some(limit), Some(coefficient))
            }
        }
    }

    /// The bound follows from the normal force, and an open node bears no shear.
    pub(crate) fn follows(&self) -> bool {
        !matches!(self, Self::Tresca { .. })
    }

    /// The law of several nodes taken as one, which all have this kind of law: forces add up, coefficients are averaged.
    pub(crate) fn together(self, all: &[Self]) -> Self {
        let sum = |value: fn(Told) -> Option<f64>| -> f64 {
            let values = all.iter().map(|law| value(law.told()).unwrap_or(0.0));
            values.sum()
        };
        let bound = || sum(|told| told.bound);
        let coefficient = || sum(|told| told.coefficient) / all.len() as f64;
        match self {
            Self::Tresca { .. } => Self::Tresca { bound: bound() },
            Self::Coulomb { .. } => Self::Coulomb {
                coefficient: coefficient(),
            },
            Self::Cohesive { .. } => Self::Cohesive {
                cohesion: bound(),
                coefficient: coefficient(),
            },
            #[cfg(test)]
            Self::Saturating { .. } => Self::Saturating {
                limit: bound(),
                coefficient: coefficient(),
            },
        }
    }

    /// Whether a node bears shear at all, by whether it is closed.
    pub(crate) fn bears(&self, closed: bool) -> bool {
        closed || !self.follows()
    }

    /// The bound jumps from zero where the node closes.
    pub(crate) fn jumps(&self) -> bool {
        self.follows() && self.touch(0.0).given > 0.0
    }

    /// The bound of a closed node is a straight line, which begins at zero where it follows from the normal force.
    pub(crate) fn is_straight(&self) -> bool {
        !self.jumps() && self.touch(0.0).bend == 0.0
    }

    /// No node bears shear, whatever its normal force is.
    pub(crate) fn is_smooth(&self) -> bool {
        let touch = self.touch(0.0);
        touch.given <= 0.0 && touch.growth <= 0.0
    }

    /// Largest tangential force beside the normal force `normal`.
    pub fn bound(&self, normal: f64) -> f64 {
        match self.bears(normal > 0.0) {
            true => self.closed_bound(normal.max(0.0)),
            false => 0.0,
        }
    }

    /// The bound beside a normal force ≥ 0, at zero that of a node that has just closed.
    fn closed_bound(&self, normal: f64) -> f64 {
        self.touch(normal).bound(normal)
    }

    /// Nearest point of {λₙ ≥ 0, ‖λₜ‖ ≤ bound(λₙ)}, with the bound of a closed node. Shapes: (1 + tangents,).
    fn project(&self, from: &[f64], to: &mut [f64]) {
        let (n, length) = (from[0], norm(&from[1..]));
        if n >= 0.0 && length <= self.closed_bound(n) {
            to.copy_from_slice(from);
            return;
        }
        to[0] = self.beside(n, length);
        let bound = self.closed_bound(to[0]);
        let factor = if length > bound { bound / length } else { 1.0 };
        for (to, from) in to[1..].iter_mut().zip(&from[1..]) {
            // where the bound is zero, so that zero has no sign
            *to = if bound > 0.0 { factor * from } else { 0.0 };
        }
    }

    /// Normal component of the nearest point with ‖λₜ‖ = bound(λₙ), at least zero: Newton's method on
    /// λₙ = n + growth · (length − bound), which one step solves for a straight bound.
    fn beside(&self, n: f64, length: f64) -> f64 {
        let mut normal = n.max(0.0);
        for _ in 0..STEPS {
            let touch = self.touch(normal);
            let Touch { given, growth, .. } = touch;
            let bending = touch.bending(normal, length);
            let next = n + growth * (length - given) + bending * normal;
            let next = (next / (1.0 + growth * growth + bending)).max(0.0);
            let still = (next - normal).abs() <= STILL * next;
            normal = next;
            if touch.bend == 0.0 || still {
                break;
            }
        }
        normal
    }

    /// The normal force at which the bound grows by a number, by Newton's method: zero where it grows less from the start, and
    /// one where it grows by hardly more than far away if it grows more everywhere.
    fn where_growth_is(&self, growth: f64) -> f64 {
        let [first, last] = [0.0, f64::INFINITY].map(|normal| self.touch(normal).growth);
        let growth = growth.max(last + FLAT * (first - last));
        let mut normal = 0.0;
        for _ in 0..STEPS {
            let touch = self.touch(normal);
            if touch.growth * (1.0 - STILL) <= growth {
                break;
            }
            normal += (growth - touch.growth) / touch.bend;
        }
        normal
    }

    /// Derivative of the projection at y in direction v. Shapes: all (1 + tangents,).
    fn project_derivative(&self, y: &[f64], v: &[f64], out: &mut [f64]) {
        let (n, length) = (y[0], norm(&y[1..]));
        if n > 0.0 && length <= self.closed_bound(n) {
            out.copy_from_slice(v);
            return;
        }
        let normal = self.beside(n, length);
        let touch = self.touch(normal);
        let growth = touch.growth;
        let change = match normal > 0.0 {
            true => {
                (v[0] + growth * (dot(&y[1..], &v[1..]) / length))
                    / (1.0 + growth * growth + touch.bending(normal, length))
            }
            false => 0.0,
        };
        out[0] = change;
        let bound = touch.bound(normal);
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

/// The unit vector s for which Σ sⱼ shearsⱼ lies farthest along `towards`, zero where none does. Shapes: all (k,).
pub(super) fn farthest(shears: &[SparseVector], towards: &[f64]) -> Vec<f64> {
    let mut along: Vec<f64> = shears.iter().map(|shear| shear.dot(towards)).collect();
    let length = norm(&along);
    if length > 0.0 {
        along.iter_mut().for_each(|along| *along /= length);
    }
    along
}

/// Images of the forces of a block: sums of `rays` with weights ≥ 0, of the edges of a round cone with weights ≥ 0, and of
/// one point of a round body. For a law whose bound follows, this is the convex hull of the admissible forces.
#[derive(Default)]
pub(super) struct Generators {
    pub rays: Vec<SparseVector>,
    /// Axis and radii: its edges are axis + Σ sⱼ radiiⱼ, ‖s‖ = 1. Those along the radii are among the rays.
    pub cone: Option<(SparseVector, Vec<SparseVector>)>,
    pub round: Option<Round>,
}

/// A disc, or what the bound of a law that bends encloses.
#[derive(Debug, PartialEq)]
pub(super) struct Round {
    /// Its points are Σ sⱼ radiiⱼ, ‖s‖ ≤ 1.
    pub radii: Vec<SparseVector>,
    /// Axis and law: its points are λₙ axis + bound(λₙ) Σ sⱼ radiiⱼ.
    pub bends: Option<(SparseVector, Friction)>,
}

impl Round {
    /// Adds its point that lies farthest along `towards`. Shapes: all (k,).
    pub fn add_farthest(&self, towards: &[f64], to: &mut [f64]) {
        let turn = farthest(&self.radii, towards);
        let mut size = 1.0;
        if let Some((axis, law)) = &self.bends {
            let parts = turn.iter().zip(&self.radii);
            let along: f64 = parts.map(|(s, radius)| s * radius.dot(towards)).sum();
            let normal = law.where_growth_is(-axis.dot(towards) / along);
            axis.add_to(normal, to);
            size = law.closed_bound(normal);
        }
        for (s, radius) in turn.into_iter().zip(&self.radii) {
            radius.add_to(s * size, to);
        }
    }
}

impl Block {
    /// Number of components of λ in the block.
    pub fn size(&self) -> usize {
        match *self {
            Self::Free { size } => size,
            Self::Unilateral | Self::Interval { .. } => 1,
            Self::Frictional { tangents, .. } => 1 + tangents,
        }
    }

    /// Any force is admissible.
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free { .. })
    }

    /// Its first component may not be negative.
    pub fn is_normal(&self) -> bool {
        matches!(self, Self::Unilateral | Self::Frictional { .. })
    }

    /// The components in `range` whose length its law bounds.
    pub fn shear(&self, range: &Range<usize>) -> Range<usize> {
        match self {
            Self::Free { .. } | Self::Unilateral => range.end..range.end,
            Self::Frictional { .. } => range.start + 1..range.end,
            Self::Interval { .. } => range.clone(),
        }
    }

    /// Kinds of blocks in files, in words; `coulomb` may have cohesion.
    pub const LAWS: [&'static str; 5] = ["unilateral", "free", "tresca", "coulomb", "interval"];

    /// Its word in [`Self::LAWS`].
    pub fn name(&self) -> &'static str {
        Self::LAWS[self.told().kind]
    }

    /// What files and other languages call it, and its values.
    pub fn told(&self) -> Told {
        let told = |name, kind, bound| Told {
            name,
            kind,
            bound,
            coefficient: None,
        };
        match self {
            Self::Unilateral => told("unilateral", 0, None),
            Self::Free { .. } => told("free", 1, None),
            Self::Frictional { law, .. } => law.told(),
            Self::Interval { bound } => told("interval", 4, Some(*bound)),
        }
    }

    /// Its law of friction, if it bounds the length of some components.
    pub fn friction(&self) -> Option<Friction> {
        match *self {
            Self::Frictional { law, .. } => Some(law),
            Self::Interval { bound } => Some(Friction::Tresca { bound }),
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
            Self::Interval { bound } => Self::Interval {
                bound: law(Friction::Tresca { bound }).closed_bound(0.0),
            },
            other => other,
        }
    }

    /// Blocks that replace this one and cannot slip: they bear any shear if this one bears some.
    pub(super) fn sticking(self) -> Vec<Self> {
        match self {
            Self::Frictional { tangents, law } if law.is_smooth() => {
                vec![Friction::Tresca { bound: 0.0 }.block(tangents)]
            }
            Self::Frictional { tangents, .. } => {
                vec![Self::Unilateral, Self::Free { size: tangents }]
            }
            Self::Interval { bound } if bound > 0.0 => vec![Self::Free { size: 1 }],
            other => vec![other],
        }
    }

    /// Nearest force that the block can bear. Shapes: (size,).
    pub(super) fn project(&self, from: &[f64], to: &mut [f64]) {
        match self {
            Self::Free { .. } => to.copy_from_slice(from),
            Self::Unilateral => to[0] = from[0].max(0.0),
            Self::Frictional { law, .. } => law.project(from, to),
            Self::Interval { bound } => to[0] = from[0].max(-bound).min(*bound),
        }
    }

    /// Derivative of the projection at y in direction v. Shapes: (size,).
    pub(super) fn project_derivative(&self, y: &[f64], v: &[f64], out: &mut [f64]) {
        match self {
            Self::Free { .. } => out.copy_from_slice(v),
            Self::Unilateral => out[0] = if y[0] > 0.0 { v[0] } else { 0.0 },
            Self::Frictional { law, .. } => law.project_derivative(y, v, out),
            Self::Interval { bound } => out[0] = if y[0].abs() <= *bound { v[0] } else { 0.0 },
        }
    }

    /// Generators of the images of its forces, from the images of its components.
    pub(super) fn generators(&self, mut images: Vec<SparseVector>) -> Generators {
        let scaled = |factor: f64, images: &[SparseVector]| -> Vec<SparseVector> {
            images.iter().map(|image| image.scaled(factor)).collect()
        };
        let mut all = Generators::default();
        let Some(law) = self.friction() else {
            if self.is_free() {
                let opposite = scaled(-1.0, &images);
                let pairs = opposite.into_iter().zip(images);
                images = pairs.flat_map(|(a, b)| [a, b]).collect();
            }
            all.rays = images;
            return all;
        };
        let Touch { given, bend, .. } = law.touch(0.0);
        let bounded = self.shear(&(0..images.len()));
        if bend < 0.0 {
            let radii = images[bounded].to_vec();
            let bends = Some((images[0].clone(), law));
            all.round = Some(Round { radii, bends });
        } else if given > 0.0 {
            let radii = scaled(given, &images[bounded]);
            let bends = None;
            all.round = Some(Round { radii, bends });
        }
        if !self.is_normal() {
            return all;
        }
        let growth = law.touch(f64::INFINITY).growth;
        let radii = scaled(growth, &images[1..]);
        let axis = images.swap_remove(0);
        if growth <= 0.0 {
            all.rays.push(axis);
            return all;
        }
        for radius in &radii {
            let edges = [-1.0, 1.0].map(|sign| axis.plus([(sign, radius)]));
            all.rays.extend(edges);
        }
        all.cone = (radii.len() > 1).then_some((axis, radii));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::grid::noise;

    const TRESCA: Friction = Friction::Tresca { bound: 0.5 };
    const COULOMB: Friction = Friction::Coulomb { coefficient: 0.4 };
    const COHESIVE: Friction = Friction::Cohesive {
        cohesion: 0.3,
        coefficient: 0.5,
    };
    const SATURATING: Friction = Friction::Saturating {
        limit: 0.6,
        coefficient: 0.8,
    };
    const LAWS: [Friction; 3] = [TRESCA, COULOMB, COHESIVE];

    fn projected(block: Block, from: &[f64]) -> Vec<f64> {
        let mut to = vec![9.0; from.len()];
        block.project(from, &mut to);
        to
    }

    #[test]
    fn bounds_of_open_and_closed_nodes_are_those_of_the_table() {
        assert_eq!([-1.0, 0.0, 2.0].map(|n| TRESCA.bound(n)), [0.5, 0.5, 0.5]);
        assert_eq!([-1.0, 0.0, 2.0].map(|n| COULOMB.bound(n)), [0.0, 0.0, 0.8]);
        assert_eq!([-1.0, 0.0, 2.0].map(|n| COHESIVE.bound(n)), [0.0, 0.0, 1.3]);
        assert_eq!(LAWS.map(|law| law.follows()), [false, true, true]);
        assert_eq!(LAWS.map(|law| law.bears(false)), [true, false, false]);
        assert_eq!(LAWS.map(|law| law.bears(true)), [true; 3]);
        assert_eq!(LAWS.map(|law| law.jumps()), [false, false, true]);
        assert_eq!(LAWS.map(|law| law.is_smooth()), [false; 3]);
        let cohesive = |cohesion, coefficient| Friction::Cohesive {
            cohesion,
            coefficient,
        };
        assert!(!cohesive(0.0, 0.5).jumps() && !cohesive(0.0, 0.5).is_smooth());
        assert!(cohesive(0.5, 0.0).jumps() && !cohesive(0.5, 0.0).is_smooth());
        assert!(!cohesive(0.0, 0.0).jumps() && cohesive(0.0, 0.0).is_smooth());
        // however little it bears
        assert!(!cohesive(1e-9, 0.0).is_smooth() && !cohesive(0.0, 1e-9).is_smooth());
        assert!(cohesive(1e-9, 0.0).jumps());
    }

    #[test]
    fn nodes_taken_together_add_forces_and_average_coefficients() {
        let tresca = TRESCA.together(&[TRESCA, Friction::Tresca { bound: 1.0 }]);
        assert_eq!(tresca, Friction::Tresca { bound: 1.5 });
        let coulomb = COULOMB.together(&[COULOMB, Friction::Coulomb { coefficient: 0.8 }]);
        let Friction::Coulomb { coefficient } = coulomb else {
            panic!("the kind of the law stays");
        };
        assert!((coefficient - 0.6).abs() < 1e-15);
        let other = Friction::Cohesive {
            cohesion: 0.5,
            coefficient: 1.0,
        };
        let expected = Friction::Cohesive {
            cohesion: 0.8,
            coefficient: 0.75,
        };
        assert_eq!(COHESIVE.together(&[COHESIVE, other]), expected);
    }

    #[test]
    fn blocks_tell_their_size_their_law_and_their_bound() {
        let free = Block::Free { size: 3 };
        let blocks = [free, Block::Unilateral, COULOMB.block(1), TRESCA.block(2)];
        assert_eq!(blocks.map(|block| block.size()), [3, 1, 2, 3]);
        let is_free = blocks.map(|block| block.is_free());
        assert_eq!(is_free, [true, false, false, false]);
        let laws = blocks.map(|block| block.friction());
        assert_eq!(laws, [None, None, Some(COULOMB), Some(TRESCA)]);
        let bounds = blocks.map(|block| block.bound(10.0));
        assert_eq!(bounds, [None, None, Some(4.0), Some(0.5)]);
        assert_eq!(free.with_friction(|_| TRESCA), free);
        assert_eq!(TRESCA.block(2).with_friction(|_| COULOMB), COULOMB.block(2));
    }

    #[test]
    fn a_block_that_cannot_slip_bears_any_shear_unless_it_bears_none() {
        let free = Block::Free { size: 2 };
        for law in LAWS {
            assert_eq!(law.block(2).sticking(), [Block::Unilateral, free]);
        }
        for law in [
            Friction::Coulomb { coefficient: 0.0 },
            Friction::Tresca { bound: 0.0 },
        ] {
            let none = Friction::Tresca { bound: 0.0 }.block(2);
            assert_eq!(law.block(2).sticking(), [none]);
        }
        assert_eq!(free.sticking(), [free]);
        assert_eq!(Block::Unilateral.sticking(), [Block::Unilateral]);
    }

    #[test]
    fn projections_of_one_node_are_those_of_a_drawing() {
        let near = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len());
            let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-15, "{found:?} {expected:?}");
        };
        // a half strip: shears are cut, tensions vanish, and the shear stays
        near(projected(TRESCA.block(1), &[2.0, -0.7]), &[2.0, -0.5]);
        near(projected(TRESCA.block(1), &[-2.0, 0.3]), &[0.0, 0.3]);
        near(
            projected(TRESCA.block(2), &[-2.0, 3.0, -4.0]),
            &[0.0, 0.3, -0.4],
        );
        // a cone of slope 1: (0, 2) goes to its edge at (1, 1), points of the polar cone to its apex
        let steep = Friction::Coulomb { coefficient: 1.0 };
        near(projected(steep.block(1), &[0.0, 2.0]), &[1.0, 1.0]);
        near(projected(steep.block(1), &[-3.0, -1.0]), &[0.0, 0.0]);
        near(projected(steep.block(1), &[3.0, -1.0]), &[3.0, -1.0]);
        near(projected(steep.block(1), &[0.5, 0.5]), &[0.5, 0.5]);
        // the zero of a node that bears nothing has no sign
        let none = projected(steep.block(1), &[-3.0, -1.0]);
        assert!(none.iter().all(|force| force.is_sign_positive()));
        // the hull of a cohesive law of slope 1 has the edge λₜ = 1 + λₙ
        let hull = Friction::Cohesive {
            cohesion: 1.0,
            coefficient: 1.0,
        };
        near(projected(hull.block(1), &[0.0, 3.0]), &[1.0, 2.0]);
        near(projected(hull.block(1), &[-3.0, 0.5]), &[0.0, 0.5]);
        near(projected(hull.block(1), &[-3.0, 2.0]), &[0.0, 1.0]);
        near(projected(Block::Unilateral, &[-1.0]), &[0.0]);
        near(projected(Block::Unilateral, &[1.0]), &[1.0]);
        let free = Block::Free { size: 2 };
        near(projected(free, &[-1.0, 2.0]), &[-1.0, 2.0]);
        let interval = Block::Interval { bound: 0.5 };
        for (from, to) in [(-2.0, -0.5), (-0.5, -0.5), (0.2, 0.2), (0.6, 0.5)] {
            near(projected(interval, &[from]), &[to]);
        }
        near(projected(Block::Interval { bound: 0.0 }, &[-3.0]), &[0.0]);
    }

    #[test]
    fn an_interval_is_a_bounded_shear_without_a_normal_force() {
        let interval = Block::Interval { bound: 0.5 };
        assert_eq!(interval.size(), 1);
        assert!(!interval.is_free() && !interval.is_normal());
        assert_eq!(interval.friction(), Some(TRESCA));
        assert_eq!(
            (interval.name(), interval.told().bound),
            ("interval", Some(0.5))
        );
        let half = interval.with_friction(|_| Friction::Tresca { bound: 0.25 });
        assert_eq!(half, Block::Interval { bound: 0.25 });
        assert_eq!(interval.sticking(), [Block::Free { size: 1 }]);
        let none = Block::Interval { bound: 0.0 };
        assert_eq!(none.sticking(), [none]);
        let sheared = [
            (Block::Free { size: 3 }, 5..5),
            (Block::Unilateral, 5..5),
            (COULOMB.block(2), 3..5),
            (interval, 2..5),
        ];
        for (block, expected) in sheared {
            assert_eq!(block.shear(&(2..5)), expected, "{block:?}");
        }
        // both ends of it and nothing else
        let found = interval.generators(vec![SparseVector::from_dense(&[2.0, -4.0])]);
        assert!(found.rays.is_empty() && found.cone.is_none());
        let ends = found.round.unwrap();
        assert_eq!(ends.radii, [SparseVector::from_dense(&[1.0, -2.0])]);
    }

    #[test]
    fn derivatives_of_one_node_agree_with_differences() {
        // h = 1e-6: the quotient is exact to h where no kink lies between, and rounds to 1e-10
        let h = 1e-6;
        let mut compared = 0;
        for tangents in [1, 2] {
            let blocks = LAWS.map(|law| law.block(tangents));
            let interval = Block::Interval { bound: 0.5 };
            let bends = SATURATING.block(tangents);
            for block in blocks
                .into_iter()
                .chain([Block::Unilateral, interval, bends])
            {
                let size = block.size();
                for pair in noise(400 * size).chunks_exact(2 * size) {
                    let (y, v) = pair.split_at(size);
                    let moved = |step: f64| -> Vec<f64> {
                        y.iter().zip(v).map(|(y, v)| y + step * v).collect()
                    };
                    let (after, before) = (moved(h), moved(-h));
                    let (after, before) = (projected(block, &after), projected(block, &before));
                    let here = projected(block, y);
                    let mut derivative = vec![9.0; size];
                    block.project_derivative(y, v, &mut derivative);
                    for i in 0..size {
                        let sides = [after[i] - here[i], here[i] - before[i]];
                        // a kink: the two one-sided quotients differ
                        if (sides[0] - sides[1]).abs() > 1e-4 * h {
                            continue;
                        }
                        compared += 1;
                        let quotient = (after[i] - before[i]) / (2.0 * h);
                        assert!(
                            (quotient - derivative[i]).abs() < 1e-5,
                            "{block:?} {y:?} {v:?}: {quotient} {}",
                            derivative[i]
                        );
                    }
                }
            }
        }
        // 200 points for each of 2 + 3 components of three laws, and two twice
        assert!(compared > 3700, "{compared}");
    }

    #[test]
    fn lines_touch_a_bound_that_bends() {
        let bound = |n: f64| 0.6 * (1.0 - (-0.8 * n / 0.6).exp());
        for n in [0.0, 0.3, 1.0, 5.0] {
            let touch = SATURATING.touch(n);
            let h = 1e-4;
            let [before, after] = [-h, h].map(|h| bound(n + h));
            assert!((touch.bound(n) - bound(n)).abs() < 1e-15);
            assert!((SATURATING.bound(n) - bound(n)).abs() < 1e-15);
            assert!((touch.growth - (after - before) / (2.0 * h)).abs() < 1e-7);
            let bend = (after - 2.0 * bound(n) + before) / (h * h);
            assert!((touch.bend - bend).abs() < 1e-5, "{bend}");
        }
        assert_eq!(SATURATING.touch(f64::INFINITY).growth, 0.0);
        for growth in [0.7, 0.1, 1e-6] {
            let normal = SATURATING.where_growth_is(growth);
            assert!((SATURATING.touch(normal).growth - growth).abs() < 1e-14 * growth.max(1e-2));
        }
        assert_eq!(SATURATING.where_growth_is(0.9), 0.0);
        // it grows everywhere: a force from which on it hardly does
        let far = [0.0, -1.0].map(|g| SATURATING.where_growth_is(g));
        assert!(far.iter().all(|&n| n > 10.0 && n < 20.0), "{far:?}");
    }

    #[test]
    fn projection_on_a_bound_that_bends_is_the_nearest_admissible_force() {
        let block = SATURATING.block(2);
        let points = noise(3 * 100);
        for y in points.chunks_exact(3) {
            let y: Vec<f64> = y.iter().map(|y| 4.0 * y).collect();
            let nearest = projected(block, &y);
            assert!(norm(&nearest[1..]) <= SATURATING.bound(nearest[0]) + 1e-15);
            let again = projected(block, &nearest);
            assert!((0..3).all(|i| (nearest[i] - again[i]).abs() < 1e-14));
            for z in points.chunks_exact(3) {
                let other = projected(block, z);
                let product: f64 = (0..3)
                    .map(|i| (y[i] - nearest[i]) * (other[i] - nearest[i]))
                    .sum();
                assert!(product < 1e-13, "{product}");
            }
        }
    }

    #[test]
    fn round_body_of_a_bound_that_bends_ends_where_the_bound_is_as_steep_as_the_direction() {
        let sparse = |v: [f64; 3]| SparseVector::from_dense(&v);
        let images = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(sparse);
        let found = SATURATING.block(2).generators(images.to_vec());
        assert_eq!(found.rays, images[..1]);
        assert!(found.cone.is_none());
        let round = found.round.unwrap();
        for towards in [[-0.5, 1.0, 0.0], [-0.01, 0.6, 0.8], [-1e-6, 0.0, 1.0]] {
            let mut corner = vec![0.0; 3];
            round.add_farthest(&towards, &mut corner);
            let reach = dot(&corner, &towards);
            let best = (0..200_000).map(|i| {
                let n = 1e-4 * i as f64;
                towards[0] * n + 2.0 * SATURATING.bound(n) * norm(&towards[1..])
            });
            let best = best.fold(0.0, f64::max);
            assert!(
                reach >= best - 1e-15 && reach < best + 1e-7,
                "{reach} {best}"
            );
        }
    }

    #[test]
    fn farthest_point_of_a_disc_is_found_among_all_of_them() {
        let shears = [[1.0, 0.2, 0.0], [-0.3, 2.0, 0.5]];
        let sparse = shears.map(|shear| SparseVector::from_dense(&shear));
        for towards in noise(30).chunks_exact(3) {
            let found = farthest(&sparse, towards);
            assert!((norm(&found) - 1.0).abs() < 1e-15);
            let parts = found.iter().zip(&shears);
            let reach: f64 = parts.map(|(s, shear)| s * dot(shear, towards)).sum();
            let best = (0..3600).map(|i| {
                let (sin, cos) = (i as f64 * std::f64::consts::TAU / 3600.0).sin_cos();
                cos * dot(&shears[0], towards) + sin * dot(&shears[1], towards)
            });
            let best = best.fold(0.0, f64::max);
            // half a step of 0.1° off the best one loses 4e-7 of it
            assert!(
                reach >= best && reach < best * (1.0 + 1e-6),
                "{reach} {best}"
            );
        }
        // across the disc every point is as far as any other
        assert_eq!(farthest(&sparse[..1], &[0.0, 0.0, 1.0]), [0.0]);
    }

    #[test]
    fn generators_are_the_edges_of_what_a_block_bears() {
        let sparse = |v: &[f64; 3]| SparseVector::from_dense(v);
        let images = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]].map(|v| sparse(&v));
        let all =
            |vectors: &[[f64; 3]]| -> Vec<SparseVector> { vectors.iter().map(sparse).collect() };
        let of = |block: Block| block.generators(images[..block.size()].to_vec());
        let disc = |radii| Some(Round { radii, bends: None });
        let free = of(Block::Free { size: 2 });
        let pairs = [
            [-1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, -2.0, 0.0],
            [0.0, 2.0, 0.0],
        ];
        assert_eq!(free.rays, all(&pairs));
        assert!(free.cone.is_none() && free.round.is_none());
        let unilateral = of(Block::Unilateral);
        assert_eq!(unilateral.rays, images[..1]);
        assert!(unilateral.cone.is_none() && unilateral.round.is_none());

        let tresca = of(TRESCA.block(2));
        assert_eq!(tresca.rays, images[..1]);
        let half = all(&[[0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]);
        assert_eq!((tresca.cone, tresca.round), (None, disc(half)));
        let smooth = of(Friction::Tresca { bound: 0.0 }.block(2));
        assert_eq!(smooth.rays, images[..1]);
        assert_eq!((smooth.cone, smooth.round), (None, None));

        let plane = of(COULOMB.block(1));
        assert_eq!(plane.rays, all(&[[1.0, -0.8, 0.0], [1.0, 0.8, 0.0]]));
        assert_eq!((plane.cone, plane.round), (None, None));
        let space = of(COULOMB.block(2));
        let edges = [
            [1.0, -0.8, 0.0],
            [1.0, 0.8, 0.0],
            [1.0, 0.0, -1.6],
            [1.0, 0.0, 1.6],
        ];
        assert_eq!(space.rays, all(&edges));
        let radii = all(&[[0.0, 0.8, 0.0], [0.0, 0.0, 1.6]]);
        assert_eq!(space.cone, Some((images[0].clone(), radii)));
        assert_eq!(space.round, None);

        let cohesive = of(COHESIVE.block(2));
        let radii = all(&[[0.0, 0.6, 0.0], [0.0, 0.0, 1.2]]);
        assert_eq!(cohesive.round, disc(radii));
        assert_eq!((cohesive.rays.len(), cohesive.cone.is_some()), (4, true));
    }
}
