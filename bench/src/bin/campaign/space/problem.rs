//! A contact problem of space as plain data, its case file, and the same problem turned and scaled.

use super::geometry::{Matrix, Vector, applied, dot, plus};
use super::solids::Solid;
use super::{Mesh, gmsh};
use crate::amount::{Amount, moved_vector};
use crate::problem::{Known, Pairing, Side};
use crate::random::Random;
use crate::raw::Cell;
use std::fmt::Write;

/// A number that may depend on place and time.
pub type Number = Amount<3>;

/// A vector that may depend on place and time.
pub type Field = [Number; 3];

/// The description of a mesh.
#[derive(Debug, Clone)]
pub enum Shape {
    Cuboid {
        from: Vector,
        to: Vector,
        cells: [usize; 3],
    },
    Cylinder {
        base: Vector,
        axis: Vector,
        radii: [f64; 2],
        height: f64,
        cells: [usize; 3],
    },
    Ball {
        center: Vector,
        radius: f64,
        cells: [usize; 2],
    },
    /// A polygon with the names of its edges, filled with triangles and carried along z.
    Column {
        corners: Vec<[f64; 2]>,
        names: Vec<&'static str>,
        size: f64,
        height: f64,
        layers: usize,
    },
    /// A Gmsh file of that name with this text.
    File { name: String, text: String },
}

/// The prescribed part of the displacement: all components, or the one along the outward normal.
#[derive(Debug, Clone)]
pub enum Held {
    All(Field),
    Normal(Number),
}

/// An external load.
#[derive(Debug, Clone)]
pub enum Load {
    Traction { side: String, field: Field },
    Pressure { side: String, field: Number },
}

/// The form of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Plane,
    Sphere,
    Cylinder,
}

/// A surface, true or rigid. `point`: a point of the plane, the centre of the sphere, or a point of the cylinder's axis. `axis`: the
/// unit normal of the plane towards the body, zero for the sphere, or the unit direction of the cylinder's axis.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    pub form: Form,
    pub point: Vector,
    pub axis: Vector,
    pub radius: f64,
}

impl Surface {
    pub fn plane(point: Vector, normal: Vector) -> Self {
        Self {
            form: Form::Plane,
            point,
            axis: normal,
            radius: 0.0,
        }
    }

    pub fn sphere(point: Vector, radius: f64) -> Self {
        Self {
            form: Form::Sphere,
            point,
            axis: [0.0; 3],
            radius,
        }
    }

    pub fn cylinder(point: Vector, axis: Vector, radius: f64) -> Self {
        Self {
            form: Form::Cylinder,
            point,
            axis,
            radius,
        }
    }
}

/// One body.
#[derive(Debug, Clone)]
pub struct Body {
    pub name: String,
    pub shape: Shape,
    pub kind: Solid,
    pub young: f64,
    pub poisson: f64,
    /// By side.
    pub supports: Vec<(String, Held)>,
    pub loads: Vec<Load>,
    pub weight: Field,
    /// True surfaces behind sides.
    pub surfaces: Vec<(String, Surface)>,
}

impl Body {
    /// E/(1 − ν²).
    pub fn plane_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }
}

/// The drive of an obstacle.
#[derive(Debug, Clone)]
pub enum Drive {
    Displacement(Field),
    Force(Field),
}

/// The counterpart of a side in a contact.
#[derive(Debug, Clone)]
pub enum Against {
    /// The other side; named `nonmortar` and `mortar`, or only `sides`.
    Side { side: Side, chosen: bool },
    Obstacle {
        surface: Surface,
        /// The body is inside the sphere or the cylinder.
        inside: bool,
        drive: Option<Drive>,
    },
}

/// The initial gap.
#[derive(Debug, Clone, Copy)]
pub enum Gap {
    Default,
    Closed,
    Geometric,
    Given(f64),
}

/// The law of the interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    Frictionless,
    Coulomb(f64),
    Tresca(f64),
    Tied,
}

impl Law {
    /// It bears shear up to a bound.
    pub fn rough(self) -> bool {
        matches!(self, Self::Coulomb(_) | Self::Tresca(_))
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

/// A problem.
#[derive(Debug, Clone)]
pub struct Problem {
    pub family: &'static str,
    pub bodies: Vec<Body>,
    pub contacts: Vec<Contact>,
    pub times: Vec<f64>,
    pub known: Known,
    /// The reason of `known`, for the report.
    pub reason: String,
    /// The pressure of all contacts, where it is known to be the same everywhere.
    pub uniform: Option<f64>,
    /// Round bodies may spin: rounding decides how far a polyhedron turns until its next node touches.
    pub spins: bool,
    pub method: String,
}

/// A field that is the same everywhere and always.
pub fn constant(v: Vector) -> Field {
    v.map(Number::from)
}

/// A rotation, a translation, and a change of the units of length and force.
#[derive(Debug, Clone, Copy)]
pub struct Carry {
    /// Rows of the rotation.
    pub turn: Matrix,
    pub lengths: f64,
    pub forces: f64,
    /// The new place of the origin.
    pub shift: Vector,
}

impl Carry {
    /// The new place of a point.
    pub fn point(&self, x: Vector) -> Vector {
        plus(self.shift, self.lengths, applied(self.turn, x))
    }

    fn number(&self, number: &Number, factor: f64) -> Number {
        self.shifted(number.moved(factor, self.lengths, self.turn))
    }

    fn field(&self, field: &Field, factor: f64) -> Field {
        moved_vector(field, factor, self.lengths, self.turn).map(|c| self.shifted(c))
    }

    fn shifted(&self, mut number: Number) -> Number {
        for term in &mut number.0 {
            term.constant -= dot(term.slope, self.shift);
        }
        number
    }

    fn surface(&self, surface: Surface) -> Surface {
        Surface {
            point: self.point(surface.point),
            axis: applied(self.turn, surface.axis),
            radius: surface.radius * self.lengths,
            ..surface
        }
    }
}

impl Problem {
    /// Index of a body.
    pub fn body(&self, name: &str) -> usize {
        let place = self.bodies.iter().position(|body| body.name == name);
        place.unwrap_or_else(|| panic!("the generator names a body {name} that is not there"))
    }

    /// The same problem, moved and in other units, its meshes as files.
    pub fn carried(&self, meshes: &[Mesh], carry: &Carry) -> Self {
        let stress = carry.forces / (carry.lengths * carry.lengths);
        let mut other = self.clone();
        other.uniform = self.uniform.map(|p| p * stress);
        for (body, mesh) in other.bodies.iter_mut().zip(meshes) {
            body.young *= stress;
            body.weight = carry.field(&body.weight, stress / carry.lengths);
            for (_, held) in &mut body.supports {
                match held {
                    Held::All(field) => *field = carry.field(field, carry.lengths),
                    Held::Normal(number) => *number = carry.number(number, carry.lengths),
                }
            }
            for load in &mut body.loads {
                match load {
                    Load::Traction { field, .. } => *field = carry.field(field, stress),
                    Load::Pressure { field, .. } => *field = carry.number(field, stress),
                }
            }
            for (_, surface) in &mut body.surfaces {
                *surface = carry.surface(*surface);
            }
            body.shape = Shape::File {
                name: format!("{}.msh", body.name),
                text: gmsh(mesh, |x| carry.point(x)),
            };
        }
        for contact in &mut other.contacts {
            if let Gap::Given(gap) = &mut contact.gap {
                *gap *= carry.lengths;
            }
            if let Law::Tresca(bound) = &mut contact.law {
                *bound *= stress;
            }
            if let Against::Obstacle { surface, drive, .. } = &mut contact.against {
                *surface = carry.surface(*surface);
                match drive {
                    Some(Drive::Displacement(field)) => *field = carry.field(field, carry.lengths),
                    Some(Drive::Force(field)) => *field = carry.field(field, carry.forces),
                    None => {}
                }
            }
        }
        other
    }

    /// The case file.
    pub fn text(&self) -> String {
        let mut out = format!(
            "title    = \"campaign: {}\"\nanalysis = \"3d\"\n",
            self.family
        );
        // writing to a String cannot fail
        let mut line = |text: String| {
            let _ = writeln!(out, "{text}");
        };
        for body in &self.bodies {
            line(format!("\n[[body]]\nname     = \"{}\"", body.name));
            line(format!("mesh     = {{ {} }}", shape(body)));
            let (young, poisson) = (body.young, body.poisson);
            line(format!(
                "material = {{ young = {young:?}, poisson = {poisson:?} }}"
            ));
            if !body.supports.is_empty() {
                let each: Vec<String> = body.supports.iter().map(support).collect();
                line(format!("fix      = [{}]", each.join(", ")));
            }
            if !body.loads.is_empty() {
                let each: Vec<String> = body.loads.iter().map(load).collect();
                line(format!("load     = [{}]", each.join(", ")));
            }
            if body.weight.iter().any(|w| !w.is_zero()) {
                line(format!("body_force = {}", triple(&body.weight)));
            }
            if !body.surfaces.is_empty() {
                let each: Vec<String> = body
                    .surfaces
                    .iter()
                    .map(|(side, s)| format!("{side} = {{ {} }}", surface(s, None)))
                    .collect();
                line(format!("surface  = {{ {} }}", each.join(", ")));
            }
        }
        for contact in &self.contacts {
            contact_lines(contact, &mut line);
        }
        if self.method != "auto" {
            line(format!("\n[solver]\nmethod = \"{}\"", self.method));
        }
        if self.times != [1.0] {
            for time in &self.times {
                line(format!("\n[[step]]\ntime = {time:?}"));
            }
        }
        out
    }
}

fn shape(body: &Body) -> String {
    let cell = body.kind.name();
    match &body.shape {
        Shape::Cuboid { from, to, cells } => {
            format!(
                "box = {{ from = {from:?}, to = {to:?}, cells = {cells:?}, cell = \"{cell}\" }}"
            )
        }
        Shape::Cylinder {
            base,
            axis,
            radii: [inner, outer],
            height,
            cells,
        } => format!(
            "cylinder = {{ base = {base:?}, axis = {axis:?}, radius = {outer:?}, inner = {inner:?}, height = {height:?}, cells = {cells:?}, cell = \"{cell}\" }}"
        ),
        Shape::Ball {
            center,
            radius,
            cells,
        } => format!(
            "sphere = {{ center = {center:?}, radius = {radius:?}, cells = {cells:?}, cell = \"{cell}\" }}"
        ),
        Shape::Column {
            corners,
            names,
            size,
            height,
            layers,
        } => {
            let ends = corners.iter().cycle().skip(1);
            let edges = ends
                .zip(names)
                .map(|(to, name)| format!("{{ to = {to:?}, name = \"{name}\" }}"));
            let edges: Vec<String> = edges.collect();
            let flat = if body.kind.linear() { "tri3" } else { "tri6" };
            format!(
                "extrude = {{ mesh = {{ outline = {{ size = {size:?}, cell = \"{flat}\", from = {:?}, edges = [{}] }} }}, height = {height:?}, layers = {layers} }}",
                corners[0],
                edges.join(", ")
            )
        }
        Shape::File { name, .. } => format!("file = {{ path = \"{name}\" }}"),
    }
}

fn surface(surface: &Surface, inside: Option<bool>) -> String {
    let Surface {
        point,
        axis,
        radius,
        form,
    } = surface;
    let inside = inside.map_or(String::new(), |i| format!(", inside = {i}"));
    match form {
        Form::Plane => format!("plane = {{ point = {point:?}, normal = {axis:?} }}"),
        Form::Sphere => format!("sphere = {{ center = {point:?}, radius = {radius:?}{inside} }}"),
        Form::Cylinder => format!(
            "cylinder = {{ point = {point:?}, axis = {axis:?}, radius = {radius:?}{inside} }}"
        ),
    }
}

fn support((side, held): &(String, Held)) -> String {
    let held = match held {
        Held::All([x, y, z]) => format!("x = {}, y = {}, z = {}", x.text(), y.text(), z.text()),
        Held::Normal(value) => format!("normal = {}", value.text()),
    };
    format!("{{ side = \"{side}\", {held} }}")
}

fn load(load: &Load) -> String {
    match load {
        Load::Traction { side, field } => {
            format!("{{ side = \"{side}\", traction = {} }}", triple(field))
        }
        Load::Pressure { side, field } => {
            format!("{{ side = \"{side}\", pressure = {} }}", field.text())
        }
    }
}

fn triple(field: &Field) -> String {
    let [x, y, z] = field.each_ref().map(Number::text);
    format!("[{x}, {y}, {z}]")
}

fn contact_lines(contact: &Contact, line: &mut impl FnMut(String)) {
    let own = format!("{}.{}", contact.own.body, contact.own.side);
    line(format!("\n[[contact]]\nname      = \"{}\"", contact.name));
    match &contact.against {
        Against::Side { side, chosen } => {
            let other = format!("{}.{}", side.body, side.side);
            line(match chosen {
                true => format!("sides     = [\"{own}\", \"{other}\"]"),
                false => format!("nonmortar = \"{own}\"\nmortar    = \"{other}\""),
            });
        }
        Against::Obstacle {
            surface: rigid,
            inside,
            drive,
        } => {
            let drive = match drive {
                None => String::new(),
                Some(Drive::Displacement(field)) => format!(", displacement = {}", triple(field)),
                Some(Drive::Force(field)) => format!(", force = {}", triple(field)),
            };
            let rigid = surface(rigid, Some(*inside));
            line(format!(
                "nonmortar = \"{own}\"\nobstacle  = {{ {rigid}{drive} }}"
            ));
        }
    }
    if contact.pairing == Pairing::Mortar {
        line("pairing   = \"mortar\"".to_string());
    }
    match contact.gap {
        Gap::Default => {}
        Gap::Closed => line("gap       = \"closed\"".to_string()),
        Gap::Geometric => line("gap       = \"geometric\"".to_string()),
        Gap::Given(gap) => line(format!("gap       = {gap:?}")),
    }
    match contact.law {
        Law::Frictionless => {}
        Law::Coulomb(value) => line(format!("friction  = {value:?}")),
        Law::Tresca(value) => line(format!("friction  = {{ tresca = {value:?} }}")),
        Law::Tied => line("tied      = true".to_string()),
    }
}

/// Moves the nodes of a cuboid at random by this part of a cell, those on its faces along them, and puts the nodes between
/// corners in their middles: cells become skew, facets tapered.
pub fn jitter(body: &Body, mesh: &mut Mesh, part: f64, random: &mut Random) {
    let Shape::Cuboid { from, to, cells } = body.shape else {
        return;
    };
    let mut moved: Vec<Vector> = mesh.points.clone();
    for x in &mut moved {
        let by: Vector = std::array::from_fn(|d| {
            let size = to[d] - from[d];
            let inside = (x[d] - from[d]).min(to[d] - x[d]) > 1e-9 * size;
            let by = part * size / cells[d] as f64 * random.between(-1.0, 1.0);
            if inside { by } else { 0.0 }
        });
        *x = plus(*x, 1.0, by);
    }
    for (kind, nodes) in &mesh.cells {
        let corners: Vec<Vector> = nodes[..kind.corners().len()]
            .iter()
            .map(|&n| moved[n])
            .collect();
        for (&node, place) in nodes.iter().zip(kind.places(&corners)) {
            mesh.points[node] = place;
        }
    }
}
