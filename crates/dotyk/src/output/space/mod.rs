//! Pictures of models in space, drawn by the program itself: no graphics card, no network.
//!
//! Surfaces are painted into pictures with depth ([`canvas`]), letters and symbols stand above them as vectors, so that they
//! stay sharp. Each function returns HTML to be put into a page; the same model and solution give the same bytes.

mod camera;
mod canvas;
mod contact;
mod marks;
mod scene;
mod section;
mod setup;
mod skin;
mod stress;
#[cfg(test)]
mod tests;
mod thin;
mod turning;

use crate::geometry::Point;
use crate::model::{Model, Solution};
use scene::Scene;

/// Mesh, supports and loads; `alone` are contact nodes that face nothing.
pub fn model_figure(model: &Model<3>, alone: &[Point<3>]) -> String {
    setup::setup_figure(&Scene::new(model), alone)
}

/// Deformed shape, the view that turns and a section, coloured by stress.
pub fn stress_figures(model: &Model<3>, solution: &Solution<3>) -> String {
    let scene = Scene::new(model);
    let stress = stress::stress_figure(&scene, solution);
    let section = section::section_figure(&scene, solution);
    stress + &turning::turning_view(&scene, solution) + &section.unwrap_or_default()
}

/// Pressure, gap and state of the contacts that bear most.
pub fn contact_figures(model: &Model<3>, solution: &Solution<3>) -> String {
    contact::contact_figures(&Scene::new(model), solution).concat()
}
