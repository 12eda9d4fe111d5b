//! The part of a step up to which friction holds the bodies, where it does not hold them at its end.
//!
//! The solver knows the load at the end of a step and the friction that would bear a part of it; with it change the normal forces, by
//! displacements that the solver does not know. So the part that it tells is tried: the step is solved at parts of it, loads and
//! prescribed displacements in proportion, from the state before. A part that is told right is confirmed by two of them, another one is
//! found by bisection.

use crate::model::march::attempt::{Start, run};
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::model::{Body, Model};
use crate::model::system::condense::{Condensed, go_part};
use crate::model::system::condition::Condition;

/// Three digits of the part.
const NARROW: f64 = 1e-3;

/// The solver is believed if parts without an answer begin no further below what it tells: near the limit friction may not settle.
const UNKNOWN: f64 = 0.05;

/// Most parts that are tried.
const MOST: usize = 16;

/// Puts the part of the change of load in the place of the one that the solver tells, where friction does not hold the bodies to the end
/// of a step that follows another one. A part that is never reached says nothing: then the solver is believed.
///
/// Errors: those of the step itself.
pub(crate) fn hold_to<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    objection: Option<&mut Objection<D>>,
    from: Start<'_>,
) -> Result<(), Error<D>> {
    let Some(Objection::Slides {
        by: Some(_),
        held,
        step,
        ..
    }) = objection
    else {
        return Ok(());
    };
    // without a step before it is a part of the load along the motion, beside a weight that stays; what yields, is pressed out or parts
    // on the way to the end is not so at a part of it
    let lost = |condition: &Condition<D>| condition.touch.lost.contains(&true);
    let changes = |condition: &Condition<D>| condition.touch.filling.is_some() || lost(condition);
    if condensed.state.load.is_none()
        || step.is_none()
        || model.bodies.iter().any(Body::is_plastic)
        || condensed.conditions.iter().any(changes)
    {
        return Ok(());
    }
    // none where the solver finds out neither
    let mut holds = |share: f64| -> Result<Option<bool>, Error<D>> {
        go_part(model, condensed, Some(share))?;
        let tried = run(model, condensed, from, &mut |_| {});
        Ok(match tried.map(|attempt| attempt.failure) {
            Ok(None) => Some(true),
            Ok(Some(Objection::Slides { .. })) => Some(false),
            _ => None,
        })
    };
    // the largest part with an answer, the smallest one that slides, and the smallest one without an answer
    let [mut low, mut high, mut least] = [0.0, 1.0, 1.0];
    let mut next = [(1.0 - NARROW) * *held, (1.0 + NARROW) * *held].into_iter();
    for _ in 0..MOST {
        if least - low <= 2.5 * NARROW * least {
            break;
        }
        let inside = |share: &f64| (low..least).contains(share) && *share > 0.0;
        let share = next.next().filter(inside).unwrap_or(0.5 * (low + least));
        match holds(share)? {
            Some(true) => low = share,
            Some(false) => [high, least] = [share; 2],
            None => least = share,
        }
    }
    go_part(model, condensed, None)?;
    let possible = (low..=high).contains(held) && low >= (1.0 - UNKNOWN) * *held;
    if low > 0.0 && !possible {
        *held = low;
    }
    Ok(())
}
