//! Division of the edges of an outline.
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

use crate::geometry::{Point, add_scaled, distance, dot, sub};
use crate::mesh::outline::curve::Curve;
use crate::mesh::outline::nouns::MOST_VERTICES;
use crate::mesh::{MeshError, SizeField, SizePoint};
use std::f64::consts::PI;

/// Largest angle of a piece of an arc: twelve around a circle.
pub(crate) const WIDEST_PIECE: f64 = PI / 6.0;

/// Sizes that differ by less than this part are equal: a constant h must stay constant to the last bit.
const SAME_SIZE: f64 = 1e-9;

/// Samples of h per wanted size.
const SAMPLES: f64 = 2.0;

/// A curve with the wishes of the user.
#[derive(Debug, Clone)]
pub(crate) struct Rib {
    pub curve: Curve,
    /// Wanted length of its pieces.
    pub size: f64,
    /// Number of pieces, when it is given.
    pub pieces: Option<usize>,
    /// Largest angle of a piece of an arc.
    pub widest: f64,
    /// Numbers of the corners that it joins: edges with a common corner meet there.
    pub ends: [usize; 2],
    /// The faces filled on its left and on its right.
    pub faces: [Option<usize>; 2],
}

impl Rib {
    /// Whether it has a corner in common with another one.
    fn meets(&self, other: &Self) -> bool {
        self.ends.iter().any(|end| other.ends.contains(end))
    }

    /// Angle by which the direction from p turns along it, with a face on the left; zero if it does not border that face.
    pub fn winding(&self, face: usize, p: Point<2>) -> f64 {
        match self.faces.map(|own| own == Some(face)) {
            [true, false] => self.curve.winding(p),
            [false, true] => -self.curve.winding(p),
            _ => 0.0,
        }
    }
}

/// Nodes of one edge in its direction, both ends included, and the points in the middle of its pieces.
pub(crate) struct Divided {
    pub nodes: Vec<Point<2>>,
    pub middles: Vec<Point<2>>,
}

/// Limits of the size everywhere.
pub(crate) struct Sizes<'a> {
    pub largest: f64,
    pub growth: f64,
    /// The points of refinement, and what else is wanted.
    pub field: &'a SizeField<2>,
    /// Long edges within a face are halved.
    pub binding: bool,
}

impl Sizes<'_> {
    /// The size that the whole outline and the field allow at a place.
    pub fn near(&self, p: Point<2>) -> f64 {
        self.field.below(self.largest, p)
    }

    /// Refuses faces (number, area, largest size) in which the sizes ask for more corners of cells than [`MOST_VERTICES`].
    ///
    /// A rough lower bound from the sizes of the faces and of the points of refinement.
    pub fn few_enough(
        &self,
        ribs: &[Rib],
        faces: &[(usize, f64, f64)],
        refine: &[SizePoint],
    ) -> Result<(), MeshError> {
        // Each corner of equilateral triangles has √3/2 h² of the area.
        let corners = |area: f64, size: f64| 2.0 / 3.0_f64.sqrt() * area / (size * size);
        let within = |p: Point<2>| {
            let turns = |face: usize| ribs.iter().map(|rib| rib.winding(face, p)).sum::<f64>();
            faces.iter().any(|&(face, ..)| turns(face) > PI)
        };
        // A share of each disc of refinement, by the middles of 20 × 20 squares.
        let of_disc = |point: &SizePoint| {
            let step = point.radius / 10.0;
            let places = (0..400).map(|k| [k % 20, k / 20].map(|i| (f64::from(i) - 9.5) * step));
            let inside = places.filter(|&d| {
                d[0].hypot(d[1]) < point.radius && within(add_scaled(point.at, 1.0, d))
            });
            let area = inside.count() as f64 * step * step;
            corners(area, point.size.min(self.largest))
        };
        let discs = refine.iter().map(of_disc).fold(0.0, f64::max);
        let plain = faces.iter().map(|&(_, area, size)| corners(area, size));
        let wanted = plain.sum::<f64>().max(discs);
        match wanted > MOST_VERTICES as f64 {
            true => Err(MeshError::TooLarge {
                nodes: wanted.min(u64::MAX as f64) as u128,
                most: MOST_VERTICES,
            }),
            false => Ok(()),
        }
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
        let wanted = |curve: &Curve, t: f64, filled: [bool; 2]| {
            let x = curve.point(t);
            let mut h = own[index].min(sizes.near(x));
            for (other, &size) in own.iter().enumerate() {
                let far = box_distance(x, boxes[other]);
                let wall = !rib.meets(&ribs[other]);
                let least = size + sizes.growth * far;
                if other == index || (least >= h && (!wall || far >= h)) {
                    continue;
                }
                let y = ribs[other].curve.nearest(x);
                let away = distance(x, y);
                h = h.min(size + sizes.growth * away);
                let beside = dot(sub(y, x), curve.left(t));
                if wall && (filled[0] && beside > 0.0 || filled[1] && beside < 0.0) {
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
    let widest = rib.curve.arc.map(|arc| rib.widest * arc.radius);
    let size = rib.size.min(widest.unwrap_or(f64::INFINITY));
    length / whole(length / size)
}

/// The number of pieces for a real number; rounding does not add a piece.
fn whole(pieces: f64) -> f64 {
    (pieces - 1e-6).ceil().max(1.0)
}

fn box_distance(x: Point<2>, (low, high): (Point<2>, Point<2>)) -> f64 {
    let outside = |d: usize| (low[d] - x[d]).max(x[d] - high[d]).max(0.0);
    outside(0).hypot(outside(1))
}

/// Samples of h so close that it changes little between them; `wanted` gets the faces filled on the left and right of the
/// curve.
fn profile(
    rib: &Rib,
    wanted: impl Fn(&Curve, f64, [bool; 2]) -> f64,
    most: usize,
) -> Option<Profile> {
    let [left, right] = rib.faces.map(|face| face.is_some());
    let (curve, filled) = match rib.curve.is_canonical() {
        true => (rib.curve, [left, right]),
        false => (rib.curve.reversed(), [right, left]),
    };
    let length = curve.length();
    if rib.pieces.is_some() {
        let size = own_size(rib);
        let samples = vec![(0.0, size), (1.0, size)];
        return Some(Profile { samples });
    }
    let at = |t: f64| (t, wanted(&curve, t, filled));
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

/// Lets h grow by at most `growth` per length along the edges and from edge to edge at their corners. An edge with a given
/// number of pieces keeps its own.
fn limit_growth(ribs: &[Rib], profiles: &mut [Profile], growth: f64) {
    let corners = ribs.iter().flat_map(|rib| rib.ends).max();
    let mut least = vec![f64::INFINITY; corners.map_or(0, |corner| corner + 1)];
    loop {
        let mut changed = false;
        for (rib, profile) in ribs.iter().zip(&mut *profiles) {
            if let ([from, to], [first, .., last]) = (canonical_ends(rib), &profile.samples[..]) {
                for (corner, h) in [(from, first.1), (to, last.1)] {
                    changed |= h < least[corner];
                    least[corner] = least[corner].min(h);
                }
            }
        }
        if !changed {
            return;
        }
        for (rib, profile) in ribs.iter().zip(&mut *profiles) {
            if rib.pieces.is_none() {
                let ends = canonical_ends(rib).map(|corner| least[corner]);
                profile.limit(ends, rib.curve.length(), growth);
            }
        }
    }
}

/// The corners that an edge joins, in its canonical direction.
fn canonical_ends(rib: &Rib) -> [usize; 2] {
    match rib.curve.is_canonical() {
        true => rib.ends,
        false => [rib.ends[1], rib.ends[0]],
    }
}

impl Profile {
    /// Lets h grow by at most `growth` per length from its values at both ends and from each sample to the next.
    fn limit(&mut self, ends: [f64; 2], length: f64, growth: f64) {
        let limited = |h: f64, allowed: f64| match allowed < h * (1.0 - SAME_SIZE) {
            true => allowed,
            false => h,
        };
        let mut before = (0.0, ends[0]);
        for sample in &mut self.samples {
            let allowed = before.1 + growth * ((sample.0 - before.0) * length);
            sample.1 = limited(sample.1, allowed);
            before = *sample;
        }
        let mut behind = (1.0, ends[1]);
        for sample in self.samples.iter_mut().rev() {
            let allowed = behind.1 + growth * ((behind.0 - sample.0) * length);
            sample.1 = limited(sample.1, allowed);
            behind = *sample;
        }
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
