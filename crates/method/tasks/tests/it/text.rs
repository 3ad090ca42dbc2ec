//! Instructions in a made scene, with the right goals, as `sentences.toml` and `verbs.toml` state them.

use crate::made_scene::made_scene;
use serde::Deserialize;
use tasks::goal::formula;
use tasks::{Refusal, Task, TaskScene};

#[derive(Deserialize)]
struct Sentences {
    sentences: Vec<[String; 2]>,
}

fn task_of(text: &str, scene: &TaskScene) -> Result<Task, Refusal> {
    tasks::text::task(text, scene, "panda")
}

#[test]
fn sentences_have_the_goals_that_the_table_states() {
    check(include_str!("sentences.toml"), 40);
}

/// Regressions: "crack the egg into the pan" was done by putting the egg there, "hand me the spoon" by lifting it.
#[test]
fn verbs_that_are_not_performed_are_refused_and_no_others() {
    check(include_str!("verbs.toml"), 60);
}

fn check(table: &str, at_least: usize) {
    let table: Sentences = toml::from_str(table).expect("the table parses");
    assert!(table.sentences.len() >= at_least);
    let scene = made_scene();
    let mut wrong = Vec::new();
    for [text, expected] in &table.sentences {
        let (found, detail) = match task_of(text, &scene) {
            Ok(task) => {
                let formulas: Vec<String> = task.goal.predicates().iter().map(formula).collect();
                (formulas.join(", "), String::new())
            }
            Err(refusal) => (format!("!{}", refusal.code()), refusal.to_string()),
        };
        if found != *expected {
            wrong.push(format!("{text:?}: {expected}, not {found} {detail}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), table.sentences.len(), wrong.join("\n"));
}

#[test]
fn task_keeps_the_instruction_as_written() {
    let task = task_of("put mug_1 on tray_1, please ", &made_scene()).expect("a task");
    assert_eq!(task.instruction, "put mug_1 on tray_1, please");
    assert_eq!(task.robot, "panda");
}
