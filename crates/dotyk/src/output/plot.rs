//! Line plots: axes with round ticks, linear or logarithmic.

use crate::output::svg::{
    Anchor, INK, MUTED, Pixel, RULE, SERIES, Svg, Type, segments, short, text_width,
};
use crate::output::text::{superscript, with_unit};

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// The quantity, with its unit.
    pub label: String,
    /// First and last value.
    pub range: [f64; 2],
    /// Logarithmic.
    pub log: bool,
    /// Values and their texts.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// A linear axis over the values, with `zero` in sight if wanted; `most` ticks.
    ///
    /// A common power of ten moves into the label. Values that are not finite are skipped.
    pub fn linear(name: &str, unit: &str, values: &[f64], zero: bool, most: usize) -> Self {
        let (mut low, mut high) = finite_range(values.iter().copied());
        if zero {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        if low == 0.0 && high == 0.0 {
            // Only zeros: no other tick would be meaningful.
            return Self {
                label: with_unit(name, unit),
                range: [-1.0, 1.0],
                log: false,
                ticks: vec![(0.0, "0".to_string())],
            };
        }
        if high - low <= 1e-12 * high.abs().max(low.abs()) {
            let room = 0.5 * high.abs();
            (low, high) = (low - room, high + room);
        }
        let step = round_up_to_125((high - low) / most as f64);
        let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
        let exponent = shown_exponent(low.abs().max(high.abs()));
        let factor = 10f64.powi(exponent);
        let decimals = (-(step / factor).log10().floor()).max(0.0) as usize;
        let ticks = (first as i64..=last as i64)
            .map(|i| {
                let value = i as f64 * step;
                let text = format!("{:.decimals$}", value / factor + 0.0);
                (value, text.replace('-', "−"))
            })
            .collect();
        let unit = match (exponent, unit) {
            (0, unit) => unit.to_string(),
            (e, "") => format!("10{}", superscript(e)),
            (e, unit) => format!("10{}\u{202f}{unit}", superscript(e)),
        };
        Self {
            label: with_unit(name, &unit),
            range: [low, high],
            log: false,
            ticks,
        }
    }

    /// A linear axis that shows how the values change; one from zero where they hardly do.
    pub fn of_change(name: &str, unit: &str, values: &[f64], most: usize) -> Self {
        let (low, high) = finite_range(values.iter().copied());
        let hardly = high - low < HARDLY * high.abs().max(low.abs());
        Self::linear(name, unit, values, hardly, most)
    }

    /// The same axis with a fraction of its length added beyond its ends; an end at zero stays.
    pub fn widened(mut self, fraction: f64) -> Self {
        let room = fraction * (self.range[1] - self.range[0]);
        if self.range[0] != 0.0 {
            self.range[0] -= room;
        }
        if self.range[1] != 0.0 {
            self.range[1] += room;
        }
        self
    }

    /// The same axis with room at both ends, so that the first and last points are off the frame.
    pub fn roomy(mut self) -> Self {
        let room = 0.03 * (self.range[1] - self.range[0]);
        self.range = [self.range[0] - room, self.range[1] + room];
        self
    }

    /// An axis of whole numbers.
    pub fn counts(name: &str, values: &[f64], zero: bool, most: usize) -> Self {
        let mut axis = Self::linear(name, "", values, zero, most);
        axis.label = name.to_string();
        axis.ticks
            .retain(|(value, _)| (value - value.round()).abs() < 1e-6);
        for (value, text) in &mut axis.ticks {
            *text = crate::output::text::count(value.max(0.0).round() as usize);
        }
        axis
    }

    /// A logarithmic axis over the positive values.
    pub fn log(name: &str, values: &[f64]) -> Self {
        let (low, high) = finite_range(values.iter().copied().filter(|&v| v > 0.0));
        let (low, high) = if low > 0.0 && high > 0.0 {
            (low, high)
        } else {
            (0.1, 1.0)
        };
        // the quotient of two numbers may be none
        let [low, high] = [low, high].map(|value| value.clamp(LEAST, 1.0 / LEAST));
        // Room of a tenth of the span, at least of a factor 1.2, keeps points off the frame.
        let room = 10f64.powf(0.05 * (high.log10() - low.log10())).max(1.2);
        let (low, high) = (low / room, high * room);
        let decades = high.log10().floor() - low.log10().ceil();
        let every = (decades / 7.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for decade in low.log10().floor() as i32..=high.log10().ceil() as i32 {
            let multiples: &[i32] = if decades < 2.0 { &[1, 2, 5] } else { &[1] };
            for &m in multiples {
                let value = f64::from(m) * 10f64.powi(decade);
                if value >= low && value <= high && decade % every == 0 {
                    ticks.push((value, log_label(m, decade)));
                }
            }
        }
        Self {
            label: name.to_string(),
            range: [low, high],
            log: true,
            ticks,
        }
    }

    /// Place of a value along the axis, 0 to 1.
    pub fn fraction(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        if self.log {
            (value.ln() - low.ln()) / (high.ln() - low.ln())
        } else {
            (value - low) / (high - low)
        }
    }
}

/// Logarithmic axes end here, and at its inverse.
const LEAST: f64 = 1e-250;

/// Least and largest finite value; (0, 1) without any.
fn finite_range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

/// The least number of the form 1, 2, 5 × 10ⁿ that is not below a positive value.
pub fn round_up_to_125(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let mantissa = value / decade;
    // A power of ten may come out a rounding error above one.
    let round = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|m| mantissa <= m * (1.0 + 1e-9));
    round.unwrap_or(10.0) * decade
}

/// The largest number of the form 1, 2, 5 × 10ⁿ that is not above a positive value.
pub fn round_down_to_125(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let mantissa = value / decade;
    let round = [5.0, 2.0]
        .into_iter()
        .find(|m| mantissa >= m * (1.0 - 1e-9));
    round.unwrap_or(1.0) * decade
}

/// Power of a thousand that numbers of this size are shown with; 0 where plain digits read well.
fn shown_exponent(size: f64) -> i32 {
    if size == 0.0 || (1e-2..1e4).contains(&size) {
        return 0;
    }
    (size.log10() / 3.0).floor() as i32 * 3
}

fn log_label(multiple: i32, decade: i32) -> String {
    if (-2..=4).contains(&decade) {
        let value = f64::from(multiple) * 10f64.powi(decade);
        format!("{value:.*}", (-decade).max(0) as usize)
    } else if multiple == 1 {
        format!("10{}", superscript(decade))
    } else {
        format!("{multiple}·10{}", superscript(decade))
    }
}

/// Values that differ by a smaller part of them are drawn with an axis from zero: their differences may be rounding.
const HARDLY: f64 = 0.01;

/// How one of several curves is drawn: colour, dashes, width and dots all differ, so that a curve is seen beneath another one that
/// covers it, in grey, too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour of line and dots.
    pub colour: &'static str,
    dashes: &'static str,
    width: f64,
    shape: usize,
}

/// Dashes of curves in their order: those of a later one let the ones before it through.
const DASHES: [&str; SERIES.len()] = [
    "stroke-linejoin=\"round\"",
    "stroke-linejoin=\"round\" stroke-dasharray=\"9 4\"",
    "stroke-linejoin=\"round\" stroke-dasharray=\"2.5 3\"",
    "stroke-linejoin=\"round\" stroke-dasharray=\"12 3 2.5 3\"",
    "stroke-linejoin=\"round\" stroke-dasharray=\"5 5\"",
    "stroke-linejoin=\"round\" stroke-dasharray=\"1.5 5\"",
];

impl Stroke {
    /// That of the k-th of `count` curves; a single one is plain.
    pub fn of(k: usize, count: usize) -> Self {
        let k = k % SERIES.len();
        Self {
            colour: SERIES[k],
            dashes: DASHES[k],
            width: if count > 1 && k == 0 { 2.6 } else { 1.8 },
            shape: k,
        }
    }

    /// A dot of a curve; `title` is shown while the pointer rests on it. Later dots are smaller and stand within earlier ones.
    pub fn dot(self, svg: &mut Svg, at: Pixel, title: &str) {
        let radius = 3.2 - 0.25 * self.shape as f64;
        svg.dot(at, radius, self.shape, self.colour, title);
    }
}

/// Names of several curves with pieces of their lines, in rows from `left` to `right`; returns the height of all rows.
pub fn keys(svg: &mut Svg, [left, right]: [f64; 2], names: &[&str]) -> f64 {
    let (row, sample, between) = (17.0, 24.0, 14.0);
    let mut at = [left, 13.0];
    for (k, name) in names.iter().enumerate() {
        let stroke = Stroke::of(k, names.len());
        let width = sample + 5.0 + text_width(name, Type::LABEL.size);
        if at[0] > left && at[0] + width > right {
            at = [left, at[1] + row];
        }
        let y = at[1] - 4.0;
        let line = segments(&[[at[0], y], [at[0] + sample, y]], false);
        svg.path(&line, stroke.colour, stroke.width, "none", stroke.dashes);
        let style = Type::LABEL.anchored(Anchor::Start).coloured(stroke.colour);
        svg.text([at[0] + sample + 5.0, at[1]], name, style);
        at[0] += width + between;
    }
    at[1] + 8.0
}

/// A rectangle of a drawing with two axes.
pub struct Frame {
    /// Upper left corner.
    pub corner: Pixel,
    /// Width and height.
    pub size: Pixel,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis, upward.
    pub y: Axis,
}

impl Frame {
    /// Horizontal place of a value.
    pub fn across(&self, x: f64) -> f64 {
        self.corner[0] + self.x.fraction(x) * self.size[0]
    }

    /// Vertical place of a value.
    pub fn up(&self, y: f64) -> f64 {
        self.corner[1] + (1.0 - self.y.fraction(y)) * self.size[1]
    }

    /// Place of a point.
    pub fn at(&self, x: f64, y: f64) -> Pixel {
        [self.across(x), self.up(y)]
    }

    /// A vertical band between two abscissae.
    pub fn band(&self, svg: &mut Svg, from: f64, to: f64, fill: &str) {
        let (a, b) = (self.across(from), self.across(to));
        svg.rectangle([a, self.corner[1]], [b - a, self.size[1]], "none", fill);
    }

    /// Grid, ticks and labels; the numbers of the horizontal axis only where wanted.
    pub fn draw(&self, svg: &mut Svg, with_x_numbers: bool) {
        let [left, top] = self.corner;
        let (right, bottom) = (left + self.size[0], top + self.size[1]);
        let small = Type::SMALL.coloured(MUTED);
        for (value, text) in &self.x.ticks {
            let x = self.across(*value);
            svg.line([x, top], [x, bottom], RULE, 0.7);
            if with_x_numbers {
                svg.line([x, bottom], [x, bottom + 4.0], INK, 0.8);
                svg.text([x, bottom + 16.0], text, small);
            }
        }
        let mut widest: f64 = 0.0;
        for (value, text) in &self.y.ticks {
            let y = self.up(*value);
            svg.line([left, y], [right, y], RULE, 0.7);
            svg.line([left - 4.0, y], [left, y], INK, 0.8);
            svg.text([left - 7.0, y + 3.6], text, small.anchored(Anchor::End));
            widest = widest.max(text_width(text, 10.5));
        }
        svg.rectangle(self.corner, self.size, INK, "none");
        if with_x_numbers {
            svg.text(
                [(left + right) / 2.0, bottom + 33.0],
                &self.x.label,
                Type::LABEL,
            );
        }
        let at = [left - 15.0 - widest, (top + bottom) / 2.0];
        svg.turned_text(at, &self.y.label, Type::LABEL, -90.0);
    }

    /// A curve through points (x, y); values that are not finite interrupt it.
    pub fn curve(&self, svg: &mut Svg, points: &[[f64; 2]], colour: &str, width: f64) {
        let pixels: Vec<Pixel> = points.iter().map(|p| self.at(p[0], p[1])).collect();
        let path = segments(&pixels, false);
        svg.path(&path, colour, width, "none", "stroke-linejoin=\"round\"");
    }

    /// One of several curves, as [`Frame::curve`].
    pub fn stroke(&self, svg: &mut Svg, points: &[[f64; 2]], stroke: Stroke) {
        let pixels: Vec<Pixel> = points.iter().map(|p| self.at(p[0], p[1])).collect();
        let path = segments(&pixels, false);
        svg.path(&path, stroke.colour, stroke.width, "none", stroke.dashes);
    }

    /// A dashed horizontal line at a value.
    pub fn level(&self, svg: &mut Svg, y: f64, colour: &str) {
        let y = self.up(y);
        let path = format!(
            "M{} {}H{}",
            short(self.corner[0]),
            short(y),
            short(self.corner[0] + self.size[0])
        );
        svg.path(&path, colour, 1.0, "none", "stroke-dasharray=\"5 3\"");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_enclose_the_value() {
        for (value, down, up) in [
            (3.0, 2.0, 5.0),
            (1.0, 1.0, 1.0),
            (0.07, 0.05, 0.1),
            (700.0, 500.0, 1000.0),
        ] {
            assert!((round_down_to_125(value) / down - 1.0).abs() < 1e-12);
            assert!((round_up_to_125(value) / up - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn small_values_move_their_power_into_the_label() {
        let axis = Axis::linear("Gap", "m", &[0.0, 3.2e-6], true, 4);
        assert_eq!(axis.label, "Gap [10⁻⁶\u{202f}m]");
        assert_eq!(axis.ticks.last().unwrap().1, "3");
    }

    #[test]
    fn constant_and_missing_values_still_have_an_axis() {
        for values in [vec![2.0; 3], vec![0.0], vec![f64::NAN], vec![]] {
            let axis = Axis::linear("q", "", &values, false, 5);
            assert!(axis.range[0] < axis.range[1], "{values:?}");
            assert!(!axis.ticks.is_empty(), "{values:?}");
        }
        assert_eq!(
            Axis::linear("q", "", &[0.0; 3], true, 5).ticks,
            [(0.0, "0".to_string())]
        );
        assert!(Axis::log("r", &[f64::NAN, 0.0]).ticks.len() >= 2);
        // numbers whose quotient is none
        let wide = Axis::log("r", &[f64::MIN_POSITIVE, 1e-12, f64::MAX]);
        assert!((2..20).contains(&wide.ticks.len()), "{}", wide.ticks.len());
        assert!((0.3..0.7).contains(&wide.fraction(1.0)));
    }

    #[test]
    fn log_axis_is_linear_in_the_exponent() {
        let axis = Axis {
            label: String::new(),
            range: [1e-8, 1.0],
            log: true,
            ticks: Vec::new(),
        };
        assert!((axis.fraction(1e-4) - 0.5).abs() < 1e-12);
    }
}
