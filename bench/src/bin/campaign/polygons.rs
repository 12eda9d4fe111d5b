//! The parts of facets of a side of space that face the other side: polygons between plane facets, sampled points else.

use crate::cells::Place;
use crate::touch::{Facing, Sample, Touch};
use crate::vector::{cross, dot, length, mean, minus, plus, times, unit};

type Vector = [f64; 3];

/// Sampled points along an edge of a facet of a curved side.
const POINTS: usize = 5;

/// Polygons of a smaller part of their facet are rounding.
const SLIVER: f64 = 1e-9;

/// Points that face something, between the nodes, and the facets that face each other.
pub fn facing(touch: &Touch<'_, 3>) -> Facing<3> {
    let mut facing = Facing {
        sampled: !touch.exact,
        ..Facing::default()
    };
    for (index, facet) in touch.skin.facets.iter().enumerate() {
        if touch.exact {
            cut(touch, index, &mut facing);
            continue;
        }
        for xi in lattice(facet.kind.triangle()) {
            if let Some((sample, other)) = touch.look(index, &facet.at(xi)) {
                facing.between.push(sample);
                facing.seen.insert((index, other));
            }
        }
    }
    facing
}

/// The polygons of a facet that face something.
fn cut(touch: &Touch<'_, 3>, index: usize, facing: &mut Facing<3>) {
    let corners = touch.skin.facets[index].corners();
    let mut polygons: Vec<(Vec<Vector>, Option<usize>)> = Vec::new();
    match &touch.opposite {
        None => polygons.push((corners.to_vec(), None)),
        Some(opposite) => {
            let facets = opposite.facets.iter().enumerate();
            polygons.extend(facets.map(|(k, f)| (clipped(corners, f.corners()), Some(k))));
        }
    }
    for (polygon, other) in polygons {
        if area(&polygon) < SLIVER * area(corners) {
            continue;
        }
        let centre = mean(&polygon);
        // another layer of facets, or one that looks away, lies there
        let Some((middle, _)) = inside(touch, index, centre).filter(|(_, found)| *found == other)
        else {
            continue;
        };
        for &corner in &polygon {
            for part in [1.0 - 1e-6, 0.6] {
                let x = plus(centre, part, minus(corner, centre));
                let sample = inside(touch, index, x).map(|(sample, _)| sample);
                facing.between.extend(sample);
            }
            facing.points.push((corner, middle.normal));
        }
        facing.between.push(middle);
        facing.seen.insert((index, other));
        *facing.area.get_or_insert(0.0) += area(&polygon);
    }
}

/// The sample of a point of the plane of a facet, inside the facet.
fn inside(touch: &Touch<'_, 3>, facet: usize, x: Vector) -> Option<(Sample<3>, Option<usize>)> {
    let own = &touch.skin.facets[facet];
    let (xi, _) = own.hit(x, unit(doubled(own.corners())))?;
    touch.look(facet, &own.at(xi))
}

/// Reference coordinates of points all over a facet.
fn lattice(triangle: bool) -> Vec<Place> {
    let step = |k: usize| (k as f64 + 0.5) / POINTS as f64;
    let all = (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| [step(i), step(j)]));
    all.map(|[a, b]| match triangle {
        // folded onto the triangle
        true => [a * (1.0 - b), b, 0.0],
        false => [2.0 * a - 1.0, 2.0 * b - 1.0, 0.0],
    })
    .collect()
}

/// Twice the area of a plane polygon, as a vector.
fn doubled(polygon: &[Vector]) -> Vector {
    let pairs = polygon.windows(2).skip(1);
    pairs.fold([0.0; 3], |s, p| {
        let triangle = cross(minus(p[0], polygon[0]), minus(p[1], polygon[0]));
        plus(s, 1.0, triangle)
    })
}

/// The area of a plane polygon.
fn area(polygon: &[Vector]) -> f64 {
    0.5 * length(doubled(polygon))
}

/// The part of a convex plane polygon that lies behind another one, looked at along its normal.
fn clipped(own: &[Vector], other: &[Vector]) -> Vec<Vector> {
    let n = unit(doubled(own));
    let mut polygon = own.to_vec();
    let around = dot(doubled(other), n).signum();
    for (&a, &b) in other.iter().zip(other.iter().cycle().skip(1)) {
        // the plane through an edge of the other, along the normal; inside is where its normal points
        let inwards = times(around, cross(n, minus(b, a)));
        let height = |x: Vector| dot(inwards, minus(x, a));
        let mut cut = Vec::new();
        for (&p, &q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let (low, high) = (height(p), height(q));
            if low >= 0.0 {
                cut.push(p);
            }
            if (low < 0.0) != (high < 0.0) {
                cut.push(plus(p, low / (low - high), minus(q, p)));
            }
        }
        polygon = cut;
        if polygon.len() < 3 {
            return Vec::new();
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::tangents;

    #[test]
    fn polygons_are_cut_where_they_lie_behind_each_other() {
        let [u, v] = tangents([0.0, 0.6, 0.8])[..] else {
            panic!()
        };
        let at = |x: f64, y: f64, z: f64| plus(plus(times(x, u), y, v), z, cross(u, v));
        let own = [at(0.0, 0.0, 0.0), at(2.0, 0.0, 0.0), at(0.0, 2.0, 0.0)];
        let other = [
            at(1.0, 3.0, 1.0),
            at(1.0, 0.5, 1.0),
            at(-1.0, 0.5, 2.0),
            at(-1.0, 3.0, 2.0),
        ];
        let cut = clipped(&own, &other);
        // 0 ≤ x ≤ 1, 0.5 ≤ y ≤ 2 − x
        assert!((area(&cut) - 1.0).abs() < 1e-14, "{}", area(&cut));
        assert!(clipped(&own, &other.map(|x| plus(x, 5.0, u))).is_empty());
    }
}
