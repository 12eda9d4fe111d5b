//! The loop of equilibrium: forces, displacements, their plastic strain and parted joints, and forces again, until the certificate
//! holds.
//!
//! ```text
//!   solve ─▶ judge ─▶ increments, a finer tolerance (attempt.rs)
//!     ▲                 │  a joint that has parted on the way (torn.rs): without what it bore
//!     └─────────────────┤  plastic strain that displacements return to (flow.rs): with its load
//!                       ▼
//!                     answer
//! ```
//!
//! K, its factor, F and the pairs stay; only the driving terms change. A linear problem passes once.

use crate::model::march::attempt::{Attempt, Start, certified_attempt};
use crate::model::march::flow::Turns;
use crate::model::march::judge::Judged;
use crate::model::march::torn::torn;
use crate::model::nouns::error::Error;
use crate::model::nouns::event::Event;
use crate::model::nouns::model::Model;
use crate::model::system::condense::{Condensed, again};

/// An attempt, its judgement, and remarks on joints lost on the way.
pub(crate) type Found<const D: usize> = (Attempt<D>, Judged<D>, Vec<String>);

/// Solves until the certificate holds, all joints have a state, and the plastic strain is that of the displacements.
///
/// Errors: those of [`certified_attempt`].
pub(crate) fn equilibrate<const D: usize>(
    model: &Model<D>,
    condensed: &mut Condensed<D>,
    from: Start<'_>,
    observe: &mut dyn FnMut(Event),
) -> Result<Found<D>, Error<D>> {
    let mut turns = Turns::new(model, condensed)?;
    let mut parted = Vec::new();
    let (mut attempt, mut judged) = certified_attempt(model, condensed, from, observe)?;
    loop {
        let (goes_on, guess);
        if let Some(more) = torn(model, condensed, &attempt) {
            again(model, condensed, &more.lost, observe)?;
            parted.push(more.words);
            (goes_on, guess) = (true, None);
        } else {
            let known = (attempt, &judged, from);
            (attempt, goes_on) = turns.next(model, condensed, known, observe)?;
            guess = Some(attempt.outcome.multipliers.clone());
        }
        if !goes_on {
            break;
        }
        let guess = guess.as_ref().or(from.guess);
        let (further, again) =
            certified_attempt(model, condensed, Start { guess, ..from }, observe)?;
        (attempt, judged) = (attempt.followed_by(further), again);
    }
    turns.take_over(model, condensed, &mut judged)?;
    Ok((attempt, judged, parted))
}
