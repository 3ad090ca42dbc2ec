//! Written datasets: their files, rows of Parquet, and JSON.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use episodes::card::DatasetSummary;
use episodes::format::{DepthStorage, Format, ImageStorage};
use episodes::{DatasetAssembler, EpisodeUnit};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::Value;
use tempfile::TempDir;

use crate::scene;

pub const V30: Format = Format::LeRobotV30 { images: ImageStorage::Video };
pub const V30_PNG: Format = Format::LeRobotV30 { images: ImageStorage::Png };
pub const V21: Format = Format::LeRobotV21 { images: ImageStorage::Video };
pub const PLAIN: Format = Format::ParquetAndPng { depth: DepthStorage::PngMillimeters };
pub const PLAIN_METERS: Format = Format::ParquetAndPng { depth: DepthStorage::ParquetMeters };

/// The synthetic dataset in a temporary folder.
pub struct Dataset {
    pub folder: TempDir,
    pub summary: DatasetSummary,
}

impl Dataset {
    pub fn path(&self, format: Format, inside: &str) -> PathBuf {
        self.folder.path().join("set").join(format.folder()).join(inside)
    }

    pub fn json(&self, format: Format, inside: &str) -> Value {
        serde_json::from_str(&self.text(format, inside)).expect("JSON")
    }

    pub fn lines(&self, format: Format, inside: &str) -> Vec<Value> {
        self.text(format, inside).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
    }

    pub fn text(&self, format: Format, inside: &str) -> String {
        fs::read_to_string(self.path(format, inside)).expect("a file")
    }

    pub fn rows(&self, format: Format, inside: &str) -> Vec<BTreeMap<String, Field>> {
        rows(&self.path(format, inside))
    }
}

pub fn dataset(formats: &[Format]) -> Dataset {
    let units = (0..scene::EPISODES).map(|number| scene::unit(number, formats).expect("a unit"));
    dataset_of(units, formats)
}

pub fn dataset_of(units: impl Iterator<Item = EpisodeUnit>, formats: &[Format]) -> Dataset {
    let folder = TempDir::new().expect("a folder");
    let mut dataset = assembler(&folder.path().join("set"), formats);
    units.for_each(|unit| {
        dataset.add(&unit).expect("added");
    });
    let summary = dataset.finish().expect("finished");
    Dataset { folder, summary }
}

pub fn assembler(folder: &Path, formats: &[Format]) -> DatasetAssembler {
    let description = scene::description().expect("a description");
    DatasetAssembler::create(folder, description, formats, scene::card()).expect("a dataset")
}

/// Every file below a folder with its bytes.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            let inside = files(&path);
            found.extend(
                inside
                    .into_iter()
                    .map(|(name, bytes)| (Path::new(path.file_name().expect("a name")).join(name), bytes)),
            );
        } else {
            found.insert(path.file_name().expect("a name").into(), fs::read(&path).expect("bytes"));
        }
    }
    found
}

pub fn rows(path: &Path) -> Vec<BTreeMap<String, Field>> {
    let file = fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let reader = SerializedFileReader::new(file).expect("a Parquet file");
    let row = |row: parquet::errors::Result<parquet::record::Row>| {
        row.expect("a row").into_columns().into_iter().collect()
    };
    reader.get_row_iter(None).expect("rows").map(row).collect()
}

/// The numbers of a field, of lists at any depth.
pub fn numbers(field: &Field) -> Vec<f64> {
    match field {
        Field::Float(value) => vec![f64::from(*value)],
        Field::Double(value) => vec![*value],
        Field::Long(value) => vec![*value as f64],
        Field::UInt(value) => vec![f64::from(*value)],
        Field::ListInternal(list) => list.elements().iter().flat_map(numbers).collect(),
        other => panic!("{other} is no number"),
    }
}

pub fn number(field: &Field) -> f64 {
    numbers(field)[0]
}

/// f32 numbers as the file has them.
pub fn floats(field: &Field) -> Vec<f32> {
    numbers(field).into_iter().map(|number| number as f32).collect()
}
