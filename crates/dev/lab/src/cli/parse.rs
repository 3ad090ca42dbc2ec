//! `parse`: describes texts with the embedded parser, without building scenes.
//!
//! Input: a file with one JSON string per line. Output: one JSON document per line, in the same order:
//! `{"description": SceneDescription}`, or `{"error": {"code", "message", "terms"}}` for a rejected text.
//! The same file and seed give the same bytes.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use embedded::text_parser::{DescribeError, DescribeOptions, TextParserSettings, describe};
use scene::SceneDescription;
use scene::request::OnUnknown;
use tabletopgen::cli::options::ConfigOptions;
use tabletopgen::cli::{Exit, Failure, terminal};

/// Maximum number of objects of a scene.
const MAX_OBJECTS: usize = 64;

/// Arguments of `parse`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// File with one JSON string per line
    #[arg(long, value_name = "FILE")]
    texts: PathBuf,
    /// Seed of every text
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    config: ConfigOptions,
}

/// The outcome of one text.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
enum Outcome {
    Description(Box<SceneDescription>),
    Error(Rejection),
}

/// The reason why a text has no description.
#[derive(Debug, Serialize)]
struct Rejection {
    code: &'static str,
    message: String,
    /// The words that are not known.
    terms: Vec<String>,
}

/// Describes every text of the file and prints the outcomes.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let settings = arguments.config.load(Vec::new())?.config.analyst;
    let content = std::fs::read_to_string(&arguments.texts).map_err(|error| {
        let path = arguments.texts.display();
        Failure::new(Exit::Error, format!("cannot read {path}: {error}; name a file with --texts"))
    })?;
    for text in texts(&content, &arguments.texts)? {
        let outcome = outcome(&text, arguments.seed, &settings);
        let line = serde_json::to_string(&outcome).map_err(|error| {
            Failure::new(Exit::Error, format!("the description of {text:?} has no JSON form: {error}; a bug"))
        })?;
        terminal::print(&(line + "\n"));
    }
    Ok(Exit::Success)
}

/// The strings of the file. Blank lines are skipped.
fn texts(content: &str, path: &Path) -> Result<Vec<String>, Failure> {
    let lines = content.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(index, line)| {
            serde_json::from_str(line).map_err(|error| {
                let place = format!("{}:{}", path.display(), index + 1);
                Failure::usage(format!("{place}: not a JSON string: {error}; quote every text"))
            })
        })
        .collect()
}

fn outcome(text: &str, seed: u64, settings: &TextParserSettings) -> Outcome {
    let options = DescribeOptions { max_objects: MAX_OBJECTS, table: None, on_unknown: OnUnknown::default() };
    match describe(text, seed, &options, settings) {
        Ok(description) => Outcome::Description(Box::new(description)),
        Err(error) => Outcome::Error(rejection(&error)),
    }
}

fn rejection(error: &DescribeError) -> Rejection {
    Rejection { code: error.code(), message: error.to_string(), terms: error.terms().to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> TextParserSettings {
        test_settings::section("analyst")
    }

    #[test]
    fn texts_are_json_strings_and_errors_name_the_line() {
        let path = Path::new("texts.jsonl");
        let read = texts("\"a mug\"\n\n\"two\\nlines\"\n", path).expect("two texts");
        assert_eq!(read, ["a mug", "two\nlines"]);
        let complaint = texts("\"a mug\"\na plate\n", path).expect_err("no JSON").message;
        assert!(complaint.starts_with("texts.jsonl:2: not a JSON string"), "{complaint}");
    }

    #[test]
    fn known_object_is_described_and_empty_text_rejected() {
        let described = serde_json::to_value(outcome("a desk with two mugs", 3, &settings())).expect("JSON");
        assert_eq!(described["description"]["objects"][1]["category"], "mug");
        let rejected = serde_json::to_value(outcome("", 3, &settings())).expect("JSON");
        assert_eq!(rejected["error"]["code"], "text_empty");
        assert!(rejected.get("description").is_none());
    }
}
