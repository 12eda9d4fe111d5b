//! The same model with other cells.
//!
//! Sides, groups of cells and their materials are found by their names, and points by their places: points of supports, springs,
//! loads and excluded nodes are nodes of the new mesh where they lie on lines of an outline or drawing; elsewhere the nearest node
//! counts, as always.

use crate::fem::{Formulation, has_modes};
use crate::geometry::Point;
use crate::mesh::SizeField;
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::BodyId;
use crate::model::nouns::model::{Model, Place};

impl<const D: usize> Model<D> {
    /// The model with some bodies meshed anew: their cells are no larger than their recipe and these fields want
    /// ([`Recipe`](crate::mesh::Recipe)).
    ///
    /// Bodies of regions of one drawing are meshed together, by the smaller of their fields. Where quadrilaterals become triangles,
    /// the enhanced formulation, which these do not have, is left out.
    ///
    /// Errors, each naming the body: a mesh that comes from a file or a program; a side of which only its facets are known; too many
    /// nodes.
    pub fn meshed_anew(&self, sizes: &[(BodyId, SizeField<D>)]) -> Result<Self, Error<D>> {
        let mut model = self.clone();
        for (index, body) in model.bodies.iter_mut().enumerate() {
            let recipe = self.bodies[index].mesh.recipe();
            let together = |other: usize| {
                other == index || recipe.shares_drawing(self.bodies[other].mesh.recipe())
            };
            let fields = sizes.iter().filter(|(id, _)| together(id.0));
            let fields = fields.map(|(_, field)| field.clone());
            let Some(sizes) = fields.reduce(|a, b| a.and(&b)) else {
                continue;
            };
            let bodies = (0..self.bodies.len()).filter(|&other| together(other));
            let nodes: Vec<Point<D>> = bodies.flat_map(|other| self.points_of(other)).collect();
            let mesh = recipe.mesh(&sizes, &nodes);
            let mesh = mesh.map_err(|source| Error::Mesh {
                body: body.name.clone(),
                source,
            })?;
            if !mesh.blocks().iter().any(|block| has_modes(block.kind)) {
                body.formulation = Formulation::Displacement;
            }
            body.mesh = mesh.into();
        }
        Ok(model)
    }

    /// The points at which a body is held, loaded or left out of a contact, and the ends of its patches.
    fn points_of(&self, index: usize) -> Vec<Point<D>> {
        let body = &self.bodies[index];
        let excluded = self.contacts.iter().flat_map(|contact| {
            let excluded = [&contact.exclude, &contact.friction_exclude];
            let own = contact.pair.sides().iter().any(|side| side.body.0 == index);
            excluded.into_iter().flatten().filter(move |_| own).cloned()
        });
        let loads = body.loads.iter().map(|load| load.place());
        let places = body.held_places().chain(loads).chain(excluded);
        let points = places.filter_map(|place| match place {
            Place::Point(point) => Some(point),
            Place::Side(_) => None,
        });
        points.chain(body.mesh.recipe().ends()).collect()
    }
}
