//! Instructions about finished scenes, read by the embedded reader: how many of those by writers who knew nothing of it
//! it reads as a careful reader would. Phrases are compared by the objects that they mean.

use editing::EditableObject;
use editing::references::resolve;
use embedded::instruction_reader::EnglishReader;
use ports::{Call, Instruction, InstructionReader};
use runtime::{CancelFlag, CpuPool};
use serde_json::{Value, json};

use crate::harness::instructions::{edits, is_close, scenes, tasks};

/// A program with the names of the objects in place of phrases. What means no object stays as it is.
fn resolved(value: Value, objects: &[EditableObject]) -> Value {
    match value {
        Value::String(phrase) => match resolve(objects, &phrase) {
            Ok(found) => {
                json!(found.into_iter().map(|index| objects[index].name.clone()).collect::<Vec<_>>())
            }
            Err(_) => json!(phrase.strip_prefix("the ").unwrap_or(&phrase)),
        },
        Value::Array(items) => items.into_iter().map(|item| resolved(item, objects)).collect(),
        Value::Object(fields) => {
            let meant = |(key, value): (String, Value)| {
                let is_phrase = matches!(
                    key.as_str(),
                    "target" | "targets" | "second_target" | "facing" | "where" | "object"
                );
                let value = if is_phrase { resolved(value, objects) } else { value };
                (key, value)
            };
            Value::Object(fields.into_iter().map(meant).collect())
        }
        other => other,
    }
}

fn reading() -> Call {
    Call::without_budget(CpuPool::new(1).expect("a pool"), CancelFlag::default())
}

#[tokio::test]
async fn fresh_edits_are_read_no_worse_than_before() {
    let (scenes, call) = (scenes(), reading());
    let (mut right, mut wrong, mut refused) = (0, Vec::new(), Vec::new());
    for sentence in edits() {
        let objects = scenes[&sentence.scene].clone();
        let names = |operations: Value| {
            let operations: Vec<Value> = operations.as_array().expect("a list").clone();
            operations.into_iter().map(|operation| resolved(operation, &objects)).collect::<Value>()
        };
        let stated = sentence.stated();
        let instruction = Instruction { text: sentence.text.clone(), objects: objects.clone() };
        match EnglishReader.read_edit(&call, instruction).await {
            Ok(program) => {
                let found = names(json!(program.meanings().collect::<Vec<_>>()));
                if is_close(&found, &names(json!(stated))) {
                    right += 1;
                } else {
                    wrong.push(format!("{}\n    {found}\n    {}", sentence.text, names(json!(stated))));
                }
            }
            Err(_) if stated.is_empty() => right += 1,
            Err(error) => refused.push(format!("{}\n    {error}", sentence.text)),
        }
    }
    eprintln!("{right} right\n\nwrong\n{}\n\nrefused\n{}", wrong.join("\n"), refused.join("\n"));
    assert!(right >= 98, "{right}");
    assert!(wrong.len() <= 14, "{}", wrong.len());
}

#[tokio::test]
async fn fresh_tasks_are_read_no_worse_than_before() {
    let (scenes, call) = (scenes(), reading());
    let (mut right, mut wrong, mut refused) = (0, Vec::new(), Vec::new());
    for line in tasks() {
        let objects = scenes[&line.scene].clone();
        let names = |goal: Value| -> Vec<String> {
            // One condition for each object.
            let mut all = Vec::new();
            for condition in goal.as_array().expect("a list") {
                let condition = resolved(condition.clone(), &objects);
                for object in condition["object"].as_array().cloned().unwrap_or_default() {
                    let mut one = condition.clone();
                    one["object"] = object;
                    all.push(one.to_string());
                }
            }
            all.sort();
            all
        };
        let instruction = Instruction { text: line.text.clone(), objects: objects.clone() };
        match EnglishReader.read_task(&call, instruction).await {
            Ok(program) => {
                let found = names(json!(program.meanings().collect::<Vec<_>>()));
                if line.stated_any().any(|goal| names(json!(goal)) == found) {
                    right += 1;
                } else {
                    wrong.push(format!("{}\n    {found:?}", line.text));
                }
            }
            Err(_) if line.stated().is_none() => right += 1,
            Err(error) => refused.push(format!("{}\n    {error}", line.text)),
        }
    }
    eprintln!("{right} right\n\nwrong\n{}\n\nrefused\n{}", wrong.join("\n"), refused.join("\n"));
    assert!(right >= 64, "{right}");
    assert!(wrong.len() <= 18, "{}", wrong.len());
}
