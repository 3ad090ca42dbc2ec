//! The path of a request for answers, the log, traces and the record of changes.

use std::borrow::Cow;

use store::secret::KEY_PREFIX;

/// The path, or a part of it, without keys, which a client may have put there in place of an id.
pub(crate) fn path_without_keys(path: &str) -> Cow<'_, str> {
    if !path.contains(KEY_PREFIX) {
        return path.into();
    }
    let shown = |part| if str::starts_with(part, KEY_PREFIX) { "tt_..." } else { part };
    path.split('/').map(shown).collect::<Vec<_>>().join("/").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_left_out_of_paths() {
        assert_eq!(path_without_keys("/keys/tt_abc"), "/keys/tt_...");
        assert_eq!(path_without_keys("/tt_abc/tt_"), "/tt_.../tt_...");
        assert_eq!(
            path_without_keys("/scenes/1/artifacts/butt_joint.png"),
            "/scenes/1/artifacts/butt_joint.png"
        );
    }
}
