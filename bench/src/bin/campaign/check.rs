//! Is a certified answer right? Everything is computed anew from displacements, without any code of the solver.
//!
//! For every step that the program calls converged:
//!
//! | Check | What must hold | Limit, and why |
//! |---|---|---|
//! | support | u as prescribed | 1e-6 of the largest displacement |
//! | motion | no body moves farther than the largest is long: strains are 1e-3 at most | none for a polygon or polyhedron that spins until its next node is closed, whose normal may be very near to the radius |
//! | equilibrium | internal − external force = 0 off contacts, in free directions | 1e-7 of the force scale, and 32 roundings of \|K\|\|u\| |
//! | outside | no contact force at a node none of whose facets faces the other side | ten times that |
//! | row force | where conditions hold node by node: that force = the force of the rows | the same |
//! | row sum | else: resultant of the rows = resultant of the forces on either side | the same; on curved sides the angle between facets, over which a row's normal varies |
//! | act and react | forces of both sides sum to zero, moments too | the same, no allowance for curves |
//! | resultant | the reported resultant and moment are those of the forces on the nonmortar side | the same |
//! | obstacle | forces on an obstacle balance the force that moves it | the same |
//! | reaction | the reported reactions are those of the displacements | the same |
//! | corner | where a row is missing: the nodal force is a sum of forces that each contact there allows | the same |
//! | section | in the plane: N, V, M are those of the stresses and loads ahead of the cut | the same |
//! | work | the work of the contact forces on the displacements of both sides equals that of the rows on their gaps and slips | the same, times the largest displacement |
//! | footprint | a sum of pushes (in the cone of friction) from points that face the other side has this resultant and moment | 1e-6 of Σ\|force\| times length; curved: see [`wrench`](crate::wrench) |
//! | penetration | gap ≥ 0 in rows, at nodes with conditions of their own, at all points of plane linear sides | 1e-6 of the largest displacement |
//! | overlap | gap ≥ 0 elsewhere, between nodes and for integrated conditions | the resolution of the mesh, see [`resolution`], and a part of the variation of the gap on a facet and its neighbours |
//! | stands in | in the plane: no outline penetrates another one deeper than in the undeformed state | see [`overlap`](crate::overlap) |
//! | jump | all components of the jump of a tie | like penetration and overlap |
//! | tension | pressures ≥ 0; nodal forces push | the limit of equilibrium; on integrated conditions twice the largest push (force, with friction), since biorthogonal functions change sign |
//! | open force | no pressure where the gap is open, of the row and at its node | like penetration and overlap |
//! | shear | \|shear\| ≤ bound | ten times the limit of equilibrium |
//! | stuck slip | below its bound a row does not slip in this step, nor does its node | like penetration and overlap |
//! | shear sign | where it slips, shear = −bound along the slip | 1e-5 of the bound, and in space the angle squared by which a slip as small as this is known; integrated at its node: opposed |
//! | weight | weights = ∫N; their sum is the facing area | 1e-6, on curved sides 1e-3; 1e-3 of the area, since slivers are left out |
//! | normal | normals of the rows are those of the side, or minus the plane's | the angle between neighbouring facets, and 1e-6 |
//! | gap, slip | the columns of rows node by node are those of the displacements | like penetration |
//! | gap | those of integrated rows lie among the gaps around their nodes | twice the range of these gaps, since functions change sign, and the sagittas |
//! | idle | nothing moves in a step in which nothing changes | like penetration |
//! | pressure | contact pressures are those of a uniform state, where one is known | 1e-6, ten times the limit of equilibrium, and the reported rounding of the force |
//!
//! The check `work` relates gaps and slips of integrated rows to the true displacements, so that the laws in the rows can be
//! judged sharply.

use crate::dimension::Dimension;
use crate::judgement::Judgement;
use crate::problem::{Law, Problem};
use crate::raw::{Answer, Row, Status, Step};
use crate::rows::{check_corners, check_rows};
use crate::side::Skin;
use crate::state::{MOVE, State};
use crate::touch::Touch;
use crate::vector::{across, bounds, dot, length, minus, plus, unit};
use crate::wrench::check_wrenches;
use std::collections::{BTreeMap, BTreeSet};

/// Allowed gap in units of the dent of a cell: at a corner the pressure of a cell is several times that of its neighbours.
const DENTS: f64 = 2.0;

/// Words in a message for a node that has a row without a force.
const DROPPED: &str = ", whose condition was dropped";

/// Judges all steps of an answer.
pub fn check<const D: usize>(problem: &Problem<D>, answer: &Answer<D>) -> Judgement
where
    Problem<D>: Dimension<D>,
{
    let mut judgement = Judgement::default();
    let touches = touches(problem, answer);
    let at_rest = |mesh: &crate::raw::Mesh<D>| vec![[0.0; D]; mesh.points.len()];
    let mut before = Before {
        moves: answer.meshes.iter().map(at_rest).collect(),
        obstacles: vec![[0.0; D]; touches.len()],
        step: None,
    };
    let mut lost = BTreeSet::new();
    for (index, step) in answer.steps.iter().enumerate() {
        judgement.begin(index + 1);
        let state = State::new(problem, answer, step);
        let obstacle = |(c, touch): (usize, &Touch<'_, D>)| {
            let driven = touch.driven(step.time);
            driven.or_else(|| crate::rows::placed_obstacle(touch, step, c, &state))
        };
        let obstacles: Vec<_> = touches.iter().enumerate().map(obstacle).collect();
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
        check_motion(&mut judgement, &view);
        check_equilibrium(&mut judgement, &view);
        for c in 0..touches.len() {
            check_normals(&mut judgement, &view, c);
            check_gaps(&mut judgement, &view, c);
        }
        check_rows(&mut judgement, &view);
        check_corners(&mut judgement, &view);
        check_wrenches(&mut judgement, &view);
        check_uniform(&mut judgement, &view);
        check_reactions(&mut judgement, &view);
        check_idle(&mut judgement, &view, index);
        problem.check_more(&mut judgement, &view);
        lost.extend(crate::rows::lost(&view));
        before = Before {
            moves: step.displacements.clone(),
            obstacles: obstacles.iter().map(|o| o.unwrap_or([0.0; D])).collect(),
            step: Some(step),
        };
    }
    judgement
}

fn touches<'a, const D: usize>(problem: &'a Problem<D>, answer: &Answer<D>) -> Vec<Touch<'a, D>>
where
    Problem<D>: Dimension<D>,
{
    let Some(first) = answer.steps.first() else {
        return Vec::new();
    };
    let contacts = problem.contacts.iter().zip(&first.contacts);
    contacts
        .map(|(contact, raw)| Touch::new(problem, contact, answer, raw))
        .collect()
}

/// All contacts between bodies have conditions node by node.
pub fn all_nodal<const D: usize>(problem: &Problem<D>, answer: &Answer<D>) -> bool
where
    Problem<D>: Dimension<D>,
{
    touches(problem, answer).iter().all(|touch| touch.nodal)
}

/// State of the step before, on which friction depends.
pub struct Before<'a, const D: usize> {
    pub moves: Vec<Vec<[f64; D]>>,
    pub obstacles: Vec<[f64; D]>,
    pub step: Option<&'a Step<D>>,
}

/// One step with all data of the checks.
pub struct View<'a, const D: usize> {
    pub problem: &'a Problem<D>,
    pub answer: &'a Answer<D>,
    pub step: &'a Step<D>,
    pub state: &'a State<D>,
    pub touches: &'a [Touch<'a, D>],
    /// Displacements of obstacles; `None` where a force moves one that touches nothing.
    pub obstacles: &'a [Option<[f64; D]>],
    pub before: &'a Before<'a, D>,
    /// Contacts and nodes of joints that have parted or slipped in a step before.
    pub lost: &'a BTreeSet<(usize, usize)>,
}

impl<const D: usize> View<'_, D> {
    /// The name of a node in messages, with a note if the program dropped conditions of it.
    pub fn node(&self, body: usize, node: usize) -> String {
        let place = place(self.answer.meshes[body].points[node]);
        let lost = if self.lost(body, node) { DROPPED } else { "" };
        let name = &self.problem.bodies[body].name;
        format!("node {node} of {name} at {place}{lost}")
    }

    /// A row of the node, or of the one that it coincides with, has no force.
    fn lost(&self, body: usize, node: usize) -> bool {
        let mut touches = self.touches.iter().zip(&self.step.contacts);
        touches.any(|(touch, raw)| {
            let mut fixed = raw.rows.iter().filter(|row| row.status == Status::Fixed);
            fixed.any(|row| {
                let own = touch.own == body && row.node == node;
                let partner = touch.partners.get(&row.node);
                own || (touch.other == Some(body) && partner == Some(&node))
            })
        })
    }

    /// The sides of a contact that have a mesh: body, skin, whether it is the nonmortar side.
    pub fn sides(&self, c: usize) -> impl Iterator<Item = (usize, &Skin<D>, bool)> {
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
}

/// A place in messages.
pub fn place<const D: usize>(x: [f64; D]) -> String {
    let each = x.map(|c| format!("{c:.6e}"));
    format!("({})", each.join(", "))
}

/// Distance of the sides of a contact from the surfaces that they approximate, if it matters.
fn sagitta<const D: usize>(view: &View<'_, D>, c: usize) -> f64 {
    let touch = &view.touches[c];
    if let crate::problem::Against::Obstacle { surface, .. } = &touch.contact.against
        && let Some((_, _, radius, _)) = surface.bent()
    {
        return (D - 1) as f64 * touch.skin.longest.powi(2) / (8.0 * radius);
    }
    let sagittas = view.sides(c).map(|(_, skin, _)| skin.sagitta());
    let most = sagittas.fold(0.0, f64::max);
    let t = view.step.time;
    let between = touch.facing.between.iter();
    let clear = between.map(|s| touch.clearance(s, t).abs());
    if clear.fold(0.0, f64::max) > 2.0 * most {
        0.0
    } else {
        most
    }
}

/// The allowed overlap between nodes, or of integrated conditions, on each facet of the nonmortar side:
///
/// ```text
///   DENTS·(p h/E' · (1 + (h/d)³) + sagitta) + rounding
/// ```
///
/// A pressure p that changes from cell to cell dents a cell of length h by p h/E'; a body thinner than that (d, along the
/// normal) bends between nodes as a plate does; polygons or polyhedra that approximate one surface (all initial gaps are that
/// small) differ by their sagittas, and facets dip into a round obstacle. p is the largest of the rows on the facet and its
/// neighbours, h the larger length of the facets of both sides.
pub fn resolution<const D: usize>(view: &View<'_, D>, c: usize) -> Vec<f64> {
    let touch = &view.touches[c];
    let mut tractions: BTreeMap<usize, f64> = BTreeMap::new();
    for row in &view.step.contacts[c].rows {
        let sum = row.pressure.abs() + length(row.shear);
        let most = tractions.entry(row.node).or_default();
        *most = most.max(if sum.is_finite() { sum } else { 0.0 });
    }
    let longest = view.sides(c).map(|(_, skin, _)| skin.longest);
    let longest = longest.fold(0.0, f64::max);
    let mut give = 0.0f64;
    for (body, skin, _) in view.sides(c) {
        let first = skin.around.keys().next();
        let n = first.map_or([0.0; D], |&node| skin.normal_at(node));
        let points = view.answer.meshes[body].points.iter();
        let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| {
            (l.min(dot(n, x)), h.max(dot(n, x)))
        });
        let bend = 1.0 + (longest / (high - low)).powi(3);
        give = give.max(longest / view.problem.bodies[body].plane_modulus() * bend);
    }
    let sagitta = sagitta(view, c);
    // at a corner of a tied side one integrated condition covers two directions
    let wide = touch.skin.corners && touch.contact.law == Law::Tied;
    let dents = if wide { 4.0 * DENTS } else { DENTS };
    let each = (0..touch.skin.facets.len()).map(|facet| {
        let around = touch.skin.neighbours(facet);
        let nodes = around.flat_map(|f| &touch.skin.facets[f].nodes);
        let pressures = nodes.filter_map(|n| tractions.get(n));
        let pressure = pressures.fold(0.0, |s: f64, p| s.max(*p));
        dents * (give * pressure + sagitta) + view.state.tiny_length()
    });
    each.collect()
}

fn check_supports<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
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
fn check_motion<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    let longest = view.answer.meshes.iter().map(|mesh| {
        let (low, high) = bounds(&mesh.points);
        length(minus(high, low))
    });
    let conditions = view.state.conditions.iter().flatten();
    // what supports drive along several axes, too
    let driven = conditions.fold(0.0, |s: f64, c| s.max(2.0 * c.value.abs()));
    let longest = longest.fold(0.0, f64::max) + driven;
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
fn bears_on_two<const D: usize>(view: &View<'_, D>, body: usize) -> bool {
    let mut contacts = view.touches.iter().zip(&view.step.contacts);
    contacts.any(|(touch, raw)| {
        let touches = touch.own == body || touch.other == Some(body);
        touches && raw.rows.iter().filter(|row| row.pressure > 0.0).count() > 1
    })
}

fn check_equilibrium<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
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
                // an obstacle that a corner meets between its faces lies before neither face
                match own {
                    true => touch.faced.contains(&node) || touch.met.contains(&node),
                    false => touch.faced_other.contains(&node),
                }
            });
            if !faces {
                judgement.compare("outside", left, 10.0 * limit, || view.node(body, node));
            }
        }
    }
}

/// A corner may lean by ten degrees less than to the normal of what it meets, where its own faces end.
const BESIDE: f64 = 0.175;

/// How far a direction at a corner is from that against the surface which its line meets, or one beside: where facets meet, by a twentieth
/// of the way to the middle of those around.
fn leaning<const D: usize>(opposite: &Skin<D>, corner: [f64; D], direction: [f64; D]) -> f64 {
    let around = opposite
        .facets
        .iter()
        .map(|facet| (facet, minus(facet.centre, corner)));
    let around = around.filter(|(facet, way)| length(*way) <= 1.5 * facet.radius);
    let beside = around.map(|(_, way)| plus(corner, 0.05, way));
    let met = beside.chain([corner]).filter_map(|start| {
        let hit = opposite.hit(start, direction, opposite.longest)?;
        let at = opposite.facets[hit.facet].at(hit.xi);
        // kinks of some thirty degrees are smooth or sharp by rounding
        let against = [opposite.normal(hit.facet, &at), unit(at.normal)];
        let off = against.map(|normal| length(plus(direction, 1.0, normal)));
        Some(off[0].min(off[1]))
    });
    met.fold(f64::INFINITY, f64::min)
}

/// Normals of the rows; a support along an axis turns them into the directions that it leaves free.
fn check_normals<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>, c: usize) {
    let touch = &view.touches[c];
    if touch.other.is_none() && !touch.nodal {
        // integrated rows report the side's own normal, not the plane's
        return;
    }
    for row in &view.step.contacts[c].rows {
        let held = |body: usize, node: usize| view.state.held[body].contains_key(&node);
        let partner = touch.other.zip(touch.partners.get(&row.node));
        let Some(samples) = touch.at_nodes.get(&row.node) else {
            continue;
        };
        let turned = held(touch.own, row.node) || partner.is_some_and(|(b, &n)| held(b, n));
        if turned || row.gap.is_nan() {
            continue;
        }
        // the normal of one of the faces that meet at the node, or their mean; at a corner against what it meets
        let faces = touch.skin.normals_at(row.node);
        let off = faces
            .chain(samples.iter().map(|s| s.normal))
            .chain([touch.skin.normal_at(row.node)])
            .map(|n| length(minus(row.normal, n)));
        let off = off.fold(f64::INFINITY, f64::min);
        let limit = 1.1 * touch.skin.turn + 1e-6;
        let corner = view.answer.meshes[touch.own].points[row.node];
        let off = touch.opposite.iter().fold(off, |off, opposite| {
            let met = leaning(opposite, corner, row.normal);
            off.min((met - BESIDE).max(0.0))
        });
        judgement.compare("normal", off, limit, || view.node(touch.own, row.node));
    }
}

/// The largest overlap of a gap whose means vanish, in parts of its range. In the plane the parabola 1/2 − 6(x − 1/2)² on
/// 0 ≤ x ≤ 1 is orthogonal to all linear functions, −1 at the ends and 1/2 in the middle. In space facets are larger, and half of
/// the range is enough; the whole range if a polyhedron may spin onto its corners.
fn averaged<const D: usize>(problem: &Problem<D>) -> f64 {
    match (D, problem.spins) {
        (2, _) => 2.0 / 3.0,
        (_, false) => 0.5,
        (_, true) => 1.0,
    }
}

/// Largest violations of the gap conditions of a contact.
pub struct Limits {
    /// For conditions point by point.
    pub fine: f64,
    /// For integrated conditions, on each facet: the resolution of the mesh, and a part ([`averaged`]) of the variation of the gap on
    /// the facet and its neighbours, over which it is averaged.
    pub coarse: Vec<f64>,
    /// The least and the largest gap at the points between the nodes of each facet.
    ranges: Vec<[f64; 2]>,
}

/// No gap.
const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Limits {
    /// Of a contact whose obstacle has this displacement.
    pub fn new<const D: usize>(view: &View<'_, D>, c: usize, obstacle: [f64; D]) -> Self {
        let touch = &view.touches[c];
        let mut ranges = vec![EMPTY; touch.skin.facets.len()];
        for sample in &touch.facing.between {
            let gap = touch.gap(sample, &view.step.displacements, obstacle, view.step.time);
            let [low, high] = &mut ranges[sample.facet];
            (*low, *high) = (low.min(gap), high.max(gap));
        }
        let resolved = resolution(view, c).into_iter().enumerate();
        let coarse = resolved.map(|(facet, resolved)| {
            let around = touch.skin.neighbours(facet);
            let varies = around.map(|f| (ranges[f][1] - ranges[f][0]).max(0.0));
            resolved + averaged(view.problem) * varies.fold(0.0, f64::max)
        });
        Self {
            fine: view.state.tiny_length() + MOVE * length(obstacle),
            coarse: coarse.collect(),
            ranges,
        }
    }

    /// The range of the gaps on some facets.
    fn range(&self, facets: &[usize]) -> [f64; 2] {
        facets.iter().fold(EMPTY, |[low, high], &f| {
            let [l, h] = self.ranges[f];
            [low.min(l), high.max(h)]
        })
    }
}

fn check_gaps<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>, c: usize) {
    let touch = &view.touches[c];
    let Some(obstacle) = view.obstacles[c] else {
        return;
    };
    let (moves, t) = (&view.step.displacements, view.step.time);
    let limits = Limits::new(view, c, obstacle);
    let linear = touch.skin.linear() && touch.opposite.as_ref().is_none_or(Skin::linear);
    // conditions node by node on plane sides hold between the nodes, too
    let exact = touch.nodal && touch.exact && linear;
    let nodes = touch.at_nodes.values().flatten();
    let between = touch.facing.between.iter().map(|s| (exact, s));
    for (sharp, sample) in nodes.map(|s| (touch.nodal, s)).chain(between) {
        let limit = match sharp {
            true => limits.fine,
            false => limits.coarse[sample.facet],
        };
        let place = || {
            let lost = sample.own.iter().any(|(n, _)| view.lost(touch.own, *n));
            let lost = if lost { DROPPED } else { "" };
            format!(
                "contact {} at {}{lost}",
                touch.contact.name,
                place(sample.x)
            )
        };
        if touch.contact.law == Law::Tied {
            let jump = length(touch.jump(sample, moves, obstacle));
            judgement.compare("jump", jump, limit, place);
        } else {
            let gap = touch.gap(sample, moves, obstacle, t);
            let what = if sharp { "penetration" } else { "overlap" };
            judgement.compare(what, -gap, limit, place);
        }
    }
    check_columns(judgement, view, c, &limits, obstacle);
    if touch.contact.law != Law::Tied {
        check_open_forces(judgement, view, c, &limits, obstacle);
    }
}

/// Gaps and slips of the rows.
fn check_columns<const D: usize>(
    judgement: &mut Judgement,
    view: &View<'_, D>,
    c: usize,
    limits: &Limits,
    obstacle: [f64; D],
) {
    let (touch, t) = (&view.touches[c], view.step.time);
    let moves = &view.step.displacements;
    let rows = &view.step.contacts[c].rows;
    let driven = touch.driven(t).is_some();
    // the position of an obstacle that a force moves is a least-squares fit to the gaps at nodes: it is known up to their residual
    let largest = rows.iter().fold(0.0, |s: f64, r| s.max(r.pressure.abs()));
    let bearing = rows.iter().filter(|r| r.pressure > 1e-6 * largest);
    let left = bearing.filter_map(|row| touch.of_row(row));
    let left = left.map(|(_, s)| touch.gap(&s, moves, obstacle, t).abs());
    let placed = if driven {
        0.0
    } else {
        left.fold(0.0, f64::max)
    };
    let blurred = limits.fine + placed + sagitta(view, c);
    for row in rows.iter().filter(|row| !row.gap.is_nan()) {
        let Some((facets, sample)) = touch.of_row(row) else {
            continue;
        };
        let place = || view.node(touch.own, row.node);
        if touch.nodal {
            let jump = touch.jump(&sample, moves, obstacle);
            // along the row's own normal: a support may have turned it
            let gap = row.gap - touch.clearance(&sample, t) - dot(row.normal, jump);
            judgement.compare("gap", gap.abs(), limits.fine, place);
            // in space, rows without friction tell no slip
            if driven && (D == 2 || touch.contact.law.rough()) {
                let slip = plus(row.slip, 1.0, across(jump, row.normal));
                let held = view.state.held[touch.own].get(&row.node);
                let slip = crate::held::free_part(slip, held);
                judgement.compare("slip", length(slip), limits.fine, place);
            }
        } else if touch.contact.law != Law::Tied && !touch.mixed.contains(&row.node) {
            let gap = touch.gap(&sample, moves, obstacle, t);
            let [low, high] = limits.range(&facets);
            let (low, high) = (low.min(gap), high.max(gap));
            let off = (low - row.gap).max(row.gap - high);
            let limit = blurred + 2.0 * (high - low).max(0.0);
            judgement.compare("gap", off, limit, place);
        }
    }
}

/// No force where the gap is open.
fn check_open_forces<const D: usize>(
    judgement: &mut Judgement,
    view: &View<'_, D>,
    c: usize,
    limits: &Limits,
    obstacle: [f64; D],
) {
    let touch = &view.touches[c];
    let rows = &view.step.contacts[c].rows;
    let largest = rows.iter().fold(0.0, |s: f64, r| s.max(r.pressure.abs()));
    let bears = |row: &&Row<D>| {
        let limit = 10.0 * view.state.limits[touch.own][row.node];
        row.status != Status::Fixed && row.pressure * row.weight > limit
    };
    for row in rows.iter().filter(bears) {
        let Some((_, sample)) = touch.of_row(row) else {
            continue;
        };
        let place = || view.node(touch.own, row.node);
        let gap = touch.gap(&sample, &view.step.displacements, obstacle, view.step.time);
        if touch.nodal {
            judgement.compare("open force", gap, limits.fine, place);
        } else if row.pressure > 1e-2 * largest && !touch.mixed.contains(&row.node) {
            let limit = limits.coarse[sample.facet];
            judgement.compare("open force", gap, limit, place);
        }
    }
}

/// The reported reactions, if no contact touches a supported node.
fn check_reactions<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    let members = view.members();
    for (body, held) in view.state.held.iter().enumerate() {
        if held.keys().any(|&node| members.contains_key(&(body, node))) {
            continue;
        }
        // forces of beds count as reactions
        let (mut sum, mut limit) = (view.state.beds[body], 0.0);
        for (&node, axes) in held {
            let force = view.state.rest[body][node];
            sum = axes.iter().fold(sum, |s, &a| plus(s, dot(force, a), a));
            limit += 10.0 * view.state.limits[body][node];
        }
        if view.state.beds[body] != [0.0; D] {
            let each = view.state.limits[body].iter();
            limit += 10.0 * each.fold(0.0, |s: f64, l| s.max(*l));
        }
        let mut off = minus(view.step.reactions[body], sum);
        // radial forces sum to zero around the axis
        if view.problem.analysis.axisymmetric() {
            off[0] = 0.0;
        }
        let name = &view.problem.bodies[body].name;
        judgement.compare("reaction", length(off), limit, || format!("body {name}"));
    }
}

/// In a step without any change nothing moves.
fn check_idle<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>, index: usize) {
    if !view.problem.idle.contains(&(index + 1)) {
        return;
    }
    for (body, moves) in view.step.displacements.iter().enumerate() {
        for (node, (&now, &before)) in moves.iter().zip(&view.before.moves[body]).enumerate() {
            let off = length(minus(now, before));
            let limit = view.state.tiny_length();
            judgement.compare("idle", off, limit, || view.node(body, node));
        }
    }
}

/// Contact pressures where they are known.
fn check_uniform<const D: usize>(judgement: &mut Judgement, view: &View<'_, D>) {
    let Some(known) = &view.problem.uniform else {
        return;
    };
    let known = known.at([0.0; D], view.step.time);
    for (touch, raw) in view.touches.iter().zip(&view.step.contacts) {
        for row in raw.rows.iter().filter(|r| r.status != Status::Fixed) {
            let off = (row.pressure - known).abs();
            let open = 10.0 * view.state.limits[touch.own][row.node] + view.step.rounding;
            let limit = 1e-6 * known.abs() + open / row.weight;
            judgement.compare("pressure", off, limit, || view.node(touch.own, row.node));
        }
    }
}
