//! A contact problem of the plane or of space as plain data.
//!
//! Generators write it; the checker reads loads, supports and contacts from it; [`case`](crate::case) makes a case file of it.
//! Meshes are described here, not made: the checker takes points, cells and sides from the program's mesh.

use crate::amount::Amount;
use crate::cells::Kind;

/// A vector that may depend on place and time.
pub type Field<const D: usize = 2> = [Amount<D>; D];

/// A field that is the same everywhere and always.
pub fn constant<const D: usize>(v: [f64; D]) -> Field<D> {
    v.map(Amount::from)
}

/// Kind of analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Analysis {
    PlaneStrain,
    PlaneStress,
    Axisymmetric,
    Space,
}

impl Analysis {
    /// The name in a case file.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlaneStrain => "plane-strain",
            Self::PlaneStress => "plane-stress",
            Self::Axisymmetric => "axisymmetric",
            Self::Space => "3d",
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
    pub to: [f64; 2],
    pub name: &'static str,
    /// Centre of an arc, counter-clockwise.
    pub center: Option<[f64; 2]>,
    /// Number of cells, else the size of the outline.
    pub cells: Option<usize>,
}

/// The description of a mesh.
#[derive(Debug, Clone)]
pub enum Shape<const D: usize = 2> {
    /// A rectangle or a box; the diagonals of the cells of a rectangle have a pattern.
    Block {
        from: [f64; D],
        to: [f64; D],
        cells: [usize; D],
        diagonals: &'static str,
    },
    Ring {
        center: [f64; 2],
        radii: [f64; 2],
        angles: Option<[f64; 2]>,
        cells: [usize; 2],
        ratio: f64,
    },
    /// Triangles inside a path.
    Outline {
        size: f64,
        from: [f64; 2],
        edges: Vec<Edge>,
    },
    /// Triangles inside a circle, whose side is "round".
    Disc {
        size: f64,
        center: [f64; 2],
        radius: f64,
        cells: Option<usize>,
    },
    Cylinder {
        base: [f64; 3],
        axis: [f64; 3],
        radii: [f64; 2],
        height: f64,
        cells: [usize; 3],
    },
    Ball {
        center: [f64; 3],
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
    /// Regions of the drawing of the problem.
    Region(Vec<&'static str>),
}

/// The whole facets of a side in a box.
#[derive(Debug, Clone)]
pub struct Patch<const D: usize = 2> {
    pub name: String,
    pub of: &'static str,
    pub low: [f64; D],
    pub high: [f64; D],
}

/// The place of a support.
#[derive(Debug, Clone, PartialEq)]
pub enum Place<const D: usize = 2> {
    Side(String),
    /// The nearest node.
    Point([f64; D]),
}

/// A support: prescribed components, or the displacement along the outward normal.
#[derive(Debug, Clone)]
pub struct Support<const D: usize = 2> {
    pub place: Place<D>,
    pub axes: [Option<Amount<D>>; D],
    pub normal: Option<Amount<D>>,
    /// The support begins in the first step at or after this time, and holds the nodes where they are.
    pub from: Option<f64>,
}

/// An external load.
#[derive(Debug, Clone)]
pub enum Load<const D: usize = 2> {
    Traction {
        side: String,
        field: Field<D>,
    },
    Pressure {
        side: String,
        field: Amount<D>,
    },
    Force {
        point: [f64; D],
        field: Field<D>,
    },
    /// The traction of the initial stress times a factor of time.
    InSitu {
        side: String,
        factor: Amount<D>,
    },
}

impl<const D: usize> Load<D> {
    /// The side that it acts on.
    pub fn side(&self) -> Option<&str> {
        match self {
            Self::Traction { side, .. } | Self::Pressure { side, .. } => Some(side),
            Self::InSitu { side, .. } => Some(side),
            Self::Force { .. } => None,
        }
    }
}

/// One body.
#[derive(Debug, Clone)]
pub struct Body<const D: usize = 2> {
    pub name: String,
    pub shape: Shape<D>,
    pub kind: Kind,
    pub patches: Vec<Patch<D>>,
    pub young: f64,
    pub poisson: f64,
    /// One in space.
    pub thickness: f64,
    pub supports: Vec<Support<D>>,
    pub loads: Vec<Load<D>>,
    pub weight: Field<D>,
    /// True surfaces behind sides.
    pub surfaces: Vec<(String, Surface<D>)>,
    pub more: More<D>,
}

/// Further properties, which few bodies have.
#[derive(Debug, Clone)]
pub struct More<const D: usize = 2> {
    pub springs: Vec<Spring>,
    /// Initial stress σxx, σyy, σzz, σxy, tension positive.
    pub initial: Option<[Amount<D>; 4]>,
    /// The second material beyond the border; the group is that of the shape.
    pub beyond: Option<Beyond>,
    /// The body appears in the first step at or after this time.
    pub from: Option<f64>,
    pub couple: Option<Couple<D>>,
    pub bar: Option<Bar<D>>,
    /// Plasticity.
    pub metal: Option<Metal>,
}

impl<const D: usize> Default for More<D> {
    fn default() -> Self {
        Self {
            springs: Vec::new(),
            initial: None,
            beyond: None,
            from: None,
            couple: None,
            bar: None,
            metal: None,
        }
    }
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
pub struct Couple<const D: usize = 2> {
    pub side: String,
    /// The middle of the side.
    pub point: [f64; D],
    /// Its area.
    pub area: f64,
    pub rigid: bool,
}

/// A spring along x at a node; or a bar from there to a node of another body that is held.
#[derive(Debug, Clone)]
pub struct Bar<const D: usize = 2> {
    pub at: [f64; D],
    pub stiffness: f64,
    pub to: Option<(String, [f64; D])>,
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

impl<const D: usize> Bar<D> {
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

impl<const D: usize> Body<D> {
    /// A body of a material, without supports and loads.
    pub fn new(name: &str, shape: Shape<D>, kind: Kind, [young, poisson]: [f64; 2]) -> Self {
        Self {
            name: name.to_string(),
            shape,
            kind,
            patches: Vec::new(),
            young,
            poisson,
            thickness: 1.0,
            supports: Vec::new(),
            loads: Vec::new(),
            weight: std::array::from_fn(|_| Amount::default()),
            surfaces: Vec::new(),
            more: More::default(),
        }
    }

    /// E/(1 − ν²).
    pub fn plane_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }

    /// It has appeared.
    pub fn there(&self, t: f64) -> bool {
        self.more.from.is_none_or(|from| t >= from)
    }

    /// A traction on a side.
    pub fn pull(&mut self, side: &str, field: Field<D>) {
        let side = side.to_string();
        self.loads.push(Load::Traction { side, field });
    }

    /// A pressure on a side.
    pub fn press(&mut self, side: &str, field: Amount<D>) {
        let side = side.to_string();
        self.loads.push(Load::Pressure { side, field });
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

/// A surface: that of a rigid obstacle, or the true one behind a side.
#[derive(Debug, Clone)]
pub enum Surface<const D: usize = 2> {
    /// Distance along the contact normal.
    Gap(Amount<D>),
    /// The normal has length one and points towards the body.
    Plane { point: [f64; D], normal: [f64; D] },
    /// A circle or a sphere; `inside` is where the body of an obstacle is.
    Round {
        center: [f64; D],
        radius: f64,
        inside: bool,
    },
    /// The axis has length one.
    Cylinder {
        point: [f64; D],
        axis: [f64; D],
        radius: f64,
        inside: bool,
    },
}

/// The true circle or sphere behind a side.
pub fn round<const D: usize>(side: &str, center: [f64; D], radius: f64) -> (String, Surface<D>) {
    let surface = Surface::Round {
        center,
        radius,
        inside: false,
    };
    (side.to_string(), surface)
}

/// The drive of an obstacle.
#[derive(Debug, Clone)]
pub enum Drive<const D: usize = 2> {
    Nothing,
    Displacement(Field<D>),
    Force(Field<D>),
}

/// The counterpart of a side in a contact.
#[derive(Debug, Clone)]
pub enum Against<const D: usize = 2> {
    /// The other side; named `nonmortar` and `mortar`, or only `sides`.
    Side { side: Side, chosen: bool },
    Obstacle {
        surface: Surface<D>,
        drive: Drive<D>,
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
pub enum Gap<const D: usize = 2> {
    Default,
    Closed,
    Geometric,
    Given(Amount<D>),
}

/// The law of the interface.
#[derive(Debug, Clone, PartialEq)]
pub enum Law<const D: usize = 2> {
    Frictionless,
    Coulomb(Amount<D>),
    Tresca(Amount<D>),
    Tied,
    /// Bears tension and shear until it parts or slips.
    Joint {
        coulomb: f64,
        cohesion: f64,
        tension: f64,
    },
}

impl<const D: usize> Law<D> {
    /// Coulomb's law with a coefficient that is the same everywhere and always, or no friction.
    pub fn rubbing(coefficient: f64) -> Self {
        match coefficient > 0.0 {
            true => Self::Coulomb(Amount::from(coefficient)),
            false => Self::Frictionless,
        }
    }

    /// It bears shear up to a bound.
    pub fn rough(&self) -> bool {
        matches!(
            self,
            Self::Coulomb(_) | Self::Tresca(_) | Self::Joint { .. }
        )
    }

    /// Its coefficient of Coulomb's friction at the origin.
    pub fn coefficient(&self) -> f64 {
        match self {
            Self::Coulomb(coefficient) => coefficient.at([0.0; D], 0.0),
            _ => 0.0,
        }
    }
}

/// One contact.
#[derive(Debug, Clone)]
pub struct Contact<const D: usize = 2> {
    pub name: String,
    /// The nonmortar side, or the first of `sides`.
    pub own: Side,
    pub against: Against<D>,
    pub pairing: Pairing,
    pub gap: Gap<D>,
    pub law: Law<D>,
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
pub struct Problem<const D: usize = 2> {
    pub family: &'static str,
    pub analysis: Analysis,
    pub bodies: Vec<Body<D>>,
    pub contacts: Vec<Contact<D>>,
    pub times: Vec<f64>,
    pub known: Known,
    /// The reason of `known`, for the report.
    pub reason: String,
    /// The pressure of all contacts, where it is known to be the same everywhere.
    pub uniform: Option<Amount<D>>,
    /// Round bodies may spin: rounding decides how far a polygon or polyhedron turns until its next node touches.
    pub spins: bool,
    pub method: String,
    /// Pieces of all bodies together; the program chooses where it is not given.
    pub subdomains: Option<u64>,
    /// `[drawing]` of a case file.
    pub drawing: Option<Drawing>,
    pub sections: Vec<Section>,
    /// An equivalent problem, given by the family.
    pub other: Option<Box<Other<D>>>,
    /// Steps, from 1, in which nothing has moved since the step before.
    pub idle: Vec<usize>,
    /// Number of steps that are taken from an earlier run.
    pub past: usize,
}

/// A rectangle that a vertical line divides into the regions "a" and "b".
#[derive(Debug, Clone)]
pub struct Drawing {
    pub from: [f64; 2],
    pub to: [f64; 2],
    pub border: f64,
    pub size: f64,
    pub cell: Kind,
}

/// Section forces of a body of the plane between two of its sides.
#[derive(Debug, Clone)]
pub struct Section {
    pub name: String,
    pub body: String,
    pub sides: [&'static str; 2],
    pub stations: Vec<[f64; 2]>,
}

/// An equivalent problem.
#[derive(Debug, Clone)]
pub struct Other<const D: usize = 2> {
    pub name: &'static str,
    pub problem: Problem<D>,
    /// Its bodies that form each body of the original.
    pub parts: Vec<Vec<usize>>,
    /// Relative difference of displacements that is allowed.
    pub tolerance: f64,
}

impl<const D: usize> Problem<D> {
    /// A problem without bodies, of one step.
    pub fn new(family: &'static str, analysis: Analysis) -> Self {
        Self {
            family,
            analysis,
            bodies: Vec::new(),
            contacts: Vec::new(),
            times: vec![1.0],
            known: Known::Open,
            reason: String::new(),
            uniform: None,
            spins: false,
            method: "auto".to_string(),
            subdomains: None,
            drawing: None,
            sections: Vec::new(),
            other: None,
            idle: Vec::new(),
            past: 0,
        }
    }

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
        let coulomb = |law: &Law<D>| matches!(law, Law::Coulomb(_) | Law::Joint { .. });
        self.contacts.iter().any(|contact| coulomb(&contact.law))
    }

    /// Names and texts of its mesh files.
    pub fn files(&self) -> Vec<(&str, &str)> {
        let shapes = self.bodies.iter().map(|body| &body.shape);
        shapes
            .filter_map(|shape| match shape {
                Shape::File { name, text } => Some((&name[..], &text[..])),
                _ => None,
            })
            .collect()
    }
}

/// A support that holds one axis of a side or a point.
pub fn hold<const D: usize>(place: Place<D>, axis: usize) -> Support<D> {
    moved(place, axis, Amount::from(0.0))
}

/// A support that moves one axis of a side or a point.
pub fn moved<const D: usize>(place: Place<D>, axis: usize, value: Amount<D>) -> Support<D> {
    let mut support = Support {
        place,
        axes: std::array::from_fn(|_| None),
        normal: None,
        from: None,
    };
    support.axes[axis] = Some(value);
    support
}

/// A support that moves all components of a place.
pub fn driven<const D: usize>(place: Place<D>, field: Field<D>) -> Support<D> {
    Support {
        place,
        axes: field.map(Some),
        normal: None,
        from: None,
    }
}

/// A support that holds all components of a place.
pub fn clamp<const D: usize>(place: Place<D>) -> Support<D> {
    driven(place, constant([0.0; D]))
}

/// A support that moves a side along its normal.
pub fn roller<const D: usize>(side: &str, value: Amount<D>) -> Support<D> {
    Support {
        place: on(side),
        axes: std::array::from_fn(|_| None),
        normal: Some(value),
        from: None,
    }
}

/// A side as a place.
pub fn on<const D: usize>(side: &str) -> Place<D> {
    Place::Side(side.to_string())
}

/// Times 1, 2, .. of some steps.
pub fn steps(count: usize) -> Vec<f64> {
    (1..=count).map(|step| step as f64).collect()
}
