//! The reference of every key of a case file.

/// Every key with its default and meaning.
pub const TEXT: &str = include_str!("keys.txt");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_that_a_file_may_have_is_described() {
        for (table, keys) in dotyk::case::keys::ALL.iter().copied() {
            for key in keys {
                let described = TEXT.lines().any(|line| {
                    let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                    words.any(|word| word == *key)
                });
                assert!(described, "{key} of {table}");
            }
        }
    }
}
