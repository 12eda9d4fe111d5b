//! Where the facets of a plane side are cut, so that on each piece all shape functions of both sides are smooth.
//!
//! A facet consists of spans between neighbouring nodes; a span is cut where the line along the contact normal meets an end
//! node of the other side's facets. What faces nothing is left out.

use crate::contact::Against;
use crate::contact::opposite::Opposite;
use crate::contact::search::Line;
use crate::mesh::{Facet, Mesh};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Part of a facet between two neighbouring nodes.
pub(super) struct Span {
    pub facet: Facet,
    /// Reference coordinates of its ends.
    pub ends: [f64; 2],
    pub nodes: [usize; 2],
}

/// Part of a span that faces one facet of the other side (or the obstacle).
pub(super) struct Piece {
    pub span: usize,
    pub ends: [f64; 2],
    pub opposite: Option<Facet>,
}

/// The pieces of all spans that face something, in their order.
pub(super) fn pieces(sides: &Opposite<'_, 2>, spans: &[Span]) -> Vec<Piece> {
    let each = spans.par_iter().enumerate();
    each.flat_map_iter(|(index, span)| cut(sides, index, span))
        .collect()
}

/// Cuts a span where its lines meet nodes of the other side; keeps the parts that face something.
fn cut(sides: &Opposite<'_, 2>, index: usize, span: &Span) -> Vec<Piece> {
    let [from, to] = span.ends;
    let mut cuts = vec![from, to];
    cuts.extend(places(sides, span));
    cuts.sort_by(f64::total_cmp);
    let parts = cuts.windows(2).filter(|ends| ends[1] - ends[0] > 1e-12);
    let piece = |ends: &[f64]| {
        let middle = sides.line(span.facet, &[0.5 * (ends[0] + ends[1])]);
        let opposite = match sides.against {
            Against::Side(_) => Some(sides.facing(span.facet, middle)?.facet),
            Against::Obstacle(rigid, _) => {
                let places = [ends[0], ends[1]].map(|xi| sides.line(span.facet, &[xi]));
                let faces = |line: &Line<2>| rigid.faces(line.start, line.direction);
                if !places.iter().chain([&middle]).all(faces) {
                    return None;
                }
                None
            }
        };
        Some(Piece {
            span: index,
            ends: [ends[0], ends[1]],
            opposite,
        })
    };
    parts.filter_map(piece).collect()
}

/// Where the lines of a span meet end nodes of the other side's facets.
fn places(sides: &Opposite<'_, 2>, span: &Span) -> Vec<f64> {
    let (Some(search), Against::Side(mortar)) = (&sides.search, sides.against) else {
        return Vec::new();
    };
    let [from, to] = span.ends;
    let line = |xi: f64| sides.line(span.facet, &[xi]);
    let middle = line(0.5 * (from + to));
    let other = &mortar.body.mesh;
    let halves = [[line(from), middle], [middle, line(to)]];
    let near = halves.into_iter().flat_map(|lines| search.between(lines));
    let corners = near.flat_map(|facet| other.facet_nodes(facet).take(2));
    let nodes: BTreeSet<u32> = corners.collect();
    let points = nodes.iter().map(|&node| other.points()[node as usize]);
    points
        .filter_map(|y| root(span.ends, |xi| line(xi).across(y)))
        .collect()
}

/// The parts of a facet between its nodes, in its own direction.
pub(super) fn spans(mesh: &Mesh<2>, facet: Facet) -> Vec<Span> {
    let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|node| node as usize).collect();
    let span = |ends, nodes| Span { facet, ends, nodes };
    match nodes[..] {
        [a, b, middle] => vec![
            span([-1.0, 0.0], [a, middle]),
            span([0.0, 1.0], [middle, b]),
        ],
        [a, b, ..] => vec![span([-1.0, 1.0], [a, b])],
        _ => Vec::new(),
    }
}

/// The zero of a function that changes its sign between two ends, by the Illinois method.
fn root(ends: [f64; 2], f: impl Fn(f64) -> f64) -> Option<f64> {
    let [mut a, mut b] = ends;
    let (mut fa, mut fb) = (f(a), f(b));
    if fa * fb >= 0.0 || !(fa * fb).is_finite() {
        return None;
    }
    let mut last = f64::NAN;
    for _ in 0..100 {
        let x = (a * fb - b * fa) / (fb - fa);
        let fx = f(x);
        if fx == 0.0 || (x - last).abs() < 1e-15 {
            return Some(x);
        }
        last = x;
        if (fx < 0.0) == (fb < 0.0) {
            // the other end stays: halve its value, so that the next step does not creep
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (x, fx);
    }
    Some(last)
}
