//! `summary.json`: the answer in numbers for programs.
//!
//! The order of the keys is that of the structs. A number that is not finite becomes `null`. The keys are in
//! `docs/reference/summary.schema.json`, and their meanings in `files.md` beside it: tests compare them.

use crate::dual::Figure;
use crate::model::{
    BedSolution, BodySolution, ContactNode, ContactSolution, CoupleSolution, Intrusion, LinePoint,
    MemberSolution, Seconds, SectionQuantity, SectionSolution, SideRef, Solution, Status,
};
use crate::output::Overview;
use crate::output::text::{Labels, THIN};
use crate::output::vtu::judged;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// Version that every file names.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Version of the keys: it changes if a key is removed or changes its meaning, not if keys are added.
const SCHEMA: u32 = 1;

/// Content of `summary.json`: the last step and, where there are several, all that were solved in `steps`.
///
/// `converged` is that of the run: `false` for a run that ends in failure, whatever its last iterate.
pub fn summary<const D: usize>(run: &Overview<'_, D>) -> String {
    let last = Summary {
        converged: run.converged,
        seconds: run.seconds.into(),
        failed_step: run.failed.map(|failed| FailedEntry {
            step: failed.step,
            time: failed.time,
            name: run.step_name(failed.step - 1),
            reason: &failed.reason,
            carried: failed.carried,
        }),
        ..step_summary(run, run.last, run.earlier.len())
    };
    let earlier = run.earlier.iter().enumerate();
    let earlier = earlier.map(|(i, solution)| step_summary(run, solution, i));
    // the failed step is not one of them
    let good = run
        .last
        .converged
        .then(|| step_summary(run, run.last, run.earlier.len()));
    let parameters = run.model.parameters.iter();
    let parameters: BTreeMap<&str, f64> = parameters
        .map(|(name, value)| (name.as_str(), *value))
        .collect();
    let labels = Labels::of(run.model);
    let told = |label: &str| (!label.is_empty()).then(|| label.to_string());
    let units = UnitsEntry {
        length: told(&labels.length),
        force: told(&labels.force),
        stress: told(&labels.stress),
        energy: told(&labels.energy.replace(THIN, " ")),
    };
    let summary = Document {
        schema: SCHEMA,
        units: (units.length.is_some() || units.force.is_some()).then_some(units),
        parameters: (!parameters.is_empty()).then_some(parameters),
        steps: run.has_steps().then(|| earlier.chain(good).collect()),
        last,
    };
    // Strings, numbers and lists: nothing here can fail to serialise.
    let mut text = serde_json::to_string_pretty(&summary).unwrap_or_default();
    text.push('\n');
    text
}

/// One step, counted from 0.
fn step_summary<'a, const D: usize>(
    run: &Overview<'a, D>,
    solution: &'a Solution<D>,
    index: usize,
) -> Summary<'a> {
    let several = run.has_steps();
    let labels = Labels::of(run.model);
    let stage = run.stages.get(index).map_or(run.model, |stage| stage);
    let bodies = stage.bodies.iter().zip(&solution.bodies);
    let probes = solution.probes.iter();
    let contacts = solution.contacts.iter();
    let divided = solution.division.iterations > 0;
    Summary {
        case: run.stem,
        version: VERSION,
        step: several.then_some(index + 1),
        name: run.step_name(index),
        time: solution.time,
        displacements_from: solution.counted_from,
        converged: solution.converged,
        solver: &solution.solver.method,
        iterations: solution.solver.iterations,
        increments: solution.certificate.yields.map(|_| 1),
        contraction: solution.solver.contraction,
        dofs: solution.dofs,
        contact_unknowns: solution.contact_unknowns,
        subdomains: solution.division.subdomains,
        coarse_size: divided.then_some(solution.division.coarse),
        glue_iterations: divided.then_some(solution.division.iterations),
        threads: solution.threads,
        peak_memory_bytes: run.peak_memory,
        seconds: solution.seconds.into(),
        certificate: CertificateEntry(solution.certificate.figures()),
        overlap: unexplained(solution).map(|found| OverlapEntry {
            bodies: [&found.body, &found.other],
            at: &found.point,
        }),
        contacts: contacts
            .map(|contact| contact_entry(solution, contact))
            .collect(),
        bodies: bodies
            .map(|(body, answer)| {
                let cells = body.mesh.blocks().iter().map(|b| b.cells().len()).sum();
                body_entry(answer, [body.mesh.points().len(), cells], judged(solution))
            })
            .collect(),
        probes: probes
            .map(|probe| ProbeEntry {
                name: &probe.name,
                quantity: &probe.quantity,
                value: probe.value,
                unit: Some(labels.unit(probe.dimension).to_string())
                    .filter(|unit| !unit.is_empty()),
                at: probe.at.as_ref().map(|at| &at[..D]),
                line: line_entry(&probe.line),
            })
            .collect(),
        beds: solution.beds.iter().map(bed_entry).collect(),
        members: members(solution),
        sections: solution.sections.iter().map(section_entry).collect(),
        warnings: &solution.warnings,
        failed_step: None,
    }
}

/// Largest value, NaN skipped; NaN without values.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NAN, f64::max)
}

/// Smallest and largest value, NaN skipped; NaN without values.
pub fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::NAN; 2], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// A node bears a force.
pub fn in_contact(status: Status) -> bool {
    matches!(
        status,
        Status::Closed | Status::Stick | Status::Slip | Status::Tied
    )
}

/// Nodes that bear a force, and open ones.
pub fn closed_and_open<const D: usize>(nodes: &[ContactNode<D>]) -> (usize, usize) {
    let closed = nodes.iter().filter(|n| in_contact(n.status)).count();
    let open = nodes.iter().filter(|n| n.status == Status::Open).count();
    (closed, open)
}

/// Largest penetration of a contact, ≥ 0; NaN when no node has a gap.
pub fn max_penetration<const D: usize>(nodes: &[ContactNode<D>]) -> f64 {
    largest(
        nodes
            .iter()
            .map(|n| n.gap)
            .filter(|g| !g.is_nan())
            .map(|g| (-g).max(0.0)),
    )
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    #[serde(flatten)]
    last: Summary<'a>,
    /// As the case names them.
    #[serde(skip_serializing_if = "Option::is_none")]
    units: Option<UnitsEntry>,
    /// Of the case; only if it has parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    parameters: Option<BTreeMap<&'a str, f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<Vec<Summary<'a>>>,
}

#[derive(Clone, Serialize)]
struct Summary<'a> {
    case: &'a str,
    version: &'a str,
    /// From 1; only with several steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<usize>,
    /// As the case names it.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    time: f64,
    /// Only where they do not count from the beginning.
    #[serde(skip_serializing_if = "Option::is_none")]
    displacements_from: Option<f64>,
    converged: bool,
    solver: &'a str,
    iterations: usize,
    /// Of the plastic strain, each an implicit one; only where a material yields.
    #[serde(skip_serializing_if = "Option::is_none")]
    increments: Option<usize>,
    /// Of the fixed point, if it solved Coulomb's law.
    #[serde(skip_serializing_if = "Option::is_none")]
    contraction: Option<f64>,
    dofs: usize,
    contact_unknowns: usize,
    subdomains: usize,
    /// Only where a body is divided.
    #[serde(skip_serializing_if = "Option::is_none")]
    coarse_size: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    glue_iterations: Option<usize>,
    threads: usize,
    peak_memory_bytes: u64,
    seconds: SecondsEntry,
    certificate: CertificateEntry,
    /// The overlap of the certificate, if that does not hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    overlap: Option<OverlapEntry<'a>>,
    contacts: Vec<ContactEntry<'a>>,
    bodies: Vec<BodyEntry<'a>>,
    probes: Vec<ProbeEntry<'a>>,
    /// Only where sides are bedded.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    beds: Vec<BedEntry<'a>>,
    /// By kinds of which there are some.
    #[serde(flatten)]
    members: Members<'a>,
    /// Only where some are cut.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sections: Vec<SectionEntry<'a>>,
    warnings: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    failed_step: Option<FailedEntry<'a>>,
}

/// Units of the numbers; angles are in radians.
#[derive(Serialize)]
struct UnitsEntry {
    length: Option<String>,
    force: Option<String>,
    stress: Option<String>,
    energy: Option<String>,
}

#[derive(Clone, Serialize)]
struct FailedEntry<'a> {
    step: usize,
    time: f64,
    name: Option<&'a str>,
    reason: &'a str,
    /// The part of it that the bodies can bear, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    carried: Option<f64>,
}

#[derive(Clone, Serialize)]
struct SecondsEntry {
    read: f64,
    assemble: f64,
    order: f64,
    factor: f64,
    condense: f64,
    contact: f64,
    recover: f64,
    write: f64,
    total: f64,
}

impl From<Seconds> for SecondsEntry {
    fn from(s: Seconds) -> Self {
        Self {
            read: s.read,
            assemble: s.assemble,
            order: s.order,
            factor: s.factor,
            condense: s.condense,
            contact: s.contact,
            recover: s.recover,
            write: s.write,
            total: s.total,
        }
    }
}

#[derive(Clone, Serialize)]
struct FigureEntry {
    value: f64,
    relative: f64,
    limit: f64,
}

impl From<Figure> for FigureEntry {
    fn from(figure: Figure) -> Self {
        Self {
            value: figure.value,
            relative: figure.relative,
            limit: figure.limit,
        }
    }
}

/// The figures by their names.
#[derive(Clone)]
struct CertificateEntry(Vec<(&'static str, Figure)>);

impl Serialize for CertificateEntry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entries = self.0.iter();
        serializer.collect_map(entries.map(|&(name, figure)| (name, FigureEntry::from(figure))))
    }
}

/// The overlap of deformed bodies beyond the explained one.
fn unexplained<const D: usize>(solution: &Solution<D>) -> Option<&Intrusion<D>> {
    let found = solution.overlap.as_ref();
    found.filter(|_| !solution.certificate.overlap.holds())
}

/// Where two deformed bodies overlap.
#[derive(Clone, Serialize)]
struct OverlapEntry<'a> {
    /// The body of the node, and the body (or the contact with the obstacle) that it overlaps.
    bodies: [&'a str; 2],
    /// Undeformed position.
    at: &'a [f64],
}

#[derive(Clone, Serialize)]
struct ContactEntry<'a> {
    name: &'a str,
    /// "BODY.SIDE" with the multipliers, and opposite: a side, or "obstacle".
    nonmortar: String,
    mortar: String,
    resultant: &'a [f64],
    /// About the origin; in space.
    #[serde(skip_serializing_if = "Option::is_none")]
    moment: Option<&'a [f64]>,
    closed: usize,
    open: usize,
    length: f64,
    max_pressure: f64,
    /// Null where no node has a pressure.
    max_pressure_at: Option<&'a [f64]>,
    max_penetration: f64,
    imbalance: f64,
    dissipated_work: f64,
}

fn contact_entry<'a, const D: usize>(
    solution: &'a Solution<D>,
    contact: &'a ContactSolution<D>,
) -> ContactEntry<'a> {
    let name = |side: &SideRef| format!("{}.{}", solution.bodies[side.body.0].name, side.side);
    let (closed, open) = closed_and_open(&contact.nodes);
    let pressed = contact.nodes.iter().filter(|n| !n.pressure.is_nan());
    let hardest = pressed.reduce(|most, n| if n.pressure > most.pressure { n } else { most });
    ContactEntry {
        name: &contact.name,
        nonmortar: name(&contact.nonmortar),
        mortar: contact.mortar.as_ref().map_or("obstacle".to_string(), name),
        resultant: &contact.resultant,
        moment: (D == 3).then_some(&contact.moment[..]),
        closed,
        open,
        length: contact.length,
        max_pressure: hardest.map_or(f64::NAN, |node| node.pressure),
        max_pressure_at: hardest.map(|node| &node.point[..]),
        max_penetration: max_penetration(&contact.nodes),
        imbalance: contact.imbalance,
        dissipated_work: contact.dissipated,
    }
}

#[derive(Clone, Serialize)]
struct SectionEntry<'a> {
    name: &'a str,
    /// Of the middle line.
    length: f64,
    closed: bool,
    /// In space: the direction of extrusion, and how long it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<f64>,
    stations: Vec<StationEntry>,
    extremes: BTreeMap<&'static str, ExtremesEntry>,
}

#[derive(Clone, Serialize)]
struct StationEntry {
    station: usize,
    s: f64,
    /// In space.
    #[serde(skip_serializing_if = "Option::is_none")]
    along: Option<f64>,
    x: f64,
    y: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    z: Option<f64>,
    angle: f64,
    thickness: f64,
    #[serde(rename = "N")]
    normal: f64,
    #[serde(rename = "V")]
    shear: f64,
    #[serde(rename = "M")]
    moment: f64,
    stress_first: f64,
    stress_second: f64,
    /// In space.
    #[serde(rename = "V2", skip_serializing_if = "Option::is_none")]
    shear_along: Option<f64>,
    /// Of whole cuts in space.
    #[serde(rename = "M2", skip_serializing_if = "Option::is_none")]
    moment_along: Option<f64>,
    /// In space.
    #[serde(rename = "T", skip_serializing_if = "Option::is_none")]
    twist: Option<f64>,
    /// With axial symmetry.
    #[serde(rename = "hoop_N", skip_serializing_if = "Option::is_none")]
    hoop_normal: Option<f64>,
    #[serde(rename = "hoop_M", skip_serializing_if = "Option::is_none")]
    hoop_moment: Option<f64>,
    /// With a capacity.
    #[serde(skip_serializing_if = "Option::is_none")]
    utilisation: Option<f64>,
}

#[derive(Clone, Serialize)]
struct ExtremesEntry {
    max: ExtremeEntry,
    min: ExtremeEntry,
}

#[derive(Clone, Serialize)]
struct ExtremeEntry {
    value: f64,
    station: usize,
    s: f64,
    at: Vec<f64>,
}

#[derive(Clone, Serialize)]
struct BedEntry<'a> {
    name: &'a str,
    compression_only: bool,
    /// Times thickness or 2πr.
    area: f64,
    closed_area: f64,
    mean_pressure: f64,
    max_pressure: f64,
    max_pressure_at: Option<&'a [f64]>,
    min_pressure: f64,
    max_gap: f64,
    resultant: &'a [f64],
}

fn bed_entry<const D: usize>(bed: &BedSolution<D>) -> BedEntry<'_> {
    let largest = bed.largest();
    BedEntry {
        name: &bed.name,
        compression_only: bed.compression_only,
        area: bed.area(),
        closed_area: bed.closed_area(),
        mean_pressure: bed.mean_pressure(),
        max_pressure: largest.map_or(f64::NAN, |at| at.pressure),
        max_pressure_at: largest.map(|at| &at.point[..]),
        min_pressure: bed.min_pressure(),
        max_gap: bed.max_gap(),
        resultant: &bed.resultant[..],
    }
}

/// Lists of members, each after the key of its kind.
#[derive(Clone)]
struct Members<'a>(Vec<(&'static str, Vec<MemberEntry<'a>>)>);

impl Serialize for Members<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(kind, entries)| (kind, entries)))
    }
}

#[derive(Clone, Serialize)]
struct MemberEntry<'a> {
    name: &'a str,
    length: f64,
    /// The largest in magnitude, with its sign.
    force: f64,
    min: f64,
    max: f64,
    /// It was tightened in this step.
    tightening: bool,
    /// Of a bolt.
    #[serde(skip_serializing_if = "Option::is_none")]
    shortening: Option<f64>,
    stations: Vec<MemberStationEntry<'a>>,
}

#[derive(Clone, Serialize)]
struct MemberStationEntry<'a> {
    station: usize,
    s: f64,
    at: &'a [f64],
    force: f64,
}

fn members<const D: usize>(solution: &Solution<D>) -> Members<'_> {
    let kinds = solution.members_by_kind();
    let kinds = kinds.map(|(kind, own)| {
        let entries = own.into_iter().map(member_entry);
        (kind.plural, entries.collect())
    });
    Members(kinds.collect())
}

fn member_entry<const D: usize>(member: &MemberSolution<D>) -> MemberEntry<'_> {
    let [min, max] = range(member.stations.iter().map(|station| station.force));
    let stations = member.stations.iter().enumerate();
    let stations = stations.map(|(index, station)| MemberStationEntry {
        station: index + 1,
        s: station.s,
        at: &station.point[..],
        force: station.force,
    });
    MemberEntry {
        name: &member.name,
        length: member.length,
        force: member.largest().map_or(f64::NAN, |station| station.force),
        min,
        max,
        tightening: member.tightening,
        shortening: member.shortening,
        stations: stations.collect(),
    }
}

fn section_entry(section: &SectionSolution) -> SectionEntry<'_> {
    let stations = section.known().map(|(index, station)| {
        let [stress_first, stress_second] = station.edge_stress();
        let ([x, y, z], across) = (station.place(), station.across);
        StationEntry {
            station: index + 1,
            s: station.s,
            along: across.map(|own| own.along),
            x,
            y,
            z: across.map(|_| z),
            angle: station.angle(),
            thickness: station.thickness,
            normal: station.normal,
            shear: station.shear,
            moment: station.moment,
            stress_first,
            stress_second,
            shear_along: across.map(|own| own.shear),
            moment_along: across.and_then(|own| own.moment),
            twist: across.map(|own| own.twist),
            hoop_normal: station.hoop.map(|[force, _]| force),
            hoop_moment: station.hoop.map(|[_, moment]| moment),
            utilisation: station.utilisation,
        }
    });
    let extreme = |index: usize, value: f64| {
        let station = &section.stations[index];
        ExtremeEntry {
            value,
            station: index + 1,
            s: station.s,
            at: station.coordinates(),
        }
    };
    let extremes = SectionQuantity::ALL.into_iter().filter_map(|quantity| {
        let [min, max] = section.extremes(quantity)?;
        let max = extreme(max.0, max.1);
        let min = extreme(min.0, min.1);
        Some((quantity.name(), ExtremesEntry { max, min }))
    });
    SectionEntry {
        name: &section.name,
        length: section.length,
        closed: section.closed,
        axis: section.extrusion.as_ref().map(|own| own.axis),
        width: section.extrusion.as_ref().map(|own| own.length),
        stations: stations.collect(),
        extremes: extremes.collect(),
    }
}

/// One angle in 2D, three components in 3D.
#[derive(Clone, Serialize)]
#[serde(untagged)]
enum Rotation<'a> {
    Angle(f64),
    Vector(&'a [f64]),
}

impl<'a> Rotation<'a> {
    fn of(components: &'a [f64]) -> Self {
        match components {
            [angle] => Self::Angle(*angle),
            _ => Self::Vector(components),
        }
    }
}

#[derive(Clone, Serialize)]
struct RigidEntry<'a> {
    translation: &'a [f64],
    rotation: Rotation<'a>,
}

#[derive(Clone, Serialize)]
struct BodyEntry<'a> {
    name: &'a str,
    nodes: usize,
    cells: usize,
    dofs: usize,
    floating_modes: usize,
    rigid: RigidEntry<'a>,
    reaction: &'a [f64],
    max_displacement: f64,
    max_von_mises: f64,
    max_von_mises_at: Option<&'a [f64]>,
    /// The singularity there; null if there is none.
    max_von_mises_place: Option<String>,
    /// The largest one away from such places, and its point; null without such a place, or without nodes away from it.
    max_von_mises_away: Option<f64>,
    max_von_mises_away_at: Option<&'a [f64]>,
    strain_energy: f64,
    /// Of the stress over the strength; only where a body of the model has one.
    #[serde(flatten)]
    strength: Option<StrengthEntry<'a>>,
    /// Only where a material of the body yields.
    #[serde(skip_serializing_if = "Option::is_none")]
    plastic_area: Option<f64>,
    /// The points of couples; only if there are any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    couples: Vec<CoupleEntry<'a>>,
}

/// Null if the body has no strength; the largest utilisation also if it is infinite.
#[derive(Clone, Serialize)]
struct StrengthEntry<'a> {
    overstressed_area: Option<f64>,
    max_utilisation: Option<f64>,
    max_utilisation_at: Option<&'a [f64]>,
    /// The singularity there; null if there is none.
    max_utilisation_place: Option<String>,
}

fn strength_entry<const D: usize>(body: &BodySolution<D>) -> StrengthEntry<'_> {
    let own = body.utilisation.as_ref();
    let peak = own.and_then(|own| own.peak.as_ref());
    let singular = peak.and_then(|peak| peak.place.as_ref());
    StrengthEntry {
        overstressed_area: own.map(|own| own.overstressed),
        max_utilisation: peak.map(|peak| peak.most.value),
        max_utilisation_at: peak.map(|peak| &peak.most.at[..]),
        max_utilisation_place: singular.map(|singular| singular.place.to_string()),
    }
}

#[derive(Clone, Serialize)]
struct CoupleEntry<'a> {
    point: &'a str,
    kind: &'a str,
    displacement: &'a [f64],
    rotation: Rotation<'a>,
    force: &'a [f64],
    moment: Rotation<'a>,
}

fn couple_entry<const D: usize>(couple: &CoupleSolution<D>) -> CoupleEntry<'_> {
    CoupleEntry {
        point: &couple.name,
        kind: couple.kind.name(),
        displacement: &couple.displacement,
        rotation: Rotation::of(&couple.rotation),
        force: &couple.force,
        moment: Rotation::of(&couple.moment),
    }
}

fn body_entry<const D: usize>(
    body: &BodySolution<D>,
    [nodes, cells]: [usize; 2],
    judged: bool,
) -> BodyEntry<'_> {
    let peak = body.peak.as_ref();
    let singular = peak.and_then(|peak| peak.place.as_ref());
    let away = singular.and_then(|singular| singular.away.as_ref());
    BodyEntry {
        name: &body.name,
        nodes,
        cells,
        dofs: body.dofs,
        floating_modes: body.floating_modes.len(),
        rigid: RigidEntry {
            translation: &body.rigid.translation,
            rotation: Rotation::of(&body.rigid.rotation),
        },
        reaction: &body.reaction,
        max_displacement: body.max_displacement(),
        max_von_mises: largest(body.von_mises.iter().copied()),
        max_von_mises_at: peak.map(|peak| &peak.most.at[..]),
        max_von_mises_place: singular.map(|singular| singular.place.to_string()),
        max_von_mises_away: away.map(|away| away.value),
        max_von_mises_away_at: away.map(|away| &away.at[..]),
        strain_energy: body.strain_energy,
        strength: judged.then(|| strength_entry(body)),
        plastic_area: body.yielding.as_ref().map(|own| own.extent),
        couples: body.couples.iter().map(couple_entry).collect(),
    }
}

#[derive(Clone, Serialize)]
struct ProbeEntry<'a> {
    name: &'a str,
    quantity: &'a str,
    value: f64,
    /// Where the case names units.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
    /// Of the largest or smallest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<&'a [f64]>,
    /// Of a line, whose values are in lines.csv.
    #[serde(flatten)]
    line: Option<LineEntry>,
}

#[derive(Clone, Serialize)]
struct LineEntry {
    points: usize,
    length: f64,
    smallest: f64,
    largest: f64,
}

fn line_entry(line: &[LinePoint]) -> Option<LineEntry> {
    let length = line.last()?.s;
    let [smallest, largest] = range(line.iter().map(|point| point.value));
    Some(LineEntry {
        points: line.len(),
        length,
        smallest,
        largest,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel;
    use serde_json::Value;

    fn keys(value: &Value) -> Vec<&str> {
        let keys = value.as_object().unwrap().keys();
        let mut keys: Vec<&str> = keys.map(String::as_str).collect();
        keys.sort_unstable();
        keys
    }

    /// Compares the keys without their order.
    fn sorted<const N: usize>(mut names: [&str; N]) -> Vec<&str> {
        names.sort_unstable();
        names.to_vec()
    }

    #[test]
    fn summary_has_exactly_the_contracted_keys() {
        let (model, solution) = tunnel::solved();
        let text = summary(&tunnel::run(&model, &solution));
        let value: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            keys(&value),
            sorted([
                "schema",
                "case",
                "version",
                "units",
                "time",
                "converged",
                "solver",
                "iterations",
                "dofs",
                "contact_unknowns",
                "subdomains",
                "threads",
                "peak_memory_bytes",
                "seconds",
                "certificate",
                "contacts",
                "bodies",
                "probes",
                "warnings",
            ])
        );
        assert_eq!(
            keys(&value["seconds"]),
            sorted([
                "read", "assemble", "order", "factor", "condense", "contact", "recover", "write",
                "total",
            ])
        );
        assert_eq!(
            keys(&value["certificate"]),
            sorted([
                "penetration",
                "tension",
                "complementarity",
                "imbalance_force",
                "imbalance_moment",
                "energy_gap",
                "slip_violation",
                "force_error",
                "rounding",
                "between_nodes",
                "overlap",
            ])
        );
        assert_eq!(
            keys(&value["certificate"]["tension"]),
            sorted(["value", "relative", "limit"])
        );
        assert_eq!(
            keys(&value["contacts"][0]),
            sorted([
                "name",
                "resultant",
                "closed",
                "open",
                "length",
                "max_pressure",
                "max_pressure_at",
                "nonmortar",
                "mortar",
                "max_penetration",
                "imbalance",
                "dissipated_work",
            ])
        );
        assert_eq!(
            keys(&value["bodies"][0]),
            sorted([
                "name",
                "nodes",
                "cells",
                "dofs",
                "floating_modes",
                "rigid",
                "reaction",
                "max_displacement",
                "max_von_mises",
                "max_von_mises_at",
                "max_von_mises_place",
                "max_von_mises_away",
                "max_von_mises_away_at",
                "strain_energy",
            ])
        );
        assert_eq!(
            keys(&value["bodies"][0]["rigid"]),
            sorted(["translation", "rotation"])
        );
        assert_eq!(
            keys(&value["probes"][0]),
            sorted(["name", "quantity", "value", "unit"])
        );
        assert_eq!(value["probes"][0]["unit"], "m");
        let units = [
            ("length", "m"),
            ("force", "MN"),
            ("stress", "MN/m²"),
            ("energy", "MN m"),
        ];
        for (dimension, unit) in units {
            assert_eq!(value["units"][dimension], unit);
        }
        let hardest = solution.contacts[0].nodes.iter();
        let hardest = hardest
            .max_by(|a, b| a.pressure.total_cmp(&b.pressure))
            .unwrap();
        assert_eq!(value["contacts"][0]["max_pressure_at"][0], hardest.point[0]);
    }

    #[test]
    fn several_steps_are_objects_of_the_same_shape_and_the_last_is_the_top_level() {
        let (model, solution) = tunnel::solved();
        let mut first = solution.clone();
        first.time = 0.25;
        let earlier = [first];
        let text = summary(&Overview {
            earlier: &earlier,
            ..tunnel::run(&model, &solution)
        });
        let mut value: Value = serde_json::from_str(&text).unwrap();
        let steps = value.as_object_mut().unwrap().remove("steps").unwrap();
        for of_all in ["schema", "units"] {
            value.as_object_mut().unwrap().remove(of_all).unwrap();
        }
        assert_eq!(steps[1], value);
        assert_eq!(keys(&steps[0]), keys(&value));
        for (step, time) in [(0, 0.25), (1, 1.0)] {
            assert_eq!(steps[step]["step"], step + 1);
            assert_eq!(steps[step]["time"], time);
        }
    }

    #[test]
    fn numbers_keep_their_kind_and_undefined_ones_are_null() {
        let (model, mut solution) = tunnel::solved();
        solution.probes[0].value = f64::NAN;
        solution.certificate.energy_gap.relative = f64::INFINITY;
        let text = summary(&Overview {
            converged: false,
            ..tunnel::run(&model, &solution)
        });
        let value: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["converged"], false);
        assert_eq!(value["probes"][0]["value"], Value::Null);
        assert_eq!(value["certificate"]["energy_gap"]["relative"], Value::Null);
        let rotation = solution.bodies[0].rigid.rotation[0];
        assert_eq!(
            value["bodies"][0]["rigid"]["rotation"].as_f64(),
            Some(rotation)
        );
        assert_eq!(value["bodies"][0]["floating_modes"], 1);
        let contact = &value["contacts"][0];
        let (closed, open) = (contact["closed"].as_u64(), contact["open"].as_u64());
        assert_eq!(closed.unwrap() + open.unwrap(), 17);
        assert!(text.starts_with("{\n  \"schema\": 1,\n  \"case\": \"case_1\",\n  \"version\""));
    }

    #[test]
    fn penetration_is_the_largest_negative_gap() {
        let (_, solution) = tunnel::solved();
        let mut nodes = solution.contacts[0].nodes.clone();
        nodes[3].gap = -2e-9;
        nodes[4].gap = f64::NAN;
        assert_eq!(max_penetration(&nodes), 2e-9);
        for node in &mut nodes {
            node.gap = f64::NAN;
        }
        assert!(max_penetration(&nodes).is_nan());
    }
}
