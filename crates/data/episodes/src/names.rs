//! Names that every format can carry: as a column, a folder and a key.

use crate::EpisodeError;

/// Longest a name may be.
const MAX_CHARACTERS: usize = 80;

/// Checks that a name has 1 to 80 of the characters a-z, A-Z, 0-9, `_`, `-`. A `/` would divide it into keys.
pub(crate) fn check_name(kind: &str, name: &str) -> Result<(), EpisodeError> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if (1..=MAX_CHARACTERS).contains(&name.len()) && name.chars().all(is_plain) {
        return Ok(());
    }
    Err(EpisodeError::description(
        format!("`{name}` is no name for {kind}"),
        "use 1 to 80 of the characters a-z, A-Z, 0-9, _ and -; no `/`, no `.`, no spaces",
    ))
}
