//! Positions of members (`nouns/member.rs`): their points, and how these move with the bodies.

use crate::fem::{Analysis, Body, completed, show};
use crate::geometry::{Point, add_scaled, distance, dot, sub};
use crate::mesh::{Located, locate_all};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::member::{Bond, ENDS, Line, MemberEnd, MemberError, MemberWords};
use crate::model::nouns::members::Member;
use crate::model::nouns::model::Model;
use crate::model::system::bolt::LaidCut;
use crate::model::system::face::Face;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A point of a member: how it moves with its body.
#[derive(Debug, Clone)]
pub(crate) struct Anchor<const D: usize> {
    pub body: usize,
    /// Nodes of the body, and what they contribute to the displacement.
    pub nodes: Vec<(usize, f64)>,
    pub point: Point<D>,
}

/// A member in its place.
#[derive(Debug, Clone)]
pub(crate) struct LaidMember<const D: usize> {
    pub anchors: Vec<Anchor<D>>,
    /// Unit vector from its beginning to its end.
    pub along: Point<D>,
    /// Members in the thickness of the model.
    pub count: f64,
}

impl<const D: usize> LaidMember<D> {
    /// Elements: their two points.
    pub fn elements(&self) -> impl Iterator<Item = [&Anchor<D>; 2]> {
        self.anchors.windows(2).map(|pair| [&pair[0], &pair[1]])
    }

    /// Length from the beginning to a point of the member.
    pub fn length_to(&self, point: Point<D>) -> f64 {
        dot(sub(point, self.anchors[0].point), self.along)
    }
}

/// Elements in each cell that a grouted member crosses, for cells of first and second order. In a cell of second order straight elements
/// replace a parabola, and n of them miss its energy by 1/n². Then the fewest and the most elements of a member.
const IN_CELL: [usize; 2] = [2, 4];
const FEWEST: usize = 8;
const MOST_ELEMENTS: usize = 1000;

/// Sampling points along a member that find the cells it crosses.
const LOOKS: usize = 500;

/// Points along the half of a plate across a member over which the force of its end is spread.
const SHARED: usize = 4;

impl<const D: usize> Line<D> {
    /// The place of an end among these bodies.
    ///
    /// Errors: a side that has no place.
    pub(crate) fn place(
        &self,
        bodies: &[Body<D>],
        analysis: Analysis,
        end: usize,
    ) -> Result<Point<D>, MemberError> {
        match &self.ends[end] {
            MemberEnd::Point(point) => Ok(*point),
            MemberEnd::Side(side) => Ok(Face::new((bodies, analysis), side, end)?.centre),
        }
    }
}

impl<const D: usize> Member<D> {
    /// Its two ends in a model; of a bolt the ends of a line through its cut.
    ///
    /// Errors: a side that has no place.
    pub fn places(&self, model: &Model<D>) -> Result<[Point<D>; 2], MemberError> {
        if let Some(bolt) = self.kind.bolt() {
            // so that it is seen
            let cut = LaidCut::new(model, self, bolt)?;
            let end = |sign: f64| add_scaled(cut.centre, sign * cut.radius, cut.along);
            return Ok([end(-1.0), end(1.0)]);
        }
        Ok([self.place(model, 0)?, self.place(model, 1)?])
    }

    /// Whether it can be laid in a model.
    ///
    /// Errors: what is wrong with it.
    pub fn check(&self, model: &Model<D>) -> Result<(), MemberError> {
        self.lay(model).map(|_| ())
    }

    /// Its layout in a model.
    ///
    /// Errors: what is wrong with it.
    pub(crate) fn lay(&self, model: &Model<D>) -> Result<LaidMember<D>, MemberError> {
        let line = &self.line;
        self.kind.pull().check(line.bond)?;
        if let Some(bolt) = self.kind.bolt() {
            let cut = LaidCut::new(model, self, bolt)?;
            let end = |end: usize| Anchor {
                body: cut.sides[end].body.0,
                nodes: cut.shares[end].clone(),
                point: cut.centre,
            };
            return Ok(LaidMember {
                anchors: vec![end(0), end(1)],
                along: cut.along,
                count: 1.0,
            });
        }
        self.check_numbers(model)?;
        let places = self.places(model)?;
        let length = distance(places[0], places[1]);
        let across = model.bodies.iter().map(|body| body.mesh.diameter());
        if length <= NO_LENGTH * across.fold(0.0, f64::max) {
            let message = "its ends lie at the same place: it has no direction";
            return Err(MemberError::new("to", message, "the same as `from`", ""));
        }
        let along = sub(places[1], places[0]).map(|c| c / length);
        let mut anchors = vec![self.end(model, (0, places[0]), along)?];
        if line.bond == Bond::Grouted {
            anchors.extend(self.within(model, places)?);
        }
        anchors.push(self.end(model, (1, places[1]), along)?);
        let count = self.count(model, &anchors)?;
        Ok(LaidMember {
            anchors,
            along,
            count,
        })
    }

    /// Errors: numbers out of their ranges, or of another analysis.
    fn check_numbers(&self, model: &Model<D>) -> Result<(), MemberError> {
        let (line, MemberWords { key, plural, .. }) = (&self.line, self.kind.words());
        let radii = line.radius.map(|radius| ("radius", radius));
        for (number, value) in [("spacing", line.spacing)].into_iter().chain(radii) {
            value.map_or(Ok(()), |value| MemberError::positive(number, value))?;
        }
        let axial = model.analysis == Analysis::Axisymmetric;
        let (wrong, message) = match (axial, line.count) {
            (true, None) => (
                "",
                format!(
                    "with axial symmetry a {key} stands for those all around the axis: `count` says how many"
                ),
            ),
            (true, Some(0)) => ("count", format!("it stands for no {key} at all")),
            (false, Some(_)) => (
                "count",
                format!("`count` is that of {plural} around the axis of symmetry"),
            ),
            _ if line.spacing.is_none() => return Ok(()),
            (true, _) => (
                "spacing",
                format!(
                    "with axial symmetry `count` says how many {plural} there are, not `spacing`"
                ),
            ),
            _ if D == 3 => (
                "spacing",
                format!(
                    "`spacing` is across a plane model; in space every {key} is there by itself"
                ),
            ),
            _ => return Ok(()),
        };
        let label = format!("of how many {plural}?");
        Err(MemberError::new(wrong, message, label, ""))
    }

    /// How many members it stands for.
    ///
    /// Errors: bodies of different thickness.
    fn count(&self, model: &Model<D>, anchors: &[Anchor<D>]) -> Result<f64, MemberError> {
        let plural = self.kind.words().plural;
        let mut thickness = anchors.iter().map(|a| model.bodies[a.body].thickness);
        let own = thickness.next().unwrap_or(1.0);
        match (self.line.count, self.line.spacing) {
            (Some(count), _) => Ok(count as f64),
            (None, Some(_)) if thickness.any(|other| other != own) => Err(MemberError::new(
                "spacing",
                format!(
                    "its bodies differ in thickness: how many {plural} a spacing makes is not clear"
                ),
                format!("of how many {plural}?"),
                "",
            )),
            (None, Some(spacing)) => Ok(own / spacing),
            (None, None) => Ok(1.0),
        }
    }

    /// The place of an end.
    fn place(&self, model: &Model<D>, end: usize) -> Result<Point<D>, MemberError> {
        self.line.place(&model.bodies, model.analysis, end)
    }

    /// The anchor of an end at a point.
    fn end(
        &self,
        model: &Model<D>,
        (end, point): (usize, Point<D>),
        along: Point<D>,
    ) -> Result<Anchor<D>, MemberError> {
        if let MemberEnd::Side(side) = &self.line.ends[end] {
            return mean_of_side(model, side, end);
        }
        let found = self.located(model, &[point]).pop().flatten();
        let Some((body, place)) = found else {
            let bodies = self.line.bodies.iter();
            let names: Vec<&str> = bodies.map(|id| &model.bodies[id.0].name[..]).collect();
            let message = format!(
                "its end ({}) lies in none of the bodies {}",
                point.map(|c| c.to_string()).join(", "),
                names.join(", ")
            );
            let help =
                "a point end lies in a cell of one of the `bodies`, on the boundary at the most";
            let label = "in none of its bodies";
            return Err(MemberError::new(ENDS[end], message, label, help));
        };
        // where its plate reaches beyond the body, so much is left out on the other side, too: its force stays on its axis
        let radius = self.line.radius[end];
        // across the member in a meridian plane, the plate reaches so far towards the axis
        let inwards = radius.map_or(0.0, |radius| radius * along[1].abs());
        if model.analysis == Analysis::Axisymmetric && inwards > point[0] {
            let message = format!(
                "the plate of its end at {} reaches over the axis of symmetry",
                show(point)
            );
            let help = "let it end at a side, as { side = \"BODY.SIDE\" }, whose mean it is";
            return Err(MemberError::new("radius", message, "too large there", help));
        }
        let pairs = radius.map(|radius| plate(point, along, radius));
        let points = pairs.unwrap_or_default().concat();
        let spread = locate_all(&model.bodies[body].mesh, &points);
        let within =
            |place: &Option<Located<D>>| place.as_ref().is_some_and(|p| p.outside <= IN_THE_CELL);
        let spread = spread
            .chunks_exact(2)
            .filter(|pair| pair.iter().all(within));
        let spread: Vec<Located<D>> = spread.flatten().flatten().cloned().collect();
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

    /// The points between its ends at which a grouted member lies in one of its bodies.
    fn within(
        &self,
        model: &Model<D>,
        [from, to]: [Point<D>; 2],
    ) -> Result<Vec<Anchor<D>>, MemberError> {
        let step = sub(to, from);
        let looks: Vec<Point<D>> = (0..LOOKS)
            .map(|k| add_scaled(from, (k as f64 + 0.5) / LOOKS as f64, step))
            .collect();
        // cells that it crosses, and borders between cells along which it runs: at least two looks in a row
        let mut crossed = BTreeMap::new();
        let mut last = None;
        for (body, found) in self.located(model, &looks).into_iter().flatten() {
            // more nodes than the largest cell has corners
            let elements = IN_CELL[usize::from(found.nodes.len() > 1 << D)];
            let mut border: Vec<usize> = match found.cell {
                Some(_) => Vec::new(),
                None => found.carriers().collect(),
            };
            border.sort_unstable();
            let place = (body, found.cell.map(|cell| (found.block, cell)), border);
            if found.cell.is_some() || last.as_ref() == Some(&place) {
                crossed.insert(place.clone(), elements);
            }
            last = Some(place);
        }
        let elements = crossed.values().sum::<usize>();
        let elements = elements.clamp(FEWEST, MOST_ELEMENTS);
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
            true => {
                let message = "it lies in none of its bodies but at its ends: it cannot be grouted";
                let help = "name the bodies through which it runs, or leave out `bond`";
                Err(MemberError::new("bodies", message, "not in them", help))
            }
            false => Ok(anchors),
        }
    }

    /// For each point the first of its bodies in which it lies, else a body that it lies just beside: such as a point of a curve that the
    /// cells approximate by a polygon.
    fn located(&self, model: &Model<D>, points: &[Point<D>]) -> Vec<Option<(usize, Located<D>)>> {
        let mut found: Vec<Option<(usize, Located<D>)>> = vec![None; points.len()];
        for body in &self.line.bodies {
            let places = locate_all(&model.bodies[body.0].mesh, points);
            for (found, place) in found.iter_mut().zip(places) {
                let Some(place) = place.filter(|place| place.outside <= BESIDE_CELL) else {
                    continue;
                };
                let best = found
                    .as_ref()
                    .map_or(f64::INFINITY, |(_, best)| best.outside);
                if place.outside.max(IN_THE_CELL) < best.max(IN_THE_CELL) {
                    *found = Some((body.0, place));
                }
            }
        }
        found
    }
}

/// A point this far outside of a cell, in its own coordinates, lies in it to rounding; up to the second distance it lies beside it.
const IN_THE_CELL: f64 = 1e-6;
const BESIDE_CELL: f64 = 0.02;

/// Ends nearer to each other than this part of the largest body are at the same place.
const NO_LENGTH: f64 = 1e-12;

/// Points spread over a disc of a radius across a direction (in the plane over a line), each for an equal part of it: pairs that lie
/// opposite to each other.
fn plate<const D: usize>(centre: Point<D>, along: Point<D>, radius: f64) -> Vec<[Point<D>; 2]> {
    let axes = completed(vec![along]);
    let ring = |k: usize| (k as f64 + 0.5) / SHARED as f64;
    // rings of the same area; in the plane x alone counts
    let in_space = |k: usize| {
        let (r, angles) = (radius * ring(k).sqrt(), 4 * SHARED);
        let turn = move |a: usize| TAU * (a as f64 + 0.5 * (k % 2) as f64) / angles as f64;
        let half = (0..angles / 2).map(turn);
        half.map(|a| [r * a.cos(), r * a.sin()]).collect()
    };
    let offsets = (0..SHARED).flat_map(|k| match D {
        2 => vec![[radius * ring(k), 0.0]],
        _ => in_space(k),
    });
    let place = |offset: [f64; 2]| {
        let across = axes[1..].iter().zip(offset);
        across.fold(centre, |sum, (axis, x)| add_scaled(sum, x, *axis))
    };
    offsets
        .map(|offset| [offset.map(|x| -x), offset].map(place))
        .collect()
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
) -> Result<Anchor<D>, MemberError> {
    let face = Face::new((&model.bodies, model.analysis), side, end)?;
    Ok(Anchor {
        body: side.body.0,
        nodes: face.shares,
        point: face.centre,
    })
}

/// Layout of all members of a model.
///
/// Errors: what is wrong with one, with its kind and name.
pub(crate) fn lay_members<const D: usize>(
    model: &Model<D>,
) -> Result<Vec<LaidMember<D>>, Error<D>> {
    let lay = |member: &Member<D>| {
        member.lay(model).map_err(|source| Error::Member {
            kind: member.kind.words(),
            name: member.name.clone(),
            source,
        })
    };
    model.members.iter().map(lay).collect()
}
