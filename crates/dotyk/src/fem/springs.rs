//! Springs: beddings of sides and weak supports of points, which count as part of the stiffness of their body.
//!
//! ```text
//!   t = −(kₙ n⊗n + kₜ (1 − n⊗n)) (u − u_a)    per area of a side,        f_i = −k_i (u_i − u_a,i)    at a node
//!   K += ∫ NᵀCN dS,      f += ∫ NᵀC u_a dS,     C the tensor above
//! ```
//!
//! u_a is the displacement at which a spring came, without a force. A bed that only presses bears along the normal by a
//! condition of its own (`model/system/bed.rs`); here it has only its tangential part. n is the normal of the surface behind
//! the side (`fem/surface.rs`), so that a bed along the radius does not resist a spin.
//!
//! kₙ and kₜ may vary along the side, and are taken at its points of integration; they are the same at all times, because they are
//! part of K. A spring that gets stiffer is one more spring, active from then on.
//!
//! Units: kₙ, kₜ force per area and length, to be multiplied by the thickness or 2πr; k_i force per length.

use crate::fem::cells::measure;
use crate::fem::error::{FemError, show};
use crate::fem::loads::{SidePoint, points_of_degree, side_points};
use crate::fem::nouns::{Active, Analysis, Body, History, Place};
use crate::fem::supports::nearest_node;
use crate::fem::surface::SideNormals;
use crate::geometry::{Field, Point, add_scaled, dot, norm};
use std::collections::BTreeMap;

/// Where a spring acts, and how stiff it is.
#[derive(Debug, Clone)]
pub enum Bed<const D: usize> {
    /// All over a side.
    Side {
        /// Side of the body.
        side: String,
        /// Force per area and displacement along the normal, by place.
        normal: Field,
        /// The same across it, in every direction.
        tangential: Field,
        /// Along the normal it presses and does not pull; across it acts either way.
        compression_only: bool,
    },
    /// At the node nearest to a point.
    Point {
        /// The point.
        point: Point<D>,
        /// Force per displacement along each axis.
        stiffness: [f64; D],
    },
}

/// A stiffness belongs to no time. What depends on time is no number then, and is refused.
const NO_TIME: f64 = f64::NAN;

/// Beds are equal if their stiffnesses are; two functions are so only if one is a copy of the other.
impl<const D: usize> PartialEq for Bed<D> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Side {
                    side,
                    normal,
                    tangential,
                    compression_only,
                },
                Self::Side {
                    side: other_side,
                    normal: other_normal,
                    tangential: other_tangential,
                    compression_only: other_only,
                },
            ) => {
                (side, compression_only) == (other_side, other_only)
                    && normal.is_copy_of(other_normal)
                    && tangential.is_copy_of(other_tangential)
            }
            (
                Self::Point { point, stiffness },
                Self::Point {
                    point: other,
                    stiffness: k,
                },
            ) => (point, stiffness) == (other, k),
            _ => false,
        }
    }
}

/// A spring between a body and fixed ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring<const D: usize> {
    /// Where and how stiff.
    pub bed: Bed<D>,
    /// When it is present. One that comes later than its body has no force at the displacements of that time.
    pub active: Active,
}

impl<const D: usize> Spring<D> {
    /// Where it acts.
    pub fn place(&self) -> Place<D> {
        match &self.bed {
            Bed::Side { side, .. } => Place::Side(side.clone()),
            Bed::Point { point, .. } => Place::Point(*point),
        }
    }

    /// It is a bed that presses along the normal and does not pull.
    pub(crate) fn only_presses(&self) -> bool {
        matches!(&self.bed, Bed::Side { normal, compression_only: true, .. } if !is_zero(normal))
    }

    /// Stiffness of a side's spring along the normal and across it at a point, whichever way it acts.
    fn stiffness_at(&self, point: Point<D>) -> [f64; 2] {
        match &self.bed {
            Bed::Side {
                normal, tangential, ..
            } => [normal, tangential].map(|field| field.at(point, NO_TIME)),
            Bed::Point { .. } => [0.0; 2],
        }
    }

    /// The same that holds in both directions.
    fn held_at(&self, point: Point<D>) -> [f64; 2] {
        let [normal, across] = self.stiffness_at(point);
        [if self.only_presses() { 0.0 } else { normal }, across]
    }

    /// Force per area at a point of a side's spring stretched by a displacement, without a normal part that only presses.
    pub(crate) fn traction(&self, point: Point<D>, n: Point<D>, stretched: Point<D>) -> Point<D> {
        let [normal, across] = self.held_at(point);
        let along = add_scaled([0.0; D], (across - normal) * dot(n, stretched), n);
        add_scaled(along, -across, stretched)
    }

    /// The points of its side with the stiffness there, those of sampled fields asked for together.
    ///
    /// Errors: a stiffness that is negative or no number, or is nowhere positive.
    fn sampled(
        &self,
        points: Vec<SidePoint<D>>,
    ) -> Result<Vec<(SidePoint<D>, [f64; 2])>, FemError> {
        let Bed::Side {
            side,
            normal,
            tangential,
            ..
        } = &self.bed
        else {
            return Ok(Vec::new());
        };
        self.check()?;
        let fields = [normal, tangential];
        Field::prepare(fields, points.iter().map(|at| at.point), NO_TIME);
        let mut positive = false;
        let mut sampled = Vec::with_capacity(points.len());
        for at in points {
            let values = self.stiffness_at(at.point);
            for (field, value) in fields.iter().zip(values) {
                positive |= value > 0.0;
                if !(value.is_finite() && value >= 0.0) {
                    return Err(FemError::Bed {
                        side: side.clone(),
                        text: field.to_string(),
                        value,
                        point: show(at.point),
                    });
                }
            }
            sampled.push((at, values));
        }
        match positive {
            true => Ok(sampled),
            false => Err(self.nowhere(is_zero(tangential))),
        }
    }

    /// The error that a bed has no stiffness at its points, along the normal or at all.
    pub(crate) fn nowhere(&self, along_normal: bool) -> FemError {
        match &self.bed {
            Bed::Point { .. } => FemError::Spring { value: 0.0 },
            Bed::Side {
                side,
                normal,
                tangential,
                ..
            } => FemError::NoStiffness {
                side: side.clone(),
                texts: match along_normal {
                    true => normal.to_string(),
                    false => format!("each of {normal} and {tangential}"),
                },
            },
        }
    }

    /// Stiffnesses that are numbers are so from 0 on, and not all of them 0.
    fn check(&self) -> Result<(), FemError> {
        let all: Vec<f64> = match &self.bed {
            Bed::Side {
                normal, tangential, ..
            } => {
                let constants = [normal, tangential].map(Field::as_constant);
                constants.into_iter().flatten().collect()
            }
            Bed::Point { stiffness, .. } => stiffness.to_vec(),
        };
        let wrong = |value: &&f64| !(value.is_finite() && **value >= 0.0);
        let varies = matches!(&self.bed, Bed::Side { .. }) && all.len() < 2;
        match all.iter().find(wrong) {
            Some(&value) => Err(FemError::Spring { value }),
            None if !varies && all.iter().all(|&k| k == 0.0) => {
                Err(FemError::Spring { value: 0.0 })
            }
            None => Ok(()),
        }
    }
}

fn is_zero(field: &Field) -> bool {
    field.as_constant() == Some(0.0)
}

/// A point at which a spring acts: nodes with their shape functions, the directions in which it holds, and the tensor C times the
/// area there.
struct Share<const D: usize> {
    nodes: Vec<(usize, f64)>,
    held: Vec<Point<D>>,
    tensor: [Point<D>; D],
}

fn scaled_axes<const D: usize>(scale: [f64; D]) -> [Point<D>; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { scale[i] } else { 0.0 }))
}

/// The points of a spring.
fn shares<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    spring: &Spring<D>,
) -> Result<Vec<Share<D>>, FemError> {
    match &spring.bed {
        Bed::Point { point, stiffness } => {
            let node = nearest_node(&body.mesh, *point, "spring")?;
            let axes = scaled_axes([1.0; D]).into_iter().zip(stiffness);
            Ok(vec![Share {
                nodes: vec![(node, 1.0)],
                held: axes.filter(|(_, k)| **k > 0.0).map(|(a, _)| a).collect(),
                tensor: scaled_axes(*stiffness),
            }])
        }
        Bed::Side {
            side, tangential, ..
        } => {
            let points = match varies(body, side) {
                true => bed_points(body, side, analysis)?,
                false => side_points(body, side, analysis)?.collect(),
            };
            let points = spring.sampled(points)?.into_iter();
            let presses = spring.only_presses();
            if presses && is_zero(tangential) {
                return Ok(Vec::new());
            }
            let normals = SideNormals::new(body, side)?;
            let share = |(place, [normal, across]): (SidePoint<D>, [f64; 2])| {
                let normal = if presses { 0.0 } else { normal };
                let nodes = body.mesh.facet_nodes(place.facet).zip(place.shape);
                let n = normals.at(place.facet, &place.xi);
                let mut tensor = scaled_axes([across * place.area; D]);
                for (row, c) in tensor.iter_mut().zip(n) {
                    *row = add_scaled(*row, (normal - across) * place.area * c, n);
                }
                let axes = scaled_axes([1.0; D]).into_iter();
                let along = axes.map(|axis| add_scaled(axis, -dot(axis, n), n));
                let along = along.filter(|axis| across > 0.0 && norm(*axis) > 0.1);
                Share {
                    nodes: nodes.map(|(node, n)| (node as usize, n)).collect(),
                    held: along.chain((normal > 0.0).then_some(n)).collect(),
                    tensor,
                }
            };
            Ok(points.map(share).collect())
        }
    }
}

/// Row, column and value of an entry of a matrix.
pub(super) type Entry = (usize, usize, f64);

/// Entries of the stiffness of the springs of a body, in global axes, both triangles.
///
/// Errors: as [`spring_points`].
pub(crate) fn spring_stiffness<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
) -> Result<Vec<Entry>, FemError> {
    let mut sums: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for (i, j, value) in spring_points(body, analysis)?.into_iter().flatten() {
        *sums.entry((i, j)).or_insert(0.0) += value;
    }
    Ok(sums.into_iter().map(|((i, j), v)| (i, j, v)).collect())
}

/// The same of every point of the springs, whose stiffness is not negative by itself.
///
/// Errors: a stiffness that is negative or no number, unknown or empty sides, points off the body.
pub(super) fn spring_points<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
) -> Result<Vec<Vec<Entry>>, FemError> {
    let mut points = Vec::new();
    for spring in &body.springs {
        spring.check()?;
        for share in shares(body, analysis, spring)? {
            let mut entries = Vec::new();
            for &(a, na) in &share.nodes {
                for &(b, nb) in &share.nodes {
                    for (i, row) in share.tensor.iter().enumerate() {
                        for (j, value) in row.iter().enumerate() {
                            entries.push((D * a + i, D * b + j, na * nb * value));
                        }
                    }
                }
            }
            points.push(entries);
        }
    }
    Ok(points)
}

/// Nodal forces that displace a spring of a body, (nodes,), in global axes: ∫ NᵀCu dS.
fn force<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    spring: &Spring<D>,
    u: &[Point<D>],
) -> Result<Vec<Point<D>>, FemError> {
    let mut forces = vec![[0.0; D]; body.mesh.points().len()];
    for share in shares(body, analysis, spring)? {
        let nodes = share.nodes.iter();
        let at = nodes.fold([0.0; D], |sum, &(node, n)| add_scaled(sum, n, u[node]));
        let force: Point<D> = share.tensor.map(|row| dot(row, at));
        for &(node, n) in &share.nodes {
            forces[node] = add_scaled(forces[node], n, force);
        }
    }
    Ok(forces)
}

/// Nodal forces that displace each spring of a body, (nodes,), in global axes: its own K u.
pub(crate) fn spring_forces<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
    displacement: &[Point<D>],
) -> Result<Vec<Vec<Point<D>>>, FemError> {
    let springs = body.springs.iter();
    springs
        .map(|spring| force(body, analysis, spring, displacement))
        .collect()
}

/// The load of each spring that came later, (nodes,), with its place: its own K u_a, so that it has no force at u_a.
pub(crate) fn spring_loads<const D: usize>(
    (body, history): (&Body<D>, &History<D>),
    analysis: Analysis,
) -> Result<Vec<(usize, Vec<Point<D>>)>, FemError> {
    let placed = history.sprung.iter();
    placed
        .map(|(&k, u)| Ok((k, force(body, analysis, &body.springs[k], u)?)))
        .collect()
}

/// A point of a bed.
pub(crate) struct Pad<const D: usize> {
    /// Nodes with their shape functions.
    pub nodes: Vec<(usize, f64)>,
    /// Undeformed place.
    pub point: Point<D>,
    /// Outward unit normal.
    pub normal: Point<D>,
    /// Its part of the area, thickness or the full turn included, and without these.
    pub area: f64,
    pub extent: f64,
    /// Force per area and displacement along the normal and across it.
    pub stiffness: [f64; 2],
}

impl<const D: usize> Pad<D> {
    /// There is a spring along the normal.
    pub fn bears(&self) -> bool {
        self.stiffness[0] > 0.0
    }
}

/// Whether the stiffness of a spring of a side varies along it.
fn varies<const D: usize>(body: &Body<D>, of: &str) -> bool {
    body.springs.iter().any(|spring| match &spring.bed {
        Bed::Side {
            side,
            normal,
            tangential,
            ..
        } => side == of && [normal, tangential].map(Field::as_constant).contains(&None),
        Bed::Point { .. } => false,
    })
}

/// The points at which the beds of a side are read: the fewest that, if at each there is a spring that presses, give the stiffness
/// ∫ NᵀCN dS of straight facets, for a C that varies a polynomial of degree 2. The stiffness of a bed that varies is taken there,
/// too, so that what it bears is what it is told to bear.
fn bed_points<const D: usize>(
    body: &Body<D>,
    side: &str,
    analysis: Analysis,
) -> Result<Vec<SidePoint<D>>, FemError> {
    // with axial symmetry the radius is one more factor
    let more = usize::from(analysis == Analysis::Axisymmetric);
    let more = more + if varies(body, side) { 2 } else { 0 };
    Ok(points_of_degree(body, side, analysis, |kind| 2 * kind.order() + more)?.collect())
}

/// The points of a bed.
///
/// Errors: an unknown or empty side; a stiffness that is negative or no number.
pub(crate) fn pads<const D: usize>(
    body: &Body<D>,
    spring: &Spring<D>,
    analysis: Analysis,
) -> Result<Vec<Pad<D>>, FemError> {
    let Bed::Side { side, .. } = &spring.bed else {
        return Ok(Vec::new());
    };
    let normals = SideNormals::new(body, side)?;
    let pad = |(place, stiffness): (SidePoint<D>, [f64; 2])| {
        let nodes = body.mesh.facet_nodes(place.facet).zip(place.shape);
        Pad {
            nodes: nodes.map(|(node, n)| (node as usize, n)).collect(),
            point: place.point,
            normal: normals.at(place.facet, &place.xi),
            area: place.area,
            extent: place.area / measure(analysis, body.thickness, place.point),
            stiffness,
        }
    };
    let points = spring.sampled(bed_points(body, side, analysis)?)?;
    Ok(points.into_iter().map(pad).collect())
}

/// A held direction at a place: nodes with their shape functions there, and the unit vector.
pub(crate) type Direction<const D: usize> = (Vec<(usize, f64)>, Point<D>);

/// The directions in which springs hold a body, at all their places: a motion orthogonal to all of them stretches no spring.
///
/// Errors: unknown or empty sides, points off the body.
pub(crate) fn sprung_directions<const D: usize>(
    body: &Body<D>,
    analysis: Analysis,
) -> Result<Vec<Direction<D>>, FemError> {
    let mut all = Vec::new();
    for spring in &body.springs {
        for Share { nodes, held, .. } in shares(body, analysis, spring)? {
            all.extend(held.into_iter().map(|axis| (nodes.clone(), axis)));
        }
    }
    Ok(all)
}
