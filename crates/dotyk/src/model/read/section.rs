//! Section forces N, V, M of bodies with two long sides: the cuts, the external forces, and their resultant on the part ahead of a cut.
//! For the signs see `nouns/section.rs`.
//!
//! The resultant of several bodies is the sum of those of all whose cells the cut divides (`fem/cut.rs`). The forces of a contact between
//! two of them are inner ones, not among the forces ahead, H f: of −Σ(φ − H)f its nodal forces, which are known, remain, −Σφ f, and no
//! traction is made of them. Their sum is zero where φ raises all or none of its nodes. Where two bodies meet at a cut it divides the one
//! that begins there; where it lies in the gap of an open joint, the forces of the joint are all that it divides.
//!
//! In space the strip is that of the profiles of its bodies (`mesh/extruded.rs`), and a cut goes all along them.

use crate::fem::{Ahead, Along, Analysis, Body, Push, Resultant, Sums};
use crate::geometry::{Groups, Point, add_scaled, dot, padded, sub};
use crate::mesh::{
    Axes, Cut, ExtrudedError, Facet, Located, Mesh, Strip, StripError, direction, extent, levels,
    locate_all, profile,
};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::{Model, Place};
use crate::model::nouns::presence::{Absent, Stage};
use crate::model::nouns::section::{
    Across, Extrusion, Section, SectionError, SectionSolution, Station, Stations,
};
use crate::model::nouns::solution::BodySolution;
use crate::model::read::fields::support_forces;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, row_ranges};
use crate::model::system::displaced::Displaced;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::sync::Arc;

/// The cuts of a section, which do not change from step to step.
pub(crate) struct Laid<const D: usize> {
    lines: Lines<D>,
    /// All its bodies are there: where the cut passes through none of them, nothing is borne.
    whole: bool,
    /// With axial symmetry, for each cut.
    hoops: Vec<Vec<OnCut<D>>>,
}

/// The cuts of a section, and what they go along.
struct Lines<const D: usize> {
    cuts: Vec<Cut>,
    length: f64,
    closed: bool,
    reach: Reach<D>,
}

/// The axes of cuts, and how far bodies in space go along the third of them.
struct Reach<const D: usize> {
    axes: Axes<D>,
    along: Along,
    ends: Option<[f64; 2]>,
}

/// A place in a body.
type Within<const D: usize> = (usize, Located<D>);

/// A place on a cut, the part of the cut before it, and its weight; the sum of the weights is the length of the cut.
type OnCut<const D: usize> = (Option<Within<D>>, f64, f64);

impl<const D: usize> Section<D> {
    /// Its stations on the middle line of its bodies, which are some of a model's.
    ///
    /// Errors: sides that are not two long sides; stations beside the bodies; bars outside of the section; in space, bodies that are
    /// not extruded.
    pub fn check(&self, bodies: &[Body<D>]) -> Result<(), SectionError> {
        self.cuts(bodies, &[]).map(|_| ())
    }

    /// The profiles of its bodies in the plane of its cuts; in the plane these are the bodies themselves.
    ///
    /// Errors: bodies in space that are not extruded.
    pub fn profiles<'m>(
        &self,
        bodies: &'m [Body<D>],
    ) -> Result<Vec<Cow<'m, Mesh<2>>>, SectionError> {
        let axes = self.reach(bodies, &[])?.axes;
        let own = self.bodies.iter().map(|body| &*bodies[body.0].mesh);
        own.map(|mesh| Ok(in_plane(mesh, &axes)?)).collect()
    }

    fn cuts(&self, bodies: &[Body<D>], absent: &[Absent<D>]) -> Result<Lines<D>, SectionError> {
        let own: BTreeSet<usize> = self.bodies.iter().map(|body| body.0).collect();
        if own.is_empty() || own.len() < self.bodies.len() {
            return Err(SectionError::Bodies);
        }
        let thicknesses = self.bodies.iter().map(|body| bodies[body.0].thickness);
        let first = bodies[self.bodies[0].0].thickness;
        if let Some(other) = thicknesses.into_iter().find(|&other| other != first) {
            return Err(SectionError::Thicknesses([first, other]));
        }
        let present = self.bodies.iter().map(|body| &*bodies[body.0].mesh);
        let all: Vec<&Mesh<D>> = present.chain(absent.iter().map(|a| &*a.mesh)).collect();
        let reach = self.reach(bodies, absent)?;
        let profiles = all.iter().map(|mesh| in_plane(mesh, &reach.axes));
        let profiles: Vec<Cow<'_, Mesh<2>>> = profiles.collect::<Result<_, _>>()?;
        let meshes: Vec<&Mesh<2>> = profiles.iter().map(|profile| &**profile).collect();
        let line = |k: usize| -> Result<Vec<(&Mesh<2>, &str)>, SectionError> {
            let own = self.sides[k].iter().map(|side| {
                let place = self.bodies.iter().position(|body| *body == side.body);
                Ok((
                    meshes[place.ok_or(SectionError::Beside(k))?],
                    side.side.as_str(),
                ))
            });
            let gone = absent.iter().zip(&meshes[self.bodies.len()..]);
            let gone = gone.flat_map(|(absent, mesh)| {
                absent.sides[k]
                    .iter()
                    .map(|side| Ok((*mesh, side.as_str())))
            });
            let all = own.chain(gone).collect::<Result<Vec<_>, SectionError>>()?;
            match all.is_empty() {
                true => Err(SectionError::Beside(k)),
                false => Ok(all),
            }
        };
        let lines = [line(0)?, line(1)?];
        self.check_openings(&lines, (bodies, absent), &reach)?;
        let strip = Strip::between([&lines[0], &lines[1]])?;
        let length = strip.length();
        let cuts: Vec<Cut> = match &self.stations {
            Stations::Number(0 | 1) => return Err(SectionError::TooFew),
            Stations::Number(number) => {
                let step = length / (number - 1) as f64;
                (0..*number).map(|k| strip.at(k as f64 * step)).collect()
            }
            Stations::Points(points) => {
                let found = points.iter().enumerate().map(|(index, point)| {
                    let [x, y, z] = reach.axes.local(*point);
                    let off = || SectionError::Off {
                        index,
                        point: point.to_vec(),
                    };
                    let beyond = |[from, to]: [f64; 2]| {
                        let near = ON_BORDER * (to - from);
                        z < from - near || z > to + near
                    };
                    match reach.ends.is_some_and(beyond) {
                        true => Err(off()),
                        false => strip.nearest([x, y]).ok_or_else(off),
                    }
                });
                found.collect::<Result<_, _>>()?
            }
        };
        if let Some((index, at)) = within(&meshes, &cuts) {
            return Err(SectionError::NotThrough { index, at });
        }
        let layers = self
            .capacity
            .iter()
            .flat_map(|capacity| capacity.reinforcement.iter());
        for (layer, bar) in layers.enumerate() {
            if let Some(cut) = cuts.iter().find(|cut| bar.depth > cut.thickness()) {
                return Err(SectionError::Depth {
                    layer,
                    depth: bar.depth,
                    thickness: cut.thickness(),
                    at: cut.middle(),
                });
            }
        }
        Ok(Lines {
            length,
            closed: strip.closed(),
            reach,
            cuts,
        })
    }

    /// The sides along one of its long sides, of bodies present or not.
    fn sides_along<'m>(
        &'m self,
        long: usize,
        (bodies, absent): (&'m [Body<D>], &'m [Absent<D>]),
    ) -> impl Iterator<Item = (&'m Mesh<D>, &'m str)> {
        let own = self.sides[long].iter();
        let own = own.map(|own| (&*bodies[own.body.0].mesh, own.side.as_str()));
        let gone = absent.iter().flat_map(move |gone| {
            let sides = gone.sides[long].iter();
            sides.map(|side| (&*gone.mesh, side.as_str()))
        });
        own.chain(gone)
    }

    /// Refuses openings in a long side where forces are told at places along the axis: its area is less than that of its profile, carried
    /// along.
    fn check_openings(
        &self,
        lines: &[Vec<(&Mesh<2>, &str)>; 2],
        (bodies, absent): (&[Body<D>], &[Absent<D>]),
        reach: &Reach<D>,
    ) -> Result<(), SectionError> {
        let Some([from, to]) = reach.ends.filter(|_| self.places > 1) else {
            return Ok(());
        };
        for (side, line) in lines.iter().enumerate() {
            let all = self.sides_along(side, (bodies, absent));
            let area: f64 = all.map(|(mesh, side)| size_of(mesh, side)).sum();
            let line = line.iter().map(|(mesh, side)| size_of(mesh, side));
            let part = 1.0 - area / (line.sum::<f64>() * (to - from));
            if part > OPENING {
                return Err(ExtrudedError::Openings { side, part }.into());
            }
        }
        Ok(())
    }

    /// The axes of the cuts, and in space the places along the bodies, present or not.
    ///
    /// Errors: bodies in space that are not extruded along one direction, from one end to the other; places closer than cells.
    fn reach(&self, bodies: &[Body<D>], absent: &[Absent<D>]) -> Result<Reach<D>, SectionError> {
        if D == 2 {
            return match (self.axis, self.places) {
                (None, 1) => Ok(Reach {
                    axes: Axes::of_coordinates(),
                    along: Along::default(),
                    ends: None,
                }),
                _ => Err(SectionError::Plane),
            };
        }
        let all = (0..2).flat_map(|long| self.sides_along(long, (bodies, absent)));
        let facets = all.map(|(mesh, side)| {
            let unknown = || StripError::Unknown(side.to_string());
            Ok((mesh, mesh.side(side).ok_or_else(unknown)?))
        });
        let facets: Vec<(&Mesh<D>, &[Facet])> = facets.collect::<Result<_, StripError>>()?;
        let axes = Axes::along(direction(&facets, self.axis)?);
        let present = self.bodies.iter().map(|body| &bodies[body.0].mesh);
        let mut extents = present
            .chain(absent.iter().map(|a| &a.mesh))
            .map(|mesh| extent(mesh, axes.axis()));
        let ends @ [from, to] = extents.next().ok_or(SectionError::Bodies)?;
        let apart = |a: f64, b: f64| (a - b).abs() > ON_BORDER * (to - from);
        if let Some(other) = extents.find(|other| apart(other[0], from) || apart(other[1], to)) {
            return Err(ExtrudedError::Lengths(ends, other).into());
        }
        if self.places == 0 {
            return Err(SectionError::NoPlace);
        }
        let (mut places, mut knots) = (Vec::new(), Vec::new());
        if self.places > 1 {
            let step = (to - from) / (self.places - 1) as f64;
            places.extend((0..self.places).map(|k| from + k as f64 * step));
            knots = match levels(&facets, axes.axis()) {
                Ok(levels) => levels,
                Err(cells) if cells > (1.0 + ON_BORDER) * step => {
                    return Err(ExtrudedError::Finer { step, cells }.into());
                }
                Err(_) => places.clone(),
            };
        }
        let middle = 0.5 * (from + to);
        Ok(Reach {
            axes,
            along: Along {
                middle,
                levels: knots,
                places,
            },
            ends: Some(ends),
        })
    }
}

/// Length or area of a side.
fn size_of<const D: usize>(mesh: &Mesh<D>, side: &str) -> f64 {
    let facets = mesh.side(side).unwrap_or(&[]).iter();
    facets.map(|facet| mesh.facet_size(*facet)).sum()
}

/// A mesh of the plane, or the profile of one in space.
fn in_plane<'m, const D: usize>(
    mesh: &'m Mesh<D>,
    axes: &Axes<D>,
) -> Result<Cow<'m, Mesh<2>>, ExtrudedError> {
    match mesh.in_plane() {
        Some(plane) => Ok(Cow::Borrowed(plane)),
        None => profile(mesh, axes).map(Cow::Owned),
    }
}

/// A cut divides the body if this distance beyond its end, on its line and on both sides of it, is outside; relative to the thickness.
const BEYOND: f64 = 0.15;

/// A long side has openings where this part of it is missing: facets that are not flat differ by less.
const OPENING: f64 = 0.01;

/// A point counts as one of the body up to this distance from a cell, in reference coordinates: rounding of its border. Beside flat cells
/// a larger one would reach far.
const ON_BORDER: f64 = 1e-6;

/// The first cut beyond whose end the body goes on, and that end. A face along the line of the cut has the body on one side,
/// and beyond a re-entrant corner there is no body.
fn within(meshes: &[&Mesh<2>], cuts: &[Cut]) -> Option<(usize, [f64; 2])> {
    let around = cuts.iter().flat_map(|cut| {
        let reach = BEYOND * cut.thickness();
        let ends = [(cut.first, reach), (cut.second, -reach)];
        ends.map(|(end, out)| {
            let beyond = add_scaled(end, out, cut.toward_first());
            [reach, 0.0, -reach].map(|side| add_scaled(beyond, side, cut.along()))
        })
    });
    let around: Vec<[Point<2>; 3]> = around.collect();
    let mut found = vec![false; 3 * around.len()];
    for mesh in meshes {
        let places = locate_all(mesh, around.as_flattened());
        let each = found.iter_mut().zip(&places);
        let inside = |place: &Located<2>| place.outside < ON_BORDER;
        each.for_each(|(found, place)| *found |= place.as_ref().is_some_and(inside));
    }
    let inside = found
        .chunks(3)
        .position(|places| places.iter().all(|found| *found))?;
    let cut = &cuts[inside / 2];
    let end = if inside % 2 == 0 {
        cut.first
    } else {
        cut.second
    };
    Some((inside / 2, end))
}

/// The cuts of all sections of a stage, before the solution; they are those of all its bodies, present or not.
///
/// Errors: those of [`Section::check`], with the section's name.
pub(crate) fn lay_out<const D: usize>(stage: &Stage<'_, D>) -> Result<Vec<Laid<D>>, Error<D>> {
    let model = stage.model.as_ref();
    let laid = model.sections.iter().enumerate().map(|(k, section)| {
        let absent = stage.missing.get(k).map_or(&[][..], Vec::as_slice);
        let cuts = section.cuts(&model.bodies, absent);
        let lines = cuts.map_err(|source| Error::Section {
            section: section.name.clone(),
            source,
        })?;
        let bodies: Vec<usize> = section.bodies.iter().map(|body| body.0).collect();
        let hoops = match model.analysis {
            Analysis::Axisymmetric => {
                let places = lines.cuts.iter().map(|cut| places_on(model, &bodies, cut));
                places.collect()
            }
            _ => Vec::new(),
        };
        Ok(Laid {
            lines,
            whole: absent.is_empty(),
            hoops,
        })
    });
    laid.collect()
}

/// Parts of a cut, each integrated by a rule of three points.
const PARTS: usize = 16;

/// Places across a cut in these bodies: each with the part of the cut before it, from its first side, and a weight. Several bodies are
/// integrated one by one: their stresses jump from one to the next.
fn places_on<const D: usize>(model: &Model<D>, bodies: &[usize], cut: &Cut) -> Vec<OnCut<D>> {
    let step = sub(cut.second, cut.first);
    // Gauss's three points on [0, 1]
    let reach = 0.15_f64.sqrt();
    let rule = [
        (0.5 - reach, 5.0 / 18.0),
        (0.5, 8.0 / 18.0),
        (0.5 + reach, 5.0 / 18.0),
    ];
    let mut ends = vec![0.0, 1.0];
    if bodies.len() > 1 {
        ends.extend(
            bodies
                .iter()
                .flat_map(|&body| borders(&model.bodies[body].mesh, cut)),
        );
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|b, a| *b - *a < ON_BORDER);
    }
    let mut places: Vec<(f64, f64)> = Vec::new();
    for piece in ends.windows(2) {
        let length = piece[1] - piece[0];
        let parts = (0..PARTS)
            .flat_map(|k| rule.map(|(x, w)| ((k as f64 + x) / PARTS as f64, w / PARTS as f64)));
        places.extend(parts.map(|(x, w)| (piece[0] + length * x, length * w)));
    }
    let points = places.iter().map(|(x, _)| {
        let at = padded(add_scaled(cut.first, *x, step));
        std::array::from_fn(|i| at[i])
    });
    let points: Vec<Point<D>> = points.collect();
    let mut found: Vec<Option<Within<D>>> = vec![None; points.len()];
    for &body in bodies {
        let own = locate_all(&model.bodies[body].mesh, &points);
        for (best, own) in found.iter_mut().zip(own) {
            // beside a cell is not within it
            let outside = best
                .as_ref()
                .map_or(f64::INFINITY, |(_, best)| best.outside);
            if let Some(own) = own.filter(|own| own.outside < outside) {
                *best = Some((body, own));
            }
        }
    }
    let all = found.into_iter().zip(places);
    all.map(|(place, (x, w))| (place, x, w * cut.thickness()))
        .collect()
}

/// Where a cut crosses the boundary of a body, as parts of the cut.
fn borders<const D: usize>(mesh: &Mesh<D>, cut: &Cut) -> Vec<f64> {
    let (step, along) = (sub(cut.second, cut.first), cut.along());
    let squared = dot(step, step);
    let crossing = |facet: Facet| {
        let [a, b] = [-1.0, 1.0].map(|xi| {
            let at = mesh.facet_point(facet, &[xi]);
            sub([at[0], at[1]], cut.first)
        });
        let (from, to) = (dot(a, along), dot(b, along));
        if from * to > 0.0 || from == to {
            return None;
        }
        let at = add_scaled(a, from / (from - to), sub(b, a));
        let part = dot(at, step) / squared;
        (0.0..=1.0).contains(&part).then_some(part)
    };
    mesh.boundary_facets()
        .into_iter()
        .filter_map(crossing)
        .collect()
}

/// External forces on the bodies of a section: supports of sides, contacts, couples, and beds that only press.
pub(crate) struct Exerted<const D: usize> {
    /// By body, spread over its sides.
    on: BTreeMap<usize, Vec<Push<D>>>,
    /// Of contacts between two of the bodies: the forces of each multiplier.
    between: Vec<Vec<Pushed<D>>>,
}

/// Body, node, and force on it.
type Pushed<const D: usize> = (usize, usize, Point<D>);

/// The external forces of each section under forces `lambda` (m,). Contacts with common nodes count as one, the force there is that of
/// both, but for those between two bodies of the section: at the corner of a joint and a long side each has its own.
pub(crate) fn exerted<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    lambda: &[f64],
) -> Vec<Arc<Exerted<D>>> {
    let conditions = &condensed.conditions;
    let mut together = Groups::new(conditions.len());
    for (contact, condition) in conditions.iter().enumerate() {
        for sharer in &condition.touch.sharers {
            together.join(contact, sharer.at.0);
        }
    }
    let first: Vec<usize> = (0..conditions.len()).map(|k| together.first(k)).collect();
    let implied = implied_at(conditions);
    let of_bodies = |own: &BTreeSet<usize>| {
        let inner = |condition: &Condition<D>| {
            let mortar = condition.mortar.as_ref();
            let both = [Some(&condition.nonmortar), mortar];
            let there = |side: Option<&SideRef>| side.is_some_and(|s| own.contains(&s.body.0));
            condition.contact().is_some() && both.into_iter().all(there)
        };
        let mut exerted = Exerted {
            on: BTreeMap::new(),
            between: Vec::new(),
        };
        for &of in own {
            let (body, loaded) = (&model.bodies[of], &condensed.bodies[of]);
            let mut supports = vec![Push::default(); body.supports.len()];
            for (support, node, force) in support_forces(loaded, &displaced.states[of].reactions) {
                if let Place::Side(side) = &body.supports[support].place {
                    supports[support].sides.insert(side.clone());
                    supports[support].add(node, force);
                }
            }
            exerted.on.insert(of, supports);
        }
        let mut spread: Spread<D> = BTreeMap::new();
        for (place, (rows, condition)) in row_ranges(conditions).enumerate() {
            if condition.source.member().is_some() {
                continue;
            }
            let forces = condition.forces(&lambda[rows]);
            if inner(condition) {
                exerted.between.extend(pairs(condition, &forces));
                continue;
            }
            let sides = [Some(&condition.nonmortar), condition.mortar.as_ref()];
            let ends = condition.ends().zip(sides);
            for ((of, rows), side) in ends.filter(|((of, _), _)| own.contains(of)) {
                let Some(side) = side else { continue };
                let push = spread.entry((of, first[place])).or_default();
                push.sides.insert(side.side.clone());
                for (row, force) in rows.iter().zip(&forces) {
                    row.iter()
                        .for_each(|&(node, c)| push.add(node, c.map(|c| -force * c)));
                }
            }
        }
        for condition in conditions.iter().filter(|condition| inner(condition)) {
            let evened = evened(model, condition, &implied, &mut spread);
            exerted.between.extend(evened);
        }
        for ((of, _), push) in spread {
            exerted.on.entry(of).or_default().push(push);
        }
        exerted
    };
    let mut known: BTreeMap<BTreeSet<usize>, Arc<Exerted<D>>> = BTreeMap::new();
    let sections = model.sections.iter().map(|section| {
        let own: BTreeSet<usize> = section.bodies.iter().map(|body| body.0).collect();
        let exerted = known
            .entry(own)
            .or_insert_with_key(|own| Arc::new(of_bodies(own)));
        Arc::clone(exerted)
    });
    sections.collect()
}

/// Forces of contacts by body and group of contacts with common nodes.
type Spread<const D: usize> = BTreeMap<(usize, usize), Push<D>>;

/// Bodies and nodes of conditions without a multiplier, because others imply them.
fn implied_at<const D: usize>(conditions: &[Condition<D>]) -> BTreeSet<(usize, usize)> {
    let mut nodes = BTreeSet::new();
    for condition in conditions {
        let mortar = condition.mortar.as_ref().map(|side| side.body.0);
        let bodies = [Some(condition.nonmortar.body.0), mortar];
        for implied in &condition.interface.implied {
            for (of, row) in bodies.into_iter().zip(&implied.rows) {
                nodes.extend(
                    of.into_iter()
                        .flat_map(|of| row.iter().map(move |&(j, _)| (of, j))),
                );
            }
        }
    }
    nodes
}

/// Forces between two bodies of a section that go through a third one, at places of a contact between them; those of their other contacts
/// become what remains.
///
/// Where both sides of a joint are tied to the ground at one place, one of the three conditions follows from the others, and has no
/// multiplier: the force of the joint may go into the ground beside it and out of it again, and by f and g on the two nodes nothing tells
/// how much of them is the ground's, but their sum. It is divided between them as their facets are long, so that the traction of the ground
/// is even; the rest is the joint's.
fn evened<const D: usize>(
    model: &Model<D>,
    condition: &Condition<D>,
    implied: &BTreeSet<(usize, usize)>,
    spread: &mut Spread<D>,
) -> Vec<Vec<Pushed<D>>> {
    let Some(mortar) = &condition.mortar else {
        return Vec::new();
    };
    let bodies = [condition.nonmortar.body.0, mortar.body.0];
    let mut pairs = Vec::new();
    for place in &condition.interface.nodes {
        let mut opposite = place.opposite.iter();
        let Some(&(opposite, _)) = opposite.find(|(_, n)| (n - 1.0).abs() < ON_BORDER) else {
            continue;
        };
        let nodes = [(bodies[0], place.node), (bodies[1], opposite)];
        if !nodes.iter().any(|node| implied.contains(node)) {
            continue;
        }
        // the contacts that push each of them, and the length of its facets there
        let [own, other] = nodes.map(|(of, node)| {
            let mut pushes = spread.iter().filter(|((body, _), _)| *body == of);
            pushes.find_map(|(&key, push)| {
                let length = size_at(&model.bodies[of].mesh, push, node);
                let force = push.forces.get(&node).copied().unwrap_or([0.0; D]);
                (length > 0.0).then_some((key, length, force))
            })
        });
        let (Some((own, length, f)), Some((other, further, g))) = (own, other) else {
            continue;
        };
        let part = length / (length + further);
        let moved: Point<D> = std::array::from_fn(|i| part * (f[i] + g[i]) - f[i]);
        let back = moved.map(|c| -c);
        spread.entry(own).or_default().add(nodes[0].1, moved);
        spread.entry(other).or_default().add(nodes[1].1, back);
        pairs.push(vec![
            (nodes[0].0, nodes[0].1, back),
            (nodes[1].0, nodes[1].1, moved),
        ]);
    }
    pairs
}

/// Size of the facets of some sides at a node, as their middles tell it.
fn size_at<const D: usize>(mesh: &Mesh<D>, push: &Push<D>, node: usize) -> f64 {
    let facets: BTreeSet<Facet> = {
        let sides = push.sides.iter().filter_map(|side| mesh.side(side));
        sides.flatten().copied().collect()
    };
    let at_node = |facet: &&Facet| mesh.facet_nodes(**facet).any(|own| own as usize == node);
    let at_node = facets.iter().filter(at_node);
    at_node.map(|facet| mesh.facet_size(*facet)).sum()
}

/// Forces of a contact between two bodies, by multipliers.
fn pairs<const D: usize>(condition: &Condition<D>, forces: &[f64]) -> Vec<Vec<Pushed<D>>> {
    let mut all = vec![Vec::new(); forces.len()];
    for (of, rows) in condition.ends().take(2) {
        for ((row, force), pair) in rows.iter().zip(forces).zip(&mut all) {
            let own = row.iter();
            pair.extend(own.map(|&(node, c)| (of, node, c.map(|c| -force * c))));
        }
    }
    all
}

/// The forces of all sections in a solution of bodies; `exerted` are those of [`exerted`].
///
/// Errors: a group of cells without a material; an initial stress or strain that is not finite.
pub(crate) fn section_forces<const D: usize>(
    model: &Model<D>,
    (condensed, laid): (&Condensed<D>, &[Laid<D>]),
    (bodies, exerted): (&[BodySolution<D>], &[Arc<Exerted<D>>]),
) -> Result<Vec<SectionSolution>, Error<D>> {
    let asked = model.sections.iter().zip(laid).zip(exerted);
    let solved = asked.map(|((section, laid), exerted)| {
        let (lines, reach) = (&laid.lines, &laid.lines.reach);
        let in_body = |of: usize| move |source| Error::in_body(&model.bodies[of], source);
        let mut ahead: BTreeMap<usize, Ahead<'_, D>> = BTreeMap::new();
        for (&of, pushes) in &exerted.on {
            let history = &condensed.bodies[of].system.history;
            let own = Ahead::new(
                (&model.bodies[of], history, model.analysis),
                condensed.time,
                &bodies[of].displacement,
                (pushes, &bodies[of].member_forces),
                (reach.axes, &reach.along),
            );
            ahead.insert(of, own.map_err(in_body(of))?);
        }
        let width = |cut: &Cut| match model.analysis {
            Analysis::Axisymmetric => 2.0 * PI * cut.middle()[0],
            _ if reach.along.places.is_empty() => match reach.ends {
                Some([from, to]) => to - from,
                None => model.bodies[section.bodies[0].0].thickness,
            },
            // they are per length already
            _ => 1.0,
        };
        let (mut stations, mut means) = (vec![Vec::new(); reach.along.count()], Vec::new());
        for (k, cut) in lines.cuts.iter().enumerate() {
            let mut sum = laid.whole.then(|| Sums::new(&reach.along, cut));
            let mut layers = BTreeMap::new();
            for (&of, ahead) in &ahead {
                let layer = ahead.layer(cut);
                if !layer.is_empty() {
                    let own = ahead.of(cut, &layer).map_err(in_body(of))?;
                    sum.get_or_insert_with(|| Sums::new(&reach.along, cut))
                        .join(&own);
                }
                layers.insert(of, layer);
            }
            for pair in &exerted.between {
                let risen = || pair.iter().filter(|(of, node, _)| layers[of].rises(*node));
                if (1..pair.len()).contains(&risen().count())
                    && through((model, &reach.axes), cut, pair)
                {
                    let sum = sum.get_or_insert_with(|| Sums::new(&reach.along, cut));
                    risen().for_each(|(of, node, force)| ahead[of].push(*node, *force, sum));
                }
            }
            let there = sum.is_some();
            if let (Some([from, to]), false) = (reach.ends, reach.along.places.is_empty()) {
                let whole = sum.as_ref().map_or(Resultant::nowhere(), Sums::whole);
                means.push(reach.station(cut, None, whole, to - from));
            }
            let hoop = laid.hoops.get(k).map(|places| hoop_forces(places, bodies));
            let hoop = hoop.map(|hoop| hoop.map(|own| if there { own } else { f64::NAN }));
            let nowhere = Resultant::nowhere();
            let resultants = sum.map_or(vec![nowhere; stations.len()], Sums::values);
            for (place, (own, resultant)) in stations.iter_mut().zip(resultants).enumerate() {
                let mut station = reach.station(cut, Some(place), resultant, width(cut));
                station.hoop = hoop;
                station.utilisation = section.capacity.as_ref().map(|capacity| match there {
                    true => capacity.utilisation(station.thickness, station.normal, station.moment),
                    false => f64::NAN,
                });
                own.push(station);
            }
        }
        Ok(SectionSolution {
            name: section.name.clone(),
            length: lines.length,
            closed: lines.closed,
            extrusion: reach.ends.map(|[from, to]| Extrusion {
                axis: padded(reach.axes.axis()),
                length: to - from,
                places: reach.along.count(),
                means,
            }),
            stations: stations.concat(),
        })
    });
    solved.collect()
}

impl<const D: usize> Reach<D> {
    /// The forces of a cut at one of its places along the axis, or of all of it, from the resultant there on a width.
    fn station(
        &self,
        cut: &Cut,
        place: Option<usize>,
        resultant: Resultant,
        width: f64,
    ) -> Station {
        let (middle, first, along) = (cut.middle(), cut.toward_first(), cut.along());
        let (force, moment) = (resultant.force, resultant.moment);
        let of = |vector: [f64; 3], [x, y]: Point<2>| (vector[0] * x + vector[1] * y) / width;
        let across = self.ends.map(|[from, _]| {
            let at = place.and_then(|place| self.along.places.get(place).copied());
            let at = at.unwrap_or(self.along.middle);
            Across {
                point: padded(self.axes.global([middle[0], middle[1], at])),
                along: at - from,
                shear: -force[2] / width,
                moment: self.along.places.is_empty().then(|| of(moment, first)),
                twist: of(moment, along),
            }
        });
        Station {
            s: cut.s,
            point: middle,
            toward_first: first,
            thickness: cut.thickness(),
            normal: of(force, along),
            shear: -of(force, first),
            moment: -moment[2] / width,
            hoop: None,
            across,
            utilisation: None,
        }
    }
}

/// The nodes of a multiplier reach into the cut, and not only into its line elsewhere, as on the other side of a ring. On long facets of a
/// round joint some of them, and their middle, may lie beyond its ends.
fn through<const D: usize>(
    (model, axes): (&Model<D>, &Axes<D>),
    cut: &Cut,
    pair: &[Pushed<D>],
) -> bool {
    let along = pair.iter().map(|(of, node, _)| {
        let [x, y, _] = axes.local(model.bodies[*of].mesh.points()[*node]);
        dot(sub([x, y], cut.middle()), cut.toward_first())
    });
    let [low, high] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    });
    let half = 0.5 * cut.thickness() * (1.0 + ON_BORDER);
    low <= half && high >= -half
}

/// ∫σ_zz and ∫σ_zz y over a cut, from places on it.
fn hoop_forces<const D: usize>(places: &[OnCut<D>], bodies: &[BodySolution<D>]) -> [f64; 2] {
    let thickness: f64 = places.iter().map(|(.., weight)| weight).sum();
    let mut sums = [0.0; 2];
    for (place, x, weight) in places {
        let Some((of, place)) = place else { continue };
        let value = place.interpolate(|node| bodies[*of].stress_in(place.block, node))[2];
        sums[0] += weight * value;
        sums[1] += weight * value * thickness * (0.5 - x);
    }
    sums
}
