//! One test for each mistake that users of datasets report and that a writer can make.

use episodes::episode::{EpisodeHeader, Outcome};
use episodes::frame::Frame;
use episodes::unit_of_measure::Unit;
use episodes::vector_layout::{VectorElement, VectorLayout};
use episodes::{DatasetDescription, EpisodeEncoder};
use openh264::decoder::Decoder;
use serde_json::json;

use crate::reading::{PLAIN, V21, V30, V30_PNG, dataset, floats, number, numbers};
use crate::scene;

#[test]
fn seeds_and_records_are_shipped() {
    let dataset = dataset(&[V30]);
    let records = dataset.lines(V30, "records.jsonl");
    assert_eq!(records.len(), 5);
    for (episode, record) in (0_u64..).zip(&records) {
        assert_eq!(record["episode_index"], json!(episode));
        assert_eq!(record["seed"], json!(1000 + episode));
        assert_eq!(record["record"], json!({"example": "synthetic", "number": episode}));
    }
    assert_eq!((&records[3]["success"], &records[3]["outcome"]), (&json!(false), &json!("dropped")));
}

#[test]
fn state_precedes_action() {
    let dataset = dataset(&[V30]);
    let rows = dataset.rows(V30, "data/chunk-000/file-000.parquet");
    let mut checked = 0;
    for pair in rows.windows(2).filter(|pair| pair[0]["episode_index"] == pair[1]["episode_index"]) {
        let (state, next) = (floats(&pair[0]["observation.state"]), floats(&pair[1]["observation.state"]));
        let action = floats(&pair[0]["action"]);
        // The law of the synthetic robot holds with this order only.
        assert!((next[0] - (state[0] + 0.5 * (action[0] - state[0]))).abs() < 1e-6);
        let shifted = floats(&pair[1]["action"]);
        if (shifted[0] - action[0]).abs() > 1e-3 {
            assert!((next[0] - (state[0] + 0.5 * (shifted[0] - state[0]))).abs() > 1e-4);
            checked += 1;
        }
    }
    assert!(checked > 50, "{checked}");
}

#[test]
fn action_that_copies_the_state_is_refused() {
    let joint = || vec![VectorElement::new("arm", "joint", Unit::Radians)];
    let layout = |kind| VectorLayout::new(kind, joint()).expect("a layout");
    let tasks = vec!["push".to_owned()];
    let description =
        DatasetDescription::new("arm", 10, layout("state"), layout("action"), vec![], tasks).expect("valid");
    let finished = |lead: f32, speed: f32| {
        let header = EpisodeHeader { number: 0, seed: 0, task: 0, record: json!(null) };
        let mut encoder = EpisodeEncoder::new(&description, &[V30], header).expect("an encoder");
        for t in 0..5 {
            let state = speed * t as f32;
            encoder
                .add(&Frame {
                    state: &[state],
                    action: &[state + lead],
                    servo_command: &[],
                    cameras: &[],
                    points: None,
                })
                .expect("added");
        }
        encoder.finish(Outcome::Success)
    };
    assert!(finished(0.0, 0.1).expect_err("refused").to_string().contains("commanded targets"));
    assert!(finished(0.1, 0.1).is_ok(), "a target ahead of the state is no copy");
    assert!(finished(0.0, 0.0).is_ok(), "a robot that stands still may be asked to");
}

#[test]
fn gripper_units_are_in_the_names() {
    let dataset = dataset(&[V30]);
    let features = &dataset.json(V30, "meta/info.json")["features"];
    let names = features["observation.state"]["names"].as_array().expect("names");
    assert_eq!(names[1..3], [json!("gripper_0_closed_1_open"), json!("gripper_opening_m")]);
    assert_eq!(features["action"]["names"][1], "gripper_0_closed_1_open");
    // 1 is open: the opening in meters grows with the fraction.
    let rows = dataset.rows(V30, "data/chunk-000/file-000.parquet");
    for row in &rows {
        let state = floats(&row["observation.state"]);
        assert!((state[2] - 0.08 * state[1]).abs() < 1e-7);
    }
}

/// The decoded frames of a camera of episode 0: red, green, blue, row by row.
fn decoded() -> Vec<Vec<u8>> {
    let unit = scene::unit(0, &[V30]).expect("a unit");
    let mut decoder = Decoder::new().expect("a decoder");
    let decode = |sample: &video::Sample| {
        let frame = decoder.decode(&sample.bytes).expect("decoded").expect("a frame");
        let mut rgb = vec![0; (3 * scene::WIDTH_PX * scene::HEIGHT_PX) as usize];
        frame.write_rgb8(&mut rgb);
        rgb
    };
    unit.cameras()[0].video.iter().map(decode).collect()
}

fn at(rgb: &[u8], x: u32, y: u32) -> [i32; 3] {
    let start = (3 * (y * scene::WIDTH_PX + x)) as usize;
    [0, 1, 2].map(|channel| i32::from(rgb[start + channel]))
}

fn assert_near(actual: [i32; 3], expected: [i32; 3]) {
    let error = actual.iter().zip(expected).map(|(a, b)| (a - b).abs()).max().expect("channels");
    assert!(error <= 12, "{actual:?}, not {expected:?}");
}

#[test]
fn colors_are_red_green_blue_in_this_order() {
    for rgb in decoded() {
        assert_near(at(&rgb, 80, 4), [220, 30, 40]);
        assert_near(at(&rgb, 80, 12), [30, 200, 50]);
        assert_near(at(&rgb, 80, 20), [40, 50, 210]);
    }
    let features = dataset(&[V30_PNG]).json(V30_PNG, "meta/stats.json");
    // The mean of red over the card: 8 of 64 rows 220, and so on; blue is least in the yellow square.
    let mean = &features["observation.images.front"]["mean"];
    let [red, _, blue] = [0, 1, 2].map(|channel: usize| mean[channel][0][0].as_f64().expect("a number"));
    assert!(red > blue, "{mean}");
}

#[test]
fn first_row_is_the_top() {
    let first = &decoded()[0];
    assert_near(at(first, 80, 1), [220, 30, 40]);
    assert_near(at(first, 80, 62), [120, 120, 120]);
    let dataset = dataset(&[PLAIN]);
    let path = dataset.path(PLAIN, "episodes/episode_000000/front/rgb_000000.png");
    let image = imaging::codec::decode_png(&std::fs::read(path).expect("a file")).expect("PNG");
    assert_eq!(image.pixel(80, 0), [220, 30, 40, 255]);
    assert_eq!(image.pixel(80, 63), [120, 120, 120, 255]);
}

#[test]
fn timestamps_are_quotients() {
    let dataset = dataset(&[V30]);
    for row in dataset.rows(V30, "data/chunk-000/file-000.parquet") {
        let expected = (number(&row["frame_index"]) / 15.0) as f32;
        assert_eq!(floats(&row["timestamp"]), [expected]);
    }
    let mut first = 0;
    for row in dataset.rows(V30, "meta/episodes/chunk-000/file-000.parquet") {
        let last = first + number(&row["length"]) as u64;
        for camera in ["front", "wrist"] {
            let time = |name: &str| number(&row[&format!("videos/observation.images.{camera}/{name}")]);
            assert_eq!(time("from_timestamp"), first as f64 / 15.0);
            assert_eq!(time("to_timestamp"), last as f64 / 15.0);
        }
        assert_eq!(number(&row["dataset_from_index"]), first as f64);
        assert_eq!(number(&row["dataset_to_index"]), last as f64);
        first = last;
    }
}

#[test]
fn key_frames_begin_episodes_and_are_at_most_ten_apart() {
    for number in 0..scene::EPISODES {
        for track in scene::unit(number, &[V30]).expect("a unit").cameras() {
            let keys: Vec<usize> = track
                .video
                .iter()
                .enumerate()
                .filter(|(_, sample)| sample.is_key)
                .map(|(at, _)| at)
                .collect();
            assert_eq!(keys[0], 0);
            let ends = keys.iter().skip(1).copied().chain([track.video.len()]);
            assert!(keys.iter().zip(ends).all(|(start, end)| end - start <= 10), "{keys:?}");
        }
    }
}

#[test]
fn both_versions_of_lerobot_say_the_same() {
    let dataset = dataset(&[V30, V21]);
    let (new, old) = (dataset.json(V30, "meta/info.json"), dataset.json(V21, "meta/info.json"));
    assert_eq!((&new["codebase_version"], &old["codebase_version"]), (&json!("v3.0"), &json!("v2.1")));
    for key in ["features", "fps", "robot_type", "total_episodes", "total_frames", "total_tasks", "splits"] {
        assert_eq!(new[key], old[key], "{key}");
    }
    assert_eq!((&old["total_videos"], &old["total_chunks"]), (&json!(10), &json!(1)));
    assert_eq!(dataset.text(V30, "meta/stats.json"), dataset.text(V21, "meta/stats.json"));
    let rows = dataset.rows(V30, "meta/episodes/chunk-000/file-000.parquet");
    let lines = dataset.lines(V21, "meta/episodes.jsonl");
    let statistics = dataset.lines(V21, "meta/episodes_stats.jsonl");
    assert_eq!((rows.len(), lines.len(), statistics.len()), (5, 5, 5));
    for ((row, line), of_episode) in rows.iter().zip(&lines).zip(&statistics) {
        assert_eq!(number(&row["length"]), line["length"].as_f64().expect("a length"));
        assert_eq!(row["tasks"].to_string(), format!("[{}]", line["tasks"][0]));
        let means = of_episode["stats"]["observation.state"]["mean"].as_array().expect("means");
        let means: Vec<f64> = means.iter().map(|mean| mean.as_f64().expect("a number")).collect();
        assert_eq!(numbers(&row["stats/observation.state/mean"]), means);
    }
    // The groups of GR00T cover every number once.
    let modality = dataset.json(V21, "meta/modality.json");
    for (kind, dimension) in [("state", 16), ("action", 2)] {
        let groups = modality[kind].as_object().expect("groups");
        let mut end = 0;
        for group in groups.values() {
            assert_eq!(group["start"], json!(end));
            end = group["end"].as_u64().expect("an end");
        }
        assert_eq!(end, dimension);
    }
    assert_eq!(modality["video"]["front"]["original_key"], "observation.images.front");
}

#[test]
fn quantiles_are_present_and_in_order() {
    let dataset = dataset(&[V30]);
    let statistics = dataset.json(V30, "meta/stats.json");
    let info = dataset.json(V30, "meta/info.json");
    for (key, feature) in info["features"].as_object().expect("features") {
        let of_feature = &statistics[key];
        let is_image = feature["dtype"] == "video";
        let flat = |name: &str| -> Vec<f64> {
            let values = of_feature[name].as_array().unwrap_or_else(|| panic!("{key} lacks {name}"));
            // Images have the shape (3, 1, 1).
            values
                .iter()
                .map(|value| if is_image { &value[0][0] } else { value }.as_f64().expect("a number"))
                .collect()
        };
        let names = ["min", "q01", "q10", "q50", "q90", "q99", "max"];
        for pair in names.windows(2) {
            assert!(flat(pair[0]).iter().zip(flat(pair[1])).all(|(a, b)| *a <= b), "{key}: {pair:?}");
        }
        assert_eq!(flat("std").len(), flat("mean").len());
        if is_image {
            assert!(flat("max").iter().all(|max| (0.5..=1.0).contains(max)), "{key}");
            let pixels = 109 * u64::from(scene::WIDTH_PX * scene::HEIGHT_PX);
            assert_eq!(of_feature["count"], json!([pixels]));
        } else {
            assert_eq!(of_feature["count"], json!([109]), "{key}");
        }
    }
}

#[test]
fn depth_is_in_declared_millimeters() {
    let dataset = dataset(&[PLAIN]);
    let path = dataset.path(PLAIN, "episodes/episode_000000/front/depth_mm_000000.png");
    let image = image::load_from_memory(&std::fs::read(path).expect("a file")).expect("PNG").into_luma16();
    assert_eq!(image.get_pixel(0, 10).0, [0], "0 where nothing is in sight");
    // 0.5 + 0.001 x + 0.002 y meters.
    assert_eq!(image.get_pixel(10, 20).0, [550]);
    let conventions = &dataset.json(PLAIN, "dataset.json")["conventions"];
    assert!(conventions["depth"].as_str().expect("a text").contains("millimeters"));
}

#[test]
fn quaternions_are_w_first_in_the_names() {
    let names = scene::description().expect("a description").state().full_names();
    let ends = ["end_effector_qw", "end_effector_qx", "end_effector_qy", "end_effector_qz"];
    assert_eq!(names[6..10], ends);
    let mut elements = VectorElement::end_effector_pose().to_vec();
    elements[3..7].rotate_left(1);
    let text = VectorLayout::new("state", elements).expect_err("x first is refused").to_string();
    assert!(text.contains("qw, qx, qy, qz"), "{text}");
    // The robot does not turn: the first component is 1, and the columns are the axes.
    let dataset = dataset(&[V30]);
    let rows = dataset.rows(V30, "data/chunk-000/file-000.parquet");
    let state = floats(&rows[0]["observation.state"]);
    assert_eq!(state[6..10], [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(state[10..], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn quaternions_that_jump_to_their_negative_are_refused() {
    let pose = || VectorElement::end_effector_pose().to_vec();
    let layout = |kind: &str| VectorLayout::new(kind, pose()).expect("a layout");
    let tasks = vec!["turn".to_owned()];
    let description = DatasetDescription::new("arm", 10, layout("state"), layout("action"), vec![], tasks);
    let description = description.expect("valid");
    let header = EpisodeHeader { number: 0, seed: 0, task: 0, record: serde_json::Value::Null };
    let mut encoder = EpisodeEncoder::new(&description, &[V30], header).expect("an encoder");
    // A hand that points down, whose w is all but 0.
    let down = |w: f32, sign: f32| -> Vec<f32> {
        let quaternion = [w, sign, 0.0, 0.0];
        [&[0.1, 0.2, 0.3][..], &quaternion, &[1.0, 0.0, 0.0, 0.0, -1.0, 0.0]].concat()
    };
    let mut add = |state: &[f32], action: &[f32]| {
        encoder.add(&Frame { state, action, servo_command: &[], cameras: &[], points: None })
    };
    add(&down(0.001, 1.0), &down(0.0, 1.0)).expect("one sign");
    add(&down(-0.001, 1.0), &down(-0.002, 1.0)).expect("w may change its sign");
    let jumped = add(&down(0.001, -1.0), &down(0.0, -1.0)).expect_err("state jumps").to_string();
    assert!(jumped.contains("`end_effector_rotation` of the state has the other sign"), "{jumped}");
    let jumped = add(&down(0.0, 1.0), &down(0.0, -1.0)).expect_err("action jumps").to_string();
    assert!(jumped.contains("`end_effector_rotation` of the action has the other sign"), "{jumped}");
}

#[test]
fn extrinsics_reproject_a_point_of_the_world() {
    let dataset = dataset(&[V30]);
    // A point on the plane z = 0 below the camera, which is 1 m above and moves along x by 1 cm a frame.
    let point = [0.1, 0.05, 0.0];
    for row in dataset.rows(V30, "data/chunk-000/file-000.parquet") {
        let t = number(&row["frame_index"]);
        let k = numbers(&row["camera.wrist.intrinsics"]);
        let pose = numbers(&row["camera.wrist.world_from_camera"]);
        let away = [point[0] - pose[3], point[1] - pose[7], point[2] - pose[11]];
        // The inverse of a rotation is its transpose: components along the columns.
        let along = |axis: usize| (0..3).map(|i| pose[4 * i + axis] * away[i]).sum::<f64>();
        let (x, y, z) = (along(0), along(1), along(2));
        assert!((z - 1.0).abs() < 1e-6, "the point is 1 m in front of the camera, not {z}");
        let (u, v) = (k[0] * x / z + k[2], k[4] * y / z + k[5]);
        // Right of the center by 10 px less 1 px a frame, and above it: v points down, y of the world up.
        assert!((u - (58.0 - t)).abs() < 1e-4, "{u}");
        assert!((v - 27.0).abs() < 1e-4, "{v}");
    }
}

#[test]
fn names_have_no_slashes() {
    let dataset = dataset(&[V30, V21]);
    for format in [V30, V21] {
        let info = dataset.json(format, "meta/info.json");
        for (key, feature) in info["features"].as_object().expect("features") {
            assert!(!key.contains('/'), "{key}");
            let names = feature["names"].as_array().cloned().unwrap_or_default();
            assert!(names.iter().all(|name| !name.as_str().expect("a name").contains('/')));
        }
    }
}
