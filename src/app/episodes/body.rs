//! The body of a request for episodes as an order.

use std::collections::BTreeSet;

use serde::Deserialize;
use serde_json::Value;

use super::order::{Cameras, EpisodesOrder, format_named};
use super::refused;
use crate::api::episodes::EpisodesBody;
use crate::api::error::{FieldError, Problem, ProblemType};
use crate::app::executions::TaskSource;
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
pub fn ordered(body: &EpisodesBody) -> Result<EpisodesOrder, Problem> {
    let mut errors = Vec::new();
    let robot = Robot::built_in(&body.robot, None)
        .map_err(|error| Problem::new(ProblemType::InvalidRequest, "unknown_robot", error.to_string()))?;
    let order = EpisodesOrder {
        tasks: tasks(body, &mut errors),
        robot: body.robot.clone(),
        count: body.count,
        seed: body.seed,
        randomization: randomization(&body.randomize, &mut errors),
        cameras: cameras(body, &mut errors),
        fps: body.record.fps,
        depth: body.record.depth,
        instance_ids: body.record.instance_ids,
        points: body.record.point_cloud,
        formats: formats(&body.formats, &mut errors),
        keeps_failures: body.keep_failures,
        max_attempts: body
            .max_attempts
            .unwrap_or_else(|| EpisodesOrder::usual_max_attempts(body.count.min(MAX_ATTEMPTS))),
    };
    if order.seed > MAX_SEED {
        errors.push(FieldError::new("/seed", format!("must be at most {MAX_SEED}")));
    }
    if body.max_attempts.is_some_and(|attempts| attempts > MAX_ATTEMPTS) {
        errors.push(FieldError::new("/max_attempts", format!("must be at most {MAX_ATTEMPTS}")));
    }
    let is_title = |title: &str| (1..=MAX_TITLE).contains(&title.trim().chars().count());
    if body.title.as_deref().is_some_and(|title| !is_title(title)) {
        errors.push(FieldError::new("/title", format!("must have from 1 to {MAX_TITLE} characters")));
    }
    if let Err(problem) = order.check() {
        errors.extend(
            problem.errors.into_iter().filter_map(|error| in_body(error, &errors)).collect::<Vec<_>>(),
        );
    }
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    describe(&order, &robot)?;
    Ok(order)
}

/// An error of an order where it is in a body; `None` where there is one already.
fn in_body(error: FieldError, errors: &[FieldError]) -> Option<FieldError> {
    let pointer = match error.pointer.as_str() {
        "/fps" | "/cameras" | "/depth" | "/instance_ids" | "/point_cloud" => {
            format!("/record{}", error.pointer)
        }
        _ => error.pointer,
    };
    let is_known = errors.iter().any(|known| known.pointer.starts_with(&pointer));
    (!is_known).then(|| FieldError::new(pointer, error.detail))
}

fn tasks(body: &EpisodesBody, errors: &mut Vec<FieldError>) -> Vec<TaskSource> {
    if body.task.is_some() && body.tasks.is_some() {
        errors.push(FieldError::new("", "give `task` or `tasks`, one of them; both are there"));
    }
    let given = body.tasks();
    if given.len() > MAX_TASKS {
        errors.push(FieldError::new("/tasks", format!("must name at most {MAX_TASKS} tasks")));
    }
    let (mut sources, mut instructions) = (Vec::new(), BTreeSet::new());
    for (pointer, value) in given {
        let (source, instruction) = match value {
            Value::String(text) => (TaskSource::Text(text.clone()), text.clone()),
            _ => match Task::deserialize(value) {
                Ok(task) => {
                    if task.robot != body.robot {
                        let detail = format!("is for the robot {}, not {}", task.robot, body.robot);
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

fn cameras(body: &EpisodesBody, errors: &mut Vec<FieldError>) -> Cameras {
    let given = &body.record.cameras;
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
    let side_px = body.record.size_px;
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
        match format_named(name) {
            Ok(format) => formats.push(format),
            Err(detail) => errors.push(FieldError::new(format!("/formats/{index}"), detail)),
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn body(value: Value) -> EpisodesBody {
        serde_json::from_value(value).expect("a body")
    }

    fn pointers(value: Value) -> Vec<String> {
        let problem = ordered(&body(value)).expect_err("is refused");
        problem.errors.into_iter().map(|error| error.pointer).collect()
    }

    #[test]
    fn what_is_left_out_is_as_on_the_command_line() {
        let order = ordered(&body(json!({ "task": "lift the mug", "count": 3 }))).expect("will do");
        assert_eq!((order.robot.as_str(), order.count, order.max_attempts), ("panda", 3, 32));
        assert_eq!((order.fps, order.randomization), (15, Randomization::USUAL));
        let Cameras::Usual { names, side_px } = order.cameras else { panic!("usual cameras") };
        assert_eq!((names, side_px), (vec!["side".into(), "front".into(), "wrist".into()], 224));
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
        assert!(ordered(&body(kept(all))).is_ok(), "one of the formats keeps them");
        for (value, code) in [
            (with("robot", json!("hal")), "unknown_robot"),
            (with("record", json!({ "size_px": 33 })), "description"),
            (with("record", json!({ "cameras": [camera("own"), camera("own")] })), "description"),
        ] {
            assert_eq!(ordered(&body(value.clone())).expect_err("is refused").code, code, "{value}");
        }
    }
}
