//! Arrays as NumPy reads them: a `.npz` is a ZIP archive of `.npy` files, stored as they are.
//!
//! Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>, version 1.0; ZIP as in PKWARE's APPNOTE,
//! without compression. Numbers are little-endian.

use flate2::Crc;
use std::io::{self, Write};

/// Writes the entries of an array, in their order.
type Entries<'a> = dyn Fn(&mut dyn Write) -> io::Result<()> + 'a;

/// An array of an archive.
struct Array<'a> {
    name: String,
    /// The `.npy` file up to its entries.
    header: Vec<u8>,
    /// Bytes of its entries.
    size: usize,
    entries: Box<Entries<'a>>,
}

/// Named arrays for one file.
#[derive(Default)]
pub struct Archive<'a> {
    arrays: Vec<Array<'a>>,
}

impl<'a> Archive<'a> {
    /// Numbers in the order of C, last index first.
    pub fn floats(&mut self, name: &str, shape: &[usize], values: Vec<f64>) {
        self.matrix(name, shape, false, move || values.clone().into_iter());
    }

    /// Numbers in the order of C, or by columns.
    pub fn matrix<I: Iterator<Item = f64>>(
        &mut self,
        name: &str,
        shape: &[usize],
        by_columns: bool,
        values: impl Fn() -> I + 'a,
    ) {
        let write = move |out: &mut dyn Write| {
            let mut values = values();
            values.try_for_each(|value| out.write_all(&value.to_le_bytes()))
        };
        self.add(name, "<f8", shape, by_columns, 8, Box::new(write));
    }

    /// Counts and indices.
    pub fn integers(&mut self, name: &str, values: Vec<usize>) {
        let length = values.len();
        let write = move |out: &mut dyn Write| {
            let mut bytes = values.iter().map(|&value| (value as i64).to_le_bytes());
            bytes.try_for_each(|bytes| out.write_all(&bytes))
        };
        self.add(name, "<i8", &[length], false, 8, Box::new(write));
    }

    /// Words.
    pub fn words(&mut self, name: &str, values: Vec<&'a str>) {
        let longest = values.iter().map(|word| word.chars().count());
        let width = longest.max().unwrap_or(0).max(1);
        let length = values.len();
        let write = move |out: &mut dyn Write| {
            for word in &values {
                let padding = std::iter::repeat('\0');
                let mut letters = word.chars().chain(padding).take(width);
                letters.try_for_each(|c| out.write_all(&u32::from(c).to_le_bytes()))?;
            }
            Ok(())
        };
        let kind = format!("<U{width}");
        self.add(name, &kind, &[length], false, 4 * width, Box::new(write));
    }

    fn add(
        &mut self,
        name: &str,
        kind: &str,
        shape: &[usize],
        by_columns: bool,
        item: usize,
        entries: Box<Entries<'a>>,
    ) {
        self.arrays.push(Array {
            name: format!("{name}.npy"),
            header: header(kind, shape, by_columns),
            size: item * shape.iter().product::<usize>(),
            entries,
        });
    }

    /// The whole file.
    ///
    /// Errors: of the writer; more than the format can hold, 4 GB.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut directory = Vec::new();
        let mut offset = 0usize;
        for array in &self.arrays {
            let size = array.header.len() + array.size;
            let mut sum = Checksum(Crc::new());
            sum.write_all(&array.header)?;
            (array.entries)(&mut sum)?;
            let about = about(sum.0.sum(), fits(size)?, &array.name)?;
            let name = array.name.as_bytes();
            out.write_all(b"PK\x03\x04")?;
            out.write_all(&about)?;
            out.write_all(name)?;
            out.write_all(&array.header)?;
            (array.entries)(out)?;
            directory.extend(b"PK\x01\x02\x14\0");
            directory.extend(&about);
            // no comment, first disk, no attributes
            directory.extend([0; 10]);
            directory.extend(fits(offset)?.to_le_bytes());
            directory.extend(name);
            offset += 4 + about.len() + name.len() + size;
        }
        out.write_all(&directory)?;
        let count = (self.arrays.len() as u16).to_le_bytes();
        out.write_all(b"PK\x05\x06\0\0\0\0")?;
        out.write_all(&[count, count].concat())?;
        out.write_all(&fits(directory.len())?.to_le_bytes())?;
        out.write_all(&fits(offset)?.to_le_bytes())?;
        out.write_all(&[0, 0])
    }
}

/// The common part of both headers of a stored file, up to its name.
fn about(sum: u32, size: u32, name: &str) -> io::Result<Vec<u8>> {
    // version 2.0, no flags, stored, and a fixed date: 1980-01-01
    let mut about = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
    about.extend(sum.to_le_bytes());
    about.extend(size.to_le_bytes());
    about.extend(size.to_le_bytes());
    let length = u16::try_from(name.len()).map_err(io::Error::other)?;
    about.extend(length.to_le_bytes());
    about.extend([0, 0]);
    Ok(about)
}

fn fits(bytes: usize) -> io::Result<u32> {
    u32::try_from(bytes).map_err(|_| io::Error::other("more than 4 GB in one archive"))
}

/// The head of a `.npy` file: its length is a multiple of 64.
fn header(kind: &str, shape: &[usize], by_columns: bool) -> Vec<u8> {
    let order = if by_columns { "True" } else { "False" };
    let sizes: String = shape.iter().map(|size| format!("{size}, ")).collect();
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': ({sizes}), }}");
    while (10 + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

/// A writer that computes a checksum.
struct Checksum(Crc);

impl Write for Checksum {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn head_is_the_one_of_the_format() {
        let head = header("<f8", &[2, 3], true);
        assert_eq!(head.len() % 64, 0);
        assert_eq!(head[..10], *b"\x93NUMPY\x01\0\x76\0");
        let text = std::str::from_utf8(&head[10..]).unwrap();
        let expected = "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3, ), }";
        assert!(
            text.starts_with(expected) && text.ends_with(" \n"),
            "{text}"
        );
        assert!(String::from_utf8_lossy(&header("<i8", &[4], false)).contains("(4, )"));
    }

    #[test]
    fn archive_is_stored_with_sizes_sums_and_places() {
        let mut archive = Archive::default();
        archive.floats("x", &[2], vec![1.0, -0.5]);
        archive.words("law", vec!["free", "λ"]);
        archive.integers("n", vec![7]);
        let mut bytes = Vec::new();
        archive.write(&mut bytes).unwrap();
        let number = |at: usize, width: usize| {
            let bytes = bytes[at..at + width].iter().rev();
            bytes.fold(0usize, |sum, byte| sum << 8 | usize::from(*byte))
        };
        let end = bytes.len() - 22;
        assert_eq!(bytes[end..end + 4], *b"PK\x05\x06");
        assert_eq!(number(end + 10, 2), 3);
        let mut entry = number(end + 16, 4);
        assert_eq!(entry + number(end + 12, 4), end);
        let expected: [(&str, Vec<u8>); 3] = [
            (
                "x.npy",
                [1.0f64.to_le_bytes(), (-0.5f64).to_le_bytes()].concat(),
            ),
            (
                "law.npy",
                "freeλ\0\0\0"
                    .chars()
                    .flat_map(|c| u32::from(c).to_le_bytes())
                    .collect(),
            ),
            ("n.npy", 7i64.to_le_bytes().to_vec()),
        ];
        for (name, content) in expected {
            assert_eq!(bytes[entry..entry + 4], *b"PK\x01\x02");
            let (sum, size, local) = (
                number(entry + 16, 4),
                number(entry + 20, 4),
                number(entry + 42, 4),
            );
            assert_eq!(bytes[entry + 46..entry + 46 + name.len()], *name.as_bytes());
            entry += 46 + name.len();
            assert_eq!(bytes[local..local + 4], *b"PK\x03\x04");
            let start = local + 30 + name.len();
            let file = &bytes[start..start + size];
            let mut own = Crc::new();
            own.update(file);
            assert_eq!(own.sum() as usize, sum, "{name}");
            assert!(file.ends_with(&content), "{name}");
            assert_eq!((file.len() - content.len()) % 64, 0);
        }
        assert_eq!(entry, end);
    }
}
