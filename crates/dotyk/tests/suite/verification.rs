//! Every folder of `cases/`, as `dotyk verify` does: each case certified, each reference value within its band.

use dotyk::case::{Case, References, Verdict};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn entries(folder: &Path) -> Vec<PathBuf> {
    let list = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<PathBuf> = list.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

fn is_case(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "toml") && !path.ends_with("reference.toml")
}

/// What is wrong in a folder; the number of its values that were judged.
fn verify(folder: &Path) -> (Vec<String>, usize) {
    let (mut wrong, mut judged) = (Vec::new(), 0);
    let mut solutions = BTreeMap::new();
    for path in entries(folder).into_iter().filter(|path| is_case(path)) {
        let case = Case::read(&path).unwrap_or_else(|error| panic!("{error}"));
        match case.model.solve_steps() {
            Ok(steps) => {
                assert!(steps.iter().all(|s| s.converged), "{}", path.display());
                let name = path.file_name().unwrap().to_string_lossy();
                solutions.insert(name.into_owned(), steps);
            }
            Err(error) => wrong.push(format!("{}: {error}", path.display())),
        }
    }
    let reference = folder.join("reference.toml");
    if !reference.exists() {
        return (wrong, judged);
    }
    let references = References::read(&reference).unwrap_or_else(|error| panic!("{error}"));
    for value in references.values {
        // A case, step or probe that is not there agrees with nothing.
        let read = |case: &str| {
            let steps = solutions.get(case);
            let step = steps.and_then(|steps| value.of(steps, steps.len()));
            let probes = step.map(|s| s.probes.iter());
            let found = probes.and_then(|mut p| p.find(|p| p.name == value.probe));
            found.map_or(f64::NAN, |p| p.value)
        };
        let computed = value.computed(read(&value.case), value.against.as_deref().map(read));
        match value.judge(computed) {
            Verdict::Within => judged += 1,
            Verdict::NotJudged if computed.is_nan() => {
                wrong.push(format!("{}, {}: not computed", value.case, value.probe));
            }
            Verdict::NotJudged => {}
            Verdict::Outside => wrong.push(format!(
                "{}, {}, {}: {computed}, not {} ({:?})",
                folder.display(),
                value.case,
                value.probe,
                value.value,
                value.criterion
            )),
        }
    }
    (wrong, judged)
}

#[test]
fn every_case_is_certified_and_within_its_bands() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases");
    let folders = entries(&cases).into_iter().filter(|path| path.is_dir());
    let (mut wrong, mut count) = (Vec::new(), 0);
    for folder in folders {
        let (found, judged) = verify(&folder);
        wrong.extend(found);
        count += judged;
    }
    assert!(
        count > 100,
        "only {count} values are judged: the cases are elsewhere"
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
