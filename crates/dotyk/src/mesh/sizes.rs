//! A size field: the largest wanted length of cell edges, as a function of place.
//!
//! Each point i wants cells of at most the size sᵢ up to the distance rᵢ from it. Beyond, the size grows by g per distance:
//!
//! ```text
//!   h(x) = minᵢ ( sᵢ + g·max(0, |x − xᵢ| − rᵢ) )
//! ```
//!
//! Without points h is infinite. Because |h(x) − h(y)| ≤ g·|x − y|, sizes of neighbouring cells differ by a factor of about 1 + g,
//! however much the wanted sizes differ. Sizes for the cells of a mesh are points in their middles with their radii: no place of
//! a cell gets more than its size.
//!
//! The minimum is found in a tree of boxes, each with the smallest sᵢ and the largest rᵢ of its points: a box is left out when the
//! nearest of its places cannot be smaller than what is known.

use crate::geometry::{Point, bounding_box, distance};
use crate::mesh::{Mesh, MeshError};
use std::ops::Range;
use std::sync::Arc;

/// Most points of a box that is not divided.
const LEAF: usize = 8;

/// A box is left out where it is too far by more than rounding.
const BOX_ROUNDING: f64 = 1.0 - 1e-12;

/// Smaller cells about a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizePoint<const D: usize = 2> {
    /// Centre.
    pub at: Point<D>,
    /// Size up to the radius.
    pub size: f64,
    /// Where the size begins to grow.
    pub radius: f64,
}

/// The largest wanted length of cell edges as a function of place. Copies share their points.
#[derive(Debug, Clone, Default)]
pub struct SizeField<const D: usize> {
    trees: Vec<Arc<Tree<D>>>,
}

/// Points that grow alike.
#[derive(Debug)]
struct Tree<const D: usize> {
    growth: f64,
    points: Vec<SizePoint<D>>,
    /// The first holds all points; the first child of a box stands behind it.
    boxes: Vec<Bounds<D>>,
}

#[derive(Debug)]
struct Bounds<const D: usize> {
    low: Point<D>,
    high: Point<D>,
    /// The smallest size of its points.
    least: f64,
    /// Their largest radius.
    reach: f64,
    points: Range<usize>,
    /// The second child; `None` of a box that is not divided.
    second: Option<usize>,
}

impl<const D: usize> SizePoint<D> {
    fn allowed(&self, growth: f64, x: Point<D>) -> f64 {
        self.size + growth * (distance(x, self.at) - self.radius).max(0.0)
    }

    /// Errors, under the name of a key of a generator: sizes that are not positive, numbers that are not finite, a negative radius.
    pub(crate) fn check(
        &self,
        generator: &'static str,
        key: &'static str,
    ) -> Result<(), MeshError> {
        let wrong = |value, need| MeshError::Parameter {
            generator,
            key,
            value,
            need,
        };
        if !(self.size > 0.0 && self.size.is_finite()) {
            let need = "the size at a point must be positive and finite";
            return Err(wrong(self.size.to_string(), need));
        }
        let finite = self.at.iter().all(|c| c.is_finite());
        if !(finite && self.radius >= 0.0 && self.radius.is_finite()) {
            let value = format!("{:?}, radius {}", self.at, self.radius);
            let need = "must have finite coordinates and a radius that is not negative";
            return Err(wrong(value, need));
        }
        Ok(())
    }
}

impl<const D: usize> SizeField<D> {
    /// The field of some points; the size grows by `growth` per distance beyond their radii.
    ///
    /// Errors: a size that is not positive and finite, coordinates or a radius that are not finite, a growth that is not in (0, 1].
    pub fn new(points: Vec<SizePoint<D>>, growth: f64) -> Result<Self, MeshError> {
        points
            .iter()
            .try_for_each(|p| p.check("size field", "point"))?;
        if !(growth > 0.0 && growth <= 1.0) {
            return Err(MeshError::Parameter {
                generator: "size field",
                key: "growth",
                value: growth.to_string(),
                need: "must be positive and at most 1",
            });
        }
        Ok(Self::of(points, growth))
    }

    /// The field of points that have been checked.
    pub(crate) fn of(mut points: Vec<SizePoint<D>>, growth: f64) -> Self {
        if points.is_empty() {
            return Self::default();
        }
        let mut boxes = Vec::new();
        let all = 0..points.len();
        divide(&mut points, all, &mut boxes);
        let tree = Tree {
            growth,
            points,
            boxes,
        };
        Self {
            trees: vec![Arc::new(tree)],
        }
    }

    /// The field of wanted sizes (cells,) of the cells of a mesh, block after block; infinity wants nothing of a cell.
    ///
    /// Errors: as [`Self::new`]; a number of sizes that is not that of the cells.
    pub fn of_cells(mesh: &Mesh<D>, sizes: &[f64], growth: f64) -> Result<Self, MeshError> {
        if sizes.len() != mesh.cell_count() {
            return Err(MeshError::Parameter {
                generator: "size field",
                key: "sizes",
                value: format!("{} for {} cells", sizes.len(), mesh.cell_count()),
                need: "give one for each cell",
            });
        }
        let blocks = mesh.blocks().iter().enumerate();
        let cells = blocks.flat_map(|(b, block)| (0..block.cells().len()).map(move |c| (b, c)));
        let wanted = cells.zip(sizes).filter(|(_, size)| **size != f64::INFINITY);
        let points = wanted.map(|((block, cell), &size)| {
            let (at, radius) = mesh.middle(block, cell);
            SizePoint { at, size, radius }
        });
        Self::new(points.collect(), growth)
    }

    /// The smaller of both.
    pub fn and(mut self, other: &Self) -> Self {
        self.trees.extend(other.trees.iter().cloned());
        self
    }

    /// Whether it has no points.
    pub fn is_empty(&self) -> bool {
        self.trees.is_empty()
    }

    /// The largest wanted length of cell edges at a place; infinite without points.
    pub fn at(&self, x: Point<D>) -> f64 {
        self.below(f64::INFINITY, x)
    }

    /// The same, but at most this.
    pub(crate) fn below(&self, most: f64, x: Point<D>) -> f64 {
        let trees = self.trees.iter();
        trees.fold(most, |least, tree| tree.below(0, least, x))
    }
}

impl<const D: usize> Tree<D> {
    /// The smaller of a number and of the sizes that the points of a box allow at a place.
    fn below(&self, index: usize, mut least: f64, x: Point<D>) -> f64 {
        let own = &self.boxes[index];
        if self.bound(index, x) >= least {
            return least;
        }
        let Some(second) = own.second else {
            let points = self.points[own.points.clone()].iter();
            return points.fold(least, |h, point| h.min(point.allowed(self.growth, x)));
        };
        let mut children = [index + 1, second];
        if self.bound(second, x) < self.bound(index + 1, x) {
            children.reverse();
        }
        for child in children {
            least = self.below(child, least, x);
        }
        least
    }

    /// No point of a box allows less at a place.
    fn bound(&self, index: usize, x: Point<D>) -> f64 {
        let own = &self.boxes[index];
        let nearest: Point<D> = std::array::from_fn(|d| x[d].clamp(own.low[d], own.high[d]));
        let away = BOX_ROUNDING * distance(x, nearest) - own.reach;
        BOX_ROUNDING * (own.least + self.growth * away.max(0.0))
    }
}

/// Adds the box of some points, and those of its halves along its longest axis.
fn divide<const D: usize>(
    all: &mut [SizePoint<D>],
    range: Range<usize>,
    boxes: &mut Vec<Bounds<D>>,
) {
    let points = &mut all[range.clone()];
    let places: Vec<Point<D>> = points.iter().map(|point| point.at).collect();
    let (low, high) = bounding_box(&places);
    let index = boxes.len();
    boxes.push(Bounds {
        low,
        high,
        least: points.iter().map(|p| p.size).fold(f64::INFINITY, f64::min),
        reach: points.iter().map(|p| p.radius).fold(0.0, f64::max),
        points: range.clone(),
        second: None,
    });
    if range.len() <= LEAF {
        return;
    }
    let extent = |d: &usize| high[*d] - low[*d];
    let axis = (0..D).max_by(|a, b| extent(a).total_cmp(&extent(b)));
    let (axis, half) = (axis.unwrap_or(0), range.len() / 2);
    points.select_nth_unstable_by(half, |a, b| a.at[axis].total_cmp(&b.at[axis]));
    let middle = range.start + half;
    divide(all, range.start..middle, boxes);
    boxes[index].second = Some(boxes.len());
    divide(all, middle..range.end, boxes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_tree_finds_the_least_size_to_the_last_bit(
            points in prop::collection::vec(
                ([-3.0..3.0f64, -1.0..1.0f64], -3.0..0.0f64, 0.0..0.3f64), 0..200),
            others in prop::collection::vec(([-3.0..3.0f64, -1.0..1.0f64], -2.0..0.0f64), 0..20),
            places in prop::collection::vec([-4.0..4.0f64, -4.0..4.0f64], 20),
        ) {
            let points = points.into_iter();
            let points: Vec<_> = points
                .map(|(at, size, radius)| SizePoint { at, size: 10.0_f64.powf(size), radius })
                .collect();
            let others = others.into_iter();
            let others: Vec<_> = others
                .map(|(at, size)| SizePoint { at, size: 10.0_f64.powf(size), radius: 0.0 })
                .collect();
            let field = SizeField::new(points.clone(), 0.3).unwrap();
            let field = field.and(&SizeField::new(others.clone(), 0.7).unwrap());
            for x in places {
                let all = points.iter().map(|p| p.allowed(0.3, x));
                let all = all.chain(others.iter().map(|p| p.allowed(0.7, x)));
                prop_assert_eq!(field.at(x), all.fold(f64::INFINITY, f64::min));
            }
        }
    }

    #[test]
    fn sizes_that_make_no_sense_are_refused() {
        let point = |size: f64| SizePoint {
            at: [0.0, 0.0],
            size,
            radius: 0.0,
        };
        for (points, growth, said) in [
            (
                vec![point(0.0)],
                0.3,
                "the size at a point must be positive",
            ),
            (
                vec![point(f64::NAN)],
                0.3,
                "the size at a point must be positive",
            ),
            (vec![point(1.0)], 0.0, "growth = 0"),
            (vec![point(1.0)], 1.5, "growth = 1.5"),
        ] {
            let error = SizeField::new(points, growth).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
        let mesh = crate::mesh::Outline::new(crate::mesh::Contour::circle([0.0, 0.0], 1.0), 0.5);
        let error = SizeField::of_cells(&mesh.build().unwrap(), &[1.0], 0.3).unwrap_err();
        assert!(
            error.to_string().contains("give one for each cell"),
            "{error}"
        );
    }
}
