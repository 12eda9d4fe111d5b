//! Solids of revolution and extrusion: plane meshes carried along a line or around an axis, cylinders, spheres.
//!
//! A cylinder is a ring or a disc carried along its axis. A shell between two polar angles is a ring or a disc as well: radius
//! there is polar angle here, and the layers are concentric spheres. A whole ball is a cube q ∈ [−1, 1]³ and layers around its
//! faces: the outermost nodes stand in the directions of tan(πqᵢ/4), so that they are spaced equally along the equators; the
//! core lies between a cube and a ball (Nowell's map, qᵢ√(1 − qⱼ²/2 − qₖ²/2 + qⱼ²qₖ²/3)). A part of it around a pole is the
//! half with qz ≥ 0, its polar angles scaled.
//! Nodes of second order are images of the same functions: on the true circles, cylinders and spheres.

use crate::geometry::{Point, Surface, add_scaled, dot, norm, sub, unit};
use crate::mesh::generate::axis::around_axis;
use crate::mesh::generate::cuboid::{Cuboid, plane_and_solid};
use crate::mesh::generate::disc::Disc;
use crate::mesh::generate::layers::{Layers, carried};
use crate::mesh::generate::tets::tetrahedra;
use crate::mesh::generate::{
    Diagonals, Ring, between, direction, is_full, pieces, within_reach, wrong,
};
use crate::mesh::{CellBlock, CellKind, Domain, Facet, MAX_CELL_NODES, Mesh, MeshError};
use std::collections::BTreeMap;

/// A plane mesh carried along z or around an axis; its sides keep their names, `first` and `last` are its two ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Extrude {
    /// The plane mesh, drawn at z = 0.
    pub mesh: Mesh<2>,
    /// The path of the extrusion.
    pub path: Path,
    /// Where it begins: z, or degrees of the turn from z = 0.
    pub offset: f64,
    /// Layers of cells.
    pub layers: usize,
}

/// The path along which a plane mesh is extruded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Path {
    /// Along z by this height, downwards if it is negative.
    Straight(f64),
    /// Around an axis in the plane z = 0, right-handed. What lies on the axis stays there.
    Turn {
        /// A point of the axis.
        point: Point<3>,
        /// Its direction, of any length.
        axis: Point<3>,
        /// In degrees, in (0, 360], or left-handed in [−360, 0).
        angle: f64,
    },
}

/// Cylinder, pipe or a part of their turn; sides bottom top outer, inner where it is hollow, start end unless it is full.
///
/// 0° is +x, turned with +z onto the axis by the smallest rotation (about x where the axis is −z); angles are right-handed
/// about the axis. A solid one has a core of proper cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Cylinder {
    /// Centre of the bottom.
    pub base: Point<3>,
    /// Direction of the axis, of any length.
    pub axis: Point<3>,
    /// Outer radius.
    pub radius: f64,
    /// Inner radius; 0: solid.
    pub inner: f64,
    /// Length along the axis.
    pub height: f64,
    /// First and last angle in degrees; `None`: the full turn.
    pub angles: Option<[f64; 2]>,
    /// Cells around, through (in a solid one from the core to the surface) and along.
    pub cells: [usize; 3],
    /// Kind of cells: tetrahedra or hexahedra.
    pub cell: CellKind,
}

/// Ball, shell, or a part of them between two polar angles from +z; sides outer, inner where it is hollow, and start and end
/// at the polar angles that are not 0° and 180°.
///
/// A solid one has a core of proper cells, and reaches a pole.
#[derive(Debug, Clone, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Point<3>,
    /// Outer radius.
    pub radius: f64,
    /// Inner radius; 0: solid.
    pub inner: f64,
    /// First and last polar angle in degrees, in [0, 180].
    pub angles: [f64; 2],
    /// Cells around, and through (in a solid one from the core to the surface).
    pub cells: [usize; 2],
    /// Kind of cells: tetrahedra or hexahedra.
    pub cell: CellKind,
}

/// A plane mesh carried along layers: callbacks give the point from node and level, and the surface over an edge from the edge and its
/// curve. The ends are the sides `ends`.
fn carry(
    plane: &Mesh<2>,
    full: bool,
    (layers, closed): (usize, bool),
    ends: [&str; 2],
    at: impl Fn(Point<2>, usize) -> Point<3>,
    over: impl Fn(&Mesh<2>, Facet) -> Option<Surface<3>>,
) -> Result<Mesh<3>, MeshError> {
    let order = plane.blocks()[0].kind.order();
    let levels = order * layers + 1;
    within_reach(plane.points().len() as u128 * levels as u128)?;
    let full = full || has_centres(plane);
    let kinds = plane
        .blocks()
        .iter()
        .map(|b| carried(b.kind, full))
        .collect();
    let nodes = plane.points().len();
    let stack = Layers::new(plane.blocks(), kinds, nodes, layers, closed, None);
    let mut points = Vec::with_capacity(stack.count);
    stack.points(&mut points, |node, level| at(plane.points()[node], level));
    let mut curves = BTreeMap::new();
    for edge in plane.boundary_facets() {
        if let Some(surface) = over(plane, edge) {
            curves.extend(stack.over(edge).map(|facet| (facet, surface)));
        }
    }
    let mut sides = stack.sides(plane.sides());
    if !closed {
        for (name, last) in [(ends[0], false), (ends[1], true)] {
            if sides.insert(name.to_string(), stack.ends(last)).is_some() {
                let side = name.to_string();
                return Err(MeshError::SideExists { side });
            }
        }
    }
    Mesh::assembled(points, stack.blocks(), sides, curves)
}

/// Whether quadrilaterals of a plane mesh have a node in their centre. Then the faces over their edges have one, and all
/// neighbouring cells must have it, too.
fn has_centres(plane: &Mesh<2>) -> bool {
    plane.blocks().iter().any(|b| b.kind == CellKind::Quad9)
}

/// The same mesh with a node in the centre of every quad8: its shape is a quad9's.
fn with_centres(mut plane: Mesh<2>) -> Mesh<2> {
    let mut shape = [0.0; MAX_CELL_NODES];
    CellKind::Quad8.shape(&Domain::Square.centre(), &mut shape);
    for block in &mut plane.blocks {
        if block.kind != CellKind::Quad8 {
            continue;
        }
        let mut nodes = Vec::new();
        for cell in block.cells() {
            let corners = cell.iter().zip(shape);
            let centre = corners.fold([0.0; 2], |sum, (&node, share)| {
                add_scaled(sum, share, plane.points[node as usize])
            });
            nodes.extend(cell);
            nodes.push(plane.points.len() as u32);
            plane.points.push(centre);
        }
        block.kind = CellKind::Quad9;
        block.nodes = nodes;
    }
    plane
}

/// The requested cells, cut from a mesh of hexahedra.
fn in_cells(mesh: Mesh<3>, cell: CellKind) -> Result<Mesh<3>, MeshError> {
    match cell.domain() {
        Domain::Tetrahedron => tetrahedra(&mesh),
        _ => Ok(mesh),
    }
}

/// The hexahedra that are, or are cut into, the requested cells, with the quadrilaterals from which they are made.
fn hexahedra(generator: &'static str, cell: CellKind) -> Result<(CellKind, CellKind), MeshError> {
    let need = "give tet4, tet10, hex8, hex20 or hex27; prisms come from `extrude` of triangles";
    plane_and_solid(cell)
        .filter(|(plane, _)| plane.corners() == 4)
        .ok_or_else(|| wrong(generator, "cell", cell.name().to_string(), need))
}

impl Extrude {
    /// The mesh: quad4, quad8, quad9, tri3, tri6 become hex8, hex20, hex27, prism6, prism15; beside a quad9, quad8 and tri6
    /// become hex27 and prism18. Where the axis of a turn touches the mesh, quadrilaterals with an edge on it become prisms, and a
    /// mesh of triangles alone becomes one of tetrahedra; sides on the axis go.
    ///
    /// Errors: a height that is zero or not finite, an angle that is not in (0°, 360°] or [−360°, 0°), an offset that is not finite, an
    /// axis that is not in the plane of the mesh, or goes through it, or touches a quadrilateral in one corner, no layers, layers of 180°
    /// and more, cells of different order, a side of the mesh that is called `first` or `last`.
    pub fn build(&self) -> Result<Mesh<3>, MeshError> {
        let wrong = |key, value: String, need| Err(wrong("extrude", key, value, need));
        let orders = self.mesh.blocks().iter().map(|block| block.kind.order());
        let order = orders.clone().min().unwrap_or(1);
        if orders.max() != Some(order) {
            let need = "its cells must all be linear, or all quadratic";
            return wrong("mesh", "cells of both orders".to_string(), need);
        }
        if self.layers == 0 {
            return wrong("layers", "0".to_string(), "use at least one layer");
        }
        if !self.offset.is_finite() {
            let need = "must be finite";
            return wrong("offset", self.offset.to_string(), need);
        }
        let share = |level: usize| level as f64 / (order * self.layers) as f64;
        match self.path {
            Path::Straight(height) => {
                let (foot, head) = (self.offset, self.offset + height);
                if !(height != 0.0 && head.is_finite()) {
                    let need = "must be finite and not zero";
                    return wrong("height", height.to_string(), need);
                }
                let at = |[x, y]: Point<2>, level| [x, y, between(foot, head, share(level))];
                self.carry(false, at, |mesh, edge| match mesh.curve(edge)? {
                    Surface::Sphere {
                        center: [x, y],
                        radius,
                    } => Some(Surface::Cylinder {
                        point: [x, y, 0.0],
                        axis: [0.0, 0.0, 1.0],
                        radius,
                    }),
                    _ => None,
                })
            }
            Path::Turn { point, axis, angle } => {
                let span = angle.abs();
                if !(span > 0.0 && (span <= 360.0 || is_full(span))) {
                    let need = "must be in (0, 360] degrees, or in [-360, 0)";
                    return wrong("angle", angle.to_string(), need);
                }
                if span / self.layers as f64 >= 180.0 {
                    let need = "so few layers that one spans 180 degrees: use more";
                    return wrong("layers", self.layers.to_string(), need);
                }
                let flat = |v: Point<3>| v[2].abs() <= 1e-12 * norm(v);
                let along = unit([axis[0], axis[1]]).filter(|_| flat(axis));
                let Some(along) = along.filter(|_| norm(point).is_finite()) else {
                    let value = format!("{axis:?}");
                    let need = "must lie in the plane of the mesh, z = 0";
                    return wrong("axis", value, need);
                };
                if point[2].abs() > 1e-12 * self.mesh.diameter() {
                    let need = "must lie in the plane of the mesh, z = 0";
                    return wrong("point", format!("{point:?}"), need);
                }
                self.turned([point[0], point[1]], along, angle, share)
            }
        }
    }

    /// The place of a point of the plane mesh at the beginning of the path.
    pub fn foot(&self, [x, y]: Point<2>) -> Point<3> {
        match self.path {
            Path::Straight(_) => [x, y, self.offset],
            Path::Turn { point, axis, .. } => {
                let along = unit([axis[0], axis[1]]).unwrap_or_default();
                turned([point[0], point[1]], along, [x, y], self.offset)
            }
        }
    }

    /// Around an axis in the plane, which the mesh lies beside.
    fn turned(
        &self,
        point: Point<2>,
        along: Point<2>,
        angle: f64,
        share: impl Fn(usize) -> f64,
    ) -> Result<Mesh<3>, MeshError> {
        let aside = [-along[1], along[0]];
        let from_axis = |x: Point<2>| dot(sub(x, point), aside);
        let distances = self.mesh.points().iter().map(|&x| from_axis(x));
        let (low, high) = distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| {
            (low.min(d), high.max(d))
        });
        let least = 1e-9 * self.mesh.diameter();
        if low < -least && high > least {
            let value = format!("through nodes from {low} to {high} beside it");
            let need = "the mesh must lie on one side of the axis, and may touch it";
            return Err(wrong("extrude", "axis", value, need));
        }
        let at = |x: Point<2>, level| turned(point, along, x, self.offset + angle * share(level));
        let near = |a: f64, b: f64| (a - b).abs() <= least;
        let over = |mesh: &Mesh<2>, edge: Facet| -> Option<Surface<3>> {
            let space = |[x, y]: Point<2>| [x, y, 0.0];
            match mesh.curve(edge) {
                // a circle about a point of the axis
                Some(Surface::Sphere { center, radius }) => {
                    near(from_axis(center), 0.0).then_some(Surface::Sphere {
                        center: space(center),
                        radius,
                    })
                }
                Some(_) => None,
                None => {
                    let ends: Vec<Point<2>> = mesh.facet_points(edge).collect();
                    let [first, second] = [ends[0], ends[1]];
                    let [dx, dy] = unit(sub(second, first))?;
                    let straight = |x: &Point<2>| near(dot([-dy, dx], sub(*x, first)), 0.0);
                    if !ends.iter().all(straight) {
                        return None;
                    }
                    let height = |x: Point<2>| dot(sub(x, point), along);
                    let [near_axis, far] = match from_axis(first).abs() < from_axis(second).abs() {
                        true => [first, second],
                        false => [second, first],
                    };
                    let wider = from_axis(far).abs() - from_axis(near_axis).abs();
                    let higher = height(far) - height(near_axis);
                    if near(wider, 0.0) {
                        return Some(Surface::Cylinder {
                            point: space(point),
                            axis: space(along),
                            radius: from_axis(first).abs(),
                        });
                    }
                    // a line across the axis makes a plane, exact in its facets
                    let apex = height(far) - from_axis(far).abs() * higher / wider;
                    (!near(higher, 0.0)).then(|| Surface::Cone {
                        apex: space(add_scaled(point, apex, along)),
                        axis: space(along.map(|c| c * higher.signum())),
                        half_angle: wider.atan2(higher.abs()),
                    })
                }
            }
        };
        let closed = is_full(angle.abs());
        if low <= least && high >= -least {
            let (full, centred) = self.centred();
            let plane = centred.as_ref().unwrap_or(&self.mesh);
            let on = plane.points().iter().map(|&x| near(from_axis(x), 0.0));
            let on: Vec<bool> = on.collect();
            return around_axis((plane, &on), full, (self.layers, closed), at, over);
        }
        self.carry(closed, at, over)
    }

    /// Whether cells have all nodes of their order, and the mesh in which they do, if it is another one.
    fn centred(&self) -> (bool, Option<Mesh<2>>) {
        let full = has_centres(&self.mesh);
        (full, full.then(|| with_centres(self.mesh.clone())))
    }

    fn carry(
        &self,
        closed: bool,
        at: impl Fn(Point<2>, usize) -> Point<3>,
        over: impl Fn(&Mesh<2>, Facet) -> Option<Surface<3>>,
    ) -> Result<Mesh<3>, MeshError> {
        let layers = (self.layers, closed);
        let centred = self.centred().1;
        let mesh = centred.as_ref().unwrap_or(&self.mesh);
        carry(mesh, false, layers, ["first", "last"], at, over)
    }
}

/// The image of a point of the plane, turned by some degrees around an axis in it: a point of that, and its direction of length one.
fn turned(point: Point<2>, along: Point<2>, x: Point<2>, degrees: f64) -> Point<3> {
    let aside = [-along[1], along[0]];
    let [cos, sin] = direction(degrees);
    let d = dot(sub(x, point), aside);
    let [x, y] = add_scaled(x, (cos - 1.0) * d, aside);
    [x, y, sin * d]
}

/// Images of the axes under the smallest rotation that takes z to a direction of length one.
fn frame(axis: Point<3>) -> [Point<3>; 3] {
    let [x, y, z] = axis;
    if z <= -1.0 {
        return [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], axis];
    }
    let s = 1.0 / (1.0 + z);
    [
        [1.0 - x * x * s, -x * y * s, -x],
        [-x * y * s, 1.0 - y * y * s, -y],
        axis,
    ]
}

impl Cylinder {
    /// The mesh.
    ///
    /// Errors: values that are not finite, an axis without length, radii that are not 0 ≤ `inner` < `radius`, a height that is
    /// not positive, an arc that is not in (0°, 360°], no cells or too many, too few around, an odd number around a full
    /// solid one, prisms.
    pub fn build(&self) -> Result<Mesh<3>, MeshError> {
        let wrong = |key, value: String, need| Err(wrong("cylinder", key, value, need));
        let (plane, _) = hexahedra("cylinder", self.cell)?;
        if !self.base.iter().all(|c| c.is_finite()) {
            let value = format!("{:?}", self.base);
            return wrong("base", value, "give finite coordinates");
        }
        let Some(axis) = unit(self.axis) else {
            let value = format!("{:?}", self.axis);
            return wrong("axis", value, "give a direction of finite length, not zero");
        };
        for (key, value) in [("radius", self.radius), ("height", self.height)] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(key, value.to_string(), "must be positive and finite");
            }
        }
        if !(self.inner >= 0.0 && self.inner < self.radius) {
            let need = "must be 0 for a solid cylinder, else less than `radius`";
            return wrong("inner", self.inner.to_string(), need);
        }
        let [around, through, along] = self.cells;
        if self.cells.contains(&0) {
            let need = "use at least one cell along each direction";
            return wrong("cells", format!("{:?}", self.cells), need);
        }
        let order = plane.order();
        within_reach(nodes(self.hexahedra(), order))?;
        let base = self.cross_section(plane, [around, through])?;
        let axes = frame(axis);
        let place = |[x, y]: Point<2>, level: usize| {
            let z = between(0.0, self.height, level as f64 / (order * along) as f64);
            let local = [x, y, z];
            (0..3).fold(self.base, |sum, d| add_scaled(sum, local[d], axes[d]))
        };
        let point = self.base;
        let surface = |mesh: &Mesh<2>, edge: Facet| {
            let sides = [("outer", self.radius), ("inner", self.inner)];
            let on = |(name, _): &(&str, f64)| mesh.side(name).is_some_and(|s| s.contains(&edge));
            let (_, radius) = sides.into_iter().find(on)?;
            Some(Surface::Cylinder {
                point,
                axis,
                radius,
            })
        };
        let mesh = carry(
            &base,
            true,
            (along, false),
            ["bottom", "top"],
            place,
            surface,
        )?;
        Ok(in_cells(mesh, self.cell)?.made_by(self.clone()))
    }

    /// Number of cells of the mesh.
    pub fn cell_count(&self) -> u128 {
        pieces(self.cell).saturating_mul(self.hexahedra())
    }

    /// Number of the hexahedra that cells are cut from.
    fn hexahedra(&self) -> u128 {
        let [around, through, along] = self.cells;
        let radii = (self.inner, self.radius);
        let section = count_around(radii, self.angles(), [around, through]);
        section.saturating_mul(along as u128)
    }

    fn angles(&self) -> [f64; 2] {
        self.angles.unwrap_or([0.0, 360.0])
    }

    fn cross_section(&self, cell: CellKind, cells: [usize; 2]) -> Result<Mesh<2>, MeshError> {
        let angles = self.angles();
        let span = angles[1] - angles[0];
        if !(span > 0.0 && (span <= 360.0 || is_full(span))) {
            let value = format!("{}, {}", angles[0], angles[1]);
            let need = "the arc `to` − `from` must be in (0, 360] degrees";
            return Err(wrong("cylinder", "from, to", value, need));
        }
        around("cylinder", (self.inner, self.radius), angles, cells, cell)
    }
}

/// About as many nodes as so many hexahedra have.
fn nodes(hexahedra: u128, order: usize) -> u128 {
    hexahedra.saturating_mul((order as u128).pow(3))
}

/// Cells of [`around`].
fn count_around((inner, radius): (f64, f64), angles: [f64; 2], cells: [usize; 2]) -> u128 {
    if inner != 0.0 {
        return cells.map(|n| n as u128).into_iter().product();
    }
    let disc = Disc {
        generator: "",
        radius,
        angles,
        cells,
        cell: CellKind::Quad4,
    };
    disc.cell_count()
}

/// A ring, or a disc where the inner radius is zero.
fn around(
    generator: &'static str,
    (inner, outer): (f64, f64),
    angles: [f64; 2],
    cells: [usize; 2],
    cell: CellKind,
) -> Result<Mesh<2>, MeshError> {
    if inner == 0.0 {
        let disc = Disc {
            generator,
            radius: outer,
            angles,
            cells,
            cell,
        };
        return disc.build();
    }
    if 0.5 * (angles[1] - angles[0]) / cells[0] as f64 >= 90.0 {
        let need = "so few cells around that one spans 180 degrees: use more";
        return Err(wrong(generator, "cells", format!("{cells:?}"), need));
    }
    let ring = Ring {
        center: [0.0; 2],
        inner,
        outer,
        angles: Some(angles),
        cells,
        ratio: 1.0,
        grade: 1.0,
        cell,
        diagonals: Diagonals::Forward,
    };
    ring.build()
}

/// Roundness of the core of a ball: between 0, a cube, and 1, a ball.
const ROUND: f64 = 0.5;

impl Sphere {
    /// The mesh.
    ///
    /// Errors: values that are not finite, radii that are not 0 ≤ `inner` < `radius`, polar angles that are not
    /// 0° ≤ from < to ≤ 180°, a solid part without a pole, no cells or too many, a number around that is not a multiple of 4
    /// where the cells make a core or a closed sphere, prisms.
    pub fn build(&self) -> Result<Mesh<3>, MeshError> {
        let wrong = |key, value: String, need| Err(wrong("sphere", key, value, need));
        let (plane, solid) = hexahedra("sphere", self.cell)?;
        let [from, to] = self.angles;
        if !self.center.iter().all(|c| c.is_finite()) {
            let value = format!("{:?}", self.center);
            return wrong("center", value, "give finite coordinates");
        }
        if !(self.radius > 0.0 && self.radius.is_finite()) {
            let need = "must be positive and finite";
            return wrong("radius", self.radius.to_string(), need);
        }
        if !(self.inner >= 0.0 && self.inner < self.radius) {
            let need = "must be 0 for a ball, else less than `radius`";
            return wrong("inner", self.inner.to_string(), need);
        }
        if !(from >= 0.0 && to <= 180.0 && from < to) {
            let need = "polar angles are counted from +z: 0 <= from < to <= 180 degrees";
            return wrong("from, to", format!("{from}, {to}"), need);
        }
        let [around, through] = self.cells;
        if around == 0 || through == 0 {
            let need = "use at least one cell along each direction";
            return wrong("cells", format!("{:?}", self.cells), need);
        }
        within_reach(nodes(self.hexahedra(), plane.order()))?;
        let poles = self.poles();
        let closed = poles == (true, true);
        if (self.inner == 0.0 || closed) && !around.is_multiple_of(4) {
            let need = "around a ball or closed shell use a multiple of 4";
            return wrong("cells", format!("{:?}", self.cells), need);
        }
        let mesh = match (self.inner == 0.0, poles) {
            (true, (false, false)) => {
                let need = "a solid part must reach a pole (from = 0 or to = 180): give `inner`";
                return wrong("from, to", format!("{from}, {to}"), need);
            }
            (true, _) => self.ball(solid, closed)?,
            (false, (true, true)) => self.closed_shell(solid)?,
            _ => self.shell(plane)?,
        };
        Ok(in_cells(mesh, self.cell)?.made_by(self.clone()))
    }

    /// Whether it reaches the lower and the upper end of polar angles.
    fn poles(&self) -> (bool, bool) {
        (self.angles[0] == 0.0, self.angles[1] == 180.0)
    }

    /// Number of cells of the mesh.
    pub fn cell_count(&self) -> u128 {
        pieces(self.cell).saturating_mul(self.hexahedra())
    }

    /// Number of the hexahedra that cells are cut from.
    fn hexahedra(&self) -> u128 {
        let closed = self.poles() == (true, true);
        let through = self.cells[1] as u128;
        if self.inner > 0.0 && !closed {
            let (polar, cells) = self.section();
            return count_around(polar, [0.0, 360.0], cells).saturating_mul(through);
        }
        let [nx, ny, nz] = self.cube_cells(closed).map(|n| n as u128);
        let ends = if closed { 2 } else { 1 };
        let faces = ends * nx * ny + 2 * (nx + ny) * nz;
        let core = if self.inner == 0.0 { nz } else { 0 };
        (nx * ny)
            .saturating_mul(core)
            .saturating_add(faces.saturating_mul(through))
    }

    /// Polar angles of a shell with a hole, counted from the pole that it reaches, if any, and its cells around and between them.
    fn section(&self) -> ((f64, f64), [usize; 2]) {
        let [from, to] = self.angles;
        let (low, high) = match to == 180.0 {
            true => (0.0, 180.0 - from),
            false => (from, to),
        };
        // the core of a cap at a pole covers an eighth of the turn
        let share = if low == 0.0 { 720.0 } else { 360.0 };
        let around = self.cells[0];
        let rows = (around as f64 * (high - low) / share).round() as usize;
        ((low, high), [around, rows.max(1)])
    }

    /// Cells of the cube (or half cube) whose image is the core.
    fn cube_cells(&self, closed: bool) -> [usize; 3] {
        let n = self.cells[0] / 4;
        let [from, to] = self.angles;
        let rows = (n as f64 * (to - from) / 180.0).round() as usize;
        [n, n, if closed { n } else { rows.max(1) }]
    }

    /// The point at a radius, from a direction in which the part with the pole +z has polar angles up to 90°.
    fn placed(&self, direction: Point<3>, radius: f64) -> Point<3> {
        let [from, to] = self.angles;
        let [x, y, z] = direction;
        let flat = x.hypot(y);
        if (from == 0.0 && to == 180.0) || flat == 0.0 {
            let z = if from > 0.0 { -z } else { z };
            return add_scaled(self.center, radius / norm([x, y, z]), [x, y, z]);
        }
        let polar = flat.atan2(z).to_degrees();
        let polar = match from == 0.0 {
            true => polar * to / 90.0,
            false => 180.0 - polar * (180.0 - from) / 90.0,
        };
        let [cos, sin] = crate::mesh::generate::direction(polar);
        add_scaled(self.center, radius, [sin * x / flat, sin * y / flat, cos])
    }

    /// A sphere as a surface for gaps and normals.
    fn surface(&self, radius: f64) -> Surface<3> {
        let center = self.center;
        Surface::Sphere { center, radius }
    }

    /// Polar angle as radius in the plane, spheres as layers.
    fn shell(&self, plane: CellKind) -> Result<Mesh<3>, MeshError> {
        let (to, through) = (self.angles[1], self.cells[1]);
        let (angles, cells) = self.section();
        let mut polar = around("sphere", angles, [0.0, 360.0], cells, plane)?;
        let order = plane.order();
        let place = |[x, y]: Point<2>, level: usize| {
            let radius = between(
                self.inner,
                self.radius,
                level as f64 / (order * through) as f64,
            );
            let flat = x.hypot(y);
            let angle = if to == 180.0 { 180.0 - flat } else { flat };
            let [cos, sin] = direction(angle);
            let across = if flat > 0.0 { sin / flat } else { 0.0 };
            add_scaled(self.center, radius, [across * x, across * y, cos])
        };
        let renamed = |(name, facets): (String, Vec<Facet>)| {
            let far = name == "outer" && to < 180.0;
            (if far { "end" } else { "start" }.to_string(), facets)
        };
        polar.sides = std::mem::take(&mut polar.sides)
            .into_iter()
            .map(renamed)
            .collect();
        let ends = ["inner", "outer"];
        let mesh = carry(&polar, true, (through, false), ends, place, |_, _| None)?;
        Ok(self.with_spheres(mesh))
    }

    /// The mesh with the spheres behind its sides.
    fn with_spheres(&self, mesh: Mesh<3>) -> Mesh<3> {
        mesh.with_curve(&["outer"], self.surface(self.radius))
            .with_curve(&["inner"], self.surface(self.inner))
    }

    /// A cube of one cell kind, q ∈ [−1, 1]³ or its half with qz ≥ 0.
    fn cube(&self, cell: CellKind, closed: bool) -> Result<Mesh<3>, MeshError> {
        let cube = Cuboid {
            from: [-1.0, -1.0, if closed { -1.0 } else { 0.0 }],
            to: [1.0; 3],
            cells: self.cube_cells(closed),
            cell,
        };
        cube.build()
    }

    /// Layers on faces of a cube: their blocks and the places of their nodes.
    fn grown(
        &self,
        cube: &Mesh<3>,
        faces: &[&str],
        keep: bool,
        point: impl Fn(Point<3>, f64) -> Point<3>,
    ) -> Result<Mesh<3>, MeshError> {
        let through = self.cells[1];
        let facets: Vec<Facet> = faces
            .iter()
            .filter_map(|face| cube.side(face))
            .flatten()
            .copied()
            .collect();
        let kind = cube.facet_kind(facets[0]);
        let mut places: BTreeMap<u32, u32> = BTreeMap::new();
        let mut of_cube = Vec::new();
        let mut nodes = Vec::new();
        for &facet in &facets {
            nodes.extend(cube.facet_nodes(facet).map(|node| {
                *places.entry(node).or_insert_with(|| {
                    of_cube.push(node);
                    of_cube.len() as u32 - 1
                })
            }));
        }
        let surface = [CellBlock {
            kind,
            nodes,
            group: None,
        }];
        let solid = cube.blocks()[0].kind;
        let levels = (kind.order() * through) as f64;
        let count = cube.points().len();
        within_reach(of_cube.len() as u128 * (levels as u128 + 1))?;
        let first = keep.then(|| (of_cube.clone(), count));
        let stack = Layers::new(&surface, vec![solid], of_cube.len(), through, false, first);
        let mut points: Vec<Point<3>> = match keep {
            true => cube.points().iter().map(|&q| point(q, 0.0)).collect(),
            false => Vec::new(),
        };
        stack.points(&mut points, |node, level| {
            point(cube.points()[of_cube[node] as usize], level as f64 / levels)
        });
        let mut block = stack.blocks().remove(0);
        let before = if keep { cube.cell_count() as u32 } else { 0 };
        if keep {
            let own = cube.blocks()[0].nodes.iter().copied();
            block.nodes = own.chain(block.nodes).collect();
        }
        let behind = |facets: Vec<Facet>| -> Vec<Facet> {
            let shifted = facets.into_iter().map(|f| Facet {
                cell: f.cell + before,
                ..f
            });
            shifted.collect()
        };
        let mut sides = BTreeMap::from([("outer".to_string(), behind(stack.ends(true)))]);
        if !keep {
            sides.insert("inner".to_string(), stack.ends(false));
        }
        Mesh::assembled(points, vec![block], sides, BTreeMap::new())
    }

    fn closed_shell(&self, solid: CellKind) -> Result<Mesh<3>, MeshError> {
        let cube = self.cube(solid, true)?;
        let mesh = self.grown(&cube, &FACES, false, |q, s| {
            self.placed(outwards(q), between(self.inner, self.radius, s))
        })?;
        Ok(self.with_spheres(mesh))
    }

    fn ball(&self, solid: CellKind, closed: bool) -> Result<Mesh<3>, MeshError> {
        let cube = self.cube(solid, closed)?;
        let faces = if closed { &FACES[..] } else { &FACES[..5] };
        // cells of the core and of the layers of about the same size
        let deep = self.cells[0] as f64 / 8.0;
        let share = (deep / (deep + self.cells[1] as f64)).clamp(0.3, 0.7);
        let half = share / 1.25;
        let core = |q: Point<3>| -> Point<3> {
            std::array::from_fn(|i| {
                let (a, b) = (q[(i + 1) % 3].powi(2), q[(i + 2) % 3].powi(2));
                let round = (1.0 - 0.5 * (a + b) + a * b / 3.0).sqrt();
                half * q[i] * ((1.0 - ROUND) + 1.25 * ROUND * round)
            })
        };
        let point = |q: Point<3>, s: f64| {
            if s == 1.0 {
                return self.placed(outwards(q), self.radius);
            }
            let (inner, outer) = (core(q), unit(outwards(q)).unwrap_or_default());
            let x = add_scaled(inner, s, sub(outer, inner));
            match norm(x) {
                0.0 => self.center,
                length => self.placed(x, self.radius * length),
            }
        };
        let mesh = self.grown(&cube, faces, true, point)?;
        let mesh = match closed {
            true => mesh,
            // the flat end of the half cube and of the layers over its edge
            false => self.with_end(mesh)?,
        };
        Ok(self.with_spheres(mesh))
    }

    /// The boundary apart from `outer` is the end of a part.
    fn with_end(&self, mesh: Mesh<3>) -> Result<Mesh<3>, MeshError> {
        let outer = mesh.side("outer").unwrap_or_default();
        let mut rest = mesh.boundary_facets();
        rest.retain(|facet| outer.binary_search(facet).is_err());
        let name = if self.angles[0] == 0.0 {
            "end"
        } else {
            "start"
        };
        mesh.with_sides(BTreeMap::from([(name.to_string(), rest)]))
    }
}

/// Faces of a cube, the lower one last.
const FACES: [&str; 6] = ["left", "right", "front", "back", "top", "bottom"];

/// The direction of a node of the surface of a cube q: equal angles along its edges and middles.
fn outwards(q: Point<3>) -> Point<3> {
    q.map(|c| (std::f64::consts::FRAC_PI_4 * c).tan())
}
