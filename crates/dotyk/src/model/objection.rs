//! Why an attempt is no answer, in words.

use crate::dual::Multipliers;
use crate::fem::{Short, show};
use crate::model::attempt::Attempt;
use crate::model::condense::Condensed;
use crate::model::judge::Judged;
use crate::model::nouns::Model;
use crate::model::pair::carriers;
use crate::model::parts::part_name;

/// A body that gives way so many times as much as its cells do leaves the gaps few digits.
const SLENDER: f64 = 1e9;

/// Why an attempt is not an answer, if it is none.
pub(crate) fn objection<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    attempt: &Attempt,
    judged: &Judged<D>,
) -> Option<String> {
    let certificate = &judged.certificate;
    let overlap = judged
        .overlap
        .filter(|_| !certificate.between_nodes.holds());
    match (&attempt.failure, overlap) {
        (Some(reason), _) if attempt.outcome.iterations > 0 => {
            let multipliers = &attempt.outcome.multipliers;
            Some(reason.clone() + &unsettled(model, condensed, multipliers))
        }
        (Some(reason), _) => Some(reason.clone()),
        (None, _) if certificate.holds() => None,
        (None, Some(place)) => Some(format!(
            "{}: the sides of contact \"{}\" overlap by {} at {}",
            certificate.objection(),
            model.contacts[place.contact].name,
            Short(place.depth),
            show(place.point)
        )),
        (None, None) => Some(certificate.objection()),
    }
}

/// Where an iteration that did not settle is worst, and what to try, in words.
fn unsettled<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    last: &Multipliers,
) -> String {
    let problem = &condensed.problem;
    let Some(row) = problem.least_settled(last) else {
        return String::new();
    };
    let (contact, point) = carriers(model, &condensed.paired)[row];
    let slender = slender(model, condensed);
    let advice = match (slender, problem.admissible.bounds_follow()) {
        (Some((body, times)), _) => format!(
            "body \"{body}\" is slender, it gives way {times:.0e} times as much as its cells do: divide it into bodies that are `tied` to each other"
        ),
        (None, true) => "within Coulomb's cones some forces balance the load, but those that go with the slips were not found, or are not unique: try smaller load steps or a smaller coefficient".to_string(),
        (None, false) => "try a larger `tolerance`, or stiffnesses that differ less".to_string(),
    };
    format!(
        "; it is worst at {} of contact \"{}\"; {advice}",
        show(point),
        model.contacts[contact].name
    )
}

/// The body that gives way most beside what its cells do, and how many times that, where it leaves few digits.
fn slender<const D: usize>(model: &Model<D>, condensed: &Condensed<D>) -> Option<(String, f64)> {
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
    (most > SLENDER).then(|| (part_name(model, index), most))
}
