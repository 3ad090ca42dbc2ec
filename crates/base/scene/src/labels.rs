//! Pairs of words that clients attach to scenes for their own use.

use std::collections::BTreeMap;

use crate::validation::{Violation, Violations};

/// Largest number of labels of a scene.
const MAX_LABELS: usize = 32;

/// Whether a label may have this key and this value.
pub fn is_label(key: &str, value: &str) -> bool {
    is_key(key) && value.chars().count() <= 255 && !value.chars().any(char::is_control)
}

fn is_key(key: &str) -> bool {
    (1..=63).contains(&key.len())
        && key.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.'))
}

/// Every violation, with pointers into the labels.
pub fn violations(labels: &BTreeMap<String, String>) -> Vec<Violation> {
    let mut violations = Violations::default();
    let few = labels.len() <= MAX_LABELS;
    violations.require(few, "", format!("has more than {MAX_LABELS} entries"));
    for (key, value) in labels.iter().take(MAX_LABELS + 1) {
        let key_fits = is_key(key);
        violations.require(key_fits, "", "keys have 1 to 63 letters, digits, `_`, `-` or `.`");
        let value_fits = !key_fits || is_label(key, value);
        violations.require(
            value_fits,
            format!("/{key}"),
            "values have at most 255 characters, none of control",
        );
    }
    violations.into_vec()
}
