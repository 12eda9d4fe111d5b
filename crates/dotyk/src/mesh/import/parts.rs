//! The files of a mesh: one, or where there is no such file, those of its partitions.
//!
//! Programs that save each partition by itself call them NAME_1.msh, NAME_2.msh, .. (with zeros before the number, too) and
//! write no NAME.msh.

use crate::mesh::import::error::ImportError;
use std::path::{Path, PathBuf};

/// The files that a path means, in the order of their numbers.
///
/// Errors: a number that is missing or stands twice.
pub(crate) fn files(path: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let parts = if path.exists() {
        Vec::new()
    } else {
        parts(path)
    };
    if parts.is_empty() {
        return Ok(vec![path.to_path_buf()]);
    }
    let numbers: Vec<u64> = parts.iter().map(|part| part.0).collect();
    let wanted = (1..).zip(&numbers).find(|(wanted, found)| wanted != *found);
    if let Some((wanted, _)) = wanted {
        let numbers: Vec<String> = numbers.iter().map(u64::to_string).collect();
        return Err(ImportError::Unsupported {
            file: path.display().to_string(),
            what: format!(
                "the mesh is saved in files of its partitions, numbered {}: they must be numbered from 1, and one with the number {wanted} is expected next",
                numbers.join(", ")
            ),
        });
    }
    Ok(parts.into_iter().map(|part| part.1).collect())
}

/// The numbered files beside a path, ascending; a folder that cannot be listed has none.
fn parts(path: &Path) -> Vec<(u64, PathBuf)> {
    let text = |part: Option<&std::ffi::OsStr>| Some(part?.to_str()?.to_string());
    let (Some(stem), Some(ending)) = (text(path.file_stem()), text(path.extension())) else {
        return Vec::new();
    };
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let Ok(entries) = std::fs::read_dir(folder.unwrap_or(Path::new("."))) else {
        return Vec::new();
    };
    let number = |entry: std::fs::DirEntry| {
        let name = entry.file_name();
        let number = name.to_str()?.strip_prefix(&stem)?.strip_prefix('_')?;
        let number = number.strip_suffix(&ending)?.strip_suffix('.')?;
        let digits = number.bytes().all(|byte| byte.is_ascii_digit());
        let number = number.parse().ok().filter(|_| digits)?;
        Some((number, entry.path()))
    };
    let mut parts: Vec<(u64, PathBuf)> = entries.flatten().filter_map(number).collect();
    parts.sort();
    parts
}
