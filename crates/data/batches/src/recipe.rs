//! Recipes: templates with slots, times seeds, times options.
//!
//! ```json
//! {"templates": ["a {color} mug next to {count} {item}"],
//!  "slots": {"color": ["red", "blue"], "count": ["two", "three"], "item": ["spoons", "forks"]},
//!  "seeds": {"first": 0, "count": 10},
//!  "options": {"max_objects": 12},
//!  "labels": {"split": "train"},
//!  "select": {"mode": "sample", "count": 50, "seed": 7}}
//! ```
//!
//! A template takes every combination of the values of the slots that it uses; a slot that it uses twice has the same
//! value in both places. Seeds vary fastest, then options, then the slots from the last to the first, then templates.
//! Without `seeds` every text has one seed, derived from it. `select` is the whole product unless it asks for a sample
//! of distinct combinations. The same recipe gives the same requests in the same order.

mod document;
mod naming;
mod sampling;
mod template;

use std::collections::BTreeMap;
use std::fmt;

use scene::request::RequestOptions;

use super::request::{BatchRequest, MAX_REQUESTS, RequestBody};
use naming::Names;
use template::Template;

/// A recipe that expands to at least one request and at most [`MAX_REQUESTS`].
#[derive(Clone, Debug)]
pub struct Recipe {
    templates: Vec<Template>,
    /// Values by slot, in the order of the document.
    slots: Vec<(String, Vec<String>)>,
    seeds: Seeds,
    options: Vec<RequestOptions>,
    /// Whether the document has a list of options, and not one alone.
    lists_options: bool,
    labels: BTreeMap<String, String>,
    /// Number of combinations of each template, and of those before it.
    counts: Vec<Combinations>,
    /// Numbers of the combinations of a sample; `None` for all.
    sample: Option<Vec<u64>>,
    names: Names,
}

/// Combinations of one template.
#[derive(Clone, Copy, Debug)]
struct Combinations {
    /// Number of the first.
    first: u64,
    count: u64,
}

/// Seeds of every text.
#[derive(Clone, Debug, PartialEq)]
enum Seeds {
    /// One seed, derived from the text.
    Derived,
    Range {
        first: u64,
        count: u64,
    },
    List(Vec<u64>),
}

impl Seeds {
    fn count(&self) -> u64 {
        match self {
            Self::Derived => 1,
            Self::Range { count, .. } => *count,
            Self::List(seeds) => seeds.len() as u64,
        }
    }

    fn get(&self, index: u64) -> Option<u64> {
        match self {
            Self::Derived => None,
            Self::Range { first, .. } => Some(first + index),
            Self::List(seeds) => Some(seeds[index as usize]),
        }
    }

    fn largest(&self) -> Option<u64> {
        match self {
            Self::Derived => None,
            Self::Range { first, count } => Some(first + count - 1),
            Self::List(seeds) => seeds.iter().max().copied(),
        }
    }
}

/// A value of a recipe that will not do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecipeError {
    /// JSON pointer into the recipe; empty for the whole document.
    pub pointer: String,
    pub detail: String,
}

/// All errors of a recipe; never empty.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct RecipeErrors(pub Vec<RecipeError>);

impl fmt::Display for RecipeErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, RecipeError { pointer, detail }) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n" };
            let place = if pointer.is_empty() { "the recipe" } else { pointer };
            write!(f, "{separator}{place}: {detail}")?;
        }
        Ok(())
    }
}

impl Recipe {
    /// Reads a recipe from JSON.
    ///
    /// # Errors
    ///
    /// Every value that will not do, with its pointer.
    pub fn parse(json: &[u8]) -> Result<Self, RecipeErrors> {
        document::read(json)
    }

    /// Number of requests.
    pub fn request_count(&self) -> u64 {
        match &self.sample {
            Some(sample) => sample.len() as u64,
            None => self.combinations(),
        }
    }

    /// The requests in order. They are made as they are taken.
    pub fn requests(&self) -> impl Iterator<Item = BatchRequest> + '_ {
        (0..self.request_count()).map(|index| match &self.sample {
            Some(sample) => self.combination(sample[index as usize]),
            None => self.combination(index),
        })
    }

    /// The options of the requests, each with its pointer into the document.
    pub fn options(&self) -> impl Iterator<Item = (String, &RequestOptions)> {
        let pointer =
            |index| if self.lists_options { format!("/options/{index}") } else { "/options".to_owned() };
        self.options.iter().enumerate().map(move |(index, options)| (pointer(index), options))
    }

    fn combinations(&self) -> u64 {
        self.counts.last().map_or(0, |last| last.first + last.count)
    }

    /// The combination of a number: its digits are the choices of seed, options and slots.
    fn combination(&self, number: u64) -> BatchRequest {
        let index = self.counts.partition_point(|counts| counts.first <= number).saturating_sub(1);
        let template = &self.templates[index];
        let mut rest = number - self.counts[index].first;
        let mut digit = |base: u64| {
            let digit = rest % base;
            rest /= base;
            digit
        };
        let seed = self.seeds.get(digit(self.seeds.count()));
        let option = digit(self.options.len() as u64) as usize;
        let mut choices = vec![0; template.slots.len()];
        for (choice, slot) in choices.iter_mut().zip(&template.slots).rev() {
            *choice = digit(self.slots[*slot].1.len() as u64) as usize;
        }
        let several_options = (self.options.len() > 1).then_some(option);
        let custom_id = self.names.name(index, &template.slots, &choices, several_options, seed, number);
        let value = |k: usize| self.slots[template.slots[k]].1[choices[k]].as_str();
        let body = RequestBody {
            text: Some(template.filled(value)),
            image: None,
            seed,
            labels: self.labels.clone(),
            options: self.options[option].clone(),
        };
        BatchRequest { custom_id, body }
    }
}

/// The number of requests in words, where it is more than is allowed.
fn too_many(count: Option<u64>) -> String {
    let count = count.map_or("more than 10^19".to_owned(), |count| count.to_string());
    format!(
        "makes {count} requests; at most {MAX_REQUESTS} are allowed. Give fewer values, or a sample: \
         \"select\": {{\"mode\": \"sample\", \"count\": N, \"seed\": S}}"
    )
}

#[cfg(test)]
mod tests;
