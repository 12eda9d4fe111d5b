//! Loss of equilibrium: a load that no friction can hold is an answer, which names body, motion and load factor.
//!
//! The load is infeasible: no forces within the friction cones balance it. If unlimited friction could, the body slides;
//! if not, it is pulled away from everything that could hold it, which is an error of the model.

use crate::dual::{AdmissibleSet, Block, Feasibility, Multipliers};
use crate::fem::Short;
use crate::model::condense::LoadedBody;
use crate::model::floating::Floating;
use crate::model::nouns::Model;
use crate::model::pipeline::{Condensed, largest_load};

/// A coefficient of friction beyond all that hold anything.
const UNLIMITED: f64 = 1e6;

impl<const D: usize> Model<D> {
    /// What slides under the loads of a step, in words; `None` where friction has no part in it.
    pub(crate) fn sliding(&self, condensed: &Condensed<D>) -> Option<String> {
        let step = condensed
            .before
            .as_ref()
            .map(|(time, load)| (*time, condensed.time, load.as_slice()));
        let admissible = &condensed.problem.admissible;
        sliding(
            self,
            admissible,
            &condensed.floating,
            &condensed.bodies,
            step,
        )
    }
}

impl<const D: usize> Model<D> {
    /// What an iteration that did not settle points at: the floating body that moved most, where there is friction.
    pub(crate) fn slipping_away(&self, condensed: &Condensed<D>, last: &Multipliers) -> String {
        let Condensed {
            problem,
            floating,
            bodies,
            ..
        } = condensed;
        if !problem.admissible.has_friction() || floating.modes.is_empty() {
            return String::new();
        }
        let (body, motion) = floating.motion(self, bodies, &last.alpha);
        format!(
            "; the load may be more than friction can hold: body \"{body}\" moved most ({motion}); smaller load steps show how far it holds"
        )
    }
}

/// What slides, in words; `step` is the time of the step before, that of this one, and e of the one before.
pub(crate) fn sliding<const D: usize>(
    model: &Model<D>,
    admissible: &AdmissibleSet,
    floating: &Floating,
    bodies: &[LoadedBody<D>],
    step: Option<(f64, f64, &[f64])>,
) -> Option<String> {
    let unlimited = |block: &Block| match *block {
        Block::Tresca { tangents, .. } | Block::Coulomb { tangents, .. } => Block::Coulomb {
            tangents,
            coefficient: UNLIMITED,
        },
        other => other,
    };
    let rough = AdmissibleSet::new(admissible.blocks().iter().map(unlimited).collect());
    if rough.blocks() == admissible.blocks() {
        return None;
    }
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
