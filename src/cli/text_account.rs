//! The account of a text as a small table for people.

use std::fmt::Write as _;

use scene::text_account::TextAccount;
use scene::{InstanceId, TextMeaning, Understood};

/// Meanings that a table shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Objects, once each, and corrections.
    Objects,
    All,
}

/// One line for each meaning that is shown, then for each part without effect, stand-in, filling, part that an edit
/// changed, demand that yielded, and condition of the goal.
pub fn table(account: &TextAccount, detail: Detail) -> String {
    let mut rows: Vec<(&str, String, String)> = Vec::new();
    for part in account.understood.iter().filter(|part| detail == Detail::All || is_first(account, part)) {
        rows.push(("understood", quoted(&part.span.text), part.meaning.to_string()));
    }
    for part in &account.unrecognized {
        let nearest = [("by spelling", &part.nearest_by_spelling), ("by meaning", &part.nearest_by_meaning)];
        let nearest =
            nearest.into_iter().filter_map(|(by, word)| Some(format!("; nearest {by}: {}", word.as_ref()?)));
        let found = std::iter::once(part.reason.to_string()).chain(nearest).collect();
        rows.push(("without effect", quoted(&part.span.text), found));
    }
    for id in &account.stand_ins {
        let found = match category_of(account, id) {
            Some(category) if !category.starts_with(SHAPES) => {
                format!("{id} is shown as: {}", category.replace('_', " "))
            }
            _ => format!("{id} is a plain form of its kind"),
        };
        rows.push(("stand-in", words_of(account, id), found));
    }
    for id in &account.fillings {
        rows.push(("filling", String::new(), format!("{id} is added by the theme")));
    }
    for part in &account.changed {
        rows.push(("edited", quoted(&part.span.text), part.by.clone()));
    }
    for unmet in &account.unmet {
        rows.push(("yielded", String::new(), unmet.to_string()));
    }
    if let Some(goal) = &account.goal {
        rows.push(("goal", quoted(&goal.instruction), "the scene is its start state".to_owned()));
        rows.extend(goal.predicates.iter().map(|predicate| ("", String::new(), predicate.to_string())));
    }
    let width =
        rows.iter().map(|(_, words, _)| words.chars().count()).filter(|width| *width <= MAX_WIDTH).max();
    let width = width.unwrap_or(0);
    let mut text = String::new();
    for (what, words, found) in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {what:<14} {words:<width$}  {found}");
    }
    text
}

/// Whether a part is a correction, or the longest name of its objects; of equally long ones the first.
fn is_first(account: &TextAccount, part: &Understood) -> bool {
    let same = account.understood.iter().filter(|other| other.meaning == part.meaning);
    match part.meaning {
        TextMeaning::Correction { .. } => true,
        TextMeaning::Object { .. } => {
            let longest = same.rev().max_by_key(|other| other.span.text.len());
            longest.is_some_and(|longest| longest.span == part.span)
        }
        _ => false,
    }
}

/// Widest column of words; longer ones push the rest of their line.
const MAX_WIDTH: usize = 40;

/// First part of the categories that are plain shapes.
const SHAPES: &str = "stand_in_";

/// The category that the account gives an object.
fn category_of<'a>(account: &'a TextAccount, id: &InstanceId) -> Option<&'a str> {
    account.understood.iter().find_map(|part| match &part.meaning {
        TextMeaning::Object { category, objects } if objects.contains(id) => Some(category.as_str()),
        _ => None,
    })
}

/// The noun of the text for an object: the longest of the words that name it, of equally long ones the first.
fn words_of(account: &TextAccount, id: &InstanceId) -> String {
    let names = |meaning: &TextMeaning| matches!(meaning, TextMeaning::Object { objects, .. } if objects.contains(id));
    let parts = account.understood.iter().rev().filter(|part| names(&part.meaning));
    let part = parts.max_by_key(|part| part.span.text.len());
    part.map(|part| quoted(&part.span.text)).unwrap_or_default()
}

/// A part of the text on one line.
fn quoted(words: &str) -> String {
    format!("{words:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finding_has_a_line() {
        let account: TextAccount = serde_json::from_value(serde_json::json!({
            "understood": [
                { "span": { "start": 0, "end": 9, "text": "two mugs" }, "kind": "object", "category": "mug",
                  "objects": ["mug_1", "mug_2"] },
                { "span": { "start": 10, "end": 13, "text": "red" }, "kind": "property", "property": "color",
                  "value": "red", "objects": ["mug_1"] },
                { "span": { "start": 14, "end": 18, "text": "mugs" }, "kind": "object", "category": "mug",
                  "objects": ["mug_1", "mug_2"] },
                { "span": { "start": 20, "end": 24, "text": "aple" }, "kind": "correction", "corrected": "apple" },
                { "span": { "start": 30, "end": 37, "text": "sextant" }, "kind": "object",
                  "category": "stand_in_box", "objects": ["sextant_1"] },
                { "span": { "start": 38, "end": 39, "text": "beaker" }, "kind": "object",
                  "category": "mug", "objects": ["beaker_1"] },
            ],
            "unrecognized": [
                { "span": { "start": 40, "end": 45, "text": "qwr\ntz" }, "reason": "unknown_word",
                  "nearest_by_spelling": "quart", "nearest_by_meaning": "box" },
                { "span": { "start": 50, "end": 53, "text": "dad" }, "reason": "not_placeable" },
            ],
            "goal": { "instruction": "put a mug on the box", "predicates": [
                { "predicate": "on", "object": "mug_1", "target": "sextant_1" },
            ] },
            "stand_ins": ["sextant_1", "beaker_1"],
            "changed": [{ "span": { "start": 60, "end": 66, "text": "teapot" }, "by": "removed teapot_1" }],
            "fillings": ["spoon_1"],
            "unmet": [{ "objects": ["mug_1"], "kind": "relation", "relation": "left_of", "targets": ["mug_2"] }],
        }))
        .expect("an account");
        let expected = "  \
  understood     \"two mugs\"              2 × mug: mug_1, mug_2
  understood     \"aple\"                  read as \"apple\"
  understood     \"sextant\"               1 × stand-in (box): sextant_1
  understood     \"beaker\"                1 × mug: beaker_1
  without effect \"qwr\\ntz\"               unknown word; nearest by spelling: quart; nearest by meaning: box
  without effect \"dad\"                   nothing that stands on a table
  stand-in       \"sextant\"               sextant_1 is a plain form of its kind
  stand-in       \"beaker\"                beaker_1 is shown as: mug
  filling                                spoon_1 is added by the theme
  edited         \"teapot\"                removed teapot_1
  yielded                                mug_1 left of mug_2
  goal           \"put a mug on the box\"  the scene is its start state
                                         mug_1 on sextant_1
";
        assert_eq!(table(&account, Detail::Objects), expected);
        assert_eq!(table(&account, Detail::All).lines().count(), expected.lines().count() + 2);
        assert_eq!(table(&TextAccount::default(), Detail::All), "");
    }
}
