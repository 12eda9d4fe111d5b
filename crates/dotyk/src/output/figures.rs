//! The drawings of a page, in the plane and in space.
//!
//! Pages are written for any dimension and get their drawings here; a missing drawing is an empty text.

use crate::geometry::{Point, padded};
use crate::model::{Model, SideRef, Solution};
use crate::output::Overview;
use crate::output::crosses::crosses_figure;
use crate::output::deformed::{deformed_course, deformed_figures};
use crate::output::film;
use crate::output::html::fitted;
use crate::output::interface::{Stretch, interface_figure};
use crate::output::lines::spread;
use crate::output::markup::Markup;
use crate::output::picture::Picture;
use crate::output::scene::Scene;
use crate::output::setup::setup_figure;
use crate::output::space;
use crate::output::text::{Labels, count, number};
use crate::output::trough::trough_figure;
use crate::output::utilisation::utilisation_picture;
use crate::output::yielding::yielding_picture;
use std::any::Any;

/// The drawings of a model, in the plane or in space.
pub struct Figures<'a> {
    /// Of the plane.
    plane: Option<Scene<'a>>,
    /// Of space.
    space: Option<space::Scene<'a>>,
}

/// A value of D dimensions as one of the plane or of space, if it is one.
fn known<T: Any, P: Any>(thing: &T) -> Option<&P> {
    (thing as &dyn Any).downcast_ref()
}

impl<'a> Figures<'a> {
    /// The drawings of a model.
    pub fn of<const D: usize>(model: &'a Model<D>) -> Self {
        Self {
            plane: known(model).map(Scene::new),
            space: known(model).map(space::Scene::new),
        }
    }

    /// Mesh, supports and loads, and these contact nodes without an opposite side.
    pub fn model<const D: usize>(&self, alone: &[Point<D>]) -> Markup {
        if let Some(scene) = &self.space {
            let alone: Vec<Point<3>> = alone.iter().map(|p| padded(*p)).collect();
            return space::model_figure(scene, &alone);
        }
        let Some(scene) = &self.plane else {
            return Markup::default();
        };
        let alone: Vec<Point<2>> = alone.iter().map(|p| [p[0], p[1]]).collect();
        fitted(
            &|width| setup_figure(scene, &alone, width),
            "Mesh, supports and loads",
            &mesh_caption(scene.model),
        )
    }

    /// The deformed shape, coloured by stress, and the largest stress; in space a view that turns and a section, too, in the plane
    /// the principal stresses.
    pub fn deformed<const D: usize>(&self, solution: &Solution<D>) -> Markup {
        if let (Some(scene), Some(solution)) = (&self.space, known(solution)) {
            return space::stress_figures(scene, solution);
        }
        let (Some(scene), Some(solution)) = (&self.plane, known(solution)) else {
            return Markup::default();
        };
        deformed_figures(scene, solution) + crosses_figure(scene, solution)
    }

    /// The vertical displacement of the surface of ground after load steps; nothing in space.
    pub fn trough<const D: usize>(&self, steps: &[&Solution<D>]) -> Markup {
        let steps: Option<Vec<&Solution<2>>> = steps.iter().map(|step| known(*step)).collect();
        match (&self.plane, steps) {
            (Some(scene), Some(steps)) => trough_figure(scene, &steps),
            _ => Markup::default(),
        }
    }

    /// The utilisation of the strength, with the line where it is 1.
    pub fn utilisation<const D: usize>(&self, solution: &Solution<D>) -> Markup {
        self.picture(solution, utilisation_picture, utilisation_picture)
    }

    /// The plastic zone, with its border.
    pub fn yielding<const D: usize>(&self, solution: &Solution<D>) -> Markup {
        self.picture(solution, yielding_picture, yielding_picture)
    }

    /// A result over the undeformed bodies.
    fn picture<const D: usize>(
        &self,
        solution: &Solution<D>,
        in_plane: fn(&Solution<2>) -> Picture<2>,
        in_space: fn(&Solution<3>) -> Picture<3>,
    ) -> Markup {
        if let (Some(scene), Some(solution)) = (&self.space, known(solution)) {
            return space::picture(scene, solution, &in_space(solution));
        }
        let (Some(scene), Some(solution)) = (&self.plane, known(solution)) else {
            return Markup::default();
        };
        let picture = in_plane(solution);
        let draw = |width| picture.in_plane(scene, solution, width);
        fitted(&draw, picture.title, &picture.caption)
    }

    /// Pressure and gap along a contact, in space on its faces.
    pub fn contact<const D: usize>(&self, solution: &Solution<D>, index: usize) -> Markup {
        if let (Some(scene), Some(solution)) = (&self.space, known(solution)) {
            return space::contact_figure(scene, solution, index);
        }
        let (Some(scene), Some(solution)) = (&self.plane, known::<_, Solution<2>>(solution)) else {
            return Markup::default();
        };
        let contact = &solution.contacts[index];
        let law = &scene.model.contacts[index].law;
        let Some(stretch) = Stretch::of(contact) else {
            return Markup::default();
        };
        let bodies = &scene.model.bodies;
        let name = |side: &SideRef| format!("{}.{}", bodies[side.body.0].name, side.side);
        let other = contact.mortar.as_ref().map(name);
        let other = other.unwrap_or("a rigid obstacle".to_string());
        let caption = format!(
            "{} against {other}. Pressure is positive in compression, the gap is that after deformation. Arrows: pressure on {}.{}",
            name(&contact.nonmortar),
            bodies[contact.nonmortar.body.0].name,
            stretch.in_words(&Labels::of(scene.model)),
        );
        let title = format!(
            "Contact pressure and gap along the interface {}",
            contact.name
        );
        let id = format!("interface{index}");
        let draw = |width| interface_figure(scene, contact, &stretch, law, (&id, width));
        fitted(&draw, &title, &caption)
    }
}

/// The deformed shape after some of the load steps, all in one window and with the same colours; empty with a single step.
pub fn course<const D: usize>(run: &Overview<'_, D>) -> Markup {
    let steps: Vec<&Solution<D>> = run.steps().collect();
    if steps.len() < 2 {
        return Markup::default();
    }
    let shown = spread(steps.len(), film::MOST);
    let pairs = shown
        .iter()
        .map(|&step| (run.stages[step].as_ref(), steps[step]));
    let pairs: Vec<(&Model<D>, &Solution<D>)> = pairs.collect();
    let (drawings, magnified) = match (of_dimension(&pairs), of_dimension(&pairs)) {
        (Some(plane), _) => known(run.model).map(|whole| deformed_course(whole, &plane)),
        (_, Some(space)) => known(run.model).map(|whole| space::deformed_course(whole, &space)),
        _ => None,
    }
    .unwrap_or_default();
    let name = |step: usize| {
        let own = run
            .step_name(step)
            .map_or(String::new(), |name| format!(": {name}"));
        format!("{}, t = {}{own}", step + 1, number(steps[step].time))
    };
    let frames = shown
        .iter()
        .zip(drawings)
        .map(|(&step, drawing)| film::Frame {
            name: name(step),
            drawing,
        });
    let some = match shown.len() < steps.len() {
        true => format!(" {} of {} load steps.", shown.len(), count(steps.len())),
        false => String::new(),
    };
    let caption = format!(
        "Displacements are magnified {magnified} in all pictures, and the colours of the von Mises stress are the same.{some}"
    );
    let title = "Deformed shape over the load steps";
    film::film(
        &format!("film-{}", run.stem),
        &frames.collect::<Vec<_>>(),
        title,
        &caption,
    )
}

/// Stages and solutions as those of the plane or of space, if they are.
fn of_dimension<'a, const D: usize, const E: usize>(
    pairs: &[(&'a Model<D>, &'a Solution<D>)],
) -> Option<Vec<(&'a Model<E>, &'a Solution<E>)>> {
    let each = pairs
        .iter()
        .map(|(model, solution)| Some((known(*model)?, known(*solution)?)));
    each.collect()
}

fn mesh_caption(model: &Model<2>) -> String {
    let cells: usize = model.bodies.iter().map(|body| body.mesh.cell_count()).sum();
    let nodes: usize = model.bodies.iter().map(|b| b.mesh.points().len()).sum();
    format!(
        "{} cells, {} nodes. Cells narrower than two pixels are drawn without their edges. Arrows of one load are to scale among \
         themselves.",
        count(cells),
        count(nodes)
    )
}
