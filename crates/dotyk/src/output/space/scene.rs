//! Common parts of all pictures of a model in space: surfaces of its bodies, cameras, windows, triad and scale.
//!
//! The first direction is the one, of some around the model, that shows most of the marked facets: every direction is drawn
//! small, and visible pixels are counted. The other is its opposite, which shows the parts hidden from the first.

use crate::geometry::{Point, bounding_box};
use crate::mesh::Facet;
use crate::model::Model;
use crate::output::plot::round_down_to_125;
use crate::output::points::in_reach;
use crate::output::scene::PHONE;
use crate::output::space::camera::{Camera, Window};
use crate::output::space::canvas::{Canvas, Ink, Paint};
use crate::output::space::skin::{Look, Skin};
use crate::output::svg::{Anchor, INK, MUTED, Pixel, Svg, Type, segments, text_width};
use crate::output::text::{Labels, quantity};
use crate::output::view::Box2;

/// Room below a window for triad and scale.
pub const STRIP: f64 = 46.0;

/// Room between windows.
const BETWEEN: f64 = 16.0;

/// Azimuths to look from, the usual one first: x to the right and into the paper, y likewise.
const AZIMUTHS: [f64; 4] = [32.0, -32.0, 148.0, -148.0];

/// Degrees above the horizon.
const LIFT: f64 = 26.0;

/// A direction must show this many times as much as an earlier one to be chosen.
const BETTER: f64 = 1.15;

/// Size of the pictures that test a camera.
const TRIAL_SIZE: Pixel = [220.0, 220.0];

/// Edges between cells.
pub const THIN: Ink = Ink {
    colour: [0x2a, 0x36, 0x42],
    cover: 0.42,
    width: 0.5,
    depth: Some(1.2),
};

/// The same on coloured surfaces.
pub const PALE: Ink = Ink {
    colour: [0xff, 0xff, 0xff],
    cover: 0.3,
    ..THIN
};

/// Edges of bodies.
pub const HEAVY: Ink = Ink {
    colour: [0x12, 0x19, 0x20],
    cover: 0.92,
    width: 1.0,
    depth: Some(1.8),
};

/// Edges of transparent parts.
pub const GHOST: Ink = Ink {
    colour: [0x8a, 0x95, 0xa0],
    cover: 0.6,
    width: 0.7,
    depth: None,
};

/// A model on paper.
pub struct Scene<'a> {
    /// The model.
    pub model: &'a Model<3>,
    /// Boundary of each body.
    pub skins: Vec<Skin<'a>>,
    /// Box around everything.
    pub bounds: (Point<3>, Point<3>),
    /// The first shows most of the loaded, held and contact facets; the other looks from the opposite side.
    pub cameras: [Camera; 2],
}

impl<'a> Scene<'a> {
    /// Surfaces of all bodies.
    pub fn new(model: &'a Model<3>) -> Self {
        let skin =
            |body: &'a crate::model::Body<3>| Skin::new(&body.mesh, body.mesh.boundary_facets());
        let points = model.bodies.iter().flat_map(|body| body.mesh.points());
        let points: Vec<Point<3>> = points.copied().collect();
        let mut scene = Self {
            model,
            skins: model.bodies.iter().map(skin).collect(),
            bounds: bounding_box(&points),
            cameras: [Camera::around(AZIMUTHS[0], LIFT); 2],
        };
        let first = scene.best_camera();
        scene.cameras = [first, first.opposite()];
        scene
    }

    /// Facets of a named side; empty without such a side.
    pub fn side(&self, body: usize, side: &str) -> &'a [Facet] {
        let body = self.model.bodies.get(body);
        body.and_then(|b| b.mesh.side(side)).unwrap_or(&[])
    }

    /// Size of the model: the longest edge of its box.
    pub fn size(&self) -> f64 {
        let (low, high) = self.bounds;
        (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max)
    }

    /// The first of some cameras around the model that shows most of the marked facets.
    fn best_camera(&self) -> Camera {
        let bodies = 0..self.skins.len();
        let weights: Vec<Vec<f64>> = bodies.map(|body| self.weights(body)).collect();
        let shown = |camera: &Camera| {
            let window = Window::fitted(
                *camera,
                camera.extent(self.nodes()),
                [0.0; 2],
                TRIAL_SIZE,
                2.0,
            );
            let mut canvas = Canvas::sampled(TRIAL_SIZE, 1, &[]);
            for (skin, weights) in self.skins.iter().zip(&weights) {
                let look = Look::at(&window, skin.mesh.points());
                skin.fill(&mut canvas, &look, 0, &|facet| {
                    Paint::Plain([(255.0 * weights[facet]) as u8, 0, 0])
                });
            }
            canvas.redness() / (window.scale * window.scale)
        };
        let cameras = AZIMUTHS.map(|azimuth| Camera::around(azimuth, LIFT));
        let mut best = (cameras[0], shown(&cameras[0]));
        for camera in &cameras[1..] {
            let here = shown(camera);
            if here > BETTER * best.1 {
                best = (*camera, here);
            }
        }
        best.0
    }

    /// Weight of a facet of a body in the choice of a camera.
    fn weights(&self, body: usize) -> Vec<f64> {
        let facets = &self.skins[body].facets;
        let mut weights = vec![0.0; facets.len()];
        let mut mark = |side: &str, weight: f64| {
            for facet in self.side(body, side) {
                if let Ok(index) = facets.binary_search(facet) {
                    weights[index] = f64::max(weights[index], weight);
                }
            }
        };
        let of = &self.model.bodies[body];
        for load in &of.loads {
            if let crate::model::Place::Side(side) = load.place() {
                mark(&side, 1.0);
            }
        }
        for support in &of.supports {
            if let crate::model::Place::Side(side) = &support.place {
                mark(side, 0.4);
            }
        }
        for contact in &self.model.contacts {
            for side in contact.pair.sides() {
                if side.body.0 == body {
                    mark(&side.side, 0.8);
                }
            }
        }
        weights
    }

    /// Windows onto the bodies and the points of couples from both directions, below or beside each other; and the height of
    /// the figure, in a figure of this width.
    pub fn windows(&self, margin: f64, width: f64) -> (Vec<Window>, f64) {
        let places = || self.nodes().chain(in_reach(self.model, self.bounds));
        let extents = self.cameras.map(|camera| camera.extent(places()));
        windows(&self.cameras, &extents, margin, width)
    }

    /// Places of all nodes.
    pub fn nodes(&self) -> impl Iterator<Item = Point<3>> + '_ {
        let bodies = self.model.bodies.iter();
        bodies.flat_map(|body| body.mesh.points()).copied()
    }
}

/// Windows onto extents, beside each other where they are high, else below each other, in a figure of this width.
pub fn windows(
    cameras: &[Camera],
    extents: &[Box2],
    margin: f64,
    width: f64,
) -> (Vec<Window>, f64) {
    let aspect = |(low, high): &Box2| {
        let ratio = (high[0] - low[0]) / (high[1] - low[1]);
        if ratio.is_finite() {
            ratio.clamp(0.05, 20.0)
        } else {
            1.0
        }
    };
    let widest = extents.iter().map(aspect).fold(0.0, f64::max);
    let count = cameras.len() as f64;
    let beside = cameras.len() > 1 && widest < 1.7 && width > PHONE;
    let own = match beside {
        true => (width - (count - 1.0) * BETWEEN) / count,
        false => width,
    };
    let most = if beside || cameras.len() == 1 {
        430.0
    } else {
        330.0
    };
    let room =
        |extent: &Box2| ((own - 2.0 * margin) / aspect(extent) + 2.0 * margin).clamp(150.0, most);
    let highest = extents.iter().map(room).fold(0.0, f64::max);
    let (mut list, mut bottom) = (Vec::new(), 0.0);
    for (k, (camera, extent)) in cameras.iter().zip(extents).enumerate() {
        let (corner, height) = match beside {
            true => ([k as f64 * (own + BETWEEN), 0.0], highest),
            false => ([0.0, bottom], room(extent)),
        };
        let size = [own.floor(), height.floor()];
        list.push(Window::fitted(*camera, *extent, corner, size, margin));
        bottom = match beside {
            true => height + STRIP,
            false => bottom + height + STRIP,
        };
    }
    (list, bottom)
}

/// Length of the axes, and from their ends to their letters.
const TRIAD: f64 = 22.0;
const LETTER: f64 = 8.0;

/// Axes and a bar of round length below a window, with a word on the direction.
pub fn triad_and_scale(svg: &mut Svg, window: &Window, labels: &Labels, word: &str) {
    let bottom = window.corner[1] + window.size[1];
    // over the margin of the picture, or else below it
    let below = if window.filled {
        6.0 + TRIAD + LETTER
    } else {
        12.0
    };
    triad(
        svg,
        &window.camera,
        [window.corner[0] + 34.0, bottom + below],
    );
    let y = bottom + 26.0;
    let start = window.corner[0] + 84.0;
    let most = (0.26 * window.size[0]).min(120.0);
    let length = round_down_to_125(most / window.scale);
    let end = start + length * window.scale;
    let path = [
        [start, y - 3.0],
        [start, y + 3.0],
        [start, y],
        [end, y],
        [end, y - 3.0],
        [end, y + 3.0],
    ];
    svg.path(&segments(&path, false), INK, 1.1, "none", "");
    let small = Type::SMALL.coloured(MUTED);
    let text = quantity(length, &labels.length);
    svg.text([end + 6.0, y + 3.8], &text, small.anchored(Anchor::Start));
    let left = end + 14.0 + 1.1 * text_width(&text, small.size);
    let right = window.corner[0] + window.size[0] - 4.0;
    if left + text_width(word, small.size) < right {
        svg.text([right, y + 3.8], word, small.anchored(Anchor::End));
    }
}

/// The axes, those that point away from the viewer first.
fn triad(svg: &mut Svg, camera: &Camera, origin: Pixel) {
    const COLOURS: [&str; 3] = ["#b3402e", "#2f7d4f", "#2a5d9f"];
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| {
        let depth = |i: usize| camera.turned(axes[i])[2];
        depth(a).total_cmp(&depth(b))
    });
    for i in order {
        let [x, y, _] = camera.turned(axes[i]);
        let tip = [origin[0] + TRIAD * x, origin[1] - TRIAD * y];
        svg.arrow(origin, tip, COLOURS[i], 1.3);
        let beyond = [
            origin[0] + (TRIAD + LETTER) * x,
            origin[1] - (TRIAD + LETTER) * y,
        ];
        // an axis along the line of sight keeps its letter beside the others
        let at = match x.hypot(y) < 0.2 {
            true => [origin[0] - 9.0, origin[1] + 9.0],
            false => beyond,
        };
        let style = Type::SMALL.coloured(COLOURS[i]).bold();
        svg.text([at[0], at[1] + 3.6], ["x", "y", "z"][i], style);
    }
}
