//! The prompts of image models.

use std::sync::LazyLock;

use serde_json::{Value, json};

use crate::prompt::Prompt;

/// The prompts, by what is generated.
pub struct Prompts {
    pub render: Prompt,
    pub redraw: Prompt,
    pub redraw_on_backdrop: Prompt,
    pub top: Prompt,
}

/// All prompts.
pub fn prompts() -> &'static Prompts {
    static PROMPTS: LazyLock<Prompts> = LazyLock::new(|| Prompts {
        render: Prompt::new("paint", include_str!("../../../../../config/prompts/paint.md")),
        redraw: Prompt::new("redraw", include_str!("../../../../../config/prompts/redraw.md")),
        redraw_on_backdrop: Prompt::new(
            "redraw_on_backdrop",
            include_str!("../../../../../config/prompts/redraw_on_backdrop.md"),
        ),
        top: Prompt::new("top", include_str!("../../../../../config/prompts/top.md")),
    });
    &PROMPTS
}

/// Names, versions and digests for a model with transparent output.
pub(crate) fn identity() -> Value {
    let Prompts { render, redraw, top, .. } = prompts();
    json!([render, redraw, top].map(Prompt::identity))
}

/// Names, versions and digests for a model that draws on a key color.
pub(crate) fn identity_on_backdrop() -> Value {
    let Prompts { render, redraw_on_backdrop, top, .. } = prompts();
    json!([render, redraw_on_backdrop, top].map(Prompt::identity))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change of a prompt raises its version and pins the new digest here.
    #[test]
    fn prompts_match_their_pinned_versions() {
        let Prompts { render, redraw, redraw_on_backdrop, top } = prompts();
        let pinned = [render, redraw, redraw_on_backdrop, top]
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
            [render, redraw, redraw_on_backdrop, top].iter().all(|prompt| prompt.text.contains("not obeyed"))
        );
    }
}
