//! Is a certified answer right? Everything is computed anew from displacements, without any code of the solver.
//!
//! For every step that the program calls converged:
//!
//! | Check | What must hold | Limit, and why |
//! |---|---|---|
//! | support | u as prescribed | 1e-6 of the largest displacement |
//! | equilibrium | internal − external force = 0 off contacts, in free directions | 1e-7 of the force scale, and 32 roundings of \|K\|\|u\| |
//! | row force | where conditions hold node by node: that force = the force of the rows | ten times the last |
//! | row sum | else: resultant of the rows = resultant of the forces on either side | the same; on curved sides the angle between facets, over which a row's normal varies |
//! | act and react | forces of both sides sum to zero, moments too | the same, no allowance for curves |
//! | outside | no contact force at a node none of whose facets faces the other side | ten times the limit of equilibrium |
//! | footprint | a sum of pushes (in the cone of friction) from points that face the other side has this resultant and moment | 1e-6 of Σ\|force\| times length; curved: see [`wrench`](crate::wrench) |
//! | penetration | gap ≥ 0 at nodes with conditions of their own, at all nodes and points of straight linear sides | 1e-6 of the largest displacement |
//! | overlap | gap ≥ 0 elsewhere, between nodes and for integrated conditions | the resolution of the mesh, see [`resolution`], and two thirds of the variation of the gap on a facet and its neighbours |
//! | jump | both components of the jump of a tie | like penetration and overlap |
//! | tension | pressures ≥ 0; nodal forces push | 1e-7 of the force scale; on the other side of integrated conditions twice the largest push (force, with friction), since biorthogonal functions change sign |
//! | open force | no pressure where the gap is open | like penetration and overlap |
//! | shear | \|shear\| ≤ bound | 1e-6 of the force scale |
//! | stuck slip | below its bound a node does not slip in this step | like penetration and overlap |
//! | shear sign | where it slips, shear = −bound along the slip | 1e-5 of the force scale; integrated: opposed |
//! | corner | where a row is missing: the nodal force is a sum of forces that each contact there allows | ten times the limit of equilibrium |
//! | weight | weights = ∫N; their sum is the facing area | 1e-6; integrated on curved sides 1 % |
//! | obstacle | forces on an obstacle balance the force that moves it | ten times the limit of equilibrium |
//! | normal | normals of the rows are those of the side, or minus the plane's | the angle between neighbouring facets, and 1e-6 |
//! | gap, slip | the columns of rows node by node are those of the displacements | like penetration |
//! | resultant | the reported resultant is that of the forces on the nonmortar side | ten times the limit of equilibrium |
//! | reaction | the reported reactions are those of the displacements | the same |
//! | stands in | no outline penetrates another one deeper than in the undeformed state | see [`overlap`](crate::overlap) |
//! | idle | nothing moves in a step in which nothing changes | like penetration |
//! | section | N, V, M are those of the stresses and loads ahead of the cut | ten times the limit of equilibrium |
//! | pressure | contact pressures are those of a uniform state, where one is known | 1e-4, ten times the limit of equilibrium, and the reported rounding of the force |

use crate::cuts::check_sections;
use crate::judgement::Judgement;
use crate::overlap::{Outline, check_overlaps};
use crate::plane::{Vector, bounds, dot, length, plus};
use crate::problem::{Against, Law, Problem, Surface};
use crate::raw::{Answer, Status, Step};
use crate::rows::{check_corners, check_rows};
use crate::state::{MOVE, State};
use crate::touch::Touch;
use crate::wrench::check_wrenches;
use std::collections::{BTreeMap, BTreeSet};

/// Allowed gap in units of the dent of a cell: at a corner the pressure of a cell is several times that of its neighbours.
const DENTS: f64 = 2.0;

/// Words in a message for a node that has a row without a force.
const DROPPED: &str = ", whose condition was dropped";

/// Judges all steps of an answer.
pub fn check(problem: &Problem, answer: &Answer) -> Judgement {
    let mut judgement = Judgement::default();
    let (answer, owners) = crate::corners::split(problem, &with_lists(problem, answer));
    let answer = &answer;
    let Some(first) = answer.steps.first() else {
        return judgement;
    };
    let contacts = owners.iter().zip(&first.contacts);
    let touches: Vec<Touch<'_>> = contacts
        .map(|(&c, raw)| Touch::new(problem, &problem.contacts[c], answer, raw))
        .collect();
    let outlines: Vec<Outline> = answer.meshes.iter().map(Outline::new).collect();
    let rest: Vec<Vec<Vector>> = answer
        .meshes
        .iter()
        .map(|mesh| vec![[0.0; 2]; mesh.points.len()])
        .collect();
    let mut before = Before {
        moves: rest,
        obstacles: vec![[0.0; 2]; touches.len()],
    };
    let mut lost = BTreeSet::new();
    for (index, step) in answer.steps.iter().enumerate() {
        judgement.begin(index + 1);
        let state = State::new(problem, answer, step);
        let obstacles: Vec<Option<Vector>> = touches
            .iter()
            .enumerate()
            .map(|(c, touch)| match touch.driven(step.time) {
                Some(moved) => Some(moved),
                None => crate::rows::placed_obstacle(touch, step, c, &state),
            })
            .collect();
        let view = View {
            problem,
            answer,
            step,
            state: &state,
            touches: &touches,
            obstacles: &obstacles,
            before: &before,
            lost: &lost,
        };
        check_supports(&mut judgement, &view);
        check_equilibrium(&mut judgement, &view);
        check_gaps(&mut judgement, &view);
        check_rows(&mut judgement, &view);
        check_corners(&mut judgement, &view);
        check_wrenches(&mut judgement, &view);
        check_uniform(&mut judgement, &view);
        check_reactions(&mut judgement, &view);
        check_overlaps(&mut judgement, &view, &outlines);
        check_idle(&mut judgement, &view, index);
        check_sections(&mut judgement, &view);
        lost.extend(crate::rows::lost(&view));
        before = Before {
            moves: step.displacements.clone(),
            obstacles: obstacles.iter().map(|o| o.unwrap_or([0.0; 2])).collect(),
        };
    }
    judgement
}

/// The answer with lists of sides as sides, too.
fn with_lists(problem: &Problem, answer: &Answer) -> Answer {
    let mut joined = answer.clone();
    let mut join = |side: &crate::problem::Side| {
        let mesh = &mut joined.meshes[problem.body(&side.body)];
        let each = side.side.split('+').filter_map(|name| mesh.sides.get(name));
        let facets: Vec<Vec<usize>> = each.flatten().cloned().collect();
        mesh.sides.insert(side.side.clone(), facets);
    };
    for contact in &problem.contacts {
        join(&contact.own);
        if let Against::Side { side, .. } = &contact.against {
            join(side);
        }
    }
    joined
}

/// State of the step before, on which friction depends.
pub struct Before {
    pub moves: Vec<Vec<Vector>>,
    pub obstacles: Vec<Vector>,
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
    pub before: &'a Before,
    /// Contacts and nodes of joints that have parted or slipped in a step before.
    pub lost: &'a BTreeSet<(usize, usize)>,
}

impl View<'_> {
    /// The name of a node in messages, with a note if the program dropped conditions of it.
    pub fn node(&self, body: usize, node: usize) -> String {
        let [x, y] = self.answer.meshes[body].points[node];
        let lost = if self.lost(body, node) { DROPPED } else { "" };
        format!(
            "node {node} of {} at ({x:.6e}, {y:.6e}){lost}",
            self.problem.bodies[body].name
        )
    }

    /// A row of the node, or of the one that it coincides with, has no force.
    fn lost(&self, body: usize, node: usize) -> bool {
        let touches = self.touches.iter().zip(&self.step.contacts);
        touches.into_iter().any(|(touch, raw)| {
            raw.rows
                .iter()
                .filter(|row| row.status == Status::Fixed)
                .any(|row| {
                    let own = touch.own == body && row.node == node;
                    own || (touch.other == Some(body)
                        && touch.partners.get(&row.node) == Some(&node))
                })
        })
    }

    /// The contacts of each node that lies on a contact side, and whether it is on the nonmortar side.
    pub fn members(&self) -> BTreeMap<(usize, usize), Vec<(usize, bool)>> {
        let mut members: BTreeMap<(usize, usize), Vec<(usize, bool)>> = BTreeMap::new();
        for (c, touch) in self.touches.iter().enumerate() {
            for &node in touch.curve.around.keys() {
                members
                    .entry((touch.own, node))
                    .or_default()
                    .push((c, true));
            }
            if let (Some(body), Some(opposite)) = (touch.other, &touch.opposite) {
                for &node in opposite.around.keys() {
                    members.entry((body, node)).or_default().push((c, false));
                }
            }
        }
        members
    }
}

/// The allowed overlap between nodes, or of integrated conditions, on each facet of the nonmortar side:
///
/// ```text
///   DENTS·(p h/E' · (1 + (h/d)³) + sagitta) + rounding
/// ```
///
/// A pressure p that changes from cell to cell dents a cell of length h by p h/E'; a body thinner than that (d) bends
/// between nodes as a beam does, p h⁴/(E' d³); polygons that stand for one curve are apart by their sagittas. p is the
/// largest of the rows on the facet and its neighbours, h the larger length of the facets of both sides.
pub fn resolution(view: &View<'_>, contact: usize) -> Vec<f64> {
    let touch = &view.touches[contact];
    let rows = view.step.contacts[contact].rows.iter();
    let traction = |row: &crate::raw::Row| {
        let sum = row.pressure.abs() + row.shear().abs();
        (row.node, if sum.is_finite() { sum } else { 0.0 })
    };
    let tractions: BTreeMap<usize, f64> = rows.map(traction).collect();
    let (mut give, mut sagitta) = (0.0f64, touch.curve.sagitta());
    let sides = [
        (Some(touch.own), Some(&touch.curve)),
        (touch.other, touch.opposite.as_ref()),
    ];
    let longest = sides
        .iter()
        .filter_map(|s| s.1)
        .fold(0.0, |s: f64, c| s.max(c.longest));
    for (body, curve) in sides {
        let (Some(body), Some(curve)) = (body, curve) else {
            continue;
        };
        let (low, high) = bounds(&view.answer.meshes[body].points);
        let thin = (high[0] - low[0]).min(high[1] - low[1]);
        let bend = 1.0 + (longest / thin).powi(3);
        give = give.max(longest / view.problem.bodies[body].plane_modulus() * bend);
        sagitta = sagitta.max(curve.sagitta());
    }
    if let Against::Obstacle {
        surface: Surface::Circle { radius, .. },
        ..
    } = &touch.contact.against
    {
        sagitta = sagitta.max(longest * longest / (8.0 * radius));
    }
    // at a corner of a side one integrated condition covers two directions
    let dents = if touch.curve.corners {
        4.0 * DENTS
    } else {
        DENTS
    };
    let each = touch.curve.facets.iter().map(|facet| {
        let around = facet.nodes.iter().flat_map(|n| &touch.curve.around[n]);
        let nodes = around.flat_map(|&f| &touch.curve.facets[f].nodes);
        let pressures = nodes.filter_map(|n| tractions.get(n));
        let pressure = pressures.fold(0.0, |s: f64, p| s.max(*p));
        dents * (give * pressure + sagitta) + view.state.tiny_length()
    });
    each.collect()
}

/// The reported reactions, if no contact touches a supported node.
fn check_reactions(judgement: &mut Judgement, view: &View<'_>) {
    let members = view.members();
    let axisymmetric = view.problem.analysis.axisymmetric();
    for (body, held) in view.state.held.iter().enumerate() {
        if held.keys().any(|&node| members.contains_key(&(body, node))) {
            continue;
        }
        // forces of beds count as reactions
        let (mut sum, mut limit) = (view.state.beds[body], 0.0);
        for (&node, axes) in held {
            let force = view.state.rest[body][node];
            for &axis in axes {
                sum = crate::plane::plus(sum, dot(force, axis), axis);
            }
            limit += 10.0 * view.state.limits[body][node];
        }
        if view.state.beds[body] != [0.0; 2] {
            let each = view.state.limits[body].iter();
            limit += 10.0 * each.fold(0.0, |s: f64, l| s.max(*l));
        }
        let mut off = crate::plane::minus(view.step.reactions[body], sum);
        if axisymmetric {
            off[0] = 0.0;
        }
        let name = &view.problem.bodies[body].name;
        judgement.compare("reaction", length(off), limit, || format!("body {name}"));
    }
}

/// In a step without any change nothing moves.
fn check_idle(judgement: &mut Judgement, view: &View<'_>, index: usize) {
    if !view.problem.idle.contains(&(index + 1)) {
        return;
    }
    for (body, moves) in view.step.displacements.iter().enumerate() {
        for (node, (&now, &before)) in moves.iter().zip(&view.before.moves[body]).enumerate() {
            let off = length(crate::plane::minus(now, before));
            let limit = view.state.tiny_length();
            judgement.compare("idle", off, limit, || view.node(body, node));
        }
    }
}

/// Contact pressures where they are known.
fn check_uniform(judgement: &mut Judgement, view: &View<'_>) {
    let Some(known) = &view.problem.uniform else {
        return;
    };
    let known = known.at([0.0; 2], view.step.time);
    for (touch, raw) in view.touches.iter().zip(&view.step.contacts) {
        for row in raw.rows.iter().filter(|r| r.status != Status::Fixed) {
            let off = (row.pressure - known).abs();
            let open = 10.0 * view.state.limits[touch.own][row.node] + view.step.rounding;
            let limit = 1e-4 * known.abs() + open / row.weight;
            judgement.compare("pressure", off, limit, || view.node(touch.own, row.node));
        }
    }
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

fn check_equilibrium(judgement: &mut Judgement, view: &View<'_>) {
    let members = view.members();
    for (body, rest) in view.state.rest.iter().enumerate() {
        for (node, &force) in rest.iter().enumerate() {
            let limit = view.state.limits[body][node];
            let left = length(view.state.free(body, node, force));
            match members.get(&(body, node)) {
                None => judgement.compare("equilibrium", left, limit, || {
                    let scale = view.state.force;
                    format!("{left:.1e} of {scale:.1e} at {}", view.node(body, node))
                }),
                Some(contacts) => {
                    let faces = contacts.iter().any(|&(c, own)| {
                        let touch = &view.touches[c];
                        let faced = if own {
                            &touch.faced
                        } else {
                            &touch.faced_other
                        };
                        // an obstacle that a corner meets between its faces lies before neither face
                        faced.contains(&node) || own && touch.met.contains(&node)
                    });
                    if !faces {
                        judgement.compare("outside", left, 10.0 * limit, || view.node(body, node));
                    }
                }
            }
        }
    }
}

fn check_gaps(judgement: &mut Judgement, view: &View<'_>) {
    let t = view.step.time;
    for (c, touch) in view.touches.iter().enumerate() {
        check_normals(judgement, view, c);
        let Some(obstacle) = view.obstacles[c] else {
            continue;
        };
        let tied = matches!(touch.contact.law, Law::Tied);
        let moves = &view.step.displacements;
        let limits = Limits::new(view, c, obstacle);
        // conditions node by node on straight sides hold between the nodes, too
        let exact = touch.nodal && touch.curve.straight() && linear(touch) && !round(touch);
        let nodes = touch.at_nodes.iter().map(|(n, s)| (Some(*n), s));
        for (node, sample) in nodes.chain(touch.between.iter().map(|s| (None, s))) {
            let sharp = if node.is_some() { touch.nodal } else { exact };
            let limit = if sharp {
                limits.fine
            } else {
                limits.coarse[sample.facet]
            };
            let place = || {
                let [x, y] = sample.x;
                let lost = sample.own.iter().any(|(n, _)| view.lost(touch.own, *n));
                let lost = if lost { DROPPED } else { "" };
                format!("contact {} at ({x:.6e}, {y:.6e}){lost}", touch.contact.name)
            };
            if tied {
                let jump = length(touch.jump(sample, moves, obstacle));
                judgement.compare("jump", jump, limit, place);
                continue;
            }
            let gap = touch.gap(sample, moves, obstacle, t);
            let what = if sharp { "penetration" } else { "overlap" };
            judgement.compare(what, -gap, limit, place);
        }
        check_columns(judgement, view, c, limits.fine, obstacle);
        if !tied {
            check_open_forces(judgement, view, c, &limits, obstacle);
        }
    }
}

/// Normals of the rows; a support along an axis turns them into the directions that it leaves free.
fn check_normals(judgement: &mut Judgement, view: &View<'_>, c: usize) {
    let touch = &view.touches[c];
    // at a corner one row stands for two directions; integrated rows report the side's own normal, not the plane's
    if touch.curve.corners || (touch.other.is_none() && !touch.nodal) {
        return;
    }
    for &node in &touch.wrong_normals {
        judgement.compare("normal", 2.0, 1.0, || view.node(touch.own, node));
    }
    for row in &view.step.contacts[c].rows {
        let Some(sample) = touch.at_nodes.get(&row.node) else {
            continue;
        };
        let held = view.state.held[touch.own].contains_key(&row.node);
        let partner = touch.partners.get(&row.node);
        let other = touch
            .other
            .zip(partner)
            .is_some_and(|(b, n)| view.state.held[b].contains_key(n));
        if held || other || row.gap.is_nan() {
            continue;
        }
        let off = length(crate::plane::minus(row.normal, sample.normal));
        let limit = 1.1 * touch.curve.turn + 1e-6;
        judgement.compare("normal", off, limit, || view.node(touch.own, row.node));
    }
}

/// The largest overlap of a gap whose means vanish, in parts of its range: the parabola 1/2 − 6(x − 1/2)² on 0 ≤ x ≤ 1 is
/// orthogonal to all linear functions, −1 at the ends and 1/2 in the middle.
const AVERAGED: f64 = 2.0 / 3.0;

/// Largest violations of the gap conditions of a contact.
pub struct Limits {
    /// For conditions point by point.
    pub fine: f64,
    /// For integrated conditions, on each facet: the resolution of the mesh, and a part ([`AVERAGED`]) of the variation of the gap on
    /// the facet and its neighbours, over which it is averaged.
    pub coarse: Vec<f64>,
}

impl Limits {
    /// Of a contact whose obstacle has this displacement.
    pub fn new(view: &View<'_>, c: usize, obstacle: Vector) -> Self {
        let touch = &view.touches[c];
        let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; touch.curve.facets.len()];
        for sample in touch.between.iter().chain(touch.at_nodes.values()) {
            let gap = touch.gap(sample, &view.step.displacements, obstacle, view.step.time);
            let [low, high] = &mut ranges[sample.facet];
            (*low, *high) = (low.min(gap), high.max(gap));
        }
        let resolved = resolution(view, c);
        let coarse = touch
            .curve
            .facets
            .iter()
            .zip(resolved)
            .map(|(facet, resolved)| {
                let around = facet.nodes.iter().flat_map(|n| &touch.curve.around[n]);
                let varies = around.map(|&f| (ranges[f][1] - ranges[f][0]).max(0.0));
                resolved + AVERAGED * varies.fold(0.0, f64::max)
            });
        Self {
            fine: view.state.tiny_length() + MOVE * length(obstacle),
            coarse: coarse.collect(),
        }
    }
}

/// Gap and slip of the rows of conditions node by node.
fn check_columns(
    judgement: &mut Judgement,
    view: &View<'_>,
    c: usize,
    limit: f64,
    obstacle: Vector,
) {
    let touch = &view.touches[c];
    if !touch.nodal {
        return;
    }
    for row in view.step.contacts[c]
        .rows
        .iter()
        .filter(|r| !r.gap.is_nan())
    {
        let Some(sample) = touch.at_nodes.get(&row.node) else {
            continue;
        };
        let jump = touch.jump(sample, &view.step.displacements, obstacle);
        let tangent = crate::plane::turned(row.normal);
        let place = || view.node(touch.own, row.node);
        // along the row's own normal: a support may have turned it
        let clearance = touch.clearance(sample, view.step.time);
        let gap = (row.gap - clearance - dot(row.normal, jump)).abs();
        judgement.compare("gap", gap, limit, place);
        if touch.driven(view.step.time).is_some() {
            let slip = dot(tangent, plus(row.slip, 1.0, jump)).abs();
            judgement.compare("slip", slip, limit, place);
        }
    }
}

/// No force where the gap is open.
fn check_open_forces(
    judgement: &mut Judgement,
    view: &View<'_>,
    c: usize,
    limits: &Limits,
    obstacle: Vector,
) {
    let touch = &view.touches[c];
    let rows = &view.step.contacts[c].rows;
    let largest = rows.iter().fold(0.0, |s: f64, r| s.max(r.pressure.abs()));
    for row in rows.iter().filter(|r| r.status != Status::Fixed) {
        let Some(sample) = touch.at_nodes.get(&row.node) else {
            continue;
        };
        let gap = touch.gap(sample, &view.step.displacements, obstacle, view.step.time);
        let force = row.pressure * row.weight;
        let limit = 10.0 * view.state.limits[touch.own][row.node];
        let place = || view.node(touch.own, row.node);
        if touch.nodal {
            if force > limit {
                judgement.compare("open force", gap, limits.fine, place);
            }
        } else if row.pressure > 1e-2 * largest && force > limit && !touch.mixed(row.node) {
            judgement.compare("open force", gap, limits.coarse[sample.facet], place);
        }
    }
}

/// All facets of both sides are straight lines between two nodes.
fn linear(touch: &Touch<'_>) -> bool {
    let straight = |c: &crate::side::Curve| c.facets.iter().all(|f| f.nodes.len() == 2);
    straight(&touch.curve) && touch.opposite.as_ref().is_none_or(straight)
}

/// The other side is a round obstacle.
fn round(touch: &Touch<'_>) -> bool {
    matches!(
        &touch.contact.against,
        Against::Obstacle {
            surface: Surface::Circle { .. },
            ..
        }
    )
}

/// All contacts between bodies have conditions node by node.
pub fn all_nodal(problem: &Problem, answer: &Answer) -> bool {
    let answer = &with_lists(problem, answer);
    let Some(first) = answer.steps.first() else {
        return true;
    };
    let contacts = problem.contacts.iter().zip(&first.contacts);
    contacts
        .map(|(contact, raw)| Touch::new(problem, contact, answer, raw))
        .all(|touch| touch.nodal)
}
