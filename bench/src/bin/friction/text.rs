//! Text files of friction problems (`.dat`, `.dat.gz`).
//!
//! ```text
//!   dimension, contacts, W, q, μ                     local problem
//!   dimension, contacts, M, H, f, w, μ               global problem: W = HᵀM⁻¹H, q = HᵀM⁻¹f + w
//! ```
//!
//! A matrix is its storage, its rows and its columns, then
//!
//! | Storage | What follows |
//! |---|---|
//! | 0 | rows, columns, the entries row by row |
//! | 1 | blocks, block rows, block columns, cumulative rows, cumulative columns, lengths of two indices, the indices (begin of each block row; block column of each block), then each block: its number, its entries column by column |
//! | 2 | 2 (compressed columns) or 1 (triplets), then the printout of CSparse: `col j : locations a to b` and `i : x`, or `i j : x`; numbers from 0 |
//!
//! White space separates, line ends have no meaning. A flag for a following solution may end the file. A problem is global if the
//! first matrix is followed by a matrix with the same number of rows and a column per contact unknown.
//!
//! As described in the sources of Siconos (`NumericsMatrix`, `FrictionContactProblem`).

use crate::condense::{Global, assembled, condense};
use crate::problem::Problem;
use dotyk::linalg::SparseMatrix;
use std::str::FromStr;

/// The problem in `text`; errors in words.
pub fn parse(text: &str) -> Result<Problem, String> {
    let mut words = Words {
        all: text.split_whitespace().collect(),
        at: 0,
    };
    let (dimension, contacts): (usize, usize) = (words.number()?, words.number()?);
    if !(2..=3).contains(&dimension) {
        return Err(format!(
            "not a friction problem: it begins with the dimension {dimension}"
        ));
    }
    let first = matrix(&mut words)?;
    let unknowns = dimension * contacts;
    if words.matrix_follows(first.rows(), unknowns) {
        let rows = matrix(&mut words)?;
        let global = Global {
            load: words.numbers(rows.rows())?,
            velocity: words.numbers(rows.cols())?,
            mass: first,
            rows,
        };
        let friction = words.numbers(contacts)?;
        let (matrix, free) = condense(&global)?;
        return Problem::new(dimension, matrix, free, friction);
    }
    let free = words.numbers(first.rows())?;
    let friction = words.numbers(contacts)?;
    Problem::new(dimension, first, free, friction)
}

/// The words of a text, one after the other.
struct Words<'a> {
    all: Vec<&'a str>,
    at: usize,
}

impl<'a> Words<'a> {
    fn word(&mut self) -> Result<&'a str, String> {
        let word = self.all.get(self.at).ok_or("the file ends too early")?;
        self.at += 1;
        Ok(word)
    }

    fn number<T: FromStr>(&mut self) -> Result<T, String> {
        let word = self.word()?;
        word.trim_end_matches(',')
            .parse()
            .map_err(|_| format!("word {} is {word:?}, not a number", self.at))
    }

    fn numbers<T: FromStr>(&mut self, count: usize) -> Result<Vec<T>, String> {
        (0..count).map(|_| self.number()).collect()
    }

    /// The next words may be a matrix of these sizes.
    fn matrix_follows(&self, rows: usize, columns: usize) -> bool {
        let sizes = [rows.to_string(), columns.to_string()];
        match self.all.get(self.at..self.at + 3) {
            Some(next) => ["0", "1", "2"].contains(&next[0]) && next[1..] == sizes,
            None => false,
        }
    }
}

fn matrix(words: &mut Words) -> Result<SparseMatrix, String> {
    let (storage, rows, columns): (usize, usize, usize) =
        (words.number()?, words.number()?, words.number()?);
    let matrix = match storage {
        0 => dense(words)?,
        1 => blocks(words)?,
        2 => printed(words)?,
        other => return Err(format!("storage {other} is none of 0, 1, 2")),
    };
    if (matrix.rows(), matrix.cols()) != (rows, columns) {
        return Err(format!(
            "a matrix of {rows} by {columns} is announced, one of {} by {} follows",
            matrix.rows(),
            matrix.cols()
        ));
    }
    Ok(matrix)
}

fn dense(words: &mut Words) -> Result<SparseMatrix, String> {
    let (rows, columns): (usize, usize) = (words.number()?, words.number()?);
    let entries: Vec<f64> = words.numbers(rows * columns)?;
    let place = |(k, &x): (usize, &f64)| (k / columns, k % columns, x);
    let triplets: Vec<_> = entries
        .iter()
        .enumerate()
        .filter(|(_, x)| **x != 0.0)
        .map(place)
        .collect();
    assembled(rows, columns, &triplets)
}

fn blocks(words: &mut Words) -> Result<SparseMatrix, String> {
    let (count, rows, columns): (usize, usize, usize) =
        (words.number()?, words.number()?, words.number()?);
    let row_ends: Vec<usize> = words.numbers(rows)?;
    let column_ends: Vec<usize> = words.numbers(columns)?;
    let (begins, places): (usize, usize) = (words.number()?, words.number()?);
    let begins: Vec<usize> = words.numbers(begins)?;
    let places: Vec<usize> = words.numbers(places)?;
    let extent = |ends: &[usize], k: usize| -> Result<(usize, usize), String> {
        let end = ends.get(k).ok_or(format!("there is no block row {k}"))?;
        let begin = if k == 0 { 0 } else { ends[k - 1] };
        let length = end.checked_sub(begin);
        Ok((begin, length.ok_or("sizes of blocks do not ascend")?))
    };
    let mut triplets = Vec::new();
    for _ in 0..count {
        let block: usize = words.number()?;
        let column = *places
            .get(block)
            .ok_or(format!("block {block} has no column"))?;
        let row = begins
            .partition_point(|&begin| begin <= block)
            .saturating_sub(1);
        let (first_row, height) = extent(&row_ends, row)?;
        let (first_column, width) = extent(&column_ends, column)?;
        for j in 0..width {
            for i in 0..height {
                triplets.push((first_row + i, first_column + j, words.number()?));
            }
        }
    }
    let last = |ends: &[usize]| ends.last().copied().unwrap_or(0);
    assembled(last(&row_ends), last(&column_ends), &triplets)
}

fn printed(words: &mut Words) -> Result<SparseMatrix, String> {
    let by_triplets = words.number::<usize>()? == 1;
    let sizes = loop {
        let word = words.word()?;
        if let Some((rows, columns)) = word.trim_end_matches(',').split_once("-by-") {
            break (rows.parse().ok()).zip(columns.parse().ok());
        }
    };
    let (rows, columns) = sizes.ok_or("the sizes of the printed matrix are not numbers")?;
    while words.word()? != "nnz:" {}
    let count: usize = words.number()?;
    if words.all.get(words.at) == Some(&"1-norm:") {
        words.at += 2;
    }
    let mut triplets = Vec::with_capacity(count);
    let mut column = 0;
    while triplets.len() < count {
        let word = words.word()?;
        if word == "col" {
            column = words.number()?;
            words.numbers::<String>(5)?;
            continue;
        }
        let row = word
            .parse()
            .map_err(|_| format!("{word:?} is no number of a row"))?;
        let column = if by_triplets { words.number()? } else { column };
        words.word()?;
        triplets.push((row, column, words.number()?));
    }
    // Empty columns at the end.
    while words.all.get(words.at) == Some(&"col") {
        words.at += 7;
    }
    assembled(rows, columns, &triplets)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DENSE: &str = "0 4 4 4\t4\n 2. 0. .5 0.\n0. 3. 0 0\n 0.25 0 2e0 0\n0 0 0 3";
    const BLOCKS: &str = "1 4 4 4 2 2\n2 4 \n2 4\n3 4 \n0 2 4 \n0 1 0 1\n\
        0 2 0 0 3\n1 .5 0 0 0\n2 .25 0 0 0\n3 2 0 0 3";
    const COLUMNS: &str = "2 4 4 2 CSparse Version 3.1.9, May 4, 2016.  Copyright (c) A\n\
        4-by-4, nzmax: 9 nnz: 6, 1-norm: 3\n\
        col 0 : locations 0 to 1\n 0 : 2\n 2 : .25\n col 1 : locations 2 to 2\n 1 : 3\n\
        col 2 : locations 3 to 4\n 0 : .5\n 2 : 2\n col 3 : locations 5 to 5\n 3 : 3";
    const TRIPLETS: &str = "2 4 4 1 CSparse Version 3.1.9, May 4, 2016.\ntriplet: 4-by-4, nzmax: 6 nnz: 6\n\
        0 0 : 2\n 3 3 : 3\n 2 0 : .25\n 1 1 : 3\n 0 2 : .5\n 2 2 : 2";

    fn entries(matrix: &SparseMatrix) -> Vec<Vec<f64>> {
        let mut all = vec![vec![0.0; matrix.cols()]; matrix.rows()];
        for (i, row) in all.iter_mut().enumerate() {
            matrix.row(i).for_each(|(j, x)| row[j] += x);
        }
        all
    }

    #[test]
    fn every_storage_gives_the_same_problem() {
        let expected = [
            [2.0, 0.0, 0.5, 0.0],
            [0.0, 3.0, 0.0, 0.0],
            [0.25, 0.0, 2.0, 0.0],
            [0.0, 0.0, 0.0, 3.0],
        ];
        for (matrix, end) in [
            (DENSE, ""),
            (BLOCKS, "0"),
            (COLUMNS, "\n0\n"),
            (TRIPLETS, ""),
        ] {
            let text = format!("2\n2\n\n{matrix}\n -1 2 -3 4e0\n 0.5 0.25\n{end}");
            let problem = parse(&text).unwrap();
            assert_eq!(entries(&problem.matrix), expected);
            assert_eq!(problem.free, [-1.0, 2.0, -3.0, 4.0]);
            assert_eq!(problem.friction, [0.5, 0.25]);
            assert_eq!((problem.dimension, problem.size()), (2, 4));
        }
    }

    #[test]
    fn dimension_three_is_read() {
        let text = "3 1 0 3 3 3 3 1 2 3 4 5 6 7 8 9 -1 -2 -3 .7";
        let problem = parse(text).unwrap();
        assert_eq!(entries(&problem.matrix)[1], [4.0, 5.0, 6.0]);
        assert_eq!(problem.friction, [0.7]);
    }

    #[test]
    fn global_problem_is_condensed() {
        // Two masses 2 and 4 that hold one contact: u = v₁ − v₂ + w, so that W = 1/2 + 1/4 in both directions.
        let mass = "0 4 4 4 4  2 0 0 0  0 2 0 0  0 0 4 0  0 0 0 4";
        let rows = "2 4 2 1 CSparse\n triplet: 4-by-2, nzmax: 4 nnz: 4\n 0 0 : 1 1 1 : 1 2 0 : -1 3 1 : -1";
        let text = format!("2 1 {mass} {rows} 2 4 8 16  0.5 0.25  0.3 0");
        let problem = parse(&text).unwrap();
        let found = entries(&problem.matrix);
        assert!((found[0][0] - 0.75).abs() < 1e-15 && (found[1][1] - 0.75).abs() < 1e-15);
        assert!(found[0][1].abs() < 1e-15 && found[1][0].abs() < 1e-15);
        // Hᵀ M⁻¹ f = (1 − 2, 2 − 4).
        assert!((problem.free[0] + 0.5).abs() < 1e-15 && (problem.free[1] + 1.75).abs() < 1e-15);
        assert_eq!(problem.friction, [0.3]);
    }

    #[test]
    fn what_is_no_problem_is_told() {
        let message = |text: &str| parse(text).unwrap_err();
        assert!(message("4 2 2 3 6 3 6").contains("dimension 4"));
        assert!(message("2 2 0 4 4 4 4 1 2").contains("too early"));
        assert!(message("2 1 0 2 2 2 2 1 0 zero 1 0 0 .3").contains("\"zero\""));
        assert!(message("2 1 5 2 2").contains("storage 5"));
        assert!(message("2 1 0 3 3 2 2 1 0 0 1").contains("announced"));
        assert!(message("2 1 0 2 2 2 2 1 0 0 inf 1 2 .3").contains("finite"));
    }
}
