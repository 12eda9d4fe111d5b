//! From multipliers to the answer: displacements, stresses, reactions, contact state, and the certificate.
//!
//! u = u_D + K⁺(f − K u_D − Bᵀλ) + Rα for every body. The gaps, reactions, resultants and energies of the certificate
//! are computed from u and λ afresh, not taken from F and d, so that an error of the condensation cannot hide.
//! Its energy gap is that of the potential and the complementary energy, Π(u) − Π*(σ, λ) = λ·gap − r·u, with r what the
//! nodal forces of any body leave unbalanced.

use crate::contact::{Coupling, InterfaceNode, Role, Row, frame};
use crate::dual::{
    AdmissibleSet, Block, Certificate, Component, DualProblem, IMBALANCE_LIMIT, Multipliers,
    ROUNDING, Recomputed, Scales,
};
use crate::fem::{
    FemError, RigidBasis, Short, describe_motion, fit_rigid, internal_forces, recover_stress,
    von_mises,
};
use crate::geometry::{Point, add_scaled, bounding_box, cross, dot, norm, sub};
use crate::linalg::SparseVector;
use crate::model::between::{Moved, Overlap, worst_overlap};
use crate::model::condense::{FactoredBody, LoadedBody, initial_gaps};
use crate::model::error::Error;
use crate::model::floating::{Floating, add_rows, settle};
use crate::model::nouns::{Analysis, Body, Model, Place, SideRef};
use crate::model::pair::Paired;
use crate::model::pipeline::Condensed;
use crate::model::solution::*;
use crate::solve::{Outcome, distance_to_exact};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Displacements and forces of all bodies, judged but not yet dressed up.
pub(crate) struct Judged<const D: usize> {
    states: Vec<BodyState<D>>,
    /// Displacements of the free obstacles.
    obstacles: Vec<Point<D>>,
    /// Gaps of all multipliers from the displacements.
    pub gaps: Vec<f64>,
    /// To what these are known.
    pub rounding: Vec<f64>,
    /// The part of the displacements that strains each body.
    strained: Vec<Vec<f64>>,
    /// What was checked.
    pub certificate: Certificate,
    /// Bodies that touch nothing and carry no load.
    pub hovering: Vec<String>,
    /// Where two sides overlap most between their nodes.
    pub overlap: Option<Overlap<D>>,
}

/// Displacements of all bodies under some contact forces, and their certificate; if some were found `before`, as what a change
/// of the forces (m,) adds to these: rounding, which a slender body magnifies, is then the same in both, and a correction does
/// what it should.
pub(crate) fn judge<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    outcome: &Outcome,
    before: Option<(&Judged<D>, &[f64])>,
) -> Result<Judged<D>, Error<D>> {
    let Condensed {
        bodies,
        factored,
        floating,
        problem,
        ..
    } = condensed;
    let multipliers = &outcome.multipliers;
    let lambda = &multipliers.lambda;
    let amplitudes = floating.amplitudes(&multipliers.alpha);
    let elastic: Vec<Vec<f64>> = bodies
        .par_iter()
        .zip(factored)
        .enumerate()
        .map(|(index, (body, factored))| {
            let before = before.map(|(judged, change)| (&judged.strained[index][..], change));
            elastic_displacement(body, factored, lambda, before)
        })
        .collect();
    let mut rigid: Vec<Vec<f64>> = bodies
        .iter()
        .enumerate()
        .map(|(index, body)| rigid_displacement(body, floating, &amplitudes, index))
        .collect();
    let mut gaps = condensed.gaps.clone();
    add_rows(bodies, -1.0, &rigid, &mut gaps);
    add_rows(bodies, -1.0, &elastic, &mut gaps);
    let (open, hovering) = open_motions(model, bodies, floating, problem, lambda);
    if !open.is_empty() {
        settle(bodies, floating, &open, &elastic, &mut rigid, &mut gaps);
    }
    let states = (&model.bodies, bodies, factored, elastic, &rigid)
        .into_par_iter()
        .map(|(body, loaded, factored, elastic, rigid)| {
            balanced_state(
                model,
                body,
                loaded,
                factored,
                [elastic, rigid.clone()],
                lambda,
                problem.scales,
            )
        })
        .collect::<Result<Vec<_>, _>>()?;
    let (states, elastic): (Vec<_>, Vec<_>) = states.into_iter().unzip();
    // rigid motions first: they may cancel a clearance that is large beside the strains
    let mut gaps = condensed.gaps.clone();
    add_rows(bodies, -1.0, &rigid, &mut gaps);
    let clearances = gaps.clone();
    add_rows(bodies, -1.0, &elastic, &mut gaps);
    let obstacles = rigid[model.bodies.len()..].iter();
    let obstacles: Vec<Point<D>> = obstacles.map(|u| std::array::from_fn(|i| u[i])).collect();
    let moved = elastic.iter().chain(&rigid).flatten();
    let rounding = 4.0 * ROUNDING * moved.fold(0.0, |s: f64, u| s.max(u.abs()));
    let negligible = model.solver.tolerance * problem.scales.length + rounding;
    let overlap = deepest_overlap(model, condensed, &states, &obstacles, lambda, negligible);
    let terms = |u: &[f64]| ROUNDING * u.iter().fold(0.0, |s: f64, u| s.max(u.abs()));
    let mut rounding: Vec<f64> = condensed.gaps.iter().map(|g| ROUNDING * g.abs()).collect();
    for (body, u) in bodies.iter().zip(elastic.iter().zip(&rigid)) {
        let size = terms(u.0) + terms(u.1);
        body.rows
            .index
            .iter()
            .for_each(|&row| rounding[row] += size);
    }
    let certificate = certify(
        model,
        &states,
        condensed,
        multipliers,
        Seen {
            gaps: &gaps,
            clearances: &clearances,
            rounding: &rounding,
            implied: implied_violation(model, condensed, &states, &obstacles),
            exact: match outcome.exact {
                true => 0.0,
                false => distance_to_exact(problem, multipliers).unwrap_or(0.0),
            },
            between: overlap.map_or([0.0, 1.0], |o| [o.depth, o.resolved]),
        },
    );
    Ok(Judged {
        states,
        obstacles,
        gaps,
        rounding,
        strained: elastic,
        certificate,
        hovering,
        overlap,
    })
}

/// What each contact of a model moves with.
fn moved<'a, const D: usize>(
    model: &Model<D>,
    pair: &Paired<D>,
    states: &'a [BodyState<D>],
    obstacles: &[Point<D>],
) -> Moved<'a, D> {
    Moved {
        own: &states[pair.nonmortar.body.0].u,
        other: pair.mortar.as_ref().map(|side| &states[side.body.0].u[..]),
        obstacle: match (&pair.mortar, pair.opposite) {
            (None, Some(part)) => obstacles[part - model.bodies.len()],
            _ => pair.obstacle_motion,
        },
    }
}

/// The worst overlap between the nodes of all contacts.
fn deepest_overlap<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    states: &[BodyState<D>],
    obstacles: &[Point<D>],
    lambda: &[f64],
    negligible: f64,
) -> Option<Overlap<D>> {
    let mut start = 0;
    let mut worst: Option<Overlap<D>> = None;
    for (contact, pair) in condensed.paired.iter().enumerate() {
        let rows = start..start + pair.interface.nonmortar.len();
        start = rows.end;
        let moved = moved(model, pair, states, obstacles);
        let found = worst_overlap(contact, pair, &moved, &lambda[rows], negligible);
        let deeper = |w: Overlap<D>, f: &Overlap<D>| f.depth * w.resolved > w.depth * f.resolved;
        if let Some(found) = found.filter(|f| worst.is_none_or(|w| deeper(w, f))) {
            worst = Some(found);
        }
    }
    worst
}

/// Largest violation of a condition without a multiplier, a length.
fn implied_violation<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    states: &[BodyState<D>],
    obstacles: &[Point<D>],
) -> f64 {
    let mut worst = 0.0f64;
    for pair in &condensed.paired {
        let moved = moved(model, pair, states, obstacles);
        let tied = pair.interface.coupling == Coupling::Tied;
        for condition in pair
            .interface
            .implied
            .iter()
            .filter(|c| tied || c.component == 0)
        {
            let [own, other] = &condition.rows;
            let along = |row: &Row<D>, u: &dyn Fn(usize) -> Point<D>| -> f64 {
                row.iter().map(|&(node, c)| dot(c, u(node))).sum()
            };
            let gap = match condition.component {
                0 => pair.interface.nodes[condition.node].gap,
                _ => 0.0,
            };
            let other = match moved.other {
                Some(u) => along(other, &|node| u[node]),
                None => along(other, &|_| moved.obstacle),
            };
            let gap = gap - along(own, &|node| moved.own[node]) - other;
            worst = worst.max(if tied { gap.abs() } else { -gap });
        }
    }
    worst
}

/// What the certificate sees of the displacements.
struct Seen<'a> {
    gaps: &'a [f64],
    /// Gaps after the rigid motions alone.
    clearances: &'a [f64],
    /// To what the gaps are known.
    rounding: &'a [f64],
    implied: f64,
    /// By how much exact steps change a force.
    exact: f64,
    between: [f64; 2],
}

/// Most contacts that a warning names.
const NAMED: usize = 4;

/// A polygon's distance from its curve matters when it is more than this part of the displacement jump.
const SAGITTA: f64 = 0.01;

impl<const D: usize> Judged<D> {
    /// Relative tangential displacements in the rows under friction, zero in the others, (m,).
    pub fn slip(&self, condensed: &Condensed<D>) -> Vec<f64> {
        let tangential = condensed
            .paired
            .iter()
            .flat_map(|p| p.interface.tangential());
        // gap = g₀ + slip at the last step − slip now
        let undeformed = initial_gaps(&condensed.paired);
        let slips = condensed.gaps.iter().zip(&undeformed).zip(&self.gaps);
        tangential
            .zip(slips)
            .map(|(is, ((before, g0), after))| if is { before - g0 - after } else { 0.0 })
            .collect()
    }

    /// A warning about gaps that were measured between polygons which stand for curves.
    pub fn crude_gaps(&self, model: &Model<D>, condensed: &Condensed<D>) -> Option<String> {
        let mut start = 0;
        let mut crude: Vec<(f64, f64, &str)> = Vec::new();
        for (contact, pair) in model.contacts.iter().zip(&condensed.paired) {
            let rows = start..start + pair.interface.nonmortar.len();
            start = rows.end;
            let jumps = rows.map(|row| (self.gaps[row] - condensed.gaps[row]).abs());
            let jump = jumps.fold(0.0, f64::max);
            if pair.sagitta > SAGITTA * jump {
                crude.push((pair.sagitta, jump, &contact.name));
            }
        }
        let worst = crude
            .iter()
            .max_by(|a, b| (a.0 * b.1).total_cmp(&(b.0 * a.1)))?;
        let names: Vec<String> = crude
            .iter()
            .map(|(.., name)| format!("\"{name}\""))
            .collect();
        let more = match names.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        Some(format!(
            "contact {}{more}: polygons stand for curves from which they are up to {} away, where the displacement jump is {}: measured gaps are too crude; set gap = \"closed\", or give the true `surface` of both sides, or use quadratic cells",
            names[..names.len().min(NAMED)].join(", "),
            Short(worst.0),
            Short(worst.1)
        ))
    }

    /// Stresses, reactions and contact state.
    ///
    /// Errors: a group of cells without a material.
    pub fn dress(
        self,
        model: &Model<D>,
        condensed: &Condensed<D>,
        lambda: &[f64],
    ) -> Result<(Vec<BodySolution<D>>, Vec<ContactSolution<D>>), Error<D>> {
        let contacts = self.contact_solutions(model, condensed, lambda);
        let bodies = model
            .bodies
            .par_iter()
            .zip(&condensed.bodies)
            .zip(self.states)
            .map(|((body, loaded), state)| body_solution(model, body, loaded, state))
            .collect::<Result<Vec<_>, _>>()?;
        Ok((bodies, contacts))
    }
}

impl<const D: usize> Judged<D> {
    fn contact_solutions(
        &self,
        model: &Model<D>,
        Condensed {
            paired, problem, ..
        }: &Condensed<D>,
        lambda: &[f64],
    ) -> Vec<ContactSolution<D>> {
        let mut start = 0;
        let mut contacts = Vec::new();
        let bounds = shear_bounds(&problem.admissible, lambda);
        for (contact, pair) in model.contacts.iter().zip(paired) {
            let rows = start..start + pair.interface.nonmortar.len();
            start = rows.end;
            let obstacle = moved(model, pair, &self.states, &self.obstacles).obstacle;
            contacts.push(contact_solution(
                model,
                &contact.name,
                pair,
                (&self.states, obstacle),
                Rows {
                    gaps: &self.gaps[rows.clone()],
                    lambda: &lambda[rows.clone()],
                    bounds: &bounds[rows],
                },
            ));
        }
        contacts
    }
}

/// u_D + K⁺(f − K u_D − Bᵀλ) less the rigid motion that u_D contains: the part that strains the body. In one solve: load
/// and contact forces alone may each bend a slender body far more than both together. `before` are a displacement to go on from
/// and the change of the contact forces since.
fn elastic_displacement<const D: usize>(
    body: &LoadedBody<D>,
    factored: &FactoredBody,
    lambda: &[f64],
    before: Option<(&[f64], &[f64])>,
) -> Vec<f64> {
    let pushing = before.map_or(lambda, |(_, change)| change);
    let push: Vec<f64> = body.rows.index.iter().map(|&row| -pushing[row]).collect();
    let (mut u, base) = match before {
        Some((displacement, _)) => (vec![0.0; displacement.len()], displacement),
        None => (body.reduced_load.clone(), &body.system.lift[..]),
    };
    body.rows.matrix.mul_transpose_add(&push, &mut u);
    factored.factor.solve(&mut u);
    u.iter_mut().zip(base).for_each(|(u, base)| *u += base);
    u
}

/// The rigid motion that u_D contains, and Rα. A large motion is kept apart from the displacement that strains the body:
/// added up, small strains would drown in its rounding.
fn rigid_displacement<const D: usize>(
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

/// Combinations of modes that the contact forces leave open, and the bodies that hover.
fn open_motions<const D: usize>(
    model: &Model<D>,
    bodies: &[LoadedBody<D>],
    floating: &Floating,
    problem: &DualProblem,
    lambda: &[f64],
) -> (Vec<SparseVector>, Vec<String>) {
    let r = floating.modes.len();
    let mut open = floating.uncontrolled.clone();
    let force = lambda
        .iter()
        .fold(problem.scales.force, |s, l| s.max(l.abs()));
    let components = problem.admissible.components();
    let mut hovering = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        // a tie holds without force, too
        let touched =
            body.rows.index.iter().any(|&row| {
                lambda[row].abs() > 1e-12 * force || components[row] == Component::Free
            });
        if body.system.modes.is_empty() || touched {
            continue;
        }
        hovering.push(model.part_name(index));
        for (k, _) in floating
            .modes
            .iter()
            .enumerate()
            .filter(|(_, mode)| mode.0 == index)
        {
            open.push(SparseVector::new(r, [(k, 1.0)]));
        }
    }
    (open, hovering)
}

/// Displacements, forces and energies of one body in global axes.
struct BodyState<const D: usize> {
    u: Vec<Point<D>>,
    reactions: Vec<Point<D>>,
    /// External, support and contact force of every node.
    total: Vec<Point<D>>,
    strain_energy: f64,
    /// 2·(strain energy) − (f + R)·(elastic displacement): minus the work of the contact forces on it, when all forces
    /// balance.
    unbalanced_work: f64,
    /// Largest resultant of a support that moves.
    driving_force: f64,
    /// To what resultants of the nodal forces are known: these are differences of terms of the size K_ii u_i.
    rounding: f64,
}

/// State of a body, its elastic displacement refined until its forces balance; `parts` are the elastic and the rigid
/// displacement.
///
/// The factorisation leaves residuals of the size of rounding times |K||u|, which a slender body turns into a resultant;
/// one or two corrections by K⁺ with the residual of [`internal_forces`] remove it.
fn balanced_state<const D: usize>(
    model: &Model<D>,
    body: &Body<D>,
    loaded: &LoadedBody<D>,
    factored: &FactoredBody,
    parts: [Vec<f64>; 2],
    lambda: &[f64],
    scales: Scales,
) -> Result<(BodyState<D>, Vec<f64>), Error<D>> {
    let force = lambda
        .iter()
        .fold(scales.force, |largest, l| largest.max(l.abs()));
    let fail = |source| Error::Body {
        body: body.name.clone(),
        source,
    };
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
        factored.factor.solve(&mut correction);
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
        let mut internal: Vec<f64> = forces.iter().flatten().copied().collect();
        system.to_frames(&mut internal);
        let local: Vec<f64> = loaded.rows.index.iter().map(|&row| lambda[row]).collect();
        let mut push = vec![0.0; u.len()];
        loaded.rows.matrix.mul_transpose_add(&local, &mut push);
        let (mut reactions, mut total, mut residual) =
            (vec![0.0; u.len()], vec![0.0; u.len()], vec![0.0; u.len()]);
        for i in 0..u.len() {
            if system.held[i] {
                reactions[i] = internal[i] - system.load[i] + push[i];
            } else {
                residual[i] = system.load[i] - push[i] - internal[i];
            }
            total[i] = system.load[i] + reactions[i] - push[i];
        }
        let applied = system.load.iter().zip(&reactions).map(|(f, r)| f + r);
        let external: f64 = applied.zip(u).map(|(force, u)| force * u).sum();
        let mut whole: Vec<f64> = u.iter().zip(rigid).map(|(u, r)| u + r).collect();
        for (dof, u) in whole.iter_mut().enumerate().filter(|d| system.held[d.0]) {
            *u = system.prescribed[dof];
        }
        let reactions = of_supports(loaded, system.to_global(&reactions));
        let state = Self {
            u: system.to_global(&whole),
            driving_force: driving_force(body, loaded, &reactions),
            rounding: ROUNDING * norm_of_terms(&system.stiffness.diagonal(), u),
            reactions,
            total: system.to_global(&total),
            strain_energy,
            unbalanced_work: 2.0 * strain_energy - external,
        };
        Ok((state, residual))
    }
}

fn certify<const D: usize>(
    model: &Model<D>,
    states: &[BodyState<D>],
    condensed: &Condensed<D>,
    multipliers: &Multipliers,
    seen: Seen<'_>,
) -> Certificate {
    let (mut force, mut moment) = (0.0f64, 0.0f64);
    for (body, state) in model.bodies.iter().zip(states) {
        let (f, m) = imbalance(model, body.mesh.points(), &state.total);
        let arm = condensed.problem.scales.moment_arm;
        force = force.max(f - state.rounding);
        moment = moment.max(m - state.rounding * arm);
    }
    for obstacle in &condensed.bodies[model.bodies.len()..] {
        force = force.max(unbalanced(obstacle, &multipliers.lambda));
    }
    let elastic_energy: f64 = states.iter().map(|state| state.strain_energy).sum();
    // the gap of potential and complementary energy: the sum over the bodies of 2·energy − f·u − R·u_D, and λ·g₀
    let work: f64 = states.iter().map(|state| state.unbalanced_work).sum();
    let on_gaps: f64 = multipliers
        .lambda
        .iter()
        .zip(seen.clearances)
        .map(|(l, g)| l * g)
        .sum();
    // friction takes its share, bound · |slip|: λ·gap of the tangential rows is minus that where its law holds
    let admissible = &condensed.problem.admissible;
    let friction = admissible.slip_potential(&multipliers.lambda, |i| seen.gaps[i]);
    let recomputed = Recomputed {
        gap: seen.gaps,
        rounding: seen.rounding,
        implied: seen.implied,
        exact: seen.exact,
        between: seen.between,
        imbalance_force: force,
        imbalance_moment: moment,
        energy_gap: (work + on_gaps + friction).abs(),
        elastic_energy,
        driving_force: states.iter().map(|s| s.driving_force).fold(0.0, f64::max),
    };
    condensed
        .problem
        .certify_with(multipliers, &recomputed, model.solver.tolerance)
}

/// √Σ(K_ii u_i)².
fn norm_of_terms(diagonal: &[f64], u: &[f64]) -> f64 {
    let terms = diagonal.iter().zip(u).map(|(k, u)| k * u);
    terms.map(|term| term * term).sum::<f64>().sqrt()
}

/// What is left of the forces on a free obstacle.
fn unbalanced<const D: usize>(obstacle: &LoadedBody<D>, lambda: &[f64]) -> f64 {
    let local: Vec<f64> = obstacle
        .rows
        .index
        .iter()
        .map(|&row| -lambda[row])
        .collect();
    let mut rest = obstacle.system.load.clone();
    obstacle.rows.matrix.mul_transpose_add(&local, &mut rest);
    let free = rest
        .iter()
        .zip(&obstacle.system.held)
        .filter(|(_, held)| !**held);
    free.map(|(f, _)| f * f).sum::<f64>().sqrt()
}

/// Resultant force and moment about the centroid that are left over.
fn imbalance<const D: usize>(
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

/// Mean of some points.
pub(crate) fn centroid<const D: usize>(points: &[Point<D>]) -> Point<D> {
    let sum = points
        .iter()
        .fold([0.0; D], |sum, &x| add_scaled(sum, 1.0, x));
    sum.map(|c| c / points.len() as f64)
}

fn body_solution<const D: usize>(
    model: &Model<D>,
    body: &Body<D>,
    factored: &LoadedBody<D>,
    state: BodyState<D>,
) -> Result<BodySolution<D>, Error<D>> {
    let stress = recover_stress(body, model.analysis, &state.u).map_err(|source| Error::Body {
        body: body.name.clone(),
        source,
    })?;
    let points = body.mesh.points();
    let basis = RigidBasis::of(model.analysis);
    let (translation, rotation) = fit_rigid(basis, points, &state.u, centroid(points));
    let floating_modes = factored
        .system
        .modes
        .iter()
        .map(|mode| {
            let displacement = factored.system.to_global(mode);
            RigidMode {
                description: describe_motion(points, &displacement),
                displacement,
            }
        })
        .collect();
    Ok(BodySolution {
        name: body.name.clone(),
        von_mises: stress.iter().map(|&s| von_mises(s)).collect(),
        stress,
        side_reactions: side_reactions(body, factored, &state.reactions),
        reaction: state
            .reactions
            .iter()
            .fold([0.0; D], |sum, &f| add_scaled(sum, 1.0, f)),
        reactions: state.reactions,
        floating_modes,
        rigid: RigidMotion {
            translation,
            rotation,
        },
        strain_energy: state.strain_energy,
        dofs: D * points.len(),
        displacement: state.u,
    })
}

/// Without what the axis of symmetry holds: no support does.
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

/// Reactions by the side whose support holds the direction; shared directions are split evenly.
fn side_reactions<const D: usize>(
    body: &Body<D>,
    loaded: &LoadedBody<D>,
    reactions: &[Point<D>],
) -> BTreeMap<String, Point<D>> {
    let mut sums = BTreeMap::new();
    for (&node, held) in &loaded.system.constraints.nodes {
        for h in held {
            let part = dot(reactions[node], h.axis) / h.supports.len() as f64;
            for &support in &h.supports {
                if let Place::Side(side) = &body.supports[support].place {
                    let sum = sums.entry(side.clone()).or_insert([0.0; D]);
                    *sum = add_scaled(*sum, part, h.axis);
                }
            }
        }
    }
    sums
}

/// What the rows of one contact came out as.
struct Rows<'a> {
    gaps: &'a [f64],
    lambda: &'a [f64],
    /// Largest shear force of the nodes with friction, at their normal rows; NaN elsewhere.
    bounds: &'a [f64],
}

/// Largest shear force of every node with friction, at its normal row; NaN elsewhere.
fn shear_bounds(admissible: &AdmissibleSet, lambda: &[f64]) -> Vec<f64> {
    let mut bounds = vec![f64::NAN; lambda.len()];
    for (block, range) in admissible.iter() {
        bounds[range.start] = match *block {
            Block::Tresca { bound, .. } => bound,
            Block::Coulomb { coefficient, .. } => coefficient * lambda[range.start].max(0.0),
            Block::Free { .. } | Block::Unilateral => f64::NAN,
        };
    }
    bounds
}

/// Forces below this part of the largest of a contact are none.
const NONE: f64 = 1e-10;

/// A node slips when its shear force is within this part of its bound.
const AT_BOUND: f64 = 1e-7;

fn contact_solution<const D: usize>(
    model: &Model<D>,
    name: &str,
    pair: &Paired<D>,
    (states, obstacle): (&[BodyState<D>], Point<D>),
    Rows {
        gaps,
        lambda,
        bounds,
    }: Rows<'_>,
) -> ContactSolution<D> {
    let body = &model.bodies[pair.nonmortar.body.0];
    let coupling = pair.interface.coupling;
    // projected methods leave traces of force where a contact is open
    let none = NONE * lambda.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    let node_state = |node: &InterfaceNode<D>| {
        let u_nonmortar = states[pair.nonmortar.body.0].u[node.node];
        let u_mortar = match &pair.mortar {
            Some(_) if node.opposite.is_empty() => None,
            Some(mortar) => {
                let u = &states[mortar.body.0].u;
                let opposite = node.opposite.iter();
                Some(opposite.fold([0.0; D], |sum, &(j, n)| add_scaled(sum, n, u[j])))
            }
            None if node.role == Role::Alone => None,
            None => Some(obstacle),
        };
        let along = |u: Point<D>| dot(node.normal, u);
        let displacement_nonmortar = along(u_nonmortar);
        let displacement_mortar = u_mortar.map_or(f64::NAN, along);
        let slip = u_mortar.map_or([f64::NAN; D], |u| {
            let relative = sub(u_nonmortar, u);
            add_scaled(relative, -along(relative), node.normal)
        });
        let (gap, pressure, status) = match (node.role, node.rows[0]) {
            (Role::Alone, _) => (f64::NAN, 0.0, Status::Open),
            (Role::Multiplier, Some(row)) => {
                let shear = node.rows[1..].iter().flatten().map(|&row| lambda[row]);
                let shear = shear.map(|l| l * l).sum::<f64>().sqrt();
                let status = match coupling {
                    Coupling::Tied => Status::Tied,
                    _ if lambda[row] <= none => Status::Open,
                    _ if bounds[row].is_nan() => Status::Closed,
                    _ if shear < (1.0 - AT_BOUND) * bounds[row] => Status::Stick,
                    _ => Status::Slip,
                };
                (gaps[row], lambda[row] / node.weight, status)
            }
            (role, _) => {
                let gap = node.gap - displacement_nonmortar + displacement_mortar;
                let status = match role {
                    Role::Multiplier => Status::Tied,
                    _ => Status::Fixed,
                };
                (gap, f64::NAN, status)
            }
        };
        // the rows push the nonmortar body by −λ
        let directions = frame(node.normal).into_iter().zip(node.rows).skip(1);
        let shear = directions.fold([0.0; D], |sum, (direction, row)| {
            let traction = row.map_or(0.0, |row| -lambda[row] / node.weight);
            add_scaled(sum, traction, direction)
        });
        ContactNode {
            node: node.node,
            partner: pair.mortar.as_ref().and_then(|_| node.partner()),
            point: body.mesh.points()[node.node],
            normal: node.normal,
            weight: node.weight,
            gap,
            pressure,
            shear,
            slip,
            displacement_nonmortar,
            displacement_mortar,
            status,
        }
    };
    let nodes: Vec<ContactNode<D>> = pair.interface.nodes.iter().map(node_state).collect();
    let touching = |n: &ContactNode<D>| n.status != Status::Open && n.status != Status::Fixed;
    let extents = nodes.iter().zip(&pair.interface.nodes);
    let length = extents.filter(|(state, _)| touching(state));
    let length = length.map(|(_, node)| node.extent).sum();
    let (resultant, imbalance) = balance(model, pair, lambda);
    let tangential = pair.interface.tangential().into_iter();
    let work = tangential.zip(lambda.iter().zip(gaps));
    let dissipated = work.map(|(is, (l, gap))| if is { -l * gap } else { 0.0 });
    ContactSolution {
        name: name.to_string(),
        nonmortar: pair.nonmortar.clone(),
        mortar: pair.mortar.clone(),
        nodes,
        cyclic: pair.interface.cyclic,
        resultant,
        length,
        imbalance,
        dissipated: dissipated.sum(),
    }
}

/// The force on the nonmortar body, and how far the forces on both bodies, as the rows of B apply them, are from balance:
/// forces relative to the sum of the nodal forces, moments to that times the size of the interface; the larger.
fn balance<const D: usize>(model: &Model<D>, pair: &Paired<D>, lambda: &[f64]) -> (Point<D>, f64) {
    let points = |side: &SideRef| model.bodies[side.body.0].mesh.points();
    let own = points(&pair.nonmortar);
    let nodes: Vec<Point<D>> = pair.interface.nodes.iter().map(|n| own[n.node]).collect();
    let (low, high) = bounding_box(&nodes);
    let centre = centroid(&[low, high]);
    let sum = |rows: &[Row<D>], points: &[Point<D>]| {
        let (mut force, mut moment) = ([0.0; D], [0.0; 3]);
        for (row, l) in rows.iter().zip(lambda) {
            for &(node, coefficients) in row {
                let push = coefficients.map(|c| -l * c);
                force = add_scaled(force, 1.0, push);
                let turn = cross(sub(points[node], centre), push);
                moment = add_scaled(moment, 1.0, turn);
            }
        }
        (force, moment)
    };
    let (resultant, moment) = sum(&pair.interface.nonmortar, own);
    let magnitude: f64 = lambda.iter().map(|l| l.abs()).sum();
    let Some(mortar) = pair.mortar.as_ref().filter(|_| magnitude > 0.0) else {
        return (resultant, 0.0);
    };
    let (force, other) = sum(&pair.interface.mortar, points(mortar));
    let (mut rest, mut turn) = (
        add_scaled(resultant, 1.0, force),
        norm(add_scaled(moment, 1.0, other)),
    );
    if model.analysis == Analysis::Axisymmetric {
        // radial forces and moments balance over the full turn
        (rest[0], turn) = (0.0, 0.0);
    }
    let size = crate::geometry::distance(low, high);
    (resultant, norm(rest).max(turn / size) / magnitude)
}
