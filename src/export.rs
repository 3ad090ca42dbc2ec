//! Formats: a finished scene becomes bytes. Pure: the same scene gives the same bytes on any day.

pub mod png;
pub mod gltf;
