//! `edit`: a new scene from a bundle, by operations or by an instruction in words, by the server's code path.

mod sentences;

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use serde_json::{Value, json};

use super::bundle_input::BundleInput;
use super::generate::refused;
use super::local_job::{JobConfig, JobOptions};
use super::{Exit, Failure, certificate, scene_summary, terminal};
use crate::api::edits::{self, EditBody, EditOptions};
use crate::api::parent::ParentBundle;
use crate::api::submission::Submission;
use crate::app;
use crate::app::config::Resolved;
use scene::{EditOperation, Input};
use store::Digest;

/// Arguments of `edit`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("change").required(true).args(["text", "operations"])))]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// What to change, in words
    #[arg(long, value_name = "TEXT")]
    text: Option<String>,
    /// The same as a list of operations: JSON, or a file of it
    #[arg(long, value_name = "FILE_OR_JSON")]
    operations: Option<String>,
    /// Print what the edit will do, and make no scene
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    job: JobOptions,
}

/// Makes the scene, writes its bundle, prints its certificate and the operations. With `--json`, failures are printed as
/// a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.job.json;
    scene_summary::with_failure_document(edit(arguments), is_json)
}

fn edit(mut arguments: Arguments) -> Result<Exit, Failure> {
    let operations = arguments.operations.as_deref().map(read_operations).transpose()?;
    let JobConfig { resolved, own } = arguments.job.configure()?;
    let bundle = BundleInput::open(&arguments.bundle)?;
    let id = bundle.scene()?.id;
    let archive = bundle.into_archive()?;
    let parent = ParentBundle { id, digest: Digest::of(&archive) };
    let body = EditBody {
        operations,
        text: arguments.text.clone(),
        seed: arguments.job.seed,
        options: EditOptions { set: own, ..EditOptions::default() },
        ..EditBody::default()
    };
    let submission = edits::validate(
        body,
        &parent,
        resolved.config.server.max_text_chars,
        &app::pipeline::validate(&resolved),
        &app::pipeline::read_instruction(),
    )
    .map_err(|problem| refused(problem, "--text"))?;
    if arguments.dry_run {
        return predict(&resolved, &submission, &archive);
    }
    let operations = operations_of(&submission);
    let submission = Submission { bundle: Some(archive.into()), ..submission };
    let made = arguments.job.run(&resolved, submission)?;
    if arguments.job.json {
        let mut document = made.outcome.document(made.total_ms);
        document["operations"] = json!(operations);
        terminal::print(&format!("{document:#}\n"));
    } else {
        terminal::print(&certificate::table(&made.outcome, made.total_ms));
        for (index, operation) in operations.iter().enumerate() {
            terminal::print(&format!("  {:>2}. {}\n", index + 1, sentences::sentence(operation)));
        }
    }
    Ok(made.exit())
}

/// Prints the answer of `POST /scenes/{id}/edits?validate_only=true`.
fn predict(resolved: &Resolved, submission: &Submission, archive: &[u8]) -> Result<Exit, Failure> {
    let prediction = app::pipeline::predict(resolved)(&submission.request, archive);
    let prediction = prediction.map_err(|problem| refused(problem, "--text"))?;
    let document = json!({ "valid": true, "request": submission.request, "prediction": prediction });
    terminal::print(&format!("{document:#}\n"));
    Ok(Exit::Success)
}

fn operations_of(submission: &Submission) -> Vec<EditOperation> {
    match &submission.request.input {
        Input::Edit { operations, .. } => operations.clone(),
        Input::Text { .. } | Input::Image { .. } => Vec::new(),
    }
}

/// The items of a list of operations, or of `operations` in an object, as JSON or in a file.
fn read_operations(argument: &str) -> Result<Vec<Value>, Failure> {
    let wrong = |why: String| Failure::usage(format!("--operations: {why}"));
    let is_json = argument.trim_start().starts_with(['[', '{']);
    let text = match is_json {
        true => argument.to_owned(),
        false => std::fs::read_to_string(argument)
            .map_err(|error| wrong(format!("cannot read the file {argument}: {error}")))?,
    };
    let document: Value =
        serde_json::from_str(&text).map_err(|error| wrong(format!("is no JSON: {error}")))?;
    let items = match document {
        Value::Array(items) => Some(items),
        Value::Object(mut fields) if fields.len() == 1 => match fields.remove("operations") {
            Some(Value::Array(items)) => Some(items),
            _ => None,
        },
        _ => None,
    };
    items.ok_or_else(|| wrong("must be a list of operations such as [{\"op\": \"tidy\"}]".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_come_as_json_or_from_a_file() {
        let home = tempfile::tempdir().expect("temporary directory");
        let path = home.path().join("operations.json");
        std::fs::write(&path, "{\"operations\": [{\"op\": \"tidy\"}]}\n").expect("writes");
        for argument in
            ["[{\"op\": \"tidy\"}]", " {\"operations\": [{\"op\": \"tidy\"}]}", &path.display().to_string()]
        {
            let items = read_operations(argument).expect(argument);
            assert_eq!(items, [json!({ "op": "tidy" })], "{argument}");
        }
        for (argument, reason) in [
            ("[{\"op\": \"tidy\"", "is no JSON"),
            ("missing.json", "cannot read the file missing.json"),
            ("{}", "must be a list"),
            ("{\"operations\": 5}", "must be a list"),
            ("{\"operations\": [], \"seed\": 5}", "must be a list"),
        ] {
            let failure = read_operations(argument).expect_err(argument);
            assert!(failure.message.contains(reason), "{argument}: {failure}");
        }
    }
}
