//! Every key of a case file and of a reference file, table by table.
//!
//! The readers refuse any other key; the reference of the command line is tested against the same lists.

use crate::case::members;
use crate::model::MemberKind;

/// The top level of a case file.
pub const CASE: &[&str] = &{
    const KINDS: usize = MemberKind::ALL.len();
    let mut all = [""; BEFORE.len() + KINDS + AFTER.len()];
    let mut k = 0;
    while k < all.len() {
        all[k] = match k {
            k if k < BEFORE.len() => BEFORE[k],
            k if k < BEFORE.len() + KINDS => MemberKind::ALL[k - BEFORE.len()].key,
            k => AFTER[k - BEFORE.len() - KINDS],
        };
        k += 1;
    }
    all
};
/// What stands there before members.
const BEFORE: &[&str] = &[
    "title",
    "source",
    "analysis",
    "units",
    "parameters",
    "drawing",
    "body",
    "contact",
    "section",
];
/// What stands behind them.
const AFTER: &[&str] = &["solver", "step", "probe"];
/// A mesh outside of a case.
pub(crate) const CASE_MESH: &[&str] = &["mesh", "drawing"];
/// `units`.
pub const UNITS: &[&str] = &["length", "force"];
/// `[[body]]`.
pub const BODY: &[&str] = &[
    "name",
    "mesh",
    "material",
    "formulation",
    "fix",
    "spring",
    "load",
    "couple",
    "cyclic",
    "body_force",
    "initial_stress",
    "initial_strain",
    "pore_pressure",
    "active",
    "surface",
    "points",
];
/// `cyclic` of a body.
pub const CYCLIC: &[&str] = &["from", "to", "sectors", "point", "axis"];
/// `pore_pressure` of a body below a level.
pub const PORE_PRESSURE: &[&str] = &["level", "weight", "direction"];
/// `mesh` of a body.
pub const MESH: &[&str] = &[
    "rectangle",
    "ring",
    "tunnel_rock",
    "box",
    "cylinder",
    "sphere",
    "extrude",
    "outline",
    "region",
    "file",
    "sides",
];
/// `mesh.rectangle`.
pub const RECTANGLE: &[&str] = &["from", "to", "cells", "cell", "diagonals"];
/// `mesh.ring`.
pub const RING: &[&str] = &[
    "center",
    "inner",
    "outer",
    "from",
    "to",
    "cells",
    "ratio",
    "grade",
    "cell",
    "diagonals",
];
/// `mesh.tunnel_rock`.
pub const TUNNEL_ROCK: &[&str] = &[
    "radius",
    "half_width",
    "half_height",
    "cells",
    "ratio",
    "grade",
    "cell",
    "diagonals",
];
/// `mesh.box`.
pub const BOX: &[&str] = &["from", "to", "cells", "cell"];
/// `mesh.cylinder`.
pub const CYLINDER_MESH: &[&str] = &[
    "base", "axis", "radius", "inner", "height", "from", "to", "cells", "cell",
];
/// `mesh.sphere`.
pub const SPHERE_MESH: &[&str] = &["center", "radius", "inner", "from", "to", "cells", "cell"];
/// `mesh.extrude`.
pub const EXTRUDE: &[&str] = &["mesh", "height", "turn", "offset", "layers"];
/// `turn` of `mesh.extrude`.
pub const TURN: &[&str] = &["point", "axis", "angle"];
/// `mesh.file`.
pub const FILE: &[&str] = &["path", "group"];
/// `mesh.outline`.
pub const OUTLINE: &[&str] = &[
    "size", "cell", "growth", "from", "edges", "circle", "name", "holes", "refine",
];
/// One element of `holes`.
pub const HOLE: &[&str] = &["from", "edges", "circle", "name", "size"];
/// `[drawing]`.
pub const DRAWING: &[&str] = &["size", "cell", "growth", "lines", "regions", "refine"];
/// One element of `lines` of a drawing.
pub const LINE: &[&str] = &[
    "from",
    "edges",
    "circle",
    "to",
    "center",
    "via",
    "radius",
    "clockwise",
    "name",
    "size",
    "cells",
];
/// One element of `regions` of a drawing.
pub const REGION: &[&str] = &["name", "at", "size"];
/// One element of `edges`.
pub const EDGE: &[&str] = &[
    "to",
    "center",
    "via",
    "radius",
    "clockwise",
    "name",
    "size",
    "cells",
];
/// `circle` of an outline or a hole.
pub const OUTLINE_CIRCLE: &[&str] = &["center", "radius", "name", "size", "cells"];
/// One element of `refine`.
pub const REFINE: &[&str] = &["at", "size", "radius"];
/// One side of `mesh.sides`.
pub const PATCH: &[&str] = &["of", "min", "max"];
/// `material` of a body, or one element of its list.
pub const MATERIAL: &[&str] = &[
    "young",
    "poisson",
    "thickness",
    "group",
    "strength",
    "plastic",
    "hardening",
    "dilation",
    "unload",
];
/// `strength` of a material.
pub const STRENGTH: &[&str] = &[
    "yield",
    "tension",
    "compression",
    "friction_angle",
    "cohesion",
    "sci",
    "mb",
    "s",
    "a",
];
/// `initial_stress` of a body.
pub const INITIAL_STRESS: &[&str] = &[
    "vertical",
    "k0",
    "direction",
    "xx",
    "yy",
    "zz",
    "xy",
    "yz",
    "xz",
];
/// `initial_strain` of a body.
pub const INITIAL_STRAIN: &[&str] = &[
    "thermal",
    "expansion",
    "isotropic",
    "xx",
    "yy",
    "zz",
    "xy",
    "yz",
    "xz",
];
/// One side of `surface`.
pub const SURFACE: &[&str] = &["plane", "circle", "cylinder", "cone", "sphere"];
/// A plane.
pub const PLANE: &[&str] = &["point", "normal"];
/// A cylinder.
pub const CYLINDER: &[&str] = &["point", "axis", "radius", "inside"];
/// A cone.
pub const CONE: &[&str] = &["apex", "axis", "angle", "inside"];
/// A circle or sphere.
pub const CIRCLE: &[&str] = &["center", "radius", "inside"];
/// One element of `fix`.
pub const FIX: &[&str] = &[
    "side", "point", "x", "y", "z", "normal", "rotation", "active",
];
/// One element of `spring`.
pub const SPRING: &[&str] = &[
    "side",
    "point",
    "normal",
    "tangential",
    "compression_only",
    "x",
    "y",
    "z",
    "active",
];
/// One element of `load`.
pub const LOAD: &[&str] = &[
    "side", "point", "traction", "pressure", "force", "in_situ", "moment", "active",
];
/// One element of `couple`.
pub const COUPLE: &[&str] = &["side", "point", "kind"];
/// `[[contact]]`.
pub const CONTACT: &[&str] = &[
    "name",
    "nonmortar",
    "mortar",
    "sides",
    "bodies",
    "obstacle",
    "reach",
    "pairing",
    "gap",
    "friction",
    "tied",
    "exclude",
    "friction_exclude",
    "gasket",
    "active",
];
/// `gasket` of a contact.
pub const GASKET: &[&str] = &["closure", "pressure", "unloading"];
/// `gap` of a contact, when it is a table.
pub const GAP: &[&str] = &["adjust"];
/// `obstacle` of a contact.
pub const OBSTACLE: &[&str] = &[
    "gap",
    "displacement",
    "force",
    "turn",
    "plane",
    "circle",
    "sphere",
    "cylinder",
    "cone",
    "stl",
    "outline",
];
/// `friction` of a contact, when it is a table.
pub const FRICTION: &[&str] = &["coulomb", "tresca", "cohesion", "tension"];
/// `[[section]]`.
pub const SECTION: &[&str] = &[
    "name",
    "body",
    "bodies",
    "sides",
    "stations",
    "axis",
    "places",
    "capacity",
    "reinforcement",
];
/// `capacity` of a section.
pub const CAPACITY: &[&str] = &["compression", "tension", "reinforcement"];
/// One element of `reinforcement`.
pub const REINFORCEMENT: &[&str] = &["depth", "area", "yield", "young"];
/// `from` or `to` of a member, where it is a side.
pub const MEMBER_END: &[&str] = &["side"];
/// `[solver]`.
pub const SOLVER: &[&str] = &[
    "method",
    "tolerance",
    "max_iterations",
    "rho",
    "bolt",
    "subdomains",
];
/// `[[step]]`.
pub const STEP: &[&str] = &["name", "time", "zero_displacements"];
/// `active` of anything but a body.
pub const ACTIVE: &[&str] = &["from", "until"];
/// `active` of a body.
pub const ACTIVE_BODY: &[&str] = &["from", "until", "release"];
/// `[[probe]]`.
pub const PROBE: &[&str] = &[
    "name",
    "quantity",
    "expression",
    "at",
    "along",
    "reduce",
    "mean_of_neighbours",
    "minus_rigid",
    "center",
    "factor",
];
/// `along` of a probe, when it is a line.
pub const ALONG: &[&str] = &["from", "to", "points"];
/// The top level of a reference file.
pub const REFERENCES: &[&str] = &["value"];
/// `[[value]]` of a reference file.
pub const REFERENCE: &[&str] = &[
    "case",
    "cases",
    "probe",
    "step",
    "kind",
    "value",
    "tolerance",
    "band",
    "judged",
    "known",
    "source",
    "reason",
    "label",
    "scale",
    "minus",
    "against",
];

/// Keys that case files will have: a table, and those of its keys that are refused as not supported yet.
pub const LATER: &[(&[&str], &[&str])] = &[
    (CASE, &["accuracy"]),
    (SOLVER, &["motion", "max_increments", "output"]),
    (FIX, &["turn"]),
    (COUPLE, &["turn"]),
    (LOAD, &["follower", "name"]),
];

/// Every table with its keys; those of members are the last.
pub const ALL: &[(&str, &[&str])] = &{
    let mut all: [(&str, &[&str]); TABLES.len() + MemberKind::ALL.len()] =
        [("", &[]); TABLES.len() + MemberKind::ALL.len()];
    let mut k = 0;
    while k < all.len() {
        all[k] = match k < TABLES.len() {
            true => TABLES[k],
            false => (
                MemberKind::ALL[k - TABLES.len()].key,
                members::KEYS[k - TABLES.len()],
            ),
        };
        k += 1;
    }
    all
};

/// Every table but those of members.
const TABLES: &[(&str, &[&str])] = &[
    ("case", CASE),
    ("units", UNITS),
    ("body", BODY),
    ("mesh", MESH),
    ("rectangle", RECTANGLE),
    ("ring", RING),
    ("tunnel_rock", TUNNEL_ROCK),
    ("box", BOX),
    ("cylinder", CYLINDER_MESH),
    ("sphere", SPHERE_MESH),
    ("extrude", EXTRUDE),
    ("turn", TURN),
    ("file", FILE),
    ("outline", OUTLINE),
    ("holes", HOLE),
    ("drawing", DRAWING),
    ("lines", LINE),
    ("regions", REGION),
    ("edges", EDGE),
    ("circle", OUTLINE_CIRCLE),
    ("refine", REFINE),
    ("sides", PATCH),
    ("material", MATERIAL),
    ("initial_stress", INITIAL_STRESS),
    ("initial_strain", INITIAL_STRAIN),
    ("active", ACTIVE_BODY),
    ("strength", STRENGTH),
    ("surface", SURFACE),
    ("plane", PLANE),
    ("cylinder", CYLINDER),
    ("cone", CONE),
    ("circle", CIRCLE),
    ("fix", FIX),
    ("spring", SPRING),
    ("load", LOAD),
    ("couple", COUPLE),
    ("contact", CONTACT),
    ("gap", GAP),
    ("gasket", GASKET),
    ("obstacle", OBSTACLE),
    ("friction", FRICTION),
    ("section", SECTION),
    ("capacity", CAPACITY),
    ("reinforcement", REINFORCEMENT),
    ("from", MEMBER_END),
    ("solver", SOLVER),
    ("step", STEP),
    ("probe", PROBE),
    ("along", ALONG),
    ("reference", REFERENCES),
    ("value", REFERENCE),
];
