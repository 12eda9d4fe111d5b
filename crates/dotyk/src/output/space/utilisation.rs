//! Picture "Utilisation" of a model in space: the surface of the bodies, undeformed, with the lines where the utilisation is 1.

use crate::model::Solution;
use crate::output::deformed::BAR;
use crate::output::html;
use crate::output::markup::Markup;
use crate::output::scene::WIDTH;
use crate::output::space::camera::Window;
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::scene::{HEAVY, PALE, Scene, triad_and_scale, windows};
use crate::output::space::setup::WORDS;
use crate::output::space::skin::Look;
use crate::output::svg::{ALARM, INK, Svg, Type};
use crate::output::text::{Labels, number};
use crate::output::utilisation::{
    caption, drawn, end_of_scale, largest_utilisation, utilisation_bar,
};
use rayon::prelude::*;

/// Room around the bodies.
const MARGIN: f64 = 14.0;

/// A place on a surface is seen where nothing is nearer by more than this many pixels.
const SEEN: f64 = 2.0;

/// The limit.
const LIMIT: Ink = Ink {
    colour: [0xb3, 0x26, 0x1e],
    cover: 1.0,
    width: 1.8,
    depth: Some(1.8),
};

/// The figure.
pub fn utilisation_figure(scene: &Scene<'_>, solution: &Solution<3>) -> Markup {
    let labels = Labels::of(scene.model);
    let extents = scene.cameras.map(|camera| camera.extent(scene.nodes()));
    let (windows, height) = windows(&scene.cameras, &extents, MARGIN, WIDTH - BAR);
    let title = "Utilisation of the strength";
    let mut svg = Svg::new("utilisation", title, WIDTH, height);
    let peak = largest_utilisation(solution).map(|(_, peak)| peak.most);
    let pictures = windows.par_iter().map(|window| {
        let canvas = painted(scene, solution, window);
        let seen = peak.filter(|most| canvas.sees(window.place(most.at), SEEN));
        (canvas.png(), seen)
    });
    let pictures: Vec<_> = pictures.collect();
    for ((window, word), (png, seen)) in windows.iter().zip(WORDS).zip(pictures) {
        svg.picture(window.corner, window.size, &png);
        if let Some(most) = seen {
            let at = window.pixel(most.at);
            let above = [at[0], at[1] - 9.0];
            svg.circle(at, 4.0, INK, ALARM, "largest utilisation");
            svg.text(above, &number(most.value), Type::LABEL.rimmed());
        }
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
            look.borders = body.borders.clone();
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
