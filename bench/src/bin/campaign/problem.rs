//! A contact problem as plain data, and its case file.
//!
//! Generators write it; the checker reads loads, supports and contacts from it. Meshes are described here, not made: the
//! checker takes points, cells and sides from the program's mesh.

use crate::amount::Amount;
use crate::cells::Kind;
use crate::plane::Vector;
use crate::raw::Cell;
use std::fmt::Write;

/// Kind of analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Analysis {
    PlaneStrain,
    PlaneStress,
    Axisymmetric,
}

impl Analysis {
    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlaneStrain => "plane-strain",
            Self::PlaneStress => "plane-stress",
            Self::Axisymmetric => "axisymmetric",
        }
    }

    /// Bodies of revolution.
    pub fn axisymmetric(self) -> bool {
        self == Self::Axisymmetric
    }
}

/// A path of an outline: corners with the names, between spaces, of the edge that leads there, and the
/// centre of an arc.
#[derive(Debug, Clone)]
pub struct Edge {
    pub to: Vector,
    pub name: &'static str,
    /// Centre of an arc, counter-clockwise.
    pub center: Option<Vector>,
    /// Number of cells, else the size of the outline.
    pub cells: Option<usize>,
}

/// The description of a mesh.
#[derive(Debug, Clone)]
pub enum Shape {
    Rectangle {
        from: Vector,
        to: Vector,
        cells: [usize; 2],
        diagonals: &'static str,
    },
    Ring {
        center: Vector,
        radii: [f64; 2],
        angles: Option<[f64; 2]>,
        cells: [usize; 2],
        ratio: f64,
    },
    /// Triangles inside a path.
    Outline {
        size: f64,
        from: Vector,
        edges: Vec<Edge>,
    },
    /// Triangles inside a circle, whose side is "round".
    Disc {
        size: f64,
        center: Vector,
        radius: f64,
        cells: Option<usize>,
    },
    /// A Gmsh file of that name with this text.
    File { name: String, text: String },
    /// Regions of the drawing of the problem.
    Region(Vec<&'static str>),
}

/// The whole facets of a side in a box.
#[derive(Debug, Clone)]
pub struct Patch {
    pub name: String,
    pub of: &'static str,
    pub low: Vector,
    pub high: Vector,
}

/// The place of a support.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    Side(String),
    /// The nearest node.
    Point(Vector),
}

/// A support: prescribed components, or the displacement along the outward normal.
#[derive(Debug, Clone)]
pub struct Support {
    pub place: Place,
    pub axes: [Option<Amount>; 2],
    pub normal: Option<Amount>,
    /// The support begins in the first step at or after this time, and holds the nodes where they are.
    pub from: Option<f64>,
}

/// An external load.
#[derive(Debug, Clone)]
pub enum Load {
    Traction {
        side: String,
        field: [Amount; 2],
    },
    Pressure {
        side: String,
        field: Amount,
    },
    Force {
        point: Vector,
        field: [Amount; 2],
    },
    /// The traction of the initial stress times a factor of time.
    InSitu {
        side: String,
        factor: Amount,
    },
}

/// A true circle behind a side.
#[derive(Debug, Clone)]
pub struct Circle {
    pub side: String,
    pub center: Vector,
    pub radius: f64,
}

/// One body.
#[derive(Debug, Clone)]
pub struct Body {
    pub name: String,
    pub shape: Shape,
    pub kind: Kind,
    pub patches: Vec<Patch>,
    pub young: f64,
    pub poisson: f64,
    pub thickness: f64,
    pub supports: Vec<Support>,
    pub loads: Vec<Load>,
    pub weight: [Amount; 2],
    pub circles: Vec<Circle>,
    pub more: More,
}

/// Further properties, which few bodies have.
#[derive(Debug, Clone, Default)]
pub struct More {
    pub springs: Vec<Spring>,
    /// Initial stress σxx, σyy, σzz, σxy, tension positive.
    pub initial: Option<[Amount; 4]>,
    /// The second material beyond the border; the group is that of the shape.
    pub beyond: Option<Beyond>,
    /// The body appears in the first step at or after this time.
    pub from: Option<f64>,
    pub couple: Option<Couple>,
    pub bar: Option<Bar>,
    /// Plasticity.
    pub metal: Option<Metal>,
}

/// The stress at which metal yields, and the slope of its hardening.
#[derive(Debug, Clone)]
pub struct Metal {
    pub yields: f64,
    pub hardening: f64,
}

/// A side that the case file couples to a point, which takes over its supports or its uniform tractions: a rigid side held by the
/// point, or the mean of the side, which bears the point's force. The checker treats both like the side without the couple.
#[derive(Debug, Clone)]
pub struct Couple {
    pub side: String,
    /// The middle of the side.
    pub point: Vector,
    /// Its area.
    pub area: f64,
    pub rigid: bool,
}

/// A spring along x at a node; or a bar from there to a node of another body that is held.
#[derive(Debug, Clone)]
pub struct Bar {
    pub at: Vector,
    pub stiffness: f64,
    pub to: Option<(String, Vector)>,
    pub gives: Option<Gives>,
}

/// Slackening and yielding of a bar.
#[derive(Debug, Clone)]
pub struct Gives {
    /// It bears no compression.
    pub slack: bool,
    /// It yields at this force.
    pub most: Option<f64>,
}

impl Bar {
    /// Its tension after these displacements of its node along x in turn: elongation beyond its strength is plastic, slackening is
    /// not.
    pub fn tension(&self, ways: impl Iterator<Item = f64>) -> f64 {
        let (slack, most) = match &self.gives {
            Some(gives) => (gives.slack, gives.most.unwrap_or(f64::INFINITY)),
            None => (false, f64::INFINITY),
        };
        let least = if slack { 0.0 } else { -most };
        let (mut plastic, mut tension) = (0.0, 0.0);
        for way in ways {
            let elastic = self.stiffness * (way - plastic);
            tension = elastic.max(least).min(most);
            if !(slack && elastic < 0.0) {
                plastic += (elastic - tension) / self.stiffness;
            }
        }
        tension
    }
}

/// Another material beyond a vertical border.
#[derive(Debug, Clone)]
pub struct Beyond {
    pub border: f64,
    pub young: f64,
    pub poisson: f64,
}

/// A bed under a side: stiffness per area, along its normal and across it.
#[derive(Debug, Clone)]
pub struct Spring {
    pub side: String,
    pub normal: f64,
    pub tangential: f64,
    pub compression_only: bool,
}

impl Body {
    /// E/(1 − ν²).
    pub fn plane_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }
}

/// A side of a body, by names; the names of several sides are joined by plus signs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Side {
    pub body: String,
    pub side: String,
}

/// A side of a body.
pub fn side(body: &str, side: &str) -> Side {
    Side {
        body: body.to_string(),
        side: side.to_string(),
    }
}

/// The surface of a rigid obstacle.
#[derive(Debug, Clone)]
pub enum Surface {
    /// Distance along the contact normal.
    Gap(Amount),
    /// The normal has length one and points towards the body.
    Plane { point: Vector, normal: Vector },
    Circle {
        center: Vector,
        radius: f64,
        inside: bool,
    },
}

/// The drive of an obstacle.
#[derive(Debug, Clone)]
pub enum Drive {
    Nothing,
    Displacement([Amount; 2]),
    Force([Amount; 2]),
}

/// The counterpart of a side in a contact.
#[derive(Debug, Clone)]
pub enum Against {
    /// The other side; named `nonmortar` and `mortar`, or only `sides`.
    Side {
        side: Side,
        chosen: bool,
    },
    Obstacle {
        surface: Surface,
        drive: Drive,
    },
}

/// The coupling of the sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pairing {
    Default,
    Mortar,
}

/// The initial gap.
#[derive(Debug, Clone)]
pub enum Gap {
    Default,
    Closed,
    Geometric,
    Given(Amount),
}

/// The law of the interface.
#[derive(Debug, Clone)]
pub enum Law {
    Frictionless,
    Coulomb(Amount),
    Tresca(Amount),
    Tied,
    /// Bears tension and shear until it parts or slips.
    Joint {
        coulomb: f64,
        cohesion: f64,
        tension: f64,
    },
}

impl Law {
    /// It bears shear up to a bound.
    pub fn rough(&self) -> bool {
        matches!(
            self,
            Self::Coulomb(_) | Self::Tresca(_) | Self::Joint { .. }
        )
    }
}

/// One contact.
#[derive(Debug, Clone)]
pub struct Contact {
    pub name: String,
    /// The nonmortar side, or the first of `sides`.
    pub own: Side,
    pub against: Against,
    pub pairing: Pairing,
    pub gap: Gap,
    pub law: Law,
}

/// Advance knowledge of the answer, from statics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// Some contact forces hold the load, with a margin.
    Holds,
    /// No contact forces hold the load of some step, with a margin.
    Falls,
    /// Unknown.
    Open,
}

/// A problem.
#[derive(Debug, Clone)]
pub struct Problem {
    pub family: &'static str,
    pub analysis: Analysis,
    pub bodies: Vec<Body>,
    pub contacts: Vec<Contact>,
    pub times: Vec<f64>,
    pub known: Known,
    /// The reason of `known`, for the report.
    pub reason: String,
    /// The pressure of all contacts, where it is known to be the same everywhere.
    pub uniform: Option<Amount>,
    /// Round bodies may spin: rounding decides how far a polygon turns until its next node touches.
    pub spins: bool,
    pub method: String,
    /// `[drawing]` of a case file.
    pub drawing: Option<Drawing>,
    pub sections: Vec<Section>,
    /// An equivalent problem, given by the family.
    pub other: Option<Box<Other>>,
    /// Steps, from 1, in which nothing has moved since the step before.
    pub idle: Vec<usize>,
    /// Number of steps that are taken from an earlier run.
    pub past: usize,
}

/// A rectangle that a vertical line divides into the regions "a" and "b".
#[derive(Debug, Clone)]
pub struct Drawing {
    pub from: Vector,
    pub to: Vector,
    pub border: f64,
    pub size: f64,
    pub cell: Kind,
}

/// Section forces of a body between two of its sides.
#[derive(Debug, Clone)]
pub struct Section {
    pub name: String,
    pub body: String,
    pub sides: [&'static str; 2],
    pub stations: Vec<Vector>,
}

/// An equivalent problem.
#[derive(Debug, Clone)]
pub struct Other {
    pub name: &'static str,
    pub problem: Problem,
    /// Its bodies that form each body of the original.
    pub parts: Vec<Vec<usize>>,
    /// Relative difference of displacements that is allowed.
    pub tolerance: f64,
}

impl Problem {
    /// Index of a body.
    pub fn body(&self, name: &str) -> usize {
        let place = self.bodies.iter().position(|body| body.name == name);
        place.unwrap_or_else(|| panic!("the generator names a body {name} that is not there"))
    }

    /// Some contact has friction.
    pub fn rough(&self) -> bool {
        self.contacts.iter().any(|contact| contact.law.rough())
    }

    /// Some contact follows Coulomb's law, which may have several answers.
    pub fn coulomb(&self) -> bool {
        let coulomb =
            |contact: &Contact| matches!(contact.law, Law::Coulomb(_) | Law::Joint { .. });
        self.contacts.iter().any(coulomb)
    }

    /// The case file.
    pub fn text(&self) -> String {
        let mut out = format!(
            "title    = \"campaign: {}\"\nanalysis = \"{}\"\n",
            self.family,
            self.analysis.name()
        );
        if let Some(drawing) = &self.drawing {
            write_drawing(&mut out, drawing);
        }
        for body in &self.bodies {
            write_body(&mut out, body, self.analysis);
        }
        for contact in &self.contacts {
            write_contact(&mut out, contact);
        }
        for body in &self.bodies {
            if let Some(Bar {
                at,
                stiffness,
                to: Some((other, to)),
                gives,
            }) = &body.more.bar
            {
                let long = (to[0] - at[0]).abs();
                line(
                    &mut out,
                    format_args!(
                        "\n[[bar]]\nname     = \"bar\"\nfrom     = {at:?}\nto       = {to:?}\n\
                         bodies   = {:?}\nyoung    = {:?}\narea     = 1.0",
                        [&body.name, other],
                        stiffness * long
                    ),
                );
                if let Some(most) = gives.as_ref().and_then(|gives| gives.most) {
                    line(&mut out, format_args!("yield    = {most:?}"));
                }
                if gives.as_ref().is_some_and(|gives| gives.slack) {
                    line(&mut out, format_args!("tension_only = true"));
                }
            }
        }
        for section in &self.sections {
            line(
                &mut out,
                format_args!(
                    "\n[[section]]\nname     = \"{}\"\nbody     = \"{}\"\nsides    = {:?}\nstations = {:?}",
                    section.name, section.body, section.sides, section.stations
                ),
            );
        }
        if self.method != "auto" {
            line(
                &mut out,
                format_args!("\n[solver]\nmethod = \"{}\"", self.method),
            );
        }
        if self.times != [1.0] {
            for time in &self.times {
                line(&mut out, format_args!("\n[[step]]\ntime = {time:?}"));
            }
        }
        out
    }
}

/// Writing to a String cannot fail.
fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = writeln!(out, "{text}");
}

fn write_drawing(out: &mut String, drawing: &Drawing) {
    let Drawing {
        from: [x, y],
        to: [z, w],
        border,
        size,
        cell,
    } = drawing;
    let cell = cell.name();
    let high = 0.5 * (y + w);
    line(
        out,
        format_args!(
            "\n[drawing]\ncell    = \"{cell}\"\nsize    = {size:?}\nlines   = [{{ from = [{x:?}, {y:?}], edges = [\
             {{ to = [{border:?}, {y:?}], name = \"bottom\" }}, {{ to = [{z:?}, {y:?}], name = \"bottom\" }}, \
             {{ to = [{z:?}, {w:?}], name = \"right\" }}, {{ to = [{border:?}, {w:?}], name = \"top\" }}, \
             {{ to = [{x:?}, {w:?}], name = \"top\" }}, {{ to = [{x:?}, {y:?}], name = \"left\" }}] }}, \
             {{ from = [{border:?}, {y:?}], to = [{border:?}, {w:?}], name = \"border\" }}]\n\
             regions = [{{ name = \"a\", at = [{:?}, {high:?}] }}, {{ name = \"b\", at = [{:?}, {high:?}] }}]",
            0.5 * (x + border),
            0.5 * (border + z)
        ),
    );
}

fn write_body(out: &mut String, body: &Body, analysis: Analysis) {
    line(
        out,
        format_args!("\n[[body]]\nname     = \"{}\"", body.name),
    );
    let patches: Vec<String> = body
        .patches
        .iter()
        .map(|p| {
            format!(
                "{} = {{ of = \"{}\", min = {:?}, max = {:?} }}",
                p.name, p.of, p.low, p.high
            )
        })
        .collect();
    let patches = match patches.len() {
        0 => String::new(),
        _ => format!(", sides = {{ {} }}", patches.join(", ")),
    };
    line(
        out,
        format_args!("mesh     = {{ {}{patches} }}", shape(body)),
    );
    let thickness = match analysis {
        Analysis::Axisymmetric => String::new(),
        _ if body.thickness == 1.0 => String::new(),
        _ => format!(", thickness = {:?}", body.thickness),
    };
    let material = |group: &str, young: f64, poisson: f64| {
        format!("{{ {group}young = {young:?}, poisson = {poisson:?}{thickness} }}")
    };
    let metal = body.more.metal.as_ref();
    let metal = metal.map_or(String::new(), |Metal { yields, hardening }| {
        format!("strength = {{ yield = {yields:?} }}, plastic = true, hardening = {hardening:?}, ")
    });
    let plain = material(&metal, body.young, body.poisson);
    let materials = match &body.more.beyond {
        None => plain,
        Some(Beyond { young, poisson, .. }) => {
            format!(
                "[{plain}, {}]",
                material("group = \"b\", ", *young, *poisson)
            )
        }
    };
    line(out, format_args!("material = {materials}"));
    if let Some(from) = body.more.from {
        line(out, format_args!("active   = {{ from = {from:?} }}"));
    }
    if let Some([xx, yy, zz, xy]) = &body.more.initial {
        let [xx, yy, zz, xy] = [xx, yy, zz, xy].map(Amount::text);
        line(
            out,
            format_args!("initial_stress = {{ xx = {xx}, yy = {yy}, zz = {zz}, xy = {xy} }}"),
        );
    }
    let mut springs: Vec<String> = body.more.springs.iter().map(spring).collect();
    if let Some(Bar {
        at,
        stiffness,
        to: None,
        ..
    }) = &body.more.bar
    {
        springs.push(format!("{{ point = {at:?}, x = {stiffness:?} }}"));
    }
    if !springs.is_empty() {
        line(out, format_args!("spring   = [{}]", springs.join(", ")));
    }
    if let Some(couple) = &body.more.couple {
        let kind = if couple.rigid { "rigid" } else { "average" };
        line(
            out,
            format_args!(
                "points   = {{ c = {:?} }}\ncouple   = [{{ side = \"{}\", point = \"c\", kind = \"{kind}\" }}]",
                couple.point, couple.side
            ),
        );
    }
    if !body.supports.is_empty() {
        let each = body.supports.iter().map(|s| support(s, &body.more.couple));
        let each: Vec<String> = each.collect();
        line(out, format_args!("fix      = [{}]", each.join(", ")));
    }
    if !body.loads.is_empty() {
        let each = body.loads.iter().map(|l| load(l, &body.more.couple));
        let each: Vec<String> = each.collect();
        line(out, format_args!("load     = [{}]", each.join(", ")));
    }
    if body.weight.iter().any(|w| !w.is_zero()) {
        line(out, format_args!("body_force = {}", pair(&body.weight)));
    }
    if !body.circles.is_empty() {
        let each: Vec<String> = body
            .circles
            .iter()
            .map(|c| {
                format!(
                    "{} = {{ circle = {{ center = {:?}, radius = {:?} }} }}",
                    c.side, c.center, c.radius
                )
            })
            .collect();
        line(out, format_args!("surface  = {{ {} }}", each.join(", ")));
    }
}

fn shape(body: &Body) -> String {
    let cell = body.kind.name();
    match &body.shape {
        Shape::Rectangle {
            from,
            to,
            cells,
            diagonals,
        } => format!(
            "rectangle = {{ from = {from:?}, to = {to:?}, cells = {cells:?}, cell = \"{cell}\", diagonals = \"{diagonals}\" }}"
        ),
        Shape::Ring {
            center,
            radii,
            angles,
            cells,
            ratio,
        } => {
            let part = match angles {
                Some([from, to]) => format!("from = {from:?}, to = {to:?}, "),
                None => String::new(),
            };
            format!(
                "ring = {{ center = {center:?}, inner = {:?}, outer = {:?}, {part}cells = {cells:?}, ratio = {ratio:?}, cell = \"{cell}\" }}",
                radii[0], radii[1]
            )
        }
        Shape::Outline { size, from, edges } => {
            let each: Vec<String> = edges.iter().map(edge).collect();
            format!(
                "outline = {{ size = {size:?}, cell = \"{cell}\", from = {from:?}, edges = [{}] }}",
                each.join(", ")
            )
        }
        Shape::Disc {
            size,
            center,
            radius,
            cells,
        } => {
            let cells = cells.map_or(String::new(), |n| format!(", cells = {n}"));
            format!(
                "outline = {{ size = {size:?}, cell = \"{cell}\", circle = {{ center = {center:?}, radius = {radius:?}, name = \"round\"{cells} }} }}"
            )
        }
        Shape::File { name, .. } => format!("file = {{ path = \"{name}\" }}"),
        Shape::Region(names) => format!("region = {names:?}"),
    }
}

fn edge(edge: &Edge) -> String {
    let arc = edge
        .center
        .map_or(String::new(), |c| format!(", center = {c:?}"));
    let cells = edge
        .cells
        .map_or(String::new(), |n| format!(", cells = {n}"));
    let names = quoted(edge.name.split(' '));
    format!("{{ to = {:?}, name = {names}{arc}{cells} }}", edge.to)
}

fn support(support: &Support, couple: &Option<Couple>) -> String {
    let rigid = |side: &String| couple.as_ref().is_some_and(|c| c.rigid && c.side == *side);
    let mut keys = vec![match &support.place {
        Place::Side(side) if rigid(side) => "point = \"c\", rotation = 0".to_string(),
        Place::Side(side) => format!("side = \"{side}\""),
        Place::Point(point) => format!("point = {point:?}"),
    }];
    let named = support.axes.iter().zip(["x", "y"]);
    for (value, name) in named.chain([(&support.normal, "normal")]) {
        keys.extend(value.as_ref().map(|v| format!("{name} = {}", v.text())));
    }
    if let Some(from) = support.from {
        keys.push(format!("active = {{ from = {from:?} }}"));
    }
    format!("{{ {} }}", keys.join(", "))
}

fn spring(spring: &Spring) -> String {
    format!(
        "{{ side = \"{}\", normal = {:?}, tangential = {:?}, compression_only = {} }}",
        spring.side, spring.normal, spring.tangential, spring.compression_only
    )
}

fn load(load: &Load, couple: &Option<Couple>) -> String {
    match load {
        Load::Traction { side, field }
            if couple.as_ref().is_some_and(|c| !c.rigid && c.side == *side) =>
        {
            let area = couple.as_ref().map_or(1.0, |c| c.area);
            let force = field.each_ref().map(|f| f.times(area));
            format!("{{ point = \"c\", force = {} }}", pair(&force))
        }
        Load::Traction { side, field } => {
            format!("{{ side = \"{side}\", traction = {} }}", pair(field))
        }
        Load::Pressure { side, field } => {
            format!("{{ side = \"{side}\", pressure = {} }}", field.text())
        }
        Load::Force { point, field } => {
            format!("{{ point = {point:?}, force = {} }}", pair(field))
        }
        Load::InSitu { side, factor } => {
            format!("{{ side = \"{side}\", in_situ = {} }}", factor.text())
        }
    }
}

fn pair(field: &[Amount; 2]) -> String {
    format!("[{}, {}]", field[0].text(), field[1].text())
}

fn write_contact(out: &mut String, contact: &Contact) {
    let own = named(&contact.own);
    line(
        out,
        format_args!("\n[[contact]]\nname      = \"{}\"", contact.name),
    );
    match &contact.against {
        Against::Side { side, chosen } => {
            let other = named(side);
            if *chosen {
                line(out, format_args!("sides     = [{own}, {other}]"));
            } else {
                line(out, format_args!("nonmortar = {own}\nmortar    = {other}"));
            }
        }
        Against::Obstacle { surface, drive } => {
            let surface = match surface {
                Surface::Gap(gap) => format!("gap = {}", gap.text()),
                Surface::Plane { point, normal } => {
                    format!("plane = {{ point = {point:?}, normal = {normal:?} }}")
                }
                Surface::Circle {
                    center,
                    radius,
                    inside,
                } => format!(
                    "circle = {{ center = {center:?}, radius = {radius:?}, inside = {inside} }}"
                ),
            };
            let drive = match drive {
                Drive::Nothing => String::new(),
                Drive::Displacement(field) => format!(", displacement = {}", pair(field)),
                Drive::Force(field) => format!(", force = {}", pair(field)),
            };
            line(
                out,
                format_args!("nonmortar = {own}\nobstacle  = {{ {surface}{drive} }}"),
            );
        }
    }
    if contact.pairing == Pairing::Mortar {
        line(out, format_args!("pairing   = \"mortar\""));
    }
    match &contact.gap {
        Gap::Default => {}
        Gap::Closed => line(out, format_args!("gap       = \"closed\"")),
        Gap::Geometric => line(out, format_args!("gap       = \"geometric\"")),
        Gap::Given(gap) => line(out, format_args!("gap       = {}", gap.text())),
    }
    match &contact.law {
        Law::Frictionless => {}
        Law::Coulomb(value) => line(out, format_args!("friction  = {}", value.text())),
        Law::Tresca(value) => {
            line(
                out,
                format_args!("friction  = {{ tresca = {} }}", value.text()),
            );
        }
        Law::Tied => line(out, format_args!("tied      = true")),
        Law::Joint {
            coulomb,
            cohesion,
            tension,
        } => line(
            out,
            format_args!(
                "friction  = {{ coulomb = {coulomb:?}, cohesion = {cohesion:?}, tension = {tension:?} }}"
            ),
        ),
    }
}

/// A side, or a list of sides, in quotes.
fn named(side: &Side) -> String {
    quoted(side.side.split('+').map(|s| format!("{}.{s}", side.body)))
}

/// A name, or a list of names, in quotes.
fn quoted(names: impl Iterator<Item = impl std::fmt::Debug>) -> String {
    match &names.collect::<Vec<_>>()[..] {
        [one] => format!("{one:?}"),
        several => format!("{several:?}"),
    }
}

/// A support that holds one axis of a side or a point.
pub fn hold(place: Place, axis: usize) -> Support {
    moved(place, axis, Amount::from(0.0))
}

/// A support that moves one axis of a side or a point.
pub fn moved(place: Place, axis: usize, value: Amount) -> Support {
    let mut axes = [None, None];
    axes[axis] = Some(value);
    Support {
        place,
        axes,
        normal: None,
        from: None,
    }
}

/// A support that holds all components of a place.
pub fn clamp(place: Place) -> Support {
    Support {
        place,
        axes: [Some(Amount::from(0.0)), Some(Amount::from(0.0))],
        normal: None,
        from: None,
    }
}

/// A side as a place.
pub fn on(side: &str) -> Place {
    Place::Side(side.to_string())
}

/// Times 1, 2, .. of some steps.
pub fn steps(count: usize) -> Vec<f64> {
    (1..=count).map(|step| step as f64).collect()
}
