//! Λ, the forces that the contact nodes can bear: a product of small blocks, each with its projection.
//!
//! Sign: λₙ ≥ 0 is compression. Projections are Euclidean in the components of λ (forces).

use std::ops::Range;

use crate::dual::Block;

/// What a single component of λ is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// Any force.
    Free,
    /// A normal force, ≥ 0.
    Normal,
    /// A tangential force, bounded by its block.
    Tangent,
}

impl Block {
    /// Number of components of λ in the block.
    pub fn size(&self) -> usize {
        match *self {
            Self::Free { size } => size,
            Self::Unilateral => 1,
            Self::Tresca { tangents, .. } | Self::Coulomb { tangents, .. } => 1 + tangents,
        }
    }
}

/// Λ: the blocks in order, and where each begins in λ.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AdmissibleSet {
    blocks: Vec<Block>,
    offsets: Vec<usize>,
}

impl AdmissibleSet {
    /// The product of `blocks`, in this order in λ.
    pub fn new(blocks: Vec<Block>) -> Self {
        let mut offsets = Vec::with_capacity(blocks.len() + 1);
        let mut end = 0;
        offsets.push(0);
        for block in &blocks {
            end += block.size();
            offsets.push(end);
        }
        Self { blocks, offsets }
    }

    /// Length m of λ.
    pub fn len(&self) -> usize {
        self.offsets.last().copied().unwrap_or(0)
    }

    /// There is no contact force.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The blocks in order.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Components of λ that belong to block `index`.
    pub fn range(&self, index: usize) -> Range<usize> {
        self.offsets[index]..self.offsets[index + 1]
    }

    /// Each block with its components of λ.
    pub fn iter(&self) -> impl Iterator<Item = (&Block, Range<usize>)> {
        self.blocks
            .iter()
            .zip(self.offsets.windows(2).map(|ends| ends[0]..ends[1]))
    }

    /// What each component of λ is, (m,).
    pub fn components(&self) -> Vec<Component> {
        let mut components = Vec::with_capacity(self.len());
        for block in &self.blocks {
            match *block {
                Block::Free { size } => components.extend(vec![Component::Free; size]),
                Block::Unilateral => components.push(Component::Normal),
                Block::Tresca { tangents, .. } | Block::Coulomb { tangents, .. } => {
                    components.push(Component::Normal);
                    components.extend(vec![Component::Tangent; tangents]);
                }
            }
        }
        components
    }

    /// λ = P_Λ(y), the nearest admissible force. Shapes: both (m,).
    pub fn project(&self, y: &[f64], lambda: &mut [f64]) {
        for (block, range) in self.iter() {
            let (from, to) = (&y[range.clone()], &mut lambda[range]);
            match *block {
                Block::Free { .. } => to.copy_from_slice(from),
                Block::Unilateral => to[0] = from[0].max(0.0),
                Block::Tresca { bound, .. } => {
                    to[0] = from[0].max(0.0);
                    project_ball(&from[1..], bound, &mut to[1..]);
                }
                Block::Coulomb { coefficient, .. } => project_cone(from, coefficient, to),
            }
        }
    }

    /// Derivative of the projection at y in direction v: symmetric, between 0 and 1. Shapes: all (m,).
    pub fn project_derivative(&self, y: &[f64], v: &[f64], out: &mut [f64]) {
        for (block, range) in self.iter() {
            let (y, v, out) = (&y[range.clone()], &v[range.clone()], &mut out[range]);
            match *block {
                Block::Free { .. } => out.copy_from_slice(v),
                Block::Unilateral => out[0] = if y[0] > 0.0 { v[0] } else { 0.0 },
                Block::Tresca { bound, .. } => {
                    out[0] = if y[0] > 0.0 { v[0] } else { 0.0 };
                    let length = norm(&y[1..]);
                    if length <= bound {
                        out[1..].copy_from_slice(&v[1..]);
                    } else {
                        turn(&y[1..], length, bound / length, 0.0, &v[1..], &mut out[1..]);
                    }
                }
                Block::Coulomb { coefficient, .. } => cone_derivative(y, coefficient, v, out),
            }
        }
    }

    /// Largest tension of a normal component, a force ≥ 0.
    pub fn tension(&self, lambda: &[f64]) -> f64 {
        self.iter()
            .filter(|(block, _)| !matches!(block, Block::Free { .. }))
            .map(|(_, range)| -lambda[range.start])
            .fold(0.0, f64::max)
    }

    /// Distance of λ from Λ in its worst component, a force ≥ 0.
    pub fn violation(&self, lambda: &[f64]) -> f64 {
        let mut nearest = lambda.to_vec();
        self.project(lambda, &mut nearest);
        lambda
            .iter()
            .zip(&nearest)
            .map(|(own, near)| (own - near).abs())
            .fold(0.0, f64::max)
    }

    /// Largest violation of the friction law, a force: λₜ against the projection of λₜ − gapₜ/`compliance`
    /// onto the disc of its bound (for Coulomb the bound is coefficient · λₙ).
    ///
    /// `compliance` (length over force) makes gap and force comparable.
    pub fn slip_violation(&self, lambda: &[f64], gap: &[f64], compliance: f64) -> f64 {
        let mut worst: f64 = 0.0;
        for (block, range) in self.iter() {
            let bound = match *block {
                Block::Free { .. } | Block::Unilateral => continue,
                Block::Tresca { bound, .. } => bound,
                Block::Coulomb { coefficient, .. } => coefficient * lambda[range.start].max(0.0),
            };
            let tangents = range.start + 1..range.end;
            let mut trial: Vec<f64> = tangents
                .clone()
                .map(|i| lambda[i] - gap[i] / compliance)
                .collect();
            let length = norm(&trial);
            if length > bound {
                trial.iter_mut().for_each(|t| *t *= bound / length);
            }
            let distance = tangents
                .zip(&trial)
                .map(|(i, t)| (lambda[i] - t).powi(2))
                .sum::<f64>()
                .sqrt();
            worst = worst.max(distance);
        }
        worst
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Nearest point of the ball ‖t‖ ≤ bound.
fn project_ball(from: &[f64], bound: f64, to: &mut [f64]) {
    let length = norm(from);
    let factor = if length > bound { bound / length } else { 1.0 };
    for (to, from) in to.iter_mut().zip(from) {
        *to = factor * from;
    }
}

/// Nearest point of the cone ‖t‖ ≤ μn.
fn project_cone(from: &[f64], mu: f64, to: &mut [f64]) {
    let (n, length) = (from[0], norm(&from[1..]));
    if length <= mu * n {
        to.copy_from_slice(from);
    } else if mu * length <= -n {
        to.fill(0.0);
    } else {
        let normal = (n + mu * length) / (1.0 + mu * mu);
        to[0] = normal;
        for (to, from) in to[1..].iter_mut().zip(&from[1..]) {
            *to = mu * normal / length * from;
        }
    }
}

/// Derivative of [`project_cone`].
fn cone_derivative(y: &[f64], mu: f64, v: &[f64], out: &mut [f64]) {
    let (n, length) = (y[0], norm(&y[1..]));
    if length <= mu * n {
        out.copy_from_slice(v);
    } else if mu * length <= -n {
        out.fill(0.0);
    } else {
        let normal = (n + mu * length) / (1.0 + mu * mu);
        let along = dot(&y[1..], &v[1..]) / length;
        let change = (v[0] + mu * along) / (1.0 + mu * mu);
        out[0] = change;
        turn(
            &y[1..],
            length,
            mu * normal / length,
            mu * change,
            &v[1..],
            &mut out[1..],
        );
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

#[cfg(test)]
mod tests {
    use super::*;

    fn friction() -> AdmissibleSet {
        AdmissibleSet::new(vec![
            Block::Free { size: 2 },
            Block::Unilateral,
            Block::Tresca {
                tangents: 2,
                bound: 0.5,
            },
            Block::Coulomb {
                tangents: 2,
                coefficient: 0.4,
            },
        ])
    }

    /// Reproducible points that visit every branch of the projections.
    fn points(count: usize) -> Vec<Vec<f64>> {
        (0..count)
            .map(|k| {
                (0..9)
                    .map(|i| 2.0 * ((k * 31 + i * 17) as f64).sin())
                    .collect()
            })
            .collect()
    }

    #[test]
    fn projection_is_the_nearest_admissible_force() {
        // Variational characterisation: (y − P(y))·(z − P(y)) ≤ 0 for every admissible z.
        let set = friction();
        let mut nearest = vec![0.0; 9];
        let mut other = vec![0.0; 9];
        for y in points(60) {
            set.project(&y, &mut nearest);
            assert!(set.violation(&nearest) < 1e-15);
            for z in points(60) {
                set.project(&z, &mut other);
                let product: f64 = (0..9)
                    .map(|i| (y[i] - nearest[i]) * (other[i] - nearest[i]))
                    .sum();
                assert!(product < 1e-13, "{product}");
            }
        }
    }

    #[test]
    fn derivative_agrees_with_differences() {
        let set = friction();
        let step = 1e-6;
        let (mut before, mut after, mut derivative) = (vec![0.0; 9], vec![0.0; 9], vec![0.0; 9]);
        let all = points(40);
        for (y, v) in all.iter().zip(all.iter().skip(1)) {
            let forward: Vec<f64> = (0..9).map(|i| y[i] + step * v[i]).collect();
            let backward: Vec<f64> = (0..9).map(|i| y[i] - step * v[i]).collect();
            set.project(&forward, &mut after);
            set.project(&backward, &mut before);
            set.project_derivative(y, v, &mut derivative);
            for i in 0..9 {
                let difference = (after[i] - before[i]) / (2.0 * step);
                assert!((difference - derivative[i]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn tension_counts_normal_forces_only() {
        let set = friction();
        let lambda = [-9.0, -9.0, -1.0, 2.0, -5.0, 0.0, -3.0, -8.0, 0.0];
        assert_eq!(set.tension(&lambda), 3.0);
    }

    #[test]
    fn friction_law_holds_in_stick_and_in_slip_against_the_motion() {
        let set = AdmissibleSet::new(vec![Block::Tresca {
            tangents: 1,
            bound: 1.0,
        }]);
        assert_eq!(set.slip_violation(&[1.0, 0.5], &[0.0, 0.0], 1.0), 0.0);
        // The gap is the gradient: a force at its bound has a gap of the opposite sign.
        assert_eq!(set.slip_violation(&[1.0, 1.0], &[0.0, -0.3], 1.0), 0.0);
        assert!(set.slip_violation(&[1.0, 1.0], &[0.0, 0.3], 1.0) > 0.29);
        assert!(set.slip_violation(&[1.0, 1.5], &[0.0, 0.0], 1.0) > 0.49);
    }
}
