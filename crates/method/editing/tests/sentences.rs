//! Edit instructions and the operations that a careful reader expects: `sentences.toml` was written before the grammar,
//! `sentences_unseen.toml` after it.

use serde::Deserialize;

use editing::instruction;
use scene::EditOperation;

#[derive(Deserialize)]
struct Sentences {
    sentence: Vec<Sentence>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sentence {
    text: String,
    /// JSON.
    #[serde(default)]
    operations: Option<String>,
    /// A word of the reason for which a careful reader asks back.
    #[serde(default)]
    error: Option<String>,
}

/// Counts of the results of a file's sentences.
#[derive(Debug, Default)]
struct Score {
    total: usize,
    right: usize,
    /// Refused although the meaning is clear, or refused for another reason.
    refused: Vec<String>,
    /// Other operations than expected.
    wrong: Vec<String>,
}

fn score(file: &str) -> Score {
    let sentences: Sentences = toml::from_str(file).expect("the sentences parse");
    let mut score = Score { total: sentences.sentence.len(), ..Score::default() };
    for Sentence { text, operations, error } in sentences.sentence {
        let expected = operations.as_ref().map(|json| -> Vec<EditOperation> {
            let expected: Vec<EditOperation> = serde_json::from_str(json).expect(json);
            assert_eq!(scene::edit::violations(&expected), [], "{json}");
            expected
        });
        assert!(expected.is_some() != error.is_some(), "operations or an error: {text}");
        match (instruction::read(&text), expected, error) {
            (Ok(found), Some(expected), _) if is_same(&found, &expected) => score.right += 1,
            (Ok(found), ..) => {
                score
                    .wrong
                    .push(format!("{text}\n    {}", serde_json::to_string(&found).expect("serializes")));
            }
            (Err(found), None, Some(word)) if found.to_string().contains(&word) => score.right += 1,
            (Err(found), ..) => score.refused.push(format!("{text}\n    {found}")),
        }
    }
    score
}

/// Equal up to rounding of numbers.
fn is_same(found: &[EditOperation], expected: &[EditOperation]) -> bool {
    let json = |operations| serde_json::to_value(operations).expect("serializes");
    is_close(&json(found), &json(expected))
}

fn is_close(a: &serde_json::Value, b: &serde_json::Value) -> bool {
    use serde_json::Value::{Array, Number, Object};
    match (a, b) {
        (Number(a), Number(b)) => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            (a - b).abs() < 1e-6
        }
        (Array(a), Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_close(a, b)),
        (Object(a), Object(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| is_close(a, b)))
        }
        (a, b) => a == b,
    }
}

/// The score, with what is not right, in the output of the test.
fn report(file: &str, score: &Score) {
    eprintln!("{file}: {} of {} sentences are right", score.right, score.total);
    for sentence in score.refused.iter().chain(&score.wrong) {
        eprintln!("  {sentence}");
    }
}

#[test]
fn sentences_written_before_the_grammar_do_what_a_reader_expects() {
    let score = score(include_str!("sentences.toml"));
    report("sentences.toml", &score);
    assert_eq!(score.total, 60);
    assert!(score.wrong.is_empty(), "{}", score.wrong.join("\n"));
    assert!(score.right >= 54, "{}: {}", score.right, score.refused.join("\n"));
}

#[test]
fn sentences_written_after_the_grammar_do_nothing_else_than_a_reader_expects() {
    let score = score(include_str!("sentences_unseen.toml"));
    report("sentences_unseen.toml", &score);
    assert_eq!(score.total, 20);
    assert!(score.wrong.is_empty(), "{}", score.wrong.join("\n"));
    assert!(score.right >= 17, "{}: {}", score.right, score.refused.join("\n"));
}
