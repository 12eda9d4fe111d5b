//! Figure "Deformed shape": magnified displacements, coloured by the von Mises stress at the nodes.
//!
//! The colours are a small picture of 256 colours under vector lines, so that its size does not grow with the mesh.

use crate::geometry::{Point, add_scaled, bounding_box, distance, norm, sub};
use crate::mesh::{CellKind, MAX_CELL_NODES, Mesh};
use crate::model::{BodySolution, Borders, Model, Solution};
use crate::output::colour;
use crate::output::encode::png;
use crate::output::html::fitted;
use crate::output::markup::Markup;
use crate::output::plot::round_down_to_125;
use crate::output::points::draw_moved;
use crate::output::ranges::{
    BAR, Range, colour_bars, end_for, in_words, least_height, stress_ranges,
};
use crate::output::scene::{PHONE, Scene, WIDTH, mesh_lines, outline_path, parabola};
use crate::output::svg::{Anchor, INK, MUTED, Pixel, Svg, Type};
use crate::output::text::{Labels, number, quantity, vector};
use crate::output::view::{Box2, Margin, STRIP, View, beside, mark_detail, scale_bar};

/// Pixels of the picture per pixel of the drawing: crisp in print.
const FINE: f64 = 2.0;
/// The largest displacement is drawn as at most this part of the size.
pub const SHOWN: f64 = 0.05;
/// Where the stress falls to a half within this part of the model, its place is drawn once more, larger.
const CLOSE: f64 = 0.04;

/// The deformed shape of a solution, and a window to its largest stress where that is a small place.
pub fn deformed_figures(scene: &Scene, solution: &Solution<2>) -> Markup {
    let labels = Labels::of(scene.model);
    let ranges = stress_ranges(scene.model, [solution]);
    let (windows, _) = windows(scene, solution, WIDTH);
    let mut list: Vec<String> = windows.iter().map(|(_, factor)| number(*factor)).collect();
    list.dedup();
    let magnified = match list.as_slice() {
        [one] if one == "1" => "Displacements are drawn true to scale.".to_string(),
        [one] => format!("Displacements are magnified {one} times, initial gaps are not."),
        list => format!(
            "Displacements are magnified {} times (whole) and {} times (detail), initial gaps are not.",
            list[0],
            list.last().map_or("1", String::as_str)
        ),
    };
    let caption = format!(
        "{magnified}{} Dashed: undeformed outline. Colour: von Mises stress, recovered at the nodes.",
        in_words(solution, &ranges, &labels)
    );
    let draw = |width| deformed_figure(scene, solution, &ranges, width);
    let shape = fitted(&draw, "Deformed shape", &caption);
    let views: Vec<View> = windows.into_iter().map(|(view, _)| view).collect();
    let Some((body, centre, reach)) = close_up(scene, solution, &views) else {
        return shape;
    };
    let draw = |width| close_figure(scene, solution, &ranges, (centre, reach), width);
    let caption = format!(
        "Undeformed, around {} in {}, where the von Mises stress is largest.",
        vector(&centre, &labels.length),
        scene.model.bodies[body].name
    );
    shape + fitted(&draw, "The largest stress", &caption)
}

/// Windows of the figure, beside its colour bars, each with its magnification; the whole has room for what moves.
fn windows(scene: &Scene, solution: &Solution<2>, width: f64) -> (Vec<(View, f64)>, f64) {
    let margin = Margin::all(16.0);
    let (still, _) = scene.views(width - BAR, margin, STRIP);
    let whole = magnification(scene, solution, &still[0]);
    let bounds = moved_bounds(scene, solution, whole);
    let (views, height) = scene.views_of(bounds, width - BAR, margin, STRIP);
    let with_factor = views.into_iter().map(|view| match view.detail {
        true => (view.clone(), magnification(scene, solution, &view)),
        false => (view, whole),
    });
    (with_factor.collect(), height)
}

/// Box around everything, where it was and where it is drawn.
fn moved_bounds(scene: &Scene, solution: &Solution<2>, factor: f64) -> Box2 {
    let mut places = vec![scene.bounds.0, scene.bounds.1];
    for (body, answer) in scene.model.bodies.iter().zip(&solution.bodies) {
        let moved = body.mesh.points().iter().zip(answer.shown().into_owned());
        places.extend(moved.map(|(&x, u)| add_scaled(x, factor, u)));
    }
    places.retain(|x| x.iter().all(|c| c.is_finite()));
    bounding_box(&places)
}

fn deformed_figure(scene: &Scene, solution: &Solution<2>, ranges: &[Range], width: f64) -> Markup {
    let labels = Labels::of(scene.model);
    let (windows, height) = windows(scene, solution, width);
    let height = height.max(least_height(ranges) + 40.0);
    let title = "Deformed shape coloured by von Mises stress";
    let mut svg = Svg::new("deformed", title, width, height);
    for (view, factor) in &windows {
        draw_view(&mut svg, scene, solution, view, *factor, ranges);
        scale_bar(&mut svg, view, &labels);
        let text = format!("displacements × {}", number(*factor));
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
    if let [(whole, _), (detail, _)] = windows.as_slice() {
        mark_detail(&mut svg, whole, detail);
    }
    let size = [width, height - 40.0];
    colour_bars(&mut svg, solution, ranges, &labels, size);
    svg.finish()
}

/// Drawings of solutions, each of a stage of the whole model, in one window, that of the contacts where these are small, equally
/// magnified and with the same colours; and words on magnification and place.
pub fn deformed_course(
    whole: &Model<2>,
    steps: &[(&Model<2>, &Solution<2>)],
) -> (Vec<Markup>, String) {
    let labels = Labels::of(whole);
    let all = Scene::new(whole);
    let ranges = stress_ranges(whole, steps.iter().map(|(_, solution)| *solution));
    let scenes: Vec<Scene> = steps.iter().map(|(stage, _)| Scene::new(stage)).collect();
    let each = || scenes.iter().zip(steps);
    let still = course_view(all.detail.unwrap_or(all.bounds), &ranges);
    let factors = each().map(|(scene, (_, solution))| magnification(scene, solution, &still));
    // where nothing moves any factor would do
    let moving = factors.zip(steps).filter(|(_, (_, solution))| {
        let moved = solution.bodies.iter().map(BodySolution::max_displacement);
        moved.fold(0.0, f64::max) > 0.0
    });
    let factor = moving
        .map(|(factor, _)| factor)
        .fold(f64::INFINITY, f64::min);
    let factor = if factor.is_finite() { factor } else { 1.0 };
    // around the contacts, where these are small
    let bounds = all.detail.unwrap_or_else(|| {
        let boxes = each().map(|(scene, (_, solution))| moved_bounds(scene, solution, factor));
        let corners: Vec<Point<2>> = boxes.flat_map(|(low, high)| [low, high]).collect();
        bounding_box(&corners)
    });
    let view = course_view(bounds, &ranges);
    let tall = view.size[1];
    let draw = |(k, (scene, (_, solution))): (usize, (&Scene, &(&Model<2>, &Solution<2>)))| {
        let title = format!("Deformed shape of picture {}", k + 1);
        let mut svg = Svg::new(&format!("course{k}"), &title, PHONE, tall + STRIP);
        draw_view(&mut svg, scene, solution, &view, factor, &ranges);
        scale_bar(&mut svg, &view, &labels);
        colour_bars(&mut svg, solution, &ranges, &labels, [PHONE, tall]);
        svg.finish()
    };
    let place = if all.detail.is_some() {
        ", around the contacts,"
    } else {
        ""
    };
    let words = format!("{} times{place}", number(factor));
    (each().enumerate().map(draw).collect(), words)
}

/// The window of a picture of a course, beside its colour bars.
fn course_view(bounds: Box2, ranges: &[Range]) -> View {
    let size = sub(bounds.1, bounds.0);
    let own = PHONE - BAR;
    let tall = (own - 28.0) * size[1] / size[0].max(f64::MIN_POSITIVE) + 28.0;
    // colour bars of many bodies are taller than any figure should be
    let least = least_height(ranges);
    let tall = tall.clamp(least, least.max(320.0));
    View::fitted(bounds, [0.0, 0.0], [own, tall], Margin::all(14.0))
}

/// Body and place of the largest stress, and the size of its surroundings that are worth a window of their own: beyond them it is
/// below a half of its value. `None` where the figure shows them well enough.
fn close_up(
    scene: &Scene,
    solution: &Solution<2>,
    views: &[View],
) -> Option<(usize, Point<2>, f64)> {
    let peaks = solution.bodies.iter().enumerate();
    let peaks = peaks.filter_map(|(i, body)| Some((i, body.peak?.most)));
    let (body, most) = peaks.max_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
    let mesh = &scene.model.bodies[body].mesh;
    let stresses = &solution.bodies[body].von_mises;
    let nodes = mesh.points().iter().zip(stresses);
    let away = nodes.filter(|(_, stress)| **stress < 0.5 * most.value);
    let half = away
        .map(|(&point, _)| distance(point, most.at))
        .fold(f64::INFINITY, f64::min);
    let size = |(low, high): Box2| (high[0] - low[0]).max(high[1] - low[1]);
    let near = views.iter().filter(|view| view.sees(view.pixel(most.at)));
    let shown = near
        .map(|view| size((view.low, view.high)))
        .fold(size(scene.bounds), f64::min);
    (half < CLOSE * shown).then_some((body, most.at, 4.0 * half))
}

fn close_figure(
    scene: &Scene,
    solution: &Solution<2>,
    ranges: &[Range],
    (centre, reach): (Point<2>, f64),
    width: f64,
) -> Markup {
    let labels = Labels::of(scene.model);
    let height = (0.4 * width).max(least_height(ranges)).max(220.0);
    let mut svg = Svg::new("closest", "The largest stress", width, height + STRIP);
    let around = [-reach, reach].map(|r| [centre[0] + r, centre[1] + r]);
    let size = [width - BAR - 2.0, height - 2.0];
    let view = View {
        detail: true,
        ..View::fitted((around[0], around[1]), [1.0, 1.0], size, Margin::all(0.0))
    };
    draw_view(&mut svg, scene, solution, &view, 0.0, ranges);
    svg.rectangle(view.corner, view.size, MUTED, "none");
    let at = view.pixel(centre);
    svg.circle(at, 4.0, INK, "none", "largest von Mises stress");
    let peaks = solution.bodies.iter().filter_map(|body| body.peak);
    let most = peaks.map(|peak| peak.most.value).fold(0.0, f64::max);
    let label = quantity(most, &labels.stress);
    beside(&mut svg, &view, [at[0], at[1] - 12.0], &label, INK, false);
    scale_bar(&mut svg, &view, &labels);
    colour_bars(&mut svg, solution, ranges, &labels, [width, height]);
    svg.finish()
}

/// A round factor that makes the largest displacement in sight about 5 % of the window's size, never less than 1.
pub fn magnification(scene: &Scene, solution: &Solution<2>, view: &View) -> f64 {
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

/// The bodies in a window, displacements magnified; with a factor of zero as they were.
pub fn draw_view(
    svg: &mut Svg,
    scene: &Scene,
    solution: &Solution<2>,
    view: &View,
    factor: f64,
    ranges: &[Range],
) {
    let mut canvas = Canvas::new(view);
    for (i, body) in scene.model.bodies.iter().enumerate() {
        let u = solution.bodies[i].shown();
        let high = end_for(ranges, &body.name);
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
        if factor > 0.0 {
            let original = outline_path(&scene.outlines[i], &|n| view.pixel(points[n]));
            svg.path(&original, "#fff", 1.6, "none", "stroke-opacity=\"0.55\"");
            let dashes = "stroke-dasharray=\"4 3\"";
            svg.path(&original, "#4a545e", 0.9, "none", dashes);
        }
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
    use crate::model::{Peak, StressAt};
    use crate::output::json::largest;
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
        let (windows, _) = windows(&scene, &solution, WIDTH);
        let factor = windows[0].1;
        let most = largest(solution.bodies.iter().map(BodySolution::max_displacement));
        let part = factor * most / 40.0;
        assert!(part <= SHOWN && part > 0.4 * SHOWN, "{part}");
    }

    #[test]
    fn a_small_place_of_the_largest_stress_gets_a_window_and_a_wide_one_does_not() {
        let (model, mut solution) = tunnel::solved();
        let scene = Scene::new(&model);
        let (windows, _) = windows(&scene, &solution, WIDTH);
        let views: Vec<View> = windows.into_iter().map(|(view, _)| view).collect();
        assert!(close_up(&scene, &solution, &views).is_none());
        // at the hole, where cells are small
        let at = model.bodies[1].mesh.points()[0];
        let most = StressAt { value: 1e6, at };
        solution.bodies[1].von_mises[0] = most.value;
        solution.bodies[1].peak = Some(Peak { most, place: None });
        // seen in the whole model alone
        let (body, centre, reach) = close_up(&scene, &solution, &[]).unwrap();
        assert_eq!((body, centre), (1, at));
        let far = |p: &&Point<2>| **p != at;
        let points = model.bodies[1].mesh.points().iter().filter(far);
        let next = points
            .map(|&p| distance(p, at))
            .fold(f64::INFINITY, f64::min);
        assert_eq!(reach, 4.0 * next);
        let ranges = stress_ranges(&model, [&solution]);
        let figure = close_figure(&scene, &solution, &ranges, (centre, reach), WIDTH);
        assert!(figure.contains("largest von Mises stress"));
    }
}
