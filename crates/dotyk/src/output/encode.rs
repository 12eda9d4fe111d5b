//! Bytes for files: zlib, and PNG pictures of 256 or of all colours.

use flate2::write::ZlibEncoder;
use flate2::{Compression, Crc};
use std::io::Write;

/// A zlib stream.
pub fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // A Vec takes every byte.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// A PNG picture with a palette; colour 0 is transparent.
///
/// Shapes: `pixels` (height · width,), row by row from the top; `palette` at most 256 colours.
/// Source: PNG specification, third edition, sections 5 and 11.
pub fn png(width: usize, height: usize, pixels: &[u8], palette: &[[u8; 3]]) -> Vec<u8> {
    let mut out = begin(width, height, 3);
    chunk(&mut out, b"PLTE", palette.as_flattened());
    chunk(&mut out, b"tRNS", &[0]);
    let mut rows = Vec::with_capacity(pixels.len() + height);
    for row in pixels.chunks(width.max(1)) {
        rows.push(0);
        rows.extend(row);
    }
    chunk(&mut out, b"IDAT", &zlib(&rows));
    chunk(&mut out, b"IEND", &[]);
    out
}

/// A PNG picture in RGB.
///
/// Shapes: `pixels` (height · width,), row by row from the top. Each row has the filter whose bytes are smallest in sum.
/// Source: PNG specification, third edition, sections 9 and 12.7.
pub fn png_rgb(width: usize, height: usize, pixels: &[[u8; 3]]) -> Vec<u8> {
    let mut out = begin(width, height, 2);
    let mut rows = Vec::with_capacity(3 * pixels.len() + height);
    let blank = vec![0; 3 * width];
    let mut above: &[u8] = &blank;
    for row in pixels.chunks(width.max(1)) {
        let row = row.as_flattened();
        let sum = |bytes: &[u8]| -> u32 {
            bytes
                .iter()
                .map(|&b| u32::from(b.min(b.wrapping_neg())))
                .sum()
        };
        let filtered = (0..5).map(|filter| filtered(filter, row, above));
        let best = filtered.min_by_key(|bytes| sum(&bytes[1..]));
        rows.extend(best.unwrap_or_default());
        above = row;
    }
    chunk(&mut out, b"IDAT", &zlib(&rows));
    chunk(&mut out, b"IEND", &[]);
    out
}

/// A row of RGB pixels behind the number of its filter: none, left, above, their mean, Paeth.
fn filtered(filter: u8, row: &[u8], above: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(row.len() + 1);
    out.push(filter);
    out.extend(row.iter().enumerate().map(|(i, &byte)| {
        let [left, corner] = match i {
            0..3 => [0; 2],
            _ => [row[i - 3], above[i - 3]],
        };
        let guess = match filter {
            0 => 0,
            1 => left,
            2 => above[i],
            3 => left.midpoint(above[i]),
            _ => {
                let [a, b, c] = [left, above[i], corner].map(i16::from);
                let off = |x: i16| (a + b - c - x).abs();
                match (off(a), off(b), off(c)) {
                    (p, q, r) if p <= q && p <= r => left,
                    (_, q, r) if q <= r => above[i],
                    _ => corner,
                }
            }
        };
        byte.wrapping_sub(guess)
    }));
    out
}

/// Signature and header of a picture of 8 bits per value; `colours` is 2 for RGB, 3 for a palette.
fn begin(width: usize, height: usize, colours: u8) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = Vec::new();
    header.extend((width as u32).to_be_bytes());
    header.extend((height as u32).to_be_bytes());
    // Depth 8, deflate, adaptive filters, no interlace.
    header.extend([8, colours, 0, 0, 0]);
    chunk(&mut out, b"IHDR", &header);
    out
}

fn chunk(out: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    let mut crc = Crc::new();
    crc.update(kind);
    crc.update(data);
    out.extend((data.len() as u32).to_be_bytes());
    out.extend(kind);
    out.extend(data);
    out.extend(crc.sum().to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn png_stores_every_row_behind_a_filter_byte() {
        let png = png(2, 2, &[0, 1, 1, 0], &[[0, 0, 0], [255, 0, 0]]);
        let start = png.windows(4).position(|w| w == b"IDAT").unwrap() + 4;
        let mut rows = Vec::new();
        flate2::read::ZlibDecoder::new(&png[start..])
            .read_to_end(&mut rows)
            .unwrap();
        assert_eq!(rows, [0, 0, 1, 0, 1, 0]);
        // The last chunk is always the same twelve bytes.
        assert!(png.ends_with(b"\x00\x00\x00\x00IEND\xaeB`\x82"));
    }
}
