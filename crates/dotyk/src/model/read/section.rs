//! Section forces N, V, M of bodies with two long sides: the cuts, the external forces, and their resultant on the part ahead of a cut.
//! For the signs see `nouns/section.rs`.

use crate::fem::{Ahead, Analysis, Body, Push};
use crate::geometry::{Groups, Point, add_scaled, padded, sub};
use crate::mesh::{Cut, Located, Mesh, Strip, locate_all};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Model, Place};
use crate::model::nouns::section::{Section, SectionError, SectionSolution, Station, Stations};
use crate::model::nouns::solution::BodySolution;
use crate::model::read::fields::support_forces;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::row_ranges;
use crate::model::system::displaced::Displaced;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// The cuts of a section, which do not change from step to step.
pub(crate) struct Laid<const D: usize> {
    cuts: Vec<Cut>,
    length: f64,
    closed: bool,
    /// With axial symmetry, for each cut: places on it, and weights whose sum is its length.
    across: Vec<Vec<(Option<Located<D>>, f64)>>,
}

impl<const D: usize> Section<D> {
    /// Its stations on the middle line of a body.
    ///
    /// Errors: sides that are not two long sides; stations beside the body; bars outside of the section.
    pub fn check(&self, body: &Body<D>) -> Result<(), SectionError> {
        self.cuts(body).map(|_| ())
    }

    fn cuts(&self, body: &Body<D>) -> Result<(Vec<Cut>, f64, bool), SectionError> {
        let mesh = body.mesh.in_plane().ok_or(SectionError::Space)?;
        let strip = Strip::between(mesh, &self.sides[0], &self.sides[1])?;
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
        if let Some((index, at)) = within(mesh, &cuts) {
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

/// The first cut beyond whose end the body goes on, and that end. A face along the line of the cut has the body on one side,
/// and beyond a re-entrant corner there is no body.
fn within(mesh: &Mesh<2>, cuts: &[Cut]) -> Option<(usize, [f64; 2])> {
    let around = cuts.iter().flat_map(|cut| {
        let reach = BEYOND * cut.thickness();
        let ends = [(cut.first, reach), (cut.second, -reach)];
        ends.map(|(end, out)| {
            let beyond = add_scaled(end, out, cut.toward_first());
            [reach, 0.0, -reach].map(|side| add_scaled(beyond, side, cut.along()))
        })
    });
    let around: Vec<[Point<2>; 3]> = around.collect();
    let found = locate_all(mesh, around.as_flattened());
    let inside = found
        .chunks(3)
        .position(|places| places.iter().all(Option::is_some))?;
    let cut = &cuts[inside / 2];
    let end = if inside % 2 == 0 {
        cut.first
    } else {
        cut.second
    };
    Some((inside / 2, end))
}

/// The cuts of all sections of a model, before the solution.
///
/// Errors: those of [`Section::check`], with the section's name.
pub(crate) fn lay_out<const D: usize>(model: &Model<D>) -> Result<Vec<Laid<D>>, Error<D>> {
    let laid = model.sections.iter().map(|section| {
        let body = &model.bodies[section.body.0];
        let (cuts, length, closed) = section.cuts(body).map_err(|source| Error::Section {
            section: section.name.clone(),
            source,
        })?;
        let across = match model.analysis {
            Analysis::Axisymmetric => cuts.iter().map(|cut| places_on(body, cut)).collect(),
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

/// Places across a cut with their weights.
fn places_on<const D: usize>(body: &Body<D>, cut: &Cut) -> Vec<(Option<Located<D>>, f64)> {
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
    locate_all(&body.mesh, &points)
        .into_iter()
        .zip(weights)
        .collect()
}

/// External forces on each body with sections, under forces `lambda` (m,): supports of sides, contacts, couples, and beds that only
/// press. Contacts with common nodes count as one: the force there is that of both.
pub(crate) fn pushes<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    lambda: &[f64],
) -> BTreeMap<usize, Vec<Push<D>>> {
    let conditions = &condensed.conditions;
    let mut together = Groups::new(conditions.len());
    for (contact, condition) in conditions.iter().enumerate() {
        for sharer in &condition.touch.sharers {
            together.join(contact, sharer.at.0);
        }
    }
    let first: Vec<usize> = (0..conditions.len()).map(|k| together.first(k)).collect();
    let of_body = |of: usize| -> Vec<Push<D>> {
        let (body, loaded) = (&model.bodies[of], &condensed.bodies[of]);
        let mut supports = vec![Push::default(); body.supports.len()];
        for (support, node, force) in support_forces(loaded, &displaced.states[of].reactions) {
            if let Place::Side(side) = &body.supports[support].place {
                supports[support].sides.insert(side.clone());
                supports[support].add(node, force);
            }
        }
        let mut others: BTreeMap<usize, Push<D>> = BTreeMap::new();
        for (place, (rows, condition)) in row_ranges(conditions).enumerate() {
            if condition.source.member().is_some() {
                continue;
            }
            let forces = condition.forces(&lambda[rows]);
            let sides = [Some(&condition.nonmortar), condition.mortar.as_ref()];
            let own = condition
                .ends()
                .zip(sides)
                .filter(|((part, _), _)| *part == of);
            for ((_, rows), side) in own {
                let Some(side) = side else { continue };
                let push = others.entry(first[place]).or_default();
                push.sides.insert(side.side.clone());
                for (row, force) in rows.iter().zip(&forces) {
                    row.iter()
                        .for_each(|&(node, c)| push.add(node, c.map(|c| -force * c)));
                }
            }
        }
        supports.into_iter().chain(others.into_values()).collect()
    };
    let cut: BTreeSet<usize> = model.sections.iter().map(|s| s.body.0).collect();
    cut.into_iter().map(|of| (of, of_body(of))).collect()
}

/// The forces of all sections in a solution of bodies; `pushes` are those of [`pushes`].
///
/// Errors: a group of cells without a material; an initial stress or strain that is not finite.
pub(crate) fn section_forces<const D: usize>(
    model: &Model<D>,
    (condensed, laid): (&Condensed<D>, &[Laid<D>]),
    (bodies, pushes): (&[BodySolution<D>], &BTreeMap<usize, Vec<Push<D>>>),
) -> Result<Vec<SectionSolution>, Error<D>> {
    let solved = model.sections.iter().zip(laid).map(|(section, laid)| {
        let of = section.body.0;
        let pushes = pushes.get(&of).map_or(&[][..], Vec::as_slice);
        let (body, solution) = (&model.bodies[of], &bodies[of]);
        let history = &condensed.bodies[of].system.history;
        let ahead = Ahead::new(
            (body, history, model.analysis),
            condensed.time,
            &solution.displacement,
            (pushes, &solution.member_forces),
        );
        let ahead = ahead.map_err(|source| Error::in_body(body, source))?;
        let stations = laid.cuts.iter().enumerate().map(|(k, cut)| {
            let resultant = ahead
                .of(cut)
                .map_err(|source| Error::in_body(body, source))?;
            let (middle, thickness, first) = (cut.middle(), cut.thickness(), cut.toward_first());
            let width = match model.analysis {
                Analysis::Axisymmetric => 2.0 * PI * middle[0],
                _ => body.thickness,
            };
            let along = |direction: [f64; 2]| {
                let [x, y] = resultant.force;
                (x * direction[0] + y * direction[1]) / width
            };
            let (normal, moment) = (along(cut.along()), -resultant.moment / width);
            Ok(Station {
                s: cut.s,
                point: middle,
                toward_first: first,
                thickness,
                normal,
                shear: -along(first),
                moment,
                hoop: laid
                    .across
                    .get(k)
                    .map(|places| hoop_forces(places, solution)),
                utilisation: section
                    .capacity
                    .as_ref()
                    .map(|capacity| capacity.utilisation(thickness, normal, moment)),
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
    places: &[(Option<Located<D>>, f64)],
    solution: &BodySolution<D>,
) -> [f64; 2] {
    let thickness: f64 = places.iter().map(|(_, weight)| weight).sum();
    let parts = PARTS as f64;
    let reach = 0.15_f64.sqrt();
    let mut sums = [0.0; 2];
    for (k, (place, weight)) in places.iter().enumerate() {
        let Some(place) = place else { continue };
        let value = place.interpolate(|node| solution.stress_in(place.block, node))[2];
        let x = ((k / 3) as f64 + 0.5 + reach * ((k % 3) as f64 - 1.0)) / parts;
        sums[0] += weight * value;
        sums[1] += weight * value * thickness * (0.5 - x);
    }
    sums
}
