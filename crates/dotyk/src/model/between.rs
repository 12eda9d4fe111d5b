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
    let pressure = pressure_near(pair, lambda);
    let mut worst: Option<Overlap<D>> = None;
    for samples in &pair.samples {
        let gaps: Vec<f64> = samples.iter().map(|sample| gap(sample, moved)).collect();
        let bend = bend(&gaps);
        for (sample, gap) in samples.iter().zip(gaps).filter(|(_, gap)| *gap < 0.0) {
            let nodes = sample.own.iter().filter_map(|(node, _)| pressure.get(node));
            let pressure = nodes.fold(0.0, |largest: f64, p| largest.max(*p));
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

/// Largest |pressure| at each node of the side or at a node that shares a facet with it.
fn pressure_near<const D: usize>(pair: &Paired<D>, lambda: &[f64]) -> BTreeMap<usize, f64> {
    let own = |node: &InterfaceNode<D>| node.rows[0].map(|row| (lambda[row] / node.weight).abs());
    let nodes = pair.interface.nodes.iter();
    let at: BTreeMap<usize, f64> = nodes.filter_map(|n| Some((n.node, own(n)?))).collect();
    let mut near = at.clone();
    for sample in pair.samples.iter().filter_map(|samples| samples.first()) {
        let nodes = || sample.own.iter().map(|(node, _)| node);
        let largest = nodes()
            .filter_map(|node| at.get(node))
            .fold(0.0, |s: f64, p| s.max(*p));
        for &node in nodes() {
            let near = near.entry(node).or_insert(0.0);
            *near = near.max(largest);
        }
    }
    near
}
