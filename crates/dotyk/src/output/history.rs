//! Figure "Convergence": residual and active contact unknowns against iterations.

use crate::model::{HistoryPoint, Solution};
use crate::output::markup::Markup;
use crate::output::plot::{Axis, Frame};
use crate::output::scene::ticks;
use crate::output::svg::{Anchor, MUTED, SERIES, Svg, Type};
use crate::output::text::power;

/// Longer histories are thinned out to about this many points.
const MOST_DRAWN: usize = 1200;
/// More points than this are drawn without dots.
const MOST_DOTS: usize = 60;

/// The figure as an SVG element; `None` without a history.
pub fn history_figure<const D: usize>(
    solution: &Solution<D>,
    tolerance: f64,
    width: f64,
) -> Option<Markup> {
    let history = thinned(&solution.solver.history);
    if history.is_empty() {
        return None;
    }
    let mut svg = Svg::new(
        "history",
        "Residual and active contact unknowns against iterations",
        width,
        330.0,
    );
    let at = |h: &HistoryPoint| h.iteration as f64;
    let iterations: Vec<f64> = history.iter().map(at).collect();
    let residuals: Vec<f64> = history.iter().map(|h| h.residual).collect();
    let limits: Vec<f64> = residuals.iter().copied().chain([tolerance]).collect();
    // Room on both sides keeps the first and last points off the frame.
    let mut x = Axis::counts("Iteration", &iterations, false, ticks(width) + 2);
    let room = 0.02 * (x.range[1] - x.range[0]);
    x.range = [x.range[0] - room, x.range[1] + room];
    let upper = Frame {
        corner: [78.0, 12.0],
        size: [width - 94.0, 170.0],
        x: x.clone(),
        y: Axis::log("Residual (relative)", &limits),
    };
    upper.draw(&mut svg, false);
    upper.level(&mut svg, tolerance, MUTED);
    let small = Type::SMALL.coloured(MUTED).rimmed();
    let place = [upper.corner[0] + 8.0, upper.up(tolerance) - 5.0];
    svg.text(
        place,
        &format!("tolerance {}", power(tolerance)),
        small.anchored(Anchor::Start),
    );
    let [least, _] = upper.y.range;
    // An exact zero has no logarithm: it sits on the floor of the plot.
    let curve: Vec<[f64; 2]> = history
        .iter()
        .map(|h| [at(h), h.residual.max(least)])
        .collect();
    upper.curve(&mut svg, &curve, SERIES[1], 1.8);

    let actives: Vec<f64> = history.iter().map(|h| h.active as f64).collect();
    let y = Axis::counts("Active", &actives, true, 4).widened(0.08);
    let lower = Frame {
        corner: [78.0, 196.0],
        size: [width - 94.0, 84.0],
        x,
        y,
    };
    lower.draw(&mut svg, true);
    let steps: Vec<[f64; 2]> = history.iter().map(|h| [at(h), h.active as f64]).collect();
    lower.curve(&mut svg, &steps, SERIES[2], 1.6);
    if history.len() <= MOST_DOTS {
        for (point, h) in curve.iter().zip(&history) {
            let title = format!(
                "iteration {}: residual {}, {} active",
                h.iteration,
                power(h.residual),
                h.active
            );
            svg.circle(upper.at(point[0], point[1]), 2.6, SERIES[1], "#fff", &title);
            svg.circle(
                lower.at(point[0], h.active as f64),
                2.6,
                SERIES[2],
                "#fff",
                &title,
            );
        }
    }
    Some(svg.finish())
}

/// Every k-th point and the last.
fn thinned(history: &[HistoryPoint]) -> Vec<HistoryPoint> {
    let every = history.len().div_ceil(MOST_DRAWN).max(1);
    let mut list: Vec<HistoryPoint> = history.iter().step_by(every).copied().collect();
    if let (Some(last), Some(end)) = (list.last(), history.last())
        && last != end
    {
        list.push(*end);
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_histories_keep_their_end() {
        let history: Vec<HistoryPoint> = (1..=10_000)
            .map(|iteration| HistoryPoint {
                iteration,
                residual: 1.0,
                active: 0,
            })
            .collect();
        let list = thinned(&history);
        assert!(list.len() <= MOST_DRAWN + 1);
        assert_eq!(
            (list[0].iteration, list.last().unwrap().iteration),
            (1, 10_000)
        );
    }
}
