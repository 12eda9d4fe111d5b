//! The judge of contact forces: gaps, reactions, resultants and energies of the displacements that they cause.
//!
//! All of it is computed from u and λ afresh, not taken from F and d, so that an error of the condensation cannot hide.
//! The energy gap is the difference of the potential and the complementary energy, Π(u) − Π*(σ, λ) = λ·gap − r·u, with r the
//! unbalanced nodal forces of all bodies.

use crate::contact::{Coupling, Row};
use crate::dual::{Certificate, Component, Multipliers, OfDomain, ROUNDING, Recomputed, above};
use crate::geometry::{Point, distance, dot};
use crate::host::in_order;
use crate::linalg::SparseVector;
use crate::model::march::between::{
    Overlap, held_overlap, left_overlap, smallest_gap, sunk, untied, worst_overlap,
};
use crate::model::march::intrusion::intrusions;
use crate::model::march::open::open_forces;
use crate::model::march::settle::settle;
use crate::model::nouns::error::Error;
use crate::model::nouns::intrusion::Intrusion;
use crate::model::nouns::model::Model;
use crate::model::nouns::presence::Stage;
use crate::model::read::view::View;
use crate::model::system::bodies::{LoadedBody, add_rows};
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, contact_rows, row_ranges};
use crate::model::system::displaced::{Displaced, moved};
use crate::model::system::domains::domains;
use crate::model::system::links::part_balance;
use crate::model::system::parts::Parts;
use crate::model::system::recover::{
    balanced_state, elastic_displacement, imbalance, rigid_displacement,
};
use crate::solve::{Outcome, distance_to_exact};
use rayon::prelude::*;

/// A force below this part of the largest is rounding of the linear solves: such a contact holds no body.
const NO_FORCE: f64 = 1e-12;

/// Energies below this part of those without contacts are rounding of these: where ties pass a load on to supports, no body is
/// strained.
const NO_ENERGY: f64 = 1e-7;

/// Gaps and overlaps below this part of the length of the problem are not reported.
const PARTED: f64 = 1e-6;

/// An overlap of held nodes up to this part of the length of the problem is one of polygons and averages.
const DEEP: f64 = 1e-2;

/// Displacements under some contact forces, and their judgement.
pub(crate) struct Judged<const D: usize> {
    pub displaced: Displaced<D>,
    /// The checked figures.
    pub certificate: Certificate,
    /// The deepest overlap of two sides between their nodes.
    pub overlap: Option<Overlap<D>>,
    /// The worst intrusion of a body, if that was looked for.
    pub intrusion: Option<Intrusion<D>>,
    /// Remarks on bodies whose contact is inactive.
    pub remarks: Vec<String>,
}

impl<const D: usize> Judged<D> {
    /// Looks for overlapping bodies under the forces `lambda` (m,): only once an answer is found, because no contact force can change
    /// them.
    pub fn look_for_intrusion(
        &mut self,
        stage: &Stage<'_, D>,
        condensed: (&Condensed<D>, &View<D>),
        lambda: &[f64],
    ) {
        let found = intrusions(stage, condensed, &self.displaced, lambda);
        self.intrusion = Intrusion::worst(&found);
        self.remarks = found.iter().filter_map(Intrusion::remark).collect();
        self.certificate.overlap = Intrusion::figure(self.intrusion.as_ref());
    }
}

/// Displacements of all bodies under some contact forces, and their certificate. With displacements found `before`, the increments
/// of a change of the forces (m,) are added to these: rounding, which a slender body magnifies, is then the same in both, and a
/// correction is effective.
///
/// A pressed body may still be free to move. It is placed by least norm only in an answer, because corrections go on from the
/// amplitudes of the solver. The placement is kept where the certificate still holds, and where the solver has moved a body farther
/// than its own length without a reason: such displacements are dominated by rounding, and no answer is better than this one.
pub(crate) fn judge<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    outcome: &Outcome,
    before: Option<(&Judged<D>, &[f64])>,
) -> Result<Judged<D>, Error<D>> {
    let judged = judge_placed(model, condensed, outcome, (before, Placed::Hovering))?;
    if !(judged.displaced.loose && judged.certificate.holds()) {
        return Ok(judged);
    }
    let settled = judge_placed(model, condensed, outcome, (before, Placed::Loose))?;
    let strays = strays(model, [&judged.displaced, &settled.displaced]);
    Ok(match settled.certificate.holds() || strays {
        true => settled,
        false => judged,
    })
}

/// Some body lies farther apart in two placements than it is long.
fn strays<const D: usize>(model: &Model<D>, placed: [&Displaced<D>; 2]) -> bool {
    let [first, second] = placed.map(|displaced| &displaced.states);
    let mut bodies = model.bodies.iter().zip(first.iter().zip(second));
    bodies.any(|(body, (a, b))| {
        let length = body.mesh.diameter();
        let mut nodes = a.u.iter().zip(&b.u);
        nodes.any(|(&a, &b)| distance(a, b) > length)
    })
}

/// Bodies that are placed by least norm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Placed {
    /// Motions that no contact controls, and bodies without contact.
    Hovering,
    /// Also bodies pressed by contacts that let them move.
    Loose,
}

fn judge_placed<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    outcome: &Outcome,
    how: (Option<(&Judged<D>, &[f64])>, Placed),
) -> Result<Judged<D>, Error<D>> {
    let displaced = displaced(model, condensed, &outcome.multipliers, how)?;
    let lambda = &outcome.multipliers.lambda;
    let overlap = deepest_overlap(model, condensed, &displaced, lambda);
    let certificate = certify(model, condensed, &displaced, outcome, overlap);
    Ok(Judged {
        displaced,
        certificate,
        overlap,
        intrusion: None,
        remarks: Vec::new(),
    })
}

/// Displacements of all bodies, some of them placed; `before` as in [`judge`].
fn displaced<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    multipliers: &Multipliers,
    (before, placed): (Option<(&Judged<D>, &[f64])>, Placed),
) -> Result<Displaced<D>, Error<D>> {
    let Condensed {
        bodies,
        factored,
        floating,
        problem,
        ..
    } = condensed;
    let lambda = &multipliers.lambda;
    let mut amplitudes = floating.amplitudes(&multipliers.alpha);
    let elastic = (bodies, factored).into_par_iter().enumerate();
    let elastic = elastic.map(|(index, (body, factored))| {
        let strained = before.and_then(|(judged, change)| {
            let own = judged.displaced.strained.get(index)?;
            Some((&own[..], change))
        });
        elastic_displacement(body, factored, lambda, strained)
    });
    let mut elastic: Vec<Vec<f64>> = elastic.collect();
    let rigid_at = |amplitudes: &[f64]| -> Vec<Vec<f64>> {
        let each = bodies.iter().enumerate();
        let each = each.map(|(index, body)| rigid_displacement(body, floating, amplitudes, index));
        each.collect()
    };
    let mut rigid = rigid_at(&amplitudes);
    let mut open = open_motions(model, condensed, lambda)?;
    let loose = !open.loose.is_empty();
    if placed == Placed::Loose {
        open.motions.append(&mut open.loose);
    }
    if !open.motions.is_empty() {
        let mut gaps = condensed.gaps.clone();
        add_rows(bodies, -1.0, &rigid, &mut gaps);
        add_rows(bodies, -1.0, &elastic, &mut gaps);
        let limiting = gaps.into_iter().zip(&open.limits);
        let limiting = limiting.map(|(gap, limits)| limits.then_some(gap));
        let limiting: Vec<Option<f64>> = limiting.collect();
        let free = (&open.motions[..], Parts::of(model).free());
        let settled = settle(bodies, floating, free, [&elastic, &rigid], &limiting);
        settled.add_to(1.0, &mut amplitudes);
        rigid = rigid_at(&amplitudes);
    }
    let of_rigid = elastic.split_off(model.bodies.len());
    let of_parts = domains(&condensed.conditions, bodies.len());
    let states = (&model.bodies, bodies, factored, elastic, &rigid).into_par_iter();
    let states = states.enumerate();
    let states = states.map(|(index, (body, loaded, factored, elastic, rigid))| {
        let parts = [elastic, rigid.clone()];
        let scales = problem.domain_scales(of_parts[index]);
        balanced_state(model, body, loaded, factored, parts, lambda, scales)
    });
    let (states, mut strained): (Vec<_>, Vec<_>) = in_order(states)?.into_iter().unzip();
    strained.extend(of_rigid);
    // rigid motions first: they may cancel a clearance that is large beside the strains
    let mut clearances = condensed.gaps.clone();
    add_rows(bodies, -1.0, &rigid, &mut clearances);
    let mut gaps = clearances.clone();
    add_rows(bodies, -1.0, &strained, &mut gaps);
    let terms = |u: &[f64]| ROUNDING * u.iter().fold(0.0, |s: f64, u| s.max(u.abs()));
    let mut rounding: Vec<f64> = condensed.gaps.iter().map(|g| ROUNDING * g.abs()).collect();
    for (body, (elastic, rigid)) in bodies.iter().zip(strained.iter().zip(&rigid)) {
        let size = terms(elastic) + terms(rigid);
        let rows = body.rows.index.iter();
        rows.for_each(|&row| rounding[row] += size);
    }
    let mut negligible = vec![0.0f64; problem.coupled.domains()];
    for (part, moved) in of_parts.iter().zip(strained.iter().zip(&rigid)) {
        let own = &mut negligible[*part];
        *own = own.max(4.0 * terms(moved.0)).max(4.0 * terms(moved.1));
    }
    let rigid_parts = bodies.iter().zip(&rigid).skip(model.bodies.len());
    Ok(Displaced {
        states,
        parts: rigid_parts
            .map(|(part, u)| part.system.to_global(u))
            .collect(),
        gaps,
        rounding,
        clearances,
        domains: of_parts,
        negligible,
        strained,
        hovering: open.hovering,
        loose,
    })
}

/// Negligible lengths in a contact: a part of the length of its domain, and the rounding there.
fn negligible<const D: usize>(
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    contact: usize,
    part: f64,
) -> f64 {
    let domain = condensed.problem.coupled.domain(contact);
    let length = condensed.problem.domain_scales(domain).length;
    part * length + displaced.negligible[domain]
}

/// The worst overlap between the nodes of all contacts.
fn deepest_overlap<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    lambda: &[f64],
) -> Option<Overlap<D>> {
    let mut worst: Option<Overlap<D>> = None;
    for (contact, (rows, condition)) in contact_rows(&condensed.conditions) {
        let moved = moved(condition, displaced);
        let negligible = negligible(condensed, displaced, contact, model.solver.tolerance);
        let found = worst_overlap(contact, condition, &moved, &lambda[rows], negligible);
        let deeper = |w: Overlap<D>, f: &Overlap<D>| f.depth * w.resolved > w.depth * f.resolved;
        if let Some(found) = found.filter(|f| worst.is_none_or(|w| deeper(w, f))) {
            worst = Some(found);
        }
    }
    worst
}

/// The deepest overlap of the sides of each contact at excluded nodes: contact, undeformed position, depth.
pub(crate) fn left_to_overlap<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
) -> Vec<(usize, Point<D>, f64)> {
    let deepest = |(contact, condition): (usize, &Condition<D>)| {
        let negligible = negligible(condensed, displaced, contact, model.solver.tolerance);
        let found = left_overlap(condition, &moved(condition, displaced), negligible);
        found.map(|(point, depth)| (contact, point, depth))
    };
    let contacts = contact_rows(&condensed.conditions);
    let contacts = contacts.map(|(contact, (_, condition))| (contact, condition));
    contacts.filter_map(deepest).collect()
}

/// Nodes that supports push into the other side: the deepest of each contact, its undeformed position and depth. No condition
/// keeps it out, and the overlap of its neighbours, which the mesh may hide, says little about it.
pub(crate) fn held_to_overlap<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
) -> Vec<(usize, Point<D>, f64)> {
    let deepest = |(contact, condition): (usize, &Condition<D>)| {
        let (node, depth) = held_overlap(condition, &moved(condition, displaced))?;
        let points = model.bodies[condition.nonmortar.body.0].mesh.points();
        let negligible = negligible(condensed, displaced, contact, DEEP);
        (depth > negligible).then_some((contact, points[node], depth))
    };
    let contacts = contact_rows(&condensed.conditions);
    let contacts = contacts.map(|(contact, (_, condition))| (contact, condition));
    contacts.filter_map(deepest).collect()
}

/// A contradiction between the force of a contact and the gaps between its nodes, because its facets are too large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Blur<const D: usize> {
    /// It bears a force although its sides are everywhere at least this far apart.
    Apart(f64),
    /// It bears no force although its sides overlap by this depth.
    Unborne(f64),
    /// It bears a force, but its sides have sunk into each other by this depth, most of their motion.
    Sunk(f64),
    /// A tie whose sides part by this much at a place where supports leave no condition.
    Untied(Point<D>, f64),
}

/// Contacts whose forces and gaps between nodes contradict each other, by their index.
pub(crate) fn blurred<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    judged: &Judged<D>,
    lambda: &[f64],
) -> Vec<(usize, Blur<D>)> {
    let displaced = &judged.displaced;
    // a tip of a tool may lie between all points that are looked at
    let tip = |contact: usize| {
        let found = judged.intrusion.iter().filter(|found| found.obstacle);
        let mut found = found.filter(|found| found.other == model.contacts[contact].name);
        found.next().map_or(0.0, |found| found.depth)
    };
    let largest = |lambda: &[f64]| lambda.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    let whole = largest(lambda);
    let (none, some) = (NO_FORCE * whole, model.solver.tolerance * whole);
    let told = contact_rows(&condensed.conditions).filter_map(|(contact, (rows, condition))| {
        let loose = condition.interface.coupling != Coupling::Tied;
        let lambda = &lambda[rows];
        let bears = |row: usize| lambda[row].abs() > none;
        let moved = moved(condition, displaced);
        if !loose {
            let (place, jump) = untied(condition, &moved)?;
            return Some((contact, Blur::Untied(place, jump)));
        }
        // sides with a gasket move into what lies between them
        if condition.touch.filling.is_some() {
            return None;
        }
        let nearest = smallest_gap(condition, &moved, bears);
        let rounding = negligible(condensed, displaced, contact, PARTED);
        // forces within the tolerance may be there or not
        let force = largest(lambda);
        let blur = match nearest {
            Some(gap) if force > some && gap > rounding => Some(Blur::Apart(gap)),
            Some(gap) if force <= none && gap < -rounding => Some(Blur::Unborne(-gap)),
            _ if force <= none && tip(contact) > rounding => Some(Blur::Unborne(tip(contact))),
            _ => {
                let deep = sunk(condition, &moved, tip(contact));
                let deep = deep.filter(|depth| *depth > rounding);
                deep.map(Blur::Sunk)
            }
        };
        Some((contact, blur?))
    });
    told.collect()
}

/// Largest violation of a condition without a multiplier, a length, by contact.
fn implied_violations<const D: usize>(
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
) -> Vec<f64> {
    let of_condition = |condition: &Condition<D>| {
        let mut worst = 0.0f64;
        let moved = moved(condition, displaced);
        let tied = condition.interface.coupling == Coupling::Tied;
        let implied = condition.interface.implied.iter();
        for implied in implied.filter(|c| tied || c.component == 0) {
            let [own, other] = &implied.rows;
            let along = |row: &Row<D>, u: &dyn Fn(usize) -> Point<D>| -> f64 {
                row.iter().map(|&(node, c)| dot(c, u(node))).sum()
            };
            let gap = match implied.component {
                0 => condition.interface.nodes[implied.node].gap,
                _ => 0.0,
            };
            let other = match (&moved.other, condition.opposite) {
                (Some(u), _) => along(other, &|node| u[node]),
                (None, Some(part)) => along(other, &|node| displaced.nodes(part)[node]),
                (None, None) => along(other, &|_| moved.obstacle),
            };
            let gap = gap - along(own, &|node| moved.own[node]) - other;
            worst = worst.max(if tied { gap.abs() } else { -gap });
        }
        worst
    };
    condensed.conditions.iter().map(of_condition).collect()
}

/// Motions that the contact forces leave open.
struct OpenMotions {
    /// Combinations (r,) of modes that no contact controls, or of bodies without contact.
    motions: Vec<SparseVector>,
    /// Those of pressed bodies.
    loose: Vec<SparseVector>,
    /// Rows (m,) whose gaps limit them: open contacts. Pressed ones they do not change, and slips are free.
    limits: Vec<bool>,
    /// Bodies that hover: single ones, or groups joined by ties and couples, whose other contacts bear no force.
    hovering: Vec<String>,
}

/// Combinations of modes that no contact can control, and motions of single bodies, or of groups joined by ties and couples, that
/// change no tied or pressed row: a ball on one node may turn about it until the next node touches, and no force determines its
/// position in between.
///
/// Errors: a split of the modes that does not succeed.
fn open_motions<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    lambda: &[f64],
) -> Result<OpenMotions, Error<D>> {
    let Condensed {
        bodies,
        floating,
        problem,
        ..
    } = condensed;
    let coupled = &problem.coupled;
    let mut forces: Vec<f64> = coupled.scales.iter().map(|scales| scales.force).collect();
    for (row, l) in lambda.iter().enumerate() {
        let largest = &mut forces[coupled.domain_of(row)];
        *largest = largest.max(l.abs());
    }
    let components = problem.admissible.components();
    let mut free: Vec<bool> = components.iter().map(|c| *c == Component::Free).collect();
    // a member is a tie until it yields
    for (rows, condition) in
        row_ranges(&condensed.conditions).filter(|(_, condition)| condition.is_link())
    {
        for (row, along) in rows.zip(condition.slides()) {
            free[row] |= along;
        }
    }
    let free = free;
    let mut bears = free.clone();
    for (_, block) in problem.admissible.iter() {
        let force = forces[coupled.domain_of(block.start)];
        let presses = block
            .clone()
            .any(|row| lambda[row].abs() > NO_FORCE * force);
        block.for_each(|row| bears[row] |= presses);
    }
    let normal = |row: usize| components[row] == Component::Normal;
    let mut open = OpenMotions {
        motions: floating.uncontrolled.clone(),
        loose: Vec::new(),
        limits: (0..free.len()).map(|i| normal(i) && !bears[i]).collect(),
        hovering: Vec::new(),
    };
    let parts = Parts::of(model);
    for group in groups(bodies, &free) {
        let left = floating.left_by(&group, |row| bears[row])?;
        // motions that no contact controls are in the list already
        if left.len() == floating.left_by(&group, |_| true)?.len() {
            continue;
        }
        let mut rows = group.iter().flat_map(|&part| &bodies[part].rows.index);
        if rows.any(|&row| bears[row] && !free[row]) {
            open.loose.extend(left);
            continue;
        }
        let moved = |&&part: &&usize| {
            let mut modes = floating.modes.iter().enumerate();
            modes.any(|(k, mode)| mode.0 == part && left.iter().any(|z| z[k] != 0.0))
        };
        let named = group.iter().filter(|part| parts.owner(**part).is_free());
        let named = named.filter(moved);
        let named = named.map(|&part| parts.owner(part).name(model));
        open.hovering.extend(named);
        open.motions.extend(left);
    }
    Ok(open)
}

/// Groups of parts joined by ties and couples, the `free` rows (m,); a part without these is a group by itself.
fn groups<const D: usize>(bodies: &[LoadedBody<D>], free: &[bool]) -> Vec<Vec<usize>> {
    // the group of every part, and that of every row met so far
    let mut group: Vec<usize> = (0..bodies.len()).collect();
    let mut of_row: Vec<Option<usize>> = vec![None; free.len()];
    for (part, body) in bodies.iter().enumerate() {
        for &row in body.rows.index.iter().filter(|row| free[**row]) {
            let own = group[part];
            match of_row[row] {
                None => of_row[row] = Some(part),
                Some(other) if group[other] != own => {
                    let other = group[other];
                    let joined = group.iter_mut().filter(|g| **g == own);
                    joined.for_each(|g| *g = other);
                }
                Some(_) => {}
            }
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); bodies.len()];
    for (part, group) in group.into_iter().enumerate() {
        groups[group].push(part);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

fn certify<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    Outcome {
        multipliers, exact, ..
    }: &Outcome,
    overlap: Option<Overlap<D>>,
) -> Certificate {
    let (gaps, problem) = (&displaced.gaps, &condensed.problem);
    let lambda = &multipliers.lambda;
    let exact = match exact {
        true => None,
        false => distance_to_exact(problem, multipliers),
    };
    let recomputed = Recomputed {
        gap: gaps,
        rounding: &displaced.rounding,
        exact: exact.unwrap_or_default(),
        open: open_forces(model, condensed, displaced, multipliers).unwrap_or_default(),
        between: overlap.map_or([0.0, 1.0], |o| [o.depth, o.resolved]),
        domains: of_domains(model, condensed, displaced, lambda),
    };
    problem.certify_with(multipliers, &recomputed, model.solver.tolerance)
}

/// Figures of every domain from the displacements.
///
/// The gap of potential and complementary energy is the sum over the bodies of 2·energy − f·u − R·u_D, and λ·g₀; friction takes its
/// share, bound·|slip|: λ·gap of the tangential rows is minus that where its law holds.
fn of_domains<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    displaced: &Displaced<D>,
    lambda: &[f64],
) -> Vec<OfDomain> {
    let Displaced {
        states,
        gaps,
        domains: of_parts,
        ..
    } = displaced;
    let Condensed {
        bodies, problem, ..
    } = condensed;
    let coupled = &problem.coupled;
    let mut found = vec![OfDomain::default(); coupled.domains()];
    let mut known = vec![0.0; found.len()];
    for (index, (body, state)) in model.bodies.iter().zip(states).enumerate() {
        let own = &mut found[of_parts[index]];
        known[of_parts[index]] += state.work_rounding;
        let (force, moment) = imbalance(model, body.mesh.points(), &state.total);
        let arm = coupled.scales[of_parts[index]].moment_arm;
        own.imbalance_force = own.imbalance_force.max(force - state.rounding);
        own.imbalance_moment = own.imbalance_moment.max(moment - state.rounding * arm);
        own.energy_gap += state.unbalanced_work;
        own.elastic_energy += state.strain_energy + state.spring_energy;
        own.driving_force = own.driving_force.max(state.driving_force);
    }
    let first = model.bodies.len();
    let parts = bodies.iter().zip(&displaced.strained).enumerate();
    for (index, (part, u)) in parts.skip(first) {
        let own = &mut found[of_parts[index]];
        let [work, energy, left] = part_balance(part, lambda, u);
        own.energy_gap += work;
        own.elastic_energy += energy;
        own.imbalance_force = own.imbalance_force.max(left);
    }
    let of_row = |row: usize| coupled.domain_of(row);
    for (row, (l, gap)) in lambda.iter().zip(&displaced.clearances).enumerate() {
        found[of_row(row)].energy_gap += l * gap;
    }
    for (row, work) in problem.admissible.slip_potentials(lambda, |i| gaps[i]) {
        found[of_row(row)].energy_gap += work;
    }
    let implied = implied_violations(condensed, displaced);
    for (&domain, depth) in coupled.domain.iter().zip(implied) {
        found[domain].implied = found[domain].implied.max(depth);
    }
    let [mut rest, mut borne] = [0, 1].map(|_| vec![0.0; found.len()]);
    for (index, energy) in at_rest(model, condensed) {
        rest[of_parts[index]] += energy;
    }
    for (row, energy) in of_base(condensed) {
        borne[of_row(row)] += energy;
    }
    for (domain, own) in found.iter_mut().enumerate() {
        let idle = own.elastic_energy <= known[domain];
        let none = if idle { known[domain] } else { 0.0 };
        own.energy_gap = above(own.energy_gap.abs(), none);
        let least = NO_ENERGY * coupled.scales[domain].energy;
        own.elastic_energy = own
            .elastic_energy
            .max(rest[domain])
            .max(borne[domain])
            .max(least);
    }
    found
}

/// Energy that the offsets of joints and members, their forces besides those of the rows, would store alone, by row: where the row
/// forces cancel the offsets, the remainder is rounding.
fn of_base<const D: usize>(condensed: &Condensed<D>) -> impl Iterator<Item = (usize, f64)> {
    let rows =
        row_ranges(&condensed.conditions).flat_map(|(rows, condition)| rows.zip(&condition.offset));
    let softness = &condensed.problem.softness;
    rows.map(|(row, offset)| (row, 0.5 * offset * offset * softness[row]))
}

/// Elastic energy that stressed ground would release without its contacts, by body: relative to it the energies of ground at rest
/// are rounding.
fn at_rest<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
) -> impl Iterator<Item = (usize, f64)> {
    let bodies = model.bodies.iter().zip(&condensed.bodies);
    let bodies = bodies.zip(&condensed.factored).enumerate();
    let stressed = bodies.filter(|(_, ((body, loaded), _))| {
        body.initial.stress.is_some() && loaded.system.modes.is_empty()
    });
    stressed.map(|(index, ((_, loaded), factored))| (index, factored.energy(loaded).abs()))
}
