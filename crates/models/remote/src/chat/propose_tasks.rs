//! Robot tasks in a finished scene: instructions, each with the existing objects that it involves.

use serde::Deserialize;
use serde_json::{Value, json};

use super::prompts::prompts;
use super::repair_turn::Topic;
use super::response_values::Complaints;
use super::{ChatAnalyst, schema};
use ports::{Call, ProviderError, TaskObject, TaskQuestion};
use scene::appraisal::{ModelResponse, ProposedTask, TaskKind};

/// Maximum length of an instruction, characters.
const MAX_INSTRUCTION_CHARS: usize = 300;

#[derive(Deserialize)]
pub(super) struct Answer {
    tasks: Vec<AnswerTask>,
}

#[derive(Deserialize)]
struct AnswerTask {
    instruction: String,
    kind: TaskKind,
    objects: Vec<String>,
}

pub(super) fn schema() -> Value {
    let task = schema::object(&[
        ("instruction", schema::text("what a person would say to the robot")),
        ("kind", schema::word(TaskKind::NAMES)),
        ("objects", schema::list(&schema::text("a given name"))),
    ]);
    schema::object(&[("tasks", schema::list(&task))])
}

/// Asks for tasks.
pub(super) async fn propose(
    analyst: &ChatAnalyst,
    call: &Call,
    question: TaskQuestion,
) -> Result<ModelResponse<Vec<ProposedTask>>, ProviderError> {
    let prompt = &prompts().propose_tasks;
    let topic = Topic {
        prompt,
        schema: schema(),
        seed: question.seed,
        data: json!({ "count": question.count, "things": question.objects }),
        images: Vec::new(),
    };
    let count = question.count as usize;
    let tasks = analyst.ask(call, topic, |answer| accepted(answer, &question.objects, count)).await?;
    Ok(analyst.opinion(prompt, tasks))
}

pub(super) fn accepted(
    answer: Answer,
    known: &[TaskObject],
    count: usize,
) -> Result<Vec<ProposedTask>, Vec<String>> {
    let mut complaints = Complaints::default();
    if answer.tasks.len() != count {
        // The tasks stay unread: there may be a million.
        return Err(vec![format!("there are {} tasks; {count} are wanted", answer.tasks.len())]);
    }
    let mut tasks: Vec<ProposedTask> = Vec::with_capacity(count);
    for (index, AnswerTask { instruction, kind, objects }) in answer.tasks.into_iter().enumerate() {
        let at = format!("tasks[{index}]");
        complaints.plain(&format!("{at}.instruction"), &instruction, MAX_INSTRUCTION_CHARS);
        if tasks.iter().any(|task| task.instruction.eq_ignore_ascii_case(&instruction)) {
            complaints.add(format!("{at} is stated twice; state another"));
        }
        let fits = match kind {
            TaskKind::PickAndPlace => (1..=2).contains(&objects.len()),
            TaskKind::Swap => objects.len() == 2,
            TaskKind::Stack => objects.len() >= 2,
            TaskKind::MultiStep => !objects.is_empty(),
        };
        if !fits || objects.len() > known.len() {
            complaints.add(format!("{at} is about {} objects, which does not fit its kind", objects.len()));
            continue;
        }
        let mut named = Vec::with_capacity(objects.len());
        for name in &objects {
            match known.iter().find(|object| object.name.as_str() == name) {
                Some(object) if named.contains(&object.name) => {
                    complaints.add(format!("{at}.objects names {} twice", object.name));
                }
                Some(object) => named.push(object.name.clone()),
                None => complaints.add(format!("{at}.objects has a name that was not given")),
            }
        }
        tasks.push(ProposedTask { instruction, kind, objects: named });
    }
    complaints.none_or(tasks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::InstanceId;
    use scene::instance::SupportRelation;

    fn objects() -> Vec<TaskObject> {
        ["apple_1", "bowl_1", "fork_1"]
            .map(|name| TaskObject {
                name: InstanceId::new(name).expect(name),
                label: name.into(),
                material: None,
                size_m: [0.05; 3],
                mass_kg: 0.1,
                relation: SupportRelation::On,
                carried_by: "table".into(),
            })
            .into()
    }

    fn answered(text: &str, count: usize) -> Result<Vec<ProposedTask>, Vec<String>> {
        accepted(serde_json::from_str(text).expect("has the form"), &objects(), count)
    }

    const GOOD: &str = r#"{"tasks": [
        {"instruction": "Put the apple into the bowl.", "kind": "pick_and_place", "objects": ["apple_1", "bowl_1"]},
        {"instruction": "Swap the fork and the apple.", "kind": "swap", "objects": ["fork_1", "apple_1"]}]}"#;

    #[test]
    fn accepted_tasks_name_objects_of_the_scene() {
        let tasks = answered(GOOD, 2).expect("holds");
        assert_eq!((tasks[0].kind, tasks[1].kind), (TaskKind::PickAndPlace, TaskKind::Swap));
        let named: Vec<&str> = tasks[0].objects.iter().map(InstanceId::as_str).collect();
        assert_eq!(named, ["apple_1", "bowl_1"]);
        for name in TaskKind::NAMES {
            assert!(serde_json::from_value::<TaskKind>(json!(name)).is_ok(), "{name}");
        }
    }

    #[test]
    fn accepted_rejects_invalid_tasks() {
        assert!(answered(GOOD, 3).is_err(), "one is missing");
        for (from, to) in [
            ("\"apple_1\", \"bowl_1\"", "\"apple_1\", \"cup_1\""),
            ("\"apple_1\", \"bowl_1\"", "\"apple_1\", \"apple_1\""),
            ("\"apple_1\", \"bowl_1\"", ""),
            ("\"fork_1\", \"apple_1\"", "\"fork_1\""),
            ("Swap the fork and the apple.", "Put the apple into the bowl."),
            ("Swap the fork and the apple.", ""),
            ("Swap the fork and the apple.", "a\\u0000b"),
        ] {
            let spoiled = GOOD.replace(from, to);
            assert_ne!(spoiled, GOOD);
            assert!(answered(&spoiled, 2).is_err(), "{to}");
        }
    }
}
