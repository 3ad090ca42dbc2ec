//! The requests of a body one by one: read, checked as `POST /scenes` checks them, and compared with those before.

use std::io::Cursor;

use serde::de::IgnoredAny;

use super::App;
use crate::problem::{FieldError, Problem, ProblemType};
use ::batches::{BatchRequest, LineReader, OutputError, Recipe, Registry};
use scene::{Input, MicroUsd, SceneRequest};
use serde_json::json;
use store::batches::{ItemContent, NewItem, RecipeRest};

/// Largest recipe. It is short, however many requests it makes; its values are in memory together.
const MAX_RECIPE_BYTES: usize = 2 << 20;

/// Kind of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// One request per line.
    Lines,
    /// A recipe that expands to requests.
    Recipe,
}

impl BodyKind {
    /// The kind of a media type.
    pub fn of(media_type: &str) -> Result<Self, Problem> {
        match media_type {
            "application/jsonl" | "application/x-ndjson" | "application/x-jsonlines" => Ok(Self::Lines),
            "application/json" => Ok(Self::Recipe),
            _ => Err(Problem::new(
                ProblemType::UnsupportedMediaType,
                "body_format",
                "send application/jsonl with one request per line, or a recipe as application/json",
            )),
        }
    }
}

/// Reads requests and checks them.
#[derive(Clone, Debug)]
pub struct BatchReader {
    pub app: App,
}

impl BatchReader {
    /// Gives every request of the body to `take`, until that returns `false`.
    ///
    /// # Errors
    ///
    /// A [`Problem`] for a recipe that will not do, and for a body of no request or of too many.
    pub fn read(
        &self,
        kind: BodyKind,
        body: &[u8],
        mut take: impl FnMut(NewItem) -> bool,
    ) -> Result<(), Problem> {
        let mut registry = Registry::default();
        let mut count = 0;
        let mut next =
            |place, custom_id, request: Result<BatchRequest, OutputError>| -> Result<bool, Problem> {
                count += 1;
                if count > self.max_requests() {
                    return Err(self.too_many());
                }
                let content = match request {
                    Ok(request) => self.content(&mut registry, place, request),
                    Err(error) => ItemContent::Invalid(error),
                };
                Ok(take(NewItem { place, custom_id, content }))
            };
        match kind {
            BodyKind::Lines => {
                // Reading memory does not fail.
                for line in LineReader::new(Cursor::new(body)).map_while(Result::ok) {
                    let (custom_id, content) = match line.content {
                        Ok(request) => (Some(request.custom_id.clone()), Ok(request)),
                        Err(wrong) => (wrong.custom_id, Err(*wrong.error)),
                    };
                    if !next(line.number, custom_id, content)? {
                        return Ok(());
                    }
                }
            }
            BodyKind::Recipe => {
                let recipe = read_recipe(body)?;
                self.check_settings(&recipe)?;
                if recipe.request_count() > self.max_requests() {
                    return Err(self.too_many());
                }
                for (place, request) in (1..).zip(recipe.requests()) {
                    if !next(place, Some(request.custom_id.clone()), Ok(request))? {
                        return Ok(());
                    }
                }
            }
        }
        if count == 0 {
            let detail = "has no requests; send at least one line";
            return Err(Problem::invalid(vec![FieldError::new("", detail)]));
        }
        Ok(())
    }

    /// The next requests of a recipe, at most `limit`, and whether they are the last. Those before are made and checked
    /// again, as a request may ask for the scene of an earlier one; 100,000 take about two seconds.
    pub fn expand(&self, rest: &RecipeRest, limit: usize) -> (Vec<NewItem>, bool) {
        let recipe = match Recipe::parse(rest.recipe.as_bytes()) {
            Ok(recipe) => recipe,
            // Another version of the program has accepted it.
            Err(errors) => {
                let error = OutputError::new("invalid_request", errors.to_string());
                let content = ItemContent::Invalid(error.on_line(rest.first_place));
                return (vec![NewItem { place: rest.first_place, custom_id: None, content }], true);
            }
        };
        let mut registry = Registry::default();
        let mut items = Vec::new();
        for (place, request) in (1..).zip(recipe.requests()) {
            if items.len() == limit {
                return (items, false);
            }
            let custom_id = Some(request.custom_id.clone());
            let content = self.content(&mut registry, place, request);
            if place >= rest.first_place {
                items.push(NewItem { place, custom_id, content });
            }
        }
        (items, true)
    }

    /// Settings that the configuration does not accept would make each request with them invalid.
    fn check_settings(&self, recipe: &Recipe) -> Result<(), Problem> {
        let mut errors = Vec::new();
        for (pointer, options) in recipe.options() {
            let request = SceneRequest::new(Input::Text { text: String::new() }, 0, options.clone());
            errors.extend(self.app.violations(&request).into_iter().map(|error| {
                let within = error.pointer.strip_prefix("/options").unwrap_or(&error.pointer);
                FieldError::new(format!("{pointer}{within}"), error.detail)
            }));
        }
        if errors.is_empty() { Ok(()) } else { Err(Problem::invalid(errors)) }
    }

    fn max_requests(&self) -> u64 {
        self.app.config().batches.max_requests
    }

    fn too_many(&self) -> Problem {
        let detail = format!("has more than {} requests; send several batches", self.max_requests());
        Problem::invalid(vec![FieldError::new("", detail)])
    }

    /// Stored content of a request.
    fn content(&self, registry: &mut Registry, place: u64, request: BatchRequest) -> ItemContent {
        // What is invalid is no first of its kind.
        if request.body.image.is_some() {
            let message = "a batch of the server has texts only; submit images to /scenes one by one";
            let error = OutputError::new("invalid_request", message).at("/body/image");
            return ItemContent::Invalid(error.on_line(place));
        }
        let submission = match self.app.check_batch_request(&request, None) {
            Ok(submission) => submission,
            Err(error) => return ItemContent::Invalid(error.on_line(place)),
        };
        if let Some(line) = registry.refusal(place, &request) {
            let error = line.error.unwrap_or_default();
            return match line.duplicate_of {
                Some(of) => ItemContent::Duplicate { of, error },
                None => ItemContent::Invalid(error),
            };
        }
        let budget: MicroUsd = submission.request.options.budget(self.app.config().server.usual_budget_usd);
        ItemContent::Request { request: json!(submission.request), labels: submission.labels, budget }
    }
}

fn read_recipe(body: &[u8]) -> Result<Recipe, Problem> {
    if body.len() > MAX_RECIPE_BYTES {
        let detail =
            format!("a recipe has at most {MAX_RECIPE_BYTES} bytes; send requests as application/jsonl");
        return Err(Problem::new(ProblemType::PayloadTooLarge, "body_too_large", detail));
    }
    if let Err(error) = serde_json::from_slice::<IgnoredAny>(body) {
        let detail = format!("the body is no JSON of a recipe: {error}");
        return Err(Problem::new(ProblemType::MalformedRequest, "malformed_json", detail));
    }
    Recipe::parse(body).map_err(|errors| {
        let errors = errors.0.into_iter().map(|error| FieldError::new(error.pointer, error.detail));
        Problem::invalid(errors.collect())
    })
}
