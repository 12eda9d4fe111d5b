//! Picture "Utilisation" of a model in space: the surface of the bodies, undeformed, with the lines where the utilisation is 1.

use crate::model::Solution;
use crate::output::deformed::BAR;
use crate::output::html;
use crate::output::scene::WIDTH;
use crate::output::space::camera::Window;
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::scene::{HEAVY, PALE, Scene, triad_and_scale, windows};
use crate::output::space::setup::WORDS;
use crate::output::space::skin::Look;
use crate::output::svg::Svg;
use crate::output::text::Labels;
use crate::output::utilisation::{caption, drawn, end_of_scale, utilisation_bar};
use rayon::prelude::*;

/// Room around the bodies.
const MARGIN: f64 = 14.0;

/// The limit.
pub const LIMIT: Ink = Ink {
    colour: [0xb3, 0x26, 0x1e],
    cover: 1.0,
    width: 1.8,
    depth: Some(1.8),
};

/// The figure.
pub fn utilisation_figure(scene: &Scene<'_>, solution: &Solution<3>) -> String {
    let labels = Labels::of(scene.model);
    let extents = scene.cameras.map(|camera| camera.extent(scene.nodes()));
    let (windows, height) = windows(&scene.cameras, &extents, MARGIN, WIDTH - BAR);
    let title = "Utilisation of the strength";
    let mut svg = Svg::new("utilisation", title, WIDTH, height);
    let pictures = windows
        .par_iter()
        .map(|w| painted(scene, solution, w).png());
    let pictures: Vec<Vec<u8>> = pictures.collect();
    for ((window, word), png) in windows.iter().zip(WORDS).zip(pictures) {
        svg.picture(window.corner, window.size, &png);
        triad_and_scale(&mut svg, window, &labels, word);
    }
    utilisation_bar(&mut svg, solution, height - 40.0);
    html::figure(&svg.finish(), title, &caption(solution))
}

fn painted(scene: &Scene<'_>, solution: &Solution<3>, window: &Window) -> Canvas {
    let mut canvas = Canvas::new(window.size, &[PALE, HEAVY, LIMIT]);
    let high = end_of_scale(solution);
    let looks = scene
        .skins
        .iter()
        .zip(&solution.bodies)
        .map(|(skin, body)| {
            let mut look = Look::at(window, skin.mesh.points());
            look.values = drawn(body).into_iter().map(|value| value / high).collect();
            look
        });
    let looks: Vec<Look> = looks.collect();
    for (body, (skin, look)) in scene.skins.iter().zip(&looks).enumerate() {
        skin.fill(&mut canvas, look, body, &|_| Paint::Scale);
    }
    for (skin, look) in scene.skins.iter().zip(&looks) {
        skin.outline(&mut canvas, window, look, [Some(0), Some(1)]);
        skin.level(&mut canvas, look, 1.0 / high, 2);
    }
    canvas
}
