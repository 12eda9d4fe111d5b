//! A deck as data: nodes, elements, sets, surfaces, materials, pairs and steps, each with the line that it comes from.
//!
//! Two passes over the cards: geometry and sets, which may be used before they are defined, then everything else in order.

use crate::elements::{Kind, kind};
use crate::equations::Equal;
use crate::error::Fault;
use crate::keywords::{Becomes, entry};
use crate::lines::{Card, Place, Row, Sources, folded};
use crate::pretension::PreTension;
use crate::steps::{Acting, Course, Step};
use dotyk::case::nearest;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A node or element by its index in the order of the deck.
pub(crate) type Index = u32;

/// Result files have columns of ten digits for numbers.
const LARGEST: u64 = 9_999_999_999;

/// A face of an element.
pub(crate) type Face = (Index, usize);

#[derive(Debug)]
pub(crate) struct Element {
    pub number: u64,
    /// Index into [`Deck::kinds`].
    pub kind: usize,
    pub nodes: Vec<Index>,
    pub place: Place,
}

/// Nodes or elements with a name.
#[derive(Debug, Clone, Default)]
pub(crate) struct Set {
    /// In the order of the deck, each once.
    pub members: Vec<Index>,
}

#[derive(Debug)]
pub(crate) struct Surface {
    pub name: String,
    pub faces: Vec<Face>,
    /// Of a surface of nodes.
    pub nodes: Option<Vec<Index>>,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Material {
    pub name: String,
    /// Young's modulus and Poisson's ratio.
    pub elastic: Option<[f64; 2]>,
    pub density: Option<f64>,
    /// Coefficient of expansion.
    pub expansion: Option<f64>,
    pub place: Place,
}

#[derive(Debug)]
pub(crate) struct Section {
    /// Name of the set of elements, as written.
    pub set: String,
    pub material: String,
    pub thickness: Option<f64>,
    pub place: Place,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Interaction {
    /// Coefficient of friction at the end of each step.
    pub friction: Vec<f64>,
    /// Whether both surfaces move together, step by step.
    pub tied: Vec<bool>,
}

/// Which gaps count as closed.
#[derive(Debug, Clone)]
pub(crate) enum Adjust {
    /// Those up to a length, and overlaps.
    UpTo(f64),
    /// Those of some nodes.
    Nodes(Vec<Index>),
}

#[derive(Debug)]
pub(crate) struct Pair {
    pub place: Place,
    /// Names of the surfaces, in capitals.
    pub slave: String,
    pub master: String,
    pub interaction: String,
    pub adjust: Option<Adjust>,
    pub clearance: Option<f64>,
    /// Whether it is there, step by step.
    pub present: Vec<bool>,
}

#[derive(Debug)]
pub(crate) struct Tie {
    pub place: Place,
    pub name: String,
    pub slave: String,
    pub master: String,
    pub tolerance: Option<f64>,
}

/// A cyclic symmetry: a tie whose first surface moves as the second does, turned.
#[derive(Debug)]
pub(crate) struct Cyclic {
    pub tie: Tie,
    /// Number of sectors and two points of the axis; `None` until its *CYCLIC SYMMETRY MODEL is read.
    pub model: Option<(u64, [[f64; 3]; 2])>,
}

/// How a set of nodes moves with a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Motion {
    Rigid,
    /// Rigid, without turning.
    Parallel,
    Average,
}

#[derive(Debug)]
pub(crate) struct Coupling {
    pub place: Place,
    /// That of its line.
    pub keyword: String,
    pub name: String,
    pub reference: Index,
    /// The node whose degrees of freedom 1 to 3 are the rotations of the point; otherwise 4 to 6 of the reference.
    pub rotation: Option<Index>,
    pub nodes: Vec<Index>,
    pub motion: Option<Motion>,
    pub of: String,
}

#[derive(Debug, Clone)]
pub(crate) struct Amplitude {
    pub points: Vec<[f64; 2]>,
    pub total: bool,
}

impl Amplitude {
    /// Its value, by straight lines, constant beyond the ends.
    pub fn at(&self, time: f64) -> f64 {
        let points = &self.points;
        let behind = points.iter().position(|point| point[0] >= time);
        match behind {
            None => points.last().map_or(1.0, |last| last[1]),
            Some(0) => points[0][1],
            Some(k) => {
                let ([t0, a0], [t1, a1]) = (points[k - 1], points[k]);
                a0 + (a1 - a0) * (time - t0) / (t1 - t0)
            }
        }
    }
}

/// A deck, read.
#[derive(Debug, Default)]
pub(crate) struct Deck {
    pub sources: Sources,
    /// Lines of *HEADING.
    pub headings: Vec<String>,
    pub numbers: Vec<u64>,
    pub points: Vec<[f64; 3]>,
    places: Vec<Place>,
    index: HashMap<u64, Index>,
    pub kinds: Vec<(String, Kind)>,
    pub elements: Vec<Element>,
    element_index: HashMap<u64, Index>,
    pub node_sets: BTreeMap<String, Set>,
    pub element_sets: BTreeMap<String, Set>,
    pub surfaces: BTreeMap<String, Surface>,
    pub materials: BTreeMap<String, Material>,
    pub sections: Vec<Section>,
    pub interactions: BTreeMap<String, Interaction>,
    pub pairs: Vec<Pair>,
    pub ties: Vec<Tie>,
    pub cyclic: Vec<Cyclic>,
    pub couplings: Vec<Coupling>,
    pub pretensions: Vec<PreTension>,
    /// What the elements of surfaces of pre-tension sections have instead of the nodes there.
    pub copies: BTreeMap<Index, Index>,
    /// Nodes that equations make one, the second of each stands for nothing any more.
    pub same: Vec<[Index; 2]>,
    pub amplitudes: BTreeMap<String, Amplitude>,
    /// Temperature of each node before the first step.
    pub initial: BTreeMap<Index, f64>,
    pub steps: Vec<Step>,
    pub acting: Acting,
    /// What was passed over, with its line.
    pub notes: Vec<String>,
}

impl Deck {
    /// The deck of cards.
    ///
    /// Errors: the first mistake, at its line.
    pub fn new(sources: Sources, cards: &[Card]) -> Result<Self, Fault> {
        let mut deck = Self {
            sources,
            ..Self::default()
        };
        for card in cards {
            known(card)?;
        }
        deck.geometry(cards)?;
        let (equal, held) = deck.equations(cards)?;
        deck.surfaces(cards)?;
        deck.cut_sections(cards)?;
        crate::steps::read(&mut deck, cards, &held)?;
        deck.act_on_kept_nodes();
        deck.treat_copies_alike();
        let axes = deck.axes();
        crate::equations::rigid_sides(&mut deck, &equal, axes)?;
        Ok(deck)
    }

    /// A remark at a line, once for each text.
    pub fn note(&mut self, place: Place, keyword: &str, message: &str) {
        let source = &self.sources.files[place.file as usize].name;
        let note = format!("{source}:{}: *{keyword}: {message}", place.line);
        self.notes.push(note);
    }

    fn geometry(&mut self, cards: &[Card]) -> Result<(), Fault> {
        for card in cards.iter().filter(|card| card.keyword == "NODE") {
            self.nodes(card)?;
        }
        for card in cards.iter().filter(|card| card.keyword == "ELEMENT") {
            self.elements(card)?;
        }
        for card in cards {
            match card.keyword.as_str() {
                "NSET" => self.set(card, "NSET")?,
                "ELSET" => self.set(card, "ELSET")?,
                _ => {}
            }
        }
        for set in self
            .node_sets
            .values_mut()
            .chain(self.element_sets.values_mut())
        {
            let mut seen = BTreeSet::new();
            set.members.retain(|member| seen.insert(*member));
        }
        Ok(())
    }

    /// Number of axes: that of the elements.
    pub fn axes(&self) -> usize {
        match self.elements.is_empty() {
            true => 3,
            false => self.shape(0).dimension,
        }
    }

    /// Reads all equations, and lets one node stand for two where they say so.
    fn equations(&mut self, cards: &[Card]) -> Result<crate::equations::Read, Fault> {
        let (mut equal, mut held) = (Vec::new(), Vec::new());
        for card in cards.iter().filter(|card| card.keyword == "EQUATION") {
            let (own, single) = crate::equations::read(self, card)?;
            equal.extend(own);
            held.extend(single);
        }
        self.same = crate::equations::same(self, &mut equal, self.axes());
        let kept = self.kept();
        let elements = self.elements.iter_mut();
        let nodes = elements.flat_map(|element| &mut element.nodes);
        nodes.for_each(|node| *node = kept(*node));
        for Equal { nodes, .. } in &mut equal {
            *nodes = nodes.map(&kept);
        }
        Ok((equal, held))
    }

    /// The node that stands for a node since equations made them one.
    pub fn kept(&self) -> impl Fn(Index) -> Index + use<> {
        let pairs = self.same.iter().map(|[kept, gone]| (*gone, *kept));
        let of: BTreeMap<Index, Index> = pairs.collect();
        move |node| of.get(&node).copied().unwrap_or(node)
    }

    /// Gives the nodes that stay what lines name those for that they stand. Forces add: both nodes bear theirs.
    fn act_on_kept_nodes(&mut self) {
        if self.same.is_empty() {
            return;
        }
        let kept = self.kept();
        let one = |nodes: &mut Vec<Index>| {
            let mut seen = BTreeSet::new();
            nodes.iter_mut().for_each(|node| *node = kept(*node));
            nodes.retain(|node| seen.insert(*node));
        };
        let surfaces = self.surfaces.values_mut();
        surfaces
            .filter_map(|surface| surface.nodes.as_mut())
            .for_each(one);
        for coupling in &mut self.couplings {
            one(&mut coupling.nodes);
            coupling.reference = kept(coupling.reference);
            coupling.rotation = coupling.rotation.map(&kept);
        }
        for pair in &mut self.pairs {
            if let Some(Adjust::Nodes(nodes)) = &mut pair.adjust {
                one(nodes);
            }
        }
        for [kept, gone] in &self.same {
            if let Some(value) = self.initial.remove(gone) {
                self.initial.entry(*kept).or_insert(value);
            }
        }
        let Acting {
            held,
            forces,
            temperatures,
            ..
        } = &mut self.acting;
        let of_component = |(node, freedom): (Index, u8)| (kept(node), freedom);
        held.rename(of_component, |_, _| {});
        forces.rename(of_component, Course::add);
        temperatures.rename(&kept, |_, _| {});
    }

    fn nodes(&mut self, card: &Card) -> Result<(), Fault> {
        if card.word("SYSTEM").is_some_and(|system| system != "R") {
            return Err(card.fault("coordinates are rectangular: SYSTEM=R"));
        }
        let mut members = Vec::with_capacity(card.rows.len());
        for row in &card.rows {
            let number = row.id(card, 0, "the number of a node")?;
            if number > LARGEST {
                return Err(card.fault_at(
                    row.place,
                    format!(
                        "numbers of nodes and elements have at most ten digits, found {number}"
                    ),
                ));
            }
            let mut point = [0.0; 3];
            for (d, x) in point.iter_mut().enumerate() {
                *x = row.number_or(card, d + 1, 0.0)?;
            }
            let new = self.points.len() as Index;
            let at = *self.index.entry(number).or_insert(new);
            if at == new {
                self.numbers.push(number);
                self.points.push(point);
                self.places.push(row.place);
            } else if self.points[at as usize] != point {
                let message = format!("node {number} has other coordinates further above");
                return Err(card.fault_at(row.place, message));
            }
            members.push(at);
        }
        if let Some(name) = card.get("NSET") {
            add(&mut self.node_sets, name, members);
        }
        Ok(())
    }

    /// A node of a new number at the place of another one.
    pub fn copy_node(&mut self, node: Index) {
        let largest = self.numbers.iter().copied().max().unwrap_or(0);
        self.numbers.push(largest + 1);
        self.points.push(self.points[node as usize]);
        self.places.push(self.places[node as usize]);
    }

    fn elements(&mut self, card: &Card) -> Result<(), Fault> {
        let Some(name) = card.word("TYPE") else {
            return Err(card.fault("TYPE is missing"));
        };
        let found = kind(&name).map_err(|why| card.fault(format!("TYPE={name}: {why}")))?;
        if let (Some(told), false) = (
            found.told,
            self.kinds.iter().any(|(known, _)| *known == name),
        ) {
            self.note(card.place, "ELEMENT", &format!("{name} {told}"));
        }
        let count = found.shape.nodes;
        let kind = self.kinds.len();
        self.kinds.push((name, found));
        let mut members = Vec::new();
        let mut open: Vec<(Place, u64)> = Vec::new();
        for row in &card.rows {
            let ids =
                (0..row.fields.len()).map(|k| row.id(card, k, "the number of an element or node"));
            let ids = ids.collect::<Result<Vec<_>, _>>()?;
            open.extend(ids.into_iter().map(|id| (row.place, id)));
            if open.len() > count {
                members.push(self.element(card, kind, &open, count)?);
                open.clear();
            }
        }
        if let Some((place, number)) = open.first() {
            let message = format!(
                "element {number} has {} nodes, {} needs {count}",
                open.len() - 1,
                self.kinds[kind].0
            );
            return Err(card.fault_at(*place, message));
        }
        if let Some(name) = card.get("ELSET") {
            add(&mut self.element_sets, name, members);
        }
        Ok(())
    }

    fn element(
        &mut self,
        card: &Card,
        kind: usize,
        ids: &[(Place, u64)],
        count: usize,
    ) -> Result<Index, Fault> {
        let (place, number) = ids[0];
        if number > LARGEST {
            return Err(card.fault_at(
                place,
                format!("numbers of nodes and elements have at most ten digits, found {number}"),
            ));
        }
        if ids.len() != count + 1 {
            let name = &self.kinds[kind].0;
            let message = format!(
                "element {number} has {} nodes, {name} needs {count}",
                ids.len() - 1
            );
            return Err(card.fault_at(place, message));
        }
        let nodes = ids[1..].iter().map(|(place, id)| {
            let known = self.index.get(id).copied();
            known.ok_or_else(|| card.fault_at(*place, format!("there is no node {id}")))
        });
        let nodes = nodes.collect::<Result<Vec<_>, _>>()?;
        let index = self.elements.len() as Index;
        if self.element_index.insert(number, index).is_some() {
            return Err(card.fault_at(place, format!("there are two elements {number}")));
        }
        self.elements.push(Element {
            number,
            kind,
            nodes,
            place,
        });
        Ok(index)
    }

    /// A set of nodes or elements: numbers, other sets, or first, last and increment.
    fn set(&mut self, card: &Card, of: &str) -> Result<(), Fault> {
        let Some(name) = card.get(of).filter(|name| !name.is_empty()) else {
            return Err(card.fault(format!("{of}=NAME is missing")));
        };
        let generate = card.get("GENERATE").is_some();
        let (index, sets) = match of {
            "NSET" => (&self.index, &self.node_sets),
            _ => (&self.element_index, &self.element_sets),
        };
        let mut members = Vec::new();
        for row in &card.rows {
            if generate {
                let first = row.id(card, 0, "a number")?;
                let last = if row.field(1).is_empty() {
                    first
                } else {
                    row.id(card, 1, "a number")?
                };
                let step = if row.field(2).is_empty() {
                    1
                } else {
                    row.id(card, 2, "an increment")?
                };
                if last < first {
                    return Err(card.fault_at(
                        row.place,
                        format!("GENERATE from {first} to {last}: the first is the smaller"),
                    ));
                }
                // numbers between that do not exist are passed over, as they are by CalculiX
                let within = |number: &u64| {
                    (first..=last).contains(number) && (number - first).is_multiple_of(step)
                };
                let mut numbers: Vec<u64> = match (last - first) / step < index.len() as u64 {
                    true => (first..=last)
                        .step_by(step as usize)
                        .filter(|n| index.contains_key(n))
                        .collect(),
                    false => index.keys().copied().filter(within).collect(),
                };
                numbers.sort_unstable();
                members.extend(numbers.iter().map(|number| index[number]));
                continue;
            }
            for field in row.fields.iter().filter(|field| !field.is_empty()) {
                match field.parse::<u64>() {
                    Ok(number) => {
                        let known = index.get(&number).copied();
                        let what = if of == "NSET" { "node" } else { "element" };
                        members.push(known.ok_or_else(|| {
                            card.fault_at(row.place, format!("there is no {what} {number}"))
                        })?);
                    }
                    Err(_) => members.extend(&find(card, row.place, of, field, sets)?.members),
                }
            }
        }
        let sets = match of {
            "NSET" => &mut self.node_sets,
            _ => &mut self.element_sets,
        };
        add(sets, name, members);
        Ok(())
    }

    fn surfaces(&mut self, cards: &[Card]) -> Result<(), Fault> {
        for card in cards.iter().filter(|card| card.keyword == "SURFACE") {
            let Some(name) = card.get("NAME").filter(|name| !name.is_empty()) else {
                return Err(card.fault("NAME is missing"));
            };
            let kind = card.word("TYPE").unwrap_or("ELEMENT".to_string());
            let mut surface = Surface {
                name: name.to_string(),
                faces: Vec::new(),
                nodes: None,
            };
            match kind.as_str() {
                "ELEMENT" => {
                    for row in &card.rows {
                        surface.faces.extend(self.faces(card, row)?);
                    }
                    let mut seen = BTreeSet::new();
                    surface.faces.retain(|face| seen.insert(*face));
                }
                "NODE" => {
                    let mut nodes = Vec::new();
                    for row in &card.rows {
                        nodes.extend(self.nodes_of(card, row, 0)?);
                    }
                    if nodes.is_empty() {
                        return Err(card.fault(format!("surface {name} has no nodes")));
                    }
                    surface.nodes = Some(nodes);
                }
                _ => {
                    return Err(card.fault(format!("TYPE={kind}: a surface is of ELEMENT or NODE")));
                }
            }
            if surface.faces.is_empty() && surface.nodes.is_none() {
                let message = format!("surface {name} has no faces");
                return Err(card.fault(message));
            }
            if self.surfaces.insert(folded(name), surface).is_some() {
                return Err(card.fault(format!("there are two surfaces {name}")));
            }
        }
        Ok(())
    }

    /// The faces of a line of *SURFACE: element or set, and face.
    fn faces(&self, card: &Card, row: &Row) -> Result<Vec<Face>, Fault> {
        let elements = self.elements_of(card, row)?;
        let label = folded(row.field(1));
        if label.is_empty() {
            return Ok(self.free_faces(&elements));
        }
        let number = label
            .strip_prefix('S')
            .and_then(|text| text.parse::<usize>().ok());
        let Some(number) = number.filter(|number| *number > 0) else {
            let message = format!(
                "`{}` is no face of a solid element: S1, S2, ..",
                row.field(1)
            );
            return Err(card.fault_at(row.place, message));
        };
        let faces = elements
            .into_iter()
            .map(|element| self.face(card, row.place, element, number - 1));
        faces.collect()
    }

    /// A face that the element has.
    pub fn face(
        &self,
        card: &Card,
        place: Place,
        element: Index,
        face: usize,
    ) -> Result<Face, Fault> {
        let own = &self.elements[element as usize];
        let (name, kind) = &self.kinds[own.kind];
        match face < kind.shape.faces.len() {
            true => Ok((element, face)),
            false => {
                let message = format!(
                    "element {} of type {name} has no face {}",
                    own.number,
                    face + 1
                );
                Err(card.fault_at(place, message))
            }
        }
    }

    /// Faces of some elements that belong to none of the others.
    fn free_faces(&self, elements: &[Index]) -> Vec<Face> {
        let mut seen: BTreeMap<Vec<Index>, Vec<Face>> = BTreeMap::new();
        for &element in elements {
            for face in 0..self.shape(element).faces.len() {
                seen.entry(self.corners((element, face)))
                    .or_default()
                    .push((element, face));
            }
        }
        let free = seen.into_values().filter(|faces| faces.len() == 1);
        let mut free: Vec<Face> = free.flatten().collect();
        free.sort_unstable();
        free
    }

    pub fn shape(&self, element: Index) -> &'static crate::elements::Shape {
        self.kinds[self.elements[element as usize].kind].1.shape
    }

    /// The corners of a face in ascending order.
    pub fn corners(&self, (element, face): Face) -> Vec<Index> {
        let nodes = &self.elements[element as usize].nodes;
        let corners = self.shape(element).faces[face].iter();
        let mut corners: Vec<Index> = corners.map(|&corner| nodes[corner]).collect();
        corners.sort_unstable();
        corners
    }

    /// The nodes of a face, middle nodes behind the corners.
    pub fn face_nodes(&self, (element, face): Face) -> Vec<Index> {
        let nodes = &self.elements[element as usize].nodes;
        let own = self.shape(element).face_nodes(face);
        own.into_iter().map(|node| nodes[node]).collect()
    }

    /// The element or the set of elements in the first field of a line.
    pub fn elements_of(&self, card: &Card, row: &Row) -> Result<Vec<Index>, Fault> {
        let field = row.field(0);
        if let Ok(number) = field.parse::<u64>() {
            let known = self.element_index.get(&number).copied();
            let missing = || card.fault_at(row.place, format!("there is no element {number}"));
            return Ok(vec![known.ok_or_else(missing)?]);
        }
        let set = find(card, row.place, "ELSET", field, &self.element_sets)?;
        match set.members.is_empty() {
            true => Err(card.fault_at(row.place, format!("ELSET `{field}` is empty"))),
            false => Ok(set.members.clone()),
        }
    }

    /// The node or the set of nodes in a field of a line.
    pub fn nodes_of(&self, card: &Card, row: &Row, at: usize) -> Result<Vec<Index>, Fault> {
        let field = row.field(at);
        if let Ok(number) = field.parse::<u64>() {
            return Ok(vec![self.node(card, row.place, number)?]);
        }
        Ok(self.node_set(card, row.place, field)?.members.clone())
    }

    /// A node of a number.
    pub fn node(&self, card: &Card, place: Place, number: u64) -> Result<Index, Fault> {
        let known = self.index.get(&number).copied();
        known.ok_or_else(|| card.fault_at(place, format!("there is no node {number}")))
    }

    /// A set of nodes.
    pub fn node_set(&self, card: &Card, place: Place, name: &str) -> Result<&Set, Fault> {
        let set = find(card, place, "NSET", name, &self.node_sets)?;
        match set.members.is_empty() {
            true => Err(card.fault_at(place, format!("NSET `{name}` is empty"))),
            false => Ok(set),
        }
    }
}

/// Adds members to a set.
fn add(sets: &mut BTreeMap<String, Set>, name: &str, members: Vec<Index>) {
    let set = sets.entry(folded(name)).or_default();
    set.members.extend(members);
}

/// What a name stands for; `what` is its kind in messages.
///
/// Errors: a name that is not among the known ones.
pub(crate) fn find<'m, T>(
    card: &Card,
    place: Place,
    what: &str,
    name: &str,
    known: &'m BTreeMap<String, T>,
) -> Result<&'m T, Fault> {
    known.get(&folded(name)).ok_or_else(|| {
        let near = nearest(&folded(name), known.keys().map(String::as_str));
        let near = near.map_or(String::new(), |near| format!(", the nearest is {near}"));
        card.fault_at(place, format!("there is no {what} `{name}`{near}"))
    })
}

/// Refuses unknown keywords and parameters, and what cannot be done.
fn known(card: &Card) -> Result<(), Fault> {
    let Some((_, parameters, becomes)) = entry(&card.keyword) else {
        let words = crate::keywords::KEYWORDS.iter().map(|(word, ..)| *word);
        let near = nearest(&card.keyword, words);
        let near = near.map_or(String::new(), |near| {
            format!(", the nearest known one is *{near}")
        });
        return Err(card.fault(format!("this keyword is not known{near}")));
    };
    if let Becomes::Refused(why) = becomes {
        return Err(card.fault(*why));
    }
    for (k, (name, _)) in card.parameters.iter().enumerate() {
        if card.parameters[..k]
            .iter()
            .any(|(before, _)| before == name)
        {
            return Err(card.fault(format!("the parameter {name} is given twice")));
        }
        if !parameters.contains(&name.as_str()) {
            let words = parameters.to_vec().join(", ");
            let known = if words.is_empty() {
                "it has none".to_string()
            } else {
                format!("known are {words}")
            };
            return Err(card.fault(format!("the parameter {name} is not known: {known}")));
        }
    }
    Ok(())
}
