//! Matrices as text in the Matrix Market exchange format, which MATLAB, Julia, SciPy and others read; numbers read back to the
//! same bits, indices count from 1.
//!
//! Format: R. F. Boisvert, R. Pozo, K. A. Remington, The Matrix Market exchange formats, NISTIR 5935 (1996).

use std::io::{self, Write};

/// All entries of a (rows, columns) matrix, by columns.
pub fn array(
    out: &mut dyn Write,
    [rows, columns]: [usize; 2],
    entry: impl Fn(usize, usize) -> f64,
) -> io::Result<()> {
    writeln!(out, "%%MatrixMarket matrix array real general")?;
    writeln!(out, "{rows} {columns}")?;
    for j in 0..columns {
        for i in 0..rows {
            writeln!(out, "{:e}", entry(i, j))?;
        }
    }
    Ok(())
}

/// The entries (row, column, value) of a (rows, columns) matrix that are stored, `count` in number.
pub fn coordinate(
    out: &mut dyn Write,
    [rows, columns]: [usize; 2],
    count: usize,
    entries: impl Iterator<Item = (usize, usize, f64)>,
) -> io::Result<()> {
    writeln!(out, "%%MatrixMarket matrix coordinate real general")?;
    writeln!(out, "{rows} {columns} {count}")?;
    for (i, j, value) in entries {
        writeln!(out, "{} {} {value:e}", i + 1, j + 1)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_written_by_columns_and_by_entries() {
        let text = |write: &dyn Fn(&mut Vec<u8>) -> io::Result<()>| {
            let mut bytes = Vec::new();
            write(&mut bytes).unwrap();
            String::from_utf8(bytes).unwrap()
        };
        let dense = text(&|out| array(out, [2, 2], |i, j| 0.1 + 10.0 * i as f64 + j as f64));
        let expected =
            "%%MatrixMarket matrix array real general\n2 2\n1e-1\n1.01e1\n1.1e0\n1.11e1\n";
        assert_eq!(dense, expected);
        let sparse = text(&|out| coordinate(out, [2, 3], 1, [(1, 2, -1.0 / 3.0)].into_iter()));
        let expected =
            "%%MatrixMarket matrix coordinate real general\n2 3 1\n2 3 -3.333333333333333e-1\n";
        assert_eq!(sparse, expected);
    }
}
