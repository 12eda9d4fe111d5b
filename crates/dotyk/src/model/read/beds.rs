//! Results of beds (`fem/springs.rs`, `model/system/bed.rs`): pressure, gap and shear at the points of integration of their sides.
//!
//! ```text
//!   s = n·(u − u_a)                      pressed in; n outward from the body, u_a its displacement when the spring came
//!   p = kₙ s, or λ/A if it only presses  ≥ 0 compression
//!   gap = max(−s, 0) if it only presses, else 0
//!   t = −kₜ (1 − n⊗n)(u − u_a)           ON the body
//! ```
//!
//! Springs of one side are one bed: p and t are their sums, and the gap is the smallest of those that only press. The resultant is the
//! sum of their nodal forces.

use crate::dual::NONE;
use crate::fem::{Bed, Pad, Spring, pads};
use crate::geometry::{Point, add_scaled, dot, sub};
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::Model;
use crate::model::nouns::solution::{BedPoint, BedSolution};
use crate::model::system::bodies::largest_load;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Source, row_ranges};
use crate::model::system::parts::Owner;
use crate::model::system::recover::BodyState;
use std::collections::BTreeMap;

/// The beds of all bodies from their displacements, the forces of their springs, and forces `lambda` (m,).
///
/// Errors: a stiffness that is negative or no number.
pub(crate) fn bed_solutions<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    states: &[BodyState<D>],
    lambda: &[f64],
) -> Result<Vec<BedSolution<D>>, Error<D>> {
    let pressing: BTreeMap<(usize, usize), &[f64]> = row_ranges(&condensed.conditions)
        .filter_map(|(rows, condition)| match condition.source {
            Source::Of(Owner::Bed(of, place)) => Some(((of, place), &lambda[rows])),
            _ => None,
        })
        .collect();
    let mut beds: Vec<BedSolution<D>> = Vec::new();
    for (of, body) in model.bodies.iter().enumerate() {
        let history = &condensed.bodies[of].system.history;
        for (place, spring) in body.springs.iter().enumerate() {
            let Bed::Side { side, .. } = &spring.bed else {
                continue;
            };
            let pads = pads(body, spring, model.analysis);
            let pads = pads.map_err(|source| Error::in_body(body, source))?;
            let came = history.sprung.get(&place).map(|u| &u[..]);
            let forces = pressing.get(&(of, place)).copied();
            let forces = forces.unwrap_or_default();
            let read = Sprung { spring, forces };
            let own = BedSolution {
                name: format!("{}.{side}", body.name),
                side: SideRef {
                    body: BodyId(of),
                    side: side.clone(),
                },
                compression_only: spring.only_presses(),
                points: read.points(&pads, (&states[of].u, came)),
                resultant: sum(&states[of].springs[place]),
            };
            match beds.iter_mut().find(|bed| bed.side == own.side) {
                Some(bed) => join(bed, own),
                None => beds.push(own),
            }
        }
    }
    let load = largest_load(&condensed.bodies);
    beds.iter_mut().for_each(|bed| finish(bed, load));
    Ok(beds)
}

/// A spring of a side, and the forces of its points that only press.
struct Sprung<'a, const D: usize> {
    spring: &'a Spring<D>,
    forces: &'a [f64],
}

impl<const D: usize> Sprung<'_, D> {
    /// Its points under displacements of the nodes, now and when it came. Where no spring presses the gap is infinite.
    fn points(
        &self,
        pads: &[Pad<D>],
        (u, came): (&[Point<D>], Option<&[Point<D>]>),
    ) -> Vec<BedPoint<D>> {
        let only = self.spring.only_presses();
        let mut forces = self.forces.iter();
        let point = |pad: &Pad<D>| {
            let at = |u: &[Point<D>]| {
                let nodes = pad.nodes.iter();
                nodes.fold([0.0; D], |sum, &(node, n)| add_scaled(sum, n, u[node]))
            };
            let moved = came.map_or_else(|| at(u), |came| sub(at(u), at(came)));
            let [normal, across] = pad.stiffness;
            let pressed = dot(pad.normal, moved);
            let force = match only && pad.bears() {
                true => forces.next().copied().unwrap_or(0.0),
                false => normal * pressed * pad.area,
            };
            BedPoint {
                point: pad.point,
                normal: pad.normal,
                area: pad.area,
                pressure: force / pad.area,
                gap: match only && pad.bears() {
                    true => (-pressed).max(0.0),
                    false => f64::INFINITY,
                },
                shear: add_scaled(moved, -pressed, pad.normal).map(|u| -across * u),
                closed: false,
            }
        };
        pads.iter().map(point).collect()
    }
}

/// Adds a further spring of the same side.
fn join<const D: usize>(bed: &mut BedSolution<D>, further: BedSolution<D>) {
    for (at, more) in bed.points.iter_mut().zip(further.points) {
        at.pressure += more.pressure;
        at.gap = at.gap.min(more.gap);
        at.shear = add_scaled(at.shear, 1.0, more.shear);
    }
    bed.compression_only |= further.compression_only;
    bed.resultant = add_scaled(bed.resultant, 1.0, further.resultant);
}

/// Tells where it presses, beyond the rounding of its pressures and of the largest load; without a spring that presses nothing is left.
fn finish<const D: usize>(bed: &mut BedSolution<D>, load: f64) {
    let pressures = bed.points.iter().map(|at| at.pressure.abs());
    let none = NONE * pressures.fold(load / bed.area(), f64::max);
    for at in &mut bed.points {
        at.closed = at.pressure > none;
        at.gap = if at.gap.is_finite() { at.gap } else { 0.0 };
    }
}

fn sum<const D: usize>(forces: &[Point<D>]) -> Point<D> {
    let forces = forces.iter();
    forces.fold([0.0; D], |sum, &force| add_scaled(sum, 1.0, force))
}
