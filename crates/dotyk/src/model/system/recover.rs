//! From multipliers to displacements: those of every body, its internal forces and its reactions.
//!
//! u = u_D + K⁺(f − K u_D − Bᵀλ) + Rα, the elastic part refined until the forces of the body balance.

use crate::dual::{IMBALANCE_LIMIT, ROUNDING, Scales};
use crate::fem::{FemError, internal_forces, spring_forces, spring_loads};
use crate::geometry::{Point, add_scaled, centroid, cross, dot, norm, sub};
use crate::model::nouns::error::Error;
use crate::model::nouns::model::{Analysis, Body, Model};
use crate::model::system::bodies::LoadedBody;
use crate::model::system::factor::FactoredBody;
use crate::model::system::floating::Floating;

/// u_D + K⁺(f − K u_D − Bᵀλ) less the rigid motion that u_D contains: the part that strains the body. One solve for both, because
/// load and contact forces alone may each bend a slender body far more than both together. `before` are a displacement to go on
/// from and the change of the contact forces since.
pub(crate) fn elastic_displacement<const D: usize>(
    body: &LoadedBody<D>,
    factored: &FactoredBody,
    lambda: &[f64],
    before: Option<(&[f64], &[f64])>,
) -> Vec<f64> {
    if before.is_none()
        && let Some(u) = factored.completed(body, lambda)
    {
        return u;
    }
    let (mut u, base, pushing) = match before {
        Some((displacement, change)) => (vec![0.0; displacement.len()], displacement, change),
        None => (body.reduced_load.clone(), &body.system.lift[..], lambda),
    };
    body.rows.add_forces(-1.0, pushing, &mut u);
    factored.factor.solve(&mut u);
    u.iter_mut().zip(base).for_each(|(u, base)| *u += base);
    u
}

/// The rigid motion that u_D contains, and Rα. A large motion is kept apart from the displacement that strains the body:
/// added up, small strains would drown in its rounding.
pub(crate) fn rigid_displacement<const D: usize>(
    body: &LoadedBody<D>,
    floating: &Floating,
    amplitudes: &[f64],
    index: usize,
) -> Vec<f64> {
    let mut u = body.system.carried.clone();
    for (&(owner, mode), &a) in floating.modes.iter().zip(amplitudes) {
        if owner == index {
            u.iter_mut()
                .zip(&body.system.modes[mode])
                .for_each(|(u, r)| *u += a * r);
        }
    }
    u
}

/// Displacements, forces and energies of one body in global axes.
pub(crate) struct BodyState<const D: usize> {
    pub u: Vec<Point<D>>,
    pub reactions: Vec<Point<D>>,
    /// Forces of each of its springs ON the body, (springs,) and (nodes,).
    pub springs: Vec<Vec<Point<D>>>,
    /// Forces of all contacts.
    pub contact_forces: Vec<Point<D>>,
    /// External, support, spring and contact force of every node.
    pub total: Vec<Point<D>>,
    pub strain_energy: f64,
    /// Area with a plastic strain, in space volume.
    pub yielded: f64,
    /// 1/2 uᵀKu of its springs.
    pub spring_energy: f64,
    /// 2·(strain energy and that of springs) − (f + R)·(elastic displacement): minus the work of the contact forces on it, when all forces
    /// balance.
    pub unbalanced_work: f64,
    /// The part of it that is rounding of its terms.
    pub work_rounding: f64,
    /// Largest resultant of a support that moves.
    pub driving_force: f64,
    /// Uncertainty of resultants of the nodal forces, which are differences of terms of the size K_ii u_i.
    pub rounding: f64,
}

/// State of a body, its elastic displacement refined until its forces balance; `parts` are the elastic and the rigid
/// displacement.
///
/// The factorisation leaves residuals of the size of rounding times |K||u|, which a slender body turns into a resultant;
/// one or two corrections by K⁺ with the residual of [`internal_forces`] remove it.
pub(crate) fn balanced_state<const D: usize>(
    model: &Model<D>,
    body: &Body<D>,
    loaded: &LoadedBody<D>,
    factored: &FactoredBody,
    parts: [Vec<f64>; 2],
    lambda: &[f64],
    scales: &Scales,
) -> Result<(BodyState<D>, Vec<f64>), Error<D>> {
    let force = lambda
        .iter()
        .fold(scales.force, |largest, l| largest.max(l.abs()));
    let fail = |source| Error::in_body(body, source);
    let [mut elastic, rigid] = parts;
    let mut refinements = 0;
    loop {
        let (state, residual) =
            BodyState::new(model, body, loaded, [&elastic, &rigid], lambda).map_err(fail)?;
        let force = force.max(state.driving_force);
        let (f, m) = imbalance(model, body.mesh.points(), &state.total);
        let worst = f.max(m / scales.moment_arm);
        if worst <= 0.1 * IMBALANCE_LIMIT * force || refinements == 2 {
            return Ok((state, elastic));
        }
        refinements += 1;
        let mut correction = residual;
        factored.factor.correct(&mut correction);
        elastic
            .iter_mut()
            .zip(&correction)
            .for_each(|(u, c)| *u += c);
    }
}

impl<const D: usize> BodyState<D> {
    /// The state, and the residual f − Bᵀλ − f_int of its free dofs in the node frames.
    fn new(
        model: &Model<D>,
        body: &Body<D>,
        loaded: &LoadedBody<D>,
        [u, rigid]: [&[f64]; 2],
        lambda: &[f64],
    ) -> Result<(Self, Vec<f64>), FemError> {
        let system = &loaded.system;
        let global = system.to_global(u);
        let (forces, strain_energy) = internal_forces(body, model.analysis, &global)?;
        // free rigid motions stretch no spring
        let mut springs = spring_forces(body, model.analysis, &global)?;
        let mut stretched = vec![[0.0; D]; global.len()];
        for own in &springs {
            let both = stretched.iter_mut().zip(own);
            both.for_each(|(sum, &force)| *sum = add_scaled(*sum, 1.0, force));
        }
        let stored = stretched.iter().zip(&global);
        let spring_energy: f64 = stored.map(|(&f, &u)| 0.5 * dot(f, u)).sum();
        let in_frames = |forces: &[Point<D>]| {
            let mut forces = forces.concat();
            system.to_frames(&mut forces);
            forces
        };
        let (mut internal, sprung) = (in_frames(&forces), in_frames(&stretched));
        internal.iter_mut().zip(&sprung).for_each(|(f, k)| *f += k);
        let mut push = vec![0.0; u.len()];
        loaded.rows.add_forces(1.0, lambda, &mut push);
        let (mut reactions, mut total, mut residual) =
            (vec![0.0; u.len()], vec![0.0; u.len()], vec![0.0; u.len()]);
        for i in 0..u.len() {
            if system.held[i] {
                reactions[i] = internal[i] - system.load[i] + push[i];
            } else {
                residual[i] = system.load[i] - push[i] - internal[i];
            }
            total[i] = system.load[i] + reactions[i] - push[i] - sprung[i];
        }
        let applied = system.load.iter().zip(&reactions).map(|(f, r)| f + r);
        let external: f64 = applied.zip(u).map(|(force, u)| force * u).sum();
        let sizes = (system.load.iter().zip(&reactions)).map(|(f, r)| f.abs() + r.abs());
        let worked: f64 = sizes.zip(u).map(|(size, u)| size * u.abs()).sum();
        let mut whole: Vec<f64> = u.iter().zip(rigid).map(|(u, r)| u + r).collect();
        for (dof, u) in whole.iter_mut().enumerate().filter(|d| system.held[d.0]) {
            *u = system.prescribed[dof];
        }
        let reactions = of_supports(loaded, system.to_global(&reactions));
        for force in springs.iter_mut().flatten().flatten() {
            *force = -*force;
        }
        for (place, came) in spring_loads((body, &system.history), model.analysis)? {
            for (force, came) in springs[place].iter_mut().zip(came) {
                *force = add_scaled(*force, 1.0, came);
            }
        }
        let state = Self {
            u: system.to_global(&whole),
            driving_force: driving_force(body, loaded, &reactions),
            rounding: ROUNDING * norm_of_terms(&system.stiffness.diagonal(), u),
            reactions,
            springs,
            contact_forces: system.to_global(&push.iter().map(|force| -force).collect::<Vec<_>>()),
            total: system.to_global(&total),
            strain_energy,
            yielded: 0.0,
            spring_energy,
            unbalanced_work: 2.0 * (strain_energy + spring_energy) - external,
            work_rounding: ROUNDING * worked,
        };
        Ok((state, residual))
    }
}

/// √Σ(K_ii u_i)².
fn norm_of_terms(diagonal: &[f64], u: &[f64]) -> f64 {
    let terms = diagonal.iter().zip(u).map(|(k, u)| k * u);
    terms.map(|term| term * term).sum::<f64>().sqrt()
}

/// Unbalanced resultant force, and moment about the centroid.
pub(crate) fn imbalance<const D: usize>(
    model: &Model<D>,
    points: &[Point<D>],
    total: &[Point<D>],
) -> (f64, f64) {
    let resultant = total
        .iter()
        .fold([0.0; D], |sum, &f| add_scaled(sum, 1.0, f));
    if model.analysis == Analysis::Axisymmetric {
        // radial forces balance over the full turn, and moments vanish
        return (resultant[1].abs(), 0.0);
    }
    let centre = centroid(points);
    let mut moment = [0.0; 3];
    for (&x, &f) in points.iter().zip(total) {
        moment = add_scaled(moment, 1.0, cross(sub(x, centre), f));
    }
    (norm(resultant), norm(moment))
}

/// Forces without those that the axis of symmetry holds, which come from no support.
fn of_supports<const D: usize>(
    loaded: &LoadedBody<D>,
    mut reactions: Vec<Point<D>>,
) -> Vec<Point<D>> {
    for (&node, held) in &loaded.system.constraints.nodes {
        for h in held.iter().filter(|h| h.supports.is_empty()) {
            let part = dot(reactions[node], h.axis);
            reactions[node] = add_scaled(reactions[node], -part, h.axis);
        }
    }
    reactions
}

/// Largest resultant of a support with a prescribed displacement other than zero.
fn driving_force<const D: usize>(
    body: &Body<D>,
    loaded: &LoadedBody<D>,
    reactions: &[Point<D>],
) -> f64 {
    let mut sums = vec![[0.0; D]; body.supports.len()];
    for (&node, held) in &loaded.system.constraints.nodes {
        for h in held.iter().filter(|h| h.value != 0.0) {
            let part = dot(reactions[node], h.axis) / h.supports.len() as f64;
            for &support in &h.supports {
                sums[support] = add_scaled(sums[support], part, h.axis);
            }
        }
    }
    sums.into_iter().map(norm).fold(0.0, f64::max)
}
