//! ZIP archives of OBJ files; bytes that are no archive are put into one, as an OBJ file and, after a 0, its
//! MTL file, so that changed lines are found without a checksum in the way.
#![no_main]

use std::io::{Cursor, Write};

use libfuzzer_sys::fuzz_target;
use mesh_io::obj_archive::{is_archive, read_mesh_obj_archive};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

fuzz_target!(|bytes: &[u8]| {
    let read = match is_archive(bytes) {
        true => read_mesh_obj_archive(bytes),
        false => read_mesh_obj_archive(&archive(bytes)),
    };
    if let Ok(mesh) = read {
        let _ = (mesh.size_m(), mesh.triangle_count(), mesh.bounds());
    }
});

fn archive(bytes: &[u8]) -> Vec<u8> {
    let mut parts = bytes.splitn(2, |byte| *byte == 0);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for name in ["thing.obj", "thing.mtl"] {
        archive.start_file(name, stored).expect("memory takes everything");
        archive.write_all(parts.next().unwrap_or_default()).expect("memory takes everything");
    }
    archive.finish().expect("memory takes everything").into_inner()
}
