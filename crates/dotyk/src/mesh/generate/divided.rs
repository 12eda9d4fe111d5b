//! Structured meshes of space made anew with a size field: each cell is divided into k³.

use crate::geometry::Point;
use crate::mesh::generate::{Cuboid, Cylinder, MOST_POINTS, Sphere};
use crate::mesh::{Generator, Mesh, MeshError, SizeField};

/// An edge is as long as wanted within rounding.
const LONG: f64 = 1.0 + 1e-9;

macro_rules! divided {
    ($($Solid:ident)*) => {$(
        impl Generator<3> for $Solid {
            fn anew(&self, sizes: &SizeField<3>, _: &[Point<3>]) -> Result<Mesh<3>, MeshError> {
                finer(sizes, self.cells, |cells| Self { cells, ..self.clone() }.build())
            }
        }
    )*};
}

divided!(Cuboid Cylinder Sphere);

/// A mesh of k times so many cells in each direction, with an edge of at most the size wanted in the middle of each cell.
fn finer<const N: usize>(
    sizes: &SizeField<3>,
    counts: [usize; N],
    build: impl Fn([usize; N]) -> Result<Mesh<3>, MeshError>,
) -> Result<Mesh<3>, MeshError> {
    let mut k: usize = 1;
    loop {
        let mesh = build(counts.map(|n| n.saturating_mul(k).min(MOST_POINTS)))?;
        let blocks = mesh.blocks().iter().enumerate();
        let cells = blocks.flat_map(|(b, block)| (0..block.cells().len()).map(move |c| (b, c)));
        let excess = cells.map(|(block, cell)| {
            mesh.longest_edge(block, cell) / sizes.at(mesh.middle(block, cell).0)
        });
        let worst = excess.fold(0.0, f64::max);
        if worst <= LONG {
            return Ok(mesh);
        }
        k = (k + 1).max((k as f64 * worst) as usize);
    }
}
