//! Pictures of a contact in space: pressure, gap and state on its faces alone, each seen from where it is open.

use crate::model::{ContactSolution, Solution, Status};
use crate::output::encode::png;
use crate::output::json::largest;
use crate::output::markup::Markup;
use crate::output::plot::Axis;
use crate::output::scene::WIDTH;
use crate::output::space::camera::Window;
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::face::{Face, faces};
use crate::output::space::friction::friction_figure;
use crate::output::space::scene::{GHOST, HEAVY, PALE, STRIP, Scene, THIN, triad_and_scale};
use crate::output::space::setup::rgb;
use crate::output::space::skin::Look;
use crate::output::svg::{Anchor, INK, MUTED, Svg, Type, text_width};
use crate::output::text::{Labels, count};
use crate::output::view::Box2;
use crate::output::{colour, html};
use rayon::prelude::*;

/// Room around the faces.
pub const MARGIN: f64 = 14.0;

/// Room above the windows for the names of the columns and below for their scales.
pub const HEAD: f64 = 22.0;
pub const FOOT: f64 = 48.0;

/// Room between columns.
const BETWEEN: f64 = 14.0;

/// Remark beside the name of a side that is shown in part.
const CUTOUT: &str = "cutout: what touches, with its surroundings";

/// Colours of the states.
const STATES: [(Status, &str); 6] = [
    (Status::Open, "#d9dfe5"),
    (Status::Closed, "#d7825a"),
    (Status::Stick, "#5b93cc"),
    (Status::Slip, "#e6b84a"),
    (Status::Tied, "#74a889"),
    (Status::Fixed, "#a08db8"),
];

/// Edges of cells on the colours of states.
const CELLS: Ink = Ink { cover: 0.3, ..THIN };

/// The figures of a contact; empty for a contact without nodes.
pub fn contact_figure(scene: &Scene<'_>, solution: &Solution<3>, index: usize) -> Option<Markup> {
    let contact = &solution.contacts[index];
    let faces = faces(scene, contact)?;
    let (states, friction) = rayon::join(
        || states_figure(scene, contact, &faces, index),
        || friction_figure(scene, contact, &faces, index),
    );
    Some(states + friction.unwrap_or_default())
}

/// Width and left ends of columns beside each other.
pub fn columns(count: usize) -> (f64, impl Fn(usize) -> f64) {
    let width = ((WIDTH - (count - 1) as f64 * BETWEEN) / count as f64).floor();
    (width, move |column| column as f64 * (width + BETWEEN))
}

/// Height of a window of this width onto an extent.
pub fn window_height((low, high): Box2, width: f64) -> f64 {
    let aspect = (high[0] - low[0]) / (high[1] - low[1]).max(f64::MIN_POSITIVE);
    (width / aspect.clamp(0.2, 5.0))
        .clamp(120.0, (0.85 * width).max(250.0))
        .floor()
}

fn states_figure(
    scene: &Scene<'_>,
    contact: &ContactSolution<3>,
    faces: &[Face<'_>],
    index: usize,
) -> Markup {
    let labels = Labels::of(scene.model);
    let (width, left) = columns(3);
    let title = format!("Pressure, gap and state on the faces of {}", contact.name);
    let mut svg = Svg::new(&format!("faces{index}"), &title, WIDTH, 0.0);
    let high = Highest {
        pressure: largest(contact.nodes.iter().map(|n| n.pressure)),
        gap: largest(faces.iter().map(|face| face.largest_in_sight(&face.gap))),
    };
    let mut top = HEAD;
    for face in faces {
        let height = window_height(face.view.extent, width);
        name_face(&mut svg, face, top);
        let columns = (0..3).into_par_iter().map(|column| {
            let window = face.window([left(column), top], [width, height]);
            let png = face.draw(scene, &window, column, &high).png();
            (window, png)
        });
        let columns: Vec<(Window, Vec<u8>)> = columns.collect();
        for (window, png) in &columns {
            svg.picture(window.corner, window.size, png);
        }
        triad_and_scale(&mut svg, &columns[0].0, &labels, "");
        top += height + STRIP + HEAD;
    }
    let base = top - HEAD + 4.0;
    let bars = [
        ("Pressure", &labels.stress, high.pressure),
        ("Gap", &labels.length, high.gap),
    ];
    for (column, (name, unit, high)) in bars.into_iter().enumerate() {
        let axis = Axis::linear(name, unit, &[0.0, high], true, 4);
        bar(&mut svg, [left(column), base], width, &axis);
    }
    states(&mut svg, [left(2), base], width, contact);
    svg.set_height(base + FOOT);
    let cutout = match faces.iter().any(|face| face.view.cutout) {
        true => {
            " Of a side that touches in a small part only this part is seen, with its surroundings."
        }
        false => "",
    };
    let caption = format!(
        "The faces alone, each seen from where it is open, the bodies as grey edges. Pressure is positive in compression, the \
         gap is that after deformation. The nonmortar side carries the values; the other side shows those of the nearest \
         point. Light grey: no value.{cutout}"
    );
    html::figure(&svg.finish(), &title, &caption)
}

/// Name of a face above its window.
pub fn name_face(svg: &mut Svg, face: &Face<'_>, top: f64) {
    let start = Type::SMALL.anchored(Anchor::Start);
    svg.text([0.0, top - 6.0], &face.title, start.bold());
    if face.view.cutout {
        // letters of this weight are wider
        let beside = 1.12 * text_width(&face.title, start.size) + 10.0;
        svg.text([beside, top - 6.0], CUTOUT, start.coloured(MUTED));
    }
}

/// Ends of the scales.
struct Highest {
    pressure: f64,
    gap: f64,
}

impl Face<'_> {
    /// A window onto the visible part of the side.
    pub fn window(&self, corner: [f64; 2], size: [f64; 2]) -> Window {
        let filled = self.view.cutout;
        let margin = if filled { 0.0 } else { MARGIN };
        let window = Window::fitted(self.view.camera, self.view.extent, corner, size, margin);
        Window { filled, ..window }
    }

    /// Pressure, gap or state, by the column.
    fn draw(&self, scene: &Scene<'_>, window: &Window, column: usize, high: &Highest) -> Canvas {
        let cells = if column == 2 { CELLS } else { PALE };
        let mut canvas = Canvas::new(window.size, &[GHOST, cells, HEAVY]);
        let mut look = Look::at(window, self.skin.mesh.points());
        if column == 2 {
            let colour = |node: u32| {
                let status = self.status[node as usize]?;
                let own = STATES.iter().find(|s| s.0 == status)?;
                Some(rgb(own.1))
            };
            self.skin.patches(&mut canvas, &look, 0, &colour);
        } else {
            look.values = match column {
                0 => scaled(&self.pressure, high.pressure),
                _ => scaled(&self.gap, high.gap),
            };
            self.skin.fill(&mut canvas, &look, 0, &|_| Paint::Scale);
        }
        self.outline(&mut canvas, scene, window, &look);
        canvas
    }

    /// Edges of the body with the first ink, of the cells of the side with the second, of the side with the third.
    pub fn outline(&self, canvas: &mut Canvas, scene: &Scene<'_>, window: &Window, look: &Look) {
        let body = &scene.skins[self.body];
        body.outline(canvas, window, look, [None, Some(0)]);
        self.skin.outline(canvas, window, look, [Some(1), Some(2)]);
    }
}

/// Values as parts of the largest one.
pub fn scaled(values: &[f64], high: f64) -> Vec<f64> {
    let high = if high > 0.0 { high } else { 1.0 };
    values.iter().map(|v| v / high).collect()
}

/// A lying colour bar with its name and numbers; in words where all values are zero.
pub fn bar(svg: &mut Svg, [left, top]: [f64; 2], width: f64, axis: &Axis) {
    let small = Type::SMALL.coloured(MUTED);
    if axis.range[0] < 0.0 {
        let text = format!("{}: 0 everywhere", axis.label);
        svg.text([left + 0.5 * width, top + 6.0], &text, small);
        return;
    }
    let strip: Vec<u8> = (0..colour::STEPS).map(|i| 1 + i as u8).collect();
    let picture = png(colour::STEPS, 1, &strip, &colour::palette());
    let room = 14.0;
    let (start, length) = (left + room, width - 2.0 * room);
    svg.text([left + 0.5 * width, top + 6.0], &axis.label, small);
    svg.picture([start, top + 12.0], [length, 11.0], &picture);
    svg.rectangle([start, top + 12.0], [length, 11.0], INK, "none");
    for (value, text) in &axis.ticks {
        let x = start + axis.fraction(*value) * length;
        svg.line([x, top + 23.0], [x, top + 27.0], INK, 0.8);
        svg.text([x, top + 37.0], text, Type::SMALL);
    }
}

/// Colours of the states that occur, with their numbers of nodes.
fn states(svg: &mut Svg, [left, top]: [f64; 2], width: f64, contact: &ContactSolution<3>) {
    let small = Type::SMALL;
    svg.text(
        [left + 0.5 * width, top + 6.0],
        "State",
        small.coloured(MUTED),
    );
    let (mut x, mut y) = (left + 4.0, top + 12.0);
    for (status, fill) in STATES {
        let nodes = contact.nodes.iter().filter(|n| n.status == status).count();
        if nodes == 0 {
            continue;
        }
        let text = format!("{} ({})", status.name(), count(nodes));
        let room = 18.0 + text_width(&text, small.size) + 10.0;
        if x > left + 4.0 && x + room > left + width {
            (x, y) = (left + 4.0, y + 16.0);
        }
        svg.rectangle([x, y], [13.0, 11.0], INK, fill);
        svg.text([x + 18.0, y + 9.0], &text, small.anchored(Anchor::Start));
        x += room;
    }
}
