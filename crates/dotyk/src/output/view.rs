//! Windows through which the figures show the bodies, and the labels at their edges.
//!
//! World coordinates have y upward, pixels have y downward.

use crate::geometry::{Point, sub};
use crate::output::plot::round_down_to_125;
use crate::output::svg::{Anchor, INK, MUTED, Pixel, Svg, Type, segments, text_width};
use crate::output::text::{Labels, quantity};

/// Room below them for axes and scale bar.
pub const STRIP: f64 = 34.0;

/// Lower and upper corner.
pub type Box2 = (Point<2>, Point<2>);

/// Room in pixels that a window keeps free around its bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// On the left.
    pub left: f64,
    /// On the right.
    pub right: f64,
    /// Above.
    pub top: f64,
    /// Below.
    pub bottom: f64,
}

impl Margin {
    /// The same on all sides.
    pub fn all(room: f64) -> Self {
        Self {
            left: room,
            right: room,
            top: room,
            bottom: room,
        }
    }
}

/// A window onto the bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Upper left corner of the window.
    pub corner: Pixel,
    /// Its size.
    pub size: Pixel,
    /// World box that it is meant to show.
    pub low: Point<2>,
    /// Upper corner of that box.
    pub high: Point<2>,
    /// Pixel of the middle of that box.
    pub middle: Pixel,
    /// Pixels per unit of length.
    pub scale: f64,
    /// It shows a part of the model, larger.
    pub detail: bool,
}

impl View {
    /// The box in the middle of a window, less the margins.
    pub fn fitted((low, high): Box2, corner: Pixel, size: Pixel, margin: Margin) -> Self {
        let room = [
            (size[0] - margin.left - margin.right).max(1.0),
            (size[1] - margin.top - margin.bottom).max(1.0),
        ];
        let extent = sub(high, low);
        let scale = (room[0] / extent[0]).min(room[1] / extent[1]);
        Self {
            corner,
            size,
            low,
            high,
            middle: [
                corner[0] + margin.left + 0.5 * room[0],
                corner[1] + margin.top + 0.5 * room[1],
            ],
            scale: if scale.is_finite() { scale } else { 1.0 },
            detail: false,
        }
    }

    /// Pixel of a point.
    pub fn pixel(&self, p: Point<2>) -> Pixel {
        let middle = [0, 1].map(|i| 0.5 * (self.low[i] + self.high[i]));
        [
            self.middle[0] + self.scale * (p[0] - middle[0]),
            self.middle[1] - self.scale * (p[1] - middle[1]),
        ]
    }

    /// A pixel lies inside the window.
    pub fn sees(&self, p: Pixel) -> bool {
        (0..2).all(|i| p[i] >= self.corner[i] && p[i] <= self.corner[i] + self.size[i])
    }
}

/// A direction of the world on paper, where y points down.
pub fn on_paper(d: Point<2>) -> Pixel {
    [d[0], -d[1]]
}

/// Ways by which a label gives way to others, across its line.
const AWAY: [f64; 5] = [0.0, 14.0, -14.0, 28.0, -28.0];

/// A label kept inside the window and off other labels; `upright` turns it by a quarter.
pub fn beside(
    svg: &mut Svg,
    view: &View,
    at: Pixel,
    text: &str,
    colour: &'static str,
    upright: bool,
) {
    if !view.sees(at) && view.detail {
        return;
    }
    let style = Type::LABEL.coloured(colour).rimmed();
    let half = 0.5 * text_width(text, style.size) + 2.0;
    let keep = |value: f64, axis: usize, room: f64| {
        let (low, high) = (
            view.corner[axis] + room,
            view.corner[axis] + view.size[axis] - room,
        );
        if low <= high {
            value.clamp(low, high)
        } else {
            0.5 * (low + high)
        }
    };
    let (across, along) = if upright { (0, 1) } else { (1, 0) };
    let mut place = at;
    for away in AWAY {
        place[across] = keep(at[across] + away, across, 9.0);
        place[along] = keep(at[along], along, half);
        let mut room = [half, half];
        room[across] = 6.5;
        let corners = [-1.0, 1.0].map(|sign| [0, 1].map(|i| place[i] + sign * room[i]));
        if svg.take(corners) {
            break;
        }
    }
    let [x, y] = place;
    match upright {
        true => svg.turned_text([x + 4.0, y], text, style, -90.0),
        false => svg.text([x, y + 4.0], text, style),
    }
}

/// Frame around the detail, and where it is in the whole.
pub fn mark_detail(svg: &mut Svg, whole: &View, detail: &View) {
    let (a, b) = (
        whole.pixel([detail.low[0], detail.high[1]]),
        whole.pixel([detail.high[0], detail.low[1]]),
    );
    let path = segments(&[a, [b[0], a[1]], b, [a[0], b[1]]], true);
    svg.path(&path, INK, 0.8, "none", "stroke-dasharray=\"3 2\"");
    let label = Type::SMALL.coloured(MUTED).rimmed();
    svg.text(
        [b[0] + 4.0, a[1] + 9.0],
        "detail",
        label.anchored(Anchor::Start),
    );
    let path = segments(
        &[
            detail.corner,
            [detail.corner[0] + detail.size[0], detail.corner[1]],
            [
                detail.corner[0] + detail.size[0],
                detail.corner[1] + detail.size[1],
            ],
            [detail.corner[0], detail.corner[1] + detail.size[1]],
        ],
        true,
    );
    svg.path(&path, MUTED, 0.8, "none", "stroke-dasharray=\"3 2\"");
}

/// Axes at the lower left, and a bar of round length.
pub fn scale_bar(svg: &mut Svg, view: &View, labels: &Labels) {
    let y = view.corner[1] + view.size[1] + STRIP - 14.0;
    let left = view.corner[0] + 8.0;
    let small = Type::SMALL.coloured(MUTED);
    let mut start = left;
    if !view.detail {
        let origin = [left + 2.0, y + 4.0];
        svg.arrow(origin, [origin[0] + 24.0, origin[1]], MUTED, 1.0);
        svg.arrow(origin, [origin[0], origin[1] - 24.0], MUTED, 1.0);
        svg.text([origin[0] + 30.0, origin[1] + 3.0], labels.axes[0], small);
        svg.text([origin[0] + 7.0, origin[1] - 19.0], labels.axes[1], small);
        start = left + 50.0;
    }
    let most = (0.3 * view.size[0]).min(140.0);
    let length = round_down_to_125(most / view.scale);
    let end = start + length * view.scale;
    let path = segments(
        &[
            [start, y - 3.0],
            [start, y + 3.0],
            [start, y],
            [end, y],
            [end, y - 3.0],
            [end, y + 3.0],
        ],
        false,
    );
    svg.path(&path, INK, 1.1, "none", "");
    svg.text(
        [end + 6.0, y + 3.8],
        &quantity(length, &labels.length),
        small.anchored(Anchor::Start),
    );
}
