//! The second pass: materials, contact, and the steps with what holds and loads the model at the end of each.
//!
//! Loads, supports and temperatures stay until they are changed. OP=NEW of the first card of a keyword in a step takes away all
//! that earlier steps have brought by it. A load that a step names replaces that of earlier steps; named twice in one step, its
//! parts add. Amplitudes and ramps count by their value at the end of a step, or of its increments where contacts have friction and the deck
//! asks for their results; an amplitude of step time ends with its step. All
//! this is as CalculiX has it.

use crate::deck::*;
use crate::error::Fault;
use crate::keywords::{Becomes, entry};
use crate::lines::{Card, Place, Row, folded};
use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};

/// Values over the steps, from one line of the deck.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Course {
    /// The line that brought it, and the name of the set in that line.
    pub place: Place,
    pub of: String,
    pub keyword: String,
    /// One for each step; `None` where it is not there.
    pub values: Vec<Option<f64>>,
    /// Whether it holds what was reached when it came, step by step.
    pub fixed: Vec<bool>,
}

impl Course {
    /// Adds the values of another one.
    pub fn add(&mut self, other: &Self) {
        for (own, other) in self.values.iter_mut().zip(&other.values) {
            *own = match (*own, *other) {
                (Some(own), Some(other)) => Some(own + other),
                (own, other) => own.or(other),
            };
        }
    }
}

/// What a value at a step depends on.
#[derive(Debug, Clone)]
struct Current {
    place: Place,
    of: String,
    parts: Vec<Part>,
    fixed: bool,
    keyword: String,
}

/// A value with its amplitude, and the keyword that brought it.
#[derive(Debug, Clone)]
struct Part {
    value: f64,
    amplitude: Option<String>,
    keyword: String,
}

/// Courses by what they act on.
#[derive(Debug)]
pub(crate) struct Courses<K> {
    now: BTreeMap<K, Current>,
    touched: BTreeSet<K>,
    /// The courses.
    pub all: BTreeMap<K, Course>,
}

impl<K> Default for Courses<K> {
    fn default() -> Self {
        Self {
            now: BTreeMap::new(),
            touched: BTreeSet::new(),
            all: BTreeMap::new(),
        }
    }
}

impl<K: Ord + Clone> Courses<K> {
    /// A value from a line. With `adds` a second one in the same step adds to the first.
    fn give(&mut self, key: K, from: &From<'_>, part: (f64, Option<String>), adds: bool) {
        let part = Part {
            value: part.0,
            amplitude: part.1,
            keyword: from.keyword.to_string(),
        };
        let first = self.touched.insert(key.clone());
        match self.now.get_mut(&key) {
            Some(current) if adds && !first => current.parts.push(part),
            _ => {
                let current = Current {
                    place: from.place,
                    of: from.of.to_string(),
                    parts: vec![part],
                    fixed: from.fixed,
                    keyword: from.keyword.to_string(),
                };
                self.now.insert(key, current);
            }
        }
    }

    /// Takes away what a keyword has brought.
    fn clear(&mut self, keyword: &str) {
        self.now.retain(|_, current| {
            current.parts.retain(|part| part.keyword != keyword);
            !current.parts.is_empty()
        });
        self.touched.retain(|key| self.now.contains_key(key));
    }

    /// The value at the end of the last step, if it was there.
    fn reached(&self, key: &K, steps: usize) -> Option<f64> {
        let values = &self.all.get(key)?.values;
        values.get(steps.checked_sub(1)?).copied().flatten()
    }

    /// Courses of other things: of two that become one the first in order stays, changed by `joins`.
    pub fn rename(&mut self, to: impl Fn(K) -> K, joins: impl Fn(&mut Course, &Course)) {
        let (stay, go): (BTreeMap<_, _>, BTreeMap<_, _>) = std::mem::take(&mut self.all)
            .into_iter()
            .partition(|(key, _)| to(key.clone()) == *key);
        self.all = stay;
        for (key, course) in go {
            match self.all.entry(to(key)) {
                Entry::Occupied(known) => joins(known.into_mut(), &course),
                Entry::Vacant(free) => {
                    free.insert(course);
                }
            }
        }
    }

    /// Writes down the values at the end of a step. What is not named again stays: by an amplitude of total time it goes on, by one of
    /// the step it keeps the value reached, as in CalculiX.
    fn end(&mut self, step: usize, factor: impl Fn(&Option<String>) -> (f64, bool)) {
        for (key, current) in &mut self.now {
            for part in &mut current.parts {
                let (factor, goes_on) = factor(&part.amplitude);
                if !goes_on {
                    (part.value, part.amplitude) = (part.value * factor, None);
                }
            }
            let parts = current.parts.iter();
            let value = parts
                .map(|part| part.value * factor(&part.amplitude).0)
                .sum();
            write(self.all.entry(key.clone()), current, (step, value));
        }
        self.touched.clear();
    }

    /// Writes down the values at a part of a step: straight from those reached before it, `started` steps, to those at its end; amplitudes
    /// have the `factor` of the time. What the step has taken away goes down to zero if it `fades`, else it is gone.
    fn within(
        &mut self,
        (step, started): (usize, usize),
        (share, fades): (f64, bool),
        factor: impl Fn(&str) -> f64,
    ) {
        for (_, course) in self
            .all
            .iter_mut()
            .filter(|(key, _)| fades && !self.now.contains_key(key))
        {
            let before = started
                .checked_sub(1)
                .and_then(|last| *course.values.get(last)?);
            if let Some(before) = before {
                course.give(step, (1.0 - share) * before, false);
            }
        }
        let keys: Vec<K> = self.now.keys().cloned().collect();
        for key in keys {
            let before = self.reached(&key, started).unwrap_or(0.0);
            let current = &self.now[&key];
            let (varying, steady): (Vec<&Part>, Vec<&Part>) =
                (current.parts.iter()).partition(|part| part.amplitude.is_some());
            let end: f64 = steady.iter().map(|part| part.value).sum();
            let own = |part: &&Part| part.value * part.amplitude.as_deref().map_or(1.0, &factor);
            let value = match varying.is_empty() {
                true => before + share * (end - before),
                false => share * end + varying.iter().map(own).sum::<f64>(),
            };
            write(self.all.entry(key), current, (step, value));
        }
    }

    /// Gives all courses a value for each of the steps.
    fn close(&mut self, steps: usize) {
        for course in self.all.values_mut() {
            course.values.resize(steps, None);
            course.fixed.resize(steps, false);
        }
    }
}

/// Writes down the value of a step.
fn write<K: Ord>(course: Entry<'_, K, Course>, current: &Current, (step, value): (usize, f64)) {
    let course = course.or_insert_with(|| Course {
        place: current.place,
        of: current.of.clone(),
        keyword: current.keyword.clone(),
        values: Vec::new(),
        fixed: Vec::new(),
    });
    course.give(step, value, current.fixed);
}

impl Course {
    /// Gives it a value for a step, the last so far.
    fn give(&mut self, step: usize, value: f64, fixed: bool) {
        self.values.resize(step, None);
        self.values.push(Some(value));
        self.fixed.resize(step, false);
        self.fixed.push(fixed);
    }
}

/// Where a value comes from.
struct From<'c> {
    place: Place,
    of: &'c str,
    keyword: &'c str,
    fixed: bool,
}

impl<'c> From<'c> {
    fn row(card: &'c Card, row: &'c Row) -> Self {
        Self {
            place: row.place,
            of: row.field(0),
            keyword: &card.keyword,
            fixed: false,
        }
    }
}

/// What is written of a step.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Request {
    /// `NODE PRINT` and so on; `NODE FILE` for its other name, too.
    pub keyword: String,
    pub set: Option<String>,
    /// Slave and master of *CONTACT PRINT, in capitals.
    pub pair: [Option<String>; 2],
    pub totals: Option<String>,
    /// Names of results in capitals.
    pub quantities: Vec<String>,
    /// Of how many increments one is written, besides the last; `None` where the deck does not say.
    pub frequency: Option<usize>,
}

/// A step, or an increment of one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Step {
    pub place: Place,
    pub nlgeom: bool,
    /// Number of the step, of the increment in it, and of all of them.
    pub number: [usize; 3],
    /// Loads without an amplitude act in full from its beginning.
    pub at_once: bool,
    /// Length of an increment, as *STATIC has it.
    pub increment: f64,
    /// Time at its end, and since its beginning.
    pub time: f64,
    pub period: f64,
    pub requests: Vec<Request>,
}

/// What acts in the steps.
#[derive(Debug, Default)]
pub(crate) struct Acting {
    /// By node and degree of freedom, from 1.
    pub held: Courses<(Index, u8)>,
    pub forces: Courses<(Index, u8)>,
    /// Pressure by face, of *DLOAD and of *DSLOAD.
    pub pressures: Courses<Face>,
    /// Acceleration by element and direction (the bits of a unit vector).
    pub gravity: Courses<(Index, [u64; 3])>,
    pub temperatures: Courses<Index>,
}

/// Reads materials, contacts and steps into a deck.
///
/// Errors: the first mistake, at its line.
pub(crate) fn read(
    deck: &mut Deck,
    cards: &[Card],
    held: &[(Place, Index, u8)],
) -> Result<(), Fault> {
    for (place, node, freedom) in held {
        let number = deck.numbers[*node as usize].to_string();
        let from = From {
            place: *place,
            of: &number,
            keyword: "EQUATION",
            fixed: false,
        };
        deck.acting
            .held
            .give((*node, *freedom), &from, (0.0, None), false);
    }
    let mut reader = Reader {
        deck,
        step: None,
        material: None,
        interaction: None,
        requests: Vec::new(),
        asked: BTreeSet::new(),
        had: BTreeSet::new(),
        statics: false,
        told: BTreeSet::new(),
    };
    for (at, card) in cards.iter().enumerate() {
        reader.card(card, cards.get(at + 1))?;
    }
    if let Some(step) = &reader.step {
        let message = "the step has no *END STEP".to_string();
        return Err(Fault::new(step.place, "STEP", message));
    }
    let count = reader.deck.steps.len();
    if count == 0 {
        let place = cards
            .last()
            .map_or(Place { file: 0, line: 1 }, |card| card.place);
        let message = "the deck has no *STEP: nothing is solved".to_string();
        return Err(Fault {
            place,
            keyword: String::new(),
            message,
        });
    }
    let acting = &mut reader.deck.acting;
    acting.held.close(count);
    acting.forces.close(count);
    acting.pressures.close(count);
    acting.gravity.close(count);
    acting.temperatures.close(count);
    Ok(())
}

/// Most increments of a step.
const MOST_INCREMENTS: f64 = 1e4;

/// Components of unit vectors of one direction differ by this at most.
const SAME_WAY: f64 = 1e-9;

struct Reader<'d> {
    deck: &'d mut Deck,
    step: Option<Step>,
    material: Option<String>,
    interaction: Option<String>,
    /// Requests that stand, and those keywords that this step has replaced.
    requests: Vec<Request>,
    asked: BTreeSet<String>,
    /// Keywords that this step has had: OP=NEW acts on the first card of its keyword alone, as in CalculiX.
    had: BTreeSet<String>,
    statics: bool,
    /// Remarks that were made once and hold for all steps.
    told: BTreeSet<&'static str>,
}

impl Reader<'_> {
    fn card(&mut self, card: &Card, next: Option<&Card>) -> Result<(), Fault> {
        const ALONE: [&str; 8] = [
            "STEP",
            "END STEP",
            "MATERIAL",
            "COUPLING",
            "RIGID BODY",
            "CLEARANCE",
            "CHANGE FRICTION",
            "CHANGE SURFACE BEHAVIOR",
        ];
        if let (true, Some(row)) = (ALONE.contains(&card.keyword.as_str()), card.rows.first()) {
            return Err(card.fault_at(
                row.place,
                "no data belong here: a line with a keyword is missing above",
            ));
        }
        if let Some((_, _, Becomes::Ignored(why))) = entry(&card.keyword) {
            self.deck
                .note(card.place, &card.keyword, &format!("passed over, {why}"));
            return Ok(());
        }
        match card.keyword.as_str() {
            "HEADING" => {
                let lines = card.rows.iter().map(|row| row.fields.join(", "));
                self.deck.headings.extend(lines);
                Ok(())
            }
            "MATERIAL" => self.material(card),
            "ELASTIC" | "DENSITY" | "EXPANSION" => self.property(card),
            "SOLID SECTION" => self.section(card),
            "SURFACE INTERACTION" => self.interaction(card),
            "SURFACE BEHAVIOR" => self.behaviour(card),
            "FRICTION" => self.friction(card),
            "CHANGE FRICTION" | "CHANGE SURFACE BEHAVIOR" => {
                let name = self.named(card, "INTERACTION")?;
                find(
                    card,
                    card.place,
                    "INTERACTION",
                    &name,
                    &self.deck.interactions,
                )?;
                self.interaction = Some(folded(&name));
                Ok(())
            }
            "CONTACT PAIR" => self.pair(card),
            "CLEARANCE" => self.clearance(card),
            "TIE" => self.tie(card),
            "CYCLIC SYMMETRY MODEL" => self.cyclic(card),
            "COUPLING" => self.coupling(card, next),
            "KINEMATIC" | "DISTRIBUTING" => self.motion(card),
            "RIGID BODY" => self.rigid(card),
            "INITIAL CONDITIONS" => self.initial(card),
            "AMPLITUDE" => self.amplitude(card),
            "STEP" => self.begin(card),
            "STATIC" => self.statics(card),
            "END STEP" => self.end(card),
            "BOUNDARY" => self.boundary(card),
            "CLOAD" => self.cload(card),
            "DLOAD" => self.dload(card),
            "DSLOAD" => self.dsload(card),
            "TEMPERATURE" => self.temperature(card),
            "MODEL CHANGE" => self.change(card),
            "NODE PRINT" | "EL PRINT" | "CONTACT PRINT" | "NODE FILE" | "NODE OUTPUT"
            | "EL FILE" | "ELEMENT OUTPUT" | "CONTACT FILE" | "CONTACT OUTPUT" => {
                self.request(card)
            }
            _ => Ok(()),
        }
    }

    fn named(&self, card: &Card, parameter: &str) -> Result<String, Fault> {
        let name = card.get(parameter).filter(|name| !name.is_empty());
        name.map(str::to_string)
            .ok_or_else(|| card.fault(format!("{parameter}=NAME is missing")))
    }

    fn one_row<'c>(&self, card: &'c Card) -> Result<&'c Row, Fault> {
        match &card.rows[..] {
            [row] => Ok(row),
            [] => Err(card.fault("the line of data is missing")),
            [_, second, ..] => Err(card.fault_at(second.place, "one line of data is enough: properties that depend on temperature are not supported")),
        }
    }

    fn material(&mut self, card: &Card) -> Result<(), Fault> {
        let name = self.named(card, "NAME")?;
        let material = Material {
            name: name.clone(),
            place: card.place,
            ..Material::default()
        };
        if self
            .deck
            .materials
            .insert(folded(&name), material)
            .is_some()
        {
            return Err(card.fault(format!("there are two materials {name}")));
        }
        self.material = Some(folded(&name));
        Ok(())
    }

    fn property(&mut self, card: &Card) -> Result<(), Fault> {
        let name = self
            .material
            .clone()
            .ok_or_else(|| card.fault("it belongs below *MATERIAL"))?;
        let isotropic = card
            .word("TYPE")
            .is_none_or(|kind| kind == "ISO" || kind == "ISOTROPIC");
        if !isotropic {
            return Err(card.fault("materials are isotropic: TYPE=ISO"));
        }
        let row = self.one_row(card)?;
        let material = self.deck.materials.entry(name).or_default();
        match card.keyword.as_str() {
            "ELASTIC" => {
                let young = row.number(card, 0, "Young's modulus")?;
                let poisson = row.number(card, 1, "Poisson's ratio")?;
                if young <= 0.0 || !(poisson > -1.0 && poisson < 0.5) {
                    let message = format!(
                        "E must be positive and ν in (-1, 0.5), found {young:?} and {poisson:?}"
                    );
                    return Err(card.fault_at(row.place, message));
                }
                material.elastic = Some([young, poisson]);
            }
            "DENSITY" => material.density = Some(row.number(card, 0, "the density")?),
            _ => material.expansion = Some(row.number(card, 0, "the coefficient of expansion")?),
        }
        Ok(())
    }

    fn section(&mut self, card: &Card) -> Result<(), Fault> {
        let set = self.named(card, "ELSET")?;
        let material = self.named(card, "MATERIAL")?;
        find(card, card.place, "ELSET", &set, &self.deck.element_sets)?;
        let row = card.rows.first();
        let thickness = row.filter(|row| !row.field(0).is_empty());
        let thickness = thickness
            .map(|row| row.number(card, 0, "the thickness"))
            .transpose()?;
        if let (Some(value), Some(row)) = (thickness.filter(|t| *t <= 0.0), row) {
            return Err(card.fault_at(
                row.place,
                format!("the thickness must be positive, found {value:?}"),
            ));
        }
        self.deck.sections.push(Section {
            set,
            material,
            thickness,
            place: card.place,
        });
        Ok(())
    }

    fn interaction(&mut self, card: &Card) -> Result<(), Fault> {
        let name = self.named(card, "NAME")?;
        if let Some(row) = card.rows.first() {
            let message = "the thickness of the interface is passed over";
            self.deck.note(row.place, &card.keyword, message);
        }
        let interaction = Interaction::default();
        if self
            .deck
            .interactions
            .insert(folded(&name), interaction)
            .is_some()
        {
            return Err(card.fault(format!("there are two interactions {name}")));
        }
        self.interaction = Some(folded(&name));
        Ok(())
    }

    fn current(&mut self, card: &Card) -> Result<&mut Interaction, Fault> {
        let name = self.interaction.clone();
        let name = name.ok_or_else(|| card.fault("it belongs below *SURFACE INTERACTION"))?;
        Ok(self.deck.interactions.entry(name).or_default())
    }

    fn behaviour(&mut self, card: &Card) -> Result<(), Fault> {
        let word = card
            .word("PRESSURE-OVERCLOSURE")
            .unwrap_or("HARD".to_string());
        let tied = match word.as_str() {
            "HARD" => false,
            "LINEAR" | "EXPONENTIAL" | "TABULAR" => {
                self.deck.note(
                    card.place,
                    &card.keyword,
                    &format!("{word} becomes hard contact, without a slope"),
                );
                false
            }
            "TIED" => true,
            _ => return Err(card.fault(format!(
                "PRESSURE-OVERCLOSURE={word}: known are HARD, LINEAR, EXPONENTIAL, TABULAR, TIED"
            ))),
        };
        let step = self.deck.steps.len();
        let own = &mut self.current(card)?.tied;
        let before = own.last().copied().unwrap_or(tied);
        own.resize(step, before);
        own.push(tied);
        Ok(())
    }

    fn friction(&mut self, card: &Card) -> Result<(), Fault> {
        let row = self.one_row(card)?;
        let value = row.number(card, 0, "the coefficient of friction")?;
        if value < 0.0 {
            return Err(card.fault_at(
                row.place,
                format!("the coefficient of friction must not be negative, found {value:?}"),
            ));
        }
        if !row.field(1).is_empty() || card.get("SLIP TOLERANCE").is_some() {
            self.deck.note(
                card.place,
                &card.keyword,
                "the slope of sticking is passed over: what sticks does not slip",
            );
        }
        let step = self.deck.steps.len();
        let friction = &mut self.current(card)?.friction;
        let before = friction.last().copied().unwrap_or(value);
        friction.resize(step, before);
        friction.push(value);
        Ok(())
    }

    fn surface(&self, card: &Card, row: &Row, at: usize) -> Result<String, Fault> {
        find(
            card,
            row.place,
            "surface",
            row.field(at),
            &self.deck.surfaces,
        )?;
        Ok(folded(row.field(at)))
    }

    fn pair(&mut self, card: &Card) -> Result<(), Fault> {
        let interaction = folded(&self.named(card, "INTERACTION")?);
        let adjust = card
            .get("ADJUST")
            .map(|text| self.adjust(card, text))
            .transpose()?;
        if let Some(word) = card.word("TYPE") {
            const TYPES: [&str; 6] = [
                "NODETOSURFACE",
                "SURFACETOSURFACE",
                "MORTAR",
                "LINMORTAR",
                "PGLINMORTAR",
                "MASSLESS",
            ];
            if !TYPES.contains(&word.as_str()) {
                return Err(card.fault(format!(
                    "TYPE={word}: known are NODE TO SURFACE, SURFACE TO SURFACE, MORTAR"
                )));
            }
        }
        if card.rows.is_empty() {
            return Err(card.fault("the line with the two surfaces is missing"));
        }
        for row in &card.rows {
            let (slave, master) = (self.surface(card, row, 0)?, self.surface(card, row, 1)?);
            if self.deck.surfaces[&master].nodes.is_some() {
                return Err(
                    card.fault_at(row.place, "the second surface must be one of element faces")
                );
            }
            self.deck.pairs.push(Pair {
                place: row.place,
                slave,
                master,
                interaction: interaction.clone(),
                adjust: adjust.clone(),
                clearance: None,
                present: Vec::new(),
            });
        }
        Ok(())
    }

    fn adjust(&self, card: &Card, text: &str) -> Result<Adjust, Fault> {
        match crate::lines::number(text) {
            Some(value) if value >= 0.0 => Ok(Adjust::UpTo(value)),
            Some(_) => Err(card.fault(format!("ADJUST={text}: a length is not negative"))),
            None => Ok(Adjust::Nodes(
                self.deck.node_set(card, card.place, text)?.members.clone(),
            )),
        }
    }

    fn clearance(&mut self, card: &Card) -> Result<(), Fault> {
        let sides =
            ["MASTER", "SLAVE"].map(|side| self.named(card, side).map(|name| folded(&name)));
        let [master, slave] = sides;
        let (master, slave) = (master?, slave?);
        let text = self.named(card, "VALUE")?;
        let value = crate::lines::number(&text)
            .ok_or_else(|| card.fault(format!("VALUE={text} is no number")))?;
        let mut pairs = self.deck.pairs.iter_mut();
        match pairs.find(|pair| pair.slave == slave && pair.master == master) {
            Some(pair) => pair.clearance = Some(value),
            None => return Err(card.fault("there is no such *CONTACT PAIR above")),
        }
        Ok(())
    }

    fn tie(&mut self, card: &Card) -> Result<(), Fault> {
        let name = card.get("NAME").unwrap_or("tie").to_string();
        for word in ["MULTISTAGE", "FLUID PERIODIC"] {
            if card.get(word).is_some() {
                return Err(card.fault(format!("{word} is not supported")));
            }
        }
        if card
            .word("ADJUST")
            .is_some_and(|word| word != "YES" && word != "NO")
        {
            return Err(card.fault("ADJUST is YES or NO"));
        }
        let tolerance = card.get("POSITION TOLERANCE");
        let tolerance = tolerance.map(|text| {
            crate::lines::number(text)
                .ok_or_else(|| card.fault(format!("POSITION TOLERANCE={text} is no number")))
        });
        let tolerance = tolerance.transpose()?;
        for row in &card.rows {
            let (slave, master) = (self.surface(card, row, 0)?, self.surface(card, row, 1)?);
            let tie = Tie {
                place: row.place,
                name: name.clone(),
                slave,
                master,
                tolerance,
            };
            match card.get("CYCLIC SYMMETRY") {
                Some(_) => self.deck.cyclic.push(Cyclic { tie, model: None }),
                None => self.deck.ties.push(tie),
            }
        }
        match card.rows.is_empty() {
            true => Err(card.fault("the line with the two surfaces is missing")),
            false => Ok(()),
        }
    }

    /// Gives a cyclic tie its number of sectors and its axis.
    fn cyclic(&mut self, card: &Card) -> Result<(), Fault> {
        let text = self.named(card, "N")?;
        let sectors = text.parse::<u64>().ok().filter(|sectors| *sectors > 1);
        let Some(sectors) = sectors else {
            return Err(card.fault(format!("N={text} is no number of sectors: 2 or more")));
        };
        let Some(row) = card.rows.first() else {
            return Err(card.fault("the line with two points of the axis is missing"));
        };
        let mut axis = [[0.0; 3]; 2];
        for (k, value) in axis.as_flattened_mut().iter_mut().enumerate() {
            *value = row.number(card, k, "a coordinate of the axis")?;
        }
        if axis[0] == axis[1] {
            return Err(card.fault_at(row.place, "the two points of the axis are the same"));
        }
        let tie = card.get("TIE").map(folded);
        let meant = |cyclic: &&mut Cyclic| match &tie {
            Some(name) => folded(&cyclic.tie.name) == *name,
            None => cyclic.model.is_none(),
        };
        let mut found = 0;
        for cyclic in self.deck.cyclic.iter_mut().filter(meant) {
            cyclic.model = Some((sectors, axis));
            found += 1;
        }
        match found {
            0 => Err(card.fault("there is no *TIE, CYCLIC SYMMETRY of this name above")),
            _ => Ok(()),
        }
    }

    fn reference(&self, card: &Card, parameter: &str) -> Result<Index, Fault> {
        let text = self.named(card, parameter)?;
        match text.parse::<u64>() {
            Ok(number) => self.deck.node(card, card.place, number),
            Err(_) => match &self.deck.node_set(card, card.place, &text)?.members[..] {
                [node] => Ok(*node),
                members => Err(card.fault(format!(
                    "{parameter}={text} has {} nodes, one is needed",
                    members.len()
                ))),
            },
        }
    }

    fn coupling(&mut self, card: &Card, next: Option<&Card>) -> Result<(), Fault> {
        let surface = self.named(card, "SURFACE")?;
        let found = find(card, card.place, "surface", &surface, &self.deck.surfaces)?;
        let nodes = match &found.nodes {
            Some(nodes) => nodes.clone(),
            None => found
                .faces
                .iter()
                .flat_map(|face| self.deck.face_nodes(*face))
                .collect(),
        };
        if card.get("ORIENTATION").is_some() {
            return Err(card.fault("ORIENTATION: degrees of freedom are along the global axes"));
        }
        if !next.is_some_and(|next| ["KINEMATIC", "DISTRIBUTING"].contains(&next.keyword.as_str()))
        {
            return Err(card.fault("*KINEMATIC or *DISTRIBUTING must follow"));
        }
        let reference = self.reference(card, "REF NODE")?;
        self.deck.couplings.push(Coupling {
            place: card.place,
            keyword: card.keyword.clone(),
            name: card.get("CONSTRAINT NAME").unwrap_or(&surface).to_string(),
            reference,
            rotation: None,
            nodes,
            motion: None,
            of: surface,
        });
        Ok(())
    }

    fn motion(&mut self, card: &Card) -> Result<(), Fault> {
        let motion = if card.keyword == "KINEMATIC" {
            Motion::Rigid
        } else {
            Motion::Average
        };
        let axes = self.deck.axes() as u8;
        let mut coupled = BTreeSet::new();
        for row in &card.rows {
            let first = row.freedom(card, 0)?;
            let last = match row.field(1).is_empty() {
                true => first,
                false => row.freedom(card, 1)?,
            };
            coupled.extend(first..=last);
        }
        let whole = card.rows.is_empty() || (1..=axes).all(|freedom| coupled.contains(&freedom));
        if !whole {
            return Err(card.fault(format!(
                "all of the degrees of freedom 1 to {axes} must be coupled"
            )));
        }
        match self
            .deck
            .couplings
            .last_mut()
            .filter(|coupling| coupling.motion.is_none())
        {
            Some(coupling) => coupling.motion = Some(motion),
            None => return Err(card.fault("it belongs below *COUPLING")),
        }
        Ok(())
    }

    fn rigid(&mut self, card: &Card) -> Result<(), Fault> {
        let (of, nodes) = match (card.get("NSET"), card.get("ELSET")) {
            (Some(name), None) => (
                name.to_string(),
                self.deck.node_set(card, card.place, name)?.members.clone(),
            ),
            (None, Some(name)) => {
                let set = find(card, card.place, "ELSET", name, &self.deck.element_sets)?;
                let nodes = set
                    .members
                    .iter()
                    .flat_map(|e| self.deck.elements[*e as usize].nodes.clone());
                let nodes: BTreeSet<Index> = nodes.collect();
                (name.to_string(), nodes.into_iter().collect())
            }
            _ => return Err(card.fault("NSET or ELSET is needed, and one of the two")),
        };
        let rotation = card
            .get("ROT NODE")
            .map(|_| self.reference(card, "ROT NODE"))
            .transpose()?;
        let reference = self.reference(card, "REF NODE")?;
        self.deck.couplings.push(Coupling {
            place: card.place,
            keyword: card.keyword.clone(),
            name: of.clone(),
            reference,
            rotation,
            nodes,
            motion: Some(Motion::Rigid),
            of,
        });
        Ok(())
    }

    fn initial(&mut self, card: &Card) -> Result<(), Fault> {
        let word = card.word("TYPE").unwrap_or_default();
        if word != "TEMPERATURE" {
            return Err(card.fault(format!(
                "TYPE={word} is not supported: known is TEMPERATURE"
            )));
        }
        if card.get("USER").is_some() {
            return Err(card.fault("USER: temperatures are given by nodes"));
        }
        for row in &card.rows {
            let value = row.number(card, 1, "the temperature")?;
            for node in self.deck.nodes_of(card, row, 0)? {
                self.deck.initial.insert(node, value);
            }
        }
        Ok(())
    }

    fn amplitude(&mut self, card: &Card) -> Result<(), Fault> {
        let name = self.named(card, "NAME")?;
        let tabular = card.word("DEFINITION").is_none_or(|word| word == "TABULAR");
        let relative = card.word("VALUE").is_none_or(|word| word == "RELATIVE");
        if !tabular
            || !relative
            || ["SMOOTH", "SHIFTX", "SHIFTY"]
                .iter()
                .any(|word| card.get(word).is_some())
        {
            return Err(card.fault("amplitudes are tables of time and factor"));
        }
        let total = card.word("TIME").is_some_and(|word| word == "TOTALTIME");
        let mut points: Vec<[f64; 2]> = Vec::new();
        for row in &card.rows {
            for pair in 0..row.fields.len().div_ceil(2) {
                let point = [
                    row.number(card, 2 * pair, "a time")?,
                    row.number(card, 2 * pair + 1, "a factor")?,
                ];
                if points.last().is_some_and(|last| last[0] >= point[0]) {
                    return Err(card.fault_at(
                        row.place,
                        format!("times must ascend, {:?} does not", point[0]),
                    ));
                }
                points.push(point);
            }
        }
        if points.is_empty() {
            return Err(card.fault("the table is empty"));
        }
        let amplitude = Amplitude { points, total };
        match self.deck.amplitudes.insert(folded(&name), amplitude) {
            None => Ok(()),
            Some(_) => Err(card.fault(format!("there are two amplitudes {name}"))),
        }
    }

    fn begin(&mut self, card: &Card) -> Result<(), Fault> {
        if let Some(step) = &self.step {
            return Err(card.fault(format!(
                "the step of line {} has no *END STEP",
                step.place.line
            )));
        }
        let wanted = card.get("NLGEOM").map(folded);
        let nlgeom = wanted.is_some_and(|word| !["NO", "OFF"].contains(&word.as_str()));
        if card.get("NLGEOM").is_some() {
            self.tell_once(
                card,
                match nlgeom {
                    true => "NLGEOM is not supported yet, motion is taken as small",
                    false => "NLGEOM is passed over: motion is small",
                },
            );
        }
        let at_once = match card.word("AMPLITUDE").as_deref() {
            None | Some("RAMP") => false,
            Some("STEP") => true,
            Some(other) => {
                return Err(card.fault(format!("AMPLITUDE={other}: known are RAMP and STEP")));
            }
        };
        self.step = Some(Step {
            place: card.place,
            nlgeom,
            at_once,
            period: 1.0,
            ..Step::default()
        });
        self.asked.clear();
        self.had.clear();
        self.statics = false;
        Ok(())
    }

    fn tell_once(&mut self, card: &Card, message: &'static str) {
        if self.told.insert(message) {
            self.deck.note(card.place, &card.keyword, message);
        }
    }

    fn statics(&mut self, card: &Card) -> Result<(), Fault> {
        for word in ["TIME RESET", "TOTAL TIME AT START"] {
            if card.get(word).is_some() {
                return Err(card.fault(format!(
                    "{word} is not supported: time goes on from step to step"
                )));
            }
        }
        if let [_, second, ..] = &card.rows[..] {
            return Err(card.fault_at(
                second.place,
                "one line of data is enough: increment, and time of the step",
            ));
        }
        let [increment, period] = match card.rows.first() {
            Some(row) => [row.number_or(card, 0, 1.0)?, row.number_or(card, 1, 1.0)?],
            None => [1.0; 2],
        };
        self.statics = true;
        if period <= 0.0 {
            return Err(card.fault(format!(
                "the time of the step must be positive, found {period:?}"
            )));
        }
        match &mut self.step {
            Some(step) => (step.increment, step.period) = (increment, period),
            None => return Err(card.fault("it belongs within a *STEP")),
        }
        Ok(())
    }

    fn end(&mut self, card: &Card) -> Result<(), Fault> {
        let Some(mut step) = self.step.take() else {
            return Err(card.fault("there is no *STEP above"));
        };
        if !self.statics {
            let (place, keyword) = (step.place, "STEP".to_string());
            let message = "the step has no *STATIC: nothing says what is solved".to_string();
            return Err(Fault {
                place,
                keyword,
                message,
            });
        }
        let count = self.increments(&step);
        let passed = "increments are passed over: there is one answer, at the end of the step, unless contacts have friction, results are asked for by FREQUENCY, and no temperature changes";
        if count == 1 && step.increment < step.period && self.told.insert(passed) {
            self.deck.note(step.place, "STATIC", passed);
        }
        let number = self.deck.steps.last().map_or(1, |last| last.number[0] + 1);
        let (started, before) = (self.deck.steps.len(), self.deck.steps.last());
        let before = before.map_or(0.0, |step| step.time);
        let whole = step.period;
        step.period /= count as f64;
        for increment in 1..=count {
            let share = increment as f64 / count as f64;
            step.number = [number, increment, count];
            step.time = match increment == count {
                true => before + whole,
                false => before + share * whole,
            };
            let asked = |request: &&Request| {
                let each = request.frequency.unwrap_or(usize::MAX);
                increment == count || increment % each == 0
            };
            step.requests = self.requests.iter().filter(asked).cloned().collect();
            self.write_down(&step, (started, share), whole);
        }
        Ok(())
    }

    /// Into how many increments a step is divided: where its contacts have friction and the deck asks for results of increments.
    fn increments(&self, step: &Step) -> usize {
        let frictions = self.deck.interactions.values();
        let mut frictions = frictions.filter_map(|own| own.friction.last());
        let mut asked = self.requests.iter().filter_map(|request| request.frequency);
        let heats = !self.deck.acting.temperatures.touched.is_empty();
        let divided = frictions.any(|value| *value > 0.0) && asked.next().is_some() && !heats;
        match divided && step.increment > 0.0 {
            true => (step.period / step.increment)
                .round()
                .clamp(1.0, MOST_INCREMENTS) as usize,
            false => 1,
        }
    }

    /// Writes down what acts at the end of a step, or at a part of it.
    fn write_down(&mut self, step: &Step, (started, share): (usize, f64), whole: f64) {
        let deck = &mut *self.deck;
        let (amplitudes, at) = (&deck.amplitudes, deck.steps.len());
        let factor = |name: &str| {
            amplitudes
                .get(name)
                .map_or((1.0, false), |amplitude| match amplitude.total {
                    true => (amplitude.at(step.time), true),
                    false => (amplitude.at(share * whole), false),
                })
        };
        let acting = &mut deck.acting;
        if step.number[1] == step.number[2] {
            let factor = |name: &Option<String>| name.as_deref().map_or((1.0, false), factor);
            acting.held.end(at, factor);
            acting.forces.end(at, factor);
            acting.pressures.end(at, factor);
            acting.gravity.end(at, factor);
            acting.temperatures.end(at, factor);
        } else {
            let (places, factor) = ((at, started), |name: &str| factor(name).0);
            let share = if step.at_once { 1.0 } else { share };
            acting.held.within(places, (share, false), factor);
            acting.forces.within(places, (share, true), factor);
            acting.pressures.within(places, (share, true), factor);
            acting.gravity.within(places, (share, true), factor);
            acting.temperatures.within(places, (1.0, false), factor);
        }
        for pair in &mut deck.pairs {
            let last = pair.present.last().copied().unwrap_or(true);
            pair.present.resize(at + 1, last);
        }
        for interaction in deck.interactions.values_mut() {
            let last = interaction.friction.last().copied().unwrap_or(0.0);
            interaction.friction.resize(at + 1, last);
            let last = interaction.tied.last().copied().unwrap_or(false);
            interaction.tied.resize(at + 1, last);
        }
        deck.steps.push(step.clone());
    }

    /// The amplitude of a card, and whether it takes away what is there.
    fn given(&mut self, card: &Card) -> Result<(Option<String>, bool), Fault> {
        for (word, why) in [
            ("TIME DELAY", "amplitudes begin with the step"),
            ("LOAD CASE", "there is one load case"),
        ] {
            if card.get(word).is_some() {
                return Err(card.fault(format!("{word}: {why}")));
            }
        }
        let new = match card.word("OP").as_deref() {
            None | Some("MOD") => false,
            Some("NEW") => true,
            Some(other) => return Err(card.fault(format!("OP={other}: known are MOD and NEW"))),
        };
        let amplitude = card.get("AMPLITUDE").map(folded);
        if let Some(name) = &amplitude {
            find(card, card.place, "amplitude", name, &self.deck.amplitudes)?;
        }
        if self.step.is_none() && card.keyword != "BOUNDARY" {
            return Err(card.fault("loads belong within a *STEP"));
        }
        let first = self.had.insert(card.keyword.clone());
        Ok((amplitude, new && first))
    }

    fn boundary(&mut self, card: &Card) -> Result<(), Fault> {
        let (amplitude, new) = self.given(card)?;
        if card.word("TYPE").is_some_and(|word| word != "DISPLACEMENT") {
            return Err(card.fault("displacements are prescribed: TYPE=DISPLACEMENT"));
        }
        if new {
            self.deck.acting.held.clear("BOUNDARY");
        }
        let fixed = card.get("FIXED").is_some();
        let steps = self.deck.steps.len();
        for row in &card.rows {
            let (first, last) = self.freedoms(card, row)?;
            let value = row.number_or(card, 3, 0.0)?;
            for node in self.deck.nodes_of(card, row, 0)? {
                for freedom in first..=last {
                    let held = &mut self.deck.acting.held;
                    let key = (node, freedom);
                    let reached = held.reached(&key, steps);
                    let part = match fixed {
                        true => (reached.unwrap_or(0.0), None),
                        false => (value, amplitude.clone()),
                    };
                    let from = From {
                        fixed: fixed && reached.is_none(),
                        ..From::row(card, row)
                    };
                    held.give(key, &from, part, false);
                }
            }
        }
        Ok(())
    }

    /// The degrees of freedom of a line of *BOUNDARY.
    fn freedoms(&self, card: &Card, row: &Row) -> Result<(u8, u8), Fault> {
        let word = folded(row.field(1));
        match word.as_str() {
            "ENCASTRE" | "PINNED" => return Ok((1, 3)),
            "XSYMM" => return Ok((1, 1)),
            "YSYMM" => return Ok((2, 2)),
            "ZSYMM" => return Ok((3, 3)),
            _ => {}
        }
        let first = row.freedom(card, 1)?;
        let last = match row.field(2).is_empty() {
            true => first,
            false => row.freedom(card, 2)?,
        };
        match first <= last {
            true => Ok((first, last)),
            false => Err(card.fault_at(
                row.place,
                format!("degrees of freedom {first} to {last}: the first is the smaller"),
            )),
        }
    }

    fn cload(&mut self, card: &Card) -> Result<(), Fault> {
        let (amplitude, new) = self.given(card)?;
        if new {
            self.deck.acting.forces.clear("CLOAD");
        }
        let copies: BTreeSet<Index> = self.deck.copies.values().copied().collect();
        for row in &card.rows {
            let freedom = row.freedom(card, 1)?;
            let value = row.number(card, 2, "the force")?;
            let nodes = self.deck.nodes_of(card, row, 0)?.into_iter();
            // of a node that is cut in two one bears the force
            for node in nodes.filter(|node| !copies.contains(node)) {
                let from = From::row(card, row);
                self.deck.acting.forces.give(
                    (node, freedom),
                    &from,
                    (value, amplitude.clone()),
                    true,
                );
            }
        }
        Ok(())
    }

    fn dload(&mut self, card: &Card) -> Result<(), Fault> {
        let (amplitude, new) = self.given(card)?;
        if new {
            self.deck.acting.pressures.clear("DLOAD");
            self.deck.acting.gravity.clear("DLOAD");
        }
        for row in &card.rows {
            let label = folded(row.field(1));
            let value = row.number(card, 2, "the load")?;
            let from = From::row(card, row);
            if label == "GRAV" {
                self.gravity(card, row, value, &amplitude)?;
                continue;
            }
            let number = label
                .strip_prefix('P')
                .and_then(|text| text.parse::<usize>().ok());
            let Some(face) = number.filter(|number| *number > 0) else {
                let message = format!("`{label}` is not supported: known are P1, P2, .. and GRAV");
                return Err(card.fault_at(row.place, message));
            };
            for element in self.deck.elements_of(card, row)? {
                let face = self.deck.face(card, row.place, element, face - 1)?;
                self.deck
                    .acting
                    .pressures
                    .give(face, &from, (value, amplitude.clone()), true);
            }
        }
        Ok(())
    }

    fn gravity(
        &mut self,
        card: &Card,
        row: &Row,
        value: f64,
        amplitude: &Option<String>,
    ) -> Result<(), Fault> {
        let mut way = [0.0; 3];
        for (d, x) in way.iter_mut().enumerate() {
            *x = row.number_or(card, 3 + d, 0.0)?;
        }
        let size = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        if size == 0.0 {
            return Err(card.fault_at(row.place, "GRAV needs a direction in fields 4 to 6"));
        }
        let way = way.map(|x| x / size);
        let from = From::row(card, row);
        for element in self.deck.elements_of(card, row)? {
            let part = (value, amplitude.clone());
            let gravity = &mut self.deck.acting.gravity;
            // a direction that is known but for rounding is that one
            let own = gravity
                .now
                .range((element, [0; 3])..=(element, [u64::MAX; 3]));
            let is_known = |known: &[u64; 3]| {
                let off = known
                    .iter()
                    .zip(way)
                    .map(|(bits, x)| f64::from_bits(*bits) - x);
                off.into_iter().all(|off| off.abs() <= SAME_WAY)
            };
            let known = own.map(|(key, _)| key.1).find(is_known);
            let way = known.unwrap_or(way.map(f64::to_bits));
            gravity.give((element, way), &from, part, true);
        }
        Ok(())
    }

    fn dsload(&mut self, card: &Card) -> Result<(), Fault> {
        let (amplitude, new) = self.given(card)?;
        if new {
            self.deck.acting.pressures.clear("DSLOAD");
        }
        for row in &card.rows {
            let name = self.surface(card, row, 0)?;
            if self.deck.surfaces[&name].nodes.is_some() {
                return Err(card.fault_at(row.place, "a pressure needs a surface of element faces"));
            }
            let label = folded(row.field(1));
            if label != "P" {
                return Err(
                    card.fault_at(row.place, format!("`{label}` is not supported: known is P"))
                );
            }
            let value = row.number(card, 2, "the pressure")?;
            let from = From::row(card, row);
            for face in self.deck.surfaces[&name].faces.clone() {
                let part = (value, amplitude.clone());
                self.deck.acting.pressures.give(face, &from, part, true);
            }
        }
        Ok(())
    }

    fn temperature(&mut self, card: &Card) -> Result<(), Fault> {
        let (amplitude, new) = self.given(card)?;
        if new {
            self.deck.acting.temperatures.clear("TEMPERATURE");
        }
        for row in &card.rows {
            let value = row.number(card, 1, "the temperature")?;
            for node in self.deck.nodes_of(card, row, 0)? {
                let from = From::row(card, row);
                self.deck
                    .acting
                    .temperatures
                    .give(node, &from, (value, amplitude.clone()), false);
            }
        }
        Ok(())
    }

    fn change(&mut self, card: &Card) -> Result<(), Fault> {
        let step = self.deck.steps.len();
        if self.step.is_none() {
            return Err(card.fault("it belongs within a *STEP"));
        }
        let there = match (card.get("ADD"), card.get("REMOVE")) {
            (Some(_), None) => true,
            (None, Some(_)) => false,
            _ => return Err(card.fault("ADD or REMOVE is needed")),
        };
        if card.word("TYPE").is_none_or(|word| word != "CONTACTPAIR") {
            return Err(card.fault("TYPE=CONTACT PAIR is supported; elements that come and go are `active` of a body in a case"));
        }
        for row in &card.rows {
            let (slave, master) = (self.surface(card, row, 0)?, self.surface(card, row, 1)?);
            let mut pairs = self.deck.pairs.iter_mut();
            let Some(pair) = pairs.find(|pair| pair.slave == slave && pair.master == master) else {
                return Err(card.fault_at(row.place, "there is no such *CONTACT PAIR"));
            };
            let before = pair.present.last().copied().unwrap_or(true);
            pair.present.resize(step, before);
            pair.present.push(there);
        }
        Ok(())
    }

    fn request(&mut self, card: &Card) -> Result<(), Fault> {
        let keyword = match card.keyword.as_str() {
            "NODE OUTPUT" => "NODE FILE",
            "ELEMENT OUTPUT" => "EL FILE",
            "CONTACT OUTPUT" => "CONTACT FILE",
            other => other,
        };
        if self.step.is_none() {
            return Err(card.fault("it belongs within a *STEP"));
        }
        let set = card.get("NSET").or(card.get("ELSET"));
        self.check_set(card, keyword, set)?;
        let fields = card.rows.iter().flat_map(|row| &row.fields);
        let fields = fields.filter(|field| !field.is_empty());
        let quantities: Vec<String> = fields.map(|field| folded(field)).collect();
        let written: &[&str] = match keyword {
            "NODE PRINT" | "NODE FILE" => &["U", "RF"],
            "EL PRINT" | "EL FILE" => &["S", "E"],
            "CONTACT PRINT" => &["CDIS", "CDISP", "CSTR", "CSTRESS", "CF", "CFN", "CFS"],
            _ => &["CDIS", "CDISP", "CSTR", "CSTRESS"],
        };
        // what only says that no error estimate is wanted
        let left = quantities
            .iter()
            .filter(|word| !written.contains(&word.as_str()) && *word != "NOE");
        let left: Vec<&str> = left.map(String::as_str).collect();
        if !left.is_empty() {
            self.deck.note(
                card.place,
                &card.keyword,
                &format!("{} is not written", left.join(", ")),
            );
        }
        if keyword.ends_with("FILE") && set.is_some() {
            self.deck.note(
                card.place,
                &card.keyword,
                "all nodes are written, not those of a set alone",
            );
        }
        let pair = [card.get("SLAVE"), card.get("MASTER")].map(|name| name.map(folded));
        for name in pair.iter().flatten() {
            find(card, card.place, "surface", name, &self.deck.surfaces)?;
        }
        if let [Some(slave), Some(master)] = &pair
            && !self
                .deck
                .pairs
                .iter()
                .any(|own| own.slave == *slave && own.master == *master)
        {
            return Err(card.fault(format!("there is no *CONTACT PAIR {slave}, {master} above")));
        }
        // the first request of a kind in a step takes the place of those before
        if self.asked.insert(keyword.to_string()) {
            self.requests.retain(|request| request.keyword != keyword);
        }
        let frequency = match card.word("FREQUENCY").as_deref() {
            None => None,
            Some(word) => match word.parse::<usize>() {
                Ok(0) => return Ok(()),
                Ok(each) => Some(each),
                Err(_) => {
                    let message = format!("FREQUENCY={word}: a number of increments is expected");
                    return Err(card.fault(message));
                }
            },
        };
        self.requests.push(Request {
            keyword: keyword.to_string(),
            set: set.map(str::to_string),
            pair,
            totals: card.word("TOTALS"),
            quantities,
            frequency,
        });
        Ok(())
    }

    /// Refuses prints without a set, or of one that does not exist.
    fn check_set(&self, card: &Card, keyword: &str, set: Option<&str>) -> Result<(), Fault> {
        match (keyword, set) {
            ("NODE PRINT", Some(name)) => self.deck.node_set(card, card.place, name).map(|_| ()),
            ("EL PRINT", Some(name)) => {
                find(card, card.place, "ELSET", name, &self.deck.element_sets).map(|_| ())
            }
            ("NODE PRINT", None) => Err(card.fault("NSET=NAME is missing")),
            ("EL PRINT", None) => Err(card.fault("ELSET=NAME is missing")),
            _ => Ok(()),
        }
    }
}
