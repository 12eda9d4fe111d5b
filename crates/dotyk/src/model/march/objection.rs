//! Reasons why an attempt is not an answer.

use crate::dual::Multipliers;
use crate::fem::{RigidBasis, describe_motion, fit_rigid};
use crate::geometry::{Point, add_scaled, centroid, distance, sub};
use crate::linalg::dense::dot;
use crate::model::march::attempt::Attempt;
use crate::model::march::jam::{jammed, wedged};
use crate::model::march::judge::Judged;
use crate::model::march::open::most_open;
use crate::model::nouns::error::{Advice, Objection};
use crate::model::nouns::model::Model;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::carriers;
use crate::model::system::parts::part_name;

/// A body whose compliance exceeds that of its cells by this factor leaves the gaps few digits.
const SLENDER: f64 = 1e9;

/// Below this residual the forces of a crowd are nearly an answer.
const ROUGH: f64 = 1e-3;

/// A turn in radians beyond the theory of small rotations, and the ratio of turn to strain above which loads do not explain it.
const LARGE_TURN: f64 = 1.0;
const UNDRIVEN: f64 = 100.0;

/// Why an attempt is not an answer; `None` where it is one.
pub(crate) fn objection<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    attempt: &Attempt<D>,
    judged: &Judged<D>,
) -> Option<Objection<D>> {
    let certificate = judged.certificate;
    match &attempt.failure {
        Some(Objection::Unsettled {
            reason, residual, ..
        }) if attempt.outcome.iterations > 0 => {
            let forces = &attempt.outcome.multipliers;
            let row = condensed.problem.least_settled(forces);
            let worst = row.map(|row| {
                let (index, point) = carriers(model, &condensed.conditions)[row];
                let called = condensed.conditions[index].called(model);
                (called, point, advice(model, condensed, (forces, *residual)))
            });
            Some(Objection::Unsettled {
                reason: reason.clone(),
                residual: *residual,
                worst,
            })
        }
        Some(failure) => Some(failure.clone()),
        None if certificate.holds() => turned(model, condensed, judged),
        None => {
            let overlap = judged
                .overlap
                .filter(|_| !certificate.between_nodes.holds());
            let intrusion = judged.intrusion.clone();
            let open = (!certificate.rounding.holds()).then(|| {
                let forces = &attempt.outcome.multipliers;
                most_open(model, condensed, &judged.displaced, forces)
            });
            let balanced = [certificate.imbalance_force, certificate.imbalance_moment];
            let unbalanced = balanced.iter().any(|figure| !figure.holds());
            let mut ordered = condensed.ordered.iter();
            let glued = unbalanced && ordered.any(|ordered| ordered.divided().is_some());
            Some(Objection::Violated {
                certificate: Box::new(certificate),
                open: open.flatten(),
                glued,
                intrusion: intrusion
                    .filter(|_| !certificate.overlap.holds())
                    .map(Box::new),
                overlap: overlap.map(|o| {
                    let contact = &model.contacts[o.contact];
                    (contact.name.clone(), o.point, o.depth)
                }),
            })
        }
    }
}

/// A floating body that turns by more than a radian although hardly strained: in the theory of small rotations the forces may
/// balance and the gaps be closed, but a real body would not be there.
///
/// With large strains a large turn comes from large loads, and a warning reports it.
fn turned<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    judged: &Judged<D>,
) -> Option<Objection<D>> {
    let basis = RigidBasis::of(model.analysis);
    let states = &judged.displaced.states;
    let bodies = model.bodies.iter().zip(&condensed.bodies).zip(states);
    let mut floating = bodies.filter(|((_, loaded), _)| !loaded.system.modes.is_empty());
    floating.find_map(|((body, _), state)| {
        let points = body.mesh.points();
        let centre = centroid(points);
        let (translation, spin) = fit_rigid(basis, points, &state.u, centre);
        let turn = dot(&spin, &spin).sqrt();
        if turn <= LARGE_TURN {
            return None;
        }
        let rigid = |&x: &Point<D>| {
            let about = spin.iter().enumerate();
            about.fold(translation, |u, (k, s)| {
                add_scaled(u, *s, basis.displacement(k, sub(x, centre)))
            })
        };
        let left = points.iter().zip(&state.u);
        let left = left.map(|(x, &u)| distance(u, rigid(x)));
        let strain = left.fold(0.0, f64::max) / body.mesh.diameter();
        (turn > UNDRIVEN * strain).then(|| Objection::Turned {
            body: body.name.clone(),
            motion: describe_motion(points, &points.iter().map(rigid).collect::<Vec<_>>()),
            turn,
        })
    })
}

/// Advice where an iteration did not settle.
fn advice<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    (forces, residual): (&Multipliers, f64),
) -> Advice {
    if let Some((body, times)) = slender(model, condensed) {
        return Advice::Divide { body, times };
    }
    let jam = jammed(model, condensed, forces).or_else(|| wedged(model, condensed));
    if let Some(jam) = jam {
        return jam;
    }
    match condensed.problem.admissible.bounds_follow() {
        _ if condensed.problem.is_crowd() && residual < ROUGH => Advice::Crowd {
            tolerance: 10f64.powf((10.0 * residual).log10().ceil()),
        },
        true => Advice::SmallerSteps,
        false => Advice::LargerTolerance,
    }
}

/// The body whose compliance is largest relative to that of its cells, and that ratio, where it leaves few digits.
fn slender<const D: usize>(model: &Model<D>, condensed: &Condensed<D>) -> Option<(String, f64)> {
    let softness = &condensed.problem.softness;
    // of the bodies at a contact the one of softer material: the other may move with it
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
