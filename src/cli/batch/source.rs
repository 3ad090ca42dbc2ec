//! The file of a batch: JSON lines, or a recipe.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use crate::cli::{Failure, input_file};
use batches::{BatchRequest, LineReader, OutputError, Recipe};

const ADVICE: &str = "give a .jsonl file with one request per line, or a recipe in a .json file";

/// Largest recipe, bytes.
const MAX_RECIPE_BYTES: u64 = 64 << 20;

/// A file that can be read as often as necessary.
pub(super) struct Source {
    path: PathBuf,
    kind: Kind,
    limit: usize,
    /// Settings of every request that does not state its own.
    set: BTreeMap<String, String>,
}

enum Kind {
    Lines,
    Recipe(Box<Recipe>),
}

/// A request, or why there is none.
pub(super) struct Entry {
    /// Line of the file, or number of the request of a recipe, from 1.
    pub(super) place: u64,
    pub(super) content: Result<BatchRequest, Rejection>,
}

/// A request that will not do.
pub(super) struct Rejection {
    pub(super) custom_id: Option<String>,
    pub(super) error: OutputError,
}

impl Source {
    /// Opens the file; a recipe is checked whole.
    pub(super) fn open(
        path: &Path,
        limit: Option<usize>,
        set: BTreeMap<String, String>,
    ) -> Result<Self, Failure> {
        let about = std::fs::metadata(path).map_err(|error| unreadable(path, &error))?;
        if !about.is_file() {
            return Err(Failure::usage(format!("{} is not a file; {ADVICE}", path.display())));
        }
        let kind = match path.extension().and_then(|extension| extension.to_str()) {
            Some("jsonl" | "ndjson") => Kind::Lines,
            Some("json") if about.len() > MAX_RECIPE_BYTES => {
                let message = "a recipe has at most 64 MiB; give requests as .jsonl";
                return Err(Failure::usage(format!("{}: {message}", path.display())));
            }
            Some("json") => {
                let json = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
                let recipe = Recipe::parse(&json).map_err(|errors| {
                    Failure::usage(format!("the recipe {} will not do:\n{errors}", path.display()))
                })?;
                Kind::Recipe(Box::new(recipe))
            }
            _ => {
                return Err(Failure::usage(format!(
                    "{} is neither .jsonl (one request per line) nor .json (a recipe); rename it",
                    path.display()
                )));
            }
        };
        Ok(Self { path: path.to_owned(), kind, limit: limit.unwrap_or(usize::MAX), set })
    }

    /// Folder from which relative paths of images begin.
    pub(super) fn folder(&self) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).to_owned()
    }

    /// Text of an error with its place, for messages.
    pub(super) fn shown(&self, error: &OutputError) -> String {
        let place = [error.line, error.column].into_iter().flatten();
        let place: String = place.map(|number| format!(":{number}")).collect();
        let pointer = error.pointer.as_deref().filter(|pointer| !pointer.is_empty());
        let pointer = pointer.map(|pointer| format!(" {pointer}")).unwrap_or_default();
        format!("{}{place}:{pointer} {} ({})", self.path.display(), error.message, error.code)
    }

    /// The requests in order, from the beginning.
    pub(super) fn entries(&self) -> Result<impl Iterator<Item = Result<Entry, Failure>> + '_, Failure> {
        let entries: Box<dyn Iterator<Item = Result<Entry, Failure>> + '_> = match &self.kind {
            Kind::Lines => {
                let file = File::open(&self.path).map_err(|error| unreadable(&self.path, &error))?;
                Box::new(LineReader::new(BufReader::new(file)).map(|line| -> Result<Entry, Failure> {
                    let line = line.map_err(|error| unreadable(&self.path, &error))?;
                    let content = line
                        .content
                        .map_err(|wrong| Rejection { custom_id: wrong.custom_id, error: *wrong.error });
                    Ok(Entry { place: line.number, content })
                }))
            }
            Kind::Recipe(recipe) => {
                let places = 1_u64..;
                Box::new(
                    places
                        .zip(recipe.requests())
                        .map(|(place, request)| Ok(Entry { place, content: Ok(request) })),
                )
            }
        };
        Ok(entries.take(self.limit).map(|entry| entry.map(|entry| self.with_own_settings(entry))))
    }

    fn with_own_settings(&self, mut entry: Entry) -> Entry {
        if let Ok(request) = &mut entry.content {
            for (key, value) in &self.set {
                request.body.options.set.entry(key.clone()).or_insert_with(|| value.clone());
            }
        }
        entry
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    input_file::unreadable(path, "the requests", error, ADVICE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Exit;

    fn file(name: &str, content: &str) -> (tempfile::TempDir, PathBuf) {
        let home = tempfile::tempdir().expect("temporary directory");
        let path = home.path().join(name);
        std::fs::write(&path, content).expect("writes");
        (home, path)
    }

    #[test]
    fn the_kind_of_the_file_follows_its_name() {
        for (name, content, count) in [
            ("a.jsonl", "{\"custom_id\":\"a\",\"body\":{\"text\":\"a mug\"}}\nnonsense\n", 2),
            ("a.json", r#"{"templates": ["a mug"], "seeds": [1, 2, 3]}"#, 3),
        ] {
            let (_home, path) = file(name, content);
            let source = Source::open(&path, None, BTreeMap::new()).expect(name);
            assert_eq!(source.entries().expect("opens").count(), count);
            let limited = Source::open(&path, Some(1), BTreeMap::new()).expect(name);
            assert_eq!(limited.entries().expect("opens").count(), 1);
        }
        for (name, content, says) in [
            ("a.txt", "", "neither .jsonl"),
            ("a.json", "{\"templates\": []}", "/templates: has no templates"),
        ] {
            let (_home, path) = file(name, content);
            let failure = Source::open(&path, None, BTreeMap::new()).err().expect(name);
            assert_eq!(failure.exit, Exit::Usage);
            assert!(failure.message.contains(says), "{}", failure.message);
        }
    }

    #[test]
    fn settings_of_the_command_line_yield_to_those_of_a_request() {
        let line = r#"{"custom_id":"a","body":{"text":"a mug","options":{"set":{"tsa.a":"1"}}}}"#;
        let (_home, path) = file("a.jsonl", line);
        let set = [("tsa.a", "2"), ("tsa.b", "3")].map(|(key, value)| (key.to_owned(), value.to_owned()));
        let source = Source::open(&path, None, set.into()).expect("opens");
        let entry = source.entries().expect("opens").next().expect("a line").expect("reads");
        let own = entry.content.ok().expect("a request").body.options.set;
        assert_eq!((own["tsa.a"].as_str(), own["tsa.b"].as_str()), ("1", "3"));
    }
}
