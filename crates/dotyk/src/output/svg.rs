//! A drawing in SVG: y downward, in pixels at 96 dpi, one decimal.
//!
//! Every shape carries its own colours, so that a drawing looks the same inside the report and as a file of its own.

use crate::output::markup::{Markup, markup};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// A point of the drawing, in pixels.
pub type Pixel = [f64; 2];

/// A higher drawing may take more than a third of a sheet of paper.
const TALL: f64 = 700.0;

/// Text and axes.
pub const INK: &str = "#1d2733";
/// Secondary text.
pub const MUTED: &str = "#5a6672";
/// Grid lines and frames.
pub const RULE: &str = "#d5dbe1";
/// Supports.
pub const SUPPORT: &str = "#2f6b4f";
/// Bars.
pub const BAR: &str = "#5b3a8c";
/// Loads.
pub const LOAD: &str = "#1f5c99";
/// The part of an interface that is open.
pub const OPEN: &str = "#eef0f2";
/// The part of an interface that bears force.
pub const CLOSED: &str = "#fbe9e2";
/// Background of sticking parts of an interface.
pub const STICK: &str = "#e2eefb";
/// Background of slipping parts of an interface.
pub const SLIP: &str = "#fdf3d3";
/// Values out of limits.
pub const ALARM: &str = "#b3261e";
/// Colours of lines, distinguishable also without red–green vision (after Okabe and Ito).
pub const SERIES: [&str; 6] = [
    "#c2410c", "#0b6aa8", "#00795b", "#8a3d7c", "#8a6d00", "#3a4a5a",
];
/// Colours of positive and negative values.
pub const SIGNS: [&str; 2] = [SERIES[1], SERIES[0]];
/// Fills of bodies.
pub const TINTS: [&str; 6] = [
    "#d9e6f2", "#f4e7d1", "#dcecdf", "#ecdfec", "#f3eec7", "#e3e6ea",
];

/// Where a text is anchored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// At its start.
    Start,
    /// At its middle.
    Middle,
    /// At its end.
    End,
}

/// Style of a text.
#[derive(Debug, Clone, Copy)]
pub struct Type {
    /// Size in pixels.
    pub size: f64,
    /// Colour.
    pub colour: &'static str,
    /// Anchor.
    pub anchor: Anchor,
    /// Heavy.
    pub bold: bool,
    /// A white rim keeps it readable above lines.
    pub rim: bool,
}

impl Type {
    /// Ordinary label.
    pub const LABEL: Self = Self {
        size: 11.5,
        colour: INK,
        anchor: Anchor::Middle,
        bold: false,
        rim: false,
    };

    /// Numbers at axes, and remarks.
    pub const SMALL: Self = Self {
        size: 10.5,
        ..Self::LABEL
    };

    /// The same in another size.
    pub const fn sized(self, size: f64) -> Self {
        Self { size, ..self }
    }

    /// The same at another anchor.
    pub const fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same in another colour.
    pub const fn coloured(self, colour: &'static str) -> Self {
        Self { colour, ..self }
    }

    /// The same with a white rim.
    pub const fn rimmed(self) -> Self {
        Self { rim: true, ..self }
    }

    /// The same, heavy.
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
}

/// A drawing that grows.
pub struct Svg {
    width: f64,
    height: f64,
    description: String,
    body: Markup,
    clips: usize,
    id: String,
    /// Lower and upper corners of labels that give way to each other.
    labels: Vec<[Pixel; 2]>,
}

impl Svg {
    /// An empty drawing; `id` must be unique in its page, `description` is for readers who cannot see it.
    pub fn new(id: &str, description: &str, width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            description: description.to_string(),
            body: Markup::default(),
            clips: 0,
            id: id.to_string(),
            labels: Vec::new(),
        }
    }

    /// The drawing grows downward to this height.
    pub fn set_height(&mut self, height: f64) {
        self.height = height;
    }

    /// A straight line.
    pub fn line(&mut self, a: Pixel, b: Pixel, colour: &str, width: f64) {
        let path = segments(&[a, b], false);
        self.path(&path, colour, width, "none", "");
    }

    /// A path of SVG commands; `more` are further attributes.
    pub fn path(
        &mut self,
        commands: &str,
        stroke: &str,
        width: f64,
        fill: &str,
        more: &'static str,
    ) {
        if commands.is_empty() {
            return;
        }
        self.body += markup!("<path d=\"{}\" fill=\"{}\"", commands, fill);
        if stroke != "none" {
            self.body += markup!(" stroke=\"{}\" stroke-width=\"{}\"", stroke, short(width));
        }
        if !more.is_empty() {
            self.body += markup!(" {}", Markup::own(more));
        }
        self.body += markup!("/>\n");
    }

    /// A filled polygon.
    pub fn polygon(&mut self, points: &[Pixel], fill: &str) {
        self.path(&segments(points, true), "none", 0.0, fill, "");
    }

    /// An axis-parallel rectangle.
    pub fn rectangle(&mut self, corner: Pixel, size: Pixel, stroke: &str, fill: &str) {
        self.body += markup!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" stroke=\"{}\" fill=\"{}\"/>\n",
            short(corner[0]),
            short(corner[1]),
            short(size[0].max(0.0)),
            short(size[1].max(0.0)),
            stroke,
            fill
        );
    }

    /// A circle; `title` is shown while the pointer rests on it.
    pub fn circle(&mut self, center: Pixel, radius: f64, stroke: &str, fill: &str, title: &str) {
        self.body += markup!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" stroke=\"{}\" fill=\"{}\"",
            short(center[0]),
            short(center[1]),
            short(radius),
            stroke,
            fill
        );
        self.body += match title {
            "" => markup!("/>\n"),
            title => markup!("><title>{}</title></circle>\n", title),
        };
    }

    /// A dot of one of four shapes, white inside; `title` is shown while the pointer rests on it.
    pub fn dot(&mut self, at: Pixel, radius: f64, shape: usize, colour: &str, title: &str) {
        let r = radius;
        let corners: &[Pixel] = match shape % 4 {
            0 => return self.circle(at, r, colour, "#fff", title),
            1 => &[[-r, -r], [r, -r], [r, r], [-r, r]],
            2 => &[
                [0.0, -1.3 * r],
                [1.3 * r, 0.0],
                [0.0, 1.3 * r],
                [-1.3 * r, 0.0],
            ],
            _ => &[[0.0, -1.3 * r], [1.2 * r, r], [-1.2 * r, r]],
        };
        let corners: Vec<Pixel> = corners
            .iter()
            .map(|c| [at[0] + c[0], at[1] + c[1]])
            .collect();
        self.body += markup!(
            "<path d=\"{}\" stroke=\"{}\" fill=\"#fff\"><title>{}</title></path>\n",
            segments(&corners, true),
            colour,
            title
        );
    }

    /// A line of text with its baseline at `at`.
    pub fn text(&mut self, at: Pixel, text: &str, style: Type) {
        self.turned_text(at, text, style, 0.0);
    }

    /// Takes this place for a label, if no other label has a part of it.
    pub fn take(&mut self, [low, high]: [Pixel; 2]) -> bool {
        let apart =
            |other: &[Pixel; 2]| (0..2).any(|i| high[i] <= other[0][i] || low[i] >= other[1][i]);
        let free = self.labels.iter().all(apart);
        if free {
            self.labels.push([low, high]);
        }
        free
    }

    /// Text turned by `degrees` clockwise about its anchor.
    pub fn turned_text(&mut self, at: Pixel, text: &str, style: Type, degrees: f64) {
        let (x, y) = (short(at[0]), short(at[1]));
        self.body += markup!(
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\"",
            x,
            y,
            short(style.size),
            style.colour
        );
        self.body += match style.anchor {
            Anchor::Start => markup!(""),
            Anchor::Middle => markup!(" text-anchor=\"middle\""),
            Anchor::End => markup!(" text-anchor=\"end\""),
        };
        if style.bold {
            self.body += markup!(" font-weight=\"600\"");
        }
        if style.rim {
            self.body += markup!(
                " stroke=\"#fff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\""
            );
        }
        if degrees != 0.0 {
            self.body += markup!(" transform=\"rotate({} {} {})\"", short(degrees), x, y);
        }
        self.body += markup!(">{}</text>\n", text);
    }

    /// An arrow from `tail` to `tip`.
    pub fn arrow(&mut self, tail: Pixel, tip: Pixel, colour: &str, width: f64) {
        let along = [tip[0] - tail[0], tip[1] - tail[1]];
        let length = along[0].hypot(along[1]);
        if length < 0.5 {
            return;
        }
        let t = [along[0] / length, along[1] / length];
        let head = (4.0 + 1.6 * width).min(length);
        let half = 0.38 * head;
        let base = [tip[0] - head * t[0], tip[1] - head * t[1]];
        self.line(tail, base, colour, width);
        self.polygon(
            &[
                tip,
                [base[0] - half * t[1], base[1] + half * t[0]],
                [base[0] + half * t[1], base[1] - half * t[0]],
            ],
            colour,
        );
    }

    /// A PNG picture.
    pub fn picture(&mut self, corner: Pixel, size: Pixel, png: &[u8]) {
        self.body += markup!(
            "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" href=\"data:image/png;base64,{}\"/>\n",
            short(corner[0]),
            short(corner[1]),
            short(size[0]),
            short(size[1]),
            STANDARD.encode(png)
        );
    }

    /// Clips all further drawing to this rectangle, until [`Svg::end_clip`].
    pub fn begin_clip(&mut self, corner: Pixel, size: Pixel) {
        self.clips += 1;
        // the same drawing may stand in a page twice, in two widths
        let id = format!("{}-{}-clip{}", self.id, short(self.width), self.clips);
        self.body += markup!(
            "<clipPath id=\"{0}\"><rect x=\"{1}\" y=\"{2}\" width=\"{3}\" height=\"{4}\"/></clipPath>\n<g clip-path=\"url(#{0})\">\n",
            id,
            short(corner[0]),
            short(corner[1]),
            short(size[0]),
            short(size[1])
        );
    }

    /// Ends [`Svg::begin_clip`].
    pub fn end_clip(&mut self) {
        self.body += markup!("</g>\n");
    }

    /// The finished drawing, with the namespace that a file of its own needs.
    pub fn finish(self) -> Markup {
        markup!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\"{4} viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" \
             aria-label=\"{2}\" font-family=\"'Inter','Segoe UI',system-ui,-apple-system,'Helvetica Neue',Arial,sans-serif\">\n{3}</svg>\n",
            short(self.width),
            short(self.height),
            self.description,
            self.body,
            match self.height > TALL {
                true => markup!(" class=\"tall\""),
                false => Markup::default(),
            },
        )
    }
}

/// A pixel coordinate with one decimal (two below 2, for line widths).
pub fn short(value: f64) -> String {
    let text = if value.abs() < 2.0 {
        format!("{value:.2}")
    } else {
        format!("{value:.1}")
    };
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" | "" => "0".to_string(),
        other => other.to_string(),
    }
}

/// Path commands of straight segments through the points; points that are not finite lift the pen.
pub fn segments(points: &[Pixel], closed: bool) -> String {
    let mut out = String::new();
    let mut pen = false;
    for point in points {
        if !point.iter().all(|c| c.is_finite()) {
            pen = false;
            continue;
        }
        let _ = write!(
            out,
            "{}{} {}",
            if pen { 'L' } else { 'M' },
            short(point[0]),
            short(point[1])
        );
        pen = true;
    }
    if closed && !out.is_empty() {
        out.push('Z');
    }
    out
}

/// Rough width of a text in pixels in a wide typeface, for keeping labels apart.
pub fn text_width(text: &str, size: f64) -> f64 {
    let units: f64 = text
        .chars()
        .map(|c| match c {
            '\u{202f}' | '.' | ',' | 'i' | 'l' | ' ' => 0.32,
            '(' | ')' | 'r' | 't' | 'f' => 0.4,
            'm' | 'w' | 'M' | 'W' => 0.95,
            c if c.is_uppercase() => 0.72,
            _ => 0.62,
        })
        .sum();
    units * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        assert_eq!(short(12.04), "12");
        assert_eq!(short(-0.001), "0");
        assert_eq!(short(0.35), "0.35");
        assert_eq!(short(-100.0), "-100");
    }

    #[test]
    fn a_point_that_is_not_finite_lifts_the_pen() {
        let path = segments(
            &[
                [0.0, 0.0],
                [1.0, 0.0],
                [f64::NAN, 0.0],
                [3.0, 0.0],
                [4.0, 0.0],
            ],
            false,
        );
        assert_eq!(path, "M0 0L1 0M3 0L4 0");
    }
}
