//! Recordings: ZIP archives of exchanges. Bytes that are no archive are put into one, as an exchange, so that
//! changed text is found without a checksum in the way.
#![no_main]

use std::io::{Cursor, Write};
use std::path::Path;

use libfuzzer_sys::fuzz_target;
use mesh_io::obj_archive::is_archive;
use http_client::cassette::Cassette;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

fuzz_target!(|bytes: &[u8]| {
    let archive = match is_archive(bytes) {
        true => bytes.to_vec(),
        false => archive(bytes),
    };
    let _ = Cassette::replay_archive(Path::new("fuzz.zip"), Cursor::new(archive));
});

fn archive(exchange: &[u8]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let name = format!("{}-0000.json", "0".repeat(64));
    archive.start_file(name, stored).expect("memory takes everything");
    archive.write_all(exchange).expect("memory takes everything");
    archive.finish().expect("memory takes everything").into_inner()
}
