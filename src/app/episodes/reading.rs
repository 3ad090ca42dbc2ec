//! The reading of a draft as an order.

use std::collections::BTreeSet;

use serde::Deserialize;
use serde_json::{Value, json};

use super::draft::{EpisodesDraft, RecordDraft};
use super::order::{Cameras, EpisodesOrder, makeable_format};
use super::refused;
use crate::app::executions::TaskSource;
use crate::app::tasks::robot_named;
use crate::problem::{FieldError, Problem};
use demonstrations::vectors::{action_layout, state_layout};
use demonstrations::{CameraSpec, Randomization, SetupError};
use episodes::description::{CameraDescription, DatasetDescription};
use episodes::format::Format;
use geometry::DVec3;
use robot::model::Robot;
use scene::request::MAX_SEED;
use tasks::Task;

/// Most tasks of an order.
const MAX_TASKS: usize = 20;
/// Most cameras of an order.
const MAX_CAMERAS: usize = 8;
/// Longest name of a camera, characters: paths of files have it.
const MAX_CAMERA_NAME: usize = 24;
/// Most pixels of a frame, of all cameras together.
const MAX_FRAME_PIXELS: u64 = 4 << 20;
/// Longest title, characters.
const MAX_TITLE: usize = 100;
/// Most attempts of an order.
const MAX_ATTEMPTS: u64 = 1_000_000;

/// Reads and checks all that needs no scene.
///
/// # Errors
///
/// A [`Problem`] with every value that will not do, or that names an unknown robot.
pub fn ordered(draft: &EpisodesDraft) -> Result<EpisodesOrder, Problem> {
    let mut errors = Vec::new();
    let robot = robot_named(&draft.robot)?;
    let order = EpisodesOrder {
        title: draft.title.as_ref().map(|title| title.trim().to_owned()),
        tasks: tasks(draft, &mut errors),
        robot: draft.robot.clone(),
        count: draft.count,
        seed: draft.seed,
        randomization: randomization(&draft.randomize, &mut errors),
        cameras: cameras(draft, &mut errors),
        fps: draft.record.fps,
        depth: draft.record.depth,
        instance_ids: draft.record.instance_ids,
        points: draft.record.point_cloud,
        formats: formats(&draft.formats, &mut errors),
        keeps_failures: draft.keep_failures,
        max_attempts: draft
            .max_attempts
            .unwrap_or_else(|| EpisodesOrder::usual_max_attempts(draft.count.min(MAX_ATTEMPTS))),
    };
    if order.seed > MAX_SEED {
        errors.push(FieldError::new("/seed", format!("must be at most {MAX_SEED}")));
    }
    if draft.max_attempts.is_some_and(|attempts| attempts > MAX_ATTEMPTS) {
        errors.push(FieldError::new("/max_attempts", format!("must be at most {MAX_ATTEMPTS}")));
    }
    let is_title = |title: &str| (1..=MAX_TITLE).contains(&title.trim().chars().count());
    if draft.title.as_deref().is_some_and(|title| !is_title(title)) {
        errors.push(FieldError::new("/title", format!("must have from 1 to {MAX_TITLE} characters")));
    }
    if let Err(problem) = order.check() {
        errors.extend(
            problem.errors.into_iter().filter_map(|error| in_draft(error, &errors)).collect::<Vec<_>>(),
        );
    }
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    describe(&order, &robot)?;
    Ok(order)
}

/// Inverse of [`ordered`]: the order as a client could have stated it.
pub fn stated(order: &EpisodesOrder) -> EpisodesDraft {
    let task = |source: &TaskSource| match source {
        TaskSource::Text(text) => json!(text),
        TaskSource::Task(task) => json!(task),
    };
    let mut tasks: Vec<Value> = order.tasks.iter().map(task).collect();
    let (task, tasks) = if tasks.len() == 1 { (tasks.pop(), None) } else { (None, Some(tasks)) };
    let usual = RecordDraft::default();
    let (cameras, size_px) = match &order.cameras {
        Cameras::Usual { names, side_px } => (names.iter().map(|name| json!(name)).collect(), *side_px),
        Cameras::Own(cameras) => (cameras.iter().map(|camera| json!(camera)).collect(), usual.size_px),
    };
    let name = ["usual", "wide", "none"]
        .into_iter()
        .find(|name| Randomization::named(name) == Some(order.randomization));
    EpisodesDraft {
        title: order.title.clone(),
        robot: order.robot.clone(),
        task,
        tasks,
        count: order.count,
        seed: order.seed,
        randomize: name.map_or_else(|| json!(order.randomization), |name| json!(name)),
        record: RecordDraft {
            cameras,
            size_px,
            fps: order.fps,
            depth: order.depth,
            instance_ids: order.instance_ids,
            point_cloud: order.points,
        },
        formats: order.formats.iter().map(|format| format.folder().to_owned()).collect(),
        keep_failures: order.keeps_failures,
        max_attempts: Some(order.max_attempts),
    }
}

/// An error of an order where it is in a draft; `None` where there is one already.
fn in_draft(error: FieldError, errors: &[FieldError]) -> Option<FieldError> {
    let pointer = match error.pointer.as_str() {
        "/fps" | "/cameras" | "/depth" | "/instance_ids" | "/point_cloud" => {
            format!("/record{}", error.pointer)
        }
        _ => error.pointer,
    };
    let is_known = errors.iter().any(|known| known.pointer.starts_with(&pointer));
    (!is_known).then(|| FieldError::new(pointer, error.detail))
}

fn tasks(draft: &EpisodesDraft, errors: &mut Vec<FieldError>) -> Vec<TaskSource> {
    if draft.task.is_some() && draft.tasks.is_some() {
        errors.push(FieldError::new("", "give `task` or `tasks`, one of them; both are there"));
    }
    let given = draft.tasks();
    if given.len() > MAX_TASKS {
        errors.push(FieldError::new("/tasks", format!("must name at most {MAX_TASKS} tasks")));
    }
    let (mut sources, mut instructions) = (Vec::new(), BTreeSet::new());
    for (pointer, value) in given {
        let (source, instruction) = match value {
            Value::String(text) => (TaskSource::Text(text.clone()), text.clone()),
            _ => match Task::deserialize(value) {
                Ok(task) => {
                    if task.robot != draft.robot {
                        let detail = format!("is for the robot {}, not {}", task.robot, draft.robot);
                        errors.push(FieldError::new(&*pointer, detail));
                    }
                    let instruction = task.instruction.clone();
                    (TaskSource::Task(Box::new(task)), instruction)
                }
                Err(error) => {
                    let detail = format!("is neither an instruction in words nor a task: {error}");
                    errors.push(FieldError::new(pointer, detail));
                    continue;
                }
            },
        };
        if !instructions.insert(instruction.clone()) {
            errors.push(FieldError::new(pointer, format!("\"{instruction}\" is in the list twice")));
        }
        sources.push(source);
    }
    sources
}

fn randomization(given: &Value, errors: &mut Vec<FieldError>) -> Randomization {
    if let Some(named) = given.as_str().and_then(Randomization::named) {
        return named;
    }
    let wrong = match given {
        Value::Object(_) => match Randomization::deserialize(given) {
            Ok(randomization) => return randomization,
            Err(error) => format!("has no amplitudes of axes: {error}"),
        },
        _ => "must be \"usual\", \"wide\", \"none\", or amplitudes by axis".to_owned(),
    };
    errors.push(FieldError::new("/randomize", wrong));
    Randomization::NONE
}

fn cameras(draft: &EpisodesDraft, errors: &mut Vec<FieldError>) -> Cameras {
    let given = &draft.record.cameras;
    if given.len() > MAX_CAMERAS {
        errors.push(FieldError::new("/record/cameras", format!("must name at most {MAX_CAMERAS} cameras")));
    }
    let (mut names, mut own): (Vec<String>, Vec<CameraSpec>) = (Vec::new(), Vec::new());
    for (index, value) in given.iter().enumerate() {
        let mut wrong = |detail: String| {
            errors.push(FieldError::new(format!("/record/cameras/{index}"), detail));
        };
        match value {
            Value::String(name) if names.contains(name) => wrong(format!("{name} is in the list twice")),
            Value::String(name) => names.push(name.clone()),
            _ => match CameraSpec::deserialize(value) {
                Ok(camera) if camera.name.len() > MAX_CAMERA_NAME => {
                    wrong(format!("the name must have at most {MAX_CAMERA_NAME} characters"));
                }
                Ok(camera) => match camera.fault() {
                    Some(fault) => wrong(fault),
                    None => own.push(camera),
                },
                Err(error) => wrong(format!("is neither the name of a usual camera nor a camera: {error}")),
            },
        }
    }
    if !names.is_empty() && !own.is_empty() {
        let detail = "must be names of usual cameras, or own cameras, and not both";
        errors.push(FieldError::new("/record/cameras", detail));
    }
    let side_px = draft.record.size_px;
    let usual = names.len() as u64 * u64::from(side_px).pow(2);
    let pixels = own.iter().map(|camera| u64::from(camera.width_px) * u64::from(camera.height_px));
    if pixels.fold(usual, u64::saturating_add) > MAX_FRAME_PIXELS {
        let detail = format!("cameras must have at most {MAX_FRAME_PIXELS} pixels together");
        errors.push(FieldError::new("/record/cameras", detail));
    }
    if own.is_empty() { Cameras::Usual { names, side_px } } else { Cameras::Own(own) }
}

/// In the order of the list of all, so that the order of names makes no difference.
fn formats(names: &[String], errors: &mut Vec<FieldError>) -> Vec<Format> {
    let mut formats = Vec::new();
    for (index, name) in names.iter().enumerate() {
        match makeable_format(name) {
            Ok(format) => formats.push(format),
            Err(error) => errors.push(FieldError::new(format!("/formats/{index}"), error.to_string())),
        }
    }
    formats.sort_by_key(|format| Format::ALL.iter().position(|known| known == format));
    formats.dedup();
    formats
}

/// Refuses what no dataset can hold, such as images with odd sides. Where usual cameras are depends on the scene, and
/// how instructions in words are understood, too; neither matters here.
fn describe(order: &EpisodesOrder, robot: &Robot) -> Result<(), Problem> {
    let unplaced = |name: &String, side_px| CameraSpec {
        name: name.clone(),
        mount: demonstrations::Mount::World,
        eye_m: DVec3::Z,
        target_m: DVec3::ZERO,
        fov_x_rad: 1.0,
        width_px: side_px,
        height_px: side_px,
    };
    let cameras = match &order.cameras {
        Cameras::Usual { names, side_px } => names.iter().map(|name| unplaced(name, *side_px)).collect(),
        Cameras::Own(own) => own.clone(),
    };
    let cameras = cameras.into_iter().map(|camera| CameraDescription {
        name: camera.name,
        width_px: camera.width_px,
        height_px: camera.height_px,
        depth: order.depth,
        instance_ids: None,
    });
    let described = || {
        let (state, action) = (state_layout(robot)?, action_layout(robot)?);
        let tasks = vec!["a task".to_owned()];
        DatasetDescription::new(robot.name(), order.fps, state, action, cameras.collect(), tasks)
    };
    described().map(|_| ()).map_err(|error| refused(&SetupError::Description(error)))
}

#[cfg(all(test, feature = "video"))]
mod tests {
    use super::*;

    fn draft(value: Value) -> EpisodesDraft {
        serde_json::from_value(value).expect("a draft")
    }

    fn pointers(value: Value) -> Vec<String> {
        let problem = ordered(&draft(value)).expect_err("is refused");
        problem.errors.into_iter().map(|error| error.pointer).collect()
    }

    #[test]
    fn what_is_left_out_is_as_on_the_command_line() {
        let order = ordered(&draft(json!({ "task": "lift the mug", "count": 3 }))).expect("will do");
        assert_eq!((order.robot.as_str(), order.count, order.max_attempts), ("panda", 3, 32));
        assert_eq!((order.fps, order.randomization), (15, Randomization::USUAL));
        let Cameras::Usual { names, side_px } = order.cameras else { panic!("usual cameras") };
        assert_eq!((names, side_px), (vec!["side".into(), "front".into(), "wrist".into()], 224));
    }

    #[test]
    fn an_order_is_that_of_its_statement() {
        let own = json!({ "name": "own", "mount": "world", "eye_m": [0.0, -0.1, 1.2], "target_m": [0.0, 0.0, 0.0],
                          "fov_x_rad": 0.9, "width_px": 64, "height_px": 64 });
        for value in [
            json!({ "task": "lift the mug", "count": 3 }),
            json!({ "tasks": ["lift the mug", "lift the plate"], "count": 9, "title": "Two", "randomize": "wide",
                    "formats": ["robomimic", "lerobot-v3.0"], "keep_failures": true, "max_attempts": 40,
                    "record": { "cameras": [own], "fps": 10, "depth": true, "point_cloud": 100 } }),
            json!({ "task": "lift the mug", "count": 3, "randomize": { "mass": 0.1 }, "seed": 7, "robot": "piper" }),
        ] {
            let order = ordered(&draft(value)).expect("will do");
            assert_eq!(ordered(&stated(&order)).expect("will do").stored(), order.stored());
        }
    }

    #[test]
    fn every_value_that_will_not_do_is_named() {
        let with = |name: &str, value: Value| {
            let mut body = json!({ "task": "lift the mug", "count": 3 });
            body[name] = value;
            body
        };
        // With a format that keeps all that is recorded.
        let kept = |record: Value| json!({ "task": "lift the mug", "count": 3, "formats": ["lerobot-v3.0", "robomimic"], "record": record });
        let camera = |name: &str| {
            json!({ "name": name, "mount": "world", "eye_m": [0, -0.1, 1.2], "target_m": [0, 0, 0],
                    "fov_x_rad": 0.9, "width_px": 64, "height_px": 64 })
        };
        for (value, expected) in [
            (json!({ "count": 3 }), &["/tasks"][..]),
            (json!({ "task": "lift the mug" }), &["/count"]),
            (with("tasks", json!(["lift the mug"])), &["", "/tasks/0"]),
            (with("task", json!({ "name": "mug" })), &["/task", "/tasks"]),
            (with("seed", json!(u64::MAX)), &["/seed"]),
            (with("max_attempts", json!(2)), &["/max_attempts"]),
            (with("max_attempts", json!(2_000_000)), &["/max_attempts"]),
            (with("title", json!(" ")), &["/title"]),
            (with("randomize", json!("wild")), &["/randomize"]),
            (with("randomize", json!({ "wind": 1 })), &["/randomize"]),
            (with("randomize", json!({ "mass": 0.9 })), &["/randomize/mass"]),
            (with("randomize", json!({ "added_distractors": 9 })), &["/randomize/added_distractors"]),
            (kept(json!({ "point_cloud": 0 })), &["/record/point_cloud"]),
            (kept(json!({ "point_cloud": 100, "cameras": [] })), &["/record/point_cloud"]),
            (kept(json!({ "depth": true, "cameras": [] })), &["/record/depth"]),
            (with("record", json!({ "depth": true })), &["/record/depth"]),
            (
                with("record", json!({ "instance_ids": true, "point_cloud": 9 })),
                &["/record/instance_ids", "/record/point_cloud"],
            ),
            (with("formats", json!(["rlds"])), &["/formats/0"]),
            (with("formats", json!([])), &["/formats"]),
            (with("record", json!({ "fps": 0 })), &["/record/fps"]),
            (with("record", json!({ "cameras": ["top"] })), &["/record/cameras"]),
            (with("record", json!({ "cameras": ["side", "side"] })), &["/record/cameras/1"]),
            (with("record", json!({ "cameras": [{ "name": "own" }] })), &["/record/cameras/0"]),
            (with("record", json!({ "cameras": ["side", camera("own")] })), &["/record/cameras"]),
            (with("record", json!({ "cameras": [camera(&"x".repeat(25))] })), &["/record/cameras/0"]),
            (with("record", json!({ "size_px": 2000 })), &["/record/cameras"]),
        ] {
            assert_eq!(pointers(value.clone()), expected, "{value}");
        }
        let all = json!({ "depth": true, "instance_ids": true, "point_cloud": 9 });
        assert!(ordered(&draft(kept(all))).is_ok(), "one of the formats keeps them");
        for (value, code) in [
            (with("robot", json!("hal")), "unknown_robot"),
            (with("record", json!({ "size_px": 33 })), "description"),
            (with("record", json!({ "cameras": [camera("own"), camera("own")] })), "description"),
        ] {
            assert_eq!(ordered(&draft(value.clone())).expect_err("is refused").code, code, "{value}");
        }
    }
}
