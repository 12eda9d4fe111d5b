//! Decks of Abaqus and CalculiX through the commands: answers, files, messages with their line, exit status.
//!
//! `decks/*.dat` are what CalculiX 2.20 printed for the deck beside it, with elements that both programs have alike.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn dotyk(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dotyk"));
    command.current_dir(folder).args(arguments);
    command.output().expect("dotyk runs")
}

fn folder_of(name: &str) -> PathBuf {
    let of_all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("decks");
    of_all.join(name)
}

/// A folder of its own for a test, with decks of this folder.
fn folder(name: &str, decks: &[&str]) -> PathBuf {
    let path = folder_of(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    for deck in decks {
        std::fs::copy(own(deck), path.join(deck)).unwrap();
    }
    path
}

fn own(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/decks")
        .join(file)
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The tables of a `.dat`: heading, and rows of numbers.
fn tables(text: &str) -> Vec<(String, Vec<Vec<f64>>)> {
    let mut tables: Vec<(String, Vec<Vec<f64>>)> = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let row: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match (row, tables.last_mut()) {
            (Ok(row), Some(table)) => table.1.push(row),
            _ => tables.push((line.trim().to_string(), Vec::new())),
        }
    }
    tables
}

#[test]
fn answers_are_those_of_calculix_where_elements_are_the_same() {
    // with C3D8I incompatible modes differ a little on warped cells, plane stress is a thin solid there
    let within = [
        ("beam20", 1e-6),
        ("beam8", 2e-3),
        ("plate8", 1e-2),
        ("strain8", 1e-6),
        ("ring8", 2e-4),
        ("bolt8", 1e-5),
        ("sector4", 1e-6),
    ];
    for (name, tolerance) in within {
        let deck = format!("{name}.inp");
        let folder = folder(name, &[&deck]);
        let run = dotyk(&folder, &["run", &deck, "--out", "out", "--quiet"]);
        assert!(run.status.success(), "{name}: {}", told(&run));
        let dat = format!("{name}.dat");
        let found = tables(&std::fs::read_to_string(folder.join("out").join(&dat)).unwrap());
        let wanted = tables(&std::fs::read_to_string(own(&dat)).unwrap());
        let heads = |tables: &[(String, Vec<Vec<f64>>)]| {
            tables.iter().map(|t| t.0.clone()).collect::<Vec<_>>()
        };
        assert_eq!(heads(&found), heads(&wanted), "{name}");
        for ((head, found), (_, wanted)) in found.iter().zip(&wanted) {
            assert_eq!(found.len(), wanted.len(), "{name}: {head}");
            // numbers of nodes and elements come first, and points of integration
            let skip = match head {
                head if head.starts_with("total") => 0,
                head if head.contains("integ.pnt.") => 2,
                _ => 1,
            };
            let values = wanted.iter().flat_map(|row| &row[skip..]);
            let size = values.fold(0.0f64, |s, v| s.max(v.abs()));
            for (found, wanted) in found.iter().zip(wanted) {
                assert_eq!(found[..skip], wanted[..skip], "{name}: {head}");
                for (a, b) in found[skip..].iter().zip(&wanted[skip..]) {
                    assert!(
                        (a - b).abs() <= tolerance * size,
                        "{name}: {head}: {found:?} {wanted:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn two_cubes_pressed_on_each_other_are_shortened_by_pl_over_e() {
    let folder = folder("press", &["press.inp"]);
    let run = dotyk(&folder, &["run", "press.inp", "--out", "out", "--quiet"]);
    assert!(run.status.success(), "{}", told(&run));
    let dat = std::fs::read_to_string(folder.join("out/press.dat")).unwrap();
    let tables = tables(&dat);
    let displacements = &tables[0].1;
    for row in displacements {
        let z = [0.0, -0.01, -0.02][match row[0] as usize {
            1..=4 => 0,
            5..=14 => 1,
            _ => 2,
        }];
        assert!((row[3] - z).abs() < 1e-9 && row[1].abs() < 1e-9, "{row:?}");
    }
    let totals = tables
        .iter()
        .find(|t| t.0.starts_with("total force"))
        .unwrap();
    assert!((totals.1[0][2] - 10.0).abs() < 1e-6, "{totals:?}");
    let frd = std::fs::read_to_string(folder.join("out/press.frd")).unwrap();
    for block in ["DISP", "STRESS", "TOSTRAIN", "FORC", "CONTACT"] {
        assert!(frd.contains(&format!(" -4  {block}")), "{block}");
    }
    assert!(frd.starts_with("    1C") && frd.contains("    1UHash: abc, two cubes"));
    assert!(frd.trim_end().ends_with("9999"));
    let summary = std::fs::read_to_string(folder.join("out/summary.json")).unwrap();
    assert!(summary.contains("\"converged\": true") && summary.contains("Upper-Lower"));
    assert!(
        summary.contains("press.inp:42: *FRICTION: the slope of sticking is passed over"),
        "{summary}"
    );
}

#[test]
fn the_imported_case_says_the_same() {
    for deck in ["press", "beam20", "beam8", "plate8"] {
        let file = format!("{deck}.inp");
        let folder = folder(&format!("import-{deck}"), &[&file]);
        let import = dotyk(&folder, &["import", &file, "--out", "case"]);
        assert!(import.status.success(), "{}", told(&import));
        let mut files: Vec<String> = std::fs::read_dir(folder.join("case"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        assert_eq!(files, [format!("{deck}.msh"), format!("{deck}.toml")]);
        let case = format!("case/{deck}.toml");
        let of_case = dotyk(&folder, &["run", &case, "--out", "of-case", "--quiet"]);
        assert!(of_case.status.success(), "{}", told(&of_case));
        let of_deck = dotyk(&folder, &["run", &file, "--out", "of-deck", "--quiet"]);
        assert!(of_deck.status.success(), "{}", told(&of_deck));
        let vtu = |run: &str| -> BTreeMap<String, Vec<u8>> {
            let files = std::fs::read_dir(folder.join(run)).unwrap();
            let files = files.map(|entry| entry.unwrap().path());
            let files = files.filter(|path| path.extension().is_some_and(|e| e == "vtu"));
            files
                .map(|path| {
                    (
                        path.file_name().unwrap().to_str().unwrap().to_string(),
                        std::fs::read(path).unwrap(),
                    )
                })
                .collect()
        };
        let (a, b) = (vtu("of-case"), vtu("of-deck"));
        assert!(!a.is_empty() && a == b, "{deck}");
    }
}

#[test]
fn called_as_ccx_is_it_leaves_the_files_of_ccx() {
    let folder = folder("ccx", &["press.inp"]);
    std::fs::write(folder.join("broken.inp"), "*NODE\n1, 0\n*ELEMENT\n").unwrap();
    std::fs::write(folder.join("broken.frd"), "old").unwrap();
    let ccx = |job: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_dotyk-ccx"));
        command
            .current_dir(&folder)
            .args(["-i", job])
            .output()
            .unwrap()
    };
    let done = ccx("press");
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let mut files: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(
        files,
        [
            "broken.frd",
            "broken.inp",
            "press-out",
            "press.dat",
            "press.frd",
            "press.inp",
            "press.sta"
        ]
    );
    assert!(folder.join("press-out/summary.json").exists());
    assert!(!folder.join("press-out/press.frd").exists());
    let broken = ccx("broken");
    assert_eq!(broken.status.code(), Some(1));
    assert!(told(&broken).contains("broken.inp:3"), "{}", told(&broken));
    assert!(
        !folder.join("broken.frd").exists(),
        "an old result is not that of this run"
    );
}

#[test]
fn decks_without_an_answer_end_with_the_status_of_ccx() {
    let text = std::fs::read_to_string(own("press.inp")).unwrap();
    // pushed sideways by more than friction bears
    let push = "*Cload\n15, 1, 0.5\n16, 1, 0.5\n17, 1, 0.5\n18, 1, 0.5\n*Dload\n";
    let text = text
        .replace("0.5, 1e4\n", "0.1\n")
        .replace("*Dload\n", push);
    let output = as_ccx("slides", &text);
    assert_eq!(output.status.code(), Some(201), "{}", told(&output));
}

/// A deck run under the calling convention of ccx.
fn as_ccx(name: &str, deck: &str) -> Output {
    let folder = folder(name, &[]);
    std::fs::write(folder.join(format!("{name}.inp")), deck).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_dotyk-ccx"));
    command.current_dir(&folder);
    command.args(["-i", name]).output().unwrap()
}

#[test]
fn what_moves_far_under_nlgeom_is_no_answer_and_its_files_are_there() {
    // pulled by a strain of 0.01, which is small, and of 0.03
    for (name, force, status) in [("little", 2.5, 0), ("far", 7.5, 201)] {
        let deck = format!(
            "{CUBE}*STEP, NLGEOM\n*STATIC\n*CLOAD\nTop, 3, {force}\n*NODE PRINT, NSET=Top\nU\n*END STEP\n"
        );
        let output = as_ccx(name, &deck);
        assert_eq!(output.status.code(), Some(status), "{}", told(&output));
        let line = deck.lines().count() - 6;
        let named = format!("{name}.inp:{line}: *STEP: NLGEOM");
        assert!(told(&output).contains(&named), "{}", told(&output));
        let path = folder_of(name).join(format!("{name}.dat"));
        let all = tables(&std::fs::read_to_string(path).unwrap());
        near(all[0].1[0][3], force * 4.0 / 1000.0, name);
    }
}

/// A cube of E = 1000 and density 2 that is held at its floor, a set with the name of a parameter below a line that ends with a comma, with the top as a set, a surface and the element `All`.
const CUBE: &str = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, 1\n\
    *ELEMENT, TYPE=C3D8I, ELSET=All\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*NSET, NSET=Fixed\n1, 2, 3, 4\n*NSET, NSET=Top\n5, 6, 7, 8\n\
    *SURFACE, NAME=Roof\nAll, S2\n*MATERIAL, NAME=M\n*ELASTIC\n1000., 0.\n*DENSITY\n2.\n*SOLID SECTION, ELSET=All, MATERIAL=M\n\
    *AMPLITUDE, NAME=Ramp\n0., 0., 4., 1.,,\n*AMPLITUDE, NAME=Total, TIME=TOTAL TIME\n0., 0., 4., 1.\n*BOUNDARY,\nFixed, 1, 3,\n";

/// 1000 times the displacement of the top at the end of each step; what stands before a `|` is the time of a step.
fn lifted(name: &str, steps: &[&str]) -> Vec<f64> {
    let folder = folder(name, &[]);
    let steps = steps.iter().map(|step| {
        let (period, step) = step.split_once('|').unwrap_or(("1.", step));
        format!("*STEP\n*STATIC\n1., {period}\n{step}*NODE PRINT, NSET=Top\nU\n*END STEP\n")
    });
    let text = CUBE.to_string() + &steps.collect::<String>();
    std::fs::write(folder.join("cube.inp"), text).unwrap();
    let run = dotyk(&folder, &["run", "cube.inp", "--out", "out", "--quiet"]);
    assert!(run.status.success(), "{name}: {}", told(&run));
    let dat = std::fs::read_to_string(folder.join("out/cube.dat")).unwrap();
    tables(&dat)
        .iter()
        .map(|(_, rows)| 1e3 * rows[0][3])
        .collect()
}

#[test]
fn loads_and_supports_go_on_from_step_to_step_as_in_calculix() {
    let cases: &[(&str, &[&str], &[f64])] = &[
        // a line that names a load again in the same step adds, in a later step it replaces
        (
            "adds",
            &[
                "*CLOAD\nTop, 3, 1.\nTop, 3, 0.5\n",
                "",
                "*CLOAD\nTop, 3, 2.\n",
            ],
            &[6.0, 6.0, 8.0],
        ),
        (
            "new",
            &[
                "*CLOAD\nTop, 3, 1.\n*DLOAD\nAll, P2, -1.\n",
                "*CLOAD, OP=NEW\nTop, 3, 0.25\n",
            ],
            &[5.0, 2.0],
        ),
        // OP=NEW acts on the first card of its keyword in a step
        (
            "new-twice",
            &[
                "*CLOAD\nTop, 3, 9.\n",
                "*CLOAD, OP=NEW\nTop, 3, 1.\n*CLOAD, OP=NEW\n5, 3, 1.\n6, 3, 1.\n7, 3, 1.\n8, 3, 1.\n",
            ],
            &[36.0, 8.0],
        ),
        (
            "new-behind",
            &[
                "*CLOAD\nTop, 3, 9.\n",
                "*CLOAD\nTop, 3, 1.\n*CLOAD, OP=NEW\nTop, 3, 0.5\n",
            ],
            &[36.0, 6.0],
        ),
        // pressure on a face, by element or by surface
        (
            "pressure",
            &[
                "*DSLOAD\nRoof, P, -2.\n",
                "*DLOAD\nAll, P2, -1.\n",
                "*DLOAD, OP=NEW\n",
            ],
            &[2.0, 1.0, 0.0],
        ),
        // half of the weight stretches: density times acceleration over 2E
        (
            "weight",
            &[
                "*DLOAD\nAll, GRAV, 4., 0., 0., 1.\n1, GRAV, 2., 0., 0., 3.\n",
                "*DLOAD\nAll, GRAV, 1., 0., 0., 1.\n",
            ],
            &[6.0, 1.0],
        ),
        (
            "amplitude",
            &[
                "*CLOAD, AMPLITUDE=Ramp\nTop, 3, 4.\n",
                "",
                "*CLOAD, OP=NEW, AMPLITUDE=Total\nTop, 3, 4.\n",
            ],
            &[4.0, 4.0, 12.0],
        ),
        // an amplitude of a step ends with it, one of total time goes on
        (
            "amplitude-ends",
            &[
                "2.|*CLOAD, AMPLITUDE=Ramp\nTop, 3, 4.\n",
                "4.|",
                "0.5|*CLOAD, OP=NEW, AMPLITUDE=Total\nTop, 3, 4.\n",
            ],
            &[8.0, 8.0, 16.0],
        ),
        (
            "amplitude-goes-on",
            &[
                "*CLOAD, AMPLITUDE=Total\nTop, 3, 4.\n",
                "",
                "*DLOAD\nAll, P2, -1.\n",
            ],
            &[4.0, 8.0, 13.0],
        ),
        // what is held stays where it is
        (
            "fixed",
            &[
                "*BOUNDARY\nTop, 3, 3, 0.01\n",
                "*BOUNDARY, FIXED\nTop, 3, 3\n",
                "*BOUNDARY\nTop, 3, 3, 0.02\n",
            ],
            &[10.0, 10.0, 20.0],
        ),
        (
            "fixed-free",
            &[
                "*CLOAD\nTop, 3, 1.\n",
                "*BOUNDARY, FIXED\nTop, 3, 3\n*CLOAD, OP=NEW\n",
                "",
            ],
            &[4.0, 4.0, 4.0],
        ),
    ];
    for (name, steps, wanted) in cases {
        let found = lifted(name, steps);
        assert_eq!(found.len(), wanted.len(), "{name}: {found:?}");
        for (a, b) in found.iter().zip(*wanted) {
            assert!(
                (a - b).abs() < 1e-5,
                "{name}: {found:?}, and not {wanted:?}"
            );
        }
    }
}

#[test]
fn loads_change_in_hundreds_of_steps() {
    let load = |step: usize| (100.0 * (step as f64).sin()).round() / 100.0;
    let steps: Vec<String> = (0..300)
        .map(|step| format!("*CLOAD, OP=NEW\nTop, 3, {:?}\n", load(step)))
        .collect();
    let steps: Vec<&str> = steps.iter().map(String::as_str).collect();
    for (step, found) in lifted("steps", &steps).into_iter().enumerate() {
        near(found, 4.0 * load(step), &format!("step {}", step + 1));
    }
}

#[test]
fn commands_that_need_a_case_say_how_to_get_one() {
    let folder = folder("no-case", &["press.inp"]);
    for command in [
        &["study", "--vary", "E=1..2:2"][..],
        &["compare"],
        &["export"],
    ] {
        let output = dotyk(&folder, &[command, &["press.inp"]].concat());
        assert_eq!(output.status.code(), Some(2), "{command:?}");
        assert!(
            told(&output).contains("dotyk import"),
            "{command:?}: {}",
            told(&output)
        );
    }
    let output = dotyk(&folder, &["run", "press.inp", "--set", "E=1"]);
    assert!(
        told(&output).contains("a deck has no parameter `E`"),
        "{}",
        told(&output)
    );
    let output = dotyk(&folder, &["import", "press.toml"]);
    assert!(
        told(&output).contains("whose name ends with .inp"),
        "{}",
        told(&output)
    );
}

#[test]
fn spoilt_decks_are_refused_at_a_line_or_solved() {
    let folder = folder("spoilt", &[]);
    let decks = ["press.inp", "beam8.inp", "plate8.inp"]
        .map(|deck| std::fs::read_to_string(own(deck)).unwrap());
    // a generator by itself, so that each run has the same decks
    let mut state = 20_261_128_u64;
    let mut below = |n: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let (mut refused, mut solved) = (0, 0);
    for number in 0..300 {
        let mut lines: Vec<String> = decks[number % 3].lines().map(str::to_string).collect();
        for _ in 0..=below(3) {
            let (at, other) = (below(lines.len()), below(lines.len()));
            match below(6) {
                0 => drop(lines.remove(at)),
                1 => lines.insert(at, lines[other].clone()),
                2 => lines.swap(at, other),
                3 => lines[at].push_str(", 7"),
                4 => lines[at] = lines[at].replacen([',', '1', '='], "-", 1),
                _ => {
                    let half = lines[at]
                        .chars()
                        .take(lines[at].chars().count() / 2)
                        .collect();
                    lines[at] = half;
                }
            }
        }
        std::fs::write(folder.join("spoilt.inp"), lines.join("\n")).unwrap();
        let output = dotyk(&folder, &["check", "spoilt.inp"]);
        let message = told(&output);
        match output.status.code() {
            Some(0) => solved += 1,
            Some(2) => {
                refused += 1;
                assert!(message.contains("spoilt.inp"), "{number}: {message}");
            }
            code => panic!("{number}: {code:?}: {message}"),
        }
        assert!(!message.contains("panicked"), "{number}: {message}");
    }
    assert!(
        refused > 100 && solved > 20,
        "{refused} refused, {solved} solved"
    );
}

/// What is replaced in `press.inp`, by what, text on the line that is told, words of the message.
type Mistake = (&'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const MISTAKES: &[Mistake] = &[
    ("*Static\n", "*Static\n*Dynamic\n", "*Dynamic", "*DYNAMIC: only *STATIC is solved"),
    ("*Material, name=Soft\n", "*Materal, name=Soft\n", "*Materal", "the nearest known one is *MATERIAL"),
    ("*Nset, nset=Floor\n", "*Nset, nset=Floor, colour=red\n", "colour=red", "the parameter COLOUR is not known"),
    ("Floor, 1, 3\n", "Flor, 1, 3\n", "Flor, 1", "there is no NSET `Flor`, the nearest is FLOOR"),
    ("Floor, 1, 3\n", "Floor, 7\n", "Floor, 7", "a degree of freedom from 1 to 6"),
    ("2, 11, 12, 13, 14,", "2, 11, 12, 13, 99,", "2, 11, 12", "there is no node 99"),
    ("2, 11, 12, 13, 14,", "1, 11, 12, 13, 14,", "1, 11, 12", "there are two elements 1"),
    ("1000., 0.\n", "1000., 0.5\n", "1000., 0.5", "ν in (-1, 0.5)"),
    ("1000., 0.\n", "1000., x\n", "1000., x", "expected a number in field 2, found `x`"),
    ("High, P2, 10.", "High, P7, 10.", "High, P7", "has no face 7"),
    ("High, P2, 10.", "High, P2, nan", "High, P2, nan", "expected a number in field 3"),
    ("High, S1\n", "High, S9\n", "High, S9", "has no face 9"),
    ("Upper, Lower\n*B", "Upper, Lowr\n*B", "Upper, Lowr", "there is no surface `Lowr`, the nearest is LOWER"),
    ("interaction=Hard, type", "interaction=Hart, type", "Upper, Lower", "there is no *SURFACE INTERACTION HART"),
    ("type=C3D8I, elset=High", "type=S4, elset=High", "elset=High", "shells and membranes are not supported"),
    ("*Solid section, elset=High, material=Soft\n", "", "2, 11, 12", "element 2 has no *SOLID SECTION"),
    ("*Solid section, elset=High, material=Soft\n", "*Solid section, elset=High, material=Sofd\n", "elset=High, material", "there is no material Sofd"),
    ("*Elastic\n1000., 0.\n", "", "*Material", "material Soft has no *ELASTIC"),
    ("*End step\n", "", "*Step", "the step has no *END STEP"),
    ("0.5, 1e4\n", "-0.5\n", "-0.5", "must not be negative"),
    ("*Step\n", "*Include, input=none.inp\n*Step\n", "*Include", "none.inp"),
    ("*Step\n", "*Include, input=press.inp\n*Step\n", "*Include", "includes itself"),
    ("*Dload\n", "*Cload\nNone, 1, 1.\n*Dload\n", "None, 1", "there is no NSET `None`"),
    ("*Nset, nset=Left, generate\n11, 18, 1\n", "*Nset, nset=Left, generate\n18, 11, 1\n", "18, 11", "the first is the smaller"),
    ("*Nset, nset=Left, generate\n11, 18, 1\n", "*Nset, nset=Left\n*Rigid body, nset=Left, ref node=1\n", "*Rigid body", "is empty"),
    ("*Static\n", "*Static\nHigh, P2, 1.\n", "High, P2, 1.", "expected a number in field 1"),
    ("*Static\n", "", "*Step", "has no *STATIC"),
    ("*Static\n", "*Static, time reset\n", "*Static", "TIME RESET is not supported"),
    ("nset=All\nU", "nset=Oll\nU", "nset=Oll", "there is no NSET `Oll`"),
    ("*Node print, nset=All", "*Node print", "*Node print", "NSET=NAME is missing"),
    ("slave=Upper, master", "slave=Uper, master", "slave=Uper", "there is no surface `UPER`"),
    ("18, 0, 1, 2\n", "18, 0, 1, 2\n99999999999, 0, 0, 0\n", "99999999999", "at most ten digits"),
    ("*Step\n", "*Step, amplitude=smooth\n", "*Step, amplitude", "known are RAMP and STEP"),
    ("*Boundary\n", "*Boundary, fixed, fixed\n", "*Boundary", "FIXED is given twice"),
    ("*Step\n", "*Equation\n2\n11, 1, 1., 12, 1\n*Step\n", "11, 1, 1., 12", "terms are a node"),
    ("*Step\n", "*Equation\n1\n11, 257, 1.\n*Step\n", "11, 257", "a degree of freedom from 1 to 6"),
    ("*Step\n", "*Initial conditions, type=temperature, user\n*Step\n", "*Initial", "USER"),
    ("Floor, 1, 3\n", "Floor, 1, 4, 0.1\n", "Floor, 1, 4", "no degree of freedom 4"),
    ("*Solid section, elset=High, material=Soft\n", "*Solid section, elset=High, material=Soft\n*Solid Section, elset=High, material=Soft\n2.\n", "*Solid Section", "element 2 has a section already"),
    // what only the case shows
    ("Floor, 1, 3\n", "Floor, 1, 2\n", "*Solid section, elset=Low", "body \"Low\" is not held"),
];

#[test]
fn mistakes_are_told_at_their_line() {
    let good = std::fs::read_to_string(own("press.inp")).unwrap();
    let folder = folder("mistakes", &[]);
    for (what, by, line, words) in MISTAKES {
        assert!(good.contains(what), "{what}");
        let text = good.replacen(what, by, 1);
        std::fs::write(folder.join("press.inp"), &text).unwrap();
        let output = dotyk(&folder, &["run", "press.inp", "--out", "out", "--quiet"]);
        let message = told(&output);
        assert_eq!(output.status.code(), Some(2), "{by}: {message}");
        let number = text.lines().position(|l| l.contains(line)).unwrap() + 1;
        assert!(
            message.contains(&format!("press.inp:{number}:")),
            "{by}: line {number}: {message}"
        );
        assert!(message.contains(words), "{by}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        assert!(!folder.join("out/press.frd").exists());
    }
}

/// The tables that dotyk prints for a deck of this folder.
fn printed(deck: &str) -> Vec<(String, Vec<Vec<f64>>)> {
    let folder = folder(deck, &[&format!("{deck}.inp")]);
    let run = dotyk(
        &folder,
        &["run", &format!("{deck}.inp"), "--out", "out", "--quiet"],
    );
    assert!(run.status.success(), "{deck}: {}", told(&run));
    tables(&std::fs::read_to_string(folder.join(format!("out/{deck}.dat"))).unwrap())
}

/// The first row of every table whose heading begins like this.
fn firsts(deck: &str, head: &str) -> Vec<Vec<f64>> {
    let tables = printed(deck).into_iter();
    let wanted = tables.filter(|(own, _)| own.starts_with(head));
    wanted.map(|(_, rows)| rows[0].clone()).collect()
}

fn near(found: f64, wanted: f64, what: &str) {
    let off = (found - wanted).abs();
    assert!(
        off <= 2e-6 * wanted.abs().max(1e-3),
        "{what}: {found} {wanted}"
    );
}

#[test]
fn joined_nodes_bear_the_loads_of_both_and_are_printed_by_their_own_numbers() {
    // four nodes with a force of 1 each, of which two pairs are one
    near(
        firsts("joined-set-load", "total force")[0][1],
        -4.0,
        "a set with both nodes of a pair",
    );
    // one force of 1 in each of two steps, on the two nodes of a pair
    let later = firsts("joined-later-load", "total force");
    near(later[0][1], -1.0, "the first node");
    near(later[1][1], -2.0, "the other one later");
    let dependent = &printed("joined-print")[0].1;
    assert_eq!(
        dependent.iter().map(|row| row[0]).collect::<Vec<_>>(),
        [5.0, 8.0]
    );
    // two nodes that are each joined to a third one move alike, as far as calculix says
    let star = &printed("joined-star")[0].1;
    let moved = |node: f64| star.iter().find(|row| row[0] == node).unwrap()[1];
    near(moved(2.0), moved(5.0), "a star");
    near(moved(2.0), moved(9.0), "its middle");
    assert!((moved(2.0) / -7.43e-4 - 1.0).abs() < 1e-3, "{}", moved(2.0));
}

#[test]
fn forces_of_sets_are_those_of_calculix() {
    // a rigid group that moves with a node of its own
    let [end, fix] = firsts("rigid-own-node", "total force").try_into().unwrap();
    near(end[0], -fix[0], "balance");
    assert!((end[0] / 52.59 - 1.0).abs() < 1e-3, "{}", end[0]);
    // four nodes of a cut, a force of 1 each, halfway between two clamps
    let [left, right] = firsts("bolt-set-load", "total force").try_into().unwrap();
    near(left[1], -2.0, "a cut");
    near(right[1], -2.0, "its other side");
    // gravity again, but for the sign of a zero
    let [first, then] = firsts("gravity-again", "total force").try_into().unwrap();
    near(first[2], 2.0 * then[2], "gravity");
    // *DLOAD and *DSLOAD on one face, the latter taken away
    let [both, one] = firsts("two-pressures", "total force").try_into().unwrap();
    near(both[2], 3.0 * one[2], "pressures");
    // a pair whose master lies on two bodies, and one of which a part is open
    let pairs = printed("pair-of-bodies");
    let heads = pairs
        .iter()
        .filter(|(head, _)| head.starts_with("statistics"));
    assert_eq!(heads.count(), 1);
    let force = firsts("pair-of-bodies", "total surface force");
    assert!((force[0][2] / 11.13 - 1.0).abs() < 0.01, "{force:?}");
    // of five columns of nodes over a length of 4 three are closed; their centre lies nearer to the closed end
    near(firsts("open-area", "area,")[0][0], 2.5, "an area");
    near(
        firsts("open-area", "center of gravity")[0][0],
        1.2,
        "its centre",
    );
}

/// A block that is pressed and dragged with friction in increments of a quarter, whose results the deck asks for: each that many times; what
/// is asked for without FREQUENCY once, at the end.
#[test]
fn increments_that_a_deck_asks_for_are_steps() {
    let tables = printed("increments");
    let sums = |head: &str, column: usize| -> Vec<f64> {
        let own = tables.iter().filter(|(own, _)| own.starts_with(head));
        own.map(|(_, rows)| rows.iter().map(|row| row[column]).sum())
            .collect()
    };
    let lifted = sums("forces", 3);
    assert_eq!(lifted.len(), 4);
    for (k, force) in lifted.into_iter().enumerate() {
        // a pressure of 1 on 2 x 2
        near(force, (k + 1) as f64, &format!("increment {}", k + 1));
    }
    assert_eq!(sums("stresses", 2).len(), 1);
}

/// Within steps AMPLITUDE=STEP acts in full from the first increment, and forces that OP=NEW takes away go down to zero: RF z of
/// CalculiX. The `.frd` counts steps and their increments.
#[test]
fn loads_within_steps_act_as_in_calculix() {
    for (deck, wanted) in [
        ("amplitude-step", vec![4.0; 4]),
        ("removed-loads", vec![4.0, 3.5, 3.0, 2.5, 2.0]),
    ] {
        let lifted = firsts(deck, "total force");
        assert_eq!(lifted.len(), wanted.len(), "{deck}");
        for (row, wanted) in lifted.iter().zip(wanted) {
            near(row[2], wanted, deck);
        }
    }
    let folder = folder("numbers", &["removed-loads.inp"]);
    let deck = std::fs::read_to_string(own("removed-loads.inp")).unwrap();
    let asked = deck.replacen("*NODE PRINT", "*NODE FILE, FREQUENCY=1\nU\n*NODE PRINT", 1);
    std::fs::write(folder.join("removed-loads.inp"), asked).unwrap();
    let run = dotyk(
        &folder,
        &["run", "removed-loads.inp", "--out", "out", "--quiet"],
    );
    assert!(run.status.success(), "{}", told(&run));
    let frd = std::fs::read_to_string(folder.join("out/removed-loads.frd")).unwrap();
    let heads = frd.lines().filter(|line| line.starts_with("    1PSTEP"));
    let numbers = heads.map(|line| {
        let words: Vec<usize> = line
            .split_whitespace()
            .skip(1)
            .map(|w| w.parse().unwrap())
            .collect();
        [words[2], words[1]]
    });
    let all: Vec<[usize; 2]> = numbers.collect();
    assert_eq!(all, [[1, 1], [2, 1], [2, 2], [2, 3], [2, 4]]);
}

#[test]
fn what_a_deck_names_once_more_is_no_other_thing() {
    // a body whose name is that of the body and the section of another one
    let moved = printed("groups-one-name").remove(0).1;
    let far = moved.iter().find(|row| row[0] == 102.0).unwrap();
    for (found, wanted) in far[1..].iter().zip([2.807143e-3, 6.75e-4, 6.75e-4]) {
        near(*found, wanted, "what calculix says");
    }
    // surfaces upon each other are tied by a tolerance of zero as by a small one
    let name = "tie-no-tolerance.inp";
    let small = folder("tie-small-tolerance", &[name]);
    let deck = std::fs::read_to_string(own(name)).unwrap();
    let other = deck.replace("TOLERANCE=0.0", "TOLERANCE=1e-3");
    assert_ne!(deck, other);
    std::fs::write(small.join(name), other).unwrap();
    let run = dotyk(&small, &["run", name, "--out", "out", "--quiet"]);
    assert!(run.status.success(), "{}", told(&run));
    let wanted = std::fs::read_to_string(small.join("out/tie-no-tolerance.dat")).unwrap();
    assert_eq!(printed("tie-no-tolerance"), tables(&wanted));
    // linear, and nothing but a motion acts: what calculix says of the point
    let moved = &firsts("two-couples", "displacements")[0];
    for (found, wanted) in moved[1..]
        .iter()
        .zip([-3.315440e-4, -4.515409e-3, -1.419727e-4])
    {
        near(*found, wanted, "a coupled point");
    }
    for row in &printed("rigid-elements")[0].1 {
        near(row[1].hypot(row[2]), 0.0, "a rigid body");
        near(row[3], 0.1, "its lift");
    }
    // forces spread over a surface, with the lines that other programs write
    near(firsts("lines-of-cae", "total force")[0][2], 2.0, "a press");
    for (deck, line, words) in [
        ("empty-surface", 17, "surface S has no faces"),
        ("element-twice", 20, "element 2 has the nodes of element 1"),
    ] {
        let name = format!("{deck}.inp");
        let folder = folder(deck, &[&name]);
        let run = dotyk(&folder, &["run", &name, "--out", "out", "--quiet"]);
        let said = told(&run);
        assert_eq!(run.status.code(), Some(2), "{said}");
        assert!(
            said.contains(&format!("{name}:{line}")) && said.contains(words),
            "{said}"
        );
    }
}
