//! Files that a case names, which may come from a stranger: endless files are not read, and pipes without a writer are not
//! waited for.

use crate::host::memory::{free_memory, told};
use std::fs::{File, metadata};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Most bytes of a case or of its references: the data read from a list take a hundred times as much memory.
const MOST_OF_TEXT: u64 = 20_000_000;

/// Where a system keeps the streams that a process was given, standard input among them.
const STREAMS: &str = "/dev";

/// The bytes of a file of data, which must leave room for the data made of them.
///
/// Errors: why it is not read, in words.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    bytes(path, free_memory().map_or(u64::MAX, |free| free / 2), false)
}

/// A text, which may come from a stream that the process was given.
///
/// Errors: as [`read`]; a text that is not UTF-8.
pub(crate) fn read_text(path: &Path) -> Result<String, String> {
    let most = free_memory().map_or(MOST_OF_TEXT, |free| MOST_OF_TEXT.min(free / 2));
    let bytes = bytes(path, most, path.starts_with(STREAMS))?;
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        format!("byte {at} is not UTF-8 text")
    })
}

fn bytes(path: &Path, most: u64, stream: bool) -> Result<Vec<u8>, String> {
    let words = |e: std::io::Error| match e.kind() {
        ErrorKind::NotFound => "there is no such file".to_string(),
        _ => e.to_string(),
    };
    let found = metadata(path).map_err(words)?;
    if found.is_dir() {
        return Err("it is a folder".to_string());
    }
    let readable = found.is_file() || stream && is_pipe(&found);
    if !readable {
        return Err("it is no regular file but a device, a pipe or a socket".to_string());
    }
    let large = || format!("it has more than {}, all that may be read here", told(most));
    if found.len() > most {
        return Err(large());
    }
    let mut bytes = Vec::new();
    let room = usize::try_from(found.len()).is_ok_and(|n| bytes.try_reserve_exact(n).is_ok());
    if !room {
        return Err(format!("the system gives no {} for it", told(found.len())));
    }
    let file = File::open(path).map_err(words)?;
    file.take(most.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(words)?;
    // one that grows meanwhile, or comes from a stream
    match bytes.len() as u64 > most {
        true => Err(large()),
        false => Ok(bytes),
    }
}

#[cfg(unix)]
fn is_pipe(found: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_: &std::fs::Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_end_or_is_too_large_is_not_read() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let manifest = here.join("Cargo.toml");
        let length = metadata(&manifest).unwrap().len();
        assert_eq!(
            bytes(&manifest, length, false).unwrap().len() as u64,
            length
        );
        let short = bytes(&manifest, length - 1, false).unwrap_err();
        assert!(short.starts_with("it has more than "), "{short}");
        assert_eq!(read(here).unwrap_err(), "it is a folder");
        assert_eq!(
            read(&here.join("none")).unwrap_err(),
            "there is no such file"
        );
        if cfg!(unix) {
            let device = read_text(Path::new("/dev/zero")).unwrap_err();
            assert!(device.contains("no regular file"), "{device}");
        }
    }
}
