//! The strip between two long sides of a plane body, or of several bodies side by side or one upon the other: its middle line, its
//! thickness, and the cuts across it.
//!
//! A *rib* joins a point a of the first side with a point b of the second; ribs follow each other without crossing, from one
//! end of the strip to the other, or once around a ring. With the unit tangents τ and the angle θ between rib and tangent
//! they are those for which
//!
//! ```text
//!   ∫ |a − b| (sin² 2θ_a ds_a + sin² 2θ_b ds_b)   is least:
//! ```
//!
//! across where the sides allow it (θ = 90°: radial in a ring of any thickness, upright in a beam; also beside a step, whose
//! face, at θ = 0°, costs nothing), with equal angles to both sides where these converge, and turning about the re-entrant
//! corner of a frame, whose diagonal is one of them. The middle line runs through the middles of the ribs.
//! Nodes of the two sides need not match: the paths are found among samples of the sides, which include the feet of the opposite
//! ones, by dynamic programming (the warping of two sequences, as described in Sakoe and Chiba, IEEE Trans. ASSP
//! 26 (1978) 43–49).
//!
//! Signs: s runs along the middle line with the first side on its left. A closed strip starts where the ray along +x from the
//! centroid of the enclosed area meets it.

use crate::geometry::{Point, add_scaled, distance, dot, norm, sub, unit};
use crate::mesh::{Chain, Facet, Mesh};
use std::collections::BTreeSet;

/// A straight cut across a strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// Length of the middle line up to it.
    pub s: f64,
    /// Its end on the first side.
    pub first: Point<2>,
    /// Its end on the second side.
    pub second: Point<2>,
    /// It is the end of the body, at the end of the middle line: the body lies on its far side.
    pub last: bool,
}

impl Cut {
    /// Its middle, about which moments are taken.
    pub fn middle(&self) -> Point<2> {
        add_scaled(self.first, 0.5, sub(self.second, self.first))
    }

    /// Its length.
    pub fn thickness(&self) -> f64 {
        distance(self.first, self.second)
    }

    /// Unit vector from the second side to the first.
    pub fn toward_first(&self) -> Point<2> {
        unit(sub(self.first, self.second)).unwrap_or([0.0, 1.0])
    }

    /// Unit vector across the cut, in the direction of s: the first side is on its left.
    pub fn along(&self) -> Point<2> {
        let [x, y] = self.toward_first();
        [y, -x]
    }
}

/// Why two sides are not the long sides of a strip.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StripError {
    /// No such side.
    #[error("there is no side \"{0}\"")]
    Unknown(String),
    /// A side in pieces.
    #[error("the side \"{side}\" is not one line: it has {pieces} pieces")]
    Pieces {
        /// Its name.
        side: String,
        /// How many.
        pieces: usize,
    },
    /// They meet, or coincide.
    #[error(
        "the sides \"{0}\" and \"{1}\" meet: two sides that face each other across the body are needed"
    )]
    Meet(String, String),
    /// A ring and a line.
    #[error("the side \"{0}\" goes all around and \"{1}\" does not")]
    OneClosed(String, String),
    /// They run in the same direction, or belong to unconnected parts.
    #[error("the sides \"{0}\" and \"{1}\" do not face each other across the body")]
    Apart(String, String),
    /// Thicker than long.
    #[error(
        "the sides \"{first}\" and \"{second}\" are not long ones: {thickness:.3e} from one to the other, {length:.3e} along"
    )]
    Short {
        /// Name of a side.
        first: String,
        /// The other.
        second: String,
        /// Largest thickness.
        thickness: f64,
        /// Length of the middle line.
        length: f64,
    },
}

/// The strip between two sides.
#[derive(Debug, Clone)]
pub struct Strip<'m> {
    sides: [Track<'m>; 2],
    ribs: Vec<Rib>,
    closed: bool,
}

/// A rib by its places on both sides; `s` is that of its middle.
#[derive(Debug, Clone, Copy)]
struct Rib {
    at: [f64; 2],
    s: f64,
}

/// Facets in their order, each of one of the bodies.
type Facets<'m> = Vec<(&'m Mesh<2>, Facet)>;

/// A side as a path: place k + x is the part x along its facet k.
#[derive(Debug, Clone)]
struct Track<'m> {
    facets: Facets<'m>,
    /// Against its chain, the body on the right.
    reversed: bool,
    closed: bool,
}

/// Most samples of a side that has fewer facets.
const SAMPLES: usize = 1200;

/// Most parts of a facet between two samples.
const PARTS: usize = 4;

/// Places of a facet nearer to each other coincide.
const SAME_PLACE: f64 = 1e-7;

/// Cosine of the angle between the normals of two facets up to which their common node is not a corner.
const SMOOTH: f64 = 0.94;

/// Lengths alone decide between paths that are equal otherwise.
const BY_LENGTH: f64 = 1e-6;

/// A rib is turned about its middle by up to this angle into the best position across, unless it is more oblique than this: then
/// it turns about a corner.
const LARGEST_TURN: f64 = 0.15;
const OBLIQUE: f64 = 0.3;

/// A point belongs to the cut that is nearer to it than this part of the thickness.
const ON_CUT: f64 = 0.25;

/// Facets of sides of several bodies follow each other where the ends are nearer than this part of both facets.
const JOINED: f64 = 0.25;

/// Both ends of a facet in the order of its side.
fn ends((mesh, facet): (&Mesh<2>, Facet)) -> [Point<2>; 2] {
    [-1.0, 1.0].map(|xi| mesh.facet_point(facet, &[xi]))
}

/// The sides of some bodies as one path, and whether it goes all around.
///
/// Errors: a side that is not there; several paths.
fn path<'m>(sides: &[(&'m Mesh<2>, &str)]) -> Result<(Facets<'m>, bool), StripError> {
    let mut chains: Vec<(Facets<'m>, bool)> = Vec::new();
    for &(mesh, side) in sides {
        let own = mesh
            .chain(side)
            .ok_or_else(|| StripError::Unknown(side.to_string()))?;
        let of_mesh = |chain: Chain| {
            let facets = chain.facets.into_iter().map(|facet| (mesh, facet));
            (facets.collect(), chain.cyclic)
        };
        chains.extend(own.into_iter().map(of_mesh));
    }
    let follows = |before: &Facets<'m>, next: &Facets<'m>| {
        let (Some(&before), Some(&next)) = (before.last(), next.first()) else {
            return false;
        };
        let [before, next] = [before, next].map(ends);
        let least = distance(before[0], before[1]).min(distance(next[0], next[1]));
        distance(before[1], next[0]) < JOINED * least
    };
    let open = |(_, cyclic): &(Facets<'m>, bool)| !cyclic;
    if chains.len() > 1 && chains.iter().all(open) {
        let followed = |k: usize| {
            chains
                .iter()
                .any(|(before, _)| follows(before, &chains[k].0))
        };
        // of a ring any may be the first
        let first = (0..chains.len()).find(|&k| !followed(k)).unwrap_or(0);
        let mut rest = chains;
        let mut whole = rest.remove(first).0;
        while let Some(next) = rest.iter().position(|(next, _)| follows(&whole, next)) {
            whole.extend(rest.remove(next).0);
        }
        let closed = follows(&whole, &whole);
        rest.push((whole, closed));
        chains = rest;
    }
    match (chains.len(), chains.pop()) {
        (1, Some(only)) => Ok(only),
        (pieces, _) => Err(StripError::Pieces {
            side: in_words(sides),
            pieces,
        }),
    }
}

/// The names of sides, those of several bodies each once.
fn in_words(sides: &[(&Mesh<2>, &str)]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for (_, side) in sides {
        names.extend((!names.contains(side)).then_some(*side));
    }
    names.join("\", \"")
}

impl<'m> Track<'m> {
    fn new((mut facets, closed): (Facets<'m>, bool), reversed: bool) -> Self {
        if reversed {
            facets.reverse();
        }
        Self {
            facets,
            reversed,
            closed,
        }
    }

    fn count(&self) -> f64 {
        self.facets.len() as f64
    }

    /// Facet and reference coordinate of a place; a closed track is endless.
    fn place(&self, at: f64) -> ((&'m Mesh<2>, Facet), f64) {
        let count = self.count();
        let at = if self.closed {
            at.rem_euclid(count)
        } else {
            at.clamp(0.0, count)
        };
        let index = (at.floor() as usize).min(self.facets.len() - 1);
        let xi = 2.0 * (at - index as f64) - 1.0;
        (self.facets[index], if self.reversed { -xi } else { xi })
    }

    /// The point at a place; straight on beyond the ends of an open track.
    fn point(&self, at: f64) -> Point<2> {
        let ((mesh, facet), xi) = self.place(at);
        let point = mesh.facet_point(facet, &[xi]);
        let beyond = at - at.clamp(0.0, self.count());
        if self.closed || beyond == 0.0 {
            return point;
        }
        let [start, end] = ends((mesh, facet));
        let way = if self.reversed { -beyond } else { beyond };
        add_scaled(point, way, sub(end, start))
    }

    /// It lies on the track.
    fn has(&self, at: f64) -> bool {
        self.closed || (0.0..=self.count()).contains(&at)
    }

    /// Unit vector into the body.
    fn inward(&self, at: f64) -> Point<2> {
        let ((mesh, facet), xi) = self.place(at);
        unit(mesh.outward_normal(facet, &[xi])).map_or([0.0; 2], |n| n.map(|c| -c))
    }

    /// The number of equal parts of each facet.
    fn parts(&self) -> usize {
        (SAMPLES / self.facets.len()).clamp(1, PARTS)
    }

    /// The ends of equal parts of all facets, in order; of a closed track without the last, which is the first.
    fn even(&self) -> Vec<f64> {
        let parts = self.parts();
        let last = if self.closed { 0 } else { 1 };
        let samples = 0..self.facets.len() * parts + last;
        samples.map(|k| k as f64 / parts as f64).collect()
    }

    /// Its nodes, each with the direction into the body there; at a corner those of both facets.
    fn rays(&self) -> Vec<(Point<2>, Point<2>)> {
        let end = if self.reversed { -1.0 } else { 1.0 };
        let inward = |(mesh, facet): (&Mesh<2>, Facet), xi: f64| {
            let normal = unit(mesh.outward_normal(facet, &[xi])).unwrap_or([0.0; 2]);
            normal.map(|n| -n)
        };
        let last = self.facets.len() - 1;
        let mut rays = Vec::new();
        for (k, &facet) in self.facets.iter().enumerate() {
            let at = |xi: f64| facet.0.facet_point(facet.1, &[xi]);
            if k == 0 && !self.closed {
                rays.push((at(-end), inward(facet, -end)));
            }
            let own = inward(facet, end);
            if k == last && !self.closed {
                rays.push((at(end), own));
                continue;
            }
            let next = inward(self.facets[(k + 1) % self.facets.len()], -end);
            match unit(add_scaled(own, 1.0, next)) {
                Some(mean) if dot(own, next) > SMOOTH => rays.push((at(end), mean)),
                _ => rays.extend([(at(end), own), (at(end), next)]),
            }
        }
        rays
    }

    /// The same at the ends of equal parts within its facets.
    fn rays_within(&self) -> impl Iterator<Item = (Point<2>, Point<2>)> {
        let parts = self.parts();
        let within = (0..self.facets.len() * parts).filter(move |k| k % parts != 0);
        let places = within.map(move |k| k as f64 / parts as f64);
        places.map(|at| (self.point(at), self.inward(at)))
    }

    /// Where a ray first meets it.
    fn hit(&self, samples: &[(f64, Point<2>)], from: Point<2>, along: Point<2>) -> Option<f64> {
        let hits = samples.windows(2).filter_map(|pair| {
            let [(p, a), (q, b)] = [pair[0], pair[1]];
            let (x, y) = (sub(a, from), sub(b, from));
            let side = |v: Point<2>| along[0] * v[1] - along[1] * v[0];
            let (left, right) = (side(x), side(y));
            if left * right > 0.0 || left == right {
                return None;
            }
            let part = left / (left - right);
            let far = dot(add_scaled(x, part, sub(y, x)), along);
            (far > SAME_PLACE * distance(a, b)).then_some((far, p + part * (q - p)))
        });
        hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|hit| hit.1)
    }

    /// Where a line through a point meets it near a place.
    fn crossing(&self, near: f64, through: Point<2>, along: Point<2>) -> Option<f64> {
        let side = |at: f64| {
            let v = sub(self.point(at), through);
            along[0] * v[1] - along[1] * v[0]
        };
        let (mut low, mut high) = (near, near);
        for step in [0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6] {
            (low, high) = (near - step, near + step);
            if side(low) * side(high) <= 0.0 {
                break;
            }
        }
        let (mut at_low, at_high) = (side(low), side(high));
        if at_low * at_high > 0.0 {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let value = side(middle);
            if at_low * value <= 0.0 {
                high = middle;
            } else {
                (low, at_low) = (middle, value);
            }
        }
        Some(0.5 * (low + high))
    }
}

/// sin² 2θ of the angle between two directions.
fn oblique(rib: Point<2>, tangent: Point<2>) -> f64 {
    let lengths = dot(rib, rib) * dot(tangent, tangent);
    if lengths == 0.0 {
        return 0.0;
    }
    let part = dot(rib, tangent);
    let part = part * part / lengths;
    4.0 * part * (1.0 - part)
}

/// Cost of the path from a to b beside the other end of the rib.
fn walk(a: Point<2>, b: Point<2>, rib: Point<2>) -> f64 {
    let step = sub(b, a);
    norm(step) * norm(rib) * (oblique(rib, step) + BY_LENGTH)
}

fn middle(a: Point<2>, b: Point<2>) -> Point<2> {
    add_scaled(a, 0.5, sub(b, a))
}

/// The cheapest path from the first to the last pair of two sequences, pair by pair.
fn cheapest(a: &[Point<2>], b: &[Point<2>]) -> Vec<[usize; 2]> {
    let (n, m) = (a.len(), b.len());
    // the step to each pair: 0 in both, 1 in the first, 2 in the second
    let mut came = vec![0_u8; n * m];
    let mut before: Vec<f64> = Vec::new();
    for i in 0..n {
        let mut row = vec![f64::INFINITY; m];
        for j in 0..m {
            if (i, j) == (0, 0) {
                row[0] = 0.0;
                continue;
            }
            let mut best = (f64::INFINITY, 0);
            if i > 0 {
                let rib = sub(b[j], middle(a[i - 1], a[i]));
                best = (before[j] + walk(a[i - 1], a[i], rib), 1);
            }
            if j > 0 {
                let rib = sub(middle(b[j - 1], b[j]), a[i]);
                let cost = row[j - 1] + walk(b[j - 1], b[j], rib);
                best = if cost < best.0 { (cost, 2) } else { best };
            }
            if i > 0 && j > 0 {
                let rib = sub(middle(b[j - 1], b[j]), middle(a[i - 1], a[i]));
                let both = walk(a[i - 1], a[i], rib) + walk(b[j - 1], b[j], rib);
                let cost = before[j - 1] + both;
                best = if cost <= best.0 { (cost, 0) } else { best };
            }
            row[j] = best.0;
            came[i * m + j] = best.1;
        }
        before = row;
    }
    let (mut i, mut j) = (n - 1, m - 1);
    let mut path = vec![[i, j]];
    while (i, j) != (0, 0) {
        match came[i * m + j] {
            1 => i -= 1,
            2 => j -= 1,
            _ => (i, j) = (i - 1, j - 1),
        }
        path.push([i, j]);
    }
    path.reverse();
    path
}

/// Two paths along one mesh belong to one part of it; those along several may be of any bodies.
fn connected(one: &Facets<'_>, other: &Facets<'_>) -> bool {
    let ((mesh, a), (_, b)) = (one[0], other[0]);
    let mut all = one.iter().chain(other);
    if !all.all(|(of, _)| std::ptr::eq(*of, mesh)) {
        return true;
    }
    let part = mesh.facet_components();
    let of = |facet: Facet| {
        let blocks = mesh.blocks()[..facet.block as usize].iter();
        part[blocks.map(|block| block.cells().len()).sum::<usize>() + facet.cell as usize]
    };
    of(a) == of(b)
}

impl<'m> Strip<'m> {
    /// The strip between two long sides, s with the first on its left. Each is a path along the named sides of one or several
    /// meshes.
    ///
    /// Errors: sides that are not two long sides of the bodies.
    pub fn between(sides: [&[(&'m Mesh<2>, &str)]; 2]) -> Result<Self, StripError> {
        let names = || (in_words(sides[0]), in_words(sides[1]));
        let (one, other) = (path(sides[0])?, path(sides[1])?);
        let nodes = |facets: &Facets<'m>| -> BTreeSet<(*const Mesh<2>, u32)> {
            let of = |&(mesh, facet): &(&'m Mesh<2>, Facet)| {
                let nodes = mesh.facet_nodes(facet);
                nodes.map(move |node| (std::ptr::from_ref(mesh), node))
            };
            facets.iter().flat_map(of).collect()
        };
        if !nodes(&one.0).is_disjoint(&nodes(&other.0)) {
            let (first, second) = names();
            return Err(StripError::Meet(first, second));
        }
        if one.1 != other.1 {
            let (first, second) = names();
            return Err(match one.1 {
                true => StripError::OneClosed(first, second),
                false => StripError::OneClosed(second, first),
            });
        }
        let connected = connected(&one.0, &other.0);
        let mut strip = Self {
            closed: one.1,
            sides: [Track::new(one, true), Track::new(other, false)],
            ribs: Vec::new(),
        };
        if !connected || !strip.faces() {
            let (first, second) = names();
            return Err(StripError::Apart(first, second));
        }
        let samples = strip.samples();
        strip.ribs = if strip.closed {
            strip.around(&samples)
        } else {
            let points = samples
                .each_ref()
                .map(|list| list.iter().map(|p| p.1).collect());
            let [a, b]: [Vec<Point<2>>; 2] = points;
            let path = cheapest(&a, &b).into_iter();
            let at = |[i, j]: [usize; 2]| [samples[0][i].0, samples[1][j].0];
            strip.measured(path.map(at).collect())
        };
        let thickness = |rib: &Rib| strip.raw(rib.at).thickness();
        let thickness = strip.ribs.iter().map(thickness).fold(0.0, f64::max);
        if thickness > strip.length() {
            let (first, second) = names();
            return Err(StripError::Short {
                first,
                second,
                thickness,
                length: strip.length(),
            });
        }
        Ok(strip)
    }

    /// Both sides face each other: rays into the body from one mostly meet the other.
    fn faces(&self) -> bool {
        let [first, second] = &self.sides;
        let target = second.polygon(&second.even());
        let even = first.even();
        let meets = |at: &&f64| {
            let from = first.point(**at + 0.5 / PARTS as f64);
            let inward = first.inward(**at + 0.5 / PARTS as f64);
            first.hit(&target, from, inward).is_some()
        };
        2 * even.iter().filter(meets).count() >= even.len()
    }

    /// Places of both sides that ribs may join, with their points, in order: equal parts of the facets, and the feet of the
    /// nodes opposite. Where these are no such parts, or their numbers differ, the sides do not match, and feet of all parts are taken:
    /// there would be oblique ribs between those of the nodes, the more so the thinner the strip.
    fn samples(&self) -> [Vec<(f64, Point<2>)>; 2] {
        let even = self.sides.each_ref().map(Track::even);
        let polygons = [0, 1].map(|k| self.sides[k].polygon(&even[k]));
        let known = |k: usize, at: f64| {
            let next = even[k].partition_point(|&even| even < at);
            let before = even[k].get(next.wrapping_sub(1)).copied();
            let end = Some(self.sides[k].count());
            let near = [before, even[k].get(next).copied(), end];
            near.into_iter()
                .flatten()
                .any(|even| (even - at).abs() < SAME_PLACE)
        };
        let hit = |k: usize, (from, inward)| self.sides[k].hit(&polygons[k], from, inward);
        // on each side those of the nodes of the other one
        let mut feet = [0, 1].map(|k| {
            let rays = self.sides[1 - k].rays().into_iter();
            let hits = rays.filter_map(|ray| hit(k, ray));
            hits.filter(|&at| !known(k, at)).collect::<Vec<f64>>()
        });
        if even[0].len() != even[1].len() || feet.iter().any(|own| !own.is_empty()) {
            for (k, own) in feet.iter_mut().enumerate() {
                let hits = self.sides[1 - k].rays_within();
                own.extend(
                    hits.filter_map(|ray| hit(k, ray))
                        .filter(|&at| !known(k, at)),
                );
            }
        }
        [0, 1].map(|k| {
            let (side, mut places) = (&self.sides[k], even[k].clone());
            places.append(&mut feet[k]);
            places.sort_by(f64::total_cmp);
            places.dedup_by(|b, a| *b - *a < SAME_PLACE);
            places.iter().map(|&at| (at, side.point(at))).collect()
        })
    }

    /// Ribs once around: a first path from any start, then one that starts where the first is farthest from its ends.
    fn around(&self, samples: &[Vec<(f64, Point<2>)>; 2]) -> Vec<Rib> {
        let counts = self.sides.each_ref().map(Track::count);
        let way = |start: [usize; 2]| -> Vec<[f64; 2]> {
            let turned = [0, 1].map(|k| {
                let list = &samples[k];
                let round = (0..=list.len()).map(|i| {
                    let index = start[k] + i;
                    let (at, point) = list[index % list.len()];
                    (at + counts[k] * (index / list.len()) as f64, point)
                });
                round.collect::<Vec<_>>()
            });
            let points = turned
                .each_ref()
                .map(|list| list.iter().map(|p| p.1).collect());
            let [a, b]: [Vec<Point<2>>; 2] = points;
            let path = cheapest(&a, &b).into_iter();
            path.map(|[i, j]| [turned[0][i].0, turned[1][j].0])
                .collect()
        };
        let nearest = |list: &[(f64, Point<2>)], to: Point<2>| {
            let far = |p: &(f64, Point<2>)| distance(p.1, to);
            let order = (0..list.len()).min_by(|&i, &j| far(&list[i]).total_cmp(&far(&list[j])));
            order.unwrap_or(0)
        };
        let first = way([0, nearest(&samples[1], samples[0][0].1)]);
        let half = first[first.len() / 2];
        let index = |k: usize| {
            let at = half[k].rem_euclid(counts[k]);
            let found = samples[k]
                .iter()
                .position(|p| (p.0 - at).abs() < SAME_PLACE);
            found.unwrap_or(0)
        };
        let path = way([index(0), index(1)]);
        let middles: Vec<Point<2>> = path.iter().map(|&at| self.raw(at).middle()).collect();
        let start = start_of_ring(&middles);
        // cut open there, and joined again after its end
        let (k, x) = (start.floor() as usize, start.fract());
        let between = |i: usize, x: f64| {
            let (p, q) = (path[i], path[i + 1]);
            [0, 1].map(|k| p[k] + x * (q[k] - p[k]))
        };
        let begin = between(k, x);
        let mut turned = vec![begin];
        turned.extend(&path[k + 1..]);
        let behind = path[1..=k].iter();
        turned.extend(behind.map(|at| [at[0] + counts[0], at[1] + counts[1]]));
        turned.push([begin[0] + counts[0], begin[1] + counts[1]]);
        self.measured(turned)
    }

    /// Ribs with the path lengths of their middles.
    fn measured(&self, path: Vec<[f64; 2]>) -> Vec<Rib> {
        let mut s = 0.0;
        let mut before = None;
        let ribs = path.into_iter().map(|at| {
            let here = self.raw(at).middle();
            s += before
                .replace(here)
                .map_or(0.0, |before| distance(before, here));
            Rib { at, s }
        });
        ribs.collect()
    }

    /// Length of the middle line.
    pub fn length(&self) -> f64 {
        self.ribs.last().map_or(0.0, |rib| rib.s)
    }

    /// It goes all around.
    pub fn closed(&self) -> bool {
        self.closed
    }

    /// The rib between two places as it is.
    fn raw(&self, at: [f64; 2]) -> Cut {
        Cut {
            s: 0.0,
            first: self.sides[0].point(at[0]),
            second: self.sides[1].point(at[1]),
            last: false,
        }
    }

    /// The cut at a length of the middle line.
    pub fn at(&self, s: f64) -> Cut {
        let (length, count) = (self.length(), self.ribs.len());
        let s = s.clamp(0.0, length);
        let next = self
            .ribs
            .partition_point(|rib| rib.s <= s)
            .clamp(1, count - 1);
        let (a, b) = (self.ribs[next - 1], self.ribs[next]);
        let part = if b.s > a.s {
            ((s - a.s) / (b.s - a.s)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let at = [0, 1].map(|k| a.at[k] + part * (b.at[k] - a.at[k]));
        let ends = !self.closed && (s <= SAME_PLACE * length || s >= (1.0 - SAME_PLACE) * length);
        let cut = if ends { self.raw(at) } else { self.across(at) };
        Cut {
            s,
            last: ends && s > 0.5 * length,
            ..cut
        }
    }

    /// A rib turned about its middle into the best position across.
    fn across(&self, at: [f64; 2]) -> Cut {
        let cut = self.raw(at);
        let (centre, along) = (cut.middle(), cut.toward_first());
        let turned = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let along = [
                cos * along[0] - sin * along[1],
                sin * along[0] + cos * along[1],
            ];
            let crossing = |k: usize| self.sides[k].crossing(at[k], centre, along);
            Some([crossing(0)?, crossing(1)?])
        };
        let cost = |at: [f64; 2]| {
            let rib = sub(self.sides[1].point(at[1]), self.sides[0].point(at[0]));
            let of = |k: usize| {
                let [x, y] = self.sides[k].inward(at[k]);
                oblique(rib, [y, -x])
            };
            of(0) + of(1)
        };
        if cost(at) > OBLIQUE {
            return cut;
        }
        let of_angle = |angle: f64| turned(angle).map_or(f64::INFINITY, cost);
        // golden section
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut low, mut high) = (-LARGEST_TURN, LARGEST_TURN);
        for _ in 0..45 {
            let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
            if of_angle(a) <= of_angle(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let on_body = |at: [f64; 2]| (0..2).all(|k| self.sides[k].has(at[k]));
        match turned(0.5 * (low + high)) {
            Some(better) if on_body(better) && cost(better) + 1e-12 < cost(at) => self.raw(better),
            _ => cut,
        }
    }

    /// The cut whose middle is nearest to a point; `None` where the point lies beside the strip.
    pub fn nearest(&self, point: Point<2>) -> Option<Cut> {
        let middles = self
            .ribs
            .iter()
            .map(|rib| (rib.s, self.raw(rib.at).middle()));
        let middles: Vec<(f64, Point<2>)> = middles.collect();
        let places = middles.windows(2).map(|pair| {
            let [(s, a), (r, b)] = [pair[0], pair[1]];
            let step = sub(b, a);
            let squared = dot(step, step);
            let part = if squared > 0.0 {
                dot(sub(point, a), step) / squared
            } else {
                0.0
            };
            let part = part.clamp(0.0, 1.0);
            (
                distance(point, add_scaled(a, part, step)),
                s + part * (r - s),
            )
        });
        let (_, s) = places.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let cut = self.at(s);
        let (from, half) = (sub(point, cut.middle()), 0.5 * cut.thickness());
        let beyond = (dot(from, cut.toward_first()).abs() - half).max(0.0);
        let off = dot(from, cut.along()).hypot(beyond);
        (off <= ON_CUT * cut.thickness()).then_some(cut)
    }
}

impl Track<'_> {
    /// The samples with their points, those of a closed track with the first once more behind them.
    fn polygon(&self, samples: &[f64]) -> Vec<(f64, Point<2>)> {
        let end = self.closed.then_some(self.count());
        let all = samples.iter().copied().chain(end);
        all.map(|at| (at, self.point(at))).collect()
    }
}

/// The outermost point of a polygon on the ray along +x from its centroid: index and part of the side that follows it. The last
/// point is the first.
fn start_of_ring(polygon: &[Point<2>]) -> f64 {
    let mut area = [0.0; 3];
    let origin = polygon[0];
    for pair in polygon.windows(2) {
        let (a, b) = (sub(pair[0], origin), sub(pair[1], origin));
        let twice = a[0] * b[1] - a[1] * b[0];
        area[0] += 3.0 * twice;
        area[1] += twice * (a[0] + b[0]);
        area[2] += twice * (a[1] + b[1]);
    }
    let centre = [origin[0] + area[1] / area[0], origin[1] + area[2] / area[0]];
    let size = polygon
        .iter()
        .map(|&p| distance(p, centre))
        .fold(0.0, f64::max);
    // a point that rounding has moved beside the ray is on it
    let height = |p: Point<2>| match p[1] - centre[1] {
        y if y.abs() < 1e-9 * size => 0.0,
        y => y,
    };
    let mut best = (f64::NEG_INFINITY, 0.0);
    for (k, pair) in polygon.windows(2).enumerate() {
        let (a, b) = (height(pair[0]), height(pair[1]));
        if a * b > 0.0 || a == b || b == 0.0 {
            continue;
        }
        let part = a / (a - b);
        let x = pair[0][0] + part * (pair[1][0] - pair[0][0]);
        if x > best.0 {
            best = (x, k as f64 + part);
        }
    }
    best.1
}

#[cfg(test)]
mod tests;
