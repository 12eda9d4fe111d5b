//! Section "Yielding" of the report: the plastic zones of each body, and their picture.

use crate::model::Solution;
use crate::output::figures::Figures;
use crate::output::html::{column, left, plain, table, text};
use crate::output::markup::{Markup, markup};
use crate::output::picture::Picture;
use crate::output::text::{Labels, number};

/// At the border of the plastic zone the equivalent plastic strain is this part of the largest: smaller values are remainders of the
/// mean over cells.
const BORDER: f64 = 0.01;

/// The largest equivalent plastic strain; zero without yielding.
fn largest<const D: usize>(solution: &Solution<D>) -> f64 {
    let own = solution.bodies.iter().filter_map(|b| b.yielding.as_ref());
    own.flat_map(|own| own.equivalent.iter().copied())
        .fold(0.0, f64::max)
}

/// The picture of the plastic zone, with its border.
pub fn yielding_picture<const D: usize>(solution: &Solution<D>) -> Picture<D> {
    let most = largest(solution);
    Picture {
        id: "yielding",
        title: "Plastic zone",
        label: "Plastic strain",
        most_called: "largest equivalent plastic strain",
        values: solution
            .bodies
            .iter()
            .map(|body| body.at_nodes("equivalent_plastic_strain"))
            .collect(),
        high: most,
        limit: BORDER * most,
        most: None,
        caption: format!(
            "Equivalent plastic strain, undeformed; the largest is {}. Red: the border of what has yielded, where it is a hundredth of the largest.",
            number(most)
        ),
    }
}

/// The section; empty if no material yields.
pub fn yielding_section<const D: usize>(
    solution: &Solution<D>,
    figures: &Figures<'_>,
    labels: &Labels,
) -> Markup {
    if solution.bodies.iter().all(|body| body.yielding.is_none()) {
        return Markup::default();
    }
    let (word, unit) = labels.interior();
    let rows = solution.bodies.iter().filter_map(|body| {
        let own = body.yielding.as_ref()?;
        let most = own.equivalent.iter().copied().fold(0.0, f64::max);
        Some(vec![
            text(&body.name),
            plain(number(most)),
            plain(number(own.extent)),
        ])
    });
    let heads = [
        left("body"),
        column("largest equivalent plastic strain", ""),
        column(&format!("plastic {word}"), &unit),
    ];
    let (picture, words) = match largest(solution) > 0.0 {
        true => (
            figures.yielding(solution),
            "Stress is returned to what the material bears; what is beyond it elastically has gone to the neighbourhood.",
        ),
        false => (
            Markup::default(),
            "Nothing has yielded: the answer is that of elastic bodies.",
        ),
    };
    [
        markup!("<h2>Yielding</h2>\n"),
        picture,
        table(&heads, rows.collect()),
        markup!("<p>{}</p>\n", words),
    ]
    .into_iter()
    .collect()
}
