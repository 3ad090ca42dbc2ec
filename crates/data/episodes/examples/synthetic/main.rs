//! Writes synthetic episodes in every format: `cargo run -p tabletopgen-episodes --example synthetic -- OUT`.
//!
//! The judges in `tests/judges/episodes` render the same episodes anew from the formulas in `scene.rs` and compare.

mod scene;

use std::error::Error;
use std::path::Path;

use episodes::DatasetAssembler;
use episodes::format::{DepthStorage, Format, ImageStorage};

/// Every format, as the judges expect them.
const FORMATS: &[Format] = &[
    Format::LeRobotV30 { images: ImageStorage::Video },
    Format::LeRobotV30 { images: ImageStorage::Png },
    Format::LeRobotV21 { images: ImageStorage::Video },
    Format::LeRobotV21 { images: ImageStorage::Png },
    Format::Robomimic,
    Format::ParquetAndPng { depth: DepthStorage::PngMillimeters },
];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: synthetic OUT")?;
    let description = scene::description()?;
    let mut dataset = DatasetAssembler::create(Path::new(&folder), description, FORMATS, scene::card())?;
    for number in 0..scene::EPISODES {
        dataset.add(&scene::unit(number, FORMATS)?)?;
    }
    dataset.finish()?;
    Ok(())
}
