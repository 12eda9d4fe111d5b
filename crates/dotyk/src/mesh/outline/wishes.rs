//! What a mesh made anew wants beside the outline or drawing: smaller cells, and nodes at some points of its lines.
//!
//! Lines are cut at these points. Where cells shall be smaller, a number of cells of an edge becomes the length of one of them:
//! the edge is divided like the others.

use crate::geometry::{Point, distance};
use crate::mesh::outline::drawing::Drawn;
use crate::mesh::outline::nouns::Division;
use crate::mesh::{SizeField, SizePoint};

/// Wishes of a mesh made anew; none by default.
#[derive(Default)]
pub(crate) struct Wishes<'a> {
    pub sizes: Option<&'a SizeField<2>>,
    pub nodes: &'a [Point<2>],
}

impl Wishes<'_> {
    /// The sizes of the points of refinement, and those that are wanted.
    pub fn field(&self, refine: &[SizePoint], growth: f64) -> SizeField<2> {
        let own = SizeField::of(refine.to_vec(), growth);
        self.sizes.map_or(own.clone(), |sizes| own.and(sizes))
    }

    /// The parts of some curves between nodes nearer to them than `near`, without numbers of cells.
    pub fn cut(&self, drawn: Vec<Drawn>, near: f64) -> Vec<Drawn> {
        match self.sizes {
            None => drawn,
            Some(_) => drawn.iter().flat_map(|d| self.parts(d, near)).collect(),
        }
    }

    fn parts(&self, drawn: &Drawn, near: f64) -> Vec<Drawn> {
        let curve = &drawn.curve;
        let inside = self.nodes.iter().filter(|&&node| {
            let [from, to] = [curve.start, curve.end].map(|end| distance(node, end));
            from > near && to > near && distance(node, curve.nearest(node)) <= near
        });
        let mut ends = vec![(0.0, curve.start)];
        ends.extend(inside.map(|&node| (curve.parameter(node), node)));
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.dedup_by(|b, a| distance(a.1, b.1) <= near);
        ends.push((1.0, curve.end));
        let division = match drawn.division {
            Some(Division::Cells(cells)) => Some(Division::Size(curve.length() / cells as f64)),
            other => other,
        };
        let between = |ends: &[(f64, Point<2>)]| Drawn {
            curve: curve.part([ends[0].0, ends[1].0], [ends[0].1, ends[1].1]),
            division,
            ..drawn.clone()
        };
        ends.windows(2).map(between).collect()
    }
}
