//! Positions of bars (`nouns/bar.rs`): their points, and how these move with the bodies.

use crate::fem::{Analysis, completed, side_points};
use crate::geometry::{Point, add_scaled, distance, dot, sub};
use crate::mesh::{Located, locate_all};
use crate::model::nouns::bar::{Bar, BarEnd, BarError, Bond};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::Model;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A point of a bar: how it moves with its body.
#[derive(Debug, Clone)]
pub(crate) struct Anchor<const D: usize> {
    pub body: usize,
    /// Nodes of the body, and what they contribute to the displacement.
    pub nodes: Vec<(usize, f64)>,
    pub point: Point<D>,
}

/// A bar in its place.
#[derive(Debug, Clone)]
pub(crate) struct LaidBar<const D: usize> {
    pub anchors: Vec<Anchor<D>>,
    /// Unit vector from its beginning to its end.
    pub along: Point<D>,
    /// Bars in the thickness of the model.
    pub count: f64,
}

impl<const D: usize> LaidBar<D> {
    /// Elements: their two points.
    pub fn elements(&self) -> impl Iterator<Item = [&Anchor<D>; 2]> {
        self.anchors.windows(2).map(|pair| [&pair[0], &pair[1]])
    }

    /// Length from the beginning to a point of the bar.
    pub fn length_to(&self, point: Point<D>) -> f64 {
        dot(sub(point, self.anchors[0].point), self.along)
    }
}

/// Elements in each cell that a grouted bar crosses, for cells of first and second order. In a cell of second order straight elements
/// replace a parabola, and n of them miss its energy by 1/n². Then the fewest and the most elements of a bar.
const IN_CELL: [usize; 2] = [2, 4];
const FEWEST: usize = 8;
const MOST: usize = 1000;

/// Sampling points along a bar that find the cells it crosses.
const LOOKS: usize = 500;

/// Points along the half of a plate across a bar over which the force of its end is spread.
const SHARED: usize = 4;

impl<const D: usize> Bar<D> {
    /// Its two ends in a model.
    ///
    /// Errors: see [`BarError`].
    pub fn places(&self, model: &Model<D>) -> Result<[Point<D>; 2], BarError> {
        Ok([self.place(model, 0)?, self.place(model, 1)?])
    }

    /// Whether it can be laid in a model.
    ///
    /// Errors: see [`BarError`].
    pub fn check(&self, model: &Model<D>) -> Result<(), BarError> {
        self.lay(model).map(|_| ())
    }

    /// Its layout in a model.
    ///
    /// Errors: see [`BarError`].
    pub(crate) fn lay(&self, model: &Model<D>) -> Result<LaidBar<D>, BarError> {
        self.check_numbers()?;
        if model.analysis == Analysis::Axisymmetric {
            return Err(BarError::Axial);
        }
        if D == 3 && self.spacing.is_some() {
            return Err(BarError::Spacing);
        }
        let places = self.places(model)?;
        let length = distance(places[0], places[1]);
        let across = model.bodies.iter().map(|body| body.mesh.diameter());
        if length <= NO_LENGTH * across.fold(0.0, f64::max) {
            return Err(BarError::NoLength);
        }
        let along = sub(places[1], places[0]).map(|c| c / length);
        let mut anchors = vec![self.end(model, (0, places[0]), along)?];
        if self.bond == Bond::Grouted {
            anchors.extend(self.within(model, places)?);
        }
        anchors.push(self.end(model, (1, places[1]), along)?);
        let mut thickness = anchors.iter().map(|a| model.bodies[a.body].thickness);
        let own = thickness.next().unwrap_or(1.0);
        let count = match self.spacing {
            Some(_) if thickness.any(|other| other != own) => return Err(BarError::Thickness),
            Some(spacing) => own / spacing,
            None => 1.0,
        };
        Ok(LaidBar {
            anchors,
            along,
            count,
        })
    }

    /// The place of an end.
    fn place(&self, model: &Model<D>, end: usize) -> Result<Point<D>, BarError> {
        match &self.ends[end] {
            BarEnd::Point(point) => Ok(*point),
            BarEnd::Side(side) => Ok(mean_of_side(model, side, end)?.point),
        }
    }

    /// The anchor of an end at a point.
    fn end(
        &self,
        model: &Model<D>,
        (end, point): (usize, Point<D>),
        along: Point<D>,
    ) -> Result<Anchor<D>, BarError> {
        if let BarEnd::Side(side) = &self.ends[end] {
            return mean_of_side(model, side, end);
        }
        let found = self.located(model, &[point]).pop().flatten();
        let Some((body, place)) = found else {
            let names = self.bodies.iter().map(|id| model.bodies[id.0].name.clone());
            return Err(BarError::Off {
                end,
                point: point.to_vec(),
                bodies: names.collect::<Vec<_>>().join(", "),
            });
        };
        // its plate may reach beyond the body
        let points = self.radius.map(|radius| plate(point, along, radius));
        let spread = locate_all(&model.bodies[body].mesh, &points.unwrap_or_default());
        let spread = spread.into_iter().flatten().filter(|p| p.outside <= INSIDE);
        let spread: Vec<Located<D>> = spread.collect();
        Ok(Anchor {
            body,
            nodes: mean_of(if spread.is_empty() {
                vec![place]
            } else {
                spread
            }),
            point,
        })
    }

    /// The points between its ends at which a grouted bar lies in one of its bodies.
    fn within(
        &self,
        model: &Model<D>,
        [from, to]: [Point<D>; 2],
    ) -> Result<Vec<Anchor<D>>, BarError> {
        let step = sub(to, from);
        let looks: Vec<Point<D>> = (0..LOOKS)
            .map(|k| add_scaled(from, (k as f64 + 0.5) / LOOKS as f64, step))
            .collect();
        let mut cells: Vec<Vec<usize>> = Vec::new();
        for (_, found) in self.located(model, &looks).into_iter().flatten() {
            if cells.last() != Some(&found.nodes) {
                cells.push(found.nodes);
            }
        }
        // more nodes than the largest cell has corners
        let of_cell = |nodes: &Vec<usize>| IN_CELL[usize::from(nodes.len() > 1 << D)];
        let elements = cells.iter().map(of_cell).sum::<usize>();
        let elements = elements.clamp(FEWEST, MOST);
        let points: Vec<Point<D>> = (1..elements)
            .map(|k| add_scaled(from, k as f64 / elements as f64, step))
            .collect();
        let found = self.located(model, &points).into_iter().zip(points);
        let anchors: Vec<Anchor<D>> = found
            .filter_map(|(found, point)| {
                let (body, place) = found?;
                Some(Anchor {
                    body,
                    nodes: place.nodes.into_iter().zip(place.shape).collect(),
                    point,
                })
            })
            .collect();
        match anchors.is_empty() {
            true => Err(BarError::NotWithin),
            false => Ok(anchors),
        }
    }

    /// For each point the first of its bodies in which it lies, else a body that it lies just beside: such as a point of a curve that the
    /// cells approximate by a polygon.
    fn located(&self, model: &Model<D>, points: &[Point<D>]) -> Vec<Option<(usize, Located<D>)>> {
        let mut found: Vec<Option<(usize, Located<D>)>> = vec![None; points.len()];
        for body in &self.bodies {
            let places = locate_all(&model.bodies[body.0].mesh, points);
            for (found, place) in found.iter_mut().zip(places) {
                let Some(place) = place.filter(|place| place.outside <= BESIDE) else {
                    continue;
                };
                let best = found
                    .as_ref()
                    .map_or(f64::INFINITY, |(_, best)| best.outside);
                if place.outside.max(INSIDE) < best.max(INSIDE) {
                    *found = Some((body.0, place));
                }
            }
        }
        found
    }
}

/// A point this far outside of a cell, in its own coordinates, lies in it to rounding; up to the second distance it lies beside it.
const INSIDE: f64 = 1e-6;
const BESIDE: f64 = 0.02;

/// Ends nearer to each other than this part of the largest body are at the same place.
const NO_LENGTH: f64 = 1e-12;

/// Points spread over a disc of a radius across a direction (in the plane over a line), each for an equal part of it.
fn plate<const D: usize>(centre: Point<D>, along: Point<D>, radius: f64) -> Vec<Point<D>> {
    let axes = completed(vec![along]);
    let ring = |k: usize| (k as f64 + 0.5) / SHARED as f64;
    let in_plane = |k: usize| {
        [-radius * ring(k), radius * ring(k)]
            .map(|x| [x, 0.0])
            .to_vec()
    };
    // rings of the same area
    let in_space = |k: usize| {
        let (r, angles) = (radius * ring(k).sqrt(), 4 * SHARED);
        let turn = move |a: usize| TAU * (a as f64 + 0.5 * (k % 2) as f64) / angles as f64;
        let around = (0..angles).map(turn);
        around.map(|a| [r * a.cos(), r * a.sin()]).collect()
    };
    let offsets = (0..SHARED).flat_map(|k| if D == 2 { in_plane(k) } else { in_space(k) });
    let place = |offset: [f64; 2]| {
        let across = axes[1..].iter().zip(offset);
        across.fold(centre, |sum, (axis, x)| add_scaled(sum, x, *axis))
    };
    offsets.map(place).collect()
}

/// Mean of some places.
fn mean_of<const D: usize>(places: Vec<Located<D>>) -> Vec<(usize, f64)> {
    let share = 1.0 / places.len() as f64;
    let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
    for place in places {
        for (node, n) in place.nodes.into_iter().zip(place.shape) {
            *sums.entry(node).or_insert(0.0) += share * n;
        }
    }
    sums.into_iter().collect()
}

/// The mean displacement of a side, at its centroid.
fn mean_of_side<const D: usize>(
    model: &Model<D>,
    side: &SideRef,
    end: usize,
) -> Result<Anchor<D>, BarError> {
    let body = &model.bodies[side.body.0];
    let fail = || BarError::Side {
        side: side.side.clone(),
        end,
    };
    let (mut area, mut centre) = (0.0, [0.0; D]);
    let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
    for place in side_points(body, &side.side, model.analysis).map_err(|_| fail())? {
        area += place.area;
        centre = add_scaled(centre, place.area, place.point);
        for (node, n) in body.mesh.facet_nodes(place.facet).zip(place.shape) {
            *sums.entry(node as usize).or_insert(0.0) += place.area * n;
        }
    }
    if area <= 0.0 {
        return Err(fail());
    }
    Ok(Anchor {
        body: side.body.0,
        nodes: sums.into_iter().map(|(node, n)| (node, n / area)).collect(),
        point: centre.map(|c| c / area),
    })
}

/// Layout of all bars of a model.
///
/// Errors: see [`BarError`], with the bar's name.
pub(crate) fn lay_bars<const D: usize>(model: &Model<D>) -> Result<Vec<LaidBar<D>>, Error<D>> {
    let lay = |bar: &Bar<D>| {
        bar.lay(model).map_err(|source| Error::Bar {
            bar: bar.name.clone(),
            source,
        })
    };
    model.bars.iter().map(lay).collect()
}
