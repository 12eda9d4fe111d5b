//! Small plots beside and below each other, all against the same values.

use crate::output::markup::Markup;
use crate::output::plot::{Axis, Frame, Stroke, keys};
use crate::output::scene::PHONE;
use crate::output::svg::{Anchor, Svg, Type, text_width};
use crate::output::text::{number, with_unit};

/// Curves of more points than this are drawn without dots.
const MOST_DOTS: usize = 60;

/// A curve with its name.
pub struct Series {
    pub name: String,
    pub values: Vec<f64>,
}

/// One small plot.
pub struct Panel {
    pub title: String,
    pub unit: String,
    pub curves: Vec<Series>,
    /// Zero is in sight, however far away.
    pub zero: bool,
}

/// The common abscissae of all plots.
pub struct Abscissae<'a> {
    /// Its axis.
    pub axis: Axis,
    /// Values, as many as every curve has.
    pub values: &'a [f64],
    /// The text of a dot, by index and value.
    pub hint: &'a dyn Fn(usize, f64) -> String,
}

/// Height of one plot, with title, numbers and label.
const HEIGHT: f64 = 190.0;

/// Room for the numbers at the left of a plot.
const LEFT: f64 = 52.0;

/// Its title.
const TITLE: Type = Type::LABEL;

/// More plots than this stand three in a row, if their titles fit.
const MANY: usize = 6;

/// The plots as an SVG element: two or three in a row, on a phone one. The names of several curves stand once, above all.
pub fn panels_figure(
    id: &str,
    title: &str,
    panels: &[Panel],
    x: &Abscissae<'_>,
    width: f64,
) -> Markup {
    let title_fits = |panel: &Panel| {
        let label = with_unit(&panel.title, &panel.unit);
        text_width(&label, TITLE.size) < width / 3.0 - LEFT
    };
    let columns = match width > PHONE {
        true if panels.len() > MANY && panels.iter().all(title_fits) => 3,
        true => 2,
        false => 1,
    };
    let size = [width / columns as f64, HEIGHT];
    let mut svg = Svg::new(id, title, width, 0.0);
    let several = panels.iter().find(|panel| panel.curves.len() > 1);
    let top = several.map_or(0.0, |panel| {
        let names: Vec<&str> = panel
            .curves
            .iter()
            .map(|curve| curve.name.as_str())
            .collect();
        keys(&mut svg, [LEFT, width], &names)
    });
    svg.set_height(top + panels.len().div_ceil(columns) as f64 * HEIGHT);
    for (i, panel) in panels.iter().enumerate() {
        let [column, row] = [i % columns, i / columns].map(|place| place as f64);
        let corner = [column * size[0], top + row * HEIGHT];
        draw_panel(&mut svg, panel, x, corner, size);
    }
    svg.finish()
}

/// A title as far as there is room for it.
fn shortened(mut title: String, room: f64) -> String {
    // bold letters are wider
    let fits = |title: &str| 1.08 * text_width(title, TITLE.size) <= room;
    if fits(&title) {
        return title;
    }
    while !title.is_empty() && !fits(&format!("{title}…")) {
        title.pop();
    }
    title + "…"
}

fn draw_panel(
    svg: &mut Svg,
    panel: &Panel,
    x: &Abscissae<'_>,
    corner: [f64; 2],
    [width, height]: [f64; 2],
) {
    let values: Vec<f64> = panel.curves.iter().flat_map(|c| c.values.clone()).collect();
    let mut y = Axis::linear(&panel.title, &panel.unit, &values, panel.zero, 4).widened(0.08);
    let title = shortened(std::mem::take(&mut y.label), width - LEFT);
    let frame = Frame {
        corner: [corner[0] + LEFT, corner[1] + 22.0],
        size: [width - 70.0, height - 70.0],
        x: x.axis.clone(),
        y,
    };
    frame.draw(svg, true);
    let start = [frame.corner[0], frame.corner[1] - 8.0];
    svg.text(start, &title, TITLE.anchored(Anchor::Start).bold());
    for (k, curve) in panel.curves.iter().enumerate() {
        let stroke = Stroke::of(k, panel.curves.len());
        let each = x.values.iter().zip(&curve.values);
        let points: Vec<[f64; 2]> = each.map(|(&x, &v)| [x, v]).collect();
        frame.stroke(svg, &points, stroke);
        if points.len() <= MOST_DOTS {
            let seen = points.iter().enumerate().filter(|(_, p)| p[1].is_finite());
            for (i, p) in seen {
                let hint = format!("{}: {}", (x.hint)(i, p[0]), number(p[1]));
                stroke.dot(svg, frame.at(p[0], p[1]), &hint);
            }
        }
    }
}
