//! The banned words, from `words.txt`. Checks in other languages read the same file.

use std::collections::HashSet;
use std::sync::LazyLock;

/// Words that are banned in identifiers alone, and those that are banned everywhere.
struct Banned {
    in_names: HashSet<&'static str>,
    everywhere: HashSet<&'static str>,
}

static BANNED: LazyLock<Banned> = LazyLock::new(|| {
    let lines = include_str!("../../words.txt").lines().filter(|line| !line.starts_with('#'));
    let (in_names, everywhere) = lines
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .partition::<Vec<&str>, _>(|line| line.contains(' '));
    let in_names = in_names.into_iter().filter_map(|line| line.strip_suffix(" (names)")).collect();
    Banned { in_names, everywhere: everywhere.into_iter().collect() }
});

/// Whether a lower-case word is banned in text.
pub fn is_banned_in_text(word: &str) -> bool {
    BANNED.everywhere.contains(word)
}

/// Whether a lower-case segment is banned in identifiers.
pub fn is_banned_in_names(segment: &str) -> bool {
    is_banned_in_text(segment) || BANNED.in_names.contains(segment)
}
