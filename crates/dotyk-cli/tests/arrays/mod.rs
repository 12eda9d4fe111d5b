//! Readers of what `dotyk export` writes, which share nothing with its writers: NumPy archives and Matrix Market text.

use std::collections::BTreeMap;
use std::path::Path;

/// A matrix of numbers by rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    pub rows: usize,
    pub columns: usize,
    pub entries: Vec<f64>,
}

impl Matrix {
    fn zeros(rows: usize, columns: usize) -> Self {
        let entries = vec![0.0; rows * columns];
        Self {
            rows,
            columns,
            entries,
        }
    }

    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[i * self.columns + j]
    }

    /// Its product with a vector.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.columns);
        let row = |i: usize| (0..self.columns).map(|j| self.at(i, j) * x[j]).sum();
        (0..self.rows).map(row).collect()
    }

    pub fn transposed(&self) -> Self {
        let mut other = Self::zeros(self.columns, self.rows);
        for i in 0..self.rows {
            for j in 0..self.columns {
                other.entries[j * self.rows + i] = self.at(i, j);
            }
        }
        other
    }
}

/// The matrix of a Matrix Market file.
pub fn market(path: &Path) -> Matrix {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let dense = match lines.next().unwrap() {
        "%%MatrixMarket matrix array real general" => true,
        "%%MatrixMarket matrix coordinate real general" => false,
        other => panic!("{other}"),
    };
    let counts: Vec<usize> = lines
        .next()
        .unwrap()
        .split(' ')
        .map(|n| n.parse().unwrap())
        .collect();
    let mut matrix = Matrix::zeros(counts[0], counts[1]);
    let mut read = 0;
    for line in lines {
        let words: Vec<&str> = line.split(' ').collect();
        let (i, j) = match dense {
            true => (read % counts[0], read / counts[0]),
            false => {
                let index = |k: usize| words[k].parse::<usize>().unwrap() - 1;
                (index(0), index(1))
            }
        };
        matrix.entries[i * counts[1] + j] = words.last().unwrap().parse().unwrap();
        read += 1;
    }
    assert_eq!(
        read,
        if dense {
            counts[0] * counts[1]
        } else {
            counts[2]
        }
    );
    matrix
}

/// The arrays of a NumPy archive.
pub struct Archive {
    files: BTreeMap<String, Vec<u8>>,
}

fn number(bytes: &[u8]) -> usize {
    bytes
        .iter()
        .rev()
        .fold(0, |sum, byte| sum << 8 | usize::from(*byte))
}

impl Archive {
    /// Reads one file after the other, as they are stored.
    pub fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let (mut files, mut at) = (BTreeMap::new(), 0);
        while bytes[at..at + 4] == *b"PK\x03\x04" {
            assert_eq!(number(&bytes[at + 8..at + 10]), 0, "stored, not compressed");
            let size = number(&bytes[at + 18..at + 22]);
            let name = at + 30..at + 30 + number(&bytes[at + 26..at + 28]);
            let start = name.end + number(&bytes[at + 28..at + 30]);
            let name = String::from_utf8(bytes[name].to_vec()).unwrap();
            files.insert(name, bytes[start..start + size].to_vec());
            at = start + size;
        }
        Self { files }
    }

    pub fn has(&self, name: &str) -> bool {
        self.files.contains_key(&format!("{name}.npy"))
    }

    /// Description and entries of an array.
    fn parts(&self, name: &str) -> (String, &[u8]) {
        let file = &self.files[&format!("{name}.npy")];
        assert_eq!(file[..8], *b"\x93NUMPY\x01\0");
        let start = 10 + number(&file[8..10]);
        let head = String::from_utf8(file[10..start].to_vec()).unwrap();
        (head, &file[start..])
    }

    pub fn numbers(&self, name: &str) -> Vec<f64> {
        let (head, bytes) = self.parts(name);
        assert!(head.contains("'<f8'"), "{head}");
        let entries = bytes.chunks_exact(8);
        entries
            .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
            .collect()
    }

    pub fn counts(&self, name: &str) -> Vec<usize> {
        let (head, bytes) = self.parts(name);
        assert!(head.contains("'<i8'"), "{head}");
        bytes.chunks_exact(8).map(number).collect()
    }

    pub fn words(&self, name: &str) -> Vec<String> {
        let (head, bytes) = self.parts(name);
        let width = head.split("<U").nth(1).unwrap().split('\'').next().unwrap();
        let width: usize = width.parse().unwrap();
        let word = |bytes: &[u8]| {
            let letters = bytes.chunks_exact(4).map(|c| number(c) as u32);
            let letters = letters.filter(|c| *c != 0);
            letters.map(|c| char::from_u32(c).unwrap()).collect()
        };
        bytes.chunks_exact(4 * width).map(word).collect()
    }

    /// A matrix with its zeros, or from its three parts.
    pub fn matrix(&self, name: &str) -> Matrix {
        if !self.has(name) {
            let part = |part: &str| self.counts(&format!("{name}_{part}"));
            let shape = part("shape");
            let (starts, index) = (part("indptr"), part("indices"));
            let values = self.numbers(&format!("{name}_data"));
            let mut matrix = Matrix::zeros(shape[0], shape[1]);
            for i in 0..shape[0] {
                for k in starts[i]..starts[i + 1] {
                    matrix.entries[i * shape[1] + index[k]] = values[k];
                }
            }
            return matrix;
        }
        let (head, _) = self.parts(name);
        let shape = head.split("'shape': (").nth(1).unwrap();
        let shape = shape.split(')').next().unwrap().split(", ");
        let shape: Vec<usize> = shape.filter_map(|n| n.parse().ok()).collect();
        let entries = self.numbers(name);
        let by_columns = head.contains("'fortran_order': True");
        let (rows, columns) = match by_columns {
            true => (shape[1], shape[0]),
            false => (shape[0], shape[1]),
        };
        let matrix = Matrix {
            rows,
            columns,
            entries,
        };
        match by_columns {
            true => matrix.transposed(),
            false => matrix,
        }
    }
}
