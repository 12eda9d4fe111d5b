//! Bytes for files: zlib, and PNG pictures of 256 colours.

use flate2::write::ZlibEncoder;
use flate2::{Compression, Crc};
use std::io::Write;

/// A zlib stream, small.
fn zlib(bytes: &[u8]) -> Vec<u8> {
    zlib_at(Compression::default(), bytes)
}

/// A zlib stream, made fast: the digits of computed numbers hardly repeat, and more effort makes them no smaller.
pub fn zlib_fast(bytes: &[u8]) -> Vec<u8> {
    zlib_at(Compression::fast(), bytes)
}

fn zlib_at(effort: Compression, bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), effort);
    // A Vec takes every byte.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// A PNG picture with a palette; colour 0 is transparent.
///
/// Shapes: `pixels` (height · width,), row by row from the top; `palette` at most 256 colours.
/// Source: PNG specification, third edition, sections 5 and 11.
pub fn png(width: usize, height: usize, pixels: &[u8], palette: &[[u8; 3]]) -> Vec<u8> {
    let mut out = begin(width, height);
    chunk(&mut out, b"PLTE", palette.as_flattened());
    chunk(&mut out, b"tRNS", &[0]);
    end(out, pixels, width)
}

/// Levels of red, green and blue of a picture, as a power of two.
const LEVELS: u32 = 6;

/// Most colours of a picture.
const COLOURS: usize = 256;

/// A PNG picture of any colours, reduced to the 256 most frequent ones; rarer ones, blends at edges, take the nearest of these. It
/// takes half of the size and of the time of a picture in all colours.
///
/// Shapes: `pixels` (height · width,), row by row from the top.
pub fn png_nearest(width: usize, height: usize, pixels: &[[u8; 3]]) -> Vec<u8> {
    let bits = 8 - LEVELS;
    let key = |[r, g, b]: [u8; 3]| {
        let level = |c: u8| usize::from(c >> bits);
        (level(r) << LEVELS | level(g)) << LEVELS | level(b)
    };
    // by the level of a colour: how often it occurs, and the last one of it
    let mut counts = vec![(0u32, [0u8; 3]); 1 << (3 * LEVELS)];
    for &pixel in pixels {
        let entry = &mut counts[key(pixel)];
        *entry = (entry.0 + 1, pixel);
    }
    let mut found: Vec<usize> = (0..counts.len()).filter(|&k| counts[k].0 > 0).collect();
    found.sort_by_key(|&k| std::cmp::Reverse(counts[k].0));
    let palette: Vec<[u8; 3]> = found.iter().take(COLOURS).map(|&k| counts[k].1).collect();
    let mut indices = vec![0u8; counts.len()];
    for (place, &k) in found.iter().enumerate() {
        let own = || nearest(&palette, counts[k].1);
        indices[k] = if place < COLOURS { place as u8 } else { own() };
    }
    let mut out = begin(width, height);
    chunk(&mut out, b"PLTE", palette.as_flattened());
    let indices: Vec<u8> = pixels.iter().map(|&pixel| indices[key(pixel)]).collect();
    end(out, &indices, width)
}

/// Index of the nearest colour; of equal ones the first.
fn nearest(palette: &[[u8; 3]], colour: [u8; 3]) -> u8 {
    let far = |c: &[u8; 3]| -> i32 {
        let off = (0..3).map(|i| i32::from(c[i]) - i32::from(colour[i]));
        off.map(|d| d * d).sum()
    };
    let near = palette.iter().enumerate().min_by_key(|(_, c)| far(c));
    near.map_or(0, |(index, _)| index as u8)
}

/// The pixels in rows of this length, and the end of the file.
///
/// No row has a filter: our pictures are flat areas, lines and gradients of few colours, which are as small without as with the
/// best of five for each row, and take half of the time.
fn end(mut out: Vec<u8>, pixels: &[u8], length: usize) -> Vec<u8> {
    let mut rows = Vec::with_capacity(pixels.len() + pixels.len() / length.max(1));
    for row in pixels.chunks(length.max(1)) {
        rows.push(0);
        rows.extend(row);
    }
    chunk(&mut out, b"IDAT", &zlib(&rows));
    chunk(&mut out, b"IEND", &[]);
    out
}

/// Signature and header of a picture with a palette.
fn begin(width: usize, height: usize) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = Vec::new();
    header.extend((width as u32).to_be_bytes());
    header.extend((height as u32).to_be_bytes());
    // Depth 8, a palette, deflate, filters by rows, no interlace.
    header.extend([8, 3, 0, 0, 0]);
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

    /// The rows of a picture as they are stored.
    fn rows(png: &[u8]) -> Vec<u8> {
        let start = png.windows(4).position(|w| w == b"IDAT").unwrap() + 4;
        let mut rows = Vec::new();
        flate2::read::ZlibDecoder::new(&png[start..])
            .read_to_end(&mut rows)
            .unwrap();
        rows
    }

    #[test]
    fn of_more_than_256_colours_the_rare_ones_are_shown_by_the_nearest() {
        // 300 shades in steps of 4 of red, then of green; the last 44 once, all others twice
        let shade = |k: usize| [4 * (k % 60) as u8, 4 * (k / 60) as u8, 0];
        let pixels: Vec<[u8; 3]> = (0..300).chain(0..256).map(shade).collect();
        let png = png_nearest(pixels.len(), 1, &pixels);
        let start = png.windows(4).position(|w| w == b"PLTE").unwrap() + 4;
        let palette: Vec<&[u8]> = png[start..start + 3 * COLOURS].chunks(3).collect();
        for (pixel, index) in pixels.iter().zip(&rows(&png)[1..]) {
            let shown = palette[usize::from(*index)];
            let off = (0..3).map(|i| pixel[i].abs_diff(shown[i])).max().unwrap();
            let rare = pixel[1] == 16 && pixel[0] > 60;
            assert!(off <= if rare { 4 } else { 0 }, "{pixel:?} {shown:?}");
        }
    }

    #[test]
    fn png_stores_every_row_behind_a_filter_byte() {
        let png = png(2, 2, &[0, 1, 1, 0], &[[0, 0, 0], [255, 0, 0]]);
        assert_eq!(rows(&png), [0, 0, 1, 0, 1, 0]);
        // The last chunk is always the same twelve bytes.
        assert!(png.ends_with(b"\x00\x00\x00\x00IEND\xaeB`\x82"));
    }
}
