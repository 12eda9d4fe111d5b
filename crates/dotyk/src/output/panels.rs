//! Small plots beside and below each other, all against the same values.

use crate::output::markup::Markup;
use crate::output::plot::{Axis, Frame};
use crate::output::scene::WIDTH;
use crate::output::svg::{Anchor, SERIES, Svg, Type, text_width};
use crate::output::text::number;

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

/// Room for one plot, with title, numbers and label.
const PANEL: [f64; 2] = [WIDTH / 2.0, 190.0];

/// The plots, two in a row, as an SVG element. Where the names of the curves do not fit beside every title, they stand
/// once, above all.
pub fn panels_figure(id: &str, title: &str, panels: &[Panel], x: &Abscissae<'_>) -> Markup {
    let rows = panels.len().div_ceil(2);
    let beside = panels.iter().all(names_fit);
    let mut svg = Svg::new(id, title, WIDTH, 0.0);
    let top = match panels.first() {
        Some(panel) if !beside => legend(&mut svg, &names(panel)),
        _ => 0.0,
    };
    svg.set_height(top + rows as f64 * PANEL[1]);
    for (i, panel) in panels.iter().enumerate() {
        let corner = [(i % 2) as f64 * PANEL[0], top + (i / 2) as f64 * PANEL[1]];
        draw_panel(&mut svg, panel, x, corner, beside);
    }
    svg.finish()
}

/// From one name to the next.
const BETWEEN: f64 = 12.0;

fn names_fit(panel: &Panel) -> bool {
    let width = |text: &str| text_width(text, Type::LABEL.size) + BETWEEN;
    let names = panel.curves.iter().map(|curve| width(&curve.name));
    // the title is bold, and takes a power of ten and a unit
    let title = 1.1 * width(&panel.title) + 70.0;
    panel.curves.len() < 2 || title + names.sum::<f64>() < PANEL[0] - 70.0
}

fn names(panel: &Panel) -> Vec<&str> {
    let names = panel.curves.iter().map(|curve| curve.name.as_str());
    names.collect()
}

/// The names of curves in lines, each in its colour; returns the height of all.
pub fn legend(svg: &mut Svg, names: &[&str]) -> f64 {
    let [left, line] = [52.0, 18.0];
    let mut at = [left, 14.0];
    for (name, colour) in names.iter().zip(SERIES.iter().cycle()) {
        let width = text_width(name, Type::LABEL.size);
        if at[0] > left && at[0] + width > WIDTH - BETWEEN {
            at = [left, at[1] + line];
        }
        let style = Type::LABEL.anchored(Anchor::Start).coloured(colour);
        svg.text(at, name, style);
        at[0] += width + BETWEEN;
    }
    at[1] + line
}

fn draw_panel(svg: &mut Svg, panel: &Panel, x: &Abscissae<'_>, corner: [f64; 2], names: bool) {
    let values: Vec<f64> = panel.curves.iter().flat_map(|c| c.values.clone()).collect();
    let mut y = Axis::linear(&panel.title, &panel.unit, &values, panel.zero, 4).widened(0.08);
    let title = std::mem::take(&mut y.label);
    let frame = Frame {
        corner: [corner[0] + 52.0, corner[1] + 22.0],
        size: [PANEL[0] - 70.0, PANEL[1] - 70.0],
        x: x.axis.clone(),
        y,
    };
    frame.draw(svg, true);
    let start = [frame.corner[0], frame.corner[1] - 8.0];
    svg.text(start, &title, Type::LABEL.anchored(Anchor::Start).bold());
    let mut key = start[0] + text_width(&title, Type::LABEL.size) * 1.1 + 12.0;
    for (curve, colour) in panel.curves.iter().zip(SERIES.iter().cycle()) {
        let points: Vec<[f64; 2]> = x
            .values
            .iter()
            .zip(&curve.values)
            .map(|(&x, &v)| [x, v])
            .collect();
        frame.curve(svg, &points, colour, 1.8);
        if points.len() <= MOST_DOTS {
            let seen = points.iter().enumerate().filter(|(_, p)| p[1].is_finite());
            for (i, p) in seen {
                let hint = format!("{}: {}", (x.hint)(i, p[0]), number(p[1]));
                svg.circle(frame.at(p[0], p[1]), 2.8, colour, "#fff", &hint);
            }
        }
        if names && panel.curves.len() > 1 {
            let style = Type::LABEL.anchored(Anchor::Start).coloured(colour);
            svg.text([key, start[1]], &curve.name, style);
            key += text_width(&curve.name, style.size) + BETWEEN;
        }
    }
}
