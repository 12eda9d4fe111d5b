//! Triangles of good shape inside an outline of straight lines and circular arcs, with holes and named edges.
//!
//! The outer path and the holes are closed and do not touch; their sense does not matter. Edges of one
//! name form one side. Edges without a name form the side `outline`, those of hole k the side `hole_k`, so that
//! every facet of the boundary is in exactly one side.
//!
//! Sizes are lengths of cell edges. The size of the outline holds everywhere, that of an edge along it, that of a point of
//! refinement around it; from each, the wanted size grows by `growth` per distance. Where two edges that do not share a
//! corner come nearer through the body than the size, the size is their distance; a piece of an arc spans at most 30°.
//! A mesh made anew takes a size field h as one more size: no edge within it is longer than 1.4·h in the middle of a triangle beside
//! it, and none at all than 1.5·h while h and the sizes grow by at most 0.5 per distance. It has at most about twice as many cells
//! as ∫ 4/(√3 h²) and the mesh without the field together.
//! Nodes of the boundary lie on the true lines and arcs, for quadratic cells the middle nodes, too; facets on arcs know them.
//!
//! **Matching nodes.** An edge is divided from its own data in a direction-independent way. The same edge of two
//! outlines has the same nodes when both give the same number of cells, or the same size and nothing near that wants
//! finer cells.
//!
//! Angles: at least 25° where the corners of the outline are at least 60° and neighbouring edges do not prescribe numbers of
//! cells that differ wildly; 30° or more is usual. The boundary is never divided further to raise an angle.

mod curve;
mod divide;
mod drawing;
mod fill;
mod lattice;
mod net;
mod nouns;
mod partition;
mod regions;
mod wishes;

pub(crate) use nouns::GROWTH;
pub use nouns::{
    Contour, Division, Drawing, EdgeShape, Outline, OutlineEdge, OutlinePart, OutlinePlace, Region,
};
pub use regions::Regions;

use crate::geometry::Point;
use crate::mesh::outline::divide::Sizes;
use crate::mesh::outline::drawing::Curves;
use crate::mesh::outline::net::Net;
use crate::mesh::outline::wishes::Wishes;
use crate::mesh::{Generator, Mesh, MeshError, SizeField};

impl Outline {
    /// The mesh: nodes of the boundary first, path after path.
    ///
    /// Errors, each naming the edge: coordinates that are not finite; edges of no length, that do not close, cross or touch;
    /// arcs that do not exist; a hole outside or in another one; sizes that are not positive or exceed the outline; a kind of
    /// cell that is not a triangle; more than two million corners of cells.
    pub fn build(&self) -> Result<Mesh<2>, MeshError> {
        let mesh = self.filled(&Wishes::default())?;
        Ok(mesh.made_by(self.clone()))
    }

    fn filled(&self, wishes: &Wishes<'_>) -> Result<Mesh<2>, MeshError> {
        let curves = Curves::of(self, wishes)?;
        let sizes = Sizes {
            largest: self.size,
            growth: self.growth,
            field: &wishes.field(&self.refine, self.growth),
            binding: wishes.sizes.is_some(),
        };
        sizes.few_enough(&curves.ribs, &[(0, curves.area, self.size)], &self.refine)?;
        let Curves { ribs, places, .. } = &curves;
        let too_many = || OutlinePlace::default().too_many();
        let net = Net::of(ribs, &sizes).ok_or_else(too_many)?;
        let part = net.fill((ribs, places), 0, None, &sizes)?;
        let sides = |rib: usize, _| curves.sides[rib].clone();
        net.mesh(ribs, self.cell, &[&part], sides)
    }
}

impl Generator<2> for Outline {
    fn anew(&self, sizes: &SizeField<2>, nodes: &[Point<2>]) -> Result<Mesh<2>, MeshError> {
        self.filled(&Wishes {
            sizes: Some(sizes),
            nodes,
        })
    }
}
