//! Can any admissible force balance the load? If not, along which rigid motion does the load pull the bodies away?
//!
//! ```text
//!   C = {Gλ: λ ∈ Λ}         the loads that the contacts can bear
//!   y = e − nearest point of C to e        the part of the load that they cannot bear
//! ```
//!
//! Where y = 0 some admissible force balances the load. Where y ≠ 0 no admissible force does, and y proves it (Farkas): as a rigid
//! motion it closes no unilateral contact, (Gᵀy)ᵢ ≤ 0, and moves no tied one, (Gᵀy)ᵢ = 0, while the load does work on it,
//! eᵀy > 0. So y is the motion along which the load pulls the bodies away. (Where friction has given bounds the contacts bear
//! some load along y, too: then eᵀy is more than the work of any forces that they can bear.)
//!
//! C is described by *generators*: the sums of these vectors with weights ≥ 0 are the points of C. Each block of Λ gives its own
//! (`law.rs`), and the weights that come nearest to e are found by least squares with signs (`linalg/signed.rs`), of many
//! bodies by an interior point method (`cone.rs`) whose answer is checked.
//!
//! Two sets have no finite list of generators that could be written down at once. The cone of Coulomb's law in space is round:
//! it has infinitely many edges. The shears that given bounds allow, all nodes together, are a bounded convex set: it is the
//! hull of its corners, whose weights must sum to one, and has far too many of them. Of both sets, the generators that lie
//! farthest along y are added repeatedly until no generator lies along y. With many bodies and round cones, polygons
//! inscribed in the cones mostly bear the load already.
//!
//! Where a bound of friction follows from the normal force, a positive answer is necessary for a solution, not sufficient: the
//! shears must oppose the slips, too.
//!
//! Where friction does not suffice, y opens contacts while it slips along them, in the ratio of the coefficient, which no body does.
//! So y serves only to find the contacts that slip. The motion reported is the one without friction there and without slip
//! elsewhere, together with the part of the load along it that friction can hold. Where no friction whatever could hold the bodies
//! (they tip or are lifted), it is the motion that remains when no contact slips, and friction holds no part of the load along it.

use crate::dual::law::{Generators, Round, farthest};
use crate::dual::modes::transposed;
use crate::dual::split::{MANY, Split};
use crate::dual::{AdmissibleSet, Balance, Block, DualProblem, ModeSplit, Modes, cone};
use crate::linalg::SparseVector;
use crate::linalg::dense::{dot, norm};
use crate::linalg::signed::least_squares_nonnegative;
use std::f64::consts::TAU;
use std::ops::Range;

/// Work on a rigid motion below this part of the load's scale counts as zero.
pub const NO_WORK: f64 = 1e-9;

/// Answer of [`DualProblem::feasibility`].
#[derive(Debug, Clone, PartialEq)]
pub enum Feasibility {
    /// Some admissible force balances the load.
    Feasible {
        /// Gλ of that force, (r,): e, or e without a part below 1e-9 of the load's scale that no force can carry.
        load: Vec<f64>,
    },
    /// No admissible force balances the load.
    Infeasible {
        /// Amplitudes z (r,), unit length: the rigid motion along which the load pulls the bodies away.
        direction: Vec<f64>,
        /// Largest part s in [0, 1) of the load along that motion which friction can hold: e − (1 − s)(z·e)z is
        /// balanced by an admissible force. `None`: no friction, however steep, could hold it.
        factor: Option<f64>,
    },
}

/// Rounds in which generators are added for round cones and for bounded shears.
const ROUNDS: usize = 300;

/// Most edges of round cones that are added in a round.
const EDGES: usize = 20;

/// Corners of the polygons inscribed in the cones of many bodies, and rounds in which each gets two more.
const CORNERS: usize = 8;
const ROUNDS_OF_MANY: usize = 20;

/// With many bodies, a rest below this part of the load counts as zero, and an edge points along a rest if its cosine exceeds the second.
const BORNE: f64 = 1e-11;
const SEPARATED: f64 = 1e-9;

/// Corners of a polygon are farther apart than this.
const CORNERS_APART: f64 = 1e-5;

/// An edge adds nothing if the cosine of its angle to the rest is below this.
const ALONG: f64 = 1e-13;

/// Bisections of a load factor, down to the rounding of a load.
const BISECTIONS: usize = 48;

impl DualProblem {
    /// Whether {λ ∈ Λ, Gλ = e} is empty, and why.
    pub fn feasibility(&self) -> Feasibility {
        Feasibility::of(&self.admissible, &self.balance, self.scales.force)
    }
}

impl Feasibility {
    /// Whether {λ ∈ Λ, Gλ = e} is empty, and why; `force` is the scale of the loads, where it is larger than e.
    pub fn of(admissible: &AdmissibleSet, balance: &Balance, force: f64) -> Self {
        let load = balance.load();
        let no_work = NO_WORK * scale_of(load, force);
        let carrier = Carrier::new(admissible, balance);
        let (driven, rest) = carrier.rest(load);
        if norm(&driven) <= no_work && norm(&rest) <= no_work {
            let target = carrier.reduce(load);
            let carried: Vec<f64> = target.iter().zip(&rest).map(|(t, rest)| t - rest).collect();
            return Feasibility::Feasible {
                load: carrier.expand(&carried, load.len()),
            };
        }
        if !admissible.has_friction() {
            let direction = match norm(&driven) > no_work {
                true => unit(driven),
                false => unit(carrier.expand(&rest, load.len())),
            };
            let factor = None;
            return Feasibility::Infeasible { direction, factor };
        }
        let motion = |set: &AdmissibleSet| -> Vec<f64> {
            let carrier = Carrier::new(set, balance);
            let (driven, rest) = carrier.rest(load);
            let rest = carrier.expand(&rest, load.len());
            driven.iter().zip(&rest).map(|(d, rest)| d + rest).collect()
        };
        let held = motion(&admissible.sticking());
        if norm(&held) > no_work {
            let (direction, factor) = (unit(held), None);
            return Feasibility::Infeasible { direction, factor };
        }
        let slips = slipping(admissible, balance, &motion(admissible));
        let mechanism = motion(&admissible.with_slip(&slips));
        let direction = match norm(&mechanism) > no_work {
            true => unit(mechanism),
            false => unit(motion(&admissible.with_all_bounds(0.0))),
        };
        let factor = Self::part_along(admissible, balance, &direction, force);
        let factor = Some(factor);
        Feasibility::Infeasible { direction, factor }
    }

    /// Largest s in [0, 1] for which some admissible force balances e − (1 − s)(z·e)z, z = `direction` (r,) of unit length: the part
    /// of the load along that motion which is held. `force` as in [`Self::of`].
    pub fn part_along(
        admissible: &AdmissibleSet,
        balance: &Balance,
        direction: &[f64],
        force: f64,
    ) -> f64 {
        let load = balance.load();
        let no_work = NO_WORK * scale_of(load, force);
        let carrier = Carrier::new(admissible, balance);
        let work = dot(direction, load);
        largest_part(|part| {
            let along = |(e, z): (&f64, &f64)| e - (1.0 - part) * work * z;
            let reduced: Vec<f64> = load.iter().zip(direction).map(along).collect();
            carrier.carries(&reduced, no_work)
        })
    }

    /// Whether a motion (r,) turns about a contact that stays closed: the first row of a block keeps its gap, although parts of
    /// the motion, which cancel, would change it.
    pub fn leans(admissible: &AdmissibleSet, balance: &Balance, motion: &[f64]) -> bool {
        let touched = admissible.iter();
        let touched = touched.filter(|(block, _)| !matches!(block, Block::Interval { .. }));
        let rates = touched.filter_map(|(_, range)| {
            let column = balance.modes().column(range.start);
            let parts = column
                .entries()
                .map(|(mode, part)| (part * motion[mode]).abs());
            (!range.is_empty()).then(|| (column.dot(motion).abs(), parts.sum::<f64>()))
        });
        let rates: Vec<(f64, f64)> = rates.collect();
        let largest = rates.iter().fold(0.0, |s: f64, (_, parts)| s.max(*parts));
        let keeps =
            |&(rate, parts): &(f64, f64)| rate <= NO_SLIP * parts && parts > NO_SLIP * largest;
        rates.iter().any(keeps)
    }

    /// Largest s in [0, 1] for which some admissible force balances e₀ + s(e − e₀), e₀ = `before` (r,) the load of the
    /// step before and e that of `balance`: the part of the step at which equilibrium is lost; 1 if it is not lost.
    ///
    /// The loads that can be balanced are convex, so a load e₀ that is one of them makes the answer unique; 0 if it is not.
    pub fn fraction(admissible: &AdmissibleSet, balance: &Balance, before: &[f64]) -> f64 {
        let load = balance.load();
        let no_work = NO_WORK * scale_of(before, scale_of(load, 0.0));
        let carrier = Carrier::new(admissible, balance);
        largest_part(|part| {
            let between = |(e, e0): (&f64, &f64)| e0 + part * (e - e0);
            let mixed: Vec<f64> = load.iter().zip(before).map(between).collect();
            carrier.carries(&mixed, no_work)
        })
    }
}

/// A slip below this part of the largest is rounding of a motion.
const NO_SLIP: f64 = 1e-6;

/// Which blocks with friction slip in a motion (r,), block after block.
fn slipping(admissible: &AdmissibleSet, balance: &Balance, motion: &[f64]) -> Vec<bool> {
    let slip = |(block, range): (&Block, Range<usize>)| {
        let slips = block.shear(&range);
        let slips = slips.map(|row| balance.modes().column(row).dot(motion));
        slips.fold(0.0, |s: f64, slip| s.max(slip.abs()))
    };
    let slips: Vec<f64> = admissible.iter().map(slip).collect();
    let largest = slips.iter().fold(0.0, |s: f64, slip| s.max(*slip));
    let slips = slips.into_iter();
    slips.map(|slip| slip > NO_SLIP * largest).collect()
}

/// Largest s in [0, 1] for which `holds` is true, if these s form an interval from 0.
fn largest_part(holds: impl Fn(f64) -> bool) -> f64 {
    if holds(1.0) {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

fn scale_of(load: &[f64], force: f64) -> f64 {
    load.iter().fold(force, |s, e| s.max(e.abs()))
}

/// {Gλ: λ ∈ Λ} by generators, in the coordinates of the modes that the contact controls.
struct Carrier {
    split: ModeSplit,
    /// Vectors whose weights are any ≥ 0.
    rays: Vec<SparseVector>,
    /// Axis and radii of the round cones.
    cones: Vec<(SparseVector, Vec<SparseVector>)>,
    /// Shears of given bounds, and forces of bounds that bend.
    rounds: Vec<Round>,
}

impl Carrier {
    fn new(admissible: &AdmissibleSet, balance: &Balance) -> Self {
        let modes = balance.modes();
        let smooth = |block: &Block| block.friction().is_some_and(|law| law.is_smooth());
        // shears of blocks without friction control no mode
        let split = if admissible.blocks().iter().any(smooth) {
            let mut borne = modes.columns().to_vec();
            for (block, range) in admissible.iter().filter(|(block, _)| smooth(block)) {
                borne[block.shear(&range)].fill(SparseVector::new(modes.nrows(), []));
            }
            Split::new(&Modes::new(modes.nrows(), borne)).map(|split| split.modes)
        } else {
            balance.split().cloned()
        };
        let mut carrier = Self {
            // no decomposition of finite entries is known to fail; if one did, the projection would decide
            split: split.unwrap_or_default(),
            rays: Vec::new(),
            cones: Vec::new(),
            rounds: Vec::new(),
        };
        let controlled = transposed(&carrier.split.controlled, modes.nrows());
        let k = carrier.split.controlled.len();
        for (block, range) in admissible.iter() {
            let image = |i: usize| {
                let parts = modes.column(i).entries();
                let parts = parts.map(|(mode, value)| (value, &controlled[mode]));
                SparseVector::new(k, []).plus(parts)
            };
            let Generators { rays, cone, round } = block.generators(range.map(image).collect());
            // those of a round cone are added where it is made a polygon
            match cone {
                Some(cone) => carrier.cones.push(cone),
                None => carrier.rays.extend(rays),
            }
            carrier.rounds.extend(round);
        }
        carrier
    }

    /// Coordinates of v (r,) in the controlled modes, (k,).
    fn reduce(&self, v: &[f64]) -> Vec<f64> {
        let modes = self.split.controlled.iter();
        modes.map(|mode| mode.dot(v)).collect()
    }

    /// The vector (r,) with the coordinates v (k,) in the controlled modes.
    fn expand(&self, v: &[f64], r: usize) -> Vec<f64> {
        let mut expanded = vec![0.0; r];
        for (mode, part) in self.split.controlled.iter().zip(v) {
            mode.add_to(*part, &mut expanded);
        }
        expanded
    }

    /// Some admissible force balances `load` up to `no_work`.
    fn carries(&self, load: &[f64], no_work: f64) -> bool {
        let (driven, rest) = self.rest(load);
        norm(&driven) <= no_work && norm(&rest) <= no_work
    }

    /// The part of `load` (r,) that no admissible force balances: along uncontrolled modes (r,), and in the coordinates of the
    /// controlled ones (k,), where it separates the load from those that can be carried.
    fn rest(&self, load: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut driven = vec![0.0; load.len()];
        for z in &self.split.uncontrolled {
            z.add_to(z.dot(load), &mut driven);
        }
        let target = self.reduce(load);
        let rest = if self.cones.is_empty() && self.rounds.is_empty() {
            self.rest_of_cone(&target)
        } else {
            let rest = self.rest_of_round_cones(&target);
            rest.unwrap_or_else(|| self.rest_with_generation(target))
        };
        (driven, rest)
    }

    /// The rest of many bodies beyond round cones, from polygons inscribed in them that grow where they are needed: `None` where
    /// bodies are few, where bounds of friction are given, and where no answer could be verified.
    fn rest_of_round_cones(&self, target: &[f64]) -> Option<Vec<f64>> {
        if target.len() < MANY || !self.rounds.is_empty() {
            return None;
        }
        let corners = (0..CORNERS).map(|k| (k as f64 * TAU / CORNERS as f64).sin_cos());
        let corners: Vec<[f64; 2]> = corners.map(|(sin, cos)| [cos, sin]).collect();
        let mut polygons = vec![corners; self.cones.len()];
        for _ in 0..ROUNDS_OF_MANY {
            let mut rays = self.rays.clone();
            for (cone, turns) in polygons.iter().enumerate() {
                rays.extend(turns.iter().map(|&turn| self.edge(cone, turn)));
            }
            let nearest = cone::nearest(&rays, target)?;
            let rest = &nearest.rest;
            let size = norm(rest);
            let mut weights = nearest.weights[self.rays.len()..].iter();
            let mut left = false;
            for (cone, turns) in polygons.iter_mut().enumerate() {
                let mut shear = [0.0; 2];
                for (turn, weight) in turns.iter().zip(weights.by_ref()) {
                    shear = [0, 1].map(|d| shear[d] + weight * turn[d]);
                }
                let steepest = farthest(&self.cones[cone].1, rest);
                let steepest = [steepest[0], steepest[1]];
                let edge = self.edge(cone, steepest);
                left |= edge.dot(rest) > SEPARATED * size * edge.norm();
                // new edges: along the present shear and along the rest
                let length = norm(&shear).max(f64::MIN_POSITIVE);
                for turn in [shear.map(|s| s / length), steepest] {
                    let beside = |own: &[f64; 2]| {
                        (own[0] - turn[0]).hypot(own[1] - turn[1]) > CORNERS_APART
                            && norm(&turn) > 0.5
                    };
                    if turns.iter().all(beside) {
                        turns.push(turn);
                    }
                }
            }
            // nothing admissible lies along the rest: it is zero, or proves that the load is not borne
            if !left || size <= BORNE * norm(target) {
                return Some(nearest.rest);
            }
        }
        None
    }

    /// An edge of a round cone of two radii. The unit vector `turn` tells which.
    fn edge(&self, cone: usize, turn: [f64; 2]) -> SparseVector {
        let (axis, radii) = &self.cones[cone];
        axis.plus(turn.into_iter().zip(radii))
    }

    /// The rest where the list of generators is complete.
    fn rest_of_cone(&self, target: &[f64]) -> Vec<f64> {
        if target.len() >= MANY
            && let Some(rest) = cone::rest(&self.rays, target)
        {
            return rest;
        }
        least_squares_nonnegative(&self.dense_rays(), target).1
    }

    fn dense_rays(&self) -> Vec<Vec<f64>> {
        self.rays.iter().map(SparseVector::to_dense).collect()
    }

    /// The rest where generators are added along it. An additional row makes the weights of the corners of the bounded shears
    /// sum to one.
    fn rest_with_generation(&self, mut target: Vec<f64>) -> Vec<f64> {
        let k = target.len();
        let weight = Some(norm(&target))
            .filter(|size| *size > 0.0)
            .unwrap_or(1.0);
        target.push(weight);
        let mut columns = self.dense_rays();
        let along = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        for cone in 0..self.cones.len() {
            columns.extend(along.map(|turn| self.edge(cone, turn).to_dense()));
        }
        columns.iter_mut().for_each(|column| column.push(0.0));
        let mut none = vec![0.0; k];
        none.push(weight);
        columns.push(none);
        let mut rest = Vec::new();
        for _ in 0..ROUNDS {
            rest = least_squares_nonnegative(&columns, &target).1;
            let mut wanted = self.steepest_edges(&rest[..k]);
            wanted.iter_mut().for_each(|edge| edge.push(0.0));
            let mut corner = self.corner(&rest[..k]);
            corner.push(weight);
            wanted.push(corner);
            let gains = |column: &Vec<f64>| {
                dot(column, &rest) > ALONG * norm(&target) * norm(column)
                    && !columns.contains(column)
            };
            let added: Vec<Vec<f64>> = wanted.into_iter().filter(gains).collect();
            if added.is_empty() {
                break;
            }
            columns.extend(added);
        }
        rest.pop();
        rest
    }

    /// The edge of each round cone that points most along `rest`.
    fn edges(&self, rest: &[f64]) -> impl Iterator<Item = SparseVector> {
        self.cones.iter().map(|(axis, radii)| {
            let turn = farthest(radii, rest);
            axis.plus(turn.into_iter().zip(radii))
        })
    }

    /// Those of them that point most along `rest`, with their zeros.
    fn steepest_edges(&self, rest: &[f64]) -> Vec<Vec<f64>> {
        let mut edges: Vec<(f64, SparseVector)> = self
            .edges(rest)
            .map(|edge| (edge.dot(rest), edge))
            .collect();
        edges.sort_by(|a, b| b.0.total_cmp(&a.0));
        edges.truncate(EDGES);
        edges.iter().map(|(_, edge)| edge.to_dense()).collect()
    }

    /// The corner of the round bodies that lies farthest along `rest`.
    fn corner(&self, rest: &[f64]) -> Vec<f64> {
        let mut corner = vec![0.0; rest.len()];
        for round in &self.rounds {
            round.add_farthest(rest, &mut corner);
        }
        corner
    }
}

fn unit(mut v: Vec<f64>) -> Vec<f64> {
    let length = norm(&v);
    v.iter_mut().for_each(|x| *x /= length);
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::split::tests::row_of_discs;
    use crate::dual::{AdmissibleSet, Balance, Block, Compliance, Coupled, Friction, Mat, Scales};

    /// A plate on two unilateral points at x = 0 and 1 (forces up), modes: lift and rotation.
    fn plate(load: [f64; 2], blocks: [Block; 2]) -> DualProblem {
        let modes = Mat::from_fn(2, 2, |i, j| if i == 0 { -1.0 } else { -(j as f64) });
        DualProblem {
            compliance: Compliance::Dense(Mat::from_fn(2, 2, |i, j| f64::from(i == j))),
            shift: vec![0.0; 2],
            admissible: AdmissibleSet::new(blocks.to_vec()),
            balance: Balance::new(modes, load.to_vec()),
            scales: Scales::default(),
            coupled: Coupled::default(),
            softness: vec![1.0; 2],
            neighbours: Vec::new(),
            parts: Vec::new(),
        }
    }

    #[test]
    fn load_between_the_supports_is_carried() {
        let problem = plate([-1.0, -0.3], [Block::Unilateral; 2]);
        let Feasibility::Feasible { load } = problem.feasibility() else {
            panic!("the load lies between the supports");
        };
        assert!((load[0] + 1.0).abs() < 1e-14 && (load[1] + 0.3).abs() < 1e-14);
    }

    #[test]
    fn load_beside_the_supports_tips_the_plate() {
        let problem = plate([-1.0, -1.5], [Block::Unilateral; 2]);
        let Feasibility::Infeasible { direction, .. } = problem.feasibility() else {
            panic!("the load lies beside the supports");
        };
        // It opens both contacts (G z ≤ 0 in each column), and the load works on it.
        for j in 0..2 {
            let image: f64 = (0..2)
                .map(|i| problem.balance.modes()[(i, j)] * direction[i])
                .sum();
            assert!(image < 1e-12, "contact {j}: {image}");
        }
        assert!(dot(&direction, problem.balance.load()) > 0.1);
    }

    #[test]
    fn a_tie_carries_what_a_contact_cannot() {
        let tied = plate([-1.0, -1.5], [Block::Free { size: 1 }, Block::Unilateral]);
        assert!(matches!(tied.feasibility(), Feasibility::Feasible { .. }));
    }

    #[test]
    fn driven_mode_without_contact_is_named() {
        let mut problem = plate([-1.0, 0.5], [Block::Unilateral; 2]);
        let first = &problem.balance.modes().rows()[0];
        let none = SparseVector::new(2, []);
        let modes = Modes::of_rows(&[first.clone(), none], 2);
        problem.balance = Balance::new(modes, problem.balance.load().to_vec());
        let Feasibility::Infeasible { direction, .. } = problem.feasibility() else {
            panic!("nothing holds mode 1");
        };
        assert_eq!(direction, vec![0.0, 1.0]);
        let load = problem.balance.load()[0];
        problem.balance.set_load(vec![load, 1e-12]);
        assert!(matches!(
            problem.feasibility(),
            Feasibility::Feasible { .. }
        ));
    }

    /// A block on a plane, two nodes at x = ∓1: (normal, tangential..) each; modes: sinking, sliding.., tipping.
    fn block_on_plane(block: Block, load: &[f64]) -> Feasibility {
        let size = block.size();
        let modes = Mat::from_fn(1 + size, 2 * size, |mode, i| {
            let component = i % size;
            if mode == size {
                // The normal force turns the block about its middle, 1 away.
                if component == 0 {
                    (i / size) as f64 * 2.0 - 1.0
                } else {
                    0.0
                }
            } else {
                f64::from(mode == component)
            }
        });
        let set = AdmissibleSet::new(vec![block; 2]);
        Feasibility::of(&set, &Balance::new(modes, load.to_vec()), 0.0)
    }

    fn feasible(block: Block, load: &[f64]) -> bool {
        matches!(block_on_plane(block, load), Feasibility::Feasible { .. })
    }

    #[test]
    fn friction_holds_a_block_up_to_its_coefficient_and_no_further() {
        let coulomb = |tangents| Friction::Coulomb { coefficient: 0.3 }.block(tangents);
        assert!(feasible(coulomb(1), &[1.0, 0.3 - 1e-8, 0.0]));
        assert!(!feasible(coulomb(1), &[1.0, 0.3 + 1e-8, 0.0]));
        let oblique = |size: f64| [1.0, 0.6 * size, -0.8 * size, 0.2];
        assert!(feasible(coulomb(2), &oblique(0.3 - 1e-6)));
        assert!(!feasible(coulomb(2), &oblique(0.3 + 1e-6)));
        let tresca = |tangents| Friction::Tresca { bound: 0.15 }.block(tangents);
        assert!(feasible(tresca(1), &[1.0, 0.3 - 1e-8, 0.2]));
        assert!(!feasible(tresca(1), &[1.0, 0.3 + 1e-8, 0.2]));
        assert!(feasible(tresca(2), &oblique(0.3 - 1e-6)));
        assert!(!feasible(tresca(2), &oblique(0.3 + 1e-6)));
        // two nodes with 0.05 each beside 0.2 of the weight
        let cohesive = |tangents| {
            let (cohesion, coefficient) = (0.05, 0.2);
            Friction::Cohesive {
                cohesion,
                coefficient,
            }
            .block(tangents)
        };
        assert!(feasible(cohesive(1), &[1.0, 0.3 - 1e-8, 0.2]));
        assert!(!feasible(cohesive(1), &[1.0, 0.3 + 1e-8, 0.2]));
        assert!(feasible(cohesive(2), &oblique(0.3 - 1e-6)));
        assert!(!feasible(cohesive(2), &oblique(0.3 + 1e-6)));
    }

    #[test]
    fn sliding_block_is_told_its_motion_and_the_part_that_friction_holds() {
        let block = Friction::Coulomb { coefficient: 0.3 }.block(1);
        let Feasibility::Infeasible { direction, factor } =
            block_on_plane(block, &[1.0, -0.4, 0.1])
        else {
            panic!("0.4 is more than 0.3");
        };
        assert!((direction[1] + 1.0).abs() < 1e-12, "{direction:?}");
        assert!((factor.unwrap() - 0.75).abs() < 1e-8, "{factor:?}");
    }

    #[test]
    fn tipping_block_is_not_held_by_any_friction() {
        for coefficient in [0.3, 1e3] {
            let block = Friction::Coulomb { coefficient }.block(1);
            let Feasibility::Infeasible { direction, factor } =
                block_on_plane(block, &[1.0, 0.1, 1.2])
            else {
                panic!("the load lies beside the supports");
            };
            assert_eq!(factor, None);
            // It opens node 0 and lets node 1 rest: sinking against turning.
            assert!(
                direction[1].abs() < 1e-12 && direction[2] > 0.5,
                "{direction:?}"
            );
            assert!((direction[0] + direction[2]).abs() < 1e-12, "{direction:?}");
        }
    }

    #[test]
    fn wedge_is_held_by_friction_above_its_slope() {
        // One node whose normal pushes back at 45°: without friction it slips out.
        let root = 0.5f64.sqrt();
        let modes = Mat::from_fn(
            2,
            2,
            |mode, i| if mode == 1 && i == 0 { -root } else { root },
        );
        let load = Balance::new(modes, vec![1.0, 0.0]);
        let held = |coefficient| {
            let set = AdmissibleSet::new(vec![Friction::Coulomb { coefficient }.block(1)]);
            Feasibility::of(&set, &load, 0.0)
        };
        assert!(matches!(held(1.01), Feasibility::Feasible { .. }));
        let Feasibility::Infeasible { factor, .. } = held(0.5) else {
            panic!("the slope is 1");
        };
        // Along the slope the load is as large as across: half of it is held.
        assert!((factor.unwrap() - 0.5).abs() < 1e-8, "{factor:?}");
    }

    #[test]
    fn smooth_contacts_hold_no_sliding_even_with_tangents() {
        for block in [
            Friction::Coulomb { coefficient: 0.0 }.block(1),
            Friction::Tresca { bound: 0.0 }.block(1),
        ] {
            assert!(feasible(block, &[1.0, 0.0, 0.3]));
            let Feasibility::Infeasible { direction, factor } =
                block_on_plane(block, &[1.0, 0.1, 0.3])
            else {
                panic!("nothing holds it");
            };
            assert!((direction[1] - 1.0).abs() < 1e-12 && factor.is_none());
        }
    }

    #[test]
    fn fraction_of_a_step_ends_where_equilibrium_does() {
        let modes = Mat::from_fn(2, 2, |mode, i| f64::from(mode == i));
        let set = AdmissibleSet::new(vec![Friction::Coulomb { coefficient: 0.5 }.block(1)]);
        let fraction = |load: [f64; 2], before: [f64; 2]| {
            Feasibility::fraction(&set, &Balance::new(modes.clone(), load.to_vec()), &before)
        };
        assert_eq!(fraction([1.0, 0.4], [1.0, 0.0]), 1.0);
        assert!((fraction([1.0, 0.8], [1.0, 0.2]) - 0.5).abs() < 1e-8);
        // Unloading: T = 0.3 at N = 1 − 0.8 s is lost at N = 0.6.
        assert!((fraction([0.2, 0.3], [1.0, 0.3]) - 0.5).abs() < 1e-8);
        assert!(fraction([1.0, 0.9], [1.0, 0.8]) < 1e-8);
    }

    #[test]
    fn largest_part_is_the_end_of_an_interval() {
        assert_eq!(largest_part(|_| true), 1.0);
        assert_eq!(
            largest_part(|part| part < 1.0),
            1.0 - 0.5f64.powi(BISECTIONS as i32)
        );
        assert_eq!(largest_part(|_| false), 0.0);
        for end in [0.3, 0.77] {
            let found = largest_part(|part| part <= end);
            assert!(found <= end && end - found < 1e-14, "{found}");
        }
    }

    #[test]
    fn work_that_is_nothing_beside_the_largest_load_drives_nothing() {
        // mode 1 meets no contact
        let modes = Mat::from_fn(2, 1, |i, _| [1.0, 0.0][i]);
        let set = AdmissibleSet::new(vec![Block::Unilateral]);
        let feasible = |load: [f64; 2], force: f64| {
            let balance = Balance::new(modes.clone(), load.to_vec());
            matches!(
                Feasibility::of(&set, &balance, force),
                Feasibility::Feasible { .. }
            )
        };
        for size in [1e-6, 1.0, 1e6] {
            assert!(feasible([size, 0.9 * NO_WORK * size], 0.0));
            assert!(feasible([size, -0.9 * NO_WORK * size], 0.0));
            assert!(!feasible([size, 1.1 * NO_WORK * size], 0.0));
            assert!(!feasible([size, -1.1 * NO_WORK * size], 0.0));
            // a scale given by the caller
            assert!(feasible([size, 0.9 * NO_WORK * 5.0 * size], 5.0 * size));
            assert!(!feasible([size, 1.1 * NO_WORK * 5.0 * size], 5.0 * size));
            // the same for what contact controls but cannot bear
            assert!(feasible([-0.9 * NO_WORK * size, 0.0], size));
            assert!(!feasible([-1.1 * NO_WORK * size, 0.0], size));
        }
        assert!(feasible([0.0; 2], 0.0));
        // the load that is carried lacks the part that no force can carry
        let balance = Balance::new(modes.clone(), vec![1.0, 1e-10]);
        let Feasibility::Feasible { load } = Feasibility::of(&set, &balance, 0.0) else {
            panic!("the rest is rounding");
        };
        assert!((load[0] - 1.0).abs() < 1e-15 && load[1] == 0.0);
    }

    /// The projection decides up to this distance from the last load that can be carried; nearer it needs more steps than it has.
    const WITHIN: f64 = 3e-3;
    const BEYOND: f64 = 1e-4;

    /// Sets of a few nodes of several kinds, by number; modes and loads of three motions.
    fn random(seed: usize) -> (AdmissibleSet, Mat<f64>, Vec<f64>) {
        // of squares: sines of sums of two indices would make modes of rank 2
        let wave = |i: usize| (((i * 37 + seed * 101).pow(2)) as f64 * 0.061).sin();
        let laws = [
            Friction::Coulomb { coefficient: 0.5 }.block(2),
            Friction::Tresca { bound: 0.4 }.block(2),
        ];
        let blocks = match seed % 4 {
            0 => vec![Block::Unilateral; 5],
            1 => vec![Block::Unilateral, laws[0], laws[1]],
            2 => vec![Friction::Coulomb { coefficient: 0.5 }.block(1); 3],
            _ => vec![Block::Free { size: 1 }, Block::Unilateral, laws[1]],
        };
        let set = AdmissibleSet::new(blocks);
        let modes = Mat::from_fn(3, set.len(), |i, j| wave(50 + i * set.len() + j));
        let load = (0..3).map(|i| wave(i + 9)).collect();
        (set, modes, load)
    }

    /// The imbalance left by projecting some forces: an iteration that knows no generators. Near the last load that can be
    /// carried it may need more steps than it has, so that it starts from several.
    fn projected(set: &AdmissibleSet, modes: &Mat<f64>, load: &[f64]) -> f64 {
        let balance = Balance::new(modes.clone(), load.to_vec());
        let rest = |start: usize| {
            let wave = |i: usize| start as f64 * (1.0 + ((i + start) as f64).sin());
            let y: Vec<f64> = (0..set.len()).map(wave).collect();
            let (mut tau, mut lambda) = (vec![0.0; balance.rank()], vec![0.0; set.len()]);
            let projector = &mut balance.projector(set);
            projector.project(&y, &mut tau, &mut lambda)
        };
        (0..6).map(rest).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn load_is_carried_where_the_projection_finds_forces_and_nowhere_else() {
        let (mut carried, mut lost) = (0, 0);
        for seed in 0..80 {
            let (set, modes, load) = random(seed);
            let balance = Balance::new(modes.clone(), load.clone());
            match Feasibility::of(&set, &balance, 0.0) {
                Feasibility::Feasible { load: found } => {
                    carried += 1;
                    assert!((0..3).all(|i| (found[i] - load[i]).abs() < 1e-12));
                    assert!(projected(&set, &modes, &load) < 1e-9, "seed {seed}");
                }
                Feasibility::Infeasible { direction, factor } => {
                    lost += 1;
                    assert!(projected(&set, &modes, &load) > 1e-6, "seed {seed}");
                    assert!((norm(&direction) - 1.0).abs() < 1e-14);
                    let work = dot(&direction, &load);
                    assert!(work > 0.0);
                    let Some(factor) = factor else { continue };
                    let left = |part: f64| {
                        let along = |i: usize| load[i] - (1.0 - part) * work * direction[i];
                        let left: Vec<f64> = (0..3).map(along).collect();
                        projected(&set, &modes, &left)
                    };
                    assert!(
                        left((factor - WITHIN).max(0.0)) < 1e-8,
                        "seed {seed} {factor}"
                    );
                    assert!(left(factor + BEYOND) > 1e-6, "seed {seed} {factor}");
                }
            }
        }
        assert!(carried >= 10 && lost >= 10, "{carried} {lost}");
    }

    #[test]
    fn motion_of_bodies_without_friction_opens_contacts_and_moves_no_tie() {
        for seed in 0..40 {
            let (_, modes, load) = random(seed);
            let modes = Mat::from_fn(3, 5, |i, j| modes[(i, j)]);
            let blocks = [vec![Block::Free { size: 1 }], vec![Block::Unilateral; 4]].concat();
            let set = AdmissibleSet::new(blocks);
            let balance = Balance::new(modes.clone(), load.clone());
            let Feasibility::Infeasible { direction, factor } =
                Feasibility::of(&set, &balance, 0.0)
            else {
                continue;
            };
            assert_eq!(factor, None);
            assert!(dot(&direction, &load) > 0.0);
            let closes = |j: usize| dot(modes.col_as_slice(j), &direction);
            assert!(closes(0).abs() < 1e-12 && (1..5).all(|j| closes(j) < 1e-12));
        }
    }

    #[test]
    fn fraction_ends_where_the_projection_finds_no_forces_any_more() {
        let mut ends = 0;
        for seed in 0..60 {
            let (set, modes, load) = random(seed);
            // a load that some force within Λ carries
            let wave = |i: usize| 1.0 + 0.5 * ((i + seed) as f64).sin();
            let mut force = vec![0.0; set.len()];
            set.project(&(0..set.len()).map(wave).collect::<Vec<_>>(), &mut force);
            let before: Vec<f64> = (0..3)
                .map(|i| (0..set.len()).map(|j| modes[(i, j)] * force[j]).sum())
                .collect();
            let balance = Balance::new(modes.clone(), load.clone());
            let part = Feasibility::fraction(&set, &balance, &before);
            let at = |part: f64| {
                let mixed = |i: usize| before[i] + part * (load[i] - before[i]);
                projected(&set, &modes, &(0..3).map(mixed).collect::<Vec<_>>())
            };
            if part < 1.0 {
                ends += 1;
                assert!(
                    at(part - WITHIN) < 1e-9 && at(part + BEYOND) > 1e-6,
                    "seed {seed} {part}"
                );
            } else {
                assert!(at(1.0) < 1e-9, "seed {seed}");
            }
        }
        assert!(ends >= 10, "{ends}");
    }

    #[test]
    fn smooth_nodes_among_rough_ones_hold_no_motion_along_themselves() {
        // node 0 is smooth and slides along mode 1, node 1 holds mode 2 by friction
        let modes = Mat::from_fn(3, 4, |i, j| {
            f64::from(matches!((i, j), (0, 0) | (1, 1) | (0, 2) | (2, 3)))
        });
        let smooth = Friction::Coulomb { coefficient: 0.0 }.block(1);
        let rough = Friction::Coulomb { coefficient: 0.5 }.block(1);
        let set = AdmissibleSet::new(vec![smooth, rough]);
        let of = |load: [f64; 3]| {
            Feasibility::of(&set, &Balance::new(modes.clone(), load.to_vec()), 0.0)
        };
        assert!(matches!(of([1.0, 0.0, 0.4]), Feasibility::Feasible { .. }));
        let Feasibility::Infeasible { direction, factor } = of([1.0, -0.1, 0.4]) else {
            panic!("nothing holds mode 1");
        };
        assert_eq!(factor, None);
        for (found, expected) in direction.iter().zip([0.0, -1.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12, "{direction:?}");
        }
    }

    fn carrier() -> Carrier {
        Carrier {
            split: ModeSplit::default(),
            rays: Vec::new(),
            cones: Vec::new(),
            rounds: Vec::new(),
        }
    }

    #[test]
    fn edges_that_point_most_along_the_rest_are_added_first() {
        let mut carrier = carrier();
        let count = EDGES + 5;
        // axes of 0, 1, .. along x, and one radius along y
        let sparse = |v: [f64; 2]| SparseVector::from_dense(&v);
        let axis = |j: usize| sparse([((7 * j) % count) as f64, 0.0]);
        let cone = |j: usize| (axis(j), vec![sparse([0.0, 0.5])]);
        carrier.cones = (0..count).map(cone).collect();
        let edges = carrier.steepest_edges(&[1.0, -1.0]);
        let expected: Vec<Vec<f64>> = (5..count).rev().map(|n| vec![n as f64, -0.5]).collect();
        assert_eq!(edges, expected);
    }

    #[test]
    fn corner_of_bounded_shears_is_farthest_in_every_node() {
        let mut carrier = carrier();
        assert_eq!(carrier.corner(&[1.0, 1.0]), [0.0, 0.0]);
        let sparse = |v: [f64; 2]| SparseVector::from_dense(&v);
        let discs = [
            vec![sparse([2.0, 0.0])],
            vec![sparse([0.0, 3.0])],
            vec![sparse([5.0, 0.0]), sparse([0.0, 5.0])],
        ];
        let disc = |radii| Round { radii, bends: None };
        carrier.rounds = discs.into_iter().map(disc).collect();
        // each disc gives its point farthest along (−3, 4)
        assert_eq!(carrier.corner(&[-3.0, 4.0]), [-2.0 - 3.0, 3.0 + 4.0]);
    }

    #[test]
    fn loads_on_many_bodies_are_told_as_on_few() {
        // 120 controlled modes: the interior point method answers. There is no wall behind the last disc
        let discs = 60;
        let mut modes = row_of_discs(discs);
        let (r, m) = (modes.nrows(), modes.ncols() - 2);
        modes.truncate(r, m);
        let set = AdmissibleSet::new(vec![Block::Unilateral; m]);
        let forces: Vec<f64> = (0..m).map(|j| 1.1 + (j as f64).sin()).collect();
        let mut load: Vec<f64> = (0..r)
            .map(|i| (0..m).map(|j| modes[(i, j)] * forces[j]).sum())
            .collect();
        let mut balance = Balance::new(modes.clone(), load.clone());
        assert!(balance.rank() >= MANY);
        let Feasibility::Feasible { load: found } = Feasibility::of(&set, &balance, 0.0) else {
            panic!("these forces carry it");
        };
        assert!((0..r).all(|i| (found[i] - load[i]).abs() < 1e-8));
        // all discs together are pulled off the first wall
        load[3 * (discs - 1)] -= 2.0 * (forces[0] + forces[1]);
        balance.set_load(load.clone());
        let Feasibility::Infeasible { direction, factor } = Feasibility::of(&set, &balance, 0.0)
        else {
            panic!("the wall pushes and does not pull");
        };
        assert_eq!(factor, None);
        assert!(dot(&direction, &load) > 0.1);
        for j in 0..m {
            assert!(dot(modes.col_as_slice(j), &direction) < 1e-8);
        }
    }

    #[test]
    fn columns_of_many_blocks_stand_up_to_the_round_cones_of_their_joints() {
        // 40 blocks without rotations on each other, pushed aside in a direction between the edges of any polygon
        let (blocks, coefficient) = (40, 0.5);
        let modes = Mat::from_fn(3 * blocks, 3 * blocks, |i, j| match (i / 3, j / 3) {
            _ if i % 3 != j % 3 => 0.0,
            (block, joint) if block == joint => -1.0,
            (block, joint) if block + 1 == joint => 1.0,
            _ => 0.0,
        });
        let joint = Friction::Coulomb { coefficient }.block(2);
        let set = AdmissibleSet::new(vec![joint; blocks]);
        let (sin, cos) = 0.3_f64.sin_cos();
        for part in [0.5, 0.95] {
            let push = part * coefficient;
            let load = [-1.0, push * cos, push * sin];
            let load = (0..3 * blocks).map(|i| load[i % 3]).collect();
            let balance = Balance::new(modes.clone(), load);
            assert!(balance.rank() >= MANY);
            let found = Feasibility::of(&set, &balance, 0.0);
            assert!(matches!(found, Feasibility::Feasible { .. }), "{part}");
        }
    }
}
