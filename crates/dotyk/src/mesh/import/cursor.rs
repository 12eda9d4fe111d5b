//! A place in the bytes of a mesh file, from which words and numbers are read.
//!
//! The same calls read text and binary parts: [`Cursor::integer`], [`Cursor::size`] and [`Cursor::real`] take the next
//! word of a text, or the next bytes of a binary part. Every error names the line, or the section and the byte.

use crate::mesh::import::error::{FilePlace, ImportError};
use std::str::FromStr;

/// How numbers are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    Text,
    /// Bytes in this order; sizes have 4 or 8 of them.
    Binary {
        big_endian: bool,
        size: usize,
    },
}

pub(crate) struct Cursor<'b> {
    file: &'b str,
    bytes: &'b [u8],
    at: usize,
    /// Section that is being read, for messages.
    pub section: String,
    pub encoding: Encoding,
}

impl<'b> Cursor<'b> {
    pub fn new(file: &'b str, bytes: &'b [u8]) -> Self {
        Self {
            file,
            bytes,
            at: 0,
            section: "the beginning".to_string(),
            encoding: Encoding::Text,
        }
    }

    pub fn file(&self) -> String {
        self.file.to_string()
    }

    pub fn at(&self) -> usize {
        self.at
    }

    /// A mistake at a byte: by its line in a text, else by its section and offset.
    pub fn malformed(&self, at: usize, what: impl Into<String>) -> ImportError {
        let before = &self.bytes[..at.min(self.bytes.len())];
        let place = match self.encoding {
            Encoding::Text => {
                FilePlace::Line(before.iter().filter(|byte| **byte == b'\n').count() + 1)
            }
            Encoding::Binary { .. } => FilePlace::Byte {
                section: self.section.clone(),
                offset: before.len(),
            },
        };
        ImportError::Malformed {
            file: self.file(),
            place,
            what: what.into(),
        }
    }

    /// The file ends where `what` should be.
    fn truncated(&self, what: &str) -> ImportError {
        let message = format!(
            "the file ends where {what} should be, in {}: it is cut off, write it again",
            self.section
        );
        self.malformed(self.bytes.len(), message)
    }

    pub fn unsupported(&self, what: impl Into<String>) -> ImportError {
        ImportError::Unsupported {
            file: self.file(),
            what: what.into(),
        }
    }

    /// The place of the next number, for messages: behind white space in a text.
    pub fn next_at(&mut self) -> usize {
        if self.encoding == Encoding::Text {
            self.skip_space();
        }
        self.at
    }

    /// Moves to the next byte that is not white space; `false` at the end of the file.
    pub fn skip_space(&mut self) -> bool {
        let rest = &self.bytes[self.at..];
        let space = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
        self.at += space.count();
        self.at < self.bytes.len()
    }

    /// The rest of the line without white space around it; moves past it.
    pub fn line(&mut self) -> String {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|byte| *byte == b'\n');
        self.at += end.map_or(rest.len(), |end| end + 1);
        let line = &rest[..end.unwrap_or(rest.len())];
        String::from_utf8_lossy(line).trim().to_string()
    }

    /// The next word of a text; a quotation mark begins another one.
    fn word(&mut self, what: &str) -> Result<&'b [u8], ImportError> {
        if !self.skip_space() {
            return Err(self.truncated(what));
        }
        let rest = &self.bytes[self.at..];
        let ends = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'"';
        let end = rest.iter().skip(1).position(ends).map(|end| end + 1);
        let word = &rest[..end.unwrap_or(rest.len())];
        self.at += word.len();
        Ok(word)
    }

    /// The next word of a text as a number.
    pub fn parsed<T: FromStr>(&mut self, what: &str) -> Result<T, ImportError> {
        let word = self.word(what)?;
        let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        parsed.ok_or_else(|| {
            let found = String::from_utf8_lossy(&word[..word.len().min(40)]);
            let hint = match word.first() {
                Some(b'$') => ": the section has fewer entries than its counts say",
                _ => "",
            };
            let message = format!("expected {what}, found `{found}`{hint}");
            self.malformed(self.at - word.len(), message)
        })
    }

    /// The next N bytes.
    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], ImportError> {
        let taken = self.bytes[self.at..].first_chunk::<N>().copied();
        let taken = taken.ok_or_else(|| self.truncated(what))?;
        self.at += N;
        Ok(taken)
    }

    /// The number 1 in four bytes, which shows the order of bytes; `size` is that of sizes.
    pub fn byte_order(&mut self, size: usize) -> Result<Encoding, ImportError> {
        let start = self.at;
        match u32::from_le_bytes(self.take("the number 1 that tells the order of bytes")?) {
            1 => Ok(Encoding::Binary {
                big_endian: false,
                size,
            }),
            0x0100_0000 => Ok(Encoding::Binary {
                big_endian: true,
                size,
            }),
            other => {
                let message =
                    format!("the number that tells the order of bytes must be 1, found {other}");
                Err(self.malformed(start, message))
            }
        }
    }

    /// An integer of four bytes.
    pub fn integer(&mut self, what: &str) -> Result<i64, ImportError> {
        match self.encoding {
            Encoding::Text => self.parsed(what),
            Encoding::Binary { big_endian, .. } => {
                let bytes = self.take::<4>(what)?;
                Ok(i64::from(match big_endian {
                    true => i32::from_be_bytes(bytes),
                    false => i32::from_le_bytes(bytes),
                }))
            }
        }
    }

    /// A count or an index.
    pub fn size(&mut self, what: &str) -> Result<u64, ImportError> {
        let Encoding::Binary { big_endian, size } = self.encoding else {
            return self.parsed(what);
        };
        if size == 4 {
            let bytes = self.take::<4>(what)?;
            return Ok(u64::from(match big_endian {
                true => u32::from_be_bytes(bytes),
                false => u32::from_le_bytes(bytes),
            }));
        }
        let bytes = self.take::<8>(what)?;
        Ok(match big_endian {
            true => u64::from_be_bytes(bytes),
            false => u64::from_le_bytes(bytes),
        })
    }

    /// A number, infinity and NaN included.
    pub fn number(&mut self, what: &str) -> Result<f64, ImportError> {
        let Encoding::Binary { big_endian, .. } = self.encoding else {
            return self.parsed(what);
        };
        let bytes = self.take::<8>(what)?;
        Ok(match big_endian {
            true => f64::from_be_bytes(bytes),
            false => f64::from_le_bytes(bytes),
        })
    }

    /// A finite number.
    pub fn real(&mut self, what: &str) -> Result<f64, ImportError> {
        let start = self.next_at();
        let value = self.number(what)?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.malformed(start, format!("{what} must be finite, found {value}")))
    }

    /// Whether a quotation mark follows.
    pub fn before_quote(&mut self) -> bool {
        self.skip_space() && self.bytes[self.at] == b'"'
    }

    /// A quoted name; other programs write words of their own behind it, which are skipped.
    pub fn quoted(&mut self) -> Result<String, ImportError> {
        let what = "a name in quotation marks";
        if !self.skip_space() {
            return Err(self.truncated(what));
        }
        let start = self.at;
        let line = self.line();
        let inner = line.strip_prefix('"').and_then(|l| l.rsplit_once('"'));
        inner.map(|(name, _)| name.to_string()).ok_or_else(|| {
            let message = format!("expected {what}, found `{line}`");
            self.malformed(start, message)
        })
    }

    /// Moves past the line `$End...` of the section whose data end here.
    pub fn end_section(&mut self, name: &str) -> Result<(), ImportError> {
        let end = end_of(name);
        if !self.skip_space() {
            return Err(self.truncated(&format!("`{end}`")));
        }
        let start = self.at;
        if self.bytes[start..].starts_with(end.as_bytes()) {
            self.line();
            return Ok(());
        }
        let message = format!("expected `{end}`: the section has more entries than its counts say");
        Err(self.malformed(start, message))
    }

    /// Moves past the line `$End...` of a section whose data are not read.
    pub fn skip_section(&mut self, name: &str) -> Result<(), ImportError> {
        let end = format!("\n{}", end_of(name));
        // The section may be empty: its end may follow its header at once.
        let from = self.at.saturating_sub(1);
        let found = self.bytes[from..]
            .windows(end.len())
            .position(|window| window == end.as_bytes());
        let Some(offset) = found else {
            return Err(self.truncated(&format!("`{}`", end.trim())));
        };
        self.at = from + offset + 1;
        self.line();
        Ok(())
    }
}

/// The line that ends a section: version 1 of Gmsh's format, whose sections have names of capitals, has its own.
fn end_of(name: &str) -> String {
    let old = name.chars().all(|c| c.is_ascii_uppercase());
    format!("${}{name}", if old { "END" } else { "End" })
}
