//! Section forces N, V, M of bodies with two long sides: the cuts, the external forces, and their resultant on the part ahead of a cut.
//! For the signs see `nouns/section.rs`.
//!
//! The resultant of several bodies is the sum of those of all whose cells the cut divides (`fem/cut.rs`). A contact between two of
//! them acts on both at the ends of one line, and has no resultant on what is ahead, H f: of −Σ(φ − H)f its nodal forces, which are
//! known, remain, −Σφ f, and no traction is made of them. Where two bodies meet at a cut it divides the one that begins there.

use crate::fem::{Ahead, Analysis, Body, Push, Resultant};
use crate::geometry::{Groups, Point, add_scaled, dot, padded, sub};
use crate::mesh::{Cut, Located, Mesh, Strip, locate_all};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::{Model, Place};
use crate::model::nouns::presence::{Absent, Stage};
use crate::model::nouns::section::{Section, SectionError, SectionSolution, Station, Stations};
use crate::model::nouns::solution::BodySolution;
use crate::model::read::fields::support_forces;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, row_ranges};
use crate::model::system::displaced::Displaced;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::sync::Arc;

/// The cuts of a section, which do not change from step to step.
pub(crate) struct Laid<const D: usize> {
    cuts: Vec<Cut>,
    length: f64,
    closed: bool,
    /// With axial symmetry, for each cut: places on it with their bodies, and weights whose sum is its length.
    across: Vec<Vec<(Option<Within<D>>, f64)>>,
}

/// A place in a body.
type Within<const D: usize> = (usize, Located<D>);

impl<const D: usize> Section<D> {
    /// Its stations on the middle line of its bodies, which are some of a model's.
    ///
    /// Errors: sides that are not two long sides; stations beside the bodies; bars outside of the section.
    pub fn check(&self, bodies: &[Body<D>]) -> Result<(), SectionError> {
        self.cuts(bodies, &[]).map(|_| ())
    }

    fn cuts(
        &self,
        bodies: &[Body<D>],
        absent: &[Absent<D>],
    ) -> Result<(Vec<Cut>, f64, bool), SectionError> {
        let own: BTreeSet<usize> = self.bodies.iter().map(|body| body.0).collect();
        if own.is_empty() || own.len() < self.bodies.len() {
            return Err(SectionError::Bodies);
        }
        let thicknesses = self.bodies.iter().map(|body| bodies[body.0].thickness);
        let first = bodies[self.bodies[0].0].thickness;
        if let Some(other) = thicknesses.into_iter().find(|&other| other != first) {
            return Err(SectionError::Thicknesses([first, other]));
        }
        let plane = |mesh: &'_ Arc<Mesh<D>>| mesh.in_plane().is_some();
        let present = self.bodies.iter().map(|body| &bodies[body.0].mesh);
        let all: Vec<&Arc<Mesh<D>>> = present.chain(absent.iter().map(|a| &a.mesh)).collect();
        if !all.iter().all(|mesh| plane(mesh)) {
            return Err(SectionError::Space);
        }
        let meshes: Vec<&Mesh<2>> = all.iter().filter_map(|mesh| mesh.in_plane()).collect();
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
        let strip = Strip::between([&line(0)?, &line(1)?])?;
        let length = strip.length();
        let cuts: Vec<Cut> = match &self.stations {
            Stations::Number(0 | 1) => return Err(SectionError::TooFew),
            Stations::Number(number) => {
                let step = length / (number - 1) as f64;
                (0..*number).map(|k| strip.at(k as f64 * step)).collect()
            }
            Stations::Points(points) => {
                let found = points.iter().enumerate().map(|(index, point)| {
                    let point = [point[0], point[1]];
                    strip
                        .nearest(point)
                        .ok_or(SectionError::Off { index, point })
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
        Ok((cuts, length, strip.closed()))
    }
}

/// A cut divides the body if this distance beyond its end, on its line and on both sides of it, is outside; relative to the thickness.
const BEYOND: f64 = 0.15;

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
        let absent = stage.uncut.get(k).map_or(&[][..], Vec::as_slice);
        let cuts = section.cuts(&model.bodies, absent);
        let (cuts, length, closed) = cuts.map_err(|source| Error::Section {
            section: section.name.clone(),
            source,
        })?;
        let bodies: Vec<usize> = section.bodies.iter().map(|body| body.0).collect();
        let across = match model.analysis {
            Analysis::Axisymmetric => {
                let places = cuts.iter().map(|cut| places_on(model, &bodies, cut));
                places.collect()
            }
            _ => Vec::new(),
        };
        Ok(Laid {
            cuts,
            length,
            closed,
            across,
        })
    });
    laid.collect()
}

/// Parts of a cut, each integrated by a rule of three points.
const PARTS: usize = 16;

/// Places across a cut in these bodies, with their weights.
fn places_on<const D: usize>(
    model: &Model<D>,
    bodies: &[usize],
    cut: &Cut,
) -> Vec<(Option<Within<D>>, f64)> {
    let step = sub(cut.second, cut.first);
    // Gauss's three points on [0, 1]
    let reach = 0.15_f64.sqrt();
    let rule = [
        (0.5 - reach, 5.0 / 18.0),
        (0.5, 8.0 / 18.0),
        (0.5 + reach, 5.0 / 18.0),
    ];
    let parts = (0..PARTS)
        .flat_map(|k| rule.map(|(x, w)| ((k as f64 + x) / PARTS as f64, w / PARTS as f64)));
    let (points, weights): (Vec<Point<D>>, Vec<f64>) = parts
        .map(|(x, w)| {
            let at = padded(add_scaled(cut.first, x, step));
            (std::array::from_fn(|i| at[i]), w * cut.thickness())
        })
        .unzip();
    let mut places: Vec<Option<Within<D>>> = vec![None; points.len()];
    for &body in bodies {
        let found = locate_all(&model.bodies[body].mesh, &points);
        for (place, found) in places.iter_mut().zip(found) {
            *place = place.take().or(found.map(|found| (body, found)));
        }
    }
    places.into_iter().zip(weights).collect()
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
) -> Vec<Exerted<D>> {
    let conditions = &condensed.conditions;
    let mut together = Groups::new(conditions.len());
    for (contact, condition) in conditions.iter().enumerate() {
        for sharer in &condition.touch.sharers {
            together.join(contact, sharer.at.0);
        }
    }
    let first: Vec<usize> = (0..conditions.len()).map(|k| together.first(k)).collect();
    let of_section = |section: &Section<D>| {
        let own: BTreeSet<usize> = section.bodies.iter().map(|body| body.0).collect();
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
        for &of in &own {
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
        let mut spread: BTreeMap<(usize, usize), Push<D>> = BTreeMap::new();
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
        for ((of, _), push) in spread {
            exerted.on.entry(of).or_default().push(push);
        }
        exerted
    };
    model.sections.iter().map(of_section).collect()
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
    (bodies, exerted): (&[BodySolution<D>], &[Exerted<D>]),
) -> Result<Vec<SectionSolution>, Error<D>> {
    let asked = model.sections.iter().zip(laid).zip(exerted);
    let solved = asked.map(|((section, laid), exerted)| {
        let in_body = |of: usize| move |source| Error::in_body(&model.bodies[of], source);
        let mut ahead: BTreeMap<usize, Ahead<'_, D>> = BTreeMap::new();
        for (&of, pushes) in &exerted.on {
            let history = &condensed.bodies[of].system.history;
            let own = Ahead::new(
                (&model.bodies[of], history, model.analysis),
                condensed.time,
                &bodies[of].displacement,
                (pushes, &bodies[of].member_forces),
            );
            ahead.insert(of, own.map_err(in_body(of))?);
        }
        let stations = laid.cuts.iter().enumerate().map(|(k, cut)| {
            let mut sum = None;
            let mut layers = BTreeMap::new();
            for (&of, ahead) in &ahead {
                let layer = ahead.layer(cut);
                if !layer.is_empty() {
                    let own = ahead.of(cut, &layer).map_err(in_body(of))?;
                    sum.get_or_insert(Resultant::default()).join(own);
                }
                layers.insert(of, layer);
            }
            if let Some(sum) = &mut sum {
                for pair in &exerted.between {
                    let mut ends = pair.iter();
                    if ends.any(|(of, node, _)| layers[of].has(*node)) {
                        let risen = pair.iter().filter(|(of, node, _)| layers[of].rises(*node));
                        risen.for_each(|(of, node, force)| ahead[of].push(cut, *node, *force, sum));
                    }
                }
            }
            let (middle, thickness, first) = (cut.middle(), cut.thickness(), cut.toward_first());
            let width = match model.analysis {
                Analysis::Axisymmetric => 2.0 * PI * middle[0],
                _ => model.bodies[section.bodies[0].0].thickness,
            };
            let along = |direction: [f64; 2]| {
                let force = sum.map_or([f64::NAN; 2], |sum| sum.force);
                dot(force, direction) / width
            };
            let moment = sum.map_or(f64::NAN, |sum| -sum.moment / width);
            let normal = along(cut.along());
            let hoop = laid.across.get(k).map(|places| hoop_forces(places, bodies));
            Ok(Station {
                s: cut.s,
                point: middle,
                toward_first: first,
                thickness,
                normal,
                shear: -along(first),
                moment,
                hoop: hoop.map(|hoop| hoop.map(|own| if sum.is_some() { own } else { f64::NAN })),
                utilisation: section.capacity.as_ref().map(|capacity| match sum {
                    Some(_) => capacity.utilisation(thickness, normal, moment),
                    None => f64::NAN,
                }),
            })
        });
        Ok(SectionSolution {
            name: section.name.clone(),
            length: laid.length,
            closed: laid.closed,
            stations: stations.collect::<Result<_, Error<D>>>()?,
        })
    });
    solved.collect()
}

/// ∫σ_zz and ∫σ_zz y over a cut, from places in the order from its first side.
fn hoop_forces<const D: usize>(
    places: &[(Option<Within<D>>, f64)],
    bodies: &[BodySolution<D>],
) -> [f64; 2] {
    let thickness: f64 = places.iter().map(|(_, weight)| weight).sum();
    let parts = PARTS as f64;
    let reach = 0.15_f64.sqrt();
    let mut sums = [0.0; 2];
    for (k, (place, weight)) in places.iter().enumerate() {
        let Some((of, place)) = place else { continue };
        let value = place.interpolate(|node| bodies[*of].stress_in(place.block, node))[2];
        let x = ((k / 3) as f64 + 0.5 + reach * ((k % 3) as f64 - 1.0)) / parts;
        sums[0] += weight * value;
        sums[1] += weight * value * thickness * (0.5 - x);
    }
    sums
}
