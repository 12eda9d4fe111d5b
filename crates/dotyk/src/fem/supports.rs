//! Supports as orthonormal held directions at nodes, with their prescribed displacements.
//!
//! Every support contributes conditions a·u = v at nodes. Conditions at one node are orthonormalised in the order in
//! which they are written; a dependent one must agree with the earlier ones, else it is a contradiction.
//!
//! Both are sums of terms that may cancel: a roller across a prescribed displacement follows as Σ (a·aₖ) vₖ = 0, and a value is an
//! expression at coordinates with rounding. So two agree if they differ by at most a part of the *terms*: those of the sum, the
//! terms of each vₖ itself, and the largest value that a support prescribes anywhere; or by less than rounding of a length of the body.

use crate::fem::error::{FemError, show};
use crate::fem::nouns::{Analysis, Body, History, Place};
use crate::fem::sides::side_nodes;
use crate::fem::surface::joined_normals;
use crate::geometry::{Field, Point, add_scaled, distance, dot, norm};
use crate::mesh::Mesh;
use std::collections::{BTreeMap, BTreeSet};

/// One prescribed displacement component: axis·u = value at a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Held<const D: usize> {
    /// Unit direction.
    pub axis: Point<D>,
    /// Displacement along it.
    pub value: f64,
    /// Size of the terms of which the value is a sum: it is known to the rounding of these.
    pub terms: f64,
    /// It is zero at all times.
    pub still: bool,
    /// Indices of the body's supports that hold it; empty where only the axis of symmetry does.
    pub supports: Vec<usize>,
}

/// All held directions of a body, by node.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Constraints<const D: usize> {
    /// Orthonormal held directions of each supported node, in node order.
    pub nodes: BTreeMap<usize, Vec<Held<D>>>,
}

/// Two directions count as the same below this sine.
const PARALLEL: f64 = 1e-8;

/// Two values at a node that differ by no more than this part of their terms are the same.
pub(crate) const AGREE: f64 = 1e-9;

/// A displacement along a direction as a support prescribes it.
#[derive(Clone, Copy)]
struct Prescribed {
    value: f64,
    /// The size of the terms of its value, at least the largest value that the support prescribes.
    terms: f64,
    /// It is zero at all times.
    still: bool,
}

impl Prescribed {
    const STILL: Self = Self {
        value: 0.0,
        terms: 0.0,
        still: true,
    };
}

impl<const D: usize> Constraints<D> {
    /// Evaluates the supports of a body at a time. On the axis of an axisymmetric analysis the radius cannot change: its
    /// nodes are held along it without a support.
    pub(crate) fn new(
        (body, history): (&Body<D>, &History<D>),
        analysis: Analysis,
        time: f64,
    ) -> Result<Self, FemError> {
        let mut constraints = Self {
            nodes: BTreeMap::new(),
        };
        if analysis == Analysis::Axisymmetric {
            let radial = std::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 });
            for node in nodes_on_axis(&body.mesh) {
                constraints.hold(body, node, radial, Prescribed::STILL, None)?;
            }
        }
        let rollers = body.supports.iter().filter(|s| s.normal.is_some());
        let sides: BTreeSet<&str> = rollers.filter_map(|s| s.place.side()).collect();
        let sides: Vec<&str> = sides.into_iter().collect();
        let normals = joined_normals(body, &sides)?;
        let normals: BTreeMap<&str, _> = sides.into_iter().zip(normals).collect();
        let none = BTreeMap::new();
        for (index, support) in body.supports.iter().enumerate() {
            let placed = history.placed.get(&index);
            let nodes: Vec<usize> = match &support.place {
                Place::Side(side) => side_nodes(&body.mesh, side)?.into_iter().collect(),
                Place::Point(point) => vec![nearest_node(&body.mesh, *point, "support")?],
            };
            let side = support.place.side();
            let normals = side.and_then(|side| normals.get(side)).unwrap_or(&none);
            let fields = support.components.iter().flatten().chain(&support.normal);
            let points = nodes.iter().map(|&node| body.mesh.points()[node]);
            Field::prepare(fields, points, time);
            let directions = |node: usize| {
                let unit = |i: usize| std::array::from_fn(|j| f64::from(u8::from(i == j)));
                let components = support.components.iter().enumerate();
                let along =
                    components.filter_map(move |(i, field)| Some((unit(i), field.as_ref()?)));
                let normal = support.normal.as_ref();
                along.chain(normal.and_then(|field| Some((*normals.get(&node)?, field))))
            };
            let what = || format!("support {}", describe(&support.place));
            let value =
                |node: usize, field: &Field| finite(field, body.mesh.points()[node], time, what);
            let mut largest: f64 = 0.0;
            for &node in &nodes {
                for (_, field) in directions(node) {
                    largest = largest.max(value(node, field)?.abs());
                }
            }
            for &node in &nodes {
                for (direction, field) in directions(node) {
                    // a support that came later holds the node at its displacement of that time
                    let was = placed.map(|placed| placed[node]);
                    let prescribed = Prescribed {
                        value: value(node, field)? + was.map_or(0.0, |u| dot(u, direction)),
                        terms: largest + was.map_or(0.0, norm),
                        still: was.is_none() && field.as_constant() == Some(0.0),
                    };
                    constraints.hold(body, node, direction, prescribed, Some(index))?;
                }
            }
        }
        Ok(constraints)
    }

    /// Held directions of a node.
    pub fn at(&self, node: usize) -> &[Held<D>] {
        self.nodes.get(&node).map_or(&[], Vec::as_slice)
    }

    /// Adds a condition: a displacement along a direction.
    fn hold(
        &mut self,
        body: &Body<D>,
        node: usize,
        direction: Point<D>,
        prescribed: Prescribed,
        support: Option<usize>,
    ) -> Result<(), FemError> {
        let Prescribed {
            value,
            terms,
            mut still,
        } = prescribed;
        let held = self.nodes.entry(node).or_default();
        let (mut rest, mut implied, mut of_others) = (direction, 0.0, 0.0);
        for h in held.iter() {
            let part = dot(direction, h.axis);
            rest = add_scaled(rest, -part, h.axis);
            implied += part * h.value;
            of_others += part.abs() * h.terms;
            still &= h.still || part.abs() <= PARALLEL;
        }
        let (size, terms) = (norm(rest), terms.max(of_others));
        if size > PARALLEL {
            let axis = rest.map(|c| c / size);
            held.push(Held {
                axis,
                value: (value - implied) / size,
                terms: terms / size,
                still,
                supports: support.into_iter().collect(),
            });
            return Ok(());
        }
        let apart = (value - implied).abs();
        if apart > AGREE * terms && apart > f64::EPSILON * body.mesh.diameter() {
            let name = |index: Option<usize>| match index {
                Some(index) => describe(&body.supports[index].place),
                None => "by symmetry about the axis r = 0".to_string(),
            };
            let first = held.iter().max_by(|a, b| {
                dot(direction, a.axis)
                    .abs()
                    .total_cmp(&dot(direction, b.axis).abs())
            });
            return Err(FemError::Contradiction {
                node,
                point: show(body.mesh.points()[node]),
                first: first.map_or_else(String::new, |h| name(h.supports.first().copied())),
                second: name(support),
                a: implied,
                b: value,
            });
        }
        for h in held.iter_mut() {
            if dot(direction, h.axis).abs() > PARALLEL {
                let other = support.filter(|index| !h.supports.contains(index));
                h.supports.extend(other);
            }
        }
        Ok(())
    }
}

/// A radius below this part of the body's diameter is zero.
pub(crate) const ON_AXIS: f64 = 1e-9;

/// Nodes on the axis of symmetry.
fn nodes_on_axis<const D: usize>(mesh: &Mesh<D>) -> impl Iterator<Item = usize> {
    let limit = ON_AXIS * mesh.diameter();
    let radii = mesh.points().iter().map(|point| point[0]).enumerate();
    radii.filter(move |(_, r)| r.abs() <= limit).map(|(n, _)| n)
}

/// How messages name a place.
pub(crate) fn describe<const D: usize>(place: &Place<D>) -> String {
    match place {
        Place::Side(side) => format!("on side \"{side}\""),
        Place::Point(point) => format!("at point {}", show(*point)),
    }
}

/// Value of a field at a point; an error when it is not finite.
pub(crate) fn finite<const D: usize>(
    field: &Field,
    point: Point<D>,
    time: f64,
    what: impl FnOnce() -> String,
) -> Result<f64, FemError> {
    let value = field.at(point, time);
    if value.is_finite() {
        Ok(value)
    } else {
        Err(FemError::NotFinite {
            what: what(),
            text: field.to_string(),
            point: show(point),
        })
    }
}

/// The node nearest to a point; an error when it is farther than half the longest edge that meets there.
pub fn nearest_node<const D: usize>(
    mesh: &Mesh<D>,
    point: Point<D>,
    what: &str,
) -> Result<usize, FemError> {
    let nearest = mesh.nearest_node(point);
    let at = mesh.points()[nearest];
    let (gap, limit) = (distance(at, point), 0.5 * mesh.longest_edge_at(nearest));
    if gap <= limit {
        Ok(nearest)
    } else {
        Err(FemError::NoNodeNear {
            what: what.to_string(),
            point: show(point),
            node: nearest,
            at: show(at),
            distance: gap,
            limit,
        })
    }
}
