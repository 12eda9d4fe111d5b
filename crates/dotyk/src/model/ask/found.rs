//! Finds contacts between bodies, and names their sides.
//!
//! The facets of a body that face another one are a side of it: one that it has, or several of its sides together, if these are the same
//! facets; else a new side "contact-b" of body a. What is found is written into the model as any contact with `sides`.

use crate::contact::{Faced, Neighbours, Sight};
use crate::fem::{Active, Body};
use crate::mesh::{Facet, Mesh, MeshError};
use crate::model::nouns::finding::{Finding, FindingError, Found};
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::model::{Contact, Model, Pair};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// New sides are named after the other body, with this before it.
const SIDE: &str = "contact-";

impl<const D: usize> Model<D> {
    /// Adds the contacts that are found between bodies; returns what was found, contacts included. The model's contacts so far count as
    /// written: a pair of bodies with one of these is left to it.
    ///
    /// Errors: see [`FindingError`].
    pub fn find_contacts(&mut self, finding: &Finding) -> Result<Found<D>, FindingError> {
        let found = find(finding, &mut self.bodies, (&self.contacts, &[]))?;
        self.contacts.extend(found.contacts.iter().cloned());
        Ok(found)
    }
}

/// The contacts between bodies that were not `written`, and none between those of others that were `found` before.
///
/// Errors: see [`FindingError`].
pub(crate) fn find<const D: usize>(
    finding: &Finding,
    bodies: &mut [Body<D>],
    (written, found): (&[Contact<D>], &[Contact<D>]),
) -> Result<Found<D>, FindingError> {
    let sorted = sorted(finding, bodies)?;
    let seen: Vec<Seen> = {
        let neighbours = Neighbours::of(bodies.iter().map(|body| &*body.mesh));
        let candidates = neighbours.candidates(&sorted, finding.reach);
        let look = |&pair: &[usize; 2]| look(finding, bodies, &neighbours, pair);
        let seen: Vec<Seen> = candidates.par_iter().filter_map(look).collect();
        if seen.iter().all(|seen| seen.faced.facets[0].is_empty()) {
            let every = sorted.iter().enumerate();
            let every = every.flat_map(|(k, &a)| sorted[k + 1..].iter().map(move |&b| [a, b]));
            let open = every.filter(|&pair| {
                together(finding, bodies, pair).is_some()
                    && contacts_of(written, pair).next().is_none()
            });
            let open: Vec<[usize; 2]> = open.collect();
            let named = |(pair, distance): ([usize; 2], f64)| {
                (pair.map(|body| bodies[body].name.clone()), distance)
            };
            return Err(FindingError::Nothing {
                name: finding.name.clone(),
                reach: finding.reach,
                nearest: neighbours.nearest(&open).map(named),
            });
        }
        seen
    };
    let mut result = Found {
        contacts: Vec::new(),
        left: Vec::new(),
        warnings: Vec::new(),
    };
    for Seen {
        pair,
        faced,
        active,
        deep,
    } in seen
    {
        let names = pair.map(|body| bodies[body].name.clone());
        if let Some(contact) = contacts_of(written, pair).next() {
            let others = contacts_of(written, pair);
            result
                .left
                .extend(left(bodies, (pair, &faced), contact, others));
        } else if faced.facets[0].is_empty() {
            result.warnings.push(format!(
                "contact \"{}\": bodies \"{}\" and \"{}\" overlap at first by {:.4e}, which is more than `reach` ({:.4e}): nothing was found between them; give a larger one",
                finding.name, names[0], names[1], deep, faced.reach
            ));
        } else if let Some(first) = contacts_of(found, pair).next() {
            return Err(FindingError::Twice {
                second: finding.name.clone(),
                first: first.name.clone(),
                bodies: names,
            });
        } else {
            let [a, b] = [0, 1].map(|k| {
                let body = &mut bodies[pair[k]];
                let side = named_side(
                    Arc::make_mut(&mut body.mesh),
                    &faced.facets[k],
                    &names[1 - k],
                );
                let side = side.map_err(|side| FindingError::SideExists {
                    name: finding.name.clone(),
                    body: names[k].clone(),
                    side,
                });
                side.map(|side| SideRef {
                    body: BodyId(pair[k]),
                    side,
                })
            });
            result.contacts.push(Contact {
                name: finding.name_of(names.each_ref().map(String::as_str)),
                pair: Pair::Automatic([a?, b?]),
                pairing: finding.pairing,
                gap: finding.gap.clone(),
                law: finding.law.clone(),
                gasket: None,
                reach: None,
                exclude: Vec::new(),
                friction_exclude: Vec::new(),
                active,
            });
        }
    }
    Ok(result)
}

/// Two bodies, and what of them faces each other.
struct Seen {
    pair: [usize; 2],
    faced: Faced,
    /// When the contact is there.
    active: Active,
    /// How deep the bodies lie in each other, where nothing faces each other within the reach.
    deep: f64,
}

/// The bodies in the order of the model.
///
/// Errors: fewer than two bodies, one of them twice.
fn sorted<const D: usize>(
    finding: &Finding,
    bodies: &[Body<D>],
) -> Result<Vec<usize>, FindingError> {
    let name = || finding.name.clone();
    let mut sorted: Vec<usize> = finding.bodies.iter().map(|body| body.0).collect();
    sorted.sort_unstable();
    if let Some(twice) = sorted.windows(2).find(|two| two[0] == two[1]) {
        let body = bodies[twice[0]].name.clone();
        return Err(FindingError::Repeated { name: name(), body });
    }
    match sorted.len() {
        count @ (0 | 1) => Err(FindingError::TooFew {
            name: name(),
            count,
        }),
        _ => Ok(sorted),
    }
}

/// When two bodies and a contact between them are there; `None`: never.
fn together<const D: usize>(
    finding: &Finding,
    bodies: &[Body<D>],
    pair: [usize; 2],
) -> Option<Active> {
    let [a, b] = pair.map(|body| bodies[body].active);
    let all = [a, b, finding.active];
    let from = all
        .iter()
        .map(|active| active.from)
        .fold(f64::NEG_INFINITY, f64::max);
    let until = all
        .iter()
        .map(|active| active.until)
        .fold(f64::INFINITY, f64::min);
    (from < until).then_some(Active { from, until })
}

/// What of two bodies faces each other, if something does, or how deep they lie in each other. Others hide what lies behind them if they
/// are there all the time that the two are; if they hide everything and come or go, the contact is there when they are not.
fn look<const D: usize>(
    finding: &Finding,
    bodies: &[Body<D>],
    neighbours: &Neighbours<'_, D>,
    pair: [usize; 2],
) -> Option<Seen> {
    let both = together(finding, bodies, pair)?;
    let others = (0..bodies.len()).filter(|other| !pair.contains(other));
    let meets = |other: &usize| bodies[*other].active.meets(both);
    let stays = |other: &usize| {
        let active = bodies[*other].active;
        active.from <= both.from && active.until >= both.until
    };
    let (staying, passing): (Vec<usize>, Vec<usize>) = others.filter(meets).partition(stays);
    let sight = match finding.is_closed_anywhere() {
        true => Sight::Middle,
        false => Sight::Any,
    };
    let faced = neighbours.faced(pair, finding.reach, &staying, sight);
    if faced.facets[0].is_empty() {
        let deep = neighbours.depth(pair);
        let active = finding.active;
        return (deep > faced.reach).then_some(Seen {
            pair,
            faced,
            active,
            deep,
        });
    }
    let hides = |other: &usize| {
        let between: Vec<usize> = staying.iter().copied().chain([*other]).collect();
        let left = neighbours.faced(pair, Some(faced.reach), &between, sight);
        left.facets[0].is_empty()
    };
    let mut active = finding.active;
    let beside = |other: &usize| neighbours.is_beside(*other, pair, faced.reach);
    for other in passing.into_iter().filter(beside).filter(hides) {
        let there = bodies[other].active;
        match there.from <= both.from {
            true => active.from = active.from.max(there.until),
            false => active.until = active.until.min(there.from),
        }
    }
    (active.from < active.until).then_some(Seen {
        pair,
        faced,
        active,
        deep: 0.0,
    })
}

/// The contacts between two bodies.
fn contacts_of<const D: usize>(
    contacts: &[Contact<D>],
    pair: [usize; 2],
) -> impl Iterator<Item = &Contact<D>> + Clone {
    contacts
        .iter()
        .filter(move |contact| match contact.pair.sides()[..] {
            [one, other] => {
                let sides = [one.body.0, other.body.0];
                sides == pair || sides == [pair[1], pair[0]]
            }
            _ => false,
        })
}

/// What faces each other of two bodies and is not on the sides of their written contacts.
fn left<'c, const D: usize>(
    bodies: &[Body<D>],
    (pair, faced): ([usize; 2], &Faced),
    first: &Contact<D>,
    contacts: impl Iterator<Item = &'c Contact<D>> + Clone,
) -> Option<String> {
    let [a, b] = [0, 1].map(|k| {
        let body = &bodies[pair[k]];
        let sides = contacts.clone().flat_map(|contact| contact.pair.sides());
        let own = sides.filter(|side| side.body.0 == pair[k]);
        let on_sides: BTreeSet<Facet> = own
            .flat_map(|side| body.mesh.side(&side.side).unwrap_or_default())
            .copied()
            .collect();
        let others = faced.facets[k]
            .iter()
            .filter(|facet| !on_sides.contains(facet));
        (others.count(), &body.name)
    });
    (a.0 + b.0 > 0).then(|| {
        format!(
            "bodies \"{}\" and \"{}\" are left to contact \"{}\": {} more facets of the first and {} of the second, which are not on its sides, face each other within {:.4e}",
            a.1, b.1, first.name, a.0, b.0, faced.reach
        )
    })
}

/// The name of a side of exactly these facets, made if it does not exist yet.
///
/// Errors: the name that it would have, if that is another side.
fn named_side<const D: usize>(
    mesh: &mut Mesh<D>,
    facets: &[Facet],
    other: &str,
) -> Result<String, String> {
    let name = format!("{SIDE}{other}");
    let named = |mesh: &Mesh<D>| {
        let sides = mesh
            .sides()
            .iter()
            .filter(|(side, _)| !side.starts_with(SIDE));
        let mut whole: Vec<(&String, &Vec<Facet>)> = sides
            .filter(|(_, own)| {
                !own.is_empty() && own.iter().all(|f| facets.binary_search(f).is_ok())
            })
            .collect();
        // the largest first: few names
        whole.sort_by_key(|(_, own)| std::cmp::Reverse(own.len()));
        let mut covered: BTreeSet<Facet> = BTreeSet::new();
        let mut names = Vec::new();
        for (side, own) in whole {
            if own.iter().any(|facet| !covered.contains(facet)) {
                covered.extend(own);
                names.push(side.clone());
            }
        }
        (covered.len() == facets.len()).then_some(names)
    };
    let join = |mesh: &mut Mesh<D>, names: Vec<String>| -> Result<String, MeshError> {
        match &names[..] {
            [one] => Ok(one.clone()),
            _ => mesh.join_sides(&names.iter().map(String::as_str).collect::<Vec<_>>()),
        }
    };
    if let Some(names) = named(mesh) {
        return join(mesh, names).map_err(|_| name);
    }
    match mesh.side(&name) {
        Some(known) if known == facets => Ok(name),
        Some(_) => Err(name),
        None => {
            let added = mesh.add_side(&name, facets.to_vec());
            added.map(|()| name.clone()).map_err(|_| name)
        }
    }
}
