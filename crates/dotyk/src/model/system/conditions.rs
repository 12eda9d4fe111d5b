//! All conditions of a stage, in one order: contacts, then those of the parts in the order of these, bodies that are sectors before all
//! others, then bolts.

use crate::fem::Constraints;
use crate::host::in_order;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::nouns::presence::Stage;
use crate::model::system::bed::bedded;
use crate::model::system::bolt::drawn_together;
use crate::model::system::condition::{Condition, Source};
use crate::model::system::contact::{contact_gaps, touching};
use crate::model::system::couple::{check_held, coupling};
use crate::model::system::cyclic::{check_faces, repeated};
use crate::model::system::laid::lay_members;
use crate::model::system::member::pulling;
use crate::model::system::parts::{Owner, Parts};
use rayon::prelude::*;

/// The conditions of a stage, with the gaps at a time.
///
/// Errors: sides that cannot be paired; members that cannot be laid.
pub(crate) fn all_conditions<const D: usize>(
    stage: &Stage<'_, D>,
    constraints: &[&Constraints<D>],
    time: f64,
) -> Result<Vec<Condition<D>>, Error<D>> {
    let model = stage.model.as_ref();
    let parts = Parts::of(model);
    let contacts = (0..model.contacts.len()).into_par_iter();
    let contacts = contacts.map(|index| touching((model, &parts), constraints, index, time));
    let mut conditions = in_order(contacts)?;
    let laid = lay_members(model)?;
    for (part, owner) in parts.iter() {
        conditions.push(match owner {
            Owner::Body(of) => match &model.bodies[of].cyclic {
                Some(cyclic) => repeated(model, constraints[of], of, cyclic)?,
                None => continue,
            },
            // this part belongs to a contact
            Owner::Obstacle(_) | Owner::Gasket(_) => continue,
            Owner::Point(of, place) => coupling(model, constraints[of], ((of, place), part), time)?,
            Owner::Bed(of, place) => bedded(model, (of, place), part)?,
            Owner::Member(place) => pulling(stage, (place, &laid[place]), part),
        });
    }
    for (place, member) in model.members.iter().enumerate() {
        if let Some(bolt) = member.kind.bolt() {
            conditions.push(drawn_together(stage, constraints, (place, bolt), time)?);
        }
    }
    Ok(conditions)
}

/// Updates the gaps and the motion of obstacles to another time; rows, weights and roles stay.
///
/// Errors: values that are not finite; a support that contradicts that of a point.
pub(crate) fn take_gaps<const D: usize>(
    model: &Model<D>,
    constraints: &[&Constraints<D>],
    conditions: &mut [Condition<D>],
    time: f64,
) -> Result<(), Error<D>> {
    let take = |condition: &mut Condition<D>| match condition.source {
        Source::Contact(index) => contact_gaps(model, constraints, (index, condition), time),
        Source::Of(Owner::Point(of, place)) => check_held(
            model,
            constraints[of],
            (of, place),
            &condition.interface,
            time,
        ),
        Source::Of(Owner::Body(of)) => {
            let body = &model.bodies[of];
            let Some(cyclic) = &body.cyclic else {
                return Ok(());
            };
            check_faces(body, cyclic, constraints[of], &condition.interface)
                .map_err(|source| Error::in_body(body, source))
        }
        Source::Of(Owner::Obstacle(_) | Owner::Gasket(_) | Owner::Bed(..) | Owner::Member(_)) => {
            Ok(())
        }
    };
    let taken: Vec<_> = conditions.par_iter_mut().map(take).collect();
    // of several errors the first one, whatever thread was faster
    taken.into_iter().collect()
}
