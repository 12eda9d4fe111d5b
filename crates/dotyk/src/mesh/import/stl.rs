//! STL files, binary and text: triangles whose corners turn outwards. Stored normals are ignored; those that contradict are counted.

use crate::geometry::{Point, cross, distance, dot, norm, sub};
use std::collections::{BTreeMap, BTreeSet};

/// Triangles that are thinner than this part of their length have no normal, and are left out.
const THIN: f64 = 1e-9;

/// Bytes of the head of a binary file, and of one triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// A surface of triangles.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Triangles {
    /// Corners, each once.
    pub points: Vec<Point<3>>,
    /// Triangles that turn outwards.
    pub triangles: Vec<[u32; 3]>,
    /// Stored normals that point inwards.
    pub contradictions: usize,
    /// Triangles without an area.
    pub thin: usize,
    /// Triangles that were there before.
    pub repeated: usize,
}

/// Why a file is no surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum StlError {
    #[error(
        "it ends within its {triangles} triangles: {bytes} bytes of {expected}; it was cut off, copy it again"
    )]
    CutBinary {
        triangles: usize,
        bytes: usize,
        expected: usize,
    },
    #[error("it ends in line {line}, before its `endsolid`: it was cut off, copy it again")]
    CutText { line: usize },
    #[error("line {line}: `{found}` where `{expected}` should be")]
    Word {
        line: usize,
        found: String,
        expected: String,
    },
    #[error("line {line}: `{found}` is not a finite number")]
    Number { line: usize, found: String },
    #[error("triangle {triangle} has a coordinate that is not finite")]
    NotFinite { triangle: usize },
    #[error("it has no triangles")]
    Empty,
    #[error("it is no STL file: it neither begins with `solid` nor is as long as its head tells")]
    Neither,
}

impl Triangles {
    /// The triangles of a file.
    pub fn read(bytes: &[u8]) -> Result<Self, StlError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let told = bytes
            .get(HEAD - 4..HEAD)
            .and_then(|four| four.try_into().ok());
        let told = told.map(|four| u32::from_le_bytes(four) as usize);
        let length = told.map(|count| HEAD + TRIANGLE * count);
        let word = bytes.trim_ascii_start().get(..5);
        let is_text = word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
        let corners = match length {
            Some(length) if bytes.len() == length => binary(&bytes[HEAD..])?,
            _ if is_text => text(bytes)?,
            Some(length) if bytes.len() < length => {
                return Err(StlError::CutBinary {
                    triangles: told.unwrap_or_default(),
                    bytes: bytes.len(),
                    expected: length,
                });
            }
            _ => return Err(StlError::Neither),
        };
        Self::of(&corners)
    }

    /// The surface of stored normals and corners.
    fn of(all: &[[Point<3>; 4]]) -> Result<Self, StlError> {
        let mut surface = Self::default();
        let mut places: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        let mut seen: BTreeSet<[u32; 3]> = BTreeSet::new();
        for [normal, corners @ ..] in all {
            let own = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
            let length = (0..3).map(|k| distance(corners[k], corners[(k + 1) % 3]));
            let length = length.fold(0.0, f64::max);
            let area = norm(own);
            if area.is_nan() || area <= THIN * length * length {
                surface.thin += 1;
                continue;
            }
            if dot(own, *normal) < 0.0 {
                surface.contradictions += 1;
            }
            let place = corners.map(|corner| {
                // zeros of both signs are the same
                let key = corner.map(|c| (c + 0.0).to_bits());
                *places.entry(key).or_insert_with(|| {
                    surface.points.push(corner);
                    surface.points.len() as u32 - 1
                })
            });
            let first = (0..3).min_by_key(|&k| place[k]).unwrap_or_default();
            match seen.insert([0, 1, 2].map(|k| place[(first + k) % 3])) {
                true => surface.triangles.push(place),
                false => surface.repeated += 1,
            }
        }
        match surface.triangles.is_empty() {
            true => Err(StlError::Empty),
            false => Ok(surface),
        }
    }
}

fn binary(bytes: &[u8]) -> Result<Vec<[Point<3>; 4]>, StlError> {
    let triangle = |(index, bytes): (usize, &[u8])| {
        let number = |k: usize| {
            let four = [0, 1, 2, 3].map(|j| bytes[4 * k + j]);
            f64::from(f32::from_le_bytes(four))
        };
        let points: [Point<3>; 4] =
            std::array::from_fn(|p| std::array::from_fn(|d| number(3 * p + d)));
        match points[1..].iter().flatten().all(|c| c.is_finite()) {
            true => Ok(points),
            false => Err(StlError::NotFinite {
                triangle: index + 1,
            }),
        }
    };
    bytes
        .chunks_exact(TRIANGLE)
        .enumerate()
        .map(triangle)
        .collect()
}

/// The words of a text with their lines.
struct Words<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    line: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Result<&'a str, StlError> {
        match self.words.next() {
            Some((line, word)) => {
                self.line = line;
                Ok(word)
            }
            None => Err(StlError::CutText { line: self.line }),
        }
    }

    fn expect(&mut self, expected: &str) -> Result<(), StlError> {
        let found = self.next()?;
        match found.eq_ignore_ascii_case(expected) {
            true => Ok(()),
            false => Err(self.other(found, expected)),
        }
    }

    /// Another word than expected: the last one may be cut off.
    fn other(&mut self, found: &str, expected: &str) -> StlError {
        let line = self.line;
        if self.words.next().is_none() {
            return StlError::CutText { line };
        }
        StlError::Word {
            line,
            found: found.chars().take(40).collect(),
            expected: expected.to_string(),
        }
    }

    fn point(&mut self) -> Result<Point<3>, StlError> {
        let mut point = [0.0; 3];
        for coordinate in &mut point {
            let found = self.next()?;
            let number = found.parse().ok().filter(|number: &f64| number.is_finite());
            *coordinate = match number {
                Some(number) => number,
                None if self.words.next().is_none() => {
                    return Err(StlError::CutText { line: self.line });
                }
                None => {
                    return Err(StlError::Number {
                        line: self.line,
                        found: found.chars().take(40).collect(),
                    });
                }
            };
        }
        Ok(point)
    }
}

fn text(bytes: &[u8]) -> Result<Vec<[Point<3>; 4]>, StlError> {
    let text = String::from_utf8_lossy(bytes);
    let lines = text.lines().enumerate();
    // the names of solids may have any words: only the first one of their lines counts
    let words = lines.flat_map(|(line, text)| {
        let first = text.split_whitespace().next().unwrap_or_default();
        let named = ["solid", "endsolid"]
            .iter()
            .any(|word| first.eq_ignore_ascii_case(word));
        let most = if named { 1 } else { usize::MAX };
        text.split_whitespace()
            .take(most)
            .map(move |word| (line + 1, word))
    });
    let mut words = Words {
        words: Box::new(words),
        line: 0,
    };
    let mut all = Vec::new();
    words.expect("solid")?;
    loop {
        let word = words.next()?;
        if word.eq_ignore_ascii_case("facet") {
            words.expect("normal")?;
            let normal = words.point()?;
            words.expect("outer")?;
            words.expect("loop")?;
            let mut triangle = [normal; 4];
            for corner in &mut triangle[1..] {
                words.expect("vertex")?;
                *corner = words.point()?;
            }
            words.expect("endloop")?;
            words.expect("endfacet")?;
            all.push(triangle);
        } else if word.eq_ignore_ascii_case("endsolid") {
            // another solid, or the end
            match words.next() {
                Ok(word) if word.eq_ignore_ascii_case("solid") => {}
                Ok(word) => return Err(words.other(word, "solid")),
                Err(_) => return Ok(all),
            }
        } else {
            return Err(words.other(word, "facet"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid a name facet\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0.1\n   vertex 1 0 0.1\n   vertex 0 1 0.1\n  endloop\n endfacet\n facet normal 0 0 -1\n  outer loop\n   vertex 1 0 0.1\n   vertex 1 1 0.1\n   vertex 0 1 0.1\n  endloop\n endfacet\nendsolid a\n";

    fn of_binary(triangles: &[[[f32; 3]; 4]]) -> Vec<u8> {
        let mut bytes = b"solid in name alone".to_vec();
        bytes.resize(80, b' ');
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend(triangle.iter().flatten().flat_map(|c| c.to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    #[test]
    fn text_and_binary_files_are_read() {
        let read = Triangles::read(TEXT.as_bytes()).unwrap();
        assert_eq!(
            read.points,
            [
                [0.0, 0.0, 0.1],
                [1.0, 0.0, 0.1],
                [0.0, 1.0, 0.1],
                [1.0, 1.0, 0.1]
            ]
        );
        assert_eq!(read.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!((read.contradictions, read.thin), (1, 0));
        let flat = [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
        ];
        let one = [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        let read = Triangles::read(&of_binary(&[one, flat])).unwrap();
        assert_eq!((read.triangles.len(), read.thin), (1, 1));
        let turned = [one[0], one[2], one[3], one[1]];
        let read = Triangles::read(&of_binary(&[one, turned])).unwrap();
        assert_eq!((read.triangles.len(), read.repeated), (1, 1));
        let marked = [b"\xef\xbb\xbf".as_slice(), TEXT.to_uppercase().as_bytes()].concat();
        assert_eq!(Triangles::read(&marked).unwrap().triangles.len(), 2);
        assert_eq!(Triangles::read(&of_binary(&[])), Err(StlError::Empty));
        assert_eq!(Triangles::read(&of_binary(&[flat])), Err(StlError::Empty));
    }

    #[test]
    fn what_is_cut_off_is_told_at_every_byte() {
        for end in 0..TEXT.trim_end().len() - "id a".len() {
            let error = Triangles::read(&TEXT.as_bytes()[..end]);
            assert!(error.is_err(), "{end}");
        }
        let one = [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        let whole = of_binary(&[one, one]);
        for end in 0..whole.len() {
            assert!(Triangles::read(&whole[..end]).is_err(), "{end}");
        }
        let wrong = TEXT.replace("vertex 1 1 0.1", "vertex 1 nan 0.1");
        let error = StlError::Number {
            line: 12,
            found: "nan".to_string(),
        };
        assert_eq!(Triangles::read(wrong.as_bytes()), Err(error));
        let wrong = TEXT.replace("endloop\n endfacet\nends", "vertex 0 0 0\n endfacet\nends");
        assert!(matches!(
            Triangles::read(wrong.as_bytes()),
            Err(StlError::Word { line: 14, .. })
        ));
    }
}
