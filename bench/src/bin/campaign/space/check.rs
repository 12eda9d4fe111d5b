//! Is a certified answer right? Everything is computed anew from displacements, without any code of the solver.
//!
//! For every step that the program calls converged:
//!
//! | Check | What must hold | Limit, and why |
//! |---|---|---|
//! | support | u as prescribed | 1e-6 of the largest displacement |
//! | motion | no body moves farther than the largest is long: strains are 1e-3 at most | none for a polyhedron that spins until its next node is closed, whose normal may be very near to the radius |
//! | equilibrium | internal − external force = 0 off contacts, in free directions | 1e-7 of the force scale, and 32 roundings of \|K\|\|u\| |
//! | outside | no contact force at a node none of whose facets faces the other side | ten times that |
//! | row force | where conditions hold node by node: that force = the force of the rows | the same |
//! | row sum | else: resultant of the rows = resultant of the forces on either side | the same; on curved sides the angle between facets, over which a row's normal varies |
//! | act and react | forces of both sides sum to zero, moments too | the same, no allowance for curves |
//! | resultant | the reported resultant and moment are those of the forces on the nonmortar side | the same |
//! | obstacle | forces on an obstacle balance the force that moves it | the same |
//! | reaction | the reported reactions are those of the displacements | the same |
//! | work | the work of the contact forces on the displacements of both sides equals that of the rows on their gaps and slips | the same, times the largest displacement |
//! | footprint | a sum of pushes in the cone of friction from points that face the other side has this resultant and moment | 1e-6 of Σ\|force\| times length; curved: see [`wrench`](super::wrench) |
//! | penetration | gap ≥ 0 in rows, at nodes with conditions of their own, at all points of plane linear sides | 1e-6 of the largest displacement |
//! | overlap | gap ≥ 0 elsewhere, between nodes and for integrated conditions | the resolution of the mesh, see [`resolution`], and half of the variation of the gap on a facet and its neighbours |
//! | jump | all components of the jump of a tie | like penetration and overlap |
//! | tension | pressures ≥ 0 | the limit of equilibrium |
//! | open force | no pressure where the gap is open, of the row and at its node | like penetration and overlap |
//! | shear | \|shear\| ≤ bound | ten times the limit of equilibrium |
//! | stuck slip | below its bound a row does not slip in this step | like penetration |
//! | shear sign | where it slips, shear = −bound along the slip | 1e-5 of the bound, and the angle squared by which a slip as small as this is known |
//! | weight | weights = ∫N; their sum is the facing area | 1e-6, on curved sides 1e-3; 1e-3 of the area, since slivers are left out |
//! | normal | normals of the rows are those of the side, or minus the plane's | the angle between neighbouring facets, and 1e-6 |
//! | gap, slip | the columns of rows node by node are those of the displacements | like penetration |
//! | gap | those of integrated rows lie among the gaps around their nodes | twice the range of these gaps, since functions change sign, and the sagittas |
//! | pressure | contact pressures are those of a uniform state, where one is known | 1e-6, ten times the limit of equilibrium, and the reported rounding of the force |
//!
//! The check `work` relates gaps and slips of integrated rows to the true displacements, so that the laws in the rows can be
//! judged sharply.

use super::geometry::{Vector, across, bounds, dot, length, minus, plus};
use super::problem::{Against, Form, Law, Problem};
use super::rows::check_rows;
use super::side::Skin;
use super::state::State;
use super::touch::{Sample, Touch};
use super::wrench::check_wrenches;
use super::{Answer, Row, Step};
use crate::judgement::Judgement;
use crate::raw::Status;
use crate::state::MOVE;
use std::collections::BTreeMap;

/// Allowed gap in units of the dent of a cell: at a corner the pressure of a cell is several times that of its neighbours.
const DENTS: f64 = 2.0;

/// Judges all steps of an answer.
pub fn check(problem: &Problem, answer: &Answer) -> Judgement {
    let mut judgement = Judgement::default();
    let touches = touches(problem, answer);
    let mut before: Option<&Step> = None;
    for (index, step) in answer.steps.iter().enumerate() {
        judgement.begin(index + 1);
        let state = State::new(problem, answer, step);
        let obstacle = |(c, touch): (usize, &Touch<'_>)| {
            let driven = touch.driven(step.time);
            driven.or_else(|| placed_obstacle(touch, step, c, &state))
        };
        let view = View {
            problem,
            answer,
            step,
            obstacles: &touches.iter().enumerate().map(obstacle).collect::<Vec<_>>(),
            state: &state,
            touches: &touches,
            before,
        };
        check_supports(&mut judgement, &view);
        check_motion(&mut judgement, &view);
        check_equilibrium(&mut judgement, &view);
        for c in 0..touches.len() {
            check_normals(&mut judgement, &view, c);
            check_gaps(&mut judgement, &view, c);
        }
        check_rows(&mut judgement, &view);
        check_wrenches(&mut judgement, &view);
        check_uniform(&mut judgement, &view);
        check_reactions(&mut judgement, &view);
        before = Some(step);
    }
    judgement
}

fn touches<'a>(problem: &'a Problem, answer: &Answer) -> Vec<Touch<'a>> {
    let Some(first) = answer.steps.first() else {
        return Vec::new();
    };
    let contacts = problem.contacts.iter().zip(&first.contacts);
    contacts
        .map(|(contact, raw)| Touch::new(problem, contact, answer, raw))
        .collect()
}

/// All contacts between bodies have conditions node by node.
pub fn all_nodal(problem: &Problem, answer: &Answer) -> bool {
    touches(problem, answer).iter().all(|touch| touch.nodal)
}

/// One step with all data of the checks.
pub struct View<'a> {
    pub problem: &'a Problem,
    pub answer: &'a Answer,
    pub step: &'a Step,
    pub state: &'a State,
    pub touches: &'a [Touch<'a>],
    /// Displacements of obstacles; `None` where a force moves one that touches nothing.
    pub obstacles: &'a [Option<Vector>],
    pub before: Option<&'a Step>,
}

impl View<'_> {
    /// The name of a node in messages.
    pub fn node(&self, body: usize, node: usize) -> String {
        let [x, y, z] = self.answer.meshes[body].points[node];
        let name = &self.problem.bodies[body].name;
        format!("node {node} of {name} at ({x:.6e}, {y:.6e}, {z:.6e})")
    }

    /// The sides of a contact that have a mesh: body, skin, nodes that face the other side.
    pub fn sides(&self, c: usize) -> impl Iterator<Item = (usize, &Skin, bool)> {
        let touch = &self.touches[c];
        let other = touch.other.zip(touch.opposite.as_ref());
        let other = other.map(|(body, skin)| (body, skin, false));
        std::iter::once((touch.own, &touch.skin, true)).chain(other)
    }

    /// The contacts of each node that lies on a contact side, and whether it is on the nonmortar side.
    pub fn members(&self) -> BTreeMap<(usize, usize), Vec<(usize, bool)>> {
        let mut members: BTreeMap<(usize, usize), Vec<(usize, bool)>> = BTreeMap::new();
        for c in 0..self.touches.len() {
            for (body, skin, own) in self.sides(c) {
                for &node in skin.around.keys() {
                    members.entry((body, node)).or_default().push((c, own));
                }
            }
        }
        members
    }

    /// The gap at a sample of a contact; `None` if the position of the obstacle is unknown.
    pub fn gap(&self, c: usize, sample: &Sample) -> Option<f64> {
        let moves = &self.step.displacements;
        Some(self.touches[c].gap(sample, moves, self.obstacles[c]?))
    }
}

/// Displacement of an obstacle that a force moves: the least one with which the rows that bear force are closed.
fn placed_obstacle(touch: &Touch<'_>, step: &Step, c: usize, state: &State) -> Option<Vector> {
    let rows = &step.contacts[c].rows;
    let forces = rows.iter().map(|r| r.pressure * r.weight);
    let largest = forces.fold(0.0, f64::max);
    if largest <= 1e-6 * state.force {
        return None;
    }
    let bearing = rows
        .iter()
        .filter(|r| r.pressure * r.weight > 1e-6 * largest);
    let samples = bearing.filter_map(|r| touch.at_nodes.get(&r.node));
    let samples: Vec<&Sample> = samples.collect();
    // conjugate gradients for the normal equations: directions without any row get no displacement
    let felt = |f: &dyn Fn(&Sample) -> f64| {
        let each = samples.iter();
        each.fold([0.0; 3], |s, sample| plus(s, f(sample), sample.normal))
    };
    let mut moved = [0.0; 3];
    for _ in 0..3 {
        let mut rest = felt(&|s| -touch.gap(s, &step.displacements, moved));
        let (mut along, first) = (rest, dot(rest, rest));
        for _ in 0..3 {
            let size = dot(rest, rest);
            let image = felt(&|s| dot(s.normal, along));
            let give = dot(along, image);
            // the rest is rounding, or in directions without any row
            if size <= 1e-28 * first || give <= 1e-12 * dot(along, along) {
                break;
            }
            let part = size / give;
            (moved, rest) = (plus(moved, part, along), plus(rest, -part, image));
            along = plus(rest, dot(rest, rest) / size, along);
        }
    }
    Some(moved)
}

/// Distance of the sides of a contact from the surfaces that they approximate, if it matters.
fn sagitta(view: &View<'_>, c: usize) -> f64 {
    let touch = &view.touches[c];
    if let Against::Obstacle { surface, .. } = &touch.contact.against
        && surface.form != Form::Plane
    {
        return touch.skin.longest.powi(2) / (4.0 * surface.radius);
    }
    let both = view.sides(c).map(|(_, skin, _)| skin.sagitta()).sum();
    let clear = touch.between.iter().map(|s| touch.clearance(s).abs());
    if clear.fold(0.0, f64::max) > 2.0 * both {
        0.0
    } else {
        both
    }
}

/// The allowed overlap between nodes, or of integrated conditions, on each facet of the nonmortar side:
///
/// ```text
///   DENTS·(p h/E' · (1 + (h/d)³) + sagitta) + rounding
/// ```
///
/// A pressure p that changes from cell to cell dents a cell of length h by p h/E'; a body thinner than that (d, along the
/// normal) bends between nodes as a plate does; polyhedra that approximate one surface (all initial gaps are that small) differ
/// by their sagittas, and facets dip into a round obstacle. p is the largest of the rows on the facet and its neighbours, h the
/// larger length of the facets of both sides.
pub fn resolution(view: &View<'_>, c: usize) -> Vec<f64> {
    let touch = &view.touches[c];
    let traction = |row: &Row| {
        let sum = row.pressure.abs() + length(row.shear);
        (row.node, if sum.is_finite() { sum } else { 0.0 })
    };
    let rows = view.step.contacts[c].rows.iter();
    let tractions: BTreeMap<usize, f64> = rows.map(traction).collect();
    let longest = view
        .sides(c)
        .fold(0.0, |s: f64, (_, skin, _)| s.max(skin.longest));
    let mut give = 0.0f64;
    for (body, skin, _) in view.sides(c) {
        let n = skin
            .around
            .keys()
            .next()
            .map_or([0.0; 3], |&node| skin.normal_at(node));
        let points = view.answer.meshes[body].points.iter();
        let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| {
            (l.min(dot(n, x)), h.max(dot(n, x)))
        });
        let bend = 1.0 + (longest / (high - low)).powi(3);
        give = give.max(longest / view.problem.bodies[body].plane_modulus() * bend);
    }
    let sagitta = sagitta(view, c);
    let each = touch.skin.facets.iter().map(|facet| {
        let around = facet.nodes.iter().flat_map(|n| &touch.skin.around[n]);
        let nodes = around.flat_map(|&f| &touch.skin.facets[f].nodes);
        let pressures = nodes.filter_map(|n| tractions.get(n));
        let pressure = pressures.fold(0.0, |s: f64, p| s.max(*p));
        DENTS * (give * pressure + sagitta) + view.state.tiny_length()
    });
    each.collect()
}

fn check_supports(judgement: &mut Judgement, view: &View<'_>) {
    for (body, conditions) in view.state.conditions.iter().enumerate() {
        for condition in conditions {
            let u = view.step.displacements[body][condition.node];
            let off = (dot(condition.axis, u) - condition.value).abs();
            let limit = MOVE * view.state.moves + f64::MIN_POSITIVE;
            judgement.compare("support", off, limit, || view.node(body, condition.node));
        }
    }
}

/// Undriven motions stay small.
fn check_motion(judgement: &mut Judgement, view: &View<'_>) {
    let longest = view.answer.meshes.iter().map(|mesh| {
        let (low, high) = bounds(&mesh.points);
        length(minus(high, low))
    });
    let longest = longest.fold(0.0, f64::max);
    for (body, moves) in view.step.displacements.iter().enumerate() {
        // a body that spins until a second node bears has no limit; about a single node it must not turn
        let stopped = view.problem.spins && bears_on_two(view, body);
        let limit = if stopped { f64::INFINITY } else { longest };
        let most = moves.iter().fold(0.0, |s: f64, &u| s.max(length(u)));
        judgement.compare("motion", most, limit, || {
            let name = &view.problem.bodies[body].name;
            format!("body {name} by {:.1e} of its length", most / longest)
        });
    }
}

/// Whether some contact bears on a body at two nodes or more, with forces of any size: the force of the second vanishes with the
/// angle between its normal and the radius.
fn bears_on_two(view: &View<'_>, body: usize) -> bool {
    let mut contacts = view.touches.iter().zip(&view.step.contacts);
    contacts.any(|(touch, raw)| {
        let touches = touch.own == body || touch.other == Some(body);
        touches && raw.rows.iter().filter(|row| row.pressure > 0.0).count() > 1
    })
}

fn check_equilibrium(judgement: &mut Judgement, view: &View<'_>) {
    let members = view.members();
    for (body, rest) in view.state.rest.iter().enumerate() {
        for (node, &force) in rest.iter().enumerate() {
            let limit = view.state.limits[body][node];
            let left = length(view.state.free(body, node, force));
            let Some(contacts) = members.get(&(body, node)) else {
                judgement.compare("equilibrium", left, limit, || {
                    let scale = view.state.force;
                    format!("{left:.1e} of {scale:.1e} at {}", view.node(body, node))
                });
                continue;
            };
            let faces = contacts.iter().any(|&(c, own)| {
                let touch = &view.touches[c];
                let faced = if own {
                    &touch.faced
                } else {
                    &touch.faced_other
                };
                faced.contains(&node)
            });
            if !faces {
                judgement.compare("outside", left, 10.0 * limit, || view.node(body, node));
            }
        }
    }
}

/// Normals of the rows; a support along an axis turns them into the directions that it leaves free.
fn check_normals(judgement: &mut Judgement, view: &View<'_>, c: usize) {
    let touch = &view.touches[c];
    if touch.other.is_none() && !touch.nodal {
        // integrated rows report the side's own normal, not the plane's
        return;
    }
    for row in &view.step.contacts[c].rows {
        let held = |body: usize, node: usize| view.state.held[body].contains_key(&node);
        let partner = touch.other.zip(touch.partners.get(&row.node));
        let Some(sample) = touch.at_nodes.get(&row.node) else {
            continue;
        };
        if held(touch.own, row.node) || partner.is_some_and(|(b, &n)| held(b, n)) {
            continue;
        }
        // the normal of one of the faces that meet at the node
        let faces = touch.skin.normals_at(row.node);
        let off = faces
            .chain([sample.normal])
            .map(|n| length(minus(row.normal, n)));
        let off = off.fold(f64::INFINITY, f64::min);
        let limit = 1.1 * touch.skin.turn + 1e-6;
        judgement.compare("normal", off, limit, || view.node(touch.own, row.node));
    }
}

/// The least and the largest gap at the points between the nodes of each facet.
fn ranges(view: &View<'_>, c: usize) -> Vec<[f64; 2]> {
    let touch = &view.touches[c];
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; touch.skin.facets.len()];
    for sample in &touch.between {
        if let Some(gap) = view.gap(c, sample) {
            let [low, high] = &mut ranges[sample.facet];
            (*low, *high) = (low.min(gap), high.max(gap));
        }
    }
    ranges
}

/// The allowed overlap between nodes on each facet: the resolution of the mesh, and half of the variation of the gap on the facet
/// and its neighbours, over which a condition averages it; the whole variation if a polyhedron may spin onto its corners.
fn coarse(view: &View<'_>, c: usize, ranges: &[[f64; 2]]) -> Vec<f64> {
    let touch = &view.touches[c];
    let facets = touch.skin.facets.iter().zip(resolution(view, c));
    let each = facets.map(|(facet, resolved)| {
        let around = facet.nodes.iter().flat_map(|n| &touch.skin.around[n]);
        let varies = around.map(|&f| (ranges[f][1] - ranges[f][0]).max(0.0));
        let part = if view.problem.spins { 1.0 } else { 0.5 };
        resolved + part * varies.fold(0.0, f64::max)
    });
    each.collect()
}

fn check_gaps(judgement: &mut Judgement, view: &View<'_>, c: usize) {
    let touch = &view.touches[c];
    let Some(obstacle) = view.obstacles[c] else {
        return;
    };
    let fine = view.state.tiny_length() + MOVE * length(obstacle);
    let ranges = ranges(view, c);
    let coarse = coarse(view, c, &ranges);
    let linear = touch.skin.linear() && touch.opposite.as_ref().is_none_or(Skin::linear);
    // conditions node by node on plane sides hold between the nodes, too
    let exact = touch.nodal && touch.exact && linear;
    let nodes = touch.at_nodes.values().map(|s| (touch.nodal, s));
    for (sharp, sample) in nodes.chain(touch.between.iter().map(|s| (exact, s))) {
        let limit = if sharp { fine } else { coarse[sample.facet] };
        let place = || {
            let [x, y, z] = sample.x;
            let name = &touch.contact.name;
            format!("contact {name} at ({x:.6e}, {y:.6e}, {z:.6e})")
        };
        if touch.contact.law == Law::Tied {
            let jump = length(touch.jump(sample, &view.step.displacements, obstacle));
            judgement.compare("jump", jump, limit, place);
        } else {
            let gap = touch.gap(sample, &view.step.displacements, obstacle);
            let what = if sharp { "penetration" } else { "overlap" };
            judgement.compare(what, -gap, limit, place);
        }
    }
    let rows = &view.step.contacts[c].rows;
    let largest = rows.iter().fold(0.0, |s: f64, r| s.max(r.pressure.abs()));
    let around = |node: usize| {
        let facets = touch.skin.around[&node].iter().map(|&f| ranges[f]);
        facets.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], r| {
            [l.min(r[0]), h.max(r[1])]
        })
    };
    // the position of an obstacle that a force moves is a least-squares fit to the gaps at nodes: it is known up to their residual
    let driven = touch.driven(view.step.time).is_some();
    let bearing = rows.iter().filter(|r| r.pressure > 1e-6 * largest);
    let left = bearing.filter_map(|r| touch.at_nodes.get(&r.node));
    let left = left.map(|s| touch.gap(s, &view.step.displacements, obstacle).abs());
    let placed = left.fold(0.0, f64::max) * f64::from(!driven);
    for row in rows {
        let Some(sample) = touch.at_row(row) else {
            continue;
        };
        let place = || view.node(touch.own, row.node);
        let jump = touch.jump(&sample, &view.step.displacements, obstacle);
        if touch.nodal && !row.gap.is_nan() {
            // along the row's own normal: a support may have turned it
            let gap = row.gap - touch.clearance(&sample) - dot(row.normal, jump);
            judgement.compare("gap", gap.abs(), fine, place);
            if touch.driven(view.step.time).is_some() && touch.contact.law.rough() {
                let slip = plus(row.slip, 1.0, across(jump, row.normal));
                let held = view.state.held[touch.own].get(&row.node);
                let slip = crate::held::free_part(slip, held);
                judgement.compare("slip", length(slip), fine, place);
            }
        }
        if !touch.nodal && !row.gap.is_nan() && touch.contact.law != Law::Tied {
            let [low, high] = around(row.node);
            let off = (low - row.gap).max(row.gap - high);
            let limit = fine + placed + sagitta(view, c) + 2.0 * (high - low).max(0.0);
            judgement.compare("gap", off, limit, place);
        }
        let force = row.pressure * row.weight;
        let bears = force > 10.0 * view.state.limits[touch.own][row.node];
        if row.status == Status::Fixed || touch.contact.law == Law::Tied || !bears {
            continue;
        }
        let gap = touch.gap(&sample, &view.step.displacements, obstacle);
        if touch.nodal {
            judgement.compare("open force", gap, fine, place);
        } else if row.pressure > 1e-2 * largest {
            // a condition may cover a part of its facets that is far from its node
            let low = around(row.node)[0];
            judgement.compare("open force", gap.min(low), coarse[sample.facet], place);
        }
    }
}

/// The reported reactions, if no contact touches a supported node.
fn check_reactions(judgement: &mut Judgement, view: &View<'_>) {
    let members = view.members();
    for (body, held) in view.state.held.iter().enumerate() {
        if held.keys().any(|&node| members.contains_key(&(body, node))) {
            continue;
        }
        let (mut sum, mut limit) = ([0.0; 3], 0.0);
        for (&node, axes) in held {
            let force = view.state.rest[body][node];
            sum = axes.iter().fold(sum, |s, &a| plus(s, dot(force, a), a));
            limit += 10.0 * view.state.limits[body][node];
        }
        let off = length(minus(view.step.reactions[body], sum));
        let name = &view.problem.bodies[body].name;
        judgement.compare("reaction", off, limit, || format!("body {name}"));
    }
}

/// Contact pressures where they are known.
fn check_uniform(judgement: &mut Judgement, view: &View<'_>) {
    let Some(known) = view.problem.uniform else {
        return;
    };
    for (touch, raw) in view.touches.iter().zip(&view.step.contacts) {
        for row in raw.rows.iter().filter(|r| r.status != Status::Fixed) {
            let off = (row.pressure - known).abs();
            let open = 10.0 * view.state.limits[touch.own][row.node] + view.step.rounding;
            let limit = 1e-6 * known.abs() + open / row.weight;
            judgement.compare("pressure", off, limit, || view.node(touch.own, row.node));
        }
    }
}
