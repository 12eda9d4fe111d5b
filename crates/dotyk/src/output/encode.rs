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
    end(out, pixels, width)
}

/// A PNG picture in RGB.
///
/// Shapes: `pixels` (height · width,), row by row from the top.
pub fn png_rgb(width: usize, height: usize, pixels: &[[u8; 3]]) -> Vec<u8> {
    let out = begin(width, height, 2);
    end(out, pixels.as_flattened(), 3 * width)
}

/// The pixels in rows of this length, and what closes a file.
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

/// Signature and header of a picture of 8 bits per value; `colours` is 2 for RGB, 3 for a palette.
fn begin(width: usize, height: usize, colours: u8) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = Vec::new();
    header.extend((width as u32).to_be_bytes());
    header.extend((height as u32).to_be_bytes());
    // Depth 8, deflate, filters by rows, no interlace.
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
