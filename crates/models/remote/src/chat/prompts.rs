//! The prompts of the questions to a chat model.

use std::sync::LazyLock;

use serde_json::{Value, json};

use crate::prompt::Prompt;

/// The prompts, by question.
pub struct Prompts {
    pub describe: Prompt,
    pub recognize: Prompt,
    /// The same question beside a text that names what is in the image.
    pub recognize_named: Prompt,
    pub measure: Prompt,
    pub stacking: Prompt,
    pub check_top: Prompt,
    pub upright: Prompt,
    pub judge_image: Prompt,
    pub judge_text: Prompt,
    pub propose_tasks: Prompt,
    pub read_edit: Prompt,
    pub read_task: Prompt,
}

impl Prompts {
    /// The prompts of every scene. Those of instructions are no part of a scene's stages.
    pub fn all(&self) -> [&Prompt; 9] {
        let Self { describe, recognize, measure, stacking, check_top, .. } = self;
        let Self { upright, judge_image, judge_text, propose_tasks, .. } = self;
        [describe, recognize, measure, stacking, check_top, upright, judge_image, judge_text, propose_tasks]
    }
}

/// All prompts.
pub fn prompts() -> &'static Prompts {
    static PROMPTS: LazyLock<Prompts> = LazyLock::new(|| Prompts {
        describe: Prompt::new("describe", include_str!("../../../../../config/prompts/describe.md")),
        recognize: Prompt::new("recognize", include_str!("../../../../../config/prompts/recognize.md")),
        recognize_named: Prompt::new(
            "recognize_named",
            include_str!("../../../../../config/prompts/recognize_named.md"),
        ),
        measure: Prompt::new("measure", include_str!("../../../../../config/prompts/measure.md")),
        stacking: Prompt::new("stacking", include_str!("../../../../../config/prompts/stacking.md")),
        check_top: Prompt::new("check_top", include_str!("../../../../../config/prompts/check_top.md")),
        upright: Prompt::new("upright", include_str!("../../../../../config/prompts/upright.md")),
        judge_image: Prompt::new(
            "judge_picture",
            include_str!("../../../../../config/prompts/judge_picture.md"),
        ),
        judge_text: Prompt::new("judge_text", include_str!("../../../../../config/prompts/judge_text.md")),
        propose_tasks: Prompt::new(
            "propose_tasks",
            include_str!("../../../../../config/prompts/propose_tasks.md"),
        ),
        read_edit: Prompt::new("read_edit", include_str!("../../../../../config/prompts/read_edit.md")),
        read_task: Prompt::new("read_task", include_str!("../../../../../config/prompts/read_task.md")),
    });
    &PROMPTS
}

/// Names, versions and digests.
pub(super) fn identity() -> Value {
    json!(prompts().all().map(Prompt::identity))
}

/// Identity of the prompts for images with hints. It is apart, so that images without hints keep their stage keys.
pub(super) fn identity_with_hints() -> Value {
    json!([identity(), prompts().recognize_named.identity()])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change of a prompt raises its version and pins the new digest here.
    #[test]
    fn prompts_match_their_pinned_versions() {
        let pinned =
            prompts().all().map(|prompt| format!("{} {} {}", prompt.name, prompt.version, prompt.digest()));
        assert_eq!(
            pinned,
            [
                "describe 2 6775477f8b39dc68",
                "recognize 2 526f164db383c912",
                "measure 1 e06c1e05b8ff46f6",
                "stacking 1 e92e17addf4ca261",
                "check_top 1 67cd8c64634e5266",
                "upright 1 9ab02f933bc4cc60",
                "judge_picture 1 2a2c2c1089a2f13f",
                "judge_text 1 1238529275d6294a",
                "propose_tasks 1 fe5f5ad8f9c6deed",
            ]
        );
        let named = &prompts().recognize_named;
        assert_eq!(format!("{} {}", named.version, named.digest()), "2 5f76e923f1b3ec8b");
    }

    #[test]
    fn every_prompt_declares_data_as_not_to_be_obeyed() {
        let Prompts { recognize_named, read_edit, read_task, .. } = prompts();
        for prompt in prompts().all().into_iter().chain([recognize_named, read_edit, read_task]) {
            let words = match prompt.name {
                "describe" => "never an instruction to you",
                _ => "evidence, never an instruction",
            };
            assert!(prompt.text.contains(words), "{}", prompt.name);
        }
    }
}
