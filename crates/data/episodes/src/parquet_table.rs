//! Tables in Parquet files: columns with names and values, written as row groups with Snappy.
//!
//! Names are ordinary column names, also with dots and slashes. There are no nulls; only files have fields that permit
//! them, since the library `datasets` knows images by this very type. Equal tables give equal bytes.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use crate::EpisodeError;

/// The values of a column, one after the other; lists have the length `width` in each row.
pub(crate) enum Column {
    Bool(Vec<bool>),
    Int64(Vec<i64>),
    Float(Vec<f32>),
    Double(Vec<f64>),
    Text(Vec<String>),
    FloatList {
        values: Vec<f32>,
        width: usize,
    },
    DoubleList {
        values: Vec<f64>,
        width: usize,
    },
    Int64List {
        values: Vec<i64>,
        width: usize,
    },
    /// Numbers of 32 bits without a sign.
    UnsignedList {
        values: Vec<u32>,
        width: usize,
    },
    TextList {
        values: Vec<String>,
        width: usize,
    },
    /// Lists of lists of lists, shape (`width`, 1, 1): statistics of channels.
    ChannelList {
        values: Vec<f64>,
        width: usize,
    },
    /// Files, each with a name: the form of images of the library `datasets`.
    Files {
        files: Vec<Vec<u8>>,
        names: Vec<String>,
    },
}

/// Columns with names, in order; all have equally many rows.
#[derive(Default)]
pub(crate) struct Table(Vec<(String, Column)>);

impl Table {
    pub fn push(&mut self, name: impl Into<String>, column: Column) {
        self.0.push((name.into(), column));
    }

    fn schema(&self) -> Result<TypePtr, ParquetError> {
        let fields = self.0.iter().map(|(name, column)| column.field(name)).collect::<Result<_, _>>()?;
        Type::group_type_builder("schema").with_fields(fields).build().map(Arc::new)
    }
}

/// A Parquet file that grows by tables with equal columns.
pub(crate) struct ParquetFile {
    path: PathBuf,
    writer: SerializedFileWriter<BufWriter<File>>,
}

impl ParquetFile {
    /// A new file for tables with the columns of `table`. `metadata` is what the file states as key and value.
    pub fn create(path: &Path, table: &Table, metadata: &[(&str, String)]) -> Result<Self, EpisodeError> {
        let file = File::create(path).map_err(|source| EpisodeError::write(path, source))?;
        let pair = |(key, value): &(&str, String)| KeyValue::new((*key).to_owned(), value.clone());
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_key_value_metadata(Some(metadata.iter().map(pair).collect()))
            .build();
        let begin = || SerializedFileWriter::new(BufWriter::new(file), table.schema()?, Arc::new(properties));
        let writer = begin().map_err(|source| EpisodeError::parquet(path, source))?;
        Ok(Self { path: path.to_owned(), writer })
    }

    /// Adds a table as a row group.
    pub fn add(&mut self, table: &Table) -> Result<(), EpisodeError> {
        let mut add = || {
            let mut rows = self.writer.next_row_group()?;
            table.0.iter().try_for_each(|(_, column)| column.write(&mut rows))?;
            rows.close().map(|_| ())
        };
        add().map_err(|source| EpisodeError::parquet(&self.path, source))
    }

    /// The bytes that were written, without the tables at the end.
    pub fn bytes(&self) -> u64 {
        self.writer.bytes_written() as u64
    }

    pub fn finish(self) -> Result<(), EpisodeError> {
        let path = self.path;
        let failed = |source| EpisodeError::parquet(&path, source);
        let buffered = self.writer.into_inner().map_err(failed)?;
        buffered.into_inner().map_err(|error| EpisodeError::write(&path, error.into_error()))?;
        Ok(())
    }
}

/// Writes a file with one table.
pub(crate) fn write_table(
    path: &Path,
    table: &Table,
    metadata: &[(&str, String)],
) -> Result<(), EpisodeError> {
    let mut file = ParquetFile::create(path, table, metadata)?;
    file.add(table)?;
    file.finish()
}

type Rows<'a> = SerializedRowGroupWriter<'a, BufWriter<File>>;

impl Column {
    /// An upper bound of the bytes that the column adds to a file, up to a few hundred.
    pub fn bytes(&self) -> u64 {
        let count = match self {
            Self::Bool(values) => values.len(),
            Self::Int64(values) | Self::Int64List { values, .. } => 8 * values.len(),
            Self::Float(values) | Self::FloatList { values, .. } => 5 * values.len(),
            Self::Double(values) | Self::DoubleList { values, .. } | Self::ChannelList { values, .. } => {
                9 * values.len()
            }
            Self::UnsignedList { values, .. } => 5 * values.len(),
            Self::Text(values) | Self::TextList { values, .. } => {
                values.iter().map(|text| 5 + text.len()).sum()
            }
            Self::Files { files, names } => {
                files.iter().map(|file| 8 + file.len()).sum::<usize>()
                    + names.iter().map(|name| 8 + name.len()).sum::<usize>()
            }
        };
        count as u64
    }

    fn field(&self, name: &str) -> Result<TypePtr, ParquetError> {
        match self {
            Self::Bool(_) => primitive(name, Physical::BOOLEAN, None),
            Self::Int64(_) => primitive(name, Physical::INT64, None),
            Self::Float(_) => primitive(name, Physical::FLOAT, None),
            Self::Double(_) => primitive(name, Physical::DOUBLE, None),
            Self::Text(_) => primitive(name, Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Self::FloatList { .. } => list(name, primitive("element", Physical::FLOAT, None)?),
            Self::DoubleList { .. } => list(name, primitive("element", Physical::DOUBLE, None)?),
            Self::Int64List { .. } => list(name, primitive("element", Physical::INT64, None)?),
            Self::UnsignedList { .. } => {
                let unsigned = LogicalType::integer(32, false);
                list(name, primitive("element", Physical::INT32, Some(unsigned))?)
            }
            Self::TextList { .. } => {
                list(name, primitive("element", Physical::BYTE_ARRAY, Some(LogicalType::String))?)
            }
            Self::ChannelList { .. } => {
                let number = primitive("element", Physical::DOUBLE, None)?;
                list(name, list("element", list("element", number)?)?)
            }
            Self::Files { .. } => Type::group_type_builder(name)
                .with_repetition(Repetition::OPTIONAL)
                .with_fields(vec![
                    field("bytes", Repetition::OPTIONAL, Physical::BYTE_ARRAY, None)?,
                    field("path", Repetition::OPTIONAL, Physical::BYTE_ARRAY, Some(LogicalType::String))?,
                ])
                .build()
                .map(Arc::new),
        }
    }

    fn write(&self, rows: &mut Rows<'_>) -> Result<(), ParquetError> {
        match self {
            Self::Bool(values) => column::<BoolType>(rows, values, None),
            Self::Int64(values) => column::<Int64Type>(rows, values, None),
            Self::Float(values) => column::<FloatType>(rows, values, None),
            Self::Double(values) => column::<DoubleType>(rows, values, None),
            Self::Text(values) => column::<ByteArrayType>(rows, &texts(values), None),
            Self::FloatList { values, width } => column::<FloatType>(rows, values, Some((*width, 1))),
            Self::DoubleList { values, width } => column::<DoubleType>(rows, values, Some((*width, 1))),
            Self::Int64List { values, width } => column::<Int64Type>(rows, values, Some((*width, 1))),
            Self::UnsignedList { values, width } => {
                let bits: Vec<i32> = values.iter().map(|value| value.cast_signed()).collect();
                column::<Int32Type>(rows, &bits, Some((*width, 1)))
            }
            Self::TextList { values, width } => {
                column::<ByteArrayType>(rows, &texts(values), Some((*width, 1)))
            }
            Self::ChannelList { values, width } => column::<DoubleType>(rows, values, Some((*width, 3))),
            Self::Files { files, names } => {
                let files: Vec<ByteArray> = files.iter().map(|file| ByteArray::from(file.clone())).collect();
                // Both the group and the field are there.
                let present = vec![2; files.len()];
                write_column::<ByteArrayType>(rows, &files, Some(&present), None)?;
                write_column::<ByteArrayType>(rows, &texts(names), Some(&present), None)
            }
        }
    }
}

fn primitive(name: &str, physical: Physical, logical: Option<LogicalType>) -> Result<TypePtr, ParquetError> {
    field(name, Repetition::REQUIRED, physical, logical)
}

fn field(
    name: &str,
    repetition: Repetition,
    physical: Physical,
    logical: Option<LogicalType>,
) -> Result<TypePtr, ParquetError> {
    Type::primitive_type_builder(name, physical)
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()
        .map(Arc::new)
}

/// A list as the format wants it: a group, in it a repeated group `list`, in it `element`.
fn list(name: &str, element: TypePtr) -> Result<TypePtr, ParquetError> {
    let repeated = Type::group_type_builder("list")
        .with_repetition(Repetition::REPEATED)
        .with_fields(vec![element])
        .build()?;
    Type::group_type_builder(name)
        .with_repetition(Repetition::REQUIRED)
        .with_converted_type(ConvertedType::LIST)
        .with_logical_type(Some(LogicalType::List))
        .with_fields(vec![Arc::new(repeated)])
        .build()
        .map(Arc::new)
}

/// Writes one column. `list` is the length of its lists and how deep they are; a new row begins at repetition level
/// 0.
fn column<D: DataType>(
    rows: &mut Rows<'_>,
    values: &[D::T],
    list: Option<(usize, i16)>,
) -> Result<(), ParquetError> {
    let levels = list.map(|(width, depth)| {
        let repetition: Vec<i16> = (0..values.len()).map(|i| i16::from(i % width != 0)).collect();
        (vec![depth; values.len()], repetition)
    });
    match &levels {
        Some((definition, repetition)) => write_column::<D>(rows, values, Some(definition), Some(repetition)),
        None => write_column::<D>(rows, values, None, None),
    }
}

fn write_column<D: DataType>(
    rows: &mut Rows<'_>,
    values: &[D::T],
    definition: Option<&[i16]>,
    repetition: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let mut column =
        rows.next_column()?.ok_or_else(|| ParquetError::General("the schema has fewer columns".into()))?;
    column.typed::<D>().write_batch(values, definition, repetition)?;
    column.close()
}

fn texts(values: &[String]) -> Vec<ByteArray> {
    values.iter().map(|text| ByteArray::from(text.as_str())).collect()
}

impl Table {
    /// An upper bound of the bytes that the table adds to a file, without its description of columns.
    pub fn bytes(&self) -> u64 {
        self.0.iter().map(|(_, column)| column.bytes()).sum()
    }
}
