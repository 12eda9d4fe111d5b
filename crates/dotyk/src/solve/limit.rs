//! The part of a load that friction bears.
//!
//! ```text
//!   Gλ = e − (1 − s) h,      h the load on motions that no normal force resists,      s as large as has an answer
//! ```
//!
//! Bodies that are pressed onto each other (a shaft in its hub, a pin in its hole) slide where friction does not bear the load with
//! the normal forces that the elasticity of the bodies gives, although larger normal forces would balance it. Then a part of the load
//! has an answer and the whole has none, and at the largest part friction is exhausted. The part is found by bisection; each answer
//! is the start of the next problem.

use crate::solve::dot;
use crate::solve::setup::{Forces, Setup};
use crate::solve::states::State;
use crate::solve::system::{LOOSE, System};

/// Bisections of a load: three digits.
const BISECTIONS: usize = 12;

/// At the largest load that friction bears it is exhausted, but for this part.
const SPARE: f64 = 0.05;

/// The motion, amplitudes (r,), on which friction does not bear the load of a problem, and the part of the load along it that it
/// bears; `None` where there is another reason why there is no answer.
///
/// `answer` solves a problem, from forces or from anywhere.
pub(crate) fn limit(
    setup: &Setup<'_>,
    answer: &dyn Fn(&Setup<'_>, Option<&Forces>) -> Option<Forces>,
) -> Option<(Vec<f64>, f64)> {
    let (motions, load) = loose(setup)?;
    let bears = |part: f64, from: Option<&Forces>| {
        let mut given = setup.with_admissible(setup.admissible.clone());
        let rest = setup.balance.load().iter().zip(&load);
        let rest = rest.map(|(e, held)| e - (1.0 - part) * held);
        given.balance.set_load(rest.collect());
        let near = from.and_then(|from| answer(&given, Some(from)));
        near.or_else(|| answer(&given, None))
    };
    let mut before = bears(0.0, None)?;
    let (mut low, mut high, mut last) = (0.0, 1.0, None);
    for _ in 0..BISECTIONS {
        let part = 0.5 * (low + high);
        match bears(part, Some(last.as_ref().unwrap_or(&before))) {
            Some(forces) => {
                before = last.replace(forces).unwrap_or(before);
                low = part;
            }
            None => high = part,
        }
    }
    let last = last?;
    // how the bodies have moved for the last part of the load, along the motions that friction alone resists
    let moved = last.alpha.iter().zip(&before.alpha);
    let moved: Vec<f64> = moved.map(|(now, then)| now - then).collect();
    let mut along = vec![0.0; moved.len()];
    for z in &motions {
        let part = dot(z, &moved);
        along.iter_mut().zip(z).for_each(|(a, z)| *a += part * z);
    }
    let exhausted = exhausted(setup, &last.lambda, &along) >= 1.0 - SPARE;
    exhausted.then(|| (setup.multipliers(&last.lambda, &along).alpha, low))
}

/// Motions that no normal force resists, orthonormal amplitudes (k,), and the load on them (r,); `None` where there is no such motion.
fn loose(setup: &Setup<'_>) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
    let bounds = setup.admissible.bounds(&vec![0.0; setup.len()]);
    let smooth = setup.with_admissible(setup.admissible.with_bounds(&bounds));
    let blocks = smooth.admissible.blocks().iter();
    let closed: Vec<State> = blocks.map(|block| State::sticking(block, true)).collect();
    let motions = System::of(&smooth, &closed, None, &setup.problem.softness).loose;
    let mut pulls = vec![0.0; setup.len()];
    for z in &motions {
        let load = dot(z, setup.balance.target());
        setup.balance.add_transposed(load, z, &mut pulls);
    }
    let load = setup.balance.modes().product(&pulls);
    (!motions.is_empty()).then_some((motions, load))
}

/// Used part of the bounds of friction that resists a motion α̂ (k,): Σ‖λₜ‖ over Σ bound; 0 if none resists. Shapes: λ (m,).
fn exhausted(setup: &Setup<'_>, lambda: &[f64], along: &[f64]) -> f64 {
    let mut motion = vec![0.0; setup.len()];
    setup.balance.add_transposed(1.0, along, &mut motion);
    let size = motion.iter().fold(0.0, |s: f64, u| s.max(u.abs()));
    let bounds = setup.admissible.bounds(lambda);
    let (mut borne, mut most) = (0.0, 0.0);
    for ((block, range), bound) in setup.admissible.iter().zip(bounds) {
        let tangents = block.shear(&range);
        if tangents.clone().any(|i| motion[i].abs() > LOOSE * size) {
            borne += lambda[tangents].iter().map(|t| t * t).sum::<f64>().sqrt();
            most += bound;
        }
    }
    if size > 0.0 && most > 0.0 {
        borne / most
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use crate::dual::{Compliance, DualProblem, Friction};
    use crate::linalg::Mat;
    use crate::solve::tests::{of, silent};
    use crate::solve::{ContactSolver, Newton, SolveError};

    /// A node that is pressed by an overlap of 1 and drawn aside, where nothing but friction holds it.
    fn pressed(load: f64) -> DualProblem {
        let f = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 0.1 });
        let block = Friction::Coulomb { coefficient: 0.5 }.block(1);
        let balance = (&[vec![0.0, 1.0]][..], &[load][..]);
        of(Compliance::Dense(f), &[1.0, 0.0], vec![block], balance)
    }

    /// λₙ + 0.1 λₜ = 1 and λₜ = 0.5 λₙ.
    const MOST: f64 = 0.5 / 1.05;

    #[test]
    fn load_beyond_what_normal_forces_let_friction_bear_slides_with_its_part() {
        let held = Newton::default().solve(&pressed(0.99 * MOST), None, &mut silent);
        assert!((held.unwrap().multipliers.lambda[1] - 0.99 * MOST).abs() < 1e-9);
        for load in [1.01 * MOST, 3.0] {
            match Newton::default().solve(&pressed(load), None, &mut silent) {
                Err(SolveError::Slides { direction, factor }) => {
                    assert!((factor * load / MOST - 1.0).abs() < 1e-2, "{factor}");
                    assert!(direction.len() == 1 && direction[0] > 0.0);
                }
                other => panic!("{other:?}"),
            }
        }
    }
}
