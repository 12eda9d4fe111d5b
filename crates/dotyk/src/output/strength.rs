//! Section "Strength" of the report: utilisation and overstressed zones.

use crate::model::{BodySolution, Solution};
use crate::output::figures::Figures;
use crate::output::html::{column, left, plain, table, text};
use crate::output::markup::{Markup, markup};
use crate::output::text::{Labels, number, quantity, singular_peak, vector};
use crate::output::vtu::judged;

/// The section; empty if no body has a strength.
pub fn strength_section<const D: usize>(
    solution: &Solution<D>,
    figures: &Figures<'_>,
    labels: &Labels,
) -> Markup {
    if !judged(solution) {
        return Markup::default();
    }
    let words = solution
        .bodies
        .iter()
        .flat_map(|body| in_words(body, labels));
    let words = words.map(|line| markup!("<p>{}</p>\n", line));
    let elastic = "The stress is elastic. Where it exceeds the strength the material would yield or break and hand stress on to its \
                   neighbourhood, which is not computed: what is overstressed tells where that begins, not how far it goes.";
    let mut asked = solution.bodies.iter().filter(|b| b.utilisation.is_some());
    let elastic = match asked.all(|body| body.yielding.is_some()) {
        true => "",
        false => elastic,
    };
    [
        markup!("<h2>Strength</h2>\n"),
        figures.utilisation(solution),
        bodies(solution, labels),
        words.collect(),
        markup!("<p>{}</p>\n", elastic),
    ]
    .into_iter()
    .collect()
}

fn bodies<const D: usize>(solution: &Solution<D>, labels: &Labels) -> Markup {
    let (word, unit) = labels.interior();
    let rows = solution.bodies.iter().filter_map(|body| {
        let own = body.utilisation.as_ref()?;
        let most = own.peak.map(|peak| peak.most);
        Some(vec![
            text(&body.name),
            plain(most.map_or("–".to_string(), |most| number(most.value))),
            plain(most.map_or("–".to_string(), |most| vector(&most.at, ""))),
            plain(number(own.overstressed)),
            plain(number(own.judged)),
        ])
    });
    let heads = [
        left("body"),
        column("largest utilisation", ""),
        column("at", &labels.length),
        column(&format!("overstressed {word}"), &unit),
        column("of", &unit),
    ];
    table(&heads, rows.collect())
}

/// Text on a body with a strength.
fn in_words<const D: usize>(body: &BodySolution<D>, labels: &Labels) -> Vec<String> {
    let Some((own, peak)) = body
        .utilisation
        .as_ref()
        .and_then(|own| Some((own, own.peak?)))
    else {
        return Vec::new();
    };
    let (name, most) = (&body.name, number(peak.most.value));
    let at = vector(&peak.most.at, &labels.length);
    let unit = labels.interior().1;
    let told = if own.overstressed > 0.0 {
        let place = match peak.most.value.is_finite() {
            true => format!("most at {at}, where the utilisation is {most}"),
            false => format!(
                "at {at}, and perhaps elsewhere, it is beyond the apex of the criterion and the utilisation infinite"
            ),
        };
        format!(
            "Overstressed: {} of {name}, {}\u{202f}% of it; {place}.",
            quantity(own.overstressed, &unit),
            number(100.0 * own.overstressed / own.judged),
        )
    } else {
        format!(
            "No stress exceeds the strength of {name}: the largest utilisation is {most}, at {at}."
        )
    };
    let what = format!("utilisation of {name}");
    let singular = singular_peak(&what, Some(peak), ["", &labels.length]);
    std::iter::once(told).chain(singular).collect()
}
