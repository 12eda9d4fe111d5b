//! A deck as a case: its text, whose every line comes from a line of the deck, and the groups of its mesh.

use crate::bodies::{Bodies, Body};
use crate::course::{active, expression, quoted, stretches};
use crate::deck::{Adjust, Coupling, Cyclic, Deck, Face, Index, Interaction, Motion, Pair};
use crate::error::Fault;
use crate::lines::{Place, folded};
use crate::msh::Groups;
use crate::names::{Names, clean};
use crate::pretension::{PreTension, Tightening};
use crate::reach::beyond;
use crate::steps::{Course, Step};
use dotyk::model::Analysis;
use std::collections::{BTreeMap, BTreeSet};

/// Part of the largest size below which numbers count as the same: they may be written with six digits.
const SAME: f64 = 2e-6;

/// Part of a sum of squares that is rounding of sums of a million.
const FLAT: f64 = 1e-10;

/// A part of the typical edge within which CalculiX ties by default.
const TIED: f64 = 0.025;

/// The same of surfaces that lie on each other.
const UPON: f64 = 1e-6;

/// Values of a course in its steps, by their bits; `None` where it is not there.
type Values = Vec<Option<u64>>;

/// Degrees of freedom with their courses.
type Freedoms = Vec<(u8, Values)>;

/// The text of a case with the line of the deck that each of its lines comes from.
#[derive(Debug, Default)]
pub(crate) struct Text {
    pub text: String,
    pub origins: Vec<Place>,
}

impl Text {
    fn line(&mut self, place: Place, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
        self.origins.push(place);
    }

    fn list(&mut self, place: Place, key: &str, entries: &[(Place, String)]) {
        if entries.is_empty() {
            return;
        }
        self.line(place, &format!("{key} = ["));
        for (place, entry) in entries {
            self.line(*place, &format!("  {entry},"));
        }
        self.line(place, "]");
    }
}

/// A contact of the case, for the results that a deck asks for.
#[derive(Debug, Clone)]
pub(crate) struct Named {
    pub name: String,
    pub slave: String,
    pub master: String,
}

/// The case of a deck.
pub(crate) struct Writer<'d> {
    deck: &'d mut Deck,
    bodies: &'d Bodies,
    names: Names,
    pub text: Text,
    pub groups: Groups,
    pub contacts: Vec<Named>,
    /// Names of sides and points by body and content.
    sides: BTreeMap<(usize, Vec<Face>), String>,
    points: BTreeMap<(usize, Vec<Index>), String>,
    /// Names of sides and points that each body has.
    used: Vec<Names>,
    /// Reference points: body and name of the point.
    pub references: BTreeMap<Index, (usize, String)>,
    /// Nodes of pre-tension sections and the names of their bolts.
    pub shortenings: Vec<(Index, String)>,
}

/// Entries of `fix` and `load` and the like of one body.
#[derive(Default)]
struct Entries {
    fix: Vec<(Place, String)>,
    load: Vec<(Place, String)>,
    couple: Vec<(Place, String)>,
    points: Vec<(Place, String)>,
    cyclic: Option<(Place, String)>,
}

impl<'d> Writer<'d> {
    /// Writes the case; `file` is the name of its mesh file, `title` what it is called without *HEADING.
    ///
    /// Errors: what the case cannot say, at its line.
    pub fn new(
        deck: &'d mut Deck,
        bodies: &'d Bodies,
        names: Names,
        file: &str,
        title: &str,
    ) -> Result<Self, Fault> {
        let mut writer = Self {
            deck,
            bodies,
            names,
            text: Text::default(),
            groups: Groups::default(),
            contacts: Vec::new(),
            sides: BTreeMap::new(),
            points: BTreeMap::new(),
            used: bodies.list.iter().map(|_| Names::default()).collect(),
            references: BTreeMap::new(),
            shortenings: Vec::new(),
        };
        writer.head(title);
        // what acts is handed over to bodies
        let sections = writer.deck.pretensions.clone().into_iter();
        let tightened = sections.map(|section| Ok((writer.deck.tightening(&section)?, section)));
        let tightened: Vec<(Tightening, PreTension)> = tightened.collect::<Result<_, Fault>>()?;
        let mut entries: Vec<Entries> = bodies.list.iter().map(|_| Entries::default()).collect();
        writer.couples(&mut entries)?;
        writer.supports(&mut entries)?;
        writer.forces(&mut entries)?;
        writer.pressures(&mut entries)?;
        writer.sectors(&mut entries)?;
        for (index, own) in entries.into_iter().enumerate() {
            writer.body(index, file, own)?;
        }
        writer.contacts()?;
        writer.ties()?;
        writer.bolts(&tightened)?;
        for step in writer.deck.steps.clone() {
            let [number, increment, count] = step.number;
            let increment = match count {
                1 => String::new(),
                _ => format!("-{increment}"),
            };
            let line = format!(
                "[[step]]\nname = \"step-{number}{increment}\"\ntime = {:?}\n",
                step.time
            );
            line.lines()
                .for_each(|line| writer.text.line(step.place, line));
        }
        Ok(writer)
    }

    fn head(&mut self, title: &str) {
        let first = Place { file: 0, line: 1 };
        let headings = self.deck.headings.join(" ");
        let title = match headings.trim() {
            "" => title,
            heading => heading,
        };
        let title: String = title.chars().filter(|c| !c.is_control()).collect();
        let title = title.replace('\\', "\\\\").replace('"', "\\\"");
        self.text.line(first, &format!("title = \"{title}\""));
        self.text.line(
            first,
            &format!("analysis = \"{}\"", self.bodies.analysis.name()),
        );
        self.text.line(first, "");
    }

    fn axes(&self) -> usize {
        if self.bodies.analysis == Analysis::Solid {
            3
        } else {
            2
        }
    }

    /// The name of a side of a body with these faces.
    fn side(&mut self, body: usize, faces: &[Face], wanted: &str) -> String {
        let mut faces = faces.to_vec();
        faces.sort_unstable();
        if let Some(known) = self.sides.get(&(body, faces.clone())) {
            return known.clone();
        }
        let name = self.free(body, wanted);
        self.groups
            .sides
            .entry(name.clone())
            .or_default()
            .extend(&faces);
        self.sides.insert((body, faces), name.clone());
        name
    }

    /// The name of a group of nodes of a body.
    ///
    /// Errors: a node at whose place the body has another one.
    fn point(
        &mut self,
        body: usize,
        nodes: &[Index],
        wanted: &str,
        (place, keyword): (Place, &str),
    ) -> Result<String, Fault> {
        if let Some(node) = nodes.iter().find(|node| self.bodies.doubled.contains(node)) {
            let message = format!(
                "node {} lies where its body has another node, and cannot be told from it: name whole faces",
                self.deck.numbers[*node as usize]
            );
            return Err(Fault::new(place, keyword, message));
        }
        if let Some(known) = self.points.get(&(body, nodes.to_vec())) {
            return Ok(known.clone());
        }
        let name = self.free(body, wanted);
        self.groups
            .points
            .entry(name.clone())
            .or_default()
            .extend(nodes);
        self.points.insert((body, nodes.to_vec()), name.clone());
        Ok(name)
    }

    fn free(&mut self, body: usize, wanted: &str) -> String {
        let wanted = match clean(wanted) {
            // a name of digits alone would be a number
            name if name.chars().all(|c| c.is_ascii_digit()) => format!("N{name}"),
            name if name == "boundary" => "boundary-1".to_string(),
            name => name,
        };
        self.used[body].fresh(&wanted)
    }

    /// Boundary faces of a body with all of their nodes among these, and the nodes that are on none of them.
    fn cover(&self, body: usize, nodes: &[Index]) -> (Vec<Face>, Vec<Index>) {
        let set: BTreeSet<Index> = nodes.iter().copied().collect();
        let own = &self.bodies.list[body];
        let near = set
            .iter()
            .filter_map(|node| own.at_node.get(node))
            .flatten();
        let near: BTreeSet<usize> = near.copied().collect();
        let mut covered = BTreeSet::new();
        let mut faces = Vec::new();
        for face in near.into_iter().map(|place| own.boundary[place]) {
            let nodes = self.deck.face_nodes(face);
            if nodes.iter().all(|node| set.contains(node)) {
                covered.extend(nodes);
                faces.push(face);
            }
        }
        let rest = set.into_iter().filter(|node| !covered.contains(node));
        (faces, rest.collect())
    }

    /// The places of nodes in a case: `side = ".."` and `point = ".."`.
    fn places(
        &mut self,
        body: usize,
        nodes: &[Index],
        wanted: &str,
        at: (Place, &str),
    ) -> Result<Vec<String>, Fault> {
        let (faces, rest) = self.cover(body, nodes);
        let mut places = Vec::new();
        if !faces.is_empty() {
            places.push(format!("side = \"{}\"", self.side(body, &faces, wanted)));
        }
        if !rest.is_empty() {
            let wanted = if faces.is_empty() {
                wanted.to_string()
            } else {
                format!("{wanted}-nodes")
            };
            let point = self.point(body, &rest, &wanted, at)?;
            places.push(format!("point = \"{point}\""));
        }
        Ok(places)
    }

    fn couples(&mut self, entries: &mut [Entries]) -> Result<(), Fault> {
        let couplings = std::mem::take(&mut self.deck.couplings);
        for coupling in &couplings {
            let fault = |message: String| Fault::new(coupling.place, &coupling.keyword, message);
            let (by_body, loose) = self.bodies.split(&coupling.nodes);
            let mut by_body = by_body.into_iter();
            let (Some((body, nodes)), None) = (by_body.next(), by_body.next()) else {
                return Err(fault(format!(
                    "the nodes of {} belong to several bodies, or to none: one is supported",
                    coupling.of
                )));
            };
            if !loose.is_empty() {
                return Err(fault(format!(
                    "{} has nodes that belong to no element",
                    coupling.of
                )));
            }
            if self.references.contains_key(&coupling.reference) {
                return Err(fault(
                    "the reference node has another coupling already".to_string(),
                ));
            }
            let (faces, rest) = self.cover(body, &nodes);
            if faces.is_empty() {
                return Err(fault(format!(
                    "the nodes of {} make no face of an element",
                    coupling.of
                )));
            }
            // within a body that is rigid as a whole nothing deforms
            let whole = nodes.len() == self.bodies.list[body].nodes.len();
            if let (Some(first), false) = (rest.first(), whole) {
                return Err(fault(format!(
                    "{} nodes of {} are on no face with all its nodes there, node {} for one: whole faces are supported",
                    rest.len(),
                    coupling.of,
                    self.deck.numbers[*first as usize]
                )));
            }
            let within = self.bodies.of_node[coupling.reference as usize].is_some();
            if within && !nodes.contains(&coupling.reference) {
                return Err(fault(format!(
                    "the reference node {} belongs to an element: take a node of its own",
                    self.deck.numbers[coupling.reference as usize]
                )));
            }
            let side = self.side(body, &faces, &coupling.of);
            let point = self.free(body, &format!("{}-point", coupling.name));
            let axes = self.axes();
            let at = list(&self.deck.points[coupling.reference as usize][..axes]);
            let kind = match coupling.motion {
                Some(Motion::Average) => "average",
                _ => "rigid",
            };
            let own = &mut entries[body];
            if coupling.motion == Some(Motion::Parallel) {
                let still = if axes == 2 {
                    "0.0"
                } else {
                    "{ x = 0.0, y = 0.0, z = 0.0 }"
                };
                own.fix.push((
                    coupling.place,
                    format!("{{ point = \"{point}\", rotation = {still} }}"),
                ));
            }
            own.points.push((coupling.place, format!("{point} = {at}")));
            own.couple.push((
                coupling.place,
                format!("{{ side = \"{side}\", point = \"{point}\", kind = \"{kind}\" }}"),
            ));
            self.references.insert(coupling.reference, (body, point));
        }
        self.deck.couplings = couplings;
        Ok(())
    }

    /// The coupling that a node is the point of, or whose rotation it is.
    fn coupling(&self, node: Index) -> Option<(&Coupling, bool)> {
        let mut known = self.deck.couplings.iter();
        known.find_map(|coupling| match () {
            () if coupling.reference == node => Some((coupling, false)),
            () if coupling.rotation == Some(node) => Some((coupling, true)),
            () => None,
        })
    }

    /// Whether a node is that of a pre-tension section.
    fn shortens(&self, node: Index) -> bool {
        let mut sections = self.deck.pretensions.iter();
        sections.any(|section| section.node == node)
    }

    fn supports(&mut self, entries: &mut [Entries]) -> Result<(), Fault> {
        let held = std::mem::take(&mut self.deck.acting.held.all);
        let steps = self.deck.steps.clone();
        // nodes with the same line and the same values are one support
        type Key = (Place, String, Freedoms);
        let mut alike: BTreeMap<Key, Vec<Index>> = BTreeMap::new();
        let mut by_node: BTreeMap<(Index, Place), Vec<(u8, &Course)>> = BTreeMap::new();
        for ((node, freedom), course) in &held {
            if self.shortens(*node) {
                continue;
            }
            late(course, *freedom)?;
            match self.coupling(*node) {
                Some(_) => self.hold_point(*node, *freedom, course, &steps, entries)?,
                // a solid has no such motion: only that it is none can be said of it
                None if usize::from(*freedom) > self.axes() => {
                    if course.values.iter().flatten().any(|value| *value != 0.0) {
                        let message = format!("solid elements have no degree of freedom {freedom}");
                        return Err(Fault::new(course.place, "BOUNDARY", message));
                    }
                }
                None => by_node
                    .entry((*node, course.place))
                    .or_default()
                    .push((*freedom, course)),
            }
        }
        // nodes that lines name by their numbers belong together where their values are the same
        let mut first: BTreeMap<Freedoms, Place> = BTreeMap::new();
        for ((node, place), courses) in &by_node {
            let values = courses.iter();
            let values = values.map(|(freedom, course)| (*freedom, course.key()));
            let values: Vec<_> = values.collect();
            let of = &courses[0].1.of;
            let (place, of) = match of.parse::<u64>() {
                Ok(_) => (*first.entry(values.clone()).or_insert(*place), "fixed"),
                Err(_) => (*place, of.as_str()),
            };
            alike
                .entry((place, of.to_string(), values))
                .or_default()
                .push(*node);
        }
        for ((place, of, values), nodes) in alike {
            let (by_body, loose) = self.bodies.split(&nodes);
            if !loose.is_empty() && by_body.is_empty() {
                let number = self.deck.numbers[loose[0] as usize];
                self.deck.note(
                    place,
                    "BOUNDARY",
                    &format!("node {number} belongs to no element: it holds nothing"),
                );
            }
            for (body, nodes) in by_body {
                let places = self.places(body, &nodes, &of, (place, "BOUNDARY"))?;
                for at in places {
                    for (keys, during) in self.merged(&values, &steps) {
                        entries[body]
                            .fix
                            .push((place, format!("{{ {at}, {keys}{during} }}")));
                    }
                }
            }
        }
        Ok(())
    }

    /// Components with the stretches in which they are there; those of the same stretch are one entry.
    fn merged(&self, values: &[(u8, Values)], steps: &[Step]) -> Vec<(String, String)> {
        let mut by_time: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (freedom, key) in values {
            let own: Vec<Option<f64>> = key.iter().map(|bits| bits.map(f64::from_bits)).collect();
            for stretch in stretches(&own, steps) {
                let entry = format!("{} = {}", axis(*freedom), stretch.text);
                by_time
                    .entry(active(&stretch, steps))
                    .or_default()
                    .push(entry);
            }
        }
        by_time
            .into_iter()
            .map(|(during, keys)| (keys.join(", "), during))
            .collect()
    }

    /// A support of a reference point: 1 to 3 displacements, 4 to 6, or 1 to 3 of the rotation node, rotations.
    fn hold_point(
        &mut self,
        node: Index,
        freedom: u8,
        course: &Course,
        steps: &[Step],
        entries: &mut [Entries],
    ) -> Result<(), Fault> {
        let Some((coupling, turns)) = self.coupling(node) else {
            return Ok(());
        };
        let Some((body, point)) = self.references.get(&coupling.reference).cloned() else {
            return Ok(());
        };
        let axes = self.axes();
        let about = match (turns, freedom) {
            (true, k) if k <= 3 => Some(k),
            (false, k) if k > 3 => Some(k - 3),
            _ => None,
        };
        if axes == 2 && about.is_some_and(|k| k != 3)
            || about.is_none() && usize::from(freedom) > axes
        {
            return Ok(());
        }
        for stretch in stretches(&course.values, steps) {
            let during = active(&stretch, steps);
            let key = match about {
                None => format!("{} = {}", axis(freedom), stretch.text),
                Some(_) if axes == 2 => format!("rotation = {}", stretch.text),
                Some(k) => format!("rotation = {{ {} = {} }}", axis(k), stretch.text),
            };
            entries[body].fix.push((
                course.place,
                format!("{{ point = \"{point}\", {key}{during} }}"),
            ));
        }
        Ok(())
    }

    fn forces(&mut self, entries: &mut [Entries]) -> Result<(), Fault> {
        let forces = std::mem::take(&mut self.deck.acting.forces.all);
        let steps = self.deck.steps.clone();
        type Key = (Place, String, Freedoms);
        let mut alike: BTreeMap<Key, Vec<Index>> = BTreeMap::new();
        let mut by_node: BTreeMap<(Index, String), Vec<(u8, &Course)>> = BTreeMap::new();
        let axes = self.axes();
        for ((node, freedom), course) in &forces {
            let fault = |message: String| Fault::new(course.place, "CLOAD", message);
            let number = self.deck.numbers[*node as usize];
            if self.shortens(*node) {
                continue;
            }
            if let Some((coupling, turns)) = self.coupling(*node) {
                let Some((body, point)) = self.references.get(&coupling.reference).cloned() else {
                    continue;
                };
                let text = quoted(&expression(&course.filled(), &steps));
                let zeros = |k: u8| -> Vec<String> {
                    let along = (1..=axes as u8).map(|d| {
                        if d == k {
                            text.clone()
                        } else {
                            "0.0".to_string()
                        }
                    });
                    along.collect()
                };
                let entry = match (turns, *freedom) {
                    (false, k) if usize::from(k) <= axes => {
                        format!("force = [{}]", zeros(k).join(", "))
                    }
                    (true, k) | (false, k) if axes == 3 && (turns || k > 3) => {
                        format!(
                            "moment = [{}]",
                            zeros(if turns { k } else { k - 3 }).join(", ")
                        )
                    }
                    (true, 3) | (false, 6) => format!("moment = {text}"),
                    _ => {
                        return Err(fault(format!(
                            "degree of freedom {freedom} of node {number} does not exist in the plane"
                        )));
                    }
                };
                entries[body]
                    .load
                    .push((course.place, format!("{{ point = \"{point}\", {entry} }}")));
                continue;
            }
            if usize::from(*freedom) > axes {
                return Err(fault(format!(
                    "node {number} of solid elements has no degree of freedom {freedom}"
                )));
            }
            if self.bodies.of_node[*node as usize].is_none() {
                return Err(fault(format!(
                    "node {number} belongs to no element, and is the reference node of nothing"
                )));
            }
            by_node
                .entry((*node, course.of.clone()))
                .or_default()
                .push((*freedom, course));
        }
        for ((node, of), courses) in &by_node {
            let values = courses
                .iter()
                .map(|(freedom, course)| (*freedom, course.key()));
            alike
                .entry((courses[0].1.place, of.clone(), values.collect()))
                .or_default()
                .push(*node);
        }
        for ((place, of, values), nodes) in alike {
            let component = |k: u8| match values.iter().find(|(freedom, _)| *freedom == k) {
                None => "0.0".to_string(),
                Some((_, key)) => {
                    let own: Vec<f64> = key
                        .iter()
                        .map(|bits| bits.map_or(0.0, f64::from_bits))
                        .collect();
                    quoted(&expression(&own, &steps))
                }
            };
            let force: Vec<String> = (1..=axes as u8).map(component).collect();
            for (body, nodes) in self.bodies.split(&nodes).0 {
                let point = self.point(body, &nodes, &of, (place, "CLOAD"))?;
                entries[body].load.push((
                    place,
                    format!("{{ point = \"{point}\", force = [{}] }}", force.join(", ")),
                ));
            }
        }
        Ok(())
    }

    fn pressures(&mut self, entries: &mut [Entries]) -> Result<(), Fault> {
        let steps = self.deck.steps.clone();
        let faces = std::mem::take(&mut self.deck.acting.pressures.all);
        type Pressed = (String, Vec<Face>);
        let mut alike: BTreeMap<(Place, Values), Pressed> = BTreeMap::new();
        // lines of one set with the same value are one load
        let mut first: BTreeMap<(String, Values), Place> = BTreeMap::new();
        for (face, course) in &faces {
            self.outer(&[*face], course.place, &course.keyword)?;
            let of = match course.of.parse::<u64>() {
                Ok(_) => "pressed".to_string(),
                Err(_) => course.of.clone(),
            };
            let place = *first
                .entry((of.clone(), course.key()))
                .or_insert(course.place);
            alike
                .entry((place, course.key()))
                .or_insert_with(|| (of, Vec::new()))
                .1
                .push(*face);
        }
        for ((place, key), (of, faces)) in alike {
            let own: Vec<f64> = key
                .iter()
                .map(|bits| bits.map_or(0.0, f64::from_bits))
                .collect();
            let text = quoted(&expression(&own, &steps));
            for (body, faces) in self.bodies.split_faces(&faces) {
                let side = self.side(body, &faces, &of);
                entries[body]
                    .load
                    .push((place, format!("{{ side = \"{side}\", pressure = {text} }}")));
            }
        }
        Ok(())
    }

    fn body(&mut self, index: usize, file: &str, entries: Entries) -> Result<(), Fault> {
        let bodies = self.bodies;
        let body = &bodies.list[index];
        let first = &self.deck.sections[body.sections[0].0];
        let place = first.place;
        let groups: Vec<String> = body
            .sections
            .iter()
            .map(|(_, group)| format!("\"{group}\""))
            .collect();
        let material = self.materials(body)?;
        let gravity = self.gravity(body)?;
        let thermal = self.thermal(body)?;
        let enhanced = body.elements.iter().any(|e| {
            self.deck.kinds[self.deck.elements[*e as usize].kind]
                .1
                .enhanced
        });
        let text = &mut self.text;
        text.line(place, "[[body]]");
        text.line(place, &format!("name = \"{}\"", body.name));
        text.line(
            place,
            &format!(
                "mesh = {{ file = {{ path = \"{file}\", group = [{}] }} }}",
                groups.join(", ")
            ),
        );
        match &material[..] {
            [(place, one)] => text.line(*place, &format!("material = {{ {one} }}")),
            several => {
                let entries = several.iter().zip(&groups);
                let entries = entries
                    .map(|((place, own), group)| (*place, format!("{{ group = {group}, {own} }}")));
                text.list(place, "material", &entries.collect::<Vec<_>>());
            }
        }
        if enhanced {
            text.line(place, "formulation = \"enhanced\"");
        }
        if let Some((place, force)) = gravity {
            text.line(place, &format!("body_force = [{}]", force.join(", ")));
        }
        if let Some((place, strain)) = thermal {
            text.line(place, &format!("initial_strain = {strain}"));
        }
        if !entries.points.is_empty() {
            let points: Vec<&str> = entries
                .points
                .iter()
                .map(|(_, point)| point.as_str())
                .collect();
            text.line(
                entries.points[0].0,
                &format!("points = {{ {} }}", points.join(", ")),
            );
        }
        if let Some((place, cyclic)) = &entries.cyclic {
            text.line(*place, &format!("cyclic = {cyclic}"));
        }
        text.list(place, "couple", &entries.couple);
        text.list(place, "fix", &entries.fix);
        text.list(place, "load", &entries.load);
        text.line(place, "");
        Ok(())
    }

    /// The material of each section of a body, without its group.
    fn materials(&self, body: &Body) -> Result<Vec<(Place, String)>, Fault> {
        let plane = self.axes() == 2 && self.bodies.analysis != Analysis::Axisymmetric;
        let of = |(section, _): &(usize, String)| {
            let section = &self.deck.sections[*section];
            let material = &self.deck.materials[&folded(&section.material)];
            let [young, poisson] = material.elastic.unwrap_or([1.0, 0.0]);
            let thickness = section.thickness.filter(|_| plane);
            let thickness = thickness.map_or(String::new(), |t| format!(", thickness = {t:?}"));
            (
                section.place,
                format!("young = {young:?}, poisson = {poisson:?}{thickness}"),
            )
        };
        Ok(body.sections.iter().map(of).collect())
    }

    /// The density times the acceleration.
    fn gravity(&self, body: &Body) -> Result<Option<(Place, Vec<String>)>, Fault> {
        let mut sum: Option<(Place, Vec<Vec<f64>>)> = None;
        let all = &self.deck.acting.gravity.all;
        let of = |element: &Index| all.range((*element, [0; 3])..=(*element, [u64::MAX; 3]));
        let courses = |element: &Index| -> Vec<([u64; 3], Vec<Option<u64>>)> {
            of(element)
                .map(|((_, way), course)| (*way, course.key()))
                .collect()
        };
        let first = &body.elements[0];
        let other = body
            .elements
            .iter()
            .find(|element| courses(element) != courses(first));
        if let Some(other) = other {
            let course = of(first).chain(of(other)).next();
            let place = course.map_or(Place::default(), |(_, course)| course.place);
            return Err(Fault::new(
                place,
                "DLOAD",
                format!(
                    "GRAV acts on a part of body {}: the whole body is supported",
                    body.name
                ),
            ));
        }
        for ((_, way), course) in of(first) {
            let fault = |message: String| Fault::new(course.place, "DLOAD", message);
            let densities = body.sections.iter().map(|(section, _)| {
                let material =
                    &self.deck.materials[&folded(&self.deck.sections[*section].material)];
                material
                    .density
                    .ok_or_else(|| fault(format!("material {} has no *DENSITY", material.name)))
            });
            let densities = densities.collect::<Result<Vec<_>, _>>()?;
            if densities.iter().any(|density| *density != densities[0]) {
                return Err(fault(format!(
                    "the materials of body {} differ in density: one is supported; tie two bodies",
                    body.name
                )));
            }
            let (_, force) =
                sum.get_or_insert_with(|| (course.place, vec![vec![0.0; course.values.len()]; 3]));
            for (along, part) in force.iter_mut().zip(way.map(f64::from_bits)) {
                for (total, value) in along.iter_mut().zip(course.filled()) {
                    *total += densities[0] * part * value;
                }
            }
        }
        let steps = &self.deck.steps;
        Ok(sum.map(|(place, force)| {
            let along = force
                .iter()
                .take(self.axes())
                .map(|values| quoted(&expression(values, steps)));
            (place, along.collect())
        }))
    }

    /// The change of temperature of a body, times its expansion.
    fn thermal(&self, body: &Body) -> Result<Option<(Place, String)>, Fault> {
        let temperatures = &self.deck.acting.temperatures.all;
        let heated = body.nodes.iter().find_map(|node| temperatures.get(node));
        let Some(heated) = heated else {
            return Ok(None);
        };
        let fault = |message: String| Fault::new(heated.place, "TEMPERATURE", message);
        let materials = body.sections.iter().map(|(section, _)| {
            &self.deck.materials[&folded(&self.deck.sections[*section].material)]
        });
        let expansions: Vec<f64> = materials
            .map(|material| material.expansion.unwrap_or(0.0))
            .collect();
        if expansions
            .iter()
            .any(|expansion| *expansion != expansions[0])
        {
            return Err(fault(format!(
                "the materials of body {} differ in expansion: one is supported; tie two bodies",
                body.name
            )));
        }
        if expansions[0] == 0.0 {
            return Ok(None);
        }
        if let Some(node) = body
            .nodes
            .iter()
            .find(|node| !self.deck.initial.contains_key(node))
        {
            let number = self.deck.numbers[*node as usize];
            return Err(fault(format!(
                "node {number} has no *INITIAL CONDITIONS, TYPE=TEMPERATURE: expansion has no reference"
            )));
        }
        let count = self.deck.steps.len();
        let points = body.nodes.iter();
        let points: Vec<[f64; 3]> = points
            .map(|node| self.deck.points[*node as usize])
            .collect();
        let mut fitted = Vec::with_capacity(count);
        for step in 0..count {
            let change = body.nodes.iter().map(|node| {
                let before = self.deck.initial[node];
                let now = temperatures
                    .get(node)
                    .and_then(|course| course.values[step]);
                now.map_or(0.0, |now| now - before)
            });
            let change: Vec<f64> = change.collect();
            let fit = linear(&points, &change).ok_or_else(|| {
                fault(format!("the temperature of body {} is neither constant nor linear in space: other fields are not supported in a deck", body.name))
            })?;
            fitted.push(fit);
        }
        let mut text = String::new();
        for (k, name) in ["", "*x", "*y", "*z"].iter().enumerate() {
            let values: Vec<f64> = fitted.iter().map(|fit| fit[k]).collect();
            if k > 0 && values.iter().all(|value| *value == 0.0) {
                continue;
            }
            let own = expression(&values, &self.deck.steps);
            text += &if k == 0 {
                own
            } else {
                format!(" + ({own}){name}")
            };
        }
        Ok(Some((
            heated.place,
            format!(
                "{{ thermal = {}, expansion = {:?} }}",
                quoted(&text),
                expansions[0]
            ),
        )))
    }

    /// Refuses faces inside a body.
    fn outer(&self, faces: &[Face], place: Place, keyword: &str) -> Result<(), Fault> {
        let within = faces.iter().find(|(element, face)| {
            let body = &self.bodies.list[self.bodies.of_element[*element as usize]];
            body.boundary.binary_search(&(*element, *face)).is_err()
        });
        match within {
            None => Ok(()),
            Some((element, face)) => Err(Fault::new(
                place,
                keyword,
                format!(
                    "face {} of element {} lies inside a body: faces on its boundary are supported",
                    face + 1,
                    self.deck.elements[*element as usize].number
                ),
            )),
        }
    }

    /// The faces of a surface by body; nodes stand for the faces that they make.
    fn faces_of(
        &mut self,
        name: &str,
        place: Place,
        keyword: &str,
    ) -> Result<BTreeMap<usize, String>, Fault> {
        let surface = &self.deck.surfaces[name];
        let (title, nodes) = (surface.name.clone(), surface.nodes.clone());
        let Some(nodes) = nodes else {
            self.outer(&surface.faces, place, keyword)?;
            let by_body = self.bodies.split_faces(&surface.faces).into_iter();
            let sides = by_body.map(|(body, faces)| (body, self.side(body, &faces, &title)));
            return Ok(sides.collect());
        };
        let (split, loose) = self.bodies.split(&nodes);
        let mut by_body = BTreeMap::new();
        for (body, nodes) in split {
            let (faces, rest) = self.cover(body, &nodes);
            if let Some(node) = rest.first().or(loose.first()) {
                let number = self.deck.numbers[*node as usize];
                let message = format!(
                    "node {number} of surface {title} is on no face with all its nodes there: use a surface of element faces"
                );
                return Err(Fault::new(place, keyword, message));
            }
            by_body.insert(body, faces);
        }
        let sides = by_body
            .into_iter()
            .map(|(body, faces)| (body, self.side(body, &faces, &title)));
        Ok(sides.collect())
    }

    fn contacts(&mut self) -> Result<(), Fault> {
        let pairs = std::mem::take(&mut self.deck.pairs);
        for pair in &pairs {
            self.pair(pair)?;
        }
        self.deck.pairs = pairs;
        Ok(())
    }

    /// The key `gap` of a pair.
    fn gap(&self, pair: &Pair) -> Result<String, Fault> {
        let nodes = match (pair.clearance, &pair.adjust) {
            (Some(value), _) => return Ok(format!("gap = {value:?}")),
            (None, None) => return Ok("gap = \"geometric\"".to_string()),
            (None, Some(Adjust::UpTo(value))) => {
                return Ok(format!("gap = {{ adjust = {value:?} }}"));
            }
            (None, Some(Adjust::Nodes(nodes))) => nodes,
        };
        let adjusted: BTreeSet<&Index> = nodes.iter().collect();
        let surface = &self.deck.surfaces[&pair.slave];
        let own = match &surface.nodes {
            Some(nodes) => nodes.clone(),
            None => surface
                .faces
                .iter()
                .flat_map(|face| self.deck.face_nodes(*face))
                .collect(),
        };
        match own.iter().find(|node| !adjusted.contains(node)) {
            None => Ok("gap = \"closed\"".to_string()),
            Some(node) => {
                let number = self.deck.numbers[*node as usize];
                let message = format!(
                    "ADJUST names some nodes of surface {} only, node {number} is not among them: name all, or give a length",
                    surface.name
                );
                Err(Fault::new(pair.place, "CONTACT PAIR", message))
            }
        }
    }

    /// The keys of a pair that say how it acts.
    fn law(
        &self,
        pair: &Pair,
        interaction: &Interaction,
        tied: bool,
    ) -> Result<Vec<String>, Fault> {
        if tied {
            return Ok(vec!["tied = true".to_string()]);
        }
        let mut keys = vec![self.gap(pair)?];
        if interaction.friction.iter().any(|value| *value != 0.0) {
            let text = expression(&interaction.friction, &self.deck.steps);
            keys.push(format!("friction = {}", quoted(&text)));
        }
        Ok(keys)
    }

    fn pair(&mut self, pair: &Pair) -> Result<(), Fault> {
        let fault = |message: String| Fault::new(pair.place, "CONTACT PAIR", message);
        let Some(interaction) = self.deck.interactions.get(&pair.interaction).cloned() else {
            return Err(fault(format!(
                "there is no *SURFACE INTERACTION {}",
                pair.interaction
            )));
        };
        let steps = self.deck.steps.clone();
        let slaves = self.faces_of(&pair.slave, pair.place, "CONTACT PAIR")?;
        let masters = self.faces_of(&pair.master, pair.place, "CONTACT PAIR")?;
        for tied in [true, false] {
            let there = pair.present.iter().zip(&interaction.tied);
            let there = there.map(|(present, own)| (*present && *own == tied).then_some(0.0));
            for stretch in stretches(&there.collect::<Vec<_>>(), &steps) {
                let mut keys = self.law(pair, &interaction, tied)?;
                let during = active(&stretch, &steps);
                keys.extend(during.strip_prefix(", ").map(str::to_string));
                self.between(
                    (&pair.slave, &pair.master),
                    pair.place,
                    None,
                    [&slaves, &masters],
                    &keys,
                );
            }
        }
        Ok(())
    }

    /// A contact for each two bodies of two surfaces.
    fn between(
        &mut self,
        (slave, master): (&str, &str),
        place: Place,
        name: Option<&str>,
        [slaves, masters]: [&BTreeMap<usize, String>; 2],
        keys: &[String],
    ) {
        let single = slaves.len() == 1 && masters.len() == 1;
        let titles = [slave, master].map(|surface| clean(&self.deck.surfaces[surface].name));
        let base = name.map_or_else(|| titles.join("-"), clean);
        for (own, side) in slaves {
            for (other, opposite) in masters {
                let [a, b] = [own, other].map(|body| self.bodies.list[*body].name.clone());
                let wanted = if single {
                    base.clone()
                } else {
                    format!("{base}-{a}-{b}")
                };
                let name = self.names.fresh(&wanted);
                self.text.line(place, "[[contact]]");
                self.text.line(place, &format!("name = \"{name}\""));
                self.text
                    .line(place, &format!("nonmortar = \"{a}.{side}\""));
                self.text
                    .line(place, &format!("mortar = \"{b}.{opposite}\""));
                keys.iter().for_each(|key| self.text.line(place, key));
                self.text.line(place, "");
                self.contacts.push(Named {
                    name,
                    slave: slave.to_string(),
                    master: master.to_string(),
                });
            }
        }
    }

    /// The faces of bodies that are sectors.
    fn sectors(&mut self, entries: &mut [Entries]) -> Result<(), Fault> {
        let cyclic = std::mem::take(&mut self.deck.cyclic);
        for Cyclic { tie, model } in &cyclic {
            let fault = |message: String| Fault::new(tie.place, "TIE", message);
            let Some((sectors, [point, end])) = model else {
                return Err(fault(format!(
                    "*CYCLIC SYMMETRY MODEL, TIE={} is missing: it has the number of sectors and the axis",
                    tie.name
                )));
            };
            let to = self.faces_of(&tie.slave, tie.place, "TIE")?;
            let from = self.faces_of(&tie.master, tie.place, "TIE")?;
            for body in to.keys().chain(from.keys()) {
                let name = &self.bodies.list[*body].name;
                let (Some(to), Some(from)) = (to.get(body), from.get(body)) else {
                    return Err(fault(format!(
                        "body {name} has one of its two surfaces alone: a sector has both of its faces, and is one body where its elements share nodes"
                    )));
                };
                let along: Vec<f64> = (0..3).map(|d| end[d] - point[d]).collect();
                let axes = self.axes();
                if axes == 2 && (along[0], along[1]) != (0.0, 0.0) {
                    return Err(fault("the axis of a plane sector is along z".to_string()));
                }
                let axis = match axes {
                    2 => String::new(),
                    _ => format!(", axis = {}", list(&along)),
                };
                let point = list(&point[..axes]);
                let keys = format!(
                    "{{ from = \"{from}\", to = \"{to}\", sectors = {sectors}, point = {point}{axis} }}"
                );
                let known = &mut entries[*body].cyclic;
                if known.as_ref().is_some_and(|(_, known)| *known != keys) {
                    return Err(fault(format!(
                        "body {name} is a sector already: one *TIE has both of its faces, whole"
                    )));
                }
                *known = Some((tie.place, keys));
            }
        }
        self.deck.cyclic = cyclic;
        Ok(())
    }

    fn ties(&mut self) -> Result<(), Fault> {
        let ties = std::mem::take(&mut self.deck.ties);
        for tie in &ties {
            let slaves = self.faces_of(&tie.slave, tie.place, "TIE")?;
            let masters = self.faces_of(&tie.master, tie.place, "TIE")?;
            let edge = self.edge(&slaves);
            // surfaces that are drawn upon each other are some rounding apart
            let told = tie.tolerance.map(|own| own.max(UPON * edge));
            let tolerance = told.unwrap_or(TIED * edge);
            let faces = self.faces_on(&masters);
            for (body, side) in &slaves {
                let own = BTreeMap::from([(*body, side.clone())]);
                let nodes = self.faces_on(&own).into_iter();
                let nodes: BTreeSet<Index> =
                    nodes.flat_map(|face| self.deck.face_nodes(face)).collect();
                let nodes: Vec<Index> = nodes.into_iter().collect();
                let far = beyond(self.deck, &nodes, &faces, tolerance);
                let mut keys = vec!["tied = true".to_string()];
                if let Some(first) = far.first() {
                    let title = &self.deck.surfaces[&tie.slave].name;
                    let message = format!(
                        "{} of {} nodes of surface {title} are farther than {tolerance:?} from the other one and are not tied, node {} for one",
                        far.len(),
                        nodes.len(),
                        self.deck.numbers[*first as usize]
                    );
                    if far.len() == nodes.len() {
                        return Err(Fault::new(tie.place, "TIE", message));
                    }
                    self.deck.note(tie.place, "TIE", &message);
                    let wanted = format!("{}-free", tie.name);
                    let point = self.point(*body, &far, &wanted, (tie.place, "TIE"))?;
                    keys.push(format!("exclude = [\"{point}\"]"));
                }
                self.between(
                    (&tie.slave, &tie.master),
                    tie.place,
                    Some(&tie.name),
                    [&own, &masters],
                    &keys,
                );
            }
        }
        self.deck.ties = ties;
        Ok(())
    }

    /// A bolt for each pre-tension section.
    fn bolts(&mut self, tightened: &[(Tightening, PreTension)]) -> Result<(), Fault> {
        let steps = self.deck.steps.clone();
        for (tightening, section) in tightened {
            let name = self.names.fresh(&clean(&section.of));
            let mut keys = vec![format!("name = \"{name}\"")];
            for (key, faces) in ["from", "to"].iter().zip(&section.faces) {
                let body = self.bodies.of_element[faces[0].0 as usize];
                let wanted = format!("{}-{key}", section.of);
                let side = self.side(body, faces, &wanted);
                let body = &self.bodies.list[body].name;
                keys.push(format!("{key} = {{ side = \"{body}.{side}\" }}"));
            }
            if let Some(normal) = section.normal {
                keys.push(format!("axis = {}", list(&normal[..self.axes()])));
            }
            for stretch in stretches(&tightening.forces, &steps) {
                keys.push(format!("prestress = {}", stretch.text));
                let until = match steps.get(stretch.until) {
                    Some(next) => format!(", until = {:?}", next.time),
                    None => String::new(),
                };
                let from = steps[stretch.from].time;
                keys.push(format!("tightened = {{ from = {from:?}{until} }}"));
            }
            let lengths = tightening
                .lengths
                .iter()
                .map(|length| length.unwrap_or(0.0));
            if tightening.lengths.iter().any(Option::is_some) {
                let text = quoted(&expression(&lengths.collect::<Vec<_>>(), &steps));
                keys.push(format!("shortening = {text}"));
            }
            self.text.line(section.place, "[[bolt]]");
            keys.iter()
                .for_each(|key| self.text.line(section.place, key));
            self.text.line(section.place, "");
            self.shortenings.push((section.node, name));
        }
        Ok(())
    }

    /// The faces of some sides.
    fn faces_on(&self, sides: &BTreeMap<usize, String>) -> Vec<Face> {
        let known = self.sides.iter();
        let known = known.filter(|((body, _), name)| sides.get(body) == Some(name));
        known.flat_map(|((_, faces), _)| faces).copied().collect()
    }

    /// The mean edge of the faces of some sides.
    fn edge(&self, sides: &BTreeMap<usize, String>) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for face in self.faces_on(sides) {
            let nodes = &self.deck.elements[face.0 as usize].nodes;
            let corners = self.deck.shape(face.0).faces[face.1];
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            for (a, b) in ends.take(if corners.len() == 2 { 1 } else { corners.len() }) {
                let [p, q] = [a, b].map(|k| self.deck.points[nodes[*k] as usize]);
                sum += (0..3).map(|d| (p[d] - q[d]).powi(2)).sum::<f64>().sqrt();
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }
}

/// Refuses a support that begins in a later step with a displacement of its own.
fn late(course: &Course, freedom: u8) -> Result<(), Fault> {
    let there = |step: usize| step > 0 && course.values[step - 1].is_some();
    let begins = (1..course.values.len()).find(|step| {
        let now = course.values[*step].is_some();
        let from = now && !there(*step);
        // what was held where it is cannot get a displacement of its own
        let given = now && there(*step) && course.fixed[*step - 1] && !course.fixed[*step];
        (from && !course.fixed[*step]) || given
    });
    let Some(begins) = begins else {
        return Ok(());
    };
    let message = format!(
        "degree of freedom {freedom} of {} is held from step {} on, by its displacement since the beginning: that is not supported; hold it in the first step, or where it is (FIXED)",
        course.of,
        begins + 1
    );
    Err(Fault::new(course.place, "BOUNDARY", message))
}

fn axis(freedom: u8) -> &'static str {
    ["x", "y", "z"][usize::from(freedom.clamp(1, 3)) - 1]
}

fn list(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    format!("[{}]", values.join(", "))
}

/// a + b x + c y + d z through all values, or `None`: normal equations about the first point, and a check of every value.
fn linear(points: &[[f64; 3]], values: &[f64]) -> Option<[f64; 4]> {
    let largest = values.iter().fold(0.0f64, |s, v| s.max(v.abs()));
    let close = |fit: &[f64; 4]| {
        let misses = points
            .iter()
            .zip(values)
            .map(|(p, v)| fit[0] + fit[1] * p[0] + fit[2] * p[1] + fit[3] * p[2] - v);
        misses.fold(0.0f64, |s, miss| s.max(miss.abs())) <= SAME * largest
    };
    let constant = [values.first().copied().unwrap_or(0.0), 0.0, 0.0, 0.0];
    if close(&constant) {
        return Some(constant);
    }
    let origin = points[0];
    let row = |p: &[f64; 3]| [1.0, p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
    let mut matrix = [[0.0; 5]; 4];
    for (p, v) in points.iter().zip(values) {
        let row = row(p);
        for i in 0..4 {
            (0..4).for_each(|j| matrix[i][j] += row[i] * row[j]);
            matrix[i][4] += row[i] * v;
        }
    }
    let sizes: [f64; 4] = std::array::from_fn(|i| matrix[i][i]);
    for i in 0..4 {
        if matrix[i][i] <= FLAT * sizes[i] {
            // the points have no extent along this axis, or none of its own: no slope
            matrix[i] = [0.0; 5];
            matrix[i][i] = 1.0;
        }
        let pivot = matrix[i][i];
        matrix[i].iter_mut().for_each(|entry| *entry /= pivot);
        let own = matrix[i];
        for (k, other) in matrix.iter_mut().enumerate() {
            if k != i {
                let factor = other[i];
                (0..5).for_each(|j| other[j] -= factor * own[j]);
            }
        }
    }
    let slopes = [matrix[1][4], matrix[2][4], matrix[3][4]];
    let at_origin = matrix[0][4] - (0..3).map(|d| slopes[d] * origin[d]).sum::<f64>();
    let fit = [at_origin, slopes[0], slopes[1], slopes[2]];
    close(&fit).then_some(fit)
}
