//! Penetration: outlines of all deformed bodies against each other, with or without a contact between them.
//!
//! ```text
//!   grown(x) = max(0, depth of x + u in the other outline as it has moved) − max(0, the same of x before anything moved)
//! ```
//!
//! at nodes and points between them. The depth of a point inside a polygon is its distance from the polygon; a ray decides whether
//! it is inside. The limit is the error of small displacements:
//!
//! ```text
//!   tiny + 2 s (‖∇u₁‖ + ‖∇u₂‖)       rotations by angles instead of their sines, over a motion s; ‖∇u‖ along the outlines
//!        + 10 × resolution of the mesh + s²/R + a clearance that the meshes lack      at sides of contacts between the two,
//!                                                                                     and no farther from them than that
//! ```
//!
//! Bodies whose undeformed outlines meet in a point, and along no line, have no sides there for a contact: points nearer than ten
//! motions to such a point are not checked, where facets are longer than that.

use crate::cells::Kind;
use crate::check::{Limits, View, place};
use crate::judgement::Judgement;
use crate::plane::{Vector, cross};
use crate::raw::{Answer, Mesh};
use crate::vector::{bounds, dot, length, minus, plus, times};
use std::collections::{BTreeMap, BTreeSet};

/// Pieces of a facet with a middle node.
const PIECES: usize = 6;

/// Allowed penetration of the surfaces of a contact, in units of the resolution of the mesh.
const RESOLVED: f64 = 10.0;

/// Points within this many motions of the meeting point of two edges are not checked.
const NARROW: f64 = 10.0;

/// A point of an outline: the nodes that carry it.
type Bearers = Vec<(usize, f64)>;

/// The outline of a body.
pub struct Outline {
    /// Pieces of facets, by their two ends, and the facet of each.
    pieces: Vec<([usize; 2], usize)>,
    points: Vec<Bearers>,
    facets: Vec<Vec<usize>>,
}

impl Outline {
    /// The outline of a mesh: the facets that belong to one cell only.
    pub fn new(mesh: &Mesh) -> Self {
        let mut found: BTreeMap<Vec<usize>, (usize, Vec<usize>)> = BTreeMap::new();
        for (kind, nodes) in &mesh.cells {
            for local in 0..kind.facets().len() {
                let facet: Vec<usize> = kind.facet(local).iter().map(|&i| nodes[i]).collect();
                let mut key = facet.clone();
                key.sort_unstable();
                found.entry(key).or_insert((0, facet)).0 += 1;
            }
        }
        let once = found.into_values().filter(|(count, _)| *count == 1);
        let mut outline = Self {
            pieces: Vec::new(),
            points: Vec::new(),
            facets: once.map(|(_, facet)| facet).collect(),
        };
        let mut places: BTreeMap<usize, usize> = BTreeMap::new();
        for (index, facet) in outline.facets.iter().enumerate() {
            let points = &mut outline.points;
            let mut at = |node: usize| {
                *places.entry(node).or_insert_with(|| {
                    points.push(vec![(node, 1.0)]);
                    points.len() - 1
                })
            };
            let (first, last) = (at(facet[0]), at(facet[1]));
            let count = if facet.len() == 3 { PIECES } else { 1 };
            let mut before = first;
            for k in 1..=count {
                let next = if k == count {
                    last
                } else {
                    let xi = -1.0 + 2.0 * k as f64 / count as f64;
                    let shape = Kind::Line3.shape([xi, 0.0, 0.0]).into_iter();
                    let values = shape.map(|(n, _)| n);
                    outline
                        .points
                        .push(facet.iter().copied().zip(values).collect());
                    outline.points.len() - 1
                };
                outline.pieces.push(([before, next], index));
                before = next;
            }
        }
        outline
    }

    /// Its points, moved by these displacements.
    fn places(&self, mesh: &Mesh, moves: Option<&[Vector]>) -> Vec<Vector> {
        let at = |node: usize| match moves {
            Some(moves) => plus(mesh.points[node], 1.0, moves[node]),
            None => mesh.points[node],
        };
        let place = |bearers: &Bearers| {
            bearers
                .iter()
                .fold([0.0; 2], |sum, &(node, n)| plus(sum, n, at(node)))
        };
        self.points.iter().map(place).collect()
    }

    /// The largest derivative of the displacement along it.
    fn gradient(&self, mesh: &Mesh, moves: &[Vector]) -> f64 {
        let along = |facet: &Vec<usize>| {
            let [a, b] = [facet[0], facet[1]];
            length(minus(moves[b], moves[a])) / length(minus(mesh.points[b], mesh.points[a]))
        };
        self.facets.iter().map(along).fold(0.0, f64::max)
    }
}

/// The depth of a point inside a closed line, zero outside, and its distance from that line.
pub fn depth(x: Vector, pieces: impl Iterator<Item = [Vector; 2]>) -> (f64, f64) {
    let (mut inside, mut distance) = (false, f64::INFINITY);
    for [a, b] in pieces {
        if (a[1] > x[1]) != (b[1] > x[1]) {
            let part = (x[1] - a[1]) / (b[1] - a[1]);
            inside ^= x[0] < a[0] + part * (b[0] - a[0]);
        }
        distance = distance.min(to_piece(x, a, b));
    }
    (if inside { distance } else { 0.0 }, distance)
}

/// Distance of a point from a piece of a line.
fn to_piece(x: Vector, a: Vector, b: Vector) -> f64 {
    let (along, from) = (minus(b, a), minus(x, a));
    let size = dot(along, along);
    let part = if size > 0.0 {
        (dot(from, along) / size).clamp(0.0, 1.0)
    } else {
        0.0
    };
    length(minus(from, times(part, along)))
}

/// Points of the first body that are in contacts between two bodies, and their allowed penetration.
#[derive(Default)]
struct Named {
    /// Nodes of its sides in such contacts.
    nodes: BTreeSet<usize>,
    allowed: f64,
}

/// Judges the penetration of every body into every other.
pub fn check_overlaps(judgement: &mut Judgement, view: &View<'_, 2>) {
    let Answer { meshes, .. } = view.answer;
    let outlines: Vec<Outline> = meshes.iter().map(Outline::new).collect();
    let bodies = view.problem.bodies.iter();
    let there: Vec<bool> = bodies.map(|body| body.there(view.step.time)).collect();
    let moves = &view.step.displacements;
    let places =
        |b: usize, moved: bool| outlines[b].places(&meshes[b], moved.then_some(&moves[b][..]));
    for a in 0..meshes.len() {
        for b in 0..meshes.len() {
            if a == b || !there[a] || !there[b] {
                continue;
            }
            let (mine, theirs) = (places(a, true), places(b, true));
            let (low, high) = bounds(&theirs);
            let within = |x: &Vector| (0..2).all(|d| x[d] > low[d] && x[d] < high[d]);
            if !mine.iter().any(within) {
                continue;
            }
            let named = named(view, a, b);
            let drawn = [places(a, false), places(b, false)];
            let travel = mine.iter().zip(&drawn[0]);
            let travel = travel.chain(theirs.iter().zip(&drawn[1]));
            // the relative motion of the two
            let (least, most) = bounds(&travel.map(|(&y, &x)| minus(y, x)).collect::<Vec<_>>());
            let motion = length(minus(most, least)).min(2.0 * view.state.moves);
            let gradients = outlines[a].gradient(&meshes[a], &moves[a])
                + outlines[b].gradient(&meshes[b], &moves[b]);
            let base = view.state.tiny_length() + 2.0 * motion * gradients;
            let meetings = meetings(&drawn, &outlines[a], &outlines[b], motion);
            let line = |of: &[Vector]| -> Vec<[Vector; 2]> {
                let pieces = outlines[b].pieces.iter();
                pieces.map(|([p, q], _)| [of[*p], of[*q]]).collect()
            };
            let (now, first) = (line(&theirs), line(&drawn[1]));
            for (point, bearers) in outlines[a].points.iter().enumerate() {
                if !within(&mine[point]) {
                    continue;
                }
                let (deep, _) = depth(mine[point], now.iter().copied());
                if deep <= base {
                    continue;
                }
                let near = |x: &Vector| length(minus(*x, drawn[0][point])) < NARROW * motion;
                if meetings.iter().any(near) {
                    continue;
                }
                let (before, _) = depth(drawn[0][point], first.iter().copied());
                // a point nearer to a side than its allowed penetration moves with that side: a corner of the finest cells
                let beside = |node: &usize| {
                    let off = minus(meshes[a].points[*node], drawn[0][point]);
                    length(off) <= named.allowed
                };
                let in_contact = bearers.iter().any(|(node, _)| named.nodes.contains(node))
                    || named.nodes.iter().any(beside);
                let allowed = base + if in_contact { named.allowed } else { 0.0 };
                judgement.compare("stands in", deep - before, allowed, || {
                    let at = place(drawn[0][point]);
                    let [mine, theirs] = [a, b].map(|b| &view.problem.bodies[b].name);
                    format!("{mine} in {theirs} by {deep:.3e} at {at}")
                });
            }
        }
    }
}

/// Points at which undeformed outlines without a common line meet.
fn meetings(
    drawn: &[Vec<Vector>; 2],
    mine: &Outline,
    theirs: &Outline,
    motion: f64,
) -> Vec<Vector> {
    let (low, high) = bounds(&drawn[0]);
    let touch = 1e-9 * length(minus(high, low));
    let on = |x: Vector, of: &Outline, points: &[Vector]| {
        let pieces = of.pieces.iter();
        pieces
            .map(|([p, q], _)| to_piece(x, points[*p], points[*q]))
            .fold(f64::INFINITY, f64::min)
            <= touch
    };
    let mut found = Vec::new();
    let sides = [(mine, 0, theirs, 1), (theirs, 1, mine, 0)];
    for (own, i, other, j) in sides {
        for (point, &x) in drawn[i].iter().enumerate() {
            if !on(x, other, &drawn[j]) {
                continue;
            }
            let around = own
                .pieces
                .iter()
                .filter(|([p, q], _)| *p == point || *q == point);
            let alone = around.clone().all(|([p, q], _)| {
                let [p, q] = [drawn[i][*p], drawn[i][*q]];
                let beside = plus(x, 1e-3, minus(if p == x { q } else { p }, x));
                length(minus(p, q)) > NARROW * motion && !on(beside, other, &drawn[j])
            });
            // along a line of the other one that runs through this point
            let lines = other.pieces.iter().all(|([p, q], _)| {
                let [p, q] = [drawn[j][*p], drawn[j][*q]];
                to_piece(x, p, q) > touch
                    || around.clone().all(|([r, s], _)| {
                        let mine = minus(drawn[i][*s], drawn[i][*r]);
                        let theirs = minus(q, p);
                        let sine = cross(mine, theirs).abs() / (length(mine) * length(theirs));
                        sine > 1e-6 || !overlapping([p, q], [drawn[i][*r], drawn[i][*s]])
                    })
            });
            if alone && lines {
                found.push(x);
            }
        }
    }
    found
}

/// Whether two pieces of one straight line have more than a point in common.
fn overlapping([a, b]: [Vector; 2], [c, d]: [Vector; 2]) -> bool {
    let along = minus(b, a);
    let size = dot(along, along);
    let place = |x: Vector| dot(minus(x, a), along) / size;
    let (low, high) = (place(c).min(place(d)), place(c).max(place(d)));
    high.min(1.0) - low.max(0.0) > 1e-6
}

/// The contacts between two bodies, for points of the first.
fn named(view: &View<'_, 2>, a: usize, b: usize) -> Named {
    let mut all = Named::default();
    for (c, touch) in view.touches.iter().enumerate() {
        let other = if touch.own == a { b } else { a };
        let both = touch.own == other || touch.other == Some(other);
        let Some((_, own, _)) = view.sides(c).find(|(body, ..)| both && *body == a) else {
            continue;
        };
        all.nodes.extend(own.around.keys());
        let limits = Limits::new(view, c, [0.0; 2]);
        let resolved = limits.coarse.into_iter().fold(0.0, f64::max);
        // the difference of the gap in the meshes and the gap of the contact: given, or counted as closed
        let lacking = touch.samples().map(|sample| {
            let clearance = touch.clearance(sample, view.step.time);
            (sample.distance - clearance).abs()
        });
        let lacking = lacking.fold(0.0, f64::max);
        // motion along a curve: the sagitta of the arc that was passed
        let turns = view.sides(c).map(|(_, skin, _)| skin.turn);
        let turn = turns.fold(0.0, f64::max);
        let bow = 2.0 * view.state.moves.powi(2) * turn / touch.skin.longest;
        let allowed = RESOLVED * resolved + bow + lacking;
        all.allowed = all.allowed.max(allowed);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64) -> Mesh {
        Mesh {
            points: vec![[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]],
            cells: vec![(Kind::Quad4, vec![0, 1, 2, 3])],
            sides: BTreeMap::new(),
        }
    }

    #[test]
    fn depths_are_distances_from_the_outline_of_what_is_inside() {
        let mesh = square(0.0, 0.0);
        let outline = Outline::new(&mesh);
        let points = outline.places(&mesh, None);
        let pieces = || {
            let pieces = outline.pieces.iter();
            pieces.map(|([p, q], _)| [points[*p], points[*q]])
        };
        let (deep, off) = depth([0.9, 0.4], pieces());
        assert!((deep - 0.1).abs() < 1e-15 && (off - 0.1).abs() < 1e-15);
        let (deep, off) = depth([1.3, 1.4], pieces());
        assert!(deep == 0.0 && (off - 0.5).abs() < 1e-15);
    }

    #[test]
    fn corners_meet_in_a_point_and_sides_along_a_line() {
        let (a, corner, beside) = (square(0.0, 0.0), square(1.0, 1.0), square(1.0, 0.3));
        let outlines = [&a, &corner, &beside].map(Outline::new);
        let drawn = [&a, &corner, &beside].map(|m| Outline::new(m).places(m, None));
        let found = |k: usize| {
            let both = [drawn[0].clone(), drawn[k].clone()];
            meetings(&both, &outlines[0], &outlines[k], 1e-3)
        };
        assert!(found(1).iter().all(|&x| x == [1.0, 1.0]) && !found(1).is_empty());
        assert!(found(2).is_empty());
    }
}
