//! Picture "Deformed shape" of a model in space: magnified displacements, coloured by the von Mises stress at the nodes.

use crate::geometry::{Point, add_scaled};
use crate::model::Solution;
use crate::output::deformed::{BAR, SHOWN, beyond_the_scale, colour_bars, stress_scales};
use crate::output::html;
use crate::output::markup::Markup;
use crate::output::plot::round_down_to_125;
use crate::output::scene::WIDTH;
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

/// Groups of bodies with one colour scale, and the stress at its end.
pub type Scales = [(Vec<usize>, f64)];

/// The figure.
pub fn stress_figure(scene: &Scene<'_>, solution: &Solution<3>) -> Markup {
    let labels = Labels::of(scene.model);
    let factor = magnification(scene, solution);
    let extents = scene.cameras.map(|camera| {
        let moved = moved(scene, solution, factor);
        camera.extent(scene.nodes().chain(moved))
    });
    let (windows, height) = windows(&scene.cameras, &extents, MARGIN, WIDTH - BAR);
    let title = "Deformed shape coloured by von Mises stress";
    let mut svg = Svg::new("deformed", title, WIDTH, height);
    let scales = stress_scales(solution);
    let pictures = windows.par_iter();
    let pictures = pictures.map(|w| deformed(scene, solution, w, factor, &scales).png());
    let pictures: Vec<Vec<u8>> = pictures.collect();
    for ((window, word), png) in windows.iter().zip(WORDS).zip(pictures) {
        svg.picture(window.corner, window.size, &png);
        triad_and_scale(&mut svg, window, &labels, word);
    }
    colour_bars(&mut svg, solution, &scales, &labels, height - 40.0);
    let caption = match factor {
        1.0 => "Displacements are drawn true to scale.".to_string(),
        _ => format!(
            "Displacements are magnified {} times, initial gaps are not.",
            number(factor)
        ),
    };
    let caption = caption
        + &beyond_the_scale(solution, &scales, &labels)
        + " Grey: edges before the deformation. Colour: von Mises stress, recovered at the nodes.";
    html::figure(&svg.finish(), "Deformed shape", &caption)
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

/// Stress of a body, where it is given, as parts of its scale.
pub fn stress_values(solution: &Solution<3>, scales: &Scales, body: usize) -> Vec<f64> {
    let own = scales.iter().find(|s| s.0.contains(&body));
    let high = own.map_or(1.0, |s| s.1);
    let high = if high > 0.0 { high } else { 1.0 };
    let stresses = solution.bodies[body].von_mises.iter();
    stresses.map(|s| s / high).collect()
}

fn deformed(
    scene: &Scene<'_>,
    solution: &Solution<3>,
    window: &Window,
    factor: f64,
    scales: &Scales,
) -> Canvas {
    let mut canvas = Canvas::new(window.size, &[BEFORE, PALE, HEAVY]);
    let looks: Vec<Look> = scene
        .skins
        .iter()
        .enumerate()
        .map(|(body, skin)| {
            let u = solution.bodies[body].shown();
            let mut look = Look::moved(window, skin.mesh.points(), &u, factor);
            look.values = stress_values(solution, scales, body);
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
