//! Penetration between the nodes: the deformed sides as they are, independent of rows, weights and multipliers.
//!
//! ```text
//!   gap(x) = g₀(x) + n·(u_m(y) − u_s(x)) ≥ −(what the meshes can resolve at x)
//! ```
//!
//! Contact conditions hold at nodes or in the mean of functions ψ. Between them the sides may overlap by what the meshes
//! cannot resolve: the dent p(h_s/E_s + h_m/E_m) of a pressure p that varies from node to node, and how much the gap itself
//! curves along a facet. Where nothing presses and nothing curves there is no excuse: a condition was lost.

use crate::contact::{InterfaceNode, Sample};
use crate::geometry::{Point, dot};
use crate::model::pair::Paired;
use std::collections::BTreeMap;

/// The place where two sides overlap most beyond what their meshes can resolve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overlap<const D: usize> {
    /// Index of the contact.
    pub contact: usize,
    /// Undeformed position.
    pub point: Point<D>,
    /// Penetration, a length > 0.
    pub depth: f64,
    /// What the meshes can resolve there, a length > 0.
    pub resolved: f64,
}

/// Displacements that a contact sees.
pub(crate) struct Moved<'a, const D: usize> {
    /// Nodal displacements of the nonmortar body.
    pub own: &'a [Point<D>],
    /// Those of the mortar body; `None` against an obstacle.
    pub other: Option<&'a [Point<D>]>,
    /// Displacement of the obstacle.
    pub obstacle: Point<D>,
}

/// The worst overlap of one contact between its nodes under its forces `lambda`; overlaps up to `negligible` are rounding.
pub(crate) fn worst_overlap<const D: usize>(
    contact: usize,
    pair: &Paired<D>,
    moved: &Moved<'_, D>,
    lambda: &[f64],
    negligible: f64,
) -> Option<Overlap<D>> {
    let own = |node: &InterfaceNode<D>| node.rows[0].map(|row| (lambda[row] / node.weight).abs());
    let nodes = pair.interface.nodes.iter();
    let pressures = nodes.filter_map(|n| Some((n.node, own(n)?))).collect();
    let pressure = near(pair, &pressures);
    let facets = pair.samples.iter().map(|samples| {
        let gaps = samples.iter().map(|sample| gap(sample, moved));
        gaps.collect::<Vec<f64>>()
    });
    let facets: Vec<Vec<f64>> = facets.collect();
    let mut bends = BTreeMap::new();
    for (samples, gaps) in pair.samples.iter().zip(&facets) {
        let bend = bend(gaps);
        nodes_of(samples).for_each(|node| raise(&mut bends, node, bend));
    }
    // a condition that is a mean over the facets of a node sees how the gap bends on all of them
    let bends = near(pair, &bends);
    let mut worst: Option<Overlap<D>> = None;
    for (samples, gaps) in pair.samples.iter().zip(facets) {
        let largest = |of: &BTreeMap<usize, f64>| {
            let values = nodes_of(samples).filter_map(|node| of.get(&node));
            values.fold(0.0, |largest: f64, value| largest.max(*value))
        };
        let (pressure, bend) = (largest(&pressure), largest(&bends));
        for (sample, gap) in samples.iter().zip(gaps).filter(|(_, gap)| *gap < 0.0) {
            let found = Overlap {
                contact,
                point: sample.point,
                depth: -gap,
                resolved: pressure * sample.dent + bend + negligible,
            };
            if worst.is_none_or(|w| found.depth * w.resolved > w.depth * found.resolved) {
                worst = Some(found);
            }
        }
    }
    worst
}

fn gap<const D: usize>(sample: &Sample<D>, moved: &Moved<'_, D>) -> f64 {
    let at = |nodes: &[(usize, f64)], u: &[Point<D>]| {
        let along = nodes.iter().map(|&(j, n)| n * dot(sample.normal, u[j]));
        along.sum::<f64>()
    };
    let other = match moved.other {
        Some(u) => at(&sample.opposite, u),
        None => dot(sample.normal, moved.obstacle),
    };
    sample.gap + (other - at(&sample.own, moved.own))
}

/// Largest distance of some values along a facet from the straight line between the first and the last.
fn bend(values: &[f64]) -> f64 {
    let ([first, .., last], steps) = (values, values.len().saturating_sub(1)) else {
        return 0.0;
    };
    let off = |(k, value): (usize, &f64)| {
        let t = k as f64 / steps as f64;
        (value - first - t * (last - first)).abs()
    };
    values.iter().enumerate().map(off).fold(0.0, f64::max)
}

/// Nodes of the facet of some samples.
fn nodes_of<const D: usize>(samples: &[Sample<D>]) -> impl Iterator<Item = usize> {
    let nodes = samples.first().into_iter().flat_map(|sample| &sample.own);
    nodes.map(|(node, _)| *node)
}

fn raise(values: &mut BTreeMap<usize, f64>, node: usize, value: f64) {
    let at = values.entry(node).or_insert(0.0);
    *at = at.max(value);
}

/// The largest of some nonnegative values at each node of the side or at a node that shares a facet with it.
fn near<const D: usize>(pair: &Paired<D>, values: &BTreeMap<usize, f64>) -> BTreeMap<usize, f64> {
    let mut near = values.clone();
    for samples in &pair.samples {
        let at = nodes_of(samples).filter_map(|node| values.get(&node));
        let largest = at.fold(0.0, |s: f64, value| s.max(*value));
        nodes_of(samples).for_each(|node| raise(&mut near, node, largest));
    }
    near
}
