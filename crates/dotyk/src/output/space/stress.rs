//! Picture "Deformed shape" of a model in space: magnified displacements, coloured by the von Mises stress at the nodes.

use crate::geometry::{Point, add_scaled};
use crate::model::{Model, Solution};
use crate::output::deformed::SHOWN;
use crate::output::html;
use crate::output::markup::Markup;
use crate::output::plot::round_down_to_125;
use crate::output::ranges::{
    BAR, Range, colour_bars, end_for, in_words, least_height, stress_ranges,
};
use crate::output::scene::PHONE;
use crate::output::space::camera::Window;
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::scene::{GHOST, HEAVY, PALE, Scene, triad_and_scale, windows};
use crate::output::space::setup::WORDS;
use crate::output::space::skin::Look;
use crate::output::svg::Svg;
use crate::output::text::{Labels, number};
use rayon::prelude::*;

/// Room around the bodies.
const MARGIN: f64 = 14.0;

/// Edges of bodies where they were, behind what hides them.
const BEFORE: Ink = Ink {
    depth: Some(0.0),
    ..GHOST
};

/// The figure.
pub fn stress_figure(scene: &Scene<'_>, solution: &Solution<3>) -> Markup {
    let labels = Labels::of(scene.model);
    let factor = magnification(scene, solution);
    let extents = scene.cameras.map(|camera| {
        let moved = moved(scene, solution, factor);
        camera.extent(scene.nodes().chain(moved))
    });
    let ranges = stress_ranges(scene.model, [solution]);
    let draw = |width: f64| {
        let (windows, height) = windows(&scene.cameras, &extents, MARGIN, width - BAR);
        let height = height.max(least_height(&ranges) + 40.0);
        let title = "Deformed shape coloured by von Mises stress";
        let mut svg = Svg::new("deformed", title, width, height);
        let pictures = windows.par_iter();
        let pictures = pictures.map(|w| deformed(scene, solution, w, factor, &ranges).png());
        let pictures: Vec<Vec<u8>> = pictures.collect();
        for ((window, word), png) in windows.iter().zip(WORDS).zip(pictures) {
            svg.picture(window.corner, window.size, &png);
            triad_and_scale(&mut svg, window, &labels, word);
        }
        let size = [width, height - 40.0];
        colour_bars(&mut svg, solution, &ranges, &labels, size);
        svg.finish()
    };
    let caption = match factor {
        1.0 => "Displacements are drawn true to scale.".to_string(),
        _ => format!(
            "Displacements are magnified {} times, initial gaps are not.",
            number(factor)
        ),
    };
    let caption = caption
        + &in_words(solution, &ranges, &labels)
        + " Grey: edges before the deformation. Colour: von Mises stress, recovered at the nodes.";
    html::fitted(&draw, "Deformed shape", &caption)
}

/// Drawings of solutions, each of a stage of the whole model, in one window, equally magnified and with the same colours; and words
/// on the magnification.
pub fn deformed_course(
    whole: &Model<3>,
    steps: &[(&Model<3>, &Solution<3>)],
) -> (Vec<Markup>, String) {
    let labels = Labels::of(whole);
    let ranges = stress_ranges(whole, steps.iter().map(|(_, solution)| *solution));
    let all = Scene::new(whole);
    let camera = all.cameras[0];
    let scenes: Vec<Scene<'_>> = steps.iter().map(|(stage, _)| Scene::new(stage)).collect();
    let each = || scenes.iter().zip(steps);
    // where nothing moves any factor would do
    let moves = |solution: &Solution<3>| solution.bodies.iter().any(|b| b.max_displacement() > 0.0);
    let moving = each().filter(|(_, (_, solution))| moves(solution));
    let factors = moving.map(|(_, (_, solution))| magnification(&all, solution));
    let factor = factors.fold(f64::INFINITY, f64::min);
    let factor = if factor.is_finite() { factor } else { 1.0 };
    let places = each().flat_map(|(scene, (_, solution))| moved(scene, solution, factor));
    let extent = camera.extent(all.nodes().chain(places));
    let (windows, height) = windows(&[camera], &[extent], MARGIN, PHONE - BAR);
    let window = windows[0];
    let height = height.max(least_height(&ranges) + 40.0);
    let draw = |(k, (scene, (_, solution))): (usize, (&Scene<'_>, &(&Model<3>, &Solution<3>)))| {
        let title = format!("Deformed shape of picture {}", k + 1);
        let mut svg = Svg::new(&format!("course{k}"), &title, PHONE, height);
        let png = deformed(scene, solution, &window, factor, &ranges).png();
        svg.picture(window.corner, window.size, &png);
        triad_and_scale(&mut svg, &window, &labels, "");
        colour_bars(&mut svg, solution, &ranges, &labels, [PHONE, height - 40.0]);
        svg.finish()
    };
    let words = format!("{} times", number(factor));
    (each().enumerate().map(draw).collect(), words)
}

/// Places of all nodes, displacements magnified.
fn moved<'a>(
    scene: &'a Scene<'_>,
    solution: &'a Solution<3>,
    factor: f64,
) -> impl Iterator<Item = Point<3>> + 'a {
    let bodies = solution.bodies.iter();
    let displacements = bodies.flat_map(|body| body.shown().into_owned());
    let places = scene.nodes().zip(displacements);
    places.map(move |(x, u)| add_scaled(x, factor, u))
}

/// A round factor that makes the largest displacement about 5 % of the model's size, never less than 1.
pub fn magnification(scene: &Scene<'_>, solution: &Solution<3>) -> f64 {
    let moved = solution.bodies.iter().map(|body| body.max_displacement());
    let factor = SHOWN * scene.size() / moved.fold(0.0, f64::max);
    match factor.is_finite() {
        true => round_down_to_125(factor).max(1.0),
        false => 1.0,
    }
}

/// Stress of a body, where it is given, as parts of its range.
pub fn stress_values(solution: &Solution<3>, ranges: &[Range], body: usize) -> Vec<f64> {
    let high = end_for(ranges, &solution.bodies[body].name);
    let stresses = solution.bodies[body].von_mises.iter();
    stresses.map(|s| s / high).collect()
}

fn deformed(
    scene: &Scene<'_>,
    solution: &Solution<3>,
    window: &Window,
    factor: f64,
    ranges: &[Range],
) -> Canvas {
    let mut canvas = Canvas::new(window.size, &[BEFORE, PALE, HEAVY]);
    let looks: Vec<Look> = scene
        .skins
        .iter()
        .enumerate()
        .map(|(body, skin)| {
            let u = solution.bodies[body].shown();
            let mut look = Look::moved(window, skin.mesh.points(), &u, factor);
            look.values = stress_values(solution, ranges, body);
            look.borders = solution.bodies[body].borders.clone();
            look
        })
        .collect();
    for (body, (skin, look)) in scene.skins.iter().zip(&looks).enumerate() {
        skin.fill(&mut canvas, look, body, &|_| Paint::Scale);
    }
    for (skin, look) in scene.skins.iter().zip(&looks) {
        skin.outline(&mut canvas, window, look, [Some(1), Some(2)]);
        let before = Look::at(window, skin.mesh.points());
        skin.outline(&mut canvas, window, &before, [None, Some(0)]);
    }
    canvas
}
