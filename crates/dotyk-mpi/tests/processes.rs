//! `dotyk-mpi` as its users call it, by `mpirun`.
#![cfg(mpi)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// An empty folder of its own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A block that is pressed on another one and drawn along it, in so many cells, pieces and steps; nothing else holds it.
fn blocks(cells: usize, pieces: usize, steps: usize) -> String {
    let (wide, narrow) = (2 * cells, cells + cells / 2);
    let times = (1..=steps).map(|k| format!("[[step]]\ntime = {}\n", k as f64 / steps as f64));
    format!(
        r#"title = "Two blocks"
analysis = "3d"

[[body]]
name = "lower"
mesh = {{ box = {{ from = [0, 0, 0], to = [2, 2, 1], cells = [{wide}, {wide}, {cells}] }} }}
material = {{ young = 1000, poisson = 0.3 }}
fix = [{{ side = "bottom", x = 0, y = 0, z = 0 }}]

[[body]]
name = "upper"
mesh = {{ box = {{ from = [0.4, 0.4, 1], to = [1.6, 1.6, 2], cells = [{narrow}, {narrow}, {cells}] }} }}
material = {{ young = 2000, poisson = 0.2 }}
load = [{{ side = "top", traction = ["3*t", 0, "-20*(1 + 0.3*x)"] }}]

[[contact]]
name = "sole"
nonmortar = "upper.bottom"
mortar = "lower.top"
friction = 0.4

[solver]
subdomains = {pieces}

{}"#,
        times.collect::<String>()
    )
}

/// The program on so many processes, without `mpirun` on none.
fn on(processes: usize, folder: &Path, arguments: &[&str]) -> Command {
    let program = env!("CARGO_BIN_EXE_dotyk-mpi");
    let mut command = match processes {
        0 => Command::new(program),
        _ => {
            let mut command = Command::new("mpirun");
            command.args(["-n", &processes.to_string(), program]);
            command
        }
    };
    command.args(arguments).current_dir(folder);
    // Open MPI does not start as the user of containers, nor more processes than there are processors, unless it is told to
    for name in [
        "OMPI_ALLOW_RUN_AS_ROOT",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM",
        "OMPI_MCA_rmaps_base_oversubscribe",
        "PRTE_ALLOW_RUN_AS_ROOT",
        "PRTE_ALLOW_RUN_AS_ROOT_CONFIRM",
    ] {
        command.env(name, "1");
    }
    command
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn read(folder: &Path, file: &str) -> String {
    fs::read_to_string(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name());
    names.map(|name| name.into_string().unwrap()).collect()
}

/// What stands behind a key of a summary, where it comes first.
fn number(summary: &str, key: &str) -> f64 {
    let rest = summary.split(&format!("\"{key}\":")).nth(1).unwrap();
    let end = rest.find([',', '\n', '}', ']']).unwrap();
    rest[..end].trim().parse().unwrap()
}

#[test]
fn bits_of_the_answer_do_not_depend_on_the_number_of_processes() {
    let folder = folder("bits");
    fs::write(folder.join("blocks.toml"), blocks(6, 24, 2)).unwrap();
    let mut answers = Vec::new();
    for processes in [0, 1, 2, 3, 4, 8] {
        let out = format!("out{processes}");
        let ended = on(
            processes,
            &folder,
            &["run", "blocks.toml", "--out", &out, "--quiet"],
        );
        let ended = { ended }.output().unwrap();
        assert_eq!(
            ended.status.code(),
            Some(0),
            "{processes}: {}",
            told(&ended)
        );
        let printed = String::from_utf8(ended.stdout).unwrap();
        assert_eq!(printed.matches("Two blocks").count(), 1, "{printed}");
        let out = folder.join(out);
        let summary = read(&out, "summary.json");
        assert_eq!(number(&summary, "subdomains"), 24.0);
        answers.push((read(&out, "contact.csv"), number(&summary, "iterations")));
        // a piece of every body for each process, and nothing but what the collection names
        for name in ["lower_0001", "upper_0002"] {
            let whole = read(&out, &format!("{name}.pvtu"));
            assert_eq!(whole.matches("<Piece ").count(), processes.max(1));
            for part in 0..processes.max(1) {
                let part = format!("{name}.p{part}.vtu");
                assert!(whole.contains(&part));
                assert!(read(&out, &part).contains("Name=\"displacement\""));
            }
        }
        let blocks = read(&out, "case_0002.vtm");
        assert_eq!(blocks.matches(".vtu\"").count(), 2 * processes.max(1));
        let files = names(&out);
        let parts = files.iter().filter(|name| name.ends_with(".vtu")).count();
        assert_eq!(parts, 2 * 2 * processes.max(1));
        for once in ["case.pvd", "contact.csv", "report.html", "summary.json"] {
            assert!(files.contains(once));
        }
    }
    assert!(answers.iter().all(|answer| *answer == answers[0]));
}

#[test]
fn pieces_on_processes_answer_as_whole_bodies() {
    let folder = folder("wholes");
    let mut answers = Vec::new();
    for (name, pieces, processes) in [("whole", 1, 2), ("pieces", 30, 3)] {
        let file = format!("{name}.toml");
        fs::write(folder.join(&file), blocks(5, pieces, 1)).unwrap();
        let ended = on(
            processes,
            &folder,
            &["run", &file, "--out", name, "--quiet"],
        );
        let ended = { ended }.output().unwrap();
        assert_eq!(ended.status.code(), Some(0), "{}", told(&ended));
        let summary = read(&folder.join(name), "summary.json");
        answers.push(["max_pressure", "strain_energy"].map(|key| number(&summary, key)));
    }
    for (a, b) in answers[0].iter().zip(&answers[1]) {
        assert!((a - b).abs() < 1e-7 * a.abs(), "{answers:?}");
    }
}

#[test]
fn fewer_processes_write_fewer_files_and_go_on_where_more_have_ended() {
    let folder = folder("from");
    let text = blocks(3, 8, 3);
    let two = text.trim_end().rsplit_once("[[step]]").unwrap().0;
    for (text, processes, steps, more) in [
        (two, 3, 2, &[][..]),
        (&text, 2, 3, &["--from", "blocks-out"]),
    ] {
        fs::write(folder.join("blocks.toml"), text).unwrap();
        // what is kept of the steps on the way goes when the results are there
        let run = ["run", "blocks.toml", "--quiet", "--keep-every", "0"];
        let arguments = [&run, more].concat();
        let ended = on(processes, &folder, &arguments).output().unwrap();
        assert_eq!(ended.status.code(), Some(0), "{}", told(&ended));
        let files = names(&folder.join("blocks-out"));
        let parts = files.iter().filter(|name| name.ends_with(".vtu")).count();
        assert_eq!(parts, 2 * steps * processes);
    }
    assert_eq!(names(&folder).len(), 2);
}

#[test]
fn mistakes_are_told_once() {
    let folder = folder("mistakes");
    let text = blocks(2, 4, 1);
    fs::write(folder.join("good.toml"), &text).unwrap();
    let held = "fix = [{ side = \"bottom\", x = 0, y = 0, z = 0 }]\n";
    for (name, text, words) in [
        (
            "side",
            text.replace("upper.bottom", "upper.botom"),
            "has no side `botom`",
        ),
        ("free", text.replace(held, ""), "lower"),
        ("young", text.replace("1000", "-1000"), "young"),
    ] {
        let file = format!("{name}.toml");
        fs::write(folder.join(&file), text).unwrap();
        let ended = on(3, &folder, &["run", &file]).output().unwrap();
        assert_eq!(ended.status.code(), Some(2), "{name}: {}", told(&ended));
        assert_eq!(told(&ended).matches("  x ").count(), 1, "{}", told(&ended));
        assert!(told(&ended).contains(words), "{}", told(&ended));
    }
    fs::write(folder.join("taken"), "").unwrap();
    for (arguments, words) in [
        (
            &["run", "good.toml", "--threads", "2"][..],
            "start more processes",
        ),
        (
            &["run", "good.toml", "--out", "taken"],
            "cannot be the output folder",
        ),
        (&["check", "good.toml"], "check"),
        (&["run", "missing.toml"], "missing.toml"),
    ] {
        let ended = on(2, &folder, arguments).output().unwrap();
        assert_eq!(ended.status.code(), Some(2), "{}", told(&ended));
        assert_eq!(told(&ended).matches(words).count(), 1, "{}", told(&ended));
    }
    assert!(!folder.join("good-out").exists());
}

#[test]
fn cases_are_independent_of_those_that_were_refused() {
    let folder = folder("several");
    let text = blocks(2, 4, 1);
    fs::write(folder.join("good.toml"), &text).unwrap();
    fs::write(
        folder.join("bad.toml"),
        text.replace("upper.bottom", "upper.botom"),
    )
    .unwrap();
    let arguments = ["run", "bad.toml", "good.toml", "--out", "out", "--quiet"];
    let ended = on(3, &folder, &arguments).output().unwrap();
    assert_eq!(ended.status.code(), Some(2), "{}", told(&ended));
    assert_eq!(told(&ended).matches("  x ").count(), 1, "{}", told(&ended));
    assert!(folder.join("out/good/contact.csv").exists());
}

#[test]
fn processes_with_different_files_are_refused() {
    let folder = folder("different");
    let text = blocks(3, 6, 1);
    for (name, other) in [
        // another load, another mesh, and a case that ends with an error
        ("load", text.replace("-20*", "-21*")),
        ("mesh", text.replace("[0.4, 0.4, 1]", "[0.4, 0.5, 1]")),
        ("steps", text.replace("time = 1", "time = 2")),
        ("side", text.replace("upper.bottom", "upper.botom")),
    ] {
        fs::write(folder.join("one.toml"), &text).unwrap();
        fs::write(folder.join("other.toml"), other).unwrap();
        let mut both = on(1, &folder, &["run", "one.toml", "--out", "out", ":"]);
        let program = env!("CARGO_BIN_EXE_dotyk-mpi");
        both.args(["-n", "1", program, "run", "other.toml", "--out", "out"]);
        let ended = both.output().unwrap();
        assert_eq!(ended.status.code(), Some(2), "{name}: {}", told(&ended));
        assert!(told(&ended).contains("  x "), "{name}: {}", told(&ended));
        assert!(!folder.join("out/summary.json").exists(), "{name}");
    }
}

#[test]
fn a_process_that_dies_ends_all_and_leaves_no_half_answer() {
    let folder = folder("dies");
    fs::write(folder.join("blocks.toml"), blocks(10, 60, 8)).unwrap();
    let mut running = on(3, &folder, &["run", "blocks.toml", "--quiet"]);
    let mut running = running
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    let victim = loop {
        let mut listed = Command::new("ps");
        listed.args(["-o", "pid=,args=", "--ppid", &running.id().to_string()]);
        let listed = listed.output().unwrap();
        let text = String::from_utf8_lossy(&listed.stdout).into_owned();
        let own = text
            .lines()
            .filter(|line| line.contains("dotyk-mpi"))
            .nth(1);
        let number = own.and_then(|line| line.split_whitespace().next().map(str::to_string));
        if let Some(number) = number
            && folder.join("blocks-out").exists()
        {
            break number;
        }
        assert!(Instant::now() < deadline && running.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    };
    assert!(
        Command::new("kill")
            .args(["-KILL", &victim])
            .status()
            .unwrap()
            .success()
    );
    let ended = running.wait_with_output().unwrap();
    assert!(!ended.status.success());
    // the first process, which is told to end, has removed the folder, unless it was killed as well
    let out = folder.join("blocks-out");
    let left = if out.exists() {
        names(&out)
    } else {
        BTreeSet::new()
    };
    assert!(left.is_empty(), "{left:?}");
}
