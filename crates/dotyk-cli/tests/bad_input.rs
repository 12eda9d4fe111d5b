//! Every mistake ends with exit status 2, one clear message that names the place, and no result file.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const GOOD: &str = r#"title = "Floating punch on a block"
analysis = "plane-strain"
units = { length = "m", force = "N" }

[[body]]
name = "block"
mesh = { rectangle = { from = [0.0, 0.0], to = [4.0, 1.0], cells = [8, 2] } }
material = { young = 210e9, poisson = 0.3 }
fix = [{ side = "bottom", x = 0.0, y = 0.0 }]

[[body]]
name = "punch"
mesh = { rectangle = { from = [1.5, 1.0], to = [2.5, 2.0], cells = [2, 2] } }
material = { young = 210e9, poisson = 0.3 }
fix = [{ side = "left", x = 0.0 }, { side = "right", x = 0.0 }]
load = [{ side = "top", traction = [0.0, "-1e6 * (1 + 0.1*x)"] }]

[[contact]]
name = "sole"
nonmortar = "punch.bottom"
mortar = "block.top"
gap = "geometric"

[solver]
method = "uzawa"
tolerance = 1e-8
rho = 1e9

[[probe]]
name = "middle"
quantity = "sole.pressure"
at = [2.0, 1.0]
"#;

/// A mistake in the text: what is replaced, by what, text on the line that is to be reported, words of the message.
type Mistake = (&'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const IN_THE_TEXT: &[Mistake] = &[
    // TOML
    ("title = \"Floating punch on a block\"", "title = \"Floating punch", "title", "not valid TOML"),
    ("name = \"block\"", "name = \"block\"\nname = \"brick\"", "brick", "duplicate key"),
    // keys
    ("analysis =", "analisys =", "analisys", "`analysis`"),
    ("young =", "joung =", "joung", "`young`"),
    ("[solver]", "[sover]", "[sover]", "`solver`"),
    ("mortar = \"block.top\"", "master = \"block.top\"", "master", "`mortar`"),
    ("quantity =", "quantities =", "quantities", "`quantity`"),
    ("analysis = \"plane-strain\"\n", "", "title", "needs the key `analysis`"),
    ("name = \"punch\"\n", "", "[[body]]\nmesh", "needs the key `name`"),
    (", cells = [8, 2]", "", "to = [4.0, 1.0]", "needs the key `cells`"),
    (", poisson = 0.3 }\nfix = [{ side = \"bottom\"", " }\nfix = [{ side = \"bottom\"", "young = 210e9 }", "`poisson`"),
    // names that no file can have, or that are one file on some systems
    ("name = \"punch\"", "name = \"CON\"", "CON", "body `CON`: Windows keeps the name `CON` for a device"),
    ("name = \"punch\"", "name = \"lpt7\"", "lpt7", "choose another one, such as `lpt7_1`"),
    ("name = \"punch\"", "name = \"Block\"", "Block", "body `Block`: its name differs from `block` in case alone"),
    // in-situ stress and initial strain
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { vertical = -1e6 }", "vertical", "needs the key `k0`"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { k0 = 0.5 }", "k0 = 0.5", "needs the key `vertical`"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { vertical = -1e6, k0 = 0.5, direction = [0, 0] }", "[0, 0]", "has no length"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { xx = -1e6, direction = [0, 1] }", "direction", "do not go together"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { direction = [0, 1], k0 = 0.5 }", "direction", "needs the key `vertical`"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { vertical = -1e6, k0 = 0.5, xx = -1e6 }", "xx = -1e6", "do not go together"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = {}", "initial_stress = {}", "nothing is given"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { vertical = -1e6, k0 = [0.5, 0.5, 0.5] }", "k0 = [0.5", "expected 2"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { sxx = -1e6 }", "sxx", "`xx`"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_stress = { vertical = \"-1e6/y\", k0 = 0.5 }", "name = \"block\"", "initial_stress xx"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_strain = { thermal = 40 }", "thermal = 40", "needs the key `expansion`"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_strain = { thermal = 40, expansion = \"y\" }", "expansion = \"y\"", "expected a number"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_strain = { isotropic = 1e-4, xx = 1e-4 }", "isotropic", "do not go together"),
    ("fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]", "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\ninitial_strain = { xx = 1e-4, yz = 1e-4 }", "initial_strain", "does not move out of its plane"),
    ("traction = [0.0, \"-1e6 * (1 + 0.1*x)\"]", "in_situ = 1", "in_situ", "without an `initial_stress` of body `punch`"),
    ("traction = [0.0, \"-1e6 * (1 + 0.1*x)\"]", "pressure = 1, in_situ = 1", "in_situ", "not a load"),
    // types
    ("\"-1e6 * (1 + 0.1*x)\"", "true", "true", "expected a number or an expression string, found a boolean"),
    ("tolerance = 1e-8", "tolerance = \"small\"", "small", "expected a number, the expression \"small\""),
    ("traction = [0.0, \"-1e6 * (1 + 0.1*x)\"]", "traction = [1, 2, 3]", "[1, 2, 3]", "found 3"),
    ("at = [2.0, 1.0]", "at = 2.0", "at = 2.0", "expected a list of 2 numbers"),
    ("cells = [8, 2]", "cells = [8.5, 2]", "8.5", "positive integer"),
    ("cells = [8, 2]", "cells = [8, 0]", "[8, 0]", "positive integer"),
    ("cells = [8, 2]", "cells = [1000000, 1000000]", "1000000", "cells"),
    // words
    ("\"plane-strain\"", "\"plain-strain\"", "plain", "`plane-strain`"),
    ("method = \"uzawa\"", "method = \"uzava\"", "uzava", "`uzawa`"),
    ("cells = [8, 2]", "cells = [8, 2], cell = \"quad5\"", "quad5", "`quad4`"),
    // names
    ("name = \"punch\"", "name = \"block\"", "name = \"block\"\nmesh = { rectangle = { from = [1.5", "two bodies"),
    ("name = \"punch\"", "name = \"a punch\"", "a punch", "not a valid name"),
    ("\"punch.bottom\"", "\"punsh.bottom\"", "punsh", "`punch`"),
    ("\"block.top\"", "\"block.up\"", "block.up", "`top`"),
    ("\"block.top\"", "\"block\"", "mortar = \"block\"", "BODY.SIDE"),
    ("\"block.top\"", "\"punch.bottom\"", "\nmortar", "itself"),
    ("side = \"bottom\", x", "side = \"botom\", x", "botom", "`bottom`"),
    ("side = \"top\"", "side = \"topp\"", "topp", "`top`"),
    // supports and loads
    ("{ side = \"bottom\", x = 0.0, y = 0.0 }", "{ side = \"bottom\" }", "{ side = \"bottom\" }", "prescribes nothing"),
    ("{ side = \"bottom\", x = 0.0, y = 0.0 }", "{ side = \"bottom\", point = [0, 0], x = 0 }", "point", "both `side` and `point`"),
    ("x = 0.0, y = 0.0 }", "x = 0.0, z = 0.0 }", "z = 0.0", "no `z`"),
    ("{ side = \"top\",", "{", "{ traction", "a load is"),
    // numbers
    ("young = 210e9, poisson = 0.3 }\nfix = [{ side = \"bottom\"", "young = -1.0, poisson = 0.3 }\nfix = [{ side = \"bottom\"", "-1.0", "must be positive"),
    ("poisson = 0.3 }\nfix = [{ side = \"left\"", "poisson = 0.5 }\nfix = [{ side = \"left\"", "0.5", "incompressible"),
    ("poisson = 0.3 }\nfix = [{ side = \"left\"", "poisson = 0.7 }\nfix = [{ side = \"left\"", "0.7", "between -1 and 0.5"),
    ("poisson = 0.3 }\nfix = [{ side = \"left\"", "poisson = 0.3, thickness = 0 }\nfix = [{ side = \"left\"", "thickness", "positive"),
    ("from = [0.0, 0.0]", "from = [nan, 0.0]", "nan", "finite"),
    ("to = [4.0, 1.0]", "to = [-4.0, 1.0]", "-4.0", "block"),
    ("tolerance = 1e-8", "tolerance = 0", "tolerance = 0", "positive"),
    ("rho = 1e9", "rho = -1e9", "rho", "positive"),
    ("method = \"uzawa\"", "method = \"newton\"", "rho", "no meaning for the method `newton`"),
    // expressions
    ("0.1*x)", "0.1*xx)", "0.1*xx)", "unknown name `xx`"),
    ("0.1*x)", "0.1*x", "traction", "never closed"),
    ("\"-1e6 * (1 + 0.1*x)\"", "\"1/0\"", "1/0", "not finite"),
    ("gap = \"geometric\"", "gap = \"geometrical\"", "geometrical", "unknown name `geometrical`"),
    // contacts
    ("mortar = \"block.top\"\n", "", "[[contact]]", "what touches what"),
    ("gap = \"geometric\"", "obstacle = { gap = 0.0 }", "[[contact]]", "what touches what"),
    // probes
    ("\"sole.pressure\"", "\"sole.presure\"", "presure", "`pressure`"),
    ("\"sole.pressure\"", "\"soul.pressure\"", "soul", "`sole`"),
    ("\"sole.pressure\"", "\"block.displacement.w\"", "displacement.w", "`magnitude`"),
    ("\"sole.pressure\"", "\"sole.length\"", "\nat =", "takes no `at`"),
    ("at = [2.0, 1.0]\n", "", "[[probe]]", "`at`, `along` or `reduce`"),
    ("at = [2.0, 1.0]", "at = [2.0, 1.0]\nreduce = \"max\"", "reduce", "both"),
    ("at = [2.0, 1.0]", "at = [2.0, 1.0]\nalong = \"punch.bottom\"", "along", "both `at` and `along`"),
    ("at = [2.0, 1.0]", "along = { from = [1.5, 1], to = [2, 1], points = 3 }\nreduce = \"max\"", "reduce", "or along a side"),
    ("at = [2.0, 1.0]", "along = \"punch.bottom\"\nreduce = \"max\"", "reduce", "leave out `along`"),
    ("at = [2.0, 1.0]", "along = \"punch.bottm\"", "along", "`bottom`"),
    ("at = [2.0, 1.0]", "along = [\"punch.bottom\", \"block.top\"]", "along", "belong to one body"),
    ("at = [2.0, 1.0]", "along = 2", "along", "expected \"BODY.SIDE\""),
    ("at = [2.0, 1.0]", "along = { from = [1.5, 1], to = [2, 1] }", "along", "needs the key `points`"),
    ("at = [2.0, 1.0]", "along = { from = [1.5, 1], to = [2, 1], point = 3 }", "along", "`points`"),
    ("at = [2.0, 1.0]", "along = { from = [1.5, 1], to = [1.5, 1], points = 3 }", "along", "another point"),
    ("at = [2.0, 1.0]", "along = { from = [1.5, 1], to = [2, 1], points = 1 }", "along", "2 to 1000000 points"),
    ("at = [2.0, 1.0]", "along = { from = [1.5, 1], to = [2, 1], points = \"1e9\" }", "along", "2 to 1000000 points"),
    ("at = [2.0, 1.0]", "along = { from = [1.5, 1], to = [2, 1], points = \"5/2\" }", "along", "must come out whole"),
    ("at = [2.0, 1.0]", "along = \"punch.bottom\"\nmean_of_neighbours = true", "mean_of_neighbours", "needs `at`"),
    ("quantity = \"sole.pressure\"\nat = [2.0, 1.0]", "quantity = \"sole.length\"\nalong = \"punch.bottom\"", "along", "takes no `along`"),
    ("quantity = \"sole.pressure\"\nat = [2.0, 1.0]", "quantity = \"punch.stress.normal\"\nat = [2, 1.5]", "normal", "needs one"),
    // meshes
    ("{ rectangle = { from = [1.5, 1.0], to = [2.5, 2.0], cells = [2, 2] } }", "{}", "mesh = {}", "exactly one"),
    ("cells = [2, 2] } }", "cells = [2, 2] }, ring = { inner = 1, outer = 2, cells = [8, 2] } }", "ring", "more than one generator"),
    // steps
    ("[solver]", "[[step]]\ntime = 1\n[[step]]\ntime = 1\n[solver]", "\ntime = 1\n[solver]", "must increase"),
    ("[solver]", "[[step]]\n[solver]", "[[step]]", "`time`"),
    ("[solver]", "[[step]]\ntime = inf\n[solver]", "time = inf", "finite"),
    ("{ rectangle = { from = [1.5, 1.0], to = [2.5, 2.0], cells = [2, 2] } }", "{ file = { path = \"punch.msh\" } }", "punch.msh", "there is no such file"),
    ("{ rectangle = { from = [1.5, 1.0], to = [2.5, 2.0], cells = [2, 2] } }", "{ file = { path = \"bad.toml\" } }", "{ file", "neither a Gmsh mesh"),
    ("{ rectangle = { from = [1.5, 1.0], to = [2.5, 2.0], cells = [2, 2] } }", "{ file = { group = \"a\" } }", "{ file", "needs the key `path`"),
    // what belongs elsewhere, or comes later
    ("fix = [{ side = \"bottom\"", "pressure = 3\nfix = [{ side = \"bottom\"", "\npressure", "`pressure` is a key of `load`"),
    ("\"plane-strain\"", "\"2d\"", "2d", "here it is `plane-strain`"),
    ("[solver]", "[parameters]\na = \"2*b\"\nb = 3\n[solver]", "2*b", "comes after it"),
    ("young = 210e9, poisson = 0.3 }\nfix = [{ side = \"bottom\"", "young = \"inf\", poisson = 0.3 }\nfix = [{ side = \"bottom\"", "\"inf\"", "no number to compute with"),
    // named points
    ("fix = [{ side = \"bottom\"", "fix = [{ point = \"tip\", x = 0 }, { side = \"bottom\"", "\"tip\"", "has no point `tip`"),
    ("fix = [{ side = \"bottom\"", "points = { tip = [0, 1] }\nfix = [{ point = \"tipp\", x = 0 }, { side = \"bottom\"", "\"tipp\"", "nearest known point is `tip`"),
    ("fix = [{ side = \"bottom\"", "points = { tip = [0, 1] }\nfix = [{ point = \"tip\", normal = 0 }, { side = \"bottom\"", "normal", "no normal"),
    ("fix = [{ side = \"bottom\"", "points = { \"a tip\" = [0, 1] }\nfix = [{ side = \"bottom\"", "a tip", "not a valid name"),
    ("fix = [{ side = \"bottom\"", "points = { tip = [0, 1, 2] }\nfix = [{ side = \"bottom\"", "[0, 1, 2]", "found 3"),
    ("at = [2.0, 1.0]", "at = \"block.tip\"", "block.tip", "has no point `tip`"),
    ("at = [2.0, 1.0]", "at = \"tip\"", "\"tip\"", "BODY.NAME"),
    ("at = [2.0, 1.0]", "at = \"blok.tip\"", "blok.tip", "`block`"),
    // couples
    ("load = [", "couple = [{ side = \"tip\", point = \"P\", kind = \"rigid\" }]\npoints = { P = [2, 3] }\nload = [", "side = \"tip\"", "has no side `tip`"),
    ("load = [", "couple = [{ side = \"top\", point = \"Q\", kind = \"rigid\" }]\npoints = { P = [2, 3] }\nload = [", "\"Q\"", "nearest known point is `P`"),
    ("load = [", "couple = [{ side = \"top\", point = [2, 3], kind = \"rigid\" }]\nload = [", "[2, 3]", "expected the name of a point"),
    ("load = [", "couple = [{ side = \"top\", point = \"P\", kind = \"stiff\" }]\npoints = { P = [2, 3] }\nload = [", "stiff", "`rigid`"),
    ("load = [", "couple = [{ side = \"top\", point = \"P\" }]\npoints = { P = [2, 3] }\nload = [", "{ side = \"top\", point", "needs the key `kind`"),
    ("load = [", "couple = [{ side = \"top\", point = \"P\", kind = \"rigid\" }, { side = \"left\", point = \"P\", kind = \"average\" }]\npoints = { P = [2, 3] }\nload = [", "side = \"left\", point", "two couples"),
    ("fix = [{ side = \"left\"", "couple = [{ side = \"top\", point = \"P\", kind = \"rigid\" }]\npoints = { P = [2, 3] }\nfix = [{ point = \"P\", normal = 0 }, { side = \"left\"", "normal = 0", "no normal"),
    ("fix = [{ side = \"left\"", "couple = [{ side = \"top\", point = \"P\", kind = \"rigid\" }]\npoints = { P = [2, 3] }\nfix = [{ point = \"P\", x = 0 }, { point = \"P\", x = 1 }, { side = \"left\"", "x = 1", "prescribed twice"),
    ("fix = [{ side = \"left\", x = 0.0 }", "fix = [{ side = \"left\", x = 0.0, rotation = 0 }", "rotation = 0", "only for a coupled point"),
    ("fix = [{ side = \"left\"", "points = { P = [2, 2] }\nfix = [{ point = \"P\", rotation = 0 }, { side = \"left\"", "rotation = 0", "only for a coupled point"),
    ("load = [", "load = [{ side = \"top\", moment = 1 }, ", "moment = 1", "only for a coupled point"),
    ("load = [", "couple = [{ side = \"top\", point = \"P\", kind = \"rigid\" }]\npoints = { P = [2, 3] }\nload = [{ point = \"P\", pressure = 1 }, ", "pressure = 1", "no `pressure`"),
    ("load = [", "couple = [{ side = \"top\", point = \"P\", kind = \"rigid\" }]\npoints = { P = [2, 3] }\nload = [{ point = \"P\" }, ", "{ point = \"P\" }", "needs `force` or `moment`"),
    ("load = [", "coupling = []\nload = [", "coupling", "`couple`"),
    // what takes no part
    ("gap = \"geometric\"", "exclude = [\"botom\"]", "botom", "nearest known name is `bottom`"),
    ("gap = \"geometric\"", "exclude = [\"top\"]", "exclude = [\"top\"]", "has no node of punch.bottom"),
    ("gap = \"geometric\"", "exclude = [\"bottom\"]", "exclude = [\"bottom\"]", "nothing is left"),
    ("gap = \"geometric\"", "exclude = [3]", "[3]", "expected a string"),
    ("gap = \"geometric\"", "friction_exclude = [\"left\"]", "friction_exclude", "no friction"),
    ("nonmortar = \"punch.bottom\"\nmortar = \"block.top\"", "sides = [\"punch.bottom\", \"block.top\"]\nexclude = \"left\"", "exclude = \"left\"", "both bodies"),
    // strength
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { yeld = 235e6 } }\nfix = [{ side = \"bottom\"", "yeld", "`yield`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { yield = 235e6, cohesion = 1e6 } }\nfix = [{ side = \"bottom\"", "cohesion = 1e6", "none of the keys of von Mises"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { friction_angle = 30, cohesion = 1e6, compression = 3e6 } }\nfix = [{ side = \"bottom\"", "compression = 3e6", "none of the keys of Mohr–Coulomb"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { compression = 30e6, tension = 2e6, s = 1 } }\nfix = [{ side = \"bottom\"", "s = 1", "none of the keys of principal stresses"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { yield = -235e6 } }\nfix = [{ side = \"bottom\"", "-235e6", "must be positive"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { yield = 0 } }\nfix = [{ side = \"bottom\"", "yield = 0", "must be positive"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { yield = true } }\nfix = [{ side = \"bottom\"", "true", "expected a number"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = 235e6 }\nfix = [{ side = \"bottom\"", "strength = 235e6", "expected a table"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = {} }\nfix = [{ side = \"bottom\"", "strength = {}", "one criterion"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { tension = 2e6 } }\nfix = [{ side = \"bottom\"", "strength = { tension", "one criterion"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { compression = 30e6 } }\nfix = [{ side = \"bottom\"", "strength = { compression", "needs the key `tension`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { compression = 30e6, tension = -2e6 } }\nfix = [{ side = \"bottom\"", "tension = -2e6", "must not be negative"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { friction_angle = 30 } }\nfix = [{ side = \"bottom\"", "strength = { friction_angle", "needs the key `cohesion`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { friction_angle = 90, cohesion = 1e6 } }\nfix = [{ side = \"bottom\"", "friction_angle = 90", "[0, 90) degrees"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { friction_angle = 30, cohesion = -1 } }\nfix = [{ side = \"bottom\"", "cohesion = -1", "must not be negative"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { friction_angle = 0, cohesion = 0 } }\nfix = [{ side = \"bottom\"", "cohesion = 0", "nothing is borne"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { friction_angle = 45, cohesion = 1e6, tension = 1.01e6 } }\nfix = [{ side = \"bottom\"", "tension = 1.01e6", "the apex"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { sci = 50e6, mb = 2, s = 0.01 } }\nfix = [{ side = \"bottom\"", "strength = { sci", "needs the key `a`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { sci = 0, mb = 2, s = 0.01, a = 0.5 } }\nfix = [{ side = \"bottom\"", "sci = 0", "must be positive"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { sci = 50e6, mb = -2, s = 0.01, a = 0.5 } }\nfix = [{ side = \"bottom\"", "mb = -2", "must be positive"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { sci = 50e6, mb = 2, s = 1.01, a = 0.5 } }\nfix = [{ side = \"bottom\"", "s = 1.01", "[0, 1]"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3, strength = { sci = 50e6, mb = 2, s = 0.01, a = 1.5 } }\nfix = [{ side = \"bottom\"", "a = 1.5", "(0, 1]"),
    ("\"sole.pressure\"", "\"block.utilisation\"", "utilisation", "a body without `strength`"),
    ("\"sole.pressure\"", "\"block.utilization\"", "utilization", "`utilisation`"),
    // later
    ("\"plane-strain\"", "\"3d\"", "rectangle", "makes 2D meshes"),
    ("gap = \"geometric\"", "friction = -0.3", "-0.3", "negative"),
    ("gap = \"geometric\"", "friction = { coulomb = 0.3, tresca = 1 }", "friction", "one law"),
    ("gap = \"geometric\"", "friction = { cohesion = 1, tresca = 1 }", "friction", "one law"),
    ("gap = \"geometric\"", "friction = { cohesion = -1 }", "-1 }", "negative"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ side = \"buttom\", normal = 1 }]\nfix = [{ side = \"bottom\"", "\"buttom\"", "no side `buttom`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ side = \"bottom\" }]\nfix = [{ side = \"bottom\"", "{ side = \"bottom\" }", "without a stiffness"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ side = \"bottom\", normal = -1 }]\nfix = [{ side = \"bottom\"", "-1 }", "must not be negative"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ side = \"bottom\", normal = \"1e9*t\" }]\nfix = [{ side = \"bottom\"", "t\" }", "the same at all times"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ side = \"bottom\", tangential = \"-1 - x^2\" }]\nfix = [{ side = \"bottom\"", "\"-1 - x^2\"", "`tangential` of a spring is -"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ side = \"bottom\", normal = 1, y = 2 }]\nfix = [{ side = \"bottom\"", "y = 2", "no `y`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ side = \"bottom\", tangential = 1, compression_only = true }]\nfix = [{ side = \"bottom\"", "compression_only", "along the normal"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ point = [0, 0], normal = 1 }]\nfix = [{ side = \"bottom\"", "normal", "no `normal`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ point = [0, 0], z = 1 }]\nfix = [{ side = \"bottom\"", "z = 1", "have no `z`"),
    ("poisson = 0.3 }\nfix = [{ side = \"bottom\"", "poisson = 0.3 }\nspring = [{ normal = 1 }]\nfix = [{ side = \"bottom\"", "{ normal = 1 }", "needs `side` or `point`"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"block\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 1e-4\n", "name = \"block\"\nfrom", "names a body already"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 7.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 1e-4\n", "[1, 7.5]", "in none of the bodies block"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [2, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 1e-4\n", "to = [2, 0.5]", "same place"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nyoung = 1e9\narea = 1e-4\n", "[[bar]]", "in which bodies"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"blick\"]\nyoung = 1e9\narea = 1e-4\n", "\"blick\"", "no body `blick`"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 0\n", "area = 0", "`area`"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 1e-4\nbond = \"glued\"", "\"glued\"", "bond"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 1e-4\nprestress = 5\nyield = 2", "prestress = 5", "at most yield times area"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 1e-4\nspacing = 0", "spacing = 0", "`spacing`"),
    ("gap = \"geometric\"", "friction = 0\n[[bar]]\nname = \"bolt\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nyoung = 1e9\narea = 1e-4\nactive = { from = \"later\" }", "\"later\"", "no step"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"block\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\n", "name = \"block\"\nfrom", "names a body already"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [1, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\n", "to = [1, 0.5]", "same place"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 7.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\n", "[1, 7.5]", "in none of the bodies block"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nstiffness = 1e9\n", "[[spring]]", "in which bodies"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\n", "[[spring]]", "`stiffness`"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = -1\n", "stiffness = -1", "`stiffness` must be positive"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\nacts = \"pull\"", "\"pull\"", "unknown way to act"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\ngap = 0.1", "gap = 0.1", "acts both ways"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\nacts = \"compression\"\ngap = -0.1", "gap = -0.1", "zero or positive"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\nprestress = 5", "prestress", "unknown key `prestress`"),
    ("gap = \"geometric\"", "friction = 0\n[[spring]]\nname = \"buffer\"\nfrom = [1, 0.5]\nto = [2, 0.5]\nbodies = [\"block\"]\nstiffness = 1e9\nspacing = 0", "spacing = 0", "`spacing`"),
    ("gap = \"geometric\"", "friction = { cohesion = 1, coulomb = 0.5, tension = 3 }", "tension = 3", "more tension than its cohesion allows"),
    ("gap = \"geometric\"", "friction = { coulomb = 0.5, tension = 3 }", "tension", "has tension and no cohesion"),
];

const GOOD_IN_SPACE: &str = r#"title = "Block on a block"
analysis = "3d"

[[body]]
name = "block"
mesh = { box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }
material = { young = 210e9, poisson = 0.3 }
fix = [{ side = "bottom", x = 0.0, y = 0.0, z = 0.0 }]

[[body]]
name = "punch"
mesh = { box = { from = [1, 0, 1], to = [3, 2, 2], cells = [2, 2, 1], cell = "hex8" } }
material = { young = 210e9, poisson = 0.3 }
points = { eye = [2, 1, 3] }
couple = [{ side = "top", point = "eye", kind = "average" }]
fix = [{ point = "eye", x = 0.0, y = 0.0, rotation = { x = 0, y = 0, z = 0 } }]
load = [{ point = "eye", force = [0, 0, -1e6], moment = [0, 0, 0] }]

[[contact]]
name = "sole"
nonmortar = "punch.bottom"
mortar = "block.top"

[[contact]]
name = "wall"
nonmortar = "punch.right"
obstacle = { sphere = { center = [9, 1, 2], radius = 5 }, displacement = [0, 0, 0] }
friction = 0.2

[[probe]]
name = "middle"
quantity = "sole.pressure"
at = [2, 1, 1]
"#;

#[rustfmt::skip]
const IN_SPACE: &[Mistake] = &[
    // components: two where three are needed
    ("from = [0, 0, 0]", "from = [0, 0]", "from = [0, 0]", "expected 3 numbers, found 2"),
    ("to = [4, 2, 1]", "to = [4, 2]", "to = [4, 2]", "third is missing"),
    ("cells = [4, 2, 1]", "cells = [4, 2]", "cells = [4, 2]", "expected 3 positive integers"),
    ("at = [2, 1, 1]", "at = [2, 1]", "at = [2, 1]", "expected 3 numbers, found 2"),
    ("eye = [2, 1, 3]", "eye = [2, 1]", "eye = [2, 1]", "expected 3 numbers"),
    ("force = [0, 0, -1e6]", "force = [0, -1e6]", "force = [0, -1e6]", "expected 3 numbers or expressions, found 2"),
    ("moment = [0, 0, 0]", "moment = 3.0", "moment = 3.0", "a list of 3 numbers"),
    ("rotation = { x = 0, y = 0, z = 0 }", "rotation = 0.0", "rotation = 0.0", "expected a table"),
    ("rotation = { x = 0, y = 0, z = 0 }", "rotation = {}", "rotation = {}", "prescribes nothing"),
    ("rotation = { x = 0, y = 0, z = 0 }", "rotation = { w = 0 }", "rotation = { w", "unknown key `w`"),
    ("center = [9, 1, 2]", "center = [9, 1]", "center = [9, 1]", "expected 3 numbers"),
    ("displacement = [0, 0, 0]", "displacement = [0, 0]", "displacement = [0, 0]", "found 2"),
    ("poisson = 0.3 }\nfix", "poisson = 0.3 }\nbody_force = [0, -9.81]\nfix", "body_force", "found 2"),
    ("cell = \"hex8\" } }", "cell = \"hex8\" }, sides = { foot = { of = \"bottom\", min = [1, 0], max = [2, 2, 1] } } }", "min = [1, 0]", "found 2"),
    // words of the plane
    ("\"3d\"", "\"plane-strain\"", "box", "makes 3D meshes, and the analysis is in 2D"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ rectangle = { from = [0, 0], to = [4, 2], cells = [4, 2] } }", "rectangle", "makes 2D meshes, and the analysis is in 3D"),
    ("cell = \"hex8\"", "cell = \"quad4\"", "quad4", "a cell of 2D meshes"),
    ("cell = \"hex8\"", "cell = \"hex9\"", "hex9", "`hex8`"),
    ("sphere = { center", "circle = { center", "circle", "`circle` is a shape of 2D analyses"),
    ("material = { young = 210e9, poisson = 0.3 }\npoints", "material = { young = 210e9, poisson = 0.3 }\nsurface = { right = { circle = { center = [0, 0], radius = 1 } } }\npoints", "circle", "`circle` is a shape of 2D"),
    ("poisson = 0.3 }\nfix", "poisson = 0.3, thickness = 2 }\nfix", "thickness", "no meaning in a 3D analysis"),
    ("\"sole.pressure\"", "\"block.stress.hoop\"", "hoop", "`xz`"),
    // quantities
    ("\"sole.pressure\"", "\"block.stress.zy\"", "zy", "`yz`"),
    ("\"sole.pressure\"", "\"sole.resultant\"", "sole.resultant", "add one of `x`, `y`, `z`"),
    ("at = [2, 1, 1]", "along = { from = [1, 1, 1], to = [3, 1], points = 3 }", "to = [3, 1]", "found 2"),
    ("at = [2, 1, 1]", "along = \"punch.bottom\"", "along", "have no order"),
    ("at = [2, 1, 1]", "at = [9, 1, 1]", "at = [9", "(9, 1, 1)"),
    ("at = [2, 1, 1]", "at = [2, 1, 1.8]", "at = [2", "(2, 1, 1.8)"),
    // sides and shapes
    ("\"punch.bottom\"", "\"punch.under\"", "punch.under", "`bottom`"),
    ("sphere = { center = [9, 1, 2], radius = 5 }", "cylinder = { point = [9, 1, 2], axis = [0, 0, 0], radius = 5 }", "axis = [0, 0, 0]", "axis of a cylinder is zero"),
    ("sphere = { center = [9, 1, 2], radius = 5 }", "cylinder = { point = [9, 1, 2], radius = 5 }", "cylinder", "needs the key `axis`"),
    ("sphere = { center = [9, 1, 2], radius = 5 }", "sphere = { center = [9, 1, 2], radius = -5 }", "-5", "must be positive"),
    ("sphere = { center = [9, 1, 2], radius = 5 }", "plane = { point = [9, 1, 2], normal = [1, 0] }", "normal = [1, 0]", "found 2"),
    ("from = [1, 0, 1]", "from = [1, 0, 3]", "from = [1, 0, 3]", "punch"),
    ("cells = [4, 2, 1]", "cells = [1000, 1000, 1000]", "1000", "cells in one body"),
    ("cells = [4, 2, 1] }", "cells = [300, 300, 300], cell = \"tet4\" }", "cells = [300", "162000000 cells"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{}", "mesh = {}", "`box`"),
    // cylinders, spheres and extruded meshes
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ cylinder = { base = [0, 0, 0], axis = [0, 0, 1], radius = 2, height = 1, from = 0, cells = [8, 2, 1] } }", "from = 0", "needs both `from` and `to`"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ cylinder = { base = [0, 0, 0], axis = [0, 0, 1], radius = 2, height = 1, cells = [8, 2] } }", "cells = [8, 2]", "found 2"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ cylinder = { base = [0, 0, 0], axis = [0, 0, 0], radius = 2, height = 1, cells = [8, 2, 1] } }", "cylinder", "axis"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ sphere = { center = [0, 0, 0], radius = 2, inner = 3, cells = [8, 2] } }", "sphere", "inner"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ sphere = { center = [0, 0, 0], radius = 2, cells = [1400, 1] } }", "cells = [1400, 1]", "43610000 cells"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ cylinder = { base = [0, 0, 0], axis = [0, 0, 1], radius = 2, height = 1, cells = [20000, 1, 1] } }", "cells = [20000", "25020000 cells"),
    ("poisson = 0.3 }\npoints", "poisson = 0.3 }\nsurface = { right = { sphere = { center = [0, 0, 0], radius = 1, inside = true } } }\npoints", "inside", "has no `inside`"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ extrude = { mesh = { rectangle = { from = [0, 0], to = [4, 2], cells = [4, 2] } }, layers = 2 } }", "extrude", "needs `height` or `turn`"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ extrude = { mesh = { box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }, height = 1, layers = 2 } }", "box", "makes 3D meshes, and `extrude` takes 2D ones"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ extrude = { mesh = { rectangle = { from = [-1, 0], to = [4, 2], cells = [5, 2] } }, turn = { point = [0, 0, 0], axis = [0, 1, 0], angle = 90 }, layers = 4 } }", "extrude", "axis"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ extrude = { mesh = { rectangle = { from = [0, 0], to = [4, 2], cells = [4, 2] } }, height = 0, layers = 2 } }", "0, layers", "must not be zero"),
    ("{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }", "{ extrude = { mesh = { rectangle = { from = [0, 0], to = [4, 2], cells = [4, 2] } }, turn = { point = [0, 0, 0], axis = [1, -1, 0], angle = 90 }, layers = 4 } }", "extrude", "have a whole edge on it"),
    ("\"sole.pressure\"", "\"sole.moment\"", "sole.moment", "add one of `x`, `y`, `z`"),
    ("at = [2, 1, 1]", "at = [2, 1, 1]\ncenter = [0, 0, 0]", "center = [0, 0, 0]", "belongs to moments"),
    ("x = 0.0, y = 0.0, z = 0.0", "w = 0.0", "w = 0.0", "unknown key `w`"),
    ("{ side = \"bottom\", x = 0.0, y = 0.0, z = 0.0 }", "{ side = \"bottom\" }", "{ side = \"bottom\" }", "`x`, `y`, `z` or `normal`"),
];

/// Mistakes of mechanics in space, and words of the message.
const IN_THE_MODEL_IN_SPACE: &[(&str, &str, &[&str])] = &[
    // the load lifts the punch off, and no wall is there
    (
        "-1e6], moment = [0, 0, 0] }]\n\n[[contact]]\nname = \"sole\"\nnonmortar = \"punch.bottom\"\nmortar = \"block.top\"\n\n\
         [[contact]]\nname = \"wall\"\nnonmortar = \"punch.right\"\n\
         obstacle = { sphere = { center = [9, 1, 2], radius = 5 }, displacement = [0, 0, 0] }\nfriction = 0.2\n",
        "1e6], moment = [0, 0, 0] }]\n\n[[contact]]\nname = \"sole\"\nnonmortar = \"punch.bottom\"\nmortar = \"block.top\"\n",
        &["punch", "z"],
    ),
    // two values for one node
    (
        "z = 0.0 }]\n\n[[body]]",
        "z = 0.0 }, { side = \"left\", z = 1e-3 }]\n\n[[body]]",
        &["block"],
    ),
    // no node is near this point
    (
        "fix = [{ side = \"bottom\"",
        "fix = [{ point = [9, 9, 9], x = 0 }, { side = \"bottom\"",
        &["block", "9"],
    ),
    // a load that is not finite at a point of the side
    (
        "load = [",
        "load = [{ side = \"front\", pressure = \"sqrt(z - 1.5)\" }, ",
        &["punch", "front"],
    ),
];

/// Mistakes of mechanics, which only assembling or solving finds: what is replaced, by what, words of the message.
const IN_THE_MODEL: &[(&str, &str, &[&str])] = &[
    // nothing holds the block
    (
        "fix = [{ side = \"bottom\", x = 0.0, y = 0.0 }]\n",
        "",
        &["block"],
    ),
    // the punch hangs on nothing
    (
        "[[contact]]\nname = \"sole\"\nnonmortar = \"punch.bottom\"\nmortar = \"block.top\"\ngap = \"geometric\"\n\n\
         [solver]\nmethod = \"uzawa\"\ntolerance = 1e-8\nrho = 1e9\n\n\
         [[probe]]\nname = \"middle\"\nquantity = \"sole.pressure\"\nat = [2.0, 1.0]\n",
        "",
        &["punch", "y"],
    ),
    // the load lifts the punch off
    ("\"-1e6 * (1 + 0.1*x)\"", "1e6", &["punch", "y"]),
    // no node is near this point
    (
        "{ side = \"left\", x = 0.0 }",
        "{ point = [9.0, 9.0], x = 0.0 }",
        &["punch", "9"],
    ),
    // the corner cannot be in two places
    (
        "{ side = \"left\", x = 0.0 }",
        "{ side = \"left\", x = 0.0 }, { side = \"top\", x = 1e-3 }",
        &["punch"],
    ),
    // a load that is not finite at a point of the side
    (
        "\"-1e6 * (1 + 0.1*x)\"",
        "\"-1e6*sqrt(x - 2)\"",
        &["punch", "top"],
    ),
    // outside of the contact
    (
        "at = [2.0, 1.0]",
        "at = [9.0, 1.0]",
        &["middle", "at = [9.0, 1.0]"],
    ),
    (
        "at = [2.0, 1.0]",
        "along = { from = [1, 1], to = [2, 1], points = 3 }",
        &["middle", "(1, 1)", "along = {"],
    ),
    (
        "at = [2.0, 1.0]",
        "along = \"block.top\"",
        &["block.top", "punch.bottom", "along = \"block"],
    ),
    (
        "quantity = \"sole.pressure\"\nat = [2.0, 1.0]",
        "quantity = \"punch.stress.xx\"\nalong = { from = [0, 0], to = [0, 1], points = 3 }",
        &["middle", "no point of the line", "along = {"],
    ),
    (
        "quantity = \"sole.pressure\"\nat = [2.0, 1.0]",
        "quantity = \"punch.stress.xx\"\nalong = \"block.top\"",
        &["block.top", "punch", "along = \"block"],
    ),
];

/// A fresh folder for one test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("bad_input")
        .join(name);
    if path.exists() {
        std::fs::remove_dir_all(&path).unwrap();
    }
    std::fs::create_dir_all(&path).unwrap();
    path
}

const GOOD_SECTION: &str = r#"analysis = "plane-strain"

[[body]]
name = "wall"
mesh = { rectangle = { from = [0, 0], to = [0.3, 3], cells = [2, 12], cell = "quad8" } }
material = { young = 30e6, poisson = 0.2 }
fix = [{ side = "bottom", x = 0, y = 0 }]
load = [{ side = "top", traction = [1, -100] }]

[[body]]
name = "block"
mesh = { rectangle = { from = [0.3, 0], to = [2, 3], cells = [2, 6] } }
material = { young = 30e6, poisson = 0.2 }
fix = [{ side = "bottom", x = 0, y = 0 }]

[[contact]]
name = "joint"
sides = ["wall.right", "block.left"]

[[section]]
name = "cut"
body = "wall"
sides = ["left", "right"]
stations = 7
capacity = { compression = 20e3, tension = 2e3 }
reinforcement = [{ depth = 0.05, area = 1e-3, yield = 435e3 }]

[[section]]
name = "points"
body = "wall"
sides = ["right", "left"]
stations = [[0.15, 1.0], [0.2, 2.5]]

[[probe]]
name = "largest"
quantity = "cut.M"
reduce = "max"
"#;

const SECTION_IN_SPACE: &str = r#"
[[section]]
name = "cut"
body = "block"
sides = ["front", "back"]
axis = [0, 0, 1]
stations = [[2, 1, 0.5], [3, 1, 0.5]]
places = 3
"#;

#[rustfmt::skip]
const IN_A_SECTION_IN_SPACE: &[Mistake] = &[
    ("axis = [0, 0, 1]\nstations", "stations", "sides = [\"front\"", "`axis` tells that of extrusion"),
    ("axis = [0, 0, 1]\nstations", "axis = [0, 0, 0]\nstations", "axis = [0, 0, 0]", "is zero"),
    ("axis = [0, 0, 1]\nstations", "axis = [0, 1, 0]\nstations", "axis = [0, 1, 0]", "do not run along its `axis`"),
    ("axis = [0, 0, 1]\nstations", "axis = [0, 1]\nstations", "axis = [0, 1]", "expected 3 numbers"),
    ("sides = [\"front\", \"back\"]\naxis", "sides = [\"front\", \"left\"]\naxis", "sides = [\"front\", \"left\"]", "meet"),
    ("[2, 1, 0.5]", "[2, 1]", "[2, 1]", "expected 3 numbers"),
    ("[3, 1, 0.5]", "[5, 1, 0.5]", "[5, 1, 0.5]", "lies beside the body"),
    ("[3, 1, 0.5]", "[3, 1, 1.5]", "[3, 1, 1.5]", "lies beside the body"),
    ("places = 3", "places = 0", "places = 0", "positive integer"),
    ("places = 3", "places = 1001", "places = 1001", "at most 1000"),
    ("places = 3", "places = [3]", "places = [3]", "positive integer"),
];

#[rustfmt::skip]
const IN_A_SECTION: &[Mistake] = &[
    ("body = \"wall\"\nsides = [\"left\"", "body = \"wal\"\nsides = [\"left\"", "\"wal\"", "`wall`"),
    ("sides = [\"left\", \"right\"]", "sides = [\"left\", \"rigth\"]", "rigth", "`right`"),
    ("sides = [\"left\", \"right\"]", "sides = [\"left\"]", "sides = [\"left\"]", "needs two sides"),
    ("sides = [\"left\", \"right\"]", "sides = [\"left\", \"left\"]", "sides = [\"left\", \"left\"]", "meet"),
    ("sides = [\"left\", \"right\"]", "sides = [\"left\", \"top\"]", "sides = [\"left\", \"top\"]", "meet"),
    ("sides = [\"left\", \"right\"]", "sides = [\"bottom\", \"top\"]", "sides = [\"bottom\", \"top\"]", "not long ones"),
    ("sides = [\"left\", \"right\"]", "sides = [[\"left\", \"left\"], \"right\"]", "sides = [[", "listed twice"),
    ("stations = 7", "stations = 7\nplaces = 3", "places = 3", "those of sections in space"),
    ("stations = 7", "stations = 7\naxis = [0, 1]", "axis = [0, 1]", "those of sections in space"),
    ("stations = 7", "stations = 1", "stations = 1", "2 to 10000"),
    ("stations = 7", "stations = 0", "stations = 0", "positive integer"),
    ("stations = 7", "stations = []", "stations = []", "empty"),
    ("stations = 7", "stations = true", "stations = true", "a number of stations or a list of points"),
    ("stations = 7\n", "", "[[section]]\nname = \"cut\"", "needs the key `stations`"),
    ("[0.2, 2.5]", "[0.9, 2.5]", "[0.9, 2.5]", "lies beside the body"),
    ("[0.2, 2.5]", "[0.15, 3.5]", "[0.15, 3.5]", "lies beside the body"),
    ("[0.2, 2.5]", "[0.2, 2.5, 1]", "[0.2, 2.5, 1]", "expected 2 numbers"),
    ("compression = 20e3", "compression = -20e3", "compression = -20e3", "must be positive"),
    ("tension = 2e3", "tension = -2e3", "tension = -2e3", "must not be negative"),
    ("compression = 20e3, ", "", "capacity", "needs the key `compression`"),
    ("capacity = { compression = 20e3, tension = 2e3 }\n", "", "reinforcement =", "no strength"),
    ("tension = 2e3 }", "tension = 2e3, reinforcement = [] }", "reinforcement = [{", "beside it"),
    ("depth = 0.05", "depth = 0.35", "depth = 0.35", "outside of the section"),
    ("area = 1e-3", "area = 0", "area = 0", "must be positive"),
    ("yield = 435e3", "yields = 435e3", "yields", "`yield`"),
    ("name = \"points\"", "name = \"joint\"", "name = \"joint\"\nbody", "a contact already"),
    ("name = \"points\"", "name = \"block\"", "name = \"block\"\nbody = \"wall\"", "a body already"),
    ("name = \"points\"", "name = \"cut\"", "name = \"cut\"\nbody = \"wall\"\nsides = [\"right\"", "two sections are named"),
    ("name = \"joint\"", "name = \"block\"", "name = \"block\"\nsides", "a body already"),
    ("cut.M", "cut.Q", "Q", "unknown quantity of a section"),
    ("cut.M", "cut", "cut\"\nreduce", "ends after"),
    ("cut.M", "cit.M", "cit.M", "`cut`"),
    ("cut.M", "points.utilisation", "points.utilisation", "no capacity"),
    ("reduce = \"max\"", "along = \"wall.left\"", "along", "known at stations"),
    ("reduce = \"max\"\n", "", "[[probe]]", "must say where"),
];

fn dotyk(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dotyk"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn replaced(from: &str, to: &str) -> String {
    replaced_in(GOOD, from, to)
}

fn replaced_in(good: &str, from: &str, to: &str) -> String {
    let text = good.replacen(from, to, 1);
    assert_ne!(text, good, "nothing is replaced by {to}");
    text
}

/// Checks what holds for every refusal, and returns the message.
#[track_caller]
fn refused(output: &Output, what: &str) -> String {
    let message = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(2), "{what}: {message}");
    assert!(output.stdout.is_empty(), "{what}: results are printed");
    for internal in ["panicked", "RUST_BACKTRACE", "unwrap", "\u{1b}["] {
        assert!(!message.contains(internal), "{what}: {message}");
    }
    let headlines = message.lines().filter(|line| line.starts_with("  x "));
    assert_eq!(headlines.count(), 1, "{what}: {message}");
    message
}

/// The line of the text on which `mark` begins, from 1; a leading line end of `mark` is only context.
fn line_of(text: &str, mark: &str) -> usize {
    let skip = usize::from(mark.starts_with('\n'));
    let at = text.find(mark).unwrap() + skip;
    text[..at].matches('\n').count() + 1
}

#[test]
fn every_mistake_in_the_text_is_underlined_on_its_line() {
    each_is_underlined(&folder("text"), GOOD, IN_THE_TEXT);
}

#[test]
fn every_mistake_in_space_is_underlined_on_its_line() {
    let folder = folder("space");
    each_is_underlined(&folder, GOOD_IN_SPACE, IN_SPACE);
    std::fs::write(folder.join("good.toml"), GOOD_IN_SPACE).unwrap();
    let output = dotyk(&folder, &["run", "good.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn every_mistake_in_a_section_is_underlined_on_its_line() {
    let folder = folder("section");
    each_is_underlined(&folder, GOOD_SECTION, IN_A_SECTION);
    std::fs::write(folder.join("good.toml"), GOOD_SECTION).unwrap();
    let output = dotyk(&folder, &["run", "good.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let head = format!("{GOOD_IN_SPACE}\n{SECTION_IN_SPACE}");
    each_is_underlined(&folder, &head, IN_A_SECTION_IN_SPACE);
    std::fs::write(folder.join("good.toml"), &head).unwrap();
    let output = dotyk(&folder, &["run", "good.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[track_caller]
fn each_is_underlined(folder: &Path, good: &str, mistakes: &[Mistake]) {
    for (from, to, mark, words) in mistakes {
        let text = replaced_in(good, from, to);
        std::fs::write(folder.join("bad.toml"), &text).unwrap();
        let message = refused(&dotyk(folder, &["run", "bad.toml"]), to);
        let line = format!("bad.toml, line {}, column ", line_of(&text, mark));
        assert!(message.contains(&line), "{to}: no \"{line}\" in {message}");
        assert!(message.contains(words), "{to}: no \"{words}\" in {message}");
        assert!(!folder.join("bad-out").exists(), "{to}: a result folder");
    }
}

#[test]
fn every_mistake_in_the_text_stops_check_as_well() {
    let folder = folder("check");
    for (from, to, ..) in IN_THE_TEXT.iter().step_by(7) {
        std::fs::write(folder.join("bad.toml"), replaced(from, to)).unwrap();
        refused(&dotyk(&folder, &["check", "bad.toml", "--out", "page"]), to);
        assert!(!folder.join("page").exists(), "{to}: a result folder");
    }
}

#[test]
fn every_mistake_of_mechanics_names_its_body_and_leaves_no_files() {
    each_names_its_body(&folder("model"), GOOD, IN_THE_MODEL);
}

#[test]
fn every_mistake_of_mechanics_in_space_names_its_body() {
    each_names_its_body(&folder("space_model"), GOOD_IN_SPACE, IN_THE_MODEL_IN_SPACE);
}

#[track_caller]
fn each_names_its_body(folder: &Path, good: &str, mistakes: &[(&str, &str, &[&str])]) {
    for (from, to, words) in mistakes {
        std::fs::write(folder.join("bad.toml"), replaced_in(good, from, to)).unwrap();
        let message = refused(&dotyk(folder, &["run", "bad.toml", "--quiet"]), to);
        assert!(message.contains("bad.toml"), "{to}: {message}");
        for word in *words {
            assert!(message.contains(word), "{to}: no \"{word}\" in {message}");
        }
        assert!(!folder.join("bad-out").exists(), "{to}: a result folder");
    }
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = folder("unreadable");
    std::fs::create_dir(folder.join("folder.toml")).unwrap();
    std::fs::write(folder.join("latin.toml"), b"title = \"\xe9\"").unwrap();
    std::fs::write(folder.join("empty.toml"), "").unwrap();
    for (file, words) in [
        ("missing.toml", "no such file"),
        ("folder.toml", "folder"),
        ("latin.toml", "UTF-8"),
        ("empty.toml", "analysis"),
    ] {
        for command in ["run", "check", "compare"] {
            let message = refused(&dotyk(&folder, &[command, file]), file);
            assert!(
                message.contains(file) && message.contains(words),
                "{message}"
            );
        }
    }
}

#[test]
fn mesh_files_of_the_other_dimension_are_refused_at_their_place() {
    let folder = folder("mesh_files");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../dotyk/tests/data");
    for name in ["gmsh_pipe_tet4_41.msh", "gmsh_nogroups_41.msh"] {
        std::fs::copy(data.join(name), folder.join(name)).unwrap();
    }
    let box_of = "{ box = { from = [0, 0, 0], to = [4, 2, 1], cells = [4, 2, 1] } }";
    let rectangle = "{ rectangle = { from = [0.0, 0.0], to = [4.0, 1.0], cells = [8, 2] } }";
    let file = |rest: &str| format!("{{ file = {{ path = \"{rest} }} }}");
    for (good, from, file, mark, words) in [
        // a plane mesh in space, a shell, a group that is not there, a mesh of space in the plane
        (
            GOOD_IN_SPACE,
            box_of,
            file("gmsh_nogroups_41.msh\""),
            "path",
            "a mesh of the plane",
        ),
        (
            GOOD_IN_SPACE,
            box_of,
            file("gmsh_pipe_tet4_41.msh\", group = \"outer\""),
            "\"outer\"",
            "a shell",
        ),
        (
            GOOD_IN_SPACE,
            box_of,
            file("gmsh_pipe_tet4_41.msh\", group = \"pip\""),
            "\"pip\"",
            "`pipe`",
        ),
        (
            GOOD,
            rectangle,
            file("gmsh_pipe_tet4_41.msh\""),
            "path",
            "gmsh_pipe",
        ),
    ] {
        let text = replaced_in(good, from, &file);
        std::fs::write(folder.join("bad.toml"), &text).unwrap();
        let message = refused(&dotyk(&folder, &["run", "bad.toml"]), &file);
        let line = format!("bad.toml, line {}, column ", line_of(&text, mark));
        assert!(message.contains(&line), "{file}: {message}");
        assert!(message.contains(words), "{file}: {message}");
        assert!(!folder.join("bad-out").exists(), "{file}: a result folder");
    }
    // a body out of such a file
    let text = GOOD_IN_SPACE.split("[[body]]").take(2).collect::<Vec<_>>();
    let pipe = replaced_in(
        &text.join("[[body]]"),
        box_of,
        &file("gmsh_pipe_tet4_41.msh\", group = \"pipe\""),
    );
    std::fs::write(folder.join("pipe.toml"), pipe).unwrap();
    let output = dotyk(&folder, &["run", "pipe.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn an_output_folder_that_cannot_be_is_refused_before_solving() {
    let folder = folder("output");
    std::fs::write(folder.join("good.toml"), GOOD).unwrap();
    std::fs::write(folder.join("file"), "mine").unwrap();
    for out in ["file", "file/below"] {
        let message = refused(&dotyk(&folder, &["run", "good.toml", "--out", out]), out);
        assert!(
            message.contains("file") && message.contains("--out"),
            "{message}"
        );
    }
    assert_eq!(
        std::fs::read_to_string(folder.join("file")).unwrap(),
        "mine"
    );
}

#[test]
fn arguments_that_make_no_sense_are_refused() {
    let folder = folder("arguments");
    std::fs::write(folder.join("good.toml"), GOOD).unwrap();
    for (arguments, words) in [
        (&["run"][..], "CASE"),
        (&["run", "good.toml", "--solver", "uzava"], "uzawa"),
        (
            &["run", "good.toml", "--solver", "newton", "--rho", "1e9"],
            "--rho",
        ),
        (&["run", "good.toml", "--rho", "-1"], "--rho"),
        (&["run", "good.toml", "--rho=-1"], "positive number"),
        (&["run", "good.toml", "--threads", "0"], "--threads"),
        (&["run", "good.toml", "--treads", "2"], "--threads"),
        (&["compare", "good.toml", "--rho", "2..1"], "A < B"),
        (&["compare", "good.toml", "--rho", "1"], "A..B"),
        (&["solve", "good.toml"], "solve"),
        (&["verify", "nowhere"], "nowhere"),
        (&["verify", "good.toml"], "folder"),
        (&["verify"], "cases"),
    ] {
        let output = dotyk(&folder, arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(words), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
    }
}

#[test]
fn mistakes_in_a_reference_file_are_found_before_solving() {
    let folder = folder("reference");
    std::fs::create_dir(folder.join("punch")).unwrap();
    let line = "\n[[probe]]\nname = \"line\"\nquantity = \"sole.gap\"\nalong = \"punch.bottom\"\n";
    std::fs::write(folder.join("punch/good.toml"), GOOD.to_string() + line).unwrap();
    let reference = "[[value]]\ncase = \"good.toml\"\nprobe = \"middle\"\nkind = \"analytic\"\nvalue = 1\ntolerance = 0.1\n";
    for (from, to, line, words) in [
        ("good.toml", "god.toml", 2, "god.toml"),
        ("\"middle\"", "\"midle\"", 3, "`middle`"),
        ("\"middle\"", "\"line\"", 3, "values along a line"),
        ("value = 1", "step = 2\nvalue = 1", 5, "no step 2"),
        ("value = 1", "step = 0\nvalue = 1", 5, "`step`"),
        ("analytic", "exact", 4, "`published`"),
        ("value = 1", "valeu = 1", 5, "`value`"),
        ("tolerance = 0.1", "tolerance = -1", 6, "negative"),
        ("tolerance = 0.1", "judged = false", 6, "published"),
        ("tolerance = 0.1", "", 1, "`tolerance` or `band`"),
        (
            "case = \"good.toml\"",
            "cases = [\"good.toml\", \"god.toml\"]",
            2,
            "god.toml",
        ),
        (
            "tolerance = 0.1",
            "tolerance = 0.1\nagainst = \"bad.toml\"",
            7,
            "bad.toml",
        ),
        (
            "case = \"good.toml\"",
            "cases = [\"good.toml\", \"good.toml\"]",
            2,
            "listed twice",
        ),
    ] {
        let text = reference.replacen(from, to, 1);
        std::fs::write(folder.join("punch/reference.toml"), text).unwrap();
        let message = refused(&dotyk(&folder, &["verify", "punch"]), to);
        let place = format!("reference.toml, line {line}, column ");
        assert!(
            message.contains(&place) && message.contains(words),
            "{message}"
        );
    }
    std::fs::remove_file(folder.join("punch/good.toml")).unwrap();
    let message = refused(&dotyk(&folder, &["verify", "punch"]), "no case");
    assert!(message.contains("no case file"), "{message}");
}
