//! Λ, the forces that the contact nodes can bear: the product of their blocks, see `law.rs`.
//!
//! Sign: λₙ ≥ 0 is compression. Projections are Euclidean in the components of λ (forces).

use std::ops::Range;

use crate::dual::law::NONE;
use crate::dual::{Block, Friction};
use crate::linalg::dense::{dot, norm};

/// The kind of a single component of λ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// Any force.
    Free,
    /// A normal force, ≥ 0.
    Normal,
    /// A tangential force, or one along a line, bounded by its block.
    Tangent,
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

    /// Some block has a friction law.
    pub fn has_friction(&self) -> bool {
        self.blocks.iter().any(|block| block.friction().is_some())
    }

    /// Some bound of friction follows from its normal force: the problem is not the minimum of a convex functional.
    pub fn bounds_follow(&self) -> bool {
        let mut laws = self.blocks.iter().filter_map(Block::friction);
        laws.any(|law| law.follows())
    }

    /// Bound of the tangential force of each block at λ, 0 without friction; one per block.
    pub fn bounds(&self, lambda: &[f64]) -> Vec<f64> {
        let none = NONE * lambda.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
        let bound = |(block, range): (&Block, Range<usize>)| {
            let normal = lambda.get(range.start).copied().unwrap_or(0.0);
            match block.friction() {
                Some(law) if law.jumps() && normal <= none => 0.0,
                Some(law) => law.bound(normal),
                None => 0.0,
            }
        };
        self.iter().map(bound).collect()
    }

    /// The set without slip: a node with friction bears any shear beside its normal force.
    ///
    /// λ keeps its length. A block that bears no shear at all stays as it is.
    pub fn sticking(&self) -> Self {
        let blocks = self.blocks.iter().flat_map(|block| block.sticking());
        Self::new(blocks.collect())
    }

    /// The set in which friction vanishes where `slips` (one per block) is true and is unbounded in the other blocks with friction.
    pub fn with_slip(&self, slips: &[bool]) -> Self {
        let blocks = self.blocks.iter().zip(slips);
        let blocks = blocks.flat_map(|(block, slips)| match slips {
            true => vec![block.with_friction(|_| Friction::Tresca { bound: 0.0 })],
            false => block.sticking().into_iter().collect(),
        });
        Self::new(blocks.collect())
    }

    /// The set in which every block with friction has the given bound `bound`.
    pub fn with_all_bounds(&self, bound: f64) -> Self {
        let given = |block: &Block| block.with_friction(|_| Friction::Tresca { bound });
        Self::new(self.blocks.iter().map(given).collect())
    }

    /// The set in which every bound that follows from a normal force is given (one per block).
    pub fn with_bounds(&self, bounds: &[f64]) -> Self {
        let given = |(block, &bound): (&Block, &f64)| {
            block.with_friction(|law| match law.follows() {
                true => Friction::Tresca { bound },
                false => law,
            })
        };
        Self::new(self.blocks.iter().zip(bounds).map(given).collect())
    }

    /// The kind of each component of λ, (m,).
    pub fn components(&self) -> Vec<Component> {
        let of_block = |block: &Block| {
            let (first, others) = match block {
                Block::Free { .. } => (Component::Free, Component::Free),
                Block::Unilateral | Block::Frictional { .. } => {
                    (Component::Normal, Component::Tangent)
                }
                Block::Interval { .. } => (Component::Tangent, Component::Tangent),
            };
            let others = std::iter::repeat(others);
            std::iter::once(first).chain(others).take(block.size())
        };
        self.blocks.iter().flat_map(of_block).collect()
    }

    /// No bound bends with the normal force or jumps where its node closes.
    pub(crate) fn is_straight(&self) -> bool {
        let mut laws = self.blocks.iter().filter_map(Block::friction);
        laws.all(|law| law.is_straight())
    }

    /// Some bound jumps where its node closes, as cohesion does.
    pub(crate) fn jumps(&self) -> bool {
        let mut laws = self.blocks.iter().filter_map(Block::friction);
        laws.any(|law| law.jumps())
    }

    /// λ = P_Λ(y), the nearest admissible force. Shapes: both (m,).
    pub fn project(&self, y: &[f64], lambda: &mut [f64]) {
        for (block, range) in self.iter() {
            block.project(&y[range.clone()], &mut lambda[range]);
        }
    }

    /// Derivative of the projection at y in direction v: symmetric, between 0 and 1. Shapes: all (m,).
    pub fn project_derivative(&self, y: &[f64], v: &[f64], out: &mut [f64]) {
        for (block, range) in self.iter() {
            block.project_derivative(&y[range.clone()], &v[range.clone()], &mut out[range]);
        }
    }

    /// Shortens tangential forces to their bounds, in place; the rest of λ stays as it is.
    pub fn bound_tangents(&self, lambda: &mut [f64]) {
        for (block, range) in self.iter() {
            if let Some(bound) = block.bound(lambda[range.start]) {
                let tangents = &mut lambda[block.shear(&range)];
                let length = norm(tangents);
                if length > bound {
                    tangents.iter_mut().for_each(|t| *t *= bound / length);
                }
            }
        }
    }

    /// Largest tension of a normal component, a force ≥ 0.
    pub fn tension(&self, lambda: &[f64]) -> f64 {
        self.iter()
            .filter(|(block, _)| block.is_normal())
            .map(|(_, range)| -lambda[range.start])
            .fold(0.0, f64::max)
    }

    /// Violations of the friction law, forces: λₜ against the projection of the trial forces onto the disc of its bound (where it
    /// follows from λₙ, at λₙ), for each block with friction and beside its first component.
    ///
    /// Shapes: λ (m,). `trial` gives λ − gap/softness of a component, the softness being a length over force.
    pub fn slip_violations(
        &self,
        lambda: &[f64],
        trial: impl Fn(usize) -> f64,
    ) -> impl Iterator<Item = (usize, f64)> {
        self.tangents(lambda).map(move |(first, tangents, bound)| {
            let square: f64 = tangents.clone().map(|i| trial(i).powi(2)).sum();
            let length = square.sqrt();
            let factor = if length > bound { bound / length } else { 1.0 };
            let off = tangents.map(|i| (lambda[i] - factor * trial(i)).powi(2));
            (first, off.sum::<f64>().sqrt())
        })
    }

    /// The largest of [`Self::slip_violations`]; NaN if there is any.
    pub fn slip_violation(&self, lambda: &[f64], trial: impl Fn(usize) -> f64) -> f64 {
        let each = self.slip_violations(lambda, trial);
        each.fold(0.0, |worst: f64, (_, distance)| {
            match distance.is_nan() || distance > worst {
                true => distance,
                false => worst,
            }
        })
    }

    /// First component, tangential components and bound of every block with friction.
    fn tangents(&self, lambda: &[f64]) -> impl Iterator<Item = (usize, Range<usize>, f64)> {
        let each = self.iter().zip(self.bounds(lambda));
        let with_friction = each.filter(|((block, _), _)| block.friction().is_some());
        with_friction.map(|((block, range), bound)| (range.start, block.shear(&range), bound))
    }

    /// Work of the tangential forces on the slip of this step, λₜ·slip = −λₜ·gapₜ, one per block (0 without friction).
    ///
    /// Shapes: λ, gap (m,). Unit: energy. At a solution it is bound · |slip| ≥ 0: what friction dissipates.
    pub fn dissipated(&self, lambda: &[f64], gap: &[f64]) -> Vec<f64> {
        self.iter()
            .map(|(block, range)| {
                let slips = block.shear(&range);
                -dot(&lambda[slips.clone()], &gap[slips])
            })
            .collect()
    }

    /// bound·|slip| of every block with friction, the potential of its forces at bounds that follow from λ, beside its first
    /// component; energies ≥ 0.
    ///
    /// A bound that follows from the normal force counts up to twice the force of the block. A shear that stays below a larger
    /// bound stays below half of it, too: the node sticks, and a law with half the bound has the same answer. A rough contact
    /// has a coefficient that stands for infinity: its bound times the rounding of a slip would be a large energy.
    ///
    /// At a solution they equal [`AdmissibleSet::dissipated`]; elsewhere in Λ they are larger. `gap` gives that of a component.
    pub fn slip_potentials(
        &self,
        lambda: &[f64],
        gap: impl Fn(usize) -> f64,
    ) -> impl Iterator<Item = (usize, f64)> {
        let blocks = self.iter().zip(self.bounds(lambda));
        blocks.filter_map(move |((block, range), bound)| {
            let law = block.friction()?;
            let most = match law.follows() {
                true => law.touch(0.0).given + 2.0 * norm(&lambda[range.clone()]),
                false => bound,
            };
            let square: f64 = block.shear(&range).map(|i| gap(i).powi(2)).sum();
            Some((range.start, bound.min(most) * square.sqrt()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn friction() -> AdmissibleSet {
        AdmissibleSet::new(vec![
            Block::Free { size: 2 },
            Block::Unilateral,
            Friction::Tresca { bound: 0.5 }.block(2),
            Friction::Coulomb { coefficient: 0.4 }.block(2),
        ])
    }

    /// The same with a cohesive node, whose convex hull is projected on.
    fn every_law() -> AdmissibleSet {
        let cohesive = Friction::Cohesive {
            cohesion: 0.3,
            coefficient: 0.5,
        };
        let mut blocks = friction().blocks;
        blocks.push(cohesive.block(2));
        AdmissibleSet::new(blocks)
    }

    /// Reproducible points that visit every branch of the projections.
    fn points(count: usize) -> Vec<Vec<f64>> {
        (0..count)
            .map(|k| {
                (0..12)
                    .map(|i| 2.0 * ((k * 31 + i * 17) as f64).sin())
                    .collect()
            })
            .collect()
    }

    #[test]
    fn projection_is_the_nearest_admissible_force() {
        // Variational characterisation: (y − P(y))·(z − P(y)) ≤ 0 for every admissible z.
        let set = every_law();
        let mut nearest = vec![0.0; 12];
        let mut other = vec![0.0; 12];
        for y in points(60) {
            set.project(&y, &mut nearest);
            set.project(&nearest, &mut other);
            assert!((0..12).all(|i| (nearest[i] - other[i]).abs() < 1e-15));
            for z in points(60) {
                set.project(&z, &mut other);
                let product: f64 = (0..12)
                    .map(|i| (y[i] - nearest[i]) * (other[i] - nearest[i]))
                    .sum();
                assert!(product < 1e-13, "{product}");
            }
        }
    }

    #[test]
    fn derivative_agrees_with_differences() {
        let set = every_law();
        let step = 1e-6;
        let (mut before, mut after, mut derivative) = (vec![0.0; 12], vec![0.0; 12], vec![0.0; 12]);
        let all = points(40);
        for (y, v) in all.iter().zip(all.iter().skip(1)) {
            let forward: Vec<f64> = (0..12).map(|i| y[i] + step * v[i]).collect();
            let backward: Vec<f64> = (0..12).map(|i| y[i] - step * v[i]).collect();
            set.project(&forward, &mut after);
            set.project(&backward, &mut before);
            set.project_derivative(y, v, &mut derivative);
            for i in 0..12 {
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
        let set = AdmissibleSet::new(vec![Friction::Tresca { bound: 1.0 }.block(1)]);
        let violation =
            |lambda: [f64; 2], gap: f64| set.slip_violation(&lambda, |i| lambda[i] - [0.0, gap][i]);
        assert_eq!(violation([1.0, 0.5], 0.0), 0.0);
        // The gap is the gradient: a force at its bound has a gap of the opposite sign.
        assert_eq!(violation([1.0, 1.0], -0.3), 0.0);
        assert!(violation([1.0, 1.0], 0.3) > 0.29);
        assert!(violation([1.0, 1.5], 0.0) > 0.49);
        assert!(violation([1.0, f64::NAN], 0.0).is_nan());
    }

    #[test]
    fn cohesion_holds_closed_nodes_alone_and_traces_of_a_force_close_none() {
        let (cohesion, coefficient) = (2.0, 0.5);
        let law = Friction::Cohesive {
            cohesion,
            coefficient,
        };
        let set = AdmissibleSet::new(vec![law.block(1); 4]);
        let lambda = [1e3, 0.0, 0.0, 1.0, 1e-8, 0.0, 1e-6, 0.0];
        assert_eq!(set.bounds(&lambda), [502.0, 0.0, 0.0, 2.0 + 5e-7]);
        // the shear of an open node is a violation, however small it is
        assert_eq!(set.slip_violation(&lambda, |i| lambda[i]), 1.0);
        assert!(set.bounds_follow() && law.bound(0.0) == 0.0 && law.bound(1.0) == 2.5);
    }

    #[test]
    fn dissipation_is_the_bound_times_the_slip_and_less_where_the_law_is_violated() {
        let set = friction();
        // Free (2), unilateral, Tresca (3) at its bound 0.5, Coulomb (3) with μλₙ = 0.4.
        let lambda = [1.0, 1.0, 1.0, 2.0, 0.3, 0.4, 1.0, 0.0, 0.4];
        let mut gap = [9.0, 9.0, 0.0, 0.0, -0.6, -0.8, 0.0, 0.0, -2.0];
        let dissipated = set.dissipated(&lambda, &gap);
        for (found, expected) in dissipated.iter().zip([0.0, 0.0, 0.5, 0.8]) {
            assert!((found - expected).abs() < 1e-15);
        }
        let potential = |gap: &[f64]| -> f64 {
            let each = set.slip_potentials(&lambda, |i| gap[i]);
            each.map(|(_, work)| work).sum()
        };
        assert!((potential(&gap) - 1.3).abs() < 1e-15);
        gap[8] = 2.0;
        assert!(set.dissipated(&lambda, &gap)[3] < 0.0);
        assert!((potential(&gap) - 1.3).abs() < 1e-15);
    }

    #[test]
    fn blocks_lie_one_after_the_other() {
        let set = every_law();
        assert_eq!((set.len(), set.is_empty()), (12, false));
        let ranges = [0..2, 2..3, 3..6, 6..9, 9..12];
        for (index, (range, (block, found))) in ranges.into_iter().zip(set.iter()).enumerate() {
            assert_eq!((set.range(index), found), (range.clone(), range));
            assert_eq!(block, &set.blocks()[index]);
        }
        for none in [AdmissibleSet::new(Vec::new()), AdmissibleSet::default()] {
            assert_eq!((none.len(), none.is_empty()), (0, true));
            assert_eq!(none.iter().count(), 0);
        }
    }

    #[test]
    fn components_are_free_normal_or_tangent() {
        use Component::{Free, Normal, Tangent};
        let expected = [
            Free, Free, Normal, Normal, Tangent, Tangent, Normal, Tangent, Tangent,
        ];
        assert_eq!(friction().components(), expected);
    }

    #[test]
    fn friction_and_bounds_that_follow_are_told_of_the_set() {
        let of = |blocks: &[Block]| {
            let set = AdmissibleSet::new(blocks.to_vec());
            (set.has_friction(), set.bounds_follow())
        };
        let tresca = Friction::Tresca { bound: 0.5 }.block(1);
        let coulomb = Friction::Coulomb { coefficient: 0.5 }.block(1);
        assert_eq!(
            of(&[Block::Unilateral, Block::Free { size: 2 }]),
            (false, false)
        );
        assert_eq!(of(&[Block::Unilateral, tresca]), (true, false));
        assert_eq!(of(&[tresca, coulomb]), (true, true));
    }

    #[test]
    fn a_trace_is_what_is_nothing_beside_the_largest_force_however_large_that_is() {
        let cohesive = Friction::Cohesive {
            cohesion: 2.0,
            coefficient: 0.5,
        };
        let coulomb = Friction::Coulomb { coefficient: 0.5 };
        let set = AdmissibleSet::new(vec![
            Block::Unilateral,
            cohesive.block(1),
            cohesive.block(1),
            coulomb.block(1),
        ]);
        for size in [1e-6, -1e-6, 1e6] {
            let unit: f64 = f64::abs(size);
            let (below, above) = (0.9 * NONE * unit, 1.1 * NONE * unit);
            let lambda = [size, below, 0.0, above, 0.0, below, 0.0];
            // only a bound that jumps is kept from rounding
            let expected = [0.0, 0.0, 2.0 + 0.5 * above, 0.5 * below];
            assert_eq!(set.bounds(&lambda), expected);
        }
    }

    #[test]
    fn sets_with_other_bounds_change_the_laws_alone() {
        let (free, tresca) = (Block::Free { size: 2 }, |bound| Friction::Tresca { bound });
        let blocks = friction().blocks;
        let all = friction().with_all_bounds(0.7);
        let expected = [
            free,
            Block::Unilateral,
            tresca(0.7).block(2),
            tresca(0.7).block(2),
        ];
        assert_eq!(all.blocks(), expected);
        let following = friction().with_bounds(&[9.0, 9.0, 9.0, 0.2]);
        let expected = [free, Block::Unilateral, blocks[2], tresca(0.2).block(2)];
        assert_eq!(following.blocks(), expected);
        let sticking = friction().sticking();
        let node = [Block::Unilateral, Block::Free { size: 2 }];
        let expected = [free, Block::Unilateral, node[0], node[1], node[0], node[1]];
        assert_eq!(sticking.blocks(), expected);
        assert_eq!(sticking.len(), friction().len());
    }

    #[test]
    fn only_shears_beyond_their_bound_are_shortened() {
        let set = friction();
        let near = |a: [f64; 9], b: [f64; 9]| {
            assert!((0..9).all(|i| (a[i] - b[i]).abs() < 1e-15), "{a:?} {b:?}");
        };
        // Tresca at 5 of 0.5, Coulomb at 0.3 of 0.4; then the other way round
        let mut lambda = [7.0, -7.0, -1.0, 2.0, 3.0, -4.0, 1.0, 0.0, 0.3];
        set.bound_tangents(&mut lambda);
        near(lambda, [7.0, -7.0, -1.0, 2.0, 0.3, -0.4, 1.0, 0.0, 0.3]);
        let mut lambda = [7.0, -7.0, -1.0, 2.0, 0.2, 0.1, 5.0, 6.0, -8.0];
        set.bound_tangents(&mut lambda);
        near(lambda, [7.0, -7.0, -1.0, 2.0, 0.2, 0.1, 5.0, 1.2, -1.6]);
    }

    #[test]
    fn worst_node_tells_how_far_the_law_of_friction_is_violated() {
        let set = friction();
        let violation = |tresca: [f64; 2], coulomb: [f64; 2], trial: [f64; 2]| {
            let [a, b] = tresca;
            let [c, d] = coulomb;
            let lambda = [9.0, 9.0, 9.0, 2.0, a, b, 1.0, c, d];
            set.slip_violation(&lambda, |i| match i {
                4 | 5 => trial[i - 4],
                7 | 8 => 0.0,
                _ => 100.0,
            })
        };
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-15, "{found}");
        // at its bound along the slip, whatever its size is
        near(violation([0.3, 0.4], [0.0, 0.0], [3.0, 4.0]), 0.0);
        // within its bound it is the trial shear that counts
        near(violation([0.3, 0.0], [0.0, 0.0], [0.0, 0.4]), 0.5);
        // the bound (0.3, 0.4) off by (0.6, 0.8)
        near(violation([0.9, 1.2], [0.0, 0.0], [0.6, 0.8]), 1.0);
        // the larger of both, whichever comes first
        near(violation([0.9, 1.2], [0.3, 0.0], [0.6, 0.8]), 1.0);
        near(violation([0.0, 0.0], [0.0, -2.0], [0.0, 0.0]), 2.0);
    }

    #[test]
    fn a_set_that_is_all_compression_or_tie_has_no_tension() {
        assert_eq!(
            friction().tension(&[-5.0, -5.0, 1.0, 2.0, -3.0, 0.0, 3.0, 0.0, 0.0]),
            0.0
        );
    }
}
