//! `edit`: a new scene from a bundle, by operations or by an instruction in words, by the server's code path.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use serde_json::{Value, json};

use super::bundle_input::BundleInput;
use super::generate::refused;
use super::local_job::{JobConfig, JobOptions};
use super::{Exit, Failure, certificate, input_file, instructions, scene_summary, terminal};
use crate::app::App;
use crate::app::edit_scene::{EditOrder, ParentBundle};
use crate::app::submission::Submission;
use crate::app::terms::Terms;
use scene::edit::EditAccount;
use scene::request::RequestOptions;
use store::Digest;

/// Arguments of `edit`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("change").required(true).args(["text", "operations"])))]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// The change, in words
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
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

/// Makes the scene, writes its bundle, prints its certificate and the operations. With `--json`, failures are printed
/// as a document, too.
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
    let options =
        RequestOptions { set: own, robot: arguments.job.robot.clone(), ..RequestOptions::default() };
    let terms = Terms { seed: arguments.job.seed, options, ..Terms::default() };
    let mut order = EditOrder { operations, text: arguments.text.clone(), program: None, terms };
    let refusal = |problem| refused(problem, "--text");
    instructions::read_edit(&resolved, &archive, &mut order, refusal)?;
    let app = App::new(&resolved);
    let submission = app.check_edit(order, &parent).map_err(refusal)?;
    if arguments.dry_run {
        return predict(&app, &submission, &archive);
    }
    let place = arguments.job.place(&inputs(&arguments))?;
    let submission = Submission { bundle: Some(archive.into()), ..submission };
    let made = arguments.job.run(&resolved, submission, place)?;
    match arguments.job.json {
        true => terminal::print(&format!("{:#}\n", made.outcome.document(made.total_ms))),
        false => {
            terminal::print(&certificate::table(&made.outcome, made.total_ms));
            let account = serde_json::from_value::<EditAccount>(made.outcome.summary["edit"].clone());
            terminal::print(&account.map(|account| lines(&account)).unwrap_or_default());
        }
    }
    Ok(made.exit())
}

/// The bundle, and the file of the operations.
fn inputs(arguments: &Arguments) -> Vec<&Path> {
    let file = arguments.operations.as_deref().filter(|given| !is_json(given)).map(Path::new);
    std::iter::once(&*arguments.bundle).chain(file).collect()
}

/// Prints the answer of `POST /scenes/{scene_id}/edits/validate`.
fn predict(app: &App, submission: &Submission, archive: &[u8]) -> Result<Exit, Failure> {
    let prediction = app.predict_edit(&submission.request, archive);
    let prediction = prediction.map_err(|problem| refused(problem, "--text"))?;
    let document = json!({ "valid": true, "request": submission.request, "prediction": prediction });
    terminal::print(&format!("{document:#}\n"));
    Ok(Exit::Success)
}

/// One line for each operation, and for each object that moved although no operation names it.
pub(super) fn lines(account: &EditAccount) -> String {
    let mut text = String::new();
    for (index, operation) in account.operations.iter().enumerate() {
        // Writing to a string cannot fail.
        let words = operation.words.as_ref().map_or(String::new(), |words| format!(" ({words:?})"));
        let _ = writeln!(text, "  {:>2}. {}{words}", index + 1, operation.sentence);
    }
    for words in &account.asides {
        let _ = writeln!(text, "  nothing asked by {words:?}");
    }
    for moved in &account.moved {
        let (distance_mm, turn_deg) = (moved.distance_m * 1000.0, moved.angle_rad.to_degrees());
        let _ = writeln!(
            text,
            "  {} moved {distance_mm:.2} mm and turned {turn_deg:.1}°: {}",
            moved.name, moved.cause
        );
    }
    text
}

const ADVICE: &str = "give a list of operations such as [{\"op\": \"tidy\"}], or a file of it";

/// The items of a list of operations, or of `operations` in an object, as JSON or in a file.
fn read_operations(argument: &str) -> Result<Vec<Value>, Failure> {
    let wrong = |why: String| Failure::usage(format!("--operations: {why}"));
    let document: Value = match is_json(argument) {
        true => serde_json::from_str(argument).map_err(|error| wrong(format!("is no JSON: {error}")))?,
        false => input_file::json(Path::new(argument), "the operations", ADVICE)?,
    };
    let items = match document {
        Value::Array(items) => Some(items),
        Value::Object(mut fields) if fields.len() == 1 => match fields.remove("operations") {
            Some(Value::Array(items)) => Some(items),
            _ => None,
        },
        _ => None,
    };
    items.ok_or_else(|| wrong(format!("{argument} is no list of operations; {ADVICE}")))
}

/// Whether an argument is a document and no name of a file.
fn is_json(argument: &str) -> bool {
    argument.trim_start().starts_with(['[', '{'])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_operation_and_each_moved_object_has_a_line() {
        let account: EditAccount = serde_json::from_value(json!({
            "parent": "0a1b",
            "operations": [
                { "op": "move", "objects": ["bowl_1"], "sentence": "bowl_1 is at the back" },
                { "op": "tidy", "objects": [], "sentence": "nothing to tidy" },
            ],
            "moved": [{ "name": "apple_1", "distance_m": 0.1, "angle_rad": 0.5, "cause": "it lies in bowl_1" }],
        }))
        .expect("an account");
        let expected = "   1. bowl_1 is at the back\n   2. nothing to tidy\n  \
                        apple_1 moved 100.00 mm and turned 28.6°: it lies in bowl_1\n";
        assert_eq!(lines(&account), expected);
    }

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
            ("missing.json", "cannot read the operations missing.json: there is no such file; give a list"),
            ("{}", "is no list of operations"),
            ("{\"operations\": 5}", "is no list of operations"),
            ("{\"operations\": [], \"seed\": 5}", "is no list of operations"),
        ] {
            let failure = read_operations(argument).expect_err(argument);
            assert!(failure.message.contains(reason), "{argument}: {failure}");
        }
    }
}
