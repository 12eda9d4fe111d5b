//! HDF5 files of the Friction Contact Library.
//!
//! | Group | Holds |
//! |---|---|
//! | `fclib_local` | `spacedim`, `W`, `vectors/q`, `vectors/mu` |
//! | `fclib_global` | `spacedim`, `M`, `H`, `vectors/f`, `vectors/w`, `vectors/mu`: W = HᵀM⁻¹H, q = HᵀM⁻¹f + w |
//!
//! A matrix has `m` rows, `n` columns, `x`, `i`, `p` and `nz`: −1 compressed columns (p begins of columns, i rows),
//! −2 compressed rows (p begins of rows, i columns), else the number of triplets (i rows, p columns). Numbers from 0.
//! Bilateral rows (`R`, `G`) are not treated. Solutions in the files are not read: many are zeros.

use crate::condense::{Global, assembled, condense};
use crate::problem::Problem;
use dotyk::linalg::SparseMatrix;
use hdf5_pure::File;

/// The problem in `file`; errors in words.
pub fn parse(file: &File) -> Result<Problem, String> {
    let has = |path: &str| file.dataset(path).is_ok();
    for bilateral in ["fclib_local/R/m", "fclib_global/G/m"] {
        if has(bilateral) {
            return Err("it has bilateral rows, which are not treated".to_string());
        }
    }
    if has("fclib_local/spacedim") {
        return Problem::new(
            integer(file, "fclib_local/spacedim")?,
            matrix(file, "fclib_local/W")?,
            reals(file, "fclib_local/vectors/q")?,
            reals(file, "fclib_local/vectors/mu")?,
        );
    }
    let global = Global {
        mass: matrix(file, "fclib_global/M")?,
        rows: matrix(file, "fclib_global/H")?,
        load: reals(file, "fclib_global/vectors/f")?,
        velocity: reals(file, "fclib_global/vectors/w")?,
    };
    let (dimension, friction) = (
        integer(file, "fclib_global/spacedim")?,
        reals(file, "fclib_global/vectors/mu")?,
    );
    let (matrix, free) = condense(&global)?;
    Problem::new(dimension, matrix, free, friction)
}

fn reals(file: &File, path: &str) -> Result<Vec<f64>, String> {
    let dataset = file
        .dataset(path)
        .map_err(|error| format!("{path}: {error}"))?;
    dataset
        .read_f64()
        .map_err(|error| format!("{path}: {error}"))
}

fn integers(file: &File, path: &str) -> Result<Vec<i32>, String> {
    let dataset = file
        .dataset(path)
        .map_err(|error| format!("{path}: {error}"))?;
    dataset
        .read_i32()
        .map_err(|error| format!("{path}: {error}"))
}

/// Numbers from 0.
fn indices(file: &File, path: &str) -> Result<Vec<usize>, String> {
    let numbers = integers(file, path)?.into_iter();
    let index = |k| usize::try_from(k).map_err(|_| format!("{path} holds the negative number {k}"));
    numbers.map(index).collect()
}

fn integer(file: &File, path: &str) -> Result<usize, String> {
    let first = indices(file, path)?.first().copied();
    first.ok_or(format!("{path} is empty"))
}

fn matrix(file: &File, path: &str) -> Result<SparseMatrix, String> {
    let part = |name: &str| format!("{path}/{name}");
    let (rows, columns) = (integer(file, &part("m"))?, integer(file, &part("n"))?);
    let kind = integers(file, &part("nz"))?;
    let kind = *kind.first().ok_or(format!("{path}/nz is empty"))?;
    let (i, p) = (indices(file, &part("i"))?, indices(file, &part("p"))?);
    let x = reals(file, &part("x"))?;
    let entries = match usize::try_from(kind) {
        Ok(count) => triplets(&i, &p, &x, count),
        Err(_) => compressed(&i, &p, &x, kind == -2),
    };
    let entries = entries.ok_or(format!("{path} is shorter than it says"))?;
    assembled(rows, columns, &entries).map_err(|error| format!("{path}: {error}"))
}

type Entries = Vec<(usize, usize, f64)>;

fn triplets(i: &[usize], p: &[usize], x: &[f64], count: usize) -> Option<Entries> {
    let (i, p, x) = (i.get(..count)?, p.get(..count)?, x.get(..count)?);
    let places = i.iter().zip(p);
    Some(places.zip(x).map(|((&i, &j), &x)| (i, j, x)).collect())
}

fn compressed(i: &[usize], p: &[usize], x: &[f64], by_rows: bool) -> Option<Entries> {
    let mut entries = Vec::with_capacity(x.len());
    for (line, ends) in p.windows(2).enumerate() {
        let others = i.get(ends[0]..ends[1])?.iter();
        let values = x.get(ends[0]..ends[1])?;
        entries.extend(others.zip(values).map(|(&other, &x)| {
            if by_rows {
                (line, other, x)
            } else {
                (other, line, x)
            }
        }));
    }
    Some(entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdf5_pure::FileBuilder;

    /// One way to store a matrix: m, n, nz, i, p, x.
    type Stored = (i32, i32, i32, Vec<i32>, Vec<i32>, Vec<f64>);

    fn file(top: &str, matrices: &[(&str, &Stored)], vectors: &[(&str, &[f64])]) -> File {
        let mut builder = FileBuilder::new();
        let mut group = builder.create_group(top);
        group.create_dataset("spacedim").with_i32_data(&[2]);
        for (name, (m, n, nz, i, p, x)) in matrices {
            let mut matrix = group.create_group(name);
            for (name, value) in [("m", m), ("n", n), ("nz", nz)] {
                matrix.create_dataset(name).with_i32_data(&[*value]);
            }
            matrix.create_dataset("i").with_i32_data(i);
            matrix.create_dataset("p").with_i32_data(p);
            matrix.create_dataset("x").with_f64_data(x);
            group.add_group(matrix.finish());
        }
        let mut list = group.create_group("vectors");
        for (name, values) in vectors {
            list.create_dataset(name).with_f64_data(values);
        }
        group.add_group(list.finish());
        builder.add_group(group.finish());
        File::from_bytes(builder.finish().unwrap()).unwrap()
    }

    /// [2 1; 0 3] in every storage.
    fn stored() -> [Stored; 3] {
        [
            (2, 2, 3, vec![0, 1, 0], vec![1, 1, 0], vec![1.0, 3.0, 2.0]),
            (2, 2, -1, vec![0, 0, 1], vec![0, 1, 3], vec![2.0, 1.0, 3.0]),
            (2, 2, -2, vec![0, 1, 1], vec![0, 2, 3], vec![2.0, 1.0, 3.0]),
        ]
    }

    #[test]
    fn every_storage_of_a_local_problem_is_the_same() {
        for stored in stored() {
            let vectors: [(&str, &[f64]); 2] = [("q", &[-1.0, 0.5]), ("mu", &[0.3])];
            let problem = parse(&file("fclib_local", &[("W", &stored)], &vectors)).unwrap();
            let rows = [0, 1].map(|i| problem.matrix.row(i).collect::<Vec<_>>());
            assert_eq!(rows[0], [(0, 2.0), (1, 1.0)]);
            assert_eq!(rows[1], [(1, 3.0)]);
            assert_eq!(problem.free, [-1.0, 0.5]);
            assert_eq!(problem.friction, [0.3]);
        }
    }

    #[test]
    fn global_problem_is_condensed() {
        let mass = (2, 2, 2, vec![0, 1], vec![0, 1], vec![2.0, 4.0]);
        let rows = (2, 2, -2, vec![1, 0], vec![0, 1, 2], vec![1.0, 1.0]);
        let vectors: [(&str, &[f64]); 3] =
            [("f", &[2.0, 4.0]), ("w", &[0.25, 0.5]), ("mu", &[0.3])];
        let file = file("fclib_global", &[("M", &mass), ("H", &rows)], &vectors);
        let problem = parse(&file).unwrap();
        let diagonal: Vec<f64> = (0..2)
            .map(|i| problem.matrix.row(i).find(|e| e.0 == i).unwrap().1)
            .collect();
        assert!((diagonal[0] - 0.25).abs() < 1e-15 && (diagonal[1] - 0.5).abs() < 1e-15);
        assert!((problem.free[0] - 1.25).abs() < 1e-15 && (problem.free[1] - 1.5).abs() < 1e-15);
    }

    #[test]
    fn what_cannot_be_treated_is_told() {
        let [stored, ..] = stored();
        let vectors: [(&str, &[f64]); 2] = [("q", &[-1.0, 0.5]), ("mu", &[0.3])];
        let bilateral = file("fclib_local", &[("W", &stored), ("R", &stored)], &vectors);
        assert!(parse(&bilateral).unwrap_err().contains("bilateral"));
        let other = file("other", &[], &[]);
        assert!(parse(&other).unwrap_err().contains("fclib_global"));
        let outside = (2, 2, 1, vec![2], vec![0], vec![1.0]);
        let outside = file("fclib_local", &[("W", &outside)], &vectors);
        assert!(parse(&outside).unwrap_err().contains("outside"));
    }
}
