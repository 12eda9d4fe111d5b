//! `check`: a description of a model, with its errors and warnings, before it is solved.

use crate::dual::{Feasibility, NO_WORK};
use crate::fem::{
    BodySystem, Constraints, History, RigidBasis, Short, describe_motion, fit_rigid, list_motions,
    show,
};
use crate::geometry::{Point, add_scaled, dot, norm};
use crate::mesh::Mesh;
use crate::model::march::sliding::sliding;
use crate::model::nouns::error::{Error, Subject};
use crate::model::nouns::member::{MemberEnd, MemberWords};
use crate::model::nouns::members::Member;
use crate::model::nouns::model::*;
use crate::model::nouns::presence::Stage;
use crate::model::nouns::told::{told_in_steps, told_once};
use crate::model::read::probe::sites;
use crate::model::read::remarks::{
    ContactCheck, body_remarks, check_contacts, remarks, worst_quality,
};
use crate::model::read::section::lay_out;
use crate::model::system::admissible::admissible_set;
use crate::model::system::bodies::{LoadedBody, body_rows, largest_load, systems};
use crate::model::system::condition::{Condition, row_ranges};
use crate::model::system::conditions::all_conditions;
use crate::model::system::drive::{complete, driven};
use crate::model::system::floating::Floating;
use crate::model::system::parts::Parts;
use std::fmt;
use std::ops::Range;

/// A contact that does less work on a motion does not help to hold it: modes are scaled to a largest displacement of 1, and half
/// the digits of the normals are accurate.
const NO_PART: f64 = 1e-8;

/// Description of one body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyCheck<const D: usize> {
    /// Its name.
    pub name: String,
    /// Nodes and cells.
    pub size: [usize; 2],
    /// Quality of the worst cell, in (0, 1].
    pub worst_quality: f64,
    /// Resultant of its loads, those at points of its couples included; zero where loads cancel up to rounding.
    pub load: Point<D>,
    /// Number of held dofs.
    pub held: usize,
    /// Rigid motions that the supports leave free, each with the contacts that hold it; in one text where no contact can.
    pub floating: Vec<String>,
    /// Its couples, each with the supports and loads of its point.
    pub couples: Vec<String>,
}

/// Description of one member: a bar, a spring between places, a bolt.
#[derive(Debug, Clone, PartialEq)]
pub struct MemberCheck {
    /// Its name.
    pub name: String,
    /// The words for its kind.
    pub kind: MemberWords,
    /// The choice of its kind in a word, such as its bond.
    pub chosen: &'static str,
    /// Where it begins and ends: "BODY.SIDE", or a point.
    pub ends: [String; 2],
    /// From its beginning to its end; that of a bolt is 0.
    pub length: f64,
    /// Number of its elements.
    pub elements: usize,
    /// How many members it stands for.
    pub count: f64,
}

/// Description of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Check<const D: usize> {
    /// One per body.
    pub bodies: Vec<BodyCheck<D>>,
    /// One per contact.
    pub contacts: Vec<ContactCheck<D>>,
    /// One per member that can be laid.
    pub members: Vec<MemberCheck>,
    /// Reasons why no solution is possible.
    pub errors: Vec<String>,
    /// Subject of the first error.
    pub subject: Option<Subject>,
    /// Warnings to the user.
    pub warnings: Vec<String>,
    /// What else is worth to be known.
    pub notes: Vec<String>,
}

/// Describes a model, or reports why it is not `valid`.
pub(crate) fn check<const D: usize>(model: &Model<D>, valid: Result<(), Error<D>>) -> Check<D> {
    let mut check = Check::default();
    if let Err(error) = valid.and_then(|()| fill(model, &mut check)) {
        check.subject = error.subject();
        check.errors.push(error.to_string());
    }
    check
}

/// Describes the model in each run of load steps between which no part comes or goes; parts that are there in several runs as in
/// the last of these.
fn fill<const D: usize>(model: &Model<D>, check: &mut Check<D>) -> Result<(), Error<D>> {
    check.members = check_members(model);
    let mut before = 0;
    let mut warnings: Vec<Vec<String>> = Vec::new();
    for run in model.runs() {
        let mut of_run = Check::default();
        // findings before a mistake are reported, too
        let filled = fill_run(&run, (model, before), &mut of_run);
        before += run.model.times.len();
        check
            .bodies
            .retain(|body| !of_run.bodies.iter().any(|b| b.name == body.name));
        check
            .contacts
            .retain(|contact| !of_run.contacts.iter().any(|c| c.name == contact.name));
        check.bodies.append(&mut of_run.bodies);
        check.contacts.append(&mut of_run.contacts);
        warnings.push(told_once(of_run.warnings));
        check.warnings = told_in_steps(warnings.iter().map(Vec::as_slice));
        filled?;
    }
    let place = |name: &str| model.bodies.iter().position(|body| body.name == name);
    check.bodies.sort_by_key(|body| place(&body.name));
    let place = |name: &str| {
        model
            .contacts
            .iter()
            .position(|contact| contact.name == name)
    };
    check.contacts.sort_by_key(|contact| place(&contact.name));
    Ok(())
}

/// The members of a model that can be laid.
fn check_members<const D: usize>(model: &Model<D>) -> Vec<MemberCheck> {
    let told = |end: &MemberEnd<D>| match end {
        MemberEnd::Point(point) => show(*point),
        MemberEnd::Side(side) => format!("{}.{}", model.bodies[side.body.0].name, side.side),
    };
    let one = |member: &Member<D>| {
        let laid = member.lay(model).ok()?;
        let last = laid.anchors.last();
        Some(MemberCheck {
            name: member.name.clone(),
            kind: member.kind.words(),
            chosen: member.kind.pull().chosen(member.line.bond),
            ends: member.line.ends.each_ref().map(told),
            length: last.map_or(0.0, |last| laid.length_to(last.point)),
            elements: laid.elements().count(),
            count: laid.count,
        })
    };
    model.members.iter().filter_map(one).collect()
}

/// Describes a run at its last load step, then checks the loads of its other steps; `before` is the number of steps of the whole
/// model that precede it.
fn fill_run<const D: usize>(
    stage: &Stage<'_, D>,
    (whole, before): (&Model<D>, usize),
    check: &mut Check<D>,
) -> Result<(), Error<D>> {
    let model = stage.model.as_ref();
    let time = model.last_time();
    let in_step = |error: Error<D>, step: usize| error.in_step(whole, before + step, Vec::new());
    let last = |error: Error<D>| in_step(error, model.times.len());
    let mut systems = systems(model, nothing(model), time).map_err(last)?;
    let mut motions = Vec::new();
    check.warnings.extend(body_remarks(stage));
    for (index, body) in model.bodies.iter().enumerate() {
        let loads = Loads::of(model, index, &systems).map_err(last)?;
        let free = free_motions(model.analysis, body, &systems[index], &loads);
        check
            .bodies
            .push(check_body(body, &systems[index], &loads, &free));
        motions.push(free);
    }
    for (part, body, couple) in Parts::of(model).points(model) {
        let arm = couple.arm(&model.bodies[body]);
        let arm = arm.map_err(|source| Error::in_body(&model.bodies[body], source))?;
        let found = check_couple(model, (couple, arm), &systems[part]);
        check.bodies[body].couples.push(found);
    }
    let constraints: Vec<&Constraints<D>> = systems.iter().map(|s| &s.constraints).collect();
    let mut conditions = all_conditions(stage, &constraints, time).map_err(last)?;
    let dropped = complete(
        model,
        &mut systems,
        (&mut conditions, &|_| (None, None)),
        time,
    )
    .map_err(last)?;
    sites(model, &conditions)?;
    lay_out(stage)?;
    check.warnings.extend(dropped);
    let of_conditions = conditions
        .iter()
        .flat_map(|condition| condition.warnings.clone());
    check.warnings.extend(of_conditions);
    check.contacts = check_contacts(model, &conditions);
    check.warnings.extend(remarks(&check.contacts));
    let rows = body_rows(&systems, &conditions);
    let loaded = systems
        .into_iter()
        .zip(rows)
        .map(|(system, rows)| LoadedBody::new(system, rows));
    let mut bodies: Vec<LoadedBody<D>> = loaded.collect();
    let mut floating = Floating::new(model, &bodies, &conditions).map_err(last)?;
    check.warnings.extend(floating.warnings.iter().cloned());
    describe_floating(model, &floating, &conditions, &motions, check);
    check_balance(
        model,
        &floating,
        &bodies,
        &conditions,
        time,
        &mut check.warnings,
    )
    .map_err(last)?;
    for (index, &time) in model.times.iter().enumerate().rev().skip(1) {
        let at = |error: Error<D>| in_step(error, index + 1);
        (bodies, conditions) = driven(model, bodies, conditions, (time, None)).map_err(at)?;
        floating
            .set_loads(model, &bodies, &conditions)
            .map_err(at)?;
        check_balance(
            model,
            &floating,
            &bodies,
            &conditions,
            time,
            &mut check.warnings,
        )
        .map_err(at)?;
    }
    Ok(())
}

/// No system and no history for any body.
fn nothing<const D: usize>(model: &Model<D>) -> (Vec<Option<BodySystem<D>>>, Vec<History<D>>) {
    let nothing = model.bodies.iter().map(|_| (None, History::default()));
    nothing.unzip()
}

/// Errors: a load that no contact force can balance.
fn check_balance<const D: usize>(
    model: &Model<D>,
    floating: &Floating,
    bodies: &[LoadedBody<D>],
    conditions: &[Condition<D>],
    time: f64,
    warnings: &mut Vec<String>,
) -> Result<(), Error<D>> {
    let admissible = admissible_set(model, conditions, time)?;
    let force = largest_load(bodies);
    let feasible = Feasibility::of(&admissible, &floating.balance, force);
    if let Feasibility::Infeasible { direction, factor } = feasible {
        let parts = (floating, bodies, conditions);
        let slides = sliding(model, parts, &admissible, (&direction, factor), None)?;
        warnings.push(slides.to_string());
    }
    Ok(())
}

/// Which contacts and couples do work on each of the free `motions` of the bodies.
fn describe_floating<const D: usize>(
    model: &Model<D>,
    floating: &Floating,
    conditions: &[Condition<D>],
    motions: &[Vec<FreeMotion>],
    check: &mut Check<D>,
) {
    for body in &mut check.bodies {
        body.floating.clear();
    }
    let ranges: Vec<Range<usize>> = row_ranges(conditions).map(|(rows, _)| rows).collect();
    let of_bodies = floating.modes.iter().enumerate();
    for (k, &(body, mode)) in of_bodies.filter(|(_, mode)| mode.0 < model.bodies.len()) {
        let works =
            |range: &Range<usize>| range.clone().any(|i| floating.work(k, i).abs() > NO_PART);
        // conditions of a kind stand together
        let mut held: Vec<(&str, Vec<String>)> = Vec::new();
        for (condition, range) in conditions.iter().zip(&ranges) {
            if !works(range) {
                continue;
            }
            let (kind, name) = (
                condition.source.kind(model),
                format!("\"{}\"", condition.name),
            );
            match held.last_mut().filter(|last| last.0 == kind) {
                Some((_, names)) => names.push(name),
                None => held.push((kind, vec![name])),
            }
        }
        let held = held.iter();
        let held = held.map(|(kind, names)| format!("{kind} {}", names.join(", ")));
        let held = match held.collect::<Vec<_>>().join(" and ") {
            none if none.is_empty() => "held by nothing".to_string(),
            all => format!("held by {all}"),
        };
        let FreeMotion { words, load } = &motions[body][mode];
        let found = &mut check.bodies[body].floating;
        found.push(format!("{words}: load on it {}, {held}", Short(*load)));
    }
}

/// Describes a couple: the arm of its rotations, the supports and the loads of its point.
fn check_couple<const D: usize>(
    model: &Model<D>,
    (couple, arm): (&Couple<D>, f64),
    system: &BodySystem<D>,
) -> String {
    let turns = Couple::<D>::turns(model.analysis);
    let about = turns.clone().map(|axis| match D {
        2 => "rotation".to_string(),
        _ => format!("rotation about {}", ["x", "y", "z"][axis]),
    });
    let moves = ["x", "y", "z"].into_iter().take(D);
    let moves = moves.map(|axis| format!("displacement along {axis}"));
    let all: Vec<String> = moves.chain(about).collect();
    let held = all.iter().zip(&system.held).filter(|(_, held)| **held);
    let held: Vec<&str> = held.map(|(name, _)| name.as_str()).collect();
    let held = match held.is_empty() {
        true => "nothing held".to_string(),
        false => format!("held: {}", held.join(", ")),
    };
    let [force, moment] = carried(system);
    let moments: Vec<String> = turns
        .map(|axis| Short(moment[axis - turns_from::<D>()] * arm).to_string())
        .collect();
    let moment = match moments.as_slice() {
        none if none.iter().all(|m| m == "0") => String::new(),
        [one] => format!(", moment {one}"),
        all => format!(", moment ({})", all.join(", ")),
    };
    format!(
        "point \"{}\" at {}: {} couple of side \"{}\", {held}, force {}{moment}",
        couple.name,
        show(couple.point),
        couple.kind.name(),
        couple.side,
        show(force)
    )
}

/// The first axis about which a point of a couple turns.
fn turns_from<const D: usize>() -> usize {
    if D == 2 { 2 } else { 0 }
}

/// The load of the point of a couple: its force, and its moments over the arm.
fn carried<const D: usize>(system: &BodySystem<D>) -> [Point<D>; 2] {
    let loads = system.to_global(&system.load);
    [loads[0], loads[1]]
}

/// The loads of a body: on its nodes and at points of its couples, without the forces of connections such as prestress or the
/// tension of a joint.
struct Loads<'a, const D: usize> {
    /// Forces by node, in the order of the nodes.
    nodes: Vec<Point<D>>,
    /// Couples with their arm, and the system of the point.
    points: Vec<(&'a Couple<D>, f64, &'a BodySystem<D>)>,
}

impl<'a, const D: usize> Loads<'a, D> {
    /// Those of a body, from the systems of all parts.
    ///
    /// Errors: a couple with an unknown side.
    fn of(
        model: &'a Model<D>,
        body: usize,
        systems: &'a [BodySystem<D>],
    ) -> Result<Self, Error<D>> {
        let own = Parts::of(model).points(model);
        let own = own.filter(|(_, of, _)| *of == body);
        let point = |(part, _, couple): (usize, usize, &'a Couple<D>)| {
            let arm = couple.arm(&model.bodies[body]);
            let arm = arm.map_err(|source| Error::in_body(&model.bodies[body], source))?;
            Ok((couple, arm, &systems[part]))
        };
        Ok(Self {
            nodes: systems[body].to_global(&systems[body].load),
            points: own.map(point).collect::<Result<_, Error<D>>>()?,
        })
    }

    /// Their resultant, and the sum of their sizes.
    fn resultant(&self) -> (Point<D>, f64) {
        let at_points = self.points.iter().map(|(_, _, system)| carried(system)[0]);
        let all = self.nodes.iter().copied().chain(at_points);
        all.fold(([0.0; D], 0.0), |(sum, size), force| {
            (add_scaled(sum, 1.0, force), size + norm(force))
        })
    }

    /// Their work on a rigid motion (displacements of all nodes), which the points of couples follow: Σ f·u + m·ω over the free
    /// components. Zero where it is rounding of the sum.
    fn work(&self, analysis: Analysis, mesh: &Mesh<D>, motion: &[Point<D>]) -> f64 {
        let basis = RigidBasis::of(analysis);
        let mut work: f64 = self
            .nodes
            .iter()
            .zip(motion)
            .map(|(&f, &u)| dot(f, u))
            .sum();
        let mut sizes: f64 = self.nodes.iter().map(|&f| norm(f)).sum();
        for (couple, arm, system) in &self.points {
            let (mut u, spin) = fit_rigid(basis, mesh.points(), motion, couple.point);
            let mut turn = [0.0; D];
            turn.iter_mut().zip(&spin).for_each(|(t, s)| *t = s * arm);
            let [force, moment] = carried(system);
            let free = |k: usize| if system.held[k] { 0.0 } else { 1.0 };
            (0..D).for_each(|k| u[k] *= free(k));
            (0..D).for_each(|k| turn[k] *= free(D + k));
            work += dot(force, u) + dot(moment, turn);
            sizes += norm(force) + norm(moment);
        }
        told(work, sizes)
    }
}

/// A sum, or zero where it is rounding of its parts, of which `sizes` is the sum of magnitudes.
fn told(figure: f64, sizes: f64) -> f64 {
    if figure.abs() <= NO_WORK * sizes {
        0.0
    } else {
        figure
    }
}

/// A rigid motion that the supports of a body leave free, and the work of its loads for a largest displacement of 1.
struct FreeMotion {
    words: String,
    load: f64,
}

/// Each of the motions that the supports of a body leave free.
fn free_motions<const D: usize>(
    analysis: Analysis,
    body: &Body<D>,
    system: &BodySystem<D>,
    loads: &Loads<D>,
) -> Vec<FreeMotion> {
    let describe = |mode: &Vec<f64>| {
        let motion = system.to_global(mode);
        FreeMotion {
            words: describe_motion(body.mesh.points(), &motion),
            load: loads.work(analysis, &body.mesh, &motion),
        }
    };
    system.modes.iter().map(describe).collect()
}

fn check_body<const D: usize>(
    body: &Body<D>,
    system: &BodySystem<D>,
    loads: &Loads<D>,
    free: &[FreeMotion],
) -> BodyCheck<D> {
    let mesh = &body.mesh;
    let (load, sizes) = loads.resultant();
    let words: Vec<String> = free.iter().map(|motion| motion.words.clone()).collect();
    let floating = (!free.is_empty()).then(|| list_motions::<D>(&words));
    BodyCheck {
        name: body.name.clone(),
        size: [mesh.points().len(), mesh.cell_count()],
        worst_quality: worst_quality(body),
        load: load.map(|c| told(c, sizes)),
        held: system.held.iter().filter(|held| **held).count(),
        floating: floating.into_iter().collect(),
        couples: Vec::new(),
    }
}

impl<const D: usize> fmt::Display for Check<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for body in &self.bodies {
            writeln!(
                f,
                "body \"{}\": {} nodes, {} cells, worst cell quality {:.3}, {} dofs held, resultant load {}",
                body.name,
                body.size[0],
                body.size[1],
                body.worst_quality,
                body.held,
                show(body.load)
            )?;
            match body.floating.as_slice() {
                [] => writeln!(f, "  held by its supports")?,
                modes => modes
                    .iter()
                    .try_for_each(|mode| writeln!(f, "  floats: {mode}"))?,
            }
            for couple in &body.couples {
                writeln!(f, "  {couple}")?;
            }
        }
        for contact in &self.contacts {
            write!(
                f,
                "contact \"{}\": {} against {}, {} unknowns",
                contact.name, contact.sides[0], contact.sides[1], contact.unknowns
            )?;
            if !contact.alone.is_empty() {
                write!(f, ", {} nodes face nothing", contact.alone.len())?;
            }
            match contact.penetration {
                _ if contact.unknowns == 0 => writeln!(f)?,
                0.0 if contact.clearance > 0.0 => {
                    writeln!(f, ", initial clearance {:.4e}", contact.clearance)?
                }
                0.0 => writeln!(f, ", touching initially")?,
                depth => writeln!(f, ", initial penetration {depth:.4e}")?,
            }
            let extents = contact.extents.iter().zip(&contact.sides);
            let measure = if D == 2 { "length" } else { "area" };
            let parts = extents.map(|((facets, extent), side)| {
                format!("{facets} facets of {side}, {measure} {extent:.4e}")
            });
            let parts: Vec<String> = parts.collect();
            write!(f, "  {}", parts.join("; "))?;
            match contact.farthest.is_finite() && contact.farthest > contact.clearance {
                true => writeln!(
                    f,
                    "; gaps {:.4e} to {:.4e}",
                    contact.clearance, contact.farthest
                )?,
                false => writeln!(f)?,
            }
        }
        for member in &self.members {
            let MemberWords { key, choice, .. } = member.kind;
            let [from, to] = &member.ends;
            write!(f, "{key} \"{}\": from {from} to {to}", member.name)?;
            if member.length > 0.0 {
                write!(f, ", length {:.4e}", member.length)?;
            }
            write!(f, ", {choice} {}", member.chosen)?;
            if member.elements > 1 {
                write!(f, ", {} elements", member.elements)?;
            }
            match member.count {
                1.0 => writeln!(f)?,
                count => writeln!(f, ", stands for {}", Short(count))?,
            }
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        for error in &self.errors {
            writeln!(f, "error: {error}")?;
        }
        Ok(())
    }
}
