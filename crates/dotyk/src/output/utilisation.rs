//! The utilisation of the strength: the largest one, and its picture.

use crate::model::{BodySolution, Peak, Solution};
use crate::output::picture::Picture;
use crate::output::ranges::CLEARLY;
use crate::output::text::number;

/// Largest end of the colours: larger values are far beyond the strength.
const MOST_SHOWN: f64 = 2.0;

/// The body with the largest utilisation, and its value.
pub fn largest_utilisation<const D: usize>(solution: &Solution<D>) -> Option<(&str, Peak<D>)> {
    let bodies = solution.bodies.iter();
    let peaks = bodies.filter_map(|body| Some((&body.name[..], body.utilisation.as_ref()?.peak?)));
    peaks.max_by(|a, b| a.1.most.value.total_cmp(&b.1.most.value))
}

/// End of the colours: the largest utilisation, but not below 1, and not far beyond; if that is at a place where stresses are not
/// finite, the usual one if it is clearly less.
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

/// Utilisation of a body at the places of stress, as drawn: NaN without a value, and limited to the end of the colours, so that an
/// infinite value at a node does not oscillate between the nodes of quadratic cells.
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

/// The picture of the utilisation, with the line where it is 1.
pub fn utilisation_picture<const D: usize>(solution: &Solution<D>) -> Picture<D> {
    Picture {
        id: "utilisation",
        title: "Utilisation of the strength",
        label: "Utilisation",
        most_called: "largest utilisation",
        values: solution.bodies.iter().map(drawn).collect(),
        high: end_of_scale(solution),
        limit: 1.0,
        most: largest_utilisation(solution).map(|(_, peak)| (peak.most.at, peak.most.value)),
        caption: caption(solution),
    }
}

/// Meaning of the colours, for captions.
fn caption<const D: usize>(solution: &Solution<D>) -> String {
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
    let (stress, one) = match solution.bodies.iter().any(|body| body.yielding.is_some()) {
        true => ("stress", "1 is failure, or yielding"),
        false => ("elastic stress", "1 is failure"),
    };
    format!("Utilisation of the strength by the {stress}, {one}; undeformed. {line}{more}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Singular, SingularPeak, StressAt, Utilisation};
    use crate::output::json::summary;
    use crate::output::report::page;
    use crate::output::svg::ALARM;
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
}
