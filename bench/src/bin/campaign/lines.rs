//! The parts of lines of a side of the plane that face the other side.

use crate::cells::gauss;
use crate::elastic::depth;
use crate::plane::cross;
use crate::problem::Problem;
use crate::side::Skin;
use crate::touch::{Facing, Touch};
use crate::vector::{length, minus};

/// Points of a facet, beside its nodes, at which gaps are looked at.
const POINTS: usize = 20;

/// Cuts every facet where the opposite facet may change, and keeps the parts that face the other side.
pub fn facing(problem: &Problem, touch: &Touch<'_, 2>) -> Facing<2> {
    let mut facing = Facing::default();
    let mut area = 0.0;
    for index in 0..touch.skin.facets.len() {
        let parts = parts(touch, index);
        for &part in &parts {
            look(touch, index, part, &mut facing);
            area += size(problem, touch, index, part);
        }
        let even = (0..POINTS).map(|k| -1.0 + 2.0 * (k as f64 + 0.5) / POINTS as f64);
        for xi in even.chain(ends(&parts)) {
            let at = touch.skin.facets[index].at([xi, 0.0, 0.0]);
            let sample = touch.look(index, &at).map(|(sample, _)| sample);
            facing.between.extend(sample);
        }
    }
    let straight = touch.skin.flat() && touch.opposite.as_ref().is_none_or(Skin::flat);
    facing.area = straight.then_some(area);
    facing
}

/// The parts of a facet that face the other side, by their ends.
fn parts(touch: &Touch<'_, 2>, index: usize) -> Vec<[f64; 2]> {
    let mut cuts = cuts(touch, index);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let middle = |c: &[f64]| 0.5 * (c[0] + c[1]);
    let faces: Vec<bool> = cuts
        .windows(2)
        .map(|c| touch.faces(index, [middle(c), 0.0, 0.0]))
        .collect();
    let mut parts = Vec::new();
    for (place, own) in cuts.windows(2).enumerate().filter(|(p, _)| faces[*p]) {
        let (mut from, mut to) = (own[0], own[1]);
        if place > 0 && !faces[place - 1] {
            from = edge(touch, index, middle(&cuts[place - 1..]), middle(own));
        }
        if place + 1 < faces.len() && !faces[place + 1] {
            to = edge(touch, index, middle(&cuts[place + 1..]), middle(own));
        }
        parts.push([from, to]);
    }
    parts
}

/// Places just inside the ends of what faces the other side.
fn ends(parts: &[[f64; 2]]) -> Vec<f64> {
    let all = parts
        .iter()
        .flat_map(|&[from, to]| [[from, to], [to, from]]);
    let alone = |end: f64| parts.iter().flatten().filter(|x| **x == end).count() == 1;
    all.filter(|[end, _]| alone(*end))
        .map(|[end, inwards]| end + 1e-9 * (inwards - end))
        .collect()
}

/// Where lines along the normals meet ends of the other side's facets; ends and a few places between.
fn cuts(touch: &Touch<'_, 2>, index: usize) -> Vec<f64> {
    let facet = &touch.skin.facets[index];
    let even = (0..=8).map(|k| -1.0 + 0.25 * f64::from(k));
    let mut cuts: Vec<f64> = even.collect();
    let Some(opposite) = &touch.opposite else {
        return cuts;
    };
    let line = |xi: f64| {
        let at = facet.at([xi, 0.0, 0.0]);
        (touch.skin.normal(index, &at), at.x)
    };
    let ends = [line(-1.0), line(1.0)];
    for &y in opposite.facets.iter().flat_map(|f| f.corners()) {
        let beside = |(normal, x)| cross(normal, minus(y, x));
        let [at_low, at_high] = ends.map(beside);
        if at_low * at_high >= 0.0 {
            continue;
        }
        let (mut low, mut high) = (-1.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (beside(line(middle)) < 0.0) == (at_low < 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        cuts.push(0.5 * (low + high));
    }
    cuts
}

/// Where facing begins between a place that does not face anything and one that does.
fn edge(touch: &Touch<'_, 2>, index: usize, mut alone: f64, mut faces: f64) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (alone + faces);
        if touch.faces(index, [middle, 0.0, 0.0]) {
            faces = middle;
        } else {
            alone = middle;
        }
    }
    faces
}

/// Adds points of a part, its ends included, with contact normals and the facets that it faces.
fn look(touch: &Touch<'_, 2>, index: usize, [from, to]: [f64; 2], facing: &mut Facing<2>) {
    let facet = &touch.skin.facets[index];
    for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let inside = from + (0.5 + (part - 0.5) * (1.0 - 1e-9)) * (to - from);
        let at = facet.at([inside, 0.0, 0.0]);
        let Some((sample, other)) = touch.look(index, &at) else {
            continue;
        };
        let end = facet.at([from + part * (to - from), 0.0, 0.0]);
        facing.points.push((end.x, sample.normal));
        // at the ends of a part another facet may be as near
        if part > 0.0 && part < 1.0 {
            facing.seen.insert((index, other));
        }
    }
}

/// The area of a part.
fn size(problem: &Problem, touch: &Touch<'_, 2>, index: usize, [from, to]: [f64; 2]) -> f64 {
    let body = &problem.bodies[touch.own];
    let each = gauss(5).into_iter().map(|(x, weight)| {
        let xi = 0.5 * (from + to) + 0.5 * (to - from) * x;
        let at = touch.skin.facets[index].at([xi, 0.0, 0.0]);
        let stretch = 0.5 * (to - from) * length(at.normal);
        weight * stretch * depth(body, problem.analysis, at.x)
    });
    each.sum()
}
