//! Stages: bodies, supports and contacts that come and go. A stage holds the parts of a model that are present at a time, as a model
//! of its own; the state that load steps pass on is in `system/state.rs`.
//!
//! A part is present in the steps whose time t lies in from ≤ t < until; parts of the first step do not count as appearing.

use crate::fem::{Active, FemError, Material};
use crate::mesh::Mesh;
use crate::model::nouns::error::{Error, Subject};
use crate::model::nouns::ids::{BodyId, SideRef};
use crate::model::nouns::member::{Line, MemberEnd};
use crate::model::nouns::members::Member;
use crate::model::nouns::model::{Along, Body, Contact, Model, Pair, Probe};
use crate::model::nouns::section::Section;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The parts of a model that are present at a time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Presence {
    pub bodies: Vec<bool>,
    pub contacts: Vec<bool>,
    /// Of each body.
    pub supports: Vec<Vec<bool>>,
    /// Of each body.
    pub springs: Vec<Vec<bool>>,
    pub members: Vec<bool>,
    /// Members that are being tightened: prestressed ones in their first step, bolts when it is said.
    pub tightening: Vec<bool>,
    /// Young's moduli of the materials of each body that ages; none of others.
    pub young: Vec<Vec<f64>>,
}

impl Presence {
    /// Presence in a model at a time.
    pub fn at<const D: usize>(model: &Model<D>, time: f64) -> Self {
        let before = model.times.iter().copied().filter(|&before| before < time);
        let before = before.reduce(f64::max);
        let members = |time: f64| {
            let there = |member: &Member<D>| {
                let mut bodies = member.line.touched();
                member.active.at(time) && bodies.all(|body| model.bodies[body.0].active.at(time))
            };
            model.members.iter().map(there).collect::<Vec<bool>>()
        };
        let there = members(time);
        let been = before.map_or(vec![false; there.len()], members);
        let new = there.iter().zip(&been).map(|(now, been)| *now && !been);
        let tightened = new.zip(&model.members);
        let tightening = tightened.map(|(new, member)| member.kind.pull().tightened(new, time));
        let tightening = tightening.collect();
        let bodies: Vec<bool> = model.bodies.iter().map(|b| b.active.at(time)).collect();
        let touching = |contact: &Contact<D>| {
            let sides = contact.pair.sides();
            contact.active.at(time) && sides.iter().all(|side| bodies[side.body.0])
        };
        let supports = |body: &Body<D>| body.supports.iter().map(|s| s.active.at(time)).collect();
        let springs = |body: &Body<D>| body.springs.iter().map(|s| s.active.at(time)).collect();
        let young = |body: &Body<D>| match body.ages() {
            true => body.materials.iter().map(|m| m.young_at(time)).collect(),
            false => Vec::new(),
        };
        Self {
            young: model.bodies.iter().map(young).collect(),
            contacts: model.contacts.iter().map(touching).collect(),
            supports: model.bodies.iter().map(supports).collect(),
            springs: model.bodies.iter().map(springs).collect(),
            members: there,
            tightening,
            bodies,
        }
    }

    /// Whether some body of each section is there.
    fn cut<const D: usize>(&self, model: &Model<D>) -> Vec<bool> {
        let sections = model.sections.iter();
        let any = sections.map(|s| s.bodies.iter().any(|body| self.bodies[body.0]));
        any.collect()
    }

    /// Everything is there, and as it is at all times.
    pub fn is_whole(&self) -> bool {
        let Self {
            bodies,
            contacts,
            supports,
            springs,
            members,
            // what is tightened is there
            tightening: _,
            young,
        } = self;
        if young.iter().any(|own| !own.is_empty()) {
            return false;
        }
        let lists = [bodies, contacts, members].into_iter();
        let mut lists = lists.chain(supports).chain(springs);
        lists.all(|list| list.iter().all(|&there| there))
    }
}

/// Index of each present element among those present.
pub(crate) fn places(there: &[bool]) -> Vec<Option<usize>> {
    let mut next = 0;
    let place = |&there: &bool| {
        next += usize::from(there);
        there.then(|| next - 1)
    };
    there.iter().map(place).collect()
}

/// The elements that are present.
pub(crate) fn kept<'a, T>(all: &'a [T], there: &'a [bool]) -> impl Iterator<Item = &'a T> {
    all.iter()
        .zip(there)
        .filter(|(_, there)| **there)
        .map(|(one, _)| one)
}

/// The present parts of a model at a time, as a model of its own, with some data of the absent parts.
#[derive(Debug, Clone)]
pub(crate) struct Stage<'m, const D: usize> {
    /// The present parts; borrowed where all are present.
    pub model: Cow<'m, Model<D>>,
    /// Whether each member is being tightened: it pulls with its prestress.
    pub tightening: Vec<bool>,
    /// Absent contacts: their names, and their sides on present bodies.
    pub absent: Vec<(String, Vec<SideRef>)>,
    /// Absent bodies of each present section; empty where all are there.
    pub missing: Vec<Vec<Absent<D>>>,
}

/// A body of a section that is not there: its middle line goes on along it.
#[derive(Debug, Clone)]
pub(crate) struct Absent<const D: usize> {
    pub mesh: Arc<Mesh<D>>,
    /// Its sides along the long sides of the section.
    pub sides: [Vec<String>; 2],
}

impl<'m, const D: usize> Stage<'m, D> {
    /// All of a model, at its first step.
    pub fn whole(model: &'m Model<D>) -> Self {
        Self {
            model: Cow::Borrowed(model),
            tightening: {
                let first = model.times.first().copied().unwrap_or(1.0);
                let members = model.members.iter();
                let tightened = members.map(|m| m.kind.pull().tightened(true, first));
                tightened.collect()
            },
            absent: Vec::new(),
            missing: Vec::new(),
        }
    }

    /// The stage of a model with this presence.
    pub fn of(model: &'m Model<D>, there: &Presence) -> Self {
        let places = places(&there.bodies);
        let missing = model.contacts.iter().zip(&there.contacts);
        let missing = missing.filter(|(_, there)| !**there);
        let absent = missing.map(|(contact, _)| {
            let sides = contact.pair.sides().into_iter();
            let sides = sides.filter_map(|side| placed(side, &places)).collect();
            (contact.name.clone(), sides)
        });
        let missing_bodies = kept(&model.sections, &there.cut(model))
            .map(|section| {
                let gone = section.bodies.iter().filter(|body| !there.bodies[body.0]);
                let absent = gone.map(|body| Absent {
                    mesh: Arc::clone(&model.bodies[body.0].mesh),
                    sides: section.sides.each_ref().map(|sides| {
                        let own = sides.iter().filter(|side| side.body == *body);
                        own.map(|side| side.side.clone()).collect()
                    }),
                });
                absent.collect()
            })
            .collect();
        Self {
            missing: missing_bodies,
            model: match there.is_whole() {
                true => Cow::Borrowed(model),
                false => Cow::Owned(model.part(there, None)),
            },
            tightening: kept(&there.tightening, &there.members).copied().collect(),
            absent: absent.collect(),
        }
    }

    /// The same, without borrowed data.
    pub fn into_owned(self) -> Stage<'static, D> {
        Stage {
            model: Cow::Owned(self.model.into_owned()),
            tightening: self.tightening,
            absent: self.absent,
            missing: self.missing,
        }
    }

    /// Sides of a body in some contact, present or not.
    pub fn touched(&self, body: BodyId) -> BTreeSet<&str> {
        let there = self.model.contacts.iter();
        let there = there.flat_map(|contact| contact.pair.sides());
        let absent = self.absent.iter().flat_map(|(_, sides)| sides);
        let own = there.chain(absent).filter(|side| side.body == body);
        own.map(|side| side.side.as_str()).collect()
    }

    /// The absent contact between two bodies.
    pub fn waits(&self, [a, b]: [usize; 2]) -> Option<&str> {
        let between = |sides: &[SideRef]| match sides {
            [one, other] => [[a, b], [b, a]].contains(&[one.body.0, other.body.0]),
            _ => false,
        };
        let found = self.absent.iter().rfind(|(_, sides)| between(sides));
        found.map(|(name, _)| name.as_str())
    }
}

/// A side with the index of its body among the present ones.
fn placed(side: &SideRef, bodies: &[Option<usize>]) -> Option<SideRef> {
    Some(SideRef {
        body: BodyId(bodies[side.body.0]?),
        side: side.side.clone(),
    })
}

impl<const D: usize> Model<D> {
    /// Its present parts at a time, as a model with the steps up to that time; borrowed where all are present. The state after earlier
    /// steps is not included.
    pub fn stage(&self, time: f64) -> Cow<'_, Self> {
        let presence = Presence::at(self, time);
        match presence.is_whole() {
            true => Cow::Borrowed(self),
            false => Cow::Owned(self.part(&presence, Some(time))),
        }
    }

    /// Whether a part comes or goes between its load steps.
    pub(crate) fn has_stages(&self) -> bool {
        let mut presences = self.times.iter().map(|&time| Presence::at(self, time));
        let first = presences.next();
        presences.any(|other| Some(other) != first)
    }

    /// Whether a gasket lies in one of its contacts.
    pub(crate) fn has_gaskets(&self) -> bool {
        self.contacts.iter().any(|contact| contact.gasket.is_some())
    }

    /// Whether its steps pass on a state other than slip.
    pub(crate) fn is_staged(&self) -> bool {
        // what is tightened in its first step is locked in the next
        let first = self.times.first().copied().unwrap_or(1.0);
        let mut members = self.members.iter();
        members.any(|member| member.kind.pull().tightened(true, first)) || self.has_stages()
    }

    /// Whether the presence at a time differs from that in its first load step.
    pub(crate) fn has_stage_at(&self, time: f64) -> bool {
        let first = self.times.first().map(|&first| Presence::at(self, first));
        first.is_some_and(|first| first != Presence::at(self, time))
    }

    /// The present parts as a model, with the steps up to a time.
    pub(crate) fn part(&self, there: &Presence, until: Option<f64>) -> Self {
        let cut = there.cut(self);
        let [bodies, contacts, sections, members] =
            [&there.bodies, &there.contacts, &cut, &there.members].map(|list| places(list));
        let side = |side: &SideRef| placed(side, &bodies);
        let body = |(index, body): (usize, &Body<D>)| {
            let supports = kept(&body.supports, &there.supports[index]);
            let springs = kept(&body.springs, &there.springs[index]);
            Body {
                supports: supports.cloned().collect(),
                springs: springs.cloned().collect(),
                ..body.with_moduli(&there.young[index])
            }
        };
        let each = self.bodies.iter().enumerate();
        let each = each.filter(|(index, _)| there.bodies[*index]);
        let contact = |contact: &Contact<D>| {
            let pair = match &contact.pair {
                Pair::Given { nonmortar, mortar } => Pair::Given {
                    nonmortar: side(nonmortar)?,
                    mortar: side(mortar)?,
                },
                Pair::Automatic([a, b]) => Pair::Automatic([side(a)?, side(b)?]),
                Pair::Obstacle {
                    nonmortar,
                    obstacle,
                } => Pair::Obstacle {
                    nonmortar: side(nonmortar)?,
                    obstacle: obstacle.clone(),
                },
            };
            Some(Contact {
                pair,
                ..contact.clone()
            })
        };
        let section = |section: &Section<D>| {
            let own = section.bodies.iter().filter_map(|body| bodies[body.0]);
            Section {
                bodies: own.map(BodyId).collect(),
                sides: section
                    .sides
                    .each_ref()
                    .map(|sides| sides.iter().filter_map(side).collect()),
                ..section.clone()
            }
        };
        let member = |member: &Member<D>| {
            let end = |end: &MemberEnd<D>| {
                Some(match end {
                    MemberEnd::Side(of) => MemberEnd::Side(side(of)?),
                    MemberEnd::Point(point) => MemberEnd::Point(*point),
                })
            };
            let line = &member.line;
            let [from, to] = &line.ends;
            let named = line.bodies.iter().filter_map(|body| bodies[body.0]);
            Some(Member {
                line: Line {
                    ends: [end(from)?, end(to)?],
                    bodies: named.map(BodyId).collect(),
                    ..line.clone()
                },
                ..member.clone()
            })
        };
        let owners = [&bodies, &contacts, &sections, &members].map(|list| &list[..]);
        let probe = |probe: &Probe<D>| {
            Some(Probe {
                quantity: probe.quantity.placed(owners)?,
                along: match &probe.along {
                    Some(Along::Side(read)) => Some(Along::Side(side(read)?)),
                    other => other.clone(),
                },
                minus_rigid: match probe.minus_rigid {
                    Some(body) => Some(BodyId(bodies[body.0]?)),
                    None => None,
                },
                ..probe.clone()
            })
        };
        let before = |time: &&f64| until.is_none_or(|until| **time <= until);
        Self {
            title: self.title.clone(),
            source: self.source.clone(),
            analysis: self.analysis,
            units: self.units.clone(),
            bodies: each.map(body).collect(),
            contacts: kept(&self.contacts, &there.contacts)
                .filter_map(contact)
                .collect(),
            members: kept(&self.members, &there.members)
                .filter_map(member)
                .collect(),
            sections: kept(&self.sections, &cut).map(section).collect(),
            solver: self.solver.clone(),
            probes: self.probes.iter().filter_map(probe).collect(),
            times: self.times.iter().filter(before).copied().collect(),
            step_names: self.step_names.clone(),
            zeroed: self.zeroed.clone(),
            parameters: self.parameters.clone(),
        }
    }

    /// Errors: a part that is present in no load step; a modulus that is no positive number in one.
    pub(crate) fn check_presence(&self) -> Result<(), Error<D>> {
        let never = |what, subject: Subject| Err(Error::NeverThere { what, subject });
        let of_body = |body: &Body<D>| Subject::Body(body.name.clone());
        let all: Vec<Presence> = self.times.iter().map(|&t| Presence::at(self, t)).collect();
        for (index, body) in self.bodies.iter().enumerate() {
            if !all.iter().any(|there| there.bodies[index]) {
                return never("body", of_body(body));
            }
            for (there, &time) in all.iter().zip(&self.times).filter(|(t, _)| t.bodies[index]) {
                let wrong = |(_, young): &(&Material, &f64)| !(**young > 0.0 && young.is_finite());
                let each = body.materials.iter().zip(&there.young[index]);
                if let Some((material, &value)) = each.into_iter().find(wrong) {
                    let ages = material.ages.as_ref();
                    let text = ages.map_or(String::new(), |ages| ages.young.to_string());
                    return Err(Error::in_body(body, FemError::Young { text, value, time }));
                }
            }
            for (place, support) in body.supports.iter().enumerate() {
                let holds = |there: &Presence| there.bodies[index] && there.supports[index][place];
                if support.active != Active::ALWAYS && !all.iter().any(holds) {
                    return never("a support of body", of_body(body));
                }
            }
            for (place, spring) in body.springs.iter().enumerate() {
                let holds = |there: &Presence| there.bodies[index] && there.springs[index][place];
                if spring.active != Active::ALWAYS && !all.iter().any(holds) {
                    return never("a spring of body", of_body(body));
                }
            }
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            if !all.iter().any(|there| there.contacts[index]) {
                return never("contact", Subject::Contact(contact.name.clone()));
            }
        }
        for (index, member) in self.members.iter().enumerate() {
            if !all.iter().any(|there| there.members[index]) {
                let kind = member.kind.words();
                return never(kind.key, Subject::Member(kind, member.name.clone()));
            }
        }
        if let Some(step) = all.iter().position(|there| !there.bodies.contains(&true)) {
            return Err(Error::NoBody.in_step(self, step + 1, Vec::new()));
        }
        Ok(())
    }

    /// Runs of load steps between which no part comes or goes, each as a stage with these steps, without the state after those
    /// before.
    pub(crate) fn runs(&self) -> Vec<Stage<'_, D>> {
        let mut runs: Vec<(Presence, Vec<f64>)> = Vec::new();
        for &time in &self.times {
            let presence = Presence::at(self, time);
            match runs.last_mut().filter(|(last, _)| *last == presence) {
                Some((_, times)) => times.push(time),
                None => runs.push((presence, vec![time])),
            }
        }
        let run = |(presence, times): (Presence, Vec<f64>)| {
            let mut stage = Stage::of(self, &presence);
            if stage.model.times != times {
                stage.model.to_mut().times = times;
            }
            stage
        };
        runs.into_iter().map(run).collect()
    }
}
