//! Building a model in Rust: every method returns the object for the next line.

use crate::geometry::{Field, Point};
use crate::mesh::Mesh;
use crate::model::nouns::formula::Formula;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::*;
use crate::model::nouns::quantity::{Quantity, QuantityError};
use crate::model::nouns::section::{Section, Stations};
use std::sync::Arc;

impl<const D: usize> Default for Model<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const D: usize> Model<D> {
    /// An empty model: plane strain in 2D.
    pub fn new() -> Self {
        Self {
            title: String::new(),
            source: String::new(),
            analysis: if D == 3 {
                Analysis::Solid
            } else {
                Analysis::PlaneStrain
            },
            units: Units::default(),
            bodies: Vec::new(),
            contacts: Vec::new(),
            members: Vec::new(),
            sections: Vec::new(),
            solver: SolverOptions::default(),
            probes: Vec::new(),
            times: vec![1.0],
            step_names: Vec::new(),
            zeroed: Vec::new(),
            parameters: Vec::new(),
        }
    }

    /// Adds a body of one material.
    pub fn body(&mut self, name: &str, mesh: impl Into<Arc<Mesh<D>>>, elastic: Elastic) -> BodyId {
        let material = Material {
            group: None,
            elastic,
            strength: None,
            plastic: None,
            ages: None,
        };
        self.bodies.push(Body {
            materials: vec![material],
            ..Body::of(name, mesh.into())
        });
        BodyId(self.bodies.len() - 1)
    }

    /// Holds components of a side; `None` leaves one free.
    pub fn fix(&mut self, body: BodyId, side: &str, components: [Option<f64>; D]) -> &mut Self {
        self.support(
            body,
            Place::Side(side.to_string()),
            components.map(|c| c.map(Field::constant)),
            None,
        )
    }

    /// Holds components of the node nearest to a point.
    pub fn pin(
        &mut self,
        body: BodyId,
        point: [f64; D],
        components: [Option<f64>; D],
    ) -> &mut Self {
        self.support(
            body,
            Place::Point(point),
            components.map(|c| c.map(Field::constant)),
            None,
        )
    }

    /// A roller: prescribed displacement along the outward normal of a side.
    pub fn roller(&mut self, body: BodyId, side: &str, displacement: f64) -> &mut Self {
        let free = std::array::from_fn(|_| None);
        self.support(
            body,
            Place::Side(side.to_string()),
            free,
            Some(Field::constant(displacement)),
        )
    }

    fn support(
        &mut self,
        body: BodyId,
        place: Place<D>,
        components: [Option<Field>; D],
        normal: Option<Field>,
    ) -> &mut Self {
        self.bodies[body.0].supports.push(Support {
            place,
            components,
            normal,
            active: Default::default(),
        });
        self
    }

    /// A point with which a side moves, and which the returned couple holds and loads; it need not lie on the mesh.
    pub fn couple(
        &mut self,
        body: BodyId,
        side: &str,
        (name, point): (&str, Point<D>),
        kind: CoupleKind,
    ) -> &mut Couple<D> {
        let couples = &mut self.bodies[body.0].couples;
        couples.push(Couple::new(name, point, side, kind));
        let last = couples.len() - 1;
        &mut couples[last]
    }

    /// A traction in global axes on a side.
    pub fn pull(&mut self, body: BodyId, side: &str, traction: [f64; D]) -> &mut Self {
        self.load(
            body,
            Load::Traction {
                side: side.to_string(),
                traction: traction.map(Field::constant),
            },
        )
    }

    /// A pressure on a side; positive pushes into the body.
    pub fn press(&mut self, body: BodyId, side: &str, pressure: f64) -> &mut Self {
        self.load(
            body,
            Load::Pressure {
                side: side.to_string(),
                pressure: Field::constant(pressure),
            },
        )
    }

    /// The remaining part, on a side, of the traction of the body's initial stress: 1 is untouched ground, 0 is excavated. The
    /// body must already have an initial stress.
    pub fn in_situ(&mut self, body: BodyId, side: &str, factor: impl Into<Field>) -> &mut Self {
        let stress = self.bodies[body.0].initial.stress.clone();
        let none = || Components::isotropic(Field::constant(0.0));
        self.load(
            body,
            Load::InSitu {
                side: side.to_string(),
                factor: factor.into(),
                stress: stress.unwrap_or_else(none).into(),
            },
        )
    }

    /// Any load.
    pub fn load(&mut self, body: BodyId, load: Load<D>) -> &mut Self {
        self.bodies[body.0].loads.push(load);
        self
    }

    /// A frictionless unilateral contact between a nonmortar and a mortar side, named `contact_1`, `contact_2`, ...
    pub fn contact(
        &mut self,
        nonmortar: (BodyId, &str),
        mortar: (BodyId, &str),
    ) -> &mut Contact<D> {
        let side = |(body, side): (BodyId, &str)| SideRef {
            body,
            side: side.to_string(),
        };
        self.contacts.push(Contact {
            name: format!("contact_{}", self.contacts.len() + 1),
            pair: Pair::Given {
                nonmortar: side(nonmortar),
                mortar: side(mortar),
            },
            pairing: None,
            gap: None,
            law: Law::Frictionless,
            exclude: Vec::new(),
            gasket: None,
            reach: None,
            friction_exclude: Vec::new(),
            active: Active::ALWAYS,
        });
        let last = self.contacts.len() - 1;
        &mut self.contacts[last]
    }

    /// The section forces N, V, M of a body between two of its sides, at stations of its middle line, the first side on the left.
    pub fn section(
        &mut self,
        name: &str,
        body: BodyId,
        sides: [&str; 2],
        stations: Stations<D>,
    ) -> &mut Section<D> {
        let sides = sides.map(|side| {
            let side = side.to_string();
            vec![SideRef { body, side }]
        });
        self.section_of(name, vec![body], sides, stations)
    }

    /// The same for several bodies, each long side a path along some of them.
    pub fn section_of(
        &mut self,
        name: &str,
        bodies: Vec<BodyId>,
        sides: [Vec<SideRef>; 2],
        stations: Stations<D>,
    ) -> &mut Section<D> {
        self.sections.push(Section {
            name: name.to_string(),
            bodies,
            sides,
            stations,
            axis: None,
            places: 1,
            capacity: None,
        });
        let last = self.sections.len() - 1;
        &mut self.sections[last]
    }

    /// Reads a quantity off the solution, such as `gamma.pressure`: name of the probe, quantity, and place.
    ///
    /// Errors: the wrong word, and the words known in its place.
    pub fn probe(
        &mut self,
        name: &str,
        quantity: &str,
        reading: Reading<D>,
    ) -> Result<&mut Probe<D>, QuantityError> {
        let contacts = self.contacts.iter().map(|contact| contact.name.as_str());
        let contacts: Vec<&str> = contacts.collect();
        let sections = self.sections.iter().map(|section| section.name.as_str());
        let sections: Vec<&str> = sections.collect();
        let named = [&contacts[..], &sections];
        let quantity = Quantity::parse(quantity, &self.bodies, named, &self.members)?;
        self.probes.push(Probe::new(name, quantity, reading));
        let last = self.probes.len() - 1;
        Ok(&mut self.probes[last])
    }

    /// Reads a number of the values of other probes, whatever the order of the probes.
    pub fn probe_of(&mut self, name: &str, formula: Formula) -> &mut Probe<D> {
        self.probes.push(Probe::new(
            name,
            Quantity::of_formula(formula),
            Reading::Whole,
        ));
        let last = self.probes.len() - 1;
        &mut self.probes[last]
    }

    /// A frictionless unilateral contact of a side with a fixed rigid obstacle at a distance along its normal.
    pub fn obstacle(&mut self, nonmortar: (BodyId, &str), gap: Field) -> &mut Contact<D> {
        let contact = self.contact(nonmortar, nonmortar);
        if let Pair::Given { nonmortar, .. } = &contact.pair {
            let obstacle = Obstacle {
                shape: Rigid::Gap(gap),
                motion: Motion::Prescribed(std::array::from_fn(|_| Field::constant(0.0))),
            };
            contact.pair = Pair::Obstacle {
                nonmortar: nonmortar.clone(),
                obstacle,
            };
        }
        contact
    }
}
