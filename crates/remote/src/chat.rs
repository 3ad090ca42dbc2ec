//! The analyst over an OpenAI-compatible chat endpoint: OpenAI, OpenRouter, Ark, vLLM, Ollama, llama.cpp.
//!
//! Each question is a prompt of `config/prompts/`, a strict JSON schema and, where it is about a picture, the
//! picture. An answer is data: it is read by its schema ([`conversation`]), every number has a range, every
//! name is one that was given, and what does not hold is told to the model once. Words of users and of
//! pictures reach the model only as data that the prompts say not to obey, and whatever it answers can do no
//! more than describe things on a table.
//!
//! [`describe`] plans a scene from words; [`recognize`] reads a picture in three turns: what is there, how
//! large it is ([`measure`]), what carries what ([`stacking`]); [`check_top`] looks at drawn views from
//! above; [`upright`] says how meshes are turned, and the picture has a say in it; [`judge`] rates finished
//! scenes, [`propose_tasks`] thinks of what a robot could do in them.

pub mod wire;
pub mod prompts;
pub mod schema;
pub mod conversation;
pub mod proofreading;
pub mod words;
pub mod describe;
pub mod recognize;
pub mod measure;
pub mod stacking;
pub mod check_top;
pub mod upright;
pub mod judge;
pub mod propose_tasks;
pub mod seen_camera;

use std::sync::Arc;

use serde_json::json;

use super::prompt::Prompt;
use super::{ChatSettings, Endpoint};
use ports::{
    Adapter, Answer, Call, Judgement, Port, ProviderError, Reference, SceneAnalyst, TaskQuestion, TopCheck,
    TopVerdict, Upright, UprightQuestion,
};
use scene::appraisal::{Opinion, ProposedTask, Rating};
use scene::request::RequestOptions;
use scene::{Recognition, SceneDescription};

/// Name of the adapter.
pub const NAME: &str = "openai/chat";

/// Asks a chat endpoint.
pub struct ChatAnalyst {
    pub settings: ChatSettings,
    pub endpoint: Arc<Endpoint>,
}

impl SceneAnalyst for ChatAnalyst {
    fn adapter(&self) -> Adapter {
        let ChatSettings { endpoint, schema, temperature, send_seed, detail, picture_px, .. } =
            &self.settings;
        let settings = json!({
            "base_url": endpoint.base_url, "schema": schema, "temperature": temperature, "send_seed": send_seed,
            "detail": detail, "picture_px": picture_px, "max_output_tokens": self.settings.max_output_tokens,
            "prompts": prompts::identity(), "schemas": schema::identity(),
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
        reference: Reference,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, Recognition> {
        Box::pin(recognize::recognize(self, call, reference, seed, options))
    }

    fn check_top_view<'a>(&'a self, call: &'a Call, question: TopCheck) -> Answer<'a, TopVerdict> {
        Box::pin(check_top::check(self, call, question))
    }

    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright> {
        Box::pin(upright::upright(self, call, question))
    }

    fn judge<'a>(&'a self, call: &'a Call, question: Judgement) -> Answer<'a, Opinion<Vec<Rating>>> {
        Box::pin(judge::judge(self, call, question))
    }

    fn propose_tasks<'a>(
        &'a self,
        call: &'a Call,
        question: TaskQuestion,
    ) -> Answer<'a, Opinion<Vec<ProposedTask>>> {
        Box::pin(propose_tasks::propose(self, call, question))
    }
}

impl ChatAnalyst {
    /// What this model said to a prompt.
    fn opinion<T>(&self, prompt: &Prompt, said: T) -> Opinion<T> {
        let prompt = format!("{} {}", prompt.name, prompt.version);
        Opinion { by: NAME.to_owned(), model: self.settings.model.clone(), prompt, said }
    }
}

/// What cannot be asked of anybody.
pub(super) fn rejected(code: &'static str, reason: String) -> ProviderError {
    ProviderError::Rejected { port: Port::Analyst, code, reason }
}

#[cfg(test)]
pub(super) mod tests;
