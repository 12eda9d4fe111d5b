//! One factorisation for models that differ in loads, friction and prescribed values alone.

use crate::geometry::Field;
use crate::model::nouns::model::{
    Body, Contact, Couple, Elastic, Gap, Law, Model, Motion, Obstacle, Pair, Rigid, Support,
};
use crate::model::read::view::View;
use crate::model::system::condense::Condensed;

/// What a solved model leaves for the next one: its bodies condensed onto the contact. A model of the same stiffness takes it
/// up, any other one replaces it.
#[derive(Default)]
pub struct Reuse<const D: usize> {
    pub(crate) kept: Option<(Model<D>, Condensed<D>, View<D>)>,
}

impl<const D: usize> Reuse<D> {
    /// What is kept for a model; gone if it is of no use to it.
    pub(crate) fn take(&mut self, model: &Model<D>) -> Option<(Condensed<D>, View<D>)> {
        let kept = self.kept.take();
        let (_, condensed, view) = kept.filter(|(kept, ..)| kept.has_stiffness_of(model))?;
        Some((condensed, view))
    }
}

impl<const D: usize> Model<D> {
    /// Whether stiffness, pairs and compliance are those of another model: all but loads, friction, prescribed values, steps,
    /// solver and probes is the same.
    pub fn has_stiffness_of(&self, other: &Self) -> bool {
        let mut bodies = self.bodies.iter().zip(&other.bodies);
        let mut contacts = self.contacts.iter().zip(&other.contacts);
        let counts = |model: &Self| (model.bodies.len(), model.contacts.len());
        self.analysis == other.analysis
            && counts(self) == counts(other)
            && self.bars == other.bars
            && bodies.all(|(a, b)| same_body(a, b))
            && contacts.all(|(a, b)| same_contact(a, b))
    }
}

fn same_body<const D: usize>(a: &Body<D>, b: &Body<D>) -> bool {
    let holds = |a: &Support<D>, b: &Support<D>| {
        let components = a.components.iter().zip(&b.components);
        (&a.place, a.active) == (&b.place, b.active)
            && a.normal.is_some() == b.normal.is_some()
            && components
                .into_iter()
                .all(|(a, b)| a.is_some() == b.is_some())
    };
    let stiffness = |body: &Body<D>| -> Vec<(Option<String>, Elastic)> {
        let materials = body.materials.iter();
        materials.map(|m| (m.group.clone(), m.elastic)).collect()
    };
    (&a.name, stiffness(a), a.thickness, a.formulation)
        == (&b.name, stiffness(b), b.thickness, b.formulation)
        && a.couples.len() == b.couples.len()
        && a.couples
            .iter()
            .zip(&b.couples)
            .all(|(a, b)| same_couple(a, b))
        && a.surfaces == b.surfaces
        && a.springs == b.springs
        && a.supports.len() == b.supports.len()
        && a.supports.iter().zip(&b.supports).all(|(a, b)| holds(a, b))
        && a.mesh == b.mesh
}

fn same_couple<const D: usize>(a: &Couple<D>, b: &Couple<D>) -> bool {
    let held = |couple: &Couple<D>| {
        let all = couple.displacement.iter().chain(&couple.rotation);
        all.map(Option::is_some).collect::<Vec<_>>()
    };
    (&a.name, a.point, &a.side, a.kind) == (&b.name, b.point, &b.side, b.kind) && held(a) == held(b)
}

fn same_contact<const D: usize>(a: &Contact<D>, b: &Contact<D>) -> bool {
    let pairs = match (&a.pair, &b.pair) {
        (Pair::Automatic(a), Pair::Automatic(b)) => a == b,
        (
            Pair::Given { nonmortar, mortar },
            Pair::Given {
                nonmortar: n,
                mortar: m,
            },
        ) => (nonmortar, mortar) == (n, m),
        (
            Pair::Obstacle {
                nonmortar,
                obstacle,
            },
            Pair::Obstacle {
                nonmortar: n,
                obstacle: o,
            },
        ) => nonmortar == n && same_obstacle(obstacle, o),
        _ => false,
    };
    let gaps = match (&a.gap, &b.gap) {
        (None, None) => true,
        (Some(Gap::Geometric), Some(Gap::Geometric)) => true,
        (Some(Gap::Closed), Some(Gap::Closed)) => true,
        (Some(Gap::Given(a)), Some(Gap::Given(b))) => same_field(a, b),
        _ => false,
    };
    let [same_name, same_nodes] = [
        (&a.name, a.pairing) == (&b.name, b.pairing),
        (&a.exclude, &a.friction_exclude) == (&b.exclude, &b.friction_exclude),
    ];
    same_name && same_nodes && pairs && gaps && rows(&a.law) == rows(&b.law)
}

fn same_obstacle<const D: usize>(a: &Obstacle<D>, b: &Obstacle<D>) -> bool {
    let shapes = match (&a.shape, &b.shape) {
        (Rigid::Gap(a), Rigid::Gap(b)) => same_field(a, b),
        (
            Rigid::Surface { surface, inside },
            Rigid::Surface {
                surface: s,
                inside: i,
            },
        ) => (surface, inside) == (s, i),
        _ => false,
    };
    let motions = match (&a.motion, &b.motion) {
        (Motion::Prescribed(a), Motion::Prescribed(b)) => {
            a.iter().zip(b).all(|(a, b)| same_field(a, b))
        }
        (Motion::Loaded(_), Motion::Loaded(_)) => true,
        _ => false,
    };
    shapes && motions
}

/// What varies is taken anew at every time; of what does not, equal values may have been taken for one condition.
fn same_field(a: &Field, b: &Field) -> bool {
    a.as_constant() == b.as_constant()
}

/// What a law makes of the rows of a node: one, or one for each tangent, too, borne by all or by what is closed.
fn rows(law: &Law) -> u8 {
    match law {
        Law::Frictionless => 0,
        Law::Tied => 1,
        _ => 2,
    }
}
