//! How the edges of an outline are divided.
//!
//! The wanted size at a place x of an edge is
//!
//! ```text
//!   h(x) = min( own size, s_f + g·dist(x, f), s_r + g·max(0, |x − r| − radius_r), dist(x, wall) )
//! ```
//!
//! over the other edges f with size s_f, the points r of refinement, and the walls: edges without a common corner that are
//! seen through the body. Along the boundary h grows by at most g per length. An edge gets N = ⌈∫ds/h⌉ pieces of equal
//! ∫ds/h. Where h is constant the pieces are equal; an edge with a given number of pieces takes no notice of h.
//! Every edge is divided in a direction of its own, so that two bodies that draw it in opposite directions get the
//! same nodes.

use crate::geometry::{Point, distance, dot, sub};
use crate::mesh::outline::curve::Curve;
use crate::mesh::outline::nouns::{MOST_VERTICES, SizePoint};
use std::f64::consts::PI;

/// Largest angle of a piece of an arc: twelve around a circle.
const WIDEST_PIECE: f64 = PI / 6.0;

/// Sizes that differ by less than this part are one: where h is constant it must stay so to the last bit.
const SAME_SIZE: f64 = 1e-9;

/// Samples of h per wanted size.
const SAMPLES: f64 = 2.0;

/// A curve with what the user wants of it; `loop_index` and `next` say which edges meet.
#[derive(Debug, Clone)]
pub(crate) struct Rib {
    pub curve: Curve,
    /// Wanted length of its pieces.
    pub size: f64,
    /// Number of pieces, when it is given.
    pub pieces: Option<usize>,
    /// Which closed path it belongs to.
    pub path: usize,
    /// The edge that follows along the path.
    pub next: usize,
    /// The edge before.
    pub previous: usize,
}

/// Nodes of one edge in its direction, both ends included, and the points in the middle of its pieces.
pub(crate) struct Divided {
    pub nodes: Vec<Point<2>>,
    pub middles: Vec<Point<2>>,
}

/// What limits the size everywhere.
pub(crate) struct Sizes<'a> {
    pub largest: f64,
    pub growth: f64,
    pub refine: &'a [SizePoint],
}

impl Sizes<'_> {
    /// The size that the whole outline and the points of refinement allow at a place.
    pub fn near(&self, p: Point<2>) -> f64 {
        let allowed =
            |r: &SizePoint| r.size + self.growth * (distance(p, r.at) - r.radius).max(0.0);
        self.refine.iter().map(allowed).fold(self.largest, f64::min)
    }
}

/// h at places along one edge, in its canonical direction.
struct Profile {
    /// Parameter and size.
    samples: Vec<(f64, f64)>,
}

/// The division of every edge; `None` when it would have more than [`MOST_VERTICES`] pieces.
pub(crate) fn divide(ribs: &[Rib], sizes: &Sizes<'_>) -> Option<Vec<Divided>> {
    let own: Vec<f64> = ribs.iter().map(own_size).collect();
    let boxes: Vec<_> = ribs.iter().map(|rib| rib.curve.bounds()).collect();
    let mut profiles = Vec::with_capacity(ribs.len());
    let mut samples = 0;
    for (index, rib) in ribs.iter().enumerate() {
        let wanted = |curve: &Curve, t: f64, inward: f64| {
            let x = curve.point(t);
            let mut h = own[index].min(sizes.near(x));
            for (other, &size) in own.iter().enumerate() {
                let far = box_distance(x, boxes[other]);
                let wall = other != rib.next && other != rib.previous;
                let least = size + sizes.growth * far;
                if other == index || (least >= h && (!wall || far >= h)) {
                    continue;
                }
                let y = ribs[other].curve.nearest(x);
                let away = distance(x, y);
                h = h.min(size + sizes.growth * away);
                if wall && inward * dot(sub(y, x), curve.left(t)) > 0.0 {
                    h = h.min(away);
                }
            }
            h
        };
        let profile = profile(rib, wanted, MOST_VERTICES - samples)?;
        samples += profile.samples.len();
        profiles.push(profile);
    }
    limit_growth(ribs, &mut profiles, sizes.growth);
    let divided = ribs.iter().zip(&profiles);
    divided
        .map(|(rib, profile)| divided_rib(rib, profile))
        .collect()
}

/// Length of the pieces of an edge that has no neighbours.
fn own_size(rib: &Rib) -> f64 {
    let length = rib.curve.length();
    if let Some(pieces) = rib.pieces {
        return length / pieces as f64;
    }
    let widest = rib.curve.arc.map(|arc| WIDEST_PIECE * arc.radius);
    let size = rib.size.min(widest.unwrap_or(f64::INFINITY));
    length / whole(length / size)
}

/// The number of pieces for a number that need not be whole; rounding does not make one more.
fn whole(pieces: f64) -> f64 {
    (pieces - 1e-6).ceil().max(1.0)
}

fn box_distance(x: Point<2>, (low, high): (Point<2>, Point<2>)) -> f64 {
    let outside = |d: usize| (low[d] - x[d]).max(x[d] - high[d]).max(0.0);
    outside(0).hypot(outside(1))
}

/// Samples of h so close that it changes little between them. The body is on the left of the edge.
fn profile(rib: &Rib, wanted: impl Fn(&Curve, f64, f64) -> f64, most: usize) -> Option<Profile> {
    let canonical = rib.curve.is_canonical();
    let (curve, inward) = match canonical {
        true => (rib.curve, 1.0),
        false => (rib.curve.reversed(), -1.0),
    };
    let length = curve.length();
    if rib.pieces.is_some() {
        let size = own_size(rib);
        let samples = vec![(0.0, size), (1.0, size)];
        return Some(Profile { samples });
    }
    let at = |t: f64| (t, wanted(&curve, t, inward));
    let mut samples = vec![at(0.0)];
    // Intervals that wait, the next one last.
    let mut waiting = vec![(0.0, 1.0)];
    while let Some((from, to)) = waiting.pop() {
        let middle = at(0.5 * (from + to));
        if samples.len() + waiting.len() > most {
            return None;
        }
        let divisible = from < middle.0 && middle.0 < to;
        if divisible && SAMPLES * (to - from) * length > middle.1 {
            waiting.push((middle.0, to));
            waiting.push((from, middle.0));
        } else {
            samples.push(middle);
            samples.push(at(to));
        }
    }
    Some(Profile { samples })
}

/// Lets h grow by at most `growth` per length along every path, in both directions.
fn limit_growth(ribs: &[Rib], profiles: &mut [Profile], growth: f64) {
    let Some(paths) = ribs.iter().map(|rib| rib.path + 1).max() else {
        return;
    };
    for path in 0..paths {
        let mut places: Vec<(usize, usize)> = Vec::new();
        for (index, rib) in ribs.iter().enumerate().filter(|(_, rib)| rib.path == path) {
            let count = profiles[index].samples.len();
            match rib.curve.is_canonical() {
                true => places.extend((0..count).map(|k| (index, k))),
                false => places.extend((0..count).rev().map(|k| (index, k))),
            }
        }
        // Twice around, so that the smallest size reaches everything whatever the start.
        let around: Vec<_> = places.iter().chain(&places).copied().collect();
        sweep(ribs, profiles, growth, around.iter().copied());
        sweep(ribs, profiles, growth, around.iter().rev().copied());
    }
}

fn sweep(
    ribs: &[Rib],
    profiles: &mut [Profile],
    growth: f64,
    places: impl Iterator<Item = (usize, usize)>,
) {
    let mut last: Option<(usize, f64, f64)> = None;
    for (index, k) in places {
        let (t, h) = profiles[index].samples[k];
        let mut limited = h;
        if let Some((before, t_before, h_before)) = last {
            let step = match before == index {
                true => (t - t_before).abs() * ribs[index].curve.length(),
                false => 0.0,
            };
            let allowed = h_before + growth * step;
            if ribs[index].pieces.is_none() && allowed < h * (1.0 - SAME_SIZE) {
                limited = allowed;
            }
        }
        profiles[index].samples[k].1 = limited;
        last = Some((index, t, limited));
    }
}

fn divided_rib(rib: &Rib, profile: &Profile) -> Option<Divided> {
    let canonical = rib.curve.is_canonical();
    let curve = match canonical {
        true => rib.curve,
        false => rib.curve.reversed(),
    };
    let ends = parameters(rib, &curve, profile)?;
    let mut nodes: Vec<Point<2>> = ends.iter().map(|&t| curve.point(t)).collect();
    let mut middles: Vec<Point<2>> = ends
        .windows(2)
        .map(|t| curve.point(0.5 * (t[0] + t[1])))
        .collect();
    if !canonical {
        nodes.reverse();
        middles.reverse();
    }
    Some(Divided { nodes, middles })
}

/// Parameters of the nodes in the canonical direction.
fn parameters(rib: &Rib, curve: &Curve, profile: &Profile) -> Option<Vec<f64>> {
    let samples = &profile.samples;
    let low = samples.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
    let high = samples.iter().map(|s| s.1).fold(0.0, f64::max);
    let length = curve.length();
    if low >= high * (1.0 - SAME_SIZE) {
        let pieces = rib
            .pieces
            .map_or(whole(length / low), |pieces| pieces as f64);
        if pieces > MOST_VERTICES as f64 {
            return None;
        }
        let pieces = pieces as usize;
        return Some((0..=pieces).map(|k| k as f64 / pieces as f64).collect());
    }
    let mut sums = vec![0.0];
    for pair in samples.windows(2) {
        let step = (pair[1].0 - pair[0].0) * length;
        let density = 0.5 * (1.0 / pair[0].1 + 1.0 / pair[1].1);
        sums.push(sums[sums.len() - 1] + step * density);
    }
    let total = sums[sums.len() - 1];
    let pieces = whole(total);
    if pieces > MOST_VERTICES as f64 {
        return None;
    }
    let pieces = pieces as usize;
    let mut ends = vec![0.0];
    let mut interval = 0;
    for k in 1..pieces {
        let sum = total * k as f64 / pieces as f64;
        while interval + 2 < sums.len() && sums[interval + 1] < sum {
            interval += 1;
        }
        let share = (sum - sums[interval]) / (sums[interval + 1] - sums[interval]);
        let (from, to) = (samples[interval].0, samples[interval + 1].0);
        ends.push(from + share * (to - from));
    }
    ends.push(1.0);
    Some(ends)
}
