//! Reads and checks the document of a recipe.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;
use serde_json::{Map, Value};

use super::naming::{Extent, Names};
use super::template::Template;
use super::{Combinations, Recipe, RecipeError, RecipeErrors, Seeds, sampling, too_many};
use crate::json_error::{self, JsonError, escaped};
use crate::request::MAX_REQUESTS;
use scene::request::{MAX_SEED, RequestOptions};

/// Largest number of templates, of slots, and of values of a slot.
const MAX_LIST: usize = 100_000;
/// Longest template, that of the longest text of a scene.
const MAX_TEMPLATE_CHARS: usize = 4000;
/// Objects within options.
const OPTION_OBJECTS: [&str; 3] = ["", "/table", "/metric_anchor"];

/// The document; values whose errors need a place of their own are read by hand.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
struct Document {
    templates: Vec<String>,
    #[serde(default)]
    slots: Map<String, Value>,
    seeds: Option<Value>,
    options: Option<Value>,
    #[serde(default)]
    labels: BTreeMap<String, String>,
    select: Option<Select>,
}

#[derive(Deserialize)]
#[serde(tag = "mode", rename_all = "snake_case", deny_unknown_fields, expecting = "an object with `mode`")]
enum Select {
    // Braces: serde lets a variant without them have unknown members.
    Product {},
    Sample { count: u64, seed: u64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a list, or an object with `first` and `count`")]
struct SeedRange {
    first: u64,
    count: u64,
}

/// Errors as they are found.
#[derive(Default)]
struct Errors(Vec<RecipeError>);

impl Errors {
    fn add(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.0.push(RecipeError { pointer: pointer.into(), detail: detail.into() });
    }

    fn add_json(&mut self, prefix: &str, error: JsonError) {
        self.add(format!("{prefix}{}", error.pointer), error.detail);
    }
}

/// Reads a recipe.
pub(super) fn read(json: &[u8]) -> Result<Recipe, RecipeErrors> {
    let mut errors = Errors::default();
    let document: Document = match json_error::parse(json, &["/select"]) {
        Ok(document) => document,
        Err(error) if error.is_malformed => {
            errors.add(
                "",
                format!("is no JSON: {} (line {}, column {})", error.detail, error.line, error.column),
            );
            return Err(RecipeErrors(errors.0));
        }
        Err(error) => {
            errors.add_json("", error);
            return Err(RecipeErrors(errors.0));
        }
    };
    let slots = slots(&document.slots, &mut errors);
    let templates = templates(&document.templates, &slots, &mut errors);
    let seeds = seeds(document.seeds.as_ref(), &mut errors);
    let options = options(document.options.as_ref(), &mut errors);
    for violation in scene::labels::violations(&document.labels) {
        errors.add(format!("/labels{}", violation.pointer), violation.detail);
    }
    if !errors.0.is_empty() {
        return Err(RecipeErrors(errors.0));
    }
    let counts = combinations(&templates, &slots, options.len() as u64 * seeds.count());
    let total = counts.as_ref().and_then(|counts| counts.last()).map(|last| last.first + last.count);
    let sample = match (document.select.unwrap_or(Select::Product {}), total) {
        (Select::Product {}, Some(total)) if total <= MAX_REQUESTS => None,
        (Select::Product {}, total) => {
            errors.add("", too_many(total));
            None
        }
        (Select::Sample { .. }, None) => {
            errors.add("", "has more than 10^19 combinations; give fewer values");
            None
        }
        (Select::Sample { count, seed }, Some(total)) => {
            if count == 0 || count > MAX_REQUESTS || count > total {
                let limit = total.min(MAX_REQUESTS);
                errors.add("/select/count", format!("must be from 1 to {limit}; {total} combinations exist"));
                None
            } else if seed > MAX_SEED {
                errors.add("/select/seed", format!("must be at most {MAX_SEED}"));
                None
            } else {
                Some(sampling::distinct_below(total, count, seed))
            }
        }
    };
    if !errors.0.is_empty() {
        return Err(RecipeErrors(errors.0));
    }
    let extent = Extent {
        templates: templates.iter().map(|template| template.slots.as_slice()).collect(),
        option_count: options.len(),
        largest_seed: seeds.largest(),
    };
    let names = Names::new(&slots, &extent);
    let counts = counts.unwrap_or_default();
    let lists_options = document.options.is_some_and(|options| options.is_array());
    let labels = document.labels;
    Ok(Recipe { templates, slots, seeds, options, lists_options, labels, counts, sample, names })
}

/// Values by slot, in the order of the document.
fn slots(document: &Map<String, Value>, errors: &mut Errors) -> Vec<(String, Vec<String>)> {
    if document.len() > MAX_LIST {
        errors.add("/slots", format!("has more than {MAX_LIST} slots"));
        return Vec::new();
    }
    let slots = document.iter().map(|(name, values)| {
        let pointer = format!("/slots/{}", escaped(name));
        if name.is_empty() || name.trim() != name || name.contains(['{', '}']) {
            errors.add(&pointer, "a name of a slot has no braces and no space around it, and is not empty");
        }
        (name.clone(), slot_values(values, &pointer, errors))
    });
    slots.collect()
}

fn slot_values(values: &Value, pointer: &str, errors: &mut Errors) -> Vec<String> {
    let Some(values) = values.as_array() else {
        errors.add(pointer, "must be a list of texts or numbers");
        return Vec::new();
    };
    if values.is_empty() {
        errors.add(pointer, "has no values; give at least one");
    } else if values.len() > MAX_LIST {
        errors.add(pointer, format!("has more than {MAX_LIST} values"));
        return Vec::new();
    }
    let mut used = BTreeSet::new();
    let texts = values.iter().enumerate().map(|(index, value)| {
        let text = match value {
            Value::String(text) => text.split_whitespace().collect::<Vec<_>>().join(" "),
            Value::Number(number) => number.to_string(),
            _ => {
                errors.add(format!("{pointer}/{index}"), "must be a text or a number");
                return String::new();
            }
        };
        if !used.insert(text.clone()) {
            errors.add(format!("{pointer}/{index}"), format!("{text:?} is in the list twice; remove one"));
        }
        text
    });
    texts.collect()
}

/// Fault of a text of a scene that does not depend on its slots, if there is one.
fn text_fault(text: &str) -> Option<String> {
    let length = text.chars().count();
    if length > MAX_TEMPLATE_CHARS {
        return Some(format!("has {length} characters; say it in at most {MAX_TEMPLATE_CHARS}"));
    }
    let is_wrong = |c: char| c.is_control() && !matches!(c, '\n' | '\r' | '\t');
    text.chars().any(is_wrong).then(|| "contains control characters; remove them".to_owned())
}

fn templates(texts: &[String], slots: &[(String, Vec<String>)], errors: &mut Errors) -> Vec<Template> {
    if texts.is_empty() {
        errors.add("/templates", "has no templates; give at least one");
    }
    let numbers: BTreeMap<&str, usize> =
        slots.iter().enumerate().map(|(number, (name, _))| (name.as_str(), number)).collect();
    let mut used_slots = BTreeSet::new();
    let mut used_texts = BTreeSet::new();
    let mut templates = Vec::new();
    for (index, text) in texts.iter().enumerate() {
        let pointer = format!("/templates/{index}");
        let parsed = Template::parse(text, |name| {
            let number = numbers.get(name).copied();
            used_slots.extend(number);
            number
        });
        if let Some(detail) = text_fault(text) {
            errors.add(pointer, detail);
            continue;
        }
        match parsed {
            Ok(_) if !used_texts.insert(text.trim()) => {
                errors.add(pointer, "is in the list twice; remove one")
            }
            Ok(template) => templates.push(template),
            Err(error) => errors.add(pointer, error.to_string()),
        }
    }
    for (number, (name, _)) in slots.iter().enumerate() {
        if !used_slots.contains(&number) {
            errors.add(
                format!("/slots/{}", escaped(name)),
                format!("no template uses it; write {{{name}}} in one, or remove the values"),
            );
        }
    }
    templates
}

fn seeds(document: Option<&Value>, errors: &mut Errors) -> Seeds {
    let wrong = || format!("seeds are whole numbers from 0 to {MAX_SEED}");
    match document {
        None | Some(Value::Null) => return Seeds::Derived,
        Some(Value::Array(list)) => {
            let mut used = BTreeSet::new();
            for (index, value) in list.iter().enumerate() {
                match value.as_u64().filter(|seed| *seed <= MAX_SEED) {
                    None => errors.add(format!("/seeds/{index}"), wrong()),
                    Some(seed) if !used.insert(seed) => {
                        errors.add(
                            format!("/seeds/{index}"),
                            format!("{seed} is in the list twice; remove one"),
                        );
                    }
                    Some(_) => {}
                }
            }
            if list.is_empty() {
                errors.add("/seeds", "is empty; give at least one seed, or leave `seeds` out");
            }
            return Seeds::List(list.iter().filter_map(Value::as_u64).collect());
        }
        Some(range) => match json_error::convert::<SeedRange>(range, &[]) {
            Err(error) => errors.add_json("/seeds", error),
            Ok(SeedRange { count: 0, .. }) => errors.add("/seeds/count", "must be at least 1"),
            Ok(SeedRange { first, count }) => match first.checked_add(count - 1) {
                Some(last) if last <= MAX_SEED => return Seeds::Range { first, count },
                _ => errors.add("/seeds", wrong()),
            },
        },
    }
    Seeds::Derived
}

fn options(document: Option<&Value>, errors: &mut Errors) -> Vec<RequestOptions> {
    let mut read = |value: &Value, pointer: String| match json_error::convert::<RequestOptions>(
        value,
        &OPTION_OBJECTS,
    ) {
        Ok(options) => {
            for violation in options.violations() {
                errors.add(format!("{pointer}{}", violation.pointer), violation.detail);
            }
            options
        }
        Err(error) => {
            errors.add_json(&pointer, error);
            RequestOptions::default()
        }
    };
    match document {
        None | Some(Value::Null) => vec![RequestOptions::default()],
        Some(Value::Array(list)) => {
            let options: Vec<RequestOptions> = list
                .iter()
                .enumerate()
                .map(|(index, value)| read(value, format!("/options/{index}")))
                .collect();
            if options.is_empty() {
                errors.add("/options", "is empty; give at least one object, or leave `options` out");
            }
            for (index, own) in options.iter().enumerate() {
                if options[..index].contains(own) {
                    errors.add(format!("/options/{index}"), "is in the list twice; remove one");
                }
            }
            options
        }
        Some(value) => vec![read(value, "/options".to_owned())],
    }
}

/// Combinations of each template; `None` where their number does not fit.
fn combinations(
    templates: &[Template],
    slots: &[(String, Vec<String>)],
    of_each_text: u64,
) -> Option<Vec<Combinations>> {
    let mut first = 0_u64;
    let mut counts = Vec::with_capacity(templates.len());
    for template in templates {
        let sizes = template.slots.iter().map(|slot| slots[*slot].1.len() as u64);
        let count = sizes.into_iter().try_fold(of_each_text, u64::checked_mul)?;
        counts.push(Combinations { first, count });
        first = first.checked_add(count)?;
    }
    Some(counts)
}
