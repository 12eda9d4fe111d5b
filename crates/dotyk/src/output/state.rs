//! `state.bin`: strains without stress of each body in each load step, plastic or kept, from which a run goes on.
//!
//! ```text
//!   dotyk state 1\n
//!   [{ "step": 1, "body": "tube", "points": 2304 }, ..]\n
//!   for each of these: points × (xx yy zz xy yz xz p θ), f64, little-endian
//! ```
//!
//! The plastic strain ε_p, the equivalent one p and the change of volume θ that the cell does not resist stand at the points of
//! integration of the stiffness, block by block of the mesh and cell by cell.

use crate::model::{Past, Solution};
use serde::{Deserialize, Serialize};

/// Name of the file.
pub const STATE: &str = "state.bin";

/// Its first bytes.
pub const STATE_HEAD: &str = "dotyk state 1\n";

/// Numbers of a point.
const NUMBERS: usize = 8;

/// The owner of the numbers.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    step: usize,
    body: String,
    points: usize,
}

/// Its content; `None` where no material yields.
pub fn state<const D: usize>(steps: &[Solution<D>]) -> Option<Vec<u8>> {
    let (mut entries, mut numbers) = (Vec::new(), Vec::new());
    for (step, solution) in steps.iter().enumerate() {
        for body in &solution.bodies {
            let Some(points) = &body.inelastic else {
                continue;
            };
            entries.push(Entry {
                step: step + 1,
                body: body.name.clone(),
                points: points.len(),
            });
            let values = points.as_flattened().iter();
            numbers.extend(values.flat_map(|value| value.to_le_bytes()));
        }
    }
    // names and numbers: nothing here can fail to serialise
    let head = serde_json::to_string(&entries).unwrap_or_default();
    let file = [format!("{STATE_HEAD}{head}\n").into_bytes(), numbers].concat();
    (!entries.is_empty()).then_some(file)
}

/// Adds the plastic strains of a file to these steps; entries of other steps are skipped.
///
/// Errors: another kind of file.
pub fn read_state<const D: usize>(file: &[u8], past: &mut [Past<D>]) -> Result<(), String> {
    let broken = || {
        format!(
            "is no state of a run: it is cut off, holds what is no number, or does not begin with `{}`",
            STATE_HEAD.trim_end()
        )
    };
    let rest = file
        .strip_prefix(STATE_HEAD.as_bytes())
        .ok_or_else(broken)?;
    let end = rest
        .iter()
        .position(|&byte| byte == b'\n')
        .ok_or_else(broken)?;
    let entries: Vec<Entry> = serde_json::from_slice(&rest[..end]).map_err(|_| broken())?;
    let mut numbers = rest[end + 1..].chunks_exact(8);
    for entry in entries {
        let mut point = || -> Option<[f64; NUMBERS]> {
            let mut values = [0.0; NUMBERS];
            for value in &mut values {
                *value = f64::from_le_bytes(numbers.next()?.try_into().ok()?);
            }
            Some(values).filter(|values| values.iter().all(|value| value.is_finite()))
        };
        let points = (0..entry.points).map(|_| point());
        let points = points.collect::<Option<Vec<_>>>().ok_or_else(broken)?;
        let step = entry
            .step
            .checked_sub(1)
            .and_then(|step| past.get_mut(step));
        let bodies = step.into_iter().flat_map(|step| &mut step.bodies);
        for body in bodies.filter(|body| body.name == entry.body) {
            body.yielded = Some(points.clone());
        }
    }
    match numbers.next() {
        None => Ok(()),
        Some(_) => Err(broken()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::PastBody;
    use crate::output::tunnel;

    #[test]
    fn a_state_comes_back_and_a_broken_one_does_not() {
        let (_, mut solution) = tunnel::solved();
        assert_eq!(state(std::slice::from_ref(&solution)), None);
        let points = vec![[0.5; NUMBERS], [-1e-300; NUMBERS], [0.0; NUMBERS]];
        solution.bodies[1].inelastic = Some(points.clone());
        let file = state(std::slice::from_ref(&solution)).unwrap();
        let mut past = vec![Past::from(&solution)];
        past[0].bodies.iter_mut().for_each(|b| b.yielded = None);
        read_state(&file, &mut past).unwrap();
        let of = |b: &PastBody| b.yielded.clone();
        assert_eq!(
            past[0].bodies.iter().map(of).collect::<Vec<_>>()[..2],
            [None, Some(points)]
        );
        for cut in [0, 5, 20, file.len() - 8, file.len() - 1] {
            assert!(read_state(&file[..cut], &mut past).is_err(), "{cut}");
        }
        assert!(read_state(&[file, vec![0; 8]].concat(), &mut past).is_err());
    }
}
