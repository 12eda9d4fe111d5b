//! `[[contact]]` of a case file.

use crate::case::body::joined;
use crate::case::document::{Entry, Node, Span, Table, Value, later, name, zero};
use crate::case::error::Fault;
use crate::case::keys;
use crate::case::mesh_file::MeshFiles;
use crate::case::points::{named_places, of_body};
use crate::case::steps::Steps;
use crate::case::suggest::listed;
use crate::case::surface::{shapes, surface};
use crate::case::tool::tool;
use crate::contact::{ContactError, End};
use crate::fem::Constraints;
use crate::geometry::Field;
use crate::model::{
    Body, BodyId, Contact, Finding, FindingError, Gap, Gasket, Law, Motion, Obstacle, Pair,
    Pairing, Place, Rigid, SideRef, find,
};
use std::sync::Arc;

const PAIRINGS: [(&str, Pairing); 2] = [
    ("node-to-node", Pairing::NodeToNode),
    ("mortar", Pairing::Mortar),
];

/// The contacts of a case.
pub(crate) struct Contacts<const D: usize> {
    /// Written and found ones, in the order of the case.
    pub list: Vec<Contact<D>>,
    /// What is known of the search.
    pub aside: Aside,
}

/// What is known of contacts that were to be found, beside those that were.
#[derive(Debug, Clone, Default)]
pub(crate) struct Aside {
    /// Between which bodies they were sought.
    pub sought: Vec<Sought>,
    /// What `check` tells: pairs of bodies that are left to written contacts.
    pub notes: Vec<String>,
    /// What every command tells: pairs of bodies that overlap too much.
    pub warnings: Vec<String>,
    /// Name of each found contact, and the place of the table that it comes from.
    pub places: Vec<(String, Span)>,
}

/// Bodies between which contacts were sought.
#[derive(Debug, Clone)]
pub(crate) struct Sought {
    name: String,
    bodies: Vec<String>,
}

impl Sought {
    /// Whether a contact between two of the bodies would have this name.
    pub fn would_be(&self, name: &str) -> bool {
        let after = |text: &'_ str, head: &str| -> Option<usize> {
            text.strip_prefix(head)?
                .starts_with('-')
                .then_some(head.len() + 1)
        };
        let Some(start) = after(name, &self.name) else {
            return false;
        };
        let pair = &name[start..];
        let mut seconds = self.bodies.iter().enumerate().filter_map(|(k, first)| {
            let start = after(pair, first)?;
            Some((k, &pair[start..]))
        });
        seconds.any(|(k, second)| self.bodies[k + 1..].iter().any(|body| body == second))
    }
}

/// A table `[[contact]]`.
enum Read<const D: usize> {
    Written(Box<Contact<D>>),
    Sought(Box<Finding>),
}

/// The contacts of these tables; found ones become sides of their bodies, after those that are written.
pub(crate) fn contacts<const D: usize>(
    nodes: &[Node],
    bodies: &mut [Body<D>],
    steps: &Steps,
    files: &mut MeshFiles,
) -> Result<Contacts<D>, Fault> {
    let tables = nodes.iter().map(|node| {
        let sought = node.table(keys::CONTACT)?.entry("bodies").is_some();
        Ok(match sought {
            true => Read::Sought(Box::new(finding(node, bodies, steps)?)),
            false => Read::Written(Box::new(contact(node, bodies, steps, files)?)),
        })
    });
    let tables = tables.collect::<Result<Vec<Read<D>>, Fault>>()?;
    let written = tables.iter().filter_map(|table| match table {
        Read::Written(contact) => Some(Contact::clone(contact)),
        Read::Sought(_) => None,
    });
    let written: Vec<Contact<D>> = written.collect();
    let (mut list, mut aside) = (Vec::new(), Aside::default());
    let mut before: Vec<Contact<D>> = Vec::new();
    for (table, node) in tables.into_iter().zip(nodes) {
        match table {
            Read::Written(contact) => list.push(*contact),
            Read::Sought(sought) => {
                let span = node
                    .table(keys::CONTACT)?
                    .require("name", "a contact")?
                    .span
                    .clone();
                let found = find(&sought, bodies, (&written, &before));
                let found = found.map_err(|error| not_found(node, &error))?;
                let names = found.contacts.iter().map(|contact| contact.name.clone());
                aside.places.extend(names.map(|name| (name, span.clone())));
                before.extend(found.contacts.iter().cloned());
                list.extend(found.contacts);
                aside.sought.push(Sought {
                    bodies: sought
                        .bodies
                        .iter()
                        .map(|id| bodies[id.0].name.clone())
                        .collect(),
                    name: sought.name,
                });
                aside.notes.extend(found.left);
                aside.warnings.extend(found.warnings);
            }
        }
    }
    Ok(Contacts { list, aside })
}

/// Contacts that are to be found between bodies.
fn finding<const D: usize>(
    node: &Node,
    bodies: &[Body<D>],
    steps: &Steps,
) -> Result<Finding, Fault> {
    let table = node.table(keys::CONTACT)?;
    let name = name(table.require("name", "a contact")?)?;
    let instead = [
        "nonmortar",
        "mortar",
        "sides",
        "obstacle",
        "exclude",
        "friction_exclude",
        "gasket",
    ];
    if let Some(entry) = instead.iter().find_map(|key| table.entry(key)) {
        let message = format!(
            "contact `{name}` is found between `bodies` and has no `{}`",
            entry.key
        );
        return Err(Fault::new(&entry.key_span, message)
            .label("of a written contact")
            .help("remove it, or write the contact of two bodies with `sides`, to which these are then left"));
    }
    let of = table.require("bodies", "contacts that are found")?;
    let index = |node: &Node| {
        let text = node.text()?;
        let place = bodies.iter().position(|body| body.name == text);
        place.map(BodyId).ok_or_else(|| {
            let fault = Fault::new(&node.span, format!("unknown body `{text}`"));
            let names = bodies.iter().map(|body| body.name.as_str());
            fault.nearest(text, ["the nearest known body", "bodies"], names)
        })
    };
    let between = match &of.value {
        Value::Text(text) if text == "all" => (0..bodies.len()).map(BodyId).collect(),
        Value::List(list) => list.iter().map(index).collect::<Result<Vec<_>, _>>()?,
        _ => return Err(of.expected("\"all\" or a list of names of bodies")),
    };
    // pairs are named in the order of the case
    let mut between: Vec<BodyId> = between;
    between.sort_unstable();
    Ok(Finding {
        bodies: between,
        reach: reach(table)?,
        pairing: pairing(table)?,
        gap: table.get("gap").map(gap).transpose()?,
        law: law(table, &name)?,
        active: steps.active(table)?,
        name,
    })
}

/// The largest distance of facets that face each other.
fn reach(table: Table<'_>) -> Result<Option<f64>, Fault> {
    let node = table.get("reach");
    node.map(|node| node.positive("`reach`")).transpose()
}

fn pairing(table: Table<'_>) -> Result<Option<Pairing>, Fault> {
    let node = table.get("pairing");
    node.map(|node| node.choice("pairing", &PAIRINGS))
        .transpose()
}

/// The mistake at its key.
fn not_found(node: &Node, error: &FindingError) -> Fault {
    let key = match error {
        FindingError::TooFew { .. }
        | FindingError::Repeated { .. }
        | FindingError::Twice { .. } => "bodies",
        FindingError::Nothing { reach: Some(_), .. } => "reach",
        FindingError::Nothing { reach: None, .. } => "bodies",
        FindingError::SideExists { .. } => "name",
    };
    let entry = node
        .entries()
        .ok()
        .and_then(|all| all.iter().find(|entry| entry.key == key));
    let fault = Fault::new(
        entry.map_or(&node.span, |entry| &entry.node.span),
        error.to_string(),
    );
    match error {
        FindingError::TooFew { .. } => fault
            .label("fewer than two")
            .help("name two bodies or more, or say \"all\""),
        FindingError::Repeated { .. } => fault.label("the same body"),
        FindingError::Nothing { .. } => fault
            .label("nothing is found")
            .help("give a larger `reach`, or correct the places of the bodies; surfaces face each other where their normals are opposed and no body is between them"),
        FindingError::Twice { .. } => fault.label("between the same bodies"),
        FindingError::SideExists { .. } => fault.label("its side has this name"),
    }
}

/// One written contact between sides of these bodies.
fn contact<const D: usize>(
    node: &Node,
    bodies: &mut [Body<D>],
    steps: &Steps,
    files: &mut MeshFiles,
) -> Result<Contact<D>, Fault> {
    let table = node.table(keys::CONTACT)?;
    let name = name(table.require("name", "a contact")?)?;
    let pair = pair(table, &name, bodies, files)?;
    let law = law(table, &name)?;
    let pairing = pairing(table)?;
    if let (Some(entry), Some(Pairing::NodeToNode)) = (table.entry("pairing"), pairing)
        && let Pair::Obstacle { obstacle, .. } = &pair
        && matches!(obstacle.shape, Rigid::Tool(_))
    {
        let message = format!("contact `{name}` has a tool, whose corners lie between the nodes");
        return Err(Fault::new(&entry.node.span, message)
            .label("not node to node")
            .help("leave it out: a tool is paired by its facets"));
    }
    if let (Some(entry), Pair::Obstacle { .. }) = (table.entry("reach"), &pair) {
        let message = format!("contact `{name}` has an obstacle, and no `reach`");
        return Err(Fault::new(&entry.key_span, message)
            .label("between bodies alone")
            .help("remove it: an obstacle counts wherever it is"));
    }
    let gap = match (table.get("gap"), &pair) {
        (None, _) => None,
        (Some(node), Pair::Obstacle { .. }) => match gap(node)? {
            // The default for an obstacle: its own `gap` is the distance.
            Gap::Geometric => None,
            _ => {
                let message = format!("the obstacle of contact `{name}` has its own gap");
                return Err(Fault::new(&node.span, message)
                    .label("a second gap")
                    .help("leave it out: an obstacle with a shape is where it is drawn or `displacement` moves it to, and `obstacle = { gap = .. }` has no shape"));
            }
        },
        (Some(node), _) => Some(gap(node)?),
    };
    let gasket = gasket(table, (&name, &pair, &law))?;
    // it fills what lies between its sides
    let gap = gap.or(gasket.as_ref().map(|_| Gap::Closed));
    let (exclude, friction_exclude) = (table.get("exclude"), table.get("friction_exclude"));
    if let (Some(node), None) = (friction_exclude, table.get("friction")) {
        let message = format!("contact `{name}` has no friction that a node could be without");
        return Err(Fault::new(&node.span, message)
            .label("superfluous")
            .help("use `exclude` for nodes that take no part at all"));
    }
    let named = [exclude, friction_exclude].into_iter().flatten();
    let named = named.map(names).collect::<Result<Vec<_>, _>>()?.concat();
    let pair = with_names(pair, &named, bodies)?;
    let places = |node: Option<&Node>| {
        let places = node.map(|node| excluded(node, &pair, bodies));
        places.unwrap_or(Ok(Vec::new()))
    };
    Ok(Contact {
        exclude: places(exclude)?,
        friction_exclude: places(friction_exclude)?,
        name,
        pair,
        pairing,
        gap,
        law,
        gasket,
        reach: reach(table)?,
        active: steps.active(table)?,
    })
}

/// What lies in a contact and is compressed.
fn gasket<const D: usize>(
    table: Table<'_>,
    (name, pair, law): (&str, &Pair<D>, &Law),
) -> Result<Option<Gasket>, Fault> {
    let Some(entry) = table.entry("gasket") else {
        return Ok(None);
    };
    if matches!(pair, Pair::Obstacle { .. }) {
        let message =
            format!("contact `{name}` has an obstacle, and a gasket lies between two bodies");
        return Err(Fault::new(&entry.key_span, message)
            .label("no second body")
            .help("make the obstacle a body that is held"));
    }
    if matches!(law, Law::Tied | Law::Cohesive { .. }) {
        let message = format!("contact `{name}` has a gasket, which presses and does not pull");
        return Err(Fault::new(&entry.key_span, message)
            .label("not with a tie or a joint")
            .help("leave out `tied`, or the cohesion"));
    }
    let own = entry.node.table(keys::GASKET)?;
    let numbers = |key: &str| -> Result<Vec<f64>, Fault> {
        let list = own.require(key, "a gasket")?.list()?;
        list.iter().map(Node::number).collect()
    };
    let unloading = own.get("unloading");
    let gasket = Gasket {
        closure: numbers("closure")?,
        pressure: numbers("pressure")?,
        unloading: unloading
            .map(|node| node.positive("`unloading`"))
            .transpose()?,
    };
    match gasket.check() {
        Ok(()) => Ok(Some(gasket)),
        Err(error) => {
            let message = format!("contact `{name}`: {error}");
            Err(Fault::new(&entry.node.span, message).label("no law"))
        }
    }
}

/// The name of a "NAME" or "BODY.NAME" of one body.
fn own_name<'n, const D: usize>(name: &'n str, body: &Body<D>) -> &'n str {
    let of_body = name.strip_prefix(body.name.as_str());
    of_body
        .and_then(|rest| rest.strip_prefix('.'))
        .unwrap_or(name)
}

/// One name or a list of names, with their nodes.
fn names(node: &Node) -> Result<Vec<(&str, &Node)>, Fault> {
    match &node.value {
        Value::List(list) => list.iter().map(|node| Ok((node.text()?, node))).collect(),
        _ => Ok(vec![(node.text()?, node)]),
    }
}

/// Where dotyk would choose between two sides, the one whose body has points and sides of these names carries the forces.
fn with_names<const D: usize>(
    pair: Pair<D>,
    named: &[(&str, &Node)],
    bodies: &[Body<D>],
) -> Result<Pair<D>, Fault> {
    let (Pair::Automatic(sides), Some((_, first))) = (&pair, named.first()) else {
        return Ok(pair);
    };
    let has_all = |side: &SideRef| {
        let body = &bodies[side.body.0];
        let mut names = named.iter();
        names.all(|(name, _)| {
            let name = own_name(name, body);
            !named_places(name, &body.mesh, &body.points).is_empty()
        })
    };
    let [nonmortar, mortar] = match sides.each_ref().map(has_all) {
        [true, false] => sides.clone(),
        [false, true] => [sides[1].clone(), sides[0].clone()],
        both => {
            let found = if both[0] {
                "both bodies of this contact have"
            } else {
                "neither body of this contact has"
            };
            let message = format!("{found} what is excluded");
            return Err(Fault::new(&first.span, message)
                .label("of which side?")
                .help("write `nonmortar` and `mortar` instead of `sides`: what is excluded belongs to the nonmortar body"));
        }
    };
    Ok(Pair::Given { nonmortar, mortar })
}

/// The places of some names of the nonmortar body.
fn excluded<const D: usize>(
    node: &Node,
    pair: &Pair<D>,
    bodies: &[Body<D>],
) -> Result<Vec<Place<D>>, Fault> {
    let (Pair::Given { nonmortar, .. } | Pair::Obstacle { nonmortar, .. }) = pair else {
        return Ok(Vec::new());
    };
    let body = &bodies[nonmortar.body.0];
    let end = End {
        body,
        side: &nonmortar.side,
        constraints: &Constraints::default(),
        part: None,
    };
    let on_side = |places: &[Place<D>], span: &Span| {
        let nodes = end.nodes_at(places);
        let fault = |error: ContactError| Fault::new(span, error.to_string());
        nodes.map_err(|error| match error {
            ContactError::NothingLeft { .. } => fault(error).label("nothing is left"),
            _ => fault(error).label("not on that side"),
        })
    };
    let mut all = Vec::new();
    for (name, node) in names(node)? {
        let name = own_name(name, body);
        let places = named_places(name, &body.mesh, &body.points);
        if places.is_empty() {
            let known = body.mesh.side_names();
            let known: Vec<&str> = known
                .chain(body.points.keys().map(String::as_str))
                .collect();
            let message = format!("body `{}` has no point or side `{name}`", body.name);
            let words = ["the nearest known name", "its sides and points"];
            return Err(Fault::new(&node.span, message).nearest(name, words, known.into_iter()));
        }
        on_side(&places, &node.span)?;
        all.extend(places);
    }
    on_side(&all, &node.span)?;
    Ok(all)
}

/// Who touches whom: `nonmortar` with `mortar`, `nonmortar` with `obstacle`, or `sides`.
fn pair<const D: usize>(
    table: Table<'_>,
    contact: &str,
    bodies: &mut [Body<D>],
    files: &mut MeshFiles,
) -> Result<Pair<D>, Fault> {
    let get = |key: &str| table.get(key);
    match (
        get("nonmortar"),
        get("mortar"),
        get("sides"),
        get("obstacle"),
    ) {
        (Some(nonmortar), Some(mortar), None, None) => {
            let pair = [side_ref(nonmortar, bodies)?, side_ref(mortar, bodies)?];
            different(&pair, mortar, contact)?;
            let [nonmortar, mortar] = pair;
            Ok(Pair::Given { nonmortar, mortar })
        }
        (None, None, Some(node), None) => {
            let [a, b] = node.list()? else {
                let message = format!("`sides` of contact `{contact}` needs two sides");
                return Err(Fault::new(&node.span, message).label("not two"));
            };
            let pair = [side_ref(a, bodies)?, side_ref(b, bodies)?];
            different(&pair, b, contact)?;
            Ok(Pair::Automatic(pair))
        }
        (Some(nonmortar), None, None, Some(node)) => Ok(Pair::Obstacle {
            nonmortar: side_ref(nonmortar, bodies)?,
            obstacle: obstacle(node, contact, files)?,
        }),
        _ => {
            let given = ["nonmortar", "mortar", "sides", "obstacle"];
            let given = given.into_iter().filter(|key| table.entry(key).is_some());
            let given = listed(given);
            let found = if given.is_empty() { "nothing" } else { &given };
            let message = format!("contact `{contact}` must say what touches what, found {found}");
            Err(Fault::new(table.span, message)
                .label("incomplete or contradictory")
                .help("give `nonmortar` and `mortar`, or `sides`, or `nonmortar` and `obstacle`, or `bodies` between which contacts are found"))
        }
    }
}

fn different(pair: &[SideRef; 2], second: &Node, contact: &str) -> Result<(), Fault> {
    if pair[0] != pair[1] {
        return Ok(());
    }
    let side = &pair[0].side;
    let message = format!("contact `{contact}` presses the side `{side}` against itself");
    Err(Fault::new(&second.span, message).label("the same side"))
}

/// "BODY.SIDE", or a list of sides of one body.
pub(crate) fn side_ref<const D: usize>(
    node: &Node,
    bodies: &mut [Body<D>],
) -> Result<SideRef, Fault> {
    let one = |node: &Node| {
        let written = ["a side", "\"BODY.SIDE\", such as \"block.top\""];
        let (body, side) = of_body(node, bodies, written)?;
        Ok((body, side.to_string(), node.span.clone()))
    };
    let list = match &node.value {
        Value::List(list) => list.iter().map(one).collect::<Result<Vec<_>, Fault>>()?,
        _ => vec![one(node)?],
    };
    let Some(&(body, ..)) = list.first() else {
        return Err(Fault::new(&node.span, "the list of sides is empty").label("no side"));
    };
    if let Some((_, side, span)) = list.iter().find(|(other, ..)| *other != body) {
        let name = &bodies[body].name;
        let message =
            format!("the sides of one list belong to one body, `{side}` is not of `{name}`");
        return Err(Fault::new(span, message)
            .label("another body")
            .help("a contact is between two bodies: write a [[contact]] for each pair"));
    }
    let sides: Vec<_> = list
        .into_iter()
        .map(|(_, side, span)| (side, span))
        .collect();
    let Body { name, mesh, .. } = &mut bodies[body];
    Ok(SideRef {
        body: BodyId(body),
        side: joined(&sides, &node.span, name, Arc::make_mut(mesh))?,
    })
}

/// A shape and its motion.
fn obstacle<const D: usize>(
    node: &Node,
    contact: &str,
    files: &mut MeshFiles,
) -> Result<Obstacle<D>, Fault> {
    let table = node.table(keys::OBSTACLE)?;
    if let Some(entry) = table.entry("turn") {
        return Err(later(&entry.key_span, "`turn` of an obstacle"));
    }
    let tools = ["outline", "stl"];
    let shapes = shapes::<D>().chain([tools[D - 2], "gap"]);
    let all = keys::SURFACE.iter().copied().chain(tools).chain(["gap"]);
    let given: Vec<&Entry> = all.filter_map(|key| table.entry(key)).collect();
    let [entry] = given[..] else {
        return Err(Fault::new(table.span, "an obstacle has exactly one shape")
            .label("not exactly one")
            .help(format!("give one of {}", listed(shapes))));
    };
    let shape = match entry.key.as_str() {
        "gap" => Rigid::Gap(entry.node.field()?),
        key if tools.contains(&key) => {
            let tool = tool(entry, contact, files)?;
            Rigid::Tool(Arc::new(tool))
        }
        _ => {
            let (surface, inside) = surface(entry)?;
            Rigid::Surface { surface, inside }
        }
    };
    let motion = match (table.get("displacement"), table.get("force")) {
        (None, None) => Motion::Prescribed(zero()),
        (Some(displacement), None) => Motion::Prescribed(displacement.courses()?),
        (None, Some(force)) => Motion::Loaded(force.courses()?),
        (Some(_), Some(force)) => {
            let message = "an obstacle is moved by a displacement or loaded by a force";
            return Err(Fault::new(&force.span, message)
                .label("both are given")
                .help("remove `displacement` or `force`"));
        }
    };
    Ok(Obstacle { shape, motion })
}

fn gap(node: &Node) -> Result<Gap, Fault> {
    if matches!(node.value, Value::Table(_)) {
        let most = node
            .table(keys::GAP)?
            .require("adjust", "a `gap` as a table")?;
        return Ok(Gap::Adjusted(most.not_negative("`adjust`")?));
    }
    let Value::Text(text) = &node.value else {
        return Ok(Gap::Given(node.field()?));
    };
    match text.as_str() {
        "geometric" => Ok(Gap::Geometric),
        "closed" => Ok(Gap::Closed),
        _ => node.field().map(Gap::Given).map_err(|fault| {
            fault.help("a gap is \"geometric\", \"closed\", a number, an expression or { adjust = LENGTH }")
        }),
    }
}

/// The contact law.
fn law(table: Table<'_>, contact: &str) -> Result<Law, Fault> {
    let friction = table.get("friction");
    if let Some(node) = table.get("tied")
        && node.boolean()?
    {
        return match friction {
            None => Ok(Law::Tied),
            Some(friction) => Err(Fault::new(
                &friction.span,
                format!("contact `{contact}` is tied and has friction"),
            )
            .label("a tie does not slip")
            .help("remove `friction` or `tied`")),
        };
    }
    let law = match friction {
        None => Law::Frictionless,
        Some(node) => friction_law(node, contact)?,
    };
    let constant = |field: &Field| field.as_constant().ok_or(());
    match law.friction(constant, 1.0) {
        Ok(Some(smooth))
            if smooth.is_smooth()
                && law
                    .tension()
                    .and_then(Field::as_constant)
                    .is_none_or(|t| t == 0.0) =>
        {
            Ok(Law::Frictionless)
        }
        _ => Ok(law),
    }
}

/// A coefficient, or a table with the values of one law.
fn friction_law(node: &Node, contact: &str) -> Result<Law, Fault> {
    let field = |node: &Node| match node.field()? {
        field if field.as_constant().is_some_and(|value| value < 0.0) => {
            let message = format!("friction of contact `{contact}` is negative");
            Err(Fault::new(&node.span, message).label("not ≥ 0"))
        }
        field => Ok(field),
    };
    if !matches!(node.value, Value::Table(_)) {
        return field(node).map(Law::Coulomb);
    }
    let table = node.table(keys::FRICTION)?;
    if let (Some(entry), None) = (table.entry("tension"), table.entry("cohesion")) {
        let message = format!("the joint of contact `{contact}` has tension and no cohesion");
        return Err(Fault::new(&entry.key_span, message)
            .label("more than cohesion / coulomb")
            .help("a joint that bears tension bears shear, too: add `cohesion`, at least coulomb times tension"));
    }
    let value = |key: &str| table.get(key).map(field).transpose();
    match (value("coulomb")?, value("tresca")?, table.entry("cohesion")) {
        (Some(coefficient), None, None) => Ok(Law::Coulomb(coefficient)),
        (None, Some(traction), None) => Ok(Law::Tresca(traction)),
        (coefficient, None, Some(entry)) => {
            let none = || Field::constant(0.0);
            let values = [
                field(&entry.node)?,
                coefficient.unwrap_or_else(none),
                value("tension")?.unwrap_or_else(none),
            ];
            let span = table.get("tension").map_or(&node.span, |node| &node.span);
            joint(values, span, contact)
        }
        _ => {
            let message = format!("friction of contact `{contact}` needs one law");
            let help = "give `coulomb` (a coefficient), `tresca` (a shear traction), or `cohesion` (a stress) with or without \
                        `coulomb`";
            let fault = Fault::new(&node.span, message).label("not exactly one");
            Err(fault.help(help))
        }
    }
}

/// A joint of this cohesion, coefficient and tension, which must not exceed cohesion over coefficient; `span` is that of the
/// tension.
fn joint(values: [Field; 3], span: &Span, contact: &str) -> Result<Law, Fault> {
    let constant = values.each_ref().map(Field::as_constant);
    if let [Some(cohesion), Some(coefficient), Some(tension)] = constant
        && tension * coefficient > cohesion * (1.0 + ROUNDED)
    {
        let message =
            format!("the joint of contact `{contact}` bears more tension than its cohesion allows");
        let most = cohesion / coefficient;
        return Err(Fault::new(span, message)
            .label(format!("more than cohesion / coulomb = {most}"))
            .help("such a joint fails in shear before it does in tension: lower `tension`, or raise `cohesion`"));
    }
    let [cohesion, coefficient, tension] = values;
    Ok(Law::Cohesive {
        cohesion,
        coefficient,
        tension,
    })
}

/// Numbers of a case file are written with some ten digits.
const ROUNDED: f64 = 1e-9;
