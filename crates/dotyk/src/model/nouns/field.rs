//! Results of bodies that have a value everywhere, as one list: files, probes, pictures and Python go through it. A further one is an
//! entry here and a member of `BodySolution`, which `read/fields.rs` fills.

use crate::fem::Body;
use crate::geometry::padded;
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::solution::{BodySolution, Solution, effective_stress};

/// How many components a field has, and which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// One.
    Number,
    /// Those of a vector, three.
    Vector,
    /// xx yy zz xy yz xz.
    Tensor,
    /// Principal values of a tensor, largest first.
    Principal,
}

impl Shape {
    /// Their number.
    pub fn components(self) -> usize {
        match self {
            Self::Number => 1,
            Self::Vector | Self::Principal => 3,
            Self::Tensor => 6,
        }
    }
}

/// What a field has its values of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum On {
    /// Every node, and the further places of the body's `borders`.
    Nodes,
    /// Every cell, in the order of the mesh, block by block.
    Cells,
}

/// The numbers at nodes that bodies of a solution have, in the order of files: what a picture may show.
pub(crate) fn numbers_at_nodes<const D: usize>(
    solution: &Solution<D>,
) -> Vec<&'static FieldKind<D>> {
    let shown = |kind: &&FieldKind<D>| {
        let has = |body| (kind.values)(body).is_some();
        (kind.shape, kind.on) == (Shape::Number, On::Nodes) && solution.bodies.iter().any(has)
    };
    FieldKind::ALL.iter().filter(shown).collect()
}

/// A result of a body that has a value everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyField {
    /// Its name, in all files, of probes and in Python.
    pub name: &'static str,
    /// Its components.
    pub shape: Shape,
    /// The dimension of its values.
    pub dimension: Dimension,
    /// What has a value.
    pub on: On,
    /// All components of a place or cell together.
    pub values: Vec<f64>,
}

/// What a body needs for a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Needs {
    /// A material that yields.
    Yielding,
    /// Water in its pores.
    Water,
}

impl Needs {
    /// Whether a body has it.
    pub fn met<const D: usize>(self, body: &Body<D>) -> bool {
        match self {
            Self::Yielding => body.is_plastic(),
            Self::Water => body.initial.pore.is_some(),
        }
    }
}

/// An entry of the list.
pub(crate) struct FieldKind<const D: usize> {
    pub name: &'static str,
    pub shape: Shape,
    pub dimension: Dimension,
    /// What it has values of.
    pub on: On,
    /// Whether probes read its nodal values directly; other fields have a reading of their own.
    pub plain: bool,
    /// What a body needs to have it; `None`: nothing.
    pub needs: Option<Needs>,
    /// Its values in a solution; `None` where the solution has no such values.
    pub values: fn(&BodySolution<D>) -> Option<Vec<f64>>,
}

/// Values of all nodes, at every place.
fn of_nodes<const D: usize>(own: &BodySolution<D>, values: &[[f64; D]]) -> Option<Vec<f64>> {
    let nodes = own.borders.nodes();
    Some(nodes.flat_map(|node| padded(values[node])).collect())
}

use {Dimension::*, Shape::*};

impl<const D: usize> FieldKind<D> {
    /// All of them, in the order of files.
    pub const ALL: &'static [Self] = &[
        Self::new("displacement", Vector, Length, |own| {
            of_nodes(own, &own.displacement)
        })
        .apart(),
        Self::new("stress", Tensor, Stress, |own| Some(own.stress.concat())).apart(),
        Self::new("strain", Tensor, Ratio, |own| Some(own.strain.concat())),
        Self::new("von_mises", Number, Stress, |own| {
            Some(own.von_mises.clone())
        })
        .apart(),
        Self::new("utilisation", Number, Ratio, |own| {
            own.utilisation.as_ref().map(|own| own.nodal.clone())
        })
        .apart(),
        Self::new("plastic_strain", Tensor, Ratio, |own| {
            own.yielding.as_ref().map(|own| own.strain.concat())
        })
        .of_metal(),
        Self::new("equivalent_plastic_strain", Number, Ratio, |own| {
            own.yielding.as_ref().map(|own| own.equivalent.clone())
        })
        .of_metal(),
        Self::new("yielded", Number, Ratio, |own| {
            own.yielding.as_ref().map(|own| own.share.clone())
        })
        .of_metal(),
        Self::new("yielded", Number, Ratio, |own| {
            own.yielding.as_ref().map(|own| own.cells.clone())
        })
        .of_metal()
        .of_cells(),
        Self::new("pore_pressure", Number, Stress, |own| {
            own.pore_pressure.clone()
        })
        .of_wet(),
        Self::new("effective_stress", Tensor, Stress, |own| {
            let water = own.pore_pressure.as_ref()?;
            Some(effective_stress(&own.stress, water).concat())
        })
        .of_wet(),
        Self::new("principal_stress", Principal, Stress, |own| {
            Some(own.principal_stress().concat())
        })
        .apart(),
        Self::new("reaction", Vector, Force, |own| {
            of_nodes(own, &own.reactions)
        })
        .apart(),
        Self::new("contact_force", Vector, Force, |own| {
            of_nodes(own, &own.contact_forces)
        })
        .apart(),
    ];

    /// Its name in words, for pictures.
    pub fn label(&self) -> String {
        match self.name {
            "von_mises" => "von Mises stress".to_string(),
            name => name.replace('_', " "),
        }
    }

    /// The field of cells that has this name.
    pub fn of_cells_named(name: &str) -> Option<&'static Self> {
        let mut cells = Self::ALL.iter().filter(|kind| kind.on == On::Cells);
        cells.find(|kind| kind.name == name)
    }

    const fn new(
        name: &'static str,
        shape: Shape,
        dimension: Dimension,
        values: fn(&BodySolution<D>) -> Option<Vec<f64>>,
    ) -> Self {
        Self {
            name,
            shape,
            dimension,
            on: On::Nodes,
            plain: true,
            needs: None,
            values,
        }
    }

    /// Probes read it in a way of their own, or not at all.
    const fn apart(mut self) -> Self {
        self.plain = false;
        self
    }

    const fn of_metal(mut self) -> Self {
        self.needs = Some(Needs::Yielding);
        self
    }

    const fn of_wet(mut self) -> Self {
        self.needs = Some(Needs::Water);
        self
    }

    /// Probes within a cell read its value, those at nodes what a field of the same name has there.
    const fn of_cells(mut self) -> Self {
        self.on = On::Cells;
        self.apart()
    }
}

impl<const D: usize> BodySolution<D> {
    /// Values of a number at every node, and at the further places of `borders`; NaN where there is none.
    pub(crate) fn at_nodes(&self, name: &str) -> Vec<f64> {
        let mut kinds = FieldKind::<D>::ALL.iter();
        let kind = kinds.find(|kind| (kind.name, kind.on) == (name, On::Nodes));
        let values = kind.and_then(|kind| (kind.values)(self));
        values.unwrap_or_else(|| vec![f64::NAN; self.borders.count()])
    }

    /// All results that have a value everywhere, in the order of files.
    pub fn fields(&self) -> Vec<BodyField> {
        let field = |kind: &FieldKind<D>| {
            Some(BodyField {
                name: kind.name,
                shape: kind.shape,
                dimension: kind.dimension,
                on: kind.on,
                values: (kind.values)(self)?,
            })
        };
        FieldKind::ALL.iter().filter_map(field).collect()
    }
}
