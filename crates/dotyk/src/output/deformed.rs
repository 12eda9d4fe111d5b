//! Figure "Deformed shape": magnified displacements, coloured by the von Mises stress at the nodes.
//!
//! The colours are a small picture of 256 colours under vector lines, so that its size does not grow with the mesh.

use crate::geometry::{Point, norm, sub};
use crate::mesh::{CellKind, MAX_CELL_NODES, Mesh};
use crate::model::{BodySolution, Borders, Solution};
use crate::output::colour;
use crate::output::encode::png;
use crate::output::json::largest;
use crate::output::markup::Markup;
use crate::output::plot::{Axis, round_down_to_125};
use crate::output::points::draw_moved;
use crate::output::scene::{Scene, WIDTH, mesh_lines, outline_path, parabola};
use crate::output::svg::{Anchor, INK, MUTED, Pixel, Svg, Type, segments};
use crate::output::text::{Labels, number, quantity, vector};
use crate::output::view::{Margin, View, mark_detail, scale_bar};

/// Pixels of the picture per pixel of the drawing: crisp in print.
const FINE: f64 = 2.0;
/// The largest displacement is drawn as at most this part of the size.
pub const SHOWN: f64 = 0.05;
/// Bodies whose largest stresses differ by more than this factor have their own colour scales.
const SCALES_APART: f64 = 4.0;
/// A colour scale ends below the largest stress if it then is shorter than this part of it.
pub const CLEARLY: f64 = 0.8;
/// Room for a colour bar with its numbers.
pub const BAR: f64 = 92.0;

/// The figure as an SVG element, and its caption.
pub fn deformed_figure(scene: &Scene, solution: &Solution<2>) -> (Markup, String) {
    let labels = Labels::of(scene.model);
    let (views, height) = scene.views(Margin::all(26.0), 34.0, BAR);
    let mut svg = Svg::new(
        "deformed",
        "Deformed shape coloured by von Mises stress",
        WIDTH,
        height,
    );
    let scales = stress_scales(solution);
    let mut factors = Vec::new();
    for view in &views {
        let factor = magnification(scene, solution, view);
        factors.push(factor);
        draw_view(&mut svg, scene, solution, view, factor, &scales);
        scale_bar(&mut svg, view, &labels);
        let text = format!("displacements × {}", number(factor));
        let at = [
            view.corner[0] + view.size[0] - 6.0,
            view.corner[1] + view.size[1] + 23.0,
        ];
        let style = Type::SMALL.coloured(MUTED).anchored(Anchor::End);
        // Beside the scale bar there is room for it only in wide windows.
        if view.size[0] > 330.0 {
            svg.text(at, &text, style);
        }
    }
    if let [whole, detail] = views.as_slice() {
        mark_detail(&mut svg, whole, detail);
    }
    colour_bars(&mut svg, solution, &scales, &labels, height - 40.0);
    let mut list: Vec<String> = factors.iter().map(|&f| number(f)).collect();
    list.dedup();
    let caption = match list.as_slice() {
        [one] if one == "1" => "Displacements are drawn true to scale.".to_string(),
        [one] => format!("Displacements are magnified {one} times, initial gaps are not."),
        list => format!(
            "Displacements are magnified {} times (whole) and {} times (detail), initial gaps are not.",
            list[0],
            list.last().map_or("1", String::as_str)
        ),
    };
    (
        svg.finish(),
        caption + &beyond_the_scale(solution, &scales, &labels),
    )
}

/// Words on values beyond the last colour.
pub fn beyond_the_scale<const D: usize>(
    solution: &Solution<D>,
    scales: &[(Vec<usize>, f64)],
    labels: &Labels,
) -> String {
    let sentence = |(bodies, high): &(Vec<usize>, f64)| {
        let bodies = bodies.iter().map(|&i| &solution.bodies[i]);
        let peaks = bodies.filter_map(|body| Some((body, body.peak?)));
        let beyond = peaks.filter(|(_, peak)| peak.most.value > *high);
        let (body, peak) = beyond.max_by(|a, b| a.1.most.value.total_cmp(&b.1.most.value))?;
        let singular = peak.place?;
        Some(format!(
            " The colours end at {}, which {} % of {} does not exceed: its largest, {} at {}, is at {}, where the theory has no \
             finite stress.",
            quantity(*high, &labels.stress),
            // rounded down: never 100 %
            (1000.0 * singular.share).floor() / 10.0,
            body.name,
            quantity(peak.most.value, &labels.stress),
            vector(&peak.most.at, ""),
            singular.place,
        ))
    };
    scales.iter().filter_map(sentence).collect()
}

/// A round factor that makes the largest displacement in sight about 5 % of the window's size, never less than 1.
fn magnification(scene: &Scene, solution: &Solution<2>, view: &View) -> f64 {
    let mut most: f64 = 0.0;
    for (body, answer) in scene.model.bodies.iter().zip(&solution.bodies) {
        for (&point, &u) in body.mesh.points().iter().zip(answer.shown().iter()) {
            if view.sees(view.pixel(point)) {
                most = most.max(norm(u));
            }
        }
    }
    let extent = sub(view.high, view.low);
    let factor = SHOWN * extent[0].max(extent[1]) / most;
    if factor.is_finite() {
        round_down_to_125(factor).max(1.0)
    } else {
        1.0
    }
}

/// End of the colour scale of a body: its largest stress, or, if that is at a place where stresses are not finite, the usual one if
/// it is clearly less.
fn shown_stress<const D: usize>(body: &BodySolution<D>) -> f64 {
    let most = largest(body.von_mises.iter().copied().filter(|v| v.is_finite())).max(0.0);
    let Some(singular) = body.peak.and_then(|peak| peak.place) else {
        return most;
    };
    match singular.usual > 0.0 && singular.usual < CLEARLY * most {
        true => singular.usual,
        false => most,
    }
}

/// Groups of bodies that share a colour scale: the bodies' indices and the largest stress shown.
pub fn stress_scales<const D: usize>(solution: &Solution<D>) -> Vec<(Vec<usize>, f64)> {
    let most: Vec<f64> = solution.bodies.iter().map(shown_stress).collect();
    let high = largest(most.iter().copied());
    let low = most.iter().copied().fold(f64::INFINITY, f64::min);
    if most.len() <= 4 && low > 0.0 && high > SCALES_APART * low {
        return most
            .iter()
            .enumerate()
            .map(|(i, &m)| (vec![i], m))
            .collect();
    }
    vec![((0..most.len()).collect(), high)]
}

fn draw_view(
    svg: &mut Svg,
    scene: &Scene,
    solution: &Solution<2>,
    view: &View,
    factor: f64,
    scales: &[(Vec<usize>, f64)],
) {
    let mut canvas = Canvas::new(view);
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let u = solution.bodies[i].shown();
        let high = scales
            .iter()
            .find(|s| s.0.contains(&i))
            .map_or(1.0, |s| s.1);
        let places: Vec<Pixel> = body
            .mesh
            .points()
            .iter()
            .zip(u.iter())
            .map(|(p, u)| view.pixel([p[0] + factor * u[0], p[1] + factor * u[1]]))
            .collect();
        let BodySolution {
            borders, von_mises, ..
        } = &solution.bodies[i];
        canvas.mesh((&body.mesh, borders), &places, von_mises, high);
    }
    svg.begin_clip(view.corner, view.size);
    svg.picture(view.corner, view.size, &canvas.png());
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let points = body.mesh.points();
        let u = solution.bodies[i].shown();
        let moved = |n: usize| {
            view.pixel([
                points[n][0] + factor * u[n][0],
                points[n][1] + factor * u[n][1],
            ])
        };
        svg.path(
            &mesh_lines(&body.mesh, view, &moved),
            "#fff",
            0.4,
            "none",
            "stroke-opacity=\"0.45\"",
        );
        let original = outline_path(&scene.outlines[i], &|n| view.pixel(points[n]));
        svg.path(&original, "#fff", 1.6, "none", "stroke-opacity=\"0.55\"");
        svg.path(
            &original,
            "#4a545e",
            0.9,
            "none",
            "stroke-dasharray=\"4 3\"",
        );
        let outline = outline_path(&scene.outlines[i], &moved);
        svg.path(
            &outline,
            "#10161c",
            0.9,
            "none",
            "stroke-linejoin=\"round\"",
        );
    }
    draw_moved(svg, scene, solution, view, factor);
    svg.end_clip();
}

/// One bar per scale, at the right of the figure.
pub fn colour_bars<const D: usize>(
    svg: &mut Svg,
    solution: &Solution<D>,
    scales: &[(Vec<usize>, f64)],
    labels: &Labels,
    height: f64,
) {
    let bars = scales.len() as f64;
    let each = height / bars;
    let left = WIDTH - BAR + 18.0;
    for (k, (bodies, high)) in scales.iter().enumerate() {
        let top = 16.0 + each * k as f64;
        let axis = Axis::linear("Von Mises", &labels.stress, &[0.0, *high], true, 5);
        let small = Type::SMALL.anchored(Anchor::Start);
        let mut start = top + 4.0;
        if bodies.len() == 1 && scales.len() > 1 {
            svg.text(
                [left, start],
                &solution.bodies[bodies[0]].name,
                small.bold(),
            );
            start += 13.0;
        }
        for line in axis.label.split_inclusive("Mises ") {
            svg.text([left, start], line.trim(), small.coloured(MUTED));
            start += 13.0;
        }
        let peaks = bodies.iter().filter_map(|&i| solution.bodies[i].peak);
        let more = peaks.into_iter().any(|peak| peak.most.value > *high);
        colour_bar(svg, [left, start], top + each - 22.0 - start, &axis, more);
    }
}

/// A strip of the colours with the ticks of its axis, and its height; with a tip if values exceed its end.
pub fn colour_bar(svg: &mut Svg, [left, top]: Pixel, height: f64, axis: &Axis, more: bool) -> f64 {
    let strip: Vec<u8> = (0..colour::STEPS).rev().map(|i| 1 + i as u8).collect();
    let picture = png(1, colour::STEPS, &strip, &colour::palette());
    let size = [14.0, height.clamp(40.0, 260.0)];
    svg.picture([left, top], size, &picture);
    svg.rectangle([left, top], size, INK, "none");
    if more {
        // values beyond the end of the scale have a colour, too
        let tip = [[left, top], [left + 14.0, top], [left + 7.0, top - 9.0]];
        let end = colour::palette()[colour::STEPS];
        let fill = format!("#{:02x}{:02x}{:02x}", end[0], end[1], end[2]);
        svg.path(&segments(&tip, true), INK, 1.0, &fill, "");
    }
    for (value, text) in &axis.ticks {
        let y = top + (1.0 - axis.fraction(*value)) * size[1];
        svg.line([left + 14.0, y], [left + 18.0, y], INK, 0.8);
        let style = Type::SMALL.anchored(Anchor::Start);
        svg.text([left + 21.0, y + 3.6], text, style);
    }
    size[1]
}

/// A picture of palette indices that grows triangle by triangle.
pub struct Canvas {
    corner: Pixel,
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Canvas {
    /// An empty canvas for a view.
    pub fn new(view: &View) -> Self {
        let (width, height) = (
            (view.size[0] * FINE).ceil() as usize,
            (view.size[1] * FINE).ceil() as usize,
        );
        Self {
            corner: view.corner,
            width,
            height,
            pixels: vec![0; width * height],
        }
    }

    /// As a PNG file.
    pub fn png(&self) -> Vec<u8> {
        png(self.width, self.height, &self.pixels, &colour::palette())
    }

    /// All cells of a mesh with its nodes at `places`; `values` run from 0 to `high`, and places with NaN are not drawn.
    pub fn mesh(
        &mut self,
        (mesh, borders): (&Mesh<2>, &Borders),
        nodes: &[Pixel],
        values: &[f64],
        high: f64,
    ) {
        let high = if high > 0.0 { high } else { 1.0 };
        let vertex = |block: usize, n: u32| {
            let p = nodes[n as usize];
            let x = (p[0] - self.corner[0]) * FINE;
            let y = (p[1] - self.corner[1]) * FINE;
            ([x, y], values[borders.place(block, n as usize)] / high)
        };
        for corners in fans(mesh, &vertex) {
            self.triangle(corners);
        }
    }

    /// Linear colours over one triangle, clipped to the picture.
    fn triangle(&mut self, [a, b, c]: [Vertex; 3]) {
        let xs = [a.0[0], b.0[0], c.0[0]];
        let ys = [a.0[1], b.0[1], c.0[1]];
        let twice = (xs[1] - xs[0]) * (ys[2] - ys[0]) - (xs[2] - xs[0]) * (ys[1] - ys[0]);
        let known = [a, b, c].iter().all(|corner| !corner.1.is_nan());
        if !twice.is_finite() || twice.abs() <= 1e-12 || !known {
            return;
        }
        let span = |v: [f64; 3], size: usize| {
            let low = v[0].min(v[1]).min(v[2]).floor().max(0.0);
            let high = v[0].max(v[1]).max(v[2]).ceil().min(size as f64);
            low as usize..high.max(0.0) as usize
        };
        // A hair of overlap leaves no seams between neighbours.
        let hair = -1e-6;
        for row in span(ys, self.height) {
            let y = row as f64 + 0.5;
            for column in span(xs, self.width) {
                let x = column as f64 + 0.5;
                let wb = ((x - xs[0]) * (ys[2] - ys[0]) - (xs[2] - xs[0]) * (y - ys[0])) / twice;
                let wc = ((xs[1] - xs[0]) * (y - ys[0]) - (x - xs[0]) * (ys[1] - ys[0])) / twice;
                let wa = 1.0 - wb - wc;
                if wa >= hair && wb >= hair && wc >= hair {
                    let value = wa * a.1 + wb * b.1 + wc * c.1;
                    self.pixels[row * self.width + column] = colour::index(value);
                }
            }
        }
    }
}

/// Place and value.
pub type Vertex = ([f64; 2], f64);

/// All cells of a mesh as triangles, on which places and values are linear: those of a node for the cells of a block.
pub fn fans(mesh: &Mesh<2>, vertex: &dyn Fn(usize, u32) -> Vertex) -> Vec<[Vertex; 3]> {
    let (mut rim, mut fans) = (Vec::new(), Vec::new());
    for (index, block) in mesh.blocks().iter().enumerate() {
        for cell in block.cells() {
            rim.clear();
            let center = fan(block.kind, cell, &|node| vertex(index, node), &mut rim);
            for (i, &start) in rim.iter().enumerate() {
                fans.push([center, start, rim[(i + 1) % rim.len()]]);
            }
        }
    }
    fans
}

/// Rim of a cell (quadratic edges as four pieces) and its centre: a fan of triangles.
fn fan(
    kind: CellKind,
    cell: &[u32],
    vertex: &dyn Fn(u32) -> Vertex,
    rim: &mut Vec<Vertex>,
) -> Vertex {
    let corners = kind.corners();
    let quadratic = cell.len() > corners;
    for i in 0..corners {
        let a = vertex(cell[i]);
        rim.push(a);
        if quadratic {
            let (m, b) = (vertex(cell[corners + i]), vertex(cell[(i + 1) % corners]));
            for t in [0.25, 0.5, 0.75] {
                let value = parabola([a.1, 0.0], [m.1, 0.0], [b.1, 0.0], t)[0];
                rim.push((parabola(a.0, m.0, b.0, t), value));
            }
        }
    }
    let mut shape = [0.0; MAX_CELL_NODES];
    kind.shape(&kind.domain().centre(), &mut shape);
    let mut center: Vertex = ([0.0; 2], 0.0);
    for (&node, weight) in cell.iter().zip(shape) {
        let (p, value): (Point<2>, f64) = vertex(node);
        center.0[0] += weight * p[0];
        center.0[1] += weight * p[1];
        center.1 += weight * value;
    }
    center
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, Rectangle};
    use crate::output::tunnel;

    #[test]
    fn colours_fill_the_body_and_nothing_else() {
        let mesh = Rectangle {
            from: [0.0, 0.0],
            to: [20.0, 10.0],
            cells: [4, 2],
            cell: CellKind::Quad8,
            diagonals: Diagonals::default(),
        };
        let mesh = mesh.build().unwrap();
        let places: Vec<Pixel> = mesh.points().to_vec();
        let values: Vec<f64> = places.iter().map(|p| p[0]).collect();
        let (width, height) = (60, 40);
        let mut canvas = Canvas {
            corner: [0.0, 0.0],
            width,
            height,
            pixels: vec![0; width * height],
        };
        canvas.mesh((&mesh, &Borders::default()), &places, &values, 20.0);
        let inside = canvas.pixels.iter().filter(|&&p| p > 0).count();
        // 20 × 10 at two pixels each way.
        assert_eq!(inside, 40 * 20);
        assert!(canvas.pixels[0] < canvas.pixels[39]);
        assert_eq!(canvas.pixels[40], 0);
    }

    #[test]
    fn largest_displacement_is_drawn_as_about_five_per_cent() {
        let (model, solution) = tunnel::solved();
        let scene = Scene::new(&model);
        let (views, _) = scene.views(Margin::all(26.0), 34.0, BAR);
        let factor = magnification(&scene, &solution, &views[0]);
        let most = largest(solution.bodies.iter().map(BodySolution::max_displacement));
        let part = factor * most / 40.0;
        assert!(part <= SHOWN && part > 0.4 * SHOWN, "{part}");
    }

    #[test]
    fn very_different_stresses_get_their_own_scales() {
        let (_, mut solution) = tunnel::solved();
        assert_eq!(stress_scales(&solution).len(), 2);
        let rock = solution.bodies[1].von_mises.clone();
        solution.bodies[0].von_mises = rock;
        assert_eq!(stress_scales(&solution).len(), 1);
    }
}
