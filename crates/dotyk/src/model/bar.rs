//! Bars: bolts, anchors and ties, straight and stiff along themselves alone.
//!
//! A bar is a chain of elements between points that move with the bodies. With the direction t of the bar, the displacement u_k
//! of its k-th point and the lengths L_k between them, element k pulls its ends together by
//!
//! ```text
//!   N_k = P + (EA/L_k) (e_k − e_a),       e_k = t·(u_{k+1} − u_k)
//! ```
//!
//! P is its prestress and e_a the elongation at which it was there: that at the end of the step in which it came, in which a
//! prestressed bar pulls with P, whatever gives; without prestress that before this step. It may give way: in compression
//! (`tension_only`, N ≥ 0), or where it yields, |N| ≤ yield · A, with a plastic elongation that stays.
//!
//! One with ends has one element. A grouted one has two or, in cells of second order, four in each cell that it crosses; its points
//! move with the cells in which they lie, meshes need not fit. Across itself it does nothing.
//!
//! Units: N a force, of one bar. In the plane a model is as thick as its bodies: with `spacing` it holds thickness/spacing bars.

use crate::fem::{Active, Analysis, completed, side_points};
use crate::geometry::{Point, add_scaled, distance, dot, sub};
use crate::model::error::Error;
use crate::model::locate::{Located, locate_all};
use crate::model::nouns::{BodyId, Model, SideRef};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A bar between two places.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar<const D: usize> {
    /// Unique name.
    pub name: String,
    /// Where it begins and ends.
    pub ends: [BarEnd<D>; 2],
    /// The bodies in which its points lie; of sides their own.
    pub bodies: Vec<BodyId>,
    /// How it holds to them.
    pub bond: Bond,
    /// Young's modulus.
    pub young: f64,
    /// Cross section of one bar.
    pub area: f64,
    /// The force with which it pulls in the step in which it comes; `None`: it comes without a force.
    pub prestress: Option<f64>,
    /// Distance of one bar to the next across a plane model; `None`: one bar in the thickness.
    pub spacing: Option<f64>,
    /// It bears no compression.
    pub tension_only: bool,
    /// Stress at which it yields.
    pub yields: Option<f64>,
    /// Its ends at points pull at a disc of this radius across it, in the plane at a line twice as long; `None`: at the point itself.
    pub radius: Option<f64>,
    /// When it is there, as long as its bodies are.
    pub active: Active,
    /// It is being tightened: it pulls with its prestress.
    pub(crate) tightening: bool,
}

/// Where a bar ends.
#[derive(Debug, Clone, PartialEq)]
pub enum BarEnd<const D: usize> {
    /// A point of one of its bodies.
    Point(Point<D>),
    /// The mean displacement of a side, at its centroid.
    Side(SideRef),
}

/// How a bar holds to its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bond {
    /// At both ends.
    #[default]
    Ends,
    /// All along.
    Grouted,
}

impl Bond {
    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ends => "ends",
            Self::Grouted => "grouted",
        }
    }
}

/// Why a bar is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BarError {
    /// A number out of its range.
    #[error("its {what} is {value}: it must be {range}")]
    Number {
        /// Which.
        what: &'static str,
        /// The number.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// A point that lies in no body of its own.
    #[error("its end {} lies in none of the bodies {bodies}", show(.point))]
    Off {
        /// Which end, from zero.
        end: usize,
        /// The point.
        point: Vec<f64>,
        /// The bodies, as a list.
        bodies: String,
    },
    /// Both ends at the same place.
    #[error("its ends lie at the same place: it has no direction")]
    NoLength,
    /// A side without area.
    #[error("its side \"{side}\" is unknown, or has no area")]
    Side {
        /// The side.
        side: String,
        /// Which end, from zero.
        end: usize,
    },
    /// A grouted bar that lies in its bodies at less than two points.
    #[error("it lies in none of its bodies but at its ends: it cannot be grouted")]
    NotWithin,
    /// With axial symmetry.
    #[error("a bar has no meaning with axial symmetry")]
    Axial,
    /// Bodies of different thickness beside a spacing.
    #[error("its bodies differ in thickness: how many bars a spacing makes is not clear")]
    Thickness,
    /// A spacing in space.
    #[error("`spacing` is across a plane model; in space every bar is there by itself")]
    Spacing,
}

fn show(point: &[f64]) -> String {
    let numbers: Vec<String> = point.iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}

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

/// Elements in each cell that a grouted bar crosses: straight ones where a cell of second order is a parabola, whose energy n of
/// them miss by 1/n². Of all at least and at most as many.
const IN_CELL: [usize; 2] = [2, 4];
const FEWEST: usize = 8;
const MOST: usize = 1000;

/// Places where it is asked which cells a bar crosses.
const LOOKS: usize = 500;

/// Points along the half of a plate across a bar at which its end is shared out.
const SHARED: usize = 4;

impl<const D: usize> Bar<D> {
    /// One that is grouted or not between two places of some bodies, always there, without prestress.
    pub fn new(
        name: &str,
        ends: [BarEnd<D>; 2],
        bodies: &[BodyId],
        [young, area]: [f64; 2],
    ) -> Self {
        Self {
            name: name.to_string(),
            ends,
            bodies: bodies.to_vec(),
            bond: Bond::Ends,
            young,
            area,
            prestress: None,
            spacing: None,
            tension_only: false,
            yields: None,
            radius: None,
            active: Active::ALWAYS,
            tightening: false,
        }
    }

    /// All bodies that it touches.
    pub fn touched(&self) -> impl Iterator<Item = BodyId> {
        let sides = self.ends.iter().filter_map(|end| match end {
            BarEnd::Side(side) => Some(side.body),
            BarEnd::Point(_) => None,
        });
        let within = self.ends.iter().any(|end| matches!(end, BarEnd::Point(_)));
        let within = within || self.bond == Bond::Grouted;
        let bodies = self.bodies.iter().copied().filter(move |_| within);
        sides.chain(bodies)
    }

    /// In this stage of a model it is being tightened: it pulls with its prestress.
    pub fn is_tightening(&self) -> bool {
        self.tightening
    }

    /// Where it begins and ends in a model.
    ///
    /// Errors: see [`BarError`].
    pub fn places(&self, model: &Model<D>) -> Result<[Point<D>; 2], BarError> {
        Ok([self.place(model, 0)?, self.place(model, 1)?])
    }

    /// The largest force that it bears.
    pub fn strength(&self) -> Option<f64> {
        self.yields.map(|stress| stress * self.area)
    }

    fn check_numbers(&self) -> Result<(), BarError> {
        let positive = |what, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(BarError::Number {
                what,
                value,
                range: "positive",
            }),
        };
        positive("young", self.young)?;
        positive("area", self.area)?;
        let given = [
            ("spacing", self.spacing),
            ("yield", self.yields),
            ("radius", self.radius),
        ];
        for (what, value) in given {
            value.map_or(Ok(()), |value| positive(what, value))?;
        }
        let Some(prestress) = self.prestress else {
            return Ok(());
        };
        let wrong = |range| {
            Err(BarError::Number {
                what: "prestress",
                value: prestress,
                range,
            })
        };
        if !prestress.is_finite() {
            return wrong("a finite number");
        }
        if self.tension_only && prestress < 0.0 {
            return wrong("a tension, as the bar bears no compression");
        }
        match self.strength() {
            Some(most) if prestress.abs() > most => {
                wrong("at most yield times area, else the bar yields while it is tightened")
            }
            _ => Ok(()),
        }
    }

    /// Whether it can be laid in a model.
    ///
    /// Errors: see [`BarError`].
    pub fn check(&self, model: &Model<D>) -> Result<(), BarError> {
        self.lay(model).map(|_| ())
    }

    /// Where it lies in a model.
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

    /// How an end moves, which lies at a point.
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

    /// For each point the first of its bodies in which it lies, else the one that it lies just beside, as a point of a curve does
    /// for whose cells a polygon stands.
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

/// A point so far outside of a cell, in its own coordinates, lies in it to rounding; and so far outside beside it.
const INSIDE: f64 = 1e-6;
const BESIDE: f64 = 0.02;

/// Ends nearer to each other than this part of the largest body are at the same place.
const NO_LENGTH: f64 = 1e-12;

/// Points all over a disc of a radius across a direction, in the plane along a line, each for the same part of it.
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

/// Where all bars of a model lie.
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

/// Forces of a bar.
#[derive(Debug, Clone, PartialEq)]
pub struct BarSolution<const D: usize> {
    /// Its name.
    pub name: String,
    /// From its beginning to its end.
    pub length: f64,
    /// One for each of its elements, in their order.
    pub stations: Vec<BarStation<D>>,
    /// It was tightened in this step.
    pub tightening: bool,
}

/// Force of an element of a bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarStation<const D: usize> {
    /// Length from the beginning of the bar to the middle of the element.
    pub s: f64,
    /// The middle.
    pub point: Point<D>,
    /// Length of the element.
    pub length: f64,
    /// N of one bar, tension positive.
    pub force: f64,
}

impl<const D: usize> BarSolution<D> {
    /// The station with the force of the largest magnitude.
    pub fn largest(&self) -> Option<&BarStation<D>> {
        let mut stations = self.stations.iter();
        let first = stations.next()?;
        Some(stations.fold(first, |best, next| {
            if next.force.abs() > best.force.abs() {
                next
            } else {
                best
            }
        }))
    }
}
