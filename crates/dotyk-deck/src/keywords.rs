//! What becomes of every keyword, with the parameters that it may have.
//!
//! A keyword that changes the answer and is not understood is an error at its line; so is an unknown parameter of a known
//! keyword. What only tunes a solver is passed over, and told.

/// What becomes of a keyword.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Becomes {
    /// It is read.
    Read,
    /// It changes nothing here, for this reason.
    Ignored(&'static str),
    /// It is refused, for this reason.
    Refused(&'static str),
}

use crate::lines::folded;
use Becomes::{Ignored, Read, Refused};

const TUNES: Becomes = Ignored("it tunes a solver, and there is nothing to tune");
const NO_STATICS: Becomes = Refused("only *STATIC is solved");
const OUTPUT: &[&str] = &[
    "NSET",
    "ELSET",
    "FREQUENCY",
    "FREQUENCYF",
    "TOTALS",
    "GLOBAL",
    "TIME POINTS",
    "OUTPUT",
    "OUTPUT ALL",
    "LAST ITERATIONS",
    "CONTACT ELEMENTS",
    "SECTION FORCES",
    "SLAVE",
    "MASTER",
    "OP",
    "VARIABLE",
    "FIELD",
    "NAME",
    "SURFACE",
    "SET",
    "POSITION",
    "DIRECTIONS",
];

/// Keywords, their parameters, and what becomes of them.
pub(crate) const KEYWORDS: &[Entry] = &[
    ("HEADING", &[], Read),
    ("NODE", &["NSET", "SYSTEM"], Read),
    ("ELEMENT", &["TYPE", "ELSET"], Read),
    (
        "NSET",
        &["NSET", "GENERATE", "UNSORTED", "INSTANCE", "INTERNAL"],
        Read,
    ),
    (
        "ELSET",
        &["ELSET", "GENERATE", "UNSORTED", "INSTANCE", "INTERNAL"],
        Read,
    ),
    ("SURFACE", &["NAME", "TYPE", "INTERNAL"], Read),
    ("MATERIAL", &["NAME", "DESCRIPTION"], Read),
    ("ELASTIC", &["TYPE"], Read),
    ("DENSITY", &[], Read),
    ("EXPANSION", &["TYPE", "ZERO"], Read),
    (
        "CONDUCTIVITY",
        &["TYPE"],
        Ignored("heat does not flow here"),
    ),
    ("SPECIFIC HEAT", &[], Ignored("heat does not flow here")),
    (
        "DAMPING",
        &["ALPHA", "BETA", "STRUCTURAL"],
        Ignored("statics have no damping"),
    ),
    ("SOLID SECTION", &["ELSET", "MATERIAL", "CONTROLS"], Read),
    (
        "SECTION CONTROLS",
        &["NAME", "HOURGLASS", "KINEMATIC SPLIT"],
        TUNES,
    ),
    ("SURFACE INTERACTION", &["NAME"], Read),
    ("SURFACE BEHAVIOR", &["PRESSURE-OVERCLOSURE"], Read),
    ("FRICTION", &["SLIP TOLERANCE"], Read),
    ("CHANGE FRICTION", &["INTERACTION"], Read),
    ("CHANGE SURFACE BEHAVIOR", &["INTERACTION"], Read),
    (
        "CONTACT DAMPING",
        &["DEFINITION", "TANGENT FRACTION"],
        Ignored("statics have no damping"),
    ),
    (
        "GAP CONDUCTANCE",
        &["PRESSURE"],
        Ignored("heat does not flow here"),
    ),
    (
        "GAP HEAT GENERATION",
        &[],
        Ignored("heat does not flow here"),
    ),
    (
        "CONTACT PAIR",
        &[
            "INTERACTION",
            "TYPE",
            "SMALL SLIDING",
            "ADJUST",
            "EXTENSION ZONE",
            "NO THICKNESS",
        ],
        Read,
    ),
    ("CLEARANCE", &["MASTER", "SLAVE", "VALUE"], Read),
    (
        "TIE",
        &[
            "NAME",
            "POSITION TOLERANCE",
            "ADJUST",
            "TYPE",
            "CYCLIC SYMMETRY",
            "MULTISTAGE",
            "FLUID PERIODIC",
        ],
        Read,
    ),
    (
        "COUPLING",
        &["REF NODE", "SURFACE", "CONSTRAINT NAME", "ORIENTATION"],
        Read,
    ),
    ("KINEMATIC", &[], Read),
    ("DISTRIBUTING", &[], Read),
    (
        "RIGID BODY",
        &["NSET", "ELSET", "REF NODE", "ROT NODE"],
        Read,
    ),
    ("INITIAL CONDITIONS", &["TYPE", "USER"], Read),
    (
        "AMPLITUDE",
        &[
            "NAME",
            "TIME",
            "VALUE",
            "DEFINITION",
            "SMOOTH",
            "SHIFTX",
            "SHIFTY",
        ],
        Read,
    ),
    (
        "TIME POINTS",
        &["NAME", "TIME", "GENERATE"],
        Ignored("results are those at the ends of the steps"),
    ),
    (
        "STEP",
        &[
            "NLGEOM",
            "INC",
            "INCF",
            "AMPLITUDE",
            "NAME",
            "TURBULENCE MODEL",
            "UNSYMM",
            "EXTRAPOLATION",
        ],
        Read,
    ),
    (
        "STATIC",
        &["DIRECT", "SOLVER", "TIME RESET", "TOTAL TIME AT START"],
        Read,
    ),
    ("END STEP", &[], Read),
    (
        "CONTROLS",
        &["PARAMETERS", "PARAMETER", "FIELD", "RESET", "ANALYSIS"],
        TUNES,
    ),
    ("SOLUTION TECHNIQUE", &["TYPE", "REFORM KERNEL"], TUNES),
    (
        "CONTACT CONTROLS",
        &[
            "MASTER",
            "SLAVE",
            "STABILIZE",
            "AUTOMATIC TOLERANCES",
            "ABSOLUTE PENETRATION TOLERANCE",
        ],
        TUNES,
    ),
    (
        "BOUNDARY",
        &[
            "OP",
            "AMPLITUDE",
            "FIXED",
            "TIME DELAY",
            "TYPE",
            "LOAD CASE",
        ],
        Read,
    ),
    (
        "CLOAD",
        &["OP", "AMPLITUDE", "TIME DELAY", "LOAD CASE"],
        Read,
    ),
    (
        "DLOAD",
        &["OP", "AMPLITUDE", "TIME DELAY", "LOAD CASE"],
        Read,
    ),
    (
        "DSLOAD",
        &["OP", "AMPLITUDE", "TIME DELAY", "LOAD CASE"],
        Read,
    ),
    ("TEMPERATURE", &["OP", "AMPLITUDE", "TIME DELAY"], Read),
    ("MODEL CHANGE", &["TYPE", "ADD", "REMOVE"], Read),
    ("NODE PRINT", OUTPUT, Read),
    ("EL PRINT", OUTPUT, Read),
    ("CONTACT PRINT", OUTPUT, Read),
    ("NODE FILE", OUTPUT, Read),
    ("NODE OUTPUT", OUTPUT, Read),
    ("EL FILE", OUTPUT, Read),
    ("ELEMENT OUTPUT", OUTPUT, Read),
    ("CONTACT FILE", OUTPUT, Read),
    ("CONTACT OUTPUT", OUTPUT, Read),
    (
        "OUTPUT",
        &[
            "FIELD",
            "HISTORY",
            "VARIABLE",
            "FREQUENCY",
            "TIME INTERVAL",
            "NAME",
            "NUMBER INTERVAL",
        ],
        Ignored(
            "results are those that dotyk writes, and what *NODE FILE, *EL FILE and *CONTACT FILE ask for",
        ),
    ),
    (
        "SECTION PRINT",
        &["SURFACE", "NAME", "FREQUENCY", "FREQUENCYF", "TIME POINTS"],
        Ignored("forces on surfaces are those of contacts and supports in summary.json"),
    ),
    (
        "ENERGY OUTPUT",
        &["ELSET", "FREQUENCY", "VARIABLE"],
        Ignored("energies are in summary.json"),
    ),
    (
        "RESTART",
        &["WRITE", "FREQUENCY", "OVERLAY", "NUMBER INTERVAL"],
        Ignored("`--from` goes on behind the steps of an earlier run"),
    ),
    (
        "PREPRINT",
        &["ECHO", "MODEL", "HISTORY", "CONTACT"],
        Ignored("it is about what is printed"),
    ),
    (
        "PHYSICAL CONSTANTS",
        &["ABSOLUTE ZERO", "STEFAN BOLTZMANN", "NEWTON GRAVITY"],
        Ignored("heat does not flow here"),
    ),
    ("EQUATION", &["REMOVE"], Read),
    (
        "MPC",
        &["USER"],
        Refused("multiple point constraints are not supported: use *RIGID BODY, *COUPLING or *TIE"),
    ),
    ("PRE-TENSION SECTION", &["NODE", "SURFACE", "ELEMENT"], Read),
    (
        "CYCLIC SYMMETRY MODEL",
        &["N", "NGRAPH", "TIE", "ELSET", "CHECK"],
        Read,
    ),
    (
        "TRANSFORM",
        &["NSET", "TYPE"],
        Refused("degrees of freedom are along the global axes"),
    ),
    (
        "ORIENTATION",
        &["NAME", "SYSTEM"],
        Refused("materials are isotropic, and have no orientation"),
    ),
    (
        "DISTRIBUTING COUPLING",
        &["ELSET"],
        Refused("use *COUPLING with *DISTRIBUTING"),
    ),
    (
        "SHELL SECTION",
        &[
            "ELSET",
            "MATERIAL",
            "OFFSET",
            "ORIENTATION",
            "COMPOSITE",
            "NODAL THICKNESS",
        ],
        Refused("shells are not supported: use solid elements"),
    ),
    (
        "MEMBRANE SECTION",
        &["ELSET", "MATERIAL"],
        Refused("membranes are not supported: use solid elements"),
    ),
    (
        "BEAM SECTION",
        &["ELSET", "MATERIAL", "SECTION", "OFFSET1", "OFFSET2"],
        Refused("beams are not supported: use solid elements, or `[[bar]]` in a case"),
    ),
    (
        "BEAM GENERAL SECTION",
        &["ELSET", "SECTION"],
        Refused("beams are not supported: use solid elements, or `[[bar]]` in a case"),
    ),
    (
        "SPRING",
        &["ELSET", "NONLINEAR", "ORIENTATION"],
        Refused("springs are not supported in a deck: use `[[spring]]` in a case"),
    ),
    (
        "GAP",
        &["ELSET"],
        Refused("gap elements are not supported: use *CONTACT PAIR"),
    ),
    (
        "PLASTIC",
        &["HARDENING"],
        Refused(
            "materials of a deck are elastic: give the material a `strength` and `plastic` in the case that `dotyk import` writes without this keyword",
        ),
    ),
    ("HYPERELASTIC", &[], Refused("materials are linear elastic")),
    ("HYPERFOAM", &[], Refused("materials are linear elastic")),
    ("CREEP", &["LAW"], Refused("materials are linear elastic")),
    ("VISCO", &[], NO_STATICS),
    (
        "CYCLIC HARDENING",
        &[],
        Refused("materials of a deck are elastic"),
    ),
    (
        "DEFORMATION PLASTICITY",
        &[],
        Refused("materials are linear elastic"),
    ),
    (
        "MOHR COULOMB",
        &[],
        Refused("materials of a deck are elastic"),
    ),
    (
        "USER MATERIAL",
        &["CONSTANTS", "TYPE"],
        Refused("materials are linear elastic"),
    ),
    ("DEPVAR", &[], Refused("materials are linear elastic")),
    ("DYNAMIC", &[], NO_STATICS),
    ("FREQUENCY", &[], NO_STATICS),
    ("COMPLEX FREQUENCY", &[], NO_STATICS),
    ("MODAL DYNAMIC", &[], NO_STATICS),
    ("STEADY STATE DYNAMICS", &[], NO_STATICS),
    ("BUCKLE", &[], NO_STATICS),
    ("HEAT TRANSFER", &[], NO_STATICS),
    ("COUPLED TEMPERATURE-DISPLACEMENT", &[], NO_STATICS),
    ("UNCOUPLED TEMPERATURE-DISPLACEMENT", &[], NO_STATICS),
    ("GREEN", &[], NO_STATICS),
    ("SENSITIVITY", &[], NO_STATICS),
    (
        "CONTACT",
        &["SMALL SLIDING"],
        Refused(
            "general contact is *CONTACT PAIR here, or `[[contact]]` with `bodies = \"all\"` in a case",
        ),
    ),
    (
        "PART",
        &["NAME"],
        Refused(
            "decks with parts are not supported: write the deck flat (\"Do not use parts and assemblies in input files\")",
        ),
    ),
    (
        "ASSEMBLY",
        &["NAME"],
        Refused(
            "decks with assemblies are not supported: write the deck flat (\"Do not use parts and assemblies in input files\")",
        ),
    ),
    (
        "INSTANCE",
        &["NAME", "PART"],
        Refused(
            "decks with instances are not supported: write the deck flat (\"Do not use parts and assemblies in input files\")",
        ),
    ),
    ("CFLUX", &[], Refused("heat is not solved")),
    ("DFLUX", &[], Refused("heat is not solved")),
    ("FILM", &[], Refused("heat is not solved")),
    ("RADIATE", &[], Refused("heat is not solved")),
    ("SUBMODEL", &[], Refused("submodels are not supported")),
];

/// A keyword, its parameters, and what becomes of it.
pub(crate) type Entry = (&'static str, &'static [&'static str], Becomes);

/// The entry of a keyword; blanks do not count.
pub(crate) fn entry(keyword: &str) -> Option<&'static Entry> {
    let word = folded(keyword);
    KEYWORDS.iter().find(|(known, ..)| folded(known) == word)
}

/// The name of a parameter of a keyword as its entry has it; blanks do not count.
pub(crate) fn parameter(entry: &Entry, name: &str) -> Option<&'static str> {
    let word = folded(name);
    entry.1.iter().copied().find(|known| folded(known) == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_keyword_stands_once() {
        for (k, (word, ..)) in KEYWORDS.iter().enumerate() {
            assert!(
                !KEYWORDS[..k].iter().any(|(before, ..)| before == word),
                "{word}"
            );
        }
    }
}
