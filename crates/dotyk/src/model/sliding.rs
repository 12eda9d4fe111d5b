//! Loss of equilibrium: a load that no friction can hold is an answer, which names body, motion and load factor.
//!
//! The load is infeasible: no forces within the friction cones balance it. If unlimited friction could, the body slides;
//! if not, it is pulled away from everything that could hold it, which is an error of the model.

use crate::dual::{AdmissibleSet, Feasibility};
use crate::fem::Short;
use crate::model::bodies::{LoadedBody, largest_load};
use crate::model::floating::Floating;
use crate::model::nouns::Model;

/// What slides, in words; `step` is the time of the step before, that of this one, and e of the one before.
pub(crate) fn sliding<const D: usize>(
    model: &Model<D>,
    admissible: &AdmissibleSet,
    floating: &Floating,
    bodies: &[LoadedBody<D>],
    step: Option<(f64, f64, &[f64])>,
) -> Option<String> {
    if !admissible.has_friction() {
        return None;
    }
    let rough = admissible.sticking();
    let equilibrium = &floating.equilibrium;
    let force = largest_load(bodies);
    let Feasibility::Infeasible { direction, factor } =
        Feasibility::of(admissible, equilibrium, force)
    else {
        return None;
    };
    if !matches!(
        Feasibility::of(&rough, equilibrium, force),
        Feasibility::Feasible { .. }
    ) {
        return None;
    }
    let (body, motion) = floating.motion(model, bodies, &direction);
    let when = match step {
        Some((before, now, load)) => {
            let part = Feasibility::fraction(admissible, equilibrium, load);
            let time = before + part * (now - before);
            format!(
                "friction holds it up to {} of the change of load from t = {before} to t = {now} (t = {})",
                Short(part),
                Short(time)
            )
        }
        None => format!(
            "friction holds {} of the load along this motion",
            Short(factor)
        ),
    };
    Some(format!(
        "loss of equilibrium: body \"{body}\" slides ({motion}); {when}"
    ))
}
