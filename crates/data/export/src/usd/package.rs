//! USD packages (`.usdz`): a ZIP of uncompressed files aligned to 64 bytes, with the root layer first. Readers can map
//! the files without unpacking. A package may contain only layers and images.

use std::io::{Cursor, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Alignment of file contents that the format requires.
const ALIGNMENT_BYTES: u16 = 64;

/// The bytes of the package. `files` are paths and contents; the first is the root layer.
pub fn write(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>, ZipError> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .with_alignment(ALIGNMENT_BYTES)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o644);
    let mut package = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, content) in files {
        package.start_file(path.as_str(), options)?;
        package.write_all(content)?;
    }
    Ok(package.finish()?.into_inner())
}
