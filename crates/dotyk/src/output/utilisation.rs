//! The picture of the utilisation of the strength, with the line where it is 1.

use crate::geometry::Point;
use crate::model::{BodySolution, Peak, Solution};
use crate::output::deformed::{BAR, CLEARLY, Canvas, Vertex, colour_bar, fans};
use crate::output::markup::Markup;
use crate::output::plot::Axis;
use crate::output::scene::{Scene, WIDTH, outline_path};
use crate::output::svg::{ALARM, Anchor, INK, MUTED, Pixel, Svg, Type, segments};
use crate::output::text::{Labels, number};
use crate::output::view::{Margin, View, beside, mark_detail, scale_bar};

/// The colours end here at the latest: what is beyond is far beyond the strength.
const MOST_SHOWN: f64 = 2.0;

/// The body with the largest utilisation, and that.
pub fn largest_utilisation<const D: usize>(solution: &Solution<D>) -> Option<(&str, Peak<D>)> {
    let bodies = solution.bodies.iter();
    let peaks = bodies.filter_map(|body| Some((&body.name[..], body.utilisation.as_ref()?.peak?)));
    peaks.max_by(|a, b| a.1.most.value.total_cmp(&b.1.most.value))
}

/// Where the colours end: at the largest utilisation, but not below 1, and not far beyond; where that is at a place where stresses are
/// not finite, at the usual one, if that is clearly less.
pub fn end_of_scale<const D: usize>(solution: &Solution<D>) -> f64 {
    let shown = |peak: Peak<D>| match peak.place {
        Some(place) if place.usual < CLEARLY * peak.most.value => place.usual,
        _ => peak.most.value,
    };
    let peaks = solution
        .bodies
        .iter()
        .filter_map(|body| body.utilisation.as_ref()?.peak);
    peaks.map(shown).fold(1.0, f64::max).min(MOST_SHOWN)
}

/// Utilisation of a body where stress is given, as it is drawn: NaN where it has none. Beyond the last colour it is that of its end, so that
/// what is infinite at a node does not swing between the nodes of quadratic cells.
pub fn drawn<const D: usize>(body: &BodySolution<D>) -> Vec<f64> {
    match &body.utilisation {
        Some(own) => own
            .nodal
            .iter()
            .map(|value| value.clamp(0.0, MOST_SHOWN))
            .collect(),
        None => vec![f64::NAN; body.borders.count()],
    }
}

/// The colours with the limit, at the right of a figure of this height.
pub fn utilisation_bar<const D: usize>(svg: &mut Svg, solution: &Solution<D>, height: f64) {
    let (left, top) = (WIDTH - BAR + 18.0, 42.0);
    let high = end_of_scale(solution);
    let axis = Axis::linear("Utilisation", "", &[0.0, high], true, 5);
    let small = Type::SMALL.anchored(Anchor::Start);
    svg.text([left, 20.0], &axis.label, small.coloured(MUTED));
    let most = largest_utilisation(solution).map_or(0.0, |(_, peak)| peak.most.value);
    let size = colour_bar(svg, [left, top], height - top - 22.0, &axis, most > high);
    let y = top + (1.0 - axis.fraction(1.0)) * size;
    svg.line([left - 4.0, y], [left + 18.0, y], "#fff", 3.0);
    svg.line([left - 4.0, y], [left + 18.0, y], ALARM, 1.6);
}

/// What the colours mean, for captions.
pub fn caption<const D: usize>(solution: &Solution<D>) -> String {
    let high = end_of_scale(solution);
    let most = largest_utilisation(solution).map_or(0.0, |(_, peak)| peak.most.value);
    let more = match most > high {
        true => format!(
            " The colours end at {}, the largest is {}.",
            number(high),
            number(most)
        ),
        false => String::new(),
    };
    let line = match most > 1.0 {
        true => "Red: the line where it is 1, and the place of the largest one.",
        false => "It is nowhere more than 1. Red: the place of the largest one.",
    };
    format!(
        "Utilisation of the strength by the elastic stress, 1 is failure; undeformed. {line}{more}"
    )
}

/// The figure as an SVG element, and its caption.
pub fn utilisation_figure(scene: &Scene, solution: &Solution<2>) -> (Markup, String) {
    let labels = Labels::of(scene.model);
    let (views, height) = scene.views(Margin::all(26.0), 34.0, BAR);
    let title = "Utilisation of the strength";
    let mut svg = Svg::new("utilisation", title, WIDTH, height);
    let high = end_of_scale(solution);
    for view in &views {
        draw_view(&mut svg, scene, solution, view, high);
        scale_bar(&mut svg, view, &labels);
    }
    if let [whole, detail] = views.as_slice() {
        mark_detail(&mut svg, whole, detail);
    }
    utilisation_bar(&mut svg, solution, height - 40.0);
    (svg.finish(), caption(solution))
}

fn draw_view(svg: &mut Svg, scene: &Scene, solution: &Solution<2>, view: &View, high: f64) {
    let mut canvas = Canvas::new(view);
    let mut limits = String::new();
    for (body, answer) in scene.model.bodies.iter().zip(&solution.bodies) {
        let places: Vec<Pixel> = body.mesh.points().iter().map(|&p| view.pixel(p)).collect();
        let values = drawn(answer);
        canvas.mesh((&body.mesh, &answer.borders), &places, &values, high);
        let vertex = |block: usize, node: u32| {
            let node = node as usize;
            (places[node], values[answer.borders.place(block, node)])
        };
        let lines = fans(&body.mesh, &vertex).into_iter().filter_map(crossing);
        let seen = lines.filter(|line| line.iter().any(|&end| view.sees(end)));
        limits.extend(seen.map(|line| segments(&line, false)));
    }
    svg.begin_clip(view.corner, view.size);
    svg.picture(view.corner, view.size, &canvas.png());
    for (body, strands) in scene.model.bodies.iter().zip(&scene.outlines) {
        let points: &[Point<2>] = body.mesh.points();
        let outline = outline_path(strands, &|n| view.pixel(points[n]));
        svg.path(
            &outline,
            "#10161c",
            0.9,
            "none",
            "stroke-linejoin=\"round\"",
        );
    }
    if !limits.is_empty() {
        let round = "stroke-linecap=\"round\"";
        svg.path(&limits, "#fff", 3.2, "none", round);
        svg.path(&limits, ALARM, 1.6, "none", round);
    }
    svg.end_clip();
    if let Some((_, peak)) = largest_utilisation(solution) {
        let at = view.pixel(peak.most.at);
        if view.sees(at) {
            svg.circle(at, 4.0, INK, ALARM, "largest utilisation");
            let above = [at[0], at[1] - 12.0];
            beside(svg, view, above, &number(peak.most.value), INK, false);
        }
    }
}

/// The line across a triangle on which its values are 1.
fn crossing(corners: [Vertex; 3]) -> Option<[Pixel; 2]> {
    let edges = (0..3).filter_map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        ((a.1 > 1.0) != (b.1 > 1.0)).then(|| {
            let part = (1.0 - a.1) / (b.1 - a.1);
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
    use crate::model::{Singular, SingularPeak, StressAt, Utilisation};
    use crate::output::json::summary;
    use crate::output::report::page;
    use crate::output::tunnel;
    use crate::output::vtu::body_vtu;
    use serde_json::Value;

    /// The tunnel with a utilisation of its first body alone, that is largest at its first node.
    fn solved(most: f64, singular: bool) -> (crate::model::Model<2>, Solution<2>) {
        let (model, mut solution) = tunnel::solved();
        let at = model.bodies[0].mesh.points()[0];
        let body = &mut solution.bodies[0];
        let mut nodal = vec![0.5; body.displacement.len()];
        nodal[0] = most;
        let place = singular.then_some(SingularPeak {
            place: Singular::Corner,
            away: None,
            usual: 0.5,
            share: 0.995,
        });
        body.utilisation = Some(Utilisation {
            nodal,
            overstressed: if most > 1.0 { 0.25 } else { 0.0 },
            judged: 10.0,
            peak: Some(Peak {
                most: StressAt { value: most, at },
                place,
            }),
        });
        (model, solution)
    }

    #[test]
    fn the_report_tells_what_is_overstressed_and_that_nothing_yields() {
        let told = |most: f64, singular: bool| {
            let (model, solution) = solved(most, singular);
            page(&tunnel::run(&model, &solution))
        };
        let page = told(1.5, false);
        for words in [
            "<h2>Strength</h2>",
            "Overstressed: 0.25",
            "2.5\u{202f}%",
            "The stress is elastic",
            "Largest utilisation",
            ALARM,
        ] {
            assert!(page.contains(words), "{words}");
        }
        assert!(!page.contains("grows as the mesh is refined"));
        assert!(told(1.5, true).contains("The largest utilisation of ring is at a re-entrant corner: it grows as the mesh is refined"));
        let page = told(0.9, false);
        assert!(
            page.contains("No stress exceeds the strength of ring: the largest utilisation is 0.9")
        );
        let page = told(f64::INFINITY, false);
        assert!(
            page.contains("beyond the apex")
                && page.contains("The colours end at 2, the largest is ∞")
        );
        let (model, solution) = tunnel::solved();
        assert!(!super::super::report::page(&tunnel::run(&model, &solution)).contains("Strength"));
    }

    #[test]
    fn bodies_without_a_strength_have_nan_and_null_beside_those_with_one() {
        let (model, solution) = solved(f64::INFINITY, false);
        for body in 0..2 {
            assert!(body_vtu(&model, &solution, body).contains("Name=\"utilisation\""));
        }
        let value: Value = serde_json::from_str(&summary(&tunnel::run(&model, &solution))).unwrap();
        let [with, without] = [&value["bodies"][0], &value["bodies"][1]];
        assert_eq!(with["overstressed_area"], 0.25);
        // infinite
        assert_eq!(with["max_utilisation"], Value::Null);
        assert_eq!(with["max_utilisation_at"].as_array().unwrap().len(), 2);
        assert!(without["overstressed_area"].is_null() && without.get("max_utilisation").is_some());
        let (model, solution) = tunnel::solved();
        assert!(!body_vtu(&model, &solution, 0).contains("utilisation"));
    }

    #[test]
    fn the_line_of_the_limit_crosses_where_linear_values_are_one() {
        let corners = [([0.0, 0.0], 0.0), ([10.0, 0.0], 2.0), ([0.0, 10.0], 0.0)];
        let mut ends = crossing(corners).unwrap();
        ends.sort_by(|a, b| a[1].total_cmp(&b[1]));
        assert_eq!(ends, [[5.0, 0.0], [5.0, 5.0]]);
        assert!(crossing([corners[0], corners[1], ([0.0, 1.0], f64::NAN)]).is_none());
        assert!(crossing([corners[0], corners[2], ([1.0, 1.0], 1.0)]).is_none());
    }
}
