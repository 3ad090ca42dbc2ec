//! A USD package (`.usdz`): a ZIP in which every file lies uncompressed at a multiple of 64 bytes, the root
//! layer first, so that readers use it as it is. Only layers and pictures belong in one.

use std::io::{Cursor, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Where the format wants the content of files to begin.
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
