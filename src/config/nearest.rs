//! The known key that is nearest to a misspelled one.

use super::keys::keys;

/// The key closest to `given`: with the same last part if there is one, else by edit distance.
pub(super) fn nearest(given: &str) -> &'static str {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let given_last = last(given);
    let distance_of = |key: &&String| {
        let whole = distance(given, key);
        // `concurrency` means `worker.concurrency`, however far apart the texts are.
        let ending = distance(&given_last, &last(key));
        (whole.min(2 * ending), whole)
    };
    keys().keys().min_by_key(distance_of).map_or("", String::as_str)
}

/// Levenshtein's distance: single-character insertions, deletions and substitutions.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_find_the_key_that_was_meant() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(nearest("worker.concurency"), "worker.concurrency");
        assert_eq!(nearest("concurrency"), "worker.concurrency");
        assert_eq!(nearest("server.fsync"), "store.fsync");
        assert_eq!(nearest("decompose.hulls"), "decompose.max_hulls");
    }
}
