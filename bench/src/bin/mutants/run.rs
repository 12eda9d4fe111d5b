//! Building the copy once, and running the tests that reach a change.

use crate::copy::{CHANGE, REACHED};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A test of a binary.
#[derive(Debug, Clone)]
pub struct Test {
    pub binary: PathBuf,
    pub name: String,
    /// Wall time alone in its process.
    pub time: Duration,
    /// The changes that it reaches, by number.
    pub reaches: Vec<bool>,
}

/// The outcome of a change.
#[derive(Debug, Clone, PartialEq)]
pub enum Fate {
    /// The copy does not compile with it.
    NotViable,
    /// One of these tests fails, or does not end.
    Caught(String),
    /// All tests that reach it pass; their number.
    Survived(usize),
}

/// Runs cargo in the copy; its machine-readable messages.
fn cargo(folder: &Path, arguments: &[&str]) -> Result<(bool, Vec<Value>), String> {
    let output = Command::new("cargo")
        .args(arguments)
        .arg("--message-format=json")
        .current_dir(folder)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cargo: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let messages = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    Ok((output.status.success(), messages.collect()))
}

/// Numbers of the changes that the copy does not compile with; empty when it compiles.
///
/// An error is attributed to all changes on the lines that it names, or else to the last change before it.
pub fn not_viable(folder: &Path) -> Result<Vec<usize>, String> {
    let (compiles, messages) = cargo(folder, &["check", "--release", "-p", "dotyk", "--lib"])?;
    let mut found = Vec::new();
    for message in messages {
        let message = &message["message"];
        if message["level"] != "error" {
            continue;
        }
        let (mut named, mut before) = (Vec::new(), None);
        for span in message["spans"].as_array().into_iter().flatten() {
            let number = |key: &str| span[key].as_u64().unwrap_or(0) as usize;
            let file = span["file_name"].as_str().unwrap_or_default();
            // files of the standard library contain no changes
            let text = std::fs::read_to_string(folder.join(file)).unwrap_or_default();
            let (first, last) = (number("line_start"), number("line_end"));
            let lines = text.lines().take(last).skip(first.saturating_sub(1));
            named.extend(lines.flat_map(numbers));
            if span["is_primary"] == true {
                let start = text.get(..number("byte_start"));
                before = start.and_then(|text| numbers(text).pop());
            }
        }
        found.extend(named.is_empty().then_some(before).flatten());
        found.append(&mut named);
    }
    found.sort_unstable();
    found.dedup();
    match (compiles, found.is_empty()) {
        (false, true) => Err("the copy does not compile, and not because of a change".to_string()),
        _ => Ok(found),
    }
}

/// Numbers of the changes in a piece of the copy, in their order.
fn numbers(text: &str) -> Vec<usize> {
    let rest = text.split("dotyk_mutant(").skip(1);
    let digits = rest.filter_map(|rest| rest.split(')').next());
    digits.filter_map(|digits| digits.parse().ok()).collect()
}

/// The tests of the tier, built: those inside the library, and those of the suite that begin with none of these words.
pub fn tests(folder: &Path, left_out: &[&str]) -> Result<Vec<Test>, String> {
    let arguments = "test --release --no-run -p dotyk-suite -p dotyk-unit --test unit --test suite";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let (built, messages) = cargo(folder, &arguments)?;
    if !built {
        return Err("the tests of the copy do not compile".to_string());
    }
    let mut tests = Vec::new();
    for message in messages {
        let Some(binary) = message["executable"].as_str().map(PathBuf::from) else {
            continue;
        };
        let list = Command::new(&binary)
            .args(["--list", "--format", "terse"])
            .output();
        let list = list.map_err(|error| format!("{}: {error}", binary.display()))?;
        let inside = message["target"]["name"] == "unit";
        for name in String::from_utf8_lossy(&list.stdout).lines() {
            let Some(name) = name.strip_suffix(": test") else {
                continue;
            };
            if inside || !left_out.iter().any(|word| name.starts_with(word)) {
                tests.push(Test {
                    binary: binary.clone(),
                    name: name.to_string(),
                    time: Duration::ZERO,
                    reaches: Vec::new(),
                });
            }
        }
    }
    Ok(tests)
}

/// Runs a test without a change: its time, and the changes (of `count`) that it reaches.
pub fn survey(folder: &Path, test: &Test, log: &Path, count: usize) -> Result<Test, String> {
    if log.exists() {
        std::fs::remove_file(log).map_err(|error| format!("{}: {error}", log.display()))?;
    }
    let start = Instant::now();
    let hour = Duration::from_secs(3600);
    let variables = [(REACHED, log.display().to_string())];
    if !passes(folder, &[test], &variables, hour)? {
        return Err(format!("{} fails without a change", test.name));
    }
    let mut test = test.clone();
    test.time = start.elapsed();
    test.reaches = vec![false; count];
    // a test that reaches no change writes no file
    for line in std::fs::read_to_string(log).unwrap_or_default().lines() {
        if let Some(reached) = line
            .parse()
            .ok()
            .and_then(|k: usize| test.reaches.get_mut(k))
        {
            *reached = true;
        }
    }
    Ok(test)
}

/// Runs the tests that reach a change, the fastest first; one that takes 20 times its time, and 5 s, does not end.
pub fn fate(folder: &Path, tests: &[Test], number: usize) -> Result<Fate, String> {
    let mut reaching: Vec<&Test> = tests.iter().filter(|test| test.reaches[number]).collect();
    reaching.sort_by_key(|test| (test.binary.clone(), test.time));
    reaching.sort_by_key(|test| test.time);
    let variables = [(CHANGE, number.to_string())];
    let (mut rest, mut size) = (reaching.as_slice(), 4);
    while !rest.is_empty() {
        let (now, later) = rest.split_at(size.min(rest.len()));
        let mut binaries: Vec<&Path> = now.iter().map(|test| test.binary.as_path()).collect();
        binaries.sort_unstable();
        binaries.dedup();
        for binary in binaries {
            let own: Vec<&Test> = now.iter().copied().filter(|t| t.binary == binary).collect();
            let time: Duration = own.iter().map(|test| test.time).sum();
            let limit = 20 * time + Duration::from_secs(5);
            if !passes(folder, &own, &variables, limit)? {
                let names: Vec<&str> = own.iter().map(|test| test.name.as_str()).collect();
                return Ok(Fate::Caught(names.join(" ")));
            }
        }
        (rest, size) = (later, 4 * size);
    }
    Ok(Fate::Survived(reaching.len()))
}

/// Runs tests of one binary in one thread; false where one fails or the time is over.
fn passes(
    folder: &Path,
    tests: &[&Test],
    variables: &[(&str, String)],
    limit: Duration,
) -> Result<bool, String> {
    let Some(first) = tests.first() else {
        return Ok(true);
    };
    let refused = |error| format!("{}: {error}", first.binary.display());
    let mut child = Command::new(&first.binary)
        .args(["--exact", "--test-threads=1", "--quiet"])
        .args(tests.iter().map(|test| &test.name))
        .envs(variables.iter().map(|(name, value)| (name, value)))
        .env("RAYON_NUM_THREADS", "1")
        // the folder in which cargo starts them
        .current_dir(folder.join("crates/dotyk"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(refused)?;
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(refused)? {
            return Ok(status.success());
        }
        if start.elapsed() > limit {
            child.kill().and_then(|()| child.wait()).map_err(refused)?;
            return Ok(false);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}
