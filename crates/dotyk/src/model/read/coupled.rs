//! Results at the points of couples: their motion, and the force that they pass on to their sides.

use crate::contact::pushed;
use crate::geometry::Point;
use crate::model::nouns::model::{Analysis, Couple, Model};
use crate::model::nouns::solution::CoupleSolution;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Source, row_ranges};
use crate::model::system::displaced::Displaced;
use crate::model::system::parts::Owner;

/// Solutions of the couples of every body under forces `lambda` (m,), (bodies,).
pub(crate) fn couple_solutions<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    lambda: &[f64],
) -> Vec<Vec<CoupleSolution<D>>> {
    let mut solutions = vec![Vec::new(); model.bodies.len()];
    for (rows, condition) in row_ranges(&condensed.conditions) {
        let (Source::Of(Owner::Point(body, place)), Some(part)) =
            (condition.source, condition.opposite)
        else {
            continue;
        };
        let couple = &model.bodies[body].couples[place];
        let turns = Couple::<D>::turns(model.analysis);
        let points = model.bodies[body].mesh.points();
        let (force, moment) = pushed(
            &condition.interface.nonmortar,
            &lambda[rows],
            points,
            couple.point,
        );
        let [u, turned] = [0, 1].map(|node| displaced.nodes(part)[node]);
        // a side that could be paired has an arm
        let arm = couple.arm(&model.bodies[body]).unwrap_or(f64::NAN);
        let angles = |vector: &dyn Fn(usize) -> f64| match model.analysis {
            Analysis::Axisymmetric => vec![0.0],
            _ => (0..turns.len()).map(vector).collect(),
        };
        solutions[body].push(CoupleSolution {
            name: couple.name.clone(),
            kind: couple.kind,
            point: couple.point,
            displacement: u,
            rotation: angles(&|k| turned[k] / arm),
            force,
            moment: angles(&|k| moment[turns.start + k]),
            reaction: reaction(condensed, part, lambda),
        });
    }
    solutions
}

/// Force of the supports ON a point.
fn reaction<const D: usize>(condensed: &Condensed<D>, part: usize, lambda: &[f64]) -> Point<D> {
    let forces = condensed.bodies[part].held_forces(lambda);
    std::array::from_fn(|i| forces[i])
}
