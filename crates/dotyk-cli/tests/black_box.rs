//! What a user sees of the program: exit status, result files and their numbers, on small cases with known answers.

mod arrays;
mod schema;

use arrays::{Archive, market};
use schema::Schema;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What one run left behind.
struct Run {
    status: Option<i32>,
    stdout: String,
    stderr: String,
    folder: PathBuf,
}

impl Run {
    /// Runs `dotyk COMMAND case.toml ARGUMENTS` in a fresh folder of that name.
    fn new(name: &str, text: &str, command: &str, arguments: &[&str]) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("black_box")
            .join(name);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).unwrap();
        }
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("case.toml"), text).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_dotyk"))
            .args([command, "case.toml"])
            .args(arguments)
            .current_dir(&folder)
            .output()
            .unwrap();
        Self {
            status: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
            folder,
        }
    }

    /// Runs a case that is to converge.
    #[track_caller]
    fn solved(name: &str, text: &str) -> Self {
        let run = Self::new(name, text, "run", &[]);
        assert_eq!(run.status, Some(0), "{name}: {}", run.stderr);
        run
    }

    /// Runs a case that is to be refused, and returns the message.
    #[track_caller]
    fn refused(name: &str, text: &str) -> String {
        let run = Self::new(name, text, "run", &[]);
        assert_eq!(run.status, Some(2), "{name}: {}", run.stderr);
        assert!(run.stdout.is_empty(), "{name}: {}", run.stdout);
        assert_eq!(run.files(), [""; 0], "{name}");
        run.stderr
    }

    /// Runs a case that has no answer, and returns what it left with the message.
    #[track_caller]
    fn unsatisfied(name: &str, text: &str) -> (Self, String) {
        let run = Self::new(name, text, "run", &[]);
        assert_eq!(run.status, Some(1), "{name}: {}", run.stderr);
        let message = run.stderr.clone();
        (run, message)
    }

    /// Names of the result files.
    fn files(&self) -> Vec<String> {
        let Ok(list) = std::fs::read_dir(self.folder.join("case-out")) else {
            return Vec::new();
        };
        let names = list.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    /// The summary, which is as its schema says.
    fn summary(&self) -> Value {
        let text = std::fs::read_to_string(self.folder.join("case-out/summary.json")).unwrap();
        let summary = serde_json::from_str(&text).unwrap();
        assert_eq!(Schema::read().faults(&summary), [""; 0]);
        summary
    }

    /// Value of a probe; NaN where it is null.
    fn probe(&self, name: &str) -> f64 {
        let summary = self.summary();
        let mut probes = summary["probes"].as_array().unwrap().iter();
        let found = probes.find(|probe| probe["name"] == name).unwrap();
        found["value"].as_f64().unwrap_or(f64::NAN)
    }

    fn warnings(&self) -> Vec<String> {
        let summary = self.summary();
        let list = summary["warnings"].as_array().unwrap().iter();
        list.map(|w| w.as_str().unwrap().to_string()).collect()
    }

    /// One column of contact.csv.
    fn column(&self, name: &str) -> Vec<String> {
        let text = std::fs::read_to_string(self.folder.join("case-out/contact.csv")).unwrap();
        let mut lines = text.lines();
        let index = lines.next().unwrap().split(',').position(|c| c == name);
        let cell = |line: &str| line.split(',').nth(index.unwrap()).unwrap().to_string();
        lines.map(cell).collect()
    }
}

#[track_caller]
fn assert_near(found: f64, expected: f64, relative: f64) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{found} instead of {expected}"
    );
}

/// A body of steel with these cells, supports and loads.
fn steel(name: &str, mesh: &str, fix: &str, load: &str) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\nmesh = {{ {mesh} }}\nmaterial = {{ young = 210e9, poisson = 0.3 }}\nfix = [{fix}]\nload = [{load}]\n"
    )
}

fn contact(name: &str, nonmortar: &str, mortar: &str, more: &str) -> String {
    format!(
        "[[contact]]\nname = \"{name}\"\nnonmortar = \"{nonmortar}\"\nmortar = \"{mortar}\"\n{more}\n"
    )
}

fn probe(name: &str, quantity: &str, place: &str) -> String {
    format!("[[probe]]\nname = \"{name}\"\nquantity = \"{quantity}\"\n{place}\n")
}

const HEAD: &str = "analysis = \"plane-strain\"\n";
const LOW: &str = "rectangle = { from = [0, 0], to = [1, 1], cells = [4, 4] }";
const UP: &str = "rectangle = { from = [0, 1], to = [1, 2], cells = [4, 4] }";
const HELD: &str = "{ side = \"bottom\", x = 0, y = 0 }";
const SLIDES: &str = "{ side = \"left\", x = 0 }";

/// A block that may sink onto a held one under a pressure, with something added to the contact.
fn stack(pressure: f64, gap: &str) -> String {
    let load = format!("{{ side = \"top\", pressure = {pressure:e} }}");
    [
        HEAD.to_string(),
        steel("low", LOW, HELD, ""),
        steel("up", UP, SLIDES, &load),
        contact("sole", "up.bottom", "low.top", gap),
    ]
    .concat()
}

#[test]
fn loads_that_balance_each_other_are_measured_by_their_own_size() {
    let bar = "rectangle = { from = [0, 0], to = [3, 1], cells = [7, 3] }";
    let fix = "{ point = [0, 0], x = 0, y = 0 }, { point = [0, 1], x = 0 }";
    let pull =
        "{ side = \"left\", traction = [-1e6, 0] }, { side = \"right\", traction = [1e6, 0] }";
    let text = HEAD.to_string()
        + &steel("bar", bar, fix, pull)
        + &probe("stress", "bar.stress.xx", "at = [1, 0.5]");
    assert_near(Run::solved("bar", &text).probe("stress"), 1e6, 1e-10);

    let ring = "ring = { inner = 1, outer = 2, cells = [32, 4] }";
    let fix = "{ point = [1, 0], x = 0, y = 0 }, { point = [-1, 0], y = 0 }";
    let text = HEAD.to_string() + &steel("ring", ring, fix, "{ side = \"outer\", pressure = 1e6 }");
    Run::solved("pressed_ring", &text);
}

#[test]
fn supports_that_move_are_loads() {
    let bar = "rectangle = { from = [0, 0], to = [4, 1], cells = [16, 4] }";
    let fix =
        "{ side = \"left\", x = 0 }, { side = \"right\", x = 0.1 }, { point = [0, 0], y = 0 }";
    let text =
        HEAD.to_string() + &steel("bar", bar, fix, "") + &probe("pull", "bar.right.reaction.x", "");
    // free to contract across: plane strain modulus E/(1 − ν²) times strain 0.1/4
    let expected = 210e9 / (1.0 - 0.09) * 0.025;
    assert_near(
        Run::solved("stretched", &text).probe("pull"),
        expected,
        1e-9,
    );
}

#[test]
fn a_body_moved_as_a_whole_is_not_strained() {
    let lift = "{ side = \"top\", x = \"-0.1*(y - 1)\", y = \"0.2 + 0.1*x\" }";
    let text = [
        HEAD.to_string(),
        steel("low", LOW, HELD, ""),
        steel("up", UP, lift, ""),
        contact("sole", "up.bottom", "low.top", ""),
        probe("corner", "up.displacement.y", "at = [1, 1]"),
        probe("stress", "up.stress.von_mises", "reduce = \"max\""),
    ]
    .concat();
    let run = Run::solved("lifted", &text);
    assert_near(run.probe("corner"), 0.3, 1e-12);
    // the strain is rounding of the rotation
    assert!(run.probe("stress") < 210e9 * 1e-15);
    assert!(run.column("status").iter().all(|status| status == "open"));
}

#[test]
fn small_strains_do_not_drown_in_a_large_clearance() {
    // the clearance is a hundred million times the compression
    let text = stack(100.0, "gap = 1e-2") + &probe("force", "sole.resultant.y", "");
    assert_near(Run::solved("clearance", &text).probe("force"), 100.0, 1e-9);
    // driven by a support instead of a load
    let driven = "{ side = \"top\", x = 0, y = -0.01000001 }";
    let text = [
        HEAD.to_string(),
        steel("low", LOW, HELD, ""),
        steel("up", UP, driven, ""),
        contact("sole", "up.bottom", "low.top", "gap = 1e-2"),
    ]
    .concat();
    Run::solved("driven", &text);
}

#[test]
fn sides_with_different_nodes_are_integrated() {
    let load = "{ side = \"top\", pressure = 1 }";
    for cells in ["[3, 3]", "[2, 2]", "[8, 8]"] {
        let mesh = UP.replace("[4, 4]", cells);
        let text = |more: &str| {
            [
                HEAD.to_string(),
                steel("low", LOW, HELD, ""),
                steel("up", &mesh, SLIDES, load),
                contact("sole", "up.bottom", "low.top", more),
                probe("force", "sole.resultant.y", ""),
            ]
            .concat()
        };
        assert_near(
            Run::solved("different_nodes", &text("")).probe("force"),
            1.0,
            1e-10,
        );
        let message = Run::refused("forced_nodes", &text("pairing = \"node-to-node\""));
        for word in [
            "sole",
            "needs coincident nodes",
            "leave out `pairing`",
            "line 15",
        ] {
            assert!(message.contains(word), "{cells}: no {word} in {message}");
        }
    }
}

#[test]
fn sides_that_never_face_each_other_are_no_contact() {
    let aside = UP.replace("[0, 1], to = [1, 2]", "[5, 1], to = [6, 2]");
    let text = |fix: &str| {
        [
            HEAD.to_string(),
            steel("low", LOW, HELD, ""),
            steel("up", &aside, fix, "{ side = \"top\", pressure = 1 }"),
            contact("sole", "up.bottom", "low.top", ""),
        ]
        .concat()
    };
    let run = Run::solved("aside", &text("{ side = \"top\", x = 0, y = 0 }"));
    assert_eq!(run.summary()["contact_unknowns"], 0);
    assert!(run.column("gap").iter().all(|gap| gap == "NaN"));
    let message = Run::refused("aside_floating", &text(SLIDES));
    for word in ["\"up\"", "translation along y", "no contact faces it"] {
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn a_contact_beyond_all_reach_holds_nothing() {
    let message = Run::refused("reach", &stack(1.0, "gap = 1e9"));
    assert!(message.contains("\"up\"") && message.contains("out of reach"));
}

#[test]
fn dependent_conditions_are_dropped_and_named() {
    let text = stack(1e6, "") + &contact("again", "low.top", "up.bottom", "");
    let run = Run::solved("dependent", &text);
    let warnings = run.warnings();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("\"again\"") && warnings[0].contains("dropped"));
    let summary = run.summary();
    assert_eq!(summary["contact_unknowns"], 5);
    assert_near(
        summary["contacts"][0]["resultant"][1].as_f64().unwrap(),
        1e6,
        1e-9,
    );
    let (contacts, status) = (run.column("contact"), run.column("status"));
    let pressure = run.column("pressure");
    for ((contact, status), pressure) in contacts.iter().zip(&status).zip(&pressure) {
        let dropped = contact == "again";
        assert_eq!(status == "fixed", dropped, "{contact} {status}");
        assert_eq!(pressure == "NaN", dropped, "{contact} {pressure}");
    }
}

#[test]
fn a_probe_beside_a_side_is_refused() {
    for (at, good) in [
        ("[0.3, 1.0]", true),
        ("[1.0, 1.0]", true),
        ("[0.3, 1.1]", false),
        ("[1.01, 1.0]", false),
        ("[-0.01, 1.0]", false),
        ("[0.3, 0.0]", false),
    ] {
        let text = stack(1e6, "") + &probe("here", "sole.pressure", &format!("at = {at}"));
        if good {
            Run::solved("probe", &text);
        } else {
            let message = Run::refused("probe", &text);
            assert!(
                message.contains("\"here\"") && message.contains("case.toml, line"),
                "{message}"
            );
        }
    }
}

#[test]
fn a_largest_stress_at_the_edge_of_a_punch_is_told_with_the_one_beside() {
    let low = "rectangle = { from = [0, 0], to = [4, 4], cells = [32, 32] }";
    let up = "rectangle = { from = [0, 4], to = [1, 5], cells = [8, 8] }";
    let held = "{ side = \"bottom\", y = 0 }, { side = \"left\", x = 0 }";
    let load = "{ side = \"top\", pressure = 1e6 }";
    let text = [
        HEAD.to_string(),
        steel("low", low, held, ""),
        steel("up", up, SLIDES, load),
        contact("sole", "up.bottom", "low.top", ""),
    ]
    .concat();
    let run = Run::solved("punch", &text);
    let body = &run.summary()["bodies"][1];
    assert_eq!(body["max_von_mises_place"], "the end of a contact");
    let [most, away] =
        ["max_von_mises", "max_von_mises_away"].map(|key| body[key].as_f64().unwrap());
    assert!(away < 0.9 * most, "{away} {most}");
    let at = |key: &str| body[key].as_array().unwrap().len();
    assert_eq!(
        [at("max_von_mises_at"), at("max_von_mises_away_at")],
        [2, 2]
    );
    let told = "max von Mises of up is at the end of a contact and grows as the mesh is refined";
    assert!(run.stdout.contains(told), "{}", run.stdout);
    let page = std::fs::read_to_string(run.folder.join("case-out/report.html")).unwrap();
    assert!(
        page.contains("The colours end at") && page.contains("of up is at the end of a contact")
    );
    // a uniform stress has no such place, and the colours hold all of it
    let run = Run::solved("smooth", &stack(1e6, "").replace("x = 0, y = 0", "y = 0"));
    let summary = run.summary();
    assert!(summary["bodies"][0]["max_von_mises_place"].is_null());
    assert!(!run.stdout.contains("grows as the mesh"));
    let page = std::fs::read_to_string(run.folder.join("case-out/report.html")).unwrap();
    assert!(!page.contains("The colours end at"));
}

/// Rows of lines.csv without its head: step, probe, s, x, y, value.
fn rows_of_lines(run: &Run) -> Vec<(usize, String, [f64; 4])> {
    let text = std::fs::read_to_string(run.folder.join("case-out/lines.csv")).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    assert_eq!(head, "step,probe,s,x,y,value");
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells[k].parse().unwrap();
        let numbers = [2, 3, 4, 5].map(number);
        (cells[0].parse().unwrap(), cells[1].to_string(), numbers)
    };
    rows.lines().map(row).collect()
}

#[test]
fn a_line_is_told_in_a_table_a_plot_and_its_range() {
    let line = "along = { from = [0.5, \"-h\"], to = [0.5, 2], points = \"3*n\" }";
    let held = "{ side = \"bottom\", y = 0 }, { side = \"left\", x = 0 }";
    let text = [
        HEAD.to_string() + "[parameters]\nh = 0.5\nn = 2\n",
        steel("low", LOW, held, ""),
        steel("up", UP, SLIDES, "{ side = \"top\", pressure = \"1e6*t\" }"),
        contact("sole", "up.bottom", "low.top", ""),
        steps(&[0.5, 1.0]),
        probe("middle", "low.stress.yy", line),
        probe("sole", "sole.pressure", "along = \"up.bottom\""),
        probe(
            "pressed",
            "up.stress.normal",
            "along = \"up.top\"\nreduce = \"integral\"",
        ),
    ]
    .concat();
    let run = Run::solved("lines", &text);
    let rows = rows_of_lines(&run);
    // both steps: six points, and five nodes
    assert_eq!(rows.len(), 2 * (6 + 5));
    for (step, name, [s, x, y, value]) in &rows {
        let pressure = 5e5 * *step as f64;
        if name == "sole" {
            assert_near(*value, pressure, 1e-9);
            assert_eq!((*s, *y), (*x, 1.0));
        } else {
            assert_eq!((*x, *s), (0.5, y + 0.5));
            // below and above the lower block there is none of its stress
            match (0.0..=1.0).contains(y) {
                true => assert_near(*value, -pressure, 1e-9),
                false => assert!(value.is_nan()),
            }
        }
    }
    let probes = &run.summary()["probes"];
    assert_eq!(
        (probes[0]["value"].is_null(), &probes[0]["points"]),
        (true, &6.into())
    );
    assert_eq!(probes[0]["length"], 2.5);
    assert_near(probes[0]["smallest"].as_f64().unwrap(), -1e6, 1e-6);
    assert_near(probes[1]["largest"].as_f64().unwrap(), 1e6, 1e-9);
    assert_near(run.probe("pressed"), -1e6, 1e-6);
    assert!(probes[2].get("points").is_none());
    assert!(
        run.stdout.contains("along 2.5, 6 points in lines.csv"),
        "{}",
        run.stdout
    );
    let page = std::fs::read_to_string(run.folder.join("case-out/report.html")).unwrap();
    // each is drawn for pages and for phones
    assert_eq!(page.matches(" along a line\"").count(), 4, "a plot each");
}

#[test]
fn slip_is_the_motion_along_the_tangent_without_friction() {
    // the lower block is held along x, the upper one moves by 1e-3 along it
    let text = [
        HEAD.to_string(),
        steel("low", LOW, HELD, ""),
        steel("up", UP, "{ side = \"left\", x = 1e-3 }", ""),
        contact("sole", "up.bottom", "low.top", ""),
        probe("slip", "sole.slip", "at = [0.5, 1]"),
    ]
    .concat();
    // the normal (0, −1) turned by +90° is (1, 0)
    assert_near(Run::solved("slip", &text).probe("slip"), 1e-3, 1e-12);
}

#[test]
fn a_run_that_does_not_converge_says_why_and_leaves_its_summary() {
    let text = stack(1e6, "") + "[solver]\nmethod = \"uzawa\"\nmax_iterations = 3\n";
    let run = Run::new("three_steps", &text, "run", &[]);
    assert_eq!(run.status, Some(1), "{}", run.stderr);
    assert_eq!(run.files(), ["summary.json"]);
    let summary = run.summary();
    assert_eq!(summary["converged"], false);
    assert_eq!(summary["solver"], "uzawa");
    assert!(run.stderr.contains("more iterations"), "{}", run.stderr);
}

/// The stack with its pressure as a parameter and a probe of the force; `scale` multiplies an expression of it.
fn parametric() -> String {
    let parameters = "[parameters]\np = 1e6\nn = 4\n\n[[body]]";
    stack(1e6, "")
        .replacen("[[body]]", parameters, 1)
        .replacen("pressure = 1e6", "pressure = \"p\"", 1)
        .replace("cells = [4, 4]", "cells = [\"n\", \"n\"]")
        + &probe("force, all of it", "sole.resultant.y", "")
}

#[test]
fn parameters_take_values_from_the_command_line() {
    let text = parametric();
    let own = Run::solved("own_value", &text);
    assert_near(own.probe("force, all of it"), 1e6, 1e-10);
    assert!(own.warnings().is_empty());
    let idle = text.replacen("n = 4", "n = 4\nidle = 3", 1);
    let warnings = Run::solved("idle_value", &idle).warnings();
    assert!(
        warnings[0].contains("depends on the parameter `idle`"),
        "{warnings:?}"
    );
    let taken = text.replace("force, all of it", "p");
    let study = Run::new("taken", &taken, "study", &["--vary", "p=1..2:2"]);
    assert_eq!(study.status, Some(2));
    assert!(
        study.stderr.contains("are both named `p`"),
        "{}",
        study.stderr
    );
    assert_eq!(own.summary()["parameters"]["p"], 1e6);
    let set = ["--set", "p=n * 5e5", "--set", "n=2"];
    let other = Run::new("other_value", &text, "run", &set);
    assert_eq!(other.status, Some(2), "{}", other.stderr);
    assert!(
        other.stderr.contains("unknown name `n`"),
        "{}",
        other.stderr
    );
    let set = ["--set", "n=p / 5e5", "--set", "p = 2e6"];
    let other = Run::new("other_value", &text, "run", &set);
    assert_near(other.probe("force, all of it"), 2e6, 1e-10);
    assert_eq!(other.column("node").len(), 5);
    assert!(other.folder.join("case-out/report.html").exists());
    let page = std::fs::read_to_string(other.folder.join("case-out/report.html")).unwrap();
    assert!(page.contains("Parameters p = 2"));
    for command in ["run", "check", "compare"] {
        let refused = Run::new("unknown_value", &text, command, &["--set", "q=1"]);
        assert_eq!(refused.status, Some(2));
        let nearest = "there is no parameter `q`";
        assert!(
            refused.stderr.contains(nearest),
            "{command}: {}",
            refused.stderr
        );
    }
}

#[test]
fn programs_get_the_summary_and_people_no_rounding_errors() {
    let text = stack(1e6, "").replacen(
        "analysis",
        "units = { length = \"m\", force = \"N\" }\nanalysis",
        1,
    );
    let run = Run::new("tables", &text, "run", &[]);
    assert!(
        run.stdout.contains("contact unknowns, in m and N"),
        "{}",
        run.stdout
    );
    let line = run
        .stdout
        .lines()
        .find(|line| line.starts_with("sole"))
        .unwrap();
    let words: Vec<&str> = line.split_whitespace().collect();
    // the force along x is rounding beside the one along y
    assert_eq!(words[1..3], ["0", "1e6"], "{line}");
    let json = Run::new("json", &text, "run", &["--json"]);
    let told: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(told, json.summary());
    let failing = text.clone() + "[solver]\nmethod = \"uzawa\"\nmax_iterations = 3\n";
    let failed = Run::new("json_failed", &failing, "run", &["--json"]);
    assert_eq!(failed.status, Some(1));
    let told: Value = serde_json::from_str(&failed.stdout).unwrap();
    assert_eq!(told["converged"], false);
    let round = text
        .replace("plane-strain", "axisymmetric")
        .replace("side = \"left\", x = 0", "side = \"right\", x = 0");
    let round = Run::new("round_tables", &round, "run", &[]);
    assert!(
        round.stdout.contains("force r") && round.stdout.contains("reaction z"),
        "{}",
        round.stdout
    );
}

#[test]
fn under_pressure_on_all_sides_rounding_is_no_result() {
    let text = r#"
analysis = "3d"
[[body]]
name = "b"
mesh = { box = { from = [0, 0, 0], to = [1, 2, 3], cells = [3, 2, 3], cell = "tet10" } }
material = { young = 1000, poisson = 0.3 }
fix = [{ point = [0, 0, 0], x = 0, y = 0, z = 0 }, { point = [1, 0, 0], y = 0, z = 0 }, { point = [0, 2, 0], z = 0 }]
load = [{ side = ["left", "right", "front", "back", "bottom", "top"], pressure = 1 }]
[[probe]]
name = "shear"
quantity = "b.stress.xy"
reduce = "max"
"#;
    let run = Run::solved("all_sides", text);
    let line = |start: &str| {
        let mut lines = run.stdout.lines();
        lines.find(|line| line.starts_with(start)).unwrap()
    };
    // von Mises stress and reactions
    let body: Vec<&str> = line("b ").split_whitespace().collect();
    assert_eq!(body[2..], ["0"; 4], "{}", run.stdout);
    let shear: Vec<&str> = line("shear ").split_whitespace().collect();
    assert_eq!(shear[2], "0", "{}", run.stdout);
    assert!(
        !run.stdout.contains("grows as the mesh is refined"),
        "{}",
        run.stdout
    );
}

#[test]
fn several_cases_are_run_each_into_a_folder_of_its_own() {
    let text = parametric();
    let folder = Run::solved("several", &text).folder;
    std::fs::write(folder.join("other.toml"), &text).unwrap();
    std::fs::write(folder.join("broken.toml"), "analysis = 1").unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_dotyk"))
            .args(arguments)
            .current_dir(&folder)
            .output()
            .unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let all = [
        "run",
        "case.toml",
        "broken.toml",
        "other.toml",
        "--out",
        "all",
        "--set",
        "n=2",
    ];
    let (status, message) = run(&all);
    assert_eq!(status, Some(2), "{message}");
    assert!(message.contains("broken.toml, line 1"), "{message}");
    for case in ["case", "other"] {
        assert!(
            folder.join("all").join(case).join("summary.json").exists(),
            "{case}"
        );
    }
    let (status, message) = run(&["run", "case.toml", "./case.toml"]);
    assert_eq!(status, Some(2));
    assert!(
        message.contains("another case has the same name"),
        "{message}"
    );
    // folders that not every system has, or tells apart
    for (case, words) in [("nul.toml", "for a device"), ("CASE.toml", "in case alone")] {
        let (status, message) = run(&["run", "case.toml", case]);
        assert_eq!(status, Some(2), "{case}");
        assert!(message.contains(words), "{case}: {message}");
    }
}

#[test]
fn a_study_lists_every_member_with_probes_or_reason() {
    // a line has no column, and says so
    let line = probe("line", "sole.gap", "along = \"up.bottom\"");
    let text = parametric().replacen("[[contact]]", &(line + "\n[[contact]]"), 1);
    let vary = ["--vary", "p=1e6..3e6:3", "--vary", "n=2..3:3", "--log", "p"];
    let study = Run::new("study", &text, "study", &vary);
    assert_eq!(study.status, Some(1), "{}", study.stderr);
    assert!(study.stderr.contains("`line` has values along a line"));
    assert_eq!(study.files(), ["study.csv", "study.html"]);
    let table = std::fs::read_to_string(study.folder.join("case-out/study.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "p,n,\"force, all of it\",converged,reason");
    assert_eq!(lines.len(), 10);
    for (k, line) in lines[1..].iter().enumerate() {
        let cells: Vec<&str> = line.splitn(5, ',').collect();
        let number = |k: usize| cells[k].parse::<f64>().unwrap();
        assert_near(number(0), 1e6 * 3f64.powf((k / 3) as f64 / 2.0), 1e-14);
        assert_eq!(number(1), [2.0, 2.5, 3.0][k % 3]);
        match k % 3 {
            1 => {
                assert_eq!(cells[2..4], ["NaN", "false"]);
                assert!(
                    cells[4].contains("must come out whole, it is 2.5"),
                    "{line}"
                );
            }
            _ => {
                assert_near(number(2), number(0), 1e-10);
                assert_eq!(cells[3..], ["true", ""]);
            }
        }
    }
    assert!(
        study.stdout.contains("NOT CONVERGED: 6 of 9 members"),
        "{}",
        study.stdout
    );
    let page = std::fs::read_to_string(study.folder.join("case-out/study.html")).unwrap();
    assert!(page.contains("3 of 9 members have no answer") && page.contains("<svg"));
}

#[test]
fn supports_on_lists_hold_each_side_and_parts_tell_their_reactions() {
    let body = |fix: &str| {
        format!(
            "{HEAD}[[body]]\nname = \"b\"\nmesh = {{ rectangle = {{ from = [0, 0], to = [4, 1], cells = [8, 2] }}, \
             sides = {{ west = {{ of = \"bottom\", min = [0, 0], max = [2, 0] }} }} }}\n\
             material = {{ young = 1000, poisson = 0.3, thickness = 2 }}\nfix = [{fix}]\n\
             load = [{{ side = \"top\", pressure = 1 }}]\n"
        )
    };
    let sink = "quantity = \"b.displacement.y\"\nreduce = \"min\"\n";
    let probes = format!("[[probe]]\nname = \"sink\"\n{sink}")
        + &probe("bottom", "b.bottom.reaction.y", "")
        + &probe("west", "b.west.reaction.y", "");
    let list = body("{ side = [\"bottom\", \"left\", \"right\"], normal = 0 }") + &probes;
    let run = Run::solved("rollers", &list);
    // confined compression: (1 + ν)(1 − 2ν)/(1 − ν) p/E
    assert_near(run.probe("sink"), -0.742857142857e-3, 1e-10);
    assert_near(run.probe("bottom"), 8.0, 1e-10);
    // the middle node counts whole for both halves
    assert_near(run.probe("west"), 4.5, 1e-10);
}

#[test]
fn a_study_tells_all_load_steps_if_asked() {
    let steps = "[[step]]\ntime = 0.5\n[[step]]\ntime = 1\n";
    let text = parametric().replacen("pressure = \"p\"", "pressure = \"p*t\"", 1) + steps;
    let text = text + "[[probe]]\nname = \"ratio\"\nexpression = \"'force, all of it'/p\"\n";
    let vary = [
        "--vary",
        "p=1e6..3e6:3",
        "--vary",
        "n=2..2.5:2",
        "--steps",
        "all",
    ];
    let study = Run::new("study_steps", &text, "study", &vary);
    assert_eq!(study.status, Some(1), "{}", study.stderr);
    let read = |name: &str| std::fs::read_to_string(study.folder.join("case-out").join(name));
    let table = read("study.csv").unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "p,n,step,time,\"force, all of it\",ratio,converged,reason"
    );
    assert_eq!(lines.len(), 1 + 3 * (2 + 1));
    for of_member in lines[1..].chunks(3) {
        for (k, line) in of_member[..2].iter().enumerate() {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells[2..4], [["1", "0.5"], ["2", "1.0"]][k]);
            assert_near(cells[5].parse().unwrap(), [0.5, 1.0][k], 1e-10);
            assert_eq!(cells[6..], ["true", ""]);
        }
        assert!(
            of_member[2].contains(",2.5,1,NaN,NaN,NaN,false,"),
            "{}",
            of_member[2]
        );
    }
    let page = read("study.html").unwrap();
    assert!(page.contains("Probes over the load steps") && page.contains("Over time, "));
    let named = text.replacen("name = \"ratio\"", "name = \"time\"", 1);
    let study = Run::new("study_time", &named, "study", &vary);
    assert!(
        study.stderr.contains("are both named `time`"),
        "{}",
        study.stderr
    );
    let study = Run::new("study_time", &named, "study", &vary[..2]);
    assert_eq!(study.status, Some(0), "{}", study.stderr);
}

#[test]
fn a_study_tells_the_warnings_of_its_members() {
    let text = parametric().replacen("p = 1e6", "p = 2e10", 1);
    let study = Run::new("warned", &text, "study", &["--vary", "p=1e6..2e10:3"]);
    assert_eq!(study.status, Some(0), "{}", study.stderr);
    // half and all of 2e10 are beyond 5 % of strain, 1e6 is not
    assert!(
        study
            .stderr
            .contains("1 of 3 members: body \"up\" is strained"),
        "{}",
        study.stderr
    );
    let page = std::fs::read_to_string(study.folder.join("case-out/study.html")).unwrap();
    assert!(page.contains("is strained by"));
}

#[test]
fn a_force_on_the_axis_is_refused() {
    let text = "analysis = \"axisymmetric\"\n[[body]]\nname = \"b\"\n\
                mesh = { rectangle = { from = [0, 0], to = [4, 1], cells = [8, 2] } }\n\
                material = { young = 1000, poisson = 0.3 }\nfix = [{ side = \"bottom\", y = 0 }]\n\
                load = [{ side = \"left\", force = [0, 1] }]\n";
    for command in ["run", "check"] {
        let run = Run::new("axis_force", text, command, &[]);
        assert_eq!(run.status, Some(2), "{}", run.stderr);
        assert!(
            run.stderr.contains("\"left\" has no area"),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn a_study_of_what_is_not_there_is_refused() {
    let text = parametric();
    let mistakes: [(&[&str], &str); 11] = [
        (&[], "--vary"),
        (&["--vary", "q=1..2:3"], "there is no parameter `q`"),
        (&["--vary", "p=1..2"], "expected NAME=A..B:COUNT"),
        (&["--vary", "p=1..2:1"], "one value cannot be both ends"),
        (&["--vary", "p=1..2:2", "--vary", "p=1..2:2"], "given twice"),
        (&["--vary", "p=1..2:2", "--set", "p=3"], "varied and set"),
        (
            &["--vary", "p=1..2:2", "--log", "n"],
            "--vary n=... is missing",
        ),
        (
            &["--vary", "p=-1..2:2", "--log", "p"],
            "both ends must be positive",
        ),
        (
            &["--vary", "n=1..2:2", "--set", "p=1", "--set", "p=2"],
            "--set p is given twice",
        ),
        (&["--vary", "n=1..2:2000000"], "too many, at most"),
        (
            &["--vary", "p=1..2:2000", "--vary", "n=1..2:2000"],
            "more than 1000000 combinations",
        ),
    ];
    for (arguments, message) in mistakes {
        let study = Run::new("no_study", &text, "study", arguments);
        assert_eq!(study.status, Some(2), "{arguments:?}");
        assert!(study.stderr.contains(message), "{}", study.stderr);
        assert_eq!(study.files(), [""; 0]);
    }
}

#[test]
fn a_study_draws_columns_against_each_other() {
    let plot = [
        "--plot",
        "p:force, all of it",
        "--plot",
        "force, all of it:n",
    ];
    let vary = ["--vary", "p=1e6..3e6:3", "--vary", "n=2..3:2", "--quiet"];
    let study = Run::new(
        "pairs",
        &parametric(),
        "study",
        &[&vary[..], &plot].concat(),
    );
    assert_eq!(study.status, Some(0), "{}", study.stderr);
    assert_eq!(study.files(), ["study.csv", "study.html", "study.svg"]);
    let read = |name: &str| std::fs::read_to_string(study.folder.join("case-out").join(name));
    let picture = read("study.svg").unwrap();
    assert!(read("study.html").unwrap().contains("Against each other."));
    // the force does not depend on n: one curve; n does, and is one for each of its values
    let drawn = |name: &str| picture.contains(&format!(">{name}</text>"));
    assert!(drawn("force, all of it") && !drawn("force, all of it, n = 2"));
    assert!(drawn("n, n = 2") && drawn("n, n = 3"));
    // three points of each of the three curves, which have a shape each
    assert_eq!(picture.matches("</title>").count(), 9);
    assert_eq!(picture.matches("<circle").count(), 3);

    for (plot, message) in [
        ("p", "expected X:Y"),
        ("p:q", "p, n, force, all of it"),
        ("line:p", "expected X:Y"),
    ] {
        let study = Run::new(
            "no_pair",
            &parametric(),
            "study",
            &["--vary", "p=1..2:2", "--vary", "n=2..3:2", "--plot", plot],
        );
        assert_eq!(study.status, Some(2), "{plot}");
        assert!(study.stderr.contains(message), "{}", study.stderr);
        assert_eq!(study.files(), [""; 0]);
    }
    let other = parametric().replacen(
        "[[contact]]",
        &(probe("gap", "sole.gap", "reduce = \"max\"") + "\n[[contact]]"),
        1,
    );
    let mixed = [
        "--vary",
        "p=1..2:2",
        "--plot",
        "p:force, all of it",
        "--plot",
        "p:gap",
    ];
    let study = Run::new("mixed", &other, "study", &mixed);
    assert_eq!(study.status, Some(2));
    assert!(
        study.stderr.contains("cannot share its axis"),
        "{}",
        study.stderr
    );
}

#[test]
fn the_ground_reaction_and_the_support_line_meet_in_equilibrium() {
    let text = include_str!("../../../cases/convergence-confinement/tunnel.toml");
    let vary = [
        "--vary",
        "left=0..1:6",
        "--vary",
        "lined_at=0.2..0.6:2",
        "--quiet",
    ];
    let study = Run::new("confinement", text, "study", &vary);
    assert_eq!(study.status, Some(0), "{}", study.stderr);
    let table = std::fs::read_to_string(study.folder.join("case-out/study.csv")).unwrap();
    // u = released a/2G; p = k (u − u at installation), k of a thick ring (Lamé)
    let (shear, ring) = (500.0 / 2.6, 30_000.0 / 2.4);
    let (a, bore) = (5.15f64, 4.85f64);
    let bare = a / (2.0 * shear);
    let k = 2.0 * ring * (a * a - bore * bore) / (a * (0.6 * a * a + bore * bore));
    let (mut members, mut meet) = (0, 0);
    for line in table.lines().skip(1) {
        let numbers: Vec<f64> = line
            .split(',')
            .take(5)
            .map(|n| n.parse().unwrap())
            .collect();
        let [left, lined_at, alone, wall, pressure] = numbers[..] else {
            panic!("{line}");
        };
        assert!((alone - (1.0 - left) * bare).abs() < 0.002 * bare, "{line}");
        let borne = k * (wall - lined_at * bare).max(0.0);
        assert!((pressure - borne).abs() < 0.002, "{line}");
        // what is left of the ground's pressure and what the lining bears hold the ground
        assert!(
            (wall - (1.0 - left - pressure) * bare).abs() < 0.002 * bare,
            "{line}"
        );
        members += 1;
        meet += usize::from(pressure > 0.3);
    }
    assert_eq!((members, meet > 2), (12, true));
}

/// Load steps at these times.
fn steps(times: &[f64]) -> String {
    let step = |time: &f64| format!("[[step]]\ntime = {time:?}\n");
    times.iter().map(step).collect()
}

#[test]
fn every_step_leaves_its_fields_its_rows_and_its_summary() {
    let gap = "gap = \"1e-6 * t\"\n";
    let text = stack(1e6, gap).replacen("pressure = 1e6", "pressure = \"1e6 * t\"", 1)
        + &probe("force", "sole.resultant.y", "")
        + &steps(&[0.5, 1.0, 2.5]);
    let run = Run::solved("steps", &text);
    let mut expected = vec!["case.pvd".to_string(), "contact.csv".to_string()];
    for body in ["low", "up"] {
        expected.extend((1..4).map(|step| format!("{body}_{step:04}.vtu")));
    }
    expected.extend((1..4).map(|step| format!("case_{step:04}.vtm")));
    expected.extend(["report.html", "summary.json"].map(String::from));
    expected.sort();
    assert_eq!(run.files(), expected);
    let counts =
        ["1", "2", "3"].map(|step| run.column("step").iter().filter(|s| *s == step).count());
    assert_eq!(counts, [5, 5, 5]);
    let summary = run.summary();
    let list = summary["steps"].as_array().unwrap();
    for (i, time) in [0.5, 1.0, 2.5].into_iter().enumerate() {
        assert_eq!(
            (&list[i]["step"], &list[i]["time"]),
            (&(i + 1).into(), &time.into())
        );
        assert_eq!(list[i]["converged"], true);
        let force = list[i]["probes"][0]["value"].as_f64().unwrap();
        assert_near(force, 1e6 * time, 1e-10);
    }
    assert_eq!(list[2]["certificate"], summary["certificate"]);
    assert_eq!(list[2]["contacts"], summary["contacts"]);
    assert!(
        run.stdout.contains("converged: 3 of 3 steps"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_step_that_does_not_converge_leaves_the_good_ones() {
    let text = stack(1e6, "").replacen("pressure = 1e6", "pressure = \"1e6 * t\"", 1)
        + "[solver]\nmethod = \"uzawa\"\nmax_iterations = 3\n"
        + &steps(&[0.0, 1.0, 2.0]);
    let run = Run::new("failing_step", &text, "run", &[]);
    assert_eq!(run.status, Some(1), "{}", run.stderr);
    let good = [
        "case.pvd",
        "case_0001.vtm",
        "contact.csv",
        "low_0001.vtu",
        "report.html",
        "summary.json",
        "up_0001.vtu",
    ];
    assert_eq!(run.files(), good);
    let summary = run.summary();
    let steps = summary["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 1);
    assert_eq!(steps[0]["converged"], true);
    // the top level is the last good step, but the run has failed
    assert_eq!(
        (&summary["converged"], &summary["step"]),
        (&Value::from(false), &Value::from(1))
    );
    let failed = &summary["failed_step"];
    assert_eq!(
        (&failed["step"], &failed["time"]),
        (&Value::from(2), &Value::from(1.0))
    );
    assert!(
        failed["reason"].as_str().unwrap().contains("residual"),
        "{failed}"
    );
    assert!(run.stderr.contains("step 2 of 3 (t = 1)"), "{}", run.stderr);
    assert!(
        run.stdout.contains("NOT CONVERGED: 1 of 3 steps"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_mistake_in_a_later_step_is_bad_input_and_leaves_the_good_ones() {
    let text = stack(1e6, "").replacen("pressure = 1e6", "pressure = \"1e6 / (2 - t)\"", 1)
        + &steps(&[0.0, 1.0, 2.0]);
    let run = Run::new("bad_step", &text, "run", &[]);
    assert_eq!(run.status, Some(2), "{}", run.stderr);
    assert!(run.stderr.contains("step 3 (t = 2)"), "{}", run.stderr);
    let summary = run.summary();
    assert_eq!(summary["steps"].as_array().unwrap().len(), 2);
    assert_eq!(
        (&summary["converged"], &summary["failed_step"]["step"]),
        (&Value::from(false), &Value::from(3))
    );
    assert!(run.files().contains(&"up_0002.vtu".to_string()));
}

#[test]
fn check_tells_load_and_holder_of_each_free_motion() {
    let run = Run::new("check", &stack(1e6, "gap = 0.5"), "check", &[]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    for words in [
        "translation along y: load on it -1000000, held by contact \"sole\"",
        "initial clearance 5.0000e-1",
    ] {
        assert!(run.stdout.contains(words), "{}", run.stdout);
    }
    assert!(run.files().is_empty());
    let run = Run::new("check_bad", &stack(-1e6, ""), "check", &[]);
    assert_eq!(run.status, Some(2));
    assert!(
        run.stderr.contains("case.toml, line 9, column"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_body_that_nothing_holds_is_told_once() {
    let text = "analysis = \"3d\"\n[[body]]\nname = \"b\"\n\
                mesh = { box = { from = [0, 0, 0], to = [1, 1, 1], cells = [1, 1, 1] } }\n\
                material = { young = 1, poisson = 0.3 }\n";
    let check = Run::new("nothing_holds", text, "check", &[]);
    assert_eq!(check.status, Some(2));
    assert!(
        check.stdout.contains("  floats: every rigid motion\n"),
        "{}",
        check.stdout
    );
    let words = "its supports leave every rigid motion free";
    let said = |text: &str| text.matches(words).count();
    assert_eq!([said(&check.stdout), said(&check.stderr)], [0, 1]);
}

#[test]
fn a_table_for_a_list_is_explained() {
    let text = stack(1.0, "").replacen("[[contact]]", "[contact]", 1);
    let message = Run::refused("brackets", &text);
    assert!(message.contains("[[contact]]"), "{message}");
}

#[test]
fn what_is_left_out_of_a_mesh_file_is_a_warning_everywhere() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/press-fit-gmsh/rings.msh");
    let mesh = format!(
        "file = {{ path = '{}', group = \"inner\" }}",
        file.display()
    );
    let fix = "{ side = \"on-x\", y = 0 }, { side = \"on-y\", x = 0 }";
    let load = "{ side = \"fit\", pressure = 1e6 }";
    let text = format!("{HEAD}{}", steel("inner", &mesh, fix, load));
    let run = Run::solved("mesh_file", &text);
    let warnings = run.warnings();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    let check = Run::new("mesh_file_check", &text, "check", &[]);
    assert_eq!(check.status, Some(0), "{}", check.stderr);
    for (warning, words) in warnings.iter().zip([
        "rings.msh: no body has the groups of cells `outer`",
        "rings.msh: the groups of edges `rim` are on the boundary of no body",
    ]) {
        assert!(warning.contains(words), "{warning}");
        assert!(
            run.stderr.contains(&format!("warning: {warning}")),
            "{}",
            run.stderr
        );
        assert!(check.stdout.contains(words), "{}", check.stdout);
    }
}

#[test]
fn a_face_to_extrude_and_a_solid_come_from_one_file() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../dotyk/tests/data");
    let file = data.join("gmsh_pipe_tet4_41.msh");
    let file = |group| {
        format!(
            "file = {{ path = '{}', group = '{group}' }}",
            file.display()
        )
    };
    let slice = format!(
        "extrude = {{ mesh = {{ {} }}, height = 1, layers = 1 }}",
        file("bottom")
    );
    let held = |side: &str| format!("{{ side = \"{side}\", x = 0, y = 0, z = 0 }}");
    let text = format!(
        "analysis = \"3d\"\n{}{}",
        steel("slice", &slice, &held("first"), ""),
        steel("pipe", &file("pipe"), &held("bottom"), "")
    );
    let check = Run::new("mesh_file_twice", &text, "check", &[]);
    assert_eq!(check.status, Some(0), "{}{}", check.stdout, check.stderr);
    // what one of the two has no use for is the other
    for words in ["no body has", "left out", "boundary of no body"] {
        assert!(!check.stdout.contains(words), "{}", check.stdout);
    }
}

/// A block on a slope: gravity turned by an angle whose tangent is the coefficient times a factor.
fn slope(factor: f64, more: &str) -> String {
    let (sin, cos) = (0.5 * factor).atan().sin_cos();
    let block = "rectangle = { from = [0, 0], to = [4, 1], cells = [8, 2] }";
    let gravity = format!("body_force = [{}, {}]\n", 10.0 * sin, -10.0 * cos);
    let plane = "obstacle = { plane = { point = [0, 0], normal = [0, 1] } }\nfriction = 0.5";
    [
        HEAD.to_string(),
        steel("block", block, "", ""),
        gravity,
        format!("[[contact]]\nname = \"slope\"\nnonmortar = \"block.bottom\"\n{plane}\n"),
        probe("along", "slope.resultant.x", ""),
        more.to_string(),
    ]
    .concat()
}

#[test]
fn a_block_rests_on_a_slope_up_to_the_angle_of_friction() {
    let run = Run::solved("rests", &slope(1.0 - 1e-6, ""));
    let weight = 4.0 * 10.0;
    assert_near(run.probe("along"), -weight * 0.5f64.atan().sin(), 1e-5);
    let states = run.column("status");
    assert!(
        states
            .iter()
            .all(|s| s == "stick" || s == "slip" || s == "open")
    );
    assert!(states.iter().any(|s| s == "slip" || s == "stick"));
    let fields = std::fs::read_to_string(run.folder.join("case-out/block.vtu")).unwrap();
    for array in ["\"shear\"", "\"contact_state\""] {
        assert!(fields.contains(array), "no {array}");
    }
    assert_eq!(run.warnings(), Vec::<String>::new());
}

#[test]
fn a_block_that_slides_is_an_answer_with_body_direction_and_load_factor() {
    let (run, message) = Run::unsatisfied("slides", &slope(1.25, ""));
    for word in [
        "loss of equilibrium",
        "\"block\" slides",
        "along x",
        "0.8 of the load",
    ] {
        assert!(message.contains(word), "no {word} in {message}");
    }
    assert_eq!(run.files(), ["summary.json"]);
    assert_eq!(run.summary()["converged"], false);
    // over load steps: half of the second step
    let steps = "[[step]]\ntime = 1\n[[step]]\ntime = 3\n";
    let text = slope(0.75, steps);
    let (sin, cos) = (0.5f64 * 0.75).atan().sin_cos();
    let turned = format!("body_force = [\"{} * t\", {}]", 10.0 * sin, -10.0 * cos);
    let plain = format!("body_force = [{}, {}]", 10.0 * sin, -10.0 * cos);
    let (_, message) = Run::unsatisfied("slides_later", &text.replace(&plain, &turned));
    // 0.75 t reaches 1 at t = 4/3: a sixth of the way from 1 to 3
    for word in [
        "step 2 of 2",
        "0.166667 of the change of load",
        "t = 1.33333",
    ] {
        assert!(message.contains(word), "no {word} in {message}");
    }
}

/// A tied cap on a block that friction holds on a held one, pushed in the second of two steps.
fn cap_on_block() -> String {
    let cap = "rectangle = { from = [0, 2], to = [1, 2.5], cells = [3, 2] }";
    let load = "{ side = \"top\", traction = [\"Q * (t - 1)\", -2e6] }";
    [
        HEAD.to_string(),
        "[parameters]\nQ = 3e5\n".to_string(),
        steel("low", LOW, HELD, ""),
        steel("up", UP, "", ""),
        steel("cap", cap, "", load),
        contact("sole", "up.bottom", "low.top", "friction = 0.4"),
        contact("glue", "cap.bottom", "up.top", "tied = true"),
        steps(&[1.0, 2.0]),
    ]
    .concat()
}

#[test]
fn an_export_is_the_problem_whose_forces_and_gaps_a_run_has_found() {
    let text = cap_on_block();
    let run = Run::solved("exported", &text);
    let out = run.folder.join("case-out");
    let export = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_dotyk"))
            .args([&["export", "case.toml"], arguments].concat())
            .current_dir(&run.folder)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let said = export(&["--threads", "1"]);
    for word in ["m = 18 contact forces", "9 blocks", "5 coulomb", "4 free"] {
        assert!(said.contains(word), "no {word} in {said}");
    }
    let archive = Archive::read(&out.join("dual.npz"));
    let matrix = |name: &str| match name {
        "F" | "G" | "B" => archive.matrix(name),
        vector => {
            let entries = archive.numbers(vector);
            arrays::Matrix {
                rows: entries.len(),
                columns: 1,
                entries,
            }
        }
    };
    let names = ["F", "G", "B", "d", "e", "g0", "lambda", "alpha", "gap"];
    for name in names {
        let text = market(&out.join(format!("{name}.mtx")));
        assert_eq!(
            text,
            matrix(name),
            "{name}: both formats hold the same bits"
        );
    }
    let [f, g, b] = ["F", "G", "B"].map(matrix);
    let [d, e, g0, lambda, alpha, gap] =
        ["d", "e", "g0", "lambda", "alpha", "gap"].map(|name| matrix(name).entries);
    assert_eq!((f.rows, f.columns, g.columns), (18, 18, 18));

    // gap = F lambda − d − G' alpha, and the balance of what floats
    let (product, rigid) = (f.times(&lambda), g.transposed().times(&alpha));
    let length = d.iter().fold(0.0, |s: f64, d| s.max(d.abs()));
    for i in 0..18 {
        let expected = product[i] - d[i] - rigid[i];
        assert!((gap[i] - expected).abs() < 1e-12 * length, "row {i}");
    }
    let force = lambda.iter().fold(0.0, |s: f64, l| s.max(l.abs()));
    for (carried, load) in g.times(&lambda).iter().zip(&e) {
        assert!((carried - load).abs() < 1e-9 * force, "{carried} {load}");
    }

    // what contact.csv says of the last step, row by row
    let last: Vec<usize> = {
        let steps = run.column("step");
        (0..steps.len()).filter(|&k| steps[k] == "2").collect()
    };
    let column = |name: &str| -> Vec<f64> {
        let all = run.column(name);
        last.iter().map(|&k| all[k].parse().unwrap()).collect()
    };
    let [gaps, pressures, shears, weights] = ["gap", "pressure", "shear", "weight"].map(column);
    let rows = std::fs::read_to_string(out.join("rows.csv")).unwrap();
    let rows: Vec<Vec<&str>> = rows
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect())
        .collect();
    assert_eq!((rows.len(), last.len()), (18, 9));
    let nodes = run.column("node");
    for (i, row) in rows.iter().enumerate() {
        let (block, component) = (row[1].parse::<usize>().unwrap(), row[5]);
        assert_eq!(row[0], i.to_string());
        assert_eq!(row[4], nodes[last[block]], "row {i}");
        let per_area = lambda[i] / weights[block];
        let [along, across]: [f64; 2] = [8, 9].map(|k| row[k].parse().unwrap());
        let expected = match component {
            "normal" => pressures[block],
            // shear is ON the nonmortar body and along the normal turned by +90°: here the x axis
            _ => -shears[block] * along,
        };
        assert!(
            (per_area - expected).abs() < 1e-9 * 2e6,
            "row {i}: {per_area} {expected}"
        );
        if component == "normal" {
            assert!((gap[i] - gaps[block]).abs() < 1e-9 * length, "row {i}");
            assert!(along.abs() < 1e-15 && across == -1.0);
        }
    }
    assert_eq!(archive.numbers("weight").len(), 18);

    // blocks: the friction of the sole, then the tie
    let laws = archive.words("block_law");
    assert_eq!(laws[..5], ["coulomb"; 5]);
    assert_eq!(laws[5..], ["free"; 4]);
    assert_eq!(archive.counts("block_size").iter().sum::<usize>(), 18);
    let table = market(&out.join("blocks.mtx"));
    for block in 0..9 {
        let own: [f64; 4] = std::array::from_fn(|k| table.at(block, k));
        let expected = match block < 5 {
            true => [3.0, 2.0, 0.0, 0.4],
            false => [1.0, own[1], 0.0, 0.0],
        };
        assert_eq!(own, expected);
    }

    // B: what slipped in the first step is in g0, and the bodies feel −B' lambda
    assert_eq!(b.rows, 18);
    let push = b.transposed().times(&lambda);
    let dofs = [0, 2 * 25, 2 * 50, 2 * 62];
    assert_eq!(b.columns, dofs[3]);
    let vertical = |body: usize| -> f64 {
        (dofs[body]..dofs[body + 1])
            .skip(1)
            .step_by(2)
            .map(|j| -push[j])
            .sum()
    };
    assert_near(vertical(0), -2e6, 1e-9);
    assert_near(vertical(2), 2e6, 1e-9);
    assert!(vertical(1).abs() < 1e-3);
    assert!(
        g0.iter().any(|g| *g != 0.0),
        "the first step has slipped or strained"
    );

    // the first step by itself, with another push
    export(&["--time", "1", "--set", "Q=1", "--out", "first"]);
    let first = Archive::read(&run.folder.join("first/dual.npz"));
    assert_eq!(first.numbers("g0"), [0.0; 18]);
    assert_eq!(first.matrix("F"), f);
    let text = std::fs::read_to_string(out.join("dual.txt")).unwrap();
    for line in [
        "0 to 49: low",
        "50 to 99: up",
        "100 to 123: cap",
        "at t = 2.0",
    ] {
        assert!(text.contains(line), "no {line} in {text}");
    }
}

/// A cube on a cube, one cell each.
const CUBES: &str = r#"
analysis = "3d"
[[body]]
name = "low"
mesh = { box = { from = [0, 0, 0], to = [1, 1, 1], cells = [1, 1, 1] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0, z = 0 }]
[[body]]
name = "up"
mesh = { box = { from = [0, 0, 1], to = [1, 1, 2], cells = [1, 1, 1] } }
material = { young = 1000, poisson = 0.3 }
fix = [{ side = ["left", "right"], x = 0 }, { side = ["front", "back"], y = 0 }]
load = [{ side = "top", pressure = 1 }]
[[contact]]
name = "sole"
sides = ["up.bottom", "low.top"]
"#;

#[test]
fn an_export_in_space_counts_three_columns_for_a_node() {
    let run = Run::new("export_space", CUBES, "export", &["--out", "dual"]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    let text = std::fs::read_to_string(run.folder.join("dual/dual.txt")).unwrap();
    assert!(text.contains("(column first + 3 node\n"), "{text}");
    assert!(text.contains("24 to 47: up"), "{text}");
}

#[test]
fn a_problem_without_an_answer_is_exported_all_the_same() {
    let run = Run::new("export_rests", &slope(0.5, ""), "export", &[]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    assert!(run.files().contains(&"lambda.mtx".to_string()));
    std::fs::write(run.folder.join("case.toml"), slope(1.25, "")).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_dotyk"))
        .args(["export", "case.toml"])
        .current_dir(&run.folder)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.contains("without an answer") && told.contains("slides"),
        "{told}"
    );
    let files = run.files();
    for gone in ["lambda.mtx", "alpha.mtx", "gap.mtx"] {
        assert!(
            !files.contains(&gone.to_string()),
            "{gone} is of the other problem"
        );
    }
    let archive = Archive::read(&run.folder.join("case-out/dual.npz"));
    assert!(archive.has("d") && !archive.has("lambda"));
}

#[test]
fn an_export_without_floating_bodies_has_no_files_of_their_balance() {
    let run = Run::new(
        "export_held",
        &stack(1e6, "").replace(SLIDES, "{ side = \"top\", x = 0, y = -1e-6 }"),
        "export",
        &[],
    );
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    let files = run.files();
    assert!(!files.contains(&"G.mtx".to_string()) && !files.contains(&"e.mtx".to_string()));
    let archive = Archive::read(&run.folder.join("case-out/dual.npz"));
    assert_eq!(
        (archive.numbers("G").len(), archive.numbers("e").len()),
        (0, 0)
    );
}

#[test]
fn a_problem_too_large_for_a_file_is_refused() {
    let long = "rectangle = { from = [0, 0], to = [8192, 1], cells = [8192, 1] }";
    let plane = "obstacle = { plane = { point = [0, 0], normal = [0, 1] } }";
    let text = [
        HEAD.to_string(),
        steel(
            "strip",
            long,
            "{ side = \"top\", x = 0 }",
            "{ side = \"top\", pressure = 1 }",
        ),
        format!("[[contact]]\nname = \"floor\"\nnonmortar = \"strip.bottom\"\n{plane}\n"),
    ];
    let run = Run::new("export_too_large", &text.concat(), "export", &[]);
    assert_eq!(run.status, Some(2), "{}", run.stdout);
    for word in ["8193 contact unknowns", "up to 8192"] {
        assert!(run.stderr.contains(word), "no {word} in {}", run.stderr);
    }
    assert_eq!(run.files(), [""; 0]);
}

/// Runs `dotyk verify` on some folders of another one: its status, standard output and standard error.
fn verify(folder: &Path, cases: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_dotyk"))
        .args(["verify", "--quiet"])
        .args(cases)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[test]
fn what_is_known_to_lie_outside_is_told_with_its_reason_until_it_lies_inside() {
    let pressure = probe("pressure", "sole.pressure", "at = [0.5, 1]");
    let case = Run::solved("known", &(stack(1e6, "") + &pressure));
    let judged = |more: &str| {
        let text = "[[value]]\ncase = \"case.toml\"\nprobe = \"pressure\"\nkind = \"published\"\n";
        std::fs::write(case.folder.join("reference.toml"), text.to_string() + more).unwrap();
        verify(case.folder.parent().unwrap(), &["known"])
    };
    let (inside, outside) = ("band = [5e5, 2e6]\n", "band = [2e6, 4e6]\n");
    let known = "judged = true\nknown = \"a stiffer block\"\n";
    let last = |output: &str| output.lines().last().unwrap().to_string();

    let (status, output, _) = judged(outside);
    assert_eq!(status, Some(1));
    assert!(last(&output).contains("0 within, 1 outside, 0 outside for a known reason"));
    let (status, output, _) = judged(&(outside.to_string() + known));
    assert_eq!(status, Some(0));
    assert!(
        output.contains("OUTSIDE, known: a stiffer block"),
        "{output}"
    );
    assert!(last(&output).contains("0 within, 0 outside, 1 outside for a known reason"));
    let (status, output, message) = judged(&(inside.to_string() + known));
    assert_eq!(status, Some(1));
    assert!(
        message.contains("reference.toml, line 7, column 9"),
        "{message}"
    );
    assert!(last(&output).contains("0 within, 1 outside"), "{output}");
    assert_eq!(judged(inside).0, Some(0));
}

#[test]
fn a_book_has_a_page_for_every_folder_with_pictures_values_and_links() {
    let pressure = probe("pressure", "sole.pressure", "at = [0.5, 1]");
    let case = Run::solved("booked", &(stack(1e6, "") + &pressure));
    let write = |name: &str, text: &str| std::fs::write(case.folder.join(name), text).unwrap();
    let value = "[[value]]\ncase = \"case.toml\"\nprobe = \"pressure\"\nkind = \"analytic\"\nvalue = 1e6\n\
                 tolerance = 0.02\nsource = \"p_0 | by hand\"\n";
    write("reference.toml", value);
    write(
        "README.md",
        "# Two blocks\n\nSee [it](case.toml) and [more](../elsewhere).\n",
    );
    let root = case.folder.parent().unwrap();
    let (status, output, message) = verify(root, &["booked", "--book", "booked/book"]);
    assert_eq!(status, Some(0), "{output}{message}");
    let book = case.folder.join("book");
    let read = |name: &str| std::fs::read_to_string(book.join(name)).unwrap();
    let page = read("booked/index.md");
    let parts = [
        "# Two blocks\n",
        "See [it](case.toml) and more.",
        "![Deformed shape](case_2.svg)",
        "| case.toml | pressure | analytic | 1e6 ± ",
        " | ok | 1 |",
        "1. p\\_0 \\| by hand\n",
        "| limit | | 1.0e-8 |",
        "dotyk verify cases/booked\n",
        "<summary>case.toml</summary>",
    ];
    for part in parts {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert!(read("booked/case_2.svg").starts_with("<svg xmlns"));
    assert_eq!(read("booked/case.toml"), stack(1e6, "") + &pressure);
    let row = "| [Two blocks](booked/index.md) | `booked` | 1 | 1 | 1 | 0 | 0 | 0 |";
    assert!(read("index.md").contains(row));

    std::fs::write(case.folder.join("file"), "").unwrap();
    let (status, _, message) = verify(root, &["booked", "--book", "booked/file"]);
    assert_eq!(status, Some(2));
    assert!(
        message.contains("choose another folder with --book"),
        "{message}"
    );
}

/// Number of summaries in the folders of a folder, none of which has what the schema does not allow.
fn summaries_as_the_schema_says(folder: &Path) -> usize {
    let schema = Schema::read();
    let inside = |path: &Path| {
        let entries = std::fs::read_dir(path).unwrap();
        entries.map(|entry| entry.unwrap().path())
    };
    let files: Vec<PathBuf> = inside(folder).flat_map(|path| inside(&path)).collect();
    for file in &files {
        let text = std::fs::read_to_string(file).unwrap();
        let faults = schema.faults(&serde_json::from_str(&text).unwrap());
        assert_eq!(faults, [""; 0], "{}", file.display());
    }
    files.len()
}

#[test]
fn the_schema_knows_what_is_wrong_with_a_summary() {
    let summary = Run::solved("schema", &stack(1e6, "")).summary();
    let schema = Schema::read();
    let faults_with = |place: &str, value: Option<Value>| {
        let mut summary = summary.clone();
        let (parent, key) = place.rsplit_once('/').unwrap();
        let parent = summary.pointer_mut(parent).unwrap();
        let parent = parent.as_object_mut().unwrap();
        match value {
            Some(value) => parent.insert(key.to_string(), value),
            None => parent.remove(key),
        };
        schema.faults(&summary).len()
    };
    let faults = [
        ("/schema", Some(Value::from(2))),
        ("/schema", None),
        ("/further", Some(Value::from(1))),
        ("/iterations", Some(Value::from(1.5))),
        ("/converged", Some(Value::Null)),
        ("/bodies/0/reaction", Some(Value::from(vec![1.0]))),
        ("/bodies/0/rigid/rotation", Some(Value::from("x"))),
        ("/bodies/0/max_utilisation", Some(Value::from(1.0))),
        ("/contacts/0/closed", Some(Value::from(-1))),
        ("/certificate/tension/limit", Some(Value::Null)),
    ];
    for (place, value) in faults {
        assert_eq!(faults_with(place, value), 1, "{place}");
    }
    let undefined = faults_with("/certificate/tension/relative", Some(Value::Null));
    assert_eq!(undefined, 0);
}

/// What the page of the reference on files says of a file or an object, under a heading of its own.
fn told_of(title: &str) -> String {
    let page = std::fs::read_to_string(schema::reference().join("files.md")).unwrap();
    let head = format!("\n### {title}\n");
    let begin = page.find(&head);
    let begin = begin.unwrap_or_else(|| panic!("files.md has no heading `{title}`"));
    let text = &page[begin + head.len()..];
    text[..text.find("\n##").unwrap_or(text.len())].to_string()
}

#[test]
fn every_key_of_a_summary_is_told_in_the_reference() {
    let schema = Schema::read();
    let keys = schema.keys();
    assert!(keys.len() > 100);
    let silent = keys.iter().filter(|(object, key)| {
        // those of a step are those of the whole
        let object = if *object == "step" { "summary" } else { object };
        !told_of(&object.replace('_', " ")).contains(&format!("`{key}`"))
    });
    assert_eq!(silent.collect::<Vec<_>>(), [&("", ""); 0]);
}

#[test]
fn every_column_of_a_table_is_told_in_the_reference() {
    let more = "[[section]]\nname = \"cut\"\nbody = \"up\"\nsides = [\"left\", \"right\"]\nstations = 2\n\
         capacity = { compression = 30e6, tension = 3e6 }\n";
    let bar = |ends: [&str; 2]| {
        format!(
            "[[bar]]\nname = \"bolt\"\nfrom = {0}\nto = {1}\nbodies = [\"low\", \"up\"]\nyoung = 1e9\narea = 1e-3\n\
             [[spring]]\nname = \"buffer\"\nfrom = {0}\nto = {1}\nbodies = [\"low\", \"up\"]\nstiffness = 1e6\n",
            ends[0], ends[1]
        )
    };
    let plane = stack(1e6, "friction = 0.3")
        + more
        + &bar(["[0.3, 0.6]", "[0.3, 1.6]"])
        + &probe("line", "up.stress.yy", "along = \"up.bottom\"");
    let round = stack(1e6, "friction = 0.3").replace("plane-strain", "axisymmetric") + more;
    let space = "box = { from = [0, 0, 0], to = [1, 1, 1], cells = [2, 2, 2] }";
    let above = "box = { from = [0, 0, 1], to = [1, 1, 2], cells = [2, 2, 2] }";
    let space = [
        "analysis = \"3d\"\n".to_string(),
        steel(
            "low",
            space,
            "{ side = \"bottom\", x = 0, y = 0, z = 0 }",
            "",
        ),
        steel(
            "up",
            above,
            "{ side = \"left\", x = 0 }, { side = \"front\", y = 0 }",
            "{ side = \"top\", pressure = 1e6 }",
        ),
        contact("sole", "up.bottom", "low.top", "friction = 0.3"),
        bar(["[0.3, 0.3, 0.6]", "[0.3, 0.3, 1.6]"]),
        probe(
            "line",
            "up.stress.zz",
            "along = { from = [0.5, 0.5, 1.2], to = [0.5, 0.5, 1.8], points = 3 }",
        ),
    ]
    .concat();
    let cases = [
        (
            "columns_plane",
            &plane,
            "run",
            &[
                "contact.csv",
                "sections.csv",
                "lines.csv",
                "bars.csv",
                "springs.csv",
            ][..],
        ),
        ("columns_round", &round, "run", &["sections.csv"]),
        (
            "columns_space",
            &space,
            "run",
            &["contact.csv", "lines.csv", "bars.csv", "springs.csv"],
        ),
        ("columns_export", &space, "export", &["rows.csv"]),
        (
            "columns_compare",
            &stack(1e6, ""),
            "compare",
            &["compare.csv"],
        ),
    ];
    for (name, text, command, files) in cases {
        let run = Run::new(name, text, command, &["--out", "case-out"]);
        assert_eq!(run.status, Some(0), "{name}: {}", run.stderr);
        for file in files {
            let table = std::fs::read_to_string(run.folder.join("case-out").join(file)).unwrap();
            let told = told_of(file);
            for column in table.lines().next().unwrap().split(',') {
                assert!(told.contains(&format!("`{column}`")), "{file}: {column}");
            }
        }
    }
}

#[test]
fn nothing_of_a_case_leaves_its_place_in_the_book() {
    let obey = "]</details> ```{raw} html <script>{eval}`1`</script>";
    let text = format!(
        "title = '{obey}'\n# ````\n# {obey}\n{}{}",
        stack(1e6, ""),
        probe(obey, "sole.pressure", "at = [0.5, 1]")
    );
    let case = Run::solved("strange", &text);
    let write = |name: &str, text: &str| std::fs::write(case.folder.join(name), text).unwrap();
    let value = format!(
        "[[value]]\ncase = \"case.toml\"\nprobe = '{obey}'\nkind = \"analytic\"\nvalue = 1e6\ntolerance = 0.02\n\
         source = ':::{obey}'\nreason = '{obey}'\n"
    );
    write("reference.toml", &value);
    write("README.md", &format!("# {obey}\n\nText.\n{obey}\n"));
    let root = case.folder.parent().unwrap();
    let (status, output, message) = verify(root, &["strange", "--book", "strange/book"]);
    assert_eq!(status, Some(0), "{output}{message}");
    let book = case.folder.join("book");
    let page = std::fs::read_to_string(book.join("strange/index.md")).unwrap();
    let (before, code) = page.split_once("`````toml\n").unwrap();
    assert_eq!(code, format!("{}\n`````\n\n</details>\n", text.trim_end()));
    let index = std::fs::read_to_string(book.join("index.md")).unwrap();
    // what stands behind a backslash is a character like others
    let obeyed = |page: &str| -> String {
        let mut out = String::new();
        let mut characters = page.chars();
        while let Some(c) = characters.next() {
            match c {
                '\\' => drop(characters.next()),
                c => out.push(c),
            }
        }
        out
    };
    for page in [obeyed(before), obeyed(&index)] {
        for place in ["<script", "]</details>", "`{raw", "{eval}`", "\n1. :::"] {
            assert!(!page.contains(place), "{place}: {page}");
        }
    }
    std::fs::rename(
        case.folder.join("case.toml"),
        case.folder.join("a <b>.toml"),
    )
    .unwrap();
    write("reference.toml", &value.replace("case.toml", "a <b>.toml"));
    let (status, _, message) = verify(root, &["strange", "--book", "strange/book"]);
    assert_eq!(status, Some(2));
    assert!(message.contains("rename it"), "{message}");
}

#[test]
fn every_case_is_certified_and_within_its_bands() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // the pages of the book are made of the same runs, and summaries for whoever holds them against the schema
    let folder = |name: &str| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_dir_all(&folder);
        folder
    };
    let (book, summaries) = (folder("verification"), folder("summaries"));
    let options = [("--book", &book), ("--summaries", &summaries)];
    let options = options.map(|(option, folder)| [option, folder.to_str().unwrap()]);
    let (status, output, message) = verify(&root, options.as_flattened());
    assert_eq!(status, Some(0), "{output}{message}");
    assert!(book.join("index.md").exists());
    let certified = output.matches(": certified, ").count();
    assert_eq!(summaries_as_the_schema_says(&summaries), certified);
    // an empty folder would pass as well
    let judged = output.matches("  ok\n").count();
    assert!(judged > 1000, "only {judged} values are judged");
}

#[test]
fn a_run_goes_on_behind_the_steps_of_another() {
    let text = |times: &[f64]| {
        stack(1e6, "friction = 0.3").replacen(
            "pressure = 1e6",
            "traction = [\"1e5 * t\", \"-1e6 * t\"]",
            1,
        ) + &probe("force", "sole.resultant.y", "")
            + &steps(times)
    };
    let begun = Run::solved("begun", &text(&[0.5, 1.0]));
    let from = begun.folder.join("case-out");
    let from = from.to_str().unwrap();
    let on = Run::new("gone_on", &text(&[0.5, 1.0, 1.5]), "run", &["--from", from]);
    assert_eq!(on.status, Some(0), "{}", on.stderr);
    let whole = Run::solved("whole", &text(&[0.5, 1.0, 1.5]));
    assert_eq!(on.files(), whole.files());
    let [on_summary, whole_summary] = [&on, &whole].map(Run::summary);
    for step in 0..3 {
        let force = |summary: &Value| {
            summary["steps"][step]["probes"][0]["value"]
                .as_f64()
                .unwrap()
        };
        assert_near(force(&on_summary), force(&whole_summary), 1e-10);
        assert_near(force(&on_summary), 1e6 * [0.5, 1.0, 1.5][step], 1e-10);
    }
    // what was done must be of this case, and something must be left
    for (name, times, words) in [
        (
            "other_steps",
            &[0.5, 1.1, 1.5][..],
            "step 2 of the run before is not one of this model",
        ),
        (
            "no_step_left",
            &[0.5, 1.0],
            "all 2 steps were solved before",
        ),
    ] {
        let refused = Run::new(name, &text(times), "run", &["--from", from]);
        assert_eq!(refused.status, Some(2), "{}", refused.stderr);
        assert!(refused.stderr.contains(words), "{}", refused.stderr);
        assert_eq!(refused.files(), [""; 0]);
    }
    let nowhere = Run::new(
        "from_nowhere",
        &text(&[0.5, 1.0]),
        "run",
        &["--from", "nowhere"],
    );
    assert_eq!(nowhere.status, Some(2));
    assert!(
        nowhere
            .stderr
            .contains("nowhere/summary.json: cannot be read"),
        "{}",
        nowhere.stderr
    );
}

/// A plate that one point holds and another pulls, a quarter of its height above its middle.
const COUPLED: &str = r#"analysis = "plane-stress"
[[body]]
name = "plate"
mesh = { rectangle = { from = [0, 0], to = [8, 2], cells = [8, 2], cell = "quad8" } }
material = { young = 1e6, poisson = 0.3 }
points = { lug = [10, 1.5], foot = [0, 1] }
couple = [{ side = "right", point = "lug", kind = "average" }, { side = "left", point = "foot", kind = "rigid" }]
fix = [{ point = "foot", x = 0, y = 0, rotation = 0 }]
load = [{ point = "lug", force = [8, 0] }, { point = "lug", force = ["2*t", 0], moment = 3 }]
[[probe]]
name = "lug"
quantity = "plate.displacement.x"
at = "plate.lug"
[[probe]]
name = "held"
quantity = "plate.reaction.x"
"#;

#[test]
fn points_of_couples_hold_and_pull() {
    let run = Run::solved("couples", COUPLED);
    assert!(run.stdout.contains("plate.lug") && run.stdout.contains("plate.foot"));
    let summary = run.summary();
    let couples = summary["bodies"][0]["couples"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let [lug, foot] = [&couples[0], &couples[1]];
    assert_eq!([&lug["point"], &lug["kind"]], ["lug", "average"]);
    assert_eq!([&foot["point"], &foot["kind"]], ["foot", "rigid"]);
    assert!((number(&lug["force"][0]) - 10.0).abs() < 1e-9);
    assert!((number(&lug["moment"]) - 3.0).abs() < 1e-9);
    // about the foot: the force 10 passes 0.5 above it, and turns the other way
    assert!((number(&foot["force"][0]) + 10.0).abs() < 1e-9);
    assert!((number(&foot["moment"]) - (10.0 * 0.5 - 3.0)).abs() < 1e-8);
    assert_eq!(foot["displacement"], serde_json::json!([0.0, 0.0]));
    let probes = summary["probes"].as_array().unwrap();
    assert_eq!(probes[0]["value"], lug["displacement"][0]);
    assert!((number(&probes[1]["value"]) + 10.0).abs() < 1e-9);
    let report = std::fs::read_to_string(run.folder.join("case-out/report.html")).unwrap();
    assert!(report.contains("Coupled points") && report.contains("mean motion of plate.right"));
    // what is not coupled says nothing of it
    let plain = COUPLED
        .lines()
        .filter(|line| !line.contains("lug") && !line.contains("foot"));
    let plain: Vec<&str> = plain.collect();
    let plain = plain.join("\n").replace(
        "material",
        "fix = [{ side = \"left\", x = 0, y = 0 }]\nmaterial",
    );
    let plain = plain.replace("[[probe]]\nquantity = \"plate.displacement.x\"\n", "");
    let plain = Run::solved("no_couples", &plain);
    assert_eq!(plain.summary()["bodies"][0]["couples"], Value::Null);
}

#[test]
fn problems_with_couples_are_exported() {
    let run = Run::new("couples_exported", COUPLED, "export", &["--out", "dual"]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    let rows = std::fs::read_to_string(run.folder.join("dual/rows.csv")).unwrap();
    let of = |name: &str| rows.lines().filter(|line| line.contains(name)).count();
    // five nodes of a quadratic side, and the three motions of a point
    assert_eq!([of("plate.foot"), of("plate.lug")], [10, 3]);
    assert_eq!(of(",couple,"), 13);
}

/// A plate on a block, and a member "bolt" through both, exported: the rows of the member.
fn exported(name: &str, member: &str) -> Vec<Vec<String>> {
    let case = format!(
        r#"
analysis = "plane-strain"
[[body]]
name = "block"
mesh = {{ rectangle = {{ from = [0, 0], to = [2, 1], cells = [8, 4] }} }}
material = {{ young = 1000, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "plate"
mesh = {{ rectangle = {{ from = [0, 1], to = [2, 2], cells = [8, 4] }} }}
material = {{ young = 1000, poisson = 0.3 }}
load = [{{ side = "top", traction = [0, -1] }}]
fix = [{{ side = "left", x = 0 }}]
[[contact]]
name = "joint"
sides = ["plate.bottom", "block.top"]
{member}
name = "bolt"
bodies = ["plate", "block"]
"#
    );
    let run = Run::new(name, &case, "export", &["--out", "dual"]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    let rows = std::fs::read_to_string(run.folder.join("dual/rows.csv")).unwrap();
    let bolts = rows.lines().filter(|line| line.contains(",bolt,"));
    bolts
        .map(|line| line.split(',').map(str::to_string).collect())
        .collect()
}

const BAR: &str = "[[bar]]\nyoung = 1e5\narea = 0.01\n";

#[test]
fn springs_between_places_are_exported_as_such() {
    // λ > 0 is tension from the beginning to the end, of one that presses alone compression and the other way round
    for (acts, law, along) in [
        ("both", "free", -1.0),
        ("tension", "unilateral", -1.0),
        ("compression", "unilateral", 1.0),
    ] {
        let spring = format!(
            "[[spring]]\nstiffness = 1000\nfrom = [1.5, 1.75]\nto = [1.5, 0.25]\nacts = \"{acts}\""
        );
        let rows = exported(&format!("exported_spring_{acts}"), &spring);
        let [row] = &rows[..] else {
            panic!("one row for one element: {rows:?}");
        };
        assert_eq!([&row[2][..], &row[5][..]], [law, "spring between"]);
        let found: [f64; 4] = [6, 7, 8, 9].map(|k| row[k].parse().unwrap());
        assert_eq!(found, [1.5, 1.0, 0.0, along], "{row:?}");
    }
}

#[test]
fn bars_are_exported_along_themselves_and_where_they_are() {
    let upright = "from = [1.5, 1.75]\nto = [1.5, 0.25]";
    let oblique = "from = [1.5, 1.75]\nto = [0.5, 0.25]";
    let laws = [
        ("elastic", "", "free"),
        ("slack", "tension_only = true", "unilateral"),
        ("yields", "yield = 1e4", "interval"),
        ("both", "yield = 1e4\ntension_only = true", "interval"),
    ];
    for (name, key, law) in laws {
        for (way, ends, middle) in [("up", upright, [1.5, 1.0]), ("askew", oblique, [1.0, 1.0])] {
            let rows = exported(
                &format!("exported_bar_{name}_{way}"),
                &format!("{BAR}{ends}\n{key}"),
            );
            let [row] = &rows[..] else {
                panic!("one row for one element: {rows:?}");
            };
            assert_eq!([&row[2][..], &row[5][..]], [law, "bar"]);
            let [x, y, along, across]: [f64; 4] = [6, 7, 8, 9].map(|k| row[k].parse().unwrap());
            let [from, to] = match way {
                "up" => [[1.5, 1.75], [1.5, 0.25]],
                _ => [[1.5, 1.75], [0.5, 0.25]],
            };
            let length = f64::hypot(to[0] - from[0], to[1] - from[1]);
            let expected = [
                middle[0],
                middle[1],
                (to[0] - from[0]) / length,
                (to[1] - from[1]) / length,
            ];
            for (found, expected) in [x, y, along, across].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{row:?}");
            }
        }
    }
    // a grouted one has a row for each element, in their order
    let rows = exported(
        "exported_bar_grouted",
        &format!("{BAR}{upright}\nbond = \"grouted\""),
    );
    assert!(rows.len() >= 8);
    let heights: Vec<f64> = rows.iter().map(|row| row[7].parse().unwrap()).collect();
    assert!(
        heights.windows(2).all(|pair| pair[0] > pair[1]),
        "{heights:?}"
    );
}

#[test]
fn check_tells_what_points_hold() {
    let run = Run::new("couples_checked", COUPLED, "check", &[]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    let said = [
        "point \"lug\" at (10, 1.5): average couple of side \"right\", nothing held, force (10, 0)",
        "point \"foot\" at (0, 1): rigid couple of side \"left\", held: displacement along x, displacement along y, rotation",
        "held by couple \"plate.lug\", \"plate.foot\"",
    ];
    for words in said {
        assert!(run.stdout.contains(words), "{words}\n{}", run.stdout);
    }
}

/// Bodies whose stresses differ by much have a colour range each: more of them than a small figure is tall.
#[test]
fn bodies_of_many_colour_ranges_are_drawn_over_steps() {
    let body = |k: i32| {
        let (at, stiff) = (2 * k, 10f64.powi(2 * k));
        format!(
            "[[body]]\nname = \"b{k}\"\n\
             mesh = {{ rectangle = {{ from = [{at}, 0], to = [{}, 1], cells = [2, 2] }} }}\n\
             material = {{ young = {stiff:?}, poisson = 0.3 }}\n\
             fix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n\
             load = [{{ side = \"top\", traction = [0, \"{:?}*t\"] }}]\n",
            at + 1,
            -1e-4 * stiff
        )
    };
    let bodies: String = (0..6).map(body).collect();
    let text =
        format!("analysis = \"plane-strain\"\nstep = [{{ time = 1 }}, {{ time = 2 }}]\n{bodies}");
    let run = Run::solved("colour_ranges", &text);
    assert!(run.folder.join("case-out/report.html").exists());
}
