//! The form of an episode unit in a store.
//!
//! | part | content |
//! | --- | --- |
//! | 8 bytes | `EPISODE4`: the last character is the version |
//! | fields | each a length of 8 bytes, little-endian, and as many bytes |
//! | 32 bytes | SHA-256 of all before |
//!
//! The first field is JSON with description, encodings, header, outcome, frames and cameras. State, action and servo
//! command follow. Each camera has eleven fields; three of point clouds and that of the preview end the unit. A list of
//! byte strings is a field whose content has the form of fields. Numbers are little-endian.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use video::Sample;

use crate::EpisodeError;
use crate::camera_track::CameraTrack;
use crate::episode::{EpisodeHeader, Outcome};
use crate::format::Encodings;
use crate::point_cloud::PointCloudTrack;
use crate::statistics::histogram::ImageHistogram;
use crate::unit::EpisodeUnit;

const MAGIC: &[u8; 8] = b"EPISODE4";
pub(crate) const DIGEST_BYTES: usize = 32;

#[derive(Serialize, Deserialize)]
struct Facts {
    description: String,
    encodings: Encodings,
    header: EpisodeHeader,
    outcome: Outcome,
    frames: usize,
    cameras: usize,
}

pub(crate) fn write(unit: &EpisodeUnit) -> Vec<u8> {
    let facts = Facts {
        description: unit.description.clone(),
        encodings: unit.encodings,
        header: unit.header.clone(),
        outcome: unit.outcome.clone(),
        frames: unit.frames,
        cameras: unit.cameras.len(),
    };
    let mut bytes = MAGIC.to_vec();
    field(&mut bytes, &serde_json::to_vec(&facts).unwrap_or_default());
    field(&mut bytes, &floats(&unit.state));
    field(&mut bytes, &floats(&unit.action));
    field(&mut bytes, &floats(&unit.servo_command));
    for camera in &unit.cameras {
        field(&mut bytes, &floats(&camera.intrinsics));
        field(&mut bytes, &floats(&camera.world_from_camera));
        let counts = camera.histogram.counts();
        field(&mut bytes, &counts.iter().flat_map(|count| count.to_le_bytes()).collect::<Vec<_>>());
        // The first byte says whether the frame can be decoded alone.
        let samples =
            camera.video.iter().map(|sample| [&[u8::from(sample.is_key)], &sample.bytes[..]].concat());
        field(&mut bytes, &list(samples));
        for blobs in [
            &camera.rgb_png,
            &camera.depth_png,
            &camera.ids_png,
            &camera.rgb_zlib,
            &camera.depth_zlib,
            &camera.ids_zlib,
        ] {
            field(&mut bytes, &list(blobs));
        }
        field(&mut bytes, &camera.strip_png);
    }
    unit.points.lists().into_iter().for_each(|streams| field(&mut bytes, &list(streams)));
    field(&mut bytes, &unit.preview_mp4);
    let digest = Sha256::digest(&bytes);
    bytes.extend(digest);
    bytes
}

pub(crate) fn read(bytes: &[u8]) -> Result<EpisodeUnit, EpisodeError> {
    let damaged = |what: &str| EpisodeError::Unit { what: what.to_owned() };
    let (content, digest) =
        bytes.split_last_chunk::<DIGEST_BYTES>().ok_or_else(|| damaged("its bytes are too few"))?;
    let mut rest = content.strip_prefix(MAGIC).ok_or_else(|| damaged("it has another form or version"))?;
    if Sha256::digest(content).as_slice() != digest {
        return Err(damaged("its digest is another: the bytes are damaged"));
    }
    unit(&mut rest)
        .filter(|_| rest.is_empty())
        .ok_or_else(|| damaged("its fields do not have the form of a unit"))
}

fn unit(rest: &mut &[u8]) -> Option<EpisodeUnit> {
    let facts: Facts = serde_json::from_slice(next(rest)?).ok()?;
    let mut numbers = || read_floats(next(rest)?);
    let (state, action, servo_command) = (numbers()?, numbers()?, numbers()?);
    let cameras = (0..facts.cameras).map(|_| camera(rest)).collect::<Option<_>>()?;
    let mut streams = || read_list(next(rest)?);
    let points =
        PointCloudTrack { positions_zlib: streams()?, colors_zlib: streams()?, ids_zlib: streams()? };
    let preview_mp4 = next(rest)?.to_vec();
    Some(EpisodeUnit {
        description: facts.description,
        encodings: facts.encodings,
        header: facts.header,
        outcome: facts.outcome,
        frames: facts.frames,
        state,
        action,
        servo_command,
        cameras,
        points,
        preview_mp4,
    })
}

fn camera(rest: &mut &[u8]) -> Option<CameraTrack> {
    let intrinsics = read_floats(next(rest)?)?;
    let world_from_camera = read_floats(next(rest)?)?;
    let (counts, []) = next(rest)?.as_chunks::<8>() else { return None };
    let histogram =
        ImageHistogram::from_counts(counts.iter().map(|eight| u64::from_le_bytes(*eight)).collect())?;
    let sample = |bytes: Vec<u8>| {
        let (key, bytes) = bytes.split_first()?;
        Some(Sample { bytes: bytes.to_vec(), is_key: *key == 1 })
    };
    let video = read_list(next(rest)?)?.into_iter().map(sample).collect::<Option<_>>()?;
    let mut blobs = || read_list(next(rest)?);
    Some(CameraTrack {
        intrinsics,
        world_from_camera,
        histogram,
        video,
        rgb_png: blobs()?,
        depth_png: blobs()?,
        ids_png: blobs()?,
        rgb_zlib: blobs()?,
        depth_zlib: blobs()?,
        ids_zlib: blobs()?,
        strip_png: next(rest)?.to_vec(),
    })
}

fn field(bytes: &mut Vec<u8>, content: &[u8]) {
    bytes.extend((content.len() as u64).to_le_bytes());
    bytes.extend(content);
}

fn list(items: impl IntoIterator<Item = impl AsRef<[u8]>>) -> Vec<u8> {
    let mut bytes = Vec::new();
    items.into_iter().for_each(|item| field(&mut bytes, item.as_ref()));
    bytes
}

fn next<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (length, after) = rest.split_first_chunk::<8>()?;
    let (content, after) = after.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    *rest = after;
    Some(content)
}

fn read_list(mut content: &[u8]) -> Option<Vec<Vec<u8>>> {
    let mut items = Vec::new();
    while !content.is_empty() {
        items.push(next(&mut content)?.to_vec());
    }
    Some(items)
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn read_floats(bytes: &[u8]) -> Option<Vec<f32>> {
    let (fours, []) = bytes.as_chunks::<4>() else { return None };
    Some(fours.iter().map(|four| f32::from_le_bytes(*four)).collect())
}
