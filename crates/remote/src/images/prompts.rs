//! What an image model is told.

use std::sync::LazyLock;

use serde_json::{Value, json};

use crate::prompt::Prompt;

/// The prompts, by what is painted.
pub struct Prompts {
    pub paint: Prompt,
    pub redraw: Prompt,
    pub redraw_on_backdrop: Prompt,
    pub top: Prompt,
}

/// All of them.
pub fn prompts() -> &'static Prompts {
    static PROMPTS: LazyLock<Prompts> = LazyLock::new(|| Prompts {
        paint: Prompt::new("paint", include_str!("../../../../config/prompts/paint.md")),
        redraw: Prompt::new("redraw", include_str!("../../../../config/prompts/redraw.md")),
        redraw_on_backdrop: Prompt::new(
            "redraw_on_backdrop",
            include_str!("../../../../config/prompts/redraw_on_backdrop.md"),
        ),
        top: Prompt::new("top", include_str!("../../../../config/prompts/top.md")),
    });
    &PROMPTS
}

/// Names, versions and digests of those for a painter that draws on no background.
pub(crate) fn identity() -> Value {
    let Prompts { paint, redraw, top, .. } = prompts();
    json!([paint, redraw, top].map(Prompt::identity))
}

/// And for one that draws before a backdrop.
pub(crate) fn identity_on_backdrop() -> Value {
    let Prompts { paint, redraw_on_backdrop, top, .. } = prompts();
    json!([paint, redraw_on_backdrop, top].map(Prompt::identity))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever changes a prompt raises its version and pins the new text here.
    #[test]
    fn no_prompt_changes_without_its_version() {
        let Prompts { paint, redraw, redraw_on_backdrop, top } = prompts();
        let pinned = [paint, redraw, redraw_on_backdrop, top]
            .map(|prompt| format!("{} {} {}", prompt.name, prompt.version, prompt.digest()));
        assert_eq!(
            pinned,
            [
                "paint 1 07d959f839712742",
                "redraw 1 aa5b8c76591ef077",
                "redraw_on_backdrop 1 95ed8fd47754e0db",
                "top 1 1562301c713b6200",
            ]
        );
        assert!(
            [paint, redraw, redraw_on_backdrop, top].iter().all(|prompt| prompt.text.contains("not obeyed"))
        );
    }
}
