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

/// The block dragged by friction in twenty steps.
fn dragged() -> String {
    let text = punch("old", 1e5, 40);
    let (head, _) = text.split_once("[[step]]").unwrap();
    let head = head
        .replace(
            "mortar = \"block.top\"",
            "mortar = \"block.top\"\nfriction = 0.3",
        )
        .replace(
            "fix = [{ side = \"left\", x = 0 }, { side = \"right\", x = 0 }]\n",
            "",
        )
        .replace("[0, \"-q*t\"]", "[\"0.15*q*sin(3*t)\", \"-q*(1 + 0.2*t)\"]");
    let steps = (1..=20).map(|k| format!("[[step]]\ntime = {k}\n"));
    head.to_string() + &steps.collect::<String>()
}

#[test]
fn killed_runs_go_on_from_their_finished_steps() {
    let folder = folder("goes_on");
    fs::write(folder.join("old.toml"), dragged()).unwrap();
    let start = std::time::Instant::now();
    let whole = dotyk(&folder, &["run", "old.toml", "--out", "whole", "--quiet"]);
    let whole = { whole }.output().unwrap();
    assert_eq!(whole.status.code(), Some(0), "{}", told(&whole));
    let needed = start.elapsed();
    assert_eq!(
        names(&folder),
        ["old.toml", "whole"].map(String::from).into()
    );
    let kept = folder.join("out.unfinished");
    let (mut finished, mut kills) = (0, 0);
    // each attempt has more time: it repeats what was finished
    for attempt in 1.. {
        let mut arguments = vec![
            "run",
            "old.toml",
            "--out",
            "out",
            "--quiet",
            "--keep-every",
            "0",
        ];
        if kept.exists() {
            arguments.extend(["--from", "out.unfinished"]);
        }
        let child = dotyk(&folder, &arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(needed.mul_f64(0.1 * f64::from(attempt)));
        kill(&child, "-KILL");
        let ended = child.wait_with_output().unwrap();
        if ended.status.success() {
            break;
        }
        // ended by the signal, not by an error
        assert_eq!(ended.status.code(), None, "{}", told(&ended));
        kills += 1;
        if folder.join("out/summary.json").exists() {
            // killed at its very end, between putting the answer in place and removing what was kept, or what was there before
            let _ = fs::remove_dir_all(&kept);
            let left = names(&folder)
                .into_iter()
                .filter(|name| name.starts_with(".out."));
            left.for_each(|name| drop(fs::remove_dir_all(folder.join(name))));
            break;
        }
        if let Ok(summary) = fs::read_to_string(kept.join("summary.json")) {
            let summary: Value = serde_json::from_str(&summary).unwrap();
            let steps = summary["steps"].as_array().unwrap().len();
            assert!(steps >= finished && steps < 20, "{steps} after {finished}");
            finished = steps;
        }
        assert!(attempt < 100, "{finished}");
    }
    assert!(kills > 0 && finished > 0, "{kills} {finished}");
    assert_eq!(
        names(&folder),
        ["old.toml", "out", "whole"].map(String::from).into()
    );
    let read = |out: &str| -> Value {
        let text = fs::read_to_string(folder.join(out).join("summary.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    let (one, other) = (read("whole"), read("out"));
    for step in 0..20 {
        let of = |summary: &Value| {
            let contact = &summary["steps"][step]["contacts"][0];
            let force = |axis: usize| contact["resultant"][axis].as_f64().unwrap();
            [
                contact["max_pressure"].as_f64().unwrap(),
                force(0),
                force(1),
            ]
        };
        for (a, b) in of(&one).into_iter().zip(of(&other)) {
            assert!((a - b).abs() < 1e-9 * 1e6, "step {}: {a} {b}", step + 1);
        }
    }
}

#[test]
fn a_run_killed_before_its_first_step_is_begun_anew() {
    let folder = folder("bare");
    fs::write(folder.join("old.toml"), punch("old", 1e5, 4)).unwrap();
    // what a run leaves that is killed between making the folder and writing into it
    fs::create_dir(folder.join("out.unfinished")).unwrap();
    let from = [
        "run",
        "old.toml",
        "--out",
        "out",
        "--from",
        "out.unfinished",
    ];
    let ended = dotyk(&folder, &from).output().unwrap();
    assert_eq!(ended.status.code(), Some(0), "{}", told(&ended));
    assert!(
        told(&ended).contains("starts from the beginning"),
        "{}",
        told(&ended)
    );
    assert_eq!(names(&folder), ["old.toml", "out"].map(String::from).into());
    // a folder of another name is a mistake
    fs::create_dir(folder.join("empty")).unwrap();
    let from = ["run", "old.toml", "--out", "out", "--from", "empty"];
    let ended = dotyk(&folder, &from).output().unwrap();
    assert_eq!(ended.status.code(), Some(2), "{}", told(&ended));
}

#[test]
fn what_an_interrupted_run_has_finished_is_told() {
    let folder = folder("interrupted");
    fs::write(folder.join("old.toml"), dragged()).unwrap();
    let arguments = [
        "run",
        "old.toml",
        "--out",
        "out",
        "--quiet",
        "--keep-every",
        "0",
    ];
    let mut child = dotyk(&folder, &arguments)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let kept = folder.join("out.unfinished/summary.json");
    while !kept.exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    kill(&child, "-KILL");
    assert!(!child.wait().unwrap().success());
    // somebody's own file beside them stays
    fs::write(folder.join("out.unfinished/notes.txt"), "mine").unwrap();
    let again = dotyk(&folder, &["run", "old.toml", "--out", "out", "--quiet"]);
    let again = { again }.output().unwrap();
    assert_eq!(again.status.code(), Some(0), "{}", told(&again));
    assert!(
        told(&again).contains("--from out.unfinished goes on from there"),
        "{}",
        told(&again)
    );
    assert_eq!(
        names(&folder.join("out.unfinished")),
        ["notes.txt".to_string()].into()
    );
}

#[test]
fn a_second_run_into_a_folder_is_told() {
    let folder = old_and_new("second", 60);
    for turn in 0..30 {
        if turn % 3 > 0 {
            // the loser may have made what the winner holds
            fs::remove_dir_all(folder.join("out")).unwrap();
        }
        let both = ["old.toml", "new.toml"].map(|case| begin(&folder, case));
        let ended = both.map(|child| child.wait_with_output().unwrap());
        let codes = [0, 1].map(|k| ended[k].status.code());
        let winner = codes.iter().position(|code| *code == Some(0)).unwrap();
        let second = &ended[1 - winner];
        assert_eq!(second.status.code(), Some(2));
        let words = "out is in use: another run writes its results there; wait for its end, or choose another folder with --out";
        assert!(told(second).contains(words), "{}", told(second));
        fs::write(folder.join("out/notes.txt"), "mine").unwrap();
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

/// The exit status of a command in a folder, and what it told, which must be short.
#[track_caller]
fn refused(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let told = told(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.len() < 1500, "{} bytes: {told:.500}", told.len());
    told
}

/// A case of one body, with a mesh and a modulus.
fn body(mesh: &str, young: &str) -> String {
    format!(
        "analysis = \"plane-strain\"\n[[body]]\nname = \"b\"\nmesh = {{ {mesh} }}\n\
         material = {{ young = {young}, poisson = 0.3 }}\nfix = [{{ side = \"bottom\", x = 0, y = 0 }}]\n"
    )
}

fn rectangle(cells: &str) -> String {
    format!("rectangle = {{ from = [0, 0], to = [1, 1], cells = [{cells}] }}")
}

#[test]
fn pipes_and_devices_are_no_meshes() {
    let folder = folder("pipes");
    fs::write(
        folder.join("case.toml"),
        body("file = { path = \"a.msh\" }", "1"),
    )
    .unwrap();
    let mesh = folder.join("a.msh");
    let made = Command::new("mkfifo").arg(&mesh).status().unwrap();
    assert!(made.success());
    let pipe = refused(&mut dotyk(&folder, &["check", "case.toml"]));
    assert!(pipe.contains("no regular file"), "{pipe}");
    fs::remove_file(&mesh).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &mesh).unwrap();
    let device = refused(&mut dotyk(&folder, &["check", "case.toml"]));
    assert!(device.contains("no regular file"), "{device}");
    fs::remove_file(&mesh).unwrap();
    File::create(&mesh).unwrap().set_len(1 << 42).unwrap();
    let huge = refused(&mut dotyk(&folder, &["check", "case.toml"]));
    assert!(huge.contains("it has more than "), "{huge}");
    let endless = refused(&mut dotyk(&folder, &["run", "/dev/zero"]));
    assert!(endless.contains("no regular file"), "{endless}");
}

#[test]
fn numbers_and_lengths_have_limits() {
    let folder = folder("limits");
    let small = body(&rectangle("1, 1"), "1");
    let many = |entry: &dyn Fn(usize) -> String| (0..10_001).map(entry).collect::<String>();
    let cases = [
        ("body", many(&|k| format!("[[body]]\nname = \"b{k}\"\n"))),
        ("step", many(&|k| format!("[[step]]\ntime = {}\n", k + 1))),
        ("probe", many(&|k| format!("[[probe]]\nname = \"p{k}\"\n"))),
        (
            "contact",
            many(&|k| format!("[[contact]]\nname = \"c{k}\"\n")),
        ),
        (
            "parameters",
            format!("[parameters]\n{}", many(&|k| format!("p{k} = {k}\n"))),
        ),
    ];
    for (key, more) in &cases {
        fs::write(folder.join("case.toml"), format!("{small}{more}")).unwrap();
        let said = refused(&mut dotyk(&folder, &["check", "case.toml"]));
        assert!(said.contains(&format!("`{key}` has 1000")), "{said}");
        assert!(said.contains("at most 10000"), "{said}");
    }
    for word in ["1+".repeat(100_000), "q".repeat(1_000_000)] {
        let case = body(&rectangle("1, 1"), &format!("\"{word}\""));
        fs::write(folder.join("case.toml"), case).unwrap();
        let said = refused(&mut dotyk(&folder, &["check", "case.toml"]));
        assert!(said.contains("longer than 100000 characters"), "{said}");
    }
    fs::write(
        folder.join("case.toml"),
        format!("{small}#{}", " ".repeat(30 << 20)),
    )
    .unwrap();
    let said = refused(&mut dotyk(&folder, &["check", "case.toml"]));
    assert!(said.contains("it has more than 20 MB"), "{said}");
    // as many parameters as may be, each of which names the one before it, and warned of at once
    let chain = many(&|k| match k {
        0 => "[parameters]\np0 = 1\n".to_string(),
        1..10_000 => format!("p{k} = \"p{} + 1\"\n", k - 1),
        _ => String::new(),
    });
    fs::write(folder.join("case.toml"), format!("{small}{chain}")).unwrap();
    let output = dotyk(&folder, &["check", "case.toml"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", told_briefly(&output));
    let warnings = String::from_utf8_lossy(&output.stdout)
        .matches("warning")
        .count();
    assert_eq!(warnings, 1, "{}", told_briefly(&output));
    fs::write(folder.join("case.toml"), &small).unwrap();
    let said = refused(&mut dotyk(
        &folder,
        &["run", "case.toml", "--threads", "5000"],
    ));
    assert!(said.contains("at most 1024"), "{said}");
}

fn told_briefly(output: &Output) -> String {
    told(output).chars().take(500).collect()
}

/// A command under limits that a shell sets first.
#[cfg(target_os = "linux")]
fn limited(folder: &Path, limits: &str, arguments: &str) -> Command {
    let mut command = Command::new("sh");
    let line = format!("{limits}; exec \"$0\" {arguments}");
    let program = env!("CARGO_BIN_EXE_dotyk");
    command.args(["-c", &line, program]).current_dir(folder);
    command
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_there_is_not_is_an_error() {
    let folder = folder("memory");
    fs::write(folder.join("case.toml"), punch("small", 1e5, 8)).unwrap();
    fs::write(
        folder.join("wide.toml"),
        body(&rectangle("5, 1000000"), "1"),
    )
    .unwrap();
    for space in [50_000, 100_000, 200_000] {
        let limit = format!("ulimit -v {space}");
        let told = refused(&mut limited(&folder, &limit, "run case.toml"));
        assert!(told.contains("the address space is limited"), "{told}");
        assert!(!folder.join("case-out").exists());
    }
    let told = refused(&mut limited(
        &folder,
        "ulimit -v 3000000",
        "check wide.toml",
    ));
    assert!(told.contains("of memory are needed at least"), "{told}");
    assert!(told.contains("wide.toml, line 4"), "{told}");
    // a stack of 64 kB
    let run = limited(&folder, "ulimit -s 64", "run case.toml --quiet").status();
    assert_eq!(run.unwrap().code(), Some(0));
}

#[test]
fn an_abort_is_an_exit_status() {
    let folder = folder("abort");
    fs::write(folder.join("case.toml"), punch("long", 1e5, 400)).unwrap();
    let mut child = begin(&folder, "case.toml");
    std::thread::sleep(Duration::from_millis(300));
    kill(&child, "-ABRT");
    assert_eq!(child.wait().unwrap().code(), Some(2));
}
