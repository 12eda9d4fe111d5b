//! Which facets of two bodies face each other.
//!
//! A facet faces another body where the straight way along its outward normal, forwards through what is open or backwards through an
//! overlap, meets within `reach` a facet there with an opposed normal, and passes through neither of the two bodies (`search.rs`) nor,
//! where it is open, a third one. What it meets faces it, too: a large facet may be seen by a small one alone.
//!
//! Distances are those of the curves that polygons stand for: what polygons miss of them does not count.
//!
//! Without a `reach` the distance is at most a tenth of the diagonal of the smaller body's box, and half of the smallest thickness that
//! either body has behind the facets which face each other within that: of two surfaces of a thin plate the near one counts.

use crate::contact::facing::first_seen;
use crate::contact::search::{Boundary, Hit, Line, NEAR, Screen, SideSearch};
use crate::contact::{ContactError, End};
use crate::geometry::{Point, add_scaled, bounding_box, distance, norm, unit};
use crate::mesh::{Facet, Mesh, Skin};
use rayon::prelude::*;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock};

/// The default of `reach`, in parts of the diagonal of the smaller body's box.
const REACH: f64 = 0.1;

/// `reach` is at most this part of the thickness behind a facet.
const THICKNESS: f64 = 0.5;

/// What facets miss of the curve that the surface of their mesh stands for: those that miss something, and the most.
struct Bows {
    of: BTreeMap<Facet, f64>,
    most: f64,
}

impl Bows {
    fn new<const D: usize>(mesh: &Mesh<D>, facets: &[Facet]) -> Self {
        let skin = Skin::of(mesh);
        let of_facet = |&facet: &Facet| {
            let bows = mesh.facet_nodes(facet).map(|node| skin.bow(node).off);
            let most = bows.fold(0.0, f64::max);
            (most > 0.0).then_some((facet, most))
        };
        let of: BTreeMap<Facet, f64> = facets.iter().filter_map(of_facet).collect();
        let most = of.values().copied().fold(0.0, f64::max);
        Self { of, most }
    }
}

/// The outer surface of a body, or some facets of it that may face others.
struct Outer<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    facets: Vec<Facet>,
    /// Made on first use.
    screen: OnceLock<Arc<Screen<'a, D>>>,
    boundary: Arc<Boundary<'a, D>>,
    bounds: [Point<D>; 2],
    /// Made on first use.
    bows: OnceLock<Bows>,
}

impl<'a, const D: usize> Outer<'a, D> {
    fn of(mesh: &'a Mesh<D>, facets: Vec<Facet>) -> Self {
        Self {
            mesh,
            screen: OnceLock::new(),
            boundary: Arc::new(Boundary::of(mesh)),
            bounds: mesh.bounds(),
            bows: OnceLock::new(),
            facets,
        }
    }

    /// Whether its box, grown by a length, meets another box.
    fn is_near(&self, [low, high]: [Point<D>; 2], length: f64) -> bool {
        let [own_low, own_high] = self.bounds;
        (0..D).all(|d| low[d] <= own_high[d] + length && high[d] >= own_low[d] - length)
    }

    fn bows(&self) -> &Bows {
        self.bows.get_or_init(|| Bows::new(self.mesh, &self.facets))
    }

    fn bow(&self, facet: Facet) -> f64 {
        self.bows().of.get(&facet).copied().unwrap_or(0.0)
    }

    fn most_bow(&self) -> f64 {
        self.bows().most
    }

    fn diagonal(&self) -> f64 {
        distance(self.bounds[0], self.bounds[1])
    }

    /// The search from here for the facets of another one.
    fn search_of(&self, other: &Self) -> SideSearch<'a, D> {
        let screen = || Arc::new(Screen::new(other.mesh, &other.facets));
        let screen = other.screen.get_or_init(screen);
        SideSearch::from_to(&self.boundary, &other.boundary, screen)
    }

    /// Pairs of its facets and facets of another body that face each other within a reach, found from here.
    fn sights(&self, other: &Self, reach: f64, others: &[&Self], sight: Sight) -> Vec<[Facet; 2]> {
        let search = self.search_of(other);
        let met = |&facet: &Facet| {
            let points: Vec<Point<D>> = self.mesh.facet_points(facet).collect();
            let (low, high) = bounding_box(&points);
            if !other.is_near([low, high], reach + self.bow(facet) + other.most_bow()) {
                return None;
            }
            let rounding = NEAR * self.mesh.facet_length(facet);
            let covered = Cell::new(false);
            let hit = first_seen(self.mesh, facet, &search, |line, hit| {
                let near = hit.distance.abs() <= reach + self.bow(facet) + other.bow(hit.facet);
                if covered.get() || !near && sight == Sight::Any {
                    return false;
                }
                let hides = others.iter().any(|o| o.hides(line, hit.distance, rounding));
                covered.set(hides && sight == Sight::Middle);
                near && !hides
            })?;
            Some([facet, hit.facet])
        };
        self.facets.par_iter().filter_map(met).collect()
    }

    /// Its facets that see another side, but for one of `others` between.
    fn hidden_from(&self, other: &Self, others: &[&Self]) -> BTreeSet<Facet> {
        let search = self.search_of(other);
        let hidden = |&facet: &Facet| {
            let rounding = NEAR * self.mesh.facet_length(facet);
            let covered = Cell::new(false);
            let free = first_seen(self.mesh, facet, &search, |line, hit| {
                let hides = others.iter().any(|o| o.hides(line, hit.distance, rounding));
                covered.set(covered.get() || hides);
                !hides
            });
            (free.is_none() && covered.get()).then_some(facet)
        };
        let hidden: Vec<Facet> = self.facets.par_iter().filter_map(hidden).collect();
        hidden.into_iter().collect()
    }

    /// Whether a body stands somewhere on the ways from here to another side.
    fn looks_through(&self, other: &Self, body: &Self) -> bool {
        let search = self.search_of(other);
        self.facets.iter().any(|&facet| {
            let rounding = NEAR * self.mesh.facet_length(facet);
            let hides = |line, hit: Hit| body.hides(line, hit.distance, rounding);
            first_seen(self.mesh, facet, &search, hides).is_some()
        })
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
    sight: Sight,
) -> [Vec<Facet>; 2] {
    if !a.is_near(b.bounds, reach + a.most_bow() + b.most_bow()) {
        return [Vec::new(), Vec::new()];
    }
    let mut faced: [BTreeSet<Facet>; 2] = Default::default();
    for [own, met] in a.sights(b, reach, others, sight) {
        faced[0].insert(own);
        faced[1].insert(met);
    }
    for [own, met] in b.sights(a, reach, others, sight) {
        faced[1].insert(own);
        faced[0].insert(met);
    }
    faced.map(|facets| facets.into_iter().collect())
}

/// How much of a facet must see another body where third ones stand between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// Any part of it: for contacts with the gaps that are there, through a body they stay open.
    Any,
    /// What it sees nearest to its middle: for contacts that count as closed at any distance. They would hold the bodies through the third
    /// one where a facet sees the other body past its edge alone.
    Middle,
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
        let wide = |body: usize| grown(body) + 2.0 * self.0[body].most_bow();
        let low = |body: usize| self.0[body].bounds[0][0] - wide(body);
        let mut ahead: Vec<usize> = bodies.to_vec();
        ahead.sort_by(|&a, &b| low(a).total_cmp(&low(b)));
        let mut open: Vec<usize> = Vec::new();
        let mut pairs = Vec::new();
        for body in ahead {
            open.retain(|&other| self.0[other].bounds[1][0] + wide(other) >= low(body));
            let near = |&&other: &&usize| {
                let bows = self.0[body].most_bow() + self.0[other].most_bow();
                let reach = grown(body).min(grown(other)) + bows;
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
    pub fn faced(
        &self,
        [a, b]: [usize; 2],
        reach: Option<f64>,
        between: &[usize],
        sight: Sight,
    ) -> Faced {
        let pair = [&self.0[a], &self.0[b]];
        let limit = REACH * pair[0].diagonal().min(pair[1].diagonal());
        let wide = reach.unwrap_or(limit);
        let others: Vec<&Outer<'a, D>> = between
            .iter()
            .map(|&k| &self.0[k])
            .filter(|other| pair.iter().all(|body| other.is_near(body.bounds, wide)))
            .collect();
        let facets = faced(pair, wide, &others, sight);
        if reach.is_some() || facets[0].is_empty() {
            return Faced {
                facets,
                reach: wide,
            };
        }
        let thickness = [0, 1].map(|k| pair[k].thickness(&facets[k]));
        let reach = limit.min(THICKNESS * thickness[0].min(thickness[1]));
        let facets = match reach < limit {
            true => faced(pair, reach, &others, sight),
            false => facets,
        };
        Faced { facets, reach }
    }

    /// Whether the box of a body is within a reach of those of two others.
    pub fn is_beside(&self, body: usize, pair: [usize; 2], reach: f64) -> bool {
        let mut pair = pair.iter().map(|&other| self.0[other].bounds);
        pair.all(|bounds| self.0[body].is_near(bounds, reach))
    }

    /// How deep two bodies lie in each other at nodes of their surfaces; zero where their boxes do not meet.
    pub fn depth(&self, pair: [usize; 2]) -> f64 {
        let [a, b] = pair.map(|body| &self.0[body]);
        match a.is_near(b.bounds, 0.0) {
            true => pair_depth([a.mesh, b.mesh]),
            false => 0.0,
        }
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

/// How deep a node on the surface of one of two meshes lies in the other, at most; zero where they do not overlap there.
fn pair_depth<const D: usize>(meshes: [&Mesh<D>; 2]) -> f64 {
    depths(meshes).fold(0.0, f64::max)
}

/// The smallest distance of a node on the surface of either mesh from the surface of the other.
fn pair_distance<const D: usize>(meshes: [&Mesh<D>; 2]) -> f64 {
    let apart = depths(meshes).map(|depth| (-depth).max(0.0));
    apart.fold(f64::INFINITY, f64::min)
}

/// Depths of the nodes on the surface of either of two meshes in the other one, negative outside.
fn depths<'a, const D: usize>(meshes: [&'a Mesh<D>; 2]) -> impl Iterator<Item = f64> + 'a {
    let everywhere = ([f64::NEG_INFINITY; D], [f64::INFINITY; D]);
    [[0, 1], [1, 0]].into_iter().flat_map(move |[own, other]| {
        let surface = Skin::of(meshes[other]).at(meshes[other].points(), everywhere);
        let nodes = Skin::of(meshes[own]).nodes().to_vec();
        let points = meshes[own].points();
        let depth = move |node: u32| surface.depth(points[node as usize]);
        nodes.into_iter().filter_map(depth).map(|(depth, _)| depth)
    })
}

/// The facets of two sides that take part in their contact: those that face each other within a reach, if there is one, and
/// no facet that another body hides from the other side, unless a facet there sees it: a large one may be seen between bodies that hide
/// all that it sees itself. `None`: all of them.
///
/// Errors: an unknown or empty side; sides no facets of which face each other within the reach, or all of which are hidden.
pub fn taking_part<'a, const D: usize>(
    ends: [End<'a, D>; 2],
    reach: Option<f64>,
    others: impl Iterator<Item = (&'a str, &'a Mesh<D>)>,
) -> Result<Option<[Vec<Facet>; 2]>, ContactError> {
    let outer = |end: End<'a, D>| Ok(Outer::of(&end.body.mesh, end.facets()?.to_vec()));
    let pair = [outer(ends[0])?, outer(ends[1])?];
    let corners = pair.each_ref().map(|side| {
        let facets = side.facets.iter();
        let points = facets.flat_map(|&facet| side.mesh.facet_points(facet));
        bounding_box(&points.collect::<Vec<Point<D>>>())
    });
    let (low, high) = bounding_box(&[corners[0].0, corners[0].1, corners[1].0, corners[1].1]);
    let others: Vec<(&str, Outer<'a, D>)> = others
        .map(|(name, mesh)| (name, Outer::of(mesh, Vec::new())))
        .filter(|(_, other)| other.is_near([low, high], 0.0))
        .collect();
    let between: Vec<&Outer<'a, D>> = others.iter().map(|(_, other)| other).collect();
    let [a, b] = &pair;
    if let Some(reach) = reach {
        let facets = faced([a, b], reach, &between, Sight::Any);
        return match facets[0].is_empty() {
            true => Err(ContactError::BeyondReach {
                sides: ends.map(|end| end.name()),
                reach,
            }),
            false => Ok(Some(facets)),
        };
    }
    if between.is_empty() {
        return Ok(None);
    }
    let hidden = [a.hidden_from(b, &between), b.hidden_from(a, &between)];
    if hidden.iter().all(BTreeSet::is_empty) {
        return Ok(None);
    }
    let seen = faced([a, b], f64::INFINITY, &between, Sight::Any);
    if seen[0].is_empty() {
        let hides = |other: &Outer<'a, D>| a.looks_through(b, other) || b.looks_through(a, other);
        return Err(ContactError::Hidden {
            sides: ends.map(|end| end.name()),
            by: others
                .iter()
                .filter(|(_, other)| hides(other))
                .map(|(name, _)| format!("\"{name}\""))
                .collect::<Vec<String>>()
                .join(", "),
        });
    }
    let takes_part = |k: usize, facet: &Facet| {
        !hidden[k].contains(facet) || seen[k].binary_search(facet).is_ok()
    };
    Ok(Some([0, 1].map(|k| {
        let facets = pair[k].facets.iter().copied();
        facets.filter(|facet| takes_part(k, facet)).collect()
    })))
}
