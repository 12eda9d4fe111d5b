//! The view that turns: the surfaces of all bodies with their displacements and values as numbers of 8 to 32 bits, and the
//! script that draws them in the page.
//!
//! Quantities: positions are low + span · p / 65535, displacements unit · u / 32767, values high · v / 255.

use crate::geometry::{Point, add_scaled, norm, sub};
use crate::model::{Model, Solution, numbers_at_nodes};
use crate::output::html;
use crate::output::json::largest;
use crate::output::markup::{Markup, markup};
use crate::output::space::face::faces;
use crate::output::space::scene::Scene;
use crate::output::space::stress::magnification;
use crate::output::space::thin::{Surface, thinned};
use crate::output::svg::short;
use crate::output::text::{Labels, number, quantity, with_unit};
use crate::output::utilisation::drawn;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

/// Most triangles: with their nodes about 1 MB, so that a page stays below two.
pub const MOST_TRIANGLES: usize = 48_000;

/// A quantity of all bodies.
struct Shown {
    name: String,
    unit: String,
    /// By body and place where stress is given; NaN where there is none.
    values: Vec<Vec<f64>>,
}

/// The view with its controls and its script.
pub fn turning_view(scene: &Scene<'_>, solution: &Solution<3>) -> Markup {
    let shown = quantities(scene, solution);
    let names = shown.iter().enumerate();
    let quantities = options(&mut names.map(|(i, q)| (i as i64, q.name.clone())));
    let bodies = scene.model.bodies.iter().enumerate();
    let bodies = bodies.map(|(i, b)| (i as i64, b.name.clone()));
    let bodies = options(&mut std::iter::once((-1, "all bodies".to_string())).chain(bodies));
    let factor = magnification(scene, solution);
    markup!(
        "<figure id=\"turning\" class=\"turning\">\n<style>\n{}</style>\n<div class=\"tools\">\
         <label>Colour <select name=\"quantity\">{}</select></label>\
         <label>Show <select name=\"body\">{}</select></label>\
         <label>Deformation <input name=\"factor\" type=\"range\" min=\"0\" max=\"100\" value=\"50\"> \
         <output>× {}</output></label><button name=\"reset\" type=\"button\">Reset</button></div>\n\
         <div class=\"stage\"><canvas tabindex=\"0\" aria-label=\"The model, to be turned\"></canvas>\
         <div class=\"scale\"><span class=\"name\"></span><span class=\"high\"></span><i></i><span>0</span></div>{}</div>\n\
         <figcaption><b>View that turns.</b> Drag to turn, with Shift to move, wheel or two fingers to zoom; arrow keys, \
         + and −, 0 for the first view. Without scripts this place is empty: the pictures show the same.</figcaption>\n\
         <script type=\"application/json\" id=\"turning-data\">{}</script>\n{}</figure>\n",
        Markup::own(include_str!("turning.css")),
        quantities,
        bodies,
        number(factor),
        triad(),
        Markup::json(&data(scene, solution, &shown, factor)),
        html::script(),
    )
    .titled("View that turns")
}

fn options(names: &mut dyn Iterator<Item = (i64, String)>) -> Markup {
    let option =
        |(value, name): (i64, String)| markup!("<option value=\"{}\">{}</option>", value, name);
    names.map(option).collect()
}

/// Axes that the script turns.
fn triad() -> Markup {
    let axis = |(name, colour): (&str, &str)| {
        markup!(
            "<g data-axis=\"{0}\"><line stroke=\"{1}\" stroke-width=\"1.6\"/><text fill=\"{1}\" \
             font-size=\"11\" font-weight=\"600\" text-anchor=\"middle\">{0}</text></g>",
            name,
            colour
        )
    };
    let axes = [("x", "#b3402e"), ("y", "#2f7d4f"), ("z", "#2a5d9f")].map(axis);
    markup!(
        "<svg viewBox=\"-34 -34 68 68\" aria-hidden=\"true\">{}</svg>",
        axes.into_iter().collect::<Markup>()
    )
}

fn quantities(scene: &Scene<'_>, solution: &Solution<3>) -> Vec<Shown> {
    let labels = Labels::of(scene.model);
    let bodies = || solution.bodies.iter();
    let moved = bodies().map(|b| {
        let nodes = b.borders.nodes();
        nodes.map(|node| norm(b.displacement[node])).collect()
    });
    // the utilisation ends where its colours do
    let of_nodes = numbers_at_nodes(solution).into_iter().map(|kind| Shown {
        name: kind.label(),
        unit: labels.unit(kind.dimension).to_string(),
        values: match kind.name {
            "utilisation" => bodies().map(drawn).collect(),
            name => bodies().map(|b| b.at_nodes(name)).collect(),
        },
    });
    let mut list: Vec<Shown> = of_nodes.collect();
    list.insert(
        1,
        Shown {
            name: "displacement".to_string(),
            unit: labels.length.clone(),
            values: moved.collect(),
        },
    );
    if !solution.contacts.is_empty() {
        list.push(Shown {
            name: "contact pressure".to_string(),
            unit: labels.stress.clone(),
            values: pressures(scene, solution),
        });
    }
    list
}

fn pressures(scene: &Scene<'_>, solution: &Solution<3>) -> Vec<Vec<f64>> {
    let blank = |body: &crate::model::Body<3>| vec![f64::NAN; body.mesh.points().len()];
    let mut values: Vec<Vec<f64>> = scene.model.bodies.iter().map(blank).collect();
    for contact in &solution.contacts {
        for face in faces(scene, contact).unwrap_or_default() {
            for (old, &own) in values[face.body].iter_mut().zip(&face.pressure) {
                *old = old.max(own);
            }
        }
    }
    for (own, body) in values.iter_mut().zip(&solution.bodies) {
        *own = body.borders.nodes().map(|node| own[node]).collect();
    }
    values
}

/// Everything that the script draws.
fn data(
    scene: &Scene<'_>,
    solution: &Solution<3>,
    shown: &[Shown],
    factor: f64,
) -> serde_json::Value {
    let Model { bodies, .. } = scene.model;
    let solved = || solution.bodies.iter();
    let points = bodies.iter().zip(solved()).map(|(body, own)| {
        let nodes = own.borders.nodes();
        nodes.map(|node| body.mesh.points()[node]).collect()
    });
    let points: Vec<Vec<Point<3>>> = points.collect();
    let skins = scene.skins.iter().zip(solved());
    let surfaces = skins.map(|(skin, own)| Surface::of(skin, &own.borders));
    let by_body: Vec<&[Point<3>]> = points.iter().map(Vec::as_slice).collect();
    let surfaces = thinned(surfaces.collect(), &by_body, scene.size(), MOST_TRIANGLES);
    let (low, high) = scene.bounds;
    let span = sub(high, low).map(|s| if s > 0.0 { s } else { 1.0 });
    let drawn = solved().map(|own| {
        let shown = own.shown();
        own.borders.nodes().map(|node| shown[node]).collect()
    });
    let drawn: Vec<Vec<Point<3>>> = drawn.collect();
    let unit = largest(drawn.iter().flat_map(|u| u.iter().map(|&u| norm(u))));
    let unit = if unit > 0.0 { unit } else { 1.0 };
    let mut packed = Packed::default();
    let ends: Vec<f64> = shown
        .iter()
        .map(|q| largest(q.values.iter().flatten().copied()))
        .map(|high| if high > 0.0 { high } else { 1.0 })
        .collect();
    packed.values = vec![Vec::new(); shown.len()];
    packed.known = vec![Vec::new(); shown.len()];
    let mut ranges = Vec::new();
    for (body, surface) in surfaces.iter().enumerate() {
        let mut place = vec![u32::MAX; points[body].len()];
        let mut index = |node: u32, packed: &mut Packed| -> u32 {
            let n = node as usize;
            if place[n] == u32::MAX {
                place[n] = packed.count;
                packed.count += 1;
                for d in 0..3 {
                    let share = (points[body][n][d] - low[d]) / span[d];
                    packed
                        .positions
                        .extend(((65535.0 * share).round() as u16).to_le_bytes());
                    let moved = drawn[body][n][d] / unit;
                    packed
                        .moved
                        .extend(((32767.0 * moved).round() as i16).to_le_bytes());
                }
                for (k, q) in shown.iter().enumerate() {
                    let value = q.values[body][n] / ends[k];
                    packed.values[k].push((255.0 * value.max(0.0)).round() as u8);
                    packed.known[k].push(if value.is_nan() { 0 } else { 255 });
                }
            }
            place[n]
        };
        let starts = [packed.triangles.len(), packed.edges.len()];
        for &node in surface.triangles.as_flattened() {
            let own = index(node, &mut packed);
            packed.triangles.push(own);
        }
        for &node in surface.edges.as_flattened() {
            let own = index(node, &mut packed);
            packed.edges.push(own);
        }
        let counts = [3 * surface.triangles.len(), 2 * surface.edges.len()];
        ranges.push(json!({
            "triangles": [starts[0], counts[0]],
            "edges": [starts[1], counts[1]],
        }));
    }
    let quantities: Vec<_> = shown
        .iter()
        .enumerate()
        .map(|(k, q)| {
            let whole = packed.known[k].iter().all(|k| *k > 0);
            json!({
                "label": with_unit(&q.name, &q.unit),
                "high": quantity(ends[k], ""),
                "values": STANDARD.encode(&packed.values[k]),
                "known": (!whole).then(|| STANDARD.encode(&packed.known[k])),
            })
        })
        .collect();
    let [camera, _] = scene.cameras;
    let [x, y, z] = camera.towards;
    let (least, most) = camera.extent(scene.nodes());
    // some room around the first view, for what moves and turns
    let [wide, tall] = [0, 1].map(|d| 1.25 * (most[d] - least[d]).max(f64::MIN_POSITIVE));
    let rounded = |degrees: f64| short(degrees).parse::<f64>().unwrap_or(0.0);
    json!({
        "low": low,
        "span": span,
        "centre": add_scaled(low, 0.5, sub(high, low)),
        "diameter": norm(sub(high, low)),
        "wide": wide,
        "high": tall,
        "unit": unit,
        "factor": factor,
        "azimuth": rounded(x.atan2(-y).to_degrees()),
        "lift": rounded(z.asin().to_degrees()),
        "bodies": ranges,
        "quantities": quantities,
        "positions": STANDARD.encode(&packed.positions),
        "displacements": STANDARD.encode(&packed.moved),
        "short": packed.is_short(),
        "triangles": STANDARD.encode(packed.indices(&packed.triangles)),
        "edges": STANDARD.encode(packed.indices(&packed.edges)),
    })
}

/// Bytes of all nodes, and the corners of triangles and ends of edges by number.
#[derive(Default)]
struct Packed {
    count: u32,
    positions: Vec<u8>,
    moved: Vec<u8>,
    values: Vec<Vec<u8>>,
    known: Vec<Vec<u8>>,
    triangles: Vec<u32>,
    edges: Vec<u32>,
}

impl Packed {
    /// Two bytes are enough for the number of a node.
    fn is_short(&self) -> bool {
        self.count <= 1 << 16
    }

    /// Numbers of nodes as bytes.
    fn indices(&self, numbers: &[u32]) -> Vec<u8> {
        let bytes = if self.is_short() { 2 } else { 4 };
        let each = numbers.iter().map(|number| number.to_le_bytes());
        each.flat_map(|own| own.into_iter().take(bytes)).collect()
    }
}
