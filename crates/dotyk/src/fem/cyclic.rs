//! Cyclic symmetry: a body that is one of N equal sectors around an axis.
//!
//! ```text
//!   u(R x) = R u(x)      on the face `from`,     R the turn by 360°/N that takes it to the face `to`
//! ```
//!
//! Loads and supports are those of one sector; all sectors bear the same. The turn about the axis stays free, and in space the shift along
//! it: what holds them is up to supports and contacts.

use crate::fem::coincident::{SAME, largest_facet, partners, placed};
use crate::fem::error::{FemError, show};
use crate::fem::nouns::Body;
use crate::geometry::{Point, add_scaled, cross, dot, padded, sub, unit};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// The cyclic symmetry of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Cyclic<const D: usize> {
    /// Side of the sector.
    pub from: String,
    /// The side on which `from` lies after a turn by one sector, in either sense.
    pub to: String,
    /// Number of sectors in the full turn, at least 2.
    pub sectors: usize,
    /// A point of the axis.
    pub point: Point<D>,
    /// Direction of the axis, of any length; in the plane z.
    pub axis: [f64; 3],
}

/// A turn about an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn<const D: usize> {
    point: Point<D>,
    /// Unit vector.
    axis: [f64; 3],
    /// Sine and cosine of its angle.
    angle: [f64; 2],
}

impl<const D: usize> Cyclic<D> {
    /// The error that its faces are not the same.
    pub(crate) fn unlike(&self, why: &str) -> FemError {
        FemError::Unlike {
            from: self.from.clone(),
            to: self.to.clone(),
            sectors: self.sectors,
            axis: show(self.point),
            why: why.to_string(),
        }
    }

    /// The turn by one sector, the right-handed one about the axis or the other; `None` where the axis has no direction,
    /// and for fewer than two sectors.
    pub(crate) fn turn(&self, right_handed: bool) -> Option<Turn<D>> {
        if self.sectors < 2 {
            return None;
        }
        let (sin, cos) = (TAU / self.sectors as f64).sin_cos();
        let sin = if right_handed { sin } else { -sin };
        Some(Turn {
            point: self.point,
            axis: unit(self.axis)?,
            angle: [sin, cos],
        })
    }
}

/// Nodes of the two faces of a sector that are one place of the whole.
pub(crate) struct Twins<const D: usize> {
    /// Takes a node of the first face to its twin.
    pub turn: Turn<D>,
    /// One of each face; nodes on the axis have no twin.
    pub pairs: Vec<[usize; 2]>,
}

impl<const D: usize> Body<D> {
    /// Its twins; `None` if it is no sector.
    pub(crate) fn twins(&self) -> Option<Twins<D>> {
        let cyclic = self.cyclic.as_ref()?;
        let within = SAME * largest_facet(&self.mesh, &cyclic.to);
        let [from, to] = [&cyclic.from, &cyclic.to].map(|side| placed(&self.mesh, side));
        let of_sense = |right_handed: bool| {
            let turn = cyclic.turn(right_handed)?;
            let turned = from.iter().map(|&(node, x)| (node, turn.place(x)));
            let turned: Vec<_> = turned.collect();
            let found = partners([&turned, &to], within).into_iter().zip(&from);
            let pairs = found.filter_map(|(twin, &(node, _))| Some([node, twin?]));
            let pairs = pairs.filter(|[node, twin]| node != twin).collect();
            Some(Twins { turn, pairs })
        };
        let (one, other) = (of_sense(true)?, of_sense(false)?);
        Some(match other.pairs.len() > one.pairs.len() {
            true => other,
            false => one,
        })
    }

    /// Some nodes, and their twins.
    pub(crate) fn with_twins(&self, mut nodes: BTreeSet<usize>) -> BTreeSet<usize> {
        for pair in self.twins().into_iter().flat_map(|twins| twins.pairs) {
            if pair.iter().any(|node| nodes.contains(node)) {
                nodes.extend(pair);
            }
        }
        nodes
    }
}

impl<const D: usize> Twins<D> {
    /// Gives twins the sum of the vectors of both.
    pub fn add_up(&self, vectors: &mut BTreeMap<usize, Point<D>>) {
        for [node, twin] in &self.pairs {
            if let (Some(&own), Some(&other)) = (vectors.get(node), vectors.get(twin)) {
                let sum = add_scaled(own, 1.0, self.turn.back(other));
                vectors.insert(*node, sum);
                vectors.insert(*twin, self.turn.vector(sum));
            }
        }
    }
}

impl<const D: usize> Turn<D> {
    /// The turn by nothing.
    pub fn none() -> Self {
        Self {
            point: [0.0; D],
            axis: [0.0, 0.0, 1.0],
            angle: [0.0, 1.0],
        }
    }

    /// A vector after the turn: R v.
    pub fn vector(&self, v: Point<D>) -> Point<D> {
        self.by(self.angle[0], v)
    }

    /// A vector before it: Rᵀ v.
    pub fn back(&self, v: Point<D>) -> Point<D> {
        self.by(-self.angle[0], v)
    }

    /// Where it takes a point.
    pub fn place(&self, x: Point<D>) -> Point<D> {
        add_scaled(self.point, 1.0, self.vector(sub(x, self.point)))
    }

    /// v cos + a×v sin + a (a·v)(1 − cos), Rodrigues' formula.
    fn by(&self, sin: f64, v: Point<D>) -> Point<D> {
        let cos = self.angle[1];
        let v = padded(v);
        let beside = cross(self.axis, v);
        let along = dot(self.axis, v) * (1.0 - cos);
        std::array::from_fn(|d| cos * v[d] + sin * beside[d] + along * self.axis[d])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_about_its_axis_and_ends_after_all_sectors() {
        let cyclic = Cyclic {
            from: String::new(),
            to: String::new(),
            sectors: 7,
            point: [1.0, -2.0, 0.5],
            axis: [1.0, 2.0, -2.0],
        };
        let turn = cyclic.turn(true).unwrap();
        let start = [0.3, 4.0, 1.0];
        let end = (0..7).fold(start, |x, _| turn.place(x));
        assert!((0..3).all(|d| (end[d] - start[d]).abs() < 1e-13), "{end:?}");
        let along = turn.place([2.0, 0.0, -1.5]);
        assert!((0..3).all(|d| (along[d] - [2.0, 0.0, -1.5][d]).abs() < 1e-14));
        let back = turn.back(turn.vector(start));
        assert!((0..3).all(|d| (back[d] - start[d]).abs() < 1e-14));
        assert!(
            dot(
                turn.vector([0.0, 2.0, 2.0]),
                cross([1.0, 2.0, -2.0], [0.0, 2.0, 2.0])
            ) > 0.0
        );
    }
}
