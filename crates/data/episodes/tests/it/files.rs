//! The content of each format, read back.

use std::fs;

use episodes::format::Format;
use parquet::record::Field;
use rust_hdf5::H5File;
use serde_json::json;

use crate::reading::{PLAIN, PLAIN_METERS, V21, V30, V30_PNG, dataset, floats, number, numbers};
use crate::scene;

#[test]
fn rows_of_lerobot_are_the_frames() {
    let dataset = dataset(&[V30, V30_PNG, V21]);
    let all = dataset.rows(V30, "data/chunk-000/file-000.parquet");
    assert_eq!(all.len() as u64, dataset.summary.frames);
    let mut index = 0;
    for episode in 0..scene::EPISODES {
        let alone = dataset.rows(V21, &format!("data/chunk-000/episode_{episode:06}.parquet"));
        assert_eq!(alone.len() as u64, scene::frames(episode));
        for (t, state) in scene::states(episode).iter().enumerate() {
            let row = &all[index];
            assert_eq!(row, &alone[t], "both versions have equal rows");
            assert_eq!(floats(&row["observation.state"]), state);
            assert_eq!(floats(&row["action"]), scene::action(episode, t as u64));
            assert_eq!(floats(&row["servo_command"]), scene::servo_command(episode, t as u64));
            assert_eq!(number(&row["index"]), index as f64);
            assert_eq!(number(&row["frame_index"]), t as f64);
            assert_eq!(number(&row["task_index"]), (episode % 2) as f64);
            index += 1;
        }
    }
    let png = dataset.rows(V30_PNG, "data/chunk-000/file-000.parquet");
    let Field::Group(file) = &png[3]["observation.images.front"] else { panic!("no file") };
    let columns: Vec<&String> = file.get_column_iter().map(|(name, _)| name).collect();
    assert_eq!(columns, ["bytes", "path"]);
    let Some((_, Field::Bytes(bytes))) = file.get_column_iter().next() else { panic!("no bytes") };
    assert_eq!(imaging::codec::decode_png(bytes.data()).expect("PNG"), scene::image(0, 3));
}

#[test]
fn tasks_of_v30_declare_their_index_to_pandas() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let dataset = dataset(&[V30]);
    let rows = dataset.rows(V30, "meta/tasks.parquet");
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[1]["task"], Field::Str("lift the square".into()));
    assert_eq!(rows[1]["task_index"], Field::Long(1));
    let file = fs::File::open(dataset.path(V30, "meta/tasks.parquet")).expect("a file");
    let reader = SerializedFileReader::new(file).expect("Parquet");
    let pairs = reader.metadata().file_metadata().key_value_metadata().expect("metadata");
    let pandas = pairs.iter().find(|pair| pair.key == "pandas").and_then(|pair| pair.value.clone());
    let pandas: serde_json::Value = serde_json::from_str(&pandas.expect("pandas")).expect("JSON");
    assert_eq!(pandas["index_columns"], json!(["task"]));
}

#[test]
fn robomimic_layout_is_read_back() {
    let dataset = dataset(&[Format::Robomimic]);
    let file = H5File::open(dataset.path(Format::Robomimic, "dataset.hdf5")).expect("a file");
    let episode = 1;
    let demo = |name: &str| file.dataset(&format!("data/demo_{episode}/{name}")).expect("a dataset");
    let floats = |name: &str| demo(name).read_raw::<f32>().expect("numbers");
    let states = scene::states(episode);
    let actions: Vec<f32> = (0..scene::frames(episode)).flat_map(|t| scene::action(episode, t)).collect();
    assert_eq!(floats("states"), states.as_flattened());
    assert_eq!(floats("action_targets"), actions);
    let servo: Vec<f32> =
        (0..scene::frames(episode)).flat_map(|t| scene::servo_command(episode, t)).collect();
    assert_eq!(floats("servo_commands"), servo);
    // Ranges: -2 to 2 rad, and 0 to 1.
    let scaled: Vec<f32> = actions.chunks_exact(2).flat_map(|a| [a[0] / 2.0, 2.0 * a[1] - 1.0]).collect();
    assert_eq!(floats("actions"), scaled);
    let arm: Vec<f32> = states.iter().map(|state| state[0]).collect();
    assert_eq!(floats("obs/arm"), arm);
    assert_eq!(floats("next_obs/arm")[..arm.len() - 1], arm[1..]);
    assert_eq!(floats("next_obs/arm").last(), arm.last());
    assert_eq!(floats("rewards").iter().sum::<f32>(), 1.0);
    let image = demo("obs/front_image");
    assert_eq!(image.shape(), [states.len(), 64, 96, 3]);
    let pixels = image.read_raw::<u8>().expect("bytes");
    let expected = scene::image(episode, 4);
    let rgb: Vec<u8> = expected.as_rgba().chunks_exact(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
    assert_eq!(pixels[4 * 64 * 96 * 3..][..rgb.len()], rgb);
    let depth_m = scene::depth_m();
    assert_eq!(floats("obs/front_depth")[..depth_m.len()], depth_m);
    let ids = demo("obs/wrist_instance_ids").read_raw::<u32>().expect("ids");
    assert_eq!(ids[..depth_m.len()], scene::instance_ids(episode, 0, 70_000));
    let (positions_m, colors, point_ids) = scene::points(episode, 4);
    let cloud = demo("obs/point_cloud");
    assert_eq!(cloud.shape(), [states.len(), 6, 3]);
    assert_eq!(floats("obs/point_cloud")[4 * 18..][..18], positions_m);
    assert_eq!(demo("obs/point_cloud_colors").read_raw::<u8>().expect("bytes")[4 * 18..][..18], colors);
    assert_eq!(demo("obs/point_cloud_ids").read_raw::<u16>().expect("ids")[4 * 6..][..6], point_ids);
    let failure = file.dataset("data/demo_3/rewards").expect("a dataset").read_raw::<f32>().expect("numbers");
    assert_eq!(failure.iter().sum::<f32>(), 0.0, "episode 3 failed");
}

#[test]
fn plain_files_are_read_back() {
    let dataset = dataset(&[PLAIN]);
    let folder = "episodes/episode_000002";
    let rows = dataset.rows(PLAIN, &format!("{folder}/frames.parquet"));
    assert_eq!(floats(&rows[5]["action"]), scene::action(2, 5));
    // Ids of 32 bits are in the table.
    let ids: Vec<u32> = numbers(&rows[5]["instance_ids.wrist"]).into_iter().map(|id| id as u32).collect();
    assert_eq!(ids, scene::instance_ids(2, 5, 70_000));
    let (positions_m, colors, point_ids) = scene::points(2, 5);
    assert_eq!(floats(&rows[5]["point_cloud"]), positions_m);
    assert_eq!(
        numbers(&rows[5]["point_cloud_colors"]),
        colors.into_iter().map(f64::from).collect::<Vec<_>>()
    );
    assert_eq!(
        numbers(&rows[5]["point_cloud_ids"]),
        point_ids.into_iter().map(f64::from).collect::<Vec<_>>()
    );
    let file = |name: &str| fs::read(dataset.path(PLAIN, &format!("{folder}/{name}"))).expect("a file");
    let image = imaging::codec::decode_png(&file("front/rgb_000005.png")).expect("PNG");
    assert_eq!(image, scene::image(2, 5));
    let gray = |name: &str| image::load_from_memory(&file(name)).expect("PNG").into_luma16().into_raw();
    let ids = gray("front/instance_ids_000005.png");
    assert_eq!(ids.into_iter().map(u32::from).collect::<Vec<_>>(), scene::instance_ids(2, 5, 0));
    let description = dataset.json(PLAIN, "dataset.json");
    assert_eq!(description["total_episodes"], json!(scene::EPISODES));
    assert_eq!(description["state_names"][0], "joint_1_rad");
}

#[test]
fn depth_in_meters_is_exact() {
    let dataset = dataset(&[PLAIN_METERS]);
    let rows = dataset.rows(PLAIN_METERS, "episodes/episode_000000/frames.parquet");
    assert_eq!(floats(&rows[0]["depth_m.front"]), scene::depth_m());
    assert!(!dataset.path(PLAIN_METERS, "episodes/episode_000000/front/depth_mm_000000.png").exists());
}

#[test]
fn card_states_what_is_in_the_dataset() {
    let dataset = dataset(&[V30]);
    let card = dataset.text(V30, "README.md");
    for part in [
        "license: cc0-1.0",
        "5 episodes with 109 frames at 15 frames per second",
        "Seeds are from 1000 to 1004",
        "| success | 4 |",
        "| dropped | 1 |",
        "The square starts 3 pixels further right",
        "| `state` | `gripper_opening_m` | m |",
        "Not in this format: depth, instance ids, points. They are in no format of this dataset.",
        "| tabletopgen-episodes | 0.1.0 |",
        "state[t]` is measured before",
        "of velocity, acceleration and jerk by differences at 15 Hz",
        // From the end of the range, in steps of at most 3.125 rad.
        "| `action` | `joint_1_rad` | 100.0 % | 46.9 % |",
        "| `servo_command` | `joint_1_rad` | 100.0 % |",
    ] {
        assert!(card.contains(part), "the card lacks `{part}`:\n{card}");
    }
}

#[test]
fn card_names_the_formats_that_have_what_another_lacks() {
    let dataset = dataset(&[V30, Format::Robomimic, PLAIN]);
    let lacks = "Not in this format: depth, instance ids, points. They are in `robomimic`, `parquet-png`.";
    assert!(dataset.text(V30, "README.md").contains(lacks));
    let card = dataset.text(PLAIN, "README.md");
    assert!(
        card.contains("RGB 96 x 64, with depth, instance ids") && !card.contains("Not in this"),
        "{card}"
    );
}

#[test]
fn previews_are_where_video_is() {
    let dataset = dataset(&[V30, PLAIN]);
    let preview = "strips/chunk-000/episode_000004.mp4";
    let video = fs::read(dataset.path(V30, preview)).expect("a file");
    assert_eq!(&video[4..8], b"ftyp");
    // The sizes of both cameras side by side, as the track states it: 96 + 96 times 64, in 16.16.
    let stated = [192_u32 << 16, 64 << 16].map(u32::to_be_bytes).concat();
    assert!(video.windows(8).any(|bytes| bytes == stated), "no track of 192 x 64 pixels");
    assert!(!dataset.path(PLAIN, preview).exists(), "no H.264 in a folder that has no video");
    assert!(dataset.text(V30, "README.md").contains("a small video of each episode"));
}

#[test]
fn strips_show_frames_of_every_episode_and_camera() {
    let dataset = dataset(&[V30, PLAIN]);
    for (format, episode) in [(V30, 0), (V30, 4), (PLAIN, 3)] {
        let path = dataset.path(format, &format!("strips/chunk-000/episode_{episode:06}_front.png"));
        let strip = imaging::codec::decode_png(&fs::read(path).expect("a strip")).expect("PNG");
        let first = scene::image(episode, 0);
        assert_eq!((strip.width_px(), strip.height_px()), (8 * first.width_px(), first.height_px()));
        for (x, y) in [(3, 5), (40, 44), (60, 50), (95, 63)] {
            assert_eq!(strip.pixel(x, y), first.pixel(x, y));
        }
    }
    let card = dataset.text(V30, "README.md");
    assert!(card.contains("![episode 3, camera wrist](strips/chunk-000/episode_000003_wrist.png)"), "{card}");
    assert!(!card.contains("![episode 4"), "{card}");
}
