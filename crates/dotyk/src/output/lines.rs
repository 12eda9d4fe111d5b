//! Section "Along lines" of the report: a plot of every probe that has values along a line.

use crate::model::{Along, LinePoint, Model, Probe, ProbeValue, Solution};
use crate::output::Overview;
use crate::output::html::fitted;
use crate::output::markup::{Markup, markup};
use crate::output::plot::{Axis, Frame, Stroke, keys};
use crate::output::scene::ticks;
use crate::output::svg::{SERIES, Svg};
use crate::output::text::{Labels, count, number, vector};

/// Curves of more points than this are drawn without dots.
const MOST_DOTS: usize = 60;

/// The section; empty without a probe along a line.
pub fn lines_section<const D: usize>(run: &Overview<'_, D>, labels: &Labels) -> Markup {
    let steps: Vec<&Solution<D>> = run.steps().collect();
    let shown = spread(steps.len(), SERIES.len());
    let probes = run.last.probes.iter().enumerate();
    let lines = probes.filter(|(_, probe)| !probe.line.is_empty());
    let figures = lines.map(|(index, probe)| {
        let curves = shown.iter().map(|&step| Curve {
            name: format!("t = {}", number(steps[step].time)),
            places: &steps[step].probes[index].line,
        });
        let curves: Vec<Curve<'_>> = curves.collect();
        let drawn = (("s", &probe.quantity[..]), labels.unit(probe.dimension));
        let draw = |width| line_figure(&format!("line-{index}"), drawn, &curves, labels, width);
        let mut caption = format!(
            "{} {}, {} points.",
            probe.quantity,
            place_in_words(run.stage(), probe),
            count(probe.line.len())
        );
        if shown.len() < steps.len() {
            caption += &format!(" {} of {} load steps.", shown.len(), count(steps.len()));
        }
        if probe.line.iter().any(|place| place.value.is_nan()) {
            caption += " The curve is interrupted where there is no value.";
        }
        fitted(&draw, &probe.name, &caption)
    });
    let figures: Markup = figures.collect();
    match figures.is_empty() {
        true => figures,
        false => markup!("<h2>Along lines</h2>\n") + figures,
    }
}

/// Indices of at most this many of the steps, the first and the last among them.
pub fn spread(steps: usize, most: usize) -> Vec<usize> {
    let (shown, last) = (steps.min(most), steps.saturating_sub(1));
    let place = |k: usize| (k * last + (shown - 1) / 2) / (shown - 1).max(1);
    (0..shown).map(place).collect()
}

/// The line of a probe: "from (0, 0) to (1, 0)", "along rock.hole"; a dash without a line.
pub fn place_in_words<const D: usize>(model: &Model<D>, probe: &ProbeValue) -> String {
    let asked = model.probes.iter().find(|asked| asked.name == probe.name);
    match asked.and_then(|asked: &Probe<D>| asked.along.as_ref()) {
        Some(Along::Line { from, to, .. }) => {
            format!("from {} to {}", vector(from, ""), vector(to, ""))
        }
        Some(Along::Side(side)) => {
            format!("along {}.{}", model.bodies[side.body.0].name, side.side)
        }
        None => "–".to_string(),
    }
}

/// The values of one step.
pub struct Curve<'a> {
    /// Of the step.
    pub name: String,
    /// In the order of s.
    pub places: &'a [LinePoint],
}

impl Curve<'_> {
    /// Points of the plot; one that is not finite lifts the pen before each piece.
    fn points(&self) -> Vec<[f64; 2]> {
        let pieces = self.places.iter().flat_map(|place| {
            let gap = place.starts.then_some([place.s, f64::NAN]);
            gap.into_iter().chain([[place.s, place.value]])
        });
        pieces.collect()
    }
}

/// Curves of a quantity, in a unit, over the length `along`.
pub fn line_figure(
    id: &str,
    ((along, quantity), unit): ((&str, &str), &str),
    curves: &[Curve<'_>],
    labels: &Labels,
    width: f64,
) -> Markup {
    let title = format!("{quantity} along a line");
    let mut svg = Svg::new(id, &title, width, 0.0);
    let names: Vec<&str> = curves.iter().map(|curve| curve.name.as_str()).collect();
    let head = match names.len() {
        0 | 1 => 12.0,
        _ => keys(&mut svg, [86.0, width], &names),
    };
    svg.set_height(head + 300.0);
    let places = || curves.iter().flat_map(|curve| curve.places);
    let ways: Vec<f64> = places().map(|place| place.s).collect();
    let values: Vec<f64> = places().map(|place| place.value).collect();
    let frame = Frame {
        corner: [86.0, head],
        size: [width - 106.0, 246.0],
        x: Axis::linear(along, &labels.length, &ways, false, ticks(width)).roomy(),
        y: Axis::of_change(quantity, unit, &values, 6).widened(0.06),
    };
    frame.draw(&mut svg, true);
    for (k, curve) in curves.iter().enumerate() {
        let stroke = Stroke::of(k, curves.len());
        frame.stroke(&mut svg, &curve.points(), stroke);
        if curve.places.len() <= MOST_DOTS {
            for place in curve.places.iter().filter(|place| place.value.is_finite()) {
                let at = vector(&place.point[..2], "");
                let hint = format!("{} at {at}: {}", curve.name, number(place.value));
                stroke.dot(&mut svg, frame.at(place.s, place.value), &hint);
            }
        }
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{BodyId, Reading, SideRef};
    use crate::output::tunnel;

    #[test]
    fn a_spread_has_both_ends_and_no_step_twice() {
        assert_eq!(spread(1, 6), [0]);
        assert_eq!(spread(3, 6), [0, 1, 2]);
        assert_eq!(spread(6, 6), [0, 1, 2, 3, 4, 5]);
        for steps in [7, 8, 12, 100] {
            let shown = spread(steps, 6);
            assert_eq!((shown[0], shown[5], shown.len()), (0, steps - 1, 6));
            assert!(shown.is_sorted_by(|a, b| a < b), "{shown:?}");
        }
    }

    #[test]
    fn every_line_has_its_plot_and_a_gap_lifts_the_pen() {
        let (mut model, _) = tunnel::solved();
        let [from, to] = [[0.0, -4.0], [0.0, 4.0]];
        let line = Along::Line {
            from,
            to,
            points: 9,
        };
        let side = SideRef {
            body: BodyId(1),
            side: "hole".to_string(),
        };
        for (name, quantity, along) in [
            ("axis & more", "rock.stress.yy", line),
            ("wall", "rock.stress.normal", Along::Side(side)),
        ] {
            let probe = model.probe(name, quantity, Reading::Whole).unwrap();
            probe.along = Some(along);
        }
        let solution = model.solve().unwrap();
        let labels = Labels::of(&model);
        let section = lines_section(&tunnel::run(&model, &solution), &labels);
        assert_eq!(section.matches("<figure>").count(), 2);
        assert!(section.contains("axis &amp; more") && section.contains("along rock.hole"));
        assert!(section.contains("from (0, −4) to (0, 4), 9 points. The curve is interrupted"));
        assert!(section.contains("rock.stress.yy [MN/m²]") && section.contains(">s [m]<"));
        // the hole is not part of the rock: two pieces
        let values = solution.probes[1].line.iter().map(|place| place.value);
        let inside: Vec<bool> = values.map(f64::is_finite).collect();
        let rock = |k: usize| !(2..7).contains(&k);
        assert_eq!(inside, (0..9).map(rock).collect::<Vec<_>>());
        let piece = |k: usize, starts: bool| LinePoint {
            s: k as f64,
            point: [0.0; 3],
            value: 1.0,
            starts,
        };
        let places = [piece(0, true), piece(1, false), piece(2, true)];
        let curve = Curve {
            name: String::new(),
            places: &places,
        };
        let pens: Vec<bool> = curve.points().iter().map(|p| p[1].is_nan()).collect();
        assert_eq!(pens, [true, false, false, true, false]);
        let none = tunnel::solved();
        assert!(lines_section(&tunnel::run(&none.0, &none.1), &labels).is_empty());
    }
}
