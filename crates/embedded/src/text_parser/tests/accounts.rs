//! The account of every text of the test sets: what it says of the words is true of the objects.

use super::*;
use crate::text_parser::property::{Property, colors, number};
use crate::text_parser::tokens::word;
use crate::text_parser::verbs::verbs;
use scene::text_account::{TextMeaning, Understood};
use scene::{InstanceId, ObjectSpec};

/// The texts of `tests/words`, of the parser's tests and of `scripts/sentences.toml`.
fn texts() -> Vec<String> {
    let mut texts: Vec<String> = Vec::new();
    for file in [
        include_str!("../../../../../tests/words/sentences.jsonl"),
        include_str!("../../../../../tests/words/tasks.jsonl"),
        include_str!("../../../../../tests/words/narrated.jsonl"),
    ] {
        for line in file.lines() {
            let entry: serde_json::Value = serde_json::from_str(line).expect(line);
            texts.push(entry["text"].as_str().expect("a text").to_owned());
        }
    }
    let names = include_str!("../../../../../tests/words/vocabulary.tsv").lines().skip(1);
    texts.extend(names.map(|line| format!("A table with a {}", line.split('\t').nth(1).expect("a name"))));
    // Strings of more than two words in the sentences of the parser's tests.
    for file in [
        include_str!("../tests.rs"),
        include_str!("attachment.rs"),
        include_str!("data_set_tasks.rs"),
        include_str!("descriptions.rs"),
        include_str!("goals.rs"),
        include_str!("kinds.rs"),
        include_str!("names.rs"),
        include_str!("../../../../../scripts/sentences.toml"),
    ] {
        let quoted = file.lines().flat_map(|line| line.split('"').skip(1).step_by(2));
        texts.extend(
            quoted.filter(|text| text.split(' ').count() > 2 && !text.contains("_1 ")).map(str::to_owned),
        );
    }
    texts
}

fn objects<'d>(description: &'d SceneDescription, ids: &[InstanceId]) -> Vec<&'d ObjectSpec> {
    description.objects.iter().filter(|object| ids.contains(&object.id)).collect()
}

/// What is untrue of a stated property.
fn untrue(description: &SceneDescription, property: &str, value: &str, ids: &[InstanceId]) -> Option<String> {
    let objects = objects(description, ids);
    let source = Source::read(value);
    let is = |property: Property| property.reads(&LEXICON, &source.tokens, &(0..source.tokens.len()));
    let wrong = match property {
        "color" => {
            let named = colors(vocabulary::vocabulary(), &source.tokens, &(0..source.tokens.len()));
            !is(Property::Color)
                || objects.iter().any(|object| !object.color.is_some_and(|c| named.contains(&c)))
        }
        "count" => number(&LEXICON, &source.tokens, &(0..source.tokens.len())).is_none_or(|[low, high]| {
            !ids.is_empty() && !(low as usize..=high as usize).contains(&objects.len())
        }),
        "material" => !is(Property::Material) || objects.iter().any(|object| object.material.is_none()),
        "size" => !is(Property::Size),
        "shape" => !is(Property::Shape),
        "volume" => !is(Property::Volume),
        "mass" => !is(Property::Mass) || objects.iter().any(|object| object.mass_kg.is_none()),
        "state" => !is(Property::State),
        "people" => !is(Property::People),
        "distance" => !is(Property::Distance),
        _ => false,
    };
    wrong.then(|| format!("{property} {value:?} of {ids:?}"))
}

/// Two parts that explain a byte of the text differently. Words that imply an object also state its goal, its relation
/// or its arrangement ("water the plant").
fn overlap(parts: &[Understood]) -> Option<String> {
    let explains = |part: &&Understood| !matches!(part.meaning, TextMeaning::Correction { .. });
    let parts: Vec<&Understood> = parts.iter().filter(explains).collect();
    let property = |part: &Understood| match &part.meaning {
        TextMeaning::Property { property, .. } => Some(property.clone()),
        _ => None,
    };
    parts.iter().enumerate().find_map(|(k, first)| {
        let other = parts[k + 1..].iter().find(|second| {
            let apart = first.span.end <= second.span.start || second.span.end <= first.span.start;
            !apart && (first.span != second.span || property(first) != property(second))
        })?;
        Some(format!(
            "{:?} is {:?} and {:?} is {:?}",
            first.span.text, first.meaning, other.span.text, other.meaning
        ))
    })
}

/// Whether an object is named by a verb, an agent or a function word.
fn misnamed(part: &Understood) -> bool {
    let source = Source::read(&part.span.text);
    let TextMeaning::Object { .. } = part.meaning else { return false };
    let [tokens::Token::Word(only)] = &source.tokens[..] else { return false };
    let agent = &phrases::phrases().agent;
    // Nouns for groups, parts and actions.
    const NOUNS: &[&str] = &["pair", "stack", "pile", "sort", "stand", "top", "power", "turn"];
    let is_grammar = verbs().is_form(only)
        || agent.names.has(only)
        || agent.persons.has(only)
        || vocabulary::vocabulary().grammar.boundaries.contains(only.as_str());
    is_grammar
        && !NOUNS.contains(&only.as_str())
        && !LEXICON.names_object(only)
        && !LEXICON.names_object(&vocabulary::vocabulary().singular_of(only))
}

/// A stand-in whose longest name in the account does not end with its noun.
fn unnamed_stand_in(description: &SceneDescription) -> Option<String> {
    description.objects.iter().filter(|object| object.requested && object.stand_in).find_map(|object| {
        let names = description.understood.iter().filter(
            |part| matches!(&part.meaning, TextMeaning::Object { objects, .. } if objects.contains(&object.id)),
        );
        let longest = names.max_by_key(|part| part.span.text.len())?;
        let tokens = Source::read(&longest.span.text).tokens;
        let last = word(&tokens, tokens.len().checked_sub(1)?)?;
        let noun = object.id.as_str().rsplit_once('_')?.0.rsplit('_').next()?;
        let singular = vocabulary::vocabulary().singular_of(last);
        (singular != noun && last != noun).then(|| format!("{:?} for {}", longest.span.text, object.id))
    })
}

#[test]
fn the_account_of_every_text_is_true() {
    let mut wrong = Vec::new();
    let mut described = 0;
    for text in texts() {
        let Ok(description) = describe(&text, 3, &options(), &settings()) else { continue };
        described += 1;
        let mut tell = |what: String| wrong.push(format!("{text:?}: {what}"));
        for part in &description.understood {
            if let TextMeaning::Property { property, value, objects } = &part.meaning
                && let Some(what) = untrue(&description, property, value, objects)
            {
                tell(what);
            }
            if misnamed(part) {
                tell(format!("{:?} is {:?}", part.span.text, part.meaning));
            }
        }
        if let Some(what) = overlap(&description.understood) {
            tell(what);
        }
        if let Some(what) = unnamed_stand_in(&description) {
            tell(format!("the noun is {what}"));
        }
    }
    assert!(described > 1200, "{described} texts");
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
