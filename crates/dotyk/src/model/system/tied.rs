//! Ties against supports: where supports prescribe the motion of both sides of a tie, the tie has no force, and the motions must agree.
//!
//! ```text
//!   a·(Σ n_j u_j − u) = 0      along every direction a that is held at a node of the nonmortar side and at all nodes j opposite it
//! ```
//!
//! Curved sides are polygons: the motion opposite a node is known to the differences of the motions that it is a mean of. Only motions
//! are compared: a gap that both supports leave open is theirs.

use crate::contact::{ContactError, Coupling, InterfaceNode, Role};
use crate::fem::{AGREE, Constraints, Held, show};
use crate::geometry::{Point, add_scaled, dot, norm};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::system::condition::Condition;
use std::sync::Arc;

/// A direction is held if no more than this part of it is not along held ones.
const HELD: f64 = 1e-8;

/// A node of which a point is a smaller part does not count for it.
const NO_PART: f64 = 1e-9;

/// A displacement along a direction, and the size of its terms.
type Along = (f64, f64);

/// Errors: a tie whose sides supports move apart.
pub(crate) fn agree_with_supports<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    conditions: &[Condition<D>],
) -> Result<(), Error<D>> {
    let is_tie = |condition: &&Condition<D>| {
        let tied = condition.interface.coupling == Coupling::Tied;
        condition.contact().is_some() && tied && condition.touch.filling.is_none()
    };
    for condition in conditions.iter().filter(is_tie) {
        let own = condition.nonmortar.body.0;
        let nodes = condition.interface.nodes.iter();
        let nodes = nodes.filter(|node| !matches!(node.role, Role::Excluded | Role::Alone));
        for node in nodes {
            for held in constraints[own].nodes.get(&node.node).into_iter().flatten() {
                let value =
                    held.value - dot(held.axis, fitted(&condition.touch.fit.own, node.node));
                let opposite = opposite(constraints, condition, node, held.axis);
                let apart = opposite.and_then(|opposite| apart((value, held.terms), &opposite));
                if let Some(distance) = apart {
                    return Err(Error::Contact {
                        contact: condition.name.clone(),
                        source: ContactError::MovedApart {
                            point: show(model.bodies[own].mesh.points()[node.node]),
                            distance,
                        },
                    });
                }
            }
        }
    }
    Ok(())
}

/// The displacement to which a node was fitted.
fn fitted<const D: usize>(fit: &Option<Arc<[Point<D>]>>, node: usize) -> Point<D> {
    fit.as_ref().map_or([0.0; D], |fit| fit[node])
}

/// Weights and prescribed displacements along a direction of what is opposite a node; `None` where some of it is free.
fn opposite<const D: usize>(
    constraints: &[&Constraints<D>],
    condition: &Condition<D>,
    node: &InterfaceNode<D>,
    axis: Point<D>,
) -> Option<Vec<(f64, Along)>> {
    let fit = &condition.touch.fit.other;
    // an obstacle moves as one
    let alone = [(0, 1.0)];
    let (part, places) = match (&condition.mortar, condition.opposite) {
        (Some(mortar), _) => (mortar.body.0, &node.opposite[..]),
        (None, Some(part)) => (part, &alone[..]),
        (None, None) => {
            let motion = condition.touch.obstacle_motion;
            let value = dot(axis, motion) - dot(axis, fitted(fit, 0));
            return Some(vec![(1.0, (value, norm(motion)))]);
        }
    };
    let places = places.iter().filter(|(_, weight)| weight.abs() > NO_PART);
    let each = places.map(|&(j, weight)| {
        let (value, terms) = value_along(constraints[part].nodes.get(&j)?, axis)?;
        Some((weight, (value - dot(axis, fitted(fit, j)), terms)))
    });
    each.collect()
}

/// The displacement along a direction that held ones prescribe; `None` if they do not.
fn value_along<const D: usize>(held: &[Held<D>], axis: Point<D>) -> Option<Along> {
    let (mut rest, mut value, mut terms) = (axis, 0.0, 0.0);
    for own in held {
        let part = dot(axis, own.axis);
        rest = add_scaled(rest, -part, own.axis);
        value += part * own.value;
        // of parts that are rounding, too
        terms = f64::max(terms, own.terms.max(own.value.abs()));
    }
    (norm(rest) <= HELD).then_some((value, terms))
}

/// How far a node goes from its place opposite, a mean by weights; `None` if they agree.
fn apart((value, terms): Along, opposite: &[(f64, Along)]) -> Option<f64> {
    let mean: f64 = opposite
        .iter()
        .map(|(weight, along)| weight * along.0)
        .sum();
    let sizes = opposite.iter().map(|(_, along)| along.1.max(along.0.abs()));
    let size = sizes.fold(terms.max(value.abs()), f64::max);
    let values = || opposite.iter().map(|(_, along)| along.0);
    let spread =
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
    let apart = (mean - value).abs();
    (!opposite.is_empty() && apart > spread + AGREE * size).then_some(apart)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_agree_within_the_differences_of_those_opposite() {
        assert_eq!(apart((1.0, 1.0), &[]), None);
        assert_eq!(apart((1.0, 1.0), &[(1.0, (1.0, 1.0))]), None);
        assert_eq!(apart((0.0, 0.0), &[(1.0, (0.0, 0.0))]), None);
        let alike = [(0.5, (0.01, 0.01)); 2];
        assert_eq!(apart((0.0, 0.0), &alike), Some(0.01));
        let found = apart((1.001, 1.0), &[(1.0, (1.0, 1.0))]).unwrap();
        assert!((found - 1e-3).abs() < 1e-12);
        // a turned side: between motions of 0.9 and 1.1
        let turned = [(0.5, (0.9, 1.1)), (0.5, (1.1, 1.1))];
        assert_eq!(apart((1.05, 1.1), &turned), None);
        assert!(apart((1.3, 1.3), &turned).is_some());
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
        let (value, _) = value_along(&both, [0.6, 0.8]).unwrap();
        assert!((value - (0.6 * 2.0 - 0.8)).abs() < 1e-15);
        assert_eq!(value_along(&both[..1], [0.6, 0.8]), None);
        assert_eq!(value_along(&both[1..], [0.0, -1.0]), Some((1.0, 1.0)));
    }
}
