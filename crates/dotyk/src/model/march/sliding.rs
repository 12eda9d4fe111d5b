//! Loss of equilibrium: a load that no friction can hold is an answer, which names body, motion and load factor.
//!
//! The load is infeasible: no forces within the friction cones balance it. If unlimited friction could, the body slides; if
//! not, it tips about a contact that stays closed, somewhere between the load of the step before and that of this one; else, and without
//! any friction, the load pulls it away from everything that could hold it: an error of the model. A body may also slide under a feasible load,
//! where the normal forces that would bear it are not those that follow from elasticity.

use crate::dual::{AdmissibleSet, Feasibility};
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::model::{Law, Model};
use crate::model::system::bodies::LoadedBody;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::Condition;
use crate::model::system::floating::Floating;

/// A change of load counts as not held if at most this part of it is held.
const NOT_HELD: f64 = 1e-6;

/// The objection to a load that is infeasible along `direction` (r,), of which friction holds the part `factor`; `step` are the
/// times of the step before and of this one, and e of the one before.
///
/// Errors: the body that is not held.
pub(crate) fn sliding<const D: usize>(
    model: &Model<D>,
    (floating, bodies, conditions): (&Floating, &[LoadedBody<D>], &[Condition<D>]),
    admissible: &AdmissibleSet,
    (direction, factor): (&[f64], Option<f64>),
    step: Option<([f64; 2], &[f64])>,
) -> Result<Objection<D>, Error<D>> {
    let balance = &floating.balance;
    let of_step = step.map(|(times, before)| {
        let part = Feasibility::fraction(admissible, balance, before);
        (part, times)
    });
    let leans = || Feasibility::leans(admissible, balance, direction);
    let of_step = of_step.filter(|(part, _)| factor.is_some() || *part > NOT_HELD && leans());
    let held = of_step.map(|(part, _)| part).or(factor);
    let Some(held) = held.filter(|_| admissible.has_friction() || factor.is_some()) else {
        let mut error = floating.pulled_away(model, (bodies, conditions), admissible, direction);
        if let (Error::PulledAway { until, .. }, Some((part, [before, now]))) =
            (&mut error, of_step)
        {
            *until = Some(before + part * (now - before));
        }
        return Err(error);
    };
    let (bodies, motion) = floating.motion(model, bodies, direction);
    Ok(Objection::Slides {
        bodies,
        motion,
        by: factor.map(|_| gives_way(model)),
        held,
        step: of_step.map(|(_, times)| times),
    })
}

/// The resistance that may be exhausted where a load is not held.
fn gives_way<const D: usize>(model: &Model<D>) -> &'static str {
    let smooth = |law: &Law| matches!(law, Law::Frictionless | Law::Tied);
    let friction = !model.contacts.iter().all(|contact| smooth(&contact.law));
    let mut members = model.members.iter();
    match members.find_map(|member| member.kind.pull().exhausted()) {
        None => "friction",
        Some([alone, beside]) => match friction {
            false => alone,
            true => beside,
        },
    }
}

/// The objection to a load along `direction` (r,) of which friction, with the normal forces that follow from elasticity, bears the
/// part `factor`.
pub(crate) fn slides_along<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    direction: &[f64],
    factor: f64,
) -> Objection<D> {
    let (floating, bodies) = (&condensed.floating, &condensed.bodies[..]);
    let (bodies, motion) = floating.motion(model, bodies, direction);
    let work = |load: &[f64]| -> f64 { load.iter().zip(direction).map(|(e, z)| e * z).sum() };
    // of the change of load in the step, if it is this change that is too much
    let of_step = condensed.state.load.as_ref().and_then(|(time, load)| {
        let (before, now) = (work(load), work(condensed.problem.balance.load()));
        let held = (factor * now - before) / (now - before);
        (0.0..=1.0)
            .contains(&held)
            .then_some((held, [*time, condensed.time]))
    });
    let (held, step) = of_step.map_or((factor, None), |(held, step)| (held, Some(step)));
    Objection::Slides {
        bodies,
        motion,
        by: Some(gives_way(model)),
        held,
        step,
    }
}
