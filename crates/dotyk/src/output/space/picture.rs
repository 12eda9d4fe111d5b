//! Pictures of a result on the surface of the bodies of a model in space, undeformed, with the lines where it reaches a limit.

use crate::model::Solution;
use crate::output::html;
use crate::output::markup::Markup;
use crate::output::picture::Picture;
use crate::output::ranges::BAR;
use crate::output::space::camera::Window;
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::scene::{HEAVY, PALE, Scene, triad_and_scale, windows};
use crate::output::space::setup::WORDS;
use crate::output::space::skin::Look;
use crate::output::svg::{ALARM, INK, Svg, Type};
use crate::output::text::{Labels, number};
use rayon::prelude::*;

/// Room around the bodies.
const MARGIN: f64 = 14.0;

/// A place on a surface is visible if no surface is nearer by more than this many pixels.
const SEEN: f64 = 2.0;

/// The limit.
const LIMIT: Ink = Ink {
    colour: [0xb3, 0x26, 0x1e],
    cover: 1.0,
    width: 1.8,
    depth: Some(1.8),
};

/// The figure.
pub fn picture(scene: &Scene<'_>, solution: &Solution<3>, picture: &Picture<3>) -> Markup {
    let labels = Labels::of(scene.model);
    let extents = scene.cameras.map(|camera| camera.extent(scene.nodes()));
    let draw = |width: f64| {
        let (windows, height) = windows(&scene.cameras, &extents, MARGIN, width - BAR);
        let mut svg = Svg::new(picture.id, picture.title, width, height);
        let pictures = windows.par_iter().map(|window| {
            let canvas = painted(scene, solution, picture, window);
            let most = picture.most;
            let seen = most.filter(|(at, _)| canvas.sees(window.place(*at), SEEN));
            (canvas.png(), seen)
        });
        let pictures: Vec<_> = pictures.collect();
        for ((window, word), (png, seen)) in windows.iter().zip(WORDS).zip(pictures) {
            svg.picture(window.corner, window.size, &png);
            if let Some((at, most)) = seen {
                let at = window.pixel(at);
                let above = [at[0], at[1] - 9.0];
                svg.circle(at, 4.0, INK, ALARM, picture.most_called);
                svg.text(above, &number(most), Type::LABEL.rimmed());
            }
            triad_and_scale(&mut svg, window, &labels, word);
        }
        picture.bar(&mut svg, [width, height - 40.0]);
        svg.finish()
    };
    html::fitted(&draw, picture.title, &picture.caption)
}

fn painted(
    scene: &Scene<'_>,
    solution: &Solution<3>,
    picture: &Picture<3>,
    window: &Window,
) -> Canvas {
    let mut canvas = Canvas::new(window.size, &[PALE, HEAVY, LIMIT]);
    let high = picture.high;
    let looks = scene
        .skins
        .iter()
        .zip(&solution.bodies)
        .zip(&picture.values)
        .map(|((skin, body), values)| {
            let mut look = Look::at(window, skin.mesh.points());
            look.values = values.iter().map(|value| value / high).collect();
            look.borders = body.borders.clone();
            look
        });
    let looks: Vec<Look> = looks.collect();
    for (body, (skin, look)) in scene.skins.iter().zip(&looks).enumerate() {
        skin.fill(&mut canvas, look, body, &|_| Paint::Scale);
    }
    for (skin, look) in scene.skins.iter().zip(&looks) {
        skin.outline(&mut canvas, window, look, [Some(0), Some(1)]);
        skin.level(&mut canvas, look, picture.limit / high, 2);
    }
    canvas
}
