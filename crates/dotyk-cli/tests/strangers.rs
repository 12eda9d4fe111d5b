//! What becomes of files of strangers, of full disks and of runs that are killed.
#![cfg(unix)]

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

/// A fresh folder.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("strangers")
        .join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn dotyk(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dotyk"));
    command.args(arguments).current_dir(folder);
    command
}

fn told(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A punch on a block in two steps, with so many cells along it.
fn punch(title: &str, pressure: f64, cells: usize) -> String {
    format!(
        r#"title = "{title}"
analysis = "plane-strain"
[parameters]
q = {pressure:?}
[[body]]
name = "block"
mesh = {{ rectangle = {{ from = [0, 0], to = [4, 1], cells = [{cells}, {}] }} }}
material = {{ young = 1e9, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0 }}]
[[body]]
name = "punch"
mesh = {{ rectangle = {{ from = [1.5, 1], to = [2.5, 2], cells = [{}, {}] }} }}
material = {{ young = 1e9, poisson = 0.3 }}
fix = [{{ side = "left", x = 0 }}, {{ side = "right", x = 0 }}]
load = [{{ side = "top", traction = [0, "-q*t"] }}]
[[contact]]
name = "sole"
nonmortar = "punch.bottom"
mortar = "block.top"
[[probe]]
name = "most"
quantity = "sole.pressure"
reduce = "max"
[[step]]
time = 0.5
[[step]]
time = 1
"#,
        cells / 2,
        cells / 4,
        cells / 4,
    )
}

/// Names of what a folder holds.
fn names(folder: &Path) -> BTreeSet<String> {
    let list = fs::read_dir(folder).into_iter().flatten();
    list.map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

/// The title of the run whose files a folder holds; all of them must be of one run.
#[track_caller]
fn whose(out: &Path) -> String {
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    let summary: Value = serde_json::from_str(&read("summary.json")).unwrap();
    let most = summary["contacts"][0]["max_pressure"].as_f64().unwrap();
    let csv = read("contact.csv");
    let head: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let column = head.iter().position(|name| *name == "pressure").unwrap();
    let pressures = csv
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(column).unwrap());
    let largest = pressures
        .filter_map(|p| p.parse::<f64>().ok())
        .fold(0.0, f64::max);
    assert!(
        (largest / most - 1.0).abs() < 1e-12,
        "{largest} of the table, {most} of the summary"
    );
    let report = read("report.html");
    let (_, title) = report.split_once("<title>").unwrap();
    let title = title.split_once("</title>").unwrap().0.to_string();
    assert_eq!(title.starts_with("old"), most < 3e5, "{title}: {most}");
    let mut expected: BTreeSet<String> = BTreeSet::new();
    let fields = [
        "block_0001.vtu",
        "block_0002.vtu",
        "punch_0001.vtu",
        "punch_0002.vtu",
    ];
    let others = [
        "case.pvd",
        "case_0001.vtm",
        "case_0002.vtm",
        "contact.csv",
        "report.html",
        "summary.json",
    ];
    expected.extend(
        fields
            .into_iter()
            .chain(others)
            .chain(["notes.txt"])
            .map(String::from),
    );
    assert_eq!(names(out), expected);
    title
}

/// A folder with two cases and the results of the old one, beside which somebody has put notes.
fn old_and_new(name: &str, cells: usize) -> PathBuf {
    let folder = folder(name);
    fs::write(folder.join("old.toml"), punch("old", 1e5, cells)).unwrap();
    fs::write(folder.join("new.toml"), punch("new", 7e5, cells)).unwrap();
    let run = dotyk(&folder, &["run", "old.toml", "--out", "out", "--quiet"])
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", told(&run));
    fs::write(folder.join("out/notes.txt"), "mine").unwrap();
    assert_eq!(whose(&folder.join("out")), "old");
    folder
}

fn begin(folder: &Path, case: &str) -> Child {
    let mut command = dotyk(folder, &["run", case, "--out", "out", "--quiet"]);
    command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn kill(child: &Child, signal: &str) {
    let done = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(done.is_ok());
}

#[test]
fn a_killed_run_leaves_the_old_answer_or_the_new_one() {
    let folder = old_and_new("killed", 48);
    let out = folder.join("out");
    let start = std::time::Instant::now();
    begin(&folder, "old.toml").wait().unwrap();
    let whole = start.elapsed();
    let expected: BTreeSet<String> = ["new.toml", "old.toml", "out"].map(String::from).into();
    for (k, case) in ["new.toml", "old.toml"]
        .into_iter()
        .cycle()
        .take(24)
        .enumerate()
    {
        let signal = ["-TERM", "-KILL", "-HUP", "-INT"][k / 2 % 4];
        let mut child = begin(&folder, case);
        // most of them while the files are written, which is the end
        std::thread::sleep(whole.mul_f64((k % 12 + 2) as f64 / 13.0));
        kill(&child, signal);
        child.wait().unwrap();
        whose(&out);
        if signal != "-KILL" {
            assert_eq!(names(&folder), expected, "{signal}");
        }
    }
    // the next one sweeps
    assert!(begin(&folder, "new.toml").wait().unwrap().success());
    assert_eq!(whose(&out), "new");
    assert_eq!(names(&folder), expected);
}

#[test]
fn a_first_run_that_is_told_to_end_leaves_nothing() {
    let folder = folder("first");
    fs::write(folder.join("old.toml"), punch("old", 1e5, 160)).unwrap();
    let mut child = begin(&folder, "old.toml");
    std::thread::sleep(Duration::from_millis(150));
    kill(&child, "-TERM");
    assert!(!child.wait().unwrap().success());
    assert_eq!(names(&folder), ["old.toml".to_string()].into());
}

#[test]
fn a_second_run_into_a_folder_is_told() {
    let folder = old_and_new("second", 120);
    for _ in 0..3 {
        let both = ["old.toml", "new.toml"].map(|case| begin(&folder, case));
        let ended = both.map(|child| child.wait_with_output().unwrap());
        let codes = [0, 1].map(|k| ended[k].status.code());
        let winner = codes.iter().position(|code| *code == Some(0)).unwrap();
        let second = &ended[1 - winner];
        assert_eq!(second.status.code(), Some(2));
        let words = "out is in use: another run writes its results there; wait for its end, or choose another folder with --out";
        assert!(told(second).contains(words), "{}", told(second));
        assert_eq!(whose(&folder.join("out")), ["old", "new"][winner]);
    }
}

#[test]
fn output_that_is_lost_is_an_error() {
    let folder = folder("full");
    fs::write(folder.join("case.toml"), punch("old", 1e5, 8)).unwrap();
    let Ok(_) = File::open("/dev/full") else {
        return;
    };
    for arguments in [
        &["run", "case.toml"][..],
        &["run", "case.toml", "--json"],
        &["check", "case.toml"],
        &["compare", "case.toml"],
        &["export", "case.toml"],
        &["study", "case.toml", "--vary", "q=1e5..2e5:2"],
        &["verify", "."],
        &["help"],
        &["reference"],
        &["completions", "bash"],
        &["--version"],
        &["run", "--help"],
    ] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let ended = dotyk(&folder, arguments).stdout(full).output().unwrap();
        assert_eq!(
            ended.status.code(),
            Some(2),
            "{arguments:?}: {}",
            told(&ended)
        );
        assert!(
            told(&ended).contains("standard output takes no more"),
            "{arguments:?}"
        );
    }
    // a reader who has seen enough is no error
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let ended = dotyk(&folder, &["run", "case.toml"])
        .stdout(writer)
        .output()
        .unwrap();
    assert_eq!(ended.status.code(), Some(0), "{}", told(&ended));
}

#[test]
fn the_summary_that_is_printed_is_that_of_the_run() {
    let folder = folder("json");
    fs::write(folder.join("case.toml"), punch("old", 1e5, 8)).unwrap();
    let ended = dotyk(&folder, &["run", "case.toml", "--json"])
        .output()
        .unwrap();
    let file = fs::read(folder.join("case-out/summary.json")).unwrap();
    assert_eq!(ended.stdout, file);
}

#[test]
fn no_text_of_a_case_reaches_the_terminal_as_a_command() {
    let folder = folder("terminal");
    let odd = "\u{1b}[2Jodd\u{9b}.toml";
    let case = punch("\\u001b[2J\\u001b]0;PWNED\\u0007\\u001b[8m", 1e5, 8);
    fs::write(folder.join(odd), &case).unwrap();
    let step = case.replacen("time = 0.5", "time = 0.5\nname = \"a\\u001b[2Jb\"", 1);
    fs::write(folder.join("step.toml"), step).unwrap();
    let key = case.replace("[[probe]]", "[[pro\u{7}be]]");
    fs::write(folder.join("key.toml"), key).unwrap();
    // the title is told
    let ended = dotyk(&folder, &["run", odd]).output().unwrap();
    let text = String::from_utf8(ended.stdout).unwrap();
    assert!(text.contains("\\u001b[2J\\u001b]0;PWNED"), "{text}");
    let missing = "\u{1b}]0;none\u{7}";
    for arguments in [
        &["run", odd][..],
        &["check", odd],
        &["verify", "."],
        &["run", "step.toml"],
        &["run", "key.toml"],
        &["run", missing],
        &["run", odd, "--solver", missing],
        &[missing],
        &["\u{1b}[8mhidden"],
    ] {
        let ended = dotyk(&folder, arguments).output().unwrap();
        for bytes in [&ended.stdout, &ended.stderr] {
            let text = String::from_utf8_lossy(bytes);
            let obeyed = |c: char| c.is_control() && c != '\n' && c != '\t';
            assert!(!text.contains(obeyed), "{arguments:?}: {text:?}");
        }
    }
}
