//! Picture "Section": the bodies cut by a plane through the middle of the contact that bears most, or through the largest
//! stress, coloured by the von Mises stress.
//!
//! A cell is the union of the cones from its centre to its facets, these are divided into triangles, so that every kind of
//! cell falls into tetrahedra by its data alone. Places and values are linear on each; a plane cuts a triangle or a
//! quadrilateral out of it. Neighbours divide their common facet alike, so that the pieces fit.

use crate::geometry::{Point, add_scaled, dot, norm, unit};
use crate::mesh::{CellKind, Facet, MAX_CELL_NODES, MAX_FACET_NODES, Mesh};
use crate::model::Solution;
use crate::output::deformed::{BAR, colour_bars, stress_scales};
use crate::output::html;
use crate::output::json::in_contact;
use crate::output::scene::WIDTH;
use crate::output::space::camera::{Camera, Window, beyond};
use crate::output::space::canvas::{Canvas, Corner, Paint, between};
use crate::output::space::scene::{HEAVY, PALE, Scene, triad_and_scale, windows};
use crate::output::space::skin::{Lattices, Look};
use crate::output::space::stress::{Scales, stress_values};
use crate::output::svg::Svg;
use crate::output::text::{Labels, quantity};

/// Room around the bodies.
const MARGIN: f64 = 12.0;

/// A plane keeps this part of the size away from the ends of the model.
const INSIDE: f64 = 0.02;

/// How far a plane is moved off nodes that lie on it, as a part of the size.
const OFF: f64 = 1e-6;

/// A plane across an axis, and why it is there.
struct Section {
    axis: usize,
    at: f64,
    why: String,
}

/// A point of a cell: its place and its value.
type Vertex = (Point<3>, f64);

/// The figure; nothing where there is no place to cut through.
pub fn section_figure(scene: &Scene<'_>, solution: &Solution<3>) -> Option<String> {
    let section = section(scene, solution)?;
    let labels = Labels::of(scene.model);
    // towards the viewer
    let sign = if section.axis == 1 { -1.0 } else { 1.0 };
    let normal: Point<3> = [0, 1, 2].map(|d| if d == section.axis { sign } else { 0.0 });
    let camera = match section.axis {
        0 => Camera::around(68.0, 20.0),
        1 => Camera::around(22.0, 20.0),
        _ => Camera::around(24.0, 58.0),
    };
    let on = normal.map(|n| n.abs() * section.at);
    // what is cut away needs no room: its nodes count at their places on the plane
    let left = scene.nodes().map(|p| {
        let ahead = beyond(p, (on, normal)).max(0.0);
        add_scaled(p, -ahead, normal)
    });
    let (windows, height) = windows(&[camera], &[camera.extent(left)], MARGIN, WIDTH - BAR);
    let window = windows.first()?;
    let mut svg = Svg::new(
        "section",
        "Section coloured by von Mises stress",
        WIDTH,
        height,
    );
    let scales = stress_scales(solution);
    let canvas = cut(scene, solution, window, (on, normal), &scales);
    svg.picture(window.corner, window.size, &canvas.png());
    triad_and_scale(&mut svg, window, &labels, "");
    colour_bars(&mut svg, solution, &scales, &labels, height - 40.0);
    let caption = format!(
        "The bodies, undeformed, behind the plane {} = {} through {}. Colour: von Mises stress.",
        ["x", "y", "z"][section.axis],
        quantity(section.at, &labels.length),
        section.why
    );
    Some(html::figure(&svg.finish(), "Section", &caption))
}

/// Across the axis that shows most, the normal of the contact in the plane.
fn section(scene: &Scene<'_>, solution: &Solution<3>) -> Option<Section> {
    let (place, normal, why) = contact_middle(solution).or_else(|| largest_stress(solution))?;
    let (low, high) = scene.bounds;
    let extent = [0, 1, 2].map(|d| high[d] - low[d]);
    let area = |axis: usize| extent[(axis + 1) % 3] * extent[(axis + 2) % 3];
    let worth = |axis: usize| area(axis) * (1.0 - normal[axis].abs()).max(0.05);
    // on equal terms the plane that faces the usual viewer
    let mut axis = 1;
    for other in [0, 2] {
        if worth(other) > 1.05 * worth(axis) {
            axis = other;
        }
    }
    let room = INSIDE * extent[axis];
    let at = place[axis].clamp(low[axis] + room, high[axis] - room);
    Some(Section { axis, at, why })
}

/// The centre of the pressure of the contact that bears most.
fn contact_middle(solution: &Solution<3>) -> Option<(Point<3>, Point<3>, String)> {
    let contacts = solution.contacts.iter();
    let loaded = contacts.filter(|c| c.nodes.iter().any(|n| in_contact(n.status)));
    let most = loaded.max_by(|a, b| norm(a.resultant).total_cmp(&norm(b.resultant)))?;
    let (mut force, mut sum, mut normal) = (0.0, [0.0; 3], [0.0; 3]);
    for node in &most.nodes {
        let own = (node.pressure * node.weight).abs();
        if own.is_finite() {
            force += own;
            sum = add_scaled(sum, own, node.point);
            normal = add_scaled(normal, own, node.normal);
        }
    }
    let normal = unit(normal).unwrap_or([0.0; 3]);
    let why = format!("the middle of the contact {}", most.name);
    (force > 0.0).then(|| (sum.map(|s| s / force), normal, why))
}

fn largest_stress(solution: &Solution<3>) -> Option<(Point<3>, Point<3>, String)> {
    let peaks = solution.bodies.iter().filter_map(|b| Some((b, b.peak?)));
    let (body, peak) = peaks.max_by(|a, b| a.1.most.value.total_cmp(&b.1.most.value))?;
    let why = format!("the largest stress, in {}", body.name);
    Some((peak.most.at, [0.0; 3], why))
}

fn cut(
    scene: &Scene<'_>,
    solution: &Solution<3>,
    window: &Window,
    (on, normal): (Point<3>, Point<3>),
    scales: &Scales,
) -> Canvas {
    let on = add_scaled(on, OFF * scene.size(), normal);
    let mut canvas = Canvas::new(window.size, &[PALE, HEAVY]);
    // the plane in places of the window
    let [origin, tip] = [on, add_scaled(on, 1.0 / window.scale, normal)].map(|p| window.place(p));
    let along = [0, 1, 2].map(|d| tip[d] - origin[d]);
    canvas.cut(Some((along, dot(along, origin))));
    for (body, skin) in scene.skins.iter().enumerate() {
        let mut look = Look::at(window, skin.mesh.points());
        look.values = stress_values(solution, scales, body);
        skin.fill(&mut canvas, &look, body, &|_| Paint::Scale);
    }
    canvas.cut(None);
    for (body, skin) in scene.skins.iter().enumerate() {
        let values = stress_values(solution, scales, body);
        let cells = Cells {
            mesh: skin.mesh,
            values: &values,
            plane: (on, normal),
        };
        cells.draw(&mut canvas, window, body);
        let mut lattices = Lattices::default();
        for &facet in &skin.facets {
            cells.facet_line(&mut lattices, facet, &mut |a, b| {
                canvas.line(window.place(a), window.place(b), 1);
            });
        }
    }
    canvas.cut(Some((along, dot(along, origin))));
    for skin in &scene.skins {
        let look = Look::at(window, skin.mesh.points());
        skin.outline(&mut canvas, window, &look, [Some(0), Some(1)]);
    }
    canvas
}

/// The cells of a body before a plane through a point with a normal.
struct Cells<'a> {
    mesh: &'a Mesh<3>,
    values: &'a [f64],
    plane: (Point<3>, Point<3>),
}

impl Cells<'_> {
    /// What the plane cuts out of them, with the edges of the cells.
    fn draw(&self, canvas: &mut Canvas, window: &Window, owner: usize) {
        let mut facets = Vec::new();
        self.pieces(&mut facets, &mut |piece| {
            let corners = piece.map(|(x, value)| Corner {
                at: window.place(x),
                shade: 1.0,
                value,
            });
            canvas.triangle(&corners, Paint::Scale, owner);
        });
        let mut lattices = Lattices::default();
        for facet in facets {
            self.facet_line(&mut lattices, facet, &mut |a, b| {
                canvas.line(window.place(a), window.place(b), 0);
            });
        }
    }

    /// The triangles in which the plane cuts the cells, and the facets of these.
    fn pieces(&self, facets: &mut Vec<Facet>, draw: &mut dyn FnMut([Vertex; 3])) {
        let mut lattices = Lattices::default();
        let points = self.mesh.points();
        for (block, cells) in self.mesh.blocks().iter().enumerate() {
            for (cell, nodes) in cells.cells().enumerate() {
                let sides = nodes
                    .iter()
                    .map(|&n| beyond(points[n as usize], self.plane) > 0.0);
                let ahead = sides.filter(|s| *s).count();
                if ahead == 0 || ahead == nodes.len() {
                    continue;
                }
                let centre = self.centre(cells.kind, nodes);
                for local in 0..cells.kind.facets().len() {
                    let [block, cell, local] = [block, cell, local].map(|i| i as u32);
                    let facet = Facet { block, cell, local };
                    for [a, b, c] in self.triangles(&mut lattices, facet) {
                        self.tetrahedron([centre, a, b, c], draw);
                    }
                    facets.push(facet);
                }
            }
        }
    }

    fn centre(&self, kind: CellKind, nodes: &[u32]) -> Vertex {
        let mut shape = [0.0; MAX_CELL_NODES];
        kind.shape(&kind.domain().centre(), &mut shape);
        let mut sum = ([0.0; 3], 0.0);
        for (&node, weight) in nodes.iter().zip(shape) {
            sum.0 = add_scaled(sum.0, weight, self.mesh.points()[node as usize]);
            sum.1 += weight * self.values[node as usize];
        }
        sum
    }

    /// A facet as triangles.
    fn triangles(&self, lattices: &mut Lattices, facet: Facet) -> Vec<[Vertex; 3]> {
        let kind = self.mesh.facet_kind(facet);
        let mut points = [[0.0; 3]; MAX_FACET_NODES];
        let mut values = [0.0; MAX_FACET_NODES];
        for (local, node) in self.mesh.facet_nodes(facet).enumerate() {
            points[local] = self.mesh.points()[node as usize];
            values[local] = self.values[node as usize];
        }
        let lattice = lattices.of(kind, if kind.order() == 1 { 1 } else { 3 });
        let vertex = |i: usize| (lattice.place(i, &points), lattice.value(i, &values));
        let triangles = lattice.triangles.iter();
        triangles.map(|corners| corners.map(vertex)).collect()
    }

    /// The lines in which the plane cuts a facet.
    fn facet_line(
        &self,
        lattices: &mut Lattices,
        facet: Facet,
        draw: &mut dyn FnMut(Point<3>, Point<3>),
    ) {
        let mut sides = self
            .mesh
            .facet_points(facet)
            .map(|p| beyond(p, self.plane) > 0.0);
        let first = sides.next();
        if sides.all(|s| Some(s) == first) {
            return;
        }
        for corners in self.triangles(lattices, facet) {
            let mut ends = Vec::with_capacity(2);
            for i in 0..3 {
                ends.extend(self.crossing(corners[i], corners[(i + 1) % 3]));
            }
            if let [a, b] = ends.as_slice() {
                draw(a.0, b.0);
            }
        }
    }

    /// Where the plane cuts an edge.
    fn crossing(&self, a: Vertex, b: Vertex) -> Option<Vertex> {
        let (s, t) = (beyond(a.0, self.plane), beyond(b.0, self.plane));
        ((s > 0.0) != (t > 0.0)).then(|| {
            let share = s / (s - t);
            (between(a.0, b.0, share), a.1 + share * (b.1 - a.1))
        })
    }

    /// The triangles in which the plane cuts a tetrahedron: none, one or two.
    fn tetrahedron(&self, corners: [Vertex; 4], draw: &mut dyn FnMut([Vertex; 3])) {
        let is_ahead = |v: &&Vertex| beyond(v.0, self.plane) > 0.0;
        let (ahead, behind): (Vec<&Vertex>, Vec<&Vertex>) = corners.iter().partition(is_ahead);
        // around the cut: neighbours share a corner
        let edges: &[[usize; 2]] = match ahead.len() {
            1 => &[[0, 0], [0, 1], [0, 2]],
            2 => &[[0, 0], [0, 1], [1, 1], [1, 0]],
            3 => &[[0, 0], [1, 0], [2, 0]],
            _ => return,
        };
        let cut = edges
            .iter()
            .filter_map(|&[i, j]| self.crossing(*ahead[i], *behind[j]));
        let cut: Vec<Vertex> = cut.collect();
        for k in 2..cut.len() {
            draw([cut[0], cut[k - 1], cut[k]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cross, sub};
    use crate::mesh::Cuboid;
    use crate::output::space::tests::cuboid;

    /// Area of the section of a unit cube, and the integral of the value over it.
    fn measure(cell: CellKind, plane: (Point<3>, Point<3>)) -> (f64, f64) {
        let mesh = cuboid([0.0; 3], [1.0; 3], [3, 4, 5], cell);
        let values: Vec<f64> = mesh.points().iter().map(|p| p[0] + 2.0 * p[2]).collect();
        let cells = Cells {
            mesh: &mesh,
            values: &values,
            plane,
        };
        let (mut area, mut integral) = (0.0, 0.0);
        cells.pieces(&mut Vec::new(), &mut |[a, b, c]| {
            let own = 0.5 * norm(cross(sub(b.0, a.0), sub(c.0, a.0)));
            area += own;
            integral += own * (a.1 + b.1 + c.1) / 3.0;
        });
        (area, integral)
    }

    #[test]
    fn sections_have_their_area_and_their_values() {
        for cell in CellKind::of_dimension(3) {
            let Ok(_) = Cuboid {
                from: [0.0; 3],
                to: [1.0; 3],
                cells: [1; 3],
                cell,
            }
            .build() else {
                continue;
            };
            let (area, integral) = measure(cell, ([0.4, 0.0, 0.0], [1.0, 0.0, 0.0]));
            assert!(
                (area - 1.0).abs() < 1e-12 && (integral - 1.4).abs() < 1e-12,
                "{cell:?}"
            );
            // the regular hexagon through the centre, across a diagonal: its edges are √½
            let third = 1.0 / 3f64.sqrt();
            let (area, integral) = measure(cell, ([0.5; 3], [third; 3]));
            let exact = 0.75 * 3f64.sqrt();
            assert!((area - exact).abs() < 1e-12, "{cell:?} {area}");
            assert!((integral - 1.5 * exact).abs() < 1e-12, "{cell:?}");
        }
    }
}
