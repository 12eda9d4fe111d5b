//! Loss of equilibrium: a load that no friction can hold is an answer, which names body, motion and load factor.
//!
//! The load is infeasible: no forces within the friction cones balance it. If unlimited friction could, the body slides;
//! if not, it is pulled away from everything that could hold it, which is an error of the model.

use crate::dual::{AdmissibleSet, Feasibility, Multipliers};
use crate::fem::{Short, show};
use crate::model::condense::LoadedBody;
use crate::model::floating::Floating;
use crate::model::nouns::Model;
use crate::model::pipeline::{Condensed, largest_load};

/// A body that gives way so many times as much as its cells do leaves the gaps few digits.
const SLENDER: f64 = 1e9;

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
    /// Where an iteration that did not settle is worst, and what to try, in words.
    pub(crate) fn unsettled(&self, condensed: &Condensed<D>, last: &Multipliers) -> String {
        let problem = &condensed.problem;
        let Some(row) = problem.least_settled(last) else {
            return String::new();
        };
        let (contact, point) = self.carriers(&condensed.paired)[row];
        let slender = self.slender(condensed);
        let advice = match (slender, problem.admissible.has_coulomb()) {
            (Some((body, times)), _) => format!(
                "body \"{body}\" is slender, it gives way {times:.0e} times as much as its cells do: divide it into bodies that are `tied` to each other"
            ),
            (None, true) => "within Coulomb's cones some forces balance the load, but those that go with the slips were not found, or are not unique: try smaller load steps or a smaller coefficient".to_string(),
            (None, false) => "try a larger `tolerance`, or stiffnesses that differ less".to_string(),
        };
        format!(
            "; it is worst at {} of contact \"{}\"; {advice}",
            show(point),
            self.contacts[contact].name
        )
    }

    /// The body that gives way most beside what its cells do, and how many times that, where it leaves few digits.
    fn slender(&self, condensed: &Condensed<D>) -> Option<(String, f64)> {
        let softness = &condensed.problem.softness;
        // of the bodies at a contact the one of softer material: the other may give way with it
        let mut softest = vec![(usize::MAX, f64::INFINITY); softness.len()];
        for (index, body) in condensed.bodies.iter().enumerate() {
            let diagonal = body.system.stiffness.diagonal();
            let stiffest = diagonal.iter().fold(0.0, |s: f64, k| s.max(*k));
            for &row in body.rows.index.iter().filter(|_| stiffest > 0.0) {
                if stiffest < softest[row].1 {
                    softest[row] = (index, stiffest);
                }
            }
        }
        let known = softest
            .iter()
            .zip(softness)
            .filter(|(s, _)| s.1.is_finite());
        let times = known.map(|(&(index, stiffest), gives)| (index, gives * stiffest));
        let (index, most) = times.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (most > SLENDER).then(|| (self.part_name(index), most))
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
