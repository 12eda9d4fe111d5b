//! Load steps that were solved before, as their results tell: a run goes on behind them.
//!
//! A recorded step is verified. The solver begins with its forces, which takes no iterations where they are the answer; the
//! answer is judged like any other, and must have the recorded forces, displacements and strain energies: forces alone do not
//! show stiffnesses that change together. Forces of couples are not recorded: with couples each step begins where the one
//! before it ended, as it did when it was solved first.

use crate::contact::InterfaceNode;
use crate::dual::Multipliers;
use crate::fem::Yielded;
use crate::geometry::{Point, dot};
use crate::linalg::SparseVector;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::nouns::solution::{BodySolution, Solution, Status};
use crate::model::system::condense::{Condensed, assume};
use crate::model::system::condition::{Condition, contact_rows, row_ranges};
use crate::model::system::joints::joints;
use crate::model::system::shared::{bearing_weight, shear_parts};
use std::sync::Arc;

/// A load step that was solved before.
#[derive(Debug, Clone, PartialEq)]
pub struct Past<const D: usize> {
    /// Its time.
    pub time: f64,
    /// Iterations that it took.
    pub iterations: usize,
    /// Time of the step at whose end its displacements are zero; `None` where they count from the beginning.
    pub counted_from: Option<f64>,
    /// Every contact by its name.
    pub contacts: Vec<(String, Vec<PastNode<D>>)>,
    /// Every body, in the order of the model.
    pub bodies: Vec<PastBody>,
}

/// Results of a body in a step that was solved before.
#[derive(Debug, Clone, PartialEq)]
pub struct PastBody {
    /// Its name.
    pub name: String,
    /// Largest length of the displacement of a node.
    pub max_displacement: f64,
    /// Its strain energy.
    pub strain_energy: f64,
    /// Its plastic strain at the points of its stiffness, where known: as
    /// [`BodySolution::inelastic`](crate::model::BodySolution::inelastic).
    pub yielded: Option<Vec<[f64; 8]>>,
}

/// A node of a contact in a step that was solved before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PastNode<const D: usize> {
    /// Node of the nonmortar mesh.
    pub node: usize,
    /// ∫ψ, an area.
    pub weight: f64,
    /// NaN where it has no gap.
    pub gap: f64,
    /// NaN where it is no unknown.
    pub pressure: f64,
    /// Traction along the interface on the nonmortar body.
    pub shear: Point<D>,
    /// Its state.
    pub status: Status,
}

impl<const D: usize> From<&Solution<D>> for Past<D> {
    fn from(solution: &Solution<D>) -> Self {
        let contacts = solution.contacts.iter().map(|contact| {
            let nodes = contact.nodes.iter().map(|node| PastNode {
                node: node.node,
                weight: node.weight,
                gap: node.gap,
                pressure: node.pressure,
                shear: node.shear,
                status: node.status,
            });
            (contact.name.clone(), nodes.collect())
        });
        Self {
            time: solution.time,
            iterations: solution.solver.iterations,
            counted_from: solution.counted_from,
            contacts: contacts.collect(),
            bodies: solution.bodies.iter().map(PastBody::from).collect(),
        }
    }
}

impl<const D: usize> From<&BodySolution<D>> for PastBody {
    fn from(body: &BodySolution<D>) -> Self {
        Self {
            name: body.name.clone(),
            max_displacement: body.max_displacement(),
            strain_energy: body.strain_energy,
            yielded: body.inelastic.clone(),
        }
    }
}

/// Forces, displacements and energies that differ by less, relative to the largest and to the tolerance, are the same: the
/// certificate bounds gaps, and forces are known to a few digits less.
const SAME_STATE: f64 = 100.0;

/// Displacements and energies below this part of those without contacts are rounding: bodies are at rest.
const REST: f64 = 1e-13;

/// Weights that differ by less, relative to their size, are those of the same mesh.
const SAME_WEIGHT: f64 = 1e-9;

/// Times that differ by less, relative to the latest, are the same.
const SAME_TIME: f64 = 1e-12;

/// Errors: steps that are not the first ones of the model, or all of them.
pub(crate) fn check_past<const D: usize>(
    model: &Model<D>,
    past: &[Past<D>],
) -> Result<(), Error<D>> {
    let latest = model.times.iter().fold(0.0, |s: f64, t| s.max(t.abs()));
    for (index, done) in past.iter().enumerate() {
        let differs = |what: String| {
            Err(Error::Past {
                step: index + 1,
                what,
            })
        };
        let Some(time) = model.times.get(index) else {
            return differs(format!("the model has {} steps", model.times.len()));
        };
        if (time - done.time).abs() > SAME_TIME * latest {
            return differs(format!("it was at t = {}, and is at {time} now", done.time));
        }
    }
    match past.len() < model.times.len() {
        true => Ok(()),
        false => Err(Error::NothingLeft(past.len())),
    }
}

/// The forces of a step that was solved before, and the amplitudes of the rigid motions from its gaps. Forces of couples, which
/// are not recorded, are zero.
///
/// Errors: other contacts, nodes or weights; forces that are not finite.
pub(crate) fn recorded<const D: usize>(
    condensed: &Condensed<D>,
    model: &Model<D>,
    past: &Past<D>,
) -> Result<Multipliers, String> {
    let m = condensed.gaps.len();
    let (mut lambda, mut gaps) = (vec![0.0; m], vec![None; m]);
    for (index, (rows, condition)) in contact_rows(&condensed.conditions) {
        let contact = &model.contacts[index];
        let found = past.contacts.iter().find(|(name, _)| *name == contact.name);
        let Some((name, nodes)) = found else {
            return Err(format!("it has no contact \"{}\"", contact.name));
        };
        let (lambda, gaps) = (&mut lambda[rows.clone()], &mut gaps[rows]);
        let shears = |place| shear_parts(model, (index, condition), place, past.time);
        let bearing = |place, pulls| bearing_weight(model, (index, condition), place, pulls);
        of_contact(name, condition, nodes, (bearing, shears), (lambda, gaps))?;
        let besides = lambda.iter_mut().zip(&condition.offset);
        besides.for_each(|(force, offset)| *force -= offset);
    }
    let mut multipliers = Multipliers {
        lambda,
        alpha: vec![0.0; condensed.problem.balance.load().len()],
    };
    let still = condensed.problem.gap(&multipliers);
    let motion = gaps.iter().zip(&still);
    let motion: Vec<Option<f64>> = motion.map(|(gap, still)| Some(still - (*gap)?)).collect();
    multipliers.alpha = amplitudes(
        condensed.problem.balance.modes().columns(),
        &motion,
        multipliers.alpha,
    );
    Ok(multipliers)
}

/// Nodes that joints lost by the end of a recorded step, by contact and node, where some parted within it (`torn.rs`): the recorded forces
/// are none that a whole joint bears there.
pub(crate) fn parted<const D: usize>(
    condensed: &Condensed<D>,
    model: &Model<D>,
    recorded: &Multipliers,
) -> Option<Vec<Vec<bool>>> {
    let conditions = &condensed.conditions;
    let lost = || conditions.iter().map(|c| c.touch.lost.clone());
    let mut lost: Vec<Vec<bool>> = lost().collect();
    let largest = recorded.lambda.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    let limit = SAME_STATE * model.solver.tolerance * largest;
    let errors = condensed.problem.force_errors(recorded);
    let firsts: Vec<usize> = row_ranges(conditions).map(|(rows, _)| rows.start).collect();
    let mut found = false;
    for (index, _, condition) in joints(model, conditions) {
        let nodes = condition.interface.nodes.iter();
        for (node, lost) in nodes.zip(&mut lost[index]) {
            let off = |row: &Option<usize>| row.map(|row| errors[firsts[index] + row]);
            let off = node.rows.iter().filter_map(off).fold(0.0, f64::max);
            if !*lost && off > limit {
                (*lost, found) = (true, true);
            }
        }
    }
    found.then_some(lost)
}

/// Forces and known gaps of the rows of a contact. At its nodes `bearing` is the weight of the pressure, by whether that is a
/// tension, and `shears` are the parts of the shear borne by the contacts there.
fn of_contact<const D: usize>(
    name: &str,
    condition: &Condition<D>,
    past: &[PastNode<D>],
    (bearing, shears): (impl Fn(usize, bool) -> f64, impl Fn(usize) -> Vec<f64>),
    (lambda, gaps): (&mut [f64], &mut [Option<f64>]),
) -> Result<(), String> {
    let nodes = &condition.interface.nodes;
    let same = |(place, (now, then)): (usize, (&InterfaceNode<D>, &PastNode<D>))| {
        let own = condition.own_weight(place) * condition.untwinned(place);
        now.node == then.node && (own - then.weight).abs() <= SAME_WEIGHT * own.abs()
    };
    if nodes.len() != past.len() || !nodes.iter().zip(past).enumerate().all(same) {
        return Err(format!(
            "contact \"{name}\" had other nodes, or weights of nodes"
        ));
    }
    for (place, (now, then)) in nodes.iter().zip(past).enumerate() {
        if let Some(row) = now.rows[0] {
            lambda[row] = if then.pressure.is_nan() {
                0.0
            } else {
                then.pressure * bearing(place, then.pressure < 0.0)
            };
            gaps[row] = Some(then.gap).filter(|gap| gap.is_finite());
        }
        for (direction, row) in now.frame.iter().zip(now.rows).skip(1) {
            let Some(row) = row else { continue };
            // the rows push the nonmortar body by −λ
            let whole = then.weight / condition.untwinned(place) / shears(place)[0];
            lambda[row] = -dot(then.shear, *direction) * whole;
            // a sticking node has not moved in this step
            gaps[row] = matches!(then.status, Status::Stick | Status::Tied).then_some(0.0);
        }
        let mut forces = now.rows.iter().flatten().map(|&row| lambda[row]);
        if let Some(force) = forces.find(|force| !force.is_finite()) {
            return Err(format!(
                "the force of contact \"{name}\" at node {} is {force}",
                now.node
            ));
        }
    }
    Ok(())
}

/// α (r,) of least norm with Gᵀα nearest to a motion in the rows where it is known, G by its columns; from zero by conjugate
/// gradients, which end after r steps.
fn amplitudes(columns: &[SparseVector], motion: &[Option<f64>], mut alpha: Vec<f64>) -> Vec<f64> {
    let known: Vec<(&SparseVector, f64)> = columns
        .iter()
        .zip(motion)
        .filter_map(|(column, motion)| Some((column, (*motion)?)))
        .collect();
    // G Gᵀ v on the known rows
    let normal = |v: &[f64]| {
        let mut product = vec![0.0; v.len()];
        for (column, _) in &known {
            column.add_to(column.dot(v), &mut product);
        }
        product
    };
    let mut rest = vec![0.0; alpha.len()];
    for (column, motion) in &known {
        column.add_to(*motion, &mut rest);
    }
    let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut along = rest.clone();
    let (start, mut size) = (inner(&rest, &rest), inner(&rest, &rest));
    for _ in 0..2 * alpha.len() {
        if size <= f64::EPSILON * f64::EPSILON * start {
            break;
        }
        let product = normal(&along);
        let step = size / inner(&along, &product);
        for ((a, r), (p, q)) in alpha
            .iter_mut()
            .zip(&mut rest)
            .zip(along.iter().zip(&product))
        {
            *a += step * p;
            *r -= step * q;
        }
        let before = std::mem::replace(&mut size, inner(&rest, &rest));
        let keep = size / before;
        along
            .iter_mut()
            .zip(&rest)
            .for_each(|(p, r)| *p = r + keep * *p);
    }
    alpha
}

/// Plastic strains of the bodies in a recorded step, as a load: the start of the search.
///
/// Errors: strains of another mesh, or that cannot be applied as a load.
pub(crate) fn assume_recorded<const D: usize>(
    condensed: &mut Condensed<D>,
    model: &Model<D>,
    past: &Past<D>,
) -> Result<Result<(), String>, Error<D>> {
    let mut all = condensed.state.yielded();
    for (body, own) in model.bodies.iter().zip(&mut all) {
        let mut recorded = past.bodies.iter().filter(|past| past.name == body.name);
        let Some(points) = recorded.next().and_then(|past| past.yielded.clone()) else {
            continue;
        };
        let nothing = Yielded::nothing(body, model.analysis);
        let nothing = nothing.map_err(|why| Error::in_body(body, why))?;
        if nothing.0.len() != points.len() {
            let what = format!("body \"{}\" had another mesh", body.name);
            return Ok(Err(what));
        }
        *own = Some(Arc::new(Yielded(points)));
    }
    if all.iter().any(Option::is_some) {
        assume(model, condensed, all)?;
    }
    Ok(Ok(()))
}

/// Errors: displacements or strain energies other than in the recorded step.
pub(crate) fn same_bodies<const D: usize>(
    (condensed, model): (&Condensed<D>, &Model<D>),
    past: &Past<D>,
    solution: &Solution<D>,
) -> Result<(), String> {
    let from = [past.counted_from, solution.counted_from];
    if from[0] != from[1] {
        let told = from.map(|time| match time {
            Some(time) => format!("the end of the step at t = {time}"),
            None => "the beginning".to_string(),
        });
        return Err(format!(
            "its displacements counted from {}, and count from {} now: `zero_displacements` was another",
            told[0], told[1]
        ));
    }
    let recorded = &past.bodies[..];
    let found: Vec<PastBody> = solution.bodies.iter().map(PastBody::from).collect();
    let names = |bodies: &[PastBody]| bodies.iter().map(|b| b.name.clone()).collect::<Vec<_>>();
    if names(recorded) != names(&found) {
        return Err(format!(
            "its bodies were {}, and are {} now",
            names(recorded).join(", "),
            names(&found).join(", ")
        ));
    }
    type Figure = (&'static str, fn(&PastBody) -> f64, f64);
    // displacements by loads alone, where contacts cancel them
    let scales = &condensed.problem.scales;
    let figures: [Figure; 2] = [
        ("moved", |body| body.max_displacement, scales.length),
        ("strained", |body| body.strain_energy, scales.energy),
    ];
    // displacements that count from an earlier step may be small differences of large ones
    let compared = if from[0].is_some() { 1 } else { 0 };
    for (what, of, alone) in figures.into_iter().skip(compared) {
        let both = recorded.iter().chain(&found).map(of);
        let largest = both.fold(0.0, f64::max);
        let limit = (SAME_STATE * model.solver.tolerance * largest).max(REST * alone);
        let pairs = recorded.iter().zip(&found);
        let differs = |(a, b): &(&PastBody, &PastBody)| {
            let off = (of(a) - of(b)).abs();
            off > limit || off.is_nan()
        };
        if let Some((before, now)) = pairs.clone().find(differs) {
            return Err(format!(
                "body \"{}\" was {what} by {:.6e}, and is by {:.6e} now: loads, materials, supports or the mesh were others",
                now.name,
                of(before),
                of(now)
            ));
        }
    }
    Ok(())
}

/// Errors: forces that are not those of the recorded step.
pub(crate) fn same_forces<const D: usize>(
    condensed: &Condensed<D>,
    model: &Model<D>,
    recorded: &Multipliers,
    found: &Multipliers,
) -> Result<(), String> {
    let contacts = contact_rows(&condensed.conditions);
    let rows = ..contacts.last().map_or(0, |(_, (rows, _))| rows.end);
    let largest = recorded.lambda[rows].iter().chain(&found.lambda[rows]);
    let largest = largest.fold(0.0, |s: f64, l| s.max(l.abs()));
    let limit = SAME_STATE * model.solver.tolerance * largest;
    for (index, (rows, _)) in contact_rows(&condensed.conditions) {
        let contact = &model.contacts[index];
        let both = recorded.lambda[rows.clone()]
            .iter()
            .zip(&found.lambda[rows]);
        let off = both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if off > limit {
            return Err(format!(
                "the forces of contact \"{}\" differ by {:.1e} of the largest contact force from those that answer this model: loads, materials or friction of the step were others",
                contact.name,
                off / largest
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_fit_the_rows_that_are_known() {
        // two modes over four rows, of which one is not known
        let columns = [[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0]];
        let columns = columns.map(|[a, b]| SparseVector::new(2, [(0, a), (1, b)]));
        let motion = [0.5, 0.75, f64::NAN, 1.25].map(|v| Some(v).filter(|v| !v.is_nan()));
        let [a, b] = amplitudes(&columns, &motion, vec![0.0; 2])[..] else {
            panic!("two modes")
        };
        assert!((a - 0.5).abs() < 1e-14 && (b - 0.25).abs() < 1e-14);
        // no known gap: no motion
        assert_eq!(amplitudes(&columns, &[None; 4], vec![0.0; 2]), [0.0; 2]);
    }
}
