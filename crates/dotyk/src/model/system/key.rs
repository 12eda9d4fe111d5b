//! Keys: the input of each layer of a linear problem, so that unchanged layers are reused.
//!
//! | Layer | Made of |
//! |---|---|
//! | stiffness of a body, its order and factor | the fields that [`same_stiffness`] compares |
//! | conditions between all parts, F | the stiffness of all bodies, and the fields that [`same_conditions`] compares |
//! | driving terms and laws | time and state: updated in every step |
//!
//! The nouns are destructured field by field, without `..`: a new field does not compile before it is in a key or among the
//! driving terms.

use crate::fem::{Elastic, Material, Spring, Support};
use crate::geometry::Field;
use crate::model::nouns::model::{
    Body, Contact, Couple, Gap, Model, Motion, Obstacle, Pair, Rigid,
};
use std::sync::Arc;

impl<const D: usize> Model<D> {
    /// Whether stiffness, pairs and compliance are those of another model: all but loads, friction, prescribed values, steps,
    /// solver and probes is the same.
    pub fn has_stiffness_of(&self, other: &Self) -> bool {
        same_conditions(self, other)
    }
}

/// Whether the conditions between the parts of two models are the same, but for their gaps and laws at a time.
pub(crate) fn same_conditions<const D: usize>(a: &Model<D>, b: &Model<D>) -> bool {
    let Model {
        analysis,
        bodies,
        contacts,
        members,
        // driving terms, solver, probes and names
        times: _,
        step_names: _,
        zeroed: _,
        solver: _,
        probes: _,
        sections: _,
        title: _,
        source: _,
        units: _,
        parameters: _,
    } = a;
    let body = |a: &Body<D>, b: &Body<D>| {
        (&a.name, &a.surfaces, &a.cyclic) == (&b.name, &b.surfaces, &b.cyclic)
            && all(&a.couples, &b.couples, same_couple)
            && same_stiffness(a, b)
    };
    *analysis == b.analysis
        && all(bodies, &b.bodies, body)
        && all(contacts, &b.contacts, same_contact)
        && *members == b.members
}

/// Whether two bodies under the same analysis have the same stiffness and are held in the same directions.
pub(crate) fn same_stiffness<const D: usize>(a: &Body<D>, b: &Body<D>) -> bool {
    let Body {
        mesh,
        materials,
        formulation,
        thickness,
        supports,
        springs,
        // fields of conditions
        name: _,
        couples: _,
        cyclic: _,
        surfaces: _,
        points: _,
        // what drives
        body_force: _,
        initial: _,
        active: _,
        release: _,
        loads: _,
    } = a;
    (formulation, thickness) == (&b.formulation, &b.thickness)
        && all(materials, &b.materials, same_elastic)
        && all(supports, &b.supports, same_directions)
        && all(springs, &b.springs, same_spring)
        && (Arc::ptr_eq(mesh, &b.mesh) || *mesh == b.mesh)
}

fn same_elastic(a: &Material, b: &Material) -> bool {
    let Material {
        group,
        elastic,
        // of a stage it is in its modulus
        ages: _,
        // strength and yielding, which only drive
        strength: _,
        plastic: _,
    } = a;
    let Elastic { young, poisson } = *elastic;
    (group, young, poisson) == (&b.group, b.elastic.young, b.elastic.poisson)
}

fn same_directions<const D: usize>(a: &Support<D>, b: &Support<D>) -> bool {
    let Support {
        place,
        components,
        normal,
        active,
    } = a;
    let held = |components: &[Option<Field>; D]| components.each_ref().map(Option::is_some);
    (place, active) == (&b.place, &b.active)
        && held(components) == held(&b.components)
        && normal.is_some() == b.normal.is_some()
}

fn same_spring<const D: usize>(a: &Spring<D>, b: &Spring<D>) -> bool {
    let Spring { bed, active } = a;
    (bed, active) == (&b.bed, &b.active)
}

fn same_couple<const D: usize>(a: &Couple<D>, b: &Couple<D>) -> bool {
    let Couple {
        name,
        point,
        side,
        kind,
        displacement,
        rotation,
        // what drives
        force: _,
        moment: _,
    } = a;
    let held = |moves: &[Option<Field>; D], turns: &[Option<Field>; 3]| {
        let held = |field: &Option<Field>| field.is_some();
        (moves.each_ref().map(held), turns.each_ref().map(held))
    };
    (name, point, side, kind) == (&b.name, &b.point, &b.side, &b.kind)
        && held(displacement, rotation) == held(&b.displacement, &b.rotation)
}

fn same_contact<const D: usize>(a: &Contact<D>, b: &Contact<D>) -> bool {
    let Contact {
        name,
        pair,
        pairing,
        gap,
        law,
        gasket,
        reach,
        exclude,
        friction_exclude,
        active,
    } = a;
    (name, pairing, reach, active) == (&b.name, &b.pairing, &b.reach, &b.active)
        && *gasket == b.gasket
        && (exclude, friction_exclude) == (&b.exclude, &b.friction_exclude)
        && same_pair(pair, &b.pair)
        && same_gap(gap.as_ref(), b.gap.as_ref())
        && law.coupling() == b.law.coupling()
}

fn same_pair<const D: usize>(a: &Pair<D>, b: &Pair<D>) -> bool {
    match (a, b) {
        (Pair::Automatic(a), Pair::Automatic(b)) => a == b,
        (Pair::Given { .. }, Pair::Given { .. }) => a.sides() == b.sides(),
        (Pair::Obstacle { obstacle, .. }, Pair::Obstacle { obstacle: o, .. }) => {
            a.sides() == b.sides() && same_obstacle(obstacle, o)
        }
        _ => false,
    }
}

fn same_gap(a: Option<&Gap>, b: Option<&Gap>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(Gap::Geometric), Some(Gap::Geometric)) => true,
        (Some(Gap::Closed), Some(Gap::Closed)) => true,
        (Some(Gap::Adjusted(a)), Some(Gap::Adjusted(b))) => a == b,
        (Some(Gap::Given(a)), Some(Gap::Given(b))) => same_field(a, b),
        _ => false,
    }
}

fn same_obstacle<const D: usize>(a: &Obstacle<D>, b: &Obstacle<D>) -> bool {
    let Obstacle { shape, motion } = a;
    let shapes = match (shape, &b.shape) {
        (Rigid::Gap(a), Rigid::Gap(b)) => same_field(a, b),
        (
            Rigid::Surface { surface, inside },
            Rigid::Surface {
                surface: s,
                inside: i,
            },
        ) => (surface, inside) == (s, i),
        (Rigid::Tool(a), Rigid::Tool(b)) => a == b,
        _ => false,
    };
    let motions = match (motion, &b.motion) {
        (Motion::Prescribed(a), Motion::Prescribed(b)) => {
            a.iter().zip(b).all(|(a, b)| same_field(a, b))
        }
        (Motion::Loaded(_), Motion::Loaded(_)) => true,
        _ => false,
    };
    shapes && motions
}

/// Varying fields are evaluated anew at every time; equal constant fields may have merged conditions.
fn same_field(a: &Field, b: &Field) -> bool {
    a.as_constant() == b.as_constant()
}

/// Lists of the same length whose elements are the same in pairs.
fn all<T>(a: &[T], b: &[T], same: impl Fn(&T, &T) -> bool) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
}
