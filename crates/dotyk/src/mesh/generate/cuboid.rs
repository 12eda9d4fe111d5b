//! Boxes: a rectangle carried along z.

use crate::geometry::Point;
use crate::mesh::generate::layers::{Layers, carried};
use crate::mesh::generate::tets::tetrahedra;
use crate::mesh::generate::{Diagonals, Rectangle, lines, within_reach, wrong};
use crate::mesh::{CellKind, Domain, Mesh, MeshError};

/// Axis-parallel box; sides left right (x) front back (y) bottom top (z).
///
/// Tetrahedra are six to a hexahedron, one for each order of the axes along which a path leads from its lowest to its highest
/// corner: the same cut everywhere, so that neighbours, and boxes on each other, match. Prisms are two to a hexahedron and
/// stand upright.
#[derive(Debug, Clone, PartialEq)]
pub struct Cuboid {
    /// Corner with the smallest coordinates.
    pub from: Point<3>,
    /// Corner with the largest coordinates.
    pub to: Point<3>,
    /// Hexahedra along x, y and z.
    pub cells: [usize; 3],
    /// Kind of cells.
    pub cell: CellKind,
}

impl Cuboid {
    /// The mesh, cells of one size.
    ///
    /// Errors: corners that are not finite or not `from` < `to`, no cells, too many cells, cells of the plane.
    pub fn build(&self) -> Result<Mesh<3>, MeshError> {
        let order = self.cell.order();
        let counts = self.cells.iter().map(|&n| (order * n) as u128 + 1);
        within_reach(counts.fold(1, u128::saturating_mul))?;
        let [_, _, z] = lines("box", self.from, self.to, self.cells)?;
        let Some((plane, solid)) = plane_and_solid(self.cell) else {
            let value = self.cell.name().to_string();
            return Err(wrong("box", "cell", value, CELLS_OF_SPACE));
        };
        let base = Rectangle {
            from: [self.from[0], self.from[1]],
            to: [self.to[0], self.to[1]],
            cells: [self.cells[0], self.cells[1]],
            cell: plane,
            diagonals: Diagonals::Forward,
        };
        let base = base.build()?;
        let nodes = base.points().len();
        let layers = Layers::new(
            base.blocks(),
            vec![solid],
            nodes,
            self.cells[2],
            false,
            None,
        );
        let mut points = Vec::with_capacity(layers.count);
        layers.points(&mut points, |node, level| {
            let [x, y] = base.points()[node];
            let (below, above) = (z[level / order], z[level.div_ceil(order)]);
            [x, y, 0.5 * (below + above)]
        });
        let mut sides = layers.sides(base.sides());
        for (of_plane, of_box) in [("top", "back"), ("bottom", "front")] {
            let facets = sides.remove(of_plane).unwrap_or_default();
            sides.insert(of_box.to_string(), facets);
        }
        for (name, last) in [("bottom", false), ("top", true)] {
            sides.insert(name.to_string(), layers.ends(last));
        }
        let mesh = Mesh::new(points, layers.blocks())?.with_sides(sides)?;
        let mesh = match self.cell.domain() {
            Domain::Tetrahedron => tetrahedra(&mesh)?,
            _ => mesh,
        };
        Ok(mesh.made_by(self.clone()))
    }
}

pub(super) const CELLS_OF_SPACE: &str =
    "give tet4, tet10, hex8, hex20, hex27, prism6, prism15 or prism18";

/// The cells of the plane from which these cells of space are extruded, and the extruded kind; tetrahedra are cut from hexahedra
/// afterwards. `None`: these are not cells of space.
pub(super) fn plane_and_solid(cell: CellKind) -> Option<(CellKind, CellKind)> {
    let full = cell != CellKind::Prism15;
    let plane = match cell {
        CellKind::Tet4 | CellKind::Hex8 => CellKind::Quad4,
        CellKind::Tet10 | CellKind::Hex27 => CellKind::Quad9,
        CellKind::Hex20 => CellKind::Quad8,
        CellKind::Prism6 => CellKind::Tri3,
        CellKind::Prism15 | CellKind::Prism18 => CellKind::Tri6,
        _ => return None,
    };
    Some((plane, carried(plane, full)))
}
