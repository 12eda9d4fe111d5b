//! The drawings of a page, in the plane and in space.
//!
//! Pages are written for any dimension and get their drawings here; a missing drawing is an empty text.

use crate::geometry::{Point, padded};
use crate::model::{Model, SideRef, Solution};
use crate::output::deformed::deformed_figure;
use crate::output::html::figure;
use crate::output::interface::interface_figure;
use crate::output::markup::Markup;
use crate::output::picture::Picture;
use crate::output::scene::Scene;
use crate::output::setup::setup_figure;
use crate::output::space;
use crate::output::text::count;
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
        let drawing = setup_figure(scene, &alone);
        figure(
            &drawing,
            "Mesh, supports and loads",
            &mesh_caption(scene.model),
        )
    }

    /// The deformed shape, coloured by stress; in space a view that turns and a section, too.
    pub fn deformed<const D: usize>(&self, solution: &Solution<D>) -> Markup {
        if let (Some(scene), Some(solution)) = (&self.space, known(solution)) {
            return space::stress_figures(scene, solution);
        }
        let (Some(scene), Some(solution)) = (&self.plane, known(solution)) else {
            return Markup::default();
        };
        let (drawing, caption) = deformed_figure(scene, solution);
        let more = " Dashed: undeformed outline. Colour: von Mises stress, recovered at the nodes.";
        figure(&drawing, "Deformed shape", &format!("{caption}{more}"))
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
        let drawing = picture.in_plane(scene, solution);
        figure(&drawing, picture.title, &picture.caption)
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
        let Some(drawing) = interface_figure(scene, contact, law, &format!("interface{index}"))
        else {
            return Markup::default();
        };
        let bodies = &scene.model.bodies;
        let name = |side: &SideRef| format!("{}.{}", bodies[side.body.0].name, side.side);
        let other = contact.mortar.as_ref().map(name);
        let other = other.unwrap_or("a rigid obstacle".to_string());
        let caption = format!(
            "{} against {other}. Pressure is positive in compression, the gap is that after deformation. Arrows: pressure on {}.",
            name(&contact.nonmortar),
            bodies[contact.nonmortar.body.0].name,
        );
        let title = format!(
            "Contact pressure and gap along the interface {}",
            contact.name
        );
        figure(&drawing, &title, &caption)
    }
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
