//! The part of a step up to which friction holds the bodies, where it does not hold them at its end.
//!
//! The solver knows the load at the end of a step and the friction that would bear a part of it; with it change the normal forces, by
//! displacements that the solver does not know. So the part that it tells is tried: the step is solved at parts of it, loads and
//! prescribed displacements in proportion, from the state before. A part that is told right is confirmed by two of them, another one is
//! found by bisection.

use crate::model::march::attempt::{Start, run};
use crate::model::nouns::error::{Error, Objection};
use crate::model::nouns::model::Model;
use crate::model::system::condense::{Condensed, go_part};

/// Three digits of the part.
const NARROW: f64 = 1e-3;

/// Most parts that are tried.
const MOST: usize = 16;

/// Puts the part in the place of the one that the solver tells, where friction does not hold the bodies to the end. A part that is never
/// reached says nothing: then the solver is believed.
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
    let before = condensed.state.load.as_ref().map(|(time, _)| *time);
    // of the load, not of its change: not a part of this step
    if before.is_some() != step.is_some() {
        return Ok(());
    }
    let mut holds = |share: f64| -> Result<bool, Error<D>> {
        go_part(model, condensed, Some(share))?;
        Ok(run(model, condensed, from, &mut |_| {}).is_ok_and(|attempt| attempt.failure.is_none()))
    };
    let [mut low, mut high] = [0.0, 1.0];
    let mut next = [(1.0 - NARROW) * *held, (1.0 + NARROW) * *held].into_iter();
    for _ in 0..MOST {
        if high - low <= 2.5 * NARROW * high {
            break;
        }
        let told = next
            .next()
            .filter(|share| (low..high).contains(share) && *share > 0.0);
        let share = told.unwrap_or(0.5 * (low + high));
        match holds(share)? {
            true => low = share,
            false => high = share,
        }
    }
    go_part(model, condensed, None)?;
    let confirmed = low < *held && *held < high;
    if low > 0.0 && !confirmed {
        *held = low;
    }
    Ok(())
}
