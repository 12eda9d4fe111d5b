//! The partition of the plane by lines that may meet, end and cross anywhere.
//!
//! 1. Every curve is cut at the corners: the ends of curves, and the points in which two of them meet. Parts of two curves that
//!    coincide become one.
//! 2. Dangling ends are cut off: the end of a line beyond its last corner borders no face.
//! 3. Around each corner the curves have an order. Turning left as sharply as possible at every corner, a walk goes around a
//!    face; one that encloses a negative area goes around a connected group of curves from outside, and belongs to the face
//!    that this lies in.
//!
//! Points nearer than 1e-9 of the diameter of the drawing coincide.

use crate::geometry::{Point, bounding_box, distance, sub};
use crate::mesh::MeshError;
use crate::mesh::outline::curve::Curve;
use crate::mesh::outline::divide::{Rib, WIDEST_PIECE};
use crate::mesh::outline::drawing::{Drawn, SAME, extent, wanted};
use crate::mesh::outline::nouns::{Division, OutlinePart, OutlinePlace};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Two ends nearer than this share of the diameter were meant to coincide.
const TOO_NEAR: f64 = 1e-6;

/// A line that ends this near to another one, relative to its own length from the last corner, was meant to end there.
const NEARLY: f64 = 1e-2;

/// Sharpest corner of a region, in radians: one degree.
const SHARPEST: f64 = TAU / 360.0;

/// Width of a nameless face over its diameter below which it is a mistake.
const SLIVER: f64 = 1e-5;

/// A curve between two corners.
struct Cut {
    drawn: Drawn,
    ends: [usize; 2],
    /// The drawn curves that it is a part of.
    of: Vec<usize>,
}

/// The partition of the plane by lines.
pub(crate) struct Partition {
    pub ribs: Vec<Rib>,
    /// The edges that they are parts of.
    pub places: Vec<OutlinePlace>,
    /// Names of these.
    pub names: Vec<Vec<String>>,
    /// Area of each bounded face, without the faces inside it.
    pub areas: Vec<f64>,
    low: Point<2>,
    diameter: f64,
    cycles: Vec<Cycle>,
}

/// A walk around a face, or around a group of curves from outside.
struct Cycle {
    /// Curves, and whether they are walked in their own direction.
    steps: Vec<(usize, bool)>,
    twice_area: f64,
    face: Option<usize>,
}

impl Partition {
    /// The faces of lines of a drawing whose size is `largest`.
    ///
    /// Errors, each naming edges: dangling lines, ends that nearly meet, numbers of cells of edges that others divide, no face at
    /// all.
    pub fn of(drawn: &[Drawn], largest: f64) -> Result<Self, MeshError> {
        let (low, diameter) = extent(drawn.iter())?;
        let corners = corners(drawn, SAME * diameter);
        let cuts = cut(drawn, &corners, diameter)?;
        let cuts = trimmed(cuts, drawn, diameter)?;
        let mut partition = Self {
            ribs: Vec::with_capacity(cuts.len()),
            places: Vec::with_capacity(cuts.len()),
            names: Vec::with_capacity(cuts.len()),
            areas: Vec::new(),
            low,
            diameter,
            cycles: Vec::new(),
        };
        for Cut { drawn, ends, .. } in cuts {
            let (size, pieces) = wanted(drawn.division, largest);
            partition.ribs.push(Rib {
                curve: drawn.curve,
                size,
                pieces,
                widest: WIDEST_PIECE,
                ends,
                faces: [None, None],
            });
            partition.places.push(drawn.place);
            partition.names.push(drawn.names);
        }
        partition.walk(corners.len());
        partition.nest();
        Ok(partition)
    }

    /// The bounded face in which a point lies; `Err` with the curve on which it lies.
    pub fn face_at(&self, p: Point<2>) -> Result<Option<usize>, usize> {
        let near = SAME * self.diameter;
        let on = |rib: &Rib| distance(rib.curve.nearest(p), p) <= near;
        match self.ribs.iter().position(on) {
            Some(rib) => Err(rib),
            None => Ok(self.around(p, |_| true)),
        }
    }

    /// The smallest face that goes around a point, of those whose cycle passes.
    fn around(&self, p: Point<2>, passes: impl Fn(&Cycle) -> bool) -> Option<usize> {
        let faces = self.cycles.iter().filter(|cycle| cycle.twice_area > 0.0);
        let around = faces.filter(|&cycle| passes(cycle) && self.turns(cycle, p) > 0.5 * TAU);
        let smallest = around.min_by(|a, b| a.twice_area.total_cmp(&b.twice_area));
        smallest.and_then(|cycle| cycle.face)
    }

    fn turns(&self, cycle: &Cycle, p: Point<2>) -> f64 {
        let steps = cycle.steps.iter();
        let turns = steps.map(|&(rib, forward)| {
            let turn = self.ribs[rib].curve.winding(p);
            if forward { turn } else { -turn }
        });
        turns.sum()
    }

    /// Leaves the curves of these faces alone; they get the numbers of their places in the list. Curves of one that meet
    /// sharply are divided finely enough that their pieces do not cross.
    ///
    /// Errors: corners that are too sharp; an unintended narrow face that is not one of these.
    pub fn keep(&mut self, faces: &[usize]) -> Result<(), MeshError> {
        self.refuse_slivers(faces)?;
        let number = |face: Option<usize>| faces.iter().position(|&f| Some(f) == face);
        for rib in &mut self.ribs {
            rib.faces = rib.faces.map(number);
        }
        let used: Vec<bool> = self.ribs.iter().map(|rib| rib.faces != [None; 2]).collect();
        let retain = |k: usize| used[k];
        self.ribs = kept(std::mem::take(&mut self.ribs), retain);
        self.places = kept(std::mem::take(&mut self.places), retain);
        self.names = kept(std::mem::take(&mut self.names), retain);
        self.areas = faces.iter().map(|&face| self.areas[face]).collect();
        self.cycles.clear();
        self.limit_pieces()
    }

    /// Goes around every face.
    fn walk(&mut self, corners: usize) {
        // A step out of a corner: 2k along curve k, 2k + 1 against it.
        let mut leaving: Vec<Vec<usize>> = vec![Vec::new(); corners];
        for (k, rib) in self.ribs.iter().enumerate() {
            leaving[rib.ends[0]].push(2 * k);
            leaving[rib.ends[1]].push(2 * k + 1);
        }
        for steps in &mut leaving {
            let lengths = steps.iter().map(|&s| self.ribs[s / 2].curve.length());
            let reach = 0.125 * lengths.fold(f64::INFINITY, f64::min);
            steps.sort_by(|&a, &b| {
                let [a, b] = [a, b].map(|s| self.direction(s, reach));
                a.total_cmp(&b)
            });
        }
        let mut done = vec![false; 2 * self.ribs.len()];
        for first in 0..done.len() {
            let (mut steps, mut step) = (Vec::new(), first);
            while !std::mem::replace(&mut done[step], true) {
                steps.push((step / 2, step.is_multiple_of(2)));
                // Arriving, the way back is the same curve the other way round; the next one to its right goes on.
                let back = step ^ 1;
                let around = &leaving[self.corner(back)];
                let place = around.iter().position(|&s| s == back).unwrap_or_default();
                step = around[(place + around.len() - 1) % around.len()];
            }
            if !steps.is_empty() {
                let twice = steps.iter().map(|&(rib, forward)| {
                    let twice = self.ribs[rib].curve.twice_area(self.low);
                    if forward { twice } else { -twice }
                });
                self.cycles.push(Cycle {
                    twice_area: twice.sum(),
                    steps,
                    face: None,
                });
            }
        }
    }

    /// The corner that a step leaves.
    fn corner(&self, step: usize) -> usize {
        self.ribs[step / 2].ends[step % 2]
    }

    /// Angle of the chord of a step over a distance along its curve; with none, of its tangent.
    fn direction(&self, step: usize, reach: f64) -> f64 {
        let curve = &self.ribs[step / 2].curve;
        let curve: Curve = match step.is_multiple_of(2) {
            true => *curve,
            false => curve.reversed(),
        };
        let [x, y] = match reach > 0.0 {
            true => sub(curve.point(reach / curve.length()), curve.start),
            false => {
                let [x, y] = curve.left(0.0);
                [y, -x]
            }
        };
        y.atan2(x)
    }

    /// Numbers the faces and finds those in which groups of curves lie.
    fn nest(&mut self) {
        for k in 0..self.cycles.len() {
            let twice = self.cycles[k].twice_area;
            if twice > 0.0 {
                self.cycles[k].face = Some(self.areas.len());
                self.areas.push(0.5 * twice);
            }
        }
        let group = self.groups();
        for k in 0..self.cycles.len() {
            if self.cycles[k].face.is_none() {
                let rib = self.cycles[k].steps[0].0;
                let outside = |cycle: &Cycle| group[cycle.steps[0].0] != group[rib];
                let face = self.around(self.ribs[rib].curve.start, outside);
                self.cycles[k].face = face;
                if let Some(face) = face {
                    self.areas[face] += 0.5 * self.cycles[k].twice_area;
                }
            }
        }
        for cycle in &self.cycles {
            for &(rib, forward) in &cycle.steps {
                self.ribs[rib].faces[usize::from(!forward)] = cycle.face;
            }
        }
    }

    /// A number for each connected group of curves, at each of its curves.
    fn groups(&self) -> Vec<usize> {
        let mut group: Vec<usize> = (0..self.ribs.len()).collect();
        loop {
            let mut least: BTreeMap<usize, usize> = BTreeMap::new();
            for (rib, &own) in self.ribs.iter().zip(&group) {
                for end in rib.ends {
                    let least = least.entry(end).or_insert(own);
                    *least = own.min(*least);
                }
            }
            let smaller: Vec<usize> = self
                .ribs
                .iter()
                .map(|rib| least[&rib.ends[0]].min(least[&rib.ends[1]]))
                .collect();
            if smaller == group {
                return group;
            }
            group = smaller;
        }
    }

    /// Refuses narrow faces outside of all regions: edges that nearly coincide.
    fn refuse_slivers(&self, faces: &[usize]) -> Result<(), MeshError> {
        for (face, &area) in self.areas.iter().enumerate() {
            let mut around: Vec<usize> = (0..self.ribs.len())
                .filter(|&k| self.ribs[k].faces.contains(&Some(face)))
                .collect();
            // The longest two are those that nearly coincide.
            let length = |k: usize| self.ribs[k].curve.length();
            around.sort_by(|&a, &b| length(b).total_cmp(&length(a)));
            let boxes = around.iter().map(|&k| self.ribs[k].curve.bounds());
            let corners: Vec<Point<2>> = boxes.flat_map(<[Point<2>; 2]>::from).collect();
            let (low, high) = bounding_box(&corners);
            let lengths = around.iter().map(|&k| length(k));
            let width = 2.0 * area / lengths.sum::<f64>();
            if faces.contains(&face) || width > SLIVER * distance(low, high) {
                continue;
            }
            let place = |of: Option<&usize>| of.map(|&k| &self.places[k]);
            if let (Some(here), Some(there)) = (place(around.first()), place(around.get(1))) {
                return Err(here.error(format!(
                    "it nearly coincides with {there}: a gap about {width:.3e} wide is between them, near {:?}; draw the common line once, or with the same points",
                    self.ribs[around[0]].curve.point(0.5)
                )));
            }
        }
        Ok(())
    }

    /// Limits the angle of pieces of arcs by the corners of faces beside them.
    fn limit_pieces(&mut self) -> Result<(), MeshError> {
        let mut leaving: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (k, rib) in self.ribs.iter().enumerate() {
            leaving.entry(rib.ends[0]).or_default().push(2 * k);
            leaving.entry(rib.ends[1]).or_default().push(2 * k + 1);
        }
        for steps in leaving.values() {
            for &step in steps {
                // The face to the left of a step is that between it and the next one to the left.
                let face = self.ribs[step / 2].faces[step % 2];
                let own = self.direction(step, 0.0);
                let angle = |&other: &usize| {
                    let angle = (self.direction(other, 0.0) - own).rem_euclid(TAU);
                    // Rounding of a tangent that goes on in the same direction.
                    if angle > TAU - 1e-9 { 0.0 } else { angle }
                };
                let beside = steps.iter().filter(|&&other| other != step);
                let beside =
                    beside.filter(|&&other| self.ribs[other / 2].faces[1 - other % 2] == face);
                let Some(next) = beside.copied().min_by(|a, b| angle(a).total_cmp(&angle(b)))
                else {
                    continue;
                };
                let angle = angle(&next);
                // Bodies that are drawn apart may touch in a point; two straight lines so close were meant to be one.
                let straight = |step: usize| self.ribs[step / 2].curve.arc.is_none();
                if face.is_none() && !(straight(step) && straight(next)) {
                    continue;
                }
                if angle < SHARPEST {
                    return Err(self.places[step / 2].error(format!(
                        "it leaves {:?} along {}, under {:.2} degrees: let them meet under one degree at least, or coincide",
                        self.start(step), self.places[next / 2], angle.to_degrees()
                    )));
                }
                for step in [step, next] {
                    let rib = &mut self.ribs[step / 2];
                    rib.widest = rib.widest.min(0.5 * angle);
                }
            }
        }
        Ok(())
    }

    fn start(&self, step: usize) -> Point<2> {
        let curve = &self.ribs[step / 2].curve;
        if step.is_multiple_of(2) {
            curve.start
        } else {
            curve.end
        }
    }
}

fn kept<T>(list: Vec<T>, retain: impl Fn(usize) -> bool) -> Vec<T> {
    let list = list.into_iter().enumerate();
    list.filter(|(k, _)| retain(*k))
        .map(|(_, item)| item)
        .collect()
}

/// Ends of curves, and points in which two of them meet; each once.
fn corners(drawn: &[Drawn], near: f64) -> Vec<Point<2>> {
    let mut corners: Vec<Point<2>> = Vec::new();
    let mut add = |p: Point<2>| {
        if corners.iter().all(|&q| distance(p, q) > near) {
            corners.push(p);
        }
    };
    for drawn in drawn {
        add(drawn.curve.start);
        add(drawn.curve.end);
    }
    let boxes: Vec<_> = drawn.iter().map(|drawn| drawn.curve.bounds()).collect();
    for (i, a) in drawn.iter().enumerate() {
        for (j, b) in drawn.iter().enumerate().skip(i + 1) {
            let apart = |d: usize| {
                boxes[i].1[d] + near < boxes[j].0[d] || boxes[j].1[d] + near < boxes[i].0[d]
            };
            if !(apart(0) || apart(1)) {
                a.curve
                    .meetings(&b.curve, near)
                    .into_iter()
                    .for_each(&mut add);
            }
        }
    }
    corners
}

/// The curves cut at the corners that lie on them, those that coincide as one.
fn cut(drawn: &[Drawn], corners: &[Point<2>], diameter: f64) -> Result<Vec<Cut>, MeshError> {
    let near = SAME * diameter;
    let mut cuts: Vec<Cut> = Vec::new();
    for (of, own) in drawn.iter().enumerate() {
        let (low, high) = own.curve.bounds();
        let on = corners.iter().enumerate().filter(|(_, p)| {
            let boxed = (0..2).all(|d| (low[d] - near..=high[d] + near).contains(&p[d]));
            boxed && distance(own.curve.nearest(**p), **p) <= near
        });
        let mut on: Vec<(f64, usize)> = on.map(|(k, &p)| (own.curve.parameter(p), k)).collect();
        on.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some(Division::Cells(cells)), true) = (own.division, on.len() > 2) {
            return Err(own.place.error(format!(
                "it cannot have {cells} cells: other lines meet it at {:?}; give it a `size`, or draw its parts as edges of their own",
                corners[on[1].1]
            )));
        }
        for pair in on.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let ends = [from.1, to.1];
            let places = ends.map(|end| corners[end]);
            // Ends of the curve are at exactly 0 and 1, without rounding.
            let first = if from.1 == on[0].1 { 0.0 } else { from.0 };
            let last = if to.1 == on[on.len() - 1].1 {
                1.0
            } else {
                to.0
            };
            let curve = own.curve.part([first, last], places);
            if curve.length() < TOO_NEAR * diameter {
                return Err(own.place.error(format!(
                    "two corners on it, at {:?} and {:?}, nearly coincide: make them one, or move them apart",
                    places[0], places[1]
                )));
            }
            let same = |cut: &&mut Cut| {
                let both = cut.ends == ends || cut.ends == [ends[1], ends[0]];
                both && distance(cut.drawn.curve.point(0.5), curve.point(0.5)) <= near
            };
            match cuts.iter_mut().find(same) {
                Some(cut) => {
                    cut.drawn.join(own);
                    cut.of.push(of);
                }
                None => cuts.push(Cut {
                    drawn: Drawn {
                        curve,
                        ..own.clone()
                    },
                    ends,
                    of: vec![of],
                }),
            }
        }
    }
    Ok(cuts)
}

impl Drawn {
    /// Adds the names of another curve that coincides, and takes its cells if they are finer.
    fn join(&mut self, other: &Self) {
        for name in &other.names {
            if !self.names.contains(name) {
                self.names.push(name.clone());
            }
        }
        let length = self.curve.length();
        let size = |division: Option<Division>| match division {
            None => f64::INFINITY,
            Some(Division::Size(size)) => size,
            Some(Division::Cells(cells)) => length / cells as f64,
        };
        if size(other.division) < size(self.division) {
            self.division = other.division;
        }
    }
}

/// The curves that remain after dangling ends are cut off repeatedly.
///
/// Errors: an edge that would vanish, or a line that ends just before another one.
fn trimmed(cuts: Vec<Cut>, drawn: &[Drawn], diameter: f64) -> Result<Vec<Cut>, MeshError> {
    let mut left: Vec<bool> = vec![true; cuts.len()];
    loop {
        let mut degree: BTreeMap<usize, usize> = BTreeMap::new();
        for (cut, _) in cuts.iter().zip(&left).filter(|(_, left)| **left) {
            cut.ends
                .iter()
                .for_each(|&end| *degree.entry(end).or_default() += 1);
        }
        let loose = |cut: &Cut| cut.ends.iter().position(|end| degree[end] == 1);
        let next = cuts
            .iter()
            .zip(&left)
            .position(|(cut, &left)| left && loose(cut).is_some());
        let Some(next) = next else {
            break;
        };
        left[next] = false;
        let cut = &cuts[next];
        let curve = cut.drawn.curve;
        let end = [curve.start, curve.end][loose(cut).unwrap_or_default()];
        let others = cuts.iter().enumerate().filter(|&(k, _)| k != next);
        // Near a common corner the distance to other curves is meaningless.
        let apart = others.filter(|(_, other)| !other.ends.iter().any(|e| cut.ends.contains(e)));
        let nearest =
            apart.map(|(_, other)| (distance(other.drawn.curve.nearest(end), end), other));
        let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
        let drawn = &drawn[cut.of[0]];
        let mut rest = kept(cuts.iter().collect(), |k| left[k]).into_iter();
        let whole = !rest.any(|other| other.of.contains(&cut.of[0]));
        let nearly = nearest
            .as_ref()
            .is_some_and(|(gap, _)| *gap < NEARLY * curve.length());
        if whole || nearly {
            let where_to = match nearest {
                Some((gap, other)) if gap < 0.1 * diameter => {
                    format!(", {gap:.3e} away from {}", other.drawn.place)
                }
                _ => String::new(),
            };
            return Err(drawn.place.error(format!(
                "it leads nowhere: it ends at {end:?}{where_to}; let it end on another line or beyond it"
            )));
        }
    }
    let cuts: Vec<Cut> = kept(cuts, |k| left[k]);
    match cuts.is_empty() {
        true => {
            let whole = OutlinePlace {
                part: OutlinePart::Drawing,
                ..OutlinePlace::default()
            };
            Err(whole.error("it has no lines"))
        }
        false => Ok(cuts),
    }
}
