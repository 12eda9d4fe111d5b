//! Penetration between the nodes: the deformed sides as they are, independent of rows, weights and multipliers.
//!
//! ```text
//!   gap(x) = g₀(x) + n·(u_m(y) − u_s(x)) ≥ −(resolution of the meshes at x)
//! ```
//!
//! Contact conditions hold at nodes or in the mean of functions ψ. Between them the sides may overlap by what the meshes
//! cannot resolve: the dent p(h_s/E_s + h_m/E_m) of a pressure p that varies from node to node, and the curvature of the gap
//! along a facet. Without pressure and curvature an overlap means that a condition was lost.

use crate::contact::{Coupling, InterfaceNode, Moved, Role, Sample};
use crate::geometry::{Point, add_scaled, dot, invert, norm, sub};
use crate::model::system::condition::Condition;
use std::collections::{BTreeMap, BTreeSet};

/// Samples whose scatter in ξ has a smaller determinant lie on a line: reference facets are of size one, their samples far from that.
const ON_A_LINE: f64 = 1e-12;

/// Sides that have sunk into each other by more than this part of their motion were not kept apart.
const SUNK: f64 = 0.5;

/// The place where two sides overlap most beyond what their meshes can resolve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overlap<const D: usize> {
    /// Index of the contact.
    pub contact: usize,
    /// Undeformed position.
    pub point: Point<D>,
    /// Penetration, a length > 0.
    pub depth: f64,
    /// The resolution of the meshes there, a length > 0.
    pub resolved: f64,
}

/// The worst overlap of one contact between its nodes under its forces `lambda`; overlaps up to `negligible` are rounding.
pub(crate) fn worst_overlap<const D: usize>(
    contact: usize,
    condition: &Condition<D>,
    moved: &Moved<'_, D>,
    lambda: &[f64],
    negligible: f64,
) -> Option<Overlap<D>> {
    let mut worst: Option<Overlap<D>> = None;
    let seen = seen(condition, lambda, |sample| sample.at.after(moved));
    let closures = condition.closures(lambda);
    for (samples, (gaps, [pressure, bend])) in condition.touch.samples.iter().zip(seen) {
        let closed = nodes_of(samples).filter_map(|node| closures.get(&node));
        let closed = closed.fold(0.0, |most: f64, closure| most.max(*closure));
        for (sample, gap) in samples.iter().zip(gaps).filter(|(_, gap)| *gap < 0.0) {
            let found = Overlap {
                contact,
                point: sample.point,
                depth: -gap,
                resolved: closed + pressure * sample.dent + bend + negligible,
            };
            if worst.is_none_or(|w| found.depth * w.resolved > w.depth * found.resolved) {
                worst = Some(found);
            }
        }
    }
    worst
}

/// Resolution of the meshes of one contact under its forces `lambda`, at each node of its nonmortar side with an opposite side, a
/// length. `out` gives the distance of points from the obstacle, if there is one: along the normal of an inclined side the gap would
/// curve more than the obstacle does.
pub(crate) fn resolved<const D: usize>(
    condition: &Condition<D>,
    moved: &Moved<'_, D>,
    lambda: &[f64],
    out: impl Fn(Point<D>) -> Option<f64>,
) -> BTreeMap<usize, f64> {
    let gap = |sample: &Sample<D>| {
        let own = sample.at.own.iter();
        let own = own.fold(sample.point, |x, &(j, n)| add_scaled(x, n, moved.own[j]));
        out(sub(own, moved.obstacle)).unwrap_or_else(|| sample.at.after(moved))
    };
    let mut resolved = BTreeMap::new();
    for (samples, (_, [pressure, bend])) in condition
        .touch
        .samples
        .iter()
        .zip(seen(condition, lambda, gap))
    {
        let dent = samples
            .iter()
            .fold(0.0, |s: f64, sample| s.max(sample.dent));
        nodes_of(samples).for_each(|node| raise(&mut resolved, node, pressure * dent + bend));
    }
    resolved
}

/// For each facet the gaps at its samples, by `gap`, and the largest pressure and bend of the gap at its nodes.
fn seen<const D: usize>(
    condition: &Condition<D>,
    lambda: &[f64],
    gap: impl Fn(&Sample<D>) -> f64,
) -> Vec<(Vec<f64>, [f64; 2])> {
    let own = |node: &InterfaceNode<D>| node.rows[0].map(|row| (lambda[row] / node.weight).abs());
    let nodes = condition.interface.nodes.iter();
    let pressures = nodes.filter_map(|n| Some((n.node, own(n)?))).collect();
    let pressure = near(condition, &pressures);
    let gaps = |samples: &Vec<Sample<D>>| samples.iter().map(&gap).collect();
    let facets: Vec<Vec<f64>> = condition.touch.samples.iter().map(gaps).collect();
    let mut bends = BTreeMap::new();
    for (samples, gaps) in condition.touch.samples.iter().zip(&facets) {
        let bend = bend(samples, gaps);
        nodes_of(samples).for_each(|node| raise(&mut bends, node, bend));
    }
    // a condition that is a mean over the facets of a node involves the bend of the gap on all of them
    let bends = near(condition, &bends);
    let most = |samples: &[Sample<D>], of: &BTreeMap<usize, f64>| {
        let values = nodes_of(samples).filter_map(|node| of.get(&node));
        values.fold(0.0, |largest: f64, value| largest.max(*value))
    };
    let facets = condition.touch.samples.iter().zip(facets);
    let facets = facets.map(|(samples, gaps)| {
        let largest = [&pressure, &bends].map(|of| most(samples, of));
        (gaps, largest)
    });
    facets.collect()
}

/// The deepest overlap of one contact at excluded nodes, beyond the bend of its gap along a facet that takes part: undeformed
/// position and depth.
pub(crate) fn left_overlap<const D: usize>(
    condition: &Condition<D>,
    moved: &Moved<'_, D>,
    negligible: f64,
) -> Option<(Point<D>, f64)> {
    if condition.touch.left_out.is_empty() {
        return None;
    }
    let bends = condition.touch.samples.iter();
    let bends = bends.map(|samples| bend(samples, &gaps(samples, moved)));
    let resolved = bends.fold(negligible, |s, bend| s.max(negligible + bend));
    let depths = condition
        .touch
        .left_out
        .iter()
        .zip(gaps(&condition.touch.left_out, moved));
    let depths = depths.map(|(sample, gap)| (sample.point, -gap));
    let deep = depths.filter(|(_, depth)| *depth > resolved);
    deep.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The supported node of the nonmortar side that is deepest in the other side, and its depth; not for ties.
pub(crate) fn held_overlap<const D: usize>(
    condition: &Condition<D>,
    moved: &Moved<'_, D>,
) -> Option<(usize, f64)> {
    // the condition of a twin is that of the node which carries the multiplier of both
    let twins = condition.touch.twins.iter().map(|twin| twin.places[1]);
    let twins: BTreeSet<usize> = twins.collect();
    let nodes = condition.interface.nodes.iter().enumerate();
    let held = nodes.filter(|(place, node)| node.role == Role::Fixed && !twins.contains(place));
    let held = held.filter(|_| condition.interface.coupling != Coupling::Tied);
    let depths = held.filter_map(|(_, node)| Some((node.node, -gap_at(condition, node, moved)?)));
    depths.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The gap of the deformed sides at a node, or at the one place that stands for it, where that is known.
fn gap_at<const D: usize>(
    condition: &Condition<D>,
    node: &InterfaceNode<D>,
    moved: &Moved<'_, D>,
) -> Option<f64> {
    if node.shares.at_node.is_none() {
        let [(place, _)] = node.shares.mean[..] else {
            return None;
        };
        return Some(condition.interface.points[place].after(moved));
    }
    let along = |u: Point<D>| dot(node.normal(), u);
    let opposite = node.opposite.iter();
    let other: f64 = match &moved.other {
        Some(u) => opposite.map(|&(j, n)| n * along(u[j])).sum(),
        None => along(moved.obstacle),
    };
    Some(node.clearance + other - along(moved.own[node.node]))
}

/// The smallest gap of one contact at nodes with an opposite side and between them; `None` where it is not known at a node that
/// `bears` a force.
pub(crate) fn smallest_gap<const D: usize>(
    condition: &Condition<D>,
    moved: &Moved<'_, D>,
    bears: impl Fn(usize) -> bool,
) -> Option<f64> {
    let mut smallest = f64::INFINITY;
    for node in &condition.interface.nodes {
        let Some(row) = node.rows[0] else { continue };
        match gap_at(condition, node, moved) {
            Some(gap) => smallest = smallest.min(gap),
            None if bears(row) => return None,
            None => {}
        }
    }
    let between = condition
        .touch
        .samples
        .iter()
        .flat_map(|samples| gaps(samples, moved));
    Some(between.fold(smallest, f64::min)).filter(|gap| gap.is_finite())
}

/// How deep the sides of one contact have sunk into each other between the nodes, if by more than half of the motion of either side
/// there: initial overlaps and the dents of pressed facets are smaller. A `tip` of a tool, which lies between all samples, is compared
/// with the largest motion.
pub(crate) fn sunk<const D: usize>(
    condition: &Condition<D>,
    moved: &Moved<'_, D>,
    tip: f64,
) -> Option<f64> {
    let motions = moved.own.iter().map(|u| norm(*u));
    let largest = motions.fold(norm(moved.obstacle), f64::max);
    let tip = (tip > SUNK * largest).then_some(tip);
    let motion = |nodes: &[(usize, f64)], u: &[Point<D>]| {
        let sum = nodes
            .iter()
            .fold([0.0; D], |sum, &(j, n)| add_scaled(sum, n, u[j]));
        norm(sum)
    };
    let depths = condition
        .touch
        .samples
        .iter()
        .flatten()
        .filter_map(|sample| {
            let at = &sample.at;
            let own = motion(&at.own, &moved.own);
            let other = match &moved.other {
                Some(u) => motion(&at.opposite, u),
                None => norm(moved.obstacle),
            };
            let depth = at.gap.min(0.0) - at.after(moved);
            (depth > SUNK * own.max(other)).then_some(depth)
        });
    depths.chain(tip).reduce(f64::max)
}

/// The place where the sides of a tie have moved apart most on facets none of whose nodes has a condition, because supports hold them on
/// both sides, and by how much: if more than a small part of the largest motion.
pub(crate) fn untied<const D: usize>(
    condition: &Condition<D>,
    moved: &Moved<'_, D>,
) -> Option<(Point<D>, f64)> {
    let nodes = condition.interface.nodes.iter();
    let bears = nodes.filter(|node| node.rows.iter().any(Option::is_some));
    let bears: BTreeSet<usize> = bears.map(|node| node.node).collect();
    let samples = condition.touch.samples.iter();
    let bare = samples.filter(|samples| nodes_of(samples).all(|node| !bears.contains(&node)));
    let at = |nodes: &[(usize, f64)], u: &[Point<D>]| {
        let sum = nodes.iter();
        sum.fold([0.0; D], |sum, &(j, n)| add_scaled(sum, n, u[j]))
    };
    let motions = |samples: &Sample<D>| {
        let other = match &moved.other {
            Some(u) => at(&samples.at.opposite, u),
            None => moved.obstacle,
        };
        [at(&samples.at.own, &moved.own), other]
    };
    let all = condition.touch.samples.iter().flatten();
    let largest = all.flat_map(motions).map(norm).fold(0.0, f64::max);
    let jumps = bare.flatten().map(|sample| {
        let [own, other] = motions(sample);
        (sample.point, norm(sub(own, other)))
    });
    let most = jumps.max_by(|a, b| a.1.total_cmp(&b.1));
    most.filter(|(_, jump)| *jump > UNTIED * largest)
}

/// Sides of a tie that have moved apart by a smaller part of their motion are as good as tied.
const UNTIED: f64 = 1e-3;

fn gaps<const D: usize>(samples: &[Sample<D>], moved: &Moved<'_, D>) -> Vec<f64> {
    samples
        .iter()
        .map(|sample| sample.at.after(moved))
        .collect()
}

/// Largest distance of some values on a facet from linear functions, one for each smooth surface opposite: each has conditions of its own,
/// and neither a step between two of them nor a kink is a curve that the mesh cannot resolve.
fn bend<const D: usize>(samples: &[Sample<D>], values: &[f64]) -> f64 {
    let mut surfaces: BTreeMap<usize, (Vec<[f64; 2]>, Vec<f64>)> = BTreeMap::new();
    for (sample, value) in samples.iter().zip(values) {
        let (places, values) = surfaces.entry(sample.surface).or_default();
        places.push(sample.xi);
        values.push(*value);
    }
    let bends = surfaces.values().map(|(places, values)| match D {
        2 => bend_of_line(places, values),
        _ => bend_of_surface(places, values),
    });
    bends.fold(0.0, f64::max)
}

/// Largest distance of some values along a facet from the straight line between the first and the last.
fn bend_of_line(places: &[[f64; 2]], values: &[f64]) -> f64 {
    let ([first, .., last], [start, .., end]) = (values, places) else {
        return 0.0;
    };
    let off = |(place, value): (&[f64; 2], &f64)| {
        let t = (place[0] - start[0]) / (end[0] - start[0]);
        (value - first - t * (last - first)).abs()
    };
    places.iter().zip(values).map(off).fold(0.0, f64::max)
}

/// Largest distance of some values from the linear function of ξ that fits them best.
fn bend_of_surface(places: &[[f64; 2]], values: &[f64]) -> f64 {
    let mean = |of: &dyn Fn(usize) -> f64| {
        let sum: f64 = (0..values.len()).map(of).sum();
        sum / values.len() as f64
    };
    let middle = [0, 1].map(|d| mean(&|k| places[k][d]));
    let level = mean(&|k| values[k]);
    let from_middle = |k: usize| [0, 1].map(|d| places[k][d] - middle[d]);
    let moment = |i: usize, j: usize| mean(&|k| from_middle(k)[i] * from_middle(k)[j]);
    let load = [0, 1].map(|d| mean(&|k| from_middle(k)[d] * (values[k] - level)));
    let scatter = [[moment(0, 0), moment(0, 1)], [moment(1, 0), moment(1, 1)]];
    let (inverse, det) = invert(&scatter);
    let spread = scatter[0][0] + scatter[1][1];
    // fewer than three points fit any plane
    if values.len() < 3 || spread <= ON_A_LINE {
        return 0.0;
    }
    let slope = match det > ON_A_LINE {
        true => inverse.map(|row| dot(row, load)),
        // points on a line: both moments lie along it
        false => load.map(|load| load / spread),
    };
    let off = (0..values.len()).map(|k| (values[k] - level - dot(slope, from_middle(k))).abs());
    off.fold(0.0, f64::max)
}

/// Nodes of the facet of some samples.
fn nodes_of<const D: usize>(samples: &[Sample<D>]) -> impl Iterator<Item = usize> {
    let nodes = samples
        .first()
        .into_iter()
        .flat_map(|sample| &sample.at.own);
    nodes.map(|(node, _)| *node)
}

fn raise(values: &mut BTreeMap<usize, f64>, node: usize, value: f64) {
    let at = values.entry(node).or_insert(0.0);
    *at = at.max(value);
}

/// The largest of some nonnegative values at each node of the side or at a node that shares a facet with it.
fn near<const D: usize>(
    condition: &Condition<D>,
    values: &BTreeMap<usize, f64>,
) -> BTreeMap<usize, f64> {
    let mut near = values.clone();
    for samples in &condition.touch.samples {
        let at = nodes_of(samples).filter_map(|node| values.get(&node));
        let largest = at.fold(0.0, |s: f64, value| s.max(*value));
        nodes_of(samples).for_each(|node| raise(&mut near, node, largest));
    }
    near
}
