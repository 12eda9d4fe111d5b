//! Pictures of friction on the nonmortar side of a contact in space: shear traction and slip, by colour and as arrows, with
//! the line between sticking and slipping parts.
//!
//! Signs: shear is the tangential traction ON the nonmortar body, slip its displacement relative to the other side since the
//! beginning. The lines are where states that are linear between the nodes, 1 and 0, are ½.

use crate::geometry::{Point, norm};
use crate::model::{Borders, ContactNode, ContactSolution, OnSide, Status};
use crate::output::html;
use crate::output::json::{in_contact, largest};
use crate::output::markup::Markup;
use crate::output::plot::Axis;
use crate::output::scene::WIDTH;
use crate::output::space::camera::{Window, faces};
use crate::output::space::canvas::{Canvas, Ink, Paint, between};
use crate::output::space::contact::{FOOT, HEAD, bar, columns, name_face, scaled, window_height};
use crate::output::space::face::Face;
use crate::output::space::marks::Squares;
use crate::output::space::scene::{GHOST, HEAVY, PALE, STRIP, Scene, triad_and_scale};
use crate::output::space::skin::Look;
use crate::output::space::thin::Surface;
use crate::output::svg::{INK, Svg};
use crate::output::text::Labels;
use rayon::prelude::*;

/// From one arrow to the next on paper, and the longest of them.
const SPACING: f64 = 26.0;
const ARROW: f64 = 23.0;

/// Arrows of less than this part of the largest are left out.
const LEAST_ARROW: f64 = 0.06;

/// Where contact ends.
const END: Ink = Ink {
    width: 1.6,
    depth: Some(2.5),
    ..HEAVY
};

/// Between stick and slip: white in a dark casing, to be seen on all colours.
const CASING: Ink = Ink { width: 3.6, ..END };
const BOUNDARY: Ink = Ink {
    colour: [0xff; 3],
    cover: 1.0,
    width: 1.8,
    ..END
};

/// A tangential vector at the nodes of a side.
struct Tangential {
    name: &'static str,
    unit: String,
    of: fn(&ContactNode<3>) -> Option<Point<3>>,
    /// Its length by node of the body; NaN where there is none.
    lengths: Vec<f64>,
}

/// The figure; `None` if no node sticks or slips.
pub fn friction_figure(
    scene: &Scene<'_>,
    contact: &ContactSolution<3>,
    sides: &[Face<'_>],
    index: usize,
) -> Option<Markup> {
    let rubs = |node: &ContactNode<3>| matches!(node.status, Status::Stick | Status::Slip);
    let face = sides.first()?;
    if !contact.nodes.iter().any(rubs) {
        return None;
    }
    let labels = Labels::of(scene.model);
    let name = |name, unit: &str, of| Tangential::new((name, unit), of, face, contact);
    let shown = [
        name("Shear", &labels.stress, |node| Some(node.shear)),
        // without contact there is motion, but no slip
        name("Slip", &labels.length, |node| {
            in_contact(node.status).then_some(node.slip)
        }),
    ];
    let lines = Lines::new(face, contact);
    let title = format!("Shear and slip on the nonmortar side of {}", contact.name);
    let mut svg = Svg::new(&format!("friction{index}"), &title, WIDTH, 0.0);
    let (width, left) = columns(shown.len());
    let height = window_height(face.view.extent, width);
    name_face(&mut svg, face, HEAD);
    let drawn = shown.par_iter().enumerate().map(|(column, vector)| {
        let window = face.window([left(column), HEAD], [width, height]);
        let canvas = draw(scene, face, &window, vector, &lines);
        let png = canvas.png();
        (window, canvas, png)
    });
    let drawn: Vec<(Window, Canvas, Vec<u8>)> = drawn.collect();
    let base = HEAD + height + STRIP + 4.0;
    for (vector, (window, canvas, png)) in shown.iter().zip(&drawn) {
        svg.picture(window.corner, window.size, png);
        svg.begin_clip(window.corner, window.size);
        arrows(&mut svg, window, canvas, vector, contact);
        svg.end_clip();
        let axis = Axis::linear(vector.name, &vector.unit, &[0.0, vector.most()], true, 4);
        bar(&mut svg, [window.corner[0], base], width, &axis);
    }
    triad_and_scale(&mut svg, &drawn[0].0, &labels, "");
    svg.set_height(base + FOOT);
    let body = &scene.model.bodies[face.body].name;
    let caption = format!(
        "Shear traction on {body}, and its slip relative to the other side where they touch. White line: between stick and \
         slip; dark line: end of what touches. Light grey: no value."
    );
    Some(html::figure(&svg.finish(), &title, &caption))
}

impl Tangential {
    fn new(
        (name, unit): (&'static str, &str),
        of: fn(&ContactNode<3>) -> Option<Point<3>>,
        face: &Face<'_>,
        contact: &ContactSolution<3>,
    ) -> Self {
        let length = |node: &ContactNode<3>| of(node).map_or(f64::NAN, norm);
        Self {
            name,
            unit: unit.to_string(),
            of,
            lengths: at_nodes(face, contact, length),
        }
    }

    fn most(&self) -> f64 {
        largest(self.lengths.iter().copied())
    }
}

/// A number by node of the body, linear between the corners; NaN off the side.
fn at_nodes(
    face: &Face<'_>,
    contact: &ContactSolution<3>,
    value: impl Fn(&ContactNode<3>) -> f64,
) -> Vec<f64> {
    let mesh = face.skin.mesh;
    let mut values = vec![f64::NAN; mesh.points().len()];
    for node in &contact.nodes {
        values[node.node] = value(node);
    }
    for place in OnSide::new(mesh, contact).between() {
        values[place.node] = place.mean(&value);
    }
    values
}

/// Pairs of places in space.
type Pieces = Vec<[Point<3>; 2]>;

/// Lines on a side.
struct Lines {
    /// Where contact ends.
    end: Pieces,
    /// Between stick and slip.
    boundary: Pieces,
}

impl Lines {
    fn new(face: &Face<'_>, contact: &ContactSolution<3>) -> Self {
        let triangles = Surface::of(&face.skin, &Borders::default()).triangles;
        let between = |state: &dyn Fn(Status) -> Option<bool>| {
            let part = |node: &ContactNode<3>| match state(node.status) {
                Some(is) => f64::from(u8::from(is)),
                None => f64::NAN,
            };
            halfway(face, &triangles, &at_nodes(face, contact, part))
        };
        Self {
            end: between(&|status| Some(in_contact(status))),
            boundary: between(&|status| match status {
                Status::Stick => Some(true),
                Status::Slip => Some(false),
                _ => None,
            }),
        }
    }
}

/// Where values that are linear on triangles are ½.
fn halfway(face: &Face<'_>, triangles: &[[u32; 3]], values: &[f64]) -> Pieces {
    let points = face.skin.mesh.points();
    let crossing = |[a, b]: [u32; 2]| {
        let [s, t] = [a, b].map(|n| values[n as usize] - 0.5);
        let crosses = s.is_finite() && t.is_finite() && (s > 0.0) != (t > 0.0);
        crosses.then(|| between(points[a as usize], points[b as usize], s / (s - t)))
    };
    let piece = |&[a, b, c]: &[u32; 3]| {
        let ends = [[a, b], [b, c], [c, a]].into_iter().filter_map(crossing);
        <[Point<3>; 2]>::try_from(ends.collect::<Vec<_>>()).ok()
    };
    triangles.iter().filter_map(piece).collect()
}

fn draw(
    scene: &Scene<'_>,
    face: &Face<'_>,
    window: &Window,
    vector: &Tangential,
    lines: &Lines,
) -> Canvas {
    let mut canvas = Canvas::new(window.size, &[GHOST, PALE, HEAVY, END, CASING, BOUNDARY]);
    let mut look = Look::at(window, face.skin.mesh.points());
    look.values = scaled(&vector.lengths, vector.most());
    face.skin.fill(&mut canvas, &look, 0, &|_| Paint::Scale);
    face.outline(&mut canvas, scene, window, &look);
    for (pieces, ink) in [(&lines.end, 3), (&lines.boundary, 4), (&lines.boundary, 5)] {
        for [a, b] in pieces {
            canvas.line(window.place(*a), window.place(*b), ink);
        }
    }
    canvas
}

/// Arrows centred at visible nodes, a fixed distance apart.
fn arrows(
    svg: &mut Svg,
    window: &Window,
    canvas: &Canvas,
    vector: &Tangential,
    contact: &ContactSolution<3>,
) {
    let mut squares = Squares::new(SPACING);
    for node in contact.nodes.iter().filter(|n| in_contact(n.status)) {
        let place = window.place(node.point);
        if faces(&window.camera, node.normal) && canvas.sees(place, 1.5) {
            squares.offer([place[0], place[1]], node);
        }
    }
    let most = vector.most();
    for node in squares.into_list() {
        let Some(value) = (vector.of)(node) else {
            continue;
        };
        let [x, y, _] = window.camera.turned(value);
        let half = [0.5 * ARROW * x / most, -0.5 * ARROW * y / most];
        let size = half[0].hypot(half[1]);
        // where all are zero there is no scale
        if size.is_nan() || size < 0.5 * ARROW * LEAST_ARROW {
            continue;
        }
        let at = window.pixel(node.point);
        let [tail, tip] = [-1.0, 1.0].map(|s| [at[0] + s * half[0], at[1] + s * half[1]]);
        svg.line(tail, tip, "#fff", 3.0);
        svg.arrow(tail, tip, INK, 1.2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::distance;
    use crate::output::space::face::faces as sides;
    use crate::output::space::tests::punch;

    #[test]
    fn the_line_between_states_runs_halfway_between_their_nodes() {
        let (model, solution) = punch();
        let scene = Scene::new(&model);
        let faces = sides(&scene, &solution.contacts[0]).unwrap();
        let triangles = Surface::of(&faces[0].skin, &Borders::default()).triangles;
        // the sole of the punch, two cells of ½ from 0.5 on: 0 on the left, 1 in the middle and beyond
        let points = model.bodies[faces[0].body].mesh.points();
        let values: Vec<f64> = points.iter().map(|p| f64::from(p[0] > 0.8)).collect();
        let pieces = halfway(&faces[0], &triangles, &values);
        let length: f64 = pieces.iter().map(|[a, b]| distance(*a, *b)).sum();
        assert!((length - 1.0).abs() < 1e-12, "{length}");
        assert!(
            pieces
                .as_flattened()
                .iter()
                .all(|p| (p[0] - 0.75).abs() < 1e-12)
        );
    }

    #[test]
    fn pictures_of_friction_are_drawn_where_there_is_friction() {
        let (model, mut solution) = punch();
        let scene = Scene::new(&model);
        let faces = sides(&scene, &solution.contacts[0]).unwrap();
        let drawn = friction_figure(&scene, &solution.contacts[0], &faces, 0).unwrap();
        assert!(drawn.contains("Shear and slip on the nonmortar side of sole"));
        for node in &mut solution.contacts[0].nodes {
            node.status = Status::Closed;
        }
        assert_eq!(
            friction_figure(&scene, &solution.contacts[0], &faces, 0),
            None
        );
    }
}
