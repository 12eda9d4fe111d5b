//! Section "Beds" of the report: pressure, gap and area of bedded sides.

use crate::model::{BedSolution, Dimension, Solution};
use crate::output::html::{column, left, plain, table_of_vectors, text};
use crate::output::markup::{Markup, markup};
use crate::output::text::{Labels, Scales, number, vector};

/// A row for each bed; empty without beds.
pub fn beds_section<const D: usize>(solution: &Solution<D>, labels: &Labels) -> Markup {
    if solution.beds.is_empty() {
        return Markup::default();
    }
    let scales = Scales::of(solution);
    let stress = |value: f64| plain(number(scales.without_noise(value, Dimension::Stress)));
    let row = |bed: &BedSolution<D>| {
        let force = bed.resultant;
        let force = force.map(|f| scales.without_noise(f, Dimension::Force));
        vec![
            text(&bed.name),
            plain(number(bed.area())),
            plain(number(bed.closed_area())),
            stress(bed.mean_pressure()),
            stress(bed.largest().map_or(f64::NAN, |at| at.pressure)),
            plain(
                bed.largest()
                    .map_or(String::new(), |at| scales.place(&at.point)),
            ),
            stress(bed.min_pressure()),
            plain(number(
                scales.without_noise(bed.max_gap(), Dimension::Length),
            )),
            plain(vector(&force, "")),
        ]
    };
    let heads = [
        left("bed"),
        column("area", labels.unit(Dimension::Area)),
        column("pressed", labels.unit(Dimension::Area)),
        column("mean pressure", &labels.stress),
        column("largest", &labels.stress),
        column("at", &labels.length),
        column("smallest", &labels.stress),
        column("largest gap", &labels.length),
        column("force on the body", &labels.force),
    ];
    markup!(
        "<h2>Beds</h2>\n<p>Sides on springs, compression positive; areas are times the thickness, with axial symmetry those of the full turn.</p>\n{}",
        table_of_vectors(&heads, solution.beds.iter().map(row).collect())
    )
}
