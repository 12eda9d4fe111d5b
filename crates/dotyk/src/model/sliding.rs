//! Loss of equilibrium: a load that no friction can hold is an answer, which names body, motion and load factor.
//!
//! The load is infeasible: no forces within the friction cones balance it. If unlimited friction could, the body slides;
//! if not, it is pulled away from everything that could hold it, which is an error of the model. The load may be feasible and
//! slide all the same, where the normal forces that would bear it are not those that elasticity gives.

use crate::dual::{AdmissibleSet, Feasibility};
use crate::model::bodies::LoadedBody;
use crate::model::condense::Condensed;
use crate::model::error::{Error, Objection};
use crate::model::floating::Floating;
use crate::model::nouns::{Law, Model};

/// What slides under a load that is infeasible along `direction` (r,), of which friction holds the part `factor`; `step` are
/// the times of the step before and of this one, e of the one before, and the admissible set.
///
/// Errors: the body that no friction could hold.
pub(crate) fn sliding<const D: usize>(
    model: &Model<D>,
    (floating, bodies): (&Floating, &[LoadedBody<D>]),
    (direction, factor): (&[f64], Option<f64>),
    step: Option<([f64; 2], &[f64], &AdmissibleSet)>,
) -> Result<Objection<D>, Error<D>> {
    let Some(factor) = factor else {
        return Err(floating.pulled_away(model, bodies, direction));
    };
    let (body, motion) = floating.motion(model, bodies, direction);
    let part = |(_, before, admissible): (_, &[f64], &AdmissibleSet)| {
        Feasibility::fraction(admissible, &floating.balance, before)
    };
    Ok(Objection::Slides {
        body,
        motion,
        by: gives_way(model),
        held: step.map_or(factor, part),
        step: step.map(|(times, ..)| times),
    })
}

/// What may be exhausted where a load is not held.
fn gives_way<const D: usize>(model: &Model<D>) -> &'static str {
    let smooth = |law: &Law| matches!(law, Law::Frictionless | Law::Tied);
    let friction = !model.contacts.iter().all(|contact| smooth(&contact.law));
    let yields = model.bars.iter().any(|bar| bar.yields.is_some());
    match (friction, yields) {
        (_, false) => "friction",
        (false, true) => "the strength of the bars",
        (true, true) => "friction, with the strength of the bars,",
    }
}

/// What slides along `direction` (r,) under a load of which friction, with the normal forces that elasticity gives, bears the
/// part `factor`.
pub(crate) fn slides_along<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    direction: &[f64],
    factor: f64,
) -> Objection<D> {
    let (floating, bodies) = (&condensed.floating, &condensed.bodies[..]);
    let (body, motion) = floating.motion(model, bodies, direction);
    let work = |load: &[f64]| -> f64 { load.iter().zip(direction).map(|(e, z)| e * z).sum() };
    // of the change of load in the step, if it is this change that is too much
    let of_step = condensed.before.as_ref().and_then(|(time, load)| {
        let (before, now) = (work(load), work(condensed.problem.balance.load()));
        let held = (factor * now - before) / (now - before);
        (0.0..=1.0)
            .contains(&held)
            .then_some((held, [*time, condensed.time]))
    });
    let (held, step) = of_step.map_or((factor, None), |(held, step)| (held, Some(step)));
    Objection::Slides {
        body,
        motion,
        by: gives_way(model),
        held,
        step,
    }
}
