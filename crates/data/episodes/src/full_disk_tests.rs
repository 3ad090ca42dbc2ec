//! Every writer of files says so where the disk is full: `/dev/full` accepts no byte.

use std::path::Path;

use crate::EpisodeError;
use crate::json_lines::JsonLines;
use crate::parquet_table::{Column, Table, write_table};
use crate::part_folder::write_file;
use crate::statistics::spool::Spool;

const FULL: &str = "/dev/full";

fn is_full<T>(result: Result<T, EpisodeError>) {
    let error = result.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(error.contains("the disk is full; free space"), "{error}");
}

#[test]
fn full_disks_are_named_by_every_writer() {
    let path = Path::new(FULL);
    is_full(write_file(path, b"text"));
    is_full(JsonLines::create(path.into()).and_then(|mut lines| {
        lines.add(&serde_json::json!({"a": 1}))?;
        lines.finish()
    }));
    let mut table = Table::default();
    table.push("numbers", Column::Float(vec![1.5; 10_000]));
    is_full(write_table(path, &table, &[]));
    is_full(Spool::create(path.into(), 1).and_then(|mut spool| {
        spool.add(&[1.0])?;
        spool.finish()
    }));
}

#[cfg(feature = "video")]
#[test]
fn full_disks_are_named_by_videos() {
    let path = Path::new(FULL);
    let camera = crate::description::CameraDescription {
        name: "front".into(),
        width_px: 32,
        height_px: 32,
        depth: false,
        instance_ids: None,
    };
    let mut encoder = video::VideoEncoder::new(32, 32, 10.0).expect("an encoder");
    encoder.add(&imaging::Image::filled(32, 32, [9; 4])).expect("encoded");
    is_full(crate::lerobot::rolling_video::write_video(path, &camera, 10, &encoder.into_samples()));
}

#[test]
fn full_disks_are_named_by_hdf5() {
    let write = || -> Result<(), rust_hdf5::Hdf5Error> {
        let file = rust_hdf5::H5File::options().no_locking().create(FULL)?;
        let numbers = file.new_dataset::<f32>().shape([100_000]).create("numbers")?;
        numbers.write_raw(&vec![1.0_f32; 100_000])?;
        drop(numbers);
        file.close()
    };
    is_full(write().map_err(|source| EpisodeError::hdf5(Path::new(FULL), source)));
}
