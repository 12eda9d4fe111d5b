//! Pictures of models in space, drawn by the program itself: no graphics card, no network.
//!
//! Surfaces are painted into pictures with depth, letters and symbols stand above them as vectors, so that they
//! stay sharp. Each function returns HTML to be put into a page; the same model and solution give the same bytes.

mod camera;
mod canvas;
mod contact;
mod face;
mod friction;
mod marks;
mod picture;
mod scene;
mod section;
mod setup;
mod skin;
mod stress;
#[cfg(test)]
mod tests;
mod thin;
mod turning;

pub use picture::picture;
pub use scene::Scene;
pub use setup::model_figure;
pub use stress::deformed_course;

use crate::model::Solution;
use crate::output::markup::Markup;

/// Deformed shape, the view that turns and a section, coloured by stress.
pub fn stress_figures(scene: &Scene<'_>, solution: &Solution<3>) -> Markup {
    let turning = || turning::turning_view(scene, solution);
    let section = || section::section_figure(scene, solution).unwrap_or_default();
    let (shape, (turning, section)) = rayon::join(
        || stress::stress_figure(scene, solution),
        || rayon::join(turning, section),
    );
    shape + turning + section
}

/// Pressure, gap and state of a contact.
pub fn contact_figure(scene: &Scene<'_>, solution: &Solution<3>, index: usize) -> Markup {
    contact::contact_figure(scene, solution, index).unwrap_or_default()
}
