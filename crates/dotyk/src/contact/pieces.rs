//! Cuts of the facets of a plane side, so that on each piece all shape functions of both sides are smooth.
//!
//! A facet consists of cells between neighbouring nodes; a cell is cut where the line along the contact normal meets an end
//! node of the other side's facets. Parts without an opposite are left out.

use crate::contact::Against;
use crate::contact::functions::{Cell, Piece};
use crate::contact::opposite::Opposite;
use crate::contact::search::Line;
use crate::fem::quadrature::gauss;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Gauss points on each piece: exact for straight sides, beyond rounding for curved ones.
const POINTS: usize = 6;

/// The pieces of all cells with an opposite, in their order.
pub(super) fn pieces(sides: &Opposite<'_, 2>, cells: &[Cell]) -> Vec<Piece> {
    let rule = gauss(POINTS);
    let each = cells.par_iter().enumerate();
    each.flat_map_iter(|(index, cell)| cut(sides, &rule, index, cell))
        .collect()
}

/// Cuts a cell where its lines meet nodes of the other side; keeps the parts with an opposite.
fn cut(sides: &Opposite<'_, 2>, rule: &[(f64, f64)], index: usize, cell: &Cell) -> Vec<Piece> {
    let mut cuts: Vec<f64> = cell.places.iter().map(|place| place[0]).collect();
    cuts.extend(places(sides, cell));
    cuts.sort_by(f64::total_cmp);
    let parts = cuts.windows(2).filter(|ends| ends[1] - ends[0] > 1e-12);
    let piece = |ends: &[f64]| {
        let middle = sides.line(cell.facet, &[0.5 * (ends[0] + ends[1])]);
        let opposite = match sides.against {
            Against::Side(_) => Some(sides.facing(cell.facet, middle)?.facet),
            Against::Obstacle(rigid, _) => {
                let places = [ends[0], ends[1]].map(|xi| sides.line(cell.facet, &[xi]));
                let faces = |line: &Line<2>| rigid.faces(line.start, line.direction);
                if !places.iter().chain([&middle]).all(faces) {
                    return None;
                }
                None
            }
        };
        let half = 0.5 * (ends[1] - ends[0]);
        let centre = 0.5 * (ends[1] + ends[0]);
        let points = rule.iter();
        Some(Piece {
            cell: index,
            opposite,
            corners: vec![[ends[0], 0.0], [ends[1], 0.0]],
            part: half,
            points: points
                .map(|&(x, weight)| ([centre + half * x, 0.0], half * weight))
                .collect(),
        })
    };
    parts.filter_map(piece).collect()
}

/// Where the lines of a cell meet end nodes of the other side's facets.
fn places(sides: &Opposite<'_, 2>, cell: &Cell) -> Vec<f64> {
    let (Some(search), Against::Side(mortar)) = (&sides.search, sides.against) else {
        return Vec::new();
    };
    let [from, to] = [cell.places[0][0], cell.places[1][0]];
    let line = |xi: f64| sides.line(cell.facet, &[xi]);
    let middle = line(0.5 * (from + to));
    let other = &mortar.body.mesh;
    let halves = [[line(from), middle], [middle, line(to)]];
    let near = halves.into_iter().flat_map(|lines| search.between(lines));
    let corners = near.flat_map(|facet| other.facet_nodes(facet).take(2));
    let nodes: BTreeSet<u32> = corners.collect();
    let points = nodes.iter().map(|&node| other.points()[node as usize]);
    points
        .filter_map(|y| root([from, to], |xi| line(xi).across(y)))
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::functions::cells;
    use crate::contact::gaps::tests::{end, flat, noise, wall};
    use crate::contact::obstacle::{Driven, Rigid};
    use crate::contact::{End, InitialGap};
    use crate::fem::{Body, Constraints};
    use crate::geometry::{Point, Surface};
    use crate::mesh::CellKind;

    #[test]
    fn the_root_of_a_function_is_found_to_rounding() {
        let cubic = |x: f64| x * x * x - 0.3;
        // monotone and very uneven: steps along chords alone would creep
        let steep = |x: f64| (20.0 * x).exp() - 2.0;
        for (ends, expected) in [([-1.0, 1.0], 0.3f64.cbrt()), ([1.0, 0.0], 0.3f64.cbrt())] {
            assert!((root(ends, cubic).unwrap() - expected).abs() < 1e-14);
        }
        let expected = 2f64.ln() / 20.0;
        assert!((root([-1.0, 1.0], steep).unwrap() - expected).abs() < 1e-14);
        // exact at the first step
        assert_eq!(root([-1.0, 3.0], |x| 2.0 * x - 1.0), Some(0.5));
    }

    #[test]
    fn a_function_without_a_change_of_sign_between_its_ends_has_no_root() {
        assert_eq!(root([-1.0, 1.0], |x| x * x), None);
        assert_eq!(root([-1.0, 1.0], |x| 0.1 * x - 0.2), None);
        // at an end: nothing is cut there
        assert_eq!(root([0.0, 1.0], |x| x), None);
        assert_eq!(root([0.0, 1.0], |x| x - 1.0), None);
        assert_eq!(root([-1.0, 1.0], |x| 1.0 / (x + 1.0) - 2.0), None);
        assert_eq!(root([-1.0, 1.0], |_| f64::NAN), None);
    }

    /// The pieces of the side "bottom" of a body against an opposite, with their cells.
    fn all_pieces<'a>(
        body: &'a Body<2>,
        free: &'a Constraints<2>,
        against: Against<'a, 2>,
    ) -> (Opposite<'a, 2>, Vec<Cell>, Vec<Piece>) {
        let nonmortar = end(body, "bottom", free);
        let sides = Opposite::new(nonmortar, against, InitialGap::Measured, 0.0).unwrap();
        let facets = body.mesh.side("bottom").unwrap();
        let all = facets.iter().flat_map(|&facet| cells(&body.mesh, facet));
        let all: Vec<Cell> = all.collect();
        let pieces = pieces(&sides, &all);
        (sides, all, pieces)
    }

    /// Where a piece begins and ends, along x.
    fn range(body: &Body<2>, cells: &[Cell], piece: &Piece) -> [f64; 2] {
        let facet = cells[piece.cell].facet;
        [0, 1].map(|k| body.mesh.facet_point(facet, &piece.corners[k])[0])
    }

    #[test]
    fn facets_are_cut_opposite_the_ends_of_facets() {
        let own = [0.0, 1.0, 1.7, 3.0, 4.0];
        let other = [0.5, 1.2, 2.0, 2.7, 3.5];
        let linear = [0.5, 1.0, 1.2, 1.7, 2.0, 2.7, 3.0, 3.5];
        let quadratic = [0.5, 1.0, 1.7, 2.0, 3.0, 3.5];
        let free = Constraints::default();
        for cell in [CellKind::Quad4, CellKind::Quad8] {
            let upper = flat(&own, 1.0, cell);
            for (cell, cuts) in [
                (CellKind::Quad4, &linear[..]),
                (CellKind::Quad8, &quadratic[..]),
            ] {
                // the body below: its facets run from right to left
                let lower = flat(&other, -1.0, cell);
                let against = Against::Side(end(&lower, "bottom", &free));
                let (_, cells, pieces) = all_pieces(&upper, &free, against);
                assert_eq!(pieces.len(), cuts.len() - 1);
                for (piece, expected) in pieces.iter().zip(cuts.windows(2)) {
                    let range = range(&upper, &cells, piece);
                    for (found, expected) in range.into_iter().zip(expected) {
                        assert!((found - expected).abs() < 1e-13, "{range:?}");
                    }
                    let middle = 0.5 * (range[0] + range[1]);
                    let ends = lower.mesh.facet_points(piece.opposite.unwrap());
                    let ends: Vec<f64> = ends.map(|x| x[0]).collect();
                    assert!(ends[1] < middle && middle < ends[0], "{ends:?}");
                }
            }
        }
    }

    #[test]
    fn every_piece_lies_opposite_one_facet_whatever_the_places_of_the_nodes() {
        let free = Constraints::default();
        let mut noise = noise();
        for _ in 0..40 {
            let mut places = || -> Vec<f64> {
                let mut at = 0.3 * noise();
                let mut step = |_| {
                    at += 0.02 + noise().powi(4);
                    at
                };
                (0..9).map(&mut step).collect()
            };
            let (own, other) = (places(), places());
            let upper = flat(&own, 1.0, CellKind::Quad4);
            let lower = flat(&other, -1.0, CellKind::Quad4);
            let against = Against::Side(end(&lower, "bottom", &free));
            let (_, cells, pieces) = all_pieces(&upper, &free, against);
            let (from, to) = (own[0].max(other[0]), own[8].min(other[8]));
            let nodes = own.iter().chain(&other);
            let inside = nodes.filter(|&&x| from < x && x < to).count();
            assert_eq!(pieces.len(), inside + 1);
            for piece in &pieces {
                let [from, to] = range(&upper, &cells, piece);
                let ends = lower.mesh.facet_points(piece.opposite.unwrap());
                let ends: Vec<f64> = ends.map(|x| x[0]).collect();
                assert!(ends[1] < from + 1e-12 && to < ends[0] + 1e-12, "{ends:?}");
            }
        }
    }

    #[test]
    fn lines_from_the_ends_of_pieces_meet_nodes_of_curved_sides_that_do_not_match() {
        let arc = |count: usize, from: f64, to: f64| -> Vec<Point<2>> {
            let place = |k: usize| from + (to - from) * k as f64 / (count - 1) as f64;
            (0..count)
                .map(|k| [place(k), 0.12 * place(k) * place(k)])
                .collect()
        };
        let free = Constraints::default();
        let upper = wall(&arc(7, -2.0, 2.0), 3.0, CellKind::Quad8);
        let below = arc(10, -2.5, 2.5).into_iter().map(|[x, y]| [x, y - 0.2]);
        let below: Vec<Point<2>> = below.collect();
        let lower = wall(&below, -2.0, CellKind::Quad4);
        let against = Against::Side(end(&lower, "bottom", &free));
        let (sides, cells, pieces) = all_pieces(&upper, &free, against);
        let nodes = lower.mesh.side_nodes("bottom").unwrap();
        let mut cuts = 0;
        for pair in pieces.windows(2) {
            let [before, after] = [&pair[0], &pair[1]];
            if before.cell != after.cell {
                continue;
            }
            assert_eq!(before.corners[1], after.corners[0]);
            let line = sides.line(cells[before.cell].facet, &before.corners[1]);
            let off = nodes.iter().map(|&node| {
                let place = lower.mesh.points()[node as usize];
                line.across(place).abs()
            });
            // the root is good to rounding
            assert!(off.fold(f64::INFINITY, f64::min) < 1e-14);
            cuts += 1;
        }
        // all but the ends of the longer side lie opposite
        let over = |node: &&u32| lower.mesh.points()[**node as usize][0].abs() < 1.99;
        assert_eq!(cuts, nodes.iter().filter(over).count());
        let length: f64 = pieces
            .iter()
            .map(|p| p.corners[1][0] - p.corners[0][0])
            .sum();
        assert!((length - 6.0).abs() < 1e-13);
    }

    #[test]
    fn cells_are_kept_whose_ends_face_the_obstacle() {
        let free = Constraints::default();
        let places: Vec<f64> = (0..9).map(|k| 0.5 * f64::from(k)).collect();
        let body = flat(&places, 1.0, CellKind::Quad4);
        let ball = Rigid::Surface {
            surface: Surface::Sphere {
                center: [2.0, -1.5],
                radius: 0.9,
            },
            inside: false,
        };
        let against = Against::Obstacle(&ball, Driven::Still);
        let (_, cells, pieces) = all_pieces(&body, &free, against);
        let ranges: Vec<[f64; 2]> = pieces.iter().map(|p| range(&body, &cells, p)).collect();
        assert_eq!(ranges, [[1.5, 2.0], [2.0, 2.5]]);
        assert!(pieces.iter().all(|piece| piece.opposite.is_none()));
    }

    #[test]
    fn the_part_of_a_side_is_cut_alone() {
        let free = Constraints::default();
        let upper = flat(&[0.0, 1.0, 2.0], 1.0, CellKind::Quad4);
        let lower = flat(&[0.0, 2.0], -1.0, CellKind::Quad4);
        let part = &lower.mesh.side("bottom").unwrap()[..1];
        let mortar = End {
            part: Some(part),
            ..end(&lower, "nowhere", &free)
        };
        let (_, _, pieces) = all_pieces(&upper, &free, Against::Side(mortar));
        assert_eq!(pieces.len(), 2);
        assert!(pieces.iter().all(|piece| piece.opposite == Some(part[0])));
    }
}
