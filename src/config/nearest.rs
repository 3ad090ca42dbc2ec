//! Suggestions for a misspelled key: the nearest known key, or the keys and sections there are.
//!
//! Keys are compared part by part. A part is close if a slip apart ([`is_close`]), so that `servr.x` is not taken for a
//! key that is merely as short.

use std::collections::BTreeSet;

use super::keys::keys;

/// Maximum number of listed keys of a section.
const LISTED: usize = 12;

/// Advice for an unknown key.
pub(super) fn advice(given: &str) -> String {
    if let Some(key) = nearest(given) {
        return format!("the nearest is {key}");
    }
    let section = sections().into_iter().filter(|section| is_close(section_of(given), section));
    match section.min_by_key(|section| distance(section_of(given), section)) {
        Some(section) => {
            let inside = keys().keys().filter(|key| section_of(key) == section);
            let names: Vec<&str> = inside.map(|key| name_of(key)).collect();
            let more = if names.len() > LISTED { ", and others (see check-config)" } else { "" };
            format!("section {section} has {}{more}", names[..names.len().min(LISTED)].join(", "))
        }
        None => {
            let sections: Vec<&str> = sections().into_iter().collect();
            format!("the sections are {} (check-config lists their keys)", sections.join(", "))
        }
    }
}

/// The key that is meant, if one is close: in both parts; else by its name alone, in whichever section.
fn nearest(given: &str) -> Option<&'static str> {
    let (section, name) = (section_of(given), name_of(given));
    let distance_of = |key: &&'static str| {
        let of_section = distance(section, section_of(key));
        // A section that is left out or mistaken weighs less than another name.
        (distance_of_names(name, name_of(key)), of_section)
    };
    let is_known = sections().contains(section);
    let close = keys().keys().map(String::as_str).filter(|key| {
        let is_in_section = is_close(section, section_of(key));
        // A name that is right in another section is meant unless the section has a close one, too.
        let has_name = is_close_name(name, name_of(key));
        has_name && (is_in_section || !is_known || name == name_of(key))
    });
    close.min_by_key(distance_of)
}

/// Whether two texts differ by a slip: one character of three, at least one, and not all.
fn is_close(a: &str, b: &str) -> bool {
    let length = a.chars().count().max(b.chars().count());
    let allowed = (length / 3).max(1);
    !a.is_empty() && distance(a, b) <= allowed && distance(a, b) < length
}

/// As [`is_close`], and where one has the other among its words: `hulls` means `max_hulls`.
fn is_close_name(a: &str, b: &str) -> bool {
    is_close(a, b) || is_word_of(a, b) || is_word_of(b, a)
}

fn distance_of_names(a: &str, b: &str) -> usize {
    let whole = distance(a, b);
    if is_word_of(a, b) || is_word_of(b, a) { whole.min(2) } else { whole }
}

fn is_word_of(word: &str, text: &str) -> bool {
    word.len() > 2 && text.split('_').any(|part| part == word)
}

fn sections() -> BTreeSet<&'static str> {
    keys().keys().map(|key| section_of(key)).collect()
}

/// All of a key but its last part; of a key without parts, the key itself: `worker` may be a section.
fn section_of(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(section, _)| section)
}

fn name_of(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or_default()
}

/// Optimal string alignment: insertions, deletions, substitutions, and swaps of two neighbors.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                rows[i][j] = i.max(j);
                continue;
            }
            let substituted = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut cost = substituted.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                cost = cost.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = cost;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_find_the_key_that_was_meant() {
        assert_eq!((distance("kitten", "sitting"), distance("tua", "tau")), (3, 1));
        assert_eq!(distance("", "abc"), 3);
        for (given, meant) in [
            ("worker.concurency", "worker.concurrency"),
            ("worked.concurency", "worker.concurrency"),
            ("concurrency", "worker.concurrency"),
            ("server.fsync", "store.fsync"),
            ("walker.fan_out", "worker.fan_out"),
            ("worker.fanout", "worker.fan_out"),
            ("decompose.hulls", "decompose.max_hulls"),
            ("tsa.tua", "tsa.tau"),
            ("dro.keeep", "dro.keep"),
        ] {
            assert_eq!(nearest(given), Some(meant), "{given}");
        }
    }

    #[test]
    fn a_key_that_resembles_none_gets_no_nearest_key() {
        for given in ["servr.x", "x", "tsa.zzz", "nonsense.gibberish", "", "a.b.c"] {
            assert_eq!(nearest(given), None, "{given}");
        }
        let text = advice("servr.x");
        assert!(text.starts_with("section server has ") && text.contains("listen"), "{text}");
        assert!(advice("worker").starts_with("section worker has "), "{}", advice("worker"));
        let text = advice("nonsense.gibberish");
        assert!(text.starts_with("the sections are ") && text.contains(", server, "), "{text}");
    }
}
