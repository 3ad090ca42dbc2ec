//! One whole document of each resource, and of each list, with ids, times, durations and digests redacted.

use std::sync::Arc;
use std::time::Duration;

use demonstrations::vectors::shares_of_limits;
use hyper::Method;
use insta::assert_json_snapshot;
use manipulation::execution::{Execution, Failure, Frame, Phase, PickReport, Recording};
use manipulation::grasp::{Grasp, Verdict};
use robot::model::Robot;
use serde_json::{Value, json};
use tabletopgen::app::executions::{Executed, files};
use tabletopgen::app::tasks::SceneTasks;
use tasks::evaluation::{Bound, Unit};
use tasks::proposals::{Difficulty, Wordings};
use tasks::{Disturbance, Goal, PredicateOutcome, ProposalKind, ProposedTask, Reason, Task};

use super::documents::{marked, redacted};
use super::recording_events;
use crate::harness::contract;
use crate::harness::script::Script;
use crate::harness::server::{Server, settings};
use crate::harness::tiny_bundle;

async fn until_final(server: &Server, path: &str) -> Value {
    let reached = async {
        loop {
            let found = server.get(path).await.json();
            if ["finished", "failed", "cancelled"].contains(&found["state"].as_str().unwrap()) {
                return found;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(60), reached).await.expect("it ends")
}

#[tokio::test]
async fn edits_and_variants_have_these_documents() {
    let server = Server::start(&Script::new(&[])).await;
    let (parent, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let headers = [("content-type", "application/json"), ("prefer", "wait=30")];
    let edit = json!({
        "seed": 7, "labels": { "set": "a1" },
        "operations": [
            { "op": "move", "target": "the mug", "where": { "relation": "left_of", "target": "laptop_1" } },
            { "op": "tidy" },
        ],
    });
    let path = format!("/scenes/{parent}/edits");
    let edited = server.call(Method::POST, &path, &headers, edit.to_string()).await.json();
    let lineage = format!("/scenes/{}/lineage", edited["id"].as_str().unwrap());
    assert_json_snapshot!("edit", redacted(edited));
    assert_json_snapshot!("lineage", redacted(server.get(&lineage).await.json()));
    let variants = json!({ "count": 2, "seed": 7, "randomize": { "layout": true, "sizes": 0.2 } });
    let made = server.post(&format!("/scenes/{parent}/variants"), variants.clone()).await;
    assert_json_snapshot!("variants", redacted(made.json()));
    let checked = server.post(&format!("/scenes/{parent}/variants/validate"), variants).await;
    assert_json_snapshot!("validated_variants", redacted(checked.json()));
}

#[tokio::test]
async fn a_batch_and_a_dataset_have_these_documents() {
    let server = Server::building(tiny_bundle::build(), &settings(&[])).await;
    let lines = [
        json!({ "custom_id": "r1", "body": { "text": "a red mug", "seed": 1 } }).to_string(),
        json!({ "custom_id": "r2", "body": { "text": "a blue mug", "seed": 1 } }).to_string(),
        json!({ "custom_id": "r3", "body": { "text": "a blue mug", "seed": 1 } }).to_string(),
        json!({ "custom_id": "r4", "body": { "text": "a mug", "seed": -1 } }).to_string(),
    ];
    let headers = [("content-type", "application/jsonl")];
    let sent = server.call(Method::POST, "/batches?name=mugs", &headers, lines.join("\n")).await;
    let id = sent.json()["id"].as_str().unwrap().to_owned();
    let batch = until_final(&server, &format!("/batches/{id}")).await;
    assert_json_snapshot!("batch", redacted(batch));
    assert_json_snapshot!("batches", redacted(server.get("/batches").await.json()));
    for which in ["output", "errors"] {
        let reply = server.get(&format!("/batches/{id}/{which}")).await;
        let text = std::str::from_utf8(&reply.body).unwrap();
        let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        for line in &lines {
            contract::hold_schema("BatchResult", line);
        }
        assert_json_snapshot!(format!("batch_{which}"), redacted(lines.into()));
    }
    let order = json!({ "name": "mugs", "batch": id, "splits": { "train": 1.0 }, "seed": 7 });
    let reply = server.post("/datasets", order).await;
    let path = format!("/datasets/{}", reply.json()["id"].as_str().unwrap());
    until_final(&server, &path).await;
    server.call(Method::POST, &format!("{path}/verify"), &[], "").await;
    let job = server.get(&path).await.json()["job_id"].as_str().unwrap().to_owned();
    server.job_is(&job, "succeeded").await;
    let dataset = redacted(server.get(&path).await.json());
    assert_json_snapshot!("dataset", marked(dataset, "/verification/found/bytes", "[bytes]"));
    let datasets = redacted(server.get("/datasets").await.json());
    assert_json_snapshot!("datasets", marked(datasets, "/datasets/*/verification/found/bytes", "[bytes]"));
    let files = redacted(server.get(&format!("{path}/files")).await.json());
    assert_json_snapshot!("dataset_files", marked(files, "/files/*/size", "[bytes]"));
}

#[tokio::test]
async fn a_recording_has_these_documents() {
    let server = Server::without_worker(Arc::new(tempfile::tempdir().unwrap()), &[]).await;
    let (id, events) = recording_events::ordered(server.store(), 1).await;
    recording_events::made(server.store(), "slipped").await;
    recording_events::made(server.store(), "success").await;
    let path = format!("/episodes/{}", id.as_str());
    let running = redacted(server.get(&path).await.json());
    assert_json_snapshot!("running_recording", marked(running, "/progress/seconds_left", "[duration]"));
    recording_events::finished(server.store()).await;
    assert_json_snapshot!("recording", redacted(server.get(&path).await.json()));
    assert_json_snapshot!("recordings", redacted(server.get("/episodes").await.json()));
    let events = redacted(server.get(&events).await.json());
    let events = marked(events, "/events/*/data/progress/seconds_left", "[duration]");
    assert_json_snapshot!("recording_events", events);
}

#[tokio::test]
async fn jobs_and_the_version_have_these_documents() {
    let server = Server::start(&Script::new(&[])).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    assert_json_snapshot!("jobs", redacted(server.get("/jobs").await.json()));
    let version = server.get("/version").await.json();
    let version = marked(version, "/version", "[version]");
    assert_json_snapshot!("version", marked(version, "/studio", "[whether the page was built]"));
    assert_json_snapshot!("healthy", server.get("/healthz").await.json());
    assert_json_snapshot!("ready", server.get("/readyz").await.json());
}

fn goal(json: &str) -> Goal {
    serde_json::from_str(json).expect("a goal")
}

/// A grasp with round numbers.
fn grasp() -> Grasp {
    Grasp {
        object_from_tool: geometry::Pose::IDENTITY,
        opening_m: 0.04,
        pregrasp_opening_m: 0.06,
        force_n: 20.0,
        confidence: 0.9,
        verdict: Verdict::Stable,
        slip_m: 0.001,
        turn_rad: 0.01,
    }
}

/// An execution of one frame, with every field.
fn execution(robot: &Robot) -> Execution {
    let joints: Vec<String> = (1..=robot.dof()).map(|number| format!("panda_joint{number}")).collect();
    let rest = vec![0.0; joints.len()];
    let frame = Frame {
        time_s: 0.0,
        phase: Phase::Approach,
        joint_targets: rest.clone(),
        joint_references: rest.clone(),
        joint_positions: rest.clone(),
        joint_velocities: rest,
        opening_target_m: 0.06,
        opening_reference_m: 0.06,
        opening_m: 0.06,
        gripper_target: 0.03,
        object_poses: vec![geometry::Pose::IDENTITY],
    };
    let goal = goal(r#"[{ "predicate": "lifted", "object": "mug_1" }]"#);
    Execution {
        robot: "panda".to_owned(),
        variant: None,
        world_from_base: geometry::Pose::IDENTITY,
        succeeded: false,
        failure: Some(Failure::Slipped),
        detail: Some("the mug slipped".to_owned()),
        predicates: vec![PredicateOutcome {
            predicate: goal.predicates()[0].clone(),
            holds: false,
            measured: 0.01,
            limit: 0.05,
            bound: Bound::AtLeast,
            unit: Unit::Meters,
            reason: Reason::NotDecidable,
        }],
        disturbed: vec![Disturbance {
            object: scene::InstanceId::numbered("plate", 1),
            displacement_m: 0.04,
            rotation_rad: 0.1,
        }],
        picks: vec![PickReport { object: "mug_1".to_owned(), grasp: grasp(), slip_m: 0.02 }],
        duration_s: 0.0,
        recording: Recording {
            rate_hz: 50.0,
            joints,
            gripper_joint: "panda_finger_joint1".to_owned(),
            objects: vec!["mug_1".to_owned()],
            frames: vec![frame],
        },
    }
}

#[test]
fn an_execution_has_this_document() {
    let robot = Robot::built_in("panda", None).expect("a robot");
    let execution = execution(&robot);
    assert!(!shares_of_limits(&robot, &execution.recording).motion.is_empty());
    let goal = goal(r#"[{ "predicate": "lifted", "object": "mug_1" }]"#);
    let executed = Executed { task: Task::new("lift the mug", goal, "panda"), robot, seed: 7, execution };
    let document = files::document(&executed);
    contract::hold_schema("ExecutedTask", &document);
    assert_json_snapshot!("execution", document);
}

#[test]
fn tasks_have_this_document() {
    let task = Task::new(
        "put the mug between the plates",
        goal(
            r#"[{ "predicate": "between", "object": "mug_1", "target": "plate_1", "second_target": "plate_2" },
                { "predicate": "upright", "object": "mug_1" }]"#,
        ),
        "panda",
    );
    let proposed = ProposedTask {
        kind: ProposalKind::NextTo,
        task: task.clone(),
        wordings: Wordings {
            vague: "put it there".to_owned(),
            default: "put the mug between the plates".to_owned(),
            specific: "pick up the red mug and put it down between the plates".to_owned(),
        },
        difficulty: Difficulty {
            objects: 3,
            clutter: 1,
            occlusion: 0.25,
            precision_m: 0.03,
            steps: 1,
            overall: 0.3,
        },
    };
    let tasks = SceneTasks {
        robot: "panda".to_owned(),
        seed: 7,
        own: Some(task),
        instructed: None,
        proposed: vec![proposed],
    };
    let document = serde_json::to_value(tasks).expect("JSON");
    contract::hold_schema("SceneTasks", &document);
    assert_json_snapshot!("tasks", document);
}
