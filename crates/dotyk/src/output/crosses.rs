//! Figure "Principal stresses": crosses along the principal directions of the plane, as long as the stresses are large.
//!
//! σ₁,₂ = (σx + σy)/2 ± √((σx − σy)²/4 + τ²), the first at ½ atan2(2τ, σx − σy) from +x; tension is positive.

use crate::geometry::{Point, distance};
use crate::model::Solution;
use crate::output::html::fitted;
use crate::output::markup::Markup;
use crate::output::ranges::{Range, end_for, stress_ranges};
use crate::output::scene::{Scene, outline_path};
use crate::output::svg::{Anchor, MUTED, Pixel, SIGNS, Svg, Type, segments, text_width};
use crate::output::text::{Labels, quantity};
use crate::output::view::{Margin, STRIP, View, mark_detail, scale_bar};
use std::collections::BTreeMap;

/// From one cross to the next, and half of the longest arm, in pixels.
const SPACING: f64 = 21.0;
const ARM: f64 = 10.0;

/// Bodies smaller than this many crosses have none.
const ROOM: f64 = 3.0;

/// Shorter arms than this are not seen.
const LEAST: f64 = 0.7;

/// The figure; empty without a stress.
pub fn crosses_figure(scene: &Scene, solution: &Solution<2>) -> Markup {
    let ranges = stress_ranges(scene.model, [solution]);
    if !ranges.iter().any(|range| range.high > 0.0) {
        return Markup::default();
    }
    let labels = Labels::of(scene.model);
    let longest = ranges.iter().map(|range| {
        let end = quantity(range.high, &labels.stress);
        match ranges.len() {
            1 => end,
            _ => format!("{end} in {}", range.bodies.join(", ")),
        }
    });
    let caption = format!(
        "Crosses at nodes of the undeformed bodies, along the principal directions. The longest arms stand for {}, or more.",
        longest.collect::<Vec<_>>().join("; ")
    );
    let draw = |width| drawing(scene, solution, &ranges, width);
    fitted(&draw, "Principal stresses", &caption)
}

fn drawing(scene: &Scene, solution: &Solution<2>, ranges: &[Range], width: f64) -> Markup {
    let labels = Labels::of(scene.model);
    let (views, height) = scene.views(width, Margin::all(16.0), STRIP);
    let mut svg = Svg::new("principal", "Principal stresses", width, height + 20.0);
    for view in &views {
        svg.begin_clip(view.corner, view.size);
        let mut arms = [String::new(), String::new()];
        for (i, body) in scene.model.bodies.iter().enumerate() {
            let points = body.mesh.points();
            let outline = outline_path(&scene.outlines[i], &|n| view.pixel(points[n]));
            svg.path(&outline, "#9aa5b0", 0.8, "#f4f6f8", "fill-rule=\"evenodd\"");
            let high = end_for(ranges, &body.name);
            // a few crosses on a small body would be any of its nodes
            let (low, far) = scene.extents[i];
            if distance(low, far) * view.scale < ROOM * SPACING {
                continue;
            }
            for node in spread_out(points, view) {
                let stress = solution.bodies[i].stress[node];
                let at = view.pixel(points[node]);
                for (value, direction) in principal(stress) {
                    let arm = ARM * (value.abs() / high).min(1.0);
                    if arm >= LEAST {
                        let end = |sign: f64| {
                            let [x, y] = direction.map(|c| sign * arm * c);
                            [at[0] + x, at[1] - y]
                        };
                        let line = segments(&[end(-1.0), end(1.0)], false);
                        arms[usize::from(value < 0.0)] += &line;
                    }
                }
            }
        }
        for (path, colour) in arms.iter().zip(SIGNS) {
            svg.path(path, colour, 1.2, "none", "");
        }
        svg.end_clip();
        scale_bar(&mut svg, view, &labels);
    }
    if let [whole, detail] = views.as_slice() {
        mark_detail(&mut svg, whole, detail);
    }
    let mut left = 8.0;
    for (name, colour) in ["tension", "compression"].iter().zip(SIGNS) {
        let y = height + 10.0;
        svg.line([left, y], [left + 2.0 * ARM, y], colour, 1.6);
        let style = Type::LABEL.anchored(Anchor::Start).coloured(MUTED);
        svg.text([left + 2.0 * ARM + 6.0, y + 4.0], name, style);
        left += 2.0 * ARM + 24.0 + text_width(name, style.size);
    }
    svg.finish()
}

/// Nodes in sight with about the spacing of crosses between them: of each square the one nearest to its middle.
fn spread_out(points: &[Point<2>], view: &View) -> Vec<usize> {
    let mut chosen: BTreeMap<[i64; 2], (usize, f64)> = BTreeMap::new();
    for (node, &point) in points.iter().enumerate() {
        let at: Pixel = view.pixel(point);
        if !view.sees(at) {
            continue;
        }
        let square = at.map(|c| (c / SPACING).floor());
        let off = (0..2)
            .map(|i| at[i] / SPACING - square[i] - 0.5)
            .map(|d| d * d)
            .sum::<f64>();
        let entry = chosen
            .entry(square.map(|c| c as i64))
            .or_insert((node, off));
        if off < entry.1 {
            *entry = (node, off);
        }
    }
    chosen.into_values().map(|(node, _)| node).collect()
}

/// The principal stresses of the plane with their directions.
fn principal([xx, yy, _, xy, ..]: [f64; 6]) -> [(f64, Point<2>); 2] {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = half.hypot(xy);
    let (s, c) = (0.5 * xy.atan2(half)).sin_cos();
    [(mean + radius, [c, s]), (mean - radius, [-s, c])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::scene::WIDTH;
    use crate::output::tunnel;

    #[test]
    fn principal_stresses_turn_with_the_stress() {
        for degrees in [0.0, 20.0, 90.0, 135.0_f64] {
            // 3 along the direction, −1 across it
            let (s, c) = degrees.to_radians().sin_cos();
            let xx = 3.0 * c * c - s * s;
            let yy = 3.0 * s * s - c * c;
            let [(most, along), (least, across)] = principal([xx, yy, 7.0, 4.0 * s * c, 0.0, 0.0]);
            assert!((most - 3.0).abs() < 1e-12 && (least + 1.0).abs() < 1e-12);
            assert!((along[0] * s - along[1] * c).abs() < 1e-12, "{degrees}");
            assert!((across[0] * c + across[1] * s).abs() < 1e-12, "{degrees}");
        }
    }

    #[test]
    fn crosses_keep_their_distance_however_fine_the_mesh() {
        let (model, solution) = tunnel::solved();
        let scene = Scene::new(&model);
        let (views, _) = scene.views(WIDTH, Margin::all(16.0), STRIP);
        for view in &views {
            let points = model.bodies[1].mesh.points();
            let squares = (view.size[0] / SPACING + 2.0) * (view.size[1] / SPACING + 2.0);
            assert!((spread_out(points, view).len() as f64) < squares);
        }
        let page = crosses_figure(&scene, &solution);
        assert!(page.contains("compression") && page.contains("or more"));
    }
}
