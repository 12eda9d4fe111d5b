//! Loss of equilibrium: a load that no friction can hold is an answer, which names body, motion and load factor.
//!
//! The load is infeasible: no forces within the friction cones balance it. If unlimited friction could, the body slides;
//! if not, it is pulled away from everything that could hold it, which is an error of the model.

use crate::dual::{AdmissibleSet, Feasibility};
use crate::model::bodies::{LoadedBody, largest_load};
use crate::model::error::Objection;
use crate::model::floating::Floating;
use crate::model::nouns::Model;

/// What slides; `step` is the time of the step before, that of this one, and e of the one before.
pub(crate) fn sliding<const D: usize>(
    model: &Model<D>,
    admissible: &AdmissibleSet,
    floating: &Floating,
    bodies: &[LoadedBody<D>],
    step: Option<([f64; 2], &[f64])>,
) -> Option<Objection<D>> {
    if !admissible.has_friction() {
        return None;
    }
    let equilibrium = &floating.equilibrium;
    let force = largest_load(bodies);
    let rough = Feasibility::of(&admissible.sticking(), equilibrium, force);
    match (rough, Feasibility::of(admissible, equilibrium, force)) {
        (Feasibility::Feasible { .. }, Feasibility::Infeasible { direction, factor }) => {
            let (body, motion) = floating.motion(model, bodies, &direction);
            let part = |(_, load)| Feasibility::fraction(admissible, equilibrium, load);
            Some(Objection::Slides {
                body,
                motion,
                held: step.map_or(factor, part),
                step: step.map(|(times, _)| times),
            })
        }
        _ => None,
    }
}
