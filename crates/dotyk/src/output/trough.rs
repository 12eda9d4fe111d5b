//! Figure "Vertical displacement of the upper surface": the settlement trough of models of ground, over x, after several load steps.

use crate::geometry::Point;
use crate::mesh::Mesh;
use crate::model::{Analysis, LinePoint, Model, Solution};
use crate::output::html::fitted;
use crate::output::lines::{Curve, line_figure, spread};
use crate::output::markup::Markup;
use crate::output::scene::Scene;
use crate::output::svg::SERIES;
use crate::output::text::{Labels, count, number, quantity, without_noise};

/// A surface that is narrower than this part of the model is not that of the ground.
const WIDE: f64 = 0.8;

/// A place that is lower by less than this part of the model lies not beneath another one.
const LEVEL: f64 = 1e-6;

/// Corners of a facet that looks up: the left one, the right one, and all nodes from left to right, with their body.
struct Upper {
    left: Point<2>,
    right: Point<2>,
    nodes: Vec<(usize, usize)>,
}

/// The figure; empty without ground. `steps` are all load steps, the last of which is that of the scene.
pub fn trough_figure(scene: &Scene, steps: &[&Solution<2>]) -> Markup {
    let model = scene.model;
    let ground = model
        .bodies
        .iter()
        .any(|body| body.initial.stress.is_some());
    let surface = match ground && model.analysis != Analysis::Axisymmetric {
        true => surface(scene),
        false => Vec::new(),
    };
    let (Some(last), false) = (steps.last(), surface.is_empty()) else {
        return Markup::default();
    };
    let labels = Labels::of(model);
    let scale = last
        .bodies
        .iter()
        .map(|body| body.max_displacement())
        .fold(0.0, f64::max);
    let shown = spread(steps.len(), SERIES.len());
    let along: Vec<Vec<LinePoint>> = shown
        .iter()
        .map(|&step| settled(&surface, model, steps[step], scale))
        .collect();
    let curves = shown.iter().zip(&along).map(|(&step, places)| Curve {
        name: format!("t = {}", number(steps[step].time)),
        places,
    });
    let curves: Vec<Curve<'_>> = curves.collect();
    let values = along
        .last()
        .into_iter()
        .flatten()
        .filter(|place| place.value.is_finite());
    let told = |word: &str, place: Option<&LinePoint>| match place {
        Some(place) => format!(
            " {word}: {} at x = {}.",
            quantity(place.value, &labels.length),
            quantity(place.s, &labels.length)
        ),
        None => String::new(),
    };
    let least = values.clone().min_by(|a, b| a.value.total_cmp(&b.value));
    let most = values.max_by(|a, b| a.value.total_cmp(&b.value));
    let anew = steps.iter().any(|step| step.counted_from.is_some());
    let anew = match anew {
        true => {
            " From a step with `zero_displacements` on they count from the end of the step before it."
        }
        false => "",
    };
    let several = match steps.len() {
        1 => String::new(),
        all => format!(" after {} of {} load steps", count(shown.len()), count(all)),
    };
    let caption = format!(
        "Over x{several}, upward positive.{anew}{}{}",
        told("Lowest", least),
        told("Highest", most)
    );
    let draw = |width| {
        let named = (("x", "Vertical displacement"), labels.length.as_str());
        line_figure("trough", named, &curves, &labels, width)
    };
    fitted(
        &draw,
        "Vertical displacement of the upper surface",
        &caption,
    )
}

/// Vertical displacements along a surface; NaN where its body is not there.
fn settled(
    surface: &[Upper],
    model: &Model<2>,
    solution: &Solution<2>,
    scale: f64,
) -> Vec<LinePoint> {
    let value = |body: usize, node: usize| {
        let name = &model.bodies[body].name;
        let own = solution.bodies.iter().find(|own| own.name == *name);
        own.map_or(f64::NAN, |own| {
            without_noise(own.displacement[node][1], scale)
        })
    };
    let mut places = Vec::new();
    let mut before = None;
    for facet in surface {
        let joined = before == facet.nodes.first().copied();
        for &(body, node) in facet.nodes.iter().skip(usize::from(joined)) {
            let [x, y] = model.bodies[body].mesh.points()[node];
            places.push(LinePoint {
                s: x,
                point: [x, y, 0.0],
                value: value(body, node),
                starts: !joined && facet.nodes.first() == Some(&(body, node)),
            });
        }
        before = facet.nodes.last().copied();
    }
    places
}

/// Facets that look up, with nothing above them, from left to right; empty if they are not as wide as the model.
fn surface(scene: &Scene) -> Vec<Upper> {
    let bodies = scene.model.bodies.iter().enumerate();
    let upper: Vec<Upper> = bodies
        .flat_map(|(i, body)| looking_up(i, &body.mesh))
        .collect();
    let (low, high) = scene.bounds;
    let level = LEVEL * (high[1] - low[1]).max(high[0] - low[0]);
    let height = |facet: &Upper, x: f64| {
        let part = (x - facet.left[0]) / (facet.right[0] - facet.left[0]);
        facet.left[1] + part * (facet.right[1] - facet.left[1])
    };
    let is_free = |facet: &&Upper| {
        let x = 0.5 * (facet.left[0] + facet.right[0]);
        let own = height(facet, x) + level;
        let over =
            |other: &Upper| other.left[0] <= x && x <= other.right[0] && height(other, x) > own;
        !upper.iter().any(over)
    };
    let free: Vec<bool> = upper.iter().map(|facet| is_free(&facet)).collect();
    let mut list: Vec<Upper> = upper
        .into_iter()
        .zip(free)
        .filter_map(|(facet, free)| free.then_some(facet))
        .collect();
    list.sort_by(|a, b| a.left[0].total_cmp(&b.left[0]));
    let wide: f64 = list
        .iter()
        .map(|facet| facet.right[0] - facet.left[0])
        .sum();
    match wide >= WIDE * (high[0] - low[0]) {
        true => list,
        false => Vec::new(),
    }
}

/// Facets of a body that look up; their outside lies to the right of the way from their first node to the second.
fn looking_up(body: usize, mesh: &Mesh<2>) -> Vec<Upper> {
    let facets = mesh.boundary_facets().into_iter().filter_map(|facet| {
        let nodes: Vec<usize> = mesh.facet_nodes(facet).map(|node| node as usize).collect();
        let [right, left] = [nodes[0], nodes[1]].map(|node| mesh.points()[node]);
        let steep = (left[1] - right[1]).abs() >= right[0] - left[0];
        let order = [Some(nodes[1]), nodes.get(2).copied(), Some(nodes[0])];
        (!steep).then(|| Upper {
            left,
            right,
            nodes: order
                .into_iter()
                .flatten()
                .map(|node| (body, node))
                .collect(),
        })
    });
    facets.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Components;
    use crate::geometry::Field;
    use crate::mesh::{CellKind, Diagonals, Rectangle};
    use crate::model::Elastic;

    #[test]
    fn the_surface_of_ground_is_what_has_nothing_above_it() {
        let rectangle = |from, to, cells| {
            let rectangle = Rectangle {
                from,
                to,
                cells,
                cell: CellKind::Quad8,
                diagonals: Diagonals::default(),
            };
            rectangle.build().unwrap()
        };
        let mut model = Model::new();
        let elastic = Elastic {
            young: 100.0,
            poisson: 0.3,
        };
        let ground = model.body(
            "ground",
            rectangle([0.0, -4.0], [10.0, 0.0], [10, 4]),
            elastic,
        );
        // something small upon it, and a layer in it
        model.body("block", rectangle([4.0, 0.0], [6.0, 1.0], [2, 1]), elastic);
        model.body(
            "below",
            rectangle([0.0, -6.0], [10.0, -4.0], [5, 2]),
            elastic,
        );
        let scene = Scene::new(&model);
        let surface = surface(&scene);
        let bodies: Vec<usize> = surface.iter().map(|facet| facet.nodes[0].0).collect();
        assert_eq!(bodies, [0, 0, 0, 0, 1, 1, 0, 0, 0, 0]);
        assert!(surface.is_sorted_by(|a, b| a.right[0] <= b.left[0] + 1e-12));
        model.bodies.truncate(1);
        model.fix(ground, "bottom", [Some(0.0), Some(-0.25)]);
        let solution = model.solve().unwrap();
        // no ground without a stress in it
        assert!(trough_figure(&Scene::new(&model), &[&solution]).is_empty());
        model.bodies[0].initial.stress = Some(Components::isotropic(Field::constant(0.0)));
        let page = trough_figure(&Scene::new(&model), &[&solution]);
        assert!(page.contains("Lowest: −0.25"));
    }
}
