//! Results of bodies and contacts: stresses, reactions by side, and the state of every contact node.

use crate::contact::{Coupling, InterfaceNode, Role, pushed};
use crate::dual::{AdmissibleSet, NONE};
use crate::fem::{
    Borders, FemError, RigidBasis, Yielded, describe_motion, fit_rigid, overstress, recover_strain,
    recover_yielded, recover_yielded_stress, von_mises,
};
use crate::geometry::{Point, add_scaled, bounding_box, centroid, cross, distance, dot, norm, sub};
use crate::host::in_order;
use crate::model::nouns::error::Error;
use crate::model::nouns::ids::SideRef;
use crate::model::nouns::model::{Analysis, Body, Model, Place, Support};
use crate::model::nouns::solution::*;
use crate::model::read::beds::bed_solutions;
use crate::model::read::coupled::couple_solutions;
use crate::model::system::bodies::LoadedBody;
use crate::model::system::border::tell_twins;
use crate::model::system::condense::Condensed;
use crate::model::system::condition::{Condition, Source, contact_rows, row_ranges};
use crate::model::system::displaced::{Displaced, moved};
use crate::model::system::parts::Owner;
use crate::model::system::recover::BodyState;
use crate::model::system::shared::share_out;
use crate::solve::{Shear, State};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Solutions of all bodies, contacts and beds.
type Fields<const D: usize> = (
    Vec<BodySolution<D>>,
    Vec<ContactSolution<D>>,
    Vec<BedSolution<D>>,
);

/// Solutions of all bodies, contacts and beds from their displacements, and forces `lambda` (m,).
///
/// Errors: a group of cells without a material.
pub(crate) fn fields<const D: usize>(
    model: &Model<D>,
    condensed: &Condensed<D>,
    mut displaced: Displaced<D>,
    lambda: &[f64],
) -> Result<Fields<D>, Error<D>> {
    let shears = shears(&condensed.problem.admissible, lambda);
    let contacts = contact_rows(&condensed.conditions);
    let contacts = contacts.map(|(index, (rows, condition))| {
        let contact = &model.contacts[index];
        let obstacle = moved(condition, &displaced).obstacle;
        let rows = Rows {
            gaps: &displaced.gaps[rows.clone()],
            borne: &lambda[rows.clone()],
            lambda: &condition.forces(&lambda[rows.clone()]),
            shears: &shears[rows],
            dissipated: condensed.state.dissipated(&contact.name),
        };
        contact_solution(
            model,
            &contact.name,
            condition,
            (&displaced.states, obstacle),
            rows,
        )
    });
    let mut contacts: Vec<ContactSolution<D>> = contacts.collect();
    let of_rows = [lambda, &displaced.gaps];
    share_out(
        model,
        &condensed.conditions,
        of_rows,
        condensed.time,
        &mut contacts,
    );
    for ((_, (_, condition)), told) in contact_rows(&condensed.conditions).zip(&mut contacts) {
        tell_twins(condition, told);
    }
    for (contact, told) in model.contacts.iter().zip(&mut contacts) {
        told.tell_for(contact.pair.first());
    }
    let couples = couple_solutions(model, condensed, &displaced, lambda);
    let links = link_forces(model, &condensed.conditions, lambda, &mut displaced.states);
    let beds = bed_solutions(model, condensed, &displaced.states, lambda)?;
    let others = couples.into_par_iter().zip(links);
    let before = condensed.state.yielded();
    let bodies = (&model.bodies, &condensed.bodies, displaced.states);
    let bodies = bodies.into_par_iter().zip(before).zip(others);
    let bodies = bodies.map(|(((body, loaded, state), before), others)| {
        let time = condensed.time;
        body_solution((model, time), (body, loaded, before), state, others)
    });
    Ok((in_order(bodies)?, contacts, beds))
}

/// Pressure of the water in the pores of a body at a time, by place.
///
/// Errors: an expression that is not finite.
fn pore_pressure<const D: usize>(
    body: &Body<D>,
    borders: &Borders,
    time: f64,
) -> Result<Option<Vec<f64>>, FemError> {
    let points = body.mesh.points();
    let of_node = |node: usize| body.initial.pore_at(points[node], time);
    borders.nodes().map(of_node).collect()
}

fn body_solution<const D: usize>(
    (model, time): (&Model<D>, f64),
    (body, factored, before): (&Body<D>, &LoadedBody<D>, Option<Arc<Yielded>>),
    mut state: BodyState<D>,
    (couples, member_forces): (Vec<CoupleSolution<D>>, BTreeMap<usize, Point<D>>),
) -> Result<BodySolution<D>, Error<D>> {
    let fail = |source| Error::in_body(body, source);
    let yielded = factored.system.history.yielded.as_deref();
    let with = (body, model.analysis);
    let none = (body.ages() || body.is_plastic()).then(|| Yielded::nothing(body, model.analysis));
    let none = none.transpose().map_err(fail)?;
    let inelastic = yielded.or(none.as_ref());
    // of a body that ages the stress is read in one way in all steps
    let known = if body.ages() { inelastic } else { yielded };
    let stress = recover_yielded_stress(with, &state.u, time, known).map_err(fail)?;
    let borders = Borders::of(body).map_err(fail)?;
    let yielding = yielding(model, (body, yielded), (before, &state), &borders).map_err(fail)?;
    let grown = yielding.as_ref().map(|own| &own.equivalent[..]);
    let pore_pressure = pore_pressure(body, &borders, time).map_err(fail)?;
    let water = pore_pressure.as_deref();
    let between_grains = water.map(|water| effective_stress(&stress, water));
    let judged = between_grains.as_deref().unwrap_or(&stress);
    let utilisation = overstress(body, &borders, judged, grown).map_err(fail)?;
    let strain = recover_strain(body, model.analysis, &state.u, time).map_err(fail)?;
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
    let mut side_reactions = side_reactions(body, factored, &state.reactions);
    let part_reactions = part_reactions(body, factored, &state.reactions);
    for (spring, forces) in body.springs.iter().zip(&state.springs) {
        if let Place::Side(side) = spring.place() {
            let sum = side_reactions.entry(side).or_insert([0.0; D]);
            *sum = forces.iter().fold(*sum, |sum, &f| add_scaled(sum, 1.0, f));
        }
        let reactions = state.reactions.iter_mut().zip(forces);
        reactions.for_each(|(sum, &force)| *sum = add_scaled(*sum, 1.0, force));
    }
    Ok(BodySolution {
        name: body.name.clone(),
        member_forces,
        borders,
        von_mises: stress.iter().map(|&s| von_mises(s)).collect(),
        stress,
        strain,
        contact_forces: state.contact_forces,
        side_reactions,
        part_reactions,
        reaction: (state.reactions.iter())
            .chain(couples.iter().map(|couple| &couple.reaction))
            .fold([0.0; D], |sum, &f| add_scaled(sum, 1.0, f)),
        couples,
        reactions: state.reactions,
        floating_modes,
        rigid: RigidMotion {
            translation,
            rotation,
        },
        strain_energy: state.strain_energy,
        dofs: D * points.len(),
        displacement: state.u,
        fitted: None,
        peak: None,
        pore_pressure,
        utilisation: utilisation.map(|own| Utilisation {
            nodal: own.utilisation,
            overstressed: own.extent,
            judged: own.whole,
            peak: None,
        }),
        yielding,
        inelastic: inelastic.map(|own| own.0.clone()),
    })
}

/// Yielding of a body since the last step began.
///
/// Errors: a group of cells without a material.
fn yielding<const D: usize>(
    model: &Model<D>,
    (body, yielded): (&Body<D>, Option<&Yielded>),
    (before, state): (Option<Arc<Yielded>>, &BodyState<D>),
    borders: &Borders,
) -> Result<Option<Yielding>, FemError> {
    if !body.is_plastic() {
        return Ok(None);
    }
    let Some(yielded) = yielded else {
        return Ok(Some(Yielding {
            strain: vec![[0.0; 6]; borders.count()],
            equivalent: vec![0.0; borders.count()],
            share: vec![0.0; borders.count()],
            cells: vec![0.0; body.mesh.cell_count()],
            extent: 0.0,
        }));
    };
    let found = recover_yielded((body, model.analysis), yielded, before.as_deref())?;
    Ok(Some(Yielding {
        strain: found.strain,
        equivalent: found.equivalent,
        share: found.share,
        cells: found.cells,
        extent: state.yielded,
    }))
}

/// Moves forces of beds that only press from the contact forces to those of springs, where they belong, and the forces of members from
/// there to the result: forces by node ON each body.
fn link_forces<const D: usize>(
    model: &Model<D>,
    conditions: &[Condition<D>],
    lambda: &[f64],
    states: &mut [BodyState<D>],
) -> Vec<BTreeMap<usize, Point<D>>> {
    let count = states.len();
    let mut of_members = vec![BTreeMap::new(); model.bodies.len()];
    for (rows, condition) in row_ranges(conditions) {
        for (body, rows_on) in condition.ends().filter(|(part, _)| *part < count) {
            // the contact forces already contain those of the problem
            for (row, offset) in rows_on.iter().zip(&condition.offset) {
                for &(node, c) in row.iter().filter(|_| *offset != 0.0) {
                    let sum = &mut states[body].contact_forces[node];
                    *sum = add_scaled(*sum, -offset, c);
                }
            }
            if !condition.is_link() && condition.source.member().is_none() {
                continue;
            }
            let forces = condition.forces(&lambda[rows.clone()]);
            let forces = rows_on.iter().zip(forces);
            let forces =
                forces.flat_map(|(row, l)| row.iter().map(move |&(n, c)| (n, c.map(|c| -l * c))));
            for (node, force) in forces {
                let state = &mut states[body];
                state.contact_forces[node] = add_scaled(state.contact_forces[node], -1.0, force);
                let sum = match condition.source {
                    Source::Of(Owner::Bed(_, spring)) => &mut state.springs[spring][node],
                    Source::Of(Owner::Member(_)) => {
                        of_members[body].entry(node).or_insert([0.0; D])
                    }
                    // these are not links
                    Source::Contact(_)
                    | Source::Of(
                        Owner::Body(_) | Owner::Obstacle(_) | Owner::Point(..) | Owner::Gasket(_),
                    ) => {
                        continue;
                    }
                };
                *sum = add_scaled(*sum, 1.0, force);
            }
        }
        for &(body, node, force) in &condition.steady {
            let sum = of_members[body].entry(node).or_insert([0.0; D]);
            *sum = add_scaled(*sum, 1.0, force);
        }
    }
    of_members
}

/// Reactions by the side whose support holds the direction; shared directions are split evenly.
fn side_reactions<const D: usize>(
    body: &Body<D>,
    loaded: &LoadedBody<D>,
    reactions: &[Point<D>],
) -> BTreeMap<String, Point<D>> {
    let mut sums = BTreeMap::new();
    for (support, _, force) in support_forces(loaded, reactions) {
        if let Place::Side(side) = &body.supports[support].place {
            let sum = sums.entry(side.clone()).or_insert([0.0; D]);
            *sum = add_scaled(*sum, 1.0, force);
        }
    }
    sums
}

/// Support, node and force ON the body: reactions (nodes,) by who holds the direction; shared directions are split evenly.
pub(crate) fn support_forces<const D: usize>(
    loaded: &LoadedBody<D>,
    reactions: &[Point<D>],
) -> impl Iterator<Item = (usize, usize, Point<D>)> {
    let nodes = loaded.system.constraints.nodes.iter();
    let held = nodes.flat_map(|(&node, held)| held.iter().map(move |h| (node, h)));
    held.flat_map(|(node, h)| {
        let part = dot(reactions[node], h.axis) / h.supports.len() as f64;
        let force = h.axis.map(|a| part * a);
        h.supports
            .iter()
            .map(move |&support| (support, node, force))
    })
}

/// Reactions of supports on larger sides at the nodes of the sides that are parts of them.
fn part_reactions<const D: usize>(
    body: &Body<D>,
    loaded: &LoadedBody<D>,
    reactions: &[Point<D>],
) -> BTreeMap<String, Point<D>> {
    let mesh = &body.mesh;
    let held = |support: &Support<D>| match &support.place {
        Place::Side(side) => Some(side.clone()),
        Place::Point(_) => None,
    };
    let held: Vec<Option<String>> = body.supports.iter().map(held).collect();
    let mut sums = BTreeMap::new();
    for (part, facets) in mesh.sides() {
        let within = |side: &Option<String>| {
            let whole = side.as_ref().filter(|side| *side != part);
            let whole = whole.and_then(|side| mesh.side(side)).unwrap_or_default();
            !facets.is_empty()
                && facets
                    .iter()
                    .all(|facet| whole.binary_search(facet).is_ok())
        };
        let larger: Vec<bool> = held.iter().map(within).collect();
        if !larger.contains(&true) {
            continue;
        }
        let nodes = mesh.side_nodes(part).unwrap_or_default();
        let sum = sums.entry(part.clone()).or_insert([0.0; D]);
        for node in nodes.into_iter().map(|node| node as usize) {
            for h in loaded.system.constraints.at(node) {
                let part = dot(reactions[node], h.axis) / h.supports.len() as f64;
                let own = h
                    .supports
                    .iter()
                    .filter(|&&support| larger[support])
                    .count();
                *sum = add_scaled(*sum, part * own as f64, h.axis);
            }
        }
    }
    sums
}

/// Results of the rows of one contact.
struct Rows<'a> {
    gaps: &'a [f64],
    /// Forces.
    lambda: &'a [f64],
    /// The same, counted from the tensile strength of joints: zero where they are open.
    borne: &'a [f64],
    /// State of the shear of nodes with friction, at their normal rows; `None` elsewhere.
    shears: &'a [Option<Shear>],
    /// Work that friction dissipated in them before this step.
    dissipated: f64,
}

/// State of the shear of every node with friction, at its normal row (m,).
fn shears(admissible: &AdmissibleSet, lambda: &[f64]) -> Vec<Option<Shear>> {
    let mut shears = vec![None; lambda.len()];
    for (block, range) in admissible.iter() {
        let first = range.start;
        let state = State::of_forces(block, &lambda[range]);
        shears[first] = block.friction().map(|_| state.shear);
    }
    shears
}

/// Tangential displacement of a node relative to the other side by its rows; along a direction without a row, held by supports, the
/// displacement `at_node`.
fn mean_slip<const D: usize>(
    condition: &Condition<D>,
    node: &InterfaceNode<D>,
    at_node: Point<D>,
    (states, obstacle): (&[BodyState<D>], Point<D>),
) -> Point<D> {
    let interface = &condition.interface;
    let mut slip = [0.0; D];
    for (direction, row) in node.frame.into_iter().zip(node.rows).skip(1) {
        let along = match row {
            None => dot(at_node, direction),
            Some(row) => {
                let own = interface.nonmortar[row].iter();
                let own = own.map(|&(j, c)| dot(c, states[condition.nonmortar.body.0].u[j]));
                let other = interface.mortar[row].iter();
                let other = other.map(|&(j, c)| match &condition.mortar {
                    Some(mortar) => dot(c, states[mortar.body.0].u[j]),
                    None => dot(c, obstacle),
                });
                let rows = [&interface.nonmortar[row], &interface.mortar[row]];
                let fitted = condition.touch.fit.along(rows[0], rows[1]);
                own.sum::<f64>() + other.sum::<f64>() - fitted
            }
        };
        slip = add_scaled(slip, along, direction);
    }
    slip
}

fn contact_solution<const D: usize>(
    model: &Model<D>,
    name: &str,
    condition: &Condition<D>,
    (states, obstacle): (&[BodyState<D>], Point<D>),
    Rows {
        gaps,
        lambda,
        borne,
        shears,
        dissipated: before,
    }: Rows<'_>,
) -> ContactSolution<D> {
    let body = &model.bodies[condition.nonmortar.body.0];
    let coupling = condition.interface.coupling;
    // projected methods leave small forces where a contact is open
    let none = NONE * borne.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    let node_state = |(place, node): (usize, &InterfaceNode<D>)| {
        let u_nonmortar = states[condition.nonmortar.body.0].u[node.node];
        let u_mortar = match &condition.mortar {
            Some(_) if node.opposite.is_empty() => None,
            Some(mortar) => {
                let u = &states[mortar.body.0].u;
                let opposite = node.opposite.iter();
                Some(opposite.fold([0.0; D], |sum, &(j, n)| add_scaled(sum, n, u[j])))
            }
            None if matches!(node.role, Role::Alone | Role::Excluded) => None,
            None => Some(obstacle),
        };
        let along = |u: Point<D>| dot(node.normal(), u);
        let fitted = condition
            .touch
            .fit
            .jump(&[(node.node, 1.0)], &node.opposite);
        let displacement_nonmortar = along(u_nonmortar);
        let displacement_mortar = u_mortar.map_or(f64::NAN, along);
        let at_node = u_mortar.map_or([f64::NAN; D], |u| {
            let relative = sub(sub(u_nonmortar, u), fitted);
            add_scaled(relative, -along(relative), node.normal())
        });
        // friction opposes the slip of its rows; in the plane, with only two directions, the slip of the node is given
        let slip = match D {
            2 => at_node,
            _ => mean_slip(condition, node, at_node, (states, obstacle)),
        };
        let (gap, pressure, status) = match (node.role, node.rows[0]) {
            (Role::Alone | Role::Excluded, _) => (f64::NAN, 0.0, Status::Open),
            (Role::Multiplier, Some(row)) => {
                let status = match (coupling, &shears[row]) {
                    (Coupling::Tied, _) => Status::Tied,
                    _ if borne[row] <= none => Status::Open,
                    (_, None) => Status::Closed,
                    (_, Some(Shear::Stick)) => Status::Stick,
                    (_, Some(Shear::Slip { .. } | Shear::Smooth)) => Status::Slip,
                };
                // of a gasket it is minus the closure
                let gap = gaps[row] - condition.closure(place, lambda).unwrap_or(0.0);
                (gap, lambda[row] / node.weight, status)
            }
            (role, _) => {
                let gap = node.gap + along(fitted) - displacement_nonmortar + displacement_mortar;
                let status = match role {
                    Role::Multiplier => Status::Tied,
                    _ => Status::Fixed,
                };
                (gap, f64::NAN, status)
            }
        };
        // the rows push the nonmortar body by −λ
        let directions = node.frame.into_iter().zip(node.rows).skip(1);
        let shear = directions.fold([0.0; D], |sum, (direction, row)| {
            let traction = row.map_or(0.0, |row| -lambda[row] / node.weight);
            add_scaled(sum, traction, direction)
        });
        ContactNode {
            node: node.node,
            partner: condition.mortar.as_ref().and_then(|_| node.partner()),
            point: body.mesh.points()[node.node],
            normal: node.normal(),
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
    let nodes: Vec<ContactNode<D>> = condition
        .interface
        .nodes
        .iter()
        .enumerate()
        .map(node_state)
        .collect();
    let touching = |n: &ContactNode<D>| n.status != Status::Open && n.status != Status::Fixed;
    let length = |counts: &dyn Fn(&ContactNode<D>) -> bool| {
        let extents = nodes.iter().zip(&condition.interface.nodes);
        let counted = extents.filter(|(state, _)| counts(state));
        // the sum of nothing is -0
        counted.fold(0.0, |sum, (_, node)| sum + node.extent)
    };
    let (resultant, moment, imbalance) = balance(model, condition, lambda);
    let tangential = condition.slides().into_iter();
    let work = tangential.zip(lambda.iter().zip(gaps));
    let dissipated = work.map(|(is, (l, gap))| if is { -l * gap } else { 0.0 });
    let dissipated = dissipated.sum::<f64>();
    ContactSolution {
        name: name.to_string(),
        nonmortar: condition.nonmortar.clone(),
        mortar: condition.mortar.clone(),
        length: length(&touching),
        length_stick: length(&|n| n.status == Status::Stick),
        length_slip: length(&|n| n.status == Status::Slip),
        nodes,
        cyclic: condition.interface.cyclic,
        first: condition.nonmortar.clone(),
        resultant,
        moment,
        imbalance,
        obstacle: condition.mortar.is_none().then_some(obstacle),
        dissipated,
        dissipated_total: before + dissipated,
    }
}

/// The force on the nonmortar body, its moment about the origin, and the imbalance of the forces on both bodies as the rows of B apply
/// them: forces relative to the sum of the nodal forces, moments to that times the size of the interface; the larger.
fn balance<const D: usize>(
    model: &Model<D>,
    condition: &Condition<D>,
    lambda: &[f64],
) -> (Point<D>, [f64; 3], f64) {
    let points = |side: &SideRef| model.bodies[side.body.0].mesh.points();
    let own = points(&condition.nonmortar);
    let nodes: Vec<Point<D>> = condition
        .interface
        .nodes
        .iter()
        .map(|n| own[n.node])
        .collect();
    let (low, high) = bounding_box(&nodes);
    let centre = centroid(&[low, high]);
    let (resultant, moment) = pushed(&condition.interface.nonmortar, lambda, own, centre);
    let about_origin = add_scaled(moment, 1.0, cross(centre, resultant));
    let magnitude: f64 = lambda.iter().map(|l| l.abs()).sum();
    let Some(mortar) = condition.mortar.as_ref().filter(|_| magnitude > 0.0) else {
        return (resultant, about_origin, 0.0);
    };
    let (force, other) = pushed(&condition.interface.mortar, lambda, points(mortar), centre);
    let (mut rest, mut turn) = (
        add_scaled(resultant, 1.0, force),
        norm(add_scaled(moment, 1.0, other)),
    );
    if model.analysis == Analysis::Axisymmetric {
        // radial forces and moments balance over the full turn
        (rest[0], turn) = (0.0, 0.0);
    }
    let size = distance(low, high);
    let imbalance = norm(rest).max(turn / size) / magnitude;
    (resultant, about_origin, imbalance)
}
