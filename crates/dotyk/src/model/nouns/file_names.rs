//! Names that become names of files, which not every system can hold.
//!
//! Source: "Naming Files, Paths, and Namespaces" of the documentation of Windows, reserved names.

use std::collections::HashMap;

/// Names that Windows reserves for devices, with any extension and in any case.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// The same, each with a digit behind it.
const PORTS: [&str; 2] = ["com", "lpt"];

/// Most characters: with number, ending and the mark of a file being written less than the 255 bytes that systems allow.
const LONGEST: usize = 200;

/// Why something cannot have its name: a file is called by it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Windows has no such file.
    #[error(
        "Windows keeps the name `{0}` for a device and has no file of this name; choose another one, such as `{0}_1`"
    )]
    Device(String),
    /// Some systems do not tell the files of two names apart.
    #[error(
        "its name differs from `{other}` in case alone, and some systems have one file for both; rename one of them"
    )]
    Alike {
        /// The name.
        name: String,
        /// The one before it.
        other: String,
    },
    /// No system has such a file.
    #[error("its name has more than 200 characters, too many for a file; choose a shorter one")]
    TooLong(String),
}

impl NameError {
    /// The name that is refused.
    pub fn name(&self) -> &str {
        match self {
            Self::Device(name) | Self::Alike { name, .. } | Self::TooLong(name) => name,
        }
    }
}

/// Checks that files of one folder can have these names on every system; equal names are not reported.
///
/// Errors: the first name that no file can have, or that differs from an earlier one in case only.
pub fn check_file_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<(), NameError> {
    let mut seen: HashMap<String, &str> = HashMap::new();
    for name in names {
        let lower = name.to_lowercase();
        if is_device(&lower) {
            return Err(NameError::Device(name.to_string()));
        }
        if name.len() > LONGEST {
            return Err(NameError::TooLong(name.to_string()));
        }
        let other = *seen.entry(lower).or_insert(name);
        if other != name {
            return Err(NameError::Alike {
                name: name.to_string(),
                other: other.to_string(),
            });
        }
    }
    Ok(())
}

/// Of a name in lower case.
fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default();
    let digit = stem.strip_suffix(|c: char| c.is_ascii_digit());
    DEVICES.contains(&stem) || digit.is_some_and(|port| PORTS.contains(&port))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_of_windows_are_no_files_whatever_their_case() {
        for name in [
            "CON", "prn", "Aux", "nul", "COM0", "com9", "Lpt1", "nul.old",
        ] {
            let found = check_file_names([name]);
            assert_eq!(found, Err(NameError::Device(name.to_string())));
        }
        let free = [
            "con_1", "console", "com", "com10", "lpt", "null", "nul-1", "a.con",
        ];
        assert_eq!(check_file_names(free), Ok(()));
    }

    #[test]
    fn names_that_only_their_case_tells_apart_are_one_file() {
        let found = check_file_names(["Rock", "lining", "rock"]).unwrap_err();
        assert_eq!(found.name(), "rock");
        assert!(found.to_string().contains("`Rock`"), "{found}");
        assert_eq!(check_file_names(["rock", "rock_1", "lining"]), Ok(()));
    }

    #[test]
    fn a_name_fits_into_that_of_a_file() {
        let name = "n".repeat(LONGEST);
        assert_eq!(check_file_names([&name[..]]), Ok(()));
        let longer = name + "n";
        assert!(check_file_names([&longer[..]]).is_err());
    }
}
