//! Units, wherever and whenever they were made, give the bytes of an undisturbed run; what is incomplete never
//! appears complete.

use std::fs;
use std::path::PathBuf;
use std::thread;

use episodes::format::Format;
use episodes::lerobot::v30::FileLimits;
use episodes::{DatasetAssembler, EpisodeError, EpisodeUnit, is_of_dataset};
use tempfile::TempDir;

use crate::reading::{PLAIN, V21, V30, V30_PNG, assembler, dataset, dataset_of, files, number, rows};
use crate::scene;

const ALL: &[Format] = &[V30, V30_PNG, V21, Format::Robomimic, PLAIN];

fn stored(number: u64) -> Vec<u8> {
    scene::unit(number, ALL).expect("a unit").to_bytes()
}

fn loaded(bytes: &[u8]) -> Result<EpisodeUnit, EpisodeError> {
    EpisodeUnit::from_bytes(bytes, &scene::description().expect("a description"))
}

#[test]
fn equal_episodes_give_equal_bytes() {
    let (first, second) = (dataset(ALL), dataset(ALL));
    let (first, second) = (files(first.folder.path()), files(second.folder.path()));
    assert!(first.len() > 50, "{} files", first.len());
    let own = |path: &&PathBuf| is_of_dataset(path.to_str().expect("UTF-8").trim_start_matches("set/"));
    let foreign: Vec<_> = first.keys().filter(|path| !own(path)).collect();
    assert!(foreign.is_empty(), "{foreign:?} would be taken for files of others");
    assert!(first == second);
}

#[test]
fn units_of_several_workers_give_the_bytes_of_one_run() {
    let direct = dataset(ALL);
    // The last episode is made first, each in a thread of its own, and one is made twice after a stop.
    let workers: Vec<_> =
        (0..scene::EPISODES).rev().map(|number| (number, thread::spawn(move || stored(number)))).collect();
    let mut units: Vec<_> =
        workers.into_iter().map(|(number, worker)| (number, worker.join().expect("a worker"))).collect();
    units.sort();
    assert_eq!(units[2].1, stored(2), "a unit that is made again has the same bytes");
    let assembled = dataset_of(units.iter().map(|(_, bytes)| loaded(bytes).expect("a unit")), ALL);
    assert!(files(direct.folder.path()) == files(assembled.folder.path()));
    assert_eq!(direct.summary, assembled.summary);
}

#[test]
fn units_come_back_as_they_were() {
    let unit = scene::unit(1, ALL).expect("a unit");
    assert_eq!(loaded(&unit.to_bytes()).expect("a unit"), unit);
    let tracks = unit.cameras();
    assert_eq!(tracks[0].video.len(), unit.frames());
    assert_eq!(tracks[0].depth_png.len(), unit.frames());
    assert!(tracks[1].depth_png.is_empty(), "the wrist camera has no depth");
}

#[test]
fn damaged_units_are_refused() {
    let bytes = stored(0);
    for at in [0, 7, 8, 20, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        assert!(matches!(loaded(&damaged), Err(EpisodeError::Unit { .. })), "byte {at}");
    }
    assert!(matches!(loaded(&bytes[..bytes.len() - 1]), Err(EpisodeError::Unit { .. })));
    assert!(matches!(loaded(&[]), Err(EpisodeError::Unit { .. })));
}

#[test]
fn units_that_do_not_belong_are_refused() {
    let folder = TempDir::new().expect("a folder");
    let mut dataset = assembler(&folder.path().join("set"), &[V30, PLAIN]);
    let refused = |result: Result<(), EpisodeError>, part: &str| {
        let text = result.expect_err("refused").to_string();
        assert!(text.contains(part), "{text}");
    };
    refused(dataset.add(&scene::unit(0, &[V30]).expect("a unit")).map(|_| ()), "other formats");
    dataset.add(&scene::unit(3, ALL).expect("a unit")).expect("a unit with more than needed");
    refused(dataset.add(&scene::unit(3, ALL).expect("a unit")).map(|_| ()), "episode 3 was added before");
    refused(dataset.add(&scene::unit(2, ALL).expect("a unit")).map(|_| ()), "ascending numbers");
    let place = dataset.add(&scene::unit(4, ALL).expect("a unit")).expect("added");
    assert_eq!((place.episode_index, place.first_frame), (1, scene::frames(3)), "no gap in the dataset");
    assert_eq!(dataset.finish().expect("finished").episodes, 2);
}

#[test]
fn incomplete_datasets_never_appear_complete() {
    let folder = TempDir::new().expect("a folder");
    let set = folder.path().join("set");
    let mut stopped = assembler(&set, ALL);
    stopped.add(&scene::unit(0, ALL).expect("a unit")).expect("added");
    drop(stopped);
    let part = folder.path().join("set.part");
    assert!(!set.exists() && part.join("INCOMPLETE.txt").is_file());
    for missing in [
        "lerobot-v3.0/meta/info.json",
        "lerobot-v2.1/meta/info.json",
        "parquet-png/dataset.json",
        "robomimic/README.md",
    ] {
        assert!(!part.join(missing).exists(), "{missing}");
    }
    // A new run takes the place of the stopped one, and gives the bytes of an undisturbed one.
    let mut again = assembler(&set, ALL);
    (0..scene::EPISODES).for_each(|number| {
        again.add(&scene::unit(number, ALL).expect("a unit")).expect("added");
    });
    again.finish().expect("finished");
    assert!(!part.exists());
    assert!(files(folder.path()) == files(dataset(ALL).folder.path()));
}

#[test]
fn folders_of_others_are_left_alone() {
    let folder = TempDir::new().expect("a folder");
    let create = |name: &str| {
        let description = scene::description().expect("a description");
        DatasetAssembler::create(&folder.path().join(name), description, ALL, scene::card()).map(|_| ())
    };
    fs::create_dir(folder.path().join("set")).expect("a folder");
    assert!(matches!(create("set"), Err(EpisodeError::Folder { .. })));
    fs::create_dir(folder.path().join("other.part")).expect("a folder");
    fs::write(folder.path().join("other.part/notes.txt"), "mine").expect("a file");
    assert!(matches!(create("other"), Err(EpisodeError::Folder { .. })));
    assert_eq!(fs::read_to_string(folder.path().join("other.part/notes.txt")).expect("a file"), "mine");
    let empty = assembler(&folder.path().join("empty"), ALL);
    assert!(empty.finish().expect_err("refused").to_string().contains("no episode was added"));
    assert!(!folder.path().join("empty").exists());
}

#[test]
fn files_roll_over_at_their_limits_and_keep_episodes_whole() {
    let folder = TempDir::new().expect("a folder");
    let set = folder.path().join("set");
    let unit = |number| scene::unit(number, &[V30]).expect("a unit");
    let of_camera = |number: u64| -> u64 {
        unit(number).cameras()[0].video.iter().map(|sample| sample.bytes.len() as u64).sum()
    };
    // Two episodes fit a video file, three do not; every episode has a file of rows.
    let limits = FileLimits { data_bytes: 1, video_bytes: of_camera(0) + of_camera(1) + 200 };
    let description = scene::description().expect("a description");
    let mut dataset =
        DatasetAssembler::with_limits(&set, description, &[V30], scene::card(), limits).expect("a dataset");
    (0..5).for_each(|number| {
        dataset.add(&unit(number)).expect("added");
    });
    dataset.finish().expect("finished");
    let root = set.join("lerobot-v3.0");
    let episodes = rows(&root.join("meta/episodes/chunk-000/file-000.parquet"));
    let column = |name: &str| -> Vec<f64> { episodes.iter().map(|row| number(&row[name])).collect() };
    assert_eq!(column("data/file_index"), [0.0, 1.0, 2.0, 3.0, 4.0]);
    let video = column("videos/observation.images.front/file_index");
    assert_eq!(video[..3], [0.0, 0.0, 1.0], "{video:?}");
    let starts = column("videos/observation.images.front/from_timestamp");
    assert_eq!(starts[..3], [0.0, 17.0 / 15.0, 0.0]);
    for (index, row) in episodes.iter().enumerate() {
        let data = rows(&root.join(format!("data/chunk-000/file-{index:03}.parquet")));
        assert_eq!(data.len() as f64, number(&row["length"]));
        assert!(data.iter().all(|frame| number(&frame["episode_index"]) == index as f64));
        let (file, camera) = (video[index] as u64, "observation.images.front");
        assert!(root.join(format!("videos/{camera}/chunk-000/file-{file:03}.mp4")).is_file());
    }
}
