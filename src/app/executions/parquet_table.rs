//! The motion of an execution as a Parquet table: one row a frame.
//!
//! | column | type |
//! | --- | --- |
//! | `time_s` | double, seconds |
//! | `phase` | string |
//! | `joint_targets`, `joint_references` | list of doubles, in the order of `joints`; SI |
//! | `joint_positions`, `joint_velocities` | list of doubles, in the order of `joints`; SI |
//! | `gripper_target` | double, position of `gripper_joint`; below 0 where thin objects are pressed |
//! | `opening_target_m` | double, meters between the pads; below 0 as well |
//! | `opening_reference_m`, `opening_m` | double, meters between the pads |
//! | `pose.NAME` for each object | list of 7 doubles: x, y, z in meters, quaternion x, y, z, w; world frame |
//!
//! The metadata of the file has `joints`, `gripper_joint`, `objects` and `rate_hz` as JSON.

use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use serde_json::json;

use geometry::Pose;
use manipulation::execution::{Frame, Recording};

type Rows<'a> = SerializedRowGroupWriter<'a, Vec<u8>>;

/// The bytes of the file. Equal records give equal bytes.
///
/// # Errors
///
/// Those of the writer, which memory does not give.
pub fn parquet_table(recording: &Recording) -> Result<Vec<u8>, ParquetError> {
    let list = |name: &str| {
        format!("required group {name} (LIST) {{ repeated group list {{ required double element; }} }}\n")
    };
    let mut schema =
        "message execution {\nrequired double time_s;\nrequired binary phase (STRING);\n".to_owned();
    let of_joints = ["joint_targets", "joint_references", "joint_positions", "joint_velocities"];
    schema += &of_joints.map(list).concat();
    let of_gripper = ["gripper_target", "opening_target_m", "opening_reference_m", "opening_m"];
    schema += &of_gripper.map(|name| format!("required double {name};\n")).concat();
    schema += &recording.objects.iter().map(|name| list(&format!("pose.{name}"))).collect::<String>();
    schema.push('}');
    let meta = |key: &str, value: serde_json::Value| KeyValue::new(key.to_owned(), value.to_string());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(vec![
            meta("joints", json!(recording.joints)),
            meta("gripper_joint", json!(recording.gripper_joint)),
            meta("objects", json!(recording.objects)),
            meta("rate_hz", json!(recording.rate_hz)),
        ]))
        .build();
    let schema = Arc::new(parse_message_type(&schema)?);
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut rows = writer.next_row_group()?;
    let frames = &recording.frames;
    // In the order of the schema.
    numbers(&mut rows, frames, |frame| frame.time_s)?;
    phases(&mut rows, frames)?;
    lists(&mut rows, frames, |frame| frame.joint_targets.clone())?;
    lists(&mut rows, frames, |frame| frame.joint_references.clone())?;
    lists(&mut rows, frames, |frame| frame.joint_positions.clone())?;
    lists(&mut rows, frames, |frame| frame.joint_velocities.clone())?;
    numbers(&mut rows, frames, |frame| frame.gripper_target)?;
    numbers(&mut rows, frames, |frame| frame.opening_target_m)?;
    numbers(&mut rows, frames, |frame| frame.opening_reference_m)?;
    numbers(&mut rows, frames, |frame| frame.opening_m)?;
    for object in 0..recording.objects.len() {
        lists(&mut rows, frames, |frame| numbers_of(&frame.object_poses[object]).to_vec())?;
    }
    rows.close()?;
    writer.into_inner()
}

fn numbers_of(pose: &Pose) -> [f64; 7] {
    let (at, turn) = (pose.translation_m, pose.rotation);
    [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w]
}

fn numbers(rows: &mut Rows, frames: &[Frame], value: impl Fn(&Frame) -> f64) -> Result<(), ParquetError> {
    let values: Vec<f64> = frames.iter().map(value).collect();
    column(rows, |column| column.typed::<DoubleType>().write_batch(&values, None, None))
}

fn phases(rows: &mut Rows, frames: &[Frame]) -> Result<(), ParquetError> {
    let name = |frame: &Frame| ByteArray::from(json!(frame.phase).as_str().unwrap_or_default());
    let values: Vec<ByteArray> = frames.iter().map(name).collect();
    column(rows, |column| column.typed::<ByteArrayType>().write_batch(&values, None, None))
}

/// A list for each frame; none is empty.
fn lists(rows: &mut Rows, frames: &[Frame], value: impl Fn(&Frame) -> Vec<f64>) -> Result<(), ParquetError> {
    let (mut values, mut repetition) = (Vec::new(), Vec::new());
    for frame in frames {
        let list = value(frame);
        // A new row begins where the level is 0.
        repetition.extend((0..list.len()).map(|k| i16::from(k > 0)));
        values.extend(list);
    }
    let definition = vec![1; values.len()];
    column(rows, |column| {
        column.typed::<DoubleType>().write_batch(&values, Some(&definition), Some(&repetition))
    })
}

fn column(
    rows: &mut Rows,
    write: impl FnOnce(&mut parquet::file::writer::SerializedColumnWriter) -> Result<usize, ParquetError>,
) -> Result<(), ParquetError> {
    if let Some(mut column) = rows.next_column()? {
        write(&mut column)?;
        column.close()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;
    use glam::DVec3;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    use super::*;
    use manipulation::execution::Phase;

    fn recording() -> Recording {
        let frame = |number: u32| {
            let time_s = 0.02 * f64::from(number);
            Frame {
                time_s,
                phase: if number < 2 { Phase::Transit } else { Phase::Close },
                joint_targets: vec![time_s, 1.0],
                joint_references: vec![time_s, 1.1],
                joint_positions: vec![0.5, -time_s],
                joint_velocities: vec![0.0, 0.1],
                opening_target_m: 0.08,
                opening_reference_m: 0.075,
                opening_m: 0.07,
                gripper_target: 0.04,
                object_poses: vec![Pose::upright(DVec3::new(0.1, 0.2, time_s), 0.0)],
            }
        };
        Recording {
            rate_hz: 50.0,
            joints: vec!["a".into(), "b".into()],
            gripper_joint: "finger".into(),
            objects: vec!["mug_1".into()],
            frames: (0..5).map(frame).collect(),
        }
    }

    #[test]
    fn rows_come_back_as_they_were() {
        let recording = recording();
        let bytes = parquet_table(&recording).expect("written");
        assert_eq!(bytes, parquet_table(&recording).expect("written"), "equal bytes");
        let reader = SerializedFileReader::new(Bytes::from(bytes)).expect("a table");
        let rows: Vec<_> = reader.get_row_iter(None).expect("rows").map(|row| row.expect("a row")).collect();
        assert_eq!(rows.len(), recording.frames.len());
        for (row, frame) in rows.iter().zip(&recording.frames) {
            assert_eq!(row.get_double(0).expect("time"), frame.time_s);
            assert_eq!(row.get_string(1).expect("phase"), json!(frame.phase).as_str().expect("a name"));
            let list = |column: usize| -> Vec<f64> {
                let list = row.get_list(column).expect("a list");
                use parquet::record::ListAccessor;
                (0..list.len()).map(|k| list.get_double(k).expect("a number")).collect()
            };
            assert_eq!(list(2), frame.joint_targets);
            assert_eq!(list(3), frame.joint_references);
            assert_eq!(list(4), frame.joint_positions);
            assert_eq!(row.get_double(8).expect("an opening"), frame.opening_reference_m);
            assert_eq!(list(10), numbers_of(&frame.object_poses[0]));
        }
        let keys = reader.metadata().file_metadata().key_value_metadata().expect("metadata");
        let joints = keys.iter().find(|pair| pair.key == "joints").and_then(|pair| pair.value.clone());
        assert_eq!(joints.as_deref(), Some(r#"["a","b"]"#));
    }
}
