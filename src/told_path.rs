//! The path of a request as answers, the log, traces and the record of changes tell it.

use std::borrow::Cow;

use store::secret::KEY_PREFIX;

/// The path, or a part of it, without keys, which a client may have put there in place of an id.
pub(crate) fn told_path(path: &str) -> Cow<'_, str> {
    if !path.contains(KEY_PREFIX) {
        return path.into();
    }
    let told = |part| if str::starts_with(part, KEY_PREFIX) { "tt_..." } else { part };
    path.split('/').map(told).collect::<Vec<_>>().join("/").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_left_out_of_paths() {
        assert_eq!(told_path("/keys/tt_abc"), "/keys/tt_...");
        assert_eq!(told_path("/tt_abc/tt_"), "/tt_.../tt_...");
        assert_eq!(told_path("/scenes/1/artifacts/butt_joint.png"), "/scenes/1/artifacts/butt_joint.png");
    }
}
