//! Which of two sides carries the multipliers.

use crate::contact::{ContactError, End, Interface, is_pointed, straight_turn};
use crate::fem::node_normals;
use crate::geometry::dot;
use std::collections::BTreeMap;

/// Bodies whose stiffness differs by more than this factor, ten but for rounding, are soft and stiff; within it the finer
/// side carries the multipliers, unless it would show the facets of the other.
const SOFTER: f64 = 10.0 * (1.0 + 1e-9);

/// The displacement of straight facets of length H has kinks. The pressures of a finer side with facets of length h oscillate there
/// in proportion to its relative stiffness times ln(H/h), by a few per cent where this product exceeds the following.
const SHOWS: f64 = 1.6;

/// Around a curve, where they turn by θ, the pressures of the finer side oscillate by about this times θ ln(H/h) (measured
/// on rings, 16 to 40 facets on a quarter of the circle, h = H/5 to H/2), times its relative stiffness if above 1.
const KINKS: f64 = 0.19;

/// Largest oscillation that is allowed, relative to the mean pressure.
const VISIBLE: f64 = 0.02;

/// Sides whose edges differ by less than this factor are equally fine.
const ALIKE: f64 = 1.05;

/// Sides whose edges differ by less than this factor differ by rounding: of these the one named first is chosen, however the model is
/// oriented.
const EVEN_EDGES: f64 = 1.0 + 1e-9;

/// A corner falls between the nodes of a flat side unless the edges there are shorter than this part of its own.
const BETWEEN_NODES: f64 = 0.5;

/// Index of the side that carries the multipliers: one that meets a flat side by its corners alone; that of the more compliant body; within a factor 10 the finer one, unless
/// that would show the straight facets of the other. A side held completely by supports cannot carry them.
pub(crate) fn chosen<const D: usize>(ends: [End<'_, D>; 2]) -> Result<usize, ContactError> {
    let stiff = ends.map(stiffness);
    let held = [held(ends[0])?, held(ends[1])?];
    let edge = [mean_edge(ends[0])?, mean_edge(ends[1])?];
    let (fine, coarse) = if edge[0] <= EVEN_EDGES * edge[1] {
        (0, 1)
    } else {
        (1, 0)
    };
    if held[0] != held[1] {
        return Ok(usize::from(held[0]));
    }
    // between the nodes of the other side a corner has no condition
    let pointed = [is_pointed(ends[0], ends[1])?, is_pointed(ends[1], ends[0])?];
    if let Some(corner) = pointed.iter().position(|&pointed| pointed)
        && edge[1 - corner] > BETWEEN_NODES * edge[corner]
    {
        return Ok(corner);
    }
    if stiff[0].max(stiff[1]) > SOFTER * stiff[0].min(stiff[1]) {
        return Ok(usize::from(stiff[1] < stiff[0]));
    }
    if edge[coarse] < ALIKE * edge[fine] {
        return Ok(fine);
    }
    let shown = shows_kinks(
        ends[coarse],
        stiff[fine] / stiff[coarse],
        edge[coarse] / edge[fine],
    )?;
    Ok(if shown { coarse } else { fine })
}

/// Whether pressures on a side that is stiffer and finer by these factors show the kinks between the straight facets of the other.
fn shows_kinks<const D: usize>(
    coarse: End<'_, D>,
    stiffer: f64,
    finer: f64,
) -> Result<bool, ContactError> {
    let answer = finer.ln();
    let shown =
        |turn: f64| stiffer * answer > SHOWS || KINKS * turn * answer * stiffer.max(1.0) > VISIBLE;
    Ok(straight_turn(coarse)?.is_some_and(shown))
}

/// Either of two sides may carry the multipliers if their edges differ by at most this factor.
const AS_FINE: f64 = 1.5;

/// Whether either of two sides may carry the multipliers: neither is much softer, much coarser, or held.
pub(crate) fn either_may<const D: usize>(ends: [End<'_, D>; 2]) -> Result<bool, ContactError> {
    let stiff = ends.map(stiffness);
    let edge = [mean_edge(ends[0])?, mean_edge(ends[1])?];
    let alike = |of: [f64; 2], factor: f64| of[0].max(of[1]) <= factor * of[0].min(of[1]);
    Ok(!held(ends[0])? && !held(ends[1])? && alike(stiff, SOFTER) && alike(edge, AS_FINE))
}

/// Whether the nonmortar side, the first, is finer than a mortar side of much softer material, or than one whose kinks it shows. Only
/// the facets that face each other count.
pub(crate) fn finer_than_softer<const D: usize>(
    [nonmortar, mortar]: [End<'_, D>; 2],
    interface: &Interface<D>,
) -> Result<bool, ContactError> {
    let [own, other] = [edges_at(nonmortar)?, edges_at(mortar)?];
    let mut sums = [0.0; 2];
    for node in &interface.nodes {
        let nearest = node.opposite.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((opposite, _)) = nearest {
            sums[0] += own[&node.node];
            sums[1] += other[opposite];
        }
    }
    let stiffer = stiffness(nonmortar) / stiffness(mortar);
    Ok(sums[0] < 0.99 * sums[1]
        && (stiffer > SOFTER || shows_kinks(mortar, stiffer, sums[1] / sums[0])?))
}

/// Mean distance of neighbouring nodes on the facets around each node.
fn edges_at<const D: usize>(end: End<'_, D>) -> Result<BTreeMap<usize, f64>, ContactError> {
    let mesh = &end.body.mesh;
    let mut sums: BTreeMap<usize, (usize, f64)> = BTreeMap::new();
    for &facet in end.facets()? {
        let (count, length) = (mesh.facet_kind(facet).order(), mesh.facet_length(facet));
        for node in mesh.facet_nodes(facet) {
            let sum = sums.entry(node as usize).or_default();
            *sum = (sum.0 + count, sum.1 + length);
        }
    }
    let means = sums.into_iter();
    Ok(means
        .map(|(node, (count, total))| (node, total / count as f64))
        .collect())
}

/// Smallest plane modulus E/(1 − ν²) of the cells at a side: its stiffness against pressures that alternate from node to node.
fn stiffness<const D: usize>(end: End<'_, D>) -> f64 {
    let facets = end.body.mesh.side(end.side).unwrap_or_default().iter();
    let blocks = facets.map(|facet| &end.body.mesh.blocks()[facet.block as usize]);
    let materials = blocks.filter_map(|block| end.body.material(block).ok());
    let moduli = materials.map(|m| m.lasting().plane_modulus());
    moduli.fold(f64::INFINITY, f64::min)
}

/// A support holds the normal if the square of the free part of the unit normal is below this: normals of straight sides are exact to
/// rounding.
const SAME_DIRECTION: f64 = 1e-12;

/// Supports hold the normal displacement of every node of the side.
fn held<const D: usize>(end: End<'_, D>) -> Result<bool, ContactError> {
    // the side is there
    end.facets()?;
    let normals = node_normals(end.body, end.side).unwrap_or_default();
    Ok(normals.iter().all(|(&node, &normal)| {
        let held = end.constraints.at(node).iter();
        let rest: f64 = 1.0 - held.map(|h| dot(h.axis, normal).powi(2)).sum::<f64>();
        rest < SAME_DIRECTION
    }))
}

/// Mean distance of neighbouring nodes: a quadratic facet counts as two.
fn mean_edge<const D: usize>(end: End<'_, D>) -> Result<f64, ContactError> {
    let mesh = &end.body.mesh;
    let facets = end.facets()?.iter();
    let edges = facets.map(|&facet| (mesh.facet_kind(facet).order(), mesh.facet_length(facet)));
    let (count, total) = edges.fold((0, 0.0), |(n, sum), (order, length)| {
        (n + order, sum + length)
    });
    Ok(total / count as f64)
}
