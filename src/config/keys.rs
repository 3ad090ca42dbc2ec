//! The keys there are, read from `config/default.toml`: default, meaning, unit and range of each.
//!
//! The file is the one place where a setting is described, so the brackets that end a key's comment are
//! read here instead of being repeated in code: `[unit, low..=high]`, `[unit, low..]`, `[unit]`,
//! `[word or word]`. `; request` at their end opens the key to requests, `; request low..=high` in a
//! narrower range.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use toml::{Table, Value};

/// `config/default.toml`.
pub const DEFAULTS: &str = include_str!("../../config/default.toml");

/// Properties of one key.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Default value, whose type every other value must have.
    pub default: Value,
    /// Comment of the key, without the brackets.
    pub meaning: String,
    /// `seconds`, `share`, ...; for words, the words.
    pub unit: String,
    pub allowed: Allowed,
    /// Values that a request may set; `None` = none, the key is the operator's.
    pub open_to_requests: Option<Allowed>,
}

/// Values of the right type that are accepted.
#[derive(Clone, Debug, PartialEq)]
pub enum Allowed {
    Anything,
    /// Both ends included; of a list, every element.
    Range {
        low: f64,
        high: Option<f64>,
    },
    /// Of a list, every element.
    Words(Vec<String>),
}

/// Every key (`section.name`), sorted.
pub fn keys() -> &'static BTreeMap<String, Key> {
    static KEYS: LazyLock<BTreeMap<String, Key>> = LazyLock::new(|| read(DEFAULTS));
    &KEYS
}

/// The leaves of nested tables under dotted names.
pub fn flatten(table: &Table) -> Vec<(String, Value)> {
    let mut leaves = Vec::new();
    for (name, value) in table {
        match value {
            Value::Table(inner) => {
                let inner = flatten(inner);
                leaves.extend(inner.into_iter().map(|(rest, value)| (format!("{name}.{rest}"), value)));
            }
            leaf => leaves.push((name.clone(), leaf.clone())),
        }
    }
    leaves
}

fn read(text: &str) -> BTreeMap<String, Key> {
    let table: Table = text.parse().expect("config/default.toml is TOML: a test reads it");
    let mut comments = comments(text);
    let key = |(path, default): (String, Value)| {
        let comment = comments.remove(&path).unwrap_or_default();
        let (meaning, brackets) = match comment.rsplit_once(" [") {
            Some((meaning, rest)) if rest.ends_with(']') => (meaning.to_owned(), &rest[..rest.len() - 1]),
            _ => (comment.clone(), ""),
        };
        let (brackets, request) = match brackets.split_once("; request") {
            Some((brackets, range)) => (brackets, Some(range)),
            None => (brackets, None),
        };
        let (unit, allowed) = constraint(brackets, &default);
        let open_to_requests = request.map(|text| range(text.trim()).unwrap_or_else(|| allowed.clone()));
        (path, Key { default, meaning, unit, allowed, open_to_requests })
    };
    flatten(&table).into_iter().map(key).collect()
}

/// The comment lines right above each key, joined.
fn comments(text: &str) -> BTreeMap<String, String> {
    let (mut section, mut comment) = (String::new(), String::new());
    let mut found = BTreeMap::new();
    for line in text.lines() {
        let line = line.trim();
        if let Some(more) = line.strip_prefix('#') {
            if !comment.is_empty() {
                comment.push(' ');
            }
            comment.push_str(more.trim());
            continue;
        }
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = name.to_owned();
        } else if let Some((name, _)) = line.split_once('=') {
            found.insert(format!("{section}.{}", name.trim()), std::mem::take(&mut comment));
        }
        comment.clear();
    }
    found
}

/// `low..=high` or `low..`.
fn range(text: &str) -> Option<Allowed> {
    let (low, high) = text.split_once("..")?;
    let high = high.strip_prefix('=').and_then(|high| high.parse().ok());
    Some(Allowed::Range { low: low.parse().ok()?, high })
}

/// Unit and range of what stands in the brackets.
fn constraint(brackets: &str, default: &Value) -> (String, Allowed) {
    if let Some((unit, text)) = brackets.rsplit_once(", ")
        && let Some(allowed) = range(text)
    {
        return (unit.to_owned(), allowed);
    }
    let element = default.as_array().and_then(|list| list.first()).unwrap_or(default);
    if element.is_str() && brackets.contains(" or ") {
        let words = brackets.split(" or ").flat_map(|part| part.split(", ")).map(str::to_owned).collect();
        return (brackets.to_owned(), Allowed::Words(words));
    }
    (brackets.to_owned(), Allowed::Anything)
}
