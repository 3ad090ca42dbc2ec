//! The account of every text of the test sets: what it says of the words is true of the objects.

use super::*;
use crate::text_parser::property::{Property, colors, number};
use crate::text_parser::tokens::{Token, word};
use crate::text_parser::verbs::verbs;
use scene::text_account::{TextMeaning, TextSpan, Understood};
use scene::{InstanceId, ObjectSpec};

/// The texts of `tests/words` and of the parser's tests.
fn texts() -> Vec<String> {
    let mut texts: Vec<String> = Vec::new();
    for file in [
        include_str!("../../../../../../tests/words/sentences.jsonl"),
        include_str!("../../../../../../tests/words/tasks.jsonl"),
        include_str!("../../../../../../tests/words/narrated.jsonl"),
    ] {
        for line in file.lines() {
            let entry: serde_json::Value = serde_json::from_str(line).expect(line);
            texts.push(entry["text"].as_str().expect("a text").to_owned());
        }
    }
    let names = include_str!("../../../../../../tests/words/vocabulary.tsv").lines().skip(1);
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
        include_str!("stand_ins.rs"),
        include_str!("../../../../../../tests/words/scenes.toml"),
    ] {
        let quoted = file.lines().flat_map(|line| line.split('"').skip(1).step_by(2));
        texts.extend(
            quoted.filter(|text| text.split(' ').count() > 2 && !text.contains('_')).map(str::to_owned),
        );
    }
    texts
}

fn objects<'d>(description: &'d SceneDescription, ids: &[InstanceId]) -> Vec<&'d ObjectSpec> {
    description.objects.iter().filter(|object| ids.contains(&object.id)).collect()
}

/// Contradiction between a stated property and the described objects, if there is one.
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

/// Faults of an account as a whole: every word is explained by one claim, or reported. Words of one claim may have
/// several meanings ("water the plant" is an object and a goal); a property has words of its own.
fn faults(understood: &[Understood], unrecognized: &[Unrecognized]) -> Vec<String> {
    let explains = |part: &&Understood| !matches!(part.meaning, TextMeaning::Correction { .. });
    let parts: Vec<&Understood> = understood.iter().filter(explains).collect();
    let apart = |a: &TextSpan, b: &TextSpan| a.end <= b.start || b.end <= a.start;
    let mut faults = Vec::new();
    for (k, first) in parts.iter().enumerate() {
        for second in parts[k + 1..].iter().filter(|second| !apart(&first.span, &second.span)) {
            let one_claim = first.span == second.span && agree(&first.meaning, &second.meaning);
            if !one_claim {
                faults.push(format!(
                    "{:?} is {:?} and {:?} is {:?}",
                    first.span.text, first.meaning, second.span.text, second.meaning
                ));
            }
        }
        // A goal whose start state is not shown is a goal, and a relation that some objects cannot have is one of the
        // others: their words are reported, too.
        let is_goal = matches!(first.meaning, TextMeaning::Goal { .. });
        let reported = unrecognized.iter().filter(|part| {
            let in_part = part.reason == UnrecognizedReason::NotSupported && first.span == part.span;
            !apart(&first.span, &part.span) && !is_goal && !in_part
        });
        faults.extend(reported.map(|part| {
            format!(
                "{:?} is {:?} and {:?} is {:?}",
                first.span.text, first.meaning, part.span.text, part.reason
            )
        }));
    }
    faults
}

/// Whether words of one claim may have both meanings.
fn agree(first: &TextMeaning, second: &TextMeaning) -> bool {
    use TextMeaning::{Object, Property};
    match (first, second) {
        (Property { .. }, _) | (_, Property { .. }) => false,
        (Object { objects, .. }, Object { objects: others, .. }) => {
            !objects.iter().any(|object| others.contains(object))
        }
        _ => first != second,
    }
}

/// Words that are neither explained nor reported, and say something.
fn unexplained(text: &str, description: &SceneDescription) -> Vec<String> {
    let source = json_input::read(text).unwrap_or_else(|| Source::read(text));
    let spans = description.understood.iter().map(|part| &part.span);
    let spans: Vec<&TextSpan> = spans.chain(description.unrecognized.iter().map(|part| &part.span)).collect();
    let says = |token: &Token| match token {
        Token::Word(word) => !vocabulary::vocabulary().grammar.ignorable.contains(word),
        Token::Number(_) => true,
        _ => false,
    };
    let tokens = source.tokens.iter().zip(&source.spans).filter(|(token, _)| says(token));
    let open = tokens.filter(|(_, bytes)| !spans.iter().any(|s| s.start < bytes.end && bytes.start < s.end));
    open.map(|(_, bytes)| text[bytes.clone()].to_owned()).collect()
}

/// Whether an object is named by a verb, an agent or a function word.
fn misnamed(part: &Understood) -> bool {
    let source = Source::read(&part.span.text);
    let TextMeaning::Object { .. } = part.meaning else { return false };
    let [Token::Word(only)] = &source.tokens[..] else { return false };
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
    description.objects.iter().filter(|object| object.requested).find_map(|object| {
        let mark = object.stand_in.as_ref()?;
        let names = description.understood.iter().filter(
            |part| matches!(&part.meaning, TextMeaning::Object { objects, .. } if objects.contains(&object.id)),
        );
        let longest = names.max_by_key(|part| part.span.text.len())?;
        let tokens = Source::read(&longest.span.text).tokens;
        let last = word(&tokens, tokens.len().checked_sub(1)?)?;
        let noun = mark.stands_for.rsplit(' ').next()?;
        let singular = vocabulary::vocabulary().singular_of(last);
        (singular != noun && !last.starts_with(noun)).then(|| format!("{:?} for {}", longest.span.text, object.id))
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
        faults(&description.understood, &description.unrecognized).into_iter().for_each(&mut tell);
        for word in unexplained(&text, &description) {
            tell(format!("{word:?} is neither explained nor reported"));
        }
        if let Some(what) = unnamed_stand_in(&description) {
            tell(format!("the noun is {what}"));
        }
    }
    assert!(described > 1200, "{described} texts");
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// Regressions: "onto" was a word of "on the right", and one of two books had no name of its own.
#[test]
fn destinations_are_words_of_the_goal_and_ranked_objects_have_their_own_names() {
    let description = describe_seed("put the mug on the right onto the red book", 3);
    let onto = description.understood.iter().find(|part| part.span.text == "onto").expect("a meaning");
    assert_eq!(onto.meaning, TextMeaning::Goal { index: 0 });
    for text in [
        "put the third book from the left on the second book from the left",
        "stack the second book from the right on the first book from the left",
    ] {
        let description = describe_seed(text, 3);
        let named = description.understood.iter().filter_map(|part| match &part.meaning {
            TextMeaning::Object { objects, .. } if part.span.text == "book" => Some(objects.clone()),
            _ => None,
        });
        let ids: Vec<Vec<InstanceId>> = description.objects.iter().map(|o| vec![o.id.clone()]).collect();
        assert_eq!(named.collect::<Vec<_>>(), ids, "{text}");
    }
}

#[test]
fn a_doubled_claim_is_a_fault() {
    let text = "two red mugs left of a plate";
    let description = describe_seed(text, 3);
    let (understood, unrecognized) = (&description.understood, &description.unrecognized);
    assert_eq!(faults(understood, unrecognized), Vec::<String>::new());
    for (k, part) in understood.iter().enumerate() {
        let mut doubled = understood.clone();
        doubled.insert(k, part.clone());
        assert!(!faults(&doubled, unrecognized).is_empty(), "{part:?} twice");
        let mut wider = part.clone();
        wider.span.end += 1;
        doubled[k] = wider;
        assert!(!faults(&doubled, unrecognized).is_empty(), "{part:?} in more words");
        let report = Unrecognized {
            span: part.span.clone(),
            reason: UnrecognizedReason::NotExpressible,
            nearest_by_spelling: None,
            nearest_by_meaning: None,
        };
        assert!(!faults(understood, &[report]).is_empty(), "{part:?} understood and reported");
        let mut short = description.clone();
        short.understood.remove(k);
        assert!(!unexplained(text, &short).is_empty(), "{part:?} left out");
    }
}
