//! `parse`: what a text is understood as, without a scene: the answer of `POST /scenes/validate`.

use clap::Args;
use serde_json::json;

use super::generate::refused;
use super::options::{ConfigOptions, TextOptions};
use super::text_account::Detail;
use super::{Exit, Failure, number, scene_summary, terminal, text_account};
use crate::app::App;
use crate::app::submission::SceneOrder;
use crate::app::terms::Terms;
use crate::problem::Problem;

/// Arguments of `parse`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Description of the table and the objects on it, in words
    #[arg(value_name = "TEXT", allow_hyphen_values = true)]
    text: String,
    /// The seed of the scene, which selects what a theme adds [default: random]
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        value_parser = number::seed
    )]
    seed: Option<u64>,
    #[command(flatten)]
    reading: TextOptions,
    /// Print one JSON document instead of the table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Prints the account of the text. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(parse(arguments), is_json)
}

fn parse(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let options = arguments.reading.request_options();
    let terms = Terms { seed: arguments.seed, options, ..Terms::default() };
    let app = App::new(&resolved);
    let submission = app
        .check_scene(SceneOrder { text: Some(arguments.text), image: None, depth: None, terms })
        .map_err(|problem| refused(problem, "TEXT"))?;
    let account = app.account(&submission.request).map_err(|error| {
        let detail = error.detail.clone();
        Failure { message: detail, ..refused(Problem::invalid(vec![error]), "TEXT") }
    })?;
    let Some(account) = account else {
        let message = "a remote model reads texts (providers.analyst), and only `generate` asks it; \
                       add --set providers.analyst=embedded for the built-in parser";
        return Err(Failure::usage(message));
    };
    match arguments.json {
        true => {
            let document = json!({ "valid": true, "request": submission.request, "text": account });
            terminal::print(&format!("{document:#}\n"));
        }
        false => terminal::print(&text_account::table(&account, Detail::All)),
    }
    Ok(Exit::Success)
}
