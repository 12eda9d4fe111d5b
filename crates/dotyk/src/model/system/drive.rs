//! Driving terms of bodies and conditions at a time: loads, prescribed values, gaps, and the offset forces of joints and members.

use crate::fem::{BodySystem, Constraints, Part};
use crate::geometry::norm;
use crate::host::in_order;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::system::bodies::LoadedBody;
use crate::model::system::bolt::take_tension;
use crate::model::system::border::join_borders;
use crate::model::system::condition::Condition;
use crate::model::system::conditions::take_gaps;
use crate::model::system::dependent::drop_implied;
use crate::model::system::filling::Filling;
use crate::model::system::gasket::fill;
use crate::model::system::joints::{Lost, restore, set_offsets};
use crate::model::system::parts::rigid_systems;
use crate::model::system::shared::share_nodes;
use crate::model::system::tied::agree_with_supports;
use rayon::prelude::*;

/// Bodies and conditions with the loads, prescribed displacements and gaps of another time. With `part` the loads and prescribed
/// displacements of bodies are those at a fraction of the step; gaps and prestress are those of the time.
pub(crate) fn driven<const D: usize>(
    model: &Model<D>,
    bodies: Vec<LoadedBody<D>>,
    mut conditions: Vec<Condition<D>>,
    (time, part): (f64, Option<Part>),
) -> Result<(Vec<LoadedBody<D>>, Vec<Condition<D>>), Error<D>> {
    let mut rigid = bodies;
    let bodies = rigid.drain(..model.bodies.len()).collect::<Vec<_>>();
    let each = (&model.bodies, bodies).into_par_iter();
    let each = each.map(|(body, loaded)| {
        let system = loaded.system.at_part(body, model.analysis, time, part);
        let system = system.map_err(|source| Error::in_body(body, source))?;
        Ok((system, loaded.rows))
    });
    let (mut systems, mut rows): (Vec<_>, Vec<_>) = in_order(each)?.into_iter().unzip();
    let mut of_rigid = rigid_systems(model, time)?;
    if let Some(part) = part {
        let before = part.before.map(|time| rigid_systems(model, time));
        let before = before.transpose()?;
        for (index, system) in of_rigid.iter_mut().enumerate() {
            system.on_the_way(part, before.as_ref().map(|before| &before[index]));
        }
    }
    // the parts of links do not know the time
    let links = rigid.split_off(of_rigid.len());
    systems.extend(of_rigid);
    rows.extend(rigid.into_iter().map(|part| part.rows));
    set_offsets(model, &mut conditions, time)?;
    take_tension(model, &mut conditions, time)?;
    add_offsets(&mut systems, &conditions);
    let loaded = systems.into_par_iter().zip(rows);
    let mut bodies: Vec<LoadedBody<D>> = loaded.map(|(s, r)| LoadedBody::new(s, r)).collect();
    bodies.extend(links);
    let constraints: Vec<&Constraints<D>> = bodies.iter().map(|b| &b.system.constraints).collect();
    take_gaps(model, &constraints, &mut conditions, time)?;
    agree_with_supports(model, &constraints, &conditions)?;
    Ok((bodies, conditions))
}

/// State of a contact before a step: lost nodes of a joint, and a gasket.
pub(crate) type Before<'s> = (Option<&'s Lost>, Option<&'s Filling>);

/// Finds the state of a contact by its name.
pub(crate) type States<'a, 's> = dyn Fn(&str) -> Before<'s> + 'a;

/// Completes the systems of bodies and rigid parts by those of links, gives common nodes of contacts one multiplier, drops conditions
/// implied by others, and adds the offset forces of joints and members to the loads, at a time; `before` gives the states of joints and
/// gaskets by the names of contacts. Returns warnings about dropped conditions.
///
/// Errors: those of [`agree_with_supports`], [`set_offsets`] and [`fill`].
pub(crate) fn complete<'s, const D: usize>(
    model: &Model<D>,
    systems: &mut Vec<BodySystem<D>>,
    (conditions, before): (&mut [Condition<D>], &States<'_, 's>),
    time: f64,
) -> Result<Vec<String>, Error<D>> {
    join_borders(model, conditions);
    fill(model, conditions, &|name| before(name).1)?;
    systems.extend(link_systems(conditions));
    restore(model, conditions, &|name| before(name).0);
    share_nodes(model, systems, conditions);
    let constraints: Vec<&Constraints<D>> = systems.iter().map(|s| &s.constraints).collect();
    agree_with_supports(model, &constraints, conditions)?;
    let dropped = drop_implied(model, systems, conditions);
    set_offsets(model, conditions, time)?;
    add_offsets(systems, conditions);
    Ok(dropped)
}

/// The parts of all links.
fn link_systems<const D: usize>(conditions: &[Condition<D>]) -> Vec<BodySystem<D>> {
    let links = conditions
        .iter()
        .filter_map(|condition| condition.elastic.as_ref());
    links
        .map(|part| BodySystem::elastic(&part.stiffness, &part.load))
        .collect()
}

/// Adds the offset forces of contacts and links to the loads: of all systems or, where links keep their loads, of those before them.
pub(crate) fn add_offsets<const D: usize>(
    systems: &mut [BodySystem<D>],
    conditions: &[Condition<D>],
) {
    for condition in conditions {
        for &(body, node, force) in &condition.steady {
            let system = &mut systems[body];
            system.add_force(&[(node, force)], 1.0);
            system.largest_load = system.largest_load.max(norm(force));
        }
        for (part, rows) in condition.ends() {
            let Some(system) = systems.get_mut(part) else {
                continue;
            };
            for (row, &offset) in rows
                .iter()
                .zip(&condition.offset)
                .filter(|(_, offset)| **offset != 0.0)
            {
                system.add_force(row, -offset);
            }
        }
    }
}
