//! Which facets of two bodies face each other.
//!
//! A facet faces another body where the straight way along its outward normal, forwards through what is open or backwards through an
//! overlap, meets within `reach` a facet there with an opposed normal, and passes through neither of the two bodies (`search.rs`) nor,
//! where it is open, a third one. What it meets faces it, too: a large facet may be seen by a small one alone.
//!
//! Without a `reach` the distance is at most a tenth of the diagonal of the smaller body's box, and half of the smallest thickness that
//! either body has behind the facets which face each other within that: of two surfaces of a thin plate the near one counts.

use crate::contact::facing::first_seen;
use crate::contact::search::{Boundary, Line, Screen, SideSearch};
use crate::contact::{ContactError, End};
use crate::geometry::{Point, add_scaled, bounding_box, distance, norm, unit};
use crate::mesh::{Facet, Mesh, Skin};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

/// The default of `reach`, in parts of the diagonal of the smaller body's box.
const REACH: f64 = 0.1;

/// `reach` is at most this part of the thickness behind a facet.
const THICKNESS: f64 = 0.5;

/// Boundaries nearer than this part of a facet to the ends of a way do not count as passed.
const NEAR: f64 = 1e-6;

/// The outer surface of a body, or some facets of it that may face others.
struct Outer<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    facets: Vec<Facet>,
    /// Made on first use.
    screen: OnceLock<Arc<Screen<'a, D>>>,
    boundary: Arc<Boundary<'a, D>>,
    bounds: [Point<D>; 2],
}

impl<'a, const D: usize> Outer<'a, D> {
    fn of(mesh: &'a Mesh<D>, facets: Vec<Facet>) -> Self {
        let (low, high) = bounding_box(mesh.points());
        Self {
            mesh,
            facets,
            screen: OnceLock::new(),
            boundary: Arc::new(Boundary::of(mesh)),
            bounds: [low, high],
        }
    }

    /// Whether its box, grown by a length, meets another box.
    fn is_near(&self, [low, high]: [Point<D>; 2], length: f64) -> bool {
        let [own_low, own_high] = self.bounds;
        (0..D).all(|d| low[d] <= own_high[d] + length && high[d] >= own_low[d] - length)
    }

    fn diagonal(&self) -> f64 {
        distance(self.bounds[0], self.bounds[1])
    }

    /// Pairs of its facets and facets of another body that face each other within a reach, found from here.
    fn sights(&self, other: &Self, reach: f64, others: &[&Self]) -> Vec<[Facet; 2]> {
        let screen = other
            .screen
            .get_or_init(|| Arc::new(Screen::new(other.mesh, &other.facets)));
        let search = SideSearch::from_to(&self.boundary, &other.boundary, screen);
        let sight = |&facet: &Facet| {
            let points: Vec<Point<D>> = self.mesh.facet_points(facet).collect();
            let (low, high) = bounding_box(&points);
            if !other.is_near([low, high], reach) {
                return None;
            }
            let rounding = NEAR * self.mesh.facet_length(facet);
            let hit = first_seen(self.mesh, facet, &search, |line, hit| {
                hit.distance.abs() <= reach
                    && !others.iter().any(|o| o.hides(line, hit.distance, rounding))
            })?;
            Some([facet, hit.facet])
        };
        self.facets.par_iter().filter_map(sight).collect()
    }

    /// Whether the way along a line to a distance passes through this body.
    fn hides(&self, line: Line<D>, length: f64, rounding: f64) -> bool {
        let end = add_scaled(line.start, length, line.direction);
        let (low, high) = bounding_box(&[line.start, end]);
        length > 0.0
            && self.is_near([low, high], rounding)
            && self.boundary.is_between(line, length, rounding)
    }

    /// The smallest thickness behind the middles of some facets.
    fn thickness(&self, facets: &[Facet]) -> f64 {
        let behind = |&facet: &Facet| {
            let centre = self.mesh.facet_kind(facet).domain().centre();
            let normal = unit(self.mesh.outward_normal(facet, &centre))?;
            let rounding = NEAR * self.mesh.facet_length(facet);
            let middle = self.mesh.facet_point(facet, &centre);
            Some(self.boundary.thickness(middle, normal, rounding))
        };
        let all: Vec<f64> = facets.par_iter().filter_map(behind).collect();
        all.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Facets of each of two bodies that face each other within a reach; both ascending. Empty if there are none.
fn faced<'a, const D: usize>(
    [a, b]: [&Outer<'a, D>; 2],
    reach: f64,
    others: &[&Outer<'a, D>],
) -> [Vec<Facet>; 2] {
    if !a.is_near(b.bounds, reach) {
        return [Vec::new(), Vec::new()];
    }
    let mut faced: [BTreeSet<Facet>; 2] = Default::default();
    for [own, met] in a.sights(b, reach, others) {
        faced[0].insert(own);
        faced[1].insert(met);
    }
    for [own, met] in b.sights(a, reach, others) {
        faced[1].insert(own);
        faced[0].insert(met);
    }
    faced.map(|facets| facets.into_iter().collect())
}

/// Bodies among which facets are sought that face each other.
pub struct Neighbours<'a, const D: usize>(Vec<Outer<'a, D>>);

/// What faces each other of two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Faced {
    /// Facets of either, ascending; none where they do not face each other.
    pub facets: [Vec<Facet>; 2],
    /// Within this distance.
    pub reach: f64,
}

impl<'a, const D: usize> Neighbours<'a, D> {
    /// All bodies, by their meshes.
    pub fn of(meshes: impl Iterator<Item = &'a Mesh<D>>) -> Self {
        Self(
            meshes
                .map(|mesh| Outer::of(mesh, mesh.boundary_facets()))
                .collect(),
        )
    }

    /// Pairs of bodies whose boxes are near enough for that, ascending: a sweep along the first axis.
    pub fn candidates(&self, bodies: &[usize], reach: Option<f64>) -> Vec<[usize; 2]> {
        // of two bodies one alone need be grown; either may be the smaller one
        let grown = |body: usize| reach.unwrap_or(REACH * self.0[body].diagonal());
        let low = |body: usize| self.0[body].bounds[0][0] - grown(body);
        let mut ahead: Vec<usize> = bodies.to_vec();
        ahead.sort_by(|&a, &b| low(a).total_cmp(&low(b)));
        let mut open: Vec<usize> = Vec::new();
        let mut pairs = Vec::new();
        for body in ahead {
            open.retain(|&other| self.0[other].bounds[1][0] + grown(other) >= low(body));
            let near = |&&other: &&usize| {
                let reach = grown(body).min(grown(other));
                self.0[other].is_near(self.0[body].bounds, reach)
            };
            let found = open.iter().filter(near);
            pairs.extend(found.map(|&other| [body.min(other), body.max(other)]));
            open.push(body);
        }
        pairs.sort_unstable();
        pairs
    }

    /// The facets of two bodies that face each other within a reach or, without one, within that of the bodies; those of `between`
    /// hide what lies behind them.
    pub fn faced(&self, [a, b]: [usize; 2], reach: Option<f64>, between: &[usize]) -> Faced {
        let pair = [&self.0[a], &self.0[b]];
        let limit = REACH * pair[0].diagonal().min(pair[1].diagonal());
        let wide = reach.unwrap_or(limit);
        let others: Vec<&Outer<'a, D>> = between
            .iter()
            .map(|&k| &self.0[k])
            .filter(|other| pair.iter().all(|body| other.is_near(body.bounds, wide)))
            .collect();
        let facets = faced(pair, wide, &others);
        if reach.is_some() || facets[0].is_empty() {
            return Faced {
                facets,
                reach: wide,
            };
        }
        let thickness = [0, 1].map(|k| pair[k].thickness(&facets[k]));
        let reach = limit.min(THICKNESS * thickness[0].min(thickness[1]));
        let facets = match reach < limit {
            true => faced(pair, reach, &others),
            false => facets,
        };
        Faced { facets, reach }
    }

    /// The nearest two of some pairs of bodies, and the distance of their surfaces at nodes; zero where a node of one lies in the other.
    pub fn nearest(&self, pairs: &[[usize; 2]]) -> Option<([usize; 2], f64)> {
        let apart = |[a, b]: [usize; 2]| {
            let [a, b] = [&self.0[a].bounds, &self.0[b].bounds];
            let gaps: Point<D> =
                std::array::from_fn(|d| (a[0][d] - b[1][d]).max(b[0][d] - a[1][d]).max(0.0));
            norm(gaps)
        };
        let mut pairs: Vec<([usize; 2], f64)> =
            pairs.iter().map(|&pair| (pair, apart(pair))).collect();
        pairs.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut best: Option<([usize; 2], f64)> = None;
        for (pair, least) in pairs {
            if best.is_some_and(|(_, distance)| distance <= least) {
                break;
            }
            let found = pair_distance(pair.map(|k| self.0[k].mesh));
            if best.is_none_or(|(_, distance)| found < distance) {
                best = Some((pair, found));
            }
        }
        best
    }
}

/// The smallest distance of a node on the surface of either mesh from the surface of the other.
fn pair_distance<const D: usize>(meshes: [&Mesh<D>; 2]) -> f64 {
    let skins = meshes.map(Skin::of);
    let everywhere = ([f64::NEG_INFINITY; D], [f64::INFINITY; D]);
    let smallest = |k: usize| {
        let other = skins[1 - k].at(meshes[1 - k].points(), everywhere);
        let nodes = skins[k].nodes().iter();
        let depths = nodes.filter_map(|&node| other.depth(meshes[k].points()[node as usize]));
        depths
            .map(|(depth, _)| (-depth).max(0.0))
            .fold(f64::INFINITY, f64::min)
    };
    smallest(0).min(smallest(1))
}

/// The facets of two sides that face each other within a reach.
///
/// Errors: an unknown or empty side; sides no facets of which face each other within the reach.
pub fn within_reach<'a, const D: usize>(
    ends: [End<'a, D>; 2],
    reach: f64,
) -> Result<[Vec<Facet>; 2], ContactError> {
    let outer = |end: End<'a, D>| Ok(Outer::of(&end.body.mesh, end.facets()?.to_vec()));
    let [a, b] = [outer(ends[0])?, outer(ends[1])?];
    let facets = faced([&a, &b], reach, &[]);
    match facets[0].is_empty() {
        true => Err(ContactError::BeyondReach {
            sides: ends.map(|end| end.name()),
            reach,
        }),
        false => Ok(facets),
    }
}
