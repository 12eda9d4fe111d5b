//! Picture "Section": the bodies cut by a plane through the middle of a contact, or through the largest stress, coloured by the
//! von Mises stress. Of the planes across the axes through the centres of pressure it is the one that shows most of the contacts
//! cut, by their forces; a contact that is small beside the model is drawn close-up, too.
//!
//! A cell is the union of the cones from its centre to its facets, these are divided into triangles, so that every kind of
//! cell falls into tetrahedra by its data alone. Places and values are linear on each; a plane cuts a triangle or a
//! quadrilateral out of it. Neighbours divide their common facet alike, so that the pieces fit.

use crate::geometry::{Point, add_scaled, bounding_box, dot, unit};
use crate::mesh::{Facet, MAX_CELL_NODES, MAX_FACET_NODES, Mesh};
use crate::model::{Borders, ContactNode, ContactSolution, Solution, Status};
use crate::output::html;
use crate::output::json::in_contact;
use crate::output::markup::Markup;
use crate::output::ranges::{BAR, Range, colour_bars, least_height, stress_ranges};
use crate::output::space::camera::{Camera, Window, beyond};
use crate::output::space::canvas::{Canvas, Corner, Paint, between};
use crate::output::space::scene::{HEAVY, PALE, Scene, triad_and_scale, windows};
use crate::output::space::skin::{Lattices, Look};
use crate::output::space::stress::stress_values;
use crate::output::svg::Svg;
use crate::output::text::{Labels, quantity};
use crate::output::view::Box2;
use rayon::prelude::*;

/// Room around the bodies.
const MARGIN: f64 = 12.0;

/// A plane keeps this part of the size away from the ends of the model.
const FROM_ENDS: f64 = 0.02;

/// How far a plane is moved off nodes that lie on it, as a part of the size.
const OFF: f64 = 1e-6;

/// A plane replaces another one only if it shows more by this factor.
const BETTER: f64 = 1.05;

/// A contact counts as cut through its middle if the plane passes the middle within this part of its half size.
const CUT: f64 = 0.8;

/// A contact smaller than this part of the model is drawn close-up, too.
const CLOSE: f64 = 0.2;

/// A plane across an axis, and the reason for it.
struct Section {
    axis: usize,
    at: f64,
    why: String,
    /// A box to be seen close-up.
    close: Option<(Point<3>, Point<3>)>,
}

/// A point of a cell: its place and its value.
type Vertex = (Point<3>, f64);

/// The figure; `None` without a place to cut through.
pub fn section_figure(scene: &Scene<'_>, solution: &Solution<3>) -> Option<Markup> {
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
    // the part cut away needs no room: its nodes count at their places on the plane
    let left = scene.nodes().map(|p| {
        let ahead = beyond(p, (on, normal)).max(0.0);
        add_scaled(p, -ahead, normal)
    });
    let close = section
        .close
        .map(|corners| camera.extent(on_plane(corners, section.axis, section.at)));
    let extents: Vec<Box2> = std::iter::once(camera.extent(left)).chain(close).collect();
    let cameras = vec![camera; extents.len()];
    let ranges = stress_ranges(scene.model, [solution]);
    let draw = |width: f64| {
        let (mut windows, height) = windows(&cameras, &extents, MARGIN, width - BAR);
        for window in windows.iter_mut().skip(1) {
            window.filled = true;
        }
        let height = height.max(least_height(&ranges) + 40.0);
        let title = "Section coloured by von Mises stress";
        let mut svg = Svg::new("section", title, width, height);
        let pictures = windows.par_iter();
        let pictures = pictures.map(|w| cut(scene, solution, w, (on, normal), &ranges).png());
        let pictures: Vec<Vec<u8>> = pictures.collect();
        for ((window, word), png) in windows.iter().zip(["", "close-up"]).zip(pictures) {
            svg.picture(window.corner, window.size, &png);
            triad_and_scale(&mut svg, window, &labels, word);
        }
        let size = [width, height - 40.0];
        colour_bars(&mut svg, solution, &ranges, &labels, size);
        svg.finish()
    };
    let caption = format!(
        "The bodies, undeformed, behind the plane {} = {} through {}. Colour: von Mises stress.",
        ["x", "y", "z"][section.axis],
        quantity(section.at, &labels.length),
        section.why
    );
    Some(html::fitted(&draw, "Section", &caption))
}

/// Corners of the side of a box that a plane across an axis cuts out of it.
fn on_plane(
    (low, high): (Point<3>, Point<3>),
    axis: usize,
    at: f64,
) -> impl Iterator<Item = Point<3>> {
    (0..8).map(move |k| {
        let mut corner = [0, 1, 2].map(|d| if k >> d & 1 == 0 { low[d] } else { high[d] });
        corner[axis] = at;
        corner
    })
}

/// Across the axis and through the contact that show most of the cut contacts; without closed contacts, through the largest
/// stress.
fn section(scene: &Scene<'_>, solution: &Solution<3>) -> Option<Section> {
    let middles: Vec<Middle> = solution.contacts.iter().filter_map(Middle::of).collect();
    let (low, high) = scene.bounds;
    let extent = [0, 1, 2].map(|d| high[d] - low[d]);
    let area = |axis: usize| extent[(axis + 1) % 3] * extent[(axis + 2) % 3];
    let stressed = largest_stress(solution);
    let places = middles.iter().map(|m| m.place);
    let places: Vec<Point<3>> = match middles.is_empty() {
        true => stressed.iter().map(|s| s.0).collect(),
        false => places.collect(),
    };
    let shown = |axis: usize, at: f64| match middles.is_empty() {
        true => area(axis),
        false => area(axis) * middles.iter().map(|m| m.shown(axis, at)).sum::<f64>(),
    };
    let mut best: Option<(usize, f64, f64)> = None;
    // on equal terms the plane that faces the usual viewer
    for axis in [1, 0, 2] {
        for place in &places {
            let own = shown(axis, place[axis]);
            if best.is_none_or(|(.., old)| own > BETTER * old) {
                best = Some((axis, place[axis], own));
            }
        }
    }
    let (axis, at, _) = best?;
    let cut = middles.iter().filter(|m| m.near(axis, at) > CUT);
    let most = cut.max_by(|a, b| a.force.total_cmp(&b.force));
    // a part of the closed area of a contact, or of the size of the model
    let room = FROM_ENDS * most.map_or(extent[axis], |m| 2.0 * m.reach[axis]);
    Some(Section {
        axis,
        at: at.clamp(low[axis] + room, high[axis] - room),
        why: most.map_or(stressed.map_or(String::new(), |s| s.1), Middle::why),
        close: most.and_then(|m| m.close(scene)),
    })
}

/// The middle of the forces of a contact.
struct Middle {
    name: String,
    /// Centre of its pressure.
    place: Point<3>,
    /// Half of the box around the closed nodes.
    reach: Point<3>,
    /// Mean unit normal, by force.
    normal: Point<3>,
    /// Sum of the normal forces.
    force: f64,
    /// Asymmetry of the forces about the middle along each axis: their skewness.
    skew: Point<3>,
    /// Corners of the box around the closed nodes.
    bounds: (Point<3>, Point<3>),
}

impl Middle {
    /// The middle of a closed contact; ties do not count.
    fn of(contact: &ContactSolution<3>) -> Option<Self> {
        let touches = |status: Status| in_contact(status) && status != Status::Tied;
        let touching = contact.nodes.iter().filter(|n| touches(n.status));
        let forces = touching.map(|n| (n, (n.pressure * n.weight).abs()));
        let forces: Vec<(&ContactNode<3>, f64)> = forces.filter(|f| f.1.is_finite()).collect();
        let force: f64 = forces.iter().map(|f| f.1).sum();
        if force == 0.0 {
            return None;
        }
        let mean = |of: &dyn Fn(&ContactNode<3>) -> Point<3>| {
            let parts = forces.iter();
            parts.fold([0.0; 3], |sum, (n, f)| add_scaled(sum, f / force, of(n)))
        };
        let place = mean(&|n| n.point);
        let moment = |power: i32| mean(&|n| [0, 1, 2].map(|d| (n.point[d] - place[d]).powi(power)));
        let (second, third) = (moment(2), moment(3));
        let points: Vec<Point<3>> = forces.iter().map(|(n, _)| n.point).collect();
        let bounds = bounding_box(&points);
        Some(Self {
            name: contact.name.clone(),
            place,
            reach: [0, 1, 2].map(|d| 0.5 * (bounds.1[d] - bounds.0[d])),
            normal: unit(mean(&|n| n.normal)).unwrap_or([0.0; 3]),
            force,
            skew: [0, 1, 2].map(|d| match second[d] > 0.0 {
                true => third[d] / second[d].powf(1.5),
                false => 0.0,
            }),
            bounds,
        })
    }

    /// Closeness of a plane across an axis to the middle: 1 through it, 0 beside the closed nodes.
    fn near(&self, axis: usize, at: f64) -> f64 {
        let off = (at - self.place[axis]).abs();
        match self.reach[axis] > 0.0 {
            true => (1.0 - off / self.reach[axis]).max(0.0),
            false => f64::from(u8::from(off == 0.0)),
        }
    }

    /// Merit of a plane for a cut contact: larger if the normal lies in the plane, and if the forces on both of its sides are
    /// alike, as about the axis of a bolt.
    fn shown(&self, axis: usize, at: f64) -> f64 {
        let across = (1.0 - self.normal[axis].abs()).max(0.05);
        let alike = (1.0 - self.skew[axis].abs()).max(0.2);
        self.force * across * alike * alike * self.near(axis, at)
    }

    fn why(&self) -> String {
        format!("the middle of the contact {}", self.name)
    }

    /// The box around the closed nodes with its surroundings, if it is small beside the model.
    fn close(&self, scene: &Scene<'_>) -> Option<(Point<3>, Point<3>)> {
        let (low, high) = self.bounds;
        let size = (0..3).map(|d| high[d] - low[d]).fold(0.0, f64::max);
        let small = size > 0.0 && size < CLOSE * scene.size();
        small.then(|| (low.map(|c| c - size), high.map(|c| c + size)))
    }
}

/// The place of the largest stress, and its description.
fn largest_stress(solution: &Solution<3>) -> Option<(Point<3>, String)> {
    let peaks = solution.bodies.iter().filter_map(|b| Some((b, b.peak?)));
    let (body, peak) = peaks.max_by(|a, b| a.1.most.value.total_cmp(&b.1.most.value))?;
    let why = format!("the largest stress, in {}", body.name);
    Some((peak.most.at, why))
}

fn cut(
    scene: &Scene<'_>,
    solution: &Solution<3>,
    window: &Window,
    (on, normal): (Point<3>, Point<3>),
    ranges: &[Range],
) -> Canvas {
    let on = add_scaled(on, OFF * scene.size(), normal);
    let mut canvas = Canvas::new(window.size, &[PALE, HEAVY]);
    // the plane in places of the window
    let [origin, tip] = [on, add_scaled(on, 1.0 / window.scale, normal)].map(|p| window.place(p));
    let along = [0, 1, 2].map(|d| tip[d] - origin[d]);
    canvas.cut(Some((along, dot(along, origin))));
    for (body, skin) in scene.skins.iter().enumerate() {
        let mut look = Look::at(window, skin.mesh.points());
        look.values = stress_values(solution, ranges, body);
        look.borders = solution.bodies[body].borders.clone();
        skin.fill(&mut canvas, &look, body, &|_| Paint::Scale);
    }
    canvas.cut(None);
    for (body, skin) in scene.skins.iter().enumerate() {
        let values = stress_values(solution, ranges, body);
        let cells = Cells {
            mesh: skin.mesh,
            values: &values,
            borders: &solution.bodies[body].borders,
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
    /// Places of the values.
    borders: &'a Borders,
    plane: (Point<3>, Point<3>),
}

impl Cells<'_> {
    /// The section of these cells with the plane, with the edges of the cells.
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
                let centre = self.centre(block, nodes);
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

    fn centre(&self, block: usize, nodes: &[u32]) -> Vertex {
        let kind = self.mesh.blocks()[block].kind;
        let mut shape = [0.0; MAX_CELL_NODES];
        kind.shape(&kind.domain().centre(), &mut shape);
        let mut sum = ([0.0; 3], 0.0);
        for (&node, weight) in nodes.iter().zip(shape) {
            sum.0 = add_scaled(sum.0, weight, self.mesh.points()[node as usize]);
            sum.1 += weight * self.values[self.borders.place(block, node as usize)];
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
            let block = facet.block as usize;
            values[local] = self.values[self.borders.place(block, node as usize)];
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
    use crate::geometry::{cross, norm, sub};
    use crate::mesh::{CellKind, Cuboid};
    use crate::model::Model;
    use crate::output::space::tests::{STEEL, cuboid, punch};

    /// Area of the section of a unit cube, and the integral of the value over it.
    fn measure(cell: CellKind, plane: (Point<3>, Point<3>)) -> (f64, f64) {
        let mesh = cuboid([0.0; 3], [1.0; 3], [3, 4, 5], cell);
        let values: Vec<f64> = mesh.points().iter().map(|p| p[0] + 2.0 * p[2]).collect();
        let cells = Cells {
            mesh: &mesh,
            values: &values,
            borders: &Borders::default(),
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

    /// A plate of 10 × 6 × 1 on which round washers of these radii press at these places.
    fn washers(places: &[([f64; 2], f64)]) -> Vec<ContactSolution<3>> {
        let (model, solution) = punch();
        let pattern = &solution.contacts[0];
        assert_eq!(model.contacts.len(), 1);
        let washer = |&([x, y], radius): &([f64; 2], f64)| {
            let nodes = (0..24).map(|k| {
                let (s, c) = (f64::from(k) * 15f64.to_radians()).sin_cos();
                ContactNode {
                    point: [x + radius * c, y + radius * s, 1.0],
                    normal: [0.0, 0.0, 1.0],
                    pressure: radius,
                    weight: 1.0,
                    ..pattern.nodes[0]
                }
            });
            ContactSolution {
                name: format!("washer at {x}"),
                nodes: nodes.collect(),
                ..pattern.clone()
            }
        };
        places.iter().map(washer).collect()
    }

    #[test]
    fn the_plane_goes_through_the_middles_of_the_contacts_that_bear_most() {
        let mut model = Model::new();
        let plate = cuboid([0.0; 3], [10.0, 6.0, 1.0], [5, 3, 1], CellKind::Hex8);
        model.body("plate", plate, STEEL);
        let (_, mut solution) = punch();
        let scene = Scene::new(&model);
        // two in a row along x beside a larger one: the row is the longer cut, and bears more
        for (places, axis, at, name) in [
            (
                vec![([2.0, 2.0], 0.6), ([7.0, 2.0], 0.7), ([5.0, 4.5], 1.0)],
                1,
                2.0,
                "washer at 7",
            ),
            (
                vec![([2.0, 2.0], 0.3), ([7.0, 4.5], 1.0)],
                1,
                4.5,
                "washer at 7",
            ),
            (
                vec![([3.0, 1.0], 1.0), ([3.0, 5.0], 1.0)],
                0,
                3.0,
                "washer at 3",
            ),
        ] {
            solution.contacts = washers(&places);
            let found = section(&scene, &solution).unwrap();
            assert_eq!(found.axis, axis, "{places:?}");
            assert!((found.at - at).abs() < 1e-9, "{places:?} {}", found.at);
            assert!(found.why.ends_with(name), "{}", found.why);
        }
    }
}
