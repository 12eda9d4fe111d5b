//! Ties against supports: where supports prescribe the motion of both sides of a tie, the tie has no force, and the motions must agree.
//!
//! ```text
//!   a·(Σ n_j u_j − u) = 0      along every direction a that is held at a node of the nonmortar side and at all nodes j opposite it
//! ```
//!
//! Curved sides are polygons: the motion opposite a node is known to the differences of the motions that it is a mean of.

use crate::contact::{ContactError, Coupling, Role};
use crate::fem::{AGREE, Constraints, Held, show};
use crate::geometry::{Point, add_scaled, dot, norm};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::system::condition::Condition;

/// A direction is held if no more than this part of it is not along held ones.
const HELD: f64 = 1e-8;

/// Errors: a tie whose sides supports move apart.
pub(crate) fn agree_with_supports<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    conditions: &[Condition<D>],
) -> Result<(), Error<D>> {
    for condition in conditions {
        let Some(mortar) = condition.mortar.as_ref() else {
            continue;
        };
        let tie = condition.contact().is_some() && condition.interface.coupling == Coupling::Tied;
        if !tie || condition.touch.filling.is_some() {
            continue;
        }
        let [own, other] = [condition.nonmortar.body.0, mortar.body.0];
        let [held, beyond] = [constraints[own], constraints[other]];
        let fit = &condition.touch.fit;
        let then = |fit: &Option<std::sync::Arc<[Point<D>]>>, node: usize| {
            fit.as_ref().map_or([0.0; D], |fit| fit[node])
        };
        for node in &condition.interface.nodes {
            if matches!(node.role, Role::Excluded | Role::Alone) {
                continue;
            }
            for along in held.nodes.get(&node.node).into_iter().flatten() {
                let opposite = node.opposite.iter().map(|&(j, weight)| {
                    let directions = beyond.nodes.get(&j)?;
                    let fitted = dot(along.axis, then(&fit.other, j));
                    let (value, terms) = value_along(directions, along.axis)?;
                    Some((weight, value - fitted, terms))
                });
                let Some(opposite) = opposite.collect::<Option<Vec<_>>>() else {
                    continue;
                };
                let Some(apart) = apart(
                    along.value - dot(along.axis, then(&fit.own, node.node)),
                    along.terms,
                    &opposite,
                ) else {
                    continue;
                };
                return Err(Error::Contact {
                    contact: condition.name.clone(),
                    source: ContactError::MovedApart {
                        bodies: [own, other].map(|body| model.bodies[body].name.clone()),
                        point: show(model.bodies[own].mesh.points()[node.node]),
                        distance: apart,
                    },
                });
            }
        }
    }
    Ok(())
}

/// The displacement along a direction that held ones prescribe, and the size of its terms; `None` if they do not.
fn value_along<const D: usize>(held: &[Held<D>], axis: Point<D>) -> Option<(f64, f64)> {
    let (mut rest, mut value, mut terms) = (axis, 0.0, 0.0);
    for own in held {
        let part = dot(axis, own.axis);
        rest = add_scaled(rest, -part, own.axis);
        value += part * own.value;
        terms += part.abs() * own.terms;
    }
    (norm(rest) <= HELD).then_some((value, terms))
}

/// How far a node that is moved by a value goes from its place opposite, of weights, values and terms; `None` if they agree.
fn apart(value: f64, terms: f64, opposite: &[(f64, f64, f64)]) -> Option<f64> {
    if opposite.is_empty() {
        return None;
    }
    let mean: f64 = opposite
        .iter()
        .map(|(weight, value, _)| weight * value)
        .sum();
    let [mut least, mut most, mut size] =
        [f64::INFINITY, f64::NEG_INFINITY, terms.max(value.abs())];
    for &(_, value, terms) in opposite {
        (least, most) = (least.min(value), most.max(value));
        size = size.max(terms).max(value.abs());
    }
    let apart = (mean - value).abs();
    (apart > most - least + AGREE * size).then_some(apart)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_agree_within_the_differences_of_those_opposite() {
        assert_eq!(apart(1.0, 1.0, &[]), None);
        assert_eq!(apart(1.0, 1.0, &[(1.0, 1.0, 1.0)]), None);
        assert_eq!(apart(0.0, 0.0, &[(1.0, 0.0, 0.0)]), None);
        assert_eq!(
            apart(0.0, 0.0, &[(0.5, 0.01, 0.01), (0.5, 0.01, 0.01)]),
            Some(0.01)
        );
        let found = apart(1.001, 1.0, &[(1.0, 1.0, 1.0)]).unwrap();
        assert!((found - 1e-3).abs() < 1e-12);
        // a turned side: between motions of 0.9 and 1.1
        assert_eq!(apart(1.05, 1.1, &[(0.5, 0.9, 1.1), (0.5, 1.1, 1.1)]), None);
        assert!(apart(1.3, 1.3, &[(0.5, 0.9, 1.1), (0.5, 1.1, 1.1)]).is_some());
    }

    #[test]
    fn held_directions_tell_the_displacement_along_those_they_span() {
        let held = |axis: Point<2>, value: f64| Held {
            axis,
            value,
            terms: value.abs(),
            still: false,
            supports: vec![0],
        };
        let both = [held([1.0, 0.0], 2.0), held([0.0, 1.0], -1.0)];
        assert_eq!(
            value_along(&both, [0.6, 0.8]).map(|found| found.0),
            Some(0.6 * 2.0 - 0.8)
        );
        assert_eq!(value_along(&both[..1], [0.6, 0.8]), None);
        assert_eq!(value_along(&both[1..], [0.0, -1.0]), Some((1.0, 1.0)));
    }
}
