//! Pictures of a result over the undeformed bodies, with the line where it reaches a limit; in space on their surface.

use crate::geometry::Point;
use crate::model::Solution;
use crate::output::deformed::{Canvas, Vertex, fans};
use crate::output::markup::Markup;
use crate::output::plot::Axis;
use crate::output::ranges::{BAR, colour_bar, name_bar};
use crate::output::scene::{Scene, outline_path};
use crate::output::svg::{ALARM, INK, Pixel, Svg, segments};
use crate::output::text::{Labels, number};
use crate::output::view::{Margin, View, beside, mark_detail, scale_bar};

/// A result, and how it is drawn.
pub struct Picture<const D: usize> {
    /// Of its element in the page.
    pub id: &'static str,
    pub title: &'static str,
    /// Beside the colours.
    pub label: &'static str,
    /// Of the place of the largest value.
    pub most_called: &'static str,
    /// By body at every place of stress; NaN without a value.
    pub values: Vec<Vec<f64>>,
    /// Where the colours end; they begin at zero.
    pub high: f64,
    /// Value on the line.
    pub limit: f64,
    /// The largest value and its node.
    pub most: Option<(Point<D>, f64)>,
    pub caption: String,
}

impl<const D: usize> Picture<D> {
    /// The colours with the limit, at the right of a figure of this size.
    pub fn bar(&self, svg: &mut Svg, [width, height]: Pixel) {
        let left = width - BAR + 18.0;
        let axis = Axis::linear(self.label, "", &[0.0, self.high], true, 5);
        let top = name_bar(svg, &axis, [left, 20.0]) + 9.0;
        let beyond = self.most.is_some_and(|(_, most)| most > self.high);
        let size = colour_bar(svg, [left, top], height - top - 22.0, &axis, beyond);
        let y = top + (1.0 - axis.fraction(self.limit)) * size;
        svg.line([left - 4.0, y], [left + 18.0, y], "#fff", 3.0);
        svg.line([left - 4.0, y], [left + 18.0, y], ALARM, 1.6);
    }
}

impl Picture<2> {
    /// The figure as an SVG element.
    pub fn in_plane(&self, scene: &Scene, solution: &Solution<2>, width: f64) -> Markup {
        let labels = Labels::of(scene.model);
        let (views, height) = scene.views(width - BAR, Margin::all(26.0), 34.0);
        let mut svg = Svg::new(self.id, self.title, width, height);
        for view in &views {
            self.draw_view(&mut svg, scene, solution, view);
            scale_bar(&mut svg, view, &labels);
        }
        if let [whole, detail] = views.as_slice() {
            mark_detail(&mut svg, whole, detail);
        }
        self.bar(&mut svg, [width, height - 40.0]);
        svg.finish()
    }

    fn draw_view(&self, svg: &mut Svg, scene: &Scene, solution: &Solution<2>, view: &View) {
        let mut canvas = Canvas::new(view);
        let mut limits = String::new();
        let bodies = scene.model.bodies.iter().zip(&solution.bodies);
        for ((body, answer), values) in bodies.zip(&self.values) {
            let places: Vec<Pixel> = body.mesh.points().iter().map(|&p| view.pixel(p)).collect();
            canvas.mesh((&body.mesh, &answer.borders), &places, values, self.high);
            let vertex = |block: usize, node: u32| {
                let node = node as usize;
                (places[node], values[answer.borders.place(block, node)])
            };
            let lines = fans(&body.mesh, &vertex).into_iter();
            let lines = lines.filter_map(|corners| crossing(corners, self.limit));
            let seen = lines.filter(|line| line.iter().any(|&end| view.sees(end)));
            limits.extend(seen.map(|line| segments(&line, false)));
        }
        svg.begin_clip(view.corner, view.size);
        svg.picture(view.corner, view.size, &canvas.png());
        for (body, strands) in scene.model.bodies.iter().zip(&scene.outlines) {
            let points: &[Point<2>] = body.mesh.points();
            let outline = outline_path(strands, &|n| view.pixel(points[n]));
            let round = "stroke-linejoin=\"round\"";
            svg.path(&outline, "#10161c", 0.9, "none", round);
        }
        if !limits.is_empty() {
            let round = "stroke-linecap=\"round\"";
            svg.path(&limits, "#fff", 3.2, "none", round);
            svg.path(&limits, ALARM, 1.6, "none", round);
        }
        svg.end_clip();
        if let Some((at, most)) = self.most {
            let at = view.pixel(at);
            if view.sees(at) {
                svg.circle(at, 4.0, INK, ALARM, self.most_called);
                let above = [at[0], at[1] - 12.0];
                beside(svg, view, above, &number(most), INK, false);
            }
        }
    }
}

/// The line across a triangle on which its values are at a limit.
fn crossing(corners: [Vertex; 3], limit: f64) -> Option<[Pixel; 2]> {
    let edges = (0..3).filter_map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        ((a.1 > limit) != (b.1 > limit)).then(|| {
            let part = (limit - a.1) / (b.1 - a.1);
            [0, 1].map(|d| a.0[d] + part * (b.0[d] - a.0[d]))
        })
    });
    let known = corners.iter().all(|corner| !corner.1.is_nan());
    let ends: Vec<Pixel> = edges.filter(|_| known).collect();
    ends.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_the_limit_crosses_where_linear_values_are_one() {
        let corners = [([0.0, 0.0], 0.0), ([10.0, 0.0], 2.0), ([0.0, 10.0], 0.0)];
        let mut ends = crossing(corners, 1.0).unwrap();
        ends.sort_by(|a, b| a[1].total_cmp(&b[1]));
        assert_eq!(ends, [[5.0, 0.0], [5.0, 5.0]]);
        assert!(crossing([corners[0], corners[1], ([0.0, 1.0], f64::NAN)], 1.0).is_none());
        assert!(crossing([corners[0], corners[2], ([1.0, 1.0], 1.0)], 1.0).is_none());
    }
}
