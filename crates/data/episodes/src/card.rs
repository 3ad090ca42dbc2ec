//! The card of a dataset: its `README.md`, as people and hubs read it.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::dataset_statistics::image_key;
use crate::description::DatasetDescription;
use crate::format::{DepthStorage, Encodings, Format, ImageStorage};
use crate::limit_shares::LimitShares;
use crate::numeric_features::SERVO_COMMAND;
use crate::strip::strip_path;
use crate::vector_layout::VectorLayout;

/// Episodes whose strips the card shows.
const SHOWN_STRIPS: u64 = 4;

/// Facts about a dataset that the caller knows and this crate does not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DatasetCard {
    pub title: String,
    /// The identifier of the license, such as `cc-by-4.0`.
    pub license: String,
    /// Programs and data with their versions.
    pub versions: Vec<(String, String)>,
    /// Variation between episodes, with ranges and units. Markdown.
    pub randomization: String,
    /// Instructions for making one episode again from its record. Markdown.
    pub regeneration: String,
    /// Number of attempts by result, `success` or the reason of a failure; also of attempts that are not in the
    /// dataset.
    pub attempts: BTreeMap<String, u64>,
}

/// Content of a dataset, as its card states it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DatasetSummary {
    pub episodes: u64,
    pub frames: u64,
    /// Episodes by `success` or reason of failure.
    pub outcomes: BTreeMap<String, u64>,
    /// Smallest and largest seed.
    pub seeds: Option<(u64, u64)>,
    /// The largest shares of the robot's limits that actions use, and those that servo commands use.
    pub action_shares: Vec<LimitShares>,
    pub servo_shares: Vec<LimitShares>,
}

/// The text of `README.md` in the folder of a format, one of all `formats` of the dataset.
pub(crate) fn card_text(
    card: &DatasetCard,
    summary: &DatasetSummary,
    description: &DatasetDescription,
    format: Format,
    formats: &[Format],
) -> String {
    let mut text = String::new();
    let is_lerobot = matches!(format, Format::LeRobotV30 { .. } | Format::LeRobotV21 { .. });
    let tags = if is_lerobot { "\ntags:\n- LeRobot" } else { "" };
    let mut line = |content: String| {
        text.push_str(&content);
        text.push('\n');
    };
    line(format!("---\nlicense: {}\ntask_categories:\n- robotics{tags}\n---\n", one_line(&card.license)));
    line(format!("# {}\n", one_line(&card.title)));
    line(format!(
        "{} episodes with {} frames at {} frames per second; robot `{}`. License: {}.\n",
        summary.episodes,
        summary.frames,
        description.fps(),
        description.robot_type(),
        one_line(&card.license)
    ));
    line(format!("{}\n", format_text(format)));
    line("## Tasks\n".into());
    description.tasks().iter().enumerate().for_each(|(i, task)| line(format!("{i}. {task}")));
    line(format!("\n## Features\n\n{}", feature_table(description, format)));
    if let Some(missing) = missing_text(description, format, formats) {
        line(format!("{missing}\n"));
    }
    line(format!("{CONVENTIONS}\n"));
    if !summary.action_shares.is_empty() {
        line(format!("## Limits of the robot\n\n{}", limits_text(summary, description.fps())));
    }
    line("## Seeds and records\n".into());
    if let Some((min, max)) = summary.seeds {
        line(format!(
            "Seeds are from {min} to {max}. `records.jsonl` has the seed, the outcome and the record of each"
        ));
        line("episode, in the order of the dataset; an episode can be made again from its record.\n".into());
    }
    if !card.regeneration.is_empty() {
        line(format!("{}\n", card.regeneration.trim()));
    }
    if !description.cameras().is_empty() && summary.episodes > 0 {
        line("## Strips\n\n`strips` has a few frames of each episode and camera, from its beginning to its end.\n".into());
        if format.has_video() {
            line("Beside them is a small video of each episode, with all cameras.\n".into());
        }
        for episode in 0..summary.episodes.min(SHOWN_STRIPS) {
            for camera in description.cameras() {
                let path = strip_path(episode, &camera.name);
                line(format!("![episode {episode}, camera {}]({path})", camera.name));
            }
        }
        line(String::new());
    }
    line(format!("## Randomization\n\n{}\n", or_none(&card.randomization)));
    line(format!("## Outcomes\n\nEpisodes in the dataset:\n\n{}", count_table(&summary.outcomes)));
    if !card.attempts.is_empty() {
        line(format!("All attempts:\n\n{}", count_table(&card.attempts)));
    }
    line("## Versions\n".into());
    line("| program | version |\n| --- | --- |".into());
    card.versions.iter().for_each(|(name, version)| line(format!("| {} | {} |", cell(name), cell(version))));
    text
}

const CONVENTIONS: &str = "\
- `state[t]` is measured before `action[t]` is sent; `action[t]` is the commanded target. Frame t is at t over the rate.
- `servo_command[t]`, where it is there, is what position servos pull to for `action[t]`: it leads the motion by what
  damping and weights hold back. Repeat a motion from it; train on `action`, which a robot can follow.
- A gripper's opening is in meters where the name ends in `_m`. Where it ends in `_0_closed_1_open`, 0 is closed.
- Quaternions are w, x, y, z, as the names say, without jumps of their sign: along an episode, between state and action,
  and at the first frame of all episodes.
- `end_effector_rotation_6d` has the first two columns of the same rotation's matrix, one after the other.
- Images are RGB; row 0 is the top.
- Depth is along the optical axis in meters unless stated otherwise; 0 where nothing is in sight.
- Points of `point_cloud` are x, y, z in the world, in meters, with colors and instance ids beside them.
- `intrinsics` is K in pixels, row by row; the center of the first pixel is at (0.5, 0.5).
- `world_from_camera` takes points of the camera to the world, row by row, in meters. Cameras have OpenCV axes: x right,
  y down, z forward.";

fn format_text(format: Format) -> String {
    let images = |storage| match storage {
        ImageStorage::Video => {
            "Images are H.264 video, 4:2:0, with a key frame at the start of each episode and at most 10 frames apart."
        }
        ImageStorage::Png => "Images are PNG in Parquet, without loss.",
    };
    match format {
        Format::LeRobotV30 { images: storage } => format!("Format: LeRobot v3.0. {}", images(storage)),
        Format::LeRobotV21 { images: storage } => {
            format!("Format: LeRobot v2.1 with `meta/modality.json`. {}", images(storage))
        }
        Format::Robomimic => {
            "Format: HDF5 in the layout of robomimic, `dataset.hdf5`. `actions` are scaled to [-1, 1] \
             by the declared ranges; `action_targets` are in their units."
                .into()
        }
        Format::ParquetAndPng { depth: DepthStorage::PngMillimeters } => {
            "Format: Parquet and PNG files. Depth is PNG with 16 bits a pixel in millimeters.".into()
        }
        Format::ParquetAndPng { depth: DepthStorage::ParquetMeters } => {
            "Format: Parquet and PNG files. Depth is f32 in Parquet in meters.".into()
        }
    }
}

fn feature_table(description: &DatasetDescription, format: Format) -> String {
    let mut table = "| feature | number | unit | range |\n| --- | --- | --- | --- |\n".to_owned();
    let mut layout = |key: &str, layout: &VectorLayout| {
        for element in layout.elements() {
            let range = element.range.map_or_else(String::new, |[min, max]| format!("{min} to {max}"));
            let (name, unit) = (element.full_name(), element.unit.text());
            let _ = writeln!(table, "| `{key}` | `{name}` | {unit} | {range} |");
        }
    };
    layout("state", description.state());
    layout("action", description.action());
    description.servo_command().into_iter().for_each(|commands| layout(SERVO_COMMAND, commands));
    let [keeps_depth, keeps_ids, keeps_points] = Encodings::of(&[format]).kept_measures();
    for camera in description.cameras() {
        let ids = camera.instance_ids.is_some() && keeps_ids;
        let extras = [(camera.depth && keeps_depth, "depth"), (ids, "instance ids")];
        let extras: Vec<&str> = extras.iter().filter(|(has, _)| *has).map(|(_, name)| *name).collect();
        let recorded =
            if extras.is_empty() { String::new() } else { format!(", with {}", extras.join(", ")) };
        let (key, width_px, height_px) = (image_key(&camera.name), camera.width_px, camera.height_px);
        let _ = writeln!(table, "| `{key}` | RGB {width_px} x {height_px}{recorded} | | |");
    }
    if let Some(points) = description.points().filter(|_| keeps_points) {
        let _ = writeln!(table, "| `point_cloud` | {points} points x 3 | m | |");
    }
    table
}

/// Text about recorded data that this format does not keep, and the formats that do; `None` if it keeps all.
fn missing_text(description: &DatasetDescription, format: Format, formats: &[Format]) -> Option<String> {
    let cameras = description.cameras();
    let recorded = [
        cameras.iter().any(|camera| camera.depth),
        cameras.iter().any(|camera| camera.instance_ids.is_some()),
        description.points().is_some(),
    ];
    let kept = |format: Format| Encodings::of(&[format]).kept_measures();
    let names = ["depth", "instance ids", "points"];
    let lacks = |index: &usize| recorded[*index] && !kept(format)[*index];
    let missing: Vec<usize> = (0..names.len()).filter(lacks).collect();
    let keeps = |other: &&Format| missing.iter().all(|index| kept(**other)[*index]);
    let others: Vec<String> =
        formats.iter().filter(keeps).map(|other| format!("`{}`", other.folder())).collect();
    let missing: Vec<&str> = missing.into_iter().map(|index| names[index]).collect();
    let place = if others.is_empty() { "no format of this dataset".to_owned() } else { others.join(", ") };
    (!missing.is_empty()).then(|| format!("Not in this format: {}. They are in {place}.", missing.join(", ")))
}

fn limits_text(summary: &DatasetSummary, fps: u32) -> String {
    let mut text = format!(
        "The largest shares that the numbers of all episodes use: of a range from its center, and of velocity, acceleration \
         and jerk by differences at {fps} Hz. Above 100 % is beyond a limit.\n\n\
         | feature | number | position | velocity | acceleration | jerk |\n\
         | --- | --- | ---: | ---: | ---: | ---: |\n"
    );
    for (key, shares) in [("action", &summary.action_shares), (SERVO_COMMAND, &summary.servo_shares)] {
        for share in shares {
            let shares = [share.position, share.velocity, share.acceleration, share.jerk];
            let cells: Vec<String> = shares.iter().map(|share| format!("{:.1} %", 100.0 * share)).collect();
            let _ = writeln!(text, "| `{key}` | `{}` | {} |", share.name, cells.join(" | "));
        }
    }
    text
}

fn count_table(counts: &BTreeMap<String, u64>) -> String {
    let rows = counts.iter().map(|(outcome, count)| format!("| {} | {count} |\n", cell(outcome)));
    format!("| outcome | count |\n| --- | --- |\n{}", rows.collect::<String>())
}

fn or_none(text: &str) -> &str {
    if text.trim().is_empty() { "None." } else { text.trim() }
}

fn cell(text: &str) -> String {
    one_line(text).replace('|', "\\|")
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
