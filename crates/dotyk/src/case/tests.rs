//! Models of case files, and messages of their mistakes.

use super::*;
use crate::geometry::{Field, Surface};
use crate::mesh::CellKind;
use crate::model::{
    BodyId, Gap, Law, Load, Motion, Pair, Pairing, Place, Reading, Rigid, Subdomains,
};

/// The example of the documentation.
const EXAMPLE: &str = r#"
title    = "Floating punch on a block"
source   = "verification case of this project"
analysis = "plane-strain"            # plane-strain | plane-stress | axisymmetric | 3d
units    = { length = "m", force = "N" }

[[body]]
name     = "block"
mesh     = { rectangle = { from = [0.0, 0.0], to = [4.0, 1.0], cells = [80, 20], cell = "quad4" } }
material = { young = 210e9, poisson = 0.3 }        # thickness = 1.0 (plane stress and plane strain)
fix      = [{ side = "bottom", x = 0.0, y = 0.0 }]

[[body]]
name     = "punch"
mesh     = { rectangle = { from = [1.5, 1.0], to = [2.5, 2.0], cells = [20, 20] } }
material = { young = 210e9, poisson = 0.3 }
fix      = [{ side = "left", x = 0.0 }, { side = "right", x = 0.0 }]
load     = [{ side = "top", traction = [0.0, "-1e6 * (1 + 0.1*x)"] }]

[[contact]]
name      = "sole"
nonmortar = "punch.bottom"
mortar    = "block.top"
gap       = "geometric"
friction  = 0.0

[solver]
method    = "auto"
tolerance = 1e-8

[[probe]]
name     = "middle pressure"
quantity = "sole.pressure"
at       = [2.0, 1.0]
"#;

/// A case in which parameters have these values.
fn read_given(
    text: &str,
    name: &str,
    folder: &Path,
    given: &[(String, String)],
) -> Result<Case<2>, CaseError> {
    of_source(Source::parse(text, name, folder, given, &Arc::default())?)
}

fn read(text: &str) -> Result<Case<2>, CaseError> {
    Case::<2>::from_str(text, "punch.toml", Path::new(""))
}

fn example(from: &str, to: &str) -> String {
    assert_eq!(EXAMPLE.matches(from).count(), 1, "{from}");
    EXAMPLE.replace(from, to)
}

fn model_with(from: &str, to: &str) -> Model<2> {
    read(&example(from, to)).unwrap().model
}

/// The message, and the text that is underlined.
fn mistake(from: &str, to: &str) -> (String, String) {
    let text = example(from, to);
    let error = read(&text).unwrap_err();
    let span = error.span.clone().unwrap();
    let help = error.help.as_deref().unwrap_or_default();
    let message = format!("{} | {} | {help}", error.message, error.label);
    (message, text[span].to_string())
}

#[track_caller]
fn assert_mistake(from: &str, to: &str, underlined: &str, fragments: &[&str]) {
    let (message, span) = mistake(from, to);
    for fragment in fragments {
        assert!(message.contains(fragment), "{fragment}: {message}");
    }
    assert_eq!(span, underlined, "{message}");
}

#[test]
fn the_example_of_the_documentation_parses() {
    let case = read(EXAMPLE).unwrap();
    assert_eq!(case.stem, "punch");
    let model = case.model;
    assert_eq!(model.title, "Floating punch on a block");
    assert_eq!(model.analysis, Analysis::PlaneStrain);
    assert_eq!(model.units.force.as_deref(), Some("N"));
    assert_eq!(model.times, [1.0]);
    let [block, punch] = &model.bodies[..] else {
        panic!("two bodies")
    };
    assert_eq!((block.thickness, block.supports.len()), (1.0, 1));
    assert_eq!(punch.materials[0].elastic.young, 210e9);
    assert!(punch.supports[0].components[1].is_none());
    let Load::Traction { traction, .. } = &punch.loads[0] else {
        panic!("a traction")
    };
    assert_eq!(traction[1].at([2.0, 0.0], 0.0), -1.2e6);
    let contact = &model.contacts[0];
    assert!(matches!(&contact.pair, Pair::Given { nonmortar, .. } if nonmortar.body.0 == 1));
    assert!(matches!(contact.gap, Some(Gap::Geometric)));
    assert!(matches!(contact.law, Law::Frictionless));
    assert_eq!(model.probes[0].name, "middle pressure");
    // the amount of memory depends on the machine
    let told = SolverOptions {
        memory: None,
        ..model.solver.clone()
    };
    assert_eq!(told, SolverOptions::default());
}

#[test]
fn what_is_left_out_has_its_default() {
    let text = example("title    = \"Floating punch on a block\"\n", "");
    assert_eq!(read(&text).unwrap().model.title, "punch");
    let model = model_with("gap       = \"geometric\"\n", "");
    assert!(model.contacts[0].gap.is_none() && model.contacts[0].pairing.is_none());
    let model = model_with("[solver]\nmethod    = \"auto\"\ntolerance = 1e-8\n", "");
    assert_eq!(model.solver.tolerance, 1e-8);
}

#[test]
fn subdomains_are_a_number_or_chosen() {
    let text = |value: &str| {
        let line = format!("tolerance = 1e-8\nsubdomains = {value}\n");
        example("tolerance = 1e-8\n", &line)
    };
    let given = |value: &str| read(&text(value)).unwrap().model.solver.subdomains;
    assert_eq!(given("\"auto\""), Subdomains::Auto);
    assert_eq!(given("12"), Subdomains::Parts(12));
    assert_eq!(given("\"2*3\""), Subdomains::Parts(6));
    for wrong in ["0", "-3", "2.5", "\"many\"", "true", "[2]"] {
        let error = read(&text(wrong)).unwrap_err();
        let span = error.span.clone().unwrap();
        let at = &error.source_text[span];
        assert!(!at.is_empty() && wrong.contains(at), "{at}");
    }
}

#[test]
fn keys_of_later_versions_are_not_supported_yet() {
    for (what, by, key) in [
        ("tolerance = 1e-8\n", "motion = \"small\"\n", "motion"),
        (
            "tolerance = 1e-8\n",
            "max_increments = 3\n",
            "max_increments",
        ),
        ("tolerance = 1e-8\n", "output = \"increments\"\n", "output"),
        (
            "[solver]\n",
            "[accuracy]\nbars = true\n[solver]\n",
            "accuracy",
        ),
        (
            "x = 0.0, y = 0.0",
            "x = 0.0, y = 0.0, turn = { point = [0, 0], angle = 1 }",
            "turn",
        ),
        ("traction =", "follower = true, traction =", "follower"),
        ("traction =", "name = \"q\", traction =", "name"),
    ] {
        let error = read(&example(what, by)).unwrap_err();
        assert_eq!(error.message, format!("`{key}` is not supported yet"));
        let span = error.span.clone().unwrap();
        assert_eq!(&error.source_text[span], key);
    }
}

#[test]
fn steps_have_increasing_times() {
    let with = |steps: &str| read(&format!("{EXAMPLE}{steps}"));
    let times = |steps: &str| with(steps).unwrap().model.times;
    assert_eq!(times("[[step]]\ntime = 0.25\n"), [0.25]);
    let two = "[[step]]\ntime = 0\n[[step]]\ntime = 2.5\n";
    assert_eq!(times(two), [0.0, 2.5]);
    for later in ["0.25", "0.1"] {
        let text = format!("[[step]]\ntime = 0.25\n[[step]]\ntime = {later}\n");
        let error = with(&text).unwrap_err();
        assert!(error.message.contains("must increase"), "{error}");
        assert_eq!((error.line(), error.column()), (Some(38), Some(8)));
    }
    let error = with("[[step]]\n").unwrap_err();
    assert!(error.message.contains("needs the key `time`"), "{error}");
    let empty = example("title ", "step = []\ntitle ");
    let error = read(&empty).unwrap_err();
    assert!(error.message.contains("list of steps is empty"), "{error}");
}

#[test]
fn a_body_of_revolution_has_no_thickness() {
    let text = example(
        "analysis = \"plane-strain\" ",
        "analysis = \"axisymmetric\" ",
    );
    assert_eq!(read(&text).unwrap().model.analysis, Analysis::Axisymmetric);
    let (plain, thick) = (
        "poisson = 0.3 }        #",
        "poisson = 0.3, thickness = 2 } #",
    );
    assert!(read(&example(plain, thick)).is_ok());
    let error = read(&text.replacen(plain, thick, 1)).unwrap_err();
    assert!(
        error.message.contains("`thickness` has no meaning"),
        "{error}"
    );
    assert_eq!(error.line(), Some(10));
}

#[test]
fn generators_parts_and_patches_are_read() {
    let ring = "{ ring = { inner = 5.7, outer = 6, from = -90, to = 90, cells = [40, 2] }, \
                sides = { crown = { of = \"outer\", min = [-1, 5], max = [1, 7] } } }";
    let old = "{ rectangle = { from = [0.0, 0.0], to = [4.0, 1.0], cells = [80, 20], cell = \"quad4\" } }";
    let text = example(old, ring);
    let text = text
        .replace("block.top", "block.crown")
        .replace("\"bottom\", x", "\"start\", x");
    let model = read(&text).unwrap().model;
    let sides: Vec<&str> = model.bodies[0].mesh.side_names().collect();
    assert_eq!(sides, ["crown", "end", "inner", "outer", "start"]);
}

#[test]
fn supports_and_loads_have_all_their_forms() {
    let model = model_with(
        "fix      = [{ side = \"bottom\", x = 0.0, y = 0.0 }]",
        "fix = [{ side = \"bottom\", normal = \"0.1*t\" }, { point = [0, 0], x = 0 }]\n\
         load = [{ side = \"top\", pressure = 3 }, { point = [1, 1], force = [0, \"-x\"] }, { side = \"top\", force = [0, \"-t\"] }]\n\
         body_force = [0, -9.81]",
    );
    let body = &model.bodies[0];
    assert_eq!(
        body.supports[0].normal.as_ref().unwrap().at([0.0; 2], 2.0),
        0.2
    );
    assert_eq!(body.supports[1].place, Place::Point([0.0, 0.0]));
    assert!(
        matches!(&body.loads[0], Load::Pressure { pressure, .. } if pressure.as_constant() == Some(3.0))
    );
    assert!(matches!(&body.loads[1], Load::Force { point, .. } if *point == [1.0, 1.0]));
    assert!(
        matches!(&body.loads[2], Load::Resultant { side, force } if side == "top" && force[1].at([0.0; 2], 3.0) == -3.0)
    );
    assert_eq!(body.body_force[1].as_constant(), Some(-9.81));
}

#[test]
fn contacts_have_all_their_forms() {
    let pair = "nonmortar = \"punch.bottom\"\nmortar    = \"block.top\"\ngap       = \"geometric\"";
    let automatic = model_with(
        pair,
        "sides = [\"punch.bottom\", \"block.top\"]\ngap = \"-1e-3*x\"",
    );
    assert!(matches!(automatic.contacts[0].pair, Pair::Automatic(_)));
    assert!(
        matches!(&automatic.contacts[0].gap, Some(Gap::Given(gap)) if gap.at([2.0, 0.0], 0.0) == -2e-3)
    );
    let obstacle = model_with(
        pair,
        "nonmortar = \"punch.bottom\"\nobstacle = { gap = \"x^2/50\", displacement = [0, 0.1] }",
    );
    let Pair::Obstacle { obstacle, .. } = &obstacle.contacts[0].pair else {
        panic!("an obstacle")
    };
    assert!(matches!(&obstacle.shape, Rigid::Gap(gap) if gap.at([5.0, 0.0], 0.0) == 0.5));
    assert!(matches!(&obstacle.motion, Motion::Prescribed([_, y]) if y.as_constant() == Some(0.1)));
    let circle = model_with(
        pair,
        "nonmortar = \"punch.bottom\"\nobstacle = { circle = { center = [2, 9], radius = 9, inside = true }, force = [0, -1] }",
    );
    let Pair::Obstacle { obstacle, .. } = &circle.contacts[0].pair else {
        panic!("an obstacle")
    };
    assert!(matches!(
        obstacle.shape,
        Rigid::Surface { inside: true, .. }
    ));
    assert!(matches!(&obstacle.motion, Motion::Loaded(_)));
    let tied = model_with("friction  = 0.0", "tied = true");
    assert!(matches!(tied.contacts[0].law, Law::Tied));
    let mortar = model_with("friction  = 0.0", "pairing = \"mortar\"");
    assert_eq!(mortar.contacts[0].pairing, Some(Pairing::Mortar));
    for frictionless in ["{ coulomb = 0 }", "{ tresca = 0.0 }", "\"0\""] {
        let model = model_with("friction  = 0.0", &format!("friction = {frictionless}"));
        assert!(matches!(model.contacts[0].law, Law::Frictionless));
    }
    for rough in ["0.3", "\"0.3 * x\"", "{ coulomb = 0.3 }"] {
        let model = model_with("friction  = 0.0", &format!("friction = {rough}"));
        assert!(matches!(model.contacts[0].law, Law::Coulomb(_)), "{rough}");
    }
    let given = model_with("friction  = 0.0", "friction = { tresca = \"x\" }");
    assert!(matches!(&given.contacts[0].law, Law::Tresca(f) if f.at([2.0, 0.0], 0.0) == 2.0));
    for (friction, expected) in [
        ("coulomb = 0.3, cohesion = 1e5", 0.3),
        ("cohesion = \"1e5\"", 0.0),
    ] {
        let model = model_with("friction  = 0.0", &format!("friction = {{ {friction} }}"));
        let Law::Cohesive {
            cohesion,
            coefficient,
            ..
        } = &model.contacts[0].law
        else {
            panic!("{friction}")
        };
        assert_eq!(cohesion.as_constant(), Some(1e5));
        assert_eq!(coefficient.as_constant(), Some(expected));
    }
}

#[test]
fn bolts_are_automatic_one_point_or_several() {
    let with = |bolt: &str| {
        model_with(
            "method    = \"auto\"",
            &format!("method = \"uzawa\"\n{bolt}"),
        )
    };
    assert_eq!(with("bolt = \"auto\"\nrho = \"auto\"").solver.rho, None);
    assert_eq!(with("rho = 2e9").solver.rho, Some(2e9));
    let one = with("bolt = [2, 1.0]").solver.bolts;
    assert_eq!(one, Bolts::Points(vec![[2.0, 1.0]]));
    let two = with("bolt = [[2, 1.0], [1, 1]]").solver.bolts;
    assert_eq!(two, Bolts::Points(vec![[2.0, 1.0], [1.0, 1.0]]));
}

#[test]
fn every_quantity_is_known() {
    let plain = [
        "punch.reaction.y",
        "block.bottom.reaction.x",
        "sole.resultant.y",
        "sole.length",
        "sole.length_stick",
        "sole.length_slip",
        "sole.dissipated_work",
        "sole.dissipated_work_total",
    ];
    let fields = [
        "block.displacement.x",
        "block.displacement.magnitude",
        "block.stress.zz",
        "block.stress.von_mises",
        "block.stress.s3",
        "sole.gap",
        "sole.shear",
        "sole.slip",
        "sole.shear.x",
        "sole.slip.magnitude",
        "sole.displacement_mortar",
    ];
    let old = "quantity = \"sole.pressure\"\nat       = [2.0, 1.0]";
    for quantity in plain {
        let model = model_with(old, &format!("quantity = \"{quantity}\""));
        assert_eq!(model.probes[0].quantity.to_string(), quantity);
    }
    for quantity in fields {
        let model = model_with(old, &format!("quantity = \"{quantity}\"\nreduce = \"max\""));
        assert_eq!(model.probes[0].reading, Reading::Largest);
        for (word, reading) in [("mean", Reading::Mean), ("integral", Reading::Integral)] {
            let change = format!("reduce = \"{word}\"");
            let model = model_with("at       = [2.0, 1.0]", &change);
            assert_eq!(model.probes[0].reading, reading);
        }
    }
    let modified = "quantity = \"sole.displacement_nonmortar\"\nat = [2, 1]\n\
                    mean_of_neighbours = true\nminus_rigid = \"punch\"";
    let probe = &model_with(old, modified).probes[0];
    assert_eq!(
        (probe.reading, probe.minus_rigid),
        (Reading::MeanOfNeighbours([2.0, 1.0]), Some(BodyId(1)))
    );
}

#[test]
fn a_probe_may_be_an_expression_of_others() {
    let more = "\n[[probe]]\nname = \"half\"\nexpression = \"0.5*'middle pressure' + later\"\n\
                [[probe]]\nname = \"later\"\nexpression = \"t\"\n[[probe]]\nname = \"line\"\n\
                quantity = \"sole.gap\"\nalong = \"punch.bottom\"";
    let old = "quantity = \"sole.pressure\"\nat       = [2.0, 1.0]";
    let with = format!("{old}{more}");
    let model = model_with(old, &with);
    let formula = model.probes[1].quantity.formula().unwrap();
    assert_eq!(formula.probes(), ["middle pressure", "later"]);
    for (from, to, underlined, words) in [
        (
            "+ later",
            "+ latter",
            "l",
            "unknown name `latter`, the nearest known is `later`",
        ),
        (
            "+ later",
            "+ half",
            "\"0.5*'middle pressure' + half\"",
            "depends on itself: half → half",
        ),
        (
            "\"t\"",
            "\"half/2\"",
            "\"0.5*'middle pressure' + later\"",
            "half → later → half",
        ),
        (
            "\"t\"",
            "\"2*line\"",
            "\"2*line\"",
            "`line` has values along a line",
        ),
        (
            "\"t\"",
            "\"t\"\nfactor = 2",
            "factor",
            "has no `factor` | superfluous",
        ),
        (
            "\"t\"",
            "\"t\"\nquantity = \"sole.length\"",
            "quantity",
            "has no `quantity`",
        ),
        ("\"t\"", "2", "2", "expected a string"),
    ] {
        assert_eq!(with.matches(from).count(), 1, "{from}");
        assert_mistake(old, &with.replace(from, to), underlined, &[words]);
    }
}

#[test]
fn wrong_quantities_are_refused_before_solving() {
    for (quantity, underlined, fragments) in [
        (
            "sole.presure",
            "presure",
            ["unknown quantity of a contact `presure`", "`pressure`"],
        ),
        (
            "soul.pressure",
            "soul",
            ["unknown body or contact `soul`", "`sole`"],
        ),
        (
            "block.displacement.z",
            "z",
            ["unknown displacement `z`", "`magnitude`"],
        ),
        ("block.displacement", "displacement", ["ends after", "`x`"]),
        (
            "block.stress.mises",
            "mises",
            ["unknown stress", "`von_mises`"],
        ),
        (
            "block.botom.reaction.x",
            "botom",
            ["unknown side `botom`", "`bottom`"],
        ),
        (
            "block.strains.xx",
            "strains",
            ["unknown quantity of a body", "`strain`"],
        ),
        (
            "sole.pressure.x",
            "pressure",
            ["has no components", "pressure"],
        ),
        ("sole", "sole", ["ends after", "`resultant`"]),
        ("", "\"\"", ["unknown body or contact", "`sole`"]),
    ] {
        assert_mistake("sole.pressure", quantity, underlined, &fragments);
    }
    let at = "at       = [2.0, 1.0]";
    assert_mistake(
        at,
        "",
        "[[probe]]",
        &["`at`, `along` or `reduce` is missing"],
    );
    assert_mistake(
        at,
        "reduce = \"sum\"",
        "\"sum\"",
        &["unknown reduction", "`max`, `min`"],
    );
    assert_mistake(at, "at = [2, 1]\nreduce = \"max\"", "reduce", &["both"]);
    assert_mistake(
        at,
        "at = [2, 1]\nminus_rigid = \"punch\"",
        "minus_rigid",
        &["displacements"],
    );
    assert_mistake(
        at,
        "reduce = \"max\"\nmean_of_neighbours = true",
        "mean_of_neighbours",
        &["needs `at`"],
    );
    assert_mistake(
        "\"sole.pressure\"",
        "\"sole.length\"",
        "at",
        &["one number"],
    );
}

#[test]
fn unknown_keys_bring_the_nearest_known_one() {
    assert_mistake("analysis =", "analisys =", "analisys", &["`analysis`"]);
    assert_mistake(
        "cell = \"quad4\"",
        "cel = \"quad4\"",
        "cel",
        &["`cell`", "`cells`"],
    );
    assert_mistake(
        "mortar    =",
        "master =",
        "master",
        &["unknown key `master`", "`mortar`"],
    );
    assert_mistake("tolerance = 1e-8", "tol = 1e-8", "tol", &["`tolerance`"]);
}

#[test]
fn missing_keys_are_named_where_they_are_missing() {
    assert_mistake("name     = \"block\"\n", "", "[[body]]", &["`name`"]);
    assert_mistake("analysis = \"plane-strain\"", "", "", &["`analysis`"]);
    assert_mistake(
        ", to = [4.0, 1.0]",
        "",
        "{ from = [0.0, 0.0], cells = [80, 20], cell = \"quad4\" }",
        &["`to`"],
    );
}

#[test]
fn wrong_types_say_what_was_expected_and_found() {
    assert_mistake(
        "\"-1e6 * (1 + 0.1*x)\"",
        "true",
        "true",
        &["expected a number or an expression string, found a boolean"],
    );
    assert_mistake(
        "[0.0, \"-1e6 * (1 + 0.1*x)\"]",
        "[1, 2, 3]",
        "[1, 2, 3]",
        &["expected 2 numbers or expressions, found 3"],
    );
    assert_mistake(
        "tolerance = 1e-8",
        "tolerance = true",
        "true",
        &["expected a number, found a boolean"],
    );
    assert_mistake(
        "cells = [80, 20]",
        "cells = [80.5, 20]",
        "80.5",
        &["expected a positive integer"],
    );
    assert_mistake(
        "cells = [80, 20]",
        "cells = [80, 0]",
        "0",
        &["positive integer"],
    );
    assert_mistake(
        "cells = [80, 20]",
        "cells = [100000, 100000]",
        "[100000, 100000]",
        &["cells"],
    );
    assert_mistake("tolerance = 1e-8", "tolerance = nan", "nan", &["finite"]);
    assert_mistake(
        "tolerance = 1e-8",
        "tolerance = 1e999",
        "1e999",
        &["finite"],
    );
}

#[test]
fn expressions_are_underlined_at_the_wrong_word() {
    assert_mistake("0.1*x)", "0.1*xx)", "x", &["unknown name `xx`", "`x`"]);
    assert_mistake(
        "\"-1e6 * (1 + 0.1*x)\"",
        "\"1/0\"",
        "\"1/0\"",
        &["not finite"],
    );
    assert_mistake(
        "\"geometric\"",
        "\"geometrc\"",
        "g",
        &["\"geometric\", \"closed\""],
    );
}

/// The example with a table of parameters before its bodies.
fn with_parameters(table: &str, changes: &[(&str, &str)]) -> String {
    let start = EXAMPLE.replacen("[[body]]", &format!("{table}\n\n[[body]]"), 1);
    changes.iter().fold(start, |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

const PARAMETERS: &str = "[parameters]\nE = 2e9\nn = \"2 * 5\"\nhalf = \"E / (2 * n)\"";

fn given(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    let owned = pairs.iter();
    owned
        .map(|(name, value)| (name.to_string(), value.to_string()))
        .collect()
}

#[test]
fn parameters_stand_for_every_number_and_in_every_expression() {
    let text = with_parameters(
        PARAMETERS,
        &[
            ("young = 210e9", "young = \"E\""),
            ("cells = [80, 20]", "cells = [\"8 * n\", \"n\"]"),
            ("from = [1.5, 1.0]", "from = [\"1.5 * E / E\", 1.0]"),
            ("-1e6 * (1 + 0.1*x)", "-half * x"),
            ("\"geometric\"", "\"-1/E\""),
            ("tolerance = 1e-8", "tolerance = \"1e-9 * n\""),
            ("at       = [2.0, 1.0]", "at       = [\"2 * E / E\", 1.0]"),
        ],
    );
    let read_with = |set: &[(&str, &str)]| {
        read_given(&text, "punch.toml", Path::new(""), &given(set))
            .unwrap()
            .model
    };
    let own = read_with(&[]);
    let expected = [("E", 2e9), ("n", 10.0), ("half", 1e8)];
    assert_eq!(
        own.parameters,
        expected.map(|(name, value)| (name.to_string(), value))
    );
    let pull = |model: &Model<2>| model.bodies[1].loads[0].at([3.0, 2.0], [0.0, 1.0], 1.0)[1];
    assert_eq!(own.bodies[0].materials[0].elastic.young, 2e9);
    assert_eq!(own.bodies[0].mesh.cell_count(), 800);
    assert_eq!(pull(&own), -3e8);
    assert_eq!(own.solver.tolerance, 1e-8);
    // a value given from outside changes those that follow from it; it may name those before
    let other = read_with(&[("E", "4e9"), ("n", "E / 8e8")]);
    assert_eq!(other.bodies[0].materials[0].elastic.young, 4e9);
    assert_eq!(other.bodies[0].mesh.cell_count(), 200);
    assert_eq!(pull(&other), -12e8);
}

#[test]
fn mistakes_with_parameters_are_underlined() {
    type Pairs = &'static [(&'static str, &'static str)];
    let mistakes: [(&str, Pairs, Pairs, &str, &str); 17] = [
        (
            "E = \"2 * F\"\nF = 1",
            &[],
            &[],
            "depends on `F`, which comes after it",
            "\"2 * F\"",
        ),
        ("E = \"2 * G\"\nF = 1", &[], &[], "unknown name `G`", "G"),
        ("E = \"x\"", &[], &[], "`x` has no meaning here", "x"),
        ("x = 1", &[], &[], "`x` means something else", "x"),
        ("pi = 3", &[], &[], "`pi` means something else", "pi"),
        ("sin = 3", &[], &[], "`sin` means something else", "sin"),
        (
            "closed = 1",
            &[],
            &[],
            "`closed` means something else",
            "closed",
        ),
        ("auto = 1", &[], &[], "`auto` means something else", "auto"),
        ("2a = 1", &[], &[], "`2a` is not a name", "2a"),
        ("a-b = 1", &[], &[], "`a-b` is not a name", "a-b"),
        (
            "E = true",
            &[],
            &[],
            "expected a number, found a boolean",
            "true",
        ),
        ("E = \"1/0\"", &[], &[], "not finite", "\"1/0\""),
        (
            "E = [1]",
            &[],
            &[],
            "expected a number, found a list",
            "[1]",
        ),
        (
            "E = 2.5",
            &[("cells = [80, 20]", "cells = [\"E\", 20]")],
            &[],
            "must come out whole, it is 2.5",
            "\"E\"",
        ),
        (
            "E = -2",
            &[("cells = [80, 20]", "cells = [\"E\", 20]")],
            &[],
            "must be a positive integer",
            "\"E\"",
        ),
        (
            "young = 1",
            &[("young = 210e9", "young = \"yong\"")],
            &[],
            "the nearest known is `young`",
            "y",
        ),
        (
            "E = 1",
            &[],
            &[("E", "2 *")],
            "the value given for the parameter `E`, \"2 *\"",
            "E",
        ),
    ];
    for (table, changes, set, message, underlined) in mistakes {
        let text = with_parameters(&format!("[parameters]\n{table}"), changes);
        let error = read_given(&text, "punch.toml", Path::new(""), &given(set)).unwrap_err();
        assert!(
            error.message.contains(message),
            "{table}: {}",
            error.message
        );
        assert_eq!(
            &text[error.span.clone().unwrap()],
            underlined,
            "{}",
            error.message
        );
    }
    let text = with_parameters(PARAMETERS, &[]);
    let error = read_given(&text, "f", Path::new(""), &given(&[("half_", "1")])).unwrap_err();
    assert_eq!(error.message, "there is no parameter `half_`");
    assert_eq!(&*error.label, "the nearest is `half`");
    let error = read_given(EXAMPLE, "f", Path::new(""), &given(&[("E", "1")])).unwrap_err();
    assert!(
        error
            .help
            .unwrap()
            .contains("add a table `[parameters]` with `E = ...`")
    );
}

/// The example with the bottom of its punch cut in two parts.
fn cut_in_parts(changes: &[(&str, &str)]) -> String {
    let cut = "cells = [20, 20] }, sides = { west = { of = \"bottom\", min = [1.5, 1], max = [2, 1] }, \
               east = { of = \"bottom\", min = [2, 1], max = [2.5, 1] } } }";
    let start = EXAMPLE.replace("cells = [20, 20] } }", cut);
    changes.iter().fold(start, |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

#[test]
fn a_list_of_sides_is_one_side() {
    let parts = "nonmortar = [\"punch.west\", \"punch.east\"]";
    let text = cut_in_parts(&[
        ("nonmortar = \"punch.bottom\"", parts),
        (
            "side = \"left\", x = 0.0 }, { side = \"right\", x = 0.0 }]\nload",
            "side = [\"left\", \"right\"], x = 0.0 }]\nload",
        ),
        ("{ side = \"top\", traction", "{ side = [\"top\"], traction"),
    ]);
    let model = read(&text).unwrap().model;
    let mesh = &model.bodies[1].mesh;
    assert_eq!(mesh.side("west+east"), mesh.side("bottom"));
    // a support on a list is one on each of its sides
    let places = model.bodies[1]
        .supports
        .iter()
        .map(|support| &support.place);
    let sides = ["left", "right"].map(|side| Place::Side(side.to_string()));
    assert!(places.eq(&sides));
    assert!(matches!(&model.bodies[1].loads[0], Load::Traction { side, .. } if side == "top"));
    let parts = model.solve().unwrap();
    let whole = read(EXAMPLE).unwrap().model.solve().unwrap();
    // the same problem in other words
    assert_eq!(parts.contacts[0].nodes, whole.contacts[0].nodes);
    assert_eq!(parts.bodies[1].displacement, whole.bodies[1].displacement);
    let automatic = "sides = [[\"punch.west\", \"punch.east\"], \"block.top\"]";
    let both = "nonmortar = \"punch.bottom\"\nmortar    = \"block.top\"";
    let text = cut_in_parts(&[(both, automatic)]);
    assert!(matches!(
        read(&text).unwrap().model.contacts[0].pair,
        Pair::Automatic(_)
    ));
}

#[test]
fn mistakes_in_lists_of_sides_are_underlined() {
    for (list, message, underlined) in [
        (
            "[\"punch.west\", \"punch.esat\"]",
            "has no side `esat`",
            "\"punch.esat\"",
        ),
        (
            "[\"punch.west\", \"block.top\"]",
            "the sides of one list belong to one body",
            "\"block.top\"",
        ),
        (
            "[\"punch.west\", \"punch.west\"]",
            "the side `west` is listed twice",
            "\"punch.west\"",
        ),
        ("[]", "the list of sides is empty", "[]"),
        (
            "[\"punch.west\", 3]",
            "expected a string, found an integer",
            "3",
        ),
        (
            "[\"punch.west\", [\"punch.east\"]]",
            "expected a string, found a list",
            "[\"punch.east\"]",
        ),
    ] {
        let change = format!("nonmortar = {list}");
        let text = cut_in_parts(&[("nonmortar = \"punch.bottom\"", &change)]);
        let error = read(&text).unwrap_err();
        assert!(error.message.contains(message), "{list}: {}", error.message);
        assert_eq!(&text[error.span.unwrap()], underlined, "{list}");
    }
}

#[test]
fn what_is_the_same_everywhere_depends_on_time_alone() {
    let same = ["`x` has no meaning here"];
    assert_mistake(
        "traction = [0.0, \"-1e6 * (1 + 0.1*x)\"]",
        "force = [0.0, \"-x\"]",
        "x",
        &same,
    );
    let pair = "mortar    = \"block.top\"\ngap       = \"geometric\"";
    for motion in ["force", "displacement"] {
        let obstacle = format!("obstacle = {{ gap = 0.0, {motion} = [\"x\", 0] }}");
        assert_mistake(pair, &obstacle, "x", &same);
    }
}

#[test]
fn a_case_is_of_the_plane_or_of_space_as_its_analysis_says() {
    let space = "\"3d\" #";
    let plane = "\"plane-strain\"            #";
    assert_mistake(plane, space, "\"3d\"", &["2 dimensions"]);
    let any = |text: &str| AnyCase::from_str(text, "punch.toml", Path::new(""));
    assert!(matches!(any(EXAMPLE), Ok(AnyCase::Plane(_))));
    let error = any(&example(plane, space)).unwrap_err();
    assert!(error.message.contains("makes 2D meshes"), "{error}");
}

#[test]
fn solids_are_made_of_their_words() {
    let boxed = "box = { from = [0, 0, 0], to = [2, 1, 1], cells = [2, 1, 3], cell = \"tet4\" }, sides = { foot = { of = \"bottom\", min = [0, 0, 0], max = [1, 1, 0] } }";
    let volume = |mesh: &Mesh<3>| {
        let (low, high) = crate::geometry::bounding_box(mesh.points());
        (mesh.cell_count(), low, high)
    };
    let head = IN_SPACE.split("points ").next().unwrap();
    for (words, cells, low, high, sides) in [
        (
            "cylinder = { base = [1, 0, 0], axis = [0, 0, 3], inner = 1, radius = 2, height = 3, from = 0, to = 90, cells = [4, 2, 3] }",
            24,
            [1.0, 0.0, 0.0],
            [3.0, 2.0, 3.0],
            "bottom end inner outer start top",
        ),
        (
            "sphere = { center = [0, 0, 1], inner = 0.5, radius = 1, cells = [8, 2], cell = \"hex20\" }, sides = { cap = { of = \"boundary\", min = [-1, -1, 1], max = [1, 1, 2] } }",
            0,
            [-1.0, -1.0, 0.0],
            [1.0, 1.0, 2.0],
            "boundary cap inner outer",
        ),
        (
            "extrude = { mesh = { rectangle = { from = [0, 0], to = [2, 1], cells = [2, 1], cell = \"tri6\" } }, height = 4, layers = 3 }",
            12,
            [0.0, 0.0, 0.0],
            [2.0, 1.0, 4.0],
            "bottom first last left right top",
        ),
        (
            "extrude = { mesh = { rectangle = { from = [1, 0], to = [2, 1], cells = [2, 1] } }, turn = { point = [0, 0, 0], axis = [0, 1, 0], angle = 90 }, layers = 3 }",
            6,
            [0.0, 0.0, -2.0],
            [2.0, 1.0, 0.0],
            "bottom first last left right top",
        ),
    ] {
        assert!(head.contains(boxed));
        let text = head.replace(boxed, words);
        let case = Case::<3>::from_str(&text, "solid.toml", Path::new("")).unwrap();
        let mesh = &case.model.bodies[0].mesh;
        let (count, lowest, highest) = volume(mesh);
        assert!(count == cells || cells == 0, "{words}: {count}");
        let off = |a: [f64; 3], b: [f64; 3]| crate::geometry::distance(a, b);
        assert!(
            off(lowest, low) < 1e-9 && off(highest, high) < 1e-9,
            "{words}: {lowest:?} {highest:?}"
        );
        assert_eq!(
            mesh.side_names().collect::<Vec<_>>().join(" "),
            sides,
            "{words}"
        );
    }
}

const IN_SPACE: &str = r#"
analysis = "3d"

[[body]]
name     = "block"
mesh     = { box = { from = [0, 0, 0], to = [2, 1, 1], cells = [2, 1, 3], cell = "tet4" }, sides = { foot = { of = "bottom", min = [0, 0, 0], max = [1, 1, 0] } } }
material = { young = 1e9, poisson = 0.25 }
points   = { eye = [1, 0.5, 2] }
surface  = { right = { cone = { apex = [2, 0, 0], axis = [0, 0, 2], angle = 30 } } }
couple   = [{ side = "top", point = "eye", kind = "rigid" }]
fix      = [{ side = "foot", x = 0, z = "0.1*y" }, { point = "eye", y = 0, rotation = { z = "t" } }]
load     = [{ side = "front", traction = [1, "z", "x + y"] }, { point = "eye", force = [0, 0, -1], moment = [1, 0, "2*t"] }]
body_force = [0, 0, "-9.81*z"]

[[contact]]
name      = "ball"
nonmortar = "block.left"
obstacle  = { sphere = { center = [-3, 0, 0], radius = 3, inside = false }, force = [1, 0, "t"] }

[solver]
method = "uzawa"
bolt   = [0, 0.5, 1]

[[probe]]
name     = "shear"
quantity = "block.stress.yz"
along    = { from = [0, 0, 0], to = [0, 0, 1], points = 3 }
"#;

#[test]
fn a_case_in_space_has_three_components_everywhere() {
    let case = Case::<3>::from_str(IN_SPACE, "block.toml", Path::new("")).unwrap();
    let model = &case.model;
    let block = &model.bodies[0];
    assert_eq!(
        (block.mesh.cell_count(), block.mesh.points().len()),
        (36, 24)
    );
    assert_eq!(block.mesh.side("foot").unwrap().len(), 2);
    let value = |field: &Option<Field>, at: [f64; 3], t: f64| Some(field.as_ref()?.at(at, t));
    let foot = &block.supports[0].components;
    let at = [1.0, 0.5, 0.25];
    let held: Vec<_> = foot.iter().map(|field| value(field, at, 1.0)).collect();
    assert_eq!(held, [Some(0.0), None, Some(0.05)]);
    let couple = &block.couples[0];
    assert_eq!(couple.point, [1.0, 0.5, 2.0]);
    assert!(couple.rotation[0].is_none() && couple.rotation[1].is_none());
    assert_eq!(value(&couple.rotation[2], at, 3.0), Some(3.0));
    assert!(couple.displacement[1].is_some() && couple.displacement[2].is_none());
    assert_eq!(
        couple.moment.each_ref().map(|m| m.at(at, 2.0)),
        [1.0, 0.0, 4.0]
    );
    assert_eq!(
        couple.force.each_ref().map(|f| f.at(at, 2.0)),
        [0.0, 0.0, -1.0]
    );
    let traction = block.loads[0].at(at, [0.0, -1.0, 0.0], 1.0);
    assert_eq!(traction, [1.0, 0.25, 1.5]);
    assert_eq!(block.body_force[2].at(at, 0.0), -9.81 * 0.25);
    let cone = Surface::Cone {
        apex: [2.0, 0.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        half_angle: 30f64.to_radians(),
    };
    assert_eq!(block.surfaces["right"], Some(cone));
    let Pair::Obstacle { obstacle, .. } = &model.contacts[0].pair else {
        panic!("an obstacle")
    };
    assert!(matches!(&obstacle.motion, Motion::Loaded(force) if force[2].at(at, 5.0) == 5.0));
    let Rigid::Surface { surface, inside } = &obstacle.shape else {
        panic!("a sphere")
    };
    assert!(!inside && surface.distance([0.0; 3]) == 0.0);
    assert_eq!(model.solver.bolts, Bolts::Points(vec![[0.0, 0.5, 1.0]]));
    assert!(model.probes[0].is_line());
    // a reader of the plane does not take it
    let plane = Case::<2>::from_str(IN_SPACE, "block.toml", Path::new(""));
    assert!(plane.unwrap_err().message.contains("2 dimensions"));
}

#[test]
fn surfaces_and_obstacles_have_one_shape_with_a_direction() {
    let surface = "load     =";
    let on_top = |shape: &str| format!("surface = {{ top = {{ {shape} }} }}\nload =");
    for (shape, place, word) in [
        (
            "sphere = { center = [0, 0], radius = 1 }",
            "sphere",
            "a shape of 3D analyses",
        ),
        (
            "circle = { center = [0, 0], radius = -1 }",
            "-1",
            "positive",
        ),
        (
            "plane = { point = [0, 0], normal = [0, 0] }",
            "[0, 0]",
            "zero",
        ),
        ("circle = { radius = 1 }", "{ radius = 1 }", "`center`"),
    ] {
        assert_mistake(surface, &on_top(shape), place, &[word]);
    }
    assert_mistake(surface, "surface = { tpo = {} }\nload =", "tpo", &["`top`"]);
    let pair = "mortar    = \"block.top\"\ngap       = \"geometric\"";
    for (obstacle, place, word) in [
        (
            "{ displacement = [0, 0] }",
            "{ displacement = [0, 0] }",
            "exactly one shape",
        ),
        (
            "{ gap = 0, displacement = [0, 0], force = [0, 1] }",
            "[0, 1]",
            "both are given",
        ),
    ] {
        assert_mistake(pair, &format!("obstacle = {obstacle}"), place, &[word]);
    }
    assert_mistake(
        "friction  = 0.0",
        "friction = 0.3\ntied = true",
        "0.3",
        &["does not slip"],
    );
}

#[test]
fn solver_options_fit_the_method() {
    assert_mistake(
        "method    = \"auto\"",
        "method = \"newtno\"",
        "\"newtno\"",
        &["`newton`", "`uzawa`"],
    );
    assert_mistake(
        "method    = \"auto\"",
        "rho = 1.0",
        "rho",
        &["`auto`", "`gradient` or `uzawa`"],
    );
    assert_mistake(
        "method    = \"auto\"",
        "method = \"gradient\"\nbolt = \"auto\"",
        "bolt",
        &["`gradient`", "`uzawa`"],
    );
    assert_mistake(
        "method    = \"auto\"",
        "method = \"uzawa\"\nrho = 0",
        "0",
        &["positive"],
    );
    assert_mistake("tolerance = 1e-8", "tolerance = 0", "0", &["positive"]);
    assert_mistake(
        "tolerance = 1e-8",
        "max_iterations = 0",
        "0",
        &["positive integer"],
    );
}

#[test]
fn a_text_that_is_not_toml_has_its_place() {
    let error = read(&example("name     = \"block\"", "name = \"block")).unwrap_err();
    assert!(error.message.contains("TOML"));
    assert_eq!(error.line(), Some(8));
    let error = read(&example(
        "name     = \"block\"",
        "name = \"a\"\nname = \"b\"",
    ))
    .unwrap_err();
    assert_eq!(error.line(), Some(9));
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = Case::<2>::read(Path::new("no-such-folder/no-such.toml")).unwrap_err();
    assert!(
        error.to_string().contains("no-such.toml") && error.to_string().contains("no such file")
    );
    let error = Case::<2>::read(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err();
    assert!(error.message.contains("folder"));
}

/// The example with a mesh from an outline for the punch.
fn with_outline(outline: &str) -> String {
    example(
        "{ rectangle = { from = [1.5, 1.0], to = [2.5, 2.0], cells = [20, 20] } }",
        &format!("{{ outline = {outline} }}"),
    )
}

const PUNCH: &str = r#"{ size = 0.2, from = [1.5, 1.0], edges = [
  { to = [2.5, 1.0], name = "bottom", cells = 20 },
  { to = [2.5, 1.8], name = "right", size = 0.1 },
  { to = [2.3, 2.0], radius = 0.2 },
  { to = [1.5, 2.0], name = "top" },
  { to = [1.5, 1.0], name = "left" } ],
  holes = [{ circle = { center = [2.0, 1.5], radius = 0.2 }, name = "eye", size = 0.05 }],
  refine = [{ at = [1.5, 1.0], size = 0.02 }] }"#;

#[test]
fn an_outline_is_read_with_edges_arcs_holes_and_sizes() {
    let model = read(&with_outline(PUNCH)).unwrap().model;
    let mesh = &model.bodies[1].mesh;
    let names: Vec<&str> = mesh.side_names().collect();
    assert_eq!(names, ["bottom", "eye", "left", "outline", "right", "top"]);
    assert_eq!(mesh.side("bottom").unwrap().len(), 20);
    assert_eq!(mesh.side("eye").unwrap().len(), 28);
    assert_eq!(mesh.blocks()[0].kind, CellKind::Tri3);
    let disc = r#"{ size = 0.3, cell = "tri6", name = "bottom", circle = { center = [2, 2], radius = 1 } }"#;
    let text = with_outline(disc).replace("side = \"left\"", "side = \"bottom\"");
    let text = text.replace("side = \"right\"", "side = \"bottom\"");
    let text = text.replace("side = \"top\"", "side = \"bottom\"");
    // The block's support was on its bottom already.
    let mesh = &read(&text).unwrap().model.bodies[1].mesh;
    assert_eq!(mesh.blocks()[0].kind, CellKind::Tri6);
    assert_eq!(mesh.side("bottom").unwrap().len(), 24);
}

#[test]
fn mistakes_in_an_outline_are_underlined() {
    let mistakes = [
        ("size = 0.2, from", "from", "needs the key `size`", "{ from"),
        ("size = 0.2", "size = 0", "`size` must be positive", "0"),
        ("size = 0.2", "sze = 0.2", "known key is `size`", "sze"),
        (
            "to = [2.5, 1.8]",
            "too = [2.5, 1.8]",
            "known key is `to`",
            "too",
        ),
        (
            "radius = 0.2 },\n  { to = [1.5, 2.0]",
            "radius = 0.1 },\n  { to = [1.5, 2.0]",
            "edge 3: its ends are",
            "{ to = [2.3, 2.0], radius = 0.1 }",
        ),
        (
            "radius = 0.2 },\n  { to = [1.5, 2.0]",
            "radius = 0.2, via = [2, 3] },\n  { to = [1.5, 2.0]",
            "both `via` and `radius`",
            "radius",
        ),
        (
            "name = \"top\"",
            "clockwise = true",
            "belongs to an arc",
            "clockwise",
        ),
        (
            "{ to = [1.5, 1.0], name",
            "{ to = [1.4, 1.0], name",
            "edge 5 (`left`): it ends at [1.4, 1.0]",
            "{ to = [1.4, 1.0], name = \"left\" }",
        ),
        (
            "cells = 20",
            "cells = 20, size = 0.1",
            "either `size` or `cells`",
            "cells",
        ),
        (
            "center = [2.0, 1.5]",
            "center = [2.4, 1.5]",
            "edge 2 (`right`): it meets hole 1 (`eye`)",
            "{ to = [2.5, 1.8], name = \"right\", size = 0.1 }",
        ),
        (
            "center = [2.0, 1.5]",
            "center = [4.0, 1.5]",
            "hole 1: it lies outside",
            "{ center = [4.0, 1.5], radius = 0.2 }",
        ),
        (
            "holes = [{ circle",
            "holes = [{ edges = [], circle",
            "both `circle` and `edges`",
            "edges",
        ),
        (
            "refine = [{ at",
            "refine = [{ radius = 0, at",
            "`radius` must be positive",
            "0",
        ),
        (
            "size = 0.2,",
            "size = 0.2, cell = \"quad4\",",
            "unknown cell of an outline",
            "\"quad4\"",
        ),
        (
            "size = 0.2,",
            "size = 0.2, growth = 2,",
            "growth = 2: must be",
            "2",
        ),
        (
            "size = 0.2,",
            "size = 20,",
            "exceeds the whole outline",
            "{ to",
        ),
    ];
    for (from, to, message, underlined) in mistakes {
        assert_eq!(PUNCH.matches(from).count(), 1, "{from}");
        let text = with_outline(&PUNCH.replace(from, to));
        let error = read(&text).unwrap_err();
        let said = format!("{} | {}", error.message, error.label);
        assert!(said.contains(message), "{to}: {said}");
        let span = &text[error.span.clone().unwrap()];
        assert!(span.starts_with(underlined), "{to}: `{span}`: {said}");
    }
}

#[test]
fn an_edge_of_an_outline_may_belong_to_several_sides() {
    let outline = |names: &str| {
        format!(
            "analysis = \"plane-strain\"\n[[body]]\nname = \"b\"\nmaterial = {{ young = 1, poisson = 0 }}\n\
             fix = [{{ side = \"all\", x = 0, y = 0 }}]\n\
             mesh = {{ outline = {{ size = 0.3, from = [0, 0], edges = [\n\
             {{ to = [1, 0], name = [\"low\", \"all\"] }}, {{ to = [1, 1], name = {names} }}, {{ to = [0, 1] }}, {{ to = [0, 0] }}] }} }}\n"
        )
    };
    let model = read(&outline("\"all\"")).unwrap().model;
    let mesh = &model.bodies[0].mesh;
    let names: Vec<&str> = mesh.side_names().collect();
    assert_eq!(names, ["all", "low", "outline"]);
    let count = |side: &str| mesh.side(side).unwrap().len();
    assert!(count("low") > 2 && count("all") == 2 * count("low"));
    assert_eq!(count("outline"), count("all"));
    let error = read(&outline("[\"a\", \"a\"]")).unwrap_err();
    assert!(
        error.message.contains("the name `a` is listed twice"),
        "{error}"
    );
    let error = read(&outline("[\"a\", 2]")).unwrap_err();
    assert!(error.message.contains("expected a string"), "{error}");
}

#[test]
fn only_hoop_stresses_go_around_a_centre() {
    let old = "quantity = \"sole.pressure\"\nat       = [2.0, 1.0]";
    let hoop = "quantity = \"punch.stress.hoop\"\nat = [2, 1.5]";
    assert_eq!(model_with(old, hoop).probes[0].center, [0.0; 2]);
    let about = format!("{hoop}\ncenter = [2, -1]");
    assert_eq!(model_with(old, &about).probes[0].center, [2.0, -1.0]);
    let other = "quantity = \"punch.stress.xx\"\nat = [2, 1.5]\ncenter = [2, -1]";
    assert_mistake(old, other, "center", &["belongs to hoop stresses"]);
}
