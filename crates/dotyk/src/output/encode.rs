//! Bytes for files: zlib, and PNG pictures of 256 colours.

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
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = Vec::new();
    header.extend((width as u32).to_be_bytes());
    header.extend((height as u32).to_be_bytes());
    // Depth 8, palette, deflate, adaptive filters, no interlace.
    header.extend([8, 3, 0, 0, 0]);
    chunk(&mut out, b"IHDR", &header);
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
