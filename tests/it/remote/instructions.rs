//! Instructions about finished scenes, read by a language model: it answers correctly, lazily or with malice. The
//! instructions are by writers who knew nothing of any reader.

use std::collections::BTreeMap;
use std::sync::Arc;

use ports::ledger::OnUnknown;
use ports::{Instruction, InstructionReader, ProviderError};
use remote::chat::ChatAnalyst;
use scene::EditOperation;
use serde_json::{Map, Value, json};

use crate::harness::instructions::{Sentence, TaskLine, edits, is_close, scenes, tasks};
use crate::remote::bench::Book;
use crate::remote::chat::{endpoint, quick};
use crate::remote::chat_server::{Answers, ChatServer, KEY};

/// The instruction of a question.
pub fn instruction_of(asked: &Value) -> String {
    let content = &asked["messages"][1]["content"];
    let text = content[0]["text"].as_str().or(content.as_str()).expect("a text");
    let data: Value = serde_json::from_str(text).expect("data");
    data["instruction"].as_str().expect("an instruction").to_owned()
}

/// A model that answers instructions by this table.
fn model(answers: BTreeMap<String, Value>) -> Answers {
    Arc::new(move |_, asked| {
        let answer = answers.get(&instruction_of(&asked)).cloned();
        Box::pin(async move { answer.expect("is in the table") })
    })
}

fn reader(server: &ChatServer) -> ChatAnalyst {
    let chat = quick(server);
    ChatAnalyst { endpoint: Arc::new(endpoint(&chat, KEY, OnUnknown::Resend)), settings: chat }
}

/// An operation as a model states it.
fn on_the_wire(words: &str, operation: &EditOperation) -> Value {
    let mut fields: Map<String, Value> = match serde_json::to_value(operation).expect("has a JSON form") {
        Value::Object(fields) => fields,
        other => panic!("{other}"),
    };
    let angles = [
        ("by_rad", "by_deg"),
        ("to_rad", "to_deg"),
        ("azimuth_rad", "azimuth_deg"),
        ("elevation_rad", "elevation_deg"),
    ];
    for (radians, degrees) in angles {
        if let Some(angle) = fields.remove(radians) {
            fields.insert(degrees.into(), json!(angle.as_f64().expect("an angle").to_degrees()));
        }
    }
    let place = fields.remove("where").map(|mut place| {
        if let Some(offset) = place.as_object_mut().expect("a place").remove("offset_m") {
            (place["offset_right_m"], place["offset_back_m"]) = (offset[0].clone(), offset[1].clone());
        }
        place
    });
    fields.insert("where".into(), json!(place.into_iter().collect::<Vec<_>>()));
    fields.insert("words".into(), json!(words));
    Value::Object(fields)
}

/// Phrases that the scenes do not resolve, with the names that a model gives when it is asked again.
const NAMED: [(&str, &str); 2] = [
    ("\"All the screwdrivers but the longest\"", "\"screwdriver_1 and screwdriver_2\""),
    ("\"the other red cube\"", "\"cube_2\""),
];

/// A JSON text with names in place of these phrases.
fn named(text: &str) -> Value {
    let named = NAMED.iter().fold(text.to_owned(), |text, (phrase, name)| {
        let lower = phrase.to_lowercase();
        text.replace(phrase, name).replace(&lower, name)
    });
    serde_json::from_str(&named).expect("is JSON")
}

#[tokio::test]
async fn edits_that_a_model_reads_correctly_become_operations() {
    let (scenes, sentences) = (scenes(), edits());
    let answer = |sentence: &Sentence| {
        let operations = sentence.stated();
        let statements: Vec<Value> =
            operations.iter().map(|operation| on_the_wire(sentence.text.trim(), operation)).collect();
        let not_understood = if operations.is_empty() { vec![sentence.text.trim()] } else { vec![] };
        json!({ "statements": statements, "not_understood": not_understood, "asides": [] })
    };
    let table: BTreeMap<String, Value> =
        sentences.iter().map(|sentence| (sentence.text.trim().to_owned(), answer(sentence))).collect();
    let answers: Answers = Arc::new(move |_, asked| {
        let answer = table[&instruction_of(&asked)].clone();
        // Asked again, the model names the objects.
        let is_repair = asked["messages"].as_array().is_some_and(|messages| messages.len() > 2);
        Box::pin(async move { if is_repair { named(&answer.to_string()) } else { answer } })
    });
    let server = ChatServer::start(answers).await;
    let (reader, call) = (reader(&server), Book::with_budget(1_000_000_000).call());
    for sentence in &sentences {
        let objects = scenes[&sentence.scene].clone();
        let read = reader.read_edit(&call, Instruction { text: sentence.text.clone(), objects }).await;
        match read {
            Ok(program) => {
                let stated = |operations: Value| named(&operations.to_string());
                let operations: Vec<&EditOperation> = program.meanings().collect();
                let (found, expected) = (stated(json!(operations)), stated(json!(sentence.stated())));
                assert!(is_close(&found, &expected), "{}: {found}", sentence.text);
                assert!(program.statements.iter().all(|statement| statement.words == sentence.text.trim()));
            }
            Err(ProviderError::Rejected { code, .. }) => {
                assert_eq!(code, "instruction_not_understood");
                assert!(sentence.stated().is_empty(), "{}", sentence.text);
            }
            Err(error) => panic!("{}: {error}", sentence.text),
        }
    }
    assert_eq!(
        server.bill().len(),
        sentences.len() + NAMED.len(),
        "only these phrases had to be asked about"
    );
}

#[tokio::test]
async fn tasks_that_a_model_reads_correctly_become_goals() {
    let lines = tasks();
    let answer = |line: &TaskLine| {
        let text = line.text.trim();
        let statements: Vec<Value> = line.stated().into_iter().flatten().map(|goal| {
            json!({ "words": text, "predicate": goal.predicate, "object": goal.object, "target": goal.target,
                "second_target": goal.second_target })
        }).collect();
        let not_understood = if statements.is_empty() { vec![text] } else { vec![] };
        json!({ "statements": statements, "not_understood": not_understood, "asides": [] })
    };
    let table = lines.iter().map(|line| (line.text.trim().to_owned(), answer(line)));
    let server = ChatServer::start(model(table.collect())).await;
    let (reader, call, scenes) = (reader(&server), Book::with_budget(1_000_000_000).call(), scenes());
    for line in &lines {
        let instruction = Instruction { text: line.text.clone(), objects: scenes[&line.scene].clone() };
        match (reader.read_task(&call, instruction).await, line.stated()) {
            (Ok(program), Some(stated)) => {
                assert_eq!(
                    program.meanings().collect::<Vec<_>>(),
                    stated.iter().collect::<Vec<_>>(),
                    "{}",
                    line.text
                );
            }
            (Err(ProviderError::Rejected { .. }), None) => {}
            (other, _) => panic!("{}: {other:?}", line.text),
        }
    }
    assert_eq!(server.bill().len(), lines.len(), "no answer had to be asked for again");
}

#[tokio::test]
async fn lazy_and_hostile_answers_are_asked_for_again_and_never_carried_out() {
    let text = "remove the apple nearest the front and bake the plate";
    let statement = |fields: Value| {
        let mut statement = json!({ "words": text, "where": [] });
        statement.as_object_mut().expect("an object").extend(fields.as_object().expect("an object").clone());
        json!({ "statements": [statement], "not_understood": [], "asides": [] })
    };
    let half = json!({
        "statements": [{ "words": "remove the apple nearest the front", "op": "remove", "target": "apple_1" }],
        "not_understood": [], "asides": [],
    });
    for answer in [
        half,
        statement(json!({ "op": "remove", "target": "the lamp" })),
        statement(json!({ "op": "remove", "target": "x".repeat(100_000) })),
        statement(json!({ "op": "add", "object": "a mug", "count": 1_000_000 })),
        statement(json!({ "op": "delete_all_scenes", "target": "apple_1" })),
        statement(json!({ "op": "resize", "target": "apple_1", "factor": f64::MAX })),
        statement(json!({ "op": "remove", "target": "apple_1", "words": "rm -rf" })),
        json!({ "statements": vec![json!({}); 100_000], "not_understood": [], "asides": [] }),
    ] {
        let server = ChatServer::start(model(BTreeMap::from([(text.to_owned(), answer.clone())]))).await;
        let (reader, call) = (reader(&server), Book::with_budget(1_000_000_000).call());
        let instruction = Instruction { text: text.to_owned(), objects: scenes()["K"].clone() };
        let error = reader.read_edit(&call, instruction).await.expect_err("is refused");
        assert!(!matches!(error, ProviderError::Rejected { .. }), "{error}");
        assert_eq!(server.bill().len(), 2, "the answer and one repair: {answer:.200}");
        assert!(error.to_string().len() < 4_000);
    }
}
