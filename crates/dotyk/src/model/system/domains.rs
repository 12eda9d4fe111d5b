//! Domains of bodies coupled by contacts, couples and links, and the scales of their figures.

use crate::dual::{Coupled, Scales};
use crate::geometry::Groups;
use crate::model::nouns::model::Model;
use crate::model::system::bodies::{LoadedBody, largest_load};
use crate::model::system::condition::{Condition, row_ranges};
use crate::model::system::factor::FactoredBody;
use crate::model::system::floating::Floating;

/// The domain of every part: bodies, then rigid parts, then links. Numbered in the order of their first parts.
pub(crate) fn domains<const D: usize>(conditions: &[Condition<D>], parts: usize) -> Vec<usize> {
    let mut groups = Groups::new(parts);
    for condition in conditions {
        for (part, _) in condition.ends() {
            groups.join(condition.nonmortar.body.0, part);
        }
    }
    let firsts: Vec<usize> = (0..parts).map(|part| groups.first(part)).collect();
    let mut numbers = vec![0; parts];
    let mut count = 0;
    for part in 0..parts {
        if firsts[part] == part {
            (numbers[part], count) = (count, count + 1);
        } else {
            numbers[part] = numbers[firsts[part]];
        }
    }
    numbers
}

/// Contacts and domains of the dual problem of some bodies at a time, with d (m,).
pub(crate) fn coupled<const D: usize>(
    model: &Model<D>,
    (bodies, factored): (&[LoadedBody<D>], &[FactoredBody]),
    (conditions, floating): (&[Condition<D>], &Floating),
    shift: &[f64],
) -> Coupled {
    let of_parts = domains(conditions, bodies.len());
    let count = of_parts.iter().max().map_or(0, |last| last + 1);
    let mut scales = vec![Scales::default(); count];
    for (part, (body, factored)) in bodies.iter().zip(factored).enumerate() {
        let own = &mut scales[of_parts[part]];
        own.force = own.force.max(largest_load(std::slice::from_ref(body)));
        // a floating body's energy without contact depends on how it is held for K⁺: leave it out
        if body.system.modes.is_empty() {
            own.energy += factored.energy(body);
        }
        if let Some(body) = model.bodies.get(part) {
            own.moment_arm = own.moment_arm.max(body.mesh.diameter());
        }
    }
    let domain: Vec<usize> = conditions
        .iter()
        .map(|condition| of_parts[condition.nonmortar.body.0])
        .collect();
    let mut contact = vec![0; shift.len()];
    for (index, (rows, _)) in row_ranges(conditions).enumerate() {
        for row in rows {
            contact[row] = index;
            let own = &mut scales[domain[index]];
            own.length = own.length.max(shift[row].abs());
        }
    }
    scales
        .iter_mut()
        .for_each(|own| own.energy = own.energy.abs());
    Coupled {
        contact,
        domain,
        modes: floating.parts_of_balance().map(|p| of_parts[p]).collect(),
        scales,
    }
}

/// The scales of all domains together.
pub(crate) fn whole(coupled: &Coupled) -> Scales {
    let largest = |of: fn(&Scales) -> f64| coupled.scales.iter().map(of).fold(0.0, f64::max);
    Scales {
        length: largest(|s| s.length),
        force: largest(|s| s.force),
        moment_arm: largest(|s| s.moment_arm),
        energy: coupled.scales.iter().map(|s| s.energy).sum(),
    }
}
