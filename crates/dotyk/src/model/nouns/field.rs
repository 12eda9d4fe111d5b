//! Results of bodies that have a value everywhere, as one list: files, probes and Python go through it. A further one is an entry here
//! and a member of `BodySolution`, which `read/fields.rs` fills.

use crate::geometry::padded;
use crate::model::nouns::dimension::Dimension;
use crate::model::nouns::solution::BodySolution;

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

/// A result of a body that has a value everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyField {
    /// Its name, in all files, of probes and in Python.
    pub name: &'static str,
    /// Its components.
    pub shape: Shape,
    /// What it is.
    pub dimension: Dimension,
    /// Values at every node, and at the further places of the body's `borders`, with all components of a place together.
    pub values: Vec<f64>,
}

/// An entry of the list.
pub(crate) struct FieldKind<const D: usize> {
    pub name: &'static str,
    pub shape: Shape,
    pub dimension: Dimension,
    /// Whether probes read it as its values at nodes say; others have a reading of their own.
    pub plain: bool,
    /// Of what yields alone.
    pub plastic: bool,
    /// Its values in a solution; `None` where that has none.
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
            plain: true,
            plastic: false,
            values,
        }
    }

    /// Probes have a reading of their own of it, or none.
    const fn apart(mut self) -> Self {
        self.plain = false;
        self
    }

    const fn of_metal(mut self) -> Self {
        self.plastic = true;
        self
    }
}

impl<const D: usize> BodySolution<D> {
    /// All results that have a value at every node, and at the further places of `borders`.
    pub fn fields(&self) -> Vec<BodyField> {
        let field = |kind: &FieldKind<D>| {
            Some(BodyField {
                name: kind.name,
                shape: kind.shape,
                dimension: kind.dimension,
                values: (kind.values)(self)?,
            })
        };
        FieldKind::ALL.iter().filter_map(field).collect()
    }
}
