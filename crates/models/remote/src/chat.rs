//! The analyst over an OpenAI-compatible chat endpoint: OpenAI, OpenRouter, Ark, vLLM, Ollama, llama.cpp.
//!
//! Each question consists of a prompt of `config/prompts/`, a strict JSON schema and, where needed, images. An answer
//! is parsed by its schema: every number has a range, and every name is a given one. One repair turn reports
//! violations to the model ([`repair_turn`]). Texts of users and of images reach the model as data that the prompts
//! declare as not to be obeyed. An answer can only describe objects on a table.
//!
//! | question | answer |
//! | --- | --- |
//! | [`describe`] | a scene description from a text |
//! | [`recognize`] | objects and camera of an image, then sizes ([`measure`]) and supports ([`stacking`]) |
//! | [`check_top`] | whether a generated top view is usable |
//! | [`upright`] | the top and the front of a mesh, one kind of evidence beside size and image |
//! | [`judge`] | ratings of a finished scene |
//! | [`propose_tasks`] | robot tasks in a finished scene |
//! | [`read_edit`], [`read_task`] | the program of an instruction about a finished scene ([`instructions`]) |

pub mod wire;
pub mod prompts;
pub mod schema;
pub mod repair_turn;
pub mod response_check;
pub mod response_values;
pub mod describe;
mod object_kinds;
pub mod recognize;
pub mod measure;
pub mod stacking;
pub mod check_top;
pub mod upright;
pub mod judge;
pub mod propose_tasks;
mod instructions;
pub mod read_edit;
pub mod read_task;
pub mod camera_estimate;

use std::sync::Arc;

use serde_json::{Value, json};

use super::prompt::Prompt;
use super::{ChatSettings, Endpoint};
use ports::{
    Adapter, Answer, Call, Instruction, InstructionReader, Judgement, Port, ProviderError, RecognitionHints,
    ReferenceImage, SceneAnalyst, TaskQuestion, TopCheck, TopVerdict, Upright, UprightQuestion,
};
use scene::appraisal::{Criterion, ModelResponse, ProposedTask, Rating};
use scene::request::RequestOptions;
use scene::{EditProgram, Recognition, SceneDescription, TaskProgram};

/// Name of the adapter.
pub const NAME: &str = "openai/chat";

/// The analyst of a chat endpoint.
pub struct ChatAnalyst {
    pub settings: ChatSettings,
    pub endpoint: Arc<Endpoint>,
}

impl SceneAnalyst for ChatAnalyst {
    fn adapter(&self) -> Adapter {
        let ChatSettings { endpoint, schema, temperature, send_seed, detail, image_px, .. } = &self.settings;
        let settings = json!({
            "base_url": endpoint.base_url, "schema": schema, "temperature": temperature, "send_seed": send_seed,
            "detail": detail, "image_px": image_px, "max_output_tokens": self.settings.max_output_tokens,
            "prompts": prompts::identity(), "schemas": schemas(),
        });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn describe<'a>(
        &'a self,
        call: &'a Call,
        text: String,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, SceneDescription> {
        Box::pin(describe::describe(self, call, text, seed, options))
    }

    fn recognize<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        seed: u64,
        options: RequestOptions,
        hints: Option<Arc<RecognitionHints>>,
    ) -> Answer<'a, Recognition> {
        Box::pin(recognize::recognize(self, call, reference, seed, options, hints))
    }

    fn adapter_with_hints(&self) -> Adapter {
        let mut adapter = self.adapter();
        adapter.settings["prompts"] = prompts::identity_with_hints();
        adapter
    }

    fn check_top_view<'a>(&'a self, call: &'a Call, question: TopCheck) -> Answer<'a, TopVerdict> {
        Box::pin(check_top::check(self, call, question))
    }

    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright> {
        Box::pin(upright::upright(self, call, question))
    }

    fn judge<'a>(&'a self, call: &'a Call, question: Judgement) -> Answer<'a, ModelResponse<Vec<Rating>>> {
        Box::pin(judge::judge(self, call, question))
    }

    fn propose_tasks<'a>(
        &'a self,
        call: &'a Call,
        question: TaskQuestion,
    ) -> Answer<'a, ModelResponse<Vec<ProposedTask>>> {
        Box::pin(propose_tasks::propose(self, call, question))
    }
}

impl InstructionReader for ChatAnalyst {
    fn read_edit<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, EditProgram> {
        Box::pin(read_edit::read(self, call, instruction))
    }

    fn read_task<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, TaskProgram> {
        Box::pin(read_task::read(self, call, instruction))
    }
}

impl ChatAnalyst {
    /// The value with the identity of the model and of the prompt.
    fn opinion<T>(&self, prompt: &Prompt, said: T) -> ModelResponse<T> {
        let prompt = format!("{} {}", prompt.name, prompt.version);
        ModelResponse { by: NAME.to_owned(), model: self.settings.model.clone(), prompt, said }
    }
}

/// The schemas of all questions about scenes, which are part of the adapter's identity.
fn schemas() -> Value {
    json!([
        describe::schema(),
        recognize::schema(),
        measure::schema(),
        stacking::schema(),
        check_top::schema(),
        upright::schema(),
        judge::schema(&Criterion::OF_IMAGE),
        judge::schema(&Criterion::OF_TEXT),
        propose_tasks::schema(),
    ])
}

/// The schemas of all questions.
#[cfg(test)]
fn all_schemas() -> Vec<Value> {
    let mut all = schemas().as_array().cloned().unwrap_or_default();
    all.extend([read_edit::schema(), read_task::schema()]);
    all
}

/// A question that no provider can answer.
pub(super) fn rejected(code: &'static str, reason: String) -> ProviderError {
    ProviderError::Rejected { port: Port::Analyst, code, reason }
}

#[cfg(test)]
pub(super) mod tests;
