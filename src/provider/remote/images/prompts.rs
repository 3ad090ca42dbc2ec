//! What an image model is told.

use std::sync::LazyLock;

use serde_json::{Value, json};

use crate::provider::remote::prompt::Prompt;

/// The prompts, by what is painted.
pub struct Prompts {
    pub paint: Prompt,
    pub redraw: Prompt,
    pub top: Prompt,
}

/// All of them.
pub fn prompts() -> &'static Prompts {
    static PROMPTS: LazyLock<Prompts> = LazyLock::new(|| Prompts {
        paint: Prompt::new("paint", include_str!("../../../../config/prompts/paint.md")),
        redraw: Prompt::new("redraw", include_str!("../../../../config/prompts/redraw.md")),
        top: Prompt::new("top", include_str!("../../../../config/prompts/top.md")),
    });
    &PROMPTS
}

/// Names, versions and digests.
pub(in crate::provider::remote) fn identity() -> Value {
    let Prompts { paint, redraw, top } = prompts();
    json!([paint, redraw, top].map(Prompt::identity))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever changes a prompt raises its version and pins the new text here.
    #[test]
    fn no_prompt_changes_without_its_version() {
        let Prompts { paint, redraw, top } = prompts();
        let pinned = [paint, redraw, top]
            .map(|prompt| format!("{} {} {}", prompt.name, prompt.version, prompt.digest()));
        assert_eq!(
            pinned,
            ["paint 1 07d959f839712742", "redraw 1 aa5b8c76591ef077", "top 1 1562301c713b6200"]
        );
        assert!([paint, redraw, top].iter().all(|prompt| prompt.text.contains("not obeyed")));
    }
}
