//! Every folder of `cases/`, as `dotyk verify` does: each case certified, each reference value within its band.

use dotyk::case::{Case, References, Verdict};
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
    let reference = folder.join("reference.toml");
    let references = reference
        .exists()
        .then(|| References::read(&reference).unwrap());
    let mut values = references.map_or(Vec::new(), |r| r.values);
    for path in entries(folder).into_iter().filter(|path| is_case(path)) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let case = Case::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let solution = match case.model.solve() {
            Ok(solution) => solution,
            Err(error) => {
                wrong.push(format!("{}: {error}", path.display()));
                continue;
            }
        };
        if !solution.converged {
            wrong.push(format!("{}: not certified", path.display()));
        }
        let (of_case, others) = values.into_iter().partition(|r| r.case == name);
        values = others;
        let of_case: Vec<dotyk::case::Reference> = of_case;
        for value in of_case {
            let found = solution.probes.iter().find(|p| p.name == value.probe);
            match found.map(|p| (p.value, value.judge(p.value))) {
                Some((_, Verdict::Within)) => judged += 1,
                Some((_, Verdict::NotJudged)) => {}
                Some((computed, Verdict::Outside)) => wrong.push(format!(
                    "{}, {}: {computed}, not {} ({:?})",
                    path.display(),
                    value.probe,
                    value.value,
                    value.criterion
                )),
                None => wrong.push(format!("{}: no probe {}", path.display(), value.probe)),
            }
        }
    }
    let lost = values
        .iter()
        .map(|r| format!("{}: no case {}", folder.display(), r.case));
    wrong.extend(lost);
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
