//! Which nodes of a surface lie within a distance of another one.
//!
//! Faces are cut into triangles at their corners and middle nodes, in the plane into straight lines. The distance is that to the
//! nearest point of them. A grid with cells as large as the largest face finds the faces near a node.

use crate::deck::{Deck, Face, Index};
use std::collections::HashMap;

type Point = [f64; 3];

/// The nodes that are farther than `reach` from all faces.
pub(crate) fn beyond(deck: &Deck, nodes: &[Index], faces: &[Face], reach: f64) -> Vec<Index> {
    let pieces: Vec<[Point; 3]> = faces.iter().flat_map(|face| pieces(deck, *face)).collect();
    let boxes: Vec<[Point; 2]> = pieces.iter().map(|piece| bounds(piece, reach)).collect();
    let widths = boxes
        .iter()
        .flat_map(|[low, high]| (0..3).map(move |d| high[d] - low[d]));
    let size = widths.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let cell = |p: Point| p.map(|x| (x / size).floor() as i64);
    let mut grid: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (index, [low, high]) in boxes.iter().enumerate() {
        let ([a, b, c], [i, j, k]) = (cell(*low), cell(*high));
        for x in a..=i {
            for y in b..=j {
                for z in c..=k {
                    grid.entry([x, y, z]).or_default().push(index);
                }
            }
        }
    }
    let far = |node: &&Index| {
        let point = deck.points[**node as usize];
        let near = grid.get(&cell(point)).into_iter().flatten();
        !near
            .into_iter()
            .any(|index| distance(&pieces[*index], point) <= reach)
    };
    nodes.iter().filter(far).copied().collect()
}

/// Triangles of a face; a line is a triangle whose last two corners coincide.
fn pieces(deck: &Deck, face: Face) -> Vec<[Point; 3]> {
    let nodes = deck.face_nodes(face);
    let corners = deck.shape(face.0).faces[face.1].len();
    let at = |k: usize| deck.points[nodes[k] as usize];
    let middle = |a: usize, b: usize| {
        // middle nodes are in the order of the edges of the cell
        let [p, q] = [at(a), at(b)];
        let half: Point = std::array::from_fn(|d| 0.5 * (p[d] + q[d]));
        let apart = |k: usize| gap(at(k), half);
        (corners..nodes.len())
            .min_by(|i, j| apart(*i).total_cmp(&apart(*j)))
            .map_or(half, at)
    };
    if corners == 2 {
        let half = middle(0, 1);
        return vec![[at(0), half, half], [half, at(1), at(1)]];
    }
    // a fan about the centre, through corners and middles of edges
    let center: Point = std::array::from_fn(|d| {
        let ends: f64 = (0..corners).map(|k| at(k)[d]).sum();
        let halves: f64 = (0..corners).map(|k| middle(k, (k + 1) % corners)[d]).sum();
        // the middle of a face with middle nodes by its shape functions
        match corners {
            4 => (2.0 * halves - ends) / 4.0,
            _ => (4.0 * halves - ends) / 9.0,
        }
    });
    let edges = (0..corners).map(|k| (k, (k + 1) % corners));
    edges
        .flat_map(|(a, b)| [[at(a), middle(a, b), center], [middle(a, b), at(b), center]])
        .collect()
}

fn bounds(piece: &[Point; 3], reach: f64) -> [Point; 2] {
    let along = |d: usize| piece.iter().map(move |p| p[d]);
    [
        std::array::from_fn(|d| along(d).fold(f64::INFINITY, f64::min) - reach),
        std::array::from_fn(|d| along(d).fold(f64::NEG_INFINITY, f64::max) + reach),
    ]
}

fn gap(a: Point, b: Point) -> f64 {
    (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
}

/// Distance of a point from a triangle: from its plane where it lies above it, else from the nearest edge.
fn distance([a, b, c]: &[Point; 3], point: Point) -> f64 {
    let sub = |p: &Point, q: &Point| -> Point { std::array::from_fn(|d| p[d] - q[d]) };
    let dot = |p: &Point, q: &Point| (0..3).map(|d| p[d] * q[d]).sum::<f64>();
    let (u, v, w) = (sub(b, a), sub(c, a), sub(&point, a));
    let (uu, uv, vv, wu, wv) = (
        dot(&u, &u),
        dot(&u, &v),
        dot(&v, &v),
        dot(&w, &u),
        dot(&w, &v),
    );
    let area = uu * vv - uv * uv;
    if area > 0.0 {
        let (s, t) = ((vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area);
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
            return gap(point, std::array::from_fn(|d| a[d] + s * u[d] + t * v[d]));
        }
    }
    let to_edge = |p: &Point, q: &Point| {
        let (along, from) = (sub(q, p), sub(&point, p));
        let length = dot(&along, &along);
        let part = if length > 0.0 {
            (dot(&from, &along) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        gap(point, std::array::from_fn(|d| p[d] + part * along[d]))
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_a_triangle_are_those_from_plane_edge_and_corner() {
        let triangle = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        for (point, wanted) in [
            ([0.5, 0.5, -0.3], 0.3),
            ([1.0, -0.4, 0.3], 0.5),
            ([2.0, 2.0, 0.0], 2f64.sqrt()),
            ([-3.0, -4.0, 0.0], 5.0),
        ] {
            assert!(
                (distance(&triangle, point) - wanted).abs() < 1e-15,
                "{point:?}"
            );
        }
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        assert!((distance(&line, [0.5, 0.25, 0.0]) - 0.25).abs() < 1e-15);
    }
}
